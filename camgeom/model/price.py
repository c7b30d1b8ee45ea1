"""What the solvers of a design take together, known before the first of them begins: seconds of one core.

Each has a price, counted from what the profile asks for. All are paid from one purse in one order, whichever is asked
first, so that a profile has the same answers by every way; what the rest of it does not pay is not begun, and says so.
Solvers whose steps are not known before (vibration, its sweep, impacts, machines drawn) share what is left.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from math import log10, sqrt
from typing import TYPE_CHECKING, final

from camgeom.errors import CamgeomError, NotConverged
from camgeom.immutable import immutable
from camgeom.maths.frozen import TWIN

if TYPE_CHECKING:
    from camgeom.mechanics.roller_duty import RollerDuty
    from camgeom.mechanics.turret_duty import TurretDuty
    from camgeom.model import Model
    from camgeom.model.body import Body

SPENT = 50.0
"""s of one core for all that has a price; surfaces and files come beside"""
A_SEARCH = 25.0
"""of the search for best laws that has cost all that it may"""
A_STATE = 0.05
"""of the loads, contacts and lives of a follower in an operating state; they are always begun (measured 0.04 to 0.1)"""
A_TURN = 0.4
"""of an ordinary turn of [impact] with its disturbed one, its pressures and lives (measured 0.35)"""
MOST_TURNS, FEW, DOUBLE = 50, 30, 500
"""turns of [impact] that are held together, of 33 MB each, pieces of the motion that this holds for, and more of them
with which a turn has twice as much"""
AN_END = 1.25
"""of the contact of a roller with stated ends over such a turn"""
ON_HALF_SPACE, TURRETS = 0.9, 5.5
"""of a roller's contact on a half-space over the turn, which one that is tilted has square too, and of a turret's, both
(measured 0.03 to 0.85, and 3 to 5)"""
TILTED, FULL, LIGHTER, LIGHTEST = 1.5, 50.0, 0.35, 6.0
"""times as much of a tilted turret (measured 1.2 to 1.5), and more by a share for every decade of the load per length,
N/mm, below a full one (measured 1.6, 2.3 and 2.6 times two, four and six decades below), so many at most"""
TURRETS_VIBRATE = 14.0
"""of a turret's in its steady state and from rest (measured 9 to 12, and 0.7 GB)"""
A_CROWN = 0.3
"""of that of a crown that is beyond its room under some of them"""
A_RUN, A_DUTY = 0.35, 0.1
"""of [dynamics] beside the steps of its solver, and of the duties of a follower in a state under its forces, with their
lives (measured together 0.3 to 0.6)"""
VIBRATING = {"line": 0.0, "ellipse": 0.3, "finite": ON_HALF_SPACE}
"""more of a roller's, in its steady state and from rest each, by its contact's level, each for a tilt too"""
A_BELOW = 6.0
"""of what the body gives way below the contacts of a follower in an operating state (measured 0.5 to 6)"""
A_WALL, A_ROOT = 10.0, 14.0
"""of a wall over the turn, and of the peak at its round root on both meshes (measured 5 to 10 and 8 to 14)"""
A_FRAME = 17.0
"""of a frame's plate, over the turn and its peak (measured 17)"""
A_STUDIED = 0.1
"""of a turn of [impact] with another clearance or law (measured 0.05)"""
LIMITS = {"vibration": (0.3, 4.0, 16.0), "sweep": (0.25, 4.0, 15.0), "impacts": (0.5, 4.0, 24.0),
          "machines": (0.3, 6.0, 24.0)}  # fmt: skip
"""weights of solvers in what is left, and s that each may take at least and at most beyond its price"""
DRAWINGS = 3
"""of machines: where they rest, where they move, what presses them"""


@final
@immutable(eq=True)
class Price:
    """Of `count` alike; what it is for, and what to leave out where not one of them is paid for."""

    what: str
    count: int
    each: float
    of: str
    without: str
    held: int | None = None
    """of them that memory is spent on"""

    @property
    def seconds(self) -> float:
        """Of one core."""
        return self.count * self.each

    @property
    def too_many(self) -> bool:
        """Whether memory does not bear so many."""
        return self.held is not None and self.count > self.held

    def paid(self, left: float) -> float:
        """What it takes of what is left: nothing where it is not begun."""
        return self.seconds if self.seconds <= left and not self.too_many else 0.0

    def less(self, left: float) -> str:
        """What would do."""
        most = int(left / self.each)
        return f"at most {most} {self.of}, or {self.without}" if most else self.without


