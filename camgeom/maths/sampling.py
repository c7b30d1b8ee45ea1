"""Structured surface grids meshed with a guaranteed chord error, with the fewest cells: knots of equal error.

A section maps parameters phi (n,) to k rows of exact points; `bands` name consecutive rows that form one surface. The
sag is measured on the true surface at every cell's middle and on its edges, and that of the quadratic patch through
those measurements, for the better of the two diagonals, is what is called the cell's chord error.

Strips that run several times round an axis side by side (the turns of a groove and the lands between them) share their
edges where all rounds have the same knots theta in [0, 2 pi]. A strip's columns are numbered on through the rounds:
column c stands at theta[c mod N] + 2 pi (c div N), with N intervals a round.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import floor
from typing import Protocol

import numpy as np
import numpy.typing as npt

from camgeom.errors import NotConverged
from camgeom.immutable import immutable
from camgeom.maths import TURN, Floats, distinct
from camgeom.maths.frozen import cached_property
from camgeom.maths.surface import cross, dot

Counts = tuple[int, ...]
"""cells across each band"""
Index = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]
Rows = Callable[[Floats, Counts], Floats]
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
MAX_CELLS = 4_000_000
"""of one surface: some ten seconds and, as the triangles of a body, 2 GB"""
FEWEST = 16
"""steps a piece of a curve is measured in first"""
EVEN = 0.98
"""aim of a curve's steps as a share of the tolerance"""
ROUNDS = 16


@immutable
class Cells:
    """Second-order sags of the cells of a grid, mm, each (n, k): along phi, mixed, and across (signed, along n)."""

    a: Floats
    b: Floats
    c: Floats

    def error(self) -> tuple[Floats, Mask]:
        """Largest sag of the two triangles for the better diagonal, and which: True joins (i, j) to (i+1, j+1)."""
        a, b, c = self.a, self.b, self.c
        side, total, twice = np.maximum(np.abs(a), np.abs(c)), a + c, 2.0 * b
        rising = 0.125 * np.maximum(side, np.abs(total + twice))
        falling = 0.125 * np.maximum(side, np.abs(total - twice))
        # Only a patch bent to one side in every direction can sag most inside a triangle.
        bowl = np.nonzero(a * c > b * b)
        if len(bowl[0]):
            rising[bowl] = patch_sag(a[bowl], -b[bowl], c[bowl])
            falling[bowl] = patch_sag(a[bowl], b[bowl], c[bowl])
        return np.minimum(rising, falling), rising <= falling

    def split(self, counts: Counts) -> list[Cells]:
        """The cells of each of the bands side by side."""
        cuts = np.cumsum(counts)[:-1]
        parts = zip(*(np.split(x, cuts, axis=1) for x in (self.a, self.b, self.c)))
        return [Cells(a, b, c) for a, b, c in parts]

    @classmethod
    def joined(cls, parts: list[Cells]) -> Cells:
        """The cells of several bands side by side."""
        if len(parts) == 1:
            return parts[0]
        return cls(*(np.concatenate([getattr(part, k) for part in parts], axis=1) for k in "abc"))

    def spread(self, measured: Index, n: int) -> Cells:
        """The cells at all of n steps along phi from those at the measured ones, in between by straight lines.

        The sags of neighbours differ little, but which diagonal is better may change anywhere between two of them.
        """
        if len(measured) == n:
            return self
        place = np.interp(np.arange(n), measured, np.arange(len(measured)))
        low = np.minimum(place.astype(np.int64), len(measured) - 2)
        share = (place - low)[:, None]
        return Cells(*(x[low] + share * (x[low + 1] - x[low]) for x in (self.a, self.b, self.c)))

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
    n = cross(d1, d2)
    length = np.sqrt(dot(n, n))
    inverse = 1.0 / np.where(length > 0.0, length, 1.0)
    row = 0.5 * (start + stop) - middle[:, :, ::2]
    centre = 0.25 * (p00 + p01 + p10 + p11) - middle[:, :, 1::2]
    low, high = dot(n, row[:, :, :-1]), dot(n, row[:, :, 1:])
    a = 8.0 * np.where(np.abs(low) > np.abs(high), low, high)
    c = 8.0 * dot(n, centre) - 4.0 * (low + high)
    b = dot(n, p11 - p10 - p01 + p00)
    for x in (a, b, c):
        x *= inverse
    return Cells(a, b, c)


@immutable
class Grid:
    """A finished structured grid: phi (n + 1,), points (3, n + 1, k + 1), cells per band, diagonals.

    chord_error  mm, of all bands that keep the tolerance; free_error: of those that may be off by more, or None
    """

    phi: Floats
    points: Floats
    counts: Counts
    rising: Mask
    chord_error: float
    free_error: float | None = None


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


