"""Undercut (local fold of the flank) and relative curvature (the contact must be tight everywhere)."""

from __future__ import annotations

from collections.abc import Iterable
from math import degrees
from typing import TYPE_CHECKING

from camgeom.checks import Finding, check

if TYPE_CHECKING:
    from camgeom.model import Model


@check("undercut", "tracks")
def undercut(model: Model) -> Iterable[Finding]:
    """Smallest undercut margin 1 - r k over the cut wall; it must be positive (and above the profile's limit)."""
    worst = min((survey.margin for survey in model.flanks), key=lambda e: e.value)
    limit = model.profile.limits.undercut_margin
    passed = worst.value > 0.0 and worst.value >= limit
    advice = "" if passed else "use a smaller roller, a larger cam or a gentler motion: the flank folds on itself"
    where = f"at {worst.place:.6g} mm along the roller axis"
    yield Finding("undercut", worst.value, limit, "1", passed, degrees(worst.cam_angle) % 360.0, advice, where)


@check("relative-curvature", "tracks")
def relative_curvature(model: Model) -> Iterable[Finding]:
    """Smallest relative curvature of cam against roller; positive everywhere (equation 33 of T/WLJC 15-2018)."""
    worst = min((survey.relative_curvature for survey in model.flanks), key=lambda e: e.value)
    passed = worst.value > 0.0
    advice = "" if passed else "the roller would cut into the flank beside its contact line: see undercut"
    angle = degrees(worst.cam_angle) % 360.0
    yield Finding("relative-curvature", worst.value, 0.0, "1/mm", passed, angle, advice)
