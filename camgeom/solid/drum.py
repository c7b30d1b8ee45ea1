"""Drums with a closed groove, rib or end face, meshed directly as one structured grid; thicknesses of their walls."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.frozen import cached_property
from camgeom.maths.sampling import Grid, sample
from camgeom.maths.surface import dot
from camgeom.solid import TOUCHED, QuickPart, Solid, eased, stated
from camgeom.solid.blank import Blank, Bore, Wall, close_ends
from camgeom.solid.builder import Builder, add_grid, band_cells, wrapped_faces
from camgeom.track import TURN, Track
from camgeom.track.column import Column, ConeLevel, CylinderLevel, cylinder_level, outside_level
from camgeom.track.section import GrooveSection

T = TypeVar("T")
CORNER = 0.98
"""aim of the sag of a cone's corners as a share of the tolerance"""
WALL_SAMPLES = 360
FACING = 0.71
"""least cosine between a web and the normals of both of its edges"""
THIN_WEB = "enlarge the cam, use a smaller roller, or give the steep motion more cam angle"
WEB_DEPTHS = 5
"""places between floor and outside at which the material between two passes is measured"""


@immutable
class GroovedCylinder(QuickPart):
    """A cylinder or cone 0 <= z <= length with one closed groove round it.

    radius  of the outside at z = 0, mm, and delta there; slope: by which a cone's radius falls per mm of height
    """

    name: str
    track: Track
    blank: Blank
    radius: float
    length: float
    slope: float = 0.0

    @property
    def outside(self) -> CylinderLevel | ConeLevel:
        """Level surface of its outside."""
        return outside_level(self.radius, self.slope)

    @property
    def end_radii(self) -> tuple[float | None, float | None]:
        """Radii of a cone's two end rings, mm; None of a cylinder's, which are as far out as the groove's edges."""
        return (self.radius, self.radius - self.slope * self.length) if self.slope else (None, None)

    @cached_property
    def section(self) -> GrooveSection:
        """The groove's cross-section, flank with the smaller z first."""
        column = Column(self.track, np.zeros(1))
        t = np.array([self.track.meridian.parameter(self.radius)])
        first = 1.0 if column.wall(1.0, t)[2, 0, 0] < column.wall(-1.0, t)[2, 0, 0] else -1.0
        return GrooveSection(self.track, self.outside, self.radius, first)

    @cached_property
    def fits(self) -> bool:
        """True where the groove stays inside both end faces, so that the body is one closed grid."""
        phi = np.linspace(*self.track.span, 721)
        column, section = Column(self.track, phi), self.section
        z = [column.wall(side, column.reach(side, section.level, self.radius))[2] for side in (1.0, -1.0)]
        if self.slope:
            # Of a roller that leans the foot may leave a body that its edge stays within.
            ball = column.ball_ended
            z += [column.ball_bottom()[2, :, None] if ball else column.wall(side, column.bottom_t())[2]
                  for side in (1.0, -1.0)]  # fmt: skip
        return self.track.closed and float(np.min(z)) > 0.0 and float(np.max(z)) < self.length

    def grid(self, tolerance: float, free: float | None = None) -> tuple[Grid, tuple[str, ...]]:
        """The structured grid from the lower end ring to the upper one, and the name of each band."""
        section = self.section

        def rows(phi: Floats, counts: tuple[int, ...]) -> Floats:
            groove = section.rows(Column(self.track, phi), counts[1:-1])
            low = self.land(groove[:, :, 0], 0.0, counts[0], self.end_radii[0])
            high = self.land(groove[:, :, -1], self.length, counts[-1], self.end_radii[1])[:, :, ::-1]
            return np.concatenate([low, groove, high], axis=2)

        most = (1, *section.max_counts, 1)
        names = ("land", *section.names, "land")
        return sample(rows, self.track.knots(), tolerance, most, eased(names, tolerance, free)), names

    @staticmethod
    def land(edge: Floats, z: float, count: int, radius: float | None = None) -> Floats:
        """Rows (3, n, count) straight from the end ring at z towards the groove's edge (edge excluded).

        radius  of a cone's end ring, mm; None: of a cylinder's, straight along Z
        """
        share = np.arange(count) / count
        rows = np.repeat(edge[:, :, None], count, axis=2)
        rows[2] = z + (edge[2][:, None] - z) * share
        if radius is not None:
            away = radius / np.sqrt(edge[0] * edge[0] + edge[1] * edge[1])
            rows[:2] *= away[:, None] + (1.0 - away)[:, None] * share
        return np.asarray(rows)

    def solid(self, tolerance: float, free: float | None = None) -> Solid:
        """Mesh directly. Raises DesignError where the topology is not that of a closed groove inside the cylinder."""
        (grid, names), sag = self.cornered(self.grid, lambda made: (made[0].phi, made[0].phi), tolerance, free)
        grid = replace(grid, chord_error=max(grid.chord_error, sag))
        self.check((grid.points[:, :, 1], grid.points[:, :, -2]))
        self.check_within(grid.points[2, :, 1:-1])
        inward = self.track.sense > 0
        return closed_body(self.name, grid, names, inward, (0.0, self.length), self.blank, tolerance, free)

    def check(self, edges: tuple[Floats, Floats]) -> None:
        """DesignError where the lower or the upper edge (3, n) leaves the drum or turns back."""
        low, high = edges
        if low[2].min() <= 0.0 or high[2].max() >= self.length:
            raise DesignError("the groove runs out of an end face, so the body is not one closed grid")
        refuse_turned(edges, "groove's")

    def cornered(
        self, mesh: Callable[[float, float | None], T], angles: Callable[[T], tuple[Floats, Floats]],
        tolerance: float, free: float | None,
    ) -> tuple[T, float]:  # fmt: skip
        """What a mesher makes of it so that the flanks' feet keep the tolerance too, and their largest sag, mm.

        Round a cone the foot of a flank is bent within both the flank and the floor: where each sags by nearly the
        tolerance, what lies in the corner between them is farther from both than either. Nothing is lost in a drum.
        angles  of the vertices of the first flank's foot and the other's, round the turn, rad
        """
        made, limit, share = mesh(tolerance, free), max(tolerance, free or 0.0), 1.0
        column = Column(self.track, np.zeros(1))
        if not self.slope or self.track.root or column.ball_ended:
            return made, 0.0
        while (sag := self._corner_sag(angles(made))) > limit:
            share *= CORNER * limit / sag
            made = mesh(share * tolerance, None if free is None else share * free)
        return made, sag if free is None else 0.0

    def _corner_sag(self, angles: tuple[Floats, Floats]) -> float:
        first, sags = self.section.first, []
        for side, phi in zip((first, -first), angles):
            start, middle, stop = (
                column.wall(side, column.bottom_t())[:, :, 0]
                for column in (Column(self.track, at) for at in (phi[:-1], 0.5 * (phi[:-1] + phi[1:]), phi[1:]))
            )
            off, along = middle - 0.5 * (start + stop), stop - start
            off = off - along * (dot(off, along) / dot(along, along))
            sags.append(float(np.sqrt(dot(off, off).max())))
        return max(sags)

    def check_within(self, z: Floats) -> None:
        """DesignError where heights z of a cone's groove, its foot among them, leave the drum."""
        if self.slope and (z.min() <= 0.0 or z.max() >= self.length):
            raise DesignError("the groove's foot runs out of an end face: a shallower groove or a longer drum")


