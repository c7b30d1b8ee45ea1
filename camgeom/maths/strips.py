"""Structured surface strips: rows of exact surface points along a parameter phi, meshed with a guaranteed chord error.

A section maps phi (n,) to k rows of points; `bands` name consecutive rows that form one surface. The sag of every cell
is measured on the true surface at the cell's middle and on its edges, and the sag of the quadratic patch through those
measurements, for the better of the two diagonals, is what is called its chord error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from camgeom.errors import NotConverged

Floats = npt.NDArray[np.float64]
Counts = tuple[int, ...]
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
class Cells:
    """Second-order sags of the cells of a grid, mm, each (n, k): along phi, mixed, and across (signed, along n)."""

    a: Floats
    b: Floats
    c: Floats

    def error(self) -> tuple[Floats, npt.NDArray[np.bool_]]:
        """Largest sag of the two triangles for the better diagonal, and which: True joins (i, j) to (i+1, j+1)."""
        rising, falling = patch_sag(self.a, -self.b, self.c), patch_sag(self.a, self.b, self.c)
        return np.minimum(rising, falling), rising <= falling

    def scaled(self, h: Floats, k: Floats) -> Cells:
        """The sags of cells h times as long in phi and k times as wide."""
        return Cells(self.a * h * h, self.b * h * k, self.c * k * k)


def patch_sag(a: Floats, b: Floats, c: Floats) -> Floats:
    """Largest |f - linear interpolant| of f = (a s² + 2 b s t + c t²) / 2 on the triangle (0,0) (1,0) (0,1).

    On the edges it is |a|/8, |c|/8 and |a + c - 2 b|/8; a stationary point inside the triangle counts too.
    """
    edge = np.maximum(np.maximum(np.abs(a), np.abs(c)), np.abs(a + c - 2.0 * b)) / 8.0
    det = a * c - b * b
    safe = np.where(det > 1e-12 * (np.abs(a * c) + b * b) + 1e-300, det, 1.0)
    s, t = c * (a - b) / (2.0 * safe), a * (c - b) / (2.0 * safe)
    inside = (safe == det) & (s > 0.0) & (t > 0.0) & (s + t < 1.0)
    return np.asarray(np.where(inside, np.maximum(edge, np.abs(a * s + c * t) / 4.0), edge))


def measure(start: Floats, stop: Floats, middle: Floats) -> Cells:
    """Sags of cells between two values of phi each.

    start, stop  (3, n, k + 1) exact points at the beginning and end of each cell along phi
    middle       (3, n, 2 k + 1) exact points at the middle phi of each cell, rows doubled
    """
    p00, p01, p10, p11 = start[:, :, :-1], start[:, :, 1:], stop[:, :, :-1], stop[:, :, 1:]
    d1, d2 = p11 - p00, p10 - p01
    n = np.stack([d1[1] * d2[2] - d1[2] * d2[1], d1[2] * d2[0] - d1[0] * d2[2], d1[0] * d2[1] - d1[1] * d2[0]])
    length = np.sqrt(n[0] ** 2 + n[1] ** 2 + n[2] ** 2)
    n /= np.where(length > 0.0, length, 1.0)
    row = 0.5 * (start + stop) - middle[:, :, ::2]
    centre = 0.25 * (p00 + p01 + p10 + p11) - middle[:, :, 1::2]
    low, high = _along(n, row[:, :, :-1]), _along(n, row[:, :, 1:])
    a = 8.0 * np.where(np.abs(low) > np.abs(high), low, high)
    c = 8.0 * _along(n, centre) - 4.0 * (low + high)
    return Cells(a, _along(n, p11 - p10 - p01 + p00), c)


def _along(n: Floats, d: Floats) -> Floats:
    return np.asarray(n[0] * d[0] + n[1] * d[1] + n[2] * d[2])


@dataclass(frozen=True, eq=False)
class Grid:
    """A finished structured grid: phi (n + 1,), points (3, n + 1, k + 1), cells per band, diagonals, chord error mm."""

    phi: Floats
    points: Floats
    counts: Counts
    rising: npt.NDArray[np.bool_]
    chord_error: float


def sample(section: Section, knots: Floats, bands: int, tolerance: float, max_counts: Counts) -> Grid:
    """Sample a section so that every triangle is within `tolerance` (mm) of the true surface.

    knots       (k,) phi where a derivative may jump, with both ends
    max_counts  upper bound of the cells across each band (1 for bands that are straight across)
    Raises NotConverged where the tolerance would need more than MAX_CELLS cells.
    """
    phi = _subdivided(knots, PROBE)
    coarse = tuple(min(6, m) for m in max_counts)
    cells = _measured(section, phi, coarse)
    counts = _choose_counts(cells, coarse, tolerance, max_counts)
    owner = np.repeat(np.arange(bands), coarse)
    steps = _steps(cells, np.array(coarse)[owner] / np.array(counts)[owner], FILL * tolerance)
    for attempt in range(PASSES):
        phi = _placed(knots, phi, steps)
        if (len(phi) - 1) * sum(counts) > MAX_CELLS:
            raise NotConverged(
                f"a tolerance of {tolerance:g} mm needs more than {MAX_CELLS} cells; ask for a coarser one"
            )
        corner = section(phi, counts)
        chosen = _probed(knots, phi, sum(counts))
        cells = _at(section, phi, corner, counts, chosen)
        error, rising = cells.error()
        worst = float(error.max())
        if worst <= tolerance * (1.0 if len(chosen) == len(phi) - 1 else SPARSE):
            nearest = np.searchsorted(0.5 * (chosen[1:] + chosen[:-1]), np.arange(len(phi) - 1))
            return Grid(phi, corner, counts, rising[nearest], worst)
        if len(chosen) < len(phi) - 1:
            cells = _at(section, phi, corner, counts, np.arange(len(phi) - 1))
        widths, counts = _widened(cells, counts, tolerance, max_counts, max(0.3, 0.9 - 0.15 * attempt))
        steps = _steps(cells, widths, (FILL - 0.03 * attempt) * tolerance)
    raise NotConverged(
        f"the chord error stays at {worst:g} mm, above the tolerance {tolerance:g} mm: the surface is nearly "
        "singular (look at the undercut margin and the continuity of the motion)"
    )


def _probed(knots: Floats, phi: Floats, across: int) -> npt.NDArray[np.int64]:
    """Cells along phi whose error is measured: all of a small grid; of a large one every few, and those at knots.

    In a large grid neighbouring cells differ by a share of about one over their number, which SPARSE leaves room for.
    """
    n = len(phi) - 1
    stride = max(1, n * across // PROBED_CELLS)
    if stride == 1 or n < 400:
        return np.arange(n)
    at = np.searchsorted(phi, knots)
    return np.unique(np.clip(np.concatenate([np.arange(0, n, stride), at, at - 1]), 0, n - 1))


def _at(
    section: Section, phi: Floats, corner: Floats, counts: Counts, chosen: npt.NDArray[np.int64]
) -> Cells:
    """Measure the chosen cells along phi."""
    middle = section(0.5 * (phi[chosen] + phi[chosen + 1]), tuple(2 * c for c in counts))
    if len(chosen) == corner.shape[1] - 1:
        return measure(corner[:, :-1], corner[:, 1:], middle)
    return measure(corner[:, chosen], corner[:, chosen + 1], middle)


def _measured(section: Section, phi: Floats, counts: Counts) -> Cells:
    return _at(section, phi, section(phi, counts), counts, np.arange(len(phi) - 1))


def _subdivided(knots: Floats, parts: int) -> Floats:
    """Every knot interval cut into parts that are finer towards its ends, where motion laws change fastest."""
    share = 0.5 * (1.0 - np.cos(np.pi * np.arange(parts) / parts))
    inner = (knots[:-1, None] + np.diff(knots)[:, None] * share).ravel()
    return np.append(inner, knots[-1])


def _steps(cells: Cells, widths: Floats, tolerance: float) -> Floats:
    """Factor (n,) by which each cell may be lengthened in phi; cells are `widths` times as wide as measured."""
    k = widths[None, :]
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
    cells: Cells, counts: Counts, tolerance: float, most: Counts, room: float
) -> tuple[Floats, Counts]:
    """More cells across the bands whose sag across takes more than `room`; widths of the measured in the new ones."""
    grown = []
    widths = []
    start = 0
    for count, top in zip(counts, most):
        sag = float(np.abs(cells.c[:, start : start + count]).max()) / 8.0
        aim = min(ACROSS, room) * tolerance
        want = count if sag <= room * tolerance else int(np.ceil(count * np.sqrt(sag / aim)))
        grown.append(min(want, top))
        widths.append(np.full(count, count / grown[-1]))
        start += count
    return np.concatenate(widths), tuple(grown)


def _choose_counts(cells: Cells, coarse: Counts, tolerance: float, most: Counts) -> Counts:
    """Cells across each band such that the whole grid has the fewest: the step along phi is set by the worst band.

    For every band the allowed step is tabled over a geometric series of counts; counts are then improved one band at a
    time, since each change shows at once in the product (sum of counts) x (number of steps).
    """
    edges = np.concatenate([[0], np.cumsum(coarse)])
    tables = []
    for b, (low, high) in enumerate(zip(edges[:-1], edges[1:])):
        band = Cells(cells.a[:, low:high], cells.b[:, low:high], cells.c[:, low:high])
        tables.append(_step_table(band, coarse[b], tolerance, most[b]))
    pick = [0] * len(tables)
    best = _grid_size(tables, pick)
    improved = True
    while improved:
        improved = False
        for b, (series, _) in enumerate(tables):
            for k in (pick[b] + 1, pick[b] + 2, pick[b] - 1):
                if not 0 <= k < len(series):
                    continue
                trial = [*pick[:b], k, *pick[b + 1 :]]
                size = _grid_size(tables, trial)
                if size < 0.999 * best:
                    best, pick, improved = size, trial, True
    return tuple(int(series[k]) for (series, _), k in zip(tables, pick))


def _step_table(band: Cells, coarse: int, tolerance: float, most: int) -> tuple[npt.NDArray[np.int64], Floats]:
    """Counts (q,) to choose from and the step factor (q, n) that each allows."""
    sag = float(np.abs(band.c).max()) / 8.0
    least = min(most, max(1, int(np.ceil(coarse * np.sqrt(sag / (ACROSS * tolerance))))))
    series = np.unique(np.minimum(most, np.ceil(least * 1.35 ** np.arange(12)))).astype(np.int64)
    factors = np.stack(
        [np.minimum(_bound(band, np.array(coarse / c), FILL * tolerance).min(axis=1), 64.0) for c in series]
    )
    return series, factors


def _grid_size(tables: list[tuple[npt.NDArray[np.int64], Floats]], pick: list[int]) -> float:
    step = np.minimum.reduce([factors[k] for (_, factors), k in zip(tables, pick)])
    return float(sum(int(series[k]) for (series, _), k in zip(tables, pick)) * np.sum(1.0 / step))
