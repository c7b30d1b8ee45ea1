"""Load along the roller: slices that approach alike, with crowning, misalignment and changing pressure angle.

Last axis m: stations (slices) along the roller. Units N, mm, MPa.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from camgeom.errors import NotConverged
from camgeom.maths import Floats
from camgeom.mechanics.hertz import line_flexibility, line_pressure
from camgeom.mechanics.material import Material

TOLERANCE = 1e-12
STEPS = 200


@final
@dataclass(frozen=True, eq=False)
class SliceLoads:
    """Load along the roller: line_load N/mm and pressure MPa (..., m); approach mm and mean station mm (...).

    approach: of roller and cam along the force; centre: station at which the resultant acts.
    """

    line_load: Floats
    pressure: Floats
    approach: Floats
    centre: Floats


def uniform_slices(force: ArrayLike, widths: ArrayLike, cosines: ArrayLike = 1.0) -> Floats:
    """Line load, N/mm, (..., m), alike in every slice: F / sum(width cos); force N, (...), widths mm, (m,)."""
    w, c = np.broadcast_arrays(np.asarray(widths, dtype=np.float64), np.asarray(cosines, dtype=np.float64))
    total = np.asarray(force, dtype=np.float64)[..., None]
    return np.asarray(total / (w * c).sum(axis=-1, keepdims=True) * np.ones_like(w))


def crown_gaps(stations: ArrayLike, arc: ArrayLike, centre: ArrayLike = 0.0) -> Floats:
    """Gap, mm, of a roller crowned to the radius `arc` (mm) at each station (mm): arc - sqrt(arc² - (x - centre)²).

    Raises ValueError where a station lies beyond the arc.
    """
    x = np.asarray(stations, dtype=np.float64) - np.asarray(centre, dtype=np.float64)
    radius = np.asarray(arc, dtype=np.float64)
    if np.any(np.abs(x) > radius):
        raise ValueError("a station lies beyond the crown's arc")
    return np.asarray(x * (x / (radius + np.sqrt((radius - x) * (radius + x)))))


def share_load(force: ArrayLike, stations: ArrayLike, widths: ArrayLike, curvature: ArrayLike, roller: Material,
               cam: Material, radius: ArrayLike, depth: ArrayLike, gaps: ArrayLike = 0.0, tilt: ArrayLike = 0.0,
               cosines: ArrayLike = 1.0) -> SliceLoads:
    """Load of every slice such that all approach alike and together carry the force.

    force: N along the follower's direction, (...); stations, widths: mm, (m,); curvature: relative, 1/mm, (..., m);
    radius: roller radius mm; depth: to which the cam body yields, mm; gaps: separation of the unloaded profiles
    (crowning) mm, (..., m); tilt: misalignment, rad, (...); cosines: of the pressure angle per slice, (..., m).
    Slice i approaches by d cos_i - gap_i - tilt x_i, and carries approach over the flexibility of its line contact,
    which hangs on the load by a logarithm only: solved exactly for fixed flexibilities and repeated until they stand.
    Raises NotConverged where that does not settle, DesignError where the contact is wider than the roller.
    """
    x, w = np.asarray(stations, dtype=np.float64), np.asarray(widths, dtype=np.float64)
    total = np.asarray(force, dtype=np.float64)
    slope = np.asarray(tilt, dtype=np.float64)[..., None]
    k, gap, cos, _ = np.broadcast_arrays(np.asarray(curvature, dtype=np.float64),
                                         np.asarray(gaps, dtype=np.float64) + slope * x,
                                         np.asarray(cosines, dtype=np.float64), total[..., None] + 0.0 * x)
    if np.any(total < 0.0):
        raise ValueError("the force that presses roller and cam together cannot be negative")
    r, d = np.asarray(radius, dtype=np.float64), np.asarray(depth, dtype=np.float64)
    mean = uniform_slices(np.broadcast_to(total, k.shape[:-1]), w, cos)
    load = mean
    # A slice without load gets the flexibility of a nearly unloaded one, so that it can come back into contact.
    least = np.maximum(mean * 1e-6, 1e-30)
    for _ in range(STEPS):
        soft = line_flexibility(np.maximum(load, least), k, roller, cam, r, d)
        base, reach = _approach(total, w * cos / soft, cos, gap)
        new = cos * np.maximum(reach - (gap / cos - base), 0.0) / soft
        done = bool(np.all(np.abs(new - load) <= TOLERANCE * mean))
        load = new
        if done:
            return _result(load, (base + reach)[..., 0], x, w * cos, k, roller.compliance + cam.compliance)
    raise NotConverged("the load along the roller did not settle: check crowning and misalignment against the load")


def _approach(total: Floats, stiffness: Floats, cosines: Floats, gap: Floats) -> tuple[Floats, Floats]:
    """Approach d with sum stiffness max(d cos - gap, 0) = total: piecewise linear, solved exactly by sorting.

    Given as the approach of the first touch and the rest beyond it, (..., 1) each: their sum would lose a small rest.
    """
    touch = gap / cosines
    order = np.argsort(touch, axis=-1)
    hard = np.take_along_axis(stiffness * cosines, order, axis=-1)
    start = np.take_along_axis(touch, order, axis=-1)
    # With the first j slices in contact d = (total + sum hard start) / sum hard, if that does not reach slice j + 1.
    base = start[..., :1]
    reach = (total[..., None] + np.cumsum(hard * (start - base), axis=-1)) / np.cumsum(hard, axis=-1)
    following = np.concatenate([start[..., 1:] - base, np.full((*start.shape[:-1], 1), np.inf)], axis=-1)
    first = np.argmax(reach <= following, axis=-1)[..., None]
    return base, np.asarray(np.take_along_axis(reach, first, axis=-1))


def _result(
    load: Floats, reach: Floats, stations: Floats, weights: Floats, curvature: Floats, pair: float
) -> SliceLoads:
    carried = load * weights
    total = carried.sum(axis=-1)
    centre = np.divide((carried * stations).sum(axis=-1), total, out=np.zeros_like(total), where=total > 0.0)
    return SliceLoads(load, line_pressure(load, curvature, pair), reach, centre)
