"""Grooves and lands of an indexing cam as one surface, cut off at both ends and closed to a solid.

Round an indexing cam the grooves of the turret's rollers lie side by side, with lands of the blank's outside between
them: at one cam angle the section of groove k, the land up to groove k + 1, its section and so on. One turn on, each
groove stands where one some places further on stood, so that all turns fit together where their knots do. Grooves are
carried on beyond the blank's ends, where the finished surface is cut off.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import ceil, cos

import numpy as np
import numpy.typing as npt

from camgeom.errors import NotConverged
from camgeom.immutable import immutable
from camgeom.maths import TURN, Floats
from camgeom.maths.frozen import cached_property
from camgeom.maths.mesh import clip, open_loops
from camgeom.maths.sampling import Cells, Counts, Strip, angles, columns_over, middle_angles, sample_surface, strip_sags
from camgeom.solid import ENDS_CUT, TOUCHED, Solid, eased, stated
from camgeom.solid.blank import Blank, bore_walls, chord_step
from camgeom.solid.builder import Builder, Index, cell_faces, filled
from camgeom.solid.ends import LAND, Addresses, EndCut
from camgeom.solid.lands import Land, LandSurface, NotOneSurface, Rim, land_net, land_of
from camgeom.track import Track
from camgeom.track.column import Column
from camgeom.track.section import CrossSection

Labels = npt.NDArray[np.uint8]
CUTS = (0.95, 0.8, 0.6)
"""shares of its tolerance that a facet is kept to which an end cuts, one attempt after the other"""
LOST = 1.4
"""times its tolerance that such a facet may be off at first; beyond, what is then made finer has no fewer triangles"""
ON_PLANE = 1e-3
"""share of the tolerance within which a vertex beside an end plane is laid on it"""


@immutable(eq=True)
class Between:
    """A land, from the groove below it (in w) to the one above, whose columns stand `offset` rounds on.

    Either is None where there is no groove, only the end of the cam.
    """

    lower: int | None
    upper: int | None
    offset: int


@immutable
class TurretSurface:
    """Grooves and lands of an indexing cam between two heights, mm; sections in order of their tracks' shift.

    cut  share of its tolerance that a facet is kept to which an end cuts: what is left of it may be off by more
    """

    sections: tuple[CrossSection, ...]
    land: LandSurface
    low: float
    high: float
    cut: float = 1.0

    @property
    def names(self) -> tuple[str, ...]:
        """Face-group names of the bands of a groove."""
        return self.sections[0].names

    @property
    def most(self) -> Counts:
        """Most cells across each band of a groove, and across a land while knots are chosen."""
        return (*self.sections[0].max_counts, 1)

    @property
    def sense(self) -> float:
        """Turning of the cam."""
        return self.sections[0].track.sense

    @property
    def closed(self) -> bool:
        """True where every groove closes on itself after one turn."""
        return self.sections[0].track.closed

    @cached_property
    def _middle(self) -> tuple[float, float]:
        """psi + sense * phi of a groove's middle, and the sign of the step in w from its first row to its last."""
        track = self.sections[0].track
        phi = 0.5 * (track.span[0] + track.span[1])
        rows = self.sections[0].rows(Column(track, np.array([phi])), (1,) * len(self.names))[:, 0]
        centre, w = rows.mean(axis=1), self.land.along(rows)
        return float(np.arctan2(centre[1], centre[0]) + self.sense * phi), float(np.sign(w[-1] - w[0]))

    @cached_property
    def lands(self) -> tuple[Between, ...]:
        """The lands, each between two grooves. Raises NotOneSurface where the tracks are not those of one turret."""
        tracks = [section.track for section in self.sections]
        first, count = tracks[0], len(tracks)
        gain = first.factor * first.program.advance
        shifts = [t.shift for t in tracks]
        pitch = np.diff(shifts) if self.closed else np.diff([*shifts, shifts[0] + abs(gain)])
        if not all(_alike(first, t) for t in tracks) or (len(pitch) and (pitch.min() <= 0.0 or np.ptp(pitch) > 1e-9)):
            raise NotOneSurface("the tracks are not those of one turret")
        order = list(range(count)) if self._rising > 0.0 else list(range(count))[::-1]
        inner = [Between(a, b, 0) for a, b in zip(order[:-1], order[1:])]
        if self.closed:
            return (Between(None, order[0], 0), *inner, Between(order[-1], None, 0))
        return (*inner, Between(order[-1], order[0], 1 if gain * self._rising > 0.0 else -1))

    @property
    def _rising(self) -> float:
        """+1 where w grows with the turret's angle, else -1."""
        track = self.sections[0].track
        at = np.array(track.anchor) + np.mean(track.contact) * np.array(track.axis)
        return float(np.sign(track.joint.velocity(at[:, None], np.ones(1, dtype=complex))[2, 0]))

    @cached_property
    def ends(self) -> tuple[float, float]:
        """w at the cam's two ends."""
        return self.land.at_height(self.low), self.land.at_height(self.high)

    def strips(self, theta: Floats, counts: Counts) -> list[Strip]:
        """The grooves, then of each one both edges unrolled, as a strip for the sag of the lands along them."""
        bands, found = tuple(range(len(counts))), []
        for section in self.sections:
            first, last = columns_over(theta, *section.track.span)
            phi = angles(theta, np.arange(first, last + 1))
            found.append(Strip(first, bands[:-1], section.rows(Column(section.track, phi), counts[:-1])))
        for strip in found[: len(self.sections)]:
            phi = self.angles(strip, theta)
            edges = [self.unrolled(strip.corner[:, :, row], phi) for row in (0, -1)]
            corner = np.stack([np.stack([x, w, w]) for x, w in edges], axis=2)
            found.append(Strip(strip.first, bands[-1:], corner))
        return found

    def sags(self, theta: Floats, counts: Counts, strips: list[Strip], chosen: list[Index]) -> list[Cells]:
        """Grooves as measured; of the lands the chords along both edges of each groove."""
        doubled, found, grooves = tuple(2 * c for c in counts[:-1]), [], len(self.sections)
        for section, strip, at in zip(self.sections, strips, chosen):
            phi = middle_angles(theta, strip.first + at)
            found.append(strip_sags(strip, at, section.rows(Column(section.track, phi), doubled), self.low, self.high))
        for strip, at in zip(strips[grooves:], chosen[grooves:]):
            start, stop = strip.corner[:, at], strip.corner[:, at + 1]
            on = (np.minimum(start[1], stop[1]) < self.ends[1]) & (np.maximum(start[1], stop[1]) > self.ends[0])
            sag = on * self.land.sag(stop[0] - start[0], stop[1] - start[1], 0.5 * (start[1] + stop[1]))
            a = 8.0 * sag.max(axis=1)[:, None]
            found.append(Cells(a, np.zeros_like(a), np.zeros_like(a)))
        return found

    def unrolled(self, points: Floats, phi: Floats) -> tuple[Floats, Floats]:
        """x (n,) and w of points (3, n) of a groove at cam angles: x = phi - sense psi, psi the polar angle from the
        groove's middle."""
        psi = np.arctan2(points[1], points[0]) + self.sense * phi
        return phi - self.sense * ((psi - self._middle[0] + np.pi) % TURN - np.pi), self.land.along(points)

    def points(self, x: Floats, w: Floats) -> Floats:
        """Points (3, ...) on the land at unrolled x and w."""
        return self.land.points(self._middle[0] - self.sense * x, w)

    def kept(self, corners: Floats) -> Floats:
        """Share (f,) of its tolerance that a facet with these corners (3, 3, f) is kept to."""
        low, high = corners[2].min(axis=0), corners[2].max(axis=0)
        cut = [(low < end) & (high > end) for end in (self.low, self.high)]
        return np.where(cut[0] | cut[1], self.cut, 1.0)

    def is_last(self, upper: bool) -> bool:
        """Whether a groove's upper side, or its lower one, is its last row."""
        return upper == (self._middle[1] > 0.0)

    def _rim(
        self, strip: Strip, upper: bool, theta: Floats, offset: int, share: float, counts: Counts
    ) -> tuple[Floats, Floats]:
        """x and w of one side of a groove at a share of its depth (counts: cells of its bands).

        upper  the side with the greater w; offset: rounds by which the groove stands ahead
        """
        row = -1 - round(share * counts[-1]) if self.is_last(upper) else round(share * counts[0])
        x, w = self.unrolled(strip.corner[:, :, row], self.angles(strip, theta))
        return x - TURN * offset, w

    @staticmethod
    def angles(strip: Strip, theta: Floats) -> Floats:
        """Cam angles of a strip's columns, rad."""
        return angles(theta, strip.first + np.arange(strip.cells + 1))

    @property
    def outward(self) -> tuple[bool, bool]:
        """Whether faces turning from columns to rows of a groove, and from x to w, look outward."""
        return self.sense * self._middle[1] < 0.0, self.sense < 0.0

    def check(self, theta: Floats, grooves: list[Strip], counts: Counts) -> None:
        """Raise NotOneSurface unless rims keep their order all round, at several depths: no two grooves touch."""
        for share in (0.0, 0.5, 1.0):
            for between in self.lands:
                if between.lower is None or between.upper is None:
                    continue
                low = self._rim(grooves[between.lower], True, theta, 0, share, counts)
                high = self._rim(grooves[between.upper], False, theta, between.offset, share, counts)
                self._ordered(low, high)
            for strip in grooves if share < 1.0 else ():
                rims = [self._rim(strip, upper, theta, 0, share, counts) for upper in (False, True)]
                self._ordered(rims[0], rims[1])

    def _ordered(self, low: tuple[Floats, Floats], high: tuple[Floats, Floats]) -> None:
        """Raise NotOneSurface where, within the cam, a rim turns back in x or the lower is not below the upper."""
        for x, w in (low, high):
            on = (np.minimum(w[1:], w[:-1]) < self.ends[1]) & (np.maximum(w[1:], w[:-1]) > self.ends[0])
            if np.any(np.diff(x)[on] <= 0.0):
                raise NotOneSurface("a groove's edge turns back")
        for (x, w), (other_x, other_w), sign in ((low, high, 1.0), (high, low, -1.0)):
            on = (w < self.ends[1]) & (w > self.ends[0]) & (x > other_x[0]) & (x < other_x[-1])
            if np.any(on) and float((sign * (np.interp(x[on], other_x, other_w) - w[on])).min()) <= 0.0:
                raise NotOneSurface("two grooves touch")


