"""The first turn from rest and the output shaft, judged on both sides; whose loads a verdict judges, said."""

from __future__ import annotations

import numpy as np
import pytest

from camgeom.checks import judge
from camgeom.cli import main
from camgeom.errors import ProfileError
from camgeom.model import Model
from camgeom.model.vibration import least_contact
from camgeom.profile import parse
from camgeom.report.result import compute
from tests.dynamics.machines import IMPACTS, changed, changer, finding, follower, levels, limited
from tests.places import PROFILES
from tests.reference.planar_machines import ELASTIC, disc

FORCE = ("friction = 15000", 'friction = 15000\nforce = [{expression = "20000"}]')
SIDES = ((1.002, "pass"), (0.998, "fail"))


def test_the_pressure_of_the_first_turn_warns_beyond_the_limit():
    """350 r/min: 1 314 MPa in the steady state, 1 343 starting from rest."""
    model = changer(350)
    peak = max(duty.peak_pressure.value for duty in model.start_duties)
    assert peak > 1.02 * model.dynamic_duty.peak_pressure.value
    for share, level in ((1.002, "pass"), (0.998, "warn")):
        limited_ = changer(350, ("contact_limit = 1300", f"contact_limit = {share * peak!r}"))
        told = finding(limited_, "start-pressure")
        assert (told.level, told.value) == (level, pytest.approx(peak))
        assert levels(limited_, "dynamic-pressure") == {"dynamic-pressure": "pass"}


@pytest.mark.parametrize(("share", "level"), SIDES)
def test_torque_and_bearing_of_the_first_turn_fail_beyond_their_limits(share, level):
    model = changer(350)
    torque = 1e-3 * model.start_torque.value
    assert torque > 1.04e-3 * model.dynamic_torque.value
    text = limited((PROFILES / "tool_changer.toml").read_text(), f"torque_n_m = {float(share * torque)!r}")
    told = judge(Model(parse(changed(text, ("speed = 120", "speed = 350")))), ["start-torque", "dynamic-torque"])
    assert {f.check: f.level for f in told.findings} == {"start-torque": level, "dynamic-torque": "pass"}
    safety = min(duty.bearing.static_safety for duty in model.start_duties)
    text = limited((PROFILES / "tool_changer.toml").read_text(),
                   f"bearing_static_safety = {float(safety / share)!r}")  # fmt: skip
    found = finding(Model(parse(changed(text, ("speed = 120", "speed = 350")))), "start-bearing")
    assert (found.level == "fail") == (level == "fail")


def test_a_contact_that_only_the_start_loses_warns():
    """At 590 r/min the start presses 0.095 N less than the steady state; a preload between the two holds one alone."""
    model = follower(590)
    steady, start = (least_contact(model, turn).value for turn in ("steady", "start"))
    assert 0.0 < start < steady
    from camgeom.dynamics.follower.response import preload_share

    share = preload_share(model.elastic_follower.train)
    for kept, level in ((1.02 * start, "pass"), (0.5 * (start + steady), "warn")):
        least = 90.0 - kept / share if level == "warn" else 90.0
        held = follower(590, ("spring_preload = 90", f"spring_preload = {least!r}"))
        assert levels(held, "lift-off", "start-lift-off") == {"lift-off": "pass", "start-lift-off": level}
    (word,) = judge(held, ["start-pressure"]).not_judged
    assert "start-lift-off" in word.reason


def test_a_start_is_judged_where_the_periodic_state_has_no_answer():
    """A resonance without damping: nothing periodic is judged, the first turn is; too few steps judge neither."""
    text = changed(ELASTIC.format(law="cycloidal"), ("polydyne = true", "linkage_damping = 0"))
    hertz = float(Model(parse(text)).elastic_follower.train.natural_frequency()[0]) / (2.0 * np.pi)
    model = Model(parse(changed(text, ("speed = 900", f"speed = {60.0 * hertz / 8!r}"))))
    verdict = judge(model, ["dynamic-pressure", "start-pressure", "start-lift-off"])
    assert "dynamic-pressure" in [word.check for word in verdict.not_judged]
    assert {f.check for f in verdict.findings} >= {"start-lift-off"}
    coarse = changer(350, ("output_damping = 25", 'output_damping = 25\nmethod = "wilson"\nsteps = 16'))
    (word,) = judge(coarse, ["start-pressure"]).not_judged
    assert "dynamics.steps" in word.reason


