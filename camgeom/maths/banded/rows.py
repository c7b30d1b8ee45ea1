"""Rows and strips of triangles between the vertices of a plan, and where the true surface is asked to measure them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from camgeom.errors import NotConverged
from camgeom.maths import Floats
from camgeom.maths.banded.facets import Band, Facets, Index, Mask, Measured, points_of
from camgeom.maths.banded.plan import Plan
from camgeom.maths.frozen import cached_property
from camgeom.maths.sampling import MAX_CELLS, patch_sag
from camgeom.maths.surface import cross, dot

SHRUNK = 1e-3
"""share of the tolerance below which a band has no width, and its two edges one vertex"""
SAME = 1e-9
"""difference of angles, rad, that are the same"""


@dataclass(frozen=True, eq=False)
class Strips:
    """Triangles between chains of vertices that do not stand beside each other.

    phi, u  of the vertices of all chains (c,); a chain is a piece of them
    corner  (f, 3) places of the triangles' corners among them
    asked   phi and u of the middles of all chords from chain to chain, and then of the link of every triangle
    is_low  (f,) whether two corners of a triangle are on the lower chain; after (f,): place of the chord behind it
    """

    phi: Floats
    u: Floats
    corner: Index
    asked: tuple[Floats, Floats]
    is_low: Mask
    after: Index

    @classmethod
    def zipped(cls, phi: Floats, u: Floats, low: Index, high: Index, across: Mask, lean: Floats, far: float) -> Strips:
        """Between chains low and high (s, 2): the place of the first vertex of each, and the number of links.

        across  (s,) whether the chains run along u, not along phi
        lean    (c,) at vertices of the higher chain, by how much those of the lower one best stand before them
        far     more than phi and u change in all
        Every link is joined to the nearest vertex of the other chain.
        """
        half_phi, half_u = 0.5 * (phi[1:] + phi[:-1]), 0.5 * (u[1:] + u[:-1])
        (s, i), (t, j) = _links(low), _links(high)
        one = np.where(across[s], half_u[i], half_phi[i]) + far * s
        other = np.where(across[t], half_u[j], half_phi[j]) - lean[j] + far * t
        # Chains must not turn back.
        other = np.maximum.accumulate(other)
        # Each link's place among those of both chains, and how many of the other one come before it.
        passed, gone = np.searchsorted(other, one), np.searchsorted(one, other, side="right")
        size = len(one) + len(other)
        at_low, at_high = np.arange(len(one)) + passed, np.arange(len(other)) + gone
        is_low = np.zeros(size, dtype=bool)
        is_low[at_low] = True
        strip, link, tip = (np.empty(size, dtype=np.int64) for _ in range(3))
        strip[at_low], strip[at_high] = s, t
        link[at_low], link[at_high] = i, j
        tip[at_low] = (high[:, 0] - np.cumsum(high[:, 1]) + high[:, 1])[s] + passed
        tip[at_high] = (low[:, 0] - np.cumsum(low[:, 1]) + low[:, 1])[t] + gone
        a, c = np.where(is_low, link, tip), np.where(is_low, tip, link)
        # Chords from low to high: one before each triangle, and the last one of each strip.
        final = np.flatnonzero(np.append(strip[1:] != strip[:-1], True))
        after = np.arange(1, size + 1)
        after[final] = size + np.arange(len(final))
        begin, end = (np.append(x, chain[strip[final]].sum(axis=1)) for x, chain in ((a, low), (c, high)))
        asked = (
            np.concatenate([0.5 * (phi[begin] + phi[end]), half_phi[link]]),
            np.concatenate([0.5 * (u[begin] + u[end]), half_u[link]]),
        )
        return cls(phi, u, np.stack([a, link + 1, c], axis=1), asked, is_low, after)

    def middles(self, x: Floats) -> Floats:
        """True middles (3, 3, f) of the triangles' edges from the points (3, n) asked for."""
        size = len(self.is_low)
        along, beyond = x[:, -size:], x[:, self.after]
        mids = np.empty((3, 3, size))
        mids[:, 0] = np.where(self.is_low, along, beyond)
        mids[:, 1] = np.where(self.is_low, beyond, along)
        mids[:, 2] = x[:, :size]
        return mids


