"""Largest and smallest values of smooth pieces, refined beyond the sampling grid. No scipy."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

GOLDEN = 0.5 * (5.0**0.5 - 1.0)


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
    """Largest value of f and where, refined by golden section about the best local maxima of the samples.

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
    found, where = golden_maximum(f, low, high)
    best = int(np.argmax(found))
    start = int(np.argmax(values))
    if found[best] >= values[start]:
        return float(found[best]), float(where[best])
    return float(values[start]), float(x[start])


def golden_maximum(f: Callable[[Floats], Floats], low: Floats, high: Floats, rounds: int = 44) -> tuple[Floats, Floats]:
    """Golden section on many brackets at once: values (k,) and places (k,) of the maxima of f between low and high."""
    p, q = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    fp, fq = f(p), f(q)
    for _ in range(rounds):
        lower = fp > fq
        high, low = np.where(lower, q, high), np.where(lower, low, p)
        p_next = high - GOLDEN * (high - low)
        q_next = low + GOLDEN * (high - low)
        probe = np.where(lower, p_next, q_next)
        fresh = f(probe)
        fp, fq = np.where(lower, fresh, fq), np.where(lower, fp, fresh)
        p, q = p_next, q_next
    return np.where(fp > fq, fp, fq), np.where(fp > fq, p, q)
