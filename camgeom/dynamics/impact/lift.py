"""What goes round with the cam angle in the contact solver: motion and applied force, each in about a microsecond (SI).

The force on the follower is held as cubics on cells of one turn. Cells never straddle a knot, so a force that jumps or
kinks there is held exactly on both sides; the solver restarts where it jumps.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import replace
from math import ceil, radians
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from camgeom.errors import DesignError, Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import TURN, Floats
from camgeom.maths.frozen import cached_property
from camgeom.motion.program import Program

Jet = tuple[float, float, float]
"""lift, first and second derivative over the cam angle in radians"""
Row = tuple[float, ...]


@final
@immutable(eq=True)
class MotionArc:
    """One formula of the motion from `start` to `end` [rad], lift in m or rad, in u = angle - anchor:

    sum power[k] u^k + sum (a (cos(w u) - 1) + b sin(w u)) over the waves (w, a, b).
    """

    start: float
    end: float
    anchor: float
    power: tuple[float, ...]
    waves: tuple[tuple[float, float, float], ...] = ()

    def compiled(self) -> Callable[[float], Jet]:
        """A plain function: angle past `start` [rad] -> (lift, first, second derivative per rad)."""
        shift = self.start - self.anchor
        if len(self.power) <= 1 and not self.waves:
            rest = (self.power[0] if self.power else 0.0, 0.0, 0.0)
            return lambda x: rest
        falling = tuple(reversed(self.power))
        if not self.waves:
            return lambda x: _horner(falling, x + shift)
        waves = tuple((w, a, b, w * a, w * b, w * w * a, w * w * b) for w, a, b in self.waves)

        def jet(x: float) -> Jet:
            u = x + shift
            lift, first, second = _horner(falling, u)
            for w, a, b, wa, wb, wwa, wwb in waves:
                c, s = math.cos(w * u), math.sin(w * u)
                half = math.sin(0.5 * w * u)
                lift += b * s - 2.0 * a * half * half
                first += wb * c - wa * s
                second -= wwa * c + wwb * s
            return lift, first, second

        return jet

    def many(self, angle: Floats, order: int) -> Floats:
        """Lift and derivatives up to `order`, shape (order + 1, n), at an array of angles [rad]."""
        u = angle - self.anchor
        out = np.zeros((order + 1, u.size))
        for term in reversed(self.power):
            for k in range(order, 0, -1):
                out[k] = out[k] * u + out[k - 1]
            out[0] = out[0] * u + term
        for k in range(2, order + 1):
            out[k] *= math.factorial(k)
        for w, a, b in self.waves:
            c: Floats = np.cos(w * u)
            s: Floats = np.sin(w * u)
            turned = (b * s + a * c, b * c - a * s)
            out[0] += b * s - 2.0 * a * np.sin(0.5 * w * u) ** 2
            for k in range(1, order + 1):
                out[k] += (-1.0 if k % 4 >= 2 else 1.0) * w**k * turned[k % 2]
        return out


def _horner(falling: tuple[float, ...], u: float) -> Jet:
    lift = first = half = 0.0
    for c in falling:
        half = half * u + first
        first = first * u + lift
        lift = lift * u + c
    return lift, first, 2.0 * half


@final
@immutable(eq=True)
class Lift:
    """The follower motion over one turn: arcs that follow each other from 0 to 2 pi rad, lift in m or rad."""

    arcs: tuple[MotionArc, ...]

    def __post_init__(self) -> None:
        ends = [0.0, *(arc.end for arc in self.arcs)]
        starts = [*(arc.start for arc in self.arcs), TURN]
        broken = any(abs(a - b) > 1e-9 for a, b in zip(starts, ends, strict=True))
        if not self.arcs or broken or any(arc.end <= arc.start for arc in self.arcs):
            message = "the pieces of the motion must follow each other from 0 to one turn"
            raise ProfileError([Problem("motion", message, starts, "0 to 2 pi rad")])
        first = np.hstack([arc.many(np.array([arc.start]), 1) for arc in self.arcs])
        last = np.hstack([arc.many(np.array([arc.end]), 1) for arc in self.arcs])
        jumps = np.abs(np.roll(first, -1, axis=1) - last)
        scale = self.peaks
        if jumps[0].max() > 1e-9 + 1e-7 * scale[0]:
            message = "contact with free play is solved for motions that close after one turn without a jump"
            raise DesignError(f"motion: {message} (found {jumps[0].max():.6g} m or rad)")
        worst = int(np.argmax(jumps[1]))
        if jumps[1, worst] > 1e-9 + 1e-6 * scale[1]:
            raise DesignError(
                f"motion: the velocity jumps at {math.degrees(self.arcs[worst].end):.6g} degrees: the profile has a "
                "corner; use a law that starts and ends at rest"
            )

    @classmethod
    def from_program(cls, program: Program, unit: float) -> Lift:
        """The motion of a program; `unit` is m (or rad) per unit of its lift: 1e-3 for mm, 1 for rad."""
        arcs = []
        for span, pieces in zip(program.spans, program.pieces, strict=True):
            width = span.end - span.start
            places = [span.start + width * piece.start for piece in pieces] + [span.end]
            for piece, start, end in zip(pieces, places, places[1:]):
                anchor = span.end if piece.anchor == 1.0 else span.start + piece.anchor * width
                power = tuple(unit * c / width**k for k, c in enumerate(piece.power))
                waves = tuple((w / width, unit * a, unit * b) for w, a, b in piece.waves)
                arcs.append(MotionArc(start, end, anchor, power, waves))
        return cls(tuple(arcs))

    def split(self, angles: Sequence[float]) -> Lift:
        """The same motion with arcs that end at the given cam angles [rad] too."""
        arcs = []
        for arc in self.arcs:
            inside = sorted(a for a in set(angles) if arc.start + 1e-9 < a < arc.end - 1e-9)
            ends = [arc.start, *inside, arc.end]
            arcs += [replace(arc, start=a, end=b) for a, b in zip(ends, ends[1:])]
        return Lift(tuple(arcs))

    @cached_property
    def inner(self) -> Floats:
        """Cam angles [rad] spread over the arcs, none of them on a knot."""
        return np.concatenate([np.linspace(a.start, a.end, 183)[1:-1] for a in self.arcs])

    @cached_property
    def starts(self) -> Row:
        """Cam angles [rad] at which the arcs begin."""
        return tuple(arc.start for arc in self.arcs)

    def arc_at(self, angle: float) -> int:
        """The number of the arc that holds a cam angle [rad] of the first turn; at a knot the one after it."""
        return max(0, bisect_right(self.starts, angle) - 1)

    def compiled(self) -> LiftJets:
        """The quick evaluator of this motion."""
        spans = [arc.end - arc.start for arc in self.arcs]
        return LiftJets([arc.compiled() for arc in self.arcs], spans, self.starts)

    def many(self, angle: ArrayLike, order: int = 2) -> Floats:
        """Lift [m or rad] and derivatives per rad, shape (order + 1, n), at any cam angles [rad]."""
        turned = np.mod(np.atleast_1d(np.asarray(angle, dtype=np.float64)), TURN)
        out = np.empty((order + 1, turned.size))
        index = np.clip(np.searchsorted(self.starts, turned, side="right") - 1, 0, None)
        if index.size and index.min() == index.max():
            return self.arcs[int(index[0])].many(turned, order)
        for k in np.unique(index):
            here = index == k
            out[:, here] = self.arcs[k].many(turned[here], order)
        return out

    @cached_property
    def peaks(self) -> tuple[float, float, float, float]:
        """Largest magnitudes of lift and its first three derivatives per rad (the last three sampled: scales)."""
        values = np.hstack([arc.many(np.linspace(arc.start, arc.end, 65), 3) for arc in self.arcs])
        high = np.abs(values).max(axis=1)
        return float(high[0]), float(high[1]), float(high[2]), float(high[3])


@final
class LiftJets:
    """Plain functions of the arcs: `at(k, x)` is the jet at the angle x [rad] past the start of arc k, x in any arc."""

    __slots__ = ("jets", "spans", "starts")

    def __init__(self, jets: Sequence[Callable[[float], Jet]], spans: Sequence[float], starts: Row) -> None:
        self.jets = tuple(jets)
        self.spans = tuple(spans)
        self.starts = starts

    def at(self, k: int, x: float) -> Jet:
        """Lift and two derivatives at x [rad] past the start of arc k, stepping into the neighbours as needed."""
        spans = self.spans
        while x < 0.0:
            k = k - 1 if k else len(spans) - 1
            x += spans[k]
        while x > spans[k]:
            x -= spans[k]
            k = k + 1 if k + 1 < len(spans) else 0
        return self.jets[k](x)


WIDEST = radians(1.0)
"""widest cell; the cubic is then good to 1e-8 of a force that waves ten times a turn"""
INSET = 1e-9
"""share of a cell by which its end points lie inside: a jump at a knot belongs to one side"""
_SHARES = np.array([INSET, 1.0 / 3.0, 2.0 / 3.0, 1.0 - INSET])
_FIT = np.linalg.inv(np.vander(_SHARES, increasing=True))
JUMP = 1e-6
"""step over the largest value that counts as a jump"""


@final
@immutable(eq=True)
class ForceTable:
    """Force [N or N m] against larger q: cells begin at `starts` [rad], from 0; cubics in the share of a cell."""

    starts: tuple[float, ...]
    cubics: tuple[tuple[float, float, float, float], ...]

    @classmethod
    def of(cls, force: Callable[[Floats], Floats], knots: Sequence[float]) -> ForceTable:
        """The table of a force over cam angles [rad] in (0, 2 pi); knots: where it may jump or kink."""
        ends = np.unique(np.concatenate([[0.0, TURN], np.asarray(knots, dtype=float)]))
        ends = ends[(ends >= 0.0) & (ends <= TURN)]
        ends = ends[np.concatenate([np.diff(ends) > 1e-12 * TURN, [True]])]
        parts = [np.linspace(a, b, ceil((b - a) / WIDEST) + 1)[:-1] for a, b in zip(ends[:-1], ends[1:], strict=True)]
        starts = np.concatenate(parts)
        width = np.diff(np.append(starts, TURN))
        values = force((starts[:, None] + width[:, None] * _SHARES).ravel()).reshape(-1, 4)
        rows = values @ _FIT.T
        return cls(tuple(map(float, starts)), tuple((float(r[0]), float(r[1]), float(r[2]), float(r[3])) for r in rows))

    @cached_property
    def _arrays(self) -> tuple[Floats, Floats, Floats]:
        starts = np.array(self.starts)
        return starts, np.diff(np.append(starts, TURN)), np.array(self.cubics)

    @cached_property
    def largest(self) -> float:
        """Largest magnitude [N or N m] at the ends of the cells."""
        _, _, c = self._arrays
        return float(max(np.abs(c[:, 0]).max(), np.abs(c.sum(axis=1)).max()))

    @cached_property
    def jumps(self) -> tuple[float, ...]:
        """Cam angles [rad] in (0, 2 pi) at which the force jumps."""
        starts, _, c = self._arrays
        steps = np.abs(c[1:, 0] - c[:-1].sum(axis=1))
        return tuple(float(a) for a in starts[1:][steps > JUMP * self.largest])

    def within(self, start: float, end: float) -> Callable[[float], float]:
        """A plain function of the angle [rad] past `start`, from the cells between two angles [rad] alone."""
        tiny = 1e-12 * TURN
        first = max(bisect_right(self.starts, start + tiny) - 1, 0)
        last = max(bisect_right(self.starts, end - tiny), first + 1)
        starts = [s - start for s in self.starts[first:last]]
        ends = [*self.starts, TURN][first + 1 : last + 1]
        cells = [
            (s, 1.0 / (e - start - s), *cubic)
            for s, e, cubic in zip(starts, ends, self.cubics[first:last], strict=True)
        ]
        inner = starts[1:]

        def force(x: float) -> float:
            s, per, a, b, c, d = cells[bisect_right(inner, x)]
            u = (x - s) * per
            return a + u * (b + u * (c + u * d))

        return force

    def many(self, angle: Floats, start: Floats, end: Floats) -> Floats:
        """Force [N or N m] at cam angles [rad], each from the cells between its own start and end [rad]."""
        starts, width, cubics = self._arrays
        tiny = 1e-12 * TURN
        low = np.searchsorted(starts, start + tiny, side="right") - 1
        high = np.searchsorted(starts, end - tiny, side="right") - 1
        cell = np.clip(np.searchsorted(starts, angle, side="right") - 1, low, np.maximum(high, low))
        u = (angle - starts[cell]) / width[cell]
        a, b, c, d = cubics[cell].T
        return np.asarray(a + u * (b + u * (c + u * d)))
