"""What holds a follower: the force that keeps it on a cam that only pushes, the play of one driven both ways."""

from __future__ import annotations

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


def loose_fit(size: float) -> float:
    """Largest clearance, mm, of the loose running fit H11/c11 of a nominal size, mm; above 500 mm that of 500 mm.

    The coarsest of the preferred clearance fits of ISO 286: the hole may be IT11 too large, the shaft IT11 smaller than
    its upper deviation.
    """
    from camgeom.tolerance.fits import SIZES, clearance

    return clearance("H11/c11", min(size, SIZES[-1]))[1]


@check("play")
def play(model: Model) -> Iterable[Finding | NotJudged]:
    """Play of a follower that is driven both ways, as asked for; beyond a loose running fit it strikes, not runs."""
    mechanism, given = model.mechanism, model.profile.limits.play_mm
    if mechanism.drive is Drive.ALONE:
        return
    size = mechanism.fit_size
    between = "between both walls" if mechanism.follower.clearance else "between both walls, square to them"
    found = judged(
        "play", mechanism.free_play, "<=", loose_fit(size) if given is None else given, "mm",
        f"more than the loosest running fit of {size:.6g} mm has (H11/c11 of ISO 286): the follower strikes from wall "
        "to wall, and stands anywhere between them; a smaller clearance, or limits.play_mm where so much is meant"
        if given is None else "a smaller clearance",
        where=between + (" at the ends of dwells" if mechanism.turret and mechanism.turret.relief else ""),
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
    held = next((duty for duty in model.driven if duty.kept is not None), None)
    if held is None or held.kept is None:
        return
    kept, least = held.kept, held.kept.least
    slack = FORCE_SLACK * float(held.contact_forces.max())
    advice = where = ""
    if least.value < -slack:
        ranges = [f"{degrees(lost.begin):.6g} to {degrees(lost.end):.6g}" for lost in kept.lost]
        where = ", ".join(f"no contact from {angles} deg" for angles in ranges)
        unit = "N mm" if model.profile.rotating else "N"
        if kept.leaving_speed is not None:
            advice = f"contact is lost above {kept.leaving_speed * 30.0 / pi:.6g} r/min: "
        advice += f"raise spring_preload to {kept.preload_needed:.6g} {unit}"
        advice += " or more, lower the mass or the speed, or use a form-closed cam"
    yield judged(
        "contact-kept", least.value, ">=", 0.0, "N", advice, slack=slack, cam_angle=least.cam_angle, where=where
    )
