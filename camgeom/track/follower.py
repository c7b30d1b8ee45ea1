"""Follower and roller as profile sections, and `Setup`: what a cam type is given to place its tracks.

A cam type receives angles already in radians inside the program; sections keep the degrees and mm of the profile.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from math import atan2, degrees, radians, sqrt
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from camgeom.keys import Degrees, Gap, Length, Section, SignedLength
from camgeom.motion.program import Program
from camgeom.track import Arc, Meridian, Straight, cone_slope

Mass = Annotated[float, Field(ge=0.0, le=1e7, allow_inf_nan=False)]
Inertia = Annotated[float, Field(ge=0.0, le=1e9, allow_inf_nan=False)]
Face = Literal["roller", "flat", "knife", "curved"]
Load = Annotated[float, Field(gt=0.0, le=1e9, allow_inf_nan=False)]


class _Bearing(Section):
    """Keys every roller has: its own bearing."""

    dynamic_rating: Load | None = Field(None, description="N, basic dynamic load rating C of the roller's bearing")
    static_rating: Load | None = Field(None, description="N, basic static load rating C0 of the roller's bearing")


class CylinderRoller(_Bearing):
    """A cylindrical roller."""

    shape: Literal["cylinder"] = "cylinder"
    diameter: Length = Field(description="mm")
    length: Length = Field(description="mm, contact length with the flank")

    def meridian(self, centre: float, tip_sign: float) -> Meridian:
        """The meridian with its middle at delta = centre."""
        del tip_sign
        return Straight(0.5 * self.diameter, centre)


class ConeRoller(_Bearing):
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

    def meridian(self, centre: float, tip_sign: float) -> Meridian:
        """The meridian with its middle at delta = centre."""
        return Straight(0.5 * self.diameter, centre, cone_slope(radians(self.half_angle), tip_sign))


class CrownedRoller(_Bearing):
    """A roller whose meridian is an arc, thickest in the middle of the contact length.

    What it runs on is either the flank of a cylinder as thick as its crest, which it touches in a point, or its own
    envelope, which it touches in a line: the second bears more, and has to be cut by a tool of the same meridian.
    """

    shape: Literal["crowned"]
    diameter: Length = Field(description="mm, at the crest")
    length: Length = Field(description="mm, contact length with the flank")
    crown_radius: Length = Field(description="mm, radius of the meridian arc, at least half the diameter")
    flank: Literal["straight", "conforming"] = Field(
        "straight", description="the cam's flank: cut by the cylinder of the crest's diameter (the crown touches it in "
        "a point; drums and discs), or by the crown itself (a line; drums and the grooves of turrets)"
    )

    @model_validator(mode="after")
    def _has_no_point(self) -> Self:
        radius = 0.5 * self.diameter
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

    def meridian(self, centre: float, tip_sign: float) -> Meridian:
        """The meridian with its crest at delta = centre."""
        del tip_sign
        return Arc(0.5 * self.diameter, centre, self.crown_radius)


class SphereRoller(_Bearing):
    """A ball; `length` is the height of flank it touches, measured from the tip side of the equator."""

    shape: Literal["sphere"]
    diameter: Length = Field(description="mm")
    length: Length | None = Field(None, description="mm, contact height below the equator; default 0.35 diameters")

    @model_validator(mode="after")
    def _ends_on_the_ball(self) -> Self:
        if (self.length or 0.0) >= 0.5 * self.diameter:
            raise ValueError(f"length = {self.length:g}: allowed: below the ball's radius, {0.5 * self.diameter:g} mm")
        return self

    def meridian(self, centre: float, tip_sign: float) -> Meridian:
        """The meridian with the ball's centre at delta = centre."""
        del tip_sign
        return Arc(0.5 * self.diameter, centre, 0.5 * self.diameter)


RollerSpec = Annotated[CylinderRoller | ConeRoller | CrownedRoller | SphereRoller, Field(discriminator="shape")]
AnyRoller = CylinderRoller | ConeRoller | CrownedRoller | SphereRoller


class Follower(Section, ABC):
    """What the cam drives. Every follower answers every question of this module, also where it has no such key."""

    rotating: ClassVar[bool]
    """True where its coordinate is an angle: positions in degrees, inertia for mass."""
    pressure_angle_limit: ClassVar[float]
    """deg, customary, where the profile states none"""

    @property
    def swing_radius(self) -> float:
        """From the axis about which it swings or turns to its roller, mm; 0 where it slides."""
        return 0.0

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
    start_angle: Degrees = Field(0.0, description="deg, cylindrical cams: arm angle from the tangent at zero lift")
    clearance: Gap = Field(0.0, description="mm, conjugate cams: play of the roller between the two cams")
    side: Literal["left", "right"] = Field(
        "left", description="disc cams: the arm's contact on the +Y side (left, seen from the cam) or the -Y side"
    )
    face: Face = Field("roller", description="disc cams: what touches the cam")
    face_radius: Length | None = Field(None, description="mm, face = curved: radius of the face")
    face_offset: SignedLength = Field(0.0, description="mm, face = flat: from the pivot back to the face's line")
    face_width: Length | None = Field(None, description="mm, face = flat: length of the face, from the pivot on")

    @property
    def swing_radius(self) -> float:
        """The arm, mm."""
        return self.arm

    def moving(self, load_mass: float, load_inertia: float) -> float:
        """Inertia, kg m2, of the arm with its load."""
        del load_mass
        return self.inertia + load_inertia


class TurretFollower(Follower):
    """An indexing turret with rollers on a circle."""

    rotating: ClassVar[bool] = True
    pressure_angle_limit: ClassVar[float] = 50.0  # T/WLJC 15-2018
    offset: ClassVar[float] = 0.0
    clearance: ClassVar[float] = 0.0
    face: ClassVar[Face] = "roller"
    face_width: ClassVar[float | None] = None

    kind: Literal["turret"]
    stops: Annotated[int, Field(ge=2, le=48)] = Field(description="stops in one turn of the turret, 2 to 48")
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

    def moving(self, load_mass: float, load_inertia: float) -> float:
        """Mass, kg, of the frame with its load."""
        del load_inertia
        return self.mass + load_mass


FollowerSpec = Annotated[
    TranslatingFollower | SwingingFollower | TurretFollower | FrameFollower, Field(discriminator="kind")
]
AnyFollower = TranslatingFollower | SwingingFollower | TurretFollower | FrameFollower


@dataclass(frozen=True)
class Setup:
    """What drives a cam: follower, roller (None for flat and knife followers) and the motion round the cam.

    corner  corner radius of the tool that cuts it, mm, where the profile names one
    """

    follower: AnyFollower
    roller: AnyRoller | None
    program: Program
    corner: float = 0.0
