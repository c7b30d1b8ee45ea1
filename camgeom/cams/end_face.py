"""End-face (bell) cam: a roller stands on the end of a ring, or reaches out into a groove in the ring's inside, and
moves along the cam axis."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace
from math import atan2, degrees, radians, sqrt
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, final

import numpy as np
from pydantic import Field

from camgeom.cams import NO_DRUM, NO_GAPS, ONE_WAY, SHARP, Cam, idle, keyway_idle, problem, sense_of
from camgeom.cams._axial import arc_problems, axial_idle, axial_track, beside, heights, too_long
from camgeom.cams._plate import bore_of, bore_problems
from camgeom.errors import Problem
from camgeom.immutable import immutable
from camgeom.keys import Clearance, Gap, Length
from camgeom.maths import Floats, distinct
from camgeom.maths.frozen import cached_property
from camgeom.solid import Part
from camgeom.solid.blank import Blank, Wall
from camgeom.solid.mechanism import Carrier, Drive, Drum, Measure, Mechanism
from camgeom.track import TURN, Arc, Meridian, Track, cone_slope
from camgeom.track.column import Column, Level, cylinder_level
from camgeom.track.follower import (
    AnyRoller,
    ConeRoller,
    CrownedRoller,
    CylinderRoller,
    Setup,
    SphereRoller,
    SwingingFollower,
    TranslatingFollower,
)
from camgeom.track.runout import Within

if TYPE_CHECKING:
    from camgeom.solid.bell import GroovedRing

DEEPER = 0.98
"""share of the room inside the ring to which the tool reaches, so that its end leaves no mark"""
EDGE_SAMPLES = 1441


NO_RING = "stress at a root is solved in rings, and a ring grooved inside is filled with tetrahedra, too coarse for it"
GROOVE = ("length", "start", "groove_depth")
"""keys that the groove form needs"""
MAY_HAVE = "running_clearance", "carrier_diameter"
"""further keys of the groove form"""


@final
class EndFace(Cam):
    """A ring on a web, 0 <= z. The roller stands at +X: it reaches in and stands on the ring's upper end, or it reaches
    out from within into a groove in the ring's inside.

    What carries a roller within the ring is a bar about the roller's axis, `carrier_diameter` thick, held from over
    the ring's upper end.
    """

    FOLLOWERS: ClassVar[tuple[str, ...]] = ("translating", "swinging")
    STATIONS: ClassVar[bool] = True

    kind: Literal["end-face"]
    form: Literal["end", "groove"] = Field(
        "end", description="the ring's end, on which a spring or weight holds the roller, or a groove in its inside, "
        "whose two walls drive the roller both ways"
    )
    diameter: Length = Field(description="mm, outside diameter of the ring")
    inner_diameter: Length = Field(description="mm, inside diameter of the ring, above its web")
    height: Length | None = Field(
        None, description="mm, end form: z of the end face under the middle of the roller at zero lift, in a dwell"
    )
    length: Length | None = Field(None, description="mm, groove form: z of the ring's upper end")
    start: Annotated[float, Field(ge=-1e5, le=1e5)] | None = Field(
        None, description="mm, groove form: z of the roller's centre at zero lift"
    )
    groove_depth: Length | None = Field(
        None, description="mm, groove form: from the inside of the ring outward to the floor, a cylinder about the axis"
    )
    web: Length = Field(description="mm, thickness of the web that closes the ring below, 0 <= z <= web")
    pitch_radius: Length | None = Field(
        None, description="mm, where the classical figures are quoted; default: middle of the contact length"
    )
    bore: Gap = Field(0.0, description="mm, bore diameter of the web; 0 leaves it solid")
    keyway_width: Gap = Field(0.0, description="mm; 0 leaves the keyway out")
    keyway_depth: Gap = Field(0.0, description="mm, from the bore wall")
    running_clearance: Clearance = Field(
        0.0, description="mm, groove form: normal gap between roller and each flank"
    )
    carrier_diameter: Length | None = Field(
        None, description="mm, groove form: of the bar about the roller's axis that carries it within the ring; it has "
        "to clear the web"
    )
    direction: Literal["ccw", "cw"] = Field("ccw", description="the cam's turning, seen from +Z")

    @property
    def radii(self) -> tuple[float, float]:
        """Inside and outside radius of the ring, mm."""
        return 0.5 * self.inner_diameter, 0.5 * self.diameter

    @property
    def middle(self) -> float:
        """Radius of the middle of the ring, where the middle of the roller stands on its end, mm."""
        return 0.5 * sum(self.radii)

    @property
    def floor(self) -> float:
        """Radius of the groove's floor, mm; of the inside where there is none."""
        return self.radii[0] + (self.groove_depth or 0.0)

    @property
    def stand(self) -> float:
        """Height z at zero lift, mm, of the end face or of the roller's centre in its groove."""
        return (self.height if self.form == "end" else self.start) or 0.0

    def mechanism(self, setup: Setup) -> EndFaceMechanism | BellMechanism:
        """The ring with its follower."""
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TranslatingFollower | SwingingFollower)
        assert roller is not None
        bore = bore_of(self.bore, self.keyway_width, self.keyway_depth)
        sense = sense_of(self.direction)
        if self.form == "groove":
            return BellMechanism(
                follower=follower,
                roller=roller,
                program=setup.program,
                sense=sense,
                drive=Drive.OPPOSED,
                width=self.length or 0.0,
                form=self.form,
                bore=bore,
                outside_diameter=self.diameter,
                running_clearance=self.running_clearance,
                cam=self,
            )
        return EndFaceMechanism(
            follower=follower,
            roller=roller,
            program=setup.program,
            sense=sense,
            drive=Drive.ALONE,
            width=self.stand,
            bore=bore,
            outside_diameter=self.diameter,
            cam=self,
        )

    def idle(self, setup: Setup) -> dict[str, str]:
        """Keys of the other form, and of followers of planar cams."""
        follower = setup.follower
        assert isinstance(follower, TranslatingFollower | SwingingFollower)
        found = NO_DRUM | SHARP | keyway_idle(self.bore) | axial_idle(follower, "ring")
        if self.form == "groove":
            found |= idle("form = 'groove' has `length`, to the ring's end, and `start`, to the roller", "cam.height")
            found |= idle(NO_RING, "material.cam.bending_limit")
            found |= idle("the play in a groove is one for the chord and the normal", "impact.clearance_kind")
            found |= idle("the roller in a groove does not turn in this solver", "impact.roller_inertia")
            return found | idle("a groove's follower has none; give cam.running_clearance", "follower.clearance")
        keys = *GROOVE, *MAY_HAVE
        found |= NO_GAPS | ONE_WAY | idle("only form = 'groove' has it", *(f"cam.{key}" for key in keys))
        return found | idle(
            "what a spring or weight holds on its cam has no play", "follower.clearance", "limits.play_mm"
        )

    def problems(self, setup: Setup) -> list[Problem]:
        """What cannot be built, with key, value and allowed range."""
        inner, outer = self.radii
        if inner >= outer:
            return [problem("cam.inner_diameter", self.inner_diameter, f"below the outside, {self.diameter:g} mm")]
        needed = GROOVE if self.form == "groove" else ("height",)
        missing = [key for key in needed if getattr(self, key) is None]
        if missing:
            return [Problem(f"cam.{key}", "missing", None, f"a length in mm, for form = {self.form!r}")
                    for key in missing]  # fmt: skip
        found = bore_problems(self.bore, self.keyway_width, self.keyway_depth, inner, "ring")
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TranslatingFollower | SwingingFollower)
        if roller is None:
            return [*found, Problem("roller", "an end-face cam needs a roller", None, "a [roller] table")]
        if isinstance(roller, SphereRoller):
            return [*found, problem("roller.shape", roller.shape, "cylinder, cone or crowned on a bell")]
        if isinstance(roller, CrownedRoller) and roller.flank != "straight":
            limit = "straight: an end face is wider than the roller, whose crown would have to be cut beside it too"
            found.append(problem("roller.flank", roller.flank, limit))
        low, high = self.contact(roller)
        if self.pitch_radius is not None and not low <= self.pitch_radius <= high:
            limit = f"{low:g} .. {high:g} mm, where the roller touches"
            found.append(problem("cam.pitch_radius", self.pitch_radius, limit))
        if self.form == "groove":
            return [*found, *self._groove_problems(setup, roller)]
        if roller.length > outer - inner:
            limit = f"at most the width of the ring, {outer - inner:g} mm"
            found.append(problem("roller.length", roller.length, limit))
        lowest = self.stand + float(heights(follower, setup.program).min())
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

    def _groove_problems(self, setup: Setup, roller: AnyRoller) -> list[Problem]:
        """The groove has to stay in the ring, and the whole of the roller's end within its floor."""
        inner, outer = self.radii
        depth, length = self.groove_depth or 0.0, self.length or 0.0
        if self.web >= length:
            return [problem("cam.web", self.web, f"below the length of the ring, {length:g} mm")]
        if self.floor >= outer:
            return [problem("cam.groove_depth", depth, f"below the ring's thickness, {outer - inner:g} mm")]
        if found := [*too_long(roller, depth), *arc_problems(setup, inner)]:
            return found
        if isinstance(roller, ConeRoller):
            if roller.half_angle < 0.0:
                limit = "0 or more: a cone that widens towards its free end cannot be put into the ring's groove"
                return [problem("roller.half_angle", roller.half_angle, limit)]
            most = degrees(atan2(0.5 * roller.diameter, self.floor - 0.5 * sum(self.contact(roller))))
            if roller.half_angle >= most:
                limit = f"less than {most:.6g} deg: beyond, the cone comes to its point within the groove"
                return [problem("roller.half_angle", roller.half_angle, limit)]
        follower = setup.follower
        assert isinstance(follower, TranslatingFollower | SwingingFollower)
        aside = beside(follower, setup.program)
        mouth, end = (self.tool_radius(roller, place) for place in self.contact(roller))
        if aside + mouth >= inner:
            limit = f"above {2.0 * (aside + mouth):.6g} mm, so that the roller stands within the ring"
            return [problem("cam.inner_diameter", self.inner_diameter, limit)]
        if self.carrier_diameter is not None and aside + 0.5 * self.carrier_diameter >= inner:
            limit = f"below {2.0 * (inner - aside):.6g} mm, so that the carrier stands within the ring"
            return [problem("cam.carrier_diameter", self.carrier_diameter, limit)]
        tip = self.tip(roller, aside)
        if self.contact(roller)[1] > tip:
            # At zero length the end is as wide as the mouth.
            if (most := tip - inner) > 0.0:
                limit = f"at most {most:.6g} mm: beyond, the edge of its flat end meets the floor, which is hollow"
                return [problem("roller.length", roller.length, limit)]
            least = sqrt(inner**2 + (aside + end) ** 2) - inner
            return [problem("cam.groove_depth", depth, f"above {least:.6g} mm, so that the roller's flat end has room")]
        lifts = heights(follower, setup.program)
        wide = max(mouth, self.tool_radius(roller, sqrt(inner**2 - (aside + mouth) ** 2)) if aside else mouth)
        lowest, highest = self.web + wide - float(lifts.min()), length - wide - float(lifts.max())
        if lowest < self.stand < highest:
            return []
        if lowest < highest:
            limit = f"{lowest:.6g} .. {highest:.6g} mm, where the groove stays between the web and the ring's end"
            return [problem("cam.start", self.stand, limit)]
        limit = f"above {length + lowest - highest:.6g} mm, so that the groove stays between the web and the ring's end"
        return [problem("cam.length", length, limit)]

    def tool_radius(self, roller: AnyRoller, place: float) -> float:
        """Radius of the tool that cuts the groove at a place along its axis, mm; a crown runs on a straight flank."""
        meridian = roller.meridian(0.5 * sum(self.contact(roller)), 1.0).grown(self.running_clearance)
        slope = 0.0 if isinstance(meridian, Arc) else meridian.slope
        return meridian.radius + slope * (place - meridian.centre)

    def tip(self, roller: AnyRoller, aside: float) -> float:
        """Place along the roller beyond which the edge of the tool's flat end would cut deeper than the floor, mm.

        aside  how far the roller's axis stands from the plane through the cam axis, at most, mm
        """
        edge = aside + self.tool_radius(roller, self.contact(roller)[1])
        return sqrt(max(0.0, self.floor**2 - edge**2))

    def contact(self, roller: AnyRoller) -> tuple[float, float]:
        """Radial stretch of a roller that touches the ring, mm: its middle stands on the middle of the ring's end; in a
        groove it begins at the ring's inside."""
        if self.form == "groove":
            return self.radii[0], self.radii[0] + (roller.length or 0.0)
        half = 0.5 * (roller.length or 0.0)
        return self.middle - half, self.middle + half

    def roller_radius(self, roller: AnyRoller, place: float) -> float:
        """Radius of the roller, or of what is left of its cone beside it, at a place along its axis, mm."""
        slope = cone_slope(radians(roller.half_angle), -1.0) if isinstance(roller, ConeRoller) else 0.0
        return 0.5 * roller.diameter + slope * (place - self.middle)


