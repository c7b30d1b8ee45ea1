"""Many contact problems at once: statistics over turns, clearance studies, comparison of profiles (SI units).

A motion with impacts need not be periodic; its peaks are then reported as mean, least and largest over turns, and the
only convergence that can be shown is that of the first turn, against a run with a ten times tighter tolerance. How far
the turns after it can be reproduced at all is measured: `sensitivity` follows a small disturbance.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from time import perf_counter
from typing import NamedTuple, final

import numpy as np

from camgeom.dynamics.impact.problem import ImpactProblem
from camgeom.dynamics.impact.run import ImpactRun, Quantity, solve
from camgeom.dynamics.impact.solver import ORDINARY
from camgeom.dynamics.impact.spec import too_long
from camgeom.errors import NotConverged, Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.interrupts import beginning_children
from camgeom.motion.own import begin_worker, cores, loaded_files

PEAKS: tuple[Quantity, ...] = ("acceleration", "force_main", "force_return")
"""what a turn is compared by"""
HARD = 2
"""times the steps of an ordinary turn that a turn may take in a study, so that what all take is known before"""
WORTH_SPAWNING = 1.0
"""s of work left that pays for starting processes, which takes about half of that"""
Job = tuple[str, ImpactProblem, int, int, float, bool]
PERIODIC_SPREAD = 1e-3
"""relative spread of the peaks of two counted turns or more below which the motion is called periodic"""
DISTURBANCE = 1e-9
"""share of the play by which the start is moved to see what becomes of it"""
SAME_PEAKS = 1e-2
"""relative change of a turn's peaks up to which the turn counts as reproduced"""


class Statistic(NamedTuple):
    """Mean, least and largest of a quantity over turns."""

    mean: float
    least: float
    largest: float

    @property
    def spread(self) -> float:
        """(largest - least) over the mean, 1."""
        return (self.largest - self.least) / self.mean if self.mean else 0.0


@final
@immutable(eq=True)
class StudyRow:
    """One variant: peaks over turns in SI units, and how far they can be trusted."""

    label: str
    clearance: float
    turns: int
    acceleration: Statistic
    force_main: Statistic
    force_return: Statistic
    pressure: Statistic
    approach_speed: Statistic
    impacts: Statistic
    conversions: Statistic
    peak_torque: float
    """largest magnitude of the torque that the cam needs [N m]"""
    mean_power: float
    """mean power that the cam supplies [W]"""
    lost_energy: float
    """mean per turn [J]"""
    impulse: tuple[float, float]
    """mean contact impulse per turn, main and return side [N s]"""
    sliding_work: tuple[float, float]
    """mean sliding work per turn and unit of friction coefficient, main and return side [J]: a measure of wear"""
    rms_jerk: float
    ideal_acceleration: float
    """peak of the motion without free play"""
    periodic: bool
    """two counted turns or more, whose peaks agree"""
    tighter_change: float | None
    """relative change of the first turn's peak acceleration against a ten times tighter run"""
    energy_residual: float
    """of the power balance, over the largest energy that flowed"""

    @property
    def amplification(self) -> float:
        """Mean peak acceleration over that of the ideal motion, 1."""
        return self.acceleration.mean / self.ideal_acceleration

    def as_dict(self, angular: bool) -> dict[str, object]:
        """The row with units in its keys, at the edge: mm, N, MPa, J; accelerations rad/s^2 (`angular`) or m/s^2."""
        unit = "rad_s" if angular else "m_s"

        def triple(statistic: Statistic, factor: float = 1.0) -> dict[str, float]:
            return {name: factor * value for name, value in statistic._asdict().items()}

        return {
            "label": self.label,
            "clearance_mm": 1e3 * self.clearance,
            "turns": self.turns,
            "periodic": self.periodic,
            f"peak_acceleration_{unit}2": triple(self.acceleration),
            f"ideal_acceleration_{unit}2": self.ideal_acceleration,
            "amplification": self.amplification,
            "peak_force_main_n": triple(self.force_main),
            "peak_force_return_n": triple(self.force_return),
            "peak_pressure_mpa": triple(self.pressure, 1e-6),
            "approach_speed_m_s": triple(self.approach_speed),
            "impacts_per_turn": triple(self.impacts),
            "drive_conversions_per_turn": triple(self.conversions),
            "peak_cam_torque_nm": self.peak_torque,
            "mean_power_w": self.mean_power,
            "lost_energy_j_per_turn": self.lost_energy,
            "impulse_ns_per_turn": list(self.impulse),
            "sliding_work_j_per_turn": list(self.sliding_work),
            f"rms_jerk_{unit}3": self.rms_jerk,
            "tighter_change": self.tighter_change,
            "energy_residual": self.energy_residual,
        }


