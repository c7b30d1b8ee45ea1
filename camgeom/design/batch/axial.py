"""Drums with cylindrical rollers that a slide or an arm carries along them: what many variants share, load and contact.

A wall is known by two numbers at every place along the roller, its lever and its relative curvature, which the kinds of
follower give in closed form. Arrays are (P, n), P samples of the cam angle and n variants; a leading axis of slices
where there is one.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable
from dataclasses import replace
from functools import partial
from itertools import combinations, product
from math import pi
from typing import Any, Self, TypeVar, final

import numpy as np
from numpy.typing import NDArray

from camgeom.cams.cylindrical import Cylindrical
from camgeom.design.batch.legs import FINE
from camgeom.design.batch.motion import ABOUT, NEAR, REACH, ROUNDS, Ints, Motion, Points, nearer, single, vertex
from camgeom.design.batch.variants import Mask, Variants, demand_of
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.duty import MILLI
from camgeom.mechanics.hertz import flexibility
from camgeom.mechanics.life import hours
from camgeom.mechanics.load import Demand
from camgeom.mechanics.pressing import SLICES
from camgeom.model import ALIKE

TURNS = 3
"""times that flexibilities and slice loads are computed in turn: each leaves about a tenth of the error before"""
SPARE = 0.2
"""share of a roller that touches at all samples from which on some of it does between them too"""
UNEVEN = 4.0
"""times the mean that a roller's load may be at one of its ends, beside what the ratio of its levers makes of it"""
NARROW, APART = 0.25, 4
"""share of a roller's radius above which a half-width at one of every so many samples may be more than it elsewhere"""
NONE = 1e-9
"""share of a roller that counts as nothing"""
BESIDE = np.arange(-128, 129, 2)[:, None]
"""fine steps beside the place where least of a roller touches, over which it is asked whether any does"""
LEAST = 1e-20
"""N; a force below it counts as so much"""
OFF = 5e-3
"""share of itself by which the square of a pressure may be off where flexibilities are computed once"""
SCANNED = (4, 1)
"""spacings, fine steps, at which one peak of the hardest contact is looked at, and not the next one, which within OFF
may be as high"""
TRIALS = ROUNDS + 2
MOST = 6
"""places in which the hardest contact is looked for, at most"""
CANNOT = "cannot be built"
Known = TypeVar("Known")
Stations = tuple[Floats, Floats]
"""Places along the roller, shares of what touches, (m, 1, 1), and the shares of it that they stand for, (m,)."""
_MIDDLES = (np.arange(SLICES) + 0.5) / SLICES
EVERY: Stations = (
    np.array([0.0, *_MIDDLES, 1.0])[:, None, None], np.array([0.0, *np.full(SLICES, 1.0 / SLICES), 0.0])
)  # fmt: skip
"""The slices' middles, and both ends, which bear no force of their own."""
_END = (1.0 - 1.0 / SLICES**2) / 6.0
FEW: Stations = np.array([0.0, 0.5, 1.0])[:, None, None], np.array([_END, 1.0 - 2.0 * _END, _END])
"""Both ends and the middle, as the slices' middles sum up a cubic."""


@final
@immutable
class Slices:
    """The contact in slices along the roller: its square of pressure, MPa², (m, P, n), and the length that touches."""

    square: Floats
    curvature: Floats
    touching: Floats


@final
@immutable
class Hard:
    """The hardest contacts of n variants, (n,) each.

    slice  largest pressure of all slices and both ends, MPa
    curvature, touching  relative curvature, 1/mm, and the length that touches, mm, there
    """

    slice: Floats
    curvature: Floats
    touching: Floats

    @property
    def figures(self) -> tuple[Floats, ...]:
        """All of it in turn."""
        return self.slice, self.curvature, self.touching

    def half_width(self, pair: Floats) -> Floats:
        """Of the hardest slice's contact, mm, of bodies with a compliance of both, 1/MPa."""
        return np.asarray(2.0 * self.slice * pair / self.curvature)


