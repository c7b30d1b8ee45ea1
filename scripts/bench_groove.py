"""Groove cam solids: time against measured error for the direct mesh, one boolean, and a union of rollers.

    python scripts/bench_groove.py [--rollers 180] [--full] [--json FILE]

The cam is profiles/pin_insertion.toml without its keyway. Every error is measured by the oracle of tests/oracle.py
(distance to the nearest roller position), which shares no code with what it measures. The peer subtracts a union of
roller cylinders at equal angles; its wall error falls as the square of their number and its time grows faster than that
number. `--full` runs the peer with as many rollers as 5 um needs (minutes); otherwise it is run coarser, and the ratio
is given at the peer's own error.
"""

from __future__ import annotations

import argparse
import json
import resource
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from oracle import roller_distance, swept_distance, triangle_points  # noqa: E402

from camgeom.export import Body, write_mesh  # noqa: E402
from camgeom.groove import cylinder_level  # noqa: E402
from camgeom.maths.mesh import Mesh  # noqa: E402
from camgeom.model import read  # noqa: E402
from camgeom.solid import CutBlank, GroovedCylinder  # noqa: E402

TURN = 2.0 * np.pi
RADIUS, TIP, OUTER, START = 11.0, 54.0, 67.0, 18.0


def best(work, runs: int = 5):
    """Shortest time of some runs, s, and the last result."""
    times, result = [], None
    for _ in range(runs):
        began = perf_counter()
        result = work()
        times.append(perf_counter() - began)
    return min(times), result


def wall_error(mesh: Mesh, motion, most: int = 1500) -> float:
    """Largest deviation of the wall's triangles from the true wall, mm; walls are found by position, not by name."""

    def pose(phi):
        s = motion.jet(np.ravel(phi), 0)[0].reshape(np.shape(phi))
        zero = np.zeros_like(s)
        return np.stack([zero, zero, START + s], -1), np.stack([np.cos(phi), -np.sin(phi), zero], -1)

    def distance(x, a, u):
        return roller_distance(x, a, u, RADIUS, TIP)

    centre = mesh.vertices[mesh.faces].mean(axis=1)
    radial = np.hypot(centre[:, 0], centre[:, 1])
    normal = np.cross(*(mesh.vertices[mesh.faces[:, k]] - mesh.vertices[mesh.faces[:, 0]] for k in (1, 2)))
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    outward = np.abs((normal[:, :2] * centre[:, :2]).sum(axis=1)) / radial
    wall = (radial > TIP + 1.5) & (radial < OUTER - 0.5) & (outward < 0.9)
    wall &= (centre[:, 2] > 0.5) & (centre[:, 2] < 109.5)
    faces = mesh.faces[wall]
    if not len(faces):
        return float("nan")
    faces = faces[np.random.default_rng(0).choice(len(faces), min(most, len(faces)), replace=False)]
    return float(np.abs(swept_distance(triangle_points(mesh.vertices, faces, 6), pose, distance, 0, TURN)).max())


def union_of_rollers(motion, rollers: int, facets: int) -> Mesh:
    """The peer: the drum minus a union of roller cylinders at equal angles, by manifold3d in double precision."""
    import manifold3d

    def cylinder(low, high, radius, sides):
        return manifold3d.Manifold.cylinder(high - low, radius, radius, sides).translate([0.0, 0.0, low])

    tool = cylinder(TIP, OUTER + 3.0, RADIUS, facets).rotate([0.0, 90.0, 0.0])
    angles = np.linspace(0.0, 360.0, rollers, endpoint=False)
    lifts = motion.jet(np.radians(angles), 0)[0]
    placed = [tool.translate([0.0, 0.0, START + s]).rotate([0.0, 0.0, -a]) for a, s in zip(angles, lifts)]
    drum = cylinder(0.0, 110.0, OUTER, 720) - cylinder(-1.0, 111.0, 20.0, 240)
    cut = drum - manifold3d.Manifold.batch_boolean(placed, manifold3d.OpType.Add)
    if cut.status().name != "NoError":
        raise SystemExit(f"the peer failed: {cut.status().name}")
    raw = cut.to_mesh64()
    return Mesh(np.ascontiguousarray(raw.vert_properties[:, :3]), raw.tri_verts.astype(np.int32))


