"""What touches a planar cam, of many variants: rollers, faces and edges on slides and arms, where they stand.

What the cam types have against a variant is told as they tell it (`cams.disc`, `cams.constant_width`,
`cams.conjugate`).
"""

from __future__ import annotations

from dataclasses import replace
from math import pi
from typing import final

import numpy as np

from camgeom.cams.conjugate import Conjugate
from camgeom.cams.constant_width import ConstantWidth
from camgeom.cams.disc import Disc
from camgeom.design.batch.motion import Motion, Points
from camgeom.design.batch.variants import Variants
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.track.outline import Pair


@final
@immutable
class Slide:
    """What stands at x + lift on a slide along X, at the height y, mm."""

    x: Floats
    y: Floats

    def jets(self, p: Points) -> tuple[Pair, Pair, Pair]:
        """Place, velocity and acceleration in the machine's frame by the cam angle."""
        zero = np.zeros_like(self.y)
        return (self.x + p.s, self.y), (p.ds, zero), (p.dds, zero)

    def moved(self, at: Pair) -> Pair:
        """Velocity of a place by the coordinate."""
        return np.ones(1), np.zeros(1)


@final
@immutable
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
@immutable
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
class Standing:
    """Where the touches of n variants stand; what is wrong with one goes to its refusals."""

    def __init__(self, variants: Variants, motion: Motion) -> None:
        self.variants, self.motion = variants, motion
        profile, cam = variants.profile, variants.profile.cam
        assert isinstance(cam, Disc | ConstantWidth | Conjugate)
        self.offset = variants.number("follower.offset")
        self.face = profile.follower.face if profile.roller is None else "roller"
        self.length = self._length(cam)
        self.radius = self._radius()
        self.touches = self._touches(cam)
        self._refuse_bores()

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
        way = v.profile.follower.way
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
        way = v.profile.follower.way
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
