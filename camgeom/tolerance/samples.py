"""Many machines: all errors drawn at once, and how far the followers of a share of them stand off.

Every machine has its own errors: one of each kind, of each roller and of each wall. An indexer's rollers come round:
at every stop other ones stand beside the cam, so that all stops are judged. Machines are drawn in blocks, each with a
seed of its own, so that the same come out whatever number of workers draws them. Further followers of a machine have
the errors of its body (of their track's walls) as the first one there has them, and else errors of their own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import pi
from typing import TypeVar, final

import numpy as np
import numpy.typing as npt

from camgeom.errors import NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.maths.threads import shared
from camgeom.solid.mechanism import Drive
from camgeom.tolerance.causes import CAUSES, NORMAL, Cause, Sharing
from camgeom.tolerance.ends import Ends
from camgeom.tolerance.places import SINGLE, Abreast, End, Order, Position, Room, Rows, settle_over, taken
from camgeom.tolerance.seat import Bools, Reals, pressures
from camgeom.tolerance.sensitivity import Loaded, Seated, Sensitivities, resting
from camgeom.tolerance.shares import Singles, Sums, first_order, sums_of
from camgeom.tolerance.spec import Distribution
from camgeom.track import TURN

BLOCK = 2048
"""machines drawn with one seed"""
TOGETHER = 4
"""blocks judged at once: so many that two workers seldom wait for each other between the steps of numpy (measured: 1
costs a fifth more, 2 a tenth), and no more memory than helps"""
ABREAST = 8
"""positions of a cam angle judged at once"""
SEED = 19
MOVES = 24
"""cam angles judged in every move"""
DWELLS = (0.02, 0.5, 0.98)
"""shares of a dwell at which it is judged at every stop"""
SLID = (1e-9, 0.5, 1.0 - 1e-9)
"""of a plate, whose yaw moves the follower most at an end of its dwell"""
KEPT = 400_000_000
"""bytes of numbers of machines that are kept between what is asked where they rest, move and press"""
SPENT = 8.0
"""s of one core that one drawing of the machines may take, where they rest and where they move; all take up to three
times that"""
STATION = 8e-9
"""s of one core for a machine at a station (measured 5e-9 to 8e-9)"""
PLACE, A_NUMBER = 7e-4, 2e-5
"""s of one core before a machine is judged at a place, and more for each number of one (measured 4e-4 to 9e-4 with 18,
1.5e-3 to 3e-3 with 121)"""
ASKED = 12_000
"""cam angles of the turn, at most, at which pilots are asked what presses them (measured 1 to 2 ms each)"""
WAVE = 18
"""cam angles of dwells judged in one wave of what turns with the cam, at the first stop"""
PILOTS = 512
"""machines that say at which cam angles the others are asked, by what they tell at the first stop"""
SHORT = 0.015
"""share by which the largest figures of them there fall short of those at all angles, on the mean; of all stops they
then tell what 99 % of the machines keep within 0.5 %"""
EXPLAINED = 16
"""blocks from which the contributions are told, 32 768 machines: a share r² of the variance is then good to its
standard error 2 r sqrt((1 - r²) / n), at most 0.007"""
TOLD = 64
"""places of rest whose outcomes are held at once, 4 MB of four blocks"""
Judged = TypeVar("Judged")
Spreads = Mapping[str, tuple[float, float, Distribution]]
"""mean, half width, mm or rad, and distribution of the errors by key"""


@final
@immutable(eq=True)
class Column:
    """One random number of a machine: which error, whose (roller, wall; 0 else), which of its parts."""

    cause: Cause
    owner: int
    part: int


Zero = tuple[Reals, Reals]
"""low and high, (size,), of machines where they are set to zero"""


@final
@immutable
class Drawn:
    """What the machines do, one figure a machine, (s,): mm or rad.

    dwell    largest deviation in the dwells (of a program without one: anywhere)
    backlash largest play in the dwells; preload: least normal interference there, mm, below zero half the play
    """

    machines: Machines
    workers: int
    dwell: Floats
    backlash: Floats
    preload: Floats

    @cached_property
    def shares(self) -> dict[str, float]:
        """Part of the variance in the dwells that each error explains alone, by key (see `shares`)."""
        return self.machines.explained(len(self.dwell), self.workers)

    @property
    def together(self) -> float:
        """Part of the variance that errors explain together alone, one by the size of another; 0 where none vary."""
        alone = sum(self.shares.values())
        return max(0.0, 1.0 - alone) if alone else 0.0

    @cached_property
    def motion(self) -> Floats:
        """Largest deviation anywhere."""
        return self.machines.moved(self.dwell, self.workers)

    @cached_property
    def pressure(self) -> Floats | None:
        """Largest contact pressure, MPa; None of no line contact."""
        return self.machines.pressed(len(self.dwell), self.workers)

    def figure(self, name: str) -> Floats:
        """The figure that has a limit: dwell, motion or backlash."""
        return self.motion if name == "motion" else self.dwell if name == "dwell" else self.backlash

    @cached_property
    def ended(self) -> Floats | None:
        """How far errors carry the roller of a plate towards the ends of its groove, mm; None of a groove without."""
        return self.machines.ended(len(self.dwell), self.workers)

    def at_yield(self, figure: Floats, share: float) -> float:
        """The value that a share of the machines does not exceed."""
        ranked = np.sort(figure)
        return float(ranked[min(len(ranked) - 1, int(np.ceil(share * len(ranked))) - 1)])


@final
@immutable
class Machines:
    """A mechanism whose errors scatter.

    spreads   of the errors by key
    relative  deviations from where each machine stands in the first dwell of its first stop
    number    of the follower on the cam, 0 of the first
    kin       the same machines as followers before it have them, by what they share with it
    spent     s of one core that one drawing of them may take
    least     of them that tell what is asked
    """

    table: Sensitivities
    spreads: Spreads
    relative: bool = False
    number: int = 0
    kin: tuple[tuple[Sharing, Machines], ...] = ()
    spent: float = SPENT
    least: int = 1

    @property
    def loaded(self) -> Loaded:
        """The mechanism and its loads."""
        return self.table.loaded

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
        shares = DWELLS if self.loaded.mechanism.carriage is None else SLID
        for start, end, still in resting(self.loaded.mechanism.program):
            if still:
                dwells.append([(start + share * (end - start)) % TURN for share in shares])
                count = int(np.ceil((end - start) / TURN * WAVE * self._waves * self._rate(start, end)))
                between.append((start + (np.arange(count) + 0.5) / max(count, 1) * (end - start)) % TURN)
            else:
                moves.append(start + (np.arange(MOVES) + 0.5) / MOVES * (end - start))
        if (carriage := self.loaded.mechanism.carriage) is not None:
            for turn in (0.0, carriage.turned):
                rests = any(still and (start <= turn <= end or turn >= start + TURN)
                            for start, end, still in resting(self.loaded.mechanism.program))  # fmt: skip
                (between if rests else moves).append(np.array([turn]))
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

    def _rate(self, start: float, end: float) -> float:
        """How fast a wave goes by in a dwell at most, rad per rad of the cam: 1 on what turns with it."""
        carriage = self.loaded.mechanism.carriage
        if carriage is None:
            return 1.0
        return float(carriage.pace(np.linspace(start, end, 65) % TURN).max()) * TURN / carriage.stroke

    @cached_property
    def _seated(self) -> Seated:
        return self.loaded.at(self._angles[0])

    @cached_property
    def _hard(self) -> tuple[tuple[Position, Singles], ...]:
        """Where the pressure is asked, at all stops, and there the square of the pressure per approach of the stations,
        MPa²/mm, (q, 1): cam angles at which some machines' is the largest, most of them at the first."""
        if self.table.hard is None:
            return ()
        count = len(self.table.theta)
        if count > ASKED:
            raise NotConverged(
                f"what presses machines would be asked at {count} cam angles of the turn, at most {ASKED} are paid "
                "for: fewer segments of the motion, or rows of tables of forces"
            )
        pressures = [_pressure(*self._pressed(row, 1)[0], self._pilots) for row in range(len(self.table.theta))]
        return tuple(asked for row in telling(np.array([pressures])) for asked in self._pressed(row, self._stops))

    @cached_property
    def _pilots(self) -> Singles:
        """Numbers of the first machines, (columns, PILOTS)."""
        return self._numbers(np.random.default_rng([SEED, 0]), PILOTS)

    def _pressed(self, row: int, stops: int) -> list[tuple[Position, Singles]]:
        """An angle of the table at so many stops, and the squares of `_hard`."""
        seated = self.table.seated
        walls, on = seated.walls, np.isfinite(seated.walls.approach[row])
        order = np.r_[np.flatnonzero(on & (walls.lever[row] < 0.0)), np.flatnonzero(on & (walls.lever[row] > 0.0))]
        one = self._per_approach[row, order]
        square = (one * one).astype(SINGLE)[:, None]
        return [(position, square) for position in self._positions(seated, row, stops, False)]

    @cached_property
    def _per_approach(self) -> Floats:
        """Pressure of every station per root of its approach, (n, q)."""
        seated = self.table.seated
        return pressures(seated.contacts, seated.walls.stiffness, self.loaded.roller, self.loaded.cam)

    @cached_property
    def stops(self) -> tuple[int, int]:
        """How many stops bring other rollers beside the cam, and by how many rollers the turret steps."""
        turret = self.loaded.mechanism.turret
        advance = self.loaded.mechanism.program.advance
        if turret is None or not advance:
            return 1, 0
        count = turret.follower.count
        step = round(abs(advance) / (TURN / count))
        return count // int(np.gcd(count, step)), step

    @property
    def positions(self) -> tuple[Position, ...]:
        """Every place judged, at all stops."""
        return self.resting + self.moving

    @cached_property
    def resting(self) -> tuple[Position, ...]:
        """The places of dwells, the middle of the first dwell first; all of a program without one."""
        theta, dwells, more = self._angles
        whole = dwells + more or len(theta)
        rows = [*range(dwells), *self._telling(range(dwells, whole), range(dwells))] if dwells else list(range(whole))
        return tuple(one for row in rows for one in self._positions(self._seated, row, self._stops, dwells > 0))

    def _telling(self, rows: range, known: range = range(0)) -> list[int]:
        """Those of the rows at which pilots stand off, and play, as far as at all of them and at the known ones."""
        if self._stops == 1:
            return list(rows)
        zero: Zero | None = None
        figures = []
        for row in (*known, *rows):
            low, high, play = self._stand(self._positions(self._seated, row, 1, False)[0], self._pilots)
            if self.relative and zero is None:
                zero = low, high
            figures.append((_off(low, high, zero), play))
        return [rows[k - len(known)] for k in telling(np.array(figures).transpose(1, 0, 2), len(known))]

    @cached_property
    def moving(self) -> tuple[Position, ...]:
        """The places of moves; none of a program without a dwell."""
        theta, dwells, more = self._angles
        rows = self._telling(range(dwells + more, len(theta))) if dwells else ()
        return tuple(position for row in rows for position in self._positions(self._seated, row, self._stops, False))

    @cached_property
    def _ends(self) -> Ends | None:
        return Ends.of(self.loaded.mechanism, self.loaded.pivots)

    @cached_property
    def ends(self) -> tuple[End, ...]:
        """The ends of a plate's groove, with all columns; none of a groove without."""
        ends = self._ends
        if ends is None:
            return ()
        at = ends.at
        owners = {"roller": at.roller, "wall": at.wall}
        each = np.zeros((2, *at.on.shape, len(self.columns)))
        for i, column in enumerate(self.columns):
            g, owner = ends.moved(column.cause)[column.part], owners.get(column.cause.holder)
            own = g if owner is None else g * (owner == column.owner)[:, None]
            each[int(column.cause.key in NORMAL), ..., i] = own
        way, growth = each.reshape(2, 2, at.on[0].size, len(self.columns))
        beside, lever = (v.reshape(2, -1, 1) for v in (ends.beside, ends.flank.lever))
        return tuple(End(way[k], growth[k], beside[k], lever[k], ends.room) for k in range(2))

    def _end(self, theta: float) -> End | None:
        """The one at a cam angle."""
        if self._ends is None:
            return None
        found = np.flatnonzero(self._ends.there(np.array([theta % TURN]))[:, 0])
        return self.ends[int(found[0])] if len(found) else None

    def _positions(self, seated: Seated, row: int, stops: int, dwell: bool) -> list[Position]:
        """A cam angle at so many stops."""
        walls, at = seated.walls, seated.contacts
        lever = walls.lever[row]
        on = at.on[row].reshape(-1)
        push, hold = on & (lever < 0.0), on & (lever > 0.0)
        order = np.r_[np.flatnonzero(push), np.flatnonzero(hold)]
        size = np.abs(lever[order])
        nominal = (walls.approach[row, order] / size).astype(SINGLE)[:, None]
        line = order // at.on.shape[2]
        roller, wall = at.roller[line][:, None], at.wall[line][:, None]
        turret = self.loaded.mechanism.turret is not None
        holders, owner, way = self._held
        each = [(seated.approaches.of(column.cause)[:, row].reshape(column.cause.parts, -1)[:, order], column.part)
                for column in self.columns]  # fmt: skip
        mine = np.stack([g[part] for g, part in each], axis=1)
        other = np.stack([g[-1 - part] for g, part in each], axis=1)
        stiffness = walls.stiffness[row, order].astype(SINGLE)[:, None]
        pressed, free = walls.half_levers
        end, base = self._end(float(at.theta[row])), (float(seated.nominal.low[row]), float(seated.nominal.high[row]))
        if end is not None:
            base = _inside(end, base, float(walls.load_side[row]))
        found = []
        for stop in range(stops):
            turned = stop * self.loaded.mechanism.program.advance
            rollers = (roller - stop * int(self.stops[1])) % at.rollers if turret else roller
            g = np.where(holders == "turret", np.cos(turned) * mine + np.sin(turned) * way * other, mine)
            beside = np.where(holders == "roller", rollers == owner, (holders != "wall") | (wall == owner))
            g = np.where(beside, g, 0.0)
            any_of = g.any(axis=0)
            if end is not None:
                any_of |= end.way.any(axis=0) | end.growth.any(axis=0)
            used = np.flatnonzero(any_of)
            found.append(Position(
                float(at.theta[row]), stop, dwell, used, (g[:, used] / size[:, None]).astype(SINGLE), nominal,
                int(push.sum()), lever[order].astype(SINGLE)[:, None], stiffness,
                float(walls.load[row]), float(walls.load_side[row]), (float(pressed[row]), float(free[row])),
                base, None if end is None else replace(end, way=end.way[:, used], growth=end.growth[:, used]),
            ))  # fmt: skip
        return found

    @cached_property
    def _held(self) -> tuple[npt.NDArray[np.str_], npt.NDArray[np.intp], Floats]:
        """Of each column, (c,): who holds it, whose it is, and the sign of what its other part turns to."""
        return (
            np.array([column.cause.holder for column in self.columns]),
            np.array([column.owner for column in self.columns], dtype=np.intp),
            np.array([1.0 if column.part == 0 else -1.0 for column in self.columns]),
        )

    @cached_property
    def cost(self) -> tuple[float, float]:
        """s of one core that a machine takes where it rests and where it moves."""
        resting, moving = (STATION * sum(len(one.near) for one in places) for places in (self.resting, self.moving))
        return resting, moving

    @property
    def _pressing(self) -> float:
        """s of one core that a machine takes where the pressure is asked."""
        return STATION * sum(len(position.near) for position, _ in self._hard)

    @cached_property
    def places(self) -> tuple[int, float]:
        """At how many places machines are judged, at most, and s of one core of each before the first machine."""
        theta, dwells, _ = self._angles
        return len(theta) + (dwells or len(theta)) * (self._stops - 1), PLACE + A_NUMBER * len(self.columns)

    def _refuse_many(self) -> None:
        """Raise NotConverged, with the figures, where machines would be judged at more places than are paid for."""
        places, each = self.places
        if places * each > self.spent:
            stops = f", those of rest at {self._stops} stops each" if self._stops > 1 else ""
            raise NotConverged(
                f"machines would be judged at {places} places ({MOVES} cam angles of a move, {len(DWELLS)} and more of "
                f"a dwell{stops}), more than the {int(self.spent / each)} that are paid for: fewer segments of the "
                f"motion{self.or_waves(places * each / self.spent)}"
            )

    def _refuse_long(self, samples: int, each: float) -> None:
        """Raise NotConverged, with the figures, where so many machines take more than is spent."""
        if samples * each > self.spent:
            most = int(self.spent / max(each, *self.cost, self._pressing))  # so many may be drawn for all that is asked
            enough = f"at most {most} of tolerance.samples" if most >= self.least else "fewer segments of the motion"
            raise NotConverged(
                f"{samples} machines would take about {samples * each:.3g} s of one core, more than the "
                f"{self.spent:.3g} s that are left for one drawing of them: {enough}"
                f"{self.or_waves(samples * each / self.spent)}"
            )

    def or_waves(self, over: float) -> str:
        """Advice on waves of the flank, where a single one needs so many times less."""
        theta, dwells, more = self._angles
        left = len(theta) - more * (1.0 - 1.0 / max(self._waves, 1))
        left += (dwells or left) * (self._stops - 1)  # of rest at every stop, which no wave asks for
        return ", or fewer tolerance.flank_waves" if left * over < 0.9 * self.places[0] and self._waves > 1 else ""

    @property
    def _stops(self) -> int:
        """How many stops are told apart."""
        own = {"roller", "turret"} & {CAUSES[key].holder for key in self.spreads}
        return self.stops[0] if own else 1

    def drawn(self, samples: int, workers: int = 2) -> Drawn:
        """Figures of so many machines; the same ones whatever the number of workers. Raises NotConverged for too many.
        """
        self._refuse_many()
        self._refuse_long(samples, self.cost[0])  # places are made once, before the workers share them
        dwell, backlash, preload = np.concatenate(self._judged(self._rest, samples, workers), axis=1)
        return Drawn(self, workers, dwell, backlash, preload)

    def explained(self, samples: int, workers: int = 2) -> dict[str, float]:
        """Part of the variance in the dwells that each error explains alone, by key, from the first of so many."""
        told = first_order(self._judged(self._told, min(samples, EXPLAINED * BLOCK), workers), self._used)
        by_key = dict.fromkeys(self.spreads, 0.0)
        for error, share in zip(self._errors, told):
            by_key[self.columns[error.start].cause.key] += float(share)
        return by_key

    def moved(self, dwell: Floats, workers: int = 2) -> Floats:
        """Largest deviation of machines, (samples,), of which that in the dwells is known: less is not asked."""
        self._refuse_long(len(dwell), self.cost[1])

        def move(block: int, x: Singles) -> Floats:
            return self._move(x, dwell[block * BLOCK :][: x.shape[1]])

        return np.concatenate(self._judged(move, len(dwell), workers))

    def _abreast(self, positions: Sequence[Position]) -> tuple[Abreast, ...]:
        """Positions in turn, those of a cam angle abreast."""
        found = list[list[Position]]()
        for one in positions:
            if not found or found[-1][0].theta != one.theta or len(found[-1]) == ABREAST:
                found.append([])
            found[-1].append(one)
        return tuple(Abreast.of(each, self._order) for each in found)

    @cached_property
    def _order(self) -> Order:
        """In which numbers of machines lie that are judged abreast."""
        numbers = len(self.columns) + 1
        if self._stops == 1:
            return Order(numbers)
        holders, owner, _way = self._held
        whose = range(self._seated.contacts.rollers)
        rollers = [np.flatnonzero((holders == "roller") & (owner == i)).tolist() for i in whose]
        turret = np.flatnonzero(holders == "turret").tolist()
        still = np.flatnonzero((holders != "roller") & (holders != "turret")).tolist()
        return Order.of([*still, numbers - 1], turret, [one for one in rollers if one], numbers)

    @cached_property
    def _rests(self) -> tuple[Abreast, ...]:
        """Where the machines rest, but for where they are set to zero."""
        each = self._abreast(self.resting[1:] if self.relative else self.resting)
        return tuple(one.beside(self._still, self._turning) for one in each) if len(each) > 2 else each

    @cached_property
    def _turning(self) -> Bools:
        """Which numbers of a machine turn with the cam, (columns + 1,), and 1, by which what is nominal counts."""
        return np.array([column.cause.holder in ("cam", "wall") for column in self.columns] + [True])

    @cached_property
    def _still(self) -> Abreast:
        """What those that do not turn do where machines rest, at the stops of one cam angle: in a dwell they do it
        everywhere, and in the next one with the next rollers."""
        return self._abreast(self.resting)[0].still(self._turning)

    @cached_property
    def _moves(self) -> tuple[Abreast, ...]:
        return self._abreast(self.moving)

    @cached_property
    def _presses(self) -> tuple[tuple[Abreast, Singles], ...]:
        """Where the pressure is asked, and the squares of `_hard`."""
        squares = {position.theta: square for position, square in self._hard}
        return tuple((each, squares[each.at.theta]) for each in self._abreast([position for position, _ in self._hard]))

    def ended(self, samples: int, workers: int = 2) -> Floats | None:
        """How far each of those machines carries its roller towards the ends of its groove, mm, (samples,); None of a
        groove without."""
        if not self.ends:
            return None
        found = self._judged(lambda _, x: np.max([end.reach(x[:-1]) for end in self.ends], axis=0), samples, workers)
        return np.concatenate(found)

    def pressed(self, samples: int, workers: int = 2) -> Floats | None:
        """Largest pressure of those machines where it is asked, MPa, (samples,); None of no line contact."""
        if self.table.hard is None:
            return None
        self._refuse_long(samples, self._pressing)
        return np.concatenate(self._judged(lambda _, x: self._press(x), samples, workers))

    def _press(self, x: Singles) -> Floats:
        """Largest pressure of machines (columns, size), MPa, (size,)."""
        most, room = np.zeros(x.shape[1]), _room([each for each, _ in self._presses], x)
        ordered = self._order.ordered(x)
        for each, square in self._presses:
            each.press(ordered, square, most, room)
        return most

    def _judged(self, judge: Callable[[int, Singles], Judged], samples: int, workers: int) -> list[Judged]:
        """What a judge of a block's number and numbers (columns, size) says of that and the next ones, TOGETHER."""
        sizes = [min(BLOCK, samples - first) for first in range(0, samples, BLOCK)]
        keeps = (len(self.columns) + 1) * samples * np.dtype(SINGLE).itemsize <= KEPT

        def judged(block: int) -> Judged:
            x = self._kept.get((block, samples))
            if x is None:
                each = range(block, min(block + TOGETHER, len(sizes)))
                drawn = [self._block(one, sizes[one]) for one in each]
                x = np.concatenate(drawn, axis=1)
                if keeps:
                    self._kept[block, samples] = x
            return judge(block, x)

        return shared(judged, range(0, len(sizes), TOGETHER), workers)

    @cached_property
    def _kept(self) -> dict[tuple[int, int], Singles]:
        """Numbers of machines (columns, size) by the first block and how many machines there are."""
        return {}

    @cached_property
    def _errors(self) -> tuple[slice, ...]:
        """The columns of every error of every holder: one, or both parts of what has a direction."""
        return tuple(slice(i, i + column.cause.parts) for i, column in enumerate(self.columns) if column.part == 0)

    @cached_property
    def _used(self) -> Bools:
        """Which error has to do with each outcome, (errors, 2 p): both ends of where it may stand at places of rest."""
        mine = np.zeros((len(self.columns), len(self.resting)), dtype=bool)
        for i, position in enumerate(self.resting):
            mine[position.columns, i] = True
        if self.relative:
            mine[self.resting[0].columns] = True
        return np.repeat([mine[error].any(axis=0) for error in self._errors], 2, axis=1)

    def _rest(self, _: int, x: Singles) -> Floats:
        """Figures (3, size) of a block where it rests."""
        size = x.shape[1]
        rest, loose, tight = np.zeros(size), np.full(size, -np.inf), np.full(size, np.inf)
        zero: Zero | None = None

        def plays(at: Position, play: Reals) -> None:
            np.maximum(loose, play, out=loose)
            np.minimum(tight, -play * np.where(play < 0.0, *at.half_levers), out=tight)

        if self.relative:
            low, high, play = self._stand(self.resting[0], x)
            zero = low, high
            plays(self.resting[0], play)
        room, ordered, others = _room(self._rests, x), self._order.ordered(x), None
        if any(each.alike for each in self._rests):
            stops, count, _columns = self._still.near.shape
            others = np.empty((count, stops, size), dtype=SINGLE)
            self._still.fill(ordered, others)
        for each in self._rests:
            plays(each.at, self._reach(each, ordered, rest, zero, room, others))
        return np.stack([rest, np.maximum(loose, 0.0), tight])

    def _told(self, _: int, x: Singles) -> Sums:
        """The sums of a block that tell what each error explains of where it rests."""
        sizes = [abs(mean) + value or 1.0 for mean, value, _ in (self.spreads[c.cause.key] for c in self.columns)]
        scaled = x[:-1] / np.array(sizes, dtype=SINGLE)[:, None]
        return sums_of([scaled[error] for error in self._errors], self._outcomes(x))

    def _outcomes(self, x: Singles) -> Iterator[Singles]:
        """Both ends of where machines (columns, size) may stand at each place of rest, (2 p, size), few at a time."""
        zero: Zero | None = None
        for start in range(0, len(self.resting), TOLD):
            some: list[Reals] = []
            for position in self.resting[start : start + TOLD]:
                low, high, _play = self._stand(position, x)
                if self.relative and zero is None:
                    zero = low, high
                    some += [low - low, high - high]
                else:
                    some += _since(low, high, zero)
            yield np.array(some, dtype=SINGLE)

    def _move(self, x: Singles, dwell: Floats) -> Floats:
        """Largest deviation of machines (columns, size), (size,), of which that in the dwells is known."""
        zero = self._stand(self.resting[0], x)[:2] if self.relative else None
        worst, room, ordered = dwell.copy(), _room(self._moves, x), self._order.ordered(x)
        for each in self._moves:
            self._reach(each, ordered, worst, zero, room)
        return worst

    def _block(self, block: int, size: int) -> Singles:
        """The errors of a block's machines, see `_numbers`; those that followers before it share are theirs."""
        seed = [SEED, block, self.number] if self.number else [SEED, block]
        x = self._numbers(np.random.default_rng(seed), size)
        for sharing, other in self.kin:
            rows = {column: row for row, column in enumerate(self.columns) if column.cause.shared == sharing}
            pairs = [(rows[column], row) for row, column in enumerate(other.columns) if column in rows]
            if pairs:
                mine, theirs = map(list, zip(*pairs))
                x[mine] = other._block(block, size)[theirs]
        return x

    def _numbers(self, rng: np.random.Generator, size: int) -> Singles:
        """The errors of machines, mm or rad, and a last row of 1 for what is nominal, (columns + 1, size)."""
        x = np.ones((len(self.columns) + 1, size), dtype=SINGLE)
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

    def _stand(self, position: Position, x: Singles) -> tuple[Reals, Reals, Reals]:
        """low, high, beyond the nominal ones, and play (size,) of machines at a position; see `seat.Walls.stand`."""
        near, low, high = position.bounds(x)
        play, (base_low, base_high) = high - low, position.base
        if (rigid := self._rigid(position, low, high)) is not None:
            return rigid - base_low, rigid - base_high, self._plays(play)
        rows = np.flatnonzero(np.full(len(play), bool(position.side)) | (play < 0.0))
        bounds, low, high = (low[rows], high[rows]), low.astype(np.float64), high.astype(np.float64)
        if len(rows):
            low[rows] = high[rows] = position.balanced(taken(near, rows), *bounds)
        return low - base_low, high - base_high, play

    def _rigid(self, position: Position, low: Reals, high: Reals) -> Reals | None:
        """The bound, (r,), at which followers stand whatever presses them; None of those that play or are balanced."""
        drive = self.loaded.mechanism.drive
        if drive is Drive.ALONE:
            return low
        return (low if position.side > 0.0 else high) if drive is Drive.OPPOSED and position.side else None

    def _plays(self, play: Reals) -> Reals:
        """Play (r,), without end where one wall is alone."""
        return np.full(play.shape, np.inf) if self.loaded.mechanism.drive is Drive.ALONE else play

    def _reach(
        self, each: Abreast, x: Singles, worst: Floats, zero: Zero | None, room: Room, others: Singles | None = None
    ) -> Reals:
        """The largest play, (n,), of machines (columns, n) at positions; raises worst, their largest deviation from
        zero, (n,), to those that are larger there: which ones, the sum of what presses tells without its balance."""
        at, size = each.at, x.shape[1]
        first, second = each.rooms(x, room)
        near, low, high = each.bounds(x, first, others)
        play, (base_low, base_high) = (high - low).reshape(-1, size), at.base
        if (rigid := self._rigid(at, low, high)) is not None:
            one = rigid.reshape(-1, size)
            np.maximum(worst, _off(one - base_low, one - base_high, zero).max(axis=0), out=worst)
            return np.asarray(self._plays(play).max(axis=0))
        free = None if at.side else play >= 0.0

        def raised(rows: Rows, low: Reals, high: Reals) -> None:
            whose = rows % size
            mine = None if zero is None else (zero[0][whose], zero[1][whose])
            np.maximum.at(worst, whose, _off(low - base_low, high - base_high, mine))

        def over() -> Singles:
            least, most = (v.astype(SINGLE) for v in _within(at, worst, zero))
            found = np.empty(play.shape, dtype=SINGLE)
            for one, over in zip(near.reshape(len(near), -1, size).swapaxes(0, 1), found):
                np.maximum(at.excess(one, most, second), -at.excess(one, least, second), out=over)
            if free is not None:
                np.copyto(found, 0.0, where=free)
            return found

        def settle(rows: Rows) -> None:
            stands = at.balanced(taken(near, rows), low[rows], high[rows])
            raised(rows, stands, stands)

        if free is not None:
            first_at, last_at = zero or (0.0, 0.0)
            off, last = (np.abs(bound.reshape(play.shape) - np.asarray(start, dtype=SINGLE)) for bound, start in
                         ((low, base_low + last_at), (high, base_high + first_at)))  # fmt: skip
            np.maximum(off, last, out=off)
            rows = np.flatnonzero(free & (off > worst.astype(SINGLE)))
            raised(rows, low[rows].astype(np.float64), high[rows].astype(np.float64))
        if free is None or not free.all():
            settle_over(over, settle)
        return np.asarray(play.max(axis=0))


