"""The best shape of a task: a programme on a fixed mesh finds its build, then its breaks move to where they belong."""

from __future__ import annotations

from dataclasses import replace
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.errors import NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.motion.optimal.bound import CELLS, cruises, lower_bound
from camgeom.motion.optimal.excess import ENOUGH, KEPT, LITTLE, excess, kept
from camgeom.motion.optimal.newton import at_rest
from camgeom.motion.optimal.programme import CLOSEST, NO_CUTS, Cuts, Programme, SearchPurse, Solved, stiffness
from camgeom.motion.optimal.shape import Shape, moment_parts, values
from camgeom.motion.optimal.sharpened import finer, ramped, switched
from camgeom.motion.optimal.wish import Task, Wish

SPANS = 64
"""of the mesh that the build is found on"""
EXACT = 1e-10
"""how well the ends are met before a law counts as found"""
SILENT = 1e-6
"""share of the lift up to which a residual is none to seek less than"""
SLOW = 3e-7
"""share of the lift; what a step has to gain of a residual below LITTLE, lest its breaks are left where they are"""
TRIED = (0, 1, 2, 4)
"""programmes after which breaks are tried for rest"""
FINE = 8
"""times as many cells prove what few do not"""
QUIET, QUIETED = 0.9, (0, 2, 5, 9, 14)
"""share of what is no residual below which breaks may do where they stand; programmes after which they are asked"""
ROUNDS = 50
PATIENT = 15
"""rounds from one mesh after which breaks need find no rest where next to no residual is left, and a law is as dear as
one that has cost more than ordinary ones"""
SHARPENED = 2
"""times that a mesh becomes finer before breaks are moved by programmes alone"""
MOST_SPANS = 320
"""of a mesh that shows more and more changes of the jerk no build is made: many laws are as good"""
SHOWN = 1e-4
"""share of the lift; of a residual below that a finer mesh shows no build, and no other is tried for so much less:
nearly as little is left behind by many"""
PASSES = 2
SLIGHT = 1e-8
"""relative; a gain that no further programme is solved for"""
GROWTH = 2.0
"""of how far breaks may move after a step that brought something"""
LATEST = 5
"""programmes for which a tangent stays that is worth nothing"""
STEADY = 1e-5
"""breaks that move less have found their place"""
NEARLY = 2e-5
"""reach at which breaks stand near enough to where they belong for the rest to be found between them as they stand"""
SHARP = 1e-6
"""how far breaks may move in the programme whose multipliers count"""
ROUGH = 1e-2
"""how far the vibration may exceed its limit while only the build is sought"""
CLOSE, NEAR = 3e-5, 3e-6
"""a gap that no further pass is made for; of a residual below LITTLE, share of the lift: other breaks prove no more"""
FAIR, FAINT = 1e-3, 2e-5
"""the same for laws that have cost more than ordinary ones; of any residual, share of the lift"""
ENOUGH_OF_FAINT = 2e-3
"""times LITTLE; how nearly a residual that is sought is cut to its circle where FAINT is near enough"""
ORDINARY = 600_000
"""rows times steps of ordinary laws, see `SearchPurse`; what is dearer is asked at every doubling whether it will do"""

FAR = 1e-3
"""a gap for which meshes are tried that are fine where even ones are not"""


@final
@immutable
class Found:
    """The best shape found for a task, the value it has, and the bound that no law of the class can beat."""

    shape: Shape
    value: float
    bound: float
    solved: Solved


