"""What a tool leaves on the flanks, as a map: CSV, and VTU with the field `rest_mm`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from camgeom.errors import ExportError
from camgeom.export import Body, write_mesh, writer
from camgeom.export.files import atomic_write
from camgeom.maths.mesh import Mesh

if TYPE_CHECKING:
    from camgeom.machining.outcome import Outcome
    from camgeom.machining.rest import RestField

ROUND = "drums and globoids"
"""cams whose flanks run round a body: what a tool leaves there changes from place to place"""
COLUMNS = ("track", "side", "cam_angle_deg", "roller_mm", "x_mm", "y_mm", "z_mm", "rest_mm")


@writer(".rest.csv", "stock that the tool leaves on flanks (gouges negative), CSV", "machined", ROUND)
def write_rest_csv(path: Path, outcome: Outcome) -> int:
    """Write the stock at points of every flank, mm, one a line; returns the bytes written.

    Raises ExportError for a planar cam, whose contour leaves the same stock everywhere, or where the file cannot be
    written.
    """
    fields = _fields(path, outcome)
    with atomic_write(path) as stream:
        stream.write((",".join(COLUMNS) + "\n").encode())
        for one in fields:
            shape = one.rest.shape
            columns = [
                np.broadcast_to(np.degrees(one.phi)[:, None], shape),
                np.broadcast_to(one.delta, shape),
                *one.flank.x,
                one.rest,
            ]
            table = np.stack([column[one.valid] for column in columns], axis=1)
            lines = (f"{one.track.name},{one.side:+.0f}," + ",".join(map(repr, row)) for row in table.tolist())
            stream.write(("\n".join(lines) + "\n").encode())
        return stream.tell()


@writer(".rest.vtu", "flanks with the stock that the tool leaves as a field, VTU; exact", "machined", ROUND)
def write_rest_vtu(path: Path, outcome: Outcome) -> int:
    """Write every flank as a surface with `rest_mm` on its points; returns the bytes written. Errors as for the CSV."""
    bodies = []
    for one in _fields(path, outcome):
        mesh = _surface(one)
        if len(mesh.faces):
            bodies.append(Body(f"{one.track.name} {one.side:+.0f}", mesh))
    return write_mesh(bodies, path)


def _fields(path: Path, outcome: Outcome) -> tuple[RestField, ...]:
    if not outcome.fields:
        raise ExportError(f"{path}: the contour of a planar cam leaves the same stock everywhere")
    return outcome.fields


def _surface(one: RestField) -> Mesh:
    """The flank's grid as triangles; cells with a corner off the blank are left out."""
    n, m = one.rest.shape
    index = np.arange(n * m).reshape(n, m)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    whole = one.valid[:-1, :-1] & one.valid[1:, :-1] & one.valid[1:, 1:] & one.valid[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], -1)[whole], np.stack([a, c, d], -1)[whole]]).astype(np.int32)
    points = np.moveaxis(one.flank.x, 0, -1).reshape(-1, 3)
    return Mesh(np.ascontiguousarray(points), faces, ("flank",), None, {"rest_mm": one.rest.ravel().copy()})
