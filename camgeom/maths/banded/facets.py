"""Triangles of bands side by side, measured on their true surfaces and split until they are within the tolerance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import reduce
from typing import Protocol, TypeVar

import numpy as np
import numpy.typing as npt

from camgeom.errors import NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.sampling import patch_sag
from camgeom.maths.surface import cross, dot

Index = npt.NDArray[np.int64]
Corners = npt.NDArray[np.int32]
Mask = npt.NDArray[np.bool_]
Kind = TypeVar("Kind", bound=np.generic)

NEXT, AFTER = [1, 2, 0], [2, 0, 1]
"""corners after the corners of a triangle, and after these"""
MET = 0.985
"""share of the tolerance to which measured sags are kept: aside of the middles a facet was off by up to 0.5 % more"""
ASIDE, MOST = 4.0, 3.0
"""times the square of the share of a facet's height by which the surface in the middles of its edges runs aside of
them: so much more than along the normal there a facet may be off, and at most so many times (measured)"""
STEPS = 5
"""of Newton's method for it, the first included"""
TOLD, TRIES = 0.92, 2
"""share of the room above which what the patch says is near is held to the true surface, at so many points at most:
beside thin facets the patch was short by up to 2.7 %, of a rim in steep motion by 10 %"""
BEYOND = 100.0
"""sides from a facet beyond which nothing of its patch is looked for"""
ROUNDS = 24
"""of splitting edges: beside a root as sharp as the tolerance allows each may leave one more over, 14 were needed"""
CHUNK = 65536
"""corners looked up at once: so many stay in the processor's cache when they are made numbers of the machine's own"""


class BandSource(Protocol):
    """What bands have in common."""

    def prepare(self, angles: Sequence[Sequence[Floats]]) -> None:
        """Make at once what is asked for next, at these very arrays of phi, by the sides of bands."""


@immutable
class Band:
    """A named surface: points (3, n, m) at angles phi (n,) and ways across u (n, m); the tolerance of its facets, mm.

    shrinks  edge (0 or 1) whose vertices stay where the band has no width; None for one that always has a width
    even     whether its edges have the steps of its columns: a twisted band takes fewer triangles so
    sharp    whether it meets the band before it at an angle: that edge is off both surfaces at once
    seen     share of the largest sag that shows half way between two u; below 1 where u is not smooth
    source   what it has in common with other bands; None for nothing
    side     number of the bands that have most in common
    """

    name: str
    at: Callable[[Floats, Floats], Floats]
    tolerance: float
    shrinks: int | None = None
    even: bool = False
    sharp: bool = False
    seen: float = 1.0
    source: BandSource | None = None
    side: int = 0

    @property
    def room(self) -> float:
        """Most that a facet may be off where it is measured, mm."""
        return MET * self.seen * self.tolerance


Truth = Callable[[Index, Floats], Floats]
"""points (3, q) of the true surface at the means of phi and u of facets' corners: facets (q,), weights (3, q)"""
Shares = Callable[[Floats], Floats]
"""of facets with corners (3, 3, f): the share of its room that each is kept to, (f,)"""


@immutable
class Banded:
    """Triangles within the tolerance of their bands.

    points  (3, v), faces (f, 3) turning from phi to u, and the band (f,) of each
    phi     (v,) angles of the vertices; u, edge_of (v,): as u and edge of `Facets`
    edges   vertices of every edge of a band, from the first one's u = 0 to the last one's u = 1, by rising phi
    errors  (b,) largest chord error of each band, mm
    """

    points: Floats
    phi: Floats
    u: Floats
    edge_of: Index
    faces: Corners
    band: Index
    edges: tuple[Index, ...]
    errors: tuple[float, ...]

    @property
    def chord_error(self) -> float:
        """Largest of all bands, mm."""
        return max(self.errors)

    @property
    def row(self) -> Floats:
        """(v,) number of the band and the way u across it, whole on edges."""
        # What is on no edge is of one band.
        own = np.zeros(len(self.u))
        own[self.faces] = self.band[:, None]
        return np.where(self.edge_of < 0, own + self.u, self.edge_of)

    def edge(self, b: int) -> Floats:
        """Points (3, n) of an edge, by rising phi."""
        return self.points[:, self.edges[b]]


