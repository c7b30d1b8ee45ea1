"""Largest and smallest values of smooth pieces, refined beyond the sampling grid. No scipy."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats

GOLDEN = 0.5 * (5.0**0.5 - 1.0)
FAN = 17
ROUNDS = 9
"""rounds of FAN samples: a bracket shrinks to 1e-8 of its width, and the value at a peak to its square"""


def piece_grid(knots: Floats, per_turn: int, least: int = 9) -> tuple[Floats, npt.NDArray[np.int64]]:
    """Sample points inside each knot interval, its ends included but nudged inwards so that one-sided values are met.

    knots     (k,) increasing
    per_turn  samples for 2 pi of the parameter
    Returns the points (n,) and the interval number of each.
    """
    points, owner = [], []
    for i, (low, high) in enumerate(zip(knots[:-1], knots[1:])):
        count = max(least, int(np.ceil(per_turn * (high - low) / (2.0 * np.pi))) + 1)
        nudge = 1e-9 * (high - low)
        points.append(np.linspace(low + nudge, high - nudge, count))
        owner.append(np.full(count, i))
    return np.concatenate(points), np.concatenate(owner)


def refined_maximum(
    f: Callable[[Floats], Floats], x: Floats, owner: npt.NDArray[np.int64], values: Floats, keep: int = 6
) -> tuple[float, float]:
    """Largest value of f and where, refined about the best local maxima of the samples.

    f       vectorised function of x (n,) -> (n,)
    x       increasing samples; `owner` numbers the smooth piece of each; values (n,) = f(x)
    Returns (value, x). The result is never below the best sample.
    """
    left = np.r_[False, owner[1:] == owner[:-1]]
    right = np.r_[owner[:-1] == owner[1:], False]
    below = np.r_[-np.inf, values[:-1]]
    above = np.r_[values[1:], -np.inf]
    peak = (~left | (values >= below)) & (~right | (values >= above))
    index = np.flatnonzero(peak)
    index = index[np.argsort(values[index])[::-1][:keep]]
    low = np.where(left[index], x[np.maximum(index - 1, 0)], x[index])
    high = np.where(right[index], x[np.minimum(index + 1, len(x) - 1)], x[index])
    found, where = bracketed_maximum(f, low, high)
    best = int(np.argmax(found))
    start = int(np.argmax(values))
    if found[best] >= values[start]:
        return float(found[best]), float(where[best])
    return float(values[start]), float(x[start])


def bracketed_maximum(f: Callable[[Floats], Floats], low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Maxima of f in many brackets at once: values (k,) and places (k,).

    Every round samples each bracket at FAN points in one call and keeps the two intervals about the best: for a peak
    with one maximum in the bracket this converges by (FAN - 1) / 2 a round, down to rounding.
    """
    share = np.linspace(0.0, 1.0, FAN)
    rows = np.arange(len(low))
    for _ in range(ROUNDS):
        x = low[:, None] + (high - low)[:, None] * share
        values = f(x.ravel()).reshape(x.shape)
        best = np.argmax(values, axis=1)
        found, where = values[rows, best], x[rows, best]
        low, high = x[rows, np.maximum(best - 1, 0)], x[rows, np.minimum(best + 1, FAN - 1)]
        if np.all(high - low <= 4e-16 * np.maximum(np.abs(low), np.abs(high))):
            break
    return found, where