def _alike(a: Track, b: Track) -> bool:
    """True where two tracks differ by their shift and span only."""
    same = ("meridian", "joint", "anchor", "axis", "tip", "sense", "factor", "closed", "relief")
    return a.program is b.program and all(getattr(a, k) == getattr(b, k) for k in same)


@immutable
class GrooveFacets:
    """The facets of one groove.

    points  (3, v), faces (f, 3) outward, and the number (f,) of each one's band
    column, row  of every vertex (v,), real numbers: its cam angle among `angles`, and where it is across the bands, of
            `counts` rows each
    rims    numbers of the vertices of the first row and of the last, and their cam angles, rad, by rising angle; of a
            closed groove the first one once more at the end
    """

    points: Floats
    faces: Index
    band: Index
    column: Floats
    row: Floats
    angles: Floats
    counts: Counts
    rims: tuple[tuple[Index, Floats], tuple[Index, Floats]]


Errors = list[tuple[str, float]]
"""chord error, mm, of faces by their group's name"""
Mesher = Callable[[TurretSurface, Floats, float, float | None], tuple[list[GrooveFacets], Errors]]
"""grooves of a surface with knots of one round within a tolerance, mm, and a free one, and their errors"""


def gridded(
    surface: TurretSurface, knots: Floats, tolerance: float, free: float | None
) -> tuple[list[GrooveFacets], Errors]:
    """All grooves as one structured grid: the same steps round the cam, and rows, for all of them.

    Raises NotOneSurface where grooves touch.
    """
    ease = eased((*surface.names, "land"), tolerance, free)
    rounds = sample_surface(surface, knots, tolerance, surface.most, ease)
    counts, strips = rounds.counts[:-1], rounds.strips[: len(surface.sections)]
    surface.check(rounds.theta, strips, counts)
    bands = np.repeat(np.arange(len(counts)), counts)
    found = [
        _gridded(surface, strip, rising, counts, bands, surface.angles(strip, rounds.theta))
        for strip, rising in zip(strips, rounds.rising)
    ]
    errors = [(TOUCHED, rounds.errors[0])]
    return found, errors + [("floor", error) for error in rounds.errors[1:] if error is not None]


