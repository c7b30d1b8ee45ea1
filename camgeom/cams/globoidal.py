"""Globoidal indexing cam: a rib or groove cam on a globoid, driving a turret whose axis crosses its own."""

from __future__ import annotations

from dataclasses import replace
from math import asin, cos, degrees, hypot, pi, sin, sqrt, tan
from typing import ClassVar, Literal, final

import numpy as np
from pydantic import Field

from camgeom.cams import NO_STRESS, problem, root_problems, sense_of
from camgeom.cams._turret import TurretKeys, bearing_meridian
from camgeom.errors import Problem
from camgeom.immutable import immutable
from camgeom.keys import Gap, Length
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.solid import Part
from camgeom.solid.blank import Blank, Globoid, Wall
from camgeom.solid.mechanism import Drive, Mechanism, Turret
from camgeom.track import Swing, Track
from camgeom.track.follower import AnyRoller, Setup, SphereRoller, TurretFollower

DISC = 0.65
"""of the roller's diameter: half the thickness of the turret's disc, which stands out beyond its rollers"""
MOST_PRELOAD = 0.01
"""of the roller's diameter; steel on steel approaches elastically by less before it yields"""


@final
class Globoidal(TurretKeys):
    """A globoid -width/2 <= z <= width/2; the turret turns about an axis parallel to Y at (center_distance, 0, 0)."""

    FOLLOWERS: ClassVar[tuple[str, ...]] = ("turret",)
    ROOTLESS: ClassVar[dict[str, str]] = NO_STRESS
    MOST_PIECES: ClassVar[int] = 1_200
    MOST_STEPPED: ClassVar[int] = 100

    kind: Literal["globoidal"]
    center_distance: Length = Field(description="mm, cam axis to turret axis")
    width: Length = Field(description="mm, length of the cam along its axis")
    globoid_radius: Length = Field(description="mm, radius of the blank's outside about the turret axis")
    preload: Gap = Field(
        0.0, description="mm, by which rollers press into the ribs they ride in the dwell, by a closer centre distance"
    )
    root_radius: Gap = Field(
        0.0, description="mm, of the roots between flanks and floor, that of the tool's corner where there is no "
        "[cutter] corner_radius"
    )
    hub_diameter: Gap = Field(0.0, description="mm, hubs on both ends; 0 leaves them out")
    hub_length: Gap = Field(0.0, description="mm, length of each hub beyond the end face")

    @property
    def globoid(self) -> Globoid:
        """The blank's shape."""
        size = self.center_distance, self.width, self.globoid_radius
        return Globoid(*size, self.bore_spec, self.hub_diameter, self.hub_length)

    def mechanism(self, setup: Setup) -> GloboidalMechanism:
        """The globoid with its turret."""
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TurretFollower)
        assert roller is not None
        return GloboidalMechanism(
            follower=follower,
            roller=roller,
            program=setup.program,
            sense=sense_of(self.direction),
            drive=Drive.SHARED,
            width=self.width,
            form=self.form,
            bore=self.bore_spec,
            running_clearance=self.running_clearance,
            root_radius=setup.corner or self.root_radius,
            cam=self,
        )

    def problems(self, setup: Setup) -> list[Problem]:
        """What cannot be built, with key, value and allowed range."""
        if setup.roller is None:
            return [Problem("roller", "a globoidal cam needs rollers", None, "a [roller] table")]
        mechanism = self.mechanism(setup)
        return [
            *self.key_problems(setup), *self._size_problems(mechanism), *self._turret_problems(mechanism),
            *self._preload_problems(mechanism), *self._root_problems(setup, mechanism),
        ]  # fmt: skip

    def _root_problems(self, setup: Setup, mechanism: GloboidalMechanism) -> list[Problem]:
        """A root is swept by the tool that stands as the roller does: without relief and preload."""
        if not mechanism.root_radius:
            return []
        if self.relief or self.preload:
            key = "cam.relief" if self.relief else "cam.preload"
            return [problem(key, self.relief or self.preload, "0 beside a rounded root")]
        return root_problems(setup, self.root_radius, mechanism.floor_radius - self.globoid_radius)

    def _size_problems(self, mechanism: GloboidalMechanism) -> list[Problem]:
        found = []
        pitch_radius = mechanism.follower.pitch_radius
        radii = {"follower.pitch_radius": pitch_radius, "cam.globoid_radius": self.globoid_radius}
        for key, radius in radii.items():
            if radius >= self.center_distance:
                return [problem(key, radius, f"below the centre distance {self.center_distance:g} mm")]
        if 0.5 * self.width >= self.globoid_radius:
            limit = f"below twice the globoid radius, {2.0 * self.globoid_radius:g} mm"
            return [problem("cam.width", self.width, limit)]
        floor = self.center_distance - mechanism.floor_radius
        if floor <= 0.0:
            limit = f"below {pitch_radius + floor:g} mm, where the groove floor reaches the cam axis"
            found.append(problem("follower.pitch_radius", pitch_radius, limit))
        elif mechanism.bore and mechanism.bore.reach >= floor:
            limit = f"outline inside the groove floor, {floor:g} mm from the axis"
            found.append(problem("cam.bore", self.bore, limit))
        low, high = mechanism.contact
        if not low - 1e-9 <= self.globoid_radius < high:
            limit = f"{low:g} .. {high:g} mm, within the roller's contact length"
            found.append(problem("cam.globoid_radius", self.globoid_radius, limit))
        return [*found, *self.globoid.hub_problems(mechanism.floor_radius)]

    def _preload_problems(self, mechanism: GloboidalMechanism) -> list[Problem]:
        """A closer turret presses the rollers that stand beside the cam in a dwell, off the line of centres."""
        if self.preload and self.running_clearance:
            limit = f"0 beside running_clearance = {self.running_clearance:g} mm: flanks that stand back press nothing"
            return [problem("cam.preload", self.preload, limit)]
        roller = asin(min(1.0, 0.5 * mechanism.roller.diameter / mechanism.quoted_radius))
        away, reach = degrees(mechanism.preload_angle), degrees(mechanism.reach + roller)
        if self.preload and away >= reach:
            limit = f"0: in a dwell the next rollers stand {away:.6g} deg from the line of centres and come beside the "
            limit += f"cam at {reach:.6g}: nothing is pressed; more rollers, a wider cam, or form = 'rib'"
            return [problem("cam.preload", self.preload, limit)]
        most = MOST_PRELOAD * mechanism.roller.diameter
        if self.preload > most:
            return [problem("cam.preload", self.preload, f"at most {most:g} mm, a hundredth of the roller's diameter")]
        return []

    def _turret_problems(self, mechanism: GloboidalMechanism) -> list[Problem]:
        found = []
        diameter, half = mechanism.roller.diameter, 0.5 * self.roller_pitch(mechanism.follower)
        radius = 0.5 * diameter
        room = 2.0 * mechanism.contact[0] * sin(half)
        if room <= diameter:
            limit = f"below {room:g} mm, the distance of neighbouring rollers at their inner end"
            found.append(problem("roller.diameter", diameter, limit))
        if radius * cos(half) >= self.globoid_radius * sin(half):
            limit = f"below {2.0 * self.globoid_radius * tan(half):g} mm, so that ribs keep a tip at the globoid radius"
            found.append(problem("roller.diameter", diameter, limit))
        rib = 2.0 * (self.globoid_radius * sin(half) - radius * cos(half))
        if self.form == "rib" and self.width <= rib:
            found.append(problem("cam.width", self.width, f"above {rib:g} mm, so that rollers stand beside the rib"))
        return found


