"""Measured lift tables: reading them, and the smoothing spline that keeps given end conditions."""

from __future__ import annotations

import csv
import math
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from camgeom.errors import Problem, ProfileError
from camgeom.maths import Floats, distinct, gauss_rule
from camgeom.maths.splines import Basis, clamped
from camgeom.motion.law import Ends
from camgeom.motion.table import Piece
from camgeom.reading import lines_of, read_bytes


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


LEAST_ROWS = 8
"""as many as the polynomial of highest degree has coefficients"""
MOST_ROWS = 20000
LEAST_SPAN = 1e-4
"""share of the segment between knots; rows that crowd closer cannot bend the curve further"""
EXACT = 1e-9
"""share of the lift within which a curve runs through rows"""
LARGEST_FILE = 4_000_000
"""bytes; a lift table of a hundredth of a degree has less than a tenth of this"""


def read_rows(file: str, rows: tuple[Any, ...], folder: str) -> tuple[Floats, Floats]:
    """Share of the segment (n,) and lift above the first row (n,) of a table; both empty where none is given.

    Raises ProfileError where the file cannot be read, a row is not two numbers, or the angles do not rise.
    """
    if file and rows:
        raise ProfileError([Problem("rows", "a table is either a file or rows, not both", None, "one of them")])
    if not file and not rows:
        return np.empty(0), np.empty(0)
    key = "file" if file else "rows"
    pairs = file_rows(Path(folder, file)) if file else _pairs(rows, key)
    if not LEAST_ROWS <= len(pairs) <= MOST_ROWS:
        allowed = f"{LEAST_ROWS} to {MOST_ROWS} rows"
        raise ProfileError([Problem(key, "a table needs a fair number of rows", len(pairs), allowed)])
    angle, lift = np.array(pairs).T
    steps = np.diff(angle)
    if steps.min() <= 0.0:
        row = int(np.argmin(steps > 0.0)) + 1
        raise ProfileError([Problem(key, f"the angles must rise; row {row + 1} does not", float(angle[row]))])
    return (angle - angle[0]) / (angle[-1] - angle[0]), lift - lift[0]


def _pairs(rows: tuple[Any, ...], key: str) -> list[tuple[float, float]]:
    pairs = []
    for number, row in enumerate(rows):
        try:
            angle, lift = (float(cell) for cell in row)
        except (TypeError, ValueError):
            raise ProfileError([Problem(key, f"row {number + 1} is not two numbers", row, "angle, lift")]) from None
        if not (math.isfinite(angle) and math.isfinite(lift) and abs(angle) < 1e9 and abs(lift) < 1e9):
            raise ProfileError([Problem(key, f"row {number + 1} is out of range", row, "finite numbers below 1e9")])
        pairs.append((angle, lift))
    return pairs


def file_rows(path: Path) -> list[tuple[float, float]]:
    """The rows of a CSV file, angle and lift, below a line of words at most.

    Raises ProfileError where it cannot be read or holds anything else.
    """
    content = read_bytes(path, LARGEST_FILE, "")
    lines = [line for line in lines_of(content, "") if line.strip() and not line.lstrip().startswith("#")]
    delimiter = next((mark for mark in (";", "\t", ",") if lines and mark in lines[0]), ",")
    rows = [row[:2] for row in csv.reader(lines, delimiter=delimiter)]
    if rows and not any(map(_is_number, rows[0])):
        rows = rows[1:]
    return _pairs(tuple(tuple(row) for row in rows), "file")


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def check_rise(lift: Floats, ends: Ends, deviation: float, key: str) -> None:
    """Raise ProfileError where a table (lift (n,) in edge units) does not end at its segment's lift."""
    slack, wanted = max(6.0 * deviation, 2e-3 * float(np.ptp(lift))), ends.lift / ends.unit
    if abs(lift[-1] - wanted) > slack:
        message = "the table does not end at the segment's `to`"
        raise ProfileError([Problem(key, message, float(lift[-1]), f"a rise of {wanted:g} within {slack:g}")])


def fit(x: Floats, lift: Floats, ends: Ends, deviation: float, most_knots: int, order: int) -> list[Piece]:
    """The spline of degree 2 order + 1 with the given ends that weighs closeness against roughness.

    Minimises mean((f(x_i) + zero - lift_i)²) + weight * integral(f^(order + 1)²) over f and zero. The weight makes the
    rms distance equal to `deviation`, or, where that is negative, minimises the generalised cross-validation score.
    Where a knot for every two rows does not come as near as `deviation`, every row gets one, and where `most_knots` are
    still too few the curve comes as near as they let it: the check `table` tells how near.
    """
    inner = _inner_knots(x, most_knots)
    if deviation >= 0.0 and len(inner) < most_knots and _fitted(x, lift, ends, deviation, inner, order)[1] > max(
        1.01 * deviation, EXACT * float(np.ptp(lift))
    ):
        inner = _spaced(x[1:-1])
        inner = inner if len(inner) <= most_knots else _inner_knots(x, most_knots, 1)
    return _fitted(x, lift, ends, deviation, inner, order)[0]


def _fitted(
    x: Floats, lift: Floats, ends: Ends, deviation: float, inner_knots: Floats, order: int
) -> tuple[list[Piece], float]:
    """The spline on these inner knots, and the rms distance by which its weight was chosen."""
    knots = clamped(inner_knots, 2 * order + 1)
    states = ends.values(order)
    controls = [end_control(knots, 2 * order + 1, end, values) for end, values in enumerate(states)]
    outer = np.concatenate(controls)
    # A state shared with a neighbour is still sought: the weight must not depend on it, or the fit were not linear.
    judged = None if ends.shared else outer.tobytes()
    smoother = _smoother(x.tobytes(), lift.tobytes(), deviation, knots.tobytes(), order, judged)
    inner = smoother.free_fit - smoother.gain @ outer
    pieces = to_pieces(knots, 2 * order + 1, np.concatenate([controls[0], inner, controls[1]]), *states)
    return pieces, smoother.distance


