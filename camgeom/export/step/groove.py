"""Cams with a closed groove, rib or end face as boundary representations: the bands of `solid`, on exact splines.

The bands are those of the direct mesh (land, flank, edge sweep, floor, edge sweep, flank, land), each as exact points
at any cam angle and any share across it, so that mesh and STEP file describe one and the same surface.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import atan
from typing import final

import numpy as np

from camgeom.errors import DesignError
from camgeom.export.step.brep import Brep
from camgeom.export.step.geometry import WORLD, Cone, Frame
from camgeom.export.step.shell import ShellBand, shell
from camgeom.export.step.solids import TOLERANCE, bore_holes, closed_solid
from camgeom.export.step.spline import SurfacePoints
from camgeom.maths import Floats, distinct
from camgeom.maths.extremum import bracketed_root
from camgeom.solid.bell import GroovedRing
from camgeom.solid.drum import EndFaceRing, GroovedCylinder, RibbedCylinder
from camgeom.solid.grooves import GroovedDrum
from camgeom.track import Track
from camgeom.track.column import Column, Level, cylinder_level
from camgeom.track.section import ROOTED


def grooved_solid(body: GroovedCylinder, tolerance: float = TOLERANCE) -> Brep:
    """The grooved cylinder as a solid whose fitted faces are within `tolerance` mm of the exact ones.

    Raises DesignError where the groove runs out of an end or its edge turns back (the mesh says so too), NotConverged
    where the motion has a kink that is no knot.
    """
    if not body.fits:
        raise DesignError(f"{body.name!r}: the groove runs out of an end face, so it is no closed ring")
    section = body.section
    walls = FlankPair(body.track, section.level, section.guess)
    bands = [
        land(walls.edge(section.first), 0.0, True, body.radius, slope=body.slope),
        *groove_bands(walls, section.first),
        land(walls.edge(-section.first), body.length, False, body.radius, slope=body.slope),
    ]
    knots = split_knots(body.track)
    skin = shell(bands, knots, -body.track.sense, tolerance)
    return closed_solid(body.name, skin, (0.0, body.length), bore_holes(body.blank.bore), tolerance)


def grooves_solid(body: GroovedDrum, tolerance: float = TOLERANCE) -> Brep:
    """The drum with several grooves as a solid whose fitted faces are within `tolerance` mm of the exact ones; raises
    as above."""
    if not body.fits:
        raise DesignError(f"{body.name!r}: a groove runs out of an end face or into the next one")
    bands: list[ShellBand] = []
    before: SurfacePoints | None = None
    for ring in body.ordered:
        section = ring.section
        walls = FlankPair(ring.track, section.level, section.guess)
        low, high = walls.edge(section.first), walls.edge(-section.first)
        bands.append(land(low, 0.0, True, body.radius) if before is None else crest(before, low, body.radius))
        bands += groove_bands(walls, section.first)
        before = high
    assert before is not None
    bands.append(land(before, body.length, False, body.radius))
    knots = distinct(np.concatenate([split_knots(ring.track) for ring in body.rings]))
    kept = knots[np.concatenate([[True], np.diff(knots) > 1e-9])]
    skin = shell(bands, kept, -body.rings[0].track.sense, tolerance)
    return closed_solid(body.name, skin, (0.0, body.length), bore_holes(body.blank.bore), tolerance)


def ribbed_solid(body: RibbedCylinder, tolerance: float = TOLERANCE) -> Brep:
    """The ribbed drum as a solid whose fitted faces are within `tolerance` mm of the exact ones; raises as above."""
    low_side, high_side = body.sides
    tracks = body.lower, body.upper
    feet, tops = ([FlankPair(t, cylinder_level(r), r) for t in tracks] for r in (body.base, body.radius))
    bands = [
        land(feet[0].edge(low_side), 0.0, True, body.base, "base"),
        ShellBand("flank", between(feet[0], tops[0], low_side)),
        crest(tops[0].edge(low_side), tops[1].edge(high_side), body.radius),
        ShellBand("flank", flipped(between(feet[1], tops[1], high_side))),
        land(feet[1].edge(high_side), body.length, False, body.base, "base"),
    ]
    skin = shell(bands, body.lower.knots(), -body.lower.sense, tolerance)
    return closed_solid(body.name, skin, (0.0, body.length), bore_holes(body.blank.bore), tolerance)


def end_face_solid(body: EndFaceRing, tolerance: float = TOLERANCE) -> Brep:
    """The ring with its web as a solid whose fitted faces are within `tolerance` mm of the exact ones; raises as above.
    """
    (side,) = body.track.sides
    outer, inner = (FlankPair(body.track, cylinder_level(r), r) for r in (body.outer, body.inner))
    bands = [
        land(outer.edge(side), 0.0, True, body.outer),
        ShellBand("flank", between(outer, inner, side)),
        land(inner.edge(side), body.web, False, body.inner, "inside"),
    ]
    skin = shell(bands, body.track.knots(), -body.track.sense, tolerance)
    return closed_solid(body.name, skin, (0.0, body.web), bore_holes(body.blank.bore), tolerance)


def grooved_ring_solid(body: GroovedRing, tolerance: float = TOLERANCE) -> Brep:
    """The ring with a groove in its inside as a solid whose fitted faces are within `tolerance` mm of the exact ones;
    raises as above."""
    low_side, high_side = body.sides
    mouth, floor = (FlankPair(body.track, cylinder_level(r), r) for r in (body.inner, body.floor))
    upper, lower = mouth.edge(high_side), mouth.edge(low_side)

    def rim(phi: Floats, share: Floats) -> Floats:
        return points_last(body.rim(np.moveaxis(upper(phi, share), -1, 0)))

    def end(phi: Floats, share: Floats) -> Floats:
        start, stop = rim(phi, share), upper(phi, share).copy()
        stop[..., 2] = body.length
        return start * (1.0 - share[:, None]) + stop * share[:, None]

    bands = [
        land(rim, 0.0, True, body.outer),
        ShellBand("end", end, degree=1),
        land(upper, body.length, True, body.inner, "inside"),
        ShellBand("flank", between(mouth, floor, high_side)),
        replace(crest(floor.edge(high_side), floor.edge(low_side), body.floor), name="floor"),
        ShellBand("flank", flipped(between(mouth, floor, low_side))),
        land(lower, body.web, False, body.inner, "inside"),
    ]
    skin = shell(bands, body.track.knots(), -body.track.sense, tolerance)
    return closed_solid(body.name, skin, (0.0, body.web), bore_holes(body.blank.bore), tolerance)


def between(foot: FlankPair, top: FlankPair, side: float) -> SurfacePoints:
    """Points of one flank from the level surface of `foot` (share 0) to that of `top` (share 1)."""

    def point(phi: Floats, share: Floats) -> Floats:
        low, high = foot.top(phi, side), top.top(phi, side)
        return points_last(foot.column(phi).wall(side, low + (high - low) * share))

    return point


def crest(start: SurfacePoints, stop: SurfacePoints, radius: float) -> ShellBand:
    """The land of a rib between its two edges on the cylinder of `radius`, straight in angle and z."""

    def point(phi: Floats, share: Floats) -> Floats:
        low, high = start(phi, share), stop(phi, share)
        a0 = np.arctan2(low[..., 1], low[..., 0])
        sweep = (np.arctan2(high[..., 1], high[..., 0]) - a0 + np.pi) % (2.0 * np.pi) - np.pi
        angle = a0 + sweep * share
        z = low[..., 2] * (1.0 - share) + high[..., 2] * share
        return np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=-1)

    return ShellBand("land", point, candidates=(Cone(WORLD, radius),))


@final
class FlankPair:
    """The two flanks of a track from a level surface down to the roller's free end, and what lies between.

    Columns are kept while neighbouring bands ask for the same cam angles.
    """

    KEPT = 4

    def __init__(self, track: Track, level: Level, guess: float) -> None:
        self.track, self.level, self.guess = track, level, guess
        self._columns: dict[bytes, tuple[Column, dict[float, Floats]]] = {}

    def column(self, phi: Floats) -> Column:
        """The track's column at cam angles (n,), computed once for a run of calls."""
        return self._entry(phi)[0]

    def _entry(self, phi: Floats) -> tuple[Column, dict[float, Floats]]:
        key = phi.tobytes()
        if key not in self._columns:
            while len(self._columns) >= self.KEPT:
                del self._columns[next(iter(self._columns))]
            self._columns[key] = Column(self.track, phi), {}
        return self._columns[key]

    def top(self, phi: Floats, side: float) -> Floats:
        """Meridian parameter (n, 1) where a flank meets the level surface."""
        column, tops = self._entry(phi)
        if side not in tops:
            tops[side] = column.reach(side, self.level, self.guess)
        return tops[side]

    def wall(self, side: float) -> SurfacePoints:
        """Points of one flank from the level surface (share 0) to its foot at the roller's free end (share 1)."""

        def point(phi: Floats, share: Floats) -> Floats:
            column, top = self.column(phi), self.top(phi, side)
            if column.ball_ended:
                return points_last(self._ball(column, column.wall(side, top), share))
            return points_last(column.wall(side, top + (column.bottom_t() - top) * share))

        return point

    def _ball(self, column: Column, top: Floats, share: Floats) -> Floats:
        """Points (3, n, m) of a ball's contact circle from its top (3, n, 1) to its lowest point, even in angle."""
        pose, meridian = column.pose, self.track.meridian
        centre = (pose.a[0] + meridian.centre * pose.u[0])[:, :, None]
        down, up = (column.ball_bottom()[:, :, None] - centre) / meridian.radius, (top - centre) / meridian.radius
        cosine = (down * up).sum(axis=0)
        aside = up - cosine * down
        sine = np.sqrt((aside * aside).sum(axis=0))
        angle = np.arctan2(sine, cosine) * (1.0 - share)
        return np.asarray(centre + meridian.radius * (np.cos(angle) * down + np.sin(angle) * (aside / sine)))

    def edge(self, side: float) -> SurfacePoints:
        """Points (n, 1, 3) of the edge between one flank and the level surface."""
        return lambda phi, _: points_last(self.column(phi).wall(side, self.top(phi, side)))


