"""Triangles for other programs: binary STL (float32), Wavefront OBJ (text), binary PLY (exact, with fields)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from camgeom.errors import ExportError
from camgeom.export import NamedMesh, common_fields, writer
from camgeom.export.files import atomic_write, number_lines
from camgeom.maths.mesh import Mesh

_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEADER = b"camgeom, lengths in mm".ljust(80)
_CHUNK = 8192
"""Triangles at a time, so that the working arrays stay in the cache."""
_PLY_CHUNK = 65536


NOTED = 0.1
"""share of a tolerance beyond which rounding is worth a word"""


def rounding(mesh: Mesh) -> float:
    """Largest distance that rounding to float32 moves a vertex, mm: half a unit in the last place of the largest
    coordinate in each direction."""
    largest = np.abs(mesh.vertices).max(axis=0).astype(np.float32)
    return float(np.sqrt(((0.5 * np.spacing(largest).astype(np.float64)) ** 2).sum()))


@writer(".stl", "binary STL; coordinates rounded to float32, names and fields lost")
def write_stl(path: Path, bodies: Sequence[NamedMesh], tolerance: float | None = None) -> int:
    """Write the bodies' triangles to a binary STL file in mm; returns the bytes written.

    The format holds float32: a coordinate is rounded by at most 6e-8 of its size (4e-6 mm at 67 mm). Vertices shared in
    the mesh stay equal to the last bit, so a closed mesh stays closed; names, groups and fields have no place in it.
    The normals are those of the rounded triangles; 0 where one has no area. Raises ExportError where that is more than
    a tolerance (mm) that the file is to keep, or the file cannot be written.
    """
    lost = max(rounding(body.mesh) for body in bodies)
    if tolerance is not None and lost > tolerance:
        raise ExportError(
            f"{path}: the 32-bit coordinates of STL are off by up to {lost:.2g} mm, more than the tolerance "
            f"{tolerance:g} mm; ask for 3mf, ply or step, or for a coarser tolerance"
        )
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


@writer(".obj", "Wavefront OBJ text with groups; coordinates to 1e-9 mm")
def write_obj(path: Path, bodies: Sequence[NamedMesh]) -> int:
    """Write the bodies to an OBJ file in mm, coordinates to 1e-9 mm; returns the bytes written.

    Each body is an object (`o`), each of its face groups a group (`g body_group`). Fields have no place in the format.
    Raises ExportError where the file cannot be written.
    """
    with atomic_write(path) as stream:
        stream.write(b"# camgeom, lengths in mm\n")
        first = 1
        for body in bodies:
            mesh, name = body.mesh, _word(body.name)
            stream.write(f"o {name}\n".encode())
            stream.writelines(number_lines(mesh.vertices, (b"v ", b" ", b" "), b"\n", decimals=9))
            for number, label in enumerate(mesh.groups):
                faces = mesh.faces[mesh.face_groups == number]
                if len(faces):
                    stream.write(f"g {name}_{_word(label)}\n".encode())
                    stream.writelines(number_lines(faces + np.int32(first), (b"f ", b" ", b" "), b"\n"))
            first += len(mesh.vertices)
        return stream.tell()


def _word(name: str) -> str:
    """A name as one word on one line."""
    return "_".join("".join(c if c.isprintable() else " " for c in name).split()) or "unnamed"


@writer(".ply", "binary PLY with result fields on the vertices; exact")
def write_ply(path: Path, bodies: Sequence[NamedMesh]) -> int:
    """Write the bodies to a little-endian PLY file in mm; returns the bytes written.

    Vertices carry x, y, z and every field as doubles, bit for bit; faces carry `group` and `body`, whose names stand in
    comments. Raises ExportError where the bodies' fields differ or the file cannot be written.
    """
    names = common_fields(path, bodies)
    with atomic_write(path) as stream:
        stream.write(_ply_header(bodies, names))
        for body in bodies:
            columns = np.column_stack([body.mesh.vertices, *(body.mesh.fields[name] for name in names)])
            stream.write(np.ascontiguousarray(columns, dtype="<f8").data)
        face = np.dtype([("count", "u1"), ("corners", "<i4", 3), ("group", "u1"), ("body", "<i4")])
        first = 0
        for number, body in enumerate(bodies):
            mesh = body.mesh
            for start in range(0, len(mesh.faces), _PLY_CHUNK):
                part = slice(start, start + _PLY_CHUNK)
                block = np.empty(len(mesh.faces[part]), dtype=face)
                block["count"], block["body"] = 3, number
                block["corners"] = mesh.faces[part] + np.int32(first)
                block["group"] = mesh.face_groups[part]
                stream.write(block.data)
            first += len(mesh.vertices)
        return stream.tell()


def _ply_header(bodies: Sequence[NamedMesh], names: Sequence[str]) -> bytes:
    lines = ["ply", "format binary_little_endian 1.0", "comment camgeom, lengths in mm"]
    for number, body in enumerate(bodies):
        lines.append(f"comment body {number} {_ascii_word(body.name)}")
        lines += [f"comment body {number} group {i} {_ascii_word(group)}" for i, group in enumerate(body.mesh.groups)]
    lines.append(f"element vertex {sum(len(body.mesh.vertices) for body in bodies)}")
    lines += [f"property double {_ascii_word(name)}" for name in ("x", "y", "z", *names)]
    lines.append(f"element face {sum(len(body.mesh.faces) for body in bodies)}")
    lines += ["property list uchar int vertex_indices", "property uchar group", "property int body", "end_header"]
    return ("\n".join(lines) + "\n").encode("ascii")


def _ascii_word(name: str) -> str:
    """A name as one ASCII word, as the header wants it."""
    return "_".join(name.encode("ascii", "backslashreplace").decode().split()) or "unnamed"
