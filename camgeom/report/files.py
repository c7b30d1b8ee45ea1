"""Every file a model can be written to: data formats, drawings, and the stills, films and PDF of a report."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from camgeom import export
from camgeom.errors import DesignError, NotConverged
from camgeom.export import Format

if TYPE_CHECKING:
    from camgeom.model import Model


def _part_sheet(path: Path, model: Model) -> int:
    from camgeom.report.part_sheet import write_part_sheet

    return write_part_sheet(model, path)


DRAWN = {
    form.extension: form
    for form in (
        Format(".sheet.svg", "model", "part drawing on A3: sections, dimensions, motion, parameters; SVG", _part_sheet),
        Format(".sheet.pdf", "model", "the same part drawing as PDF", _part_sheet),
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

    Formats of triangles get `model.solids`, the others the model itself or the attribute that the format names;
    `options` go to the writer. Raises ExportError where the extension is unknown or the file cannot be written,
    DesignError or NotConverged, naming the file, where the design has no such product; an earlier file then stands.
    """
    form = format_of(path)
    try:
        if form.extension in DRAWN:
            return form.write(Path(path), model, **options)
        return export.write(model, path, **options)
    except (DesignError, NotConverged) as error:
        raise type(error)(f"{path}: {error}") from error


EXTRAS = {
    "png": "stills of cam, mechanism, section and results; several files, drawn without a display",
    "gif": "the mechanism turning",
    "mp4": "the mechanism turning, needs ffmpeg",
    "webm": "the mechanism turning, needs ffmpeg",
    "pdf": "the report printed, needs Chromium or Chrome",
}
"""formats that are pictures or pages of a model and no file of its bodies"""

