"""Globoidal cams: pressure angle and gaps in closed form, preload, ribs, hand-over, load sharing, refusals."""

from __future__ import annotations

from dataclasses import replace
from math import atan, cos, degrees, hypot, pi, radians, sin

import numpy as np
import pytest

from camgeom.cams import starter
from camgeom.errors import ProfileError
from camgeom.maths.surface import dot
from camgeom.model import Model
from camgeom.profile import parse
from camgeom.report.result import compute
from camgeom.track.clearance import least_clearance
from camgeom.track.flank import Flank
from camgeom.track.follower import CylinderRoller, Setup, TurretFollower
from camgeom.track.turret import Engagement, rib_thickness
from tests.reference.indexing_machines import index_program, indexer

STARTER = starter("globoidal")

FINE = 1e-9


def axis_angle(pitch_radius):
    """Pressure angle at the roller axis in the middle of the index: C 180, 8 stops, 120 deg modified sine."""
    cam, setup = indexer(8, bore=0.0)
    follower = TurretFollower(kind="turret", stops=8, pitch_radius=pitch_radius)
    setup = Setup(follower, CylinderRoller(diameter=30.0, length=20.0), setup.program)
    cam = cam.model_copy(update={"center_distance": 180.0, "globoid_radius": pitch_radius - 8.0})
    (track,) = cam.mechanism(setup).tracks
    # The roller stands on the line of centres in the middle of the motion.
    phi = np.array([-pi if abs(track.coordinate(np.array([-pi]), 0)[0, 0]) < FINE else pi])
    return degrees(Flank(track, phi, np.array([pitch_radius]), 1.0).pressure_angle("axis")[0, 0])


@pytest.mark.parametrize(("radius", "angle"), [(90.0, 33.41887), (80.0, 27.82872), (100.0, 39.51629)])
def test_pressure_angle_of_the_literature(radius, angle):
    assert axis_angle(radius) == pytest.approx(angle, abs=6e-6)
    rate = 4.0 * pi / (4.0 + pi) * 45.0 / 120.0
    assert axis_angle(radius) == pytest.approx(degrees(atan(rate * radius / (180.0 - radius))), abs=1e-4)


def test_no_step_between_turns():
    """A roller leaves one turn of its groove where it enters the next: the span covers whole passages only."""
    for stops, starts in ((8, 1), (4, 2), (12, 2)):
        cam, setup = indexer(stops, starts=starts)
        tracks = cam.mechanism(setup).tracks
        assert len(tracks) == starts
        for track in tracks:
            ends = np.abs(track.coordinate(np.array(track.span), 0)[0])
            assert ends == pytest.approx(np.full(2, ends[0]), abs=1e-6)


@pytest.mark.parametrize("form", ["rib", "groove"])
def test_preload_is_the_interference_in_the_dwell(form):
    cam, setup = indexer(8, form, preload=0.02)
    (track,) = cam.mechanism(setup).tracks
    turns = (0.0, -2.0 * pi) if form == "rib" else (2.0 * pi, -2.0 * pi)
    for turn in turns:
        phi = turn + np.linspace(-0.7, 0.7, 15)
        (cutter,) = cam.mechanism(setup).cutters
        t = np.linspace(cam.globoid_radius + 2.0, cam.mechanism(setup).tip - 1.0, 5)
        cut = np.concatenate([Flank(cutter, phi, t, s).points.reshape(-1, 3) for s in (1.0, -1.0)])
        found = least_clearance(replace(track, span=(turn - 0.5, turn + 0.5)), cut)
        assert found.value == pytest.approx(-0.02, abs=2e-6)


