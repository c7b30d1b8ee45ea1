"""Clouds of flank points with normals and curvatures, for measuring machines and for comparison: PLY, CSV, NPZ."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from camgeom.errors import ExportError
from camgeom.export import writer
from camgeom.export.files import atomic_write
from camgeom.maths import Floats

if TYPE_CHECKING:
    from camgeom.model import Model

Cloud = Mapping[str, Floats]
"""Arrays by name: `points` (n, 3) mm, `normals` (n, 3) unit, and scalars (n,) whose names carry the unit."""

_CHUNK = 8192


def flank_points(model: Model) -> dict[str, Floats]:
    """Points of every flank of a model in the cam frame, mm, exact, with what is known there.

    points, normals              (n, 3): the normal points out of the cam's material
    cam_angle_deg, roller_mm     when and where along the roller (from its reference plane) the point is touched
    pressure_angle_deg           between the normal and the velocity of the contact point
    curvature_1_per_mm, _2_      principal curvatures of the cam, the larger first; positive where it is convex
    relative_curvature_per_mm    of cam against roller across the contact line
    track, side                  number of the roller track; +1 or -1 for its flanks

    Raises ExportError for a cam whose follower has no roller.
    """
    parts: dict[str, list[Floats]] = {}
    for number, survey in enumerate(model.flanks):
        for side in survey.track.sides:
            flank = survey.flank(side)
            shape = flank.x.shape[1:]
            first, second = flank.forms.principal()
            columns = {
                "points": flank.points.reshape(-1, 3),
                "normals": 0.0 - flank.normals.reshape(-1, 3),
                "cam_angle_deg": np.degrees(np.broadcast_to(flank.phi[:, None], shape)),
                "roller_mm": np.broadcast_to(survey.track.meridian.jet(survey.stations)[0], shape),
                "pressure_angle_deg": np.degrees(flank.pressure_angle()),
                "curvature_1_per_mm": np.maximum(first, second),
                "curvature_2_per_mm": np.minimum(first, second),
                "relative_curvature_per_mm": flank.k_rel,
                "track": np.full(shape, float(number)),
                "side": np.full(shape, float(side)),
            }
            for name, values in columns.items():
                parts.setdefault(name, []).append(values if values.ndim == 2 and name[-1] == "s" else values.ravel())
    if not parts:
        raise ExportError("no flank points: the follower has no roller")
    return {name: np.concatenate(values) for name, values in parts.items()}


def _cloud(path: Path, model: Model) -> Cloud:
    try:
        return flank_points(model)
    except ExportError as error:
        raise ExportError(f"{path}: {error}") from error


@writer(".points.ply", "flank points with normals and curvatures, binary PLY; exact", "model", "cams with rollers")
def _points_ply(path: Path, model: Model) -> int:
    return write_cloud_ply(path, _cloud(path, model))


@writer(".points.csv", "flank points with normals and curvatures, CSV; exact", "model", "cams with rollers")
def _points_csv(path: Path, model: Model) -> int:
    return write_cloud_csv(path, _cloud(path, model))


@writer(".points.npz", "flank points with normals and curvatures, numpy archive; exact", "model", "cams with rollers")
def _points_npz(path: Path, model: Model) -> int:
    return write_cloud_npz(path, _cloud(path, model))


def write_cloud_ply(path: Path, cloud: Cloud) -> int:
    """Write a cloud to a little-endian PLY file of doubles (x y z nx ny nz and the scalars); returns the bytes written.

    Raises ExportError where the arrays do not fit together, a number is not finite, or the file cannot be written.
    """
    names, table = _table(path, cloud)
    lines = ["ply", "format binary_little_endian 1.0", "comment camgeom, lengths in mm"]
    lines += [f"element vertex {len(table)}", *(f"property double {name}" for name in names), "end_header"]
    with atomic_write(path) as stream:
        stream.write(("\n".join(lines) + "\n").encode("ascii", "backslashreplace"))
        stream.write(table.data)
        return stream.tell()


def write_cloud_csv(path: Path, cloud: Cloud) -> int:
    """Write a cloud to a CSV file with one heading line; every number reads back to the last bit; returns the bytes.

    Raises ExportError as `write_cloud_ply` does.
    """
    names, table = _table(path, cloud)
    with atomic_write(path) as stream:
        stream.write((",".join(names) + "\n").encode())
        for start in range(0, len(table), _CHUNK):
            lines = (",".join(map(repr, row)) for row in table[start : start + _CHUNK].tolist())
            stream.write(("\n".join(lines) + "\n").encode("ascii"))
        return stream.tell()


def write_cloud_npz(path: Path, cloud: Cloud) -> int:
    """Write a cloud to a numpy archive, the arrays under their names; returns the bytes written.

    Raises ExportError as `write_cloud_ply` does.
    """
    _table(path, cloud)
    with atomic_write(path) as stream:
        np.savez(stream, allow_pickle=False, **{name: np.asarray(values) for name, values in cloud.items()})
        return stream.seek(0, 2)


def _table(path: Path, cloud: Cloud) -> tuple[list[str], Floats]:
    """Column names and the (n, k) table of a cloud."""
    points = np.asarray(cloud.get("points"))
    if points.ndim != 2 or points.shape[1] != 3 or len(points) == 0:
        raise ExportError(f"{path}: a cloud has points (n, 3), n > 0")
    names, columns = [], []
    for name, values in cloud.items():
        three = {"points": ["x", "y", "z"], "normals": ["nx", "ny", "nz"]}.get(name)
        if np.shape(values) != ((len(points), 3) if three else (len(points),)):
            raise ExportError(f"{path}: {name} has shape {np.shape(values)} beside {len(points)} points")
        if not np.all(np.isfinite(values)):
            raise ExportError(f"{path}: {name} has a value that is not finite")
        names += three or ["_".join(name.replace(",", " ").split())]
        columns.append(np.reshape(values, (len(points), -1)))
    return names, np.ascontiguousarray(np.hstack(columns), dtype="<f8")
