"""Strips that run several times round an axis, sampled at the same angles in each, with a guaranteed chord error.

Surfaces that lie side by side round after round (the turns of a groove and the lands between them) share their edges
where all rounds have the same knots theta in [0, 2 pi]. A strip's columns are numbered on through the rounds: column c
stands at theta[c mod N] + 2 pi (c div N), with N intervals a round.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import floor, pi
from typing import Protocol

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats
from camgeom.maths.sag import Cells, Counts, measure
from camgeom.maths.sampling import converge, probed

Index = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]
TURN = 2.0 * pi


def angles(theta: Floats, columns: Index) -> Floats:
    """Angles (rad, on through the rounds) of the numbered columns."""
    n = len(theta) - 1
    return np.asarray(theta[columns % n] + TURN * (columns // n))


def middle_angles(theta: Floats, columns: Index) -> Floats:
    """Angles (rad) half way from the numbered columns to the next ones."""
    n = len(theta) - 1
    return np.asarray((0.5 * (theta[:-1] + theta[1:]))[columns % n] + TURN * (columns // n))


def columns_over(theta: Floats, low: float, high: float) -> tuple[int, int]:
    """First and last of the fewest columns that cover low .. high (rad)."""
    n = len(theta) - 1
    first, last = floor(low / TURN), floor(high / TURN)
    start = int(np.searchsorted(theta, low - TURN * first, side="right")) - 1
    stop = int(np.searchsorted(theta, high - TURN * last, side="left"))
    return first * n + min(start, n - 1), last * n + stop


@dataclass(frozen=True, eq=False)
class Strip:
    """Points of one strip at consecutive columns.

    first   number of the first column
    bands   numbers of the surface's bands that lie side by side in it
    corner  (3, n + 1, k + 1) at the columns
    """

    first: int
    bands: tuple[int, ...]
    corner: Floats

    @property
    def cells(self) -> int:
        """Number n of its cells along the round."""
        return int(self.corner.shape[1]) - 1

    def within(self, low: float, high: float) -> Mask:
        """Cells (n, k) that reach into z = low .. high."""
        z = self.corner[2]
        least, most = np.minimum(z[1:], z[:-1]), np.maximum(z[1:], z[:-1])
        return np.asarray(
            (np.minimum(least[:, 1:], least[:, :-1]) < high) & (np.maximum(most[:, 1:], most[:, :-1]) > low)
        )


class Surface(Protocol):
    """Strips that can be made at any knots."""

    def strips(self, theta: Floats, counts: Counts) -> list[Strip]:
        """All strips, with counts[b] cells across band b."""

    def sags(self, theta: Floats, counts: Counts, strips: list[Strip], chosen: list[Index]) -> list[Cells]:
        """Of each strip the sags behind the chosen columns (q,), each (q, k); zero where cells do not count."""


@dataclass(frozen=True, eq=False)
class Rounds:
    """A surface meshed at knots theta; of each strip the `chosen` cells along the round are measured."""

    theta: Floats
    counts: Counts
    strips: list[Strip]
    chosen: list[Index]
    cells: list[Cells]
    complete: bool

    @cached_property
    def _judged(self) -> list[tuple[Floats, Mask]]:
        each = zip(self.cells, self.chosen, self.strips)
        return [cells.spread(chosen, strip.cells).error() for cells, chosen, strip in each]

    @property
    def worst(self) -> float:
        """Largest chord error of a counted cell, mm."""
        return max(float(error.max(initial=0.0)) for error, _ in self._judged)

    @property
    def rising(self) -> list[Mask]:
        """Of each strip which cells (n, k) have the diagonal from (i, j) to (i + 1, j + 1)."""
        return [rising for _, rising in self._judged]

    @property
    def bands(self) -> list[Cells]:
        """The sags of each band's cells in all rounds and strips, side by side for each interval of one round."""
        n = len(self.theta) - 1
        found: list[list[Cells]] = [[] for _ in self.counts]
        for strip, cells in zip(self.strips, self.cells):
            for band, part in zip(strip.bands, cells.split(tuple(self.counts[b] for b in strip.bands))):
                found[band].append(Cells(*(_folded(x, strip.first, n) for x in (part.a, part.b, part.c))))
        return [Cells.joined(parts) for parts in found]


def sample_rounds(surface: Surface, knots: Floats, tolerance: float, most: Counts) -> Rounds:
    """Sample so that every counted triangle is within `tolerance` (mm) of the true surface; see `strips.converge`.

    knots  (k,) angles from 0 to 2 pi at which a derivative may jump
    most   upper bound of the cells across each band
    """

    def measured(theta: Floats, counts: Counts, every: bool) -> Rounds:
        n = len(theta) - 1
        strips = surface.strips(theta, counts)
        total = sum(strip.cells * (strip.corner.shape[2] - 1) for strip in strips)
        base = np.zeros(n, dtype=bool)
        base[np.arange(n) if every else probed(knots, theta, -(-total // n))] = True
        chosen = [np.flatnonzero(base[np.arange(s.first, s.first + s.cells) % n]) for s in strips]
        return Rounds(theta, counts, strips, chosen, surface.sags(theta, counts, strips, chosen), bool(base.all()))

    return converge(measured, knots, tolerance, most)


def strip_sags(strip: Strip, at: Index, middle: Floats, low: float, high: float) -> Cells:
    """Sags of the chosen cells of a strip by its points half way; zero for cells that lie outside z = low .. high."""
    whole = len(at) == strip.cells
    corner = strip.corner
    start, stop = (corner[:, :-1], corner[:, 1:]) if whole else (corner[:, at], corner[:, at + 1])
    on = strip.within(low, high)[at]
    found = measure(start, stop, middle)
    return found if on.all() else Cells(found.a * on, found.b * on, found.c * on)


def _folded(x: Floats, first: int, n: int) -> Floats:
    """Values (cells, k) of a strip laid side by side for each interval of a round, (n, rounds * k)."""
    before = first % n
    rounds = -(-(before + len(x)) // n)
    padded = np.zeros((rounds * n, x.shape[1]))
    padded[before : before + len(x)] = x
    return np.asarray(padded.reshape(rounds, n, -1).transpose(1, 0, 2).reshape(n, -1))
