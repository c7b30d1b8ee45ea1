"""The cheapest method and step for a tolerance, from the modes of the system, the force on them and each method's
phase error.

A mode of frequency w (rad per rad of cam angle) turns through w L radians in a period of length L; a method of order
p adds d (w h)^p to the phase of each. The error is that times the share of the mode in the answer. A stiff mode
follows the force quasi-statically, its share falls with how sharp the force is against w: so a coarse step with many
stages is safe. The prediction only decides the cost; the error that counts is measured by halving.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from camgeom.dynamics.linear.method import Method, System
from camgeom.errors import NotConverged
from camgeom.maths import Floats

PROBES = 97
STRIDE = 12
LADDER = 2.0 ** np.arange(2.0, 20.01, 0.25)
"""steps a turn that are considered"""
OVERHEAD_US = 250.0
"""cost of a walk that does not depend on its steps"""
SATURATED = 1.0


@dataclass(frozen=True, eq=False)
class Modal:
    """What a choice needs, each (b, m): frequencies in rad per rad, shares of the modes in the answer, radians
    remembered.

    length of the period in rad; sharpness of the force, the largest change per rad over the largest value.
    """

    frequency: Floats
    share: Floats
    memory: Floats
    length: float
    sharpness: float


def modal(system: System, knots: Floats) -> Modal:
    """Modes of a system looked at round the turn, each with the share that the strongest force gives it."""
    length = float(knots[-1] - knots[0])
    # the odd offset keeps the probes off the knots
    theta = (knots[0] + length * (np.arange(PROBES) + 0.37) / PROBES)[None, :]
    here = system.coefficients(theta)
    force = np.broadcast_to(here.force, (system.batch, PROBES, system.size))
    strongest = np.take_along_axis(force, np.abs(force).max(-1).argmax(1)[:, None, None], 1)[:, 0]
    scale = np.maximum(np.abs(strongest).max(-1), 1e-300)
    sharpness = float((np.abs(np.diff(force, axis=1)).max(axis=(1, 2)) * PROBES / length / scale).max(initial=1.0))
    stiffness = np.broadcast_to(here.stiffness, (system.batch, *here.stiffness.shape[1:]))
    damping = np.broadcast_to(here.damping, (system.batch, *here.damping.shape[1:]))
    values, vectors = np.linalg.eig(stiffness[:, ::STRIDE])
    inverse = np.linalg.inv(vectors)
    decay = (
        np.abs(np.einsum("bnij,bnjk,bnki->bni", inverse, damping[:, :: STRIDE if damping.shape[1] > 1 else 1], vectors))
        / 2.0
    )
    frequency = np.maximum(np.sqrt(np.abs(values)), 1e-9)
    part = np.abs(vectors * (inverse @ strongest[:, None, :, None])[..., 0][..., None, :]).max(-2) / frequency**2
    share = part / np.maximum(part.max(-1, keepdims=True), 1e-300) * np.minimum(1.0, sharpness / frequency)
    # undamped modes remember the whole period, damped ones frequency/decay radians
    memory = frequency * np.minimum(length, 1.0 / np.maximum(decay, 1e-12))
    b = system.batch
    return Modal(
        frequency.reshape(b, -1), np.maximum(share, 1e-9).reshape(b, -1), memory.reshape(b, -1), length, sharpness
    )


def predicted_error(method: Method, known: Modal) -> Floats:
    """Predicted error (b, LADDER) of a method, a share of the peak."""
    h = known.length / LADDER
    phase = known.frequency[:, :, None] * h
    with np.errstate(over="ignore"):
        each = known.memory[:, :, None] * method.dispersion * np.minimum(phase, 1e12) ** method.order
    error = (known.share[:, :, None] * np.minimum(SATURATED, each)).max(1)
    # the force itself must be resolved as well
    error = error + method.dispersion * known.sharpness * known.length * (known.sharpness * h) ** method.order
    if np.isfinite(method.stability):
        error = np.where(phase.max(1) > method.stability, np.inf, error)
    return np.asarray(error)


def steps_for(method: Method, known: Modal, tolerance: float) -> tuple[Floats, Floats]:
    """Steps a turn (b,) a method should need for a tolerance, and its cost (b,) in microseconds; infinity when none
    does.
    """
    good = predicted_error(method, known) <= tolerance
    first = np.where(good.any(-1), good.argmax(-1), 0)
    steps = np.where(good.any(-1), LADDER[first], np.inf)
    return steps, OVERHEAD_US + method.cost_us * steps


def choose(system: System, knots: Floats, tolerance: float, pool: Sequence[Method]) -> tuple[list[Method], Floats]:
    """For each speed the method of the pool that is cheapest by prediction, and the steps a turn (b,) to begin with.

    Raises NotConverged when no step on the ladder is predicted to do.
    """
    known = modal(system, knots)
    steps, cost = (np.stack(rows) for rows in zip(*(steps_for(one, known, tolerance) for one in pool), strict=True))
    best = cost.argmin(0)
    chosen = np.take_along_axis(steps, best[None], 0)[0]
    if not np.isfinite(chosen).all():
        worst = int(np.argmax(~np.isfinite(chosen)))
        highest = float(known.frequency[worst].max())
        raise NotConverged(
            f"tolerance {tolerance:g} would need more than {int(LADDER[-1])} steps a turn with "
            f"{pool[best[worst]].name}: the highest mode turns {highest:.3g} times as fast as the cam; "
            "use auto or gauss4, or a larger tolerance"
        )
    return [pool[k] for k in best], chosen


def cheapest(system: System, knots: Floats, tolerance: float, pool: Sequence[Method]) -> Method:
    """The method of the pool that is cheapest by prediction over all speeds together."""
    known = modal(system, knots)
    total = [float(steps_for(one, known, tolerance)[1].sum()) for one in pool]
    return pool[int(np.argmin(total))]
