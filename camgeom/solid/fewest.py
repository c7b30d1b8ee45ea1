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

from camgeom.errors import DesignError, NotConverged
from camgeom.maths import TURN, Floats
from camgeom.maths.banded import Band, Banded, banded
from camgeom.maths.sampling import Strip, subdivided_knots
from camgeom.solid import TOUCHED, Part, Solid
from camgeom.solid.bell import NAMES, GroovedRing
from camgeom.solid.cut import IndexingCut
from camgeom.solid.drum import EndFaceRing, GroovedCylinder, RibbedCylinder, refuse_turned
from camgeom.solid.grooves import GroovedDrum
from camgeom.solid.lands import NotOneSurface
from camgeom.solid.round import Check, EndRing, Meshed, Round, Run, closed, meshed, with_free
from camgeom.solid.stitch import Errors, GrooveFacets, TurretSurface
from camgeom.track import Track
from camgeom.track.column import Column
from camgeom.track.section import CrossSection

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


def fewest(part: Part, tolerance: float, free: float | None = None) -> Solid:
    """A drum's, an end face's or an indexing cam's body with the fewest triangles; any other one as it makes itself.

    free  mm, tolerance of the faces that no follower touches; None: the same
    """
    if isinstance(part, IndexingCut):
        return _turret(part, tolerance, free)
    if isinstance(part, GroovedCylinder):
        return _cornered(part, tolerance, free)
    body = round_body(part, tolerance)
    if body is None:
        return part.solid(tolerance, free)
    return closed(body, meshed(body, tolerance, free), tolerance, free)


def round_body(part: Part, tolerance: float) -> Round | None:
    """A drum's or an end face's surfaces round the axis; None of any other body."""
    if isinstance(part, GroovedCylinder):
        return _drum(part, (part,), tolerance, partial(_check_groove, part))
    if isinstance(part, GroovedDrum):
        part.refuse_overlap()
        return _drum(part, part.ordered, tolerance, _check_grooves)
    if isinstance(part, RibbedCylinder):
        return _ribbed(part, tolerance)
    if isinstance(part, EndFaceRing):
        return _end_face(part, tolerance)
    return _bell(part, tolerance) if isinstance(part, GroovedRing) else None


def _turret(body: IndexingCut, tolerance: float, free: float | None) -> Solid:
    """Of both forms the one with fewer triangles: lands between long chords of rims may take more.

    Raises NotOneSurface where grooves and lands are not one, which a boolean cuts with no fewer triangles.
    """
    plain = body.direct(tolerance, free)
    try:
        few = body.direct(tolerance, free, mesher=turret_grooves)
    except (NotOneSurface, NotConverged, DesignError):
        # A groove is meshed to a little beyond the body's ends, where its flank may have come to an end of its own.
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
        beyond = partial(_rim_steps, surface, RIM * (free or tolerance))
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
    return with_free(own, tolerance, free)


def _rim_steps(surface: TurretSurface, sag: float, phi: Floats, rims: Floats) -> Floats:
    """Longest steps (2, n) of a groove's rims (2, 3, n) at cam angles (n,), rad, for lands with a sag, mm."""
    found = []
    for rim in rims:
        x, w = surface.unrolled(rim, phi)
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


def _cornered(body: GroovedCylinder, tolerance: float, free: float | None) -> Solid:
    """Raises DesignError where the topology is not that of a closed groove inside the cylinder."""
    shape = round_body(body, tolerance)
    assert shape is not None

    def feet(made: Meshed) -> tuple[Floats, Floats]:
        (run,) = made.runs
        low, high = (run.phi[run.edges[b]] for b in (1, -2))
        return np.append(low, low[0] + TURN), np.append(high, high[0] + TURN)

    made, sag = body.cornered(partial(meshed, shape), feet, tolerance, free)
    made = replace(made, errors=[(name, max(error, sag)) for name, error in made.errors])
    return closed(shape, made, tolerance, free)


def _check_groove(body: GroovedCylinder, runs: Sequence[Banded]) -> None:
    (run,) = runs
    body.check((run.edge(0), run.edge(-1)))
    body.check_within(np.concatenate([run.edge(b)[2] for b in range(len(run.edges))]))


