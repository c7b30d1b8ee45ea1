"""Clamped B-splines in numpy: basis functions, and interpolation of exact points to a measured deviation.

Interpolation is at the Greville abscissae of a uniform clamped knot vector: square, banded, well conditioned, and it
passes through both ends, so a surface's boundary poles depend on the boundary points alone. Two patches that share a
boundary callable and a basis therefore share the boundary curve pole for pole. The inverse of the collocation matrix
depends on degree and number of spans only and is kept, so that each fit is one matrix product per direction.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.errors import NotConverged

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.intp]
CurvePoints = Callable[[Floats], Floats]
"""Exact points of a curve: (n,) parameters -> (n, 3) mm."""
SurfacePoints = Callable[[Floats, Floats], Floats]
"""Exact points of a surface on a grid: (n,) u and (m,) v -> (n, m, 3) mm."""

MAX_SPANS = 1024
_PROBES = np.array([0.07, 0.23, 0.41, 0.59, 0.77, 0.93])
"""Positions inside each span where a fit is measured: none is a Greville abscissa of a uniform knot vector."""


@final
@dataclass(frozen=True, eq=False)
class Basis:
    """B-spline basis functions on a clamped knot vector (first and last knot `degree + 1` times)."""

    degree: int
    knots: Floats

    @property
    def size(self) -> int:
        """Number of basis functions, which is the number of poles."""
        return len(self.knots) - self.degree - 1

    @property
    def start(self) -> float:
        """First parameter."""
        return float(self.knots[0])

    @property
    def stop(self) -> float:
        """Last parameter."""
        return float(self.knots[-1])

    @cached_property
    def breaks(self) -> Floats:
        """Distinct knots, ascending."""
        return np.unique(self.knots)

    @cached_property
    def multiplicities(self) -> Ints:
        """How often each of `breaks` occurs in the knot vector."""
        return np.unique(self.knots, return_counts=True)[1].astype(np.intp)

    @cached_property
    def greville(self) -> Floats:
        """Greville abscissae (size,): means of `degree` consecutive knots, where interpolation is well posed."""
        inner = np.lib.stride_tricks.sliding_window_view(self.knots[1:-1], self.degree)
        return np.asarray(inner.mean(axis=1))

    def local(self, x: Floats, order: int = 0) -> tuple[Ints, Floats]:
        """Index of the first basis function alive at each x (n,), and the `order`-th derivatives of the
        degree + 1 living ones, (n, degree + 1)."""
        span = np.clip(np.searchsorted(self.knots, x, side="right") - 1, self.degree, self.size - 1)
        return span - self.degree, _derivatives(self.degree, self.knots, span, x, order)

    def design(self, x: Floats, order: int = 0) -> Floats:
        """Matrix (n, size) of the `order`-th derivative of every basis function at x (n,)."""
        first, values = self.local(x, order)
        matrix = np.zeros((len(x), self.size))
        columns = first[:, None] + np.arange(self.degree + 1)
        np.put_along_axis(matrix, columns, values, axis=1)
        return matrix


def _derivatives(degree: int, knots: Floats, span: Ints, x: Floats, order: int) -> Floats:
    """Cox-de Boor recursion for all x at once; a derivative is a difference of the functions one degree lower."""
    if order > 0:
        if degree == 0:
            return np.zeros((len(x), 1))
        values = np.zeros((len(x), degree + 1))
        index = span[:, None] + np.arange(1 - degree, 1)
        lower = _derivatives(degree - 1, knots, span, x, order - 1)
        weight = degree * lower / (knots[index + degree] - knots[index])
        values[:, :-1] -= weight
        values[:, 1:] += weight
        return values
    values = np.ones((len(x), 1))
    for j in range(1, degree + 1):
        index = span[:, None] + np.arange(1 - j, 1)
        left, right = knots[index], knots[index + j]
        weight = values / (right - left)
        values = np.zeros((len(x), j + 1))
        values[:, :-1] = (right - x[:, None]) * weight
        values[:, 1:] += (x[:, None] - left) * weight
    return values


@final
@dataclass(frozen=True, eq=False)
class CurveFit:
    """Interpolated curve: basis, poles (size, 3) mm, and the largest deviation in mm from the exact points between."""

    basis: Basis
    poles: Floats
    deviation: float


@final
@dataclass(frozen=True, eq=False)
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


def fit_curve(point: CurvePoints, start: float, stop: float, tolerance: float, degree: int = 5) -> CurveFit:
    """Curve through exact points, refined until it is within `tolerance` mm at six other parameters in each span.

    Raises NotConverged where MAX_SPANS spans are not enough: a kink inside the interval, which belongs at a knot.
    """
    spans = 2
    while True:
        kit = _kit(degree, spans)
        poles = kit.inverse @ point(_scaled(kit.nodes, start, stop))
        error = _largest(kit.probe @ poles - point(_scaled(kit.probes, start, stop)))
        if error <= tolerance:
            return CurveFit(Basis(degree, _scaled(kit.knots, start, stop)), poles, error)
        spans = _refined(spans, error, tolerance, degree, start, stop)


def fit_surface(
    point: SurfacePoints,
    u: tuple[float, float],
    v: tuple[float, float],
    tolerance: float,
    degree: tuple[int, int] = (5, 5),
    spans: tuple[int, int] = (2, 1),
) -> SurfaceFit:
    """Tensor-product surface through exact points, refined in u and v apart until within `tolerance` mm between them.

    spans: the fewest spans along u and v, so that neighbours can be given the same basis.
    Raises NotConverged where MAX_SPANS spans are not enough in one direction.
    """
    nu, nv = spans
    while True:
        ku, kv = _kit(degree[0], nu), _kit(degree[1], nv)
        au, av = _scaled(ku.nodes, *u), _scaled(kv.nodes, *v)
        bu, bv = _scaled(ku.probes, *u), _scaled(kv.probes, *v)
        rows = np.tensordot(ku.inverse, point(au, av), axes=(1, 0))
        along_u = _largest(np.tensordot(ku.probe, rows, axes=(1, 0)) - point(bu, av))
        poles = np.einsum("ij,njk->nik", kv.inverse, rows)
        along_v = _largest(np.einsum("ij,njk->nik", kv.probe @ kv.inverse, point(au, av)) - point(au, bv))
        if along_u > tolerance / 2:
            nu = _refined(nu, 2 * along_u, tolerance, degree[0], *u)
        if along_v > tolerance / 2:
            nv = _refined(nv, 2 * along_v, tolerance, degree[1], *v)
        if max(along_u, along_v) <= tolerance / 2:
            exact = point(_framed(bu, *u), _framed(bv, *v))
            fitted = np.einsum("ij,njk->nik", kv.probe, np.tensordot(ku.probe, poles, axes=(1, 0)))
            error = _largest(fitted - exact[1:-1, 1:-1])
            bases = Basis(degree[0], _scaled(ku.knots, *u)), Basis(degree[1], _scaled(kv.knots, *v))
            return SurfaceFit(*bases, poles, error, exact)


@final
@dataclass(frozen=True, eq=False)
class _Kit:
    """Everything about interpolation on [0, 1] that does not depend on the points."""

    knots: Floats
    nodes: Floats
    inverse: Floats
    probes: Floats
    probe: Floats


@lru_cache(maxsize=256)
def _kit(degree: int, spans: int) -> _Kit:
    ends = np.zeros(degree), np.ones(degree)
    breaks = np.linspace(0.0, 1.0, spans + 1)
    basis = Basis(degree, np.concatenate((ends[0], breaks, ends[1])))
    nodes = np.clip(basis.greville, 0.0, 1.0)
    nodes[0], nodes[-1] = 0.0, 1.0
    inverse = np.linalg.inv(basis.design(nodes))
    inverse[0], inverse[-1] = np.eye(basis.size)[0], np.eye(basis.size)[-1]
    probes = (breaks[:-1, None] + _PROBES / spans).ravel()
    return _Kit(basis.knots, nodes, inverse, probes, basis.design(probes))


def _scaled(unit: Floats, start: float, stop: float) -> Floats:
    """Unit parameters on [start, stop]; both ends are hit exactly."""
    return np.asarray(start * (1.0 - unit) + stop * unit)


def _framed(inner: Floats, start: float, stop: float) -> Floats:
    return np.concatenate([[start], inner, [stop]])


def _largest(difference: Floats) -> float:
    return float(np.sqrt(np.einsum("...i,...i->...", difference, difference).max()))


def _refined(spans: int, error: float, tolerance: float, degree: int, start: float, stop: float) -> int:
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
