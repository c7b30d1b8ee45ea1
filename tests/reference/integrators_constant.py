"""A linear system with constant matrices, driven over the cam angle: the lateral vibrations and the textbook
oscillator.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from camgeom.dynamics.linear.method import Coefficients, Correction, Side
from camgeom.maths import Floats


@dataclass(frozen=True, eq=False)
class ConstantSystem:
    """A linear system with constant matrices: mass M, damping C, stiffness K (m, m) and a force f(t), in SI and per
    second.

    rate (b,) rad/s turns the time into the cam angle: D = M^-1 C/rate, S = M^-1 K/rate^2. force maps cam angles (.,
    n) and a side to (., n, m), in newton or newton metres; None is no force.
    """

    mass: Floats
    damping: Floats
    stiffness: Floats
    rate: Floats
    force: ForceLaw | None = None
    inverse_mass: Floats = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "inverse_mass", np.linalg.inv(self.mass))

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return int(self.mass.shape[0])

    @property
    def batch(self) -> int:
        """Number of speeds."""
        return int(self.rate.size)

    @property
    def linear(self) -> bool:
        """Always."""
        return True

    def correction(self, theta: Floats, side: Side = "right") -> Correction:
        """Zero (b, n, m)."""
        return lambda position, rate: np.zeros_like(position)

    def coefficients(self, theta: Floats, side: Side = "right") -> Coefficients:
        """D, S, F at cam angles theta (1 or b, n), see `System`."""
        rate = np.reshape(self.rate, (-1, 1, 1, 1))
        damping = self.inverse_mass @ self.damping / rate
        stiffness = self.inverse_mass @ self.stiffness / rate**2
        force = np.zeros((*np.atleast_2d(theta).shape, self.size))
        if self.force is not None:
            force = self.force(theta, side) @ self.inverse_mass.T
        return Coefficients(damping, stiffness, force / rate[:, :, 0] ** 2)


class ForceLaw(Protocol):
    """A force over the cam angle."""

    def __call__(self, theta: Floats, side: Side) -> Floats:
        """Force (., n, m) at cam angles theta (., n)."""
        ...
