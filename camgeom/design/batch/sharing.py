"""How rollers of an indexing cam share the torque, of many variants: pressures and forces where they are largest."""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING, final
from weakref import proxy

import numpy as np

from camgeom.design.batch import LEVELS
from camgeom.design.batch.legs import FINE
from camgeom.design.batch.motion import SAMPLES, Ints, Points
from camgeom.design.batch.variants import Mask
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.hertz import flexibility
from camgeom.mechanics.load import QUIET
from camgeom.track.turret import SLICES

if TYPE_CHECKING:
    from camgeom.design.batch.indexer import Held, Indexer, Seat

THIN = 2
"""of so many samples of the motion one is taken where rollers are surveyed"""
PER = (SAMPLES - 1) // THIN + 1
"""samples of a piece then"""
STEP = FINE // (PER - 1)
"""fine steps between two of them"""
TURNS = 3
"""times that flexibilities and slice loads are computed in turn"""
EFFORTS = {LEVELS[0]: (4, 5, 12), LEVELS[1]: (8, 9, 16)}
"""by level of the pressures: parts of a step between samples in which a largest one is looked for; places about it;
halvings of the distance of two samples between which a roller comes to bear"""
NEAR = 6
"""fine steps to either side of a largest pressure that are computed once more"""


@final
@immutable
class Pressed:
    """What the load does: squares of the largest pressures of all and of the middle slice, MPa², the largest force on a
    roller, N, each (n,); and whether no roller bears somewhere."""

    square: Floats
    middle: Floats
    force: Floats
    lost: Mask


