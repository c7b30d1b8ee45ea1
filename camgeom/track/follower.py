"""Follower and roller as profile sections, and `Setup`: what a cam type is given to place its tracks.

A cam type receives angles already in radians inside the program; sections keep the degrees and mm of the profile.
"""

from abc import ABC, abstractmethod
from dataclasses import replace
from math import atan2, degrees, radians, sin, sqrt
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, Self, final

from pydantic import Field, model_validator

from camgeom.immutable import immutable
from camgeom.keys import Degrees, Gap, Length, Section, SignedLength
from camgeom.motion.program import Program
from camgeom.track import Arc, Meridian, Straight, cone_slope

if TYPE_CHECKING:
    from camgeom.track.carriage import Carriage

Mass = Annotated[float, Field(ge=0.0, le=1e7, allow_inf_nan=False)]
Inertia = Annotated[float, Field(ge=0.0, le=1e9, allow_inf_nan=False)]
Face = Literal["roller", "flat", "knife", "curved"]
Load = Annotated[float, Field(gt=0.0, le=1e9, allow_inf_nan=False)]
RUN_OUT = 0.00035
"""of a roller's diameter: the logarithmic profile of ISO/TS 16281"""


@final
@immutable(eq=True)
class Ends:
    """How a roller ends and stands, where that is stated; nothing of it makes a plain line.

    radius: rounding beyond both ends, mm; run_out: factor of its logarithmic drop, mm; tilt: of its axis, rad, positive
    where it presses the end of larger axial coordinate on the wall behind; mirrored: see `finite_contact`
    """

    radius: float = 0.0
    run_out: float = 0.0
    tilt: float = 0.0
    mirrored: bool = False

    @property
    def stated(self) -> bool:
        """Whether a contact without a crown is more than a line."""
        return bool(self.radius or self.run_out or self.tilt)


PLAIN = Ends()
"""nothing of it is stated"""


class _Bearing(Section):
    """Keys every roller has: its own bearing."""

    dynamic_rating: Load | None = Field(None, description="N, basic dynamic load rating C of the roller's bearing")
    static_rating: Load | None = Field(None, description="N, basic static load rating C0 of the roller's bearing")
    bearing_type: Literal["roller", "ball"] = Field(
        "roller", description="what rolls in the roller's bearing: the load exponent of ISO 281 is 10/3 or 3")
    fatigue_load_limit: Load | None = Field(
        None, description="N, fatigue load limit C_u (P_u) of the bearing, for the life factor a_ISO of ISO 281")
    contamination: Annotated[float, Field(ge=0.0, le=1.0)] | None = Field(
        None, description="1, contamination factor e_C of ISO 281: 0.8 to 0.6 sealed and greased for life, 0.5 to 0.3 "
        "slight, 0.3 to 0.1 typical contamination (pitch diameters below 100 mm)")
    pitch_diameter: Length | None = Field(None, description="mm, D_pw of the rolling elements")
    max_radial_load: Load | None = Field(
        None, description="N, largest running load F_r max, which bends the outer ring of a track roller")
    max_static_load: Load | None = Field(
        None, description="N, largest static load F_0r max of ring and stud; with static_rating the lower one counts")
    limiting_speed: Annotated[float, Field(gt=0.0, le=1e7, allow_inf_nan=False)] | None = Field(
        None, description="r/min, limiting speed of the bearing")
    designation: Annotated[str, Field(min_length=1, max_length=60)] | None = Field(
        None, description="of a track roller in a catalogue (`camgeom rollers`), which gives diameter and bearing")
    catalogue: Annotated[str, Field(min_length=1, max_length=200)] | None = Field(
        None, description="TOML file of your own track rollers beside the profile, asked before camgeom's")
    diameter: Length = Field(description="mm")

    @model_validator(mode="after")
    def _turns_inside(self) -> Self:
        if self.pitch_diameter is not None and self.pitch_diameter >= self.diameter:
            raise ValueError(f"pitch_diameter = {self.pitch_diameter:g}: its bearing turns inside of the roller; "
                             f"allowed: below its diameter, {self.diameter:g} mm")  # fmt: skip
        static, name = self.static_rating, "static_rating"
        if static is None:
            static, name = self.dynamic_rating, "dynamic_rating"
        if self.fatigue_load_limit is not None and static is not None and self.fatigue_load_limit >= static:
            raise ValueError(f"fatigue_load_limit = {self.fatigue_load_limit:g}: some 1/8 of the static rating of a "
                             f"roller bearing, 1/22 of a ball bearing's (ISO 281); allowed: below {name}, {static:g} N")
        return self

    @property
    def ends(self) -> Ends:
        """How it ends and stands against its flank."""
        return PLAIN

    @property
    def arc(self) -> float | None:
        """Radius of its crown, mm, that touches a flank straight along it; None of a roller without one."""
        return None

    @property
    def steepest(self) -> float:
        """Share of a contact's force that acts along the roller's axis, at most: none where it runs square to that."""
        return 0.0


