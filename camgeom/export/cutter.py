"""Cutter positions as a table: ends and axes of the tool, contact, time and machine axes, CSV."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from camgeom.export import writer
from camgeom.export.files import atomic_write

if TYPE_CHECKING:
    from camgeom.machining.plan import Machining

COLUMNS = (
    "pass", "move", "cam_angle_deg", "x_mm", "y_mm", "z_mm", "i", "j", "k", "contact_x_mm", "contact_y_mm",
    "contact_z_mm", "normal_x", "normal_y", "normal_z", "time_s",
)  # fmt: skip
_CHUNK = 8192


@writer(".cutter.csv", "cutter positions: end, axis, contact, normal, time, CSV; exact", takes="machining")
def write_cutter_csv(path: Path, machining: Machining) -> int:
    """Write every block of every pass, one a line, in the cam frame; returns the bytes written.

    Numbers read back to the last bit. `pass` counts from 1; `move` is rapid, feed (in and out) or cut; contact and
    normal (into the cam) are those of the flank that the block belongs to, of the first of two; `time_s` is the time
    the block takes (0 for rapid ones). Raises ExportError where the file cannot be written.
    """
    from camgeom.machining.plan import seconds

    with atomic_write(path) as stream:
        stream.write((",".join(COLUMNS) + "\n").encode())
        for number, made in enumerate(machining.passes("cam"), 1):
            for move, times in zip(made.moves, seconds(made.moves, machining.spec)):
                at = move.positions
                rows = [np.degrees(at.phi)[None], at.tip, at.axis, at.contacts[0], at.normals[0], times[None]]
                table = np.concatenate(rows).T
                for start in range(0, len(table), _CHUNK):
                    block = table[start : start + _CHUNK].tolist()
                    lines = (f"{number},{move.kind}," + ",".join(map(repr, row)) for row in block)
                    stream.write(("\n".join(lines) + "\n").encode("ascii"))
        return stream.tell()
