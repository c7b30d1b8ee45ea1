"""Conjugate pair: main and return disc on one shaft, two rollers on one rocker or slide, driven both ways, no spring.

The return disc is the envelope of the return roller under the same motion, ahead of it by the play asked for; that
roller may be another one than the main roller. The discs are stacked along Z: main 0 <= z <= width, return disc above
it after `gap`. The flank of a conical roller's disc leans as the cone does; free ends face the other disc.
"""

from __future__ import annotations

from dataclasses import replace
from math import asin, radians, sqrt
from typing import TYPE_CHECKING, ClassVar, Literal, final

import numpy as np
from pydantic import Field

from camgeom.cams import NO_DRUM, NO_ROOT, REGULAR, Cam, idle, prism_idle, problem, sense_of
from camgeom.cams._plate import (
    SLIDE,
    Arm,
    arm_angle,
    bore_of,
    bore_problems,
    bore_walls,
    cone_problems,
    disc_wall,
    face_idle,
    least_wall,
    lift_range,
    mark_loops,
    mark_problems,
    mark_walls,
    plate_envelope,
    roller_track,
    straight_problems,
    swing_problem,
    triangle_problem,
)
from camgeom.errors import Problem
from camgeom.immutable import immutable
from camgeom.keys import Degrees, Gap, Length
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.solid import Part
from camgeom.solid.blank import Wall
from camgeom.solid.mechanism import Drive, Mechanism
from camgeom.solid.prism import Loop, Prism
from camgeom.track import Joint, Track, Vector
from camgeom.track.follower import AnyRoller, ConeRoller, Setup, SwingingFollower, TranslatingFollower
from camgeom.track.outline import Outline, RollerOutline
from camgeom.track.touch import Touch

if TYPE_CHECKING:
    from camgeom.track.beside import Neighbour


