"""Rollers that end in a point, preloads that nothing bears, turrets that turn for ever: refused by their keys."""

from __future__ import annotations

import re

import pytest

from camgeom.cams import starter
from camgeom.checks import judge
from camgeom.errors import ProfileError
from camgeom.model import Model
from camgeom.profile import parse
from camgeom.track.follower import ConeRoller, CylinderRoller
from tests.places import PROFILES


def changed(name: str, **keys: object) -> str:
    text = (PROFILES / f"{name}.toml").read_text()
    for key, value in keys.items():
        assert re.search(rf"(?m)^{key} = ", text), key
        text = re.sub(rf"(?m)^{key} = [^#\n]*", f"{key} = {value} ", text, count=1)
    return text


@pytest.mark.parametrize("sign", ["", "-"])
def test_a_cone_ends_before_its_point(sign: str) -> None:
    # 36 mm across the middle of 22 mm: the point lies 11 mm away at atan(36 / 22) = 58.5704 deg.
    profile = parse(changed("conical_indexer", half_angle=f"{sign}7.5"))
    assert profile.roller.half_angle == float(f"{sign}7.5")
    with pytest.raises(ProfileError, match=r"roller: half_angle = -?58\.6: .* less than 58\.5704 deg"):
        parse(changed("conical_indexer", half_angle=f"{sign}58.6"))
    ConeRoller(shape="cone", diameter=36.0, length=22.0, half_angle=float(f"{sign}58.5"))


def test_a_crown_ends_before_its_point() -> None:
    # A crown of 10 mm on a roller 16 mm across ends in points 2 sqrt(8 (20 - 8)) = 19.5959 mm apart.
    text = re.sub(r"(?m)^(keyway|bore).*\n", "", changed("feeder_runout", crown_radius=10, groove_depth=20))
    parse(text.replace("\nlength = 8\n", "\nlength = 19.5\n"))
    with pytest.raises(ProfileError, match=r"roller: length = 19\.6: .* less than 19\.5959 mm for a crown_radius"):
        parse(text.replace("\nlength = 8\n", "\nlength = 19.6\n"))
    parse(changed("feeder_runout", crown_radius=8.0))
    with pytest.raises(ProfileError, match=r"crown_radius = 7\.99: allowed: at least half the diameter, 8 mm"):
        parse(changed("feeder_runout", crown_radius=7.99))


def test_an_end_is_rounded_by_no_more_than_the_roller_is_thick() -> None:
    CylinderRoller(diameter=22.0, length=12.0, end_radius=11.0)
    text = (PROFILES / "pin_insertion.toml").read_text()
    with pytest.raises(ProfileError, match=r"end_radius = 11\.01: allowed: at most half the diameter, 11 mm"):
        parse(text.replace("\nlength = 12\n", "\nlength = 12\nend_radius = 11.01\n"))


def test_a_ball_is_touched_above_its_pole() -> None:
    with pytest.raises(ProfileError, match="length = 8: allowed: below the ball's radius, 8 mm"):
        parse(changed("feeder_runout", shape='"sphere"').replace("crown_radius = 300", ""))


def grooved(rollers: int, preload: float, width: int = 84) -> str:
    text = starter("globoidal").replace('form = "rib"', 'form = "groove"').replace("width = 84", f"width = {width}")
    text = text.replace("stops = 8", f"stops = {rollers}").replace("to = 45", f"to = {360 / rollers}")
    return text.replace("bore = 40", f"bore = 40\npreload = {preload}")


def test_a_preload_needs_rollers_that_bear_it() -> None:
    model = Model(parse(grooved(24, 0.004, 60).replace("diameter = 30", "diameter = 12")))
    assert model.mechanism.centre_shift < 0.02
    for rollers in (2, 4):
        assert Model(parse(grooved(rollers, 0.0))).mechanism.centre_shift == 0.0
        with pytest.raises(ProfileError, match=r"cam\.preload: .*nothing is pressed; more rollers"):
            parse(grooved(rollers, 0.004))


def test_a_preload_is_an_elastic_approach() -> None:
    text = starter("globoidal")
    parse(text.replace("bore = 40", "bore = 40\npreload = 0.3"))
    with pytest.raises(ProfileError, match=r"cam\.preload: .*at most 0\.3 mm"):
        parse(text.replace("bore = 40", "bore = 40\npreload = 0.301"))


def test_a_turret_turns_once_at_most() -> None:
    assert judge(Model(parse(changed("tool_changer", to=45))), ["stops"]).findings
    parse(changed("tool_changer", to=360))
    with pytest.raises(ProfileError, match=r"motion\[1\]\.to: a turret turns by one whole turn at most"):
        parse(changed("tool_changer", to=405))
