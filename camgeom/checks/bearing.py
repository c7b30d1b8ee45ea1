"""The rollers as bearings: static safety, bending of the outer ring, least load, speed, lubrication.

Rigid, and of the loads also with vibration, from rest and with impacts. Their rated life is judged with the lives of
the surfaces (`life`).
"""

from __future__ import annotations

from collections.abc import Iterable
from math import pi
from typing import TYPE_CHECKING, NamedTuple

from camgeom.checks import LIFTED, NO_OPERATION, check, solved
from camgeom.checks.verdict import Finding, NotJudged, judged, life_told
from camgeom.mechanics.rating import LEAST_LOAD_SHARE, LEAST_RATIO

if TYPE_CHECKING:
    from camgeom.mechanics.bearing import BearingLife
    from camgeom.mechanics.duty import Duty
    from camgeom.mechanics.rating import Rating
    from camgeom.model import Model

BEARING = "a roller with a higher static rating, less mass, force or speed, or a smoother law"
RING = "a roller with a thicker outer ring (a higher max_radial_load), less mass, force or speed"
RPM = 30.0 / pi


class Rated(NamedTuple):
    """A rated roller under load: what is known of its bearing, and how that lasts."""

    rating: Rating
    bearing: BearingLife
    duty: Duty

    @property
    def named(self) -> str:
        """The roller, where a cam has several of different rating."""
        return "" if self.rating.table == "roller" else f", {self.rating.table.replace('_', ' ')}"


def _rated(duties: Iterable[Duty]) -> list[Rated]:
    """Those of some duties whose roller is rated."""
    each = ((duty.rating, duty.bearing, duty) for duty in duties)
    return [Rated(rating, bearing, duty) for rating, bearing, duty in each if rating and bearing is not None]


def _loads(name: str, model: Model, duties: Iterable[Duty]) -> Iterable[Finding]:
    """The least static safety of all rated rollers, and the largest load against what bends the outer ring."""
    rated = _rated(duties)
    each = [(float(one.bearing.static_safety), one) for one in rated if one.bearing.static_safety is not None]
    if each:
        limits, (safety, one) = model.profile.limits, min(each, key=lambda pair: pair[0])
        duty, where = one.duty, f"static rating over the largest load, {one.duty.peak_force.value:.6g} N{one.named}"
        yield judged(name, safety, ">=", limits.bearing_static_safety, "1", BEARING,
                     warn=limits.warn_bearing_static_safety, cam_angle=duty.peak_force.cam_angle, where=where,
                     unlimited=True)  # fmt: skip
    bent = [(one.rating.bent, one.duty.peak_force, one) for one in rated if one.rating.bent is not None]
    if bent:
        most, peak, one = max(bent, key=lambda found: found[1].value / found[0])
        yield judged(name, peak.value, "<=", most, "N", RING, cam_angle=peak.cam_angle,
                     where=f"largest load, against the bending of the outer ring{one.named}")  # fmt: skip


@check("bearing", "operation", "any rated")
def bearing(model: Model) -> Iterable[Finding | NotJudged]:
    """Static safety of the rollers' bearings, and the bending of their rings, of a rigid follower."""
    if not model.carriers:
        yield NotJudged("bearing", NO_OPERATION)
        return
    yield from _loads("bearing", model, model.carriers)
    rated = _rated(model.carriers)
    loads: dict[str, float] = {}
    for one in rated:
        loads[one.rating.table] = max(loads.get(one.rating.table, 0.0), one.duty.peak_force.value)
    bent = {one.rating.table for one in rated if one.rating.bent is not None}
    for table, load in loads.items():
        if table not in bent:
            why = f"give {table}.max_radial_load, what its outer ring bears bent: {load:.4g} N act"
            yield NotJudged("bearing", why)
    for table, roller in model.profile.rollers.items():
        if table in loads and roller.steepest:
            # A bearing that takes thrust has factors of its own for it, which no key states.
            thrust = f"up to {roller.steepest * loads[table]:.4g} N along its axis"
            yield NotJudged("bearing-thrust", f"{table}: a {roller.shape} is pressed by {thrust}, and its bearing is "
                            "rated as if all of the load were radial: see that it takes that thrust")  # fmt: skip
        if roller.dynamic_rating is None:
            yield NotJudged("bearing", f"give {table}.dynamic_rating: of the rollers this one's bearing is not rated")


