"""Globoidal cam solids: time and measured error, against a union of rollers at equal error; maps of a flank.

    python scripts/bench_globoidal.py [--rollers 240 480] [--json FILE]

The cam is a rib cam with eight stops, C = 180. Every error is measured by the oracle of tests/oracle.py (distance to
the nearest roller position), which shares no code with what it measures. The peer subtracts a union of roller
cylinders at equal angles; its wall error falls as the square of their number and its time grows faster than that.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from time import perf_counter

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from oracle import roller_distance, swept_distance, triangle_points  # noqa: E402

from camgeom.cams.globoidal import STARTER  # noqa: E402
from camgeom.flank import Flank  # noqa: E402
from camgeom.maths.mesh import Mesh  # noqa: E402
from camgeom.model import Model  # noqa: E402
from camgeom.profile import parse  # noqa: E402

CENTRE, RADIUS, HALF = 180.0, 15.0, np.pi / 8.0


def best(work, runs: int):
    """Shortest time of some runs, s, and the last result."""
    times, result = [], None
    for _ in range(runs):
        began = perf_counter()
        result = work()
        times.append(perf_counter() - began)
    return min(times), result


def pose_of(motion):
    """Roller axes in the cam frame, from the machine's description."""

    def pose(phi):
        tau = motion.jet(np.ravel(phi), 0)[0].reshape(np.shape(phi)) + HALF
        c, s = np.cos(phi), np.sin(phi)
        a = np.stack([CENTRE * c, -CENTRE * s, np.zeros_like(c)], -1)
        return a, np.stack([-np.cos(tau) * c, np.cos(tau) * s, np.sin(tau)], -1)

    return pose


def wall_error(mesh: Mesh, track, most: int = 600) -> float:
    """Largest deviation of walls from the nearest roller, mm, at triangles a roller's side has cut."""
    rng = np.random.default_rng(0)
    centre = mesh.vertices[mesh.faces].mean(axis=1)
    depth = np.hypot(np.hypot(centre[:, 0], centre[:, 1]) - CENTRE, centre[:, 2])
    faces = mesh.faces[(depth > 82.0) & (depth < 98.0) & (np.abs(centre[:, 2]) < 41.0)]
    faces = faces[rng.choice(len(faces), min(most, len(faces)), replace=False)]

    def distance(x, a, u):
        return roller_distance(x, a, u, RADIUS, 110.0, tip_high=True)

    low, high = track.span
    coarse = int(360 * (high - low) / (2.0 * np.pi))
    points = triangle_points(mesh.vertices, faces, 6)
    found = swept_distance(points, pose_of(track.program), distance, low, high, coarse)
    return float(np.abs(found).max())


def union_of_rollers(model: Model, rollers: int, facets: int) -> Mesh:
    """The peer: the blank minus a union of roller cylinders at equal angles, by manifold3d in double precision."""
    import manifold3d

    (part,) = model.cam.parts(model.setup)
    (track,) = model.cutters
    blank = part.blank.mesh(0.01)
    body = manifold3d.Manifold(manifold3d.Mesh64(blank.vertices, blank.faces.astype(np.uint64)))
    tool = manifold3d.Manifold.cylinder(40.0, RADIUS, RADIUS, facets).translate([0.0, 0.0, track.tip - 40.0])
    phi = np.linspace(*track.span, rollers)
    pose = track.pose(phi, 0)
    placed = []
    for k in range(rollers):
        u, a = pose.u[0][:, k], pose.a[0][:, k]
        first = np.cross(u, [0.0, 0.0, 1.0])
        first /= np.linalg.norm(first)
        placed.append(tool.transform(np.column_stack([first, np.cross(u, first), u, a])))
    cut = body - manifold3d.Manifold.batch_boolean(placed, manifold3d.OpType.Add)
    if cut.status().name != "NoError":
        raise SystemExit(f"the peer failed: {cut.status().name}")
    raw = cut.to_mesh64()
    return Mesh(np.ascontiguousarray(raw.vert_properties[:, :3]), raw.tri_verts.astype(np.int32))


def matched(part, track, error: float) -> tuple[float, float, Mesh]:
    """Time, measured error and mesh of our own body whose measured error is just below another's, mm."""
    tolerance = error
    for _ in range(4):
        mesh = part.solid(tolerance).mesh
        found = wall_error(mesh, track)
        if 0.85 * error <= found <= error:
            break
        tolerance *= 0.95 * error / found
    seconds, solid = best(lambda: part.solid(tolerance), 5)
    return seconds, wall_error(solid.mesh, track), solid.mesh


def maps(track) -> dict:
    """Time of curvature and pressure-angle maps on 1000 x 20 points, ms."""
    phi, t = np.linspace(*track.span, 1000), np.linspace(80.0, 102.0, 20)

    def both():
        flank = Flank(track, phi, t, 1.0)
        return flank.k_rel, flank.pressure_angle()

    seconds, _ = best(both, 20)
    return {"way": "maps of 1000 x 20 points", "time_ms": float(f"{1e3 * seconds:.4g}")}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--rollers", type=int, nargs="+", default=[240, 480], help="rollers of the peer")
    parser.add_argument("--json", type=Path, help="also write the rows here")
    options = parser.parse_args()
    model = Model(parse(STARTER))
    (part,) = model.cam.parts(model.setup)
    (track,) = model.cutters
    rows = []

    def row(way: str, mesh: Mesh, seconds: float) -> float:
        error = wall_error(mesh, track)
        rows.append({"way": way, "error_um": float(f"{1e3 * error:.4g}"), "triangles": len(mesh.faces),
                     "time_ms": float(f"{1e3 * seconds:.4g}")})
        print(rows[-1])
        return error

    for tolerance in (0.05, 0.02, 0.005, 0.001):
        for way, make in (("direct", part.direct), ("boolean", part.cut)):
            seconds, solid = best(lambda t=tolerance, m=make: m(t), 9 if way == "direct" else 3)
            row(f"{way}, {1e3 * tolerance:g} um", solid.mesh, seconds)
    for rollers in options.rollers:
        # As many facets as leave a tenth of what the distance of the rollers does.
        facets = max(24, rollers // 4)
        peer_seconds, peer = best(lambda n=rollers, m=facets: union_of_rollers(model, n, m), 1)
        error = row(f"union of {rollers} rollers of {facets} facets", peer, peer_seconds)
        seconds, found, own = matched(part, track, error)
        row("direct at that error", own, seconds)
        print(f"at {1e3 * found:.3g} um against {1e3 * error:.3g} um the direct mesh is "
              f"{peer_seconds / seconds:.0f} times faster")
    rows.append(maps(track))
    print(rows[-1])
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
