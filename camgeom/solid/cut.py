"""Cams cut from a blank by one exact-topology boolean: minus groove bodies, or minus many positions of a roller.

Groove bodies of a drum have the floor that the roller's flat end leaves. An indexing cam's floor carries nothing, and
what the flat end of a tool would leave is not used: where the turret swings fast the rim of the end cuts deeper than
its face, on surfaces that fold. The flanks go down to a surface of revolution instead (a globoid about the turret axis,
a cylinder about the cam axis), far enough that the floor, straight from foot to foot, stays out of reach of every rim.

An undercut flank crosses itself and bounds no body. What the tool leaves is the blank without the union of its
positions. Between two positions a distance d apart a smooth wall stands proud by about d² / (8 r), and more beside a
cusp: so the error stated is measured, the deepest vertex inside the true sweep and the facets' own sag.
"""

from __future__ import annotations

from math import ceil

import numpy as np

from camgeom.errors import DesignError, NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.mesh import Mesh
from camgeom.maths.sampling import Grid, sample
from camgeom.solid import TOUCHED, UNION, QuickPart, Solid, eased, stated
from camgeom.solid.blank import Blank
from camgeom.solid.builder import Builder, Index, add_grid, band_cells, cell_faces, wrapped_faces
from camgeom.solid.engine import subtract, unite
from camgeom.solid.lands import CylinderLand, GloboidLand, NotOneSurface, land_of
from camgeom.solid.stitch import Mesher, gridded, groove_solid
from camgeom.track import Arc, Straight, Track
from camgeom.track.clearance import least_clearance
from camgeom.track.column import Column, Level
from camgeom.track.section import CrossSection, FlooredSection, GrooveSection, RootedSection

MOST_ROLLERS = 360
FACETS = 0.25
"""sag of a roller's facets over what stands between two of its positions, where those are fewer than asked"""


@immutable
class CutBlank(QuickPart):
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

    def tool(self, track: Track, tolerance: float, free: float | None = None) -> tuple[Mesh, float, float | None]:
        """One groove body and its chord errors, mm; see `groove_tool`."""
        return groove_tool(GrooveSection(track, self.outside, self.guess, 1.0), self.ridge, tolerance, free)

    def solid(self, tolerance: float, free: float | None = None) -> Solid:
        """One boolean. Raises GeometryEngineError where the engine refuses."""
        tools = [self.tool(track, tolerance, free) for track in self.tracks]
        return _subtracted(self.name, self.blank, tools, tolerance, free, 1.0, self.expected_genus)


@immutable
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

    def section(self, track: Track, top: Level | None = None) -> FlooredSection | GrooveSection | RootedSection:
        """Cross-section of a groove up to a level surface (default: `top`); a ball's own bottom is its floor."""
        meridian, level = track.meridian, top or self.top
        if isinstance(meridian, Arc) and meridian.arc == meridian.radius:
            return GrooveSection(track, level, self.guesses[0], 1.0)
        if track.root:
            return RootedSection(track, level, self.guesses[0])
        return FlooredSection(track, level, self.floor, self.guesses)

    def tool(self, track: Track, tolerance: float, free: float | None = None) -> tuple[Mesh, float, float | None]:
        """One groove body and its chord errors, mm; see `groove_tool`."""
        return groove_tool(self.section(track), self.ridge, tolerance, free)

    def solid(self, tolerance: float, free: float | None = None) -> Solid:
        """Meshed directly where the grooves stay apart, else by one boolean (raises GeometryEngineError by name)."""
        try:
            return self.direct(tolerance, free)
        except (NotOneSurface, NotConverged):
            return self.cut(tolerance, free)

    def rough(self, tolerance: float) -> Solid:
        """The same with facets cut as they are at the cam's ends, where no error is measured: to look for crossings."""
        try:
            return self.direct(tolerance, straight=True)
        except (NotOneSurface, NotConverged):
            return self.cut(tolerance)

    def direct(
        self, tolerance: float, free: float | None = None, straight: bool = False, mesher: Mesher = gridded
    ) -> Solid:
        """Grooves, lands and ends as one surface. Raises NotOneSurface where they are not."""
        sections, genus = self.sections(self.land), self.expected_genus
        return groove_solid(self.name, self.blank, self._edge, sections, genus, tolerance, straight, free, mesher)

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

    def sections(self, land: GloboidLand | CylinderLand) -> tuple[CrossSection, ...]:
        """Cross-sections of all grooves up to the land."""
        return tuple(self.section(track, land.level) for track in self.tracks)

    def cut(self, tolerance: float, free: float | None = None) -> Solid:
        """Blank minus groove bodies, one boolean. Raises GeometryEngineError where the engine refuses."""
        tools = [self.tool(track, tolerance, free) for track in self.tracks]
        return _subtracted(self.name, self.blank, tools, tolerance, free, self.blank.share, self.expected_genus)


