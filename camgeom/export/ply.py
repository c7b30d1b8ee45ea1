"""Binary PLY: double coordinates, result fields on the vertices, groups on the faces."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from camgeom.export import Body, common_fields, writer
from camgeom.export.files import atomic_write

_CHUNK = 65536


@writer(".ply", "binary PLY with result fields on the vertices; exact")
def write_ply(path: Path, bodies: Sequence[Body]) -> int:
    """Write the bodies to a little-endian PLY file in mm; returns the bytes written.

    Vertices carry x, y, z and every field as doubles, bit for bit; faces carry `group` and `body`, whose names stand in
    comments. Raises ExportError where the bodies' fields differ or the file cannot be written.
    """
    names = common_fields(path, bodies)
    with atomic_write(path) as stream:
        stream.write(_header(bodies, names))
        for body in bodies:
            columns = np.column_stack([body.mesh.vertices, *(body.mesh.fields[name] for name in names)])
            stream.write(np.ascontiguousarray(columns, dtype="<f8").data)
        face = np.dtype([("count", "u1"), ("corners", "<i4", 3), ("group", "u1"), ("body", "<i4")])
        first = 0
        for number, body in enumerate(bodies):
            mesh = body.mesh
            for start in range(0, len(mesh.faces), _CHUNK):
                part = slice(start, start + _CHUNK)
                block = np.empty(len(mesh.faces[part]), dtype=face)
                block["count"], block["body"] = 3, number
                block["corners"] = mesh.faces[part] + np.int32(first)
                block["group"] = 0 if mesh.group is None else mesh.group[part]
                stream.write(block.data)
            first += len(mesh.vertices)
        return stream.tell()


def _header(bodies: Sequence[Body], names: Sequence[str]) -> bytes:
    lines = ["ply", "format binary_little_endian 1.0", "comment camgeom, lengths in mm"]
    for number, body in enumerate(bodies):
        lines.append(f"comment body {number} {_word(body.name)}")
        lines += [f"comment body {number} group {i} {_word(group)}" for i, group in enumerate(body.mesh.groups)]
    lines.append(f"element vertex {sum(len(body.mesh.vertices) for body in bodies)}")
    lines += [f"property double {_word(name)}" for name in ("x", "y", "z", *names)]
    lines.append(f"element face {sum(len(body.mesh.faces) for body in bodies)}")
    lines += ["property list uchar int vertex_indices", "property uchar group", "property int body", "end_header"]
    return ("\n".join(lines) + "\n").encode("ascii")


def _word(name: str) -> str:
    """A name as one ASCII word, as the header wants it."""
    return "_".join(name.encode("ascii", "backslashreplace").decode().split()) or "unnamed"
