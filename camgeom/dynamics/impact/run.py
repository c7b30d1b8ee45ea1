"""The solved motion between two contacts and what it tells: peaks, impacts, conversions, energy, wear, cycles (SI)."""

from __future__ import annotations

import itertools
import math
from bisect import bisect_right
from typing import Literal, NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from camgeom.dynamics.impact.laws import ImpactDamping
from camgeom.dynamics.impact.problem import Coordinates, ImpactProblem, Recorded, Regime, State, follower, spin
from camgeom.dynamics.impact.rates import CompiledProblem
from camgeom.dynamics.impact.solver import hermite_row, step, walk
from camgeom.errors import NotConverged
from camgeom.immutable import immutable
from camgeom.maths import TURN, Floats
from camgeom.maths.frozen import cached_property
from camgeom.maths.panels import NODES, Panels

Complexes = NDArray[np.complex128]
_BOOLE = np.array([7, 32, 12, 32, 14, 32, 12, 32, 7]) / 180.0
"""composite Boole weights of the nine points of a step"""


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


DEEPEST = 0.05
"""share of the roller's radius to which it sinks into the cam by a law that may be believed"""
SHARES = 8
"""intervals that every step is sampled in"""
EVEN: Floats = np.linspace(0.0, 1.0, SHARES + 1)


@final
@immutable
class Trace:
    """Arrays over time, shape (steps, 9) or whatever times were asked for; both sides in the last axis of the pairs.

    `time` s, `angle` cam angle rad (counted on over turns), `deviation` m or rad, `position`, `speed`,
    `acceleration` of the follower (m or rad, per s, per s^2), `force` (..., 2) N, `penetration` (..., 2) m
    (0 out of contact), `sliding` (..., 2) m/s, `pressure` (..., 2) Pa, `cam_torque` N m that the cam needs, `thrust` of
    the normal forces along the coordinate (N or N m), `state`.
    """

    time: Floats
    angle: Floats
    deviation: Floats
    position: Floats
    speed: Floats
    acceleration: Floats
    force: Floats
    penetration: Floats
    sliding: Floats
    pressure: Floats
    cam_torque: Floats
    thrust: Floats
    state: NDArray[np.int8]

    def flat(self) -> Trace:
        """The same with the time in one axis."""
        return self.shaped(-1)

    def shaped(self, *shape: int) -> Trace:
        """The same with the time in axes of another shape."""
        values = {name: getattr(self, name) for name in self.__dataclass_fields__}
        return Trace(**{name: v.reshape(*shape, *v.shape[self.time.ndim :]) for name, v in values.items()})


def evaluate(
    machine: CompiledProblem, regimes: list[Regime], which: NDArray[np.int64], time: Floats, states: Complexes,
    spins: Complexes,
) -> Trace:
    """The trace at deviations + 1j * rates and roller spins (flat arrays), `which` the number of the regime of each."""
    problem, lift, w = machine.problem, machine.lift, machine.speed
    arcs = np.array([r.arc for r in regimes])[which]
    x = w * (time - np.array([r.begin for r in regimes])[which])
    angle = np.array(lift.starts)[arcs] + x
    jet = np.empty((3, time.size))
    for k in np.unique(arcs):
        here = arcs == k
        jet[:, here] = lift.arcs[k].many(angle[here], 2)
    state = np.array([r.state for r in regimes], dtype=np.int8)[which]
    clipped = np.array([r.clipped for r in regimes])[which]
    approach = np.array([r.approach for r in regimes])[which]
    eta, rate = states.real, states.imag
    q, q1 = jet[0] + eta, jet[1] * w + rate
    load = problem.load
    torque = load.constant - load.stiffness * q
    if load.drag:
        torque = torque - load.drag * np.tanh(3.0 * q1 / load.drag_speed)
    if load.applied is not None:
        ends = np.array([arc.end for arc in lift.arcs])
        torque = torque - load.applied.many(angle, np.array(lift.starts)[arcs], ends[arcs])
    pairs = {name: np.zeros((time.size, 2)) for name in ("force", "penetration", "sliding", "pressure")}
    needed, thrust = np.zeros(time.size), np.zeros(time.size)
    for side in (0, 1):
        on = np.flatnonzero((state == side + 1) & ~clipped)
        if not on.size:
            continue
        delta, h, g, ht, gt, bend = problem.pair.sides[side].many(lift, angle[on], eta[on])
        sinking = g * w - h * q1[on]
        elastic = problem.laws[side].force_many(delta, bend)
        if isinstance(problem.damping, ImpactDamping):
            lost = elastic * (problem.damping.factor / approach[on]) * sinking
        else:
            lost = problem.damping.viscosity_many(delta) * sinking
        force = np.maximum(elastic + lost, 0.0)
        slide = ht * q1[on] - gt * w
        lever = ht
        if problem.spin is not None:
            radius, carrier = problem.pair.sides[side].rolls
            lever = ht + radius * carrier
            slide = lever * q1[on] - radius * (spins.real if side == 0 else spins.imag)[on] - gt * w
        rub = problem.friction.coefficient_many(slide) * force if problem.friction is not None else 0.0
        thrust[on] = force * h
        torque[on] += thrust[on] - rub * lever
        needed[on] += force * g - rub * gt
        pairs["force"][on, side], pairs["penetration"][on, side] = force, delta
        pairs["sliding"][on, side] = slide
        if (patch := problem.patches[side]) is not None:
            pairs["pressure"][on, side] = patch.pressure(force, bend)
    moved = (time, w * time, eta, q, q1, torque / problem.inertia)
    return Trace(*moved, cam_torque=needed, thrust=thrust, state=state, **pairs)


