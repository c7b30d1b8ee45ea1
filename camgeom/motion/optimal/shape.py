"""The acceleration as a row of straight or level pieces, and how integrals of it against kernels answer to it.

A functional f(a) = integral k(x) a(x) dx is given by its values against the hats (or the spans), and its slope with
respect to the breaks follows from the same numbers: that is what lets the breaks move.
"""

from __future__ import annotations

from typing import TypeVar, final

import numpy as np
import numpy.typing as npt

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property

Complexes = npt.NDArray[np.complex128]
Number = TypeVar("Number", np.float64, np.complex128)


PARABOLAS = 4
"""through three points each, eight times as close: from a grid's step to a peak of the vibration"""


@final
@immutable
class Shape:
    """s'' on 0 <= x <= 1: values (K + 1,) at the breaks x (K + 1,), straight between; or (K,) levels of the spans."""

    x: Floats
    a: Floats

    @property
    def smooth(self) -> bool:
        """Whether the acceleration is straight between its breaks and continuous."""
        return len(self.a) == len(self.x)

    @cached_property
    def h(self) -> Floats:
        """Widths of the spans (K,)."""
        return np.diff(self.x)

    @cached_property
    def jerk(self) -> Floats:
        """The slope of the acceleration in each span (K,)."""
        return np.diff(self.a) / self.h if self.smooth else np.zeros(len(self.h))

    @cached_property
    def first(self) -> Floats:
        """The acceleration at the beginning of each span (K,)."""
        return self.a[:-1] if self.smooth else self.a

    def states(self, velocity: float) -> tuple[Floats, Floats]:
        """s and s' (K + 1,) at the breaks, from s = 0 and the velocity at the start."""
        h, a, j = self.h, self.first, self.jerk
        v = velocity + np.concatenate([[0.0], np.cumsum(h * (a + h * j / 2.0))])
        s = np.concatenate([[0.0], np.cumsum(h * (v[:-1] + h * (a / 2.0 + h * j / 6.0)))])
        return s, v

    def crossings(self) -> Floats:
        """Where the acceleration changes its sign inside a span: there the velocity is extreme."""
        if not self.smooth:
            return np.empty(0)
        low, high = self.a[:-1], self.a[1:]
        rounding = 1e-9 * float(np.abs(self.a).max())
        inside = (low * high < 0.0) & (np.minimum(np.abs(low), np.abs(high)) > rounding)
        return np.asarray((self.x[:-1] + self.h * low / np.where(inside, low - high, 1.0))[inside])

    def velocities(self, velocity: float) -> tuple[Floats, Floats]:
        """Places (n,) and values (n,) of the velocity: the breaks, and its extremes between them."""
        v = self.states(velocity)[1]
        inner = self.crossings()
        k = np.clip(np.searchsorted(self.x, inner, side="right") - 1, 0, len(self.h) - 1)
        u = inner - self.x[k]
        between = v[k] + u * (self.first[k] + u * self.jerk[k] / 2.0)
        return np.concatenate([self.x, inner]), np.concatenate([v, between])

    @cached_property
    def mean_square(self) -> float:
        """The integral of the acceleration's square."""
        if not self.smooth:
            return float(self.h @ self.a**2)
        low, high = self.a[:-1], self.a[1:]
        return float(self.h @ (low * low + low * high + high * high)) / 3.0


def parts(
    x: Floats, smooth: bool, sums: npt.NDArray[Number], tilted: npt.NDArray[Number]
) -> npt.NDArray[Number]:
    """Functionals against the pieces: of spans (q, 1, K), or of the hats' left and right halves (q, 2, K + 1).

    `sums` (q, K) is the integral of the kernel over each span, `tilted` that of the kernel times the share of the span.
    """
    if not smooth:
        return sums[:, None, :]
    out: npt.NDArray[Number] = np.zeros((len(sums), 2, len(x)), dtype=sums.dtype)
    out[:, 0, 1:] = tilted
    out[:, 1, :-1] = sums - tilted
    return out


def moment_parts(x: Floats, smooth: bool) -> Floats:
    """The kernels 1 and 1 - x."""
    h = np.diff(x)
    far = 1.0 - x[:-1]
    sums = np.array([h, h * (far - h / 2.0)])
    return np.asarray(parts(x, smooth, sums, np.array([h / 2.0, h * (far / 2.0 - h / 3.0)])))


