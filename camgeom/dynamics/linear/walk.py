"""Grids of cam angles aligned with the knots of the motion, and one-step maps composed along them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field
from math import ceil, isqrt

import numpy as np
import numpy.typing as npt

from camgeom.dynamics.linear.maps import restart, step_maps
from camgeom.dynamics.linear.method import Collocated, Method, System
from camgeom.errors import Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.frozen import cached_property

MAX_STEPS = 4_000_000
"""steps a turn; more would need more memory than a workstation has"""
KEEP = 196_608
"""steps x speeds whose composed maps are kept; longer walks form them again for each pass"""
MERGE = 1e-12
"""share of a turn below which two knots are one"""


@immutable
class TurnGrid:
    """Cam angles (n + 1) in rad from the first knot over one period, every knot among them.

    counts are the steps between knots; starts_at_knot (n,) says which step starts at one.
    """

    theta: Floats
    counts: tuple[int, ...]
    knots: Floats
    starts_at_knot: npt.NDArray[np.bool_]

    @cached_property
    def start(self) -> Floats:
        """Cam angles (n,) in rad at which the steps start."""
        return self.theta[:-1]

    @cached_property
    def step(self) -> Floats:
        """Lengths (n,) of the steps in rad, equal between two knots."""
        widths = np.diff(self.knots) / np.array(self.counts)
        return np.repeat(widths, self.counts)

    @property
    def steps(self) -> int:
        """Number of steps in the period."""
        return len(self.theta) - 1

    def halved(self) -> TurnGrid:
        """The grid with every step cut in two; every second angle is an angle of this one."""
        return _grid(self.knots, tuple(2 * count for count in self.counts))


def aligned_grid(knots: npt.ArrayLike, steps: int) -> TurnGrid:
    """Grid of about `steps` steps over the span of the knots (rad): each stretch between knots gets its share, at
    least one.

    Raises ProfileError for fewer than two distinct knots, fewer than one step or more than `MAX_STEPS`.
    """
    if not 1 <= steps <= MAX_STEPS:
        raise ProfileError([Problem("dynamics.steps", "steps a turn out of range", steps, f"1 to {MAX_STEPS}")])
    values = distinct(np.asarray(knots, dtype=float))
    span = float(values[-1] - values[0]) if values.size else 0.0
    if not np.isfinite(span) or span <= 0.0:
        raise ProfileError([Problem("dynamics.knots", "needs two distinct finite knots", values.tolist())])
    keep = np.concatenate([[True], np.diff(values) > MERGE * span])
    # the end of the period is exact; a knot within rounding of it gives way
    inside = values[keep]
    inside[-1] = values[-1]
    counts = tuple(max(1, ceil(steps * float(width) / span - 1e-9)) for width in np.diff(inside))
    return _grid(inside, counts)


def _grid(knots: Floats, counts: tuple[int, ...]) -> TurnGrid:
    parts = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(knots[:-1], knots[1:], counts, strict=True)]
    theta = np.concatenate([*parts, knots[-1:]])
    at_knot = np.zeros(len(theta) - 1, dtype=bool)
    at_knot[np.concatenate([[0], np.cumsum(counts)[:-1]])] = True
    return TurnGrid(theta, counts, knots, at_knot)


@immutable
class MapChain:
    """One-step maps (b, n, r, r + 1) composed in blocks of about sqrt(n) steps, side by side.

    Walking n steps then costs about 2 sqrt(n) passes of whole-array products instead of n.
    """

    blocks: Floats
    count: int

    @staticmethod
    def of(single: Floats) -> MapChain:
        """Compose one-step maps; the array is used up."""
        b, count, size = single.shape[:3]
        block = isqrt(count - 1) + 1
        padded = -(-count // block) * block
        if padded > count:
            rest = np.broadcast_to(np.eye(size, size + 1), (b, padded - count, size, size + 1))
            single = np.concatenate([single, rest], 1)
        blocks = single.reshape(b, padded // block, block, size, size + 1)
        for j in range(1, block):
            blocks[:, :, j] = after(blocks[:, :, j], blocks[:, :, j - 1])
        return MapChain(blocks, count)

    def whole(self) -> Floats:
        """The affine map (b, r, r + 1) of all steps."""
        total = self.blocks[:, 0, -1]
        for k in range(1, self.blocks.shape[1]):
            total = after(self.blocks[:, k, -1], total)
        return total

    def states(self, begin: Floats) -> Floats:
        """States (b, n, r) after each step from the state begin (b, r)."""
        b, rows, block, size = self.blocks.shape[:4]
        corner = np.empty((b, rows, size))
        corner[:, 0] = begin
        for k in range(1, rows):
            last = self.blocks[:, k - 1, -1]
            corner[:, k] = (last[..., :-1] @ corner[:, k - 1, :, None])[..., 0] + last[..., -1]
        flat = self.blocks[..., :-1].reshape(b, rows, block * size, size) @ corner[..., None]
        out = flat.reshape(b, rows, block, size) + self.blocks[..., -1]
        return out.reshape(b, rows * block, size)[:, : self.count]


@immutable
class Walk:
    """One period of a method on a grid, ready to be walked from any state or closed into a periodic one.

    A period of more than `KEEP` steps x speeds is walked in parts whose maps are formed again for each pass.
    """

    method: Method
    system: System
    grid: TurnGrid
    part: int = field(init=False, repr=False)
    kept: tuple[MapChain, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "part", max(64, KEEP // self.system.batch))
        short = self.grid.steps <= self.part
        object.__setattr__(self, "kept", (self._compose(0),) if short else ())

    @property
    def size(self) -> int:
        """Length of the state: (q, q') or (q, q', q'') stacked."""
        return self.method.rows * self.system.size

    @cached_property
    def period(self) -> Floats:
        """The affine map [Phi | p] (b, r, r + 1) of a whole period; Phi is the monodromy matrix."""
        total = np.broadcast_to(np.eye(self.size, self.size + 1), (self.system.batch, self.size, self.size + 1))
        for low in self._lows():
            total = after(self._chain(low).whole(), total)
        return total

    def closed(self, close: Callable[[Floats], Floats]) -> Floats:
        """States (b, n + 1, r) along the grid from the state that `close` makes of the map of the whole period."""
        return self.run(close(self.period))[0]

    def run(self, begin: Floats) -> tuple[Floats, Floats]:
        """States (b, n + 1, r) along the grid from the state begin (b, r), and the map of the whole period, in one
        pass.
        """
        out = np.empty((self.system.batch, self.grid.steps + 1, self.size))
        out[:, 0] = begin
        total = np.broadcast_to(np.eye(self.size, self.size + 1), (self.system.batch, self.size, self.size + 1))
        for low in self._lows():
            chain = self._chain(low)
            out[:, low + 1 : low + 1 + chain.count] = chain.states(out[:, low])
            total = after(chain.whole(), total)
        return out, total

    def _lows(self) -> range:
        return range(0, self.grid.steps, self.part)

    def _chain(self, low: int) -> MapChain:
        return self.kept[0] if self.kept else self._compose(low)

    def _compose(self, low: int) -> MapChain:
        """The chain of the part that begins with step `low`."""
        cut = slice(low, low + self.part)
        start = self.grid.start[cut]
        # What is kept of them is not to be used up.
        single = np.array(step_maps(self.method, self.system, start, self.grid.step[cut]))
        if isinstance(self.method, Collocated):
            # the carried acceleration is renewed before each step that starts at a knot
            at_knot = self.grid.starts_at_knot[cut]
            if at_knot.any():
                single[:, at_knot] = after(single[:, at_knot], restart(self.system, start[None, at_knot]))
        return MapChain.of(single)


def after(second: Floats, first: Floats) -> Floats:
    """The affine map (..., r, r + 1) that does `first` and then `second`."""
    out = second[..., :-1] @ first
    out[..., -1] += second[..., -1]
    return np.asarray(out)
