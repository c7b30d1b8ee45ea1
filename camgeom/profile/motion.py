"""The [[motion]] tables: law parameters, what a sequence of segments must fulfil, and the program they make."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from math import pi, radians
from pathlib import Path
from typing import Any

from camgeom.errors import Problem, ProfileError, did_you_mean
from camgeom.motion.catalogue import LAWS, entry
from camgeom.motion.law import Ends, LawEntry
from camgeom.motion.program import Program
from camgeom.motion.segment import Segment
from camgeom.profile.errors import UNKNOWN, Sections, choice_problem, keys_of, plain
from camgeom.profile.sections import MotionSegment
from camgeom.profile.text import beside
from camgeom.track.follower import AnyFollower, TurretFollower

MAX_SEGMENTS = 3_000
"""a whole run of a disc with so many takes some 20 s; a law of a table or a spline holds more points"""
SLIP = 1e-6
"""deg; digits lost by writing 360 / 7 in decimal"""
OUT_OF_RANGE = "out of range"
LEAST_SHARE = 1e-9
"""of the stroke, that a segment over the travel takes at least"""
RATES = ("velocity", "acceleration", "jerk")
IN_TIME = ("residual_limit", "band", "natural_frequency", "speeds", "damping")
"""keys of the best law without a meaning over a travel, whose segments do not last in proportion to their lengths"""


def split_segment(
    segment: dict[str, Any], at: str, folder: Path | None, sections: Sections
) -> tuple[dict[str, Any], list[Problem]]:
    """A [[motion]] table with the law's own keys gathered under `parameters`, and what is wrong with them."""
    known = keys_of(MotionSegment)
    own = {key: value for key, value in segment.items() if key in known}
    extra = {key: value for key, value in segment.items() if key not in known}
    law = own.get("law")
    if law is None:
        return own, [_stray(key, value, at, None, sections) for key, value in extra.items()]
    if law not in LAWS if isinstance(law, str) else True:
        return own, [choice_problem(f"{at}.law", plain(law), tuple(sorted(LAWS)), "a motion law")]
    found: list[Problem] = []
    law_entry = entry(law)
    for key, value in list(extra.items()):
        if key not in law_entry.parameters:
            found.append(_stray(key, value, at, law_entry, sections))
            del extra[key]
    found += law_entry.problems(extra, f"{at}.")
    if law_entry.lacks(extra):
        message = f"is missing: law = {law!r} is made of data"
        found.append(Problem(f"{at}.{law_entry.data[0]}", message, None, _data(law_entry)))
    if isinstance(name := extra.get("file"), str) and name:
        place = beside(name, folder, f"{at}.file")
        rows = _rows_of(place, f"{at}.file") if isinstance(place, Path) and "rows" in law_entry.parameters else place
        if isinstance(rows, Problem):
            found.append(rows)
        elif extra.get("rows"):
            found.append(Problem(f"{at}.rows", "a table is either a file or rows, not both", None, "one of them"))
        elif isinstance(rows, tuple):
            del extra["file"]
            extra["rows"], own["rows_from"] = rows, name
    return {**own, "parameters": tuple(extra.items())}, found


def _data(law: LawEntry) -> str:
    return " or ".join(f"`{key}`: {law.parameters[key].help}" for key in law.data)


def _rows_of(place: Path, key: str) -> tuple[tuple[float, ...], ...] | Problem:
    """The rows of a segment's file, read once: what becomes of the file later is nothing to the profile."""
    from camgeom.motion.measured import file_rows

    try:
        return tuple(file_rows(place))
    except ProfileError as error:
        return replace(error.problems[0], key=key)


def _stray(key: str, value: object, at: str, law: LawEntry | None, sections: Sections) -> Problem:
    """The problem of a key that is neither a segment's nor the law's."""
    hint = did_you_mean(key, [*keys_of(MotionSegment), *(law.parameters if law else ())])
    # A share of a segment is that of a law, never that of an operating state.
    places = [name for name, models in sections.items()
              if name != "duty" and any(key in keys_of(model) for model in models)]  # fmt: skip
    if not hint and places:
        hint = f"did you mean [{places[0]}] {key}?"
    takes = f"parameters of {law.name}: {', '.join(law.parameters) or 'none'}" if law else "a dwell has no parameters"
    return Problem(f"{at}.{key}", UNKNOWN, plain(value), "", hint or takes)


