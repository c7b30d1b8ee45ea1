"""The rollers as bearings: static safety, bending of the outer ring, least load, speed, lubrication.

Rigid, and of the loads also with vibration, from rest and with impacts. Their rated life is judged with the lives of
the surfaces (`life`).
"""

from __future__ import annotations

from collections.abc import Iterable
from math import pi
from typing import TYPE_CHECKING

from camgeom.checks import LIFTED, NO_OPERATION, check, solved
from camgeom.checks.verdict import Finding, NotJudged, judged
from camgeom.mechanics.rating import LEAST_LOAD_SHARE, LEAST_RATIO

if TYPE_CHECKING:
    from camgeom.mechanics.duty import Duty
    from camgeom.model import Model

BEARING = "a roller with a higher static rating, less mass, force or speed, or a smoother law"
RING = "a roller with a thicker outer ring (a higher max_radial_load), less mass, force or speed"
RPM = 30.0 / pi


def _loads(name: str, model: Model, duties: Iterable[Duty]) -> Iterable[Finding]:
    """The least static safety of all rated rollers, and the largest load against what bends the outer ring."""
    rated = [(duty.bearing.static_safety, duty) for duty in duties if duty.bearing is not None]
    each = [(float(safety), duty) for safety, duty in rated if safety is not None]
    if each:
        limits, (safety, duty) = model.profile.limits, min(each, key=lambda pair: pair[0])
        where = f"static rating over the largest load, {duty.peak_force.value:.6g} N"
        yield judged(name, safety, ">=", limits.bearing_static_safety, "1", BEARING,
                     warn=limits.warn_bearing_static_safety, cam_angle=duty.peak_force.cam_angle, where=where,
                     unlimited=True)  # fmt: skip
    roller = model.setup.roller
    if rated and roller is not None and roller.max_radial_load is not None:
        peak = max((duty.peak_force for _, duty in rated), key=lambda one: one.value)
        yield judged(name, peak.value, "<=", roller.max_radial_load, "N", RING, cam_angle=peak.cam_angle,
                     where="largest load, against the bending of the outer ring")  # fmt: skip


@check("bearing", "operation", "rated")
def bearing(model: Model) -> Iterable[Finding | NotJudged]:
    """Static safety of the rollers' bearings, and the bending of their rings, of a rigid follower."""
    if not model.carriers:
        yield NotJudged("bearing", NO_OPERATION)
        return
    yield from _loads("bearing", model, model.carriers)
    if model.setup.roller is not None and model.setup.roller.max_radial_load is None:
        load = max(duty.peak_force.value for duty in model.carriers)
        yield NotJudged("bearing", f"give roller.max_radial_load, what its outer ring bears bent: {load:.4g} N act")


@check("bearing-least-load", "operation", "rated")
def least_load(model: Model) -> Iterable[Finding]:
    """The mean load of the bearing against what a track roller needs so that its rollers roll; a warning at most."""
    roller = model.setup.roller
    each = [duty.bearing for duty in model.carriers if duty.bearing is not None]
    if roller is None or roller.static_rating is None or not each:
        return
    mean = min(float(one.mean_load) for one in each)
    yield judged("bearing-least-load", mean, ">=", LEAST_LOAD_SHARE * roller.static_rating, "N",
                 "below 0.0167 C0 the bearing slides instead of rolling: a smaller bearing, or more preload",
                 where="equivalent load of a turn", worst="warn")  # fmt: skip


@check("bearing-speed", "operation", "rated")
def speed(model: Model) -> Iterable[Finding | NotJudged]:
    """Mean speed of the roller against its bearing's limit; a warning where the largest of the turn is beyond it."""
    roller = model.setup.roller
    each = [duty.bearing for duty in model.carriers if duty.bearing is not None]
    if roller is None or not each:
        return
    advice = "a larger roller turns slower; or less cam speed, or oil instead of grease"
    mean = RPM * max(float(one.speed) for one in each)
    peak = RPM * max(float(one.peak_speed) for one in each if one.peak_speed is not None)
    if roller.limiting_speed is None:
        yield NotJudged("bearing-speed", f"give roller.limiting_speed: it turns at {mean:.4g} r/min on the mean of the "
                        f"turn, at {peak:.4g} r/min at most")  # fmt: skip
    elif mean <= roller.limiting_speed < peak:
        yield judged("bearing-speed", peak, "<=", roller.limiting_speed, "r/min", advice, worst="warn",
                     where=f"largest of the turn; mean {mean:.6g} r/min")  # fmt: skip
    else:
        yield judged("bearing-speed", mean, "<=", roller.limiting_speed, "r/min", advice,
                     where=f"mean of the turn; largest {peak:.6g} r/min")  # fmt: skip


@check("bearing-lubrication", "operation", "rated")
def lubrication(model: Model) -> Iterable[Finding | NotJudged]:
    """Viscosity ratio kappa of the bearing: below 0.1 ISO 281 gives no life, below 1 the film does not part all."""
    from camgeom.model.loads import missing_for_bearing

    each = [duty.bearing for duty in model.carriers if duty.bearing is not None]
    if not each:
        return
    missing = missing_for_bearing(model.profile)
    if missing:
        lives = ", ".join(f"{one.judged_h:.4g} h" for one in each)
        yield NotJudged("bearing-lubrication", f"give {', '.join(missing)}: the bearing's life of {lives} counts as "
                        "well lubricated and clean (a_ISO = 1)")  # fmt: skip
        return
    worst = min((one for one in each if one.ratio is not None), key=lambda one: float(one.ratio or 0.0), default=None)
    if worst is None or worst.ratio is None or worst.factor is None:
        return
    yield judged("bearing-lubrication", float(worst.ratio), ">=", LEAST_RATIO, "1",
                 "a thicker oil, a lower temperature, or more speed; below 1 take one with additives", warn=1.0,
                 where=f"viscosity ratio kappa, a_ISO = {float(worst.factor):.4g}")  # fmt: skip


@solved("dynamic-bearing", "dynamics", "rated")
def dynamic_bearing(model: Model) -> Iterable[Finding | NotJudged]:
    """The loads with vibration."""
    if model.dynamic_duties:
        yield from _loads("dynamic-bearing", model, model.dynamic_duties)
    else:
        yield NotJudged("dynamic-bearing", LIFTED)


@solved("start-bearing", "dynamics", "rated", turn="start")
def start_bearing(model: Model) -> Iterable[Finding]:
    """The loads in the first turn from rest."""
    yield from _loads("start-bearing", model, model.start_duties)


@solved("impact-bearing", "impact", "rated")
def impact_bearing(model: Model) -> Iterable[Finding]:
    """The loads over the turns that [impact] counts."""
    yield from _loads("impact-bearing", model, [duty for turn in model.impact_duties for duty in turn])
