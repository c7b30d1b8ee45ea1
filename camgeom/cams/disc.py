"""Disc cam: external (force-closed) or face groove (form-closed), any of the usual followers; the flanks of a conical
roller lean as the cone does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import cos, hypot, inf, radians, sqrt
from typing import TYPE_CHECKING, ClassVar, Literal, final

import numpy as np
from pydantic import Field

from camgeom.cams import (
    NO_DRUM,
    NO_GAPS,
    NO_LAYERS,
    NO_ROOT,
    NORMAL_PLAY,
    ONE_WAY,
    REGULAR,
    Cam,
    idle,
    keyway_idle,
    prism_idle,
    problem,
    root_problems,
    sense_of,
)
from camgeom.cams._plate import (
    SLIDE,
    SQUARE,
    Arm,
    arm_angle,
    bore_of,
    bore_problems,
    bore_walls,
    cone_problems,
    disc_wall,
    face_idle,
    least_distance,
    least_wall,
    lift_range,
    plate_envelope,
    roller_track,
    straight_problems,
    swing_problem,
    triangle_problem,
)
from camgeom.errors import DesignError, Problem
from camgeom.immutable import immutable
from camgeom.keys import Clearance, Gap, Length
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.solid import Part
from camgeom.solid.blank import Wall
from camgeom.solid.mechanism import Drive, Measure, Mechanism
from camgeom.track import Joint, Meridian, Straight, Track, Vector
from camgeom.track.follower import AnyRoller, ConeRoller, Setup, SwingingFollower, TranslatingFollower
from camgeom.track.outline import CircleOutline, FaceOutline, FlatFace, Outline, RollerOutline

if TYPE_CHECKING:
    from camgeom.solid.prism import FaceGroove, Loop
    from camgeom.track.sliding import Slider
    from camgeom.track.touch import Touch


@final
class Disc(Cam):
    """A disc 0 <= z <= width; translating followers move along +X, swinging ones pivot at (center_distance, 0)."""

    FOLLOWERS: ClassVar[tuple[str, ...]] = ("translating", "swinging")
    STATIONS: ClassVar[bool] = True
    TRACKS: ClassVar[tuple[str, ...]] = (
        "form", "face", "rim", "base_radius", "center_distance", "groove_depth", "running_clearance", "root_radius",
    )  # fmt: skip

    kind: Literal["disc"]
    form: Literal["external", "groove"] = Field("external", description="external profile, or a face groove in a plate")
    base_radius: Length = Field(description="mm, radius of the profile at zero lift (groove: of the inner flank of a "
                               "roller without clearance; running_clearance is taken off it); of a cone's where the "
                               "middle of its contact runs")
    width: Length = Field(description="mm, thickness of the disc or plate")
    center_distance: Length | None = Field(None, description="mm, swinging followers: cam axis to pivot")
    diameter: Length | None = Field(None, description="mm, groove form: outside diameter of the plate")
    rim: Literal["circle", "profile"] = Field(
        "circle", description="groove form: the plate's rim is a circle of `diameter`, or the profile of the [[track]] "
        "(or first track) of form = 'external' on the same disc"
    )
    face: Literal["upper", "lower"] = Field(
        "upper", description="groove form: the face of the plate that it is cut in, z = width or z = 0; of several "
        "tracks on one disc each groove has a face of its own"
    )
    groove_depth: Length | None = Field(None, description="mm, groove form: depth from that face of the plate")
    running_clearance: Clearance = Field(0.0, description="mm, groove form: normal gap between roller and each flank")
    root_radius: Gap = Field(
        0.0, description="mm, groove form: of the root between flanks and floor, that of the tool's corner where there "
        "is no [cutter] corner_radius"
    )
    bore: Gap = Field(0.0, description="mm, bore diameter; 0 leaves the disc whole")
    keyway_width: Gap = Field(0.0, description="mm; 0 leaves the keyway out")
    keyway_depth: Gap = Field(0.0, description="mm, from the bore wall")
    direction: Literal["ccw", "cw"] = Field("ccw", description="the cam's turning, seen from +Z")

    def mechanism(self, setup: Setup) -> DiscMechanism:
        """The disc with its follower."""
        follower = setup.follower
        assert isinstance(follower, TranslatingFollower | SwingingFollower)
        groove = self.form == "groove"
        conical = isinstance(setup.roller, ConeRoller) and follower.face == "roller"
        return (ConicalDiscMechanism if conical else DiscMechanism)(
            follower=follower,
            roller=setup.roller,
            program=setup.program,
            sense=sense_of(self.direction),
            drive=Drive.OPPOSED if groove else Drive.ALONE,
            width=self.width,
            form=self.form,
            bore=bore_of(self.bore, self.keyway_width, self.keyway_depth),
            base_radius=self.base_radius,
            outside_diameter=self.diameter,
            running_clearance=self.running_clearance if groove else 0.0,
            root_radius=(setup.corner or self.root_radius) if groove else 0.0,
            cam=self,
        )

    def together(self, others: Sequence[Cam], rollers: Sequence[AnyRoller | None]) -> list[Problem]:
        """A groove a face, and one profile as the rim; a plate with one track has it in its upper face."""
        del rollers
        return _contradictions([(cam.form, cam.face, cam.rim) for cam in (self, *others) if isinstance(cam, Disc)])

    def joined(self, mechanisms: Sequence[Mechanism]) -> tuple[Part, ...]:
        """The disc with all of its tracks."""
        from camgeom.cams._faces import plate_of
        from camgeom.solid.prism import Loop

        discs = [one for one in mechanisms if isinstance(one, DiscMechanism)]
        grooves = {f"groove {k}": one.face_groove for k, one in enumerate(discs, 1) if one.face_groove is not None}
        profile = next((one.flanks[0] for one in discs if one.face_groove is None), None)
        rim = profile or Loop(CircleOutline(0.5 * (self.diameter or 0.0)), "rim")
        return (plate_of(grooves, rim, self.width, discs[0].bore),)

    def joined_walls(self, mechanisms: Sequence[Mechanism], parts: Sequence[Part]) -> tuple[Wall, ...]:
        """What is left between tracks, to the outside and to the bore."""
        from camgeom.solid.prism import GroovedPlate

        return tuple(wall for part in parts if isinstance(part, GroovedPlate) for wall in part.walls)

    @property
    def inside(self) -> str:
        """Name of the flank nearer to the cam axis."""
        return "profile" if self.form == "external" else "inner flank"

    def idle(self, setup: Setup) -> dict[str, str]:
        """Keys of the other form, of other faces and of other followers."""
        follower = setup.follower
        assert isinstance(follower, TranslatingFollower | SwingingFollower)
        found = NO_DRUM | REGULAR | face_idle(follower.face)
        found |= prism_idle(self.bore) if self.form == "external" else keyway_idle(self.bore)
        found |= idle("a disc's follower has none; discs of a pair and frames have", "follower.clearance")
        if self.form == "external":
            grooved = ("diameter", "rim", "face", "groove_depth", "running_clearance", "root_radius")
            keys = tuple(f"cam.{key}" for key in grooved)
            found |= idle("only form = 'groove' has one", *keys) | ONE_WAY | NO_ROOT
            found |= idle("what a spring or weight holds on its cam has no play", "limits.play_mm")
        elif self.rim == "profile":
            found |= idle("the rim is the profile of another track", "cam.diameter")
        if isinstance(setup.roller, ConeRoller):
            found |= NO_LAYERS | NORMAL_PLAY if self.form == "groove" else {}
        if not follower.rotating:
            found |= NO_GAPS if self.form == "external" else {}
            found |= SQUARE if follower.face == "flat" else {}
            return found | idle("only a swinging follower has a pivot", "cam.center_distance")
        return found | idle("belongs to a drum's follower", "follower.pivot_distance", "follower.start_angle")

    def problems(self, setup: Setup) -> list[Problem]:
        """What cannot be built, with key, value and allowed range."""
        found = bore_problems(self.bore, self.keyway_width, self.keyway_depth, self.base_radius)
        mechanism = self.mechanism(setup)
        follower, roller, face = mechanism.follower, setup.roller, mechanism.follower.face
        if face == "roller" and roller is None:
            return [*found, Problem("roller", "face = 'roller' needs a roller", None, "a [roller] table")]
        if face == "roller" and isinstance(roller, ConeRoller):
            found += self._cone_problems(mechanism, roller)
        elif face == "roller" and roller is not None and roller.shape not in ("cylinder", "crowned"):
            found.append(problem("roller.shape", roller.shape, "cylinder, cone or crowned on a disc cam"))
        found += straight_problems(setup.roller)
        if face == "curved" and not follower.face_radius:
            found.append(Problem("follower.face_radius", "is missing", None, "a radius in mm, for face = 'curved'"))
        if self.form == "groove":
            found += self._groove_problems(mechanism, setup)
        if isinstance(follower, SwingingFollower):
            return [*found, *self._swing_problems(mechanism, follower)]
        prime = mechanism.prime_radius
        if face != "flat" and abs(follower.offset) >= prime:
            found.append(problem("follower.offset", abs(follower.offset), f"below the prime radius {prime:g} mm"))
        return found

    def _cone_problems(self, mechanism: DiscMechanism, roller: ConeRoller) -> list[Problem]:
        if self.form == "external":
            return cone_problems(roller, (0.5 * self.width, 0.5 * self.width))
        if self.groove_depth is None:
            return []
        half = 0.5 * (mechanism.contact[1] - mechanism.contact[0])
        return cone_problems(roller, (self.groove_depth - half, half))

    def _groove_problems(self, mechanism: DiscMechanism, setup: Setup) -> list[Problem]:
        if mechanism.follower.face != "roller":
            return [problem("follower.face", mechanism.follower.face, "roller, for form = 'groove'")]
        if self.groove_depth is None:
            return [Problem("cam.groove_depth", "is missing", None, "a length in mm, for form = 'groove'")]
        if self.diameter is None and self.rim == "circle":
            limit = "a length in mm, for form = 'groove', or rim = 'profile' where a track of form = 'external' is it"
            return [Problem("cam.diameter", "is missing", None, limit)]
        found = root_problems(setup, self.root_radius, self.groove_depth)
        if self.groove_depth >= self.width:
            found.append(problem("cam.groove_depth", self.groove_depth, f"below the width {self.width:g} mm"))
        reach = self.groove_reach(mechanism)
        if self.diameter is not None and 0.5 * self.diameter <= reach:
            limit = f"above {2.0 * reach:g} mm, so that the groove is inside"
            found.append(problem("cam.diameter", self.diameter, limit))
        return found

    def groove_reach(self, mechanism: DiscMechanism) -> float:
        """Largest radius of the groove's outer flank, mm; 0 where the mechanism itself cannot be built."""
        follower, prime, top = mechanism.follower, mechanism.prime_radius, lift_range(mechanism.program)[1]
        own = mechanism.widest
        if isinstance(follower, TranslatingFollower):
            low = sqrt(max(prime**2 - follower.offset**2, 0.0))
            return hypot(low + top, follower.offset) + own
        a = self.center_distance
        if a is None or self._swing_problems(mechanism, follower):
            return 0.0
        angle = arm_angle(a, follower.arm, prime) + top
        return sqrt(a**2 + follower.arm**2 - 2.0 * a * follower.arm * cos(angle)) + own

    def _swing_problems(self, mechanism: DiscMechanism, follower: SwingingFollower) -> list[Problem]:
        a = self.center_distance
        if a is None:
            return [Problem("cam.center_distance", "is missing", None, "mm, cam axis to the follower's pivot")]
        if follower.face == "flat":
            if not abs(self.base_radius + follower.face_offset) < a:
                least = abs(self.base_radius + follower.face_offset)
                limit = f"above {least:g} mm, so that the face clears the base circle"
                return [problem("cam.center_distance", a, limit)]
            return []
        arm, prime = follower.arm, mechanism.prime_radius
        found = triangle_problem("cam.center_distance", a, arm, prime, "arm")
        found = found or swing_problem(arm_angle(a, arm, prime), mechanism.program)
        return [found] if found else []


