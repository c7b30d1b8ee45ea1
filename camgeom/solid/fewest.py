"""Drums, end faces and indexing cams with about the fewest triangles: rows and columns of bands follow the curvature.

The same bodies as `camgeom.solid.drum`, `grooves` and `stitch` mesh as one structured grid in less than half the time.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import accumulate
from math import ceil, sqrt

import numpy as np

from camgeom.errors import NotConverged
from camgeom.maths import Floats
from camgeom.maths.banded import Band, Banded, banded
from camgeom.maths.sampling import TURN, Strip, subdivided_knots
from camgeom.solid import TOUCHED, Part, Solid, stated
from camgeom.solid.bell import NAMES, GroovedRing
from camgeom.solid.blank import Blank, close_ends
from camgeom.solid.builder import Builder
from camgeom.solid.cut import IndexingCut
from camgeom.solid.drum import EndFaceRing, GroovedCylinder, RibbedCylinder, on_cylinder, refuse_turned
from camgeom.solid.grooves import GroovedDrum
from camgeom.solid.lands import NotOneSurface
from camgeom.solid.stitch import Errors, GrooveFacets, TurretSurface
from camgeom.track import Track
from camgeom.track.section import Column, CrossSection

BATCH = 16384
"""poses made at once: so many stay in the processor's cache"""
FEW = 2048
"""poses up to which what is made for all sides at once costs less than the calls that make each side its own"""
LOOKED = 24
"""columns between two knots at which an indexing cam's grooves are looked at before"""
FAR = 2.0
"""rad; two vertices of a groove that are further from each other are not of one facet"""
RIM = 0.5
"""share of the tolerance that a land may sag along a rim's chords, either way"""
SAME = 1e-9
"""difference of angles, rad, that are the same"""
Surface = Callable[[Floats, Floats], Floats]
"""points (3, n, m) at angles (n,) and ways across (n, m)"""
Edge = Callable[[Floats], Floats]
"""points (3, n, 1) at angles (n,)"""


def fewest(part: Part, tolerance: float, free: float | None = None) -> Solid:
    """A drum's, an end face's or an indexing cam's body with the fewest triangles; any other one as it makes itself.

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
    if isinstance(part, GroovedRing):
        return _bell(part, tolerance, free)
    if isinstance(part, IndexingCut):
        return _turret(part, tolerance, free)
    return part.solid(tolerance, free)


def _turret(body: IndexingCut, tolerance: float, free: float | None) -> Solid:
    """Of both forms the one with fewer triangles: lands between long chords of rims may take more.

    Raises NotOneSurface where grooves and lands are not one, which a boolean cuts with no fewer triangles.
    """
    plain = body.direct(tolerance, free)
    try:
        few = body.direct(tolerance, free, mesher=turret_grooves)
    except (NotOneSurface, NotConverged):
        return plain
    return few if few.chord_error <= tolerance and len(few.mesh.faces) < len(plain.mesh.faces) else plain


def turret_grooves(
    surface: TurretSurface, knots: Floats, tolerance: float, free: float | None
) -> tuple[list[GrooveFacets], Errors]:
    """Each groove of an indexing cam by its own bands. Raises NotOneSurface where grooves touch."""
    once = subdivided_knots(knots, LOOKED)
    counts = tuple(2 if name == TOUCHED else 1 for name in surface.names)
    strips = surface.strips(once, (*counts, 1))[: len(surface.sections)]
    surface.check(once, strips, counts)
    found: list[GrooveFacets] = []
    errors: Errors = []
    for section, strip in zip(surface.sections, strips):
        span = knots if surface.closed else _reach(surface, section.track, strip, once)
        bands = _turret_bands(section, tolerance, free)
        rims = partial(_at_share, bands[0].at, 0.0), partial(_at_share, bands[-1].at, 1.0)
        beyond = partial(_rim_steps, surface, rims, RIM * (free or tolerance))
        made = banded(bands, span, surface.closed, surface.kept, beyond)
        errors += [(band.name, error) for band, error in zip(bands, made.errors)]
        found.append(_turret_groove(surface, made, span, len(bands)))
    return found, errors


def _turret_bands(section: CrossSection, tolerance: float, free: float | None) -> list[Band]:
    """The bands of a groove, sharp where flank and floor meet and at the rims."""
    columns, plain = Columns(section.track), len(section.names) < 4
    own = [
        Band(name, partial(columns.points, at), tolerance, source=columns, side=side, sharp=plain or not side)
        for side, (name, at) in enumerate(zip(section.names, section.bands))
    ]
    return _with_free(own, free)


def _rim_steps(surface: TurretSurface, rims: tuple[Edge, Edge], sag: float, phi: Floats) -> Floats:
    """Longest steps (2, n) of a groove's rims at cam angles (n,), rad, for lands between them with a sag, mm."""
    found = []
    for rim in rims:
        x, w = surface.unrolled(rim(phi)[:, :, 0], phi)
        along, across = np.gradient(x, phi), np.gradient(w, phi)
        # A land bends one way along and the other way across: chords on either side of its rim sag by either.
        none = np.zeros_like(w)
        unit = surface.land.sag(along, none, w) + surface.land.sag(none, across, w)
        found.append(np.sqrt(sag / np.maximum(unit, 1e-300)))
    return np.stack(found)


