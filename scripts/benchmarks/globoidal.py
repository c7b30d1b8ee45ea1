"""Globoidal cams: solids against measured error, beside one boolean and a union of rollers; maps of a flank.

The cam is a rib cam with eight stops, C = 180. Every error is measured by the oracle of tests/oracle/envelope.py
(distance to the nearest roller position), which shares no code with what it measures. The peer subtracts a union of
roller cylinders at equal angles; its wall error falls as the square of their number and its time grows faster than
that.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from kit import Plot, Row, Table, best, milli, run, short

from camgeom.cams import starter
from camgeom.maths.mesh import Mesh
from camgeom.model import Model
from camgeom.profile import parse
from camgeom.solid.cut import IndexingCut
from camgeom.track import Track
from camgeom.track.flank import Flank
from tests.oracle.envelope import roller_distance, swept_distance, triangle_points

STARTER = starter("globoidal")

CENTRE, RADIUS, HALF = 180.0, 15.0, np.pi / 8.0


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

    (part,) = model.mechanism.parts
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


def matched(part: IndexingCut, track: Track, error: float) -> tuple[float, float, Mesh]:
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


def maps(track: Track) -> Row:
    """Time of curvature and pressure-angle maps on 1000 x 20 points, ms."""
    phi, t = np.linspace(*track.span, 1000), np.linspace(80.0, 102.0, 20)

    def both() -> Any:
        flank = Flank(track, phi, t, 1.0)
        return flank.k_rel, flank.pressure_angle()

    seconds, _ = best(both, 20)
    return {"points": "1000 x 20", "time_ms": milli(seconds)}


def tables(quick: bool) -> list[Table]:
    """Solids over the tolerance both ways, the comparison at equal error, and maps."""
    model = Model(parse(STARTER))
    (part,) = model.mechanism.parts
    (track,) = model.cutters
    rows: list[Row] = []
    for tolerance in (0.05, 0.02, 0.005) if quick else (0.05, 0.02, 0.01, 0.005, 0.002, 0.001):
        for way, make, runs in (("direct", part.direct, 9), ("one boolean", part.cut, 3)):
            seconds, solid = best(lambda t=tolerance, m=make: m(t), runs)
            rows.append({"way": way, "tolerance_um": short(tolerance * 1e3), "triangles": len(solid.mesh.faces),
                         "error_um": short(wall_error(solid.mesh, track) * 1e3), "time_ms": milli(seconds)})
    equal: list[Row] = []
    for rollers in (120,) if quick else (120, 240, 480):
        # As many facets as leave a tenth of what the distance of the rollers does.
        facets = max(24, rollers // 4)
        theirs, peer = best(lambda n=rollers, m=facets: union_of_rollers(model, n, m), 1)
        error = wall_error(peer, track)
        own, found, _ = matched(part, track, error)
        equal.append({"rollers": rollers, "facets": facets, "their_error_um": short(error * 1e3),
                      "our_error_um": short(found * 1e3), "their_time_ms": milli(theirs), "our_time_ms": milli(own),
                      "ratio": short(theirs / own, 3)})
    plot = Plot("error_um", "time_ms", "way", "measured error, um", "time, ms")
    return [
        Table("globoidal", "Globoidal rib cam, 8 stops: time against measured error", rows, plot=plot),
        Table("globoidal_equal", "Globoidal rib cam beside a union of rollers at equal error", equal),
        Table("globoidal_maps", "Curvature and pressure angle of a flank", [maps(track)]),
    ]


if __name__ == "__main__":
    run(tables, __doc__)