@immutable(kw_only=True)
class DiscMechanism(Mechanism):
    """A disc cam and its follower."""

    follower: TranslatingFollower | SwingingFollower
    cam: Disc

    @property
    def touch_radius(self) -> float:
        """Radius of what touches the cam, mm: the roller, the mushroom's face, 0 for a knife edge or a flat face."""
        if self.follower.face == "roller":
            return 0.5 * self.roller.diameter if self.roller else 0.0
        return (self.follower.face_radius or 0.0) if self.follower.face == "curved" else 0.0

    @property
    def widest(self) -> float:
        """Largest distance of a flank of the groove from the path of the roller's middle, mm."""
        return self.touch_radius + self.running_clearance

    @property
    def prime_radius(self) -> float:
        """Distance of the trace point from the cam axis at zero lift, mm."""
        return self.cam.base_radius + self.touch_radius

    @property
    def quoted_radius(self) -> float:
        """Middle of the contact along the roller axis, mm (a height z: the roller's axis is parallel to the cam's)."""
        low, high = self.contact
        return 0.5 * (low + high)

    @property
    def contact(self) -> tuple[float, float]:
        """Heights z between which roller and cam touch, mm."""
        cam, roller = self.cam, self.roller
        depth = cam.groove_depth if cam.form == "groove" and cam.groove_depth else cam.width
        length = min(depth, roller.length or depth) if roller else depth
        if cam.form == "groove":
            return (0.0, length) if cam.face == "lower" else (cam.width - length, cam.width)
        return 0.5 * (cam.width - length), 0.5 * (cam.width + length)

    @property
    def measures(self) -> tuple[Measure, ...]:
        """The depth of a face groove."""
        if self.face_groove is None:
            return ()
        reach = 0.5 * self.cam.diameter if self.cam.diameter is not None else self.cam.groove_reach(self)
        return (Measure((self.face_groove.floor, reach), (self.face_groove.top, reach)),)

    @property
    def floor_gap(self) -> float | None:
        """From the roller's end to the floor of a face groove, mm; a longer roller stands out of the plate."""
        if self.cam.form == "external" or self.cam.groove_depth is None:
            return None
        low, high = self.contact
        return self.cam.groove_depth - (high - low)

    @property
    def _floor(self) -> float:
        """Height of a groove's floor, mm."""
        depth = self.cam.groove_depth or 0.0
        return depth if self.cam.face == "lower" else self.cam.width - depth

    @property
    def _mouth(self) -> float:
        """Height of the face that a groove is cut in."""
        return 0.0 if self.cam.face == "lower" else self.cam.width

    @cached_property
    def pitch(self) -> Track:
        """The motion of the roller (or of the centre of a curved face, or of a knife edge)."""
        anchor, joint = self._mount
        groove = self.cam.form == "groove"
        sides = (1.0, -1.0) if groove else (-self.sense,)
        name, below = "groove" if groove else "profile", self._below
        return roller_track(
            name, self.program, self.sense, anchor, joint, self._meridian, self.contact, tip_high=below, sides=sides
        )

    @property
    def _below(self) -> bool:
        """True of a groove in the lower face, into which the roller reaches up."""
        return self.cam.form == "groove" and self.cam.face == "lower"

    @property
    def _meridian(self) -> Meridian:
        if self.roller is not None and self.follower.face == "roller":
            return self.roller.meridian(self.quoted_radius, 1.0 if self._below else -1.0)
        return Straight(max(self.touch_radius, 1e-9), 0.0)

    @cached_property
    def tracks(self) -> tuple[Track, ...]:
        """The roller's track; a curved face counts as a roller of its radius; none for flat and knife followers."""
        return (self.pitch,) if self.follower.face in ("roller", "curved") else ()

    @cached_property
    def cutters(self) -> tuple[Track, ...]:
        """The roller's track; of a face groove with the tool that cuts it: wider by the clearance, to the floor."""
        if self.cam.form == "external":
            return self.tracks
        grown = (track.grown(self.running_clearance) for track in self.tracks)
        return tuple(replace(track, tip=self._floor, root=self.root_radius) for track in grown)

    @property
    def sliders(self) -> tuple[Slider, ...]:
        """A flat face or a knife edge."""
        face = self.follower.face
        if face not in ("flat", "knife"):
            return ()
        from camgeom.track.sliding import SlidingEdge, SlidingFace

        if face == "flat":
            return (SlidingFace("profile", self._face),)
        return (SlidingEdge("profile", self.pitch),)

    @property
    def _mount(self) -> tuple[Vector, Joint]:
        """Where the trace point stands at zero lift, and the joint that carries it."""
        follower, prime = self.follower, self.prime_radius
        if isinstance(follower, SwingingFollower):
            arm, centre = self._arm(follower), self.cam.center_distance
            assert centre is not None
            return arm.point(follower.arm, arm_angle(centre, follower.arm, prime)), arm.joint
        return (sqrt(prime**2 - follower.offset**2), follower.offset, 0.0), SLIDE

    def _arm(self, follower: SwingingFollower) -> Arm:
        assert self.cam.center_distance is not None
        return Arm(self.cam.center_distance, follower.way)

    @property
    def _face(self) -> FlatFace:
        """The motion of a flat face seen from the cam."""
        follower, base = self.follower, self.cam.base_radius
        if isinstance(follower, SwingingFollower):
            arm = self._arm(follower)
            return FlatFace(self.program, self.sense, base, arm.centre, follower.face_offset, arm.way)
        return FlatFace(self.program, self.sense, base)

    @cached_property
    def profile(self) -> Outline:
        """The cam's profile (groove form: the inner flank)."""
        if self.follower.face == "flat":
            return FaceOutline(self._face)
        return RollerOutline(self.pitch, -self.touch_radius - self.running_clearance)

    @cached_property
    def outlines(self) -> dict[str, Outline]:
        """Profile and pitch curve by name; a face groove has an inner and an outer flank."""
        found = {"profile": self.profile}
        if self.follower.face != "flat":
            found["pitch curve"] = RollerOutline(self.pitch, 0.0)
        if self.cam.form == "groove":
            found["outer flank"] = RollerOutline(self.pitch, self.touch_radius + self.running_clearance)
        return found

    @cached_property
    def flanks(self) -> tuple[Loop, Loop]:
        """The profile or inner flank, and a groove's outer flank."""
        from camgeom.solid.prism import Loop

        return Loop(self.profile, "flank"), Loop(self.outlines.get("outer flank", self.profile), "flank")

    @cached_property
    def envelope(self) -> tuple[float, float]:
        """Of the profile, or of the plate that has a face groove."""
        cam = self.cam
        return (cam.diameter, cam.width) if cam.diameter else plate_envelope(self.flanks[0].ends, cam.width)

    @cached_property
    def touches(self) -> tuple[Touch, ...]:
        """The contacts: one of an external cam, both flanks of a face groove."""
        from camgeom.track.touch import Touch

        follower, face = self.follower, self.follower.face
        low, high = self.contact
        joint = self._arm(follower).joint if isinstance(follower, SwingingFollower) else SLIDE
        radius = inf if face == "flat" else self.touch_radius
        gap = self.running_clearance
        inner = Touch(self.cam.inside, self.profile, joint, self.sense, 1.0, radius, high - low, kind=face, gap=gap)
        if self.cam.form == "external":
            return (inner,)
        outer = self.outlines["outer flank"]
        return (
            inner,
            Touch("outer flank", outer, joint, self.sense, -1.0, radius, high - low, material=-1.0, gap=gap),
        )

    @cached_property
    def walls(self) -> tuple[Wall, ...]:
        """The disc and its profile to the bore; of a face groove the outer flank to the rim, the web below."""
        cam, (inner, outer) = self.cam, self.flanks
        to_bore = least_wall(inner, lambda outline: bore_walls(cam.inside, outline, self.bore))
        if cam.form == "external":
            return (disc_wall("cam", cam.width), *to_bore)
        if self.face_groove is None or cam.diameter is None or cam.groove_depth is None:
            return ()
        rim = 0.5 * cam.diameter

        def to_rim(x: Floats) -> Floats:
            return np.asarray(rim - np.hypot(x[0], x[1]))

        thickness, angle = min(least_distance(outline, to_rim) for outline in outer.ends)
        floor = Wall("under the groove floor", cam.width - cam.groove_depth, None, "a wider plate, a shallower groove")
        outside = Wall("outer flank to rim", thickness, angle, "a larger diameter of the plate")
        return (*to_bore, outside, floor)

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """The disc, or the plate with its face groove."""
        from camgeom.solid.prism import GroovedPlate, Loop, Prism

        cam = self.cam
        if cam.form == "external":
            return (Prism("cam", self.flanks[0], 0.0, cam.width, (), self.bore),)
        if self.face_groove is None or cam.diameter is None:
            raise DesignError("rim = 'profile' needs the track of form = 'external' that makes it")
        rim = Loop(CircleOutline(0.5 * cam.diameter), "rim")
        return (GroovedPlate("cam", rim, (self.face_groove,), 0.0, cam.width, self.bore),)

    @property
    def wall(self) -> tuple[float, float]:
        """Heights z between which the flanks stand, mm."""
        ends = (0.0, self.width) if self.face_groove is None else (self.face_groove.foot, self.face_groove.top)
        return min(ends), max(ends)

    @cached_property
    def face_groove(self) -> FaceGroove | None:
        """The groove in a face; None of an external profile."""
        if self.cam.form == "external":
            return None
        from camgeom.solid.prism import FaceGroove

        return FaceGroove(*self.flanks, self._floor, self._mouth, self.root_radius)