@immutable
class Facets:
    """Triangles: vertices (f, 3) and band (f,), and which still stand; points (3, v), their phi and u (v,).

    edge    (v,) number of the edge a vertex stands on, where u is 0 or 1 by the band, or -1
    room    (b,) most that a facet of a band may be off where it is measured, mm; shares: see `banded`
    rings   vertices of all edges, each by rising phi; begin: of each the first, and the end
    """

    points: Floats
    phi: Floats
    u: Floats
    edge: Index
    room: Floats
    corner: Corners
    band: Index
    stands: Mask
    rings: Index
    begin: Index
    turn: float
    shares: Shares | None

    def places(self, ask: Index) -> tuple[Floats, Floats]:
        """phi and u (q, 3) of the corners of facets."""
        corner = self.corner[ask]
        phi, edge = self.phi[corner], self.edge[corner]
        # The turn's end is its start.
        phi = np.where(phi.max(axis=1, keepdims=True) - phi > 0.5 * self.turn, phi + self.turn, phi)
        return phi, np.where(edge < 0, self.u[corner], np.clip(edge - self.band[ask, None], 0, 1))

    def rooms(self, ask: Index | slice) -> Floats:
        """Most that facets may be off where they are measured, mm, (q,)."""
        room = np.asarray(self.room[self.band[ask]])
        return room if self.shares is None else room * self.shares(self.points[:, self.corner[ask].T])

    def finished(self, errors: tuple[float, ...]) -> Banded:
        """What stands, without vertices that nothing uses."""
        stands = np.flatnonzero(self.stands)
        corner = self.corner.take(stands, axis=0)
        used = np.zeros(self.points.shape[1], dtype=bool)
        used[corner] = True
        number = (np.cumsum(used) - 1).astype(np.int32)
        edges = tuple(np.split(number[self.rings].astype(np.int64), self.begin[1:-1]))
        kept = np.flatnonzero(used)
        return Banded(
            self.points.take(kept, axis=1), self.phi.take(kept), self.u.take(kept), self.edge.take(kept),
            of_corners(number, corner), self.band.take(stands), edges, errors,
        )  # fmt: skip


@immutable
class Measured:
    """Facets with their sags (f,), mm; of those that are over (q,) the true middles of edges, (3, 3, q), and which of
    them are to be split, (3, q)."""

    facets: Facets
    sag: Floats
    over: Index
    mids: Floats
    mark: Mask


@immutable
class Asked:
    """Points of a band that are asked for: phi (n,), u (n, m); on (n, m): which of them are."""

    band: int
    phi: Floats
    u: Floats
    on: Mask | None = None


def points_of(bands: Sequence[Band], asked: Sequence[Asked]) -> list[Floats]:
    """Points (3, n, m) of bands; what a source has in common at all of them is made once."""
    sources: dict[int, tuple[BandSource, dict[int, list[Floats]]]] = {}
    for one in asked:
        band = bands[one.band]
        if band.source is not None:
            angles = sources.setdefault(id(band.source), (band.source, {}))[1].setdefault(band.side, [])
            if all(one.phi is not other for other in angles):
                angles.append(one.phi)
    for source, sides in sources.values():
        source.prepare(list(sides.values()))
    return [bands[one.band].at(one.phi, one.u) for one in asked]


def within(bands: Sequence[Band], measured: Measured) -> Banded:
    """Edges split until every facet is within its tolerance."""
    facets, sag, over, mids = measured.facets, measured.sag, measured.over, measured.mids
    mark = measured.mark & facets.stands[over]
    for _ in range(ROUNDS):
        if not mark.any():
            most = np.zeros(len(bands))
            np.maximum.at(most, facets.band, np.where(facets.stands, sag, 0.0))
            share = most / facets.room
            return facets.finished(tuple(float(own) * band.tolerance for own, band in zip(share, bands)))
        facets = _split(facets, over, mids, mark)
        over = np.arange(len(sag), len(facets.band))
        mids = _middles(bands, facets, over)
        found, mark = sags(facets.points, facets.corner[over], mids, facets.rooms(over), truth_of(bands, facets, over))
        sag = np.append(sag, found)
    raise NotConverged(
        f"the chord error stays at {sag.max():g} mm: the surface is nearly singular (look at the undercut margin and "
        "the continuity of the motion)"
    )


