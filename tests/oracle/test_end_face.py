"""End-face cams against closed forms: the end of a ring under a roller, the spring that holds it, the walls."""

from __future__ import annotations

from dataclasses import replace
from math import atan, cos, degrees, pi, radians

import numpy as np
import pytest

from camgeom.checks import findings, judge
from camgeom.errors import DesignError, ProfileError
from camgeom.model import Model
from camgeom.profile import parse

BASE = """
name = "ring"
[cam]
kind = "end-face"
diameter = 120
inner_diameter = 84
height = {height}
web = {web}
direction = "{direction}"
[follower]
{follower}
[roller]
{roller}
[[motion]]
until = 110
to = {stroke}
law = "cycloidal"
[[motion]]
until = 170
[[motion]]
until = 300
to = 0
law = "cycloidal"
[[motion]]
until = 360
[operation]
speed = {speed}
spring_rate = 2
spring_preload = {preload}
[output]
tolerance = 0.01
"""
CYLINDER = "diameter = 26\nlength = 14"
CONE = f'shape = "cone"\ndiameter = 26\nlength = 14\nhalf_angle = {degrees(atan(13.0 / 51.0))}'


def ring(**keys: object) -> Model:
    given = {"height": 40, "web": 15, "direction": "ccw", "follower": 'kind = "translating"\nmass = 1.5',
             "roller": CYLINDER, "stroke": 20.0, "speed": 200.0, "preload": 80.0}  # fmt: skip
    return Model(parse(BASE.format(**given | keys)))


def finding(model: Model, name: str):
    return next(iter(findings(model, [name])))


