"""Statistics over turns, clearance studies on all processors, the fixed-step method, the two papers, the spec."""

import math
import multiprocessing
from types import SimpleNamespace

import numpy as np
import pytest
from pydantic import ValidationError

from camgeom.dynamics.impact import study as impact_study
from camgeom.dynamics.impact.laws import Coulomb, HertzLine, LiuCylinder, PowerLaw, PrintedStiffness, RampedDamping
from camgeom.dynamics.impact.problem import ImpactProblem, RollerSpin
from camgeom.dynamics.impact.run import solve
from camgeom.dynamics.impact.spec import ImpactSpec
from camgeom.dynamics.impact.study import (
    StudyRow,
    Unsolved,
    clearance_study,
    sensitivity,
    statistics,
    study,
)
from camgeom.errors import NotConverged, ProfileError
from camgeom.motion.own import cores
from camgeom.validation.fixed_step import solve_fixed
from tests.reference.impact_press import SPEED as FRAME_SPEED
from tests.reference.impact_press import pressing_problem
from tests.reference.impact_reference import b1_pair, b1_problem, free_flight


def test_study_in_spawned_processes_equals_the_study_here() -> None:
    clearances = [2e-5, 1e-4]
    here = clearance_study(b1_problem(1e-4, contact="power-soft"), clearances, turns=1, skip=0, workers=1)
    there = clearance_study(b1_problem(1e-4, contact="power-soft"), clearances, turns=1, skip=0, workers=2)
    assert here == there
    assert [row.clearance for row in there] == clearances
    for row in there:
        assert row.tighter_change is not None
        assert row.tighter_change < 1e-6
        assert row.energy_residual < 1e-6
        assert row.amplification > 1.0
    growth = math.log(there[1].acceleration.mean / there[0].acceleration.mean) / math.log(5.0)
    assert 0.0 < growth < 0.8
    shown = there[0].as_dict(angular=True)
    assert shown["clearance_mm"] == pytest.approx(0.02)
    assert shown["peak_pressure_mpa"]["mean"] == pytest.approx(1e-6 * there[0].pressure.mean)  # type: ignore[index]
    assert "peak_acceleration_rad_s2" in shown


def test_a_long_study_spawns_and_a_short_one_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []

    def shared(jobs: object, order: list[int], helpers: int) -> dict[int, object]:
        asked.append(helpers)
        return dict.fromkeys(order)

    monkeypatch.setattr(impact_study, "_shared", shared)
    monkeypatch.setattr(impact_study, "_row", lambda job: None)
    monkeypatch.setattr(impact_study, "cores", lambda: 2)
    problems = {str(k): b1_problem(1e-4) for k in range(3)}
    assert study(problems) == [None] * 3
    assert not asked
    monkeypatch.setattr(impact_study, "WORTH_SPAWNING", 0.0)
    assert study(problems) == [None] * 3
    assert asked == [1]


def test_a_worker_that_may_have_none_of_its_own_works_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(multiprocessing, "current_process", lambda: SimpleNamespace(daemon=True))
    assert cores() == 1


def test_steady_turns_of_the_reference_mechanism() -> None:
    """The line contact at 0.1 mm is periodic; at 1 mm it is not and says so."""
    (row,) = study({"0.1": b1_problem(1e-4)}, turns=3, tighter=False)
    assert row.acceleration.mean == pytest.approx(15405.0, rel=1e-3)
    assert row.periodic
    wild = statistics(solve(b1_problem(1e-3), turns=3))
    assert not wild.periodic
    assert wild.acceleration.spread > 0.05
    assert wild.acceleration.least <= wild.acceleration.mean <= wild.acceleration.largest


def test_one_counted_turn_is_not_called_periodic() -> None:
    run = solve(b1_problem(1e-4), turns=3)
    assert statistics(run, skip=1).periodic
    assert not statistics(run, skip=2).periodic


