"""Cutter location data in APT (ISO 4343 words): ends and axes of the tool in the cam frame."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from camgeom.export import writer
from camgeom.export.files import atomic_write
from camgeom.maths import Floats

if TYPE_CHECKING:
    from camgeom.machining.plan import Machining, Pass


SAME_FEED = 0.01
"""share by which the feed of the tool's end may change before it is said anew"""
_GOTO = "GOTO/{:.6f},{:.6f},{:.6f},{:.8f},{:.8f},{:.8f}\n"
_CHUNK = 8192


@writer(".apt", "cutter location data in APT: GOTO/x,y,z,i,j,k of the tool's end and axis", takes="machining")
def write_apt(path: Path, machining: Machining) -> int:
    """Write the passes as APT: mm, cam frame, positions to 1e-6 mm, axes to 1e-8; returns the bytes written.

    GOTO is the end of the tool on its axis (the lowest point of a ball, the middle of a wheel's end) and the unit
    vector from there to the spindle. FEDRAT, mm/min of the tool's end, follows the surface speed at the contact to one
    per cent. Raises ExportError where the file cannot be written.
    """
    spec, tool = machining.spec, machining.tool
    height = spec.length or max(one.height for one in machining.paths)
    cutter = ",".join(f"{value:.6f}" for value in tool.apt(height))
    head = [
        f"PARTNO/{_plain(machining.title)[:64]}",
        "PPRINT/CAMGEOM, LENGTHS MM, CAM FRAME: ORIGIN AND Z ON THE CAM AXIS",
        f"PPRINT/TOOL {_plain(tool.about)}",
        f"PPRINT/CHORD ERROR AT MOST {spec.tolerance:.6g} MM, STOCK LEFT {spec.allowance:.6g} MM",
        f"PPRINT/FEDRAT KEEPS {spec.feed:.6g} MMPM AT THE CONTACT",
        "UNITS/MM",
        "MULTAX/ON",
        f"CUTTER/{cutter}",
        f"LOADTL/{spec.tool_number},LENGTH,{height:.6f}",
        f"SPINDL/{spec.spindle:.6g},RPM,CLW",
        "COOLNT/ON",
    ]
    with atomic_write(path) as stream:
        stream.write(("\n".join(head) + "\n").encode("ascii"))
        for made in machining.passes("cam"):
            stream.write(f"PPRINT/PASS {_plain(made.name)}\n".encode("ascii"))
            for text in _moves(machining, made):
                stream.write(text.encode("ascii"))
        stream.write(b"COOLNT/OFF\nSPINDL/OFF\nFINI\n")
        return stream.tell()


def _moves(machining: Machining, made: Pass) -> Iterator[str]:
    """The lines of one pass, some at a time."""
    from camgeom.machining.plan import seconds

    last: Floats | None = None
    said = 0.0
    for move, times in zip(made.moves, seconds(made.moves, machining.spec)):
        at = move.positions
        way = np.concatenate([at.tip[:, :1] if last is None else last, at.tip], axis=1)
        length = np.sqrt((np.diff(way, axis=1) ** 2).sum(axis=0))
        feeds = 60.0 * length / np.where(times > 0.0, times, np.inf)
        last = at.tip[:, -1:]
        table = np.concatenate([at.tip, at.axis]).T
        for start in range(0, len(table), _CHUNK):
            lines = []
            for row, feed in zip(table[start : start + _CHUNK].tolist(), feeds[start : start + _CHUNK].tolist()):
                if move.kind == "rapid":
                    lines.append("RAPID\n")
                    said = 0.0
                elif feed > 0.0 and abs(feed - said) > SAME_FEED * feed:
                    lines.append(f"FEDRAT/{feed:.3f},MMPM\n")
                    said = feed
                lines.append(_GOTO.format(*row))
            yield "".join(lines)


def _plain(text: str) -> str:
    """Text in the letters of APT."""
    shown = "".join(c if c.isascii() and c.isprintable() and c not in "$/" else " " for c in text)
    return " ".join(shown.upper().split())
