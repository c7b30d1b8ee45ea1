"""Residual vibration of an elastic follower after a rise, over the rise time in natural periods. No units.

Relative displacement q'' + 2 zeta w q' + w^2 q = -s'' over x = t/T in 0..1, w = 2 pi n with n = T/T_n. After the rise

    q(1) + q'-part = -(1/w_d) integral_0^1 s''(x) exp(-zeta w (1 - x)) exp(i w_d (1 - x)) dx

plus the same weight times each step of s' at a knot. Gauss quadrature between the knots of the law converges beyond
all powers, so the integral is exact to rounding. For the cycloidal law without damping |q| = |sin(pi n)|/(pi n |n^2 -
1|).
"""

from __future__ import annotations

from itertools import pairwise
from math import pi, sqrt
from typing import Protocol

import numpy as np
import numpy.typing as npt

from camgeom.dynamics.linear.method import Side
from camgeom.errors import Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import Floats, gauss_rule

BASE_POINTS = 24
"""Gauss points of a smooth piece before any oscillation is counted"""
MOST_PERIODS = 1e5
"""natural periods in a rise"""
PART = 4_000_000
"""numbers formed at once"""


class UnitLaw(Protocol):
    """A normalised motion law on 0 .. 1."""

    @property
    def knots(self) -> tuple[float, ...]: ...

    def jet(self, x: npt.NDArray[np.float64], order: int = 3, side: Side = "right") -> npt.NDArray[np.float64]: ...


@immutable
class ResidualSpectrum:
    """Residual vibration over ratio n = rise time / natural period (k,), as shares of the lift.

    amplitude (k,) of the displacement at the end of the rise; acceleration (k,) is the same times w^2, per (rise
    time)^2.
    """

    ratio: Floats
    amplitude: Floats
    acceleration: Floats


def residual_spectrum(law: UnitLaw, ratio: npt.ArrayLike, damping: float = 0.0) -> ResidualSpectrum:
    """Residual amplitude after the rise for ratios n (k,), with a damping ratio below 1.

    Raises ProfileError for ratios that are not positive or a damping outside 0 .. 1.
    """
    n = np.atleast_1d(np.asarray(ratio, dtype=float))
    problems = []
    if not (np.isfinite(n).all() and (n > 0.0).all() and (n <= MOST_PERIODS).all()):
        worst = float(n.max(initial=-np.inf)) if (n > 0.0).all() else float(n.min(initial=np.inf))
        problems.append(Problem("dynamics.ratio", "out of range", worst, f"above 0 to {MOST_PERIODS:g}"))
    if not 0.0 <= damping < 1.0:
        problems.append(Problem("dynamics.damping_ratio", "out of range", damping, "0 to 1, 1 excluded"))
    if problems:
        raise ProfileError(problems)
    w = 2.0 * pi * n
    total = np.zeros(len(n), dtype=complex)
    rate = -damping * w + 1j * w * sqrt(1.0 - damping**2)
    x, weight = _quadrature(law.knots, float(w.max()))
    bend = law.jet(x, 2)[2] * weight
    for low in range(0, len(n), max(1, PART // len(x))):
        cut = slice(low, low + max(1, PART // len(x)))
        total[cut] = np.exp(rate[cut, None] * (1.0 - x)) @ bend
    knots = np.asarray(law.knots)
    total += np.exp(rate[:, None] * (1.0 - knots)) @ _velocity_steps(law, knots)
    amplitude = np.abs(total) / (w * sqrt(1.0 - damping**2))
    return ResidualSpectrum(n, amplitude, amplitude * w * w)


def _velocity_steps(law: UnitLaw, knots: Floats) -> Floats:
    """Steps of s' at the knots (k,), rest before the first and after the last."""
    left, right = law.jet(knots, 1, "left")[1], law.jet(knots, 1, "right")[1]
    left[0], right[-1] = 0.0, 0.0
    step = right - left
    # rounding at the knots of a smooth law is no step
    step[np.abs(step) < 1e-12 * max(1.0, float(np.abs(left).max()))] = 0.0
    return np.asarray(step)


def _quadrature(knots: tuple[float, ...], w: float) -> tuple[Floats, Floats]:
    """Points and weights (p,) between the knots, fine enough for an oscillation exp(i w x)."""
    points, weights = [], []
    for low, high in pairwise(knots):
        # a panel turns through 8 rad at most: 24 points then leave less than rounding
        panels = max(1, int(np.ceil(w * (high - low) / 8.0)))
        edges = np.linspace(low, high, panels + 1)
        nodes, share = gauss_rule(BASE_POINTS)
        half = np.diff(edges)[:, None] / 2.0
        points.append((edges[:-1, None] + half * (nodes + 1.0)).ravel())
        weights.append((half * share).ravel())
    return np.concatenate(points), np.concatenate(weights)