def motion_problems(
    motion: Sequence[MotionSegment], follower: AnyFollower, span: float, travel: float | None = None
) -> list[Problem]:
    """What a program cannot know of its segments: half turns, whole turret indexes, the travel of a cam that slides.

    span: the stated range, deg; travel: mm, in place of it
    """
    problems = [
        Problem(f"motion[{i}].{key}", "a dwell has none", getattr(segment, key), "", "give it a `to` and a law")
        for i, segment in enumerate(motion)
        if segment.to is None
        for key in RATES
        if getattr(segment, key) is not None
    ]
    last = len(motion) - 1
    if travel is not None:
        return problems + _travel_problems(motion, travel) + _timed_problems(motion)
    if beyond := [Problem(f"motion[{i}].until", OUT_OF_RANGE, segment.until, "more than 0 and at most 360 deg")
                  for i, segment in enumerate(motion) if segment.until > 360.0]:  # fmt: skip
        return problems + beyond
    if span < 360.0 and abs(motion[last].until - span) > SLIP:
        message = "the last segment must end the stated half turn"
        problems.append(Problem(f"motion[{last}].until", message, motion[last].until, f"{span:g} deg"))
    if isinstance(follower, TurretFollower):
        problems += _index_problems(motion, 360.0 / follower.stops, follower.stops)
    return problems


def _travel_problems(motion: Sequence[MotionSegment], travel: float) -> list[Problem]:
    """Ends of segments, mm of travel, that do not follow on one another up to the stroke."""
    found, previous, least = list[Problem](), 0.0, travel * LEAST_SHARE
    for i, segment in enumerate(motion):
        if segment.until - previous < least:
            allowed = f"above {previous:g} mm of travel, up to the stroke of {travel:g} mm"
            found.append(Problem(f"motion[{i}].until", "each segment must end after the one before it", segment.until,
                                 allowed))  # fmt: skip
        previous = segment.until
        if i < len(motion) - 1 and segment.until > travel - least:
            message = "only the last segment may end the stroke"
            found.append(Problem(f"motion[{i}].until", message, segment.until, f"below {travel:g} mm, cam.stroke"))
    if abs(previous - travel) > least:
        message = "the last segment must end the stroke"
        found.append(Problem(f"motion[{len(motion) - 1}].until", message, previous, f"{travel:g} mm, cam.stroke"))
    return found


def _timed_problems(motion: Sequence[MotionSegment]) -> list[Problem]:
    """Keys of best laws over the travel that ask for a vibration, which swings in time."""
    message = "a linear cam's motion stands over its plate's travel, which does not go evenly in time"
    advice = "leave it out: limits of velocity, acceleration and jerk are of the travel, [dynamics] tells what vibrates"
    return [
        Problem(f"motion[{i}].{key}", message, plain(value), "", advice)
        for i, segment in enumerate(motion)
        if segment.law == "optimal"
        for key, value in segment.parameters
        if (key in IN_TIME and value) or (key == "minimise" and value == "residual")
    ]


def _index_problems(motion: Sequence[MotionSegment], index: float, stops: int) -> list[Problem]:
    moves = [(i, segment.to) for i, segment in enumerate(motion) if segment.to is not None]
    if not moves:
        return [Problem("motion", "a turret needs a segment that turns it on", None, f"`to` = {index:.12g} deg")]
    if far := [Problem(f"motion[{i}].to", "a turret turns by one whole turn at most", to, "-360 to 360 deg")
               for i, to in moves if abs(to) > 360.0 + SLIP]:
        return far
    i, end = moves[-1]
    steps = round(end / index)
    if abs(end) <= SLIP and any(abs(to) > SLIP for _, to in moves):
        return []  # a drive to and fro
    if steps == 0 or abs(end - steps * index) > SLIP:
        allowed = f"a whole multiple of 360 / {stops} = {index:.12g} deg"
        return [Problem(f"motion[{i}].to", "the motion must step by whole indexes of the turret", end, allowed)]
    return []


