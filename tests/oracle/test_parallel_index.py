"""Parallel indexing cams against the distance to the nearest roller position, in closed form where there is one."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from math import acos, degrees, hypot, pi, radians

import numpy as np
import pytest

from camgeom.cams import starter
from camgeom.cams.parallel_index import ParallelIndex
from camgeom.errors import DesignError, ProfileError
from camgeom.model import Model
from camgeom.motion.program import Program
from camgeom.motion.segment import Segment
from camgeom.profile import parse
from camgeom.report.result import compute
from camgeom.track.clearance import least_clearance
from camgeom.track.follower import CylinderRoller, Setup, TurretFollower
from camgeom.track.outline import OutlineIntegrals
from camgeom.track.sweep import BandEdge, RimArc, _centre, _parallel
from camgeom.track.turret import Engagement, largest_drive_angle
from tests.oracle.envelope import swept_distance, triangle_points
from tests.reference.indexing_machines import index_program

STARTER = starter("parallel-index")

# stops, rollers, plates -> centre distance, pitch radius, roller diameter, plate diameter, index angle
SIZES = {
    (4, 8, 2): (140.0, 80.0, 26.0, 210.0, 220.0),
    (3, 6, 2): (150.0, 80.0, 32.0, 240.0, 240.0),
    (8, 16, 2): (125.0, 80.0, 18.0, 140.0, 150.0),
    (2, 8, 2): (190.0, 80.0, 28.0, 320.0, 240.0),
    (2, 8, 4): (190.0, 80.0, 32.0, 320.0, 300.0),
    (4, 12, 3): (112.0, 80.0, 20.0, 193.0, 240.0),
    (6, 18, 3): (98.0, 80.0, 14.0, 160.0, 230.0),
    (3, 9, 3): (140.0, 80.0, 26.0, 240.0, 260.0),
}
THREE = [size for size in SIZES if size[2] == 3]


@lru_cache(maxsize=16)
def plates(stops=4, rollers=8, count=2, **changes):
    """A parallel indexing cam and its setup."""
    centre, pitch, diameter, blank, motion = SIZES[stops, rollers, count]
    follower = TurretFollower(kind="turret", stops=stops, rollers=rollers, pitch_radius=pitch, inertia=0.2)
    setup = Setup(follower, CylinderRoller(diameter=diameter, length=10.0), index_program(stops, motion=motion))
    keys = {"kind": "parallel-index", "center_distance": centre, "diameter": blank, "width": 12.0, "gap": 16.0,
            "plates": count, "bore": 20.0}
    return ParallelIndex(**(keys | changes)), setup


def ring_distance(cam, setup, plate, points):
    """Least distance of points to the surface of any roller of a plate's ring in a turn, from the machine's words."""
    count, rf, c = setup.follower.count, setup.follower.pitch_radius, cam.center_distance
    sense = 1.0 if cam.direction == "ccw" else -1.0
    best = np.full(len(points), np.inf)
    flat = np.column_stack([points[:, :2], np.zeros(len(points))])
    for k in range(count // cam.plates):
        start = (0.5 + plate + k * cam.plates) * 2.0 * pi / count

        def pose(phi, start=start):
            tau = setup.program.jet(np.ravel(phi), 0)[0].reshape(np.shape(phi)) + start
            x, y = c - rf * np.cos(tau), sense * rf * np.sin(tau)
            co, si = np.cos(phi), np.sin(phi) * sense
            a = np.stack([co * x + si * y, co * y - si * x, np.zeros_like(x)], -1)
            return a, np.zeros_like(a)

        def distance(x, a, u):
            return np.hypot(x[..., 0] - a[..., 0], x[..., 1] - a[..., 1]) - 0.5 * setup.roller.diameter

        np.minimum(best, swept_distance(flat, pose, distance, 0.0, 2.0 * pi, 200, 2, 34), out=best)
    return best


@pytest.mark.parametrize(
    ("stops", "rollers", "count", "direction"), [*((*size, "ccw") for size in SIZES), (4, 8, 2, "cw")]
)
def test_outlines_lie_at_the_roller_radius_from_the_nearest_roller(stops, rollers, count, direction):
    cam, setup = plates(stops, rollers, count, direction=direction)
    assert cam.problems(setup) == []
    for plate, sweep in enumerate(cam.mechanism(setup).outlines.values()):
        points, rim = [], []
        for part in sweep.parts:
            x = part.curve(np.linspace(part.first, part.last, 17)).points.T
            (points if isinstance(part, BandEdge) else rim).append(x)
        touching = ring_distance(cam, setup, plate, np.concatenate(points))
        assert np.abs(touching).max() < 1e-9
        for x in rim:
            assert ring_distance(cam, setup, plate, x).min() > -1e-9
            assert np.hypot(*x.T) == pytest.approx(0.5 * cam.diameter)


def test_parts_of_an_outline_meet_and_turn_once():
    cam, setup = plates()
    for outline in cam.mechanism(setup).outlines.values():
        knots = outline.knots()
        start = outline.curve(knots).points
        end = outline.curve(np.nextafter(knots[1:], 0.0)).points
        assert np.abs(start[:, 1:] - end).max() < 1e-11
        x = outline.curve(np.linspace(0.0, 2.0 * pi, 2001)).points
        turning = np.angle(np.exp(1j * np.diff(np.angle(x[0] + 1j * x[1])))).sum()
        assert turning == pytest.approx(2.0 * pi)


def test_normals_curvature_and_speed_are_the_curves_own():
    cam, setup = plates()
    outline = cam.mechanism(setup).outlines["plate 1"]
    knots = outline.knots()
    h = 1e-5
    u = np.concatenate([np.linspace(a + 3 * h, b - 3 * h, 9) for a, b in zip(knots[:-1], knots[1:]) if b - a > 0.05])
    before, at, after = (outline.curve(v) for v in (u - h, u, u + h))
    tangent = (after.points - before.points) / (2.0 * h)
    assert np.hypot(*tangent) == pytest.approx(at.speed, rel=1e-6)
    assert np.abs((tangent * at.normals).sum(axis=0)).max() < 1e-6 * at.speed.max()
    turned = (after.normals - before.normals) / (2.0 * h)
    assert (turned * tangent).sum(axis=0) / at.speed**2 == pytest.approx(at.curvature, abs=1e-7)


def test_dwell_and_rim_are_arcs_of_circles_in_closed_form():
    cam, setup = plates()
    rf, c, r = 80.0, cam.center_distance, 13.0
    seat = hypot(c - rf * np.cos(pi / 8.0), rf * np.sin(pi / 8.0)) - r
    for sweep in cam.mechanism(setup).outlines.values():
        rims = [part for part in sweep.parts if isinstance(part, RimArc)]
        assert len(rims) == 1
        u = np.linspace(0.0, 2.0 * pi, 4001)
        distance = np.hypot(*sweep.curve(u).points)
        resting = np.abs(distance - seat) < 1e-9
        # The dwell takes 140 degrees of the turn; beyond them the arc goes on where nothing else cuts.
        azimuth = np.degrees(np.arctan2(*sweep.curve(u[resting]).points[::-1]))
        assert len(np.unique(azimuth.round())) >= 139
        assert distance.min() == pytest.approx(c - rf - r, abs=1e-3)


def test_solid_is_the_outline_raised_within_its_error():
    cam, setup = plates(bore=0.0)
    for plate, part in enumerate(cam.mechanism(setup).parts):
        solid = part.solid(0.02)
        assert solid.sound
        mesh = solid.mesh
        area = OutlineIntegrals(part.outer.outline, 24).properties.area
        assert mesh.volume == pytest.approx(12.0 * area, rel=1e-3)
        assert part.solid(0.0005).mesh.volume == pytest.approx(12.0 * area, rel=2.5e-5)
        walls = mesh.faces[np.ptp(mesh.vertices[mesh.faces][:, :, 2], axis=1) > 1.0]
        points = triangle_points(mesh.vertices, walls[:: max(1, len(walls) // 60)], 4)
        on_rim = np.hypot(points[:, 0], points[:, 1]) > 0.5 * cam.diameter - 0.021
        gap = ring_distance(cam, setup, plate, points[~on_rim])
        assert np.abs(gap).max() <= 1.001 * solid.chord_error <= 0.02002


@lru_cache(maxsize=1)
def starter():
    return Model(parse(STARTER))


def test_starter_passes_its_checks_and_carries_its_load():
    model = starter()
    result = compute(model, ("checks", "flank", "contact", "fatigue"))
    assert [f for f in result.findings if not f.passed] == []
    assert result.data["contact"]["rollers_sharing_least"] >= 1
    assert result.data["fatigue"]["cam_life_h"] > 0.0
    duty = model.turret_duty
    carried = (duty.line_load * duty._cover * duty._walls(duty.engagement.lever)).sum(axis=(1, 2))
    assert carried == pytest.approx(np.abs(duty.turret_torque), rel=1e-9, abs=1e-3)


def test_pressure_angle_of_the_dwell_in_closed_form():
    """In the dwell the normal points to the cam's axis; the roller's centre would move across its own radius."""
    cam, setup = plates()
    tau, rf, c = pi / 8.0, 80.0, cam.center_distance
    centre = np.array([c - rf * np.cos(tau), rf * np.sin(tau)])
    across = np.array([np.sin(tau), np.cos(tau)])
    angle = acos(centre @ across / np.linalg.norm(centre))
    e = Engagement(cam.mechanism(setup).tracks, cam.mechanism(setup).within, np.array([0.1, 0.3]))
    assert e.drive_angle == pytest.approx(np.full((2, 2), angle), abs=1e-9)
    worst = largest_drive_angle(cam.mechanism(setup).tracks, cam.mechanism(setup).within)
    assert worst.value >= angle - 1e-12
    assert degrees(worst.value) < 45.0
    assert 0.0 <= worst.cam_angle <= 2.0 * pi


def test_a_roller_of_the_other_size_interferes_or_clears():
    model = starter()
    same, larger, smaller = (min(c.value for c in model.clearances_with(grow)) for grow in (0.0, 5e-3, -5e-3))
    assert same == pytest.approx(0.0, abs=1e-9)
    assert larger == pytest.approx(-5e-3, abs=1e-6)
    assert smaller == pytest.approx(5e-3, abs=1e-6)


def test_running_clearance_stands_between_rollers_and_plates():
    cam, setup = plates(running_clearance=0.04)
    points = cam.mechanism(setup).parts[0].solid(0.02).mesh.vertices
    found = min(least_clearance(track, points).value for track in cam.mechanism(setup).passages[:1])
    assert found == pytest.approx(0.04, abs=1e-7)


def test_drive_is_lost_where_the_motion_is_too_fast():
    """At 180 degrees of index the walls cross themselves at the line of centres: nothing drives there."""
    slow, fast = (STARTER.replace("until = 70", f"until = {a}").replace("until = 290", f"until = {b}")
                  for a, b in ((70, 290), (110, 250)))
    found = {name: list(compute(Model(parse(text)), ("checks",), ("hand-over", "pressure-angle")).findings)
             for name, text in (("slow", slow), ("fast", fast))}
    assert all(f.passed for f in found["slow"])
    assert not any(f.passed for f in found["fast"])


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("rollers = 8", "rollers = 4", "a multiple of 8"),
        ("rollers = 8", "rollers = 12", "a multiple of 8"),
        ("pitch_radius = 80", "pitch_radius = 150", "below the centre distance 140"),
        ("diameter = 210", "diameter = 100", "120 .. 280"),
        ("diameter = 26", "diameter = 122", "below 113.137"),
        ("bore = 30", "bore = 110", "inside the base circle"),
        ('shape = "cylinder"\ndiameter = 26\nlength = 12', 'shape = "sphere"\ndiameter = 26', "cylinder"),
        ("to = 90", "to = -90", "a step on"),
    ],
)
def test_bad_input_is_refused_with_the_allowed_range(old, new, words):
    with pytest.raises(ProfileError) as refused:
        parse(STARTER.replace(old, new))
    assert words in str(refused.value)


@pytest.mark.parametrize("size", THREE)
def test_the_middle_of_three_plates_rests_on_one_circle_with_two_rollers(size):
    """In the dwell two rollers of the middle ring stand symmetrically: they sweep one arc, and both bear on it."""
    cam, setup = plates(*size)
    rf, c, r = setup.follower.pitch_radius, cam.center_distance, 0.5 * setup.roller.diameter
    half = 1.5 * 2.0 * pi / setup.follower.count
    azimuth, still = np.arctan2(rf * np.sin(half), c - rf * np.cos(half)), setup.program.spans[0].end
    assert azimuth < still
    outline = cam.mechanism(setup).outlines["plate 2"]
    u = np.linspace(0.0, 2.0 * pi, 5001)
    x = outline.curve(u).points
    seat = np.abs(np.hypot(*x) - (hypot(c - rf * np.cos(half), rf * np.sin(half)) - r)) < 1e-9
    within = np.abs(np.arctan2(x[1], x[0])) < azimuth + still
    assert np.all(seat[within])
    assert np.degrees(azimuth + still) > 80.0
    # The motion is symmetric about the middle of its index: so is where the outline passes on.
    joints = outline.curve(outline.knots()).points
    assert np.abs(joints[1][joints[0] > 0.0]).min() < 1e-4
    dwell = np.linspace(-0.999 * still, 0.999 * still, 41) % (2.0 * pi)
    e = Engagement(cam.mechanism(setup).tracks, cam.mechanism(setup).within, dwell)
    middle = [k for k, (i, _) in enumerate(e.places) if e.tracks[i].name == "plate 2"]
    assert np.all(e.on[:, :, middle].any(axis=3).sum(axis=2) == 1)


@pytest.mark.parametrize("beyond", [0.0, 1e-12, 1e-7, -1e-7, -1e-3, -0.2])
def test_two_seats_that_just_meet_just_overlap_or_stand_apart(beyond):
    """A dwell from -h to h of cam angle leaves seats about +-a: one where h > a, two with a hump between below."""
    cam, setup = plates(4, 12, 3)
    half = 1.5 * 2.0 * pi / setup.follower.count
    still = np.arctan2(80.0 * np.sin(half), cam.center_distance - 80.0 * np.cos(half)) + beyond
    setup = replace(setup, program=index_program(4, motion=360.0 - 2.0 * degrees(still)))
    outline = cam.mechanism(setup).outlines["plate 2"]
    knots = outline.knots()
    assert np.abs(outline.curve(knots).points[:, 1:] - outline.curve(np.nextafter(knots[1:], 0.0)).points).max() < 1e-9
    points = outline.curve(np.linspace(0.0, 2.0 * pi, 201)).points.T
    assert np.abs(ring_distance(cam, setup, 1, points)).max() < 1e-8
    x = outline.curve(np.linspace(0.0, 2.0 * pi, 8001)).points
    ahead = np.hypot(*x)[np.abs(np.arctan2(x[1], x[0])) < 0.02].max()
    seat = hypot(cam.center_distance - 80.0 * np.cos(half), 80.0 * np.sin(half)) - 0.5 * setup.roller.diameter
    assert (ahead > seat + 1e-3) == (beyond < -0.1)


@pytest.mark.parametrize("size", THREE)
def test_solids_of_three_plates_lie_within_their_error(size):
    cam, setup = plates(*size, bore=0.0)
    for plate, part in enumerate(cam.mechanism(setup).parts):
        solid = part.solid(0.02)
        assert solid.sound
        mesh = solid.mesh
        assert mesh.volume == pytest.approx(12.0 * OutlineIntegrals(part.outer.outline, 24).properties.area, rel=1e-3)
        walls = mesh.faces[np.ptp(mesh.vertices[mesh.faces][:, :, 2], axis=1) > 1.0]
        points = triangle_points(mesh.vertices, walls[:: max(1, len(walls) // 60)], 4)
        on_rim = np.hypot(points[:, 0], points[:, 1]) > 0.5 * cam.diameter - 0.021
        assert np.abs(ring_distance(cam, setup, plate, points[~on_rim])).max() <= 1.001 * solid.chord_error


def test_a_roller_that_almost_stands_still_is_touched_half_round_within_a_moment():
    """Its path turns back on the spot within a thousandth of a degree: the bottom of that slot is not passed over."""
    cam, setup = plates(center_distance=168.29690603854365, diameter=286.935)
    program = index_program(4, "gutman-1-3", 206.03973543549)
    follower = TurretFollower(kind="turret", stops=4, rollers=8, pitch_radius=100.0)
    setup = replace(setup, follower=follower, roller=CylinderRoller(diameter=27.417, length=10.0), program=program)
    outline = cam.mechanism(setup).outlines["plate 1"]
    x = outline.curve(np.linspace(0.0, 2.0 * pi, 801)).points.T
    inner = np.hypot(*x.T) < 0.5 * cam.diameter - 1e-9
    assert np.abs(ring_distance(cam, setup, 0, x[inner])).max() < 1e-8
    assert np.hypot(*x.T).min() == pytest.approx(68.29690603854365 - 13.7085, abs=0.1)


def test_an_edge_that_leaves_along_the_rim_ends_where_it_was_found():
    """Newton's method for where it meets the rim runs away: the end is where the boundary was seen to change."""
    size = {"center_distance": 167.89921770401833, "diameter": 294.15355688380345, "plates": 4}
    cam, setup = plates(2, 8, 4, **size)
    follower = TurretFollower(kind="turret", stops=6, rollers=24, pitch_radius=100.0)
    law = ("modified-constant-velocity", {"share": 0.5234513806417603, "rise": 0.8850218933014723})
    steps = [Segment(radians(98.95006007695632)), Segment(radians(305.9772223833024), pi / 3.0, *law)]
    program = Program.from_segments([*steps, Segment(2.0 * pi)], closed=False, angular=True)
    setup = replace(setup, follower=follower, roller=CylinderRoller(diameter=24.215594895564745, length=5.0),
                    program=program)  # fmt: skip
    for plate, outline in enumerate(cam.mechanism(setup).outlines.values()):
        x = outline.curve(np.linspace(0.0, 2.0 * pi, 801)).points.T
        inner = np.hypot(*x.T) < 0.5 * cam.diameter - 1e-6
        assert np.abs(ring_distance(cam, setup, plate, x[inner])).max() < 1e-6
        assert np.hypot(*x.T).max() < 0.5 * cam.diameter + 1e-6