@check("bearing-least-load", "operation", "rated")
def least_load(model: Model) -> Iterable[Finding]:
    """The mean load of the bearing against what a track roller needs so that its rollers roll; a warning at most."""
    each = [(one.rating.basic, float(one.bearing.mean_load), one) for one in _rated(model.carriers) if one.rating.basic]
    if not each:
        return
    basic, mean, one = min(each, key=lambda found: found[1] / found[0])
    yield judged("bearing-least-load", mean, ">=", LEAST_LOAD_SHARE * basic, "N",
                 "below 0.0167 C0 the bearing slides instead of rolling: a smaller bearing, or more preload",
                 where=f"equivalent load of a turn{one.named}", worst="warn")  # fmt: skip


@check("bearing-speed", "operation", "rated")
def speed(model: Model) -> Iterable[Finding | NotJudged]:
    """Mean speed of the roller against its bearing's limit; a warning where the largest of the turn is beyond it."""
    advice = "a larger roller turns slower; or less cam speed, or oil instead of grease"
    rated = _rated(model.carriers)
    for table in dict.fromkeys(one.rating.table for one in rated):
        each = [one for one in rated if one.rating.table == table]
        fastest, named = each[0].rating.fastest, each[0].named
        mean = RPM * max(float(one.bearing.speed) for one in each)
        peak = RPM * max(float(one.bearing.peak_speed) for one in each if one.bearing.peak_speed is not None)
        if fastest is None:
            yield NotJudged("bearing-speed", f"give {table}.limiting_speed: it turns at {mean:.4g} r/min on the mean "
                            f"of the turn, at {peak:.4g} r/min at most")  # fmt: skip
        elif mean <= fastest < peak:
            yield judged("bearing-speed", peak, "<=", fastest, "r/min", advice, worst="warn",
                         where=f"largest of the turn; mean {mean:.6g} r/min{named}")  # fmt: skip
        else:
            yield judged("bearing-speed", mean, "<=", fastest, "r/min", advice,
                         where=f"mean of the turn; largest {peak:.6g} r/min{named}")  # fmt: skip


@check("bearing-lubrication", "operation", "rated")
def lubrication(model: Model) -> Iterable[Finding | NotJudged]:
    """Viscosity ratio kappa of the bearing: below 0.1 ISO 281 gives no life, below 1 the film does not part all."""
    rated = _rated(model.carriers)
    for missing in dict.fromkeys(one.rating.missing for one in rated if one.rating.missing):
        lives = ", ".join(life_told(one.bearing.judged_h) for one in rated if one.rating.missing == missing)
        yield NotJudged("bearing-lubrication", f"give {', '.join(missing)}: the bearing's life, {lives}, counts as "
                        "well lubricated and clean (a_ISO = 1)")  # fmt: skip
    each = [(float(one.bearing.ratio), one) for one in rated if one.bearing.ratio is not None]
    if not each:
        return
    ratio, worst = min(each, key=lambda pair: pair[0])
    factor = f"{float(worst.bearing.factor):.4g}" if worst.bearing.factor is not None else "unknown"
    yield judged("bearing-lubrication", ratio, ">=", LEAST_RATIO, "1",
                 "a thicker oil, a lower temperature, or more speed; below 1 take one with additives", warn=1.0,
                 where=f"viscosity ratio kappa, a_ISO = {factor}{worst.named}")  # fmt: skip


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
