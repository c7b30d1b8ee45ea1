"""Where the vertices of bands stand: the number of rows of each, stretch by stretch, and the angles of all columns."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from camgeom.errors import NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.banded.facets import Asked, Band, Index, Mask, points_of
from camgeom.maths.sampling import MAX_CELLS, subdivided_knots, too_many
from camgeom.maths.surface import cross, dot

BLOCKS, FEW, MANY = 100, 6, 15
"""stretches of one number of rows round the turn, evenly between its knots, and so many at least and at most between
two of them"""
BESIDE = 12
"""the same between two knots where something beyond the bands asks for steps of its own (all measured on the shipped
drums and indexing cams)"""
CELLS = 3
"""cells of angle in a block, in which second forms are measured"""
ACROSS = 4
"""cells across a band in which its second form is measured"""
FILL = 0.985
"""aim of steps and rows as a share of the tolerance, so that third-order terms stay inside it"""
SPARSE, DENSE = 1.6, 0.75
"""most and least distance of rows at an edge of a band, of their average one"""
GROWTH = 1.25
"""of the numbers of rows to choose from"""
SWITCH = 1.5
"""columns that a change of the number of rows counts as: columns are rounded up on either side of it, those of bands
that share an edge too (measured; where something is beyond the bands it takes more triangles, and is left out)"""
MOST = 4000
"""rows of a band"""
LONGER = 2.5
"""times the step of a band's columns that its edges may have"""
CHANGE = 0.45
"""of a block, in which the number of rows may change"""
THIN = 8.0
"""times the tolerance below which a band is so narrow that its edges and columns have the same steps"""
CALM = 0.1
"""share of the tolerance that a band may sag to be one that does not twist"""
ASIDE = 0.25
"""of the distance of two rows, by which chords of one may leave it within the surface"""
Longest = Callable[[Floats, Floats], Floats]
"""steps (2, n) at angles (n,) of the first edge and the last, whose points there are (2, 3, n)"""
LEANS = np.array([-0.5, -0.25, 0.0, 0.25, 0.5])
"""of a step, to choose from: how far chords to the next row stand off on the average"""


