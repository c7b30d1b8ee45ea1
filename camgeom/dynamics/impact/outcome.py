"""What a solved run tells of its impacts: contacts one by one, the energy balance, wear indicators (SI units)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from camgeom.dynamics.impact.problem import State

if TYPE_CHECKING:
    from camgeom.dynamics.impact.run import ImpactRun

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


def impacts(run: ImpactRun) -> list[Impact]:
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
    first, last = run.place(time), run.place(ended)
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


def balance(run: ImpactRun) -> Energy:
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


def wear(run: ImpactRun) -> tuple[Wear, Wear]:
    """Wear indicators of the main and the return side over the run."""
    trace, lengths = run.trace, np.array([s.length for s in run.recorded.steps])
    sides = []
    for k in (0, 1):
        force, slide = trace.force[..., k], np.abs(trace.sliding[..., k])
        rub = run.problem.friction.coefficient_many(slide.ravel()).reshape(slide.shape) if run.problem.friction else 0.0
        sums = [float(lengths @ (values @ _BOOLE)) for values in (force, force * slide, force * slide * rub)]
        sides.append(Wear(*sums))
    return sides[0], sides[1]
