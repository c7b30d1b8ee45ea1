"""Drums and end faces with about the fewest triangles: bands whose rows and columns follow the curvature.

The same bodies as `camgeom.solid.drum` and `grooves` mesh as one structured grid in less than half the time.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import accumulate
from math import sqrt

import numpy as np

from camgeom.maths import Floats
from camgeom.maths.banded import Band, Banded, banded
from camgeom.solid import TOUCHED, Part, Solid, stated
from camgeom.solid.blank import Blank, close_ends
from camgeom.solid.builder import Builder
from camgeom.solid.drum import EndFaceRing, GroovedCylinder, RibbedCylinder, on_cylinder, refuse_turned
from camgeom.solid.grooves import GroovedDrum
from camgeom.track import Track
from camgeom.track.section import Column

BATCH = 4096
"""poses made at once: so many stay in the processor's cache"""
Surface = Callable[[Floats, Floats], Floats]
"""points (3, n, m) at angles (n,) and ways across (n, m)"""
Edge = Callable[[Floats], Floats]
"""points (3, n, 1) at angles (n,)"""


def fewest(part: Part, tolerance: float, free: float | None = None) -> Solid:
    """A drum's body with the fewest triangles; any other body as it makes itself.

    free  mm, tolerance of the faces that no follower touches; None: the same
    """
    if isinstance(part, GroovedCylinder):
        return _grooved(part, tolerance, free)
    if isinstance(part, GroovedDrum):
        return _grooves(part, tolerance, free)
    if isinstance(part, RibbedCylinder):
        return _ribbed(part, tolerance, free)
    if isinstance(part, EndFaceRing):
        return _end_face(part, tolerance, free)
    return part.solid(tolerance, free)


def _grooved(body: GroovedCylinder, tolerance: float, free: float | None) -> Solid:
    """Raises DesignError where the topology is not that of a closed groove inside the cylinder."""
    bands = _with_free(drum_bands((body,), tolerance), free)
    surface = banded(bands, body.track.knots())
    body.check((surface.edge(1), surface.edge(-2)))
    return _closed(body.name, surface, bands, body.track, (0.0, body.length), body.blank, tolerance, free)


def _grooves(body: GroovedDrum, tolerance: float, free: float | None) -> Solid:
    body.refuse_overlap()
    bands = _with_free(drum_bands(body.ordered, tolerance), free)
    surface = banded(bands, body.knots())
    refuse_turned([surface.edge(b) for b in range(1, len(bands))], "groove's")
    return _closed(body.name, surface, bands, body.ordered[0].track, (0.0, body.length), body.blank, tolerance, free)


def drum_bands(rings: Sequence[GroovedCylinder], tolerance: float) -> list[Band]:
    """Lands and grooves by turns, from the lower end ring to the upper one."""
    radius, length = rings[0].radius, rings[0].length
    grooves = [_groove(ring, tolerance) for ring in rings]
    bands = [_land(_along_axis(partial(_at_share, grooves[0][0].at, 0.0), 0.0), grooves[0][0])]
    for number, own in enumerate(grooves, 1):
        bands += own
        edge = partial(_at_share, own[-1].at, 1.0)
        if number < len(grooves):
            at = _between(edge, partial(_at_share, grooves[number][0].at, 0.0), radius)
        else:
            at = _along_axis(edge, length, down=True)
        bands.append(replace(_land(at, own[-1]), sharp=True))
    return bands