def _middles(bands: Sequence[Band], facets: Facets, ask: Index) -> Floats:
    """The true surface half way along the edges of the facets `ask` (q,), (3, 3, q)."""
    phi, u = (0.5 * (x + x[:, NEXT]).ravel() for x in facets.places(ask))
    band = np.repeat(facets.band[ask], 3)
    # Two facets of a band have an edge in common, at the same angle but where the turn's end is its start.
    key = _edge_keys(facets.corner[ask], facets.points.shape[1]).T.ravel() * len(bands) + band
    key = 2 * key + (phi >= facets.phi[0] + facets.turn)
    order = key.argsort()
    key = key[order]
    other = np.append(True, key[1:] != key[:-1])
    own, number = order[other], np.empty_like(order)
    number[order] = np.cumsum(other) - 1
    x = _evaluated(bands, band[own], phi[own], u[own])
    return np.asarray(x.take(number, axis=1).reshape(3, -1, 3).transpose(0, 2, 1))


def _evaluated(bands: Sequence[Band], band: Index, phi: Floats, u: Floats) -> Floats:
    """Points (3, n) of several bands."""
    own = [np.flatnonzero(band == b) for b in range(len(bands))]
    used = [b for b, at in enumerate(own) if len(at)]
    x = np.empty((3, len(phi)))
    for b, each in zip(used, points_of(bands, [Asked(b, phi[own[b]], u[own[b], None]) for b in used])):
        x[:, own[b]] = each[:, :, 0]
    return x


def truth_of(bands: Sequence[Band], facets: Facets, ask: Index) -> Truth:
    """The true surface of the facets `ask` (q,)."""

    def truth(some: Index, weight: Floats) -> Floats:
        at = ask[some]
        phi, u = (np.einsum("kq,qk->q", weight, x) for x in facets.places(at))
        first = float(facets.phi[0])
        return _evaluated(bands, facets.band[at], np.clip(phi, first, first + facets.turn), np.clip(u, 0.0, 1.0))

    return truth


def sags(
    points: Floats, corner: Corners, mids: Floats, tolerance: Floats, truth: Truth | None = None
) -> tuple[Floats, Mask]:
    """Sag (f,) of each facet, mm, and which of its edges (3, f), first to second corner and so on, are to be split.

    Along the normals that the quadratic patch through corners and middles has in the middles: that of a thin facet
    leans, and turns within it. Where the surface runs aside of a facet, the nearest point of the patch; where that is
    near the tolerance, of the surface itself (truth).
    """
    x = [points.take(corner[:, k], axis=1) for k in range(3)]
    side = [x[1] - x[0], x[2] - x[1], x[0] - x[2]]
    bend = [mids[:, k] - x[k] - 0.5 * side[k] for k in range(3)]
    off = np.stack([_off(side, bend, k) for k in range(3)])
    a, c = 8.0 * off[0], 8.0 * off[2]
    sag = patch_sag(a, 0.5 * (a + c) - 4.0 * off[1], c)
    off = np.abs(off)
    # Where the surface runs aside by a share of a facet's height, what is nearest to the facet is sought.
    flat = cross(side[0], side[1])
    longest, square = (reduce(np.maximum, (dot(way, way) for way in each)) for each in (side, bend))
    most = further(square, longest, np.sqrt(dot(flat, flat)))
    near, slim = np.nonzero((off * most > tolerance) & (sag <= tolerance))
    if len(slim):
        own = _distances(side, bend, near, slim, mids, tolerance[slim], truth)
        off[near, slim] = np.maximum(off[near, slim], own)
        np.maximum.at(sag, slim, own)
    over = sag > tolerance
    mark = over & ((off > tolerance) | (off == reduce(np.maximum, off)))
    return sag, mark


def further(square: Floats, longest: Floats, area: Floats) -> Floats:
    """At most how many times as far as along the normal facets may be off, (f,); see ASIDE.

    square, longest  of the surface's way from the middle of a side, and of the longest side, mm²; area: twice a facet's
    """
    return np.asarray(np.minimum(1.0 + ASIDE * square * longest / np.maximum(area * area, 1e-300), MOST))


