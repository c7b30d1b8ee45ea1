"""Continuity of the motion: velocity and acceleration must not jump (selection rules of T/WLJC 15-2018)."""

from __future__ import annotations

from collections.abc import Iterable
from math import degrees
from typing import TYPE_CHECKING

from camgeom.checks import check
from camgeom.checks.verdict import Finding, judged

if TYPE_CHECKING:
    from camgeom.model import Model

WORDS = ("lift", "velocity", "acceleration", "jerk")


@check("continuity")
def continuity(model: Model) -> Iterable[Finding]:
    """Order of continuity of the program; 2 (continuous acceleration) is wanted."""
    found = model.setup.program.continuity
    bad = [jump for jump in found.jumps if jump.order <= 2]
    places = ", ".join(f"{WORDS[j.order]} at {degrees(j.angle):.6g} deg" for j in bad[:6])
    advice = f"jumps in {places}; use a law with continuous acceleration, or join moving segments by a polynomial"
    yield judged(
        "continuity", float(found.order), ">=", 2.0, "order", advice, cam_angle=bad[0].angle if bad else None
    )
