"""Structured surface strips: rows of exact surface points along a parameter phi, meshed with a guaranteed chord error.

A section maps phi (n,) to k rows of points; `bands` name consecutive rows that form one surface. The sag of every cell
is measured on the true surface (see `sag`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, TypeVar

import numpy as np
import numpy.typing as npt

from camgeom.errors import NotConverged
from camgeom.maths import Floats
from camgeom.maths.sag import Cells, Counts, measure

Section = Callable[[Floats, Counts], Floats]
"""(phi (n,), cells across each band) -> points (3, n, 1 + sum(counts)); band b spans counts[b] cells."""

FILL = 0.96
"""aim of the knots as a share of the tolerance, so that third-order terms stay inside it"""
ACROSS = 0.7
"""share of the tolerance that the sag across a band may take; the rest is left to the steps along phi"""
PROBE = 12
"""cells in which each knot interval is measured first"""
PASSES = 12
PROBED_CELLS = 60_000
SPARSE = 0.995
"""share of the tolerance that counts as met where only a part of the cells was measured"""
MAX_CELLS = 40_000_000


@dataclass(frozen=True, eq=False)
class Grid:
    """A finished structured grid: phi (n + 1,), points (3, n + 1, k + 1), cells per band, diagonals, chord error mm."""

    phi: Floats
    points: Floats
    counts: Counts
    rising: npt.NDArray[np.bool_]
    chord_error: float


class Measured(Protocol):
    """A surface meshed at given knots, its sags measured at all of its cells or at some."""

    @property
    def bands(self) -> list[Cells]:
        """The sags of each band's cells, (n, k) for n intervals of phi."""

    @property
    def worst(self) -> float:
        """Largest chord error that was met, mm."""

    @property
    def complete(self) -> bool:
        """True where every cell was measured."""


M = TypeVar("M", bound=Measured)


def converge(
    measured: Callable[[Floats, Counts, bool], M], knots: Floats, tolerance: float, max_counts: Counts
) -> M:
    """The mesh whose largest chord error is within `tolerance` (mm), with knots of equal error.

    measured    (phi, cells across each band, whether to measure every cell) -> the mesh there
    knots       (k,) phi where a derivative may jump, with both ends
    max_counts  upper bound of the cells across each band (1 for bands that are straight across)
    Raises NotConverged where the tolerance would need more than MAX_CELLS cells.
    """
    phi = _subdivided(knots, PROBE)
    coarse = tuple(min(6, m) for m in max_counts)
    bands = measured(phi, coarse, True).bands
    counts = _choose_counts(bands, coarse, tolerance, max_counts)
    widths = [c / n for c, n in zip(coarse, counts)]
    aim = FILL * tolerance
    for attempt in range(PASSES):
        k = np.repeat(widths, [band.a.shape[1] for band in bands])
        phi = _placed(knots, phi, _steps(Cells.joined(bands), k, aim))
        if (len(phi) - 1) * sum(counts) > MAX_CELLS:
            raise NotConverged(
                f"a tolerance of {tolerance:g} mm needs more than {MAX_CELLS} cells; ask for a coarser one"
            )
        found = measured(phi, counts, False)
        if found.worst <= tolerance * (1.0 if found.complete else SPARSE):
            return found
        bands = (found if found.complete else measured(phi, counts, True)).bands
        widths, counts = _widened(bands, counts, tolerance, max_counts, max(0.3, 0.9 - 0.15 * attempt))
        aim = (FILL - 0.03 * attempt) * tolerance
    raise NotConverged(
        f"the chord error stays at {found.worst:g} mm, above the tolerance {tolerance:g} mm: the surface is nearly "
        "singular (look at the undercut margin and the continuity of the motion)"
    )


