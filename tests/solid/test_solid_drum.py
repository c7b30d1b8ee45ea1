"""Solids of cylindrical cams: chord error by an oracle that knows only roller positions, closedness, genus, volume."""

from __future__ import annotations

import numpy as np
import pytest

from camgeom.errors import DesignError
from camgeom.solid.cut import CutBlank
from camgeom.solid.drum import GroovedCylinder, RibbedCylinder
from camgeom.track.clearance import least_clearance
from camgeom.track.follower import ConeRoller, CrownedRoller, CylinderRoller, Setup, SphereRoller, TranslatingFollower
from tests.oracle.envelope import roller_distance, swept_distance, triangle_points
from tests.reference.machines import gentle_program, pin_cam, pin_setup, program, swinging_cam, swinging_setup

TURN = 2.0 * np.pi


def translating_pose(motion, start, sense=1.0):
    """Roller axis of a translating radial roller, from the machine's description."""

    def pose(phi):
        s = motion.jet(np.ravel(phi), 0)[0].reshape(np.shape(phi))
        zero = np.zeros_like(s)
        a = np.stack([zero, zero, start + s], -1)
        return a, np.stack([np.cos(phi), -sense * np.sin(phi), zero], -1)

    return pose


def swinging_pose(motion, start, arm, psi0, distance):
    """Roller axis of a follower that swings in the tangent plane: arm angle psi0 + lift from the tangent."""

    def pose(phi):
        psi = psi0 + motion.jet(np.ravel(phi), 0)[0].reshape(np.shape(phi))
        y = distance - arm * np.cos(psi)
        z = start - arm * np.sin(psi0) + arm * np.sin(psi)
        a = np.stack([y * np.sin(phi), y * np.cos(phi), z], -1)
        return a, np.stack([np.cos(phi), -np.sin(phi), np.zeros_like(z)], -1)

    return pose


def errors(mesh, pose, distance, names, per_face=5, most=900, seed=0):
    """Signed deviations of triangles in the named groups: (largest at vertices, smallest and largest inside)."""
    rng = np.random.default_rng(seed)
    faces = np.concatenate([mesh.faces[mesh.group_faces(name)] for name in names])
    faces = faces[rng.choice(len(faces), min(most, len(faces)), replace=False)]
    inside = swept_distance(triangle_points(mesh.vertices, faces, per_face), pose, distance, 0.0, TURN, coarse=720)
    corners = swept_distance(mesh.vertices[np.unique(faces)[:most]], pose, distance, 0.0, TURN, coarse=720)
    return np.abs(corners).max(), inside.min(), inside.max()


@pytest.mark.parametrize("tolerance", [0.1, 0.01, 0.001, 0.0001])
def test_error_is_within_tolerance_and_not_far_below(tolerance):
    cam = pin_cam()
    solid = cam.mechanism(pin_setup()).parts[0].solid(tolerance)
    assert solid.method == "direct"
    assert solid.sound
    distance = lambda x, a, u: roller_distance(x, a, u, 11.0, 54.0)  # noqa: E731
    pose = translating_pose(pin_setup().program, 18.0)
    most = 700 if tolerance >= 0.001 else 400
    corner, low, high = errors(solid.mesh, pose, distance, ("flank", "edge", "floor"), most=most)
    assert corner < 1e-11
    assert max(-low, high) <= tolerance
    assert max(-low, high) > 0.4 * tolerance
    assert solid.chord_error <= tolerance


def test_volume_converges_at_second_order():
    part = pin_cam(keyway_width=12.0, keyway_depth=3.3).mechanism(pin_setup()).parts[0]
    volumes = [part.solid(t).mesh.volume for t in (0.016, 0.004, 0.001, 0.00025)]
    steps = np.diff(volumes)
    ratios = steps[:-1] / steps[1:]
    assert np.all((ratios > 3.0) & (ratios < 5.5))


SHAPES = {
    "cone": (ConeRoller(shape="cone", diameter=20.0, length=10.0, half_angle=9.0), 11.0),
    "crowned": (
        CrownedRoller(shape="crowned", diameter=20.0, length=10.0, crown_radius=150.0, flank="conforming"), 11.0
    ),
    "crowned, straight flank": (
        CrownedRoller(shape="crowned", diameter=20.0, length=10.0, crown_radius=150.0, flank="straight"), 11.0
    ),
    "sphere": (SphereRoller(shape="sphere", diameter=20.0), 9.5),
    "cylinder": (CylinderRoller(diameter=20.0, length=10.0), 11.0),
}


def oracle_shape(track):
    m = track.meridian
    if hasattr(m, "arc"):
        kind = "sphere" if m.arc == m.radius else "crowned"
        return m.radius, (kind, m.arc, m.centre)
    return m.radius, ("straight", m.slope, m.centre)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("direction", ["ccw", "cw"])
def test_every_roller_shape_translating(shape, direction):
    roller, depth = SHAPES[shape]
    cam = pin_cam(groove_depth=depth, pitch_radius=None, direction=direction, length=80.0, start=20.0)
    setup = Setup(TranslatingFollower(), roller, gentle_program())
    track = cam.mechanism(setup).cutters[0]
    solid = cam.mechanism(setup).parts[0].solid(0.01)
    assert solid.sound
    radius, form = oracle_shape(track)
    distance = lambda x, a, u: roller_distance(x, a, u, radius, track.tip, shape=form)  # noqa: E731
    sense = 1.0 if direction == "ccw" else -1.0
    names = ("flank",) if shape == "sphere" else ("flank", "edge", "floor")
    corner, low, high = errors(solid.mesh, translating_pose(setup.program, 20.0, sense), distance, names, most=400)
    assert corner < 1e-9
    assert 0.004 < max(-low, high) <= 0.01


