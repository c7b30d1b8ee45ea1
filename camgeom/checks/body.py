"""The finished body: closed, of the right shape, within its chord error, thick enough, and clear of the roller."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from camgeom.checks import check
from camgeom.checks.verdict import NO_GAP, Finding, NotJudged, judged
from camgeom.track import TURN

if TYPE_CHECKING:
    from camgeom.model import Model

CONTACT_SLACK = 1e-7
"""mm; a roller that touches without a gap measures zero to this much"""


@check("watertight", "body", "solid")
def watertight(model: Model) -> Iterable[Finding]:
    """Every body closed and oriented, one shell, of the expected genus; one that crosses itself is no body."""
    for solid, _ in model.workpieces:
        mesh = solid.mesh
        advice = (
            f"{solid.name}: watertight {mesh.watertight}, shells {mesh.components}, genus {mesh.genus} where "
            f"{solid.expected_genus} is expected; the groove may cut the body apart or open a hole"
        )
        yield judged("watertight", float(solid.sound), "=", 1.0, "", advice, where=solid.name)


@check("chord-error", "body", "solid")
def chord_error(model: Model) -> Iterable[Finding]:
    """Chord error of the mesh against the tolerance asked for."""
    for solid, _ in model.workpieces:
        advice = "ask for a coarser tolerance"
        yield judged("chord-error", solid.chord_error, "<=", model.tolerance, "mm", advice, where=solid.name)
        if solid.free_error is not None:
            where = f"{solid.name}, faces that nothing touches"
            yield judged("chord-error", solid.free_error, "<=", model.free_tolerance, "mm", advice, where=where)


@check("interference", "solid")
def interference(model: Model) -> Iterable[Finding]:
    """Least distance between follower and final mesh over the whole turn; negative is penetration."""
    limit = 0.0 - model.mechanism.allowed_interference
    advice = (
        "the follower cuts into the cam away from its contact, or the mesh is rougher than it says: check undercut, "
        "clearances and chord error"
    )
    for least in model.clearances:
        yield judged(
            "interference", least.value, ">=", limit, "mm", advice,
            slack=CONTACT_SLACK, cam_angle=least.cam_angle, where=least.where,
        )  # fmt: skip


@check("backlash", "body", "solid")
def backlash(model: Model) -> Iterable[Finding]:
    """Largest distance of the finished flanks from the followers that pass them, against what was asked for."""
    asked = model.mechanism.allowed_backlash
    for gap in model.backlash:
        x, y, z = gap.point
        yield judged(
            "backlash", gap.value, "<=", asked, "mm",
            f"the flank is cut deeper than its follower reaches and the {asked:.6g} mm of running clearance, relief "
            "and preload allow: the body is not that of this motion and follower, or the mesh is rougher than it says",
            slack=CONTACT_SLACK, cam_angle=gap.cam_angle, where=f"x = {x:.6g}, y = {y:.6g}, z = {z:.6g} mm",
        )  # fmt: skip


def _thinnest(model: Model, error: float) -> float:
    """Thinnest wall that passes, mm: that of the profile, or what the chord errors of both faces leave standing."""
    return max(model.profile.limits.min_wall_mm, 2.0 * error)


@check("followers-apart", "body")
def followers_apart(model: Model) -> Iterable[Finding | NotJudged]:
    """From the rollers of one follower on a body to those of another, which move at other times, and to its pivot."""
    if len(model.bindings) > 1 and not all(one.mechanism.rollers for one in model.bindings):
        yield NotJudged("followers-apart", "nothing measures how near faces and edges of two followers come")
    limit = model.profile.limits.clearance_mm
    place = "a place further away about the cam (the angle of its [[station]])"
    if model.apart is not None:
        least = model.apart
        yield judged(
            "followers-apart", least.value, ">", limit, "mm", f"{place}, smaller rollers, a larger cam",
            slack=-NO_GAP, cam_angle=least.cam_angle, where=least.where,
        )  # fmt: skip
    if model.apart_from_pivots is not None:
        least = model.apart_from_pivots
        yield judged(
            "followers-apart", least.value, ">", limit, "mm",
            "the roller runs over the pivot of the other arm, so that the pivots have to stand on different sides of "
            f"the cam, with the arms reaching over: see that the machine has that room, or take {place}, a smaller "
            "roller, a larger center_distance",
            slack=-NO_GAP, cam_angle=least.cam_angle, where=least.where, worst="warn",
        )  # fmt: skip


@check("pivot", "arm")
def pivot(model: Model) -> Iterable[Finding]:
    """From the pivot of an arm to the circle that its disc sweeps, or to its plate; in a groove it stands beside it."""
    gap = model.pivot_gap
    if gap is None:
        return
    advice = "so arm and pivot have to stand beside {}, with what touches it reaching over: see that the machine has "
    advice += "that room, or {}"
    if model.profiles is None:
        advice = "the pivot stands in the way of the plate as it goes to and fro, " + advice.format(
            "it", "take a lower follower.start_angle, which lifts the pivot, or the other side")  # fmt: skip
    else:
        swept = model.profiles.largest_radius.value
        advice = f"the pivot stands within the {swept:.6g} mm that the disc sweeps, " + advice.format(
            "the disc", "take a larger center_distance")  # fmt: skip
    yield judged(
        "pivot", gap.value, ">", model.profile.limits.clearance_mm, "mm", advice,
        slack=-NO_GAP, cam_angle=gap.cam_angle, where=gap.where, worst="warn",
    )  # fmt: skip


@check("neighbour", "tracks")
def neighbour(model: Model) -> Iterable[Finding]:
    """Least distance of every roller, as long as it is, from the discs that it must not touch, over the turn."""
    limit = model.profile.limits.clearance_mm
    for beside in model.mechanism.neighbours:
        least = beside.gap(limit)
        advice = "the roller runs into the other disc: a shorter roller, or a larger gap between the discs"
        yield judged(
            "neighbour", least.value, ">", limit, "mm", advice,
            slack=-NO_GAP, cam_angle=least.cam_angle, where=f"{beside.name}, {least.where}",
        )  # fmt: skip


@check("wall", "body")
def wall(model: Model) -> Iterable[Finding]:
    """Thinnest walls of the body."""
    for place in model.walls:
        yield judged(
            "wall", place.thickness, ">=", _thinnest(model, model.free_tolerance), "mm", place.advice,
            cam_angle=place.cam_angle, where=place.name,
        )  # fmt: skip


@check("rib-thickness", "tracks", slow=True)
def rib_thickness_check(model: Model) -> Iterable[Finding]:
    """Least normal thickness of ribs at their tip and root: between a drum's two rollers, or a turret's neighbours."""
    limits, mechanism, turret = model.profile.limits, model.mechanism, model.mechanism.turret
    warn = None if mechanism.rib_asked is None else (1.0 - limits.warn_rib_share) * mechanism.rib_asked
    for rib in mechanism.ribs:
        yield judged(
            "rib-thickness", rib.value, ">=", _thinnest(model, model.tolerance), "mm",
            f"steep places thin the rib to less than the {mechanism.rib_asked:.6g} mm of a level dwell: give the "
            "motion more cam angle, enlarge the drum, or ask for a thicker rib",
            warn=warn, cam_angle=rib.cam_angle, where=f"rib {rib.where}",
        )  # fmt: skip
    if turret is None:
        return
    from camgeom.track.turret import rib_thickness

    pitch = TURN / turret.follower.count
    for name, delta in turret.rib_depths:
        neighbours = (rib_thickness(track, pitch, mechanism.within, delta) for track in model.cutters)
        worst = min((rib for rib in neighbours if rib is not None), key=lambda rib: rib.thickness, default=None)
        if worst is None:
            continue
        advice = "use smaller or fewer rollers or a larger pitch radius, or reduce the width"
        yield judged(
            "rib-thickness", worst.thickness, ">=", _thinnest(model, model.tolerance), "mm", advice,
            cam_angle=worst.cam_angle, where=f"rib {name}",
        )  # fmt: skip