@immutable
class CellForms:
    """Second forms of bands in cells of u and of angle, (b, ACROSS, n); L at both edges (2, b, n), least width (b, n),
    mm, and how sharply rows turn within the surface, mm/rad², (b, n); points (2, 3, n) of the first edge and the last
    in the middles of cells."""

    L: Floats
    M: Floats
    N: Floats
    edges: Floats
    width: Floats
    turns: Floats
    ends: Floats

    def within(self, which: Index, counts: Index, tolerance: Floats) -> Floats:
        """Longest steps at which chords of some bands' rows, so many (q, b, n), stay beside each other, or within the
        tolerance (b,)."""
        aside = np.maximum(ASIDE * self.width[which] / counts, tolerance[which, None])
        return np.asarray(np.sqrt(8.0 * aside / np.maximum(self.turns[which], 1e-300)))

    def spacing(self, width: Floats, longest: Floats, room: Floats) -> Floats:
        """Distances (2, b) of rows at both edges of bands, of the average one: they follow what each cell across asks
        for, on the average of all triangles.

        width, longest  of the cells of angle, and their longest steps (n,); room: 8 times the sag of each band (b,)
        """
        room = room[:, None, None]
        step = np.minimum(np.sqrt(room / np.maximum(np.abs(self.L).max(axis=1, keepdims=True), 1e-300)), longest)
        rows = np.maximum(np.sqrt(np.abs(self.N) / room), np.abs(self.M) * step / room)
        # Where one row is enough it has no other to stand nearer to.
        several = rows.max(axis=1, keepdims=True) > 1.0
        density = (rows * np.where(several, width / step, 0.0)).sum(axis=2)
        mean, ends = density.mean(axis=1), density[:, [0, -1]].T
        return np.clip(np.where(mean > 0.0, mean / np.maximum(ends, 1e-9 * mean + 1e-300), 1.0), DENSE, SPARSE)

    def spaced(self, spacing: Floats) -> CellForms:
        """The same bands, by the numbers of their rows across, which stand as far from each other as they ask for."""
        u = (np.arange(ACROSS) + 0.5) / ACROSS
        at = np.clip(ACROSS * across(spacing[..., None], u) - 0.5, 0.0, ACROSS - 1.0)
        below = np.minimum(at.astype(np.int64), ACROSS - 2)[:, :, None]
        share = at[:, :, None] - below
        first, last = spacing[..., None]
        wide = (first + u * (2.0 * (3.0 - 2.0 * first - last) + 3.0 * u * (first + last - 2.0)))[:, :, None]
        L, M, N = (
            (1.0 - share) * np.take_along_axis(x, below, axis=1) + share * np.take_along_axis(x, below + 1, axis=1)
            for x in (self.L, self.M, self.N)
        )
        return CellForms(L, M * wide, N * (wide * wide), self.edges, self.width, self.turns, self.ends)

    def steps(self, which: Index, counts: Index, room: Floats, longest: Floats) -> Floats:
        """Longest steps (q, b, n) of the columns of some bands with so many rows (q,) and sags to room (b,) / 8; 0
        where none is.

        Where both sides are within the room, so is the better diagonal but where 2 |M| h g takes off more than the room
        and what the sides leave: | |L| h² - |N| g² | where the patch is bent to both sides, else their sum.
        """
        L, M, N = self.L[which], self.M[which], self.N[which]
        room, g = room[which, None, None], 1.0 / counts[:, None, None, None]
        along, across, twist = np.abs(L), np.abs(N) * (g * g), np.abs(M) * g
        shape = L * N
        saddle = shape < 0.0
        longer = np.sqrt(room / np.maximum(along, 1e-300))
        h = np.minimum(longer, _root(np.where(saddle, -along, along), twist, room + across))
        # Beyond the step at which both sides are alike.
        far = saddle & (along * h * h > across)
        if far.any():
            h = np.where(far, np.minimum(longer, _root(along, twist, room - across)), h)
        bowl = shape > M * M
        if bowl.any():
            h = np.where(bowl, np.sqrt(np.maximum(room - across, 0.0) / np.maximum(along, 1e-300)), h)
        h = np.where(across <= room, h, 0.0)
        return np.asarray(np.minimum(h.min(axis=2), longest))

    def leans(self, count: Index, step: Floats) -> Floats:
        """Where chords from the first row and the last to the next, half a step to either side, sag least, (2, b, n).

        count, step  of the rows and of the columns, (b, n)
        """
        p = np.stack([LEANS - 0.5, LEANS + 0.5])[..., None, None]
        found = []
        for k in (0, -1):
            along, twist = self.L[:, k] * step * step, 2.0 * self.M[:, k] * step / count
            worst = np.abs((along * p + twist) * p + self.N[:, k] / (count * count)).max(axis=0)
            found.append(LEANS[worst.argmin(axis=0)] * step)
        return np.stack(found)


def across(spacing: Floats, u: Floats) -> Floats:
    """Ways across bands at shares u of the number of rows: a cubic whose slopes at both edges are spacing (2, ...)."""
    first, last = spacing
    return np.asarray(u * (first + u * ((3.0 - 2.0 * first - last) + u * (first + last - 2.0))))


def _root(a: Floats, b: Floats, c: Floats) -> Floats:
    """Least h > 0 with a h² - 2 b h + c = 0, b and c >= 0; infinite where there is none."""
    inside = b * b - a * c
    low = b + np.sqrt(np.maximum(inside, 0.0))
    return np.asarray(np.where((inside >= 0.0) & (low > 0.0), c / np.maximum(low, 1e-300), np.inf))


