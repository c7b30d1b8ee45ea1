"""One design and every fact about it, each computed when first asked for, and once.

    model = camgeom.read("profiles/pin_insertion.toml")
    model.flanks, model.solid, model.duty.contact, model.duty.roller_life

There are no flags: what nobody asks for is not computed and what only it needs is not imported.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, final

from camgeom.errors import DesignError
from camgeom.model.facts import fact
from camgeom.model.shape import Shape
from camgeom.solid.mechanism import Drive

if TYPE_CHECKING:
    from camgeom.dynamics.follower.study import FollowerStudy
    from camgeom.dynamics.impact.run import ImpactRun
    from camgeom.dynamics.indexing.study import IndexingStudy
    from camgeom.machining.outcome import Outcome
    from camgeom.machining.plan import Machining
    from camgeom.mechanics.contact import Contact
    from camgeom.mechanics.duty import Duty
    from camgeom.mechanics.face_duty import FaceDuty
    from camgeom.mechanics.life import RollerLife
    from camgeom.mechanics.load import Load
    from camgeom.mechanics.roller_duty import RollerDuty
    from camgeom.mechanics.turret_duty import TurretDuty


@final
class Model(Shape):
    """A profile and its facts. Facts are attributes; `ledger.costs` says which were computed and what they cost."""

    @property
    def loaded(self) -> bool:
        """True where the profile has an [operation] and a roller follower that one roller at a time serves."""
        simple = self.mechanism.drive is not Drive.SHARED and self.setup.roller is not None
        return self.profile.operation is not None and bool(self.tracks) and simple

    @property
    def driven(self) -> bool:
        """True for a planar cam whose profile has an [operation]."""
        return self.profile.operation is not None and bool(self.mechanism.touches)

    @fact
    def load(self) -> Load:
        """What acts on the follower. Raises ProfileError where the profile has no [operation]."""
        from camgeom.model.loads import load_of

        return load_of(self.profile, self.mechanism)

    @fact
    def drive(self) -> FaceDuty:
        """Forces of a planar cam on its follower. Raises ProfileError where the profile has no [operation]."""
        from camgeom.model.loads import face_duty

        if self.planar is None:
            raise DesignError(f"a {self.profile.kind} cam has no planar outline to compute the force on")
        return face_duty(self.profile.material, self.load, self.planar.touches)

    @property
    def turret_loaded(self) -> bool:
        """True where the profile has an [operation] and a turret, whose rollers share the load."""
        return self.profile.operation is not None and self.mechanism.drive is Drive.SHARED

    @fact
    def turret_duty(self) -> TurretDuty:
        """Load sharing, stress and life of a turret. Raises ProfileError where the profile has no [operation]."""
        from camgeom.model.loads import turret_duty

        turret = self.mechanism.turret
        if turret is None:
            raise DesignError(f"a {self.profile.kind} cam has no turret")
        return turret_duty(self.profile.material, self.mechanism, turret, self.load)

    @fact
    def indexing(self) -> IndexingStudy | None:
        """The elastic indexing drive; None where the profile has no such [dynamics]."""
        from camgeom.model.vibration import indexing_of

        spec = self.profile.dynamics_spec
        return indexing_of(self) if spec is not None and spec.kind == "indexing" else None

    @fact
    def elastic_follower(self) -> FollowerStudy | None:
        """The elastic follower; None where the profile has no such [dynamics]."""
        from camgeom.model.vibration import elastic_follower_of

        spec = self.profile.dynamics_spec
        if spec is None or spec.kind != "follower":
            return None
        load = self.load if self.profile.operation is not None else None
        return elastic_follower_of(self.profile, self.mechanism, load)

    @fact
    def impact(self) -> ImpactRun | None:
        """The follower's motion in its clearance, solved; None where the profile has no [impact]."""
        from camgeom.model.impact import impact_of

        return impact_of(self.profile, self.mechanism, self.load) if self.profile.impact_spec is not None else None

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
        made = machining_of(self.profile.name, spec, self.mechanism)
        return Outcome(made, self.mechanism.inside)

    @property
    def classical(self) -> bool:
        """True for a loaded groove drum with a translating cylindrical roller: the case of the literature."""
        return self.loaded and self.mechanism.classical

    @fact
    def duties(self) -> tuple[RollerDuty, ...]:
        """The duty of every roller: of two that drive a follower to and fro each carries its own direction.

        Raises ProfileError where the profile has no [operation].
        """
        from camgeom.model.loads import roller_duties

        return roller_duties(self.profile.material, self.mechanism, self.load)

    @fact
    def duty(self) -> RollerDuty:
        """Force, contact stress, life and torque of the hardest pressed roller.

        Raises ProfileError where the profile has no [operation].
        """
        if len(self.duties) == 1:
            return self.duties[0]
        return max(self.duties, key=lambda duty: float(duty.contact.peak().pressure))

    @property
    def carrier(self) -> Duty | None:
        """The duty of what presses the cam: a turret's rollers together, the hardest pressed roller, or the faces.

        None where the profile has no [operation].
        """
        if self.turret_loaded:
            return self.turret_duty
        if self.loaded:
            return self.duty
        return self.drive if self.driven else None

    @property
    def contact(self) -> Contact | TurretDuty | FaceDuty:
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


def read(path: str) -> Model:
    """The model of a profile file. Raises ProfileError with every problem found."""
    from camgeom.profile import read as read_profile

    return Model(read_profile(path))