def _groove(ring: GroovedCylinder, tolerance: float) -> list[Band]:
    """Flank, foot, floor, foot and flank, the one with the smaller z first; each foot in two halves."""
    section, columns = ring.section(), Columns(ring.track)
    sides = (0, 1) if len(section.names) == 2 else (0, 2, 3, 4, 1)
    # The rows of a ball that swings stand as roots of their numbers towards the bottom: half way in number
    # is at sqrt(1/2) of the way, where a chord shows 4 (sqrt(1/2) - 1/2) of its sag.
    seen = 1.0 if len(section.names) > 2 else 4.0 * (sqrt(0.5) - 0.5)
    own = [
        Band(name, partial(columns.points, at), tolerance, even=name == "flank", seen=seen, source=columns, side=side)
        for name, at, side in zip(section.names, section.bands, sides)
    ]
    own[0] = replace(own[0], sharp=True)
    if len(own) > 2:
        foot, floor, toe = own[1:4]
        if section.foot_name == "edge":
            # What sweeps from flank to floor has no width where the follower rests: the flank's foot stays.
            foot, toe = replace(foot, shrinks=0), replace(toe, shrinks=1)
        own[1:4] = [*_halves(foot, (False, True)), floor, *_halves(toe, (True, False))]
    return own


def _with_free(bands: list[Band], free: float | None) -> list[Band]:
    """The bands, those that no follower touches with a tolerance of their own."""
    return [band if free is None or band.name == TOUCHED else replace(band, tolerance=free) for band in bands]


def _ribbed(body: RibbedCylinder, tolerance: float, free: float | None) -> Solid:
    """Raises DesignError where the rib leaves the drum or its edges turn back or cross."""
    low, high = Columns(body.lower), Columns(body.upper)
    up, above = (partial(_rib_wall, body, columns, side) for columns, side in zip((low, high), body.sides))

    def down(phi: Floats, u: Floats) -> Floats:
        return above(phi, 1.0 - u)

    rising = Band("flank", up, tolerance, even=True, sharp=True, source=low)
    falling = replace(rising, at=down, source=high)
    tip = _between(partial(_at_share, up, 1.0), partial(_at_share, down, 0.0), body.radius)
    bands = [
        replace(_land(_along_axis(partial(_at_share, up, 0.0), 0.0), rising), name="base"), rising,
        replace(_land(tip, rising), sharp=True), falling,
        replace(_land(_along_axis(partial(_at_share, down, 1.0), body.length, down=True), falling), name="base",
                sharp=True),
    ]  # fmt: skip
    bands = _with_free(bands, free)
    surface = banded(bands, body.lower.knots())
    body.check([surface.edge(b) for b in (1, 2, 3, 4)])
    return _closed(body.name, surface, bands, body.lower, (0.0, body.length), body.blank, tolerance, free)


def _rib_wall(body: RibbedCylinder, columns: Columns, side: float, phi: Floats, u: Floats) -> Floats:
    return body.wall(columns.at(phi), side, u)


def _end_face(body: EndFaceRing, tolerance: float, free: float | None) -> Solid:
    """Raises DesignError where an edge of the end face turns back, or cuts into the web."""
    columns = Columns(body.track)
    flank = Band("flank", partial(columns.points, body.face), tolerance, even=True, sharp=True, source=columns)
    outer, inner = (partial(_at_share, flank.at, share) for share in (0.0, 1.0))
    bands = [
        _land(_along_axis(outer, 0.0), flank), flank,
        replace(_land(_along_axis(inner, body.web, down=True), flank), name="inside", sharp=True),
    ]
    bands = _with_free(bands, free)
    surface = banded(bands, body.track.knots())
    body.check((surface.edge(1), surface.edge(2)))
    return _closed(body.name, surface, bands, body.track, (0.0, body.web), body.blank, tolerance, free)