@immutable
class RibbedCylinder(QuickPart):
    """A drum of `base` radius with a rib of outer `radius` between a lower and an upper roller."""

    name: str
    lower: Track
    upper: Track
    blank: Blank
    base: float
    radius: float
    length: float

    def solid(self, tolerance: float, free: float | None = None) -> Solid:
        """Mesh directly. Raises DesignError where the rib leaves the drum or its edges turn back or cross."""
        low_side, high_side = self.sides
        most = (1, 4000, 4000, 4000, 1)
        names = ("base", "flank", "land", "flank", "base")

        def rows(phi: Floats, counts: tuple[int, ...]) -> Floats:
            low, high = Column(self.lower, phi), Column(self.upper, phi)
            up, down = (
                self.wall(column, side, np.arange(count + 1) / count)
                for column, side, count in ((low, low_side, counts[1]), (high, high_side, counts[3]))
            )
            down = down[:, :, ::-1]
            top = on_cylinder(up[:, :, -1], down[:, :, 0], self.radius, np.arange(1, counts[2]) / counts[2])
            start = GroovedCylinder.land(up[:, :, 0], 0.0, counts[0])
            stop = GroovedCylinder.land(down[:, :, -1], self.length, counts[4])[:, :, ::-1]
            return np.concatenate([start, up, top, down, stop], axis=2)

        grid = sample(rows, self.lower.knots(), tolerance, most, eased(names, tolerance, free))
        ends = np.cumsum(grid.counts)
        self.check([grid.points[:, :, k] for k in (1, ends[0] + grid.counts[1], ends[2], ends[3])])
        inward = self.lower.sense > 0
        return closed_body(self.name, grid, names, inward, (0.0, self.length), self.blank, tolerance, free)

    @property
    def sides(self) -> tuple[float, float]:
        """Sides (+1 or -1) of the lower and the upper roller that cut the rib."""
        return facing(self.lower, 1.0), facing(self.upper, -1.0)

    def wall(self, column: Column, side: float, share: Floats) -> Floats:
        """Points (3, n, k) of a flank at shares (k,) or (n, k) of the way from its foot to the rib's top."""
        return wall_between(column, side, (self.base, self.radius), share)

    def check(self, edges: Sequence[Floats]) -> None:
        """DesignError where the edges (3, n), from the lower foot up, leave the drum, turn back, or cross."""
        if min(edge[2].min() for edge in edges) <= 0.0 or max(edge[2].max() for edge in edges) >= self.length:
            raise DesignError("the rib runs out of an end face; lengthen the drum or move `start`")
        refuse_turned(edges, "rib's")
        for lower, upper, where in ((0, 3, "foot"), (1, 2, "tip")):
            above = height_above(edges[lower], edges[upper])
            if above.min() <= 0.0:
                worst = np.degrees(np.arctan2(*edges[lower][[1, 0], int(np.argmin(above))]))
                raise DesignError(
                    f"the rib's flanks cross at its {where} (azimuth {worst:.6g} deg of the drum), so they bound no "
                    "body: see rib-thickness; a thicker rib, a larger drum, or more cam angle for the motion"
                )


