"""Parallel (plate) indexing cam: plates on one shaft, each driving its own ring of rollers on a turret beside it.

Cam shaft and turret shaft are parallel. Each plate is what all rollers of its ring leave of a disc in a whole turn, so
that it touches rollers from both sides; where one ring's roller passes the line of centres and cannot be driven, the
other plates carry. A plate keeps its shape while it turns: one turn of the cam must carry every ring on by whole
distances of its own rollers, a whole multiple of as many roller pitches of the turret as there are plates.
"""

from __future__ import annotations

from dataclasses import replace
from math import acos, degrees, gcd, sin
from typing import Annotated, ClassVar, Literal, final

import numpy as np
from pydantic import Field

from camgeom.cams import NO_DRUM, NO_ROOT, ONE_WAY, REGULAR, Cam, prism_idle, problem, sense_of
from camgeom.cams._plate import bore_of, bore_problems, disc_wall, plate_envelope, straight_problems
from camgeom.cams._turret import bearing_meridian
from camgeom.errors import DesignError, Problem
from camgeom.immutable import immutable
from camgeom.keys import Clearance, Gap, Length
from camgeom.maths.frozen import cached_property
from camgeom.solid import Part
from camgeom.solid.blank import Wall
from camgeom.solid.mechanism import Drive, Mechanism, Turret
from camgeom.solid.prism import Loop, Prism
from camgeom.solid.turret import StackedTurret, TurretBody
from camgeom.track import TURN, Swing, Track
from camgeom.track.follower import CrownedRoller, CylinderRoller, Setup, TurretFollower
from camgeom.track.outline import Outline
from camgeom.track.sweep import BandEdge, RimArc, RollerSweep
from camgeom.track.turret import turret_tracks

DIAL_PLAY = 0.05
"""share of the gap between plates that stays free on either side of a dial"""


