"""Response of an elastic follower: periodic steady state and transient, with contact force, linkage force and shaft
torque. SI.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from camgeom.dynamics.follower.train import CamShaft, FollowerSystem, FollowerTrain, Load, Motion
from camgeom.dynamics.linear.accuracy import STANDARD, Accuracy, Once, solved
from camgeom.dynamics.linear.method import Side
from camgeom.dynamics.linear.peaks import Output, Peak, peak
from camgeom.dynamics.linear.solve import Solution, acceleration, advance, periodic, transient
from camgeom.errors import Problem, ProfileError
from camgeom.maths import Floats

OUTPUTS: Mapping[str, str] = MappingProxyType(
    {
        "deviation": "m, follower mass from its rigid position",
        "position": "m, follower mass",
        "velocity": "m/s of the follower mass",
        "acceleration": "m/s2 of the follower mass",
        "contact_force": "N between cam and follower along the motion, positive when it presses",
        "linkage_force": "N in the linkage, positive when it pushes the follower mass up",
        "cam_torque": "N m on the cam, contact force times ds/dtheta",
        "windup": "rad, cam from its nominal angle",
        "shaft_torque": "N m in the cam shaft, positive when it drives the cam",
    }
)
"""The outputs of a follower response by name, with unit and meaning."""


@dataclass(frozen=True, eq=False)
class FollowerResponse:
    """Motion of an elastic follower at speeds (b,); outputs are computed when asked for."""

    system: FollowerSystem
    solution: Solution

    @property
    def theta(self) -> Floats:
        """Cam angles (n + 1) of the nodes in rad."""
        return self.solution.theta

    def output(self, name: str, side: Side = "right") -> Floats:
        """An output of `OUTPUTS` (b, n + 1) at the nodes; at a knot the limit from the given side."""
        return output(self.system, name)(self.theta[None], self.solution.position, self.solution.rate, side)

    def at(self, theta: npt.ArrayLike, name: str) -> Floats:
        """An output (b, k) at any cam angles (k,) of the solution, rad, by true steps from the nodes."""
        angles = np.atleast_1d(np.asarray(theta, dtype=float))
        index = np.clip(np.searchsorted(self.theta, angles, "right") - 1, 0, len(self.theta) - 2)
        y = np.concatenate([self.solution.position, self.solution.rate], -1)[:, index]
        y = advance(self.system, self.theta[None, index], (angles - self.theta[index])[None], y)
        m = self.system.size
        return output(self.system, name)(angles[None], y[..., :m], y[..., m:], "right")

    def peak(self, name: str) -> Peak:
        """Extremes of an output between the nodes too, with their cam angles."""
        return peak(self.solution, output(self.system, name))


def output(system: FollowerSystem, name: str) -> Output:
    """The function that gives an output of `OUTPUTS`; ProfileError names them for any other name."""
    if name not in OUTPUTS or (name in ("windup", "shaft_torque") and system.shaft is None):
        hint = "give the shaft" if name in OUTPUTS else ""
        raise ProfileError([Problem("dynamics.output", "no such output", name, ", ".join(OUTPUTS), hint)])
    order = {"position": 0, "velocity": 1, "acceleration": 2}

    def value(theta: Floats, q: Floats, u: Floats, side: Side) -> Floats:
        if name == "deviation":
            return q[..., -1]
        if name in order:
            part = (q, u, None)[order[name]]
            own = acceleration(system, theta, q, u, side) if part is None else part
            rigid = system.lift(theta, order[name], side)[order[name]]
            return np.asarray((rigid + own[..., -1]) * system.speed[:, None] ** order[name])
        if name in ("contact_force", "cam_torque"):
            force, slope = system.contact(theta, q, u, side)
            return force if name == "contact_force" else force * slope
        if name == "linkage_force":
            return _linkage(system, theta, q, u, side)
        return _shaft(system, name, q, u)

    return value


def _linkage(system: FollowerSystem, theta: Floats, q: Floats, u: Floats, side: Side) -> Floats:
    """Force (b, n) in N in the linkage."""
    t, w = system.train, system.speed[:, None]
    if t.two_masses:
        return np.asarray(t.stiffness * (q[..., -2] - q[..., -1]) + t.damping * w * (u[..., -2] - u[..., -1]))
    if system.shaft is None:
        return np.asarray(-t.stiffness * q[..., 0] - t.damping * w * u[..., 0])
    return system.contact(theta, q, u, side)[0]


def _shaft(system: FollowerSystem, name: str, q: Floats, u: Floats) -> Floats:
    """Windup (b, n) in rad or shaft torque in N m."""
    if name == "windup" or system.shaft is None:
        return q[..., 0]
    return np.asarray(-system.shaft.stiffness * q[..., 0] - system.shaft.damping * system.speed[:, None] * u[..., 0])


def watch(solution: Solution) -> Floats:
    """What a response must have right: the deviations and the contact force, (b, n + 1, m + 1)."""
    system = solution.system
    if not isinstance(system, FollowerSystem):
        raise TypeError("a follower's response watches a follower's system")
    force = system.contact(solution.theta[None], solution.position, solution.rate)[0]
    return np.concatenate([solution.position, force[..., None]], -1)


def steady_state(
    train: FollowerTrain,
    motion: Motion,
    speed: npt.ArrayLike,
    accuracy: Accuracy = STANDARD,
    scale: float = 1e-3,
    shaft: CamShaft | None = None,
    load: Load | None = None,
) -> FollowerResponse:
    """Periodic steady state at speeds (b,) in rad/s, contact never lost (see `follower_jump` for that).

    Raises NotConverged for a resonance without damping, ProfileError for a motion whose velocity jumps.
    """
    system = FollowerSystem(train, motion, np.atleast_1d(speed), scale, shaft, load)
    return FollowerResponse(system, _solve(system, accuracy, lambda g, m: periodic(system, g, m)))


def from_rest(
    train: FollowerTrain,
    motion: Motion,
    speed: npt.ArrayLike,
    turns: int = 1,
    accuracy: Accuracy = STANDARD,
    scale: float = 1e-3,
    shaft: CamShaft | None = None,
    load: Load | None = None,
) -> FollowerResponse:
    """Transient over `turns` turns from static equilibrium at the first cam angle."""
    system = FollowerSystem(train, motion, np.atleast_1d(speed), scale, shaft, load)
    begin = np.concatenate([equilibrium(system), np.zeros((system.batch, system.size))], -1)
    return FollowerResponse(system, _solve(system, accuracy, lambda grid, m: transient(system, grid, m, begin, turns)))


def equilibrium(system: FollowerSystem) -> Floats:
    """Deviations (b, m) of the follower standing still at the first cam angle under preload, spring and load."""
    theta = np.array([[float(system.motion.knots[0])]])
    slow = FollowerSystem(system.train, system.motion, np.array([1e-9]), system.scale, system.shaft, system.load)
    here = slow.coefficients(theta)
    found = np.linalg.solve(here.stiffness[:, 0], here.force[:, 0, :, None])[..., 0]
    return np.broadcast_to(found, (system.batch, system.size)).copy()


def _solve(system: FollowerSystem, accuracy: Accuracy, once: Once) -> Solution:
    return solved(system, np.asarray(system.motion.knots), accuracy, once, watch)
