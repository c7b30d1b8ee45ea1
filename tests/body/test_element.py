"""The 20-node hexahedron: patch test, a cantilever against Timoshenko, a ring against Lame, and the ring's solver."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.linalg import spsolve

from camgeom.body import solver, sparse_solver
from camgeom.body.element import (
    NATURAL,
    elasticity,
    gauss,
    gradients,
    largest_principal,
    shapes,
    stiffness,
    strain_matrix,
    stresses,
)
from camgeom.body.hexes import HexMesh
from camgeom.body.plate import PlateSection
from camgeom.body.ring import RingMesh, even_planes, ring_of
from camgeom.body.solver import Elastic
from camgeom.body.sparse_solver import SparseElastic
from camgeom.errors import DesignError, NotConverged
from camgeom.solid.blank import Bore
from camgeom.solid.prism import Loop, Prism
from camgeom.track.outline import CircleOutline

E, NU = 210000.0, 0.3


def bricks(counts: tuple[int, int, int], size: tuple[float, float, float], skew: float = 0.0):
    """Nodes (v, 3) and elements (e, 20) of a block; inner corners moved by a share `skew` of a cell."""
    rng = np.random.default_rng(7)
    corner = np.stack(np.meshgrid(*(np.arange(n + 1.0) for n in counts), indexing="ij"), axis=-1)
    inner = np.all((corner > 0) & (corner < np.array(counts)), axis=-1)
    moved = corner + skew * inner[..., None] * rng.uniform(-1.0, 1.0, corner.shape)
    moved = moved / np.array(counts) * np.array(size)
    numbers: dict[tuple[float, ...], int] = {}
    points, elements = [], []
    for cell in np.ndindex(*counts):
        ends = [moved[tuple(np.array(cell) + ((NATURAL[k] + 1) / 2).astype(int))] for k in range(8)]
        nodes = []
        for k, at in enumerate(NATURAL):
            key = tuple(np.array(cell) * 2 + at + 1)
            if key not in numbers:
                numbers[key] = len(points)
                on = at == 0.0
                near = [e for e, c in zip(ends, NATURAL[:8]) if np.all(on | (c == at))]
                points.append(np.mean(near, axis=0))
            nodes.append(numbers[key])
            assert k < 20
        elements.append(nodes)
    return np.array(points), np.array(elements)


def assembled(x: np.ndarray, elements: np.ndarray, poisson: float = NU):
    dof = (3 * elements[:, :, None] + np.arange(3)).reshape(len(elements), 60)
    k = stiffness(x[elements], elasticity(E, poisson))
    rows, columns = np.broadcast_arrays(dof[:, :, None], dof[:, None, :])
    return coo_array((k.ravel(), (rows.ravel(), columns.ravel())), shape=(3 * len(x),) * 2).tocsc()


def solved(matrix, loads: np.ndarray, held: np.ndarray, values: np.ndarray) -> np.ndarray:
    free = np.setdiff1d(np.arange(len(loads)), held)
    found = np.zeros(len(loads))
    found[held] = values
    found[free] = spsolve(matrix[free][:, free], loads[free] - matrix[free] @ found)
    return found


def test_shape_functions_are_one_at_their_node_and_sum_to_one() -> None:
    value, _ = shapes(NATURAL)
    assert np.allclose(value, np.eye(20))
    at = np.random.default_rng(1).uniform(-1.0, 1.0, (7, 3))
    value, rate = shapes(at)
    assert np.allclose(value.sum(axis=1), 1.0)
    for k in range(3):
        step = np.zeros(3)
        step[k] = 1e-6
        assert np.allclose((shapes(at + step)[0] - shapes(at - step)[0]) / 2e-6, rate[:, :, k], atol=1e-8)


def test_patch_of_skewed_elements_holds_every_constant_strain() -> None:
    x, elements = bricks((2, 3, 2), (3.0, 4.0, 2.0), 0.25)
    matrix = assembled(x, elements)
    outer = np.flatnonzero(np.any(np.isclose(x, 0.0) | np.isclose(x, [3.0, 4.0, 2.0]), axis=1))
    held = (3 * outer[:, None] + np.arange(3)).ravel()
    assert len(held) < 3 * len(x)
    for seed in range(3):
        gradient = np.random.default_rng(seed).uniform(-1e-3, 1e-3, (3, 3))
        exact = x @ gradient.T + 0.01
        found = solved(matrix, np.zeros(3 * len(x)), held, exact[outer].ravel()).reshape(-1, 3)
        assert np.abs(found - exact).max() < 1e-10 * np.abs(exact).max()
        strain = 0.5 * (gradient + gradient.T)
        wanted = elasticity(E, NU) @ [*np.diag(strain), 2 * strain[0, 1], 2 * strain[1, 2], 2 * strain[2, 0]]
        stress = stresses(x[elements], found[elements], np.zeros((1, 3)), elasticity(E, NU))
        assert np.abs(stress - wanted).max() < 1e-10 * np.abs(wanted).max()


@pytest.mark.parametrize(("layers", "least"), [(1, 0.99), (2, 0.995)])
def test_a_slender_cantilever_does_not_lock(layers: int, least: float) -> None:
    length, height, width, force = 100.0, 10.0, 10.0, 100.0
    x, elements = bricks((10 * layers, layers, layers), (length, height, width))
    matrix = assembled(x, elements, 0.0)  # a wall that holds the section's width would stiffen another material
    loads = np.zeros(3 * len(x))
    for nodes in elements[np.isclose(x[elements[:, 1], 0], length)]:
        at, weight = face_rule(0, 1.0)
        value, _ = shapes(at)
        area = height * width / layers**2 / 4.0
        np.add.at(loads, 3 * nodes + 1, force / (height * width) * area * (weight @ value))
    wall = np.flatnonzero(np.isclose(x[:, 0], 0.0))
    held = (3 * wall[:, None] + np.arange(3)).ravel()
    found = solved(matrix, loads, held, np.zeros(len(held))).reshape(-1, 3)
    inertia, shear = width * height**3 / 12.0, 0.5 * E
    exact = force * length**3 / (3.0 * E * inertia) + force * length / (5.0 / 6.0 * shear * height * width)
    tip = found[np.isclose(x[:, 0], length), 1].mean()
    assert loads.sum() == pytest.approx(force)
    assert least < tip / exact < 1.001


def face_rule(axis: int, side: float) -> tuple[np.ndarray, np.ndarray]:
    p, w = np.polynomial.legendre.leggauss(3)
    a, b = np.meshgrid(p, p, indexing="ij")
    at = np.empty((9, 3))
    at[:, axis] = side
    at[:, (axis + 1) % 3], at[:, (axis + 2) % 3] = a.ravel(), b.ravel()
    return at, np.outer(w, w).ravel()


def disc(cells: tuple[int, int, int], planes: int) -> RingMesh:
    body = Prism("disc", Loop(CircleOutline(50.0), "flank"), 0.0, 12.0, (), Bore(40.0))
    return ring_of(PlateSection(body, cells), even_planes(planes))


def pressed(ring: RingMesh, pressure: float) -> np.ndarray:
    """Nodal forces (v, 3, 1) of a pressure on the outside."""
    loads = np.zeros((len(ring.nodes), 3, 1))
    at, weight = face_rule(0, -1.0)
    value, rate = shapes(at)
    for nodes in ring.elements.reshape(len(ring.planes), -1, 20)[:, ring.contour].reshape(-1, 20):
        x = ring.nodes[nodes]
        along, up = np.einsum("pn,nk->pk", rate[:, :, 1], x), np.einsum("pn,nk->pk", rate[:, :, 2], x)
        normal = np.cross(along, up)
        normal *= np.sign((normal * (value @ x)[:, :] * [1, 1, 0]).sum(axis=1))[:, None]
        loads[nodes, :, 0] -= pressure * np.einsum("p,pn,pk->nk", weight, value, normal)
    return loads


def lame_error(cells: tuple[int, int, int], planes: int) -> float:
    """Largest error of the radial displacement of a ring held at its bore under outer pressure, against Lame.

    Of poisson 0: u = A (r - a² / r), with E A (1 + a² / b²) = -p.
    """
    ring, p, a, b = disc(cells, planes), 100.0, 20.0, 50.0
    found = Elastic(ring, elasticity(E, 0.0)).solve(pressed(ring, p))[:, :, 0]
    r = np.hypot(ring.nodes[:, 0], ring.nodes[:, 1])
    exact = -p / (E * (1.0 + (a / b) ** 2)) * (r - a * a / r)
    radial = (found[:, :2] * ring.nodes[:, :2]).sum(axis=1) / r
    return float(np.abs(radial - exact).max() / np.abs(exact).max())


def test_a_ring_under_pressure_tends_to_lame_with_its_order() -> None:
    coarse, fine = lame_error((1, 1, 1), 12), lame_error((1, 2, 2), 24)
    assert coarse < 5e-3
    assert fine < coarse / 6.0  # third order or better


def test_the_ring_solver_agrees_with_a_sparse_one(monkeypatch: pytest.MonkeyPatch) -> None:
    ring = disc((1, 1, 1), 9)
    rng = np.random.default_rng(3)
    loads = rng.normal(size=(len(ring.nodes), 3, 2))
    problem = Elastic(ring, elasticity(E, NU))
    found = problem.solve(loads)
    bore = ring.node_set("bore")
    held = (3 * bore[:, None] + np.arange(3)).ravel()
    matrix = assembled(ring.nodes, ring.elements)
    for k in range(2):
        exact = solved(matrix, loads[:, :, k].ravel(), held, np.zeros(len(held)))
        assert np.abs(found[:, :, k].ravel() - exact).max() < 1e-9 * np.abs(exact).max()
    assert problem.cost.unknowns == 3 * (len(ring.nodes) - len(bore))
    # One load is solved by iterations, which need none of the memory that the factors take.
    monkeypatch.setattr(solver, "MOST_BYTES", 0.0)
    with pytest.raises(DesignError, match="would take"):
        Elastic(ring, elasticity(E, NU)).solve(loads)
    other = problem.solve_one(loads[:, :, 0])
    assert np.abs(other - found[:, :, 0]).max() < 1e-5 * np.abs(found).max()


def test_planes_of_thin_elements_are_solved_together(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cells of 1.25 x 1.5 mm that are 24 mm long about the axis: the same displacements, in a tenth of the steps."""
    ring, material = disc((2, 8, 8), 12), elasticity(E, NU)
    loads = np.random.default_rng(5).normal(size=(len(ring.nodes), 3, 1))
    mesh = HexMesh(ring.nodes, ring.elements, {"bore": ring.node_set("bore")})
    planes = np.arange(len(ring.nodes)) // (ring.face.shape[1] + ring.middle.shape[1])
    known = Elastic(ring, material).solve(loads)
    monkeypatch.setattr(sparse_solver, "STEPS", 80)
    monkeypatch.setattr(sparse_solver, "IN_SINGLE", 80)
    found = SparseElastic(mesh, material, "bore", planes).solve(loads, 1e-9)
    assert np.abs(found - known).max() < 1e-6 * np.abs(known).max()
    with pytest.raises(NotConverged, match="too flat"):
        SparseElastic(mesh, material).solve(loads, 1e-9)


