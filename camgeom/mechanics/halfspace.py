"""Elastic half-space: deflection of cells under pressure, and the pressure of a contact.

Units mm, N, MPa; x across, y along; compliance (1 - nu1²)/E1 + (1 - nu2²)/E2, 1/MPa.

Deflection: that of a rectangle under constant pressure, Love's closed form (A. E. H. Love, 1929; K. L. Johnson, Contact
Mechanics, 1985, equation 3.25). Summed over even cells by FFT on a doubled grid, over strips of unequal length by FFT
across them and a matrix along. Pressure p >= 0, gap >= 0, p gap = 0 under a given load: the constrained conjugate
gradients of Polonsky and Keer (doi 10.1016/S0043-1648(99)00113-1), with areas as weights, preconditioned by the
spectrum of the surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi
from typing import Protocol, final

import numpy as np

from camgeom.errors import NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats

TOLERANCE = 1e-7
"""change of the pressure in a step, share of the load, at which it has settled"""
STEPS = 2000
SMOOTHED = 60
"""steps after which contacts whose cells keep coming and going are solved by what each cell does to itself alone"""
TINY = 1e-290
"""mm, in the place of 0 where its logarithm is taken 0 times"""
NOWHERE = 1e6
"""mm, the gap where there is no body"""


def corner(u: Floats | float, v: Floats) -> Floats:
    """u asinh(v / |u|) + v asinh(u / |v|), mm: Love's integral of 1/r from a corner; 0 on the axes' crossing."""
    r, w = np.maximum(np.abs(u), TINY), np.maximum(np.abs(v), TINY)
    far = np.sqrt(u * u + v * v)
    # As logarithms, of which numpy takes several at once.
    return np.asarray(np.copysign(r * np.log((w + far) / r) + w * np.log((r + far) / w), u * v))


class Influence(Protocol):
    """Deflection, mm, (nx, ny), of cells under a pressure, MPa.

    nearly  about the pressure under which they deflect by so much: the preconditioner
    stiff   pressure over deflection of cells that come to touch late, MPa/mm or as `nearly` counts
    alone   pressure over the deflection of a cell by its own pressure, up to a factor, (ny,) or one for all
    """

    stiff: float
    alone: Floats

    def __call__(self, pressure: Floats) -> Floats: ...
    def nearly(self, deflection: Floats) -> Floats: ...


@final
class Even:
    """Of even cells dx by dy mm: the spectrum of their influence on the doubled grid, (2 nx, ny + 1)."""

    def __init__(self, nx: int, ny: int, dx: float, dy: float, compliance: float) -> None:
        from scipy import fft

        self.shape = nx, ny
        across, along = (np.asarray((np.arange(n + 2) - 0.5) * d) for n, d in ((nx, dx), (ny, dy)))
        each = corner(across[:, None], along[None, :])
        quarter = each[1:, 1:] - each[1:, :-1] - each[:-1, 1:] + each[:-1, :-1]
        # Even both ways, so that its transform is that of cosines, and real.
        self.spectrum = compliance / pi * fft.dctn(quarter, type=1)[np.r_[0:nx + 1, nx - 1:0:-1], :]
        # A wave of pressure deflects the half-space by 2 compliance over its wave number.
        waves = np.hypot(*np.ix_(pi / (nx * dx) * np.arange(nx), pi / (ny * dy) * np.arange(ny)))
        waves[0, 0] = 0.5 * min(waves[1, 0], waves[0, 1])
        self.waves = waves / (2.0 * compliance)
        self.stiff = float(self.waves.mean())
        self.alone = np.ones(1)

    def __call__(self, pressure: Floats) -> Floats:
        from scipy import fft

        nx, ny = self.shape
        rows = fft.fft(fft.rfft(pressure, 2 * ny, axis=1), 2 * nx, axis=0, overwrite_x=True)
        rows *= self.spectrum
        back = fft.ifft(rows, axis=0, overwrite_x=True)[:nx]
        return np.asarray(fft.irfft(back, 2 * ny, axis=1)[:, :ny])

    def nearly(self, deflection: Floats) -> Floats:
        """From its waves, as if the window were all of the surface."""
        from scipy import fft

        return np.asarray(fft.idctn(self.waves * fft.dctn(deflection, type=2), type=2))


@final
class StripSpectrum:
    """Of cells dx mm across and strips (ny,) along, between edges (ny + 1,): the spectrum across, (nx + 1, ny, ny).

    The mean of both ways weighted by the strips' lengths, since a strip's middle stands for all of it: what i does to
    j is then what j does to i.
    """

    def __init__(
        self, nx: int, dx: float, edges: Floats, compliance: float, mirrors: Sequence[float] = (), share: float = 0.0
    ) -> None:
        """mirrors: places of planes, mm, whose images of the strips press with a share too."""
        from scipy import fft
        from scipy.linalg import eigh_tridiagonal

        self.nx = nx
        middles, lengths = 0.5 * (edges[1:] + edges[:-1]), np.diff(edges)
        away = edges - middles[:, None]
        images = [2.0 * plane - edges - middles[:, None] for plane in mirrors]
        each = np.empty((nx + 1, len(lengths), len(lengths)))
        before = np.zeros(1)
        for i, x in enumerate((dx * (np.arange(nx + 2) - 0.5)).tolist()):  # by rows, which stay in the cache
            now = np.diff(corner(x, away), axis=1)
            for image in images:
                now -= share * np.diff(corner(x, image), axis=1)
            if i:
                both = (now - before) * lengths[:, None]
                each[i - 1] = 0.5 * (both + both.T) / lengths[:, None]
            before = now
        cosines = compliance / pi * fft.dct(np.eye(nx + 1), type=1, axis=0)
        self.spectrum = (cosines @ each.reshape(nx + 1, -1)).reshape(each.shape)
        # Waves along: those of the second differences between strips, orthogonal by the strips' lengths.
        joint = 1.0 / np.diff(middles)
        ends = np.concatenate([[0.0], joint]) + np.concatenate([joint, [0.0]])
        square, shape = eigh_tridiagonal(ends / lengths, -joint / np.sqrt(lengths[1:] * lengths[:-1]))
        waves = np.sqrt(np.square(pi / (nx * dx) * np.arange(nx))[:, None] + np.maximum(square, 0.0))
        waves[0, 0] = 0.5 * min(waves[1, 0], waves[0, 1])
        self.waves = waves / (2.0 * compliance)
        self.stiff = float(self.waves.mean())
        self.alone = 1.0 / np.diagonal(each[0])
        self.alone /= self.alone.min()
        self.into, self.back = np.sqrt(lengths)[:, None] * shape, shape.T / np.sqrt(lengths)

    def __call__(self, pressure: Floats) -> Floats:
        from scipy import fft

        rows = fft.rfft(pressure, 2 * self.nx, axis=0)
        parts = np.matmul(self.spectrum, rows.view(np.float64).reshape(*rows.shape, 2))
        across = parts.reshape(rows.shape[0], -1).view(np.complex128)
        return np.asarray(fft.irfft(across, 2 * self.nx, axis=0)[: self.nx])

    def nearly(self, deflection: Floats) -> Floats:
        """From its waves, as if the window were all of the surface."""
        from scipy import fft

        rows = fft.dct(deflection, type=2, axis=0) @ self.into
        return np.asarray(fft.idct((self.waves * rows) @ self.back, type=2, axis=0))


@final
@immutable
class CellPressure:
    """Pressure of every cell, MPa, (nx, ny), approach, mm, and steps taken."""

    pressure: Floats
    approach: float
    steps: int


def pressed(
    gap: Floats,
    influence: Influence,
    area: Floats,
    load: float,
    guess: Floats | None = None,
    tolerance: float = TOLERANCE,
) -> CellPressure:
    """Pressure, MPa, of cells of these gaps (nx, ny), mm, and areas, mm² (broadcast), that carry the load, N.

    guess: a pressure to begin with. Raises NotConverged where it has not settled after STEPS.
    """
    weight = np.broadcast_to(area, gap.shape)
    body = gap < NOWHERE
    start = body * (np.ones_like(gap) if guess is None or not (guess * body).any() else guess)
    p = start * (load / _sum(start, weight))
    u, way, old = influence(p), np.zeros_like(p), 0.0
    for step in range(1, STEPS + 1):
        on = p > 0.0
        share = weight * on
        whole = float(share.sum())
        g = u + gap
        level = _sum(share, g) / whole
        g -= level
        plain = step > SMOOTHED
        lead = influence.alone * g * on if plain else influence.nearly(g * on)
        lead = (lead - _sum(share, lead) / whole) * on
        new = _sum(share, g * lead)
        way *= new / old if old > 0.0 else 0.0
        way += lead
        way *= on
        bent = influence(way)
        r = bent - _sum(share, bent) / whole
        down = _sum(share, r * way)
        if down <= 0.0:
            return CellPressure(p, level, step)
        pace = _sum(share, g * way) / down
        fresh = p - pace * way
        cut, late = fresh < 0.0, ~on & (g < 0.0)
        old = 0.0 if late.any() else new
        changed = old == 0.0 or bool(cut.any())
        fresh[cut] = 0.0
        fresh[late] = -pace * (influence.alone * g if plain else influence.stiff * g)[late]
        carried = _sum(weight, fresh)
        if not carried > 0.0:
            break
        scale = load / carried
        fresh *= scale
        moved = _sum(weight, np.abs(fresh - p))
        # What a step moves adds to the deflection, unless cells came or went.
        u = influence(fresh) if changed else scale * (u - pace * bent)
        p = fresh
        if moved < tolerance * load and not late.any():
            return CellPressure(p, level, step)
    raise NotConverged("the contact along the roller did not settle: check length, crown and tilt against the load")


def _sum(one: Floats, two: Floats) -> float:
    return float(np.einsum("ij,ij->", one, two))
