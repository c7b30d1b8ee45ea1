"""Walls of plates and indexers: the check against meshes and dense samples, and both sides of its limit."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from camgeom.cams import starter
from camgeom.checks import judge
from camgeom.maths import Floats
from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.profile.text import load
from tests.places import PROFILES

FINE = 2e-5
"""mm, chord error of the meshes that walls are measured on"""
PLATES = {
    "disc_offset_roller": ("cam from face to face", "profile to bore"),
    "disc_flat_face": ("cam from face to face", "profile to bore"),
    "disc_face_groove": ("inner flank to bore", "outer flank to rim", "under the groove floor"),
    "constant_width_press": ("cam from face to face", "profile to bore"),
    "conjugate_rocker": (
        "main disc from face to face", "return disc from face to face",
        "main to bore", "main to phase mark", "main phase mark to bore",
        "return to bore", "return to phase mark", "return phase mark to bore",
    ),
}  # fmt: skip


def profile(name: str, **changed: dict[str, float]) -> Model:
    """A shipped profile with keys of its sections changed."""
    data = load((PROFILES / f"{name}.toml").read_text(), name)[0]
    for section, keys in changed.items():
        data[section] = {**data.get(section, {}), **keys}
    return Model(from_data(data, name))


def rings(model: Model, body: int, *groups: str) -> Floats:
    """Plane points (n, 2) of the vertices of some face groups of a body."""
    mesh = model.parts[body].solid(FINE).mesh
    numbers = [mesh.groups.index(name) for name in groups if name in mesh.groups]
    return mesh.vertices[np.unique(mesh.faces[np.isin(mesh.group, numbers)])][:, :2]


def apart(one: Floats, other: Floats) -> float:
    """Least distance of two closed polygons (n, 2), sampled: vertices of one against the other's."""
    return float(cKDTree(one).query(other)[0].min())


def measured(model: Model, wall: str) -> float:
    """A wall as the mesh has it, mm."""
    if wall == "under the groove floor":
        mesh = model.parts[0].solid(FINE).mesh
        floor = mesh.vertices[mesh.faces[mesh.group == mesh.groups.index("floor")]][..., 2]
        return float(floor.min() - mesh.vertices[:, 2].min())
    body = 1 if wall.startswith("return") else 0
    if wall.endswith("from face to face"):
        return float(np.ptp(model.parts[body].solid(FINE).mesh.vertices[:, 2]))
    flank, bore = rings(model, body, "flank"), dense(rings(model, body, "bore", "keyway"))
    if wall == "outer flank to rim":
        return apart(rings(model, 0, "rim"), flank)
    if wall == "inner flank to bore":
        return apart(bore, flank[np.hypot(*flank.T) < np.hypot(*flank.T).mean()])
    if wall.endswith("to phase mark"):
        return apart(rings(model, body, "mark"), flank)
    return apart(bore, rings(model, body, "mark") if "mark" in wall else flank)


def dense(points: Floats) -> Floats:
    """The polygon round the axis with points between its corners: a keyway's flanks have none."""
    points = points[np.argsort(np.arctan2(points[:, 1], points[:, 0]))]
    share = np.linspace(0.0, 1.0, 50, endpoint=False)[:, None, None]
    return (points + share * (np.roll(points, -1, axis=0) - points)).reshape(-1, 2)


@pytest.mark.parametrize(("name", "wall"), [(name, wall) for name, walls in PLATES.items() for wall in walls])
def test_walls_of_plates_are_those_of_the_mesh_and_judged_on_both_sides(name: str, wall: str) -> None:
    model = profile(name)
    assert sorted(place.name for place in model.walls if "frame" not in place.name) == sorted(PLATES[name])
    place = next(place for place in model.walls if place.name == wall)
    thickness = measured(model, wall)
    assert place.thickness == pytest.approx(thickness, rel=2e-4)
    for limit, level in ((thickness / 0.999, "fail"), (thickness / 1.002, "pass")):
        verdict = judge(profile(name, limits={"min_wall_mm": limit}), ["wall"])
        finding = next(one for one in verdict.findings if one.where == wall)
        assert (finding.check, finding.level) == ("wall", level)


@pytest.mark.parametrize(
    ("cam", "thickness"),
    [
        ({"bore": 59.98, "keyway_width": 0, "keyway_depth": 0}, 0.01),
        ({"bore": 50, "keyway_width": 14, "keyway_depth": 3.3}, None),
    ],
)
def test_a_bore_or_keyway_close_under_the_base_circle_fails(cam: dict[str, float], thickness: float | None) -> None:
    data = {"base_radius": 30, **cam}
    model = profile("disc_offset_roller", cam=data)
    finding = next(one for one in judge(model, ["wall"]).findings if one.where == "profile to bore")
    assert finding.level == "fail"
    assert finding.value == pytest.approx(thickness or measured(model, "profile to bore"), rel=2e-3)


@pytest.mark.parametrize(("width", "level"), [(0.02, "fail"), (0.999, "fail"), (1.002, "pass")])
@pytest.mark.parametrize("name", ["disc", "conjugate", "parallel-index"])
def test_a_disc_or_plate_as_thin_as_foil_fails(name: str, width: float, level: str) -> None:
    data = load(starter(name), name)[0]
    data["cam"] = {**data["cam"], "width": width, "bore": 0.0, "keyway_width": 0.0, "keyway_depth": 0.0}
    found = {f.where: f.level for f in judge(Model(from_data(data, name)), ["wall"]).findings}
    faces = [where for where in found if where.endswith("from face to face")]
    assert len(faces) == (1 if name == "disc" else 2)
    assert {found[where] for where in faces} == {level}


@pytest.mark.parametrize("name", ["tool_changer", "conical_indexer", "fine_indexer", "barrel_indexer"])
def test_indexers_floors_stand_off_their_bores(name: str) -> None:
    """The floor's facets are sampled: a straight floor comes nearest the axis between its edges."""
    whole = {"keyway_width": 0, "keyway_depth": 0}
    model = profile(name, cam=whole)
    mesh = model.solid.mesh
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces[mesh.group == mesh.groups.index("floor")]], 1, 0)
    share = [(i / 40.0, j / 40.0) for i in range(41) for j in range(41 - i)]
    nearest = min(float(np.hypot(*(a + i * (b - a) + j * (c - a)).T[:2]).min()) for i, j in share)
    thickness = nearest - 0.5 * model.mechanism.bore.diameter
    place = next(place for place in model.walls if place.name == "floor to bore")
    # A barrel cam's is what a groove along the drum would leave: its own run obliquely and leave a little more.
    below = 1.5 if name == "barrel_indexer" else 0.02
    assert thickness - below <= place.thickness <= thickness + 0.02
    for limit, level in ((place.thickness / 0.999, "fail"), (place.thickness / 1.002, "pass")):
        verdict = judge(profile(name, cam=whole, limits={"min_wall_mm": limit}), ["wall"])
        assert next(one.level for one in verdict.findings if one.where == "floor to bore") == level
