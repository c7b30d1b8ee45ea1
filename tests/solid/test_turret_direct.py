"""Indexing cams meshed directly: same body as the boolean's, lands within their sag, simple topology or a refusal."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from camgeom.maths import TURN
from camgeom.maths.mesh import clip, open_loops
from camgeom.maths.sampling import angles, columns_over, middle_angles
from camgeom.solid import ENDS_CUT
from camgeom.solid.blank import Blank
from camgeom.solid.fewest import fewest
from camgeom.solid.lands import CylinderLand, GloboidLand, GloboidLevel, Land, NotOneSurface, Rim, land_net, land_of
from camgeom.track.column import CylinderLevel
from tests.reference.indexing_machines import barrel, index_program, indexer

GLOBOID = GloboidLand(GloboidLevel(180.0, 80.0))


@pytest.mark.parametrize(
    "made",
    [
        lambda: indexer(3, "groove", bore=20.0),
        lambda: indexer(8, "rib", "left", shape="sphere", bore=20.0),
        lambda: indexer(6, "groove", shape="crowned", direction="cw", bore=20.0),
        lambda: indexer(4, "groove", "left", 2, "cone"),
        lambda: indexer(12, indexes=3, motion=70.0, bore=20.0, hub_diameter=60.0, hub_length=9.0),
        lambda: barrel(8, "groove", "left", keyway_width=8.0, keyway_depth=3.0),
        lambda: barrel(8, "groove", "right", 2, "crowned"),
    ],
)
def test_same_body_as_the_boolean(made):
    (part,) = made()[0].mechanism(made()[1]).parts
    volumes = []
    for tolerance in (0.1, 0.05):
        direct, cut = part.direct(tolerance), part.cut(tolerance)
        assert direct.method == ENDS_CUT
        assert part.solid(tolerance).method == ENDS_CUT
        assert direct.sound
        assert cut.sound
        assert set(direct.mesh.groups) == set(cut.mesh.groups) - {"back", "cap"}
        assert direct.chord_error <= tolerance
        # Two bodies within the tolerance of a third differ by less than its area times twice the tolerance.
        assert abs(direct.mesh.volume - cut.mesh.volume) < tolerance * direct.mesh.area
        volumes.append((direct.mesh.volume, cut.mesh.volume))
        few = fewest(part, tolerance)
        assert few.sound
        assert few.method == ENDS_CUT
        assert set(few.mesh.groups) == set(direct.mesh.groups)
        assert few.chord_error <= tolerance
        assert abs(few.mesh.volume - cut.mesh.volume) < tolerance * direct.mesh.area
        assert len(few.mesh.faces) <= len(direct.mesh.faces)
    limits = [2.0 * fine - coarse for coarse, fine in zip(*volumes)]
    assert limits[0] == pytest.approx(limits[1], rel=2e-4)


def test_ends_are_flat_and_walls_named():
    cam, setup = indexer(8, bore=20.0)
    mesh = cam.mechanism(setup).parts[0].direct(0.05).mesh
    half = 0.5 * cam.width
    assert float(np.abs(mesh.vertices[:, 2]).max()) == half
    ends = mesh.faces[mesh.group_faces("end")]
    assert np.all(np.abs(mesh.vertices[ends][:, :, 2]) == half)
    land = np.unique(mesh.faces[mesh.group_faces("land")])
    x = mesh.vertices[land]
    off = np.hypot(np.hypot(x[:, 0], x[:, 1]) - cam.center_distance, x[:, 2]) - cam.globoid_radius
    inner = np.abs(x[:, 2]) < half
    assert np.abs(off[inner]).max() < 1e-10
    # Where the ends cut chords, vertices lie on chords; a saddle's lie to both sides.
    assert np.abs(off).max() < 0.05


def test_to_and_fro_closes_every_groove():
    cam, setup = indexer(8, bore=20.0)
    steps = index_program(8).segments
    back = [replace(s, until=s.until / 2.0) for s in steps]
    rest = [replace(s, until=pi + s.until / 2.0, to=None if s.to is None else 0.0) for s in steps]
    program = type(setup.program).from_segments([*back, *rest], closed=True, angular=True)
    (part,) = cam.mechanism(replace(setup, program=program)).parts
    direct, cut = part.direct(0.05), part.cut(0.05)
    assert direct.mesh.watertight
    assert (direct.mesh.components, direct.mesh.genus) == (cut.mesh.components, cut.mesh.genus)
    assert direct.mesh.volume == pytest.approx(cut.mesh.volume, rel=5e-4)
    few = fewest(part, 0.05)
    assert few.sound
    assert len(few.mesh.faces) < len(direct.mesh.faces)
    assert few.mesh.volume == pytest.approx(direct.mesh.volume, rel=5e-4)


def test_grooves_that_touch_are_left_to_the_boolean():
    cam, setup = barrel(4, "rib", starts=2)
    (part,) = cam.mechanism(setup).parts
    with pytest.raises(NotOneSurface, match="touch"):
        part.direct(0.1)
    with pytest.raises(NotOneSurface, match="touch"):
        fewest(part, 0.1)
    solid = part.solid(0.1)
    assert solid.method == "boolean"
    assert solid.sound


def test_tracks_of_another_turret_are_refused():
    cam, setup = indexer(4, starts=2)
    (part,) = cam.mechanism(setup).parts
    first, second = part.tracks
    with pytest.raises(NotOneSurface, match="one turret"):
        replace(part, tracks=(first, replace(second, shift=second.shift + 1e-3))).direct(0.1)
    with pytest.raises(NotOneSurface, match="neither"):
        replace(part, blank=Blank(((50.0, -9.0), (60.0, 9.0)))).direct(0.1)


@pytest.mark.parametrize("land", [GLOBOID, CylinderLand(CylinderLevel(60.0))])
def test_sag_of_chords_on_a_land(land):
    """The middle of a chord against its distance from the surface itself."""
    rng = np.random.default_rng(3)
    size = land.at_height(30.0)
    w0 = rng.uniform(-size, size, 200)
    dpsi, dw = 0.02 * rng.standard_normal(200), 0.03 * size * rng.standard_normal(200)
    a, b = land.points(np.zeros(200), w0), land.points(dpsi, w0 + dw)
    off = np.abs(land.level(0.5 * (a + b)))
    assert land.sag(dpsi, dw, w0 + 0.5 * dw) == pytest.approx(off, rel=0.03, abs=2e-4 * float(off.max()))


def test_land_of_an_outline():
    globoid = Blank(((100.0, -30.0), (100.0, 30.0)), None, ((180.0, 0.0),), ("land",))
    assert land_of(globoid, 0).level.radius == pytest.approx(np.hypot(80.0, 30.0))
    assert land_of(Blank.cylinder(5.0, 9.0), 0).level.radius == 5.0
    assert land_of(Blank(((5.0, 0.0), (6.0, 9.0))), 0) is None
    assert land_of(Blank(((5.0, 0.0), (5.0, 9.0)), None, ((180.0, 4.0),)), 0) is None


def wavy(level, height, count=400):
    """A rim over x = 0 .. 3 with vertex numbers, about w = level."""
    x = np.linspace(0.0, 3.0, count)
    return Rim(x, level + height * np.sin(2.0 * x), np.arange(count))


def net_area(land, strip, net, rims):
    """Area of the net's triangles in the plane of x and w, and of the land between its rims."""
    x = np.concatenate([*(rim.x for rim in rims), net.x])
    w = np.concatenate([*(rim.w for rim in rims), net.w])
    a, b, c = net.faces.T
    area = 0.5 * ((x[b] - x[a]) * (w[c] - w[a]) - (x[c] - x[a]) * (w[b] - w[a]))
    assert area.min() > 0.0
    return float(area.sum())


