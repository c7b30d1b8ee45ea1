"""Dynamics of a profile's own cam: indexing drive and elastic follower, and the duty of the cam under what they find.

The door between the model's units (mm, N, MPa, rad) and the SI units of `camgeom.dynamics`. Both solvers carry the
whole [operation]: Coulomb friction has the sign of the ideal motion, applied forces are taken along it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import inf
from typing import TYPE_CHECKING, Any, Literal, Protocol, TypeVar, final

import numpy as np

from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats, among
from camgeom.maths.extremum import Extreme, hardest
from camgeom.maths.frozen import cached_property
from camgeom.maths.panels import TURN, panels
from camgeom.mechanics.duty import largest_of
from camgeom.mechanics.load import QUIET
from camgeom.model.loads import carriers, ratings_of, roller_duties
from camgeom.profile.solvers import refuse
from camgeom.solid.mechanism import Drive

if TYPE_CHECKING:
    from camgeom.body.compliance import Below
    from camgeom.dynamics.follower.study import FollowerStudy
    from camgeom.dynamics.follower.train import Closure, FollowerResponse
    from camgeom.dynamics.indexing.study import IndexingStudy
    from camgeom.dynamics.indexing.system import DriveResponse
    from camgeom.dynamics.linear.method import DrivenMotion, Side
    from camgeom.dynamics.spec import DynamicsSpec
    from camgeom.mechanics.duty import Duty
    from camgeom.mechanics.load import Load
    from camgeom.mechanics.turret_duty import TurretDuty
    from camgeom.model import Model
    from camgeom.model.body import Body
    from camgeom.profile import Profile
    from camgeom.solid.mechanism import Mechanism

MILLI = 1e-3
MOST_BESIDE = 20_000
"""panels of a solved torque times rollers beside the cam: some 6 s and 0.6 GB"""
INSIDE = 1e-12
"""rad from the end of a piece at which its own limit is taken"""


@final
@immutable
class Resistance:
    """What acts on a follower against larger lift beside inertia and spring, along its ideal motion; N (N m)."""

    load: Load

    @property
    def jumps(self) -> bool:
        """Whether some of it may jump or kink on the way round."""
        return bool(self.load.applied) or self.load.si.friction > 0.0

    @cached_property
    def edges(self) -> Floats:
        """Cam angles, rad, between which it is smooth: knots, ends of forces, changes of direction."""
        return panels(self.load.breaks()).breaks

    @cached_property
    def _way(self) -> Floats:
        """Sign of the motion between two edges, 0 in a dwell."""
        slope = np.asarray(self.load.motion.jet(0.5 * (self.edges[1:] + self.edges[:-1]), 1)[1])
        return np.where(np.abs(slope) > QUIET * np.abs(slope).max(initial=0.0), np.sign(slope), 0.0)

    def friction(self, theta: Floats, side: Side) -> Floats:
        """Coulomb friction, against the ideal motion."""
        return np.asarray(self.load.si.friction * self._way[self._placed(theta, side)[0]])

    def applied(self, theta: Floats, side: Side) -> Floats:
        """Applied forces and weight; those that hang on lift, velocity or acceleration take the ideal ones."""
        if not self.load.applied:
            return np.full(theta.shape, self.load.si.weight)
        piece, angle = self._placed(theta, side)
        edges = self.edges
        angle = np.clip(angle, edges[piece] + INSIDE, edges[piece + 1] - INSIDE)
        omega, unit = self.load.omega, MILLI if self.load.rotating else 1.0
        s, v, a = self.load.motion.jet(angle.ravel(), 2)[:3].reshape(3, *angle.shape)
        total = sum((force(angle, s, omega * v, omega**2 * a) for force in self.load.applied), np.zeros(angle.shape))
        return np.asarray(unit * total + self.load.si.weight)

    def __call__(self, theta: Floats, side: Side) -> Floats:
        """All of it."""
        return self.friction(theta, side) + self.applied(theta, side)

    def torques(self, theta: Floats, side: Side) -> Floats:
        """On cam, turret and load of an indexing drive: friction on the turret, what is applied on the load plate."""
        return np.stack([np.zeros(theta.shape), -self.friction(theta, side), -self.applied(theta, side)], -1)

    def _placed(self, theta: Floats, side: Side) -> tuple[Any, Floats]:
        """The piece that each cam angle belongs to from a side, and the angle within the turn."""
        inside = (theta >= 0.0) & (theta <= TURN)
        angle = np.where(inside, theta, np.mod(theta, TURN))
        piece = np.searchsorted(self.edges, angle, "left" if side == "left" else "right") - 1
        return np.clip(piece, 0, len(self.edges) - 2), angle


@final
@immutable
class Broken:
    """A motion with further knots, where a force on the follower jumps."""

    motion: DrivenMotion
    knots: Floats

    def jet(self, theta: Floats, order: int = 3, side: Side = "right") -> Floats:
        """As the motion's."""
        return self.motion.jet(theta, order, side)


