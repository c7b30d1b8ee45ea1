"""Parallel (plate) indexing cam: plates on one shaft, each driving its own ring of rollers on a turret beside it.

Cam shaft and turret shaft are parallel. Each plate is what all rollers of its ring leave of a disc in a whole turn, so
that it touches rollers from both sides; where one ring's roller passes the line of centres and cannot be driven, the
other plates carry. A plate keeps its shape while it turns: one turn of the cam must carry every ring on by whole
distances of its own rollers, a whole multiple of as many roller pitches of the turret as there are plates.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from math import acos, degrees, gcd, sin
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from camgeom.cams._plate import bore_problems, problem
from camgeom.errors import Problem
from camgeom.keys import Gap, Length, Section
from camgeom.solid import Part
from camgeom.solid.blank import Bore, Wall
from camgeom.solid.prism import Loop, Prism
from camgeom.solid.turret import StackedTurret, TurretBody
from camgeom.track import TURN, Swing, Track
from camgeom.track.follower import CylinderRoller, Setup, TurretFollower
from camgeom.track.outline import Outline
from camgeom.track.sweep import Edge, Rim, RollerSweep
from camgeom.track.turret import turret_tracks


class Cam(Section):
    """Plates from z = 0 up, `gap` apart; the turret turns against the cam about a line along Z at (center_distance, 0).

    In the first dwell rollers stand half a roller pitch on either side of the line of centres.
    """

    FOLLOWERS: ClassVar[tuple[str, ...]] = ("turret",)
    SHARED_DRIVE: ClassVar[bool] = True

    kind: Literal["parallel-index"]
    center_distance: Length = Field(description="mm, cam shaft to turret shaft")
    diameter: Length = Field(description="mm, of the discs the plates are cut from")
    width: Length = Field(description="mm, thickness of each plate")
    gap: Length = Field(description="mm, between neighbouring plates along the shaft")
    plates: Annotated[int, Field(ge=2, le=4)] = Field(2, description="plates, each with its own ring of rollers")
    running_clearance: Gap = Field(0.0, description="mm, normal gap between roller and plate")
    bore: Gap = Field(0.0, description="mm, bore diameter; 0 leaves the plates whole")
    keyway_width: Gap = Field(0.0, description="mm; 0 leaves the keyway out")
    keyway_depth: Gap = Field(0.0, description="mm, from the bore wall")
    direction: Literal["ccw", "cw"] = Field("ccw", description="the cam's turning, seen from +Z")

    @property
    def sense(self) -> float:
        """+1 counter-clockwise, -1 clockwise."""
        return 1.0 if self.direction == "ccw" else -1.0

    @property
    def pitch(self) -> float:
        """Distance of neighbouring plates along the shaft, middle to middle, mm."""
        return self.width + self.gap

    def problems(self, setup: Setup) -> list[Problem]:
        """What cannot be built, with key, value and allowed range."""
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TurretFollower)
        if not isinstance(roller, CylinderRoller):
            shape = roller.shape if roller else None
            return [Problem("roller.shape", "parallel indexing cams need rollers", shape, "cylinder")]
        return self._step_problems(setup, follower) + self._size_problems(follower, roller)

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

    def _size_problems(self, follower: TurretFollower, roller: CylinderRoller) -> list[Problem]:
        low = self.center_distance - follower.pitch_radius
        if low <= 0.0:
            limit = f"below the centre distance {self.center_distance:g} mm"
            return [problem("follower.pitch_radius", follower.pitch_radius, limit)]
        radius = 0.5 * roller.diameter + self.running_clearance
        if not low < 0.5 * self.diameter < self.center_distance:
            limit = f"{2.0 * low:g} .. {2.0 * self.center_distance:g} mm, from the deepest roller to the turret's shaft"
            return [problem("cam.diameter", self.diameter, limit)]
        found = bore_problems(self.bore, self.keyway_width, self.keyway_depth, max(low - radius, 0.0))
        room = 2.0 * follower.pitch_radius * sin(0.5 * TURN * self.plates / follower.count)
        if room <= roller.diameter:
            limit = f"below {room:g} mm, the distance of neighbouring rollers of a ring"
            found.append(problem("roller.diameter", roller.diameter, limit))
        if radius >= low:
            limit = f"below {2.0 * (low - self.running_clearance):g} mm, where rollers reach the cam's axis"
            found.append(problem("roller.diameter", roller.diameter, limit))
        return found

    def contact(self, setup: Setup, plate: int = 0) -> tuple[float, float]:
        """Heights z between which a plate and its rollers touch, mm."""
        assert setup.roller is not None
        middle, half = plate * self.pitch + 0.5 * self.width, 0.5 * min(self.width, setup.roller.length or self.width)
        return middle - half, middle + half

    def _dial(self, plate: int) -> int:
        """The gap in which the dial turns that carries a plate's rollers."""
        even = plate - plate % 2
        return even if even + 1 < self.plates else plate - 1

    def passages(self, setup: Setup) -> tuple[Track, ...]:
        """Every roller that runs on a plate, longer than the plate is wide, from where it comes over the disc on."""
        found = []
        for plate, sweep in enumerate(_sweeps(self, setup, False)):
            low, high = plate * self.pitch - 0.5 * self.gap, (plate + 1) * self.pitch - 0.5 * self.gap
            found += [replace(track, contact=(low, high), tip=low) for track in sweep.tracks]
        return tuple(found)

    def _sweep(self, setup: Setup, plate: int, gap: float) -> RollerSweep:
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TurretFollower)
        assert isinstance(roller, CylinderRoller)
        low, high = self.contact(setup, plate)
        c, rf = self.center_distance, follower.pitch_radius
        edge = 0.5 * self.diameter
        clear = edge + 1.05 * (0.5 * roller.diameter + gap)
        first = Track(
            meridian=roller.meridian(0.5 * (low + high), 1.0),
            joint=Swing((0.0, 0.0, -self.sense), (c, 0.0, 0.0)),
            anchor=(c - rf, 0.0, 0.0),
            axis=(0.0, 0.0, 1.0),
            tip=low if self._dial(plate) == plate else high,
            contact=(low, high),
            program=setup.program,
            sense=self.sense,
            name=f"plate {plate + 1}",
        ).grown(gap)
        reach = acos(max(-1.0, (c * c + rf * rf - clear * clear) / (2.0 * c * rf)))
        base = (0.5 + plate) * TURN / follower.count
        return RollerSweep(turret_tracks(first, follower.count // self.plates, base, reach), edge)

    def cutters(self, setup: Setup) -> tuple[Track, ...]:
        """The tools: rollers larger by the running clearance, each over the cam angles at which its wall remains."""
        return tuple(track for sweep in _sweeps(self, setup) for track in sweep.contacts)

    def tracks(self, setup: Setup) -> tuple[Track, ...]:
        """One track a wall: its roller over the cam angles at which it touches; equal names belong to one roller."""
        return tuple(track.grown(-self.running_clearance) for track in self.cutters(setup))

    def outlines(self, setup: Setup) -> dict[str, Outline]:
        """The plates' outlines by name."""
        return {f"plate {i + 1}": sweep.outline for i, sweep in enumerate(_sweeps(self, setup))}

    def inside(self, x: np.ndarray) -> np.ndarray:
        """Whether contact points (3, ...) lie on the plates: all do, since tracks end where their walls do."""
        return np.ones(x.shape[1:], dtype=bool)

    def bore_spec(self) -> Bore | None:
        """The bore, or None."""
        return Bore(self.bore, self.keyway_width, self.keyway_depth) if self.bore else None

    def walls(self, setup: Setup) -> tuple[Wall, ...]:
        """Widths of the horns at their tips, and what the deepest roller leaves about the bore."""
        found = []
        reach = Bore(self.bore, self.keyway_width, self.keyway_depth).reach if self.bore else 0.0
        for i, sweep in enumerate(_sweeps(self, setup)):
            name = f"plate {i + 1}"
            for part in sweep.chain:
                if isinstance(part, Rim):
                    width = 2.0 * part.radius * sin(0.5 * min(part.high - part.low, 0.5 * TURN))
                    found.append(Wall(f"{name} horn tip", width, None, "a smaller diameter cuts horns off where wider"))
            edges = [part for part in sweep.chain if isinstance(part, Edge)]
            points = [edge.curve(np.linspace(edge.low, edge.high, 2001)).points for edge in edges]
            least = min(float(np.hypot(*x).min()) for x in points)
            found.append(Wall(f"{name} to bore", least - reach, None, "a larger centre distance or a smaller bore"))
        return tuple(found)

    def gaps(self, setup: Setup) -> tuple[tuple[str, float, str], ...]:
        """Free distances of the turret in mm, each with advice: (name, distance, advice)."""
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TurretFollower)
        assert roller is not None
        ring = 2.0 * follower.pitch_radius * sin(0.5 * TURN * self.plates / follower.count) - roller.diameter
        shaft = self.center_distance - follower.pitch_radius - 0.5 * roller.diameter - 0.5 * self.bore
        return (
            ("between rollers of a ring", ring, "fewer rollers, smaller ones, or a larger pitch radius"),
            ("dial to camshaft", shaft, "a larger centre distance, or a thinner shaft"),
            ("plates to turret axis", self.center_distance - 0.5 * self.diameter, "a smaller diameter"),
        )

    def rollers(self, setup: Setup) -> tuple[Track, ...]:
        """Every roller of the turret, ring by ring."""
        assert isinstance(setup.follower, TurretFollower)
        count = setup.follower.count // self.plates
        rings = [sweep.tracks[0] for sweep in _sweeps(self, setup, False)]
        return tuple(replace(t, shift=t.shift + k * TURN / count) for t in rings for k in range(count))

    def dials(self, setup: Setup) -> tuple[tuple[float, float, float], ...]:
        """The turret's discs between the plates, each with its radius and its faces' heights z, mm."""
        follower, roller = setup.follower, setup.roller
        assert isinstance(follower, TurretFollower)
        assert roller is not None
        radius, play = follower.pitch_radius + 0.5 * roller.diameter, 0.05 * self.gap
        places = sorted({self._dial(plate) for plate in range(self.plates)})
        lows = [place * self.pitch + self.width + play for place in places]
        return tuple((radius, low, low + self.gap - 2.0 * play) for low in lows)

    def turret(self, setup: Setup, cam_angle: float = 0.0) -> StackedTurret:
        """The turret with its rings of rollers as it stands at a cam angle (rad)."""
        assert isinstance(setup.follower, TurretFollower)
        count, dials = setup.follower.count // self.plates, self.dials(setup)
        rings = []
        for plate, sweep in enumerate(_sweeps(self, setup, False)):
            radius, low, high = dials[self._dial(plate) // 2 if self._dial(plate) % 2 == 0 else -1]
            ends = self._along_turret(low, high)
            rings.append(TurretBody(sweep.tracks[0], count, radius, *ends, 0.5 * (low + high), cam_angle))
        shaft = min(0.35 * setup.follower.pitch_radius, 0.8 * (self.center_distance - 0.5 * self.diameter))
        return StackedTurret(tuple(rings), shaft, *self._along_turret(-self.gap, self.plates * self.pitch))

    def _along_turret(self, low: float, high: float) -> tuple[float, float]:
        """Heights z as places along the turret's axis, which points down where the cam turns counter-clockwise."""
        return (-high, -low) if self.sense > 0.0 else (low, high)

    def parts(self, setup: Setup) -> tuple[Part, ...]:
        """The plates, from the lowest up."""
        found = []
        for i, (name, outline) in enumerate(self.outlines(setup).items()):
            low = i * self.pitch
            found.append(Prism(name, Loop(outline, "flank"), low, low + self.width, (), self.bore_spec()))
        return tuple(found)


@lru_cache(maxsize=16)
def _sweeps(cam: Cam, setup: Setup, cut: bool = True) -> tuple[RollerSweep, ...]:
    """What the rollers (the tools, where cut) sweep from every plate. Raises DesignError where no plate is left."""
    gap = cam.running_clearance if cut else 0.0
    found = tuple(cam._sweep(setup, plate, gap) for plate in range(cam.plates))
    if cut:
        for sweep in found:
            sweep.chain  # noqa: B018
    return found
