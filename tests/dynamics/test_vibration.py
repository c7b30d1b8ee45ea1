"""Dynamics wired to a profile: each kind of drive from a profile's own geometry, and plain refusals."""

from __future__ import annotations

import numpy as np
import pytest

from camgeom.errors import ExportError, ProfileError
from camgeom.export import write
from camgeom.model import Model
from camgeom.profile import parse
from camgeom.report.result import compute
from tests.places import PROFILES
from tests.reference.planar_machines import ELASTIC

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


def plain(profile):
    """A shipped profile without its own tables of dynamics."""
    text = (PROFILES / f"{profile}.toml").read_text()
    for table in ("[dynamics]", "[impact]"):
        head, _, rest = text.partition(table)
        text = head + rest.partition("\n\n")[2]
    return text


def solved(profile, extra, change=("", "")):
    model = Model(parse(plain(profile).replace(*change) + extra))
    return compute(model, ("dynamics",)).data["dynamics"]


def test_indexing_drive_from_a_profile():
    found = solved("tool_changer", DRIVE, ("inertia = 1.1", "inertia = 0.0635"))
    assert 200.0 < found["first_frequency_hz"] < 265.6
    assert found["indefinite_blocks"] == []
    assert found["amplification"] > 1.0


def test_elastic_follower_from_a_profile():
    text = '\n[dynamics]\nkind = "follower"\nlinkage_stiffness = 20000\nlinkage_damping = 200\n'
    found = solved("disc_offset_roller", text)
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
    ],
)
def test_dynamics_that_do_not_apply_are_refused(profile, extra, word):
    with pytest.raises(ProfileError, match=word):
        solved(profile, extra)


def test_a_groove_without_a_clearance_has_no_impacts():
    text = (PROFILES / "pin_insertion.toml").read_text() + "\n[impact]\nturns = 2\n"
    with pytest.raises(ProfileError, match=r"impact\.clearance: is missing"):
        parse(text)
    assert parse(text + "clearance = 0.02\n")


