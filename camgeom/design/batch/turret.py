"""Indexing cams with grooves and cylindrical rollers: figures of many variants of a globoid or a barrel at once.

The roller's axis sweeps the pitch surface of which the flanks are offsets. With tau the roller's angle from the line of
centres, tau' and tau'' by the cam angle, and delta the place along the roller axis, its forms are known in closed form,
the same for both hands and senses (a mirror image):

    globoid  R = C - delta cos tau, E = R² + (delta tau')², M = C tau' / sqrt E,
             2H = [delta tau'' R - sin tau (R² + 2 delta² tau'²)] / (E sqrt E), lever = R delta / sqrt E
    barrel   a = y' - delta, b = z', D = a² + b² with y = C - rf cos tau, z = rf sin tau; M = b / sqrt D,
             2H = [a z'' - b (y'' + y)] / (D sqrt D), lever = rf |cos tau| delta / sqrt D

K = -M²/E (M²/D). Arrays are (P, n), P samples of the cam angle and n variants, or (k, P, n) with a row for each place
that a roller takes beside the cam.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING, final

import numpy as np
from numpy.typing import NDArray

from camgeom.cams._turret import TurretKeys
from camgeom.design.batch import LEVELS, Batch
from camgeom.design.batch.common import (
    FINE,
    REACH,
    SAMPLES,
    Motion,
    Points,
    Variants,
    motion_of,
    motion_reason,
    program_of,
    vertex,
)
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.bearing import stud_stress
from camgeom.mechanics.duty import MILLI
from camgeom.mechanics.hertz import flexibility
from camgeom.mechanics.life import hours
from camgeom.mechanics.load import QUIET, Demand
from camgeom.mechanics.turret_duty import STUD_SHARE
from camgeom.model.loads import DEGREES
from camgeom.track.follower import CylinderRoller, TurretFollower
from camgeom.track.runout import PLACES
from camgeom.track.turret import SLICES

if TYPE_CHECKING:
    from camgeom.profile import Profile

CHUNK = 256
THIN = 2
"""of so many samples of the motion one is taken where rollers are surveyed"""
PER = (SAMPLES - 1) // THIN + 1
"""samples of a piece then"""
STEP = FINE // (PER - 1)
"""fine steps between two of them"""
ROUNDS = 2
"""times that a largest quantity is laid a parabola through, each about where the one before has its top"""
TURNS = 3
"""times that flexibilities and slice loads are computed in turn"""
SHARED = {
    "slice": {"contact.peak_slice_pressure_mpa", "fatigue.cam_life_h"},
    "middle": {"contact.peak_pressure_mpa"},
    "force": {"contact.peak_force_n", "contact.stud_stress_mpa"},
}
"""figures that rest on how rollers share the torque"""
EFFORTS = {LEVELS[0]: (4, 5, 12), LEVELS[1]: (8, 9, 16)}
"""by level of the pressures: parts of a step between samples in which a largest one is looked for; places about it;
halvings of the distance of two samples between which a roller comes to bear"""
NEAR = 6
"""fine steps to either side of a largest pressure that are computed once more"""
Mask = NDArray[np.bool_]
Ints = NDArray[np.intp]

GEOMETRY = (
    "motion.stroke_deg",
    "motion.peak_velocity_deg_per_rad",
    "motion.peak_acceleration_deg_per_rad2",
    "motion.peak_jerk_deg_per_rad3",
    "flank.max_pressure_angle_deg",
    "flank.max_axis_pressure_angle_deg",
    "flank.pitch_radius_mm",
    "flank.pitch_pressure_angle_deg",
    "flank.undercut_margin",
    "flank.min_relative_radius_mm",
    "checks.relative-curvature",
)
LOADED = (
    "motion.peak_velocity_deg_per_s",
    "motion.peak_acceleration_deg_per_s2",
    "motion.peak_jerk_deg_per_s3",
    "contact.peak_turret_torque_n_m",
    "contact.peak_torque_n_m",
    "contact.mean_torque_n_m",
    "contact.peak_pressure_mpa",
    "contact.peak_slice_pressure_mpa",
    "contact.peak_force_n",
    "contact.stud_diameter_mm",
    "contact.stud_stress_mpa",
    "fatigue.cam_life_h",
)


def offered(profile: Profile) -> tuple[str, ...]:
    """Names of the figures that the batch gives."""
    return GEOMETRY + (LOADED if profile.operation is not None else ())


def supports(profile: Profile, varied: Sequence[str]) -> str | None:
    """None where the closed forms hold; else why not."""
    cam, roller, program = profile.cam, profile.roller, profile.setup().program
    assert isinstance(cam, TurretKeys)
    if not isinstance(roller, CylinderRoller):
        return f"roller.shape = {roller.shape if roller else None!r}: the closed forms are those of a cylinder"
    if program.closed:
        return "a drive to and fro: every roller has a groove of its own"
    for key in ("cam.relief", "cam.preload", "cam.hub_length"):
        if key in varied or getattr(cam, key.removeprefix("cam."), None):
            return f"{key}: rollers that are pressed or relieved, and hubs, are for the exact model"
    for key in varied:
        if key in ("follower.stops", "follower.rollers"):
            return f"{key}: every value makes another turret"
        if key.endswith(".to"):
            return f"{key}: steps by whole indexes"
        if key.startswith("operation.force"):
            return f"{key}: every value makes another force"
        if key.startswith("motion") and profile.operation is not None and profile.operation.force:
            return f"{key}: applied forces stay at their cam angles, elsewhere in every variant's motion"
        if key == "cam.bore" and not cam.bore:
            return f"{key}: the profile gives none"
    if profile.cutter is not None:
        return "[cutter]: what it says is held against every variant by the exact model"
    lifts = program.jet(np.linspace(0.0, 2.0 * pi, 4097), 1)[1]
    if lifts.min() < -QUIET * lifts.max():
        return "a law that turns back: a roller passes the cam more than once"
    return motion_reason(profile, varied)


def kernel(profile: Profile, columns: Mapping[str, Floats], figures: Sequence[str], level: float) -> Batch:
    """The figures of one chunk of variants."""
    variants = Variants(profile, columns)
    forces = profile.operation.force if profile.operation is not None else ()
    cuts = tuple(angle for force in forces for angle in force.applied().breaks)
    cam = KINDS[profile.kind](variants, motion_of(variants, cuts, bool(forces)), figures, level)
    with np.errstate(all="ignore"):
        cam.refuse()
        values = {name: variants.full(FIGURES[name](cam)) for name in figures}
        variants.refusals.add(cam.margin <= 0.0, "undercut")
        if cam.asked:
            variants.refusals.add(cam.pressed.lost, "no roller can take the turret's torque")
    return variants.refusals.batch(values)


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


@final
@dataclass(frozen=True, eq=False)
class Pressed:
    """What the load does: squares of the largest pressures of all and of the middle slice, MPa², the largest force on a
    roller, N, each (n,); and whether no roller bears somewhere."""

    square: Floats
    middle: Floats
    force: Floats
    lost: Mask


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
        self.finer, self.around, self.halvings = EFFORTS[level]
        self.centre, self.width = number("cam.center_distance"), number("cam.width")
        self.gap = number("cam.running_clearance")
        self.roller, self.length = 0.5 * number("roller.diameter"), number("roller.length")
        self.cutter = self.roller + self.gap
        self.circle = number("follower.pitch_radius")
        self.reach = np.arcsin(np.minimum(1.0, 0.5 * self.width / self.circle))
        self.low, self.high = self.contact()
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
        roller, sample = np.nonzero(self._beside(points, offsets, self.reach))
        near, at = points.of(sample), offsets[roller][:, None]
        return offsets, roller * len(points.s) + sample, self.seat(near, at), np.abs(near.s + at) <= self.reach

    @staticmethod
    def _beside(points: Points, offsets: Floats, limit: Floats) -> Mask:
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

    @cached_property
    def peaks(self) -> tuple[Floats, Floats, Floats]:
        """Largest velocity, acceleration and jerk by the cam angle, deg."""
        first, second, third = (np.degrees(peak) for peak in self.motion.peaks())
        return first, second, third

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

    def press(self, points: Points, offsets: Floats) -> tuple[Floats, Floats, Floats, Mask, Mask]:
        """Squares of the largest pressures of all slices and of the middle one, MPa², and the largest force on a
        roller, N, (P, n) each; whether no roller bears; which do, (k, P, n).

        Rollers at `offsets` (k,) share by their levers, as if all slices were alike flexible.
        """
        beside = self._beside(points, offsets, self.clear)
        beside[0, ~beside.any(axis=0)] = True
        sample, roller = np.nonzero(beside.T)
        starts = np.flatnonzero(np.diff(sample, prepend=-1))
        near, at = points.of(sample), offsets[roller][:, None]
        torque = self.torque(points)
        side = (self.pushing * np.copysign(1.0, torque))[sample]
        seat = self.seat(near, at)
        begin, stop, on = self._bearing(near, seat, at, side)
        cover = np.where(on, stop - begin, 0.0) / 6.0
        ends = [self.lever(seat, delta) for delta in (begin, 0.5 * (begin + stop), stop)]
        first = cover * (ends[0] + 4.0 * ends[1] + ends[2])
        second = cover * (ends[0] ** 2 + 4.0 * ends[1] ** 2 + ends[2] ** 2)
        total = np.add.reduceat(second, starts, axis=0)
        scale = np.divide(np.abs(torque), total, out=np.zeros_like(total), where=total > 0.0)
        share = self.length / SLICES
        nearest = self.low + share * np.floor((begin - self.low) / share + 1.0)
        farthest = self.low + share * np.ceil((stop - self.low) / share - 1.0)
        squares = self._square(seat, 0.5 * (begin + np.minimum(nearest, stop)), side)
        squares = np.maximum(squares, self._square(seat, 0.5 * (np.maximum(farthest, begin) + stop), side))
        scaled = scale / (pi * self.pair)
        middle = np.zeros(1)
        if "middle" in self.asked:
            inner = self.low + share * (SLICES // 2)
            low, high = np.maximum(inner, begin), np.minimum(inner + share, stop)
            there = np.where(on & (low < high), self._square(seat, 0.5 * (low + high), side), 0.0)
            squares = np.maximum(squares, there)
            middle = np.maximum.reduceat(there, starts, axis=0) * scaled
        squares = np.where(on, squares, 0.0)
        lost = (total <= 0.0) & (np.abs(torque) > QUIET * self._most_torque)
        force = np.maximum.reduceat(first, starts, axis=0) * scale
        bearing = np.zeros((*beside.shape, self.motion.size), dtype=bool)
        bearing[roller, sample] = on
        return np.maximum.reduceat(squares, starts, axis=0) * scaled, middle, force, lost, bearing

    def _bearing(self, points: Points, seat: Seat, offsets: Floats, side: Floats) -> tuple[Floats, Floats, Mask]:
        """Ends of what the rollers touch, mm, and whether they touch: as `track.runout.touching` finds it, at one of
        its places along the roller."""
        begin, stop = self.stretch(seat, side)
        step = self.length / (PLACES - 1)
        meets = np.floor((stop - self.low) / step + 1e-9) >= np.ceil((begin - self.low) / step - 1e-9)
        return begin, stop, (np.abs(points.s + offsets) <= self.clear) & (stop > begin) & meets

    def _square(self, seat: Seat, delta: Floats, side: Floats) -> Floats:
        """Lever times relative curvature of the wall on a side at places along the rollers."""
        line = self.line(seat, delta)
        turned = self.roller * self.roller * line.twist2
        rest = 1.0 - self.roller * side * line.bend - turned
        rest = np.where(np.abs(rest) > 1e-12, rest, 1e-12)
        return np.asarray(line.lever * (1.0 + turned) / (self.roller * rest))

    def share(self, points: Points, offsets: Floats) -> tuple[Floats, Floats, Floats]:
        """The same three with slices that approach alike by their own flexibility, as the exact model has them."""
        torque = self.torque(points)
        side = np.where(torque >= 0.0, self.pushing, -self.pushing)
        seat = self.seat(points, offsets)
        begin, stop, beside = self._bearing(points, seat, offsets, side)
        edges = self.low + (self.length / SLICES) * np.arange(SLICES + 1.0)[:, None, None, None]
        first, last = np.maximum(begin, edges[:-1]), np.minimum(stop, edges[1:])
        cover = np.where(beside, np.maximum(last - first, 0.0), 0.0)
        line = self.line(seat, 0.5 * (first + last))
        turned = self.roller * self.roller * line.twist2
        k = (1.0 + turned) / (self.roller * (1.0 - self.roller * side * line.bend - turned))
        k = np.where(k > 0.0, k, 1.0 / self.roller)
        on, size = cover > 0.0, np.abs(torque)
        weight = cover * line.lever
        sum_ = weight.sum(axis=(0, 1))
        load = np.divide(size, sum_, out=np.zeros_like(sum_), where=sum_ > 0.0)
        least = np.maximum(1e-6 * load, 1e-30)
        poisson = self.variants.number("material.cam.poisson")
        for _ in range(TURNS):
            half = 2.0 * np.sqrt(np.maximum(load, least) * self.pair / (pi * k))
            far = np.log(4.0 * self.roller / half)
            stiff = line.lever / flexibility(far, far, *self.compliances, poisson)
            sum_ = (weight * stiff).sum(axis=(0, 1))
            load = stiff * np.divide(size, sum_, out=np.zeros_like(sum_), where=sum_ > 0.0)
        load = np.where(on, load, 0.0)
        square = load * k / (pi * self.pair)
        force = (load * cover).sum(axis=0).max(axis=0)
        return square.max(axis=(0, 1)), square[SLICES // 2].max(axis=0), force

    @cached_property
    def _most_torque(self) -> Floats:
        return np.asarray(np.abs(self.torque(self.motion.samples)).max(axis=0))

    @cached_property
    def pressed(self) -> Pressed:
        """The contact under load: sampled, then where rollers come and go and about the largest values, at last with
        the flexibility of every slice."""
        motion, one = self.motion, np.arange(self.motion.size)
        offsets = self.offsets(self.clear)
        *sampled, lost, bearing = self.press(self.points, offsets)
        wanted = [n for n, word in enumerate(("slice", "middle", "force")) if word in self.asked]
        tops = [np.broadcast_to(sampled[n], lost.shape)[: motion.moving * PER].argmax(axis=0) for n in wanted]
        windows = [(top // PER, top % PER * STEP) for top in {top.tobytes(): top for top in tops}.values()]
        around = np.arange(-STEP, STEP + 1, STEP // self.finer)[:, None]
        tried = [(np.broadcast_to(piece, (len(around), motion.size)), np.clip(step + around, 0, FINE).astype(float))
                 for piece, step in windows]
        if coming := self._comings(bearing, offsets):
            tried.append(coming)
        pieces, steps = (np.concatenate(part) for part in zip(*tried))
        found, near = [np.zeros(1)] * 3, np.linspace(-NEAR, NEAR, self.around)[:, None]
        again = self.press(motion.at(pieces, steps), offsets)
        for n in wanted:
            best = np.broadcast_to(again[n], steps.shape).argmax(axis=0)
            j = np.clip(steps[best, one] + near, 0.0, FINE)
            shared = self.share(motion.at(pieces[best, one], j), offsets[:, None, None])[n]
            found[n] = np.broadcast_to(shared, j.shape).max(axis=0)
        return Pressed(found[0], found[1], found[2], np.asarray(lost.any(axis=0)))

    def _comings(self, bearing: Mask, offsets: Floats) -> tuple[Ints, Floats] | None:
        """Where rollers come to bear or cease to, on either side of it: pieces and fine steps (t, n).

        bearing  which of the rollers at `offsets`, (k,), bear at the samples, (k, P, n)
        """
        motion = self.motion
        v = bearing[:, : motion.moving * PER].reshape(len(bearing), motion.moving, PER, motion.size)
        places: list[Ints] = []
        rollers: list[float] = []
        comes: list[bool] = []
        for roller, row in enumerate(v):
            for comes_on in (True, False):
                change = (row[:, 1:] & ~row[:, :-1]) if comes_on else (row[:, :-1] & ~row[:, 1:])
                flat = change.reshape(-1, motion.size)
                # On either wall in turn: the first and the last.
                first, last = flat.argmax(axis=0), len(flat) - 1 - flat[::-1].argmax(axis=0)
                several = flat.any(axis=0) & (last > first)
                for at in (first, last) if several.any() else (first,):
                    if flat.any():
                        places.append(at)
                        rollers.append(offsets[roller])
                        comes.append(comes_on)
        if not places:
            return None
        piece, sample = np.divmod(np.array(places), PER - 1)
        low = sample * float(STEP)
        high = low + STEP
        at, coming = np.array(rollers)[:, None], np.array(comes)[:, None]
        for _ in range(self.halvings):
            middle = 0.5 * (low + high)
            points = motion.at(piece, middle)
            side = np.where(self.torque(points) >= 0.0, self.pushing, -self.pushing)
            on = self._bearing(points, self.seat(points, at), at, side)[2] == coming
            low, high = np.where(on, low, middle), np.where(on, middle, high)
        return np.concatenate([piece, piece]), np.concatenate([low, high])

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


Place = Callable[[Seat, Floats, Floats], Floats]


@final
class Globoid(Indexer):
    """Globoidal cams."""

    pushing = -1.0

    def contact(self) -> tuple[Floats, Floats]:
        """About the pitch radius."""
        return self.circle - 0.5 * self.length, self.circle + 0.5 * self.length

    @property
    def quoted(self) -> Floats:
        """The pitch radius."""
        return self.circle

    @cached_property
    def outside(self) -> Floats:
        """Radius of the blank's outside about the turret axis, mm."""
        return self.variants.number("cam.globoid_radius")

    @cached_property
    def floor(self) -> Floats:
        """Distance of the floor's edges from the turret axis, mm."""
        tool = self.cutter
        return np.sqrt(self.high**2 + 2.0 * tool * tool) + self.variants.number("cam.tip_clearance")

    @property
    def wall(self) -> tuple[Floats, Floats]:
        """From the roller's inner end to the floor."""
        return self.low, self.floor

    @property
    def clear(self) -> Floats:
        """See `solid.blank.Globoid.clear_angle`."""
        top = 0.95 * self.outside
        size = np.hypot(top, self.cutter)
        angle = np.arcsin(np.minimum(0.5 * self.width / size, 1.0)) + np.arctan2(self.cutter, top)
        return np.where((0.5 * self.width < size) & (angle < 0.5 * pi), 1.02 * angle + 0.01, 0.5 * pi)

    def refuse(self) -> None:
        """As `Globoidal.problems`."""
        self.refuse_shared()
        refusals, cannot = self.variants.refusals, "cannot be built"
        diameter = 2.0 * self.roller
        refusals.add(self.circle >= self.centre, f"follower.pitch_radius: {cannot}")
        refusals.add(self.outside >= self.centre, f"cam.globoid_radius: {cannot}")
        refusals.add(0.5 * self.width >= self.outside, f"cam.width: {cannot}")
        floor = self.centre - self.floor
        refusals.add(floor <= 0.0, f"follower.pitch_radius: {cannot}")
        refusals.add((self.bored > 0.0) & (self.bored >= floor), f"cam.bore: {cannot}")
        within = (self.low - 1e-9 <= self.outside) & (self.outside < self.high)
        refusals.add(~within, f"cam.globoid_radius: {cannot}")
        half = 0.5 * self.pitch
        refusals.add(2.0 * self.low * np.sin(half) <= diameter, f"roller.diameter: {cannot}")
        refusals.add(self.roller * np.cos(half) >= self.outside * np.sin(half), f"roller.diameter: {cannot}")
        if self.base:
            rib = 2.0 * (self.outside * np.sin(half) - self.roller * np.cos(half))
            refusals.add(self.width <= rib, f"cam.width: {cannot}")

    def kept(self, cos: Floats, sin: Floats, one: Floats, two: Floats) -> tuple[Floats, ...]:
        """Nothing."""
        return ()

    def lever(self, seat: Seat, delta: Floats) -> Floats:
        """See the head of this file."""
        away, swept = self.centre - delta * seat.cos, delta * seat.one
        return np.asarray(away * delta / np.sqrt(away * away + swept * swept))

    def line(self, seat: Seat, delta: Floats) -> Line:
        """See the head of this file."""
        away = self.centre - delta * seat.cos
        swept = delta * seat.one
        square, forward = away * away, swept * swept
        form = square + forward
        root = np.sqrt(form)
        bend = (delta * seat.two * away - seat.sin * (square + 2.0 * forward)) / (form * root)
        twist = self.centre * seat.one / form
        return Line(bend, twist * twist, away * delta / root)

    def tangent2(self, surface: bool, delta: Floats, seat: Seat) -> Floats:
        """tan² at the axis; at the surface (r / delta)² more."""
        tangent = delta * seat.one / (self.centre - delta * seat.cos)
        found = tangent * tangent
        return np.asarray(found + (self.roller / delta) ** 2 if surface else found)

    def _arm(self, seat: Seat, side: Floats, delta: Floats) -> tuple[Floats, Floats, Floats]:
        """How far a place along the roller is from the cam's axis, mm, its speed, mm/rad, and roller radius by the
        root of the sum of their squares."""
        away, swept = self.centre - delta * seat.cos, delta * seat.one
        form = away * away
        form = form + swept * swept
        return away, swept, np.asarray(side * self.roller / np.sqrt(form, out=form))

    def _rim(self, seat: Seat, side: Floats, delta: Floats) -> Floats:
        """Distance of the contact point from the turret's axis, seen along the cam, mm."""
        away, swept, arm = self._arm(seat, side, delta)
        z = delta * seat.sin + arm * away * seat.cos
        away = away * (1.0 + arm * seat.sin)
        swept = swept * arm
        rim = self.centre - np.sqrt(away * away + swept * swept)
        return np.sqrt(rim * rim + z * z)

    def _height(self, seat: Seat, side: Floats, delta: Floats) -> Floats:
        """Height z of the contact point, mm."""
        away, _, arm = self._arm(seat, side, delta)
        return np.asarray(delta * seat.sin + arm * away * seat.cos)

    def stretch(self, seat: Seat, side: Floats) -> tuple[Floats, Floats]:
        """From the globoid, or the end faces, to the roller's end: roots of smooth functions by two secant steps."""
        low, high, half, outside = self.low, self.high, 0.5 * self.width, self.outside
        near, far = self._rim(seat, side, low), self._rim(seat, side, high)
        wide = high - low

        def root(what: Place, at_low: Floats, at_high: Floats, level: Floats) -> Floats:
            slope = (at_high - at_low) / wide
            slope = np.where(np.abs(slope) > 1e-12, slope, 1e-12)
            x = np.clip(low + (level - at_low) / slope, low, high)
            x = x + (level - what(seat, side, x)) / slope
            return np.clip(x, low, high)

        begin = np.where(near >= outside, low, root(self._rim, near, far, outside))
        stop = np.where(far >= outside, high, low)
        z_low, z_high, z_begin = (self._height(seat, side, delta) for delta in (low, high, begin))
        leaves, comes = np.abs(z_high) > half, np.abs(z_begin) > half
        if np.any(leaves | comes):
            level = np.where(leaves, np.sign(z_high), np.sign(z_begin)) * half
            edge = root(self._height, z_low, z_high, level)
            stop = np.where(leaves, np.minimum(edge, stop), stop)
            begin = np.where(comes, np.maximum(edge, begin), begin)
            begin = np.where(leaves & comes, stop, begin)
        return begin, np.maximum(stop, begin)


