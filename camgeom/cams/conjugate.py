"""Conjugate pair: main and return disc on one shaft, two rollers on one rocker or slide, driven both ways, no spring.

The return disc is the envelope of the return roller under the same motion, ahead of it by the play asked for. The
discs are stacked along Z: main 0 <= z <= width, return disc above it after `gap`.
"""

from __future__ import annotations

from math import asin, radians, sqrt
from typing import ClassVar, Literal

from pydantic import Field

from camgeom.cams._plate import (
    SLIDE,
    Arm,
    arm_angle,
    bore_problems,
    lift_range,
    mark_loops,
    mark_problems,
    problem,
    roller_track,
    swing_problem,
    triangle_problem,
)
from camgeom.errors import Problem
from camgeom.keys import Degrees, Gap, Length, Section
from camgeom.solid import Part
from camgeom.solid.blank import Bore
from camgeom.solid.prism import Loop, Prism
from camgeom.track import Joint, Track, Vector
from camgeom.track.follower import Setup, SwingingFollower, TranslatingFollower
from camgeom.track.outline import Outline, RollerOutline
from camgeom.track.touch import Touch


class Cam(Section):
    """Two discs on one shaft; the main roller drives towards larger lift, the return roller back."""

    FOLLOWERS: ClassVar[tuple[str, ...]] = ("swinging", "translating")

    kind: Literal["conjugate"]
    base_radius: Length = Field(description="mm, radius of the main profile at zero lift")
    width: Length = Field(description="mm, thickness of each disc")
    center_distance: Length | None = Field(None, description="mm, swinging followers: cam axis to pivot")
    return_arm: Length | None = Field(None, description="mm, arm of the return roller; default that of the follower")
    rocker_angle: Degrees | None = Field(
        None, description="deg, from the main arm to the return arm; default: the return disc has the main base radius"
    )
    return_radius: Length | None = Field(
        None, description="mm, slide: radius of the return profile at zero lift; default base_radius plus the stroke"
    )
    gap: Gap = Field(0.0, description="mm, between the two discs along the shaft")
    bore: Gap = Field(0.0, description="mm, bore diameter; 0 leaves the discs whole")
    keyway_width: Gap = Field(0.0, description="mm; 0 leaves the keyway out")
    keyway_depth: Gap = Field(0.0, description="mm, from the bore wall")
    mark_diameter: Gap = Field(0.0, description="mm, hole through both discs as a phase mark; 0 leaves it out")
    mark_radius: Length | None = Field(None, description="mm, cam axis to the phase mark, a quarter turn from +X")
    direction: Literal["ccw", "cw"] = Field("ccw", description="the cam's turning, seen from +Z")

    @property
    def sense(self) -> float:
        """+1 counter-clockwise, -1 clockwise."""
        return 1.0 if self.direction == "ccw" else -1.0

    def quoted_radius(self, setup: Setup) -> float:
        """Middle of the main roller's contact along its axis, mm (a height z)."""
        return 0.5 * sum(self._heights(setup)[0])

    def _heights(self, setup: Setup) -> tuple[tuple[float, float], tuple[float, float]]:
        """Heights z between which the main and the return roller touch, mm."""
        length = min(self.width, (setup.roller.length if setup.roller else None) or self.width)
        middles = 0.5 * self.width, 1.5 * self.width + self.gap
        low, high = ((m - 0.5 * length, m + 0.5 * length) for m in middles)
        return low, high

    def problems(self, setup: Setup) -> list[Problem]:
        """What cannot be built, with key, value and allowed range."""
        if setup.roller is None:
            return [Problem("roller", "a conjugate pair needs rollers", None, "a [roller] table")]
        found = bore_problems(self.bore, self.keyway_width, self.keyway_depth, self.base_radius)
        if setup.roller.shape not in ("cylinder", "crowned"):
            found.append(problem("roller.shape", setup.roller.shape, "cylinder or crowned on conjugate cams"))
        reach = Bore(self.bore, self.keyway_width, self.keyway_depth).reach if self.bore else 0.0
        found += mark_problems(self.mark_diameter, self.mark_radius, self.base_radius, reach)
        follower = setup.follower
        if isinstance(follower, SwingingFollower):
            return found + self._swing_problems(setup, follower)
        assert isinstance(follower, TranslatingFollower)
        return found + self._slide_problems(setup, follower)

    def _swing_problems(self, setup: Setup, follower: SwingingFollower) -> list[Problem]:
        a, prime = self.center_distance, self._prime(setup)
        found = [] if follower.face == "roller" else [problem("follower.face", follower.face, "roller")]
        if a is None:
            return [*found, Problem("cam.center_distance", "is missing", None, "mm, cam shaft to the rocker's pivot")]
        back = self.return_arm or follower.arm
        open_ = [triangle_problem("cam.center_distance", a, follower.arm, prime, "arm")]
        open_ += [triangle_problem("cam.return_arm", a, back, prime, "return arm")] if self.rocker_angle is None else []
        if any(open_):
            return [*found, *filter(None, open_)]
        start = arm_angle(a, follower.arm, prime)
        swung = swing_problem(start, setup.program)
        if swung:
            return [*found, swung]
        low, high = lift_range(setup.program)
        least = start + high + self._play(setup)
        if not least < self.angle_between(setup) < 2.0 * asin(1.0) + start + low:
            limit = "above the main arm's largest angle from the line of centres and below half a turn beyond its "
            found.append(problem("cam.rocker_angle", self.rocker_angle, limit + "least one"))
        return found

    def _slide_problems(self, setup: Setup, follower: TranslatingFollower) -> list[Problem]:
        found = [] if follower.face == "roller" else [problem("follower.face", follower.face, "roller")]
        for key in ("center_distance", "return_arm", "rocker_angle"):
            if getattr(self, key) is not None:
                found.append(problem(f"cam.{key}", getattr(self, key), "none for a slide (it belongs to a rocker)"))
        prime = self._prime(setup)
        if abs(follower.offset) >= prime:
            found.append(problem("follower.offset", follower.offset, f"below the prime radius {prime:g} mm"))
        stroke = lift_range(setup.program)[1]
        radius = setup.roller.diameter * 0.5 if setup.roller else 0.0
        least = sqrt((stroke + 1e-3) ** 2 + follower.offset**2) - radius
        if self.slide_return_radius(setup) <= max(least, 0.0):
            limit = f"above {max(least, 0.0):g} mm, so that the roller stays on its side of the shaft"
            found.append(problem("cam.return_radius", self.return_radius, limit))
        return found

    def _prime(self, setup: Setup) -> float:
        return self.base_radius + (0.5 * setup.roller.diameter if setup.roller else 0.0)

    def slide_return_radius(self, setup: Setup) -> float:
        """Radius of the slide's return profile at zero lift, mm; the default makes the discs mirror images."""
        if self.return_radius is not None or setup.roller is None:
            return self.return_radius or self.base_radius
        assert isinstance(setup.follower, TranslatingFollower)
        e, r, prime = setup.follower.offset, 0.5 * setup.roller.diameter, self._prime(setup)
        return sqrt((sqrt(prime**2 - e**2) + lift_range(setup.program)[1]) ** 2 + e**2) - r

    def angle_between(self, setup: Setup) -> float:
        """Angle of the rocker from the main arm to the return arm, rad."""
        if self.rocker_angle is not None:
            return radians(self.rocker_angle)
        assert isinstance(setup.follower, SwingingFollower)
        assert self.center_distance is not None
        a, prime = self.center_distance, self._prime(setup)
        start = arm_angle(a, setup.follower.arm, prime)
        return start + lift_range(setup.program)[1] + arm_angle(a, self.return_arm or setup.follower.arm, prime)

    def _play(self, setup: Setup) -> float:
        """By how much the follower is ahead where it touches the return disc, mm or rad (chord at the roller)."""
        follower = setup.follower
        if isinstance(follower, SwingingFollower):
            return 2.0 * asin(min(1.0, follower.clearance / (2.0 * (self.return_arm or follower.arm))))
        assert isinstance(follower, TranslatingFollower)
        return follower.clearance

    def _mounts(self, setup: Setup) -> tuple[Joint, Vector, Vector]:
        """The joint, and where the main and the return roller stand at zero lift."""
        follower, prime = setup.follower, self._prime(setup)
        if isinstance(follower, SwingingFollower):
            assert self.center_distance is not None
            arm = Arm(self.center_distance, 1.0 if follower.side == "left" else -1.0)
            start = arm_angle(self.center_distance, follower.arm, prime)
            back = start - self.angle_between(setup)
            return arm.joint, arm.point(follower.arm, start), arm.point(self.return_arm or follower.arm, back)
        assert isinstance(follower, TranslatingFollower)
        e = follower.offset
        far = self.slide_return_radius(setup) + prime - self.base_radius
        return SLIDE, (sqrt(prime**2 - e**2), e, 0.0), (-sqrt(far**2 - e**2), e, 0.0)

    def tracks(self, setup: Setup) -> tuple[Track, ...]:
        """The main and the return roller."""
        assert setup.roller is not None
        joint, main, back = self._mounts(setup)
        low, high = self._heights(setup)
        # Each roller's free end faces the other disc: it reaches no further than its own.
        roller, program, sense = setup.roller, setup.program, self.sense
        first, second = (roller.meridian(0.5 * (z[0] + z[1]), 1.0) for z in (low, high))
        return (
            roller_track("main", program, sense, main, joint, first, low, tip_high=True),
            roller_track("return", program, sense, back, joint, second, high, shift=self._play(setup)),
        )

    def outlines(self, setup: Setup) -> dict[str, Outline]:
        """Profile and pitch curve of both discs by name."""
        assert setup.roller is not None
        r = 0.5 * setup.roller.diameter
        main, back = self.tracks(setup)
        return {
            "main": RollerOutline(main, -r),
            "return": RollerOutline(back, -r),
            "main pitch curve": RollerOutline(main, 0.0),
            "return pitch curve": RollerOutline(back, 0.0),
        }

    def touches(self, setup: Setup) -> tuple[Touch, ...]:
        """The two contacts: the main disc pushes towards larger lift, the return disc back."""
        assert setup.roller is not None
        joint, _, _ = self._mounts(setup)
        low, high = self._heights(setup)[0]
        outlines, radius = self.outlines(setup), 0.5 * setup.roller.diameter
        return tuple(
            Touch(name, outlines[name], joint, self.sense, way, radius, high - low)
            for name, way in (("main", 1.0), ("return", -1.0))
        )

    def parts(self, setup: Setup) -> tuple[Part, ...]:
        """The main disc and the return disc, with bore and phase mark."""
        bore = Bore(self.bore, self.keyway_width, self.keyway_depth) if self.bore else None
        marks = mark_loops(self.mark_diameter, self.mark_radius or 0.0, self.sense)
        outlines, above = self.outlines(setup), self.width + self.gap
        return (
            Prism("main disc", Loop(outlines["main"], "flank"), 0.0, self.width, marks, bore),
            Prism("return disc", Loop(outlines["return"], "flank"), above, above + self.width, marks, bore),
        )
