"""End-face (bell) cam: the end of a ring is the profile; a roller stands on it and moves along the cam axis."""

from __future__ import annotations

from dataclasses import replace
from math import atan2, degrees, radians, sqrt
from typing import ClassVar, Literal, final

import numpy as np
from pydantic import Field

from camgeom.cams import NO_DRUM, NO_GAPS, ONE_WAY, SHARP, Cam, idle, keyway_idle, problem, sense_of
from camgeom.cams._axial import arc_problems, axial_idle, beside, heights, mount
from camgeom.cams._plate import bore_of, bore_problems
from camgeom.errors import Problem
from camgeom.immutable import immutable
from camgeom.keys import Gap, Length
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.solid import Part
from camgeom.solid.blank import Blank, Wall
from camgeom.solid.mechanism import Drive, Drum, Measure, Mechanism
from camgeom.track import TURN, Track, cone_slope
from camgeom.track.follower import (
    AnyRoller,
    ConeRoller,
    CrownedRoller,
    Setup,
    SphereRoller,
    SwingingFollower,
    TranslatingFollower,
)
from camgeom.track.runout import Within
from camgeom.track.section import Column, Level, cylinder_level

DEEPER = 0.98
"""share of the room inside the ring to which the tool reaches, so that its end leaves no mark"""
EDGE_SAMPLES = 1441


@final
class EndFace(Cam):
    """A ring on a web, 0 <= z; the roller reaches in radially from the +X side and stands on the ring's upper end."""

    FOLLOWERS: ClassVar[tuple[str, ...]] = ("translating", "swinging")
    STATIONS: ClassVar[bool] = True

    kind: Literal["end-face"]
    diameter: Length = Field(description="mm, outside diameter of the ring")
    inner_diameter: Length = Field(description="mm, inside diameter of the ring, above its web")
    height: Length = Field(description="mm, z of the end face under the middle of the roller at zero lift, in a dwell")
    web: Length = Field(description="mm, thickness of the web that closes the ring below, 0 <= z <= web")
    pitch_radius: Length | None = Field(
        None, description="mm, where the classical figures are quoted; default: middle of the contact length"
    )
    bore: Gap = Field(0.0, description="mm, bore diameter of the web; 0 leaves it solid")
    keyway_width: Gap = Field(0.0, description="mm; 0 leaves the keyway out")
    keyway_depth: Gap = Field(0.0, description="mm, from the bore wall")
    direction: Literal["ccw", "cw"] = Field("ccw", description="the cam's turning, seen from +Z")

    @property
    def radii(self) -> tuple[float, float]:
        """Inside and outside radius of the ring, mm."""
        return 0.5 * self.inner_diameter, 0.5 * self.diameter

    @property
    def middle(self) -> float:
        """Radius of the middle of the ring, where the middle of the roller stands, mm."""
        return 0.5 * sum(self.radii)

    def mechanism(self, setup: Setup) -> EndFaceMechanism:
        """The ring with its follower."""
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TranslatingFollower | SwingingFollower)
        assert roller is not None
        return EndFaceMechanism(
            follower=follower,
            roller=roller,
            program=setup.program,
            sense=sense_of(self.direction),
            drive=Drive.ALONE,
            width=self.height,
            bore=bore_of(self.bore, self.keyway_width, self.keyway_depth),
            outside_diameter=self.diameter,
            cam=self,
        )

    def idle(self, setup: Setup) -> dict[str, str]:
        """Keys of grooves, and of followers of planar cams."""
        follower = setup.follower
        assert isinstance(follower, TranslatingFollower | SwingingFollower)
        found = NO_DRUM | SHARP | NO_GAPS | ONE_WAY | keyway_idle(self.bore) | axial_idle(follower, "ring")
        return found | idle(
            "what a spring or weight holds on its cam has no play", "follower.clearance", "limits.play_mm"
        )

    def problems(self, setup: Setup) -> list[Problem]:
        """What cannot be built, with key, value and allowed range."""
        inner, outer = self.radii
        if inner >= outer:
            return [problem("cam.inner_diameter", self.inner_diameter, f"below the outside, {self.diameter:g} mm")]
        found = bore_problems(self.bore, self.keyway_width, self.keyway_depth, inner, "ring")
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TranslatingFollower | SwingingFollower)
        if roller is None:
            return [*found, Problem("roller", "an end-face cam needs a roller", None, "a [roller] table")]
        if isinstance(roller, SphereRoller):
            return [*found, problem("roller.shape", roller.shape, "cylinder, cone or crowned on an end face")]
        if isinstance(roller, CrownedRoller) and roller.flank != "straight":
            limit = "straight: an end face is wider than the roller, whose crown would have to be cut beside it too"
            found.append(problem("roller.flank", roller.flank, limit))
        if roller.length > outer - inner:
            limit = f"at most the width of the ring, {outer - inner:g} mm"
            found.append(problem("roller.length", roller.length, limit))
        low, high = self.contact(roller)
        if self.pitch_radius is not None and not low <= self.pitch_radius <= high:
            limit = f"{low:g} .. {high:g} mm, where the roller touches"
            found.append(problem("cam.pitch_radius", self.pitch_radius, limit))
        lowest = self.height + float(heights(follower, setup.program).min())
        if self.web >= lowest:
            limit = f"below the lowest place of the end face, {lowest:.6g} mm"
            found.append(problem("cam.web", self.web, limit))
        if aside := arc_problems(setup, inner):
            return [*found, *aside]
        if isinstance(roller, ConeRoller):
            least = degrees(atan2(0.5 * roller.diameter, 0.5 * (outer - inner)))
            if abs(roller.half_angle) >= least:
                limit = f"less than {least:.6g} deg either way: beyond, the cone comes to its point over the ring"
                return [*found, problem("roller.half_angle", roller.half_angle, limit)]
        reach = beside(follower, setup.program) + self.roller_radius(roller, inner)
        if reach >= inner:
            limit = f"above {2.0 * reach:.6g} mm, so that the roller meets the inside of the ring at every slope"
            found.append(problem("cam.inner_diameter", self.inner_diameter, limit))
        return found

    def contact(self, roller: AnyRoller) -> tuple[float, float]:
        """Radial stretch of a roller that touches the ring, mm: its middle stands on the middle of the ring."""
        half = 0.5 * (roller.length or 0.0)
        return self.middle - half, self.middle + half

    def roller_radius(self, roller: AnyRoller, place: float) -> float:
        """Radius of the roller, or of what is left of its cone beside it, at a place along its axis, mm."""
        slope = cone_slope(radians(roller.half_angle), -1.0) if isinstance(roller, ConeRoller) else 0.0
        return 0.5 * roller.diameter + slope * (place - self.middle)


