"""Constant-width cam: driven to and fro inside a frame with two parallel faces, or between the two rollers of a yoke.

The rise half of the motion is given; the return follows from it, s(theta + pi) = h - s(theta), so that the supports of
opposite tangents add up to one width 2 base_radius + h (frame), or opposite radii of the pitch curve to one diameter
2 (base_radius + r) + h (yoke).
"""

from __future__ import annotations

from dataclasses import replace
from math import inf, pi
from typing import ClassVar, Literal, final

from pydantic import Field

from camgeom.cams import NO_DRUM, NO_GAPS, NO_ROOT, REGULAR, Cam, idle, prism_idle, problem, sense_of
from camgeom.cams._plate import (
    SLIDE,
    SQUARE,
    bore_of,
    bore_problems,
    bore_walls,
    disc_wall,
    face_idle,
    lift_range,
    plate_envelope,
    roller_track,
    straight_problems,
)
from camgeom.errors import Problem
from camgeom.immutable import immutable
from camgeom.keys import Gap, Length
from camgeom.maths.frozen import cached_property
from camgeom.solid import Part
from camgeom.solid.blank import Wall
from camgeom.solid.frame import FramePlate
from camgeom.solid.mechanism import Drive, Mechanism
from camgeom.solid.prism import Loop, Prism
from camgeom.track import Track
from camgeom.track.follower import FrameFollower, Setup
from camgeom.track.outline import FaceOutline, FlatFace, Outline, RollerOutline
from camgeom.track.sliding import Slider, SlidingFace
from camgeom.track.touch import Touch

PLATE = (
    "plate_length", "plate_width", "plate_thickness", "window_width", "face_height", "window_radius", "guide_bore",
    "guide_spacing",
)  # fmt: skip
"""keys of a frame that is made as a part"""


@final
class ConstantWidth(Cam):
    """A disc 0 <= z <= width in a frame that slides along X; the near face (or roller) stands on the +X side."""

    FOLLOWERS: ClassVar[tuple[str, ...]] = ("frame",)
    MOTION_SPAN: ClassVar[float] = 180.0

    kind: Literal["constant-width"]
    base_radius: Length = Field(description="mm, near face (yoke: profile) from the cam axis at zero lift")
    width: Length = Field(description="mm, thickness of the disc")
    bore: Gap = Field(0.0, description="mm, bore diameter; 0 leaves the disc whole")
    keyway_width: Gap = Field(0.0, description="mm; 0 leaves the keyway out")
    keyway_depth: Gap = Field(0.0, description="mm, from the bore wall")
    direction: Literal["ccw", "cw"] = Field("ccw", description="the cam's turning, seen from +Z")

    def mechanism(self, setup: Setup) -> ConstantWidthMechanism:
        """The disc with its frame or yoke."""
        assert isinstance(setup.follower, FrameFollower)
        return ConstantWidthMechanism(
            follower=setup.follower,
            roller=setup.roller,
            program=setup.program,
            sense=sense_of(self.direction),
            drive=Drive.OPPOSED,
            width=self.width,
            bore=bore_of(self.bore, self.keyway_width, self.keyway_depth),
            base_radius=self.base_radius,
            cam=self,
        )

    def idle(self, setup: Setup) -> dict[str, str]:
        """Keys of the other of frame (flat faces) and yoke (rollers)."""
        found = NO_DRUM | REGULAR | NO_ROOT | prism_idle(self.bore)
        faces = {key: why for key, why in face_idle("flat").items() if key.startswith(("limits.", "material."))}
        if setup.roller is not None:
            plate = idle("a yoke carries rollers, and is not made as a part", *(f"follower.{key}" for key in PLATE))
            return found | NO_GAPS | plate | idle("a yoke's rollers touch the cam, no faces", "follower.face_width")
        found |= faces | SQUARE | idle("a frame has no rollers", "impact.roller_inertia")
        follower = setup.follower
        assert isinstance(follower, FrameFollower)
        if follower.plate_length is None and follower.plate_width is None:
            reason = "no plate: give follower.plate_length, plate_width and face_width, mm, and the frame is a part"
            return found | NO_GAPS | idle(reason, *(f"follower.{key}" for key in PLATE[2:]))
        return found if follower.guide_bore else found | idle("no guide_bore", "follower.guide_spacing")

    def problems(self, setup: Setup) -> list[Problem]:
        """What cannot be built, with key, value and allowed range."""
        found = bore_problems(self.bore, self.keyway_width, self.keyway_depth, self.base_radius)
        roller = setup.roller
        if roller is not None and roller.shape not in ("cylinder", "crowned"):
            found.append(problem("roller.shape", roller.shape, "cylinder or crowned on a constant-width cam"))
        found += straight_problems(setup.roller)
        low, high = lift_range(setup.program)
        if low < -1e-9 * max(high, 1.0):
            found.append(problem("motion.to", low, "0 or above: the rise half starts from the lowest position"))
        follower = setup.follower
        assert isinstance(follower, FrameFollower)
        length, width = follower.plate_length, follower.plate_width
        if roller is None and (length or width):
            sizes = {"plate_length": length, "plate_width": width, "face_width": follower.face_width}
            missing = [Problem(f"follower.{key}", "a frame that is made as a part needs it", None, "a length in mm")
                       for key, value in sizes.items() if value is None]  # fmt: skip
            plate = frame_plate(self, follower, high)
            found += missing or (plate.problems() if plate is not None else [])
        return found


