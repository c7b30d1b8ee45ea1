"""Dynamics of a profile's own cam: indexing drive and elastic follower.

The door between the model's units (mm, N, MPa, rad) and the SI units of `camgeom.dynamics`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from camgeom.errors import Problem, ProfileError
from camgeom.solid.mechanism import Drive

if TYPE_CHECKING:
    from camgeom.dynamics.follower.study import FollowerStudy
    from camgeom.dynamics.follower.train import Closure
    from camgeom.dynamics.indexing.study import IndexingStudy
    from camgeom.dynamics.spec import DynamicsSpec
    from camgeom.mechanics.load import Load
    from camgeom.mechanics.turret_duty import TurretDuty
    from camgeom.profile import Profile
    from camgeom.solid import Solid
    from camgeom.solid.mechanism import Mechanism

MILLI = 1e-3
INDEXING_IGNORES = ("friction", "spring_rate", "spring_preload", "force")
"""keys of [operation] that the elastic indexing drive leaves out"""
FOLLOWER_IGNORES = ("friction", "guide_friction", "gravity", "force")
"""keys of [operation] that the elastic follower leaves out"""


class Indexer(Protocol):
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
    def turret(self) -> Solid | None: ...


def indexing_of(model: Indexer) -> IndexingStudy:
    """The indexing drive of a turret cam at the operating speed, with what [dynamics] leaves out from the model.

    Contact stiffness: Hertz line contact of the rollers that bear; inertias: bodies, follower and load. Leaves out
    INDEXING_IGNORES. Raises ProfileError for another follower and where nothing is left for the load plate.
    """
    from camgeom.dynamics.indexing.study import indexing_study

    spec = model.profile.dynamics_spec
    assert spec is not None
    if model.mechanism.turret is None:
        raise ProfileError([Problem("dynamics.kind", "an indexing drive needs a turret", spec.kind, "follower")])
    speed, sources = _speed(model.profile), dict[str, str]()
    table: tuple[float, ...] = ()
    if spec.contact_stiffness is None:
        assert model.turret_duty is not None, "there is a turret, and a speed"
        table = model.turret_duty.stiffness_table(spec.estimate)
        sources["contact_stiffness"] = f"Hertz line contact of the rollers under the turret's torque, {spec.estimate}"
    inertias = _inertias(model, model.mechanism.turret.follower.inertia, spec, sources)
    return indexing_study(spec, model.mechanism.program, speed, table, inertias, sources)


def _inertias(model: Indexer, own: float, spec: DynamicsSpec, sources: dict[str, str]) -> dict[str, float]:
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
        turret = own if moved > own else _turret_inertia(model)
        found["turret_inertia"] = turret
        sources["turret_inertia"] = "follower.inertia" if moved > own else "the turret's body"
    if spec.load_inertia is None:
        rest = moved - turret
        if rest <= 0.0 or turret <= 0.0:
            text = "nothing of follower.inertia and operation.load_inertia is left for it beside the turret"
            hint = f"the turret takes {turret:.6g} kg m2; give dynamics.turret_inertia and dynamics.load_inertia"
            raise ProfileError([Problem("dynamics.load_inertia", text, rest, "> 0 kg m2", hint)])
        found["load_inertia"] = rest
        sources["load_inertia"] = "follower.inertia and operation.load_inertia without the turret"
    return found


def _turret_inertia(model: Indexer) -> float:
    """Inertia, kg m2, of the turret's disc and rollers about the turret axis, of the roller's material."""
    from camgeom.maths.mesh import mass_properties
    from camgeom.track import Swing

    body = model.turret
    if body is None:
        raise ProfileError([Problem("dynamics.turret_inertia", "is missing", None, "> 0 kg m2")])
    _, mass, centre, inertia = mass_properties(body.mesh, model.profile.material.roller.density)
    joint = model.mechanism.tracks[0].joint
    assert isinstance(joint, Swing)
    axis, away = np.array(joint.axis), np.array(centre) - np.array(joint.centre)
    across = away - away @ axis * axis
    return float(axis @ np.array(inertia) @ axis + mass * MILLI**2 * (across @ across))


def elastic_follower_of(profile: Profile, mechanism: Mechanism, load: Load | None) -> FollowerStudy:
    """The elastic follower under the load at the operating speed; force-closed where a spring holds it on the cam.

    Leaves out FOLLOWER_IGNORES. Raises ProfileError for a turret, and without a load.
    """
    from camgeom.dynamics.follower.study import follower_study

    spec = profile.dynamics_spec
    assert spec is not None
    if mechanism.turret is not None:
        raise ProfileError([Problem("dynamics.kind", "a turret is an indexing drive", spec.kind, "indexing")])
    speed = _speed(profile)
    assert load is not None
    si = load.si
    closure: Closure = "force" if mechanism.drive is Drive.ALONE else "form"
    return follower_study(spec, mechanism.program, speed, load.rotating, closure, si.mass, si.rate, si.preload)


def _speed(profile: Profile) -> float:
    if profile.operation is None:
        raise ProfileError([Problem("operation.speed", "is missing", None, "r/min, for the dynamics")])
    return profile.operation.speed
