"""What every error does alone: follower motion, play, preload and pressure, the largest over the turn and where.

An error of a size is put on at every station, plus and minus, on one roller or wall after the other where each has its
own; the follower stands where `seat` says. Errors with a direction are tried both ways along two axes and along what
these two add up to: exact where the follower follows in proportion. It does not where lines come to bear or go: where a
motion is large, directions beside that are tried too. A play is the least of many pairs of walls, and may open between
the axes alone: all directions are tried where it can.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import repeat
from math import pi
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme, bracketed_maximum, piece_grid
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.load import Load
from camgeom.mechanics.material import Material
from camgeom.motion.program import Program
from camgeom.solid.mechanism import Drive, Mechanism
from camgeom.tolerance.causes import Approaches, Cause, Pivots, applicable
from camgeom.tolerance.contacts import Contacts, contacts
from camgeom.tolerance.directions import SETTLED, Figure, Rows, Trials
from camgeom.tolerance.seat import TOGETHER, Bools, Stand, Walls, pressures, walls_of
from camgeom.track import TURN

PER_TURN = 240
"""cam angles in a turn, beside those that every dwell and move has"""
LEAST = 7
"""in every piece of the motion"""
LEAST_SLID = 25
"""the same of a plate, whose path the drive runs faster in the middle than at the ends"""
SIZES = {"mm": 0.01, "arcmin": 1.0, "arcsec": 10.0}
"""of the errors that are tried, in their unit"""
SECONDS = 648000.0 / pi
OPENED = 1e-6
"""share of the largest play that an error can open, below which the rest of it is not looked for"""


@final
@immutable
class Loaded:
    """A mechanism with what its contacts need: materials, and the load on its follower over cam angles, or None.

    line  False where rollers touch in points, whose pressure no line contact gives
    peak  the largest nominal pressure, MPa, as the contact's own check has it along its line; None: as it is here,
          at the stations of a line
    """

    mechanism: Mechanism
    roller: Material
    cam: Material
    load: Load | None
    pivots: Pivots
    peak: Callable[[], float | None] | None = None

    @property
    def line(self) -> bool:
        """Whether contacts are lines, along which a tilt makes the load uneven."""
        tracks = self.mechanism.tracks
        if any(roller.shape in ("crowned", "sphere") for roller in self.mechanism.rollers):
            return self.mechanism.crown == "conforming"
        return bool(tracks) or self.mechanism.touches[0].kind != "knife"

    @cached_property
    def preload(self) -> float:
        """Normal interference in the dwell, mm."""
        return self.mechanism.turret.preload if self.mechanism.turret is not None else 0.0

    @cached_property
    def forces(self) -> tuple[Floats, Floats]:
        """Cam angles, rad, and the load on the follower there, N or N mm: none without an [operation]."""
        if self.load is None:
            return np.array([0.0, TURN]), np.zeros(2)
        sampled = self.load.sampled()
        return sampled.panels.theta.ravel(), sampled.force.ravel()

    def at(self, theta: Floats) -> Seated:
        """The contacts at cam angles (n,), rad, and how they stand."""
        if self.load is None:
            force = np.zeros(len(theta))
        else:
            sampled = self.load.sampled()
            force = sampled.panels.at(sampled.force, np.mod(theta, TURN))
        found = contacts(self.mechanism, theta)
        return Seated(self, found, walls_of(found, force, self.roller, self.cam, self.preload))

    def shown(self, coordinate: float) -> float:
        """A deviation of the joint coordinate as it is told: um of a slide, seconds of arc of what turns."""
        return coordinate * (SECONDS if self.mechanism.follower.rotating else 1e3)

    @property
    def unit(self) -> str:
        """The unit of that."""
        return "arcsec" if self.mechanism.follower.rotating else "um"

    @property
    def arm(self) -> float:
        """From the follower's axis to its reference point, mm; 1 of a slide, whose coordinate is a length."""
        return self.mechanism.follower.swing_radius or 1.0


