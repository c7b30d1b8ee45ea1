"""Many machines: all errors drawn at once, and how far the followers of a share of them stand off.

Every machine has its own errors: one of each kind, of each roller and of each wall. An indexer's rollers come round:
at every stop other ones stand beside the cam, so that all stops are judged. Machines are drawn in blocks, each with a
seed of its own, so that the same come out whatever number of workers draws them.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from math import pi
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.motion.program import Program
from camgeom.solid.mechanism import Drive
from camgeom.tolerance.causes import CAUSES, Cause
from camgeom.tolerance.seat import balance, pressures
from camgeom.tolerance.sensitivity import Loaded, Seated
from camgeom.tolerance.spec import Distribution
from camgeom.track import TURN

BLOCK = 2048
"""machines drawn and judged at once: their approaches stay in a core's cache"""
SEED = 19
MOVES = 24
"""cam angles judged in every move"""
DWELLS = (0.02, 0.5, 0.98)
"""shares of a dwell at which it is judged at every stop"""
WAVE = 18
"""cam angles of dwells judged in one wave of what turns with the cam, at the first stop"""
SINGLE = np.float32
Singles = npt.NDArray[np.float32]
"""of a machine's numbers: a deviation of seconds of arc is good to a hundred thousandth of one"""
EXPLAINED = 20
"""blocks from which the contributions are told"""
Spreads = Mapping[str, tuple[float, float, Distribution]]
"""mean, half width, mm or rad, and distribution of the errors by key"""


@final
@dataclass(frozen=True)
class Column:
    """One random number of a machine: which error, whose (roller, wall; 0 else), which of its parts."""

    cause: Cause
    owner: int
    part: int


@final
@dataclass(frozen=True, eq=False)
class Position:
    """A cam angle at a stop: how the columns bring each station nearer, as deviations of the coordinate.

    push, hold  (q, c): approach over |lever| per unit of a column, mm or rad, of the stations that push and hold
    nominal     the same without errors, (q,) of both; base: nominal low and high; side: of the load (see `Walls`)
    lever, stiffness, load  of all stations, pushing ones first, for what is pressed; half_levers: see `Walls`
    """

    theta: float
    stop: int
    dwell: bool
    columns: npt.NDArray[np.intp]
    push: Singles
    hold: Singles
    nominal_push: Singles
    nominal_hold: Singles
    lever: Singles
    stiffness: Singles
    load: float
    side: float
    half_levers: tuple[float, float]
    base: tuple[float, float]


@final
@dataclass(frozen=True, eq=False)
class Drawn:
    """What the machines do, one figure a machine, (s,): mm or rad.

    dwell, motion  largest deviation in the dwells (of a program without one: anywhere), and anywhere
    backlash       largest play in the dwells; preload: least normal interference there, mm, below zero half the play
    pressure       largest contact pressure at the cam angle that is nominally the hardest, MPa; None of no line contact
    shares         part of the variance of the deviation that each error explains, by key
    """

    dwell: Floats
    motion: Floats
    backlash: Floats
    preload: Floats
    pressure: Floats | None
    shares: dict[str, float]

    def at_yield(self, figure: Floats, share: float) -> float:
        """The value that a share of the machines does not exceed."""
        ranked = np.sort(figure)
        return float(ranked[min(len(ranked) - 1, int(np.ceil(share * len(ranked))) - 1)])


def share_within(figure: Floats, limit: float) -> float:
    """Share of the machines whose figure is within a limit."""
    return float(np.mean(figure <= limit))


