"""Lead-in relief at the ends of dwells: in closed form, against the nearest roller, and on both sides of its limits."""

from __future__ import annotations

from dataclasses import replace
from math import degrees, pi, radians

import numpy as np
import pytest

from camgeom.cams import starter
from camgeom.errors import ProfileError
from camgeom.model import Model
from camgeom.motion import Program, Segment
from camgeom.profile import parse
from camgeom.report.result import compute
from camgeom.track import Relief
from camgeom.track.column import Column
from camgeom.track.flank import Flank
from camgeom.track.turret import play_at
from tests.oracle.envelope import roller_distance, swept_distance, triangle_points
from tests.reference.indexing_machines import dwell_half_angle, indexer, meridian_of, turret_pose

STARTER = starter("globoidal")
BARREL = starter("cylindrical-index")

GAP, WIDTH = 0.03, 4.0


def share(off):
    """What is left of the relief `off` degrees beside the end of a dwell."""
    return max(0.0, 1.0 - (off / WIDTH) ** 2) ** 4


def test_derivatives_are_those_of_the_shape():
    relief = Relief((0.3, 4.0), 0.1, 0.02)
    phi, h = np.linspace(0.15, 4.2, 4001) + 2.0 * pi, 1e-6
    jet = relief.jet(phi, 3)
    for order in range(3):
        slope = (relief.jet(phi + h, order)[order] - relief.jet(phi - h, order)[order]) / (2.0 * h)
        assert slope == pytest.approx(jet[order + 1], abs=1e-4 * np.abs(jet[order + 1]).max())
    assert relief.jet(np.array([0.3, 0.2, 0.4, 0.39999]), 0)[0] == pytest.approx([0.02, 0.0, 0.0, 0.0], abs=1e-15)
    assert np.abs(relief.jet(np.array([0.2, 0.4]), 3)).max() < 1e-11


@pytest.mark.parametrize("form", ["rib", "groove"])
@pytest.mark.parametrize(("hand", "direction"), [("right", "ccw"), ("left", "ccw"), ("right", "cw"), ("left", "cw")])
def test_play_of_a_globoidal_cam_in_closed_form(form, hand, direction):
    """The flank stands back by the lever times the angle: in proportion to the distance from the turret's axis."""
    cam, setup = indexer(8, form, hand, direction=direction, relief=GAP, relief_angle=WIDTH)
    assert cam.problems(setup) == []
    machine = cam.mechanism(setup)
    for end in cam.dwell_ends(setup.program):
        for off in (-1.05 * WIDTH, -0.9 * WIDTH, -0.5 * WIDTH, 0.0, 0.5 * WIDTH, 0.9 * WIDTH, 1.05 * WIDTH):
            found = play_at(machine.tracks, machine.cutters, machine.within, end + radians(off))
            # The innermost of nine places that still lies in the blank.
            inner = 82.5 / 90.0
            assert found == pytest.approx(GAP * share(off) * inner, rel=1e-3, abs=2e-8)


@pytest.mark.parametrize("shape", ["cylinder", "cone", "crowned"])
def test_relieved_walls_are_where_the_tools_pass(shape):
    """Each flank against the tool turned aside its own way, by the description; nothing sticks out of either."""
    cam, setup = indexer(8, "rib", shape=shape, relief=0.3, relief_angle=9.0, bore=20.0)
    solid = cam.mechanism(setup).parts[0].solid(0.02)
    assert solid.sound
    rng = np.random.default_rng(4)
    faces = solid.mesh.faces[solid.mesh.group_faces("flank")]
    angle = np.degrees(np.arctan2(*solid.mesh.vertices[faces].mean(axis=1).T[1::-1]))
    near = np.abs(np.abs(angle) - 120.0) < 30.0
    points = triangle_points(solid.mesh.vertices, rng.choice(faces[near], 120), 4)
    kind, radius = meridian_of(setup, shape), 0.5 * setup.roller.diameter
    low, high = cam.mechanism(setup).cutters[0].span
    ends, best, plain = np.radians([120.0, 240.0]), np.full(len(points), np.inf), np.full(len(points), np.inf)

    def aside(phi):
        off = np.degrees(np.asarray(phi)[..., None] - ends + pi) % 360.0 - 180.0
        return 0.3 / 90.0 * (np.maximum(0.0, 1.0 - (off / 9.0) ** 2) ** 4).sum(axis=-1)

    def distance(x, a, u):
        return roller_distance(x, a, u, radius, cam.mechanism(setup).tip + 12.0, tip_high=True, shape=kind)

    for way in (1.0, 0.0, -1.0):

        def pose(phi, way=way):
            return turned(setup, cam, phi, way * aside(phi))

        found = swept_distance(points, pose, distance, low, high, int(200 * (high - low) / (2.0 * pi)), 3, 30)
        if way:
            np.minimum(best, found, out=best)
        else:
            plain = found
    assert np.abs(best).max() <= 1.001 * solid.chord_error
    # Here and there the plain roller stands well off these walls: the relief is there.
    assert plain.max() > 0.2
    assert plain.min() > -1.001 * solid.chord_error


