"""Cylindrical (barrel) indexing cam: grooves or ribs round a drum, driving a turret whose rollers reach in sideways.

The turret's axis is perpendicular to the cam's and passes it at the centre distance; the rollers stand parallel to the
turret axis on its face and meet the drum one after another while they pass the line of centres.
"""

from __future__ import annotations

from dataclasses import replace
from math import asin, pi, sin, sqrt
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from camgeom.cams._turret import TurretKeys, problem
from camgeom.errors import Problem
from camgeom.keys import Length
from camgeom.solid import Part
from camgeom.solid.blank import Blank
from camgeom.solid.cut import IndexingCut
from camgeom.solid.turret import TurretBody
from camgeom.track import Swing, Track
from camgeom.track.follower import Setup, SphereRoller, TurretFollower
from camgeom.track.section import cylinder_level
from camgeom.track.turret import turret_tracks


class Cam(TurretKeys):
    """A drum -width/2 <= z <= width/2; the turret turns about a line along X through (0, center_distance, 0)."""

    FOLLOWERS: ClassVar[tuple[str, ...]] = ("turret",)

    kind: Literal["cylindrical-index"]
    center_distance: Length = Field(description="mm, cam axis to turret axis")
    diameter: Length = Field(description="mm, outside of the drum")
    width: Length = Field(description="mm, length of the drum along its axis")

    @property
    def radius(self) -> float:
        """Outer radius of the drum, mm."""
        return 0.5 * self.diameter

    def contact(self, setup: Setup) -> tuple[float, float]:
        """Stretch of the roller that touches the flank, from the plane of both axes' feet, mm."""
        roller = setup.roller
        assert roller is not None
        if isinstance(roller, SphereRoller):
            return self.radius - (roller.length or 0.35 * roller.diameter), self.radius
        return self.radius - roller.length, self.radius

    def tip(self, setup: Setup) -> float:
        """Free end of the roller, in the same measure, mm."""
        if isinstance(setup.roller, SphereRoller):
            return self.radius - 0.5 * setup.roller.diameter
        return self.contact(setup)[0]

    def quoted_radius(self, setup: Setup) -> float:
        """Where the classical figures are quoted: the middle of the contact, mm from the cam axis."""
        return 0.5 * sum(self.contact(setup))

    def floor_radius(self, setup: Setup) -> float:
        """Distance of the floor's edges from the cam axis, mm."""
        return self.tip(setup) - self.tip_clearance

    def _clear_angle(self, setup: Setup) -> float:
        """Turret angle (rad) from the line of centres beyond which a tool is clear of the drum."""
        assert setup.roller is not None
        assert isinstance(setup.follower, TurretFollower)
        reach = (0.5 * self.width + 0.5 * setup.roller.diameter + self.running_clearance) / setup.follower.pitch_radius
        return 1.02 * asin(reach) + 0.01 if reach < 0.95 else 0.5 * pi

    def problems(self, setup: Setup) -> list[Problem]:
        """What cannot be built, with key, value and allowed range."""
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TurretFollower)
        if roller is None:
            return [Problem("roller", "a cylindrical indexing cam needs rollers", None, "a [roller] table")]
        found = self.key_problems(setup) + self._reach_problems(setup, follower, 0.5 * roller.diameter)
        room = 2.0 * follower.pitch_radius * sin(0.5 * self.roller_pitch(follower))
        if room <= roller.diameter:
            limit = f"below {room:g} mm, the distance of neighbouring rollers"
            found.append(problem("roller.diameter", roller.diameter, limit))
        return found

    def _reach_problems(self, setup: Setup, follower: TurretFollower, radius: float) -> list[Problem]:
        if 0.5 * self.width + radius >= 0.95 * follower.pitch_radius:
            most = 2.0 * (0.95 * follower.pitch_radius - radius)
            return [problem("cam.width", self.width, f"below {most:g} mm, so that the rollers swing clear of it")]
        floor = self.floor_radius(setup)
        if floor <= 0.0:
            limit = f"below the drum's radius {self.radius:g} mm"
            return [problem("roller.length", self.radius - self.tip(setup), limit)]
        rim = radius + self.running_clearance
        # On the line of centres a roller stands farthest to one side of the drum's axis, at the end faces to the other.
        beside = min(1.0, (0.5 * self.width + rim) / follower.pitch_radius)
        low = follower.pitch_radius - floor + rim
        high = follower.pitch_radius * sqrt(1.0 - beside**2) + floor - rim
        found = []
        if low >= high:
            limit = "narrower, or a larger follower.pitch_radius: nowhere do the rollers stay over the groove floor"
            found.append(problem("cam.width", self.width, limit))
        elif not low < self.center_distance < high:
            limit = f"{low:g} .. {high:g} mm, where rollers stay over the groove floor"
            found.append(problem("cam.center_distance", self.center_distance, limit))
        elif self.bore and self.bore_spec().reach >= sqrt(max(0.0, floor**2 - rim**2)):
            most = sqrt(max(0.0, floor**2 - rim**2))
            found.append(problem("cam.bore", self.bore, f"outline inside the groove floor, {most:g} mm from the axis"))
        return found

    def blank(self, setup: Setup) -> Blank:
        """The drum before the grooves are cut."""
        del setup
        half = 0.5 * self.width
        bore = self.bore_spec() if self.bore else None
        return Blank(((self.radius, -half), (self.radius, half)), bore, (None,), ("land",))

    def tracks(self, setup: Setup) -> tuple[Track, ...]:
        """One track for each start: a roller followed through all its turns while its middle is beside the cam."""
        assert isinstance(setup.follower, TurretFollower)
        reach = asin(min(1.0, 0.5 * self.width / setup.follower.pitch_radius))
        return self._grooves(setup, reach)

    def passages(self, setup: Setup) -> tuple[Track, ...]:
        """The same rollers as long as any part of them may be beside the cam."""
        return self._grooves(setup, self._clear_angle(setup))

    def cutters(self, setup: Setup) -> tuple[Track, ...]:
        """The tools: each followed until clear of the drum, larger by the running clearance and deeper at the tip."""
        if isinstance(setup.roller, SphereRoller):
            tip = self.tip(setup) - self.running_clearance
        else:
            tip = self.floor_radius(setup)
        grooves = self._grooves(setup, self._clear_angle(setup))
        assert isinstance(setup.follower, TurretFollower)
        relief = self.relief_of(setup, -setup.follower.pitch_radius)
        return tuple(replace(g.grown(self.running_clearance), tip=tip, relief=relief) for g in grooves)

    def _grooves(self, setup: Setup, reach: float) -> tuple[Track, ...]:
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TurretFollower)
        assert roller is not None
        low, high = self.contact(setup)
        middle = high if isinstance(roller, SphereRoller) else 0.5 * (low + high)
        first = Track(
            meridian=roller.meridian(middle, -1.0),
            joint=Swing((-self.way, 0.0, 0.0), (0.0, self.center_distance, 0.0)),
            anchor=(0.0, self.center_distance - follower.pitch_radius, 0.0),
            axis=(1.0, 0.0, 0.0),
            tip=self.tip(setup),
            contact=(low, high),
            program=setup.program,
            sense=self.sense,
        )
        base = 0.5 * self.roller_pitch(follower) if self.form == "rib" else 0.0
        return turret_tracks(first, follower.count, base, reach)

    def inside(self, x: np.ndarray) -> np.ndarray:
        """Whether points (3, ...) of the cam frame lie within the drum."""
        return np.asarray((np.hypot(x[0], x[1]) <= self.radius + 1e-9) & (np.abs(x[2]) <= 0.5 * self.width + 1e-9))

    def rib_depths(self, setup: Setup) -> tuple[tuple[str, float], ...]:
        """Where ribs are measured, along the roller, mm: where both walls are still in the drum, and at the root."""
        assert setup.roller is not None
        low, _ = self.contact(setup)
        return ("tip", max(low, sqrt(self.radius**2 - 0.25 * setup.roller.diameter**2) - 1e-6)), ("root", low)

    def gaps(self, setup: Setup) -> tuple[tuple[str, float, str], ...]:
        """Free distances of the turret in mm, each with advice: (name, distance, advice)."""
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TurretFollower)
        assert roller is not None
        between = 2.0 * follower.pitch_radius * sin(0.5 * self.roller_pitch(follower)) - roller.diameter
        found = [("between rollers", between, "fewer rollers, smaller ones, or a larger pitch radius")]
        if not isinstance(roller, SphereRoller):
            found.append(("roller end to floor", self.tip_clearance, "a larger tip_clearance"))
        return tuple(found)

    def turret(self, setup: Setup, cam_angle: float = 0.0) -> TurretBody:
        """The turret with its rollers as it stands at a cam angle (rad)."""
        follower, roller = setup.follower, setup.roller
        assert roller is not None
        assert isinstance(follower, TurretFollower)
        track = self.tracks(setup)[0]
        near, far = self.radius + 2.0, self.radius + 2.0 + 0.6 * roller.diameter
        # The turret's axis points along X or against it with the hand.
        low, high = (near, far) if track.joint.axis[0] > 0.0 else (-far, -near)  # type: ignore[union-attr]
        radius = follower.pitch_radius + 0.6 * roller.diameter
        return TurretBody(track, follower.count, radius, low, high, 0.5 * (near + far), cam_angle)

    def parts(self, setup: Setup) -> tuple[Part, ...]:
        """The cam: drum minus its grooves."""
        assert setup.roller is not None
        top = 1.04 * self.radius
        return (
            IndexingCut(
                "cam",
                self.cutters(setup),
                self.blank(setup),
                cylinder_level(top),
                cylinder_level(self.floor_radius(setup)),
                (top, self.tip(setup)),
                top + 0.5 * setup.roller.diameter,
                1 if self.bore else 0,
            ),
        )
