"""An indexing turret beside its cam: gaps, hand-over, fins, dwell, contact pressure and lives."""

from __future__ import annotations

from collections.abc import Iterable
from math import degrees
from typing import TYPE_CHECKING

import numpy as np

from camgeom.checks import check
from camgeom.checks.verdict import NO_GAP, Finding, NotJudged, judged

if TYPE_CHECKING:
    from camgeom.model import Model
    from camgeom.solid.mechanism import Turret

DWELL_SECONDS = 30.0
"""seconds of arc; coarser end of the indexing accuracy of globoidal cams (T/WLJC 15-2018, section 3.2)"""
HORN_DEGREES = 60.0
"""degrees of cam angle; a groove that runs out of an end face during an index takes 5 to 30, a hoop the whole dwell"""


def _turret(model: Model) -> Turret:
    turret = model.mechanism.turret
    assert turret is not None, "the registry asks for it"
    return turret


@check("stops", "turret")
def stops(model: Model) -> Iterable[Finding]:
    """Number of stops against the range in use; a remark, never a failure."""
    follower = _turret(model).follower
    value, (low, high) = follower.stops, follower.usual_stops
    if value < low:
        advice = f"fewer than {low} stops: expect a large pressure angle; more motion angle or a smaller rf / C helps"
        yield judged("stops", float(value), ">=", float(low), "stops", advice, worst="warn")
    else:
        advice = f"more than {high} stops: preload tends to jam; take the groove form and little preload"
        yield judged("stops", float(value), "<=", float(high), "stops", advice, worst="warn")


@check("turret-gap", "turret")
def turret_gap(model: Model) -> Iterable[Finding]:
    """Free distances of the turret: between rollers, body to blank, roller ends to floor."""
    limit = model.profile.limits.clearance_mm
    for name, value, remedy in _turret(model).gaps:
        yield judged("turret-gap", value, ">", limit, "mm", remedy, slack=-NO_GAP, where=name)


@check("hand-over", "turret", slow=True)
def hand_over(model: Model) -> Iterable[Finding]:
    """Least number of rollers with a wall to bear on, pushing on and holding back, over the whole turn."""
    from camgeom.track.turret import least_held

    turret = _turret(model)
    for least, name in zip(least_held(turret.bearing, model.mechanism.within), ("pushing on", "holding back")):
        advice = "no roller holds the turret there: widen the cam so that the next roller is engaged"
        if turret.take_turns:
            advice = (
                "no roller of any plate holds the turret there: a larger cam.diameter or cam.center_distance keeps "
                "them beside their plates longer, more motion angle makes the walls less steep"
            )
        yield judged(
            "hand-over", least.value, ">=", 1.0, "rollers", advice, cam_angle=least.cam_angle, where=name
        )


@check("fins", "body", "turret", "solid")
def fins(model: Model) -> Iterable[Finding]:
    """Thin pieces that the grooves cut off a too wide blank."""
    for solid in model.solids:
        pieces = solid.pieces
        advice = ""
        if len(pieces) > 1:
            size = sorted(piece.volume for piece in pieces)
            inner = min(float(np.abs(piece.vertices[:, 2]).min()) for piece in pieces if piece.volume < size[-1])
            advice = (
                f"the blank is so wide that the grooves cut {len(pieces) - 1} fins off (largest {size[-2]:.4g} mm3); "
                f"reduce the width below {2.0 * inner:.4g} mm or the globoid radius's overlap with the rollers"
            )
        yield judged("fins", float(len(pieces) - 1), "<=", 0.0, "1", advice, where=solid.name)


@check("horns", "turret", slow=True)
def horns(model: Model) -> Iterable[Finding]:
    """Longest outer wall at an end face whose foot is cut away: a wedge where a groove runs out, a hoop in a dwell."""
    if not _turret(model).rib_depths:
        return
    from camgeom.track.turret import longest_horn

    half, wall = 0.5 * model.mechanism.width, model.profile.limits.min_wall_mm
    found = [longest_horn(cutter, model.mechanism.within, half, wall) for cutter in model.cutters]
    worst = max((horn for horn in found if horn is not None), key=lambda horn: horn.turn, default=None)
    if worst is None:
        return
    advice = (
        f"the outermost grooves leave a thin hoop at the end faces: make the width less than {worst.narrower:.4g} mm, "
        f"so that they are open there, or more than {worst.wider:.4g} mm"
    )
    yield judged("horns", degrees(worst.turn), "<=", HORN_DEGREES, "deg", advice, cam_angle=worst.cam_angle)


@check("relief", "turret")
def relief(model: Model) -> Iterable[Finding]:
    """Least distance of rollers and finished flanks at the ends of dwells, where the cam has a lead-in relief."""
    turret = _turret(model)
    if not turret.relief:
        return
    from camgeom.track.turret import play_at

    for end in turret.dwell_ends:
        value = play_at(turret.bearing, model.cutters, model.mechanism.within, end)
        advice = "raise `relief` above the preload, or lower the preload"
        yield judged("relief", value, ">", 0.0, "mm", advice, cam_angle=end, where="roller to flank")


@check("dwell-accuracy", "turret", "solid")
def dwell_accuracy(model: Model) -> Iterable[Finding]:
    """Error of the turret's angle that the mesh's chord error may cause; a remark: cams are not ground from meshes."""
    radius = _turret(model).follower.pitch_radius
    error = max(solid.chord_error for solid in model.solids)
    value = degrees(error / radius) * 3600.0
    wanted = np.radians(DWELL_SECONDS / 3600.0) * radius
    advice = f"parts made from the mesh need a tolerance of {wanted:.3g} mm or less"
    yield judged("dwell-accuracy", value, "<=", DWELL_SECONDS, "arcsec", advice, worst="warn")


@check("vibration", "turret", "turret load")
def vibration(model: Model) -> Iterable[NotJudged]:
    """Tells that a loaded turret was judged rigid where the profile says nothing of its shafts."""
    if model.profile.dynamics_spec is None:
        yield NotJudged("vibration", "no [dynamics]: pressure, life, dwell are of a rigid drive; give its shafts")
