"""The worst case: where no machine whose errors keep within their sizes stands beyond, nor has more play.

At the cam angles that are sampled: between them a machine was found by up to 0.13 % beyond the largest.

On a wall that a load presses rigidly each error is added at every station as it hurts most. What stands in a balance,
or between its walls, is pressed by errors x within their sizes (-1 .. 1, a disc where they have any direction) with

    F(psi, x) = sum over what pushes k |L| [u]+ - sum over what holds k |L| [u]+ - load,     u = a + g x + L psi

and stands below psi where F < 0. With u in c - s .. c + s over all x, a push is at most the chord of [u]+ between these
ends (its concave envelope: McCormick, Math. Program. 10, 1976, 147) and a hold at least f u for any share f of 0 .. 1:

    F <= chords - sum f k |L| u - load, linear in x: its largest over all x is known, and the least of these of any f

is a bound, exact where no station leaves its wall or comes to it. The least psi is told at which it is below zero; f is
improved by what answers the hardest errors (fictitious play: Robinson, Ann. Math. 54, 1951, 296).

Arrays: n cam angles, p packed stations, i errors with one part, j with two, each roller's and wall's own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Self, final

import numpy as np
import numpy.typing as npt

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme
from camgeom.solid.mechanism import Drive
from camgeom.tolerance.causes import Cause
from camgeom.tolerance.directions import Rows
from camgeom.tolerance.ends import Ends
from camgeom.tolerance.samples import Spreads
from camgeom.tolerance.seat import Bools, Walls
from camgeom.tolerance.sensitivity import Seated, resting_at

ROUNDS = 40
"""of the search, at most: what it tells is a bound after any of them"""
CLOSE = 1e-6
"""share of the rigid bound to which it is found"""
ANSWERS = 2
"""of f in a round of the search"""


@final
@immutable
class Worst:
    """All errors within their sizes at once; mm or rad.

    curve  bound of the deviation over cam angles (n,); motion: its largest, dwell: in the dwells; backlash: largest
           play
    """

    curve: Floats
    motion: Extreme
    dwell: Extreme
    backlash: Extreme

    @classmethod
    def of(cls, seated: Seated, causes: Sequence[Cause], spreads: Spreads) -> Self:
        """Of errors that scatter so."""
        theta, mechanism = seated.contacts.theta, seated.of.mechanism
        still, curve = resting_at(mechanism.program, theta), farthest(seated, Within.of(seated, causes, spreads))
        if (ends := Ends.of(mechanism, seated.of.pivots)) is not None:
            curve = curve + ends.farther(theta, causes, spreads)
        play = loosest(seated, causes, spreads) if mechanism.drive is not Drive.ALONE else np.zeros(len(curve))

        def largest(values: Floats) -> Extreme:
            at = int(np.argmax(values))
            return Extreme(float(values[at]), float(theta[at]))

        return cls(curve, largest(curve), *(largest(np.where(still, each, -1.0)) for each in (curve, play)))


@final
@immutable
class Within:
    """Errors within their sizes at cam angles: mean approaches (n, p), mm, and those of errors at their sizes with one
    part, (n, i, p), and with two, (n, 2, j, p)."""

    mean: Floats
    single: Floats
    double: Floats

    @classmethod
    def of(cls, seated: Seated, causes: Sequence[Cause], spreads: Spreads) -> Self:
        """Those of causes."""
        packed = seated.packed
        shape = packed.order.shape
        holders = {"roller": _numbered(packed.roller), "wall": _numbered(packed.wall)}
        mean, parts = np.zeros(shape), {1: list[Floats](), 2: list[Floats]()}
        for cause in causes:
            middle, value, _ = spreads[cause.key]
            g = packed.taken(seated.flat(seated.approaches.of(cause)))
            mean += middle * g[0]
            owner = holders.get(cause.holder, np.zeros(shape, dtype=np.intp))
            for one in range(int(owner.max()) + 1):
                parts[len(g)].append(value * g * (owner == one))
        single, double = (np.array(parts[k]).reshape(-1, k, *shape) for k in (1, 2))
        return cls(mean, np.ascontiguousarray(single[:, 0].transpose(1, 0, 2)),
                   np.ascontiguousarray(double.transpose(2, 1, 0, 3)))  # fmt: skip

    @property
    def size(self) -> Floats:
        """How much nearer than the mean they bring every station at most, mm, (n, p)."""
        both = np.hypot(self.double[:, 0], self.double[:, 1])
        return np.asarray(np.abs(self.single).sum(axis=1) + both.sum(axis=1))

    def rows(self, rows: Rows) -> Self:
        """Those at some of the cam angles."""
        return type(self)(self.mean[rows], self.single[rows], self.double[rows])

    def hardest(self, weight: Floats) -> tuple[Floats, Floats]:
        """Largest weighted sum (n,) of what they bring the stations nearer, weights (n, p), and how near that, (n, p).
        """
        single, double = self.single @ weight[..., None], self.double @ weight[:, None, :, None]
        far = np.hypot(double[:, 0], double[:, 1])
        way = np.divide(double, far[:, None], out=np.zeros_like(double), where=far[:, None] > 0.0)
        near = (np.sign(single).swapaxes(1, 2) @ self.single)[:, 0]
        near += (way.swapaxes(2, 3) @ self.double)[:, :, 0].sum(axis=1)
        return np.asarray(np.abs(single).sum(axis=(1, 2)) + far.sum(axis=(1, 2))), near


def _numbered(owner: npt.NDArray[np.intp]) -> npt.NDArray[np.intp]:
    """Owners of stations, (n, p), counted from 0 at each cam angle."""
    first = (owner[:, :, None] == owner[:, None, :]).argmax(axis=2)
    place = np.arange(owner.shape[1])
    counted = np.cumsum(first == place, axis=1) - 1
    return np.take_along_axis(counted, first, axis=1)


def loosest(seated: Seated, causes: Sequence[Cause], spreads: Spreads) -> Floats:
    """Largest play, (n,), that errors at their ends can open; it may be opened by several that do nothing alone."""
    packed = seated.packed
    mean, errors = np.zeros(packed.order.shape), []
    for cause in causes:
        middle, value, _ = spreads[cause.key]
        g = packed.taken(seated.flat(seated.approaches.of(cause)))
        mean += middle * g[0]
        errors.append((value * g, {"roller": packed.roller, "wall": packed.wall}.get(cause.holder)))
    return np.maximum(packed.walls.parted(mean, errors), 0.0)


def farthest(seated: Seated, within: Within) -> Floats:
    """How far from its nominal stand, (n,), mm or rad, no machine's follower goes beyond."""
    walls, base = seated.packed.walls, seated.nominal
    bounds = [walls.bounds(within.mean + way * within.size) for way in (-1.0, 1.0)]
    behind, beyond = (
        np.max([np.abs(one - end) for one in ends], axis=0) for ends, end in zip(zip(*bounds), (base.low, base.high))
    )
    if walls.drive is Drive.ALONE:
        return np.asarray(behind)
    side = walls.load_side
    found = np.where(side > 0.0, behind, beyond)
    stands = (side == 0.0) | (walls.drive is Drive.SHARED)
    found[stands] = 0.0
    loaded = replace(walls, load=np.where(side == 0.0, 0.0, walls.load))
    for way, near, far in ((1.0, base.low, base.high), (-1.0, base.high, base.low)):
        for start, last, asked in ((far, True, stands), (near, False, stands & (near != far))):
            rows = np.flatnonzero(asked)
            if len(rows):
                reached = _reached(loaded.rows(rows), within.rows(rows), start[rows], way, last)
                found[rows] = np.maximum(found[rows], reached)
    return np.asarray(found)