@final
@immutable
class Packed:
    """Stations that have a wall at each cam angle, (n, p), as many as any angle has; the last ones of others have none.

    order  their numbers among all, (n, p); walls: theirs; roller, wall: whose they are
    square of the pressure per force, MPa²/N
    """

    order: npt.NDArray[np.intp]
    walls: Walls
    roller: npt.NDArray[np.intp]
    wall: npt.NDArray[np.intp]
    square: Floats

    def taken(self, values: Floats) -> Floats:
        """Values of all stations, (parts, n, q), of these, (parts, n, p)."""
        return np.take_along_axis(values, self.order[None], axis=2)


@final
@immutable
class Seated:
    """Contacts, their walls under the load, and the approaches of every error."""

    of: Loaded
    contacts: Contacts
    walls: Walls

    @cached_property
    def approaches(self) -> Approaches:
        """Approach per mm or rad of every error."""
        return Approaches(self.contacts, self.of.pivots)

    def flat(self, approach: Floats) -> Floats:
        """Approaches (..., n, l, m) with the stations in one row, (..., n, q)."""
        return np.asarray(approach.reshape(*approach.shape[:-2], -1))

    @cached_property
    def packed(self) -> Packed:
        """The stations that have a wall, side by side."""
        at, n = self.contacts, len(self.contacts.theta)
        on = at.on.reshape(n, -1)
        order = np.argsort(~on, axis=1, kind="stable")[:, : max(1, int(on.sum(axis=1).max()))]
        line = order // at.on.shape[2]
        one = pressures(at, np.ones(on.shape), self.of.roller, self.of.cam)
        walls = self.walls
        every = (walls.approach, walls.lever, walls.stiffness, one**2)
        near, lever, stiffness, square = (np.take_along_axis(each, order, axis=1) for each in every)
        return Packed(order, replace(walls, approach=near, lever=lever, stiffness=stiffness), at.roller[line],
                      at.wall[line], np.where(stiffness > 0.0, square, 0.0))  # fmt: skip

    @cached_property
    def nominal(self) -> Stand:
        """Where the follower stands without errors.

        Raises DesignError where nothing says it: beside one wall alone, against which no load presses.
        """
        stand = self.walls.stand(np.zeros(self.walls.lever.shape))
        apart = np.flatnonzero(~(np.isfinite(stand.low) & np.isfinite(stand.high)))
        if len(apart):
            angle = round(float(np.degrees(self.contacts.theta[apart[0]])), 3) % 360.0
            raise DesignError(
                f"at cam angle {angle:g} deg one wall has run out and no load presses the follower on the other: "
                "nothing says where it stands, with errors or without; give [operation] the forces that do"
            )
        return stand

    def deviation(self, stand: Stand) -> Floats:
        """Largest deviation from the nominal stand, (..., n), mm or rad, >= 0: where it is free, at either end."""
        base = self.nominal
        return np.maximum(np.abs(stand.low - base.low), np.abs(stand.high - base.high))

    def preload(self, play: Floats) -> Floats:
        """Normal interference, mm, (..., n), of a play below zero, mm or rad, (..., n); above it minus half the gap."""
        return self.walls.normal(play)


@final
@immutable
class Sensitivity:
    """What one error of a size does alone.

    size     in the cause's unit; motion: largest deviation, mm or rad; curve: of every cam angle (n,)
    play     largest growth of play, and preload: largest loss of it along the normal, mm
    pressure largest pressure over the nominal largest, 1; None where no line contact is loaded
    """

    cause: Cause
    size: float
    motion: Extreme
    curve: Floats
    play: float
    preload: float
    pressure: float | None


