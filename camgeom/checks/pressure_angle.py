"""Pressure angle at every depth along the roller, on every flank it works on."""

from __future__ import annotations

from collections.abc import Iterable
from math import degrees
from typing import TYPE_CHECKING

from camgeom.checks import Finding, check

if TYPE_CHECKING:
    from camgeom.model import Model


@check("pressure-angle", "tracks")
def pressure_angle(model: Model) -> Iterable[Finding]:
    """Largest pressure angle against the limit of the follower kind."""
    limit = model.profile.limits.pressure_angle_deg
    assert limit is not None
    worst = max((survey.pressure_angle for survey in model.flanks), key=lambda e: e.value)
    value = degrees(worst.value)
    passed = value <= limit
    advice = "" if passed else "give the motion more cam angle, enlarge the cam, or take a law of lower peak velocity"
    where = f"at {worst.delta:.6g} mm along the roller axis"
    angle = degrees(worst.cam_angle) % 360.0
    yield Finding("pressure-angle", value, limit, "deg", passed, angle, advice, where)
