"""Segments of the motion of many variants: shapes over unit travel, legs between cam angles, what may be varied."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import field
from functools import lru_cache
from typing import TYPE_CHECKING, final

import numpy as np
from numpy.typing import NDArray

from camgeom.design.batch.variants import path_of, value_of
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.maths.panels import TURN, Panels, panels, resolved
from camgeom.motion.catalogue import LAWS
from camgeom.motion.law import Law

if TYPE_CHECKING:
    from camgeom.motion.program import Program
    from camgeom.profile import Profile
    from camgeom.profile.sections import MotionSegment


WIDEST = 0.5
"""of a law's travel that one piece spans at most"""
FINE = 1024
"""steps of a piece to which a refined extreme is placed"""
ALIKE = 1e-9
"""by which share of its largest value a half of a move may differ from the other half turned about the middle"""
BESIDE = 1e-10
"""share of a piece by which its ends are sampled inside it, on its own side of a jump: an applied force counts as begun
within 6e-14 rad"""
EVEN, TRUE, ROUNDS = 1e-5, 1e-6, 10
"""shares of the largest applied force to which pieces have to follow it and by which it is known itself, and how often
a piece is halved for that"""
WIDEST_PANEL = np.radians(6.0)
"""rad; between the angles at which a force is looked at first lie a tenth of that"""
MOST_CUTS = 100
"""pieces that applied forces may add to a motion"""


@final
@immutable
class Shape:
    """A segment's motion over unit travel and unit lift: knots in 0..1 and jets (4, m) at places (m,)."""

    knots: tuple[float, ...]
    jet: Callable[[Floats], Floats]
    dwells: bool = False
    _tables: dict[tuple[float, float], Floats] = field(default_factory=dict)

    @cached_property
    def pieces(self) -> tuple[tuple[float, float], ...]:
        """Pieces between knots and places where the motion turns, none wider than WIDEST."""
        ends = sorted({*self.knots, *self._turns()})
        found = []
        for low, high in zip(ends, ends[1:]):
            parts = int(np.ceil((high - low) / WIDEST - 1e-9))
            found += [(low + (high - low) * i / parts, low + (high - low) * (i + 1) / parts) for i in range(parts)]
        return tuple(found)

    def _turns(self) -> list[float]:
        """Places inside where the velocity changes sign: friction does so there."""
        from camgeom.maths.extremum import bracketed_root

        x = np.concatenate([np.linspace(low, high, 65)[1:-1] for low, high in zip(self.knots, self.knots[1:])])
        v = self.jet(x)[1]
        at = np.flatnonzero(v[:-1] * v[1:] < 0.0)
        if not at.size:
            return []
        return [float(one) for one in bracketed_root(lambda y: self.jet(y)[1], x[at], x[at + 1])]

    @cached_property
    def even(self) -> bool:
        """Whether it ends as it began: the second half is the first one turned about the middle."""
        if self.dwells:
            return True
        ends = np.array(self.pieces)
        if np.abs(ends + ends[::-1, ::-1] - 1.0).max() > ALIKE:
            return False
        jets = np.concatenate([self.table(low, high) for low, high in self.pieces], axis=1)
        s, v, a = jets[:3]
        total = s[0] + s[-1]
        slips = (s + s[::-1] - total, v - v[::-1], a + a[::-1])
        return all(np.abs(slip).max() <= ALIKE * np.abs(x).max() for slip, x in zip(slips, (s, v, a)))

    def table(self, low: float, high: float) -> Floats:
        """Jets at FINE steps of a stretch without a knot inside, (4, FINE + 1), one-sided at its ends."""
        if (low, high) not in self._tables:
            share = np.linspace(0.0, 1.0, FINE + 1)
            share[0], share[-1] = BESIDE, 1.0 - BESIDE
            self._tables[low, high] = self.jet(low + (high - low) * share)
        return self._tables[low, high]

    @cached_property
    def peaks(self) -> tuple[float, float, float]:
        """Largest magnitude of the first three derivatives."""
        if self.dwells:
            return 0.0, 0.0, 0.0
        from camgeom.maths.extremum import refined_maximum

        found = []
        for order in (1, 2, 3):
            x = np.concatenate([np.linspace(low + 1e-12, high - 1e-12, 65) for low, high in self.pieces])
            owner = np.repeat(np.arange(len(self.pieces)), 65)

            def size(at: Floats, order: int = order) -> Floats:
                return np.asarray(np.abs(self.jet(at)[order]))

            found.append(refined_maximum(size, x, owner, size(x))[0])
        return found[0], found[1], found[2]


DWELL = Shape((0.0, 1.0), lambda x: np.zeros((4, *x.shape)), dwells=True)


@lru_cache(maxsize=256)
def law_shape(law: Law) -> Shape:
    """The shape of a law that stands alone."""
    return Shape(law.knots, lambda x: law.jet(x, 3))


