"""The fixed-step method of the conjugate-cam paper, for many clearances at once: classical RK4, late latch (SI units).

For comparison with the event solver. The approach speed is latched at the first step that finds the roller inside the
cam, up to one step late, so the method converges with order 1 only, whatever the order of its formula; with free play
of 1 mm its trajectory at the paper's 1e-5 s is not a converged one, though its peaks are good to about 0.1 %.
Source: doi 10.3969/j.issn.1671-024x.2025.05.013, section 3.1.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from camgeom.dynamics.impact.laws import ImpactDamping
from camgeom.dynamics.impact.pair import FaceSide, PairSide, Roller
from camgeom.dynamics.impact.problem import ImpactProblem
from camgeom.errors import Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import Floats


@final
@immutable
class FixedRun:
    """The outcome at every step, one column a clearance: time [s], deviation, speed and acceleration, forces [N]."""

    time: Floats
    deviation: Floats
    rate: Floats
    acceleration: Floats
    force_main: Floats
    force_return: Floats

    def peaks(self) -> Floats:
        """Largest magnitude of the follower's acceleration [m/s^2 or rad/s^2], one a clearance."""
        peaks: Floats = np.abs(self.acceleration).max(axis=0)
        return peaks


def solve_fixed(
    problem: ImpactProblem, clearances: Sequence[float], *, end_angle: float, step: float = 1e-5
) -> FixedRun:
    """Solve from cam angle 0 to `end_angle` [rad] with a fixed step [s] for all clearances [m] together.

    Starts in the middle of the play with the follower at rest. No friction, load or spin, as in the paper; raises
    ProfileError where the problem asks for them.
    """
    if problem.friction or problem.spin or problem.load.acts or not isinstance(problem.damping, ImpactDamping):
        message = "the fixed-step method has the hybrid damping only, without friction, load or roller spin"
        raise ProfileError([Problem("method", message, None, "the event solver")])
    return _Fixed(problem, tuple(clearances)).run(end_angle, step)


class _Fixed:
    """The walk; its latches are the only state beside the state."""

    def __init__(self, problem: ImpactProblem, clearances: tuple[float, ...]) -> None:
        pairs = [problem.pair.with_clearance(c) for c in clearances]
        self.problem, self.lift = problem, problem.pair.lift
        self.sides = tuple(_stacked([pair.sides[k] for pair in pairs]) for k in (0, 1))
        slope = float(self.lift.many(0.0, 1)[1, 0])
        self.start = np.array([complex(pair.middle(0.0), -slope * problem.speed) for pair in pairs])
        self.latch = np.zeros((2, len(pairs)))

    def run(self, end_angle: float, step: float) -> FixedRun:
        w = self.problem.speed
        count = max(1, math.ceil(end_angle / w / step - 1e-9))
        y = self.start
        rows = []
        for k in range(count + 1):
            t = k * step
            self._latch(t, y)
            k1, forces = self._rate(t, y)
            rows.append((t, y, k1.imag + self.lift.many(w * t, 2)[2] * w * w, *forces))
            k2, _ = self._rate(t + 0.5 * step, y + 0.5 * step * k1)
            k3, _ = self._rate(t + 0.5 * step, y + 0.5 * step * k2)
            k4, _ = self._rate(t + step, y + step * k3)
            y = y + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        states = np.array([row[1] for row in rows])
        columns = [np.array([row[j] for row in rows]) for j in (0, 2, 3, 4)]
        return FixedRun(columns[0], states.real, states.imag, columns[1], columns[2], columns[3])

    def _touch(self, which: int, t: float, y: NDArray[np.complex128]) -> tuple[NDArray[np.intp], Any]:
        """The clearances whose side is in reach, and their contact there."""
        side, eta = self.sides[which], y.real
        limit = side.limit
        reach = None if limit is None else (eta < limit if which == 0 else eta > limit)
        on = np.arange(eta.size) if reach is None else np.flatnonzero(reach)
        if not on.size:
            return on, None
        angle = np.full(on.size, self.problem.speed * t)
        return on, _picked(side, on).many(self.lift, angle, eta[on])

    def _sinking(self, t: float, y: NDArray[np.complex128], on: NDArray[np.intp], touch: Any) -> Floats:
        w = self.problem.speed
        slope = self.lift.many(w * t, 1)[1]
        sinking: Floats = touch[2] * w - touch[1] * (slope * w + y.imag[on])
        return sinking

    def _latch(self, t: float, y: NDArray[np.complex128]) -> None:
        floor = self._floor()
        for which in (0, 1):
            on, touch = self._touch(which, t, y)
            seen = np.zeros(y.size)
            if on.size:
                speed = np.maximum(self._sinking(t, y, on, touch), floor)
                seen[on] = np.where(
                    touch[0] > 0.0, np.where(self.latch[which, on] > 0.0, self.latch[which, on], speed), 0
                )
            self.latch[which] = seen

    def _floor(self) -> float:
        damping = self.problem.damping
        return damping.speed_floor if isinstance(damping, ImpactDamping) else 0.0

    def _rate(self, t: float, y: NDArray[np.complex128]) -> tuple[NDArray[np.complex128], list[Floats]]:
        problem, w = self.problem, self.problem.speed
        factor = problem.damping.factor if isinstance(problem.damping, ImpactDamping) else 0.0
        torque, forces = np.zeros(y.size), []
        for which in (0, 1):
            on, touch = self._touch(which, t, y)
            force = np.zeros(y.size)
            if on.size:
                inside = touch[0] > 0.0
                sinking = self._sinking(t, y, on, touch)
                latch = self.latch[which, on]
                approach = np.where(latch > 0.0, latch, np.maximum(sinking, self._floor()))
                elastic = problem.law.force_many(np.maximum(touch[0], 0.0), touch[5])
                force[on] = np.where(inside, np.maximum(elastic * (1.0 + factor * sinking / approach), 0.0), 0.0)
                torque[on] += force[on] * touch[1]
            forces.append(force)
        second = self.lift.many(w * t, 2)[2]
        return y.imag + 1j * (torque / problem.inertia - second * w * w), forces


def _stacked(sides: list[PairSide]) -> Any:
    """Sides that differ in their clearance alone as one side whose numbers are arrays."""
    first = sides[0]
    if isinstance(first, Roller):
        rollers = [side for side in sides if isinstance(side, Roller)]
        begins: Any = None if first.begins is None else np.array([side.begins for side in rollers])
        shifts: Any = np.array([side.shift for side in rollers])
        gaps: Any = np.array([side.gap for side in rollers])
        return replace(first, shift=shifts, gap=gaps, begins=begins)
    if isinstance(first, FaceSide):
        gaps = np.array([side.gap for side in sides if isinstance(side, FaceSide)])
        return replace(first, gap=gaps)
    raise ProfileError([Problem("method", "the fixed-step method knows rollers and frames", None, "the event solver")])


def _picked(side: Any, on: NDArray[np.intp]) -> Any:
    """The stacked side of some of the clearances."""
    if isinstance(side, Roller):
        shift: Any = side.shift
        side = replace(side, shift=shift[on], begins=None)
    gap: Any = side.gap
    return replace(side, gap=gap[on])