@final
class Conjugate(Cam):
    """Two discs on one shaft; the main roller drives towards larger lift, the return roller back."""

    FOLLOWERS: ClassVar[tuple[str, ...]] = ("swinging", "translating")
    STATIONS: ClassVar[bool] = True
    ROLLERS: ClassVar[tuple[str, ...]] = ("roller", "return_roller")

    kind: Literal["conjugate"]
    base_radius: Length = Field(
        description="mm, radius of the main profile at zero lift; of a cone's half way between its faces"
    )
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

    def mechanism(self, setup: Setup) -> ConjugateMechanism:
        """The pair with its rocker or slide."""
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, SwingingFollower | TranslatingFollower)
        assert roller is not None
        return ConjugateMechanism(
            follower=follower,
            roller=roller,
            program=setup.program,
            sense=sense_of(self.direction),
            drive=Drive.OPPOSED,
            width=self.width,
            bore=bore_of(self.bore, self.keyway_width, self.keyway_depth),
            base_radius=self.base_radius,
            back=setup.second or roller,
            cam=self,
        )

    def idle(self, setup: Setup) -> dict[str, str]:
        """Keys of the other follower, and of followers of other cams."""
        found = NO_DRUM | REGULAR | NO_ROOT | prism_idle(self.bore, self.mark_diameter) | face_idle("roller")
        if any(isinstance(roller, ConeRoller) for roller in (setup.roller, setup.second)):
            found |= idle("what a pair strikes is solved for discs of one profile at all heights", "impact")
        if not setup.follower.rotating:
            rocker = ("cam.center_distance", "cam.return_arm", "cam.rocker_angle")
            return found | idle("belongs to a rocker, none for a slide", *rocker)
        found |= idle("belongs to a slide, none for a rocker", "cam.return_radius")
        return found | idle("belongs to a drum's follower", "follower.pivot_distance", "follower.start_angle")

    def problems(self, setup: Setup) -> list[Problem]:
        """What cannot be built, with key, value and allowed range."""
        if setup.roller is None:
            return [Problem("roller", "a conjugate pair needs rollers", None, "a [roller] table")]
        found = bore_problems(self.bore, self.keyway_width, self.keyway_depth, self.base_radius)
        for table, roller in zip(self.ROLLERS, (setup.roller, setup.second)):
            if isinstance(roller, ConeRoller):
                found += cone_problems(roller, (0.5 * self.width, 0.5 * self.width), table)
            elif roller is not None and roller.shape not in ("cylinder", "crowned"):
                found.append(problem(f"{table}.shape", roller.shape, "cylinder, cone or crowned on conjugate cams"))
            found += straight_problems(roller, table)
        mechanism = self.mechanism(setup)
        reach = mechanism.bore.reach if mechanism.bore else 0.0
        found += mark_problems(self.mark_diameter, self.mark_radius, self.base_radius, reach)
        follower = mechanism.follower
        if follower.face != "roller":
            found.append(problem("follower.face", follower.face, "roller"))
        if isinstance(follower, SwingingFollower):
            return found + self._swing_problems(mechanism, follower)
        return found + self._slide_problems(mechanism, follower)

    def _swing_problems(self, mechanism: ConjugateMechanism, follower: SwingingFollower) -> list[Problem]:
        a, prime = self.center_distance, mechanism.prime_radius
        if a is None:
            return [Problem("cam.center_distance", "is missing", None, "mm, cam shaft to the rocker's pivot")]
        back = self.return_arm or follower.arm
        open_ = [triangle_problem("cam.center_distance", a, follower.arm, prime, "arm")]
        if self.rocker_angle is None:
            open_ += [triangle_problem("cam.return_arm", a, back, mechanism.return_prime, "return arm")]
        if any(open_):
            return list(filter(None, open_))
        start = arm_angle(a, follower.arm, prime)
        swung = swing_problem(start, mechanism.program)
        if swung:
            return [swung]
        low, high = lift_range(mechanism.program)
        if start + high + mechanism.play < mechanism.angle_between < 2.0 * asin(1.0) + start + low:
            return []
        limit = "above the main arm's largest angle from the line of centres and below half a turn beyond its least one"
        return [problem("cam.rocker_angle", self.rocker_angle, limit)]

    def _slide_problems(self, mechanism: ConjugateMechanism, follower: TranslatingFollower) -> list[Problem]:
        found: list[Problem] = []
        prime = mechanism.prime_radius
        if abs(follower.offset) >= prime:
            return [*found, problem("follower.offset", follower.offset, f"below the prime radius {prime:g} mm")]
        stroke = lift_range(mechanism.program)[1]
        least = sqrt((stroke + 1e-3) ** 2 + follower.offset**2) - 0.5 * mechanism.back.diameter
        if mechanism.slide_return_radius <= max(least, 0.0):
            limit = f"above {max(least, 0.0):g} mm, so that the roller stays on its side of the shaft"
            found.append(problem("cam.return_radius", self.return_radius, limit))
        return found