@pytest.mark.parametrize("land", [GLOBOID, CylinderLand(CylinderLevel(60.0))])
def test_net_fills_a_land(land):
    size = land.at_height(40.0)
    low, high = wavy(-0.4 * size, 0.1 * size), wavy(0.4 * size, 0.2 * size)
    high = replace(high, number=high.number + len(low.x))
    strip = Land(land, low, high, (-size, size), False)
    net = land_net(strip, 800, 0.01)
    assert net.sag <= 0.01
    expected = np.trapezoid(high.w - low.w, low.x)
    assert net_area(land, strip, net, (low, high)) == pytest.approx(expected, rel=1e-9)


def test_rims_may_come_close_but_not_meet():
    size = GLOBOID.at_height(40.0)
    for gap, meets in ((0.02, False), (-0.001, True)):
        low, high = wavy(0.0, 0.1), wavy(0.1 + gap, -0.0)
        high = replace(high, number=high.number + len(low.x))
        strip = Land(GLOBOID, low, high, (-size, size), False)
        if meets:
            with pytest.raises(NotOneSurface, match="meet"):
                land_net(strip, 800, 0.05)
        else:
            assert land_net(strip, 800, 0.05).sag <= 0.05


def cube():
    """A unit cube about the origin, outward."""
    points = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return points, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


@pytest.mark.parametrize("height", [-0.3, 0.0, 0.999])
def test_clipped_cube_ends_in_one_loop_on_the_plane(height):
    points, faces = cube()
    points, faces, label = clip(points, faces, np.arange(12, dtype=np.uint8), height, 1.0)
    assert points[faces][:, :, 2].max() == height
    assert set(label) == set(range(12)) - {10, 11}
    (loop,) = open_loops(faces, points[:, 2] == height)
    plane = points[loop]
    area = 0.5 * np.sum(plane[:, 0] * np.roll(plane[:, 1], -1) - np.roll(plane[:, 0], -1) * plane[:, 1])
    # Faces run clockwise along an end they leave open above them.
    assert area == pytest.approx(-4.0)


def test_faces_in_the_plane_are_left_out_and_those_below_stay():
    points, faces = cube()
    for sign, height in ((1.0, 1.0), (-1.0, -1.0)):
        _, kept, _ = clip(points, faces, np.zeros(12, dtype=np.uint8), height, sign)
        assert len(kept) == 10
        assert len(open_loops(kept, points[:, 2] == height)) == 1
    beyond, kept, _ = clip(points, faces, np.zeros(12, dtype=np.uint8), 1.5, -1.0)
    assert len(kept) == 0
    assert len(beyond) == 8


def test_loops_that_meet_in_a_point_are_refused():
    faces = np.array([[0, 1, 5], [1, 2, 5], [2, 0, 5], [0, 3, 6], [3, 4, 6], [4, 0, 6]])
    assert open_loops(faces, np.array([True] * 5 + [False] * 2)) is None
    apart = np.array([[0, 1, 5], [1, 2, 5], [2, 0, 5]])
    assert len(open_loops(apart, np.array([True] * 5 + [False]))) == 1


def test_columns_run_on_through_the_rounds():
    theta = np.array([0.0, 1.0, 4.0, TURN])
    low, high = -TURN - 0.5, 2.5
    first, last = columns_over(theta, low, high)
    found = angles(theta, np.arange(first, last + 1))
    assert found[0] <= low < found[1]
    assert found[-2] < high <= found[-1]
    assert np.all(np.diff(found) > 0.0)
    middles = middle_angles(theta, np.arange(first, last))
    assert middles == pytest.approx(0.5 * (found[1:] + found[:-1]))
    assert columns_over(theta, 0.0, TURN) == (0, 3)
