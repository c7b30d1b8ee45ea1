"""B-splines on 0 <= x <= 1 with clamped knots: their ends, and their pieces."""

from __future__ import annotations

import math

import numpy as np

from camgeom.maths import Floats, distinct
from camgeom.maths.splines import Basis
from camgeom.motion.table import Piece


def end_control(knots: Floats, degree: int, end: int, values: Floats) -> Floats:
    """The control values (k,) next to the start (end = 0) or the end (end = 1) that give value and derivatives there.

    `values` (k,) are the value and the k - 1 derivatives at x = 0 or x = 1.
    """
    count = len(values)
    rows = np.array([Basis(degree, knots).design(np.array([float(end)]), r)[0] for r in range(count)])
    block = rows[:, :count] if end == 0 else rows[:, -count:]
    # Rows of high derivatives are large by powers of the knot spacing; scaled they solve to rounding.
    scale = np.abs(block).max(axis=1)
    return np.asarray(np.linalg.solve(block / scale[:, None], values / scale))


def to_pieces(knots: Floats, degree: int, control: Floats, start: Floats, end: Floats) -> list[Piece]:
    """The spline as polynomial pieces, each about its left end; the last about x = 1.

    `start`, `end` (k,) are its value and derivatives at both ends, which the pieces then have to the last digit.
    """
    breaks = distinct(knots)
    anchors = np.append(breaks[:-2], 1.0)
    basis = Basis(degree, knots)
    rows = [basis.design(anchors, r) @ control / math.factorial(r) for r in range(degree + 1)]
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
