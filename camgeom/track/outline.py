"""Closed plane curves of planar cams: exact points, outward normals and signed curvature over the cam angle.

A planar cam's outline is the envelope of its follower: the parallel curve of the pitch curve (roller, mushroom), the
envelope of a line (flat face: support function), or the pitch curve itself (knife edge). Curvature is positive where
the outline is convex.
"""

from __future__ import annotations

from math import acos
from typing import Protocol

import numpy as np

from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats, gauss_rule
from camgeom.maths.extremum import piece_grid
from camgeom.maths.frozen import cached_property
from camgeom.motion.program import Program
from camgeom.track import TURN, Track

Number = float | Floats
"""one for all, or one each"""


@immutable
class Curve:
    """An outline at cam angles phi (n,): points and unit outward normals (2, n), curvature (n,) 1/mm, convex positive.

    speed  signed length per radian (n,): its sign is that of the outline's sense of travel, and where it vanishes or
           changes the outline has a cusp
    """

    points: Floats
    normals: Floats
    curvature: Floats
    speed: Floats


class Outline(Protocol):
    """A closed plane curve over one turn of the cam angle."""

    def knots(self) -> Floats:
        """Cam angles from 0 to 2 pi where a derivative may jump, rad."""

    def curve(self, phi: Floats) -> Curve:
        """Exact points, normals and curvature at cam angles (n,)."""


def _left(v: Floats) -> Floats:
    return np.stack([-v[1], v[0]])


@immutable
class RollerOutline:
    """The outline that a roller (axis along Z) envelops: its pitch curve moved by `distance` along the normal.

    distance  mm, along the pitch curve's outward normal: -r for a cam inside the roller, +r for the outer flank of a
              face groove, 0 for the pitch curve itself, any other value for a cutter or grinding wheel's centre
    """

    track: Track
    distance: float

    def knots(self) -> Floats:
        """Cam angles where the motion's derivatives may jump."""
        return self.track.knots()

    def curve(self, phi: Floats) -> Curve:
        """Points, outward normals, curvature. Raises DesignError where the pitch curve itself stands still."""
        pose = self.track.pose(phi, 2)
        c, d, dd = (pose.a[k][:2] for k in range(3))
        pace = np.sqrt(d[0] ** 2 + d[1] ** 2)
        if np.any(pace <= 1e-12 * np.abs(c).max()):
            raise DesignError("the roller centre stands still in the cam frame: the pitch curve has no direction there")
        sense = self.track.sense
        outward = np.stack(outward_normal((d[0], d[1]), pace, sense))
        bend = pitch_curvature((d[0], d[1]), (dd[0], dd[1]), pace, sense)
        growth = 1.0 + self.distance * bend
        safe = np.where(np.abs(growth) > 1e-300, growth, 1e-300)
        return Curve(c + self.distance * outward, outward, bend / safe, -sense * pace * growth)


Pair = tuple[Floats, Floats]
"""x and y of plane vectors, (...) each"""


def outward_normal(d: Pair, pace: Floats, sense: float) -> Pair:
    """Unit outward normals of a pitch curve from its derivative by the cam angle, of length `pace`.

    The follower travels round the cam against its turning (`sense`), which says on which hand the outside lies.
    """
    return d[1] * (-sense / pace), d[0] * (sense / pace)


def pitch_curvature(d: Pair, dd: Pair, pace: Floats, sense: float) -> Floats:
    """Curvature of a pitch curve, 1/mm, convex positive, from its derivatives by the cam angle, in any frame."""
    return np.asarray((d[1] * dd[0] - d[0] * dd[1]) * (sense / (pace * pace * pace)))


@immutable
class FaceOutline:
    """The envelope of a flat face: the line n(psi) . x = support, with its normal turning as the cam does.

    line(phi) gives psi, psi', psi'' (the normal's azimuth in the cam frame) and the support h, h', h'' over the cam
    angle; x = h n + (h' / psi') n_left. With psi = const -+ phi this is the support function of the theory.
    """

    line: FlatFace

    def knots(self) -> Floats:
        """Cam angles where the motion's derivatives may jump."""
        return self.line.knots()

    def curve(self, phi: Floats) -> Curve:
        """Points, outward normals, curvature. Raises DesignError where the face turns with the cam."""
        psi, h = self.line.jets(phi)
        if np.any(psi[1] == 0.0):
            raise DesignError("the flat face turns with the cam: it envelops no profile there")
        n = np.stack([np.cos(psi[0]), np.sin(psi[0])])
        along, radius = face_contact(psi, h)
        points = h[0] * n + along * _left(n)
        safe = np.where(np.abs(radius) > 1e-300, radius, 1e-300)
        return Curve(points, n, 1.0 / safe, radius * psi[1])


