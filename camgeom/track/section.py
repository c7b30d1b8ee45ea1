"""The cross-section of a groove cut by a roller, as rows of exact points: flank, edge sweep, floor, sweep, flank."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Protocol

import numpy as np

from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.track import Track
from camgeom.track.column import Column, Level

ROOTED = 2.0 / 3.0
"""share of its quarter circle that the tool's corner rounds an indexing cam's root"""


class CrossSection(Protocol):
    """Rows of points across a groove, from the top of one flank down and up the other."""

    @property
    def track(self) -> Track:
        """The track of the groove."""

    @property
    def names(self) -> tuple[str, ...]:
        """Face-group names of its bands."""

    @property
    def max_counts(self) -> tuple[int, ...]:
        """Most cells across each band."""

    def rows(self, column: Column, counts: tuple[int, ...]) -> Floats:
        """Points (3, n, 1 + sum(counts))."""

    def at(self, phi: Floats, row: Floats, counts: tuple[int, ...]) -> Floats:
        """Points (3, n) at cam angles (n,) and rows (n,) that need not be whole numbers."""

    @property
    def bands(self) -> list[Band]:
        """Each band as a surface."""


Band = Callable[[Column, Floats], Floats]
"""Points (3, n, m) of a band at columns (n,) and shares (n, m) of the way across it."""


def _banded(track: Track, phi: Floats, row: Floats, counts: tuple[int, ...], bands: list[Band]) -> Floats:
    """Points (3, n) at cam angles (n,) and rows (n,) of bands side by side."""
    ends = np.cumsum((0, *counts))
    x = np.empty((3, len(row)))
    for k, band in enumerate(bands):
        own = np.flatnonzero((row >= ends[k]) & ((row < ends[k + 1]) | (k + 1 == len(bands))))
        if len(own):
            share = np.clip((row[own] - ends[k]) / counts[k], 0.0, 1.0)
            x[:, own] = band(Column(track, phi[own]), share[:, None])[:, :, 0]
    return x


@immutable
class GrooveSection:
    """Rows of points across a groove, from the top of flank `first` down, across the floor and up the other flank.

    top      for each of the two flanks the level surface it ends at, and a guess of delta there
    first    side (+1 or -1) of the flank that comes first
    """

    track: Track
    level: Level
    guess: float
    first: float

    @property
    def names(self) -> tuple[str, ...]:
        """Face-group names of the bands."""
        if self._ball:
            return ("flank", "flank")
        return ("flank", self.foot_name, "floor", self.foot_name, "flank")

    @property
    def foot_name(self) -> str:
        """Face-group name of what lies between a flank and the floor."""
        return "root" if self.track.root else "edge"

    @cached_property
    def _ball(self) -> bool:
        return Column(self.track, np.zeros(1)).ball_ended

    @property
    def max_counts(self) -> tuple[int, ...]:
        """Most cells across each band (the floor is straight across)."""
        return (4000, 4000) if self._ball else (4000, 4000, 1, 4000, 4000)

    def rows(self, column: Column, counts: tuple[int, ...]) -> Floats:
        """Points (3, n, 1 + sum(counts))."""
        first, last = self.first, -self.first
        down = self._wall(column, first, counts[0])
        up = self._wall(column, last, counts[-1])[:, :, ::-1]
        if self._ball:
            return np.concatenate([down, up[:, :, 1:]], axis=2)
        arc1 = column.edge(first, self._spread(np.arange(1, counts[1] + 1) / counts[1]))
        arc2 = column.edge(last, self._spread(np.arange(counts[3], 0, -1) / counts[3]))
        floor = self._floor(arc1[:, :, -1], arc2[:, :, 0], counts[2])
        return np.concatenate([down, arc1, floor, arc2, up], axis=2)

    def at(self, phi: Floats, row: Floats, counts: tuple[int, ...]) -> Floats:
        """Points (3, n) at cam angles (n,) and rows (n,) that need not be whole numbers."""
        return _banded(self.track, phi, row, counts, self.bands)

    @property
    def bands(self) -> list[Band]:
        """Each band as a surface."""
        first, last = self.first, -self.first

        def wall(side: float, column: Column, share: Floats) -> Floats:
            top = self._top(column, side)
            if not self._ball:
                return column.wall(side, top + (column.tip_t - top) * share)
            pole = share == 1.0
            x = column.wall(side, top + (column.bottom_t() - top) * np.where(pole, 0.0, share))
            # Both flanks of a ball end where they meet.
            return np.where(pole, column.ball_bottom()[:, :, None], x) if pole.any() else x

        def edge(side: float, column: Column, share: Floats) -> Floats:
            return column.edge(side, self._spread(share))

        def floor(column: Column, share: Floats) -> Floats:
            start, stop = column.chord_end(first)[:, :, None], column.chord_end(last)[:, :, None]
            return start + (stop - start) * share

        bands: list[Band] = [partial(wall, first), lambda column, share: wall(last, column, 1.0 - share)]
        if not self._ball:
            bands[1:1] = [partial(edge, first), floor, lambda column, share: edge(last, column, 1.0 - share)]
        return bands

    def _spread(self, share: Floats) -> Floats:
        """Shares of rows between flank and floor: an edge sweep bends sharply beside the flank's foot alone."""
        return share if self.track.root else share**2

    def _top(self, column: Column, side: float) -> Floats:
        """Meridian parameter (n, 1) at the groove's outer edge."""
        top = column.reach(side, self.level, self.guess)
        if self.track.root and float((self.track.tip_sign * (column.bottom_t() - top)).min()) <= 0.0:
            raise DesignError(
                f"track {self.track.name!r}: the root, {self.track.root:g} mm in radius, reaches the groove's outer "
                "edge and leaves no flank: a smaller corner radius or a deeper groove"
            )
        return top

    def _wall(self, column: Column, side: float, count: int) -> Floats:
        top, share = self._top(column, side), np.arange(count + 1) / count
        if not self._ball:
            return column.wall(side, top + (column.bottom_t() - top) * share)
        upper = column.wall(side, top + (column.bottom_t() - top) * share[:-1])
        return np.concatenate([upper, column.ball_bottom()[:, :, None]], axis=2)

    @staticmethod
    def _floor(start: Floats, stop: Floats, count: int) -> Floats:
        share = np.arange(1, count) / count
        return np.asarray(start[:, :, None] + (stop - start)[:, :, None] * share)


