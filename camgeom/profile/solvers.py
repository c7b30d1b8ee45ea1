"""What the solvers of [dynamics] and [impact] ask of the whole profile: refused when it is read, not while they run.

Every solver carries all of [operation] or refuses a key by name. What only a computed body or motion tells (an undercut
flank, a velocity that jumps) is a finding on the design, and no matter of the profile.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from typing import TYPE_CHECKING

from camgeom.errors import DesignError, Problem, ProfileError
from camgeom.track.follower import TurretFollower

if TYPE_CHECKING:
    from camgeom.dynamics.impact.spec import ImpactSpec
    from camgeom.dynamics.spec import DynamicsSpec
    from camgeom.profile import Profile
    from camgeom.solid.mechanism import Mechanism

LINEAR = ("wilson", "newmark", "generalized-alpha")
"""methods that solve linear drives alone"""
BOTH_WAYS = "a groove, a conjugate pair with a rocker, or a constant-width cam with a frame"


def solver_problems(profile: Profile, mechanism: Mechanism) -> list[Problem]:
    """One problem for every key that a solver of the profile cannot carry, or cannot do without."""
    dynamics, impact = profile.dynamics_spec, profile.impact_spec
    found: list[Problem] = []
    if profile.operation is None:
        for name, spec in (("dynamics", dynamics), ("impact", impact)):
            if spec is not None:
                hint = f"give [operation] speed, or leave [{name}] out"
                found.append(Problem("operation", f"is missing: [{name}] is solved at its speed, under its loads",
                                     None, "a table [operation]", hint))  # fmt: skip
        return found
    if dynamics is not None:
        found += _of_drive(profile, dynamics, mechanism)
    if impact is not None:
        # Where a motion that jumps leaves no tracks, that is a finding on the design and costs the impacts alone.
        with suppress(DesignError):
            found += _of_impact(profile, impact, mechanism)
    return found


def refuse(profile: Profile, mechanism: Mechanism) -> None:
    """Raise ProfileError where a profile that was not read asks for what its solvers cannot do."""
    if problems := solver_problems(profile, mechanism):
        raise ProfileError(problems, profile.source)


def _of_drive(profile: Profile, spec: DynamicsSpec, mechanism: Mechanism) -> Iterator[Problem]:
    operation = profile.operation
    assert operation is not None
    turret = isinstance(profile.follower, TurretFollower)
    if turret != (spec.kind == "indexing"):
        what = "a turret is an indexing drive" if turret else "an indexing drive needs a turret"
        yield Problem("dynamics.kind", what, spec.kind, "indexing" if turret else "follower")
        return
    bent = spec.exact_contact or spec.shaft_stiffness is not None
    if bent and spec.method in LINEAR:
        key = "dynamics.exact_contact" if spec.exact_contact else "dynamics.shaft_stiffness"
        yield Problem("dynamics.method", f"solves linear drives, and {key} makes this one non-linear", spec.method,
                      "auto, gauss1 to gauss8, radau2, radau3, radau5")  # fmt: skip
    if spec.sweep is not None:
        of_states = [(f"duty[{index}]", state.force) for index, state in enumerate(profile.operating_states)]
        of_stations = [(f"station[{index}]", station.force) for index, station in enumerate(profile.stations)]
        for place, forces in [("operation", operation.force), *of_states, *of_stations]:
            for index, force in enumerate(forces or ()):
                if force.hangs_on_speed:
                    what = "hangs on v or a: in dynamics.sweep it would be that of one speed"
                    yield Problem(f"{place}.force[{index}].expression", what, force.expression, "phi, deg and s",
                                  "or leave dynamics.sweep out")  # fmt: skip
    if spec.body_compliance and (reason := _not_meshed(mechanism)):
        yield Problem("dynamics.body_compliance", reason, True, "false")
    yield from (_of_indexing if turret else _of_follower)(profile, spec, mechanism)


def _not_meshed(mechanism: Mechanism) -> str:
    """Why nothing is known of the body below a mechanism's contacts; empty where it is."""
    if mechanism.roller is None:
        return "begins below the depth of a roller's contact, and there is no [roller]"
    if mechanism.bore is None:
        return "needs the body's volume, and one without a bore is held by nothing: give cam.bore"
    from camgeom.body.compliance import unmeshed

    with suppress(DesignError):
        return unmeshed(mechanism.parts, mechanism.cutters)
    return ""


