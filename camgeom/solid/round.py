"""Surfaces round the axis: rings, bands that are meshed together, and lands from each to the next, as one closed mesh.

A land is a cylinder, a cone or a plane about the axis, which chords along the axis lie in: it takes no vertices but
those of its two edges, each of which has steps of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import field, replace
from functools import partial
from itertools import pairwise
from math import ceil

import numpy as np

from camgeom.immutable import immutable
from camgeom.maths import TURN, Floats
from camgeom.maths.banded import Band, Banded, Index, banded
from camgeom.solid import TOUCHED, Solid, stated
from camgeom.solid.blank import Blank, close_ends
from camgeom.solid.builder import Builder

AIM = 0.97
"""share of the tolerance to which lands beside bands are aimed at: between the angles that are looked at edges may turn
faster"""
WIDEST = 0.5
"""rad; widest facet of a land"""
SAME = 1e-9
"""share of a turn that is none"""
Check = Callable[[Sequence[Banded]], None]
"""of what bands have become: raises DesignError where they cannot be joined"""


@immutable
class EndRing:
    """A circle about the axis, its radius and height in mm."""

    radius: float
    z: float


@immutable
class Run:
    """Bands beside each other round the axis, by the knots (k,) of one motion, rad."""

    bands: Sequence[Band]
    knots: Floats


@immutable
class Round:
    """Rings and runs round the axis, from the lower end to the upper one; between each two of them a named land, on a
    cylinder, a cone or a plane about the axis.

    clockwise  whether azimuths fall while cam angles rise
    check      of what the runs have become
    """

    name: str
    blank: Blank
    clockwise: bool
    pieces: tuple[EndRing | Run, ...]
    lands: tuple[str, ...]
    check: Check

    @property
    def runs(self) -> list[Run]:
        """Those of the pieces that are bands."""
        return [piece for piece in self.pieces if isinstance(piece, Run)]


@immutable
class Piece:
    """Points (3, v) of a ring or a run, the numbers of those on its first edge and on its last; the run's bands."""

    points: Floats
    low: Index
    high: Index
    names: list[str] = field(default_factory=list)
    run: Banded | None = None

    def edge(self, last: bool) -> Floats:
        """Points (3, n) of the first edge or the last, by rising cam angle."""
        return self.points[:, self.high if last else self.low]


@immutable
class Meshed:
    """A `Round` within a tolerance: its pieces, the corners (f, 3) of its lands, see `land`, and the chord errors of
    all surfaces, mm."""

    pieces: list[Piece]
    lands: list[tuple[str, Index]]
    errors: list[tuple[str, float]]

    @property
    def runs(self) -> list[Banded]:
        """Those of the pieces that are bands."""
        return [piece.run for piece in self.pieces if piece.run is not None]


def meshed(body: Round, tolerance: float, free: float | None) -> Meshed:
    """The body within the tolerance. Raises DesignError where its runs cannot be joined."""
    most, aim = free or tolerance, AIM
    radii = [piece.radius if isinstance(piece, EndRing) else 0.0 for piece in body.pieces]
    while True:
        made: dict[int, Piece] = {}
        for k, piece in enumerate(body.pieces):
            if isinstance(piece, Run):
                longest = partial(land_steps, (radii[k - 1], radii[k + 1]), aim * most)
                run = banded(with_free(piece.bands, tolerance, free), piece.knots, longest=longest, steady=True)
                made[k] = Piece(run.points, run.edges[0], run.edges[-1], [band.name for band in piece.bands], run)
        body.check([piece.run for piece in made.values() if piece.run is not None])
        for k, piece in enumerate(body.pieces):
            if isinstance(piece, EndRing):
                beside = [made[at].edge(last) for at, last in ((k - 1, True), (k + 1, False)) if at in made]
                radius = max([piece.radius, *(float(np.hypot(x[0], x[1]).max()) for x in beside)])
                made[k] = _circle(piece, most, radius, body.clockwise)
        pieces = [made[k] for k in range(len(made))]
        lands = [land(one.edge(True), other.edge(False), body.clockwise) for one, other in pairwise(pieces)]
        sag = max(sag for _, sag in lands)
        if sag <= most:
            break
        aim *= AIM * most / sag
    errors = [(name, error) for one in pieces if one.run for name, error in zip(one.names, one.run.errors)]
    errors += [(name, sag) for name, (_, sag) in zip(body.lands, lands)]
    return Meshed(pieces, list(zip(body.lands, (corner for corner, _ in lands))), errors)


