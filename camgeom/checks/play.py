"""What holds a follower: the force that keeps it on a cam that only pushes, the play of one driven both ways."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable
from math import degrees, pi
from typing import TYPE_CHECKING

from camgeom.checks import check
from camgeom.checks.verdict import Finding, NotJudged, judged
from camgeom.solid.mechanism import Drive

if TYPE_CHECKING:
    from camgeom.model import Model

FORCE_SLACK = 1e-9
"""share of the peak force that rounding leaves where contact just holds"""
SIZES = (3.0, 6.0, 10.0, 18.0, 30.0, 40.0, 50.0, 65.0, 80.0, 100.0, 120.0, 140.0, 160.0, 180.0, 200.0, 225.0, 250.0,
         280.0, 315.0, 355.0, 400.0, 450.0, 500.0)  # fmt: skip
"""mm, upper ends of the steps of nominal sizes; each step holds its upper end"""
GRADE_11 = (60, 75, 90, 110, 130, 160, 160, 190, 190, 220, 220, 250, 250, 250, 290, 290, 290, 320, 320, 360, 360, 400,
            400)  # fmt: skip
"""um, standard tolerance IT11 of each step: ISO 286-1, table of standard tolerance grades"""
SHAFT_C = (60, 70, 80, 95, 110, 120, 130, 140, 150, 170, 180, 200, 210, 230, 240, 260, 280, 300, 330, 360, 400, 440,
           480)  # fmt: skip
"""um below nominal, upper deviation of shafts c of each step: ISO 286-1, table of fundamental deviations (as excerpted
in JIS B 0401, whose c9 has the same); the letter c ends at 500 mm"""


def loose_fit(size: float) -> float:
    """Largest clearance, mm, of the loose running fit H11/c11 of a nominal size, mm; above 500 mm that of 500 mm.

    The coarsest of the preferred clearance fits of ISO 286: the hole may be IT11 too large, the shaft IT11 smaller than
    its upper deviation.
    """
    step = min(bisect_left(SIZES, size), len(SIZES) - 1)
    return 1e-3 * (2 * GRADE_11[step] + SHAFT_C[step])


@check("play")
def play(model: Model) -> Iterable[Finding | NotJudged]:
    """Play of a follower that is driven both ways, as asked for; beyond a loose running fit it strikes, not runs."""
    mechanism, given = model.mechanism, model.profile.limits.play_mm
    if mechanism.drive is Drive.ALONE:
        return
    size = mechanism.fit_size
    found = judged(
        "play", mechanism.free_play, "<=", loose_fit(size) if given is None else given, "mm",
        f"more than the loosest running fit of {size:.6g} mm has (H11/c11 of ISO 286): the follower strikes from wall "
        "to wall, and stands anywhere between them; a smaller clearance, or limits.play_mm where so much is meant"
        if given is None else "a smaller clearance",
        where="between both walls" + (" at the ends of dwells" if mechanism.turret and mechanism.turret.relief else ""),
        worst="warn" if given is None else "fail",
    )  # fmt: skip
    yield found
    if found.level != "pass" and model.profile.impact_spec is None:
        why = model.cam.idle(model.setup).get("impact")
        reason = f"no solver for impacts: {why}" if why else "no [impact]"
        yield NotJudged("play", f"impacts in a play of {mechanism.free_play:.6g} mm: {reason}")


@check("contact-kept", "operation")
def contact_kept(model: Model) -> Iterable[Finding]:
    """Least force between a force-closed cam and its follower; below zero the follower leaves the cam."""
    shaft = model.shaft
    if shaft is None or shaft.kept is None:
        return
    kept, least = shaft.kept, shaft.kept.least
    slack = FORCE_SLACK * float(shaft.contact_forces.max())
    advice = where = ""
    if least.value < -slack:
        ranges = [f"{degrees(lost.begin):.6g} to {degrees(lost.end):.6g}" for lost in kept.lost]
        where = ", ".join(f"no contact from {angles} deg" for angles in ranges)
        rpm = kept.leaving_speed * 30.0 / pi
        unit = "N mm" if model.profile.rotating else "N"
        advice = f"contact is lost above {rpm:.6g} r/min: raise spring_preload to {kept.preload_needed:.6g} {unit}"
        advice += " or more, lower the mass or the speed, or use a form-closed cam"
    yield judged(
        "contact-kept", least.value, ">=", 0.0, "N", advice, slack=slack, cam_angle=least.cam_angle, where=where
    )
