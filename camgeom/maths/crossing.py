"""Triangles of a mesh that pierce each other: boxes sorted in space, met level by level, then edges against triangles.

A closed, consistently oriented mesh whose triangles do not pierce each other bounds a body; where they do, some regions
are within it twice or turned inside out.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats
from camgeom.maths.mesh import Mesh

Index = npt.NDArray[np.int64]
BITS = 10
"""of each coordinate in the order of space: as many cells as triangles could fill"""
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


def _meeting_boxes(low: Floats, high: Floats) -> Index:
    """Pairs (k, 2) of boxes (f, 3) that overlap: a tree of four boxes a node, met with itself from the root down."""
    order = np.argsort(_space_order(0.5 * (low + high)), kind="stable")
    levels = [(low[order], high[order])]
    while len(levels[-1][0]) > 1:
        small, large = levels[-1]
        missing = -len(small) % 4
        small = np.concatenate([small, np.full((missing, 3), np.inf)]).reshape(-1, 4, 3).min(axis=1)
        large = np.concatenate([large, np.full((missing, 3), -np.inf)]).reshape(-1, 4, 3).max(axis=1)
        levels.append((small, large))
    child = np.arange(4)
    i, j = (side.ravel() for side in np.meshgrid(child, child, indexing="ij"))
    a = b = np.zeros(1, dtype=np.int64)
    for small, large in levels[-2::-1]:
        a, b = (4 * a[:, None] + i).ravel(), (4 * b[:, None] + j).ravel()
        keep = (a <= b) & (b < len(small))
        a, b = a[keep], b[keep]
        for k in range(3):
            meet = (small[a, k] <= large[b, k]) & (small[b, k] <= large[a, k])
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
    for first, second in ((0, 1), (1, 0)):
        edges, plane = pairs[:, first], pairs[:, second]
        height = np.einsum("kci,ki->kc", corners[edges] - origin[plane][:, None], normal[plane])
        # Most pairs stand beside each other: all corners of one on one side of the other's plane.
        across = np.flatnonzero((height.min(axis=1) < -depth) & (height.max(axis=1) > depth) & ~found)
        edges, plane, height = edges[across], plane[across], height[across]
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
