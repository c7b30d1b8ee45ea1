"""A cam angle at a stop, or at several stops abreast: what the errors of many machines do to their followers there.

Arrays: q stations, c numbers of a machine, l the same in the order of `Order`, p positions abreast, n machines.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.tolerance.ends import inset
from camgeom.tolerance.seat import Bools, Reals, balance, bracket, room
from camgeom.tolerance.shares import Singles

AT_ONCE = 4096
"""followers balanced at once: what they have stays in a core's cache (measured: half the time of four times as many)"""
SINGLE = np.float32
ROUNDED = 4.0 * float(np.finfo(SINGLE).eps)
"""share of the largest approach within which approaches are the same"""
TINY = SINGLE(1e-30)
"""of a machine's numbers: a deviation of seconds of arc is good to a hundred thousandth of one"""
Room = Singles
Rows = npt.NDArray[np.intp]


@final
@immutable
class End:
    """An end of a plate's groove: what a unit of each column does to the stations of its walls, see `Ends`.

    way, growth  mm, (q, c); beside, lever: of the walls, (q, 1); room: running clearance, mm
    """

    way: Floats
    growth: Floats
    beside: Floats
    lever: Floats
    room: float

    def reach(self, x: Singles) -> Floats:
        """How far machines x (c, size) carry their roller towards it, mm, (size,)."""
        return np.asarray(((self.way + self.growth) @ x).max(axis=0))

    def insets(self, x: Singles) -> tuple[Floats, Floats]:
        """How much nearer to the middle their followers stand by it on what pushes and on what holds, (size,) each."""
        found = inset(self.way @ x, self.room - self.growth @ x, self.beside, self.lever)
        pushes = self.lever[:, 0] < 0.0
        return found[pushes].max(axis=0), found[~pushes].max(axis=0)


@final
@immutable
class Position:
    """A cam angle at a stop: how the columns bring each station nearer, as deviations of the coordinate.

    columns     which of a machine's numbers count there, (c,)
    near        approach over |lever| per unit of a column, mm or rad, (q, c), stations that push first
    nominal     the same without errors, (q, 1); pushing: how many stations push; base: nominal low and high
    side        of the load (see `Walls`); half_levers: see `Walls`
    lever, stiffness, load  of all stations, (q, 1), for what is pressed
    end         where the groove of a plate ends there, with the same columns
    """

    theta: float
    stop: int
    dwell: bool
    columns: npt.NDArray[np.intp]
    near: Singles
    nominal: Singles
    pushing: int
    lever: Singles
    stiffness: Singles
    load: float
    side: float
    half_levers: tuple[float, float]
    base: tuple[float, float]
    end: End | None = None

    def bounds(self, x: Singles) -> tuple[Singles, Reals, Reals]:
        """Approaches over |lever| of machines x (columns, size), (q, size), rigid bounds low, high (size,)."""
        near = self.near @ x[self.columns]
        near += self.nominal
        low: Reals = near[: self.pushing].max(axis=0, initial=-np.inf)
        high: Reals = -near[self.pushing :].max(axis=0, initial=-np.inf)
        if self.end is not None:
            first, second = self.end.insets(x[self.columns])
            low, high = low + first, high - second
        return near, low, high

    def balanced(self, near: Singles, low: Reals, high: Reals) -> Floats:
        """Where what is pressed stands, (r,), of approaches (q, r) and bounds (r,)."""
        load = np.full(1, self.load)
        ends = bracket(low, high, room(self.lever, self.stiffness, load))
        return balance(near * np.abs(self.lever), self.lever, self.stiffness, load, *ends, self._start(near))

    @cached_property
    def pull(self) -> Singles:
        """What an approach over |lever| of each station adds to the follower's load, (q,): what pushes above zero."""
        return np.asarray(-self.lever * np.abs(self.lever) * self.stiffness)[:, 0]

    @cached_property
    def _linear(self) -> Singles:
        """What they move the follower by as long as what presses nominally does, (q,); NaN where nothing does."""
        away = np.sign(self.lever) * self.base[0] + self.nominal > 0.0
        pull = np.where(away[:, 0], self.pull, 0.0)
        return np.asarray(pull / (np.abs(pull).sum() or np.nan), dtype=SINGLE)

    def _start(self, near: Singles) -> Floats:
        """Where what is pressed is looked for first, (r,): where it stands if the same stations press as nominally."""
        return np.asarray(self.base[0] + self._linear @ (near - self.nominal), dtype=np.float64)

    def excess(self, near: Singles, psi: Singles, room: Singles) -> Singles:
        """Load, (n,), that approaches (q, n) give at psi (n,) beyond what is asked: it falls with psi; room: (q, n),
        overwritten."""
        first = self.pushing
        np.maximum(near[:first], psi, out=room[:first])
        np.maximum(near[first:], -psi, out=room[first:])
        given: Singles = self.pull @ room
        given -= psi * self._hard
        given -= SINGLE(self.load)
        return given

    @cached_property
    def _hard(self) -> np.float32:
        """What all of them take off together as the follower moves on by a unit."""
        return SINGLE(np.abs(self.pull).sum())

    def pressure(self, near: Singles, low: Reals, high: Reals, square: Singles) -> Floats:
        """Largest pressure of approaches (q, r) with bounds (r,), MPa, (r,); square: see `Machines._hard`."""
        psi = self.balanced(near, low.astype(np.float64), high.astype(np.float64))
        pressed = np.maximum(near * np.abs(self.lever) + self.lever * psi.astype(SINGLE), 0.0)
        return np.asarray(np.sqrt((square * pressed).max(axis=0)), dtype=np.float64)