@final
@immutable(kw_only=True)
class ConicalDiscMechanism(DiscMechanism):
    """A disc whose flanks are, at each height, those of the cone's radius there; the roller's free end is below, or at
    the floor of its groove."""

    @property
    def _span(self) -> tuple[float, float]:
        """Heights between which its flanks stand, mm."""
        low, high = sorted((self._floor, self._mouth))
        return (0.0, self.width) if self.cam.form == "external" else (low, high)

    @cached_property
    def _radii(self) -> tuple[float, float]:
        """Of the tool at both, mm."""
        tool = self._meridian.grown(self.running_clearance)
        low, high = (float(r) for r in tool.jet(np.array(self._span))[3])
        return low, high

    @property
    def widest(self) -> float:
        """Largest distance of a flank of the groove from the path of the roller's middle, mm."""
        return max(self._radii)

    @cached_property
    def flanks(self) -> tuple[Loop, Loop]:
        """The profile or inner flank, and a groove's outer flank."""
        from camgeom.solid.prism import Loop

        inner, outer = ([RollerOutline(self.pitch, way * r) for r in self._radii] for way in (-1.0, 1.0))
        return Loop(inner[0], "flank", inner[1]), Loop(outer[0], "flank", outer[1])

    @cached_property
    def outlines(self) -> dict[str, Outline]:
        """The flanks at both of their ends, and the pitch curve."""
        ends = {touch.where: touch.outline for touch in self.profiles}
        return ends | {"pitch curve": RollerOutline(self.pitch, 0.0)}

    @property
    def touches(self) -> tuple[Touch, ...]:
        """None: its profile is not the same at every height."""
        return ()

    @property
    def profiles(self) -> tuple[Touch, ...]:
        """Those of both ends."""
        from camgeom.track.touch import Touch

        joint = self._arm(self.follower).joint if isinstance(self.follower, SwingingFollower) else SLIDE
        low, high = self._span
        names = (self.cam.inside, 1.0), ("outer flank", -1.0)
        rollers = self._meridian.jet(np.array(self._span))[3].tolist()
        lean = radians(self.roller.half_angle) if isinstance(self.roller, ConeRoller) else 0.0
        return tuple(
            Touch(
                name, outline, joint, self.sense, way, own, high - low, material=way, gap=tool - own, lean=lean,
                height=z,
            )
            for (name, way), flank in zip(names if self.cam.form == "groove" else names[:1], self.flanks)
            for z, own, tool, outline in zip(self._span, rollers, self._radii, flank.ends)
        )  # fmt: skip

    @cached_property
    def cutters(self) -> tuple[Track, ...]:
        """The track with a tool as long as its flanks, of which the roller may leave some bare."""
        tip = self._floor if self.cam.form == "groove" else 0.0
        grown = (track.grown(self.running_clearance) for track in self.tracks)
        return tuple(replace(track, tip=tip, contact=self._span) for track in grown)

    @property
    def passages(self) -> tuple[Track, ...]:
        """The roller as long as its flanks; its end is as far from a floor as its side from the flanks, or nearer."""
        off, (low, high) = min(self.floor_gap or 0.0, self.running_clearance), self._span
        ends = (low, high - off) if self._below else (low + off, high)
        tip = ends[1] if self._below else ends[0]
        return tuple(replace(track, tip=tip, contact=ends) for track in self.tracks)

    def within(self, x: Floats) -> Floats:
        """How far contact points (3, ...) lie between the ends of the flanks, mm."""
        low, high = self._span
        return np.asarray(np.minimum(x[2] - low, high - x[2]) + 1e-9)


