"""Plates of parallel indexers, of many variants: where each wall begins and ends, as `track.sweep` finds it for one.

A plate is what all rollers of its ring leave of a disc. A point of the edge of a roller's band is a wall where it is in
the disc and under no roller: that is asked at samples of the edges against samples of the paths; where it changes, the
crossing of the two exact curves, or of one with the rim, is found by Newton's method. From wall to wall the outline of
the piece that holds the shaft is followed, beginning where a roller comes nearest to it. A variant of which that cannot
be told (a wall shorter than the samples are apart) is looked at again with more of them, and is then left open.

Lengths mm, angles rad; the plane is complex and turns with a cam that turns counter-clockwise: the other way round is
a mirror image. With tau a roller's angle from the line of centres its middle is exp(-i phi) (C - rf exp(-i tau)).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import ceil, floor
from typing import TypeVar, cast, final

import numpy as np
from numpy.typing import NDArray

from camgeom.design.batch.legs import FINE
from camgeom.design.batch.motion import Ints, Motion, Points, single
from camgeom.design.batch.variants import Mask
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.motion.program import TURN

INNER: tuple[float, ...] = (-1.0,)
"""sides of the bands towards the cam's axis: all walls of most plates are there"""
BOTH: tuple[float, ...] = (-1.0, 1.0)
MOVING, RESTING = 44.0, 52.0
"""samples of a law, and of a turn spent in a dwell"""
LEAST = 4
"""samples of a piece"""
MORE = 8
"""samples that are put where a path turns most, in a round"""
EFFORTS = ((INNER, 1.0, 0), (BOTH, 1.0, 5), (BOTH, 2.0, 12))
"""sides of the bands, times as many samples, and rounds of more of them, which are tried in turn"""
AT_ONCE = 1024
"""variants whose paths are sampled at once"""
BLOCK = 32
"""variants of which every sample is held against every other at once: the distances stay in the cache"""
NEAREST, APART = 0.1, 0.3
"""rad within which the nearest place of a path is believed beside its sample, and by which it is not the edge's own"""
SMALL = 60_000
"""distances that are computed by one product: of larger ones the algebra library makes a thread's work each"""
UNDER = 2e-5
"""share of a roller's square by which it must reach over a point to cover it"""
SHARP, ROUND = 0.5, 0.3
"""rad by which a path may turn between two samples of a wall of which this share of the roller's radius is its bend"""
NEWTON = 5
NEAR_RIM = 0.1
"""share of the disc's radius within which two ends that were sought on its rim may be one corner inside"""
HALVINGS, NEAREST_OF = 18, 3
"""of the distance of two samples where that loses its way, and steps to the nearest place of a path in each"""
MOST_STEP = 0.15
"""rad by which Newton's method moves at most in a step"""
MET = 1e-6
"""share of the disc's radius within which two ends of walls are one corner"""

Plane = NDArray[np.complex128]
S = TypeVar("S", bound=np.generic)


