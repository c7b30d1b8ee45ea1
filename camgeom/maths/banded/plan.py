"""Where the vertices of bands stand: the number of rows of each, stretch by stretch, and the angles of all columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from camgeom.errors import NotConverged
from camgeom.maths import Floats
from camgeom.maths.banded.facets import Band, Index, Mask, points_of
from camgeom.maths.sampling import MAX_CELLS, subdivided_knots
from camgeom.maths.surface import cross, dot

BLOCKS = 12
"""stretches of one number of rows between two knots"""
CELLS = 3
"""cells of angle in a block, in which second forms are measured"""
ACROSS = 4
"""cells across a band in which its second form is measured"""
FILL = 0.985
"""aim of steps and rows as a share of the tolerance, so that third-order terms stay inside it"""
GROWTH = 1.1
"""of the numbers of rows to choose from"""
MOST = 4000
"""rows of a band"""
LONGER = 2.5
"""times the step of a band's columns that its edges may have"""
CHANGE = 0.45
"""of a block, in which the number of rows may change"""
THIN = 8.0
"""times the tolerance below which a band is so narrow that its edges and columns have the same steps"""
LEANS = np.array([-0.5, -0.25, 0.0, 0.25, 0.5])
"""of a step, to choose from: how far chords to the next row stand off on the average"""


@dataclass(frozen=True, eq=False)
class Form:
    """Second form of a band in cells of angle and of u, (n, ACROSS); L at its two edges and least width (n,), mm."""

    L: Floats
    M: Floats
    N: Floats
    edges: tuple[Floats, Floats]
    width: Floats

    def steps(self, counts: Index, room: float, longest: Floats) -> Floats:
        """Longest steps (q, n) of the columns with so many rows (q,) and sags to room / 8; 0 where none is.

        Where both sides are within the room, so is the better diagonal but where 2 |M| h g takes off more than the room
        and what the sides leave: | |L| h² - |N| g² | where the patch is bent to both sides, else their sum.
        """
        g = 1.0 / counts[:, None, None]
        along, across, twist = np.abs(self.L), np.abs(self.N) * (g * g), np.abs(self.M) * g
        shape = self.L * self.N
        saddle = shape < 0.0
        longer = np.sqrt(room / np.maximum(along, 1e-300))
        h = np.minimum(longer, _root(np.where(saddle, -along, along), twist, room + across))
        # Beyond the step at which both sides are alike.
        h = np.where(saddle & (along * h * h > across), np.minimum(longer, _root(along, twist, room - across)), h)
        bowl = shape > self.M * self.M
        if bowl.any():
            h = np.where(bowl, np.sqrt(np.maximum(room - across, 0.0) / np.maximum(along, 1e-300)), h)
        return np.asarray(np.minimum(np.where(across <= room, h, 0.0).min(axis=2), longest))


def _root(a: Floats, b: Floats, c: Floats) -> Floats:
    """Least h > 0 with a h² - 2 b h + c = 0, b and c >= 0; infinite where there is none."""
    inside = b * b - a * c
    low = b + np.sqrt(np.maximum(inside, 0.0))
    return np.asarray(np.where((inside >= 0.0) & (low > 0.0), c / np.maximum(low, 1e-300), np.inf))


def forms_of(bands: Sequence[Band], theta: Floats) -> list[Form]:
    """The second forms of bands in the cells of angles theta (n + 1,)."""
    k = 2 * ACROSS + 1
    step = 0.5 * np.diff(theta)
    phi = np.append(np.stack([theta[:-1], theta[:-1] + step], axis=1).ravel(), theta[-1])
    u = np.broadcast_to(np.arange(k) / (k - 1), (len(phi), k))
    return [_form(x, step) for x in points_of(bands, [(b, phi, u) for b in range(len(bands))])]