class _Ended(_Bearing):
    """Keys of a roller with two ends: what its contact with the flank is like beside its shape."""

    end_radius: Gap = Field(
        0.0, description="mm, rounding that follows at both ends of `length`, of whichever body ends there; 0: sharp "
        "edges, whose pressure nothing bounds where they bear"
    )
    misalignment_deg: Annotated[float, Field(ge=-1.0, le=1.0, allow_inf_nan=False)] = Field(
        0.0, description="deg, tilt of the roller's axis against the flank; a positive one presses the end of larger "
        "axial coordinate (outer end of a drum's roller, upper end on a disc) on the wall towards smaller lift"
    )
    free_ends: Literal["half-space", "mirrored"] = Field(
        "half-space", description="where an end bears: supported as by a half-space that goes on (harder), or without "
        "the roller's part of that support, by its mirrored pressure (approximate)"
    )

    @model_validator(mode="after")
    def _has_ends(self) -> Self:
        if self.end_radius > 0.5 * self.diameter:
            most = 0.5 * self.diameter
            raise ValueError(f"end_radius = {self.end_radius:g}: allowed: at most half the diameter, {most:g} mm")
        return self

    @property
    def ends(self) -> Ends:
        """How it ends and stands against its flank."""
        return Ends(self.end_radius, 0.0, radians(self.misalignment_deg), self.free_ends == "mirrored")


class CylinderRoller(_Ended):
    """A cylindrical roller."""

    shape: Literal["cylinder"] = "cylinder"
    length: Length = Field(description="mm, contact length with the flank")

    def meridian(self, centre: float, tip_sign: float) -> Meridian:
        """The meridian with its middle at delta = centre."""
        del tip_sign
        return Straight(0.5 * self.diameter, centre)


class ConeRoller(_Ended):
    """A conical roller, narrower at its free end."""

    shape: Literal["cone"]
    diameter: Length = Field(description="mm, at the middle of the contact length")
    length: Length = Field(description="mm, contact length with the flank, along the axis")
    half_angle: Annotated[float, Field(gt=-80.0, lt=80.0)] = Field(
        description="deg, half the cone angle; positive narrows towards the free end"
    )

    @model_validator(mode="after")
    def _has_no_point(self) -> Self:
        most = degrees(atan2(self.diameter, self.length))
        if abs(self.half_angle) >= most:
            raise ValueError(
                f"half_angle = {self.half_angle:g}: the cone comes to its point within the contact length of "
                f"{self.length:g} mm; allowed: less than {most:.6g} deg either way, or a shorter length"
            )
        return self

    @property
    def steepest(self) -> float:
        """The sine of its half angle, all along."""
        return abs(sin(radians(self.half_angle)))

    def meridian(self, centre: float, tip_sign: float) -> Meridian:
        """The meridian with its middle at delta = centre."""
        return Straight(0.5 * self.diameter, centre, cone_slope(radians(self.half_angle), tip_sign))


