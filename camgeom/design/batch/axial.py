"""Drums with cylindrical rollers that a slide or an arm carries along them: what many variants share, load and contact.

A wall is known by two numbers at every place along the roller, its lever and its relative curvature, which the kinds of
follower give in closed form. Arrays are (P, n), P samples of the cam angle and n variants; a leading axis of slices
where there is one.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import partial
from itertools import combinations
from math import pi
from typing import Self, final

import numpy as np
from numpy.typing import NDArray

from camgeom.cams.cylindrical import Cylindrical
from camgeom.design.batch.legs import FINE
from camgeom.design.batch.motion import ROUNDS, Ints, Motion, Points, nearer, vertex
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

TURNS = 4
"""times that flexibilities and slice loads are computed in turn: each leaves about a tenth of the error before"""
SPARE = 0.2
"""share of a roller that touches at all samples from which on some of it does between them too"""
NONE = 1e-9
"""share of a roller that counts as nothing"""
BESIDE = np.arange(-128, 129, 2)[:, None]
"""fine steps beside the place where least of a roller touches, over which it is asked whether any does"""
ASIDE = FINE // 16
"""fine steps on either side of the place that is hardest if all slices are alike flexible, over which the hardest is
sought first"""
SHARED = 0.05
"""share of itself by which the square of a pressure may be off if all slices are alike flexible"""
TRIALS = ROUNDS + 2
MOST = 6
"""places in which the hardest contact is looked for, at most"""
CANNOT = "cannot be built"


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

    quoted, slice  largest pressure at the quoted radius and of all slices, MPa
    curvature, touching  relative curvature, 1/mm, and the length that touches, mm, at the hardest slice
    """

    quoted: Floats
    slice: Floats
    curvature: Floats
    touching: Floats

    @property
    def figures(self) -> tuple[Floats, ...]:
        """All of it in turn."""
        return self.quoted, self.slice, self.curvature, self.touching

    @property
    def peak(self) -> Floats:
        """The larger of both pressures, MPa."""
        return np.maximum(self.slice, self.quoted)

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
        # Without a wall at the pitch radius the contact is quoted in the middle of what has one.
        self.quoted = np.where((self.low <= self.pitch) & (self.pitch <= self.radius), self.pitch, self.middle)

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

    def over(self, what: Callable[[Floats, Points], Floats], places: Floats, values: Floats) -> Floats:
        """Largest of a quantity over the turn and over places along the roller (k, n), (n,); values: at the samples."""
        found = []
        piece, step, _ = self.motion.tops(values)
        for top in zip(piece, step):
            near = self.motion.around(*top)
            height = np.stack([what(place, near)[1] for place in places])
            best = np.broadcast_to(places, height.shape)[height.argmax(axis=0), np.arange(self.motion.size)]
            found.append(self.motion.laid(partial(what, best), *top)[1])
        return np.asarray(np.max(found, axis=0))

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
        return self.demand.force(points.theta, (points.s, points.ds, points.dds), points.side)[0]

    @cached_property
    def sampled_force(self) -> Floats:
        """At the samples of the motion."""
        return self.force(self.motion.samples)

    @cached_property
    def peak_force(self) -> Floats:
        """Largest normal force at the quoted radius, N."""
        forces = []
        for way in self.ways:

            def normal(points: Points, force: Floats | None = None, way: float = way) -> Floats:
                force = self.force(points) if force is None else force
                return _only(way, force, np.abs(self.normal(points, way, force, self.quoted)))

            forces.append(self.motion.largest(normal, normal(self.motion.samples, self.sampled_force), self.guided))
        return np.asarray(np.max(forces, axis=0))

    @cached_property
    def peak_torque(self) -> Floats:
        """Largest torque of the camshaft, N m."""

        def torque(points: Points, force: Floats | None = None) -> Floats:
            force = self.force(points) if force is None else force
            return np.abs(self.pushed(points, force) * points.ds)

        return MILLI * self.motion.largest(torque, torque(self.motion.samples, self.sampled_force), self.guided)

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
        normal = self.normal(points, way, force, self.quoted)
        k = self.wall(points, way, np.copysign(1.0, normal), self.quoted)[1]
        k *= np.abs(normal)
        return np.asarray(k / (self.length * pi * self.pair))

    @property
    def pressure(self) -> Floats:
        """Largest pressure at the quoted radius, MPa, of the hardest pressed roller."""
        return self.hardest.quoted

    def slices(self, points: Points, way: float, force: Floats, which: Sequence[int] | None = None) -> Slices:
        """The contact of slices that approach alike (default all of them); with `which`, as if alike flexible."""
        force = self.pushed(points, force)
        up = np.copysign(1.0, force)
        # Where no force presses there may be no wall: what is left of it is not zero.
        touching = np.clip(self.reach(points, way, up), NONE * self.length, self.length)
        share = (np.arange(SLICES) if which is None else np.array(which)) + 0.5
        lever, k = self.wall(points, way, up, self.low + touching * (share[:, None, None] / SLICES))
        k = np.where(k > 0.0, k, 1.0 / self.roller)
        size, width = np.abs(force), touching / SLICES
        if which is not None:
            # The lever's square along the line by Simpson's rule.
            one, two, three = (self.lever2(points, way, self.low + x * touching) for x in (0.0, 0.5, 1.0))
            line = size * lever / (touching * (one + 4.0 * two + three) / 6.0)
        else:
            line = np.broadcast_to(size / (width * lever.sum(axis=0)), lever.shape)
            least = np.maximum(1e-6 * line, 1e-30)
            for _ in range(TURNS):
                line = self._shared(line, least, k, lever, size, width)
        return Slices(line * k / (pi * self.pair), k, touching)

    def _shared(self, line: Floats, least: Floats, k: Floats, lever: Floats, size: Floats, width: Floats) -> Floats:
        """Load per length of slices (m, P, n) whose flexibility is that under a load per length; see `share_load`."""
        half = 2.0 * np.sqrt(np.maximum(line, least) * self.pair / (pi * k))
        far = np.log(4.0 * self.roller / half)
        soft = flexibility(far, far, self.compliance("roller"), self.compliance("cam"),
                           self.variants.number("material.cam.poisson"))  # fmt: skip
        stiff = lever / soft
        return np.asarray(stiff * (size / (width * (stiff * lever).sum(axis=0))))

    @cached_property
    def hardest(self) -> Hard:
        """The hardest contact: of a rib's rollers, one pressed upwards and one downwards, that of the harder."""
        if not self.rib:
            return self._hards[0]
        lower, upper = self._hards
        mine = lower.peak >= (1.0 - ALIKE) * np.maximum(lower.peak, upper.peak)
        return Hard(*(np.where(mine, one, other) for one, other in zip(lower.figures, upper.figures)))

    @cached_property
    def _hards(self) -> tuple[Hard, ...]:
        """Of every roller."""
        return tuple(self._hard(way) for way in self.ways)

    @property
    def wearing(self) -> Floats:
        """Largest pressure at the quoted radius, MPa, of any roller: what the cam's life is quoted with."""
        return np.asarray(np.max([one.quoted for one in self._hards], axis=0))

    def _hard(self, way: float) -> Hard:
        """The hardest contact of the roller that pushes the follower up, 1, down, -1, or either way, 0."""
        on, force = self.motion, self.sampled_force

        def square(points: Points) -> Floats:
            force = self.force(points)
            return _only(way, force, self.square(points, way, force))

        quoted = on.largest(square, _only(way, force, self.square(on.samples, way, force)), self.guided)
        few = self.slices(on.samples, way, force, self.tried)
        lost = self._lost(way, few.touching)
        # How the load is shared moves the hardest place along its piece, and either end may be the harder one.
        piece, step, tried = on.tops(_only(way, force, few.square), MOST, SHARED)
        value, k, touching = self._sought(way, piece, step, tried)
        slices = np.where(lost, np.inf, np.sqrt(np.maximum(value, 0.0)))
        k, touching = np.where(lost, 1.0 / self.roller, k), np.where(lost, 0.0, touching)
        return Hard(np.sqrt(np.maximum(quoted, 0.0)), slices, k, touching)

    def _sought(self, way: float, piece: Ints, step: Ints, tried: Mask) -> tuple[Floats, Floats, Floats]:
        """Square of the largest pressure about places (k, n) that are tried, MPa², relative curvature, 1/mm, and the
        length that touches there, mm, (n,) each."""
        for i, j in combinations(range(len(tried)), 2):
            # Both ends of a roller are as hard at about the same place.
            tried[j] &= ~(tried[i] & (piece[i] == piece[j]) & (np.abs(step[i] - step[j]) <= ASIDE))
        _, variant = np.nonzero(tried)
        found = np.full((3, len(variant)), -np.inf)
        rows, part, reach = np.arange(len(variant)), self.of(variant), np.full(len(variant), ASIDE)
        piece, step = piece[tried], np.clip(step[tried], ASIDE, FINE - ASIDE)
        for _ in range(TRIALS):
            points = part.motion.at(piece, step + reach * np.array([[-1], [0], [1]]))
            force = part.force(points)
            near = part.slices(points, way, force)
            values = _only(way, force, near.square.max(axis=0))
            at, value = vertex(*values)
            which = near.square[:, 1].argmax(axis=0), slice(None), np.arange(len(rows))
            found[:, rows] = value, *(one[1] + 0.5 * at * (one[2] - one[0])
                                      for one in (near.curvature[which].T, near.touching))  # fmt: skip
            more, moved, closer = nearer(values, at, step, reach)
            # Twice what a parabola can stand above its samples: others that cannot be harder stay as they are.
            doubt, sure = 0.25 * np.abs(values[0] - 2.0 * values[1] + values[2]), np.full(self.motion.size, -np.inf)
            np.maximum.at(sure, variant, value - doubt)
            left = np.flatnonzero(more & ((value + doubt >= sure[variant]) | (np.abs(at) >= 1.0)))
            if not left.size:
                break
            rows, variant, piece, step, reach, part = (
                rows[left], variant[left], piece[left], moved[left], closer[left], part.of(left)
            )
        every = np.full((3, *tried.shape), -np.inf)
        every[:, tried] = found
        value, k, touching = every[:, every[0].argmax(axis=0), np.arange(self.motion.size)]
        return value, k, touching

    def _lost(self, way: float, touching: Floats) -> NDArray[np.bool_]:
        """Whether the roller is pressed where it has no wall at all, so that its pressure has no bound.

        touching  length that touches at the samples, mm
        """

        def least(points: Points, force: Floats | None = None) -> Floats:
            force = self.force(points) if force is None else force
            spare = -self.reach(points, way, np.copysign(1.0, force))
            return np.where((force != 0.0) & ((way == 0.0) | (np.copysign(1.0, force) == way)), spare, -self.length)

        on = self.motion
        if np.all(touching > SPARE * self.length):
            return np.zeros(self.variants.size, dtype=bool)
        # Where the force changes walls the reach jumps, so that no parabola finds the least of it.
        piece, step = (each[0] for each in on.tops(least(on.samples, self.sampled_force))[:2])
        return np.asarray((least(on.at(piece, np.clip(step + BESIDE, 0, FINE))) > 0.0).any(axis=0))

    @property
    def tried(self) -> tuple[int, ...]:
        """Slices of which one is the hardest: where it presses most is sought with these."""
        return 0, SLICES - 1

    @property
    def too_wide(self) -> NDArray[np.bool_]:
        """Whether a contact is wider than its roller: of what touches hardly anywhere."""
        wide = [(one.half_width(self.pair) > self.roller) & np.isfinite(one.slice) for one in self._hards]
        return np.asarray(np.any(wide, axis=0))

    @property
    def peak_slice(self) -> Floats:
        """Largest pressure of all slices and the quoted place, MPa."""
        return self.hardest.peak

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