@final
@immutable(eq=True)
class Unsolved:
    """A variant whose run does not converge, or takes more than the steps of its share: its clearance [m], and why."""

    label: str
    clearance: float
    reason: str

    def as_dict(self, angular: bool = False) -> dict[str, object]:
        """Plain data for result.json."""
        return {"label": self.label, "clearance_mm": 1e3 * self.clearance, "refused": self.reason}


def statistics(run: ImpactRun, skip: int = 1, label: str = "", tighter: float | None = None) -> StudyRow:
    """The peaks of every whole turn of a run but the first `skip`. Raises ProfileError where no turn is left."""
    turns = run.turn_times()[skip:]
    if not turns:
        raise ProfileError([Problem("cycles", "no whole turn is left after the settling turns", skip, "fewer to skip")])

    def over(quantity: Quantity) -> Statistic:
        return _statistic([run.peak(quantity, low, high).value for low, high in turns])

    hits = [[hit for hit in run.impacts if low <= hit.time < high] for low, high in turns]
    main, back = over("force_main"), over("force_return")
    pressures = [
        max(run.peak("pressure_main", *turn).value, run.peak("pressure_return", *turn).value)
        if run.problem.patch
        else 0.0
        for turn in turns
    ]
    acceleration = over("acceleration")
    ideal = run.machine.lift.peaks[2] * run.problem.speed**2
    return StudyRow(
        label,
        _clearance(run.problem),
        len(turns),
        acceleration,
        main,
        back,
        _statistic(pressures),
        _statistic([max((hit.approach_speed for hit in turn), default=0.0) for turn in hits]),
        _statistic([float(len(turn)) for turn in hits]),
        _statistic([float(sum(hit.converts for hit in turn)) for turn in hits]),
        over("cam_torque").largest,
        *_powers(run, turns),
        _per_turn(run, [side.impulse for side in run.wear]),
        _per_turn(run, [side.sliding for side in run.wear]),
        run.jerk[1],
        ideal,
        len(turns) > 1 and all(peaks.spread < PERIODIC_SPREAD for peaks in (acceleration, main, back)),
        tighter,
        run.energy.relative_residual,
    )


def study(
    problems: Mapping[str, ImpactProblem],
    *,
    turns: int = 6,
    skip: int = 1,
    rtol: float = 1e-9,
    tighter: bool = True,
    workers: int | None = None,
) -> list[StudyRow | Unsolved]:
    """One row a problem, in order, on all processors (or `workers` of them; 1: in this process).

    `tighter` repeats the first turn with a tenth of the tolerance. Processes are used, not threads: a run is plain
    Python and threads would take turns. They are spawned where the first run says that it pays, so a script must guard
    its entry by `if __name__ == "__main__"`. A run that does not converge costs its own row. Raises NotConverged
    where all together would take too long (`spec.too_long`).
    """
    if said := too_long(len(problems), turns):
        raise NotConverged(said)
    jobs = [(label, problem, turns, skip, rtol, tighter) for label, problem in problems.items()]
    # Long runs first: the work grows with the clearance, and one long run must not be the last to start.
    order = sorted(range(len(jobs)), key=lambda i: -_clearance(jobs[i][1]))
    rows: dict[int, StudyRow | Unsolved] = {}
    count = min(workers or cores(), len(jobs))
    if workers is None and count > 1:
        began = perf_counter()
        rows[order[0]] = _row(jobs[order[0]])
        order = order[1:]
        if (perf_counter() - began) * len(order) < WORTH_SPAWNING:
            count = 1
    rows |= {i: _row(jobs[i]) for i in order} if count <= 1 else _shared(jobs, order, count - 1)
    return [rows[i] for i in range(len(jobs))]


def _shared(jobs: Sequence[Job], order: Sequence[int], helpers: int) -> dict[int, StudyRow | Unsolved]:
    """Rows of the jobs by this process and `helpers` spawned ones: this one works while they start."""
    rows: dict[int, StudyRow | Unsolved] = {}
    with ProcessPoolExecutor(helpers, get_context("spawn"), begin_worker, (loaded_files(),)) as pool:
        with beginning_children():
            given = {i: pool.submit(_row, jobs[i]) for i in order}
        for i in order:
            # a job that no helper has taken yet is done here
            if given[i].cancel():
                rows[i] = _row(jobs[i])
        rows |= {i: future.result() for i, future in given.items() if not future.cancelled()}
    return rows