class IndexerInputs(Protocol):
    """What an indexing drive takes from a model."""

    @property
    def profile(self) -> Profile: ...
    @property
    def mechanism(self) -> Mechanism: ...
    @property
    def load(self) -> Load: ...
    @property
    def turret_duty(self) -> TurretDuty | None: ...
    @property
    def mass(self) -> tuple[Any, ...]: ...
    @property
    def body(self) -> Body: ...
    @property
    def below(self) -> Below | None: ...


Study = TypeVar("Study", "FollowerStudy", "IndexingStudy")


def one_of(model: Model, made: Callable[[], Study]) -> Study:
    """A study beside those of other followers and operating states that differ, which have time and memory in common.
    Raises NotConverged where they are too many."""
    from camgeom.model.price import VIBRATION, afford, limit

    afford(model.body, VIBRATION)
    return _sharing(made(), len(model.runs), limit(model, "vibration"), limit(model, "sweep"))


def _sharing(study: Study, runs: int, together: float, sweep: float) -> Study:
    rigid = None if study.rigid is None else _sharing(study.rigid, runs, together, sweep)
    return replace(study, accuracy=replace(study.accuracy, runs=runs, together=together, sweep=sweep), rigid=rigid)


def indexing_of(model: IndexerInputs) -> IndexingStudy:
    """The indexing drive of a turret cam at the operating speed, with what [dynamics] leaves out from the model.

    Contact stiffness: Hertz line contact of the rollers that bear; inertias: bodies, follower and load. Friction acts
    on the turret, applied torques on the load plate. Raises ProfileError for what the solver cannot do
    (`profile.solvers`), DesignError where the turret's body is all that moves.
    """
    from camgeom.dynamics.indexing.study import indexing_study

    spec = model.profile.dynamics_spec
    assert spec is not None
    refuse(model.profile, model.mechanism)
    assert model.mechanism.turret is not None
    assert model.profile.operation is not None
    speed, sources = model.profile.operation.speed, dict[str, str]()
    table: tuple[float, ...] = ()
    if spec.contact_stiffness is None:
        assert model.turret_duty is not None, "there is a turret, and a speed"
        table = model.turret_duty.stiffness_table(spec.estimate)
        which = {"half-space": "half-space tangent", "secant": "half-space secant", "chord": "chord secant"}
        source = f"Hertz line contact of the rollers under the turret's torque, {which[spec.estimate]}"
        sources["contact_stiffness"] = source
    inertias = _inertias(model, model.mechanism.turret.follower.inertia, spec, sources)
    against, program = Resistance(model.load), model.mechanism.program
    motion, acting = (Broken(program, against.edges), against.torques) if against.jumps else (program, None)
    rigid = indexing_study(spec, motion, speed, table, inertias, sources, acting)
    if model.below is None:
        return rigid
    # What the contact moves is its share of the whole way, and so is the work of its damper.
    left = model.below.at(np.linspace(0.0, TURN, len(table), endpoint=False))
    soft = spec.model_copy(update={"contact_damping": float(np.mean(left)) ** 2 * spec.contact_damping})
    sources = sources | {"contact_stiffness": f"{sources['contact_stiffness']}, and the body below"}
    table = tuple((left * np.array(table)).tolist())
    return replace(indexing_study(soft, motion, speed, table, inertias, sources, acting), rigid=rigid)


