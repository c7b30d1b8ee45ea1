"""Rainflow counting of a measured history (ASTM E1049-85, section 5.4.4)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from camgeom.immutable import immutable
from camgeom.maths import Floats


@final
@immutable
class Cycles:
    """Counted cycles: range and mean in the unit of the history, and count, 1 or 0.5 (what was not closed); (n,) each.
    """

    range: Floats
    mean: Floats
    count: Floats


def reversals(history: ArrayLike) -> list[float]:
    """The turning points of a history with its two ends, equal neighbours taken as one."""
    values = np.asarray(history, dtype=np.float64)
    kept = values[np.concatenate([[True], np.diff(values) != 0.0])]
    slope = np.sign(np.diff(kept))
    turning = np.flatnonzero(slope[1:] != slope[:-1]) + 1
    return [float(x) for x in kept[np.concatenate([[0], turning, [len(kept) - 1]])]] if len(kept) > 1 else []


def rainflow(history: ArrayLike) -> Cycles:
    """The cycles of a history. Raises ValueError where it never changes, so that it has none.

    X is the range of the newest two turning points, Y the one before. Where X >= Y, Y is a cycle, and its two points
    are taken out; if it holds the history's first point it is half a cycle, and that point alone goes. What is left at
    the end are half cycles.
    """
    open_: list[float] = []
    counted: list[tuple[float, float, float]] = []
    for point in reversals(history):
        open_.append(point)
        while len(open_) >= 3 and abs(open_[-1] - open_[-2]) >= abs(open_[-2] - open_[-3]):
            if len(open_) == 3:
                counted.append(_cycle(open_[:2], 0.5))
                del open_[0]
            else:
                counted.append(_cycle(open_[-3:-1], 1.0))
                del open_[-3:-1]
    counted += [_cycle(open_[k : k + 2], 0.5) for k in range(len(open_) - 1)]
    if not counted:
        raise ValueError("a history that never changes has no cycles")
    found = np.array(counted)
    return Cycles(found[:, 0], found[:, 1], found[:, 2])


def _cycle(ends: Sequence[float], count: float) -> tuple[float, float, float]:
    return abs(ends[1] - ends[0]), 0.5 * (ends[0] + ends[1]), count