@immutable
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

    def sides(self, at: Index) -> tuple[Floats, Floats]:
        """Points (3, q, k + 1) at the beginning and at the end of the cells `at` (q,) along the round."""
        if len(at) == self.cells:
            return self.corner[:, :-1], self.corner[:, 1:]
        return self.corner[:, at], self.corner[:, at + 1]

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


@immutable
class _Single:
    """One section from end to end: a surface of a single strip."""

    rows: Rows

    def strips(self, theta: Floats, counts: Counts) -> list[Strip]:
        return [Strip(0, tuple(range(len(counts))), self.rows(theta, counts))]

    def sags(self, theta: Floats, counts: Counts, strips: list[Strip], chosen: list[Index]) -> list[Cells]:
        at = chosen[0]
        middle = self.rows(0.5 * (theta[at] + theta[at + 1]), tuple(2 * c for c in counts))
        return [measure(*strips[0].sides(at), middle)]


@immutable
class Sampled:
    """A surface meshed at knots theta; of each strip the `chosen` cells along the round are measured.

    cells     their sags, those of a band over its ease: how many times the tolerance it may be off
    complete  True where every cell was measured
    """

    theta: Floats
    counts: Counts
    strips: list[Strip]
    chosen: list[Index]
    cells: list[Cells]
    complete: bool
    ease: tuple[float, ...]

    @cached_property
    def _judged(self) -> list[tuple[Floats, Mask]]:
        each = zip(self.cells, self.chosen, self.strips)
        return [cells.spread(chosen, strip.cells).error() for cells, chosen, strip in each]

    @property
    def worst(self) -> float:
        """Largest chord error of a counted cell over its band's ease, mm."""
        return max(float(error.max(initial=0.0)) for error, _ in self._judged)

    @property
    def errors(self) -> tuple[float, float | None]:
        """Largest chord errors of counted cells, mm: of the bands that keep the tolerance, and of all others."""
        worst = [0.0] * len(self.ease)
        for (error, _), strip in zip(self._judged, self.strips):
            cuts = np.cumsum([self.counts[b] for b in strip.bands])[:-1]
            for band, part in zip(strip.bands, np.split(error, cuts, axis=1)):
                worst[band] = max(worst[band], self.ease[band] * float(part.max(initial=0.0)))
        strict = [error for error, ease in zip(worst, self.ease) if ease == 1.0]
        free = [error for error, ease in zip(worst, self.ease) if ease > 1.0]
        return max(strict, default=0.0), max(free, default=None)

    @property
    def rising(self) -> list[Mask]:
        """Of each strip which cells (n, k) have the diagonal from (i, j) to (i + 1, j + 1)."""
        return [rising for _, rising in self._judged]

    @property
    def bands(self) -> list[Cells]:
        """The sags of each band's cells in all rounds and strips, side by side for each interval of one round."""
        n = len(self.theta) - 1
        bands: list[list[Cells]] = [[] for _ in self.counts]
        for strip, cells in zip(self.strips, self.cells):
            for band, part in zip(strip.bands, cells.split(tuple(self.counts[b] for b in strip.bands))):
                bands[band].append(Cells(*(_folded(x, strip.first, n) for x in (part.a, part.b, part.c))))
        return [Cells.joined(parts) for parts in bands]


def sample(rows: Rows, knots: Floats, tolerance: float, most: Counts, ease: Sequence[float] | None = None) -> Grid:
    """Sample one section so that every triangle is within `tolerance` mm of the true surface; see `sample_surface`."""
    sampled = sample_surface(_Single(rows), knots, tolerance, most, ease)
    corner, (strict, free) = sampled.strips[0].corner, sampled.errors
    return Grid(sampled.theta, corner, sampled.counts, sampled.rising[0], strict, free)


def too_many(count: int, of: str) -> NotConverged:
    """Of cells or vertices beyond MAX_CELLS."""
    return NotConverged(f"the tolerance needs {count} {of}, more than {MAX_CELLS}; ask for a coarser one")