@pytest.mark.parametrize(
    ("stops", "form", "hand", "starts", "shape"),
    [(8, "rib", "right", 1, "cylinder"), (12, "groove", "left", 1, "cone"), (4, "rib", "left", 2, "crowned")],
)
def test_a_larger_roller_interferes_and_a_smaller_one_clears(stops, form, hand, starts, shape):
    """On the finished mesh, for every roller over the whole cycle, also where its middle stands beyond the cam."""
    cam, setup = indexer(stops, form, hand, starts, shape)
    (part,) = cam.mechanism(setup).parts
    # Fine enough that walls have vertices between their edges, which lie on facets.
    solid = part.solid(0.05 if shape == "cylinder" else 0.01)
    slack = np.where(solid.cut_vertices, solid.chord_error, 0.0)
    points = solid.mesh.vertices
    touch, larger, smaller = (
        min(least_clearance(track, points, slack, grow).value for track in cam.mechanism(setup).passages)
        for grow in (0.0, 5e-3, -5e-3)
    )
    assert touch == pytest.approx(0.0, abs=1e-7)
    assert larger == pytest.approx(-5e-3, abs=1e-6)
    assert smaller == pytest.approx(5e-3, abs=1e-6)


def test_rib_in_the_dwell_in_closed_form():
    """Without motion the rib is a wedge between two flat flanks that meet at twice the half pitch."""
    cam, setup = indexer(8)
    (track,) = cam.mechanism(setup).tracks
    still = replace(track, span=(-0.5, 0.5))
    delta, half, radius = 90.0, pi / 8.0, 0.5 * setup.roller.diameter
    rib = rib_thickness(still, -pi / 4.0 if track.shift > 0 else pi / 4.0, lambda x: np.ones(x.shape[1:], bool), delta)
    point = delta * np.array([cos(half), sin(half)]) + radius * np.array([sin(half), -cos(half)])
    across = np.array([sin(half), cos(half)])
    assert rib.thickness == pytest.approx(float(point @ across) - radius, abs=1e-6)


def test_torque_is_carried_exactly():
    model = Model(parse(STARTER.replace("speed = 100", "speed = 300\nfriction = 2000")), 0.05)
    duty = model.turret_duty
    lever = duty._walls(duty.engagement.lever)
    carried = (duty.line_load * duty._cover * lever).sum(axis=(1, 2))
    assert carried == pytest.approx(np.abs(duty.turret_torque), rel=1e-9, abs=1e-3)
    # Two rollers never bear more than their sum would alone; work over a turn is what friction takes.
    assert duty.contact_data()["mean_torque_n_m"] == pytest.approx(2.0 * (pi / 4.0) / (2.0 * pi), rel=1e-9)


def test_pressure_grows_with_the_root_of_the_load():
    speeds = [Model(parse(STARTER.replace("speed = 100", f"speed = {v}")), 0.05).turret_duty for v in (100, 400)]
    slow, fast = (d.peak_pressure.value for d in speeds)
    # Four times the speed is sixteen times the torque; the share of the slices hardly changes.
    assert fast / slow == pytest.approx(4.0, rel=0.02)


def test_contact_normals_carry_the_lever():
    cam, setup = indexer(8)
    theta = np.linspace(0.1, 6.0, 31)
    e = Engagement(cam.mechanism(setup).tracks, cam.mechanism(setup).within, theta)
    assert e.count.min() >= 1
    slim = cam.model_copy(update={"width": 40.0}).mechanism(setup)
    narrow = Engagement(cam.mechanism(setup).tracks, slim.within, theta)
    assert narrow.count.min() == 0
    assert np.all(e.lever > 0.0)
    norms = dot(np.moveaxis(e.normal, -1, 0), np.moveaxis(e.normal, -1, 0))
    assert norms[e.on] == pytest.approx(1.0)


def test_floor_stays_out_of_reach():
    for stops in (3, 8, 24):
        cam, setup = indexer(stops)
        gaps = {name: value for name, value, _ in cam.mechanism(setup).turret.gaps}
        assert gaps["roller end to floor"] > 0.9 * cam.tip_clearance
        assert cam.mechanism(setup).floor_radius > hypot(cam.mechanism(setup).tip, 0.5 * setup.roller.diameter)


def findings(text, tolerance=0.1):
    result = compute(Model(parse(text), tolerance), ("checks",))
    return {(f.check, f.where): f for f in result.findings}


def findings_of(model, check):
    return [f for f in compute(model, ("checks",), (check,)).findings if f.check == check]


