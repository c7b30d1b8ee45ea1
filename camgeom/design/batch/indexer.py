"""Indexing cams of many variants: the rollers about the line of centres, geometry of their flanks, and the load.

Arrays are (P, n), P samples of the cam angle and n variants, (m, n) with a row for each roller and sample at which it
is beside the cam, or (k, P, n) with a row for each place that a roller takes.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from math import pi
from typing import Any, Self, final

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
SPIKE = 10.0
"""times the steepest step between samples of a piece by which a quantity may stand above them where a wall ends: of
5000 random barrels 3 times lose a figure of one, 10 times none"""
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
    """Rollers at samples of the motion: tau, its cos and sin, (k, P, n) or (P, n), and its derivatives, (P, n).

    kept  what a kind of cam computes of them once, whatever the place along the roller
    """

    tau: Floats
    cos: Floats
    sin: Floats
    one: Floats
    two: Floats
    kept: tuple[Floats, ...]

    def flat(self, places: Ints, size: int) -> Seat:
        """These places of (P size) alone, (N,)."""
        return self._each(lambda v: v.reshape(-1).take(places if v.shape[1] == size else places // size))

    def columns(self, some: slice | Ints) -> Seat:
        """These of (P, n) alone."""
        return self._each(lambda v: v[:, some])

    def _each(self, pick: Callable[[Floats], Floats]) -> Seat:
        tau, cos, sin, one, two = (pick(v) for v in (self.tau, self.cos, self.sin, self.one, self.two))
        return Seat(tau, cos, sin, one, two, tuple(pick(v) for v in self.kept))


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
    plays: bool
    """whether a tool is larger than its roller"""
    derived: frozenset[str] = frozenset()
    """names of what is derived when it is asked for"""

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
        self.sought = {"folding", *(SOUGHT[name] for name in figures if name in SOUGHT)}
        self.plays = bool(np.any(self.gap))

    def __init_subclass__(cls) -> None:
        every = {name: value for kind in cls.__mro__[::-1] for name, value in vars(kind).items()}
        cls.derived = frozenset(name for name, value in every.items() if isinstance(value, cached_property))

    def of(self, rows: Ints) -> Self:
        """The cams of these variants, each as often as it is named."""
        found = self._part(rows)
        found.variants, found.motion = self.variants.of(rows), self.motion.of(rows)
        return found

    def _part(self, rows: Ints | slice) -> Self:
        """Their numbers alone."""
        found, own, shape = object.__new__(type(self)), dict[str, Any](), self.low.shape
        # Numbers of a variant go along; what was derived of all samples is derived anew where it is asked for.
        for name, value in vars(self).items():
            if not isinstance(value, np.ndarray):
                if name not in self.derived:
                    own[name] = value
            elif value.shape == shape:
                own[name] = value[rows] if isinstance(rows, slice) else value.take(rows)
            else:
                own[name] = value
        vars(found).update(own)
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
        return Seat(points.s + offset, cos, sin, points.ds, points.dds, self.kept(cos, sin, points.ds, points.dds))

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
    def surveyed(self) -> Surveyed:
        """The rollers while they may be beside the cam, for some variant."""
        offsets, points, whole = self.offsets(self.clear), self.points, self.motion.moving * PER
        beside = self.beside(points, offsets, self.clear)
        moves = beside[:, :whole].reshape(len(offsets), -1, PER).any(axis=2)
        (roller, piece), (still, rest) = np.nonzero(moves), np.nonzero(beside[:, whole:])
        every = np.concatenate([np.repeat(roller, PER), still])
        sample = np.concatenate([(piece[:, None] * PER + np.arange(PER)).reshape(-1), whole + rest])
        seat = self.seat(points.of(sample), offsets[every][:, None])
        return Surveyed(offsets, roller, piece, every, sample, seat)

    @staticmethod
    def beside(points: Points, offsets: Floats, limit: Floats) -> Mask:
        """Whether rollers at offsets (k,) are within +-limit of the line of centres for some variant, (k, P)."""
        if points.s.shape[1] == 1:
            limit = np.fmax.reduce(limit, keepdims=True)
        return np.asarray((np.abs(points.s + offsets[:, None, None]) <= limit).any(axis=2))

    def held(self, seat: Seat, side: Floats | float, ends: Ends) -> Held:
        """Ends of what a wall on a side has of the cam beside it, mm, and whether it has: as `track.runout.touching`
        finds it, at one of its places along the roller.

        ends  of the wall along the roller, mm, and its distance from the roller's axis, mm
        """
        return self._on(seat, *self.stretch(seat, side, ends), ends)

    def _on(self, seat: Seat, begin: Floats, stop: Floats, ends: Ends) -> Held:
        """Whether one of a wall's places is between these."""
        low, high, _ = ends
        step = (high - low) / (PLACES - 1)
        last = stop - low
        last /= step
        last += 1e-9
        np.floor(last, out=last)
        last += 1e-9
        last *= step
        on = last >= begin - low
        on &= stop > begin
        on &= np.abs(seat.tau) <= self.clear
        return begin, stop, on

    @cached_property
    def touched(self) -> Ends:
        """Of the rollers."""
        return self.low, self.high, self.roller

    def _bears(self, seat: Seat, side: Floats | float, cut: Held) -> Held:
        """The same of the rollers' walls, of which those that the tool leaves are known."""
        if self.plays:
            return self.held(seat, side, self.touched)
        # Without play they are stretches of one surface.
        begin, stop, _ = cut
        begin, stop = (np.minimum(np.maximum(end, self.low), self.high) for end in (begin, stop))
        return self._on(seat, begin, stop, self.touched)

    def _walled(self, seat: Seat, side: Floats, cut: bool) -> Held:
        """The same of the rollers' walls, or of the cut ones where a roller bears on either."""
        if not cut:
            return self.held(seat, side, self.touched)
        begin, stop, on = held = self.held(seat, side, self.cut)
        bears = self._bears(seat, side, held)[2]
        rows = np.flatnonzero((on & ~bears).any(axis=0))
        if rows.size:
            part = self._part(rows)
            bears[:, rows] |= part.held(seat.columns(rows), -side[rows], part.touched)[2]
        return begin, stop, on & bears

    @cached_property
    def walls(self) -> dict[bool, dict[float, Held]]:
        """What is walled at the samples surveyed, (m, n), by whether the walls are the cut ones and by side."""
        seat = self.surveyed.seat
        cut = {side: self.held(seat, side, self.cut) for side in (self.sides if self.plays else SIDES)}
        rollers = {side: self._bears(seat, side, cut.get(side, cut[1.0])) for side in SIDES}
        bears = np.logical_or(*(on for _, _, on in rollers.values()))
        return {False: rollers, True: {side: (*cut[side][:2], cut[side][2] & bears) for side in self.sides}}

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

    @cached_property
    def largest(self) -> dict[str, Floats]:
        """Of every quantity that is asked for the largest over the turn, all rollers and both walls, (n,): at both ends
        of what a wall has of the cam beside it, or at the place along the rollers that is quoted.

        About the largest sample of each piece the steps are halved as long as more may lie between them than the
        largest found: also beside a jump, where a wall comes, or a kink, where it runs out.
        """
        names = [name for name in QUANTITIES if name in self.sought]
        found = [self._tops(QUANTITIES[name]) for name in names]
        best = np.array([top for top, _ in found])
        self._refined([QUANTITIES[name] for name in names], best, [windows for _, windows in found])
        return dict(zip(names, best))

    def _tops(self, quantity: Quantity) -> tuple[Floats, Windows]:
        """The largest of the samples, (n,), and where there may be more."""
        on, best = self.surveyed, np.full(self.motion.size, -np.inf)
        whole, each, parts = len(on.piece) * PER, [], []
        walls = [(side, far) for side in self.sides for far in (False, True)[: 1 if quantity.quoted else 2]]
        for side, far in walls:
            values = self._valued(quantity, self.walls[quantity.cut][side], on.seat, side, far)
            v = values[:whole].reshape(-1, PER, self.motion.size)
            most = v.max(axis=1)
            np.maximum(best, most.max(axis=0, initial=-np.inf), out=best)
            np.maximum(best, values[whole:].max(axis=0, initial=-np.inf), out=best)
            each.append((v, most))
        for (v, most), (side, far) in zip(each, walls):
            # No three neighbours differ by more than the whole piece.
            window, variant = np.nonzero((most + (most - v.min(axis=1)) > best) & (most > -np.inf))
            some = v[window, :, variant]
            steep, at = SPIKE * _steepest(some.T), np.clip(some.argmax(axis=1), 1, PER - 2)
            begin, stop, _ = self.walls[quantity.cut][side]
            low, high, _ = self.cut if quantity.cut else self.touched
            # At the roller's own end it has a bend, where its end runs in or out.
            end = (stop if far else begin)[:whole].reshape(-1, PER, self.motion.size)[window, :, variant]
            inside = end < high[variant, None] if far else end > low[variant, None]
            row, kink = np.nonzero(inside[:, 1:] ^ inside[:, :-1])
            kink = np.clip(kink, 1, PER - 2)
            other = kink != at[row]
            rows, at = np.concatenate([np.arange(len(at)), row[other]]), np.concatenate([at, kink[other]])
            three = at + np.array([[-1], [0], [1]])
            values, bent = some[rows, three], inside[rows, three]
            bent = bent.any(axis=0) & ~bent.all(axis=0)
            hoped = np.flatnonzero(_hope(values, steep[rows], bent) > best[variant[rows]])
            window, variant, at = window[rows[hoped]], variant[rows[hoped]], three[:, hoped]
            sides, fars = np.full(len(window), side), np.full(len(window), far)
            parts.append(Windows(variant, on.piece[window], on.offsets[on.roller[window]], sides, fars,
                                 at * float(STEP), values[:, hoped]))  # fmt: skip
        return best, Windows.joined(parts)

    def _refined(self, quantities: Sequence[Quantity], best: Floats, parts: Sequence[Windows]) -> None:
        """Raise the largest found of each quantity, (Q, n), to what there is in windows, a part for each of them."""
        size, on = self.motion.size, Windows.joined(parts)
        owner = np.repeat(np.arange(len(parts)), [len(part.variant) for part in parts])
        flat, cam = best.reshape(-1), self.of(on.variant)
        for _ in range(HALVINGS):
            between = 0.5 * (on.steps[1:] + on.steps[:-1])
            seat = cam.seat(cam.motion.at(on.piece, between), on.offset)
            found, ends = np.empty(between.shape), np.searchsorted(owner, np.arange(len(parts) + 1)).tolist()
            for quantity, some in zip(quantities, map(slice, ends, ends[1:])):
                part, there, side = cam._part(some), seat.columns(some), on.side[some]
                held = part._walled(there, side, quantity.cut)
                found[:, some] = part._valued(quantity, held, there, side, on.far[some])
            target = owner * size + on.variant
            np.maximum.at(flat, target, found.max(axis=0))
            steps = np.stack([on.steps[0], between[0], on.steps[1], between[1], on.steps[2]])
            values = np.stack([on.values[0], found[0], on.values[1], found[1], on.values[2]])
            steep = _steepest(values)
            peak = np.clip(values.argmax(axis=0), 1, 3) + np.array([[-1], [0], [1]])
            steps, values = np.take_along_axis(steps, peak, axis=0), np.take_along_axis(values, peak, axis=0)
            on, beaten = replace(on, steps=steps, values=values), flat[target]
            left = np.flatnonzero(_hope(values, steep) > beaten + HAIR * np.abs(beaten))
            if not left.size:
                break
            if left.size < FEWER * len(owner):
                on, owner, cam = on.of(left), owner[left], cam.of(left)

    def _valued(self, quantity: Quantity, held: Held, seat: Seat, side: Floats | float, far: Mask | bool) -> Floats:
        """A quantity where there is a wall, at its end, or at its beginning, or where it is quoted; else -inf."""
        begin, stop, on = held
        if quantity.quoted:
            place = self.quoted
            on = on & (begin <= place) & (place <= stop)
        elif isinstance(far, bool):
            place = stop if far else begin
        else:
            place = np.where(far, stop, begin)
        return np.where(on, quantity.what(self, place, seat, side), -np.inf)

    def angle(self, name: str) -> Floats:
        """Largest pressure angle, deg, on the walls, or at the place that is quoted: infinite, always off the cam."""
        tangent = self.largest[name]
        return np.where(tangent >= 0.0, np.degrees(np.arctan(np.sqrt(np.maximum(tangent, 0.0)))), np.inf)

    @property
    def margin(self) -> Floats:
        """Least margin against undercut over the cut wall, 1."""
        return np.asarray(1.0 - self.largest["folding"])

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