def telling(figures: Floats, known: int = 0) -> list[int]:
    """Rows, the one that tells most first, whose largest figures (kinds, rows, pilots) fall short of those of all by
    SHORT of their size on the mean, beside the first rows, which are known.
    """
    whole = figures.max(axis=1)
    size = np.abs(whole).mean(axis=1)
    size = np.where(size > 0.0, size, 1.0)[:, None]
    reached = figures[:, :known].max(axis=1) if known else figures.min(axis=1)
    rows, left = list[int](), list(range(known, figures.shape[1]))
    while left and float(((whole - reached) / size).mean(axis=1).max()) > SHORT:
        gains = [float((np.maximum(figures[:, k] - reached, 0.0) / size).mean()) for k in left]
        rows.append(left.pop(int(np.argmax(gains))))
        reached = np.maximum(reached, figures[:, rows[-1]])
    return rows


def _inside(end: End, base: tuple[float, float], side: float) -> tuple[float, float]:
    """Where a follower stands nominally by the end of its groove, of where it stands by its walls alone."""
    push, hold = end.insets(np.zeros((end.way.shape[1], 1), dtype=SINGLE))
    low, high = base[0] + float(push[0]), base[1] - float(hold[0])
    if side > 0.0:
        return low, low
    return (high, high) if side < 0.0 else (low, high)


