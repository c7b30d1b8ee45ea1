"""B-splines on 0 <= x <= 1 with clamped knots, as matrices of basis values and as pieces. Plain numpy."""

from __future__ import annotations

import math

import numpy as np

from camgeom.motion.piece import Piece
from camgeom.motion.table import Floats


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
    basis = np.zeros((len(x), len(knots) - 1))
    basis[np.arange(len(x)), span] = 1.0
    for p in range(1, lower + 1):
        width = knots[p:] - knots[:-p]
        inverse = np.divide(1.0, width, out=np.zeros_like(width), where=width > 0.0)
        rising = (x[:, None] - knots[: -p - 1]) * inverse[:-1]
        falling = (knots[p + 1 :] - x[:, None]) * inverse[1:]
        basis = rising * basis[:, :-1] + falling * basis[:, 1:]
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


def to_pieces(knots: Floats, degree: int, control: Floats) -> list[Piece]:
    """The spline as polynomial pieces, each about its left end; the last about x = 1, where its value is exact."""
    breaks = np.unique(knots)
    anchors = np.append(breaks[:-2], 1.0)
    at = np.append(breaks[:-2], 1.0)
    rows = [collocation(knots, degree, at, r) @ control / math.factorial(r) for r in range(degree + 1)]
    power = np.array(rows).T
    return [
        Piece(float(start), float(end), float(anchor), tuple(row.tolist()))
        for start, end, anchor, row in zip(breaks[:-1], breaks[1:], anchors, power, strict=True)
    ]
