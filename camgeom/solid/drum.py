"""Flanks and blank become a watertight solid whose faces keep their names.

A closed groove (or rib) round a cylinder is meshed directly as one structured grid, with no boolean; everything else is
the blank minus the groove bodies by one exact-topology boolean. Either way the chord error is guaranteed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from camgeom.errors import DesignError
from camgeom.maths import Floats
from camgeom.maths.mesh import Mesh
from camgeom.maths.sampling import Grid, sample
from camgeom.solid.blank import Blank, Builder, close_ends
from camgeom.solid.engine import subtract
from camgeom.track import Track
from camgeom.track.section import Column, GrooveSection, Level, cylinder_level

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

    def fits(self) -> bool:
        """True where the groove stays inside both end faces, so that the body is one closed grid."""
        phi = np.linspace(*self.track.span, 721)
        column, section = Column(self.track, phi), self.section()
        z = [column.wall(side, column.reach(side, section.level, self.radius))[2] for side in (1.0, -1.0)]
        return self.track.closed and float(np.min(z)) > 0.0 and float(np.max(z)) < self.length

    def grid(self, tolerance: float) -> tuple[Grid, tuple[str, ...]]:
        """The structured grid from the lower end ring to the upper one, and the name of each band."""
        section = self.section()

        def rows(phi: Floats, counts: tuple[int, ...]) -> Floats:
            groove = section.rows(Column(self.track, phi), counts[1:-1])
            low = self._land(groove[:, :, 0], 0.0, counts[0])
            high = self._land(groove[:, :, -1], self.length, counts[-1])[:, :, ::-1]
            return np.concatenate([low, groove, high], axis=2)

        most = (1, *section.max_counts, 1)
        grid = sample(rows, self.track.knots(), tolerance, most)
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
        self._check(grid.points)
        return closed_body(self.name, grid, names, self.track.sense > 0, (0.0, self.length), self.blank, tolerance)

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
    faces = np.empty((*p00.shape, 2, 3), dtype=p00.dtype)
    corners = (p00, p10, np.where(rising, p11, p01)), (np.where(rising, p00, p10), p11, p01)
    for k, corner in enumerate(corners):
        for j, index in enumerate(corner[::-1] if inward else corner):
            faces[..., k, j] = index
    return faces


@dataclass(frozen=True, eq=False)
class RibbedCylinder:
    """A drum of `base` radius with a rib of outer `radius` between a lower and an upper roller."""

    name: str
    lower: Track
    upper: Track
    blank: Blank
    base: float
    radius: float
    length: float

    def solid(self, tolerance: float) -> Solid:
        """Mesh directly. Raises DesignError where the rib leaves the drum or its edges turn back or cross."""
        low_side, high_side = self._facing(self.lower, 1.0), self._facing(self.upper, -1.0)
        most = (1, 4000, 4000, 4000, 1)
        names = ("base", "flank", "land", "flank", "base")

        def rows(phi: Floats, counts: tuple[int, ...]) -> Floats:
            low, high = Column(self.lower, phi), Column(self.upper, phi)
            up = self._wall(low, low_side, counts[1])
            down = self._wall(high, high_side, counts[3])[:, :, ::-1]
            top = on_cylinder(up[:, :, -1], down[:, :, 0], self.radius, counts[2])
            start = GroovedCylinder._land(up[:, :, 0], 0.0, counts[0])
            stop = GroovedCylinder._land(down[:, :, -1], self.length, counts[4])[:, :, ::-1]
            return np.concatenate([start, up, top, down, stop], axis=2)

        grid = sample(rows, self.lower.knots(), tolerance, most)
        ends = np.cumsum(grid.counts)
        self._check(grid.points[:, :, [1, ends[0] + grid.counts[1], ends[2], ends[3]]])
        return closed_body(self.name, grid, names, self.lower.sense > 0, (0.0, self.length), self.blank, tolerance)

    def _wall(self, column: Column, side: float, count: int) -> Floats:
        foot = column.reach(side, cylinder_level(self.base), self.base)
        top = column.reach(side, cylinder_level(self.radius), self.radius)
        return column.wall(side, foot + (top - foot) * np.arange(count + 1) / count)

    @staticmethod
    def _facing(track: Track, sign: float) -> float:
        """The side (+1 or -1) of the roller's flank whose normal points along sign * Z."""
        column = Column(track, np.zeros(1))
        t = np.array([track.meridian.parameter(track.contact[1])])
        return 1.0 if sign * (column.wall(1.0, t)[2, 0, 0] - column.wall(-1.0, t)[2, 0, 0]) > 0.0 else -1.0

    def _check(self, edges: Floats) -> None:
        z = edges[2]
        if z.min() <= 0.0 or z.max() >= self.length:
            raise DesignError("the rib runs out of an end face; lengthen the drum or move `start`")
        for k in range(edges.shape[2]):
            angle = np.unwrap(np.arctan2(edges[1, :, k], edges[0, :, k]))
            if not (np.all(np.diff(angle) < 0.0) or np.all(np.diff(angle) > 0.0)):
                raise DesignError("the rib's edge turns back on itself: the flank is undercut")


