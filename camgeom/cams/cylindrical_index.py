"""Cylindrical (barrel) indexing cam: grooves or ribs round a drum, driving a turret whose rollers reach in sideways.

The turret's axis is perpendicular to the cam's and passes it at the centre distance; the rollers stand parallel to the
turret axis on its face and meet the drum one after another while they pass the line of centres.
"""

from __future__ import annotations

from dataclasses import replace
from math import asin, pi, sin, sqrt
from typing import ClassVar, Literal, final

from pydantic import Field

from camgeom.cams import problem, sense_of
from camgeom.cams._turret import TurretKeys, bearing_meridian
from camgeom.errors import Problem
from camgeom.immutable import immutable
from camgeom.keys import Length
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.solid import Part
from camgeom.solid.blank import Blank, Wall
from camgeom.solid.mechanism import Drive, Drum, Mechanism, Turret
from camgeom.solid.turret import TurretBody
from camgeom.track import Swing, Track
from camgeom.track.column import cylinder_level
from camgeom.track.follower import AnyRoller, Setup, SphereRoller, TurretFollower
from camgeom.track.turret import turret_tracks


@final
class CylindricalIndex(TurretKeys):
    """A drum -width/2 <= z <= width/2; the turret turns about a line along X through (0, center_distance, 0)."""

    FOLLOWERS: ClassVar[tuple[str, ...]] = ("turret",)
    MOST_PIECES: ClassVar[int] = 1_200
    MOST_STEPPED: ClassVar[int] = 100

    kind: Literal["cylindrical-index"]
    center_distance: Length = Field(description="mm, cam axis to turret axis")
    diameter: Length = Field(description="mm, outside of the drum")
    width: Length = Field(description="mm, length of the drum along its axis")

    def mechanism(self, setup: Setup) -> CylindricalIndexMechanism:
        """The drum with its turret."""
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TurretFollower)
        assert roller is not None
        return CylindricalIndexMechanism(
            follower=follower,
            roller=roller,
            program=setup.program,
            sense=sense_of(self.direction),
            drive=Drive.SHARED,
            width=self.width,
            form=self.form,
            bore=self.bore_spec,
            outside_diameter=self.diameter,
            running_clearance=self.running_clearance,
            cam=self,
        )

    def problems(self, setup: Setup) -> list[Problem]:
        """What cannot be built, with key, value and allowed range."""
        if setup.roller is None:
            return [Problem("roller", "a cylindrical indexing cam needs rollers", None, "a [roller] table")]
        mechanism, diameter = self.mechanism(setup), setup.roller.diameter
        found = self.key_problems(setup) + self._reach_problems(mechanism)
        if mechanism.roller_distance <= diameter:
            limit = f"below {mechanism.roller_distance:g} mm, the distance of neighbouring rollers"
            found.append(problem("roller.diameter", diameter, limit))
        return found

    def _reach_problems(self, mechanism: CylindricalIndexMechanism) -> list[Problem]:
        pitch_radius, radius = mechanism.follower.pitch_radius, 0.5 * mechanism.roller.diameter
        if 0.5 * self.width + radius >= 0.95 * pitch_radius:
            most = 2.0 * (0.95 * pitch_radius - radius)
            return [problem("cam.width", self.width, f"below {most:g} mm, so that the rollers swing clear of it")]
        floor = mechanism.floor_radius
        if floor <= 0.0:
            limit = f"below the drum's radius {mechanism.radius:g} mm"
            return [problem("roller.length", mechanism.radius - mechanism.tip, limit)]
        rim = radius + self.running_clearance
        # On the line of centres a roller stands farthest to one side of the drum's axis, at the end faces to the other.
        beside = min(1.0, (0.5 * self.width + rim) / pitch_radius)
        low = pitch_radius - floor + rim
        high = pitch_radius * sqrt(1.0 - beside**2) + floor - rim
        found = []
        if low >= high:
            limit = "narrower, or a larger follower.pitch_radius: nowhere do the rollers stay over the groove floor"
            found.append(problem("cam.width", self.width, limit))
        elif not low < self.center_distance < high:
            limit = f"{low:g} .. {high:g} mm, where rollers stay over the groove floor"
            found.append(problem("cam.center_distance", self.center_distance, limit))
        elif mechanism.bore and mechanism.bore.reach >= sqrt(max(0.0, floor**2 - rim**2)):
            most = sqrt(max(0.0, floor**2 - rim**2))
            found.append(problem("cam.bore", self.bore, f"outline inside the groove floor, {most:g} mm from the axis"))
        return found