def test_factors_of_single_precision_say_nothing_about_the_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same displacements within what may be left over, whatever unit forces have; in double where it is needed."""
    ring, material = disc((2, 3, 3), 12), elasticity(E, NU)
    loads = np.random.default_rng(6).normal(size=(len(ring.nodes), 3, 3)) * [1.0, 1e-60, 1e60]
    mesh = HexMesh(ring.nodes, ring.elements, {"bore": ring.node_set("bore")})
    known = Elastic(ring, material).solve(loads)
    largest = np.abs(known).max(axis=(0, 1))
    solver = SparseElastic(mesh, material)
    for found in (solver.solve(loads, 1e-10), solver.solve(1e-3 * loads, 1e-10) * 1e3):
        assert (np.abs(found - known).max(axis=(0, 1)) < 1e-8 * largest).all()
    assert "_double" not in vars(solver)
    none = SparseElastic(mesh, material).solve(np.zeros_like(loads))
    assert not none.any()
    monkeypatch.setattr(sparse_solver, "IN_SINGLE", 3)
    other = SparseElastic(mesh, material)
    assert (np.abs(other.solve(loads, 1e-10) - known).max(axis=(0, 1)) < 1e-8 * largest).all()
    assert "_double" in vars(other)
    monkeypatch.setattr(sparse_solver, "STEPS", 3)
    with pytest.raises(NotConverged, match="too flat"):
        SparseElastic(mesh, material).solve(loads, 1e-10)


def test_a_folded_element_and_a_material_that_keeps_its_volume_are_refused() -> None:
    x, elements = bricks((1, 1, 1), (1.0, 1.0, 1.0))
    with pytest.raises(DesignError, match="folded"):
        stiffness((x * [1.0, 1.0, -1.0])[elements], elasticity(E, NU))
    with pytest.raises(DesignError, match="poisson"):
        elasticity(E, 0.5)


def test_volume_and_principal_stress() -> None:
    x, elements = bricks((1, 1, 1), (2.0, 3.0, 4.0))
    at, weight = gauss()
    gradient, volume = gradients(x[elements], shapes(at)[1])
    assert (volume * weight).sum() == pytest.approx(24.0)
    assert strain_matrix(gradient).shape == (1, 27, 6, 60)
    assert largest_principal(np.array([1.0, 1.0, 0.0, 2.0, 0.0, 0.0])) == pytest.approx(3.0)