def test_a_motion_that_moves_where_the_turn_begins_has_no_start():
    head, _, rest = ELASTIC.format(law="cycloidal").replace("polydyne = true", "").partition("[[motion]]")
    rest = rest[rest.index("[operation]"):]
    law = 'law = "polynomial"'
    for speed, judged_ in ((0.0, True), (2.0, False)):
        motion = f"[[motion]]\nuntil = 150\nto = 12\n{law}\n[[motion]]\nuntil = 360\nto = 0\n{law}\n"
        motion += f"velocity = {speed}\nacceleration = 0\n"
        verdict = judge(Model(parse(head + motion + rest)), ["start-pressure", "start-lift-off"])
        assert bool(verdict.findings) == judged_
        assert [word.check for word in verdict.not_judged] == ([] if judged_ else ["start-pressure"])
        assert all("does not stand still where the turn begins" in word.reason for word in verdict.not_judged)


def test_a_drive_starts_from_the_windup_of_what_acts_on_it():
    """A torque of 20 N m holds the load plate from the first moment; relaxed shafts would throw it."""
    study = changer(350, FORCE).indexing
    start = study.start
    assert start.output("output_torque")[0, 0] == pytest.approx(-20.0, rel=1e-9)
    deviation = start.output("load_deviation")[0]
    assert deviation[0] != 0.0
    assert np.abs(deviation[:3] - deviation[0]).max() < 1e-9 * abs(deviation[0])
    assert abs(start.output("load_acceleration")[0, 0]) < 1e-9
    # without a torque nothing is wound up
    assert not changer(350, ("friction = 15000", "friction = 0")).indexing.start.output("load_deviation")[0, :3].any()


@pytest.mark.parametrize(("share", "level"), SIDES)
def test_the_output_shaft_is_judged_by_the_hardest_turn(share, level):
    model = changer(350)
    peak = 1e-3 * model.output_torque.value
    assert model.output_torque.where == "starting from rest"
    assert peak > 1e-3 * float(model.indexing.steady.peak("output_torque").magnitude[0])
    text = limited((PROFILES / "tool_changer.toml").read_text(), f"output_torque_n_m = {float(share * peak)!r}")
    assert finding(Model(parse(changed(text, ("speed = 120", "speed = 350")))), "output-torque").level == level


@pytest.mark.parametrize(("share", "level"), SIDES)
def test_without_dynamics_the_output_shaft_carries_the_whole_turret(share, level):
    text = (PROFILES / "parallel_index.toml").read_text()
    model = Model(parse(text))
    assert model.profile.dynamics_spec is None
    peak = 1e-3 * model.output_torque.value
    assert peak == pytest.approx(1e-3 * np.abs(model.turret_duty.turret_torque).max(), rel=1e-3)
    told = finding(Model(parse(limited(text, f"output_torque_n_m = {float(share * peak)!r}"))), "output-torque")
    assert (told.level, told.value) == (level, pytest.approx(peak))
    assert "rigid" in told.where
    assert not judge(model, ["output-torque"]).findings


def test_torques_without_a_limit_are_told():
    shaft = ("[output_shaft]", "diameter = 60 ", "lever = 45 ", "stress_limit = 70 ", "bolts = 8 ", 'bolt_size = "M10"',
             "bolt_circle = 110")  # fmt: skip
    bare = changer(350, *((line, f"# {line}") for line in shaft))
    told = {word.check: word.reason for word in judge(bare, ["output-torque", "dynamic-torque"]).not_judged}
    assert "limits.output_torque_n_m" in told["output-torque"]
    assert "1404 N m starting from rest" in told["output-torque"]
    assert "limits.torque_n_m" in told["dynamic-torque"]
    assert "466.9 N m starting from rest" in told["dynamic-torque"]
    # bolts say nothing of the shaft; a diameter with its limit does
    bolted = changer(350, *((line, f"# {line}") for line in shaft[1:4]))
    (alone,) = judge(bolted, ["output-torque"]).not_judged
    assert "limits.output_torque_n_m" in alone.reason
    assert not judge(changer(350), ["output-torque"]).not_judged


