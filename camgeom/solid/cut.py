"""Indexing cams cut from a blank: groove bodies between two flanks and a floor that clears every roller, one boolean.

The floor carries nothing. What the flat end of a tool would leave is not used: where the turret swings fast the rim of
the end cuts deeper than its face, on surfaces that fold. The flanks go down to a surface of revolution instead (a
globoid about the turret axis, a cylinder about the cam axis), far enough that the floor, straight from foot to foot,
stays out of reach of every rim.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camgeom.errors import NotConverged
from camgeom.maths import Floats
from camgeom.maths.mesh import Mesh
from camgeom.maths.sampling import sample
from camgeom.solid.blank import Blank
from camgeom.solid.drum import Solid, groove_body
from camgeom.solid.engine import subtract
from camgeom.solid.lands import CylinderLand, GloboidLand, land_of
from camgeom.solid.lands import GloboidLevel as GloboidLevel
from camgeom.solid.turret_lands import NotOneSurface
from camgeom.solid.turret_stitch import groove_solid
from camgeom.track import Arc, Track
from camgeom.track.section import Column, GrooveSection, Level


@dataclass(frozen=True, eq=False)
class FlooredSection:
    """Rows across a groove: down one flank from `top` to `floor`, straight across, up the other flank.

    guesses  delta near the top and near the floor
    """

    track: Track
    top: Level
    floor: Level
    guesses: tuple[float, float]
    names: tuple[str, ...] = ("flank", "floor", "flank")
    max_counts: tuple[int, ...] = (4000, 4000, 4000)

    def rows(self, column: Column, counts: tuple[int, ...]) -> Floats:
        """Points (3, n, 1 + sum(counts))."""
        down = self._wall(column, 1.0, counts[0])
        up = self._wall(column, -1.0, counts[2])[:, :, ::-1]
        foot, share = down[:, :, -1:], np.arange(1, counts[1]) / counts[1]
        return np.concatenate([down, foot + (up[:, :, :1] - foot) * share, up], axis=2)

    def _wall(self, column: Column, side: float, count: int) -> Floats:
        high = column.reach(side, self.top, self.guesses[0])
        low = column.reach(side, self.floor, self.guesses[1])
        return column.wall(side, high + (low - high) * np.arange(count + 1) / count)


@dataclass(frozen=True, eq=False)
class IndexingCut:
    """A blank minus the groove bodies of a turret's rollers, by one boolean.

    top, floor   where the groove bodies end: outside the blank, and below the rollers
    guesses      delta near them
    ridge        delta of the groove body's back, safely outside the blank
    """

    name: str
    tracks: tuple[Track, ...]
    blank: Blank
    top: Level
    floor: Level
    guesses: tuple[float, float]
    ridge: float
    expected_genus: int

    def section(self, track: Track, top: Level | None = None) -> FlooredSection | GrooveSection:
        """Cross-section of a groove up to a level surface (default: `top`); a ball's own bottom is its floor."""
        meridian, level = track.meridian, top or self.top
        if isinstance(meridian, Arc) and meridian.arc == meridian.radius:
            return GrooveSection(track, level, self.guesses[0], 1.0)
        return FlooredSection(track, level, self.floor, self.guesses)

    def tool(self, track: Track, tolerance: float) -> tuple[Mesh, float]:
        """One groove body as a closed mesh (a ring, or a tube with two end caps), and its chord error, mm."""
        section = self.section(track)

        def rows(phi: Floats, counts: tuple[int, ...]) -> Floats:
            return section.rows(Column(track, phi), counts)

        grid = sample(rows, track.knots(), tolerance, section.max_counts)
        return groove_body(grid, section, self.ridge, tolerance), grid.chord_error

    def solid(self, tolerance: float) -> Solid:
        """Meshed directly where the grooves stay apart, else by one boolean (raises GeometryEngineError by name)."""
        try:
            return self.direct(tolerance)
        except (NotOneSurface, NotConverged):
            return self.cut(tolerance)

    def direct(self, tolerance: float) -> Solid:
        """Grooves, lands and ends as one surface. Raises NotOneSurface where they are not."""
        sections = self.sections(self.land)
        return groove_solid(self.name, self.blank, self._edge, sections, self.expected_genus, tolerance)

    @property
    def _edge(self) -> int:
        """Number of the blank's outline edge that the grooves cut."""
        return (self.blank.names or ("land",)).index("land")

    @property
    def land(self) -> GloboidLand | CylinderLand:
        """The blank's outside between the grooves. Raises NotOneSurface where it is another surface."""
        land = land_of(self.blank, self._edge)
        if land is None:
            raise NotOneSurface("the blank's outside is neither a cylinder nor a globoid")
        return land

    def sections(self, land: GloboidLand | CylinderLand) -> tuple[FlooredSection | GrooveSection, ...]:
        """Cross-sections of all grooves up to the land."""
        return tuple(self.section(track, land.level) for track in self.tracks)

    def cut(self, tolerance: float) -> Solid:
        """Blank minus groove bodies, one boolean. Raises GeometryEngineError where the engine refuses."""
        tools = [self.tool(track, tolerance) for track in self.tracks]
        mesh = subtract(self.blank.mesh(tolerance), [tool for tool, _ in tools])
        error = max([self.blank.share * tolerance, *(e for _, e in tools)])
        return Solid(self.name, mesh, error, "boolean", self.expected_genus)
