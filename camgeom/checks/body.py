"""The finished body: closed, of the right shape, within its chord error, thick enough, and clear of the roller."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from camgeom.checks import check
from camgeom.checks.verdict import Finding, judged

if TYPE_CHECKING:
    from camgeom.model import Model

CONTACT_SLACK = 1e-7
"""mm; a roller that touches without a gap measures zero to this much"""


@check("watertight", "body", "solid")
def watertight(model: Model) -> Iterable[Finding]:
    """Every body closed and oriented, one shell, of the expected genus."""
    for solid in model.solids:
        mesh = solid.mesh
        advice = (
            f"{solid.name}: watertight {mesh.watertight}, shells {mesh.components}, genus {mesh.genus} where "
            f"{solid.expected_genus} is expected; the groove may cut the body apart or open a hole"
        )
        yield judged("watertight", float(solid.sound), "=", 1.0, "", advice, where=solid.name)


@check("chord-error", "body", "solid")
def chord_error(model: Model) -> Iterable[Finding]:
    """Chord error of the mesh against the tolerance asked for."""
    for solid in model.solids:
        advice = "ask for a coarser tolerance"
        yield judged("chord-error", solid.chord_error, "<=", model.tolerance, "mm", advice, where=solid.name)


@check("interference", "solid", "tracks")
def interference(model: Model) -> Iterable[Finding]:
    """Least distance between roller and final mesh over the whole turn; negative is penetration."""
    limit = model.profile.limits.clearance_mm - model.mechanism.allowed_interference
    advice = "the roller cuts into the cam away from its contact: check undercut and clearances"
    for track, least in zip(model.passages, model.clearances):
        yield judged(
            "interference", least.value, ">=", limit, "mm", advice,
            slack=CONTACT_SLACK, cam_angle=least.cam_angle, where=track.name,
        )  # fmt: skip


@check("wall", "body")
def wall(model: Model) -> Iterable[Finding]:
    """Thinnest walls of the body."""
    for place in model.walls:
        yield judged(
            "wall", place.thickness, ">=", model.profile.limits.min_wall_mm, "mm", place.advice,
            cam_angle=place.cam_angle, where=place.name,
        )  # fmt: skip
