"""Output shaft and bolts of a turret: against printed tables and hand calculation, judged on both sides."""

from __future__ import annotations

from math import pi, sqrt
from typing import Any

import pytest

from camgeom.checks import judge
from camgeom.design.batch import supports
from camgeom.errors import ProfileError
from camgeom.mechanics.output_shaft import PITCH, Bolts, Grade, Size, equivalent_stress
from camgeom.model import Model
from camgeom.report.data.load import output_data
from tests.reference.profiles import model

JOINT: dict[str, Any] = {"bolts": 8, "bolt_size": "M10", "bolt_circle": 110.0}
SHAFT: dict[str, Any] = {"diameter": 60.0, "lever": 45.0, "stress_limit": 70.0}


@pytest.fixture(scope="module")
def rigid() -> Model:
    return model("tool_changer", dynamics=None, tolerance=None, reproduces=None)


@pytest.mark.parametrize(
    ("size", "pitch", "thread", "printed"),
    [
        ("M8", 1.0, 0.12, (20.2, 29.7, 34.7)),
        ("M10", 1.25, 0.14, (30.8, 45.2, 52.9)),
        ("M12", 1.25, 0.10, (49.1, 72.1, 84.4)),
        ("M16", 1.5, 0.14, (85.5, 125.5, 146.9)),
        ("M12", 1.75, 0.14, (41.9, None, None)),
    ],
)
def test_preloads_are_those_of_the_tables_of_vdi_2230(
    size: Size, pitch: float, thread: float, printed: tuple[float | None, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """kN, fine threads and one coarse one, as makers print them."""
    monkeypatch.setitem(PITCH, size, pitch)
    grades: tuple[Grade, ...] = ("8.8", "10.9", "12.9")
    for grade, known in zip(grades, printed):
        if known is not None:
            assert Bolts(8, size, grade, 100.0, 0.1, thread, 2.0, 0.2).preload == pytest.approx(1e3 * known, rel=3e-3)


def test_joint_and_shaft_by_hand() -> None:
    joint = Bolts(6, "M8", "10.9", 80.0, 0.12, 0.14, 1.6, 0.1)
    _, area = joint.section
    assert area == pytest.approx(36.6, abs=0.05)  # ISO 898-1
    assert joint.grip == pytest.approx(6 * 0.12 * joint.preload / 1.6 * 0.9 * 40.0)
    assert joint.shear == pytest.approx(6 * 0.62 * 1040.0 * area * 40.0)
    assert equivalent_stress(40.0, 0.0, 0.0, 1e6) == pytest.approx(sqrt(3.0) * 1e6 * 16.0 / (pi * 40.0**3))
    assert equivalent_stress(40.0, 20.0, 1e6, 0.0) == pytest.approx(1e6 * 32.0 * 40.0 / (pi * (40.0**4 - 20.0**4)))


def test_the_load_is_that_of_the_drive(rigid: Model) -> None:
    """Torque as the limit of the output shaft is judged by; all rollers bend, by at least force times lever."""
    found, duty, torque = rigid.output, rigid.turret_duty, rigid.output_torque
    assert found is not None
    assert duty is not None
    assert torque is not None
    assert found.torque == torque
    assert found.force == pytest.approx(duty.contact_forces.sum(axis=0).max())
    assert found.force >= duty.peak_force.value
    assert found.bending >= 45.0 * found.force
    solved = model("tool_changer", tolerance=None, reproduces=None)
    assert solved.output is not None
    assert solved.output.force > found.force
    assert solved.output.torque == solved.output_torque


@pytest.mark.parametrize(("share", "level"), [(0.999, "fail"), (1.002, "pass")])
def test_both_sides(rigid: Model, share: float, level: str) -> None:
    found = rigid.output
    assert found is not None
    assert found.bolts is not None
    assert found.slip_safety is not None
    assert found.shear_safety is not None
    assert found.stress is not None
    for keys, check, word in (
        ({"output_shaft__joint_friction": 0.1 * 1.8 / found.slip_safety * share}, "bolts", "slip"),
        ({"limits__bolt_slip_safety": found.slip_safety / share}, "bolts", "slip"),
        ({"limits__bolt_shear_safety": found.shear_safety / share}, "bolts", "shear"),
        ({"output_shaft__stress_limit": found.stress * share}, "output-shaft", "bent"),
        ({"output_shaft__diameter": 2.0 * 70.0 / share}, "output-shaft", "room"),
        ({"output_shaft__bolt_circle": (2.0 * 70.0 - 15.0) / share}, "bolts", "room"),
    ):
        told = judge(rigid.with_(**keys), [check]).findings
        assert next(one.level for one in told if word in one.where) == level, keys


@pytest.mark.parametrize(
    ("key", "value", "weaker"),
    [
        ("diameter", 50.0, "stress_mpa"), ("bore", 30.0, "stress_mpa"), ("lever", 90.0, "stress_mpa"),
        ("bolts", 7, "slip_safety"), ("bolt_size", "M8", "slip_safety"), ("bolt_circle", 100.0, "slip_safety"),
        ("joint_friction", 0.09, "slip_safety"), ("thread_friction", 0.16, "slip_safety"),
        ("tightening_factor", 2.5, "slip_safety"), ("preload_loss", 0.3, "slip_safety"),
    ],
)  # fmt: skip
def test_every_key_acts_the_right_way(rigid: Model, key: str, value: Any, weaker: str) -> None:
    before, after = (output_data(one)[weaker] for one in (rigid, rigid.with_(**{f"output_shaft__{key}": value})))
    assert after > before if weaker == "stress_mpa" else after < before
    higher = output_data(rigid.with_(output_shaft__bolt_grade="10.9"))
    assert higher["slip_safety"] > output_data(rigid)["slip_safety"]


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({}, "nothing to judge"),
        ({"diameter": 60.0}, "lever and stress_limit missing"),
        ({"bolts": 8, "bolt_size": "M10"}, "bolt_circle missing"),
        (SHAFT | {"bore": 60.0}, "below the diameter"),
        (JOINT | {"bore": 20.0}, "without the diameter"),
        (SHAFT | {"joint_friction": 0.2}, "mean nothing without bolts"),
        (JOINT | {"bolt_circle": 39.1}, "overlap; allowed: 39.1969"),
    ],
)
def test_halves_and_contradictions_are_refused(rigid: Model, table: dict[str, Any], said: str) -> None:
    with pytest.raises(ProfileError, match=said):
        rigid.with_(output_shaft=table)


