"""VTU: the unstructured grid that ParaView and other post-processors read; raw binary, exact."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path

import numpy as np
import numpy.typing as npt

from camgeom.export import NamedMesh, common_fields, writer
from camgeom.export.files import atomic_write

_TYPES = {"f8": "Float64", "i4": "Int32", "i8": "Int64", "u1": "UInt8", "u2": "UInt16"}
_TRIANGLE = 5


@writer(".vtu", "VTU for ParaView with result fields and face groups; exact")
def write_vtu(path: Path, bodies: Sequence[NamedMesh]) -> int:
    """Write the bodies to a VTU file in mm, doubles bit for bit; returns the bytes written.

    Point data: every field. Cell data: `group` and `body`, numbers whose names stand in the comment at the head. Raises
    ExportError where the bodies' fields differ or the file cannot be written.
    """
    names = common_fields(path, bodies)
    sections = _sections(bodies, names)
    lines, offset = [], 0
    for section, arrays in sections.items():
        lines.append(f"<{section}>")
        for name, array in arrays.items():
            parts = "" if array.ndim == 1 else f' NumberOfComponents="{array.shape[1]}"'
            kind = _TYPES[array.dtype.str[1:]]
            lines.append(
                f'<DataArray type="{kind}" Name="{escape(name)}"{parts} format="appended" offset="{offset}"/>'
            )
            offset += 8 + array.nbytes
        lines.append(f"</{section}>")
    points, cells = len(sections["Points"]["Points"]), len(sections["Cells"]["types"])
    head = "\n".join(
        [
            '<?xml version="1.0"?>',
            f"<!-- {_names(bodies)} -->",
            '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">',
            "<UnstructuredGrid>",
            f'<Piece NumberOfPoints="{points}" NumberOfCells="{cells}">',
            *lines,
            "</Piece>",
            "</UnstructuredGrid>",
            '<AppendedData encoding="raw">',
            "_",
        ]
    )
    with atomic_write(path) as stream:
        stream.write(head.encode("utf-8"))
        for arrays in sections.values():
            for array in arrays.values():
                stream.write(np.uint64(array.nbytes).tobytes())
                stream.write(array.data)
        stream.write(b"\n</AppendedData>\n</VTKFile>\n")
        return stream.tell()


def _sections(bodies: Sequence[NamedMesh], names: Sequence[str]) -> dict[str, dict[str, npt.NDArray[np.generic]]]:
    """The file's arrays by section and name, little endian and contiguous."""
    starts = np.cumsum([0] + [len(body.mesh.vertices) for body in bodies])
    faces = np.concatenate([body.mesh.faces + np.int32(start) for body, start in zip(bodies, starts)])
    group = [body.mesh.face_groups for body in bodies]
    number = [np.full(len(body.mesh.faces), i) for i, body in enumerate(bodies)]
    fields = {name: np.concatenate([body.mesh.fields[name] for body in bodies]) for name in names}
    return {
        "PointData": {name: _as(values, "<f8") for name, values in fields.items()},
        "CellData": {"group": _as(np.concatenate(group), "u1"), "body": _as(np.concatenate(number), "<u2")},
        "Points": {"Points": _as(np.concatenate([body.mesh.vertices for body in bodies]), "<f8")},
        "Cells": {
            "connectivity": _as(faces.ravel(), "<i4"),
            "offsets": _as(np.arange(3, 3 * len(faces) + 3, 3), "<i8"),
            "types": np.full(len(faces), _TRIANGLE, np.uint8),
        },
    }


def _as(values: npt.NDArray[np.generic], kind: str) -> npt.NDArray[np.generic]:
    return np.ascontiguousarray(values, dtype=kind)


def _names(bodies: Sequence[NamedMesh]) -> str:
    """What the numbers of bodies and groups mean; no `--`, which would end the comment."""
    text = "; ".join(
        f"body {i} {body.name}: " + ", ".join(f"group {k} {group}" for k, group in enumerate(body.mesh.groups))
        for i, body in enumerate(bodies)
    )
    shown = "".join(c if c.isprintable() else " " for c in f"camgeom, lengths in mm; {text}")
    return shown.replace("-", "\u2010").encode("utf-8", "replace").decode("utf-8")