def _gridded(
    surface: TurretSurface, strip: Strip, rising: npt.NDArray[np.bool_], counts: Counts, bands: Index, phi: Floats
) -> GrooveFacets:
    """A strip's cells that reach between the cam's ends."""
    columns, rows = strip.corner.shape[1:]
    number = np.arange(columns * rows).reshape(columns, rows)
    if surface.closed:
        number[-1] = number[0]
    on = strip.within(surface.low, surface.high)
    p00, p10, p11, p01 = number[:-1, :-1][on], number[1:, :-1][on], number[1:, 1:][on], number[:-1, 1:][on]
    cells = cell_faces(p00, p10, p11, p01, rising[on], inward=not surface.outward[0])
    return GrooveFacets(
        strip.corner.reshape(3, -1), cells.reshape(-1, 3), np.repeat(np.broadcast_to(bands, on.shape)[on], 2),
        np.repeat(np.arange(float(columns)), rows), np.tile(np.arange(float(rows)), columns), phi, counts,
        ((number[:, 0], phi), (number[:, -1], phi)),
    )  # fmt: skip


def groove_solid(
    name: str,
    blank: Blank,
    edge: int,
    sections: tuple[CrossSection, ...],
    expected_genus: int,
    tolerance: float,
    straight: bool = False,
    free: float | None = None,
    mesher: Mesher = gridded,
) -> Solid:
    """A blank whose outline edge `edge` is cut by grooves; sections end on that edge's surface.

    straight  cut the facets at the cam's ends as they are, which is quicker and leaves the error there unmeasured
    free      mm, tolerance of all faces but flanks; None: the same
    Raises NotOneSurface where the topology is not that of separate grooves, NotConverged as the mesher does.
    """
    aim, wide = tolerance, free
    for cut in CUTS:
        solid = _groove_solid(name, blank, edge, sections, expected_genus, aim, straight, wide, mesher, cut)
        over = solid.chord_error / tolerance
        over_free = 0.0 if free is None or solid.free_error is None else solid.free_error / free
        if straight or max(over, over_free) <= 1.0:
            break
        if mesher is not gridded and max(over, over_free) > LOST:
            raise NotConverged(f"a facet at an end of the cam is off by {max(over, over_free):.3g} tolerances")
        # Facets at the cam's ends, whose cells were not measured as a whole.
        aim *= 0.985 / over if over > 1.0 else 1.0
        wide = wide and max(aim, wide * (0.985 / over_free if over_free > 1.0 else 1.0))
    return solid