def test_a_path_whose_curvature_jumps_bounds_its_plate():
    """Newton's method for the nearest place of a path does not settle across the jump; its bracket is halved there."""
    cam, setup = plates(4, 12, 3, center_distance=136.70971751867475, diameter=212.8570301765766, plates=4)
    follower = TurretFollower(kind="turret", stops=4, rollers=16, pitch_radius=77.78078002920338)
    program = index_program(4, "parabolic", 217.31522594656703)
    setup = replace(setup, follower=follower, roller=CylinderRoller(diameter=18.103222110183037, length=12.9),
                    program=program)  # fmt: skip
    for plate, outline in enumerate(cam.mechanism(setup).outlines.values()):
        x = outline.curve(np.linspace(0.0, 2.0 * pi, 801)).points.T
        inner = np.hypot(*x.T) < 0.5 * cam.diameter - 1e-6
        assert np.abs(ring_distance(cam, setup, plate, x[inner])).max() < 1e-8


def test_a_jump_of_velocity_is_named():
    cam, setup = plates(4, 12, 3)
    setup = replace(setup, program=index_program(4, "constant-velocity", 240.0))
    with pytest.raises(DesignError, match="velocity jumps at 60, 300 deg"):
        cam.mechanism(setup).tracks  # noqa: B018


