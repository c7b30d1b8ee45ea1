"""Pressure angle at every depth along the roller, on every flank it works on."""

from __future__ import annotations

from collections.abc import Iterable
from math import degrees
from typing import TYPE_CHECKING

from camgeom.checks import Finding, check

if TYPE_CHECKING:
    from camgeom.model import Model

ADVICE = "give the motion more cam angle, enlarge the cam, or take a law of lower peak velocity"


@check("pressure-angle")
def pressure_angle(model: Model) -> Iterable[Finding]:
    """Largest pressure angle against the limit of the follower kind; of a planar cam at the roller's centre."""
    limit = model.profile.limits.pressure_angle_deg
    assert limit is not None
    if model.planar is None and not model.tracks:
        return
    if model.drive_angle is not None:
        value, at = model.drive_angle
        passed, where = degrees(value) <= limit, "best placed roller that carries"
        advice = "" if passed else ADVICE
        yield Finding("pressure-angle", degrees(value), limit, "deg", passed, degrees(at), advice, where)
        return
    if model.planar is not None:
        found = model.planar.pressure_angle
        angle = degrees(found.cam_angle) % 360.0
        passed = degrees(found.value) <= limit
        yield Finding(
            "pressure-angle", degrees(found.value), limit, "deg", passed, angle, "" if passed else ADVICE, found.where
        )
        return
    worst = max((survey.pressure_angle for survey in model.flanks), key=lambda e: e.value)
    value = degrees(worst.value)
    passed = value <= limit
    advice = "" if passed else ADVICE
    where = f"at {worst.place:.6g} mm along the roller axis"
    angle = degrees(worst.cam_angle) % 360.0
    yield Finding("pressure-angle", value, limit, "deg", passed, angle, advice, where)