def forms_of(bands: Sequence[Band], theta: Floats) -> CellForms:
    """The second forms of bands in the cells of angles theta (n + 1,)."""
    n, k = len(theta) - 1, 2 * ACROSS + 1
    h = 0.5 * np.diff(theta)
    phi = np.concatenate([theta, theta[:-1] + h])
    u = np.repeat(np.arange(k) / (k - 1), len(phi)).reshape(k, -1).T
    # The angles last, so that what is worked on at once lies together.
    x = np.empty((3, len(bands), k, len(phi)))
    for b, each in enumerate(points_of(bands, [Asked(b, phi, u) for b in range(len(bands))])):
        x[:, b] = each.transpose(0, 2, 1)
    before, here, after = x[..., :n], x[..., n + 1 :], x[..., 1 : n + 1]
    low, at, high = (slice(start, stop, 2) for start, stop in ((0, -2), (1, None), (2, None)))
    along = after - before
    bent, first, last = (after[:, :, j] + before[:, :, j] - 2.0 * here[:, :, j] for j in (at, 0, -1))
    normal = cross(along[:, :, at], here[:, :, high] - here[:, :, low])
    size = np.sqrt(dot(normal, normal))
    normal /= np.where(size > 0.0, size, 1.0)
    twist = along[:, :, high] - along[:, :, low]
    curl = here[:, :, high] + here[:, :, low] - 2.0 * here[:, :, at]
    square = h * h
    span = x[:, :, -1] - x[:, :, 0]
    width = np.sqrt(dot(span, span))
    middle = along[:, :, at]
    aside = cross(normal, middle)
    aside = np.abs(dot(aside, bent)) / np.maximum(np.sqrt(dot(middle, middle)), 1e-300) / square
    return CellForms(
        dot(normal, bent) / square, dot(normal, twist) * (ACROSS / (2.0 * h)), dot(normal, curl) * (4.0 * ACROSS**2),
        np.stack([dot(normal[:, :, 0], first), dot(normal[:, :, -1], last)]) / square,
        np.minimum(np.minimum(width[:, :n], width[:, n + 1 :]), width[:, 1 : n + 1]), aside.max(axis=1),
        np.stack([here[:, 0, 0], here[:, -1, -1]]),
    )  # fmt: skip


@immutable
class NetPlan:
    """Where the vertices stand. Owners of angles are, by turns, the edges and the columns of the bands.

    theta   angles of the cells
    phi     (a,) angles of all owners, one after the other, both ends of the turn included; begin: the first of each
    band    (s,) of every stretch, in order; rows: their number there, 0 where it changes in one column
    even    (s,) whether its edges have the steps of its columns
    place   (3, s, 2) in phi where it starts and ends: of the edge below, of the columns, of the edge above
    lean    (2, b, n) at a band's first row and its last: step along phi to the next row that joins best, by cell
    spacing (2, b) distances of a band's rows at its edges, of their average one; see `across`
    closed  whether the turn's end is its start; else the bands end there
    """

    theta: Floats
    phi: Floats
    begin: Index
    band: Index
    rows: Index
    even: Mask
    place: Index
    lean: Floats
    spacing: Floats
    closed: bool