def _off(side: list[Floats], bend: list[Floats], k: int) -> Floats:
    """How far (f,) the middle of an edge is off along the normal that the quadratic patch has there, mm, signed; see
    `_distances`."""
    # Across the edge, half way, the patch runs to the corner behind it.
    across = side[NEXT[k]] + 0.5 * side[k] + 2.0 * (bend[NEXT[k]] + bend[AFTER[k]] - bend[k])
    normal = cross(side[k], across)
    return np.asarray(dot(normal, bend[k]) / np.maximum(np.sqrt(dot(normal, normal)), 1e-300))


def _distances(
    side: list[Floats], bend: list[Floats], which: Index, facets: Index, mids: Floats, room: Floats,
    truth: Truth | None,
) -> Floats:  # fmt: skip
    """Distances (q,) of the middles of sides of some facets from the quadratic patch through corners and middles, mm;
    where they are near the room (q,), from the true surface.

    side, bend  (3, f) of each side its way, and the way from its middle to the patch's; which: side (q,) of each facet
    mids        true middles (3, 3, f)
    By Newton's method for the patch's nearest point, of whose steps the nearest counts: a distance is no larger. It is
    no larger than to the surface's own point there either.
    """
    sides, bends = np.concatenate(side, axis=1), np.concatenate(bend, axis=1)
    every = side[0].shape[1]
    at, after, last = (facets + every * ((which + k) % 3) for k in range(3))
    # From the side's first corner s along it and t to the corner behind it.
    along, behind = sides.take(at, axis=1), -sides.take(last, axis=1)
    one, two, three = (4.0 * bends.take(each, axis=1) for each in (at, after, last))
    s, t, least = np.full(len(at), 0.5), np.zeros(len(at)), np.full(len(at), np.inf)
    for _ in range(STEPS):
        r = 1.0 - s - t
        away = (s - 0.5) * along + t * behind + s * r * one + s * t * two + t * r * three
        np.minimum(least, dot(away, away), out=least)
        ds = along + (r - s) * one + t * (two - three)
        dt = behind + s * (two - one) + (r - t) * three
        aa, ab, bb, fa, fb = dot(ds, ds), dot(ds, dt), dot(dt, dt), dot(ds, away), dot(dt, away)
        area = np.maximum(aa * bb - ab * ab, 1e-300)
        # Where the patch folds a step may be of any length.
        s = np.clip(s - (fa * bb - fb * ab) / area, -BEYOND, BEYOND)
        t = np.clip(t - (fb * aa - fa * ab) / area, -BEYOND, BEYOND)
    found = np.sqrt(least)
    near = np.flatnonzero((found > TOLD * room) & (found <= room))
    if truth is None or not len(near):
        return np.asarray(found)
    told = np.full(len(found), np.inf)
    for _ in range(TRIES):
        weight = np.empty((3, len(near)))
        order = (which[near] + np.arange(3)[:, None]) % 3
        np.put_along_axis(weight, order, np.stack([1.0 - s[near] - t[near], s[near], t[near]]), axis=0)
        middle = mids[:, which[near], facets[near]] - bends.take(at[near], axis=1)
        away = truth(facets[near], weight) - middle
        # Of the surface's points the nearest is no nearer than it is.
        told[near] = np.minimum(told[near], np.sqrt(dot(away, away)))
        one, other = ds[:, near], dt[:, near]
        aa, ab, bb, fa, fb = dot(one, one), dot(one, other), dot(other, other), dot(one, away), dot(other, away)
        area = np.maximum(aa * bb - ab * ab, 1e-300)
        s[near] -= (fa * bb - fb * ab) / area
        t[near] -= (fb * aa - fa * ab) / area
        near = near[told[near] > room[near]]
        if not len(near):
            break
    return np.asarray(np.where(np.isfinite(told), told, found))


PARTS = (
    np.array([[0, 3, 2], [3, 1, 2]]),
    np.array([[3, 1, 4], [0, 3, 4], [0, 4, 2]]),
    np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]),
)
"""triangles of a facet with one, two (the last is whole) or three edges split: corners 0 .. 2, middles 3 .. 5"""


