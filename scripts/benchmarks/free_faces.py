"""Triangles of every profile with output.free_tolerance, as coarse as the tolerance and 10 times coarser.

The error of flanks and of all other faces is that of tests/oracle on points of facets drawn at random, over the
tolerance of the faces they are on, as in `fewest`.
"""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path
from time import process_time
from typing import Any

from kit import ROOT, Row, Table, run, short

sys.path.append(str(ROOT / "scripts" / "stability"))

from judging import frozen, judge

from camgeom.errors import ProfileError
from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.solid import TOUCHED

TIMES = 10.0
TURNS = 4
"""times that a body is made, of which the quickest counts"""


def figures(data: dict[str, Any]) -> dict[str, Any]:
    """Triangles, processor time, s, and errors stated, mm, and measured, over the tolerance, of the bodies."""
    times = []
    for _ in range(TURNS):
        model = Model(from_data(frozen(data), ""))
        parts = [*model.parts]
        began = process_time()
        solids = model.solids
        times.append(process_time() - began)
    assert len(parts) == len(solids)
    touched = sum(int(solid.mesh.group_faces(TOUCHED).sum()) for solid in solids)
    return {
        "triangles": sum(len(solid.mesh.faces) for solid in solids), "touched": touched, "seconds": min(times),
        "stated": max(solid.chord_error for solid in solids),
        "free": max((solid.free_error or 0.0) for solid in solids), "measured": judge(data).get("error", float("nan")),
    }  # fmt: skip


def row(path: Path) -> Row | None:
    """The row of a profile; None where the key is refused."""
    data = tomllib.loads(path.read_text())
    output = data.get("output", {}) | {"fewest_triangles": False}
    tolerance = output.get("tolerance", 0.005)
    try:
        after = figures(data | {"output": output | {"free_tolerance": TIMES * tolerance}})
    except ProfileError:
        return None
    before = figures(data | {"output": output})
    found: Row = {"profile": path.stem, "tolerance_um": short(tolerance * 1e3)}
    for label, one in (("_before", before), ("", after)):
        found[f"triangles{label}"] = one["triangles"]
        found[f"flank_triangles{label}"] = one["touched"]
        found[f"time_ms{label}"] = short(one["seconds"] * 1e3, 3)
        found[f"stl_mb{label}"] = short((84 + 50 * one["triangles"]) * 1e-6, 3)
        found[f"stated_um{label}"] = short(one["stated"] * 1e3, 3)
        found[f"measured_of_tolerance{label}"] = short(one["measured"], 3)
    return found | {"stated_free_um": short(after["free"] * 1e3, 3)}


def tables(quick: bool) -> list[Table]:
    """A row a profile that takes the key."""
    rows = [found for path in sorted((ROOT / "profiles").glob("*.toml")) if (found := row(path)) is not None]
    return [Table("free_faces", f"Faces that nothing touches {TIMES:g} times coarser", rows, "Flanks: as without.")]


if __name__ == "__main__":
    run(tables, __doc__)
