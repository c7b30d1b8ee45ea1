"""B-splines on 0 <= x <= 1 with clamped knots, as matrices of basis values and as pieces. Plain numpy."""

from __future__ import annotations

import math

import numpy as np

from camgeom.maths import Floats
from camgeom.motion.table import Piece


def clamped(inner: Floats, degree: int) -> Floats:
    """The knot vector with simple inner knots and both ends repeated degree + 1 times."""
    return np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])


def collocation(knots: Floats, degree: int, x: Floats, order: int = 0) -> Floats:
    """The derivatives of the given order of all basis functions at x, (n, len(knots) - degree - 1).

    At an inner knot the right-hand limit is taken, at x = 1 the left-hand one (de Boor's recurrence; a derivative is a
    spline of lower degree on the same knots).
    """
    if order > degree:
        return np.zeros((len(x), len(knots) - degree - 1))
    lower = degree - order
    span = np.clip(np.searchsorted(knots, x, side="right") - 1, degree, len(knots) - degree - 2)
    # Only lower + 1 functions live on a span: their values by the triangle, then into their columns.
    local = np.zeros((lower + 1, len(x)))
    local[0] = 1.0
    for p in range(1, lower + 1):
        carried = np.zeros(len(x))
        for r in range(p):
            upper, under = knots[span + r + 1], knots[span + r + 1 - p]
            part = local[r] / (upper - under)
            local[r] = carried + (upper - x) * part
            carried = (x - under) * part
        local[p] = carried
    basis = np.zeros((len(x), len(knots) - lower - 1))
    basis[np.arange(len(x)), span - lower + np.arange(lower + 1)[:, None]] = local
    for p in range(lower + 1, degree + 1):
        width = knots[p:] - knots[:-p]
        scaled = p * basis * np.divide(1.0, width, out=np.zeros_like(width), where=width > 0.0)
        basis = scaled[:, :-1] - scaled[:, 1:]
    return basis


def end_control(knots: Floats, degree: int, end: int, values: Floats) -> Floats:
    """The control values (k,) next to the start (end = 0) or the end (end = 1) that give value and derivatives there.

    `values` (k,) are the value and the k - 1 derivatives at x = 0 or x = 1.
    """
    count = len(values)
    rows = np.array([collocation(knots, degree, np.array([float(end)]), r)[0] for r in range(count)])
    block = rows[:, :count] if end == 0 else rows[:, -count:]
    # Rows of high derivatives are large by powers of the knot spacing; scaled they solve to rounding.
    scale = np.abs(block).max(axis=1)
    return np.asarray(np.linalg.solve(block / scale[:, None], values / scale))


def to_pieces(knots: Floats, degree: int, control: Floats, start: Floats, end: Floats) -> list[Piece]:
    """The spline as polynomial pieces, each about its left end; the last about x = 1.

    `start`, `end` (k,) are its value and derivatives at both ends, which the pieces then have to the last digit.
    """
    breaks = np.unique(knots)
    anchors = np.append(breaks[:-2], 1.0)
    rows = [collocation(knots, degree, anchors, r) @ control / math.factorial(r) for r in range(degree + 1)]
    power = np.array(rows).T
    factorials = np.array([math.factorial(r) for r in range(len(start))])
    if len(power) > 1:
        power[0, : len(start)] = start / factorials
    power[-1, : len(end)] = end / factorials
    kept = [-1, *[degree - 1] * (len(power) - 1)]
    return [
        Piece(float(low), float(high), float(anchor), tuple(row.tolist()), (), order)
        for low, high, anchor, row, order in zip(breaks[:-1], breaks[1:], anchors, power, kept, strict=True)
    ]