def _room(each: Sequence[Abreast], x: Singles) -> Room:
    """Memory for the approaches of machines (columns, n) at any of the positions, see `Abreast.rooms`: had anew for
    each, it costs as much as what is put there."""
    return np.empty(max((len(one.at.near) for one in each), default=0) * (ABREAST + 1) * x.shape[1], dtype=SINGLE)


def _within(position: Position, known: Floats, zero: Zero | None) -> Zero:
    """Least and largest coordinate, (r,), whose deviation keeps within known ones (r,), see `_off`."""
    low, high = position.base
    if zero is None:
        return max(low, high) - known, min(low, high) + known
    return zero[1] + low - known, zero[0] + high + known


def _since(low: Reals, high: Reals, zero: Zero | None) -> list[Reals]:
    """Both ends, (size,), of where followers stand, from zero or from where they were set to zero."""
    return [low, high] if zero is None else [low - zero[1], high - zero[0]]


def _off(low: Reals, high: Reals, zero: Zero | None) -> Reals:
    """Deviation (size,) of followers that stand low .. high, from zero or from where they were set to zero."""
    first, last = _since(low, high, zero)
    return np.maximum(np.abs(first), np.abs(last))


def _pressure(position: Position, square: Singles, x: Singles) -> Floats:
    """Largest pressure of machines (columns, size) at a position, MPa; square: see `Machines._hard`."""
    return position.pressure(*position.bounds(x), square)


def _direction(rng: np.random.Generator, size: int, value: float, how: Distribution) -> Singles:
    """Errors of any direction, (2, size): both parts normal, evenly over a disc, or on its rim."""
    if how == "normal":
        return np.asarray(value / 3.0 * rng.standard_normal((2, size), dtype=SINGLE))
    angle = 2.0 * pi * rng.random(size, dtype=SINGLE)
    radius = value * np.sqrt(rng.random(size, dtype=SINGLE)) if how == "uniform" else value
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)])
