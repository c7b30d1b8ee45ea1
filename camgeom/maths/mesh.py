"""A triangle mesh as plain arrays, with the facts a solid is judged by: volume, mass, area, closedness, genus; cuts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from camgeom.errors import not_installed
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.frozen import cached_property
from camgeom.maths.surface import cross, dot

Ints = npt.NDArray[np.int32]
Index = npt.NDArray[np.int64]
Labels = npt.NDArray[np.uint8]
Vector = tuple[float, float, float]


@immutable
class Mesh:
    """Triangles with outward orientation (counter-clockwise seen from outside).

    vertices  (v, 3) float64, mm
    faces     (f, 3) int32 vertex indices
    groups    face-group names (flank, floor, edge, land, end, bore ...)
    group     (f,) uint8 index into `groups`, or None where all faces are groups[0]
    fields    result fields on the vertices by name with unit (`contact_pressure_mpa`), each (v,) float64; NaN-free
    """

    vertices: Floats
    faces: Ints
    groups: tuple[str, ...] = ("surface",)
    group: npt.NDArray[np.uint8] | None = None
    fields: dict[str, Floats] = field(default_factory=dict)

    @cached_property
    def volume(self) -> float:
        """Enclosed volume, mm³ (divergence theorem about the vertex centroid to keep digits)."""
        about = np.ascontiguousarray((self.vertices - self.vertices.mean(axis=0)).T)
        a, b, c = (about.take(self.faces[:, i], axis=1) for i in range(3))
        return float(np.einsum("fi,fi->", np.ascontiguousarray(a.T), np.ascontiguousarray(cross(b, c).T)) / 6.0)

    @cached_property
    def face_areas(self) -> Floats:
        """Area of each triangle, mm², (f,)."""
        a, b, c = (self.vertices[self.faces[:, i]] for i in range(3))
        n = np.cross(b - a, c - a)
        return np.asarray(0.5 * np.sqrt(np.einsum("fi,fi->f", n, n)))

    @property
    def area(self) -> float:
        """Surface area, mm²."""
        return float(self.face_areas.sum())

    @cached_property
    def watertight(self) -> bool:
        """Every directed edge is met exactly once by its opposite: closed, oriented, two-manifold along edges."""
        if len(self.faces) == 0:
            return False
        start, end = self.faces.ravel(), self.faces[:, [1, 2, 0]].ravel()
        forward = start < end
        low, high = np.where(forward, start, end), np.where(forward, end, start)
        # One key an edge, its last bit the direction: sorted, each pair must be one edge run both ways.
        keys = ((low.astype(np.int64) * len(self.vertices) + high) << 1) | forward
        keys.sort(kind="stable")  # runs of rising numbers: a fifth of the time
        if len(keys) % 2 or np.any(low == high):
            return False
        even, odd = keys[::2], keys[1::2]
        return bool(np.all(even & 1 == 0) and np.all(odd == even + 1) and np.all(even[1:] > odd[:-1]))

    @cached_property
    def euler(self) -> int:
        """Euler characteristic V - E + F of the used vertices."""
        used = np.zeros(len(self.vertices), dtype=bool)
        used[self.faces] = True
        return int(used.sum()) - 3 * len(self.faces) // 2 + len(self.faces)

    @cached_property
    def components(self) -> int:
        """Number of connected shells."""
        used = np.zeros(len(self.vertices), dtype=bool)
        used[self.faces] = True
        return int(np.count_nonzero(used & (self._labels == np.arange(len(used)))))

    @cached_property
    def shells(self) -> tuple[Mesh, ...]:
        """Every connected shell as a mesh of its own, without groups and fields."""
        owner = self._labels[self.faces[:, 0]]
        found = []
        for label in distinct(owner):
            used, index = np.unique(self.faces[owner == label], return_inverse=True)
            found.append(Mesh(self.vertices[used], index.reshape(-1, 3).astype(np.int32)))
        return tuple(found)

    @cached_property
    def _labels(self) -> npt.NDArray[np.int64]:
        """The shell of each vertex (v,), named by its first vertex."""
        # Two edges of each triangle join all three corners.
        a = self.faces[:, [0, 1]].ravel().astype(np.int64)
        b = self.faces[:, [1, 2]].ravel().astype(np.int64)
        return joined(len(self.vertices), a, b)

    @property
    def genus(self) -> int:
        """Number of through holes summed over the shells: components - euler / 2."""
        return self.components - self.euler // 2

    def group_vertices(self, *names: str) -> npt.NDArray[np.bool_]:
        """Mask (v,) of the vertices of faces in any of the named groups."""
        mask = np.zeros(len(self.vertices), dtype=bool)
        for name in names:
            mask[self.faces[self.group_faces(name)]] = True
        return mask

    def to_trimesh(self) -> Any:
        """This mesh as a trimesh.Trimesh, vertices in the same order and place; fields and groups as its attributes."""
        import trimesh

        made = trimesh.Trimesh(self.vertices, self.faces, process=False)
        made.vertex_attributes.update(self.fields)
        if self.group is not None:
            made.face_attributes["group"] = self.group
        made.metadata["groups"] = list(self.groups)
        return made

    def to_pyvista(self) -> Any:
        """This mesh as a pyvista.PolyData: fields as point data, groups as cell data and their names as field data."""
        try:
            import pyvista
        except ImportError:
            raise not_installed("a pyvista mesh", "pyvista", "pictures") from None

        made = pyvista.PolyData.from_regular_faces(self.vertices, self.faces)
        for name, values in self.fields.items():
            made.point_data[name] = values
        if self.group is not None:
            made.cell_data["group"] = self.group
        made.field_data["groups"] = list(self.groups)
        return made

    @cached_property
    def face_groups(self) -> npt.NDArray[np.uint8]:
        """Index into `groups` of every face, (f,)."""
        return np.zeros(len(self.faces), np.uint8) if self.group is None else self.group

    def group_faces(self, name: str) -> npt.NDArray[np.bool_]:
        """Mask (f,) of the faces in the named group; all False where the name is absent."""
        if name not in self.groups:
            return np.zeros(len(self.faces), dtype=bool)
        return np.asarray(self.face_groups == self.groups.index(name))


def joined(count: int, a: npt.NDArray[np.int64], b: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """The group of each of `count` things, (count,), where a[i] and b[i] are of one, named by its first thing.

    Trees are hooked onto smaller names and flattened.
    """
    label = np.arange(count)
    while len(a):
        low, high = np.minimum(a, b), np.maximum(a, b)
        label[high] = low
        while not np.array_equal(label, flat := label[label]):
            label = flat
        a, b = label[a], label[b]
        apart = a != b
        a, b = a[apart], b[apart]
    return label


def mass_properties(mesh: Mesh, density: float) -> tuple[float, float, Vector, tuple[Vector, ...]]:
    """Volume mm³, mass kg, centroid mm, inertia tensor about the centroid kg m² of a closed mesh; density kg/m³.

    Signed tetrahedra from the vertex mean (to keep digits); the second moments of a tetrahedron with one corner at the
    origin are V/20 (sum_i p_i p_i^T + (sum p)(sum p)^T) over its three other corners.
    """
    origin = mesh.vertices.mean(axis=0)
    p = mesh.vertices[mesh.faces] - origin
    a, b, c = (np.ascontiguousarray(p[:, k].T) for k in range(3))
    volume = dot(a, cross(b, c)) / 6.0
    total = float(volume.sum())
    together = a + b + c
    centre = (volume * together).sum(axis=1) / 4.0 / total
    second = np.zeros((3, 3))
    for x in (a, b, c, together):
        for i, row in enumerate(volume * x):
            second[i] += (row * x).sum(axis=1) / 20.0
    about = second - total * np.outer(centre, centre)
    inertia = (np.trace(about) * np.eye(3) - about) * density * 1e-15
    where = origin + centre
    rows = tuple((float(r[0]), float(r[1]), float(r[2])) for r in inertia)
    return total, total * density * 1e-9, (float(where[0]), float(where[1]), float(where[2])), rows


Place = Callable[[Index, Index, Floats], Floats]


def clip(
    points: Floats, faces: Index, label: Labels, height: float, sign: float, place: Place | None = None
) -> tuple[Floats, Index, Labels]:
    """What of a mesh lies at sign * (z - height) <= 0: points (v, 3), faces (f, 3) and their labels (f,).

    A cut edge gets one new point, numbered after all the old ones: straight between its ends, or where
    place(end, other end, straight point) puts it. Faces that only touch the plane are left out, so that the mesh ends
    there.
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
    new, (to_p, to_q) = _crossings(points, s, height, o, (p, q), place)
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
    points: Floats, s: Floats, height: float, start: Index, ends: tuple[Index, ...], place: Place | None
) -> tuple[Floats, list[Index]]:
    """New points where edges cross the plane, and the vertex of each crossing; an end on the plane is its own."""
    a, b = np.tile(start, len(ends)).astype(np.int64), np.concatenate(ends)
    on = s[b] == 0.0
    # A number of both ends needs twice the bits of one.
    key = np.minimum(a, b) * len(points) + np.maximum(a, b)
    unique, number = np.unique(key[~on], return_inverse=True)
    i, j = unique // len(points), unique % len(points)
    share = (s[i] / (s[i] - s[j]))[:, None]
    new = points[i] + share * (points[j] - points[i])
    new[:, 2] = height
    if place is not None:
        new = place(i, j, new)
    found = b.copy()
    found[~on] = len(points) + number.reshape(-1)
    return new, np.split(found, len(ends))


