"""Cylindrical cam: a groove or a rib on a drum, translating or swinging follower."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, final

import numpy as np
from pydantic import Field

from camgeom.cams import NO_GAPS, NO_RIB, ONE_WAY, REGULAR, Cam, idle, keyway_idle, problem, root_problems, sense_of
from camgeom.cams._axial import arc_problems, axial_idle, axial_track, ball_problems, grooved_contact, heights, too_long
from camgeom.errors import DesignError, Problem
from camgeom.immutable import immutable
from camgeom.keys import Clearance, Gap, Length
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme
from camgeom.maths.frozen import cached_property
from camgeom.solid import Part
from camgeom.solid.blank import Blank, Bore, Wall
from camgeom.solid.mechanism import Drive, Drum, Mechanism
from camgeom.track import Track
from camgeom.track.follower import (
    AnyRoller,
    CylinderRoller,
    Setup,
    SphereRoller,
    SwingingFollower,
    TranslatingFollower,
)

if TYPE_CHECKING:
    from camgeom.track.column import Level
    from camgeom.track.runout import Within


@final
class Cylindrical(Cam):
    """A drum 0 <= z <= length with one groove (or rib); the roller reaches in radially from the +X side."""

    FOLLOWERS: ClassVar[tuple[str, ...]] = ("translating", "swinging")
    MOST_PIECES: ClassVar[int] = 3_000
    MOST_STEPPED: ClassVar[int] = 1_000
    STATIONS: ClassVar[bool] = True
    TRACKS: ClassVar[tuple[str, ...]] = ("start", "groove_depth", "pitch_radius", "running_clearance", "root_radius")
    PLACES: ClassVar[tuple[str, ...]] = ("start",)

    kind: Literal["cylindrical"]
    form: Literal["groove", "rib"] = Field("groove", description="a groove with one roller in it, or a rib between two")
    diameter: Length = Field(description="mm, outside diameter of the drum")
    length: Length = Field(description="mm, length of the drum")
    start: Annotated[float, Field(ge=-1e5, le=1e5)] = Field(
        description="mm, z of the roller centre (rib: of the rib's middle) at zero lift"
    )
    groove_depth: Length = Field(description="mm, from the outer surface (rib: its height)")
    pitch_radius: Length | None = Field(
        None, description="mm, where the classical figures are quoted; default: middle of the contact length"
    )
    bore: Gap = Field(0.0, description="mm, bore diameter; 0 leaves the drum solid")
    keyway_width: Gap = Field(0.0, description="mm; 0 leaves the keyway out")
    keyway_depth: Gap = Field(0.0, description="mm, from the bore wall")
    rib_thickness: Length | None = Field(None, description="mm, rib form: axial thickness of the rib in a dwell")
    running_clearance: Clearance = Field(0.0, description="mm, normal gap between roller and each flank")
    root_radius: Gap = Field(
        0.0, description="mm, groove form: of the root between flank and floor, that of the tool's corner where there "
        "is no [cutter] corner_radius"
    )
    run_out: bool = Field(
        False, description="true where the groove leaves the drum through an end face on purpose: nothing holds the "
        "roller there, and nothing is judged where there is no wall"
    )
    direction: Literal["ccw", "cw"] = Field("ccw", description="the cam's turning, seen from +Z")

    @property
    def radius(self) -> float:
        """Outer radius of the drum, mm."""
        return 0.5 * self.diameter

    @property
    def floor_radius(self) -> float:
        """Radius of the groove's floor on its centre line (rib: of the drum beside the rib), mm."""
        return self.radius - self.groove_depth

    @property
    def bore_spec(self) -> Bore | None:
        """The bore, or None for a solid drum."""
        return Bore(self.bore, self.keyway_width, self.keyway_depth) if self.bore else None

    def mechanism(self, setup: Setup) -> "CylindricalMechanism":
        """The drum with its follower."""
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TranslatingFollower | SwingingFollower)
        assert roller is not None
        return CylindricalMechanism(
            follower=follower,
            roller=roller,
            program=setup.program,
            sense=sense_of(self.direction),
            drive=Drive.OPPOSED,
            width=self.length,
            form=self.form,
            bore=self.bore_spec,
            outside_diameter=self.diameter,
            running_clearance=self.running_clearance,
            root_radius=setup.corner or self.root_radius,
            cam=self,
        )

    def together(self, others: Sequence[Cam], rollers: Sequence[AnyRoller | None]) -> list[Problem]:
        """Several tracks are grooves, within both ends of the drum."""
        del rollers
        if not others:
            return []
        form = [] if self.form == "groove" else [problem("cam.form", self.form, "groove, of several tracks")]
        return form + ([problem("cam.run_out", True, "false, of several tracks")] if self.run_out else [])

    def joined(self, mechanisms: Sequence[Mechanism]) -> tuple[Part, ...]:
        """The drum with several grooves. DesignError where one runs out of an end."""
        from camgeom.solid.drum import GroovedCylinder
        from camgeom.solid.grooves import GroovedDrum

        parts = [part for one in mechanisms for part in one.parts]
        rings = tuple(part for part in parts if isinstance(part, GroovedCylinder))
        if len(rings) < len(parts):
            raise DesignError("several tracks on one drum are closed grooves inside both of its ends")
        named = tuple(replace(ring, track=replace(ring.track, name=f"groove {k}")) for k, ring in enumerate(rings, 1))
        return (GroovedDrum("cam", named, rings[0].blank, self.radius, self.length),)

    def joined_walls(self, mechanisms: Sequence[Mechanism], parts: Sequence[Part]) -> tuple[Wall, ...]:
        """Those of each groove, and what is left between them."""
        from camgeom.solid.grooves import GroovedDrum

        lands = [land for part in parts if isinstance(part, GroovedDrum) for land in part.lands]
        return tuple(dict.fromkeys([*(wall for one in mechanisms for wall in one.walls), *lands]))

    def idle(self, setup: Setup) -> dict[str, str]:
        """Keys of the other form, and of followers of planar cams."""
        follower = setup.follower
        assert isinstance(follower, TranslatingFollower | SwingingFollower)
        found = keyway_idle(self.bore) | (NO_GAPS if isinstance(setup.roller, SphereRoller) else {})
        if self.form == "groove":
            found |= idle("only form = 'rib' has a thickness", "cam.rib_thickness") | NO_RIB
            found |= idle("the play in a drum's groove is one for the chord and the normal", "impact.clearance_kind")
            found |= idle("the roller in a drum's groove does not turn in this solver", "impact.roller_inertia")
        else:
            found |= ONE_WAY
            found |= idle(
                "the drum beside a rib is turned, not left by the tool's end: its root is sharp so far",
                "cam.root_radius", "cutter.corner_radius",
            )  # fmt: skip
        found |= idle("a drum's follower has none; give cam.running_clearance", "follower.clearance")
        if self.run_out:
            found |= REGULAR
        return found | axial_idle(follower, "drum")

    def problems(self, setup: Setup) -> list[Problem]:
        """What cannot be built, with key, value and allowed range."""
        found = [*self._size_problems(), *self._roller_problems(setup.roller)]
        if self.form == "rib" and self.rib_thickness is None:
            found.append(Problem("cam.rib_thickness", "missing", None, "a length in mm, for form = 'rib'"))
        if self.form == "rib" and self.run_out:
            found.append(problem("cam.run_out", True, "false for form = 'rib': a rib has to stay within the drum"))
        if self.pitch_radius is not None and setup.roller is not None:
            low, high = self.contact(setup.roller)
            if not low <= self.pitch_radius <= high:
                limit = f"{low:g} .. {high:g} mm, where the roller touches"
                found.append(problem("cam.pitch_radius", self.pitch_radius, limit))
        root = root_problems(setup, self.root_radius, self.groove_depth) if self.form == "groove" else []
        return [*found, *root, *self._start_problems(setup), *arc_problems(setup, self.radius)]

    def contact(self, roller: AnyRoller) -> tuple[float, float]:
        """Radial stretch of a roller that touches the flank, mm."""
        return grooved_contact(roller, self.radius, self.groove_depth)

    def _size_problems(self) -> list[Problem]:
        found = []
        if self.groove_depth >= self.radius:
            limit = f"below the drum's radius {self.radius:g} mm"
            found.append(problem("cam.groove_depth", self.groove_depth, limit))
        bore = self.bore_spec
        if bore is None and (self.keyway_width or self.keyway_depth):
            found.append(problem("cam.keyway_width", self.keyway_width, "0 where the drum has no bore"))
        elif bore is not None:
            if self.keyway_width >= self.bore:
                found.append(problem("cam.keyway_width", self.keyway_width, f"below the bore {self.bore:g} mm"))
            elif bool(self.keyway_width) != bool(self.keyway_depth):
                found.append(problem("cam.keyway_depth", self.keyway_depth, "width and depth both, or neither"))
            elif self.groove_depth < self.radius and bore.reach >= self.floor_radius:
                limit = f"outline (reaches {bore.reach:g} mm) inside the groove floor, {self.floor_radius:g} mm"
                found.append(problem("cam.bore", self.bore, limit))
        return found

    def _roller_problems(self, roller: AnyRoller | None) -> list[Problem]:
        if roller is None:
            return [Problem("roller", "a cylindrical cam needs a roller", None, "a [roller] table")]
        if not isinstance(roller, SphereRoller):
            return too_long(roller, self.groove_depth)
        if self.form == "rib":
            return [problem("roller.shape", roller.shape, "cylinder, cone or crowned, for form = 'rib'")]
        return ball_problems(roller, self.groove_depth)

    def _start_problems(self, setup: Setup) -> list[Problem]:
        """The groove or rib must meet the drum somewhere; where it runs out of an end it is cut open there."""
        assert isinstance(setup.follower, TranslatingFollower | SwingingFollower)
        lifts = heights(setup.follower, setup.program)
        half = 0.5 * (self.rib_thickness or 0.0) if self.form == "rib" else 0.0
        half = half or (0.5 * setup.roller.diameter if setup.roller else 0.0)
        low, high = -float(lifts.max()) - half, self.length - float(lifts.min()) + half
        if low < self.start < high:
            return []
        limit = f"{low:g} .. {high:g} mm, where the {self.form} meets the drum"
        return [problem("cam.start", self.start, limit)]


