"""A profile: everything that describes one cam, its drive and what is wanted, as frozen types read from TOML.

`read` and `parse` report every problem of a profile at once. Sections keep the edge units (mm, degrees, r/min);
`Profile.setup` is the door at which angles become radians.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Protocol, cast, final, runtime_checkable

import numpy as np
from pydantic import Field, PrivateAttr, SerializeAsAny, model_validator
from pydantic_core import CoreSchema, core_schema

from camgeom.cams import Cam
from camgeom.errors import DesignError, NotConverged, Problem, ProfileError
from camgeom.keys import Section
from camgeom.profile.idle import idle_problems, idle_way
from camgeom.profile.motion import MAX_SEGMENTS, motion_problems, program_of
from camgeom.profile.reader import Reader, first_of
from camgeom.profile.sections import (
    INCH,
    INTERNAL,
    MOST_FOLLOWED,
    MOST_LOADED,
    MOST_STATES,
    MOST_STATIONS,
    TURRETS_FOLLOWED,
    Force,
    Limits,
    Materials,
    MotionSegment,
    Operation,
    Output,
    Reproduced,
    TitleBlock,
    Units,
)
from camgeom.profile.text import MAX_BYTES, Path_, cleaned, dump, key_path, load, replaced
from camgeom.reading import decode, read_bytes
from camgeom.track import TURN
from camgeom.track.follower import AnyFollower, AnyRoller, Setup, TurretFollower

if TYPE_CHECKING:
    from camgeom.dynamics.impact.spec import ImpactSpec
    from camgeom.dynamics.spec import DynamicsSpec
    from camgeom.machining.spec import CutterSpec
    from camgeom.mechanics.lubricant import Lubricant
    from camgeom.mechanics.output_shaft import OutputShaft
    from camgeom.profile.duty import OperatingState
    from camgeom.profile.own_track import OwnTrack
    from camgeom.profile.station import Station
    from camgeom.tolerance.spec import ToleranceSpec

Swinging = tuple[str | None, float, float]
"""a force by its expression and the ends of its range"""
STDIN = "-"
"""the file name of standard input"""
_FILES: Any = {"__all__": {"rows_from"}}
UNTOLD: Any = {"source": True, "units": True, "motion": _FILES,
               "track": {"__all__": {"profile": {"source": True, "units": True, "motion": _FILES}}}}
"""what a design does not rest on: where it and its tables were read, and in which unit"""
MOST_ROWS, MOST_TURRET_ROWS = 9_000, 5_000
"""of all force tables together, beside a roller and on a turret: a run then takes 10 to 30 s and up to 1.7 GB"""
A_SWING = 2
"""rows of a table that a panel of an expression on a turret takes as long as"""


@runtime_checkable
class Readable(Protocol):
    """An open file."""

    def read(self) -> str | bytes:
        """All that is left of it."""


class _Typed:
    """Of a field whose section comes typed from the reader: the kinds that it is not need no validators."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        return core_schema.is_instance_schema(source)