def _links(chains: Index) -> tuple[Index, Index]:
    """Of every link of chains (s, 2) its chain, and the place of its first vertex."""
    own = np.repeat(np.arange(len(chains)), chains[:, 1])
    return own, np.arange(len(own)) + (chains[:, 0] - np.cumsum(chains[:, 1]) + chains[:, 1])[own]


@dataclass(frozen=True, eq=False)
class Rows:
    """What stands between the two edges of band b: rows of vertices on columns.

    low, high  angles of the edges; phi: of the columns, with both ends of the turn
    nodes      (s + 1,) angles between the stretches, and stretch (s,) the number of rows in each, 0 where it changes
    even       (s,) where the edges have the steps of the columns
    lean       at the first and the last row in the cells of angles theta, see `Plan`
    """

    b: int
    low: Floats
    high: Floats
    phi: Floats
    nodes: Floats
    stretch: Index
    even: Mask
    lean: tuple[Floats, Floats]
    theta: Floats

    @cached_property
    def first(self) -> Index:
        """Columns (s + 1,) at the nodes."""
        return np.searchsorted(self.phi, self.nodes)

    @cached_property
    def ends(self) -> tuple[Index, Index]:
        """Vertices (s + 1,) of either edge at the nodes."""
        return np.searchsorted(self.low, self.nodes), np.searchsorted(self.high, self.nodes)

    @cached_property
    def cells(self) -> Index:
        """Numbers of rows (n,) between columns, 0 where they change."""
        return np.repeat(self.stretch, np.diff(self.first))

    @cached_property
    def counts(self) -> Index:
        """Numbers of rows (n + 1,) at the columns."""
        rows: Index = np.maximum(np.append(self.cells, 0), np.append(0, self.cells))
        rows[[0, -1]] = max(int(rows[0]), int(rows[-1]))
        return rows

    @cached_property
    def share(self) -> Floats:
        """u (n, m + 1) of the rows of every column, the last one's again where a column has fewer."""
        return np.minimum(np.arange(int(self.counts.max()) + 1) / self.counts[:-1, None], 1.0)

    @cached_property
    def inner(self) -> Mask:
        """Which of these stand between the edges, (n, m + 1)."""
        return (self.share > 0.0) & (np.arange(self.share.shape[1]) < self.counts[:-1, None])

    @cached_property
    def regular(self) -> Index:
        """Cells between columns in which rows stand beside each other: all of them, or but the outermost."""
        return np.flatnonzero(np.repeat((self.stretch > 0) & (self.even | (self.stretch > 2)), np.diff(self.first)))

    @cached_property
    def halves(self) -> tuple[Floats, Floats]:
        """phi (q,) and u (q, 2 k + 1) of the middles of the regular cells."""
        at, rows = self.regular, self.cells[self.regular]
        u = np.minimum(np.arange(2 * int(rows.max(initial=1)) + 1) / (2 * rows[:, None]), 1.0)
        return 0.5 * (self.phi[at] + self.phi[at + 1]), u

    @cached_property
    def strips(self) -> Strips | None:
        """What is not regular: between the edges and the first rows, and where the number of rows changes."""
        n, c = len(self.phi), self.counts
        single, several, change = (
            np.flatnonzero(on)
            for on in (~self.even & (self.stretch == 1), ~self.even & (self.stretch > 1), self.stretch == 0)
        )
        sizes = [len(single), len(several), len(several), len(change)]
        if not sum(sizes):
            return None
        # Vertices: lower edge, upper edge, first row, last row, then the columns beside changes from edge to edge.
        begin = np.cumsum([0, len(self.low), len(self.high), n, n])
        places = *self.ends, self.first, self.first

        def chain(which: int, stretch: Index) -> Index:
            ends = places[which]
            return np.stack([begin[which] + ends[stretch], ends[stretch + 1] - ends[stretch]], axis=1)

        columns, row = self.beside
        size = c[columns] + 1
        start = begin[4] + np.cumsum(size) - size
        each = np.stack([start, size - 1], axis=1)
        own = np.repeat(columns, size)
        phi = np.concatenate([self.low, self.high, self.phi, self.phi, self.phi[own]])
        u = np.concatenate([np.zeros(len(self.low)), np.ones(len(self.high)), 1.0 / c, 1.0 - 1.0 / c, row / c[own]])
        low = np.concatenate([chain(0, single), chain(0, several), chain(3, several), each[: len(change)]])
        high = np.concatenate([chain(1, single), chain(2, several), chain(1, several), each[len(change) :]])
        cell = np.clip(np.searchsorted(self.theta, phi, side="right") - 1, 0, len(self.theta) - 2)
        # From the lower edge chords lean as the first row asks, to the upper edge as the last one does.
        last = np.arange(len(phi)) < begin[2] if int(c.max()) > 1 else np.zeros(len(phi), dtype=bool)
        lean = np.where(last, self.lean[1][cell], self.lean[0][cell])
        far = 4.0 * float(self.theta[-1] - self.theta[0]) + 4.0
        # In a column that changes they lean the same way, up or down.
        finest = np.maximum(c[columns], np.roll(c[columns], len(change)))
        lean[begin[4] :] = -0.5 * np.sign(lean[begin[4] :]) / np.repeat(finest, size)
        return Strips.zipped(phi, u, low, high, np.repeat([False, True], [sum(sizes[:3]), sizes[3]]), lean, far)

    @cached_property
    def beside(self) -> tuple[Index, Index]:
        """Columns (2 s,) after and before the changes of rows, and the rows of all of them one after the other."""
        change = np.flatnonzero(self.stretch == 0)
        columns = self.first[np.concatenate([change + 1, change])]
        size = self.counts[columns] + 1
        return columns, np.arange(int(size.sum())) - np.repeat(np.cumsum(size) - size, size)

    def numbers(self, low: Index, high: Index, count: int) -> Numbers:
        """With the vertices of the edges, by rising phi, and the first one of its own."""
        own = self.counts[:-1] - 1
        start = count + np.cumsum(own) - own
        return Numbers(self, np.append(low, low[0]), np.append(high, high[0]), np.append(start, start[0]))


