"""Sag of the cells of a structured surface grid: how far their two triangles lie from the true surface.

The sag is measured on the true surface at the cell's middle and on its edges, and that of the quadratic patch through
those measurements, for the better of the two diagonals, is what is called its chord error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats
from camgeom.maths.surface import cross, dot

Counts = tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Cells:
    """Second-order sags of the cells of a grid, mm, each (n, k): along phi, mixed, and across (signed, along n)."""

    a: Floats
    b: Floats
    c: Floats

    def error(self) -> tuple[Floats, npt.NDArray[np.bool_]]:
        """Largest sag of the two triangles for the better diagonal, and which: True joins (i, j) to (i+1, j+1)."""
        a, b, c = self.a, self.b, self.c
        side, total, twice = np.maximum(np.abs(a), np.abs(c)), a + c, 2.0 * b
        rising = 0.125 * np.maximum(side, np.abs(total + twice))
        falling = 0.125 * np.maximum(side, np.abs(total - twice))
        # Only a patch bent to one side in every direction can sag most inside a triangle.
        bowl = np.nonzero(a * c > b * b)
        if len(bowl[0]):
            rising[bowl] = patch_sag(a[bowl], -b[bowl], c[bowl])
            falling[bowl] = patch_sag(a[bowl], b[bowl], c[bowl])
        return np.minimum(rising, falling), rising <= falling

    def split(self, counts: Counts) -> list[Cells]:
        """The cells of each of the bands side by side."""
        cuts = np.cumsum(counts)[:-1]
        parts = zip(*(np.split(x, cuts, axis=1) for x in (self.a, self.b, self.c)))
        return [Cells(a, b, c) for a, b, c in parts]

    @classmethod
    def joined(cls, parts: list[Cells]) -> Cells:
        """The cells of several bands side by side."""
        return cls(*(np.concatenate([getattr(part, k) for part in parts], axis=1) for k in "abc"))

    def spread(self, measured: npt.NDArray[np.int64], n: int) -> Cells:
        """The cells at all of n steps along phi from those at the measured ones, in between by straight lines.

        The sags of neighbours differ little, but which diagonal is better may change anywhere between two of them.
        """
        if len(measured) == n:
            return self
        place = np.interp(np.arange(n), measured, np.arange(len(measured)))
        low = np.minimum(place.astype(np.int64), len(measured) - 2)
        share = (place - low)[:, None]
        return Cells(*(x[low] + share * (x[low + 1] - x[low]) for x in (self.a, self.b, self.c)))

    def scaled(self, h: Floats, k: Floats) -> Cells:
        """The sags of cells h times as long in phi and k times as wide."""
        return Cells(self.a * h * h, self.b * h * k, self.c * k * k)


def patch_sag(a: Floats, b: Floats, c: Floats) -> Floats:
    """Largest |f - linear interpolant| of f = (a s² + 2 b s t + c t²) / 2 on the triangle (0,0) (1,0) (0,1).

    On the edges it is |a|/8, |c|/8 and |a + c - 2 b|/8; a stationary point inside the triangle counts too.
    """
    edge = np.maximum(np.maximum(np.abs(a), np.abs(c)), np.abs(a + c - 2.0 * b)) / 8.0
    det = a * c - b * b
    safe = np.where(det > 1e-12 * (np.abs(a * c) + b * b) + 1e-300, det, 1.0)
    s, t = c * (a - b) / (2.0 * safe), a * (c - b) / (2.0 * safe)
    inside = (safe == det) & (s > 0.0) & (t > 0.0) & (s + t < 1.0)
    return np.asarray(np.where(inside, np.maximum(edge, np.abs(a * s + c * t) / 4.0), edge))


def measure(start: Floats, stop: Floats, middle: Floats) -> Cells:
    """Sags of cells between two values of phi each.

    start, stop  (3, n, k + 1) exact points at the beginning and end of each cell along phi
    middle       (3, n, 2 k + 1) exact points at the middle phi of each cell, rows doubled
    """
    p00, p01, p10, p11 = start[:, :, :-1], start[:, :, 1:], stop[:, :, :-1], stop[:, :, 1:]
    d1, d2 = p11 - p00, p10 - p01
    n = cross(d1, d2)
    length = np.sqrt(dot(n, n))
    inverse = 1.0 / np.where(length > 0.0, length, 1.0)
    row = 0.5 * (start + stop) - middle[:, :, ::2]
    centre = 0.25 * (p00 + p01 + p10 + p11) - middle[:, :, 1::2]
    low, high = dot(n, row[:, :, :-1]), dot(n, row[:, :, 1:])
    a = 8.0 * np.where(np.abs(low) > np.abs(high), low, high)
    c = 8.0 * dot(n, centre) - 4.0 * (low + high)
    b = dot(n, p11 - p10 - p01 + p00)
    for x in (a, b, c):
        x *= inverse
    return Cells(a, b, c)