@final
@dataclass(frozen=True, eq=False)
class Machines:
    """A mechanism whose errors scatter.

    spreads   of the errors by key
    relative  deviations from where each machine stands in the first dwell of its first stop
    hardest   cam angle, rad, at which the pressure is asked, at the first stop; None where none is
    """

    loaded: Loaded
    spreads: Spreads
    relative: bool = False
    hardest: float | None = None

    @cached_property
    def columns(self) -> tuple[Column, ...]:
        """The random numbers of a machine."""
        at = self._seated.contacts
        owners = {"roller": range(at.rollers), "wall": sorted(set(at.wall.tolist()))}
        return tuple(
            Column(CAUSES[key], owner, part)
            for key in self.spreads
            for owner in owners.get(CAUSES[key].holder, range(1))
            for part in range(CAUSES[key].parts)
        )

    @cached_property
    def _angles(self) -> tuple[Floats, int, int]:
        """Cam angles judged, rad: of dwells, the first one's middle first, further ones of dwells, those of moves; and
        the numbers of the first two."""
        dwells, between, moves = [], [], []
        for start, end, still in resting(self.loaded.mechanism.program):
            if still:
                dwells.append([(start + share * (end - start)) % TURN for share in DWELLS])
                count = int(np.ceil((end - start) / TURN * WAVE * self._waves))
                between.append((start + (np.arange(count) + 0.5) / max(count, 1) * (end - start)) % TURN)
            else:
                moves.append(start + (np.arange(MOVES) + 0.5) / MOVES * (end - start))
        first = [dwells[0][1], dwells[0][0], dwells[0][2]] if dwells else []
        rest = np.asarray(first + [angle for dwell in dwells[1:] for angle in dwell])
        more, moving = (np.concatenate(some) if some else np.zeros(0) for some in (between, moves))
        return np.concatenate([rest, more, moving]), len(rest), len(more)

    @property
    def _waves(self) -> int:
        """Waves in a cam turn of what turns with the cam; 0 where nothing does."""
        turning = [cause for cause in map(CAUSES.__getitem__, self.spreads) if cause.holder == "cam"]
        form = self.loaded.pivots.waves if "flank_form" in self.spreads else 0
        return max(form, 1 if turning else 0)

    @cached_property
    def _seated(self) -> Seated:
        return self.loaded.at(self._angles[0])

    @cached_property
    def _hard(self) -> tuple[Position, Singles] | None:
        """Where the pressure is asked, and the square of the pressure per approach of its stations, MPa²/mm, (q,)."""
        if self.hardest is None:
            return None
        seated = self.loaded.at(np.array([self.hardest]))
        position = self._position(seated, 0, 0, 0, False)
        on = np.isfinite(seated.walls.approach[0])
        order = np.r_[np.flatnonzero(on & (seated.walls.lever[0] < 0.0)), np.flatnonzero(seated.walls.holds[0])]
        one = pressures(seated.contacts, seated.walls.stiffness, self.loaded.roller, self.loaded.cam)[0, order]
        return position, (one * one).astype(SINGLE)

    @cached_property
    def stops(self) -> tuple[int, float]:
        """How many stops bring other rollers beside the cam, and by how many rollers the turret steps."""
        turret = self.loaded.mechanism.turret
        advance = self.loaded.mechanism.program.advance
        if turret is None or not advance:
            return 1, 0
        count = turret.follower.count
        step = round(abs(advance) / (TURN / count))
        return count // int(np.gcd(count, step)), step

    @cached_property
    def positions(self) -> tuple[Position, ...]:
        """Every place judged: dwells at all stops, moves from the first."""
        theta, dwells, more = self._angles
        stops, step = self.stops
        own = bool({"roller", "turret"} & {CAUSES[key].holder for key in self.spreads})
        found = []
        for row in range(len(theta)):
            for stop in range(stops if row < dwells and own else 1):
                found.append(self._position(self._seated, row, stop, int(step), row < dwells + more))
        return tuple(found)

    def _position(self, seated: Seated, row: int, stop: int, step: int, dwell: bool) -> Position:
        walls, at = seated.walls, seated.contacts
        on = at.on[row].reshape(-1)
        lines = np.repeat(np.arange(at.on.shape[1]), at.on.shape[2])
        rollers = (at.roller - stop * step) % at.rollers if self.loaded.mechanism.turret is not None else at.roller
        owners = {"roller": rollers, "wall": at.wall}
        turned = stop * self.loaded.mechanism.program.advance
        used, rows = [], []
        for index, column in enumerate(self.columns):
            g = seated.approaches.of(column.cause)[:, row]
            mine = g[column.part]
            if column.cause.holder == "turret":
                other = g[1 - column.part] * (1.0 if column.part == 0 else -1.0)
                mine = np.cos(turned) * mine + np.sin(turned) * other
            flat = mine.reshape(-1)
            if column.cause.holder in owners:
                flat = flat * (owners[column.cause.holder] == column.owner)[lines]
            if np.any(flat[on]):
                used.append(index)
                rows.append(flat)
        lever = walls.lever[row]
        push, hold = on & (lever < 0.0), on & (lever > 0.0)
        g = np.array(rows).reshape(len(rows), len(on)).T / np.abs(lever)[:, None]
        nominal = np.where(on, walls.approach[row], 0.0) / np.abs(lever)
        order = np.r_[np.flatnonzero(push), np.flatnonzero(hold)]
        pressed, free = walls.half_levers
        base = float(seated.nominal.low[row]), float(seated.nominal.high[row])
        return Position(
            float(at.theta[row]), stop, dwell, np.array(used, dtype=np.intp), g[push].astype(SINGLE),
            g[hold].astype(SINGLE), nominal[push].astype(SINGLE), nominal[hold].astype(SINGLE),
            lever[order].astype(SINGLE), walls.stiffness[row, order].astype(SINGLE), float(walls.load[row]),
            float(walls.load_side[row]), (float(pressed[row]), float(free[row])), base,
        )  # fmt: skip

    def drawn(self, samples: int, workers: int = 2) -> Drawn:
        """Figures of so many machines; the same ones whatever the number of workers."""
        sizes = [min(BLOCK, samples - first) for first in range(0, samples, BLOCK)]
        # Made once, before the workers share them.
        self.positions, self._hard  # noqa: B018

        def judged(block: int) -> tuple[Floats, Floats | None]:
            return self._block(block, sizes[block])

        with ThreadPoolExecutor(max(1, workers)) as pool:
            found = list(pool.map(judged, range(len(sizes))))
        figures = np.concatenate([figure for figure, _ in found], axis=1)
        told = [shares for _, shares in found[:EXPLAINED] if shares is not None]
        shares = np.mean(told, axis=0) if told else np.zeros(0)
        by_key = dict.fromkeys(self.spreads, 0.0)
        for column, share in zip(self.columns, shares):
            by_key[column.cause.key] += float(share)
        by_key = {key: max(0.0, share) for key, share in by_key.items()}
        dwell, motion, backlash, preload, pressure = figures
        return Drawn(dwell, motion, backlash, preload, pressure if self._hard is not None else None, by_key)

    def _block(self, block: int, size: int) -> tuple[Floats, Floats | None]:
        """Figures (5, size) of a block, and of early ones the share of the variance each column explains."""
        x = self._numbers(np.random.default_rng([SEED, block]), size)
        worst, rest, loose = np.zeros(size), np.zeros(size), np.full(size, -np.inf)
        tight = np.full(size, np.inf)
        none = not any(position.dwell for position in self.positions)
        reference: tuple[Floats, Floats] | None = None
        explained = []
        for position in self.positions:
            low, high, play = self._stand(position, x[position.columns])
            base_low, base_high = position.base
            low, high = low - base_low, high - base_high
            if self.relative:
                reference = reference or (low, high)
                off = np.maximum(high - reference[0], reference[1] - low)
                off = np.zeros(size) if reference[0] is low else off
            else:
                off = np.maximum(np.abs(low), np.abs(high))
            np.maximum(worst, off, out=worst)
            if position.dwell or none:
                np.maximum(rest, off, out=rest)
                np.maximum(loose, play, out=loose)
                levers = np.where(play < 0.0, *position.half_levers)
                np.minimum(tight, -play * levers, out=tight)
            if block < EXPLAINED and (position.dwell or none):
                middle = 0.5 * (low + high) - (0.5 * (reference[0] + reference[1]) if reference else 0.0)
                explained.append(_explained(x, np.arange(len(x)) if reference else position.columns, middle))
        figures = np.stack([rest, worst, np.maximum(loose, 0.0), tight, self._pressure(x)])
        return figures, np.mean(explained, axis=0) if explained else None

    def _pressure(self, x: Singles) -> Floats:
        """Largest pressure of machines (columns, size) where it is asked, MPa; 0 where it is not."""
        if self._hard is None:
            return np.zeros(x.shape[1])
        position, square = self._hard
        own = x[position.columns]
        push = position.push @ own + position.nominal_push[:, None]
        hold = position.hold @ own + position.nominal_hold[:, None]
        low = push.max(axis=0, initial=-np.inf).astype(np.float64)
        high = -hold.max(axis=0, initial=-np.inf).astype(np.float64)
        lever = position.lever[:, None]
        approach = np.concatenate([push, hold]) * np.abs(lever)
        psi = balance(approach, lever, position.stiffness[:, None], np.full(1, position.load), low, high)
        pressed = np.maximum(approach + lever * psi.astype(SINGLE), 0.0)
        return np.asarray(np.sqrt((square[:, None] * pressed).max(axis=0)), dtype=np.float64)

    def _numbers(self, rng: np.random.Generator, size: int) -> Singles:
        """The errors of machines, (columns, size), mm or rad."""
        x = np.empty((len(self.columns), size), dtype=SINGLE)
        row = 0
        while row < len(self.columns):
            column = self.columns[row]
            mean, value, how = self.spreads[column.cause.key]
            if column.cause.parts == 2:
                x[row : row + 2] = _direction(rng, size, value, how)
                row += 2
                continue
            if how == "normal":
                x[row] = mean + value / 3.0 * rng.standard_normal(size, dtype=SINGLE)
            elif how == "uniform":
                x[row] = mean + value * (2.0 * rng.random(size, dtype=SINGLE) - 1.0)
            else:
                x[row] = mean + value * np.where(rng.random(size, dtype=SINGLE) < 0.5, -1.0, 1.0)
            row += 1
        return x

    def _stand(self, position: Position, x: Singles) -> tuple[Floats, Floats, Floats]:
        """low, high and play (size,) of machines at a position; see `seat.Walls.stand`."""
        size = x.shape[1]
        push = position.push @ x
        push += position.nominal_push[:, None]
        low = push.max(axis=0) if len(push) else np.full(size, -np.inf)
        if self.loaded.mechanism.drive is Drive.ALONE:
            return low, low, np.full(size, np.inf)
        hold = position.hold @ x
        hold += position.nominal_hold[:, None]
        high = -hold.max(axis=0) if len(hold) else np.full(size, np.inf)
        play, side = high - low, position.side
        if self.loaded.mechanism.drive is Drive.OPPOSED and side:
            one = low if side > 0.0 else high
            return one, one, play
        pressed = np.flatnonzero(play < 0.0) if side == 0.0 else np.arange(size)
        if len(pressed):
            low, high = low.astype(np.float64), high.astype(np.float64)
            lever = np.abs(position.lever)[:, None]
            approach = np.concatenate([push[:, pressed], hold[:, pressed]]) * lever
            start = np.full(1, position.base[0]) if side else None
            psi = balance(
                approach, position.lever[:, None], position.stiffness[:, None], np.full(1, position.load),
                low[pressed], high[pressed], start,
            )  # fmt: skip
            low[pressed] = high[pressed] = psi
        return low, high, play


