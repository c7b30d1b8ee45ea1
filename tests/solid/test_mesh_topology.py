"""Closedness, shells and genus of meshes, against independent counts and deliberately broken meshes."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from camgeom.maths.mesh import Mesh


def ring(n: int, m: int, start: int = 0) -> np.ndarray:
    """Faces of a closed n by m torus on vertices from `start`."""
    i, j = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    corner = [((i + p) % n * m + (j + q) % m).ravel() + start for p, q in ((0, 0), (1, 0), (1, 1), (0, 1))]
    return np.concatenate([np.stack([corner[k] for k in t], axis=1) for t in ((0, 1, 2), (0, 2, 3))])


def mesh_of(faces: np.ndarray, seed: int = 0) -> Mesh:
    """The faces in any order, on as many random vertices, and a few that no face uses."""
    rng = np.random.default_rng(seed)
    count = int(faces.max()) + 4 if len(faces) else 4
    name = rng.permutation(count)
    return Mesh(rng.normal(size=(count, 3)), rng.permutation(name[faces]).astype(np.int32))


def closed_by_counting(mesh: Mesh) -> bool:
    edges = Counter((int(a), int(b)) for f in mesh.faces for a, b in zip(f, np.roll(f, -1)))
    return all(n == 1 and edges[(b, a)] == 1 and a != b for (a, b), n in list(edges.items()))


def shells_by_scipy(mesh: Mesh) -> int:
    f = mesh.faces
    a, b = np.concatenate([f[:, 0], f[:, 1]]), np.concatenate([f[:, 1], f[:, 2]])
    size = len(mesh.vertices)
    labels = connected_components(coo_array((np.ones(len(a)), (a, b)), shape=(size, size)), directed=False)[1]
    return len(np.unique(labels[np.unique(f)]))


@settings(max_examples=60, deadline=None)
@given(n=st.integers(3, 9), m=st.integers(3, 9), shells=st.integers(1, 4), seed=st.integers(0, 10_000))
def test_tori_are_closed_and_counted(n: int, m: int, shells: int, seed: int) -> None:
    mesh = mesh_of(np.concatenate([ring(n, m, k * n * m) for k in range(shells)]), seed)
    assert mesh.watertight
    assert mesh.components == shells == shells_by_scipy(mesh)
    assert mesh.genus == shells
    assert sum(len(shell.faces) for shell in mesh.shells) == len(mesh.faces)


@settings(max_examples=80, deadline=None)
@given(seed=st.integers(0, 100_000), damage=st.sampled_from(["drop", "turn", "twice", "weld", "collapse", "none"]))
def test_damage_is_seen(seed: int, damage: str) -> None:
    rng = np.random.default_rng(seed)
    faces = np.concatenate([ring(4, 5), ring(3, 6, 20)])
    k = int(rng.integers(len(faces)))
    if damage == "drop":
        faces = np.delete(faces, k, axis=0)
    elif damage == "turn":
        faces[k] = faces[k, ::-1]
    elif damage == "twice":
        faces = np.concatenate([faces, faces[k : k + 1]])
    elif damage == "weld":
        faces = np.where(faces == 20, 0, faces)
    elif damage == "collapse":
        faces[k, 1] = faces[k, 0]
    mesh = mesh_of(faces, seed)
    assert mesh.watertight == closed_by_counting(mesh) == (damage in ("none", "weld"))
    assert mesh.components == shells_by_scipy(mesh)


@pytest.mark.parametrize("faces", [np.zeros((0, 3), int), np.array([[0, 1, 2]]), np.array([[0, 1, 2], [0, 1, 2]])])
def test_open_pieces_are_not_closed(faces: np.ndarray) -> None:
    assert not mesh_of(faces).watertight


def test_long_chains_of_shells_are_followed_to_the_end() -> None:
    strip = np.stack([np.arange(20_000), np.arange(1, 20_001), np.arange(2, 20_002)], axis=1)
    assert mesh_of(strip, 3).components == 1
    assert mesh_of(strip[::3], 3).components == len(strip[::3])
