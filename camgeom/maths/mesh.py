"""A triangle mesh as plain arrays, with the facts a solid is judged by: volume, area, closedness, genus."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats

Ints = npt.NDArray[np.int32]


@dataclass(frozen=True, eq=False)
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
        a, b, c = (self.vertices[self.faces[:, i]] for i in range(3))
        centre = self.vertices.mean(axis=0)
        return float(np.einsum("fi,fi->", a - centre, np.cross(b - centre, c - centre)) / 6.0)

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
        keys.sort()
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

    @property
    def shells(self) -> tuple[Mesh, ...]:
        """Every connected shell as a mesh of its own, without groups and fields."""
        owner = self._labels[self.faces[:, 0]]
        found = []
        for label in np.unique(owner):
            used, index = np.unique(self.faces[owner == label], return_inverse=True)
            found.append(Mesh(self.vertices[used], index.reshape(-1, 3).astype(np.int32)))
        return tuple(found)

    @cached_property
    def _labels(self) -> npt.NDArray[np.int64]:
        """The shell of each vertex (v,), named by its first vertex: trees hooked onto smaller names and flattened."""
        label = np.arange(len(self.vertices))
        # Two edges of each triangle join all three corners.
        a = self.faces[:, [0, 1]].ravel().astype(np.int64)
        b = self.faces[:, [1, 2]].ravel().astype(np.int64)
        while len(a):
            low, high = np.minimum(a, b), np.maximum(a, b)
            label[high] = low
            while not np.array_equal(label, flat := label[label]):
                label = flat
            a, b = label[a], label[b]
            apart = a != b
            a, b = a[apart], b[apart]
        return label

    @property
    def genus(self) -> int:
        """Number of through holes summed over the shells: components - euler / 2."""
        return self.components - self.euler // 2

    @cached_property
    def seam_vertices(self) -> npt.NDArray[np.bool_]:
        """Mask (v,) of the vertices at which faces of different groups meet."""
        if self.group is None:
            return np.zeros(len(self.vertices), dtype=bool)
        low = np.full(len(self.vertices), 255, dtype=np.uint8)
        high = np.zeros(len(self.vertices), dtype=np.uint8)
        for k in range(3):
            np.minimum.at(low, self.faces[:, k], self.group)
            np.maximum.at(high, self.faces[:, k], self.group)
        return np.asarray(low < high)

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
        import pyvista

        made = pyvista.PolyData.from_regular_faces(self.vertices, self.faces)
        for name, values in self.fields.items():
            made.point_data[name] = values
        if self.group is not None:
            made.cell_data["group"] = self.group
        made.field_data["groups"] = list(self.groups)
        return made

    def group_faces(self, name: str) -> npt.NDArray[np.bool_]:
        """Mask (f,) of the faces in the named group; all False where the name is absent."""
        if name not in self.groups:
            return np.zeros(len(self.faces), dtype=bool)
        if self.group is None:
            return np.full(len(self.faces), self.groups[0] == name)
        return np.asarray(self.group == self.groups.index(name))