def afford(body: Body, name: str, part: int = 0) -> None:
    """Raise NotConverged, with the figures, where the purse of the design does not pay for what is asked for.

    part  of walls the number of the track, with [[duty]] of the follower; of roots that of the follower
    What is left of a model that is gone, a state or a duty, has no design beside it that would pay.
    """
    if not body.bindings:
        return
    paid = dict[str, float]()
    for one, number, price in _prices(body.bindings[0]):
        left = SPENT - sum(paid.values())
        asked = (one, number) == (name, part)
        if asked and price.seconds > left:
            others = ", ".join(f"{seconds:.3g} s of {what}" for what, seconds in paid.items())
            dearest = max(paid, key=lambda what: paid[what])
            or_less = f"; or less of {dearest}" if dearest != LOADS and price.seconds <= left + paid[dearest] else ""
            raise NotConverged(
                f"{price.what} would take about {price.seconds:.3g} s of one core beside {others}, more than the "
                f"{SPENT:g} s that are spent on a design: {price.less(left)}{or_less}"
            )
        if asked and price.too_many:
            raise NotConverged(
                f"{price.what} would take more than the 2 GB that are spent on a design: at most "
                f"{max(price.held or 0, 1)} {price.of}, or {price.without}"
            )
        if asked:
            return
        if begun := price.paid(left):
            paid[one] = paid.get(one, 0.0) + begun


def limit(model: Model, name: str) -> float:
    """s of one core that a solver may take beyond its price, whose steps are not known before: of what is left, in
    common with the others of them that the profile asks for."""
    left = SPENT
    for _, _, price in _prices(_first(model)):
        left -= price.paid(left)
    weight, least, most = LIMITS[name]
    return min(max(left * weight / sum(LIMITS[one][0] for one in {name, *_limited(model)}), least), most)


def a_drawing(model: Model) -> float:
    """s of one core for one drawing of machines for one follower."""
    return limit(model, "machines") / DRAWINGS / max(len(model.bindings), 1)


def _limited(model: Model) -> Iterator[str]:
    """Those that it asks for."""
    profile = _first(model).profile
    spec = profile.dynamics_spec
    if spec is not None:
        yield "vibration"
    if spec is not None and spec.sweep is not None:
        yield "sweep"
    if profile.impact_spec is not None:
        yield "impacts"
    if profile.tolerance_spec is not None:
        yield "machines"


def impact_steps(model: Model) -> int:
    """Steps that the runs of [impact] may take together: those of ordinary turns, and what their share of the rest pays
    for."""
    from camgeom.dynamics.impact.solver import ORDINARY

    return int(ORDINARY * (_impacts(_first(model)).seconds + limit(model, "impacts")) / A_TURN)


def _first(model: Model) -> Model:
    """The first follower's, in no state of its own; a state whose model is gone is one alone."""
    return next(iter(model.bindings), model)


def _each(first: Model) -> list[Model]:
    """The models of all followers in all states, those that have all in common once."""
    every = tuple(first._kin) if first.bindings else (first,)
    return [one for one in every if TWIN not in vars(one)]


def _prices(first: Model) -> Iterator[tuple[str, int, Price]]:
    """All that the design asks for, in the order in which it is paid."""
    for name, priced in PRICES.items():
        price = priced(first)
        if price.count:
            yield name, 0, price
    if first.root_limit is not None:
        yield from _roots(first)
    if (studied := _studied(first)).count:
        yield STUDIES, 0, studied


def _laws(first: Model) -> Price:
    """Those that were sought when the profile was read, where they were dear."""
    programs = [one.setup.program for one in first.bindings or (first,)]
    spent = {best.wish: best.spent for program in programs for _, best in program.best_laws}
    if not spent:
        return Price("best laws", 0, 0.0, "", "")
    from camgeom.motion.optimal.programme import WHOLE

    seconds = A_SEARCH * sum(spent.values()) / WHOLE
    return Price("best laws", int(seconds >= A_STATE), seconds, "", "")


def _loads(first: Model) -> Price:
    count = max(len(first.bindings), 1) * len(first.states)
    return Price("the loads", count, A_STATE, "followers and states", "fewer of [[duty]]")


def _half_space(first: Model) -> Price:
    count, seconds = 0, 0.0
    for one in _each(first):
        with suppress(CamgeomError):  # without a contact there is none on a half-space either
            if (turret := one.turret_duty) is not None:
                if turret.level == "finite":
                    count, seconds = count + 1, seconds + TURRETS * _harder(turret)
            else:
                poses = sum(_poses(duty) for duty in one.duties if duty.level == "finite")
                count, seconds = count + poses, seconds + ON_HALF_SPACE * poses
    what = f"contacts on a half-space, of rollers in operating states whose ends, tilt or crowns ask for it ({count}),"
    return Price(what, count, seconds / max(count, 1), "of them", "fewer of [[duty]]")


def _harder(turret: TurretDuty) -> float:
    """How many times as long as an ordinary one a turret takes."""
    load = turret.torque_line_load
    decades = min(max(log10(FULL / load), 0.0), LIGHTEST) if load > 0.0 else LIGHTEST
    light = 0.0 if turret.preload > 0.0 else LIGHTER * decades
    return (1.0 + light) * (1.0 if turret.squared is None else TILTED)


def _poses(duty: RollerDuty) -> int:
    """How a roller is solved: as it stands, and square where it is tilted."""
    return 1 if duty.squared is None else 2


