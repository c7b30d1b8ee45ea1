"""The roller as a bearing: every check has the side that passes and the other, every key acts or is refused."""

from __future__ import annotations

from math import hypot, radians, sqrt, tan
from pathlib import Path
from typing import Any

import pytest

import camgeom
from camgeom.checks import judge
from camgeom.checks.verdict import NotJudged
from camgeom.errors import ProfileError
from camgeom.mechanics.rating import ROLLER, life_factor, viscosity_ratio
from camgeom.model import Model
from camgeom.profile import parse
from camgeom.profile.catalogue import shipped
from camgeom.report.result import compute
from tests.places import PROFILES
from tests.reference.profiles import model, said

DISC = "disc_offset_roller"
OIL: dict[str, Any] = {"lubricant__viscosity_40": 46.0, "lubricant__viscosity_100": 6.8, "lubricant__temperature": 60.0}
KNOWN: dict[str, Any] = {"roller__fatigue_load_limit": 700.0, "roller__contamination": 0.5,
                         "roller__pitch_diameter": 14.0, **OIL}  # fmt: skip


def omitted(made: Model, check: str) -> list[NotJudged]:
    return list(judge(made, [check]).not_judged)


def test_the_rated_life_is_the_one_of_the_standard():
    made = model(DISC, **KNOWN, limits__bearing_reliability=95)
    bearing, plain = made.duty.bearing, model(DISC).duty.bearing
    assert bearing is not None
    assert plain is not None
    oil = made.profile.oil
    assert oil is not None
    load, turning = float(plain.mean_load), float(plain.speed) * 30 / 3.141592653589793
    kappa = float(viscosity_ratio(oil.viscosity, turning, 14.0))
    factor = float(life_factor(ROLLER, kappa, 0.5 * 700.0 / load))
    assert 0.1 < factor < 50.0
    assert made.lives["bearing"] == pytest.approx(0.64 * factor * plain.life_h, rel=1e-9)
    data = compute(made, ("fatigue",)).data["fatigue"]
    assert data["bearing_viscosity_ratio"] == pytest.approx(kappa)
    assert data["bearing_life_factor"] == pytest.approx(factor)
    assert data["bearing_life_h"] == pytest.approx(float(plain.life_h))
    for share, level in ((0.999, "pass"), (1.002, "fail")):
        judged = model(DISC, **KNOWN, limits__bearing_reliability=95, limits__life_h=share * made.lives["bearing"])
        assert [f.level for f in said(judged, "life") if f.where == "bearing"] == [level]


def test_a_factor_of_every_state_is_not_that_of_the_mean_load():
    duty = ({"share": 0.9, "load_factor": 0.3}, {"share": 0.1, "load_factor": 12.0, "temperature": 90.0})
    made = model(DISC, **KNOWN, duty=duty)
    hand = sum(
        one.state.weight / one.duty.bearing.judged_h for one in made.states if one.state and one.duty.bearing
    )
    assert made.lives["bearing"] == pytest.approx(1.0 / hand)
    factors = [float(one.duty.bearing.factor) for one in made.states if one.duty.bearing and one.duty.bearing.factor]
    assert factors[0] > 2.0 * factors[1]


@pytest.mark.parametrize(
    ("check", "key", "of", "margins"),
    [
        # the key at which the check is met exactly, and the shares of it that pass and fail
        ("bearing", "roller__max_radial_load", lambda m: m.duty.peak_force.value, (1.001, 0.998)),
        ("bearing-speed", "roller__limiting_speed", lambda m: float(m.duty.bearing.peak_speed) * 9.549296585513721,
         (1.001, 0.998)),
        ("bearing-least-load", "roller__static_rating", lambda m: float(m.duty.bearing.mean_load) / 0.0167,
         (0.998, 1.001)),
    ],
)  # fmt: skip
def test_a_limit_of_the_bearing_has_two_sides(check, key, of, margins):
    exact = of(model(DISC))
    good, bad = (model(DISC, **{key: share * exact}) for share in margins)
    assert {f.level for f in said(good, check)} == {"pass"}
    assert "pass" not in {f.level for f in said(bad, check) if "static" not in f.where}


def test_a_roller_that_turns_too_fast_on_the_mean_fails():
    mean = float(model(DISC).duty.bearing.speed) * 9.549296585513721
    assert [f.level for f in said(model(DISC, roller__limiting_speed=1.002 * mean), "bearing-speed")] == ["warn"]
    assert [f.level for f in said(model(DISC, roller__limiting_speed=0.999 * mean), "bearing-speed")] == ["fail"]


