"""The stepping of the contact solver: accepted steps, events placed to rounding, restarts (SI units).

The method is the explicit Runge-Kutta pair DOP853. A one-coordinate system has the state (position, velocity); held as
position + 1j * velocity every linear combination of the stages is one Python operation, so a step costs a few
microseconds beside its twelve calls of the right-hand side. The same code takes a complex array with roller spins.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, final

import numpy as np

from camgeom.dynamics.impact.laws import ImpactDamping
from camgeom.dynamics.impact.problem import (
    Coordinates,
    Event,
    ImpactProblem,
    Rate,
    Recorded,
    Regime,
    State,
    StepRecord,
    follower,
    spin,
)
from camgeom.dynamics.impact.rates import CompiledProblem
from camgeom.errors import NotConverged, Problem, ProfileError
from camgeom.maths import TURN


class Stepped(NamedTuple):
    """A trial step: the new state, its error measure vectors of order 5 and 3, and the integrated powers."""

    state: Coordinates
    fifth: Coordinates
    third: Coordinates
    work: complex


def step(f: Rate, t: float, y: Coordinates, k1: Coordinates, p1: complex, h: float) -> Stepped:
    """The state at t + h by the 12-stage method of order 8 of Dormand and Prince, as given by Hairer.

    `k1, p1` are f(t, y). Coefficients: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 2nd ed.,
    section II.10 (DOP853). They stand in the text as literals because a literal is the quickest operand there is.
    The powers take the quadrature of the same order and never feed back.
    """
    k2, _ = f(t + 0.05260015195876773 * h, y + h * (0.05260015195876773 * k1))
    k3, _ = f(t + 0.0789002279381516 * h, y + h * (0.0197250569845379 * k1 + 0.0591751709536137 * k2))
    k4, _ = f(t + 0.1183503419072274 * h, y + h * (0.02958758547680685 * k1 + 0.08876275643042054 * k3))
    rise = 0.2413651341592667 * k1 - 0.8845494793282861 * k3 + 0.924834003261792 * k4
    k5, _ = f(t + 0.2816496580927726 * h, y + h * rise)
    rise = 0.037037037037037035 * k1 + 0.17082860872947386 * k4 + 0.12546768756682242 * k5
    k6, p6 = f(t + 0.3333333333333333 * h, y + h * rise)
    rise = 0.037109375 * k1 + 0.17025221101954405 * k4 + 0.06021653898045596 * k5 - 0.017578125 * k6
    k7, p7 = f(t + 0.25 * h, y + h * rise)
    rise = (
        0.03709200011850479 * k1
        + 0.17038392571223998 * k4
        + 0.10726203044637328 * k5
        - 0.015319437748624402 * k6
        + 0.008273789163814023 * k7
    )
    k8, p8 = f(t + 0.3076923076923077 * h, y + h * rise)
    rise = (
        0.6241109587160757 * k1
        - 3.3608926294469414 * k4
        - 0.868219346841726 * k5
        + 27.59209969944671 * k6
        + 20.154067550477894 * k7
        - 43.48988418106996 * k8
    )
    k9, p9 = f(t + 0.6512820512820513 * h, y + h * rise)
    rise = (
        0.47766253643826434 * k1
        - 2.4881146199716677 * k4
        - 0.590290826836843 * k5
        + 21.230051448181193 * k6
        + 15.279233632882423 * k7
        - 33.28821096898486 * k8
        - 0.020331201708508627 * k9
    )
    k10, p10 = f(t + 0.6 * h, y + h * rise)
    rise = (
        -0.9371424300859873 * k1
        + 5.186372428844064 * k4
        + 1.0914373489967295 * k5
        - 8.149787010746927 * k6
        - 18.52006565999696 * k7
        + 22.739487099350505 * k8
        + 2.4936055526796523 * k9
        - 3.0467644718982196 * k10
    )
    k11, p11 = f(t + 0.8571428571428571 * h, y + h * rise)
    rise = (
        2.273310147516538 * k1
        - 10.53449546673725 * k4
        - 2.0008720582248625 * k5
        - 17.9589318631188 * k6
        + 27.94888452941996 * k7
        - 2.8589982771350235 * k8
        - 8.87285693353063 * k9
        + 12.360567175794303 * k10
        + 0.6433927460157636 * k11
    )
    k12, p12 = f(t + h, y + h * rise)
    rise = (
        0.054293734116568765 * k1
        + 4.450312892752409 * k6
        + 1.8915178993145003 * k7
        - 5.801203960010585 * k8
        + 0.3111643669578199 * k9
        - 0.1521609496625161 * k10
        + 0.20136540080403034 * k11
        + 0.04471061572777259 * k12
    )
    fifth = (
        0.01312004499419488 * k1
        - 1.2251564463762044 * k6
        - 0.4957589496572502 * k7
        + 1.6643771824549864 * k8
        - 0.35032884874997366 * k9
        + 0.3341791187130175 * k10
        + 0.08192320648511571 * k11
        - 0.022355307863886294 * k12
    )
    third = rise - 0.2440944881889764 * k1 - 0.7338466882816118 * k9 - 0.022058823529411766 * k12
    work = h * (
        0.054293734116568765 * p1
        + 4.450312892752409 * p6
        + 1.8915178993145003 * p7
        - 5.801203960010585 * p8
        + 0.3111643669578199 * p9
        - 0.1521609496625161 * p10
        + 0.20136540080403034 * p11
        + 0.04471061572777259 * p12
    )
    return Stepped(y + h * rise, fifth, third, work)


def error_norm(fifth: complex, third: complex, h: float, scale: complex) -> float:
    """The error of a step over its tolerance, 1; `scale` holds the tolerances of the two components of the state."""
    a, b = fifth.real / scale.real, fifth.imag / scale.imag
    c, d = third.real / scale.real, third.imag / scale.imag
    five, three = a * a + b * b, c * c + d * d
    if five == 0.0:
        return 0.0
    return float(abs(h) * five / math.sqrt(2.0 * (five + 0.01 * three)))


def next_step(h: float, error: float) -> float:
    """The step to try after one of length h whose error over the tolerance was `error` (safety 0.9, 0.2 to 8 times)."""
    if error == 0.0:
        return 8.0 * h
    return h * min(8.0, max(0.2, 0.9 * math.pow(error, -0.125)))


SUBPOINTS = 8


def hermite_row(u: float) -> tuple[float, float, float, float, float, float]:
    """Weights of y0, h y0', h^2 y0'', y1, h y1', h^2 y1'' in the quintic Hermite form at the share u of a step."""
    v = 1.0 - u
    u3, v3 = u * u * u, v * v * v
    return (
        v3 * (1.0 + 3.0 * u + 6.0 * u * u),
        v3 * u * (1.0 + 3.0 * u),
        0.5 * v3 * u * u,
        u3 * (1.0 + 3.0 * v + 6.0 * v * v),
        -u3 * v * (1.0 + 3.0 * v),
        0.5 * u3 * v * v,
    )


_ROWS = tuple(hermite_row(j / SUBPOINTS) for j in range(1, SUBPOINTS))


class Trial(NamedTuple):
    """A step that met its tolerance, with the rate at its end."""

    time: float
    length: float
    state: Coordinates
    rate: Coordinates
    powers: complex
    work: complex


def subpoints(record: StepRecord, trial: Trial) -> list[tuple[float, complex]]:
    """Shares of a step and the state there: quintic in the deviation, linear in its rate.

    The rate only serves to watch the clip, which is placed exactly.
    """
    h = trial.length
    y, k, y1, k1 = (follower(state) for state in (record.state, record.rate, trial.state, trial.rate))
    a, b, c = y.real, h * y.imag, h * h * k.imag
    d, e, f = y1.real, h * y1.imag, h * h * k1.imag
    rise = y1.imag - y.imag
    points: list[tuple[float, complex]] = []
    for j, (ra, rb, rc, rd, re, rf) in enumerate(_ROWS, 1):
        eta = ra * a + rb * b + rc * c + rd * d + re * e + rf * f
        points.append((j / SUBPOINTS, complex(eta, y.imag + rise * j / SUBPOINTS)))
    points.append((1.0, y1))
    return points


class Beside(NamedTuple):
    """A place beside an event: the time past the start of the step, what changes its sign there and how fast it does
    (not a number where that is not known), and the step up to it."""

    tau: float
    value: float
    slope: float
    made: Stepped


def crossing(at: Callable[[float], Beside], low: Beside, high: Beside, past: float, width: float) -> Beside:
    """A place just past a sign change from not positive to positive: with a value of at most `past`, or within a width.

    The cubic of the inverse function through both ends, with their slopes, tells where half of that value is.
    """
    goal, stalled = 0.5 * past, False
    for _ in range(100):
        if high.value <= past or high.tau - low.tau <= width:
            break
        tau = _inverse(low, high, goal)
        if stalled or not low.tau < tau < high.tau:
            tau = 0.5 * (low.tau + high.tau)
            if not low.tau < tau < high.tau:
                break
        found = at(tau)
        if 0.0 < found.value <= past:
            return found
        # A guess that is no nearer by half than the ends are is followed by half of what is left.
        stalled = not stalled and abs(found.value) > 0.5 * min(-low.value, high.value)
        low, high = (low, found) if found.value > 0.0 else (found, high)
    return high


def _inverse(low: Beside, high: Beside, goal: float) -> float:
    """Where a function that rises reaches a value, by the cubic of its inverse; by the chord without its slopes."""
    long, rise = high.tau - low.tau, high.value - low.value
    share = (goal - low.value) / rise
    left, right = low.slope * long, high.slope * long
    if not (left > FLAT * rise and right > FLAT * rise):
        return low.tau + long * share
    # Shares of the time over shares of the rise; as steep as rise / left and rise / right at its ends.
    rest = 1.0 - share
    bend = rest * (rise / left - 1.0) - share * (rise / right - 1.0)
    return low.tau + long * share * (1.0 + rest * bend)


FLAT = 0.2
"""of the chord's slope; with less than that at an end the cubic of the inverse is no guide"""
PAST = 1e-3
"""of the tolerance, by which a contact may have begun or ended where it is placed"""
FIRST_STEP = 1e-6
"""of a turn, after every restart: an automatic first step would be judged at zero force"""
AFTER_KNOT = 0.1
"""of the step before: the force is continuous across a knot of the motion, but the foot passes it a little later"""
LONGEST_STEP = math.radians(1.0)
"""of the cam: in free flight the error says nothing and the step would grow past contacts"""
_MOST_EVENTS = 20_000
_MOST_STEPS = 30_000
"""a turn; an ordinary one takes a thousand, so that this is a stiffness no explicit step should follow"""
MOST_OF_A_RUN = 60_000
"""of a run, or twice an ordinary one's where that has many turns: some ten seconds, 100 MB"""
ORDINARY, ORDINARY_TOLERANCE = 1000, 1e-9
"""steps of an ordinary turn, and the tolerance that they keep"""


