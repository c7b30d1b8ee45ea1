"""Conjugate pairs: mechanism B1, the slide, what cannot be assembled, the solids measured by the oracle."""

from __future__ import annotations

from math import degrees, pi, radians

import numpy as np
import pytest

from camgeom.cams import starter
from camgeom.errors import DesignError, ProfileError
from camgeom.model import Model
from camgeom.profile import parse
from camgeom.track.pair import PairErrors, pair_residual
from tests.oracle.envelope import roller_distance, swept_distance, triangle_points
from tests.reference.planar_machines import b1

SLIDE = """
name = "slide"
[cam]
kind = "conjugate"
base_radius = 40
width = 12
[follower]
kind = "translating"
mass = 2
offset = {offset}
[roller]
diameter = 24
length = 12
[[motion]]
until = 120
to = 20
law = "cycloidal"
[[motion]]
until = 180
[[motion]]
until = 300
to = 0
law = "modified-sine"
[[motion]]
until = 360
"""


def test_b1_has_the_published_curvatures_and_angles() -> None:
    model = b1()
    assert degrees(model.mechanism.angle_between) == pytest.approx(107.053723248926, abs=1e-12)
    phi = np.radians(np.linspace(0.0, 360.0, 7201))
    for touch in model.mechanism.touches:
        found = touch.at(phi)
        radius = 1.0 / found.curve.curvature + 20.0
        assert radius[radius > 0.0].min() == pytest.approx(102.909, abs=1e-3)
        assert radius[radius < 0.0].max() == pytest.approx(-3658.2, abs=0.1)
        assert np.degrees(np.abs(found.pressure_angle)).max() == pytest.approx(33.0, abs=0.05)


@pytest.mark.parametrize("direction", ["ccw", "cw"])
def test_rollers_touch_the_solids_all_round(direction: str) -> None:
    model = b1(cam=f'direction = "{direction}"', tolerance=0.02)
    for solid, track in zip(model.solids, model.tracks):
        mesh = solid.mesh
        assert solid.sound
        wall = mesh.faces[mesh.group == mesh.groups.index("flank")][::7]
        points = mesh.vertices[np.unique(wall)]

        def pose(phi, track=track):
            found = track.pose(phi.ravel(), 0)
            return tuple(jet[0].T.reshape(*phi.shape, 3) for jet in (found.a, found.u))

        def distance(x, a, u):
            return roller_distance(x, a, u, 20.0, -1e6)

        assert np.abs(swept_distance(points, pose, distance, 0.0, 2.0 * pi)).max() < 1e-10
        inside = swept_distance(triangle_points(mesh.vertices, wall[::5], 3), pose, distance, 0.0, 2.0 * pi)
        assert inside.min() > -1e-10
        assert inside.max() < solid.chord_error + 1e-9


@pytest.mark.parametrize("offset", [0, 12, -12])
def test_slide_rollers_keep_their_distance(offset: float) -> None:
    model = Model(parse(SLIDE.format(offset=offset)))
    phi = np.linspace(0.0, 2.0 * pi, 181)
    main, back = (track.pose(phi, 0).a[0] for track in model.tracks)
    distance = np.sqrt(((main - back) ** 2).sum(axis=0))
    assert np.ptp(distance) < 1e-12
    assert all(solid.sound for solid in model.solids)


def test_mechanisms_that_cannot_be_assembled_are_refused() -> None:
    with pytest.raises(ProfileError, match=r"between 115 and 295 mm"):
        b1(base=79.5)
    with pytest.raises(ProfileError, match=r"rocker_angle"):
        b1(cam="rocker_angle = 30")
    with pytest.raises(ProfileError, match=r"comes into line"):
        parse(starter("conjugate").replace("to = 24", "to = 140"))


def test_phase_mark_goes_through_both_discs() -> None:
    model = b1(cam="mark_diameter = 6\nmark_radius = 70")
    for solid in model.solids:
        assert solid.mesh.genus == 2
        mark = solid.mesh.vertices[np.unique(solid.mesh.faces[solid.mesh.group == solid.mesh.groups.index("mark")])]
        assert np.hypot(mark[:, 0], mark[:, 1] + 70.0) == pytest.approx(3.0, abs=1e-12)
    with pytest.raises(ProfileError, match=r"between 33 and 127 mm"):
        b1(cam="mark_diameter = 6\nmark_radius = 128")


PHI = np.linspace(0.0, 2.0 * pi, 3601)


@pytest.mark.parametrize("model", [b1(), b1(cam='direction = "cw"'), b1(law="simple-harmonic")])
def test_pair_residual_of_perfect_parts_is_zero(model: Model) -> None:
    found = pair_residual(*model.tracks, PHI)
    assert np.abs(found.gap).max() < 1e-10
    assert found.position == pytest.approx(model.setup.program.jet(PHI, 0)[0], abs=1e-12)


def nearest(curve: np.ndarray, point: complex) -> float:
    """Distance of a point from a curve sampled densely: the vertex of the parabola through the nearest samples."""
    far = np.abs(curve - point) ** 2
    i = int(np.argmin(far))
    a, b, c = far[i - 1], far[i], far[(i + 1) % len(far)]
    return float(np.sqrt(b - (a - c) ** 2 / (8.0 * (a - 2.0 * b + c))))


def test_pair_residual_under_a_wrong_centre_distance() -> None:
    """Rest of the main roller and gap of the return roller found by brute force on dense profiles."""
    model = b1()
    phi = np.radians([3.0, 20.0, 35.0, 52.0, 88.0, 130.0, 250.0])
    found = pair_residual(*model.tracks, phi, PairErrors(centre_distance=0.02))
    dense = np.linspace(0.0, 2.0 * pi, 40_000, endpoint=False)
    discs = [model.mechanism.outlines[name].curve(dense).points for name in ("main", "return")]
    main, back = (points[0] + 1j * points[1] for points in discs)
    arms = [complex(*track.anchor[:2]) - 205.0 for track in model.tracks]
    for angle, gap in zip(phi, found.gap):

        def centre(arm: complex, q: float, angle: float = angle) -> complex:
            return np.exp(-1j * angle) * (205.02 + arm * np.exp(-1j * q))

        low, high = found.position.min() - 1e-3, found.position.max() + 1e-3
        for _ in range(50):
            q = 0.5 * (low + high)
            low, high = (q, high) if nearest(main, centre(arms[0], q)) < 20.0 else (low, q)
        assert nearest(back, centre(arms[1], q)) - 20.0 == pytest.approx(gap, abs=2e-8)
    assert found.gap.min() > 0.028


def test_play_shows_as_the_gap_of_the_chord() -> None:
    model = b1(follower="clearance = 0.1")
    found = model.pair
    assert found.least == pytest.approx(0.1 * np.cos(radians(33.0)), abs=5e-5)
    assert found.gap.max() <= 0.1
    assert found.spread > 0.01
    jammed = pair_residual(*model.tracks, PHI, PairErrors(return_roller=0.09))
    assert jammed.least == pytest.approx(found.least - 0.09, abs=1e-6)
    assert jammed.least < 0.0


def test_motions_that_jump_have_no_residual_but_a_finding() -> None:
    model = b1(law="constant-velocity")
    assert model.pair is None
    with pytest.raises(DesignError, match="velocity jumps"):
        _ = model.solids
    assert np.abs(b1(law="parabolic").pair.gap).max() < 1e-10