@final
class Sharing:
    """The rollers of n variants under their torque."""

    def __init__(self, cam: Indexer) -> None:
        self.cam: Indexer = proxy(cam)
        self.finer, self.around, self.halvings = EFFORTS[cam.level]

    def press(
        self, points: Points, offsets: Floats, surveyed: bool = False
    ) -> tuple[Floats, Floats, Floats, Mask, tuple[Mask, ...]]:
        """Squares of the largest pressures of all slices and of the middle one, MPa², and the largest force on a
        roller, N, (P, n) each; whether no roller bears; which do, and where it is asked whose middle slice, (k, P, n).

        Rollers at `offsets` (k,) share by their levers, as if all slices were alike flexible.

        surveyed  whether the points are those of the cam, whose walls are known
        """
        size, torque, shape = self.cam.motion.size, self.cam.torque(points), (len(points.s), self.cam.motion.size)
        side = np.broadcast_to(self.cam.pushing * np.copysign(1.0, torque), shape)
        roller, sample, seat, held = self._held_at(points, offsets, side, surveyed)
        # From here on only rollers that bear, (N,).
        row, variant = np.nonzero(held[2])
        each = row * size + variant
        cam, place, seat = self.cam.of(variant), sample[row] * size + variant, seat.flat(each, size)
        begin, stop, side = held[0].reshape(-1)[each], held[1].reshape(-1)[each], side.reshape(-1)[place]
        cover = (stop - begin) / 6.0
        ends = [cam.lever(seat, delta) for delta in (begin, 0.5 * (begin + stop), stop)]
        first = cover * (ends[0] + 4.0 * ends[1] + ends[2])
        second = cover * (ends[0] ** 2 + 4.0 * ends[1] ** 2 + ends[2] ** 2)

        def largest(values: Floats) -> Floats:
            found = np.zeros(shape[0] * size)
            np.maximum.at(found, place, values)
            return found.reshape(shape)

        total = np.bincount(place, second, shape[0] * size).reshape(shape)
        scale = np.divide(np.abs(torque), total, out=np.zeros_like(total), where=total > 0.0)
        squares = np.maximum(*(_square(cam, seat, end, side) for end in (begin, stop)))
        scaled = scale / (pi * self.cam.pair)
        middle, holds = np.zeros(1), [held[2]]
        if "middle" in self.cam.asked:
            low, high = _inner(cam, begin, stop)
            there = np.where(low < high, _square(cam, seat, 0.5 * (low + high), side), 0.0)
            squares = np.maximum(squares, there)
            middle = largest(there) * scaled
            holds.append(np.zeros_like(held[2]))
            holds[1].reshape(-1)[each] = low < high
        lost = (total <= 0.0) & (np.abs(torque) > QUIET * self.cam.most_torque)
        bearing = np.zeros((len(holds), len(offsets), *shape), dtype=bool)
        for which, hold in zip(bearing, holds):
            which[roller, sample] = hold
        return largest(squares) * scaled, middle, largest(first) * scale, lost, tuple(bearing)

    def _held_at(
        self, points: Points, offsets: Floats, side: Floats, surveyed: bool
    ) -> tuple[Ints, Ints, Seat, Held]:
        """Which rollers at offsets are beside the cam at which points, (m,), as they stand there, and what the walls on
        the sides (P, n) have of them."""
        if surveyed:
            found = self.cam.surveyed
            walls, forth = self.cam.walls[False], side[found.sample] > 0.0
            begin, stop, on = (np.where(forth, one, other) for one, other in zip(walls[1.0], walls[-1.0]))
            return found.every, found.sample, found.seat, (begin, stop, on)
        roller, sample = np.nonzero(self.cam.beside(points, offsets, self.cam.clear))
        seat = self.cam.seat(points.of(sample), offsets[roller][:, None])
        return roller, sample, seat, self.cam.held(seat, side[sample], self.cam.touched)

    def share(self, points: Points, offsets: Floats) -> tuple[Floats, Floats, Floats]:
        """The same three with slices that approach alike by their own flexibility, as the exact model has them."""
        torque, shape = self.cam.torque(points), points.s.shape
        side = np.where(torque >= 0.0, self.cam.pushing, -self.cam.pushing)
        held = self.cam.held(self.cam.seat(points, offsets[:, None, None]), side, self.cam.touched)
        # From here on only rollers that bear, (N,), and their slices, both ends of what touches among them.
        roller, row, variant = np.nonzero(held[2])
        cam, place = self.cam.of(variant), row * shape[1] + variant
        near, side, size = points.flat(place, shape[1]), side.reshape(-1)[place], np.abs(torque).reshape(-1)
        begin, stop = (end.reshape(len(offsets), -1)[roller, place] for end in held[:2])
        edges = cam.low + (cam.length / SLICES) * np.arange(SLICES + 1.0)[:, None]
        first = np.concatenate([begin[None], np.maximum(begin, edges[:-1]), stop[None]])
        last = np.concatenate([begin[None], np.minimum(stop, edges[1:]), stop[None]])
        cover, bears = np.maximum(last - first, 0.0), last > first
        bears[[0, -1]] = True
        line = cam.line(cam.seat(near, offsets[roller]), 0.5 * (first + last))
        turned = cam.roller * cam.roller * line.twist2
        k = (1.0 + turned) / (cam.roller * (1.0 - cam.roller * side * line.bend - turned))
        k = np.where(k > 0.0, k, 1.0 / cam.roller)

        def together(weights: Floats) -> Floats:
            """The torque over the sum of weights of all slices of the rollers that share it, (N,)."""
            sum_ = np.bincount(place, weights.sum(axis=0), len(size))
            return np.asarray(np.divide(size, sum_, out=np.zeros_like(sum_), where=sum_ > 0.0)[place])

        def largest(values: Floats) -> Floats:
            found = np.zeros(len(size))
            np.maximum.at(found, place, values)
            return found.reshape(shape)

        weight, pressing = cover * line.lever, k / (pi * cam.pair)
        load = np.broadcast_to(together(weight), cover.shape)
        least = np.maximum(1e-6 * load, 1e-30)
        # The flexibility is linear in the logarithm of 4 r over the half-width.
        poisson = cam.variants.number("material.cam.poisson")
        still, more = (flexibility(far, far, *cam.compliances, poisson) for far in (np.zeros(1), np.ones(1)))
        more, widest = more - still, np.log(2.0 * cam.roller)
        for _ in range(TURNS):
            far = widest - 0.5 * np.log(np.maximum(load, least) * cam.pair / (pi * k))
            stiff = line.lever / (still + more * far)
            load = stiff * together(weight * stiff)
        load = np.where(bears, load, 0.0)
        square = load * pressing
        return largest(square.max(axis=0)), largest(square[1 + SLICES // 2]), largest((load * cover).sum(axis=0))

    @cached_property
    def pressed(self) -> Pressed:
        """The contact under load: sampled, then where rollers come and go and about the largest values, at last with
        the flexibility of every slice."""
        motion, one = self.cam.motion, np.arange(self.cam.motion.size)
        offsets = self.cam.offsets(self.cam.clear)
        *sampled, lost, bearing = self.press(self.cam.points, offsets, surveyed=True)
        wanted = [n for n, word in enumerate(("slice", "middle", "force")) if word in self.cam.asked]
        whole = motion.moving * PER
        tops = {n: np.broadcast_to(sampled[n], lost.shape)[:whole].argmax(axis=0) for n in wanted}
        windows = [(top // PER, top % PER * STEP) for top in {top.tobytes(): top for top in tops.values()}.values()]
        around = np.arange(-STEP, STEP + 1, STEP // self.finer)[:, None]
        tried = [(np.broadcast_to(piece, (len(around), motion.size)), np.clip(step + around, 0, FINE).astype(float))
                 for piece, step in windows]
        comings: dict[bool, slice] = {}
        for middle, holds in enumerate(bearing):
            if coming := self._comings(holds, offsets, bool(middle)):
                begun = sum(len(part[1]) for part in tried)
                comings[bool(middle)] = slice(begun, begun + len(coming[1]))
                tried.append(coming)
        pieces, steps = (np.concatenate(part) for part in zip(*tried))
        found, near = [np.zeros(1)] * 3, np.linspace(-NEAR, NEAR, self.around)[:, None]
        again = self.press(motion.at(pieces, steps), offsets)
        for n in wanted:
            values: Floats = np.broadcast_to(again[n], steps.shape)
            best = values.argmax(axis=0)
            # Slices are not alike flexible: the largest in truth may be the next one of the samples, or stand on either
            # side of the two comings that press hardest.
            other = _second(np.broadcast_to(sampled[n], lost.shape)[:whole], tops[n])
            more = [values[: len(windows) * len(around)].argmax(axis=0)]
            if where := comings.get(n == 1):
                more += _sides(values[where], where.start)
            piece = np.concatenate([np.broadcast_to(pieces[best, one], (len(near), motion.size)),
                                    pieces[np.array(more), one], (other // PER)[None]])  # fmt: skip
            step = np.concatenate([np.clip(steps[best, one] + near, 0.0, FINE), steps[np.array(more), one],
                                   (other % PER * float(STEP))[None]])  # fmt: skip
            shared = self.share(motion.at(piece, step), offsets)[n]
            found[n] = np.broadcast_to(shared, step.shape).max(axis=0)
        return Pressed(found[0], found[1], found[2], np.asarray(lost.any(axis=0)))

    def _comings(self, bearing: Mask, offsets: Floats, middle: bool) -> tuple[Ints, Floats] | None:
        """Where rollers, or their middle slices, come to bear or cease to, on either side of it: pieces and fine steps
        (t, n).

        bearing  which of the rollers at `offsets`, (k,), bear so at the samples, (k, P, n)
        """
        motion = self.cam.motion
        v = bearing[:, : motion.moving * PER].reshape(len(bearing), motion.moving, PER, motion.size)
        places: list[Ints] = []
        rollers: list[float] = []
        comes: list[bool] = []
        for roller, row in enumerate(v):
            for comes_on in (True, False):
                change = (row[:, 1:] & ~row[:, :-1]) if comes_on else (row[:, :-1] & ~row[:, 1:])
                flat = change.reshape(-1, motion.size)
                # On either wall in turn: the first and the last.
                first, last = flat.argmax(axis=0), len(flat) - 1 - flat[::-1].argmax(axis=0)
                several = flat.any(axis=0) & (last > first)
                for at in (first, last) if several.any() else (first,):
                    if flat.any():
                        places.append(at)
                        rollers.append(offsets[roller])
                        comes.append(comes_on)
        if not places:
            return None
        piece, sample = np.divmod(np.array(places), PER - 1)
        low = sample * float(STEP)
        high = low + STEP
        at, coming = np.array(rollers)[:, None], np.array(comes)[:, None]
        for _ in range(self.halvings):
            between = 0.5 * (low + high)
            points = motion.at(piece, between)
            side = np.where(self.cam.torque(points) >= 0.0, self.cam.pushing, -self.cam.pushing)
            begin, stop, on = self.cam.held(self.cam.seat(points, at), side, self.cam.touched)
            if middle:
                first, last = _inner(self.cam, begin, stop)
                on &= first < last
            on = on == coming
            low, high = np.where(on, low, between), np.where(on, between, high)
        return np.concatenate([piece, piece]), np.concatenate([low, high])


def _inner(cam: Indexer, begin: Floats, stop: Floats) -> tuple[Floats, Floats]:
    """Ends of what the middle slice touches, mm, of stretches; none where the second is not beyond the first."""
    share = cam.length / SLICES
    inner = cam.low + share * (SLICES // 2)
    return np.maximum(inner, begin), np.minimum(inner + share, stop)


def _square(cam: Indexer, seat: Seat, delta: Floats, side: Floats) -> Floats:
    """Lever times relative curvature of the wall on a side at places along the rollers."""
    line = cam.line(seat, delta)
    turned = cam.roller * cam.roller * line.twist2
    rest = 1.0 - cam.roller * side * line.bend - turned
    rest = np.where(np.abs(rest) > 1e-12, rest, 1e-12)
    return np.asarray(line.lever * (1.0 + turned) / (cam.roller * rest))


def _second(values: Floats, top: Ints) -> Ints:
    """Place (n,) of the largest of values (P, n) that is no neighbour of the largest of all, at `top` (n,)."""
    away = np.abs(np.arange(len(values))[:, None] - top) > 1
    return np.asarray(np.where(away, values, -1.0).argmax(axis=0))


def _sides(values: Floats, begun: int) -> list[Ints]:
    """Places (n,) of both sides of the two comings with the largest values (2 m, n), all first sides before all second
    ones; counted from `begun`."""
    half, one = len(values) // 2, np.arange(values.shape[1])
    largest = np.maximum(values[:half], values[half:])
    first = largest.argmax(axis=0)
    largest[first, one] = -1.0
    return [begun + at + side for at in (first, largest.argmax(axis=0)) for side in (0, half)]
