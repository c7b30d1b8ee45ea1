"""What a picture draws of a body: shaded triangles and dark lines, cut open by a plane where one is given."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats
from camgeom.maths.creases import crease_lines, shade
from camgeom.maths.mesh import Ints, Mesh

_CUT = "cut"
_HATCHES = 36
"""Hatch lines over the part's length."""


@dataclass(frozen=True)
class Plane:
    """A cutting plane through `point` (mm); what lies on the side of `normal` is taken away."""

    point: tuple[float, float, float]
    normal: tuple[float, float, float]

    def height(self, points: Floats) -> Floats:
        """Distance of points (n, 3) above the plane, mm, (n,)."""
        normal = np.array(self.normal) / np.linalg.norm(self.normal)
        return np.asarray((points - np.array(self.point)) @ normal)


@dataclass(frozen=True, eq=False)
class Skin:
    """Drawing data of one body.

    points, normals  (n, 3) mm and unit
    values           (n,) of the shown field, or None
    faces, group     (f, 3) and (f,) with the names in `groups`; the cut faces are of the group `cut`
    lines            (e, 2, 3) end points of creases, group borders and section outlines
    hatch            (e, 2, 3) end points of the hatching of the cut faces
    """

    points: Floats
    normals: Floats
    values: Floats | None
    faces: Ints
    group: npt.NDArray[np.uint8]
    groups: tuple[str, ...]
    lines: Floats
    hatch: Floats


def skin(mesh: Mesh, field: str | None = None, plane: Plane | None = None) -> Skin:
    """Drawing data of a mesh: split along its creases, with the field that it may carry, cut where asked.

    Raises GeometryEngineError where a plane is given and the mesh bounds no body.
    """
    shaded = shade(mesh)
    group = np.zeros(len(mesh.faces), np.uint8) if mesh.group is None else mesh.group
    lines = mesh.vertices[crease_lines(mesh)]
    columns = [mesh.vertices[shaded.source], shaded.normals]
    if field is not None and field in mesh.fields:
        columns.append(mesh.fields[field][shaded.source][:, None])
    table, faces, groups, hatch = np.hstack(columns), shaded.faces, mesh.groups, np.zeros((0, 2, 3))
    if plane is not None:
        table, faces, kept = _below(table, faces, plane.height(table[:, :3]))
        cap, outline = _cap(mesh, plane)
        padded = np.zeros((len(cap), table.shape[1]))
        padded[:, :3] = cap
        padded[:, 3:6] = np.array(plane.normal) / np.linalg.norm(plane.normal)
        added = np.arange(len(cap), dtype=np.int32).reshape(-1, 3) + np.int32(len(table))
        group = np.concatenate([group[kept], np.full(len(added), len(groups), np.uint8)])
        table, faces, groups = np.vstack([table, padded]), np.vstack([faces, added]), (*groups, _CUT)
        lines = np.concatenate([_lines_below(lines, plane), outline])
        hatch = _hatch(cap.reshape(-1, 3, 3), plane, float(np.ptp(mesh.vertices, axis=0).max()) / _HATCHES)
    values = table[:, 6] if table.shape[1] > 6 else None
    return Skin(table[:, :3], table[:, 3:6], values, faces, group, groups, lines, hatch)


def _below(table: Floats, faces: Ints, height: Floats) -> tuple[Floats, Ints, npt.NDArray[np.int64]]:
    """The part of the triangles below height 0: rows of data with the cut points, faces, and whose part each is."""
    low = (height <= 0.0)[faces]
    count = low.sum(axis=1)
    parts, source = [faces[count == 3]], [np.flatnonzero(count == 3)]
    added: list[Floats] = []
    start = len(table)
    for inside in (1, 2):
        chosen = np.flatnonzero(count == inside)
        odd = np.argmax(low[chosen] == (inside == 1), axis=1)  # the corner that is alone on its side
        a, b, c = (faces[chosen, (odd + k) % 3] for k in range(3))
        first = np.arange(len(chosen), dtype=np.int32) + np.int32(start)
        second = first + np.int32(len(chosen))
        start += 2 * len(chosen)
        for end in (b, c):
            share = (height[a] / (height[a] - height[end]))[:, None]
            added.append(table[a] + share * (table[end] - table[a]))
        made = [(a, first, second)] if inside == 1 else [(first, b, c), (first, c, second)]
        parts += [np.stack(corners, axis=1) for corners in made]
        source += [chosen] * len(made)
    return np.vstack([table, *added]), np.vstack(parts).astype(np.int32), np.concatenate(source)


