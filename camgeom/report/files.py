"""Every file a model can be written to: data formats, drawings, and the stills, films and PDF of a report."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from camgeom import export
from camgeom.errors import CamgeomError, DesignError, NotConverged
from camgeom.export import Format, NamedMesh
from camgeom.maths.mesh import rowed

if TYPE_CHECKING:
    from camgeom.model import Model


def _part_sheet(path: Path, model: Model) -> int:
    from camgeom.report.part_sheet import part_sheet, write_sheet

    return write_sheet(part_sheet, model, path)


def _table_sheet(path: Path, model: Model) -> int:
    from camgeom.report.part_sheet import write_sheet
    from camgeom.report.table_sheet import table_sheet

    return write_sheet(table_sheet, model, path)


DRAWN = {
    form.extension: form
    for form in (
        Format(".sheet.svg", "model", "part drawing on A3 to A1: views, sizes, motion, parameters; SVG", _part_sheet),
        Format(".sheet.pdf", "model", "the same part drawing as PDF", _part_sheet),
        Format(".table.svg", "model", "table of the profile on A3, a row every degree of cam angle; SVG", _table_sheet),
        Format(".table.pdf", "model", "the same table as PDF", _table_sheet),
    )
}


def formats() -> dict[str, Format]:
    """Every format that one file is written in, by extension, sorted."""
    return dict(sorted((export.formats() | DRAWN).items()))


def format_of(path: Path | str) -> Format:
    """The format a file name (or a bare one, `3mf`, `sheet.pdf`) asks for. Raises ExportError as that of `export`."""
    return export.format_of(path, extra=DRAWN)


def format_rows() -> list[dict[str, str]]:
    """Name, cams and purpose of every format, for lists; pictures, films and the printed report among them."""
    rows = [
        {"format": form.extension.lstrip("."), "cams": form.cams, "about": form.about} for form in formats().values()
    ]
    rows += [{"format": name, "cams": "every cam", "about": about} for name, about in EXTRAS.items()]
    return sorted(rows, key=lambda row: row["format"])


def write(model: Model, path: Path | str, **options: Any) -> int:
    """Write a model to a file, the format by extension; returns the bytes written.

    Formats of triangles get `model.workpieces`, the others the model itself or the attribute that the format names;
    `options` go to the writer. Raises ExportError where the extension is unknown or the file cannot be written,
    DesignError or NotConverged, naming the file, where the design has no such product; an earlier file then stands.
    """
    form = format_of(path)
    try:
        if form.extension in DRAWN:
            return form.write(Path(path), model, **options)
        if form.extension == ".vtu" and model.profile.operation is not None:
            return export.write_mesh(_coloured(model), path, **options)
        return export.write(model, path, **options)
    except (DesignError, NotConverged) as error:
        raise type(error)(f"{path}: {error}") from error


def encode(model: Model, form: str, **options: Any) -> bytes:
    """A model's file of a format (`step`, `3mf`, `sheet.svg`, ...) as bytes; formats, options and errors as in `write`.

    Nothing stays on the disk: writers seek, so the file is made in a temporary folder.
    """
    extension = format_of(form).extension
    with TemporaryDirectory(prefix="camgeom-") as folder:
        path = Path(folder, f"cam{extension}")
        write(model, path, **options)
        return path.read_bytes()


def to_build123d(model: Model) -> Any:
    """The model's bodies as a build123d shape, exact: read from its STEP file.

    Raises CamgeomError where build123d is not installed, else as `write`.
    """
    try:
        from build123d import import_step
    except ImportError:
        raise CamgeomError("this needs build123d: pip install build123d") from None
    with TemporaryDirectory(prefix="camgeom-") as folder:
        path = Path(folder, "cam.step")
        path.write_bytes(encode(model, "step"))
        return import_step(path)


RESULTS = {
    "pressure": "contact_pressure_mpa",
    "pressure_angle": "pressure_angle_deg",
    "curvature": "relative_curvature_per_mm",
    "clearance": "clearance_mm",
}
"""names of result fields with their units; 0 away from the flanks"""


MOST_COLOURED = 1_500_000
"""vertices at which results are found, some 14 us each"""


def _coloured(model: Model) -> list[NamedMesh]:
    """The bodies with the results on their flanks; a planar cam's with rows where its roller's pressure changes.

    What goes with the cam, a frame, has zeros.
    """
    from camgeom.report.sections.bodies import pressed_rows
    from camgeom.report.sections.mechanism import fields

    rows = pressed_rows(model)
    meshes = [(solid.name, rowed(solid.mesh, rows, "flank")) for solid in model.body.gridded]
    if (count := sum(len(mesh.vertices) for _, mesh in meshes)) > MOST_COLOURED:
        what = f"results would be found at {count} vertices, more than {MOST_COLOURED}"
        raise NotConverged(f"{what}: ask for a coarser tolerance, or for a format without result fields")
    found = [fields(model, mesh) for _, mesh in meshes]
    named = {RESULTS[key]: key for key in found[0] if all(key in each for each in found)}
    bodies = [
        NamedMesh(name, replace(mesh, fields={label: np.nan_to_num(each[key]) for label, key in named.items()}))
        for (name, mesh), each in zip(meshes, found)
    ]
    for solid, _ in model.workpieces[len(meshes) :]:
        nothing = np.zeros(len(solid.mesh.vertices))
        bodies.append(NamedMesh(solid.name, replace(solid.mesh, fields=dict.fromkeys(named, nothing))))
    return bodies


EXTRAS = {
    "png": "stills of cam, mechanism, section and results; several files, drawn without a display",
    "gif": "the mechanism turning",
    "mp4": "the mechanism turning, needs ffmpeg",
    "webm": "the mechanism turning, needs ffmpeg",
    "pdf": "the report printed, needs Chromium or Chrome",
}
"""formats that are pictures or pages of a model and no file of its bodies"""

