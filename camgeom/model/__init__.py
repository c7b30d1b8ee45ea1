"""One design and every fact about it, each computed when first asked for, and once.

    model = camgeom.read("profiles/pin_insertion.toml")
    model.flanks, model.solid, model.duty.contact, model.duty.roller_life

There are no flags: what nobody asks for is not computed and what only it needs is not imported.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from math import degrees, inf
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

import numpy as np
import numpy.typing as npt

from camgeom.errors import DesignError
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme
from camgeom.maths.frozen import fact, fact_of
from camgeom.model.body import Body, MassProperties
from camgeom.model.seen import Seen
from camgeom.profile import Readable, given
from camgeom.solid.mechanism import Drive
from camgeom.track import TURN, Swing, Track

if TYPE_CHECKING:
    from camgeom.body.compliance import Below
    from camgeom.body.stress import RootStress
    from camgeom.body.volume import Volume
    from camgeom.dynamics.follower.study import FollowerStudy
    from camgeom.dynamics.impact.run import ImpactRun
    from camgeom.dynamics.impact.study import StartSensitivity, StudyRow, Unsolved
    from camgeom.dynamics.indexing.study import IndexingStudy
    from camgeom.machining.outcome import Outcome
    from camgeom.machining.plan import Machining
    from camgeom.mechanics.bearing import BearingLife
    from camgeom.mechanics.contact import Contact
    from camgeom.mechanics.duty import Duty
    from camgeom.mechanics.face_duty import FaceDuty
    from camgeom.mechanics.film import Film
    from camgeom.mechanics.life import RollerLife
    from camgeom.mechanics.load import Load
    from camgeom.mechanics.roller_duty import RollerDuty
    from camgeom.mechanics.slide_drive import SlideDrive
    from camgeom.mechanics.turret_duty import TurretDuty
    from camgeom.model.arrays import MotionArrays
    from camgeom.model.loaded import ShaftDemand
    from camgeom.model.tables import TableFit
    from camgeom.model.together import Shaft
    from camgeom.solid import Part, Solid
    from camgeom.solid.blank import Wall
    from camgeom.tolerance.causes import Sharing
    from camgeom.tolerance.machine import MachineStudy
    from camgeom.tolerance.study import ToleranceStudy
    from camgeom.track.clearance import Clearance
    from camgeom.track.flank import Flank
    from camgeom.track.pair import PairResidual
    from camgeom.track.planar import Planar
    from camgeom.track.survey import Survey


ALIKE = 1e-6
"""share by which the pressures of two rollers may differ that are pressed alike: what their solution leaves open"""
MEAN = "hot spots of the counted turns"
HARDEST = "every turn as the hardest counted one"


def _on_half_space(body: Body) -> None:
    """Raise NotConverged where contacts on a half-space would take too long."""
    from camgeom.model.price import HALF_SPACE, afford

    afford(body, HALF_SPACE)


def _pressed(duty: Duty | None) -> tuple[float, float]:
    """Largest pressure, MPa, and force, N, of a duty, 0 of none."""
    return (0.0, 0.0) if duty is None else (_hardness(duty), duty.peak_force.value)


def _hardness(duty: Duty) -> float:
    """Largest pressure of a duty, MPa; infinite where none is the largest."""
    return duty.peak_pressure.value if duty.peak_pressure is not None else inf


TELLERS: list[Callable[[Model], str]] = []
"""what layers above add to the line that shows a model, such as its verdict where it was judged"""
PAINTERS: list[Callable[[Model], str]] = []
"""how a layer above shows a model in a notebook, as HTML; the first is asked"""


@final
class Model(Seen):
    """A profile and its facts. Facts are attributes; `ledger.costs` says which were computed and what they cost.

    A model sees its cam from one follower. All followers of the cam are `bindings`, models that share one `body`.
    Nothing of it can be set or written into; several threads may ask one model, and it can be pickled.
    """

    @property
    def hardest_state(self) -> Model:
        """The state with the largest pressure, of contacts without one with the largest force; without [[duty]] itself.
        """
        return max(self._running, key=lambda one: _pressed(one.carrier), default=self)

    @property
    def parts(self) -> tuple[Part, ...]:
        """The recipes of the bodies."""
        return self.body.parts

    @property
    def solids(self) -> tuple[Solid, ...]:
        """The finished bodies within the tolerance. Raises DesignError where the cam is undercut."""
        return self.body.solids

    @property
    def solid(self) -> Solid:
        """The cam's (first) body."""
        return self.body.solids[0]

    @property
    def walls(self) -> tuple[Wall, ...]:
        """Thinnest walls of the bodies."""
        return self.body.walls

    @property
    def mass(self) -> tuple[MassProperties, ...]:
        """Mass properties of every body, of the cam material's density."""
        return self.body.mass

    @fact
    def tracks(self) -> tuple[Track, ...]:
        """The roller tracks; empty for followers without a roller."""
        return self.mechanism.tracks

    @fact
    def passages(self) -> tuple[Track, ...]:
        """Every roller over all the cam angles at which it is beside the cam, also where it touches nothing."""
        return self.mechanism.passages

    @fact
    def cutters(self) -> tuple[Track, ...]:
        """The tracks with the tool that cuts them (clearance, groove depth)."""
        return self.mechanism.cutters

    def within(self, x: Floats) -> Floats:
        """How deep points (3, ...) of the flanks lie on the cam's material, mm, by the track that has them deepest."""
        return np.asarray(np.maximum.reduce([one.mechanism.within(x) for one in self.grooves]))

    @fact
    def tables(self) -> tuple[TableFit, ...]:
        """How near the motion runs to the rows of every segment that follows a table."""
        if all(segment.law != "table" for segment in self.profile.motion):
            return ()
        from camgeom.model.tables import table_fits

        return table_fits(self)

    @fact
    def drive_angle(self) -> Extreme | None:
        """Largest pressure angle, rad, of the best placed roller, of cams whose rollers take turns.

        None for others, where every roller has to be driven all the way.
        """
        turret = self.mechanism.turret
        if turret is None or not turret.take_turns:
            return None
        from camgeom.track.turret import largest_drive_angle

        return largest_drive_angle(turret.bearing, self.mechanism.within)

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
    def flanks(self) -> tuple[Survey, ...]:
        """A survey of every track: pressure angle, curvature, undercut margin, sliding, with refined extremes."""
        from camgeom.track.runout import walled
        from camgeom.track.survey import Survey

        mechanism, turret = self.mechanism, self.mechanism.turret
        foot, cutting = mechanism.wall_foot, mechanism.cutting
        pairs = list(zip(map(cutting, self.tracks), map(cutting, self.cutters)))
        within = mechanism.within if mechanism.runs_out else None
        if turret is not None and not turret.take_turns:
            # A roller bears beyond where its middle leaves the cam, as long as any of its wall is there.
            within = mechanism.within
            borne = [walled(cutting(track), within) for track in turret.bearing]
            pairs = [(track, cutting(tool)) for track, tool in zip(borne, self.cutters) if track is not None]
        return tuple(Survey(track, cutter, foot, within, mechanism.wall_mouth) for track, cutter in pairs)

    @fact
    def lost_contact(self) -> dict[str, tuple[tuple[float, float], ...]]:
        """Stretches of cam angle (from, to), rad, by flank, over which a roller that leaves its cam has none beside it.

        Empty where no roller leaves its cam on purpose.
        """
        if not self.mechanism.runs_out:
            return {}
        from camgeom.track.runout import missing
        from camgeom.track.survey import FLANKS

        within, many = self.mechanism.within, len(self.tracks) > 1
        return {
            f"{track.name} {name}" if many else name: missing(self.mechanism.cutting(track), side, within)
            for track in self.tracks
            for name, side in FLANKS.items()
            if side in track.sides
        }

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
    def frame(self) -> Solid | None:
        """The frame about the cam as it stands at zero lift; None where the profile does not make it a part."""
        plate = self.mechanism.frame
        return plate.solid(self.tolerance) if plate else None

    @property
    def frame_mass(self) -> float | None:
        """Of the frame's plate, kg, of the density of `material.roller`; None where it is no part."""
        plate = self.mechanism.frame
        return plate.volume * self.profile.material.roller.density * 1e-9 if plate else None

    @property
    def workpieces(self) -> tuple[tuple[Solid, float], ...]:
        """Everything that is made, with its density, kg/m3: the bodies of the cam, and a frame that is a part."""
        material = self.profile.material
        frame = () if self.frame is None else ((self.frame, material.roller.density),)
        return (*((solid, material.cam.density) for solid in self.solids), *frame)

    @fact
    def clearances(self) -> tuple[Clearance, ...]:
        """Least distance between every roller, face or edge and the final mesh over the whole turn."""
        return self.clearances_with(0.0)

    def clearances_with(self, grow: float) -> tuple[Clearance, ...]:
        """The same with followers larger by `grow` mm (normal).

        On a straight flank a crowned roller counts as the cylinder of its crest, which touches wherever vertices are.
        """
        from camgeom.model.finished import clearances

        return clearances(self, grow)

    @property
    def envelope(self) -> tuple[float, float]:
        """Diameter and length, mm, of the cylinder about the axis that just holds the finished cam with all tracks."""
        diameters, lengths = zip(*(one.mechanism.envelope for one in self.grooves))
        return max(diameters), max(lengths)

    @fact
    def backlash(self) -> tuple[Clearance, ...]:
        """The largest distance at which the follower passes a point of each body's flank, mm: what is cut too deep."""
        from camgeom.model.finished import backlash

        return backlash(self)

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
    def profiles(self) -> Planar | None:
        """The profiles of a disc, also where a cone makes another one at every height; None for other cams."""
        mechanism = self.mechanism
        if mechanism.touches or not mechanism.profiles:
            return self.planar
        from camgeom.track.planar import Planar

        return Planar(mechanism.profiles, mechanism.outlines, mechanism.program)

    @fact
    def pivot_gap(self) -> Extreme | None:
        """Least distance from an arm's pivot to the circle that its disc sweeps, or to its plate as that goes to and
        fro, mm; negative: within it. None without an arm, and of one beside its cam, as in a groove."""
        profiles = self.profiles
        if profiles is None:
            return self.mechanism.pivot_gap
        joint = profiles.touches[0].joint
        if not isinstance(joint, Swing) or any(touch.material < 0.0 for touch in profiles.touches):
            return None
        swept = profiles.largest_radius
        return replace(swept, value=float(np.hypot(*joint.centre[:2])) - swept.value)

    @fact
    def pair(self) -> PairResidual | None:
        """Gap at the second roller of a pair that drives a follower both ways; None for other cams.

        None too where the motion's velocity jumps: the discs then have gaps, and no solid.
        """
        if self.profiles is None or not self.profiles.form_closed or len(self.tracks) != 2:
            return None
        if self.setup.program.continuity.order < 1:
            return None
        from camgeom.track.pair import pair_residual

        return pair_residual(*self.tracks, np.linspace(0.0, TURN, 1440, endpoint=False))

    @fact
    def load(self) -> Load:
        """What acts on the follower. Raises ProfileError where the profile has no [operation]."""
        from camgeom.model.loads import load_of

        return load_of(self.profile, self.mechanism, 1.0 if self.state is None else self.state.load_factor)

    @fact
    def drive(self) -> FaceDuty | None:
        """Forces of a planar cam on its follower; None for other cams, and without an [operation]."""
        from camgeom.model.loads import face_duty

        if self.profile.operation is None or not self.mechanism.touches:
            return None
        return face_duty(self.profile.material, self.load, self.mechanism.touches)

    @property
    def root_limit(self) -> float | None:
        """What the body endures in bending, MPa: material.cam.bending_limit, of a frame that is a part the roller's."""
        material = self.profile.material
        return (material.cam if self.mechanism.frame is None else material.roller).bending_limit

    @fact
    def root_stress(self) -> RootStress | None:
        """Stress at a wall's root, or in a frame's plate, under its duty; None without these or without [operation]."""
        from camgeom.model.loaded import root_stress

        return root_stress(self)

    @fact
    def wall_stresses(self) -> dict[int, Floats]:
        """Nominal stress, MPa, of the walls of all followers on its track by their numbers, where they have one."""
        from camgeom.model.loaded import wall_stresses

        return wall_stresses(self)

    @fact
    def volume(self) -> Volume:
        """The body as hexahedra or tetrahedra with its load at output.load_angle_deg, for FE programs.

        Raises DesignError where the body cannot be meshed or nothing presses it, ProfileError without [operation].
        """
        from camgeom.model.loaded import volume

        return volume(self)

    @fact
    def frame_volume(self) -> Volume:
        """The frame's plate as hexahedra with the cam's load at output.load_angle_deg, for FE programs.

        Raises DesignError where the frame is no part or nothing presses it, ProfileError without [operation].
        """
        from camgeom.model.loaded import frame_volume

        return frame_volume(self)

    @fact
    def below(self) -> Below | None:
        """What the body gives way below its contacts; None without dynamics.body_compliance.

        Raises DesignError where it is pressed by nothing, or cannot be meshed, NotConverged with too many followers and
        operating states.
        """
        from camgeom.model.loaded import below

        return below(self)

    @fact
    def turret_duty(self) -> TurretDuty | None:
        """Load sharing, stress and life of a turret; None for other cams, and without an [operation]."""
        from camgeom.model.loads import ratings_of, turret_duty

        turret = self.mechanism.turret
        if self.profile.operation is None or turret is None:
            return None
        made = turret_duty(self.profile.material, self.mechanism, turret, self.load, ratings_of(self.profile)[0])
        return replace(made, paid=partial(_on_half_space, self.body)) if made.level == "finite" else made

    @fact_of("_moving")
    def indexing(self) -> IndexingStudy | None:
        """The elastic indexing drive; None where the profile has no such [dynamics]."""
        from camgeom.model.vibration import indexing_of, one_of

        spec = self.profile.dynamics_spec
        return one_of(self, lambda: indexing_of(self)) if spec is not None and spec.kind == "indexing" else None

    @fact_of("_moving")
    def elastic_follower(self) -> FollowerStudy | None:
        """The elastic follower; None where the profile has no such [dynamics]."""
        from camgeom.model.vibration import elastic_follower_of, one_of

        spec = self.profile.dynamics_spec
        if spec is None or spec.kind != "follower":
            return None
        return one_of(self, lambda: elastic_follower_of(self.profile, self.mechanism, self.load, self.below))

    @fact
    def dynamic_duties(self) -> tuple[Duty, ...]:
        """The duties of all that presses the cam under the force that [dynamics] finds; none where contact is lost."""
        from camgeom.model.vibration import dynamic_duties_of

        return dynamic_duties_of(self, "steady")

    @fact
    def start_duties(self) -> tuple[Duty, ...]:
        """The same in the first turn from rest; none of a motion that does not stand still where the turn begins."""
        from camgeom.model.vibration import dynamic_duties_of, starts_at_rest

        return dynamic_duties_of(self, "start") if starts_at_rest(self) else ()

    @property
    def dynamic_duty(self) -> Duty | None:
        """The hardest pressed of `dynamic_duties`; None without any."""
        return max(self.dynamic_duties, key=_hardness, default=None)

    @fact
    def dynamic_torque(self) -> Extreme | None:
        """Largest torque of the camshaft, N mm, under that force; None where there is none, or no shaft."""
        from camgeom.model.vibration import dynamic_torque_of

        turns = self.dynamic_duties and self.mechanism.carriage is None
        return dynamic_torque_of(self, self.dynamic_duties, "steady") if turns else None

    @fact
    def start_torque(self) -> Extreme | None:
        """The same in the first turn from rest."""
        from camgeom.model.vibration import dynamic_torque_of

        turns = self.start_duties and self.mechanism.carriage is None
        return dynamic_torque_of(self, self.start_duties, "start") if turns else None

    @fact
    def output_torque(self) -> Extreme | None:
        """Largest torque of a turret's output shaft, N mm, and whether with vibration or from rest; None of others."""
        from camgeom.model.vibration import output_torque_of

        return output_torque_of(self)

    @fact
    def output(self) -> ShaftDemand | None:
        """What the drive asks of the shaft and the bolts of [output_shaft]; None without that table, or a load."""
        spec = self.profile.output_shaft_spec
        if spec is None:
            return None
        from camgeom.model.loaded import output_of

        return output_of(self, spec)

    @fact_of("_moving")
    def impact(self) -> ImpactRun | None:
        """The follower's motion in its clearance, solved; None where the profile has no [impact]."""
        from camgeom.model.impact import impact_of

        if self.profile.impact_spec is None:
            return None
        return impact_of(self.profile, self.mechanism, self.load, self.impact_most)

    @fact_of("_moving")
    def impact_most(self) -> int | None:
        """Steps that this run may take, beside those of other followers and states, which are solved in their order."""
        from camgeom.model.impact import most_steps

        return most_steps(self)

    @fact_of("_moving")
    def impact_pressure(self) -> Extreme:
        """Largest contact pressure, MPa, of the follower in its clearance over the turns that [impact] counts."""
        from camgeom.model.impact import hardest_impact

        run, spec = self.impact, self.profile.impact_spec
        if run is None or spec is None:
            raise DesignError("the profile has no [impact]")
        return hardest_impact(run, spec.settle, self.impact_duties)

    @fact_of("_alike")
    def impact_duties(self) -> tuple[tuple[Duty, ...], ...]:
        """The duties of all that presses the cam in every turn that [impact] counts; none without it."""
        from camgeom.model.impact import impact_duties_of

        run = self.impact
        if run is None:
            return ()
        return impact_duties_of(self, run)

    @fact_of("_alike")
    def impact_lives(self) -> dict[str, float]:
        """Fatigue life, h, of every body under the history of impacts; empty without [impact]."""
        from camgeom.model.impact import impact_lives_of

        return impact_lives_of(self.impact_duties, self.impact_basis == MEAN)

    @property
    def impact_basis(self) -> str:
        """What those lives rest on: of a chaotic motion other turns will come than were counted."""
        found = self.impact_sensitivity
        return MEAN if found is None or found.reproducible >= found.turns else HARDEST

    @fact_of("_moving")
    def impact_torque(self) -> Extreme | None:
        """Largest torque of the camshaft, N mm, in the turns that [impact] counts; None without it."""
        run, spec = self.impact, self.profile.impact_spec
        if run is None or spec is None:
            return None
        peak = run.peak("cam_torque", run.turn_times()[spec.settle][0])
        return Extreme(1e3 * peak.value, peak.angle % TURN)

    @fact_of("_moving")
    def impact_sensitivity(self) -> StartSensitivity | None:
        """What becomes of a small disturbance of that motion; None where the profile has no [impact]."""
        from camgeom.dynamics.impact.study import sensitivity

        return sensitivity(self.impact) if self.impact is not None else None

    @fact_of("_moving")
    def impact_row(self) -> StudyRow | None:
        """Its peaks over the counted turns, and how far they can be trusted; None without [impact]."""
        from camgeom.dynamics.impact.study import statistics, tighter_change

        run, spec = self.impact, self.profile.impact_spec
        return statistics(run, spec.settle, "", tighter_change(run)) if run is not None and spec is not None else None

    @fact_of("_moving")
    def impact_clearances(self) -> tuple[StudyRow | Unsolved, ...]:
        """Peaks with every clearance that [impact] studies; empty without."""
        from camgeom.model.impact import clearance_rows

        run, spec = self.impact, self.profile.impact_spec
        return clearance_rows(self, run) if run is not None and spec is not None and spec.study else ()

    @fact_of("_moving")
    def impact_law_rows(self) -> tuple[StudyRow | Unsolved, ...]:
        """Peaks with every law that [impact] compares; empty without."""
        from camgeom.model.impact import law_rows

        spec = self.profile.impact_spec
        return law_rows(self) if spec is not None and spec.laws else ()

    @fact_of("_moving")
    def impact_law_runs(self) -> dict[str, ImpactRun]:
        """The motion in the clearance with every such law, to its first counted turn."""
        from camgeom.model.impact import law_runs

        spec = self.profile.impact_spec
        return law_runs(self.profile) if spec is not None and spec.laws else {}

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
            for one in self.grooves:
                one.refuse_folded()
        made = machining_of(self.profile.name, spec, [one.mechanism for one in self.grooves], self.parts)
        drum = self.mechanism.drum
        within = drum.under if drum is not None and drum.hollow else self.within
        return Outcome(replace(made, assumed=self.profile.cutter_spec is None), within)

    @fact
    def tolerances(self) -> ToleranceStudy:
        """What errors of assembly and manufacture do: each alone, and, where [tolerance] gives them, all together."""
        from camgeom.model.price import a_drawing
        from camgeom.tolerance.causes import default_pivots
        from camgeom.tolerance.sensitivity import Loaded
        from camgeom.tolerance.study import ToleranceStudy

        spec, material = self.profile.tolerance_spec, self.profile.material
        pivots = default_pivots(self.mechanism) if spec is None else spec.pivots(self.mechanism)
        load = self.hardest_state.load if self.profile.operation is not None else None
        loaded = Loaded(self.mechanism, material.roller, material.cam, load, pivots, self._peak)
        kin: list[tuple[Sharing, ToleranceStudy]] = []
        if self.number and self.bindings[0] is not self:
            kin.append(("body", self.bindings[0].tolerances))
        if self.mates[0].number != self.number:
            kin.append(("track", self.mates[0].tolerances))
        return ToleranceStudy(loaded, spec, self.number, self.groove, tuple(kin), partial(a_drawing, self))

    def _peak(self) -> float | None:
        carrier = self.hardest_state.carrier
        return None if carrier is None or carrier.least_peak is None else carrier.least_peak.value

    @property
    def machine_tolerances(self) -> MachineStudy:
        """What they do to all followers of the machine together: its yield, the widest tolerances that hold one."""
        return self.bindings[0]._machine_tolerances

    @fact
    def _machine_tolerances(self) -> MachineStudy:
        from camgeom.tolerance.machine import MachineStudy

        return MachineStudy(tuple(one.tolerances for one in self.bindings))

    @fact
    def duties(self) -> tuple[RollerDuty, ...]:
        """The duty of every roller: of two that drive a follower to and fro each carries its own direction.

        None of them without an [operation], for a turret, whose rollers share, and for a follower without a roller.
        """
        from camgeom.model.loads import ratings_of, roller_duties

        shared = self.mechanism.drive is Drive.SHARED
        if self.profile.operation is None or shared or self.mechanism.roller is None:
            return ()
        made = roller_duties(self.profile.material, self.mechanism, self.load, ratings_of(self.profile))
        if not any(roller.ends.stated or roller.arc is not None for roller in self.mechanism.rollers):
            return made
        return tuple(replace(duty, paid=partial(_on_half_space, self.body)) for duty in made)

    @fact
    def slide_drive(self) -> SlideDrive | None:
        """What the drive of a cam that slides gives along its travel; None of cams that turn, without an [operation].
        """
        return self._slide_drive(self.duties)

    @fact
    def dynamic_slide_drive(self) -> SlideDrive | None:
        """The same under the force that [dynamics] finds; None where there is none."""
        return self._slide_drive(self.dynamic_duties)

    @fact
    def start_slide_drive(self) -> SlideDrive | None:
        """The same in the first turn from rest."""
        return self._slide_drive(self.start_duties)

    def _slide_drive(self, duties: tuple[Duty, ...]) -> SlideDrive | None:
        carriage = self.mechanism.carriage
        if carriage is None or not duties:
            return None
        from camgeom.mechanics.roller_duty import RollerDuty
        from camgeom.mechanics.slide_drive import SlideDrive

        (duty,) = duties
        assert isinstance(duty, RollerDuty), "one roller runs on a plate"
        return SlideDrive(duty, carriage, self.mechanism.moving_mass)

    @fact
    def duty(self) -> RollerDuty:
        """Force, contact stress, life and torque of the hardest pressed roller; of two pressed alike of the first.

        Raises ProfileError where the profile has no [operation], DesignError where no roller is pressed alone.
        """
        from camgeom.model.loads import operation_of

        if not self.duties:
            operation_of(self.profile, "stress and life")
            raise DesignError(f"a {self.setup.follower.kind} follower has no roller that bears alone")
        if len(self.duties) == 1:
            return self.duties[0]
        most = max(map(_hardness, self.duties))
        return next(duty for duty in self.duties if _hardness(duty) >= (1.0 - ALIKE) * most)

    @property
    def carrier(self) -> Duty | None:
        """The duty of what presses the cam: a turret's rollers together, the hardest pressed roller, or the faces.

        None where the profile has no [operation].
        """
        if self.turret_duty is not None:
            return self.turret_duty
        return self.duty if self.duties else self.drive

    @property
    def carriers(self) -> tuple[Duty, ...]:
        """The duties of all that presses the cam: every roller, or what `carrier` has; none without [operation]."""
        return self.duties or ((self.carrier,) if self.carrier is not None else ())

    @property
    def bearing(self) -> BearingLife | None:
        """Of all rollers the bearing that lives least; None without a rated one."""
        rated = (duty.bearing for duty in self.carriers if duty.bearing is not None)
        return min(rated, key=lambda bearing: bearing.judged_h, default=None)

    @fact
    def film(self) -> Film | None:
        """The thinnest film of all that presses the cam; None without the keys that it takes, and where none is."""
        from camgeom.mechanics.film import Oil

        oil = Oil.between(self.profile.oil, self.profile.material.cam, self.profile.material.roller)
        if oil is None:
            return None
        found = [film for film in (duty.film(oil) for duty in self.carriers) if film is not None]
        return min(found, key=lambda film: film.least.value, default=None)

    @property
    def creeps(self) -> bool:
        """True of a crown on a straight flank along its own axis: nothing slides but its places of another radius than
        its crest's (Heathcote), which is not computed; elsewhere that is little beside what slides."""
        return self.mechanism.crown == "straight" and all(track.upright for track in self.tracks)

    @fact
    def friction_power(self) -> float | None:
        """Heat of the sliding contacts, W, the mean of a turn; None without a coefficient of friction or a load, and of
        a crown that `creeps`."""
        oil = self.profile.oil
        if oil is None or oil.friction is None or not self.carriers or self.creeps:
            return None
        return oil.friction * sum(duty.rubbed for duty in self.carriers) * 1e-3 * self.load.omega / TURN

    @fact
    def wear(self) -> dict[str, float]:
        """Depth that a turn wears off each body with a wear rate, mm, at its hardest rubbed place (Archard); none is
        known of a crown that `creeps`."""
        material, found, together = self.profile.material, dict[str, float](), 0.0
        rates = {"cam": material.cam.wear_rate, "roller": material.roller.wear_rate}
        for duty in self.carriers if any(rates.values()) and not self.creeps else ():
            for body, rubbing in duty.rubbing.items():
                rate = rates["cam" if body == "cam" else "roller"]
                if rate is not None:
                    found[body] = max(found.get(body, 0.0), 1e-3 * rate * rubbing)
                    together += 1e-3 * rate * rubbing if body == "cam" and duty.meeting is not None else 0.0
        return found | ({"cam": max(found["cam"], together)} if "cam" in found else {})

    @property
    def wear_per_hour(self) -> dict[str, float]:
        """The same in an hour of running, mm, over all operating states; of the cam under all followers."""
        if self.state is not None or len(self.mates) == 1:
            return self.own_wear
        every = [one.own_wear for one in self.mates]
        cam = sum(one.get("cam", 0.0) for one in every)
        return {body: cam if body == "cam" else depth for body, depth in self.own_wear.items()}

    @property
    def own_wear(self) -> dict[str, float]:
        """The same, with this follower alone on the cam."""
        total = dict[str, float]()
        for one in self.states:
            weight, speed = (1.0, one.load.omega) if one.state is None else (one.state.weight, one.load.omega)
            for body, depth in one.wear.items():
                total[body] = total.get(body, 0.0) + depth * weight * 3600.0 * speed / TURN
        return total

    @fact
    def lives(self) -> dict[str, float]:
        """Life, h, of every body at its hardest place, over all operating states; rigid.

        Of several followers on one track each wears out its own roller, and all of them the cam.
        """
        return self._worn_by_all(lambda model: model.own_lives)

    @fact
    def own_lives(self) -> dict[str, float]:
        """The same, with this follower alone on the cam."""
        from camgeom.mechanics.duty import least_lives

        return self._summed(lambda state: least_lives(state.carriers))

    @fact
    def square_lives(self) -> dict[str, float]:
        """The same of rollers that stand square to their flanks, whatever their tilt."""
        from camgeom.mechanics.duty import least_lives

        return self._summed(lambda state: least_lives(one.squared[1] if one.squared else one for one in state.carriers))

    @fact
    def dynamic_lives(self) -> dict[str, float]:
        """The lives under the forces that [dynamics] finds; empty where one state has none."""
        from camgeom.mechanics.duty import least_lives

        return self._worn_by_all(lambda one: one._summed(lambda state: least_lives(state.dynamic_duties)))

    @fact
    def lives_in_play(self) -> dict[str, float]:
        """The lives under the history of impacts, over all operating states."""
        return self._worn_by_all(lambda one: one._summed(lambda state: state.impact_lives))

    def _worn_by_all(self, lives_of: Callable[[Model], dict[str, float]]) -> dict[str, float]:
        """Lives, h, with that of the cam under all followers: at most as if one place were the hardest for all."""
        from camgeom.mechanics.life import summed_life

        own = lives_of(self)
        if self.state is not None or len(self.mates) == 1 or "cam" not in own:
            return own
        every = [lives_of(one) for one in self.mates]
        return {**own, "cam": summed_life((1.0, lives["cam"]) for lives in every if "cam" in lives)}

    @fact
    def camshaft(self) -> Shaft | None:
        """The torque of the shaft under all followers, of operating states the largest; None of one follower, without a
        load."""
        from camgeom.model.together import Shaft

        if len(self.bindings) > 1 and self._running:
            shafts = [shaft for one in self._running if (shaft := one.camshaft) is not None]
            return max(shafts, key=lambda shaft: shaft.peak_torque.value, default=None)
        each = [(one.angle, one.driven) for one in self.at_once if one.driven]
        return Shaft(tuple(each)) if len(each) > 1 else None

    @fact
    def apart(self) -> Extreme | None:
        """Least distance between the rollers of two followers over the turn, mm; None of one follower."""
        if len(self.bindings) < 2:
            return None
        from camgeom.model.together import least_apart

        return least_apart(self.bindings)

    @fact
    def apart_from_pivots(self) -> Extreme | None:
        """Least distance from a roller to the axis of another follower's arm over the turn, mm; None without both."""
        if len(self.bindings) < 2:
            return None
        from camgeom.model.together import least_to_pivot

        return least_to_pivot(self.bindings)

    def _summed(self, lives_of: Callable[[Model], dict[str, float]]) -> dict[str, float]:
        """Lives, h, of bodies by Miner's rule over the operating states; of bodies that have one in every state."""
        from camgeom.mechanics.life import summed_life

        if not self.profile.duty:
            return lives_of(self)
        each = [(one.state.weight, lives_of(one)) for one in self.states if one.state is not None]
        return {
            body: summed_life((weight, lives[body]) for weight, lives in each)
            for body in each[0][1]
            if all(body in lives for _, lives in each)
        }

    def with_(self, changes: Mapping[str, Any] | None = None, /, **keys: Any) -> Model:
        """Another model with other values in its profile, read and judged like a file.

            model.with_({"cam.diameter": 150, "motion[1].to": 40})
            model.with_(cam__diameter=150, operation__speed=300)

        Keys are dotted as in messages and in `camgeom study`; as a keyword two underscores stand for the dot. None
        takes a key away. Raises ProfileError with every problem found; the model itself stays as it is.
        """
        every = {**(changes or {}), **{key.replace("__", "."): value for key, value in keys.items()}}
        return Model(self.profile.with_(every))

    def toml(self) -> str:
        """The profile as TOML: what was stated, without comments; `camgeom.read` reads it back."""
        return self.profile.toml()

    def motion(self, theta: npt.ArrayLike | None = None) -> MotionArrays:
        """Position and derivatives per rad, arrays (n,), at cam angles theta (n,), rad; default 721 round a turn."""
        from camgeom.model import arrays

        return arrays.motion(self, theta)

    def pitch_curve(self, theta: npt.ArrayLike | None = None, track: int = 0) -> Floats:
        """Centre of the roller at the middle of its contact, (n, 3) mm in the cam frame, at cam angles theta (n,), rad.

        Of a planar cam this is its pitch curve. Raises DesignError for a follower without a roller.
        """
        from camgeom.model import arrays

        return arrays.pitch_curve(self, theta, track)

    def outline(self, theta: npt.ArrayLike | None = None, touch: int = 0) -> Floats:
        """The profile of a planar cam, (n, 2) mm in the cam frame: its points of contact at cam angles theta (n,), rad.

        `touch` numbers what touches the cam: a pair or a face groove has two. (`model.profile` is what the file says.)
        Raises DesignError for cams whose profile is no plane curve.
        """
        from camgeom.model import arrays

        return arrays.outline(self, theta, touch)

    def flank(
        self, side: float | None = None, theta: npt.ArrayLike | None = None, stations: int = 9, track: int = 0
    ) -> Flank:
        """A flank at cam angles theta (n,), rad, and stations along the roller's contact (m).

        side  +1 or -1 as `track.sides` has it; the first where none is named
        Of the result: `points` (n, m, 3) mm in the cam frame, `normals` (n, m, 3) from the roller into the cam,
        `pressure_angle()` (n, m) rad, `k_rel` (n, m) 1/mm (relative curvature). Raises DesignError without a roller.
        """
        from camgeom.model import arrays

        return arrays.flank(self, side, theta, stations, track)

    def plot(self, axes: Any = None) -> Any:
        """The motion drawn on four matplotlib axes (made where none are given), which are returned.

        Position mm (rad), velocity, acceleration and jerk over the cam angle, deg: per second where the profile has a
        speed, else per rad. Raises CamgeomError where matplotlib is not installed.
        """
        from camgeom.model import arrays

        return arrays.plot(self, axes)

    def __repr__(self) -> str:
        kind = f"{self.profile.kind} cam, {self.profile.follower.kind} follower"
        return f"<camgeom.Model {self.profile.name!r}: {kind}{''.join(f', {say(self)}' for say in TELLERS)}>"

    def _repr_html_(self) -> str | None:
        """How a notebook shows the model, where a layer above has entered how."""
        return next((draw(self) for draw in PAINTERS), None)

    @property
    def pressure_limit(self) -> float:
        """Largest contact pressure allowed, MPa: the profile's, else what the weaker material's fatigue line bears."""
        material = self.profile.material
        return self.profile.limits.contact_pressure_mpa or min(material.cam.rated_limit, material.roller.rated_limit)

    @property
    def driven(self) -> tuple[Duty, ...]:
        """The duties whose torques add up to the camshaft's: of all that touches a planar cam together, else those of
        all that presses the cam."""
        return (self.drive,) if self.drive is not None else self.carriers

    @property
    def peak_force(self) -> Extreme | None:
        """The largest force, N, that presses the cam anywhere; None without an [operation]."""
        return max((duty.peak_force for duty in self.driven), key=lambda force: force.value, default=None)

    @fact
    def shaft(self) -> Shaft | None:
        """The torque of the shaft under this follower alone; None without an [operation]."""
        from camgeom.model.together import Shaft

        return Shaft(((0.0, self.driven),)) if self.driven else None

    @property
    def contact(self) -> Contact | TurretDuty | FaceDuty:
        """Contact stress over the turn: of the hardest pressed roller, of a turret's rollers that share the load, or of
        the faces of a cam without a roller. Raises ProfileError where the profile has no [operation]."""
        if self.turret_duty is not None:
            return self.turret_duty
        return self.drive if self.drive is not None and not self.duties else self.duty.contact

    @property
    def life(self) -> RollerLife | TurretDuty:
        """Fatigue life of the hardest pressed roller, h; of a turret with its lives of roller, cam and bearing.

        Raises ProfileError where the profile has no [operation], DesignError for a follower without a roller.
        """
        if self.turret_duty is not None:
            return self.turret_duty
        if self.setup.roller is None:
            raise DesignError(f"a {self.setup.follower.kind} follower without a roller has no roller life")
        return self.duty.roller_life


def read(source: str | Path | Mapping[str, Any] | Readable, file: str = "") -> Model:
    """The model of a profile: the path of its file, its TOML text, plain data (dict) or an open file.

    A string of several lines or with a `=` is a text, any other a path. `file` is named in messages, and what a profile
    names (lift tables) is looked for beside it. Raises ProfileError with every problem found.
    """
    return Model(given(source, file))
