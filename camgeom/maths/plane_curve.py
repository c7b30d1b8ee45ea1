"""Plane curves by exact points and tangents: clamped cubic splines and polylines with a measured deviation.

A curve is smooth between its knots. The spline's parameter is arc length, so that it is C1 at knots where the curvature
jumps, C2 between knots, and has a corner exactly where the curve has one. scipy is imported where a spline is made.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from camgeom.errors import NotConverged

Floats = npt.NDArray[np.float64]
Role = Literal["profile", "pitch", "cutter", "centre"]

HAIR = 1e-12
"""share of a piece by which its ends are nudged inwards, so that one-sided values are met"""
GAUSS = np.polynomial.legendre.leggauss(4)
CORNER = 1e-6
"""rad; a turn of the direction at a knot that makes a corner"""
FIRST = 6
"""spline intervals a piece starts with"""
ROUNDS = 16
MOST = 20_000
"""intervals of a spline, or chords of a polyline, beyond which it is given up"""
SHARES = np.array([0.25, 0.5, 0.75])
"""where in an interval the error is measured"""
FILL = 0.98
FEWEST = 16
"""cells a piece is measured in first"""


@dataclass(frozen=True, eq=False)
class PlaneCurve:
    """A plane curve over a parameter: at(phi (n,)) -> points (2, n) in mm and their derivatives (2, n).

    knots   (k,) increasing: the ends, and where a second derivative may jump
    closed  True where the end is the beginning
    """

    name: str
    role: Role
    at: Callable[[Floats], tuple[Floats, Floats]]
    knots: Floats
    closed: bool = True

    def pieces(self) -> list[tuple[float, float]]:
        """The smooth pieces, their ends a hair inwards."""
        return [(a + HAIR * (b - a), b - HAIR * (b - a)) for a, b in zip(self.knots[:-1], self.knots[1:])]


@dataclass(frozen=True, eq=False)
class Spline:
    """A clamped cubic B-spline: control points (n, 2), knots (n + 4,), largest measured distance to the curve."""

    control: Floats
    knots: Floats
    deviation: float

    def __call__(self, u: Floats) -> Floats:
        """Points (n, 2) at parameters u (arc length, mm, from knots[0] to knots[-1])."""
        from scipy.interpolate import BSpline

        return np.asarray(BSpline(self.knots, self.control, 3)(u))


@dataclass(frozen=True, eq=False)
class Polyline:
    """Points (n, 2) of the curve itself and the largest measured distance of the curve from its chords, mm."""

    points: Floats
    chord_error: float


def fitted(curve: PlaneCurve, deviation: float) -> Spline:
    """One clamped cubic spline through points of the curve that stays within `deviation` mm of it, measured.

    Every piece starts and ends with the curve's own direction. Raises NotConverged where the curve has a cusp.
    """
    knots, control = np.zeros(0), np.zeros((0, 2))
    worst = 0.0
    for low, high in curve.pieces():
        own, points, error = _fitted_piece(curve, low, high, deviation)
        worst = max(worst, error)
        if not len(knots):
            knots, control = own, points
            continue
        # Where both pieces leave the joint with one unit tangent over arc length, the joint's own control point and one
        # of its knots are redundant: without them the spline is C1 there by its knots alone. A corner keeps them.
        corner = _turned(control[-1] - control[-2], points[1] - points[0]) > CORNER
        knots = np.concatenate([knots[: -1 if corner else -2], own[4:] + knots[-1]])
        control = np.concatenate([control if corner else control[:-1], points[1:]])
    if curve.closed:
        control[-1] = control[0]
    return Spline(control, knots, worst)


def _turned(before: Floats, after: Floats) -> float:
    """Angle between two directions, rad."""
    return abs(float(np.arctan2(before[0] * after[1] - before[1] * after[0], before @ after)))


def _fitted_piece(curve: PlaneCurve, low: float, high: float, deviation: float) -> tuple[Floats, Floats, float]:
    phi = np.linspace(low, high, FIRST + 1)
    best = np.inf
    for _ in range(ROUNDS):
        knots, control, error = _interpolated(curve, phi)
        best = float(error.max())
        if best <= deviation:
            return knots, control, best
        # A cubic's error falls with the fourth power of the interval.
        parts = np.clip(np.ceil(1.05 * (error / deviation) ** 0.25), np.where(error > 0.9 * deviation, 2, 1), 4)
        phi = _subdivided(phi, parts.astype(np.int64))
        if len(phi) > MOST:
            break
    raise NotConverged(
        f"{curve.name}: no spline within {deviation:g} mm between {np.degrees(low):.6g} and {np.degrees(high):.6g} deg "
        f"(best {best:.3g} mm): the curve has a cusp there (look at the undercut margin)"
    )


def _subdivided(phi: Floats, parts: npt.NDArray[np.int64]) -> Floats:
    """Every interval of phi cut into so many parts."""
    first = np.repeat(np.cumsum(parts) - parts, parts)
    share = (np.arange(parts.sum()) - first) / np.repeat(parts, parts)
    return np.append(np.repeat(phi[:-1], parts) + share * np.repeat(np.diff(phi), parts), phi[-1])


def _interpolated(curve: PlaneCurve, phi: Floats) -> tuple[Floats, Floats, Floats]:
    """Spline through the curve at phi over arc length: knots, control points, and the error in every interval, mm."""
    from scipy.interpolate import make_interp_spline

    length = np.concatenate([[0.0], np.cumsum(_lengths(curve, phi))])
    if not np.all(np.diff(length) > 0.0):
        raise NotConverged(f"{curve.name}: stands still at {np.degrees(phi[0]):.6g} deg, so it has no direction there")
    points, tangent = curve.at(phi)
    tangent = tangent[:, [0, -1]] / np.hypot(*tangent[:, [0, -1]])
    ends: Any = ([(1, tangent[:, 0])], [(1, tangent[:, 1])])
    spline = make_interp_spline(length, points.T, 3, bc_type=ends)
    u = (length[:-1, None] + np.diff(length)[:, None] * SHARES).ravel()
    guess = np.interp(u, length, phi)
    error = distances(curve, np.asarray(spline(u)).T, guess, phi[0], phi[-1])
    return np.asarray(spline.t), np.asarray(spline.c), error.reshape(len(phi) - 1, -1).max(axis=1)


def _lengths(curve: PlaneCurve, phi: Floats) -> Floats:
    """Arc length (n - 1,) between neighbouring phi, by Gauss-Legendre quadrature."""
    x, w = GAUSS
    half = 0.5 * np.diff(phi)
    nodes = (0.5 * (phi[1:] + phi[:-1]))[:, None] + half[:, None] * x
    pace = np.hypot(*curve.at(nodes.ravel())[1]).reshape(nodes.shape)
    return np.asarray((pace * w).sum(axis=1) * half)


def distances(curve: PlaneCurve, points: Floats, guess: Floats, low: float, high: float) -> Floats:
    """Distance (n,) of points (2, n) from the curve's foot point near phi = guess (n,), by Gauss-Newton steps."""
    phi = guess.copy()
    for _ in range(2):
        x, d = curve.at(phi)
        square = np.maximum((d * d).sum(axis=0), 1e-300)
        phi = np.clip(phi + ((points - x) * d).sum(axis=0) / square, low, high)
    return np.asarray(np.hypot(*(points - curve.at(phi)[0])))


