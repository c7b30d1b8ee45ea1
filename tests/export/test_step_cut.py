"""Cut bodies as faces: sound, of the mesh's topology and volume, and flanks that touch the roller."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import pytest

from camgeom.errors import DesignError, NotConverged
from camgeom.export import write
from camgeom.export.step.brep import Brep
from camgeom.export.step.check import check_solid
from camgeom.export.step.cut import cut_solid
from camgeom.export.step.geometry import WORLD, Circle, Cone, Frame, Plane, SplineCurve, SplineSurface
from camgeom.export.step.meeting import SurfaceCrossing, corner
from camgeom.export.step.tagged import Tagged, TaggedMesh, subtract_tagged
from camgeom.model import Model, read
from camgeom.profile import parse
from camgeom.solid.cut import IndexingCut
from tests.oracle.envelope import roller_distance, swept_distance
from tests.oracle.refined_volume import limit_volume
from tests.places import PROFILES
from tests.reference.indexing_machines import barrel, dwell_half_angle, indexer, meridian_of, turret_pose


def flank_points(solid: Brep, count: int = 6) -> np.ndarray:
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
    (part,) = cam.mechanism(setup).parts
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
        low, high = cam.mechanism(setup).cutters[start].span

        def distance(x: np.ndarray, a: np.ndarray, u: np.ndarray) -> np.ndarray:
            deep = cam.mechanism(setup).tip + 12.0
            return roller_distance(x, a, u, radius, deep, tip_high=True, shape=meridian_of(setup, shape))

        pose = turret_pose(setup, cam.center_distance, shift, hand, 1.0)
        coarse = int(120 * (high - low) / (2.0 * pi))
        np.minimum(best, swept_distance(points, pose, distance, low, high, coarse, 3, 40), out=best)
    assert np.abs(best).max() < 1e-4


def test_barrel_whose_grooves_cross() -> None:
    cam, setup = barrel(4, "rib", "right", 2, "cylinder", bore=20.0)
    (part,) = cam.mechanism(setup).parts
    verdict = check_solid(cut_solid(part), 1e-5)
    assert verdict.problems == ()
    assert verdict.volume == pytest.approx(limit_volume(part, 4), rel=3e-7)


def test_hubs_and_keyway() -> None:
    keys = {"bore": 24.0, "keyway_width": 8.0, "keyway_depth": 3.3, "hub_diameter": 60.0, "hub_length": 12.0}
    cam, setup = indexer(8, **keys)
    solid = cut_solid(cam.mechanism(setup).parts[0])
    assert check_solid(solid, 1e-5, nodes=2).problems == ()
    assert {face.name for face in solid.faces} == {"flank", "floor", "land", "end", "hub", "bore", "keyway"}


def test_groove_that_runs_out_of_its_drum() -> None:
    (part,) = read(str(PROFILES / "feeder_runout.toml")).parts
    solid = cut_solid(part)
    verdict = check_solid(solid, 1e-5)
    assert verdict.problems == ()
    assert verdict.genus == 1
    assert verdict.volume == pytest.approx(limit_volume(part, 4), rel=1e-7)
    assert {face.name for face in solid.faces} == {"flank", "edge", "floor", "land", "end", "bore"}


def test_a_body_that_does_not_close_goes_out_as_triangles(tmp_path: Path) -> None:
    model = read(str(PROFILES / "feeder_runout.toml"))
    (part,) = model.parts
    with pytest.raises(DesignError, match="reaches into the blank"):
        cut_solid(replace(part, ridge=part.guess - 6.0))
    model.body.__dict__["parts"] = (replace(part, ridge=part.guess - 6.0),)
    model.body.__dict__["solids"] = (part.solid(0.1),)
    write(model, tmp_path / "cam.step")
    (note,) = model.ledger.notes["step"][0]["bodies"]
    assert note["faces"] == "triangles"
    assert "reaches into the blank" in note["reason"]
    assert note["deviation_mm"] <= 0.1
    assert "TRIANGULATED_FACE" in (tmp_path / "cam.step").read_text()


BARREL, FLAT = Cone(WORLD, 10.0), Plane(Frame.about((0.0, 0.0, 3.0), (0.0, 0.0, 1.0)))


def near(surface: Cone | Plane, point: tuple[float, float, float]) -> np.ndarray:
    """Parameters (2,) of a point near a surface."""
    return np.concatenate(surface.locate(np.array([point])))


TWINS = """
[cam]
kind = "globoidal"
form = "rib"
hand = "left"
width = 42.679
center_distance = 71.23
globoid_radius = 33.41
direction = "cw"
bore = 16.9
[follower]
kind = "turret"
stops = 2
pitch_radius = 34.2
rollers = 12
[roller]
diameter = 14.252
length = 10.6
[output]
tolerance = 0.05
[[motion]]
until = 80.0
[[motion]]
until = 240.0
to = 180.0
law = "scca"
[[motion]]
until = 360.0
"""


def test_a_body_whose_corners_fall_together_goes_out_as_triangles_too(tmp_path: Path) -> None:
    """The edge without length between them ended as a bug: a matrix without an inverse."""
    made = Model(parse(TWINS))
    write(made, tmp_path / "cam.step")
    (note,) = made.ledger.notes["step"][0]["bodies"]
    assert (note["faces"], note["deviation_mm"] <= 0.05) == ("triangles", True)
    assert "two corners of the body fall together at [-28.2" in note["reason"]


def test_corner_of_three_surfaces() -> None:
    side = Plane(Frame.about((6.0, 0.0, 0.0), (1.0, 0.0, 0.0)))
    guesses = np.array([near(surface, (6.1, 8.1, 3.2)) for surface in (BARREL, FLAT, side)])
    point, at = corner([BARREL, FLAT, side], guesses, [{}, {}, {}])
    assert point == pytest.approx([6.0, 8.0, 3.0], abs=1e-12)
    assert at[0] == pytest.approx([np.arctan2(8.0, 6.0), 3.0])
    far = Plane(Frame.about((11.0, 0.0, 0.0), (1.0, 0.0, 0.0)))
    with pytest.raises(NotConverged, match="do not meet"):
        corner([BARREL, FLAT, far], guesses, [{}, {}, {}])


def crossing(one: Cone | Plane, other: Cone | Plane, points: np.ndarray) -> SurfaceCrossing:
    """The crossing of two surfaces from rough points (n, 3) between exact ends."""
    return SurfaceCrossing((one, other), points, *(np.stack(s.locate(points), axis=1) for s in (one, other)))


def test_crossings_are_recognised_or_fitted() -> None:
    angle = np.linspace(0.3, 2.0, 9)
    rough = np.stack([10.05 * np.cos(angle), 9.96 * np.sin(angle), 3.0 + 0.02 * np.sin(40.0 * angle)], axis=1)
    rough[[0, -1]] = [[10.0 * np.cos(a), 10.0 * np.sin(a), 3.0] for a in angle[[0, -1]]]
    curve, error = crossing(BARREL, FLAT, rough).fit(1e-7)
    assert isinstance(curve, Circle)
    assert curve.radius == pytest.approx(10.0, abs=1e-9)
    assert error <= 1e-7
    # A drum of radius 4 across one of radius 10: x² = 100 - 16 sin² there.
    across = Cone(Frame.about((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)), 4.0)
    y, z = 4.0 * np.cos(angle), 4.0 * np.sin(angle)
    rough = np.stack([np.sqrt(100.0 - y * y) + 0.01 * np.sin(9.0 * angle), y, z], axis=1)
    rough[[0, -1], 0] = np.sqrt(100.0 - y[[0, -1]] ** 2)
    curve, _ = crossing(BARREL, across, rough).fit(1e-7)
    assert isinstance(curve, SplineCurve)
    x = curve.at(np.linspace(0.0, 1.0, 101))
    assert np.hypot(x[:, 0], x[:, 1]) == pytest.approx(10.0, abs=2e-7)
    assert np.hypot(x[:, 1], x[:, 2]) == pytest.approx(4.0, abs=2e-7)


def test_surfaces_that_do_not_cross() -> None:
    touching = Plane(Frame.about((10.5, 0.0, 0.0), (1.0, 0.0, 0.0)))
    rough = np.stack([np.full(5, 10.2), np.linspace(-1.0, 1.0, 5), np.linspace(0.0, 5.0, 5)], axis=1)
    with pytest.raises(NotConverged, match="cross"):
        crossing(BARREL, touching, rough).fit(1e-7)


LARGE_DRUM = """name = "ten metres"
[cam]
kind = "cylindrical-index"
form = "rib"
hand = "right"
width = 5216.69
center_distance = 9153.3
diameter = 9879.888
bore = 2443.47
[follower]
kind = "turret"
stops = 8
pitch_radius = 9171.92
[roller]
shape = "cylinder"
diameter = 3453.016
length = 1964.39
[[motion]]
until = 30.0
[[motion]]
until = 250.0
to = 45.0
law = "cycloidal"
[[motion]]
until = 360.0
"""


def test_a_drum_of_ten_metres_takes_no_finer_mesh_than_one_of_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its topology was settled on a mesh of 30 and of 8 µm: 4 million triangles and 1.5 GB."""
    sizes: list[int] = []

    def counted(blank: Tagged, tools: list[Tagged]) -> TaggedMesh:
        sizes.append(len(blank.faces) + sum(len(tool.faces) for tool in tools))
        return subtract_tagged(blank, tools)

    monkeypatch.setattr("camgeom.export.step.cut.subtract_tagged", counted)
    (part,) = Model(parse(LARGE_DRUM)).parts
    assert isinstance(part, IndexingCut)
    verdict = check_solid(cut_solid(part), 1e-5)
    assert verdict.problems == ()
    assert verdict.deviation <= 1e-5
    assert max(sizes) < 300_000