def sample_surface(
    surface: Surface, knots: Floats, tolerance: float, most: Counts, ease: Sequence[float] | None = None
) -> Sampled:
    """Sample so that every counted triangle is within `tolerance` (mm) of the true surface, with knots of equal error.

    knots  (k,) parameters at which a derivative may jump, with both ends; strips in rounds: angles from 0 to 2 pi
    most   upper bound of the cells across each band (1 for bands that are straight across)
    ease   how many times the tolerance each band may be off, 1 or more; None: 1 for all
    Raises NotConverged where the tolerance would need more than MAX_CELLS cells.
    """
    phi = subdivided_knots(knots, PROBE)
    coarse = tuple(min(6, m) for m in most)
    eased = tuple(ease or (1.0,) * len(most))
    bands = _measured(surface, knots, phi, coarse, True, eased).bands
    counts = _choose_counts(bands, coarse, tolerance, most)
    widths = [c / n for c, n in zip(coarse, counts)]
    aim = FILL * tolerance
    for attempt in range(PASSES):
        k = np.repeat(widths, [band.a.shape[1] for band in bands])
        phi = placed(knots, phi, _steps(Cells.joined(bands), k, aim))
        if (len(phi) - 1) * sum(counts) > MAX_CELLS:
            raise too_many((len(phi) - 1) * sum(counts), "cells")
        sampled = _measured(surface, knots, phi, counts, False, eased)
        if sampled.worst <= tolerance * (1.0 if sampled.complete else SPARSE):
            return sampled
        bands = (sampled if sampled.complete else _measured(surface, knots, phi, counts, True, eased)).bands
        widths, counts = _widened(bands, counts, tolerance, most, max(0.3, 0.9 - 0.15 * attempt))
        aim = (FILL - 0.03 * attempt) * tolerance
    raise NotConverged(
        f"the chord error stays at {sampled.worst:g} mm, above the tolerance {tolerance:g} mm: the surface is nearly "
        "singular (look at the undercut margin and the continuity of the motion)"
    )