def turned(setup, cam, phi, aside):
    """Pose of the tool with its turret turned aside."""
    plain = turret_pose(setup, cam.center_distance, dwell_half_angle(setup, cam.form), cam.hand)
    a, u = plain(phi)
    axis = np.stack([np.sin(phi), np.cos(phi), np.zeros_like(phi)], -1)
    c, s = np.cos(aside)[..., None], np.sin(aside)[..., None]
    return a, u * c + np.cross(axis, u) * s


def test_normals_are_across_the_relieved_surface():
    cam, setup = indexer(8, relief=0.2, relief_angle=5.0)
    (cutter,) = cam.mechanism(setup).cutters
    end, h, t = radians(240.0) - 2.0 * pi, 1e-6, np.array([84.0, 95.0])
    phi = end + np.radians(np.linspace(-6.0, 6.0, 41)) + 1e-4
    for side in (1.0, -1.0):
        here, before, after = (Flank(cutter, phi + d, t, side) for d in (0.0, -h, h))
        tangent = (after.x - before.x) / (2.0 * h)
        assert np.abs((tangent * here.n).sum(axis=0)).max() < 1e-6
        assert Column(cutter, phi).wall(side, t) == pytest.approx(here.x, abs=1e-12)
        assert tangent == pytest.approx(here.tangents[0], abs=1e-4)


def test_barrel_cam_has_the_relief_on_both_flanks():
    text = BARREL.replace('hand = "right"', 'hand = "left"\nrelief = 0.03\nrelief_angle = 4')
    model = Model(parse(text))
    for end in model.mechanism.turret.dwell_ends:
        for off in (-4.2, -2.0, 0.0, 2.0, 4.2):
            found = play_at(model.tracks, model.cutters, model.mechanism.within, end + radians(off))
            # The lever of a roller half a pitch off the centre line is rf cos(tau), nearly rf.
            assert found == pytest.approx(GAP * share(off), rel=0.05, abs=1e-8)


@pytest.mark.parametrize(("relief", "passed"), [(0.019, False), (0.024, True)])
def test_relief_is_judged_against_the_preload(relief, passed):
    keys = f"preload = 0.02\nrelief = {relief}\nrelief_angle = 3"
    model = Model(parse(STARTER.replace("bore = 40", f"bore = 40\n{keys}")))
    found = compute(model, ("checks",), ("relief", "undercut")).findings
    ends = [f for f in found if f.check == "relief"]
    assert [round(f.cam_angle_deg) for f in ends] == [240, 120]
    assert [f.passed for f in ends] == [passed, passed]
    assert all(f.passed for f in found if f.check == "undercut")


def test_two_dwells_in_a_turn_have_four_ends():
    cam, setup = indexer(12, indexes=2, motion=70.0, relief=0.02)
    assert sorted(round(degrees(e), 6) for e in cam.dwell_ends(setup.program)) == [55.0, 125.0, 235.0, 305.0]


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ("relief = 0.02\nrelief_angle = 61", "at most 60 deg"),
        ("relief = 0.02\nrelief_angle = 0", "relief_angle"),
        ("relief = -0.02", "relief"),
    ],
)
def test_bad_relief_is_refused_with_the_allowed_range(keys, words):
    with pytest.raises(ProfileError) as refused:
        parse(STARTER.replace("bore = 40", f"bore = 40\n{keys}"))
    assert words in str(refused.value)
    assert parse(STARTER.replace("bore = 40", "bore = 40\nrelief = 0.02\nrelief_angle = 60")).cam.relief == 0.02


def test_balls_and_motions_without_a_dwell_have_no_relief():
    cam, setup = indexer(8, shape="sphere", relief=0.02)
    assert any("balls" in p.allowed for p in cam.problems(setup))
    cam, setup = indexer(8, relief=0.02)
    moving = Program.from_segments([Segment(2.0 * pi, pi / 4.0, "cycloidal")], closed=False, angular=True)
    assert any("without a dwell" in p.allowed for p in cam.problems(replace(setup, program=moving)))
