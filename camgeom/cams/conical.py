"""Conical drum cam: a groove in a cone; the follower slides along the cone's generator, its roller square to it."""

from __future__ import annotations

from dataclasses import replace
from math import cos, radians, sin, tan
from typing import Annotated, ClassVar, Literal, final

import numpy as np
from pydantic import Field

from camgeom.cams import NO_GAPS, NO_LAYERS, NO_RIB, Cam, idle, keyway_idle, problem, root_problems, sense_of
from camgeom.cams._axial import axial_idle, ball_problems, grooved_contact, too_long
from camgeom.cams._plate import bore_of, bore_problems
from camgeom.errors import Problem
from camgeom.immutable import immutable
from camgeom.keys import Clearance, Gap, Length
from camgeom.maths.frozen import cached_property
from camgeom.motion.program import Program
from camgeom.solid import Part
from camgeom.solid.blank import Blank, Wall
from camgeom.solid.mechanism import Drive, Drum, Measure, Mechanism
from camgeom.track import Slide, Track
from camgeom.track.column import Level, outside_level
from camgeom.track.follower import AnyRoller, Setup, SphereRoller, TranslatingFollower
from camgeom.track.runout import Within

STEEPEST = 85.0
"""deg; a steeper cone is a disc with a groove in its face"""


