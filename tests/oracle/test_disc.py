"""Disc cams: the reference disc, every follower against an oracle, what is refused or found."""

from __future__ import annotations

from math import asin, degrees, pi, sqrt

import numpy as np
import pytest

from camgeom.checks import findings
from camgeom.errors import DesignError, ProfileError
from camgeom.model import Model
from camgeom.profile import parse
from camgeom.track.outline import OutlineIntegrals
from tests.oracle.envelope import roller_distance, swept_distance
from tests.reference.planar_machines import HARMONIC, REFERENCE, disc, flat


def judged(model: Model, name: str):
    return next(one for one in findings(model, [name]))


def test_reference_disc() -> None:
    planar = disc().planar
    assert degrees(planar.pressure_angle.value) == pytest.approx(21.223026, abs=5e-7)
    assert planar.radii[0].value + 10.0 == pytest.approx(38.856751, abs=5e-7)
    assert planar.radii[1] is None
    pitch, cam = (OutlineIntegrals(planar.outlines[name]).properties for name in ("pitch curve", "profile"))
    assert pitch.area == pytest.approx(7557.96743, abs=5e-6)
    assert pitch.perimeter == pytest.approx(309.322807, abs=5e-7)
    assert cam.area == pytest.approx(4778.898628, abs=5e-7)
    assert cam.perimeter == pytest.approx(246.490954, abs=5e-7)


def test_harmonic_cam_has_the_closed_form_extremes() -> None:
    """Prime circle as large as the stroke: the pitch curve is an eccentric ellipse-like curve with known extremes."""
    planar = disc("base_radius = 40.8", motion=HARMONIC).planar
    assert degrees(planar.pressure_angle.value) == pytest.approx(degrees(asin(1.0 / 3.0)), abs=1e-9)
    assert planar.radii[0].value + 10.0 == pytest.approx(50.8 * sqrt(2.0), rel=1e-9)


@pytest.mark.parametrize("direction", ["ccw", "cw"])
@pytest.mark.parametrize("offset", [-9, 0, 9])
def test_pressure_angle_has_the_sign_of_offset_and_direction(direction: str, offset: float) -> None:
    model = disc(f'direction = "{direction}"', f'kind = "translating"\noffset = {offset}')
    phi = np.radians(np.linspace(0.0, 359.0, 360))
    s, ds = model.setup.program.jet(phi, 1)
    sense = 1.0 if direction == "ccw" else -1.0
    expected = np.arctan2(ds + sense * offset, sqrt(40.0**2 - offset**2) + s)
    assert model.planar.touches[0].at(phi).pressure_angle == pytest.approx(expected, abs=1e-13)


FOLLOWERS = {
    "offset": ("", 'kind = "translating"\noffset = 9', REFERENCE),
    "left arm": ("center_distance = 100", 'kind = "swinging"\narm = 80', [(150, 18, "3-4-5"), (360, 0, "3-4-5")]),
    "right arm": (
        'center_distance = 100\ndirection = "cw"',
        'kind = "swinging"\narm = 80\nside = "right"',
        [(150, 18, "3-4-5"), (360, 0, "3-4-5")],
    ),
    "groove": ('form = "groove"\ndiameter = 170\ngroove_depth = 7\nbore = 20', 'kind = "translating"', REFERENCE),
}


@pytest.mark.parametrize("name", FOLLOWERS)
def test_rollers_touch_the_solid_all_round(name: str) -> None:
    cam, follower, motion = FOLLOWERS[name]
    model = disc(cam, follower, motion=motion)
    solid, track = model.solid, model.tracks[0]
    assert solid.sound
    mesh = solid.mesh
    ring = mesh.vertices[np.unique(mesh.faces[mesh.group == mesh.groups.index("flank")])][::5]

    def pose(phi):
        found = track.pose(phi.ravel(), 0)
        return tuple(jet[0].T.reshape(*phi.shape, 3) for jet in (found.a, found.u))

    def distance(x, a, u):
        return roller_distance(x, a, u, 10.0, -1e6)

    assert np.abs(swept_distance(ring, pose, distance, 0.0, 2.0 * pi)).max() < 1e-10


