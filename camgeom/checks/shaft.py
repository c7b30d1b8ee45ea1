"""Torque of the camshaft and static safety of the rollers' bearings: rigid, with vibration, with impacts."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from camgeom.checks import LIFTED, NO_OPERATION, check, solved
from camgeom.checks.verdict import Finding, NotJudged, judged

if TYPE_CHECKING:
    from camgeom.maths.extremum import Extreme
    from camgeom.mechanics.duty import Duty
    from camgeom.model import Model

TORQUE = "less mass, force or speed, more angle for the motion, a smoother law, or a stronger drive"
BEARING = "a roller with a higher static rating, less mass, force or speed, or a smoother law"


def _torque(name: str, model: Model, peak: Extreme) -> Iterable[Finding]:
    """The largest torque, N mm, against the limit, where the profile gives one."""
    limit = model.profile.limits.torque_n_m
    if limit is not None:
        yield judged(name, 1e-3 * peak.value, "<=", limit, "N m", TORQUE, cam_angle=peak.cam_angle, where=peak.where)


def _bearing(name: str, model: Model, duties: Iterable[Duty]) -> Iterable[Finding]:
    """The least static safety of all rollers that have a rating."""
    rated = [(duty.bearing.static_safety, duty) for duty in duties if duty.bearing is not None]
    each = [(float(safety), duty) for safety, duty in rated if safety is not None]
    if each:
        limits, (safety, duty) = model.profile.limits, min(each, key=lambda pair: pair[0])
        where = f"static rating over the largest load, {duty.peak_force.value:.6g} N"
        yield judged(name, safety, ">=", limits.bearing_static_safety, "1", BEARING,
                     warn=limits.warn_bearing_static_safety, cam_angle=duty.peak_force.cam_angle, where=where,
                     unlimited=True)  # fmt: skip


def _rated(model: Model) -> bool:
    """Whether the roller's bearing has a static rating."""
    roller = model.setup.roller
    return roller is not None and roller.static_rating is not None


@check("torque")
def torque(model: Model) -> Iterable[Finding | NotJudged]:
    """Largest torque that a rigid cam takes from its shaft or gives it."""
    if model.profile.limits.torque_n_m is None:
        return
    if model.shaft is not None:
        yield from _torque("torque", model, model.shaft.peak_torque)
    else:
        yield NotJudged("torque", NO_OPERATION)


@check("bearing")
def bearing(model: Model) -> Iterable[Finding | NotJudged]:
    """Static safety of the rollers' bearings of a rigid follower."""
    if not _rated(model):
        return
    if model.carriers:
        yield from _bearing("bearing", model, model.carriers)
    else:
        yield NotJudged("bearing", NO_OPERATION)


@solved("dynamic-torque", "dynamics")
def dynamic_torque(model: Model) -> Iterable[Finding | NotJudged]:
    """The same with vibration: at the cam, and in its shaft where that is elastic."""
    if model.profile.limits.torque_n_m is None:
        return
    if model.dynamic_torque is not None:
        yield from _torque("dynamic-torque", model, model.dynamic_torque)
    else:
        yield NotJudged("dynamic-torque", LIFTED)


@solved("dynamic-bearing", "dynamics")
def dynamic_bearing(model: Model) -> Iterable[Finding | NotJudged]:
    """The same with vibration."""
    if not _rated(model):
        return
    if model.dynamic_duties:
        yield from _bearing("dynamic-bearing", model, model.dynamic_duties)
    else:
        yield NotJudged("dynamic-bearing", LIFTED)


@solved("impact-torque", "impact")
def impact_torque(model: Model) -> Iterable[Finding]:
    """The same over the turns that [impact] counts, with the friction of the contacts."""
    if model.profile.limits.torque_n_m is not None and model.impact_torque is not None:
        yield from _torque("impact-torque", model, model.impact_torque)


@solved("impact-bearing", "impact")
def impact_bearing(model: Model) -> Iterable[Finding]:
    """The same over the turns that [impact] counts."""
    if _rated(model):
        yield from _bearing("impact-bearing", model, [duty for turn in model.impact_duties for duty in turn])
