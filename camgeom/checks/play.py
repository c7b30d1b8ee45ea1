"""Play between a cam and a follower that it drives both ways: what was asked for, against what a running fit has."""

from __future__ import annotations

from collections.abc import Iterable
from math import cbrt
from typing import TYPE_CHECKING

from camgeom.checks import check
from camgeom.checks.verdict import Finding, NotJudged, judged
from camgeom.solid.mechanism import Drive

if TYPE_CHECKING:
    from camgeom.model import Model

LARGEST_SIZE = 500.0
"""mm, up to which ISO 286-1 has these formulas"""


def loose_fit(size: float) -> float:
    """Largest clearance, mm, of the loose running fit H11/c11 of a nominal size, mm.

    The coarsest of the preferred clearance fits of ISO 286. By the formulas of ISO 286-1 (its tables are rounded) the
    grade IT11 is 100 (0.45 D^(1/3) + 0.001 D) um, and a shaft c lies 52 D^0.2 um (to 40 mm), 95 + 0.8 D um (above)
    below its nominal size.
    """
    size = min(size, LARGEST_SIZE)
    grade = 100.0 * (0.45 * cbrt(size) + 0.001 * size)
    below = 52.0 * size**0.2 if size <= 40.0 else 95.0 + 0.8 * size
    return 1e-3 * (2.0 * grade + below)


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
        where="between both walls", worst="warn" if given is None else "fail",
    )  # fmt: skip
    yield found
    if found.level != "pass" and model.profile.impact_spec is None:
        why = model.cam.idle(model.setup).get("impact")
        reason = f"no solver for impacts: {why}" if why else "no [impact]"
        yield NotJudged("play", f"impacts in a play of {mechanism.free_play:.6g} mm: {reason}")