def face_lines(model: Model, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Support and azimuth of the face in the machine, without the envelope."""
    s = model.setup.program.jet(phi, 0)[0]
    if model.setup.follower.kind == "translating":
        return 30.0 + s, np.zeros_like(s)
    beta = np.arccos((30.0 + model.setup.follower.face_offset) / 100.0) - s
    return 100.0 * np.cos(beta) - model.setup.follower.face_offset, beta


@pytest.mark.parametrize(("kind", "offset"), [("translating", 0), ("swinging", 0), ("swinging", 6)])
def test_flat_faces_touch_the_solid_all_round(kind: str, offset: float) -> None:
    gentle = [(160, 8, "3-4-5"), (360, 0, "3-4-5")]
    swing = kind == "swinging"
    cam = "center_distance = 100" if swing else ""
    model = flat(kind, cam, f"face_offset = {offset}" if swing else "", gentle)
    solid = model.solid
    assert solid.sound
    ring = solid.mesh.vertices[:, :2]
    phi = np.linspace(0.0, 2.0 * pi, 721)
    support, azimuth = face_lines(model, phi)
    n = np.stack([np.cos(azimuth - phi), np.sin(azimuth - phi)])
    gap = support - (ring @ n).max(axis=0)
    assert gap.min() > -1e-10
    assert gap.max() < 2.0 * solid.chord_error


def test_curved_face_is_a_large_roller_that_does_not_roll() -> None:
    model = disc("", 'kind = "translating"\nface = "curved"\nface_radius = 60', "", rest="[operation]\nspeed = 100")
    assert model.planar.sliding is not None
    assert not model.duties
    assert model.drive is not None
    assert model.planar.touches[0].at(np.zeros(1)).relative == pytest.approx(1.0 / 30.0 + 1.0 / 60.0)


def test_knife_edge_runs_on_its_own_pitch_curve() -> None:
    model = disc("", 'kind = "translating"\nface = "knife"', "", rest="[operation]\nspeed = 100\nspring_preload = 50")
    phi = np.radians([0.0, 60.0, 135.0])
    reach = np.hypot(*model.planar.touches[0].at(phi).curve.points)
    assert reach == pytest.approx(30.0 + model.setup.program.jet(phi, 0)[0], abs=1e-12)
    assert model.drive.peak_pressure is None
    assert model.solid.sound


@pytest.mark.parametrize(("base", "good"), [(11.0, True), (8.0, False)])
def test_flat_face_folds_below_a_base_radius(base: float, good: bool) -> None:
    model = flat(cam=f"base_radius = {base}")
    finding = judged(model, "face-curvature")
    s, _, dds = model.setup.program.jet(np.linspace(0.0, 2.0 * pi, 200_001), 2)
    assert finding.value == pytest.approx(base + (s + dds).min(), abs=1e-6)
    assert finding.passed is good
    if good:
        assert model.solid.sound
        return
    assert f"more than {-finding.value:.6g} mm" in finding.advice
    with pytest.raises(DesignError, match="folds at cam angle"):
        _ = model.solid


def test_face_too_narrow_is_found() -> None:
    needed = judged(flat(follower="face_width = 200"), "face-width").limit
    velocity = flat().setup.program.peak(1).value
    assert needed == pytest.approx(2.0 * abs(velocity), rel=1e-12)
    assert judged(flat(follower=f"face_width = {1.001 * needed}"), "face-width").passed
    narrow = judged(flat(follower=f"face_width = {0.999 * needed}"), "face-width")
    assert not narrow.passed
    assert f"{needed:.6g} mm" in narrow.advice


def test_undercut_is_found_and_has_no_solid() -> None:
    steep = [(40, 20, "cycloidal"), (360, 0, "cycloidal")]
    model = disc("base_radius = 12", motion=steep)
    assert not judged(model, "undercut").passed
    assert not judged(model, "self-crossing").passed
    with pytest.raises(DesignError, match="undercut"):
        _ = model.solid


def test_impossible_mechanisms_are_refused() -> None:
    with pytest.raises(ProfileError, match="between 20 and 180 mm"):
        disc("center_distance = 100\nbase_radius = 5", 'kind = "swinging"\narm = 80')
    with pytest.raises(ProfileError, match="comes into line"):
        disc("center_distance = 100", 'kind = "swinging"\narm = 80', motion=[(150, 170, "3-4-5"), (360, 0, "3-4-5")])
    with pytest.raises(ProfileError, match="below the prime radius"):
        disc("", 'kind = "translating"\noffset = 45')


@pytest.mark.parametrize("name", ["offset", "left arm"])
def test_a_groove_must_stay_inside_its_plate(name: str) -> None:
    cam, follower, motion = FOLLOWERS[name]
    groove = f'form = "groove"\ngroove_depth = 7\n{cam}\n'
    with pytest.raises(ProfileError, match="so that the groove is inside") as refused:
        disc(f"{groove}diameter = 100", follower, motion=motion)
    (problem,) = refused.value.problems
    least = float(problem.allowed.split()[1])
    outer = disc(f"{groove}diameter = {least + 0.01}", follower, motion=motion).planar.outlines["outer flank"]
    reach = np.hypot(*outer.curve(np.linspace(0.0, 2.0 * pi, 7201)).points).max()
    assert 2.0 * reach == pytest.approx(least, rel=1e-3)


def test_a_peak_at_a_joint_is_exact_to_rounding() -> None:
    # The parabolic law's velocity has its corner, and the pressure angle its peak, half way of the rise.
    model = Model(
        parse(
            '[cam]\nkind = "disc"\nbase_radius = 40\nwidth = 12\n[follower]\nkind = "translating"\noffset = 7\n'
            '[roller]\ndiameter = 20\nlength = 9\n[[motion]]\nuntil = 100\nto = 12\nlaw = "parabolic"\n'
            '[[motion]]\nuntil = 150\n[[motion]]\nuntil = 290\nto = 0\nlaw = "parabolic"\n[[motion]]\nuntil = 360\n'
        )
    )
    slope, height = 24.0 / np.radians(100.0), 6.0 + np.sqrt(50.0**2 - 7.0**2)
    assert model.pressure_angle.value == pytest.approx(np.arctan((slope + 7.0) / height), rel=2e-14)
    assert model.pressure_angle.cam_angle == pytest.approx(np.radians(50.0), abs=1e-13)
