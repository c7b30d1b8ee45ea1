"""Dynamics of a profile's own cam: indexing drive, elastic follower, and impacts in the follower's clearance.

The door between the model's units (mm, N, MPa, rad) and the SI units of `camgeom.dynamics`.
"""

from __future__ import annotations

from dataclasses import replace
from math import radians
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

from camgeom.errors import Problem, ProfileError
from camgeom.mechanics.material import pair_compliance
from camgeom.track.follower import FrameFollower, Setup, SwingingFollower, TranslatingFollower, TurretFollower

if TYPE_CHECKING:
    from camgeom.dynamics.follower.study import FollowerStudy
    from camgeom.dynamics.impact.problem import ImpactProblem
    from camgeom.dynamics.impact.problem import Load as ImpactLoad
    from camgeom.dynamics.impact.run import ImpactRun
    from camgeom.dynamics.impact.side import Pair
    from camgeom.dynamics.indexing.study import IndexingStudy
    from camgeom.dynamics.spec import DynamicsSpec
    from camgeom.mechanics.turret_duty import TurretDuty
    from camgeom.profile import Profile
    from camgeom.solid.drum import Solid
    from camgeom.track import Track

MILLI = 1e-3


class Drive(Protocol):
    """What an indexing drive takes from a model."""

    @property
    def profile(self) -> Profile: ...
    @property
    def setup(self) -> Setup: ...
    @property
    def turret_duty(self) -> TurretDuty: ...
    @property
    def mass(self) -> tuple[Any, ...]: ...
    @property
    def turret(self) -> Solid | None: ...


def indexing_of(model: Drive) -> IndexingStudy:
    """The indexing drive of a turret cam at the operating speed, with what [dynamics] leaves out from the model.

    Contact stiffness: Hertz line contact of the rollers that bear; inertias: bodies, follower and load. Raises
    ProfileError for another follower and where nothing is left for the load plate.
    """
    from camgeom.dynamics.indexing.study import indexing_study

    spec = model.profile.dynamics_spec
    assert spec is not None
    if not isinstance(model.setup.follower, TurretFollower):
        raise ProfileError([Problem("dynamics.kind", "an indexing drive needs a turret", spec.kind, "follower")])
    speed, sources = _speed(model.profile), dict[str, str]()
    table: tuple[float, ...] = ()
    if spec.contact_stiffness is None:
        from camgeom.mechanics.turret_stiffness import contact_table

        table = contact_table(model.turret_duty, spec.estimate)
        sources["contact_stiffness"] = f"Hertz line contact of the rollers under the turret's torque, {spec.estimate}"
    inertias = _inertias(model, spec, sources)
    return indexing_study(spec, model.setup.program, speed, table, inertias, sources)


def _inertias(model: Drive, spec: DynamicsSpec, sources: dict[str, str]) -> dict[str, float]:
    """Inertias, kg m2, that the profile's [dynamics] does not give; where each comes from goes into sources."""
    found: dict[str, float] = {}
    follower, operation = model.setup.follower, model.profile.operation
    assert isinstance(follower, TurretFollower)
    if spec.cam_inertia is None:
        found["cam_inertia"] = sum(
            m.inertia[2][2] + m.mass * MILLI**2 * (m.centroid[0] ** 2 + m.centroid[1] ** 2) for m in model.mass
        )
        sources["cam_inertia"] = "the cam's body"
    load = operation.load_inertia if operation is not None else 0.0
    turret = spec.turret_inertia
    if turret is None:
        turret = follower.inertia if load > 0.0 else _turret_inertia(model)
        found["turret_inertia"] = turret
        sources["turret_inertia"] = "follower.inertia" if load > 0.0 else "the turret's body"
    if spec.load_inertia is None:
        rest = follower.inertia + load - turret
        if rest <= 0.0 or turret <= 0.0:
            text = "nothing of follower.inertia and operation.load_inertia is left for it beside the turret"
            hint = f"the turret takes {turret:.6g} kg m2; give dynamics.turret_inertia and dynamics.load_inertia"
            raise ProfileError([Problem("dynamics.load_inertia", text, rest, "> 0 kg m2", hint)])
        found["load_inertia"] = rest
        sources["load_inertia"] = "follower.inertia and operation.load_inertia without the turret"
    return found


