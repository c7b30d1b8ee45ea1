"""Planar cams for many variants at once: discs, constant-width cams and conjugate pairs with all that touches them.

Curvature, pressure angle, lever and force do not hang on how far the cam has turned, so that all of it is computed in
the machine's frame: seen from the turning cam a point c has the velocity c' - i sense c. The formulas are those of the
exact model (`track.outline`, `mechanics.load`, `mechanics.hertz`, `mechanics.life`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from math import pi
from typing import TYPE_CHECKING, final
from weakref import proxy

import numpy as np

from camgeom.cams import sense_of
from camgeom.cams.conjugate import Conjugate
from camgeom.cams.constant_width import ConstantWidth
from camgeom.cams.disc import Disc
from camgeom.design.batch import Batch
from camgeom.design.batch.common import Ints, Mask, Motion, Points, Variants, motion_of, motion_reason
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.applied import Applied, Expression
from camgeom.mechanics.bearing import ROLLER_EXPONENT, rated_hours
from camgeom.mechanics.duty import MEAN_OF_NOTHING, MILLI
from camgeom.mechanics.hertz import SHEAR_DEPTH, SHEAR_SHARE
from camgeom.mechanics.life import hours
from camgeom.mechanics.load import inertia_force, thrust_share
from camgeom.model import ALIKE
from camgeom.track.outline import Pair, face_contact, outward_normal, pitch_curvature, swung_face

if TYPE_CHECKING:
    from camgeom.profile import Profile

CHUNK = 1024
LEAST_LOAD = 1e-200
"""N; a load below it is none"""


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
    return motion_reason(profile, varied)


BLANK = ("blank.diameter_mm", "blank.length_mm", "blank.volume_mm3")
ORDERS = ("velocity", "acceleration", "jerk")


def offered(profile: Profile) -> tuple[str, ...]:
    """Names of the figures that are given for this profile."""
    unit = "deg" if profile.rotating else "mm"
    names = [f"motion.stroke_{unit}"]
    names += [f"motion.peak_{word}_{unit}_per_{per}" for word, per in zip(ORDERS, ("rad", "rad2", "rad3"))]
    face, kind = profile.follower.face if profile.roller is None else "roller", profile.kind
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
    names += [f"motion.peak_{word}_{unit}_per_{per}" for word, per in zip(ORDERS, ("s", "s2", "s3"))]
    contact, fatigue = ["peak_force_n", "peak_torque_n_m", "mean_torque_n_m"], list[str]()
    if face != "knife":
        contact += ["peak_pressure_mpa", "half_width_mm", "peak_shear_mpa", "shear_depth_mm", "deepest_shear_mm"]
        fatigue += ["cam_life_h"]
    if face == "roller":
        contact += ["peak_slice_pressure_mpa", "contact_length_mm", "least_contact_length_mm"]
        fatigue += ["cam_slice_life_h"]
        # In a groove the roller turns round with the wall it presses: its path has jumps that the samples do not meet.
        one_wall = getattr(profile.cam, "form", "") != "groove"
        fatigue += ["roller_life_h", "roller_slice_life_h", "path_per_turn_m"] if one_wall else []
        if one_wall and profile.roller is not None and profile.roller.dynamic_rating is not None:
            fatigue += ["bearing_life_h", "bearing_mean_load_n"]
            fatigue += ["bearing_static_safety"] if profile.roller.static_rating is not None else []
    if kind == "disc" and getattr(profile.cam, "form", "") == "external":
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


@final
@dataclass(frozen=True, eq=False)
class Slide:
    """What stands at x + lift on a slide along X, at the height y, mm."""

    x: Floats
    y: Floats

    def jets(self, p: Points) -> tuple[Pair, Pair, Pair]:
        """Place, velocity and acceleration in the machine's frame by the cam angle."""
        zero = np.zeros(1)
        return (self.x + p.s, self.y), (p.ds, zero), (p.dds, zero)

    def moved(self, at: Pair) -> Pair:
        """Velocity of a place by the coordinate."""
        return np.ones(1), np.zeros(1)


