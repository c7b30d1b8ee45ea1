"""Volume meshes for finite element programs: elements, sets, held bore, and the contact's load at one cam angle.

CalculiX and Abaqus input and Nastran bulk data are written here, because a solver runs them as they are: material, sets
and one linear step. VTU and Gmsh, which carry a mesh with fields, are written by meshio, on a mesh of its own: it turns
sets into fields of the mesh that it is given. XDMF is written here too: meshio asks for
h5py even where no HDF5 is wanted.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from camgeom.errors import CamgeomError, ExportError
from camgeom.export import NO_PLATE, writer
from camgeom.export.files import atomic_write, write_whole
from camgeom.maths import Floats

if TYPE_CHECKING:
    from camgeom.body.volume import Volume
    from camgeom.model import Model

Index = npt.NDArray[np.int64]
CAMS = "with a bore; no linear"
KINDS = {"hexahedron20": ("C3D20", "Hexahedron_20"), "tetra10": ("C3D10", "Tetrahedron_10")}
"""names of the elements in Abaqus' and XDMF's files"""


NO_LOAD = "there is no [operation]: no load for a volume file"
_Write = Callable[[Path, "Volume"], int]


def _missing(model: Model) -> str:
    if model.profile.operation is None:
        return NO_LOAD
    from camgeom.body.groove import NO_BORE
    from camgeom.body.volume import unfilled

    reason = ""
    with suppress(CamgeomError):  # what keeps the body from being made at all is told where it is made
        reason = unfilled(model.parts, model.cutters, [one.cutters for one in model.grooves])
    return reason or ("" if model.mechanism.bore is not None else NO_BORE)


def _no_frame(model: Model) -> str:
    return NO_PLATE if model.mechanism.frame is None else "" if model.profile.operation else NO_LOAD


def volume_writer(extension: str, about: str) -> Callable[[_Write], _Write]:
    """Register a function as the writer of a cam's volume and of that of the frame about it."""

    def register(function: _Write) -> _Write:
        writer(f".frame{extension}", f"frame about a cam: {about}", takes="frame_volume", cams="frames with a plate",
               missing=_no_frame)(function)  # fmt: skip
        return writer(extension, about, takes="volume", cams=CAMS, missing=_missing)(function)

    return register


@volume_writer(".volume.inp", "elements, sets, load and one linear step: input of CalculiX and Abaqus")
def write_inp(path: Path, volume: Volume) -> int:
    """Write a file that `ccx` runs as it is; returns its bytes. Raises ExportError where it cannot be written."""
    material = volume.material
    forced = np.flatnonzero(np.abs(volume.forces).sum(axis=1) > 0.0)
    loads = (f"{node + 1},{k + 1},{volume.forces[node, k]:.10e}" for node in forced for k in range(3))
    lines: Iterable[str] = chain(
        (f"** {line}" for line in volume.about),
        ("*HEADING", volume.name, "*NODE, NSET=all"),
        (f"{i + 1},{x:.10e},{y:.10e},{z:.10e}" for i, (x, y, z) in enumerate(volume.nodes.tolist())),
        (f"*ELEMENT, TYPE={KINDS[volume.cell][0]}, ELSET=body",),
        _elements(volume.elements),
        chain.from_iterable(_node_set(name, nodes + 1) for name, nodes in volume.sets.items()),
        ("*SURFACE, NAME=contour, TYPE=ELEMENT",),
        (f"{element + 1},S{face + 1}" for element, face in volume.pressed_faces.tolist()),
        ("*MATERIAL, NAME=body_material", "*ELASTIC", f"{material.elastic_modulus:.10g},{material.poisson:.10g}"),
        ("*DENSITY", f"{material.density * 1e-12:.10g}", "*SOLID SECTION, ELSET=body, MATERIAL=body_material"),
        ("*BOUNDARY", f"{volume.held},1,3", "*STEP", "*STATIC", "*CLOAD"),
        loads,
        ("*NODE FILE", "U", "*EL FILE", "S", "*END STEP"),
    )
    return _written(path, lines)


def _elements(elements: Index) -> Iterator[str]:
    for number, nodes in enumerate((elements + 1).tolist()):
        yield f"{number + 1}," + ",".join(map(str, nodes[:12])) + ("," if len(nodes) > 12 else "")
        if len(nodes) > 12:
            yield ",".join(map(str, nodes[12:]))


def _node_set(name: str, nodes: Index) -> Iterator[str]:
    yield f"*NSET, NSET={name}"
    for start in range(0, len(nodes), 12):
        yield ",".join(map(str, nodes[start : start + 12].tolist()))


@volume_writer(".volume.bdf", "elements, sets, load and one linear step: Nastran bulk data")
def write_bdf(path: Path, volume: Volume) -> int:
    """Write a Nastran file (SOL 101); returns its bytes. Raises ExportError where it cannot be written.

    Sets are SET1 cards; their numbers stand in comments with their names.
    """
    material, sets, density = volume.material, volume.sets, _short(volume.material.density * 1e-12)
    forced = np.flatnonzero(np.abs(volume.forces).sum(axis=1) > 0.0)
    lines: Iterable[str] = chain(
        (f"$ {line}" for line in volume.about),
        ("SOL 101", "CEND", "SPC = 1", "LOAD = 1", "DISPLACEMENT = ALL", "STRESS = ALL", "BEGIN BULK"),
        chain.from_iterable(_grid(i + 1, x) for i, x in enumerate(volume.nodes.tolist())),
        chain.from_iterable(_cell(i + 1, nodes) for i, nodes in enumerate((volume.elements + 1).tolist())),
        ("PSOLID,1,1", "MAT1,1," + ",".join((_short(material.elastic_modulus), "", _short(material.poisson), density))),
        (f"SPC1,1,123,{node + 1}" for node in sets[volume.held]),
        (f"FORCE,1,{i + 1},0,1.0," + ",".join(_short(float(f)) for f in volume.forces[i]) for i in forced),
        chain.from_iterable(_set1(k + 1, *one) for k, one in enumerate(sets.items())),
        ("ENDDATA",),
    )
    return _written(path, lines)