def test_how_far_a_motion_with_impacts_can_be_reproduced() -> None:
    """A small play forgets a disturbance of the start; a large one multiplies it until every peak is another."""
    calm, wild = (sensitivity(solve(b1_problem(play), turns=5)) for play in (1e-4, 1e-3))
    assert calm.reproducible == calm.turns == 5
    assert max(calm.growth) < 1e3
    assert wild.reproducible < 5
    assert wild.growth[-1] > 1e5 * wild.growth[0] > 0.0 or wild.growth[-1] > 1e7
    # beyond them another tolerance gives other peaks as well, up to them it does not
    other = solve(b1_problem(1e-3), turns=5, rtol=3e-10)
    same = solve(b1_problem(1e-3), turns=5)
    changes = [
        abs(same.peak("acceleration", *turn).value / other.peak("acceleration", *turn).value - 1.0)
        for turn in same.turn_times()
    ]
    assert max(changes[: wild.reproducible], default=0.0) < 0.05
    assert max(changes[wild.reproducible :]) > 1e-3


def test_a_roller_that_sticks_names_the_speed_that_would_help(monkeypatch: pytest.MonkeyPatch) -> None:
    from camgeom.dynamics.impact import solver

    monkeypatch.setattr(solver, "_MOST_STEPS", 200)
    rolling = {"friction": Coulomb(0.1, 0.08), "spin": RollerSpin(1e-4)}
    with pytest.raises(NotConverged, match=r"raise stick_speed \(now 0\.001 m/s\)"):
        solve(b1_problem(1e-4, **rolling))
    with pytest.raises(NotConverged, match="softer law") as caught:
        solve(b1_problem(1e-4))
    assert "stick_speed" not in str(caught.value)


@pytest.mark.slow
def test_steady_peaks_under_both_laws_and_contacts() -> None:
    """Those that the paper's statements hang on; the statements themselves are judged by `camgeom validate S5`."""
    keys = [("3-4-5", "printed", 1e-5), ("3-4-5", "printed", 1e-4), ("modified-trapezoid", "hertz", 1e-5),
            ("modified-trapezoid", "hertz", 1e-4), ("modified-trapezoid", "printed", 1e-5)]  # fmt: skip
    problems = {f"{law} {contact} {c:g}": b1_problem(c, law, contact) for law, contact, c in keys}
    rows = dict(zip(keys, study(problems, turns=2, tighter=False), strict=True))
    peaks = [rows[key].acceleration.mean for key in keys[:4]]
    assert peaks == pytest.approx([6439.0, 15125.0, 6311.0, 19254.0], rel=2e-3)
    assert rows[keys[4]].force_main.mean == pytest.approx(12370.0, abs=3.0)
    assert rows[keys[3]].amplification > 2.0


def test_profiles_compared_in_one_call() -> None:
    problems = {law: b1_problem(1e-5, law, "printed") for law in ("3-4-5", "modified-trapezoid")}
    rows = study(problems, turns=1, skip=0, tighter=False)
    assert [row.label for row in rows] == ["3-4-5", "modified-trapezoid"]
    assert rows[0].ideal_acceleration == pytest.approx(6396.418337, rel=1e-3)
    assert rows[1].ideal_acceleration == pytest.approx(5415.514514, rel=1e-3)
    assert rows[1].amplification > rows[0].amplification
    for row in rows:
        assert row.mean_power == pytest.approx(row.lost_energy / problems[row.label].period, abs=2.0)
        assert row.impulse[0] == pytest.approx(row.impulse[1], rel=0.1)
        assert row.peak_torque > 100.0


def test_ideal_peaks_and_printed_geometry() -> None:
    run = solve(b1_problem(1e-4), turns=1.0, rtol=1e-6)
    assert run.machine.lift.peaks[2] * run.problem.speed**2 == pytest.approx(6396.418337, rel=1e-3)
    with pytest.raises(ProfileError, match=r"prime radius 99\.5 mm must lie between 115 and 295 mm"):
        b1_pair(1e-4, base_radius=79.5)


def test_free_flight_estimates() -> None:
    for c, gained, speed in ((1e-5, 0.456230, 0.04056), (1e-4, 2.117631, 0.18829), (1e-3, 9.829205, 0.87512)):
        _, rate, approach = free_flight(b1_problem(c))
        assert rate == pytest.approx(gained, rel=2e-3)
        assert approach == pytest.approx(speed, rel=2e-3)


