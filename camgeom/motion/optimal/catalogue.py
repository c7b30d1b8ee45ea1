"""What laws of the catalogue leave behind over a band, beside which the best law is seen."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camgeom.maths import gauss_rule
from camgeom.motion.catalogue import LAWS, make
from camgeom.motion.law import Law
from camgeom.motion.optimal.shape import decay
from camgeom.motion.optimal.wish import Wish


class Rival(NamedTuple):
    """A law of the catalogue at its defaults: peak values and the largest residual over a band."""

    name: str
    velocity: float
    acceleration: float
    jerk: float
    residual: float

    def keeps(self, wish: Wish) -> bool:
        """Whether the law keeps what a wish says of velocity and jerk, and of jumps of the acceleration."""
        return self.velocity <= wish.velocity * TRUE and self.jerk <= (wish.jerk if wish.smooth else math.inf) * TRUE


TRUE = 1.0 + 1e-4
"""limits are often copied from a table's digits"""


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
    told: set[object] = set()
    for name, entry in LAWS.items():
        claims = entry.claims
        # Splines between rest and rest are the polynomial of their order: one law, told once.
        if name == "optimal" or claims.order < 1 or claims in told:
            continue
        told.add(claims)
        found.append(Rival(name, claims.vm, claims.am, claims.jm, residual_of(make(name), band, damping)))
    return sorted(found, key=lambda rival: rival.residual)
