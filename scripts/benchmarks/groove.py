"""Groove cam solids: time against measured error for the direct mesh, one boolean, and a union of rollers.

The cam is profiles/pin_insertion.toml without its keyway. Every error is measured by the oracle of
tests/oracle/envelope.py (distance to the nearest roller position), which shares no code with what it measures. The peer
subtracts a union of roller cylinders at equal angles; its wall error falls as the square of their number and its time
grows faster than that number. Without --quick it is run up to 360 rollers; 5 um would need 1740.
"""

from __future__ import annotations

import resource
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from kit import ROOT, Plot, Row, Table, best, milli, run, short

from camgeom.export import NamedMesh, write_mesh
from camgeom.maths.mesh import Mesh
from camgeom.model import read
from camgeom.solid.cut import CutBlank
from camgeom.solid.drum import GroovedCylinder
from camgeom.track.column import cylinder_level
from tests.oracle.envelope import roller_distance, swept_distance, triangle_points

TURN = 2.0 * np.pi
RADIUS, TIP, OUTER, START = 11.0, 54.0, 67.0, 18.0


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


def tables(quick: bool) -> list[Table]:
    """The Pareto front, the comparison at equal error, and a large mesh."""
    model = read(str(ROOT / "profiles" / "pin_insertion.toml"))
    motion = model.setup.program
    cam = model.cam.model_copy(update={"keyway_width": 0.0, "keyway_depth": 0.0})
    (track,) = cam.mechanism(model.setup).cutters
    direct = GroovedCylinder("cam", track, cam.mechanism(model.setup).blank, cam.radius, cam.length)
    cut = CutBlank("cam", (track,), cam.mechanism(model.setup).blank, cylinder_level(70.0), 70.0, 76.0, 1)
    rows = []
    for tolerance in (0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0001):
        seconds, solid = best(lambda t=tolerance: direct.solid(t), 7)
        rows.append(row("direct", tolerance, solid.mesh, seconds, wall_error(solid.mesh, motion)))
    for tolerance in (0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001):
        seconds, solid = best(lambda t=tolerance: cut.solid(t), 3)
        rows.append(row("one boolean", tolerance, solid.mesh, seconds, wall_error(solid.mesh, motion)))
    equal = []
    for count in (45, 90) if quick else (45, 90, 180, 360):
        seconds, peer = best(lambda n=count: union_of_rollers(motion, n, 360), 1)
        error = wall_error(peer, motion)
        rows.append(row("union of rollers", None, peer, seconds, error))
        tolerance = min(0.5, 1.02 * error)
        own, solid = best(lambda t=tolerance: direct.solid(t), 7)
        found = wall_error(solid.mesh, motion)
        equal.append({"rollers": count, "their_error_um": short(error * 1e3), "our_error_um": short(found * 1e3),
                      "their_time_ms": milli(seconds), "our_time_ms": milli(own), "ratio": short(seconds / own, 3)})
    plot = Plot("error_um", "time_ms", "way", "measured error, um", "time, ms")
    return [
        Table("groove", "Groove cam: time against measured error", rows, plot=plot),
        Table("groove_equal", "Groove cam: the direct mesh beside a union of rollers at equal error", equal),
        Table("groove_large", "Groove cam: a large mesh and its STL", [large(direct)],
              "raw: a plain write of as many bytes; memory: peak of the whole process."),
    ]


def row(way: str, tolerance: float | None, mesh: Mesh, seconds: float, error: float) -> Row:
    return {
        "way": way,
        "tolerance_um": "" if tolerance is None else short(tolerance * 1e3),
        "error_um": short(error * 1e3),
        "triangles": len(mesh.faces),
        "time_ms": milli(seconds),
    }


def large(direct: GroovedCylinder) -> Row:
    """Two million triangles: time, memory, and the STL of it against a raw write of as many bytes."""
    seconds, solid = best(lambda: direct.solid(5.2e-5), 3)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "cam.stl"
        stl, _ = best(lambda: write_mesh([NamedMesh("cam", replace(solid.mesh), None)], path), 3)
        data = path.read_bytes()
        raw, _ = best(lambda: (Path(folder) / "raw").write_bytes(data), 3)
    return {"triangles": len(solid.mesh.faces), "time_s": short(seconds), "peak_memory_gb": short(memory, 3),
            "stl_s": short(stl), "stl_mb": short(len(data) / 1e6), "times_raw_write": short(stl / raw, 3)}


if __name__ == "__main__":
    run(tables, __doc__)