def test_fixed_step_method_of_the_paper_converges_towards_the_event_solver() -> None:
    problem, end = b1_problem(1e-4, contact="power-soft"), math.radians(9.0)
    exact = [solve(b1_problem(c, contact="power-soft"), end_angle=end).peak("acceleration").value for c in (1e-5, 1e-4)]
    errors = []
    for step in (4e-5, 1e-5):
        fixed = solve_fixed(problem, (1e-5, 1e-4), end_angle=end, step=step)
        errors.append(np.abs(fixed.peaks() / exact - 1.0).max())
    assert errors[1] < errors[0] < 2e-2
    assert errors[1] < 3e-3
    with pytest.raises(ProfileError, match="fixed-step"):
        solve_fixed(b1_problem(1e-4, friction=Coulomb()), (1e-4,), end_angle=end)


def test_pressing_mechanism_moves_as_designed_with_contact_ripple() -> None:
    """Constant-width cam, 60 r/min: kinematic peak pi h w/(2 Phi) = 121.18 mm/s; the printed run gave 120.341."""
    problem = pressing_problem(2e-5)
    run = solve(problem, turns=1.0)
    trace = run.trace.flat()
    peak = 1e3 * float(np.abs(trace.speed).max())
    assert peak == pytest.approx(121.18, rel=0.01)
    assert peak == pytest.approx(120.341, rel=0.02)
    kinematic = problem.pair.lift.many(trace.angle, 2) * np.array([[1.0], [FRAME_SPEED], [FRAME_SPEED**2]])
    assert np.abs(trace.position - kinematic[0]).max() < 2.5e-5, "within the play and the contact deflection"
    assert np.abs(kinematic[2]).max() == pytest.approx(0.979, abs=1e-3)
    assert run.peak("acceleration").value > 1.2 * 0.979, "the contact ripple stands above the kinematic peak"
    assert run.energy.relative_residual < 1e-6
    tight = solve(problem, turns=0.5, rtol=1e-10)
    assert run.peak("acceleration", until=0.5).value == pytest.approx(tight.peak("acceleration").value, rel=1e-6)
    assert {hit.side.name for hit in run.conversions} == {"MAIN", "RETURN"}


def test_spec_gives_the_laws_in_si_units() -> None:
    spec = ImpactSpec()
    law = spec.contact_law(112304.6875, 20.0, 20.0, 130.0)
    assert isinstance(law, HertzLine)
    assert law.force(1e-6, 0.0) == pytest.approx(469.9932583, rel=1e-9)
    assert spec.friction_law() is None
    assert spec.spin() is None
    flat = spec.contact_law(112304.6875, 20.0, math.inf, 40.0)
    assert flat.force(1e-6, 0.0) > 0.0
    power = ImpactSpec(law="power", stiffness=35000.0, damping=28.0).contact_law(1.0, 1.0, 1.0, 1.0)
    assert power == PowerLaw(35000.0 * 10**4.5, 1.5)
    damper = ImpactSpec(damping=28.0).damping_law()
    assert damper == RampedDamping(28e3, 1e-4)
    assert isinstance(ImpactSpec(law="liu").contact_law(1e5, 20.0, 20.0, 130.0), LiuCylinder)
    printed = ImpactSpec(law="printed").contact_law(1e5, 20.0, 20.0, 130.0)
    assert isinstance(printed, PrintedStiffness)
    assert printed.exponent == 1.0
    assert ImpactSpec(study=[0.01, 0.1]).study == (0.01, 0.1)
    reference = b1_problem(1e-4)
    sizes = {"modulus_mpa": 112304.6875, "length_mm": 20.0, "roller_radius_mm": 20.0, "cam_radius_mm": 130.0}
    made = spec.problem(reference.pair, inertia=0.14, speed_rpm=600.0, **sizes)
    assert made.speed == pytest.approx(reference.speed, rel=1e-15)
    assert made.law.force(1e-5, 0.0) == pytest.approx(reference.law.force(1e-5, 0.0), rel=1e-12)
    assert made.damping == reference.damping