def _reach(surface: TurretSurface, track: Track, strip: Strip, once: Floats) -> Floats:
    """Knots (k,) from a little before a groove comes in at one end of the cam until a little after it leaves."""
    phi = surface.angles(strip, once)
    on = np.flatnonzero(strip.within(surface.low, surface.high).any(axis=1))
    low, high = phi[max(0, on[0] - 1)], phi[min(len(phi) - 1, on[-1] + 2)]
    inner = track.knots()
    return np.concatenate([[low], inner[(inner > low + SAME) & (inner < high - SAME)], [high]])


def _turret_groove(surface: TurretSurface, made: Banded, span: Floats, bands: int) -> GrooveFacets:
    """What a groove's bands have become, between the cam's ends."""
    faces, band = made.faces, made.band
    z = made.points[2][faces]
    on = (z.min(axis=1) < surface.high) & (z.max(axis=1) > surface.low)
    faces, band = faces[on], band[on]
    parts = ceil((span[-1] - span[0]) / FAR)
    angles = np.linspace(span[0], span[-1], parts + 1)
    column = (made.phi - span[0]) * (parts / (span[-1] - span[0]))
    rims = []
    for edge in (made.edges[0], made.edges[-1]):
        phi = made.phi[edge]
        rims.append((np.append(edge, edge[0]), np.append(phi, phi[0] + TURN)) if surface.closed else (edge, phi))
    return GrooveFacets(
        made.points, faces if surface.outward[0] else faces[:, ::-1], band, column, made.row, angles,
        (1,) * bands, (rims[0], rims[1]),
    )  # fmt: skip


def _grooved(body: GroovedCylinder, tolerance: float, free: float | None) -> Solid:
    """Raises DesignError where the topology is not that of a closed groove inside the cylinder."""

    def mesh(fine: float, coarse: float | None) -> tuple[list[Band], Banded]:
        bands = _with_free(drum_bands((body,), fine), coarse)
        return bands, banded(bands, body.track.knots())

    def feet(made: tuple[list[Band], Banded]) -> tuple[Floats, Floats]:
        low, high = (made[1].phi[made[1].edges[b]] for b in (2, -3))
        return np.append(low, low[0] + TURN), np.append(high, high[0] + TURN)

    (bands, surface), sag = body.cornered(mesh, feet, tolerance, free)
    surface = replace(surface, errors=tuple(max(error, sag) for error in surface.errors))
    body.check((surface.edge(1), surface.edge(-2)))
    body.check_within(np.concatenate([surface.edge(b)[2] for b in range(1, len(bands))]))
    return _closed(body.name, surface, bands, body.track, (0.0, body.length), body.blank, tolerance, free)


def _grooves(body: GroovedDrum, tolerance: float, free: float | None) -> Solid:
    body.refuse_overlap()
    bands = _with_free(drum_bands(body.ordered, tolerance), free)
    surface = banded(bands, body.knots())
    refuse_turned([surface.edge(b) for b in range(1, len(bands))], "groove's")
    return _closed(body.name, surface, bands, body.ordered[0].track, (0.0, body.length), body.blank, tolerance, free)