class Sight:
    """The best law and the best bound that the search for a task has seen, whichever of its steps they are from.

    tried   programmes from the mesh that breaks are moved from now
    """

    def __init__(self, task: Task, purse: SearchPurse) -> None:
        self.task, self.purse = task, purse
        self.law: Solved | None = None
        self.proof: Solved | None = None
        self.bound = -np.inf
        self.asked = ORDINARY
        self.tried = 0

    def saw(self, law: Solved, bound: float) -> None:
        """One more law that keeps the limits, and what no law can go below by its multipliers."""
        if self.law is None or law.value < self.law.value:
            self.law = law
        self.proved(law, bound)

    def proved(self, by: Solved, bound: float) -> None:
        """One more number that no law can go below, by the multipliers of what need not keep the limits itself."""
        if self.proof is None or bound > self.bound:
            self.proof, self.bound = by, bound

    @property
    def does(self) -> bool:
        """Whether the law is near enough to its bound for what it has cost."""
        if self.law is None:
            return False
        value = self.law.value
        gap = value - (max(self.bound, 0.0) if self.task.residual.slope else self.bound)
        undecided = self.task.proof and self.bound <= 1.0 < value
        dear = not undecided and (self.purse.spent > ORDINARY or self.tried >= PATIENT)
        fair = max(FAIR * value, FAINT if self.task.residual.slope else 0.0) if dear else 0.0
        return gap <= max(fair, _near(self.task, value))

    @property
    def doubled(self) -> bool:
        """Whether twice as much has been spent as when that was last so."""
        if self.purse.spent < self.asked:
            return False
        self.asked = 2 * self.purse.spent
        return True

    @property
    def found(self) -> Found | None:
        """The law and the bound."""
        if self.law is None or self.proof is None:
            return None
        shape = self.law.shape if self.law.at_rest else merged(self.law.shape, EXACT)
        return Found(shape, self.law.value, self.bound, self.proof)


def find(task: Task, begun: Shape | None = None, purse: SearchPurse | None = None) -> Found | None:
    """The best shape; None where no mesh holds one that keeps the limits. A shape to begin with is the first mesh.

    Raises NotConverged where the purse, one of its own by default, is spent and none was found.
    """
    purse = purse or SearchPurse()
    x = _mesh(task.wish)
    mesh, cuts = Shape(x, np.zeros(len(x) - 1 + task.smooth)) if begun is None else begun, NO_CUTS
    if mesh.smooth != task.smooth:
        mesh = Shape(mesh.x, np.zeros(len(mesh.h) + task.smooth))
    if task.mean:
        return _least_square(task, mesh)
    sight = Sight(task, purse)
    try:
        _look(sight, mesh, cuts)
    except NotConverged:
        if sight.found is None:
            raise
    return sight.found


def _look(sight: Sight, mesh: Shape, cuts: Cuts) -> None:
    """Pass over the task, from one mesh to the next, until what is seen does. Raises NotConverged."""
    task, purse = sight.task, sight.purse
    for turn in range(PASSES):
        solved, cuts = _on_mesh(task, mesh, cuts, purse)
        if solved is None:
            break
        begin = joined(solved.shape)
        settled, cuts = _settled(sight, begin, solved.value, cuts, solved if turn == 0 else None)
        if sight.does:
            break
        if settled is None and turn == 0:
            mesh = refined(solved.shape)
            continue
        if settled is None or (turn > 0 and not settled.at_rest and settled.value >= solved.value):
            # The mesh has a law all the same, or a better one, though with more breaks than it needs.
            on_mesh, cuts = _keeping(task, mesh, cuts, purse)
            laws = [one for one in (on_mesh, settled) if one is not None]
            if not laws:
                break
            settled = min(laws, key=lambda one: one.value)
        _weighed(sight, settled, cuts)
        if sight.does or (task.residual.slope and settled.value <= SILENT):
            break
        mesh = refined(settled.shape)


def _near(task: Task, value: float) -> float:
    """How far from the bound a value may be for no further pass to be made."""
    return NEAR if task.residual.slope and value <= LITTLE else CLOSE * value


def far(task: Task, found: Found) -> bool:
    """Whether the bound is so far below that another mesh may hold a better law."""
    least = SHOWN if task.residual.slope else EXACT
    return found.value > least and found.value - found.bound > max(FAR * found.value, least)