def _split(facets: Facets, ask: Index, mids: Floats, mark: Mask) -> Facets:
    """The facets with marked edges (3, q) of the facets `ask` split at the true surface, on both sides of the edge.

    The new ones stand behind the old ones, of which those that are split stand no more.
    """
    corner, size = facets.corner, facets.points.shape[1]
    split, first = np.unique(_edge_keys(corner[ask], size)[mark], return_index=True)
    side, own = (each[first] for each in np.nonzero(mark))
    phi, u = facets.places(ask[own])
    row, other = np.arange(len(own)), (side + 1) % 3
    share = 0.5 * (u[row, side] + u[row, other])
    whole = (share == 0.0) | (share == 1.0)
    edge = np.where(whole, facets.band[ask[own]] + share.astype(np.int64), -1)
    start = facets.phi[facets.rings[0]]
    ends = np.zeros(size, dtype=bool)
    ends[split // size] = ends[split % size] = True
    one, two, three = of_corners(ends, corner).T
    near = np.flatnonzero(((one & (two | three)) | (two & three)) & facets.stands)
    at, hit = _found(split, _edge_keys(corner[near], size))
    many = hit.sum(axis=0)
    turn = np.where(many == 2, np.argmin(hit, axis=0) + 1, np.argmax(hit, axis=0))
    stands = facets.stands.copy()
    stands[near[many > 0]] = False
    numbers, bands = [corner], [facets.band]
    for count, part in enumerate(PARTS, 1):
        which = np.flatnonzero(many == count)
        order = (turn[which][:, None] + np.arange(3)) % 3
        middle = size + np.take_along_axis(at.T[which], order, axis=1)
        six = np.concatenate([np.take_along_axis(corner[near[which]], order, axis=1), middle], axis=1)
        numbers.append(six[:, part].reshape(-1, 3).astype(np.int32))
        bands.append(np.repeat(facets.band[near[which]], len(part)))
    corner = np.concatenate(numbers)
    # A link of an edge runs from each of its vertices to the next one, the last one's to the first.
    rings, begin = facets.rings, facets.begin
    after = np.append(rings[1:], 0)
    after[begin[1:] - 1] = rings[begin[:-1]]
    at, hit = _found(split, np.minimum(rings, after) * np.int64(size) + np.maximum(rings, after))
    cut = np.flatnonzero(hit)
    return Facets(
        np.concatenate([facets.points, mids[:, mark][:, first]], axis=1),
        np.append(facets.phi, (0.5 * (phi[row, side] + phi[row, other]) - start) % facets.turn + start),
        np.append(facets.u, share), np.append(facets.edge, edge), facets.room, corner, np.concatenate(bands),
        np.append(stands, np.ones(len(corner) - len(stands), dtype=bool)),
        np.insert(rings, cut + 1, size + at[cut]).astype(np.int64), begin + np.searchsorted(cut, begin), facets.turn,
        facets.shares,
    )  # fmt: skip


def _found(split: Index, keys: Index) -> tuple[Index, Mask]:
    """Where keys stand among sorted ones, and whether they do."""
    at = np.minimum(np.searchsorted(split, keys), len(split) - 1)
    return at, split[at] == keys


def _edge_keys(corner: Corners, size: int) -> Index:
    """One number (3, q) for each edge of facets (q, 3), the same from both sides."""
    one, other = corner.T, corner.T[NEXT]
    return np.asarray(np.minimum(one, other) * np.int64(size) + np.maximum(one, other))


def of_corners(values: npt.NDArray[Kind], corner: Corners) -> npt.NDArray[Kind]:
    """Values (v,) of vertices at the corners (f, 3) of facets."""
    every = corner.ravel()
    found = np.empty(len(every), dtype=values.dtype)
    for start in range(0, len(every), CHUNK):
        part = slice(start, start + CHUNK)
        values.take(every[part], out=found[part], mode="clip")
    return found.reshape(corner.shape)


def kept(corner: Corners) -> Mask:
    """Which triangles have three corners."""
    a, b, c = corner.T
    return np.asarray((a != b) & (b != c) & (c != a))
