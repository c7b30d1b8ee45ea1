"""The edges of bodies that are seen behind a section plane, and not hidden by what lies before them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats
from camgeom.maths.creases import crease_lines
from camgeom.maths.mesh import Ints, Mesh

BINS = 96
"""squares along either side of the view into which triangles are sorted"""
NEAR = 2e-4
"""share of the size within which a surface is the edge's own"""
PAIRS = 1_000_000
"""of points and sides, or triangles, that are held at once"""
PIECES = 120
"""pieces of the size into which long edges are cut, each seen or not as its middle is"""


def edges_behind(
    meshes: Sequence[Mesh], axis: int, level: float, sense: float, cut: Iterable[Floats]
) -> tuple[Floats, ...]:
    """Lines (k, 3) along the sharp edges of closed meshes that are seen behind the plane x[axis] = level.

    sense  1 where what has the larger coordinate lies behind, -1 the other way
    cut    closed outlines (k, 3) of the meshes in the plane, within which they hide what is behind
    An edge is seen where the straight way to the plane meets no surface and ends outside the outlines.
    """
    flat = [number for number in range(3) if number != axis]
    size = max(float(np.ptp(mesh.vertices, axis=0).max()) for mesh in meshes)
    starts, stops = (np.concatenate(ends) for ends in zip(*(_edges(mesh, axis, level, sense, size) for mesh in meshes)))
    middle = 0.5 * (starts + stops)
    seen = ~_within(middle[:, flat], [loop[:, flat] for loop in cut])
    seen[seen] = ~_covered(middle[seen], meshes, axis, level, sense, NEAR * size)
    return _chained(starts[seen], stops[seen], NEAR * size)


def _edges(mesh: Mesh, axis: int, level: float, sense: float, size: float) -> tuple[Floats, Floats]:
    """Ends (e, 3) of the pieces of a mesh's creases that lie behind the plane."""
    a, b = mesh.vertices[crease_lines(mesh)].transpose(1, 0, 2)
    depth = [sense * (end[:, axis] - level) for end in (a, b)]
    behind = np.maximum(*depth) > NEAR * size
    a, b, near, far = a[behind], b[behind], depth[0][behind], depth[1][behind]
    # What reaches through the plane begins at it.
    share = np.where(np.minimum(near, far) < 0.0, near / np.where(near == far, 1.0, near - far), 0.0)[:, None]
    crossing = a + share * (b - a)
    a, b = np.where((near < 0.0)[:, None], crossing, a), np.where((far < 0.0)[:, None], crossing, b)
    count = np.maximum(1, np.ceil(np.linalg.norm(b - a, axis=1) / (size / PIECES))).astype(np.int64)
    which = np.repeat(np.arange(len(count)), count)
    place = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
    at = [((place + end) / count[which])[:, None] for end in (0, 1)]
    return a[which] + at[0] * (b - a)[which], a[which] + at[1] * (b - a)[which]


def _within(points: Floats, loops: Sequence[Floats]) -> npt.NDArray[np.bool_]:
    """Which points (n, 2) lie inside closed outlines (k, 2), by the number of sides that a ray to the right crosses."""
    order = np.argsort(points[:, 1])
    x, y = points[order].T
    crossed = np.zeros(len(points), dtype=np.int64)
    for loop in loops:
        ends = np.stack([loop, np.roll(loop, -1, axis=0)], axis=1)
        # A side is met by the rays of the points between the heights of its ends, which stand one after the other.
        first, last = np.searchsorted(y, np.sort(ends[:, :, 1], axis=1).T)
        count = last - first
        pairs = np.cumsum(count)
        for k in range(0, int(pairs[-1]), PAIRS):
            number = np.arange(k, min(k + PAIRS, int(pairs[-1])))
            side = np.searchsorted(pairs, number, side="right")
            at = number - (pairs - count)[side] + first[side]
            (x0, y0), (x1, y1) = ends[side].transpose(1, 2, 0)
            right = x[at] < x0 + (y[at] - y0) / (y1 - y0) * (x1 - x0)
            crossed += np.bincount(at[right], minlength=len(points))
    inside = np.empty(len(points), dtype=bool)
    inside[order] = crossed % 2 == 1
    return inside


