"""The motion of many variants: on pieces with tables of the laws' jets, refined extremes, integrals.

Arrays are (P, n): P samples of the cam angle, n variants, so that a number of a variant meets all its samples and a
number of a law all the variants.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from math import radians
from typing import final

import numpy as np
from numpy.typing import NDArray

from camgeom.design.batch.legs import BESIDE, FINE, Leg, fixed_legs, joined, program_of, shape_of
from camgeom.design.batch.variants import Variants
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
STEEP = 1e-3
ROUNDS = 4


@final
@immutable
class Points:
    """The motion at samples: cam angle, rad, lift and derivatives per rad, each (P, n) or (P, 1).

    side  sign of the motion there, 0 in a dwell
    """

    theta: Floats
    s: Floats
    ds: Floats
    dds: Floats
    side: Floats

    def of(self, rows: Ints) -> Points:
        """These samples alone."""
        return Points(self.theta[rows], self.s[rows], self.ds[rows], self.dds[rows], self.side[rows])

    def flat(self, places: Ints, size: int) -> Points:
        """These places of (P size) alone, (N,)."""
        each = (self.theta, self.s, self.ds, self.dds, self.side)
        return Points(*(one.reshape(-1).take(places if one.shape[1] == size else places // size) for one in each))


FIXED = "rows", "order", "moving", "_table", "_places", "_one_leg"
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

    def _laid(self, values: Floats) -> Floats:
        """(K, samples of a piece, n) as samples (P, n): one of a piece that rests."""
        moving = values[: self.moving].reshape(-1, values.shape[2])
        middle = values.shape[1] // 2
        return np.concatenate([moving, values[self.moving :, middle]]) if self.moving < len(values) else moving

    def peak(self, values: Floats, beside: Ints | None = None) -> tuple[Ints, Ints]:
        """Where the largest of samples (P, n) lies: piece (n,) and fine step (n,), by parabolas through the best
        sample of every piece and its neighbours; of pieces other than `beside`, (n,) or (k, n)."""
        values = np.broadcast_to(values, (self.moving * SAMPLES + len(self.rows) - self.moving, self.size))
        v = values[: self.moving * SAMPLES].reshape(self.moving, SAMPLES, self.size)
        top = np.clip(v.argmax(axis=1), 1, SAMPLES - 2)
        at, best = vertex(*(np.take_along_axis(v, top[:, None] + k, axis=1)[:, 0] for k in (-1, 0, 1)))
        place = top + at
        # Beside an end a peak may stand higher above its samples than the largest sample is.
        for middle in (1, SAMPLES - 2):
            at, height = vertex(*(v[:, middle + k] for k in (-1, 0, 1)))
            place, best = np.where(height > best, middle + at, place), np.maximum(height, best)
        rest = values[self.moving * SAMPLES :]
        height, one = np.concatenate([best, rest]), np.arange(self.size)
        if beside is not None:
            height[beside, one] = -np.inf
        piece = height.argmax(axis=0)
        place = np.concatenate([place * (FINE // (SAMPLES - 1)), np.full(rest.shape, 0.5 * FINE)])[piece, one]
        return piece, np.clip(np.rint(place).astype(np.intp), REACH, FINE - REACH)

    def around(self, piece: Ints, step: Ints) -> Points:
        """The motion at three fine steps about places, (3, n)."""
        return self.at(piece, step + np.array([[-REACH], [0], [REACH]]))

    def piece(self, piece: Ints) -> Points:
        """The motion at the samples of one piece of every variant, (SAMPLES, n)."""
        return self.at(piece, np.arange(0, FINE + 1, FINE // (SAMPLES - 1))[:, None])

    @staticmethod
    def step_in(values: Floats) -> Ints:
        """The fine step (n,) of the largest of samples (SAMPLES, n) of a piece, by a parabola."""
        one = np.arange(values.shape[1])
        top = np.clip(values.argmax(axis=0), 1, SAMPLES - 2)
        place = top + vertex(*(values[top + k, one] for k in (-1, 0, 1)))[0]
        step = np.rint(place * (FINE // (SAMPLES - 1))).astype(np.intp)
        return np.asarray(np.clip(step, REACH, FINE - REACH), dtype=np.intp)

    @cached_property
    def _places(self) -> tuple[Floats, Floats, Floats]:
        """Of every piece: beginning and length in its leg's own travel, and the sign of the leg's shape, (K,) each."""
        low, high = (np.array([row[k] for row in self.rows]) for k in (1, 2))
        return low, high - low, np.sign(self._table[1, :, FINE // 2])

    @cached_property
    def _one_leg(self) -> int | None:
        """The leg of which all pieces that move are, if they are."""
        legs = {k for k, _, _ in self.rows[: self.moving]}
        return legs.pop() if len(legs) == 1 else None

    def at(self, piece: Ints, j: Ints | Floats) -> Points:
        """The motion at fine steps, or between them, (k, n) of pieces (n,) or (k, n)."""
        i = np.asarray(j, dtype=np.intp)
        flat = piece * (FINE + 1) + i
        tables = [one.reshape(-1) for one in self._table[:3]]
        f = [one.take(flat) for one in tables]
        if i is not j and (share := j - i).any():
            # The error of a chord is that of the step's square, 1e-7 of the piece's bend.
            flat += i < FINE
            f = [value + share * (one.take(flat) - value) for one, value in zip(tables, f)]
        low, span, sign = self._places
        place = low.take(piece) + span.take(piece) * np.clip(j / FINE, BESIDE, 1.0 - BESIDE)
        if self._one_leg is not None and piece.max(initial=0) < self.moving:
            leg = self.legs[self._one_leg]
            start, before, lift, width = leg.start, leg.before, leg.lift, leg.width
        else:
            start, before, lift, width = (one[piece, np.arange(self.size)] for one in self._of_legs)
        side = np.sign(lift) * sign.take(piece)
        rate = lift / width
        return Points(
            start + width * place, before + lift * f[0], rate * f[1], (rate / width) * f[2],
            np.broadcast_to(side, np.broadcast_shapes(side.shape, f[0].shape)),
        )  # fmt: skip

    @cached_property
    def _of_legs(self) -> tuple[Floats, ...]:
        """Of every piece's leg: start, lift before, lift, width, (K, n)."""
        legs = [self.legs[k] for k, _, _ in self.rows]
        each = ([leg.start for leg in legs], [leg.before for leg in legs], [leg.lift for leg in legs],
                [leg.width for leg in legs])  # fmt: skip
        return tuple(np.stack([np.broadcast_to(one, (self.size,)) for one in some]) for some in each)

    def whenever(self, theta: Floats) -> Points:
        """The motion at cam angles (k, n), rad, of any turn."""
        begin, long, *_ = self._columns
        at = np.mod(theta, TURN)
        place: Ints = np.zeros(at.shape, dtype=np.intp)
        for i in self.order[1:].tolist():
            place += at >= begin[i]
        piece = self.order.take(place)
        which = piece if begin.shape[2] == 1 else piece * self.size + np.arange(self.size)
        share = (at - begin.reshape(-1).take(which)) / long.reshape(-1).take(which)
        return self.at(piece, FINE * np.clip(share, 0.0, 1.0))

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

    def tops(self, values: Floats) -> list[tuple[Ints, Ints]]:
        """Where samples (P, n) are largest, as by `peak`: in the best pieces, the best first. Samples do not tell which
        of two that are nearly alike is larger, and both halves of a move may be alike."""
        found = [self.peak(values)]
        while len(found) < min(TOPS, len(self.rows)):
            found.append(self.peak(values, np.stack([piece for piece, _ in found])))
        return found

    def largest(self, again: Callable[[Points], Floats], values: Floats | None = None) -> Floats:
        """The largest of a quantity of points, (n,): sampled, and computed again near its largest samples."""
        places = self.tops(again(self.samples) if values is None else values)
        return np.asarray(np.max([self.laid(again, *place)[1] for place in places], axis=0))

    def top(
        self, again: Callable[[Points], Floats], values: Floats, beside: Ints | None = None
    ) -> tuple[Points, Floats, Floats]:
        """The same with three points (3, n) about its place, and the place between them, -1 to 1, (n,); of pieces
        other than `beside`.

        Returns points, value, place.
        """
        return self.laid(again, *self.peak(values, beside))

    def laid(self, again: Callable[[Points], Floats], piece: Ints, step: Ints) -> tuple[Points, Floats, Floats]:
        """The same from a place where the largest value is sought. The three points are laid again where it lies beyond
        them, and nearer where it is steep."""
        reach: Ints = np.full(self.size, REACH)
        for _ in range(ROUNDS):
            near = self.at(piece, step + reach * np.array([[-1], [0], [1]]))
            low, mid, high = np.broadcast_to(again(near), (3, self.size))
            at, value = vertex(low, mid, high)
            steep = (reach > NEAR) & (mid - np.minimum(low, high) > STEEP * np.abs(mid))
            closer = np.where(steep, NEAR, reach)
            moved = np.clip(step + np.rint(at * reach).astype(np.intp), closer, FINE - closer)
            again_ = steep | ((np.abs(at) >= 1.0) & (moved != step))
            if not again_.any():
                break
            step, reach = np.where(again_, moved, step), closer
        return near, value, at

    def smallest(self, again: Callable[[Points], Floats], values: Floats | None = None) -> Floats:
        """The smallest, likewise."""
        return -self.largest(lambda points: -again(points), None if values is None else -values)

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
        """Least and largest lift, mm or rad; inside a law that overshoots at the turning point that its pieces have."""
        s = self.samples.s
        return s.min(axis=0), s.max(axis=0)

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


LEAST = 1e-200


def vertex(low: Floats, mid: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Place (-1 to 1) and value of the largest of a parabola through three even samples, ends included."""
    slope, bend = 0.5 * (high - low), low - 2.0 * mid + high
    # Where it does not bend down the larger end has the largest value: a step far beyond it, held there.
    at = np.clip(np.divide(slope, np.maximum(-bend, LEAST)), -1.0, 1.0)
    return at, mid + at * (slope + 0.5 * at * bend)


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


