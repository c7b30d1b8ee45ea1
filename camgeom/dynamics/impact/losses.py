"""Losses of an impact in SI units: damping with its restitution, and friction between cam and roller."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from camgeom.errors import Problem, ProfileError
from camgeom.maths import Floats

_SERIES_LIMIT = 0.02
"""below this damping factor the balance is summed as a series: the logarithms would cancel"""


def hybrid_factor(coefficient: float) -> float:
    """The damping factor chi, 1, of the hybrid contact model for a nominal restitution: 3/4 (1 - c^2) e^(2 (1 - c)).

    >>> round(hybrid_factor(0.9), 12)
    0.174049893038
    """
    return 0.75 * (1.0 - coefficient**2) * math.exp(2.0 * (1.0 - coefficient))


def _balance(factor: float, e: float) -> float:
    """Zero where a contact of damping factor chi leaves with e times its approach speed; falls with chi and with e.

    m v dv = -Fe (1 + chi v/v0) ddelta is separable, and the way in and the way out take the same elastic work:
    chi - ln(1 + chi) + chi e + ln(1 - chi e) = 0, whatever the elastic law. Here divided by chi^2.
    """
    if factor < _SERIES_LIMIT:
        terms = ((-factor) ** (k - 2) * (1.0 - (-e) ** k) / k for k in range(2, 14))
        return sum(terms)
    return (factor - math.log1p(factor) + factor * e + math.log1p(-factor * e)) / factor**2


def restitution_of(factor: float) -> float:
    """The restitution, 1, that a damping factor chi really gives.

    >>> round(restitution_of(hybrid_factor(0.9)), 6)
    0.895918
    """
    if factor == 0.0:
        return 1.0
    return _falling_root(lambda e: _balance(factor, e), 0.0, min(1.0, 1.0 / factor))


def exact_factor(restitution: float) -> float:
    """The damping factor chi, 1, that gives exactly this restitution (0 < restitution <= 1).

    >>> round(exact_factor(0.9), 8)
    0.16648195
    """
    if not 0.0 < restitution <= 1.0:
        raise ProfileError([Problem("restitution", "no damping factor gives it", restitution, "0 < e <= 1")])
    if restitution == 1.0:
        return 0.0
    return _falling_root(lambda chi: _balance(chi, restitution), 0.0, 1.0 / restitution)


def _falling_root(function: Callable[[float], float], low: float, high: float) -> float:
    """The root inside (low, high) of a function that is positive before it and negative after, to the last digit."""
    while True:
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            return middle
        if function(middle) > 0.0:
            low = middle
        else:
            high = middle


@final
@dataclass(frozen=True)
class ImpactDamping:
    """Damping proportional to the elastic force: F = Fe (1 + chi v/v0), v0 the approach speed of this contact [m/s].

    `coefficient` 0..1 is the nominal restitution; `exact` chooses chi so that the restitution is that number, otherwise
    the hybrid model's chi is used, whose true restitution differs (`restitution` tells it). `speed_floor` [m/s] bounds
    v0 from below (contact that begins at rest). The damping keeps the v0 of the onset for the whole contact, so ripples
    late in a long contact are damped less than a new impact of their speed would be: a property of the model.
    """

    coefficient: float = 0.9
    exact: bool = False
    speed_floor: float = 1e-3

    def __post_init__(self) -> None:
        problems = []
        if not 0.0 < self.coefficient <= 1.0:
            problems.append(Problem("restitution", "outside its range", self.coefficient, "0 < e <= 1"))
        if not self.speed_floor > 0.0:
            problems.append(Problem("speed_floor", "must be positive", self.speed_floor, "> 0 m/s"))
        if problems:
            raise ProfileError(problems)

    @cached_property
    def factor(self) -> float:
        """The damping factor chi, 1."""
        return exact_factor(self.coefficient) if self.exact else hybrid_factor(self.coefficient)

    @cached_property
    def restitution(self) -> float:
        """The restitution, 1, of a free impact under this damping."""
        return restitution_of(self.factor)


@final
@dataclass(frozen=True)
class RampedDamping:
    """Viscous damping that grows with the penetration: F = Fe + c ramp(delta/depth) v, ramp = x^2 (3 - 2x) up to 1.

    `coefficient` c [N s/m], `depth` [m] of full damping: the contact damper of general multibody programs.
    """

    coefficient: float
    depth: float

    def __post_init__(self) -> None:
        if not (self.coefficient >= 0.0 and self.depth > 0.0):
            found = (self.coefficient, self.depth)
            raise ProfileError([Problem("damping", "needs a coefficient >= 0 and a depth > 0", found)])

    def viscosity(self, delta: float) -> float:
        """Damping constant [N s/m] at a penetration [m]."""
        x = delta / self.depth
        if x >= 1.0:
            return self.coefficient
        return self.coefficient * x * x * (3.0 - 2.0 * x) if x > 0.0 else 0.0

    def viscosity_many(self, delta: Floats) -> Floats:
        """Damping constant [N s/m] at an array of penetrations [m]."""
        x = np.clip(delta / self.depth, 0.0, 1.0)
        viscosity: Floats = self.coefficient * x * x * (3.0 - 2.0 * x)
        return viscosity


Damping = ImpactDamping | RampedDamping


@final
@dataclass(frozen=True)
class Coulomb:
    """Dry friction without a jump: odd and continuously differentiable in the sliding speed [m/s].

    `static` at the speed `stick_speed`, `dynamic` from `slip_speed` on, cubic in between and through zero.
    """

    static: float = 0.15
    dynamic: float = 0.10
    stick_speed: float = 0.001
    slip_speed: float = 0.002

    def __post_init__(self) -> None:
        problems = []
        if not 0.0 <= self.dynamic <= self.static:
            problems.append(Problem("friction", "dynamic above static", self.dynamic, "0 <= dynamic <= static"))
        if not 0.0 < self.stick_speed < self.slip_speed:
            problems.append(Problem("slip_speed", "must exceed the stick speed", self.slip_speed, "> stick_speed > 0"))
        if problems:
            raise ProfileError(problems)

    def coefficient(self, speed: float) -> float:
        """The signed friction coefficient, 1, at a sliding speed [m/s]; the force is against the sign."""
        size = speed if speed >= 0.0 else -speed
        if size >= self.slip_speed:
            value = self.dynamic
        elif size >= self.stick_speed:
            x = (size - self.stick_speed) / (self.slip_speed - self.stick_speed)
            value = self.static + (self.dynamic - self.static) * x * x * (3.0 - 2.0 * x)
        else:
            x = (size + self.stick_speed) / (2.0 * self.stick_speed)
            value = self.static * (2.0 * x * x * (3.0 - 2.0 * x) - 1.0)
        return value if speed >= 0.0 else -value

    def coefficient_many(self, speed: Floats) -> Floats:
        """The signed friction coefficients, 1, at an array of sliding speeds [m/s]."""
        size = np.abs(speed)
        x = np.clip((size - self.stick_speed) / (self.slip_speed - self.stick_speed), 0.0, 1.0)
        sliding = self.static + (self.dynamic - self.static) * x * x * (3.0 - 2.0 * x)
        x = (np.minimum(size, self.stick_speed) + self.stick_speed) / (2.0 * self.stick_speed)
        sticking = self.static * (2.0 * x * x * (3.0 - 2.0 * x) - 1.0)
        value: Floats = np.copysign(np.where(size >= self.stick_speed, sliding, sticking), speed)
        return value
