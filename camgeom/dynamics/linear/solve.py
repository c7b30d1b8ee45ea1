"""Transients and periodic steady states of a system on a grid of cam angles.

A linear system is a walk along its one-step maps. A small non-linear correction g(theta, q, q') is evaluated at the
stages of the last pass and enters the next as a known force; the matrices of the linear part, already inverted, stay.
Each pass shrinks the error by the ratio of the correction to the linear force, 1e-3 or less for an indexing drive, so
four to six passes reach rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field

import numpy as np
import numpy.typing as npt

from camgeom.dynamics.linear.maps import KEPT, Stages, held_stages, stages_of, step_maps, stepped
from camgeom.dynamics.linear.method import Correction, Method, RungeKutta, Side, System, find, radau
from camgeom.dynamics.linear.walk import MapChain, TurnGrid, Walk
from camgeom.errors import NotConverged, Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property, frozen

NEUTRAL = 1e-9
"""a multiplier within this of the unit circle neither grows nor decays"""
SINGULAR = 1e-11
"""smallest singular value of I - Phi (scaled) below which the steady state is a resonance"""
PASSES = 150
SURE = 12
"""passes after which it is told from their changes whether PASSES will do"""
AT_ONCE = 32_768
"""steps x speeds whose maps or stages are formed together"""
SIDES: tuple[Side, Side] = ("right", "left")
INSIDE = np.array([1.0, 2.0, 3.0, 4.0, 5.0]) / 6.0
"""shares of a step at which a solution is interpolated"""
SETTLED = 2e-15
"""change of the state, as a share of its largest value, at which a pass has converged"""
LOOSE = 1e-7
"""change that is still accepted when rounding, amplified by a weakly damped mode, keeps it from shrinking further; what
is left shows in the error by halving"""
FINE = radau(6)
"""steps of its own for events, peaks and single angles: L-stable, so that a partial step leaves no stiff ringing"""


@immutable
class Solution:
    """States over one or more turns: theta (n + 1) rad, state (b, n + 1, r) with q, q' (and q'' for the Newmark
    family).

    error (b,) is the difference to the solution with half as many steps (of given steps: with twice as many), over the
    peak of what was watched, so that it bounds the error of the coarser of the two; infinity where none was made.
    spectral_radius (b,) is the largest multiplier of a turn; attracting (b,) is whether disturbances die out.
    """

    system: System
    method: Method
    grid: TurnGrid
    theta: Floats
    state: Floats
    spectral_radius: Floats
    error: Floats
    choice: str

    @cached_property
    def position(self) -> Floats:
        """Coordinates q (b, n + 1, m)."""
        return self.state[..., : self.system.size]

    @cached_property
    def rate(self) -> Floats:
        """Derivatives q' (b, n + 1, m) per rad of cam angle."""
        return self.state[..., self.system.size : 2 * self.system.size]

    @cached_property
    def attracting(self) -> npt.NDArray[np.bool_]:
        """Whether the turn-by-turn map shrinks every disturbance (b,)."""
        return np.asarray(self.spectral_radius < 1.0 - NEUTRAL)

    @property
    def cautions(self) -> tuple[str, ...]:
        """What to know before trusting the numbers."""
        notes = [self.method.caution] if self.method.caution else []
        if not bool(self.attracting.all()):
            notes.append(
                "no damping in some motion: a disturbance never dies out, the steady state is only one of many"
            )
        return tuple(notes)

    def acceleration(self, side: Side = "right") -> Floats:
        """q'' (b, n + 1, m) per rad^2 from the equation of motion, at knots the limit from the given side."""
        return acceleration(self.system, self.theta, self.position, self.rate, side)


    def inside(self, low: int, high: int) -> tuple[Floats, Floats, Floats]:
        """Cam angles (1, n), q and q' (b, n, m) at the shares INSIDE of the steps low .. high, by the quintic that has
        place, rate and acceleration of both ends; kept where it is one part."""
        if (low, high) not in self._inside:
            found = frozen(self._interpolated(low, high))
            if high - low < len(self.theta) - 1:
                return found
            self._inside[low, high] = found
        return self._inside[low, high]

    @cached_property
    def _inside(self) -> dict[tuple[int, int], tuple[Floats, Floats, Floats]]:
        """What was interpolated."""
        return {}

    def _interpolated(self, low: int, high: int) -> tuple[Floats, Floats, Floats]:
        theta = self.theta[low : high + 1]
        h = np.diff(theta)[None, :, None, None]
        q, v = self.position[:, low : high + 1], self.rate[:, low : high + 1]
        right, left = (acceleration(self.system, theta, q, v, side) for side in SIDES)
        x = INSIDE[None, None, :, None]
        q0, v0, a0 = q[:, :-1, None], v[:, :-1, None] * h, right[:, :-1, None] * h * h
        gap = q[:, 1:, None] - q0 - v0 - a0 / 2.0
        slope = v[:, 1:, None] * h - v0 - a0
        bend = left[:, 1:, None] * h * h - a0
        c3, c4, c5 = (
            10.0 * gap - 4.0 * slope + bend / 2.0,
            -15.0 * gap + 7.0 * slope - bend,
            6.0 * gap - 3.0 * slope + bend / 2.0,
        )
        place = q0 + x * (v0 + x * (a0 / 2.0 + x * (c3 + x * (c4 + x * c5))))
        speed = (v0 + x * (a0 + x * (3.0 * c3 + x * (4.0 * c4 + x * 5.0 * c5)))) / h
        b, n, k, m = place.shape
        angles = (theta[:-1, None] + np.diff(theta)[:, None] * INSIDE).reshape(1, n * k)
        return angles, place.reshape(b, n * k, m), speed.reshape(b, n * k, m)