@final
@immutable
class Order:
    """In what order a machine's numbers lie, so that what counts at a place lies together: a product then takes one
    stretch of them. What is the same at all stops comes first, then roller after roller, and once more the first two,
    with what turns with the turret among them. rows: of its numbers, (l,), some more than once; None: as they are.
    """

    numbers: int
    rows: npt.NDArray[np.intp] | None = None

    @classmethod
    def of(cls, still: Sequence[int], turret: Sequence[int], rollers: Sequence[Sequence[int]], numbers: int) -> Order:
        """Of machines with so many numbers: those of neither turret nor rollers, of the turret, of each roller."""
        rows = list(still)
        for i in range(len(rollers) + 2 if rollers else 0):
            rows += [*(turret if i % 2 == 0 else ()), *rollers[i % len(rollers)]]
        return cls(numbers, np.array(rows if rollers else [*still, *turret], dtype=np.intp))

    def ordered(self, x: Singles) -> Singles:
        """The numbers x (c, n) of machines in this order, (l, n)."""
        return x if self.rows is None else x.take(self.rows, axis=0)

    @cached_property
    def _next(self) -> npt.NDArray[np.intp]:
        """Where each number comes next from each row on, (l, c); l where it does not."""
        rows = np.arange(self.numbers) if self.rows is None else self.rows
        found = np.full((len(rows) + 1, self.numbers), len(rows))
        for i in range(len(rows) - 1, -1, -1):
            found[i] = found[i + 1]
            found[i, rows[i]] = i
        return found[:-1]

    def stretch(self, near: Singles) -> tuple[slice, Singles]:
        """The shortest stretch that has all numbers by which near (q, c) is not zero, and near by these, (q, s)."""
        used = np.flatnonzero(near.any(axis=0))
        if not len(used):
            return slice(0), np.zeros((len(near), 0), dtype=SINGLE)
        end = self._next[:, used].max(axis=1) + 1
        start = int(np.argmin(np.where(end <= len(end), end - np.arange(len(end)), len(end) + 1)))
        found = np.zeros((len(near), int(end[start]) - start), dtype=SINGLE)
        found[:, self._next[start, used] - start] = near[:, used]
        return slice(start, int(end[start])), found


