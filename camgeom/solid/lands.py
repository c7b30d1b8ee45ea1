"""Lands between grooves: the outside surfaces they lie on, and the triangles between two rims.

Unrolled, a surface of revolution about Z is a plane: the polar angle psi about Z (or x, on through the turns), and w
along the meridian. There the sag of every chord is known in closed form, so that the inner columns and rows of a land
are as far apart as its own curvature allows, whatever the grooves beside it need; the triangles take all points of both
rims and a net of their own in between. Beyond the cam's ends a land goes on only as far as it takes to cut it off.
"""

from __future__ import annotations

from math import asin, ceil, sqrt
from typing import Protocol

import numpy as np

from camgeom.errors import CamgeomError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.solid.blank import Blank
from camgeom.solid.builder import Index
from camgeom.track import TURN
from camgeom.track.column import CylinderLevel

TRIES = 10
FIRST = 0.6
"""height of the rows beside the rims, in rows"""
BEYOND = 0.02
"""most that a land goes on beyond the cam's ends, as a share of the cam's length"""


@immutable(eq=True)
class GloboidLevel:
    """Field of the globoid of `radius` about a turret axis at `centre` from the cam axis: positive outside the cam."""

    centre: float
    radius: float

    def __call__(self, x: Floats) -> Floats:
        """Radius - distance of the meridian point from the turret centre, mm."""
        rho = np.sqrt(x[0] * x[0] + x[1] * x[1]) - self.centre
        return np.asarray(self.radius - np.sqrt(rho * rho + x[2] * x[2]))


class LandSurface(Protocol):
    """The outside of a blank of revolution as a surface with coordinates."""

    @property
    def level(self) -> GloboidLevel | CylinderLevel:
        """Its level field."""

    def along(self, x: Floats) -> Floats:
        """The coordinate w of points (3, ...)."""

    def points(self, psi: Floats, w: Floats) -> Floats:
        """Points (3, ...) at polar angle psi (rad) and w."""

    def at_height(self, z: float) -> float:
        """The w at height z (mm)."""

    def sag(self, psi: Floats, w: Floats, middle: Floats) -> Floats:
        """How far the middle of short chords lies off the surface, mm: steps in psi and in w, and w half way."""


@immutable(eq=True)
class GloboidLand:
    """A globoid: w is the angle (rad) about the turret axis from the line across both axes."""

    level: GloboidLevel

    def along(self, x: Floats) -> Floats:
        """w (rad) of points (3, ...)."""
        return np.asarray(np.arctan2(x[2], self.level.centre - np.sqrt(x[0] * x[0] + x[1] * x[1])))

    def points(self, psi: Floats, w: Floats) -> Floats:
        """Points (3, ...) at polar angle psi (rad) and w (rad)."""
        rho = self.level.centre - self.level.radius * np.cos(w)
        return np.stack([rho * np.cos(psi), rho * np.sin(psi), self.level.radius * np.sin(w)])

    def at_height(self, z: float) -> float:
        """w (rad) at height z (mm)."""
        return asin(z / self.level.radius)

    def sag(self, psi: Floats, w: Floats, middle: Floats) -> Floats:
        """Sag of short chords, mm: bent outward round the axis, inward along the meridian."""
        cosine, radius = np.cos(middle), self.level.radius
        return np.asarray(np.abs(radius * w * w - (self.level.centre - radius * cosine) * cosine * psi * psi) / 8.0)


@immutable(eq=True)
class CylinderLand:
    """A cylinder about Z: w is the height (mm)."""

    level: CylinderLevel

    def along(self, x: Floats) -> Floats:
        """w (mm) of points (3, ...)."""
        return np.asarray(x[2])

    def points(self, psi: Floats, w: Floats) -> Floats:
        """Points (3, ...) at polar angle psi (rad) and w (mm)."""
        radius = self.level.radius
        return np.stack([radius * np.cos(psi), radius * np.sin(psi), w])

    def at_height(self, z: float) -> float:
        """w (mm) at height z (mm)."""
        return z

    def sag(self, psi: Floats, w: Floats, middle: Floats) -> Floats:
        """Sag of short chords, mm."""
        del w, middle
        return np.asarray(self.level.radius * psi * psi / 8.0)


