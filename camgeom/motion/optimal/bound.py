"""What no law can beat: weak duality over all laws, not only over those that a programme can draw.

Take any multipliers: y of the moments, r >= 0 of tangents to the vibration's circle, w >= 0 of the velocity at some
places, and let g be the sum of their kernels, W its integral. Any law that keeps the limits has

    y b <= integral g a + E sum r + sum w (V -+ v0),
    integral g a = [(W - S) a] + integral S' a - integral (W - S) a' <= [(W - S) a] + A TV(S) + J integral |W - S|

for any S of bounded variation; where the mean square is least a part of S' stands against it by Cauchy and Schwarz. So
limits and least value are tied by numbers that come from integrals of |W - S| alone. S is level where the jerk is at
its limit and follows W where the acceleration is: that is all of S that the multipliers leave open.
"""

from __future__ import annotations

from typing import NamedTuple, final

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats, distinct
from camgeom.motion.optimal.programme import Multipliers
from camgeom.motion.optimal.shape import Shape, decay
from camgeom.motion.optimal.wish import LIMITS, Task

CELLS, FEWEST = 2048, 16
"""cells that the integrals are taken over, and those of a short span; what a cell's curvature can hide is added"""
SILENT = 1e-9
"""a multiplier below this share of the largest is rounding"""


class Weights(NamedTuple):
    """How much of each limit the multipliers take up: const >= sum of weight times limit."""

    const: float
    velocity: float
    acceleration: float
    jerk: float
    residual: float
    mean: float


@final
class _Field:
    """g and W on a grid of cells, for given multipliers.

    Where the velocity stays at its limit over a span, the multiplier is not a weight at the span's ends but a density
    that keeps g at zero between them; W then goes on level.
    """

    def __init__(self, task: Task, shape: Shape, m: Multipliers, count: int) -> None:
        self.y = m.moments
        keep = m.cut > 0.0
        self.k, damped = decay(m.cuts.n[keep], task.wish.damping)
        self.wave = m.cut[keep] * np.exp(-1j * m.cuts.angle[keep]) / damped
        net = m.above - m.below
        places, net = m.places[net != 0.0], net[net != 0.0]
        self.x = _nodes(np.concatenate([shape.x, places]), count)
        self.h = np.diff(self.x)
        self.middle = 0.5 * (self.x[:-1] + self.x[1:])
        at, total = self._rest(self.x)
        at_middle, total_middle = self._rest(self.middle)
        left = (self.middle[:, None] < places) @ net
        right = left.copy()
        level = np.zeros(len(self.h), dtype=bool)
        for first, last in cruises(shape):
            inside = (self.middle > shape.x[first]) & (self.middle < shape.x[last])
            cells = np.flatnonzero(inside)
            before = left[cells[0] - 1] if cells[0] else float(net.sum())
            after = left[cells[-1] + 1] if cells[-1] + 1 < len(left) else 0.0
            held = np.clip(at[cells[0] : cells[-1] + 2], min(before, after), max(before, after))
            held = np.minimum.accumulate(held) if before > after else np.maximum.accumulate(held)
            left[cells], right[cells] = held[:-1], held[1:]
            level[cells] = (held[:-1] == at[cells]) & (held[1:] == at[cells + 1])
        gained = np.concatenate([[0.0], np.cumsum(0.5 * self.h * (left + right))])
        self.total = total - gained
        self.total_middle = total_middle - gained[:-1] - self.h * (3.0 * left + right) / 8.0
        self.g = at[:-1] - left, at_middle - 0.5 * (left + right), at[1:] - right
        falls = -np.diff(np.concatenate([[left[0]], np.ravel(np.column_stack([left, right])), [0.0]]))
        self.above, self.below = float(falls[falls > 0.0].sum()), float(-falls[falls < 0.0].sum())
        size = np.abs(self.wave) * np.exp(np.maximum(0.0, -self.k.real))
        rate = np.abs(self.k)
        self.bend = 2.0 * float(size @ rate**2)
        # Where the density keeps g at zero, W bends by no more than what g's own curve leaves of it within a cell.
        self.slope: Floats = np.where(level, self.h * self.bend, 2.0 * float(abs(self.y[1]) + size @ rate))

    def _rest(self, x: Floats) -> tuple[Floats, Floats]:
        """g without the velocity's part, and its integral from 0, at x (n,)."""
        decayed = np.exp(-np.outer(1.0 - x, self.k))
        # Not as a product of matrices, over which threads wait for each other longer than they work.
        waves, sums = np.einsum("xq,qw->wx", decayed, np.column_stack([self.wave, self.wave / self.k])).real
        g = self.y[0] + self.y[1] * (1.0 - x) - waves
        total = self.y[0] * x + self.y[1] * (x - 0.5 * x * x) - sums
        return g, total