@final
class Profile(Section):
    """One cam design. `cam` is the section of its kind, chosen from the registry of cam types."""

    name: Annotated[str, Field(min_length=1, max_length=120)] = Field("cam", description="shown in reports")
    units: Units = Field(
        "mm", description="of every length that the profile states: keys whose meaning begins with mm, and lifts of a "
        "follower that translates; a key whose name ends in _mm keeps mm, and N/mm, mm/s, mm/min and um stay; results "
        "are in mm"
    )
    reproduces: Reproduced | None = Field(
        None, description="the source document that the profile is the machine of: its report then shows every printed "
        "result beside ours (`camgeom validate`)"
    )
    cam: SerializeAsAny[Cam] = Field(description="the cam, by kind")
    follower: Annotated[AnyFollower, _Typed()] = Field(description="the follower, by kind")
    roller: Annotated[AnyRoller | None, _Typed()] = Field(
        None, description="the roller, by shape; none for flat and knife followers"
    )
    return_roller: Annotated[AnyRoller | None, _Typed()] = Field(
        None, description="a conjugate pair's return roller, by shape, with all of its own keys; default: as [roller]"
    )
    motion: Annotated[tuple[MotionSegment, ...], Field(min_length=1, max_length=MAX_SEGMENTS)] = Field(
        description="segments of the motion round the cam, in order"
    )
    operation: Operation | None = Field(None, description="speed and forces; needed for contact, life and dynamics")
    duty: Annotated[tuple[SerializeAsAny[Section], ...], Field(max_length=MOST_STATES)] = Field(
        (), description="operating states, over which damage is summed; without any the machine runs as [operation]"
    )
    station: Annotated[tuple[SerializeAsAny[Section], ...], Field(max_length=MOST_STATIONS)] = Field(
        (), description="further followers of the same kind on the same track; everything that is told of each counts "
        "from its own cam angle, the cam's less the `angle` of its place"
    )
    track: tuple[SerializeAsAny[Section], ...] = Field(
        (), description="further tracks on the same body, each with a follower of its own; what a table leaves out is "
        "as of the first track"
    )
    material: Materials = Field(Materials(), description="the two bodies in contact")
    lubricant: SerializeAsAny[Section] | None = Field(
        None, description="the lubricant of roller and cam, and of the bearing"
    )
    output_shaft: SerializeAsAny[Section] | None = Field(
        None, description="output shaft of a turret, and the bolts that carry its torque"
    )
    output: Output = Field(Output(), description="what is written")
    limits: Limits = Field(Limits(), description="what the checks judge against")
    drawing: TitleBlock = Field(TitleBlock(), description="what the part drawing's title block says")
    dynamics: SerializeAsAny[Section] | None = Field(None, description="indexing dynamics")
    impact: SerializeAsAny[Section] | None = Field(None, description="impacts in the clearance")
    cutter: SerializeAsAny[Section] | None = Field(None, description="the tool that makes the flanks")
    tolerance: SerializeAsAny[Section] | None = Field(None, description="errors of assembly and manufacture")
    source: str = Field("", description="the file it was read from", json_schema_extra=INTERNAL)
    _stated: dict[str, Any] | None = PrivateAttr(None)
    _beside: int = PrivateAttr(1)
    """programs of the cam that have best laws, which share what their search may cost"""
    _pieces: int = PrivateAttr(0)
    """of the motion, between the cam angles at which a derivative of it may jump"""
    _swings: dict[Swinging, int] = PrivateAttr(default_factory=dict)
    """panels that follow how expressions of forces swing, the most at any speed; on a turret `A_SWING` times"""

    def __eq__(self, other: object) -> bool:
        """Whether the sections are equal, however they were stated."""
        return isinstance(other, Profile) and self.__dict__ == other.__dict__

    @model_validator(mode="before")
    @classmethod
    def _complete_limits(cls, data: Any) -> Any:
        """Limits that depend on the follower, filled in before the profile freezes."""
        if isinstance(data, dict) and isinstance(data.get("follower"), AnyFollower):
            limits = data.get("limits", Limits())
            if isinstance(limits, Limits):
                return {**data, "limits": limits.for_follower(data["follower"])}
        return data

    @property
    def kind(self) -> str:
        """The cam kind as it is written in the profile."""
        return type(self.cam).__module__.rpartition(".")[2].replace("_", "-")

    @property
    def rotating(self) -> bool:
        """True where positions of the motion are degrees: swinging followers and turrets."""
        return self.follower.rotating

    @property
    def units_note(self) -> str:
        """What stands beside results where the profile's lengths are in another unit; empty where they are not."""
        return "the profile states lengths in inches; every result is in mm" if self.units == "inch" else ""

    @property
    def lift_unit(self) -> tuple[float, str]:
        """What a lift of the program, mm or rad, is divided by to give one as the profile states it, and the unit."""
        if self.rotating:
            return np.pi / 180.0, "°"
        return (INCH, "in") if self.units == "inch" else (1.0, "mm")

    @property
    def dynamics_spec(self) -> DynamicsSpec | None:
        """The [dynamics] section with its own type."""
        return cast("DynamicsSpec | None", self.dynamics)

    @property
    def impact_spec(self) -> ImpactSpec | None:
        """The [impact] section with its own type."""
        return cast("ImpactSpec | None", self.impact)

    @property
    def cutter_spec(self) -> CutterSpec | None:
        """The [cutter] section with its own type."""
        return cast("CutterSpec | None", self.cutter)

    @property
    def operating_states(self) -> tuple[OperatingState, ...]:
        """The [[duty]] tables with their own type."""
        return cast("tuple[OperatingState, ...]", self.duty)

    @property
    def rollers(self) -> dict[str, AnyRoller]:
        """The rollers that the profile gives, by the names of their tables."""
        given = {"roller": self.roller, "return_roller": self.return_roller}
        return {table: roller for table, roller in given.items() if roller is not None}

    @property
    def tracks(self) -> tuple[OwnTrack, ...]:
        """The [[track]] tables with their own type."""
        return cast("tuple[OwnTrack, ...]", self.track)

    @property
    def oil(self) -> Lubricant | None:
        """The [lubricant] section with its own type."""
        return cast("Lubricant | None", self.lubricant)

    @property
    def output_shaft_spec(self) -> OutputShaft | None:
        """The [output_shaft] section with its own type."""
        return cast("OutputShaft | None", self.output_shaft)

    @property
    def fastest(self) -> float | None:
        """Cam speed, r/min, of the fastest operating state; None without an [operation]."""
        if self.operation is None:
            return None
        stated = self.operation.speed
        return max((state.speed or stated for state in self.operating_states), default=stated)

    @property
    def tolerance_spec(self) -> ToleranceSpec | None:
        """The [tolerance] section with its own type."""
        return cast("ToleranceSpec | None", self.tolerance)

    @property
    def stations(self) -> tuple[Station, ...]:
        """The [[station]] tables with their own type."""
        return cast("tuple[Station, ...]", self.station)

    @property
    def stated(self) -> dict[str, Any]:
        """The plain data it was read from (tables as dict, arrays as tuple): what was stated, no defaults.

        Raises ProfileError for a profile that was made of typed sections.
        """
        if self._stated is None:
            raise ProfileError([Problem("profile", "was made of typed sections and has no text; read it from data")])
        return self._stated

    def toml(self) -> str:
        """What was stated, as TOML. Raises ProfileError for a profile that was made of typed sections."""
        return dump(self.stated)

    def with_(self, changes: Mapping[str, Any]) -> Profile:
        """The profile with other values under dotted keys (`cam.diameter`, `motion[1].to`), judged like a file.

        None as a value takes the key away. Raises ProfileError with every problem found.
        """
        data = self.stated
        for key, value in changes.items():
            path = key_path(key)
            if path is None:
                raise ProfileError([Problem(key, "is no dotted key", None, "for example cam.diameter or motion[1].to")])
            data = replaced(data, path, value, key)
        return from_data(*_clean(data, self.source))

    def digest(self) -> str:
        """SHA-256 of all that the design rests on: every key, rows of its tables, and the laws of the user's own files.

        Two profiles with the same digest are the same design, whatever their files are called.
        """
        import hashlib

        from camgeom.motion.own import loaded_contents

        # A command that makes no body decides how bodies are meshed where the profile does not.
        meshed = self.stated.get("output", {}).get("fewest_triangles")
        output = self.output.model_copy(update={"fewest_triangles": meshed})
        found = hashlib.sha256(self.model_copy(update={"output": output}).model_dump_json(exclude=UNTOLD).encode())
        # A law of the user's own reads its file itself.
        names = [value for segment in self.motion for key, value in segment.parameters if key == "file" and value]
        for name in names:
            found.update(Path(_folder_name(self.source), str(name)).read_bytes())
        if own := loaded_contents():
            found.update(b"".join(own))
            # What such a file rests on beside its own text shows in the motions alone.
            for one in (self, *(track.whole for track in self.tracks)):
                found.update(one.setup().program.table.content())
        return found.hexdigest()

    @property
    def pieces(self) -> int:
        """Pieces of the motions of all its tracks, between the cam angles at which a derivative of them may jump."""
        return sum(one._pieces for one in (self, *(track.whole for track in self.tracks)))

    def setup(self) -> Setup:
        """Follower, roller and the motion program (mm or rad over rad).

        Raises ProfileError where the motion cannot be made or does not close.
        """
        follower = self.follower
        span, travel = self.cam.MOTION_SPAN, self.cam.travel
        problems = motion_problems(self.motion, follower, span, travel)
        if problems:
            raise ProfileError(problems, self.source)
        program = program_of(self.motion, follower, span, _folder_name(self.source), travel, self._beside)
        corner = self.cutter_spec.corner_radius if self.cutter_spec is not None else 0.0
        try:
            carriage = self.cam.carriage(program)
            if carriage is not None:
                program = carriage.program
        except NotConverged as error:
            raise ProfileError([Problem("motion", str(error))], self.source) from None
        return Setup(follower, self.roller, program, corner, self.return_roller, carriage)