def clearance_study(
    problem: ImpactProblem,
    clearances: Sequence[float] | None = None,
    *,
    count: int = 13,
    **options: int | float | bool | None,
) -> list[StudyRow | Unsolved]:
    """Rows over the clearance [m]; by default `count` of them from 1e-6 to 1e-3 m in equal ratios."""
    values = list(np.geomspace(1e-6, 1e-3, count)) if clearances is None else list(clearances)
    problems = {f"{1e3 * c:.4g} mm": replace(problem, pair=problem.pair.with_clearance(float(c))) for c in values}
    return study(problems, **options)  # type: ignore[arg-type]


def _row(job: Job) -> StudyRow | Unsolved:
    label, problem, turns, skip, rtol, tighter = job
    try:
        run = solve(problem, turns=turns, rtol=rtol, most=HARD * ORDINARY * turns)
        return statistics(run, skip, label, tighter_change(run, HARD * ORDINARY) if tighter else None)
    except NotConverged as error:
        return Unsolved(label, _clearance(problem), str(error))


def tighter_change(run: ImpactRun, most: int | None = None) -> float:
    """Relative change (1) of the first turn's peak acceleration when it is solved with a tenth of the tolerance, in at
    most so many steps."""
    problem = run.problem
    first = run.peak("acceleration", 0.0, problem.period).value
    close = solve(
        problem, start_angle=run.start_angle, turns=1.0, rtol=max(0.1 * run.rtol, 1e-13), most=most
    ).peak("acceleration").value
    return abs(first - close) / close if close > 0.0 else abs(first - close)


@final
@immutable(eq=True)
class StartSensitivity:
    """What becomes of a small disturbance of the start: how far a run can be reproduced.

    growth        (turns,) distance of the two runs at the end of every turn over the disturbance, 1
    reproducible  turns from the start whose peaks the disturbance leaves as they are, to SAME_PEAKS
    """

    growth: tuple[float, ...]
    reproducible: int

    @property
    def turns(self) -> int:
        """Turns that were compared."""
        return len(self.growth)

    def as_dict(self) -> dict[str, object]:
        """Plain data for result.json."""
        data = {"disturbance": DISTURBANCE, "growth_over_turns": list(self.growth)}
        return data | {"reproducible_turns": self.reproducible, "turns": self.turns}


def sensitivity(run: ImpactRun) -> StartSensitivity:
    """The run against one whose start is moved by DISTURBANCE of the play, solved alike.

    Distances are relative to the play with its deflection and to the speed of a free flight, see `Machine`. Every
    solver's rounding is such a disturbance: beyond the turns that are reproducible no peak is a result, only the
    statistics of many turns are.
    """
    machine, turns = run.machine, run.turn_times()
    first = run.state_at([0.0])[0]
    start = (first.real + DISTURBANCE * machine.eta_scale, first.imag)
    angle = run.start_angle
    moved = solve(run.problem, start_angle=angle, turns=float(len(turns)), start=start, rtol=run.rtol)
    ends = [high for _, high in turns]
    gaps = [a - b for a, b in zip(run.state_at(ends), moved.state_at(ends), strict=True)]
    scale = DISTURBANCE
    growth = [float(np.hypot(g.real / machine.eta_scale, g.imag / machine.rate_scale)) / scale for g in gaps]
    same = [all(_same(run.peak(q, *turn).value, moved.peak(q, *turn).value) for q in PEAKS) for turn in turns]
    return StartSensitivity(tuple(growth), same.index(False) if False in same else len(same))


def _same(one: float, other: float) -> bool:
    return abs(one - other) <= SAME_PEAKS * max(one, other)


def _statistic(values: Sequence[float]) -> Statistic:
    return Statistic(sum(values) / len(values), min(values), max(values))


def _clearance(problem: ImpactProblem) -> float:
    return problem.pair.clearance


def _powers(run: ImpactRun, turns: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Mean power supplied [W] and mean energy lost per turn [J], between the steps nearest to the turns' ends."""
    times = [step.time for step in run.recorded.steps] + [run.recorded.time]
    low, high = turns[0][0], turns[-1][1]
    given = np.interp([low, high], times, [work.real for work in run.recorded.work])
    lost = np.interp([low, high], times, [work.imag for work in run.recorded.work])
    return float(given[1] - given[0]) / (high - low), float(lost[1] - lost[0]) / len(turns)


def _per_turn(run: ImpactRun, values: Sequence[float]) -> tuple[float, float]:
    turns = run.recorded.time / run.problem.period
    return values[0] / turns, values[1] / turns
