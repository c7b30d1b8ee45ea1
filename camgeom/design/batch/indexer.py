"""Indexing cams of many variants: the rollers about the line of centres, geometry of their flanks, and the load.

Arrays are (P, n), P samples of the cam angle and n variants, (m, n) with a row for each roller and sample at which it
is beside the cam, or (k, P, n) with a row for each place that a roller takes.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import pi
from typing import final

import numpy as np

from camgeom.cams._turret import TurretKeys
from camgeom.design.batch.legs import FINE, program_of
from camgeom.design.batch.motion import SAMPLES, Ints, Motion, Points
from camgeom.design.batch.sharing import PER, STEP, THIN, Pressed, Sharing
from camgeom.design.batch.variants import Mask, Variants
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.duty import MILLI
from camgeom.mechanics.life import hours
from camgeom.mechanics.load import Demand
from camgeom.model.loads import DEGREES
from camgeom.track.follower import TurretFollower
from camgeom.track.runout import PLACES

SIDES = 1.0, -1.0
ROUNDS = 4
FAN = 9
"""times that a largest quantity is looked for among so many fine steps, each between the neighbours of the last"""
KEPT = 4
"""pieces of the motion, of all rollers, in which it is looked for first; then in the one that holds the largest"""
Ends = tuple[Floats, Floats, Floats]
"""Of a wall along the roller, mm, and its distance from the roller's axis, mm."""
Held = tuple[Floats, Floats, Mask]
"""From where to where a wall has the cam beside it, mm, and whether it has."""
SHARED = {
    "slice": {"contact.peak_slice_pressure_mpa", "fatigue.cam_life_h"},
    "middle": {"contact.peak_pressure_mpa"},
    "force": {"contact.peak_force_n", "contact.stud_stress_mpa"},
}
"""figures that rest on how rollers share the torque"""


@final
@dataclass(frozen=True, eq=False)
class Seat:
    """Rollers at samples of the motion: cos and sin of tau, (k, P, n) or (P, n), and its derivatives, (P, n).

    kept  what a kind of cam computes of them once, whatever the place along the roller
    """

    cos: Floats
    sin: Floats
    one: Floats
    two: Floats
    kept: tuple[Floats, ...]


@final
@dataclass(frozen=True, eq=False)
class Line:
    """The pitch surface at one place along the rollers: 2H, M²/D (D the first form's determinant), lever."""

    bend: Floats
    twist2: Floats
    lever: Floats