def read(path: str | Path) -> Profile:
    """The profile in a TOML file; `-` is standard input. Raises ProfileError with every problem found."""
    return parse(_text(path), _named(path))


def read_data(path: str | Path) -> dict[str, Any]:
    """The plain data of a profile file, for `from_data`; tables as dict, arrays as tuple. Raises ProfileError."""
    data, problems, _ = load(_text(path), _named(path))
    if problems:
        raise ProfileError(first_of(problems), _named(path))
    return data


def given(source: str | Path | Mapping[str, Any] | Readable, file: str = "") -> Profile:
    """The profile in a file's path, a TOML text, plain data, or an open file (text or binary).

    A text is a string of several lines or with a `=`; any other string is a path. `file` is named in messages, and
    data files that the profile names are looked for beside it; an open file of a name has that. Raises ProfileError
    with every problem found.
    """
    if isinstance(source, Path):
        return read(source)
    if isinstance(source, str):
        return parse(source, file) if "\n" in source or "=" in source else read(source)
    if isinstance(source, Mapping):
        return from_data(*_clean(dict(source), file))
    if not isinstance(source, Readable):
        raise TypeError(f"a profile is a path, a TOML text, a dict or an open file, not a {type(source).__name__}")
    content = source.read()
    text = content if isinstance(content, str) else decode(content, file)
    return parse(text, file)


