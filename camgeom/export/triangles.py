"""Binary STL: triangles only, float32."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from camgeom.export import Body, writer
from camgeom.export.files import atomic_write
from camgeom.maths.mesh import Mesh

_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEADER = b"camgeom, lengths in mm".ljust(80)
_CHUNK = 8192
"""Triangles at a time, so that the working arrays stay in the cache."""


@writer(".stl", "binary STL; coordinates rounded to float32, names and fields lost")
def write_stl(path: Path, bodies: Sequence[Body]) -> int:
    """Write the bodies' triangles to a binary STL file in mm; returns the bytes written.

    The format holds float32: a coordinate is rounded by at most 6e-8 of its size (4e-6 mm at 67 mm). Vertices shared in
    the mesh stay equal to the last bit, so a closed mesh stays closed; names, groups and fields have no place in it.
    The normals are those of the rounded triangles; 0 where one has no area. Raises ExportError where the file cannot be
    written.
    """
    with atomic_write(path) as stream:
        stream.write(_HEADER + np.uint32(sum(len(body.mesh.faces) for body in bodies)).tobytes())
        for body in bodies:
            for block in _blocks(body.mesh):
                stream.write(block)
        return stream.tell()


def _blocks(mesh: Mesh) -> Iterator[memoryview]:
    """Triangles as the file holds them, some at a time."""
    vertices = mesh.vertices.astype(np.float32)
    for start in range(0, len(mesh.faces), _CHUNK):
        faces = mesh.faces[start : start + _CHUNK]
        block = np.zeros(len(faces), dtype=_TRIANGLE)
        corners = vertices.take(faces, axis=0)
        block["corners"] = corners
        x, y, z = corners.transpose(2, 1, 0).astype(np.float64, order="C")
        bx, by, bz, cx, cy, cz = x[1] - x[0], y[1] - y[0], z[1] - z[0], x[2] - x[0], y[2] - y[0], z[2] - z[0]
        normal = (by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx)
        length = np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
        length[length == 0.0] = 1.0
        for axis in range(3):
            block["normal"][:, axis] = normal[axis] / length
        yield block.data
