"""A short stretch of the verdict campaign, and what its designs and faults are."""

from __future__ import annotations

import sys
from collections.abc import Callable

import numpy as np
import pytest

from tests.places import ROOT

sys.path.insert(0, str(ROOT / "scripts" / "stability"))

from verdict import Record, asked, design_of, of_fault, run_fault, run_sound, table
from verdict_designs import (
    BELL_SEED,
    CONE_SEED,
    DRUM_SEED,
    EDGE_SEED,
    FIFTH_KINDS,
    FIRST_SEED,
    FOURTH_KINDS,
    KINDS,
    LAWS,
    LEAN_SEED,
    LINEAR_SEED,
    SEVENTH_KINDS,
    SIXTH_KINDS,
    THIRD_KINDS,
    furnished,
    kind_of,
    sound,
)
from verdict_faults import (
    CARRIER_SEED,
    FAULTS,
    FIRST,
    IDLE,
    PENDING,
    WITHOUT,
    count_of,
    injected,
    normalised,
    swinging_torque,
)

from camgeom.checks import checks

CONES = tuple(kind for kind in KINDS if kind.endswith("cone") and kind.startswith("disc"))
LEANING = tuple(kind for kind in KINDS if kind.endswith("cone") and kind not in CONES)
CONICAL = "cone groove"
BELLS = tuple(kind for kind in KINDS if kind.startswith("bell"))
CLASSES = count_of(FIRST_SEED)
SECOND = FIRST_SEED + FIRST - FIRST_SEED % CLASSES + CLASSES
"""the first seed of the classes after the first 27"""


@pytest.mark.parametrize(("error", "counted"), [(ZeroDivisionError, True), (KeyError, True), (MemoryError, False)])
@pytest.mark.parametrize("run", [run_sound, run_fault])
def test_a_mistake_of_the_product_is_an_outcome_and_what_the_machine_does_ends_the_campaign(
    run: Callable[[int], Record], error: type[Exception], counted: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def raised(*_: object) -> None:
        raise error("of a test")

    monkeypatch.setattr("verdict.model_of", raised)
    if counted:
        record = run(17)
        assert record.outcome in {"ALARM", "MISS"}
        assert record.by == ("traceback",)
        assert "of a test" in record.said
    else:
        with pytest.raises(error):
            run(17)


def test_a_seed_gives_one_design_and_one_fault() -> None:
    assert sound(17) == sound(17)
    assert of_fault(17) == of_fault(17)
    came = {FIRST_SEED: set(), LINEAR_SEED: {"linear"}, EDGE_SEED: {"linear edge"}, CONE_SEED: {*CONES},
            DRUM_SEED: {CONICAL}, BELL_SEED: {*BELLS}, LEAN_SEED: {*LEANING}}  # fmt: skip
    known = set(KINDS).difference(*came.values())
    for first, kinds in came.items():
        known |= kinds
        assert {kind_of(seed) for seed in range(first, first + len(KINDS))} == known
    classes = {of_fault(seed)[0] for seed in range(LINEAR_SEED, LINEAR_SEED + len(FAULTS))}
    assert classes == set(FAULTS) - {"carrier on the web"}
    assert {of_fault(seed)[0] for seed in range(CARRIER_SEED, CARRIER_SEED + len(FAULTS))} == set(FAULTS)


def test_a_fault_changes_its_profile_unless_it_spoils_the_body() -> None:
    for seed in (*range(2 * len(FAULTS)), *range(LINEAR_SEED, LINEAR_SEED + len(FAULTS))):
        name, kind, data, faulty = of_fault(seed)
        assert kind in FAULTS[name].kinds
        assert (data == faulty) == (FAULTS[name].body in ("coarse", "moved")), name


def test_every_class_names_who_may_speak_and_what_is_pending_is_a_class() -> None:
    for name, fault in FAULTS.items():
        assert fault.checks or fault.refusal, name
        assert set(fault.kinds) <= set(KINDS), name
    assert set(PENDING) <= {"sound", *FAULTS}
    assert all(set(kinds) <= set(KINDS) for kinds, _, _, _ in IDLE)
    spoken = {name for fault in FAULTS.values() for name in fault.checks}
    assert {"wall", "interference", "run-out", "rib-thickness", "dynamic-pressure"} <= spoken & set(checks())


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 20, 10))
def test_sound_designs_raise_no_alarm(first: int) -> None:
    records = [run_sound(seed) for seed in range(first, first + 10)]
    assert not [record for record in records if record.outcome == "ALARM"], table(records)


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, FIRST, 9))
def test_faults_are_told_by_the_right_check(first: int) -> None:
    records = [run_fault(seed) for seed in range(first, first + 9)]
    assert not [record for record in records if record.outcome == "MISS"], table(records)


@pytest.mark.slow
@pytest.mark.parametrize("first", range(SECOND, SECOND + CLASSES - FIRST, 7))
def test_faults_of_the_other_checks_are_told_by_them(first: int) -> None:
    records = [run_fault(seed) for seed in range(first, min(first + 7, SECOND + CLASSES - FIRST))]
    assert not [record for record in records if record.outcome == "MISS"], table(records)


LINEAR = LINEAR_SEED + THIRD_KINDS - LINEAR_SEED % THIRD_KINDS - 1
EDGE = EDGE_SEED + FOURTH_KINDS - EDGE_SEED % FOURTH_KINDS - 1