def rowed(mesh: Mesh, heights: Floats, name: str) -> Mesh:
    """The same surface with the faces of a group cut along planes of these heights z, mm, for results between them.

    Planes through a vertex are left out. Fields are not carried over.
    """
    points, faces, label = mesh.vertices, mesh.faces, mesh.face_groups
    group = mesh.groups.index(name) if name in mesh.groups else -1
    for height in _halving(heights.tolist()):
        s = points[:, 2] - height
        if np.abs(s).min() <= 1e-9 * np.abs(s).max():
            continue
        corner = s[faces] > 0.0
        cut = (label == group) & corner.any(axis=1) & ~corner.all(axis=1)
        tri, out = faces[cut], corner[cut]
        single = out.sum(axis=1) == 1
        odd = np.where(single, np.argmax(out, axis=1), np.argmin(out, axis=1))
        p, q, o = np.take_along_axis(tri, (odd[:, None] + np.array([1, 2, 3])) % 3, axis=1).T
        new, (to_p, to_q) = _crossings(points, s, height, o, (p, q), None)
        parts = [np.stack(each, axis=1) for each in ((p, q, to_q), (p, to_q, to_p), (to_p, to_q, o))]
        points = np.concatenate([points, new])
        faces = np.concatenate([faces[~cut], *parts]).astype(faces.dtype)
        label = np.concatenate([label[~cut], *(np.full(len(part), group, label.dtype) for part in parts)])
    return replace(mesh, vertices=points, faces=faces, group=label, fields={})