def cruises(shape: Shape) -> list[tuple[int, int]]:
    """Runs of spans (first break, last break) over which the velocity stays as it is."""
    still = np.abs(shape.a) <= SILENT * np.abs(shape.a).max(initial=1.0)
    level = still[:-1] & still[1:] if shape.smooth else still
    return _runs(level)


def _runs(chosen: npt.NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Where runs of true begin and where the next false stands."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], chosen.astype(int), [0]])))
    return [(int(first), int(last)) for first, last in zip(edges[::2], edges[1::2], strict=True)]


def _nodes(places: Floats, cells: int) -> Floats:
    """Nodes over 0 .. 1, the given places among them."""
    edges = distinct(np.concatenate([places, [0.0, 1.0]]))
    counts = np.maximum(FEWEST, np.ceil(cells * np.diff(edges))).astype(int)
    parts = [np.linspace(low, high, n, endpoint=False) for low, high, n in zip(edges[:-1], edges[1:], counts)]
    return np.concatenate([*parts, [1.0]])


def _sizes(low: Floats, middle: Floats, high: Floats, h: Floats, bend: Floats | float) -> Floats:
    """Upper bounds of the integral of |f| over cells from three values; `bend` bounds |f''|.

    Where f keeps its sign Simpson's rule is exact to rounding; where it may change the chord is taken, and what the
    curve can add to it.
    """
    slack = h * h * bend / 8.0
    same = (low * high > 0.0) & (np.minimum(np.abs(low), np.abs(high)) > slack)
    simpson = np.abs(low + 4.0 * middle + high) / 6.0
    size = np.abs(low) + np.abs(high)
    crossing = (low * low + high * high) / np.where(size > 0.0, 2.0 * size, 1.0)
    chord = np.where(low * high < 0.0, crossing, 0.5 * size)
    return np.asarray(h * np.where(same, simpson, chord + 2.0 * slack / 3.0))


def lower_bound(task: Task, shape: Shape, m: Multipliers, cells: int = CELLS) -> float:
    """The value of t that no law of the class can beat; -inf where the multipliers say nothing."""
    return max(_by_multipliers(task, shape, m, cells), _by_ends(task))


def _by_ends(task: Task) -> float:
    """What a limit of what is fixed at an end cannot go below."""
    start, end = task.wish.start, task.wish.end
    fixed = ((task.velocity, (start[0], end[0])), (task.acceleration, (start[1] or 0.0, end[1] or 0.0)))
    return max(
        ((max(map(abs, values)) - limit.const) / limit.slope for limit, values in fixed if limit.slope > 0.0),
        default=-np.inf,
    )


def _by_multipliers(task: Task, shape: Shape, m: Multipliers, cells: int) -> float:
    weights = weigh(task, shape, m, cells)
    const, slope = weights.const, weights.mean
    for name in LIMITS:
        weight, limit = getattr(weights, name), getattr(task, name)
        if weight > 0.0:
            const -= weight * limit.const
            slope += weight * limit.slope
    return float(const / slope) if np.isfinite(const) and slope > 0.0 else -np.inf


def weigh(task: Task, shape: Shape, m: Multipliers, cells: int = CELLS) -> Weights:
    """What the multipliers take up of each limit."""
    field = _Field(task, shape, m, cells)
    begun = task.wish.start[0]
    const = float(m.moments @ np.array(task.wish.moments)) + begun * (field.above - field.below)
    # Upwards s' <= V; downwards s' >= -V, or s' >= 0 where the law may not turn back.
    velocity = field.above if task.wish.monotone else field.above + field.below
    residual = float(m.cut.sum())
    if not task.jerk.asked:
        acceleration, mean = _without_jerk(task, field, shape)
        return Weights(const, velocity, acceleration, 0.0, residual, mean)
    acceleration, jerk, ends = _with_jerk(task, field, shape, m)
    if not task.acceleration.asked:
        # Somewhere the acceleration is its mean, and from there it cannot go further than the jerk lets it.
        ends += acceleration * abs(task.wish.moments[0])
        jerk, acceleration = jerk + acceleration, 0.0
    return Weights(const - ends, velocity, acceleration, jerk, residual, float(task.mean))


def _without_jerk(task: Task, field: _Field, shape: Shape) -> tuple[float, float]:
    """Weights of acceleration and mean square where no jerk is limited: S is W itself."""
    if not task.mean:
        return float(_sizes(*field.g, field.h, field.bend).sum()), 0.0
    level = task.acceleration.const / float(np.sqrt(shape.mean_square))
    kept = [np.clip(g, -level, level) for g in field.g]
    low, middle, high = (g - k for g, k in zip(field.g, kept, strict=True))
    over = float(_sizes(low, middle, high, field.h, field.bend).sum()) if task.acceleration.asked else 0.0
    squares = (kept[0] ** 2 + 4.0 * kept[1] ** 2 + kept[2] ** 2) / 6.0
    return over, float(np.sqrt(field.h @ squares))


def _with_jerk(task: Task, field: _Field, shape: Shape, m: Multipliers) -> tuple[float, float, float]:
    """Weights of acceleration and jerk, and what the ends give: S level where the jerk is at its limit, else W."""
    total, total_middle, g = field.total, field.total_middle, field.g
    slope, bend = field.slope, field.bend
    if task.mean:
        # Against the mean square stands the law's own acceleration, which is what it is proportional to.
        size = float(np.sqrt(shape.mean_square))
        v, v_middle, a, a_middle = *_velocity(shape, field.x, field.middle), *_levels(shape, field.x, field.middle)
        total, total_middle = total - v / size, total_middle - v_middle / size
        g = g[0] - a[:-1] / size, g[1] - a_middle / size, g[2] - a[1:] / size
        slope = slope + float(np.abs(shape.jerk).max()) / size
    span = np.clip(np.searchsorted(shape.x, field.middle) - 1, 0, len(shape.h) - 1)
    mean = np.bincount(span, field.h * (total[:-1] + 4.0 * total_middle + total[1:]) / 6.0, len(shape.h)) / shape.h
    level = mean + m.jerk
    active = np.abs(m.jerk) > SILENT * np.abs(m.jerk).max(initial=0.0)
    low, high = level[span], level[span]
    follows = np.zeros(len(span), dtype=bool)
    if not task.acceleration.asked:
        constant = float(shape.h @ level)
        low, high = np.full_like(low, constant), np.full_like(high, constant)
    else:
        for first, last in _runs(~active):
            cells = np.flatnonzero((span >= first) & (span < last))
            before = level[first - 1] if first else total[0]
            after = level[last] if last < len(level) else total[-1]
            ways = [(cells, before, after)] if last - first < len(level) else []
            low[cells], high[cells] = total[:-1][cells], total[1:][cells]
            if task.mean:
                # Such a run may hold both limits of the acceleration: W goes up, and down again between its ends.
                head, tail = cells[span[cells] == first], cells[span[cells] == last - 1]
                ways = [(head, before, total[head[-1] + 1]), (tail, total[tail[0]], after)] if ways else []
            for some, one, other in ways:
                low[some] = np.clip(total[:-1][some], min(one, other), max(one, other))
                high[some] = np.clip(total[1:][some], min(one, other), max(one, other))
        for first, last in cruises(shape):
            # While the velocity is held nothing else is: S is W there, and the spans beside it end on the same level.
            beside = [k for k in (first - 1, last) if 0 <= k < len(level) and active[k]]
            inside = (span >= first) & (span < last)
            for k in beside:
                low[span == k] = high[span == k] = float(total_middle[inside].mean())
        follows = (low == total[:-1]) & (high == total[1:])
    middle = np.where(follows, total_middle, 0.5 * (low + high))
    jerk = float(
        np.where(follows, 0.0, _sizes(total[:-1] - low, total_middle - middle, total[1:] - high, field.h, slope)).sum()
    )
    varied = np.where(follows, _sizes(*g, field.h, bend), np.abs(high - low))
    acceleration = float(varied.sum() + np.abs(low[1:] - high[:-1]).sum())
    ends = 0.0
    start, end = task.wish.start, task.wish.end
    for gap, (_, fixed), sign in ((total[0] - low[0], start, -1.0), (total[-1] - high[-1], end, 1.0)):
        if fixed is None:
            acceleration += abs(float(gap))
        else:
            ends += sign * float(gap) * fixed
    return acceleration, jerk, ends


def _levels(shape: Shape, *places: Floats) -> tuple[Floats, ...]:
    """The acceleration at places."""
    return tuple(np.interp(x, shape.x, shape.a) for x in places)


def _velocity(shape: Shape, *places: Floats) -> tuple[Floats, ...]:
    """The velocity gained up to places."""
    v = shape.states(0.0)[1]
    found = []
    for x in places:
        k = np.clip(np.searchsorted(shape.x, x, side="right") - 1, 0, len(shape.h) - 1)
        u = x - shape.x[k]
        found.append(v[k] + u * (shape.first[k] + u * shape.jerk[k] / 2.0))
    return tuple(found)