@pytest.mark.parametrize("seed", [LINEAR, LINEAR + THIRD_KINDS, EDGE, EDGE + FOURTH_KINDS])
def test_sound_linear_cams_raise_no_alarm(seed: int) -> None:
    assert furnished(seed)["cam"]["kind"] == "linear"
    assert run_sound(seed).outcome == "quiet"


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name, fault in FAULTS.items() if "linear" in fault.kinds])
def test_faults_of_linear_cams_are_told(name: str) -> None:
    data = sound(LINEAR, "linear")
    told, _, said = asked(name, data, injected(name, data, "linear", LINEAR))
    assert told, said


@pytest.mark.slow
@pytest.mark.parametrize("kind", [*CONES, CONICAL, *BELLS, *LEANING])
@pytest.mark.parametrize("turn", range(4))
def test_later_kinds_are_judged_right(kind: str, turn: int) -> None:
    first, count = (CONE_SEED, FIFTH_KINDS) if kind in CONES else (DRUM_SEED, SIXTH_KINDS)
    if kind in BELLS:
        first, count = BELL_SEED, SEVENTH_KINDS
    if kind in LEANING:
        first, count = LEAN_SEED, len(KINDS)
    seed = first + count * turn - first % count + count + list(KINDS).index(kind)
    assert kind_of(seed) == kind
    assert run_sound(seed).outcome == "quiet"
    for name in [name for name, fault in FAULTS.items() if kind in fault.kinds][turn::4]:
        data = sound(seed, kind)
        told, _, said = asked(name, data, injected(name, data, kind, seed))
        assert told, (name, said)


def test_every_check_has_a_fault_or_a_reason_why_not() -> None:
    spoken = {name for fault in FAULTS.values() for name in fault.checks}
    assert set(checks()) - spoken == set(WITHOUT)
    assert all(WITHOUT.values())


@pytest.mark.slow
@pytest.mark.parametrize("first", range(FIRST_SEED, FIRST_SEED + len(KINDS), 11))
def test_furnished_designs_raise_no_alarm(first: int) -> None:
    """Further limits, drives and followers that are stiff and damped."""
    assert any("dynamics" in design_of(seed) for seed in range(first, first + 11))
    records = [run_sound(seed) for seed in range(first, first + 11)]
    assert not [record for record in records if record.outcome == "ALARM"], table(records)


@pytest.mark.parametrize(("law", "peaks"), LAWS.items())
def test_the_campaigns_own_laws_have_the_peaks_of_the_handbooks(law: str, peaks: tuple[float, float]) -> None:
    _, slope, curvature = normalised(law, np.linspace(0.0, 1.0, 4001))
    assert (slope.max(), np.abs(curvature).max()) == pytest.approx(peaks, rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "twice"), [(1100, False), (1154, False), (1127, True)])
def test_a_soft_drive_presses_as_the_harmonics_of_one_mass_on_a_spring_say(seed: int, twice: bool) -> None:
    """Its torque rises by 1.6 and more; where it peaks while two rollers bear, the pressure rises by 1.04 alone."""
    from designs import Dice
    from verdict import model_of

    _, kind, _, data = of_fault(seed)
    data = {key: value for key, value in data.items() if key not in ("between", "dynamics")}
    data["follower"]["inertia"] += data["operation"].pop("load_inertia")
    FAULTS["bad indexing drive"].change(data, Dice(seed + 1_000_003))
    model = model_of(data)
    rigid, elastic = model.turret_duty, model.dynamic_duty
    swung = swinging_torque(data, elastic.theta)
    largest = float(np.abs(swung).max())
    assert np.abs(elastic.turret_torque - swung)[np.abs(swung) > 0.5 * largest].max() < 0.05 * largest
    assert float(np.abs(elastic.turret_torque).max()) == pytest.approx(largest, rel=5e-3)
    assert largest > 1.6 * float(np.abs(rigid.turret_torque).max())
    rise = elastic.peak_pressure.value / rigid.peak_pressure.value
    bearing = [int((duty.roller_load[np.abs(duty.turret_torque).argmax()] > 0.0).sum()) for duty in (rigid, elastic)]
    # The pressure at an angle goes with the root of the torque, whoever shares it there.
    pressure, torque = rigid.pressure.max(axis=(1, 2)), rigid.turret_torque
    alike = (swinging_torque(data, rigid.theta) * torque > 0.0) & (np.abs(torque) > 0.05 * np.abs(torque).max())
    root = np.sqrt(np.divide(swinging_torque(data, rigid.theta), torque, out=np.zeros_like(torque), where=alike))
    assert rise == pytest.approx(float((pressure * root).max() / pressure.max()), rel=0.015)
    assert (rise > 1.4) == twice
    assert (bearing == [1, 2]) != twice, kind


@pytest.mark.parametrize("seed", [12, 33])
def test_a_crown_beside_its_straight_wall_is_no_backlash(seed: int) -> None:
    from verdict import model_of

    from camgeom.checks import judge

    data = sound(seed)
    assert data["roller"]["shape"] == "crowned"
    findings = judge(model_of(data), ["backlash"]).findings
    assert [f.level for f in findings] == ["pass", "pass"]
    deep = dict(data, cam=data["cam"] | {"base_radius": data["cam"]["base_radius"] - 5.0 * data["output"]["tolerance"]})
    cut = model_of(data)
    cut.body.__dict__["solids"] = model_of(deep).solids
    assert "fail" in {f.level for f in judge(cut, ["backlash"]).findings}