def groove_bands(walls: FlankPair, first: float) -> list[ShellBand]:
    """Bands across a groove from the top of flank `first` (+1 or -1) to the top of the other one."""
    down, up = ShellBand("flank", walls.wall(first)), ShellBand("flank", flipped(walls.wall(-first)))
    if walls.column(np.zeros(1)).ball_ended:
        return [down, up]

    def sweep(side: float) -> SurfacePoints:
        return lambda phi, share: points_last(walls.column(phi).edge(side, share))

    foot = "root" if walls.track.root else "edge"

    def floor(phi: Floats, share: Floats) -> Floats:
        column = walls.column(phi)
        low, high = column.chord_end(first)[:, :, None], column.chord_end(-first)[:, :, None]
        return points_last(low * (1.0 - share) + high * share)

    there, back = ShellBand(foot, sweep(first)), ShellBand(foot, flipped(sweep(-first)))
    return [down, there, ShellBand("floor", floor, degree=1), back, up]


def rooted_bands(walls: FlankPair) -> list[ShellBand]:
    """Bands across an indexing cam's groove with rounded roots, from the top of flank +1 to the top of the other."""

    def root(side: float) -> SurfacePoints:
        return lambda phi, share: points_last(walls.column(phi).corner(side, ROOTED * share))

    def floor(phi: Floats, share: Floats) -> Floats:
        low, high = (walls.column(phi).corner(side, np.array([ROOTED])) for side in (1.0, -1.0))
        return points_last(low * (1.0 - share) + high * share)

    middle = [ShellBand("root", root(1.0)), ShellBand("floor", floor, degree=1), ShellBand("root", flipped(root(-1.0)))]
    return [ShellBand("flank", walls.wall(1.0)), *middle, ShellBand("flank", flipped(walls.wall(-1.0)))]


