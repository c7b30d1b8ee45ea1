"""Continuity of the motion: velocity and acceleration must not jump (selection rules of T/WLJC 15-2018)."""

from __future__ import annotations

from collections.abc import Iterable
from math import degrees
from typing import TYPE_CHECKING

from camgeom.checks import check
from camgeom.checks.verdict import Finding, Level, judged

if TYPE_CHECKING:
    from camgeom.model import Model
    from camgeom.motion.program import Continuity

WORDS = ("lift", "velocity", "acceleration", "jerk")


@check("continuity")
def continuity(model: Model) -> Iterable[Finding]:
    """Order of continuity of the program, and of how a plate is driven; 2 (continuous acceleration) is wanted."""
    join = "use a law with continuous acceleration, or join moving segments by a polynomial"
    yield _smooth(model.setup.program.continuity, f"jumps in {{}}; {join}")
    if model.mechanism.carriage is not None:
        turn = "the force on plate and slide jumps with the {}; use a cam.drive whose acceleration begins and ends at "
        even = "0, or, of a simple harmonic, cam.drive_out = 180"
        yield _smooth(model.mechanism.carriage.drive.continuity, turn + even, "the plate's drive", "warn")


def _smooth(found: Continuity, advice: str, where: str = "", worst: Level = "fail") -> Finding:
    bad = [jump for jump in found.jumps if jump.order <= 2]
    places = ", ".join(f"{WORDS[j.order]} at {degrees(j.angle):.6g} deg" for j in bad[:6])
    return judged("continuity", float(found.order), ">=", 2.0, "order", advice.format(places),
                  cam_angle=bad[0].angle if bad else None, where=where, worst=worst)  # fmt: skip
