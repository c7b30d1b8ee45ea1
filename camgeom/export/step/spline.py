"""Clamped B-spline surfaces and curves through exact points, to a measured deviation.

Interpolation is at the Greville abscissae of a uniform clamped knot vector: square, banded, well conditioned, and it
passes through both ends, so a surface's boundary poles depend on the boundary points alone. Two patches that share a
boundary callable and a basis therefore share the boundary curve pole for pole. The inverse of the collocation matrix
depends on degree and number of spans only and is kept, so that each fit is one matrix product per direction.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import final

import numpy as np

from camgeom.errors import NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.splines import Basis, clamped

SurfacePoints = Callable[[Floats, Floats], Floats]
"""Exact points of a surface on a grid: (n,) u and (m,) v -> (n, m, 3) mm."""

MAX_SPANS = 256
DEGREE = 5
"""along u: the deviation falls with the sixth power of the span, so few poles reach a nanometre"""
FIRST_SPANS = 6
_PROBES = np.array([0.07, 0.23, 0.41, 0.59, 0.77, 0.93])
"""Positions inside each span where a fit is measured: none is a Greville abscissa of a uniform knot vector."""


@final
@immutable
class SurfaceFit:
    """Interpolated surface: bases along u and v, poles (nu, nv, 3) mm, and the largest deviation in mm between."""

    u: Basis
    v: Basis
    poles: Floats
    deviation: float
    exact: Floats
    """(n, m, 3) the exact points it was measured against, boundary included, for recognising elementary shapes."""

    @property
    def spans(self) -> tuple[int, int]:
        """Number of knot spans along u and v."""
        return len(self.u.breaks) - 1, len(self.v.breaks) - 1


def fit_bands(
    points: Sequence[SurfacePoints],
    degrees: Sequence[int],
    u: tuple[float, float],
    tolerance: float,
    spans: tuple[int, Sequence[int]] | None = None,
) -> list[SurfaceFit]:
    """Quintic-by-`degrees` surfaces over one interval of u and v in [0, 1], through exact points.

    All share their basis along u, which is refined, and each across apart, until every one is within `tolerance` mm of
    its exact points at six other parameters in each span. spans: the fewest along u, and across each surface.
    Raises NotConverged where MAX_SPANS spans are not enough: a kink inside the interval, which belongs at a knot.
    """
    nu, across = (FIRST_SPANS, [1] * len(points)) if spans is None else (spans[0], list(spans[1]))
    while True:
        trials = [_Trial(point, degree, u, nu, nv) for point, degree, nv in zip(points, degrees, across)]
        along = max(trial.along for trial in trials)
        if not along <= 0.5 * tolerance:  # true for NaN as well
            nu = refined(nu, 2.0 * along, tolerance, DEGREE, *u)
        rough = [k for k, trial in enumerate(trials) if not trial.across <= 0.5 * tolerance]
        for k in rough:
            across[k] = refined(across[k], 2.0 * trials[k].across, tolerance, degrees[k], 0.0, 1.0)
        if along <= 0.5 * tolerance and not rough:
            return [trial.fit() for trial in trials]


@final
class _Trial:
    """One fit and its deviation along u and across, mm; the exact points come in one call."""

    def __init__(self, point: SurfacePoints, degree: int, u: tuple[float, float], nu: int, nv: int) -> None:
        self.ku, self.kv, self.interval = kit(DEGREE, nu), kit(degree, nv), u
        a, b = len(self.ku.nodes), len(self.kv.nodes)
        self.grid = point(_scaled(self.ku.grid, *u), self.kv.grid)
        rows = _along_u(self.ku.inverse, self.grid[:a, :b])
        self.poles = self.kv.inverse @ rows
        over = (self.kv.probe @ self.kv.inverse) @ self.grid[:a, :b]
        self.along = _largest(_along_u(self.ku.probe, rows) - self.grid[a:, :b])
        self.across = _largest(over - self.grid[:a, b:])

    def fit(self) -> SurfaceFit:
        """The finished fit, with its deviation measured where neither direction was interpolated."""
        a, b = len(self.ku.nodes), len(self.kv.nodes)
        fitted = self.kv.probe @ _along_u(self.ku.probe, self.poles)
        error = max(self.along, self.across, _largest(fitted - self.grid[a:, b:]))
        rows = np.r_[0, a : len(self.ku.grid), a - 1]
        columns = np.r_[0, b : len(self.kv.grid), b - 1]
        bases = Basis(DEGREE, _scaled(self.ku.knots, *self.interval)), Basis(self.kv.degree, self.kv.knots)
        return SurfaceFit(*bases, self.poles, error, self.grid[rows[:, None], columns])


@final
@immutable
class Kit:
    """Everything about interpolation on [0, 1] that does not depend on the points."""

    degree: int
    knots: Floats
    nodes: Floats
    inverse: Floats
    probe: Floats
    grid: Floats
    """nodes, then the parameters in between where the fit is measured"""


@lru_cache(maxsize=256)
def kit(degree: int, spans: int) -> Kit:
    breaks = np.linspace(0.0, 1.0, spans + 1)
    basis = Basis(degree, clamped(breaks[1:-1], degree))
    nodes = np.clip(basis.greville, 0.0, 1.0)
    nodes[0], nodes[-1] = 0.0, 1.0
    inverse = np.asarray(np.linalg.inv(basis.design(nodes)), dtype=float)
    inverse[0], inverse[-1] = np.eye(basis.size)[0], np.eye(basis.size)[-1]
    probes = (breaks[:-1, None] + _PROBES / spans).ravel()
    return Kit(degree, basis.knots, nodes, inverse, basis.design(probes), np.concatenate([nodes, probes]))


def _scaled(unit: Floats, start: float, stop: float) -> Floats:
    """Unit parameters on [start, stop]; both ends are hit exactly."""
    return np.asarray(start * (1.0 - unit) + stop * unit)


def _along_u(matrix: Floats, points: Floats) -> Floats:
    """Matrix (k, n) applied along the first axis of points (n, m, 3)."""
    n, m, _ = points.shape
    return np.asarray((matrix @ points.reshape(n, 3 * m)).reshape(-1, m, 3))


def _largest(difference: Floats) -> float:
    return float(np.sqrt(np.einsum("...i,...i->...", difference, difference).max()))


def refined(spans: int, error: float, tolerance: float, degree: int, start: float, stop: float) -> int:
    """Next number of spans: the error falls with spans^-(degree + 1) once the points are resolved."""
    if not np.isfinite(error):
        raise NotConverged(f"spline fit on [{start:.6g}, {stop:.6g}]: the exact points hold NaN or infinity")
    factor = min(max(1.08 * (error / tolerance) ** (1.0 / (degree + 1)), 1.15), 3.0)
    more = int(np.ceil(spans * factor))
    if spans >= MAX_SPANS:
        raise NotConverged(
            f"spline fit on [{start:.6g}, {stop:.6g}]: {error:.3g} mm left with {spans} spans, {tolerance:.3g} asked; "
            "split the interval where the curve has a kink, or allow a larger tolerance"
        )
    return min(more, MAX_SPANS)