def _turret_inertia(model: Drive) -> float:
    """Inertia, kg m2, of the turret's disc and rollers about the turret axis, of the roller's material."""
    from camgeom.maths.massprops import mass_properties
    from camgeom.track import Swing

    body = model.turret
    if body is None:
        raise ProfileError([Problem("dynamics.turret_inertia", "is missing", None, "> 0 kg m2")])
    _, mass, centre, inertia = mass_properties(body.mesh, model.profile.material.roller.density)
    joint = model.turret_duty.tracks[0].joint
    assert isinstance(joint, Swing)
    axis, away = np.array(joint.axis), np.array(centre) - np.array(joint.centre)
    across = away - away @ axis * axis
    return float(axis @ np.array(inertia) @ axis + mass * MILLI**2 * (across @ across))


def elastic_follower_of(profile: Profile, setup: Setup, one_sided: bool) -> FollowerStudy:
    """The elastic follower at the operating speed; force-closed where the cam has one flank (`one_sided`)."""
    from camgeom.dynamics.follower.study import follower_study

    spec, operation, follower = profile.dynamics_spec, profile.operation, setup.follower
    assert spec is not None
    if isinstance(follower, TurretFollower):
        raise ProfileError([Problem("dynamics.kind", "a turret is an indexing drive", spec.kind, "indexing")])
    speed = _speed(profile)
    assert operation is not None
    rotating = isinstance(follower, SwingingFollower)
    # [operation] holds N/mm and N for a slide, N mm/deg and N mm for an arm.
    stiffness = operation.spring_rate * (MILLI / radians(1.0) if rotating else 1.0 / MILLI)
    preload = operation.spring_preload * (MILLI if rotating else 1.0)
    closure: Any = "force" if one_sided else "form"
    return follower_study(
        spec, setup.program, speed, rotating, closure, _inertia(profile, setup), stiffness, preload
    )


def impact_of(profile: Profile, setup: Setup, tracks: tuple[Track, ...]) -> ImpactRun:
    """The follower's motion with free play between its two contacts, over the turns the profile asks for.

    Raises ProfileError where the cam does not drive both ways or has no play.
    """
    from camgeom.dynamics.impact.run import solve

    spec = profile.impact_spec
    assert spec is not None
    return solve(impact_problem(profile, setup, tracks), turns=spec.turns, rtol=spec.tolerance)


def impact_problem(profile: Profile, setup: Setup, tracks: tuple[Track, ...]) -> ImpactProblem:
    """The contact problem of the profile's cam in SI units; raises as `impact_of`."""
    spec = profile.impact_spec
    assert spec is not None
    cam, roller = profile.cam, setup.roller
    radius = 0.5 * roller.diameter if roller is not None else float("inf")
    length = (roller.length if roller is not None else None) or getattr(cam, "width", None) or 1.0
    base = getattr(cam, "base_radius", None) or getattr(cam, "radius", None) or radius
    pair, load = impact_pair(profile, setup, tracks), impact_load(profile, setup)
    if load.applied is not None and load.applied.jumps:
        pair = replace(pair, lift=pair.lift.split(load.applied.jumps))  # type: ignore[type-var]
    return spec.problem(
        pair,
        inertia=_inertia(profile, setup),
        speed_rpm=_speed(profile),
        modulus_mpa=1.0 / pair_compliance(profile.material.roller, profile.material.cam),
        length_mm=float(length),
        roller_radius_mm=radius,
        cam_radius_mm=float(base),
        load=load,
    )


def impact_laws(profile: Profile) -> dict[str, ImpactProblem]:
    """The contact problem for every law that [impact] compares, put in place of those of all moving segments.

    Each cam is made anew, so its levers and curvatures are those of its own motion. Raises as `impact_of`.
    """
    spec = profile.impact_spec
    assert spec is not None
    found = {}
    for law in spec.laws:
        motion = tuple(
            segment if segment.to is None else segment.model_copy(update={"law": law, "parameters": ()})
            for segment in profile.motion
        )
        other = profile.model_copy(update={"motion": motion})
        setup = other.setup()
        cam: Any = other.cam
        if problems := cam.problems(setup):
            raise ProfileError(problems, profile.source)
        found[law] = impact_problem(other, setup, tuple(cam.tracks(setup)))
    return found


