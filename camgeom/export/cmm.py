"""Inspection tables for coordinate measuring machines: nominal points of every flank with normals, CSV."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from camgeom.errors import CamgeomError, ExportError
from camgeom.export import writer
from camgeom.export.files import atomic_write
from camgeom.maths import Floats
from camgeom.model.surfaces import FlankSurface, flank_surfaces, within

if TYPE_CHECKING:
    from camgeom.model import Model


STEP = 1.0
"""deg of cam angle between points"""
ACROSS = 3
"""points along the roller"""
INSET = 0.1
"""share of the touched stretch that is left free at its ends"""
COLUMNS = (
    "flank", "cam_angle_deg", "station_mm", "x_mm", "y_mm", "z_mm", "normal_x", "normal_y", "normal_z",
    "polar_angle_deg", "polar_radius_mm", "pitch_x_mm", "pitch_y_mm", "pitch_z_mm", "pitch_angle_deg",
    "pitch_radius_mm",
)  # fmt: skip


@writer(".cmm.csv", "inspection points of every flank: Cartesian, polar, normals, roller centres, CSV", takes="model")
def write_cmm_csv(path: Path, model: Model, step: float = STEP, across: int = ACROSS) -> int:
    """Write nominal points of every flank in the cam frame; returns the bytes written.

    step    deg of cam angle; across: points along the roller (or over the height of a disc)
    Points lie on the exact flank and within the blank; normals point out of the material; the polar angle is counted
    from +X towards +Y. Roller-centre columns stay empty where the follower has no roller. `camgeom inspect` reads
    the same columns with measured coordinates. Raises ExportError where the cam has no flank or the file cannot be
    written.
    """
    try:
        surfaces, inside = flank_surfaces(model), within(model)
        rows = [(surface.name, _rows(surface, step, across)) for surface in surfaces]
    except CamgeomError as error:
        raise ExportError(f"{path}: {error}") from error
    with atomic_write(path) as stream:
        stream.write((",".join(COLUMNS) + "\n").encode())
        for name, table in rows:
            kept = table[inside(table[:, 2:5].T)]
            for row in kept.tolist():
                cells = ("" if value != value else repr(value) for value in row)
                stream.write((f"{name}," + ",".join(cells) + "\n").encode())
        return stream.tell()


def _rows(surface: FlankSurface, step: float, across: int) -> Floats:
    """Numbers (k, 15) of one flank; NaN where there is no roller."""
    low, high = surface.span
    count = max(3, round(np.degrees(high - low) / step))
    angles = np.linspace(low, high, count, endpoint=False) if surface.closed else np.linspace(low, high, count + 1)
    bottom, top = surface.touched
    share = np.linspace(INSET, 1.0 - INSET, across) if across > 1 else np.array([0.5])
    phi, t = (grid.ravel() for grid in np.meshgrid(angles, bottom + share * (top - bottom), indexing="ij"))
    patch = surface.at(phi, t)
    pitch = surface.pitch(phi, t)
    pitch = np.full((3, len(phi)), np.nan) if pitch is None else pitch
    columns = [np.degrees(phi), surface.station(t), *patch.x, *patch.n, *_polar(patch.x), *pitch, *_polar(pitch)]
    return np.column_stack(columns) + 0.0  # no negative zeros


def _polar(x: Floats) -> tuple[Floats, Floats]:
    """Angle (deg, 0 to 360) and radius (mm) of points (3, n) about the cam axis."""
    return np.degrees(np.arctan2(x[1], x[0])) % 360.0, np.hypot(x[0], x[1])