def _reached(walls: Walls, within: Within, start: Floats, way: float, last: bool) -> Floats:
    """How far beyond start (n,), one way, no machine's follower stands, (n,), at least 0.

    last: the last place that its walls leave it, else the first: apart where it is free between them
    """
    lever, rate = way * walls.lever, np.abs(walls.lever) * walls.stiffness
    pushes, holds, size = lever < 0.0, lever > 0.0, within.size
    nominal = np.where(rate > 0.0, walls.approach, 0.0) + within.mean + lever * (way * start)[:, None]
    share = np.full(rate.shape, 0.5)

    def over(moved: Floats) -> Floats:
        """Bound of what presses beyond the load, (n,); not below zero where a machine may stand as far as moved."""
        nonlocal share
        middle = nominal + lever * moved[:, None]
        top, bottom = middle + size, middle - size
        chord = np.clip(np.divide(top, 2.0 * size, out=(middle > 0.0).astype(float), where=size > 0.0), 0.0, 1.0)
        push = np.where(pushes, rate * np.where(bottom >= 0.0, 1.0, chord), 0.0)
        fixed = (push * np.where(bottom >= 0.0, middle, size)).sum(axis=1) - way * walls.load
        hold = np.where(holds, rate, 0.0)
        best, _ = told(fixed, push, hold * (bottom > 0.0), middle)
        for turn in range(ANSWERS):
            value, near = told(fixed, push, hold * share, middle)
            best = np.minimum(best, value)
            share += ((middle + near > 0.0) - share) / (turn + 2.0)
        return np.minimum(best, told(fixed, push, hold * share, middle)[0])

    def told(fixed: Floats, push: Floats, hold: Floats, middle: Floats) -> tuple[Floats, Floats]:
        value, near = within.hardest(push - hold)
        return value + fixed - (hold * middle).sum(axis=1), near

    def beyond(value: Floats) -> Bools:
        return np.asarray(value >= 0.0 if last else value > 0.0)

    reach = np.where(rate > 0.0, (size + np.abs(within.mean)) / np.abs(lever), 0.0).max(axis=1)
    least, most = np.zeros(len(start)), (1.0 + CLOSE) * reach
    at_least, at_most = over(least), over(most)
    most = np.where(beyond(at_least), most, 0.0)
    for turn in range(ROUNDS):
        if np.all(most - least <= CLOSE * reach):
            break
        part = np.divide(at_least, at_least - at_most, out=np.full(len(start), 0.5), where=at_least > at_most)
        at = least + np.clip(part, 0.02, 0.98) * (most - least) if turn % 3 else 0.5 * (least + most)
        value = over(at)
        further = beyond(value)
        least, at_least = np.where(further, at, least), np.where(further, value, 0.5 * at_least)
        most, at_most = np.where(further, most, at), np.where(further, 0.5 * at_most, value)
    return most