@final
@dataclass
class _Walk:
    """The walk through time. Mutable: it is the one place that accumulates."""

    machine: CompiledProblem
    rtol: float
    end: float
    allowed: int | None = None

    def run(self, angle: float, start: Coordinates) -> Recorded:
        """From a cam angle [rad] (time 0) and a state to the end time."""
        machine, w = self.machine, self.machine.speed
        lift = machine.lift
        inside = angle % TURN
        arc = lift.arc_at(inside)
        begin = (lift.starts[arc] - inside) / w
        regime = self._first_regime(Regime(State.FREE, arc, begin, 1.0, False), follower(start))
        self.steps: list[StepRecord] = []
        self.work: list[complex] = [0j]
        self.regimes: list[Regime] = []
        self.events: list[Event] = []
        self.calls = 0
        turns = max(1.0, self.end / machine.problem.period)
        self.most = int(min(_MOST_STEPS * turns, self.allowed or max(MOST_OF_A_RUN, 2 * ORDINARY * turns)))
        self.next = 0.0
        t, y = 0.0, start
        while t < self.end:
            knot = regime.begin + machine.jets.spans[regime.arc] / w
            t, y, regime = self._until(t, y, regime, min(knot, self.end))
            if t == knot and t < self.end:
                following = regime.arc + 1 if regime.arc + 1 < len(lift.arcs) else 0
                regime = regime._replace(arc=following, begin=knot)
            else:
                self.next = 0.0
            if len(self.events) > _MOST_EVENTS:
                raise NotConverged(
                    f"{len(self.events)} contact events by {t:.6g} s: the contact chatters; a softer law, more "
                    "damping, or a larger speed_floor would settle it"
                )
        return Recorded(self.steps, t, y, self.work, self.regimes, self.events, self.calls)

    def _first_regime(self, regime: Regime, y: complex) -> Regime:
        """Start in contact where the state is past a limit, or on it and moving in."""
        for which in (0, 1):
            depth, rate = self.machine.depth(which, regime, 0.0, y)
            if depth > 0.0 or (depth == 0.0 and rate > 0.0):
                return self._entered(regime, which, 0.0, y)
        return regime

    def _entered(self, regime: Regime, which: int, t: float, y: complex) -> Regime:
        speed = self.machine.approach(which, regime, t, y)[1]
        damping = self.machine.problem.damping
        floor = damping.speed_floor if isinstance(damping, ImpactDamping) else 0.0
        return regime._replace(state=State(which + 1), approach=max(speed, floor), clipped=False)

    def _until(self, t: float, y: Coordinates, regime: Regime, stop: float) -> tuple[float, Coordinates, Regime]:
        """Step within one regime until it changes or `stop` is reached."""
        machine = self.machine
        rate = machine.rate(regime)
        number = len(self.regimes)
        self.regimes.append(regime)
        k, p = rate(t, y)
        self.calls += 1
        h = AFTER_KNOT * self.next or FIRST_STEP * machine.problem.period
        moving = abs(follower(y).imag)
        if moving > 0.0 and not self.next:
            h = min(h, 0.01 * machine.eta_scale / moving)
        while t < stop:
            wanted = h
            trial, h = self._step(rate, t, y, k, p, h, stop)
            # A step cut short by the end of the stretch says little about the length to go on with.
            self.next = max(h, wanted) if trial.time == stop and trial.length < wanted else h
            record = StepRecord(t, trial.length, y, k, p, number)
            found = self._event(regime, rate, record, trial)
            if found is not None:
                tau, made, which = found
                error = self._error(made, tau)
                if error > 1.0:
                    # The trial was judged beyond the event, where the contact law goes on otherwise.
                    h = next_step(tau, error)
                    continue
                self._accept(record._replace(length=tau), made.work)
                t, y = t + tau, made.state
                return t, y, self._changed(regime, which, t, follower(y))
            self._accept(record, trial.work)
            t, y, k, p = trial.time, trial.state, trial.rate, trial.powers
        return t, y, regime

    def _accept(self, record: StepRecord, work: complex) -> None:
        if record.length > 0.0:
            self.steps.append(record)
            if len(self.steps) > self.most:
                period = self.machine.problem.period
                turns, made = self.end / period, record.time / period
                fewer = ", or fewer of these turns" if made >= 1.0 else ""
                raise NotConverged(
                    f"{len(self.steps)} steps by {record.time:.6g} s, {made:.3g} of {turns:.3g} turns: the contact, "
                    "its damping (tied to the speed of the last touch) or the friction is too stiff against the length "
                    "of a turn; a larger speed_floor, a restitution nearer 1, a softer law, less friction or a higher "
                    f"speed would do{fewer}{self._friction_advice()}{self._fine_advice()}"
                )
            self.work.append(self.work[-1] + work)

    def _fine_advice(self) -> str:
        """What eases a tolerance that asks for more than ordinary figures need."""
        return f"; or a larger impact.tolerance than {self.rtol:g}" if self.rtol < ORDINARY_TOLERANCE else ""

    def _friction_advice(self) -> str:
        """What eases a friction that turns a roller: it sticks, and the steps follow the slope through no sliding."""
        problem = self.machine.problem
        if problem.friction is None or problem.spin is None:
            return ""
        stick = problem.friction.stick_speed
        return (
            f"; with roller_inertia a roller that rolls sticks: raise stick_speed (now {stick:g} m/s) and slip_speed "
            "with it, to a hundredth of the sliding speeds or more, or leave roller_inertia out"
        )

    def _step(
        self, rate: Rate, t: float, y: Coordinates, k: Coordinates, p: complex, h: float, stop: float
    ) -> tuple[Trial, float]:
        """One step that meets the tolerance, and the length to try next."""
        longest = LONGEST_STEP / self.machine.speed
        shortest = 1e-15 * (self.machine.problem.period + abs(t))
        while True:
            h = min(h, longest)
            last = t + 1.01 * h >= stop
            if last:
                h = stop - t
            self.calls += 11
            try:
                made = step(rate, t, y, k, p, h)
                error = self._error(made, h)
            except NotConverged as beyond:
                # A trial that is far too long may look outside the range of a law; only a short one may not.
                if h < shortest:
                    raise NotConverged(f"at {t:.9g} s: {beyond}") from beyond
                h *= 0.1
                continue
            if error <= 1.0:
                t1 = stop if last else t + h
                k1, p1 = rate(t1, made.state)
                self.calls += 1
                return Trial(t1, h, made.state, k1, p1, made.work), next_step(h, error)
            if not error < math.inf or h < shortest:
                raise NotConverged(
                    f"the step fell to {h:.3g} s at {t:.9g} s without meeting rtol {self.rtol:g}; "
                    "use a tolerance not below 1e-12, or check the contact data"
                )
            h = next_step(h, error)

    def _error(self, made: Stepped, h: float) -> float:
        machine, rtol = self.machine, self.rtol
        scale = complex(rtol * machine.eta_scale, rtol * max(machine.rate_scale, abs(follower(made.state).imag)))
        error = error_norm(follower(made.fifth), follower(made.third), h, scale)
        if isinstance(made.state, complex):
            return error
        tolerance = rtol * max(abs(spin(made.state)), machine.speed)
        return max(error, error_norm(spin(made.fifth), spin(made.third), h, complex(tolerance, tolerance)))

    def _event(
        self, regime: Regime, rate: Rate, record: StepRecord, trial: Trial
    ) -> tuple[float, Stepped, int] | None:
        """The first event inside a step: (time past its start, the step up to it, event number), or None.

        Events: 0, 1 contact with main, return side; 2 contact lost; 3 force clipped or released.
        """
        watched: list[int]
        if regime.state == State.FREE:
            watched = [0, 1]
        else:
            watched = [2, 3] if regime.clipped or self._may_clip(regime, record, trial) else [2]
        points = subpoints(record, trial)
        for j, (share, state) in enumerate(points):
            t = record.time + share * trial.length if share < 1.0 else trial.time
            for which in watched:
                if self._crossed(regime, which, t, state)[0] > 0.0:
                    low = points[j - 1][0] if j else 0.0
                    return self._placed(regime, rate, record, which, low * trial.length, share * trial.length)
        return None

    def _may_clip(self, regime: Regime, record: StepRecord, trial: Trial) -> bool:
        """Whether the separating speed can come near the one at which damping cancels the elastic force."""
        if not isinstance(self.machine.problem.damping, ImpactDamping):
            return self.machine.problem.damping.coefficient > 0.0
        first, second = follower(record.state), follower(trial.state)
        fastest = max(abs(first.imag), abs(second.imag)) * self.machine.levers[regime.state - 1]
        return bool(2.0 * fastest * self.machine.factor > regime.approach)

    def _crossed(self, regime: Regime, which: int, t: float, y: complex) -> tuple[float, float]:
        """Positive once the event has happened, and its rate of change, where that is known."""
        if which < 2:
            return self.machine.depth(which, regime, t, y)
        side = regime.state - 1
        if which == 2:
            depth, rate = self.machine.depth(side, regime, t, y)
            return -depth, -rate
        share = self.machine.approach(side, regime, t, y)[2]
        return share if regime.clipped else -share, math.nan

    def _placed(
        self, regime: Regime, rate: Rate, record: StepRecord, which: int, low: float, high: float
    ) -> tuple[float, Stepped, int] | None:
        """The event between two times past the start of the step, by repeating the step to ever better guesses."""

        def at(tau: float) -> Beside:
            made = step(rate, record.time, record.state, record.rate, record.powers, tau)
            self.calls += 11
            return Beside(tau, *self._crossed(regime, which, record.time + tau, follower(made.state)), made)

        end = at(high)
        if end.value <= 0.0:
            return None
        if low == 0.0:
            value, slope = self._crossed(regime, which, record.time, follower(record.state))
            begin = Beside(0.0, min(value, 0.0), slope, end.made)
        else:
            begin = at(low)
            if begin.value > 0.0:
                return self._placed(regime, rate, record, which, 0.0, low)
        past = PAST * self.rtol * (self.machine.eta_scale if which < 3 else 1.0)
        found = crossing(at, begin, end, past, 1e-15 * (1.0 + abs(record.time)))
        return found.tau, found.made, which

    def _changed(self, regime: Regime, which: int, t: float, y: complex) -> Regime:
        """The regime after an event, which is noted."""
        if which < 2:
            after = self._entered(regime, which, t, y)
            kind = "on"
        elif which == 2:
            after = regime._replace(state=State.FREE, clipped=False)
            kind = "off"
        else:
            after = regime._replace(clipped=not regime.clipped)
            kind = "release" if regime.clipped else "clip"
        side = max(after.state, regime.state) - 1
        speed = self.machine.approach(side, regime, t, y)[1]
        self.events.append(Event(t, kind, State(side + 1), speed))
        return after


def walk(
    problem: ImpactProblem, angle: float, end_angle: float, start: tuple[float, float] | None, rtol: float,
    most: int | None = None,
) -> tuple[CompiledProblem, Recorded]:
    """Solve from a cam angle to another [rad]; `start` is (eta, d eta/dt), by default the middle of the play with the
    follower (not the deviation) at rest. Raises NotConverged, with more than `most` steps too where that is given.
    """
    if not 1e-13 <= rtol <= 1e-2:
        raise ProfileError([Problem("tolerance", "outside its range", rtol, "1e-13 to 1e-2")])
    if not end_angle > angle:
        raise ProfileError([Problem("end_angle", "must lie beyond the start", end_angle, f"> {angle:g} rad")])
    machine = CompiledProblem(problem)
    slope = float(machine.lift.many(angle, 1)[1, 0])
    begin = start or (problem.pair.middle(angle), -slope * problem.speed)
    state: Coordinates = complex(*begin)
    if problem.spin is not None:
        state = np.array([state, 0j])
    runner = _Walk(machine, rtol, (end_angle - angle) / problem.speed, most)
    return machine, runner.run(angle, state)
