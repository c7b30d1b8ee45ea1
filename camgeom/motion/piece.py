"""One formula on one interval: a power series and a few waves about an anchor. Laws and programs are rows of these."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import final

Wave = tuple[float, float, float]
"""(w, a, b): the term a (cos(w u) - 1) + b sin(w u), which is zero at the anchor."""


@final
@dataclass(frozen=True, slots=True)
class Piece:
    """f(x) on start <= x <= end: sum_k power[k] u^k + sum (a (cos(w u) - 1) + b sin(w u)), u = x - anchor.

    Every term but power[0] vanishes at the anchor, so the value there is exact; an anchor at the end of a motion keeps
    the last digits there. Every derivative and every integral of a piece is again a piece.
    """

    start: float
    end: float
    anchor: float
    power: tuple[float, ...]
    waves: tuple[Wave, ...] = ()
    kept: int = -1
    """derivatives up to this order continue the piece before by construction (a spline); -1 where nothing is known"""

    def value(self, x: float, order: int = 0) -> float:
        """The derivative of the given order at x (scalar; arrays are evaluated by `Table`)."""
        u = x - self.anchor
        total = 0.0
        for k in range(len(self.power) - 1, order - 1, -1):
            total = total * u + self.power[k] * math.perm(k, order)
        for w, a, b in self.waves:
            c, s = math.cos(w * u), math.sin(w * u)
            versine = -2.0 * math.sin(0.5 * w * u) ** 2
            quarter = (a * (c if order else versine) + b * s, b * c - a * s)[order % 2]
            total += w**order * (-1.0 if order % 4 >= 2 else 1.0) * quarter
        return total

    def scaled(self, factor: float, offset: float = 0.0) -> Piece:
        """offset + factor f."""
        power = (offset + factor * self.power[0], *(factor * c for c in self.power[1:]))
        return replace(self, power=power, waves=tuple((w, factor * a, factor * b) for w, a, b in self.waves))

    def mirrored(self) -> Piece:
        """1 - f(1 - x): the same motion run backwards from the other end."""
        power = tuple(c if k % 2 else -c for k, c in enumerate(self.power))
        return Piece(
            1.0 - self.end,
            1.0 - self.start,
            1.0 - self.anchor,
            (1.0 - self.power[0], *power[1:]),
            tuple((w, -a, b) for w, a, b in self.waves),
        )

    def about(self, anchor: float) -> Piece:
        """The same function written about another anchor (Taylor shift of the powers, rotation of the waves)."""
        shift = anchor - self.anchor
        power = [
            sum(self.power[k] * math.comb(k, r) * shift ** (k - r) for k in range(len(self.power) - 1, r - 1, -1))
            for r in range(len(self.power))
        ]
        waves: list[Wave] = []
        for w, a, b in self.waves:
            c, s = math.cos(w * shift), math.sin(w * shift)
            power[0] += -2.0 * a * math.sin(0.5 * w * shift) ** 2 + b * s
            waves.append((w, a * c + b * s, b * c - a * s))
        return replace(self, anchor=anchor, power=tuple(power), waves=tuple(waves))

    def between(self, start: float, end: float) -> Piece:
        """The same formula on another interval."""
        return replace(self, start=start, end=end)

    def integrated(self, value_at_start: float) -> Piece:
        """The antiderivative that takes the given value at `start`; exact, term by term."""
        slope = self.power[0] - sum(a for _, a, _ in self.waves)
        power = (0.0, slope, *(c / (k + 2) for k, c in enumerate(self.power[1:])))
        raw = Piece(self.start, self.end, self.anchor, power, tuple((w, -b / w, a / w) for w, a, b in self.waves))
        return replace(raw, power=(value_at_start - raw.value(self.start), *power[1:]))