def test_the_lower_of_both_static_limits_counts():
    force = model(DISC).duty.peak_force.value
    for share, level in ((1.001, "pass"), (0.998, "fail")):
        made = model(DISC, roller__max_static_load=share * force, limits__warn_bearing_static_safety=1.0)
        assert [f.level for f in said(made, "bearing")] == [level]
    assert model(DISC, roller__max_static_load=1e6).duty.bearing.static_safety == model(DISC).duty.bearing.static_safety


def test_the_lubrication_of_the_bearing():
    assert "roller.fatigue_load_limit" in omitted(model(DISC), "bearing-lubrication")[0].reason
    thick = model(DISC, **{**KNOWN, "lubricant__viscosity_40": 460.0, "lubricant__viscosity_100": 31.0})
    assert [f.level for f in said(thick, "bearing-lubrication")] == ["pass"]
    assert [f.level for f in said(model(DISC, **KNOWN), "bearing-lubrication")] == ["warn"]
    thin = model(DISC, **{**KNOWN, "lubricant__viscosity_40": 3.0, "lubricant__viscosity_100": 2.0})
    assert [f.level for f in said(thin, "bearing-lubrication")] == ["fail"]
    assert [f.level for f in said(thin, "life") if f.where == "bearing"] == ["fail"]


def test_what_is_missing_is_told():
    assert "max_radial_load" in omitted(model(DISC), "bearing")[0].reason
    assert "limiting_speed" in omitted(model(DISC), "bearing-speed")[0].reason


def test_what_presses_along_the_axis_is_told():
    """Of the 305 N at the top of conical_disc the cone of 10 deg takes the tangent, and the offset leans it more."""
    cone, cylinder = (parse((PROFILES / "conical_disc.toml").read_text()),
                      parse((PROFILES / "conical_disc.toml").read_text().replace('"cone"', '"cylinder"').replace(
                          "half_angle = 10 ", "# ")))  # fmt: skip
    (told,) = (word.reason for word in omitted(Model(cone), "bearing") if word.check == "bearing-thrust")
    at_top = sqrt(52.0**2 - 5.0**2) + 15.0
    thrust = 305.0 * tan(radians(10.0)) / (at_top / hypot(at_top, 5.0))
    assert f"a cone is pressed by up to {thrust:.4g} N along its axis" in told
    assert not [word for word in omitted(Model(cylinder), "bearing") if word.check == "bearing-thrust"]
    flat = model("conical_disc", roller__half_angle=0.0)
    assert not [word for word in omitted(flat, "bearing") if word.check == "bearing-thrust"]
    unrated = model("conical_disc", roller__dynamic_rating=None, roller__static_rating=None,
                    limits__bearing_static_safety=None)  # fmt: skip
    assert not [word for word in omitted(unrated, "bearing") if word.check == "bearing-thrust"]


def test_a_ball_bearing_has_another_exponent():
    ball, roller = (model(DISC, roller__bearing_type=kind).duty.bearing for kind in ("ball", "roller"))
    assert float(ball.life_h) < float(roller.life_h)


def test_a_turret_has_the_same():
    made = model("parallel_index", **{**KNOWN, "roller__max_radial_load": 9000.0, "roller__limiting_speed": 3000.0})
    bearing = made.turret_duty.bearing
    assert bearing.factor is not None
    assert made.lives["bearing"] == pytest.approx(float(bearing.life_h * bearing.factor))
    assert float(bearing.peak_speed) > float(bearing.speed) > 0.0
    assert {f.check for f in judge(made, ["bearing", "bearing-speed", "bearing-lubrication"]).findings} == {
        "bearing", "bearing-speed", "bearing-lubrication"}  # fmt: skip


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"roller__fatigue_load_limit": 300.0}, "a_ISO of ISO 281 wants"),
        ({"roller__dynamic_rating": None, "roller__static_rating": None, "roller__limiting_speed": 9.0}, "_rating"),
        ({"roller__static_rating": None, "roller__max_static_load": 9.0}, "static_rating"),
        ({"roller__catalogue": "own.toml"}, "designation"),
        ({"roller__designation": "CF 99"}, "no catalogue"),
        ({"roller__designation": "CF 10 WBUUR/SG"}, "stated twice"),
    ],
)
def test_what_means_nothing_is_refused(changes, word):
    with pytest.raises(ProfileError) as caught:
        model(DISC, **changes)
    assert word in str(caught.value)


