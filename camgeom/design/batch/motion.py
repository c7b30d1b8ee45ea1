"""The motion of many variants: on pieces with tables of the laws' jets, refined extremes, integrals.

Arrays are (P, n): P samples of the cam angle, n variants, so that a number of a variant meets all its samples and a
number of a law all the variants.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from copy import copy
from dataclasses import field, is_dataclass, replace
from math import radians
from typing import TypeVar, cast, final

import numpy as np
from numpy.typing import NDArray

from camgeom.design.batch.legs import BESIDE, FINE, Leg, fixed_legs, joined, program_of, shape_of
from camgeom.design.batch.variants import Mask, Variants
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.motion.program import ANGLE_SLIP, LEAST_WIDTH, MOST_LIFT, TURN

Ints = NDArray[np.intp]

SAMPLES = 17
"""a piece of a law, both ends included"""
REACH = 8
"""fine steps on both sides of it, where the parabola that gives its value is laid"""
NEAR = 2
"""the same where a quantity falls off by more than STEEP of itself within REACH"""
TOPS = 3
"""pieces in which the largest of a quantity is computed again"""
PART = 65536
"""numbers of a quantity at samples that are computed at once: what arises on the way stays in the cache"""
STEEP = 1e-3
ROUNDS = 8
ABOUT = np.array([[-1], [0], [1]])
SCAN, SCANNED = 10, (FINE // 64, 2)
"""places on either side of a largest sample at which a quantity with bends is looked at, and their spacings in turn"""
MIRRORED, BENT = 1e-11, 1e-6
"""shares by which the largest samples of two pieces and their second differences differ where one mirrors the other"""
ROUNDED = 16
"""units of the last place by which a quantity of samples may be rounded"""


@final
@immutable
class Points:
    """The motion at samples: cam angle, rad, lift and derivatives per rad, each (P, n) or (P, 1).

    side  sign of the motion there, 0 in a dwell
    kept  whether they come again, so that what is found out about them is kept
    """

    theta: Floats
    s: Floats
    ds: Floats
    dds: Floats
    side: Floats
    kept: bool = field(default=False, kw_only=True)

    def of(self, rows: Ints | slice) -> Points:
        """These samples alone."""
        return Points(self.theta[rows], self.s[rows], self.ds[rows], self.dds[rows], self.side[rows])

    @cached_property
    def rough(self) -> Points:
        """In single precision, but for the cam angle, which stands on its own side of a jump."""
        return Points(self.theta, *map(single, (self.s, self.ds, self.dds, self.side)), kept=self.kept)

    def flat(self, places: Ints, size: int) -> Points:
        """These places of (P size) alone, (N,)."""
        each = (self.theta, self.s, self.ds, self.dds, self.side)
        return Points(*(one.reshape(-1).take(places if one.shape[1] == size else places // size) for one in each))


Some = Callable[[Ints], Callable[["Points"], Floats]]
Thing = TypeVar("Thing")


def changed(thing: Thing, change: Callable[[Floats], Floats]) -> Thing:
    """The same with all numbers of many variants in it, (n,), changed: in tuples and objects of such numbers too."""
    if isinstance(thing, np.ndarray):
        return cast(Thing, change(thing))
    if isinstance(thing, tuple):
        return cast(Thing, tuple(changed(one, change) for one in thing))
    if is_dataclass(thing):
        found = copy(thing)
        vars(found).update({name: changed(one, change) for name, one in vars(thing).items()})
        return found
    return thing


def of_rows(rows: Ints) -> Callable[[Floats], Floats]:
    """Numbers of these variants from those of all, of which one stands for all where they are alike."""
    return lambda values: values.take(rows) if len(values) > 1 else values


def single(values: Floats) -> Floats:
    """In single precision, which takes half the time: enough to see about where a quantity is largest."""
    return cast(Floats, values.astype(np.float32))


FIXED = "rows", "order", "moving", "_table", "_places"
"""what of a motion hangs on no variant"""
Row = tuple[int, float, float]
"""A piece: the leg it is of, and its ends in the leg's own travel."""


