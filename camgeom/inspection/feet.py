"""Exact foot points on the flanks of a cam: where the normal through a given point meets the flank.

Seeds come from a tree of sampled points (scipy), feet by Newton steps on both parameters with exact second derivatives.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.model.surfaces import MeasuredSurface
from camgeom.track import TURN

if TYPE_CHECKING:
    from collections.abc import Callable

Ints = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]

PER_TURN, ACROSS = 720, 7
ROUNDS, ROUGH_ROUNDS = 40, 8
"""Newton steps at most: for the result, and while a place is looked for"""
STEP = 0.2
"""rad; longest Newton step in phi"""
SETTLED = 1e-12
"""share of the parameters' ranges below which a step ends the iteration"""


@immutable
class Feet:
    """Feet of points (n,): flank number, parameters, foot x and outward normal n (3, n), signed distance (n,) in mm.

    beside  (n,) by how far the foot is from being one, mm: 0 where the normal meets the flank, else along its edge
    """

    surface: Ints
    phi: Floats
    t: Floats
    x: Floats
    n: Floats
    distance: Floats
    beside: Floats


@immutable
class Target:
    """The flanks to measure against, with the seeds of the search."""

    surfaces: tuple[MeasuredSurface, ...]
    seeds: tuple[Any, ...]
    grids: tuple[tuple[Floats, Floats], ...]

    @classmethod
    def of(cls, surfaces: tuple[MeasuredSurface, ...], within: Callable[[Floats], Floats]) -> Target:
        """Sampled once; points outside the blank are no seeds."""
        from scipy.spatial import cKDTree

        trees, grids = [], []
        for surface in surfaces:
            low, high = surface.span
            count = max(9, round(PER_TURN * (high - low) / TURN))
            hair = 1e-9 * (high - low)
            angles, stations = np.linspace(low + hair, high - hair, count), np.linspace(*surface.wall, ACROSS)
            phi, t = np.repeat(angles, ACROSS), np.tile(stations, count)
            x = surface.at(phi, t).x
            kept = within(x) >= 0.0
            trees.append(cKDTree(x[:, kept].T))
            grids.append((phi[kept], t[kept]))
        return cls(surfaces, tuple(trees), tuple(grids))

    def rough(self, points: Floats, radius: float) -> Floats:
        """About how far points (3, n) are off the flanks at the probe's radius, (n,) mm: from the sampled points."""
        every = np.stack([np.abs(tree.query(points.T)[0] - radius) for tree in self.seeds])
        return np.asarray(every.min(axis=0))

    def feet(
        self, points: Floats, radius: float, allowed: Mask, last: Feet | None = None, rounds: int = ROUNDS
    ) -> Feet:
        """Feet of points (3, n), each on the flank whose distance is nearest to the probe's radius, mm.

        allowed  (n, s): the flanks that a point may belong to; `last`: feet of nearly the same points, to start from;
        rounds: Newton steps at most
        """
        n = points.shape[1]
        zero, far = np.zeros((5, n)), np.full((2, n), np.inf)
        best = Feet(np.zeros(n, dtype=np.int64), zero[0], zero[1], np.zeros((3, n)), zero[2:], far[0], far[1])
        score = np.full(n, np.inf)
        for number, surface in enumerate(self.surfaces):
            here = np.flatnonzero(allowed[:, number] & (True if last is None else last.surface == number))
            if not len(here):
                continue
            if last is None:
                nearest = self.seeds[number].query(points[:, here].T)[1]
                start = self.grids[number][0][nearest], self.grids[number][1][nearest]
            else:
                start = last.phi[here], last.t[here]
            found = _feet(surface, number, points[:, here], *start, rounds)
            error = np.abs(found.distance - radius) + found.beside
            better = error < score[here]
            into = here[better]
            score[into] = error[better]
            for name in ("surface", "phi", "t", "x", "n", "distance", "beside"):
                getattr(best, name)[..., into] = getattr(found, name)[..., better]
        return best


def _feet(surface: MeasuredSurface, number: int, points: Floats, phi: Floats, t: Floats, rounds: int) -> Feet:
    """Feet on one flank by Newton steps from (phi, t), kept within the flank's parameters."""
    (low, high), (bottom, top) = surface.span, surface.wall
    wide, tall = high - low, top - bottom
    open_ = not surface.closed
    phi, t = phi.copy(), t.copy()
    left = np.arange(len(phi))
    for _ in range(rounds):
        patch = surface.at(phi[left], t[left])
        d_phi, d_t = _newton(patch, points[:, left] - patch.x)
        share = np.minimum(1.0, STEP / np.maximum(np.abs(d_phi), 1e-300))
        share = np.minimum(share, 0.5 * tall / np.maximum(np.abs(d_t), 1e-300))
        new_phi, new_t = phi[left] + share * d_phi, np.clip(t[left] + share * d_t, bottom, top)
        if open_:
            new_phi = np.clip(new_phi, low, high)
        moved = np.maximum(np.abs(new_phi - phi[left]) / wide, np.abs(new_t - t[left]) / tall)
        phi[left], t[left] = new_phi, new_t
        left = left[moved > SETTLED]
        if not len(left):
            break
    patch = surface.at(phi, t)
    gap = points - patch.x
    distance = (gap * patch.n).sum(axis=0)
    aside = gap - distance * patch.n
    beside = np.sqrt((aside * aside).sum(axis=0))
    return Feet(np.full(len(phi), number, dtype=np.int64), phi, t, patch.x, patch.n, distance, beside)


def _newton(patch: Any, gap: Floats) -> tuple[Floats, Floats]:
    """Newton step of half the squared distance; where its matrix is not positive, the Gauss-Newton step."""
    a, b = patch.by_phi, patch.by_t
    height = (gap * patch.n).sum(axis=0)
    ee, ff, gg = ((p * q).sum(axis=0) for p, q in ((a, a), (a, b), (b, b)))
    e, f, g = (m - height * s for m, s in zip((ee, ff, gg), patch.second))
    det = e * g - f * f
    bad = (e <= 0.0) | (det <= 1e-6 * ee * gg)
    e, f, g = (np.where(bad, plain, full) for plain, full in ((ee, e), (ff, f), (gg, g)))
    det = np.maximum(e * g - f * f, 1e-300)
    ra, rb = (gap * a).sum(axis=0), (gap * b).sum(axis=0)
    return (g * ra - f * rb) / det, (e * rb - f * ra) / det