@final
class ParallelIndex(Cam):
    """Plates from z = 0 up, `gap` apart; the turret turns against the cam about a line along Z at (center_distance, 0).

    In the first dwell rollers stand half a roller pitch on either side of the line of centres.
    """

    FOLLOWERS: ClassVar[tuple[str, ...]] = ("turret",)
    MOST_PIECES: ClassVar[int] = 1_500
    MOST_STEPPED: ClassVar[int] = 700

    kind: Literal["parallel-index"]
    center_distance: Length = Field(description="mm, cam shaft to turret shaft")
    diameter: Length = Field(description="mm, of the discs the plates are cut from")
    width: Length = Field(description="mm, thickness of each plate")
    gap: Length = Field(description="mm, between neighbouring plates along the shaft")
    plates: Annotated[int, Field(ge=2, le=4)] = Field(2, description="plates, each with its own ring of rollers")
    running_clearance: Clearance = Field(0.0, description="mm, normal gap between roller and plate")
    bore: Gap = Field(0.0, description="mm, bore diameter; 0 leaves the plates whole")
    keyway_width: Gap = Field(0.0, description="mm; 0 leaves the keyway out")
    keyway_depth: Gap = Field(0.0, description="mm, from the bore wall")
    direction: Literal["ccw", "cw"] = Field("ccw", description="the cam's turning, seen from +Z")

    @property
    def pitch(self) -> float:
        """Distance of neighbouring plates along the shaft, middle to middle, mm."""
        return self.width + self.gap

    def mechanism(self, setup: Setup) -> ParallelIndexMechanism:
        """The plates with their turret."""
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TurretFollower)
        assert isinstance(roller, CylinderRoller | CrownedRoller)
        return ParallelIndexMechanism(
            follower=follower,
            roller=roller,
            program=setup.program,
            sense=sense_of(self.direction),
            drive=Drive.SHARED,
            width=self.width,
            bore=bore_of(self.bore, self.keyway_width, self.keyway_depth),
            outside_diameter=self.diameter,
            running_clearance=self.running_clearance,
            cam=self,
        )

    def idle(self, setup: Setup) -> dict[str, str]:
        """The keyway's keys without a bore."""
        del setup
        return NO_DRUM | REGULAR | NO_ROOT | ONE_WAY | prism_idle(self.bore)

    def problems(self, setup: Setup) -> list[Problem]:
        """What cannot be built, with key, value and allowed range."""
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TurretFollower)
        if not isinstance(roller, CylinderRoller | CrownedRoller):
            shape = roller.shape if roller else None
            return [Problem("roller.shape", "parallel indexing cams need rollers", shape, "cylinder or crowned")]
        found = straight_problems(roller)
        return found + self._step_problems(setup, follower) + self._size_problems(follower, roller)

    def _step_problems(self, setup: Setup, follower: TurretFollower) -> list[Problem]:
        program, count = setup.program, follower.count
        steps = round(program.advance * follower.stops / TURN)
        if program.closed or steps <= 0:
            limit = "a step on, in the positive sense; for motion to and fro take kind = 'conjugate'"
            return [problem("motion.to", degrees(program.advance), limit)]
        need = self.plates * follower.stops // gcd(steps, follower.stops)
        if count % need:
            limit = f"a multiple of {need}: each of the {self.plates} plates drives every {self.plates}. roller, and "
            limit += "one turn of the cam must carry them on by whole distances, to where others of the ring stood"
            return [problem("follower.rollers", count, limit)]
        return []

    def _size_problems(self, follower: TurretFollower, roller: CylinderRoller | CrownedRoller) -> list[Problem]:
        low = self.center_distance - follower.pitch_radius
        if low <= 0.0:
            limit = f"below the centre distance {self.center_distance:g} mm"
            return [problem("follower.pitch_radius", follower.pitch_radius, limit)]
        radius = 0.5 * roller.diameter + self.running_clearance
        if not low < 0.5 * self.diameter < self.center_distance:
            limit = f"{2.0 * low:g} .. {2.0 * self.center_distance:g} mm, from the deepest roller to the turret's shaft"
            return [problem("cam.diameter", self.diameter, limit)]
        found = bore_problems(self.bore, self.keyway_width, self.keyway_depth, max(low - radius, 0.0))
        room = ring_distance(self, follower)
        if room <= roller.diameter:
            limit = f"below {room:g} mm, the distance of neighbouring rollers of a ring"
            found.append(problem("roller.diameter", roller.diameter, limit))
        room = self.width + (1.0 - 2.0 * DIAL_PLAY) * self.gap
        if roller.length >= room:
            limit = f"below {room:g} mm, so that a dial stands between the ends of rollers of neighbouring plates"
            found.append(problem("roller.length", roller.length, limit))
        if radius >= low:
            limit = f"below {2.0 * (low - self.running_clearance):g} mm, where rollers reach the cam's axis"
            found.append(problem("roller.diameter", roller.diameter, limit))
        return found


def ring_distance(cam: ParallelIndex, follower: TurretFollower) -> float:
    """Distance of neighbouring rollers' axes on one ring, mm."""
    return 2.0 * follower.pitch_radius * sin(0.5 * TURN * cam.plates / follower.count)