@immutable
class RollerUnion(QuickPart):
    """A blank minus the positions of straight rollers that reach from their tip out to `beyond`, mm."""

    name: str
    tracks: tuple[Track, ...]
    blank: Blank
    beyond: float

    def solid(self, tolerance: float, free: float | None = None) -> Solid:
        """At most MOST_ROLLERS positions a track; `chord_error` says what that leaves. Raises GeometryEngineError.

        The blank has the tolerance `free`, and what rollers leave the one that their number gives.
        """
        if any(track.root for track in self.tracks):
            raise DesignError("the body of an undercut drum is made of straight rollers, with a sharp root: leave out "
                              "the corner radius, or mend the undercut")  # fmt: skip
        made = [self._positions(track, tolerance) for track in self.tracks]
        mesh = subtract(self.blank.mesh(free or tolerance), [unite(bodies) for bodies, _ in made])
        deepest = min(least_clearance(track, mesh.vertices).value for track in self.tracks)
        error = max(sag for _, sag in made) + max(0.0, -deepest)
        return Solid(self.name, mesh, error, UNION, mesh.genus, free and max(error, free))

    def _positions(self, track: Track, tolerance: float) -> tuple[list[Mesh], float]:
        """Roller bodies at equal steps of their largest travel, and the sag of their facets, mm: the tolerance, or
        a share of what stands between two positions where that is more."""
        if not isinstance(track.meridian, Straight):
            raise DesignError("an undercut body is made of straight rollers (cylinder or cone) only")
        fine = np.linspace(*track.span, 7201)
        pose = track.pose(fine, 0)
        ends = [pose.a[0] + d * pose.u[0] for d in (track.tip, self.beyond)]
        step = np.max([np.sqrt((np.diff(x, axis=1) ** 2).sum(axis=0)) for x in ends], axis=0)
        path = np.concatenate([[0.0], np.cumsum(step)])
        radius = track.meridian.radius
        count = min(MOST_ROLLERS, max(24, ceil(path[-1] / np.sqrt(8.0 * radius * tolerance))))
        phi = np.interp(np.linspace(0.0, path[-1], count + 1), path, fine)[: -1 if track.closed else None]
        sag = max(tolerance, FACETS * (path[-1] / count) ** 2 / (8.0 * radius))
        return [self._body(track, float(p), sag) for p in phi], sag

    def _body(self, track: Track, phi: float, sag: float) -> Mesh:
        """The roller standing at one cam angle, from its tip to `beyond`."""
        low, high = sorted((track.tip, self.beyond))
        r = track.meridian.jet(np.array([low, high]))[3]
        upright = Blank(((float(r[0]), low), (float(r[1]), high)), names=("flank",)).mesh(sag)
        pose = track.pose(np.array([phi]), 0)
        u = pose.u[0][:, 0]
        side = np.cross(u, [0.0, 0.0, 1.0] if abs(u[2]) < 0.9 else [1.0, 0.0, 0.0])
        side /= np.linalg.norm(side)
        frame = np.stack([side, np.cross(u, side), u])
        return Mesh(upright.vertices @ frame + pose.a[0][:, 0], upright.faces, upright.groups, upright.group)


