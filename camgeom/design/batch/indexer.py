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
from camgeom.design.batch.motion import REACH, SAMPLES, Ints, Motion, Points, vertex
from camgeom.design.batch.sharing import PER, STEP, THIN, Pressed, Sharing
from camgeom.design.batch.variants import Mask, Variants
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.duty import MILLI
from camgeom.mechanics.life import hours
from camgeom.mechanics.load import Demand
from camgeom.model.loads import DEGREES
from camgeom.track.follower import TurretFollower

ROUNDS = 2
"""times that a largest quantity is laid a parabola through, each about where the one before has its top"""
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
        self.reach = np.arcsin(np.minimum(1.0, 0.5 * self.width / self.circle))
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
    def tangent2(self, surface: bool, delta: Floats, seat: Seat) -> Floats:
        """tan² of the pressure angle, at the worse flank's surface or at the axis."""

    @abstractmethod
    def stretch(self, seat: Seat, side: Floats) -> tuple[Floats, Floats]:
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
    def _surveyed(self) -> tuple[Floats, Ints, Seat, Mask]:
        """The rollers while their middles are beside the cam: offsets (k,), which samples of all of theirs that is for
        some variant, (m,) of k P, the seats there, and where they are, (m, n)."""
        offsets, points = self.offsets(self.reach), self.points
        roller, sample = np.nonzero(self.beside(points, offsets, self.reach))
        near, at = points.of(sample), offsets[roller][:, None]
        return offsets, roller * len(points.s) + sample, self.seat(near, at), np.abs(near.s + at) <= self.reach

    @staticmethod
    def beside(points: Points, offsets: Floats, limit: Floats) -> Mask:
        """Whether rollers at offsets (k,) are within +-limit of the line of centres for some variant, (k, P)."""
        return np.asarray((np.abs(points.s + offsets[:, None, None]) <= limit).any(axis=2))

    @cached_property
    def _ends(self) -> tuple[Seat, Mask] | None:
        """The rollers as they come beside the cam and leave it: seats (e, n), and whether they do, (e, n)."""
        levels = [(end - offset, offset) for offset in self._surveyed[0] for end in (-self.reach, self.reach)]
        inner = [(np.broadcast_to(level, (self.motion.size,)), offset) for level, offset in levels
                 if np.any((level > 0.0) & (level < self.advance))]
        if not inner:
            return None
        lifts, at = np.stack([level for level, _ in inner]), np.array([[offset] for _, offset in inner])
        points = self.motion.reached(np.clip(lifts, 0.0, self.advance))
        return self.seat(points, at), (lifts > 0.0) & (lifts < self.advance)

    def _worst(self, what: Callable[[Floats, Seat], Floats], *stations: Floats) -> Floats:
        """Largest of a quantity over the turn, all rollers beside the cam, and some places along them, (n,)."""
        offsets, rows, seat, here = self._surveyed
        values = what(stations[0], seat)
        for station in stations[1:]:
            np.maximum(values, what(station, seat), out=values)
        row, piece, step, best = self._candidates(offsets, rows, here, values)
        at = offsets[row]
        for _ in range(ROUNDS):
            near = self.motion.at(piece, step + REACH * np.array([-1, 0, 1])[:, None, None])
            beside = self.seat(near, at)
            tried = [vertex(*what(station, beside)) for station in stations]
            move = np.rint(tried[0][0] * REACH).astype(np.intp)
            step = np.clip(step + move, REACH, FINE - REACH)
        for share, value in tried:
            # It is smooth beyond the edge of the cam, but of no account there.
            place = near.s[1] + 0.5 * share * (near.s[2] - near.s[0])
            best = np.maximum(best, np.where(np.abs(place + at) <= self.reach, value, -np.inf).max(axis=0))
        if self._ends is not None:
            seats, there = self._ends
            for station in stations:
                best = np.maximum(best, np.where(there, what(station, seats), -np.inf).max(axis=0))
        return best

    def _candidates(self, offsets: Floats, rows: Ints, here: Mask, values: Floats) -> tuple[Ints, Ints, Ints, Floats]:
        """Roller, piece and fine step of the two largest peaks of the samples surveyed, (2, n) each, and the largest
        sample, (n,)."""
        rollers, size, moving = len(offsets), self.motion.size, self.motion.moving
        every = np.full((2, rollers, len(self.points.s), size), -np.inf)
        every[0].reshape(-1, size)[rows] = np.where(here, values, -np.inf)
        every[1].reshape(-1, size)[rows] = values
        one = np.arange(size)
        v, beyond = every[:, :, : moving * PER].reshape(2, rollers * moving, PER, size)
        top = v.argmax(axis=1)
        most = np.take_along_axis(v, top[:, None], axis=1)[:, 0]
        middle = np.clip(top, 1, PER - 2)
        three = [np.take_along_axis(beyond, middle[:, None] + k, axis=1)[:, 0] for k in (-1, 0, 1)]
        smooth = np.isfinite(most) & np.isfinite(three[0]) & np.isfinite(three[1]) & np.isfinite(three[2])
        at, peak = vertex(*(np.where(smooth, each, 0.0) for each in three))
        # Beyond the edge of the cam a quantity goes on, but is of no account there.
        begin = np.tile(PER * np.arange(moving), rollers)[:, None] + middle
        lift = np.broadcast_to(self.points.s, (len(self.points.s), size))
        low, high = (lift[begin + k, one] + np.repeat(offsets, moving)[:, None] for k in (-1, 1))
        smooth &= np.abs(0.5 * (low + high + at * (high - low))) <= self.reach
        rest = every[0, :, moving * PER :].reshape(-1, size)
        height = np.concatenate([np.where(smooth, peak, most), rest])
        first = height.argmax(axis=0)
        height[first, one] = -np.inf
        row = np.stack([first, height.argmax(axis=0)])
        still = row >= rollers * moving
        place = np.where(smooth, middle + at, top)[np.where(still, 0, row), one] * STEP
        rests = max(len(rest) // rollers, 1)
        roller: Ints = np.where(still, (row - rollers * moving) // rests, row // moving)
        piece = np.where(still, moving + (row - rollers * moving) % rests, row % moving)
        step = np.where(still, FINE // 2, np.clip(np.rint(place), REACH, FINE - REACH)).astype(np.intp)
        found = np.maximum(most.max(axis=0), rest.max(axis=0, initial=-np.inf))
        return roller.astype(np.intp), piece.astype(np.intp), step, np.asarray(found)

    def angle(self, surface: bool, *stations: Floats) -> Floats:
        """Largest pressure angle, deg."""
        tangent = self._worst(lambda delta, seat: self.tangent2(surface, delta, seat), *stations)
        return np.asarray(np.degrees(np.arctan(np.sqrt(np.maximum(tangent, 0.0)))))

    @cached_property
    def margin(self) -> Floats:
        """Least margin against undercut over the cut wall, 1."""

        def folding(delta: Floats, seat: Seat) -> Floats:
            line = self.line(seat, delta)
            bend = np.abs(line.bend)
            return np.asarray((0.5 * self.cutter) * (bend + np.sqrt(bend * bend + 4.0 * line.twist2)))

        return np.asarray(1.0 - self._worst(folding, *self.wall))

    def relative_radius(self, sign: float) -> Floats:
        """Largest of the relative radius times sign, mm: +1 on the wall where it is larger, -1 where it is less."""

        def radius(delta: Floats, seat: Seat) -> Floats:
            line = self.line(seat, delta)
            turned = self.roller * self.roller * line.twist2
            bend = self.roller * np.abs(line.bend)
            return np.asarray(sign * self.roller * (1.0 + sign * bend - turned) / (1.0 + turned))

        return self._worst(radius, self.low, self.high)

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
