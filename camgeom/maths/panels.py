"""Functions of the cam angle held as Chebyshev panels: sampled once, then integrated, solved and maximised exactly.

A smooth function on a panel is known by its values at the first-kind Chebyshev points, all strictly inside the panel:
a jump at a panel edge (start of a force, start of a motion) never needs a side: each panel sees its own limit.
Arrays are (..., p, n): any leading axes, p panels, n points in a panel.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camgeom.errors import NotConverged
from camgeom.immutable import immutable
from camgeom.maths import TURN as TURN
from camgeom.maths import Floats, distinct
from camgeom.maths.extremum import bracketed_root
from camgeom.maths.frozen import cached_property

Ints = NDArray[np.intp]

POINTS = 12
SMALLEST_PANEL = 1e-9
"""rad; edges closer than this are taken as one"""
NEAR = 0.05
"""Share of the range of a function within which a sampled local maximum may turn out to be the largest"""


def _nodes() -> Floats:
    return np.asarray(-np.cos(np.pi * (np.arange(POINTS) + 0.5) / POINTS), dtype=np.float64)


def _to_coefficients() -> Floats:
    """(n, n) matrix from values at the points to Chebyshev coefficients (discrete orthogonality)."""
    angle = np.arccos(np.clip(_nodes(), -1.0, 1.0))
    matrix = np.cos(np.outer(np.arange(POINTS), angle)) * 2.0 / POINTS
    matrix[0] *= 0.5
    return np.asarray(matrix, dtype=np.float64)


def _antiderivative() -> Floats:
    """(n + 1, n) matrix from coefficients to those of the antiderivative that vanishes at x = -1."""
    matrix = np.zeros((POINTS + 1, POINTS))
    for k in range(POINTS):
        if k == 0:
            matrix[1, 0] += 1.0
        elif k == 1:
            matrix[2, 1] += 0.25
        else:
            matrix[k + 1, k] += 0.5 / (k + 1)
            matrix[k - 1, k] -= 0.5 / (k - 1)
    matrix[0] = -((-1.0) ** np.arange(1, POINTS + 1)) @ matrix[1:]
    return matrix


def _derivative() -> Floats:
    """(n, n) matrix from coefficients to those of the derivative with respect to x."""
    matrix = np.zeros((POINTS, POINTS))
    for k in range(1, POINTS):
        for i in range(k - 1, -1, -2):
            matrix[i, k] = k if i == 0 else 2.0 * k
    return matrix


NODES = _nodes()
TO_COEFFICIENTS = _to_coefficients()
ANTIDERIVATIVE = _antiderivative()
DERIVATIVE = _derivative()
WEIGHTS: Floats = np.asarray(np.ones(POINTS + 1) @ ANTIDERIVATIVE @ TO_COEFFICIENTS, dtype=np.float64)


def chebyshev(x: ArrayLike, degree: int) -> Floats:
    """Chebyshev polynomials T_0..T_degree at x in [-1, 1]: shape (degree + 1, *x.shape)."""
    at = np.asarray(x, dtype=np.float64)
    out = np.empty((degree + 1, *at.shape))
    out[0] = 1.0
    if degree:
        out[1] = at
    for k in range(2, degree + 1):
        out[k] = 2.0 * at * out[k - 1] - out[k - 2]
    return out


def evaluate(coefficients: Floats, x: Floats) -> Floats:
    """Value of each row's Chebyshev series, coefficients (N, n), at its own x (N,)."""
    older = np.zeros_like(x)
    newer = np.zeros_like(x)
    twice = 2.0 * x
    for k in range(coefficients.shape[-1] - 1, 0, -1):
        older, newer = newer, coefficients[..., k] + twice * newer - older
    return np.asarray(coefficients[..., 0] + x * newer - older, dtype=np.float64)