def land_of(blank: Blank, edge: int) -> GloboidLand | CylinderLand | None:
    """The surface of one outline edge of a blank; None where it is neither a cylinder nor a globoid about z = 0."""
    (r0, z0), (r1, _) = blank.outline[edge : edge + 2]
    arc = blank.arcs[edge] if blank.arcs else None
    if arc is None:
        return CylinderLand(CylinderLevel(r0)) if r0 == r1 else None
    if arc[1] != 0.0 or arc[0] <= max(r0, r1):
        return None
    return GloboidLand(GloboidLevel(arc[0], float(np.hypot(r0 - arc[0], z0))))


class NotOneSurface(CamgeomError):
    """The grooves and lands of a cam do not form one simple surface."""


@immutable
class Rim:
    """A rim of a land: points (n,) at increasing x (rad), w, and their vertex numbers (-1: not yet numbered)."""

    x: Floats
    w: Floats
    number: Index

    def at(self, x: Floats) -> Floats:
        """w at any x, straight between the points, constant beyond them."""
        return np.interp(x, self.x, self.w)

    def turned(self, x0: float) -> Rim:
        """A closed rim (its last point is its first) from its point nearest to x0 once round to that point again."""
        near = (self.x[:-1] - x0 + 0.5 * TURN) % TURN - 0.5 * TURN
        k = int(np.argmin(np.abs(near)))
        x = np.roll(self.x[:-1], -k)
        x = x0 + near[k] + (x - x[0]) % TURN
        w, number = np.roll(self.w[:-1], -k), np.roll(self.number[:-1], -k)
        return Rim(np.append(x, x[0] + TURN), np.append(w, w[0]), np.append(number, number[0]))


@immutable
class Land:
    """A land between two rims (None: none before the cam's end) and the cam's ends in w."""

    surface: LandSurface
    lower: Rim | None
    upper: Rim | None
    ends: tuple[float, float]
    closed: bool

    def framed(self) -> tuple[Rim, Rim]:
        """Both rims over x from end to end or once round; a missing one as a circle far beyond its end."""
        given = [rim for rim in (self.lower, self.upper) if rim is not None]
        x0 = given[0].x[0] if self.closed else min(rim.x[0] for rim in given)
        x1 = x0 + TURN if self.closed else max(rim.x[-1] for rim in given)
        span = self.ends[1] - self.ends[0]
        rims = []
        for rim, far in ((self.lower, self.ends[0] - span), (self.upper, self.ends[1] + span)):
            if rim is None:
                rims.append(Rim(np.array([x0, x1]), np.array([far, far]), np.array([-1, -1])))
            else:
                rims.append(rim.turned(x0) if self.closed else rim)
        return rims[0], rims[1]


@immutable
class LandNet:
    """A triangulated land: its new points x, w (v,), faces (f, 3) turning from x to w, and its largest sag, mm."""

    x: Floats
    w: Floats
    faces: Index
    sag: float


def land_net(land: Land, count: int, tolerance: float) -> LandNet:
    """Triangulate a land within the tolerance (mm); new points are numbered from `count` on.

    Raises NotOneSurface where its rims meet, or are too steep for such a net.
    """
    share = 0.96
    for _ in range(TRIES):
        net = _net(land, count, share * tolerance)
        if net is not None and net.sag <= tolerance:
            return net
        share *= 0.92
    raise NotOneSurface("the rims of a land meet, or are too steep")


