"""How exact: the one place where a wanted tolerance becomes a number of steps, and then a verified solution.

The steps to begin with are predicted. A mode of frequency w (rad per rad of cam angle) turns through w L radians in a
period of length L; a method of order p adds d (w h)^p to the phase of each. The error is that times the share of the
mode in the answer. A stiff mode follows the force quasi-statically, its share falls with how sharp the force is
against w: so a coarse step with many stages is safe. The prediction only decides the cost; the error that counts is
measured by halving.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from camgeom.dynamics.linear.budget import (
    MOST_BYTES,
    MOST_SECONDS,
    MOST_SWEEP_SECONDS,
    MOST_TOGETHER,
    refuse_costly,
)
from camgeom.dynamics.linear.method import Method, System, find
from camgeom.dynamics.linear.solve import Growing, Solution
from camgeom.dynamics.linear.walk import MAX_STEPS, TurnGrid, aligned_grid
from camgeom.errors import NotConverged, Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import Floats

PROBES = 97
"""cam angles at which forces and modes are looked at to predict a step"""
STRIDE = 12
"""of the probes, those at which the modes are looked at"""
LADDER = 2.0 ** np.arange(2.0, 20.01, 0.25)
"""steps a turn that are considered"""
SATURATED = 1.0
SAME_GROWTH = 0.05
"""share by which the growth found on two grids may differ and still be the growth of the drive"""
Once = Callable[[TurnGrid, Method], Solution]
"""A solution on a grid by a method."""
Watch = Callable[[Solution], Floats]
"""What must be accurate: values (b, n + 1, k) on the nodes of a solution."""


@immutable(eq=True)
class Accuracy:
    """Tolerance as a share of the peak, checked by halving the step; method by name, "auto" for gauss8.

    `steps` fixes the steps a turn instead: then the error is measured by halving, whatever it is. `runs`: solutions
    like this one that are wanted, which have bytes and the seconds `together` in common; `sweep`: s of a sweep.
    """

    tolerance: float = 1e-6
    method: str | Method = "auto"
    steps: int | None = None
    runs: int = 1
    together: float = MOST_TOGETHER
    sweep: float = MOST_SWEEP_SECONDS

    def __post_init__(self) -> None:
        problems = []
        if not 1e-13 <= self.tolerance <= 0.1:
            problems.append(Problem("dynamics.tolerance", "out of range", self.tolerance, "1e-13 to 0.1"))
        if self.steps is not None and not 1 <= self.steps <= MAX_STEPS:
            problems.append(Problem("dynamics.steps", "out of range", self.steps, f"1 to {MAX_STEPS}"))
        if problems:
            raise ProfileError(problems)
        find(self.method)

    def refuse_costly(self, system: System, method: Method, steps: float) -> None:
        """Raise NotConverged where so many steps of one of them would take too long or too much memory."""
        most = min(MOST_SECONDS, self.together / self.runs)
        refuse_costly(system, method, steps, most, self.runs, MOST_BYTES / self.runs)


STANDARD = Accuracy()
"""1e-6 of the peak"""


def watch_position(solution: Solution) -> Floats:
    """The coordinates themselves (b, n + 1, m)."""
    return solution.position


def solved(system: System, knots: Floats, accuracy: Accuracy, once: Once, watch: Watch = watch_position) -> Solution:
    """A solution verified by halving, or one of the given steps with its error; one grid for all speeds."""
    method = find(accuracy.method)
    if accuracy.steps is not None:
        accuracy.refuse_costly(system, method, accuracy.steps * system.batch)
        return measured(lambda g: once(g, method), aligned_grid(knots, accuracy.steps), watch)
    steps = predicted_steps(system, knots, accuracy.tolerance, method)
    grid = aligned_grid(knots, round(float(steps.max())))
    accuracy.refuse_costly(system, method, 2 * grid.steps * system.batch)
    return verified(affordable(system, method, once, accuracy), grid, accuracy.tolerance, watch)


def affordable(
    system: System, method: Method, once: Once, accuracy: Accuracy = STANDARD
) -> Callable[[TurnGrid], Solution]:
    """Solutions on the grids that are affordable; NotConverged, with the cost, for the others."""

    def solve(grid: TurnGrid) -> Solution:
        accuracy.refuse_costly(system, method, grid.steps * system.batch)
        return once(grid, method)

    return solve


def predicted_steps(system: System, knots: Floats, tolerance: float, method: Method) -> Floats:
    """Steps a turn (b,) that a method should need for a tolerance, at each speed.

    Raises NotConverged when no step on the ladder is predicted to do.
    """
    known = _modal(system, knots)
    h = known.length / LADDER
    phase = np.minimum(known.frequency[:, :, None] * h, 1e12)
    with np.errstate(over="ignore"):
        each = known.memory[:, :, None] * method.dispersion * phase**method.order
    error = (known.share[:, :, None] * np.minimum(SATURATED, each)).max(1)
    # the force itself must be resolved as well
    error = error + method.dispersion * known.sharpness * known.length * (known.sharpness * h) ** method.order
    good = error <= tolerance
    if not good.any(-1).all():
        worst = int(np.argmin(good.any(-1)))
        raise NotConverged(
            f"tolerance {tolerance:g} would need more than {int(LADDER[-1])} steps a turn with {method.name}: the "
            f"highest mode turns {float(known.frequency[worst].max()):.3g} times as fast as the cam; use auto, or a "
            "larger tolerance"
        )
    return np.asarray(LADDER[good.argmax(-1)])


@immutable
class Modal:
    """What a prediction needs, each (b, m): frequencies in rad per rad, shares of the modes in the answer, radians
    remembered.

    length of the period in rad; sharpness of the force, the largest change per rad over the largest value.
    """

    frequency: Floats
    share: Floats
    memory: Floats
    length: float
    sharpness: float


def _modal(system: System, knots: Floats) -> Modal:
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


def verified(
    solve: Callable[[TurnGrid], Solution],
    grid: TurnGrid,
    tolerance: float,
    watch: Watch = watch_position,
    max_steps: int = MAX_STEPS,
) -> Solution:
    """The solution whose watched values changed by less than `tolerance` of their peak when the step was halved.

    Doubles the steps until then; raises NotConverged when rounding or `max_steps` comes first, with the error reached.
    """
    coarse: Solution | None = None
    reached, stalled, growth = np.inf, 0, np.inf
    while grid.steps <= max_steps:
        try:
            fine = solve(grid)
        except Growing as refusal:
            # growth that two grids agree on is the drive's own
            if 2 * grid.steps > max_steps or abs(refusal.radius - growth) < SAME_GROWTH * (refusal.radius - 1.0):
                raise
            coarse, grid, growth = None, grid.halved(), refusal.radius
            continue
        if coarse is not None:
            error = _difference(coarse, fine, watch)
            worst = float(error.max())
            if worst <= tolerance:
                text = f"{fine.method.name}, {fine.grid.steps} steps a turn, error {worst:.1e} of the peak by halving"
                return replace(fine, error=error, choice=text)
            stalled = stalled + 1 if worst > 0.7 * reached and worst < 1e-6 else 0
            if stalled == 2:
                raise NotConverged(
                    f"{fine.method.name}: the error no longer falls below {worst:.1e} of the peak (rounding, or a "
                    "motion with sharp corners); ask for a tolerance above it"
                )
            reached = worst
        coarse, grid = fine, grid.halved()
    raise NotConverged(
        f"tolerance {tolerance:g} not met with {max_steps} steps a turn (error {reached:.1e} of the peak); "
        "use auto, or a larger tolerance"
    )


def measured(solve: Callable[[TurnGrid], Solution], grid: TurnGrid, watch: Watch = watch_position) -> Solution:
    """The solution on a grid as it is, with what half the step changes in it; infinity where that has no answer."""
    found = solve(grid)
    if 2 * grid.steps > MAX_STEPS:
        return found
    try:
        error = _difference(found, solve(grid.halved()), watch)
    except NotConverged:
        return found
    text = f"{found.method.name}, {grid.steps} steps a turn as given, error {error.max():.1e} of the peak by halving"
    return replace(found, error=error, choice=text)


def _difference(coarse: Solution, fine: Solution, watch: Watch) -> Floats:
    """Change (b,) of the watched values at common cam angles when the step was halved, a share of their peak."""
    a, b = watch(coarse), watch(fine)
    gap = np.abs(b[:, ::2] - a).max(1)
    peak = np.abs(b).max(1)
    share = np.divide(gap, peak, out=np.where(gap > 0.0, np.inf, 0.0), where=peak > 0.0)
    return np.asarray(share.max(-1))