@final
@immutable(kw_only=True)
class GloboidalMechanism(Mechanism):
    """A globoidal cam and its turret."""

    follower: TurretFollower
    roller: AnyRoller
    cam: Globoidal

    @property
    def envelope(self) -> tuple[float, float]:
        """Of the blank."""
        return self.blank.envelope

    @property
    def named(self) -> dict[str, float]:
        """Radii of the turret's seat rf0 and over its rollers rfm, outside diameter De, depth h and height l, mm.

        T/WLJC 15-2018, (7), (8), (11), (13), (34), with the operators that its scan lost; h from the blank to the
        floor, l from the lower face of the turret's disc, as it is delivered, to the cam's axis.
        """
        low, high = self.contact
        return {
            "seat_radius_mm": low,
            "over_rollers_radius_mm": hypot(high, 0.5 * self.roller.diameter),
            "outside_diameter_mm": self.envelope[0],
            "groove_depth_mm": self.floor_radius - self.cam.globoid_radius,
            "axis_height_mm": DISC * self.roller.diameter,
        }

    @property
    def blank(self) -> Blank:
        """The globoid before the grooves are cut."""
        return self.cam.globoid.blank()

    @property
    def centre_shift(self) -> float:
        """By how much the turret is set closer than the cam was cut for, mm.

        In the dwell a flank's normal lies at the roller's angle tau from the line across the centres, so that a shift
        presses the roller in by shift * sin(tau): tau is half the roller pitch for a rib, the pitch for a groove.
        """
        return self.cam.preload / sin(self.preload_angle) if self.cam.preload else 0.0

    @property
    def preload_angle(self) -> float:
        """Angle from the line of centres, rad, of the rollers that a preload presses in a dwell."""
        return (0.5 if self.cam.form == "rib" else 1.0) * self.cam.roller_pitch(self.follower)

    @property
    def allowed_interference(self) -> float:
        """By how much a roller may stand in the cam on purpose, mm (the preload at its steepest)."""
        return self.centre_shift

    @property
    def allowed_backlash(self) -> float:
        """Running clearance; the relief, an angle, at the flank's foot; and what the closer turret opens, mm.

        The shift moves a roller at the angle tau out of its outer flank by shift * sin(tau) at most.
        """
        relief = self.cam.relief * self.floor_radius / self.follower.pitch_radius
        return self.running_clearance + relief + self.centre_shift * sin(min(self._clear_angle, 0.5 * pi))

    @property
    def quoted_radius(self) -> float:
        """Where the classical figures are quoted, from the turret axis, mm."""
        return self.follower.pitch_radius

    @property
    def contact(self) -> tuple[float, float]:
        """Stretch of the roller that touches the flank, from the turret axis, mm."""
        roller, middle = self.roller, self.quoted_radius
        if isinstance(roller, SphereRoller):
            return middle, middle + (roller.length or 0.35 * roller.diameter)
        return middle - 0.5 * roller.length, middle + 0.5 * roller.length

    @property
    def tip(self) -> float:
        """Free end of the roller, from the turret axis, mm."""
        if isinstance(self.roller, SphereRoller):
            return self.quoted_radius + 0.5 * self.roller.diameter
        return self.contact[1]

    @cached_property
    def tip_radius(self) -> float:
        """Radius of the roller at its free end, mm."""
        meridian = bearing_meridian(self.roller, self.quoted_radius, 1.0)
        return float(meridian.jet(np.array([meridian.parameter(self.tip)]))[3][0])

    @property
    def top_radius(self) -> float:
        """Distance from the turret axis at which groove bodies end, outside the blank, mm."""
        beyond = 0.05 * self.cam.globoid_radius
        if isinstance(self.roller, SphereRoller):
            # A ball ends half its diameter above its middle, which stands below the blank's outside.
            beyond = min(beyond, 0.25 * self.roller.diameter)
        return self.cam.globoid_radius - beyond

    @property
    def floor_radius(self) -> float:
        """Distance of the floor's edges from the turret axis, mm.

        Rims of the rollers' ends move at hypot(tip, r); a straight floor as wide as the roller between edges at
        hypot(tip, r, r) stays outside that, and the tip clearance is left besides.
        """
        if isinstance(self.roller, SphereRoller):
            return self.tip + self.cam.running_clearance
        radius = self.tip_radius + self.cam.running_clearance
        return hypot(self.tip, radius, radius) + self.cam.tip_clearance

    @property
    def _clear_angle(self) -> float:
        """Turret angle (rad) from the line of centres beyond which a tool is clear of the blank."""
        tool = 0.5 * self.roller.diameter + self.cam.running_clearance + self.cam.relief
        return self.cam.globoid.clear_angle(self.top_radius, tool)

    @cached_property
    def tracks(self) -> tuple[Track, ...]:
        """One track for each start: a roller followed through all its turns while its middle is beside the cam."""
        return self._grooves(self.reach, self.cam.center_distance - self.centre_shift)

    @property
    def reach(self) -> float:
        """Angle from the line of centres, rad, within which a roller's middle is beside the cam."""
        return asin(min(1.0, 0.5 * self.cam.width / self.quoted_radius))

    @cached_property
    def passages(self) -> tuple[Track, ...]:
        """The same rollers as long as any part of them may be beside the cam."""
        return self._grooves(self._clear_angle, self.cam.center_distance - self.centre_shift)

    @cached_property
    def cutters(self) -> tuple[Track, ...]:
        """The tools: each followed until clear of the blank, larger by the running clearance and deeper at the tip."""
        grooves = self._grooves(self._clear_angle, self.cam.center_distance)
        relief = self.cam.relief_of(self.program, self.quoted_radius)
        gap, root, floor = self.cam.running_clearance, self.root_radius, self.floor_radius
        if root:
            from camgeom.track.section import ROOTED

            # The floor's edges, where the corner's arc ends, are as far from the turret's axis as they are without.
            arc = 0.5 * pi * ROOTED
            floor = sqrt(floor**2 - (self.tip_radius + gap - root * (1.0 - cos(arc))) ** 2) + root * (1.0 - sin(arc))
        return tuple(replace(track.grown(gap), tip=floor, relief=relief, root=root) for track in grooves)

    def _grooves(self, reach: float, centre: float) -> tuple[Track, ...]:
        from camgeom.track.turret import turret_tracks

        follower = self.follower
        first = Track(
            meridian=bearing_meridian(self.roller, follower.pitch_radius, 1.0),
            joint=Swing((0.0, self.cam.way, 0.0), (centre, 0.0, 0.0)),
            anchor=(centre, 0.0, 0.0),
            axis=(-1.0, 0.0, 0.0),
            tip=self.tip,
            contact=self.contact,
            program=self.program,
            sense=self.sense,
        )
        base = 0.5 * self.cam.roller_pitch(follower) if self.cam.form == "rib" else 0.0
        return turret_tracks(first, follower.count, base, reach)

    def within(self, x: Floats) -> Floats:
        """How deep points (3, ...) of the cam frame lie within the blank, mm."""
        return self.cam.globoid.within(x)

    @cached_property
    def turret(self) -> Turret:
        """The turret: a disc about its axis with the rollers on its rim."""
        from camgeom.solid.turret import TurretBody

        follower, diameter, (seat, end) = self.follower, self.roller.diameter, self.contact
        half = DISC * diameter
        return Turret(
            follower,
            TurretBody(self.tracks[0], follower.count, seat, -half, half, 0.7 * seat),
            self._gaps,
            self.passages,
            room=seat,
            # Ribs are measured at their tip and beside the rollers' ends.
            rib_depths=(("tip", max(seat, self.cam.globoid_radius)), ("root", end)),
            preload=self.cam.preload,
            relief=self.cam.relief,
            dwell_ends=self.cam.dwell_ends(self.program),
        )

    @property
    def _gaps(self) -> tuple[tuple[str, float, str], ...]:
        seat, cam = self.contact[0], self.cam
        between = 2.0 * seat * sin(0.5 * cam.roller_pitch(self.follower)) - self.roller.diameter
        found = [
            ("between rollers", between, "fewer rollers, smaller ones, or a larger pitch radius"),
            ("turret body to blank", cam.globoid_radius - seat - self.centre_shift,
             "a globoid radius 1 to 5 mm above the inner end of the rollers"),
        ]  # fmt: skip
        if not isinstance(self.roller, SphereRoller):
            floor = sqrt(self.floor_radius**2 - (self.tip_radius + cam.running_clearance) ** 2)
            gap = floor - hypot(self.tip, self.tip_radius) - self.centre_shift
            found.append(("roller end to floor", gap, "a larger tip_clearance"))
        return tuple(found)

    @cached_property
    def walls(self) -> tuple[Wall, ...]:
        """Groove floor to bore, where every groove passes the middle of the cam; hubs to bore."""
        if self.bore is None:
            return ()
        floor, reach = self.cam.center_distance - self.floor_radius, self.bore.reach
        found = [Wall("floor to bore", floor - reach, None, "a smaller bore or keyway, or a shorter roller")]
        if self.cam.hub_length:
            hub = 0.5 * self.cam.hub_diameter - reach
            found.append(Wall("hub to bore", hub, None, "a larger hub_diameter, or a smaller bore or keyway"))
        return tuple(found)

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """The cam: globoid blank minus its grooves."""
        from camgeom.solid.cut import IndexingCut
        from camgeom.solid.lands import GloboidLevel

        top, centre = self.top_radius, self.cam.center_distance
        return (
            IndexingCut(
                "cam",
                self.cutters,
                self.blank,
                GloboidLevel(centre, top),
                GloboidLevel(centre, self.floor_radius),
                (top, self.tip),
                top - 0.25 * self.roller.diameter,
                1 if self.cam.bore else 0,
            ),
        )
