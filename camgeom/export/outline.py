"""Profile curves of planar cams as data: points, normals and curvature over the cam angle, CSV."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from camgeom.errors import ExportError
from camgeom.export import writer
from camgeom.export.files import atomic_write
from camgeom.maths.extremum import piece_grid

if TYPE_CHECKING:
    from camgeom.model import Model

PER_TURN = 3600
COLUMNS = ("curve", "cam_angle_deg", "x_mm", "y_mm", "normal_x", "normal_y", "curvature_per_mm")


@writer(
    ".outline.csv", "profile and pitch curves, normals, curvature, CSV; exact", takes="model", cams="planar cams"
)
def write_outline_csv(path: Path, model: Model) -> int:
    """Write every outline of a planar cam, a tenth of a degree apart and one-sided at knots; returns the bytes written.

    Points lie on the exact curve, numbers read back to the last bit; normals point outwards, curvature is positive
    where the curve is convex. Raises ExportError for a cam that is not planar, or where the file cannot be written.
    """
    if model.planar is None:
        raise ExportError(f"{path}: only planar cams have outlines")
    with atomic_write(path) as stream:
        stream.write((",".join(COLUMNS) + "\n").encode())
        for name, outline in model.planar.outlines.items():
            phi, _ = piece_grid(outline.knots(), PER_TURN)
            curve = outline.curve(phi)
            table = np.stack([np.degrees(phi), *curve.points, *curve.normals, curve.curvature], axis=1)
            lines = (f"{name}," + ",".join(map(repr, row)) for row in table.tolist())
            stream.write(("\n".join(lines) + "\n").encode())
        return stream.tell()