@dataclass(frozen=True, eq=False)
class _Sheet:
    """One grid of a section; `chosen` cells along phi are measured."""

    phi: Floats
    points: Floats
    counts: Counts
    chosen: npt.NDArray[np.int64]
    cells: Cells
    complete: bool

    @cached_property
    def _judged(self) -> tuple[Floats, npt.NDArray[np.bool_]]:
        return self.cells.spread(self.chosen, len(self.phi) - 1).error()

    @property
    def worst(self) -> float:
        return float(self._judged[0].max())

    @property
    def bands(self) -> list[Cells]:
        return self.cells.split(self.counts)

    def grid(self) -> Grid:
        """The finished grid."""
        return Grid(self.phi, self.points, self.counts, self._judged[1], self.worst)


def sample(section: Section, knots: Floats, tolerance: float, max_counts: Counts) -> Grid:
    """Sample a section so that every triangle is within `tolerance` (mm) of the true surface; see `converge`."""

    def measured(phi: Floats, counts: Counts, every: bool) -> _Sheet:
        n = len(phi) - 1
        corner = section(phi, counts)
        chosen = np.arange(n) if every else probed(knots, phi, sum(counts))
        middle = section(0.5 * (phi[chosen] + phi[chosen + 1]), tuple(2 * c for c in counts))
        whole = len(chosen) == n
        start, stop = (corner[:, :-1], corner[:, 1:]) if whole else (corner[:, chosen], corner[:, chosen + 1])
        return _Sheet(phi, corner, counts, chosen, measure(start, stop, middle), whole)

    return converge(measured, knots, tolerance, max_counts).grid()


