"""The solved motion between two contacts and what it tells: peaks, impacts, conversions, energy, wear, cycles (SI)."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple, final

import numpy as np

from camgeom.dynamics.impact.lift import TURN
from camgeom.dynamics.impact.outcome import Energy, Impact, Wear, balance, impacts, wear
from camgeom.dynamics.impact.problem import ImpactProblem, Recorded
from camgeom.dynamics.impact.rates import Machine
from camgeom.dynamics.impact.solver import walk
from camgeom.dynamics.impact.stepper import step
from camgeom.dynamics.impact.trace import SHARES, Trace, evaluate, sampled
from camgeom.maths import Floats

Quantity = Literal["acceleration", "force_main", "force_return", "pressure_main", "pressure_return"]


class Peak(NamedTuple):
    """The largest magnitude of a quantity, its time [s] and cam angle [rad]."""

    value: float
    time: float
    angle: float


@final
@dataclass(frozen=True, eq=False)
class ImpactRun:
    """A solved run; everything else is computed when asked for, once."""

    problem: ImpactProblem
    start_angle: float
    rtol: float
    machine: Machine
    recorded: Recorded

    @cached_property
    def trace(self) -> Trace:
        """Nine points in every step, arrays of shape (steps, 9)."""
        return sampled(self.machine, self.recorded, self.start_angle)

    def state_at(self, times: list[float]) -> list[complex]:
        """Deviation + 1j * its rate at times [s] inside the run, to the accuracy of the solver."""
        return [complex(y) if isinstance(y, complex) else complex(y[0]) for y in map(self._state, times)]

    def place(self, time: float) -> int:
        """The number of the step that holds a time [s]."""
        return min(max(bisect_right(self._starts, time) - 1, 0), len(self._starts) - 1)

    @cached_property
    def _starts(self) -> list[float]:
        return [s.time for s in self.recorded.steps]

    def _state(self, time: float) -> Any:
        record = self.recorded.steps[self.place(time)]
        rate = self.machine.rate(self.recorded.regimes[record.regime])
        return step(rate, record.time, record.state, record.rate, record.powers, time - record.time).state

    def at(self, times: list[float]) -> Trace:
        """The trace at given times [s], to the accuracy of the solver."""
        states = [self._state(t) for t in times]
        spinning = bool(states) and not isinstance(states[0], complex)
        follower = np.array([complex(y[0]) if spinning else y for y in states])
        spins = np.array([complex(y[1]) for y in states]) if spinning else None
        which = np.array([self.recorded.steps[self.place(t)].regime for t in times])
        made = evaluate(self.machine, self.recorded.regimes, which, np.array(times), follower, spins)
        made.angle[:] += self.start_angle
        return made

    def peak(self, quantity: Quantity, since: float = 0.0, until: float = math.inf) -> Peak:
        """The largest magnitude of a quantity between two times [s], refined to the accuracy of the solver."""
        values = np.where((self.trace.time >= since) & (self.trace.time <= until), _pick(self.trace, quantity), 0.0)
        order = np.argsort(values, axis=None)[::-1]
        best = Peak(0.0, since, self.start_angle)
        seen: list[float] = []
        for flat in order[:60]:
            value, time = values.flat[flat], float(self.trace.time.flat[flat])
            if value <= 0.985 * best.value or value == 0.0 or len(seen) >= 4:
                break
            if any(abs(time - other) < 1e-3 * self.problem.period for other in seen):
                continue
            seen.append(time)
            refined = self._refined(quantity, int(flat))
            best = max(best, refined)
        return best

    def _refined(self, quantity: Quantity, flat: int) -> Peak:
        """A sampled peak, refined by a polynomial through exact values on both sides of it within its regime."""
        row, column = divmod(flat, SHARES + 1)
        steps, time = self.recorded.steps, self.trace.time
        regime = steps[row].regime
        low, high = float(time[row, max(column - 1, 0)]), float(time[row, min(column + 1, SHARES)])
        if column == 0 and row and steps[row - 1].regime == regime:
            low = float(time[row - 1, -2])
        if column == SHARES and row + 1 < len(steps) and steps[row + 1].regime == regime:
            high = float(time[row + 1, 1])
        nodes = np.cos(np.pi * (np.arange(7) + 0.5) / 7)
        times = 0.5 * (low + high) + 0.5 * (high - low) * nodes
        found = _pick(self.at([float(t) for t in times]), quantity)
        series = np.polynomial.chebyshev.Chebyshev.fit(nodes, found, 6, domain=[-1, 1])
        roots = series.deriv().roots()
        inside = roots.real[(np.abs(roots.imag) < 1e-6) & (np.abs(roots.real) <= 1.0)]
        places = np.concatenate([inside, [-1.0, 1.0]])
        heights = series(places)
        best = int(np.argmax(heights))
        at = 0.5 * (low + high) + 0.5 * (high - low) * float(places[best])
        return Peak(float(heights[best]), at, self.start_angle + self.problem.speed * at)

    @cached_property
    def impacts(self) -> tuple[Impact, ...]:
        """Every contact, in order."""
        return tuple(impacts(self))

    @property
    def conversions(self) -> tuple[Impact, ...]:
        """The contacts by which the drive passes to the other side."""
        return tuple(hit for hit in self.impacts if hit.converts)

    @cached_property
    def energy(self) -> Energy:
        """The balance of work, kinetic, stored and lost energy over the run."""
        return balance(self)

    @cached_property
    def wear(self) -> tuple[Wear, Wear]:
        """Wear indicators of the main and the return side over the run."""
        return wear(self)

    @cached_property
    def jerk(self) -> tuple[float, float]:
        """Largest and root-mean-square jerk of the follower [m/s^3 or rad/s^3], by differences inside every step.

        The part that is heard: the rms jerk grows with the share of impacts in the motion.
        """
        lengths = np.array([s.length for s in self.recorded.steps])
        # Steps cut short by an event are left out: the difference of their accelerations is rounding.
        kept = lengths > 1e-7 * self.problem.period
        lengths = lengths[kept] / SHARES
        slope = np.diff(self.trace.acceleration[kept], axis=1) / lengths[:, None]
        mean = float((slope**2 * lengths[:, None]).sum() / (SHARES * lengths.sum()))
        return float(np.abs(slope).max()), math.sqrt(mean)

    def turn_times(self) -> list[tuple[float, float]]:
        """Start and end [s] of every whole turn of the run."""
        count = int((self.recorded.time * self.problem.speed) / TURN + 1e-9)
        return [(k * self.problem.period, (k + 1) * self.problem.period) for k in range(count)]


def solve(
    problem: ImpactProblem,
    *,
    start_angle: float = 0.0,
    end_angle: float | None = None,
    turns: float = 1.0,
    start: tuple[float, float] | None = None,
    rtol: float = 1e-9,
) -> ImpactRun:
    """Solve the contact problem from a cam angle [rad] to another, or over a number of turns.

    `start` is the deviation and its rate [m, m/s or rad, rad/s]; by default the follower rests in the middle of the
    play. `rtol` is relative to the play plus the static deflection, and to the larger of the free-flight speed and the
    speed at hand. Raises NotConverged, ProfileError.
    """
    end = start_angle + TURN * turns if end_angle is None else end_angle
    machine, recorded = walk(problem, start_angle, end, start, rtol)
    return ImpactRun(problem, start_angle, rtol, machine, recorded)


def _pick(trace: Trace, quantity: Quantity) -> Floats:
    if quantity == "acceleration":
        return np.abs(trace.acceleration)
    name, side = quantity.split("_")
    values: Floats = getattr(trace, name)[..., 0 if side == "main" else 1]
    return values