@pytest.mark.parametrize(
    "keys",
    [
        {"law": "power"},
        {"static_friction": 0.1, "dynamic_friction": 0.2},
        {"static_friction": 0.1, "slip_speed": 0.0005},
        {"turns": 3, "settle": 3},
        {"roller_inertia": 5.0},
        {"restitution": 0.0},
        {"tolerance": 1e-14},
        {"clearance_kind": "axial"},
    ],
)
def test_spec_refuses(keys: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        ImpactSpec(**keys)  # type: ignore[arg-type]


def test_statistics_need_a_turn() -> None:
    run = solve(b1_problem(1e-5), end_angle=0.5)
    with pytest.raises(ProfileError, match="no whole turn"):
        statistics(run)
    assert isinstance(run.problem, ImpactProblem)


def test_a_run_and_a_study_have_a_budget_of_steps_and_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    from camgeom.dynamics.impact import solver

    problem = b1_problem(1e-4)
    spent = len(solve(problem, turns=2).recorded.steps)
    monkeypatch.setattr(solver, "ORDINARY", 1)
    monkeypatch.setattr(solver, "MOST_OF_A_RUN", spent)
    assert len(solve(problem, turns=2).recorded.steps) == spent
    monkeypatch.setattr(solver, "MOST_OF_A_RUN", spent - 1)
    with pytest.raises(NotConverged, match=f"{spent} steps by"):
        solve(problem, turns=2)
    monkeypatch.setattr(impact_study, "_row", lambda job: job[0])
    names = {str(i): problem for i in range(40)}
    assert len(study(names, turns=4, workers=1)) == 40
    with pytest.raises(NotConverged, match="41 runs of 4 turns and a check would take about 41 s of one core"):
        study({**names, "one more": problem}, turns=4, workers=1)


def test_the_peak_of_a_turn_is_sought_in_the_steps_of_that_turn(monkeypatch: pytest.MonkeyPatch) -> None:
    """So that statistics over many turns cost a turn each, and not all of them; the peaks are the same."""
    from camgeom.dynamics.impact import run as module

    made, plain, looked = solve(b1_problem(1e-4), turns=4), module._pick, list[int]()

    def pick(trace, quantity, *steps):
        found = plain(trace, quantity, *steps)
        if steps:
            looked.append(len(found))
        return found

    monkeypatch.setattr(module, "_pick", pick)
    turns = made.turn_times()
    each = [made.peak("force_main", *turn) for turn in turns]
    starts = np.array([step.time for step in made.recorded.steps])
    within = [int(np.count_nonzero((starts >= low) & (starts <= high))) for low, high in turns]
    assert all(size <= count + 2 for size, count in zip(looked, within, strict=True))
    assert max(each).value == made.peak("force_main").value
    for peak, (low, high) in zip(each, turns, strict=True):
        trace = made.trace.time
        sampled = made.trace.force[..., 0][(trace >= low) & (trace <= high)].max()
        assert sampled * (1.0 - 1e-12) <= peak.value <= 1.001 * sampled
        assert low <= peak.time <= high


def test_a_row_of_a_study_fails_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    problems = {"0.1": b1_problem(1e-4), "1": b1_problem(1e-3)}
    spent = [len(solve(problem, turns=2).recorded.steps) for problem in problems.values()]
    monkeypatch.setattr(impact_study, "ORDINARY", (sum(spent) // 2) // (2 * impact_study.HARD))
    easy, hard = sorted(study(problems, turns=2, tighter=False, workers=1), key=lambda row: isinstance(row, Unsolved))
    assert isinstance(easy, StudyRow)
    assert isinstance(hard, Unsolved)
    assert "steps by" in str(hard.as_dict()["refused"])
    assert hard.label == ("0.1", "1")[int(spent[1] > spent[0])]


CASES = [(66, 2, False), (67, 2, True), (13, 14, False), (400, 6, True)]


@pytest.mark.parametrize(("clearances", "turns", "refused"), CASES)
def test_a_study_that_takes_too_long_is_refused_when_its_profile_is_read(clearances, turns, refused) -> None:
    given = tuple(0.01 + 0.001 * k for k in range(clearances))
    if not refused:
        assert ImpactSpec(study=given, turns=turns).turns == turns
        return
    with pytest.raises(ValueError, match=f"{clearances} runs of {turns} turns and a check would take about"):
        ImpactSpec(study=given, turns=turns)