def _inertias(model: IndexerInputs, own: float, spec: DynamicsSpec, sources: dict[str, str]) -> dict[str, float]:
    """Inertias, kg m2, that the profile's [dynamics] does not give; where each comes from goes into sources.

    own: follower.inertia, of the turret or, without a load of its own, of the turret with its load.
    """
    found: dict[str, float] = {}
    moved = model.load.si.mass
    if spec.cam_inertia is None:
        found["cam_inertia"] = sum(
            m.inertia[2][2] + m.mass * MILLI**2 * (m.centroid[0] ** 2 + m.centroid[1] ** 2) for m in model.mass
        )
        sources["cam_inertia"] = "the cam's body"
    turret = spec.turret_inertia
    if turret is None:
        if spec.load_inertia is not None and moved > spec.load_inertia:
            turret, source = moved - spec.load_inertia, "follower.inertia and operation.load_inertia without the load"
        elif moved > own:
            turret, source = own, "follower.inertia"
        else:
            turret, source = _turret_inertia(model), "the turret's body"
        found["turret_inertia"], sources["turret_inertia"] = turret, source
    if spec.load_inertia is None:
        rest = moved - turret
        if rest <= 0.0 or turret <= 0.0:
            raise DesignError(
                f"the turret's body has {turret:.6g} kg m2 and leaves nothing for the load plate of the {moved:.6g} kg "
                "m2 of follower.inertia and operation.load_inertia: give dynamics.turret_inertia and "
                "dynamics.load_inertia"
            )
        found["load_inertia"] = rest
        sources["load_inertia"] = "follower.inertia and operation.load_inertia without the turret"
    return found


def _turret_inertia(model: IndexerInputs) -> float:
    """Inertia, kg m2, of the turret's disc and rollers about the turret axis, of the roller's material."""
    moment = model.body.turret_moment
    if moment is None:
        raise DesignError("dynamics.turret_inertia is missing, and the turret has no body to weigh: give it, kg m2")
    return model.profile.material.roller.density * moment


def elastic_follower_of(
    profile: Profile, mechanism: Mechanism, load: Load, below: Below | None = None
) -> FollowerStudy:
    """The elastic follower under the load at the operating speed; force-closed where a spring holds it on the cam.

    below  what the cam's body gives way below the contact

    Friction, weight and applied forces act on the mass beyond the linkage. The guides lead the cam's end of it: their
    friction is that of a tappet which follows the cam, so it needs a rigid contact and cam shaft. Raises ProfileError
    for what the solver cannot do (`profile.solvers`).
    """
    from camgeom.dynamics.follower.study import follower_study

    spec = profile.dynamics_spec
    assert spec is not None
    refuse(profile, mechanism)
    assert profile.operation is not None, "it made the load"
    if spec.tappet_contact is not None:
        spec = spec.model_copy(update={"tappet_stiffness": tappet_stiffness(profile, mechanism, load)})
    si = load.si
    closure: Closure = "force" if mechanism.drive is Drive.ALONE else "form"
    against, motion = Resistance(load), mechanism.program
    acting = against if against.jumps or si.weight else None
    speed, wanted = profile.operation.speed, Broken(motion, against.edges) if against.jumps else motion

    def study(spec: DynamicsSpec) -> FollowerStudy:
        return follower_study(spec, wanted, speed, load.rotating, closure, si.mass, si.rate, si.preload, acting,
                              mechanism.carriage is not None)  # fmt: skip

    if below is None:
        return study(spec)
    soft, angle = softest(below, profile, mechanism, load)
    return replace(study(_yielding(spec, soft)), rigid=study(spec), body=(soft, angle))


