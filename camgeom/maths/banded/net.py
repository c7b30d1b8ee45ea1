"""Vertices and triangles of a plan: which stand beside each other, and where the surface is asked for them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.banded.facets import Asked, Band, Corners, Index, Mask, points_of
from camgeom.maths.banded.plan import NetPlan, across
from camgeom.maths.frozen import cached_property
from camgeom.maths.surface import dot


@immutable
class Strips:
    """Triangles between chains of vertices that do not stand beside each other.

    phi, u   of the vertices of the chains, and the vertex of each: number
    corner   (f, 3) places of the triangles' corners among them
    ends     (c, 2) places of both ends of every chord from chain to chain: before each triangle, and the last of each
             strip; links (f, 2): of the links of chains
    is_low   (f,) whether two corners of a triangle are on the lower chain; after (f,): number of the chord behind it
    band     of every triangle, and then of the strips' last chords
    """

    phi: Floats
    u: Floats
    number: Index
    corner: Index
    ends: Index
    links: Index
    is_low: Mask
    after: Index
    band: Index

    @classmethod
    def zipped(
        cls, phi: Floats, u: Floats, number: Index, band: Index, low: Index, high: Index, across: Mask, lean: Floats,
        far: float,
    ) -> Strips:  # fmt: skip
        """Between chains low and high (s, 2): the place of the first vertex of each, and the number of links.

        phi, u  of the vertices of all chains (c,), and the number of each; a chain is a piece of them
        band    (s,) of each strip
        across  (s,) whether the chains run along u, not along phi
        lean    (c,) at vertices of the higher chain, by how much those of the lower one best stand before them
        far     more than phi and u change in all
        Every link is joined to the nearest vertex of the other chain.
        """
        (s, i), (t, j) = _links(low), _links(high)
        one = 0.5 * np.where(across[s], u[i] + u[i + 1], phi[i] + phi[i + 1]) + far * s
        other = 0.5 * np.where(across[t], u[j] + u[j + 1], phi[j] + phi[j + 1]) - lean[j] + far * t
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
        final = np.flatnonzero(np.append(strip[1:] != strip[:-1], [True] * min(size, 1)))
        after = np.arange(1, size + 1)
        after[final] = size + np.arange(len(final))
        last = strip[final]
        ends = np.stack([np.append(a, low[last].sum(axis=1)), np.append(c, high[last].sum(axis=1))], axis=1)
        return cls(
            phi, u, number, np.stack([a, link + 1, c], axis=1), ends, np.stack([link, link + 1], axis=1), is_low, after,
            band[np.append(strip, last)],
        )  # fmt: skip

    @staticmethod
    def middle(x: Floats, ends: Index) -> Floats:
        """Half way (n,) between two places (n, 2)."""
        return np.asarray(0.5 * (x[ends[:, 0]] + x[ends[:, 1]]))

    def middles(self, chords: Floats, links: Floats) -> Floats:
        """True middles (3, 3, f) of the triangles' edges from those of all chords (3, c) and of the links (3, f)."""
        beyond = chords[:, self.after]
        mids = np.empty((3, 3, len(self.is_low)))
        mids[:, 0] = np.where(self.is_low, links, beyond)
        mids[:, 1] = np.where(self.is_low, beyond, links)
        mids[:, 2] = chords[:, : len(self.is_low)]
        return mids


def _links(chains: Index) -> tuple[Index, Index]:
    """Of every link of chains (s, 2) its chain, and the place of its first vertex."""
    return counted(chains[:, 1], chains[:, 0])


def counted(size: Index, start: Index) -> tuple[Index, Index]:
    """Of runs of so many numbers (s,) from their starts, one after the other: the run of each, and the numbers."""
    own = np.repeat(np.arange(len(size)), size)
    return own, np.arange(len(own)) + (start - np.cumsum(size) + size)[own]


SHRUNK = 1e-3
"""share of the tolerance below which a band has no width, and its two edges one vertex"""
SAME = 1e-9
"""difference of angles, rad, that are the same"""
PADDED = 8192
"""points of a band beyond which columns of like numbers of rows are asked for together"""
LIKE = 1.3
"""times the rows that are still like"""


@immutable
class Request:
    """Points asked of bands, and where they belong in one array of all (3, t)."""

    asked: list[Asked]
    to: list[Index | slice]
    on: list[Mask | None]

    def add(self, b: int, phi: Floats, u: Floats, to: Index | slice, on: Mask | None = None) -> None:
        """Points at phi (n,) and u (n, m), of which some (n, m) are wanted."""
        # Rows are few and angles many: what is done to all of them runs along the angles.
        self.asked.append(Asked(b, phi, np.asfortranarray(u)))
        self.to.append(to)
        self.on.append(None if on is None or on.all() else on)

    def told(self, bands: Sequence[Band], size: int) -> Floats:
        """All of them, (3, size)."""
        every = np.empty((3, size))
        for x, to, on in zip(points_of(bands, self.asked), self.to, self.on):
            x = x.reshape(3, -1)
            every[:, to] = x if on is None else x.take(np.flatnonzero(on), axis=1)
        return every


