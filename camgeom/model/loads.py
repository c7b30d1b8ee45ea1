"""What a profile's [operation] puts on the follower, and the duty of one roller under it, in internal units."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from typing import TYPE_CHECKING

from camgeom.errors import Problem, ProfileError
from camgeom.mechanics.load import FollowerLoad
from camgeom.mechanics.roller_duty import Duty
from camgeom.track import Arc, Straight, Track
from camgeom.track.follower import FrameFollower, Setup, SwingingFollower, TranslatingFollower, TurretFollower

if TYPE_CHECKING:
    from camgeom.profile import Profile
    from camgeom.profile.sections import Operation

DEGREES = 180.0 / pi


def operation_of(profile: Profile, purpose: str) -> Operation:
    """The [operation] section. Raises ProfileError where the profile has none, naming what it is wanted for."""
    if profile.operation is None:
        raise ProfileError([Problem("operation", f"missing: no speed or load to compute {purpose} from")])
    return profile.operation


def angular_speed(rpm: float) -> float:
    """r/min in rad/s."""
    return rpm * 2.0 * pi / 60.0


def follower_load(profile: Profile, setup: Setup) -> FollowerLoad:
    """Inertia, friction, spring, weight and applied forces on the follower; N and mm, or N mm and rad."""
    operation, follower = operation_of(profile, "a force"), setup.follower
    applied = tuple(force.applied() for force in operation.force)
    translating = isinstance(follower, TranslatingFollower | FrameFollower)
    if isinstance(follower, TranslatingFollower | FrameFollower):
        mass = follower.mass + operation.load_mass
        rate, weight = operation.spring_rate, mass * operation.gravity
    else:
        assert isinstance(follower, SwingingFollower | TurretFollower)
        mass = follower.inertia + operation.load_inertia
        rate, weight = operation.spring_rate * DEGREES, 0.0
    return FollowerLoad(
        setup.program,
        angular_speed(operation.speed),
        mass,
        operation.friction,
        operation.spring_preload,
        rate,
        weight,
        applied,
        "translating" if translating else "rotating",
        operation.guide_friction,
    )


def roller_duty(profile: Profile, setup: Setup, track: Track, flat: bool, quoted: float | None) -> Duty:
    """Force, stress and life of one roller.

    flat    a planar cam, straight along the roller's axis; quoted: where the classical figures are quoted on it, mm

    Such a cam is not the envelope of a crown: a crowned roller touches it with the crown's own arc.
    """
    low, high = track.contact
    crown = None
    if flat and isinstance(track.meridian, Arc):
        crown = track.meridian.arc
        track = replace(track, meridian=Straight(track.meridian.radius, track.meridian.centre))
    radius = 0.5 * (low + high)
    if quoted is not None and min(low, high) <= quoted <= max(low, high):
        radius = quoted
    load = follower_load(profile, setup)
    return Duty(
        track,
        track.meridian.parameter(radius),
        high - low,
        load,
        profile.material.roller,
        profile.material.cam,
        angular_speed(operation_of(profile, "stress and life").speed),
        crown,
    )