@pytest.mark.parametrize("direction", ["ccw", "cw"])
def test_the_end_face_is_the_lower_parallel_of_the_developed_path(direction: str) -> None:
    # At the distance delta along its axis a cylinder stands over the path (delta phi, s); its lower contact is
    # r below along the normal, which makes the angle alpha with Z, tan alpha = s' / delta.
    model, r = ring(direction=direction), 13.0
    mesh = model.solids[0].mesh
    x = mesh.vertices[mesh.group_vertices("flank")]
    theta = np.linspace(-0.5, 2.0 * pi + 0.5, 14401)
    s, ds = model.setup.program.jet(theta % (2.0 * pi), 1)
    sense = 1.0 if direction == "ccw" else -1.0
    for point in x[:: max(1, len(x) // 60)]:
        # delta from the radius: rho^2 = delta^2 + (r sin alpha)^2
        rho, z = float(np.hypot(point[0], point[1])), float(point[2])
        delta = np.full_like(theta, rho)
        for _ in range(60):
            delta = np.sqrt(rho**2 - (r * ds / np.hypot(delta, ds)) ** 2)
        sine, cosine = ds / np.hypot(delta, ds), delta / np.hypot(delta, ds)
        # A rise is touched on the side that is still to come.
        place = -sense * (theta + np.arcsin(r * sine / rho))
        off = np.angle(np.exp(1j * (place - np.arctan2(point[1], point[0]))))
        height = 53.0 + s - r * cosine
        at = np.flatnonzero((off[1:] * off[:-1] <= 0.0) & (np.abs(off[1:]) < 0.1))
        share = off[at] / (off[at] - off[at + 1])
        found = height[at] + share * (height[at + 1] - height[at])
        assert np.abs(found - z).min() < 2e-5


def test_pressure_angle_and_force_are_those_of_the_plane_path() -> None:
    model = ring()
    theta = radians(55.0)
    slope = float(model.setup.program.jet(np.array([theta]), 1)[1][0])
    found = finding(model, "pressure-angle")
    assert found.value == pytest.approx(degrees(atan(slope / 44.0)), abs=1e-6)
    kept = model.duty.kept
    assert kept is not None
    s, _, dds = model.setup.program.jet(np.linspace(0.0, 2.0 * pi, 20001), 2)
    omega = 200.0 * pi / 30.0
    force = 80.0 + 2.0 * s + 1.5e-3 * omega**2 * dds
    assert kept.least.value == pytest.approx(force.min(), rel=1e-2)
    assert model.driven == (model.duty,)


def test_the_speed_at_which_a_spring_loses_its_roller_has_two_sides() -> None:
    rpm = ring().duty.kept.leaving_speed * 30.0 / pi
    for factor, level in ((0.999, "pass"), (1.002, "fail")):
        made = ring(speed=factor * rpm)
        assert finding(made, "contact-kept").level == level
        assert bool(made.duty.kept.lost) is (level == "fail")
    needed = ring(speed=2.0 * rpm).duty.kept.preload_needed
    for factor, level in ((0.999, "fail"), (1.002, "pass")):
        assert finding(ring(speed=2.0 * rpm, preload=factor * needed), "contact-kept").level == level


def test_a_cone_whose_point_is_on_the_axis_presses_by_its_flank_in_a_dwell() -> None:
    model = ring(roller=CONE)
    half = atan(13.0 / 51.0)
    at = model.duty.force.panels.at(model.duty.normal, np.array([radians(140.0)]))[0]
    assert at == pytest.approx((80.0 + 2.0 * 20.0) / cos(half), rel=1e-9)
    assert judge(model).level != "fail"
    wide = ring(roller=CONE.replace(f"{degrees(half)}", "30"))
    assert finding(wide, "interference").passed
    with pytest.raises(ProfileError, match=r"roller.half_angle.*comes to its point over the ring"):
        ring(roller='shape = "cone"\ndiameter = 26\nlength = 14\nhalf_angle = 55.4')


def test_the_web_bounds_the_end_face_on_both_sides() -> None:
    assert judge(ring(web=38.9), ["wall"]).level == "pass"
    assert judge(ring(web=39.1), ["wall"]).level == "fail"
    with pytest.raises(ProfileError, match=r"cam.web.*below the lowest place of the end face, 40 mm"):
        ring(web=40)
    # A cone's inner end dips below the middle of the ring.
    with pytest.raises(DesignError, match="cuts into the web"):
        _ = ring(roller=CONE, web=39.99).solids


def test_an_undercut_end_face_has_no_body() -> None:
    # Before the upper dwell the path is bent round what lies below it, at last more sharply than the roller.
    for stroke, sound in ((20.0, True), (220.0, False)):
        model = ring(stroke=stroke)
        assert finding(model, "undercut").passed is sound
        if not sound:
            with pytest.raises(DesignError, match="undercut"):
                _ = model.solids


def test_a_swinging_roller_on_the_ring_and_a_crown_that_touches_in_a_point() -> None:
    arm = 'kind = "swinging"\narm = 90\nstart_angle = -6\ninertia = 0.004'
    model = ring(follower=arm, stroke=12.0, preload=8000.0)
    verdict = judge(model)
    assert verdict.level != "fail", [f.check for f in verdict.findings if not f.passed]
    crowned = ring(roller='shape = "crowned"\ndiameter = 26\nlength = 14\ncrown_radius = 400')
    assert crowned.duty.crowned is not None
    assert crowned.duty.peak_pressure.value > 1.5 * ring().duty.peak_pressure.value
    with pytest.raises(ProfileError, match=r"roller.flank.*straight"):
        ring(roller='shape = "crowned"\ndiameter = 26\nlength = 14\ncrown_radius = 400\nflank = "conforming"')
    with pytest.raises(ProfileError, match=r"roller.shape.*cylinder, cone or crowned"):
        ring(roller='shape = "sphere"\ndiameter = 26')


def test_what_means_nothing_for_a_ring_is_refused() -> None:
    text = BASE.format(height=40, web=15, direction="ccw", follower='kind = "translating"', roller=CYLINDER, stroke=20,
                       speed=200, preload=80)  # fmt: skip
    for table, key in (("[limits]\n", "play_mm = 0.1"), ("[limits]\n", "clearance_mm = 0.1")):
        with pytest.raises(ProfileError, match=key.split()[0]):
            parse(text + table + key + "\n")
    with pytest.raises(ProfileError, match="inner_diameter"):
        parse(text.replace("inner_diameter = 84", "inner_diameter = 121"))
    with pytest.raises(ProfileError, match=r"roller.length.*width of the ring, 18 mm"):
        parse(text.replace("length = 14", "length = 18.1"))
    assert replace(Model(parse(text.replace("length = 14", "length = 18"))).mechanism).contact == (42.0, 60.0)


def test_a_follower_that_is_thrown_off_at_every_jump_is_told() -> None:
    text = BASE.format(height=40, web=15, direction="ccw", follower='kind = "translating"\nmass = 3.49',
                       roller=CYLINDER, stroke=6.48, speed=31700, preload=25.9)  # fmt: skip
    model = Model(parse(text.replace('"cycloidal"', '"trapezoidal-acceleration"')))
    kept = model.duty.kept
    assert kept is not None
    assert kept.force.force.shape == kept.lever.shape
    assert finding(model, "contact-kept").level == "fail"