@immutable
class Net:
    """Vertices and triangles of a plan. `a` places stand in `plan.phi`, `g` gaps between a column and the next one."""

    plan: NetPlan

    @cached_property
    def owner(self) -> Index:
        """Of every place its owner, (a,)."""
        return np.repeat(np.arange(len(self.plan.begin) - 1), np.diff(self.plan.begin))

    @cached_property
    def closing(self) -> Index:
        """The last place of every owner, which is the first one again where the bands are closed."""
        return self.plan.begin[1:] - 1

    @cached_property
    def gaps(self) -> tuple[Index, Index]:
        """Stretch and place of the column before every gap, (g,) each."""
        column = self.plan.place[1]
        return counted(column[:, 1] - column[:, 0], column[:, 0])

    @cached_property
    def counts(self) -> Index:
        """Numbers of rows at every column, (a,); 2 at the vertices of edges."""
        stretch, at = self.gaps
        found = np.zeros(len(self.plan.phi), dtype=np.int64)
        found[at] = self.plan.rows[stretch]
        found[at + 1] = np.maximum(found[at + 1], self.plan.rows[stretch])
        first, last = self.plan.begin[1:-1:2], self.closing[1::2]
        found[first] = found[last] = np.maximum(found[first], found[last])
        found[self.owner % 2 == 0] = 2
        return found

    @cached_property
    def size(self) -> Index:
        """Vertices at every place, (a,)."""
        size = self.counts - 1
        if self.plan.closed:
            size[self.closing] = 0
        return size

    @cached_property
    def start(self) -> Index:
        """The first vertex at every place, (a,)."""
        found = np.cumsum(self.size) - self.size
        if self.plan.closed:
            found[self.closing] = found[self.plan.begin[:-1]]
        return found

    @cached_property
    def vertices(self) -> tuple[Index, Floats, Index]:
        """Place of every vertex, and its u; on an edge that is 0 or 1 by the band, and the edge's number is not -1."""
        place, row = counted(self.size, np.ones_like(self.size))
        edge = np.where(self.owner % 2 == 0, self.owner // 2, -1)[place]
        return place, np.where(edge < 0, self.ways(place, row / self.counts[place]), 0.0), edge

    def ways(self, place: Index, share: Floats) -> Floats:
        """Ways across (n,) the bands of columns at some places of rows at shares of their number."""
        band = np.minimum(self.owner[place] // 2, len(self.whole) - 1)
        return across(self.plan.spacing[:, band], share)

    def edge(self, k: int) -> Index:
        """Places of an edge's vertices."""
        return np.arange(self.plan.begin[2 * k], self.closing[2 * k] + (not self.plan.closed))

    @cached_property
    def regular(self) -> Index:
        """Gaps in which rows stand beside each other: all of them, or but the outermost."""
        stretch, _ = self.gaps
        return np.flatnonzero(((self.plan.rows > 0) & (self.plan.even | (self.plan.rows > 2)))[stretch])

    def cells(self, gaps: Index) -> tuple[Corners, Index, Index]:
        """Of all regular cells in some gaps the vertices at their corners (4, c): before low, high, after low, high;
        the number of the gap, and of the row."""
        plan, (stretch, at) = self.plan, self.gaps
        stretch, at = stretch[gaps], at[gaps]
        aside = np.where(plan.even[stretch], 0, 1)
        gap, row = counted(plan.rows[stretch] - 2 * aside, aside)
        step = at - plan.place[1, stretch, 0]
        found = np.empty((4, len(gap)), dtype=np.int32)
        top = row + 1 == plan.rows[stretch][gap]
        for more in (0, 1):
            number = self.start[at + more][gap] + row
            # Where edges have other steps than the columns these are not used.
            low, high = (
                self.start[np.minimum(plan.place[k, stretch, 0] + step + more, len(self.start) - 1)] for k in (0, 2)
            )
            found[2 * more] = np.where(row == 0, low[gap], number - 1)
            found[2 * more + 1] = np.where(top, high[gap], number)
        return found, gap, row

    @cached_property
    def strips(self) -> Strips:
        """What is not regular: between the edges and the first rows, and where the number of rows changes."""
        plan, owner, c = self.plan, self.owner, self.counts
        a, every, u0 = len(plan.phi), np.arange(len(plan.phi)), 1.0 / c
        low, column, high = ((x[:, 0], x[:, 1] - x[:, 0]) for x in plan.place)
        single, several, change = (
            np.flatnonzero(on)
            for on in (~plan.even & (plan.rows == 1), ~plan.even & (plan.rows > 1), plan.rows == 0)
        )
        # Vertices of lower chains, edges and last rows; of upper ones, edges and first rows; columns beside changes.
        after, before = plan.place[1, change, 1], plan.place[1, change, 0]
        beside = np.concatenate([after, before])
        size = c[beside] + 1
        own, row = counted(size, np.zeros_like(size))
        start = 2 * a + np.cumsum(size) - size
        chains = [
            ((low[0][single], low[1][single]), (a + high[0][single], high[1][single])),
            ((low[0][several], low[1][several]), (a + column[0][several], column[1][several])),
            ((column[0][several], column[1][several]), (a + high[0][several], high[1][several])),
            ((start[: len(change)], c[after]), (start[len(change) :], c[before])),
        ]
        kinds = [single, several, several, change]
        stretch = np.concatenate(kinds)
        order = plan.band[stretch].argsort(kind="stable")
        lower, upper = (
            np.stack([np.concatenate([chain[side][k] for chain in chains]) for k in (0, 1)], axis=1)[order]
            for side in (0, 1)
        )
        edge = owner % 2 == 0
        phi = np.concatenate([plan.phi, plan.phi, plan.phi[beside][own]])
        start, stop = self.ways(every, u0), self.ways(every, 1.0 - u0)
        inside = self.ways(beside[own], row / c[beside][own])
        u = np.concatenate([np.where(edge, 0.0, stop), np.where(edge, 1.0, start), inside])
        last = self.start + np.where(edge, 0, np.maximum(c - 2, 0))
        at_low, at_high = (
            self.start[np.concatenate([plan.place[k, change, 1], plan.place[k, change, 0]])][own] for k in (0, 2)
        )
        inner = np.where(row == 0, at_low, np.where(row == c[beside][own], at_high, self.start[beside][own] + row - 1))
        number = np.concatenate([last, self.start, inner])
        # From the lower edge chords lean as the first row asks, to the upper edge as the last one does.
        cell = np.clip(np.searchsorted(plan.theta, plan.phi, side="right") - 1, 0, len(plan.theta) - 2)
        lean = plan.lean[np.where(edge, 1, 0), np.maximum((owner - 1) // 2, 0), cell]
        # In a column that changes they lean the same way, up or down.
        finest = np.maximum(c[beside], np.roll(c[beside], len(change)))
        turned = -0.5 * np.sign(plan.lean[0, (owner[beside] - 1) // 2, cell[beside]]) / finest
        across = np.repeat([False, True], [len(stretch) - len(change), len(change)])[order]
        far = 4.0 * float(plan.theta[-1] - plan.theta[0]) + 4.0
        lean = np.concatenate([lean, lean, turned[own]])
        return Strips.zipped(phi, u, number, plan.band[stretch[order]], lower, upper, across, lean, far)

    @cached_property
    def edge_links(self) -> Mask:
        """Which links of strips are on edges, (f,)."""
        at, a = self.strips.links[:, 0], len(self.owner)
        return np.asarray((at < 2 * a) & (self.owner % 2 == 0)[at % a])

    @cached_property
    def whole(self) -> Mask:
        """Bands (b,) whose edges have the steps of their columns all along."""
        band = self.plan.band
        return np.logical_and.reduceat(self.plan.even, np.flatnonzero(np.append(True, band[1:] != band[:-1])))

    def opposite(self, columns: Index, k: int) -> Index:
        """Places on the edges below (0) or above (2) the columns at some places, of bands that are whole."""
        begin, owner = self.plan.begin, self.owner[columns]
        return np.asarray(columns - begin[owner] + begin[owner - 1 + k])

    @staticmethod
    def grouped(at: Index, band: Index, rows: Index) -> list[tuple[int, Index]]:
        """Those of each band, in order of the bands, with nearly as many rows where they are many."""
        found = []
        if not len(band):
            return []
        for low, high in pairwise(np.flatnonzero(np.concatenate([[True], band[1:] != band[:-1], [True]])).tolist()):
            own, many = at[low:high], rows[low:high]
            if len(own) * int(many.max()) <= PADDED:
                found.append((int(band[low]), own))
                continue
            like = (np.log(many) / np.log(LIKE)).astype(np.int64)
            found += [(int(band[low]), own[like == k]) for k in distinct(like).tolist()]
        return found

    def ask_columns(self, request: Request, known: Mask) -> None:
        """Ask for the inner vertices of all columns, and for those of edges that have the same steps; marks these."""
        plan, counts = self.plan, self.counts
        on = (self.owner % 2 == 1) & ((counts > 1) | self.whole[np.minimum(self.owner // 2, len(self.whole) - 1)])
        on[self.closing] &= not self.plan.closed
        columns = np.flatnonzero(on)
        for b, own in self.grouped(columns, self.owner[columns] // 2, counts[columns]):
            rows, whole = counts[own], bool(self.whole[b])
            row = np.arange(0 if whole else 1, int(rows.max()) + (1 if whole else 0))
            to = self.start[own][:, None] + row - 1
            if whole:
                for k, side in ((0, np.zeros_like(rows)), (2, rows)):
                    edge = self.opposite(own, k)
                    to[np.arange(len(own)), side] = self.start[edge]
                    known[edge] = True
            wanted = row < rows[:, None] + (1 if whole else 0)
            u = across(plan.spacing[:, b], np.minimum(row / rows[:, None], 1.0))
            request.add(b, plan.phi[own], u, to[wanted], wanted)

    def ask_middles(self, request: Request, gaps: list[tuple[int, Index]], first: int) -> None:
        """Ask for the points half way in regular gaps, rows doubled, one after the other from `first` on."""
        stretch, at = self.gaps
        for b, own in gaps:
            rows = 2 * self.plan.rows[stretch[own]]
            row = np.arange(int(rows.max()) + 1)
            wanted = row <= rows[:, None]
            phi = 0.5 * (self.plan.phi[at[own]] + self.plan.phi[at[own] + 1])
            last = first + int(rows.sum()) + len(rows)
            u = across(self.plan.spacing[:, b], np.minimum(row / rows[:, None], 1.0))
            u[:, 1::2] = 0.5 * (u[:, :-1:2] + u[:, 2::2])
            request.add(b, phi, u, slice(first, last), wanted)
            first = last

    def ask_alone(self, request: Request, vertex: Mask, half: Mask, halves: int, chords: int, links: int) -> None:
        """Ask for the vertices of edges and the middles of their links at some places (a,), and for the middles of the
        strips' chords and of their links that are not on edges."""
        plan, strips = self.plan, self.strips
        size, count = len(strips.links), len(self.whole)
        middle = 0.5 * (plan.phi[1:] + plan.phi[:-1])
        every = np.arange(count + 1)
        final = size + np.searchsorted(strips.band[size:], every)
        before = np.searchsorted(strips.band[:size], every)
        inner = np.flatnonzero(~self.edge_links)
        rows = np.searchsorted(strips.band[inner], every)
        for b in range(count):
            own = np.r_[before[b] : before[b + 1], final[b] : final[b + 1]]
            link = inner[rows[b] : rows[b + 1]]
            ends = strips.ends[own], strips.links[link]
            phi, u = ([strips.middle(x, each) for each in ends] for x in (strips.phi, strips.u))
            to = [chords + own, links + link]
            for k in (0, 1) if b + 1 == count else (0,):
                edge = self.edge(b + k)
                one, other = edge[vertex[edge]], edge[half[edge]]
                phi += [plan.phi[one], middle[other]]
                u.append(np.full(len(one) + len(other), float(k)))
                to += [self.start[one], halves + other]
            place = np.concatenate(to)
            if len(place):
                request.add(b, np.concatenate(phi), np.concatenate(u)[:, None], place)

    def shrunk(self, bands: Sequence[Band], points: Floats) -> Corners | None:
        """Numbers (v,) of the vertices: one for all of a column where a band has no width; None where all have one."""
        one, phi, begin = np.arange(points.shape[1], dtype=np.int32), self.plan.phi, self.plan.begin
        some = False
        for b, band in enumerate(bands):
            if band.shrinks is None:
                continue
            low, high = self.edge(b), self.edge(b + 1)
            at = np.minimum(np.searchsorted(phi[high], phi[low] - SAME), len(high) - 1)
            pair = np.flatnonzero(np.abs(phi[high][at] - phi[low]) < SAME)
            foot, other, angle = self.start[low[pair]], self.start[high[at[pair]]], phi[low[pair]]
            span = points[:, other] - points[:, foot]
            gone = dot(span, span) < (SHRUNK * band.tolerance) ** 2
            foot, other, angle = foot[gone], other[gone], angle[gone]
            if band.shrinks == 1:
                foot, other = other, foot
            one[other] = foot
            column = begin[2 * b + 1] + np.searchsorted(phi[begin[2 * b + 1] : self.closing[2 * b + 1]], angle - SAME)
            on = np.flatnonzero(np.abs(phi[column] - angle) < SAME)
            own, inner = counted(self.size[column[on]], self.start[column[on]])
            one[inner] = foot[on][own]
            some = some or len(foot) > 0
        return one[one] if some else None