def _groove_solid(
    name: str,
    blank: Blank,
    edge: int,
    sections: tuple[CrossSection, ...],
    expected_genus: int,
    tolerance: float,
    straight: bool,
    free: float | None,
    mesher: Mesher,
    cut_share: float,
) -> Solid:
    land = land_of(blank, edge)
    if land is None:
        raise NotOneSurface("the blank's outside is neither a cylinder nor a globoid")
    low, high = blank.outline[edge][1], blank.outline[edge + 1][1]
    surface = TurretSurface(sections, land, low, high, cut_share)
    knots = replace(sections[0].track, span=(0.0, TURN)).knots()
    near, room = ON_PLANE * tolerance, 1.0 - ON_PLANE
    grooves, errors = mesher(surface, knots, room * tolerance, free and room * free)
    whole, sag = stitched(surface, grooves, room * (free or tolerance))
    points, cut = whole.points, whole.crossing(low, high, near)
    faces, label = whole.faces[cut], whole.label[cut]
    ends = EndCut(sections, land, [groove.angles for groove in grooves], grooves[0].counts, surface.closed)
    at = whole.addresses
    fresh = np.zeros(len(points), dtype=bool)
    for height, sign in ((high, 1.0), (low, -1.0)):
        if straight:
            points[np.abs(points[:, 2] - height) < near, 2] = height
            points, faces, label = clip(points, faces, label, height, sign)
            continue
        points, at, moved = ends.laid(points, at, height, near)
        fresh[moved] = True
        points, at, faces, label = ends.clipped(points, at, faces, label, height, sign)
        fresh = np.append(fresh, np.ones(len(points) - len(fresh), dtype=bool))
    errors = [(group, error + near) for group, error in (*errors, ("land", sag))]
    if not straight:
        beside = fresh[faces].any(axis=1)
        for k, group in enumerate(whole.names):
            own = beside & (label == k)
            errors.append((group, ends.sag(points, at, faces[own], np.full(own.sum(), group == "land"))))
    builder = Builder()
    builder.add(points)
    for k, group in enumerate(whole.names):
        builder.faces(np.concatenate([whole.faces[~cut & (whole.label == k)], faces[label == k]]), group)
    errors.append(("bore", _close(builder, points, faces, blank, edge, free or tolerance)))
    error, free_error = stated(errors, free)
    return Solid(name, builder.mesh(), error, ENDS_CUT, expected_genus, free_error)