def _of_indexing(profile: Profile, spec: DynamicsSpec, mechanism: Mechanism) -> Iterator[Problem]:
    assert profile.operation is not None
    own = profile.follower.inertia if isinstance(profile.follower, TurretFollower) else 0.0
    yield from _refused(
        profile, ("spring_rate", "spring_preload"), "the elastic indexing drive has no spring: a turret that goes on "
        "would wind it up", "give its torque as an [[operation.force]] over the cam angle",
    )  # fmt: skip
    moved = mechanism.follower.moving(profile.operation.load_mass, profile.operation.load_inertia)
    if spec.load_inertia is None and moved <= (spec.turret_inertia or 0.0):
        beside = f" beside dynamics.turret_inertia, {spec.turret_inertia:g} kg m2" if spec.turret_inertia else ""
        yield Problem("dynamics.load_inertia", f"is missing, and follower.inertia and operation.load_inertia leave "
                      f"nothing for it{beside}", moved, "> 0 kg m2", "give it, or one of those")  # fmt: skip
    elif spec.load_inertia is None and spec.turret_inertia is None and not own:
        yield Problem("follower.inertia", "is that of the turret, beside operation.load_inertia", 0.0, "> 0 kg m2",
                      "or give dynamics.turret_inertia and dynamics.load_inertia")  # fmt: skip


def _of_follower(profile: Profile, spec: DynamicsSpec, mechanism: Mechanism) -> Iterator[Problem]:
    operation = profile.operation
    assert operation is not None
    # Told here, after the keys that mean nothing: a plate's drive has no shaft to complete.
    for key, other in (("shaft_inertia", spec.shaft_stiffness), ("shaft_stiffness", spec.shaft_inertia)):
        if getattr(spec, key) is None and other is not None:
            yield Problem(f"dynamics.{key}", "is missing: an elastic cam shaft needs both shaft_inertia and "
                          "shaft_stiffness", None, "> 0")  # fmt: skip
    if spec.elastic_tappet or spec.shaft_stiffness is not None:
        yield from _refused(
            profile, ("guide_friction",), "is that of a tappet which follows the cam exactly, not one on an elastic "
            "contact or cam shaft", "leave tappet_stiffness and shaft_stiffness out, or give a friction in N",
        )  # fmt: skip
    if spec.tappet_contact is not None and mechanism.roller is None:
        yield Problem("dynamics.tappet_contact", "takes the stiffness of a roller's contact", spec.tappet_contact,
                      "a follower with a [roller]", "or give tappet_stiffness")  # fmt: skip
    moved = mechanism.follower.moving(operation.load_mass, operation.load_inertia)
    if spec.mass is None and moved <= spec.tappet_mass:
        own, load = ("inertia", "load_inertia") if profile.rotating else ("mass", "load_mass")
        unit = "kg m2" if profile.rotating else "kg"
        what = f"follower.{own} and operation.{load}"
        hint = f"give dynamics.mass for what is beyond the linkage, or {what}"
        if spec.tappet_mass:
            yield Problem("dynamics.tappet_mass", f"is all that moves ({what}) or more", spec.tappet_mass,
                          f"below {moved:g} {unit}", hint)  # fmt: skip
        else:
            yield Problem("dynamics.mass", f"is missing, and so are {what}", None, f"> 0 {unit}", hint)
    if spec.polydyne:
        yield from uncorrected(profile, mechanism)


