"""Cut bodies as faces: sound, of the mesh's topology and volume, and flanks that touch the roller."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from indexing_machines import dwell_half_angle, indexer, meridian_of, turret_pose
from oracle import roller_distance, swept_distance

from camgeom.export.step.brep import Solid
from camgeom.export.step.check import check_solid
from camgeom.export.step.cut import cut_solid
from camgeom.export.step.geometry import Cone, Plane, SplineSurface


def flank_points(solid: Solid, count: int = 6) -> np.ndarray:
    """Points on the edges of the spline flanks, and of the surfaces between them where an edge crosses the patch."""
    found = []
    for face in solid.faces:
        if face.name == "flank" and isinstance(face.surface, SplineSurface):
            edges = np.concatenate([use.edge.points(count) for loop in face.loops for use in loop])
            u, v = face.surface.locate(edges)
            middle = face.surface.jet(0.5 * (u + np.roll(u, count // 2)), 0.5 * (v + np.roll(v, count // 2)))[0]
            found += [edges, middle]
    return np.concatenate(found)


CASES = [
    (8, "rib", "right", 1, "cylinder"),
    (12, "groove", "left", 1, "cylinder"),
    (6, "rib", "left", 1, "cone"),
    (4, "rib", "right", 2, "cylinder"),
]


@pytest.mark.parametrize(("stops", "form", "hand", "starts", "shape"), CASES)
def test_globoidal_cam(stops: int, form: str, hand: str, starts: int, shape: str) -> None:
    cam, setup = indexer(stops, form, hand, starts, shape, bore=20.0)
    (part,) = cam.parts(setup)
    solid = cut_solid(part)
    verdict = check_solid(solid, 1e-5)
    assert verdict.problems == ()
    assert verdict.deviation <= 1e-5
    assert solid.deviation <= 1e-5
    assert verdict.genus == 1
    assert {face.name for face in solid.faces} == {"flank", "floor", "land", "end", "bore"}
    assert {type(face.surface) for face in solid.faces if face.name == "bore"} == {Cone}
    assert {type(face.surface) for face in solid.faces if face.name == "end"} == {Plane}
    points = flank_points(solid)
    best = np.full(len(points), np.inf)
    radius = 0.5 * setup.roller.diameter + cam.running_clearance
    for start in range(starts):
        shift = dwell_half_angle(setup, form) + start * 2.0 * pi / setup.follower.count
        low, high = cam.cutters(setup)[start].span

        def distance(x: np.ndarray, a: np.ndarray, u: np.ndarray) -> np.ndarray:
            deep = cam.tip(setup) + 12.0
            return roller_distance(x, a, u, radius, deep, tip_high=True, shape=meridian_of(setup, shape))

        pose = turret_pose(setup, cam.center_distance, shift, hand, 1.0)
        coarse = int(120 * (high - low) / (2.0 * pi))
        np.minimum(best, swept_distance(points, pose, distance, low, high, coarse, 3, 40), out=best)
    assert np.abs(best).max() < 1e-4