def _halving(heights: list[float]) -> list[float]:
    """The same, the middle one first, then those of the halves, so that long triangles are cut least often."""
    parts, order = [sorted(heights)], []
    while parts:
        part = parts.pop(0)
        if part:
            middle = len(part) // 2
            order.append(part[middle])
            parts += [part[:middle], part[middle + 1 :]]
    return order


def open_loops(faces: Index, on: npt.NDArray[np.bool_]) -> list[Index] | None:
    """Loops (n,) of vertex numbers in which faces end, along their own direction; edges between marked vertices only.

    None where the ends do not join up to simple loops (a vertex is met twice, or an end is missing).
    """
    marked = on[faces]
    near = faces[marked.sum(axis=1) >= 2]
    edges = np.concatenate([near[:, [0, 1]], near[:, [1, 2]], near[:, [2, 0]]])
    edges = edges[on[edges].all(axis=1)]
    size = np.int64(len(on))
    forth, back = edges[:, 0] * size + edges[:, 1], np.sort(edges[:, 1] * size + edges[:, 0])
    single = np.searchsorted(back, forth, side="left") == np.searchsorted(back, forth, side="right")
    start, stop = edges[single].T
    if len(distinct(start)) < len(start) or not np.array_equal(np.sort(start), np.sort(stop)):
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
