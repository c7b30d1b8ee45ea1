"""Equations of motion of the indexing drive's torsion in the cam angle, linearised about the rigid motion, and their
exact rest.

    M q.. + C q. + K q = f,  g = theta2 - tau' theta1 the contact elongation, g. its rate tau'' omega in theta1:
    K = K0 + K12 g g^T + C12 g g.^T,   C = C0 + C12 g g^T,
    f = -(J1 theta.. + Cf1 omega, J2 tau.. + Cf2 tau., J3 tau..)

with tau. = tau' omega, tau.. = tau'' omega^2 + tau' theta... The coordinates are angles in rad, time derivatives become
derivatives in the cam angle by q. = omega q', q.. = omega^2 q'' + omega omega' q'.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from camgeom.dynamics.indexing.drive import TORSION, IndexingDrive
from camgeom.dynamics.linear.method import Coefficients, Motion, Side, Split
from camgeom.dynamics.linear.response import Response, positive_speeds
from camgeom.dynamics.linear.solve import acceleration
from camgeom.errors import Problem, ProfileError
from camgeom.maths import Floats


@dataclass(frozen=True)
class Fluctuation:
    """Periodic variation of the input speed: omega = mean (1 + sum share cos(order theta + phase)), phase in rad."""

    harmonics: tuple[tuple[int, float, float], ...] = ()

    def __post_init__(self) -> None:
        total = sum(abs(share) for _, share, _ in self.harmonics)
        if total >= 0.9 or any(order < 1 for order, _, _ in self.harmonics):
            raise ProfileError(
                [Problem("dynamics.speed_fluctuation", "orders from 1, shares below 0.9 in sum", self.harmonics)]
            )

    def at(self, theta: Floats) -> tuple[Floats, Floats]:
        """omega/mean and its derivative in the cam angle, both without unit, at cam angles theta (rad)."""
        factor, slope = np.ones_like(theta), np.zeros_like(theta)
        for order, share, phase in self.harmonics:
            factor += share * np.cos(order * theta + phase)
            slope -= order * share * np.sin(order * theta + phase)
        return factor, slope


OUTPUTS: Mapping[str, str] = MappingProxyType(
    {
        "cam_windup": "rad, q1: cam behind its rigid position",
        "turret_deviation": "rad, q2: turret from its rigid position",
        "load_deviation": "rad, q3: load plate from its rigid position",
        "cam_acceleration": "rad/s2 of the cam",
        "turret_acceleration": "rad/s2 of the turret",
        "load_acceleration": "rad/s2 of the load plate",
        "contact_torque": "N m between cam and turret, at the turret, positive when the cam holds the turret back",
        "output_torque": "N m in the output shaft",
        "input_torque": "N m in the input shaft, positive when it drives the cam",
    }
)
"""The outputs of an indexing drive by name, with unit and meaning."""
DEVIATIONS = tuple(OUTPUTS)[:3]
ACCELERATIONS = tuple(OUTPUTS)[3:6]
SEEN = 12
"""jets of the motion kept: the same cam angles are asked for by the equation of motion, its check and its outputs"""
SAME = 1e-9
"""share of a table's step within which a node is a knot of the motion"""
Torque = Callable[[Floats, Side], Floats]
"""External torque (1, n, 3) in N m on cam, turret and load plate over cam angles (1, n)."""


