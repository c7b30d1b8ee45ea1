"""The front: of all variants of a profile within ranges of some keys, those that no other beats in every aim.

An evolutionary search (NSGA-II of pymoo) on figures of the batch, or of the exact model where the batch carries the
case not; then the exact model with all its checks on every member. What it finds wrong sends the search's own archive
forward again, so that nothing is shown that does not pass.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol, final

import numpy as np
from numpy.typing import NDArray

from camgeom.design.engine import Engine
from camgeom.design.requirement import UNBOUNDED, Bound, Requirement
from camgeom.design.study import Data, Figures, Measure, Row, Value
from camgeom.errors import CamgeomError
from camgeom.immutable import immutable
from camgeom.maths import Floats

if TYPE_CHECKING:
    from camgeom.model import Model
    from camgeom.profile import Profile

Bools = NDArray[np.bool_]
Ints = NDArray[np.intp]
SEED = 1
"""of the search, which so gives the same front every time"""


class Evaluator(Protocol):
    """Figures (n,) of points by name, and which of the points can exist."""

    def __call__(self, points: Sequence[tuple[Value, ...]]) -> tuple[Mapping[str, Floats], Bools]: ...


@final
@immutable(eq=True)
class ByBatch:
    """All points at once."""

    profile: Profile
    requirement: Requirement

    def __call__(self, points: Sequence[tuple[Value, ...]]) -> tuple[Mapping[str, Floats], Bools]:
        from camgeom.design.batch import evaluate

        keys = [one.key for one in self.requirement.axes]
        columns = {key: np.array(values, dtype=np.float64) for key, values in zip(keys, zip(*points))}
        found = evaluate(self.profile, columns, self.requirement.figures)
        return found.figures, found.reason == 0


@final
@immutable(eq=True)
class ByModel:
    """One exact model a point, by an engine."""

    requirement: Requirement
    measure: Measure
    engine: Engine

    def __call__(self, points: Sequence[tuple[Value, ...]]) -> tuple[Mapping[str, Floats], Bools]:
        rows = list(self.requirement.study(points, self.measure).rows(self.engine))
        return figures_of(rows, self.requirement.figures)


def figures_of(rows: Sequence[Row], names: Sequence[str]) -> tuple[dict[str, Floats], Bools]:
    """Figures of rows by name, endless ones as infinite, and which rows have them; 0 where one has none."""
    exist = np.array([all(name in row.figures for name in names) for row in rows], dtype=bool)
    found = {}
    for name in names:
        values = [row.figures.get(name, 0.0) for row in rows]
        found[name] = np.array([math.inf if value is None else float(value) for value in values])
    return found, exist


@final
@immutable
class Archive:
    """Every point that a search looked at and that exists: shares of the ranges (n, k), and figures (n,) by name.

    evaluated  how many it looked at
    """

    requirement: Requirement
    evaluated: int
    shares: Floats
    figures: Mapping[str, Floats]

    def front(self, room: Floats | float = 0.0, allowed: Bools | None = None) -> Ints:
        """Numbers of the points that keep every bound with some room (bounds,) and that no other such point beats."""
        keep = np.all(self.requirement.excess(self.figures) <= -np.asarray(room), axis=1)
        at = np.flatnonzero(keep if allowed is None else keep & allowed)
        return at[undominated(self.requirement.scores(self.figures)[at])]


def undominated(scores: Floats) -> Bools:
    """Which of the points (n, aims), smaller is better, no other beats; of equal ones the first."""
    if not len(scores):
        return np.zeros(0, dtype=bool)
    if scores.shape[1] == 1:
        return np.asarray(np.arange(len(scores)) == np.argmin(scores[:, 0]))
    from moocore import is_nondominated

    return np.asarray(is_nondominated(scores, keep_weakly=False), dtype=bool)


def search(
    requirement: Requirement, evaluate: Evaluator, population: int, generations: int, said: Callable[[int], None]
) -> Archive:
    """All that NSGA-II has looked at in so many generations, begun from Sobol points; `said` hears of each."""
    from scipy.stats.qmc import Sobol

    pymoo = _pymoo()
    k = len(requirement.free)
    first = Sobol(k, seed=SEED).random_base2(math.ceil(math.log2(population)))[:population]
    problem = pymoo.Problem(n_var=k, n_obj=len(requirement.aims), n_ieq_constr=len(requirement.bounds) + 1,
                            xl=np.zeros(k), xu=np.ones(k))  # fmt: skip
    algorithm = pymoo.NSGA2(pop_size=population, sampling=first)
    algorithm.setup(problem, termination=("n_gen", generations), seed=SEED, verbose=False)
    evaluated, kept = 0, list[tuple[Floats, Mapping[str, Floats]]]()
    while algorithm.has_next():
        asked = algorithm.ask()
        shares = np.asarray(asked.get("X"), dtype=np.float64)
        figures, exist = evaluate(requirement.points(shares))
        evaluated += len(shares)
        kept.append((shares[exist], {name: figures[name][exist] for name in requirement.figures}))
        there = np.where(exist, -1.0, 1.0)[:, None]
        beyond = np.where(exist[:, None], requirement.excess(figures), 1.0)
        scores = np.where(exist[:, None], requirement.scores(figures), UNBOUNDED)
        given = pymoo.StaticProblem(problem, F=scores, G=np.concatenate([there, beyond], axis=1))
        pymoo.Evaluator().eval(given, asked)
        algorithm.tell(infills=asked)
        said(evaluated)
    figures = {name: np.concatenate([part[name] for _, part in kept]) for name in requirement.figures}
    return Archive(requirement, evaluated, np.concatenate([shares for shares, _ in kept]), figures)


class _Pymoo:
    """What is used of the library."""

    def __init__(self) -> None:
        from pymoo.algorithms.moo.nsga2 import NSGA2
        from pymoo.core.evaluator import Evaluator
        from pymoo.core.problem import Problem
        from pymoo.problems.static import StaticProblem

        self.NSGA2, self.Evaluator, self.Problem, self.StaticProblem = NSGA2, Evaluator, Problem, StaticProblem


def _pymoo() -> Any:
    try:
        return _Pymoo()
    except ImportError:
        raise CamgeomError("optimise needs pymoo: pip install 'camgeom[optimise]'") from None


@final
@immutable
class Front:
    """The members that pass, and what it took to find them.

    members  rows of the exact model, with all checks, in order of the first aim
    judged   exact models that were judged; refused: how many of them failed, by reason
    """

    members: tuple[Row, ...]
    judged: int
    refused: Counter[str]


PASSING = ("pass", "warn")
ROUNDS = 6
"""at most so many times an archive is asked for other members where the exact model refused some"""
MOST_JUDGED = 3
"""exact models for each member that is wanted, of one archive"""


def judged(archive: Archive, measure: Measure, engine: Engine, count: int, said: Callable[[int], None]) -> list[Row]:
    """Rows of the exact model of up to `count` well spread members of an archive's front, and of those that failed.

    Where members fail, others are taken: with more room to a bound that the exact figures pass where the search's do
    not (they differ by their errors), and away from points that fail for what the search does not know of.
    """
    requirement = archive.requirement
    known: dict[int, Row] = {}
    room = np.zeros(len(requirement.bounds))
    away = np.zeros(len(archive.shares), dtype=bool)
    for _ in range(ROUNDS):
        front = archive.front(room, ~away)
        if not len(front):
            front = _scattered(archive, known, count)
        good = [i for i, row in known.items() if row.verdict in PASSING]
        chosen = [i for i in spread(requirement.scores(archive.figures), front, count, good) if i not in known]
        if not chosen or len(known) > MOST_JUDGED * count:
            break
        points = requirement.points(archive.shares[chosen])
        for i, row in zip(chosen, requirement.study(points, measure).rows(engine)):
            known[i] = row
            said(len(known))
        room = _room(archive, known)
        away = _away(archive, known)
    return list(known.values())


def front_of(requirement: Requirement, rows: Sequence[Row], count: int) -> Front:
    """The rows that pass, keep every bound and are not beaten by another such row, at most `count` of them."""
    passing = [row for row in rows if row.verdict in PASSING]
    figures, _ = figures_of(passing, requirement.figures)
    keep = np.all(requirement.excess(figures) <= 0.0, axis=1) if passing else np.zeros(0, dtype=bool)
    kept = [row for row, good in zip(passing, keep) if good]
    scores = requirement.scores(figures)[keep] if kept else np.zeros((0, 1))
    best = [kept[i] for i in spread(scores, np.flatnonzero(undominated(scores)), count)]
    first = requirement.aims[0]
    best.sort(key=lambda row: first.sign * float(row.figures[first.figure] or 0.0))
    reasons = (word for row in rows if row.verdict not in PASSING for word in row.reason.split("; "))
    return Front(tuple(best), len(rows), Counter(reasons))


@final
@immutable
class Foretelling:
    """An evaluator that foretells beside its figures what checks of the exact model will find.

    checks  by figure (`checks.wall`), what interpolates the findings of rows that were judged
    """

    evaluate: Evaluator
    requirement: Requirement
    checks: Mapping[str, Callable[[Floats], Floats]]

    def __call__(self, points: Sequence[tuple[Value, ...]]) -> tuple[Mapping[str, Floats], Bools]:
        figures, exist = self.evaluate(points)
        at = self.requirement.placed(points)
        return {**figures, **{name: np.asarray(foretold(at)) for name, foretold in self.checks.items()}}, exist


def learnt(
    requirement: Requirement, rows: Sequence[Row], findings: Sequence[Mapping[str, Any]]
) -> tuple[tuple[Bound, ...], dict[str, Callable[[Floats], Floats]]]:
    """Bounds for checks that refused rows for what the search does not know of, and what foretells their findings.

    findings  of the profile itself, for the limits; a check without a number in every row is left to the judging
    """
    from scipy.interpolate import RBFInterpolator

    told = list({row.values: row for row in rows if "not_judged" in row.figures}.values())
    refused = {word for row in told if row.verdict not in PASSING for word in row.reason.split("; ")}
    bounds: dict[str, Bound] = {}
    checks: dict[str, Callable[[Floats], Floats]] = {}
    if len(told) < 3 or not requirement.placed([told[0].values]).size:
        return (), {}
    at = requirement.placed([row.values for row in told])
    for finding in findings:
        check, sign = finding["check"], {"<": 1.0, ">": -1.0}.get(str(finding["comparison"])[:1])
        if check not in refused or sign is None or finding["limit"] is None:
            continue
        for name in dict.fromkeys(key for row in told for key in row.figures if _of(key, check)):
            values = [row.figures.get(name) for row in told]
            if name in requirement.figures or not all(isinstance(value, int | float) for value in values):
                continue
            bounds[name] = Bound(name, sign, finding["limit"], f"check {check}, foretold", own=True)
            checks[name] = RBFInterpolator(at, np.array(values, dtype=np.float64), kernel="linear", degree=0)
    return tuple(bounds.values()), checks


def _of(figure: str, check: str) -> bool:
    """Whether a figure is a finding of a check: `checks.wall`, `checks.wall profile to bore`."""
    return figure == f"checks.{check}" or figure.startswith(f"checks.{check} ")


def _room(archive: Archive, known: Mapping[int, Row]) -> Floats:
    """The room, as a share of each bound, by which the search's figures were too kind to points that were judged."""
    requirement, at = archive.requirement, [i for i, row in known.items() if row.verdict in ("pass", "warn", "fail")]
    rows = [known[i] for i in at]
    exact, exist = figures_of(rows, requirement.figures)
    if not exist.any():
        return np.zeros(len(requirement.bounds))
    searched = {name: values[at] for name, values in archive.figures.items()}
    kind = requirement.excess(exact)[exist] - requirement.excess(searched)[exist]
    return np.asarray(np.maximum(1.1 * kind.max(axis=0), 0.0))


