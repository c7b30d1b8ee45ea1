"""Keys that a profile gives and that mean nothing for its cam, follower, roller, tool or solver: all found, none kept.

Every part of a profile says itself which of its keys say nothing, and why: `Cam.idle`, `Operation.idle`,
`CutterSpec.idle`, `DynamicsSpec.idle`, `ImpactSpec.idle`. A key that stands at its default says nothing wrong.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from pydantic import BaseModel

from camgeom.errors import DesignError, Problem
from camgeom.track.follower import AnyRoller, CrownedRoller, FrameFollower, Setup, TurretFollower

if TYPE_CHECKING:
    from camgeom.profile import Profile

MESSAGE = "means nothing here"
ENDS = ("end_radius", "misalignment_deg", "free_ends")
"""keys of a roller that is more than a line: how it ends and how it stands"""
RATED = "the bearing is judged where its dynamic_rating is given"
MODIFIED = ("fatigue_load_limit", "contamination", "pitch_diameter")
"""keys of a bearing that the life factor a_ISO of ISO 281 takes"""


def idle_problems(profile: Profile, setup: Setup, tracks: bool = False) -> list[Problem]:
    """One problem for every key that the profile gives and that nothing would read, with what would read it.

    tracks: whether its body has further tracks
    """
    return [
        Problem(key, MESSAGE, value if not isinstance(value, BaseModel) else None, "", reason)
        for key, reason in idle_keys(profile, setup, tracks).items()
        if (value := _stated(profile, key)) is not None
    ]


def idle_keys(profile: Profile, setup: Setup, tracks: bool = False) -> dict[str, str]:
    """Keys (dotted paths) that mean nothing for this profile, whether it gives them or not, each with the reason."""
    found = dict(profile.cam.idle(setup))
    if tracks or (profile.station and setup.roller is not None):
        found.pop("limits.clearance_mm", None)  # followers keep apart from each other
    rollers, dynamics, impact = profile.rollers, profile.dynamics_spec, profile.impact_spec
    turret = isinstance(setup.follower, TurretFollower)
    if not profile.cam.SLIDES:
        found["limits.drive_force_n"] = "only a linear cam's plate is driven along its travel"
    if not turret:
        found["limits.output_torque_n_m"] = found["output_shaft"] = "only a turret has an output shaft"
    elif setup.program.advance:
        found["operation.spring_rate"] = (
            "a turret that goes on in one direction would wind it up: give its torque as an [[operation.force]]"
        )
    for table, roller in rollers.items():
        if table not in profile.cam.ROLLERS:
            found[table] = "only a conjugate pair has a second roller of its own"
            continue
        if not roller.ends.stated and roller.shape != "crowned":
            reason = f"an end bears where {table}.misalignment_deg or {table}.end_radius is given"
            found[f"{table}.{ENDS[-1]}"] = reason
        elif isinstance(roller, CrownedRoller) and roller.crown == "logarithmic":
            reason = "no end of a logarithmic crown bears: it falls away without a bound towards both"
            found[f"{table}.{ENDS[-1]}"] = reason
        found |= _of_bearing(profile, table, roller)
    joint = profile.output_shaft_spec
    if joint is None or joint.bolts is None:
        reason = "give the bolts of [output_shaft]"
        found |= {f"limits.{key}": reason for key in ("bolt_slip_safety", "bolt_shear_safety")}
    if not any(roller.dynamic_rating for roller in rollers.values()):
        found["limits.bearing_reliability"] = RATED if rollers else "a follower without a roller has no bearing"
    found |= _of_film(profile)
    if not any(roller.static_rating for roller in rollers.values()):
        found["limits.bearing_static_safety"] = found["limits.warn_bearing_static_safety"] = (
            "a follower without a roller has no bearing" if not rollers else
            "give roller.static_rating (and dynamic_rating): the safety is that rating over the largest load"
        )  # fmt: skip
    weighed = dynamics is not None and dynamics.kind == "indexing" and dynamics.turret_inertia is None
    plate = isinstance(setup.follower, FrameFollower) and setup.follower.plate_length is not None
    if not weighed and not plate:
        reason = "only the turret of an indexing drive without a turret_inertia, and a frame's plate, are weighed"
        found["material.roller.density"] = reason
    if not plate:
        found["material.roller.bending_limit"] = "a frame's plate is solved, no roller; give material.cam.bending_limit"
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


def idle_way(profile: Profile) -> list[Problem]:
    """The problem of a `cutter.milling` that changes nothing, and of a `cutter.axis`, on any track of the body."""
    cutter = profile.cutter_spec
    if cutter is None or (cutter.milling == "climb" and cutter.axis != "fitted"):
        return []
    alone = (profile, *(track.whole for track in profile.tracks))
    try:
        mechanisms = [one.cam.mechanism(one.setup()) for one in alone]
        found = cutter.upright(mechanisms)
        reasons = [cutter.one_way(one) for one in mechanisms]
    except DesignError:
        return []  # Of flanks that cannot be made nothing is known; whoever asks for them is told.
    if cutter.milling == "climb" or not all(reasons):
        return found
    return [*found, Problem("cutter.milling", MESSAGE, cutter.milling, "", reasons[0])]


def _of_bearing(profile: Profile, table: str, roller: AnyRoller) -> dict[str, str]:
    """Keys of a roller's bearing that is not rated, and of one whose other keys are missing."""
    found = dict[str, str]()
    if roller.designation is None:
        found[f"{table}.catalogue"] = f"give {table}.designation: the catalogue is asked for that"
    if roller.dynamic_rating is None:
        keys = ("static_rating", "bearing_type", *MODIFIED, "max_radial_load", "max_static_load", "limiting_speed")
        return found | _under(table, dict.fromkeys(keys, RATED))
    if roller.static_rating is None:
        found[f"{table}.max_static_load"] = f"give {table}.static_rating too: the lower of both is the static limit"
    given = dict(roller)
    absent = [key for key in MODIFIED if given[key] is None]
    if profile.lubricant is None:
        absent.append("lubricant")
    if absent:
        wanted = ", ".join("[lubricant]" if key == "lubricant" else f"{table}.{key}" for key in absent)
        found |= {f"{table}.{key}": f"a_ISO of ISO 281 wants {wanted} too" for key in MODIFIED}
    return found


def _of_film(profile: Profile) -> dict[str, str]:
    """Keys of film, friction and wear whose other keys are missing."""
    found, oil = dict[str, str](), profile.oil
    bodies = (("cam", profile.material.cam), ("roller", profile.material.roller))
    rough = all(material.roughness_um is not None for _, material in bodies)
    if profile.operation is None:
        found["lubricant"] = "nothing runs: give [operation]"
    if oil is None or oil.pressure_viscosity is None:
        reason = "the film that it is compared with wants [lubricant] with a pressure_viscosity"
        found |= {f"material.{body}.roughness_um": reason for body, _ in bodies}
    if oil is None or oil.pressure_viscosity is None or not rough:
        reason = "wants [lubricant] with a pressure_viscosity, and roughness_um of cam and roller"
        found |= dict.fromkeys(("limits.film_ratio", "limits.warn_film_ratio"), reason)
    if all(material.wear_rate is None for _, material in bodies):
        found["limits.wear_um"] = "nothing wears: give material.cam.wear_rate, material.roller.wear_rate"
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
        default = type(here).model_fields[name].default
        if value == default or (default is None and value is False):
            return None  # Whoever turns off what is not there asks for nothing else.
        here = value
    return here
