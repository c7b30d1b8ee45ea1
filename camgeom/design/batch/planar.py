"""Planar cams for many variants at once: discs, constant-width cams and conjugate pairs with all that touches them.

Curvature, pressure angle, lever and force do not hang on how far the cam has turned, so that all of it is computed in
the machine's frame: seen from the turning cam a point c has the velocity c' - i sense c. The formulas are those of the
exact model (`track.outline`, `mechanics.load`, `mechanics.hertz`, `mechanics.life`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from functools import lru_cache, partial
from math import pi
from typing import TYPE_CHECKING, final

import numpy as np

from camgeom.cams import sense_of
from camgeom.cams.conjugate import Conjugate
from camgeom.cams.constant_width import PLATE, ConstantWidth
from camgeom.cams.disc import Disc
from camgeom.design.batch.legs import FINE, force_cuts, motion_reason
from camgeom.design.batch.lives import LEAST_LOAD, Lives
from camgeom.design.batch.motion import NEAR, Ints, Motion, Points, changed, motion_figures, motion_of, of_rows, single
from camgeom.design.batch.seen import Seen
from camgeom.design.batch.touches import Standing, Touch
from camgeom.design.batch.variants import Batch, Mask, Variants
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.applied import Applied, Expression
from camgeom.mechanics.duty import MEAN_OF_NOTHING, MILLI
from camgeom.mechanics.hertz import SHEAR_DEPTH, SHEAR_SHARE
from camgeom.mechanics.load import inertia_force, thrust_share
from camgeom.model import ALIKE
from camgeom.track.follower import FrameFollower

if TYPE_CHECKING:
    from camgeom.profile import Profile

CHUNK = 8192


def supports(profile: Profile, varied: Sequence[str]) -> str | None:
    """None where these keys of this profile are carried, else why not."""
    roller, operation = profile.roller, profile.operation
    if roller is not None and roller.shape != "cylinder":
        return f"a roller of shape = {roller.shape!r} is left to the exact model"
    if operation is not None and operation.force:
        if stray := [key for key in varied if key.startswith("operation.force") or key.endswith(".until")]:
            return f"{stray[0]}: the ends of [[operation.force]] would move through the motion"
        if profile.kind == "constant-width":
            return "[[operation.force]] on a cam of constant width is left to the exact model"
    follower = profile.follower
    plate = isinstance(follower, FrameFollower) and follower.plate_length is not None
    if plate or any(key in (f"follower.{name}" for name in PLATE) for key in varied):
        return "a frame that is made as a part is left to the exact model"
    return motion_reason(profile, varied)


BLANK = ("blank.diameter_mm", "blank.length_mm", "blank.volume_mm3")


def offered(profile: Profile) -> tuple[str, ...]:
    """Names of the figures that are given for this profile."""
    unit = "deg" if profile.rotating else "mm"
    names = [f"motion.stroke_{unit}"]
    names += motion_figures(unit, "rad")
    face = profile.follower.face if profile.roller is None else "roller"
    form = profile.cam.form if isinstance(profile.cam, Disc) else None
    flank = ["max_pressure_angle_deg", "min_convex_radius_mm", "min_hollow_radius_mm", "top_dwell_share"]
    if face in ("roller", "curved"):
        flank += ["min_relative_radius_mm", "undercut_margin"]
    if face == "flat":
        flank += ["min_face_radius_mm", "face_width_needed_mm"]
    if face != "roller":
        flank += ["max_sliding_mm_per_rad"]
    names += [*BLANK, *(f"flank.{name}" for name in flank)]
    if profile.operation is None:
        return tuple(names)
    names += motion_figures(unit, "s")
    contact, fatigue = ["peak_force_n", "peak_torque_n_m", "mean_torque_n_m"], list[str]()
    if face != "knife":
        contact += ["peak_pressure_mpa", "half_width_mm", "peak_shear_mpa", "shear_depth_mm", "deepest_shear_mm"]
        fatigue += ["cam_life_h"]
    if face == "roller":
        contact += ["peak_slice_pressure_mpa", "contact_length_mm", "least_contact_length_mm"]
        fatigue += ["cam_slice_life_h"]
        # In a groove the roller turns round with the wall it presses: its path has jumps that the samples do not meet.
        one_wall = form != "groove"
        fatigue += ["roller_life_h", "roller_slice_life_h", "path_per_turn_m"] if one_wall else []
        if one_wall and profile.roller is not None and profile.roller.dynamic_rating is not None:
            fatigue += ["bearing_life_h", "bearing_mean_load_n"]
            fatigue += ["bearing_static_safety"] if profile.roller.static_rating is not None else []
    if form == "external":
        contact += ["least_force_n", "preload_needed"]
        if not any(isinstance(one, Expression) and one.variables & {"v", "a"} for one in _values(profile)):
            contact += ["leaving_speed_rpm"]
    return (*names, *(f"contact.{name}" for name in contact), *(f"fatigue.{name}" for name in fatigue))


def _values(profile: Profile) -> list[object]:
    """What the applied forces are made of."""
    return [one.applied().value for one in profile.operation.force] if profile.operation is not None else []


def kernel(profile: Profile, columns: Mapping[str, Floats], figures: Sequence[str], level: float) -> Batch:
    """The figures of one chunk of variants; all of them are smooth, so that none hangs on the level."""
    cams = Cams(Variants(profile, columns))
    kept = cams.variants.refusals.none
    if not kept.all():
        # What a profile refuses has no geometry to compute with.
        sound = {key: values[kept] for key, values in columns.items()}
        return cams.variants.refusals.scattered(kernel(profile, sound, figures, level) if kept.any() else None, figures)
    cams.refuse_folded()
    found = {name: cams.variants.full(cams.figure(name)) for name in figures}
    return cams.variants.refusals.batch(found)


Quantity = Callable[[Seen], Floats]
"""of one touch"""
NUMBERS = (
    "offset", "length", "radius", "touches", "guide", "omega", "mass", "friction", "preload", "rate", "weight",
    "compliance",
)
"""what of cams is numbers of variants"""


@final
class Cams:
    """A chunk of variants and its facts, each computed when asked."""

    def __init__(self, variants: Variants) -> None:
        self.variants = v = variants
        profile, cam = v.profile, v.profile.cam
        assert isinstance(cam, Disc | ConstantWidth | Conjugate)
        self.sense = sense_of(cam.direction)
        operation = profile.operation
        self.applied: tuple[Applied, ...] = tuple(f.applied() for f in operation.force) if operation else ()
        self.motion: Motion = motion_of(v, force_cuts(profile), bool(self.applied))
        standing = Standing(v, self.motion)
        self.offset, self.face, self.length = standing.offset, standing.face, standing.length
        self.radius, self.touches = standing.radius, standing.touches
        self.all = tuple(self.seen(touch, self.motion.samples) for touch in self.touches)
        self.guide: Floats | None = None
        self.omega = np.zeros(1)
        if operation is not None:
            self._load()

    def seen(self, touch: Touch, points: Points) -> Seen:
        """One touch at samples of the motion."""
        return Seen(self, touch, points)

    def _load(self) -> None:
        v = self.variants
        turning = v.profile.rotating
        self.omega = v.number("operation.speed") * 2.0 * pi / 60.0
        keys = ("follower.inertia", "operation.load_inertia") if turning else ("follower.mass", "operation.load_mass")
        self.mass = v.number(keys[0]) + v.number(keys[1])
        self.friction, self.preload = v.number("operation.friction"), v.number("operation.spring_preload")
        self.rate = v.number("operation.spring_rate") * (180.0 / pi if turning else 1.0)
        self.weight = np.zeros(1) if turning else self.mass * v.number("operation.gravity")
        guide = v.number("operation.guide_friction")
        self.guide = guide if guide.any() else None
        self.compliance = np.asarray(
            sum((1.0 - v.number(f"material.{body}.poisson") ** 2) / v.number(f"material.{body}.elastic_modulus")
                for body in ("cam", "roller"))
        )  # fmt: skip

    def force(self, p: Points) -> Floats:
        """What the follower needs along its motion, N (N mm), positive towards larger lift."""
        steady = self.preload + self.weight
        force = inertia_force(self.mass, self.omega, p.dds, self.variants.profile.rotating) + (self.rate * p.s + steady)
        if self.friction.any():
            force = force + self.friction * p.side
        for one in self.applied:
            force = force + self._applied(one, p)
        return force

    def _applied(self, one: Applied, p: Points) -> Floats:
        if isinstance(one.value, Expression) and one.value.variables & {"s", "v", "a"}:
            force = one(p.theta, p.s, self.omega * p.ds, self.omega**2 * p.dds)
        else:
            force = one(p.theta)
        return force.astype(p.s.dtype, copy=False)

    def refuse_folded(self) -> None:
        """The reasons for which no body exists."""
        add = self.variants.refusals.add
        add(_jumps(self.variants.profile), "continuity")
        if self.face == "flat":
            add(self.face_radius <= 0.0, "face-curvature")
        elif self.face != "knife":
            add(self.margin <= 0.0, "undercut")
        if self.guide is not None:
            for seen in self.all:
                cosine = np.minimum(np.abs(seen.lever), 1.0)
                share = thrust_share(seen.force, cosine, self.guide, seen.points.side)
                add(share.min(axis=0) <= 0.0, "the follower jams in its guides")

    def figure(self, name: str) -> Floats:
        """A figure by its name in a study, (n,) or (1,)."""
        if name.startswith("motion."):
            unit = 180.0 / pi if self.variants.profile.rotating else 1.0
            return self.motion.figure(name, unit, self.omega)
        return FIGURES[name](self)

    def largest(self, what: Quantity, seen: Seen, pressed: bool = False) -> Floats:
        """The largest of a quantity of one touch, refined, (n,).

        pressed  whether it rests on the force at the contact, which has bends where a thrust in the guides turns
        """
        number = self.all.index(seen)

        def again(cams: Cams, points: Points) -> Floats:
            return what(cams.seen(cams.touches[number], points))

        return self.most_of(again, what(self.rough.all[number]), pressed and self.rubbed)

    def most_of(self, what: Callable[[Cams, Points], Floats], values: Floats, bent: bool) -> Floats:
        """The largest of a quantity of cams at points, (n,), by its values at the samples."""
        return self.motion.largest(partial(what, self), values, bent, lambda rows: partial(what, self.of(rows)))

    @cached_property
    def rough(self) -> Cams:
        """The same in single precision."""
        found = self._changed(single, self.variants.rough, self.motion)
        found.all = tuple(found.seen(touch, self.motion.samples.rough) for touch in found.touches)
        return found

    def of(self, rows: Ints) -> Cams:
        """The same of these variants, each as often as it is named."""
        return self._changed(of_rows(rows), self.variants.of(rows), self.motion.of(rows))

    def _changed(self, change: Callable[[Floats], Floats], variants: Variants, motion: Motion) -> Cams:
        found = copy(self)
        vars(found).update({name: changed(vars(self)[name], change) for name in NUMBERS if name in vars(self)})
        found.variants, found.motion, found.all = variants, motion, ()
        return found

    def smallest(self, what: Quantity, seen: Seen, pressed: bool = False) -> Floats:
        """The smallest."""
        return -self.largest(lambda s: -what(s), seen, pressed)

    def most(self, what: Quantity, pressed: bool = False) -> Floats:
        """The largest over all touches, (n,)."""
        return np.asarray(np.max([self.largest(what, seen, pressed) for seen in self.all], axis=0))

    @property
    def rubbed(self) -> bool:
        """Whether the follower's guides have friction."""
        return self.guide is not None

    @cached_property
    def highs(self) -> tuple[Floats, ...]:
        """Largest curvature of the pitch curve of every touch, 1/mm, where its material is convex positive."""
        if self.mirrored:
            return self.largest(lambda s: s.bend, self.all[0]), -self.smallest(lambda s: s.bend, self.all[0])
        return tuple(self.largest(lambda s: s.bend, seen) for seen in self.all)

    @cached_property
    def lows(self) -> tuple[Floats, ...]:
        """The least."""
        if self.mirrored:
            return -self.highs[1], -self.highs[0]
        return tuple(self.smallest(lambda s: s.bend, seen) for seen in self.all)

    @property
    def mirrored(self) -> bool:
        """Whether two touches are the two flanks of one groove."""
        return any(touch.material < 0.0 for touch in self.touches)

    @cached_property
    def margin(self) -> Floats:
        """Undercut margin of the tool, in a groove larger than the roller by the clearance: its generatrix is straight,
        so that it is 1 where the pitch curve is hollow."""
        least = np.min([1.0 - (self.radius + self.touches[0].gap) * high for high in self.highs], axis=0)
        return np.asarray(np.minimum(least, 1.0))

    @cached_property
    def relative_radius(self) -> Floats:
        """Of the sharpest contact, mm."""
        least = np.min([1.0 - self.radius * high for high in self.highs], axis=0)
        return np.asarray(self.radius * np.maximum(least, 0.0))

    @cached_property
    def face_radius(self) -> Floats:
        """Least radius of curvature of a profile for flat faces, mm."""
        return self.smallest(lambda s: s.face_radius, self.all[0])

    @cached_property
    def convex(self) -> Floats:
        """Smallest convex radius of a profile, mm; infinite where there is none."""
        if self.face == "flat":
            return self.face_radius
        found = [_or_none(high, high > 0.0) - self.radius - touch.gap
                 for touch, high in zip(self.touches, self.highs)]  # fmt: skip
        return np.asarray(np.min(np.broadcast_arrays(*found), axis=0))

    @cached_property
    def hollow(self) -> Floats:
        """Smallest hollow radius of a profile, mm; infinite where there is none."""
        if self.face == "flat":
            return np.full(1, np.inf)
        found = [_or_none(-low, low < 0.0) + self.radius + touch.gap
                 for touch, low in zip(self.touches, self.lows)]  # fmt: skip
        return np.asarray(np.min(np.broadcast_arrays(*found), axis=0))

    @cached_property
    def blank(self) -> tuple[Floats, Floats]:
        """Diameter and length of the cylinder that just holds the finished cam, mm."""
        v = self.variants
        length = v.number("cam.width")
        if v.profile.kind == "conjugate":
            length = 2.0 * length + v.number("cam.gap")
        if v.profile.kind == "disc" and v.optional("cam.diameter") is not None:
            return v.number("cam.diameter"), length
        return 2.0 * np.sqrt(self.most(lambda s: s.reach)), length

    @cached_property
    def peaks(self) -> tuple[Floats, ...]:
        """Of every touch the squared largest pressure, MPa²."""
        return tuple(self.largest(lambda s: s.square, seen, pressed=True) for seen in self.all)

    def _radius_of_peak(self, whole: Seen) -> Floats:
        """Relative radius where the pressure is largest, mm: of peaks which may be as good as alike that of the
        largest."""
        square = partial(self._square, whole.touch)
        piece, step, _ = self.motion.sought(square, whole.square, self.rubbed)
        value, place = np.array([self.motion.top(square, *one) for one in zip(piece, step)]).swapaxes(0, 1)
        best = value.argmax(axis=0)[None]
        piece, place = (np.take_along_axis(one, best, axis=0)[0] for one in (piece, place))
        # The radius changes beside the peak as the pressure does not: its place has to be known better.
        step = np.clip(np.rint(place).astype(np.intp), NEAR, FINE - NEAR)
        place = self.motion.top(square, piece, step, reach=NEAR)[1]
        return np.asarray(self.seen(whole.touch, self.motion.at(piece, place[None])).relative_radius[0])

    def _square(self, touch: Touch, points: Points) -> Floats:
        return self.seen(touch, points).square

    @cached_property
    def hardest(self) -> Ints:
        """Number of the touch with the largest pressure, (n,); of two alike the first."""
        squares = np.array(np.broadcast_arrays(*self.peaks))
        return np.asarray(np.argmax(squares >= (1.0 - 2.0 * ALIKE) * squares.max(axis=0), axis=0))

    def hard(self, values: Sequence[Floats]) -> Floats:
        """Of a figure of every touch that of the hardest pressed one."""
        return np.asarray(np.choose(self.hardest, [self.variants.full(one) for one in values]))

    def of_duty(self, what: Quantity) -> Floats:
        """The largest of a quantity over what one duty sees: both flanks of a groove, both faces; else one roller."""
        each = [self.largest(what, seen, pressed=True) for seen in self.all]
        return self.hard(each) if self.alone else np.asarray(np.max(each, axis=0))

    @property
    def alone(self) -> bool:
        """Whether each of two rollers has its duty for itself."""
        return self.face == "roller" and not self.mirrored

    @cached_property
    def pressure(self) -> Floats:
        """Largest pressure, MPa."""
        return np.sqrt(np.maximum(self.hard(self.peaks), 0.0))

    @cached_property
    def half_width(self) -> Floats:
        """Of the hardest contact, mm."""
        radius = self.hard([self._radius_of_peak(seen) for seen in self.all])
        return np.asarray(2.0 * self.pressure * self.compliance * radius)

    @cached_property
    def deepest_shear(self) -> Floats:
        """Where the largest shear lies deepest, mm."""
        spread = np.maximum(self.of_duty(lambda s: s.spread), 0.0)
        return np.asarray(2.0 * SHEAR_DEPTH * self.compliance * np.sqrt(spread))

    def torque(self, p: Points) -> Floats:
        """Of the camshaft, N mm: what all touches give."""
        given = [touch.way * self.seen(touch, p).pushed for touch in self.touches]
        return np.asarray(sum(given) * p.ds)

    @cached_property
    def mean_torque(self) -> Floats:
        """N mm: the work of a turn, of which inertia, springs and weight have got all back unless contact was lost."""
        p = self.motion.samples
        given = sum(touch.way * seen.pushed for touch, seen in zip(self.touches, self.all))
        force = self.all[0].force
        work = self.variants.full(self.motion.integral(self._lossy(p, np.asarray(given))))
        if self.guide is not None:
            work = self.motion.fine_integral(self._lossy)
        kept = self.variants.full(force.min(axis=0)) >= 0.0
        if len(self.touches) == 1 and not kept.all():
            work = np.where(kept, work, self.motion.fine_integral(self.torque))
        mean = work / (2.0 * pi)
        return np.where(np.abs(mean) < MEAN_OF_NOTHING * np.abs(self.peak_torque), 0.0, mean)

    def _lossy(self, p: Points, given: Floats | None = None) -> Floats:
        """Torque, N mm, that no spring, weight or inertia gives back."""
        if given is None:
            given = np.asarray(sum(touch.way * self.seen(touch, p).pushed for touch in self.touches))
        force = given - self.force(p) + self.friction * p.side
        for one in self.applied:
            force = force + self._applied(one, p)
        return np.asarray(force * p.ds)

    @cached_property
    def peak_torque(self) -> Floats:
        """Largest size of the torque, N mm."""
        rough = self.rough
        given = sum(touch.way * seen.pushed for touch, seen in zip(rough.touches, rough.all))
        values = np.abs(given * self.motion.samples.rough.ds)
        return self.most_of(lambda cams, p: np.abs(cams.torque(p)), values, self.rubbed)

    def hard_samples(self, what: Quantity, every: Sequence[Seen] | None = None) -> Floats:
        """Samples (P, n) of a quantity of the hardest pressed of two rollers; of a groove's roller that of all."""
        every = self.all if every is None else every
        shape = (every[0].points.s.shape[0], self.variants.size)
        each = [np.broadcast_to(what(seen), shape) for seen in every]
        if not self.alone:
            return np.asarray(np.max(each, axis=0))
        return np.asarray(np.choose(self.hardest[None], each))

    @cached_property
    def lives(self) -> Lives:
        """Of cam, rollers and bearings."""
        return Lives(self)

    @cached_property
    def leaving_speed(self) -> Floats:
        """Cam speed, r/min, from which the follower leaves a cam that only pushes; infinite where it never does."""
        rotating = self.variants.profile.rotating

        def static(p: Points) -> tuple[Floats, Floats]:
            inertia = inertia_force(self.mass, self.omega, p.dds, rotating)
            return self.force(p) - inertia, inertia

        def share(p: Points) -> Floats:
            rest, inertia = static(p)
            return np.asarray(-inertia / np.where(rest > 0.0, rest, 1.0))

        holds = self.variants.full(static(self.motion.samples)[0].min(axis=0)) > 0.0
        most = self.motion.largest(share)
        speed = self.omega * 30.0 / pi / np.sqrt(np.where(most > 0.0, most, 1.0))
        return np.where(holds, np.where(most > 0.0, speed, np.inf), 0.0)