def frame_plate(cam: ConstantWidth, follower: FrameFollower, stroke: float) -> FramePlate | None:
    """The frame as it stands at zero lift; None where the profile does not make it a part."""
    length, width, face = follower.plate_length, follower.plate_width, follower.face_width
    if length is None or width is None or face is None:
        return None
    window = face if follower.window_width is None else follower.window_width
    spacing = 0.5 * (window + width) if follower.guide_spacing is None else follower.guide_spacing
    return FramePlate(
        middle=-0.5 * stroke,
        height=0.5 * cam.width,
        length=length,
        width=width,
        thickness=follower.plate_thickness or cam.width,
        opening=2.0 * cam.base_radius + stroke + follower.clearance,
        window=window,
        face=face,
        rise=follower.face_height,
        corner=follower.window_radius,
        bore=follower.guide_bore,
        spacing=spacing,
    )


@final
@immutable(kw_only=True)
class ConstantWidthMechanism(Mechanism):
    """A constant-width cam in its frame or yoke."""

    follower: FrameFollower
    cam: ConstantWidth

    @property
    def quoted_radius(self) -> float:
        """Middle of the contact along the roller axis, mm (a height z)."""
        return 0.5 * sum(self.contact)

    @property
    def contact(self) -> tuple[float, float]:
        """Heights z between which cam and follower touch, mm."""
        width = self.cam.width
        held = self.roller.length if self.roller else self.frame.thickness if self.frame else None
        length = min(width, held or width)
        return 0.5 * (width - length), 0.5 * (width + length)

    @property
    def _radius(self) -> float:
        return 0.5 * self.roller.diameter if self.roller else 0.0

    @property
    def _span(self) -> float:
        """Constant width of the cam (frame), or constant distance of the roller centres (yoke), mm."""
        return 2.0 * (self.cam.base_radius + self._radius) + lift_range(self.program)[1]

    @property
    def fit_size(self) -> float:
        """Width of the cam between what holds it, mm."""
        return self._span - 2.0 * self._radius

    @property
    def span_between(self) -> float | None:
        """Constant width of a cam in a frame, mm; a yoke has no faces."""
        return self._span if self.roller is None else None

    @cached_property
    def tracks(self) -> tuple[Track, ...]:
        """The two rollers of a yoke; none for a frame."""
        if self.roller is None:
            return ()
        low, high = self.contact
        meridian = self.roller.meridian(0.5 * (low + high), 1.0)
        near = self.cam.base_radius + self._radius
        return tuple(
            roller_track(name, self.program, self.sense, (x, 0.0, 0.0), SLIDE, meridian, (low, high))
            for name, x in (("near roller", near), ("far roller", near - self._span))
        )

    @property
    def lags(self) -> tuple[float, ...]:
        """Both rollers or faces run on the one profile, half a turn apart."""
        return (0.0, pi)

    @cached_property
    def sliders(self) -> tuple[Slider, ...]:
        """The two faces of a frame; none of a yoke."""
        if self.tracks:
            return ()
        near = FlatFace(self.program, self.sense, self.cam.base_radius)
        return SlidingFace("near face", near), SlidingFace("far face", replace(near, span=self._span))

    @cached_property
    def outlines(self) -> dict[str, Outline]:
        """Profile (and pitch curve of a yoke's cam) by name."""
        if not self.tracks:
            return {"profile": FaceOutline(FlatFace(self.program, self.sense, self.cam.base_radius))}
        near = self.tracks[0]
        return {"profile": RollerOutline(near, -self._radius), "pitch curve": RollerOutline(near, 0.0)}

    @cached_property
    def envelope(self) -> tuple[float, float]:
        """Of the profile."""
        return plate_envelope([self.outlines["profile"]], self.width)

    @cached_property
    def touches(self) -> tuple[Touch, ...]:
        """The two contacts that drive the frame to and fro."""
        low, high = self.contact
        length, radius, sense = high - low, self._radius, self.sense
        if self.tracks:
            return tuple(
                Touch(track.name, RollerOutline(track, -radius), SLIDE, sense, way, radius, length)
                for track, way in zip(self.tracks, (1.0, -1.0))
            )
        face = self.outlines["profile"]
        return (
            Touch("near face", face, SLIDE, sense, 1.0, inf, length, kind="flat"),
            Touch("far face", face, SLIDE, sense, -1.0, inf, length, lag=pi, kind="flat"),
        )

    @cached_property
    def walls(self) -> tuple[Wall, ...]:
        """The disc itself, profile to bore, and what is left of the frame."""
        own = disc_wall("cam", self.width), *bore_walls("profile", self.outlines["profile"], self.bore)
        return own if self.frame is None else (*own, *self.frame.walls)

    @cached_property
    def frame(self) -> FramePlate | None:
        """The frame as a part."""
        return None if self.roller else frame_plate(self.cam, self.follower, lift_range(self.program)[1])

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """The disc."""
        return (Prism("cam", Loop(self.outlines["profile"], "flank"), 0.0, self.cam.width, (), self.bore),)
