"""What the [cutter] tool makes of the flanks, how deep it cuts into them, what it leaves that jams the follower; and
whether it goes into a ring."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from camgeom.checks import check
from camgeom.checks.verdict import Finding, NotJudged, judged
from camgeom.errors import DesignError

if TYPE_CHECKING:
    from camgeom.model import Model


@check("gouge", "cutter")
def gouge(model: Model) -> Iterable[Finding | NotJudged]:
    """Deepest cut of the tool into a finished flank, against `cutter.gouge_limit`; a tool that does not fit fails."""
    outcome = model.machined
    least, spec = outcome.least, outcome.machining.spec
    value = 0.0 if outcome.certain or least is None else max(0.0, -least.value)
    if mouth := outcome.mouth():
        yield judged(
            "gouge", mouth, "<=", spec.gouge_limit, "mm",
            "the tool is thicker below than the groove's mouth, into which it plunges: open the groove at an end "
            "(run_out), or use a smaller tool or a longer cutter.lead",
            where=f"mouth, {outcome.machining.tool.about}",
        )  # fmt: skip
    if (profile := outcome.into_profile) is not None:
        yield judged(
            "gouge", profile[0], "<=", spec.gouge_limit, "mm", "use a smaller tool", cam_angle=profile[1],
            where=f"profile, {outcome.machining.tool.about}",
        )  # fmt: skip
        return
    yield judged(
        "gouge", value, "<=", spec.gouge_limit, "mm", outcome.advice if value > spec.gouge_limit else "",
        cam_angle=least.cam_angle if least is not None and value else None, where=outcome.machining.tool.about,
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

    A flank may stand proud by as much as it may be cut into, `cutter.gouge_limit`, or by the ridges of a ball.
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
    if most is None:
        return
    limit = max(spec.gouge_limit, spec.scallop + spec.tolerance if spec.kind == "ball" else 0.0)
    advice = ("the follower may jam on it: a tool as large as the roller, path = 'flank', a taper of a cone's half "
              "angle, or a smaller ball")  # fmt: skip
    yield judged(
        "stock-left", max(0.0, most.value - spec.allowance), "<=", limit, "mm", advice, cam_angle=most.cam_angle,
        where=f"beyond the allowance, {outcome.machining.tool.about}",
    )  # fmt: skip