@immutable(kw_only=True)
class RingMechanism(Mechanism):
    """A ring on its web with a follower, whatever of it the roller runs on."""

    follower: TranslatingFollower | SwingingFollower
    roller: AnyRoller
    cam: EndFace

    @property
    @abstractmethod
    def top(self) -> float:
        """Height of the ring's highest place, mm."""

    @property
    def contact(self) -> tuple[float, float]:
        """See `EndFace.contact`."""
        return self.cam.contact(self.roller)

    @property
    def quoted_radius(self) -> float:
        """Where the classical figures are quoted, mm."""
        return self.cam.pitch_radius or 0.5 * sum(self.contact)

    def mounted(self, meridian: Meridian, tip: float, height: float, name: str, sides: tuple[float, ...]) -> Track:
        """The roller's track, its axis at `height` at zero lift, mm."""
        return axial_track(self, self.follower, meridian, self.contact, tip, height, name, sides)

    @property
    def aside(self) -> float:
        """How far the roller's axis stands from the plane through the cam axis, at most, mm."""
        return beside(self.follower, self.program)

    @property
    def blank(self) -> Blank:
        """What holds the ring and its web; here as a full cylinder."""
        return Blank.cylinder(self.cam.radii[1], self.top, self.bore)

    @property
    def measures(self) -> tuple[Measure, ...]:
        """The inside of the ring, told at its highest place, and the thickness of the web."""
        inner, outer = self.cam.radii
        return Measure((self.top, -inner), (self.top, inner)), Measure((0.0, outer), (self.cam.web, outer))

    @property
    def bored(self) -> tuple[float, float]:
        """Through the web."""
        return 0.0, self.cam.web

    @property
    def envelope(self) -> tuple[float, float]:
        """Of the ring with its web."""
        return self.cam.diameter, self.top

    @property
    def web_walls(self) -> list[Wall]:
        """The web, and what of it is left about its bore."""
        ledge = [] if self.bore is None else [
            Wall("web, bore to ring", self.cam.radii[0] - self.bore.reach, None, "a smaller cam.bore")
        ]
        return [*ledge, Wall("web", self.cam.web, None, "a thicker cam.web")]


