"""What every error does alone: follower motion, play, preload and pressure, the largest over the turn and where.

An error of a size is put on at every station, plus and minus, on one roller or wall after the other where each has its
own; the follower stands where `seat` says. Errors with a direction are tried both ways along two axes, and the root of
their squares is told: exact where the follower follows in proportion, never too small elsewhere, since where it stands
is a convex function of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi
from typing import final

import numpy as np

from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme, piece_grid
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.load import Load
from camgeom.mechanics.material import Material
from camgeom.motion.program import Program
from camgeom.solid.mechanism import Drive, Mechanism
from camgeom.tolerance.causes import Approaches, Cause, Pivots, applicable
from camgeom.tolerance.contacts import Contacts, contacts
from camgeom.tolerance.seat import Stand, Walls, pressures, walls_of
from camgeom.track import TURN

PER_TURN = 240
"""cam angles in a turn, beside those that every dwell and move has"""
LEAST = 7
SIZES = {"mm": 0.01, "arcmin": 1.0, "arcsec": 10.0}
"""of the errors that are tried, in their unit"""
SECONDS = 648000.0 / pi


@final
@dataclass(frozen=True, eq=False)
class Loaded:
    """A mechanism with what its contacts need: materials, and the load on its follower over cam angles, or None.

    line  False where rollers touch in points, whose pressure no line contact gives
    """

    mechanism: Mechanism
    roller: Material
    cam: Material
    load: Load | None
    pivots: Pivots

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
@dataclass(frozen=True, eq=False)
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
    def nominal(self) -> Stand:
        """Where the follower stands without errors."""
        return self.walls.stand(np.zeros(self.walls.lever.shape))

    def deviation(self, stand: Stand) -> Floats:
        """Largest deviation from the nominal stand, (..., n), mm or rad, >= 0: where it is free, at either end."""
        base = self.nominal
        return np.maximum(np.abs(stand.low - base.low), np.abs(stand.high - base.high))

    def preload(self, play: Floats) -> Floats:
        """Normal interference, mm, (..., n), of a play below zero, mm or rad, (..., n); above it minus half the gap."""
        return self.walls.normal(play)


@final
@dataclass(frozen=True, eq=False)
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
@dataclass(frozen=True, eq=False)
class Sensitivities:
    """The table of all errors that a mechanism can have."""

    loaded: Loaded

    @cached_property
    def theta(self) -> Floats:
        """Cam angles, rad, (n,), both sides of every knot of the motion."""
        return turn_grid(self.loaded.mechanism.program)

    @cached_property
    def seated(self) -> Seated:
        """The contacts there."""
        return self.loaded.at(self.theta)

    @cached_property
    def hard(self) -> tuple[Seated, float, Extreme] | None:
        """Contacts at a few cam angles about the largest nominal pressure, that pressure, MPa; None of no line."""
        if self.loaded.load is None or not self.loaded.line:
            return None
        pressure = self._pressure(self.seated, np.zeros(self.seated.walls.lever.shape))
        at = int(np.argmax(pressure))
        few = np.unique(np.r_[np.arange(0, len(self.theta), 10), at])
        peak = Extreme(float(pressure[at]), float(self.theta[at]))
        return self.loaded.at(self.theta[few]), float(pressure[at]), peak

    def _pressure(self, seated: Seated, errors: Floats) -> Floats:
        """Largest pressure, MPa, (..., n)."""
        force = seated.walls.forces(errors)
        return np.asarray(pressures(seated.contacts, force, self.loaded.roller, self.loaded.cam).max(axis=-1))

    @cached_property
    def rows(self) -> tuple[Sensitivity, ...]:
        """One a cause, the largest motion first."""
        found = [self.of(cause) for cause in applicable(self.loaded.mechanism)]
        return tuple(sorted(found, key=lambda one: -one.motion.value))

    def of(self, cause: Cause, size: float | None = None) -> Sensitivity:
        """What an error of a size (in its unit; default: `SIZES`) does alone."""
        size = SIZES[cause.unit] if size is None else size
        unit, seated = size * cause.scale, self.seated
        curve, play, preload = np.zeros(len(self.theta)), 0.0, 0.0
        before = seated.preload(seated.nominal.play) if self._both else None
        for parts in trials(seated, cause, unit):
            moved = np.zeros((len(parts), len(self.theta)))
            grown, lost = np.zeros(len(parts)), np.zeros(len(parts))
            for part, both in enumerate(parts):
                stand = seated.walls.stand(both)
                moved[part] = seated.deviation(stand).max(axis=0)
                if before is not None:
                    grown[part] = float((stand.play - seated.nominal.play).max())
                    lost[part] = float((before - seated.preload(stand.play)).max())
            curve = np.maximum(curve, np.sqrt((moved**2).sum(axis=0)))
            play, preload = max(play, float(np.hypot.reduce(grown))), max(preload, float(np.hypot.reduce(lost)))
        at = int(np.argmax(curve))
        motion = Extreme(float(curve[at]), float(self.theta[at]))
        return Sensitivity(cause, size, motion, curve, play, preload, self._harder(cause, unit))

    @property
    def _both(self) -> bool:
        """Whether walls stand on both sides."""
        return self.loaded.mechanism.drive is not Drive.ALONE

    def _harder(self, cause: Cause, unit: float) -> float | None:
        if self.hard is None:
            return None
        seated, before, _ = self.hard
        worst = 0.0
        for parts in trials(seated, cause, unit):
            more = [max(0.0, float(self._pressure(seated, both).max()) / before - 1.0) for both in parts]
            worst = max(worst, float(np.hypot.reduce(more)))
        return 1.0 + worst


def trials(seated: Seated, cause: Cause, unit: float) -> Iterator[list[Floats]]:
    """The error put on, plus and minus (2, n, q), part by part; of each roller or wall in turn where each has its own.
    """
    g = unit * seated.approaches.of(cause)
    owners = {"roller": seated.contacts.roller, "wall": seated.contacts.wall}.get(cause.holder)
    shares = [np.ones(g.shape[2], dtype=bool)]
    if owners is not None:
        shares = [owners == k for k in sorted(set(owners.tolist()))]
    for share in shares:
        mine = seated.flat(g * share[:, None])
        yield [np.stack([part, -part]) for part in mine]


def turn_grid(program: Program) -> Floats:
    """Cam angles (n,), rad, on both sides of every knot; as few in dwells as tell a turning error's sine."""
    knots = np.asarray(program.knots, dtype=np.float64)
    knots = knots[(knots >= 0.0) & (knots <= TURN)]
    theta, piece = piece_grid(knots, PER_TURN, LEAST)
    still = np.array([float(np.ptp(program.jet(np.linspace(a, b, 5)[1:-1], 0)[0])) == 0.0
                      for a, b in zip(knots[:-1], knots[1:])])  # fmt: skip
    last = np.r_[piece[1:] != piece[:-1], True] | np.r_[True, piece[1:] != piece[:-1]]
    return np.asarray(theta[~still[piece] | last | (np.arange(len(theta)) % 8 == 0)])