@final
class Barrel(Indexer):
    """Cylindrical indexing cams."""

    pushing = 1.0

    def contact(self) -> tuple[Floats, Floats]:
        """From the drum's outside inwards."""
        radius = 0.5 * self.variants.number("cam.diameter")
        return radius - self.length, radius

    @property
    def quoted(self) -> Floats:
        """The middle of the contact."""
        return np.asarray(0.5 * (self.low + self.high))

    @cached_property
    def floor(self) -> Floats:
        """Distance of the floor from the cam axis, mm."""
        return np.asarray(self.low - self.variants.number("cam.tip_clearance"))

    @property
    def wall(self) -> tuple[Floats, Floats]:
        """From the floor to the drum's outside."""
        return self.floor, self.high

    @property
    def clear(self) -> Floats:
        """See `CylindricalIndexMechanism`."""
        reach = (0.5 * self.width + self.cutter) / self.circle
        return np.where(reach < 0.95, 1.02 * np.arcsin(np.minimum(reach, 1.0)) + 0.01, 0.5 * pi)

    def refuse(self) -> None:
        """As `CylindricalIndex.problems`."""
        self.refuse_shared()
        refusals, cannot = self.variants.refusals, "cannot be built"
        rim, floor = self.cutter, self.floor
        refusals.add(0.5 * self.width + self.roller >= 0.95 * self.circle, f"cam.width: {cannot}")
        refusals.add(floor <= 0.0, f"roller.length: {cannot}")
        beside = np.minimum(1.0, (0.5 * self.width + rim) / self.circle)
        least, most = self.circle - floor + rim, self.circle * np.sqrt(1.0 - beside * beside) + floor - rim
        refusals.add(least >= most, f"cam.width: {cannot}")
        refusals.add((self.centre <= least) | (self.centre >= most), f"cam.center_distance: {cannot}")
        room = np.sqrt(np.maximum(floor * floor - rim * rim, 0.0))
        refusals.add((self.bored > 0.0) & (self.bored >= room), f"cam.bore: {cannot}")
        refusals.add(2.0 * self.circle * np.sin(0.5 * self.pitch) <= 2.0 * self.roller, f"roller.diameter: {cannot}")

    def kept(self, cos: Floats, sin: Floats, one: Floats, two: Floats) -> tuple[Floats, ...]:
        """y', b, (y'' + y), z'', the arm rf |cos tau|, and b²."""
        rf, square = self.circle, one * one
        along, across = rf * cos, rf * sin
        b = along * one
        y, z = self.centre + along * (square - 1.0) + across * two, along * two - across * square
        return across * one, b, y, z, np.abs(along), b * b

    def lever(self, seat: Seat, delta: Floats) -> Floats:
        """See the head of this file."""
        rate, _, _, _, arm, across = seat.kept
        a = rate - delta
        return np.asarray(arm * delta / np.sqrt(a * a + across))

    def line(self, seat: Seat, delta: Floats) -> Line:
        """See the head of this file."""
        rate, b, y, z, arm, across = seat.kept
        a = rate - delta
        form = a * a + across
        root = np.sqrt(form)
        twist = b / form
        return Line((a * z - b * y) / (form * root), twist * twist, arm * delta / root)

    def tangent2(self, surface: bool, delta: Floats, seat: Seat) -> Floats:
        """The contact's arm about the turret along the normal, at the surface by r longer, over that across it."""
        rate, b, _, _, arm, across = seat.kept
        a = rate - delta
        along = np.abs(b * seat.cos + a * seat.sin) * self.circle
        if surface:
            along = along + self.roller * np.sqrt(a * a + across)
        tangent = along / (arm * delta)
        return np.asarray(tangent * tangent)

    def stretch(self, seat: Seat, side: Floats) -> tuple[Floats, Floats]:
        """To the drum's outside, between the end faces: z(delta) is monotone, its root known."""
        r, half = self.roller, 0.5 * self.width
        rate, b, _, _, _, across = seat.kept
        y, z = self.centre - self.circle * seat.cos, self.circle * seat.sin
        outer = self.high * self.high
        stop = self.high
        for _ in range(3):
            a = rate - stop
            beside = y - (side * r) * b / np.sqrt(a * a + across)
            stop = np.sqrt(np.maximum(outer - beside * beside, 0.0))
        stop = np.clip(stop, self.low, self.high)

        def height(delta: Floats) -> Floats:
            a = rate - delta
            return np.asarray(z + (side * r) * a / np.sqrt(a * a + across))

        z_low, z_stop = height(self.low), height(stop)
        comes, leaves = np.abs(z_low) > half, np.abs(z_stop) > half
        arm = np.where(leaves, np.sign(z_stop), np.sign(z_low)) * half - z
        edge = rate - side * arm * np.abs(b) / np.sqrt(np.maximum(r * r - arm * arm, 1e-30))
        edge = np.clip(edge, self.low, stop)
        begin = np.where(comes, np.where(leaves, stop, edge), self.low)
        return begin, np.where(leaves, np.maximum(edge, begin), stop)


