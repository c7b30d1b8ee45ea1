"""GLB (binary glTF 2.0): pictures in browsers, office programs and augmented reality."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from camgeom.errors import ExportError
from camgeom.export import Colour, NamedMesh, writer
from camgeom.export.files import atomic_write
from camgeom.maths.creases import shade
from camgeom.version import __version__

_STEEL: Colour = (0.72, 0.74, 0.77)
_FLANK: Colour = (0.30, 0.52, 0.74)
_UP = [-(0.5**0.5), 0.0, 0.0, 0.5**0.5]
"""Quaternion that lays the cam axis Z on the format's upward axis Y."""
_KINDS = {"<f4": 5126, "<u4": 5125, "|u1": 5121}
_ARRAY, _ELEMENT = 34962, 34963
_SCALE = np.array(
    [
        (68, 1, 84), (72, 40, 120), (62, 74, 137), (49, 104, 142), (38, 130, 142),
        (31, 158, 137), (53, 183, 121), (109, 205, 89), (180, 222, 44), (253, 231, 37),
    ]
) / 255.0  # fmt: skip
"""Dark blue over green to yellow at equal steps of lightness, safe for the colour-blind."""


@writer(".glb", "GLB (glTF 2.0) for viewers, one primitive a face group; float32")
def write_glb(path: Path, bodies: Sequence[NamedMesh], colour_by: str | None = None, crease: float = 30.0) -> int:
    """Write the bodies to a GLB file; returns the bytes written.

    The format wants metres and Y upward: the coordinates stay in mm (as float32, rounded by at most 6e-8 of their size)
    under one root node that scales by 0.001 and lays the cam axis on Y. Each body is a node, each of its face groups a
    primitive with a material of that name. Normals are smooth but split along creases of more than `crease` degrees and
    between groups. Fields are vertex attributes `_NAME`; `colour_by` names one to show as vertex colours.

    Raises ExportError where no body carries the field, the file would pass the format's 4 GiB, or it cannot be written.
    """
    if colour_by is not None and not any(colour_by in body.mesh.fields for body in bodies):
        raise ExportError(f"{path}: no body carries the field {colour_by!r} to colour by")
    root: dict[str, Any] = {"name": path.stem, "rotation": _UP, "scale": [0.001] * 3, "children": []}
    root["extras"] = {"unit": "mm", "note": "mm in the cam frame under this node, which turns them into metres, Y up"}
    document: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": f"camgeom {__version__}"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [root],
        "meshes": [],
        "materials": [],
        "accessors": [],
        "bufferViews": [],
    }
    blocks: list[npt.NDArray[np.generic]] = []
    for number, body in enumerate(bodies):
        primitives = _primitives(document, blocks, body, colour_by, crease)
        document["meshes"].append({"name": body.name, "primitives": primitives})
        document["nodes"].append({"name": body.name, "mesh": number})
        root["children"].append(number + 1)
    size = sum(block.nbytes for block in blocks)
    document["buffers"] = [{"byteLength": size}]
    text = json.dumps(document, separators=(",", ":"), allow_nan=False).encode("utf-8")
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + size
    if total >= 1 << 32:
        raise ExportError(f"{path}: {total} bytes are more than a GLB file can hold (4 GiB); use a coarser tolerance")
    with atomic_write(path) as stream:
        stream.write(b"glTF" + np.array([2, total, len(text)], "<u4").tobytes() + b"JSON" + text)
        stream.write(np.uint32(size).tobytes() + b"BIN\0")
        for block in blocks:
            stream.write(block.data)
        return stream.tell()


def _primitives(
    document: dict[str, Any], blocks: list[npt.NDArray[np.generic]], body: NamedMesh, colour_by: str | None,
    crease: float,
) -> list[dict[str, Any]]:
    """One primitive a face group; they share the body's vertices."""
    mesh = body.mesh
    shaded = shade(mesh, crease)

    def accessor(values: npt.NDArray[np.generic], target: int, **more: Any) -> int:
        shape = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}[1 if values.ndim == 1 else values.shape[1]]
        offset = sum(view["byteLength"] for view in document["bufferViews"])
        view = {"buffer": 0, "byteOffset": offset, "byteLength": values.nbytes, "target": target}
        document["bufferViews"].append(view)
        blocks.append(np.ascontiguousarray(values))
        kind = _KINDS[values.dtype.str]
        entry = {"bufferView": len(blocks) - 1, "componentType": kind, "count": len(values), "type": shape, **more}
        document["accessors"].append(entry)
        return len(blocks) - 1

    points = mesh.vertices.astype("<f4")[shaded.source]
    bounds = {"min": points.min(axis=0).tolist(), "max": points.max(axis=0).tolist()}
    attributes = {
        "POSITION": accessor(points, _ARRAY, **bounds),
        "NORMAL": accessor(shaded.normals.astype("<f4"), _ARRAY),
    }
    for name, values in mesh.fields.items():
        attributes["_" + "_".join(name.upper().split())] = accessor(values[shaded.source].astype("<f4"), _ARRAY)
    coloured = colour_by is not None and colour_by in mesh.fields
    if colour_by is not None and coloured:
        colours = _colours(mesh.fields[colour_by])[shaded.source]
        attributes["COLOR_0"] = accessor(colours, _ARRAY, normalized=True)
    primitives = []
    for number, label in enumerate(mesh.groups):
        faces = shaded.faces[mesh.face_groups == number]
        if len(faces):
            colour = (1.0, 1.0, 1.0) if coloured else body.colour or (_FLANK if label.startswith("flank") else _STEEL)
            document["materials"].append(_material(label, colour))
            indices = accessor(faces.ravel().astype("<u4"), _ELEMENT)
            material = len(document["materials"]) - 1
            primitives.append({"attributes": attributes, "indices": indices, "material": material})
    return primitives


def _material(name: str, colour: Colour) -> dict[str, Any]:
    linear = _linear(np.array(colour)).tolist()
    surface = {"baseColorFactor": [*linear, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.5}
    return {"name": name, "pbrMetallicRoughness": surface}


def _linear(srgb: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Light from sRGB values (IEC 61966-2-1), both 0 to 1."""
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def _colours(values: npt.NDArray[np.float64]) -> npt.NDArray[np.uint8]:
    """Vertex colours (v, 4) on the scale from the smallest to the largest value."""
    low, high = float(values.min()), float(values.max())
    place = (values - low) / (high - low) if high > low else np.zeros(len(values))
    ticks = np.linspace(0.0, 1.0, len(_SCALE))
    srgb = np.column_stack([np.interp(place, ticks, _SCALE[:, i]) for i in range(3)])
    return np.rint(255.0 * np.column_stack([_linear(srgb), np.ones(len(values))])).astype(np.uint8)
