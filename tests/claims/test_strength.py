"""Pressure, life, hardness and load are judged at the hardest place: each with the side that passes and the other."""

from __future__ import annotations

from math import inf, pi
from typing import Any

import numpy as np
import pytest

from camgeom.checks import judge
from camgeom.checks.verdict import life_shown
from camgeom.errors import ProfileError
from camgeom.export.history import turn_history
from camgeom.mechanics.hardness import hardness_bound
from camgeom.mechanics.material import Material
from camgeom.model import Model
from camgeom.profile import from_data, read_data
from camgeom.report.data.load import contact_data
from camgeom.report.data.load import fatigue_data as contact_fatigue
from camgeom.report.result import compute
from tests.places import BARE, PROFILES
from tests.reference.profiles import model, said


def levels(made: Model, check: str) -> dict[str, str]:
    return {finding.where: finding.level for finding in said(made, check)}


def test_crowned_disc_shows_the_pressure_and_life_of_its_ellipse() -> None:
    duty = model("disc_offset_roller").duty
    data, lives = duty.contact_data(), duty.fatigue_data()
    assert data["peak_pressure_mpa"] == pytest.approx(754.441, abs=1e-3)
    assert data["peak_slice_pressure_mpa"] == pytest.approx(754.441, abs=1e-3)
    assert data["line_pressure_mpa"] == pytest.approx(304.608, abs=1e-3)
    assert lives["roller_life_h"] == pytest.approx(247785.9, rel=1e-5) == lives["roller_slice_life_h"]
    assert data["ellipse_half_length_mm"] < 6.0


@pytest.mark.parametrize(("factor", "level"), [(1.002, "fail"), (0.999, "pass")])
def test_crowned_disc_is_judged_by_its_ellipse(factor: float, level: str) -> None:
    life = model("disc_offset_roller", limits__life_h=247785.904 * factor)
    assert levels(life, "life")["roller"] == level
    pressure = model("disc_offset_roller", limits__contact_pressure_mpa=754.4415 / factor)
    assert [finding.level for finding in said(pressure, "contact-pressure")] == [level]


@pytest.mark.parametrize(("crown", "level"), [(500.0, "pass"), (1e5, "warn")])
def test_an_ellipse_longer_than_the_roller_is_told(crown: float, level: str) -> None:
    made = model("disc_offset_roller", roller__crown_radius=crown)
    (finding,) = said(made, "crown-length")
    assert finding.level == level
    assert made.duty.level == {"pass": "ellipse", "warn": "finite"}[level]
    # A sharp end that bears has no largest pressure: neither a pass nor a life comes from it.
    assert bool(made.duty.no_stress) == (level == "warn")
    assert ("line_pressure_mpa" in made.duty.contact_data()) == (level == "pass")


def _fullest(name: str, **keys: Any) -> tuple[float, float, float]:
    made = model(name, **keys)
    (finding,) = said(made, "crown-length")
    assert finding.value is not None
    return finding.value, finding.limit, made.duty.contact_data()["ellipse_half_length_mm"]


def test_the_longest_ellipse_stands_between_the_samples() -> None:
    # A force told in two parts has its turn sampled elsewhere: the figures are those of the same turn.
    force = {"from": 80.0, "until": 110.0, "expression": "150.0"}
    whole = _fullest("disc_offset_roller", operation__force=(force,))
    for place in (83.7, 96.1, 104.9):
        parts = (force | {"until": place}, force | {"from": place})
        assert _fullest("disc_offset_roller", operation__force=parts) == pytest.approx(whole, rel=1e-7)


def test_a_cylinder_has_no_crown_to_judge() -> None:
    made = model("disc_offset_roller", roller__shape="cylinder", roller__crown_radius=None)
    assert said(made, "crown-length") == []
    assert "line_pressure_mpa" not in made.duty.contact_data()


@pytest.mark.parametrize(("life_h", "level"), [(23064.059 * 0.999, "pass"), (23064.059 * 1.002, "fail"), (4e4, "fail")])
def test_life_of_the_pin_cam_is_that_of_its_hardest_slice(life_h: float, level: str) -> None:
    made = model("pin_insertion", limits__life_h=life_h)
    assert levels(made, "life")["roller"] == level
    data = made.duty.fatigue_data()
    assert data["roller_slice_life_h"] == pytest.approx(23064.059, rel=1e-5)
    assert data["roller_life_h"] == pytest.approx(45347.0, rel=1e-4)
    assert data["cam_slice_life_h"] < data["cam_life_h"]