@final
@immutable
class Surveyed:
    """Rollers at `offsets`, (k,), at zero lift, rad, while they may be beside the cam.

    roller, piece  of PER samples each in a piece that moves, (w,)
    every, sample  roller and sample of all of theirs, then of those at rest, (m,)
    seat           of these, (m, n)
    """

    offsets: Floats
    roller: Ints
    piece: Ints
    every: Ints
    sample: Ints
    seat: Seat


@final
@immutable
class Windows:
    """Stretches of pieces in which a quantity is looked for: variant, piece, offset of the roller, side of the wall and
    whether its far end, (N,) each, three fine steps and the values there, (3, N)."""

    variant: Ints
    piece: Ints
    offset: Floats
    side: Floats
    far: Mask
    steps: Floats
    values: Floats

    def of(self, rows: Ints) -> Windows:
        """These of them."""
        return Windows(*(one[..., rows] for one in self._all))

    @staticmethod
    def joined(parts: Sequence[Windows]) -> Windows:
        """All of these."""
        return Windows(*(np.concatenate(some, axis=-1) for some in zip(*(part._all for part in parts))))

    @property
    def _all(self) -> tuple[Any, ...]:
        return self.variant, self.piece, self.offset, self.side, self.far, self.steps, self.values


@final
@immutable
class Quantity:
    """Something of the cams at places along their rollers, mm, on the walls on a side.

    cut     whether these are the walls that the tool leaves, else those at the rollers
    quoted  whether it is asked where the classical figures are quoted, else at both ends of what is beside the cam
    """

    what: Callable[[Indexer, Floats, Seat, Floats | float], Floats]
    cut: bool = False
    quoted: bool = False