@final
@immutable(kw_only=True)
class EndFaceMechanism(Mechanism):
    """A ring and its follower."""

    follower: TranslatingFollower | SwingingFollower
    roller: AnyRoller
    cam: EndFace

    @property
    def contact(self) -> tuple[float, float]:
        """See `EndFace.contact`."""
        return self.cam.contact(self.roller)

    @property
    def quoted_radius(self) -> float:
        """Where the classical figures are quoted, mm."""
        return self.cam.pitch_radius or self.cam.middle

    @cached_property
    def tracks(self) -> tuple[Track, ...]:
        """The roller on the ring."""
        low, high = self.contact
        # u x v points towards smaller z where the cam turns counter-clockwise: what is below a roller is on that side.
        centre = self.cam.height + 0.5 * self.roller.diameter
        anchor, joint, shift = mount(self.follower, self.program, centre)
        return (
            Track(
                meridian=self.roller.meridian(self.cam.middle, -1.0),
                joint=joint,
                anchor=anchor,
                axis=(1.0, 0.0, 0.0),
                tip=low,
                contact=(low, high),
                program=self.program,
                sense=self.sense,
                shift=shift,
                name="end face",
                sides=(self.sense,),
            ),
        )

    @cached_property
    def cutters(self) -> tuple[Track, ...]:
        """The track with a tool that reaches through the ring."""
        (track,) = map(self.cutting, self.tracks)
        inner = self.cam.radii[0]
        aside = beside(self.follower, self.program) + self.cam.roller_radius(self.roller, inner)
        return (replace(track, tip=DEEPER * sqrt(inner * inner - aside * aside)),)

    @property
    def passages(self) -> tuple[Track, ...]:
        """The roller as wide as the ring, which it may leave bare on either side."""
        (cutter,) = self.cutters
        return (replace(cutter, contact=(cutter.tip, self.cam.radii[1])),)

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """The ring with its web, meshed directly."""
        from camgeom.solid.drum import EndFaceRing

        (track,) = self.cutters
        return (EndFaceRing("cam", track, self.blank, *self.cam.radii, self.cam.web),)

    @property
    def blank(self) -> Blank:
        """What the end face is cut from: a ring as high as the face gets, on its web; here as a full cylinder."""
        return Blank.cylinder(self.cam.radii[1], self._top, self.bore)

    @cached_property
    def _top(self) -> float:
        """Height of the highest place of the end face, mm."""
        return float(max(edge[2].max() for edge in self._edges))

    @cached_property
    def _edges(self) -> tuple[Floats, Floats]:
        """The inner and the outer edge of the end face at the samples of a turn, (3, n) each, mm."""
        (track,) = self.cutters
        phi = np.unique(np.concatenate([np.linspace(0.0, TURN, EDGE_SAMPLES), self.program.knots]))
        column, (side,) = Column(track, phi), track.sides
        inner, outer = (
            column.wall(side, column.reach(side, cylinder_level(radius), radius))[:, :, 0] for radius in self.cam.radii
        )
        return inner, outer

    @property
    def measures(self) -> tuple[Measure, ...]:
        """The inside of the ring at its highest place, and the thickness of the web below it."""
        inner, outer = self.cam.radii
        return Measure((self._top, -inner), (self._top, inner)), Measure((0.0, outer), (self.cam.web, outer))

    @property
    def bored(self) -> tuple[float, float]:
        """Through the web."""
        return 0.0, self.cam.web

    @property
    def envelope(self) -> tuple[float, float]:
        """Of the ring with its web."""
        return self.cam.diameter, self._top

    @property
    def drum(self) -> Drum:
        """The outside of the ring, as high as the roller gets."""
        rise = float(heights(self.follower, self.program).max())
        return Drum(self.cam.radii[1], self.cam.web, self.cam.height + rise + self.roller.diameter)

    @property
    def beside(self) -> Within:
        """How far within the ring contact points lie: where it is steep the roller's outer end stands beyond it."""
        return self.within

    def within(self, x: Floats) -> Floats:
        """How far contact points (3, ...) lie between the inside and the outside of the ring, mm."""
        inner, outer = self.cam.radii
        rho = np.sqrt(x[0] * x[0] + x[1] * x[1])
        return np.asarray(np.minimum(rho - inner, outer - rho) + 1e-9)

    @property
    def wall_foot(self) -> tuple[Level, float]:
        """The inside of the ring, where the end face ends."""
        inner = self.cam.radii[0]
        return cylinder_level(inner), inner

    @property
    def wall_top(self) -> tuple[Level, float]:
        """The outside of the ring."""
        outer = self.cam.radii[1]
        return cylinder_level(outer), outer

    @cached_property
    def walls(self) -> tuple[Wall, ...]:
        """The ring, its web, and what of the ring stands above the web at its lowest place."""
        inner, outer = self.cam.radii
        edge = self._edges[0]
        low = int(np.argmin(edge[2]))
        angle = float(-self.sense * np.arctan2(edge[1, low], edge[0, low]) % TURN)
        ledge = inner - self.bore.reach if self.bore is not None else None
        return (
            *(() if ledge is None else (Wall("web, bore to ring", ledge, None, "a smaller cam.bore"),)),
            Wall("ring, inside to outside", outer - inner, None, "a smaller cam.inner_diameter or a larger diameter"),
            Wall("web", self.cam.web, None, "a thicker cam.web"),
            Wall("end face to web", float(edge[2, low]) - self.cam.web, angle, "a greater cam.height or a thinner web"),
        )
