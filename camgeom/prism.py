"""Solids of planar cams: an outline with holes between two planes, meshed directly with a guaranteed chord error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from camgeom.blank import Bore, Builder
from camgeom.errors import DesignError
from camgeom.maths.strips import Grid, sample
from camgeom.outline import Outline
from camgeom.solid import Solid

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Loop:
    """One closed boundary of a prism: an outline and the name of the faces it makes."""

    outline: Outline
    name: str


@dataclass(frozen=True, eq=False)
class Step:
    """A flat plateau of a prism: between heights `low` and `high` it is bounded by an outer loop and holes."""

    low: float
    high: float
    outer: Loop
    holes: tuple[Loop, ...] = ()


@dataclass(frozen=True, eq=False)
class Prism:
    """A planar cam: a disc between z0 and z1 with an outer outline, further holes, and a bore with keyway."""

    name: str
    outer: Loop
    z0: float
    z1: float
    holes: tuple[Loop, ...] = ()
    bore: Bore | None = None

    def solid(self, tolerance: float) -> Solid:
        """Mesh within the tolerance. Raises DesignError where the outline crosses itself or a hole."""
        builder = Builder()
        loops: list[tuple[Floats, Index, Index]] = []
        error = 0.0
        for loop, inside in ((self.outer, False), *((hole, True) for hole in self.holes)):
            grid = outline_grid(loop.outline, tolerance)
            error = max(error, grid.chord_error)
            plane = grid.points[:2, :-1, 0].T
            loops.append(self._side(builder, plane, [loop.name] * len(plane), inside))
        if self.bore is not None:
            outline, names = self.bore.outline(tolerance)
            error = max(error, 0.0)
            loops.append(self._side(builder, outline, names, True))
        self._cap(builder, loops)
        genus = len(loops) - 1
        return Solid(self.name, builder.mesh(), max(error, tolerance * 1e-9), "direct", genus)

    def _side(
        self, builder: Builder, plane: Floats, names: list[str], inside: bool
    ) -> tuple[Floats, Index, Index]:
        """Add the wall over a closed polygon; returns it counter-clockwise (holes clockwise) with its two rings."""
        area = 0.5 * float(np.sum(plane[:, 0] * np.roll(plane[:, 1], -1) - np.roll(plane[:, 0], -1) * plane[:, 1]))
        if (area < 0.0) != inside:
            plane, names = plane[::-1].copy(), [*names[::-1][1:], names[-1]]
        low = builder.add(np.column_stack([plane, np.full(len(plane), self.z0)]))
        high = builder.add(np.column_stack([plane, np.full(len(plane), self.z1)]))
        low2, high2 = np.roll(low, -1), np.roll(high, -1)
        for name in dict.fromkeys(names):
            mask = np.array([n == name for n in names])
            builder.faces(np.stack([low, low2, high2], axis=1)[mask], name)
            builder.faces(np.stack([low, high2, high], axis=1)[mask], name)
        return plane, low, high

    @staticmethod
    def _cap(builder: Builder, loops: list[tuple[Floats, Index, Index]]) -> None:
        import manifold3d

        polygons = [np.ascontiguousarray(plane) for plane, _, _ in loops]
        triangles = np.asarray(manifold3d.triangulate(polygons)).astype(np.int64)
        wanted = sum(len(p) for p in polygons) + 2 * (len(polygons) - 1) - 2
        if len(triangles) != wanted:
            raise DesignError("the outline crosses itself or a hole: check undercut, bore and hub against the profile")
        low = np.concatenate([one for _, one, _ in loops])
        high = np.concatenate([one for _, _, one in loops])
        builder.faces(high[triangles], "end")
        builder.faces(low[triangles[:, ::-1]], "end")


def outline_grid(outline: Outline, tolerance: float) -> Grid:
    """The outline sampled so that every chord is within tolerance: a grid of one band over a unit height."""

    def rows(phi: Floats, counts: tuple[int, ...]) -> Floats:
        points = outline.curve(phi).points
        height = np.linspace(0.0, 1.0, counts[0] + 1)
        n = points.shape[1]
        flat = np.broadcast_to(points[:, :, None], (2, n, len(height)))
        return np.concatenate([flat, np.broadcast_to(height, (1, n, len(height)))])

    return sample(rows, outline.knots(), 1, tolerance, (1,))