def face_contact(psi: Floats, h: Floats) -> tuple[Floats, Floats]:
    """Where a face with normal azimuth and support (3, ...) touches its envelope, mm along it; radius of that, mm."""
    return np.asarray(h[1] / psi[1]), np.asarray(h[0] + (h[2] - h[1] * psi[2] / psi[1]) / psi[1] ** 2)


def swung_face(s: Floats, start: Number, pivot: Number, offset: Number) -> tuple[Floats, Floats]:
    """Jets (3, ...) of an arm's face at lifts s (3, ...): the angle of its normal from the line of centres, support.

    start  that angle at zero lift, rad: cos(start) = (base + offset) / pivot
    """
    # Of many variants an angle each may stand against one motion.
    beta = np.stack(np.broadcast_arrays(start - s[0], -s[1], -s[2]))
    c, sn = np.cos(beta[0]), np.sin(beta[0])
    support = (pivot * c - offset, -pivot * sn * beta[1], -pivot * (c * beta[1] ** 2 + sn * beta[2]))
    return beta, np.stack(support)


@immutable
class FlatFace:
    """A flat face carried by a slide along X (pivot None) or by an arm pivoted at (pivot, 0).

    Translating: support base + s, normal azimuth -sense phi. Swinging: the normal stands at way * (beta0 - lift) in the
    machine, cos(beta0) = (base + offset) / pivot, and the support is pivot cos(beta) - offset.

    span  mm, of the far face of a frame: its distance from the near one, which it looks at; 0 for any other face
    """

    program: Program
    sense: float
    base: float
    pivot: float | None = None
    offset: float = 0.0
    way: float = 1.0
    span: float = 0.0

    def knots(self) -> Floats:
        """Cam angles where the motion's derivatives may jump."""
        return np.asarray(self.program.knots)

    def jets(self, phi: Floats) -> tuple[Floats, Floats]:
        """Azimuth of the normal and support, each (3, n)."""
        s = self.program.jet(phi, 2)
        psi, h = np.zeros_like(s), s.copy()
        psi[0], psi[1] = -self.sense * phi, -self.sense
        if self.span:
            psi[0] += np.pi
            h[0] += self.base - self.span
            return psi, -h
        if self.pivot is None:
            h[0] += self.base
            return psi, h
        beta, h = swung_face(s, acos((self.base + self.offset) / self.pivot), self.pivot, self.offset)
        return psi + self.way * beta, h


@immutable
class CircleOutline:
    """A circle of the given radius about a centre, counter-clockwise."""

    radius: float
    centre: tuple[float, float] = (0.0, 0.0)

    def knots(self) -> Floats:
        """A circle has none but the turn's ends."""
        return np.array([0.0, 0.5 * TURN, TURN])

    def curve(self, phi: Floats) -> Curve:
        """Points, normals, curvature."""
        n = np.stack([np.cos(phi), np.sin(phi)])
        centre = np.array(self.centre)[:, None]
        one = np.ones_like(phi)
        return Curve(centre + self.radius * n, n, one / self.radius, self.radius * one)


@immutable
class ParallelOutline:
    """The curve at a normal distance (mm, outwards) from an outline: the path of a round tool's centre."""

    outline: Outline
    distance: float

    def knots(self) -> Floats:
        """Cam angles where a derivative may jump."""
        return self.outline.knots()

    def curve(self, phi: Floats) -> Curve:
        """Points, normals, curvature."""
        at = self.outline.curve(phi)
        growth = 1.0 + self.distance * at.curvature
        safe = np.where(np.abs(growth) > 1e-300, growth, 1e-300)
        return Curve(at.points + self.distance * at.normals, at.normals, at.curvature / safe, at.speed * growth)


@immutable
class PolygonOutline:
    """A closed polygon (n, 2), counter-clockwise, travelled edge by edge over the turn; flat between its corners."""

    corners: Floats

    def knots(self) -> Floats:
        """One cam angle a corner."""
        return np.linspace(0.0, TURN, len(self.corners) + 1)

    def curve(self, phi: Floats) -> Curve:
        """Points, normals, curvature (zero)."""
        place = np.asarray(phi) / TURN * len(self.corners)
        edge = np.minimum(place.astype(int), len(self.corners) - 1)
        step = (np.roll(self.corners, -1, axis=0) - self.corners)[edge].T
        length = np.sqrt((step**2).sum(axis=0))
        points = self.corners[edge].T + (place - edge) * step
        normals = np.stack([step[1], -step[0]]) / length
        return Curve(points, normals, np.zeros_like(length), length * len(self.corners) / TURN)