def test_rollers_that_reach_the_shaft_leave_no_plate():
    cam, setup = plates(4, 12, 3)
    mechanism = cam.mechanism(setup)
    assert mechanism._sweep(1, 15.0).chain
    with pytest.raises(DesignError, match="no plate about the shaft: they cut through it"):
        mechanism._sweep(1, 25.0).chain  # noqa: B018


def test_a_small_disc_loses_the_turret_and_says_what_helps():
    """Three plates on 0.86 of the centre distance hold the turret all the way, on 0.7 of it nobody does for a while."""
    found = {}
    for share in (0.86, 0.7):
        text = STARTER.replace("center_distance = 140", "center_distance = 110.4")
        text = text.replace("rollers = 8", "rollers = 12")
        text = text.replace("diameter = 210", f"plates = 3\ndiameter = {2.0 * share * 110.4}")
        text = text.replace("diameter = 26", "diameter = 24").replace("bore = 30", "bore = 10")
        text = text.replace("keyway", "#")
        found[share] = list(compute(Model(parse(text)), ("checks",), ("hand-over",)).findings)
    assert [f.passed for f in found[0.86]] == [True, True]
    assert [f.passed for f in found[0.7]] == [False, False]
    assert "no roller of any plate holds the turret there: a larger cam.diameter" in found[0.7][0].advice


