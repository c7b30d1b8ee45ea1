"""What laws of the catalogue leave behind over a band, beside which the best law is seen."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camgeom.maths import Floats, gauss_rule
from camgeom.motion.law import LAWS, Law, make
from camgeom.motion.optimal.shape import decay


class Rival(NamedTuple):
    """A law of the catalogue at its defaults: peak values and the largest residual over a band."""

    name: str
    velocity: float
    acceleration: float
    jerk: float
    residual: float


def residual_of(law: Law, band: tuple[float, float], damping: float) -> float:
    """The largest residual, a share of the lift, of a law over a band of rise time / natural period.

    Its acceleration need not be polynomial: Gauss points, several a wave, and impulses where the velocity jumps.
    """
    n = np.linspace(*band, max(2, math.ceil(64.0 * (band[1] - band[0])) + 1))
    k, damped = decay(n, damping)
    nodes, weights = gauss_rule(16)
    x, a, w = [], [], []
    for low, high in zip(law.knots[:-1], law.knots[1:], strict=True):
        edges = np.linspace(low, high, 2 + math.ceil(2.0 * band[1] * (high - low)))
        middle, half = 0.5 * (edges[1:] + edges[:-1]), 0.5 * np.diff(edges)
        at = (middle[:, None] + half[:, None] * nodes).ravel()
        x.append(at)
        a.append(law.jet(at, 2)[2])
        w.append((half[:, None] * weights).ravel())
    places = np.array(law.knots)
    before = np.append(0.0, law.jet(places[1:], 1, "left")[1])
    after = np.append(law.jet(places[:-1], 1)[1], 0.0)
    at, pulse = np.concatenate([*x, places]), np.concatenate([*(p * q for p, q in zip(a, w)), after - before])
    return float((np.abs(np.exp(-np.outer(k, 1.0 - at)) @ pulse) / damped).max())


def rivals(band: tuple[float, float], damping: float) -> list[Rival]:
    """Every law of the catalogue that moves from rest to rest without a jump of velocity, least residual first."""
    found: list[Rival] = []
    for name, entry in LAWS.items():
        if name == "optimal" or entry.claims.order < 1:
            continue
        claims = entry.claims
        found.append(Rival(name, claims.vm, claims.am, claims.jm, residual_of(make(name), band, damping)))
    return sorted(found, key=lambda rival: rival.residual)


def front(points: Floats) -> list[int]:
    """The rows (n, 2) that no other row is better than in both columns, rising in the first."""
    kept, least = [], math.inf
    for i in np.lexsort((points[:, 1], points[:, 0])).tolist():
        if points[i, 1] < least:
            kept.append(i)
            least = points[i, 1]
    return kept
