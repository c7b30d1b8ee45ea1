"""Further followers on the track of the first one, [[station]]: where each stands about the cam, and what differs.

The cam turns the same track past all of them, so each does at its own cam angle, the cam's less the angle of its place,
what the first does at the cam's: everything that is told of a follower counts from there. Its forces too act over its
own cam angle.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, final

from pydantic import Field

from camgeom.errors import Problem
from camgeom.keys import Section
from camgeom.profile.sections import Force, NonNegative
from camgeom.track.follower import Inertia, Mass

if TYPE_CHECKING:
    from camgeom.profile import Profile
    from camgeom.track.follower import Setup

OWN = ("mass", "inertia")
"""keys of the follower; all others but `angle` are those of [operation]"""


@final
class Station(Section):
    """A further follower of the same kind and roller on the same track; what it leaves out is as of the first one."""

    angle: Annotated[float, Field(gt=0.0, lt=360.0)] = Field(
        description="deg, its place about the cam axis from the first follower, in the sense of the cam's turning; its "
        "motion comes later by as much"
    )
    mass: Mass | None = Field(None, description="kg, all that moves with it; default that of [follower]")
    inertia: Inertia | None = Field(None, description="kg m2 about its pivot; default that of [follower]")
    friction: NonNegative | None = Field(None, description="N (N mm), against its motion; default as in [operation]")
    guide_friction: Annotated[float, Field(ge=0.0, le=10.0)] | None = Field(
        None, description="1, friction of its guides; default as in [operation]"
    )
    load_mass: Mass | None = Field(None, description="kg, moved with it; default as in [operation]")
    load_inertia: Inertia | None = Field(None, description="kg m2, turned with it; default as in [operation]")
    spring_rate: NonNegative | None = Field(None, description="N/mm (N mm/deg); default as in [operation]")
    spring_preload: NonNegative | None = Field(None, description="N (N mm); default as in [operation]")
    gravity: Annotated[float, Field(ge=-1000.0, le=1000.0)] | None = Field(
        None, description="m/s2, along its motion; default as in [operation]"
    )
    force: Annotated[tuple[Force, ...], Field(max_length=1000)] | None = Field(
        None, description="its applied forces, over its own cam angle, in every state of [[duty]]; default those of "
        "[operation], or of the state"
    )

    def profile(self, first: Profile) -> Profile:
        """The profile of this follower alone, as if it stood where the first one does."""
        given = {key: value for key, value in self if key != "angle" and value is not None}
        own = {key: given.pop(key) for key in OWN if key in given}
        operation = first.operation.model_copy(update=given) if first.operation is not None else None
        follower = first.follower.model_copy(update=own)
        duty = first.operating_states
        if self.force is not None:
            duty = tuple(state.model_copy(update={"force": None}) for state in duty)
        return first.model_copy(update={"follower": follower, "operation": operation, "duty": duty, "station": ()})


def station_problems(profile: Profile, setup: Setup) -> Iterator[Problem]:
    """What no station knows alone: cams that have room for one follower, two at one place, keys that mean nothing."""
    if not profile.cam.STATIONS:
        yield Problem("station", "means nothing here", None, "", "discs, drums, end faces and conjugate pairs have "
                      "room for several followers; frames and turrets have not")  # fmt: skip
        return
    idle = {"mass": "of a translating follower; a rotating one has an inertia"} if profile.rotating else {
        "inertia": "of a swinging follower; a translating one has a mass"}  # fmt: skip
    if profile.operation is not None:
        of_cam = profile.cam.idle(setup)
        idle |= {key.removeprefix("operation."): of_cam[key] for key in of_cam if key.startswith("operation.")}
        idle |= profile.operation.idle(profile.rotating)
    taken = set[float]()
    for number, station in enumerate(profile.stations):
        if station.angle in taken:
            yield Problem(f"station[{number}].angle", "is taken by another follower", station.angle)
        taken.add(station.angle)
        for key in sorted(station.model_fields_set - {"angle"}):
            reason = idle.get(key, "")
            if profile.operation is None and key not in OWN:
                reason = "give [operation]: a station says what differs from it"
            if reason:
                yield Problem(f"station[{number}].{key}", "means nothing here", None, "", reason)
    spec = profile.dynamics_spec
    if spec is not None and spec.shaft_stiffness is not None:
        yield Problem("dynamics.shaft_stiffness", "couples all followers of the cam, and each is solved alone",
                      spec.shaft_stiffness, "none beside a [[station]]")  # fmt: skip


def unsolved_stations(profile: Profile, setup: Setup) -> Iterator[Problem]:
    """What no solver can carry of a station, or what another key states otherwise, by the key that can be set.

    Of a profile whose first follower is free of both.
    """
    from camgeom.profile.solvers import solver_problems
    from camgeom.profile.twice import contradictions

    for number, station in enumerate(profile.stations):
        own, at = station.profile(profile), f"station[{number}]"
        mechanism = own.cam.mechanism(replace(setup, follower=own.follower))
        for problem in contradictions(own, mechanism) or solver_problems(own, mechanism):
            table, _, key = problem.key.partition(".")
            if table in ("operation", "follower") and key.partition("[")[0] in station.model_fields_set:
                yield replace(problem, key=f"{at}.{key}")
            else:
                yield replace(problem, message=f"{problem.message}, of {at}")