def sampled(machine: CompiledProblem, made: Recorded, angle: float, shares: Floats = EVEN) -> Trace:
    """The trace at shares (k,) of every step, by quintic Hermite in the deviation (error below 1e-6 of its range)."""
    steps = made.steps
    t0 = np.array([s.time for s in steps])
    h = np.array([s.length for s in steps])
    which = np.array([s.regime for s in steps])
    every = [*(s.state for s in steps), made.state]
    y: Complexes = np.array([follower(s) for s in every])
    z: Complexes = np.array([spin(s) for s in every])
    a0 = np.array([follower(s.rate) for s in steps]).imag
    w = machine.speed
    # The rate at a step's end belongs to its own regime: at a knot of the motion the next one begins with another.
    ends = evaluate(machine, made.regimes, which, t0 + h, y[1:], z[1:])
    a1 = ends.acceleration - _ideal(machine, made.regimes, which, t0 + h) * w * w
    rows = np.array([hermite_row(u) for u in shares])
    slopes = np.array([_hermite_slope(u) for u in shares])
    basis = np.stack([y[:-1].real, h * y[:-1].imag, h * h * a0, y[1:].real, h * y[1:].imag, h * h * a1], axis=1)
    states = (basis @ rows.T + 1j * (basis @ slopes.T) / h[:, None]).ravel()
    time = (t0[:, None] + shares * h[:, None]).ravel()
    spins: Complexes = (z[:-1, None] * (1.0 - shares) + z[1:, None] * shares).ravel()
    numbers = np.repeat(which, len(shares))
    trace = evaluate(machine, made.regimes, numbers, time, states, spins)
    trace.angle[:] += angle
    return trace.shaped(len(steps), len(shares))


def _ideal(machine: CompiledProblem, regimes: list[Regime], which: NDArray[np.int64], time: Floats) -> Floats:
    """Second derivative of the ideal motion per rad^2, each in the arc of its own regime."""
    lift = machine.lift
    arcs = np.array([r.arc for r in regimes])[which]
    angle = np.array(lift.starts)[arcs] + machine.speed * (time - np.array([r.begin for r in regimes])[which])
    second = np.empty(time.size)
    for k in np.unique(arcs):
        here = arcs == k
        second[here] = lift.arcs[k].many(angle[here], 2)[2]
    return second


def _hermite_slope(u: float) -> tuple[float, ...]:
    """Derivative over u of the rows of `hermite_row`."""
    v = 1.0 - u
    return (
        -30.0 * u * u * v * v,
        v * v * (1.0 + 2.0 * u - 15.0 * u * u),
        0.5 * u * v * v * (2.0 - 5.0 * u),
        30.0 * u * u * v * v,
        u * u * (1.0 + 2.0 * v - 15.0 * v * v),
        -0.5 * u * u * v * (2.0 - 5.0 * v),
    )


Quantity = Literal["acceleration", "force_main", "force_return", "pressure_main", "pressure_return", "cam_torque"]


class ImpactPeak(NamedTuple):
    """The largest magnitude of a quantity, its time [s] and cam angle [rad]."""

    value: float
    time: float
    angle: float