def test_what_has_no_output_shaft_has_no_limit_of_it():
    with pytest.raises(ProfileError, match=r"limits\.output_torque_n_m.*only a turret"):
        parse(ELASTIC.format(law="cycloidal") + "\n[limits]\noutput_torque_n_m = 10\n")


def test_figures_of_the_first_turn_stand_in_json_text_report_and_study(tmp_path, capsys):
    from camgeom.report.sections.dynamics import dynamics

    text = changed((PROFILES / "tool_changer.toml").read_text(), ("speed = 120", "speed = 350"))
    model = Model(parse(text))
    data = compute(model, ("dynamics",)).data["dynamics"]
    assert data["start_duty"]["peak_pressure_mpa"] == pytest.approx(1353.70, abs=0.1)
    assert data["output_torque_n_m"] == pytest.approx(1404.06, abs=0.01)
    assert not [key for key in data["start_duty"] if key.endswith("life_h")]
    tables = [block for block in dynamics(model) if "What the contact carries" in getattr(block, "caption", "")]
    assert [column.label for column in tables[0].columns] == ["Quantity", "Elastic", "From rest", "Rigid", "Unit"]
    assert all(len(row) == 5 for row in tables[0].rows)
    profile = tmp_path / "changer.toml"
    profile.write_text(text)
    assert main(["solve", str(profile)]) == 0
    shown = capsys.readouterr().out
    for words in ("peak contact pressure, from rest", "peak camshaft torque, from rest", "peak torque of the output"):
        assert words in shown
    assert main(["study", str(profile), "--vary", "operation.speed=350", "--out", str(tmp_path / "s")]) in (0, 1)
    head = (tmp_path / "s" / "study.csv").read_text().splitlines()[0]
    assert "dynamics.output_torque_n_m" in head
    assert "dynamics.start_duty.peak_pressure_mpa" in head
    assert "loads" in head.split(",")


def test_a_verdict_says_whose_loads_it_judged(tmp_path, capsys):
    from camgeom.report.sections import report

    rigid = Model(parse((PROFILES / "pin_insertion.toml").read_text()))
    found = judge(rigid, ["load"])
    assert found.loads.rigid
    moves = [span for span in rigid.setup.program.spans if span.law != "dwell"]
    shortest = min(span.end - span.start for span in moves) / (600.0 * np.pi / 30.0)
    assert found.loads.shortest_move_ms == pytest.approx(1e3 * shortest)
    assert not [word for word in (*found.findings, *found.not_judged) if "rigid" in word.check]
    for model, words in ((changer(120), "with vibration"), (Model(parse(IMPACTS)), "with impacts")):
        loads = judge(model, ["load"]).loads
        assert not loads.rigid
        assert loads.sentence.endswith(words)
    data = compute(rigid, ("checks",), ("load",)).data
    assert data["loads"] == {"rigid": True, "vibration": False, "impacts": False,
                             "shortest_move_ms": pytest.approx(1e3 * shortest)}  # fmt: skip
    assert main(["check", str(PROFILES / "pin_insertion.toml"), "--only", "load"]) == 0
    assert "loads: of a rigid follower; without [dynamics] or [impact]" in capsys.readouterr().out
    assert "Loads: of a rigid follower" in report(rigid, ["checks"], found).summary


def test_without_a_load_nothing_is_said_of_it():
    assert judge(disc(), ["load"]).loads is None
    assert "loads" not in compute(disc(), ("checks",), ("load",)).data