@dataclass(frozen=True, eq=False)
class Numbers:
    """The vertices of a band: of its edges, both ends of the turn included, and the first inner one of every column."""

    rows: Rows
    low: Index
    high: Index
    start: Index

    def grid(self, x: Floats, middle: Floats) -> tuple[Index, Floats]:
        """Corners (f, 3) and sags (f,) of regular cells from points at all columns, and half way between."""
        rows, at = self.rows, self.rows.regular
        counts, links = rows.cells[at], np.diff(rows.first)
        most, after = int(counts.max()), (at + 1) % (len(rows.phi) - 1)
        sag, rising = _cell_sags(x[:, at, : most + 1], x[:, after, : most + 1], middle)
        stretch = np.repeat(np.arange(len(links)), links)[at]
        row, aside = np.arange(most), np.where(rows.even[stretch], 0, 1)[:, None]
        on = (row >= aside) & (row < counts[:, None] - aside)
        corners = []
        for more in (0, 1):
            step = at - rows.first[stretch] + more
            number = self.start[at + more][:, None] + np.arange(-1, most)
            # Where edges have other steps than the columns these are not used.
            number[:, 0] = self.low[np.minimum(rows.ends[0][stretch] + step, len(self.low) - 1)]
            number[np.arange(len(at)), counts] = self.high[np.minimum(rows.ends[1][stretch] + step, len(self.high) - 1)]
            corners.append((number[:, :-1][on], number[:, 1:][on]))
        (p00, p01), (p10, p11) = corners
        diagonal = rising[on]
        each = np.empty((len(p00), 2, 3), dtype=np.int64)
        each[:, 0, 0], each[:, 0, 1], each[:, 0, 2] = p00, p10, np.where(diagonal, p11, p01)
        each[:, 1, 0], each[:, 1, 1], each[:, 1, 2] = np.where(diagonal, p00, p10), p11, p01
        return each.reshape(-1, 3), np.repeat(sag[on], 2)

    def strips(self, strips: Strips) -> Index:
        """Corners (f, 3) of strips."""
        rows = self.rows
        columns, row = rows.beside
        own = np.repeat(np.arange(len(columns)), rows.counts[columns] + 1)
        at = columns[own]
        # The node of each column: those after the changes come first.
        change = np.flatnonzero(rows.stretch == 0)
        node = np.concatenate([change + 1, change])[own]
        inner = self.start[at] + row - 1
        inner = np.where(row == 0, self.low[rows.ends[0][node]], inner)
        inner = np.where(row == rows.counts[at], self.high[rows.ends[1][node]], inner)
        last = self.start + np.maximum(rows.counts - 2, 0)
        number = np.concatenate([self.low, self.high, self.start, last, inner])
        return np.asarray(number[strips.corner])

    def column(self, at: Index) -> tuple[Index, Index]:
        """Inner vertices of columns, and the column of each by its place among them."""
        size = self.rows.counts[at] - 1
        own = np.repeat(np.arange(len(at)), size)
        return self.start[at][own] + np.arange(len(own)) - (np.cumsum(size) - size)[own], own


