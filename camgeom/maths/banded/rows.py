"""Facets of rows and strips between the vertices of a plan, measured on the true surface."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camgeom.maths import Floats
from camgeom.maths.banded.facets import (
    Band,
    Corners,
    Facets,
    Index,
    Mask,
    Measured,
    Shares,
    further,
    kept,
    of_corners,
    sags,
    truth_of,
)
from camgeom.maths.banded.net import Net, Request
from camgeom.maths.banded.plan import NetPlan
from camgeom.maths.sampling import MAX_CELLS, patch_sag, too_many
from camgeom.maths.surface import cross, dot

CHUNK = 16384
"""cells measured at once: so many stay in the processor's cache"""


def meshed(bands: Sequence[Band], plan: NetPlan, shares: Shares | None) -> Measured:
    """The facets of all rows and strips, measured."""
    net = Net(plan)
    cells = int(plan.rows[net.gaps[0]].sum())
    if cells > MAX_CELLS:
        raise too_many(cells, "cells")
    strips = net.strips
    # One array: vertices, the middles of edges' links, of regular gaps, of the strips' chords and of their links.
    gaps = net.grouped(net.regular, plan.band[net.gaps[0][net.regular]], plan.rows[net.gaps[0][net.regular]])
    own = np.concatenate([each for _, each in gaps] or [net.regular])
    rows = plan.rows[net.gaps[0][own]]
    size = 2 * rows + 1
    ends = np.cumsum([0, int(net.size.sum()), len(plan.phi), int(size.sum()), len(strips.ends), len(strips.links)])
    half, middle, chord, link = ends[1:-1].tolist()
    first = middle + np.cumsum(size) - size
    request = Request([], [], [])
    known = np.zeros(len(plan.phi), dtype=bool)
    net.ask_columns(request, known)
    net.ask_middles(request, gaps, middle)
    # Where a band's edges have the steps of its columns, their links are sides of its cells.
    stretch, at = (x[own] for x in net.gaps)
    side = net.whole[plan.band[stretch]]
    shared = [(half + net.opposite(at[side], k), first[side] + k * rows[side]) for k in (0, 2)]
    halved = np.zeros(len(plan.phi), dtype=bool)
    halved[np.concatenate([to for to, _ in shared]) - half] = True
    halved[net.closing] = True
    net.ask_alone(request, ~known, ~halved, half, chord, link)
    told = request.told(bands, int(ends[-1]))
    for to, source in shared:
        told[:, to] = told.take(source, axis=1)
    on_edge = np.flatnonzero(net.edge_links)
    told[:, link + on_edge] = told.take(half + strips.links[on_edge, 0] % len(plan.phi), axis=1)
    points = np.ascontiguousarray(told[:, :half])
    grid = RegularCells(net, own, points, told, first)
    one = net.shrunk(bands, points)
    corner = np.concatenate([grid.corner, strips.number[strips.corner].astype(np.int32)])
    label = np.concatenate([np.repeat(plan.band[stretch][grid.gap], 2), strips.band[: len(strips.links)]])
    if one is not None:
        corner = of_corners(one, corner)
    mids = strips.middles(told[:, chord:link], told[:, link:])
    place, share, edge_of = net.vertices
    edges = [net.edge(k) for k in range(len(bands) + 1)]
    ring = net.start[np.concatenate(edges)]
    facets = Facets(
        points, plan.phi[place], share, edge_of, np.array([band.room for band in bands]), corner,
        label, kept(corner), ring if one is None else one[ring].astype(np.int64),
        np.cumsum([0, *map(len, edges)]), float(plan.theta[-1] - plan.theta[0]), shares,
    )  # fmt: skip
    room = facets.rooms(slice(0, len(grid.corner), 2))
    over, own_sag, off, marked = grid.over(room)
    close, true, cut = grid.close(room)
    ask = np.append(close, np.arange(len(grid.corner), len(corner)))
    most, true_mids = facets.rooms(ask), np.concatenate([true, mids], axis=2)
    found, mark = sags(points, corner[ask], true_mids, most, truth_of(bands, facets, ask))
    few = len(close)
    mark, asked = mark[:, few:], mark[:, :few] & cut[0]
    asked |= cut[1] & (found > most)[:few] & ~asked.any(axis=0)
    split = np.flatnonzero(mark.any(axis=0))
    sag = np.append(np.repeat(grid.sag, 2), found[few:])
    sag[over], sag[close] = own_sag, found[:few]
    return Measured(
        facets, sag, np.concatenate([over, close, len(grid.corner) + split]),
        np.concatenate([off, true, mids[:, :, split]], axis=2),
        np.concatenate([marked, asked, mark[:, split]], axis=1),
    )  # fmt: skip