@dataclass(frozen=True, eq=False)
class TorsionSystem:
    """The three torsional coordinates of the drive at mean input speeds `speed` (b,) in rad/s.

    torque adds an external load; exact keeps the contact non-linear in the cam's windup, tau(theta + q1) instead of
    tau + tau' q1; paper_form drops tau'^2 K12 (comparison only).
    """

    drive: IndexingDrive
    motion: Motion
    speed: Floats
    fluctuation: Fluctuation = Fluctuation()
    torque: Torque | None = None
    exact: bool = False
    paper_form: bool = False
    mass: Floats = field(init=False, repr=False)
    _fixed: tuple[Floats, Floats] = field(init=False, repr=False)
    _seen: dict[tuple[bytes, tuple[int, ...], Side], Floats] = field(init=False, repr=False, default_factory=dict)

    def __post_init__(self) -> None:
        d = self.drive
        object.__setattr__(self, "speed", positive_speeds(self.speed))
        object.__setattr__(self, "mass", np.array([d.cam_inertia, d.turret_inertia, d.load_inertia]))
        fixed = (d.matrix(d.spring_terms(), TORSION), d.matrix(d.damping_terms(), TORSION))
        object.__setattr__(self, "_fixed", fixed)

    @property
    def size(self) -> int:
        """Three coordinates."""
        return 3

    @property
    def batch(self) -> int:
        """Number of speeds."""
        return len(self.speed)

    @property
    def linear(self) -> bool:
        """Whether the contact is linearised about the rigid motion."""
        return not self.exact

    @property
    def outputs(self) -> Mapping[str, str]:
        """`OUTPUTS`."""
        return OUTPUTS

    @property
    def judged(self) -> str:
        """The acceleration of the load plate, which an indexing drive is built for."""
        return "load_acceleration"

    def read(self, name: str, theta: Floats, position: Floats, rate: Floats, side: Side = "right") -> Floats:
        """An output (b, n) of `OUTPUTS` from q and q' (b, n, 3) at cam angles theta (1 or b, n)."""
        if name in DEVIATIONS:
            return position[..., DEVIATIONS.index(name)]
        if name in ACCELERATIONS:
            return _acceleration(self, ACCELERATIONS.index(name), theta, position, rate, side)
        return _torque(self, name, theta, position, rate, side)

    @property
    def knots(self) -> Floats:
        """Cam angles in rad at which some derivative jumps: the motion's knots and the nodes of a contact table."""
        own, count = np.asarray(self.motion.knots, dtype=float), len(self.drive.contact_table)
        if not count:
            return own
        step = 2.0 * np.pi / count
        nodes = step * np.arange(np.ceil(own[0] / step), np.floor(own[-1] / step) + 1.0)
        far = np.abs(nodes[:, None] - own).min(1) > SAME * step
        return np.sort(np.concatenate([own, nodes[far]]))

    def exact_contact(self, theta: Floats, q: Floats, u: Floats, side: Side = "right") -> tuple[Floats, Floats]:
        """Contact torque (b, n) in N m at the turret and the slope tau' at the cam's true angle theta + q1."""
        omega, _ = self.rates(theta)
        tau = self.jet(theta, 1, side)
        true = self.jet(theta + q[..., 0], 1, side)
        stretch = q[..., 1] - (true[0] - tau[0])
        rate = omega * (u[..., 1] + tau[1] - true[1] * (1.0 + u[..., 0]))
        return self.drive.contact_stiffness_at(theta) * stretch + self.drive.contact_damping * rate, true[1]

    def correction(self, theta: Floats, position: Floats, rate: Floats, side: Side = "right") -> Floats:
        """Exact less linearised q'' (b, n, 3) per rad^2."""
        q, u = position, rate
        omega, _ = self.rates(theta)
        tau = self.jet(theta, 2, side)
        stretch = q[..., 1] - tau[1] * q[..., 0]
        closing = omega * (u[..., 1] - tau[1] * u[..., 0] - tau[2] * q[..., 0])
        straight = self.drive.contact_stiffness_at(theta) * stretch + self.drive.contact_damping * closing
        torque, slope = self.exact_contact(theta, q, u, side)
        out = np.zeros_like(q)
        out[..., 0] = (slope * torque - tau[1] * straight) / (self.mass[0] * omega**2)
        out[..., 1] = (straight - torque) / (self.mass[1] * omega**2)
        return out

    def rates(self, theta: Floats) -> tuple[Floats, Floats]:
        """Input speed omega (b, n) in rad/s and d omega/d theta at cam angles theta (1 or b, n)."""
        factor, slope = self.fluctuation.at(theta)
        return self.speed[:, None] * factor, self.speed[:, None] * slope

    def coefficients(self, theta: Floats, side: Side = "right") -> Coefficients:
        """D, S, F per rad of cam angle at cam angles theta (1 or b, n), see `System`."""
        tau = self.jet(theta, 2, side)
        omega, slope = self.rates(theta) if self.fluctuation.harmonics else (self.speed[:, None], np.zeros((1, 1)))
        stiff = self.drive.contact_stiffness_at(theta)
        return Coefficients(
            self._damping(tau, omega, slope),
            self._stiffness(tau, omega, stiff),
            self.force(theta, tau, omega, slope, side),
        )

    def split(self, theta: Floats, side: Side = "right") -> Split | None:
        """The same with the contact apart, see `Split`; None at a varying speed or without the contact's tau'^2."""
        if self.fluctuation.harmonics or self.paper_form:
            return None
        tau, omega = self.jet(theta, 2, side), self.speed[:, None]
        along = np.zeros((*tau[1].shape, 3))
        along[..., 0], along[..., 1] = -tau[1], 1.0
        square = (omega**2)[..., None]
        place = self.drive.contact_stiffness_at(theta)[..., None] * along / square
        place[..., 0] -= self.drive.contact_damping * tau[2] / omega
        return Split(
            self._fixed[1] / self.mass[:, None] / omega[..., None],
            self._fixed[0] / self.mass[:, None] / square,
            self._steady_force(theta, tau, omega, side),
            along / self.mass,
            self.drive.contact_damping * along / omega[..., None],
            place,
        )

    def _steady_force(self, theta: Floats, tau: Floats, omega: Floats, side: Side) -> Floats:
        """The force at a constant speed: (1, n, 3) where it is the same for all speeds."""
        d = self.drive
        if d.cam_friction or d.turret_friction or self.torque is not None:
            return self.force(theta, tau, omega, np.zeros((1, 1)), side)
        return np.stack([np.zeros_like(tau[2]), -tau[2], -tau[2]], -1)

    def jet(self, theta: Floats, order: int, side: Side = "right") -> Floats:
        """tau, tau', ... (order + 1, ., n) at cam angles theta (., n)."""
        key = (theta.tobytes(), theta.shape, side)
        found = self._seen.get(key)
        if found is None or len(found) <= order:
            if len(self._seen) >= SEEN:
                self._seen.clear()
            found = self.motion.jet(theta.ravel(), max(order, 2), side).reshape(-1, *theta.shape)
            self._seen[key] = found
        return found[: order + 1]

    def _damping(self, tau: Floats, omega: Floats, slope: Floats) -> Floats:
        """M^-1 C/omega + omega'/omega."""
        c12 = self.drive.contact_damping
        one = np.ones_like(tau[1])
        # rows of the symmetric contact dyad g g^T, g = (-tau', 1, 0)
        out = _entries(self._fixed[1], c12 * tau[1] ** 2, -c12 * tau[1], -c12 * tau[1], c12 * one)
        out = out / self.mass[:, None] / omega[..., None, None]
        if slope.any():
            out = out + (slope / omega)[..., None, None] * np.eye(3)
        return np.asarray(out)

    def _stiffness(self, tau: Floats, omega: Floats, stiff: Floats) -> Floats:
        """M^-1 K/omega^2 with the rate of the contact direction in the damper."""
        rate = self.drive.contact_damping * tau[2] * omega
        corner = 0.0 if self.paper_form else stiff * tau[1] ** 2
        out = _entries(self._fixed[0], corner + tau[1] * rate, -stiff * tau[1], -stiff * tau[1] - rate, stiff)
        return np.asarray(out / self.mass[:, None] / (omega**2)[..., None, None])

    def force(self, theta: Floats, tau: Floats, omega: Floats, slope: Floats, side: Side = "right") -> Floats:
        """M^-1 f/omega^2 (b, n, 3)."""
        d = self.drive
        j1, j2, _ = self.mass
        change = slope / omega
        plate = -tau[2] - tau[1] * change
        cam = -change - (d.cam_friction / j1) / omega
        turret = plate - (d.turret_friction / j2) * tau[1] / omega
        cam, turret, plate = np.broadcast_arrays(cam, turret, plate)
        out = np.stack([cam, turret, plate], -1)
        if self.torque is not None:
            out = out + self.torque(theta, side) / self.mass / (omega**2)[..., None]
        return np.asarray(out)