class CrownedRoller(_Ended):
    """A roller thickest in the middle of the contact length: its meridian is an arc, or runs out by a logarithm.

    What it runs on is either the flank of a cylinder as thick as its crest, which it touches in a point, or its own
    envelope, which it touches in a line: the second bears more, and has to be cut by a tool of the same meridian.
    """

    shape: Literal["crowned"]
    diameter: Length = Field(description="mm, at the crest")
    length: Length = Field(description="mm, contact length with the flank")
    crown: Literal["circular", "logarithmic"] = Field(
        "circular", description="the meridian: an arc of crown_radius, or a logarithmic run-out (crown_factor), which "
        "carries along all of the roller and ends without an edge"
    )
    crown_radius: Length | None = Field(
        None, description="mm, crown = circular: radius of the meridian arc, at least half the diameter"
    )
    crown_factor: Annotated[float, Field(gt=0.0, le=0.1, allow_inf_nan=False)] = Field(
        RUN_OUT, description="crown = logarithmic: the drop at x from the middle is crown_factor * diameter * "
        "ln(1 / (1 - (2 x / length)^2)); 0.00035 is that of ISO/TS 16281"
    )
    flank: Literal["straight", "conforming"] = Field(
        "straight", description="the cam's flank: cut by the cylinder of the crest's diameter (the crown touches it in "
        "a point), or by the crown itself (a line; drums and the grooves of turrets)"
    )

    @model_validator(mode="after")
    def _has_one_meridian(self) -> Self:
        if self.crown == "circular":
            if self.crown_radius is None:
                raise ValueError("crown_radius is missing: a length in mm, or crown = 'logarithmic'")
            if "crown_factor" in self.model_fields_set:
                raise ValueError("crown_factor: only crown = 'logarithmic' has it; the arc has a crown_radius")
        elif self.crown_radius is not None:
            raise ValueError("crown_radius: only crown = 'circular' has it; the run-out has a crown_factor")
        elif self.flank == "conforming":
            raise ValueError("flank = 'conforming': a logarithmic run-out is made for a straight flank")
        elif self.end_radius:
            raise ValueError("end_radius: a logarithmic run-out has left the flank before its end")
        return self

    @model_validator(mode="after")
    def _has_no_point(self) -> Self:
        radius = 0.5 * self.diameter
        if self.crown_radius is None:
            return self
        if self.crown_radius < radius:
            text = f"crown_radius = {self.crown_radius:g}: allowed: at least half the diameter, {radius:g} mm"
            raise ValueError(text)
        most = 2.0 * sqrt(radius * (2.0 * self.crown_radius - radius))
        if self.length >= most:
            raise ValueError(
                f"length = {self.length:g}: the crown brings the roller to a point within it; allowed: less than "
                f"{most:.6g} mm for a crown_radius of {self.crown_radius:g}, or a larger crown_radius"
            )
        return self

    @property
    def ends(self) -> Ends:
        """How it ends and stands against its flank."""
        run_out = self.crown_factor * self.diameter if self.crown == "logarithmic" else 0.0
        return replace(super().ends, run_out=run_out)

    @property
    def arc(self) -> float | None:
        """Radius of its crown, mm, on a straight flank; None of a run-out and of a flank that conforms."""
        return self.crown_radius if self.flank == "straight" else None

    def meridian(self, centre: float, tip_sign: float) -> Meridian:
        """The meridian with its crest at delta = centre; the micrometres of a run-out are left to the contact."""
        del tip_sign
        if self.crown_radius is None:
            return Straight(0.5 * self.diameter, centre)
        return Arc(0.5 * self.diameter, centre, self.crown_radius)


class SphereRoller(_Bearing):
    """A ball; `length` is the height of flank it touches, measured from the tip side of the equator."""

    shape: Literal["sphere"]
    length: Length | None = Field(None, description="mm, contact height below the equator; default 0.35 diameters")

    @model_validator(mode="after")
    def _ends_on_the_ball(self) -> Self:
        if (self.length or 0.0) >= 0.5 * self.diameter:
            raise ValueError(f"length = {self.length:g}: allowed: below the ball's radius, {0.5 * self.diameter:g} mm")
        return self

    @property
    def steepest(self) -> float:
        """Its share where the flank ends."""
        return 2.0 * (self.length or 0.35 * self.diameter) / self.diameter

    def meridian(self, centre: float, tip_sign: float) -> Meridian:
        """The meridian with the ball's centre at delta = centre."""
        del tip_sign
        return Arc(0.5 * self.diameter, centre, 0.5 * self.diameter)


