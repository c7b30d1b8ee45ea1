"""The shape of one design as facts: motion, tracks, flanks, bodies, walls, clearances, mass."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import degrees
from typing import TYPE_CHECKING

import numpy as np

from camgeom.errors import DesignError
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme
from camgeom.model.facts import Ledger, Observer, fact
from camgeom.profile import Profile
from camgeom.track import TURN, Track
from camgeom.track.follower import Setup
from camgeom.track.survey import Survey

if TYPE_CHECKING:
    from camgeom.cams import Cam
    from camgeom.solid import Part, Solid
    from camgeom.solid.blank import Blank, Wall
    from camgeom.solid.mechanism import Mechanism
    from camgeom.track.clearance import Clearance
    from camgeom.track.pair import PairResidual
    from camgeom.track.planar import Planar



@dataclass(frozen=True)
class MassProperties:
    """Volume mm³, mass kg, centroid mm and inertia tensor about it, kg m² (uniform density)."""

    volume: float
    mass: float
    centroid: tuple[float, float, float]
    inertia: tuple[tuple[float, float, float], ...]


class Shape:
    """Facts of a profile's geometry; `Model` adds what acts on it. Abstract: make a Model."""

    def __init__(self, profile: Profile, tolerance: float | None = None, observer: Observer | None = None) -> None:
        self.profile = profile
        self.tolerance = tolerance if tolerance is not None else profile.output.tolerance
        self.ledger = Ledger(observer)

    @property
    def cam(self) -> Cam:
        """The [cam] table."""
        return self.profile.cam

    @fact
    def setup(self) -> Setup:
        """Follower, roller and motion program in internal units."""
        return self.profile.setup()

    @cached_property
    def mechanism(self) -> Mechanism:
        """The cam bound to its follower, roller and program."""
        return self.profile.cam.mechanism(self.setup)

    @fact
    def tracks(self) -> tuple[Track, ...]:
        """The roller tracks; empty for followers without a roller."""
        return self.mechanism.tracks

    @fact
    def passages(self) -> tuple[Track, ...]:
        """Every roller over all the cam angles at which it is beside the cam, also where it touches nothing."""
        return self.mechanism.passages

    @fact
    def drive_angle(self) -> Extreme | None:
        """Largest pressure angle, rad, of the best placed roller, of cams whose rollers take turns.

        None for others, where every roller has to be driven all the way.
        """
        turret = self.mechanism.turret
        if turret is None or not turret.take_turns:
            return None
        from camgeom.track.turret import largest_drive_angle

        value, cam_angle = largest_drive_angle(turret.bearing, self.mechanism.inside)
        return Extreme(value, cam_angle, 0.0, "best placed roller that carries")

    @fact
    def pressure_angle(self) -> Extreme | None:
        """Largest pressure angle, rad: between the contact normal and the velocity of the follower.

        Of a drum or globoid the velocity of the contact point, over the whole flank; of a planar cam that of the
        roller's centre; where rollers take turns that of the best placed one. None where nothing is driven.
        """
        if self.drive_angle is not None:
            return self.drive_angle
        if self.planar is not None:
            return self.planar.pressure_angle
        return max((survey.pressure_angle for survey in self.flanks), key=lambda worst: worst.value, default=None)

    @fact
    def cutters(self) -> tuple[Track, ...]:
        """The tracks with the tool that cuts them (clearance, groove depth)."""
        return self.mechanism.cutters

    @fact
    def flanks(self) -> tuple[Survey, ...]:
        """A survey of every track: pressure angle, curvature, undercut margin, sliding, with refined extremes."""
        foot = self.mechanism.wall_foot
        pairs = zip(self.tracks, self.cutters)
        if self.mechanism.touches:
            # The wall of a disc is straight along the roller: it is not the envelope of a crown.
            pairs = zip((t.straightened() for t in self.tracks), (t.straightened() for t in self.cutters))
        return tuple(Survey(track, cutter, foot) for track, cutter in pairs)

    @fact
    def parts(self) -> tuple[Part, ...]:
        """The recipes of the bodies."""
        return self.mechanism.parts

    @fact
    def solids(self) -> tuple[Solid, ...]:
        """The finished bodies within the tolerance. Raises DesignError where the cam is undercut."""
        try:
            self.refuse_folded()
        except DesignError:
            drum, blank = self.mechanism.drum, self.mechanism.blank
            if not self.profile.output.undercut_solid or drum is None or drum.depth is None or blank is None:
                raise
            return (self._undercut_body(blank, drum.radius, drum.depth),)
        return tuple(part.solid(self.tolerance) for part in self.parts)

    def _undercut_body(self, blank: Blank, radius: float, depth: float) -> Solid:
        """What the tool really leaves of an undercut drum, asked for by [output] undercut_solid."""
        from camgeom.solid.cut import RollerUnion

        beyond = radius + max(0.05 * radius, 0.25 * depth)
        return RollerUnion("cam", self.cutters, blank, beyond).solid(self.tolerance)

    @property
    def solid(self) -> Solid:
        """The cam's (first) body."""
        return self.solids[0]

    def refuse_folded(self) -> None:
        """Raise DesignError where a flank folds back on itself or the motion jumps, so that no solid exists."""
        continuity = self.setup.program.continuity
        if continuity.order < 1 and (self.tracks or self.planar is not None):
            angles = ", ".join(f"{degrees(j.angle):.6g}" for j in continuity.jumps if j.order <= 1)
            raise DesignError(f"the motion's velocity jumps at {angles} deg, so the flank has gaps there and no solid")
        if self.planar is not None:
            self.planar.refuse_folded()
        for survey in self.flanks:
            if survey.margin.value <= 0.0:
                at = survey.margin
                raise DesignError(
                    f"track {survey.track.name!r} is undercut at cam angle {degrees(at.cam_angle):.6g} deg "
                    f"(margin 1 - r k = {at.value:.6g}, must be above 0), so its flank bounds no solid; use a smaller "
                    "roller, a larger cam or a gentler motion"
                )

    @fact
    def turret(self) -> Solid | None:
        """The turret with its rollers at cam angle zero, for assemblies; None where the follower is no turret."""
        turret = self.mechanism.turret
        return turret.body.solid(self.tolerance) if turret else None

    @fact
    def walls(self) -> tuple[Wall, ...]:
        """Thinnest walls of the bodies."""
        return self.mechanism.walls

    @fact
    def clearances(self) -> tuple[Clearance, ...]:
        """Least distance between every roller and the final mesh over the whole turn."""
        return self.clearances_with(0.0)

    def clearances_with(self, grow: float) -> tuple[Clearance, ...]:
        """The same with rollers larger by `grow` mm (normal)."""
        from camgeom.track.clearance import least_clearance

        return tuple(least_clearance(track, *self._surface_points(track), grow) for track in self.passages)

    def _surface_points(self, track: Track) -> tuple[Floats, Floats]:
        """Vertices of all bodies, and by how much each may stand inside the true surface, mm.

        A vertex that a boolean put on the crossing of two faces lies on facets, not on the true surface. A planar
        cam's walls run along the roller, with vertices at their ends alone: those are taken beside the roller's middle.
        """
        from camgeom.track.clearance import floor_points, wall_points

        points = [solid.mesh.vertices for solid in self.solids]
        if self.planar is not None:
            points = [wall_points(solid.mesh, 0.5 * sum(track.contact)) for solid in self.solids]
        rungs = [floor_points(solid.mesh) for solid in self.solids]
        slack = [
            np.where(solid.mesh.seam_vertices, solid.chord_error, 0.0) if solid.method != "direct" else
            np.zeros(len(solid.mesh.vertices))
            for solid in self.solids
        ]
        slack += [np.full(len(rung), solid.chord_error) for rung, solid in zip(rungs, self.solids)]
        return np.concatenate([*points, *rungs]), np.concatenate(slack)

    @fact
    def mass(self) -> tuple[MassProperties, ...]:
        """Mass properties of every body from its mesh and the cam material's density."""
        from camgeom.maths.mesh import mass_properties

        density = self.profile.material.cam.density
        return tuple(MassProperties(*mass_properties(solid.mesh, density)) for solid in self.solids)

    @fact
    def planar(self) -> Planar | None:
        """What touches a planar cam, and its extremes; None for other cams."""
        mechanism = self.mechanism
        if not mechanism.touches:
            return None
        from camgeom.track.planar import Planar

        span, offset = mechanism.span_between, mechanism.follower.offset
        return Planar(mechanism.touches, mechanism.outlines, mechanism.program, span, offset)

    @fact
    def pair(self) -> PairResidual | None:
        """Gap at the second roller of a pair that drives a follower both ways; None for other cams.

        None too where the motion's velocity jumps: the discs then have gaps, and no solid.
        """
        if self.planar is None or not self.planar.form_closed or len(self.tracks) != 2:
            return None
        if self.setup.program.continuity.order < 1:
            return None
        from camgeom.track.pair import pair_residual

        return pair_residual(*self.tracks, np.linspace(0.0, TURN, 1440, endpoint=False))
