"""Response of the indexing drive: transient from rest, periodic steady state, sweep over speeds, and what is read
from them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from camgeom.dynamics.indexing.drive import TORSION, IndexingDrive, Motion
from camgeom.dynamics.indexing.system import Fluctuation, Torque, TorsionSystem
from camgeom.dynamics.linear.accuracy import STANDARD, Accuracy, Once, solved
from camgeom.dynamics.linear.method import Side
from camgeom.dynamics.linear.peaks import Output, Peak, peak
from camgeom.dynamics.linear.solve import Solution, acceleration, advance, periodic, transient
from camgeom.errors import DesignError, Problem, ProfileError
from camgeom.maths import Floats

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
"""The outputs of a response by name, with unit and meaning."""


@dataclass(frozen=True, eq=False)
class Response:
    """Motion of the torsional coordinates at one or more input speeds (b,): solution, and outputs computed when
    asked.
    """

    system: TorsionSystem
    solution: Solution

    @property
    def theta(self) -> Floats:
        """Cam angles (n + 1) of the nodes in rad."""
        return self.solution.theta

    @property
    def speed(self) -> Floats:
        """Mean input speeds (b,) in rad/s."""
        return self.system.speed

    def output(self, name: str, side: Side = "right") -> Floats:
        """An output of `OUTPUTS` (b, n + 1) at the nodes; at a knot the limit from the given side."""
        return output(self.system, name)(self.theta[None], self.solution.position, self.solution.rate, side)

    def at(self, theta: npt.ArrayLike, name: str) -> Floats:
        """An output (b, k) at any cam angles (k,) of the solution, rad, by true steps from the nodes."""
        angles = np.atleast_1d(np.asarray(theta, dtype=float))
        index = np.clip(np.searchsorted(self.theta, angles, "right") - 1, 0, len(self.theta) - 2)
        y = np.concatenate([self.solution.position, self.solution.rate], -1)[:, index]
        y = advance(self.system, self.theta[None, index], (angles - self.theta[index])[None], y)
        return output(self.system, name)(angles[None], y[..., :3], y[..., 3:], "right")

    def peak(self, name: str) -> Peak:
        """Extremes of an output between the nodes too, with their cam angles."""
        return peak(self.solution, output(self.system, name))

    def turret_angles(self) -> Floats:
        """Angles (3, b, n + 1) of cam, turret and load plate in rad."""
        tau = self.system.jet(self.theta[None], 0)[0]
        rigid = np.stack([self.theta[None], tau, tau])
        return rigid + np.moveaxis(self.solution.position, -1, 0)

    def rigid_peak(self) -> Floats:
        """Peak (b,) of the rigid turret acceleration in rad/s2 at the mean speed."""
        begin, width = self.theta[:-1], np.diff(self.theta)
        low, high = np.zeros_like(begin), np.ones_like(begin)
        best = float(np.abs(self.system.motion.jet(self.theta[1:], 2, "left")[2]).max())
        for _ in range(6):
            share = low + (high - low) * np.linspace(0.0, 1.0, 17)[:-1, None]
            values = np.abs(self.system.motion.jet(begin + share * width, 2)[2])
            best = max(best, float(values.max()))
            place = share.ravel()[values.argmax(0) * share.shape[1] + np.arange(share.shape[1])]
            reach = (high - low) / 16.0
            low, high = np.maximum(place - reach, 0.0), np.minimum(place + reach, 1.0)
        return np.asarray(self.speed**2 * best)

    def amplification(self) -> Floats:
        """Peak load-plate acceleration over its rigid value (b,), no unit."""
        return np.asarray(self.peak("load_acceleration").magnitude / self.rigid_peak())


def output(system: TorsionSystem, name: str) -> Output:
    """The function that gives an output of `OUTPUTS`; ProfileError names them for any other name."""
    if name not in OUTPUTS:
        raise ProfileError([Problem("dynamics.output", "no such output", name, ", ".join(OUTPUTS))])

    def value(theta: Floats, q: Floats, u: Floats, side: Side) -> Floats:
        if name in ("cam_windup", "turret_deviation", "load_deviation"):
            return q[..., ("cam_windup", "turret_deviation", "load_deviation").index(name)]
        if name.endswith("acceleration"):
            return _acceleration(system, name, theta, q, u, side)
        return _torque(system, name, theta, q, u, side)

    return value


def _acceleration(system: TorsionSystem, name: str, theta: Floats, q: Floats, u: Floats, side: Side) -> Floats:
    """theta_k.. (b, n) in rad/s2."""
    k = ("cam_acceleration", "turret_acceleration", "load_acceleration").index(name)
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


def watch(solution: Solution) -> Floats:
    """What a response must have right: the three deviations and the load-plate acceleration, (b, n + 1, 4)."""
    system = solution.system
    if not isinstance(system, TorsionSystem):
        raise TypeError("an indexing response watches a torsion system")
    load = output(system, "load_acceleration")(solution.theta[None], solution.position, solution.rate, "right")
    return np.concatenate([solution.position, load[..., None]], -1)


CONSTANT = Fluctuation()


def steady_state(
    drive: IndexingDrive,
    motion: Motion,
    speed: npt.ArrayLike,
    accuracy: Accuracy = STANDARD,
    fluctuation: Fluctuation = CONSTANT,
    torque: Torque | None = None,
    exact: bool = False,
    paper_form: bool = False,
) -> Response:
    """Periodic steady state at input speeds (b,) in rad/s, one method and step for all of them.

    Raises DesignError for a torsion that is not definite, NotConverged for a resonance without damping, a growing
    turn or a tolerance out of reach.
    """
    system = TorsionSystem(drive, motion, np.atleast_1d(speed), fluctuation, torque, exact, paper_form)
    refuse_indefinite(drive, motion)
    return Response(system, _solve(system, accuracy, lambda grid, method: periodic(system, grid, method)))


def from_rest(
    drive: IndexingDrive,
    motion: Motion,
    speed: npt.ArrayLike,
    turns: int = 1,
    accuracy: Accuracy = STANDARD,
    fluctuation: Fluctuation = CONSTANT,
    torque: Torque | None = None,
    begin: npt.ArrayLike | None = None,
    exact: bool = False,
    paper_form: bool = False,
) -> Response:
    """Transient over `turns` turns from rest at the first cam angle (or from begin (b, 6): deviations, rad, and
    rates, rad/s).
    """
    system = TorsionSystem(drive, motion, np.atleast_1d(speed), fluctuation, torque, exact, paper_form)
    refuse_indefinite(drive, motion)
    state = None
    if begin is not None:
        state = np.broadcast_to(np.asarray(begin, dtype=float), (system.batch, 6)).copy()
        state[:, 3:] /= system.rates(np.array([[motion.knots[0]]]))[0]
    return Response(
        system, _solve(system, accuracy, lambda grid, method: transient(system, grid, method, state, turns))
    )


def _solve(system: TorsionSystem, accuracy: Accuracy, once: Once) -> Solution:
    return solved(system, system.knots, accuracy, once, watch)


def refuse_indefinite(drive: IndexingDrive, motion: Motion, blocks: tuple[tuple[str, ...], ...] = (TORSION,)) -> None:
    """DesignError when one of the blocks to be integrated has no definite stiffness, naming what would do."""
    wrong = [item for item in drive.indefinite(motion) if item.block in blocks]
    if wrong:
        raise DesignError("; ".join(str(item) for item in wrong) + "; it is not integrated")