def land_steps(radii: tuple[float, float], sag: float, phi: Floats, edges: Floats) -> Floats:
    """Longest steps (2, n) of a run's outer edges (2, 3, n) at cam angles (n,), rad, for lands with a sag, mm.

    radii  of rings beyond the lands, mm
    """
    speed = np.gradient(np.unwrap(np.arctan2(edges[:, 1], edges[:, 0])), phi, axis=1)
    radius = np.maximum(np.hypot(edges[:, 0], edges[:, 1]), np.reshape(radii, (2, 1)))
    return np.asarray(_widest(sag, radius) / np.abs(speed))


def _widest(sag: float, radius: Floats | float) -> Floats:
    """Azimuth, rad, between points at radii, mm, whose chord is off the cylinder through them by a sag, mm."""
    return np.asarray(np.minimum(4.0 * np.arcsin(np.sqrt(np.minimum(0.5 * sag / radius, 1.0))), WIDEST))


def _circle(ring: EndRing, sag: float, radius: float, clockwise: bool) -> Piece:
    """The vertices of a ring, evenly round it, for a sag at a radius of the land beside it, mm."""
    number = np.arange(ceil(TURN / float(_widest(sag, radius)) * (1.0 + SAME)))
    angle = number * ((-TURN if clockwise else TURN) / len(number))
    points = np.stack([ring.radius * np.cos(angle), ring.radius * np.sin(angle), np.full(len(number), ring.z)])
    return Piece(points, number, number)


def land(low: Floats, high: Floats, clockwise: bool) -> tuple[Index, float]:
    """Triangles between two edges (3, n) and (3, m) round the axis, and the most that one is off the land, mm.

    In order of the azimuth: each link of an edge is joined to the other edge's last vertex before the link's end. So no
    triangle is wider than the widest link, and there are as many as links, the fewest that are possible. Of points
    within an azimuth w none is nearer to the axis than cos(w / 2) times as far as its land is at that height.
    Corners (n + m, 3): numbers of the lower edge, and n more of the upper one.
    """
    sense, n, m = (-1.0 if clockwise else 1.0), low.shape[1], high.shape[1]
    a, b = (np.unwrap(np.arctan2(sense * x[1], x[0])) for x in (low, high))
    b = (b - a[0]) % TURN
    a, first = a - a[0], int(np.argmin(b))
    b = np.roll(b, -first)
    a_end, b_end = np.append(a[1:], TURN), np.append(b[1:], b[0] + TURN)
    above = np.searchsorted(b, a_end) - 1
    below = np.searchsorted(a, b_end % TURN, side="right") - 1
    # Before the first vertex of the upper edge is its last one, a turn less.
    wide = a_end - np.minimum(a, b[above] - np.where(above < 0, TURN, 0.0))
    width = b_end - np.minimum(b, a[below] + np.where(b_end >= TURN, TURN, 0.0))
    i, j = np.arange(n), np.arange(m)
    corner = np.concatenate(
        [np.stack([i, (i + 1) % n, n + above % m], axis=1), np.stack([below, n + (j + 1) % m, n + j], axis=1)]
    )
    upper = corner >= n
    corner[upper] = n + (corner[upper] - n + first) % m
    if np.ptp(low[2]) == 0.0 and np.all(high[2] == low[2, 0]):
        return corner, 0.0
    radius = np.hypot(*np.concatenate([low[:2], high[:2]], axis=1))[corner].max(axis=1)
    return corner, float((2.0 * radius * np.sin(0.25 * np.append(wide, width)) ** 2).max())


def closed(body: Round, made: Meshed, tolerance: float, free: float | None) -> Solid:
    """The body with its ends and its bore."""
    builder, rings = Builder(), []
    for piece in made.pieces:
        start = builder.add(np.ascontiguousarray(piece.points.T))[0]
        rings.append((start + piece.low, start + piece.high))
        if piece.run is not None:
            faces = piece.run.faces + np.int32(start)
            builder.labelled(faces[:, ::-1] if body.clockwise else faces, piece.run.band, piece.names)
    for (land, corner), (_, below), (above, _) in zip(made.lands, rings, rings[1:]):
        builder.faces(np.concatenate([below, above])[corner[:, ::-1] if body.clockwise else corner], land)
    ends = rings[0][0], rings[-1][1]
    bottom, top = (ring[::-1] for ring in ends) if body.clockwise else ends
    low, high = (float(made.pieces[k].points[2, 0]) for k in (0, -1))
    bored = close_ends(builder, bottom, top, low, high, body.blank.bore, free or tolerance)
    error, free_error = stated([*made.errors, ("bore", bored)], free)
    return Solid(body.name, builder.mesh(), error, "direct", 0 if body.blank.bore is None else 1, free_error)


def with_free(bands: Sequence[Band], tolerance: float, free: float | None) -> list[Band]:
    """The bands with a tolerance, and another one of those that no follower touches."""
    return [replace(band, tolerance=tolerance if free is None or band.name == TOUCHED else free) for band in bands]
