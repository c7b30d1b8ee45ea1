"""Profiles in inches: every length is converted, nothing else is, and what cannot be converted is refused by name."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import pytest

from camgeom.cli.study_page import unit_of
from camgeom.errors import ProfileError
from camgeom.model import Model
from camgeom.profile import Profile, from_data, parse, read
from camgeom.profile.errors import keys_of
from camgeom.profile.reader import Reader
from camgeom.profile.schema import schema
from camgeom.profile.sections import INCH
from camgeom.profile.units import is_length
from camgeom.report.answer import Memory, answers
from camgeom.report.part_sheet import part_sheet
from camgeom.report.result import compute
from tests.places import PROFILES

DISC = """units = "inch"
name = "inch disc"
[cam]
kind = "disc"
base_radius = 1.25
width = 0.5
bore = 0.75
[follower]
kind = "translating"
mass = 0.8
[roller]
diameter = 0.75
length = 0.5
[[motion]]
until = 120
to = 0.75
law = "cycloidal"
[[motion]]
until = 150
[[motion]]
until = 270
to = 0
law = "cycloidal"
[[motion]]
until = 360
[operation]
speed = 300
spring_rate = 4
spring_preload = 60
[limits]
min_wall_mm = 2
"""
MM = (DISC.replace('"inch"', '"mm"', 1).replace("1.25", "31.75").replace("0.75", "19.05").replace("0.5", "12.7"))


def _in_inches(data: Any, profile: Profile, section: str) -> Any:
    """The section's data with its lengths divided by 25.4, by the same rule read backwards."""
    models = Reader(Profile, profile.stated, profile.source)
    models._models()
    fields = {key: one for model in models.sections[section] for key, one in keys_of(model).items()}
    return {
        key: value / INCH if key in fields and isinstance(value, int | float) and not isinstance(value, bool)
        and is_length(key, fields[key].description or "", profile.rotating) else value
        for key, value in data.items()
    }  # fmt: skip


@pytest.mark.parametrize("name", ["pin_insertion", "globoidal_drive", "conjugate_rocker"])
def test_a_profile_in_inches_is_the_same_machine(name: str) -> None:
    metric = read(PROFILES / f"{name}.toml")
    data: dict[str, Any] = {"units": "inch"}
    for key, value in metric.stated.items():
        if key == "motion":
            data[key] = tuple(_in_inches(one, metric, key) for one in value)
        else:
            inches = key in ("cam", "follower", "roller", "return_roller", "output")
            data[key] = _in_inches(value, metric, key) if inches else value
    for key in ("impact", "tolerance", "cutter", "dynamics"):
        data.pop(key, None)
    stated = {key: value for key, value in metric.stated.items() if key in data}
    made, beside = from_data(data, metric.source), from_data(stated, metric.source)
    for found, wanted in zip(_numbers(made.model_dump()), _numbers(beside.model_dump()), strict=True):
        assert found == pytest.approx(wanted, rel=1e-13)
    assert from_data(made.stated, metric.source) == made
    assert parse(made.toml(), metric.source) == made


def _numbers(data: Any) -> Iterator[float]:
    if isinstance(data, dict):
        data = tuple(data.values())
    if isinstance(data, tuple):
        for one in data:
            yield from _numbers(one)
    elif isinstance(data, float):
        yield data


def test_lengths_alone_are_converted_and_a_key_that_names_its_unit_keeps_it() -> None:
    profile, metric = parse(DISC), parse(MM)
    assert profile.digest() == metric.digest()
    assert profile.cam.model_dump()["base_radius"] == 31.75
    assert profile.motion[0].to == 19.05
    assert profile.limits.min_wall_mm == 2.0
    assert profile.operation is not None
    assert profile.operation.spring_rate == 4.0
    assert profile.with_({"cam.bore": 1}).cam.model_dump()["bore"] == 25.4
    assert 'units = "inch"' in profile.toml()


