"""Meshes put together: named triangles, rings, cells of a grid, and flat faces between loops."""

from __future__ import annotations

from math import pi

import numpy as np
import numpy.typing as npt

from camgeom.errors import DesignError
from camgeom.maths import Floats
from camgeom.maths.mesh import Mesh

Index = npt.NDArray[np.int64]

SHORT = 1024
"""corners of a polygon that is filled as a whole in no time"""
LONG = 8192
"""corners of a polygon that is filled as a whole, in 0.3 s; one of 54 000 would take 20 s"""


class Builder:
    """Collects vertices and named triangles into one mesh."""

    def __init__(self) -> None:
        self._vertices: list[Floats] = []
        self._faces: list[npt.NDArray[np.integer]] = []
        self._labels: list[npt.NDArray[np.uint8]] = []
        self._names: list[str] = []
        self._count = 0

    def add(self, points: Floats) -> Index:
        """Append points (n, 3); returns their indices."""
        self._vertices.append(points)
        index = np.arange(self._count, self._count + len(points))
        self._count += len(points)
        return index

    def points(self, index: Index) -> Floats:
        """Coordinates of the given vertices."""
        first = 0
        for added in self._vertices:
            if first <= index.min() and index.max() < first + len(added):
                return np.asarray(added[index - first])
            first += len(added)
        return np.asarray(np.concatenate(self._vertices)[index])

    def faces(self, triangles: Index, name: str) -> None:
        """Append triangles (f, 3) to the named group; triangles with a repeated vertex are dropped."""
        a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
        keep = (a != b) & (b != c) & (c != a)
        if name not in self._names:
            self._names.append(name)
        self._faces.append(triangles[keep])
        self._labels.append(np.full(int(keep.sum()), self._names.index(name), dtype=np.uint8))

    def labelled(self, triangles: npt.NDArray[np.int32], label: Index, names: list[str]) -> None:
        """Append triangles (f, 3) of three vertices each to the groups named by their labels (f,)."""
        self._names += [name for name in dict.fromkeys(names) if name not in self._names]
        self._faces.append(triangles)
        self._labels.append(np.array([self._names.index(name) for name in names], dtype=np.uint8)[label])

    def band(self, low: Index, high: Index, name: str) -> None:
        """Join two closed rings of equal length; outward where both run counter-clockwise and `high` is above."""
        low2, high2 = np.roll(low, -1), np.roll(high, -1)
        self.faces(np.stack([low, low2, high2], axis=1), name)
        self.faces(np.stack([low, high2, high], axis=1), name)

    def mesh(self) -> Mesh:
        """The finished mesh with unused vertices removed."""
        vertices = np.concatenate(self._vertices)
        faces = np.concatenate(self._faces, dtype=np.int32, casting="same_kind")
        used = np.zeros(len(vertices), dtype=bool)
        used[faces] = True
        group, names = np.concatenate(self._labels), tuple(self._names)
        if used.all():
            return Mesh(vertices, faces, names, group)
        number = (np.cumsum(used) - 1).astype(np.int32)
        return Mesh(vertices[used], number[faces], names, group)


def add_grid(
    builder: Builder, points: Floats, counts: tuple[int, ...], names: tuple[str, ...], tolerance: float
) -> Index:
    """Add the grid's points (3, n, k); where an edge sweep has shrunk to nothing (dwells) its rows share one vertex."""
    n, k = points.shape[1:]
    index = builder.add(points.reshape(3, -1).T.copy()).reshape(n, k)
    ends = np.concatenate([[0], np.cumsum(counts)])
    for band, name in enumerate(names):
        if name != "edge":
            continue
        low, high = ends[band], ends[band + 1]
        span = points[:, :, high] - points[:, :, low]
        shrunk = (span * span).sum(axis=0) < (1e-3 * tolerance) ** 2
        foot = low if names[band - 1] == "flank" else high
        index[shrunk, low : high + 1] = index[shrunk, foot : foot + 1]
    return index


def wrapped_faces(index: Index, rising: npt.NDArray[np.bool_], inward: bool) -> Index:
    """Two triangles a cell of a grid closed in its first direction, (n, k, 2, 3)."""
    nxt = np.roll(index, -1, axis=0)
    return cell_faces(index[:, :-1], nxt[:, :-1], nxt[:, 1:], index[:, 1:], rising, inward)