def on_cylinder(start: Floats, stop: Floats, radius: float, count: int) -> Floats:
    """Rows (3, n, count - 1) strictly between two edges on a cylinder, straight in angle and z."""
    share = np.arange(1, count) / count
    a0 = np.arctan2(start[1], start[0])
    sweep = (np.arctan2(stop[1], stop[0]) - a0 + np.pi) % (2.0 * np.pi) - np.pi
    angle = a0[:, None] + sweep[:, None] * share
    z = start[2][:, None] + (stop[2] - start[2])[:, None] * share
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), z])


def closed_body(
    name: str,
    grid: Grid,
    names: tuple[str, ...],
    inward: bool,
    ends: tuple[float, float],
    blank: Blank,
    tolerance: float,
) -> Solid:
    """Close a grid that runs once round the axis, from the lower end ring to the upper one, into a solid."""
    builder = Builder()
    index = stitched(builder, grid.points[:, :-1], grid.counts, names, tolerance)
    faces = wrapped_faces(index, grid.rising, inward)
    for b, band in enumerate(names):
        builder.faces(faces[b_slice(grid.counts, b)].reshape(-1, 3), band)
    bottom, top = index[:, 0], index[:, -1]
    if inward:
        bottom, top = bottom[::-1], top[::-1]
    close_ends(builder, bottom, top, ends[0], ends[1], blank.bore, tolerance)
    return Solid(name, builder.mesh(), grid.chord_error, "direct", 0 if blank.bore is None else 1)


@dataclass(frozen=True, eq=False)
class CutBlank:
    """A blank minus the groove bodies of its tracks, by one boolean.

    outside  level surface beyond the blank at which the groove bodies end, and a guess of delta there
    ridge    delta of the groove body's back, safely outside the blank
    """

    name: str
    tracks: tuple[Track, ...]
    blank: Blank
    outside: Level
    guess: float
    ridge: float
    expected_genus: int

    def tool(self, track: Track, tolerance: float) -> tuple[Mesh, float]:
        """One groove body as a closed mesh (a ring, or a tube with two end caps), and its chord error, mm."""
        section = GrooveSection(track, self.outside, self.guess, 1.0)

        def rows(phi: Floats, counts: tuple[int, ...]) -> Floats:
            return section.rows(Column(track, phi), counts)

        grid = sample(rows, track.knots(), tolerance, section.max_counts)
        return groove_body(grid, section, self.ridge, tolerance), grid.chord_error

    def solid(self, tolerance: float) -> Solid:
        """One boolean. Raises GeometryEngineError where the engine refuses."""
        tools = [self.tool(track, tolerance) for track in self.tracks]
        mesh = subtract(self.blank.mesh(tolerance), [tool for tool, _ in tools])
        error = max([tolerance * BLANK_SHARE, *(e for _, e in tools)])
        return Solid(self.name, mesh, error, "boolean", self.expected_genus)


class CrossSection(Protocol):
    """What a groove body is made of: its track and the names of its bands."""

    @property
    def track(self) -> Track:
        """The track of the groove."""

    @property
    def names(self) -> tuple[str, ...]:
        """Face-group name of each band across the groove."""


BLANK_SHARE = 1.0
"""the blank's own chord error as a share of the tolerance (its mesh is made within it)"""


def groove_body(grid: Grid, section: CrossSection, ridge: float, tolerance: float) -> Mesh:
    """Close a groove grid with a back over its ridge (the roller axis at delta = ridge) and, where open, two caps."""
    track = section.track
    pose = track.pose(grid.phi, 0)
    back = pose.a[0] + ridge * pose.u[0]
    points = np.concatenate([grid.points, back[:, :, None]], axis=2)
    closed = track.closed
    builder = Builder()
    index = stitched(builder, points[:, :-1] if closed else points, grid.counts, section.names, tolerance)
    ring = np.concatenate([index, index[:, :1]], axis=1)
    rising = np.concatenate([grid.rising, np.ones((len(grid.rising), 2), dtype=bool)], axis=1)
    if closed:
        faces = wrapped_faces(ring, rising, inward=False)
    else:
        faces = cell_faces(ring[:-1, :-1], ring[1:, :-1], ring[1:, 1:], ring[:-1, 1:], rising, inward=False)
    for b, name in enumerate(section.names):
        builder.faces(faces[b_slice(grid.counts, b)].reshape(-1, 3), name)
    builder.faces(faces[:, sum(grid.counts) :].reshape(-1, 3), "back")
    if not closed:
        cap = _cap(ring[0, :-2], ring[0, -2])
        builder.faces(cap, "cap")
        builder.faces(_cap(ring[-1, :-2], ring[-1, -2])[:, ::-1], "cap")
    mesh = builder.mesh()
    if mesh.volume < 0.0:
        return Mesh(mesh.vertices, np.ascontiguousarray(mesh.faces[:, ::-1]), mesh.groups, mesh.group)
    return mesh


def _cap(rows: Index, ridge: np.int64) -> Index:
    """Triangles closing the end of a groove body: rungs between the two flanks, and the ridge."""
    half = len(rows) // 2
    left, right = rows[: half + 1], rows[::-1][: len(rows) - half]
    triangles = [[ridge, rows[0], rows[-1]]]
    for j in range(max(len(left), len(right)) - 1):
        l0, l1 = left[min(j, len(left) - 1)], left[min(j + 1, len(left) - 1)]
        r0, r1 = right[min(j, len(right) - 1)], right[min(j + 1, len(right) - 1)]
        triangles += [[l0, l1, r0], [l1, r1, r0]]
    return np.array(triangles, dtype=np.int64)