@final
@immutable
class Ring:
    """The rollers of one ring of n variants, numbers (n,): angle of the first from the line of centres, their pitch,
    the turret's advance in a turn of the cam, the circle of their middles, their tool's radius, the disc's radius."""

    motion: Motion
    base: float
    pitch: float
    advance: float
    centre: Floats
    circle: Floats
    tool: Floats
    rim: Floats

    def of(self, rows: Ints) -> Ring:
        """That of these variants, each as often as it is named."""
        return replace(
            self, motion=self.motion.of(rows),
            **{name: getattr(self, name)[rows] for name in ("centre", "circle", "tool", "rim")},
        )  # fmt: skip

    @property
    def rough(self) -> Ring:
        """In single precision, but for the motion."""
        return replace(self, centre=single(self.centre), circle=single(self.circle), tool=single(self.tool),
                       rim=single(self.rim))  # fmt: skip

    @property
    def paths(self) -> int:
        """Number of different paths."""
        return max(1, round(self.advance / self.pitch))

    def moved(self, points: Points, tau: Floats) -> tuple[Plane, Plane, Floats]:
        """Middles of rollers in the machine's frame, their velocity in the cam, and the curvature of their paths there,
        left positive."""
        turned, rate = np.exp(-1j * tau), 1.0 + points.ds
        arm = self.circle * turned
        velocity = 1j * (rate * arm - self.centre)
        bend = (rate * rate + 1j * points.dds) * arm - self.centre
        pace = np.maximum(np.abs(velocity), 1e-12)
        return self.centre - arm, velocity, (np.conj(velocity) * bend).imag / (pace * pace * pace)

    def jet(self, path: Ints, phi: Floats) -> tuple[Plane, Plane, Floats]:
        """Middles of rollers on paths (n,) at cam angles (n,), their velocities, and curvatures there."""
        points = self.motion.whenever(phi[None])
        tau = points.s + self.base + path * self.pitch + self.advance * np.floor(phi / TURN)
        at, velocity, bend = self.moved(points, tau)
        turned = np.exp(-1j * phi)
        return at[0] * turned, velocity[0] * turned, bend[0]

    def edge(self, path: Ints, side: Floats, phi: Floats) -> tuple[Plane, Plane]:
        """Points of the edges of bands at cam angles phi (n,), and their derivatives."""
        at, velocity, bend = self.jet(path, phi)
        reach = side * self.tool
        return at + reach * 1j * velocity / np.maximum(np.abs(velocity), 1e-12), velocity * (1.0 - reach * bend)


def vars_of(points: Points) -> tuple[Floats, ...]:
    """All that points are."""
    return points.theta, points.s, points.ds, points.dds, points.side


@final
@immutable
class Walls:
    """Walls of plates of n variants.

    each  (4, E, n): angle of their rollers from the line of centres at zero lift in the first turn, side of the band,
          and the cam angles, counted through all turns, between which they touch; none where the last is not beyond
    open  (n,) where the outline could not be followed
    """

    each: Floats
    open: Mask

    def of(self, rows: Ints) -> Walls:
        """Those of these variants."""
        return Walls(self.each[:, :, rows], self.open[rows])

    def mirrored(self, even: Floats, advance: float) -> Walls:
        """Those of the plate that is this one's mirror image, of a motion that is even about half of a cam angle (n,);
        advance: of the turret in a turn of the cam."""
        shift, side, low, high = self.each
        there = high > low
        return Walls(np.stack([-shift - advance, side, np.where(there, even - high, 0.0),
                               np.where(there, even - low, 0.0)]), self.open)  # fmt: skip

    def with_rows(self, rows: Ints, others: Walls) -> Walls:
        """The same with others in place of those of some variants."""
        most = max(self.each.shape[1], others.each.shape[1])
        each, still = _padded(self.each, most), self.open.copy()
        each[:, :, rows], still[rows] = _padded(others.each, most), others.open
        return Walls(each, still)


def side_by_side(parts: Sequence[Walls]) -> Walls:
    """Those of variants one after the other."""
    most = max(one.each.shape[1] for one in parts)
    every = np.concatenate([_padded(one.each, most) for one in parts], axis=2)
    return Walls(every, np.concatenate([one.open for one in parts]))


def _padded(each: Floats, rows: int) -> Floats:
    return np.concatenate([each, np.zeros((4, rows - each.shape[1], each.shape[2]))], axis=1)


def walls(ring: Ring) -> Walls:
    """The walls of a plate of every variant."""
    size = ring.motion.size
    found = side_by_side([_traced(ring.of(np.arange(k, min(k + AT_ONCE, size))), *EFFORTS[0])
                          for k in range(0, size, AT_ONCE)])  # fmt: skip
    for effort in EFFORTS[1:]:
        rows = np.flatnonzero(found.open)
        if not rows.size:
            break
        found = found.with_rows(rows, _traced(ring.of(rows), *effort))
    return found


@final
@immutable
class Sampled:
    """Samples of the paths, (n, paths, L): cam angles through all turns, and in single precision middles, velocities
    and curvature in the cam's frame."""

    phi: Floats
    middle: Plane
    velocity: Plane
    bend: Floats