DriveResponse = Response[TorsionSystem]


def _entries(fixed: Floats, e11: Floats, e12: Floats, e21: Floats, e22: Floats) -> Floats:
    """fixed (3, 3) plus the entries of the contact, each (b, n): (b, n, 3, 3)."""
    e11, e12, e21, e22 = np.broadcast_arrays(e11, e12, e21, e22)
    out = np.empty((*e11.shape, 3, 3))
    out[...] = fixed
    out[..., 0, 0] += e11
    out[..., 0, 1] += e12
    out[..., 1, 0] += e21
    out[..., 1, 1] += e22
    return out


def _acceleration(system: TorsionSystem, k: int, theta: Floats, q: Floats, u: Floats, side: Side) -> Floats:
    """theta_k.. (b, n) in rad/s2."""
    omega, slope = system.rates(theta)
    bend = acceleration(system, theta, q, u, side)[..., k]
    tau = system.jet(theta, 2, side)
    rigid = (1.0, 0.0) if k == 0 else (tau[1], tau[2])
    return np.asarray(omega**2 * (bend + rigid[1]) + omega * slope * (u[..., k] + rigid[0]))


def _torque(system: TorsionSystem, name: str, theta: Floats, q: Floats, u: Floats, side: Side) -> Floats:
    """Torque (b, n) in N m."""
    d = system.drive
    omega, _ = system.rates(theta)
    if name == "input_torque":
        return np.asarray(-d.input_stiffness * q[..., 0] - d.input_damping * omega * u[..., 0])
    if name == "output_torque":
        return np.asarray(
            d.output_stiffness * (q[..., 2] - q[..., 1]) + d.output_damping * omega * (u[..., 2] - u[..., 1])
        )
    tau = system.jet(theta, 2, side)
    stretch = q[..., 1] - tau[1] * q[..., 0]
    rate = omega * (u[..., 1] - tau[1] * u[..., 0] - tau[2] * q[..., 0])
    if system.exact:
        return system.exact_contact(theta, q, u, side)[0]
    return np.asarray(d.contact_stiffness_at(theta) * stretch + d.contact_damping * rate)