@final
class Conical(Cam):
    """A cone 0 <= z <= length with one groove; the roller reaches in square to the cone from the +X side.

    Places along the roller count from the cone's surface, which stands at half of `diameter`.
    """

    FOLLOWERS: ClassVar[tuple[str, ...]] = ("translating",)
    MOST_PIECES: ClassVar[int] = 2_000
    MOST_STEPPED: ClassVar[int] = 1_000
    STATIONS: ClassVar[bool] = True

    kind: Literal["conical"]
    diameter: Length = Field(description="mm, outside diameter at the lower end, z = 0")
    half_angle: Annotated[float, Field(ge=-STEEPEST, le=STEEPEST)] = Field(
        description="deg, between the cam axis and the cone's generator; positive narrows towards z = length"
    )
    length: Length = Field(description="mm, length of the cone along its axis")
    start: Annotated[float, Field(ge=-1e5, le=1e5)] = Field(
        description="mm, from the lower end along the generator to the roller's axis at zero lift; the lift goes on "
        "along the generator"
    )
    groove_depth: Length = Field(description="mm, from the outer surface, square to it")
    bore: Gap = Field(0.0, description="mm, bore diameter; 0 leaves the cone solid")
    keyway_width: Gap = Field(0.0, description="mm; 0 leaves the keyway out")
    keyway_depth: Gap = Field(0.0, description="mm, from the bore wall")
    running_clearance: Clearance = Field(0.0, description="mm, normal gap between roller and each flank")
    root_radius: Gap = Field(
        0.0, description="mm, of the root between flank and floor, that of the tool's corner where there is no "
        "[cutter] corner_radius"
    )
    direction: Literal["ccw", "cw"] = Field("ccw", description="the cam's turning, seen from +Z")

    @property
    def radius(self) -> float:
        """Outer radius at the lower end, mm."""
        return 0.5 * self.diameter

    @property
    def lean(self) -> float:
        """The half angle, rad."""
        return radians(self.half_angle)

    @property
    def slope(self) -> float:
        """By which the radius falls per mm of height."""
        return tan(self.lean)

    @property
    def upper_radius(self) -> float:
        """Outer radius at the upper end, mm."""
        return self.radius - self.slope * self.length

    @property
    def floor(self) -> float:
        """Place of the groove's floor along the roller, mm."""
        return self.radius - self.groove_depth

    def mechanism(self, setup: Setup) -> ConicalMechanism:
        """The cone with its follower."""
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TranslatingFollower)
        assert roller is not None
        return ConicalMechanism(
            follower=follower,
            roller=roller,
            program=setup.program,
            sense=sense_of(self.direction),
            drive=Drive.OPPOSED,
            width=self.length,
            bore=bore_of(self.bore, self.keyway_width, self.keyway_depth),
            outside_diameter=2.0 * max(self.radius, self.upper_radius),
            running_clearance=self.running_clearance,
            root_radius=setup.corner or self.root_radius,
            cam=self,
        )

    def idle(self, setup: Setup) -> dict[str, str]:
        """Keys of ribs, of other followers, and of what a groove's roller does not do."""
        follower = setup.follower
        assert isinstance(follower, TranslatingFollower)
        found = keyway_idle(self.bore) | NO_RIB | NO_LAYERS
        found |= NO_GAPS if isinstance(setup.roller, SphereRoller) else {}
        found |= idle("the play in a drum's groove is one for the chord and the normal", "impact.clearance_kind")
        found |= idle("the roller in a drum's groove does not turn in this solver", "impact.roller_inertia")
        found |= idle("a drum's follower has none; give cam.running_clearance", "follower.clearance")
        return found | axial_idle(follower, "cone")

    def problems(self, setup: Setup) -> list[Problem]:
        """What cannot be built, with key, value and allowed range."""
        roller, depth = setup.roller, self.groove_depth
        if roller is None:
            return [Problem("roller", "a conical cam needs a roller", None, "a [roller] table")]
        found = ball_problems(roller, depth) if isinstance(roller, SphereRoller) else too_long(roller, depth)
        if self.upper_radius <= 0.0:
            steepest = np.degrees(np.arctan2(self.radius, self.length))
            limit = f"below {steepest:.6g} deg: the cone comes to its point within its length of {self.length:g} mm"
            return [*found, problem("cam.half_angle", self.half_angle, limit)]
        if found := [*found, *root_problems(setup, self.root_radius, depth)]:
            return found
        if found := self._start_problems(roller, setup.program):
            return found
        least = self.least_floor(roller, setup.program)
        if least <= 0.0:
            most = depth + least / cos(self.lean)
            return [problem("cam.groove_depth", depth, f"below {most:.6g} mm: beyond, the floor reaches the cam axis")]
        return bore_problems(self.bore, self.keyway_width, self.keyway_depth, least, "groove floor")

    def reach(self, roller: AnyRoller) -> tuple[float, float]:
        """Radius of the tool at the cone's surface and at the floor, mm; of a ball that of its equator, and none."""
        gap = self.running_clearance
        if isinstance(roller, SphereRoller):
            return 0.5 * roller.diameter + gap, 0.0
        meridian = roller.meridian(0.5 * sum(self.contact(roller)), -1.0).grown(gap)
        ends = np.array([meridian.parameter(place) for place in (self.radius, self.floor)])
        top, tip = (float(r) for r in meridian.jet(ends)[3])
        return top, tip

    def _start_problems(self, roller: AnyRoller, program: Program) -> list[Problem]:
        """The groove has to stay within both ends of the cone, at its edge and at its foot, which leans aside."""
        lifts = [float(end.value) for end in program.extremes(0)]
        (top, tip), aside = self.reach(roller), self.groove_depth * self.slope
        low = max(top, tip + aside) - min(lifts)
        high = self.length / cos(self.lean) - max(top, tip - aside) - max(lifts)
        if low < self.start < high:
            return []
        if low < high:
            limit = f"{low:.6g} .. {high:.6g} mm, where the groove stays within both ends of the cone"
            return [problem("cam.start", self.start, limit)]
        need = self.length + (low - high) * cos(self.lean)
        return [problem("cam.length", self.length, f"above {need:.6g} mm, so that the groove stays within both ends")]

    def least_floor(self, roller: AnyRoller, program: Program) -> float:
        """Least radius of the groove's floor, mm."""
        lifts = [float(end.value) for end in program.extremes(0)]
        tip = self.reach(roller)[1]
        depth = self.groove_depth + (self.running_clearance if isinstance(roller, SphereRoller) else 0.0)
        way = max(lifts) + tip if self.slope > 0.0 else min(lifts) - tip
        return self.radius - (self.start + way) * sin(self.lean) - depth * cos(self.lean)

    def contact(self, roller: AnyRoller) -> tuple[float, float]:
        """Stretch of a roller that touches the flank, mm along it; the cone's surface is at half of `diameter`."""
        return grooved_contact(roller, self.radius, self.groove_depth)