AnyRoller = CylinderRoller | ConeRoller | CrownedRoller | SphereRoller


class Follower(Section, ABC):
    """What the cam drives. Every follower answers every question of this module, also where it has no such key."""

    rotating: ClassVar[bool]
    """True where its coordinate is an angle: positions in degrees, inertia for mass."""
    pressure_angle_limit: ClassVar[float]
    """deg, customary, where the profile states none"""
    shares: ClassVar[bool] = False
    """True where several rollers share what it has to bear: a turret's"""

    @property
    def square(self) -> bool:
        """Whether what slides on a planar cam is flat and moves square to itself."""
        return False

    @property
    def face_end(self) -> float | None:
        """Where a flat face ends whose width is not stated, mm from the pivot; None: nowhere."""
        return None

    @property
    def swing_radius(self) -> float:
        """From the axis about which it swings or turns to its roller, mm; 0 where it slides."""
        return 0.0

    @property
    def way(self) -> float:
        """Sign of the angle, seen from the cam, by which a growing lift turns the arm of a planar cam; +1 of others."""
        return 1.0

    @abstractmethod
    def moving(self, load_mass: float, load_inertia: float) -> float:
        """Mass, kg, or inertia, kg m2, of the follower with the load that it carries."""


class TranslatingFollower(Follower):
    """A follower that slides."""

    rotating: ClassVar[bool] = False
    pressure_angle_limit: ClassVar[float] = 30.0

    kind: Literal["translating"] = "translating"
    mass: Mass = Field(0.0, description="kg, all that moves with the follower")
    offset: SignedLength = Field(0.0, description="mm, disc cams: offset of the follower's line towards +Y")
    face: Face = Field("roller", description="disc cams: what touches the cam")
    face_radius: Length | None = Field(None, description="mm, face = curved: radius of the mushroom's face")
    face_width: Length | None = Field(None, description="mm, face = flat: width of the face, centred on its line")
    clearance: Gap = Field(0.0, description="mm, conjugate cams: play of the slide between the two cams")

    @property
    def square(self) -> bool:
        """Whether its face is flat."""
        return self.face == "flat"

    def moving(self, load_mass: float, load_inertia: float) -> float:
        """Mass, kg, of the follower with its load."""
        del load_inertia
        return self.mass + load_mass


class SwingingFollower(Follower):
    """A follower that swings about a fixed pivot."""

    rotating: ClassVar[bool] = True
    pressure_angle_limit: ClassVar[float] = 45.0
    offset: ClassVar[float] = 0.0

    kind: Literal["swinging"]
    arm: Length = Field(description="mm, pivot to roller centre")
    inertia: Inertia = Field(0.0, description="kg m2 about the pivot")
    pivot_distance: Length | None = Field(
        None, description="mm, cylindrical cams: distance of the pivot axis from the cam axis; default centres the arc"
    )
    start_angle: Degrees = Field(
        0.0, description="deg, arm angle at zero lift: cylindrical cams from the tangent, linear cams from the travel"
    )
    clearance: Gap = Field(0.0, description="mm, conjugate cams: play of the roller between the two cams")
    side: Literal["left", "right"] = Field(
        "left", description="disc cams: the arm's contact on the +Y side (left, seen from the cam) or the -Y side; "
        "linear cams: the pivot towards -X (left) or +X of the roller"
    )
    face: Face = Field("roller", description="disc cams: what touches the cam")
    face_radius: Length | None = Field(None, description="mm, face = curved: radius of the face")
    face_offset: SignedLength = Field(0.0, description="mm, face = flat: from the pivot back to the face's line")
    face_width: Length | None = Field(None, description="mm, face = flat: length of the face, from the pivot on")

    @property
    def square(self) -> bool:
        """Whether its face is flat and passes through the pivot."""
        return self.face == "flat" and self.face_offset == 0.0

    @property
    def face_end(self) -> float:
        """The end of the arm."""
        return self.arm

    @property
    def swing_radius(self) -> float:
        """The arm, mm."""
        return self.arm

    @property
    def way(self) -> float:
        """+1 of an arm on the left, -1 on the right."""
        return 1.0 if self.side == "left" else -1.0

    def moving(self, load_mass: float, load_inertia: float) -> float:
        """Inertia, kg m2, of the arm with its load."""
        del load_mass
        return self.inertia + load_inertia


