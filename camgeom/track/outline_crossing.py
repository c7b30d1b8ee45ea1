"""Does a closed outline cross itself? A certificate first: a star-shaped curve without cusps does not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camgeom.maths import Floats
from camgeom.maths.extremum import piece_grid
from camgeom.track.outline import Outline

PER_TURN = 1440


@dataclass(frozen=True)
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
    for begin in range(0, n, 256):
        i = np.arange(begin, min(begin + 256, n))
        gap = a[:, None, :] - a[:, i, None]
        cross = d[0, i, None] * d[1] - d[1, i, None] * d[0]
        safe = np.where(cross != 0.0, cross, np.inf)
        s = (gap[0] * d[1] - gap[1] * d[0]) / safe
        t = (gap[0] * d[1, i, None] - gap[1] * d[0, i, None]) / safe
        apart = np.abs(np.arange(n) - i[:, None])
        hit = (s > 0.0) & (s < 1.0) & (t > 0.0) & (t < 1.0) & (apart > 1) & (apart < n - 1)
        if np.any(hit):
            row, other = (int(k[0]) for k in np.nonzero(hit))
            point = a[:, i[row]] + s[row, other] * d[:, i[row]]
            return Crossing(float(phi[keep[i[row]]]), float(phi[keep[other]]), (float(point[0]), float(point[1])))
    return None