def _cell_sags(start: Floats, stop: Floats, middle: Floats) -> tuple[Floats, Mask]:
    """Sags (n, m) of the triangles of cells along the better diagonal, mm, and whether that is the rising one.

    start, stop  (3, n, m + 1) points on the columns before and after; middle (3, n, 2 m + 1) half way, rows doubled
    Along the rows and both diagonals as it is in their middles, along the columns what the others leave over.
    """
    p00, p01, p10, p11 = start[:, :, :-1], start[:, :, 1:], stop[:, :, :-1], stop[:, :, 1:]
    rise, fall = p11 - p00, p10 - p01
    normal = cross(rise, fall)
    length = np.sqrt(dot(normal, normal))
    normal /= np.where(length > 0.0, length, 1.0)
    row = 0.5 * (start + stop) - middle[:, :, ::2]
    centre = p00 + 0.5 * rise - middle[:, :, 1::2]
    low, high = dot(normal, row[:, :, :-1]), dot(normal, row[:, :, 1:])
    rising = dot(normal, centre)
    falling = rising + 0.5 * dot(normal, p10 + p01 - p00 - p11)
    across = 0.5 * (rising + falling - low - high)
    along = np.where(np.abs(low) > np.abs(high), low, high)
    side = np.maximum(np.abs(along), np.abs(across))
    twist = 0.25 * (rising - falling)
    one, other = np.maximum(side, np.abs(rising)), np.maximum(side, np.abs(falling))
    bowl = np.nonzero(along * across > twist * twist)
    if len(bowl[0]):
        a, b, c = 8.0 * along[bowl], 8.0 * twist[bowl], 8.0 * across[bowl]
        one[bowl] = np.maximum(one[bowl], patch_sag(a, -b, c))
        other[bowl] = np.maximum(other[bowl], patch_sag(a, b, c))
    return np.minimum(one, other), one <= other


@dataclass(frozen=True, eq=False)
class Request:
    """What is asked of bands at once: each its number, phi (n,) and u (n, m)."""

    asked: list[tuple[int, Floats, Floats]]

    def add(self, b: int, phi: Floats, u: Floats) -> int:
        """The place of the answer."""
        self.asked.append((b, phi, u))
        return len(self.asked) - 1


