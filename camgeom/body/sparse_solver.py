"""Linear elasticity on quadratic elements of any shape: conjugate gradients behind a factorisation of corners alone.

A quadratic displacement is the linear one of the corners and a part of the edges' own. On the first the stiffness is
factorised, on the second its diagonal serves: the number of steps does not hang on the size of the elements (H.
Yserentant, Numer. Math. 49 (1986) 379). Where elements are thin in planes and long across them, the stiffness of every
plane's nodes serves in place of the diagonal, factorised too: a sixth of the steps on the meshes of a root's peak. The
ring's dense elimination would take ten times as long on tetrahedra.

The factors are of single precision, which halves what every step reads and says nothing about the answer: what is left
over is measured in double. Where that does not settle they are made anew in double.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Protocol, final

import numpy as np
import numpy.typing as npt

from camgeom.errors import NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property

if TYPE_CHECKING:
    import scipy.sparse as sp

Index = npt.NDArray[np.int64]
Way = Callable[[Floats], Floats]
CHUNK = 2048
"""elements whose stiffness is made together"""
STEPS, IN_SINGLE = 2000, 400
"""of which so many with factors of single precision: ordinary bodies take 30 to 200"""
AT_ONCE = 8
"""loads solved together: what a matrix is read for once"""


class QuadraticMesh(Protocol):
    """A mesh of quadratic elements, corners first, then the middles of edges."""

    @property
    def nodes(self) -> Floats:
        """(v, 3), mm."""

    @property
    def elements(self) -> Index:
        """Node numbers (e, k)."""

    @property
    def sets(self) -> Mapping[str, Index]:
        """Node numbers by name."""

    @property
    def edges(self) -> tuple[tuple[int, int], ...]:
        """Corners of which the nodes behind the corners are the middles."""

    def stiffness(self, x: Floats, material: Floats) -> Floats:
        """Stiffness (e, 3 k, 3 k), N/mm, of elements with nodes (e, k, 3). Raises DesignError where one is folded."""


@final
@immutable
class SparseElastic:
    """Elements of one material, of stiffness (6, 6), MPa, whose nodes of the set `held` do not move; mm, N.

    planes  (v,) numbers of the planes that nodes of elements long across them belong to
    """

    mesh: QuadraticMesh
    material: Floats
    held: str = "bore"
    planes: Index | None = None

    @cached_property
    def _free(self) -> Floats:
        """Components that move, (3 v,), as a mask."""
        fixed = np.zeros(len(self.mesh.nodes), dtype=bool)
        fixed[self.mesh.sets[self.held]] = True
        return np.repeat(~fixed, 3)

    @cached_property
    def _system(self) -> tuple[sp.csr_array, sp.csr_array, sp.csr_array, sp.csr_array | None]:
        """Stiffness of what moves, what corners make of it, that on the corners, and that within planes."""
        import scipy.sparse as sp

        mesh, count = self.mesh, 3 * len(self.mesh.nodes)
        own = [mesh.stiffness(mesh.nodes[mesh.elements[start : start + CHUNK]], self.material)
               for start in range(0, len(mesh.elements), CHUNK)]  # fmt: skip
        entry = (3 * mesh.elements[:, :, None] + np.arange(3)).reshape(len(mesh.elements), -1).astype(np.int32)
        size = entry.shape[1]
        rows, columns = np.repeat(entry, size, axis=1).ravel(), np.tile(entry, (1, size)).ravel()
        whole = sp.coo_array((np.concatenate(own).ravel(), (rows, columns)), shape=(count, count)).tocsr()
        free = np.flatnonzero(self._free)
        inner = whole[free][:, free]
        prolong = self._linear[free]
        prolong = prolong[:, np.flatnonzero(np.diff(prolong.tocsc().indptr))]
        corners = prolong.T @ inner @ prolong
        if self.planes is None:
            return inner, prolong, corners, None
        plane, every = np.repeat(self.planes, 3)[free], inner.tocoo()
        near = plane[every.row] == plane[every.col]
        blocks = sp.coo_array((every.data[near], (every.row[near], every.col[near])), shape=inner.shape)
        return inner, prolong, corners, blocks.tocsr()

    def _near(self, kind: type[np.floating[Any]]) -> Way | None:
        """What brings forces (n, k) near the displacements under them, with factors of this precision; None where it
        has none."""
        inner, prolong, corners, blocks = self._system
        try:
            coarse = _factorised(corners, kind)
            within = None if blocks is None else _factorised(blocks, kind)
        except RuntimeError:  # a pivot of zero
            return None
        if within is not None:
            return lambda rest: within(rest) + prolong @ coarse(prolong.T @ rest)
        diagonal = 1.0 / inner.diagonal()[:, None]
        return lambda rest: diagonal * rest + prolong @ coarse(prolong.T @ rest)

    @cached_property
    def _single(self) -> Way | None:
        return self._near(np.float32)

    @cached_property
    def _double(self) -> Way | None:
        return self._near(np.float64)

    @property
    def _linear(self) -> sp.csr_array:
        """What components (3 v,) become where corners alone move, and the middles of edges with them; held ones stay.
        """
        import scipy.sparse as sp

        mesh = self.mesh
        ends = np.tile(np.arange(len(mesh.nodes))[:, None], (1, 2))
        corners = mesh.elements.shape[1] - len(mesh.edges)
        for k, (i, j) in enumerate(mesh.edges):
            ends[mesh.elements[:, corners + k]] = mesh.elements[:, [i, j]]
        rows, columns = (3 * one[:, None] + np.arange(3) for one in (np.repeat(np.arange(len(ends)), 2), ends.ravel()))
        size = 3 * len(ends)
        share = np.where(self._free[columns.ravel()], 0.5, 0.0)
        made = sp.coo_array((share, (rows.ravel(), columns.ravel())), shape=(size, size)).tocsr()
        made.eliminate_zeros()
        return made

    def solve(self, loads: Floats, tolerance: float = 1e-6) -> Floats:
        """Displacements (v, 3, k), mm, of all nodes under nodal forces (v, 3, k), N.

        tolerance  force that is left over, a share of the load's. Raises NotConverged where it is not reached.
        """
        found = np.zeros((len(self._free), loads.shape[2]))
        rest = loads.reshape(-1, loads.shape[2])[self._free]
        for first in range(0, loads.shape[2], AT_ONCE):
            part = rest[:, first : first + AT_ONCE]
            moved = None if "_double" in vars(self) else self._solved(part, tolerance, self._single, IN_SINGLE)
            if moved is None:
                moved = self._solved(part, tolerance, self._double, STEPS)
            if moved is None:
                raise NotConverged("the deflection of the cam's body did not settle: its elements are too flat")
            found[self._free, first : first + AT_ONCE] = moved
        return found.reshape(-1, 3, loads.shape[2])

    def _solved(self, rest: Floats, tolerance: float, near: Way | None, steps: int) -> Floats | None:
        """The same (n, k) of what moves under forces (n, k): every load has steps of its own, all of them together.
        None where they do not settle."""
        if near is None:
            return None
        inner, column = self._system[0], np.arange(rest.shape[1])
        found, x, least = np.zeros_like(rest), np.zeros_like(rest), tolerance * tolerance * _dots(rest, rest)
        way, before = np.zeros_like(rest), np.ones(rest.shape[1])
        for _ in range(steps + 1):
            done = _dots(rest, rest) <= least
            if done.any():
                found[:, column[done]] = x[:, done]
                x, rest, way = (np.ascontiguousarray(one[:, ~done]) for one in (x, rest, way))
                least, before, column = least[~done], before[~done], column[~done]
                if not len(column):
                    return found
            better = near(rest)
            energy = _dots(rest, better)
            if not (energy > 0.0).all():
                return None
            way *= energy / before
            way += better
            force, before = inner @ way, energy
            step = energy / _dots(way, force)
            x += step * way
            rest = rest - step * force
        return None


def _factorised(stiffness: sp.csr_array, kind: type[np.floating[Any]]) -> Way:
    """Displacements (n, k) under forces (n, k), by factors of this precision."""
    from scipy.sparse.linalg import splu

    stiff, options = float(np.abs(stiffness.data).max(initial=0.0)) or 1.0, {"SymmetricMode": True}
    matrix = (stiffness / stiff).tocsc().astype(kind)
    factors = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)

    def solve(forces: Floats) -> Floats:
        size = np.abs(forces).max(axis=0, initial=0.0)  # a force of 1e-40 N has no digits of single precision
        size[size == 0.0] = 1.0
        return np.asarray(factors.solve((forces / size).astype(kind)) * (size / stiff))

    return solve


def _dots(one: Floats, other: Floats) -> Floats:
    """Products (k,) of columns (n, k)."""
    return np.asarray(np.einsum("nk,nk->k", one, other))