def _impacts(first: Model) -> Price:
    turns = [spec.turns for run in first.runs if (spec := run.profile.impact_spec) is not None]
    what = f"impacts of {len(turns)} followers and operating states that differ, {max(turns, default=0)} turns each,"
    more = max(0, max((run.profile._pieces for run in first.runs), default=0) - FEW)
    held = int(MOST_TURNS / (1.0 + more / DOUBLE))
    return Price(what, sum(turns), A_TURN, "turns together", "fewer of impact.turns", held)


def _ends(first: Model) -> Price:
    count, seconds = 0, 0.0
    for run in first.alike:
        if (spec := run.profile.impact_spec) is None:
            continue
        with suppress(CamgeomError):  # without a rigid contact there is none under impacts either
            levels = [duty.level for duty in run.duties if duty.level != "line"]
            turns = spec.turns - spec.settle
            count += len(levels) * turns
            seconds += turns * sum(AN_END if level == "finite" else A_CROWN for level in levels)
    what = f"contacts of crowns or stated ends over a turn of [impact] ({count})"
    return Price(what, count, seconds / max(count, 1), "of them", "fewer impact.turns, or more that settle")


def _vibration(first: Model) -> Price:
    runs = sum(run.profile.dynamics_spec is not None for run in first.runs)
    seconds = A_RUN * runs
    for one in _each(first) if runs else ():
        with suppress(CamgeomError):
            if (turret := one.turret_duty) is not None:
                seconds += TURRETS_VIBRATE if turret.level == "finite" else A_DUTY
            else:
                seconds += A_DUTY + 2.0 * sum(VIBRATING[duty.level] * _poses(duty) for duty in one.duties)
    return Price(f"[dynamics] of {runs} followers and operating states that differ", runs, seconds / max(runs, 1),
                 "of them", "leave [dynamics] out")  # fmt: skip


def _below(first: Model) -> Price:
    asked = [run.profile for run in first.runs]
    runs = sum((spec := one.dynamics_spec) is not None and spec.body_compliance for one in asked)
    soft = _steps(first.profile.material.cam.poisson)
    what = f"what the body gives way below its contacts, of {runs} followers and operating states that differ,"
    return Price(what, runs, A_BELOW * (0.2 + 0.8 * soft), "of them", "leave dynamics.body_compliance out")


def _roots(first: Model) -> Iterator[tuple[str, int, Price]]:
    """Of walls over the turn, then of peaks at round roots; of a frame's plate both at once."""
    from camgeom.body.stress import PressedRing

    walls, peaks, soft = dict[int, None](), list[int](), 1.0
    for one in first.bindings:
        with suppress(CamgeomError):  # raised again where it is asked for
            if (found := one.root_stress) is None:
                continue
            soft = _steps(found.body.material.poisson)
            # Followers on one track are solved together, but for their hardest states.
            walls[one.number if first.profile.duty else one.groove] = None
            if not isinstance(found.body, PressedRing):
                yield WALLS, 0, Price("stress in the frame's plate", 1, A_FRAME * (0.2 + 0.8 * soft), "", NO_LIMIT)
                return
            if not found.body.sharp:
                peaks.append(one.number)
    for number in walls:
        yield WALLS, number, Price(f"stress in a wall over the turn ({len(walls)} of them)", 1, A_WALL, "", NO_LIMIT)
    root = A_ROOT * (0.4 + 0.6 * soft)
    for number in peaks:
        yield ROOTS, number, Price(f"the peak of stress at a round root ({len(peaks)} of them)", 1, root, "", NO_LIMIT)


def _steps(poisson: float) -> float:
    """Steps of iterations on a body over those on one of steel: material that hardly gives way to pressure takes more
    of them (measured at 0.48 and 0.499)."""
    return max(1.0, sqrt(0.4 / max(1.0 - 2.0 * poisson, 1e-6)))


def _studied(first: Model) -> Price:
    spec = first.profile.impact_spec
    count = 0 if spec is None else (len(spec.study) + len(spec.laws)) * (spec.turns + 1) * first._differing
    return Price("impact.study and impact.laws", count, A_STUDIED, "turns together", "fewer of them")


LAWS = "best laws"
LOADS, HALF_SPACE, IMPACTS, ENDS = "loads", "contacts on a half-space", "impacts", "contacts of stated ends"
VIBRATION, BELOW = "[dynamics]", "body_compliance"
WALLS, ROOTS, STUDIES = "walls", "roots", "studies of impacts"
NO_LIMIT = "leave the bending_limit out"
PRICES: dict[str, Callable[[Model], Price]] = {
    LAWS: _laws,
    LOADS: _loads,
    HALF_SPACE: _half_space,
    IMPACTS: _impacts,
    ENDS: _ends,
    VIBRATION: _vibration,
    BELOW: _below,
}
"""in the order in which they are paid; then walls, roots and studies"""
