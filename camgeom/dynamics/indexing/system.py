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
from dataclasses import field
from types import MappingProxyType

import numpy as np

from camgeom.dynamics.indexing.drive import TORSION, IndexingDrive
from camgeom.dynamics.linear.method import Coefficients, Correction, DrivenMotion, Side, VaryingContact
from camgeom.dynamics.linear.response import Response, positive_speeds
from camgeom.dynamics.linear.solve import acceleration
from camgeom.errors import Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property


@immutable(eq=True)
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
        "turret_velocity": "rad/s of the turret",
        "load_velocity": "rad/s of the load plate",
        "contact_torque": "N m between cam and turret, at the turret, positive when the cam holds the turret back",
        "output_torque": "N m in the output shaft",
        "input_torque": "N m in the input shaft, positive when it drives the cam",
    }
)
"""The outputs of an indexing drive by name, with unit and meaning."""
DEVIATIONS = tuple(OUTPUTS)[:3]
ACCELERATIONS = tuple(OUTPUTS)[3:6]
VELOCITIES = tuple(OUTPUTS)[6:8]
SEEN = 12
"""jets of the motion kept: the same cam angles are asked for by the equation of motion, its check and its outputs"""
SAME = 1e-9
"""share of a table's step within which a node is a knot of the motion"""
Torque = Callable[[Floats, Side], Floats]
"""External torque (1, n, 3) in N m on cam, turret and load plate over cam angles (1, n)."""


@immutable
class TorsionSystem:
    """The three torsional coordinates of the drive at mean input speeds `speed` (b,) in rad/s.

    torque adds an external load; exact keeps the contact non-linear in the cam's windup, tau(theta + q1) instead of
    tau + tau' q1.
    """

    drive: IndexingDrive
    motion: DrivenMotion
    speed: Floats
    fluctuation: Fluctuation = Fluctuation()
    torque: Torque | None = None
    exact: bool = False
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
        if name in VELOCITIES:
            swings = rate[..., 1 + VELOCITIES.index(name)] + self.jet(theta, 1, side)[1]
            return np.asarray(self.rates(theta)[0] * swings)
        return _torque(self, name, theta, position, rate, side)

    @cached_property
    def knots(self) -> Floats:
        """Cam angles in rad at which some derivative jumps: the motion's knots and the nodes of a contact table."""
        own, count = np.asarray(self.motion.knots, dtype=float), len(self.drive.contact_table)
        if not count:
            return own
        step = 2.0 * np.pi / count
        nodes = step * np.arange(np.ceil(own[0] / step), np.floor(own[-1] / step) + 1.0)
        far = np.abs(nodes[:, None] - own).min(1) > SAME * step
        return np.sort(np.concatenate([own, nodes[far]]))

    def linear_contact(self, theta: Floats, q: Floats, u: Floats, tau: Floats) -> Floats:
        """Contact torque (b, n) in N m by the motion's jet tau (3, ...) at the cam angle of a cam that is not wound up.
        """
        stretch = q[..., 1] - tau[1] * q[..., 0]
        rate = self.rates(theta)[0] * (u[..., 1] - tau[1] * u[..., 0] - tau[2] * q[..., 0])
        return np.asarray(self.drive.contact_stiffness_at(theta) * stretch + self.drive.contact_damping * rate)

    def exact_contact(
        self, theta: Floats, q: Floats, u: Floats, side: Side = "right", tau: Floats | None = None
    ) -> tuple[Floats, Floats]:
        """Contact torque (b, n) in N m at the turret and the slope tau' at the cam's true angle theta + q1.

        tau   the motion's jet at theta, where it is known
        """
        omega, _ = self.rates(theta)
        tau = self.jet(theta, 1, side) if tau is None else tau
        true = self.jet(theta + q[..., 0], 1, side)
        stretch = q[..., 1] - (true[0] - tau[0])
        rate = omega * (u[..., 1] + tau[1] - true[1] * (1.0 + u[..., 0]))
        return self.drive.contact_stiffness_at(theta) * stretch + self.drive.contact_damping * rate, true[1]

    def correction(self, theta: Floats, side: Side = "right") -> Correction:
        """Exact less linearised q'' (b, n, 3) per rad^2."""
        omega, _ = self.rates(theta)
        tau = self.jet(theta, 2, side)

        def of(q: Floats, u: Floats) -> Floats:
            straight = self.linear_contact(theta, q, u, tau)
            torque, slope = self.exact_contact(theta, q, u, side, tau)
            out = np.zeros_like(q)
            out[..., 0] = (slope * torque - tau[1] * straight) / (self.mass[0] * omega**2)
            out[..., 1] = (straight - torque) / (self.mass[1] * omega**2)
            return out

        return of

    def rates(self, theta: Floats) -> tuple[Floats, Floats]:
        """Input speed omega (b, n) in rad/s and d omega/d theta at cam angles theta (1 or b, n)."""
        factor, slope = self.fluctuation.at(theta)
        return self.speed[:, None] * factor, self.speed[:, None] * slope

    def coefficients(self, theta: Floats, side: Side = "right") -> Coefficients:
        """D, S, F per rad of cam angle at cam angles theta (1 or b, n), see `System`."""
        d, tau = self.drive, self.jet(theta, 2, side)
        omega, change = self.speed[:, None], np.zeros((1, 1))
        springs, dampers = (part / self.mass[:, None] for part in self._fixed)
        damping = dampers / omega[..., None, None]
        if self.fluctuation.harmonics:
            omega, slope = self.rates(theta)
            change = slope / omega
            damping = dampers / omega[..., None, None] + change[..., None, None] * np.eye(3)
        return Coefficients(
            damping,
            springs / (omega**2)[..., None, None],
            self._force(theta, tau, omega, change, side),
            VaryingContact.on_cam(tau[1], tau[2], d.contact_stiffness_at(theta), d.contact_damping, omega, self.mass),
        )

    def _force(self, theta: Floats, tau: Floats, omega: Floats, change: Floats, side: Side) -> Floats:
        """M^-1 f/omega^2 (b, n, 3) with change = omega'/omega; (1, n, 3) where it is the same for all speeds."""
        d = self.drive
        plate = -tau[2] - tau[1] * change
        cam, turret = np.broadcast_to(-change, plate.shape), plate
        if d.cam_friction or d.turret_friction:
            cam = cam - d.cam_friction / self.mass[0] / omega
            turret = turret - d.turret_friction / self.mass[1] * tau[1] / omega
        out = np.stack(np.broadcast_arrays(cam, turret, plate), -1)
        if self.torque is not None:
            out = out + self.torque(theta, side) / self.mass / (omega**2)[..., None]
        return np.asarray(out)

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
    if system.exact:
        return system.exact_contact(theta, q, u, side)[0]
    return system.linear_contact(theta, q, u, system.jet(theta, 2, side))


DriveResponse = Response[TorsionSystem]