def meshed(bands: Sequence[Band], plan: Plan) -> Measured:
    """The facets of all rows and strips, measured."""
    every = [
        Rows(b, plan.phi[2 * b], plan.phi[2 * b + 2], plan.phi[2 * b + 1], plan.nodes[b], plan.rows[b], plan.even[b],
             plan.lean[b], plan.theta)
        for b in range(len(bands))
    ]  # fmt: skip
    cells = sum(int(rows.cells.sum()) for rows in every)
    if cells > MAX_CELLS:
        raise NotConverged(f"the tolerance needs {cells} cells, more than {MAX_CELLS}; ask for a coarser one")
    request = Request([])
    whole = [bool(rows.even.all()) for rows in every]
    columns = {r.b: request.add(r.b, r.phi[:-1], r.share) for r in every if len(r.regular) or r.counts.max() > 1}
    halves = {r.b: request.add(r.b, *r.halves) for r in every if len(r.regular)}
    strips = {r.b: request.add(r.b, r.strips.asked[0], r.strips.asked[1][:, None]) for r in every if r.strips}
    # An edge is the first or the last row of a band that shares its columns.
    edges_at: list[tuple[int, int]] = []
    for k in range(len(bands) + 1):
        if k < len(bands) and whole[k]:
            edges_at.append((columns[k], 0))
        elif k > 0 and whole[k - 1]:
            edges_at.append((columns[k - 1], -1))
        else:
            b, phi = min(k, len(bands) - 1), plan.phi[2 * k][:-1]
            edges_at.append((request.add(b, phi, np.full((len(phi), 1), float(k - b))), 0))
    found = points_of(bands, request.asked)
    vertices: list[tuple[Floats, Floats, Floats, Index]] = []
    edges: list[Index] = []
    count = 0
    for k, (place, row) in enumerate(edges_at):
        phi = plan.phi[2 * k][:-1]
        vertices.append((found[place][:, :, row], phi, np.zeros(len(phi)), np.full(len(phi), k)))
        edges.append(count + np.arange(len(phi)))
        count += len(phi)
    numbers, grids, sags, loose, mids = [], [], [], [], []
    for b, rows in enumerate(every):
        number = rows.numbers(edges[b], edges[b + 1], count)
        numbers.append(number)
        if b in columns:
            u = rows.share[rows.inner]
            phi = np.repeat(rows.phi[:-1], rows.counts[:-1] - 1)
            vertices.append((found[columns[b]][:, rows.inner], phi, u, np.full(len(u), -1)))
            count += len(u)
        if b in halves:
            corner, sag = number.grid(found[columns[b]], found[halves[b]])
            grids.append(corner)
            sags.append(sag)
        if rows.strips:
            loose.append(number.strips(rows.strips))
            mids.append(rows.strips.middles(found[strips[b]][:, :, 0]))
    points, phi, u, edge = (np.concatenate(each, axis=-1) for each in zip(*vertices))
    one = _shrunk(bands, points, numbers)
    corner = one[np.concatenate(grids + loose)]
    band = np.repeat([*halves, *strips], [len(each) for each in grids + loose])
    middle = np.concatenate(mids, axis=2)
    kept = _kept(corner)
    regular = len(corner) - middle.shape[2]
    first = np.concatenate(sags)[kept[:regular]] if grids else np.empty(0)
    facets = Facets(
        points, phi, u, edge, corner[kept], band[kept], tuple(one[each] for each in edges),
        float(plan.theta[-1] - plan.theta[0]),
    )  # fmt: skip
    return Measured(facets, first, middle[:, :, kept[regular:]])


def _kept(corner: Index) -> Mask:
    """Which triangles have three corners."""
    a, b, c = corner.T
    return np.asarray((a != b) & (b != c) & (c != a))


def _shrunk(bands: Sequence[Band], points: Floats, numbers: list[Numbers]) -> Index:
    """Numbers (v,) of the vertices: one for all of a column where a band has no width."""
    one = np.arange(points.shape[1])
    for band, number in zip(bands, numbers):
        if band.shrinks is None:
            continue
        rows = number.rows
        high = rows.high[:-1]
        at = np.minimum(np.searchsorted(high, rows.low[:-1] - SAME), len(high) - 1)
        pair = np.flatnonzero(np.abs(high[at] - rows.low[:-1]) < SAME)
        span = points[:, number.high[at[pair]]] - points[:, number.low[pair]]
        pair = pair[dot(span, span) < (SHRUNK * band.tolerance) ** 2]
        foot, other = number.low[pair], number.high[at[pair]]
        if band.shrinks == 1:
            foot, other = other, foot
        one[other] = foot
        angle = rows.low[pair]
        column = np.minimum(np.searchsorted(rows.phi, angle - SAME), len(rows.phi) - 2)
        on = np.flatnonzero(np.abs(rows.phi[column] - angle) < SAME)
        inner, own = number.column(column[on])
        one[inner] = foot[on][own]
    return one[one]
