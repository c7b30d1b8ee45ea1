"""A drum's rib: its least normal thickness all round against closed forms and a dense search; crossing flanks."""

from __future__ import annotations

from math import cos, radians

import numpy as np
import pytest

from camgeom.checks import judge
from camgeom.errors import DesignError
from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.profile.text import load
from camgeom.track.column import Column, cylinder_level
from camgeom.track.flank import Flank
from tests.places import PROFILES

SWINGING = {"kind": "swinging", "arm": 80, "inertia": 0.01}


def rib(stroke: float, thickness: float = 14.0, start_angle: float | None = None, **limits) -> Model:
    data, _, _ = load((PROFILES / "pin_insertion.toml").read_text(encoding="utf-8"), "")
    data["cam"] = data["cam"] | {"form": "rib", "rib_thickness": thickness, "length": 200, "start": 60}
    data["motion"] = (
        {"until": 180, "to": stroke, "law": "cycloidal"}, {"until": 240}, {"until": 360, "to": 0, "law": "cycloidal"},
    )
    data["operation"] = {"speed": 100}
    if start_angle is not None:
        data["follower"] = SWINGING | {"start_angle": start_angle}
    data["limits"] = {"pressure_angle_deg": 70} | limits
    return Model(from_data(data, ""))


def judged(model: Model):
    return {f.where: f for f in judge(model, ["rib-thickness"]).findings}


@pytest.mark.parametrize("start_angle", [0.0, -8.0, -30.0, -45.0])
def test_a_swinging_rib_is_as_thick_as_its_rollers_leave_it(start_angle) -> None:
    # Two rollers one above the other, 14 + 22 mm apart along Z, that move at the arm's angle to it.
    wanted = (14.0 + 22.0) * cos(radians(start_angle)) - 22.0
    for finding in judged(rib(1e-4, start_angle=start_angle)).values():
        assert finding.value == pytest.approx(wanted, abs=2e-3)


def test_the_thickness_is_the_least_distance_of_the_flanks() -> None:
    model = rib(37.0)
    lower, upper = model.mechanism.cutters
    phi = np.linspace(4.6, 5.8, 1500)
    for name, radius in (("tip", 67.0), ("foot", 54.0)):
        column = Column(lower, phi)
        edge = column.wall(lower.sides[0], column.reach(lower.sides[0], cylinder_level(radius), radius))[:, :, 0]
        t = np.linspace(radius - 6.0, radius + 6.0, 61)
        other = Flank(upper, phi, t, upper.sides[0]).x.reshape(3, -1)
        least = min(float(np.sqrt(((other - point[:, None]) ** 2).sum(axis=0)).min()) for point in edge.T[::10])
        found = next(rib for rib in model.mechanism.ribs if rib.where == name)
        assert found.value == pytest.approx(least, abs=5e-3)
        assert found.value <= least + 1e-9


@pytest.mark.parametrize(("stroke", "level", "fails"), [(5.0, "pass", 0), (37.0, "warn", 0), (74.0, "fail", 1)])
def test_steep_ribs_warn_and_fail(stroke, level, fails) -> None:
    findings = judged(rib(stroke))
    assert findings["rib foot"].level == level
    assert findings["rib foot"].value < findings["rib tip"].value
    assert sum(f.level == "fail" for f in findings.values()) == fails


def test_the_limit_has_two_sides() -> None:
    least = judged(rib(37.0))["rib foot"].value
    assert judged(rib(37.0, min_wall_mm=least / 1.001))["rib foot"].level == "warn"
    assert judged(rib(37.0, min_wall_mm=least / 0.998))["rib foot"].level == "fail"
    assert judged(rib(37.0, warn_rib_share=0.5))["rib foot"].level == "pass"


def test_flanks_that_cross_bound_no_body() -> None:
    rib(74.0, thickness=14.2).solid  # noqa: B018
    crossed = rib(74.0, thickness=13.5)
    assert judged(crossed)["rib foot"].value < 0.0
    with pytest.raises(DesignError, match="flanks cross at its foot"):
        crossed.solid  # noqa: B018


@pytest.mark.parametrize(("share", "level"), [(1.002, "pass"), (0.998, "fail")])
def test_a_rib_thinner_than_the_chord_errors_of_its_flanks_is_none(share, level) -> None:
    # Level rollers leave the thickness asked for; 0.05 mm on either side may be missing.
    model = rib(1e-4, thickness=share * 0.1, min_wall_mm=0.0, warn_rib_share=1.0)
    model = Model(model.profile, tolerance=0.05)
    for finding in judged(model).values():
        assert (finding.level, finding.limit) == (level, 0.1)