class Columns:
    """Columns of a track, those asked for together made at once."""

    def __init__(self, track: Track) -> None:
        self._track = track
        self._known: list[tuple[Floats, Column]] = []

    def prepare(self, angles: Sequence[Sequence[Floats]]) -> None:
        """The columns at several arrays of cam angles, by sides: each has figures of its own."""
        self._known = []
        if sum(len(phi) for side in angles for phi in side) <= BATCH:
            self._made(angles)
            return
        for side in angles:
            batch: list[Floats] = []
            for number, phi in enumerate(side, 1):
                batch.append(phi)
                if number == len(side) or sum(map(len, batch)) + len(side[number]) > BATCH:
                    self._made([batch])
                    batch = []

    def _made(self, sides: Sequence[Sequence[Floats]]) -> None:
        """Columns of several sides, whose poses are made at once."""
        if len({id(phi) for side in sides for phi in side}) == 1:
            column = Column(self._track, sides[0][0])
            self._known.append((sides[0][0], column))
            return
        angles = [np.concatenate(side) for side in sides]
        pose = self._track.pose(np.concatenate(angles), 1)
        start = 0
        for side, phi in zip(sides, angles):
            whole = Column(self._track, phi, pose.between(start, start + len(phi)))
            start += len(phi)
            ends = [0, *accumulate(map(len, side))]
            self._known += [(each, whole.between(low, high)) for each, low, high in zip(side, ends, ends[1:])]

    def at(self, phi: Floats) -> Column:
        """The columns at cam angles (n,)."""
        for known, column in self._known:
            if known is phi:
                return column
        return Column(self._track, phi)

    def points(self, band: Callable[[Column, Floats], Floats], phi: Floats, u: Floats) -> Floats:
        """Points (3, n, m) of a band of a cross-section."""
        return band(self.at(phi), u)


def _land(at: Surface, beside: Band) -> Band:
    """A cylinder beside a band of the same columns."""
    return Band("land", at, beside.tolerance, source=beside.source, side=beside.side)


def _halves(band: Band, even: tuple[bool, bool]) -> list[Band]:
    """Both halves of a band, to have columns of their own; which of them share those with their edges."""

    def half(start: float, phi: Floats, u: Floats) -> Floats:
        return band.at(phi, start + 0.5 * u)

    return [
        replace(band, at=partial(half, start), even=own, sharp=band.sharp and not start)
        for start, own in zip((0.0, 0.5), even)
    ]


def _along_axis(edge: Edge, z: float, down: bool = False) -> Surface:
    """The cylinder straight along Z from the ring at height z to an edge, or down from the edge to the ring."""

    def at(phi: Floats, u: Floats) -> Floats:
        x = edge(phi)
        height = z + (x[2] - z) * (1.0 - u if down else u)
        return np.stack([np.broadcast_to(x[0], u.shape), np.broadcast_to(x[1], u.shape), height])

    return at


def _between(start: Edge, stop: Edge, radius: float) -> Surface:
    """A cylinder of a radius from one edge on it to another, straight in angle and z."""

    def at(phi: Floats, u: Floats) -> Floats:
        return on_cylinder(start(phi)[:, :, 0], stop(phi)[:, :, 0], radius, u)

    return at


def _at_share(at: Surface, share: float, phi: Floats) -> Floats:
    """One row (3, n, 1) of a band."""
    return at(phi, np.full((len(phi), 1), share))


def _closed(
    name: str, surface: Banded, bands: Sequence[Band], track: Track, ends: tuple[float, float], blank: Blank,
    tolerance: float, free: float | None,
) -> Solid:  # fmt: skip
    """Close bands that run once round the axis, from the lower end ring to the upper one, into a solid."""
    builder, inward = Builder(), track.sense > 0
    builder.add(np.ascontiguousarray(surface.points.T))
    faces = surface.faces[:, ::-1] if inward else surface.faces
    builder.labelled(faces, surface.band, [band.name for band in bands])
    bottom, top = surface.edges[0], surface.edges[-1]
    if inward:
        bottom, top = bottom[::-1], top[::-1]
    bored = close_ends(builder, bottom, top, ends[0], ends[1], blank.bore, free or tolerance)
    errors = [(band.name, error) for band, error in zip(bands, surface.errors)]
    error, free_error = stated([*errors, ("bore", bored)], free)
    return Solid(name, builder.mesh(), error, "direct", 0 if blank.bore is None else 1, free_error)
