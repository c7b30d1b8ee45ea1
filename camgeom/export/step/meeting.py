"""Where surfaces meet: corners of three as points, edges of two as splines, by Newton's method on their parameters.

An edge is a line of constant parameter, or a crossing found from a rough chain of points.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.errors import NotConverged
from camgeom.export.step.geometry import Curve, SplineCurve, SplineSurface, Surface, largest_gap
from camgeom.export.step.recognise import curve_of
from camgeom.export.step.spline import DEGREE, kit, refined
from camgeom.maths import Floats, distinct
from camgeom.maths.splines import Basis

Ints = npt.NDArray[np.int64]

STEPS = 25
ARRIVED = 1e-11
"""mm; a step below which the search has arrived"""
APART = 1e-9
"""mm; surfaces must meet within this"""
STEADY = 0.05
"""least evenness (slowest over mean pace) of a parameter that an edge is a function of"""
KEPT = 0.7
"""least share of the rough points through which that parameter runs one way"""
LEAST_POINTS = 12
MOST_POINTS = 160
NEAR = 0.01
"""a fit within this share of the edge's length guides the search for the next one"""
LEAST_GAP = 0.3
"""least distance of rough points as a share of their mean distance"""


def corner(surfaces: Sequence[Surface], guesses: Floats, fixed: Sequence[dict[int, float]]) -> tuple[Floats, Floats]:
    """The point (3,) on all surfaces and its parameters (k, 2), by least squares; raises NotConverged.

    guesses  (k, 2) parameters to start from; fixed: for each surface the parameters (0: u, 1: v) that are given
    """
    at = np.array(guesses, dtype=float)
    for k, given in enumerate(fixed):
        for axis, value in given.items():
            at[k, axis] = value
    free = [(k, axis) for k in range(len(surfaces)) for axis in (0, 1) if axis not in fixed[k]]
    gap = np.inf
    for _ in range(STEPS):
        jets = [surface.jet(at[k : k + 1, 0], at[k : k + 1, 1]) for k, surface in enumerate(surfaces)]
        points = np.array([jet[0][0] for jet in jets])
        middle = points.mean(axis=0)
        gap = float(np.abs(points - middle).max())
        if not free:
            return middle, at
        # Unknowns: the point, then the free parameters, each scaled to mm.
        matrix = np.zeros((3 * len(surfaces), 3 + len(free)))
        scale = np.ones(3 + len(free))
        for k in range(len(surfaces)):
            matrix[3 * k : 3 * k + 3, :3] = np.eye(3)
        for j, (k, axis) in enumerate(free):
            tangent = jets[k][1 + axis][0]
            scale[3 + j] = max(float(np.sqrt(tangent @ tangent)), 1e-12)
            matrix[3 * k : 3 * k + 3, 3 + j] = -tangent / scale[3 + j]
        step = np.linalg.lstsq(matrix, (points - middle).ravel(), rcond=1e-12)[0]
        for j, (k, axis) in enumerate(free):
            at[k, axis] += step[3 + j] / scale[3 + j]
        if np.abs(step).max() < ARRIVED:
            break
    if not gap < APART:
        raise NotConverged(f"{len(surfaces)} surfaces do not meet in a corner: {gap:.3g} mm apart")
    return middle, at


def along(
    first: Surface,
    second: Surface,
    a: Floats,
    b: Floats,
    planes: tuple[Floats, Floats] | None = None,
    held: int | None = None,
) -> tuple[Floats, Floats, Floats]:
    """Points (n, 3) on both surfaces and their parameters (n, 2) on each, from parameters a, b (n, 2) near them.

    Which point of the edge is either said by planes, through points (n, 3) across directions (n, 3), or by one
    parameter that is held: 0, 1 of the first surface, 2, 3 of the second.
    Raises NotConverged where the surfaces do not cross there.
    """
    a, b = a.copy(), b.copy()
    matrix, rest = np.zeros((len(a), 4, 4)), np.zeros((len(a), 4))
    for _ in range(STEPS):
        x, xu, xv = first.jet(a[:, 0], a[:, 1])
        y, yu, yv = second.jet(b[:, 0], b[:, 1])
        tangents = np.stack([xu, xv, -yu, -yv], axis=1)
        sizes = np.sqrt((tangents * tangents).sum(axis=2)) + 1e-150
        tangents /= sizes[:, :, None]
        matrix[:, :3] = tangents.transpose(0, 2, 1)
        rest[:, :3] = y - x
        if planes is not None:
            guide, direction = planes
            across = direction / np.sqrt((direction * direction).sum(axis=1))[:, None]
            matrix[:, 3, :2] = np.einsum("njc,nc->nj", tangents[:, :2], across)
            rest[:, 3] = np.einsum("nc,nc->n", guide - x, across)
        else:
            matrix[:, 3, held] = 1.0
        try:
            step = np.linalg.solve(matrix, rest[:, :, None])[:, :, 0]
        except np.linalg.LinAlgError:
            raise NotConverged("two surfaces touch instead of crossing") from None
        if not np.all(np.isfinite(step)):
            raise NotConverged("two surfaces do not cross where the mesh says so")
        if np.abs(step).max() < ARRIVED:
            return x, a, b
        a += step[:, :2] / sizes[:, :2]
        b += step[:, 2:] / sizes[:, 2:]
    gap = float(np.abs(rest[:, :3]).max())
    if not gap < APART:
        raise NotConverged(f"two surfaces do not cross where the mesh says so: {gap:.3g} mm apart")
    return x, a, b