def table(rows: list[dict], columns: list[str]) -> None:
    """Print rows as aligned text."""
    widths = [max(len(c), *(len(str(r.get(c, ""))) for r in rows)) for c in columns]
    print("  ".join(c.ljust(w) for c, w in zip(columns, widths)))
    for row in rows:
        print("  ".join(str(row.get(c, "")).ljust(w) for c, w in zip(columns, widths)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--rollers", type=int, default=180, help="rollers of the peer")
    parser.add_argument("--full", action="store_true", help="run the peer at 5 um: 1740 rollers, minutes")
    parser.add_argument("--json", type=Path, help="also write the rows here")
    options = parser.parse_args()
    model = read(str(ROOT / "profiles" / "pin_insertion.toml"))
    motion = model.setup.program
    cam = model.cam.model_copy(update={"keyway_width": 0.0, "keyway_depth": 0.0})
    (track,) = cam.cutters(model.setup)
    direct = GroovedCylinder("cam", track, cam.blank(model.setup), cam.radius, cam.length)
    cut = CutBlank("cam", (track,), cam.blank(model.setup), cylinder_level(70.0), 70.0, 76.0, 1)
    rows = []
    for tolerance in (0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0001):
        for way, part, runs in (("direct", direct, 7), ("boolean", cut, 3)):
            if way == "boolean" and tolerance < 0.001:
                continue
            seconds, solid = best(lambda part=part, t=tolerance: part.solid(t), runs)
            rows.append(row(way, tolerance, solid.mesh, seconds, wall_error(solid.mesh, motion)))
    count = 1740 if options.full else options.rollers
    seconds, peer = best(lambda: union_of_rollers(motion, count, 360), 1)
    peer_error = wall_error(peer, motion)
    rows.append(row(f"union of {count} rollers", None, peer, seconds, peer_error))
    tolerance = min(0.5, 1.02 * peer_error)
    equal_seconds, equal = best(lambda: direct.solid(tolerance), 7)
    equal_error = wall_error(equal.mesh, motion)
    rows.append(row("direct at the peer's error", tolerance, equal.mesh, equal_seconds, equal_error))
    table(rows, ["way", "tolerance_um", "error_um", "triangles", "time_ms"])
    print(f"\nat the peer's error the direct mesh is {seconds / equal_seconds:.0f} times faster "
          f"({equal_error * 1e3:.3g} um against {peer_error * 1e3:.3g} um)")
    rows.append(large(direct))
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1))


def row(way: str, tolerance: float | None, mesh: Mesh, seconds: float, error: float) -> dict:
    return {
        "way": way,
        "tolerance_um": "" if tolerance is None else round(tolerance * 1e3, 4),
        "error_um": float(f"{error * 1e3:.4g}"),
        "triangles": len(mesh.faces),
        "time_ms": float(f"{seconds * 1e3:.4g}"),
    }


def large(direct: GroovedCylinder) -> dict:
    """Two million triangles: time, memory, and the STL of it against a raw write of as many bytes."""
    tolerance = 5.2e-5
    seconds, solid = best(lambda: direct.solid(tolerance), 3)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "cam.stl"
        stl, _ = best(lambda: write_mesh([Body("cam", replace(solid.mesh), None)], path), 3)
        data = path.read_bytes()
        raw, _ = best(lambda: (Path(folder) / "raw").write_bytes(data), 3)
    print(f"{len(solid.mesh.faces)} triangles in {seconds:.3f} s, peak memory of this process {memory:.2f} GB; "
          f"STL in {stl:.3f} s ({stl / raw:.1f} times a raw write of {len(data) / 1e6:.0f} MB)")
    return {"way": "large", "triangles": len(solid.mesh.faces), "time_ms": seconds * 1e3, "memory_gb": memory,
            "stl_ms": stl * 1e3, "raw_ms": raw * 1e3}


if __name__ == "__main__":
    main()
