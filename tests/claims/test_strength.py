"""Pressure, life, hardness and load are judged at the hardest place: each with the side that passes and the other."""

from __future__ import annotations

from math import inf, pi
from typing import Any

import numpy as np
import pytest

from camgeom.checks import judge
from camgeom.checks.verdict import Finding
from camgeom.mechanics.material import Material, hardness_bound
from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.profile.text import load
from camgeom.report.result import compute
from tests.places import PROFILES


def model(name: str, **changes: Any) -> Model:
    """A shipped profile with keys, dots written as two underscores, changed; None removes one."""
    data, _, _ = load((PROFILES / f"{name}.toml").read_text(), name)
    for key, value in changes.items():
        *tables, last = key.split("__")
        place = data
        for table in tables:
            place = place.setdefault(table, {})
        if value is None:
            place.pop(last, None)
        else:
            place[last] = value
    return Model(from_data(data, name))


def said(made: Model, check: str) -> list[Finding]:
    return list(judge(made, [check]).findings)


def levels(made: Model, check: str) -> dict[str, str]:
    return {finding.where: finding.level for finding in said(made, check)}


def test_crowned_disc_shows_the_pressure_and_life_of_its_ellipse() -> None:
    duty = model("disc_offset_roller").duty
    data, lives = duty.contact_data(), duty.fatigue_data()
    assert data["peak_pressure_mpa"] == pytest.approx(754.441, abs=1e-3)
    assert data["peak_slice_pressure_mpa"] == pytest.approx(754.441, abs=1e-3)
    assert data["line_pressure_mpa"] == pytest.approx(304.608, abs=1e-3)
    assert lives["roller_life_h"] == pytest.approx(182739.0, rel=1e-5) == lives["roller_slice_life_h"]
    assert data["ellipse_half_length_mm"] < 6.0


@pytest.mark.parametrize(("factor", "level"), [(1.002, "fail"), (0.999, "pass")])
def test_crowned_disc_is_judged_by_its_ellipse(factor: float, level: str) -> None:
    life = model("disc_offset_roller", limits__life_h=182738.92 * factor)
    assert levels(life, "life")["roller"] == level
    pressure = model("disc_offset_roller", limits__contact_pressure_mpa=754.4415 / factor)
    assert [finding.level for finding in said(pressure, "contact-pressure")] == [level]


@pytest.mark.parametrize(("crown", "level"), [(500.0, "pass"), (1e5, "warn")])
def test_an_ellipse_longer_than_the_roller_is_told(crown: float, level: str) -> None:
    made = model("disc_offset_roller", roller__crown_radius=crown)
    (finding,) = said(made, "crown-length")
    assert finding.level == level
    assert made.duty.peak_pressure.value > made.duty.contact_data()["line_pressure_mpa"]


def test_a_cylinder_has_no_crown_to_judge() -> None:
    made = model("disc_offset_roller", roller__shape="cylinder", roller__crown_radius=None)
    assert said(made, "crown-length") == []
    assert "line_pressure_mpa" not in made.duty.contact_data()


@pytest.mark.parametrize(("life_h", "level"), [(30452.8 * 0.999, "pass"), (30452.8 * 1.002, "fail"), (40000.0, "fail")])
def test_life_of_the_pin_cam_is_that_of_its_hardest_slice(life_h: float, level: str) -> None:
    made = model("pin_insertion", limits__life_h=life_h)
    assert levels(made, "life")["roller"] == level
    data = made.duty.fatigue_data()
    assert data["roller_slice_life_h"] == pytest.approx(30452.8, rel=1e-5)
    assert data["roller_life_h"] == pytest.approx(45347.0, rel=1e-4)
    assert data["cam_slice_life_h"] < data["cam_life_h"]


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
    assert said(model(name, **{f"follower__{key}": None, f"operation__load_{key}": 1.0}), "moving-mass") == []


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
    assert levels(made, "hardness") == {"cam": level}


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
    beneath = carrier.peak_contact
    assert beneath is not None
    assert carrier.contact_data()["shear_depth_mm"] == pytest.approx(beneath.shear_depth)
    made = model(name, material__cam__case_depth_mm=2.0 * factor * beneath.shear_depth)
    assert levels(made, "case-depth") == {"cam": level}
    assert said(model(name), "case-depth") == []


def test_mean_torque_holds_the_friction_of_the_guides() -> None:
    bare, rubbing = (model("pin_insertion", operation__guide_friction=mu) for mu in (None, 0.1))
    for made in (bare, rubbing):
        duty = made.duty
        theta = np.linspace(0.0, 2.0 * pi, 200001)
        mean = np.trapezoid(duty.force.panels.at(duty.torque, np.clip(theta, 0.0, 2.0 * pi - 1e-9)), theta) / (2e3 * pi)
        assert duty.contact_data()["mean_torque_n_m"] == pytest.approx(mean, rel=1e-4)
    assert rubbing.duty.contact_data()["mean_torque_n_m"] > 1.01 * bare.duty.contact_data()["mean_torque_n_m"]


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
    made = model("tool_changer")
    duty = made.turret_duty
    assert duty is not None
    duty.engagement.curvature[:, n, k, m] = -0.02
    assert duty.peak_pressure.value == inf
    assert duty.lives["roller"] == 0.0 == duty.lives["cam"]
    assert [finding.level for finding in said(made, "turret-pressure")] == ["fail"]
    assert set(levels(made, "turret-life").values()) == {"fail", "pass"}
    data = compute(made, ["contact", "fatigue"]).data
    assert data["contact"]["peak_pressure_mpa"] is None or data["contact"]["peak_slice_pressure_mpa"] is None
    assert "shear_depth_mm" not in data["contact"]
    assert [finding.level for finding in said(model("tool_changer"), "turret-pressure")] == ["pass"]
