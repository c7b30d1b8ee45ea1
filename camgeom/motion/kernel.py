"""The arithmetic of jets: power series by repeated Horner, waves by half angles, one piece or many columns at once."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats
from camgeom.motion.piece import Piece, Wave

Indices = npt.NDArray[np.intp]
Row = Floats | float


class Block(NamedTuple):
    """Pieces of one shape (degree, number of waves) as columns: power (degree + 1, m); w, a, b (waves, m)."""

    power: Floats
    w: Floats
    a: Floats
    b: Floats

    def fill(self, out: Floats, column: Indices, u: Floats) -> None:
        """Write the jets at the points u (n,) of the pieces `column` (n,) into out (order + 1, n)."""
        waves = zip(self.w, self.a, self.b, strict=True)
        fill(out, (row[column] for row in self.power[::-1]), (tuple(row[column] for row in wave) for wave in waves), u)

    def bound(self, reach: Floats, order: int) -> Floats:
        """Upper bounds (order + 1, m) of |derivative| where |u| <= reach (m,): the scale that rounding is judged by."""
        out = np.zeros((order + 1, len(reach)))
        for r in range(order + 1):
            for k in range(len(self.power) - 1, r - 1, -1):
                out[r] *= reach
                out[r] += math.perm(k, r) * np.abs(self.power[k])
            for w, a, b in zip(self.w, self.a, self.b, strict=True):
                out[r] += (np.abs(a) + np.abs(b)) * w**r
        return out


def fill(out: Floats, power: Iterable[Row], waves: Iterable[tuple[Row, Row, Row]], u: Floats) -> None:
    """Write the jet at u (n,) into out (order + 1, n); `power` from the highest down, rows are (n,) or numbers."""
    top = 0
    # Repeated Horner: afterwards out[r] is the r-th derivative divided by r!.
    for step, c in enumerate(power):
        if step == 0:
            out[0] = c
            out[1:] = 0.0
            continue
        top = min(step, len(out) - 1)
        for r in range(top, 0, -1):
            if r < step:
                out[r] *= u
            out[r] += out[r - 1]
        out[0] *= u
        out[0] += c
    for r in range(2, top + 1):
        out[r] *= math.factorial(r)
    for w, a, b in waves:
        _add_wave(out, w, a, b, u)


def _add_wave(out: Floats, w: Row, a: Row, b: Row, u: Floats) -> None:
    """Add the jet of a (cos(w u) - 1) + b sin(w u); half angles keep the digits of cos - 1 near the anchor."""
    half = u * (0.5 * w)
    sine = np.sin(half)
    versine = sine * sine
    versine *= -2.0
    np.cos(half, out=half)
    sine *= half
    sine *= 2.0
    out[0] += _mix(a, versine, b, sine)
    if len(out) == 1:
        return
    versine += 1.0
    terms = _mix(a, versine, b, sine), _mix(b, versine, -a, sine)
    factor: Row = w
    for r in range(1, len(out)):
        out[r] += (-factor if r % 4 >= 2 else factor) * terms[r % 2]
        factor = factor * w


def _mix(a: Row, x: Floats, b: Row, y: Floats) -> Floats:
    """a x + b y; most waves are a pure sine or cosine, and half the work is saved there."""
    if isinstance(a, float) and a == 0.0:
        return b * y
    if isinstance(b, float) and b == 0.0:
        return a * x
    return a * x + b * y


def stretched(piece: Piece, rate: float) -> tuple[tuple[float, ...], tuple[Wave, ...]]:
    """The powers and waves of a piece for an argument that runs 1/rate times as long."""
    if rate == 1.0:
        return piece.power, piece.waves
    power = tuple([c * rate**k for k, c in enumerate(piece.power)])
    return power, tuple([(w * rate, a, b) for w, a, b in piece.waves])