@pytest.mark.parametrize("more", [{"operation__guide_friction": 0.1}, {"roller__end_radius": 1.0},
                                  {"cam__running_clearance": 0.01, "impact": {"turns": 2}}])  # fmt: skip
def test_where_figures_are_quoted_moves_none_that_is_judged(more: dict[str, Any]) -> None:
    keys = {"roller__dynamic_rating": 2e4, "roller__static_rating": 25e3, "limits__torque_n_m": 900.0, **more}
    one, other = (model("pin_insertion", cam__pitch_radius=at, **keys) for at in (55.0, 67.0))
    names = ["load", "life", "bearing", "contact-pressure", "torque", "impact-pressure", "impact-torque"]
    told, again = (judge(made, names).findings for made in (one, other))
    assert len(told) >= 5 + 2 * ("impact" in more)
    assert [finding.value for finding in told] == [finding.value for finding in again]


def test_the_force_of_a_contact_is_that_of_all_of_its_places() -> None:
    made = model("pin_insertion")
    force, slope = made.duty.force.force, made.duty.force.ds
    # Slices that approach alike along the motion bear by the cosine of their pressure angle.
    radius = np.linspace(55.0, 67.0, 401)[:, None, None]
    cosine = radius / np.hypot(radius, slope)
    borne = np.abs(force) * cosine.sum(axis=0) / (cosine**2).sum(axis=0)
    assert made.duty.peak_force.value == pytest.approx(float(borne.max()), rel=1e-3)
    # the literature's force is that at the pitch radius
    told = made.duty.contact_data()
    classical = np.abs(force * np.hypot(67.0, slope) / 67.0).max()
    assert told["peak_force_n"] == pytest.approx(float(classical), rel=1e-3)
    assert told["peak_middle_force_n"] == made.duty.peak_force.value > 1.05 * told["peak_force_n"]
    assert "peak_middle_force_n" not in model("disc_face_groove").duty.contact_data()


@pytest.mark.parametrize(("name", "low", "high"), [("pin_insertion", 55.0, 67.0), ("end_face_lifter", 45.5, 58.5)])
def test_the_quoted_place_lies_where_the_roller_touches(name: str, low: float, high: float) -> None:
    """Beyond it, in the groove's depth and on the ring, forces and pressures were those of the middle, in silence."""
    data = read_data(PROFILES / f"{name}.toml")
    for quoted in (low - 0.01, low, high, high + 0.01):
        changed = {**data, "cam": {**data["cam"], "pitch_radius": quoted}}
        if low <= quoted <= high:
            (duty,) = Model(from_data(changed)).duties
            assert duty.quoted.station == pytest.approx(quoted)
        else:
            with pytest.raises(ProfileError, match="where the roller touches"):
                from_data(changed)


@pytest.mark.parametrize("name", ["disc_flat_face", "constant_width_press"])
def test_faces_have_a_life_that_is_judged(name: str) -> None:
    lives = model(name).drive.lives  # type: ignore[union-attr]
    assert set(lives) == {"cam", "face"}
    for body in lives:
        for factor, level in ((0.999, "pass"), (1.002, "fail")):
            few = {f"material__{part}__contact_limit": 10.0 for part in ("cam", "roller")}
            least = model(name, **few).drive.lives[body]  # type: ignore[union-attr]
            assert levels(model(name, limits__life_h=least * factor, **few), "face-life")[body] == level
    # The contact sweeps the face to and fro, a cam point is met once in a turn (twice between two faces).
    assert lives["face"] < lives["cam"] * 1.001
    assert said(model(name), "face-life") == []


def test_cam_life_of_one_face_is_that_of_its_hardest_point() -> None:
    drive = model("disc_flat_face").drive
    assert drive is not None
    peak = drive.peak_pressure
    assert peak is not None
    damage = (peak.value / drive.cam.contact_limit) ** drive.cam.exponent / drive.cam.contact_cycles
    assert drive.lives["cam"] == pytest.approx(1.0 / (damage * 60.0 * 900.0), rel=1e-9)