@final
@immutable(kw_only=True)
class EndFaceMechanism(RingMechanism):
    """A ring with a follower on its end."""

    @cached_property
    def tracks(self) -> tuple[Track, ...]:
        """The roller on the ring."""
        # u x v points towards smaller z where the cam turns counter-clockwise: what is below a roller is on that side.
        centre, meridian = self.cam.stand + 0.5 * self.roller.diameter, self.roller.meridian(self.cam.middle, -1.0)
        return (self.mounted(meridian, self.contact[0], centre, "end face", (self.sense,)),)

    @cached_property
    def cutters(self) -> tuple[Track, ...]:
        """The track with a tool that reaches through the ring, whose whole face it cuts."""
        (track,) = map(self.cutting, self.tracks)
        inner = self.cam.radii[0]
        aside = self.aside + self.cam.roller_radius(self.roller, inner)
        tip = DEEPER * sqrt(inner * inner - aside * aside)
        return (replace(track, tip=tip, contact=(track.contact[0], self.cam.radii[1])),)

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

    @cached_property
    def top(self) -> float:
        """Height of the highest place of the end face, mm."""
        return float(max(edge[2].max() for edge in self._edges))

    @cached_property
    def _edges(self) -> tuple[Floats, Floats]:
        """The inner and the outer edge of the end face at the samples of a turn, (3, n) each, mm."""
        (track,) = self.cutters
        phi = distinct(np.concatenate([np.linspace(0.0, TURN, EDGE_SAMPLES), self.program.knots]))
        column, (side,) = Column(track, phi), track.sides
        inner, outer = (
            column.wall(side, column.reach(side, cylinder_level(radius), radius))[:, :, 0] for radius in self.cam.radii
        )
        return inner, outer

    @property
    def drum(self) -> Drum:
        """The outside of the ring, as high as the roller gets."""
        rise = float(heights(self.follower, self.program).max())
        return Drum(self.cam.radii[1], self.cam.web, self.cam.stand + rise + self.roller.diameter)

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
        *ledge, web = self.web_walls
        return (
            *ledge,
            Wall("ring, inside to outside", outer - inner, None, "a smaller cam.inner_diameter or a larger diameter"),
            web,
            Wall("end face to web", float(edge[2, low]) - self.cam.web, angle, "a greater cam.height or a thinner web"),
        )


