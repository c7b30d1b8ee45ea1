"""The flanks of a cam: pressure angle, undercut (a local fold), relative curvature, and flank beside the roller."""

from __future__ import annotations

from collections.abc import Iterable
from math import acos, atan, cos, degrees, tan
from typing import TYPE_CHECKING

import numpy as np

from camgeom.checks import check, solved
from camgeom.checks.verdict import NO_GAP, Finding, NotJudged, judged
from camgeom.track import TURN

if TYPE_CHECKING:
    from camgeom.maths import Floats
    from camgeom.mechanics.duty import Duty
    from camgeom.model import Model
    from camgeom.track import Track
    from camgeom.track.column import Level

PER_TURN = 720


@check("pressure-angle")
def pressure_angle(model: Model) -> Iterable[Finding]:
    """Largest pressure angle against the limit of the follower kind."""
    limits, worst = model.profile.limits, model.pressure_angle
    if worst is None:
        return
    where = worst.where
    if not model.mechanism.touches and model.drive_angle is None:
        where = f"at {worst.place:.6g} mm along the roller axis"
    advice = "give the motion more cam angle, enlarge the cam, or take a law of lower peak velocity"
    limit = limits.pressure_angle_deg
    if limit is not None and (lean := _lean(model)):
        flat = degrees(acos(min(1.0, cos(worst.value) / cos(lean))))
        if flat <= limit < degrees(worst.value):
            advice = f"a smaller roller.half_angle: without the cone's lean it is {flat:.6g} deg there"
    yield judged(
        "pressure-angle", degrees(worst.value), "<=", limit, "deg", advice,
        warn=limits.warn_pressure_angle_deg, cam_angle=worst.cam_angle, where=where,
    )  # fmt: skip


def _lean(model: Model) -> float:
    """By how much cones parallel to the cam's axis lean to it, rad; 0 of what does not."""
    from camgeom.track import Straight

    meridians = [track.meridian for track in model.tracks if track.upright]
    return max((atan(abs(one.slope)) for one in meridians if isinstance(one, Straight)), default=0.0)


@check("undercut", "tracks")
def undercut(model: Model) -> Iterable[Finding]:
    """Smallest undercut margin 1 - r k over the cut wall; it must be positive (and above the profile's limit)."""
    survey = min(model.flanks, key=lambda survey: survey.margin.value)
    worst, limits = survey.margin, model.profile.limits
    limit = limits.undercut_margin
    yield judged(
        "undercut", worst.value, ">=" if limit else ">", limit, "1",
        "use a smaller roller, a larger cam or a gentler motion: the flank folds on itself",
        warn=limits.warn_undercut_margin, cam_angle=worst.cam_angle,
        where=f"{survey.track.name}, at {worst.place:.6g} mm along the roller axis",
    )  # fmt: skip


@check("relative-curvature", "tracks")
def relative_curvature(model: Model) -> Iterable[Finding]:
    """Smallest relative curvature of cam against roller; positive everywhere (equation 33 of T/WLJC 15-2018)."""
    survey = min(model.flanks, key=lambda survey: survey.relative_curvature.value)
    worst = survey.relative_curvature
    if worst.value <= 0.0:
        # Beyond a cusp it comes back from minus infinity: the least that the samples meet says nothing.
        advice = "the flank folds on itself, where its curvature has no bound: see undercut"
        yield Finding("relative-curvature", "fail", None, ">", 0.0, "1/mm", where=survey.track.name, advice=advice)
        return
    where = f"{survey.track.name}, at {worst.place:.6g} mm along the roller axis"
    yield judged("relative-curvature", worst.value, ">", 0.0, "1/mm", "", cam_angle=worst.cam_angle, where=where)


@check("contact-length", "tracks")
def contact_length(model: Model) -> Iterable[Finding]:
    """Least length of flank beside the contact stretch of a drum's roller; swinging rollers can leave the drum."""
    from camgeom.maths.extremum import piece_grid

    top = model.mechanism.wall_top
    if top is None:
        return
    advice = (
        "the roller leaves the cam sideways and touches nothing there: a longer arm, less swing, a pivot distance "
        "that centres the arc, or a larger cam"
    )
    for track in map(model.mechanism.cutting, model.tracks):
        phi, _ = piece_grid(track.knots(), PER_TURN)
        lengths = _lengths(track, phi, *top)
        least = int(np.argmin(lengths))
        yield judged(
            "contact-length", float(lengths[least]), ">", 0.0, "mm", advice,
            cam_angle=float(phi[least]), where=track.name,
        )  # fmt: skip


def _lengths(track: Track, phi: Floats, top: Level, near: float) -> Floats:
    """Length of flank beside a roller's contact stretch at cam angles (n,), mm; not positive: none."""
    from camgeom.track.column import Column

    low, high = sorted(track.contact)
    column = Column(track, phi)
    ends = [column.reach(side, top, near)[:, 0] for side in track.sides]
    return np.asarray(np.min([np.minimum(track.meridian.jet(end)[0], high) - low for end in ends], axis=0))


@check("floor-gap", "tracks")
def floor_gap(model: Model) -> Iterable[Finding]:
    """From a roller's flat end to the floor of its groove: an end that rubs wears, and takes the flanks' load."""
    gap = model.mechanism.floor_gap
    if gap is not None:
        yield judged(
            "floor-gap", gap, ">", model.profile.limits.clearance_mm, "mm",
            "the roller's end rubs on the floor: a shorter roller or a deeper groove", slack=-NO_GAP,
        )  # fmt: skip