class Axial(ABC):
    """The grooves or ribs of n variants; numbers are (n,) or (1,)."""

    def __init__(self, variants: Variants, motion: Motion) -> None:
        number = variants.number
        self.variants, self.motion, self.profile = variants, motion, variants.profile
        self.radius = 0.5 * number("cam.diameter")
        self.floor = self.radius - number("cam.groove_depth")
        self.roller = 0.5 * number("roller.diameter")
        self.length = number("roller.length")
        self.low = self.radius - self.length
        self.cutter = self.roller + number("cam.running_clearance")
        quoted = variants.optional("cam.pitch_radius")
        self.middle = 0.5 * (self.low + self.radius)
        self.pitch = self.middle if quoted is None else quoted
        assert isinstance(variants.profile.cam, Cylindrical)
        self.rib = variants.profile.cam.form == "rib"
        """Whether two rollers embrace a rib."""
        self._known: dict[tuple[Hashable, Points], Any] = {}
        # Without a wall at the pitch radius the contact is quoted in the middle of what has one.
        self.quoted = np.where((self.low <= self.pitch) & (self.pitch <= self.radius), self.pitch, self.middle)

    def once(self, key: Hashable, points: Points, what: Callable[[], Known]) -> Known:
        """Something of points, which is kept, by a key, of the samples: they come again."""
        if not points.kept:
            return what()
        if (key, points) not in self._known:
            self._known[key, points] = what()
        found: Known = self._known[key, points]
        return found

    @cached_property
    def rough(self) -> Self:
        """The same in single precision."""
        return type(self)(self.variants.rough, self.motion)

    def largest(self, what: Callable[[Self, Points], Floats], motion: Motion, bent: bool = False) -> Floats:
        """The largest of a quantity of drums at points of a motion, (n,)."""
        values = motion.spread(partial(what, self.rough), rough=True)
        return motion.largest(partial(what, self), values, bent, lambda rows: partial(what, self.of(rows)))

    def of(self, rows: Ints) -> Self:
        """Those of these variants, each as often as it is named."""
        return type(self)(self.variants.of(rows), self.motion.of(rows))

    def refuse(self) -> None:
        """Give what `Cylindrical.problems` has against a variant, in its order."""
        number, refusals = self.variants.number, self.variants.refusals
        depth, bore = number("cam.groove_depth"), number("cam.bore")
        width, deep = number("cam.keyway_width"), number("cam.keyway_depth")
        refusals.add(depth >= self.radius, f"cam.groove_depth: {CANNOT}")
        if self.variants.optional("cam.bore") is not None and np.all(bore > 0.0):
            reach = np.where(width > 0.0, np.hypot(0.5 * bore + deep, 0.5 * width), 0.5 * bore)
            refusals.add(width >= bore, f"cam.keyway_width: {CANNOT}")
            refusals.add((width > 0.0) != (deep > 0.0), f"cam.keyway_depth: {CANNOT}")
            refusals.add(reach >= self.floor, f"cam.bore: {CANNOT}")
        refusals.add(self.length > depth, f"roller.length: {CANNOT}")
        refusals.add((self.pitch < self.low) | (self.pitch > self.radius), f"cam.pitch_radius: {CANNOT}")
        start, (least, most) = number("cam.start"), self.heights
        meets = (start > -most - self.half) & (start < number("cam.length") - least + self.half)
        refusals.add(~meets, f"cam.start: {CANNOT}")
        self.refuse_carrier()

    @property
    def half(self) -> Floats:
        """From the pitch curve to the wall of a dwell, mm: half the rib, or the roller's radius in a groove."""
        return 0.5 * self.variants.number("cam.rib_thickness") if self.rib else self.roller

    # What carries the roller

    @abstractmethod
    def refuse_carrier(self) -> None:
        """What is wrong with what carries the roller, after all else."""

    @property
    @abstractmethod
    def heights(self) -> tuple[Floats, Floats]:
        """Least and largest height of the roller above that at zero lift, mm."""

    @property
    @abstractmethod
    def aside(self) -> Floats:
        """Largest distance, mm, of a roller's line from the drum's axis."""

    @property
    @abstractmethod
    def steepest(self) -> Floats:
        """Largest pressure angle on the walls, deg."""

    @property
    @abstractmethod
    def steepest_axis(self) -> Floats:
        """The same at the roller's axis, deg."""

    @property
    @abstractmethod
    def steepest_quoted(self) -> Floats:
        """The same on the walls at the pitch radius, deg."""

    @property
    @abstractmethod
    def margin(self) -> Floats:
        """Least margin against undercut over the wall, 1: from the tool's end up, of a rib from the drum beside it."""

    @property
    @abstractmethod
    def thickness(self) -> Floats:
        """Least normal thickness of a rib, mm, at its tip and its foot: how far points of either wall are from all
        places of the other's roller."""

    @abstractmethod
    def widest(self, sign: float) -> Floats:
        """Largest of the relative radius times sign over the walls, mm; a cusp has none."""

    @property
    def least_radius(self) -> Floats:
        """Smallest relative radius, mm; 0 of a cusp."""
        return np.maximum(-self.widest(-1.0), 0.0)

    @property
    def dullest(self) -> Floats:
        """Smallest relative curvature, 1/mm."""
        return np.asarray(1.0 / self.widest(1.0))

    @property
    @abstractmethod
    def run_out(self) -> Floats:
        """From the roller's contact to the nearer end of the drum, mm."""

    @property
    @abstractmethod
    def jams(self) -> NDArray[np.bool_]:
        """Whether the follower jams in its guides."""

    @abstractmethod
    def pushed(self, points: Points, force: Floats) -> Floats:
        """What pushes the follower on, N or N mm, where it needs a force: the friction of its guides is in it."""

    @abstractmethod
    def normal(self, points: Points, way: float, force: Floats, place: Floats) -> Floats:
        """Normal force, N, of a roller that pushes the follower as it needs if all of it acts at a place, mm.

        way  of a rib's roller: 1 of that which pushes the follower up, -1 of the other; 0 of a groove's
        """

    @abstractmethod
    def lever2(self, points: Points, way: float, place: Floats) -> Floats:
        """Square of the speed of the contact along its normal per unit of the lift, 1 or mm², at a place along the
        roller, mm."""

    @abstractmethod
    def wall(self, points: Points, way: float, up: Floats, place: Floats) -> tuple[Floats, Floats]:
        """Lever, and relative curvature, 1/mm, of the wall that pushes the follower up, 1, or down, -1, at a place."""

    @abstractmethod
    def reach(self, points: Points, way: float, up: Floats) -> Floats:
        """How far such a wall reaches along the roller from its inner end on, mm: nowhere where it is not positive."""

    def across(self, signed: Floats, twist2: Floats) -> Floats:
        """Relative curvature of a wall whose pitch curve is curved by `signed` away from it, 1/mm.

        The denominator is kept from zero, as that of the exact flank is.
        """
        rest = self.roller * signed
        rest += 1.0
        rest -= twist2
        rest[np.abs(rest) <= 1e-12] = 1e-12
        rest *= self.roller
        return np.asarray((1.0 + twist2) / rest)

    def over(
        self, what: Callable[[Self, Floats, Points], Floats], places: Floats, values: Floats, motion: Motion
    ) -> Floats:
        """Largest of a quantity over a motion and over places along the roller (k, n), (n,).

        values  at the samples (P, n), or those of every place, (k, P, n)
        """
        piece, step, tried = motion.tops(values)
        found = self._over(what, places, motion, piece[0], step[0])
        for top in zip(piece[1:], step[1:], tried[1:]):
            rows = np.flatnonzero(top[2])
            if rows.size:
                few = places[:, rows] if places.shape[1] > 1 else places
                more = self.of(rows)._over(what, few, motion.of(rows), top[0][rows], top[1][rows])
                found[rows] = np.maximum(found[rows], more)
        return found

    def _over(
        self, what: Callable[[Self, Floats, Points], Floats], places: Floats, motion: Motion, piece: Ints, step: Ints
    ) -> Floats:
        """The largest near a place of the motion, at that of places along the roller where it is largest there."""
        near = replace(motion.at(piece, step[None]), kept=True)
        height = np.stack([what(self, place, near)[0] for place in places])
        best = np.broadcast_to(places, height.shape)[height.argmax(axis=0), np.arange(motion.size)]

        def some(rows: Ints) -> Callable[[Points], Floats]:
            return partial(what, self.of(rows), best[rows])

        return motion.top(partial(what, self, best), piece, step, some)[0]

    # Load

    @cached_property
    def demand(self) -> Demand:
        """What acts on the follower."""
        return demand_of(self.variants)

    @cached_property
    def speed(self) -> Floats:
        """Cam speed, rad/s."""
        return self.demand.speed

    def force(self, points: Points) -> Floats:
        """Force, or torque, that the follower needs, N or N mm."""
        jet = points.s, points.ds, points.dds
        return self.once("force", points, lambda: self.demand.force(points.theta, jet, points.side)[0])

    @cached_property
    def peak_force(self) -> Floats:
        """Largest normal force at the quoted radius, N."""
        forces = []
        for way in self.ways:

            def normal(drums: Self, points: Points, way: float = way) -> Floats:
                force = drums.force(points)
                return _only(way, force, np.abs(drums.normal(points, way, force, drums.quoted)))

            forces.append(self.largest(normal, self.motion, self.guided))
        return np.asarray(np.max(forces, axis=0))

    @cached_property
    def peak_torque(self) -> Floats:
        """Largest torque of the camshaft, N m."""

        def torque(drums: Self, points: Points) -> Floats:
            return np.abs(drums.pushed(points, drums.force(points)) * points.ds)

        return MILLI * self.largest(torque, self.motion, self.guided)

    @cached_property
    def mean_torque(self) -> Floats:
        """Mean torque of the camshaft, N m: inertia, springs and weight give back what they take."""
        d, points = self.demand, self.motion.samples
        lost = d.friction * np.abs(points.ds)
        for one in d.applied:
            lost = lost + d.of(one, points.theta, (points.s, points.ds, points.dds)) * points.ds
        work = self.motion.integral(lost)
        if self.guided:
            # The side thrust has a kink where the force changes walls.
            work = work + self.motion.fine_integral(self._rubbed)
        return MILLI * work / (2.0 * pi)

    def _rubbed(self, points: Points) -> Floats:
        """What friction in the guides takes, N mm/rad."""
        force = self.force(points)
        return np.asarray((self.pushed(points, force) - force) * points.ds)

    @cached_property
    def guided(self) -> bool:
        """Whether the follower's guides have friction."""
        return bool(np.any(self.variants.number("operation.guide_friction") != 0.0))

    @cached_property
    def ways(self) -> tuple[float, ...]:
        """Of every roller: whether it pushes the follower down, up or both ways."""
        return (-1.0, 1.0) if self.rib else (0.0,)

    # Contact

    @cached_property
    def pair(self) -> Floats:
        """Compliance of the two bodies, 1/MPa."""
        return self.compliance("roller") + self.compliance("cam")

    def compliance(self, body: str) -> Floats:
        """Plane-strain compliance of a body, 1/MPa."""
        poisson = self.variants.number(f"material.{body}.poisson")
        return np.asarray((1.0 - poisson * poisson) / self.variants.number(f"material.{body}.elastic_modulus"))

    def square(self, points: Points, way: float, force: Floats) -> Floats:
        """Square of the pressure at the quoted radius, MPa²."""
        lever, k = self.wall(points, way, np.copysign(1.0, force), self.quoted)
        size = np.abs(self.normal(points, way, force, self.quoted)) if self.guided else np.abs(force) / lever
        return np.asarray(k * size / (self.length * pi * self.pair))

    @property
    def pressure(self) -> Floats:
        """Largest pressure at the quoted radius, MPa, of the hardest pressed roller."""
        return np.where(self._mine, self._quoted[0], self._quoted[-1]) if self.rib else self._quoted[0]

    def _walled(self, points: Points, way: float, force: Floats, share: Floats) -> tuple[Floats, ...]:
        """Lever and relative curvature, 1/mm, at shares (m, 1, 1) of what touches of the wall that a force presses, the
        length that touches, mm, and the force over it."""
        force = self.pushed(points, force)
        up = np.copysign(1.0, force)
        # Where no force presses there may be no wall: what is left of it is not zero.
        touching = np.clip(self.reach(points, way, up), NONE * self.length, self.length)
        lever, k = self.wall(points, way, up, self.low + touching * share)
        k = np.where(k > 0.0, k, 1.0 / self.roller)
        return lever, k, touching, np.maximum(np.abs(force), LEAST) / touching

    def ends(self, points: Points, way: float, force: Floats) -> Slices:
        """The contact at both ends, its square within OFF: they are more or less flexible than the middle by
        the logarithm of load over curvature, x, of which (y - x) / (y + x) is half."""
        lever, k, touching, over = self._walled(points, way, force, FEW[0][::2])
        x = lever / k
        more = (x[1] - x[0]) / (x[1] + x[0]) * self._softer
        stiff = lever / np.stack([1.0 - more, 1.0 + more])
        outer = stiff * lever
        middle = (1.0 - 2.0 * _END) * self.lever2(points, way, self.low + 0.5 * touching)
        over = over / (_END * (outer[0] + outer[1]) + middle)
        return Slices(stiff * k * (over / (pi * self.pair)), k, touching)

    def slices(self, points: Points, way: float, force: Floats, stations: Stations, turns: int) -> Slices:
        """The contact at places along the roller that approach alike, each by its own flexibility."""
        share, weight = stations
        lever, k, touching, over = self._walled(points, way, force, share)
        line = self._together(lever, lever, weight, over)
        for _ in range(turns):
            soft = self._soft[0] + self._soft[1] * np.log(line / k)
            line = self._together(lever / soft, lever, weight, over)
        return Slices(line * k / (pi * self.pair), k, touching)

    @cached_property
    def _softer(self) -> Floats:
        """By which share a contact is more flexible for a unit of that logarithm, under about the largest force."""
        still, more = self._soft
        return np.asarray(more / (still + more * np.log(self.peak_force * self.roller / self.length)))

    @staticmethod
    def _together(stiff: Floats, lever: Floats, weight: Floats, over: Floats) -> Floats:
        """Loads per length, as places are stiff along their levers, that carry a force `over` the length together."""
        return np.asarray(stiff * (over / np.einsum("i,ijk,ijk->jk", weight, stiff, lever)))

    @cached_property
    def _soft(self) -> tuple[Floats, Floats]:
        """Of a line contact's flexibility, which is linear in the logarithm of its load per length over its relative
        curvature: what does not change with it and what it is multiplied by; see `line_flexibility`."""
        bodies = self.compliance("roller"), self.compliance("cam"), self.variants.number("material.cam.poisson")
        still, more = (flexibility(far, far, *bodies) for far in (np.zeros(1), np.ones(1)))
        more -= still
        # Of 4 r over the half-width, 2 sqrt(load pair / (pi k)).
        return still + more * (np.log(2.0 * self.roller) - 0.5 * np.log(self.pair / pi)), -0.5 * more

    @cached_property
    def hardest(self) -> Hard:
        """The hardest contact: of a rib's rollers, one pressed upwards and one downwards, that of the harder."""
        if not self.rib:
            return self._hards[0]
        return Hard(*(np.where(self._mine, *both) for both in zip(*(one.figures for one in self._hards))))

    @cached_property
    def _mine(self) -> Mask:
        """Whether of a rib's rollers the first is the harder one."""
        first, second = self._peaks
        return np.asarray(first >= (1.0 - ALIKE) * np.maximum(first, second))

    @property
    def _peaks(self) -> list[Floats]:
        """The largest pressure of every roller, MPa, of all slices and the quoted place."""
        return [np.maximum(one.slice, quoted) for one, quoted in zip(self._hards, self._quoted)]

    @cached_property
    def _hards(self) -> tuple[Hard, ...]:
        """Of every roller."""
        return tuple(self._hard(way) for way in self.ways)

    @cached_property
    def _quoted(self) -> tuple[Floats, ...]:
        """Largest pressure at the quoted radius, MPa, of every roller."""
        found = []
        for way in self.ways:

            def square(drums: Self, points: Points, way: float = way) -> Floats:
                force = drums.force(points)
                return _only(way, force, drums.square(points, way, force))

            found.append(self.largest(square, self.motion, self.guided))
        return tuple(np.sqrt(np.maximum(one, 0.0)) for one in found)

    @property
    def wearing(self) -> Floats:
        """Largest pressure at the quoted radius, MPa, of any roller: what the cam's life is quoted with."""
        return np.asarray(np.max(self._quoted, axis=0))

    def _hard(self, way: float) -> Hard:
        """The hardest contact of the roller that pushes the follower up, 1, down, -1, or either way, 0."""
        found = []
        for points in self.motion.parts:
            force = self.force(points)
            near = self.ends(points, way, force)
            found.append((*_only(way, force, near.square), near.touching))
        inner, outer, touching = (np.concatenate(one) for one in zip(*found))
        lost = self._lost(way, touching)
        # Either end of the roller may be the harder one.
        square, k, touching = self._sought(way, *self.motion.tops(np.stack([inner, outer]), MOST, OFF, self.guided))
        lost |= touching <= 2.0 * NONE * self.length
        slices = np.where(lost, np.inf, np.sqrt(np.maximum(square, 0.0)))
        return Hard(slices, np.where(lost, 1.0 / self.roller, k), np.where(lost, 0.0, touching))

    def _sought(self, way: float, piece: Ints, step: Ints, tried: Mask) -> Floats:
        """Square of the largest pressure about places (k, n) that are tried, MPa², relative curvature, 1/mm, and the
        length that touches there, mm, (3, n)."""
        for i, j in combinations(range(len(tried)), 2):
            # Both ends of a roller are as hard at about the same place.
            tried[j] &= ~(tried[i] & (piece[i] == piece[j]) & (np.abs(step[i] - step[j]) <= REACH))
        _, variant = np.nonzero(tried)
        value, place = self._tops(way, variant, piece[tried], self._scanned(way, variant, piece[tried], step[tried]))
        best = np.full(self.motion.size, -np.inf)
        np.maximum.at(best, variant, value)
        left = value >= (1.0 - 2.0 * OFF) * best[variant]
        tried[tried] = left
        part, piece = self.of(variant[left]), piece[tried]
        points = part.motion.at(piece, place[left][None])
        force = part.force(points)
        near = part.slices(points, way, force, EVERY, TURNS)
        square = _only(way, force, near.square)[:, 0]
        which = square.argmax(axis=0), np.arange(len(piece))
        every = np.full((3, *tried.shape), -np.inf)
        every[:, tried] = square[which], near.curvature[:, 0][which], near.touching[0]
        return np.asarray(every[:, every[0].argmax(axis=0), np.arange(self.motion.size)])

    def _scanned(self, way: float, variant: Ints, piece: Ints, step: Ints) -> Ints:
        """The fine steps about places where the contact is hardest; those themselves where it has no bends."""
        if not self.guided:
            return step
        part = self.of(variant)
        found: Ints = part.motion.scanned(partial(part._hardness, way), piece[None], step[None], SCANNED)[0]
        return found

    def _hardness(self, way: float, points: Points) -> Floats:
        """Square of the largest pressure, MPa², within OFF."""
        force = self.force(points)
        return _only(way, force, np.asarray(self.slices(points, way, force, FEW, 1).square.max(axis=0)))

    def _tops(self, way: float, variant: Ints, piece: Ints, step: Ints) -> tuple[Floats, Floats]:
        """Square of the largest pressure about places, MPa², within OFF, and the fine step where it is, (N,)."""
        value, place = np.empty((2, len(variant)))
        rows, part = np.arange(len(variant)), self.of(variant)
        reach = np.full(len(variant), NEAR if self.guided else REACH)
        for _ in range(TRIALS):
            values = part._hardness(way, part.motion.at(piece, step + reach * ABOUT))
            at, top = vertex(*values)
            value[rows], place[rows] = top, step + at * reach
            more, moved, closer = nearer(values, at, step, reach)
            # Twice what a parabola can stand above its samples: others that cannot be harder stay as they are.
            doubt = 0.25 * np.abs(values[0] - 2.0 * values[1] + values[2]) + OFF * top
            sure = np.full(self.motion.size, -np.inf)
            np.maximum.at(sure, variant, top - doubt)
            left = np.flatnonzero(more & ((top + doubt >= sure[variant]) | (np.abs(at) >= 1.0)))
            if not left.size:
                break
            rows, variant, piece, step, reach, part = (
                rows[left], variant[left], piece[left], moved[left], closer[left], part.of(left)
            )
        return value, place

    def _lost(self, way: float, touching: Floats) -> NDArray[np.bool_]:
        """Whether the roller is pressed where it has no wall at all, so that its pressure has no bound.

        touching  length that touches at the samples, mm
        """

        def least(points: Points) -> Floats:
            force = self.force(points)
            spare = -self.reach(points, way, np.copysign(1.0, force))
            return np.where((force != 0.0) & ((way == 0.0) | (np.copysign(1.0, force) == way)), spare, -self.length)

        on = self.motion
        if np.all(touching > SPARE * self.length):
            return np.zeros(self.variants.size, dtype=bool)
        # Where the force changes walls the reach jumps, so that no parabola finds the least of it.
        piece, step = (each[0] for each in on.tops(on.spread(least))[:2])
        return np.asarray((least(on.at(piece, np.clip(step + BESIDE, 0, FINE))) > 0.0).any(axis=0))

    @property
    def too_wide(self) -> Mask:
        """Whether a contact is wider than its roller: of what touches hardly anywhere."""
        rows = np.arange(self.variants.size) if "_hards" in vars(self) else np.flatnonzero(~self._faint)
        if rows.size and "_hards" not in vars(self):
            rows = rows[~(self if rows.size == self.variants.size else self.of(rows))._narrow]
        found = np.zeros(self.variants.size, dtype=bool)
        if rows.size:
            some = self if rows.size == len(found) else self.of(rows)
            wide = [(one.half_width(some.pair) > some.roller) & np.isfinite(one.slice) for one in some._hards]
            found[rows] = np.any(wide, axis=0)
        return found

    @property
    def _faint(self) -> Mask:
        """Whether no contact can be wide, without a look at any: most of the roller touches wherever it stands, since
        the point beside it where it leaves the land is no further from the line that it stands on than the roller's own
        line and its radius; a wall without undercut curves less than half away from its roller; and even as uneven a
        load as levers make it is far too small."""
        radius, length = self.radius, self.length
        touching = np.sqrt(np.maximum(radius * radius - (self.aside + self.roller) ** 2, 0.0)) - self.low
        line = UNEVEN * (radius / self.low) ** 2 * self.peak_force / (SPARE * length)
        faint = 8.0 * self.pair * line < NARROW * NARROW * pi * self.roller
        return np.asarray(faint & (touching > SPARE * length) & (self.low > 0.0) & (self.margin > 0.0))

    @property
    def _narrow(self) -> Mask:
        """Whether contacts are so much narrower than the roller at some samples, and so much of it touches, that none
        can be wider."""
        found = np.ones(self.variants.size, dtype=bool)
        rough = self.rough
        vars(rough)["_softer"] = single(self._softer)
        for part, way in product(self.motion.parts, self.ways):
            points = replace(part.of(slice(None, None, APART)).rough, kept=True)
            force = rough.force(points)
            near = rough.ends(points, way, force)
            wide = _only(way, force, near.square) > (0.5 * NARROW * rough.roller * near.curvature / rough.pair) ** 2
            found &= ~wide.any(axis=(0, 1)) & (near.touching > SPARE * rough.length).all(axis=0)
        return found

    @property
    def peak_slice(self) -> Floats:
        """Largest pressure of all slices and the quoted place, MPa."""
        return np.asarray(np.max(self._peaks, axis=0))

    @property
    def half_width(self) -> Floats:
        """Half-width of the hardest slice's contact, mm."""
        return self.hardest.half_width(self.pair)

    def cam_life(self, pressure: Floats) -> Floats:
        """Fatigue life of the cam's wall under a pressure once in a turn, h."""
        limit, cycles, exponent = (
            self.variants.number(f"material.cam.{key}") for key in ("contact_limit", "contact_cycles", "exponent")
        )
        return hours((pressure / limit) ** exponent / cycles, self.speed)


def _only(way: float, force: Floats, values: Floats) -> Floats:
    """Values where a force presses the roller that pushes the follower up, 1, down, -1, or either way, 0; else 0."""
    return values if way == 0.0 else np.where(np.copysign(1.0, force) == way, values, 0.0)
