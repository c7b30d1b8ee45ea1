"""What a profile's [operation] puts on the follower, collected once, and the duty of what presses the cam under it."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from typing import TYPE_CHECKING

from camgeom.errors import Problem, ProfileError
from camgeom.mechanics.load import Load
from camgeom.solid.mechanism import Drive
from camgeom.track import Arc
from camgeom.track.follower import PLAIN

if TYPE_CHECKING:
    from camgeom.mechanics.duty import Duty
    from camgeom.mechanics.face_duty import FaceDuty
    from camgeom.mechanics.roller_duty import RollerDuty
    from camgeom.mechanics.turret_duty import TurretDuty
    from camgeom.profile import Profile
    from camgeom.profile.sections import Materials, Operation
    from camgeom.solid.mechanism import Mechanism, Turret
    from camgeom.track.follower import AnyRoller
    from camgeom.track.touch import Touch

DEGREES = 180.0 / pi


def operation_of(profile: Profile, purpose: str) -> Operation:
    """The [operation] section. Raises ProfileError where the profile has none, naming what it is wanted for."""
    if profile.operation is None:
        raise ProfileError([Problem("operation", f"missing: no speed or load to compute {purpose} from")])
    return profile.operation


def load_of(profile: Profile, mechanism: Mechanism, load_factor: float = 1.0) -> Load:
    """Inertia, friction, spring, weight and applied forces on the follower; N and mm, or N mm and rad.

    load_factor: by which an operating state multiplies the applied forces

    Every solver carries all of it, or refuses a key by name (`vibration`, `impact`); the rigid duties honour all that
    means something for their follower (see `Operation.idle`).
    """
    operation, follower = operation_of(profile, "a force"), mechanism.follower
    mass = follower.moving(operation.load_mass, operation.load_inertia)
    return Load(
        mechanism.program,
        operation.speed * 2.0 * pi / 60.0,
        mass,
        operation.friction,
        operation.spring_preload,
        operation.spring_rate * (DEGREES if follower.rotating else 1.0),
        0.0 if follower.rotating else mass * operation.gravity,
        tuple(replace(force.applied(), factor=load_factor) for force in operation.force),
        "rotating" if follower.rotating else "translating",
        operation.guide_friction,
    )


def roller_duties(material: Materials, mechanism: Mechanism, load: Load) -> tuple[RollerDuty, ...]:
    """Force, stress and life of every roller: of two that drive a follower to and fro each carries its own direction.

    On a flank that is straight along it a crowned roller touches with the crown's own arc, at its crest.
    """
    from camgeom.mechanics.roller_duty import RollerDuty

    quoted, rating = mechanism.quoted_radius, _rating(mechanism.roller)
    alone = mechanism.drive is Drive.ALONE and not mechanism.touches
    ends = mechanism.roller.ends if mechanism.roller is not None else PLAIN
    duties = []
    for track in mechanism.tracks:
        low, high = track.contact
        crown = None
        if mechanism.crown == "straight" and isinstance(track.meridian, Arc):
            crown, track = track.meridian.arc, mechanism.cutting(track)
        within = crown is None and quoted is not None and min(low, high) <= quoted <= max(low, high)
        station = track.meridian.parameter(quoted if quoted is not None and within else 0.5 * (low + high))
        duties.append(
            RollerDuty(track, station, high - low, load, material.roller, material.cam, crown, *rating,
                       mechanism.beside, mechanism.runs_out, alone, ends)
        )  # fmt: skip
    return tuple(duties)


def face_duty(material: Materials, load: Load, touches: tuple[Touch, ...]) -> FaceDuty:
    """Force and stress of what touches a planar cam."""
    from camgeom.mechanics.face_duty import FaceDuty

    return FaceDuty(touches, load, material.roller, material.cam)


def carriers(material: Materials, mechanism: Mechanism, load: Load) -> tuple[Duty, ...]:
    """The duties of all that presses a cam without a turret: its rollers, or the faces together."""
    if mechanism.roller is None:
        return (face_duty(material, load, mechanism.touches),)
    return roller_duties(material, mechanism, load)


def turret_duty(material: Materials, mechanism: Mechanism, turret: Turret, load: Load) -> TurretDuty:
    """Load sharing, stress and life of a turret's rollers."""
    from camgeom.mechanics.turret_duty import TurretDuty
    from camgeom.track.turret import Beside

    bore = mechanism.bore.diameter if mechanism.bore else 0.0
    return TurretDuty(
        Beside(turret.bearing, mechanism.inside), load, material.roller, material.cam, turret.preload, mechanism.width,
        bore, *_rating(mechanism.roller),
    )  # fmt: skip


def _rating(roller: AnyRoller | None) -> tuple[float | None, float | None]:
    """Dynamic and static rating of the roller's bearing, N."""
    return (roller.dynamic_rating, roller.static_rating) if roller is not None else (None, None)
