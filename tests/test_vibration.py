"""Dynamics wired to a profile: each kind of drive from a profile's own geometry, and plain refusals."""

from __future__ import annotations

from pathlib import Path

import pytest

from camgeom.errors import ProfileError
from camgeom.job import compute
from camgeom.model import Model
from camgeom.profile import parse

PROFILES = Path(__file__).resolve().parents[1] / "profiles"

DRIVE = """
[dynamics]
kind = "indexing"
cam_inertia = 0.07
turret_inertia = 0.0035
load_inertia = 0.06
input_stiffness = 194870
output_stiffness = 350210
contact_stiffness = 1232900
input_damping = 7.0
output_damping = 8.7
contact_damping = 3.9
"""


def solved(profile, extra):
    head, _, rest = (PROFILES / f"{profile}.toml").read_text().partition("[dynamics]")
    model = Model(parse(head + rest.partition("\n\n")[2] + extra))
    return compute(model, ("dynamics",)).data["dynamics"]


def test_indexing_drive_from_a_profile():
    found = solved("tool_changer", DRIVE)
    assert 200.0 < found["first_frequency_hz"] < 265.6
    assert found["indefinite_blocks"] == []
    assert found["amplification"] > 1.0


def test_elastic_follower_from_a_profile():
    found = solved("disc_offset_roller", '\n[dynamics]\nkind = "follower"\nlinkage_stiffness = 20000\n')
    assert found["contact_lost"] is False
    assert found["frequencies_hz"][0] == pytest.approx(750.357, abs=1e-3)


def test_conjugate_rocker_converts_in_rise_and_return():
    """Mechanism B1 with 0.1 mm of play: the drive passes over at 40.57 and 110.45 deg (Hertz)."""
    found = solved("conjugate_rocker", "\n[impact]\nturns = 2\nsettle = 1\n")["impact"]
    first = found["conversions_deg"][:2]
    assert first == pytest.approx([40.57, 110.45], abs=0.05)


def test_frame_and_groove_have_play_too():
    frame = solved("constant_width_press", "\n[impact]\nturns = 2\n")["impact"]
    assert frame["over_turns"]["clearance_mm"] == pytest.approx(0.02)
    groove = solved("pin_insertion", "\n[impact]\nclearance = 0.02\nturns = 2\n")["impact"]
    assert groove["over_turns"]["amplification"] > 1.0


@pytest.mark.parametrize(
    ("profile", "extra", "word"),
    [
        ("disc_offset_roller", DRIVE, "needs a turret"),
        ("tool_changer", '\n[dynamics]\nkind = "follower"\nlinkage_stiffness = 20000\n', "turret"),
        ("disc_offset_roller", "\n[impact]\nclearance = 0.1\n", "both ways"),
        ("pin_insertion", "\n[impact]\nturns = 2\n", "clearance"),
    ],
)
def test_dynamics_that_do_not_apply_are_refused(profile, extra, word):
    with pytest.raises(ProfileError, match=word):
        solved(profile, extra)


def test_uneven_speed_and_exact_contact_from_a_profile():
    plain, uneven, exact = (
        solved("tool_changer", DRIVE + extra)
        for extra in ("", "fluctuation = 0.05\nfluctuation_order = 2\n", "exact_contact = true\n")
    )
    key = "peak_load_acceleration_rad_s2"
    assert abs(uneven[key] / plain[key] - 1.0) > 1e-3
    assert 1e-9 < abs(exact[key] / plain[key] - 1.0) < 1e-3


def test_windup_and_sweep_of_a_follower_from_a_profile():
    text = '\n[dynamics]\nkind = "follower"\nlinkage_stiffness = 20000\nlinkage_damping = 200\nsweep = [100, 200]\n'
    found = solved("disc_offset_roller", text + "sweep_points = 3\nshaft_inertia = 2e-3\nshaft_stiffness = 2e4\n")
    assert found["peak_windup_deg"] > 0.0
    assert found["peak_shaft_torque_n_m"] > 0.0
    assert found["sweep"]["speed_rpm"] == pytest.approx([100.0, 150.0, 200.0])
    forces = found["sweep"]["least_contact_force_n"]
    assert forces == sorted(forces, reverse=True)