def _measured(
    surface: Surface, knots: Floats, theta: Floats, counts: Counts, every: bool, ease: tuple[float, ...]
) -> Sampled:
    """The surface at knots theta, its sags measured at every cell or only where `_probed` says."""
    n = len(theta) - 1
    strips = surface.strips(theta, counts)
    total = sum(strip.cells * (strip.corner.shape[2] - 1) for strip in strips)
    base = np.zeros(n, dtype=bool)
    base[np.arange(n) if every else _probed(knots, theta, -(-total // n))] = True
    chosen = [np.flatnonzero(base[np.arange(s.first, s.first + s.cells) % n]) for s in strips]
    cells = surface.sags(theta, counts, strips, chosen)
    if max(ease) > 1.0:
        cells = [_eased(own, strip, counts, ease) for own, strip in zip(cells, strips)]
    return Sampled(theta, counts, strips, chosen, cells, bool(base.all()), ease)


def _eased(cells: Cells, strip: Strip, counts: Counts, ease: tuple[float, ...]) -> Cells:
    """The sags of a strip's cells over the eases of its bands."""
    over = np.repeat([ease[b] for b in strip.bands], [counts[b] for b in strip.bands])
    return Cells(cells.a / over, cells.b / over, cells.c / over)


def _probed(knots: Floats, phi: Floats, across: int) -> Index:
    """Cells along phi whose error is measured: all of a small grid; of a large one every few, and those at knots.

    In a large grid neighbouring cells differ by a share of about one over their number, which SPARSE leaves room for.
    """
    n = len(phi) - 1
    stride = max(1, n * across // PROBED_CELLS)
    if stride == 1 or n < 400:
        return np.arange(n)
    at = np.searchsorted(phi, knots)
    return distinct(np.clip(np.concatenate([np.arange(0, n, stride), at, at - 1]), 0, n - 1))


def subdivided_knots(knots: Floats, parts: int) -> Floats:
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


def placed(knots: Floats, phi: Floats, factors: Floats) -> Floats:
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


def _step_table(band: Cells, coarse: int, tolerance: float, most: int) -> tuple[Index, Floats]:
    """Counts (q,) to choose from and the step factor (q, n) that each allows."""
    sag = float(np.abs(band.c).max()) / 8.0
    least = min(most, max(1, int(np.ceil(coarse * np.sqrt(sag / (ACROSS * tolerance))))))
    series = distinct(np.minimum(most, np.ceil(least * 1.35 ** np.arange(12)))).astype(np.int64)
    factors = _bound(band, (coarse / series)[:, None, None], FILL * tolerance).min(axis=2)
    return series, np.minimum(factors, 64.0)


def _grid_size(
    tables: list[tuple[Index, Floats]], pick: list[int], shares: list[float]
) -> float:
    """Cells of the whole grid; a band is there `shares` times."""
    step = np.minimum.reduce([factors[k] for (_, factors), k in zip(tables, pick)])
    across = sum(share * int(series[k]) for (series, _), k, share in zip(tables, pick, shares))
    return float(across * np.sum(1.0 / step))


def strip_sags(strip: Strip, at: Index, middle: Floats, low: float, high: float) -> Cells:
    """Sags of the chosen cells of a strip by its points half way; zero for cells that lie outside z = low .. high."""
    on = strip.within(low, high)[at]
    cells = measure(*strip.sides(at), middle)
    return cells if on.all() else Cells(cells.a * on, cells.b * on, cells.c * on)


def _folded(x: Floats, first: int, n: int) -> Floats:
    """Values (cells, k) of a strip laid side by side for each interval of a round, (n, rounds * k)."""
    before = first % n
    if before == 0 and len(x) == n:
        return x
    rounds = -(-(before + len(x)) // n)
    padded = np.zeros((rounds * n, x.shape[1]))
    padded[before : before + len(x)] = x
    return np.asarray(padded.reshape(rounds, n, -1).transpose(1, 0, 2).reshape(n, -1))


def even_steps(
    error: Callable[[Floats], Floats], pieces: Sequence[tuple[float, float]], tolerance: float, most: int
) -> tuple[Floats, Floats]:
    """Steps of nearly equal error along a curve: parameters (n + 1,) with the ends of every piece, and errors (n,).

    error   parameters (n + 1,) -> the error (n,) of each step, which falls with its square as a chord's sag does
    pieces  smooth stretches one after the other
    most    steps; NotConverged where more are needed, before they are made
    Where some error stays above the tolerance the caller sees it, and can say where.
    """
    grids = [np.linspace(low, high, FEWEST + 1) for low, high in pieces]
    errors = _errors(error, grids)
    for attempt in range(ROUNDS):
        # Pieces that are far within the tolerance are first spread anew as well: a short dwell needs one step.
        ample = 0.25 * tolerance if attempt == 0 else 0.0
        again = [k for k, e in enumerate(errors) if e.max() > tolerance or e.max() < ample]
        if not again:
            break
        totals = {k: _steps_needed(errors[k], EVEN * tolerance * 0.97**attempt) for k in again}
        steps = sum(float(totals[k][-1]) if k in totals else len(grid) - 1 for k, grid in enumerate(grids))
        if steps > most:
            raise NotConverged(f"{tolerance:g} mm takes {steps:.0f} steps, more than {most}; ask for a coarser one")
        for k, total in totals.items():
            grids[k] = _spread(grids[k], total)
        for k, anew in zip(again, _errors(error, [grids[k] for k in again])):
            errors[k] = anew
    return np.concatenate([grids[0], *(phi[1:] for phi in grids[1:])]), np.concatenate(errors)


def steps_about(error: Callable[[Floats], Floats], pieces: Sequence[tuple[float, float]], tolerance: float) -> int:
    """About how many steps `even_steps` takes."""
    errors = _errors(error, [np.linspace(low, high, FEWEST + 1) for low, high in pieces])
    return sum(int(np.ceil(_steps_needed(e, EVEN * tolerance)[-1])) for e in errors)


def subdivided(phi: Floats, parts: Index) -> Floats:
    """Every interval of phi cut into so many equal parts."""
    first = np.repeat(np.cumsum(parts) - parts, parts)
    share = (np.arange(parts.sum()) - first) / np.repeat(parts, parts)
    return np.append(np.repeat(phi[:-1], parts) + share * np.repeat(np.diff(phi), parts), phi[-1])


def _errors(error: Callable[[Floats], Floats], grids: list[Floats]) -> list[Floats]:
    """The error of every step of several grids, in one call; what lies between two grids does not count."""
    cuts = np.cumsum([len(grid) for grid in grids])[:-1]
    parts = np.split(error(np.concatenate(grids)), cuts)
    return [part[: len(grid) - 1] for part, grid in zip(parts, grids)]


def _steps_needed(error: Floats, aim: float) -> Floats:
    """Number of steps needed from the first parameter up to each, (n + 1,)."""
    need = np.maximum(np.sqrt(error / aim), 1e-3)
    # A step beside one that bends more sharply is cut as if it bent nearly as much.
    smooth = np.maximum(need, 0.5 * (np.r_[need[1:], need[-1]] + np.r_[need[0], need[:-1]]))
    return np.concatenate([[0.0], np.cumsum(smooth)])


def _spread(phi: Floats, total: Floats) -> Floats:
    """New parameters at equal shares of the steps needed."""
    count = max(1, int(np.ceil(total[-1])))
    spread = np.interp(np.linspace(0.0, total[-1], count + 1), total, phi)
    spread[[0, -1]] = phi[[0, -1]]
    return np.asarray(spread)