def acceleration(system: System, theta: Floats, position: Floats, rate: Floats, side: Side = "right") -> Floats:
    """q'' (b, n, m) per rad^2 at cam angles theta (n,) or (b, n) for given q and q'."""
    out = system.coefficients(np.atleast_2d(theta), side).acceleration(position, rate)
    return out if system.linear else out + system.correction(np.atleast_2d(theta), side)(position, rate)


def periodic(system: System, grid: TurnGrid, method: str | Method) -> Solution:
    """The periodic steady state on a grid, y0 = (I - Phi)^-1 p, without any transient.

    Raises NotConverged for a growing turn (step too long for the method, or parametric instability) and for a resonance
    without damping; the text says which, at which speed index, and what would help.
    """
    method = find(method)
    turn = _turn(system, grid, method)
    radius = _growth(turn.period)
    state = turn.closed(lambda total: _closing_state(system, grid, method, total, radius))
    return Solution(system, method, grid, grid.theta, state, radius, np.full(system.batch, np.inf), "")


def transient(
    system: System, grid: TurnGrid, method: str | Method, begin: Floats | None = None, turns: int = 1
) -> Solution:
    """The motion over `turns` turns from the state begin (b, 2m) of q, q' at the grid's first angle; rest when not
    given.

    Raises NotConverged when the motion grows past every bound.
    """
    method = find(method)
    m, turn = system.size, _turn(system, grid, method)
    state = np.zeros((system.batch, method.rows * m))
    if begin is not None:
        state[:, : 2 * m] = begin
    if method.rows == 3:
        here = grid.theta[None, :1]
        # the limit from the left: the renewal at the first knot then brings the limit from the right
        state[:, 2 * m :] = acceleration(system, here, state[:, None, :m], state[:, None, m : 2 * m], "left")[:, 0]
    part, total = turn.run(state)
    parts = [part]
    for _ in range(1, turns):
        parts.append(turn.run(parts[-1][:, -1])[0][:, 1:])
    out = np.concatenate(parts, 1)
    if not np.isfinite(out).all():
        raise NotConverged(
            f"{method.name}: the motion grows without bound within {turns} turns; see the spectral radius"
        )
    span = grid.theta[-1] - grid.theta[0]
    theta = np.concatenate([grid.theta, *(grid.theta[1:] + k * span for k in range(1, turns))])
    return Solution(system, method, grid, theta, out, _growth(total), np.full(system.batch, np.inf), "")


def _turn(system: System, grid: TurnGrid, method: Method) -> Walk | CorrectedWalk:
    return Walk(method, system, grid) if system.linear else CorrectedWalk(method, system, grid)


def _growth(total: Floats) -> Floats:
    """Largest multiplier (b,) of a turn from its map [Phi | p]; infinite where that has no finite entries."""
    if not np.isfinite(total).all():
        return np.full(len(total), np.inf)
    return np.asarray(np.abs(np.linalg.eigvals(total[..., :-1])).max(-1))