def planned(
    bands: Sequence[Band], knots: Floats, closed: bool, beyond: Longest | None, steady: bool
) -> NetPlan:
    """Rows block by block, and the angles of every edge and of every band's columns."""
    blocks = min(MANY, max(FEW, BLOCKS // (len(knots) - 1))) if steady else BESIDE
    theta = subdivided_knots(knots, blocks * CELLS)
    width = np.diff(theta)
    longest = np.repeat(np.diff(knots), blocks * CELLS)
    forms = forms_of(bands, theta)
    n = len(width)
    room = 8.0 * FILL * np.array([band.room for band in bands])
    spacing = forms.spacing(width, longest, room)
    forms = forms.spaced(spacing)
    most = (1.05 * np.sqrt(np.abs(forms.N).max(axis=(1, 2)) / room)).astype(np.int64) + 2
    if int(most.max()) > MOST:
        raise NotConverged(f"the chord error asks for more than {MOST} rows: the surface is nearly singular")
    choice = _choice(int(most.max()))
    sizes = np.searchsorted(choice, 1.5 * most) + 1
    h = np.zeros((len(choice), len(bands), n))
    for size in distinct(sizes).tolist():
        which = np.flatnonzero(sizes == size)
        some = choice[:size]
        h[:size, which] = np.minimum(forms.steps(which, some, room, longest),
                                     forms.within(which, some[:, None, None], room / 8.0))  # fmt: skip
    cost = np.where(h > 0.0, choice[:, None, None] * width / np.where(h > 0.0, h, 1.0), np.inf)
    cells = cost.reshape(*h.shape[:2], -1, CELLS).sum(axis=3)
    pick = (_steady(cells, choice) if steady else cells.argmin(axis=0)).repeat(CELLS, axis=1)
    count, step = choice[pick], np.take_along_axis(h, pick[None], axis=0)[0]
    own = 1.0 / step
    density = np.zeros((2 * len(bands) + 1, n))
    density[1::2] = own
    bend = np.maximum(np.sqrt(np.abs(forms.edges) / room[:, None]), np.where(count == 1, own, own / LONGER))
    bend = np.maximum(bend, 1.0 / forms.within(np.arange(len(bands)), count, room / 8.0))
    density[2::2] = bend[1]
    edge = density[:-1:2]
    sharp = np.array([band.sharp for band in bands])[:, None]
    density[:-1:2] = np.where(sharp, np.sqrt(np.hypot(edge * edge, bend[0] * bend[0])), np.maximum(edge, bend[0]))
    if beyond is not None:
        density[[0, -1]] = np.maximum(density[[0, -1]], 1.0 / beyond(theta[:-1] + 0.5 * width, forms.ends))
    thin = (forms.width < THIN * np.array([[band.tolerance] for band in bands])).reshape(len(bands), -1, CELLS)
    shrinks = np.array([[band.shrinks is not None] for band in bands])
    # Between two knots where nothing bends along the turn or twists, as in dwells, each edge has its own steps.
    long = 1.0 / np.minimum(density[:-1:2], density[2::2])[:, None]
    sag = (np.abs(forms.L) * long * long + 2.0 * np.abs(forms.M) * long + np.abs(forms.N)).max(axis=1)
    calm = ((count == 1) & (sag < CALM * room[:, None])).reshape(len(bands), len(knots) - 1, -1).all(axis=2)
    twisted = np.array([[band.even] for band in bands]) & ~calm.repeat(blocks, axis=1)
    tied = twisted | (shrinks & thin.any(axis=2))
    return _stretches(knots, theta, density, count[:, ::CELLS], tied, forms.leans(count, step), spacing, closed)


def _steady(cost: Floats, choice: Index) -> Index:
    """Which number of rows each block of bands takes, (b, m): the fewest cells, a block's by choice (q, b, m), with
    those of SWITCH columns at a change (shortest way through all blocks: Viterbi, IEEE Trans. Inf. Theory 13, 1967).

    A change costs half of what it comes from and half of what it goes to, so that all come from one and the same.
    """
    change, every = 0.5 * SWITCH * choice[:, None], np.arange(cost.shape[1])
    blocks = np.ascontiguousarray(np.moveaxis(cost, 2, 0))
    whole, before = blocks[0].copy(), np.empty_like(blocks[1:])
    for block, known in zip(blocks[1:], before):
        known[:] = whole
        np.minimum(whole, (whole + change).min(axis=0) + change, out=whole)
        whole += block
    ways = before + change
    stays = before <= ways.min(axis=1, keepdims=True) + change
    came = np.where(stays, np.arange(len(choice))[:, None], ways.argmin(axis=1)[:, None])
    pick = [whole.argmin(axis=0)]
    for origin in came[::-1]:
        pick.append(origin[pick[-1], every])
    return np.stack(pick[::-1], axis=1)


def _choice(most: int) -> Index:
    """Numbers of rows to choose from; the last one allows a step everywhere."""
    found = [1]
    while found[-1] < 1.5 * most:
        found.append(max(found[-1] + 1, int(found[-1] * GROWTH)))
    return np.array(found)


def _stretches(
    knots: Floats, theta: Floats, density: Floats, count: Index, tied: Mask, lean: Floats, spacing: Floats,
    closed: bool,
) -> NetPlan:
    """The plan from steps per radian (2 b + 1, n) of all owners, rows (b, m) of every block, and which are tied."""
    n, m, many = density.shape[1], count.shape[1], len(density)
    ends = theta[::CELLS]
    joined = _beside(tied, many)
    cells = np.repeat(tied, CELLS, axis=1)
    for row in _passes(tied):
        group = density[2 * row : 2 * row + 3]
        np.copyto(group, group.max(axis=0), where=cells[row])
    # Where a band changes its rows (at the start of a block, the first one's at the turn's), and at what is tied there.
    moved = _beside(count != np.roll(count, 1, axis=1), many)
    # One column beside the start takes up the change, on the side of the longer steps.
    total = density.sum(axis=0)
    on = total[::CELLS] < np.roll(total[CELLS - 1 :: CELLS], 1)
    there = np.where(on, np.arange(m), np.arange(m) - 1) % m
    for row in _passes(tied):
        marks = moved[2 * row : 2 * row + 3]
        np.copyto(marks, marks.any(axis=0), where=tied[row][there])
    cell = np.where(on, np.arange(m) * CELLS, np.arange(m) * CELLS - 1) % n
    finest = np.where(moved, density[:, cell], 0.0).max(axis=0)
    wide = np.minimum(1.0 / np.maximum(finest, 1e-300), CHANGE * np.diff(ends)[there])
    beside = np.where(on, ends[:-1] + wide, np.where(np.arange(m) > 0, ends[:-1], ends[-1]) - wide)
    node = np.zeros((many, m + 1), dtype=bool)
    node[:, :-1] = moved | (joined != np.roll(joined, 1, axis=1))
    node |= np.isin(ends, knots)
    for row in _passes(tied):
        marks = node[2 * row : 2 * row + 3]
        np.copyto(marks, marks.any(axis=0), where=np.append(tied[row], False) | np.append(False, tied[row]))
    one, at = np.nonzero(node)
    other, place = np.nonzero(moved)
    owner = np.concatenate([one, other])
    where = np.concatenate([ends[at], beside[place]])
    # A column of change starts at the block's start, or beside it.
    starts = np.zeros((many, m + 1), dtype=bool)
    starts[:, :-1] = moved & on
    single = np.concatenate([starts[one, at], ~on[place]])
    aside = theta[-1] - theta[0] + 1.0
    key = where + aside * owner
    order = key.argsort()
    owner, where, single, key = owner[order], where[order], single[order], key[order]
    last = np.append(owner[1:] != owner[:-1], True)
    phi, node_at = _cut(theta, node, density, owner, where, single, last, aside)
    begin = np.concatenate([[0], node_at[last] + 1])
    own = np.flatnonzero(~last & (owner % 2 == 1))
    band = owner[own] // 2
    middle = 0.5 * (where[own + 1] + where[own])
    block = np.clip(np.searchsorted(ends, middle, side="right") - 1, 0, m - 1)
    # What is tied to a band that changes its rows need not change its own.
    rows = count[band, block]
    first = np.flatnonzero(np.append(True, band[1:] != band[:-1]))
    final = np.append(first[1:], len(band)) - 1
    ahead, behind = np.arange(len(band)) - 1, np.arange(len(band)) + 1
    ahead[first], behind[final] = final, first
    changes = single[own] & (rows[ahead] != rows[behind])
    column = np.stack([node_at[own], node_at[own + 1]], axis=1)
    keys = phi + aside * np.repeat(np.arange(many), np.diff(begin))
    angle = np.stack([where[own], where[own + 1]], axis=1)
    low, high = (keys.searchsorted(angle + (aside * (owner[own] + k))[:, None]) for k in (-1, 1))
    return NetPlan(
        theta, phi, begin, band, np.where(changes, 0, rows), tied[band, block], np.stack([low, column, high]), lean,
        spacing, closed,
    )


def _beside(bands: Mask, many: int) -> Mask:
    """Which owners (many, m) are bands with a mark (b, m), or edges of one."""
    found = np.zeros((many, bands.shape[1]), dtype=bool)
    for k in range(3):
        found[k : many - 2 + k : 2] |= bands
    return found


def _passes(tied: Mask) -> list[int]:
    """Bands that are tied somewhere, up and down again."""
    some = np.flatnonzero(tied.any(axis=1)).tolist()
    return [*some, *some[-2::-1]]


def _cut(
    theta: Floats, nodes: Mask, density: Floats, owner: Index, where: Floats, single: Mask, last: Mask, aside: float
) -> tuple[Floats, Index]:
    """Angles of all owners, one after the other, and the places of the nodes among them.

    owner, where  the nodes (s,), of which some are the last of their owners; single: one step from there to the next
    The density at an angle, of steps per radian `density` (d, n), is that of the sharper cell beside it, linear to the
    middles of cells; none beyond the starts of blocks that are `nodes` (d, m + 1).
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
    x, y = (fine + (aside * np.arange(d))[:, None]).ravel(), (total + lift).ravel()
    level = np.interp(where + aside * owner, x, y)
    rise = np.append(np.diff(level), 0.0)
    steps = np.where(single | last, 1, np.maximum(1, np.ceil(rise - 1e-6))).astype(np.int64)
    if int(steps.sum()) > MAX_CELLS:
        raise too_many(int(steps.sum()), "vertices")
    first = np.cumsum(steps) - steps
    each = np.repeat(np.arange(len(owner)), steps)
    share = (np.arange(len(each)) - first[each]) / steps[each]
    phi = np.interp(level[each] + rise[each] * share, y, x) - aside * owner[each]
    phi[first] = where
    return phi, first
