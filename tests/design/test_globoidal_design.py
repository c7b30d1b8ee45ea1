"""The design procedure of globoidal drives: what it chooses passes the checks, and what it cannot do it says."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from camgeom.cli import main
from camgeom.design.globoidal import ROLLERS, Wanted, design
from camgeom.errors import DesignError, ProfileError
from camgeom.mechanics.grades import MATERIALS, material_for
from camgeom.model import Model
from camgeom.profile import parse

USUAL = Wanted(8, 120.0, 100.0, 0.5, 10.0, 20000.0, center_distance=180.0)


@pytest.mark.parametrize(
    ("changes", "law", "form"),
    [
        ({}, "modified-sine", "rib"),
        ({"stops": 4, "motion_angle": 180.0, "center_distance": None, "envelope": 400.0}, "modified-sine", "rib"),
        ({"stops": 24, "center_distance": 220.0, "speed": 60.0}, "modified-sine", "groove"),
        ({"stops": 6, "motion_angle": 150.0, "speed": 20.0, "torque": 300.0}, "modified-constant-velocity", "rib"),
    ],
)
def test_design_passes_its_checks(changes, law, form):
    wanted = replace(USUAL, **changes)
    found = design(wanted)
    assert all(f.passed for f in found.findings)
    profile = parse(found.text)
    assert profile.motion[1].law == law
    assert profile.cam.form == form
    assert profile.roller.diameter in {size.diameter for size in ROLLERS}
    assert all(choice.why for choice in found.choices)
    if wanted.envelope:
        cam, setup = profile.cam, profile.setup()
        outer = setup.follower.pitch_radius + 0.5 * setup.roller.length
        assert cam.globoid.end_radius + cam.center_distance + outer <= 1.03 * wanted.envelope
    duty = Model(profile).turret_duty
    assert duty.peak_pressure.value <= profile.material.cam.contact_limit
    assert min(duty.cam_life, duty.roller_life) >= wanted.life


def test_unreachable_pressure_angle_names_the_angle_that_would_do():
    with pytest.raises(DesignError, match=r"motion angle of at least 1\d\d"):
        design(replace(USUAL, stops=3, motion_angle=40.0))
    least = 120.0 * 1.76 * 0.3 / 0.7 / 0.8391
    assert design(replace(USUAL, stops=3, motion_angle=least + 15.0, torque=0.0)).findings


def test_wrong_input_is_refused_all_at_once():
    with pytest.raises(ProfileError) as refused:
        design(replace(USUAL, stops=0, speed=-1.0, center_distance=None))
    assert len(refused.value.problems) == 3
    assert "1 to 48" in str(refused.value)


def test_overload_is_said_with_its_reason():
    with pytest.raises(DesignError, match=r"turret-(life|pressure)"):
        design(replace(USUAL, inertia=400.0, speed=300.0))


def test_materials_follow_the_load_classes():
    assert material_for(500.0, 0.4).hardness == 30.0
    assert material_for(500.0, 1.4).hardness == 52.0
    assert material_for(999.0, 0.4) == MATERIALS[1]
    assert material_for(1001.0, 0.4) == MATERIALS[2]
    assert material_for(1301.0, 0.4) is None


@pytest.mark.parametrize("name", ["six", 'a "b" c:\\d', "\u4e2d\u6587"])
def test_command_writes_a_profile_that_parses(name, tmp_path, capsys):
    file = tmp_path / "d.toml"
    line = ["design", "globoidal", str(file), "--stops", "6", "--ratio", "0.8", "--center-distance", "180", "--json"]
    line += ["--name", name]
    assert main(line) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["choices"][0]["what"] == "motion law"
    assert file.read_text() == data["profile"]
    assert parse(file.read_text()).follower.stops == 6
    assert parse(file.read_text()).name == name


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--stops", "6", "--center-distance", "180"], "--motion-angle or --ratio"),
        (["--stops", "6.5", "--ratio", "1", "--center-distance", "180"], "whole number"),
        (["--stops", "6", "--ratio", "1", "--center-distance", "180", "--name", "a\x7fb"], "can be shown"),
        (["--stops", "6", "--ratio", "1", "--center-distance", "180", "--name", " "], "can be shown"),
        (["--stops", "6", "--ratio", "x", "--center-distance", "180"], "needs a number"),
        (["--stops", "6", "--ratio", "1"], "center-distance"),
    ],
)
def test_command_refuses_in_one_line(words, said, capsys):
    assert main(["design", "globoidal", *words]) == 2
    shown = capsys.readouterr()
    assert said in shown.err
    assert shown.out == ""


def test_law_by_name_or_by_the_accuracy_in_the_dwell():
    named = design(replace(USUAL, law="cycloidal"))
    assert parse(named.text).motion[1].law == "cycloidal"
    assert named.choices[0].why.startswith("given")
    assert parse(design(replace(USUAL, accurate_dwell=True)).text).motion[1].law == "universal-asymmetric"
    for changes in ({"law": "parabolic"}, {"law": "nonsense"}, {"law": "cycloidal", "accurate_dwell": True}):
        with pytest.raises(ProfileError, match="--law"):
            design(replace(USUAL, **changes))


def test_one_stop_takes_a_cam_of_several_starts():
    found = design(replace(USUAL, stops=1, motion_angle=330.0, center_distance=250.0, pressure_angle=65.0, torque=0.0))
    assert all(f.passed or f.status == "warn" for f in found.findings)
    profile = parse(found.text)
    assert (profile.follower.stops, profile.follower.count) == (1, 6)
    with pytest.raises(ProfileError, match=r"follower\.rollers"):
        parse(found.text.replace("rollers = 6\n", ""))
