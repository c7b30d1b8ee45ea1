"""The solved motion between two contacts and what it tells: peaks, impacts, conversions, energy, wear, cycles (SI)."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from camgeom.dynamics.impact import ImpactProblem, Recorded, State
from camgeom.dynamics.impact_lift import TURN
from camgeom.dynamics.impact_rates import Machine
from camgeom.dynamics.impact_solver import walk
from camgeom.dynamics.impact_stepper import step
from camgeom.dynamics.impact_trace import SHARES, Trace, evaluate, sampled

Floats = NDArray[np.float64]
Quantity = Literal["acceleration", "force_main", "force_back", "pressure_main", "pressure_back"]

_BOOLE = np.array([7, 32, 12, 32, 14, 32, 12, 32, 7]) / 180.0
"""composite Boole weights of the nine points of a step"""


class Peak(NamedTuple):
    """The largest magnitude of a quantity, its time [s] and cam angle [rad]."""

    value: float
    time: float
    angle: float


class Impact(NamedTuple):
    """One contact from on to off. Energy is that of the approach, m v^2/2 with the follower's mass at the contact."""

    time: float
    angle: float
    side: State
    approach_speed: float
    energy: float
    duration: float
    peak_force: float
    peak_pressure: float
    impulse: float
    sliding_work: float
    converts: bool
    """the other side drove before: a drive conversion"""


class Energy(NamedTuple):
    """The power balance over the run [J]; `residual` = work - kinetic - stored - lost should be rounding."""

    work: float
    kinetic: float
    stored: float
    lost: float
    residual: float
    largest_flow: float

    @property
    def relative_residual(self) -> float:
        """The residual over the largest energy that flowed, 1."""
        return abs(self.residual) / self.largest_flow if self.largest_flow > 0.0 else abs(self.residual)


class Wear(NamedTuple):
    """Wear indicators of one side: impulse [N s], sliding work per unit friction [J], friction work [J]."""

    impulse: float
    sliding: float
    friction: float


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

    def _place(self, time: float) -> int:
        return min(max(bisect_right(self._starts, time) - 1, 0), len(self._starts) - 1)

    @cached_property
    def _starts(self) -> list[float]:
        return [s.time for s in self.recorded.steps]

    def _state(self, time: float) -> Any:
        record = self.recorded.steps[self._place(time)]
        rate = self.machine.rate(self.recorded.regimes[record.regime])
        return step(rate, record.time, record.state, record.rate, record.powers, time - record.time).state

    def at(self, times: list[float]) -> Trace:
        """The trace at given times [s], to the accuracy of the solver."""
        states = [self._state(t) for t in times]
        spinning = bool(states) and not isinstance(states[0], complex)
        follower = np.array([complex(y[0]) if spinning else y for y in states])
        spins = np.array([complex(y[1]) for y in states]) if spinning else None
        which = np.array([self.recorded.steps[self._place(t)].regime for t in times])
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
        return tuple(_impacts(self))

    @property
    def conversions(self) -> tuple[Impact, ...]:
        """The contacts by which the drive passes to the other side."""
        return tuple(hit for hit in self.impacts if hit.converts)

    @cached_property
    def energy(self) -> Energy:
        """The balance of work, kinetic, stored and lost energy over the run."""
        return _energy(self)

    @cached_property
    def wear(self) -> tuple[Wear, Wear]:
        """Wear indicators of the main and the back side over the run."""
        trace, lengths = self.trace, np.array([s.length for s in self.recorded.steps])
        sides = []
        for k in (0, 1):
            force, slide = trace.force[..., k], np.abs(trace.sliding[..., k])
            rub = (
                self.problem.friction.coefficient_many(slide.ravel()).reshape(slide.shape)
                if self.problem.friction
                else 0.0
            )
            sums = [float(lengths @ (values @ _BOOLE)) for values in (force, force * slide, force * slide * rub)]
            sides.append(Wear(*sums))
        return sides[0], sides[1]

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


def _impacts(run: ImpactRun) -> list[Impact]:
    """Contacts between on and off events; one that is under way at the start has no approach and is left out."""
    hits: list[Impact] = []
    began: dict[State, tuple[float, float]] = {}
    driving = State.FREE
    first = run.recorded.regimes[0].state if run.recorded.regimes else State.FREE
    if first != State.FREE:
        driving = first
    for event in [*run.recorded.events, None]:
        if event is None or event.kind == "off":
            ended = run.recorded.time if event is None else event.time
            for side, (time, speed) in began.items():
                hits.append(_hit(run, side, time, ended, speed, driving))
                driving = side
            began.clear()
        elif event.kind == "on":
            began[event.state] = (event.time, event.approach)
    return hits


def _hit(run: ImpactRun, side: State, time: float, ended: float, speed: float, driving: State) -> Impact:
    trace, k = run.trace, side - 1
    first, last = run._place(time), run._place(ended)
    if run.recorded.steps[last].time >= ended:
        last -= 1
    rows = slice(first, last + 1)
    lengths = np.array([s.length for s in run.recorded.steps[rows]])
    force, slide = trace.force[rows, :, k], np.abs(trace.sliding[rows, :, k])
    angle = run.start_angle + run.problem.speed * time
    eta = run.trace.deviation[first, :1]
    lever = float(run.problem.pair.sides[k].many(run.machine.lift, np.array([angle]), eta)[1][0])
    mass = run.problem.inertia / (lever * lever)
    return Impact(
        time,
        angle,
        side,
        speed,
        0.5 * mass * speed * speed,
        ended - time,
        float(force.max(initial=0.0)),
        float(trace.pressure[rows, :, k].max(initial=0.0)),
        float(lengths @ (force @ _BOOLE)),
        float(lengths @ ((force * slide) @ _BOOLE)),
        driving not in (State.FREE, side),
    )


def _energy(run: ImpactRun) -> Energy:
    problem, recorded, machine = run.problem, run.recorded, run.machine
    kinetic, stored = [], []
    first = recorded.steps[0]
    ends = [(first.time, first.state, recorded.regimes[first.regime])]
    ends.append((recorded.time, recorded.state, recorded.regimes[recorded.steps[-1].regime]))
    for t, y, regime in ends:
        state = y if isinstance(y, complex) else complex(y[0])
        x = machine.speed * (t - regime.begin)
        s0, s1, s2 = machine.jets.jets[regime.arc](x)
        speed = s1 * machine.speed + state.imag
        spin = 0.0 if problem.spin is None else 0.5 * problem.spin.inertia * abs(complex(y[1])) ** 2
        kinetic.append(0.5 * problem.inertia * speed * speed + spin)
        elastic = 0.0
        if not problem.law.uses_curvature:
            depths = (touch(regime.arc, x, s0, s1, s2, state.real)[0] for touch in machine.touches)
            elastic = sum(problem.law.energy(depth) for depth in depths)
        stored.append(elastic + problem.load.energy(s0 + state.real))
    work, lost = recorded.work[-1].real, recorded.work[-1].imag
    residual = work - (kinetic[1] - kinetic[0]) - (stored[1] - stored[0]) - lost
    swing = max(abs(w.real) for w in recorded.work)
    largest = max(swing, float(0.5 * problem.inertia * (run.trace.speed**2).max()), abs(lost))
    return Energy(work, kinetic[1] - kinetic[0], stored[1] - stored[0], lost, residual, largest)
