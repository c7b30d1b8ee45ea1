"""What is asked of a best law, normalised: what is least, what is limited, how it begins and ends."""

from __future__ import annotations

import math
from typing import Literal, final

from camgeom.immutable import immutable

Aim = Literal["peak-acceleration", "jerk", "rms-acceleration", "residual"]
AIMS: tuple[Aim, ...] = ("peak-acceleration", "jerk", "rms-acceleration", "residual")
LIMITS = ("velocity", "acceleration", "jerk", "residual")
ALL = "all limits"
"""the aim of a proof: the least factor on every limit that some law keeps"""
EVEN = 1.0005
"""a limit of the velocity, the mean being 1, below which ramps are too short for the programmes' digits"""


@final
@immutable(eq=True)
class Wish:
    """A requirement for unit lift over unit travel, dimensionless; a limit that is not given is inf.

    velocity, acceleration, jerk   limits of |s'|, |s''|, |s'''|; with `monotone` the velocity never turns back
    residual   limit of the vibration left behind, a share of the lift, over `band`: rise time / natural period
    damping    share of critical damping of the oscillator
    start, end   velocity and acceleration there; an acceleration of None is free
    among      how many such laws are wanted, which have what a search may cost in common
    """

    aim: Aim = "jerk"
    velocity: float = math.inf
    acceleration: float = math.inf
    jerk: float = math.inf
    residual: float = math.inf
    monotone: bool = False
    band: tuple[float, float] | None = None
    damping: float = 0.0
    start: tuple[float, float | None] = (0.0, 0.0)
    end: tuple[float, float | None] = (0.0, 0.0)
    among: int = 1

    @property
    def smooth(self) -> bool:
        """Whether the acceleration is continuous inside: the jerk is limited or least, or the mean square is."""
        return math.isfinite(self.jerk) or self.aim in ("jerk", "rms-acceleration")

    @property
    def given(self) -> tuple[str, ...]:
        """The quantities that have a limit."""
        return tuple(name for name in LIMITS if math.isfinite(getattr(self, name)))

    @property
    def moments(self) -> tuple[float, float]:
        """What the integrals of s'' and of (1 - x) s'' must be, so that the law ends where and as it should."""
        return self.end[0] - self.start[0], 1.0 - self.start[0]

    @property
    def _lacks(self) -> tuple[float, ...]:
        """How far each end is below the limit of the velocity, of ends that are slower than the mean."""
        return tuple(self.velocity - v for v, _ in (self.start, self.end) if v < 1.0)

    @property
    def longest_ramp(self) -> float:
        """Share of the travel that a straight ramp from the slower end can take, inf where the velocity bounds none.

        The mean velocity is 1: a ramp of share r from u up to the limit V takes r (V - u) / 2 of the V - 1 there are.
        """
        if not 1.0 < self.velocity < math.inf or not self._lacks:
            return math.inf
        return 2.0 * (self.velocity - 1.0) / max(self._lacks)

    @property
    def steepest(self) -> float:
        """The acceleration that every law reaches: ramps of it from both ends give away the sum of (V - u)² / (2 A)."""
        return sum(lack**2 for lack in self._lacks) / (2.0 * (self.velocity - 1.0))

    @property
    def nearly_even(self) -> bool:
        """Whether a limit of the velocity leaves ramps that are shorter than those that can be solved."""
        return self.longest_ramp < 2.0 * (1.0 - 1.0 / EVEN) * (1.0 - 1e-9)


@final
@immutable(eq=True)
class Bound:
    """A limit that may hang on the unknown least value t: const + slope t."""

    const: float = math.inf
    slope: float = 0.0

    @property
    def asked(self) -> bool:
        """Whether there is a limit at all."""
        return math.isfinite(self.const)

    def at(self, t: float) -> float:
        """The limit where the least value is t."""
        return self.const + self.slope * t


@final
@immutable(eq=True)
class Task:
    """A programme: minimise t under limits that hang on it."""

    wish: Wish
    velocity: Bound
    acceleration: Bound
    jerk: Bound
    residual: Bound
    mean: bool = False
    """whether t is the root mean square of the acceleration"""
    proof: bool = False
    """whether t is the factor on all limits, of which it is asked whether it is above 1"""
    most: float = math.inf
    """a value beyond which none is sought"""

    @classmethod
    def of(cls, wish: Wish, aim: str | None = None) -> Task:
        """The task of a wish; with another aim that quantity, or the factor on all limits, is least instead."""
        aim = aim or wish.aim
        quantity = "acceleration" if aim == "peak-acceleration" else aim
        bounds = []
        for name in LIMITS:
            limit = getattr(wish, name)
            if aim == ALL:
                bounds.append(Bound(0.0, limit) if math.isfinite(limit) else Bound())
            else:
                bounds.append(Bound(0.0, 1.0) if name == quantity else Bound(limit))
        velocity, acceleration, jerk, residual = bounds
        return cls(wish, velocity, acceleration, jerk, residual, mean=aim == "rms-acceleration", proof=aim == ALL)

    @property
    def smooth(self) -> bool:
        """Whether the acceleration is piecewise linear and continuous, else piecewise constant."""
        return self.jerk.asked or self.mean
