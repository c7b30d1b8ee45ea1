"""Triangles cut off at a height, and the loops in which they then end."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats

Index = npt.NDArray[np.int64]
Labels = npt.NDArray[np.uint8]


def clip(points: Floats, faces: Index, label: Labels, height: float, sign: float) -> tuple[Floats, Index, Labels]:
    """What of a mesh lies at sign * (z - height) <= 0: points (v, 3), faces (f, 3) and their labels (f,).

    A cut edge gets one new point, straight between its ends, numbered after all the old ones. Faces that only touch the
    plane are left out, so that the mesh ends there.
    """
    s = sign * (points[:, 2] - height)
    corner = s[faces]
    out, inner = corner > 0.0, (corner < 0.0).any(axis=1)
    gone = out.any(axis=1)
    keep, cut = ~gone & inner, gone & inner
    tri, out = faces[cut], out[cut]
    # Turned so that the odd corner comes last: the one beyond of two on this side, or the one on this side.
    single = out.sum(axis=1) == 1
    odd = np.where(single, np.argmax(out, axis=1), np.argmin(out, axis=1))
    p, q, o = np.take_along_axis(tri, (odd[:, None] + np.array([1, 2, 3])) % 3, axis=1).T
    new, (to_p, to_q) = _crossings(points, s, height, o, (p, q))
    parts = [
        faces[keep],
        np.stack([p, q, to_q], axis=1)[single],
        np.stack([p, to_q, to_p], axis=1)[single],
        np.stack([to_p, to_q, o], axis=1)[~single],
    ]
    names = label[cut]
    every, named = np.concatenate(parts), np.concatenate([label[keep], names[single], names[single], names[~single]])
    sound = (every[:, 0] != every[:, 1]) & (every[:, 1] != every[:, 2]) & (every[:, 2] != every[:, 0])
    return np.concatenate([points, new]), every[sound], named[sound]


def _crossings(
    points: Floats, s: Floats, height: float, start: Index, ends: tuple[Index, ...]
) -> tuple[Floats, list[Index]]:
    """New points where edges cross the plane, and the vertex of each crossing; an end on the plane is its own."""
    a, b = np.tile(start, len(ends)), np.concatenate(ends)
    on = s[b] == 0.0
    key = np.minimum(a, b) * len(points) + np.maximum(a, b)
    unique, number = np.unique(key[~on], return_inverse=True)
    i, j = unique // len(points), unique % len(points)
    share = (s[i] / (s[i] - s[j]))[:, None]
    new = points[i] + share * (points[j] - points[i])
    new[:, 2] = height
    found = b.copy()
    found[~on] = len(points) + number.reshape(-1)
    return new, np.split(found, len(ends))


def open_loops(faces: Index, on: npt.NDArray[np.bool_]) -> list[Index] | None:
    """Loops (n,) of vertex numbers in which faces end, along their own direction; edges between marked vertices only.

    None where the ends do not join up to simple loops (a vertex is met twice, or an end is missing).
    """
    marked = on[faces]
    near = faces[marked.sum(axis=1) >= 2]
    edges = np.concatenate([near[:, [0, 1]], near[:, [1, 2]], near[:, [2, 0]]])
    edges = edges[on[edges].all(axis=1)]
    size = np.int64(len(on))
    single = ~np.isin(edges[:, 0] * size + edges[:, 1], edges[:, 1] * size + edges[:, 0])
    start, stop = edges[single].T
    if len(np.unique(start)) < len(start) or not np.array_equal(np.sort(start), np.sort(stop)):
        return None
    following = dict(zip(start.tolist(), stop.tolist()))
    loops = []
    while following:
        first, at = following.popitem()
        loop = [first]
        while at != first:
            loop.append(at)
            at = following.pop(at)
        loops.append(np.array(loop))
    return loops