def softest(below: Below, profile: Profile, mechanism: Mechanism, load: Load) -> tuple[float, float]:
    """Largest compliance, mm/N (rad/(N m)), of the body along the follower's motion, and its cam angle, rad."""
    duty = max(roller_duties(profile.material, mechanism, load), key=lambda one: one.least_peak.value)
    lever = duty.force.panels.at(duty.pressing.reference.lever, below.theta)
    along = below.value / lever**2 / (MILLI if load.rotating else 1.0)
    worst = int(np.argmax(along))
    return float(along[worst]), float(below.theta[worst])


def _yielding(spec: DynamicsSpec, soft: float) -> DynamicsSpec:
    """The spec with the body's compliance, mm/N (rad/(N m)), in series with the contact, or the linkage.

    A body that is stiffer than the half-space of the contact's formula stiffens that contact, and no linkage. What a
    spring moves is its share of the whole way, and so is the work of its damper. Raises DesignError where nothing of
    the contact is left.
    """
    name = "linkage" if spec.tappet_contact is None else "tappet"
    stiff = spec.linkage_stiffness if spec.tappet_contact is None else spec.tappet_stiffness
    assert stiff is not None, "kind = 'follower' needs it"
    left = 1.0 + stiff * (max(soft, 0.0) if spec.tappet_contact is None else soft)
    if left <= 0.0:
        raise DesignError("the body below the contact is stiffer than the whole of the contact: the meshes of this "
                          "body are too coarse for dynamics.body_compliance")  # fmt: skip
    damping = spec.linkage_damping if spec.tappet_contact is None else spec.tappet_damping
    return spec.model_copy(update={f"{name}_stiffness": stiff / left, f"{name}_damping": damping / left**2})


@final
class KnownForce:
    """A force over cam angles (n,), rad, that costs steps of a solver: where it is known it is not solved again."""

    def __init__(self, force: Callable[[Floats], Floats]) -> None:
        self._force = force
        self._known = np.zeros(0), np.zeros(0)

    def __call__(self, theta: Floats) -> Floats:
        """The force, N (N mm), (n,)."""
        angles, values = self._known
        index, there = among(angles, theta)
        if not there.all():
            angles = np.concatenate([angles, theta[~there]])
            values = np.concatenate([values, self._force(theta[~there])])
            order = np.argsort(angles)
            self._known = angles, values = angles[order], values[order]
            index, _ = among(angles, theta)
        return np.asarray(values[index])


def tappet_stiffness(profile: Profile, mechanism: Mechanism, load: Load) -> float:
    """Stiffness, N/mm (N m/rad), along the follower's motion of its roller's contact where that is pressed hardest.

    By the rigid load: tangent or secant, as dynamics.tappet_contact says. Raises DesignError where that presses
    nothing, or an edge.
    """
    spec = profile.dynamics_spec
    assert spec is not None
    duty = max(roller_duties(profile.material, mechanism, load), key=lambda one: one.least_peak.value)
    if not 0.0 < duty.least_peak.value < inf:
        why = "presses an edge" if duty.least_peak.value else "presses nothing"
        raise DesignError(f"the rigid load {why}, which has no stiffness for dynamics.tappet_contact: give "
                          "dynamics.tappet_stiffness instead")
    at = duty.least_peak.cam_angle
    lever = float(duty.force.panels.limit(duty.pressing.reference.lever, at, duty.hardest_pressure))
    each = duty.stiffness.tangent if spec.tappet_contact == "tangent" else duty.stiffness.secant
    return each * lever**2 * (MILLI if load.rotating else 1.0)


class Vibrating(IndexerInputs, Protocol):
    """What the duty of a cam under solved forces takes from a model."""

    @property
    def indexing(self) -> IndexingStudy | None: ...
    @property
    def elastic_follower(self) -> FollowerStudy | None: ...


Turn = Literal["steady", "start"]
"""A turn that is solved: of the periodic steady state, or the first one from rest."""
TURNS: dict[Turn, str] = {"steady": "with vibration", "start": "starting from rest"}


def solved_turn(model: Vibrating, turn: Turn) -> DriveResponse | FollowerResponse | None:
    """The response in a turn; None without [dynamics]."""
    study = model.indexing or model.elastic_follower
    if study is None:
        return None
    return study.steady if turn == "steady" else study.start


