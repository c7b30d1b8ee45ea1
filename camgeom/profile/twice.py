"""Quantities that a profile states twice: equal within 1 %, or refused by both names; neither wins in silence.

What moves, the return spring and its preload stand in [follower] and [operation], and again in [dynamics] or [impact],
where they serve those solvers alone. The play of [impact] may be more than the body has (bearings, wear), never less,
and its contact no longer than the roller's.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees, isclose
from typing import TYPE_CHECKING

from camgeom.errors import Problem

if TYPE_CHECKING:
    from camgeom.dynamics.impact.spec import ImpactSpec
    from camgeom.dynamics.spec import DynamicsSpec
    from camgeom.profile import Profile
    from camgeom.solid.mechanism import Mechanism

SAME = 0.01
"""share within which two values of a quantity are one"""
EXACT = 1e-9
MILLI = 1e-3


def contradictions(profile: Profile, mechanism: Mechanism) -> list[Problem]:
    """One problem for every key whose value is another than the one that a second key gives the same quantity."""
    found: list[Problem] = []
    if profile.dynamics_spec is not None:
        found += _of_dynamics(profile, profile.dynamics_spec)
    if profile.impact_spec is not None:
        found += _of_impact(profile, profile.impact_spec, mechanism)
    return found


def _of_dynamics(profile: Profile, spec: DynamicsSpec) -> Iterator[Problem]:
    moving, unit = _moving(profile), _unit(profile)
    turret, load = spec.turret_inertia, spec.load_inertia
    if moving is not None and load is not None:
        if turret is not None:
            yield from _other("dynamics.load_inertia", "with dynamics.turret_inertia", turret + load, *moving, unit)
        elif load >= moving[1]:
            yield Problem("dynamics.load_inertia", f"leaves nothing for the turret of what {moving[0]} states", load,
                          f"below {moving[1]:.6g} {unit}", "give one of them, or both alike")  # fmt: skip
    if moving is not None and spec.mass is not None:
        beside = "with dynamics.tappet_mass" if spec.tappet_mass else ""
        yield from _other("dynamics.mass", beside, spec.mass + spec.tappet_mass, *moving, unit)
    operation, rotating = profile.operation, profile.rotating
    if operation is None:
        return
    # N mm/deg and N mm of a swinging follower against N m/rad and N m
    rate = MILLI * degrees(operation.spring_rate) if rotating else operation.spring_rate
    preload = MILLI * operation.spring_preload if rotating else operation.spring_preload
    given = operation.model_fields_set
    if "spring_rate" in given and spec.return_stiffness is not None:
        yield from _other("dynamics.return_stiffness", "", spec.return_stiffness, "operation.spring_rate", rate,
                          "N m/rad" if rotating else "N/mm")  # fmt: skip
    if "spring_preload" in given and spec.preload is not None:
        yield from _other("dynamics.preload", "", spec.preload, "operation.spring_preload", preload,
                          "N m" if rotating else "N")  # fmt: skip


def _of_impact(profile: Profile, spec: ImpactSpec, mechanism: Mechanism) -> Iterator[Problem]:
    moving = _moving(profile)
    if moving is not None and spec.inertia is not None:
        yield from _other("impact.inertia", "", spec.inertia, *moving, _unit(profile))
    play, key = mechanism.free_play, "follower.clearance" if profile.follower.clearance else "cam.running_clearance"
    if spec.clearance is not None and spec.clearance < (1.0 - SAME) * play:
        yield Problem("impact.clearance", f"is less than the play of the body, which {key} gives", spec.clearance,
                      f"at least {play:.6g} mm", "leave it out, or give the body less play")  # fmt: skip
    length = mechanism.contact_length
    if spec.contact_length is not None and spec.contact_length > (1.0 + EXACT) * length:
        yield Problem("impact.contact_length", "is longer than what touches (roller.length, or the disc's width)",
                      spec.contact_length, f"at most {length:.6g} mm", "leave it out")  # fmt: skip


def _unit(profile: Profile) -> str:
    return "kg m2" if profile.rotating else "kg"


def _moving(profile: Profile) -> tuple[str, float] | None:
    """The keys that say what moves, and its mass, kg, or inertia, kg m2; None where none of them is given."""
    follower, operation = profile.follower, profile.operation
    own = "inertia" if profile.rotating else "mass"
    names = [f"follower.{own}"] if own in follower.model_fields_set else []
    if operation is not None and f"load_{own}" in operation.model_fields_set:
        names.append(f"operation.load_{own}")
    if not names:
        return None
    load = (operation.load_mass, operation.load_inertia) if operation is not None else (0.0, 0.0)
    return " and ".join(names), follower.moving(*load)


def _other(key: str, beside: str, value: float, name: str, same: float, unit: str) -> Iterator[Problem]:
    """A problem where the value of a key is another than the one that a second name gives."""
    if not isclose(value, same, rel_tol=SAME):
        what = f"{beside} is another value of what {name} states".strip()
        yield Problem(key, what, value, f"{same:.6g} {unit}, within 1 %", "give one of them, or both alike")