@final
@immutable(kw_only=True)
class CylindricalIndexMechanism(Mechanism):
    """A barrel cam and its turret."""

    follower: TurretFollower
    roller: AnyRoller
    cam: CylindricalIndex

    @property
    def radius(self) -> float:
        """Outer radius of the drum, mm."""
        return 0.5 * self.cam.diameter

    @property
    def drum(self) -> Drum:
        """The drum about z = 0."""
        return Drum(self.radius, -0.5 * self.cam.width, 0.5 * self.cam.width)

    @property
    def envelope(self) -> tuple[float, float]:
        """Of the blank."""
        return self.blank.envelope

    @property
    def blank(self) -> Blank:
        """The drum before the grooves are cut."""
        half = 0.5 * self.cam.width
        return Blank(((self.radius, -half), (self.radius, half)), self.bore, (None,), ("land",))

    @property
    def contact(self) -> tuple[float, float]:
        """Stretch of the roller that touches the flank, from the plane of both axes' feet, mm."""
        roller = self.roller
        if isinstance(roller, SphereRoller):
            return self.radius - (roller.length or 0.35 * roller.diameter), self.radius
        return self.radius - roller.length, self.radius

    @property
    def tip(self) -> float:
        """Free end of the roller, in the same measure, mm."""
        if isinstance(self.roller, SphereRoller):
            return self.radius - 0.5 * self.roller.diameter
        return self.contact[0]

    @property
    def quoted_radius(self) -> float:
        """Where the classical figures are quoted: the middle of the contact, mm from the cam axis."""
        return 0.5 * sum(self.contact)

    @property
    def floor_radius(self) -> float:
        """Distance of the floor's edges from the cam axis, mm."""
        return self.tip - self.cam.tip_clearance

    @property
    def roller_distance(self) -> float:
        """Distance of neighbouring rollers' axes, mm."""
        return 2.0 * self.follower.pitch_radius * sin(0.5 * self.cam.roller_pitch(self.follower))

    @property
    def _clear_angle(self) -> float:
        """Turret angle (rad) from the line of centres beyond which a tool is clear of the drum."""
        beside = 0.5 * self.cam.width + 0.5 * self.roller.diameter + self.cam.running_clearance
        reach = beside / self.follower.pitch_radius
        return 1.02 * asin(reach) + 0.01 if reach < 0.95 else 0.5 * pi

    @cached_property
    def tracks(self) -> tuple[Track, ...]:
        """One track for each start: a roller followed through all its turns while its middle is beside the cam."""
        return self._grooves(asin(min(1.0, 0.5 * self.cam.width / self.follower.pitch_radius)))

    @cached_property
    def passages(self) -> tuple[Track, ...]:
        """The same rollers as long as any part of them may be beside the cam."""
        return self._grooves(self._clear_angle)

    @cached_property
    def cutters(self) -> tuple[Track, ...]:
        """The tools: each followed until clear of the drum, larger by the running clearance and deeper at the tip."""
        gap = self.cam.running_clearance
        tip = self.tip - gap if isinstance(self.roller, SphereRoller) else self.floor_radius
        relief = self.cam.relief_of(self.program, -self.follower.pitch_radius)
        return tuple(replace(track.grown(gap), tip=tip, relief=relief) for track in self.passages)

    def _grooves(self, reach: float) -> tuple[Track, ...]:
        follower, centre = self.follower, self.cam.center_distance
        low, high = self.contact
        middle = high if isinstance(self.roller, SphereRoller) else 0.5 * (low + high)
        first = Track(
            meridian=bearing_meridian(self.roller, middle, -1.0),
            joint=Swing((-self.cam.way, 0.0, 0.0), (0.0, centre, 0.0)),
            anchor=(0.0, centre - follower.pitch_radius, 0.0),
            axis=(1.0, 0.0, 0.0),
            tip=self.tip,
            contact=(low, high),
            program=self.program,
            sense=self.sense,
        )
        base = 0.5 * self.cam.roller_pitch(follower) if self.cam.form == "rib" else 0.0
        return turret_tracks(first, follower.count, base, reach)

    def within(self, x: Floats) -> Floats:
        """How deep points (3, ...) of the cam frame lie within the drum, mm."""
        return self.drum.within(x)

    @cached_property
    def turret(self) -> Turret:
        """The turret: a disc beside the drum with the rollers on its face."""
        follower, diameter = self.follower, self.roller.diameter
        gaps = [
            (
                "between rollers",
                self.roller_distance - diameter,
                "fewer rollers, smaller ones, or a larger pitch radius",
            )
        ]
        if not isinstance(self.roller, SphereRoller):
            gaps.append(("roller end to floor", self.cam.tip_clearance, "a larger tip_clearance"))
        near, far = self.radius + 2.0, self.radius + 2.0 + 0.6 * diameter
        # The turret's axis points along X or against it with the hand.
        low, high = (near, far) if self.cam.way < 0.0 else (-far, -near)
        disc = follower.pitch_radius + 0.6 * diameter
        # Ribs are measured where both walls are still in the drum, and at the root.
        root = self.contact[0]
        return Turret(
            follower,
            TurretBody(self.tracks[0], follower.count, disc, low, high, 0.5 * (near + far)),
            tuple(gaps),
            self.passages,
            room=disc,
            rib_depths=(("tip", max(root, sqrt(self.radius**2 - 0.25 * diameter**2) - 1e-6)), ("root", root)),
            relief=self.cam.relief,
            dwell_ends=self.cam.dwell_ends(self.program),
        )

    @cached_property
    def walls(self) -> tuple[Wall, ...]:
        """Groove floor to bore, at least: what a floor straight across a groove along the drum would leave."""
        if self.bore is None:
            return ()
        rim = 0.5 * self.roller.diameter + self.cam.running_clearance
        floor = sqrt(max(0.0, self.floor_radius**2 - rim**2))
        return (Wall("floor to bore", floor - self.bore.reach, None, "a smaller bore or keyway, or a shorter roller"),)

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """The cam: drum minus its grooves."""
        from camgeom.solid.cut import IndexingCut

        top = 1.04 * self.radius
        return (
            IndexingCut(
                "cam",
                self.cutters,
                self.blank,
                cylinder_level(top),
                cylinder_level(self.floor_radius),
                (top, self.tip),
                top + 0.5 * self.roller.diameter,
                1 if self.cam.bore else 0,
            ),
        )