def chords(curve: PlaneCurve, chord: float) -> Polyline:
    """Points on the curve whose chords stay within `chord` mm of it, nearly equally far everywhere; measured.

    Raises NotConverged where that takes too many points.
    """
    parts: list[Floats] = []
    worst = 0.0
    for low, high in curve.pieces():
        phi = np.linspace(low, high, FEWEST + 1)
        aim = FILL * chord
        for _ in range(ROUNDS):
            sag = _sags(curve, phi)
            if sag.max() <= chord:
                break
            phi = _spread(phi, sag, aim)
            aim *= 0.97
            if len(phi) > MOST:
                raise NotConverged(f"{curve.name}: a chord error of {chord:g} mm needs more than {MOST} points")
        else:
            raise NotConverged(f"{curve.name}: the chord error stays at {sag.max():.3g} mm, above {chord:g} mm")
        if len(phi) == FEWEST + 1 and sag.max() < 0.25 * chord:
            coarse = _spread(phi, sag, aim)
            coarse_sag = _sags(curve, coarse)
            if coarse_sag.max() <= chord:
                phi, sag = coarse, coarse_sag
        worst = max(worst, float(sag.max()))
        first = 1 if parts else 0
        parts.append(curve.at(phi)[0][:, first:])
    points = np.concatenate(parts, axis=1).T
    return Polyline(np.ascontiguousarray(points[:-1] if curve.closed else points), worst)


def _sags(curve: PlaneCurve, phi: Floats) -> Floats:
    """Largest distance (n - 1,) of the curve from each chord, at three places."""
    ends = curve.at(phi)[0]
    between = (phi[:-1, None] + np.diff(phi)[:, None] * SHARES).ravel()
    x = curve.at(between)[0].reshape(2, len(phi) - 1, -1)
    step = np.diff(ends, axis=1)
    length = np.maximum(np.hypot(*step), 1e-300)
    away = x - ends[:, :-1, None]
    return np.asarray((np.abs(away[0] * step[1][:, None] - away[1] * step[0][:, None]) / length[:, None]).max(axis=1))


def _spread(phi: Floats, sag: Floats, aim: float) -> Floats:
    """New parameters with the chords that each cell needs, spread evenly over the piece."""
    need = np.maximum(np.sqrt(sag / aim), 1e-3)
    smooth = np.maximum(need, 0.5 * (np.r_[need[1:], need[-1]] + np.r_[need[0], need[:-1]]))
    total = np.concatenate([[0.0], np.cumsum(smooth)])
    count = max(1, int(np.ceil(total[-1])))
    found = np.interp(np.linspace(0.0, total[-1], count + 1), total, phi)
    found[[0, -1]] = phi[[0, -1]]
    return np.asarray(found)