def resting(program: Program) -> list[tuple[float, float, bool]]:
    """Stretches of cam angle (from, to), rad, and whether the follower rests; a dwell over the turn's end is one, which
    begins before it."""
    runs: list[tuple[float, float, bool]] = []
    for span in program.spans:
        still = span.before == span.after
        if still and runs and runs[-1][2]:
            runs[-1] = runs[-1][0], span.end, True
        else:
            runs.append((span.start, span.end, still))
    if len(runs) > 1 and runs[0][2] and runs[-1][2]:
        runs = [(runs[-1][0] - TURN, runs[0][1], True), *runs[1:-1]]
    return runs


def _direction(rng: np.random.Generator, size: int, value: float, how: Distribution) -> Singles:
    """Errors of any direction, (2, size): both parts normal, evenly over a disc, or on its rim."""
    if how == "normal":
        return np.asarray(value / 3.0 * rng.standard_normal((2, size), dtype=SINGLE))
    angle = 2.0 * pi * rng.random(size, dtype=SINGLE)
    radius = value * np.sqrt(rng.random(size, dtype=SINGLE)) if how == "uniform" else value
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)])


def _explained(x: Singles, used: npt.NDArray[np.intp], deviation: Floats) -> Floats:
    """Share of the variance of a deviation (size,) that each column (c, size) explains alone, by its correlation."""
    off = np.asarray(deviation - deviation.mean(), dtype=np.float64)
    total = float(off @ off)
    shares = np.zeros(len(x))
    if total > 0.0:
        own = np.asarray(x[used] - x[used].mean(axis=1, keepdims=True), dtype=np.float64)
        square = (own * own).sum(axis=1)
        found = np.divide((own @ off) ** 2, square * total, out=np.zeros(len(used)), where=square > 0.0)
        # Numbers that have nothing to do with it correlate by chance: 1 / (n - 1) on the average.
        shares[used] = np.where(square > 0.0, found - 1.0 / (len(off) - 1), 0.0)
    return shares
