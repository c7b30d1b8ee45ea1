"""One design and every fact about it, each computed when first asked for, and once.

    model = camgeom.read("profiles/pin_insertion.toml")
    model.flanks, model.solid, model.duty.contact, model.duty.roller_life

There are no flags: what nobody asks for is not computed and what only it needs is not imported.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from camgeom.errors import DesignError
from camgeom.facts import Ledger, Observer, fact
from camgeom.follower import CylinderRoller, Setup, TranslatingFollower, TurretFollower
from camgeom.profile import Profile
from camgeom.survey import Survey
from camgeom.track import TURN, Track

if TYPE_CHECKING:
    from camgeom.clearance import Clearance
    from camgeom.duty import Duty
    from camgeom.dynamics.follower_study import FollowerStudy
    from camgeom.dynamics.impact_run import ImpactRun
    from camgeom.dynamics.indexing_study import IndexingStudy
    from camgeom.machining.outcome import Outcome
    from camgeom.machining.plan import Machining
    from camgeom.mechanics.contact import Contact
    from camgeom.mechanics.fatigue import RollerLife
    from camgeom.planar import Planar
    from camgeom.planar_force import PlanarDrive
    from camgeom.planar_pair import PairResidual
    from camgeom.solid import Part, Solid
    from camgeom.turret_duty import TurretDuty

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class MassProperties:
    """Volume mm³, mass kg, centroid mm and inertia tensor about it, kg m² (uniform density)."""

    volume: float
    mass: float
    centroid: tuple[float, float, float]
    inertia: tuple[tuple[float, float, float], ...]


class Model:
    """A profile and its facts. Facts are attributes; `ledger.costs` says which were computed and what they cost."""

    def __init__(self, profile: Profile, tolerance: float | None = None, observer: Observer | None = None) -> None:
        self.profile = profile
        self.tolerance = tolerance if tolerance is not None else profile.output.tolerance
        self.ledger = Ledger(observer)

    @property
    def cam(self) -> Any:
        """The cam section of its kind."""
        return self.profile.cam

    @fact
    def setup(self) -> Setup:
        """Follower, roller and motion program in internal units."""
        return self.profile.setup()

    @fact
    def tracks(self) -> tuple[Track, ...]:
        """The roller tracks; empty for followers without a roller."""
        return tuple(self.cam.tracks(self.setup))

    @fact
    def passages(self) -> tuple[Track, ...]:
        """Every roller over all the cam angles at which it is beside the cam, also where it touches nothing."""
        passages = getattr(self.cam, "passages", None)
        return tuple(passages(self.setup)) if passages else self.tracks

    @property
    def engaged(self) -> tuple[Track, ...]:
        """The tracks whose walls a turret's rollers may bear on, where their cam's `inside` says so."""
        return self.tracks if getattr(self.cam, "SHARED_DRIVE", False) else self.passages

    @fact
    def drive_angle(self) -> tuple[float, float] | None:
        """Largest pressure angle (rad) of the best placed roller, and its cam angle, of cams whose rollers take turns.

        None for others, where every roller has to be driven all the way.
        """
        if not getattr(self.cam, "SHARED_DRIVE", False):
            return None
        from camgeom.turret_ribs import largest_drive_angle

        return largest_drive_angle(self.tracks, self.cam.inside)

    @fact
    def cutters(self) -> tuple[Track, ...]:
        """The tracks with the tool that cuts them (clearance, groove depth)."""
        cutters = getattr(self.cam, "cutters", None)
        return tuple(cutters(self.setup)) if cutters else self.tracks

    @fact
    def flanks(self) -> tuple[Survey, ...]:
        """A survey of every track: pressure angle, curvature, undercut margin, sliding, with refined extremes."""
        foot = getattr(self.cam, "wall_foot", None)
        return tuple(Survey(track, cutter, foot) for track, cutter in zip(self.tracks, self.cutters))

    @fact
    def parts(self) -> tuple[Part, ...]:
        """The recipes of the bodies."""
        return tuple(self.cam.parts(self.setup))

    @fact
    def solids(self) -> tuple[Solid, ...]:
        """The finished bodies within the tolerance. Raises DesignError where the cam is undercut."""
        try:
            self.refuse_folded()
        except DesignError:
            if not (self.profile.output.undercut_solid and self.profile.kind == "cylindrical"):
                raise
            return (self._undercut_body(),)
        return tuple(part.solid(self.tolerance) for part in self.parts)

    def _undercut_body(self) -> Solid:
        """What the tool really leaves of an undercut drum, asked for by [output] undercut_solid."""
        from camgeom.roller_union import RollerUnion

        beyond = self.cam.radius + max(0.05 * self.cam.radius, 0.25 * self.cam.groove_depth)
        return RollerUnion("cam", self.cutters, self.cam.blank(self.setup), beyond).solid(self.tolerance)

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
        recipe = getattr(self.cam, "turret", None)
        return recipe(self.setup).solid(self.tolerance) if recipe else None

    @fact
    def walls(self) -> tuple[Any, ...]:
        """Wall thicknesses of the body: name, thickness mm, cam angle rad."""
        walls = getattr(self.cam, "walls", None)
        return tuple(walls(self.setup)) if walls else ()

    @fact
    def clearances(self) -> tuple[Clearance, ...]:
        """Least distance between every roller and the final mesh over the whole turn."""
        return self.clearances_with(0.0)

    def clearances_with(self, grow: float) -> tuple[Clearance, ...]:
        """The same with rollers larger by `grow` mm (normal)."""
        from camgeom.clearance import least_clearance

        return tuple(least_clearance(track, *self._surface_points(track), grow) for track in self.passages)

    def _surface_points(self, track: Track) -> tuple[Floats, Floats]:
        """Vertices of all bodies, and by how much each may stand inside the true surface, mm.

        A vertex that a boolean put on the crossing of two faces lies on facets, not on the true surface. A planar
        cam's walls run along the roller, with vertices at their ends alone: those are taken beside the roller's middle.
        """
        from camgeom.clearance import floor_points, wall_points

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
        from camgeom.maths.massprops import mass_properties

        density = self.profile.material.cam.density
        return tuple(MassProperties(*mass_properties(solid.mesh, density)) for solid in self.solids)

    @property
    def loaded(self) -> bool:
        """True where the profile has an [operation] and a roller follower that one roller at a time serves."""
        simple = not isinstance(self.setup.follower, TurretFollower) and self.setup.roller is not None
        return self.profile.operation is not None and bool(self.tracks) and simple

    @fact
    def planar(self) -> Planar | None:
        """What touches a planar cam, and its extremes; None for other cams."""
        if not hasattr(self.cam, "touches"):
            return None
        from camgeom.planar import planar_of

        return planar_of(self.cam, self.setup)

    @fact
    def pair(self) -> PairResidual | None:
        """Gap at the second roller of a pair that drives a follower both ways; None for other cams.

        None too where the motion's velocity jumps: the discs then have gaps, and no solid.
        """
        if self.planar is None or not self.planar.form_closed or len(self.tracks) != 2:
            return None
        if self.setup.program.continuity.order < 1:
            return None
        from camgeom.planar_pair import pair_residual

        return pair_residual(*self.tracks, np.linspace(0.0, TURN, 1440, endpoint=False))

    @property
    def driven(self) -> bool:
        """True for a planar cam whose profile has an [operation]."""
        return self.profile.operation is not None and hasattr(self.cam, "touches")

    @fact
    def drive(self) -> PlanarDrive:
        """Forces of a planar cam on its follower. Raises ProfileError where the profile has no [operation]."""
        from camgeom.loading import follower_load
        from camgeom.planar_force import PlanarDrive

        material, planar = self.profile.material, self.planar
        if planar is None:
            raise DesignError(f"a {self.profile.kind} cam has no planar outline to compute the force on")
        load = follower_load(self.profile, self.setup)
        return PlanarDrive(planar.touches, load, material.roller, material.cam)

    @property
    def turret_loaded(self) -> bool:
        """True where the profile has an [operation] and a turret, whose rollers share the load."""
        turret = isinstance(self.setup.follower, TurretFollower) and hasattr(self.cam, "inside")
        return self.profile.operation is not None and bool(self.tracks) and turret

    @fact
    def turret_duty(self) -> TurretDuty:
        """Load sharing, stress and life of a turret. Raises ProfileError where the profile has no [operation]."""
        from camgeom.loading import angular_speed, follower_load, operation_of
        from camgeom.turret_duty import TurretDuty

        cam, operation = self.cam, operation_of(self.profile, "stress and life")
        return TurretDuty(
            self.engaged,
            cam.inside,
            follower_load(self.profile, self.setup),
            self.profile.material.roller,
            self.profile.material.cam,
            angular_speed(operation.speed),
            getattr(cam, "preload", 0.0),
            cam.width,
            cam.bore,
        )

    @fact
    def indexing(self) -> IndexingStudy | None:
        """The elastic indexing drive; None where the profile has no such [dynamics]."""
        from camgeom.vibration import indexing_of

        spec = self.profile.dynamics_spec
        return indexing_of(self) if spec is not None and spec.kind == "indexing" else None

    @fact
    def elastic_follower(self) -> FollowerStudy | None:
        """The elastic follower; None where the profile has no such [dynamics]."""
        from camgeom.vibration import elastic_follower_of

        spec = self.profile.dynamics_spec
        if spec is None or spec.kind != "follower":
            return None
        return elastic_follower_of(self.profile, self.setup, all(len(t.sides) < 2 for t in self.tracks))

    @fact
    def impact(self) -> ImpactRun | None:
        """The follower's motion in its clearance, solved; None where the profile has no [impact]."""
        from camgeom.vibration import impact_of

        return impact_of(self.profile, self.setup, self.tracks) if self.profile.impact_spec is not None else None

    @fact
    def machining(self) -> Machining:
        """Cutter data of the profile's [cutter] tool (default: one like the roller).

        Raises DesignError where the cam is undercut or the tool cuts into it, ProfileError where no tool fits.
        """
        self.machined.refuse_gouges()
        return self.machined.machining

    @fact
    def machined(self) -> Outcome:
        """What that tool leaves of the flanks, gouges among them: stock, ridges, passes."""
        from camgeom.machining.job import machining_of
        from camgeom.machining.outcome import Outcome
        from camgeom.machining.spec import CutterSpec

        spec = self.profile.cutter_spec or CutterSpec()
        if not (self.profile.output.undercut_solid and spec.kind == "roller"):
            self.refuse_folded()
        made = machining_of(self.profile.name, spec, self.cam, self.setup, self.cutters, self.parts)
        return Outcome(made, getattr(self.cam, "inside", None))

    @property
    def classical(self) -> bool:
        """True for a loaded groove drum with a translating cylindrical roller: the case of the literature."""
        kinds = self.profile.kind == "cylindrical" and isinstance(self.setup.follower, TranslatingFollower)
        return self.loaded and kinds and isinstance(self.setup.roller, CylinderRoller) and self.cam.form == "groove"

    @fact
    def duty(self) -> Duty:
        """Force, contact stress, life and torque of the hardest pressed roller.

        Raises ProfileError where the profile has no [operation].
        """
        if len(self.duties) == 1:
            return self.duties[0]
        return max(self.duties, key=lambda duty: float(duty.contact.peak().pressure))

    @property
    def contact(self) -> Contact | TurretDuty | PlanarDrive:
        """Contact stress over the turn: of the hardest pressed roller, of a turret's rollers that share the load, or of
        the faces of a cam without a roller. Raises ProfileError where the profile has no [operation]."""
        if self.turret_loaded:
            return self.turret_duty
        return self.drive if self.driven and not self.loaded else self.duty.contact

    @property
    def life(self) -> RollerLife | TurretDuty:
        """Fatigue life of the hardest pressed roller, h; of a turret with its lives of roller, cam and bearing.

        Raises ProfileError where the profile has no [operation], DesignError for a follower without a roller.
        """
        if self.turret_loaded:
            return self.turret_duty
        if self.setup.roller is None:
            raise DesignError(f"a {self.setup.follower.kind} follower without a roller has no roller life")
        return self.duty.roller_life

    @fact
    def duties(self) -> tuple[Duty, ...]:
        """The duty of every roller: of two that drive a follower to and fro each carries its own direction."""
        from camgeom.loading import roller_duty

        flat = self.planar is not None
        return tuple(roller_duty(self.profile, self.setup, track, flat) for track in self.tracks)


def read(path: str) -> Model:
    """The model of a profile file. Raises ProfileError with every problem found."""
    from camgeom.profile import read as read_profile

    return Model(read_profile(path))