@immutable
class OpenSurface:
    """An open surface: points (v, 3) with their addresses, outward faces (f, 3), and the number (f,) of each one's
    name."""

    points: Floats
    addresses: Addresses
    faces: Index
    label: Labels
    names: tuple[str, ...]

    def crossing(self, low: float, high: float, near: float) -> npt.NDArray[np.bool_]:
        """Which faces reach to within `near` of the two heights, or beyond."""
        off = (self.points[:, 2] < low + near) | (self.points[:, 2] > high - near)
        return np.asarray(off[self.faces].any(axis=1))


def stitched(surface: TurretSurface, grooves: list[GrooveFacets], tolerance: float) -> tuple[OpenSurface, float]:
    """Grooves and lands as one surface that runs on beyond the cam's ends, and the largest sag of the lands, mm."""
    names = tuple(dict.fromkeys([*surface.names, "land"]))
    numbers = np.array([names.index(name) for name in surface.names], dtype=np.uint8)
    points = [groove.points for groove in grooves]
    starts = np.cumsum([0, *(x.shape[1] for x in points)])
    faces = [groove.faces + start for groove, start in zip(grooves, starts)]
    label = [numbers[groove.band] for groove in grooves]
    count, worst = int(starts[-1]), 0.0
    for between in surface.lands:
        rims = [
            None if k is None else _rim(surface, grooves[k], int(starts[k]), upper, offset)
            for k, upper, offset in ((between.lower, True, 0), (between.upper, False, between.offset))
        ]
        net = land_net(Land(surface.land, rims[0], rims[1], surface.ends, surface.closed), count, tolerance)
        points.append(surface.points(net.x, net.w))
        faces.append(net.faces if surface.outward[1] else net.faces[:, ::-1])
        label.append(np.full(len(net.faces), names.index("land"), dtype=np.uint8))
        count, worst = count + len(net.x), max(worst, net.sag)
    free = count - int(starts[-1])
    addresses = Addresses(
        np.concatenate([np.repeat(np.arange(len(grooves)), np.diff(starts)), np.full(free, LAND)]),
        np.concatenate([*(groove.column for groove in grooves), np.zeros(free)]),
        np.concatenate([*(groove.row for groove in grooves), np.zeros(free)]),
    )
    every = np.ascontiguousarray(np.concatenate(points, axis=1).T)
    return OpenSurface(every, addresses, np.concatenate(faces), np.concatenate(label), names), worst


