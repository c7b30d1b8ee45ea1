"""Keys that a profile gives and that mean nothing for its cam, follower, roller, tool or solver: all found, none kept.

Every part of a profile says itself which of its keys say nothing, and why: `Cam.idle`, `Operation.idle`,
`CutterSpec.idle`, `DynamicsSpec.idle`, `ImpactSpec.idle`. A key that stands at its default says nothing wrong.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from pydantic import BaseModel

from camgeom.errors import Problem
from camgeom.track.follower import Setup, TurretFollower

if TYPE_CHECKING:
    from camgeom.profile import Profile

MESSAGE = "means nothing here"
ENDS = ("roller.end_radius", "roller.misalignment_deg", "roller.free_ends")
"""keys of a roller that is more than a line: how it ends and how it stands"""


def idle_problems(profile: Profile, setup: Setup) -> list[Problem]:
    """One problem for every key that the profile gives and that nothing would read, with what would read it."""
    return [
        Problem(key, MESSAGE, value if not isinstance(value, BaseModel) else None, "", reason)
        for key, reason in idle_keys(profile, setup).items()
        if (value := _stated(profile, key)) is not None
    ]


def idle_keys(profile: Profile, setup: Setup) -> dict[str, str]:
    """Keys (dotted paths) that mean nothing for this profile, whether it gives them or not, each with the reason."""
    found = dict(profile.cam.idle(setup))
    roller, dynamics, impact = profile.roller, profile.dynamics_spec, profile.impact_spec
    turret = isinstance(setup.follower, TurretFollower)
    if not turret:
        found["limits.output_torque_n_m"] = "only a turret has an output shaft"
    elif setup.program.advance:
        found["operation.spring_rate"] = (
            "a turret that goes on in one direction would wind it up: give its torque as an [[operation.force]]"
        )
    if turret:
        found |= dict.fromkeys(
            ENDS, "the rollers of a turret share its torque as lines along all of their length, parallel to the flank"
        )
    elif roller is not None and not roller.ends.stated and roller.shape != "crowned":
        found[ENDS[-1]] = "an end bears where roller.misalignment_deg or roller.end_radius is given"
    if roller is not None and roller.dynamic_rating is None:
        found["roller.static_rating"] = "the bearing is judged where its dynamic_rating is given"
    if roller is None or roller.static_rating is None:
        found["limits.bearing_static_safety"] = found["limits.warn_bearing_static_safety"] = (
            "a follower without a roller has no bearing" if roller is None else
            "give roller.static_rating (and dynamic_rating): the safety is that rating over the largest load"
        )  # fmt: skip
    if dynamics is None or dynamics.kind != "indexing" or dynamics.turret_inertia is not None:
        found["material.roller.density"] = "only the turret of an indexing drive without a turret_inertia is weighed"
    found["material.roller.bending_limit"] = "the roller's body is not solved; give material.cam.bending_limit"
    if profile.operation is not None:
        found |= _under("operation", profile.operation.idle(profile.rotating))
    if profile.output.table_tolerance is not None:
        found["output.table_points"] = "table_tolerance chooses the number of points"
    if dynamics is not None:
        found |= _under("dynamics", dynamics.idle())
        if turret != (dynamics.kind == "indexing"):
            found["dynamics.kind"] = "a turret is an indexing drive: kind = 'indexing'" if turret else (
                "an indexing drive needs a turret: kind = 'follower'"
            )
    if impact is not None:
        found |= _under("impact", impact.idle())
    if (cutter := profile.cutter_spec) is not None:
        found |= _under("cutter", cutter.idle())
    return found


def _under(section: str, keys: Mapping[str, str]) -> dict[str, str]:
    return {f"{section}.{key}": reason for key, reason in keys.items()}


def _stated(profile: Profile, key: str) -> object:
    """The value of a section or key that the profile gives, other than its default; None where it gives none."""
    here: object = profile
    for name in key.split("."):
        if not isinstance(here, BaseModel) or name not in here.model_fields_set:
            return None
        value = getattr(here, name)
        if value == type(here).model_fields[name].default:
            return None
        here = value
    return here
