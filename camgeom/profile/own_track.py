"""Further tracks on the body of the first one, [[track]]: each with its own follower, motion, roller and load.

A table overrides single keys of [cam], [follower] and [operation], and [roller] and [[motion]] as a whole; what it
leaves out is as of the first track. It is read and judged as a profile of its own. Its program counts from its own cam
angle, the cam's less the `angle` of its follower's place; so does what is told of it.
"""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, cast, final

from pydantic import Field, SerializeAsAny

from camgeom.errors import Problem, ProfileError
from camgeom.keys import Section
from camgeom.profile.errors import keys_of, plain
from camgeom.profile.idle import MESSAGE
from camgeom.profile.sections import INTERNAL, Operation
from camgeom.profile.text import key_path, replaced

if TYPE_CHECKING:
    from camgeom.profile import Profile

MOST_TRACKS = 8
MERGED, WHOLE = ("cam", "follower", "operation"), ("roller", "motion")
"""tables whose keys a track overrides one by one, and those that it replaces"""
PIVOTED = ("center_distance",)
"""keys of [cam] that belong to the kind of its follower: one of another kind does not take them over"""
FIRST_ONLY = ("track", "station")
"""what the first track alone may have"""
FOR_ALL = ("limits", "dynamics", "impact", "tolerance")
"""tables whose keys are of the followers of all tracks"""
TWO_UNITS = re.compile(r"[^(,;]+ \((?:N|deg|mm|kg|seconds)")
"""how the meaning of a key begins whose unit is another one of what turns than of a slide"""


@final
class OwnTrack(Section):
    """A further track: where its follower stands, and the profile of its own."""

    angle: Annotated[float, Field(ge=0.0, lt=360.0)] = Field(
        0.0, description="deg, place of its follower about the cam axis from that of the first one, in the sense of "
        "the cam's turning; its motion counts from there: it comes by that much later than the first one's"
    )
    cam: dict[str, Any] = Field({}, description="keys of [cam] that differ: of a drum where it lies (start), "
                                "groove_depth, pitch_radius, running_clearance, root_radius; of a disc form, face, "
                                "rim, base_radius, center_distance, groove_depth, running_clearance, root_radius; a "
                                "table with another form states all of these that it needs")  # fmt: skip
    follower: dict[str, Any] = Field({}, description="keys of [follower] that differ; another kind states all of them")
    roller: dict[str, Any] | None = Field(None, description="its roller, with all of its keys; default: as [roller]")
    motion: tuple[dict[str, Any], ...] | None = Field(
        None, description="segments of its own motion; default: those of the first track"
    )
    operation: dict[str, Any] = Field({}, description="keys of [operation] that differ; the speed is the cam's")
    profile: SerializeAsAny[Section] | None = Field(None, description="what it comes to", json_schema_extra=INTERNAL)

    @property
    def whole(self) -> Profile:
        """The profile of this track as if it were alone on its body."""
        return cast("Profile", self.profile)


def merged(first: dict[str, Any], table: dict[str, Any], own: tuple[str, ...]) -> dict[str, Any]:
    """The plain data of a further track alone: that of the first with what the table says.

    own  keys of [cam] that belong to one track; those of the first are not those of another form
    """
    data = {key: value for key, value in first.items() if key not in FIRST_ONLY}
    kind = data.get("follower", {}).get("kind")
    other = table.get("follower", {}).get("kind", kind) != kind
    if other:
        data["cam"] = {key: value for key, value in data["cam"].items() if key not in PIVOTED}
    for name in MERGED:
        if name in table:
            data[name] = table[name] if other and name == "follower" else {**data.get(name, {}), **table[name]}
    if table.get("cam", {}).get("form", first["cam"].get("form")) != first["cam"].get("form"):
        body = {key: value for key, value in first["cam"].items() if key not in own}
        data["cam"] = body | table["cam"]
    if "force" in table.get("operation", {}) and "duty" in data:
        # Forces of a state stand for those of [operation], which are not this track's.
        data["duty"] = tuple({key: value for key, value in state.items() if key != "force"} for state in data["duty"])
    return data | {name: table[name] for name in WHOLE if name in table}


def tracks_of(profile: Profile, tables: Any, read: Any) -> tuple[OwnTrack, ...]:
    """The typed tracks; `read` makes a profile of plain data. Raises ProfileError with the problems of all of them."""
    if not isinstance(tables, tuple) or not all(isinstance(table, dict) for table in tables):
        arrays, hint = "needs an array of tables [[track]]", "write [[track]] in double brackets"
        raise ProfileError([Problem("track", arrays, plain(tables), "", hint)], profile.source)
    allowed = profile.cam.TRACKS
    if not allowed:
        room = "grooved drums and discs have room for several tracks"
        raise ProfileError([Problem("track", "means nothing here", None, "", room)], profile.source)
    if len(tables) > MOST_TRACKS:
        raise ProfileError([Problem("track", "too many tracks", len(tables), f"at most {MOST_TRACKS}")], profile.source)
    found, problems = list[OwnTrack](), list[Problem]()
    for index, table in enumerate(tables):
        at = f"track[{index}]"
        wrong = list(_refused(profile, table, at))
        if not wrong:
            try:
                own = _of_its_own(merged(profile.stated, table, allowed), table, profile.source, read)
                wrong += _of_two_units(profile, own, table, at)
                angle = table.get("angle", 0.0)
                found.append(OwnTrack(**{**table, "angle": float(angle), "profile": own}))
            except ProfileError as error:
                wrong = [_placed(one, at, profile.cam.TRACKS) for one in error.problems]
        problems += wrong
    if problems:
        raise ProfileError(problems, profile.source)
    return tuple(found)


