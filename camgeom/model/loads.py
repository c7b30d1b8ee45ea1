"""What a profile's [operation] puts on the follower, collected once, and the duty of what presses the cam under it."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from typing import TYPE_CHECKING

from camgeom.errors import Problem, ProfileError
from camgeom.mechanics.load import Load
from camgeom.profile.idle import MODIFIED
from camgeom.solid.mechanism import Drive
from camgeom.track import Arc

if TYPE_CHECKING:
    from collections.abc import Sequence

    from camgeom.mechanics.duty import Duty
    from camgeom.mechanics.face_duty import FaceDuty
    from camgeom.mechanics.rating import Rating
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
    program, omega = mechanism.program, operation.speed * 2.0 * pi / 60.0
    applied = (force.applied().followed(program, omega) for force in operation.force)
    mass = follower.moving(operation.load_mass, operation.load_inertia)
    return Load(
        program,
        omega,
        mass,
        operation.friction,
        operation.spring_preload,
        operation.spring_rate * (DEGREES if follower.rotating else 1.0),
        0.0 if follower.rotating else mass * operation.gravity,
        tuple(replace(force, factor=load_factor) for force in applied),
        "rotating" if follower.rotating else "translating",
        operation.guide_friction,
    )


def roller_duties(
    material: Materials, mechanism: Mechanism, load: Load, ratings: Sequence[Rating | None] = ()
) -> tuple[RollerDuty, ...]:
    """Force, stress and life of every roller: of two that drive a follower to and fro each carries its own direction.

    ratings  of the rollers' bearings, one a table of the profile, the last one for all that follow; without any none is
             rated

    On a flank that is straight along it a crowned roller touches with the crown's own arc, at its crest.
    """
    from camgeom.mechanics.roller_duty import RollerDuty

    quoted, lags = mechanism.quoted_radius, mechanism.lags or (None,) * len(mechanism.tracks)
    alone = mechanism.drive is Drive.ALONE and not mechanism.touches
    duties = []
    for index, (track, roller) in enumerate(zip(mechanism.tracks, mechanism.rollers)):
        table = "roller" if roller is mechanism.roller else "return_roller"
        rating = ratings[min(index, len(ratings) - 1)] if ratings else None
        low, high = track.contact
        crown = None
        if mechanism.crown == "straight" and isinstance(track.meridian, Arc):
            crown, track = track.meridian.arc, mechanism.cutting(track)
        middle = 0.5 * (low + high)
        station, at = track.meridian.parameter(middle), None
        if crown is None and quoted is not None and quoted != middle and min(low, high) <= quoted <= max(low, high):
            at = track.meridian.parameter(quoted)
        duties.append(
            RollerDuty(track, station, high - low, load, material.roller, material.cam, crown, rating, mechanism.beside,
                       mechanism.runs_out, alone, roller.ends, table, mechanism.passes, lags[index], at)
        )  # fmt: skip
    return tuple(duties)


def face_duty(material: Materials, load: Load, touches: tuple[Touch, ...]) -> FaceDuty:
    """Force and stress of what touches a planar cam."""
    from camgeom.mechanics.face_duty import FaceDuty

    return FaceDuty(touches, load, material.roller, material.cam)


def carriers(
    material: Materials, mechanism: Mechanism, load: Load, ratings: Sequence[Rating | None]
) -> tuple[Duty, ...]:
    """The duties of all that presses a cam without a turret: its rollers, or the faces together."""
    if mechanism.roller is None:
        return (face_duty(material, load, mechanism.touches),)
    return roller_duties(material, mechanism, load, ratings)


def turret_duty(
    material: Materials, mechanism: Mechanism, turret: Turret, load: Load, rating: Rating | None
) -> TurretDuty:
    """Load sharing, stress and life of a turret's rollers."""
    from camgeom.mechanics.turret_duty import TurretDuty

    bore, roller = mechanism.bore.diameter if mechanism.bore else 0.0, mechanism.roller
    beside = mechanism.engagements
    assert roller is not None, "a turret has rollers"
    assert beside is not None, "and they stand beside the cam"
    return TurretDuty(
        beside, load, material.roller, material.cam, turret.preload, mechanism.width,
        bore, rating, roller.ends, roller.arc,
    )  # fmt: skip


def ratings_of(profile: Profile) -> tuple[Rating | None, ...]:
    """What the profile says of the bearing in each of its tables of rollers; None without a dynamic rating."""
    return tuple(_rating(profile, table, roller) for table, roller in profile.rollers.items())


def _rating(profile: Profile, table: str, roller: AnyRoller) -> Rating | None:
    if roller.dynamic_rating is None:
        return None
    from camgeom.mechanics.rating import KINDS, RELIABILITY, Lubrication, Rating

    oil = profile.oil
    static = [one for one in (roller.static_rating, roller.max_static_load) if one is not None]
    lubrication = None
    given = dict(roller)
    missing = [f"{table}.{key}" for key in MODIFIED if given[key] is None]
    if oil is None:
        missing.append("[lubricant]")
    if not missing:
        assert oil is not None
        assert roller.fatigue_load_limit is not None
        assert roller.contamination is not None
        assert roller.pitch_diameter is not None
        lubrication = Lubrication(roller.fatigue_load_limit, roller.contamination, roller.pitch_diameter, oil.viscosity)
    return Rating(
        roller.dynamic_rating, min(static) if roller.static_rating is not None else None, KINDS[roller.bearing_type],
        RELIABILITY[profile.limits.bearing_reliability], lubrication, roller.static_rating, roller.max_radial_load,
        roller.limiting_speed, table, tuple(missing),
    )  # fmt: skip
