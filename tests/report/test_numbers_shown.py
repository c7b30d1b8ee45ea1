"""Numbers as they are read: 0 below rounding, endless lives in a word, segments by their path in the profile."""

from __future__ import annotations

import pytest

import camgeom
from camgeom.checks import judge
from camgeom.checks.verdict import ENDLESS_H, judged
from camgeom.report.sections.life import hours
from camgeom.report.sections.motion import segments
from tests.places import PROFILES


@pytest.mark.parametrize(("life", "shown"), [(0.999 * ENDLESS_H, 0.999 * ENDLESS_H), (1.001 * ENDLESS_H, "unlimited")])
def test_a_life_that_no_machine_sees_is_unlimited(life: float, shown: float | str) -> None:
    finding = judged("life", life, ">=", 1e4, "h", "")
    assert finding.shown == shown
    assert finding.value == life, "result.json keeps the figure"
    assert (hours(life) == "unlimited") is (shown == "unlimited")


def test_a_life_too_short_is_told_with_its_figure() -> None:
    assert judged("life", 2.0 * ENDLESS_H, ">=", 9e9, "h", "").shown == 2.0 * ENDLESS_H


@pytest.mark.parametrize(("value", "shown"), [(6.361e-14, 0.0), (-3e-12, 0.0), (6.361e-4, 6.361e-4)])
def test_rounding_is_shown_as_zero(value: float, shown: float) -> None:
    assert judged("pressure-angle", value, "<=", 30.0, "deg", "").shown == shown


def test_a_sliding_flat_face_has_no_pressure_angle() -> None:
    model = camgeom.read(str(PROFILES / "disc_flat_face.toml"))
    (finding,) = judge(model, ["pressure-angle"]).findings
    assert finding.value == 0.0
    rolled = camgeom.read(str(PROFILES / "disc_offset_roller.toml"))
    assert judge(rolled, ["pressure-angle"]).findings[0].value > 10.0


def test_segments_are_named_by_their_path_in_the_profile() -> None:
    model = camgeom.read(str(PROFILES / "pin_insertion.toml"))
    names = [row[0] for row in segments(model).rows]
    assert names == [f"motion[{i}]" for i in range(len(model.profile.motion))]
    half = camgeom.read(str(PROFILES / "constant_width_press.toml"))
    assert [row[0] for row in segments(half).rows] == [
        "motion[0]", "motion[1]", "mirror of motion[0]", "mirror of motion[1]"
    ]  # fmt: skip