@final
@immutable(kw_only=True)
class BellMechanism(RingMechanism):
    """A ring with a follower in a groove of its inside."""

    @property
    def classical(self) -> bool:
        """A cylindrical roller on a slide, in a groove."""
        return isinstance(self.roller, CylinderRoller) and isinstance(self.follower, TranslatingFollower)

    @cached_property
    def tracks(self) -> tuple[Track, ...]:
        """The roller in its groove, with its free end outside."""
        meridian = self.roller.meridian(0.5 * sum(self.contact), 1.0)
        return (self.mounted(meridian, self.contact[1], self.cam.stand, "groove", (1.0, -1.0)),)

    @property
    def _mouth(self) -> tuple[float, float]:
        """From the place along the tool at which the wall can begin at most, beside its axis, to the contact's end."""
        inner, high = self.cam.radii[0], self.contact[1]
        edge = self.aside + self.cam.tool_radius(self.roller, inner)
        return DEEPER * sqrt(max(0.0, inner * inner - edge * edge)), high

    @cached_property
    def cutters(self) -> tuple[Track, ...]:
        """The track with the tool that cuts: larger by the running clearance, as far as its flat end has room."""
        (track,), cam = map(self.cutting, self.tracks), self.cam
        return (replace(track.grown(cam.running_clearance), tip=cam.tip(self.roller, self.aside),
                        contact=self._mouth),)  # fmt: skip

    @property
    def passages(self) -> tuple[Track, ...]:
        """The roller as long as the wall beside it."""
        (track,) = self.tracks
        return (replace(track, contact=self._mouth),)

    @property
    def _ring(self) -> GroovedRing:
        from camgeom.solid.bell import GroovedRing

        (track,), cam = self.cutters, self.cam
        return GroovedRing("cam", track, self.blank, *cam.radii, cam.floor, self.width, cam.web)

    @property
    def parts(self) -> tuple[Part, ...]:
        """The ring with its web, meshed directly."""
        return (self._ring,)

    @property
    def top(self) -> float:
        """The ring's upper end."""
        return self.width

    @property
    def drum(self) -> Drum:
        """The inside of the ring, from the web up."""
        return Drum(self.cam.radii[0], self.cam.web, self.width, self.cam.groove_depth, hollow=True)

    @property
    def wall_mouth(self) -> tuple[Level, float]:
        """The inside of the ring."""
        inner = self.cam.radii[0]
        return cylinder_level(inner), inner

    @property
    def wall_foot(self) -> tuple[Level, float]:
        """The floor, a cylinder, which the flanks meet."""
        return cylinder_level(self.cam.floor), self.cam.floor

    @property
    def wall_top(self) -> tuple[Level, float]:
        """The floor: beyond it there is no flank."""
        return self.wall_foot

    @property
    def floor_gap(self) -> float:
        """From the roller's end to that of the tool, whose edge just reaches the floor, mm."""
        return self.cam.tip(self.roller, self.aside) - self.contact[1]

    @property
    def carrier(self) -> Carrier:
        """The bar that carries the roller, above the web."""
        lowest = self.cam.stand + float(heights(self.follower, self.program).min())
        return Carrier(lowest - self.cam.web, self.cam.carrier_diameter)

    @cached_property
    def walls(self) -> tuple[Wall, ...]:
        """Behind the groove's floor, from the groove to the web and the upper end, between its passes, and the web."""
        from camgeom.solid.bell import bell_walls

        return (*self.web_walls, *bell_walls(self._ring))