@final
@immutable(kw_only=True)
class CylindricalMechanism(Mechanism):
    """A drum and its follower."""

    follower: TranslatingFollower | SwingingFollower
    roller: AnyRoller
    cam: Cylindrical

    @property
    def drum(self) -> Drum:
        """The drum from z = 0 up."""
        return Drum(self.cam.radius, 0.0, self.cam.length, self.cam.groove_depth)

    @property
    def runs_out(self) -> bool:
        """True where the groove leaves the drum through an end face on purpose."""
        return self.cam.run_out

    def within(self, x: Floats) -> Floats:
        """How far contact points (3, ...) lie between the drum's ends, mm; any where the groove has to stay there."""
        if not self.runs_out:
            return super().within(x)
        return np.asarray(np.minimum(x[2], self.cam.length - x[2]))

    @property
    def beside(self) -> "Within":
        """How deep contact points lie in the drum: where it is steep the roller's outer end stands beyond the land."""
        return self.drum.within if self.runs_out else self.drum.under

    @property
    def envelope(self) -> tuple[float, float]:
        """Of the blank."""
        return self.blank.envelope

    @property
    def blank(self) -> Blank:
        """The drum before the groove is cut."""
        return Blank.cylinder(self.cam.radius, self.cam.length, self.bore)

    @property
    def classical(self) -> bool:
        """A cylindrical roller on a slide, in a groove."""
        roller = isinstance(self.roller, CylinderRoller)
        return roller and isinstance(self.follower, TranslatingFollower) and self.cam.form == "groove"

    @property
    def contact(self) -> tuple[float, float]:
        """See `Cylindrical.contact`."""
        return self.cam.contact(self.roller)

    @property
    def quoted_radius(self) -> float:
        """Where the classical figures are quoted, mm."""
        low, high = self.contact
        return self.cam.pitch_radius or 0.5 * (low + high)

    @cached_property
    def tracks(self) -> tuple[Track, ...]:
        """The roller tracks: one for a groove, the lower and the upper roller for a rib."""
        cam, roller, ball = self.cam, self.roller, isinstance(self.roller, SphereRoller)
        low, high = self.contact
        centre = cam.floor_radius + 0.5 * roller.diameter if ball else 0.5 * (low + high)
        meridian = roller.meridian(centre, -1.0)
        tip = centre - 0.5 * roller.diameter if ball else low

        def at(dz: float, name: str, sides: tuple[float, ...] = (1.0, -1.0)) -> Track:
            return axial_track(self, self.follower, meridian, (low, high), tip, cam.start, name, sides, dz)

        if cam.form == "groove":
            return (at(0.0, "groove"),)
        half = 0.5 * (cam.rib_thickness or 0.0) + 0.5 * roller.diameter
        # u x v points towards smaller z where the cam turns counter-clockwise: side -1 is then a roller's upper flank.
        return at(-half, "lower roller", (-self.sense,)), at(half, "upper roller", (self.sense,))

    @cached_property
    def cutters(self) -> tuple[Track, ...]:
        """The tracks with the tool that cuts: larger by the running clearance, down to the groove floor."""
        cam, ball = self.cam, isinstance(self.roller, SphereRoller)
        floor = cam.floor_radius if cam.form == "groove" else cam.floor_radius - 0.1 * cam.groove_depth
        return tuple(
            replace(
                track.grown(cam.running_clearance),
                tip=track.tip - cam.running_clearance if ball else floor,
                root=self.root_radius,
            )
            for track in map(self.cutting, self.tracks)
        )

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """The drum: meshed directly where its groove or rib is one closed ring, cut by a boolean otherwise."""
        from camgeom.solid.drum import GroovedCylinder, RibbedCylinder

        cam, blank, cutters = self.cam, self.blank, self.cutters
        if cam.form == "rib":
            lower, upper = cutters
            return (RibbedCylinder("cam", lower, upper, blank, cam.floor_radius, cam.radius, cam.length),)
        (track,) = cutters
        ring = GroovedCylinder("cam", track, blank, cam.radius, cam.length)
        if ring.fits:
            return (ring,)
        from camgeom.solid.cut import CutBlank

        beyond = cam.radius + max(0.05 * cam.radius, 0.25 * cam.groove_depth)
        ridge = beyond + 0.5 * cam.groove_depth
        genus = 0 if blank.bore is None else 1
        return (CutBlank("cam", cutters, blank, *self._cylinder(beyond), ridge, genus),)

    @property
    def wall_foot(self) -> "tuple[Level, float] | None":
        """Surface on which a rib's walls end; None for a groove, cut down to the tool's tip."""
        return self._cylinder(self.cam.floor_radius) if self.cam.form == "rib" else None

    @property
    def wall_top(self) -> "tuple[Level, float]":
        """The drum's outside: a swinging roller can leave the drum sideways."""
        return self._cylinder(self.cam.radius)

    def _cylinder(self, radius: float) -> "tuple[Level, float]":
        from camgeom.track.column import cylinder_level

        return cylinder_level(radius), radius

    @cached_property
    def ribs(self) -> tuple[Extreme, ...]:
        """Least normal thickness of the rib at its tip and at its foot, mm: where it is steep it is thinner."""
        if self.cam.form != "rib":
            return ()
        from camgeom.track.clearance import flank_gap

        lower, upper = self.cutters
        answers = []
        for where, radius in (("tip", self.cam.radius), ("foot", self.cam.floor_radius)):
            gaps = (flank_gap(lower, upper, *self._cylinder(radius)), flank_gap(upper, lower, *self._cylinder(radius)))
            answers.append(replace(min(gaps, key=lambda gap: gap.value), where=where))
        return tuple(answers)

    @property
    def floor_gap(self) -> float | None:
        """From the roller's end to the floor, square to both, mm; a ball touches its groove at the bottom too."""
        return None if isinstance(self.roller, SphereRoller) else self.contact[0] - self.cam.floor_radius

    @property
    def rib_asked(self) -> float | None:
        """The rib's thickness in a dwell less both running clearances, mm."""
        thickness = self.cam.rib_thickness
        return None if thickness is None else thickness - 2.0 * self.cam.running_clearance

    @cached_property
    def walls(self) -> tuple[Wall, ...]:
        """Thinnest walls of the drum: to the ends, between passes of the groove, and to the bore."""
        from camgeom.solid.drum import drum_walls

        cam = self.cam
        return tuple(drum_walls(self.cutters, cam.radius, cam.floor_radius, cam.length, self.bore))