@final
@immutable
class ImpactRun:
    """A solved run; everything else is computed when asked for, once."""

    problem: ImpactProblem
    start_angle: float
    rtol: float
    machine: CompiledProblem
    recorded: Recorded

    @cached_property
    def trace(self) -> Trace:
        """Nine points in every step, arrays of shape (steps, 9)."""
        return sampled(self.machine, self.recorded, self.start_angle)

    def state_at(self, times: list[float]) -> list[complex]:
        """Deviation + 1j * its rate at times [s] inside the run, to the accuracy of the solver."""
        return [follower(self._state(t)) for t in times]

    def place(self, time: float) -> int:
        """The number of the step that holds a time [s]."""
        return min(max(bisect_right(self._starts, time) - 1, 0), len(self._starts) - 1)

    @cached_property
    def _starts(self) -> list[float]:
        return [s.time for s in self.recorded.steps]

    def _state(self, time: float) -> Coordinates:
        record = self.recorded.steps[self.place(time)]
        rate = self.machine.rate(self.recorded.regimes[record.regime])
        return step(rate, record.time, record.state, record.rate, record.powers, time - record.time).state

    def at(self, times: list[float]) -> Trace:
        """The trace at given times [s], to the accuracy of the solver."""
        states = [self._state(t) for t in times]
        y, z = np.array([follower(s) for s in states]), np.array([spin(s) for s in states])
        which = np.array([self.recorded.steps[self.place(t)].regime for t in times])
        made = evaluate(self.machine, self.recorded.regimes, which, np.array(times), y, z)
        made.angle[:] += self.start_angle
        return made

    def peak(self, quantity: Quantity, since: float = 0.0, until: float = math.inf) -> ImpactPeak:
        """The largest magnitude of a quantity between two times [s], refined to the accuracy of the solver."""
        # Only the steps of the window, and the one that ends where it begins: of many turns each asks for its own.
        first, last = max(self.place(since) - 1, 0), self.place(until) + 1
        window = self.trace.time[first:last]
        values = np.where((window >= since) & (window <= until), _pick(self.trace, quantity, first, last), 0.0)
        order = np.argsort(values, axis=None)[::-1]
        best = ImpactPeak(0.0, since, self.start_angle)
        seen: list[float] = []
        for flat in order[:60]:
            value, time = values.flat[flat], float(window.flat[flat])
            if value <= 0.985 * best.value or value == 0.0 or len(seen) >= 4:
                break
            if any(abs(time - other) < 1e-3 * self.problem.period for other in seen):
                continue
            seen.append(time)
            refined = self._refined(quantity, first * (SHARES + 1) + int(flat))
            best = max(best, refined)
        return best

    def _refined(self, quantity: Quantity, flat: int) -> ImpactPeak:
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
        return ImpactPeak(float(heights[best]), at, self.start_angle + self.problem.speed * at)

    @cached_property
    def impacts(self) -> tuple[Impact, ...]:
        """Contacts between on and off events; one that is under way at the start has no approach and is left out."""
        hits: list[Impact] = []
        began: dict[State, tuple[float, float]] = {}
        driving = self.recorded.regimes[0].state if self.recorded.regimes else State.FREE
        for event in [*self.recorded.events, None]:
            if event is None or event.kind == "off":
                ended = self.recorded.time if event is None else event.time
                for side, (time, speed) in began.items():
                    hits.append(self._hit(side, time, ended, speed, driving))
                    driving = side
                began.clear()
            elif event.kind == "on":
                began[event.state] = (event.time, event.approach)
        return tuple(hits)

    @property
    def conversions(self) -> tuple[Impact, ...]:
        """The contacts by which the drive passes to the other side."""
        return tuple(hit for hit in self.impacts if hit.converts)

    def _hit(self, side: State, time: float, ended: float, speed: float, driving: State) -> Impact:
        trace, k = self.trace, side - 1
        first, last = self.place(time), self.place(ended)
        if self.recorded.steps[last].time >= ended:
            last -= 1
        rows = slice(first, last + 1)
        lengths = np.array([s.length for s in self.recorded.steps[rows]])
        force, slide = trace.force[rows, :, k], np.abs(trace.sliding[rows, :, k])
        angle = self.start_angle + self.problem.speed * time
        eta = self.trace.deviation[first, :1]
        lever = float(self.problem.pair.sides[k].many(self.machine.lift, np.array([angle]), eta)[1][0])
        mass = self.problem.inertia / (lever * lever)
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

    @cached_property
    def energy(self) -> Energy:
        """The balance of work, kinetic, stored and lost energy over the run."""
        problem, recorded, machine = self.problem, self.recorded, self.machine
        kinetic, stored = [], []
        first = recorded.steps[0]
        ends = [(first.time, first.state, recorded.regimes[first.regime])]
        ends.append((recorded.time, recorded.state, recorded.regimes[recorded.steps[-1].regime]))
        for t, y, regime in ends:
            state = follower(y)
            x = machine.speed * (t - regime.begin)
            s0, s1, s2 = machine.jets.jets[regime.arc](x)
            speed = s1 * machine.speed + state.imag
            turning = 0.0 if problem.spin is None else 0.5 * problem.spin.inertia * abs(spin(y)) ** 2
            kinetic.append(0.5 * problem.inertia * speed * speed + turning)
            elastic = 0.0
            if not problem.law.uses_curvature:
                depths = (touch(regime.arc, x, s0, s1, s2, state.real)[0] for touch in machine.touches)
                elastic = sum(law.energy(depth) for law, depth in zip(problem.laws, depths))
            stored.append(elastic + problem.load.energy(s0 + state.real))
        work, lost = recorded.work[-1].real, recorded.work[-1].imag
        residual = work - (kinetic[1] - kinetic[0]) - (stored[1] - stored[0]) - lost
        swing = max(abs(w.real) for w in recorded.work)
        largest = max(swing, float(0.5 * problem.inertia * (self.trace.speed**2).max()), abs(lost))
        return Energy(work, kinetic[1] - kinetic[0], stored[1] - stored[0], lost, residual, largest)

    @cached_property
    def wear(self) -> tuple[Wear, Wear]:
        """Wear indicators of the main and the return side over the run."""
        trace, lengths = self.trace, np.array([s.length for s in self.recorded.steps])
        sides = []
        for k in (0, 1):
            force, slide = trace.force[..., k], np.abs(trace.sliding[..., k])
            friction = self.problem.friction
            rub = friction.coefficient_many(slide.ravel()).reshape(slide.shape) if friction is not None else 0.0
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

    def thrust(self, turn: int) -> tuple[Panels, Floats]:
        """Panels of a turn (from 0 on) between the solver's steps, and the normal forces [N or N m] along q on them."""
        first, last = (self.place((turn + k) * self.problem.period * (1.0 + 1e-12)) for k in (0, 1))
        rows = slice(first, last if (turn + 1) * self.problem.period < self.recorded.time * (1.0 - 1e-12) else None)
        steps = self.recorded.steps[rows]
        values = self._thrust[rows]
        angle = self.problem.speed * np.array([s.time for s in steps]) - TURN * turn
        changes = [a.regime != b.regime for a, b in itertools.pairwise(steps)]
        edges = np.append(angle, TURN)
        edges[0] = 0.0
        breaks = np.append(edges[np.append(True, changes).nonzero()], TURN)
        whole = Panels(edges, breaks)
        return whole, values

    @cached_property
    def _thrust(self) -> Floats:
        """What `thrust` gives, of every step, (steps, n)."""
        return sampled(self.machine, self.recorded, self.start_angle, 0.5 * (NODES + 1.0)).thrust

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
    most: int | None = None,
) -> ImpactRun:
    """Solve the contact problem from a cam angle [rad] to another, or over a number of turns.

    `start` is the deviation and its rate [m, m/s or rad, rad/s]; by default the follower rests in the middle of the
    play. `rtol` is relative to the play plus the static deflection, and to the larger of the free-flight speed and the
    speed at hand. Raises NotConverged, with more than `most` steps too where that is given, and where a roller sinks
    deeper than `DEEPEST` of its radius (a flat face has none), ProfileError.
    """
    end = start_angle + TURN * turns if end_angle is None else end_angle
    machine, recorded = walk(problem, start_angle, end, start, rtol, most)
    run = ImpactRun(problem, start_angle, rtol, machine, recorded)
    for side, patch in enumerate(problem.patches):
        depth = float(run.trace.penetration[..., side].max(initial=0.0))
        if patch is not None and depth > DEEPEST * patch.roller_radius:
            raise NotConverged(
                f"the roller sinks {1e3 * depth:.4g} mm into the cam, more than a twentieth of its radius of "
                f"{1e3 * patch.roller_radius:.4g} mm: no contact law holds there; it is far too soft for load and speed"
            )
    return run


def _pick(trace: Trace, quantity: Quantity, first: int = 0, last: int | None = None) -> Floats:
    """Its magnitudes in the trace, those of some steps."""
    if quantity in ("acceleration", "cam_torque"):
        return np.asarray(np.abs(getattr(trace, quantity)[first:last]))
    name, side = quantity.split("_")
    values: Floats = getattr(trace, name)[first:last, ..., 0 if side == "main" else 1]
    return values