@final
@immutable
class Motion:
    """The motion of n variants on pieces: first those that are sampled, then dwells in which nothing changes.

    legs  segments in the order of the cam angle
    cuts  cam angles, rad, of further breaks (ends of forces); legs then do not vary in cam angle
    busy  whether dwells are sampled too, since something changes while the follower rests
    """

    legs: tuple[Leg, ...]
    size: int
    cuts: tuple[float, ...] = ()
    busy: bool = False

    def of(self, rows: Ints) -> Motion:
        """That of these variants, each as often as it is named."""
        found = Motion(tuple(leg.of(rows) for leg in self.legs), len(rows), self.cuts, self.busy)
        vars(found).update({name: getattr(self, name) for name in FIXED})
        if "lift_range" in vars(self):
            vars(found)["lift_range"] = changed(self.lift_range, of_rows(rows))
        return found

    @cached_property
    def rows(self) -> tuple[Row, ...]:
        """All pieces, those that rest last."""
        every = [(k, low, high) for k, leg in enumerate(self.legs) for low, high in self._stretches(leg)]
        return tuple(sorted(every, key=lambda row: self._rests(row[0])))

    @cached_property
    def order(self) -> Ints:
        """The pieces in the order of the cam angle."""
        return np.array(sorted(range(len(self.rows)), key=lambda i: self.rows[i][:2]))

    @cached_property
    def halves(self) -> Motion:
        """The same without what loads cut, and of moves that end as they begin the first half alone: for what hangs on
        the squares of velocity and acceleration alone."""
        found = Motion(self.legs, self.size)
        even = [leg.shape.even for leg in self.legs]
        vars(found)["rows"] = tuple(row for row in found.rows if row[1] < 0.5 or not even[row[0]])
        return found

    def _rests(self, leg: int) -> bool:
        return self.legs[leg].shape.dwells and not self.busy

    def _stretches(self, leg: Leg) -> list[tuple[float, float]]:
        """Pieces of a leg's travel, cut at the ends of forces within."""
        found = []
        start, width = float(leg.start[0]), float(leg.width[0])
        cuts = [(angle - start) / width for angle in self.cuts]
        for low, high in leg.shape.pieces:
            if leg.shape.dwells and not self.busy:
                return [(0.0, 1.0)]
            ends = [low, *sorted(x for x in cuts if low + 1e-9 < x < high - 1e-9), high]
            found += list(zip(ends, ends[1:]))
        return found

    @cached_property
    def moving(self) -> int:
        """Number of the pieces that are sampled."""
        return sum(not self._rests(k) for k, _, _ in self.rows)

    @cached_property
    def _columns(self) -> tuple[Floats, ...]:
        """Of every piece: beginning and width in cam angle, lift before, lift, width of its leg, (K, 1, n or 1)."""

        def stacked(values: Iterable[Floats]) -> Floats:
            return np.stack(np.broadcast_arrays(*values))[:, None, :]

        legs = [self.legs[k] for k, _, _ in self.rows]
        begin = stacked(leg.start + low * leg.width for leg, (_, low, _) in zip(legs, self.rows))
        long = stacked((high - low) * leg.width for leg, (_, low, high) in zip(legs, self.rows))
        before, lift, width = (stacked(getattr(leg, name) for leg in legs) for name in ("before", "lift", "width"))
        return begin, long, before, lift, width

    @property
    def widths(self) -> Floats:
        """Width of every piece, rad, (K, n or 1)."""
        return np.asarray(self._columns[1][:, 0])

    @cached_property
    def _table(self) -> Floats:
        """Jets of all pieces, (4, K, FINE + 1)."""
        return np.stack([self.legs[k].shape.table(low, high) for k, low, high in self.rows], axis=1)

    @cached_property
    def samples(self) -> Points:
        """SAMPLES points of every piece that moves, one of every other, (P, n)."""
        return self.sampled(SAMPLES)

    def sampled(self, count: int) -> Points:
        """So many points of every piece that moves, one more than a power of two, and one of every other, (P, n)."""
        step = FINE // (count - 1)
        f = self._table[:, :, ::step][..., None]
        begin, long, before, lift, width = self._columns
        share = np.clip(np.linspace(0.0, 1.0, count), BESIDE, 1.0 - BESIDE)[None, :, None]
        side = np.sign(lift * f[1][:, count // 2, None]) + 0.0 * f[1]
        jets = (begin + long * share, before + lift * f[0], (lift / width) * f[1], (lift / width**2) * f[2], side)
        return Points(*(self._laid(x) for x in jets))

    @cached_property
    def parts(self) -> tuple[Points, ...]:
        """These samples, a few of them at a time."""
        count, rows = len(self.samples.s), max(1, PART // self.size)
        each = (self.samples.of(slice(first, first + rows)) for first in range(0, count, rows))
        return tuple(replace(points, kept=True) for points in each)

    def spread(self, what: Callable[[Points], Floats], rough: bool = False) -> Floats:
        """A quantity of points at the samples, (P, n) or (P, 1); `rough`: in single precision."""
        return np.concatenate([what(points.rough if rough else points) for points in self.parts])

    def _laid(self, values: Floats) -> Floats:
        """(K, samples of a piece, n) as samples (P, n): one of a piece that rests."""
        moving = values[: self.moving].reshape(-1, values.shape[2])
        middle = values.shape[1] // 2
        return np.concatenate([moving, values[self.moving :, middle]]) if self.moving < len(values) else moving

    def tops(
        self, values: Floats, count: int = TOPS, off: float = 0.0, bent: bool = False
    ) -> tuple[Ints, Ints, Mask]:
        """Where samples, (P, n) or (m, P, n) of m quantities, are largest: pieces and fine steps, (k, n), of the best
        and of others, `count` in all at most, and whether they may hold more than the best. Samples do not tell which
        of two that are nearly alike is larger, and both halves of a move may be alike.

        off   share of themselves by which the values may be off
        bent  whether both halves of a piece may have a peak of their own
        """
        whole, one = self.moving * SAMPLES, np.arange(self.size)
        every = whole + len(self.rows) - self.moving
        values = np.broadcast_to(values, (*values.shape[:-2], every, self.size)).reshape(-1, every, self.size)
        samples = values[:, :whole].reshape(-1, SAMPLES, self.size)
        if bent:
            samples = np.concatenate([samples[:, : SAMPLES // 2 + 1], samples[:, SAMPLES // 2 :]])
        # A piece that rests has one value.
        still = values[:, whole:].reshape(-1, self.size)
        beside: tuple[Floats | Ints, ...] = (np.full(still.shape, FINE // 2), still, np.zeros(still.shape))
        step, height, doubt = (
            np.concatenate([one.reshape(-1, self.size), rest]) for one, rest in zip(_highest(samples), beside)
        )
        each = np.arange(len(self.rows))
        moves, rests = (np.tile(part, len(values)) for part in (each[: self.moving], each[self.moving :]))
        number = np.concatenate([moves, moves, rests] if bent else [moves, rests])
        if bent:
            step[len(moves) : 2 * len(moves)] += FINE // 2
        doubt += off * np.abs(height)
        sure, most = (height - doubt).max(axis=0), height + doubt
        first = top_row(height)
        found, open_ = [first], [np.ones(self.size, dtype=bool)]
        # Of halves that mirror each other one is enough; two that meet where both are largest need not.
        like, bow = height[first, one], doubt[first, one]
        near = max(MIRRORED, ROUNDED * float(np.finfo(values.dtype).eps)) * np.abs(like)
        alike = (np.abs(height - like) <= near) & (np.abs(doubt - bow) <= BENT * bow + near)
        most[alike & (bow > near)] = -np.inf
        for _ in range(min(count, len(number)) - 1):
            most[found[-1], one] = -np.inf
            best = top_row(most)
            higher = most[best, one] >= sure
            if not higher.any():
                break
            found.append(best)
            open_.append(higher)
        places = np.stack(found)
        return number[places], step[places, one], np.stack(open_)

    @cached_property
    def _places(self) -> tuple[Floats, Floats, Floats, Ints]:
        """Of every piece: beginning and length in its leg's own travel, the sign of the leg's shape, and the leg, (K,)
        each."""
        legs, low, high = (np.array(one) for one in zip(*self.rows))
        return low, high - low, np.sign(self._table[1, :, FINE // 2]), legs

    def at(self, piece: Ints, j: Ints | Floats) -> Points:
        """The motion at fine steps, or between them, (..., n) of pieces (n,) or (k, n): as (P, n)."""
        i = np.asarray(j, dtype=np.intp)
        flat = piece * (FINE + 1) + i
        tables = [one.reshape(-1) for one in self._table]
        f = [one.take(flat) for one in tables[:3]]
        low, span, sign, leg = self._places
        if i is not j and (share := j - i).any():
            jerk = tables[3].take(flat)
            flat += i < FINE
            rise = [one.take(flat) - value for one, value in zip(tables, (*f, jerk))]
            lift, pace, bend, jerk = (value + share * more for value, more in zip((*f, jerk), rise))
            # A chord stands above an arc by half of both shares of the step and the second derivative.
            step = span.take(piece) / FINE
            under = 0.5 * share * (1.0 - share) * step
            f = [lift - under * step * bend, pace - under * step * jerk, bend - under * rise[3]]
        legs = leg.take(piece)
        several = legs * self.size + np.arange(self.size)
        start, before, lift, width, rate, bend, way = (
            one.reshape(-1).take(legs if one.shape[1] == 1 else several) for one in self._of_legs
        )
        place = low.take(piece) + span.take(piece) * np.clip(j / FINE, BESIDE, 1.0 - BESIDE)
        side = np.broadcast_to(way * sign.take(piece), f[0].shape)
        each = start + width * place, before + lift * f[0], rate * f[1], bend * f[2], side
        return Points(*(one.reshape(-1, one.shape[-1]) for one in each))

    @cached_property
    def _of_legs(self) -> tuple[Floats, ...]:
        """Of every leg: start, lift before, lift, width, lift by width and by its square, and the lift's sign, (L, n or
        1) each."""

        def of(name: str) -> Floats:
            values = [getattr(leg, name) for leg in self.legs]
            found = np.empty((len(values), max(map(len, values))))
            for row, one in zip(found, values):
                row[:] = one
            return found

        start, before, lift, width = map(of, ("start", "before", "lift", "width"))
        rate = lift / width
        return start, before, lift, width, rate, rate / width, np.sign(lift)

    def whenever(self, theta: Floats) -> Points:
        """The motion at cam angles (k, n), rad, of any turn."""
        return self.at(*self.placed(theta))

    def placed(self, theta: Floats) -> tuple[Ints, Floats]:
        """Pieces and fine steps, (k, n), of cam angles, rad, of any turn."""
        begin, long, *_ = self._columns
        at = np.mod(theta, TURN)
        place: Ints = np.zeros(at.shape, dtype=np.intp)
        for i in self.order[1:].tolist():
            place += at >= begin[i]
        piece = self.order.take(place)
        which = piece if begin.shape[2] == 1 else piece * self.size + np.arange(self.size)
        share = (at - begin.reshape(-1).take(which)) / long.reshape(-1).take(which)
        return piece, FINE * np.clip(share, 0.0, 1.0)

    def reached(self, lift: Floats) -> Points:
        """The motion at the fine step where it reaches lifts, mm or rad, (k, n), if it never turns back: (k, n)."""
        full = (self.moving, self.size)
        ends = np.broadcast_to(self.samples.s[SAMPLES - 1 : self.moving * SAMPLES : SAMPLES], full)
        begin = np.broadcast_to(self.samples.s[: self.moving * SAMPLES : SAMPLES], full)
        piece = np.minimum((ends[:, None] < lift).sum(axis=0), self.moving - 1)
        one = np.arange(self.size)
        share = (lift - begin[piece, one]) / (ends - begin)[piece, one]
        j = np.zeros(lift.shape)
        for k in np.unique(piece):
            rows = piece == k
            f = self._table[0, k]
            j[rows] = np.interp(share[rows], (f - f[0]) / (f[-1] - f[0]), np.arange(FINE + 1.0))
        return self.at(piece, j)

    def largest(
        self, again: Callable[[Points], Floats], values: Floats | None = None, bent: bool = False,
        of: Some | None = None,
    ) -> Floats:
        """The largest of a quantity of points, (n,): sampled, and computed again near its largest samples.

        values  the samples, (P, n), in either precision
        bent    whether it may have bends between samples: it is then looked at more closely on both sides of them
        of      the same quantity of some of the variants, whose rows it takes
        """
        values = self.spread(again) if values is None else values
        most, slip = values.max(axis=0), ROUNDED * float(np.finfo(values.dtype).eps)
        piece, step, tried = self.sought(again, values, bent)
        # A bend is nearer to a parabola the nearer its three points are.
        reach = NEAR if bent else REACH
        found = self.top(again, piece[0], step[0], of, reach)[0]
        for one, fine, there in zip(piece[1:], step[1:], tried[1:]):
            rows = np.flatnonzero(there)
            if of is None or 2 * rows.size > self.size:
                found = np.maximum(found, self.top(again, one, fine, of, reach)[0])
            elif rows.size:
                more = self.of(rows).top(of(rows), one[rows], fine[rows], None, reach)[0]
                found[rows] = np.maximum(found[rows], more)
        return np.where(most > found + slip * np.abs(found), most, found)

    def sought(self, again: Callable[[Points], Floats], values: Floats, bent: bool) -> tuple[Ints, Ints, Mask]:
        """Where samples (P, n) of a quantity are largest: pieces and fine steps, (k, n), and whether they may hold
        more than the first."""
        piece, step, tried = self.tops(values, bent=bent)
        return piece, self.scanned(again, piece, step) if bent else step, tried

    def scanned(
        self, again: Callable[[Points], Floats], piece: Ints, step: Ints, spacings: tuple[int, ...] = SCANNED
    ) -> Ints:
        """The fine steps about these, (k, n), at which a quantity with bends is largest: at spacings in turn."""
        for spacing in spacings:
            steps = np.clip(step + spacing * np.arange(-SCAN, SCAN + 1)[:, None, None], REACH, FINE - REACH)
            found = np.broadcast_to(again(self.at(piece, steps)), (steps.size // self.size, self.size))
            top = top_row(found.reshape(len(steps), -1)).reshape(piece.shape)
            step = np.take_along_axis(steps, top[None], axis=0)[0]
        return step

    def top(
        self, again: Callable[[Points], Floats], piece: Ints, step: Ints, of: Some | None = None,
        reach: Ints | int = REACH, rounds: int = ROUNDS,
    ) -> tuple[Floats, Floats]:
        """The largest of a quantity near places, and the fine step where it is, (n,) each: by three points, which are
        laid again where it lies beyond them, and nearer where it is steep; where it is still steep then, it is computed
        at the place that they tell. `of` as of `largest`."""
        reach = np.broadcast_to(reach, piece.shape)
        for left in range(rounds - 1, -1, -1):
            values = np.broadcast_to(again(self.at(piece, step + reach * ABOUT)), (3, self.size))
            at, value = vertex(*values)
            place = step + at * reach
            more, moved, closer = nearer(values, at, step, reach)
            rows = np.flatnonzero(more)
            if not (rows.size and left):
                break
            if of is not None and 2 * rows.size <= self.size:
                value[rows], place[rows] = self.of(rows).top(
                    of(rows), piece[rows], moved[rows], None, closer[rows], left)
                break
            step, reach = np.where(more, moved, step), closer
        rows = np.flatnonzero(values[1] - np.minimum(values[0], values[2]) > STEEP * np.abs(values[1]))
        if rows.size and (of is None or 2 * rows.size > self.size):
            value = np.broadcast_to(again(self.at(piece, place[None])), (1, self.size))[0].copy()
        elif rows.size and of is not None:
            value[rows] = of(rows)(self.of(rows).at(piece[rows], place[rows][None]))
        return value, place

    def smallest(self, again: Callable[[Points], Floats], values: Floats | None = None, bent: bool = False) -> Floats:
        """The smallest, likewise."""
        return -self.largest(lambda points: -again(points), None if values is None else -values, bent)

    @cached_property
    def weights(self) -> Floats:
        """Weights (P, n) with which samples sum to the integral over the turn (Simpson's rule in every piece)."""
        rule = np.full(SAMPLES, 2.0)
        rule[1::2], rule[0], rule[-1] = 4.0, 1.0, 1.0
        moving = self._columns[1] * (rule / (3.0 * (SAMPLES - 1)))[None, :, None]
        return np.concatenate([self._laid(moving)[: self.moving * SAMPLES], self._columns[1][self.moving :, 0]])

    def integral(self, values: Floats) -> Floats:
        """The integral over the turn of samples (P, n)."""
        return np.asarray((self.weights * values).sum(axis=0))

    def fine_integral(self, what: Callable[[Points], Floats]) -> Floats:
        """The integral over the moving pieces of a quantity of points that has kinks, (n,): samples eight times as
        dense."""
        step = FINE // (8 * (SAMPLES - 1))
        j = np.arange(0, FINE + 1, step)[:, None]
        rule = np.where(np.arange(len(j)) % 2 == 1, 4.0, 2.0)
        rule[0] = rule[-1] = 1.0
        total = np.zeros(self.size)
        for piece in range(self.moving):
            width = self._columns[1][piece, 0] * (step / (3.0 * FINE))
            total = total + width * (rule @ what(self.at(np.full(self.size, piece), j)))
        return total

    @cached_property
    def peaks(self) -> tuple[Floats, Floats, Floats]:
        """Largest magnitude of velocity, acceleration and jerk per rad, rad², rad³, (n,) or (1,) each."""
        first, second, third = (
            np.max(np.broadcast_arrays(*(np.abs(leg.lift) * leg.shape.peaks[k] / leg.width ** (k + 1)
                                         for leg in self.legs)), axis=0)
            for k in range(3)
        )  # fmt: skip
        return first, second, third

    def figure(self, name: str, unit: float, omega: Floats | float) -> Floats:
        """A figure of the motion by its name in a study, with the unit of a lift in mm or rad; omega, rad/s."""
        if name.startswith("motion.stroke"):
            return unit * self.stroke
        order = ORDERS.index(name.split("_")[1]) + 1
        peak = unit * self.peaks[order - 1]
        return np.asarray(peak * omega**order) if "_per_s" in name else peak

    @cached_property
    def lift_range(self) -> tuple[Floats, Floats]:
        """Least and largest lift, mm or rad: at the ends of pieces, which a law that overshoots has where it turns."""
        s = self.samples.s
        whole = self.moving * SAMPLES
        ends = np.concatenate([s[:whole:SAMPLES], s[SAMPLES - 1 : whole : SAMPLES], s[whole:]])
        return ends.min(axis=0), ends.max(axis=0)

    @property
    def top_share(self) -> Floats:
        """Share of the turn in which the follower rests at its largest lift."""
        top = np.max(np.broadcast_arrays(*(one for leg in self.legs for one in (leg.before, leg.after))), axis=0)
        rest = [((leg.before == top) & (leg.after == top)) * leg.width for leg in self.legs]
        return np.asarray(np.sum(np.broadcast_arrays(*rest), axis=0) / TURN)

    @property
    def stroke(self) -> Floats:
        """Between the ends of segments, mm or rad."""
        ends = np.broadcast_arrays(*(one for leg in self.legs for one in (leg.before, leg.after)))
        return np.asarray(np.max(ends, axis=0) - np.min(ends, axis=0))


def vertex(low: Floats, mid: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Place (-1 to 1) and value of the largest of a parabola through three even samples, ends included."""
    slope, bend = 0.5 * (high - low), low - 2.0 * mid + high
    # Where it does not bend down, or by less than it slopes, an end has the largest value.
    steep = np.maximum(np.maximum(-bend, np.abs(slope)), float(np.finfo(bend.dtype).tiny))
    at = slope / steep
    return at, mid + at * (slope + 0.5 * at * bend)


def nearer(values: Floats, at: Floats, step: Ints, reach: Ints) -> tuple[Mask, Ints, Ints]:
    """Whether three values (3, ...) at a reach, fine steps, about places have to be laid again, and where and how near:
    where the vertex `at` of their parabola lies beyond them, then no further apart than REACH, and nearer where it is
    steep."""
    beyond = np.abs(at) >= 1.0
    moved = np.clip(step + np.rint(at * reach).astype(np.intp), reach, FINE - reach)
    further = beyond & (moved != step)
    steep = (reach > NEAR) & (values[1] - np.minimum(values[0], values[2]) > STEEP * np.abs(values[1]))
    closer = np.where(reach > REACH, np.where(further, reach, REACH), np.where(steep & ~further, NEAR, reach))
    moved = np.clip(step + np.rint(at * reach).astype(np.intp), closer, FINE - closer)
    return (closer < reach) | further, moved, closer


def top_row(values: Floats) -> Ints:
    """Rows (n,) of the largest of values (k, ..., n), the first of those that are alike: as `argmax` over the first
    axis, which takes seven times as long of few rows."""
    best, top = values[0].copy(), np.zeros(values.shape[1:], dtype=np.int16)
    for k in range(1, len(values)):
        np.maximum(top, np.multiply(values[k] > best, np.int16(k), dtype=np.int16), out=top)
        np.maximum(best, values[k], out=best)
    return top.astype(np.intp)


def _highest(values: Floats) -> tuple[Ints, Floats, Floats]:
    """Of even samples (K, m, n) of pieces or halves the fine step of the largest value, by parabolas through the
    largest sample and its neighbours, the height there, and how far that may be off: four times what a parabola can
    stand above its samples, nothing at the end of a piece, where there is a sample; (K, n) each."""
    last, size = values.shape[1] - 1, values.shape[2]
    spacing = FINE // (SAMPLES - 1)
    top, one = np.clip(top_row(values.swapaxes(0, 1)), 1, last - 1), np.arange(size)
    flat, middle = values.reshape(-1), ((last + 1) * np.arange(len(values))[:, None] + top) * size + one
    low, mid, high = (flat.take(middle + k * size) for k in (-1, 0, 1))
    at, height = vertex(low, mid, high)
    place, bend = top + at, np.abs(low - 2.0 * mid + high)
    # Beside an end a peak may stand higher above its samples than the largest sample is.
    for beside in (1, last - 1):
        low, mid, high = (values[:, beside + k] for k in (-1, 0, 1))
        at, other = vertex(low, mid, high)
        higher = np.nonzero(other > height)
        place[higher], height[higher] = beside + at[higher], other[higher]
        bend[higher] = np.abs(low - 2.0 * mid + high)[higher]
    step = np.clip(np.rint(place * spacing).astype(np.intp), REACH, last * spacing - REACH)
    return step, height, np.where((place <= 0.0) | (place >= last), 0.0, 0.5 * bend)


ORDERS = ("velocity", "acceleration", "jerk")


def motion_figures(unit: str, per: str) -> tuple[str, ...]:
    """Names of the peaks of the motion, by the cam angle (`rad`) or by time (`s`)."""
    return tuple(f"motion.peak_{word}_{unit}_per_{per}{power}" for word, power in zip(ORDERS, ("", "2", "3")))


def motion_of(variants: Variants, cuts: tuple[float, ...] = (), busy: bool = False) -> Motion:
    """The motion of the variants; what is wrong with one goes to its refusals."""
    profile = variants.profile
    unit = radians(1.0) if profile.rotating else 1.0
    if joined(profile.motion):
        return Motion(fixed_legs(profile), variants.size, cuts, busy)
    found, refusals = [], variants.refusals
    angle, position = np.zeros(1), np.zeros(1)
    last = len(profile.motion) - 1
    half = profile.cam.MOTION_SPAN < 360.0
    for i in range(last + 1):
        refusals.add(variants.number(f"motion[{i}].until") > 360.0, f"motion[{i}].until: out of range")
    for i, segment in enumerate(profile.motion):
        until = np.radians(variants.number(f"motion[{i}].until"))
        refusals.add(until - angle < LEAST_WIDTH, f"motion[{i}].until: each segment must end after the one before it")
        turn = profile.cam.MOTION_SPAN
        if i == last:
            word = "the last segment must end the stated half turn" if half else "the last segment must end the turn"
            refusals.add(np.abs(until - radians(turn)) > ANGLE_SLIP, f"motion[{i}].until: {word}")
            until = np.array([radians(turn)])
        elif not half:
            refusals.add(until > TURN - LEAST_WIDTH, f"motion[{i}].until: only the last segment may end the turn")
        reached = position if segment.to is None else unit * variants.number(f"motion[{i}].to")
        refusals.add(np.abs(reached) > MOST_LIFT, f"motion[{i}].to: no such position")
        end = np.maximum(until, angle + LEAST_WIDTH)
        found.append(Leg(shape_of(segment), angle, end, position, reached, reached - position))
        angle, position = found[-1].end, reached
    if half:
        found += [
            Leg(leg.shape, leg.start + np.pi, leg.end + np.pi, position - leg.before, position - leg.after, -leg.lift)
            for leg in found
        ]
    elif program_of(profile).closed:
        most = np.max(np.broadcast_arrays(*(np.abs(leg.after) for leg in found)), axis=0)
        refusals.add(np.abs(position) > 1e-9 * most, f"motion[{last}].to: the program must end where it began")
    return Motion(tuple(found), variants.size, cuts, busy)