@final
@immutable(kw_only=True)
class ConicalMechanism(Mechanism):
    """A cone and its follower."""

    follower: TranslatingFollower
    roller: AnyRoller
    cam: Conical

    @property
    def drum(self) -> Drum:
        """The cone from z = 0 up."""
        cam = self.cam
        return Drum(cam.radius, 0.0, cam.length, cam.groove_depth, cam.slope)

    @property
    def beside(self) -> Within:
        """How deep contact points lie in the cone: where it is steep the roller's outer end stands beyond the land."""
        return self.drum.under

    @property
    def envelope(self) -> tuple[float, float]:
        """Of the blank."""
        return self.blank.envelope

    @property
    def blank(self) -> Blank:
        """The cone before the groove is cut."""
        cam = self.cam
        return Blank(((cam.radius, 0.0), (cam.upper_radius, cam.length)), self.bore, (None,), ("land",))

    @property
    def measures(self) -> tuple[Measure, ...]:
        """The diameter of the narrower end."""
        cam = self.cam
        r, z = min((cam.radius, 0.0), (cam.upper_radius, cam.length))
        return (Measure((z, -r), (z, r)),)

    @property
    def contact(self) -> tuple[float, float]:
        """See `Conical.contact`."""
        return self.cam.contact(self.roller)

    @property
    def quoted_radius(self) -> float:
        """The middle of the contact length, mm along the roller."""
        return 0.5 * sum(self.contact)

    @cached_property
    def tracks(self) -> tuple[Track, ...]:
        """The roller in its groove."""
        cam, ball = self.cam, isinstance(self.roller, SphereRoller)
        low, high = self.contact
        centre = cam.floor + 0.5 * self.roller.diameter if ball else 0.5 * (low + high)
        c, s = cos(cam.lean), sin(cam.lean)
        on = cam.radius - cam.start * s, cam.start * c
        return (
            Track(
                meridian=self.roller.meridian(centre, -1.0),
                joint=Slide((-s, 0.0, c)),
                anchor=(on[0] - cam.radius * c, 0.0, on[1] - cam.radius * s),
                axis=(c, 0.0, s),
                tip=centre - 0.5 * self.roller.diameter if ball else low,
                contact=(low, high),
                program=self.program,
                sense=self.sense,
            ),
        )

    @cached_property
    def cutters(self) -> tuple[Track, ...]:
        """The track with the tool that cuts: larger by the running clearance, down to the groove floor."""
        cam, (track,) = self.cam, self.tracks
        tip = track.tip - cam.running_clearance if isinstance(self.roller, SphereRoller) else cam.floor
        return (replace(self.cutting(track).grown(cam.running_clearance), tip=tip, root=self.root_radius),)

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """The cone with its groove, meshed directly."""
        from camgeom.solid.drum import GroovedCylinder

        (track,), cam = self.cutters, self.cam
        return (GroovedCylinder("cam", track, self.blank, cam.radius, cam.length, cam.slope),)

    @property
    def wall_top(self) -> tuple[Level, float]:
        """The cone's outside."""
        return outside_level(self.cam.radius, self.cam.slope), self.cam.radius

    @property
    def floor_gap(self) -> float | None:
        """From the roller's end to the floor, square to both, mm; a ball touches its groove at the bottom too."""
        return None if isinstance(self.roller, SphereRoller) else self.contact[0] - self.cam.floor

    @cached_property
    def walls(self) -> tuple[Wall, ...]:
        """Thinnest walls of the cone: to the ends, between passes of the groove, and to the bore."""
        from camgeom.solid.drum import GroovedCylinder, cone_walls

        (ring,) = self.parts
        assert isinstance(ring, GroovedCylinder)
        return tuple(cone_walls(ring, self.cam.least_floor(self.roller, self.program)))