def program_of(
    motion: Sequence[MotionSegment], follower: AnyFollower, span: float, folder: str, travel: float | None = None,
    beside: int = 1,
) -> Program:
    """The motion program, mm or rad over rad of cam angle; of a cam that slides its turn is the travel, mm. `beside`:
    of how many programs of the cam best laws share what their search may cost.

    Where the profile states half a turn the other half mirrors it: s(theta + pi) = lift - s(theta). Raises
    ProfileError with every problem of the segments.
    """
    turning = follower.rotating
    unit = radians(1.0) if turning else 1.0
    one = 360.0 / travel if travel is not None else 1.0
    segments = [_segment(segment, unit, one, i == len(motion) - 1) for i, segment in enumerate(motion)]
    if span == 180.0:
        lift = next((segment.to for segment in reversed(segments) if segment.to is not None), 0.0)
        segments += [_mirrored(segment, lift) for segment in segments]
    turret = isinstance(follower, TurretFollower)
    if turret:
        segments = _on_whole_indexes(segments, 2.0 * pi / follower.stops)  # type: ignore[union-attr]
    try:
        closed = not turret and travel is None
        return Program.from_segments(segments, closed=closed, angular=turning, folder=folder, beside=beside)
    except ProfileError as refused:
        raise ProfileError([_as_written(problem, motion) for problem in refused.problems], refused.file) from None
    except ArithmeticError as error:
        # Parameters within their ranges can still be too extreme together (a share of 1e-300).
        message = f"the parameters of the law give no finite motion ({error})"
        raise ProfileError([Problem(at, message) for at in _extreme(segments)]) from None


def _as_written(problem: Problem, motion: Sequence[MotionSegment]) -> Problem:
    """The problem with the rate that the profile gives, per degree, in place of that per radian; of rows that were read
    from a file, of that."""
    named = re.fullmatch(rf"motion\[(\d+)\]\.({'|'.join(RATES)}|rows)", problem.key)
    if named is None or int(named[1]) >= len(motion):
        return problem
    if named[2] == "rows":
        return replace(problem, key=f"motion[{named[1]}].file") if motion[int(named[1])].rows_from else problem
    return replace(problem, value=getattr(motion[int(named[1])], named[2]))


def _extreme(segments: Sequence[Segment]) -> list[str]:
    """The keys of the segments whose law has no finite motion of its own; all of the motion where each alone has."""
    found = []
    for i, segment in enumerate(segments):
        if segment.law is not None:
            try:
                entry(segment.law).pieces(dict(segment.params), Ends(lift=1.0))
            except ArithmeticError:
                found.append(f"motion[{i}]")
            except ProfileError:
                continue  # a law that needs its neighbours or its file
    return found or ["motion"]


def _segment(segment: MotionSegment, unit: float, one: float, last: bool) -> Segment:
    """A segment in radians and inner units of lift; derivatives per degree become derivatives per radian.

    one: degrees of what `until` counts in, 1 or those of a mm of travel
    """
    degree = radians(one)
    rates = [getattr(segment, key) for key in RATES]
    velocity, acceleration, jerk = (
        None if rate is None else rate * unit / degree**order for order, rate in enumerate(rates, 1)
    )
    until = 2.0 * pi if (last if one != 1.0 else segment.until == 360.0) else radians(segment.until * one)
    to = None if segment.to is None else segment.to * unit
    return Segment(until, to, segment.law, segment.parameters, velocity, acceleration, jerk)


def _mirrored(segment: Segment, lift: float) -> Segment:
    """The segment half a turn later, s(theta + pi) = lift - s(theta)."""
    to = None if segment.to is None else lift - segment.to
    rates = {key: -rate for key in RATES if (rate := getattr(segment, key)) is not None}
    return replace(segment, until=segment.until + pi, to=to, **rates)


def _on_whole_indexes(segments: list[Segment], index: float) -> list[Segment]:
    """The last position set on the exact multiple of the index, so that the error does not add up turn by turn."""
    i = max((i for i, segment in enumerate(segments) if segment.to is not None), default=-1)
    if i < 0:
        return segments  # no index at all, which `motion_problems` says
    end = segments[i].to or 0.0
    return [*segments[:i], replace(segments[i], to=round(end / index) * index), *segments[i + 1 :]]
