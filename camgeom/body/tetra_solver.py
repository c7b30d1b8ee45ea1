"""Linear elasticity on ten-node tetrahedra: conjugate gradients behind a factorisation of their corners alone.

A quadratic displacement is the linear one of the corners and a part of the edges' own. On the first the stiffness is
factorised, on the second its diagonal serves: the number of steps does not hang on the size of the elements (H.
Yserentant, Numer. Math. 49 (1986) 379). The ring's dense elimination would take ten times as long here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, final

import numpy as np

from camgeom.body.element import gradients, strain_matrix
from camgeom.body.tetra import EDGES, TetraMesh, rates
from camgeom.errors import NotConverged
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property

if TYPE_CHECKING:
    import scipy.sparse as sp

INSIDE = 0.13819660112501053
"""(5 - sqrt 5)/20: of the four Gauss points' barycentric coordinates the three that are alike, exact to degree two"""
CHUNK = 2048
"""elements whose stiffness is made together"""
STEPS = 2000


@final
@dataclass(frozen=True, eq=False)
class TetraElastic:
    """Tetrahedra of one material, of stiffness (6, 6), MPa, whose nodes of the set `held` do not move; mm, N."""

    mesh: TetraMesh
    material: Floats
    held: str = "bore"

    @cached_property
    def _free(self) -> Floats:
        """Components that move, (3 v,), as a mask."""
        fixed = np.zeros(len(self.mesh.nodes), dtype=bool)
        fixed[self.mesh.sets[self.held]] = True
        return np.repeat(~fixed, 3)

    @cached_property
    def _system(self) -> tuple[sp.csr_array, sp.csr_array, Any]:
        """Stiffness of what moves, what corners make of it, and the factorisation on the corners."""
        import scipy.sparse as sp
        from scipy.sparse.linalg import splu

        mesh, count = self.mesh, 3 * len(self.mesh.nodes)
        at = np.full((4, 4), INSIDE) + (1.0 - 4.0 * INSIDE) * np.eye(4)
        rate = rates(at)
        own = []
        for start in range(0, len(mesh.elements), CHUNK):
            gradient, volume = gradients(mesh.nodes[mesh.elements[start : start + CHUNK]], rate)
            b = strain_matrix(gradient)
            db = (volume / 24.0)[:, :, None, None] * (self.material @ b)
            own.append(np.swapaxes(b.reshape(len(b), -1, 30), 1, 2) @ db.reshape(len(b), -1, 30))
        entry = (3 * mesh.elements[:, :, None] + np.arange(3)).reshape(-1, 30)
        rows, columns = np.repeat(entry, 30, axis=1).ravel(), np.tile(entry, (1, 30)).ravel()
        whole = sp.coo_array((np.concatenate(own).ravel(), (rows, columns)), shape=(count, count)).tocsr()
        free = np.flatnonzero(self._free)
        inner = whole[free][:, free]
        prolong = self._linear[free]
        prolong = prolong[:, np.flatnonzero(np.diff(prolong.tocsc().indptr))]
        coarse = (prolong.T @ inner @ prolong).tocsc()
        factors = splu(coarse, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        return inner, prolong, factors

    @property
    def _linear(self) -> sp.csr_array:
        """What components (3 v,) become where corners alone move, and the middles of edges with them; held ones stay.
        """
        import scipy.sparse as sp

        mesh = self.mesh
        ends = np.tile(np.arange(len(mesh.nodes))[:, None], (1, 2))
        for k, (i, j) in enumerate(EDGES):
            ends[mesh.elements[:, 4 + k]] = mesh.elements[:, [i, j]]
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
        inner, prolong, factors = self._system
        diagonal = 1.0 / inner.diagonal()
        found = np.zeros((len(self._free), loads.shape[2]))

        def nearly(rest: Floats) -> Floats:
            return np.asarray(diagonal * rest + prolong @ factors.solve(prolong.T @ rest))

        for k in range(loads.shape[2]):
            rest = loads[:, :, k].ravel()[self._free]
            x, least = np.zeros_like(rest), tolerance * float(np.sqrt(rest @ rest))
            way = better = nearly(rest)
            energy = float(rest @ better)
            for _ in range(STEPS):
                if float(np.sqrt(rest @ rest)) <= least:
                    break
                force = inner @ way
                step = energy / float(way @ force)
                x, rest = x + step * way, rest - step * force
                better = nearly(rest)
                before, energy = energy, float(rest @ better)
                way = better + (energy / before) * way
            else:
                raise NotConverged("the deflection of the cam's body did not settle: its tetrahedra are too flat")
            found[self._free, k] = x
        return found.reshape(-1, 3, loads.shape[2])