@final
@immutable(kw_only=True)
class ParallelIndexMechanism(Mechanism):
    """Plates and their turret. Facts of the plates' shape raise DesignError where no plate is left."""

    follower: TurretFollower
    roller: CylinderRoller | CrownedRoller
    cam: ParallelIndex

    def _contact(self, plate: int) -> tuple[float, float]:
        """Heights z between which a plate and its rollers touch, mm."""
        middle = plate * self.cam.pitch + 0.5 * self.cam.width
        half = 0.5 * min(self.cam.width, self.roller.length)
        return middle - half, middle + half

    def _dial(self, plate: int) -> int:
        """The gap in which the dial turns that carries a plate's rollers."""
        even = plate - plate % 2
        return even if even + 1 < self.cam.plates else plate - 1

    def _sweep(self, plate: int, gap: float) -> RollerSweep:
        """What the rollers of a ring, larger by `gap`, sweep from its plate."""
        low, high = self._contact(plate)
        c, rf = self.cam.center_distance, self.follower.pitch_radius
        edge = 0.5 * self.cam.diameter
        clear = edge + 1.05 * (0.5 * self.roller.diameter + gap)
        first = Track(
            meridian=bearing_meridian(self.roller, 0.5 * (low + high), 1.0),
            joint=Swing((0.0, 0.0, -self.sense), (c, 0.0, 0.0)),
            anchor=(c - rf, 0.0, 0.0),
            axis=(0.0, 0.0, 1.0),
            tip=low if self._dial(plate) == plate else high,
            contact=(low, high),
            program=self.program,
            sense=self.sense,
            name=f"plate {plate + 1}",
        ).grown(gap)
        reach = acos(max(-1.0, (c * c + rf * rf - clear * clear) / (2.0 * c * rf)))
        count = self.follower.count
        base = (0.5 + plate) * TURN / count
        return RollerSweep(turret_tracks(first, count // self.cam.plates, base, reach), edge)

    @cached_property
    def _rings(self) -> tuple[RollerSweep, ...]:
        """The rollers ring by ring."""
        return tuple(self._sweep(plate, 0.0) for plate in range(self.cam.plates))

    @cached_property
    def _cuts(self) -> tuple[RollerSweep, ...]:
        """What the tools sweep from every plate. Raises DesignError where no plate is left."""
        jumps = sorted({degrees(jump.angle) for jump in self.program.continuity.jumps if jump.order <= 1})
        if jumps:
            angles = ", ".join(f"{angle:.6g}" for angle in jumps)
            raise DesignError(
                f"the motion's velocity jumps at {angles} deg, so the rollers leave gaps in the plates' walls there: "
                "take a law that begins and ends with the velocity of its neighbours"
            )
        found = tuple(self._sweep(plate, self.cam.running_clearance) for plate in range(self.cam.plates))
        for sweep in found:
            sweep.chain  # noqa: B018
        return found

    @cached_property
    def passages(self) -> tuple[Track, ...]:
        """Every roller that runs on a plate, longer than the plate is wide, from where it comes over the disc on."""
        found = []
        for plate, ring in enumerate(self._rings):
            low, high = (edge * self.cam.pitch - 0.5 * self.cam.gap for edge in (plate, plate + 1))
            found += [replace(track, contact=(low, high), tip=low) for track in ring.tracks]
        return tuple(found)

    @cached_property
    def cutters(self) -> tuple[Track, ...]:
        """The tools: rollers larger by the running clearance, each over the cam angles at which its wall remains."""
        return tuple(track for sweep in self._cuts for track in sweep.contacts)

    @cached_property
    def tracks(self) -> tuple[Track, ...]:
        """One track a wall: its roller over the cam angles at which it touches; equal names belong to one roller."""
        return tuple(track.grown(-self.cam.running_clearance) for track in self.cutters)

    @cached_property
    def outlines(self) -> dict[str, Outline]:
        """The plates' outlines by name."""
        return {f"plate {i + 1}": sweep.outline for i, sweep in enumerate(self._cuts)}

    @cached_property
    def walls(self) -> tuple[Wall, ...]:
        """The plates themselves, their horns' tips, and what the deepest roller leaves about the bore."""
        found = [disc_wall(name, self.width) for name in self.outlines]
        dial = min(high - low for _, low, high in self._dials)
        found.append(Wall("dial between rollers", dial, None, "shorter rollers, or a larger gap between the plates"))
        reach = self.bore.reach if self.bore else 0.0
        for name, sweep in zip(self.outlines, self._cuts):
            for part in sweep.chain:
                if isinstance(part, RimArc):
                    width = 2.0 * part.radius * sin(0.5 * min(part.high - part.low, 0.5 * TURN))
                    found.append(Wall(f"{name} horn tip", width, None, "a smaller diameter cuts horns off where wider"))
            edges = [part for part in sweep.chain if isinstance(part, BandEdge)]
            points = [edge.curve(np.linspace(edge.low, edge.high, 2001)).points for edge in edges]
            least = min(float(np.hypot(*x).min()) for x in points)
            found.append(Wall(f"{name} to bore", least - reach, None, "a larger centre distance or a smaller bore"))
        return tuple(found)

    @cached_property
    def envelope(self) -> tuple[float, float]:
        """Of all plates with the gaps between them."""
        return plate_envelope(self.outlines.values(), (self.cam.plates - 1) * self.cam.pitch + self.cam.width)

    @cached_property
    def turret(self) -> Turret:
        """The turret with its rings of rollers; the best placed roller of each direction is judged."""
        count = self.follower.count // self.cam.plates
        rollers = (
            replace(ring.tracks[0], shift=ring.tracks[0].shift + k * TURN / count)
            for ring in self._rings
            for k in range(count)
        )
        return Turret(
            self.follower,
            self._body(count),
            self._gaps,
            self.tracks,
            room=self.cam.center_distance - 0.5 * self.cam.diameter,
            take_turns=True,
            rollers=tuple(rollers),
            dials=self._dials,
        )

    @property
    def _gaps(self) -> tuple[tuple[str, float, str], ...]:
        cam, follower, diameter = self.cam, self.follower, self.roller.diameter
        ring = ring_distance(cam, follower) - diameter
        shaft = cam.center_distance - follower.pitch_radius - 0.5 * diameter - 0.5 * cam.bore
        return (
            ("between rollers of a ring", ring, "fewer rollers, smaller ones, or a larger pitch radius"),
            ("dial to camshaft", shaft, "a larger centre distance, or a thinner shaft"),
            ("plates to turret axis", cam.center_distance - 0.5 * cam.diameter, "a smaller diameter"),
        )

    @property
    def _dials(self) -> tuple[tuple[float, float, float], ...]:
        """The turret's discs between the plates, each with its radius and its faces' heights z, mm."""
        cam = self.cam
        radius = self.follower.pitch_radius + 0.5 * self.roller.diameter
        # A roller longer than its plate is wide stands out of it on both sides alike.
        play = DIAL_PLAY * cam.gap + max(0.0, 0.5 * (self.roller.length - cam.width))
        places = sorted({self._dial(plate) for plate in range(cam.plates)})
        lows = [place * cam.pitch + cam.width + play for place in places]
        return tuple((radius, low, low + cam.gap - 2.0 * play) for low in lows)

    def _body(self, count: int) -> StackedTurret:
        cam, dials, rings = self.cam, self._dials, []
        for plate, ring in enumerate(self._rings):
            radius, low, high = dials[self._dial(plate) // 2 if self._dial(plate) % 2 == 0 else -1]
            ends = self._along_turret(low, high)
            rings.append(TurretBody(ring.tracks[0], count, radius, *ends, 0.5 * (low + high)))
        shaft = min(0.35 * self.follower.pitch_radius, 0.8 * (cam.center_distance - 0.5 * cam.diameter))
        return StackedTurret(tuple(rings), shaft, *self._along_turret(-cam.gap, cam.plates * cam.pitch))

    def _along_turret(self, low: float, high: float) -> tuple[float, float]:
        """Heights z as places along the turret's axis, which points down where the cam turns counter-clockwise."""
        return (-high, -low) if self.sense > 0.0 else (low, high)

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """The plates, from the lowest up."""
        cam = self.cam
        return tuple(
            Prism(name, Loop(outline, "flank"), i * cam.pitch, i * cam.pitch + cam.width, (), self.bore)
            for i, (name, outline) in enumerate(self.outlines.items())
        )