def _check_grooves(runs: Sequence[Banded]) -> None:
    refuse_turned([run.edge(b) for run in runs for b in range(len(run.edges))], "groove's")


def _drum(
    body: GroovedCylinder | GroovedDrum, grooves: Sequence[GroovedCylinder], tolerance: float, check: Check
) -> Round:
    """Lands and grooves by turns, each of these by the knots of its own motion."""
    first = grooves[0]
    low, high = (radius or first.radius for radius in first.end_radii)
    runs = [Run(_groove(groove, tolerance), groove.track.knots()) for groove in grooves]
    pieces: tuple[EndRing | Run, ...] = (EndRing(low, 0.0), *runs, EndRing(high, body.length))
    return Round(body.name, body.blank, first.track.sense > 0, pieces, ("land",) * (len(runs) + 1), check)


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
    if len(own) > 2:
        foot, floor, toe = own[1:4]
        if section.foot_name == "edge":
            # What sweeps from flank to floor has no width where the follower rests: the flank's foot stays.
            foot, toe = replace(foot, shrinks=0), replace(toe, shrinks=1)
        own[1:4] = [*_halves(foot, (False, True)), floor, *_halves(toe, (True, False))]
    return own


def _ribbed(body: RibbedCylinder, tolerance: float) -> Round:
    low, high = Columns(body.lower), Columns(body.upper)
    up, above = (partial(_rib_wall, body, columns, side) for columns, side in zip((low, high), body.sides))

    def down(phi: Floats, u: Floats) -> Floats:
        return above(phi, 1.0 - u)

    rising = Band("flank", up, tolerance, even=True, source=low)
    falling = replace(rising, at=down, source=high)
    pieces = (
        EndRing(body.base, 0.0), Run([rising], body.lower.knots()), Run([falling], body.upper.knots()),
        EndRing(body.base, body.length),
    )  # fmt: skip
    check = partial(_check_sides, body.check)
    return Round(body.name, body.blank, body.lower.sense > 0, pieces, ("base", "land", "base"), check)


def _check_sides(check: Callable[[Sequence[Floats]], None], runs: Sequence[Banded]) -> None:
    """The edges of each run's one band."""
    check([run.edge(b) for run in runs for b in (0, 1)])


def _rib_wall(body: RibbedCylinder, columns: Columns, side: float, phi: Floats, u: Floats) -> Floats:
    return body.wall(columns.at(phi), side, u)


def _end_face(body: EndFaceRing, tolerance: float) -> Round:
    columns = Columns(body.track)
    flank = Band("flank", partial(columns.points, body.face), tolerance, even=True, source=columns)
    pieces = EndRing(body.outer, 0.0), Run([flank], body.track.knots()), EndRing(body.inner, body.web)
    check = partial(_check_sides, body.check)
    return Round(body.name, body.blank, body.track.sense > 0, pieces, ("land", "inside"), check)


def _bell(body: GroovedRing, tolerance: float) -> Round:
    columns, (low, high), knots = Columns(body.track), body.sides, body.track.knots()

    def wall(side: float, column: Column, share: Floats) -> Floats:
        return body.wall(column, side, share)

    falling = Band("flank", partial(columns.points, partial(wall, high)), tolerance, even=True, source=columns)
    out = replace(falling, at=partial(columns.points, partial(wall, low)))
    rising = replace(out, at=lambda phi, u: out.at(phi, 1.0 - u))
    pieces = (
        EndRing(body.outer, 0.0), EndRing(body.outer, body.length), EndRing(body.inner, body.length),
        Run([falling], knots), Run([rising], knots), EndRing(body.inner, body.web),
    )  # fmt: skip
    lands, check = tuple(name for name in NAMES if name != TOUCHED), partial(_check_sides, body.check)
    return Round(body.name, body.blank, body.track.sense > 0, pieces, lands, check)


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


def _halves(band: Band, even: tuple[bool, bool]) -> list[Band]:
    """Both halves of a band, to have columns of their own; which of them share those with their edges."""

    def half(start: float, phi: Floats, u: Floats) -> Floats:
        return band.at(phi, start + 0.5 * u)

    return [
        replace(band, at=partial(half, start), even=own, sharp=band.sharp and not start)
        for start, own in zip((0.0, 0.5), even)
    ]