@immutable
class FlooredSection:
    """Rows across a groove: down one flank from `top` to `floor`, straight across, up the other flank.

    guesses  delta near the top and near the floor
    """

    track: Track
    top: Level
    floor: Level
    guesses: tuple[float, float]
    names: tuple[str, ...] = ("flank", "floor", "flank")
    max_counts: tuple[int, ...] = (4000, 4000, 4000)

    def rows(self, column: Column, counts: tuple[int, ...]) -> Floats:
        """Points (3, n, 1 + sum(counts))."""
        down = self._wall(column, 1.0, counts[0])
        up = self._wall(column, -1.0, counts[2])[:, :, ::-1]
        foot, share = down[:, :, -1:], np.arange(1, counts[1]) / counts[1]
        return np.concatenate([down, foot + (up[:, :, :1] - foot) * share, up], axis=2)

    def at(self, phi: Floats, row: Floats, counts: tuple[int, ...]) -> Floats:
        """Points (3, n) at cam angles (n,) and rows (n,) that need not be whole numbers."""
        return _banded(self.track, phi, row, counts, self.bands)

    @property
    def bands(self) -> list[Band]:
        """Each band as a surface."""

        def wall(side: float, column: Column, share: Floats) -> Floats:
            return self._at_shares(column, side, share)

        def floor(column: Column, share: Floats) -> Floats:
            foot, other = (column.wall(side, column.reach(side, self.floor, self.guesses[1])) for side in (1.0, -1.0))
            return foot + (other - foot) * share

        return [partial(wall, 1.0), floor, lambda column, share: wall(-1.0, column, 1.0 - share)]

    def _wall(self, column: Column, side: float, count: int) -> Floats:
        return self._at_shares(column, side, np.arange(count + 1) / count)

    def _at_shares(self, column: Column, side: float, share: Floats) -> Floats:
        """Flank points (3, n, k) at shares (k,) or (n, k) of the way from top to floor."""
        high = column.reach(side, self.top, self.guesses[0])
        low = column.reach(side, self.floor, self.guesses[1])
        return column.wall(side, high + (low - high) * share)


@immutable
class RootedSection:
    """Rows across an indexing cam's groove with rounded roots: flank, root, straight across, root, flank.

    The root is swept by the torus of the tool's corner as far round as ROOTED says: the flat end behind it folds where
    the turret swings fast, and what it would leave is not used.
    guess  delta near the top
    """

    track: Track
    top: Level
    guess: float
    names: tuple[str, ...] = ("flank", "root", "floor", "root", "flank")
    max_counts: tuple[int, ...] = (4000, 4000, 4000, 4000, 4000)

    def rows(self, column: Column, counts: tuple[int, ...]) -> Floats:
        """Points (3, n, 1 + sum(counts))."""
        ends = np.cumsum((0, *counts))
        row = np.arange(ends[-1] + 1)
        bands = self.bands
        shares = [(row[a : b + (k == 4)] - a) / (b - a) for k, (a, b) in enumerate(zip(ends[:-1], ends[1:]))]
        return np.concatenate([band(column, share[None, :]) for band, share in zip(bands, shares)], axis=2)

    def at(self, phi: Floats, row: Floats, counts: tuple[int, ...]) -> Floats:
        """Points (3, n) at cam angles (n,) and rows (n,) that need not be whole numbers."""
        return _banded(self.track, phi, row, counts, self.bands)

    @property
    def bands(self) -> list[Band]:
        """Each band as a surface."""

        def floor(column: Column, share: Floats) -> Floats:
            start, stop = (column.corner(side, np.array([ROOTED])) for side in (1.0, -1.0))
            return np.asarray(start + (stop - start) * share)

        return [
            partial(self._wall, 1.0),
            lambda column, share: column.corner(1.0, ROOTED * share),
            floor,
            lambda column, share: column.corner(-1.0, ROOTED * (1.0 - share)),
            lambda column, share: self._wall(-1.0, column, 1.0 - share),
        ]

    def _wall(self, side: float, column: Column, share: Floats) -> Floats:
        high = column.reach(side, self.top, self.guess)
        if float((self.track.tip_sign * (column.tip_t - high)).min()) <= 0.0:
            raise DesignError(f"track {self.track.name!r}: the root, {self.track.root:g} mm in radius, leaves no flank")
        return column.wall(side, high + (column.tip_t - high) * share)