class Growing(NotConverged):
    """A turn multiplies some disturbance by `radius` > 1: too long a step, or the drive itself."""

    def __init__(self, text: str, radius: float = np.inf) -> None:
        self.radius = radius
        super().__init__(text)


def _closing_state(system: System, grid: TurnGrid, method: Method, total: Floats, radius: Floats) -> Floats:
    """The state (b, r) that the map of a turn [Phi | p] brings back to itself; refusals as in `periodic`."""
    if not np.isfinite(radius).all() or float(radius.max()) > 1.0 + NEUTRAL:
        worst = int(np.nan_to_num(radius, nan=np.inf).argmax())
        where = f" at speed {worst + 1} of {len(radius)}" if len(radius) > 1 else ""
        raise Growing(
            f"the turn grows by {radius[worst]:.6g}{where}: a parametric instability of an undamped drive or "
            f"too long a step for {method.name} ({grid.steps} a turn); give damping, move the speed, or use auto",
            float(radius[worst]),
        )
    size, rate = total.shape[1], _typical_rate(system, grid)
    scale = np.ones((system.batch, size))
    scale[:, : system.size] = rate[:, None]
    if method.rows == 3:
        scale[:, 2 * system.size :] = 1.0 / rate[:, None]
    matrix = np.eye(size) - total[..., :-1] * scale[:, :, None] / scale[:, None, :]
    smallest = np.linalg.svd(matrix, compute_uv=False)[:, -1]
    if np.any(smallest < SINGULAR):
        worst = int(smallest.argmin())
        raise NotConverged(
            f"resonance: a harmonic of the turn meets an undamped natural frequency (speed {worst}, I - Phi has the "
            f"singular value {smallest[worst]:.1e}); no steady state exists there. Give damping or move the speed"
        )
    return np.asarray(np.linalg.solve(matrix, (total[..., -1] * scale)[..., None])[..., 0] / scale)


def _typical_rate(system: System, grid: TurnGrid) -> Floats:
    """A rate (b,) in rad per rad that brings q and q' to one size."""
    stiffness = system.coefficients(grid.theta[None, :1]).stiffness
    size = np.abs(stiffness).sum(-1).max(axis=(-1, -2))
    return np.asarray(np.broadcast_to(np.sqrt(np.maximum(size, 1.0)), (system.batch,)))


