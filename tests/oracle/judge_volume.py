"""Volume of a drum with a groove cut by a radial cylindrical roller on a translating follower, with no envelope in it.

At each radius rho = sqrt(floor² + q²) the drum is a strip (angle, z). The roller's section there is the set of points
within its radius of the axis, cut off where the roller's flat end ends (|y| <= q). The groove at one angle reaches from
the least to the greatest z that any position of the roller covers: a maximum over the positions, searched for.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np


def groove_volume(
    lift: Callable[[np.ndarray], np.ndarray], radius: float, floor: float, roller: float, angles: int = 1440
) -> float:
    """Volume in mm³ of the groove between the floor radius and the drum's radius; lift(phi) in mm, any real phi."""
    phi = 2.0 * np.pi * np.arange(angles) / angles
    total = 0.0
    reach = np.sqrt(radius * radius - floor * floor)
    breaks = [0.0, roller, reach] if reach > roller else [0.0, reach]
    x, w = np.polynomial.legendre.leggauss(24)
    for low, high in zip(breaks[:-1], breaks[1:]):
        for q, weight in zip(low + 0.5 * (high - low) * (1.0 + x), 0.5 * (high - low) * w):
            widest = np.arcsin(min(q, roller) / roller)
            total += weight * q * float(_width(lift, phi, np.hypot(floor, q), roller, widest).sum())
    return total * 2.0 * np.pi / angles


def _width(lift: Callable, phi: np.ndarray, rho: float, roller: float, widest: float) -> np.ndarray:
    """Height in z of the groove at radius rho, (n,)."""
    psi = np.linspace(-widest, widest, 61)
    centre = lift(phi[:, None] + np.arcsin(roller * np.sin(psi) / rho))
    return _greatest(centre + roller * np.cos(psi)) + _greatest(roller * np.cos(psi) - centre)


def _greatest(values: np.ndarray) -> np.ndarray:
    """Largest value along the last axis, by the parabola through the largest sample and its neighbours."""
    top = np.argmax(values, axis=1)
    inner = np.clip(top, 1, values.shape[1] - 2)
    rows = np.arange(len(values))
    a, b, c = (values[rows, inner + k] for k in (-1, 0, 1))
    bend = a - 2.0 * b + c
    peak = b - np.where(bend < 0.0, (a - c) ** 2 / (8.0 * np.where(bend < 0.0, bend, -1.0)), 0.0)
    return np.where(top == inner, peak, values[rows, top])