def test_turret_stands_clear_of_the_plates():
    import manifold3d

    def manifold(mesh):
        return manifold3d.Manifold(manifold3d.Mesh64(mesh.vertices, mesh.faces.astype(np.uint64)))

    cam, setup = plates()
    solids = [manifold(part.solid(0.02).mesh) for part in cam.mechanism(setup).parts]
    for angle in (0.0, 3.3):
        standing = cam.mechanism(setup).turret.body
        rings = tuple(replace(ring, cam_angle=angle) for ring in standing.rings)
        turret = replace(standing, rings=rings).solid(0.02)
        assert turret.sound
        for plate in solids:
            assert (manifold(turret.mesh) ^ plate).volume() < 5.0


def test_edges_are_parallel_to_their_path():
    cam, setup = plates(direction="cw")
    track = cam.mechanism(setup).passages[0]
    phi = np.linspace(*track.span, 50)
    jet = track.pose(phi, 2).a
    assert np.abs(_centre(track, phi, 2) - (jet[:, 0] + 1j * jet[:, 1])).max() < 1e-11
    for side in (1.0, -1.0):
        x, step, _ = _parallel(track, phi, side)
        centre = track.pose(phi, 0).a[0]
        gap = x - (centre[0] + 1j * centre[1])
        assert np.abs(gap) == pytest.approx(13.0)
        assert np.abs((np.conj(step) * gap).real).max() < 1e-9


def test_an_edge_that_ends_on_the_rim_where_no_other_begins_leaves_no_joint_and_no_warning():
    cam, setup = plates(4, 12, 3)
    sweep = cam.mechanism(setup)._sweep(1, 15.0)
    ends = [i for i, edge in enumerate(sweep.edges) if abs(hypot(*edge.curve(np.array([edge.last])).points[:, 0])
                                                           - sweep.radius) < 1e-6]  # fmt: skip
    assert all(sweep._next(i) is not None for i in ends)
    lonely = replace(sweep)
    lonely.__dict__["_starts"] = np.zeros_like(sweep._starts)
    assert [lonely._next(i) for i in ends] == [None] * len(ends)
    assert ends