def _bound(task: Task, settled: Solved, cuts: Cuts, purse: SearchPurse) -> float:
    """What no law can go below; where breaks are not at rest the multipliers are those of a sharp programme."""
    shape, proof = settled.shape, settled.multipliers
    if task.residual.slope and settled.value <= SILENT:
        return 0.0  # no residual is below none
    if not settled.at_rest:
        shape = cruising(shape) if task.velocity.asked or task.wish.monotone else shape
        sharp = Programme(task, shape, cuts, settled.value, SHARP).solve(purse)
        if sharp is None:
            return -np.inf
        proof = sharp.multipliers
    bound = lower_bound(task, shape, proof)
    # Where breaks are at rest there are few multipliers, and finer cells cost little.
    if settled.value - bound <= (CLOSE * settled.value if settled.at_rest else _near(task, settled.value)):
        return bound
    return max(bound, lower_bound(task, shape, proof, FINE * CELLS))


def _mesh(wish: Wish) -> Floats:
    """Breaks of the first mesh: even, and finer towards both ends where a limit of the velocity leaves short ramps.

    Even spans that are as long as the longest ramp hold no law.
    """
    even = np.linspace(0.0, 1.0, SPANS + 1)
    if wish.longest_ramp >= 4.0 / SPANS:
        return even
    fine = wish.longest_ramp / 16.0
    steps = fine * 1.3 ** np.maximum(0.0, np.arange(-16.0, np.log(1.0 / (SPANS * fine)) / np.log(1.3)))
    near = np.cumsum(steps)
    inner = even[(even > near[-1] + 0.5 / SPANS) & (even < 1.0 - near[-1] - 0.5 / SPANS)]
    return np.concatenate([[0.0], near, inner, 1.0 - near[::-1], [1.0]])


def _least_square(task: Task, mesh: Shape) -> Found | None:
    """The shape of least mean square: a quadratic programme on a mesh that becomes finer where the jerk changes."""
    from camgeom.motion.optimal.square import least_square

    best, cuts = None, NO_CUTS
    for _ in range(2):
        solved = None
        for _ in range(ROUNDS):
            solved = least_square(Programme(task, mesh, cuts, 0.0, 0.0))
            if solved is None:
                return best
            over, further = excess(task, solved.shape, solved.value)
            if over <= kept(task):
                break
            cuts = cuts.and_at(*further)
        if solved is None:
            return best
        # No mean square is below none.
        bound = lower_bound(task, solved.shape, solved.multipliers) if solved.value > EXACT else 0.0
        if best is None or bound > best.bound:
            best = Found(merged(solved.shape, EXACT), solved.value, bound, solved)
        if best.value <= EXACT or best.value - best.bound <= CLOSE * best.value:
            break
        turns = np.abs(np.diff(solved.shape.jerk))
        sharp = np.flatnonzero(turns > 0.2 * turns.max())
        counts = np.ones(len(mesh.h), dtype=np.intp)
        counts[sharp] = counts[sharp + 1] = 4
        mesh = divided(solved.shape, counts)
    return best


def _keeping(task: Task, mesh: Shape, cuts: Cuts, purse: SearchPurse, exact: float = 0.0) -> tuple[Solved | None, Cuts]:
    """The best shape on fixed breaks that keeps the limits, a residual that is sought to `exact`; None where there is
    none."""
    exact = max(exact if task.residual.slope else 0.0, kept(task))
    solved, cuts = _on_mesh(task, mesh, cuts, purse, exact)
    if solved is None:
        return None, cuts
    over = max(0.0, excess(task, solved.shape, solved.value, exact / KEPT)[0])
    if task.residual.slope:
        solved = replace(solved, value=solved.value + over * max(solved.value, LITTLE))
    return (solved if over <= exact else None), cuts


def _weighed(sight: Sight, settled: Solved, cuts: Cuts) -> None:
    """Add a law to those seen, with its bound."""
    if settled.at_rest:
        return
    fewer = replace(settled, shape=merged(settled.shape))
    sight.saw(settled, lower_bound(sight.task, settled.shape, settled.multipliers, FINE * CELLS))
    if not sight.does:
        sight.saw(settled, _bound(sight.task, fewer, cuts, sight.purse))