def advance(system: System, start: Floats, step: Floats, state: Floats) -> Floats:
    """State (b, n, 2m) of q and q' one fine step of length (b, n) rad after the states (b, n, 2m) at cam angles
    start, in parts of AT_ONCE steps x speeds so that memory stays bounded.
    """
    count, part = state.shape[1], max(1, AT_ONCE // system.batch)
    parts = [slice(low, low + part) for low in range(0, count, part)]
    if len(parts) > 1:
        return np.concatenate([_advance(system, start[:, p], step[:, p], state[:, p]) for p in parts], 1)
    return _advance(system, start, step, state)


def _advance(system: System, start: Floats, step: Floats, state: Floats) -> Floats:
    if system.linear and state.shape[1] * system.batch < KEPT[0]:
        return stepped(FINE, system, start, step, state)
    if system.linear:
        maps = step_maps(FINE, system, start, step)
        return np.asarray((maps[..., :-1] @ state[..., None])[..., 0] + maps[..., -1])
    held = stages_of(FINE, system, start, step, keep_inverse=True)
    maps = held.maps()
    plain = (maps[..., :-1] @ state[..., None])[..., 0] + maps[..., -1]
    out, before = plain, np.inf
    corrections = _corrections(system, held)
    force: Floats | None = None
    for _ in range(PASSES):
        force = _stage_force(corrections, held, state, force)
        fresh = plain + _pushed(held, force)
        change = _change(fresh, out)
        out = fresh
        if change <= SETTLED or (change <= LOOSE and change >= 0.5 * before):
            return out
        before = change
    raise NotConverged(_advice(before))


@immutable
class CorrectedWalk:
    """One period of a system with a non-linear correction, as `Walk` is one of a linear system."""

    method: Method
    system: System
    grid: TurnGrid
    stages: Stages = field(init=False, repr=False)
    maps: Floats = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if not isinstance(self.method, RungeKutta):
            allowed = "auto, gauss1 .. gauss8, radau2, 3, 5"
            text = "the exact contact needs a Gauss method"
            raise ProfileError([Problem("dynamics.method", text, self.method.name, allowed)])
        held = held_stages(self.method, self.system, self.grid.start[None], self.grid.step[None])
        object.__setattr__(self, "stages", held)
        object.__setattr__(self, "maps", held.maps())

    @cached_property
    def period(self) -> Floats:
        """The affine map [Phi | p] (b, r, r + 1) of a whole period without the correction."""
        return MapChain.of(self.maps.copy()).whole()

    def run(self, begin: Floats) -> tuple[Floats, Floats]:
        """States (b, n + 1, r) along the grid from the state begin (b, r), and the map as `period` gives it."""
        return self.closed(lambda total: begin), self.period

    def closed(self, close: Callable[[Floats], Floats]) -> Floats:
        """States (b, n + 1, r) with the correction settled, each pass begun where `close` of its whole map says."""
        force: Floats | None = None
        old: Floats | None = None
        before, changes = np.inf, list[float]()
        corrections = _corrections(self.system, self.stages)
        for _ in range(PASSES):
            maps = self.maps.copy()
            if force is not None:
                maps[..., -1] += _pushed(self.stages, force)
            chain = MapChain.of(maps)
            first = close(chain.whole())
            state = np.concatenate([first[:, None], chain.states(first)], 1)
            if not np.isfinite(state).all():
                raise NotConverged(_advice(np.inf))
            if old is not None:
                change = _change(state, old)
                if change <= SETTLED or (change <= LOOSE and change >= 0.5 * before):
                    return state
                before = change
                changes.append(change)
                if _hopeless(changes):
                    raise NotConverged(_advice(change))
            try:
                force = _stage_force(corrections, self.stages, state[:, :-1], force)
            except FloatingPointError:
                raise NotConverged(_advice(np.inf)) from None
            old = state
        raise NotConverged(_advice(before))


def _hopeless(changes: list[float]) -> bool:
    """Whether passes whose changes go on as the latest of them will not settle within PASSES."""
    if len(changes) < SURE or changes[-1] <= LOOSE:
        return False
    rate = (changes[-1] / changes[-SURE]) ** (1.0 / (SURE - 1))
    return bool(changes[-1] * rate ** (PASSES - len(changes)) > LOOSE)


def _corrections(system: System, held: Stages) -> tuple[Correction, Correction | None]:
    """The correction at all stages, and that of a last one at the end of its step, which looks at a knot from inside.
    """
    of_all = np.broadcast_to(held.theta, (*held.theta.shape[:2], len(held.method.c))).reshape(len(held.theta), -1)
    ends = system.correction(held.theta[:, :, -1], "left") if held.method.c[-1] == 1.0 else None
    return system.correction(of_all), ends


def _stage_force(
    corrections: tuple[Correction, Correction | None], held: Stages, state: Floats, force: Floats | None
) -> Floats:
    """The correction (b, n, s m) at the stages of steps that start in states (b, n, 2m) under the last stage force."""
    m = state.shape[-1] // 2
    b, n, sm = held.rows.shape[:3]
    s = sm // m
    bend = (held.rows[..., :-1] @ state[..., None])[..., 0] + held.rows[..., -1]
    if force is not None:
        bend = bend + held.bent(force)
    bend = bend.reshape(b, n, s, m)
    a, c = np.array(held.method.a), np.array(held.method.c)
    h = held.step[:, :, None, None]
    rate = state[:, :, None, m:] + h * (a @ bend)
    place = state[:, :, None, :m] + h * c[:, None] * state[:, :, None, m:] + h * h * ((a @ a) @ bend)
    everywhere, ends = corrections
    out = everywhere(place.reshape(b, n * s, m), rate.reshape(b, n * s, m)).reshape(b, n, s, m)
    if ends is not None:
        out[:, :, -1] = ends(place[:, :, -1], rate[:, :, -1])
    return np.asarray(out.reshape(b, n, sm))


def _pushed(held: Stages, force: Floats) -> Floats:
    """What stage forces (b, n, s m) add to the state (b, n, 2m) at the end of the step."""
    b, n, sm = force.shape
    s = len(held.method.b)
    extra = held.bent(force).reshape(b, n, s, sm // s)
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
