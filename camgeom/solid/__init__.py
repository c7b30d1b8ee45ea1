"""What the cam is made of: blanks, recipes of bodies, and closed meshes with a stated error."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property

if TYPE_CHECKING:
    from camgeom.maths.mesh import Mesh

Mask = npt.NDArray[np.bool_]
TOOL = ("flank", "edge", "root", "floor", "back", "cap")
"""groups of the faces that tools leave"""
TOUCHED = "flank"
"""group of the faces that followers touch; all others are free"""
ENDS_CUT = "direct, ends cut"
UNION = "union of rollers"
"""how bodies are made, beside the direct mesh and the boolean"""


@immutable
class Solid:
    """A finished body: its mesh, the guaranteed chord error (mm), how it was made, and the genus it should have.

    free_error  mm, guaranteed chord error of the faces that nothing touches, where these have a tolerance of their own:
                `chord_error` is then that of the others. None: `chord_error` holds for all faces.
    """

    name: str
    mesh: Mesh
    chord_error: float
    method: str
    expected_genus: int
    free_error: float | None = None

    @property
    def largest_error(self) -> float:
        """The guaranteed chord error of all faces, mm."""
        return max(self.chord_error, self.free_error or 0.0)

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

    @cached_property
    def cut_errors(self) -> Floats:
        """By how much each vertex (v,) may stand off the true surface, mm: 0, but for those where facets were cut."""
        touched = self.mesh.group_vertices(TOUCHED)
        return np.where(self.cut_vertices, np.where(touched, self.chord_error, self.largest_error), 0.0)

    def to_trimesh(self) -> Any:
        """The mesh as a trimesh.Trimesh (imports trimesh)."""
        return self.mesh.to_trimesh()

    def to_pyvista(self) -> Any:
        """The mesh as a pyvista.PolyData (imports pyvista)."""
        return self.mesh.to_pyvista()


class Part(Protocol):
    """A body of the cam: a recipe that makes a Solid within a tolerance (mm).

    Faces that no follower touches may have a coarser one, `free` (mm, at least `tolerance`; None: the same).
    """

    @property
    def name(self) -> str:
        """The body's name in exports and reports."""

    def solid(self, tolerance: float, free: float | None = None) -> Solid:
        """Make the body. Raises DesignError, NotConverged or GeometryEngineError with the reason."""

    def rough(self, tolerance: float) -> Solid:
        """About the same body, as quick as can be: to look for crossings."""


class QuickPart:
    """A recipe so quick that a rough body is made like a fine one."""

    def rough(self: Part, tolerance: float) -> Solid:
        """The body within the tolerance, mm."""
        return self.solid(tolerance)


def eased(names: Sequence[str], tolerance: float, free: float | None) -> tuple[float, ...]:
    """How many times the tolerance bands of these names may be off."""
    return tuple(1.0 if free is None or name == TOUCHED else free / tolerance for name in names)


def stated(errors: Iterable[tuple[str, float]], free: float | None) -> tuple[float, float | None]:
    """`Solid.chord_error` and `Solid.free_error` of the chord errors of named faces, mm."""
    every = tuple(errors)
    if free is None:
        return max(error for _, error in every), None
    touched = max((error for name, error in every if name == TOUCHED), default=0.0)
    return touched, max((error for name, error in every if name != TOUCHED), default=0.0)