def test_a_curved_face_is_judged_and_a_knife_edge_is_not() -> None:
    curved = model("disc_flat_face", follower__face="curved", follower__face_radius=80.0, follower__face_width=None,
                   limits__life_h=1e9)  # fmt: skip
    assert [finding.level for finding in said(curved, "face-pressure")] == ["pass"]
    assert set(levels(curved, "face-life")) == {"cam", "face"}
    knife = model("disc_flat_face", follower__face="knife", follower__face_width=None,
                  limits__contact_pressure_mpa=None)  # fmt: skip
    verdict = judge(knife, ["face-pressure", "face-life"])
    assert [(word.check, "radius" in word.reason) for word in verdict.not_judged] == [
        ("face-pressure", True),
    ]


IDLE = {"friction": 0.0, "force": None, "spring_rate": 0.0, "spring_preload": 0.0, "gravity": 0.0}


@pytest.mark.parametrize("name", ["pin_insertion", "disc_flat_face", "disc_offset_roller", "tool_changer"])
def test_no_load_gives_a_result_and_a_warning(name: str) -> None:
    key = "inertia" if name == "tool_changer" else "mass"
    idle = {f"operation__{k}": v for k, v in IDLE.items()} | {f"follower__{key}": 0.0, "dynamics": None}
    if name == "tool_changer":
        idle = {k: v for k, v in idle.items() if not k.endswith("gravity")}
    made = model(name, **idle)
    data = compute(made, ["contact", "fatigue"]).data
    assert data["contact"]["peak_pressure_mpa"] == 0.0
    assert data["fatigue"]["cam_life_h"] is None
    assert [finding.level for finding in said(made, "load")] == ["warn"]
    assert [finding.level for finding in said(model(name, dynamics=None), "load")] == ["pass"]


@pytest.mark.parametrize(("name", "key"), [("pin_insertion", "mass"), ("tool_changer", "inertia")])
def test_a_mass_that_is_not_given_is_told(name: str, key: str) -> None:
    (finding,) = said(model(name, **{f"follower__{key}": None, "dynamics": None}), "moving-mass")
    assert finding.level == "warn"
    assert f"follower.{key}" in finding.advice
    assert said(model(name), "moving-mass") == []
    assert said(model(name, **{f"follower__{key}": 0.0, "dynamics": None}), "moving-mass") == []
    carried = {f"follower__{key}": None, f"operation__load_{key}": 1.0, "dynamics": None}
    assert said(model(name, **carried), "moving-mass") == []


@pytest.mark.parametrize(
    ("hardness", "limit", "level"),
    [
        (12.0, 1300.0, "fail"),
        (39.9, 600.0 * 0.999, "pass"),
        (39.9, 600.0 * 1.002, "fail"),
        (40.0, 1000.0 * 0.999, "pass"),
        (59.9, 1000.0 * 1.002, "fail"),
        (60.0, 1300.0, "pass"),
        (60.0, 2450.0 * 0.999, "pass"),
        (60.0, 2450.0 * 1.002, "fail"),
    ],
)
def test_a_contact_limit_asks_for_its_hardness(hardness: float, limit: float, level: str) -> None:
    made = model("tool_changer", material__cam__hardness=hardness, material__cam__contact_limit=limit)
    assert levels(made, "hardness") == {"cam, material.cam.contact_limit": level}


@pytest.mark.parametrize(("limit", "level"), [(1000.0 * 0.999, "pass"), (1000.0 * 1.002, "fail"), (5000.0, "fail")])
def test_hardness_judges_the_pressure_that_the_profile_allows(limit: float, level: str) -> None:
    """A soft cam does not bear more because the limit stands in another table."""
    soft = {"material__cam__hardness": 50.0, "material__cam__contact_limit": 900.0}
    made = model("disc_offset_roller", limits__contact_pressure_mpa=limit, **soft)
    assert levels(made, "hardness") == {"cam, limits.contact_pressure_mpa": level}


@pytest.mark.parametrize(("factor", "level"), [(1.002, "pass"), (0.999, "fail")])
def test_pressure_and_hardness_take_the_limit_at_the_same_cycles(factor: float, level: str) -> None:
    """2450 MPa for one cycle are 167 MPa for ten million: what hardness judges, the pressure has to meet."""
    peak = model("disc_offset_roller").duty.peak_pressure.value
    made = model("disc_offset_roller", material__cam__contact_limit=peak * factor * 1e7 ** (1.0 / 6.0),
                 material__cam__contact_cycles=1.0, material__cam__hardness=45.0)  # fmt: skip
    (finding,) = said(made, "contact-pressure")
    assert (finding.level, finding.limit) == (level, pytest.approx(factor * peak))
    assert said(made, "hardness")[0].value == pytest.approx(factor * peak)