@immutable
class EndFaceRing(QuickPart):
    """A ring from radius `inner` to `outer` on a web 0 <= z <= web; a roller on its upper end is the profile."""

    name: str
    track: Track
    blank: Blank
    inner: float
    outer: float
    web: float

    def solid(self, tolerance: float, free: float | None = None) -> Solid:
        """Mesh directly. Raises DesignError where an edge of the end face turns back, or cuts into the web."""
        names = ("land", "flank", "inside")

        def rows(phi: Floats, counts: tuple[int, ...]) -> Floats:
            face = self.face(Column(self.track, phi), np.arange(counts[1] + 1) / counts[1])
            start = GroovedCylinder.land(face[:, :, 0], 0.0, counts[0])
            stop = GroovedCylinder.land(face[:, :, -1], self.web, counts[2])[:, :, ::-1]
            return np.concatenate([start, face, stop], axis=2)

        grid = sample(rows, self.track.knots(), tolerance, (1, 4000, 1), eased(names, tolerance, free))
        self.check((grid.points[:, :, 1], grid.points[:, :, -2]))
        return closed_body(self.name, grid, names, self.track.sense > 0, (0.0, self.web), self.blank, tolerance, free)

    def face(self, column: Column, share: Floats) -> Floats:
        """Points (3, n, k) of the end face at shares (k,) or (n, k) of the way from its outer edge inwards."""
        (side,) = self.track.sides
        return wall_between(column, side, (self.outer, self.inner), share)

    def check(self, edges: Sequence[Floats]) -> None:
        """DesignError where the outer or the inner edge (3, n) turns back, or cuts into the web."""
        if min(edge[2].min() for edge in edges) <= self.web:
            raise DesignError("the end face cuts into the web; a greater `height` or a thinner `web`")
        refuse_turned(edges, "end face's")