def fit_curve(point: Callable[[Floats], Floats], start: Floats, stop: Floats, tolerance: float) -> tuple[Curve, float]:
    """The line, circle or quintic spline through exact points share (n,) -> (n, 3) mm, and its deviation in mm.

    start, stop  its ends (3,), which replace the first and the last point.
    """
    spans = 4
    while True:
        tools = kit(DEGREE, spans)
        exact = point(tools.grid)
        nodes = len(tools.nodes)
        exact[0], exact[nodes - 1] = start, stop
        poles = tools.inverse @ exact[:nodes]
        error = largest_gap(tools.probe @ poles, exact[nodes:])
        if error <= tolerance:
            order = np.argsort(tools.grid, kind="stable")
            return curve_of(Basis(DEGREE, tools.knots), poles, exact[order]), error
        spans = refined(spans, error, tolerance, DEGREE, 0.0, 1.0)


def iso_curve(surface: SplineSurface, axis: int, value: float, low: float, high: float, plain: bool = False) -> Curve:
    """The line on which parameter `axis` has the value, from low to high of the other one: a piece of the surface's own
    spline, pole for pole and with its parameter (negative where high is the lower one). plain: the line or circle that
    it is, where it is one."""
    other, sign = (surface.v, surface.u)[axis], 1.0 if high > low else -1.0
    low, high = sign * low, sign * high
    inner = np.sort(sign * other.breaks)
    room = 1e-9 * (high - low)
    inner = inner[(inner > low + room) & (inner < high - room)]
    ends = np.full(other.degree + 1, low), np.full(other.degree + 1, high)
    basis = Basis(other.degree, np.concatenate([ends[0], inner, ends[1]]))
    nodes = np.clip(basis.greville, low, high)
    t = distinct(np.concatenate([nodes, np.linspace(low, high, 3 * len(nodes))]))
    at = [sign * t] * 2
    at[axis] = np.full(len(t), value)
    exact = surface.jet(*at)[0]
    poles = np.asarray(np.linalg.solve(basis.design(nodes), exact[np.searchsorted(t, nodes)]), dtype=np.float64)
    poles[0], poles[-1] = exact[0], exact[-1]
    return curve_of(basis, poles, exact) if plain else SplineCurve(basis, poles)


