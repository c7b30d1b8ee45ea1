"""Constant-width cam: driven to and fro inside a frame with two parallel faces, or between the two rollers of a yoke.

The rise half of the motion is given; the return follows from it, s(theta + pi) = h - s(theta), so that the supports of
opposite tangents add up to one width 2 base_radius + h (frame), or opposite radii of the pitch curve to one diameter
2 (base_radius + r) + h (yoke).
"""

from __future__ import annotations

from math import pi
from typing import ClassVar, Literal

from pydantic import Field

from camgeom.cams._plate import SLIDE, bore_problems, lift_range, problem, roller_track
from camgeom.errors import Problem
from camgeom.keys import Gap, Length, Section
from camgeom.solid import Part
from camgeom.solid.blank import Bore
from camgeom.solid.prism import Loop, Prism
from camgeom.track import Track
from camgeom.track.follower import Setup
from camgeom.track.outline import FaceOutline, FlatFace, Outline, RollerOutline
from camgeom.track.touch import Touch


class Cam(Section):
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

    @property
    def sense(self) -> float:
        """+1 counter-clockwise, -1 clockwise."""
        return 1.0 if self.direction == "ccw" else -1.0

    def quoted_radius(self, setup: Setup) -> float:
        """Middle of the contact along the roller axis, mm (a height z)."""
        return 0.5 * sum(self.contact(setup))

    def contact(self, setup: Setup) -> tuple[float, float]:
        """Heights z between which cam and follower touch, mm."""
        length = min(self.width, (setup.roller.length if setup.roller else None) or self.width)
        return 0.5 * (self.width - length), 0.5 * (self.width + length)

    def span_between(self, setup: Setup) -> float:
        """Constant width of the cam (frame), or constant distance of the roller centres (yoke), mm."""
        stroke = lift_range(setup.program)[1]
        return 2.0 * (self.base_radius + _radius(setup)) + stroke

    def problems(self, setup: Setup) -> list[Problem]:
        """What cannot be built, with key, value and allowed range."""
        found = bore_problems(self.bore, self.keyway_width, self.keyway_depth, self.base_radius)
        roller = setup.roller
        if roller is not None and roller.shape not in ("cylinder", "crowned"):
            found.append(problem("roller.shape", roller.shape, "cylinder or crowned on a constant-width cam"))
        low, high = lift_range(setup.program)
        if low < -1e-9 * max(high, 1.0):
            found.append(problem("motion.to", low, "0 or above: the rise half starts from the lowest position"))
        return found

    def tracks(self, setup: Setup) -> tuple[Track, ...]:
        """The two rollers of a yoke; none for a frame."""
        if setup.roller is None:
            return ()
        low, high = self.contact(setup)
        meridian = setup.roller.meridian(0.5 * (low + high), 1.0)
        near = self.base_radius + _radius(setup)
        far = near - self.span_between(setup)
        return tuple(
            roller_track(name, setup.program, self.sense, (x, 0.0, 0.0), SLIDE, meridian, (low, high))
            for name, x in (("near roller", near), ("far roller", far))
        )

    def outlines(self, setup: Setup) -> dict[str, Outline]:
        """Profile (and pitch curve of a yoke's cam) by name."""
        tracks = self.tracks(setup)
        if not tracks:
            return {"profile": FaceOutline(FlatFace(setup.program, self.sense, self.base_radius))}
        radius = _radius(setup)
        return {"profile": RollerOutline(tracks[0], -radius), "pitch curve": RollerOutline(tracks[0], 0.0)}

    def touches(self, setup: Setup) -> tuple[Touch, ...]:
        """The two contacts that drive the frame to and fro."""
        low, high = self.contact(setup)
        length, radius = high - low, _radius(setup)
        tracks = self.tracks(setup)
        if tracks:
            return tuple(
                Touch(track.name, RollerOutline(track, -radius), SLIDE, self.sense, way, radius, length)
                for track, way in zip(tracks, (1.0, -1.0))
            )
        face = self.outlines(setup)["profile"]
        flat = float("inf")
        return (
            Touch("near face", face, SLIDE, self.sense, 1.0, flat, length, kind="flat"),
            Touch("far face", face, SLIDE, self.sense, -1.0, flat, length, lag=pi, kind="flat"),
        )

    def parts(self, setup: Setup) -> tuple[Part, ...]:
        """The disc."""
        bore = Bore(self.bore, self.keyway_width, self.keyway_depth) if self.bore else None
        return (Prism("cam", Loop(self.outlines(setup)["profile"], "flank"), 0.0, self.width, (), bore),)


def _radius(setup: Setup) -> float:
    return 0.5 * setup.roller.diameter if setup.roller else 0.0
