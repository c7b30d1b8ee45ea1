"""Growth of time and memory from a thousand to ten million triangles, each size in a process of its own.

The pin-insertion drum without its keyway; memory is the whole process's peak above what it had after the imports.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
from time import perf_counter

from kit import ROOT, Plot, Row, Table, run, short


def one(tolerance: float) -> Row:
    """Make the drum once in this process."""
    from camgeom.model import read
    from camgeom.solid.drum import GroovedCylinder

    model = read(str(ROOT / "profiles" / "pin_insertion.toml"))
    cam = model.cam.model_copy(update={"keyway_width": 0.0, "keyway_depth": 0.0})
    (track,) = cam.mechanism(model.setup).cutters
    part = GroovedCylinder("cam", track, cam.mechanism(model.setup).blank, cam.radius, cam.length)
    part.solid(1.0)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    began = perf_counter()
    solid = part.solid(tolerance)
    seconds = perf_counter() - began
    began = perf_counter()
    sound = solid.sound
    judged = perf_counter() - began
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    count = len(solid.mesh.faces)
    return {"tolerance_um": short(tolerance * 1e3), "triangles": count, "time_ms": short(seconds * 1e3),
            "ns_a_triangle": short(seconds * 1e9 / count, 3), "memory_mb": short(peak / 1e3, 3),
            "bytes_a_triangle": short(1024 * peak / count, 3), "sound": sound, "judging_ms": short(judged * 1e3)}


def tables(quick: bool) -> list[Table]:
    """A row a size, the best of three processes."""
    rows: list[Row] = []
    for tolerance in (0.5, 0.1, 0.01, 1e-3, 1e-4) if quick else (0.5, 0.1, 0.01, 1e-3, 1e-4, 2e-5, 1.1e-5):
        found = []
        for _ in range(1 if tolerance < 1e-4 else 3):
            done = subprocess.run([sys.executable, __file__, "--one", str(tolerance)], capture_output=True, text=True,
                                  check=True)
            found.append(json.loads(done.stdout))
        rows.append(min(found, key=lambda row: row["time_ms"]))
    for row in rows:
        row["way"] = "drum"
    plot = Plot("triangles", "time_ms", "way", "triangles", "time, ms")
    return [Table("growth", "Time and memory against the number of triangles", rows, plot=plot)]


if __name__ == "__main__":
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(one(float(sys.argv[2]))))
    else:
        run(tables, __doc__)
