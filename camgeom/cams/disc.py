"""Disc cam: external (force-closed) or face groove (form-closed), any of the usual followers."""

from __future__ import annotations

from dataclasses import replace
from math import cos, hypot, inf, sqrt
from typing import ClassVar, Literal

from pydantic import Field

from camgeom.cams._plate import (
    SLIDE,
    Arm,
    arm_angle,
    bore_problems,
    lift_range,
    problem,
    roller_track,
    swing_problem,
    triangle_problem,
)
from camgeom.errors import Problem
from camgeom.keys import Gap, Length, Section
from camgeom.solid import Part
from camgeom.solid.blank import Bore
from camgeom.solid.prism import FaceGroove, Loop, Prism
from camgeom.track import Joint, Meridian, Straight, Track, Vector
from camgeom.track.follower import Setup, SwingingFollower, TranslatingFollower
from camgeom.track.outline import CircleOutline, FaceOutline, FlatFace, Outline, RollerOutline
from camgeom.track.touch import Touch


class Cam(Section):
    """A disc 0 <= z <= width; translating followers move along +X, swinging ones pivot at (center_distance, 0)."""

    FOLLOWERS: ClassVar[tuple[str, ...]] = ("translating", "swinging")

    kind: Literal["disc"]
    form: Literal["external", "groove"] = Field("external", description="external profile, or a face groove in a plate")
    base_radius: Length = Field(description="mm, radius of the profile (groove: of its inner flank) at zero lift")
    width: Length = Field(description="mm, thickness of the disc or plate")
    center_distance: Length | None = Field(None, description="mm, swinging followers: cam axis to pivot")
    diameter: Length | None = Field(None, description="mm, groove form: outside diameter of the plate")
    groove_depth: Length | None = Field(None, description="mm, groove form: depth from the plate's upper face")
    running_clearance: Gap = Field(0.0, description="mm, groove form: normal gap between roller and each flank")
    bore: Gap = Field(0.0, description="mm, bore diameter; 0 leaves the disc whole")
    keyway_width: Gap = Field(0.0, description="mm; 0 leaves the keyway out")
    keyway_depth: Gap = Field(0.0, description="mm, from the bore wall")
    direction: Literal["ccw", "cw"] = Field("ccw", description="the cam's turning, seen from +Z")

    @property
    def sense(self) -> float:
        """+1 counter-clockwise, -1 clockwise."""
        return 1.0 if self.direction == "ccw" else -1.0

    def touch_radius(self, setup: Setup) -> float:
        """Radius of what touches the cam, mm: the roller, the mushroom's face, 0 for a knife edge or a flat face."""
        face = _face(setup)
        if face == "roller":
            return 0.5 * setup.roller.diameter if setup.roller else 0.0
        if face == "curved":
            return float(getattr(setup.follower, "face_radius", None) or 0.0)
        return 0.0

    def prime_radius(self, setup: Setup) -> float:
        """Distance of the trace point from the cam axis at zero lift, mm."""
        return self.base_radius + self.touch_radius(setup)

    def quoted_radius(self, setup: Setup) -> float:
        """Middle of the contact along the roller axis, mm (a height z: the roller's axis is parallel to the cam's)."""
        low, high = self.contact(setup)
        return 0.5 * (low + high)

    def contact(self, setup: Setup) -> tuple[float, float]:
        """Heights z between which roller and cam touch, mm."""
        depth = self.groove_depth if self.form == "groove" and self.groove_depth else self.width
        length = min(depth, setup.roller.length or depth) if setup.roller else depth
        if self.form == "groove":
            return self.width - length, self.width
        return 0.5 * (self.width - length), 0.5 * (self.width + length)

    def problems(self, setup: Setup) -> list[Problem]:
        """What cannot be built, with key, value and allowed range."""
        found = bore_problems(self.bore, self.keyway_width, self.keyway_depth, self.base_radius)
        face = _face(setup)
        if face == "roller" and setup.roller is None:
            return [*found, Problem("roller", "face = 'roller' needs a roller", None, "a [roller] table")]
        if face == "roller" and setup.roller is not None and setup.roller.shape not in ("cylinder", "crowned"):
            found.append(problem("roller.shape", setup.roller.shape, "cylinder or crowned on a disc cam"))
        if face == "curved" and not getattr(setup.follower, "face_radius", None):
            found.append(Problem("follower.face_radius", "is missing", None, "a radius in mm, for face = 'curved'"))
        if self.form == "groove":
            found += self._groove_problems(setup, face)
        if isinstance(setup.follower, SwingingFollower):
            return [*found, *self._swing_problems(setup, setup.follower, face)]
        offset = abs(setup.follower.offset) if isinstance(setup.follower, TranslatingFollower) else 0.0
        prime = self.prime_radius(setup)
        if face != "flat" and offset >= prime:
            found.append(problem("follower.offset", offset, f"below the prime radius {prime:g} mm"))
        return found

    def _groove_problems(self, setup: Setup, face: str) -> list[Problem]:
        if face != "roller":
            return [problem("follower.face", face, "roller, for form = 'groove'")]
        if self.diameter is None or self.groove_depth is None:
            missing = "cam.diameter" if self.diameter is None else "cam.groove_depth"
            return [Problem(missing, "is missing", None, "a length in mm, for form = 'groove'")]
        found = []
        if self.groove_depth >= self.width:
            found.append(problem("cam.groove_depth", self.groove_depth, f"below the width {self.width:g} mm"))
        reach = self._groove_reach(setup)
        if 0.5 * self.diameter <= reach:
            limit = f"above {2.0 * reach:g} mm, so that the groove is inside"
            found.append(problem("cam.diameter", self.diameter, limit))
        return found

    def _groove_reach(self, setup: Setup) -> float:
        """Largest radius of the groove's outer flank, mm; 0 where the mechanism itself cannot be built."""
        follower, prime, top = setup.follower, self.prime_radius(setup), lift_range(setup.program)[1]
        own = self.touch_radius(setup) + self.running_clearance
        if isinstance(follower, TranslatingFollower):
            low = sqrt(max(prime**2 - follower.offset**2, 0.0))
            return hypot(low + top, follower.offset) + own
        assert isinstance(follower, SwingingFollower)
        a = self.center_distance
        if a is None or self._swing_problems(setup, follower, "roller"):
            return 0.0
        angle = arm_angle(a, follower.arm, prime) + top
        return sqrt(a**2 + follower.arm**2 - 2.0 * a * follower.arm * cos(angle)) + own

    def _swing_problems(self, setup: Setup, follower: SwingingFollower, face: str) -> list[Problem]:
        a = self.center_distance
        if a is None:
            return [Problem("cam.center_distance", "is missing", None, "mm, cam axis to the follower's pivot")]
        if face == "flat":
            if not abs(self.base_radius + follower.face_offset) < a:
                least = abs(self.base_radius + follower.face_offset)
                limit = f"above {least:g} mm, so that the face clears the base circle"
                return [problem("cam.center_distance", a, limit)]
            return []
        arm, prime = follower.arm, self.prime_radius(setup)
        found = triangle_problem("cam.center_distance", a, arm, prime, "arm")
        found = found or swing_problem(arm_angle(a, arm, prime), setup.program)
        return [found] if found else []

    def track(self, setup: Setup) -> Track:
        """The pitch motion of the roller (or of the centre of a curved face, or of a knife edge)."""
        anchor, joint = self._mount(setup)
        low, high = self.contact(setup)
        sides = (1.0, -1.0) if self.form == "groove" else (-self.sense,)
        name = "profile" if self.form == "external" else "groove"
        meridian = self._meridian(setup)
        return roller_track(
            name, setup.program, self.sense, anchor, joint, meridian, (low, high), sides=sides
        )

    def _meridian(self, setup: Setup) -> Meridian:
        if setup.roller is not None and _face(setup) == "roller":
            low, high = self.contact(setup)
            return setup.roller.meridian(0.5 * (low + high), 1.0)
        return Straight(max(self.touch_radius(setup), 1e-9), 0.0)

    def tracks(self, setup: Setup) -> tuple[Track, ...]:
        """The roller's track; a curved face counts as a roller of its radius; none for flat and knife followers."""
        return (self.track(setup),) if _face(setup) in ("roller", "curved") else ()

    def _mount(self, setup: Setup) -> tuple[Vector, Joint]:
        follower, prime = setup.follower, self.prime_radius(setup)
        if isinstance(follower, SwingingFollower):
            assert self.center_distance is not None
            arm = Arm(self.center_distance, _way(follower))
            return arm.point(follower.arm, arm_angle(self.center_distance, follower.arm, prime)), arm.joint
        assert isinstance(follower, TranslatingFollower)
        return (sqrt(prime**2 - follower.offset**2), follower.offset, 0.0), SLIDE

    def outline(self, setup: Setup) -> Outline:
        """The cam's profile (groove form: the inner flank)."""
        if _face(setup) == "flat":
            return FaceOutline(self.face_motion(setup))
        return RollerOutline(self.track(setup), -self.touch_radius(setup) - self._gap)

    @property
    def _gap(self) -> float:
        return self.running_clearance if self.form == "groove" else 0.0

    def outlines(self, setup: Setup) -> dict[str, Outline]:
        """Profile and pitch curve by name; a face groove has an inner and an outer flank."""
        found: dict[str, Outline] = {"profile": self.outline(setup)}
        if _face(setup) != "flat":
            found["pitch curve"] = RollerOutline(self.track(setup), 0.0)
        if self.form == "groove":
            found["outer flank"] = RollerOutline(self.track(setup), self.touch_radius(setup) + self._gap)
        return found

    def face_motion(self, setup: Setup) -> FlatFace:
        """The motion of a flat face seen from the cam."""
        follower = setup.follower
        if isinstance(follower, SwingingFollower):
            assert self.center_distance is not None
            pivot, offset = self.center_distance, follower.face_offset
            return FlatFace(setup.program, self.sense, self.base_radius, pivot, offset, _way(follower))
        return FlatFace(setup.program, self.sense, self.base_radius)

    def touches(self, setup: Setup) -> tuple[Touch, ...]:
        """The contacts: one of an external cam, both flanks of a face groove."""
        face = _face(setup)
        low, high = self.contact(setup)
        joint = self._joint(setup)
        radius = inf if face == "flat" else self.touch_radius(setup)
        inner = Touch("profile", self.outline(setup), joint, self.sense, 1.0, radius, high - low, kind=face)
        if self.form == "external":
            return (inner,)
        outer = self.outlines(setup)["outer flank"]
        return (
            replace(inner, name="inner flank"),
            Touch("outer flank", outer, joint, self.sense, -1.0, radius, high - low, material=-1.0),
        )

    def _joint(self, setup: Setup) -> Joint:
        if isinstance(setup.follower, SwingingFollower):
            assert self.center_distance is not None
            return Arm(self.center_distance, _way(setup.follower)).joint
        return SLIDE

    def bore_spec(self) -> Bore | None:
        """The bore, or None."""
        return Bore(self.bore, self.keyway_width, self.keyway_depth) if self.bore else None

    def parts(self, setup: Setup) -> tuple[Part, ...]:
        """The disc, or the plate with its face groove."""
        profile = self.outline(setup)
        if self.form == "external":
            return (Prism("cam", Loop(profile, "flank"), 0.0, self.width, (), self.bore_spec()),)
        assert self.diameter is not None
        assert self.groove_depth is not None
        outer = self.outlines(setup)["outer flank"]
        rim = Loop(CircleOutline(0.5 * self.diameter), "rim")
        floor = self.width - self.groove_depth
        inside, outside = Loop(profile, "flank"), Loop(outer, "flank")
        return (FaceGroove("cam", rim, inside, outside, 0.0, floor, self.width, self.bore_spec()),)


def _face(setup: Setup) -> str:
    return str(getattr(setup.follower, "face", "roller"))


def _way(follower: SwingingFollower) -> float:
    """+1 where the arm's contact lies on the +Y side."""
    return 1.0 if follower.side == "left" else -1.0
