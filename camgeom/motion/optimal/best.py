"""The best motion law for a requirement, and the bound that no law of its class can beat.

B. Demeulenaere et al., Optimal splines for rigid motion systems: a convex programming framework, J. Mech. Des. 131(10)
(2009) 101004, is where the idea comes from. The acceleration is the unknown, and every usual wish is linear or convex.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import final

import numpy as np

from camgeom.errors import NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.motion.optimal.bound import weigh
from camgeom.motion.optimal.programme import SearchPurse
from camgeom.motion.optimal.search import Found, far, find, graded, refined
from camgeom.motion.optimal.shape import Shape, moment_parts, residual_peaks
from camgeom.motion.optimal.wish import ALL, EVEN, LIMITS, Task, Wish
from camgeom.motion.table import Piece

__all__ = ["Best", "Impossible", "Wish", "best"]

FINEST = (2e-3, 5e-4)
"""shares of the travel; shortest spans of the meshes on which a law is sought that even ones do not hold"""
STEEPEST = 1e2, 1e4
"""accelerations and jerks, of unit lift over unit travel, beyond which proofs ask no law: those of a cycloidal law are
6.3 and 39"""
RELAXED = 1e2
"""times a limit; a relaxation beyond that is no advice"""
SHOWN = 1e-6
"""a limit whose share of a proof is below this takes no part in it"""


@final
@immutable
class Best:
    """The best law found for a wish; dimensionless, for unit lift over unit travel.

    value   what is least, measured on the law; `bound` is what no law that keeps the limits can go below
    spent   what the search for it has cost, of `WHOLE` that it may
    """

    wish: Wish
    shape: Shape
    value: float
    bound: float
    spent: int = 0

    @property
    def gap(self) -> float:
        """How far the law can be from the best of all laws, a share of its value."""
        return max(0.0, 1.0 - self.bound / self.value) if self.value > 0.0 else 0.0

    @property
    def most_gain(self) -> float:
        """Most by which the best of all laws can be lower: what a share says nothing of where the value is next to
        none."""
        return max(0.0, self.value - self.bound)

    @property
    def holds_for(self) -> str:
        """The class of laws that the bound holds for."""
        return class_of(self.wish)

    @cached_property
    def pieces(self) -> tuple[Piece, ...]:
        """The law as polynomials, each about its left end, the last about x = 1."""
        shape, wish = self.shape, self.wish
        s, v = shape.states(wish.start[0])
        order = 2 if shape.smooth else 1
        pieces = []
        for k, (low, high) in enumerate(zip(shape.x[:-1].tolist(), shape.x[1:].tolist(), strict=True)):
            power = (s[k], v[k], shape.first[k] / 2.0, shape.jerk[k] / 6.0)
            kept = order if k else -1
            pieces.append(Piece(low, high, low, tuple(float(c) for c in power), (), kept))
        last = pieces[-1]
        a, j = shape.first[-1] + shape.h[-1] * shape.jerk[-1], shape.jerk[-1]
        power = (1.0, wish.end[0], float(a) / 2.0, float(j) / 6.0)
        pieces[-1] = Piece(last.start, 1.0, 1.0, power, (), last.kept)
        return tuple(pieces)

    @cached_property
    def peaks(self) -> dict[str, float]:
        """Peak |s'|, |s''|, |s'''| (inf where the acceleration jumps), root mean square of s'' and, over the band, the
        residual."""
        return _measured(self.wish, self.shape)


@final
@immutable(eq=True)
class Impossible:
    """A wish that no law can meet, with its proof.

    least     every limit would have to be this many times as large; `bound` above 1 is what proves it (and where both
              are one, it is more than that)
    clash     the limits that take part in the proof, each with its share
    relaxed   for each limit that could be relaxed alone, a hundred times at most: the least value that some law keeps
    assumed   a limit that the wish did not ask for, of which the proof makes use: "acceleration" or "jerk"
    """

    wish: Wish
    least: float
    bound: float
    clash: dict[str, float]
    relaxed: dict[str, float]
    assumed: str = ""

    @property
    def reason(self) -> str:
        """The proof in a sentence."""
        names = [name for name in LIMITS if name in self.clash and name != self.assumed]
        asked = " and ".join(f"{name} {getattr(self.wish, name):.9g}" for name in names) or "these ends"
        monotone = ", never turning back" if self.wish.monotone else ""
        steep = f", with a peak {self.assumed} up to {getattr(self.wish, self.assumed):g}" if self.assumed else ""
        loosen = " or ".join(f"{name} {_up(value)}" for name, value in self.relaxed.items())
        advice = f"; the smallest relaxation of one alone: {loosen}" if loosen else ""
        most = f"{_up(self.least)} times as large (proven above {self.bound:.7g})"
        if self.least == self.bound:
            most = f"more than {self.bound:.7g} times as large"
        return f"no law at all keeps {asked}{monotone}{steep}: all limits together would have to be {most}{advice}"


def _up(value: float) -> str:
    """Six digits, rounded so that what is shown is possible."""
    step = 10.0 ** (math.floor(math.log10(value)) - 5) if value > 0.0 else 1.0
    return f"{math.ceil(value / step - 1e-4) * step:.6g}"


def class_of(wish: Wish) -> str:
    """The laws that a bound for this wish holds for."""
    if not wish.smooth:
        return "all laws with these ends, the acceleration may jump"
    if not math.isfinite(wish.jerk) and wish.aim != "jerk":
        return "all laws with these ends whose acceleration has a mean square"
    return "all laws with these ends whose acceleration is continuous with a bounded jerk"


def _measured(wish: Wish, shape: Shape) -> dict[str, float]:
    values = {
        "velocity": float(np.abs(shape.velocities(wish.start[0])[1]).max()),
        "acceleration": float(np.abs(shape.a).max()),
        "jerk": float(np.abs(shape.jerk).max()) if shape.smooth else math.inf,
        "rms-acceleration": math.sqrt(shape.mean_square),
    }
    if wish.band is not None:
        values["residual"] = float(np.abs(residual_peaks(shape, wish.band, wish.damping)[1]).max())
    return values


def best(wish: Wish) -> Best | Impossible:
    """The best law for a wish, or the proof that there is none. Raises NotConverged where neither is found."""
    found = _tried(wish)
    if isinstance(found, str):
        raise NotConverged(found)
    return found


@lru_cache(maxsize=256)
def _tried(wish: Wish) -> Best | Impossible | str:
    """The same, or why neither is found: what has cost much is not tried again."""
    try:
        return sought(wish)
    except NotConverged as why:
        return str(why)


def sought(wish: Wish) -> Best | Impossible:
    """What `best` keeps, computed. Raises NotConverged."""
    purse = SearchPurse(among=wish.among)
    even = wish.nearly_even
    found = None if even else find(Task.of(wish), None, purse)
    if (found is None or far(Task.of(wish), found)) and (wish.given or wish.monotone):
        proof = _loosest(wish, found, purse) if wish.given else None
        if found is None and proof is not None and proof.bound > 1.0:
            return _impossible(wish, proof, purse)
        if found is None and wish.velocity <= 1.0 and min(wish.start[0], wish.end[0]) < 1.0:
            # The mean velocity is 1 and an end is slower. No mesh tells: without a limit on it the acceleration grows.
            factor = 1.0 / wish.velocity
            return Impossible(wish, factor, factor, {"velocity": 1.0}, {})
        if proof is not None and not even:
            found = _beside(wish, proof, found, purse)
    if even:
        raise NotConverged(
            f"a limit of the velocity of {wish.velocity:.9g} leaves a ramp {wish.longest_ramp:.2g} of the travel: "
            f"every law's peak acceleration is beyond {wish.steepest:.4g}, and ramps so short are not solved; from "
            f"{EVEN:.9g} on they are"
        )
    if found is None and (steep := _however_steep(wish, purse)) is not None:
        return steep
    if found is None:
        raise NotConverged("no law was found for these limits and none was proven impossible; loosen one a little")
    shape = _exact(wish, found.shape)
    name = "acceleration" if wish.aim == "peak-acceleration" else wish.aim
    return Best(wish, shape, _measured(wish, shape)[name], max(found.bound, 0.0), purse.spent)


def _however_steep(wish: Wish, purse: SearchPurse) -> Impossible | None:
    """The proof that no law meets a wish that limits neither acceleration nor jerk, though it may be as steep as no
    follower is: only under some such limit is the search for the loosest limits one; it is named where it clashes."""
    if math.isfinite(min(wish.jerk, wish.acceleration)) or not (wish.given or wish.monotone) or wish.nearly_even:
        return None
    steep = {"jerk": STEEPEST[1]} if wish.smooth else {"acceleration": STEEPEST[0]}
    limited = replace(wish, aim="rms-acceleration", **steep)  # type: ignore[arg-type]
    proof = _loosest(limited, None, purse)
    if proof is None or proof.bound <= 1.0:
        return None
    found, (assumed,) = _impossible(limited, proof, purse), steep
    return replace(found, assumed=assumed, relaxed={k: v for k, v in found.relaxed.items() if k != assumed})


def _loosest(wish: Wish, found: Found | None, purse: SearchPurse) -> Found | None:
    """The law with the least factor on all limits; None where a law is found and the purse holds no more."""
    try:
        return find(Task.of(wish, ALL), None, purse)
    except NotConverged:
        if found is None:
            raise
        return None


def _beside(wish: Wish, proof: Found, found: Found | None, purse: SearchPurse) -> Found | None:
    """A law, or a better one, with jerks shorter than a span of even meshes: beside the breaks of the one that has the
    least of all limits."""
    task = Task.of(wish)
    even = [refined(proof.shape)] if found is None else []
    for mesh in (*even, *(graded(proof.shape, finest) for finest in FINEST)):
        if found is not None and not far(task, found):
            break
        try:
            found = _better(wish, mesh, found, purse)
        except NotConverged:
            if found is None:
                raise
            break
    return found


def _better(wish: Wish, mesh: Shape, found: Found | None, purse: SearchPurse) -> Found | None:
    """The better law of one found and that of a mesh, with the better bound. Raises NotConverged."""
    other = find(Task.of(wish), mesh, purse)
    if other is None:
        return found
    better = other if found is None or other.value < found.value else found
    return replace(better, bound=max(one.bound for one in (found, other) if one is not None))


def _impossible(wish: Wish, proof: Found, purse: SearchPurse) -> Impossible:
    weights = weigh(Task.of(wish, ALL), proof.solved.shape, proof.solved.multipliers)
    shares = {name: getattr(weights, name) * getattr(wish, name) for name in wish.given}
    total = sum(shares.values())
    clash = {name: share / total for name, share in shares.items() if share > SHOWN * total}
    relaxed = {}
    for name in clash:
        if wish.nearly_even and name != "velocity":
            continue  # ramps as short as that velocity leaves are not solved
        try:
            alone = find(replace(Task.of(wish, name), most=RELAXED * getattr(wish, name)), None, purse)
        except NotConverged:
            break  # the proof stands; what one limit alone would have to be is advice
        if alone is not None:
            relaxed[name] = alone.value
    return Impossible(wish, proof.value, proof.bound, clash, relaxed)


def _exact(wish: Wish, shape: Shape) -> Shape:
    """The shape with what its moments lack by rounding spread over its levels."""
    a: Floats = shape.a.copy()
    for _ in range(2):
        rows = moment_parts(shape.x, shape.smooth).sum(axis=1)
        gap = np.array(wish.moments) - rows @ a
        if shape.smooth:
            rows[:, 0] *= wish.start[1] is None
            rows[:, -1] *= wish.end[1] is None
        a = a + np.linalg.lstsq(rows, gap, rcond=None)[0]
    return Shape(shape.x, a)
