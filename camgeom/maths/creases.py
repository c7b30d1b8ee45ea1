"""Vertex normals for shading: smooth over the surface, split along its creases and between face groups."""

from __future__ import annotations

from math import cos, radians

import numpy as np
import numpy.typing as npt

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.mesh import Ints, Mesh

Integers = npt.NDArray[np.int64]


@immutable
class Shaded:
    """A mesh whose vertices are doubled along creases, so that each has one normal.

    source   (n,) int32, the mesh vertex each comes from: positions and fields are `array[source]`
    faces    (f, 3) int32 indices into 0..n, in the mesh's order
    normals  (n, 3) unit normals, outward
    """

    source: Ints
    faces: Ints
    normals: Floats


def shade(mesh: Mesh, angle: float = 30.0) -> Shaded:
    """Split the mesh along edges whose faces meet at more than `angle` degrees or belong to different groups.

    A vertex on such an edge becomes one vertex for each fan of faces that smooth edges join round it. A normal is the
    sum of the faces' cross products, each divided by the squares of its two sides (N. Max, Weights for computing vertex
    normals from facet normals, 1999: exact on a sphere, and blind to how the surface is cut into triangles).
    """
    corner, unit = _corner_normals(mesh)
    fan, place = _fans(mesh.faces, _smooth_edges(mesh, unit, cos(radians(angle))))
    at = place.reshape(-1, 3).T.ravel()
    normals = np.column_stack([np.bincount(at, one.ravel(), len(fan)) for one in corner])
    length = np.sqrt(np.einsum("ni,ni->n", normals, normals))
    flat = length == 0.0  # only corners of faces without area
    normals[flat], length[flat] = (0.0, 0.0, 1.0), 1.0
    return Shaded(mesh.faces.ravel()[fan], place.reshape(-1, 3), normals / length[:, None])


def crease_lines(mesh: Mesh, angle: float = 30.0) -> Ints:
    """Edges (e, 2), as vertex indices, where faces meet at more than `angle` degrees, or groups or the surface end."""
    _, unit = _corner_normals(mesh)
    crease = np.ones(3 * len(mesh.faces), dtype=bool)
    for edges in _smooth_edges(mesh, unit, cos(radians(angle))):
        crease[edges] = False
    edge = np.flatnonzero(crease)
    ends = mesh.faces.ravel()[np.stack([edge, _following(edge)], axis=1)]
    return np.unique(np.sort(ends, axis=1), axis=0)


def _corner_normals(mesh: Mesh) -> tuple[Floats, Floats]:
    """Weighted normals at the corners, (xyz, place, f), and the unit normals of the faces, (xyz, f), 0 without area."""
    corners = np.ascontiguousarray(mesh.faces.T)
    x, y, z = (np.ascontiguousarray(mesh.vertices[:, i]).take(corners) for i in range(3))
    u, v, w = (p[[1, 2, 0]] - p for p in (x, y, z))  # sides, each from its corner to the next
    square = u * u + v * v + w * w
    area = np.stack([v[0] * w[1] - w[0] * v[1], w[0] * u[1] - u[0] * w[1], u[0] * v[1] - v[0] * u[1]])
    size = np.sqrt(area[0] ** 2 + area[1] ** 2 + area[2] ** 2)
    around = square * square[[2, 0, 1]]
    around[around == 0.0] = np.inf
    size[size == 0.0] = 1.0
    return area[:, None, :] / around, area / size


def _smooth_edges(mesh: Mesh, unit: Floats, least: float) -> tuple[Integers, Integers]:
    """The two directed edges (3 face + place) of every smooth edge, (e,) each; `least` is the cosine of the bend."""
    faces = mesh.faces.astype(np.int64)
    start, end = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    key = np.minimum(start, end) * len(mesh.vertices) + np.maximum(start, end)
    order = np.argsort(key)
    key = key[order]
    same = np.concatenate([[False], key[1:] == key[:-1], [False]])
    pair = np.flatnonzero(same[1:-1] & ~same[:-2] & ~same[2:])  # an edge of three faces is a crease
    one, other = order[pair], order[pair + 1]
    f, g = one // 3, other // 3
    smooth = start[one] == end[other]
    smooth &= sum(axis.take(f) * axis.take(g) for axis in unit) >= least
    if mesh.group is not None:
        smooth &= mesh.group[f] == mesh.group[g]
    return one[smooth], other[smooth]


def _fans(faces: Ints, smooth: tuple[Integers, Integers]) -> tuple[Integers, Ints]:
    """One corner (3 face + place) of every fan (n,), and the fan of every corner (3 f,).

    A vertex without a crease is one fan and needs no search; round the others, labels spread over the smooth edges.
    """
    one, other = smooth
    vertex, count = faces.ravel(), 3 * len(faces)
    crease = np.ones(count, dtype=bool)
    crease[one] = crease[other] = False
    creased = np.zeros(int(faces.max(initial=-1)) + 1, dtype=bool)
    creased[vertex[crease]] = creased[vertex[_following(np.flatnonzero(crease))]] = True
    label = np.empty(len(creased), dtype=np.int64)
    label[vertex[::-1]] = np.arange(count)[::-1]
    label = np.where(creased[vertex], np.arange(count), label[vertex])
    a, b = np.concatenate([one, other]), _following(np.concatenate([other, one]))
    near = creased[vertex[a]]
    a, b = a[near], b[near]
    while not np.array_equal(label[a], label[b]):
        low = np.minimum(label[a], label[b])
        np.minimum.at(label, label[a], low)
        np.minimum.at(label, label[b], low)
        label = label[label]
    root = label == np.arange(count)
    number = np.cumsum(root, dtype=np.int32) - np.int32(1)
    return np.flatnonzero(root), number[label]


def _following(edge: Integers) -> Integers:
    """The next directed edge of the same face; it starts where the edge ends."""
    return np.where(edge % 3 == 2, edge - 2, edge + 1)
