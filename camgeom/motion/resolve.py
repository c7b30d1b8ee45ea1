"""From segments to pieces: every problem of a program found at once, then the laws laid end to end."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from camgeom.errors import Problem, ProfileError
from camgeom.motion.joining import all_ends, pin_problems
from camgeom.motion.law import Ends
from camgeom.motion.laws import LAWS, unknown_law
from camgeom.motion.piece import Piece
from camgeom.motion.segment import TURN, Segment, Span

LEAST_WIDTH = math.radians(1e-9)
MOST_LIFT = 1e5
ANGLE_SLIP = 1e-9
"""rad; an end this near to a full turn is the full turn"""


def resolve(
    segments: Sequence[Segment], start: float, closed: bool, unit: float, folder: str, key: str
) -> tuple[tuple[Span, ...], tuple[tuple[Piece, ...], ...]]:
    """The spans and the pieces (lift over unit travel) of each segment; raises ProfileError with every problem."""
    problems = _problems(segments, start, closed, unit, folder, key)
    if problems:
        raise ProfileError(problems)
    spans = _spans(segments, start, closed)
    ends = all_ends(segments, spans, unit, folder, key)
    return spans, tuple(_pieces(*row) for row in zip(segments, spans, ends, strict=True))


def _problems(
    segments: Sequence[Segment], start: float, closed: bool, unit: float, folder: str, key: str
) -> list[Problem]:
    if not segments:
        return [Problem(key, "a program needs at least one segment")]
    found: list[Problem] = []
    if not abs(start) <= MOST_LIFT:
        found.append(Problem(key, "no such start position", start / unit, _lift_range(unit)))
        start = 0.0
    previous, position = 0.0, start
    for i, segment in enumerate(segments):
        where = f"{key}[{i}]."
        found += _until_problems(segment, previous, i == len(segments) - 1, where)
        previous = segment.until if math.isfinite(segment.until) else previous
        reached = segment.to if segment.to is not None else position
        bad_lift = not abs(reached) <= MOST_LIFT
        if bad_lift:
            found.append(Problem(where + "to", "no such position", reached / unit, _lift_range(unit)))
            reached = position
        ends = Ends(lift=reached - position, unit=unit, folder=folder)
        found += _law_problems(segment, ends, where)
        position = reached
    slip = 1e-9 * max(abs(start), *(abs(s.to) for s in segments if s.to is not None), 0.0)
    if closed and not bad_lift and abs(position - start) > slip:
        message = "the program must end where it began"
        found.append(Problem(f"{key}[{len(segments) - 1}].to", message, position / unit, f"{start / unit:.12g}"))
    return found or pin_problems(segments, key)


def _lift_range(unit: float) -> str:
    return f"{-MOST_LIFT / unit:.6g} to {MOST_LIFT / unit:.6g}"


def _until_problems(segment: Segment, previous: float, last: bool, where: str) -> list[Problem]:
    until = segment.until
    shown = math.degrees(until) if math.isfinite(until) else until
    if not math.isfinite(until) or until - previous < LEAST_WIDTH:
        message = "each segment must end after the one before it"
        allowed = f"above {math.degrees(previous):.12g} by 1e-9 degrees, up to 360"
        return [Problem(where + "until", message, shown, allowed)]
    if last and abs(until - TURN) > ANGLE_SLIP:
        return [Problem(where + "until", "the last segment must end the turn", shown, "360")]
    if not last and until > TURN - LEAST_WIDTH:
        return [Problem(where + "until", "only the last segment may end the turn", shown, "below 360")]
    return []


def _law_problems(segment: Segment, ends: Ends, where: str) -> list[Problem]:
    found: list[Problem] = []
    if segment.law is None:
        if segment.to is not None:
            found.append(Problem(where + "law", "a segment with `to` needs a law", None, "a name from `camgeom laws`"))
        return found + [Problem(where + name, "a dwell takes no such key") for name in dict(segment.params)]
    if segment.to is None:
        found.append(Problem(where + "to", "a segment with a law needs the position it reaches"))
    if segment.law not in LAWS:
        return [*found, unknown_law(segment.law, where + "law")]
    entry, params = LAWS[segment.law], dict(segment.params)
    problems = entry.problems(params, where)
    if not problems:
        try:
            entry.pieces(params, ends)
        except ProfileError as error:
            problems = [Problem(where + p.key, p.message, p.value, p.allowed, p.hint) for p in error.problems]
    return found + problems


def _spans(segments: Sequence[Segment], start: float, closed: bool) -> tuple[Span, ...]:
    spans: list[Span] = []
    angle, position = 0.0, start
    for i, segment in enumerate(segments):
        last = i == len(segments) - 1
        end = TURN if last else segment.until
        after = position if segment.to is None else segment.to
        # A closed program ends on the very number it began with.
        after = start if last and closed else after
        spans.append(Span(angle, end, position, after, segment.law or "dwell"))
        angle, position = end, after
    return tuple(spans)


def _pieces(segment: Segment, span: Span, ends: Ends) -> tuple[Piece, ...]:
    """The segment's pieces in its place; the last, anchored at its end, stands there to the last digit."""
    if segment.law is None:
        return (Piece(0.0, 1.0, 0.0, (span.before,)),)
    *inner, last = (piece.scaled(1.0, span.before) for piece in LAWS[segment.law].pieces(dict(segment.params), ends))
    return (*inner, replace(last, power=(span.after, *last.power[1:])))
