"""Triangles of the lands between an indexing cam's grooves: all points of both rims, and a net of its own in between.

A land is part of a surface of revolution, unrolled to x (the angle on through the turns, rad) and w (along the
meridian), on which the sag of every chord is known in closed form. So its inner columns and rows are as far apart as
its own curvature allows, whatever the grooves beside it need. Beyond the cam's ends it goes on only as far as it takes
to cut it off there.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, sqrt

import numpy as np
import numpy.typing as npt

from camgeom.errors import CamgeomError
from camgeom.maths import Floats
from camgeom.solid.lands import Land
from camgeom.track import TURN

Index = npt.NDArray[np.int64]
TRIES = 10
FIRST = 0.6
"""height of the rows beside the rims, in rows"""
BEYOND = 0.02
"""most that a land goes on beyond the cam's ends, as a share of the cam's length"""


class NotOneSurface(CamgeomError):
    """The grooves and lands of a cam do not form one simple surface."""


@dataclass(frozen=True, eq=False)
class Edge:
    """A rim of a land: points (n,) at increasing x (rad), w, and their vertex numbers (-1: not yet numbered)."""

    x: Floats
    w: Floats
    number: Index

    def at(self, x: Floats) -> Floats:
        """w at any x, straight between the points, constant beyond them."""
        return np.interp(x, self.x, self.w)

    def turned(self, x0: float) -> Edge:
        """A closed rim (its last point is its first) from its point nearest to x0 once round to that point again."""
        near = (self.x[:-1] - x0 + 0.5 * TURN) % TURN - 0.5 * TURN
        k = int(np.argmin(np.abs(near)))
        x = np.roll(self.x[:-1], -k)
        x = x0 + near[k] + (x - x[0]) % TURN
        w, number = np.roll(self.w[:-1], -k), np.roll(self.number[:-1], -k)
        return Edge(np.append(x, x[0] + TURN), np.append(w, w[0]), np.append(number, number[0]))


@dataclass(frozen=True, eq=False)
class Strip:
    """A land between two rims (None: none before the cam's end) and the cam's ends in w."""

    land: Land
    lower: Edge | None
    upper: Edge | None
    ends: tuple[float, float]
    closed: bool

    def framed(self) -> tuple[Edge, Edge]:
        """Both rims over x from end to end or once round; a missing one as a circle far beyond its end."""
        given = [rim for rim in (self.lower, self.upper) if rim is not None]
        x0 = given[0].x[0] if self.closed else min(rim.x[0] for rim in given)
        x1 = x0 + TURN if self.closed else max(rim.x[-1] for rim in given)
        span = self.ends[1] - self.ends[0]
        rims = []
        for rim, far in ((self.lower, self.ends[0] - span), (self.upper, self.ends[1] + span)):
            if rim is None:
                rims.append(Edge(np.array([x0, x1]), np.array([far, far]), np.array([-1, -1])))
            else:
                rims.append(rim.turned(x0) if self.closed else rim)
        return rims[0], rims[1]


@dataclass(frozen=True, eq=False)
class Net:
    """A triangulated land: its new points x, w (v,), faces (f, 3) turning from x to w, and its largest sag, mm."""

    x: Floats
    w: Floats
    faces: Index
    sag: float


def land_net(strip: Strip, count: int, tolerance: float) -> Net:
    """Triangulate a land within the tolerance (mm); new points are numbered from `count` on.

    Raises NotOneSurface where its rims meet, or are too steep for such a net.
    """
    share = 0.96
    for _ in range(TRIES):
        net = _net(strip, count, share * tolerance)
        if net is not None and net.sag <= tolerance:
            return net
        share *= 0.92
    raise NotOneSurface("the rims of a land meet, or are too steep")


def _net(strip: Strip, count: int, aim: float) -> Net | None:
    """One attempt at chords with the sag `aim`; None where triangles overlap."""
    lower, upper = strip.framed()
    columns = _columns(strip, lower, upper, aim)
    pitch = _pitch(strip.land, aim)
    gap = min(0.5 * pitch, BEYOND * (strip.ends[1] - strip.ends[0]))
    low = _trimmed(lower, upper, columns, strip.ends[0], gap, 1.0, strip.closed)
    high = _trimmed(upper, lower, columns, strip.ends[1], gap, -1.0, strip.closed)
    start, width = low.at(columns), high.at(columns) - low.at(columns)
    on = (start < strip.ends[1]) & (start + width > strip.ends[0])
    rows = max(1, ceil(float(width[on].max(initial=0.0)) / pitch + 2.0 * (1.0 - FIRST)))
    # Beside a sloping rim chords are longer than the row is high, so the first and the last row are lower.
    share = (np.arange(1, rows) - 1.0 + FIRST) / (rows - 2.0 * (1.0 - FIRST))
    inner = start + width * share[:, None]
    x = np.concatenate([low.x, high.x, np.broadcast_to(columns, inner.shape).ravel()])
    w = np.concatenate([low.w, high.w, inner.ravel()])
    own = np.concatenate([low.number, high.number, np.full(inner.size, -1)])
    a, b = len(low.x), len(high.x)
    net = a + b + np.arange(inner.size).reshape(inner.shape)
    lows, highs = np.arange(a), a + np.arange(b)
    if rows == 1:
        faces = [_zipped(x, lows, highs)]
    else:
        faces = [_zipped(x, lows, net[0]), _zipped(x, net[-1], highs), _cells(strip.land, x, w, net)]
    every = np.concatenate(faces)
    every = every[(w[every].min(axis=1) < strip.ends[1]) & (w[every].max(axis=1) > strip.ends[0])]
    new = own < 0
    own[new] = count + np.arange(int(new.sum()))
    if strip.closed:
        own[[a - 1, a + b - 1]] = own[[0, a]]
        own[net[:, -1]] = own[net[:, 0]]
    sag = max(float(_sag(strip.land, x, w, every[:, k], every[:, k - 1]).max(initial=0.0)) for k in range(3))
    return Net(x[new], w[new], own[every], sag) if _turns(x, w, every) else None


def _pitch(land: Land, aim: float) -> float:
    """Length in w of a chord along the meridian with the sag `aim`; very large on a straight one."""
    unit = float(land.sag(np.zeros(1), np.ones(1), np.zeros(1))[0])
    return sqrt(aim / unit) if unit > 0.0 else 1e9


def _columns(strip: Strip, lower: Edge, upper: Edge, aim: float) -> Floats:
    """Places x of the inner columns, from the sag of chords round the axis."""
    w = np.linspace(*strip.ends, 9)
    step = sqrt(aim / float(strip.land.sag(np.ones(9), np.zeros(9), w).max()))
    x0, x1 = min(lower.x[0], upper.x[0]), max(lower.x[-1], upper.x[-1])
    if strip.closed:
        x0, x1 = lower.x[0], lower.x[0] + TURN
    return np.linspace(x0, x1, max(3, ceil((x1 - x0) / step)) + 1)


def _trimmed(rim: Edge, other: Edge, columns: Floats, end: float, gap: float, sign: float, closed: bool) -> Edge:
    """A rim without what lies beyond `end` (the lower end; sign -1: the upper one), where it runs on beside that end.

    Points with both neighbours beyond are left out; in their stead, and where the rim is not there, it runs at `gap`
    beyond the end and beyond the other rim, at the inner columns.
    """
    w, bound, last = sign * rim.w, sign * end, len(rim.x) - 1
    beyond = w < bound
    before, after = (beyond[-2], beyond[1]) if closed else (True, True)
    keep = ~(beyond & np.append(beyond[1:], after) & np.insert(beyond[:-1], 0, before))
    k = np.clip(np.searchsorted(rim.x, columns), 1, last)
    covered = keep[k - 1] & keep[k] & (columns >= rim.x[0]) & (columns <= rim.x[-1])
    if closed:
        covered[[0, -1]] = keep[0]
    there = sign * rim.at(columns)
    step = columns[1] - columns[0]
    least = np.minimum.reduce([sign * other.at(columns + shift) for shift in (-step, 0.0, step)])
    fill = np.where(there < bound, np.minimum(bound, least) - gap, there)[~covered]
    x = np.concatenate([rim.x[keep], columns[~covered]])
    order = np.argsort(x, kind="stable")
    number = np.concatenate([rim.number[keep], np.full(len(fill), -1)])
    return Edge(x[order], sign * np.concatenate([w[keep], fill])[order], number[order])


def _zipped(x: Floats, low: Index, high: Index) -> Index:
    """Triangles between two rows of vertices at increasing x; each joins those of the other row that are nearest."""
    key = np.concatenate([x[low[1:]] + x[low[:-1]], x[high[1:]] + x[high[:-1]]])
    is_low = np.argsort(key, kind="stable") < len(low) - 1
    i: Index = np.cumsum(is_low) - is_low
    j: Index = np.cumsum(~is_low) - ~is_low
    tip = np.where(is_low, low[np.minimum(i + 1, len(low) - 1)], high[np.minimum(j + 1, len(high) - 1)])
    return np.stack([low[i], tip, high[j]], axis=1)


def _cells(land: Land, x: Floats, w: Floats, net: Index) -> Index:
    """Two triangles a cell of the inner rows (k, q), along the diagonal with the smaller sag."""
    p00, p10, p11, p01 = net[:-1, :-1].ravel(), net[:-1, 1:].ravel(), net[1:, 1:].ravel(), net[1:, :-1].ravel()
    rising = _sag(land, x, w, p00, p11) <= _sag(land, x, w, p10, p01)
    first = np.stack([p00, p10, np.where(rising, p11, p01)], axis=1)
    second = np.stack([np.where(rising, p00, p10), p11, p01], axis=1)
    return np.concatenate([first, second])


def _sag(land: Land, x: Floats, w: Floats, a: Index, b: Index) -> Floats:
    return land.sag(x[b] - x[a], w[b] - w[a], 0.5 * (w[a] + w[b]))


def _turns(x: Floats, w: Floats, faces: Index) -> bool:
    """True where every triangle turns from x to w, so that none overlaps another."""
    a, b, c = faces.T
    return bool(np.all((x[b] - x[a]) * (w[c] - w[a]) > (x[c] - x[a]) * (w[b] - w[a])))
