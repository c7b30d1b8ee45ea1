"""A short stretch of the random campaign, and its judges judged: a body that is wrong must not pass."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from tests.places import ROOT

sys.path.insert(0, str(ROOT / "scripts" / "stability"))

from designs import KINDS, design
from judging import _judges, _surface, frozen, judge, topology

from camgeom.maths.mesh import Mesh
from camgeom.model import Model
from camgeom.profile import from_data


def test_a_seed_gives_one_design():
    assert design(12345) == design(12345)
    assert {design(seed)["cam"]["kind"] for seed in range(20)} == {kind.removesuffix("-groove") for kind in KINDS}


@pytest.mark.slow
@pytest.mark.parametrize("seed", [*range(6), 41, 264, 131, 214])
def test_a_stretch_of_the_campaign(seed):
    assert judge(design(seed), seed)["outcome"] != "FAILURE"


@pytest.mark.parametrize(("by", "passes"), [(0.0, True), (3.0, False)])
def test_the_judge_sees_a_surface_that_is_off(by, passes):
    data = frozen(design(0))
    model = Model(from_data(data))
    mesh, (oracle,) = model.solid.mesh, _judges(model, data)
    flank = np.unique(mesh.faces[mesh.group_faces("flank")])
    vertices = mesh.vertices.copy()
    # Cut away by a few tolerances on the flank alone.
    vertices[flank, :2] *= 1.0 - by * model.tolerance / np.hypot(*vertices[flank, :2].T).min()
    moved = Mesh(vertices, mesh.faces, mesh.groups, mesh.group)
    tolerances = model.tolerance, model.free_tolerance
    off, depth = _surface(moved, oracle, tolerances, np.random.default_rng(1))
    assert (off <= 1.001) == passes
    grown = Mesh(mesh.vertices * [1.0 + 0.1 * by, 1.0 + 0.1 * by, 1.0], mesh.faces, mesh.groups, mesh.group)
    assert (_surface(grown, oracle, tolerances, np.random.default_rng(1))[1] <= 1.0) == passes
    assert depth <= 1.0


def test_the_judge_counts_holes_and_pieces():
    model = Model(from_data(frozen(design(0))))
    mesh = model.solid.mesh
    assert topology(mesh) == (True, 1 if design(0)["cam"].get("bore") else 0, 1)
    faces = np.concatenate([mesh.faces, mesh.faces + len(mesh.vertices)])
    twice = Mesh(np.concatenate([mesh.vertices, mesh.vertices + 1e3]), faces)
    assert topology(twice)[2] == 2
    assert not topology(Mesh(mesh.vertices, mesh.faces[1:]))[0]
