"""Triangles of bands side by side, measured on their true surfaces and split until they are within the tolerance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from camgeom.errors import NotConverged
from camgeom.maths import Floats
from camgeom.maths.sampling import patch_sag
from camgeom.maths.surface import cross, dot

Index = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]

NEXT = [1, 2, 0]
"""corners after the corners of a triangle"""
MET = 0.995
"""share of the tolerance to which measured sags are kept: elsewhere a facet may be off a little more"""
ROUNDS = 12
"""of splitting edges"""


class Source(Protocol):
    """What bands have in common."""

    def prepare(self, angles: Sequence[Floats]) -> None:
        """Make at once what is asked for next, at these very arrays of phi."""


@dataclass(frozen=True, eq=False)
class Band:
    """A named surface: points (3, n, m) at angles phi (n,) and ways across u (n, m); the tolerance of its facets, mm.

    shrinks  edge (0 or 1) whose vertices stay where the band has no width; None for one that always has a width
    even     whether its edges have the steps of its columns: a twisted band takes fewer triangles so
    sharp    whether it meets the band before it at an angle: that edge is off both surfaces at once
    seen     share of the largest sag that shows half way between two u; below 1 where u is not smooth
    source   what it has in common with other bands; None for nothing
    """

    name: str
    at: Callable[[Floats, Floats], Floats]
    tolerance: float
    shrinks: int | None = None
    even: bool = False
    sharp: bool = False
    seen: float = 1.0
    source: Source | None = None

    @property
    def room(self) -> float:
        """Most that a facet may be off where it is measured, mm."""
        return MET * self.seen * self.tolerance


@dataclass(frozen=True, eq=False)
class Banded:
    """Triangles within the tolerance of their bands.

    points  (3, v), faces (f, 3) turning from phi to u, and the band (f,) of each
    edges   vertices of every edge of a band, from the first one's u = 0 to the last one's u = 1, by rising phi
    """

    points: Floats
    faces: Index
    band: Index
    edges: tuple[Index, ...]
    chord_error: float

    def edge(self, b: int) -> Floats:
        """Points (3, n) of an edge, by rising phi."""
        return self.points[:, self.edges[b]]


@dataclass(frozen=True, eq=False)
class Facets:
    """Triangles: vertices (f, 3) and band (f,); points (3, v), their phi and u (v,); edges as of `Banded`.

    On an edge u is 0 or 1 by the band: `edge` (v,) is its number, or -1.
    """

    points: Floats
    phi: Floats
    u: Floats
    edge: Index
    corner: Index
    band: Index
    edges: tuple[Index, ...]
    turn: float

    def places(self, ask: Index) -> tuple[Floats, Floats]:
        """phi and u (q, 3) of the corners of facets."""
        corner = self.corner[ask]
        phi, edge = self.phi[corner], self.edge[corner]
        # The turn's end is its start.
        phi = np.where(phi.max(axis=1, keepdims=True) - phi > 0.5 * self.turn, phi + self.turn, phi)
        return phi, np.where(edge < 0, self.u[corner], np.clip(edge - self.band[ask, None], 0, 1))


@dataclass(frozen=True, eq=False)
class Measured:
    """Facets with the sags (r,) of the first ones, mm, and the true middles (3, 3, f - r) of the others' edges."""

    facets: Facets
    sag: Floats
    mids: Floats


def points_of(bands: Sequence[Band], asked: Sequence[tuple[int, Floats, Floats]]) -> list[Floats]:
    """Points (3, n, m) of bands at phi (n,) and u (n, m); what a source has in common at all of them is made once."""
    sources: dict[int, tuple[Source, list[Floats]]] = {}
    for b, phi, _ in asked:
        source = bands[b].source
        if source is not None:
            angles = sources.setdefault(id(source), (source, []))[1]
            if all(phi is not other for other in angles):
                angles.append(phi)
    for source, angles in sources.values():
        source.prepare(angles)
    return [bands[b].at(phi, u) for b, phi, u in asked]


def within(bands: Sequence[Band], measured: Measured) -> Banded:
    """Edges split until every facet is within its tolerance."""
    room = np.array([band.room for band in bands])
    facets, first = measured.facets, len(measured.sag)
    loose, mark = _sags(facets.points, facets.corner[first:], measured.mids, room[facets.band[first:]])
    sag = np.append(measured.sag, loose)
    over = np.flatnonzero(sag > room[facets.band])
    if len(over):
        known = over[over >= first] - first
        again = over[over < first]
        mids = np.concatenate([_middles(bands, facets, again), measured.mids[:, :, known]], axis=2)
        sag[again], marked = _sags(facets.points, facets.corner[again], mids[:, :, : len(again)],
                                   room[facets.band[again]])  # fmt: skip
        mark = np.append(marked, mark[:, known], axis=1)
    ask = over
    for _ in range(ROUNDS):
        if not len(ask) or not mark.any():
            used = np.zeros(facets.points.shape[1], dtype=bool)
            used[facets.corner] = True
            number = np.cumsum(used) - 1
            edges = tuple(number[edge] for edge in facets.edges)
            share = float((sag / room[facets.band]).max())
            return Banded(
                facets.points[:, used], number[facets.corner], facets.band, edges,
                share * max(band.tolerance for band in bands),
            )  # fmt: skip
        facets, kept = _split(facets, ask, mids, mark)
        ask = np.arange(len(kept), len(facets.band))
        mids = _middles(bands, facets, ask)
        found, mark = _sags(facets.points, facets.corner[ask], mids, room[facets.band[ask]])
        sag = np.append(sag[kept], found)
    raise NotConverged(
        f"the chord error stays at {sag.max():g} mm: the surface is nearly singular (look at the undercut margin and "
        "the continuity of the motion)"
    )


