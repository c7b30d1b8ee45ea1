"""Wavefront OBJ: text, one object a body, one group a face group."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from camgeom.export import Body, writer
from camgeom.export.files import atomic_write
from camgeom.export.rows import rows


@writer(".obj", "Wavefront OBJ text with groups; coordinates to 1e-9 mm")
def write_obj(path: Path, bodies: Sequence[Body]) -> int:
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
            stream.writelines(rows(mesh.vertices, (b"v ", b" ", b" "), b"\n", decimals=9))
            group = np.zeros(len(mesh.faces), np.uint8) if mesh.group is None else mesh.group
            for number, label in enumerate(mesh.groups):
                faces = mesh.faces[group == number]
                if len(faces):
                    stream.write(f"g {name}_{_word(label)}\n".encode())
                    stream.writelines(rows(faces + np.int32(first), (b"f ", b" ", b" "), b"\n"))
            first += len(mesh.vertices)
        return stream.tell()


def _word(name: str) -> str:
    """A name as one word on one line."""
    return "_".join("".join(c if c.isprintable() else " " for c in name).split()) or "unnamed"