def test_lifts_of_a_turning_follower_stay_degrees() -> None:
    text = """units = "inch"
[cam]
kind = "disc"
base_radius = 1.5
center_distance = 4
width = 0.5
[follower]
kind = "swinging"
arm = 3.5
[roller]
diameter = 0.75
length = 0.5
[[motion]]
until = 180
to = 15
law = "cycloidal"
[[motion]]
until = 360
to = 0
law = "cycloidal"
"""
    profile = parse(text)
    assert profile.motion[0].to == 15.0
    assert profile.cam.model_dump()["center_distance"] == 101.6
    assert profile.lift_unit[1] == "°"
    assert unit_of(profile, ("motion", 0, "to")) == "°"
    assert unit_of(profile, ("cam", "center_distance")) == "in"


def test_lifts_among_the_parameters_of_a_law_are_converted() -> None:
    points = DISC.replace('law = "cycloidal"', 'law = "spline"\npoints = [[0.5, 0.4]]', 1)
    assert dict(parse(points).motion[0].parameters)["points"] == ((0.5, 10.16),)
    control = DISC.replace('law = "cycloidal"', 'law = "b-spline"\ncontrol = [0.1, 0.5]', 1)
    assert dict(parse(control).motion[0].parameters)["control"] == (2.54, 12.7)


@pytest.mark.parametrize(("old", "new", "key", "told"), [
    ('law = "cycloidal"', 'law = "table"\nfile = "lifts.csv"', "motion[0].file", "its lifts are mm"),
    ("[limits]", '[[operation.force]]\nexpression = "5*s"\n[limits]', "operation.force[0].expression", "s: lift"),
    ('"inch"', '"inches"', "units", "did you mean 'inch'?"),
    ("base_radius = 1.25", "base_radius = -1.25", "cam.base_radius", "stated as -1.25 in"),
    ("base_radius = 1.25", "base_radius = 5000", "cam.base_radius", "stated as 5000 in"),
])  # fmt: skip
def test_what_cannot_be_in_inches_is_refused_by_name(old: str, new: str, key: str, told: str) -> None:
    with pytest.raises(ProfileError) as refused:
        parse(DISC.replace(old, new, 1))
    assert any(told in str(one) for one in refused.value.problems if one.key == key)


def test_a_force_of_angle_alone_is_none_of_the_refused() -> None:
    forced = DISC.replace("[limits]", '[[operation.force]]\nexpression = "5*sin(phi)"\n[limits]')
    assert parse(forced).operation is not None


def test_results_and_drawing_state_their_unit() -> None:
    inches, metric = Model(parse(DISC)), Model(parse(MM))
    found, wanted = compute(inches, ("motion", "flank")).data, compute(metric, ("motion", "flank")).data
    assert "inches" in found["units"]
    assert "in mm" in found["units"]
    assert "units" not in wanted
    assert found["flank"] == wanted["flank"]
    assert "A3, mm, not inch" in part_sheet(inches).svg()
    assert "A3, mm, degrees" in part_sheet(metric).svg()


def test_the_page_of_serve_drags_in_the_unit_of_the_profile() -> None:
    stages = answers(Memory(""), DISC, {"motion[0].to": 0.8}, lambda: True)
    figures = next(stage for stage in stages if stage["stage"] == "motion")
    assert figures["unit"] == "in"
    assert max(figures["lift"]) == pytest.approx(0.8)


def _meanings(part: Any) -> Iterator[tuple[str, str]]:
    """Every key of a schema with its meaning."""
    if isinstance(part, dict):
        for key, value in part.get("properties", {}).items():
            yield key, value.get("description", "")
    for one in part.values() if isinstance(part, dict) else part if isinstance(part, list) else ():
        yield from _meanings(one)


def test_every_key_whose_unit_has_mm_is_a_length_or_another_quantity() -> None:
    """A new key has to be one or the other on purpose: these begin with mm, and are no lengths."""
    named = [one for one in _meanings(schema()) if re.match(r"\S*mm", one[1]) and not one[0].endswith("_mm")]
    other = {re.split(r"[,;(]", meaning)[0].strip() for key, meaning in named if not is_length(key, meaning, False)}
    assert other == {"N/mm", "N/mm^n", "mm/min", "mm/s", "mm2/s", "mm3/"}
