"""G-code (RS-274) for a mill whose rotary axis turns the cam."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from camgeom.errors import ExportError
from camgeom.export import writer
from camgeom.export.files import atomic_write
from camgeom.maths import Floats

if TYPE_CHECKING:
    from camgeom.machining.plan import Machining, Pass


LINEAR = "%.4f"
ROTARY = "%.5f"
"""decimals of mm and degrees: 0.05 µm and, at 100 mm from the axis, 0.01 µm"""
FASTEST = 1e6
"""1/min or mm/min; a faster block would only be a rounding of its own length"""
_CHUNK = 8192


@writer(".gcode", "G-code for a rotary-table mill, feed by surface speed (G93, or G94)", takes="machining")
def write_gcode(path: Path, machining: Machining) -> int:
    """Write the passes as G-code in mm and degrees, absolute; returns the bytes written.

    Blocks are straight in the machine's coordinates, and their chord error on the part keeps spec.tolerance. In G93
    every cutting block has its own F, 1/min, so that the contact moves at spec.feed; in G94 F is mm/min of the linear
    axes, or degrees/min where only the rotary ones move. Raises DesignError where the machine's axes cannot hold the
    tool, ExportError where the file cannot be written.
    """
    spec, machine = machining.spec, machining.machine
    inverse = spec.feed_mode == "inverse-time"
    where = "TOOL END" if machine.pivot == 0.0 else "SWING AXIS"
    notes = [
        f"CAMGEOM: {machining.title}",
        f"TOOL T{spec.tool_number}: {machining.tool.about}; COORDINATES OF THE {where}",
        *machine.about,
        f"CHORD ERROR AT MOST {spec.tolerance:.6g} MM; STOCK LEFT {spec.allowance:.6g} MM",
        f"{'G93: F IS 1/MIN' if inverse else 'G94'}; SURFACE SPEED {spec.feed:.6g} MM/MIN AT THE CONTACT",
    ]
    head = ["%", *(f"({_plain(note)})" for note in notes), "G21 G90 G17 G40 G49 G80 G94"]
    head += [f"T{spec.tool_number} M6", f"S{spec.spindle:.0f} M3", "M8"]
    with atomic_write(path) as stream:
        stream.write(("\n".join(head) + "\n").encode("ascii"))
        for made in machining.passes("machine"):
            stream.write(f"({_plain('PASS ' + made.name)})\n".encode("ascii"))
            for text in _moves(path, machining, made, inverse):
                stream.write(text.encode("ascii"))
        stream.write(b"G94\nM9\nM5\nM30\n%\n")
        return stream.tell()


def _moves(path: Path, machining: Machining, made: Pass, inverse: bool) -> Iterator[str]:
    """The blocks of one pass, some at a time."""
    from camgeom.machining.machine import in_degrees
    from camgeom.machining.plan import seconds

    machine = machining.machine
    letters = machine.letters
    block = "".join(f" {letter}{LINEAR if i < 3 else ROTARY}" for i, letter in enumerate(letters))
    last: Floats | None = None
    mode = ""
    for move, times in zip(made.moves, seconds(made.moves, machining.spec)):
        table = in_degrees(machine, machine.solve(move.positions))
        if last is not None and move.kind != "rapid":
            # Every move counts its turns from nought; a tool in the cut must not go round once more.
            table[3:] += 360.0 * np.round((last[3:] - table[3:, :1]) / 360.0)
        table[:3], table[3:] = np.round(table[:3], 4) + 0.0, np.round(table[3:], 5) + 0.0
        if not np.all(np.isfinite(table)):
            raise ExportError(f"{path}: a coordinate of pass {made.name!r} is not finite")
        if move.kind == "rapid":
            yield "G94\n" if inverse and mode != "G94" else ""
            mode = "G94"
            yield "".join("G0" + block % tuple(row) + "\n" for row in table.T.tolist())
        else:
            before = table[:, :1] if last is None else last
            feeds = _feeds(np.concatenate([before, table], axis=1), times, inverse)
            rows = np.concatenate([table, feeds[None]]).T
            yield "G93\n" if inverse and mode != "G93" else ""
            mode = "G93"
            for start in range(0, len(rows), _CHUNK):
                part = rows[start : start + _CHUNK].tolist()
                yield "".join(f"G1{block % tuple(row[:-1])} F{_feed(row[-1])}\n" for row in part)
        last = table[:, -1:]


def _feeds(table: Floats, times: Floats, inverse: bool) -> Floats:
    """F of every block between the columns of a table (mm, degrees)."""
    minutes = np.maximum(times, 1e-9) / 60.0
    if inverse:
        return np.asarray(np.minimum(1.0 / minutes, FASTEST))
    step = np.diff(table, axis=1)
    linear = np.sqrt((step[:3] ** 2).sum(axis=0))
    turning = np.sqrt((step[3:] ** 2).sum(axis=0))
    return np.asarray(np.clip(np.where(linear > 0.5e-4, linear, turning) / minutes, 1e-3, FASTEST))


def _feed(value: float) -> str:
    """F with seven digits, always with a point: some controls take a number without one for thousandths."""
    return f"{value:.{max(1, 6 - len(str(int(value))))}f}"


def _plain(text: str) -> str:
    """Text that may stand in a comment."""
    shown = "".join(c if c.isascii() and c.isprintable() and c not in "()%;" else " " for c in text)
    return " ".join(shown.upper().split())