@pytest.mark.parametrize(("share", "level"), [(0.999, "fail"), (1.002, "warn"), (1.499, "warn"), (1.502, "pass")])
def test_a_static_rating_is_judged_without_a_key(share: float, level: str) -> None:
    """ISO 76: from the rated load on a rolling element stays dented; makers ask for 1.5 in ordinary running."""
    force = model("disc_offset_roller").duty.peak_force.value
    (finding,) = said(model("disc_offset_roller", roller__static_rating=share * force), "bearing")
    assert (finding.level, finding.value) == (level, pytest.approx(share, rel=1e-4))
    assert finding.cam_angle_deg is not None
    asked = model("disc_offset_roller", roller__static_rating=share * force, limits__warn_bearing_static_safety=share)
    assert said(asked, "bearing")[0].level in (level, "pass")
    assert said(model("disc_offset_roller", roller__static_rating=None), "bearing") == []


PULSES = (
    {"from": 140.0, "until": 148.0, "expression": "8400*sin((deg-140.0)*pi/8)**2"},
    {"from": 14.0, "until": 22.0, "expression": "14500*sin((deg-14.0)*pi/8)**2"},
)


@pytest.mark.parametrize(("pulses", "level"), [(PULSES, "fail"), (PULSES[:1], "pass")])
def test_the_shear_lies_deepest_elsewhere_than_the_largest_pressure(pulses: tuple[Any, ...], level: str) -> None:
    """A broad contact on a flat stretch of the profile reaches deeper than the hardest one on its crest."""
    made = model(
        "disc_offset_roller", roller__shape="cylinder", roller__crown_radius=None, roller__diameter=30.0,
        cam__base_radius=30.0, follower__offset=0.0, material__cam__case_depth_mm=0.6, operation__force=pulses,
        motion=({"until": 90.0, "to": 22.0, "law": "cycloidal"}, {"until": 120.0},
                {"until": 210.0, "to": 0.0, "law": "cycloidal"}, {"until": 360.0}),
    )  # fmt: skip
    (finding,) = said(made, "case-depth")
    deepest = made.duty.deepest_shear
    assert deepest is not None
    assert finding.level == level
    if level == "fail":
        assert np.degrees(deepest.cam_angle) == pytest.approx(18.0, abs=0.5)
        assert np.degrees(made.duty.peak_pressure.cam_angle) == pytest.approx(144.0, abs=0.5)


@pytest.mark.parametrize(("name", "check"), [("disc_offset_roller", "life"), ("tool_changer", "turret-life"),
                                             ("disc_flat_face", "face-life")])
def test_lives_without_a_limit_are_told(name: str, check: str) -> None:
    verdict = judge(model(name, limits__life_h=None, dynamics=None), [check])
    (word,) = verdict.not_judged
    assert verdict.findings == ()
    assert word.reason.startswith("give limits.life_h")
    assert all(body in word.reason for body in model(name).carrier.lives)  # type: ignore[union-attr]
    assert judge(model(name, limits__life_h=1.0), [check]).not_judged == ()


@pytest.mark.parametrize(("hours", "shown"), [(9.99e6, 9.99e6), (1.002e7, "unlimited"), (None, "unlimited")])
def test_a_life_is_told_in_one_way(hours: float | None, shown: float | str) -> None:
    assert life_shown(hours) == shown


def test_a_knife_edge_is_not_asked_for_its_hardness() -> None:
    knife = {"follower__face": "knife", "follower__face_width": None, "limits__contact_pressure_mpa": None}
    verdict = judge(model("disc_flat_face", **knife), ["hardness", "case-depth"])
    assert verdict.findings == () == verdict.not_judged
    for key in ("hardness", "case_depth_mm"):
        with pytest.raises(ProfileError, match=f"material.cam.{key}"):
            model("disc_flat_face", **knife, **{f"material__cam__{key}": 1.0})