class Indexer(ABC):
    """The cams of n variants; numbers are (n,) or (1,)."""

    pushing: float
    """side of the pitch surface, in this file's signs, whose wall pushes the turret on"""

    def __init__(self, variants: Variants, motion: Motion, figures: Sequence[str], level: float) -> None:
        number = variants.number
        self.variants, self.motion, self.profile = variants, motion, variants.profile
        follower = self.profile.follower
        assert isinstance(follower, TurretFollower)
        self.count, self.stops = follower.count, follower.stops
        self.pitch = 2.0 * pi / self.count
        cam = self.profile.cam
        assert isinstance(cam, TurretKeys)
        self.base = 0.5 * self.pitch if cam.form == "rib" else 0.0
        self.advance = program_of(self.profile).advance
        self.level = level
        self.centre, self.width = number("cam.center_distance"), number("cam.width")
        self.gap = number("cam.running_clearance")
        self.roller, self.length = 0.5 * number("roller.diameter"), number("roller.length")
        self.cutter = self.roller + self.gap
        self.circle = number("follower.pitch_radius")
        # A figure of every variant, also where only keys are varied on which no geometry rests.
        self.low, self.high = (variants.full(end) for end in self.contact())
        self.asked = {word for word, names in SHARED.items() if not names.isdisjoint(figures)}

    @abstractmethod
    def contact(self) -> tuple[Floats, Floats]:
        """Ends of the stretch of the roller that touches, mm."""

    @property
    @abstractmethod
    def wall(self) -> tuple[Floats, Floats]:
        """Ends of the cut wall along the roller, mm."""

    @property
    @abstractmethod
    def clear(self) -> Floats:
        """Angle from the line of centres beyond which a roller is clear of the cam, rad."""

    @property
    @abstractmethod
    def quoted(self) -> Floats:
        """Where the classical figures are quoted, mm."""

    @abstractmethod
    def refuse(self) -> None:
        """Give what the cam type has against a variant, in its order."""

    def seat(self, points: Points, offset: Floats) -> Seat:
        """The rollers `offset` ahead of the turret's lift, rad, (k, 1, n) or (n,)."""
        c, s, co, so = np.cos(points.s), np.sin(points.s), np.cos(offset), np.sin(offset)
        cos, sin = c * co - s * so, s * co + c * so
        return Seat(cos, sin, points.ds, points.dds, self.kept(cos, sin, points.ds, points.dds))

    @abstractmethod
    def kept(self, cos: Floats, sin: Floats, one: Floats, two: Floats) -> tuple[Floats, ...]:
        """What of a seat does not hang on the place along the roller."""

    @abstractmethod
    def lever(self, seat: Seat, delta: Floats) -> Floats:
        """Speed of the contact along its normal per radian of the turret, mm."""

    @abstractmethod
    def line(self, seat: Seat, delta: Floats) -> Line:
        """The pitch surface at a place along the rollers."""

    @abstractmethod
    def tangent2(self, surface: bool, delta: Floats, seat: Seat, side: float) -> Floats:
        """tan² of the pressure angle, at the surface of the wall on a side or at the axis."""

    @abstractmethod
    def stretch(self, seat: Seat, side: Floats | float, ends: Ends) -> tuple[Floats, Floats]:
        """Places along the rollers, mm, between which the walls on a side have the cam beside them; empty: none."""

    def refuse_shared(self) -> None:
        """What is wrong with the keys that both share."""
        number, refusals = self.variants.number, self.variants.refusals
        width, deep, bore = number("cam.keyway_width"), number("cam.keyway_depth"), number("cam.bore")
        refusals.add((width > 0.0) != (deep > 0.0), "cam.keyway_depth: cannot be built")
        refusals.add((width > 0.0) & (width >= bore), "cam.keyway_width: cannot be built")

    @cached_property
    def bored(self) -> Floats:
        """Largest distance of the bore's outline from the axis, mm; 0 without one."""
        number = self.variants.number
        bore, width, deep = number("cam.bore"), number("cam.keyway_width"), number("cam.keyway_depth")
        return np.asarray(np.where(width > 0.0, np.hypot(0.5 * bore + deep, 0.5 * width), 0.5 * bore))

    # Geometry

    def offsets(self, limit: Floats) -> Floats:
        """Angles of the rollers that come within +-limit of the line of centres, at zero lift, rad, (k,)."""
        most = float(np.max(np.where(np.isfinite(limit), limit, 0.0)))
        first = int(np.ceil((-most - self.base - self.advance) / self.pitch))
        last = int(np.floor((most - self.base) / self.pitch))
        return np.asarray(self.base + self.pitch * np.arange(first, last + 1))

    @cached_property
    def points(self) -> Points:
        """PER points of every piece that moves, one of every other, (P, n)."""
        inner = np.arange(SAMPLES) % THIN == 0
        moving = np.tile(inner, self.motion.moving)
        rests = np.ones(len(self.motion.rows) - self.motion.moving, dtype=bool)
        return self.motion.samples.of(np.flatnonzero(np.concatenate([moving, rests])))

    @cached_property
    def _surveyed(self) -> tuple[Floats, Ints, Points, Seat, Floats]:
        """The rollers while they may be beside the cam: offsets (k,), which samples of all of theirs that is for some
        variant, (m,) of k P, the points, the seats there, and their offsets (m, 1)."""
        offsets, points = self.offsets(self.clear), self.points
        roller, sample = np.nonzero(self.beside(points, offsets, self.clear))
        near, at = points.of(sample), offsets[roller][:, None]
        return offsets, roller * len(points.s) + sample, near, self.seat(near, at), at

    @staticmethod
    def beside(points: Points, offsets: Floats, limit: Floats) -> Mask:
        """Whether rollers at offsets (k,) are within +-limit of the line of centres for some variant, (k, P)."""
        return np.asarray((np.abs(points.s + offsets[:, None, None]) <= limit).any(axis=2))

    def held(self, points: Points, seat: Seat, offsets: Floats, side: Floats | float, ends: Ends) -> Held:
        """Ends of what a wall on a side has of the cam beside it, mm, and whether it has: as `track.runout.touching`
        finds it, at one of its places along the roller.

        ends  of the wall along the roller, mm, and its distance from the roller's axis, mm
        """
        low, high, _ = ends
        begin, stop = self.stretch(seat, side, ends)
        step = (high - low) / (PLACES - 1)
        meets = np.floor((stop - low) / step + 1e-9) >= np.ceil((begin - low) / step - 1e-9)
        return begin, stop, (np.abs(points.s + offsets) <= self.clear) & (stop > begin) & meets

    @cached_property
    def touched(self) -> Ends:
        """Of the rollers."""
        return self.low, self.high, self.roller

    def _walled(self, points: Points, seat: Seat, offsets: Floats, side: float, ends: Ends) -> Held:
        """The same; of walls that are not the rollers' where a roller bears on either."""
        begin, stop, on = self.held(points, seat, offsets, side, ends)
        if ends is not self.touched:
            on &= np.logical_or(*(self.held(points, seat, offsets, each, self.touched)[2] for each in SIDES))
        return begin, stop, on

    @cached_property
    def _walls(self) -> dict[bool, dict[float, Held]]:
        """What is walled at the samples surveyed, (m, n), by whether the walls are the rollers' and by side."""
        _, _, near, seat, at = self._surveyed
        rollers = {side: self.held(near, seat, at, side, self.touched) for side in SIDES}
        bears = np.logical_or(*(on for _, _, on in rollers.values()))
        cut = {side: self.held(near, seat, at, side, self.cut) for side in SIDES}
        return {True: rollers, False: {side: (begin, stop, on & bears) for side, (begin, stop, on) in cut.items()}}

    @cached_property
    def cut(self) -> Ends:
        """Of what the tool leaves."""
        return (*self.wall, self.cutter)

    def _worst(self, what: Callable[[Floats, Seat, float], Floats], ends: Ends, at: Floats | None = None) -> Floats:
        """Largest of a quantity over the turn, all rollers and both walls, at both ends of what a wall has of the cam
        beside it, or at one place along the rollers, (n,)."""
        offsets, rows, _, seat, _ = self._surveyed
        best = np.full(self.motion.size, -np.inf)
        for side in SIDES:
            for end in range(2 if at is None else 1):

                def value(beside: Seat, held: Held, side: float = side, end: int = end) -> Floats:
                    begin, stop, on = held
                    place = at if at is not None else (begin, stop)[end]
                    on = on if at is None else on & (begin <= at) & (at <= stop)
                    return np.where(on, what(place, beside, side), -np.inf)

                values = value(seat, self._walls[ends is self.touched][side])
                row, piece, low, high, top = self._candidates(len(offsets), rows, values)
                best = np.maximum(best, top)
                for _ in range(ROUNDS):
                    steps = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, FAN)[:, None]
                    points = self.motion.at(np.repeat(piece, FAN, axis=0), steps.reshape(-1, self.motion.size))
                    offset = np.repeat(offsets[row], FAN, axis=0)
                    beside = self.seat(points, offset)
                    found = value(beside, self._walled(points, beside, offset, side, ends)).reshape(steps.shape)
                    peak = found.argmax(axis=1)[:, None]
                    beside_it = (np.clip(peak + k, 0, FAN - 1) for k in (-1, 1))
                    low, high = (np.take_along_axis(steps, k, axis=1)[:, 0] for k in beside_it)
                    # Once looked at finely, the piece that holds the largest is known.
                    first = found.max(axis=1).argmax(axis=0)[None]
                    row, piece = (np.take_along_axis(v, first, axis=0) for v in (row, piece))
                    low, high = (np.take_along_axis(v, first, axis=0) for v in (low, high))
                    best = np.maximum(best, found.max(axis=(0, 1)))
        return best

    def _candidates(self, rollers: int, rows: Ints, values: Floats) -> tuple[Ints, Ints, Floats, Floats, Floats]:
        """Roller, piece and the fine steps about the largest samples of the best pieces, (c, n) each, and the largest
        sample, (n,)."""
        size, moving = self.motion.size, self.motion.moving
        every = np.full((rollers, len(self.points.s), size), -np.inf)
        every.reshape(-1, size)[rows] = values
        v = every[:, : moving * PER].reshape(rollers * moving, PER, size)
        top, most = v.argmax(axis=1), v.max(axis=1)
        row = np.argsort(-most, axis=0)[:KEPT]
        middle = np.take_along_axis(top, row, axis=0) * float(STEP)
        low, high = np.maximum(middle - STEP, 0.0), np.minimum(middle + STEP, float(FINE))
        return row // moving, row % moving, low, high, every.max(axis=(0, 1))

    def angle(self, surface: bool, at: Floats | None = None) -> Floats:
        """Largest pressure angle, deg, on the walls, or at a place along the rollers: infinite, always off the cam."""
        tangent = self._worst(lambda delta, seat, side: self.tangent2(surface, delta, seat, side), self.touched, at)
        return np.where(tangent >= 0.0, np.degrees(np.arctan(np.sqrt(np.maximum(tangent, 0.0)))), np.inf)

    @cached_property
    def margin(self) -> Floats:
        """Least margin against undercut over the cut wall, 1."""

        def folding(delta: Floats, seat: Seat, side: float) -> Floats:
            line = self.line(seat, delta)
            bend = side * line.bend
            return np.asarray((0.5 * self.cutter) * (bend + np.sqrt(bend * bend + 4.0 * line.twist2)))

        return np.asarray(1.0 - self._worst(folding, self.cut))

    def relative_radius(self, sign: float) -> Floats:
        """Largest of the relative radius times sign, mm."""

        def radius(delta: Floats, seat: Seat, side: float) -> Floats:
            line = self.line(seat, delta)
            turned = self.roller * self.roller * line.twist2
            rest = 1.0 - (self.roller * side) * line.bend - turned
            return np.asarray(sign * self.roller * rest / (1.0 + turned))

        return self._worst(radius, self.touched)

    # Load

    @cached_property
    def speed(self) -> Floats:
        """Cam speed, rad/s."""
        return np.asarray(self.variants.number("operation.speed") * (2.0 * pi / 60.0))

    @cached_property
    def demand(self) -> Demand:
        """What acts on the turret."""
        number, operation = self.variants.number, self.profile.operation
        assert operation is not None
        return Demand(
            self.speed, number("follower.inertia") + number("operation.load_inertia"), number("operation.friction"),
            number("operation.spring_preload"), number("operation.spring_rate") * DEGREES, np.zeros(1),
            tuple(force.applied() for force in operation.force), True,
        )  # fmt: skip

    def torque(self, points: Points) -> Floats:
        """Torque that the turret needs, N mm."""
        return self.demand.force(points.theta, (points.s, points.ds, points.dds), points.side)[0]

    @property
    def mean_torque(self) -> Floats:
        """Mean torque of the camshaft, N m: a turn ends with the speed that it began with."""
        d, points = self.demand, self.motion.samples
        lost = (d.friction * points.side + d.preload + d.rate * points.s) * points.ds
        for one in d.applied:
            lost = lost + d.of(one, points.theta, (points.s, points.ds, points.dds)) * points.ds
        return MILLI * self.motion.integral(lost) / (2.0 * pi)

    @cached_property
    def compliances(self) -> tuple[Floats, Floats]:
        """Of roller and cam, 1/MPa."""
        roller, cam = ((1.0 - self.variants.number(f"material.{body}.poisson") ** 2)
                       / self.variants.number(f"material.{body}.elastic_modulus") for body in ("roller", "cam"))
        return roller, cam

    @cached_property
    def pair(self) -> Floats:
        """Compliance of the two bodies, 1/MPa."""
        return sum(self.compliances)  # type: ignore[return-value]

    @cached_property
    def pressed(self) -> Pressed:
        """What the load does to the rollers that share it."""
        return Sharing(self).pressed

    @property
    def peak_slice(self) -> Floats:
        """Largest pressure, MPa."""
        return np.sqrt(self.pressed.square)

    @property
    def cam_life(self) -> Floats:
        """Fatigue life of the cam's walls, h."""
        limit, cycles, exponent = (
            self.variants.number(f"material.cam.{key}") for key in ("contact_limit", "contact_cycles", "exponent")
        )
        return hours((self.peak_slice / limit) ** exponent / cycles, self.speed)