def _settled(
    sight: Sight, shape: Shape, value: float, cuts: Cuts, meshed: Solved | None
) -> tuple[Solved | None, Cuts]:
    """The shape whose breaks have moved to where they belong; None where they find no rest, or what was seen on the way
    does.

    meshed  what its mesh has shown, which may be divided where breaks find no rest at once

    Linear programmes one after the other (F. Palacios-Gomez et al., Management Science 28 (1982) 1106): a step counts
    where it brings more than it spoils, else the next one reaches less far.
    """
    task, purse = sight.task, sight.purse
    farthest = reach = min(1.0 / SPANS, task.wish.longest_ramp / 8.0)
    merit, last, stiff, stalled = np.inf, None, None, False
    # Of a residual alone the tangents are many, and its breaks creep.
    sought = task.residual.slope > 0.0 and not task.velocity.asked
    added: list[int] = []
    begun, meshed = meshed, meshed if task.jerk.asked and value > 0.0 else None
    if meshed is not None:
        rest, cuts = _shown(sight, meshed, cuts)
        if rest is not None:
            return rest, cuts
    for turn in range(ROUNDS):
        sight.tried = turn
        if turn >= PATIENT and sight.does:
            return last, cuts
        dear = task.residual.slope > 0.0 and turn > 0 and sight.doubled
        hidden = not task.residual.slope or value > SHOWN
        if meshed is not None and hidden and (dear or turn > TRIED[-1]):
            rest, more = _sharpened(sight, meshed, cuts)
            if rest is not None:
                return rest, more
            meshed = None
        if dear:
            # It may do as it stands, or on a finer mesh.
            if begun is not None:
                sight.proved(begun, lower_bound(task, begun.shape, begun.multipliers, FINE * CELLS))
            fixed, cuts = _keeping(task, joined(shape, 1.01 * CLOSEST), cuts, purse, ENOUGH_OF_FAINT)
            if fixed is not None:
                sight.saw(fixed, -np.inf)
            if value > FAINT and not sight.does:
                rough, cuts = _on_mesh(task, refined(shape), cuts, purse)
                if rough is not None:
                    sight.proved(rough, lower_bound(task, rough.shape, rough.multipliers, FINE * CELLS))
            if value > FAINT and not sight.does:
                fixed, cuts = _keeping(task, refined(shape), cuts, purse, ENOUGH_OF_FAINT)
            if fixed is not None and (value <= FAINT or not sight.does):
                _weighed(sight, fixed, cuts)
            if sight.does:
                return None, cuts
        programme = Programme(task, shape, cuts, value, reach, stiff, stalled)
        trial, stalled = programme.solve(purse), programme.stalled
        if trial is not None and turn in QUIETED and task.residual.slope and trial.value <= QUIET * SILENT:
            # Less is not worth moving a break for: where they stand they may do.
            fixed, more = _keeping(task, joined(trial.shape, 1.01 * CLOSEST), cuts, purse)
            if fixed is not None and fixed.value <= SILENT:
                return fixed, more
        if sought and turn >= PATIENT and value <= SILENT:
            break
        if trial is None:
            break  # the rows are no others where breaks reach less far
        if turn in TRIED:
            build = replace(trial, shape=joined(trial.shape, 1.01 * CLOSEST))
            rest, cuts = _proven(sight, at_rest(task, build), cuts)
            if rest is not None:
                return rest, cuts
        moved = float(np.abs(trial.shape.x - shape.x).max())
        gaps = values(trial.shape, moment_parts(trial.shape.x, shape.smooth)) - task.wish.moments
        missed = float(np.abs(gaps).max())
        over, further = excess(task, trial.shape, trial.value)
        m = trial.multipliers
        weight = 0.0
        if task.residual.asked:
            limit = task.residual.at(trial.value)
            weight = m.cut.sum() * (max(limit, LITTLE) if task.residual.slope else limit)
        weight += (m.above.sum() + m.below.sum()) * (task.velocity.at(trial.value) if task.velocity.asked else 1.0)
        now = trial.value + 2.0 * float(np.abs(m.moments) @ np.abs(gaps)) + 2.0 * weight * max(over, 0.0)
        better = now < merit
        if better and sought:
            cuts = cuts.living(m.cut, sum(added[-LATEST:]))
        cuts, added = cuts.and_at(*further), [*added, len(further[0])]
        # What such a step gains is less than is sought: breaks come to rest.
        little = task.residual.slope > 0.0 and trial.value <= LITTLE
        slow = better and merit - now < (SLOW if little else ENOUGH * trial.value)
        if better:
            shape, value, merit = trial.shape, trial.value, now
            stiff = stiffness(task, shape, m)
        if reach <= NEARLY and better and not (missed <= EXACT and over <= kept(task)):
            # What is left to gain by the breaks is of the second order of that: they stay, and the rest is linear.
            fixed, cuts = _keeping(task, shape, cuts, purse)
            if fixed is not None:
                last = min(fixed, last or fixed, key=lambda one: one.value)
                sight.saw(last, -np.inf)
                break
        if missed <= EXACT and over <= kept(task):
            less = joined(trial.shape, 1.01 * CLOSEST)
            if len(less.x) < len(shape.x):
                shape, value, merit, reach, stiff = less, trial.value, np.inf, 4.0 * CLOSEST, None
                continue
            done = moved <= STEADY or (last is not None and trial.value >= last.value - SLIGHT * abs(last.value))
            last = trial
            sight.saw(last, -np.inf)
            if done or sight.does:
                break
        most = farthest if sought else reach
        reach = min(most, max(GROWTH * moved, 1e-9)) if better and not slow else 0.25 * min(reach, moved)
    return last, cuts


