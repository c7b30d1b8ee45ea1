"""What the cam is made of: blanks, recipes of bodies, and closed meshes with a stated error."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from camgeom.immutable import immutable
from camgeom.maths.frozen import cached_property
from camgeom.maths.mesh import Mesh

Mask = npt.NDArray[np.bool_]
TOOL = ("flank", "edge", "root", "floor", "back", "cap")
"""groups of the faces that tools leave"""
ENDS_CUT = "direct, ends cut"
UNION = "union of rollers"
"""how bodies are made, beside the direct mesh and the boolean"""


@immutable
class Solid:
    """A finished body: its mesh, the guaranteed chord error (mm), how it was made, and the genus it should have."""

    name: str
    mesh: Mesh
    chord_error: float
    method: str
    expected_genus: int

    @property
    def pieces(self) -> tuple[Mesh, ...]:
        """The connected shells, the largest first; one for a sound body."""
        return (self.mesh,) if self.mesh.components == 1 else tuple(
            sorted(self.mesh.shells, key=lambda shell: -abs(shell.volume))
        )

    @property
    def sound(self) -> bool:
        """Watertight, of positive volume, one shell, and of the expected genus."""
        m = self.mesh
        return m.watertight and m.volume > 0.0 and m.components == 1 and m.genus == self.expected_genus

    @cached_property
    def cut_vertices(self) -> Mask:
        """Vertices (v,) that were put on a facet where it was cut, and so may stand off the true surface.

        A boolean cuts the facets of the blank and of its tools by each other. Every other vertex was computed on the
        surface.
        """
        if self.method in ("direct", ENDS_CUT):
            return np.zeros(len(self.mesh.vertices), dtype=bool)
        rest = tuple(name for name in self.mesh.groups if name not in TOOL)
        return np.asarray(self.mesh.group_vertices(*TOOL) & self.mesh.group_vertices(*rest))

    def to_trimesh(self) -> Any:
        """The mesh as a trimesh.Trimesh (imports trimesh)."""
        return self.mesh.to_trimesh()

    def to_pyvista(self) -> Any:
        """The mesh as a pyvista.PolyData (imports pyvista)."""
        return self.mesh.to_pyvista()


class Part(Protocol):
    """A body of the cam: a recipe that makes a Solid within a tolerance (mm)."""

    @property
    def name(self) -> str:
        """The body's name in exports and reports."""

    def solid(self, tolerance: float) -> Solid:
        """Make the body. Raises DesignError, NotConverged or GeometryEngineError with the reason."""

    def rough(self, tolerance: float) -> Solid:
        """About the same body, as quick as can be: to look for crossings."""


class QuickPart:
    """A recipe so quick that a rough body is made like a fine one."""

    def rough(self: Part, tolerance: float) -> Solid:
        """The body within the tolerance, mm."""
        return self.solid(tolerance)