@final
@dataclass(frozen=True, eq=False)
class Swing:
    """The end of an arm, mm, pivoted at (centre, 0), that stands at `start` (rad) from the line of centres."""

    centre: Floats
    arm: Floats
    start: Floats
    way: float

    def jets(self, p: Points) -> tuple[Pair, Pair, Pair]:
        """Place, velocity and acceleration in the machine's frame by the cam angle."""
        angle = self.start + p.s
        c, s = self.arm * np.cos(angle), (self.way * self.arm) * np.sin(angle)
        # A quarter turn on, by the way that the lift turns.
        u, v = self.way * s, self.way * c
        square = p.ds * p.ds
        return (
            (self.centre - c, s),
            (p.ds * u, p.ds * v),
            (p.dds * u + square * c, p.dds * v - square * s),
        )

    def moved(self, at: Pair) -> Pair:
        """Velocity of a place by the coordinate."""
        return self.way * at[1], self.way * (self.centre - at[0])


@final
@dataclass(frozen=True, eq=False)
class Touch:
    """One contact: its follower's element on its joint.

    way       +1 where it pushes towards larger lift; material: -1 for the outer flank of a face groove
    radius    of the roller or curved face, mm; 0 of a knife edge, None of a flat face
    gap       running clearance, mm
    shift     added to the lift; turned: half a turn on, where a frame's far face meets the cam
    offset    of a swung flat face: the pivot's distance from it
    """

    joint: Slide | Swing
    way: float
    radius: Floats | None
    kind: str
    gap: Floats
    material: float = 1.0
    shift: Floats | None = None
    turned: bool = False
    offset: Floats | None = None


