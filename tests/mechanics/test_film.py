"""Film, sliding and wear against the formulas written out in SI, the literature's speeds, and sums by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from camgeom.checks import judge
from camgeom.errors import ProfileError
from camgeom.mechanics.duty import slice_shares
from camgeom.mechanics.face_duty import heaped
from camgeom.mechanics.film import Oil, line_film, point_film
from camgeom.mechanics.material import Material, pair_compliance
from camgeom.report.result import compute
from tests.reference.profiles import model, said

OIL = Oil(0.04e-6, 0.022, 0.3e-3)
"""0.04 Pa s, 22 1/GPa, 0.3 um"""
STEEL = Material()
PAIR = pair_compliance(STEEL, STEEL)
WET: dict[str, Any] = {
    "lubricant__viscosity_40": 100.0, "lubricant__viscosity_100": 11.1, "lubricant__temperature": 60.0,
    "lubricant__pressure_viscosity": 20.0, "material__cam__roughness_um": 0.15, "material__roller__roughness_um": 0.2,
}  # fmt: skip


def test_both_formulas_written_out_in_si():
    # Two steel bodies, E = 206 GPa, nu = 0.3: E' = E / (1 - nu²). R 12 mm, u 2 m/s, 40 N/mm; then 500 N, k = 3.
    modulus = 206e9 / (1 - 0.09)
    u, g = 0.04 * 2.0 / (modulus * 0.012), 22e-9 * modulus
    line = 0.012 * 2.65 * u**0.70 * g**0.54 * (40e3 / (modulus * 0.012)) ** -0.13
    assert float(line_film(2000.0, 1 / 12.0, 40.0, OIL, PAIR)) == pytest.approx(1e3 * line, rel=1e-12)
    point = 0.012 * 3.63 * u**0.68 * g**0.49 * (500 / (modulus * 0.012**2)) ** -0.073 * (1 - np.exp(-0.68 * 3))
    assert float(point_film(2000.0, 1 / 12.0, 500.0, 3.0, OIL, PAIR)) == pytest.approx(1e3 * point, rel=1e-12)
    # With the contact modulus E* by mistake the line film is only 2 % off: the test must see that.
    wrong = 0.012 * 2.65 * (2 * u) ** 0.70 * (g / 2) ** 0.54 * (2 * 40e3 / (modulus * 0.012)) ** -0.13
    assert abs(wrong / line - 1.0) == pytest.approx(0.02, abs=0.005)


@pytest.mark.parametrize(("way", "printed"), [(0.01, 0.059), (1.0, 0.281)])
def test_a_published_exercise_s_ball_on_an_inclined_plane(way: float, printed: float) -> None:
    """A steel ball of 30 mm rolls from rest down a plane of 45 degrees: 0.059 and 0.281 um after 10 mm and 1 m.

    Exercise with printed answers (tutorbin.com, "A steel ball starts rolling from rest down a steel plate"): 50 cP,
    22 1/GPa, E 210 GPa, nu 0.3, 7 800 kg/m³. It takes half the speed of the centre, and 1/R = 1/Rx + 1/Ry where Hamrock
    and Dowson have Rx: the formula is theirs, that radius is Stachowiak and Batchelor's (Engineering Tribology, 2nd
    edition, page 291). The ellipse is 1.0339 (Ry/Rx)^0.636 long.
    """
    ball = Material(elastic_modulus=210000.0, poisson=0.3)
    force = 7800 * np.pi * 0.03**3 / 6 * 9.81 * np.cos(np.pi / 4)
    centre = np.sqrt(2 * 5 / 7 * 9.81 * np.sin(np.pi / 4) * way)
    oil, pair = Oil(0.05e-6, 0.022, 0.3e-3), pair_compliance(ball, ball)
    film = 1e3 * float(point_film(500.0 * centre, 1 / 7.5, force, 1.0339, oil, pair))
    assert film == pytest.approx(printed, abs=0.0005)
    # With their Rx = 15 mm and the whole speed of rolling, it is more than twice that.
    assert float(point_film(1e3 * centre, 1 / 15.0, force, 1.0339, oil, pair)) > 2e-3 * film


def test_a_published_exercise_s_cam_on_a_convex_follower() -> None:
    """A steel cam of radius 10 mm slides on a still follower of 40 mm: roughness 0.0768 um of each keeps them apart.

    Exercise with a printed answer (tutorbin.com, "The highly loaded cam shown below has a minimum radius of 10 mm"):
    4 kN on a width of 20 mm, 0.1 m/s, 1.44 Pa s, 28 1/GPa, E 207 GPa, nu 0.3. The answer follows with lambda 3 from the
    formula of an ellipse without end, k infinite, into which the whole load goes: the width it then does not need.
    """
    steel = Material(elastic_modulus=207000.0, poisson=0.3)
    oil, pair, bend = Oil(1.44e-6, 0.028, 0.3e-3), pair_compliance(steel, steel), 1 / 10.0 + 1 / 40.0
    rough = 1e3 / (3.0 * np.sqrt(2.0))
    assert rough * float(point_film(50.0, bend, 4000.0, np.inf, oil, pair)) == pytest.approx(0.0768, abs=0.00005)
    # The formula of a line, with the load on its width, allows a quarter more.
    assert rough * float(line_film(50.0, bend, 4000.0 / 20.0, oil, pair)) == pytest.approx(0.0968, abs=0.00005)


def test_a_flat_face_draws_oil_in_as_the_literature_has_it():
    # Translating flat face: the contact runs along the cam by rb + s + s'', along the face by s'' (per rad).
    made = model("disc_flat_face", **WET)
    touch, program = made.mechanism.touches[0], made.setup.program
    phi = np.linspace(0.1, 6.2, 50)
    s, _, dds = program.jet(phi, 2)[:3]
    base = made.profile.cam.base_radius
    at = touch.at(phi)
    assert at.passing == pytest.approx(np.abs(0.5 * (base + s + 2.0 * dds)), rel=1e-9, abs=1e-9)
    assert at.sliding == pytest.approx(base + s, rel=1e-9)
    film, drive = made.film, made.drive
    assert film is not None
    angle = np.array([film.least.cam_angle])
    speed = made.load.omega * float(touch.at(angle).passing[0])
    oil = Oil.between(made.profile.oil, made.profile.material.cam, made.profile.material.roller)
    assert oil is not None
    force = float(drive.force.panels.at(drive.normals[touch.name], angle)[0])
    thick = line_film(speed, touch.at(angle).relative, force / touch.length, oil, PAIR)
    assert film.thickness == pytest.approx(float(thick[0]), rel=1e-6)
    assert film.least.value == pytest.approx(film.thickness / np.hypot(0.15e-3, 0.2e-3), rel=1e-12)


def test_a_roller_in_a_dwell_meets_the_cam_at_its_rim_speed():
    made = model("disc_offset_roller", **WET, roller__shape="cylinder", roller__crown_radius=None, follower__offset=0.0)
    duty, theta = made.duty, np.radians(320.0)
    passing, on_cam, sliding = (duty.force.panels.at(one[5], np.array([theta]))[0] for one in duty._runs)
    assert passing == pytest.approx(34.0, rel=1e-9)
    assert on_cam == pytest.approx(34.0, rel=1e-9)
    assert sliding == pytest.approx(0.0, abs=1e-9)
    assert duty.rubbed == pytest.approx(0.0, abs=1e-6)


def test_a_drum_s_roller_slides_where_it_is_not_quoted():
    duty = model("pin_insertion", **WET).duty
    # In the dwell at 100 deg the wall runs by the radius, the roller's rim as at the quoted radius of 66.
    at = duty.force.panels.at
    rolled = float(at(duty.pressing.path_rate, np.array([1.7]))[0])
    places = at(duty.slice_places[0], np.array([1.7])), at(duty.slice_places[10], np.array([1.7]))
    for number, place in zip((0, 10), places, strict=True):
        passing, on_cam, sliding = (at(one[number], np.array([1.7]))[0] for one in duty._runs)
        assert on_cam == pytest.approx(place[0], rel=1e-9)
        assert sliding == pytest.approx(abs(place[0] - rolled), rel=1e-9)
        assert passing == pytest.approx(0.5 * (place[0] + rolled), rel=1e-9)


def test_the_film_has_two_sides_and_says_what_is_missing():
    ratio = model("pin_insertion", **WET).film.least.value
    for share, level in ((0.999, "pass"), (1.002, "fail")):
        made = model("pin_insertion", **WET, limits__film_ratio=share * ratio)
        assert [f.level for f in said(made, "film")] == [level]
    for share, level in ((0.999, "pass"), (1.002, "warn")):
        made = model("pin_insertion", **WET, limits__warn_film_ratio=share * ratio)
        assert [f.level for f in said(made, "film")] == [level]
    (word,) = judge(model("pin_insertion"), ["film"]).not_judged
    assert "[lubricant]" in word.reason
    dry = {key: value for key, value in WET.items() if "pressure" not in key and "roughness" not in key}
    (word,) = judge(model("pin_insertion", **dry), ["film"]).not_judged
    assert "lubricant.pressure_viscosity" in word.reason
    assert "material.roller.roughness_um" in word.reason


def test_a_crown_is_an_ellipse_and_says_where_the_fit_ends():
    found = model("disc_offset_roller", **WET)
    assert found.film.ellipse == pytest.approx(13.5, abs=0.1)
    assert "beyond the 8 of the formula's fit" in said(found, "film")[0].where
    strong = model("disc_offset_roller", **WET, roller__crown_radius=50.0)
    assert strong.film.fitted
    assert "beyond" not in said(strong, "film")[0].where


def test_a_turret_has_a_film():
    made = model("tool_changer", **WET)
    assert 0.5 < made.film.least.value < 5.0
    assert said(made, "film")[0].value == made.film.least.value


def test_temperature_of_a_state_thins_its_film():
    states = ({"share": 0.5}, {"share": 0.5, "temperature": 95.0, "name": "hot"})
    made = model("pin_insertion", **WET, duty=states)
    cold, hot = (one.film.least.value for one in made.states)
    assert hot < 0.6 * cold
    (finding,) = said(made, "film")
    assert finding.value == hot
    assert "state 'hot'" in finding.where


def test_heat_of_sliding_by_hand():
    made = model("disc_flat_face", **WET, lubricant__friction=0.08)
    drive, turn = made.drive, np.linspace(0.0, 2 * np.pi, 200_001)
    touch = made.mechanism.touches[0]
    force = drive.force.panels.at(drive.normals[touch.name], turn)
    work = np.trapezoid(force * touch.at(turn).sliding, turn)
    assert made.friction_power == pytest.approx(0.08 * work * 1e-3 * made.load.omega / (2 * np.pi), rel=1e-5)
    assert compute(made, ("fatigue",)).data["fatigue"]["friction_power_w"] == made.friction_power
    assert model("disc_flat_face", **WET).friction_power is None


def test_what_is_heaped_is_what_is_laid():
    # A contact that stands: all the work under one ellipse, 2 / (pi half) at its middle.
    still = heaped(np.full(100, 3.0), np.full(100, 0.2), np.full(100, 5.0))
    assert still == pytest.approx(500.0 * 2.0 / (np.pi * 0.2), rel=0.01)
    # One that runs evenly and far lays work per step over length per step.
    even = heaped(np.linspace(0.0, 50.0, 20_001), np.full(20_001, 0.2), np.full(20_001, 5.0))
    assert even == pytest.approx(5.0 / 0.0025, rel=0.01)
    # Round a cam the end lies on the beginning.
    twice = heaped(np.linspace(0.0, 100.0, 40_001), np.full(40_001, 0.2), np.full(40_001, 5.0), 50.0)
    assert twice == pytest.approx(2 * 5.0 / 0.0025, rel=0.01)
    # A contact far wider than the way round lies evenly on all of it.
    wide = heaped(np.linspace(0.0, 1.0, 201), np.full(201, 500.0), np.full(201, 5.0), 1.0)
    assert wide == pytest.approx(201 * 5.0, rel=0.01)


def test_wear_of_a_cam_point_is_load_times_slip_per_pass():
    made = model("disc_flat_face", **WET, material__cam__wear_rate=1e-8)
    drive, touch = made.drive, made.mechanism.touches[0]
    turn = np.linspace(0.0, 2 * np.pi, 20_001)
    at = touch.at(turn)
    force = drive.force.panels.at(drive.normals[touch.name], turn) / touch.length
    most = float((force * at.sliding / np.abs(at.curve.speed)).max())
    assert drive.rubbing["cam"] == pytest.approx(most, rel=0.02)
    assert made.wear == pytest.approx({"cam": 1e-11 * drive.rubbing["cam"]})
    depth = made.wear_per_hour["cam"] * 1e3 * 2000.0
    for share, level in ((1.001, "pass"), (0.998, "fail")):
        judged = model("disc_flat_face", **WET, material__cam__wear_rate=1e-8, limits__life_h=2000.0,
                       limits__wear_um=share * depth)  # fmt: skip
        assert [f.level for f in said(judged, "wear")] == [level]
    (word,) = judge(model("disc_flat_face"), ["wear"]).not_judged
    assert "wear_rate" in word.reason
    assert said(model("pin_insertion"), "wear") == []


@pytest.mark.parametrize(("name", "over"), [("tool_changer", 1.982), ("barrel_indexer", 1.714)])
def test_a_turrets_roller_wears_by_all_places_of_its_passage(name: str, over: float) -> None:
    """What all contacts rub, spread evenly over all rollers, is the mean; nowhere can the largest be below it. How
    far it is above is that of 61 slices."""
    made = model(name)
    duty, roller = made.turret_duty, made.mechanism.roller
    surface = made.mechanism.turret.follower.count * np.pi * roller.diameter * roller.length
    assert duty.rubbing["roller"] == pytest.approx(over * duty.rubbed / surface, rel=0.04)


def test_a_cylinder_on_a_drum_rubs_most_at_its_ends() -> None:
    """It rolls in its middle, at the radius m; at the radius R the wall runs by hypot(R, s') a rad: rubbed is what is
    between. Of the ends, not of the middles of slices beside them, which rub 8/9 of it."""
    duty = model("pin_insertion").duty
    turn = np.linspace(0.0, 2.0 * np.pi, 100_001)
    ds = duty.track.program.jet(turn, 1)[1]
    load = np.abs(duty.force.panels.at(duty.normal, turn)) / duty.length
    slid = {radius: np.abs(np.hypot(radius, ds) - np.hypot(61.0, ds)) for radius in np.linspace(55.0, 67.0, 121)}
    worn = {radius: np.trapezoid(load * slip, turn) / (np.pi * 22.0) for radius, slip in slid.items()}
    # A point of the cam is passed at the speed of the contact along its wall, which is curved.
    ends = np.broadcast_to(np.array([55.0, 67.0])[:, None, None], (2, *duty.normal.shape))
    _, on_cam, slip = duty.pressing.runs(ends)
    passed = float((np.abs(duty.normal) / duty.length * slip / on_cam).max())
    assert max(worn, key=lambda radius: worn[radius]) in (55.0, 67.0)
    # The load is shared by lines that approach alike: a little more at the end that is curved more.
    assert duty.rubbing["roller"] == pytest.approx(max(worn.values()), rel=1e-2)
    assert duty.rubbing["cam"] == pytest.approx(passed, rel=2e-2)
    heat = np.trapezoid(load * np.trapezoid(list(slid.values()), dx=0.1, axis=0), turn)
    assert duty.rubbed == pytest.approx(heat, rel=3e-2)


def test_slices_and_their_ends_make_up_what_is_straight_on_either_side_of_the_middle() -> None:
    for count in (7, 9):
        off = np.abs((np.arange(count) + 0.5) * 2.0 / count - 1.0)
        ended = np.concatenate([[1.0], off, [1.0]])
        assert slice_shares(count) @ ended * 2.0 / count == pytest.approx(1.0, rel=1e-14)


def test_a_drums_crown_slides_within_its_ellipse() -> None:
    """Load per length 3 N (1 - u²) / (4 a) at u a from the crest, which slides by s u a: in all 3/8 N s a, at most
    N s / sqrt(12) at a place. It was taken to roll all along, without heat and wear."""
    duty = model("pin_insertion", roller__shape="crowned", roller__crown_radius=100.0).duty
    crown, where = duty.crowned, duty.force.panels
    assert crown is not None
    _, on_cam, slip = (each[0] for each in duty.pressing.runs(crown.crest[None] + 1.0, crown.crest))
    load = np.abs(duty.normal) * slip
    assert duty.rubbed == pytest.approx(float(where.integral(0.375 * load * crown.ellipse.along)), rel=5e-3)
    assert duty.rubbing["cam"] == pytest.approx(float((load / on_cam).max()) / np.sqrt(12.0), rel=0.02)
    wear = {"material__cam__wear_rate": 1e-8, "limits__life_h": 1000.0}
    depth = 1e-8 * duty.rubbing["cam"] * duty.speed / (2.0 * np.pi) * 3.6e6
    for share, level in ((1.002, "pass"), (0.998, "fail")):
        made = model("pin_insertion", roller__shape="crowned", roller__crown_radius=100.0, **wear,
                     limits__wear_um=share * depth)  # fmt: skip
        assert [found.level for found in said(made, "wear")] == [level]


def test_a_narrow_crown_slides_within_its_ellipse() -> None:
    """Half as long a contact rubs half as far under the same load, on half the place: the depth stays, the heat halves.

    Of seven equal slices one touched, and slid nowhere: no heat, no wear.
    """
    wide, narrow = (model("tool_changer", roller__shape="crowned", roller__crown_radius=radius).turret_duty
                    for radius in (800.0, 100.0))  # fmt: skip
    assert wide is not None
    assert narrow is not None
    share = narrow.contact_length / wide.contact_length
    assert share == pytest.approx(0.41, abs=0.02)
    assert narrow.rubbed / wide.rubbed == pytest.approx(share, rel=0.2)
    for body in ("roller", "cam"):
        assert narrow.rubbing[body] == pytest.approx(wide.rubbing[body], rel=0.15)


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"material__cam__roughness_um": 0.2}, "pressure_viscosity"),
        ({"limits__film_ratio": 2.0}, "roughness_um"),
        ({"limits__wear_um": 2.0}, "wear_rate"),
        ({"lubricant__viscosity_40": 9.0, "lubricant__viscosity_100": 12.0, "lubricant__temperature": 60.0}, "thinner"),
        ({"duty": ({"share": 1.0, "temperature": 60.0},)}, "temperature"),
    ],
)
def test_what_means_nothing_is_refused(changes, word):
    with pytest.raises(ProfileError) as caught:
        model("pin_insertion", **changes)
    assert word in str(caught.value)


@pytest.mark.parametrize("name", ["disc_offset_roller", "disc_face_groove"])
def test_a_crown_on_a_disc_whose_own_slip_is_not_computed_tells_no_wear(name: str) -> None:
    """It wore 0 um, whatever its keys said; a cylinder there slides nowhere, and wears nothing."""
    keys = {**WET, "lubricant__friction": 0.07, "material__cam__wear_rate": 1e-8, "material__roller__wear_rate": 1e-8,
            "limits__life_h": 1000.0, "limits__wear_um": 5.0}  # fmt: skip
    crown = {"roller__shape": "crowned", "roller__crown_radius": 300.0}
    made = model(name, **keys, **crown)
    (word,) = judge(made, ["wear"]).not_judged
    assert all(key in word.reason for key in ("cam.wear_rate", "roller.wear_rate", "lubricant.friction"))
    assert said(made, "wear") == []
    assert (made.wear, made.friction_power) == ({}, None)
    assert not judge(model(name, **crown), ["wear"]).not_judged
    straight = model(name, **keys, roller__shape="cylinder", roller__crown_radius=None)
    assert straight.friction_power == pytest.approx(0.0, abs=1e-9)
    assert {found.level for found in said(straight, "wear")} == {"pass"}
    drum = model("pin_insertion", **keys, **crown)
    assert drum.friction_power is not None
    assert drum.friction_power > 0.0
