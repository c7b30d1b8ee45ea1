"""Laws in one formula: straight line, harmonics, polynomials of rest-to-rest motion, finite Fourier series."""

from __future__ import annotations

import math
from collections.abc import Sequence

from camgeom.motion.law import Claims, law
from camgeom.motion.piece import Piece

NORTON = "R. L. Norton, Cam Design and Manufacturing Handbook, 2nd ed., Industrial Press 2009"


def symmetric(power: Sequence[float], *waves: tuple[float, float, float]) -> list[Piece]:
    """The law whose first half is the given formula about x = 0 and whose second half is its point reflection."""
    first = Piece(0.0, 0.5, 0.0, tuple(power), waves)
    return [first, first.mirrored()]


@law("constant-velocity", source=NORTON, claims=Claims(1.0, math.inf, math.inf, math.inf, math.inf, 0, 0))
def constant_velocity() -> list[Piece]:
    """A straight line: for ramps between moving neighbours; against a dwell the velocity jumps."""
    return symmetric((0.0, 1.0))


@law(
    "simple-harmonic",
    source=NORTON,
    claims=Claims(math.pi / 2, math.pi**2 / 2, math.inf, math.pi**3 / 8, math.pi**2 / math.sqrt(8), 1, 1),
)
def simple_harmonic() -> list[Piece]:
    """Half a cosine: smooth inside, the acceleration jumps against a dwell."""
    return symmetric((0.0,), (math.pi, -0.5, 0.0))


@law(
    "cycloidal",
    source=NORTON,
    claims=Claims(2.0, 2 * math.pi, 4 * math.pi**2, 8.1620971, math.sqrt(2) * math.pi, 2, 2),
)
def cycloidal() -> list[Piece]:
    """A full sine of acceleration: gentle ends, high peak."""
    return symmetric((0.0, 1.0), (2 * math.pi, 0.0, -0.5 / math.pi))


@law("3-4-5", source=NORTON, claims=Claims(1.875, 10 / math.sqrt(3), 60.0, 6.69, 4.14, 2, 2))
def polynomial_345() -> list[Piece]:
    """The polynomial of fifth degree with zero end acceleration: all-round."""
    return symmetric((0.0, 0.0, 0.0, 10.0, -15.0, 6.0))


@law("4-5-6-7", source=NORTON, claims=Claims(2.1875, 7.51318840, 52.5, 10.0, 4.9, 3, 3))
def polynomial_4567() -> list[Piece]:
    """The polynomial of seventh degree with zero end jerk: quiet ends, higher peaks."""
    return symmetric((0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0))