def _proven(sight: Sight, rest: Solved | None, cuts: Cuts) -> tuple[Solved | None, Cuts]:
    """A law at rest, and the cuts with its own; None where its bound is far: it may be at rest in the wrong build."""
    if rest is None:
        return None, cuts
    bound = _bound(sight.task, rest, cuts, sight.purse)
    sight.saw(rest, bound)
    if rest.value - bound > _near(sight.task, rest.value):
        return None, cuts
    own = rest.multipliers.cuts
    return rest, cuts.and_at(own.n, own.angle, own.places, own.dips)


def _sharpened(sight: Sight, meshed: Solved, cuts: Cuts) -> tuple[Solved | None, Cuts]:
    """The law at rest in the build that a mesh shows when it becomes finer where the jerk changes; None without one."""
    for _ in range(SHARPENED):
        mesh = finer(meshed.shape, sight.task.jerk.at(meshed.value))
        solved, cuts = _on_mesh(sight.task, mesh, cuts, sight.purse) if len(mesh.h) <= MOST_SPANS else (None, cuts)
        if solved is None:
            break
        meshed = solved
        sight.proved(meshed, lower_bound(sight.task, meshed.shape, meshed.multipliers))
        rest, cuts = _shown(sight, meshed, cuts)
        if rest is not None:
            return rest, cuts
    return None, cuts


def _shown(sight: Sight, meshed: Solved, cuts: Cuts) -> tuple[Solved | None, Cuts]:
    """The law at rest in the build that a mesh shows; None where it shows none."""
    for build in (switched, ramped):
        built = build(sight.task, meshed.shape, meshed.value)
        rest = None if built is None else at_rest(sight.task, replace(meshed, shape=built), meshed.shape)
        rest, cuts = _proven(sight, rest, cuts)
        if rest is not None:
            return rest, cuts
    return None, cuts


def cruising(shape: Shape) -> Shape:
    """The shape with breaks inside the spans over which the velocity stays as it is."""
    counts = np.ones(len(shape.h), dtype=int)
    for first, last in cruises(shape):
        counts[first:last] = 32
    return divided(shape, counts)


