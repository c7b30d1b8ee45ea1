"""Globoidal indexing cam: a rib or groove cam on a globoid, driving a turret whose axis crosses its own."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from math import asin, atan2, ceil, degrees, floor, hypot, pi, sin, sqrt
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from camgeom.blank import Blank, Bore
from camgeom.errors import Problem
from camgeom.follower import Setup, SphereRoller, TurretFollower
from camgeom.solid import CutBlank, Part
from camgeom.spec import Gap, Length, Section
from camgeom.track import TURN, Swing, Track

STARTER = """
# Starter: a globoidal indexing cam, rib type, eight stops. Lengths mm, angles degrees. `camgeom run` this file.

name = "my globoidal indexer"

[cam]
kind = "globoidal"
form = "rib"             # rib, or groove for many stops
hand = "right"
center_distance = 180    # cam axis to turret axis
width = 90
globoid_radius = 80      # the blank's outside is an arc of this radius about the turret axis
bore = 40

[follower]
kind = "turret"
stops = 8
pitch_radius = 90        # turret axis to the middle of the rollers
inertia = 0.3            # kg m2, turret and load

[roller]
shape = "cylinder"
diameter = 30
length = 24

[[motion]]
until = 120

[[motion]]               # one index; `to` is the turret's angle
until = 240
to = 45
law = "modified-sine"

[[motion]]
until = 360

[operation]
speed = 100