def _form(x: Floats, h: Floats) -> Form:
    """Of points (3, 2 n + 1, 2 ACROSS + 1), half a cell h (n,) apart in angle."""
    before, here, after = x[:, :-1:2], x[:, 1::2], x[:, 2::2]
    along = after - before
    bent = after + before - 2.0 * here
    low, at, high = slice(0, -2, 2), slice(1, None, 2), slice(2, None, 2)
    normal = cross(along[:, :, at], here[:, :, high] - here[:, :, low])
    size = np.sqrt(dot(normal, normal))
    normal /= np.where(size > 0.0, size, 1.0)
    twist = along[:, :, high] - along[:, :, low]
    curl = here[:, :, high] + here[:, :, low] - 2.0 * here[:, :, at]
    step = h[:, None]
    square = step * step
    span = x[:, :, -1] - x[:, :, 0]
    width = np.sqrt(dot(span, span))
    return Form(
        dot(normal, bent[:, :, at]) / square, dot(normal, twist) * (ACROSS / (2.0 * step)),
        dot(normal, curl) * (4.0 * ACROSS**2),
        (dot(normal[:, :, 0], bent[:, :, 0]) / square[:, 0], dot(normal[:, :, -1], bent[:, :, -1]) / square[:, 0]),
        np.minimum(np.minimum(width[:-1:2], width[1::2]), width[2::2]),
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Plan:
    """Where the vertices stand. Owners of angles are, by turns, the edges and the columns of the bands.

    phi     of each owner its angles (n + 1,), both ends of the turn included
    nodes   of each band the angles between its stretches
    rows    of each band the number of rows in each of these stretches, 0 where it changes in one column
    even    of each band in which of these its edges have the steps of its columns
    lean    of each band, at its first row and its last: step along phi to the next row that joins best, by cell
    theta   angles of the cells
    """

    theta: Floats
    phi: list[Floats]
    nodes: list[Floats]
    rows: list[Index]
    even: list[Mask]
    lean: list[tuple[Floats, Floats]]


def planned(bands: Sequence[Band], knots: Floats) -> Plan:
    """Rows block by block, and the angles of every edge and of every band's columns."""
    theta = subdivided_knots(knots, BLOCKS * CELLS)
    width = np.diff(theta)
    longest = np.repeat(np.diff(knots), BLOCKS * CELLS)
    n, many = len(width), 2 * len(bands) + 1
    density = np.zeros((many, n))
    count = np.empty((len(bands), n // CELLS), dtype=np.int64)
    tied = np.zeros(count.shape, dtype=bool)
    lean: list[tuple[Floats, Floats]] = []
    for b, (band, form) in enumerate(zip(bands, forms_of(bands, theta))):
        room = 8.0 * FILL * band.room
        choice = _choice(form, room)
        h = form.steps(choice, room, longest)
        cost = np.where(h > 0.0, choice[:, None] * width / np.where(h > 0.0, h, 1.0), np.inf)
        pick = cost.reshape(len(choice), -1, CELLS).sum(axis=2).argmin(axis=0)
        count[b] = choice[pick]
        cell = np.repeat(pick, CELLS)
        step = h[cell, np.arange(n)]
        single = choice[cell] == 1
        own = 1.0 / step
        density[2 * b + 1] = own
        for end in (0, 1):
            bend = np.maximum(np.sqrt(np.abs(form.edges[end]) / room), np.where(single, own, own / LONGER))
            edge = density[2 * b + 2 * end]
            if end == 0 and band.sharp:
                np.sqrt(np.hypot(edge * edge, bend * bend), out=edge)
            else:
                np.maximum(edge, bend, out=edge)
        lean.append(_leans(form, choice[cell], step))
        tied[b] = band.even
        if band.shrinks is not None:
            tied[b] |= (form.width < THIN * band.tolerance).reshape(-1, CELLS).any(axis=1)
    return _nodes(bands, knots, theta, density, count, tied, lean)


def _choice(form: Form, room: float) -> Index:
    """Numbers of rows to choose from; the last one allows a step everywhere."""
    most = int(1.05 * np.sqrt(float(np.abs(form.N).max()) / room)) + 2
    if most > MOST:
        raise NotConverged(f"the chord error asks for more than {MOST} rows: the surface is nearly singular")
    found = [1]
    while found[-1] < 1.5 * most:
        found.append(max(found[-1] + 1, int(found[-1] * GROWTH)))
    return np.array(found)


def _leans(form: Form, count: Index, step: Floats) -> tuple[Floats, Floats]:
    """Of the first and the last row, where chords to the next one, half a step to either side, sag least."""
    found = []
    for k in (0, -1):
        along, twist, across = form.L[:, k] * step * step, form.M[:, k] * step / count, form.N[:, k] / (count * count)
        p = np.stack([LEANS - 0.5, LEANS + 0.5])[:, :, None]
        worst = np.abs((along * p + 2.0 * twist) * p + across).max(axis=0)
        found.append(LEANS[worst.argmin(axis=0)] * step)
    return found[0], found[1]


def _nodes(
    bands: Sequence[Band], knots: Floats, theta: Floats, density: Floats, count: Index, tied: Mask,
    lean: list[tuple[Floats, Floats]],
) -> Plan:  # fmt: skip
    """The plan from steps per radian (2 b + 1, n) of all owners, rows (b, m) of every block, and which are tied."""
    n, m, many = density.shape[1], count.shape[1], len(density)
    ends = theta[::CELLS]
    joined = np.zeros((many, m), dtype=bool)
    for k in range(3):
        joined[k : many - 2 + k : 2] |= tied
    cells = np.repeat(tied, CELLS, axis=1)
    for row in _passes(tied):
        group = density[2 * row : 2 * row + 3]
        np.copyto(group, group.max(axis=0), where=cells[row])
    # Where a band changes its rows (at the start of a block, the first one's at the turn's), and at what is tied there.
    change = count != np.roll(count, 1, axis=1)
    moved = np.zeros((many, m), dtype=bool)
    for k in range(3):
        moved[k : many - 2 + k : 2] |= change
    # One column beside the start takes up the change, on the side of the longer steps.
    total = density.sum(axis=0)
    on = total[::CELLS] < np.roll(total[CELLS - 1 :: CELLS], 1)
    there = np.where(on, np.arange(m), np.arange(m) - 1) % m
    for row in _passes(tied):
        group = moved[2 * row : 2 * row + 3]
        np.copyto(group, group.any(axis=0), where=tied[row][there])
    cell = np.where(on, np.arange(m) * CELLS, np.arange(m) * CELLS - 1) % n
    finest = np.where(moved, density[:, cell], 0.0).max(axis=0)
    wide = np.minimum(1.0 / np.maximum(finest, 1e-300), CHANGE * np.diff(ends)[there])
    beside = np.where(on, ends[:-1] + wide, np.where(np.arange(m) > 0, ends[:-1], ends[-1]) - wide)
    node = np.zeros((many, m + 1), dtype=bool)
    node[:, :-1] = moved | (joined != np.roll(joined, 1, axis=1))
    node |= np.isin(ends, knots)
    for row in _passes(tied):
        group = node[2 * row : 2 * row + 3]
        np.copyto(group, group.any(axis=0), where=np.append(tied[row], False) | np.append(False, tied[row]))
    one, at = np.nonzero(node)
    other, place = np.nonzero(moved)
    owner = np.concatenate([one, other])
    where = np.concatenate([ends[at], beside[place]])
    # A column of change starts at the block's start, or beside it.
    starts = np.zeros((many, m + 1), dtype=bool)
    starts[:, :-1] = moved & on
    single = np.concatenate([starts[one, at], ~on[place]])
    order = np.lexsort((where, owner))
    owner, where, single = owner[order], where[order], single[order]
    last = np.append(owner[1:] != owner[:-1], True)
    inner = np.flatnonzero(~last)
    phi = _cut(theta, node, density, owner[inner], where[inner], where[inner + 1], single[inner])
    nodes, rows, even = [], [], []
    for b in range(len(bands)):
        own = np.flatnonzero(owner == 2 * b + 1)
        nodes.append(where[own])
        middle = 0.5 * (where[own[1:]] + where[own[:-1]])
        block = np.clip(np.searchsorted(ends, middle, side="right") - 1, 0, m - 1)
        even.append(tied[b, block])
        # What is tied to a band that changes its rows need not change its own.
        stretch = count[b, block]
        changes = single[own[:-1]] & (np.roll(stretch, 1) != np.roll(stretch, -1))
        rows.append(np.where(changes, 0, stretch))
    return Plan(theta, phi, nodes, rows, even, lean)


def _passes(tied: Mask) -> list[int]:
    """Bands that are tied somewhere, up and down again."""
    some = np.flatnonzero(tied.any(axis=1)).tolist()
    return [*some, *some[-2::-1]]


def _cut(
    theta: Floats, nodes: Mask, density: Floats, owner: Index, start: Floats, stop: Floats, single: Mask
) -> list[Floats]:
    """Angles of every owner (d,), by stretches that lie one after the other, of steps per radian `density` (d, n).

    The density at an angle is that of the sharper cell beside it, linear to the middles of cells; none beyond the
    starts of blocks that are `nodes` (d, m + 1).
    """
    d, n = density.shape
    left, right = density.copy(), density.copy()
    greater = np.maximum(density[:, 1:], density[:, :-1])
    ends = np.zeros((d, n - 1), dtype=bool)
    ends[:, CELLS - 1 :: CELLS] = nodes[:, 1:-1]
    left[:, 1:] = np.where(ends, density[:, 1:], greater)
    right[:, :-1] = np.where(ends, density[:, :-1], greater)
    half = 0.5 * np.diff(theta)
    total = np.zeros((d, 2 * n + 1))
    total[:, 1::2] = 0.5 * (left + density) * half
    total[:, 2::2] = 0.5 * (density + right) * half
    np.cumsum(total, axis=1, out=total)
    fine = np.append(np.stack([theta[:-1], theta[:-1] + half], axis=1).ravel(), theta[-1])
    # One table for all owners, one after the other.
    lift = np.append(0.0, np.cumsum(total[:-1, -1] + 1.0))[:, None]
    aside = (theta[-1] - theta[0] + 1.0) * np.arange(d)
    x, y = (fine + aside[:, None]).ravel(), (total + lift).ravel()
    low, high = (np.interp(at + aside[owner], x, y) for at in (start, stop))
    steps = np.where(single, 1, np.maximum(1, np.ceil(high - low - 1e-6))).astype(np.int64)
    if int(steps.sum()) > MAX_CELLS:
        raise NotConverged(f"the tolerance needs more than {MAX_CELLS} vertices; ask for a coarser one")
    first = np.cumsum(steps) - steps
    each = np.repeat(np.arange(len(owner)), steps)
    share = (np.arange(len(each)) - first[each]) / steps[each]
    phi = np.interp(low[each] + (high - low)[each] * share, y, x) - aside[owner[each]]
    phi[first] = start
    parts = np.split(phi, first[np.flatnonzero(np.diff(owner)) + 1])
    return [np.append(part, theta[-1]) for part in parts]