def velocity_parts(x: Floats, smooth: bool, places: Floats) -> Floats:
    """The kernels that are 1 up to each place (q,) and 0 beyond: the velocity gained there."""
    h = np.diff(x)
    share = np.clip((places[:, None] - x[:-1]) / h, 0.0, 1.0)
    return np.asarray(parts(x, smooth, share * h, 0.5 * share * share * h))


def decay(n: Floats, damping: float) -> tuple[Complexes, Floats]:
    """The rate k (q,) and the damped frequency (q,) for which z(n) = 1/wd integral a(x) exp(-k (1 - x)) dx."""
    w = 2.0 * np.pi * n
    damped = w * np.sqrt(1.0 - damping * damping)
    return damping * w - 1j * damped, damped


def residual_parts(x: Floats, smooth: bool, n: Floats, damping: float) -> Complexes:
    """The kernels whose integrals are z(n), the vibration left behind as a share of the lift, complex.

    An oscillator at rest before the rise swings after it with the amplitude |z|, w = 2 pi n, wd = w sqrt(1 - zeta²).
    """
    k, damped = decay(n, damping)
    h = np.diff(x)
    wave = np.exp(-k[:, None] * (1.0 - x))
    rise = np.diff(wave, axis=1)
    sums = rise / k[:, None]
    tilted = wave[:, 1:] / k[:, None] - rise / (k * k)[:, None] / h
    # Where a span is short against the wave, the difference above has no digits left; its series has.
    phase = k[:, None] * h
    short = np.abs(phase) < 1e-3
    if short.any():
        middle = np.exp(-k[:, None] * (1.0 - 0.5 * (x[:-1] + x[1:]))) * h
        sums = np.where(short, middle * (1.0 + phase**2 / 24.0), sums)
        tilted = np.where(short, middle * (0.5 + phase / 12.0 + phase**2 / 48.0), tilted)
    return np.asarray(parts(x, smooth, sums / damped[:, None], tilted / damped[:, None]))


def values(shape: Shape, pieces: npt.NDArray[Number]) -> npt.NDArray[Number]:
    """The functionals (q,) of a shape."""
    return np.asarray(pieces.sum(axis=1) @ shape.a, dtype=pieces.dtype)


def slopes(shape: Shape, pieces: Floats, kernel: Floats) -> Floats:
    """How functionals answer to the inner breaks, (q, K - 1); `kernel` (q, K + 1) are its values at the breaks."""
    if not shape.smooth:
        return np.asarray((kernel[:, 1:-1]) * (shape.a[:-1] - shape.a[1:]))
    j = shape.jerk
    return np.asarray(-(j[:-1] * pieces[:, 0, 1:-1] + j[1:] * pieces[:, 1, 1:-1]))


def residuals(shape: Shape, n: Floats, damping: float) -> Complexes:
    """z(n), complex (q,)."""
    return np.asarray(values(shape, residual_parts(shape.x, shape.smooth, n, damping)))


def residual_peaks(shape: Shape, band: tuple[float, float], damping: float) -> tuple[Floats, Complexes]:
    """Every local peak of |z| over the band, its ends included: n (q,) and z (q,), refined to rounding.

    |z|² wd² is band-limited: it holds no wave shorter than 1 in n, so that a grid of 24 a unit misses no peak.
    """
    low, high = band
    if high <= low:
        n = np.array([low])
        return n, residuals(shape, n, damping)
    count = max(9, int(np.ceil(24.0 * (high - low))) + 1)
    grid = np.linspace(low, high, count)
    size = np.abs(residuals(shape, grid, damping))
    padded = np.concatenate([[-1.0], size, [-1.0]])
    n = grid[(padded[1:-1] >= padded[:-2]) & (padded[1:-1] > padded[2:])]
    step = grid[1] - grid[0]
    for _ in range(PARABOLAS):
        middle = np.clip(n, low + step, high - step)
        trial = middle + step * np.array([[-1.0], [0.0], [1.0]])
        before, at, after = (np.abs(residuals(shape, trial.ravel(), damping)) ** 2).reshape(trial.shape)
        bend = before - 2.0 * at + after
        top = 0.5 * (before - after) / np.where(bend < 0.0, bend, 1.0)
        n = middle + step * np.clip(np.where(bend < 0.0, top, np.sign(after - before)), -1.0, 1.0)
        step /= 8.0
    return n, residuals(shape, n, damping)