def impact_load(profile: Profile, setup: Setup) -> ImpactLoad:
    """What [operation] puts on the follower beside its inertia: spring, friction, weight, applied forces; SI.

    Applied forces are taken over the cam angle along the ideal motion. Friction is reached at a hundredth of the
    motion's peak speed.
    """
    from camgeom.dynamics.impact.force import ForceTable
    from camgeom.dynamics.impact.problem import Load
    from camgeom.model.loads import follower_load

    load, program = follower_load(profile, setup), setup.program
    rotating = load.kind == "rotating"
    unit, length = (MILLI, 1.0) if rotating else (1.0, MILLI)
    applied = None
    if load.applied:
        omega = float(load.speed)  # type: ignore[arg-type]

        def force(theta: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
            s, v, a = program.jet(theta, 2)
            return np.asarray(unit * sum(one(theta, s, omega * v, omega**2 * a) for one in load.applied))

        applied = ForceTable.of(force, [*program.knots, *(b for one in load.applied for b in one.breaks)])
    spring, friction, weight, rate = (float(v) for v in (load.preload, load.friction, load.weight, load.rate))  # type: ignore[arg-type]
    fastest = length * abs(program.peak(1).value) * float(load.speed)  # type: ignore[arg-type]
    return Load(-unit * (spring + weight), unit * rate / length, unit * friction, 0.01 * fastest or 1e-3, applied)


def impact_pair(profile: Profile, setup: Setup, tracks: tuple[Track, ...]) -> Pair:
    """The two opposing contacts of the profile's cam, in m and rad. Raises ProfileError where it has none."""
    from camgeom.dynamics.impact.flank import groove_pair
    from camgeom.dynamics.impact.frame import FramePair
    from camgeom.dynamics.impact.lift import Lift
    from camgeom.dynamics.impact.pairs import RockerPair, SlidePair

    spec, cam, follower = profile.impact_spec, profile.cam, setup.follower
    assert spec is not None
    cut = 2.0 * getattr(cam, "running_clearance", 0.0)
    play = MILLI * (spec.clearance or getattr(follower, "clearance", 0.0) or cut)
    if play <= 0.0:
        raise ProfileError([Problem("impact.clearance", "is missing", None, "a length in mm above 0")])
    kind = profile.kind
    if kind == "conjugate" and isinstance(follower, SwingingFollower) and setup.roller is not None:
        if (follower.side == "left") != (getattr(cam, "sense", 1.0) > 0.0):
            message = "the contact solver knows rockers whose main roller meets the cam from ahead of the pivot"
            allowed = "left with direction = ccw, or right with cw"
            raise ProfileError([Problem("follower.side", message, follower.side, allowed)])
        return RockerPair(
            Lift.from_program(setup.program, 1.0),
            MILLI * float(getattr(cam, "center_distance", 0.0)),
            MILLI * follower.arm,
            MILLI * float(getattr(cam, "return_arm", None) or follower.arm),
            MILLI * 0.5 * setup.roller.diameter,
            MILLI * float(getattr(cam, "base_radius", 0.0)),
            play,
            spec.clearance_kind,
            cam.angle_between(setup) if hasattr(cam, "angle_between") else None,
        )
    if kind == "conjugate" and isinstance(follower, TranslatingFollower) and setup.roller is not None:
        return SlidePair(
            Lift.from_program(setup.program, MILLI),
            MILLI * float(getattr(cam, "base_radius", 0.0)),
            MILLI * cam.slide_return_radius(setup) if hasattr(cam, "slide_return_radius") else 0.0,
            MILLI * 0.5 * setup.roller.diameter,
            play,
            spec.clearance_kind,
            # seen from behind, a cam that turns clockwise turns the other way and the offset changes its side
            MILLI * follower.offset * getattr(cam, "sense", 1.0),
        )
    if kind == "constant-width" and isinstance(follower, FrameFollower):
        return FramePair(Lift.from_program(setup.program, MILLI), MILLI * float(getattr(cam, "base_radius", 0.0)), play)
    if len(tracks) == 1 and len(tracks[0].sides) == 2 and hasattr(cam, "quoted_radius"):
        return groove_pair(tracks[0], play, cam.quoted_radius(setup))
    allowed = "a groove, a conjugate pair with a rocker, or a constant-width cam with a frame"
    raise ProfileError([Problem("impact", "this cam does not drive its follower both ways", kind, allowed)])


def _speed(profile: Profile) -> float:
    if profile.operation is None:
        raise ProfileError([Problem("operation.speed", "is missing", None, "r/min, for the dynamics")])
    return profile.operation.speed


def _inertia(profile: Profile, setup: Setup) -> float:
    """Moving mass, kg, or inertia, kg m2."""
    follower, operation = setup.follower, profile.operation
    if isinstance(follower, TranslatingFollower | FrameFollower):
        return follower.mass + (operation.load_mass if operation else 0.0)
    assert isinstance(follower, SwingingFollower | TurretFollower)
    return follower.inertia + (operation.load_inertia if operation else 0.0)