def _middles(bands: Sequence[Band], facets: Facets, ask: Index) -> Floats:
    """The true surface half way along the edges of the facets `ask` (q,), (3, 3, q)."""
    phi, u = (0.5 * (x + x[:, NEXT]).ravel() for x in facets.places(ask))
    x = _evaluated(bands, np.repeat(facets.band[ask], 3), phi, u)
    return x.reshape(3, -1, 3).transpose(0, 2, 1)


def _evaluated(bands: Sequence[Band], band: Index, phi: Floats, u: Floats) -> Floats:
    """Points (3, n) of several bands."""
    own = [np.flatnonzero(band == b) for b in range(len(bands))]
    used = [b for b, at in enumerate(own) if len(at)]
    x = np.empty((3, len(phi)))
    for b, each in zip(used, points_of(bands, [(b, phi[own[b]], u[own[b], None]) for b in used])):
        x[:, own[b]] = each[:, :, 0]
    return x


def _sags(points: Floats, corner: Index, mids: Floats, tolerance: Floats) -> tuple[Floats, Mask]:
    """Sag (f,) of each facet, mm, and which of its edges (3, f), first to second corner and so on, are to be split.

    Along the normal that the quadratic patch through corners and middles has at its centre: that of a thin facet leans.
    """
    x = [points[:, corner[:, k]] for k in range(3)]
    side = [x[1] - x[0], x[2] - x[1], x[0] - x[2]]
    normal = cross(side[0] + 4.0 * (mids[:, 1] - mids[:, 2]), 4.0 * (mids[:, 1] - mids[:, 0]) - side[2])
    normal /= np.maximum(np.sqrt(dot(normal, normal)), 1e-300)
    off = np.stack([dot(normal, mids[:, k] - x[k] - 0.5 * side[k]) for k in range(3)])
    a, c = 8.0 * off[0], 8.0 * off[2]
    sag = patch_sag(a, 0.5 * (a + c) - 4.0 * off[1], c)
    off = np.abs(off)
    over = sag > tolerance
    mark = over & ((off > tolerance) | (off == off.max(axis=0)))
    return sag, mark


PARTS = (
    np.array([[0, 3, 2], [3, 1, 2]]),
    np.array([[3, 1, 4], [0, 3, 4], [0, 4, 2]]),
    np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]),
)
"""triangles of a facet with one, two (the last is whole) or three edges split: corners 0 .. 2, middles 3 .. 5"""


def _split(facets: Facets, ask: Index, mids: Floats, mark: Mask) -> tuple[Facets, Index]:
    """The facets with marked edges (3, q) of the facets `ask` split at the true surface, on both sides of the edge.

    Returns them, and the numbers of the old ones that are kept, which come first.
    """
    corner, size = facets.corner, facets.points.shape[1]
    split, first = np.unique(_edge_keys(corner[ask], size)[mark], return_index=True)
    side, own = (each[first] for each in np.nonzero(mark))
    phi, u = facets.places(ask[own])
    row, other = np.arange(len(own)), (side + 1) % 3
    share = 0.5 * (u[row, side] + u[row, other])
    whole = (share == 0.0) | (share == 1.0)
    edge = np.where(whole, facets.band[ask[own]] + share.astype(np.int64), -1)
    start = facets.phi.min()
    ends = np.zeros(size, dtype=bool)
    ends[split // size] = ends[split % size] = True
    near = np.flatnonzero(ends[corner].sum(axis=1) > 1)
    keys = _edge_keys(corner[near], size)
    at = np.minimum(np.searchsorted(split, keys), len(split) - 1)
    hit = split[at] == keys
    many = hit.sum(axis=0)
    turn = np.where(many == 2, np.argmin(hit, axis=0) + 1, np.argmax(hit, axis=0))
    keep = np.ones(len(corner), dtype=bool)
    keep[near[many > 0]] = False
    kept = np.flatnonzero(keep)
    numbers, bands = [corner[kept]], [facets.band[kept]]
    for count, part in enumerate(PARTS, 1):
        which = np.flatnonzero(many == count)
        order = (turn[which][:, None] + np.arange(3)) % 3
        middle = size + np.take_along_axis(at.T[which], order, axis=1)
        six = np.concatenate([np.take_along_axis(corner[near[which]], order, axis=1), middle], axis=1)
        numbers.append(six[:, part].reshape(-1, 3))
        bands.append(np.repeat(facets.band[near[which]], len(part)))
    return Facets(
        np.concatenate([facets.points, mids[:, mark][:, first]], axis=1),
        np.append(facets.phi, (0.5 * (phi[row, side] + phi[row, other]) - start) % facets.turn + start),
        np.append(facets.u, share), np.append(facets.edge, edge), np.concatenate(numbers), np.concatenate(bands),
        tuple(_with_split(each, split, size) for each in facets.edges), facets.turn,
    ), kept  # fmt: skip


def _edge_keys(corner: Index, size: int) -> Index:
    """One number (3, q) for each edge of facets (q, 3), the same from both sides."""
    one, other = corner.T, corner.T[NEXT]
    return np.asarray(np.minimum(one, other) * np.int64(size) + np.maximum(one, other))


def _with_split(edge: Index, split: Index, size: int) -> Index:
    """A closed edge with the middles of its split links."""
    other = np.roll(edge, -1)
    key = np.minimum(edge, other) * np.int64(size) + np.maximum(edge, other)
    at = np.minimum(np.searchsorted(split, key), len(split) - 1)
    hit = np.flatnonzero(split[at] == key)
    return np.insert(edge, hit + 1, size + at[hit])
