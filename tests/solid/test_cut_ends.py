"""Where grooves leave the body through its ends: vertices on the true surface and on the end plane, both."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from camgeom.checks import judge
from camgeom.model import Model, read
from camgeom.solid import ENDS_CUT
from camgeom.track.clearance import largest_gap, least_distances
from camgeom.track.column import Column
from camgeom.track.flank import Flank
from tests.places import PROFILES
from tests.reference.barrels import barrel

TURRETS = ("barrel_indexer", "conical_indexer", "tool_changer", "two_start")
WIDTHS = (80.0, 84.0, 86.0, 88.0)
MADE = {name: lambda name=name: read(str(PROFILES / f"{name}.toml")) for name in TURRETS}
MADE |= {f"balls {width:g}": lambda width=width: barrel(width, "sphere") for width in WIDTHS}


def cutters(model: Model, points: np.ndarray) -> np.ndarray:
    """Least distance from the tools, which are as long as it takes."""
    tools = (replace(t, contact=(t.contact[0] - 20.0, t.contact[1])) for t in model.cutters)
    return np.min([least_distances(track, points) for track in tools], axis=0)


@pytest.mark.parametrize("name", MADE)
def test_vertices_of_cut_ends_lie_on_the_true_surface(name) -> None:
    model = MADE[name]()
    solid = model.solid
    assert solid.method == ENDS_CUT
    mesh, half = solid.mesh, 0.5 * model.mechanism.width
    on_end = mesh.group_vertices("end") & mesh.group_vertices("flank", "floor", "land")
    assert set(np.abs(mesh.vertices[on_end, 2])) == {half}
    ends = mesh.vertices[mesh.group_vertices("end") & mesh.group_vertices("flank")]
    assert len(ends) > 20
    # Neither does a tool cut deeper than the vertex, nor does it stay away from it.
    assert np.abs(cutters(model, ends)).max() < 1e-9
    gap = largest_gap(model.cutters, (), ends, np.zeros(len(ends)))
    assert abs(gap.value) < 1e-9
    land = mesh.vertices[mesh.group_vertices("end") & mesh.group_vertices("land")]
    (part,) = model.parts
    assert np.abs(part.land.level(land.T)).max() < 1e-10


@pytest.mark.parametrize("name", MADE)
def test_facets_of_cut_ends_keep_the_error_that_is_stated(name) -> None:
    """Random points of the flank's facets beside the ends, against every position of the tools."""
    model = MADE[name]()
    solid, rng = model.solid, np.random.default_rng(5)
    assert solid.chord_error <= model.tolerance
    mesh = solid.mesh
    flank = mesh.faces[mesh.group_faces("flank")]
    beside = flank[mesh.group_vertices("end")[flank].any(axis=1)]
    weights = rng.dirichlet((0.7, 0.7, 0.7), len(beside))
    points = (mesh.vertices[beside] * weights[:, :, None]).sum(axis=1)
    assert cutters(model, points).min() > -1.001 * solid.chord_error
    assert largest_gap(model.cutters, (), points, np.zeros(len(points))).value < 1.001 * solid.chord_error


@pytest.mark.parametrize(("proud", "level"), [(0.0, "pass"), (1e-6, "fail")])
def test_a_vertex_of_a_cut_end_has_no_slack(proud, level) -> None:
    model = barrel(86.0, "sphere")
    solid = model.solid
    mesh = solid.mesh
    ends = np.flatnonzero(mesh.group_vertices("end") & mesh.group_vertices("flank"))
    track = model.passages[0]
    near = ends[np.argmin(np.abs(least_distances(track, mesh.vertices[ends])))]
    found = model.clearances[0]
    assert found.value > -1e-9
    # Into the groove, along the way to the roller's axis where it passes the vertex.
    gap = largest_gap((track,), (), mesh.vertices[[near]], np.zeros(1))
    axis = track.pose(np.array([gap.cam_angle]), 0)
    centre = axis.a[0][:, 0] + track.meridian.centre * axis.u[0][:, 0]
    vertices = mesh.vertices.copy()
    vertices[near] += proud * (centre - vertices[near]) / np.linalg.norm(centre - vertices[near])
    model.body.__dict__["solids"] = (replace(solid, mesh=replace(mesh, vertices=vertices)),)
    del model.__dict__["clearances"]
    assert {f.level for f in judge(model, ["interference"]).findings} == {level}


@pytest.mark.parametrize("name", ["conical_indexer", "tool_changer", "pin_insertion"])
def test_walls_of_a_column_are_the_flanks(name) -> None:
    """Cones and cylinders have short forms of their own, stations alike for all cam angles or not."""
    for track in MADE.get(name, lambda: read(str(PROFILES / f"{name}.toml")))().cutters:
        phi = np.linspace(*track.span, 60)
        same = np.linspace(*sorted(track.meridian.parameter(d) for d in track.contact), 7)
        for t in (same, same + np.linspace(0.0, 0.01, 60)[:, None]):
            for side in track.sides:
                assert Column(track, phi).wall(side, t) == pytest.approx(Flank(track, phi, t, side).x, abs=1e-11)
