"""A model's files without a file, and its bodies in the shapes of other libraries."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from camgeom.errors import CamgeomError

if TYPE_CHECKING:
    from camgeom.model import Model


def encode(model: Model, form: str, **options: Any) -> bytes:
    """A model's file of a format (`step`, `3mf`, `sheet.svg`, ...) as bytes; formats, options and errors as in `write`.

    Nothing stays on the disk: writers seek, so the file is made in a temporary folder.
    """
    from camgeom.report.files import format_of, write

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