def cell_faces(
    p00: Index, p10: Index, p11: Index, p01: Index, rising: npt.NDArray[np.bool_], inward: bool
) -> Index:
    """Triangles (..., 2, 3) of cells given by their corners, along the chosen diagonal."""
    faces = np.empty((*p00.shape, 2, 3), dtype=p00.dtype)
    corners = (p00, p10, np.where(rising, p11, p01)), (np.where(rising, p00, p10), p11, p01)
    for k, corner in enumerate(corners):
        for j, index in enumerate(corner[::-1] if inward else corner):
            faces[..., k, j] = index
    return faces


def band_cells(counts: tuple[int, ...], band: int) -> tuple[slice, slice]:
    """Selects the cells of one band in an array (n, k, ...)."""
    start = sum(counts[:band])
    return slice(None), slice(start, start + counts[band])


def zipper(outer: Index, outer_angle: Floats, inner: Index, inner_angle: Floats) -> Index:
    """Triangles between two counter-clockwise closed loops by merging their angles, counter-clockwise seen from +Z."""
    a = (outer_angle - inner_angle[0]) % (2.0 * pi)
    b = (inner_angle - inner_angle[0]) % (2.0 * pi)
    first = int(np.argmin(a))
    outer, a = np.roll(outer, -first), np.roll(a, -first)
    n, m = len(outer), len(inner)
    next_a, next_b = np.append(a[1:], a[0] + 2.0 * pi), np.append(b[1:], 2.0 * pi)
    order = np.argsort(np.concatenate([next_a, next_b]), kind="stable")
    is_outer = order < n
    i = np.asarray(np.cumsum(is_outer) - is_outer, dtype=np.int64)
    j = np.asarray(np.cumsum(~is_outer) - ~is_outer, dtype=np.int64)
    tip = np.where(is_outer, outer[(i + 1) % n], inner[(j + 1) % m])
    return np.stack([inner[j % m], outer[i % n], tip], axis=1)


def cap(builder: Builder, rings: list[Index], planes: list[Floats], name: str, up: bool) -> None:
    """Add the flat face between an outer ring and holes, facing up or down; see `bounded`."""
    faces = np.concatenate(rings)[bounded(planes)]
    builder.faces(faces if up else faces[:, ::-1], name)


def bounded(planes: list[Floats]) -> Index:
    """Triangles (t, 3) of the area between an outer polygon (n, 2), counter-clockwise, and holes, clockwise.

    Numbers run through all polygons in order. Raises DesignError where the loops cross, so that they bound no face.
    """
    planes = [np.ascontiguousarray(plane) for plane in planes]
    if len(planes) == 2 and (ring := _star_ring(*planes)) is not None:
        return ring
    triangles = filled(planes)
    if triangles is None:
        raise DesignError("the outline crosses itself or a hole: check undercut, bore and plate against the profile")
    return triangles


def _star_ring(outer: Floats, hole: Floats) -> Index | None:
    """Triangles between two loops that are both star-shaped about the origin, in a time proportional to their number.

    None where they are not, or where a triangle would lie the wrong way round: then the loops need a general method.
    """
    n, inner = len(outer), hole[::-1]
    angles = [np.arctan2(loop[:, 1], loop[:, 0]) for loop in (outer, inner)]
    for angle in angles:
        step = (np.roll(angle, -1) - angle) % (2.0 * np.pi)
        if np.any(step <= 0.0) or np.any(step >= np.pi) or step.sum() > 3.0 * np.pi:
            return None
    numbers = np.arange(n), np.arange(n + len(hole) - 1, n - 1, -1)
    triangles = zipper(numbers[0], angles[0], numbers[1], angles[1])
    covered = triangle_areas(np.concatenate([outer, hole]), triangles)
    return triangles if covered.min() > 0.0 else None


