"""What the [cutter] tool makes of the flanks, how deep it cuts into them, what it leaves that jams the follower; and
whether it goes into a ring."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from camgeom.checks import check
from camgeom.checks.verdict import Finding, NotJudged, judged
from camgeom.errors import DesignError, NotConverged

if TYPE_CHECKING:
    from camgeom.model import Model


@check("gouge", "cutter")
def gouge(model: Model) -> Iterable[Finding | NotJudged]:
    """Deepest cut of the tool into a finished flank, against `cutter.gouge_limit`; a tool that does not fit fails."""
    outcome = model.machined
    spec, about = outcome.machining.spec, outcome.machining.tool.about
    if mouth := outcome.mouth():
        yield judged(
            "gouge", mouth, "<=", spec.gouge_limit, "mm",
            "the tool is thicker below than the groove's mouth, into which it plunges: open the groove at an end "
            "(run_out), or use a smaller tool or a longer cutter.lead",
            where=f"mouth, {about}",
        )  # fmt: skip
    try:
        profile, flank = outcome.into_profile, outcome.into_flank
    except NotConverged as reason:
        yield NotJudged("gouge", str(reason))
        return
    if profile is not None:
        yield judged(
            "gouge", max(0.0, profile.deep), "<=", spec.gouge_limit, "mm",
            profile.advice(spec.gouge_limit, "use a smaller tool"),
            cam_angle=profile.cam_angle if profile.deep > 0.0 else None, where=f"profile, {about}",
        )  # fmt: skip
    if profile is None or outcome.machining.tracks:
        yield judged(
            "gouge", max(0.0, flank.deep), "<=", spec.gouge_limit, "mm", flank.advice(spec.gouge_limit, outcome.advice),
            cam_angle=flank.cam_angle if flank.deep > 0.0 else None, where=about,
        )  # fmt: skip


@check("angle-head", "cutter")
def angle_head(model: Model) -> Iterable[Finding | NotJudged]:
    """The tool's `cutter.length` against the room within the ring that it cuts from within; the head has no key."""
    try:
        machining = model.machined.machining
    except DesignError:
        return
    room, spec = machining.room, machining.spec
    if room is None:
        return
    if spec.length is not None:
        yield judged(
            "angle-head", spec.length, "<=", room.length, "mm",
            f"the tool alone is {spec.length - room.length:.6g} mm longer than the ring leaves behind it: a smaller "
            "cutter.length or cutter.retract, or a larger cam.inner_diameter",
            where=f"tool alone, from its end to the ring behind, {machining.tool.about}",
        )  # fmt: skip
    yield NotJudged("angle-head", f"the groove within the ring has to be cut by an angle head, and how large that is "
                    f"nobody says: along the tool's axis the ring leaves {room.length:.6g} mm for it and its tool, "
                    "less for what it is thicker than the tool, and from that axis down to the web "
                    f"{room.below:.6g} mm")  # fmt: skip


@check("stock-left", "cutter")
def stock_left(model: Model) -> Iterable[Finding | NotJudged]:
    """What the tool leaves on a flank beyond the allowance, where a follower touches it, against the flank's form.

    A flank may stand proud by as much as it may be cut into, `cutter.gouge_limit`, or by the ridges of a ball. The
    chords of the path leave stock in hollows, as they cut into bulges; where an allowance is ground off, that goes too.
    """
    try:
        outcome = model.machined
    except DesignError:
        # A tool that cannot cut the cam fails `gouge`, with the reason.
        return
    most, spec = outcome.most, outcome.machining.spec
    if spec.allowance:
        yield NotJudged("allowance", f"the tool leaves {spec.allowance:g} mm on the flanks: all else is said of "
                        "the cam that is ground to size")  # fmt: skip
    if standing := outcome.machining.standing:
        yield judged(
            "stock-left", standing, "<=", 0.0, "mm",
            "the passes make the groove's walls, not the groove: rough it out first, or take a tool that is wider by "
            f"{0.5 * standing:.6g} mm at least",
            where=f"standing between the passes, {outcome.machining.tool.about}", worst="warn",
        )  # fmt: skip
    try:
        sag, on_profile = outcome.sag, outcome.sag_on_profile
    except NotConverged as reason:
        yield NotJudged("stock-left", str(reason))
        return
    chords, coarse = 0.0 if spec.allowance else sag.left, "use a smaller cutter.tolerance"
    if outcome.into_profile is not None:
        yield judged(
            "stock-left", 0.0 if spec.allowance else on_profile.left, "<=", spec.gouge_limit, "mm", coarse,
            cam_angle=on_profile.left_at, where=f"profile, beyond the allowance, {outcome.machining.tool.about}",
        )  # fmt: skip
        if most is None:
            return
    limit = max(spec.gouge_limit, spec.scallop + min(spec.tolerance, spec.gouge_limit) if spec.kind == "ball" else 0.0)
    proud = 0.0 if most is None else max(0.0, most.value - spec.allowance)
    advice = ("the follower may jam on it: a tool as large as the roller, path = 'flank', a taper of a cone's half "
              "angle, or a smaller ball")  # fmt: skip
    yield judged(
        "stock-left", proud + chords, "<=", limit, "mm", coarse if proud <= limit else advice,
        cam_angle=most.cam_angle if most is not None and proud else sag.left_at,
        where=f"beyond the allowance, {outcome.machining.tool.about}",
    )  # fmt: skip