def test_a_knife_edge_has_no_film_and_no_wear_and_no_limit_of_them_passes_in_silence() -> None:
    knife = {"follower__face": "knife", "follower__face_width": None, "limits__contact_pressure_mpa": None}
    words = judge(model("disc_flat_face", **knife), ["film", "wear"]).not_judged
    assert [(word.check, "knife edge" in word.reason) for word in words] == [("film", True), ("wear", True)]
    rates = {"material__cam__wear_rate": 1e-8, "material__roller__wear_rate": 1e-8}
    for key, value in {**rates, "limits__wear_um": 5.0}.items():
        with pytest.raises(ProfileError, match=key.replace("__", ".")):
            model("disc_flat_face", **knife, **{**rates, key: value})
    worn = model("disc_flat_face", **rates, limits__wear_um=1e-3, limits__life_h=1000.0)
    assert set(levels(worn, "wear").values()) == {"fail"}


def test_relative_curvature_says_where() -> None:
    (finding,) = said(model("pin_insertion"), "relative-curvature")
    assert finding.where.startswith("groove, at ")


def test_hardness_that_is_not_given_is_not_judged() -> None:
    verdict = judge(model("pin_insertion"), ["hardness"])
    assert verdict.findings == ()
    assert [word.reason.split(",")[0] for word in verdict.not_judged] == [
        f"give material.{body}.hardness" for body in ("cam", "roller")
    ]


def test_a_limit_at_fewer_cycles_is_compared_at_the_same_number() -> None:
    short = Material(contact_limit=2450.0 * 10.0 ** (1.0 / 6.0), contact_cycles=1e6, exponent=6.0)
    assert short.rated_limit == pytest.approx(2450.0)
    bounds = [hardness_bound(hrc) for hrc in (0.1, 39.9, 40.0, 59.9, 60.0, 70.0)]
    assert bounds == [600.0, 600.0, 1000.0, 1000.0, 2450.0, 2450.0]


@pytest.mark.parametrize(("factor", "level"), [(0.999, "fail"), (1.002, "pass")])
@pytest.mark.parametrize("name", ["disc_offset_roller", "pin_insertion", "disc_flat_face", "tool_changer"])
def test_a_case_is_twice_as_deep_as_the_largest_shear(name: str, factor: float, level: str) -> None:
    carrier = model(name).carrier
    assert carrier is not None
    beneath, deepest = carrier.peak_contact, carrier.deepest_shear
    assert beneath is not None
    assert deepest is not None
    assert carrier.contact_data()["shear_depth_mm"] == pytest.approx(beneath.shear_depth)
    assert deepest.value >= beneath.shear_depth * (1.0 - 1e-6)
    (finding,) = said(model(name, material__cam__case_depth_mm=2.0 * factor * deepest.value), "case-depth")
    assert (finding.level, finding.cam_angle_deg) == (level, pytest.approx(np.degrees(deepest.cam_angle) % 360.0))
    assert finding.where.startswith("cam, ")
    assert said(model(name), "case-depth") == []


def test_mean_torque_holds_the_friction_of_the_guides() -> None:
    bare, rubbing = (model("pin_insertion", operation__guide_friction=mu) for mu in (None, 0.1))
    for made in (bare, rubbing):
        duty = made.duty
        theta = np.linspace(0.0, 2.0 * pi, 200001)
        mean = np.trapezoid(duty.force.panels.at(duty.torque, np.clip(theta, 0.0, 2.0 * pi - 1e-9)), theta) / (2e3 * pi)
        assert duty.contact_data()["mean_torque_n_m"] == pytest.approx(mean, rel=1e-4)
    assert rubbing.duty.contact_data()["mean_torque_n_m"] > 1.01 * bare.duty.contact_data()["mean_torque_n_m"]


QUICK = ({"until": 90}, {"until": 120, "to": 30.0, "law": "modified-trapezoid"}, {"until": 240},
         {"until": 360, "to": 0.0, "law": "cycloidal"})  # fmt: skip
"""a rise so quick that the roller which is pressed hardest and the one that takes the most torque are two"""


def rib(**keys: Any) -> Model:
    """A drum's rib between two rollers."""
    return model("milled_drum", cam__form="rib", cam__rib_thickness=20.0, cam__length=160, cam__start=65, motion=QUICK,
                 cutter=None, operation__gravity=0.0, operation__spring_preload=15.0, **keys)  # fmt: skip