@final
@immutable
class Panels:
    """A division of a range of cam angle, rad, into panels on which every quantity of interest is smooth.

    edges: (p + 1,) panel edges; breaks: (b + 1,) those edges where a quantity may jump (first and last included).
    """

    edges: Floats
    breaks: Floats

    @cached_property
    def theta(self) -> Floats:
        """Cam angle of the sample points, rad, (p, n)."""
        return np.asarray(self.middle[:, None] + self.half[:, None] * NODES, dtype=np.float64)

    def split(self, angles: ArrayLike) -> Panels:
        """The same with further breaks at cam angles within the range, rad; edges nearly at a break are that break."""
        breaks = panels(np.concatenate([self.breaks, np.ravel(angles)]), np.inf).edges
        after = np.clip(np.searchsorted(breaks, self.edges), 1, len(breaks) - 1)
        far = np.minimum(np.abs(self.edges - breaks[after]), np.abs(self.edges - breaks[after - 1])) > SMALLEST_PANEL
        return Panels(panels(np.concatenate([breaks, self.edges[far]]), np.inf).edges, breaks)

    @cached_property
    def half(self) -> Floats:
        """Half width of each panel, rad, (p,)."""
        return np.asarray(0.5 * np.diff(self.edges), dtype=np.float64)

    @cached_property
    def middle(self) -> Floats:
        """Centre of each panel, rad, (p,)."""
        return np.asarray(0.5 * (self.edges[1:] + self.edges[:-1]), dtype=np.float64)

    @cached_property
    def piece(self) -> Ints:
        """Index of the piece (range between two breaks) that each panel belongs to, (p,)."""
        return np.asarray(np.searchsorted(self.breaks, self.middle) - 1, dtype=np.intp)

    @cached_property
    def break_edges(self) -> Ints:
        """Index into `edges` of every break, (b + 1,)."""
        return np.asarray(np.searchsorted(self.edges, self.breaks), dtype=np.intp)

    def coefficients(self, values: Floats) -> Floats:
        """Chebyshev coefficients of values (..., p, n) at `theta`."""
        return np.asarray(values @ TO_COEFFICIENTS.T, dtype=np.float64)

    def integral(self, values: Floats) -> Floats:
        """Integral over the whole range of values (..., p, n) at `theta`: unit of the value times rad, shape (...)."""
        return np.asarray(np.einsum("...pn,p,n->...", values, self.half, WEIGHTS), dtype=np.float64)

    def running(self, values: Floats) -> tuple[Floats, Floats]:
        """Integral from the first edge: at the edges, (..., p + 1), and within panels as series, (..., p, n + 1)."""
        inside = np.asarray(self.coefficients(values) @ ANTIDERIVATIVE.T, dtype=np.float64) * self.half[:, None]
        steps = inside.sum(axis=-1)
        at_edges = np.concatenate([np.zeros((*steps.shape[:-1], 1)), np.cumsum(steps, axis=-1)], axis=-1)
        inside[..., 0] += at_edges[..., :-1]
        return at_edges, inside

    def at(self, values: Floats, theta: ArrayLike) -> Floats:
        """Values (..., p, n) interpolated at cam angles theta (q,): (..., q); the right-hand limit at an edge."""
        angle = np.atleast_1d(np.asarray(theta, dtype=np.float64))
        panel = np.clip(np.searchsorted(self.edges, angle, side="right") - 1, 0, len(self.half) - 1)
        x = np.clip((angle - self.middle[panel]) / self.half[panel], -1.0, 1.0)
        return evaluate(self.coefficients(values)[..., panel, :], np.broadcast_to(x, (*values.shape[:-2], x.size)))

    def limit(self, values: Floats, angle: float, judged: Floats) -> Floats:
        """Values (..., p, n) at one cam angle, rad: at an edge on its side where `judged` (p, n) is larger; (...)."""
        sides = np.searchsorted(self.edges, angle + np.array([-SMALLEST_PANEL, SMALLEST_PANEL]), side="right") - 1
        panel = np.clip(sides, 0, len(self.half) - 1)
        x = np.clip((angle - self.middle[panel]) / self.half[panel], -1.0, 1.0)
        side = int(np.argmax(evaluate(self.coefficients(judged[panel]), x)))
        row = self.coefficients(values[..., panel[side], :])
        return evaluate(row, np.broadcast_to(x[side], row.shape[:-1]))

    def harder(self, angle: float, judged: Floats) -> float:
        """A cam angle, rad; at an edge its neighbour by SMALLEST_PANEL on the side where `judged` (p, n) is larger."""
        sides = np.clip(angle + np.array([-SMALLEST_PANEL, SMALLEST_PANEL]), self.edges[0], self.edges[-1])
        low, high = np.searchsorted(self.edges[1:-1], sides, side="right")
        return angle if low == high else float(sides[np.argmax(self.at(judged, sides))])

    def sampled(self, count: int) -> Floats:
        """So many angles round the turn, rad, and both sides of every edge, where values may jump."""
        beside = [self.edges[:-1] + SMALLEST_PANEL, self.edges[1:] - SMALLEST_PANEL]
        return np.concatenate([np.linspace(self.edges[0], self.edges[-1], count, endpoint=False), *beside])

    def tail(self, values: Floats) -> Floats:
        """Share of the last coefficients in the largest value, per panel (p,): the error of the interpolation."""
        series = np.abs(self.coefficients(values))
        largest = np.abs(values).max(axis=(-1, -2), keepdims=True)
        share = np.divide(series[..., -2:].sum(axis=-1, keepdims=True), largest,
                          out=np.zeros((*series.shape[:-1], 1)), where=largest > 0.0)[..., 0]
        return np.asarray(share.reshape(-1, share.shape[-1]).max(axis=0), dtype=np.float64)