def uncorrected(profile: Profile, mechanism: Mechanism) -> Iterator[Problem]:
    """What keeps an elastic follower's cam from being corrected for its vibration (polydyne)."""
    spec = profile.dynamics_spec
    assert spec is not None
    yield from _refused(profile, ("friction", "force"), "has no part in the cam that dynamics.polydyne corrects",
                        "leave it out, or polydyne = false")  # fmt: skip
    for key, value in (("linkage_damping", spec.linkage_damping), ("tappet_damping", spec.tappet_damping)):
        if value:
            yield Problem(f"dynamics.{key}", "dynamics.polydyne corrects for damping to ground alone", value, "0",
                          "give return_damping instead, or polydyne = false")  # fmt: skip
    order, needed = mechanism.program.continuity.order, 5 if spec.elastic_tappet else 3
    if order < needed:
        hint = 'take a smoother law, such as "5-6-7-8-9", or polydyne = false'
        yield Problem("dynamics.polydyne", f"corrects a motion of {needed} continuous derivatives or more", order,
                      f"at least {needed}", hint)  # fmt: skip


def _of_impact(profile: Profile, spec: ImpactSpec, mechanism: Mechanism) -> Iterator[Problem]:
    tracks, ways = mechanism.tracks, {touch.way for touch in mechanism.touches}
    groove = len(tracks) == 1 and len(tracks[0].sides) == 2 and mechanism.quoted_radius is not None
    if ways != {1.0, -1.0} and not groove:
        yield Problem("impact", "this cam does not drive its follower both ways", profile.kind, BOTH_WAYS)
        return
    if spec.roller_inertia is not None and profile.return_roller is not None:
        yield Problem("impact.roller_inertia", "is that of both rollers, and these are two kinds", spec.roller_inertia,
                      "none beside a [return_roller]")  # fmt: skip
    if any(roller.arc is not None for roller in mechanism.rollers):
        why = "is of line contacts: a crown on a straight flank touches in an ellipse, whose law is 'hertz'"
        if spec.law in ("liu", "printed"):
            yield Problem("impact.law", why, spec.law, "hertz or power")
        if spec.true_curvature:
            yield Problem("impact.true_curvature", why, spec.true_curvature, "false")
        if spec.contact_length is not None and all(roller.arc is not None for roller in mechanism.rollers):
            yield Problem("impact.contact_length", why, spec.contact_length)
    yield from _refused(
        profile, ("guide_friction",), "hangs on the side thrust, which jumps with every contact: the solver with free "
        "play does not carry it", "give a friction in N instead",
    )  # fmt: skip
    if not (spec.clearance or mechanism.free_play):
        yield Problem("impact.clearance", "is missing, and the body has no play", None, "a length in mm above 0")
    assert profile.operation is not None
    moved = mechanism.follower.moving(profile.operation.load_mass, profile.operation.load_inertia)
    if spec.inertia is None and not moved:
        own, unit = ("inertia", "kg m2") if profile.rotating else ("mass", "kg")
        yield Problem("impact.inertia", f"is missing, and so are follower.{own} and operation.load_{own}", None,
                      f"> 0 {unit}", "give one of them")  # fmt: skip
    for law in spec.laws:
        yield from _of_law(profile, law)


def with_law(profile: Profile, law: str) -> Profile:
    """The profile with a law in place of those of all moving segments."""
    change = {"law": law, "parameters": ()}
    motion = tuple(one if one.to is None else one.model_copy(update=change) for one in profile.motion)
    return profile.model_copy(update={"motion": motion})


def _of_law(profile: Profile, law: str) -> Iterator[Problem]:
    """What keeps the profile's cam from being made with a law in place of those of its moving segments."""
    other = with_law(profile, law)
    try:
        found = other.cam.problems(other.setup())
    except ProfileError as error:
        found = error.problems
    for problem in found[:1]:
        yield Problem("impact.laws", f"with {law!r} the cam is none: {problem.key}: {problem.message}", law,
                      problem.allowed, problem.hint)  # fmt: skip


def _refused(profile: Profile, keys: tuple[str, ...], why: str, hint: str) -> Iterator[Problem]:
    """One problem for every one of some keys of [operation] that is not zero."""
    for key in keys:
        value = getattr(profile.operation, key)
        if value:
            yield Problem(f"operation.{key}", why, value if isinstance(value, float) else None, "0", hint)