class TurretFollower(Follower):
    """An indexing turret with rollers on a circle."""

    rotating: ClassVar[bool] = True
    pressure_angle_limit: ClassVar[float] = 50.0  # T/WLJC 15-2018
    shares: ClassVar[bool] = True
    # In use (T/WLJC 15-2018): below 3 the pressure angle grows, above 24 preload tends to jam.
    usual_stops: ClassVar[tuple[int, int]] = (3, 24)
    offset: ClassVar[float] = 0.0
    clearance: ClassVar[float] = 0.0
    face: ClassVar[Face] = "roller"
    face_width: ClassVar[float | None] = None

    kind: Literal["turret"]
    stops: Annotated[int, Field(ge=1, le=48)] = Field(description="stops in one turn of the turret, 1 to 48")
    rollers: Annotated[int, Field(ge=2, le=192)] | None = Field(None, description="rollers; default: one per stop")
    pitch_radius: Length = Field(description="mm, turret axis to the middle of the roller's contact length")
    inertia: Inertia = Field(0.0, description="kg m2 of the turret and its load")

    @property
    def swing_radius(self) -> float:
        """The pitch radius, mm."""
        return self.pitch_radius

    @property
    def count(self) -> int:
        """Number of rollers on the turret."""
        return self.rollers or self.stops

    def moving(self, load_mass: float, load_inertia: float) -> float:
        """Inertia, kg m2, of the turret with its load."""
        del load_mass
        return self.inertia + load_inertia


class FrameFollower(Follower):
    """A frame with two parallel flat faces (or two rollers) about a constant-width cam."""

    rotating: ClassVar[bool] = False
    pressure_angle_limit: ClassVar[float] = 45.0
    offset: ClassVar[float] = 0.0
    face: ClassVar[Face] = "flat"

    kind: Literal["frame"]
    mass: Mass = Field(0.0, description="kg")
    clearance: Gap = Field(0.0, description="mm, total play between frame and cam")
    face_width: Length | None = Field(None, description="mm, width of each face, centred on the cam axis")
    plate_length: Length | None = Field(
        None, description="mm, outside of the frame's plate along its motion; with plate_width and face_width the "
        "frame is made as a part"
    )
    plate_width: Length | None = Field(None, description="mm, outside of the frame's plate across its motion")
    plate_thickness: Length | None = Field(
        None, description="mm, of the plate along the cam axis, both about one middle plane; default: the cam's width"
    )
    window_width: Length | None = Field(
        None, description="mm, width of the plate's window, which the cam turns in; default: the faces', face_width"
    )
    face_height: Gap = Field(
        0.0, description="mm, by which faces narrower than the window stand out of its ends, as pads or shims do"
    )
    window_radius: Gap = Field(
        0.0, description="mm, of the window's corners beside such faces, as the tool leaves them; 0: sharp"
    )
    guide_bore: Gap = Field(
        0.0, description="mm, diameter of two bores for guide rods, through the bars beside the window along the "
        "motion; 0 leaves them out"
    )
    guide_spacing: Length | None = Field(
        None, description="mm, between the axes of the guide bores; default: in the middle of the bars"
    )

    @property
    def square(self) -> bool:
        """Whether it has faces, and no rollers: always, where it is asked of what slides."""
        return True

    def moving(self, load_mass: float, load_inertia: float) -> float:
        """Mass, kg, of the frame with its load."""
        del load_inertia
        return self.mass + load_mass


AnyFollower = TranslatingFollower | SwingingFollower | TurretFollower | FrameFollower


@immutable(eq=True)
class Setup:
    """What drives a cam: follower, roller (None for flat and knife followers) and the motion round the cam.

    corner  corner radius of the tool that cuts it, mm, where the profile names one
    second  the return roller of a pair, where it is another one
    carriage  of a cam that slides: the program is then the motion over the turn of its drive
    """

    follower: AnyFollower
    roller: AnyRoller | None
    program: Program
    corner: float = 0.0
    second: AnyRoller | None = None
    carriage: "Carriage | None" = None