def test_starter_passes_its_checks():
    found = findings(STARTER)
    assert all(f.passed for f in found.values()), [f for f in found.values() if not f.passed]
    assert found["rib-thickness", "rib tip"].value > 10.0
    assert found["hand-over", "pushing on"].value >= 1.0


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("stops = 8", "stops = 0", "at least 1"),
        ("stops = 8", "stops = 49", "48"),
        ("pitch_radius = 90", "pitch_radius = 180", "below the centre distance 180"),
        ("diameter = 30", "diameter = 62", "distance of neighbouring rollers"),
        ("globoid_radius = 80", "globoid_radius = 70", "78 .. 102"),
        ("width = 84", "width = 170", "below twice the globoid radius"),
        ("diameter = 30", "diameter = 67", "below 66.2742"),
        ("width = 84", "width = 30", "so that rollers stand beside the rib"),
        ("to = 45", "to = 40", "45"),
        ("bore = 40", "bore = 160", "groove floor"),
    ],
)
def test_bad_input_is_refused_with_the_allowed_range(old, new, words):
    with pytest.raises(ProfileError) as refused:
        parse(STARTER.replace(old, new))
    assert words in str(refused.value)


def test_to_and_fro_from_a_profile():
    motion = """[[motion]]
until = 60

[[motion]]
until = 160
to = 45
law = "modified-sine"

[[motion]]
until = 230

[[motion]]
until = 330
to = 0
law = "modified-sine"

[[motion]]
until = 360
"""
    head, rest = STARTER.split("[[motion]]", 1)
    text = head + motion + rest[rest.index("[operation]") :]
    wide, model = (Model(parse(text.replace("width = 84", f"width = {w}")), 0.1) for w in (90, 87))
    # Ninety is so wide that the grooves leave loose slivers at the ends; the advice names a width that does not.
    (fin,) = findings_of(wide, "fins")
    assert fin.value == 2.0
    assert "below 87." in fin.advice
    assert findings_of(model, "fins")[0].passed
    assert model.setup.program.closed
    assert all(track.closed for track in model.tracks)
    assert model.solid.sound
    assert model.turret_duty.contact_data()["rollers_sharing_least"] >= 1
    assert all(found.value > -1e-6 for found in model.clearances)


def test_hubs_and_keyway():
    keys = "keyway_width = 12\nkeyway_depth = 3.3\nhub_diameter = 66\nhub_length = 12"
    text = STARTER.replace("bore = 40", f"bore = 40\n{keys}")
    model = Model(parse(text), 0.1)
    plain = Model(parse(STARTER), 0.1)
    mesh = model.solid.mesh
    assert model.solid.sound
    assert float(np.ptp(mesh.vertices[:, 2])) == pytest.approx(84.0 + 24.0)
    extra = pi * (33.0**2 - 20.0**2) * 24.0 - 12.0 * 3.3 * 108.0
    assert mesh.volume - plain.solid.mesh.volume == pytest.approx(extra, rel=0.02)
    with pytest.raises(ProfileError, match="hub_diameter"):
        parse(text.replace("hub_diameter = 66", "hub_diameter = 190"))


def test_fins_are_found_and_advised():
    from types import SimpleNamespace

    from camgeom.checks.turret import fins
    from camgeom.maths.mesh import Mesh
    from camgeom.solid import Solid
    from camgeom.solid.blank import Blank

    big = Blank.cylinder(50.0, 60.0).mesh(0.5)
    fin = Blank(((1.0, 80.0), (1.0, 85.0))).mesh(0.5)
    faces = np.concatenate([big.faces, fin.faces + len(big.vertices)])
    both = Mesh(np.concatenate([big.vertices, fin.vertices]), faces)
    (finding,) = fins(SimpleNamespace(solids=(Solid("cam", both, 0.5, "boolean", 0),)))
    assert not finding.passed
    assert finding.value == 1.0
    assert "below 160 mm" in finding.advice
    (clean,) = fins(SimpleNamespace(solids=(Solid("cam", big, 0.5, "boolean", 0),)))
    assert clean.passed


