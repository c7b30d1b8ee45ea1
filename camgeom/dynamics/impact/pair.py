"""Two opposing contacts given by tables of exact flank geometry round the cam (globoidal and other spatial cams)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np

from camgeom.dynamics.impact.lift import TURN, Lift, LiftJets
from camgeom.dynamics.impact.side import Pair, Side, Touch, Toucher, TouchMany, check_clearance
from camgeom.errors import Problem, ProfileError
from camgeom.maths import Floats

Row = tuple[float, ...]


@final
class Ring:
    """Periodic cubic spline through equally spaced values round the cam, with its slope; for one angle or arrays."""

    def __init__(self, values: Row) -> None:
        y = np.asarray(values, dtype=np.float64)
        self.n = y.size
        self.step = TURN / y.size
        # Slopes of the C2 spline: m[-1] + 4 m[0] + m[1] = 3 (y[1] - y[-1])/h, a circulant system solved by FFT.
        right = 3.0 * (np.roll(y, -1) - np.roll(y, 1)) / self.step
        symbol = 4.0 + 2.0 * np.cos(TURN * np.arange(y.size) / y.size)
        slope = np.fft.ifft(np.fft.fft(right) / symbol).real
        y1, m1 = np.roll(y, -1), np.roll(slope, -1)
        h = self.step
        self.rows = np.stack(
            [y, slope, (3 * (y1 - y) / h - 2 * slope - m1) / h, (2 * (y - y1) / h + slope + m1) / h**2]
        )
        self.table = [(float(a), float(b), float(c), float(d)) for a, b, c, d in self.rows.T]

    def at(self, angle: float) -> tuple[float, float]:
        """Value and slope per rad at an angle [rad]."""
        place = (angle / self.step) % self.n
        k = min(int(place), self.n - 1)
        u = (place - k) * self.step
        a, b, c, d = self.table[k]
        return a + u * (b + u * (c + u * d)), b + u * (2.0 * c + 3.0 * u * d)

    def many(self, angle: Floats) -> tuple[Floats, Floats]:
        """Values and slopes at an array of angles [rad]."""
        place = np.mod(angle / self.step, self.n)
        k = np.minimum(place.astype(np.int64), self.n - 1)
        u = (place - k) * self.step
        a, b, c, d = self.rows[:, k]
        return a + u * (b + u * (c + u * d)), b + u * (2.0 * c + 3.0 * u * d)


@final
@dataclass(frozen=True)
class TableSide(Side):
    """One wall: lever and play (deviation at which it is touched), cam curvature, sliding speed per radian, all rings.

    delta = -push lever (eta - play): linear in the deviation, exact to first order in the play over the radius of
    curvature (3.5e-3 of the clearance at 1 mm on a 130 mm cam).
    """

    starts: tuple[float, ...]
    lever: Row
    offset: Row
    curvature: Row
    sliding: Row
    push: int

    @property
    def limit(self) -> float | None:
        return 0.0 if not any(self.offset) else None

    @property
    def sense(self) -> int:
        return self.push

    @cached_property
    def _rings(self) -> tuple[Ring, Ring, Ring, Ring]:
        return Ring(self.lever), Ring(self.offset), Ring(self.curvature), Ring(self.sliding)

    def compiled(self, jets: LiftJets) -> Toucher:
        lever_at, offset_at, bend_at, slide_at = (ring.at for ring in self._rings)
        starts, push = self.starts, float(self.push)

        def touch(k: int, x: float, s0: float, s1: float, s2: float, eta: float) -> Touch:
            angle = starts[k] + x
            lever, lever1 = lever_at(angle)
            offset, offset1 = offset_at(angle)
            away = push * (eta - offset)
            drag = push * lever * (s1 + offset1) - lever1 * away
            return -lever * away, push * lever, drag, 0.0, slide_at(angle)[0], bend_at(angle)[0]

        return touch

    def many(self, lift: Lift, angle: Floats, eta: Floats) -> TouchMany:
        lever_ring, offset_ring, bend_ring, slide_ring = self._rings
        lever, lever1 = lever_ring.many(angle)
        offset, offset1 = offset_ring.many(angle)
        away = self.push * (eta - offset)
        drag = self.push * lever * (lift.many(angle, 1)[1] + offset1) - lever1 * away
        bend, slide = bend_ring.many(angle)[0], slide_ring.many(angle)[0]
        return -lever * away, self.push * lever, drag, np.zeros_like(eta), slide, bend


@final
@dataclass(frozen=True)
class TablePair(Pair):
    """Two walls by the exact flank geometry at equal steps of cam angle over one turn, the last step not repeated.

    `lever_main`, `lever_return` [m/rad, or 1], > 0, are the normal components of the follower's velocity at the
    contacts; `clearance` [m] is the gap along the normal of the return wall; `curvature_main`, `curvature_return` [1/m]
    are those of the cam; `sliding` [m/rad] is the sliding speed per unit of cam speed. All of one length, at least 16.
    """

    lift: Lift
    lever_main: Row
    lever_return: Row
    clearance: float
    curvature_main: Row
    curvature_return: Row
    sliding: Row

    def __post_init__(self) -> None:
        rows = (self.lever_main, self.lever_return, self.curvature_main, self.curvature_return, self.sliding)
        check_clearance(self.clearance)
        problems = []
        if min(map(len, rows)) < 16 or len({len(row) for row in rows}) > 1:
            problems.append(Problem("tables", "must be of equal length", [len(row) for row in rows], ">= 16 each"))
        elif not min(*self.lever_main, *self.lever_return) > 0.0:
            problems.append(Problem("lever", "must be positive: the wall must be able to drive", None, "> 0"))
        if problems:
            raise ProfileError(problems)

    @property
    def play(self) -> float:
        return self.clearance * float(np.mean(1.0 / np.asarray(self.lever_return)))

    @property
    def clearance_text(self) -> str:
        return "gap along the common normal, from tables"

    @cached_property
    def sides(self) -> tuple[TableSide, TableSide]:
        starts, count = self.lift.starts, len(self.lever_main)
        offset = tuple(self.clearance / lever for lever in self.lever_return)
        return (
            TableSide(starts, self.lever_main, (0.0,) * count, self.curvature_main, self.sliding, 1),
            TableSide(starts, self.lever_return, offset, self.curvature_return, self.sliding, -1),
        )

    def with_clearance(self, clearance: float) -> TablePair:
        return replace(self, clearance=clearance)
