"""How far a law exceeds its limits of vibration and velocity, and the rows that would keep them."""

from __future__ import annotations

import numpy as np

from camgeom.maths import Floats
from camgeom.motion.optimal.shape import Shape, residual_peaks
from camgeom.motion.optimal.wish import Task

KEPT = 8e-10
"""relative; how far a limit may be exceeded while tangents are still added"""
LITTLE, ENOUGH = 1e-3, 1e-6
"""a residual that is sought is found to this share of itself, or of a thousandth of the lift"""


def kept(task: Task) -> float:
    """The relative excess at which limits count as kept; a residual that is itself sought is measured in the end."""
    return ENOUGH if task.residual.slope else KEPT


def excess(
    task: Task, shape: Shape, value: float, counted: float | None = None
) -> tuple[float, tuple[Floats, Floats, Floats, bool]]:
    """How far (relative) vibration and velocity exceed their limits, and the cuts that would keep them: n, angle,
    places, whether the velocity dips. The velocity's excess counts so many times, by default as much more as its limit
    is kept more exactly."""
    wish, none = task.wish, np.empty(0)
    worst, n, angle, places, dips = 0.0, none, none, none, False
    if wish.band is not None and task.residual.asked:
        peaks, z = residual_peaks(shape, wish.band, wish.damping)
        limit = task.residual.at(value)
        over = np.abs(z) - limit
        # A limit that is itself sought need not be met to the last digit: the law's own residual is what counts.
        size = max(limit, LITTLE) if task.residual.slope else limit
        worst = max(worst, float(over.max() / size))
        near = over > 0.1 * kept(task) * size
        n, angle = peaks[near], np.angle(z[near])
    if task.velocity.asked or wish.monotone:
        at, v = shape.velocities(wish.start[0])
        limit = task.velocity.at(value) if task.velocity.asked else np.inf
        below = -v if wish.monotone else -v - limit
        over = np.maximum(v - limit, below)
        counted = kept(task) / KEPT if counted is None else counted
        worst = max(worst, counted * float(over.max() / (limit if task.velocity.asked else 1.0)))
        inner = len(shape.x)
        places, dips = at[inner:][over[inner:] > 0.1 * KEPT], bool(below.max() > 0.1 * KEPT)
    return worst, (n, angle, places, dips)
