"""The law that is best for a requirement: its wishes as keys, its solver imported when a motion first asks for it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from camgeom.errors import NotConverged, Problem, ProfileError
from camgeom.motion.catalogue import law
from camgeom.motion.law import Claims, Ends, Parameter
from camgeom.motion.optimal.wish import AIMS, Aim, Wish
from camgeom.motion.table import Piece

if TYPE_CHECKING:
    from camgeom.motion.optimal.best import Best

MOST = 1e6
LEAST_JERK = Claims(
    vm=2.0, am=8.0, jm=32.0, vam=128.0 / (3.0 * math.sqrt(24.0)), arms=8.0 / math.sqrt(3.0),
    order_start=2, order_end=2, order_inside=2,
)  # fmt: skip
"""the jerk changes sign at 1/4 and 3/4: no law from rest to rest with a continuous acceleration has less"""


def _limit(what: str) -> Parameter:
    return Parameter(0.0, 0.0, MOST, f"limit of {what}, for unit lift over unit travel; 0 is none")


@law(
    "optimal",
    source="convex programme, B. Demeulenaere et al., J. Mech. Des. 131 (2009) 101004; bound by weak duality",
    claims=LEAST_JERK,
    joins=True,
    stand_in="polynomial",
    data=("minimise",),
    minimise=Parameter("jerk", 0, 0, f"what is least: {', '.join(AIMS)}", "text"),
    velocity_limit=_limit("the peak velocity"),
    acceleration_limit=_limit("the peak acceleration"),
    jerk_limit=_limit("the peak jerk"),
    residual_limit=_limit("the vibration left behind, a share of the lift"),
    monotone=Parameter(False, 0, 0, "whether the motion may never turn back", "switch"),
    band=Parameter((), 0, 0, "[low, high] of rise time / natural period, where the residual counts", "list"),
    natural_frequency=Parameter(0.0, 0.0, 1e6, "Hz, in place of band: the natural frequency; 0 is none"),
    speeds=Parameter((), 0, 0, "[low, high] of the cam speed, r/min, that go with natural_frequency", "list"),
    damping=Parameter(0.0, 0.0, 0.9, "share of critical damping of the vibration"),
    order=Parameter(2, 1, 2, "derivatives taken over at both ends: 1 velocity, 2 and acceleration", "integer"),
)
def optimal(ends: Ends, **keys: object) -> Sequence[Piece]:
    """The best law for a requirement, with a lower bound that no law can beat; see docs/best_laws.md."""
    return [piece.scaled(ends.lift) for piece in best_law(ends, **keys).pieces]


def best_law(ends: Ends, **keys: object) -> Best:
    """The best law that the keys ask for between these ends; ProfileError where they cannot be met, with the proof."""
    from camgeom.motion.optimal.best import Impossible, best

    wish = wish_of(ends, **keys)
    try:
        found = best(wish)
    except NotConverged as why:
        raise ProfileError([Problem("minimise", f"{why}", wish.aim)]) from why
    if isinstance(found, Impossible):
        names = [f"{name}_limit" for name in found.clash if name != found.assumed]
        raise ProfileError([Problem(names[0] if names else "minimise", found.reason)])
    return found


def wish_of(ends: Ends, **keys: object) -> Wish:
    """The requirement, normalised by lift and travel; ProfileError where keys contradict each other or say nothing."""
    given = _Keys(keys)
    if problems := _problems(given, ends):
        raise ProfileError(problems)
    lift, order = ends.lift, given.order
    start, end = ends.start, ends.end
    wish = Wish(
        given.aim,
        velocity=given.limit("velocity"),
        acceleration=given.limit("acceleration"),
        jerk=given.limit("jerk"),
        residual=given.limit("residual"),
        monotone=bool(keys["monotone"]),
        band=given.band(ends),
        damping=given.number("damping"),
        start=(start[0] / lift, start[1] / lift if order >= 2 else None),
        end=(end[0] / lift, end[1] / lift if order >= 2 else None),
        among=ends.best,
    )
    found = []
    limits = (("velocity", wish.velocity), ("acceleration", wish.acceleration))
    for derivative, (name, limit) in enumerate(limits[:order]):
        most = max(abs(start[derivative]), abs(end[derivative])) / abs(lift)
        if most > limit * (1.0 + 1e-12):
            message = f"a neighbour's {name} is beyond it already"
            found.append(Problem(f"{name}_limit", message, limit, f"at least {most:.9g}"))
    if wish.monotone and min(wish.start[0], wish.end[0]) < 0.0:
        found.append(Problem("monotone", "a neighbour moves the other way", True))
    if found:
        raise ProfileError(found)
    return wish


class _Keys:
    """The keys of a segment with their types."""

    def __init__(self, keys: dict[str, object]) -> None:
        self._keys = keys
        self.minimise = str(keys["minimise"])
        self.aim: Aim = self.minimise  # type: ignore[assignment]
        self.order = int(self.number("order"))

    def number(self, key: str) -> float:
        """A number."""
        value = self._keys[key]
        return float(value) if isinstance(value, int | float) else 0.0

    def limit(self, name: str) -> float:
        """A limit, inf where there is none."""
        return self.number(f"{name}_limit") or math.inf

    def pair(self, key: str) -> tuple[float, float] | None:
        """Two rising positive numbers, None where there is none; ProfileError where they are no such pair."""
        value = self._keys[key]
        if not isinstance(value, tuple) or not value:
            return None
        flat = [float(item) for item in value if isinstance(item, int | float)]
        if len(flat) != 2 or len(value) != 2 or not 0.0 < flat[0] <= flat[1] <= MOST:
            raise ProfileError([Problem(key, "is a pair of rising numbers", list(value), "[low, high], both above 0")])
        return flat[0], flat[1]

    def band(self, ends: Ends) -> tuple[float, float] | None:
        """The ratios of rise time to natural period that count."""
        speeds = self.pair("speeds")
        if speeds is None:
            return self.pair("band")
        turns = self.number("natural_frequency") * 60.0 * ends.turn
        return turns / speeds[1], turns / speeds[0]


NARROWEST, WIDEST = 0.05, 60.0


def _problems(keys: _Keys, ends: Ends) -> list[Problem]:
    """Everything that the keys of a segment say wrong together."""
    found: list[Problem] = []
    aim, jerk = keys.minimise, keys.number("jerk_limit")
    if aim not in AIMS:
        return [Problem("minimise", "no such aim", aim, ", ".join(AIMS))]
    if ends.lift == 0.0:
        return [Problem("to", "the best law needs a lift: its limits are shares of it")]
    least = {"peak-acceleration": "acceleration", "jerk": "jerk", "residual": "residual"}.get(aim)
    if least and keys.number(f"{least}_limit"):
        value = keys.number(f"{least}_limit")
        found.append(Problem(f"{least}_limit", f"says nothing beside minimise = {aim!r}", value))
    if keys.order == 2 and not jerk and aim != "jerk":
        message = "is needed where the acceleration is continuous: without it no law is best"
        found.append(Problem("jerk_limit", message, None, "above 0", "or order = 1, where the acceleration may jump"))
    band, frequency, speeds = keys.pair("band"), keys.number("natural_frequency"), keys.pair("speeds")
    wanted = aim == "residual" or keys.number("residual_limit") > 0.0
    if bool(frequency) != (speeds is not None):
        lacking = "speeds" if frequency else "natural_frequency"
        found.append(Problem(lacking, "is missing: natural_frequency and speeds say the band together"))
    elif frequency and band:
        found.append(Problem("band", "natural_frequency and speeds say it already", list(band)))
    elif frequency and ends.turn == 0.0:
        found.append(Problem("natural_frequency", "needs a segment with a length; outside a program give band"))
    elif wanted and not (band or frequency):
        found.append(Problem("band", "is missing: over which rise times is the residual to be small?", None,
                             "[low, high], or natural_frequency and speeds"))
    elif not wanted and (band or frequency):
        found.append(Problem("band" if band else "natural_frequency", "says nothing without residual_limit or "
                             "minimise = 'residual'"))
    elif wanted and (reach := keys.band(ends)) and (reach[0] < NARROWEST or reach[1] > WIDEST):
        found.append(Problem("band" if band else "speeds", "the rise lasts too few or too many natural periods",
                             [float(f"{n:.6g}") for n in reach], f"{NARROWEST:g} to {WIDEST:g}"))
    if keys.number("damping") and not wanted:
        found.append(Problem("damping", "says nothing without a residual", keys.number("damping")))
    if aim == "residual" and keys.order == 1 and not (jerk or keys.number("acceleration_limit")):
        found.append(Problem("jerk_limit", "the least residual needs a limit of jerk or acceleration", None, "above 0"))
    return found
