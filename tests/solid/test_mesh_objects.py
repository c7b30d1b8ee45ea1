"""Solids as objects of other libraries: the same points, faces, groups and fields."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import camgeom
from camgeom.maths.mesh import clip
from tests.places import PROFILES

PROFILE = PROFILES / "disc_flat_face.toml"


@pytest.fixture(scope="module")
def solid() -> object:
    made = camgeom.read(str(PROFILE)).solid
    mesh = replace(made.mesh, fields={"pressure_mpa": made.mesh.vertices[:, 2] * 2.0})
    return replace(made, mesh=mesh)


def test_as_trimesh(solid) -> None:
    made = solid.to_trimesh()
    assert made.is_watertight
    assert np.array_equal(made.vertices, solid.mesh.vertices)
    assert np.array_equal(made.faces, solid.mesh.faces)
    assert made.volume == pytest.approx(solid.mesh.volume, rel=1e-12)
    assert np.array_equal(made.vertex_attributes["pressure_mpa"], solid.mesh.fields["pressure_mpa"])
    assert np.array_equal(made.face_attributes["group"], solid.mesh.group)
    assert made.metadata["groups"] == list(solid.mesh.groups)


def test_as_pyvista(solid) -> None:
    made = solid.to_pyvista()
    assert made.is_manifold
    assert made.n_cells == len(solid.mesh.faces)
    assert np.array_equal(made.points, solid.mesh.vertices)
    assert np.array_equal(made.regular_faces, solid.mesh.faces)
    assert made.volume == pytest.approx(solid.mesh.volume, rel=1e-6)
    assert np.array_equal(made.point_data["pressure_mpa"], solid.mesh.fields["pressure_mpa"])
    assert list(made.field_data["groups"]) == list(solid.mesh.groups)


def test_a_mesh_of_many_vertices_with_short_numbers_is_cut_where_it_crosses() -> None:
    """The number of an edge, of both its ends, has no room in the bits of one end's."""
    many = 50_000
    points = np.zeros((many, 3))
    points[-3:] = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 0.0, 2.0]]
    faces = np.array([[many - 3, many - 2, many - 1]], dtype=np.int32)
    found, kept, _ = clip(points, faces, np.zeros(1, dtype=np.int32), 0.5, 1.0)
    assert len(kept) == 2
    assert found[many:].tolist() == [[0.0, 0.0, 0.5], [3.0, 0.0, 0.5]]