def facing(track: Track, sign: float) -> float:
    """The side (+1 or -1) of a roller's flank that is towards sign * Z."""
    column, t = Column(track, np.zeros(1)), np.array([track.meridian.parameter(track.contact[1])])
    return 1.0 if sign * (column.wall(1.0, t)[2, 0, 0] - column.wall(-1.0, t)[2, 0, 0]) > 0.0 else -1.0


def wall_between(column: Column, side: float, radii: tuple[float, float], share: Floats) -> Floats:
    """Points (3, n, k) of a flank at shares (k,) or (n, k) of the way from one cylinder about the axis to another."""
    start, stop = (column.reach(side, cylinder_level(radius), radius) for radius in radii)
    return column.wall(side, start + (stop - start) * share)


def refuse_turned(edges: Sequence[Floats], whose: str) -> None:
    """DesignError where one of the edges (3, n) round the axis turns back on itself."""
    for edge in edges:
        around = edge[0, :-1] * edge[1, 1:] - edge[1, :-1] * edge[0, 1:]
        if not (around.min() > 0.0 or around.max() < 0.0):
            raise DesignError(f"the {whose} edge turns back on itself: the flank is undercut")


def height_above(lower: Floats, upper: Floats) -> Floats:
    """Height (n,) of a closed edge (3, n) round the axis above every point of another at the same azimuth, mm."""
    at, angle = (np.arctan2(edge[1], edge[0]) for edge in (lower, upper))
    return np.asarray(np.interp(at, angle, upper[2], period=TURN) - lower[2])


def on_cylinder(start: Floats, stop: Floats, radius: float, share: Floats) -> Floats:
    """Points (3, n, k) at shares (k,) or (n, k) of the way between two edges (3, n) on a cylinder, straight in angle
    and z."""
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
    free: float | None,
) -> Solid:
    """Close a grid that runs once round the axis, from the lower end ring to the upper one, into a solid."""
    builder = Builder()
    index = add_grid(builder, grid.points[:, :-1], grid.counts, names, tolerance)
    faces = wrapped_faces(index, grid.rising, inward)
    for b, band in enumerate(names):
        builder.faces(faces[band_cells(grid.counts, b)].reshape(-1, 3), band)
    bottom, top = index[:, 0], index[:, -1]
    if inward:
        bottom, top = bottom[::-1], top[::-1]
    bored = close_ends(builder, bottom, top, ends[0], ends[1], blank.bore, free or tolerance)
    errors = [(TOUCHED, grid.chord_error), ("land", grid.free_error or 0.0), ("bore", bored)]
    error, free_error = stated(errors, free)
    return Solid(name, builder.mesh(), error, "direct", 0 if blank.bore is None else 1, free_error)


def drum_walls(tracks: tuple[Track, ...], radius: float, floor: float, length: float, bore: Bore | None) -> list[Wall]:
    """Walls of a drum of outer `radius` and `floor` radius, 0 <= z <= length, cut by the tracks' outer edges."""
    even = np.linspace(0.0, TURN, WALL_SAMPLES, endpoint=False)
    walls = []
    for track in tracks:
        # Edges are nearest to the ends where the roller is.
        phi = distinct(np.concatenate([even, [end.at % TURN for end in track.program.extremes(0)]]))
        column = Column(track, phi)
        edges = {}
        for side in track.sides:
            x = column.wall(side, column.reach(side, cylinder_level(radius), radius))[:, :, 0]
            edges[side] = np.stack([radius * np.unwrap(np.arctan2(x[1], x[0])), x[2]])
        walls += ends_walls(track, phi, np.stack([edge[1] for edge in edges.values()]), 0.0, length)
        if len(track.sides) == 2:
            walls += thinnest_web(track, even, radius)
    if bore is not None:
        walls.append(Wall("floor to bore", floor - bore.reach, None, "make the bore smaller or the groove shallower"))
    return walls


