"""The finished body: closed, of the right shape, within its chord error, thick enough, and clear of the roller."""

from __future__ import annotations

from collections.abc import Iterable
from math import degrees
from typing import TYPE_CHECKING

from camgeom.checks import Finding, check

if TYPE_CHECKING:
    from camgeom.model import Model

CONTACT_SLACK = 1e-7
"""mm; a roller that touches without a gap measures zero to this much"""


@check("watertight", "body", "solid")
def watertight(model: Model) -> Iterable[Finding]:
    """Every body closed and oriented, one shell, of the expected genus."""
    for solid in model.solids:
        mesh = solid.mesh
        advice = ""
        if not solid.sound:
            advice = (
                f"{solid.name}: watertight {mesh.watertight}, shells {mesh.components}, genus {mesh.genus} where "
                f"{solid.expected_genus} is expected; the groove may cut the body apart or open a hole"
            )
        yield Finding("watertight", float(solid.sound), 1.0, "", solid.sound, None, advice, solid.name)


@check("chord-error", "body", "solid")
def chord_error(model: Model) -> Iterable[Finding]:
    """Chord error of the mesh against the tolerance asked for."""
    for solid in model.solids:
        passed = solid.chord_error <= model.tolerance
        advice = "" if passed else "ask for a coarser tolerance"
        yield Finding("chord-error", solid.chord_error, model.tolerance, "mm", passed, None, advice, solid.name)


@check("interference", "solid", "tracks")
def interference(model: Model) -> Iterable[Finding]:
    """Least distance between roller and final mesh over the whole turn; negative is penetration."""
    limit = model.profile.limits.clearance_mm - model.mechanism.allowed_interference
    for track, found in zip(model.passages, model.clearances):
        passed = found.value >= limit - CONTACT_SLACK
        advice = "" if passed else "the roller cuts into the cam away from its contact: check undercut and clearances"
        angle = degrees(found.cam_angle) % 360.0
        yield Finding("interference", found.value, limit, "mm", passed, angle, advice, track.name)


@check("wall", "body")
def wall(model: Model) -> Iterable[Finding]:
    """Thinnest walls of the body."""
    limit = model.profile.limits.min_wall_mm
    for one in model.walls:
        passed = one.thickness >= limit
        advice = "" if passed else one.advice
        angle = None if one.cam_angle is None else degrees(one.cam_angle) % 360.0
        yield Finding("wall", one.thickness, limit, "mm", passed, angle, advice, one.name)