def drum_bands(rings: Sequence[GroovedCylinder], tolerance: float) -> list[Band]:
    """Lands and grooves by turns, from the lower end ring to the upper one."""
    radius, length, (low, high) = rings[0].radius, rings[0].length, rings[0].end_radii
    grooves = [_groove(ring, tolerance) for ring in rings]
    bands = [_land(_along_axis(partial(_at_share, grooves[0][0].at, 0.0), 0.0, radius=low), grooves[0][0])]
    for number, own in enumerate(grooves, 1):
        bands += own
        edge = partial(_at_share, own[-1].at, 1.0)
        if number < len(grooves):
            at = _between(edge, partial(_at_share, grooves[number][0].at, 0.0), radius)
        else:
            at = _along_axis(edge, length, down=True, radius=high)
        bands.append(replace(_land(at, own[-1]), sharp=True))
    return bands


def _groove(ring: GroovedCylinder, tolerance: float) -> list[Band]:
    """Flank, foot, floor, foot and flank, the one with the smaller z first; each foot in two halves."""
    section, columns = ring.section, Columns(ring.track)
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


def _bell(body: GroovedRing, tolerance: float, free: float | None) -> Solid:
    """Raises DesignError where an edge turns back, or the groove leaves the ring or crosses itself."""
    columns, (low, high) = Columns(body.track), body.sides

    def wall(side: float, column: Column, share: Floats) -> Floats:
        return body.wall(column, side, share)

    falling = Band("flank", partial(columns.points, partial(wall, high)), tolerance, even=True, sharp=True,
                   source=columns)  # fmt: skip
    out = Band("flank", partial(columns.points, partial(wall, low)), tolerance, even=True, sharp=True, source=columns,
               side=1)  # fmt: skip
    rising = replace(out, at=lambda phi, u: out.at(phi, 1.0 - u))
    upper, lower = partial(_at_share, falling.at, 0.0), partial(_at_share, rising.at, 1.0)

    def rim(phi: Floats) -> Floats:
        return body.rim(upper(phi))

    def end(phi: Floats, u: Floats) -> Floats:
        start, stop = rim(phi), upper(phi).copy()
        stop[2] = body.length
        return start + (stop - start) * u

    floor = _between(partial(_at_share, falling.at, 1.0), partial(_at_share, rising.at, 0.0), body.floor)
    surfaces = (
        _along_axis(rim, 0.0), end, _along_axis(upper, body.length), falling.at, floor, rising.at,
        _along_axis(lower, body.web, down=True),
    )  # fmt: skip
    beside = (falling, falling, falling, falling, falling, rising, rising)
    bands = [
        own if name == TOUCHED else replace(_land(at, own), name=name, sharp=number > 0)
        for number, (name, at, own) in enumerate(zip(NAMES, surfaces, beside))
    ]
    bands = _with_free(bands, free)
    surface = banded(bands, body.track.knots())
    body.check([surface.edge(b) for b in (3, 4, 5, 6)])
    return _closed(body.name, surface, bands, body.track, (0.0, body.web), body.blank, tolerance, free)


class Columns:
    """Columns of a track, those asked for together made at once."""

    def __init__(self, track: Track) -> None:
        self._track = track
        self._known: list[tuple[Floats, Column]] = []

    def prepare(self, angles: Sequence[Sequence[Floats]]) -> None:
        """The columns at several arrays of cam angles, by sides: each has figures of its own."""
        self._known = []
        every = [phi for side in angles for phi in side]
        poses = sum(map(len, every))
        if poses <= BATCH:
            self._made([every] if poses <= FEW else angles)
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


def _along_axis(edge: Edge, z: float, down: bool = False, radius: float | None = None) -> Surface:
    """The cylinder straight along Z from the ring at height z to an edge, or down from the edge to the ring.

    radius  of a cone's ring, mm; None: of a cylinder's
    """

    def at(phi: Floats, u: Floats) -> Floats:
        x, share = edge(phi), 1.0 - u if down else u
        height = z + (x[2] - z) * share
        away = 1.0
        if radius is not None:
            ring = radius / np.sqrt(x[0] * x[0] + x[1] * x[1])
            away = ring + (1.0 - ring) * share
        return np.stack([np.broadcast_to(x[0] * away, u.shape), np.broadcast_to(x[1] * away, u.shape), height])

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