def _away(archive: Archive, known: Mapping[int, Row]) -> Bools:
    """Points whose nearest judged one failed for what the search does not know of."""
    from scipy.spatial import cKDTree

    requirement = archive.requirement
    figures, exist = figures_of(list(known.values()), requirement.figures)
    told = np.any(requirement.excess(figures) > 0.0, axis=1) & exist
    rest = [(i, row) for (i, row), explained in zip(known.items(), told) if not explained]
    if all(row.verdict in PASSING for _, row in rest):
        return np.zeros(len(archive.shares), dtype=bool)
    failed = np.array([row.verdict not in PASSING for _, row in rest])
    nearest = cKDTree(archive.shares[[i for i, _ in rest]]).query(archive.shares)[1]
    return np.asarray(failed[nearest])


def _scattered(archive: Archive, known: Mapping[int, Row], count: int) -> Ints:
    """Points far from each other and from all that were judged, where every near one failed."""
    from scipy.spatial import cKDTree

    keep = np.flatnonzero(np.all(archive.requirement.excess(archive.figures) <= 0.0, axis=1))
    if not len(keep) or not known:
        return keep[:0]
    distance = np.asarray(cKDTree(archive.shares[list(known)]).query(archive.shares[keep])[0])
    found: list[int] = []
    for _ in range(min(count, len(keep))):
        i = int(np.argmax(distance))
        if distance[i] <= 0.0:
            break
        found.append(int(keep[i]))
        step = np.sqrt(np.sum((archive.shares[keep] - archive.shares[keep[i]]) ** 2, axis=1))
        distance = np.minimum(distance, step)
    return np.array(found, dtype=np.intp)


