"""Laws that join: from any velocity, acceleration and jerk to any other, through points, by control values or data.

Each takes an `Ends` and returns a motion from 0 to its lift. All are linear in the lift and the end derivatives, which
is what lets neighbouring joining segments share the smoothest common state.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from camgeom.errors import Problem, ProfileError
from camgeom.maths import Floats
from camgeom.maths.splines import Basis, clamped
from camgeom.motion.catalogue import law
from camgeom.motion.law import Ends, Parameter, ParamValue
from camgeom.motion.laws_basic import CUBIC, QUINTIC, SEPTIC
from camgeom.motion.measured import check_rise, end_control, fit, read_rows, to_pieces
from camgeom.motion.table import Piece

HERMITE = "two-point Hermite interpolation, C. de Boor, A Practical Guide to Splines, Springer 2001, ch. I"
SPLINES = "C. de Boor, A Practical Guide to Splines, Springer 2001, ch. IX and XIII"
BY_ORDER = [({"order": 1}, CUBIC), ({"order": 3}, SEPTIC)]
MOST_POINTS = 400


def _order(
    what: str = "derivatives carried over at both ends: 1 velocity, 2 and acceleration, 3 and jerk",
) -> Parameter:
    return Parameter(2, 1, 3, what, "integer")


@lru_cache
def _hermite(order: int) -> Floats:
    """Power coefficients (2 order + 2) of the Hermite basis at x = 0: rows value and derivatives at 0, then at 1."""
    degree = 2 * order + 1
    start = np.zeros((order + 1, degree + 1))
    for k in range(order + 1):
        # x^k/k! (1 - x)^(order + 1) sum_j C(order + j, j) x^j: in whole numbers up to the division by k!.
        for j in range(order + 1 - k):
            for i in range(order + 2):
                start[k, k + j + i] += math.comb(order + j, j) * math.comb(order + 1, i) * (-1) ** i
        start[k] /= math.factorial(k)
    # The basis at 1 is the mirror image: H(1 - x), with the sign of odd derivatives turned.
    flip = np.array([[math.comb(n, k) * (-1.0) ** k for k in range(degree + 1)] for n in range(degree + 1)])
    end = (start @ flip) * np.array([(-1.0) ** k for k in range(order + 1)])[:, None]
    return np.vstack([start, end])


@law("polynomial", source=HERMITE, claims=QUINTIC, cases=BY_ORDER, joins=True, order=_order())
def polynomial(ends: Ends, order: int) -> list[Piece]:
    """The polynomial that takes over velocity, acceleration (and jerk) of its neighbours: motion to motion."""
    start, end = ends.values(order)
    lift = np.array([ends.lift, *[0.0] * order])
    signs = np.array([(-1.0) ** k for k in range(2 * order + 2)])
    forward = np.concatenate([start, end]) @ _hermite(order)
    # About the end the same motion runs backwards from the lift: digits stay where they are needed.
    turned = np.concatenate([end - lift, start - lift]) * np.tile(signs[: order + 1], 2)
    backward = (turned @ _hermite(order)) * signs
    backward[0] = ends.lift
    return [Piece(0.0, 0.5, 0.0, tuple(forward.tolist())), Piece(0.5, 1.0, 1.0, tuple(backward.tolist()))]


@law(
    "spline",
    source=SPLINES,
    claims=QUINTIC,
    cases=BY_ORDER,
    joins=True,
    points=Parameter(
        (), 0, 0, "points to pass through: [share of the segment, lift above its start] pairs", "list", "last"
    ),
    order=_order(),
)
def spline(ends: Ends, points: tuple[tuple[float, float], ...], order: int) -> list[Piece]:
    """The smoothest spline through given points, joined to its neighbours: of fifth degree, C4 inside."""
    if not all(isinstance(point, tuple) and len(point) == 2 for point in points):
        raise ProfileError([Problem("points", "each point is a pair", points, "[[share, lift], ...]")])
    x, y = (np.array([float(point[i]) for point in points]) for i in (0, 1))
    steps = np.diff([0.0, *x, 1.0])
    if len(x) > MOST_POINTS or (len(x) and steps.min() < 1e-6):
        allowed = f"up to {MOST_POINTS} shares between 0 and 1, each 1e-6 above the one before"
        raise ProfileError([Problem("points", "the shares of the segment must rise", x.tolist(), allowed)])
    degree = 2 * order + 1
    knots = clamped(x, degree)
    states = ends.values(order)
    first, last = (end_control(knots, degree, end, values) for end, values in enumerate(states))
    basis = Basis(degree, knots).design(x)
    inner = slice(order + 1, order + 1 + len(x))
    rest = y * ends.unit - basis[:, : order + 1] @ first - basis[:, inner.stop :] @ last
    return to_pieces(knots, degree, np.concatenate([first, np.linalg.solve(basis[:, inner], rest), last]), *states)


@law(
    "b-spline",
    source=SPLINES,
    claims=QUINTIC,
    cases=BY_ORDER,
    joins=True,
    control=Parameter((), 0, 0, "inner control values (lift above the segment's start), evenly spread", "list",
                      "last"),
    order=_order(),
)
def b_spline(ends: Ends, control: tuple[float, ...], order: int) -> list[Piece]:
    """A B-spline shaped by control values: the curve keeps within them and moves only where they are moved."""
    if len(control) > MOST_POINTS or not all(isinstance(value, int | float) for value in control):
        raise ProfileError([Problem("control", "control values are numbers", control, f"up to {MOST_POINTS} numbers")])
    degree = 2 * order + 1
    knots = clamped(np.arange(1, len(control) + 1) / (len(control) + 1.0), degree)
    states = ends.values(order)
    first, last = (end_control(knots, degree, end, values) for end, values in enumerate(states))
    inner = np.asarray(control, dtype=float) * ends.unit
    return to_pieces(knots, degree, np.concatenate([first, inner, last]), *states)


@law(
    "table",
    source=f"penalised regression splines: P. H. C. Eilers, B. D. Marx, Statistical Science 11 (1996); {SPLINES}",
    claims=QUINTIC,
    cases=BY_ORDER,
    joins=True,
    data=("file", "rows"),
    file=Parameter("", 0, 0, "CSV file with two columns, cam angle and lift; relative to the profile", "text",
                   "refused"),
    rows=Parameter((), 0, 0, "the same rows inline: [[angle, lift], ...]", "list", "last"),
    smoothing=Parameter(
        -1.0, -1.0, 1e5, "standard deviation of the measured lifts; -1: found from the data", lift="number"
    ),
    knots=Parameter(100, 0, 400, "largest number of inner knots", "integer"),
    order=_order(),
)
def table(
    ends: Ends, file: str, rows: tuple[ParamValue, ...], smoothing: float, knots: int, order: int
) -> Sequence[Piece]:
    """A measured lift table smoothed by a spline; its angles are stretched over the segment, its ends join."""
    x, lift = read_rows(file, rows, ends.folder)
    if len(x) == 0:
        return polynomial(ends, order)
    check_rise(lift, ends, smoothing, "file" if file else "rows")
    return fit(x, lift * ends.unit, ends, smoothing * ends.unit, knots, order)
