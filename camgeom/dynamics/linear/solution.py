"""The states of a walked system, what is known about them, and the closing of a turn into a periodic state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from camgeom.dynamics.linear.method import Method, Side, System
from camgeom.dynamics.linear.walk import Grid
from camgeom.errors import NotConverged
from camgeom.maths import Floats

NEUTRAL = 1e-9
"""a multiplier within this of the unit circle neither grows nor decays"""
SINGULAR = 1e-11
"""smallest singular value of I - Phi (scaled) below which the steady state is a resonance"""


@dataclass(frozen=True, eq=False)
class Solution:
    """States over one or more turns: theta (n + 1) rad, state (b, n + 1, r) with q, q' (and q'' for the Newmark
    family).

    error (b,) is the difference to the solution with half as many steps, over the peak of what was watched (so it
    bounds the error of the coarser of the two), infinity where no halving was asked for. spectral_radius (b,) is the
    largest multiplier of a turn; attracting (b,) is whether disturbances die out.
    """

    system: System
    method: Method
    grid: Grid
    theta: Floats
    state: Floats
    spectral_radius: Floats
    error: Floats
    choice: str

    @property
    def position(self) -> Floats:
        """Coordinates q (b, n + 1, m)."""
        return self.state[..., : self.system.size]

    @property
    def rate(self) -> Floats:
        """Derivatives q' (b, n + 1, m) per rad of cam angle."""
        return self.state[..., self.system.size : 2 * self.system.size]

    @property
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


def acceleration(system: System, theta: Floats, position: Floats, rate: Floats, side: Side = "right") -> Floats:
    """q'' (b, n, m) per rad^2 at cam angles theta (n,) or (b, n) for given q and q'."""
    parts = system.split(np.atleast_2d(theta), side)
    if parts is not None:
        out = parts.acceleration(position, rate)
    else:
        here = system.coefficients(np.atleast_2d(theta), side)
        pull = (here.damping @ rate[..., None])[..., 0] + (here.stiffness @ position[..., None])[..., 0]
        out = here.force - pull
    if not system.linear:
        out = out + system.correction(np.atleast_2d(theta), position, rate, side)
    return np.asarray(out)


class Growing(NotConverged):
    """A turn multiplies some disturbance by `radius` > 1: too long a step, or the drive itself."""

    def __init__(self, radius: float, text: str) -> None:
        self.radius = radius
        super().__init__(text)


def turn_after_turn(grid: Grid, turns: int) -> Floats:
    """Cam angles of the grid repeated over the turns, in rad."""
    span = grid.theta[-1] - grid.theta[0]
    return np.concatenate([grid.theta, *(grid.theta[1:] + k * span for k in range(1, turns))])


def closing_state(system: System, grid: Grid, method: Method, total: Floats, radius: Floats) -> Floats:
    """The state (b, r) that the map of a turn [Phi | p] brings back to itself; refusals as in `periodic`."""
    _refuse_growth(radius, method, grid)
    size = total.shape[1]
    rate = _typical_rate(system, grid)
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


def _typical_rate(system: System, grid: Grid) -> Floats:
    """A rate (b,) in rad per rad that brings q and q' to one size."""
    stiffness = system.coefficients(grid.theta[None, :1]).stiffness
    size = np.abs(stiffness).sum(-1).max(axis=(-1, -2))
    return np.asarray(np.broadcast_to(np.sqrt(np.maximum(size, 1.0)), (system.batch,)))


def _refuse_growth(radius: Floats, method: Method, grid: Grid) -> None:
    """NotConverged when some speed has a growing turn."""
    if not np.isfinite(radius).all() or float(radius.max()) > 1.0 + NEUTRAL:
        worst = int(np.nan_to_num(radius, nan=np.inf).argmax())
        raise Growing(
            float(radius[worst]),
            f"the turn grows by {radius[worst]:.6g} at speed {worst}: a parametric instability of an undamped drive or "
            f"too long a step for {method.name} ({grid.steps} a turn); give damping, move the speed, or use gauss4",
        )