def _sampled(ring: Ring, finer: float) -> Sampled:
    """The paths while some roller of some variant may be over its disc."""
    motion, paths = ring.motion, ring.paths
    order = sorted(range(len(motion.rows)), key=lambda i: motion.rows[i][:2])
    pieces, steps = list[int](), list[float]()
    for i in order:
        leg, low, high = motion.rows[i]
        rests = motion.legs[leg].shape.dwells
        share = RESTING * float((motion.legs[leg].width).max()) / TURN if rests else MOVING
        count = max(LEAST, ceil(finer * share * (high - low)))
        pieces += [i] * count
        steps += [FINE * (k + 0.5) / count for k in range(count)]
    piece = np.broadcast_to(np.array(pieces)[:, None], (len(pieces), motion.size))
    points = motion.at(piece, np.array(steps)[:, None])
    clear = ring.rim + ring.tool
    cosine = (ring.centre**2 + ring.circle**2 - clear * clear) / (2.0 * ring.centre * ring.circle)
    limit = float(np.arccos(np.clip(cosine, -1.0, 1.0)).max())
    first = floor((-limit - ring.advance - ring.base) / ring.pitch / paths)
    last = ceil((limit - ring.base) / ring.pitch / paths)
    turns = np.arange(first, last + 1.0)
    offset = ring.base + ring.pitch * np.arange(paths)[:, None] + ring.advance * turns
    flat = paths, len(turns) * len(pieces), motion.size
    tau = (points.s + offset[:, :, None, None]).reshape(flat)
    # Before the first roller comes over its disc and after the last has left there is nothing to see.
    over = np.flatnonzero((np.abs(tau) <= limit).any(axis=(0, 2)))
    kept = slice(max(int(over[0]) - 1, 0), int(over[-1]) + 2)
    place = np.arange(flat[1])[kept] % len(pieces)
    theta = np.broadcast_to(points.theta, points.s.shape)[place]
    at, velocity, bend = ring.rough.moved(points.of(place).rough, single(tau[:, kept]))
    phi = np.broadcast_to(theta + TURN * np.repeat(turns, len(pieces))[kept, None], at.shape)
    turned = cast(Plane, np.exp(-1j * theta).astype(np.complex64))
    return Sampled(_by_variant(phi), _by_variant(at * turned), _by_variant(velocity * turned), _by_variant(bend))


def _by_variant(values: NDArray[S]) -> NDArray[S]:
    """Values (paths, L, n) as (n, paths, L)."""
    return np.ascontiguousarray(np.moveaxis(values, 2, 0))


def _bent(ring: Ring, on: Sampled, rounds: int) -> Sampled:
    """The same with more samples where paths turn most between two: where a roller almost stands still in the cam its
    path turns on the spot, and its whole end, half round it, is touched within a hundredth of a turn."""
    for _ in range(rounds):
        near = np.abs(on.middle) < (ring.rim + ring.tool)[:, None, None]
        turn = np.abs(np.angle(on.velocity[:, :, 1:] * np.conj(on.velocity[:, :, :-1])))
        turn = np.where(near[:, :, 1:] | near[:, :, :-1], -turn, 0.0)
        place = np.argpartition(turn, MORE, axis=2)[:, :, :MORE]
        middle = 0.5 * (on.phi[:, :, 1:] + on.phi[:, :, :-1])
        phi = np.take_along_axis(middle, place, axis=2)
        variant, path = (one.reshape(-1) for one in np.indices(phi.shape)[:2])
        at, velocity, bend = ring.of(variant).jet(path, phi.reshape(-1))
        order = np.argsort(np.concatenate([on.phi, phi], axis=2), axis=2, kind="stable")

        def sorted_in(values: NDArray[S], more: NDArray[S], order: Ints = order) -> NDArray[S]:
            more = more.reshape((*values.shape[:2], -1)).astype(values.dtype, copy=False)
            return np.take_along_axis(np.concatenate([values, more], axis=2), order, axis=2)

        on = Sampled(sorted_in(on.phi, phi), sorted_in(on.middle, at), sorted_in(on.velocity, velocity),
                     sorted_in(on.bend, bend))  # fmt: skip
    return on


