"""Plane curves by exact points and tangents: clamped cubic splines and polylines with a measured deviation.

A curve is smooth between its knots. The spline's parameter is arc length, so that it is C1 at knots where the curvature
jumps, C2 between knots, and has a corner exactly where the curve has one. scipy is imported where a spline is made.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import numpy as np

from camgeom.errors import NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats, gauss_rule
from camgeom.maths.sampling import even_steps, subdivided

Role = Literal["profile", "pitch", "cutter", "centre"]

HAIR = 1e-12
"""share of a piece by which its ends are nudged inwards, so that one-sided values are met"""
GAUSS = gauss_rule(4)
CORNER = 1e-6
"""rad; a turn of the direction at a knot that makes a corner"""
FIRST = 6
"""spline intervals a piece starts with"""
ROUNDS = 16
MOST = 20_000
"""intervals of a spline, or chords of a polyline, beyond which it is given up"""
SHARES = np.array([0.25, 0.5, 0.75])
"""where in an interval the error is measured"""


@immutable
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


@immutable
class Spline:
    """A clamped cubic B-spline: control points (n, 2), knots (n + 4,), largest measured distance to the curve."""

    control: Floats
    knots: Floats
    deviation: float

    def __call__(self, u: Floats) -> Floats:
        """Points (n, 2) at parameters u (arc length, mm, from knots[0] to knots[-1])."""
        from scipy.interpolate import BSpline

        return np.asarray(BSpline(self.knots, self.control, 3)(u))


@immutable
class Polyline:
    """Points (n, 2) of the curve itself and the largest measured distance of the curve from its chords, mm."""

    points: Floats
    chord_error: float


def fitted(curve: PlaneCurve, deviation: float) -> Spline:
    """One clamped cubic spline through points of the curve that stays within `deviation` mm of it, measured.

    Every piece starts and ends with the curve's own direction. Raises NotConverged where the curve stands still, or
    where no spline is near enough.
    """
    knots, control = np.zeros(0), np.zeros((0, 2))
    worst = 0.0
    for own, points, error in _fitted_pieces(curve, deviation):
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


def _fitted_pieces(curve: PlaneCurve, deviation: float) -> list[tuple[Floats, Floats, float]]:
    """Knots, control points and error of every piece; all are refined together, with few calls of the curve."""
    grids = [np.linspace(low, high, FIRST + 1) for low, high in curve.pieces()]
    done: dict[int, tuple[Floats, Floats, float]] = {}
    best = np.inf
    for _ in range(ROUNDS):
        left = [number for number in range(len(grids)) if number not in done]
        best = 0.0
        for number, (knots, control, error) in zip(left, _interpolated(curve, [grids[number] for number in left])):
            worst = float(error.max())
            if worst <= deviation:
                done[number] = knots, control, worst
                continue
            best = max(best, worst)
            # A cubic's error falls with the fourth power of the interval.
            parts = np.clip(np.ceil(1.05 * (error / deviation) ** 0.25), np.where(error > 0.9 * deviation, 2, 1), 4)
            grids[number] = subdivided(grids[number], parts.astype(np.int64))
        if len(done) == len(grids):
            return [done[number] for number in range(len(grids))]
        if max(map(len, grids)) > MOST:
            break
    where = np.degrees(next(grid for number, grid in enumerate(grids) if number not in done)[[0, -1]])
    raise NotConverged(
        f"{curve.name}: no spline within {deviation:g} mm between {where[0]:.6g} and {where[1]:.6g} deg (best "
        f"{best:.3g} mm): the curve has a cusp there (look at the undercut margin)"
    )


def _interpolated(curve: PlaneCurve, grids: list[Floats]) -> list[tuple[Floats, Floats, Floats]]:
    """Splines through the curve at every grid of phi over arc length: knots, control points, error by interval, mm."""
    from scipy.interpolate import make_interp_spline

    lengths = [np.concatenate([[0.0], np.cumsum(step)]) for step in _lengths(curve, grids)]
    places, tangents = (_split(values, grids) for values in curve.at(np.concatenate(grids)))
    made, between, guesses = [], [], []
    for phi, length, points, tangent in zip(grids, lengths, places, tangents):
        if not np.all(np.diff(length) > 0.0):
            where = np.degrees(phi[0])
            raise NotConverged(f"{curve.name}: stands still at {where:.6g} deg, so it has no direction there")
        unit = tangent[:, [0, -1]] / np.hypot(*tangent[:, [0, -1]])
        ends: Any = ([(1, unit[:, 0])], [(1, unit[:, 1])])
        spline = make_interp_spline(length, points.T, 3, bc_type=ends)
        u = (length[:-1, None] + np.diff(length)[:, None] * SHARES).ravel()
        made.append((np.asarray(spline.t), np.asarray(spline.c)))
        between.append(np.asarray(spline(u)).T)
        guesses.append(np.interp(u, length, phi))
    low, high = (np.concatenate([np.full(len(g), phi[end]) for g, phi in zip(guesses, grids)]) for end in (0, -1))
    error = distances(curve, np.concatenate(between, axis=1), np.concatenate(guesses), low, high)
    errors = np.split(error, np.cumsum([len(g) for g in guesses])[:-1])
    return [(*one, e.reshape(-1, len(SHARES)).max(axis=1)) for one, e in zip(made, errors)]


def _split(values: Floats, grids: list[Floats]) -> list[Floats]:
    """Columns (.., n) of several grids in one array, taken apart."""
    return np.split(values, np.cumsum([len(phi) for phi in grids])[:-1], axis=-1)


def _lengths(curve: PlaneCurve, grids: list[Floats]) -> list[Floats]:
    """Arc length between neighbouring phi of every grid, by Gauss-Legendre quadrature."""
    x, w = GAUSS
    half = [0.5 * np.diff(phi) for phi in grids]
    middle = [0.5 * (phi[1:] + phi[:-1]) for phi in grids]
    nodes = np.concatenate(middle)[:, None] + np.concatenate(half)[:, None] * x
    pace = np.hypot(*curve.at(nodes.ravel())[1]).reshape(nodes.shape)
    return _split((pace * w).sum(axis=1) * np.concatenate(half), half)


def distances(curve: PlaneCurve, points: Floats, guess: Floats, low: Floats, high: Floats) -> Floats:
    """Distance (n,) of points (2, n) from the curve's foot point near phi = guess, between low and high, (n,) each."""
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
    try:
        phi, sag = even_steps(lambda phi: _sags(curve, phi), curve.pieces(), chord, MOST)
    except NotConverged as error:
        raise NotConverged(f"{curve.name}: a chord error of {error}") from None
    worst = float(sag.max())
    if worst > chord:
        raise NotConverged(f"{curve.name}: the chord error stays at {worst:.3g} mm, above {chord:g} mm")
    points = curve.at(phi)[0].T
    return Polyline(np.ascontiguousarray(points[:-1] if curve.closed else points), worst)


def _sags(curve: PlaneCurve, phi: Floats) -> Floats:
    """Largest distance (n,) of the curve from each chord between neighbours of phi (n + 1,), at three places."""
    ends = curve.at(phi)[0]
    between = phi[:-1, None] + np.diff(phi)[:, None] * SHARES
    x = curve.at(between.ravel())[0].reshape(2, len(phi) - 1, -1)
    step = np.diff(ends, axis=1)
    length = np.maximum(np.hypot(*step), 1e-300)
    away = x - ends[:, :-1, None]
    return np.asarray((np.abs(away[0] * step[1][:, None] - away[1] * step[0][:, None]) / length[:, None]).max(axis=1))