def _contradictions(tracks: Sequence[tuple[str, str, str]]) -> list[Problem]:
    """What contradicts itself in the tracks of one disc: (form, face, rim) of [cam] and of every further table.

    A groove a face, and one profile as the rim, which all grooves have to know; a plate with one track has it in its
    upper face.
    """
    found, taken, profiles = list[Problem](), dict[str, str](), 0
    several = [form for form, _, _ in tracks].count("external")
    for key, (form, face, rim) in zip(["cam", *(f"track[{k}].cam" for k in range(len(tracks)))], tracks):
        if form == "external":
            profiles += 1
            if profiles > 1:
                limit = "a groove: one profile makes the rim of a disc (discs side by side are not built)"
                found.append(problem(f"{key}.form", form, limit))
        elif face in taken:
            limit = f"the other face: one groove a face, and {taken[face]} has this one"
            found.append(problem(f"{key}.face", face, limit))
        else:
            taken[face] = key
            if (rim == "profile") != bool(several):
                limit = "'profile' with, 'circle' without a track of form = 'external'"
                found.append(problem(f"{key}.rim", rim, limit))
    if len(tracks) == 1 and "lower" in taken:
        limit = "upper: a plate with one groove is turned over (direction the other way round)"
        found.append(problem("cam.face", "lower", limit))
    return found