@immutable(eq=True)
class AreaProperties:
    """Area mm², perimeter mm, centroid mm and second moments about the origin mm⁴ (xx, yy, xy) of an outline."""

    area: float
    perimeter: float
    centroid: tuple[float, float]
    moments: tuple[float, float, float]


@immutable
class OutlineIntegrals:
    """Integrals of an outline by Gauss-Legendre quadrature between its knots."""

    outline: Outline
    parts: int = 8

    @cached_property
    def _nodes(self) -> tuple[Floats, Floats]:
        knots = self.outline.knots()
        x, w = gauss_rule(16)
        share = np.arange(self.parts) / self.parts
        low = (knots[:-1, None] + np.diff(knots)[:, None] * share).ravel()
        half = np.repeat(np.diff(knots) / self.parts, self.parts) * 0.5
        return ((low + half)[:, None] + half[:, None] * x).ravel(), (half[:, None] * w).ravel()

    @cached_property
    def properties(self) -> AreaProperties:
        """Area, perimeter, centroid and second moments (Green's theorem on the exact curve)."""
        phi, w = self._nodes
        curve = self.outline.curve(phi)
        # dx = speed * left(normal) dphi, so x dy - y dx = speed (x . n) dphi for a counter-clockwise outline.
        x, y = curve.points
        support = (curve.points * curve.normals).sum(axis=0) * curve.speed * w
        sign = 1.0 if float(support.sum()) >= 0.0 else -1.0
        area = 0.5 * sign * float(support.sum())
        cx, cy = (sign * float((c * support).sum()) / (3.0 * area) for c in (x, y))
        xx, yy, xy = (0.25 * sign * float((q * support).sum()) for q in (x * x, y * y, x * y))
        return AreaProperties(area, float((np.abs(curve.speed) * w).sum()), (cx, cy), (xx, yy, xy))


PER_TURN = 1440


@immutable(eq=True)
class Crossing:
    """A crossing of an outline with itself: both cam angles (rad) and the point, mm."""

    first: float
    second: float
    point: tuple[float, float]


def crossing(outline: Outline) -> Crossing | None:
    """The first crossing of an outline with itself, or None.

    Where the outline runs round the cam axis without turning back (support and speed of one sign, one turn) it cannot
    cross. Elsewhere the polygon of its samples, a quarter of a degree apart, is searched for crossing edges.
    """
    phi, _ = piece_grid(outline.knots(), PER_TURN)
    curve = outline.curve(phi)
    support = (curve.points * curve.normals).sum(axis=0) * np.sign(curve.speed)
    turning = np.angle(np.exp(1j * np.diff(np.angle(curve.points[0] + 1j * curve.points[1]))))
    once = abs(abs(float(turning.sum())) - 2.0 * np.pi) < 1e-3
    if once and (np.all(support > 0.0) or np.all(support < 0.0)):
        return None
    return _searched(phi, curve.points)


def _searched(phi: Floats, points: Floats) -> Crossing | None:
    """The first crossing of the closed polygon of points (2, n)."""
    steps = np.roll(points, -1, axis=1) - points
    keep = np.flatnonzero((steps**2).sum(axis=0) > 1e-14 * float(np.abs(points).max()) ** 2)
    a = points[:, keep]
    d = np.roll(a, -1, axis=1) - a
    n = a.shape[1]
    least, most = np.minimum(a, a + d), np.maximum(a, a + d)
    for begin in range(0, n, 256):
        i = np.arange(begin, min(begin + 256, n))
        # Edges beyond the box of these cannot cross one of them.
        low, high = least[:, i].min(axis=1)[:, None], most[:, i].max(axis=1)[:, None]
        j = np.flatnonzero(((most >= low) & (least <= high)).all(axis=0))
        gap = a[:, None, j] - a[:, i, None]
        cross = d[0, i, None] * d[1, j] - d[1, i, None] * d[0, j]
        safe = np.where(cross != 0.0, cross, np.inf)
        s = (gap[0] * d[1, j] - gap[1] * d[0, j]) / safe
        t = (gap[0] * d[1, i, None] - gap[1] * d[0, i, None]) / safe
        apart = np.abs(j - i[:, None])
        hit = (s > 0.0) & (s < 1.0) & (t > 0.0) & (t < 1.0) & (apart > 1) & (apart < n - 1)
        if np.any(hit):
            row, other = (int(k[0]) for k in np.nonzero(hit))
            point = a[:, i[row]] + s[row, other] * d[:, i[row]]
            return Crossing(float(phi[keep[i[row]]]), float(phi[keep[j[other]]]), (float(point[0]), float(point[1])))
    return None
