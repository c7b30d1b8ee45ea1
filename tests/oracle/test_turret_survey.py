"""What is asked of the flanks of indexing cams is asked wherever a roller bears, and nowhere else.

A roller bears as long as any of its contact line has a wall within the blank: beyond where its axis leaves the cam, and
at the ends with a part of its length on one of its sides only.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from camgeom.checks import findings
from camgeom.model import Model
from camgeom.profile import from_data, read_data
from camgeom.track.flank import Flank
from tests.places import PROFILES
from tests.reference.barrels import barrel


def limited(name: str, **limits: float) -> Model:
    data = read_data(PROFILES / f"{name}.toml")
    data["limits"] = data["limits"] | limits
    return Model(from_data(data))


def passes(model: Model, check: str) -> bool:
    (found,) = findings(model, only=[check])
    return found.passed


@cache
def fine() -> Model:
    return limited("fine_indexer")


@pytest.mark.parametrize("name", ["fine_indexer", "barrel_indexer"])
def test_extremes_are_those_of_every_point_with_a_wall(name: str) -> None:
    """Points of the flanks one by one, over all angles at which a roller may be near, those within the blank alone."""
    model = fine() if name == "fine_indexer" else limited(name)
    inside = model.mechanism.within
    least, least_margin, steepest = np.inf, np.inf, 0.0
    for track, cutter in zip(model.passages, model.cutters):
        phi = np.linspace(*track.span, 6001)[1:-1]
        for side in track.sides:
            low, high = (track.meridian.parameter(d) for d in track.contact)
            flank = Flank(track, phi, np.linspace(low, high, 28), side)
            there = inside(flank.x) >= 0.0
            least = min(least, flank.k_rel[there].min())
            steepest = max(steepest, flank.pressure_angle()[there].max())
            top = max(low, high, key=lambda d: abs(d - cutter.tip))
            wall = np.linspace(cutter.meridian.parameter(cutter.tip), top, 28)
            cut = Flank(cutter, phi, wall, side)
            least_margin = min(least_margin, cut.margin[inside(cut.x) >= 0.0].min())
    surveyed = model.flanks
    assert min(one.relative_curvature.value for one in surveyed) == pytest.approx(least, rel=2e-3)
    assert min(one.margin.value for one in surveyed) == pytest.approx(least_margin, rel=2e-3)
    assert max(one.pressure_angle.value for one in surveyed) == pytest.approx(steepest, rel=2e-3)


def test_undercut_is_judged_where_a_roller_bears_beyond_the_width() -> None:
    """The axis leaves this cam with a margin of 0.8305; 16 degrees on, where most of the wall is, 0.8170 are left."""
    assert not passes(limited("fine_indexer", undercut_margin=0.825), "undercut")
    assert passes(limited("fine_indexer", undercut_margin=0.815), "undercut")
    worst = min((one.margin for one in fine().flanks), key=lambda margin: margin.value)
    assert worst.value == pytest.approx(0.817041, rel=1e-5)


def test_pressure_angle_is_judged_where_a_roller_bears_beyond_the_width() -> None:
    """Where its axis leaves this barrel a roller stands at 46.10 degrees; it bears up to 47.12."""
    assert not passes(limited("barrel_indexer", pressure_angle_deg=46.6), "pressure-angle")
    assert passes(limited("barrel_indexer", pressure_angle_deg=47.6), "pressure-angle")


def test_a_wall_that_is_not_there_is_not_judged() -> None:
    """Of a barrel 70 mm wide the side with a margin of 0.644 has left the end face when it comes to that."""
    narrow, wide = (min(one.margin.value for one in barrel(width, "cylinder").flanks) for width in (70.0, 100.0))
    assert wide == pytest.approx(0.6440, abs=1e-4)
    assert narrow == pytest.approx(0.6543, abs=1e-4)
