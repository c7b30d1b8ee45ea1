"""Cylindrical cam: a groove or a rib on a drum, translating or swinging follower."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, radians, sin
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from camgeom.errors import Problem
from camgeom.keys import Gap, Length, Section
from camgeom.maths import Floats
from camgeom.solid import Part
from camgeom.solid.blank import Blank, Bore, Wall
from camgeom.solid.cut import CutBlank
from camgeom.solid.drum import GroovedCylinder, RibbedCylinder, drum_walls
from camgeom.track import Joint, Slide, Swing, Track
from camgeom.track.follower import Setup, SphereRoller, SwingingFollower
from camgeom.track.section import Column, Level, cylinder_level


class Cam(Section):
    """A drum 0 <= z <= length with one groove (or rib); the roller reaches in radially from the +X side."""

    FOLLOWERS: ClassVar[tuple[str, ...]] = ("translating", "swinging")

    kind: Literal["cylindrical"]
    form: Literal["groove", "rib"] = Field("groove", description="a groove with one roller in it, or a rib between two")
    diameter: Length = Field(description="mm, outside diameter of the drum")
    length: Length = Field(description="mm, length of the drum")
    start: Annotated[float, Field(ge=-1e5, le=1e5)] = Field(
        description="mm, z of the roller centre (rib: of the rib's middle) at zero lift"
    )
    groove_depth: Length = Field(description="mm, from the outer surface (rib: its height)")
    pitch_radius: Length | None = Field(
        None, description="mm, where the classical figures are quoted; default: middle of the contact length"
    )
    bore: Gap = Field(0.0, description="mm, bore diameter; 0 leaves the drum solid")
    keyway_width: Gap = Field(0.0, description="mm; 0 leaves the keyway out")
    keyway_depth: Gap = Field(0.0, description="mm, from the bore wall")
    rib_thickness: Length | None = Field(None, description="mm, rib form: axial thickness of the rib in a dwell")
    running_clearance: Gap = Field(0.0, description="mm, normal gap between roller and each flank")
    direction: Literal["ccw", "cw"] = Field("ccw", description="the cam's turning, seen from +Z")

    @property
    def radius(self) -> float:
        """Outer radius of the drum, mm."""
        return 0.5 * self.diameter

    @property
    def floor_radius(self) -> float:
        """Radius of the groove's floor on its centre line (rib: of the drum beside the rib), mm."""
        return self.radius - self.groove_depth

    def contact(self, setup: Setup) -> tuple[float, float]:
        """Radial stretch of the roller that touches the flank, mm."""
        roller = setup.roller
        if isinstance(roller, SphereRoller):
            centre = self.floor_radius + 0.5 * roller.diameter
            return centre - (roller.length or 0.35 * roller.diameter), min(centre, self.radius)
        assert roller is not None
        return self.radius - roller.length, self.radius

    def quoted_radius(self, setup: Setup) -> float:
        """Where the classical figures are quoted, mm."""
        low, high = self.contact(setup)
        return self.pitch_radius or 0.5 * (low + high)

    def bore_spec(self) -> Bore | None:
        """The bore, or None for a solid drum."""
        return Bore(self.bore, self.keyway_width, self.keyway_depth) if self.bore else None

    def blank(self, setup: Setup) -> Blank:
        """The drum before the groove is cut."""
        del setup
        return Blank.cylinder(self.radius, self.length, self.bore_spec())

    def problems(self, setup: Setup) -> list[Problem]:
        """What cannot be built, with key, value and allowed range."""
        return [*self._size_problems(setup), *self._start_problems(setup), *self._follower_problems(setup)]

    def _size_problems(self, setup: Setup) -> list[Problem]:
        found = []
        if self.groove_depth >= self.radius:
            limit = f"below the drum's radius {self.radius:g} mm"
            found.append(_problem("cam.groove_depth", self.groove_depth, limit))
        bore = self.bore_spec()
        if bore is None and (self.keyway_width or self.keyway_depth):
            found.append(_problem("cam.keyway_width", self.keyway_width, "0 where the drum has no bore"))
        elif bore is not None:
            if self.keyway_width >= self.bore:
                found.append(_problem("cam.keyway_width", self.keyway_width, f"below the bore {self.bore:g} mm"))
            elif bool(self.keyway_width) != bool(self.keyway_depth):
                found.append(_problem("cam.keyway_depth", self.keyway_depth, "width and depth both, or neither"))
            elif self.groove_depth < self.radius and bore.reach >= self.floor_radius:
                limit = f"outline (reaches {bore.reach:g} mm) inside the groove floor, {self.floor_radius:g} mm"
                found.append(_problem("cam.bore", self.bore, limit))
        roller = setup.roller
        if roller is None:
            found.append(Problem("roller", "a cylindrical cam needs a roller", None, "a [roller] table"))
        elif isinstance(roller, SphereRoller) and self.form == "rib":
            found.append(_problem("roller.shape", roller.shape, "cylinder, cone or crowned, for form = 'rib'"))
        elif isinstance(roller, SphereRoller):
            if self.groove_depth > 0.5 * roller.diameter:
                limit = f"at most half the ball's diameter, {0.5 * roller.diameter:g} mm (the equator must come out)"
                found.append(_problem("cam.groove_depth", self.groove_depth, limit))
            least = 0.5 * roller.diameter - self.groove_depth
            if (roller.length or 0.35 * roller.diameter) <= least:
                limit = f"above {least:g} mm, from the ball's equator down into the groove"
                found.append(_problem("roller.length", roller.length, limit))
            if (roller.length or 0.0) > 0.49 * roller.diameter:
                found.append(_problem("roller.length", roller.length, f"below {0.49 * roller.diameter:g} mm"))
        elif roller.length > self.groove_depth:
            found.append(_problem("roller.length", roller.length, f"at most the wall height {self.groove_depth:g} mm"))
        if self.form == "rib" and self.rib_thickness is None:
            found.append(Problem("cam.rib_thickness", "missing", None, "a length in mm, for form = 'rib'"))
        if self.pitch_radius is not None and not self.floor_radius <= self.pitch_radius <= self.radius:
            limit = f"{self.floor_radius:g} .. {self.radius:g} mm"
            found.append(_problem("cam.pitch_radius", self.pitch_radius, limit))
        return found

    def _start_problems(self, setup: Setup) -> list[Problem]:
        """The groove or rib must meet the drum somewhere; where it runs out of an end it is cut open there."""
        least, most = setup.program.extremes(0)
        lifts = np.linspace(float(least.value), float(most.value), 181)
        follower = setup.follower
        if isinstance(follower, SwingingFollower):
            start = radians(follower.start_angle)
            lifts = follower.arm * (np.sin(start + lifts) - sin(start))
        half = 0.5 * (self.rib_thickness or 0.0) if self.form == "rib" else 0.0
        half = half or (0.5 * setup.roller.diameter if setup.roller else 0.0)
        low, high = -float(lifts.max()) - half, self.length - float(lifts.min()) + half
        if low < self.start < high:
            return []
        limit = f"{low:g} .. {high:g} mm, where the {self.form} meets the drum"
        return [_problem("cam.start", self.start, limit)]

    def _follower_problems(self, setup: Setup) -> list[Problem]:
        follower = setup.follower
        if isinstance(follower, SwingingFollower) and follower.pivot_distance is not None:
            arm = follower.arm
            if abs(follower.pivot_distance - arm) > 0.9 * self.radius:
                limit = f"{max(0.0, arm - 0.9 * self.radius):g} .. {arm + 0.9 * self.radius:g} mm for an arm of {arm:g}"
                return [_problem("follower.pivot_distance", follower.pivot_distance, limit)]
        return []

    def tracks(self, setup: Setup) -> tuple[Track, ...]:
        """The roller tracks: one for a groove, the lower and the upper roller for a rib."""
        roller = setup.roller
        assert roller is not None
        low, high = self.contact(setup)
        centre = self.floor_radius + 0.5 * roller.diameter if isinstance(roller, SphereRoller) else 0.5 * (low + high)
        meridian = roller.meridian(centre, -1.0)
        sense = 1.0 if self.direction == "ccw" else -1.0
        tip = centre - 0.5 * roller.diameter if isinstance(roller, SphereRoller) else low

        def at(dz: float, name: str, sides: tuple[float, ...] = (1.0, -1.0)) -> Track:
            anchor, joint, shift = self._mount(setup, dz)
            return Track(
                meridian=meridian,
                joint=joint,
                anchor=anchor,
                axis=(1.0, 0.0, 0.0),
                tip=tip,
                contact=(low, high),
                program=setup.program,
                sense=sense,
                shift=shift,
                name=name,
                sides=sides,
            )

        if self.form == "groove":
            return (at(0.0, "groove"),)
        half = 0.5 * (self.rib_thickness or 0.0) + 0.5 * roller.diameter
        # u x v points towards smaller z where the cam turns counter-clockwise: side -1 is then a roller's upper flank.
        return at(-half, "lower roller", (-sense,)), at(half, "upper roller", (sense,))

    def parts(self, setup: Setup) -> tuple[Part, ...]:
        """The drum: meshed directly where its groove or rib is one closed ring, cut by a boolean otherwise."""
        blank, cutters = self.blank(setup), self.cutters(setup)
        if self.form == "rib":
            lower, upper = cutters
            return (RibbedCylinder("cam", lower, upper, blank, self.floor_radius, self.radius, self.length),)
        (track,) = cutters
        ring = GroovedCylinder("cam", track, blank, self.radius, self.length)
        if ring.fits():
            return (ring,)
        beyond = self.radius + max(0.05 * self.radius, 0.25 * self.groove_depth)
        ridge = beyond + 0.5 * self.groove_depth
        genus = 0 if blank.bore is None else 1
        return (CutBlank("cam", cutters, blank, cylinder_level(beyond), beyond, ridge, genus),)

    @property
    def wall_foot(self) -> tuple[Level, float] | None:
        """Surface on which a rib's walls end, and a delta near it; None for a groove, cut down to the tool's tip."""
        return (cylinder_level(self.floor_radius), self.floor_radius) if self.form == "rib" else None

    def contact_lengths(self, track: Track, phi: Floats) -> Floats:
        """Length of flank beside a roller's contact stretch at cam angles (n,), mm; not positive: none."""
        low, high = sorted(track.contact)
        column = Column(track, phi)
        tops = [column.reach(side, cylinder_level(self.radius), self.radius)[:, 0] for side in track.sides]
        return np.asarray(np.min([np.minimum(track.meridian.jet(top)[0], high) - low for top in tops], axis=0))

    def walls(self, setup: Setup) -> list[Wall]:
        """Thinnest walls of the drum: to the ends, between passes of the groove, and to the bore."""
        return drum_walls(self.cutters(setup), self.radius, self.floor_radius, self.length, self.bore_spec())

    def cutters(self, setup: Setup) -> tuple[Track, ...]:
        """The tracks with the tool that cuts: larger by the running clearance, down to the groove floor."""
        tip = self.floor_radius if self.form == "groove" else self.floor_radius - 0.1 * self.groove_depth
        ball = isinstance(setup.roller, SphereRoller)
        cut = []
        for track in self.tracks(setup):
            grown = track.grown(self.running_clearance)
            end = track.tip - self.running_clearance if ball else tip
            cut.append(replace(grown, tip=end))
        return tuple(cut)

    def _mount(self, setup: Setup, dz: float) -> tuple[tuple[float, float, float], Joint, float]:
        """Anchor, joint and coordinate shift of a roller mounted dz above the follower's trace point."""
        follower = setup.follower
        if not isinstance(follower, SwingingFollower):
            return (0.0, 0.0, self.start + dz), Slide((0.0, 0.0, 1.0)), 0.0
        start = radians(follower.start_angle)
        distance = follower.pivot_distance or self._centred_distance(setup, start)
        height = self.start - follower.arm * sin(start)
        return (0.0, distance - follower.arm, height + dz), Swing((-1.0, 0.0, 0.0), (0.0, distance, height)), start

    @staticmethod
    def _centred_distance(setup: Setup, start: float) -> float:
        """Pivot distance that lets the roller's arc swing equally to both sides of the cam axis plane, mm."""
        assert isinstance(setup.follower, SwingingFollower)
        lifts = [lift for span in setup.program.spans for lift in (span.before, span.after)]
        low, high = min(lifts), max(lifts)
        angles = [start + low, start + high]
        cosines = [cos(a) for a in angles]
        if angles[0] <= 0.0 <= angles[1]:
            cosines.append(1.0)
        if angles[1] > pi or angles[0] < -pi:
            cosines.append(-1.0)
        return setup.follower.arm * 0.5 * (min(cosines) + max(cosines))


def _problem(key: str, value: object, allowed: str) -> Problem:
    return Problem(key, "cannot be built", value, allowed)