def starts_at_rest(model: Vibrating) -> bool:
    """Whether the motion stands still where the turn begins, so that a machine can start there."""
    motion = model.mechanism.program
    slope = np.abs(np.asarray(motion.jet(np.linspace(0.0, TURN, 721), 1)[1]))
    return bool(slope[0] <= QUIET * slope.max(initial=0.0))


def dynamic_duties_of(model: Vibrating, turn: Turn) -> tuple[Duty, ...]:
    """The duties of what presses the cam under the solved contact force of a turn, by the code of the rigid ones.

    None without [dynamics], and where the follower leaves its cam: the force of its landings is not solved. Raises
    NotConverged where the force swings too often to be sampled.
    """
    material, mechanism = model.profile.material, model.mechanism
    found = solved_turn(model, turn)
    if found is None:
        return ()
    if mechanism.turret is not None:
        # The contact torque holds the turret back where it is positive.
        load = replace(model.load, solved=KnownForce(partial(_told, found, "contact_torque", -1.0 / MILLI)))
        duty = model.turret_duty
        assert duty is not None, "there is a turret, and a speed"
        load = replace(load, solved_on=load.panels(most=MOST_BESIDE // len(duty.engagement.places)))
        return (replace(duty, load=load),)
    if least_contact(model, turn) is not None and bool(found.peak("contact_force").minimum[0] < 0.0):
        return ()
    unit = 1.0 / MILLI if model.load.rotating else 1.0
    load = replace(model.load, solved=KnownForce(partial(_told, found, "contact_force", unit)))
    return carriers(material, mechanism, replace(load, solved_on=load.panels()), ratings_of(model.profile))


def _told(response: DriveResponse | FollowerResponse, name: str, unit: float, theta: Floats) -> Floats:
    """A quantity of a response at cam angles (n,), rad, in another unit; no closure, so that a model can be pickled."""
    return np.asarray(unit * response.at(theta, name)[0])


def least_contact(model: Vibrating, turn: Turn) -> Extreme | None:
    """Least contact force, N (N m), in a turn of an elastic follower that a spring or weight holds; None of others."""
    follower, found = model.elastic_follower, solved_turn(model, turn)
    if follower is None or found is None or follower.train.closure != "force":
        return None
    peak = found.peak("contact_force")
    return Extreme(float(peak.minimum[0]), float(peak.minimum_at[0]))


def dynamic_torque_of(model: Vibrating, duties: tuple[Duty, ...], turn: Turn) -> Extreme:
    """Largest torque, N mm, that a turn makes in the camshaft: at the cam, or in the shaft where that is elastic."""
    at_cam = hardest(duty.peak_torque for duty in duties)
    found = [Extreme(at_cam.value, at_cam.cam_angle, where="at the cam")]
    response, name = solved_turn(model, turn), "input_torque" if model.indexing is not None else "shaft_torque"
    if response is not None and name in response.system.outputs:
        peak = response.peak(name)
        found.append(Extreme(float(peak.magnitude[0]) / MILLI, float(peak.magnitude_at[0]), where="in the shaft"))
    return hardest(found)


def output_torque_of(model: Vibrating) -> Extreme | None:
    """Largest torque, N mm, of a turret's output shaft: with vibration, or starting from rest where that is more.

    Without [dynamics] the rigid one of all that turns with it. None without a turret or a load.
    """
    if model.turret_duty is None:
        return None
    if model.indexing is None:
        force = model.turret_duty.force
        peak = largest_of(force.panels, force.force)
        return Extreme(peak.value, peak.cam_angle, where="rigid, with the turret's own inertia")
    turns: tuple[Turn, ...] = ("steady", "start") if starts_at_rest(model) else ("steady",)
    peaks = [(turn, solved_turn(model, turn)) for turn in turns]
    each = [(turn, one.peak("output_torque")) for turn, one in peaks if one is not None]
    return hardest(
        Extreme(float(peak.magnitude[0]) / MILLI, float(peak.magnitude_at[0]), where=TURNS[turn])
        for turn, peak in each
    )  # fmt: skip