def test_what_has_no_output_shaft_refuses_it(rigid: Model) -> None:
    with pytest.raises(ProfileError, match="only a turret has an output shaft"):
        model("pin_insertion", output_shaft=JOINT)
    with pytest.raises(ProfileError, match=r"limits.bolt_slip_safety: means nothing here"):
        rigid.with_(output_shaft=SHAFT, limits__bolt_slip_safety=1.5)


def test_a_batch_leaves_shaft_and_bolts_to_the_exact_model(rigid: Model) -> None:
    for key in ("output_shaft.bolts", "output_shaft.lever", "limits.bolt_slip_safety"):
        assert "output shaft and bolts" in str(supports(rigid.profile, [key]))
    assert supports(rigid.profile, ["operation.speed"]) is None


def test_a_shaft_or_its_bolts_alone(rigid: Model) -> None:
    shaft, joint = rigid.with_(output_shaft=SHAFT), rigid.with_(output_shaft=JOINT)
    assert [one.check for one in judge(shaft, ["bolts", "output-shaft"]).findings] == ["output-shaft"] * 2
    assert [one.check for one in judge(joint, ["bolts", "output-shaft"]).findings] == ["bolts"] * 3
    assert "slip_safety" not in output_data(shaft)
    assert "stress_mpa" not in output_data(joint)


def test_the_state_that_bends_most_need_not_twist_most() -> None:
    """Preloaded rollers press hardest in the dwell: a torque held there bends more than a larger one of the motion."""
    force = [{"from": 0.0, "until": 60.0, "expression": "1.66e5"}]
    states = [{"name": "fast", "share": 0.5}, {"name": "held", "share": 0.5, "speed": 10.0, "force": force}]
    made = model("fine_indexer", reproduces=None).with_(output_shaft=SHAFT, duty=states)
    fast, slow = (one.output for one in made.states)
    assert fast is not None
    assert slow is not None
    assert fast.torque.value > slow.torque.value
    assert fast.force < slow.force
    data, (finding, _) = output_data(made), judge(made, ["output-shaft"]).findings
    assert data["torque_n_m"] == pytest.approx(1e-3 * fast.torque.value)
    assert data["stress_mpa"] == finding.value == max(fast.stress or 0.0, slow.stress or 0.0)
    assert data["bending_n_m"] == pytest.approx(1e-3 * slow.bending)


@pytest.mark.parametrize(("name", "room"), [("parallel_index", 31.0), ("barrel_indexer", 168.0)])
def test_a_shaft_has_to_fit_its_turret_and_pass_what_turns_beside_it(name: str, room: float) -> None:
    """Of plates the distance from their rim to the turret's axis; of a barrel the disc that its rollers stand on."""
    drive = model(name, reproduces=None)
    for diameter, level in ((2.0 * 0.999 * room, "pass"), (2.0 * 1.002 * room, "fail")):
        found = judge(drive.with_(output_shaft=SHAFT | {"diameter": diameter}), ["output-shaft"]).findings
        assert [one.level for one in found if "room" in one.where] == [level]


def test_bolts_have_to_stand_on_their_turret_or_its_dials() -> None:
    """Between plates the dials are wider than what the plates let past; a circle of 100 m had slipped at no torque."""
    drive = model("parallel_index", reproduces=None)
    assert drive.mechanism.turret is not None
    wide = 2.0 * max(radius for radius, _, _ in drive.mechanism.turret.dials)
    for circle, level in (((wide - 15.0) * 0.999, "pass"), ((wide - 15.0) * 1.002, "fail"), (1e5, "fail")):
        found = judge(drive.with_(output_shaft=JOINT | {"bolt_circle": circle}), ["bolts"]).findings
        assert [one.level for one in found if "room" in one.where] == [level]