def test_a_designation_fills_in_what_the_profile_leaves_out():
    bare = {"roller__dynamic_rating": None, "roller__static_rating": None, "roller__diameter": None}
    made = model(DISC, **bare, roller__designation="cf10 WBUUR/SG")
    roller = made.profile.roller
    assert roller is not None
    assert (roller.diameter, roller.dynamic_rating, roller.static_rating) == (22.0, 5430.0, 6890.0)
    assert roller.max_static_load == 6890.0
    by_hand = model(DISC, roller__dynamic_rating=5430.0, roller__static_rating=6890.0)
    assert made.lives["bearing"] == by_hand.lives["bearing"]
    assert compute(made, ("fatigue",)).data["fatigue"]["bearing_designation"] == "cf10 WBUUR/SG"
    with pytest.raises(ProfileError, match="longer than the outer ring"):
        model(DISC, **bare, roller__designation="CF 10 WBUUR/SG", roller__length=12.5)


def test_a_crowned_ring_of_the_catalogue_is_a_crowned_roller():
    """IKO prints R 500 for these rings: as a cylinder the contact would be a line, 2.6 times less pressed."""
    bare = {"dynamic_rating": None, "static_rating": None, "diameter": None, "shape": None, "crown_radius": None}
    bare = {f"roller__{key}": value for key, value in bare.items()}
    roller = model(DISC, **bare, roller__designation="CF 10 WBUUR/SG").profile.roller
    assert (roller.shape, roller.crown_radius) == ("crowned", 500.0)
    for keys, word in (({"shape": "cylinder"}, "crowned"), ({"shape": "crowned", "crown_radius": 5000.0}, "twice")):
        with pytest.raises(ProfileError, match=word):
            model(DISC, **bare | {f"roller__{key}": value for key, value in keys.items()},
                  roller__designation="CF 10 WBUUR/SG")  # fmt: skip


def test_a_catalogue_of_the_users_own(tmp_path: Path):
    (tmp_path / "own.toml").write_text(
        '[[follower]]\ndesignation = "MY 25"\ntype = "yoke"\ndiameter = 22\nbore = 8\nwidth = 14\n'
        "dynamic_rating = 4000\nlimiting_speed = 6000\n"
    )
    text = (PROFILES / "disc_offset_roller.toml").read_text()
    start, end = text.index("dynamic_rating"), text.index("[[motion]]")
    text = text[:start] + 'designation = "MY 25"\ncatalogue = "own.toml"\n\n' + text[end:]
    (tmp_path / "cam.toml").write_text(text)
    roller = camgeom.read(str(tmp_path / "cam.toml")).profile.roller
    assert roller is not None
    assert (roller.dynamic_rating, roller.limiting_speed, roller.static_rating) == (4000.0, 6000.0, None)
    (tmp_path / "own.toml").write_text('[[follower]]\ndesignation = "MY 25"\ntype = "wheel"\n')
    with pytest.raises(ProfileError, match="catalogue"):
        camgeom.read(str(tmp_path / "cam.toml"))
    with pytest.raises(ProfileError, match="read from a file"):
        parse(text)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("roller__fatigue_load_limit", 500.0), ("roller__contamination", 0.3), ("roller__pitch_diameter", 12.0),
        ("roller__bearing_type", "ball"), ("roller__max_static_load", 3000.0), ("roller__max_radial_load", 100.0),
        ("roller__limiting_speed", 100.0), ("limits__bearing_reliability", 97), ("lubricant__viscosity_40", 68.0),
        ("lubricant__viscosity_100", 7.5), ("lubricant__temperature", 75.0), ("lubricant__density", 920.0),
        ("lubricant__pressure_viscosity", 24.0), ("lubricant__friction", 0.2), ("material__cam__roughness_um", 0.3),
        ("material__roller__roughness_um", 0.3), ("material__cam__wear_rate", 2e-8),
        ("material__roller__wear_rate", 2e-8), ("limits__film_ratio", 7.0), ("limits__warn_film_ratio", 7.0),
        ("limits__wear_um", 1e-3),
    ],
)  # fmt: skip
def test_every_key_of_bearing_film_and_wear_changes_a_figure_or_a_finding(key: str, value: object):
    whole = {
        **KNOWN, "lubricant__pressure_viscosity": 20.0, "lubricant__friction": 0.1, "limits__wear_um": 1e3,
        "material__cam__roughness_um": 0.2, "material__roller__roughness_um": 0.2, "material__cam__wear_rate": 1e-8,
        "material__roller__wear_rate": 1e-8, "limits__life_h": 100.0, "roller__dynamic_rating": 9000.0,
        "roller__static_rating": 9000.0,
    }  # fmt: skip
    asked = ["bearing", "bearing-speed", "film", "wear"]
    one, other = model("steep_shuttle", **whole), model("steep_shuttle", **{**whole, key: value})
    assert (compute(one, ("fatigue",)).data["fatigue"], judge(one, asked).findings) != (
        compute(other, ("fatigue",)).data["fatigue"], judge(other, asked).findings)  # fmt: skip


