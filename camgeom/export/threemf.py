"""3MF: what slicers and printers read; a zip file of XML, written straight into it."""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from html import escape
from pathlib import Path
from typing import IO, Any

from camgeom.export import NamedMesh, writer
from camgeom.export.files import atomic_write, number_lines
from camgeom.maths.threads import shared
from camgeom.version import __version__

_NAMESPACE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_CONTENT_TYPES = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
    '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>'
)
_RELATIONS = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    '<Relationship Target="/3D/3dmodel.model" Id="rel0" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
)
_DEFAULT_COLOUR = (0.72, 0.74, 0.77)
_DECIMALS = 7
_LARGE = 1 << 31


@writer(".3mf", "3MF for slicers and printers, one object a body; coordinates to 1e-7 mm")
def write_3mf(path: Path, bodies: Sequence[NamedMesh]) -> int:
    """Write the bodies to a 3MF file (core specification, mm), coordinates to 1e-7 mm; returns the bytes written.

    One object and one build item a body, in the place where it stands in the cam frame; the colour as a base material.
    A mesh that is not closed is written as an object of type `surface`, as the specification asks. Groups and fields
    have no place in it. Raises ExportError where the file cannot be written.
    """
    with atomic_write(path) as stream:
        with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as package:
            package.writestr(_entry("[Content_Types].xml"), _CONTENT_TYPES)
            package.writestr(_entry("_rels/.rels"), _RELATIONS)
            size = sum(90 * len(body.mesh.vertices) + 60 * len(body.mesh.faces) for body in bodies)
            with package.open(_entry("3D/3dmodel.model"), "w", force_zip64=size > _LARGE) as model:
                _write_model(model, path.stem, bodies)
        return stream.seek(0, 2)


def _entry(name: str) -> zipfile.ZipInfo:
    """An entry dated 1980, so that equal solids give equal files."""
    entry = zipfile.ZipInfo(name)
    entry.compress_type = zipfile.ZIP_DEFLATED
    return entry


def _write_model(model: IO[bytes], title: str, bodies: Sequence[NamedMesh]) -> None:
    def put(text: str) -> None:
        model.write(text.encode("utf-8"))

    put('<?xml version="1.0" encoding="UTF-8"?>\n')
    put(f'<model unit="millimeter" xml:lang="en-US" xmlns="{_NAMESPACE}">\n')
    put(f'<metadata name="Title">{escape(_plain(title))}</metadata>\n')
    put(f'<metadata name="Application">camgeom {__version__}</metadata>\n<resources>\n<basematerials id="1">\n')
    for body in bodies:
        put(f'<base name="{escape(_plain(body.name))}" displaycolor="{_hex(body)}"/>\n')
    put("</basematerials>\n")
    for number, body in enumerate(bodies):
        kind = "model" if body.mesh.watertight else "surface"
        put(f'<object id="{number + 2}" type="{kind}" name="{escape(_plain(body.name))}" pid="1" pindex="{number}">')
        put("<mesh>\n<vertices>\n")
        vertices = number_lines(body.mesh.vertices, (b'<vertex x="', b'" y="', b'" z="'), b'"/>\n', _DECIMALS)
        _packed(model, vertices)
        put("</vertices>\n<triangles>\n")
        triangles = number_lines(body.mesh.faces, (b'<triangle v1="', b'" v2="', b'" v3="'), b'"/>\n')
        _packed(model, triangles)
        put("</triangles>\n</mesh></object>\n")
    items = "".join(f'<item objectid="{number + 2}"/>\n' for number in range(len(bodies)))
    put(f"</resources>\n<build>\n{items}</build>\n</model>\n")


def _packed(model: IO[bytes], chunks: Iterator[bytes]) -> None:
    """Write the chunks, the next one being made while this one is packed; both work outside Python's lock."""
    chunk = next(chunks, None)
    while chunk is not None:
        both: tuple[Callable[[], Any], ...] = (partial(next, chunks, None), partial(model.write, chunk))
        chunk, _ = shared(lambda job: job(), both, 2)


def _plain(text: str) -> str:
    """Text without the control characters and lone surrogates that XML cannot hold."""
    shown = "".join(c if c.isprintable() else " " for c in text)
    return shown.encode("utf-8", "replace").decode("utf-8")


def _hex(body: NamedMesh) -> str:
    return "#" + "".join(f"{round(255 * max(0.0, min(1.0, c))):02X}" for c in body.colour or _DEFAULT_COLOUR)
