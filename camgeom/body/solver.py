"""Linear elasticity on a ring: one factorisation in dense blocks, plane by plane round the ring, for many loads.

The nodes half way between two planes are condensed first; what is left couples every plane to the next alone, a cyclic
block-tridiagonal matrix. It is eliminated plane by plane with the coupling to the last plane carried along, all in
BLAS: about 8 m^3 operations a plane, m the unknowns of one. A sparse LU of as many unknowns took ten times as long.
"""

from __future__ import annotations

from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.body.element import elasticity, stiffness
from camgeom.body.hexes import HexMesh
from camgeom.body.ring import RingMesh
from camgeom.body.sparse_solver import SparseElastic
from camgeom.errors import DesignError, NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.material import Material

Index = npt.NDArray[np.int64]
TIGHT = 1e-5
"""force that iterations leave over, a share of the load's: stress at roots lies within 3e-7 of that at 1e-7"""
MOST_BYTES = 1.6e9
"""of the factors: with the working arrays and all else about 2 GB"""


@final
@immutable(eq=True)
class SolverCost:
    """What a factorisation takes, known before it starts."""

    unknowns: int
    bytes: float


@final
@immutable
class Elastic:
    """A ring of one material, of stiffness (6, 6), MPa (`elasticity`), whose nodes of the set `held` do not move."""

    ring: RingMesh
    material: Floats
    held: str = "bore"

    @cached_property
    def _free(self) -> tuple[Index, Index]:
        """Components (3 k,) that may move, of a plane's nodes and of the nodes half way."""
        ring, fixed = self.ring, self.ring.sets[self.held]
        half = ring.corner[fixed]
        free = np.setdiff1d(np.arange(ring.face.shape[1]), fixed)
        other = np.setdiff1d(np.arange(ring.middle.shape[1]), half[half >= 0])
        return tuple((3 * k[:, None] + np.arange(3)).ravel() for k in (free, other))  # type: ignore[return-value]

    @cached_property
    def cost(self) -> SolverCost:
        """What the factorisation takes."""
        n, (face, half) = len(self.ring.planes), self._free
        m, c = float(len(face)), float(len(half))
        return SolverCost(int(n * (m + c)), 8.0 * n * (3.0 * m * m + c * c + 2.0 * c * m))

    @cached_property
    def _factors(self) -> _Factors:
        cost = self.cost
        if cost.bytes > MOST_BYTES:
            raise DesignError(f"the body's {cost.unknowns} unknowns would take {cost.bytes / 1e9:.2g} GB: more than "
                              f"the {MOST_BYTES / 1e9:.2g} GB that are spent on it; fewer grooves")  # fmt: skip
        return _factorised(self)

    def solve(self, loads: Floats) -> Floats:
        """Displacements (v, 3, k), mm, of all nodes under nodal forces (v, 3, k), N."""
        return self._factors.solve(loads)

    def solve_one(self, forces: Floats) -> Floats:
        """Displacements (v, 3), mm, under one load (v, 3), N: for a few of them iterations take half the time."""
        ring = self.ring
        mesh = HexMesh(ring.nodes, ring.elements, {self.held: ring.node_set(self.held)})
        planes = np.arange(len(ring.nodes)) // (ring.face.shape[1] + ring.middle.shape[1])
        solver = SparseElastic(mesh, self.material, self.held, planes)
        return np.asarray(solver.solve(forces[:, :, None], TIGHT)[:, :, 0])


def elastic(ring: RingMesh, material: Material) -> Elastic:
    """A ring of a material, held in its bore."""
    return Elastic(ring, elasticity(material.elastic_modulus, material.poisson))