def _rim(surface: TurretSurface, groove: GrooveFacets, start: int, upper: bool, offset: int) -> Rim:
    """One edge of a groove, whose vertices are numbered from `start` on, as the rim of a land."""
    number, phi = groove.rims[surface.is_last(upper)]
    x, w = surface.unrolled(groove.points[:, number], phi)
    return Rim(x - TURN * offset, w, start + number)


def _close(builder: Builder, points: Floats, faces: Index, blank: Blank, edge: int, tolerance: float) -> float:
    """Add the flat ends with hubs and bore; returns the chord error of these, mm."""
    outline, error = blank.outline, 0.0
    holes: tuple[Index | None, Index | None] = None, None
    if blank.bore is not None:
        error = blank.bore.sag(tolerance)
        holes = bore_walls(builder, blank.bore, outline[0][1], outline[-1][1], tolerance)[:2]
    for upper in (False, True):
        height = outline[edge + 1 if upper else edge][1]
        loops = open_loops(faces, points[:, 2] == height)
        if not loops:
            raise NotOneSurface("the surface does not end in simple loops at the cam's ends")
        # Faces run along their ends the other way round than the flat end that joins them.
        rings = [loop[::-1] if upper else loop for loop in loops]
        hub = _hub(builder, blank, edge, upper, tolerance)
        hole = holes[1 if upper else 0]
        if hub is None:
            flat(builder, rings, hole, upper)
        else:
            flat(builder, rings, hub[0], upper)
            flat(builder, [hub[1]], hole, upper)
            error = max(error, hub[2])
    return error


def _hub(
    builder: Builder, blank: Blank, edge: int, upper: bool, tolerance: float
) -> tuple[Index, Index, float] | None:
    """Add the walls of what the outline has beyond one end; its rings there and at its far side, and the chord error,
    mm; None for nothing."""
    outline = blank.outline[edge + 1 :] if upper else blank.outline[edge::-1]
    if len(outline) == 1:
        return None
    names = blank.names or ("land",) * (len(blank.outline) - 1)
    arcs = blank.arcs or (None,) * (len(blank.outline) - 1)
    beyond = slice(edge + 1, None) if upper else slice(edge - 1 if edge else None, None, -1)
    if outline[1][1] != outline[0][1] or any(arc is not None for arc in arcs[beyond]):
        raise NotOneSurface("the cam's end is not flat, or its hubs are not straight")
    largest = max(r for r, _ in outline[1:])
    parts = max(12, ceil(TURN / chord_step(largest, tolerance)))
    angle = TURN * np.arange(parts) / parts
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rings = [builder.add(np.column_stack([r * circle, np.full(parts, z)])) for r, z in outline[1:]]
    for near, far, group in zip(rings[:-1], rings[1:], names[beyond][1:]):
        builder.band(*((near, far) if upper else (far, near)), group)
    return rings[0], rings[-1], largest * (1.0 - cos(0.5 * TURN / parts))


def flat(builder: Builder, rings: list[Index], hole: Index | None, up: bool) -> None:
    """Add the flat face within rings of vertices (counter-clockwise, holes clockwise) less a counter-clockwise `hole`.

    Raises NotOneSurface where the rings cross.
    """
    every = [*rings, *([] if hole is None else [hole[::-1]])]
    triangles = filled([builder.points(ring)[:, :2] for ring in every])
    if triangles is None:
        raise NotOneSurface("the outlines of a flat end cross")
    faces = np.concatenate(every)[triangles]
    builder.faces(faces if up else faces[:, ::-1], "end")