def _covered(
    points: Floats, meshes: Sequence[Mesh], axis: int, level: float, sense: float, near: float
) -> npt.NDArray[np.bool_]:
    """Which points (n, 3) have a surface between themselves and the plane, further from them than `near`, mm."""
    flat = [number for number in range(3) if number != axis]
    corners = np.concatenate([mesh.vertices[mesh.faces] for mesh in meshes])
    depth = sense * (corners[:, :, axis] - level)
    behind = depth.max(axis=1) > 0.0
    if not behind.any():
        return np.zeros(len(points), dtype=bool)
    corners, depth = corners[behind][:, :, flat], depth[behind]
    low, high = corners.min(axis=1), corners.max(axis=1)
    origin, cell = low.min(axis=0), np.ptp(corners.reshape(-1, 2), axis=0) / BINS
    at = np.clip(((points[:, flat] - origin) / cell).astype(np.int64), 0, BINS - 1)
    first, last = (np.clip(((end - origin) / cell).astype(np.int64), 0, BINS - 1) for end in (low, high))
    reach = sense * (points[:, axis] - level) - near
    found = np.zeros(len(points), dtype=bool)
    for square in np.unique(at, axis=0):
        here = np.flatnonzero((at == square).all(axis=1))
        there = np.flatnonzero(((first <= square) & (last >= square)).all(axis=1))
        for part in np.array_split(here, 1 + len(here) * len(there) // PAIRS):
            found[part] = _met(points[part][:, flat], reach[part], corners[there], depth[there])
    return found


def _met(points: Floats, reach: Floats, corners: Floats, depth: Floats) -> npt.NDArray[np.bool_]:
    """Which points (n, 2) have a triangle (m, 3, 2) over them, less deep (m, 3) there than `reach` (n,)."""
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    upright = area == 0.0  # seen edge-on: it hides nothing
    d = points[:, None] - corners[:, 0]
    safe = np.where(upright, 1.0, area)
    s = (d[:, :, 0] * v[:, 1] - d[:, :, 1] * v[:, 0]) / safe
    t = (u[:, 0] * d[:, :, 1] - u[:, 1] * d[:, :, 0]) / safe
    over = (s >= 0.0) & (t >= 0.0) & (s + t <= 1.0) & ~upright
    there = depth[:, 0] + s * (depth[:, 1] - depth[:, 0]) + t * (depth[:, 2] - depth[:, 0])
    return np.asarray((over & (there > 0.0) & (there < reach[:, None])).any(axis=1))


def _chained(starts: Floats, stops: Floats, near: float) -> tuple[Floats, ...]:
    """Lines (k, 3) through pieces that have an end in common."""
    if not len(starts):
        return ()
    names = np.unique(np.round(np.concatenate([starts, stops]) / near).astype(np.int64), axis=0, return_inverse=True)[1]
    ends: Ints = names.reshape(2, -1).T.astype(np.int32)
    places = dict(zip(ends.ravel().tolist(), np.stack([starts, stops], axis=1).reshape(-1, 3)))
    at: dict[int, set[int]] = {}
    for number, pair in enumerate(ends.tolist()):
        for end in pair:
            at.setdefault(end, set()).add(number)
    pairs, left, lines = ends.tolist(), set(range(len(ends))), []
    loose = [min(at[end]) for end in at if len(at[end]) != 2]
    for number in [*loose, *range(len(pairs))]:
        if number not in left:
            continue
        left.discard(number)
        a, b = pairs[number]
        line = [b, a] if len(at[b]) != 2 else [a, b]
        while len(at[line[-1]]) == 2 and (following := at[line[-1]] & left):
            number = following.pop()
            left.discard(number)
            line.append(sum(pairs[number]) - line[-1])
        lines.append(np.array([places[one] for one in line]))
    return tuple(lines)