@pytest.mark.parametrize(
    ("key", "held", "beyond"),
    [("pitch_diameter", 23.9, 24.0), ("fatigue_load_limit", 12490.0, 12500.0)],
)  # fmt: skip
def test_a_bearing_that_no_roller_holds_is_refused(key: str, held: float, beyond: float):
    # A pitch diameter of 1 000 mm in a roller of 22 mm made kappa 2.1 of 0.27, and the warning went.
    whole = {**KNOWN, "roller__diameter": 24.0, "roller__dynamic_rating": 9800.0, "roller__static_rating": 12500.0}
    assert model(DISC, **{**whole, f"roller__{key}": held}).duty.bearing is not None
    with pytest.raises(ProfileError, match=rf"{key} = .*allowed: below"):
        model(DISC, **{**whole, f"roller__{key}": beyond})


def test_every_shipped_row_has_a_source_and_makes_a_roller():
    catalogue = shipped()
    assert len({one.designation for one in catalogue.follower}) == len(catalogue.follower) > 8
    for one in catalogue.follower:
        assert "http" in catalogue.source_of(one)
        assert one.bore < one.diameter


def test_a_yoke_type_is_filled_in_with_the_speed_of_its_page():
    """IKO's table: dn 72 000 with grease, 30 mm bore; of a narrow outer ring the static load is below the rating."""
    bare = {"roller__dynamic_rating": None, "roller__static_rating": None, "roller__diameter": None}
    roller = model(DISC, **bare, roller__designation="NURT 30 R").profile.roller
    assert roller is not None
    assert (roller.diameter, roller.dynamic_rating, roller.static_rating) == (62.0, 58200.0, 75300.0)
    assert (roller.max_static_load, roller.limiting_speed) == (35200.0, 2400.0)


def test_the_load_that_is_borne_for_the_wanted_life():
    """Equation 37 of T/WLJC 15-2018: at the life that the bearing has it is the load it carries; a_ISO has no such."""
    plain = model(DISC, limits__bearing_reliability=95).duty.bearing
    assert plain is not None
    hours = plain.judged_h
    for wanted, share in ((hours, 1.0), (hours / 8.0, 8.0**0.3)):
        made = model(DISC, limits__bearing_reliability=95, limits__life_h=wanted)
        data = compute(made, ("fatigue",)).data["fatigue"]
        assert data["bearing_borne_load_n"] == pytest.approx(share * float(plain.mean_load), rel=1e-9)
    oiled = model(DISC, **KNOWN, limits__life_h=hours)
    assert "bearing_borne_load_n" not in compute(oiled, ("fatigue",)).data["fatigue"]


def test_a_roller_that_nothing_loads_has_no_viscosity_ratio():
    # A rib's rollers: a steady load bears on the lower one alone, and the upper one
    # failed with 0.02, the ratio at 1 rad/s.
    bearing = {"dynamic_rating": 9800.0, "static_rating": 12500.0, "fatigue_load_limit": 1400.0, "contamination": 0.5,
               "pitch_diameter": 14.0}  # fmt: skip
    data: dict[str, Any] = {
        "cam": {"kind": "cylindrical", "form": "rib", "diameter": 132, "length": 120, "start": 50, "groove_depth": 13,
                "rib_thickness": 20},
        "follower": {"kind": "translating", "mass": 3}, "roller": {"shape": "cylinder", "diameter": 22, "length": 12,
                                                                   **bearing},
        "motion": [{"until": 120, "to": 20, "law": "modified-sine"}, {"until": 280, "to": 0, "law": "3-4-5"},
                   {"until": 360}],
        "operation": {"speed": 20, "force": [{"expression": "300"}]},
        "lubricant": {"viscosity_40": 100.0, "viscosity_100": 11.0, "temperature": 60.0},
    }  # fmt: skip
    made = camgeom.read(data)
    upper, lower = (duty.bearing for duty in made.carriers)
    assert lower is not None
    assert upper is not None
    assert float(upper.mean_load) == 0.0
    assert (upper.ratio, upper.factor, upper.judged_h) == (None, None, float("inf"))
    assert lower.ratio is not None
    (told,) = said(made, "bearing-lubrication")
    assert (told.level, told.value) == ("warn", pytest.approx(float(lower.ratio)))
    hotter = made.with_(lubricant__temperature=90.0)
    assert [f.level for f in said(hotter, "bearing-lubrication")] == ["fail"]