@lru_cache(maxsize=8)
def _jumps(profile: Profile) -> bool:
    """Whether the motion's velocity jumps, which no number of a segment changes."""
    return bool(profile.setup().program.continuity.order < 1)


def _or_none(curvature: Floats, there: Mask) -> Floats:
    """One over a curvature where it is there, infinite elsewhere."""
    return np.where(there, 1.0 / np.where(there, curvature, 1.0), np.inf)


FIGURES: dict[str, Callable[[Cams], Floats]] = {
    "flank.max_pressure_angle_deg": lambda c: 2.0 * np.degrees(np.arctan(c.most(lambda s: s.half_tangent))),
    "flank.min_relative_radius_mm": lambda c: c.relative_radius,
    "flank.undercut_margin": lambda c: c.margin,
    "flank.min_convex_radius_mm": lambda c: c.convex,
    "flank.min_hollow_radius_mm": lambda c: c.hollow,
    "flank.top_dwell_share": lambda c: c.motion.top_share,
    "flank.min_face_radius_mm": lambda c: c.face_radius,
    "flank.face_width_needed_mm": lambda c: c.most(lambda s: s.along_size),
    "flank.max_sliding_mm_per_rad": lambda c: c.most(lambda s: s.sliding),
    "blank.diameter_mm": lambda c: c.blank[0],
    "blank.length_mm": lambda c: c.blank[1],
    "blank.volume_mm3": lambda c: 0.25 * pi * c.blank[0] ** 2 * c.blank[1],
    "contact.peak_force_n": lambda c: c.most(lambda s: s.pressing, pressed=True),
    "contact.peak_torque_n_m": lambda c: c.peak_torque * MILLI,
    "contact.mean_torque_n_m": lambda c: c.mean_torque * MILLI,
    "contact.peak_pressure_mpa": lambda c: c.pressure,
    "contact.half_width_mm": lambda c: c.half_width,
    "contact.peak_shear_mpa": lambda c: c.pressure * SHEAR_SHARE,
    "contact.shear_depth_mm": lambda c: c.half_width * SHEAR_DEPTH,
    "contact.deepest_shear_mm": lambda c: c.deepest_shear,
    "contact.peak_slice_pressure_mpa": lambda c: c.pressure,
    "contact.contact_length_mm": lambda c: c.length,
    "contact.least_contact_length_mm": lambda c: c.length,
    "contact.least_force_n": lambda c: c.smallest(lambda s: s.needed, c.all[0], pressed=True),
    "contact.preload_needed": lambda c: np.maximum(c.preload - c.smallest(lambda s: s.force, c.all[0]), 0.0),
    "contact.leaving_speed_rpm": lambda c: c.leaving_speed,
    "fatigue.roller_life_h": lambda c: c.lives.roller,
    "fatigue.roller_slice_life_h": lambda c: c.lives.roller,
    "fatigue.bearing_life_h": lambda c: c.lives.bearing,
    "fatigue.bearing_mean_load_n": lambda c: c.lives.bearing_load,
    "fatigue.bearing_static_safety": lambda c: c.variants.number("roller.static_rating")
    / np.maximum(c.of_duty(lambda s: s.pressing), LEAST_LOAD),
    "fatigue.cam_life_h": lambda c: c.lives.cam,
    "fatigue.cam_slice_life_h": lambda c: c.lives.cam,
    "fatigue.path_per_turn_m": lambda c: c.motion.integral(c.lives.rolled) * MILLI,
}