def cone_walls(ring: GroovedCylinder, floor: float) -> list[Wall]:
    """Walls of a conical drum: beside its groove, from outside to floor, to both ends, between passes, to the bore.

    floor  least radius of the groove's floor, mm
    """
    track, bore = ring.track, ring.blank.bore
    phi = np.linspace(0.0, TURN, WALL_SAMPLES, endpoint=False)
    column = Column(track, phi)
    outside = {side: column.reach(side, ring.outside, ring.radius) for side in track.sides}
    depths = np.linspace(track.tip, ring.radius, WEB_DEPTHS)
    edges = [{side: edge_at(column, side, outside[side], depth, ring.radius) for side in track.sides}
             for depth in depths]  # fmt: skip
    walls = ends_walls(track, phi, np.stack([x[2] for each in edges for x in each.values()]), 0.0, ring.length)
    webs = [web for each in edges for web in _cone_webs(track, phi, each, ring.slope)]
    walls += [min(webs, key=lambda wall: wall.thickness)] if webs else []
    if bore is not None:
        walls.append(Wall("floor to bore", floor - bore.reach, None, "make the bore smaller or the groove shallower"))
    return walls


def _cone_webs(track: Track, phi: Floats, edges: dict[float, Floats], slope: float) -> list[Wall]:
    """Material between two passes of the same groove edge, (3, n) each, in the cone rolled out; see `_webs`.

    Seen from a point, in its own directions round the cone and up its generator, another one that stands by an azimuth
    further appears turned about the apex by its sine's share of it.
    """
    scale, found = np.sqrt(1.0 + slope**2), []
    sine = slope / scale
    middle = 0.5 * np.sum(list(edges.values()), axis=0)
    for edge in edges.values():
        radius = np.hypot(edge[0], edge[1])

        def from_to(start: Floats, stop: Floats, radius: Floats = radius) -> Floats:
            """Ways (2, n) round and up between points (3, n) that are near each other."""
            return np.stack([radius * np.angle(_azimuth(stop) / _azimuth(start)), (stop[2] - start[2]) * scale])

        along = from_to(np.roll(edge, 1, axis=1), np.roll(edge, -1, axis=1))
        normal = np.stack([-along[1], along[0]]) / np.hypot(*along)
        normal *= np.sign((normal * from_to(middle, edge)).sum(axis=0))
        turned = np.angle(_azimuth(edge)[None, :] / _azimuth(edge)[:, None])
        c, s = np.cos(sine * turned), np.sin(sine * turned)
        # sin(a) / sine and (1 - cos(a)) / sine, a = sine turned, which stay exact where the cone is a cylinder.
        half = 0.5 * sine * turned
        around, up = turned * np.sinc(2.0 * half / np.pi), turned * np.sin(half) * np.sinc(half / np.pi)
        d = np.stack([radius * around, (edge[2][None, :] - edge[2][:, None]) * scale + radius * up])
        distance = np.hypot(*d)
        leaving = d[0] * normal[0][:, None] + d[1] * normal[1][:, None]
        arriving = -d[0] * (normal[0] * c - normal[1] * s) - d[1] * (normal[0] * s + normal[1] * c)
        gap = np.where((np.minimum(leaving, arriving) > FACING * distance) & (distance > 0.0), distance, np.inf)
        i, j = np.unravel_index(int(np.argmin(gap)), gap.shape)
        if np.isfinite(gap[i, j]):
            found.append(Wall(f"{track.name} between passes", float(gap[i, j]), float(phi[min(i, j)]), THIN_WEB))
    return found


def _azimuth(x: Floats) -> npt.NDArray[np.complex128]:
    """Points (3, n) seen along the axis, (n,)."""
    return np.asarray(x[0] + 1j * x[1])


def ends_walls(
    track: Track, phi: Floats, z: Floats, start: float, stop: float, below: str = "lower end"
) -> list[Wall]:
    """Walls from a groove's edges, heights z (k, n), to both ends of what it is cut into, where they stay within it.

    start, stop  heights of the ends, mm; below: name of the lower one
    """
    low, high = z.min(axis=0), z.max(axis=0)
    i, j = int(np.argmin(low)), int(np.argmax(high))
    advice = "move `start`, lengthen the cam, or shorten the stroke"
    found = []
    if low[i] > start:
        found.append(Wall(f"{track.name} to {below}", float(low[i] - start), float(phi[i]), advice))
    if high[j] < stop:
        found.append(Wall(f"{track.name} to upper end", float(stop - high[j]), float(phi[j]), advice))
    return found