@pytest.mark.parametrize("shape", SHAPES)
def test_every_roller_shape_swinging(shape):
    roller, depth = SHAPES[shape]
    setup, cam = swinging_setup(roller), swinging_cam(groove_depth=depth)
    track = cam.mechanism(setup).cutters[0]
    solid = cam.mechanism(setup).parts[0].solid(0.01)
    assert solid.sound
    radius, form = oracle_shape(track)
    distance = lambda x, a, u: roller_distance(x, a, u, radius, track.tip, shape=form)  # noqa: E731
    pose = swinging_pose(setup.program, 26.0, 90.0, np.radians(-12.0), track.joint.centre[1])
    names = ("flank",) if shape == "sphere" else ("flank", "edge", "floor")
    corner, low, high = errors(solid.mesh, pose, distance, names, most=400)
    assert corner < 1e-9
    assert max(-low, high) <= 0.01


def test_boolean_agrees_with_the_direct_mesh():
    cam, setup = pin_cam(keyway_width=12.0, keyway_depth=3.3), pin_setup()
    direct = cam.mechanism(setup).parts[0]
    assert isinstance(direct, GroovedCylinder)
    from camgeom.track.column import cylinder_level

    cut = CutBlank("cam", (direct.track,), direct.blank, cylinder_level(70.0), 70.0, 76.0, 1)
    one, other = direct.solid(0.002), cut.solid(0.002)
    assert other.sound
    assert other.mesh.volume == pytest.approx(one.mesh.volume, rel=3e-5)
    assert set(other.mesh.groups) == set(one.mesh.groups)
    fine = direct.solid(0.0002).mesh.volume
    assert abs(other.mesh.volume - fine) < 0.002 * direct.solid(0.002).mesh.area


@pytest.mark.parametrize("bore", [0.0, 30.0])
def test_groove_that_runs_out_of_an_end(bore):
    cam = pin_cam(length=80.0, start=6.0, bore=bore, pitch_radius=None)
    setup = pin_setup(motion=gentle_program())
    part = cam.mechanism(setup).parts[0]
    assert isinstance(part, CutBlank)
    solid = part.solid(0.01)
    assert solid.sound
    distance = lambda x, a, u: roller_distance(x, a, u, 11.0, 54.0)  # noqa: E731
    corner, low, high = errors(
        solid.mesh, translating_pose(setup.program, 6.0), distance, ("flank", "edge", "floor"), most=400
    )
    assert max(-low, high, corner) <= 0.01


def test_rib_stands_between_its_rollers():
    cam = pin_cam(form="rib", rib_thickness=14.0, start=40.0, length=100.0, keyway_width=12.0, keyway_depth=3.3)
    setup = pin_setup(motion=gentle_program())
    part = cam.mechanism(setup).parts[0]
    assert isinstance(part, RibbedCylinder)
    solid = part.solid(0.01)
    assert solid.sound
    mesh = solid.mesh
    for offset in (-18.0, 18.0):
        pose = translating_pose(setup.program, 40.0 + offset)
        distance = lambda x, a, u: roller_distance(x, a, u, 11.0, 40.0)  # noqa: E731
        top = mesh.vertices[np.unique(mesh.faces[mesh.group_faces("land")])]
        found = swept_distance(top, pose, distance, 0.0, TURN)
        assert found.min() > -1e-9
        assert np.sort(np.abs(found))[10] < 1e-9
    dwell = mesh.vertices[np.unique(mesh.faces[mesh.group_faces("land")])]
    azimuth = np.degrees(np.arctan2(-dwell[:, 1], dwell[:, 0])) % 360.0
    still = dwell[(azimuth > 285.0) & (azimuth < 340.0)]
    assert np.ptp(still[:, 2]) == pytest.approx(14.0, abs=1e-9)


def test_running_clearance_is_the_gap():
    cam, setup = pin_cam(running_clearance=0.02), pin_setup()
    mesh = cam.mechanism(setup).parts[0].solid(0.01).mesh
    found = least_clearance(cam.mechanism(setup).tracks[0], mesh.vertices)
    assert found.value == pytest.approx(0.02, abs=1e-9)


@pytest.mark.parametrize(("grow", "clear"), [(0.0, True), (0.001, False), (-0.001, True)])
def test_interference_bites_at_one_micrometre(grow, clear):
    cam, setup = pin_cam(), pin_setup()
    mesh = cam.mechanism(setup).parts[0].solid(0.005).mesh
    found = least_clearance(cam.mechanism(setup).tracks[0], mesh.vertices, grow=grow)
    assert found.value == pytest.approx(-grow, abs=1e-9)
    assert (found.value >= -1e-7) is clear


def test_rib_that_leaves_the_drum_is_refused():
    cam = pin_cam(form="rib", rib_thickness=14.0, start=5.0, length=60.0)
    with pytest.raises(DesignError, match="runs out"):
        cam.mechanism(pin_setup(motion=gentle_program())).parts[0].solid(0.05)


def test_dwell_only_groove_is_a_ring():
    """A groove with no motion is a plain ring groove whose volume is known in closed form."""
    setup = Setup(TranslatingFollower(), CylinderRoller(diameter=20.0, length=10.0), program((360, None, None)))
    cam = pin_cam(start=50.0, groove_depth=13.0, bore=0.0)
    fine, coarse = (cam.mechanism(setup).parts[0].solid(t).mesh.volume for t in (1e-4, 4e-4))
    exact = np.pi * 67.0**2 * 110.0 - np.pi * (67.0**2 - 54.0**2) * 20.0
    assert fine + (fine - coarse) / 3.0 == pytest.approx(exact, rel=1e-8)