def _clean(data: dict[str, Any], file: str) -> tuple[dict[str, Any], str, list[Problem], set[Path_]]:
    clean, problems, dropped = cleaned(data, file)
    return clean, file, problems, dropped


def _named(path: str | Path) -> str:
    return "" if str(path) == STDIN else str(path)


def _text(path: str | Path) -> str:
    if str(path) == STDIN:
        if sys.stdin is None:
            raise ProfileError([Problem("standard input", "is closed")])
        content = sys.stdin.buffer.read(MAX_BYTES + 1)
        if len(content) > MAX_BYTES:
            raise ProfileError([Problem("standard input", "is too long", None, f"at most {MAX_BYTES} bytes")])
        return decode(content, "standard input")
    return decode(read_bytes(Path(path), MAX_BYTES, str(path)), str(path))


def parse(text: str, file: str = "") -> Profile:
    """The profile in a TOML text; `file` is named in messages, and data files are looked for beside it."""
    data, problems, dropped = load(text, file)
    return from_data(data, file, problems, dropped)


def from_data(
    data: dict[str, Any], file: str = "", problems: list[Problem] | None = None, dropped: set[Path_] | None = None
) -> Profile:
    """The profile in plain data as `profile_text.load` gives it (tables as dict, arrays as tuple)."""
    first = {key: value for key, value in data.items() if key != "track"}
    further = data["track"] if isinstance(data.get("track"), tuple) else ()
    one = partial(_of_one_track, beside=max(sum(map(_optimal, (first, *further))), 1))
    profile = one(first, file, problems, dropped, tracks="track" in data)
    if "track" in data:
        from camgeom.profile.own_track import tracks_of

        profile = profile.model_copy(update={"track": tracks_of(profile, data["track"], one)})
        profile._stated = data
    followers = 1 + len(profile.station) + len(profile.tracks)
    if (states := len(profile.duty)) * followers > MOST_LOADED:
        most = f"at most {MOST_LOADED // followers}, {MOST_LOADED} with those of all followers"
        raise ProfileError([Problem("duty", f"too many states of {followers} followers", states, most)], file)
    rows = MOST_FOLLOWED // (TURRETS_FOLLOWED if isinstance(profile.follower, TurretFollower) else 1)
    if (followed := _followed(profile)) > rows:
        what = "too many pieces of motions and rows or swings of forces, of every follower in every state"
        named = next(key for key in ("duty", "track", "station", "motion") if getattr(profile, key))
        raise ProfileError([Problem(named, what, followed, f"at most {rows}")], file)
    others = [track.whole for track in profile.tracks]
    if (pieces := profile.pieces) > profile.cam.MOST_PIECES:
        what = "too many pieces of motions for this kind of cam" + (", of all tracks" if others else "")
        raise ProfileError([Problem("motion", what, pieces, f"at most {profile.cam.MOST_PIECES}")], file)
    rollers = [one.roller for one in (profile, *others)]
    if found := profile.cam.together([one.cam for one in others], rollers) or idle_way(profile):
        raise ProfileError(found, file)
    return profile


