"""How far an error of any direction moves the follower: directions beside the one that its parts' effects point to.

Lines of contact that come to bear or go make the motion another than a sine of the direction; what the parts do alone
then points beside the largest, by up to 2.4 % of it at shipped cams.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi
from typing import Self, final

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats
from camgeom.maths.extremum import bracketed_maximum
from camgeom.tolerance.seat import Stand, Walls

BESIDE = pi / 6.0
"""rad, on either side: a sine through three directions says where its largest is"""
CLOSER = BESIDE / 4.0
"""rad, a second time"""


@final
@dataclass(frozen=True, eq=False)
class Turned:
    """An error of any direction at cam angles (k,): its walls there, both parts at its size, (2, k, p), mm, and where
    the follower stands without."""

    walls: Walls
    parts: Floats
    base: Stand

    @classmethod
    def at(cls, walls: Walls, base: Stand, parts: Floats, rows: npt.NDArray[np.intp]) -> Self:
        """Those of walls and nominal stands of all angles at rows (k,): what no load presses there none presses here.
        """
        loaded = replace(walls, load=np.where(walls.load_side == 0.0, 0.0, walls.load))
        return cls(loaded.rows(rows), parts, Stand(base.low[rows], base.high[rows], base.play[rows]))

    def moved(self, turn: Floats) -> Floats:
        """Motion, mm or rad, in directions (k, q), rad, from the first part towards the second, (k, q)."""
        stand = self.walls.stand(np.cos(turn.T)[..., None] * self.parts[0] + np.sin(turn.T)[..., None] * self.parts[1])
        return np.asarray(np.maximum(stand.high - self.base.high, self.base.low - stand.low).T)

    def beside(self, start: Floats, by: float) -> tuple[Floats, Floats]:
        """The largest motion and its direction, (k,), of start (k,), those by, rad, beside it, and where a sine through
        these three is the largest."""
        turn = start[:, None] + np.array([-by, 0.0, by])
        three = self.moved(turn)
        before, middle, after = three.T
        bend = (middle - 0.5 * (before + after)) / (1.0 - np.cos(by))
        vertex = start + np.arctan2((after - before) / (2.0 * np.sin(by)), bend)
        turn, four = np.column_stack([turn, vertex]), np.column_stack([three, self.moved(vertex[:, None])])
        return _best(four, turn)

    def farther(self, first: Floats) -> tuple[Floats, Floats]:
        """A large motion and its direction, (k,), near first (k,) or its mirror image in the first part: where a part
        moves both ways alike it does not say which of both."""
        _, start = _best(self.moved(both := np.column_stack([first, -first])), both)
        return self.beside(start, BESIDE)

    def largest(self) -> Floats:
        """The largest motion of all directions, (k,)."""
        count = self.parts.shape[1]
        return bracketed_maximum(self.moved, np.zeros(count), np.full(count, 2.0 * pi))[0]


def _best(values: Floats, turn: Floats) -> tuple[Floats, Floats]:
    """The largest of values (k, q) and its direction of turn (k, q), (k,)."""
    rows, best = np.arange(len(values)), np.argmax(values, axis=1)
    return values[rows, best], turn[rows, best]