@final
class Seen:
    """One touch at samples of the motion; each (P, n) or a shape that meets it."""

    def __init__(self, cams: Cams, touch: Touch, points: Points) -> None:
        # A cam has these: what they need of it must not keep it, and all its arrays, alive in turn.
        self.cams: Cams = proxy(cams)
        self.touch, self.points = touch, points
        p = points
        if touch.shift is not None:
            p = replace(p, s=p.s + touch.shift)
        if touch.turned:
            low, high = cams.motion.lift_range
            p = replace(p, s=low + high - p.s, ds=-p.ds, dds=-p.dds)
        self.moving = p

    @cached_property
    def jets(self) -> tuple[Pair, Pair, Pair]:
        """The centre of the roller, or the edge, in the machine's frame."""
        return self.touch.joint.jets(self.moving)

    @cached_property
    def d(self) -> Pair:
        """Its velocity seen from the turning cam, mm/rad."""
        (x, y), (u, v), _ = self.jets
        sense = self.cams.sense
        return u + sense * y, v - sense * x

    @cached_property
    def pace(self) -> Floats:
        """The size of that, mm/rad."""
        return np.asarray(np.sqrt(self.d[0] * self.d[0] + self.d[1] * self.d[1]))

    @cached_property
    def rolled(self) -> Floats:
        """Path that a roller's rim turns by about its pin, mm/rad."""
        return np.abs(self.turned)

    @cached_property
    def turned(self) -> Floats:
        """The same with the sign of the way in which it turns: it turns with the arm, and once less (more) a turn round
        a convex (hollow) flank than its middle's path gives."""
        r, joint = self.touch.radius, self.touch.joint
        assert r is not None
        turning = 1.0 if isinstance(joint, Slide) else 1.0 + (self.cams.sense * joint.way) * self.moving.ds
        return np.asarray(self.pace - (self.touch.material * r) * turning)

    @cached_property
    def bend(self) -> Floats:
        """Curvature of the pitch curve, 1/mm, positive where the cam's material is convex."""
        (x, y), (u, v), (du, dv) = self.jets
        sense = self.cams.sense
        dd = du + (2.0 * sense) * v - x, dv - (2.0 * sense) * u - y
        return np.asarray(self.touch.material * pitch_curvature(self.d, dd, self.pace, sense))

    @cached_property
    def face(self) -> tuple[Pair, Floats, Floats, Floats]:
        """Of a flat face: unit normal, support, place of the contact along it and radius of the profile, mm."""
        p, touch, sense = self.moving, self.touch, self.cams.sense
        joint = touch.joint
        if isinstance(joint, Slide):
            support = joint.x + p.s
            return (np.ones(1), np.zeros(1)), support, -sense * p.ds, support + p.dds
        assert touch.offset is not None
        jets = np.stack(np.broadcast_arrays(p.s, p.ds, p.dds))
        beta, h = swung_face(jets, joint.start, joint.centre, touch.offset)
        psi = joint.way * beta
        psi[1] -= sense
        along, radius = face_contact(psi, h)
        return (np.cos(psi[0]), np.sin(psi[0])), h[0], along, radius

    @cached_property
    def face_radius(self) -> Floats:
        """Radius of curvature of the profile under a flat face, mm."""
        return self.face[3]

    @cached_property
    def normal(self) -> Pair:
        """Outward normal of the profile, in the machine's frame."""
        if self.touch.radius is None:
            return self.face[0]
        return outward_normal(self.d, self.pace, self.cams.sense)

    @cached_property
    def place(self) -> Pair:
        """The point of contact, mm."""
        n = self.normal
        if self.touch.radius is None:
            _, h, along, _ = self.face
            return h * n[0] - along * n[1], h * n[1] + along * n[0]
        (x, y), _, _ = self.jets
        back = -self.touch.material * (self.touch.radius + self.touch.gap)
        return x + back * n[0], y + back * n[1]

    @cached_property
    def lever(self) -> Floats:
        """Velocity of the contact along the outward normal by the coordinate: 1 or mm/rad."""
        if self.touch.turned:
            return -np.ones(1)
        if isinstance(self.touch.joint, Slide):
            return self.normal[0]
        at = self.jets[0] if self.touch.radius is not None else self.place
        e, n = self.touch.joint.moved(at), self.normal
        return np.asarray(n[0] * e[0] + n[1] * e[1])

    @cached_property
    def half_tangent(self) -> Floats:
        """Tangent of half the pressure angle, a size: of a roller at its centre, else where it touches."""
        touch, n = self.touch, self.normal
        if touch.radius is None and isinstance(touch.joint, Slide):
            return np.zeros(1)
        if isinstance(touch.joint, Slide):
            return np.asarray(np.abs(n[1]) / (1.0 + (touch.way * touch.material) * n[0]))
        if touch.kind == "roller":
            (x, y), _, _ = self.jets
            gap = -touch.material * touch.gap
            at = (x + gap * n[0], y + gap * n[1]) if np.any(touch.gap) else (x, y)
        else:
            at = self.place
        e = touch.joint.moved(at)
        square = touch.way * touch.material * (e[0] * n[0] + e[1] * n[1])
        return np.asarray(np.abs(e[0] * n[1] - e[1] * n[0]) / (np.sqrt(e[0] * e[0] + e[1] * e[1]) + square))

    @cached_property
    def sliding(self) -> Floats:
        """Of the cam over what does not roll, mm/rad."""
        (x, y), n, sense, ds = self.place, self.normal, self.cams.sense, self.moving.ds
        if self.touch.turned:
            return np.abs(x + 0.0 * ds)
        e = self.touch.joint.moved((x, y))
        return np.asarray(np.abs((ds * e[1] - sense * x) * n[0] - (ds * e[0] + sense * y) * n[1]))

    @cached_property
    def along_size(self) -> Floats:
        """Width that the contact needs of a flat face, or its length from the pivot on, mm."""
        joint = self.touch.joint
        if isinstance(joint, Slide):
            return np.asarray(2.0 * np.abs(self.face[2] - self.touch.way * self.cams.offset))
        (x, y), n = self.place, self.normal
        return np.asarray(np.abs(y * n[0] - (x - joint.centre) * n[1]))

    @cached_property
    def reach(self) -> Floats:
        """Square of the distance of the contact from the cam axis, mm²."""
        x, y = self.place
        return np.asarray(x * x + y * y)

    @cached_property
    def force(self) -> Floats:
        """What the follower needs along its motion, N (N mm)."""
        return self.cams.force(self.points)

    @cached_property
    def pushed(self) -> Floats:
        """The size of what this touch gives of it, with the friction of the guides: it pushes one way."""
        pushed = np.maximum(self.force if self.touch.way > 0.0 else -self.force, 0.0)
        if self.cams.guide is None:
            return pushed
        cosine = np.minimum(np.abs(self.lever), 1.0)
        share = thrust_share(self.touch.way * pushed, cosine, self.cams.guide, self.points.side)
        return np.asarray(cosine * pushed / np.where(share > 0.0, share, 1.0))

    @cached_property
    def pressing(self) -> Floats:
        """Normal force, N."""
        return np.asarray(self.pushed / np.abs(self.lever))

    @cached_property
    def needed(self) -> Floats:
        """Normal force that the follower needs, N: below zero it would have to be pulled."""
        return np.asarray(np.where(self.force > 0.0, self.pressing, self.force / self.lever))

    @cached_property
    def relative_radius(self) -> Floats:
        """One over the relative curvature of cam against follower, mm."""
        r = self.touch.radius
        return self.face_radius if r is None else np.asarray(r - (r * r) * self.bend)

    @cached_property
    def square(self) -> Floats:
        """Squared peak pressure, MPa²."""
        scale = self.cams.length * np.pi * self.cams.compliance
        return np.asarray(self.pressing / (scale * np.maximum(self.relative_radius, 1e-9)))

    @cached_property
    def signed_square(self) -> Floats:
        """The same, negative where this touch would have to pull: without a kink where the load leaves it."""
        cosine = np.minimum(np.abs(self.lever), 1.0)
        share = np.ones(1)
        if self.cams.guide is not None:
            share = thrust_share(self.force, cosine, self.cams.guide, self.points.side) / cosine
        scale = self.touch.way * self.cams.length * np.pi * self.cams.compliance * np.abs(self.lever) * share
        return np.asarray(self.force / (scale * np.maximum(self.relative_radius, 1e-9)))

    @cached_property
    def spread(self) -> Floats:
        """Square of pressure times relative radius, MPa² mm²."""
        return np.asarray(self.square * self.relative_radius * self.relative_radius)


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
        cuts = sorted({angle for one in self.applied for angle in one.breaks})
        self.motion: Motion = motion_of(v, tuple(cuts), bool(self.applied))
        self.offset = v.number("follower.offset")
        self.face = profile.follower.face if profile.roller is None else "roller"
        self.length = self._length(cam)
        self.radius = self._radius()
        self.touches = self._touches(cam)
        self._refuse_bores()
        self.all = tuple(Seen(self, touch, self.motion.samples) for touch in self.touches)
        self.guide: Floats | None = None
        if operation is not None:
            self._load()

    def _radius(self) -> Floats:
        """Of the roller or curved face, mm; 0 of a knife edge or flat face."""
        if self.face == "roller":
            return 0.5 * self.variants.number("roller.diameter")
        return self.variants.number("follower.face_radius") if self.face == "curved" else np.zeros(1)

    def _length(self, cam: Disc | ConstantWidth | Conjugate) -> Floats:
        """Of contact along the axis, mm."""
        v = self.variants
        deep = v.number("cam.groove_depth" if isinstance(cam, Disc) and cam.form == "groove" else "cam.width")
        length = v.optional("roller.length") if v.profile.roller is not None else None
        return deep if length is None else np.minimum(deep, length)

    def _touches(self, cam: Disc | ConstantWidth | Conjugate) -> tuple[Touch, ...]:
        if isinstance(cam, Disc):
            return self._disc(cam)
        return self._width() if isinstance(cam, ConstantWidth) else self._pair()

    def _disc(self, cam: Disc) -> tuple[Touch, ...]:
        v, flat, groove = self.variants, self.face == "flat", cam.form == "groove"
        base = v.number("cam.base_radius")
        prime = base + self.radius
        gap = v.number("cam.running_clearance") if groove else np.zeros(1)
        radius = None if flat else self.radius
        if v.profile.rotating:
            joint = self._arm(base, prime, flat)
            offset = v.number("follower.face_offset") if flat else None
            inner = Touch(joint, 1.0, radius, self.face, gap, offset=offset)
        elif flat:
            inner = Touch(Slide(base, np.zeros(1)), 1.0, None, self.face, gap)
        else:
            v.refusals.add(np.abs(self.offset) >= prime, "follower.offset: cannot be built")
            start = np.sqrt(np.maximum(prime**2 - self.offset**2, 1e-12))
            inner = Touch(Slide(start, self.offset), 1.0, radius, self.face, gap)
        if not groove:
            return (inner,)
        self._refuse_groove(prime, inner.joint, gap)
        return inner, replace(inner, way=-1.0, material=-1.0)

    def _arm(self, base: Floats, prime: Floats, flat: bool) -> Swing:
        """The arm of a disc's follower: of a flat face with its normal's angle in place of the arm's."""
        v = self.variants
        centre, arm = v.number("cam.center_distance"), v.number("follower.arm")
        way = 1.0 if getattr(v.profile.follower, "side", "left") == "left" else -1.0
        if flat:
            reach = base + v.number("follower.face_offset")
            v.refusals.add(np.abs(reach) >= centre, "cam.center_distance: cannot be built")
            return Swing(centre, arm, np.arccos(np.clip(reach / centre, -1.0, 1.0)), way)
        return Swing(centre, arm, self._angle(centre, arm, prime, "cam.center_distance", True), way)

    def _angle(self, centre: Floats, arm: Floats, prime: Floats, key: str, swung: bool) -> Floats:
        """Angle of an arm from the line of centres at zero lift, rad; refused where there is none."""
        refusals = self.variants.refusals
        fits = (np.abs(centre - arm) < prime) & (prime < centre + arm)
        refusals.add(~fits, f"{key}: cannot be built")
        start = np.arccos(np.clip((centre**2 + arm**2 - prime**2) / (2.0 * centre * arm), -1.0, 1.0))
        if swung:
            low, high = self.motion.lift_range
            refusals.add((start + low <= 0.0) | (start + high >= pi), "motion.to: cannot be built")
        return np.asarray(start)

    def _refuse_groove(self, prime: Floats, joint: Slide | Swing, gap: Floats) -> None:
        v, top = self.variants, self.motion.lift_range[1]
        v.refusals.add(v.number("cam.groove_depth") >= v.number("cam.width"), "cam.groove_depth: cannot be built")
        if isinstance(joint, Slide):
            reach = np.hypot(joint.x + top, self.offset)
        else:
            a, arm = joint.centre, joint.arm
            reach = np.sqrt(np.maximum(a**2 + arm**2 - 2.0 * a * arm * np.cos(joint.start + top), 0.0))
        reach = reach + self.radius + gap
        v.refusals.add(0.5 * v.number("cam.diameter") <= reach, "cam.diameter: cannot be built")

    def _width(self) -> tuple[Touch, ...]:
        """The two faces of a frame, or the two rollers of a yoke."""
        v = self.variants
        low, high = self.motion.lift_range
        v.refusals.add(low < -1e-9 * np.maximum(high, 1.0), "motion.to: cannot be built")
        base, zero = v.number("cam.base_radius"), np.zeros(1)
        if self.face == "flat":
            near = Touch(Slide(base, zero), 1.0, None, "flat", zero)
            return near, replace(near, way=-1.0, turned=True)
        first = base + self.radius
        one = Touch(Slide(first, zero), 1.0, self.radius, "roller", zero)
        return one, replace(one, joint=Slide(-first - high, zero), way=-1.0)

    def _pair(self) -> tuple[Touch, ...]:
        """The main and the return roller of a conjugate pair."""
        v, refusals = self.variants, self.variants.refusals
        base, play, zero = v.number("cam.base_radius"), v.number("follower.clearance"), np.zeros(1)
        prime, (low, high) = base + self.radius, self.motion.lift_range
        if not v.profile.rotating:
            refusals.add(np.abs(self.offset) >= prime, "follower.offset: cannot be built")
            start = np.sqrt(np.maximum(prime**2 - self.offset**2, 1e-12))
            least = np.maximum(np.sqrt((high + 1e-3) ** 2 + self.offset**2) - self.radius, 0.0)
            given = v.optional("cam.return_radius")
            back = np.sqrt((start + high) ** 2 + self.offset**2) - self.radius if given is None else given
            refusals.add(back <= least, "cam.return_radius: cannot be built")
            far = np.sqrt(np.maximum((back + self.radius) ** 2 - self.offset**2, 1e-12))
            main = Touch(Slide(start, self.offset), 1.0, self.radius, "roller", zero)
            return main, replace(main, joint=Slide(-far, self.offset), way=-1.0, shift=play)
        centre, arm = v.number("cam.center_distance"), v.number("follower.arm")
        other = v.optional("cam.return_arm")
        other = arm if other is None else other
        between = v.optional("cam.rocker_angle")
        start = self._angle(centre, arm, prime, "cam.center_distance", False)
        if between is None:
            second = self._angle(centre, other, prime, "cam.return_arm", False)
            between = start + high + second
        else:
            between = np.radians(between)
        refusals.add((start + low <= 0.0) | (start + high >= pi), "motion.to: cannot be built")
        play = 2.0 * np.arcsin(np.minimum(1.0, play / (2.0 * other)))
        fits = (start + high + play < between) & (between < pi + start + low)
        refusals.add(~fits, "cam.rocker_angle: cannot be built")
        way = 1.0 if getattr(v.profile.follower, "side", "left") == "left" else -1.0
        main = Touch(Swing(centre, arm, start, way), 1.0, self.radius, "roller", zero)
        return main, replace(main, joint=Swing(centre, other, start - between, way), way=-1.0, shift=play)

    def _refuse_bores(self) -> None:
        """What `bore_problems` says of a bore and its keyway."""
        v = self.variants
        bore, wide, deep, base = (
            v.number(f"cam.{key}") for key in ("bore", "keyway_width", "keyway_depth", "base_radius")
        )
        there = bore > 0.0
        bad = np.where(there, ((wide > 0.0) != (deep > 0.0)) | (wide >= bore), wide > 0.0)
        v.refusals.add(bad, "cam.keyway_width: cannot be built")
        reach = np.where(wide > 0.0, np.hypot(0.5 * bore + deep, 0.5 * wide), 0.5 * bore)
        v.refusals.add(there & (reach >= base), "cam.bore: cannot be built")

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
            return one(p.theta, p.s, self.omega * p.ds, self.omega**2 * p.dds)
        return one(p.theta)

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
            return self._motion(name)
        return FIGURES[name](self)

    def _motion(self, name: str) -> Floats:
        unit = 180.0 / pi if self.variants.profile.rotating else 1.0
        if name.startswith("motion.stroke"):
            return unit * self.motion.stroke
        order = ORDERS.index(name.split("_")[1]) + 1
        peak = unit * self.motion.peaks()[order - 1]
        return peak * self.omega**order if "_per_s" in name else peak

    def largest(self, what: str, seen: Seen) -> Floats:
        """The largest of a quantity of one touch, refined, (n,)."""
        return self.motion.largest(lambda p: getattr(Seen(self, seen.touch, p), what), getattr(seen, what))

    def smallest(self, what: str, seen: Seen) -> Floats:
        """The smallest."""
        return self.motion.smallest(lambda p: getattr(Seen(self, seen.touch, p), what), getattr(seen, what))

    def most(self, what: str) -> Floats:
        """The largest over all touches, (n,)."""
        return np.asarray(np.max([self.largest(what, seen) for seen in self.all], axis=0))

    @cached_property
    def highs(self) -> tuple[Floats, ...]:
        """Largest curvature of the pitch curve of every touch, 1/mm, where its material is convex positive."""
        if self.mirrored:
            return self.largest("bend", self.all[0]), -self.smallest("bend", self.all[0])
        return tuple(self.largest("bend", seen) for seen in self.all)

    @cached_property
    def lows(self) -> tuple[Floats, ...]:
        """The least."""
        if self.mirrored:
            return -self.highs[1], -self.highs[0]
        return tuple(self.smallest("bend", seen) for seen in self.all)

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
        return self.smallest("face_radius", self.all[0])

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
        return 2.0 * np.sqrt(self.most("reach")), length

    @cached_property
    def peaks(self) -> tuple[Floats, ...]:
        """Of every touch the squared largest pressure, MPa²."""
        return tuple(self.motion.largest(partial(self._square, seen.touch), seen.square) for seen in self.all)

    def _radius_of_peak(self, whole: Seen) -> Floats:
        """Relative radius where the pressure is largest, mm: of the two largest peaks, which may be as good as alike,
        that of the larger."""
        first, _ = self.motion.peak(whole.square)
        values, radii = [], []
        for beside in (None, first):
            near, value, at = self.motion.top(partial(self._square, whole.touch), whole.square, beside)
            radius = Seen(self, whole.touch, near).relative_radius
            low, mid, high = np.broadcast_to(radius, (3, self.variants.size))
            values.append(value)
            radii.append(mid + at * (0.5 * (high - low) + 0.5 * at * (low - 2.0 * mid + high)))
        return np.where(values[1] > values[0], radii[1], radii[0])

    def _square(self, touch: Touch, points: Points) -> Floats:
        return Seen(self, touch, points).square

    @cached_property
    def hardest(self) -> Ints:
        """Number of the touch with the largest pressure, (n,); of two alike the first."""
        squares = np.array(np.broadcast_arrays(*self.peaks))
        return np.asarray(np.argmax(squares >= (1.0 - 2.0 * ALIKE) * squares.max(axis=0), axis=0))

    def hard(self, values: Sequence[Floats]) -> Floats:
        """Of a figure of every touch that of the hardest pressed one."""
        return np.asarray(np.choose(self.hardest, [self.variants.full(one) for one in values]))

    def of_duty(self, what: str) -> Floats:
        """The largest of a quantity over what one duty sees: both flanks of a groove, both faces; else one roller."""
        each = [self.largest(what, seen) for seen in self.all]
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
        return np.asarray(2.0 * SHEAR_DEPTH * self.compliance * np.sqrt(np.maximum(self.of_duty("spread"), 0.0)))

    def torque(self, p: Points) -> Floats:
        """Of the camshaft, N mm: what all touches give."""
        given = [touch.way * Seen(self, touch, p).pushed for touch in self.touches]
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
            given = np.asarray(sum(touch.way * Seen(self, touch, p).pushed for touch in self.touches))
        force = given - self.force(p) + self.friction * p.side
        for one in self.applied:
            force = force + self._applied(one, p)
        return np.asarray(force * p.ds)

    @cached_property
    def peak_torque(self) -> Floats:
        """Largest size of the torque, N mm."""
        return self.motion.largest(lambda p: np.abs(self.torque(p)))

    def hard_samples(self, what: str, every: Sequence[Seen] | None = None) -> Floats:
        """Samples (P, n) of a quantity of the hardest pressed of two rollers; of a groove's roller that of all."""
        every = self.all if every is None else every
        shape = (every[0].points.s.shape[0], self.variants.size)
        each = [np.broadcast_to(getattr(seen, what), shape) for seen in every]
        if not self.alone:
            return np.asarray(np.max(each, axis=0))
        return np.asarray(np.choose(self.hardest[None], each))

    @cached_property
    def rolled(self) -> Floats:
        """Path, mm/rad, (P, n), that the roller rolls on the flank it presses: of two rollers the hardest pressed."""
        return self.hard_samples("rolled")

    @cached_property
    def roller_life(self) -> Floats:
        """h, of the hardest pressed roller's hot spot."""
        from camgeom.design.batch.rolling import SAMPLES, roller_damage

        v = self.variants
        limit, cycles, power = (
            v.number(f"material.roller.{key}") for key in ("contact_limit", "contact_cycles", "exponent")
        )
        walls, points = [np.zeros(1), np.zeros(1)], self.motion.sampled(SAMPLES)
        every = [Seen(self, touch, points) for touch in self.touches]
        for number, seen in enumerate(every):
            pressed = seen.signed_square / limit**2
            if self.alone:
                pressed = np.where(self.hardest == number, pressed, 0.0)
            walls[number] = np.broadcast_to(pressed, (points.s.shape[0], v.size))
        if len(self.all) == 1:
            walls[1] = np.zeros_like(walls[0])
        damage = roller_damage(self.motion, self.hard_samples("turned", every), walls[0], walls[1], self.radius, power)
        return hours(damage / cycles, self.omega)

    @cached_property
    def bearing_load(self) -> Floats:
        """Equivalent load of the roller's bearing, N."""
        force, rate = self.hard_samples("pressing"), self.rolled
        most = np.maximum(force.max(axis=0), LEAST_LOAD)
        share = self.motion.integral((force / most) ** ROLLER_EXPONENT * rate) / self.motion.integral(rate)
        return np.asarray(most * share ** (1.0 / ROLLER_EXPONENT))

    @cached_property
    def bearing_life(self) -> Floats:
        """h."""
        turning = self.omega * self.motion.integral(self.rolled) / (2.0 * pi * self.radius)
        return rated_hours(self.variants.number("roller.dynamic_rating"), self.bearing_load, turning)

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

    @cached_property
    def cam_life(self) -> Floats:
        """h, at the hardest place of the cam."""
        v = self.variants
        limit, cycles, power = (
            v.number(f"material.cam.{key}") for key in ("contact_limit", "contact_cycles", "exponent")
        )
        damage = (self.pressure / limit) ** power / cycles
        if self.face == "flat" and len(self.all) == 2:
            damage = np.maximum(damage, self._shared_damage(limit, cycles, power))
        return hours(damage, self.omega)

    def _shared_damage(self, limit: Floats, cycles: Floats, power: Floats) -> Floats:
        """Largest damage of a cam's point that both faces of a frame meet, half a turn apart."""
        near = self.touches[0]
        low, high = self.motion.lift_range

        def both(p: Points) -> Floats:
            here = Seen(self, near, p)
            far = Points(p.theta + pi, low + high - p.s, -p.ds, -p.dds, -p.side)
            scale = self.length * np.pi * self.compliance * here.relative_radius * limit**2
            forces = here.pressing, np.maximum(-self.force(far), 0.0)
            return np.asarray(sum((force / scale) ** (0.5 * power) for force in forces) / cycles)

        return self.motion.largest(both)