@final
@immutable
class Leg:
    """One segment of the motion of all variants: cam angles (rad) and lifts (mm or rad), each (n,) or (1,).

    lift  by which the shape is multiplied: the travel of a law that stands alone
    """

    shape: Shape
    start: Floats
    end: Floats
    before: Floats
    after: Floats
    lift: Floats

    def of(self, rows: NDArray[np.intp]) -> Leg:
        """The same of these variants."""
        ends = (self.start, self.end, self.before, self.after, self.lift)
        return Leg(self.shape, *(one[rows] if len(one) > 1 else one for one in ends))

    @property
    def width(self) -> Floats:
        """rad."""
        return self.end - self.start


@lru_cache(maxsize=8)
def program_of(profile: Profile) -> Program:
    """The profile's own motion."""
    return profile.setup().program


def joined(motion: Sequence[MotionSegment]) -> bool:
    """Whether a segment asks its neighbours for its shape."""
    return any(
        (one.law is not None and LAWS[one.law].joins)
        or any(rate is not None for rate in (one.velocity, one.acceleration, one.jerk))
        for one in motion
    )


def motion_reason(profile: Profile, varied: Sequence[str]) -> str | None:
    """Why the motion of these variants has to be made one by one; None where their laws scale."""
    for key in varied:
        path = path_of(key)
        if path[0] != "motion":
            continue
        if path[-1] not in ("until", "to"):
            return f"{key}: every value makes another law"
        if joined(profile.motion):
            return f"{key}: a segment is joined to its neighbours, so every value makes another law"
        if path[-1] == "to" and value_of(profile, key) is None:
            return f"{key}: the segment dwells"
    return None


@lru_cache(maxsize=8)
def force_cuts(profile: Profile) -> tuple[float, ...]:
    """Cam angles, rad, at which pieces of the motion end so that applied forces are smooth within them: their breaks,
    and halves of halves where they turn more often than a piece's samples follow."""
    operation = profile.operation
    forces = tuple(force.applied() for force in operation.force) if operation is not None else ()
    if operation is None or not forces:
        return ()
    breaks = sorted({angle for force in forces for angle in force.anywhere})
    program, omega = profile.setup().program, operation.speed * TURN / 60.0

    def value(theta: Floats) -> Floats:
        s, v, a = program.jet(theta, 2)[:3]
        return np.stack([force(theta, s, omega * v, omega**2 * a) for force in forces])

    ends = np.array([0.0, TURN, *breaks, *program.knots])
    ends = ends[(ends >= 0.0) & (ends <= TURN)]
    known = resolved(value, panels(ends, WIDEST_PANEL), TRUE)
    edges = panels(ends, np.inf).edges
    # As the pieces of the legs are, which are no wider than half of one.
    begun = Panels(np.sort(np.concatenate([edges, 0.5 * (edges[1:] + edges[:-1])])), edges)
    current, true = begun, value(known.theta.ravel())
    least = EVEN * np.abs(true).max(axis=1, keepdims=True)
    for _ in range(ROUNDS):
        off = (np.abs(current.at(value(current.theta), known.theta.ravel()) - true) > least).any(axis=0)
        coarse = np.unique(np.searchsorted(current.edges, known.theta.ravel()[off]) - 1)
        if not coarse.size or len(current.edges) > len(begun.edges) + MOST_CUTS:
            break
        current = Panels(np.sort(np.concatenate([current.edges, current.middle[coarse]])), current.breaks)
    return tuple(sorted({*breaks, *np.setdiff1d(current.edges, begun.edges).tolist()}))


@lru_cache(maxsize=256)
def shape_of(segment: MotionSegment) -> Shape:
    """A segment's own shape, whatever stands beside it."""
    if segment.law is None:
        return DWELL
    return law_shape(LAWS[segment.law].make(dict(segment.parameters)))


@lru_cache(maxsize=8)
def fixed_legs(profile: Profile) -> tuple[Leg, ...]:
    """The segments of a motion that is the same for all variants, whatever joins them."""
    program = profile.setup().program
    legs = []
    for span in program.spans:
        width = span.end - span.start
        inner = program.knots[(program.knots > span.start + 1e-9) & (program.knots < span.end - 1e-9)]
        knots = (0.0, *((inner - span.start) / width).tolist(), 1.0)

        def jet(x: Floats, start: float = span.start, width: float = width, before: float = span.before) -> Floats:
            found = program.jet(start + width * x, 3) * (width ** np.arange(4.0))[:, None]
            found[0] -= before
            return np.asarray(found)

        shape = DWELL if span.law == "dwell" else Shape(knots, jet)
        ends = (np.array([one]) for one in (span.start, span.end, span.before, span.after, not shape.dwells))
        legs.append(Leg(shape, *ends))
    return tuple(legs)
