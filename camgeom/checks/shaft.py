"""Torque of both shafts and static safety of the rollers' bearings: rigid, with vibration, with impacts."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from camgeom.checks import LIFTED, NO_OPERATION, check, refuse_coarse, solved
from camgeom.checks.verdict import Finding, NotJudged, judged

if TYPE_CHECKING:
    from camgeom.maths.extremum import Extreme
    from camgeom.mechanics.duty import Duty
    from camgeom.model import Model

TORQUE = "less mass, force or speed, more angle for the motion, a smoother law, or a stronger drive"
OUTPUT = "less inertia, torque or speed, a smoother law, more damping, or a stronger shaft"
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


@check("torque", "operation")
def torque(model: Model) -> Iterable[Finding | NotJudged]:
    """Largest torque that a rigid cam takes from its shaft or gives it."""
    if model.profile.limits.torque_n_m is None:
        return
    if model.shaft is not None:
        yield from _torque("torque", model, model.shaft.peak_torque)
    else:
        yield NotJudged("torque", NO_OPERATION)


@check("bearing", "operation")
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
    """The same with vibration: at the cam, and in its shaft where that is elastic; without a limit it is told."""
    peak = model.dynamic_torque
    if model.profile.limits.torque_n_m is None:
        shown = "" if peak is None else f": it takes {1e-3 * peak.value:.4g} N m with vibration, {peak.where}"
        if shown and model.start_torque is not None:
            shown += f", {1e-3 * model.start_torque.value:.4g} N m starting from rest"
        yield NotJudged("dynamic-torque", f"give limits.torque_n_m, what the camshaft may carry{shown}")
    elif peak is not None:
        yield from _torque("dynamic-torque", model, peak)
    else:
        yield NotJudged("dynamic-torque", LIFTED)


@solved("output-torque", "turret load")
def output_torque(model: Model) -> Iterable[Finding | NotJudged]:
    """Largest torque of a turret's output shaft, where the profile has a limit; what [dynamics] finds is told too."""
    limit, solves = model.profile.limits.output_torque_n_m, model.profile.dynamics_spec is not None
    if limit is None and not solves:
        return
    if solves:
        refuse_coarse(model)
    peak = model.output_torque
    assert peak is not None, "there is a turret, and a load"
    if limit is not None:
        yield judged("output-torque", 1e-3 * peak.value, "<=", limit, "N m", OUTPUT, cam_angle=peak.cam_angle,
                     where=peak.where)  # fmt: skip
    else:
        yield NotJudged("output-torque", "give limits.output_torque_n_m, what the output shaft may carry: it takes "
                        f"{1e-3 * peak.value:.4g} N m {peak.where}")  # fmt: skip


@solved("dynamic-bearing", "dynamics")
def dynamic_bearing(model: Model) -> Iterable[Finding | NotJudged]:
    """The same with vibration."""
    if not _rated(model):
        return
    if model.dynamic_duties:
        yield from _bearing("dynamic-bearing", model, model.dynamic_duties)
    else:
        yield NotJudged("dynamic-bearing", LIFTED)


@solved("start-torque", "dynamics", turn="start")
def start_torque(model: Model) -> Iterable[Finding]:
    """Largest torque of the camshaft in the first turn from rest, where the profile has a limit."""
    if model.profile.limits.torque_n_m is not None and model.start_torque is not None:
        yield from _torque("start-torque", model, model.start_torque)


@solved("start-bearing", "dynamics", turn="start")
def start_bearing(model: Model) -> Iterable[Finding]:
    """Static safety of the rollers' bearings in the first turn from rest."""
    if _rated(model):
        yield from _bearing("start-bearing", model, model.start_duties)


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