@lru_cache(maxsize=8)
def _jumps(profile: Profile) -> bool:
    """Whether the motion's velocity jumps, which no number of a segment changes."""
    return bool(profile.setup().program.continuity.order < 1)


def _or_none(curvature: Floats, there: Mask) -> Floats:
    """One over a curvature where it is there, infinite elsewhere."""
    return np.where(there, 1.0 / np.where(there, curvature, 1.0), np.inf)


FIGURES: dict[str, Callable[[Cams], Floats]] = {
    "flank.max_pressure_angle_deg": lambda c: 2.0 * np.degrees(np.arctan(c.most("half_tangent"))),
    "flank.min_relative_radius_mm": lambda c: c.relative_radius,
    "flank.undercut_margin": lambda c: c.margin,
    "flank.min_convex_radius_mm": lambda c: c.convex,
    "flank.min_hollow_radius_mm": lambda c: c.hollow,
    "flank.top_dwell_share": lambda c: c.motion.top_share,
    "flank.min_face_radius_mm": lambda c: c.face_radius,
    "flank.face_width_needed_mm": lambda c: c.most("along_size"),
    "flank.max_sliding_mm_per_rad": lambda c: c.most("sliding"),
    "blank.diameter_mm": lambda c: c.blank[0],
    "blank.length_mm": lambda c: c.blank[1],
    "blank.volume_mm3": lambda c: 0.25 * pi * c.blank[0] ** 2 * c.blank[1],
    "contact.peak_force_n": lambda c: c.of_duty("pressing"),
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
    "contact.least_force_n": lambda c: c.smallest("needed", c.all[0]),
    "contact.preload_needed": lambda c: np.maximum(c.preload - c.smallest("force", c.all[0]), 0.0),
    "contact.leaving_speed_rpm": lambda c: c.leaving_speed,
    "fatigue.roller_life_h": lambda c: c.roller_life,
    "fatigue.roller_slice_life_h": lambda c: c.roller_life,
    "fatigue.bearing_life_h": lambda c: c.bearing_life,
    "fatigue.bearing_mean_load_n": lambda c: c.bearing_load,
    "fatigue.bearing_static_safety": lambda c: c.variants.number("roller.static_rating")
    / np.maximum(c.of_duty("pressing"), LEAST_LOAD),
    "fatigue.cam_life_h": lambda c: c.cam_life,
    "fatigue.cam_slice_life_h": lambda c: c.cam_life,
    "fatigue.path_per_turn_m": lambda c: c.motion.integral(c.rolled) * MILLI,
}
