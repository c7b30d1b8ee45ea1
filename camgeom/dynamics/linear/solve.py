"""Transients and periodic steady states of a linear periodic system, with the error measured by halving the step."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from camgeom.dynamics.linear.exact import exact_periodic, exact_transient
from camgeom.dynamics.linear.method import Method, StepTooLong, System, find
from camgeom.dynamics.linear.solution import Growing, Solution, acceleration, closing_state, turn_after_turn
from camgeom.dynamics.linear.walk import MAX_STEPS, Grid, Walk
from camgeom.errors import NotConverged
from camgeom.maths import Floats

SAME_GROWTH = 0.05
"""share by which the growth found on two grids may differ and still be the growth of the drive"""
PROBES = 73
"""cam angles at which frequencies are looked at to choose and to vet a step"""


def periodic(system: System, grid: Grid, method: str | Method) -> Solution:
    """The periodic steady state on a grid, y0 = (I - Phi)^-1 p, without any transient.

    Raises NotConverged for a growing turn (step too long for the method, or parametric instability) and for a resonance
    without damping; the text says which, at which speed index, and what would help.
    """
    method = find(method)
    vet(system, grid, method)
    if not system.linear:
        return exact_periodic(system, grid, method)
    walk = Walk(method, system, grid)
    total = walk.period()
    radius = np.abs(np.linalg.eigvals(total[..., :-1])).max(-1)
    state = walk.states(closing_state(system, grid, method, total, radius))
    return Solution(system, method, grid, grid.theta, state, radius, np.full(system.batch, np.inf), "")


def transient(
    system: System, grid: Grid, method: str | Method, begin: Floats | None = None, turns: int = 1
) -> Solution:
    """The motion over `turns` turns from the state begin (b, 2m) of q, q' at the grid's first angle; rest when not
    given.

    Raises NotConverged when the step is too long for an explicit method or the motion grows past every bound.
    """
    method = find(method)
    vet(system, grid, method)
    if not system.linear:
        return exact_transient(system, grid, method, begin, turns)
    walk = Walk(method, system, grid)
    state = np.zeros((system.batch, walk.size))
    if begin is not None:
        state[:, : 2 * system.size] = begin
    if method.rows == 3:
        here = grid.theta[None, :1]
        m = system.size
        # the limit from the left: the renewal at the first knot then brings the limit from the right
        state[:, 2 * m :] = acceleration(system, here, state[:, None, :m], state[:, None, m : 2 * m], "left")[:, 0]
    part, total = walk.run(state)
    parts = [part]
    for _ in range(1, turns):
        parts.append(walk.states(parts[-1][:, -1])[:, 1:])
    out = np.concatenate(parts, 1)
    if not np.isfinite(out).all():
        raise NotConverged(
            f"{method.name}: the motion grows without bound within {turns} turns; see the spectral radius"
        )
    theta = turn_after_turn(grid, turns)
    radius = np.abs(np.linalg.eigvals(total[..., :-1])).max(-1)
    return Solution(system, method, grid, theta, out, radius, np.full(system.batch, np.inf), "")


Watch = Callable[[Solution], Floats]
"""What must be accurate: values (b, n + 1, k) on the nodes of a solution."""


def watch_position(solution: Solution) -> Floats:
    """The coordinates themselves (b, n + 1, m)."""
    return solution.position


def verified(
    solve: Callable[[Grid], Solution],
    grid: Grid,
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
        except (StepTooLong, Growing) as refusal:
            # growth that two grids agree on is the drive's own
            rate = refusal.radius if isinstance(refusal, Growing) else np.inf
            if 2 * grid.steps > max_steps or abs(rate - growth) < SAME_GROWTH * (rate - 1.0):
                raise
            coarse, grid, growth = None, grid.halved(), rate
            continue
        if coarse is not None:
            error = difference(coarse, fine, watch)
            worst = float(error.max())
            if worst <= tolerance:
                return _replace_error(fine, error)
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
        "use gauss4 or auto, or a larger tolerance"
    )


def difference(coarse: Solution, fine: Solution, watch: Watch) -> Floats:
    """Change (b,) of the watched values at common cam angles when the step was halved, a share of their peak."""
    a, b = watch(coarse), watch(fine)
    gap = np.abs(b[:, ::2] - a).max(1)
    peak = np.abs(b).max(1)
    share = np.divide(gap, peak, out=np.where(gap > 0.0, np.inf, 0.0), where=peak > 0.0)
    return np.asarray(share.max(-1))


def _replace_error(solution: Solution, error: Floats) -> Solution:
    s = solution
    text = f"{s.method.name}, {s.grid.steps} steps a turn, error {float(error.max()):.1e} of the peak by halving"
    return Solution(s.system, s.method, s.grid, s.theta, s.state, s.spectral_radius, error, text)


def frequencies(system: System, grid: Grid) -> Floats:
    """Largest magnitudes (b, probes, m) of the natural frequencies in rad per rad of cam angle, looked at round the
    turn.
    """
    theta = np.linspace(grid.theta[0], grid.theta[-1], PROBES)[None, :]
    stiffness = system.coefficients(theta).stiffness
    return np.asarray(np.sqrt(np.abs(np.linalg.eigvals(stiffness))))


def vet(system: System, grid: Grid, method: Method) -> None:
    """Refuse steps beyond the stability limit of a method, naming the steps that would do (NotConverged)."""
    if not np.isfinite(method.stability):
        return
    highest = float(frequencies(system, grid).max())
    need = highest * float(grid.step.max()) / method.stability
    if need > 1.0:
        steps = int(np.ceil(grid.steps * need))
        raise StepTooLong(
            f"{method.name} is unstable at {grid.steps} steps a turn: the highest mode needs at least {steps}"
        )
