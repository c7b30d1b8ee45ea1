"""Every globoidal cam of a grid against the oracle: stops, forms, hands, starts and roller shapes, as a table.

    python scripts/oracle_globoidal.py [--tolerance 0.05] [--samples 40] [--json FILE] [--dwell 1e-4]

Each body is meshed, asked for its topology, and sampled on random triangles of flanks, floor and outside. The oracle of
tests/oracle/envelope.py (distance to the nearest roller position, no envelope in it) says how far walls are from the
rollers and how deep any point stands inside one. The exit status is 0 when every body is closed, of one piece and
within its chord error.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import replace
from itertools import product
from math import pi
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from camgeom.errors import CamgeomError  # noqa: E402
from camgeom.motion import Program, Segment  # noqa: E402
from tests.oracle.globoid import dwell_section, solid_of, wall_error  # noqa: E402
from tests.reference.indexing_machines import SHAPES, indexer  # noqa: E402

STOPS = (3, 4, 6, 8, 12, 16, 24)


def measured(case, tolerance: float, samples: int) -> dict:
    """One body: its topology, its stated error, and what the oracle finds, mm."""
    stops, form, hand, starts, shape = case
    motion = 200.0 if stops <= 4 and starts > 1 else 120.0
    cam, setup = indexer(stops, form, hand, starts, shape, motion, bore=20.0)
    row = dict(zip(("stops", "form", "hand", "starts", "shape"), case))
    refused = cam.problems(setup)
    if refused:
        return row | {"sound": False, "refused": "; ".join(map(str, refused))}
    try:
        solid = solid_of(cam, setup, tolerance)
    except CamgeomError as error:
        return row | {"sound": False, "refused": str(error)}
    wall, depth, _ = wall_error(cam, setup, shape, solid, samples=samples)
    within = max(wall, -depth) <= 1.0001 * solid.chord_error <= 1.0001 * tolerance
    return row | {
        "sound": bool(solid.sound),
        "pieces": int(solid.mesh.components),
        "genus": int(solid.mesh.genus),
        "triangles": len(solid.mesh.faces),
        "chord_error_um": round(1e3 * solid.chord_error, 3),
        "wall_um": round(1e3 * wall, 3),
        "inside_um": round(1e3 * max(0.0, -depth), 3),
        "within": bool(within),
    }


def dwell(tolerance: float) -> float:
    """Relative error of the volume of a cam that dwells all round, against its surface of revolution."""
    cam, setup = indexer(8)
    still = Program.from_segments([Segment(2.0 * pi)], closed=True, angular=True)
    solid = solid_of(cam, replace(setup, program=still), tolerance)
    return solid.mesh.volume / (2.0 * pi * dwell_section(cam, setup)) - 1.0


def table(rows: list[dict]) -> str:
    """A line for each stops, form, hand and starts: the worst of the four roller shapes."""
    lines = ["stops  form    hand   starts  shapes  closed  stated um  wall um  inside um  triangles"]
    for stops, form, hand, starts in product(STOPS, ("rib", "groove"), ("right", "left"), (1, 2)):
        key = {"stops": stops, "form": form, "hand": hand, "starts": starts}
        own = [row for row in rows if key.items() <= row.items() and "within" in row]
        if own:
            names = ("chord_error_um", "wall_um", "inside_um", "triangles")
            stated, wall, inside, triangles = (max(row[name] for row in own) for name in names)
            good = sum(row["sound"] and row["within"] for row in own)
            lines.append(
                f"{stops:5d}  {form:6s}  {hand:5s}  {starts:6d}  {len(own):6d}  {good:6d}  {stated:9.2f}  {wall:7.2f}"
                f"  {inside:9.2f}  {triangles:9d}"
            )
    return "\n".join(lines)


def main() -> int:
    """Measure the grid, print the table, say how many bodies hold."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--tolerance", type=float, default=0.05, help="mm, of the meshes")
    parser.add_argument("--samples", type=int, default=40, help="triangles a face group")
    parser.add_argument("--json", type=Path, help="also write every row here")
    parser.add_argument("--dwell", type=float, metavar="MM", help="only the dwell's volume, at this tolerance")
    options = parser.parse_args()
    if options.dwell:
        error = dwell(options.dwell)
        print(f"volume of a whole turn of dwell at {options.dwell:g} mm: {error:.3e} of the surface of revolution's")
        return int(abs(error) > 1e-2 * options.dwell)
    rows = []
    for case in product(STOPS, ("rib", "groove"), ("right", "left"), (1, 2), SHAPES):
        rows.append(measured(case, options.tolerance, options.samples))
        row = rows[-1]
        if not (row["sound"] and row.get("within")):
            print("FAIL", row, flush=True)
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1))
    print(table(rows))
    good = sum(bool(row["sound"] and row.get("within")) for row in rows)
    print(f"{good} of {len(rows)} bodies closed, of one piece, and within their stated error")
    return int(good < len(rows))


if __name__ == "__main__":
    sys.exit(main())