@final
@immutable
class Abreast:
    """Positions of a cam angle, whose machines are judged at once as if they were as many more.

    at     one of them: where they differ is in near alone
    near   as of a position, by all numbers of a machine, the last one with what is nominal, (p, q, c)
    order  of the numbers it is asked with
    alike  of each position the one of others, whose followers rest in the same places, to which numbers that turn
           with the cam alone add what they do; near is then (1, q, c); None: none is
    """

    at: Position
    near: Singles
    order: Order
    alike: tuple[int, ...] | None = None

    @classmethod
    def of(cls, each: Sequence[Position], order: Order) -> Abreast:
        """Of positions."""
        near = np.zeros((len(each), len(each[0].near), order.numbers), dtype=SINGLE)
        for one, mine in zip(each, near):
            mine[:, one.columns] = one.near
        near[..., -1] = each[0].nominal[:, 0]
        return cls(each[0], near, order)

    def still(self, turning: Bools) -> Abreast:
        """What does not turn with the cam."""
        return replace(self, near=np.where(turning, SINGLE(0.0), self.near))

    def beside(self, others: Abreast, turning: Bools) -> Abreast:
        """The same, told by what others have in common with it, if each of its positions is one of them."""
        turned, still = np.where(turning, self.near, SINGLE(0.0)), self.still(turning).near
        if self.at.end is not None or still.shape[1] != others.near.shape[1] or np.ptp(turned, axis=0).any():
            return self
        apart = np.abs(still[:, None] - others.near).max(axis=(2, 3))
        if apart.min(axis=1).max() > ROUNDED * np.abs(others.near).max():
            return self
        return replace(self, near=turned[:1], alike=tuple(apart.argmin(axis=1).tolist()))

    @cached_property
    def _parts(self) -> tuple[tuple[slice, Singles], tuple[tuple[slice, Singles], ...]]:
        """What all positions have in common, and what each has of its own: stretches of the numbers, near by these."""
        common = ~np.ptp(self.near, axis=0).any(axis=0)
        own = tuple(self.order.stretch(np.where(common, SINGLE(0.0), one)) for one in self.near)
        return self.order.stretch(np.where(common, self.near[0], SINGLE(0.0))), own

    def fill(self, x: Singles, near: Singles, others: Singles | None = None) -> None:
        """Fill near, (q, p, n), with approaches of machines x (l, n), in their order; others: of those alike."""
        (stretch, together), own = self._parts
        shared = together @ x[stretch]
        for i, one in enumerate(near.swapaxes(0, 1)):
            if self.alike is not None and others is not None:
                np.add(others[:, self.alike[i]], shared, out=one)
            elif own[i][1].size:
                np.matmul(own[i][1], x[own[i][0]], out=one)
                one += shared
            else:
                one[:] = shared

    def rooms(self, x: Singles, room: Room) -> tuple[Singles, Singles]:
        """Memory of approaches of machines (columns, n): of all positions, (q, p n), and of one, (q, n)."""
        one = len(self.at.near) * x.shape[1]
        every = len(self.near if self.alike is None else self.alike) * one
        return room[:every].reshape(len(self.at.near), -1), room[every : every + one].reshape(-1, x.shape[1])

    def bounds(self, x: Singles, near: Singles, others: Singles | None = None) -> tuple[Singles, Reals, Reals]:
        """As of a position, of machines (l, n), in their order: near (q, p n), which is filled, bounds (p n,); others:
        see `fill`."""
        at = self.at
        if at.end is not None:
            return at.bounds(x)
        self.fill(x, near.reshape(len(near), -1, x.shape[1]), others)
        low: Reals = near[: at.pushing].max(axis=0, initial=-np.inf)
        high: Reals = near[at.pushing :].max(axis=0, initial=-np.inf)
        return near, low, np.negative(high, out=high)

    def press(self, x: Singles, square: Singles, most: Floats, room: Room) -> None:
        """Raise most, MPa, (n,), to the pressures of machines (columns, n) that are larger; square: see `_hard`."""
        at, size = self.at, x.shape[1]
        first, second = self.rooms(x, room)
        near, low, high = self.bounds(x, first)
        weight = square * np.abs(at.lever)
        sides = [(side, sign) for side, sign in ((slice(at.pushing), -1.0), (slice(at.pushing, None), 1.0))
                 if weight[side].any()]  # fmt: skip

        def over() -> Singles:
            # Where the follower stands as soon as a station is pressed harder than known.
            apart = (most * most).astype(SINGLE) / np.maximum(weight, TINY)
            found = np.full((len(low) // size, size), -np.inf, dtype=SINGLE)
            for one, most_over in zip(near.reshape(len(near), -1, size).swapaxes(0, 1), found):
                np.subtract(one, apart, out=second)
                ends = [(sign, -sign * second[side].max(axis=0)) for side, sign in sides]
                for sign, psi in ends:
                    np.maximum(most_over, sign * at.excess(one, psi, second), out=most_over)
            return found

        def settle(rows: Rows) -> None:
            found = at.pressure(taken(near, rows), low[rows], high[rows], square)
            np.maximum.at(most, rows % size, found)

        settle_over(over, settle)


def taken(values: Singles, rows: npt.NDArray[np.intp]) -> Singles:
    """Columns of values (q, n): an index would turn the order of the array round, which then costs three times more."""
    return values if len(rows) == values.shape[1] else values.take(rows, axis=1)


def settle_over(over: Callable[[], Singles], settle: Callable[[Rows], None]) -> None:
    """Settle followers that are over what is known, (p, n), numbered through, few enough at once for a core's cache: of
    many the farthest of each machine first, which leaves few others."""

    def parted(rows: Rows) -> None:
        for start in range(0, len(rows), AT_ONCE):
            settle(rows[start : start + AT_ONCE])

    found = over()
    rows = np.flatnonzero(found > 0.0)
    if len(rows) > found.shape[1] // 2:
        first = found.argmax(axis=0) * found.shape[1] + np.arange(found.shape[1])
        first = first[found.reshape(-1)[first] > 0.0]
        parted(first)
        found = over()
        found.reshape(-1)[first] = 0.0
        rows = np.flatnonzero(found > 0.0)
    parted(rows)