class RegularCells:
    """Regular cells of a net.

    corner  (2 c, 3) of their triangles; gap (c,): the place among `gaps` of the gap that each stands in
    sag     (c,) of the larger of both triangles, mm, along the better diagonal
    """

    corner: Corners
    gap: Index
    sag: Floats

    def __init__(self, net: Net, gaps: Index, points: Floats, told: Floats, first: Index) -> None:
        """In some gaps, with the points (3, v) of all vertices; in `told` from `first` (g,) on are those half way in a
        gap, rows doubled."""
        number, self.gap, row = net.cells(gaps)
        self._points, self._told, self._half = points, told, first[self.gap] + 2 * row
        count = len(row)
        self.sag, self._most, rising = np.empty(count), np.empty(count), np.empty(count, dtype=bool)
        for start in range(0, count, CHUNK):
            part = slice(start, start + CHUNK)
            self.sag[part], rising[part], _, self._most[part] = self._measured(number[:, part], self._half[part])
        self._number, self._rising = number, rising
        p00, p01, p10, p11 = number
        corner = np.empty((count, 6), dtype=np.int32)
        corner[:, 0], corner[:, 1], corner[:, 4], corner[:, 5] = p00, p10, p11, p01
        corner[:, 2], corner[:, 3] = np.where(rising, p11, p01), np.where(rising, p00, p10)
        self.corner = corner.reshape(-1, 3)

    def _measured(
        self, number: Corners, half: Index
    ) -> tuple[Floats, Mask, tuple[Floats, Floats, Floats, Floats], Floats]:
        corners = (self._points.take(each, axis=1) for each in number)
        return _cell_sags(*corners, *(self._told.take(half + k, axis=1) for k in range(3)))

    def close(self, room: Floats) -> tuple[Index, Floats, tuple[Mask, Mask]]:
        """Triangles (q,) of cells within the room (c,) of each that may be off by more all the same, beside which the
        surface runs aside; the middles (3, 3, q) of their edges, along columns by what the others leave over; which
        (3, q) may be split, and which of them are diagonals."""
        at = np.flatnonzero((self.sag <= room) & (self.sag * self._most > room))
        number, rising = self._number[:, at], self._rising[at]
        low, centre, high = (self._told.take(self._half[at] + k, axis=1) for k in range(3))
        p00, p01, p10, p11 = (self._points.take(each, axis=1) for each in number)
        bend = centre - 0.5 * (low + high)
        before, after = 0.5 * (p00 + p01) + bend, 0.5 * (p10 + p11) + bend
        mids, column = np.empty((3, 3, 2, len(at))), np.zeros((3, 2, len(at)), dtype=bool)
        mids[:, 0, 0], mids[:, 1, 1] = low, high
        mids[:, 1, 0], mids[:, 2, 0] = np.where(rising, after, centre), np.where(rising, centre, before)
        mids[:, 0, 1], mids[:, 2, 1] = np.where(rising, centre, after), np.where(rising, before, centre)
        column[1, 0] = column[2, 1] = rising
        column[2, 0] = column[0, 1] = ~rising
        diagonal = ~column
        diagonal[0, 0] = diagonal[1, 1] = False
        facets = (2 * at + np.array([[0], [1]])).ravel()
        return facets, mids.reshape(3, 3, -1), (~column.reshape(3, -1), diagonal.reshape(3, -1))

    def over(self, room: Floats) -> tuple[Index, Floats, Floats, Mask]:
        """Triangles (q,) of cells that are off by more than the room (c,) of each, and their own sags, mm; the
        middles (3, 3, q) of their edges, of which those along columns are not known, and which (3, q) are to be split.
        """
        at = np.flatnonzero(self.sag > room)
        number, rising, half, most = self._number[:, at], self._rising[at], self._half[at], room[at]
        _, _, (low, high, up, down), _ = self._measured(number, half)
        # Of both triangles the row, the diagonal, and the column, which has what the others leave over.
        row, diagonal, across = np.stack([low, high]), np.where(rising, up, down), 0.5 * (up + down - low - high)
        sag = patch_sag(8.0 * row, 4.0 * (row + across - diagonal), 8.0 * across)
        row, diagonal = np.abs(row), np.abs(diagonal)
        cut_row = (sag > most) & ((row > most) | (row >= diagonal))
        cut_diagonal = (sag > most) & ((diagonal > most) | (diagonal > row))
        low, centre, high = (self._told.take(half + k, axis=1) for k in range(3))
        mids, mark = np.empty((3, 3, 2, len(at))), np.zeros((3, 2, len(at)), dtype=bool)
        mids[:] = centre[:, None, None]
        mids[:, 0, 0], mids[:, 1, 1] = low, high
        mark[0, 0], mark[1, 0], mark[2, 0] = cut_row[0], cut_diagonal[0] & ~rising, cut_diagonal[0] & rising
        mark[1, 1], mark[0, 1], mark[2, 1] = cut_row[1], cut_diagonal[1] & rising, cut_diagonal[1] & ~rising
        over = (2 * at + np.array([[0], [1]])).ravel()
        return over, sag.ravel(), mids.reshape(3, 3, -1), mark.reshape(3, -1)