def panels(breaks: ArrayLike, widest: float = np.radians(10.0)) -> Panels:
    """Panels no wider than `widest` rad over the range of the breaks (rad, any order; near equal ones are joined)."""
    wanted = distinct(np.asarray(breaks, dtype=np.float64))
    if wanted.size < 2:
        raise ValueError("a range of cam angle needs two different ends")
    kept = [float(wanted[0])]
    for value in wanted[1:-1]:
        if value - kept[-1] > SMALLEST_PANEL and wanted[-1] - value > SMALLEST_PANEL:
            kept.append(float(value))
    kept.append(float(wanted[-1]))
    return Panels(_divide(kept, widest), np.asarray(kept))


def _divide(edges: Sequence[float], widest: float) -> Floats:
    parts = [np.linspace(lo, hi, int(np.ceil((hi - lo) / widest - 1e-9)) + 1)[:-1]
             if hi - lo > widest else np.array([lo]) for lo, hi in itertools.pairwise(edges)]
    return np.concatenate([*parts, [edges[-1]]])


def resolved(
    sample: Callable[[Floats], Floats],
    start: Panels,
    tolerance: float = 1e-10,
    rounds: int = 8,
    most: int | None = None,
) -> Panels:
    """Panels split until the interpolation error of sample(theta (p, n)) -> (..., p, n) is below the tolerance.

    tolerance: share of the largest value. A kink inside a panel stops at 2^-rounds of the first width, which confines
    its effect to that sliver; the caller reads what is left from `Panels.tail`. Raises NotConverged before it takes
    more than `most` panels.
    """
    current, values = start, sample(start.theta)
    for _ in range(rounds):
        coarse = current.tail(values) > tolerance
        if not coarse.any():
            break
        if most is not None and len(current.half) + np.count_nonzero(coarse) > most:
            raise NotConverged(
                f"it swings so often in a turn that {len(current.half)} panels do not resolve it to {tolerance:g}, and "
                f"{most} are spent"
            )
        current = Panels(np.sort(np.concatenate([current.edges, current.middle[coarse]])), current.breaks)
        halved = np.repeat(coarse, 1 + coarse)
        values = np.repeat(values, 1 + coarse, axis=-2)
        values[..., halved, :] = sample(current.theta[halved])
    return current


