"""Differential geometry of a parametrised surface from its forms. Component-major vectors: (3, ...)."""

from __future__ import annotations

import numpy as np

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property

NEXT, LAST = np.array([1, 2, 0]), np.array([2, 0, 1])
FEW = 10_000
"""numbers that cost less to move than what is called to work on them component by component"""


def dot(a: Floats, b: Floats) -> Floats:
    """Scalar product of component-major vectors, broadcast over the trailing axes."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def cross(a: Floats, b: Floats) -> Floats:
    """Vector product of component-major vectors, broadcast over the trailing axes."""
    if a.ndim == b.ndim and a.size + b.size < FEW:
        few: Floats = a.take(NEXT, 0) * b.take(LAST, 0)
        few -= a.take(LAST, 0) * b.take(NEXT, 0)
        return few
    out = np.empty((3, *np.broadcast_shapes(a.shape[1:], b.shape[1:])))
    for k, (i, j) in enumerate(((1, 2), (2, 0), (0, 1))):
        np.multiply(a[i], b[j], out=out[k])
        out[k] -= a[j] * b[i]
    return out


@immutable
class Forms:
    """First form E, F, G and second form L, M, N of a surface with unit normal n (second form -dn.dx)."""

    E: Floats
    F: Floats
    G: Floats
    L: Floats
    M: Floats
    N: Floats

    @cached_property
    def determinant(self) -> Floats:
        """E G - F², squared area element."""
        return np.asarray(self.E * self.G - self.F**2)

    @property
    def _area(self) -> Floats:
        """The determinant kept from zero: where the surface is singular curvatures come out very large, not infinite.

        E G - F² is known to a rounding of E G and no better.
        """
        return np.asarray(np.maximum(self.determinant, np.maximum(1e-24 * self.E * self.G, 1e-140)))

    def gauss(self) -> Floats:
        """K = k1 k2, 1/mm²."""
        return np.asarray((self.L * self.N - self.M**2) / self._area)

    def principal(self) -> tuple[Floats, Floats]:
        """Principal curvatures, larger first, 1/mm."""
        area = self._area
        half = (0.5 * (self.E * self.N + self.G * self.L) - self.F * self.M) / area
        root = np.sqrt(np.maximum(half * half - (self.L * self.N - self.M * self.M) / area, 0.0))
        return half + root, half - root