def thinnest_web(track: Track, phi: Floats, radius: float) -> list[Wall]:
    """Material between two passes of a groove, where it is thinnest from the floor to the outside: near the axis two
    steep passes are nearer to each other."""
    column = Column(track, phi)
    outside = {side: column.reach(side, cylinder_level(radius), radius) for side in track.sides}
    found: list[Wall] = []
    for depth in np.linspace(track.tip, radius, WEB_DEPTHS):
        edges = {side: edge_at(column, side, outside[side], depth, radius) for side in track.sides}
        at = min(float(np.hypot(x[0], x[1]).min()) for x in edges.values())
        flat = {side: np.stack([at * np.unwrap(np.arctan2(x[1], x[0])), x[2]]) for side, x in edges.items()}
        found += _webs(track, phi, flat, TURN * at)
    return [min(found, key=lambda wall: wall.thickness)] if found else []


def edge_at(column: Column, side: float, outside: Floats, depth: float, radius: float) -> Floats:
    """Curve (3, n) along a flank, as deep between the tool's tip and the outside as a radius between theirs, mm.

    outside  parameters (n, 1) at which the flank meets the outside, a cylinder of the drum's radius
    """
    share = (depth - column.track.tip) / (radius - column.track.tip)
    if column.ball_ended and share == 0.0:
        # Both flanks of a ball end where they meet.
        return column.ball_bottom()
    tip = column.bottom_t() if column.ball_ended else column.track.meridian.parameter(column.track.tip)
    return column.wall(side, tip + share * (outside - tip))[:, :, 0]


def _opposed(normal: Floats) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Points of an edge with the normals (2, n) of which one (i,) can face another (j,): whose normals differ by more
    than a right angle. All of them where the edge turns back on itself."""
    angle = np.arctan2(normal[0], normal[1] * np.sign(normal[1].sum() or 1.0))
    if np.ptp(angle) > 1.5 * np.pi:
        return np.arange(angle.size), np.arange(angle.size)
    right = 0.5 * np.pi
    return np.flatnonzero(angle > angle.min() + right), np.flatnonzero(angle < angle.max() - right)


def _webs(track: Track, phi: Floats, edges: dict[float, Floats], turn: float) -> list[Wall]:
    """Material between two passes of the same groove edge, in the developed surface of a cylinder.

    Two edge points face each other across the material where the line between them leaves both edges on their
    material side within 45 degrees of the normal; the shortest such line is the web.
    """
    shortest, where = np.inf, 0
    middle = 0.5 * sum(edges.values())
    for edge in edges.values():
        tangent = np.roll(edge, -1, axis=1) - np.roll(edge, 1, axis=1)
        tangent[0] -= turn * np.rint(tangent[0] / turn)
        normal = np.stack([-tangent[1], tangent[0]]) / np.hypot(*tangent)
        outward = (normal * (edge - middle)).sum(axis=0)
        normal = normal * np.sign(outward)
        i, j = _opposed(normal)
        d = edge[:, None, j] - edge[:, i, None]
        d[0] -= turn * np.rint(d[0] / turn)
        distance = np.sqrt(d[0] * d[0] + d[1] * d[1])
        leaving = d[0] * normal[0][i, None] + d[1] * normal[1][i, None]
        arriving = -d[0] * normal[0][j] - d[1] * normal[1][j]
        facing = (np.minimum(leaving, arriving) > FACING * distance) & (distance > 0.0)
        gap = np.where(facing, distance, np.inf)
        if gap.min(initial=np.inf) < shortest:
            shortest = float(gap.min())
            one, other = np.unravel_index(np.argmin(gap), gap.shape)
            where = min(int(i[one]), int(j[other]))
    if not np.isfinite(shortest):
        return []
    return [Wall(f"{track.name} between passes", shortest, float(phi[where]), THIN_WEB)]
