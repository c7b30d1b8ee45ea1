"""Measures of a globoidal drive by the names of T/WLJC 15-2018, beside the validation's own numbers."""

from __future__ import annotations

from math import hypot, sqrt

import pytest

import camgeom
from camgeom.report.data.geometry import blank_data
from camgeom.report.sections.design import named
from tests.places import PROFILES


def test_the_tool_changers_measures() -> None:
    model = camgeom.read(PROFILES / "tool_changer.toml")
    found, cam, follower = blank_data(model), model.profile.cam.model_dump(), model.mechanism.follower
    roller = model.mechanism.roller
    assert roller is not None
    pitch = model.mechanism.quoted_radius
    assert pitch is not None
    assert found["seat_radius_mm"] == pytest.approx(pitch - 0.5 * (roller.length or 0.0))
    assert found["over_rollers_radius_mm"] == pytest.approx(hypot(pitch + 0.5 * (roller.length or 0.0),
                                                                  0.5 * roller.diameter))  # fmt: skip
    high = sqrt(cam["globoid_radius"] ** 2 - 0.25 * cam["width"] ** 2)
    assert found["outside_diameter_mm"] == pytest.approx(2.0 * (cam["center_distance"] - high))
    assert found["seat_radius_mm"] == pytest.approx(70.0)
    assert found["over_rollers_radius_mm"] == pytest.approx(95.35198, abs=1e-5)
    assert found["outside_diameter_mm"] == pytest.approx(241.6277, abs=1e-4)
    assert 20.0 < found["groove_depth_mm"] < 1.25 * (roller.length or 0.0)
    assert model.mechanism.turret is not None
    disc = model.mechanism.turret.body.high
    assert found["axis_height_mm"] == pytest.approx(disc) == pytest.approx(20.8)
    (table,) = named(model)
    assert table.rows[0][0] == "Seat radius"
    assert follower.rotating


def test_other_kinds_have_none() -> None:
    model = camgeom.read(PROFILES / "pin_insertion.toml")
    assert set(blank_data(model)) == {"diameter_mm", "length_mm", "volume_mm3"}
    assert named(model) == ()