@final
class SurfaceCrossing:
    """The edge in which two surfaces cross, from rough points (n, 3) with rough parameters (n, 2) on both.

    The ends are exact. Where a parameter of one of the surfaces runs one way along the edge, the edge is a function of
    it; elsewhere points are sought in planes across a guiding curve, which is the fit before.
    """

    def __init__(self, surfaces: tuple[Surface, Surface], rough: Floats, a: Floats, b: Floats) -> None:
        self.surfaces, self.ends = surfaces, (rough[0].copy(), rough[-1].copy())
        table = _spread(_thinned(np.concatenate([rough, a, b], axis=1)))
        rough, p = table[:, :3], table[:, 3:]
        x, found = self._search(rough, p, planes=(rough, np.gradient(rough, axis=0)))
        x[[0, -1]], found[[0, -1]] = self.ends, p[[0, -1]]
        self.x, self.p = x, found

    def _search(
        self, near: Floats, p: Floats, planes: tuple[Floats, Floats] | None = None, held: int | None = None
    ) -> tuple[Floats, Floats]:
        """Exact points (n, 3) and parameters (n, 4) from near points and parameters."""
        starts = [
            at if isinstance(surface, SplineSurface) else np.stack(surface.locate(near), axis=1)
            for surface, at in zip(self.surfaces, (p[:, :2], p[:, 2:]))
        ]
        x, a, b = along(*self.surfaces, starts[0], starts[1], planes, held)
        return x, np.concatenate([a, b], axis=1)

    def fit(self, tolerance: float) -> tuple[Curve, float]:
        """The line, circle or quintic spline along the crossing, and its distance from it in mm, as measured."""
        axis, kept = self._running()
        if axis is not None:
            # Where the edge turns back along that parameter, it is no function of it.
            with suppress(NotConverged):
                return self._by_parameter(axis, kept, tolerance)
        return self._guided(tolerance)

    def _running(self) -> tuple[int | None, Ints]:
        """The spline parameter that runs most evenly one way along the edge (None: none does), and the points kept."""
        best = STEADY
        chosen: tuple[int | None, Ints] = (None, np.arange(len(self.x)))
        for axis in range(4):
            if not isinstance(self.surfaces[axis // 2], SplineSurface):
                continue
            p = self.p[:, axis]
            share = (p - p[0]) / (p[-1] - p[0]) if p[-1] != p[0] else np.zeros(len(p))
            ahead = np.maximum.accumulate(np.concatenate([[0.0], share[:-1]]))
            inside = (share > ahead) & (share < 1.0)
            inside[[0, -1]] = True
            kept = np.nonzero(inside)[0]
            if len(kept) < KEPT * len(p):
                continue
            step = np.sqrt((np.diff(self.x[kept], axis=0) ** 2).sum(axis=1))
            pace = np.diff(share[kept]) * step.sum() / np.maximum(step, 1e-300)
            even = float(min(np.quantile(pace, 0.1), 1.0 / np.quantile(pace, 0.9)))
            if even > best:
                best, chosen = even, (axis, kept)
        return chosen

    def _by_parameter(self, axis: int, kept: Ints, tolerance: float) -> tuple[Curve, float]:
        low, high = self.p[0, axis], self.p[-1, axis]
        known = np.concatenate([self.p[kept], self.x[kept]], axis=1)

        def point(share: Floats) -> Floats:
            nonlocal known
            start = _between(share, (known[:, axis] - low) / (high - low), known)
            start[:, axis] = low * (1.0 - share) + high * share
            x, p = self._search(start[:, 4:], start[:, :4], held=axis)
            order = np.argsort(share, kind="stable")
            known = np.concatenate([known[:1], np.concatenate([p, x], axis=1)[order], known[-1:]])
            return x

        return fit_curve(point, *self.ends, tolerance)

    def _guided(self, tolerance: float) -> tuple[Curve, float]:
        spans = 3
        guide: SplineCurve | None = None
        step = np.sqrt((np.diff(self.x, axis=0) ** 2).sum(axis=1))
        t, near = np.concatenate([[0.0], np.cumsum(step)]) / step.sum(), NEAR * float(step.sum())
        while True:
            tools = kit(DEGREE, spans)
            x = self._beside(guide, t, tools.grid)
            nodes = len(tools.nodes)
            x[0], x[nodes - 1] = self.ends
            curve = SplineCurve(Basis(DEGREE, tools.knots), tools.inverse @ x[:nodes])
            error = largest_gap(tools.probe @ curve.poles, x[nodes:])
            if error < near:
                # Near enough to be its own guide: what is left is measured across it.
                guide = curve
                exact = self._beside(guide, t, tools.grid[nodes:])
                error = largest_gap(exact, tools.probe @ curve.poles)
                if error <= tolerance:
                    order = np.argsort(tools.grid, kind="stable")
                    return curve_of(curve.basis, curve.poles, np.concatenate([x[:nodes], exact])[order]), error
            spans = refined(spans, error, tolerance, DEGREE, 0.0, 1.0)

    def _beside(self, guide: SplineCurve | None, t: Floats, at: Floats) -> Floats:
        """Exact points beside the guide (at first: cubics through the points known at t) at parameters `at`."""
        planes = _cubic(t, self.x, at) if guide is None else (guide.at(at), guide.tangent(at))
        return self._search(planes[0], _between(at, t, self.p), planes=planes)[0]


def _between(at: Floats, t: Floats, values: Floats) -> Floats:
    """Columns of values (n, c) at t (n,), linear between."""
    return np.stack([np.interp(at, t, values[:, c]) for c in range(values.shape[1])], axis=1)


def _cubic(t: Floats, x: Floats, at: Floats) -> tuple[Floats, Floats]:
    """Points and derivatives (n, 3) of the Hermite cubics through points x at t, at parameters `at` (n,)."""
    slope = np.gradient(x, t, axis=0)
    i = np.clip(np.searchsorted(t, at, side="right") - 1, 0, len(t) - 2)
    h = (t[i + 1] - t[i])[:, None]
    s = (at - t[i])[:, None] / h
    d0, d1, chord = h * slope[i], h * slope[i + 1], x[i + 1] - x[i]
    bend, rest = 3.0 * chord - 2.0 * d0 - d1, d0 + d1 - 2.0 * chord
    return x[i] + s * (d0 + s * (bend + s * rest)), (d0 + s * (2.0 * bend + 3.0 * s * rest)) / h


def _thinned(table: Floats) -> Floats:
    """Rows (n, c) whose first three columns are points, without those that crowd the one before (the ends stay)."""
    step = np.sqrt((np.diff(table[:, :3], axis=0) ** 2).sum(axis=1))
    least = LEAST_GAP * step.mean()
    kept, walked = [0], 0.0
    for i in range(1, len(table) - 1):
        walked += step[i - 1]
        if walked >= least:
            kept.append(i)
            walked = 0.0
    if len(kept) > 1 and walked + step[-1] < least:
        kept.pop()
    return np.asarray(table[[*kept, len(table) - 1]])


def _spread(values: Floats) -> Floats:
    """Between LEAST_POINTS and MOST_POINTS rows, evenly chosen or linear between."""
    n = len(values)
    if n > MOST_POINTS:
        return np.asarray(values[np.round(np.linspace(0, n - 1, MOST_POINTS)).astype(int)])
    if n >= LEAST_POINTS:
        return values.copy()
    at = np.linspace(0.0, n - 1.0, LEAST_POINTS)
    return np.stack([np.interp(at, np.arange(n), values[:, c]) for c in range(values.shape[1])], axis=1)
