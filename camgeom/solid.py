"""Flanks and blank become a watertight solid whose faces keep their names.

A closed groove (or rib) round a cylinder is meshed directly as one structured grid, with no boolean; everything else is
the blank minus the groove bodies by one exact-topology boolean. Either way the chord error is guaranteed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from camgeom.blank import Blank, Builder, close_ends
from camgeom.errors import DesignError
from camgeom.groove import Column, GrooveSection, cylinder_level
from camgeom.maths.mesh import Mesh
from camgeom.maths.strips import Grid, sample
from camgeom.track import Track

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Solid:
    """A finished body: its mesh, the guaranteed chord error (mm), how it was made, and the genus it should have."""

    name: str
    mesh: Mesh
    chord_error: float
    method: str
    expected_genus: int

    @property
    def sound(self) -> bool:
        """Watertight, of positive volume, one shell, and of the expected genus."""
        m = self.mesh
        return m.watertight and m.volume > 0.0 and m.components == 1 and m.genus == self.expected_genus


@dataclass(frozen=True, eq=False)
class GroovedCylinder:
    """A cylinder 0 <= z <= length with one closed groove round it."""

    name: str
    track: Track
    blank: Blank
    radius: float
    length: float

    def section(self) -> GrooveSection:
        """The groove's cross-section, flank with the smaller z first."""
        column = Column(self.track, np.zeros(1))
        t = np.array([self.track.meridian.parameter(self.radius)])
        first = 1.0 if column.wall(1.0, t)[2, 0, 0] < column.wall(-1.0, t)[2, 0, 0] else -1.0
        return GrooveSection(self.track, cylinder_level(self.radius), self.radius, first)

    def grid(self, tolerance: float) -> tuple[Grid, tuple[str, ...]]:
        """The structured grid from the lower end ring to the upper one, and the name of each band."""
        section = self.section()

        def rows(phi: Floats, counts: tuple[int, ...]) -> Floats:
            groove = section.rows(Column(self.track, phi), counts[1:-1])
            low = self._land(groove[:, :, 0], 0.0, counts[0])
            high = self._land(groove[:, :, -1], self.length, counts[-1])[:, :, ::-1]
            return np.concatenate([low, groove, high], axis=2)

        most = (1, *section.max_counts, 1)
        grid = sample(rows, self.track.knots(), len(most), tolerance, most)
        return grid, ("land", *section.names, "land")

    @staticmethod
    def _land(edge: Floats, z: float, count: int) -> Floats:
        """Rows (3, n, count) straight along Z from the end ring at z towards the groove's edge (edge excluded)."""
        share = np.arange(count) / count
        rows = np.repeat(edge[:, :, None], count, axis=2)
        rows[2] = z + (edge[2][:, None] - z) * share
        return np.asarray(rows)

    def solid(self, tolerance: float) -> Solid:
        """Mesh directly. Raises DesignError where the topology is not that of a closed groove inside the cylinder."""
        grid, names = self.grid(tolerance)
        builder = Builder()
        index = stitched(builder, grid.points[:, :-1], grid.counts, names, tolerance)
        self._check(grid.points)
        faces = wrapped_faces(index, grid.rising, inward=self.track.sense > 0)
        for b, name in enumerate(names):
            builder.faces(faces[b_slice(grid.counts, b)].reshape(-1, 3), name)
        bottom, top = index[:, 0], index[:, -1]
        if self.track.sense > 0:
            bottom, top = bottom[::-1], top[::-1]
        close_ends(builder, bottom, top, 0.0, self.length, self.blank.bore, tolerance)
        return Solid(self.name, builder.mesh(), grid.chord_error, "direct", 0 if self.blank.bore is None else 1)

    def _check(self, points: Floats) -> None:
        low, high = points[2, :, 1], points[2, :, -2]
        if low.min() <= 0.0 or high.max() >= self.length:
            raise DesignError("the groove runs out of an end face, so the body is not one closed grid")
        for edge in (points[:, :, 1], points[:, :, -2]):
            angle = np.unwrap(np.arctan2(edge[1], edge[0]))
            if not (np.all(np.diff(angle) < 0.0) or np.all(np.diff(angle) > 0.0)):
                raise DesignError("the groove's edge turns back on itself: the flank is undercut")


def b_slice(counts: tuple[int, ...], band: int) -> tuple[slice, slice]:
    """Selects the cells of one band in an array (n, k, ...)."""
    start = sum(counts[:band])
    return slice(None), slice(start, start + counts[band])


def stitched(
    builder: Builder, points: Floats, counts: tuple[int, ...], names: tuple[str, ...], tolerance: float
) -> Index:
    """Add the grid's points (3, n, k); where an edge sweep has shrunk to nothing (dwells) its rows share one vertex."""
    n, k = points.shape[1:]
    index = builder.add(points.reshape(3, -1).T.copy()).reshape(n, k)
    ends = np.concatenate([[0], np.cumsum(counts)])
    for band, name in enumerate(names):
        if name != "edge":
            continue
        low, high = ends[band], ends[band + 1]
        span = points[:, :, high] - points[:, :, low]
        shrunk = (span * span).sum(axis=0) < (1e-3 * tolerance) ** 2
        foot = low if names[band - 1] == "flank" else high
        index[shrunk, low : high + 1] = index[shrunk, foot : foot + 1]
    return index


def wrapped_faces(index: Index, rising: npt.NDArray[np.bool_], inward: bool) -> Index:
    """Two triangles a cell of a grid closed in its first direction, (n, k, 2, 3)."""
    nxt = np.roll(index, -1, axis=0)
    return cell_faces(index[:, :-1], nxt[:, :-1], nxt[:, 1:], index[:, 1:], rising, inward)


def cell_faces(
    p00: Index, p10: Index, p11: Index, p01: Index, rising: npt.NDArray[np.bool_], inward: bool
) -> Index:
    """Triangles (..., 2, 3) of cells given by their corners, along the chosen diagonal."""
    first = np.stack([p00, p10, np.where(rising, p11, p01)], axis=-1)
    second = np.stack([np.where(rising, p00, p10), p11, p01], axis=-1)
    faces = np.stack([first, second], axis=-2)
    return np.asarray(faces[..., ::-1] if inward else faces)
