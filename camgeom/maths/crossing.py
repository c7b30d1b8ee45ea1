"""Triangles of a mesh that pierce each other: boxes sorted in space, met level by level, then edges against triangles.

A closed, consistently oriented mesh whose triangles do not pierce each other bounds a body; where they do, some regions
are within it twice or turned inside out.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats
from camgeom.maths.mesh import Mesh
from camgeom.maths.surface import dot

Index = npt.NDArray[np.int64]
BITS = 10
"""of each coordinate in the order of space: as many cells as triangles could fill"""
ROOTS = 128
"""nodes from which on all pairs are compared at once"""
GRAZING = 1e-9
"""share of a triangle by which an edge has to pass within its rim: one that runs along it does not pierce it"""


def crossings(mesh: Mesh, depth: float = 0.0) -> Index:
    """Pairs (k, 2) of triangles, without a vertex in common, of which an edge of one pierces the other.

    depth  mm; an edge whose nearer end stands no farther beyond the other's plane does not count: as much as a mesh
           with chord errors may cross itself where two surfaces run together
    """
    corners = mesh.vertices[mesh.faces]
    pairs = _meeting_boxes(corners.min(axis=1), corners.max(axis=1))
    a, b = mesh.faces[pairs[:, 0]].T, mesh.faces[pairs[:, 1]].T
    shared = np.zeros(len(pairs), dtype=bool)
    for i in range(3):
        for j in range(3):
            shared |= a[i] == b[j]
    pairs = pairs[~shared]
    return pairs[_pierce(corners, pairs, depth)]


def outline(mesh: Mesh) -> Index | None:
    """Edges (e, 2) of the lower outlines of a prism along Z, whose vertices stand at two heights; None of others."""
    z = mesh.vertices[:, 2]
    low, high = float(z.min()), float(z.max())
    if not np.all((z == low) | (z == high)):
        return None
    below = z[mesh.faces] == low
    walls = mesh.faces[below.sum(axis=1) == 2]
    edges = np.concatenate([walls[:, [0, 1]], walls[:, [1, 2]], walls[:, [2, 0]]])
    return np.asarray(edges[(z[edges] == low).all(axis=1)], dtype=np.int64)


def outlines_cross(mesh: Mesh, edges: Index, depth: float = 0.0) -> bool:
    """Whether edges (e, 2) of outlines, without an end in common, cross each other by more than `depth`, mm, in XY.

    The walls of a prism stand on them: where its outlines do not cross, neither do its faces.
    """
    corners = mesh.vertices[edges] * np.array([1.0, 1.0, 0.0])
    a, b = _meeting_boxes(corners.min(axis=1), corners.max(axis=1)).T
    apart = (edges[a][:, :, None] != edges[b][:, None, :]).all(axis=(1, 2))
    a, b = a[apart], b[apart]
    across = np.ones(len(a), dtype=bool)
    for one, other in ((a, b), (b, a)):
        p, q = corners[other].swapaxes(0, 1)
        along = (q - p) / np.sqrt(((q - p) ** 2).sum(axis=1))[:, None]
        off = corners[one] - p[:, None]
        height = along[:, :1] * off[:, :, 1] - along[:, 1:2] * off[:, :, 0]
        across &= (height[:, 0] * height[:, 1] < 0.0) & (np.abs(height).min(axis=1) > depth)
    return bool(across.any())


def _meeting_boxes(low: Floats, high: Floats) -> Index:
    """Pairs (k, 2) of boxes (f, 3) that overlap: a tree of four boxes a node, met with itself from the root down."""
    order = np.argsort(_space_order(0.5 * (low + high)), kind="stable")
    # Coordinate by coordinate: taking from one row is several times as fast as from a column.
    levels = [(np.ascontiguousarray(low[order].T), np.ascontiguousarray(high[order].T))]
    while levels[-1][0].shape[1] > ROOTS:
        small, large = levels[-1]
        beyond = np.full((3, -small.shape[1] % 4), np.inf)
        small = np.concatenate([small, beyond], axis=1).reshape(3, -1, 4).min(axis=2)
        large = np.concatenate([large, -beyond], axis=1).reshape(3, -1, 4).max(axis=2)
        levels.append((small, large))
    child = np.arange(4)
    i, j = (side.ravel() for side in np.meshgrid(child, child, indexing="ij"))
    a, b = np.triu_indices(levels[-1][0].shape[1])
    for number, (small, large) in enumerate(levels[::-1]):
        if number:
            a, b = (4 * a[:, None] + i).ravel(), (4 * b[:, None] + j).ravel()
            keep = (a <= b) & (b < small.shape[1])
            a, b = a[keep], b[keep]
        for least, most in zip(small, large):
            meet = (least.take(a) <= most.take(b)) & (least.take(b) <= most.take(a))
            a, b = a[meet], b[meet]
    apart = a < b
    return np.stack([order[a[apart]], order[b[apart]]], axis=1)


def _space_order(points: Floats) -> Index:
    """Numbers (f,) that are near for points (f, 3) near each other: the bits of their coordinates interleaved."""
    low = points.min(axis=0)
    extent = float((points.max(axis=0) - low).max()) or 1.0
    cell = ((points - low) * ((2**BITS - 1) / extent)).astype(np.int64)
    number = np.zeros(len(points), dtype=np.int64)
    for bit in range(BITS):
        for k in range(3):
            number |= ((cell[:, k] >> bit) & 1) << (3 * bit + k)
    return number


def _pierce(corners: Floats, pairs: Index, depth: float) -> npt.NDArray[np.bool_]:
    """Of which pairs (k, 2) of triangles (f, 3, 3) an edge of one passes through the inside of the other, (k,)."""
    found = np.zeros(len(pairs), dtype=bool)
    origin = corners[:, 0]
    normal = np.cross(corners[:, 1] - origin, corners[:, 2] - origin)
    size = np.sqrt(np.einsum("fi,fi->f", normal, normal))
    normal /= np.where(size > 0.0, size, 1.0)[:, None]
    # Coordinate by coordinate, as most pairs need no more: (xyz, corner, f) and (xyz, f).
    place, unit = np.ascontiguousarray(corners.T), np.ascontiguousarray(normal.T)
    for first, second in ((0, 1), (1, 0)):
        edges, plane = pairs[:, first], pairs[:, second]
        height = dot(place.take(edges, 2) - place[:, 0].take(plane, 1)[:, None], unit.take(plane, 1)[:, None])
        # Most pairs stand beside each other: all corners of one on one side of the other's plane.
        across = np.flatnonzero((height.min(axis=0) < -depth) & (height.max(axis=0) > depth) & ~found)
        edges, plane, height = edges[across], plane[across], height[:, across].T
        one, start, n, area = corners[edges], origin[plane], normal[plane], size[plane]
        u, v = corners[plane, 1] - start, corners[plane, 2] - start
        full = np.where(area > 0.0, area, 1.0)
        hit = np.zeros(len(across), dtype=bool)
        for k in range(3):
            p, q = one[:, k], one[:, (k + 1) % 3]
            hp, hq = height[:, k], height[:, (k + 1) % 3]
            apart = (hp * hq < 0.0) & (np.minimum(np.abs(hp), np.abs(hq)) > depth) & (area > 0.0)
            share = hp / np.where(apart, hp - hq, 1.0)
            d = p + share[:, None] * (q - p) - start
            s = np.einsum("ki,ki->k", np.cross(d, v), n) / full
            t = np.einsum("ki,ki->k", np.cross(u, d), n) / full
            hit |= apart & (s > GRAZING) & (t > GRAZING) & (s + t < 1.0 - GRAZING)
        found[across[hit]] = True
    return found