def _grid(number: int, x: Sequence[float]) -> Iterator[str]:
    a, b, c = (f"{value:.9E}" for value in x)
    yield f"GRID*   {number:<16d}{'':<16s}{a:>16s}{b:>16s}"
    yield f"*       {c:>16s}"


def _cell(number: int, nodes: Sequence[int]) -> Iterator[str]:
    # Nastran counts a hexahedron's upright edges' nodes before those of the upper face.
    order = [*nodes[:12], *nodes[16:20], *nodes[12:16]]
    text = [f"{number:<8d}", f"{1:<8d}", *(f"{node:<8d}" for node in order)]
    lines = [text[start : start + 8] for start in range(0, len(text), 8)]
    marks = ["CHEXA   " if len(nodes) == 20 else "CTETRA  ", *(f"+{k}{number:<6x}" for k in range(1, len(lines))), ""]
    yield from (begin + "".join(line) + end for begin, line, end in zip(marks, lines, marks[1:]))


def _set1(number: int, name: str, nodes: Index) -> Iterator[str]:
    yield f"$ SET1 {number} {name}"
    every = (nodes + 1).tolist()
    for start in range(0, len(every), 6):
        yield f"SET1,{number}," + ",".join(map(str, every[start : start + 6]))


def _short(value: float) -> str:
    """A real of at most eight characters, which a field of bulk data has."""
    for digits in range(6, -1, -1):
        mantissa, exponent = f"{value:.{digits}E}".split("E")
        text = f"{mantissa if '.' in mantissa else mantissa + '.'}E{int(exponent):d}"
        if len(text) <= 8:
            return text
    raise ExportError(f"{value:g} has no room in a field of Nastran bulk data")


def _written(path: Path, lines: Iterable[str]) -> int:
    with atomic_write(path) as stream:
        for line in lines:
            stream.write(line.encode("ascii", "replace") + b"\n")
        return stream.tell()


@volume_writer(".volume.vtu", "elements with sets and nodal forces as fields, VTU; exact")
def write_vtu(path: Path, volume: Volume) -> int:
    """Write a VTU file by meshio; returns its bytes. Raises ExportError where it cannot be written."""
    return _by_meshio(path, volume, "vtu")


@volume_writer(".volume.msh", "elements with sets and nodal forces as fields, Gmsh 4.1; exact")
def write_msh(path: Path, volume: Volume) -> int:
    """Write a Gmsh file by meshio; returns its bytes. Raises ExportError where it cannot be written."""
    return _by_meshio(path, volume, "gmsh")


@volume_writer(".volume.xdmf", "elements with sets and nodal forces as fields, XDMF with its data inside; exact")
def write_xdmf(path: Path, volume: Volume) -> int:
    """Write an XDMF file; returns its bytes. Raises ExportError where it cannot be written."""
    nodes, elements = volume.nodes, volume.elements
    topology = f'<Topology TopologyType="{KINDS[volume.cell][1]}" NumberOfElements="{len(elements)}">'
    lines: Iterable[str] = chain(
        ('<?xml version="1.0"?>', '<Xdmf Version="3.0"><Domain><Grid Name="cam">', '<Geometry GeometryType="XYZ">'),
        _item(nodes, "%.17g"),
        ("</Geometry>", topology),
        _item(elements, "%d"),
        ("</Topology>",),
        chain.from_iterable(_attribute(*field) for field in _fields(volume).items()),
        ("</Grid></Domain></Xdmf>",),
    )
    return _written(path, lines)


def _attribute(name: str, values: Floats) -> Iterator[str]:
    kind = "Vector" if values.ndim == 2 else "Scalar"
    yield f'<Attribute Name="{name}" AttributeType="{kind}" Center="Node">'
    yield from _item(values, "%.17g")
    yield "</Attribute>"


def _item(values: npt.NDArray[np.generic], style: str) -> Iterator[str]:
    kind = "Int" if values.dtype.kind == "i" else "Float"
    yield f'<DataItem DataType="{kind}" Precision="8" Dimensions="{" ".join(map(str, values.shape))}" Format="XML">'
    rows = values if values.ndim == 2 else values[:, None]
    line = " ".join([style] * rows.shape[1])
    yield from (line % tuple(row) for row in rows.tolist())
    yield "</DataItem>"


def _by_meshio(path: Path, volume: Volume, file_format: str) -> int:
    try:
        import meshio
    except ImportError:
        raise ExportError(f"{path}: this format needs meshio: pip install 'camgeom[body]'") from None
    mesh = meshio.Mesh(volume.nodes.copy(), [(volume.cell, volume.elements.copy())], _fields(volume))
    with TemporaryDirectory(prefix="camgeom-") as folder:
        made = Path(folder, f"volume{path.suffix}")
        meshio.write(made, mesh, file_format=file_format)
        content = made.read_bytes()
    return write_whole(path, content)


def _fields(volume: Volume) -> dict[str, Floats]:
    """Nodal forces, N, and every set as a field that is 1 on its nodes and 0 elsewhere."""
    fields = {"force": volume.forces.copy()}
    for name, nodes in volume.sets.items():
        fields[f"set_{name}"] = np.zeros(len(volume.nodes))
        fields[f"set_{name}"][nodes] = 1.0
    return fields