@final
@immutable
class _Factors:
    """Lower triangles of the planes, their couplings to the next and to the last plane, and those half way."""

    free: tuple[Index, Index]
    nodes: tuple[int, int]
    lower: list[Floats]
    ahead: list[Floats]
    last: list[Floats]
    half: list[Floats]
    across: list[Floats]

    def solve(self, loads: Floats) -> Floats:
        """Displacements of all nodes; see `Elastic.solve`."""
        from scipy.linalg import solve_triangular

        n, k = len(self.lower), loads.shape[2]
        f, _ = self.nodes
        face, half = self.free
        rows = loads.reshape(n, -1, 3, k)
        m = len(face)
        b = [rows[i, :f].reshape(-1, k)[face] for i in range(n)]
        inner = [solve_triangular(self.half[i], rows[i, f:].reshape(-1, k)[half], lower=True) for i in range(n)]
        for i in range(n):
            part = self.across[i].T @ inner[i]
            b[i] = b[i] - part[:m]
            b[(i + 1) % n] = b[(i + 1) % n] - part[m:]
        for i in range(n - 1):
            b[i] = solve_triangular(self.lower[i], b[i], lower=True)
            if i + 1 < n - 1:
                b[i + 1] = b[i + 1] - self.ahead[i].T @ b[i]
            b[n - 1] = b[n - 1] - self.last[i].T @ b[i]
        b[n - 1] = solve_triangular(self.lower[-1], b[n - 1], lower=True)
        b[n - 1] = solve_triangular(self.lower[-1], b[n - 1], lower=True, trans="T")
        for i in range(n - 2, -1, -1):
            known = self.last[i] @ b[n - 1]
            if i + 1 < n - 1:
                known = known + self.ahead[i] @ b[i + 1]
            b[i] = solve_triangular(self.lower[i], b[i] - known, lower=True, trans="T")
        found = np.zeros((n, sum(self.nodes) * 3, k))
        for i in range(n):
            found[i, face] = b[i]
            both = np.concatenate([b[i], b[(i + 1) % n]])
            found[i, 3 * f + half] = solve_triangular(
                self.half[i], inner[i] - self.across[i] @ both, lower=True, trans="T"
            )
        return found.reshape(-1, 3, k)


def _factorised(problem: Elastic) -> _Factors:
    from scipy.linalg import LinAlgError, cholesky, solve_triangular

    ring, (face, half) = problem.ring, problem._free
    n, f, h = len(ring.planes), ring.face.shape[1], ring.middle.shape[1]
    size, m = 3 * (2 * f + h), len(face)
    places = np.where(ring.local >= f + h, ring.local - h, np.where(ring.local >= f, ring.local + f, ring.local))
    order = np.concatenate([face, 3 * f + face, 6 * f + half])
    entry = (3 * places[:, :, None] + np.arange(3)).reshape(len(places), 60)
    flat = (entry[:, :, None] * size + entry[:, None, :]).ravel()
    nodes = ring.nodes
    elements = ring.elements.reshape(n, -1, 20)
    diagonal: list[Floats] = [np.zeros((m, m)) for _ in range(n)]
    couple: list[Floats] = []
    halves: list[Floats] = []
    across: list[Floats] = []
    try:
        for i in range(n):
            own = stiffness(nodes[elements[i]], problem.material)
            slab = np.bincount(flat, own.ravel(), minlength=size * size).reshape(size, size)[np.ix_(order, order)]
            low = cholesky(slab[2 * m :, 2 * m :], lower=True, check_finite=False)
            side = solve_triangular(low, slab[2 * m :, : 2 * m], lower=True, check_finite=False)
            left = slab[: 2 * m, : 2 * m] - side.T @ side
            diagonal[i] += left[:m, :m]
            diagonal[(i + 1) % n] += left[m:, m:]
            couple.append(left[:m, m:].copy())
            halves.append(low)
            across.append(side)
        lower: list[Floats] = []
        ahead: list[Floats] = []
        last: list[Floats] = []
        carried = couple[n - 1].T.copy()
        for i in range(n - 1):
            if i == n - 2:
                carried = carried + couple[i]
            low = cholesky(diagonal[i], lower=True, check_finite=False)
            last.append(solve_triangular(low, carried, lower=True, check_finite=False))
            lower.append(low)
            if i < n - 2:
                ahead.append(solve_triangular(low, couple[i], lower=True, check_finite=False))
                diagonal[i + 1] -= ahead[i].T @ ahead[i]
                carried = -(ahead[i].T @ last[i])
            diagonal[n - 1] -= last[i].T @ last[i]
            diagonal[i] = couple[i] = np.zeros((0, 0))
        lower.append(cholesky(diagonal[n - 1], lower=True, check_finite=False))
    except LinAlgError as error:
        raise NotConverged(f"the body's stiffness is not positive definite ({error}): nothing holds it") from error
    return _Factors((face, half), (f, h), lower, ahead, last, halves, across)