def test_the_torque_of_a_rib_is_that_of_both_rollers() -> None:
    """The same motion under the same load asks the same of the shaft, through a groove or a rib."""
    groove = model("milled_drum", cam__length=160, cam__start=65, motion=QUICK, cutter=None, operation__gravity=0.0,
                   operation__spring_preload=15.0)  # fmt: skip
    data, wanted = contact_data(rib()), contact_data(groove)
    for key in ("peak_torque_n_m", "mean_torque_n_m", "peak_force_n"):
        assert data[key] == pytest.approx(wanted[key], rel=1e-9)
    assert 1e-3 * rib().carrier.peak_torque.value < 0.7 * data["peak_torque_n_m"]
    assert [one["name"] for one in data["rollers"]] == ["lower roller", "upper roller"]
    history = turn_history(rib())
    assert np.abs(history["camshaft_torque_n_m"]).max() == pytest.approx(data["peak_torque_n_m"], rel=3e-3)


@pytest.mark.parametrize(("factor", "level"), [(1.002, "pass"), (0.998, "fail")])
def test_a_rib_is_judged_by_the_torque_of_both_rollers(factor: float, level: str) -> None:
    limit = factor * 1e-3 * rib().shaft.peak_torque.value
    (found,) = said(rib(limits__torque_n_m=limit), "torque")
    assert found.level == level


@pytest.mark.parametrize("name", ["disc_offset_roller", "pin_insertion", "disc_flat_face", "tool_changer", "two_start"])
def test_peak_torque_is_the_largest_magnitude(name: str) -> None:
    carrier = model(name).carrier
    assert carrier is not None
    where = carrier.force.panels
    size = np.abs(where.at(carrier.torque, np.linspace(0.0, 2.0 * pi - 1e-9, 100001))).max()
    assert carrier.peak_torque.value == pytest.approx(size, rel=1e-6)
    assert carrier.peak_torque.value >= np.abs(carrier.torque).max() * (1.0 - 1e-12)


def test_a_turret_roller_that_undercuts_its_wall_fails() -> None:
    """The same engagement with the curvature of one slice that bears turned negative."""
    sound = model("tool_changer").turret_duty
    assert sound is not None
    n, k, m = np.unravel_index(int(np.argmax(sound.line_load)), sound.line_load.shape)
    made = Model(model("tool_changer").profile)
    duty = made.turret_duty
    assert duty is not None
    walls = {name: values.copy() for name, values in duty.engagement._walls.items()}
    walls["curvature"][:, n, k, m] = -0.02
    vars(duty.engagement).update(_walls=walls, curvature=walls["curvature"])
    assert duty.peak_pressure.value == inf
    assert duty.lives["roller"] == 0.0 == duty.lives["cam"]
    assert [finding.level for finding in said(made, "turret-pressure")] == ["fail"]
    assert set(levels(made, "turret-life").values()) == {"fail", "pass"}
    data = compute(made, ["contact", "fatigue"]).data
    assert data["contact"]["peak_pressure_mpa"] is None or data["contact"]["peak_slice_pressure_mpa"] is None
    assert "shear_depth_mm" not in data["contact"]
    assert [finding.level for finding in said(model("tool_changer"), "turret-pressure")] == ["pass"]


def test_the_undercut_margin_of_a_face_groove_is_the_tools() -> None:
    """One minus the tool's radius by the curvature of the roller's path on the plate, by differences."""
    made = model("disc_face_groove", cam__running_clearance=0.3)
    theta, step = np.linspace(0.0, 2.0 * pi, 72001, retstep=True)
    lift = made.mechanism.program.jet(theta, 0)[0]
    centre, arm, prime = 120.0, 100.0, 57.5
    angle = np.arccos((centre**2 + arm**2 - prime**2) / (2.0 * centre * arm)) + lift
    place = (centre - arm * np.cos(angle) + 1j * arm * np.sin(angle)) * np.exp(-1j * theta)
    rate, bend = np.gradient(place, step), np.gradient(np.gradient(place, step), step)
    curvature = np.abs((np.conj(rate) * bend).imag / np.abs(rate) ** 3)[5:-5]
    (survey,) = made.flanks
    assert survey.margin.value == pytest.approx(1.0 - 12.8 * curvature.max(), abs=2e-5)
    assert survey.margin.value < 1.0 - 12.5 * curvature.max() - 5e-3