@check("mouth", "tracks")
def mouth(model: Model) -> Iterable[Finding]:
    """Half of what a groove that is closed all round is wide at its mouth, less the roller's largest radius in it."""
    if model.mechanism.runs_out:
        return
    for track, cutter in zip(model.tracks, model.cutters):
        if len(track.sides) == 1 or not track.closed:
            continue
        cut, roller = _radii(cutter), _radii(track)
        top = float(cut[0 if cutter.tip_sign > 0.0 else -1])
        if float(cut.max()) <= top + NO_GAP:
            continue
        yield judged(
            "mouth", top - float(roller.max()), ">=", 0.0, "mm",
            "no roller that is thicker within its groove than the mouth goes in: a pocket in the groove or a split "
            "cam, a cone that narrows towards its free end, or more running_clearance",
            slack=NO_GAP, where=track.name, worst="warn",
        )  # fmt: skip


def _radii(track: Track) -> Floats:
    """Radii over a roller's contact stretch, from its lower end to its upper one, mm."""
    low, high = (track.meridian.parameter(end) for end in sorted(track.contact))
    return track.meridian.jet(np.linspace(low, high, 65))[3]


@check("carrier", "tracks")
def carrier(model: Model) -> Iterable[Finding | NotJudged]:
    """From the bar that carries a roller within a ring to the ring's web."""
    bar = model.mechanism.carrier
    if bar is None:
        return
    if bar.diameter is None:
        room = f"at its lowest its middle is {bar.room:.4g} mm above the web"
        yield NotJudged("carrier", f"give cam.carrier_diameter, of the bar that carries the roller in the ring: {room}")
        return
    yield judged(
        "carrier", bar.room - 0.5 * bar.diameter, ">", model.profile.limits.clearance_mm, "mm",
        "the bar that carries the roller rubs on the web: a thinner one, a higher cam.start, or a thinner web",
        where="carrier to web",
    )  # fmt: skip
    places = sorted(one.angle for one in model.bindings)
    least = min(float(np.diff([*places, places[0] + TURN]).min()), 0.5 * TURN)
    if (meet := 0.5 * bar.diameter / tan(0.5 * least)) > NO_GAP:
        yield NotJudged("carriers", "how far in they reach nobody says: two of them at one height meet within "
                        f"{meet:.4g} mm of the cam axis")  # fmt: skip


def unheld(name: str, model: Model, duties: Iterable[Duty]) -> Iterable[Finding]:
    """Largest force of each duty that presses its follower where a groove has run out of the drum."""
    for force in filter(None, (duty.unheld for duty in duties)):
        yield judged(
            name, force.value, "<=", 0.0, "N mm" if model.setup.follower.rotating else "N",
            "the follower is pressed where it has no wall, and leaves its motion there: hold it by a stop, or turn the "
            "spring, the weight or the run-out round",
            cam_angle=force.cam_angle, where="force that no wall takes",
        )  # fmt: skip


@check("run-out", "tracks", "operation")
def run_out(model: Model) -> Iterable[Finding]:
    """How far the contact stays within a drum's ends; where it leaves on purpose, over how much of a turn."""
    drum = model.mechanism.drum
    if drum is None or model.mechanism.turret is not None:
        return
    low, high = drum.low, drum.high
    if not model.mechanism.runs_out:
        from camgeom.track.survey import smallest

        intended = "run_out" in type(model.profile.cam).model_fields
        meant = ", or say `run_out = true` where that is meant" if intended else ""
        contacts = [contact for survey in model.flanks for contact in survey.contacts]
        least = smallest(contacts, lambda flank: np.minimum(flank.x[2] - low, high - flank.x[2]))
        yield judged(
            "run-out", least.value, ">=", 0.0, "mm",
            "the roller leaves the cam through an end face and touches nothing there: lengthen the cam or move the "
            f"roller along it{meant}",
            cam_angle=least.cam_angle, where=f"{least.where} to the nearer end",
        )  # fmt: skip
        return
    for name, stretches in model.lost_contact.items():
        lost = sum(stop - start for start, stop in stretches)
        ranges = ", ".join(f"{degrees(a) % 360.0:.6g} .. {degrees(b) % 360.0:.6g}" for a, b in stretches)
        advice = f"nothing holds the roller on this side at {ranges} deg: see that nothing pushes it there"
        yield judged(
            "run-out", degrees(lost), "<=", 0.0, "deg", advice, worst="warn",
            cam_angle=stretches[0][0] if stretches else None, where=f"{name} without contact",
        )  # fmt: skip
    if not any(model.lost_contact.values()):
        yield Finding("run-out", "warn", 0.0, "", None, "deg", advice="the groove stays within the drum: no `run_out`")
    if model.profile.operation is not None:
        yield from unheld("run-out", model, model.duties)


@solved("dynamic-run-out", "dynamics")
def dynamic_run_out(model: Model) -> Iterable[Finding]:
    """Force of the elastic follower that presses where its groove has run out: it is solved as if held there."""
    if model.mechanism.runs_out:
        yield from unheld("dynamic-run-out", model, model.dynamic_duties)
