"""Equations of motion with a small non-linear correction: Gauss stages, the correction iterated as a force.

The correction g(theta, q, q') is evaluated at the stages of the last pass and enters the next as a known force; the
matrices of the linear part, already inverted, stay. Each pass shrinks the error by the ratio of the correction to the
linear force, 1e-3 or less for an indexing drive, so four to six passes reach rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from camgeom.dynamics.linear.maps import step_maps
from camgeom.dynamics.linear.method import Method, RungeKutta, System, radau
from camgeom.dynamics.linear.runge_kutta import Stages, stages
from camgeom.dynamics.linear.solution import Solution, closing_state, turn_after_turn
from camgeom.dynamics.linear.walk import Chain, Grid
from camgeom.errors import NotConverged, Problem, ProfileError
from camgeom.maths import Floats

PASSES = 150
SETTLED = 2e-15
"""change of the state, as a share of its largest value, at which a pass has converged"""
LOOSE = 1e-7
"""change that is still accepted when rounding, amplified by a weakly damped mode, keeps it from shrinking further; what
is left shows in the error by halving"""
FINE = radau(5)
"""steps of its own for events, peaks and single angles: L-stable, so that a partial step leaves no stiff ringing"""


def advance(system: System, start: Floats, step: Floats, state: Floats) -> Floats:
    """State (b, n, 2m) of q and q' one fine step of length (b, n) rad after the states (b, n, 2m) at cam angles
    start.
    """
    if system.linear:
        maps = step_maps(FINE, system, start, step)
        return np.asarray((maps[..., :-1] @ state[..., None])[..., 0] + maps[..., -1])
    held = stages(FINE, system, start, step, keep_inverse=True)
    maps = held.maps()
    plain = (maps[..., :-1] @ state[..., None])[..., 0] + maps[..., -1]
    out, before = plain, np.inf
    force: Floats | None = None
    for _ in range(PASSES):
        force = _stage_force(system, held, state, force)
        fresh = plain + _pushed(held, force)
        change = _change(fresh, out)
        out = fresh
        if change <= SETTLED or (change <= LOOSE and change >= 0.5 * before):
            return out
        before = change
    raise NotConverged(_advice(before))


def exact_periodic(system: System, grid: Grid, method: Method) -> Solution:
    """Periodic steady state with the correction, see `periodic`."""
    held, single = _linear_part(system, grid, method)
    phi = Chain.of(single.copy()).whole()[..., :-1]
    radius = np.abs(np.linalg.eigvals(phi)).max(-1)

    def begin(total: Floats) -> Floats:
        return closing_state(system, grid, method, total, radius)

    state = _iterate(system, held, single, begin)
    return Solution(system, method, grid, grid.theta, state, radius, np.full(system.batch, np.inf), "")


def exact_transient(system: System, grid: Grid, method: Method, begin: Floats | None, turns: int) -> Solution:
    """Transient with the correction from the state begin (b, 2m) or from rest, see `transient`."""
    held, single = _linear_part(system, grid, method)
    here = np.zeros((system.batch, 2 * system.size))
    if begin is not None:
        here[:] = begin
    parts = []
    for turn in range(turns):
        part = _iterate(system, held, single, partial(_given, here))
        here = part[:, -1]
        parts.append(part if turn == 0 else part[:, 1:])
    radius = np.abs(np.linalg.eigvals(Chain.of(single.copy()).whole()[..., :-1])).max(-1)
    theta = turn_after_turn(grid, turns)
    return Solution(system, method, grid, theta, np.concatenate(parts, 1), radius, np.full(system.batch, np.inf), "")


def _given(begin: Floats, total: Floats) -> Floats:
    """The state a transient begins with, whatever the map of the turn."""
    return begin


def _linear_part(system: System, grid: Grid, method: Method) -> tuple[Stages, Floats]:
    """Stages with their inverse and the one-step maps without correction."""
    if not isinstance(method, RungeKutta) or method.explicit:
        allowed = "auto, gauss1 .. gauss8, radau2, 3, 5"
        raise ProfileError([Problem("dynamics.method", "the exact contact needs a Gauss method", method.name, allowed)])
    held = stages(method, system, grid.start[None], grid.step[None], keep_inverse=True)
    return held, held.maps()


def _iterate(system: System, held: Stages, single: Floats, begin: Callable[[Floats], Floats]) -> Floats:
    """States (b, n + 1, 2m) with the correction converged."""
    force: Floats | None = None
    old: Floats | None = None
    before = np.inf
    for _ in range(PASSES):
        maps = single.copy()
        if force is not None:
            maps[..., -1] += _pushed(held, force)
        chain = Chain.of(maps)
        first = begin(chain.whole())
        state = np.concatenate([first[:, None], chain.states(first)], 1)
        if not np.isfinite(state).all():
            raise NotConverged(_advice(np.inf))
        if old is not None:
            change = _change(state, old)
            if change <= SETTLED or (change <= LOOSE and change >= 0.5 * before):
                return state
            before = change
        force = _stage_force(system, held, state[:, :-1], force)
        old = state
    raise NotConverged(_advice(before))


def _stage_force(system: System, held: Stages, state: Floats, force: Floats | None) -> Floats:
    """The correction (b, n, s m) at the stages of steps that start in states (b, n, 2m) under the last stage force."""
    m = system.size
    b, n, sm = held.rows.shape[:3]
    s = sm // m
    bend = (held.rows[..., :-1] @ state[..., None])[..., 0] + held.rows[..., -1]
    if force is not None and held.inverse is not None:
        bend = bend + (held.inverse @ force[..., None])[..., 0]
    bend = bend.reshape(b, n, s, m)
    a, c = np.array(held.method.a), np.array(held.method.c)
    h = held.step[:, :, None, None]
    rate = state[:, :, None, m:] + h * (a @ bend)
    place = state[:, :, None, :m] + h * c[:, None] * state[:, :, None, m:] + h * h * ((a @ a) @ bend)
    theta = np.broadcast_to(held.theta, (held.theta.shape[0], n, s)).reshape(-1, n * s)
    found = system.correction(theta, place.reshape(b, n * s, m), rate.reshape(b, n * s, m)).reshape(b, n, s, m)
    if c[-1] == 1.0:
        # a stage at the end of the step looks at a knot from inside
        found[:, :, -1] = system.correction(held.theta[:, :, -1], place[:, :, -1], rate[:, :, -1], "left")
    return np.asarray(found.reshape(b, n, sm))


def _pushed(held: Stages, force: Floats) -> Floats:
    """What stage forces (b, n, s m) add to the state (b, n, 2m) at the end of the step."""
    if held.inverse is None:
        raise ProfileError([Problem("dynamics.method", "the exact contact needs a Gauss method", held.method.name)])
    b, n, sm = force.shape
    s = len(held.method.b)
    extra = (held.inverse @ force[..., None]).reshape(b, n, s, sm // s)
    position, speed = held.weights()
    return np.concatenate([(position @ extra)[:, :, 0], (speed @ extra)[:, :, 0]], -1)


def _change(new: Floats, old: Floats) -> float:
    """Largest change of a state component over its largest value."""
    axes = tuple(range(new.ndim - 1))
    scale = np.abs(new).max(axis=axes)
    gap = np.abs(new - old).max(axis=axes)
    return float(np.divide(gap, scale, out=np.zeros_like(gap), where=scale > 0.0).max())


def _advice(change: float) -> str:
    return (
        f"the non-linear contact does not settle (last change {change:.1e} of the state): the windup is no longer "
        "small, or nothing damps a resonance. Lower the speed, stiffen the input shaft or give damping"
    )