def test_uneven_speed_and_exact_contact_from_a_profile():
    plain, uneven, exact = (
        solved("tool_changer", DRIVE + extra, ("inertia = 1.1", "inertia = 0.0635"))
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
    # friction and the press make it ring; the rigid follower needs at least 87.6 N
    assert found["sweep"]["least_contact_force_n"] == pytest.approx([86.8, 86.8, 86.8], abs=0.1)


def test_impacts_laws_and_clearances_of_a_profile_in_one_call():
    """At 0.1 mm the modified trapezoid hits harder than 3-4-5 with a line contact; every peak with its convergence."""
    text = '\n[impact]\nturns = 2\ntolerance = 1e-7\nstudy = [0.05, 0.1]\nlaws = ["3-4-5", "modified-trapezoid"]\n'
    found = solved("conjugate_rocker", text)["impact"]
    polynomial, trapezoid = found["laws"]
    assert (polynomial["label"], trapezoid["label"]) == ("3-4-5", "modified-trapezoid")
    peak = "peak_acceleration_rad_s2"
    assert polynomial[peak]["mean"] == pytest.approx(15409.0, rel=0.02)
    assert trapezoid[peak]["mean"] == pytest.approx(19254.0, rel=0.02)
    assert trapezoid["ideal_acceleration_rad_s2"] == pytest.approx(5415.51, rel=1e-4)
    assert [row["clearance_mm"] for row in found["study"]] == pytest.approx([0.05, 0.1])
    for row in (found["over_turns"], *found["study"], *found["laws"]):
        assert row["tighter_change"] < 1e-4
        assert row["energy_residual"] < 1e-6
    assert found["over_turns"][peak] == polynomial[peak]
    assert [hit["cam_angle_deg"] for hit in found["impacts"] if hit["converts"]] == found["conversions_deg"]
    assert found["impacts"][0]["energy_j"] > 0.0
    assert found["peak_jerk_rad_s3"] > 0.0
    assert found["friction_work_j"] == [0.0, 0.0]


SLIDE = """
name = "slide between two discs"
[cam]
kind = "conjugate"
base_radius = 60
width = 15
direction = "{direction}"
[follower]
kind = "translating"
mass = 3
offset = {offset}
clearance = 0.05
[roller]
diameter = 24
length = 15
[[motion]]
until = 120
to = 20
law = "3-4-5"
[[motion]]
until = 240
to = 0
law = "3-4-5"
[[motion]]
until = 360
[operation]
speed = 500
[impact]
turns = 2
tolerance = 1e-7
"""


def test_a_slide_between_two_discs_and_its_mirror_image():
    texts = [SLIDE.format(direction=way, offset=offset) for way, offset in (("ccw", 6), ("cw", -6), ("ccw", -6))]
    rows = [compute(Model(parse(text)), ("dynamics",)).data["dynamics"]["impact"] for text in texts]
    peaks = [row["over_turns"]["peak_acceleration_m_s2"]["mean"] for row in rows]
    assert peaks[0] > rows[0]["over_turns"]["ideal_acceleration_m_s2"]
    assert peaks[1] == pytest.approx(peaks[0], rel=1e-9)
    assert peaks[2] != pytest.approx(peaks[0], rel=1e-6)
    assert rows[0]["over_turns"]["energy_residual"] < 1e-6


def test_rockers_on_either_side_and_their_mirror_images():
    text = plain("conjugate_rocker") + "\n[impact]\nturns = 2\n"

    def impact(side, direction):
        changed = text.replace("arm = 90", f'arm = 90\nside = "{side}"')
        changed = changed.replace('direction = "ccw"', f'direction = "{direction}"')
        return compute(Model(parse(changed)), ("dynamics",)).data["dynamics"]["impact"]

    ahead, behind = impact("left", "ccw"), impact("right", "ccw")
    assert ahead == impact("right", "cw")
    assert behind == impact("left", "cw")
    assert ahead["conversions_deg"][:2] == pytest.approx([40.57, 110.45], abs=0.05)
    assert behind["conversions_deg"][:2] != pytest.approx(ahead["conversions_deg"][:2], abs=1e-3)
    assert behind["over_turns"]["energy_residual"] < 1e-6


def test_laws_of_a_groove_are_cut_anew():
    text = '\n[impact]\nclearance = 0.02\nturns = 2\ntolerance = 1e-6\nlaws = ["cycloidal", "modified-sine"]\n'
    found = solved("pin_insertion", text)["impact"]
    same, other = found["laws"]
    assert same["peak_acceleration_m_s2"] == found["over_turns"]["peak_acceleration_m_s2"]
    assert other["ideal_acceleration_m_s2"] < same["ideal_acceleration_m_s2"]


def test_polydyne_cam_of_a_profile(tmp_path):
    """On the corrected cam the mass does what is wanted; on the plain one it vibrates. Both by integration."""
    model = Model(parse(ELASTIC.format(law="5-6-7-8-9")))
    found = compute(model, ("dynamics",)).data["dynamics"]["polydyne"]
    assert found["follower_miss"] < 1e-7
    assert found["follower_miss_uncorrected"] > 1e-2
    # the return spring bends the linkage by its share of the stiffness
    assert found["coefficients"][0] == pytest.approx(1.0 + 20.0 / 400.0)
    write(model, tmp_path / "cam.polydyne.csv")
    angle, lift = np.loadtxt(tmp_path / "cam.polydyne.csv", delimiter=",", skiprows=1).T
    assert lift[np.searchsorted(angle, 120.0)] == pytest.approx(12.0 * 1.05, rel=1e-12)
    assert np.ptp(lift) == pytest.approx(1e3 * found["cam_stroke_m"], rel=1e-4)


def test_polydyne_needs_a_smooth_motion_and_an_elastic_follower(tmp_path):
    with pytest.raises(ProfileError, match=r"dynamics\.polydyne: .* 3 continuous derivatives"):
        parse(ELASTIC.format(law="cycloidal"))
    rough = Model(parse(ELASTIC.format(law="cycloidal").replace("polydyne = true", "")))
    with pytest.raises(ExportError, match="3 continuous derivatives"):
        write(rough, tmp_path / "cam.polydyne.csv")
    with pytest.raises(ExportError, match="elastic follower"):
        write(Model(parse((PROFILES / "disc_flat_face.toml").read_text())), tmp_path / "cam.polydyne.csv")
