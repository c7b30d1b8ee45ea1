"""B-spline basis functions on clamped knots. Plain numpy."""

from __future__ import annotations

from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.frozen import cached_property

Ints = npt.NDArray[np.intp]


def clamped(inner: Floats, degree: int) -> Floats:
    """The knot vector on 0 .. 1 with simple inner knots and both ends repeated degree + 1 times."""
    return np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])


@final
@immutable
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
        return distinct(self.knots)

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

    def slopes(self, x: Floats) -> tuple[Ints, Floats]:
        """As `local`, values and first derivatives together: (n,) and (n, 2, degree + 1)."""
        span = np.clip(np.searchsorted(self.knots, x, side="right") - 1, self.degree, self.size - 1)
        lower = _derivatives(self.degree - 1, self.knots, span, x, 0)
        index = span[:, None] + np.arange(1 - self.degree, 1)
        left, right = self.knots[index], self.knots[index + self.degree]
        weight = lower / (right - left)
        both = np.zeros((len(x), 2, self.degree + 1))
        both[:, 0, :-1] = (right - x[:, None]) * weight
        both[:, 0, 1:] += (x[:, None] - left) * weight
        both[:, 1, :-1] = -self.degree * weight
        both[:, 1, 1:] += self.degree * weight
        return span - self.degree, both

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