def filled(planes: list[Floats]) -> Index | None:
    """Triangles (t, 3) of the area within polygons (n, 2), counter-clockwise, less those that run clockwise.

    Numbers run through all polygons in order. None where the loops cross, so that they bound no face.
    """
    from camgeom.solid.engine import library

    loops = [np.ascontiguousarray(plane) for plane in planes]
    if len(loops) == 1 and len(loops[0]) > SHORT and (swept := _swept(loops[0])) is not None:
        return swept
    wanted = sum(len(loop) - 2 if polygon_area(loop) > 0.0 else len(loop) + 2 for loop in loops)
    points = np.concatenate(loops)
    for shorten in (_without_ears, _whole) if max(map(len, loops)) > LONG else (_whole,):
        cuts, left = zip(*map(shorten, loops))
        starts = np.cumsum([0, *map(len, loops[:-1])])
        rest = np.concatenate([start + one for start, one in zip(starts, left)])
        inner = np.asarray(library().triangulate([loop[one] for loop, one in zip(loops, left)])).astype(np.int64)
        triangles: Index = np.concatenate([*(start + one for start, one in zip(starts, cuts)), rest[inner]])
        covered = triangle_areas(points, triangles)
        if len(triangles) == wanted and covered.min() >= -1e-9 * covered.sum():
            return triangles
    return None


def _swept(loop: Floats) -> Index | None:
    """Triangles (t, 3) of a counter-clockwise polygon of which every line across its longer side has one stretch, in a
    time proportional to its corners; None of another one. (Garey, Johnson, Preparata, Tarjan 1978.)"""
    place = loop if np.ptp(loop[:, 0]) >= np.ptp(loop[:, 1]) else np.stack([loop[:, 1], -loop[:, 0]], axis=1)
    order, count = np.lexsort((place[:, 1], place[:, 0])), len(loop)
    rank = np.empty(count, dtype=np.int64)
    rank[order] = np.arange(count)
    lower = np.roll(rank, -order[0])[: (order[-1] - order[0]) % count + 1]
    upper = np.roll(rank, -order[-1])[: (order[0] - order[-1]) % count + 1]
    if np.any(np.diff(lower) < 0) or np.any(np.diff(upper) > 0):
        return None
    # Which side a corner is on: of the two ends none matters.
    side = np.ones(count, dtype=bool)
    side[lower] = False
    hand, (x, y) = side.tolist(), place[order].T.tolist()
    found, stack = list[tuple[int, int, int]](), [0, 1]
    for new in range(2, count):
        if hand[new] != hand[stack[-1]] or new == count - 1:
            found += [(new, b, a) if hand[stack[-1]] else (new, a, b) for a, b in zip(stack, stack[1:])]
            stack = [stack[-1], new]
            continue
        last = stack.pop()
        while stack:
            a = stack[-1]
            over = (x[last] - x[a]) * (y[new] - y[a]) - (y[last] - y[a]) * (x[new] - x[a])
            if over == 0.0 or (over > 0.0) is hand[new]:
                break
            found.append((new, last, a) if hand[new] else (new, a, last))
            last = stack.pop()
        stack += [last, new]
    triangles: Index = order[np.array(found)]
    covered = triangle_areas(loop, triangles)
    sound = len(triangles) == count - 2 and covered.min() >= -1e-9 * covered.sum()
    return triangles if sound and covered.sum() > 0.0 else None


def _whole(loop: Floats) -> tuple[Index, Index]:
    """No triangles, and all corners."""
    return np.zeros((0, 3), dtype=np.int64), np.arange(len(loop))


def _without_ears(loop: Floats) -> tuple[Index, Index]:
    """Triangles (t, 3) cut off a polygon's convex corners, no two neighbours at once, until it is short or few are
    left, and the corners left: a general method takes a time that grows with the square of their number.

    Where another part of the polygon reaches into a triangle, what is left crosses itself.
    """
    cuts, left = _whole(loop)
    while len(left) > LONG:
        corners = np.stack([np.roll(left, 1), left, np.roll(left, -1)], axis=1)
        ear = triangle_areas(loop, corners) > 0.0
        ear[1::2] = False
        ear[-1] = False  # of an odd number the last is the first one's neighbour
        if np.count_nonzero(ear) < len(left) // 8:
            break
        cuts, left = np.concatenate([cuts, corners[ear]]), left[~ear]
    return cuts, left


def polygon_area(plane: Floats) -> float:
    """Signed area of a polygon (n, 2), mm²."""
    x, y = plane.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def triangle_areas(points: Floats, triangles: Index) -> Floats:
    """Signed areas (t,) of triangles (t, 3) of points (n, 2), mm²."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.asarray(0.5 * ((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])))