@pytest.mark.parametrize(("clearance", "level"), [(0.0, "pass"), (0.03, "fail")])
def test_a_face_groove_whose_tool_undercuts_fails(clearance: float, level: str) -> None:
    made = model("disc_face_groove", cam__running_clearance=clearance, limits__undercut_margin=0.7699)
    assert set(levels(made, "undercut").values()) == {level}


@pytest.mark.parametrize(("factor", "level"), [(1.002, "fail"), (0.999, "pass")])
def test_the_pressure_of_a_flat_face_is_found_on_a_profile_about_to_fold(factor: float, level: str) -> None:
    """The radius of the profile is base + s + s''; it is sharp over a small part of a degree."""
    program = model("disc_flat_face").mechanism.program
    theta = np.linspace(0.0, 2.0 * pi, 1_000_001)
    s, rate, bend = program.jet(theta, 2)
    base = 0.04 - float((s + bend).min())
    force = 5.0 * np.sign(rate) + 0.35 * (30.0 * pi) ** 2 * bend * 1e-3 + 110.0 + 12.0 * s
    pair = 2.0 * (1.0 - 0.3**2) / 206000.0
    square = force.clip(0.0) / (pi * 16.0 * pair * (base + s + bend))
    peak = float(np.sqrt(square.max()))
    made = model("disc_flat_face", cam__base_radius=base, cam__bore=None, limits__contact_pressure_mpa=peak / factor)
    carrier = made.carrier
    assert carrier is not None
    assert carrier.peak_pressure is not None
    assert carrier.peak_pressure.value == pytest.approx(peak, rel=1e-6)
    assert [finding.level for finding in said(made, "face-pressure")] == [level]


def yoke(force: str, **keys: Any) -> Model:
    """A constant-width cam between two rollers."""
    roller = {"shape": "cylinder", "diameter": 30.0, "length": 14.0}
    motion = ({"until": 140.0, "to": 30.0, "law": "cycloidal"}, {"until": 180.0})
    return model("constant_width_press", **BARE, follower__face_width=None, impact=None, reproduces=None, roller=roller,
                 motion=motion, operation__force=({"expression": force},), limits=keys)  # fmt: skip


def test_a_cam_that_two_rollers_of_a_yoke_run_on_bears_both() -> None:
    """Each meets a place of the one profile once in a turn, half a turn apart: 826 029 h where either alone leaves
    twice that (line contact, N = F / cos of the pressure angle, the sum of (p / 2450)^6 / 1e7)."""
    both, one = yoke("3000*sin(phi)"), yoke("-3000*abs(sin(phi))")
    assert [duty.lives["cam"] for duty in both.duties] == pytest.approx([1_652_058.0] * 2, rel=1e-5)
    assert both.lives["cam"] == pytest.approx(826_029.0, rel=1e-5)
    assert contact_fatigue(both)["cam_life_h"] == both.lives["cam"]
    assert one.lives["cam"] == pytest.approx(min(duty.lives["cam"] for duty in one.duties), rel=1e-12)
    for life, level in ((826_000.0, "pass"), (827_700.0, "fail")):
        judged = yoke("3000*sin(phi)", life_h=life, contact_pressure_mpa=2400.0)
        assert levels(judged, "life")["cam"] == level


def test_the_figures_of_a_ribs_rollers_are_those_of_the_one_that_fails_first() -> None:
    """The upper roller is pressed hardest and seldom, the lower one always."""
    force = ({"from": 0.0, "until": 350.0, "expression": "-500"}, {"from": 350.0, "until": 360.0, "expression": "900"})
    made = model("milled_drum", cutter=None, cam__form="rib", cam__rib_thickness=12.0, cam__length=110, cam__start=40,
                 follower__mass=0.001, operation__friction=0.0, operation__force=force, operation__guide_friction=None,
                 roller__dynamic_rating=9800.0, roller__static_rating=12000.0)  # fmt: skip
    lower, upper = made.duties
    assert made.duty is upper
    assert lower.bearing.judged_h < 0.5 * upper.bearing.judged_h
    data = contact_fatigue(made)
    assert data["bearing_life_h"] == pytest.approx(lower.bearing.life_h)
    assert data["bearing_mean_load_n"] == pytest.approx(lower.bearing.mean_load)
    assert data["roller_slice_life_h"] == min(one.lives["roller"] for one in made.duties)
    assert data["bearing_static_safety"] == min(one.bearing.static_safety for one in made.duties)