[output]
tolerance = 0.01
formats = ["3mf", "stl"]
"""


class Cam(Section):
    """A globoid -width/2 <= z <= width/2; the turret turns about an axis parallel to Y at (center_distance, 0, 0)."""

    FOLLOWERS: ClassVar[tuple[str, ...]] = ("turret",)
    STARTER: ClassVar[str] = STARTER

    kind: Literal["globoidal"]
    form: Literal["rib", "groove"] = Field(
        "rib", description="in a dwell two rollers straddle a rib, or one sits in a groove"
    )
    hand: Literal["right", "left"] = Field("right", description="right: rollers next to the cam move towards +Z")
    center_distance: Length = Field(description="mm, cam axis to turret axis")
    width: Length = Field(description="mm, length of the cam along its axis")
    globoid_radius: Length = Field(description="mm, radius of the blank's outside about the turret axis")
    tip_clearance: Gap = Field(0.5, description="mm, from the roller's end to the groove floor")
    running_clearance: Gap = Field(0.0, description="mm, normal gap between roller and each flank")
    preload: Gap = Field(0.0, description="mm, by which the turret is set closer than the cam was cut for")
    bore: Gap = Field(0.0, description="mm, bore diameter; 0 leaves the cam solid")
    keyway_width: Gap = Field(0.0, description="mm; 0 leaves the keyway out")
    keyway_depth: Gap = Field(0.0, description="mm, from the bore wall")
    direction: Literal["ccw", "cw"] = Field("ccw", description="the cam's turning, seen from +Z")

    @property
    def end_radius(self) -> float:
        """Radius of the blank at its end faces (its largest), mm."""
        return self.center_distance - sqrt(self.globoid_radius**2 - 0.25 * self.width**2)

    def roller_pitch(self, follower: TurretFollower) -> float:
        """Angle between neighbouring rollers of the turret, rad."""
        return TURN / (follower.rollers or follower.stops)

    def contact(self, setup: Setup) -> tuple[float, float]:
        """Stretch of the roller that touches the flank, from the turret axis, mm."""
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TurretFollower)
        assert roller is not None
        if isinstance(roller, SphereRoller):
            return follower.pitch_radius, follower.pitch_radius + (roller.length or 0.35 * roller.diameter)
        return follower.pitch_radius - 0.5 * roller.length, follower.pitch_radius + 0.5 * roller.length

    def tip(self, setup: Setup) -> float:
        """Free end of the roller, from the turret axis, mm."""
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TurretFollower)
        if isinstance(roller, SphereRoller):
            return follower.pitch_radius + 0.5 * roller.diameter
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
        return [*self._size_problems(setup), *self._turret_problems(setup, follower)]

    def _size_problems(self, setup: Setup) -> list[Problem]:
        found = []
        follower = setup.follower
        assert isinstance(follower, TurretFollower)
        if follower.pitch_radius >= self.center_distance:
            limit = f"below the centre distance {self.center_distance:g} mm"
            return [_problem("follower.pitch_radius", follower.pitch_radius, limit)]
        if self.globoid_radius >= self.center_distance:
            limit = f"below the centre distance {self.center_distance:g} mm"
            return [_problem("cam.globoid_radius", self.globoid_radius, limit)]
        if 0.5 * self.width >= self.globoid_radius:
            limit = f"below twice the globoid radius, {2.0 * self.globoid_radius:g} mm"
            return [_problem("cam.width", self.width, limit)]
        floor_radius = self.center_distance - self.tip(setup) - self.tip_clearance
        if floor_radius <= 0.0:
            limit = f"below {self.center_distance - self.tip_clearance:g} mm, where the roller ends on the cam axis"
            found.append(_problem("follower.pitch_radius", follower.pitch_radius, limit))
        elif self.bore and self.bore_spec().reach >= floor_radius:
            limit = f"outline inside the groove floor, {floor_radius:g} mm from the axis"
            found.append(_problem("cam.bore", self.bore, limit))
        if not self.contact(setup)[0] - 1e-9 <= self.globoid_radius < self.contact(setup)[1]:
            limit = f"{self.contact(setup)[0]:g} .. {self.contact(setup)[1]:g} mm, within the roller's contact length"
            found.append(_problem("cam.globoid_radius", self.globoid_radius, limit))
        if bool(self.keyway_width) != bool(self.keyway_depth):
            found.append(_problem("cam.keyway_depth", self.keyway_depth, "width and depth both, or neither"))
        elif self.keyway_width and self.keyway_width >= self.bore:
            found.append(_problem("cam.keyway_width", self.keyway_width, f"below the bore {self.bore:g} mm"))
        return found

    def _turret_problems(self, setup: Setup, follower: TurretFollower) -> list[Problem]:
        found = []
        pitch = self.roller_pitch(follower)
        rollers = follower.rollers or follower.stops
        if rollers % follower.stops:
            found.append(_problem("follower.rollers", rollers, f"a multiple of the {follower.stops} stops"))
        roller = setup.roller
        assert roller is not None
        radius = 0.5 * roller.diameter
        room = 2.0 * self.contact(setup)[0] * sin(0.5 * pitch)
        if room <= 2.0 * radius:
            limit = f"below {room:g} mm, the distance of neighbouring rollers at their inner end"
            found.append(_problem("roller.diameter", roller.diameter, limit))
        starts = abs(setup.program.advance) / pitch
        if setup.program.closed:
            return found
        index = TURN / follower.stops
        steps = setup.program.advance / index
        if abs(steps - round(steps)) > 1e-9 or steps <= 0.0 or abs(starts - round(starts)) > 1e-9:
            limit = f"a multiple of {degrees(index):.12g} deg, one index of {follower.stops} stops"
            found.append(_problem("motion.to", degrees(setup.program.advance), limit))
        return found

    def bore_spec(self) -> Bore:
        """The bore outline."""
        return Bore(self.bore, self.keyway_width, self.keyway_depth)

    def blank(self, setup: Setup) -> Blank:
        """The globoid before the grooves are cut."""
        del setup
        half, end = 0.5 * self.width, self.end_radius
        return Blank(
            ((end, -half), (end, half)),
            self.bore_spec() if self.bore else None,
            ((self.center_distance, 0.0),),
            ("land",),
        )

    def tracks(self, setup: Setup) -> tuple[Track, ...]:
        """One track for each start: a roller followed through all its turns while its middle is beside the cam."""
        follower = setup.follower
        assert isinstance(follower, TurretFollower)
        reach = asin(min(1.0, 0.5 * self.width / follower.pitch_radius))
        return tuple(self._grooves(setup, reach, self.center_distance - self.preload, self.tip(setup)))

    def cutters(self, setup: Setup) -> tuple[Track, ...]:
        """The tools: each followed until clear of the blank, larger by the running clearance and deeper at the tip."""
        extra = self.running_clearance if isinstance(setup.roller, SphereRoller) else self.tip_clearance
        grooves = self._grooves(setup, self._clear_angle(setup), self.center_distance, self.tip(setup))
        return tuple(replace(g.grown(self.running_clearance), tip=g.tip + extra) for g in grooves)

    def _grooves(self, setup: Setup, reach: float, centre: float, tip: float) -> list[Track]:
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TurretFollower)
        assert roller is not None
        middle = follower.pitch_radius
        pitch = self.roller_pitch(follower)
        base = 0.5 * pitch if self.form == "rib" else 0.0
        program = setup.program
        first = Track(
            meridian=roller.meridian(middle, 1.0),
            joint=Swing((0.0, 1.0 if self.hand == "right" else -1.0, 0.0), (centre, 0.0, 0.0)),
            anchor=(centre, 0.0, 0.0),
            axis=(-1.0, 0.0, 0.0),
            tip=tip,
            contact=self.contact(setup),
            program=program,
            sense=1.0 if self.direction == "ccw" else -1.0,
            name="groove",
        )
        if program.closed:
            return self._oscillating(first, follower, base, pitch, reach)
        starts = round(program.advance / pitch)
        found = []
        for j in range(starts):
            shift = base + j * pitch
            name = f"groove {j + 1}" if starts > 1 else "groove"
            found.append(replace(first, shift=shift, span=_span(program, shift, reach), name=name))
        return found

    def _oscillating(
        self, first: Track, follower: TurretFollower, base: float, pitch: float, reach: float
    ) -> list[Track]:
        """To-and-fro drives: every roller that comes beside the cam has its own closed groove."""
        lifts = [lift for span in first.program.spans for lift in (span.before, span.after)]
        count = follower.rollers or follower.stops
        found = []
        for k in range(-count, count + 1):
            shift = base + k * pitch
            if shift + max(lifts) > -reach and shift + min(lifts) < reach and abs(shift) <= pi:
                found.append(replace(first, shift=shift, name=f"groove {len(found) + 1}"))
        return found

    def _clear_angle(self, setup: Setup) -> float:
        """Turret angle (rad) from the line of centres beyond which a tool is clear of the blank."""
        roller = setup.roller
        assert roller is not None
        radius = 0.5 * roller.diameter + self.running_clearance
        low = self.top_radius(setup)
        size = hypot(low, radius)
        if 0.5 * self.width < size:
            angle = asin(0.5 * self.width / size) + atan2(radius, low)
            if angle < 0.5 * pi:
                return 1.02 * angle + 0.01
        return 0.5 * pi

    def top_radius(self, setup: Setup) -> float:
        """Distance from the turret axis at which groove bodies end, outside the blank, mm."""
        del setup
        return self.globoid_radius - 0.05 * self.globoid_radius

    def parts(self, setup: Setup) -> tuple[Part, ...]:
        """The cam: globoid blank minus its grooves, by one boolean."""
        top = self.top_radius(setup)
        ridge = top - 0.25 * (setup.roller.diameter if setup.roller else 1.0)
        level = GloboidLevel(self.center_distance, top)
        return (CutBlank("cam", self.cutters(setup), self.blank(setup), level, top, ridge, 1 if self.bore else 0),)


class GloboidLevel:
    """Field of the globoid of `radius` about a turret axis at `centre`: positive outside the cam, mm."""

    def __init__(self, centre: float, radius: float) -> None:
        self.centre, self.radius = centre, radius

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """radius - distance of the meridian point from the turret centre."""
        rho = np.sqrt(x[0] * x[0] + x[1] * x[1])
        return np.asarray(self.radius - np.hypot(rho - self.centre, x[2]))


@lru_cache(maxsize=64)
def _span(program: object, shift: float, reach: float) -> tuple[float, float]:
    """Cam angles (over several turns) between which the turret angle lift + shift lies within +-reach, rad."""
    advance = program.advance  # type: ignore[attr-defined]
    low = TURN * floor((-reach - shift) / advance - 1.0)
    high = TURN * ceil((reach - shift) / advance + 1.0)

    def crossing(level: float, a: float, b: float) -> float:
        for _ in range(200):
            mid = 0.5 * (a + b)
            if program.jet(np.array([mid]), 0)[0, 0] + shift < level:  # type: ignore[attr-defined]
                a = mid
            else:
                b = mid
        return b

    return crossing(-reach, low, high), crossing(reach, low, high)


def _problem(key: str, value: object, allowed: str) -> Problem:
    return Problem(key, "cannot be built", value, allowed)

