"""Globoidal indexing cam: a rib or groove cam on a globoid, driving a turret whose axis crosses its own."""

from __future__ import annotations

from dataclasses import replace
from math import asin, cos, hypot, sin, sqrt, tan
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from camgeom.cams._turret import TurretKeys, problem
from camgeom.errors import Problem
from camgeom.keys import Gap, Length
from camgeom.solid import Part
from camgeom.solid.blank import Blank, Globoid
from camgeom.solid.cut import IndexingCut
from camgeom.solid.lands import GloboidLevel
from camgeom.solid.turret import TurretBody
from camgeom.track import Swing, Track
from camgeom.track.follower import Setup, SphereRoller, TurretFollower
from camgeom.track.turret import turret_tracks


class Cam(TurretKeys):
    """A globoid -width/2 <= z <= width/2; the turret turns about an axis parallel to Y at (center_distance, 0, 0)."""

    FOLLOWERS: ClassVar[tuple[str, ...]] = ("turret",)

    kind: Literal["globoidal"]
    center_distance: Length = Field(description="mm, cam axis to turret axis")
    width: Length = Field(description="mm, length of the cam along its axis")
    globoid_radius: Length = Field(description="mm, radius of the blank's outside about the turret axis")
    preload: Gap = Field(
        0.0, description="mm, by which rollers press into the ribs they ride in the dwell, by a closer centre distance"
    )
    hub_diameter: Gap = Field(0.0, description="mm, hubs on both ends; 0 leaves them out")
    hub_length: Gap = Field(0.0, description="mm, length of each hub beyond the end face")

    @property
    def globoid(self) -> Globoid:
        """The blank's shape."""
        bore = self.bore_spec() if self.bore else None
        size = self.center_distance, self.width, self.globoid_radius
        return Globoid(*size, bore, self.hub_diameter, self.hub_length)

    @property
    def end_radius(self) -> float:
        """Radius of the blank at its end faces (its largest), mm."""
        return self.globoid.end_radius

    def centre_shift(self, setup: Setup) -> float:
        """By how much the turret is set closer than the cam was cut for, mm.

        In the dwell a flank's normal lies at the roller's angle tau from the line across the centres, so that a shift
        presses the roller in by shift * sin(tau): tau is half the roller pitch for a rib, the pitch for a groove.
        """
        assert isinstance(setup.follower, TurretFollower)
        share = 0.5 if self.form == "rib" else 1.0
        return self.preload / sin(share * self.roller_pitch(setup.follower))

    def allowed_interference(self, setup: Setup) -> float:
        """By how much a roller may stand in the cam on purpose, mm (the preload at its steepest)."""
        return self.centre_shift(setup)

    def contact(self, setup: Setup) -> tuple[float, float]:
        """Stretch of the roller that touches the flank, from the turret axis, mm."""
        roller, middle = setup.roller, self.quoted_radius(setup)
        assert roller is not None
        if isinstance(roller, SphereRoller):
            return middle, middle + (roller.length or 0.35 * roller.diameter)
        return middle - 0.5 * roller.length, middle + 0.5 * roller.length

    def tip(self, setup: Setup) -> float:
        """Free end of the roller, from the turret axis, mm."""
        if isinstance(setup.roller, SphereRoller):
            return self.quoted_radius(setup) + 0.5 * setup.roller.diameter
        return self.contact(setup)[1]

    def quoted_radius(self, setup: Setup) -> float:
        """Where the classical figures are quoted, from the turret axis, mm."""
        assert isinstance(setup.follower, TurretFollower)
        return setup.follower.pitch_radius

    def problems(self, setup: Setup) -> list[Problem]:
        """What cannot be built, with key, value and allowed range."""
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TurretFollower)
        if roller is None:
            return [Problem("roller", "a globoidal cam needs rollers", None, "a [roller] table")]
        return [*self.key_problems(setup), *self._size_problems(setup), *self._turret_problems(setup, follower)]

    def _size_problems(self, setup: Setup) -> list[Problem]:
        found = []
        follower = setup.follower
        assert isinstance(follower, TurretFollower)
        radii = {"follower.pitch_radius": follower.pitch_radius, "cam.globoid_radius": self.globoid_radius}
        for key, radius in radii.items():
            if radius >= self.center_distance:
                return [problem(key, radius, f"below the centre distance {self.center_distance:g} mm")]
        if 0.5 * self.width >= self.globoid_radius:
            limit = f"below twice the globoid radius, {2.0 * self.globoid_radius:g} mm"
            return [problem("cam.width", self.width, limit)]
        floor_radius = self.center_distance - self.floor_radius(setup)
        if floor_radius <= 0.0:
            most = follower.pitch_radius + floor_radius
            limit = f"below {most:g} mm, where the groove floor reaches the cam axis"
            found.append(problem("follower.pitch_radius", follower.pitch_radius, limit))
        elif self.bore and self.bore_spec().reach >= floor_radius:
            limit = f"outline inside the groove floor, {floor_radius:g} mm from the axis"
            found.append(problem("cam.bore", self.bore, limit))
        if not self.contact(setup)[0] - 1e-9 <= self.globoid_radius < self.contact(setup)[1]:
            limit = f"{self.contact(setup)[0]:g} .. {self.contact(setup)[1]:g} mm, within the roller's contact length"
            found.append(problem("cam.globoid_radius", self.globoid_radius, limit))
        return [*found, *self.globoid.hub_problems(self.floor_radius(setup))]

    def _turret_problems(self, setup: Setup, follower: TurretFollower) -> list[Problem]:
        found = []
        pitch = self.roller_pitch(follower)
        roller = setup.roller
        assert roller is not None
        radius = 0.5 * roller.diameter
        room = 2.0 * self.contact(setup)[0] * sin(0.5 * pitch)
        if room <= 2.0 * radius:
            limit = f"below {room:g} mm, the distance of neighbouring rollers at their inner end"
            found.append(problem("roller.diameter", roller.diameter, limit))
        half = 0.5 * pitch
        if radius * cos(half) >= self.globoid_radius * sin(half):
            limit = f"below {2.0 * self.globoid_radius * tan(half):g} mm, so that ribs keep a tip at the globoid radius"
            found.append(problem("roller.diameter", roller.diameter, limit))
        rib = 2.0 * (self.globoid_radius * sin(half) - radius * cos(half))
        if self.form == "rib" and self.width <= rib:
            found.append(problem("cam.width", self.width, f"above {rib:g} mm, so that rollers stand beside the rib"))
        return found

    def blank(self, setup: Setup) -> Blank:
        """The globoid before the grooves are cut."""
        del setup
        return self.globoid.blank()

    def tracks(self, setup: Setup) -> tuple[Track, ...]:
        """One track for each start: a roller followed through all its turns while its middle is beside the cam."""
        reach = asin(min(1.0, 0.5 * self.width / self.quoted_radius(setup)))
        return self._grooves(setup, reach, self.center_distance - self.centre_shift(setup))

    def passages(self, setup: Setup) -> tuple[Track, ...]:
        """The same rollers as long as any part of them may be beside the cam."""
        return self._grooves(setup, self._clear_angle(setup), self.center_distance - self.centre_shift(setup))

    def cutters(self, setup: Setup) -> tuple[Track, ...]:
        """The tools: each followed until clear of the blank, larger by the running clearance and deeper at the tip."""
        grooves = self._grooves(setup, self._clear_angle(setup), self.center_distance)
        floor = self.floor_radius(setup)
        relief = self.relief_of(setup, self.quoted_radius(setup))
        return tuple(replace(g.grown(self.running_clearance), tip=floor, relief=relief) for g in grooves)

    def _grooves(self, setup: Setup, reach: float, centre: float) -> tuple[Track, ...]:
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TurretFollower)
        assert roller is not None
        first = Track(
            meridian=roller.meridian(follower.pitch_radius, 1.0),
            joint=Swing((0.0, self.way, 0.0), (centre, 0.0, 0.0)),
            anchor=(centre, 0.0, 0.0),
            axis=(-1.0, 0.0, 0.0),
            tip=self.tip(setup),
            contact=self.contact(setup),
            program=setup.program,
            sense=self.sense,
        )
        base = 0.5 * self.roller_pitch(follower) if self.form == "rib" else 0.0
        return turret_tracks(first, follower.count, base, reach)

    def _clear_angle(self, setup: Setup) -> float:
        """Turret angle (rad) from the line of centres beyond which a tool is clear of the blank."""
        assert setup.roller is not None
        tool = 0.5 * setup.roller.diameter + self.running_clearance + self.relief
        return self.globoid.clear_angle(self.top_radius(setup), tool)

    def top_radius(self, setup: Setup) -> float:
        """Distance from the turret axis at which groove bodies end, outside the blank, mm."""
        beyond = 0.05 * self.globoid_radius
        if isinstance(setup.roller, SphereRoller):
            # A ball ends half its diameter above its middle, which stands below the blank's outside.
            beyond = min(beyond, 0.25 * setup.roller.diameter)
        return self.globoid_radius - beyond

    def floor_radius(self, setup: Setup) -> float:
        """Distance of the floor's edges from the turret axis, mm.

        Rims of the rollers' ends move at hypot(tip, r); a straight floor as wide as the roller between edges at
        hypot(tip, r, r) stays outside that, and the tip clearance is left besides.
        """
        roller = setup.roller
        assert roller is not None
        tip = self.tip(setup)
        if isinstance(roller, SphereRoller):
            return tip + self.running_clearance
        end = roller.meridian(self.quoted_radius(setup), 1.0)
        radius = float(end.jet(np.array([end.parameter(tip)]))[3][0]) + self.running_clearance
        return hypot(tip, radius, radius) + self.tip_clearance

    def inside(self, x: np.ndarray) -> np.ndarray:
        """Whether points (3, ...) of the cam frame lie within the blank."""
        return self.globoid.inside(x)

    def rib_depths(self, setup: Setup) -> tuple[tuple[str, float], ...]:
        """Where ribs are measured, from the turret axis, mm: at their tip and beside the rollers' ends."""
        low, high = self.contact(setup)
        return ("tip", max(low, self.globoid_radius)), ("root", high)

    def gaps(self, setup: Setup) -> tuple[tuple[str, float, str], ...]:
        """Free distances of the turret in mm, each with advice: (name, distance, advice)."""
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TurretFollower)
        assert roller is not None
        seat, tip = self.contact(setup)[0], self.tip(setup)
        between = 2.0 * seat * sin(0.5 * self.roller_pitch(follower)) - roller.diameter
        found = [
            ("between rollers", between, "fewer rollers, smaller ones, or a larger pitch radius"),
            ("turret body to blank", self.globoid_radius - seat - self.centre_shift(setup),
             "a globoid radius 1 to 5 mm above the inner end of the rollers"),
        ]
        if not isinstance(roller, SphereRoller):
            meridian = roller.meridian(follower.pitch_radius, 1.0)
            radius = float(meridian.jet(np.array([meridian.parameter(tip)]))[3][0])
            floor = sqrt(self.floor_radius(setup) ** 2 - (radius + self.running_clearance) ** 2)
            gap = floor - hypot(tip, radius) - self.centre_shift(setup)
            found.append(("roller end to floor", gap, "a larger tip_clearance"))
        return tuple(found)

    def turret(self, setup: Setup, cam_angle: float = 0.0) -> TurretBody:
        """The turret with its rollers as it stands at a cam angle (rad)."""
        assert setup.roller is not None
        assert isinstance(setup.follower, TurretFollower)
        track, seat, half = self.tracks(setup)[0], self.contact(setup)[0], 0.65 * setup.roller.diameter
        return TurretBody(track, setup.follower.count, seat, -half, half, 0.7 * seat, cam_angle)

    def parts(self, setup: Setup) -> tuple[Part, ...]:
        """The cam: globoid blank minus its grooves."""
        assert setup.roller is not None
        top = self.top_radius(setup)
        ridge = top - 0.25 * setup.roller.diameter
        centre, floor = self.center_distance, self.floor_radius(setup)
        return (
            IndexingCut(
                "cam",
                self.cutters(setup),
                self.blank(setup),
                GloboidLevel(centre, top),
                GloboidLevel(centre, floor),
                (top, self.tip(setup)),
                ridge,
                1 if self.bore else 0,
            ),
        )