KINDS: dict[str, type[Globoid] | type[Barrel]] = {"globoidal": Globoid, "cylindrical-index": Barrel}
FIGURES: dict[str, Callable[[Indexer], Floats]] = {
    "motion.stroke_deg": lambda i: np.degrees(i.motion.stroke),
    "motion.peak_velocity_deg_per_rad": lambda i: i.peaks[0],
    "motion.peak_acceleration_deg_per_rad2": lambda i: i.peaks[1],
    "motion.peak_jerk_deg_per_rad3": lambda i: i.peaks[2],
    "motion.peak_velocity_deg_per_s": lambda i: i.peaks[0] * i.speed,
    "motion.peak_acceleration_deg_per_s2": lambda i: i.peaks[1] * i.speed**2,
    "motion.peak_jerk_deg_per_s3": lambda i: i.peaks[2] * i.speed**3,
    "flank.max_pressure_angle_deg": lambda i: i.angle(True, i.low, i.high),
    "flank.max_axis_pressure_angle_deg": lambda i: i.angle(False, i.low, i.high),
    "flank.pitch_radius_mm": lambda i: i.quoted,
    "flank.pitch_pressure_angle_deg": lambda i: i.angle(True, i.quoted),
    "flank.undercut_margin": lambda i: i.margin,
    "flank.min_relative_radius_mm": lambda i: np.maximum(-i.relative_radius(-1.0), 0.0),
    "checks.relative-curvature": lambda i: 1.0 / i.relative_radius(1.0),
    "contact.peak_turret_torque_n_m": lambda i: MILLI * i.motion.largest(lambda p: np.abs(i.torque(p))),
    "contact.peak_torque_n_m": lambda i: MILLI * i.motion.largest(lambda p: np.abs(i.torque(p) * p.ds)),
    "contact.mean_torque_n_m": lambda i: i.mean_torque,
    "contact.peak_pressure_mpa": lambda i: np.sqrt(i.pressed.middle),
    "contact.peak_slice_pressure_mpa": lambda i: i.peak_slice,
    "contact.peak_force_n": lambda i: i.pressed.force,
    "contact.stud_diameter_mm": lambda i: 2.0 * STUD_SHARE * i.roller,
    "contact.stud_stress_mpa": lambda i: stud_stress(
        i.pressed.force, 0.5 * i.length, 2.0 * STUD_SHARE * i.roller).mises,
    "fatigue.cam_life_h": lambda i: i.cam_life,
}