def spread(scores: Floats, at: Ints, count: int, given: Sequence[int] = ()) -> list[int]:
    """At most `count` of the points `at`: those given of them, the best of each aim, then always the farthest."""
    if len(at) <= count:
        return [int(i) for i in at]
    low, high = scores[at].min(axis=0), scores[at].max(axis=0)
    unit = (scores[at] - low) / np.where(high > low, high - low, 1.0)
    held = [int(i) for i in np.flatnonzero(np.isin(at, np.asarray(given, dtype=np.intp)))]
    found = list(dict.fromkeys([*np.argmin(unit, axis=0).tolist(), *held]))[:count]
    distance = np.min(np.sqrt(np.sum((unit[:, None] - unit[found]) ** 2, axis=2)), axis=1)
    while len(found) < count and distance.max() > 0.0:
        found.append(int(np.argmax(distance)))
        distance = np.minimum(distance, np.sqrt(np.sum((unit - unit[found[-1]]) ** 2, axis=1)))
    return [int(at[i]) for i in found]


def balanced(rows: Sequence[Row], requirement: Requirement) -> int:
    """The number of the member that is nearest to the best of every aim at once, each counted in its own range."""
    scores = requirement.scores(figures_of(rows, requirement.figures)[0])
    low, high = scores.min(axis=0), scores.max(axis=0)
    unit = (scores - low) / np.where(high > low, high - low, 1.0)
    return int(np.argmin(np.sum(unit**2, axis=1)))


def nothing(model: Model) -> tuple[Figures, str, str]:
    """The measure of a study that is asked for its profiles alone."""
    return {}, "", ""


def members_in(rows: Sequence[Row], requirement: Requirement) -> Iterator[Data]:
    """The profile's data of every member."""
    if not rows:
        return
    study = requirement.study([row.values for row in rows], nothing)
    for row in rows:
        yield study.variant(row.values)