def land(
    edge: SurfacePoints, z: float, rising: bool, radius: float, name: str = "land", slope: float = 0.0
) -> ShellBand:
    """The cylinder of `radius` straight along Z between an end ring at z and a groove's edge (first where falling).

    slope  by which the radius of a cone falls per mm of height; `radius` is that at z = 0
    """

    def point(phi: Floats, share: Floats) -> Floats:
        top = edge(phi, share)
        x = np.repeat(top, len(share), axis=1)
        weight = share if rising else 1.0 - share
        x[..., 2] = z * (1.0 - weight) + top[..., 2] * weight
        if slope:
            away = (radius - slope * z) / np.hypot(top[..., 0], top[..., 1])
            x[..., :2] *= (away * (1.0 - weight) + weight)[..., None]
        return x

    # The half angle of a written cone is positive: its frame points to where it widens.
    frame = Frame((0.0, 0.0, 0.0), (0.0, 0.0, -1.0)) if slope > 0.0 else WORLD
    return ShellBand(name, point, degree=1, candidates=(Cone(frame, radius, atan(abs(slope))),))


def flipped(points: SurfacePoints) -> SurfacePoints:
    """The same band run across the other way."""
    return lambda phi, share: points(phi, (1.0 - share)[::-1])[:, ::-1]


def points_last(x: Floats) -> Floats:
    """Component-major (3, n, m) points as (n, m, 3)."""
    return np.ascontiguousarray(np.moveaxis(x, 0, -1))


def split_knots(track: Track, samples: int = 48) -> Floats:
    """The track's knots, and between them the cam angles where an edge sweep narrows to a point, rad."""
    knots = track.knots()
    if track.root or Column(track, knots[:1]).ball_ended:
        return knots
    narrow = [knots]
    for side in (1.0, -1.0):

        def arc(phi: Floats, side: float = side) -> Floats:
            return np.asarray(Column(track, phi).edge_arc(side)[0])

        for low, high in pairwise(knots.tolist()):
            phi = np.linspace(low, high, samples + 1)[1:-1]
            angle = arc(phi)
            at = np.nonzero((angle[1:] * angle[:-1] < 0.0) & (np.maximum(abs(angle[1:]), abs(angle[:-1])) > 1e-9))[0]
            narrow.append(bracketed_root(arc, phi[at], phi[at + 1]))
    merged = distinct(np.concatenate(narrow))
    keep = np.concatenate([[True], np.diff(merged) > 1e-9])
    return np.asarray(merged[keep])