def probed(knots: Floats, phi: Floats, across: int) -> npt.NDArray[np.int64]:
    """Cells along phi whose error is measured: all of a small grid; of a large one every few, and those at knots.

    In a large grid neighbouring cells differ by a share of about one over their number, which SPARSE leaves room for.
    """
    n = len(phi) - 1
    stride = max(1, n * across // PROBED_CELLS)
    if stride == 1 or n < 400:
        return np.arange(n)
    at = np.searchsorted(phi, knots)
    return np.unique(np.clip(np.concatenate([np.arange(0, n, stride), at, at - 1]), 0, n - 1))


def _subdivided(knots: Floats, parts: int) -> Floats:
    """Every knot interval cut into parts that are finer towards its ends, where motion laws change fastest."""
    share = 0.5 * (1.0 - np.cos(np.pi * np.arange(parts) / parts))
    inner = (knots[:-1, None] + np.diff(knots)[:, None] * share).ravel()
    return np.append(inner, knots[-1])


def _steps(cells: Cells, k: Floats, tolerance: float) -> Floats:
    """Factor (n,) by which each cell may be lengthened in phi; cells are k times as wide as measured."""
    factors = np.minimum(_bound(cells, k, tolerance).min(axis=1), 64.0)
    for _ in range(3):
        error, _ = cells.scaled(factors[:, None], k).error()
        worst = error.max(axis=1)
        factors = np.clip(factors * (tolerance / np.maximum(worst, 1e-9 * tolerance)) ** 0.55, 1e-6, 64.0)
    return np.asarray(factors)


def _bound(cells: Cells, k: Floats, tolerance: float) -> Floats:
    """Largest h with |a| h² + 2 |b| h k + |c| k² <= 8 tolerance, cell by cell; tiny where |c| k² alone exceeds it."""
    a, b, c = np.abs(cells.a), np.abs(cells.b) * k, np.abs(cells.c) * k * k
    room = np.maximum(8.0 * tolerance - c, 1e-3 * tolerance)
    return np.asarray(room / (b + np.sqrt(b * b + a * room) + 1e-300))


def _placed(knots: Floats, phi: Floats, factors: Floats) -> Floats:
    """New parameters: each knot interval cut into equal shares of the density 1 / (step * factor).

    The density at a parameter is the larger one of the cells on its two sides (none beyond a knot), linear in between,
    so that a cell next to a sharper one is already refined.
    """
    width = np.diff(phi)
    density = 1.0 / (factors * width)
    inner = ~np.isin(phi[1:-1], knots)
    left, right = density.copy(), density.copy()
    left[1:] = np.where(inner, np.maximum(density[1:], density[:-1]), density[1:])
    right[:-1] = np.where(inner, np.maximum(density[1:], density[:-1]), density[:-1])
    share = np.arange(4) / 4.0
    fine = np.append((phi[:-1, None] + width[:, None] * share).ravel(), phi[-1])
    mean = left[:, None] + (right - left)[:, None] * (share + 0.125)
    total = np.concatenate([[0.0], np.cumsum((mean * 0.25 * width[:, None]).ravel())])
    at = np.interp(knots, fine, total)
    pieces = []
    for low, high, start, stop in zip(at[:-1], at[1:], knots[:-1], knots[1:]):
        parts = max(1, int(np.ceil(high - low)))
        piece = np.interp(low + (high - low) * np.arange(parts) / parts, total, fine)
        piece[0] = start
        pieces.append(np.minimum(piece, stop))
    return np.append(np.concatenate(pieces), knots[-1])


def _widened(
    bands: list[Cells], counts: Counts, tolerance: float, most: Counts, room: float
) -> tuple[list[float], Counts]:
    """More cells across the bands whose sag across takes more than `room`; widths of the measured in the new ones."""
    grown = []
    for band, count, top in zip(bands, counts, most):
        sag = float(np.abs(band.c).max()) / 8.0
        aim = min(ACROSS, room) * tolerance
        want = count if sag <= room * tolerance else int(np.ceil(count * np.sqrt(sag / aim)))
        grown.append(min(want, top))
    return [c / g for c, g in zip(counts, grown)], tuple(grown)


def _choose_counts(bands: list[Cells], coarse: Counts, tolerance: float, most: Counts) -> Counts:
    """Cells across each band such that the whole grid has the fewest: the step along phi is set by the worst band.

    For every band the allowed step is tabled over a geometric series of counts; counts are then improved one band at a
    time, since each change shows at once in the product (sum of counts) x (number of steps).
    """
    tables = [_step_table(band, c, tolerance, m) for band, c, m in zip(bands, coarse, most)]
    shares = [band.a.shape[1] / c for band, c in zip(bands, coarse)]
    pick = [0] * len(tables)
    best = _grid_size(tables, pick, shares)
    improved = True
    while improved:
        improved = False
        for b, (series, _) in enumerate(tables):
            for k in (pick[b] + 1, pick[b] + 2, pick[b] - 1):
                if not 0 <= k < len(series):
                    continue
                trial = [*pick[:b], k, *pick[b + 1 :]]
                size = _grid_size(tables, trial, shares)
                if size < 0.999 * best:
                    best, pick, improved = size, trial, True
    return tuple(int(series[k]) for (series, _), k in zip(tables, pick))


def _step_table(band: Cells, coarse: int, tolerance: float, most: int) -> tuple[npt.NDArray[np.int64], Floats]:
    """Counts (q,) to choose from and the step factor (q, n) that each allows."""
    sag = float(np.abs(band.c).max()) / 8.0
    least = min(most, max(1, int(np.ceil(coarse * np.sqrt(sag / (ACROSS * tolerance))))))
    series = np.unique(np.minimum(most, np.ceil(least * 1.35 ** np.arange(12)))).astype(np.int64)
    factors = _bound(band, (coarse / series)[:, None, None], FILL * tolerance).min(axis=2)
    return series, np.minimum(factors, 64.0)


def _grid_size(
    tables: list[tuple[npt.NDArray[np.int64], Floats]], pick: list[int], shares: list[float]
) -> float:
    """Cells of the whole grid; a band is there `shares` times."""
    step = np.minimum.reduce([factors[k] for (_, factors), k in zip(tables, pick)])
    across = sum(share * int(series[k]) for (series, _), k, share in zip(tables, pick, shares))
    return float(across * np.sum(1.0 / step))
