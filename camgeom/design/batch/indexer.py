"""Indexing cams of many variants: the rollers about the line of centres, geometry of their flanks, and the load.

Arrays are (P, n), P samples of the cam angle and n variants, (m, n) with a row for each roller and sample at which it
is beside the cam, or (k, P, n) with a row for each place that a roller takes.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from copy import copy
from math import pi
from typing import Self, final

import numpy as np

from camgeom.cams._turret import TurretKeys
from camgeom.design.batch.driven import Driven
from camgeom.design.batch.legs import ALIKE, program_of
from camgeom.design.batch.motion import SAMPLES, Ints, Motion, Points
from camgeom.design.batch.sharing import PER, STEP, THIN, Pressed, Sharing
from camgeom.design.batch.variants import Mask, Variants
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.track.follower import TurretFollower
from camgeom.track.runout import PLACES

SIDES = 1.0, -1.0
HALVINGS = 9
"""times that the steps between samples are halved, at most, where a largest quantity is looked for"""
HAIR = 1e-5
"""share of itself by which it is not looked for any further"""
FEWER = 0.8
"""share of the places looked at from which on down it pays to leave the others out"""
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
@immutable
class Seat:
    """Rollers at samples of the motion: cos and sin of tau, (k, P, n) or (P, n), and its derivatives, (P, n).

    kept  what a kind of cam computes of them once, whatever the place along the roller
    """

    cos: Floats
    sin: Floats
    one: Floats
    two: Floats
    kept: tuple[Floats, ...]

    def flat(self, places: Ints, size: int) -> Seat:
        """These places of (P size) alone, (N,)."""
        each = (self.cos, self.sin, self.one, self.two, *self.kept)
        cos, sin, one, two, *kept = (v.reshape(-1).take(places if v.shape[1] == size else places // size) for v in each)
        return Seat(cos, sin, one, two, tuple(kept))


@final
@immutable
class Line:
    """The pitch surface at one place along the rollers: 2H, M²/D (D the first form's determinant), lever."""

    bend: Floats
    twist2: Floats
    lever: Floats


class Indexer(Driven):
    """The cams of n variants; numbers are (n,) or (1,)."""

    pushing: float
    """side of the pitch surface, in this file's signs, whose wall pushes the turret on"""
    mirrored: bool
    """whether the walls of a roller at -tau, whose speed is the same, are those at tau with the sides changed"""

    def __init__(self, variants: Variants, motion: Motion, figures: Sequence[str], level: float) -> None:
        number = variants.number
        self.variants, self.motion, self.profile, self.figures = variants, motion, variants.profile, figures
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

    def of(self, rows: Ints) -> Self:
        """The cams of these variants, each as often as it is named."""
        found = copy(self)
        # Numbers of a variant go along; what was derived of all samples is derived anew where it is asked for.
        for name, value in vars(self).items():
            if isinstance(value, np.ndarray) and value.shape == (self.motion.size,):
                setattr(found, name, value.take(rows))
            elif isinstance(getattr(type(self), name, None), cached_property) and not isinstance(value, np.ndarray):
                delattr(found, name)
        found.variants, found.motion = self.variants.of(rows), self.motion.of(rows)
        return found

    @abstractmethod
    def contact(self) -> tuple[Floats, Floats]:
        """Ends of the stretch of the roller that touches, mm."""

    @property
    @abstractmethod
    def wall(self) -> tuple[Floats, Floats]:
        """Ends of the cut wall along the roller, mm."""

    @cached_property
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
    def tangent2(self, surface: bool, delta: Floats, seat: Seat, side: Floats | float) -> Floats:
        """tan² of the pressure angle, at the surface of the wall on a side or at the axis."""

    @abstractmethod
    def stretch(self, seat: Seat, side: Floats | float, ends: Ends) -> tuple[Floats, Floats]:
        """Places along the rollers, mm, between which the walls on a side have the cam beside them; empty: none."""

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
    def surveyed(self) -> tuple[Floats, Ints, Points, Seat, Floats]:
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
        first, last = begin - low, stop - low
        for place, slack, rounded in ((first, -1e-9, np.ceil), (last, 1e-9, np.floor)):
            place /= step
            place += slack
            rounded(place, out=place)
        on = last >= first
        on &= stop > begin
        on &= np.abs(points.s + offsets) <= self.clear
        return begin, stop, on

    @cached_property
    def touched(self) -> Ends:
        """Of the rollers."""
        return self.low, self.high, self.roller

    def _walled(self, points: Points, seat: Seat, offsets: Floats, side: Floats, cut: bool) -> Held:
        """The same of the rollers' walls, or of the cut ones where a roller bears on either."""
        if not cut:
            return self.held(points, seat, offsets, side, self.touched)
        begin, stop, on = self.held(points, seat, offsets, side, self.cut)
        bears = self.held(points, seat, offsets, side, self.touched)[2]
        if np.any(on & ~bears):
            bears = bears | self.held(points, seat, offsets, -side, self.touched)[2]
        return begin, stop, on & bears

    @cached_property
    def walls(self) -> dict[bool, dict[float, Held]]:
        """What is walled at the samples surveyed, (m, n), by whether the walls are the cut ones and by side."""
        _, _, near, seat, at = self.surveyed
        rollers = {side: self.held(near, seat, at, side, self.touched) for side in SIDES}
        bears = np.logical_or(*(on for _, _, on in rollers.values()))
        cut = {side: self.held(near, seat, at, side, self.cut) for side in self.sides}
        return {False: rollers, True: {side: (begin, stop, on & bears) for side, (begin, stop, on) in cut.items()}}

    @cached_property
    def cut(self) -> Ends:
        """Of what the tool leaves."""
        return (*self.wall, self.cutter)

    @cached_property
    def sides(self) -> tuple[float, ...]:
        """Walls that are surveyed: one where walls are mirrored and every move ends as it began, since what the other
        wall has at tau it then has at -tau, where another roller is at another time."""
        if not self.mirrored:
            return SIDES
        turns = [2.0 * self.base + leg.before + leg.after for leg in self.motion.legs]
        whole = all(np.all(np.abs(turn - self.pitch * np.rint(turn / self.pitch)) < ALIKE) for turn in turns)
        return SIDES[:1] if whole and all(leg.shape.even for leg in self.motion.legs) else SIDES

    def _worst(self, what: Quantity, cut: bool = False, quoted: bool = False) -> Floats:
        """Largest of a quantity over the turn, all rollers and both walls, (n,): at both ends of what a wall has of the
        cam beside it, or at the place along the rollers that is quoted.

        About the largest sample of each piece the steps are halved as long as more may lie between them than the
        largest found: also beside a jump, where a wall comes, or a kink, where it runs out.
        """
        offsets, rows, _, seat, _ = self.surveyed
        moving, samples = self.motion.moving, len(self.points.s)
        places = 1 if quoted else 2
        every = np.full((len(self.sides), places, len(offsets) * samples, self.motion.size), -np.inf)
        for side, by_side in zip(self.sides, every):
            for far, values in enumerate(by_side):
                values[rows] = self._valued(what, self.walls[cut][side], seat, side, far == 1, quoted)
        v = every.reshape(-1, samples, self.motion.size)
        best = v.max(axis=(0, 1))
        v = v[:, : moving * PER].reshape(-1, PER, self.motion.size)
        most, least = v.max(axis=1), v.min(axis=1)
        # No three neighbours differ by more than the whole piece.
        window, variant = np.nonzero((most + (most - least) > best) & (most > -np.inf))
        each = v[window, :, variant]
        at = np.clip(each.argmax(axis=1), 1, PER - 2) + np.array([[-1], [0], [1]])
        values = each[np.arange(len(each)), at]
        hoped = np.flatnonzero(_hope(values, np.full(len(each), np.inf)) > best[variant])
        window, variant, values, steps = window[hoped], variant[hoped], values[:, hoped], at[:, hoped] * float(STEP)
        wall, window = np.divmod(window, len(offsets) * moving)
        roller, piece = np.divmod(window, moving)
        side, far, offset = np.array(self.sides)[wall // places], wall % places == 1, offsets[roller]
        cam = self.of(variant)
        for _ in range(HALVINGS):
            between = 0.5 * (steps[1:] + steps[:-1])
            points = cam.motion.at(piece, between)
            beside = cam.seat(points, offset)
            found = cam._valued(what, cam._walled(points, beside, offset, side, cut), beside, side, far, quoted)
            np.maximum.at(best, variant, found.max(axis=0))
            steps = np.stack([steps[0], between[0], steps[1], between[1], steps[2]])
            values = np.stack([values[0], found[0], values[1], found[1], values[2]])
            steep = np.abs(np.diff(values, axis=0))
            steep = np.where(np.isfinite(steep), steep, 0.0).max(axis=0)
            peak = np.clip(values.argmax(axis=0), 1, 3) + np.array([[-1], [0], [1]])
            steps, values = np.take_along_axis(steps, peak, axis=0), np.take_along_axis(values, peak, axis=0)
            beaten = best[variant]
            left = np.flatnonzero(_hope(values, steep) > beaten + HAIR * np.abs(beaten))
            if not left.size:
                break
            if left.size < FEWER * len(variant):
                variant, piece, offset = variant[left], piece[left], offset[left]
                side, far, steps, values, cam = side[left], far[left], steps[:, left], values[:, left], cam.of(left)
        return np.asarray(best)

    def _valued(
        self, what: Quantity, held: Held, seat: Seat, side: Floats | float, far: Mask | bool, quoted: bool
    ) -> Floats:
        """A quantity where there is a wall, at its end, or at its beginning, or where it is quoted; else -inf."""
        begin, stop, on = held
        place = self.quoted if quoted else np.where(far, stop, begin)
        on = on & (begin <= place) & (place <= stop) if quoted else on
        return np.where(on, what(self, place, seat, side), -np.inf)

    def angle(self, surface: bool, quoted: bool = False) -> Floats:
        """Largest pressure angle, deg, on the walls, or at the place that is quoted: infinite, always off the cam."""
        tangent = self._worst(lambda cam, delta, seat, side: cam.tangent2(surface, delta, seat, side), quoted=quoted)
        return np.where(tangent >= 0.0, np.degrees(np.arctan(np.sqrt(np.maximum(tangent, 0.0)))), np.inf)

    @cached_property
    def margin(self) -> Floats:
        """Least margin against undercut over the cut wall, 1."""

        def folding(cam: Indexer, delta: Floats, seat: Seat, side: Floats | float) -> Floats:
            line = cam.line(seat, delta)
            bend = side * line.bend
            return np.asarray((0.5 * cam.cutter) * (bend + np.sqrt(bend * bend + 4.0 * line.twist2)))

        return np.asarray(1.0 - self._worst(folding, cut=True))

    def relative_radius(self, sign: float) -> Floats:
        """Largest of the relative radius times sign, mm."""

        def radius(cam: Indexer, delta: Floats, seat: Seat, side: Floats | float) -> Floats:
            line = cam.line(seat, delta)
            turned = cam.roller * cam.roller * line.twist2
            rest = 1.0 - (cam.roller * side) * line.bend - turned
            return np.asarray(sign * cam.roller * rest / (1.0 + turned))

        return self._worst(radius)

    # Load

    @cached_property
    def pressed(self) -> Pressed:
        """What the load does to the rollers that share it."""
        return Sharing(self).pressed

    @property
    def square(self) -> Floats:
        """Square of the largest pressure of all slices, MPa²."""
        return self.pressed.square

    @property
    def middle(self) -> Floats:
        """The same of the middle slice."""
        return self.pressed.middle

    @property
    def force(self) -> Floats:
        """Largest force on a roller, N."""
        return self.pressed.force


Quantity = Callable[[Indexer, Floats, Seat, Floats | float], Floats]
"""Something of the cams at places along their rollers, mm, on the walls on a side."""


def _hope(values: Floats, steep: Floats) -> Floats:
    """How large a quantity may be between three values (3, ...) of it, -inf where there is no wall: as far above the
    largest as they differ, eight times what a parabola has; where a wall ends by its steepest step thereabouts, and of
    one value alone nobody knows."""
    walled = np.isfinite(values)
    there, most = walled.sum(axis=0), values.max(axis=0)
    rise = np.where(there == 3, most - values.min(axis=0), np.where(there == 2, steep, np.inf))
    return np.where(there > 0, most + rise, -np.inf)
