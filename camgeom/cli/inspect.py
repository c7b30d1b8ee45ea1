"""`camgeom inspect`: measured points against the exact flanks of a profile's cam."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from camgeom.cli import Console, UsageError, aligned, number_in
from camgeom.cli.model import refuse_nameless, refuse_unwritable, write_set

if TYPE_CHECKING:
    from camgeom.inspection import Inspection

COLUMNS = (
    "flank", "cam_angle_deg", "station_mm", "x_mm", "y_mm", "z_mm", "nominal_x_mm", "nominal_y_mm", "nominal_z_mm",
    "normal_x", "normal_y", "normal_z", "deviation_mm", "on_flank",
)  # fmt: skip
LARGEST = 1e4


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Fit the points, print the deviations, write them where a folder is named; returns the exit status."""
    from camgeom.inspection import Fit, inspect
    from camgeom.inspection.points import read_points
    from camgeom.model import read

    fits = get_args(Fit)
    if arguments.fit is not None and arguments.fit not in fits:
        raise UsageError(f"--fit: unknown fit {arguments.fit[:40]!r}; allowed: {', '.join(fits)}")
    radius = number_in(arguments.probe_radius, "--probe-radius", "mm", 0.0, LARGEST)
    limit = number_in(arguments.limit, "--limit", "mm", 0.0, LARGEST)
    refuse_nameless(arguments.out)
    folder = None if arguments.out is None else Path(arguments.out)
    if folder is not None:
        refuse_unwritable(folder)
    model = read(arguments.profile)
    points = read_points(arguments.points)
    found = inspect(model, points, radius or 0.0, arguments.fit)
    worst = abs(found.of().worst)
    passed = limit is None or worst <= limit
    data: dict[str, Any] = {"name": model.profile.name, "kind": model.profile.kind, "points_file": arguments.points}
    data |= {"probe_radius_mm": radius or 0.0, "limit_mm": limit, "passed": passed, **found.as_dict()}
    files = [] if folder is None else _written(folder, data, found, console)
    if arguments.json:
        console.out(json.dumps(data, indent=2, allow_nan=False))
        return 0 if passed else 1
    for line in _lines(data, found):
        console.out(line)
    for file in files:
        console.out(f"  wrote {file}")
    return 0 if passed else 1


def _lines(data: dict[str, Any], found: Inspection) -> list[str]:
    """The verdict, the fit, and a line a flank."""
    verdict = "deviations" if data["limit_mm"] is None else f"{'PASS' if data['passed'] else 'FAIL'}, deviations"
    whole = found.of()
    lines = [f"{data['name']} ({data['kind']}): {verdict} of {whole.points} points"]
    place = f"angle {data['angle_deg']:.6f} deg, axial {data['axial_mm']:.6f} mm"
    x, y, z = data["translation_mm"]
    if data["kind"] == "linear":
        across = f"across {y:.6f} mm, " if data["fit"] == "rigid" else ""
        turned = f", angle {data['angle_deg']:.6f} deg" if data["fit"] == "rigid" else ""
        place = f"travel {x:.6f} mm, {across}height {z:.6f} mm{turned}"
    elif data["fit"] == "rigid":
        place += f", x {x:.6f} mm, y {y:.6f} mm"
    if found.undetermined:
        place += f" (the points say nothing about: {', '.join(found.undetermined)})"
    lines.append(f"  best fit: {found.fit}; {place}")
    if data["beyond_the_flanks"]:
        lines.append(f"  {data['beyond_the_flanks']} points lie beyond the flanks' edges and do not count")
    rows: list[tuple[str, ...]] = [("flank", "points", "max mm", "min mm", "rms mm", "worst mm", "at cam angle deg")]
    rows += [
        (one.name, str(one.points), *(_mm(v) for v in (one.largest, one.smallest, one.rms, one.worst)),
         f"{np.degrees(one.cam_angle) % 360.0:.3f}")
        for one in (*found.flanks, whole)
    ]  # fmt: skip
    return lines + [f"  {line}" for line in aligned(rows, right=range(1, 7))]


def _mm(value: float) -> str:
    return f"{round(value, 6) + 0.0:.6f}"


def _written(folder: Path, data: dict[str, Any], found: Inspection, console: Console) -> list[Path]:
    """inspection.json and inspection.csv; they appear together."""
    from camgeom.export.folder import INSPECTION

    feet = found.feet
    table = np.column_stack(
        [np.degrees(found.angles), found.stations, found.points.T, feet.x.T, feet.n.T, found.deviation, found.kept]
    )
    lines = [",".join(COLUMNS)]
    for number, row in zip(feet.surface.tolist(), (table + 0.0).tolist()):
        lines.append(f"{found.names[number]}," + ",".join(map(repr, row[:-1])) + f",{int(row[-1])}")
    contents = {
        "inspection.json": json.dumps(data, indent=2, allow_nan=False) + "\n",
        "inspection.csv": "\n".join(lines) + "\n",
    }
    return write_set(folder, INSPECTION, data["name"], "inspect", contents, console)
