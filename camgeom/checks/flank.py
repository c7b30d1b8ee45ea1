"""The flanks of a cam: pressure angle, undercut (a local fold), relative curvature, and flank beside the roller."""

from __future__ import annotations

from collections.abc import Iterable
from math import degrees
from typing import TYPE_CHECKING

import numpy as np

from camgeom.checks import Finding, check

if TYPE_CHECKING:
    from camgeom.maths import Floats
    from camgeom.model import Model
    from camgeom.track import Track
    from camgeom.track.section import Level

PER_TURN = 720


@check("pressure-angle")
def pressure_angle(model: Model) -> Iterable[Finding]:
    """Largest pressure angle against the limit of the follower kind."""
    limit, worst = model.profile.limits.pressure_angle_deg, model.pressure_angle
    assert limit is not None
    if worst is None:
        return
    value = degrees(worst.value)
    advice = ""
    if value > limit:
        advice = "give the motion more cam angle, enlarge the cam, or take a law of lower peak velocity"
    where = worst.where
    if not model.mechanism.touches and model.drive_angle is None:
        where = f"at {worst.place:.6g} mm along the roller axis"
    angle = degrees(worst.cam_angle) % 360.0
    yield Finding("pressure-angle", value, limit, "deg", value <= limit, angle, advice, where)


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


@check("contact-length", "tracks")
def contact_length(model: Model) -> Iterable[Finding]:
    """Least length of flank beside the contact stretch of a drum's roller; swinging rollers can leave the drum."""
    from camgeom.maths.extremum import piece_grid

    top = model.mechanism.wall_top
    if top is None:
        return
    for track in model.tracks:
        phi, _ = piece_grid(track.knots(), PER_TURN)
        found = _lengths(track, phi, *top)
        least = int(np.argmin(found))
        value, angle = float(found[least]), degrees(float(phi[least])) % 360.0
        advice = "" if value > 0.0 else (
            "the roller leaves the drum sideways and touches nothing there: a longer arm, less swing, a pivot distance "
            "that centres the arc, or a larger drum"
        )
        yield Finding("contact-length", value, 0.0, "mm", value > 0.0, angle, advice, track.name)


def _lengths(track: Track, phi: Floats, top: Level, near: float) -> Floats:
    """Length of flank beside a roller's contact stretch at cam angles (n,), mm; not positive: none."""
    from camgeom.track.section import Column

    low, high = sorted(track.contact)
    column = Column(track, phi)
    ends = [column.reach(side, top, near)[:, 0] for side in track.sides]
    return np.asarray(np.min([np.minimum(track.meridian.jet(end)[0], high) - low for end in ends], axis=0))