@final
@immutable(kw_only=True)
class ConjugateMechanism(Mechanism):
    """A conjugate pair and its rocker or slide; back: the return roller."""

    follower: SwingingFollower | TranslatingFollower
    roller: AnyRoller
    back: AnyRoller
    cam: Conjugate

    @property
    def rollers(self) -> tuple[AnyRoller, ...]:
        """The main and the return roller."""
        return self.roller, self.back

    @property
    def quoted_radius(self) -> float:
        """Middle of the main roller's contact along its axis, mm (a height z)."""
        return 0.5 * sum(self._heights[0])

    @property
    def _heights(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Heights z between which the main and the return roller touch, mm."""
        width = self.cam.width
        halves = (0.5 * min(width, roller.length or width) for roller in self.rollers)
        low, high = ((0.5 * sum(disc) - half, 0.5 * sum(disc) + half) for disc, half in zip(self._discs, halves))
        return low, high

    @property
    def _discs(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Heights z of the faces of the main and the return disc, mm."""
        above = self.width + self.cam.gap
        return (0.0, self.width), (above, above + self.width)

    @property
    def neighbours(self) -> tuple[Neighbour, ...]:
        """Each roller, as long as it is, beside the disc of the other one."""
        from camgeom.track.beside import Neighbour

        found = []
        for track, roller, own, k in zip(self.tracks, self.rollers, self._discs, (1, 0)):
            middle, half = 0.5 * sum(own), 0.5 * (roller.length or self.width)
            ends, name = (middle - half, middle + half), f"{track.name} roller to {self.tracks[k].name} disc"
            # Both change evenly along the axis: the nearest is at an end of where they stand beside each other.
            beside = sorted((max(ends[0], self._discs[k][0]), min(ends[1], self._discs[k][1])))
            sections = dict.fromkeys((self._radius(1 - k, z), self._outline(k, z)) for z in beside)
            found.append(Neighbour(name, track, ends, tuple(sections), self._discs[k]))
        return tuple(found)

    @property
    def conical(self) -> bool:
        """True where the flank of one of the discs leans."""
        return any(isinstance(roller, ConeRoller) for roller in self.rollers)

    def _radius(self, k: int, z: float) -> float:
        """Radius of the main (0) or the return (1) roller at a height, mm: of a crown at its crest."""
        if isinstance(self.rollers[k], ConeRoller):
            return float(self.tracks[k].meridian.jet(np.array([z]))[3][0])
        return 0.5 * self.rollers[k].diameter

    def _outline(self, k: int, z: float) -> RollerOutline:
        """The outline of the main (0) or the return (1) disc at a height, mm."""
        return RollerOutline(self.tracks[k], -self._radius(k, z))

    @property
    def prime_radius(self) -> float:
        """Distance of the main roller's centre from the cam axis at zero lift, mm."""
        return self.cam.base_radius + 0.5 * self.roller.diameter

    @property
    def return_prime(self) -> float:
        """That of the return roller's centre where its disc has the main base radius, mm."""
        return self.cam.base_radius + 0.5 * self.back.diameter

    @property
    def slide_return_radius(self) -> float:
        """Radius of the slide's return profile at zero lift, mm; the default makes equal rollers' discs mirror images.
        """
        if self.cam.return_radius is not None:
            return self.cam.return_radius
        e = self.follower.offset
        stroke = lift_range(self.program)[1]
        return sqrt((sqrt(self.prime_radius**2 - e**2) + stroke) ** 2 + e**2) - 0.5 * self.roller.diameter

    @property
    def return_arm(self) -> float:
        """Arm of the rocker's return roller, mm."""
        assert isinstance(self.follower, SwingingFollower)
        return self.cam.return_arm or self.follower.arm

    @property
    def angle_between(self) -> float:
        """Angle of the rocker from the main arm to the return arm, rad."""
        if self.cam.rocker_angle is not None:
            return radians(self.cam.rocker_angle)
        a, prime = self.cam.center_distance, self.prime_radius
        assert isinstance(self.follower, SwingingFollower)
        assert a is not None
        start = arm_angle(a, self.follower.arm, prime)
        return start + lift_range(self.program)[1] + arm_angle(a, self.return_arm, self.return_prime)

    @property
    def play(self) -> float:
        """By how much the follower is ahead where it touches the return disc, mm or rad (chord at the roller)."""
        if isinstance(self.follower, SwingingFollower):
            return 2.0 * asin(min(1.0, self.follower.clearance / (2.0 * self.return_arm)))
        return self.follower.clearance

    @cached_property
    def _mounts(self) -> tuple[Joint, Vector, Vector]:
        """The joint, and where the main and the return roller stand at zero lift."""
        follower, prime = self.follower, self.prime_radius
        if isinstance(follower, SwingingFollower):
            assert self.cam.center_distance is not None
            arm = Arm(self.cam.center_distance, follower.way)
            start = arm_angle(arm.centre, follower.arm, prime)
            back = start - self.angle_between
            return arm.joint, arm.point(follower.arm, start), arm.point(self.return_arm, back)
        e = follower.offset
        far = self.slide_return_radius + 0.5 * self.back.diameter
        return SLIDE, (sqrt(prime**2 - e**2), e, 0.0), (-sqrt(far**2 - e**2), e, 0.0)

    @cached_property
    def tracks(self) -> tuple[Track, ...]:
        """The main and the return roller."""
        joint, main, back = self._mounts
        low, high = self._heights
        # Each roller's free end faces the other disc: it reaches no further than its own.
        ends = zip(self.rollers, (low, high), (1.0, -1.0))
        first, second = (roller.meridian(0.5 * sum(z), tip) for roller, z, tip in ends)
        return (
            roller_track("main", self.program, self.sense, main, joint, first, low, tip_high=True),
            roller_track("return", self.program, self.sense, back, joint, second, high, shift=self.play),
        )

    @cached_property
    def outlines(self) -> dict[str, Outline]:
        """Profile and pitch curve of both discs by name."""
        pitch = {f"{track.name} pitch curve": RollerOutline(track, 0.0) for track in self.tracks}
        return {touch.where: touch.outline for touch in self.profiles} | pitch

    @cached_property
    def flanks(self) -> tuple[Loop, Loop]:
        """Of the main and the return disc."""
        main, back = (
            Loop(self._outline(k, low), "flank", self._outline(k, high) if isinstance(roller, ConeRoller) else None)
            for k, (roller, (low, high)) in enumerate(zip(self.rollers, self._discs))
        )
        return main, back

    @cached_property
    def envelope(self) -> tuple[float, float]:
        """Of both discs with the gap between them."""
        outlines = [outline for flank in self.flanks for outline in flank.ends]
        return plate_envelope(outlines, 2.0 * self.cam.width + self.cam.gap)

    @cached_property
    def profiles(self) -> tuple[Touch, ...]:
        """Both discs, of a cone's at either face: the main disc pushes towards larger lift, the return disc back."""
        joint, _, _ = self._mounts
        found = []
        for k, (track, flank, way, (low, high)) in enumerate(zip(self.tracks, self.flanks, (1.0, -1.0), self._heights)):
            for z, outline in zip(self._discs[k], flank.ends):
                roller, height = self.rollers[k], None if flank.upper is None else z
                lean = radians(roller.half_angle) if isinstance(roller, ConeRoller) else 0.0
                found.append(
                    Touch(track.name, outline, joint, self.sense, way, self._radius(k, z), high - low, lean=lean,
                          height=height)
                )  # fmt: skip
        return tuple(found)

    @property
    def touches(self) -> tuple[Touch, ...]:
        """The two contacts; none where a profile is not the same at every height."""
        return () if self.conical else self.profiles

    @cached_property
    def cutters(self) -> tuple[Track, ...]:
        """The tracks; of cones with tools as long as the discs are wide, which the rollers may leave bare."""
        each = zip(self.tracks, self.flanks, self._discs)
        return tuple(
            track if flank.upper is None else replace(track, contact=disc, tip=disc[int(track.tip_sign > 0.0)])
            for track, flank, disc in each
        )

    @property
    def passages(self) -> tuple[Track, ...]:
        """Cones as long as their discs are wide."""
        return self.cutters

    def within(self, x: Floats) -> Floats:
        """How far contact points (3, ...) lie between the faces of a disc, mm."""
        if not self.conical:
            return super().within(x)
        main, back = (np.minimum(x[2] - low, high - x[2]) for low, high in self._discs)
        return np.asarray(np.maximum(main, back) + 1e-9)

    @cached_property
    def walls(self) -> tuple[Wall, ...]:
        """Of both discs: the disc itself, profile to bore, phase mark to profile and to bore."""
        cam = self.cam
        found: list[Wall] = []
        mark = cam.mark_diameter, cam.mark_radius or 0.0, self.sense
        for name, flank in zip(("main", "return"), self.flanks):
            found.append(disc_wall(f"{name} disc", self.width))
            found += least_wall(flank, lambda outline, name=name: bore_walls(name, outline, self.bore))  # type: ignore[misc]
            found += least_wall(flank, lambda outline, name=name: mark_walls(name, outline, self.bore, *mark))  # type: ignore[misc]
        return tuple(found)

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """The main disc and the return disc, with bore and phase mark."""
        cam = self.cam
        marks = mark_loops(cam.mark_diameter, cam.mark_radius or 0.0, self.sense)
        return tuple(
            Prism(f"{track.name} disc", flank, *disc, marks, self.bore)
            for track, flank, disc in zip(self.tracks, self.flanks, self._discs)
        )