def _optimal(table: Any) -> bool:
    """Whether the motion of a profile or track, as it is written, has a best law."""
    motion = table.get("motion") if isinstance(table, dict) else None
    segments = motion if isinstance(motion, tuple) else ()
    return any(isinstance(segment, dict) and segment.get("law") == "optimal" for segment in segments)


def _of_one_track(
    data: dict[str, Any], file: str = "", problems: list[Problem] | None = None, dropped: set[Path_] | None = None,
    tracks: bool = False, beside: int = 1,
) -> Profile:  # fmt: skip
    """The same of a profile without [[track]], the first of several `tracks` on a body or alone; `beside` as of it."""
    reader = Reader(Profile, data, file, list(problems or []), set(dropped or ()))
    try:
        profile = Profile(**reader.parts(), source=file)
        profile._beside = beside
        if found := _cross_checks(profile, tracks):
            raise ProfileError(first_of(found), file)
    except ProfileError as error:
        if data.get("units") != "inch":
            raise
        from camgeom.profile.units import as_stated

        raise ProfileError(as_stated(error.problems, data), error.file) from None
    profile._stated = data
    return profile


def _cross_checks(profile: Profile, tracks: bool) -> list[Problem]:
    """What no single section can know: the motion as a whole, and what the cam type cannot build."""
    try:
        setup = profile.setup()
    except ProfileError as error:
        return error.problems
    profile._pieces = len(setup.program.knots) - 1
    idle = idle_problems(profile, setup, tracks)
    idle += _warnings_beyond(profile.limits)
    output = profile.output
    if output.free_tolerance is not None and output.free_tolerance < output.tolerance:
        allowed = f"at least output.tolerance, {output.tolerance:g} mm"
        idle.append(Problem("output.free_tolerance", "is finer than what is touched", output.free_tolerance, allowed))
    if profile.duty:
        from camgeom.profile.duty import duty_problems

        idle += duty_problems(profile)
    if profile.station:
        from camgeom.profile.station import station_problems

        idle += station_problems(profile, setup)
    if profile.operation is not None:
        idle += _forces(profile, profile.operation, setup)
    told = {problem.key for problem in idle}
    found = [*idle, *(problem for problem in profile.cam.problems(setup) if problem.key not in told)]
    tables = (profile.cutter_spec, profile.dynamics_spec, profile.impact_spec, profile.tolerance_spec)
    if not found and any(tables):
        from camgeom.profile.solvers import solver_problems
        from camgeom.profile.twice import contradictions

        mechanism = profile.cam.mechanism(setup)
        found += contradictions(profile, mechanism) or solver_problems(profile, mechanism)
        if profile.station and not found:
            from camgeom.profile.station import unsolved_stations

            found += unsolved_stations(profile, setup)
        if profile.cutter_spec is not None:
            found += profile.cutter_spec.problems(mechanism)
        if profile.tolerance_spec is not None:
            # Where a motion that jumps leaves no tracks, that is a finding on the design.
            with suppress(DesignError):
                found += profile.tolerance_spec.problems(mechanism)
    return found