def _tangent2(surface: bool, cam: Indexer, delta: Floats, seat: Seat, side: Floats | float) -> Floats:
    return cam.tangent2(surface, delta, seat, side)


def _folding(cam: Indexer, delta: Floats, seat: Seat, side: Floats | float) -> Floats:
    line = cam.line(seat, delta)
    bend = side * line.bend
    return np.asarray((0.5 * cam.cutter) * (bend + np.sqrt(bend * bend + 4.0 * line.twist2)))


def _relative_radius(sign: float, cam: Indexer, delta: Floats, seat: Seat, side: Floats | float) -> Floats:
    """Times sign, mm."""
    line = cam.line(seat, delta)
    turned = cam.roller * cam.roller * line.twist2
    rest = 1.0 - (cam.roller * side) * line.bend - turned
    return np.asarray((sign * cam.roller) * rest / (1.0 + turned))


QUANTITIES = {
    "angle": Quantity(partial(_tangent2, True)),
    "axis": Quantity(partial(_tangent2, False)),
    "quoted": Quantity(partial(_tangent2, True), quoted=True),
    "folding": Quantity(_folding, cut=True),
    "convex": Quantity(partial(_relative_radius, -1.0)),
    "hollow": Quantity(partial(_relative_radius, 1.0)),
}
"""What is looked for where it is largest: tan² of pressure angles, how nearly a wall folds, relative radii."""
SOUGHT = {
    "flank.max_pressure_angle_deg": "angle",
    "flank.max_axis_pressure_angle_deg": "axis",
    "flank.pitch_pressure_angle_deg": "quoted",
    "flank.min_relative_radius_mm": "convex",
    "checks.relative-curvature": "hollow",
}
"""Figures that rest on one; on whether a wall folds rests whether a variant exists."""


def _steepest(values: Floats) -> Floats:
    """Largest step between neighbours of values (k, N) that there are, (N,)."""
    steps = np.abs(np.diff(values, axis=0))
    return np.asarray(np.where(np.isfinite(steps), steps, 0.0).max(axis=0))


def _hope(values: Floats, steep: Floats, bent: Mask | bool = False) -> Floats:
    """How large a quantity may be between three values (3, ...) of it, -inf where there is no wall: as far above the
    largest as they differ, eight times what a parabola has; where a wall ends, or is `bent`, by its steepest step
    thereabouts, and of one value alone nobody knows."""
    walled = np.isfinite(values)
    there, most = walled.sum(axis=0), values.max(axis=0)
    rise = np.where((there == 3) & ~np.asarray(bent), most - values.min(axis=0), np.where(there >= 2, steep, np.inf))
    return np.where(there > 0, most + rise, -np.inf)