def test_oscillating_drive_has_a_closed_groove_for_each_roller():
    cam, setup = indexer(8)
    steps = index_program(8).segments
    back = [replace(s, until=s.until / 2.0) for s in steps]
    rest = [replace(s, until=pi + s.until / 2.0, to=None if s.to is None else 0.0) for s in steps]
    program = type(setup.program).from_segments([*back, *rest], closed=True, angular=True)
    setup = replace(setup, program=program)
    tracks = cam.mechanism(setup).tracks
    assert all(track.closed for track in tracks)
    assert 2 <= len(tracks) <= 4
    (part,) = cam.mechanism(setup).parts
    solid = part.solid(0.2)
    assert solid.mesh.watertight
    assert solid.sound
    assert radians(45.0) == pytest.approx(max(s.after for s in program.spans))


def test_preload_adds_to_the_load_it_shares():
    """Equilibrium with the preload in it: alone in the dwell, on top of the torque in the index."""
    plain, tight = (
        Model(parse(STARTER.replace("bore = 40", f"bore = 40\npreload = {p}").replace("speed = 100", "speed = 300")))
        for p in (0.0, 0.006)
    )
    loose, duty = plain.turret_duty, tight.turret_duty
    assert loose.preload_pressure == 0.0
    rest = int(np.argmin(np.abs(duty.theta)))
    assert loose.pressure[rest].max() == 0.0
    assert duty.pressure[rest].max() == pytest.approx(duty.preload_pressure, rel=1e-9)
    sign = np.where(duty._on_walls[0][0] > 0.0, 1.0, -1.0)
    carried = (sign * duty.line_load * duty._cover * duty._walls(duty.engagement.lever)).sum(axis=(1, 2))
    assert carried == pytest.approx(duty.turret_torque, rel=1e-9, abs=1e-6 * np.abs(duty.turret_torque).max())
    assert duty.peak_pressure.value > max(loose.peak_pressure.value, duty.preload_pressure)
    assert duty.cam_life < loose.cam_life
    # No slice presses both walls of its groove.
    assert not np.any((duty._on_walls[0][0] > 0.0) & (duty._on_walls[0][1] > 0.0))
    faint = replace(loose, preload=1e-12)
    assert faint.peak_pressure.value == pytest.approx(loose.peak_pressure.value, rel=1e-6)


def test_rollers_beside_the_end_faces_count():
    """In a groove cam's dwell the neighbours' middles stand beyond the end faces; their near sides still bear."""
    cam, setup = indexer(24, "groove")
    theta = np.array([0.0])
    assert Engagement(cam.mechanism(setup).passages, cam.mechanism(setup).within, theta).count[:, 0].tolist() == [2, 2]
    assert Engagement(cam.mechanism(setup).tracks, cam.mechanism(setup).within, theta).count[:, 0].tolist() == [1, 1]
    for (long,), (short,) in [(cam.mechanism(setup).passages, cam.mechanism(setup).tracks)]:
        assert long.span[0] < short.span[0] < short.span[1] < long.span[1]


def test_hoops_at_the_end_faces_are_found_and_advised():
    """The dwell's outermost wall leaves the blank at z = Rg sin(tau) + r cos(tau), its foot at the floor's depth."""
    half = pi / 8.0
    cam = parse(STARTER).cam
    floor = cam.mechanism(parse(STARTER).setup()).floor_radius
    open_, foot = (2.0 * (radius * sin(half) + 15.0 * cos(half)) for radius in (80.0, np.sqrt(floor**2 - 15.0**2)))

    def found(width):
        text = STARTER.replace("width = 84", f"width = {width:.9g}")
        (finding,) = findings_of(Model(parse(text), 0.1), "horns")
        return finding

    assert found(0.999 * open_).passed
    thin = found(1.002 * open_)
    assert not thin.passed
    assert thin.value > 240.0
    assert 0.98 * open_ < float(thin.advice.split("less than ")[1].split()[0]) <= open_
    # The foot of the wall lies where a line at the roller's radius meets the floor; a wall of 1 mm stands on it.
    wide = float(thin.advice.split("more than ")[1].split()[0])
    assert wide == pytest.approx(foot + 2.0, rel=0.01)
    assert found(1.02 * wide).passed