def _net(land: Land, count: int, aim: float) -> LandNet | None:
    """One attempt at chords with the sag `aim`; None where triangles overlap."""
    lower, upper = land.framed()
    columns = _columns(land, lower, upper, aim)
    pitch = _pitch(land.surface, aim)
    gap = min(0.5 * pitch, BEYOND * (land.ends[1] - land.ends[0]))
    low = _trimmed(lower, upper, columns, land.ends[0], gap, 1.0, land.closed)
    high = _trimmed(upper, lower, columns, land.ends[1], gap, -1.0, land.closed)
    start, width = low.at(columns), high.at(columns) - low.at(columns)
    on = (start < land.ends[1]) & (start + width > land.ends[0])
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
        faces = [_zipped(x, lows, net[0]), _zipped(x, net[-1], highs), _cells(land.surface, x, w, net)]
    every = np.concatenate(faces)
    every = every[(w[every].min(axis=1) < land.ends[1]) & (w[every].max(axis=1) > land.ends[0])]
    new = own < 0
    own[new] = count + np.arange(int(new.sum()))
    if land.closed:
        own[[a - 1, a + b - 1]] = own[[0, a]]
        own[net[:, -1]] = own[net[:, 0]]
    sag = max(float(_sag(land.surface, x, w, every[:, k], every[:, k - 1]).max(initial=0.0)) for k in range(3))
    return LandNet(x[new], w[new], own[every], sag) if _turns(x, w, every) else None


def _pitch(land: LandSurface, aim: float) -> float:
    """Length in w of a chord along the meridian with the sag `aim`; very large on a straight one."""
    unit = float(land.sag(np.zeros(1), np.ones(1), np.zeros(1))[0])
    return sqrt(aim / unit) if unit > 0.0 else 1e9


def _columns(land: Land, lower: Rim, upper: Rim, aim: float) -> Floats:
    """Places x of the inner columns, from the sag of chords round the axis."""
    w = np.linspace(*land.ends, 9)
    step = sqrt(aim / float(land.surface.sag(np.ones(9), np.zeros(9), w).max()))
    x0, x1 = min(lower.x[0], upper.x[0]), max(lower.x[-1], upper.x[-1])
    if land.closed:
        x0, x1 = lower.x[0], lower.x[0] + TURN
    return np.linspace(x0, x1, max(3, ceil((x1 - x0) / step)) + 1)


def _trimmed(rim: Rim, other: Rim, columns: Floats, end: float, gap: float, sign: float, closed: bool) -> Rim:
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
    return Rim(x[order], sign * np.concatenate([w[keep], fill])[order], number[order])


def _zipped(x: Floats, low: Index, high: Index) -> Index:
    """Triangles between two rows of vertices at increasing x; each joins those of the other row that are nearest."""
    key = np.concatenate([x[low[1:]] + x[low[:-1]], x[high[1:]] + x[high[:-1]]])
    is_low = np.argsort(key, kind="stable") < len(low) - 1
    i: Index = np.cumsum(is_low) - is_low
    j: Index = np.cumsum(~is_low) - ~is_low
    tip = np.where(is_low, low[np.minimum(i + 1, len(low) - 1)], high[np.minimum(j + 1, len(high) - 1)])
    return np.stack([low[i], tip, high[j]], axis=1)


def _cells(land: LandSurface, x: Floats, w: Floats, net: Index) -> Index:
    """Two triangles a cell of the inner rows (k, q), along the diagonal with the smaller sag."""
    p00, p10, p11, p01 = net[:-1, :-1].ravel(), net[:-1, 1:].ravel(), net[1:, 1:].ravel(), net[1:, :-1].ravel()
    rising = _sag(land, x, w, p00, p11) <= _sag(land, x, w, p10, p01)
    first = np.stack([p00, p10, np.where(rising, p11, p01)], axis=1)
    second = np.stack([np.where(rising, p00, p10), p11, p01], axis=1)
    return np.concatenate([first, second])


def _sag(land: LandSurface, x: Floats, w: Floats, a: Index, b: Index) -> Floats:
    return land.sag(x[b] - x[a], w[b] - w[a], 0.5 * (w[a] + w[b]))


def _turns(x: Floats, w: Floats, faces: Index) -> bool:
    """True where every triangle turns from x to w, so that none overlaps another."""
    a, b, c = faces.T
    return bool(np.all((x[b] - x[a]) * (w[c] - w[a]) > (x[c] - x[a]) * (w[b] - w[a])))