def _covering(ring: Ring, on: Sampled, x: Plane) -> Ints:
    """Number of the sample (of all paths of a variant) whose roller reaches farthest over edge points, (n, sides,
    paths, L); of samples that no roller over the disc can be near any."""
    size, _, paths, length = x.shape
    middle, points = on.middle.reshape(size, -1), x.reshape(size, -1)
    near = np.flatnonzero((np.abs(middle) < (ring.rim + ring.tool)[:, None]).any(axis=0))
    there = np.flatnonzero((np.abs(points) <= ring.rim[:, None]).any(axis=0))
    own = there % (paths * length)
    itself = np.where(own[:, None] == near, np.float32(1e12), np.float32(0.0))
    found, step = np.zeros(points.shape, dtype=np.intp), max(1, SMALL // max(len(near), 1))
    for begin in range(0, size, BLOCK):
        rows = slice(begin, begin + BLOCK)
        p, c = points[rows][:, there], middle[rows][:, near]
        one, two = np.ones_like(p.real), np.ones_like(c.real)
        left = np.stack([p.real, p.imag, p.real**2 + p.imag**2, one], axis=2)
        right = np.stack([-2.0 * c.real, -2.0 * c.imag, two, c.real**2 + c.imag**2], axis=1)
        for first in range(0, len(there), step):
            part = slice(first, first + step)
            square = left[:, part] @ right
            square += itself[part]
            found[rows, there[part]] = near[square.argmin(axis=2)]
    return found.reshape(x.shape)


@final
@immutable
class _Bands:
    """Edges of the bands at the samples, (n, sides, paths, L).

    far, inside     distance from the cam's axis, mm, and whether that is on the disc
    folded          whether the edge runs backwards
    covered, over   whether a roller covers it, and the sample of the roller that reaches farthest over it
    about, hand     where on its path that roller reaches farthest, rad, and on which side of the path the edge is then
    """

    on: Sampled
    sides: tuple[float, ...]
    far: Floats
    inside: Mask
    folded: Mask
    covered: Mask
    over: Ints
    about: Floats
    hand: Floats

    @property
    def free(self) -> Mask:
        """Where the edges are walls, (n, sides and paths, L)."""
        size, *_, length = self.far.shape
        return np.asarray((self.inside & ~self.folded & ~self.covered).reshape(size, -1, length))


def _bands(ring: Ring, on: Sampled, sides: tuple[float, ...]) -> _Bands:
    """The edges on these sides."""
    ring = ring.rough
    way, size = single(np.array(sides))[None, :, None, None], ring.motion.size
    middle, velocity, bend = (one[:, None] for one in (on.middle, on.velocity, on.bend))
    tool, rim = ring.tool[:, None, None, None], ring.rim[:, None, None, None]
    pace = np.maximum(np.abs(velocity), 1e-12)
    x: Plane = np.asarray(middle + way * tool * 1j * velocity / pace)
    length, paths = x.shape[3], x.shape[2]
    far, over = np.abs(x), _covering(ring, on, x)
    flat = over.reshape(size, -1)

    def picked(values: NDArray[S]) -> NDArray[S]:
        return np.take_along_axis(values.reshape(size, -1), flat, axis=1).reshape(x.shape)

    # From the nearest sample of a path to its nearest place.
    off, forth, curved, ahead = x - picked(on.middle), picked(on.velocity), picked(on.bend), picked(on.phi)
    along = (np.conj(forth) * off).real
    quick = np.maximum(np.abs(forth), 1e-12)
    across = (np.conj(forth) * off).imag / quick
    stiff = quick * quick * (1.0 - curved * across)
    step = np.where(stiff > 0.0, along / np.where(stiff > 0.0, stiff, 1.0), 0.0)
    same = over // length == np.arange(paths)[:, None]
    step = np.where((np.abs(step) < NEAREST) & ~(same & (np.abs(ahead + step - on.phi[:, None]) < APART)), step, 0.0)
    covered = np.abs(off) ** 2 - along * step < tool * tool * (1.0 - UNDER)
    return _Bands(on, sides, far, far <= rim, way * tool * bend >= 1.0, covered, over, ahead + step, np.sign(across))


@final
@immutable
class _Edges:
    """Runs of samples at which an edge is a wall, (E,), variant by variant: row of sides and paths, first and last
    sample.

    shape  (n, sides and paths, L)
    """

    shape: tuple[int, int, int]
    variant: Ints
    row: Ints
    begin: Ints
    last: Ints

    @cached_property
    def first(self) -> Ints:
        """Number of each variant's first one, (n,)."""
        return np.asarray(np.searchsorted(self.variant, np.arange(self.shape[0])))

    def table(self, values: NDArray[S], empty: complex) -> NDArray[S]:
        """Values (E,) by variant and the rank among its own."""
        rank = np.arange(len(self.variant)) - self.first[self.variant]
        whole = np.full((self.shape[0], int(rank.max(initial=-1)) + 1), empty, dtype=values.dtype)
        whole[self.variant, rank] = values
        return whole

    def nearest(self, far: Floats) -> Ints:
        """Rank of the edge of every variant, (n,), that comes nearest to the axis: at these distances, (n, ...)."""
        size, rows, length = self.shape
        position, place = self.row * length + self.begin, far.reshape(size, -1).argmin(axis=1)
        # The last one that begins before the place.
        every = self.variant * (rows * length) + position
        rank = np.searchsorted(every, np.arange(size) * (rows * length) + place, "right") - 1 - self.first
        return np.asarray(np.maximum(rank, 0))


def _edges(free: Mask) -> _Edges:
    size, rows, length = free.shape
    padded = np.zeros((size, rows, length + 2), dtype=bool)
    padded[:, :, 1:-1] = free
    variant, row, begin = np.nonzero(padded[:, :, 1:] & ~padded[:, :, :-1])
    _, _, end = np.nonzero(padded[:, :, :-1] & ~padded[:, :, 1:])
    return _Edges((size, rows, length), variant, row, begin, end - 1)


def _traced(ring: Ring, sides: tuple[float, ...], finer: float, rounds: int) -> Walls:
    """The walls by samples; open where the corners do not meet."""
    on = _bent(ring, _sampled(ring, finer), rounds)
    bands = _bands(ring, on, sides)
    free = bands.free
    edges, size = _edges(free), ring.motion.size
    side, path = np.array(sides)[edges.row // ring.paths], edges.row % ring.paths
    phi, point, on_rim = _ended(ring, bands, edges)
    # An edge is travelled with the material on its left.
    half, forth = len(side), side > 0.0
    one = np.arange(half)
    go, come = np.where(forth, one + half, one), np.where(forth, one, one + half)

    def ends() -> tuple[Plane, Plane, Mask, Mask]:
        return (edges.table(point[go], np.nan), edges.table(point[come], np.nan), edges.table(on_rim[go], False),
                edges.table(on_rim[come], False))  # fmt: skip

    which, p, q = np.nonzero(_before_rim(*ends(), ring.rim)) if half else np.zeros((3, 0), dtype=np.intp)
    if which.size:
        p, q = go[edges.first[which] + p], come[edges.first[which] + q]
        paths, hands = np.tile(path, 2), np.tile(side, 2)
        at, psi, x, met = _meet(ring.of(which), paths[p], hands[p], phi[p], paths[q], hands[q], phi[q])
        met &= (np.abs(at - phi[p]) < APART) & (np.abs(psi - phi[q]) < APART)
        for rows, values in ((p[met], at[met]), (q[met], psi[met])):
            phi[rows], point[rows], on_rim[rows] = values, x[met], False
        point[p[~met]] = np.nan
    low, high = phi[:half], phi[half:]
    point = np.where(np.tile(high <= low, 2), np.nan, point)
    start = edges.nearest(np.where(free, bands.far.reshape(free.shape), np.inf))
    chain = _followed(*ends(), start, ring.rim, on.middle.reshape(size, -1), ring.tool)
    chain &= ~_sharp(ring, bands, free)[:, None]
    every = [np.where(chain, edges.table(one, 0.0), 0.0).T for one in (ring.base + ring.pitch * path, side, low, high)]
    return Walls(np.array(every), np.asarray(~chain.any(axis=1)))


def _ended(ring: Ring, bands: _Bands, edges: _Edges) -> tuple[Floats, Plane, Mask]:
    """Cam angles of the beginnings of edges and then of their ends, (2 E,), the points, NaN where none was found, and
    whether they are on the rim."""
    on, sides, length = bands.on, np.array(bands.sides), edges.shape[2]
    twice, row = np.tile(edges.variant, 2), np.tile(edges.row, 2)
    side, path = sides[row // ring.paths], row % ring.paths
    within = np.concatenate([edges.begin, edges.last])
    beyond = np.clip(np.concatenate([edges.begin - 1, edges.last + 1]), 0, length - 1)
    edge = _Ends(ring.of(twice), path, side, on.phi[twice, path, within], on.phi[twice, path, beyond])
    which = (twice, row // ring.paths, path, beyond)
    crossed, hand, about = bands.covered[which], bands.hand[which], bands.about[which]
    by, inside = bands.over[which] // length % ring.paths, bands.inside[which]
    # Where its edge folds a band crosses itself beyond the fold.
    itself = bands.folded[which] & ~crossed & inside
    by, hand = np.where(itself, path, by), np.where(itself, side, hand)
    about = np.where(itself, 2.0 * edge.beyond - edge.within, about)
    phi, point, on_rim, stray = edge.solved(~inside, crossed | itself, by, about, hand)
    if len(sides) == 1:
        stray |= crossed & ~on_rim & (hand != sides[0])
    return phi, np.where(stray | (within == beyond), np.nan, point), on_rim


def _sharp(ring: Ring, bands: _Bands, free: Mask) -> Mask:
    """Whether a path turns sharply round a wall between two samples of it, (n,): the band may cross itself there,
    unseen."""
    velocity, way = bands.on.velocity, np.array(bands.sides)[:, None, None]
    turn = np.abs(np.angle(velocity[:, :, 1:] * np.conj(velocity[:, :, :-1])))
    bent = (way * ring.tool[:, None, None, None] * bands.on.bend[:, None] > ROUND).reshape(free.shape)
    there = (bent[:, :, 1:] | bent[:, :, :-1]) & free[:, :, 1:] & free[:, :, :-1]
    return np.asarray((np.tile(turn, (1, len(bands.sides), 1)) * there).max(axis=(1, 2)) > SHARP)


def _before_rim(goes: Plane, comes: Plane, leaves: Mask, enters: Mask, rim: Floats) -> Mask:
    """Ends of edges and beginnings of others, (n, E, E), near each other and not one corner, of which one or both were
    sought on the rim: they may meet before it."""
    near = NEAR_RIM * rim[:, None, None]
    gap = np.abs(goes[:, :, None] - comes[:, None, :])
    behind = np.angle(comes[:, None, :] * np.conj(goes[:, :, None])) < 0.0
    both, either = leaves[:, :, None] & enters[:, None, :], leaves[:, :, None] | enters[:, None, :]
    return np.asarray((gap < near) & (gap > MET * rim[:, None, None]) & np.where(both, behind, either))


def _meet(
    cams: Ring, path: Ints, side: Floats, phi: Floats, other: Ints, across: Floats, psi: Floats
) -> tuple[Floats, Floats, Plane, Mask]:
    """Cam angles at which edges cross, by Newton's method, the points, and whether they do so within the disc."""
    for _ in range(NEWTON):
        (x, d), (y, e) = cams.edge(path, side, phi), cams.edge(other, across, psi)
        det, miss = -(np.conj(d) * e).imag, y - x
        safe = np.where(np.abs(det) > 1e-9 * np.abs(d) * np.abs(e) + 1e-300, det, np.inf)
        phi = phi + np.clip(-(np.conj(miss) * e).imag / safe, -MOST_STEP, MOST_STEP)
        psi = psi + np.clip((np.conj(d) * miss).imag / safe, -MOST_STEP, MOST_STEP)
    (x, _), (y, _) = cams.edge(path, side, phi), cams.edge(other, across, psi)
    met = (np.abs(y - x) <= 0.1 * MET * cams.rim) & (np.abs(x) <= cams.rim * (1.0 + MET))
    return phi, psi, x, np.asarray(met)


def _followed(
    goes: Plane, comes: Plane, leaves: Mask, enters: Mask, start: Ints, rim: Floats, middle: Plane, tool: Floats
) -> Mask:
    """Which edges (n, E) the outline has that begins with `start` (n,); none where it does not close.

    goes, comes     points at which the travel of an edge ends and begins, (n, E)
    leaves, enters  whether that is on the rim
    middle, tool    of rollers, (n, Q), and their radius: none may stand over the rim between an edge and the next one
    """
    size, most = goes.shape
    if not most:
        return np.zeros((size, 0), dtype=bool)
    gap = np.abs(goes[:, :, None] - comes[:, None, :])
    ahead = np.angle(comes)[:, None, :] - np.angle(goes)[:, :, None]
    gap = np.where(np.isfinite(gap) & ~enters[:, None, :], gap, np.inf)
    turn = np.where(np.isfinite(ahead) & enters[:, None, :], np.mod(ahead, TURN), np.inf)
    beside = np.where(leaves, turn.argmin(axis=2), gap.argmin(axis=2))
    joined = np.where(leaves, np.isfinite(turn.min(axis=2)), gap.min(axis=2) <= MET * rim[:, None])
    # A wall that was not found must not be passed over: its roller stands in between.
    over, azimuth = np.abs(np.abs(middle) - rim[:, None]) < 0.9 * tool[:, None], np.angle(middle)
    for k in range(most):
        arc = np.where(leaves[:, k], turn[:, k].min(axis=1), 0.0)[:, None]
        rows = np.mod(azimuth - np.angle(goes[:, k])[:, None], TURN) < arc
        joined[:, k] &= ~(rows & over).any(axis=1)
    chain = np.zeros((size, most), dtype=bool)
    here, going, closed, one = start, np.ones(size, dtype=bool), np.zeros(size, dtype=bool), np.arange(size)
    for _ in range(most):
        chain[one[going], here[going]] = True
        going &= joined[one, here]
        here = np.where(going, beside[one, here], here)
        closed |= going & (here == start)
        going &= ~chain[one, here]
    return np.asarray(chain & closed[:, None])


def _under(cams: Ring, x: Plane, path: Ints, near: Floats) -> tuple[Mask, Floats, Floats]:
    """Whether rollers on paths cover points (n,), the cam angles nearby at which they reach farthest over them, and on
    which side of the paths the points are."""
    for _ in range(NEAREST_OF):
        at, velocity, bend = cams.jet(path, near)
        off, quick = x - at, np.maximum(np.abs(velocity), 1e-12)
        stiff = quick * quick - bend * quick * (np.conj(velocity) * off).imag
        move = (np.conj(velocity) * off).real / np.where(stiff > 0.0, stiff, np.inf)
        near = near + np.clip(move, -NEAREST, NEAREST)
    off = x - cams.jet(path, near)[0]
    return np.abs(off) < cams.tool * (1.0 - 0.5 * UNDER), near, np.sign((np.conj(velocity) * off).imag)


@final
@immutable
class _Ends:
    """Ends of edges, (N,), each of a variant of its own: on the edge of a path's band on a side, between a cam angle at
    which it is a wall and one at which it is none."""

    cams: Ring
    path: Ints
    side: Floats
    within: Floats
    beyond: Floats

    def solved(
        self, outside: Mask, covered: Mask, other: Ints, about: Floats, across: Floats
    ) -> tuple[Floats, Plane, Mask, Mask]:
        """Cam angles of the ends, their points, whether they are on the rim, and whether none was found.

        other, about, across  the path that covers the edge, where thereabouts, and with which side
        """
        phi = 0.5 * (self.within + self.beyond)
        point, rim = np.zeros(len(phi), dtype=np.complex128), np.zeros(len(phi), dtype=bool)
        stray = np.ones(len(phi), dtype=bool)
        rows = np.flatnonzero(covered)
        if rows.size:
            at, x, met = self._crossings(rows, outside[rows], other[rows], about[rows], across[rows])
            phi[rows], point[rows], stray[rows] = at, x, ~met
        rows = np.flatnonzero(outside & stray)
        if rows.size:
            at, x, met = self._on_rim(rows)
            phi[rows], point[rows], stray[rows], rim[rows] = at, x, ~met, met
        return phi, point, rim, stray

    def _between(self, rows: Ints, phi: Floats) -> Mask:
        """Whether cam angles are between those of the samples, or a little beyond."""
        step = self.beyond[rows] - self.within[rows]
        share = (phi - self.within[rows]) / np.where(step == 0.0, 1.0, step)
        return np.asarray((share > -1.0) & (share < 1.5))

    def _crossings(
        self, rows: Ints, outside: Mask, other: Ints, psi: Floats, across: Floats
    ) -> tuple[Floats, Plane, Mask]:
        """Where edges cross the other's edge: by Newton's method alone, else from where the other's rollers cover it.
        """
        cams, path, side = self.cams.of(rows), self.path[rows], self.side[rows]
        phi, _, x, met = _meet(cams, path, side, 0.5 * (self.within[rows] + self.beyond[rows]), other, across, psi)
        met &= self._between(rows, phi)
        # Where an edge comes to the rim uncovered there is none before it.
        some = np.flatnonzero(~met & outside)
        if some.size:
            _, at, found = self._on_rim(rows[some])
            outside[some] = found & ~_under(cams.of(some), at, other[some], psi[some])[0]
        some = np.flatnonzero(~met & ~outside)
        if some.size:
            about = cams.of(some)
            begun, psi, across = self._bisected(rows[some], about, path[some], side[some], other[some], psi[some])
            phi[some], _, x[some], met[some] = _meet(about, path[some], side[some], begun, other[some], across, psi)
            met[some] &= self._between(rows[some], phi[some])
        return phi, x, met

    def _bisected(
        self, rows: Ints, cams: Ring, path: Ints, side: Floats, other: Ints, psi: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Near a crossing: cam angle, that of the roller that covers the edge there, and its side that does."""
        step = self.beyond[rows] - self.within[rows]
        free, under = self.within[rows] - step, self.beyond[rows]
        across = side
        for _ in range(HALVINGS):
            phi = 0.5 * (free + under)
            covered, near, hand = _under(cams, cams.edge(path, side, phi)[0], other, psi)
            psi, across = np.where(covered, near, psi), np.where(covered, hand, across)
            free, under = np.where(covered, free, phi), np.where(covered, phi, under)
        return 0.5 * (free + under), psi, across

    def _on_rim(self, rows: Ints) -> tuple[Floats, Plane, Mask]:
        cams, path, side = self.cams.of(rows), self.path[rows], self.side[rows]
        low, high = self.within[rows].copy(), self.beyond[rows].copy()
        phi = 0.5 * (low + high)
        for _ in range(NEWTON):
            x, d = cams.edge(path, side, phi)
            far = np.abs(x)
            inside = far <= cams.rim
            low, high = np.where(inside, phi, low), np.where(inside, high, phi)
            slope = (np.conj(x) * d).real / far
            fresh = phi - (far - cams.rim) / np.where(slope == 0.0, np.inf, slope)
            kept = (fresh - low) * (fresh - high) <= 0.0
            phi = np.where(kept, fresh, 0.5 * (low + high))
        x, _ = cams.edge(path, side, phi)
        return phi, x, np.abs(np.abs(x) - cams.rim) <= 0.1 * MET * cams.rim