def _cell_sags(
    p00: Floats, p01: Floats, p10: Floats, p11: Floats, low: Floats, centre: Floats, high: Floats
) -> tuple[Floats, Mask, tuple[Floats, Floats, Floats, Floats], Floats]:
    """Sags (n,) of the triangles of cells along the better diagonal, mm, whether that is the rising one, how far both
    rows and both diagonals are off, signed, and at most how many times the sag the triangles may be off.

    Corners (3, n) before and after a step along phi, low and high across, and the true surface half way along it: low,
    in the cell's middle and high. Along the rows and both diagonals as it is in their middles, along the columns what
    the others leave over.
    """
    normal = cross(p11 - p00, p10 - p01)
    length = np.sqrt(dot(normal, normal))
    normal /= np.where(length > 0.0, length, 1.0)
    ways = 0.5 * (p00 + p10) - low, 0.5 * (p01 + p11) - high, 0.5 * (p00 + p11) - centre, 0.5 * (p10 + p01) - centre
    first, last, rising, falling = (dot(normal, way) for way in ways)
    across = 0.5 * (rising + falling - first - last)
    along = np.where(np.abs(first) > np.abs(last), first, last)
    side = np.maximum(np.abs(along), np.abs(across))
    twist = 0.25 * (rising - falling)
    one, other = np.maximum(side, np.abs(rising)), np.maximum(side, np.abs(falling))
    bowl = np.flatnonzero(along * across > twist * twist)
    if len(bowl):
        a, b, c = 8.0 * along[bowl], 8.0 * twist[bowl], 8.0 * across[bowl]
        one[bowl] = np.maximum(one[bowl], patch_sag(a, -b, c))
        other[bowl] = np.maximum(other[bowl], patch_sag(a, b, c))
    up = one <= other
    row, diagonal = np.maximum(dot(ways[0], ways[0]), dot(ways[1], ways[1])), np.where(up, ways[2], ways[3])
    long = np.where(up, p11 - p00, p10 - p01)
    # The normal was twice as long as the cell is large, which is twice a triangle.
    most = further(np.maximum(row, dot(diagonal, diagonal)), dot(long, long), 0.5 * length)
    return np.minimum(one, other), up, (first, last, rising, falling), most