def _lines_below(lines: Floats, plane: Plane) -> Floats:
    """The part of line segments (e, 2, 3) below the plane."""
    height = np.stack([plane.height(lines[:, k]) for k in range(2)], axis=1)
    kept = lines[np.any(height < 0.0, axis=1)].copy()
    height = height[np.any(height < 0.0, axis=1)]
    for k in range(2):
        above = height[:, k] > 0.0
        share = (height[above, k] / (height[above, k] - height[above, 1 - k]))[:, None]
        kept[above, k] += share * (kept[above, 1 - k] - kept[above, k])
    return kept


def _cap(mesh: Mesh, plane: Plane) -> tuple[Floats, Floats]:
    """Corners (3 n, 3) of the triangles that close the cut, and their outline (e, 2, 3)."""
    from camgeom.solid.engine import subtract

    closed = Mesh(mesh.vertices, mesh.faces)
    height = plane.height(mesh.vertices)
    if height.max() <= 0.0 or height.min() >= 0.0:
        return np.zeros((0, 3)), np.zeros((0, 2, 3))
    cut = subtract(closed, [_block(plane, 4.0 * float(np.abs(height).max() + np.ptp(mesh.vertices, axis=0).max()))])
    faces = cut.faces[cut.group_faces(_CUT)]
    faces = faces[np.abs(plane.height(cut.vertices[faces].mean(axis=1))) < 1e-6]
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    outline, times = np.unique(edges, axis=0, return_counts=True)
    return cut.vertices[faces].reshape(-1, 3), cut.vertices[outline[times == 1]]


def _hatch(cap: Floats, plane: Plane, spacing: float) -> Floats:
    """Parallel lines (e, 2, 3) at 45 degrees over the cut triangles (t, 3, 3), `spacing` mm apart."""
    _, along, up = _frame(plane)
    across = along + np.cross(up, along)
    place = cap @ across / (np.sqrt(2.0) * spacing)
    first, last = np.ceil(place.min(axis=1)), np.floor(place.max(axis=1))
    count = np.maximum(last - first + 1.0, 0.0).astype(int)
    triangle = np.repeat(np.arange(len(cap)), count)
    level = first[triangle] + np.arange(len(triangle)) - np.repeat(np.cumsum(count) - count, count)
    corner, value = cap[triangle], place[triangle]
    ends = np.full((len(triangle), 3, 3), np.nan)
    for k in range(3):
        a, b = value[:, k], value[:, (k + 1) % 3]
        met = (a <= level) != (b <= level)
        share = ((level - a)[met] / (b - a)[met])[:, None]
        ends[met, k] = corner[met, k] + share * (corner[met, (k + 1) % 3] - corner[met, k])
    met = np.isfinite(ends[:, :, 0])
    two = met.sum(axis=1) == 2
    return np.asarray(ends[two][met[two]].reshape(-1, 2, 3))


def _frame(plane: Plane) -> tuple[Floats, Floats, Floats]:
    """Unit vectors along the plane (two) and along its normal."""
    up = np.array(plane.normal) / np.linalg.norm(plane.normal)
    across = np.cross(up, np.eye(3)[int(np.argmin(np.abs(up)))])
    across /= np.linalg.norm(across)
    return across, np.cross(up, across), up


def _block(plane: Plane, size: float) -> Mesh:
    """A box of that size standing on the plane, all of one group."""
    axes = np.array(_frame(plane))
    corners = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (0.0, 1.0)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = np.array([(q[0], q[i], q[i + 1]) for q in quads for i in (1, 2)], dtype=np.int32)
    return Mesh(size * corners @ axes + np.array(plane.point), faces, (_CUT,))
