"""A force on the follower over the cam angle, as cubics on cells of one turn: a value in half a microsecond (SI).

Cells never straddle a knot, so a force that jumps or kinks there is held exactly on both sides; the solver restarts
where it jumps.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import ceil, radians
from typing import final

import numpy as np

from camgeom.dynamics.impact.lift import TURN
from camgeom.maths import Floats

WIDEST = radians(1.0)
"""widest cell; the cubic is then good to 1e-8 of a force that waves ten times a turn"""
INSET = 1e-9
"""share of a cell by which its end points lie inside: a jump at a knot belongs to one side"""
_SHARES = np.array([INSET, 1.0 / 3.0, 2.0 / 3.0, 1.0 - INSET])
_FIT = np.linalg.inv(np.vander(_SHARES, increasing=True))
JUMP = 1e-6
"""step over the largest value that counts as a jump"""


@final
@dataclass(frozen=True)
class ForceTable:
    """Force [N or N m] against larger q: cells begin at `starts` [rad], from 0; cubics in the share of a cell."""

    starts: tuple[float, ...]
    cubics: tuple[tuple[float, float, float, float], ...]

    @classmethod
    def of(cls, force: Callable[[Floats], Floats], knots: Sequence[float]) -> ForceTable:
        """The table of a force over cam angles [rad] in (0, 2 pi); knots: where it may jump or kink."""
        ends = np.unique(np.concatenate([[0.0, TURN], np.asarray(knots, dtype=float)]))
        ends = ends[(ends >= 0.0) & (ends <= TURN)]
        ends = ends[np.concatenate([np.diff(ends) > 1e-12 * TURN, [True]])]
        parts = [np.linspace(a, b, ceil((b - a) / WIDEST) + 1)[:-1] for a, b in zip(ends[:-1], ends[1:], strict=True)]
        starts = np.concatenate(parts)
        width = np.diff(np.append(starts, TURN))
        values = force((starts[:, None] + width[:, None] * _SHARES).ravel()).reshape(-1, 4)
        rows = values @ _FIT.T
        return cls(tuple(map(float, starts)), tuple((float(r[0]), float(r[1]), float(r[2]), float(r[3])) for r in rows))

    @cached_property
    def _arrays(self) -> tuple[Floats, Floats, Floats]:
        starts = np.array(self.starts)
        return starts, np.diff(np.append(starts, TURN)), np.array(self.cubics)

    @cached_property
    def largest(self) -> float:
        """Largest magnitude [N or N m] at the ends of the cells."""
        _, _, c = self._arrays
        return float(max(np.abs(c[:, 0]).max(), np.abs(c.sum(axis=1)).max()))

    @cached_property
    def jumps(self) -> tuple[float, ...]:
        """Cam angles [rad] in (0, 2 pi) at which the force jumps."""
        starts, _, c = self._arrays
        steps = np.abs(c[1:, 0] - c[:-1].sum(axis=1))
        return tuple(float(a) for a in starts[1:][steps > JUMP * self.largest])

    def within(self, start: float, end: float) -> Callable[[float], float]:
        """A plain function of the angle [rad] past `start`, from the cells between two angles [rad] alone."""
        tiny = 1e-12 * TURN
        first = max(bisect_right(self.starts, start + tiny) - 1, 0)
        last = max(bisect_right(self.starts, end - tiny), first + 1)
        starts = [s - start for s in self.starts[first:last]]
        ends = [*self.starts, TURN][first + 1 : last + 1]
        cells = [
            (s, 1.0 / (e - start - s), *cubic)
            for s, e, cubic in zip(starts, ends, self.cubics[first:last], strict=True)
        ]
        inner = starts[1:]

        def force(x: float) -> float:
            s, per, a, b, c, d = cells[bisect_right(inner, x)]
            u = (x - s) * per
            return a + u * (b + u * (c + u * d))

        return force

    def many(self, angle: Floats, start: Floats, end: Floats) -> Floats:
        """Force [N or N m] at cam angles [rad], each from the cells between its own start and end [rad]."""
        starts, width, cubics = self._arrays
        tiny = 1e-12 * TURN
        low = np.searchsorted(starts, start + tiny, side="right") - 1
        high = np.searchsorted(starts, end - tiny, side="right") - 1
        cell = np.clip(np.searchsorted(starts, angle, side="right") - 1, low, np.maximum(high, low))
        u = (angle - starts[cell]) / width[cell]
        a, b, c, d = cubics[cell].T
        return np.asarray(a + u * (b + u * (c + u * d)))
