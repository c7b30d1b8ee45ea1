"""Blocks of a path: cam angles so spaced that straight interpolation between blocks stays within a tolerance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from camgeom.errors import NotConverged
from camgeom.maths import Floats

PROBES = 16
"""intervals in which every piece between knots is measured first"""
AIM = 0.9
"""share of the tolerance that the first placing aims at"""
PASSES = 12
SHARES = (0.25, 0.5, 0.75)
"""where along a block the chord is measured"""
NARROWEST = 1e-9
"""rad; blocks are not cut finer than this"""


@dataclass(frozen=True, eq=False)
class Chords:
    """What is interpolated, and what counts.

    curve    phi (n,) -> coordinates (c, n) that a machine interpolates in straight lines
    locate   coordinates (c, n) -> points of the tool (k, 3, n), mm, whose way counts
    """

    curve: Callable[[Floats], Floats]
    locate: Callable[[Floats], Floats]

    def error(self, phi: Floats) -> Floats:
        """Largest distance (n - 1,), mm, of each chord from the true way, across it."""
        ends = self.curve(phi)
        points = self.locate(ends)
        chord = points[:, :, 1:] - points[:, :, :-1]
        length = np.sqrt((chord**2).sum(axis=1, keepdims=True))
        along = chord / np.where(length > 0.0, length, 1.0)
        worst = np.zeros(len(phi) - 1)
        for share in SHARES:
            mixed = (1.0 - share) * ends[:, :-1] + share * ends[:, 1:]
            off = self.locate(mixed) - self.locate(self.curve((1.0 - share) * phi[:-1] + share * phi[1:]))
            across = off - (off * along).sum(axis=1, keepdims=True) * along
            worst = np.maximum(worst, np.sqrt((across**2).sum(axis=1)).max(axis=0))
        return worst


def equal_error(chords: Chords, knots: Floats, tolerance: float, most: int) -> tuple[Floats, float]:
    """Cam angles of blocks, and the largest chord error measured between them, mm.

    knots  (k,) rad, with both ends; every one becomes a block's end
    most   blocks; NotConverged where more are needed, before they are made
    """
    phi = _first(chords, knots, tolerance, most)
    for _ in range(PASSES):
        error = chords.error(phi)
        wide = error > tolerance
        if not np.any(wide):
            return phi, float(error.max(initial=0.0))
        parts = np.where(wide, np.ceil(np.sqrt(error / (AIM * tolerance))), 1).astype(np.int64)
        parts = np.where((np.diff(phi) < NARROWEST) | (parts < 1), 1, np.where(wide, np.maximum(parts, 2), 1))
        _refuse(int(parts.sum()), most, tolerance)
        if np.all(parts == 1):
            break
        phi = divided(phi, parts)
    at = float(np.degrees(phi[int(np.argmax(error))]))
    raise NotConverged(
        f"the tool's path bends too sharply at cam angle {at:.6g} deg: its chord error stays at {error.max():.3g} mm, "
        f"above cutter.tolerance {tolerance:g} mm; smooth the motion there, or ask for a coarser tolerance"
    )


def estimate(chords: Chords, knots: Floats, tolerance: float) -> int:
    """About how many blocks a tolerance takes."""
    return int(_density(chords, knots, tolerance)[1][-1]) + len(knots)


def _first(chords: Chords, knots: Floats, tolerance: float, most: int) -> Floats:
    """Blocks placed by the square root of the error of a coarse division."""
    coarse, total = _density(chords, knots, tolerance)
    _refuse(int(total[-1]), most, tolerance)
    marks = np.interp(knots, coarse, total)
    pieces = [knots[:1]]
    for low, high, begin, end in zip(marks[:-1], marks[1:], knots[:-1], knots[1:]):
        count = max(1, int(np.ceil(high - low)))
        piece = np.interp(np.linspace(low, high, count + 1), total, coarse)[1:]
        piece[-1] = end
        pieces.append(np.clip(piece, begin, end))
    return np.unique(np.concatenate(pieces))


def _density(chords: Chords, knots: Floats, tolerance: float) -> tuple[Floats, Floats]:
    """Coarse cam angles, and the number of blocks needed from the first of them up to each."""
    coarse = divided(knots, np.full(len(knots) - 1, PROBES))
    need = np.sqrt(chords.error(coarse) / (AIM * tolerance))
    # An interval beside one that bends more sharply is cut as if it bent as much at that end.
    near = np.maximum(need, 0.5 * (need + np.maximum(np.r_[need[1:], 0.0], np.r_[0.0, need[:-1]])))
    return coarse, np.concatenate([[0.0], np.cumsum(near)])


def divided(phi: Floats, parts: npt.NDArray[np.int64]) -> Floats:
    """Every interval cut into so many equal parts."""
    steps = np.diff(phi) / parts
    start = np.repeat(phi[:-1], parts)
    first = np.repeat(np.cumsum(parts) - parts, parts)
    return np.append(start + np.repeat(steps, parts) * (np.arange(int(parts.sum())) - first), phi[-1])


def _refuse(blocks: int, most: int, tolerance: float) -> None:
    if blocks > most:
        raise NotConverged(
            f"cutter.tolerance {tolerance:g} mm would take {blocks} blocks in one pass, more than {most}; "
            "ask for a coarser one"
        )