@final
@immutable
class Sensitivities:
    """The table of all errors that a mechanism can have."""

    loaded: Loaded

    @cached_property
    def theta(self) -> Floats:
        """Cam angles, rad, (n,), both sides of every knot of the motion and of every jump of the load."""
        program, load = self.loaded.mechanism.program, self.loaded.load
        least = LEAST if self.loaded.mechanism.carriage is None else LEAST_SLID
        return turn_grid(program, program.knots if load is None else load.given.breaks, least)

    @cached_property
    def seated(self) -> Seated:
        """The contacts there."""
        return self.loaded.at(self.theta)

    @cached_property
    def hard(self) -> Extreme | None:
        """The largest nominal pressure, MPa, at the stations, and its cam angle; None of no line."""
        if self.loaded.load is None or not self.loaded.line:
            return None
        packed = self.seated.packed
        pressure = np.sqrt((packed.walls.forces(np.zeros(packed.order.shape)) * packed.square).max(axis=1))
        at = int(np.argmax(pressure))
        return Extreme(float(pressure[at]), float(self.theta[at]))

    @cached_property
    def rows(self) -> tuple[Sensitivity, ...]:
        """One a cause, the largest motion first: of errors of the sizes that are tried."""
        causes = applicable(self.loaded.mechanism)
        size = {cause.key: SIZES[cause.unit] for cause in causes}
        tried = Trials.of(self.seated, [(cause, size[cause.key] * cause.scale) for cause in causes])
        walls, base = self.seated.packed.walls, self.seated.nominal
        stood = walls.stand(tried.errors)

        def farther(both: Floats) -> Floats:
            stand = walls.stand(both)
            return np.stack([stand.high[0] - base.high, base.low - stand.low[1]])

        ends = np.stack([stood.high - base.high, base.low - stood.low])
        moved = tried.told(ends, farther).max(axis=0)
        tried.swung(ends.max(axis=0), moved, self._motion)
        grown = lost = np.zeros(moved.shape)
        if self._both:
            (grown,) = tried.told(self._growth(stood.play)[None], lambda errors: self._growth(walls.play(errors)))
            self._opened(tried, grown)
            lost = self._lost(grown)
        found, pressure = [], self._harder(tried, stood)
        for i, (cause, curve) in enumerate(zip(causes, moved)):
            at = int(np.argmax(curve))
            motion = Extreme(float(curve[at]), float(self.theta[at]))
            play, preload = float(grown[i].max()), float(lost[i].max())
            found.append(Sensitivity(cause, size[cause.key], motion, curve, play, preload, pressure[i]))
        return tuple(sorted(found, key=lambda one: -one.motion.value))

    @cached_property
    def _walls(self) -> Walls:
        """The packed walls, without what of the load is rounding: of some angles alone it would press."""
        walls = self.seated.packed.walls
        return replace(walls, load=np.where(walls.load_side == 0.0, 0.0, walls.load))

    def _motion(self, rows: Rows) -> Figure:
        """How far errors move the follower at cam angles rows (k,)."""
        walls, low, high = self._walls.rows(rows), self.seated.nominal.low[rows], self.seated.nominal.high[rows]

        def moved(errors: Floats) -> Floats:
            stand = walls.stand(errors)
            return np.maximum(stand.high - high, low - stand.low)

        return moved

    @cached_property
    def _between(self) -> npt.NDArray[np.bool_]:
        """Whether both walls stand at every cam angle, (n,): a groove may have run out on one side."""
        return np.isfinite(self.seated.nominal.play)

    def _growth(self, play: Floats) -> Floats:
        """Growth of a play, mm or rad, (..., n); 0 where there is none, a wall being missing."""
        zero = np.zeros(np.broadcast_shapes(play.shape, self._between.shape))
        return np.subtract(play, self.seated.nominal.play, out=zero, where=self._between)

    def _lost(self, grown: Floats) -> Floats:
        """Preload lost, mm, (..., n), where a play grows, mm or rad: the more play, the less preload."""
        base = np.where(self._between, self.seated.nominal.play, 0.0)
        return self.seated.preload(base) - self.seated.preload(base + grown)

    def _opened(self, tried: Trials, grown: Floats) -> None:
        """Growth of play, (causes, n), raised where an error of any direction opens more between its parts' directions.

        All directions are tried where the walls leave room for a growth, or a loss of preload, that is the largest of
        the turn: no more than the nominally nearest pair of stations parts, nor than any pair.
        """
        walls, base, several = self.seated.packed.walls, self.seated.nominal.play, tried.several
        if not len(several):
            return
        parts, cause = tried.errors[several, 0] / walls.lever, tried.cause[several[:, 0]]
        push, hold = (np.take_along_axis(parts, at[None, None, :, None], axis=3)[..., 0] for at in walls.nearest)
        most = np.where(self._between, np.hypot(*(push - hold).swapaxes(0, 1)), 0.0)

        def blocks(groups: Rows, angles: Rows) -> Iterator[tuple[Rows, Rows, Walls, Floats]]:
            # A pair of stations is a number: few angles at a time.
            size = max(1, TOGETHER // walls.lever.shape[1])
            for i in range(0, len(angles), size):
                own, rows = groups[i : i + size], angles[i : i + size]
                yield own, rows, walls.rows(rows), tried.errors[several[own].T, 0, rows]

        for own, rows, few, at in blocks(*self._further(most, grown[cause])):
            most[own, rows] = few.parted(np.zeros(few.lever.shape), [(at, None)]) - base[rows]
        noise = SETTLED * float(most.max())
        for own, rows, few, at in blocks(*self._further(most, grown[cause])):
            ends = np.zeros(len(rows)), np.full(len(rows), TURN)
            found, _ = bracketed_maximum(partial(few.swung, at), *ends, noise=noise)
            np.maximum.at(grown, (cause[own], rows), found - base[rows])

    def _further(self, most: Floats, grown: Floats) -> tuple[Rows, Rows]:
        """Errors and cam angles, numbers of (g, n), at which the play may grow, or the preload may go, further than the
        largest known of all, (g, n)."""
        more = OPENED * most.max(axis=1, keepdims=True)
        lost = self._lost(grown).max(axis=1, keepdims=True) + self._lost(np.broadcast_to(more, most.shape))
        group, rows = np.nonzero((most > grown.max(axis=1, keepdims=True) + more) | (self._lost(most) > lost))
        return group, rows

    @property
    def _both(self) -> bool:
        """Whether walls stand on both sides."""
        return self.loaded.mechanism.drive is not Drive.ALONE

    def _harder(self, tried: Trials, stood: Stand) -> list[float | None]:
        """Largest pressure of the turn with each error over that without; stood: where they stand with those tried."""
        if self.hard is None:
            return [None] * (int(tried.cause[-1]) + 1)
        before = self.hard.value

        def growth(rows: Rows) -> Callable[..., Floats]:
            walls, square = self._walls.rows(rows), self.seated.packed.square[rows]

            def grown(errors: Floats, stand: Stand | None = None) -> Floats:
                if errors.ndim > 2 and errors.size > TOGETHER:
                    none = repeat(None, len(errors))
                    each = none if stand is None else map(Stand, stand.low, stand.high, stand.play)
                    return np.stack(list(map(grown, errors, each)))
                force = walls.forces(errors, stand)
                force *= square
                return np.asarray(np.sqrt(force.max(axis=-1)) / before - 1.0)

            return grown

        every = growth(np.arange(len(self.theta)))
        ends = every(tried.errors, stood)
        (found,) = tried.told(ends[None], every)
        tried.swung(ends, found, growth)
        return [1.0 + float(each.max()) for each in found]


def turn_grid(program: Program, knots: Floats, least: int = LEAST) -> Floats:
    """Cam angles (n,), rad, on both sides of every knot, at least so many in each piece between; as few in dwells as
    tell a turning error's sine."""
    knots = knots[(knots >= 0.0) & (knots <= TURN)]
    theta, piece = piece_grid(knots, PER_TURN, least)
    still = np.array([float(np.ptp(program.jet(np.linspace(a, b, 5)[1:-1], 0)[0])) == 0.0
                      for a, b in zip(knots[:-1], knots[1:])])  # fmt: skip
    last = np.r_[piece[1:] != piece[:-1], True] | np.r_[True, piece[1:] != piece[:-1]]
    return np.asarray(theta[~still[piece] | last | (np.arange(len(theta)) % 8 == 0)])


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


def resting_at(program: Program, theta: Floats) -> Bools:
    """Which cam angles (n,), rad, of a turn lie in dwells; all of a program without one."""
    found = np.zeros(len(theta), dtype=bool)
    for start, end, still in resting(program):
        if still:
            found |= (theta >= start) & (theta <= end) | (theta >= start + TURN)
    return found if found.any() else ~found