def groove_tool(
    section: CrossSection, ridge: float, tolerance: float, free: float | None = None
) -> tuple[Mesh, float, float | None]:
    """A groove body as a closed mesh (a ring, or a tube with two end caps), and its chord errors, mm, as `Grid` has
    them; free: the tolerance of all but its flanks.

    ridge  delta of the body's back, safely outside the blank
    """

    def rows(phi: Floats, counts: tuple[int, ...]) -> Floats:
        return section.rows(Column(section.track, phi), counts)

    ease = eased(section.names, tolerance, free)
    grid = sample(rows, section.track.knots(), tolerance, section.max_counts, ease)
    return groove_body(grid, section, ridge, tolerance), grid.chord_error, grid.free_error


def _subtracted(
    name: str,
    blank: Blank,
    tools: list[tuple[Mesh, float, float | None]],
    tolerance: float,
    free: float | None,
    share: float,
    genus: int,
) -> Solid:
    """The blank, whose mesh is off by no more than a share of its tolerance, minus tools with the errors given."""
    mesh = subtract(blank.mesh(free or tolerance), [tool for tool, _, _ in tools])
    errors = [("land", share * (free or tolerance))]
    for _, touched, other in tools:
        errors += [(TOUCHED, touched), ("floor", other or 0.0)]
    error, free_error = stated(errors, free)
    return Solid(name, mesh, error, "boolean", genus, free_error)


def groove_body(grid: Grid, section: CrossSection, ridge: float, tolerance: float) -> Mesh:
    """Close a groove grid with a back over its ridge (the roller axis at delta = ridge) and, where open, two caps."""
    track = section.track
    pose = track.pose(grid.phi, 0)
    back = pose.a[0] + ridge * pose.u[0]
    points = np.concatenate([grid.points, back[:, :, None]], axis=2)
    closed = track.closed
    builder = Builder()
    index = add_grid(builder, points[:, :-1] if closed else points, grid.counts, section.names, tolerance)
    ring = np.concatenate([index, index[:, :1]], axis=1)
    rising = np.concatenate([grid.rising, np.ones((len(grid.rising), 2), dtype=bool)], axis=1)
    if closed:
        faces = wrapped_faces(ring, rising, inward=False)
    else:
        faces = cell_faces(ring[:-1, :-1], ring[1:, :-1], ring[1:, 1:], ring[:-1, 1:], rising, inward=False)
    for b, name in enumerate(section.names):
        builder.faces(faces[band_cells(grid.counts, b)].reshape(-1, 3), name)
    builder.faces(faces[:, sum(grid.counts) :].reshape(-1, 3), "back")
    if not closed:
        cap = groove_cap(ring[0, :-2], ring[0, -2])
        builder.faces(cap, "cap")
        builder.faces(groove_cap(ring[-1, :-2], ring[-1, -2])[:, ::-1], "cap")
    mesh = builder.mesh()
    if mesh.volume < 0.0:
        return Mesh(mesh.vertices, np.ascontiguousarray(mesh.faces[:, ::-1]), mesh.groups, mesh.group)
    return mesh


def groove_cap(rows: Index, ridge: np.int64) -> Index:
    """Triangles closing the end of a groove body: rungs between the two flanks, and the ridge."""
    half = len(rows) // 2
    left, right = rows[: half + 1], rows[::-1][: len(rows) - half]
    triangles = [[ridge, rows[0], rows[-1]]]
    for j in range(max(len(left), len(right)) - 1):
        l0, l1 = left[min(j, len(left) - 1)], left[min(j + 1, len(left) - 1)]
        r0, r1 = right[min(j, len(right) - 1)], right[min(j + 1, len(right) - 1)]
        triangles += [[l0, l1, r0], [l1, r1, r0]]
    return np.array(triangles, dtype=np.int64)