def _of_its_own(data: dict[str, Any], table: dict[str, Any], source: str, read: Any) -> Profile:
    """The profile of a track; what it takes over and has no use for, as limits and solvers of another form, is left."""
    try:
        profile: Profile = read(data, source)
    except ProfileError as error:
        idle = [one.key for one in error.problems if one.message == MESSAGE and not _says(table, one.key)]
        if len(idle) < len(error.problems):
            raise
        for key in idle:
            data = replaced(data, key_path(key) or (), None, key)
        profile = read(data, source)
    return profile


def _of_two_units(profile: Profile, own: Profile, table: dict[str, Any], at: str) -> list[Problem]:
    """What is stated in the unit of the first follower, and would be taken in another one for that of a track."""
    if own.rotating == profile.rotating:
        return []
    slides, turns = ("the first one turns", "slides") if profile.rotating else ("the first one slides", "turns")
    stated, said = profile.stated, table.get("operation", {})
    keys = {key for key, field in keys_of(Operation).items() if TWO_UNITS.match(field.description or "")} | {"force"}
    found = [
        Problem(f"{at}.operation.{key}", f"is missing: {slides}, this follower {turns}, and its unit is another one")
        for key in sorted(keys - said.keys()) if stated.get("operation", {}).get(key)
    ]
    if "motion" not in table:
        found.append(Problem(f"{at}.motion", f"is missing: {slides}, this follower {turns}, and its lifts are others"))
    if "force" not in said and any("force" in state for state in stated.get("duty", ())):
        found.append(Problem(f"{at}.operation.force", "is missing: those of [[duty]] are in another unit"))
    for name in FOR_ALL:
        for key in sorted(key for key, value in stated.get(name, {}).items() if value):
            if TWO_UNITS.match(_meaning(profile, name, key)):
                message = f"has two units: {slides}, the follower of {at} {turns}"
                found.append(Problem(f"{name}.{key}", message, plain(stated[name][key])))
    return found


def _meaning(profile: Profile, section: str, key: str) -> str:
    """The meaning of a key of a section as it was read; empty of one that is unknown there."""
    model = getattr(profile, section)
    field = None if model is None else keys_of(type(model)).get(key)
    return "" if field is None else field.description or ""


def _says(table: dict[str, Any], key: str) -> bool:
    """Whether a track's own table gives a key, or replaces what it is in."""
    first, _, rest = key.partition(".")
    within = table.get(first.partition("[")[0])
    return within is not None and (first.partition("[")[0] in WHOLE or rest in within)


def _placed(problem: Problem, at: str, of_cam: tuple[str, ...]) -> Problem:
    """A problem of a track's own profile by the key that can be set: the track's where it may say it, else the body's.
    """
    table, _, key = problem.key.partition(".")
    body = {"cam": key not in of_cam, "operation": key == "speed"}
    if body.get(table, table.partition("[")[0] not in (*MERGED, *WHOLE)):
        return replace(problem, message=f"{problem.message}, of {at}")
    return replace(problem, key=f"{at}.{problem.key}")


def _refused(profile: Profile, table: dict[str, Any], at: str) -> list[Problem]:
    found = []
    known = {"angle", *MERGED, *WHOLE}
    for key in sorted(table.keys() - known):
        found.append(Problem(f"{at}.{key}", "unknown key", None, ", ".join(sorted(known))))
    for name in (*MERGED, "roller"):
        if not isinstance(table.get(name, {}), dict):
            found.append(Problem(f"{at}.{name}", "wrong type", plain(table[name]), f"a table [track.{name}]"))
    if found:
        return found
    for key in sorted(table.get("cam", {}).keys() - set(profile.cam.TRACKS)):
        found.append(Problem(f"{at}.cam.{key}", "is the body's, one for all tracks", plain(table["cam"][key]),
                             ", ".join(profile.cam.TRACKS)))  # fmt: skip
    if "speed" in table.get("operation", {}):
        speed = plain(table["operation"]["speed"])
        found.append(Problem(f"{at}.operation.speed", "is the cam's, one for all tracks", speed))
    angle = table.get("angle", 0.0)
    if isinstance(angle, bool) or not isinstance(angle, int | float) or not 0.0 <= angle < 360.0:
        found.append(Problem(f"{at}.angle", "out of range", plain(angle), "from 0 to less than 360 deg"))
    return found
