"""Roller on cam over one turn: the squared peak pressure of either wall, from which stress peaks and lives follow.

The square of the peak pressure of a line contact, w k_rel / (pi compliance), is a smooth function of the cam angle,
also where the load changes walls: it is kept with the sign of the load, positive where that wall is loaded.
Along the roller the load is shared by slices that approach alike, with crowning, misalignment and changing pressure
angle: there the last axis m is that of the slices. Units N, mm, MPa.
"""

from __future__ import annotations

from typing import final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camgeom.errors import NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.maths.panels import Panels, highest
from camgeom.mechanics.hertz import line_flexibility, line_pressure
from camgeom.mechanics.material import Material

TOLERANCE = 1e-12
"""change of a slice's load, share of the mean one, at which the sharing has settled"""
STEPS = 200


@final
@immutable(eq=True)
class Stiffness:
    """Of a contact along its normal, N/mm: tangent for small vibration, secant from no load."""

    tangent: float
    secant: float


@final
@immutable
class Contact:
    """Contact of one roller with its two walls over one turn.

    normal: signed normal force, N, positive on the wall behind; behind, ahead: squared peak pressure of that wall,
    MPa², positive where it is loaded; path_rate: path rolled per cam angle, mm/rad; all (..., p, n). sound: (...) False
    where the roller undercuts, anywhere, a wall that it loads: there both squares are 0 and no stress can be given.
    """

    panels: Panels
    normal: Floats
    behind: Floats
    ahead: Floats
    path_rate: Floats
    sound: NDArray[np.bool_]

    @cached_property
    def pressure(self) -> Floats:
        """Peak pressure of the loaded wall at the sample points, MPa, (..., p, n)."""
        return np.asarray(np.sqrt(np.maximum(np.maximum(self.behind, self.ahead), 0.0)))

    def peak(self) -> PressurePeak:
        """Largest peak pressure over the turn and where; infinite for a variant that is not sound."""
        value = np.stack([self.behind, self.ahead])
        square, angle = highest(self.panels, value)
        wall = np.argmax(square, axis=0)
        best = np.take_along_axis(square, wall[None], axis=0)[0]
        where = np.take_along_axis(angle, wall[None], axis=0)[0]
        pressure = np.where(self.sound, np.sqrt(np.maximum(best, 0.0)), np.inf)
        return PressurePeak(np.asarray(pressure), np.asarray(where), np.asarray(1 - 2 * wall))


@final
@immutable
class PressurePeak:
    """Largest peak pressure, MPa, its cam angle, rad, and its wall (1 behind, -1 ahead); each (...)."""

    pressure: Floats
    theta: Floats
    wall: NDArray[np.intp]


def line_contacts(where: Panels, normal: ArrayLike, behind: ArrayLike, ahead: ArrayLike, path_rate: ArrayLike,
                  length: ArrayLike, compliance: ArrayLike,
                  margins: tuple[ArrayLike, ArrayLike] | None = None) -> Contact:
    """Contact from signed normal force (N), relative curvatures of both walls (1/mm) and path rate (mm/rad).

    Arrays (..., p, n); length of contact (mm) and compliance (1/MPa) broadcast as they are, so variants of them are
    (..., 1, 1). To follow slices along the roller, give the slice's force and length on a leading axis of stations m.
    margins: undercut margins of both walls (1), smooth where the curvature has a pole; without them the curvature's
    sign at the sample points decides whether the roller fits.
    """
    force = np.asarray(normal, dtype=np.float64)
    near, far = np.asarray(behind, dtype=np.float64), np.asarray(ahead, dtype=np.float64)
    scale = force / (np.asarray(length, dtype=np.float64) * np.pi * np.asarray(compliance, dtype=np.float64))
    sound = _free(near, force > 0.0) & _free(far, force < 0.0)
    if margins is not None:
        one, two = (np.asarray(margin, dtype=np.float64) for margin in margins)
        sound = sound & _free(-highest(where, -one)[0][..., None, None], force > 0.0)
        sound = sound & _free(-highest(where, -two)[0][..., None, None], force < 0.0)
    good = sound[..., None, None]
    one, two, rate, good = np.broadcast_arrays(scale * near, -scale * far,
                                               np.asarray(path_rate, dtype=np.float64), good)
    sound = np.broadcast_to(sound, one.shape[:-2])
    return Contact(where, np.broadcast_to(force, one.shape), np.where(good, one, 0.0), np.where(good, two, 0.0), rate,
                   sound)


def _free(margin: Floats, loaded: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whether a wall has positive margins (..., p, n) all round, or never carries a load: (...)."""
    return np.asarray((margin > 0.0).all(axis=(-1, -2)) | ~loaded.any(axis=(-1, -2)))


@final
@immutable
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


def share_load(force: ArrayLike, stations: ArrayLike, widths: ArrayLike, curvature: ArrayLike, roller: Material,
               cam: Material, radius: ArrayLike, depth: ArrayLike, gaps: ArrayLike = 0.0, tilt: ArrayLike = 0.0,
               cosines: ArrayLike = 1.0) -> SliceLoads:
    """Load of every slice such that all approach alike and together carry the force.

    force: N along the follower's direction, (...); stations, widths: mm, (m,), a width of 0 of a place that bears a
    load per length as the rest and no force; curvature: relative, 1/mm, (..., m);
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
    base, stiff = start[..., :1], np.cumsum(hard, axis=-1)
    carried = total[..., None] + np.cumsum(hard * (start - base), axis=-1)
    reach = np.divide(carried, stiff, out=np.full_like(carried, np.inf), where=stiff > 0.0)
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