def distances(wanted: Floats, found: Floats) -> Floats:
    """How far a motion runs above the lifts of a table's rows, (n,) each, both counted from the first row."""
    return np.asarray(found - found[0] - (wanted - wanted[0]))


class _Smoother(NamedTuple):
    """A table's fit, prepared: the inner control values are free_fit - gain @ (control values at both ends)."""

    free_fit: Floats
    gain: Floats
    distance: float


@lru_cache(maxsize=32)
def _smoother(x: bytes, lift: bytes, deviation: float, knots: bytes, order: int, judged: bytes | None) -> _Smoother:
    """The least-squares operator of a table for the weight that suits its ends, or free ends where `judged` is None."""
    angles, lifts, knot_row, degree = np.frombuffer(x), np.frombuffer(lift), np.frombuffer(knots), 2 * order + 1
    count = len(knot_row) - degree - 1
    # The table's zero is a reading like any other: its error is fitted too, as a last unknown.
    rows = np.column_stack([Basis(degree, knot_row).design(angles), np.ones(len(angles)), lifts])
    # All that the rows say, in as many rows as there are unknowns.
    packed = np.linalg.qr(rows / math.sqrt(len(angles)))[1]
    data, target = packed[:, : count + 1], packed[:, count + 1]
    rough = np.column_stack(
        [_roughness(knot_row, degree, order + 1), np.zeros((len(distinct(knot_row)) - 1) * (order + 1))]
    )
    inner = np.r_[order + 1 : count - order - 1, count]
    outer = np.r_[0 : order + 1, count - order - 1 : count]
    if judged is None:
        # With free ends the zero is no unknown of its own: the splines hold every constant.
        weight, distance = _weight(
            data[:, :count], target, rough[:, :count], np.zeros(len(rough)), len(angles), deviation
        )
    else:
        fixed = np.frombuffer(judged)
        bent = -rough[:, outer] @ fixed
        weight, distance = _weight(
            data[:, inner], target - data[:, outer] @ fixed, rough[:, inner], bent, len(angles), deviation
        )
    stacked = np.vstack([data, math.sqrt(weight) * rough])
    sides = np.column_stack([np.concatenate([target, np.zeros(len(rough))]), stacked[:, outer]])
    solved = np.linalg.lstsq(stacked[:, inner], sides, rcond=None)[0][:-1]
    return _Smoother(solved[:, 0], solved[:, 1:], distance)


def _inner_knots(x: Floats, most: int, rows: int = 2) -> Floats:
    """Inner knots at even counts of rows, no more than one for every so many rows, and not closer than LEAST_SPAN."""
    count = min(most, max(0, len(x) // rows - 1))
    return _spaced(np.quantile(x, np.arange(1, count + 1) / (count + 1.0)) if count else np.empty(0))


def _spaced(wanted: Floats) -> Floats:
    """These knots without those that are closer than LEAST_SPAN to one before or to an end."""
    kept = [0.0]
    for knot in wanted.tolist():
        if kept[-1] + LEAST_SPAN <= knot <= 1.0 - LEAST_SPAN:
            kept.append(knot)
    return np.array(kept[1:])


def _roughness(knots: Floats, degree: int, order: int) -> Floats:
    """The matrix whose square is the integral of the derivative's square: Gauss points a span, exact for the degree."""
    nodes, weights = gauss_rule(degree - order + 1)
    breaks = distinct(knots)
    middle, half = 0.5 * (breaks[1:] + breaks[:-1]), 0.5 * np.diff(breaks)
    x = (middle[:, None] + half[:, None] * nodes).ravel()
    scale = np.sqrt((half[:, None] * weights).ravel())
    return np.asarray(Basis(degree, knots).design(x, order) * scale[:, None])


def _weight(
    data: Floats, target: Floats, rough: Floats, bent: Floats, count: int, deviation: float
) -> tuple[float, float]:
    """The weight of |rough c - bent|² against |data c - target|², `count` rows being behind the data, and the rms
    distance of those from the fit."""
    if not rough.any():
        # No knots: what is left free, the table's zero, bends nothing.
        best = np.linalg.lstsq(data, target, rcond=None)[0] if data.size else np.zeros(data.shape[1])
        return 0.0, float(np.linalg.norm(data @ best - target))
    # One factorisation serves all weights: in this basis both forms are diagonal (Demmler and Reinsch). The hint of
    # roughness keeps it regular where a span holds no row.
    scale = 1e-9 / np.linalg.norm(rough)
    triangle = np.linalg.qr(np.vstack([data, scale * rough]))[1]
    left, gamma, turn = np.linalg.svd(np.linalg.solve(triangle.T, rough.T).T, full_matrices=False)
    projected, wanted = turn @ np.linalg.solve(triangle.T, data.T @ target), left.T @ bent
    outside = max(0.0, float(target @ target - projected @ projected))
    weights = 10.0 ** np.linspace(-24.0, 6.0, 241)
    kept = 1.0 / (1.0 + weights[:, None] * gamma**2)
    distance = weights[:, None] * kept * gamma * (wanted - gamma * projected)
    residual = outside + (distance**2).sum(axis=1)
    if deviation < 0.0:
        freedom = np.maximum(1e-12, 1.0 - kept.sum(axis=1) / count)
        chosen = int(np.argmin(residual / freedom**2))
    else:
        close = np.flatnonzero(residual <= deviation**2)
        chosen = int(close[-1]) if len(close) else 0
    return float(weights[chosen]), math.sqrt(float(residual[chosen]))