def _on_mesh(
    task: Task, mesh: Shape, cuts: Cuts, purse: SearchPurse, exact: float = ROUGH
) -> tuple[Solved | None, Cuts]:
    """The best shape on fixed breaks, near enough to its limits to show its build."""
    solved = None
    for _ in range(ROUNDS):
        solved = Programme(task, mesh, cuts, 0.0, 0.0).solve(purse)
        if solved is None or solved.value > task.most:
            return None, cuts
        over, further = excess(task, solved.shape, solved.value, 1.0 if exact == ROUGH else exact / KEPT)
        if over <= exact:
            break
        cuts = cuts.and_at(*further)
    return solved, cuts


def joined(shape: Shape, closest: float | None = None) -> Shape:
    """The shape without breaks at which nothing changes, and with one break for two that close in on a passing span:
    one as short as `closest`, or a single span of the mesh, in which the break is that belongs there."""
    mesh, shape = shape.x, merged(shape)
    x, a, rate = shape.x, shape.a, shape.jerk if shape.smooth else shape.a
    short = np.diff(np.searchsorted(mesh, x)) == 1 if closest is None else shape.h <= closest
    passing = np.zeros(len(shape.h), dtype=bool)
    passing[1:-1] = short[1:-1] & ((rate[1:-1] - rate[:-2]) * (rate[2:] - rate[1:-1]) > 0.0)
    kept_x, kept_a = [x[0]], [a[0]]
    k = 1
    while k < len(x) - 1:
        if passing[k]:
            # The neighbours' lines meet between the two breaks, or their levels share out the span.
            share = (rate[k] - rate[k + 1]) / (rate[k - 1] - rate[k + 1])
            u = share * (x[k + 1] - x[k])
            kept_x.append(x[k] + u)
            kept_a.append(a[k] + rate[k - 1] * u if shape.smooth else a[k + 1])
            k += 2
        else:
            kept_x.append(x[k])
            kept_a.append(a[k])
            k += 1
    last = [a[-1]] if shape.smooth else []
    return Shape(np.array([*kept_x, x[-1]]), np.array([*kept_a, *last]))


def refined(shape: Shape) -> Shape:
    """The shape on a finer mesh with its own breaks in it."""
    return divided(shape, np.maximum(1, np.ceil(shape.h * 1.5 * SPANS)).astype(int))


def graded(shape: Shape, finest: float) -> Shape:
    """A mesh (levels of none) whose spans are finest beside the breaks of a shape and grow by half from there on."""
    coarsest = 1.0 / (1.5 * SPANS)
    off = np.append(0.0, np.cumsum(finest * 1.5 ** np.arange(np.log(coarsest / finest) / np.log(1.5))))
    near = merged(shape).x[:, None] + np.concatenate([-off, off])
    x = [0.0]
    for at in distinct(np.concatenate([np.arange(0.0, 1.0, coarsest), near.ravel()])).tolist():
        if at - x[-1] >= 0.6 * finest and 1.0 - at >= 0.6 * finest:
            x.append(at)
    return Shape(np.array([*x, 1.0]), np.zeros(len(x) + 1))


def divided(shape: Shape, counts: npt.NDArray[np.int_]) -> Shape:
    """The same shape with each span divided into as many."""
    x = np.concatenate(
        [*(np.linspace(a, b, n, endpoint=False) for a, b, n in zip(shape.x[:-1], shape.x[1:], counts)), [1.0]]
    )
    return Shape(x, np.interp(x, shape.x, shape.a) if shape.smooth else np.repeat(shape.a, counts))


def merged(shape: Shape, nothing: float = 1e-7) -> Shape:
    """The shape without the breaks at which nothing changes, or less than a share of the largest."""
    step = np.diff(shape.jerk if shape.smooth else shape.a)
    size = np.abs(shape.jerk if shape.smooth else shape.a).max()
    kept = np.concatenate([[True], np.abs(step) > nothing * size, [True]])
    return Shape(shape.x[kept], shape.a[kept] if shape.smooth else shape.a[kept[:-1]])