def roots(where: Panels, values: Floats, zero: float | Floats = 0.0, finer: int = 2 * POINTS) -> list[Floats]:
    """Cam angles, rad, where each row of values (r, p, n) crosses zero inside a panel: one sorted array a row.

    zero: magnitude (scalar or (r,)) below which a value counts as zero, so that rounding in a dwell gives no crossing.
    """
    grid = np.linspace(-1.0, 1.0, finer + 1)
    series = where.coefficients(values)
    dense = series @ chebyshev(grid, POINTS - 1)
    floor = np.broadcast_to(np.asarray(zero, dtype=np.float64), dense.shape[:1])[:, None, None]
    sign = np.sign(np.where(np.abs(dense) <= floor, 0.0, dense))
    row, panel, cell = np.nonzero(sign[..., :-1] * sign[..., 1:] < 0.0)
    exact = _zero_nodes(sign)
    lo, hi = grid[cell], grid[cell + 1]
    chosen = series[row, panel]
    x = bracketed_root(lambda at: evaluate(chosen, at), lo, hi)
    angle = where.middle[panel] + where.half[panel] * x
    extra = where.middle[exact[1]] + where.half[exact[1]] * grid[exact[2]]
    return [np.sort(np.concatenate([angle[row == k], extra[exact[0] == k]])) for k in range(values.shape[0])]


def _zero_nodes(sign: NDArray[np.float64]) -> tuple[Ints, Ints, Ints]:
    """Dense points that hit a crossing exactly: zero there, opposite signs on both sides."""
    row, panel, cell = np.nonzero((sign[..., 1:-1] == 0.0) & (sign[..., :-2] * sign[..., 2:] < 0.0))
    return row, panel, cell + 1


def highest(where: Panels, values: Floats) -> tuple[Floats, Floats]:
    """Largest value of each function (..., p, n), limits at jumps included, and its cam angle in rad: (...)."""
    lead = values.shape[:-2]
    series = where.coefficients(values.reshape(-1, *values.shape[-2:]))
    grid = np.linspace(-1.0, 1.0, 2 * POINTS + 1)
    dense = series @ chebyshev(grid, POINTS - 1)
    best, least = dense.max(axis=(1, 2), keepdims=True), dense.min(axis=(1, 2), keepdims=True)
    padded = np.pad(dense, ((0, 0), (0, 0), (1, 1)), constant_values=-np.inf)
    peak = (dense >= padded[..., :-2]) & (dense >= padded[..., 2:]) & (dense > best - NEAR * (best - least))
    # A panel that is constant hides nothing: a body that mostly carries nothing has thousands.
    peak &= (dense != dense[..., :1]).any(axis=2, keepdims=True)
    # The sampled maximum itself, also of a constant.
    peak.reshape(len(dense), -1)[np.arange(len(dense)), dense.reshape(len(dense), -1).argmax(axis=1)] = True
    row, panel, cell = np.nonzero(peak)
    lo, hi = grid[np.maximum(cell - 1, 0)], grid[np.minimum(cell + 1, grid.size - 1)]
    local = series[row, panel]
    down = local @ DERIVATIVE.T
    inner = (evaluate(down, lo) > 0.0) & (evaluate(down, hi) < 0.0)
    x = np.where(inner, bracketed_root(lambda at: evaluate(down, at), lo, hi), grid[cell])
    value = np.maximum(evaluate(local, x), dense[row, panel, cell])
    order = np.lexsort((-value, row))
    chosen = order[np.unique(row[order], return_index=True)[1]]
    angle = where.middle[panel[chosen]] + where.half[panel[chosen]] * x[chosen]
    return value[chosen].reshape(lead), angle.reshape(lead)