def _warnings_beyond(limits: Limits) -> list[Problem]:
    """Thresholds of warnings beyond the limit they stand before: the design fails there already."""
    found = []
    angle, warn = limits.pressure_angle_deg, limits.warn_pressure_angle_deg
    if angle is not None and warn is not None and warn > angle:
        allowed = f"at most limits.pressure_angle_deg, {angle:g} deg"
        found.append(Problem("limits.warn_pressure_angle_deg", "the limit fails before it warns", warn, allowed))
    stated = "warn_undercut_margin" in limits.model_fields_set
    if stated and 0.0 < limits.warn_undercut_margin < limits.undercut_margin:
        allowed = f"at least limits.undercut_margin, {limits.undercut_margin:g}, or 0 for no warning"
        value = limits.warn_undercut_margin
        found.append(Problem("limits.warn_undercut_margin", "the limit fails before it warns", value, allowed))
    return found


def _forces(profile: Profile, operation: Operation, setup: Setup) -> Iterator[Problem]:
    """Forces that cannot be followed, of the operation, its states and stations; each key once, where it is met."""
    own = [(f"station[{index}]", station.force or ()) for index, station in enumerate(profile.stations)]
    shared = [("operation", operation.force), *own]
    asked = [(place, forces, operation.speed, "") for place, forces in shared]
    for index, state in enumerate(profile.operating_states):
        speed = state.speed or operation.speed
        at = f", at the {speed:g} r/min of duty[{index}]"
        kept = shared if state.force is None else shared[1:]
        asked += [(f"duty[{index}]", state.force or (), speed, "")]
        if speed != operation.speed and any(force.hangs_on_speed for _, forces in kept for force in forces):
            asked += [(place, forces, speed, at) for place, forces in kept]
    told: set[str] = set()
    for place, forces, speed, at in asked:
        for problem in _unfollowed(place, forces, speed, profile, setup):
            if problem.key not in told:
                told.add(problem.key)
                yield replace(problem, message=problem.message + at)


def _unfollowed(
    place: str, forces: tuple[Force, ...], speed: float, profile: Profile, setup: Setup
) -> Iterator[Problem]:
    """Forces that have no value somewhere along the ideal motion, looked at every half degree; tables of many rows, and
    expressions that swing as often.

    place: the table that they are of; speed: of the cam, r/min
    """
    if not forces:
        return
    from camgeom.mechanics.applied import moving

    rows = _rows(forces)
    turret = isinstance(profile.follower, TurretFollower)
    most, each = (MOST_TURRET_ROWS, A_SWING) if turret else (MOST_ROWS, 1)
    if rows > most:
        hint = "the force is followed from row to row, round all rollers that bear: fewer rows, or an expression"
        yield Problem(f"{place}.force", "has too many rows in its tables", rows, f"at most {most}", hint)
        return
    theta, omega = np.linspace(0.0, TURN, 721), speed * TURN / 60.0
    state = moving(setup.program, omega, theta)
    for index, force in enumerate(forces):
        key = f"{place}.force[{index}].expression"
        try:
            applied = force.applied(key)
            applied(theta, *state)
            swings = applied.followed(setup.program, omega).swings(setup.program, omega, most // each)
        except ProfileError as error:
            yield from error.problems
            continue
        if swings > most // each:
            hint = "each of its swings is followed, round all rollers that bear: let it swing less often in a turn"
            allowed = f"at most {most // each} panels of a turn follow it"
            yield Problem(key, "swings too often", force.expression, allowed, hint)
        which = _swinging(force)
        profile._swings[which] = max(profile._swings.get(which, 0), each * swings)


def _swinging(force: Force) -> Swinging:
    return force.expression, force.begin, force.until


def _rows(forces: tuple[Force, ...], swings: Mapping[Swinging, int] | None = None) -> int:
    """Of all tables together, and panels that follow how expressions swing."""
    return sum(len(force.table or ()) + (swings or {}).get(_swinging(force), 0) for force in forces)


def _followed(profile: Profile) -> int:
    """Pieces of the motions, rows of forces' tables and panels of their expressions that are followed, of every
    follower in every state."""
    total = 0
    for one in (profile, *(track.whole for track in profile.tracks)):
        own = one.operation.force if one.operation is not None else ()
        followers = [station.force or own for station in one.stations] + [own]
        states = [state.force for state in profile.operating_states] or [None]
        total += sum(one._pieces + _rows(force or mine, one._swings) for force in states for mine in followers)
    return total


def _folder_name(file: str) -> str:
    return str(Path(file).parent) if file else ""
