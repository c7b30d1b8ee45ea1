"""From segments to pieces: every problem of a program found at once, then the laws laid end to end."""

from __future__ import annotations

import math
from collections.abc import Sequence

from camgeom.errors import Problem, ProfileError
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
    problems = _problems(segments, start, closed, unit, key)
    if problems:
        raise ProfileError(problems)
    spans = _spans(segments, start, closed)
    pieces = tuple(_pieces(segment, span, unit, folder) for segment, span in zip(segments, spans, strict=True))
    return spans, pieces


def _problems(segments: Sequence[Segment], start: float, closed: bool, unit: float, key: str) -> list[Problem]:
    if not segments:
        return [Problem(key, "a program needs at least one segment")]
    found: list[Problem] = []
    previous, position = 0.0, start
    for i, segment in enumerate(segments):
        where = f"{key}[{i}]."
        found += _until_problems(segment, previous, i == len(segments) - 1, where)
        found += _law_problems(segment, unit, where)
        previous = segment.until if math.isfinite(segment.until) else previous
        position = segment.to if segment.to is not None else position
    slip = 1e-9 * max([abs(start), *(abs(s.to) for s in segments if s.to is not None)])
    if closed and not abs(position - start) <= slip:
        message = "the program must end where it began"
        found.append(Problem(f"{key}[{len(segments) - 1}].to", message, position / unit, f"{start / unit:.12g}"))
    return found


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


def _law_problems(segment: Segment, unit: float, where: str) -> list[Problem]:
    found: list[Problem] = []
    if segment.to is not None and not abs(segment.to) <= MOST_LIFT:
        found.append(Problem(where + "to", "no such position", segment.to / unit, f"{-MOST_LIFT:g} to {MOST_LIFT:g}"))
    if segment.law is None:
        if segment.to is not None:
            found.append(Problem(where + "law", "a segment with `to` needs a law", None, "a name from `camgeom laws`"))
        found += [Problem(where + name, "a dwell takes no such key") for name in dict(segment.params)]
        return found
    if segment.to is None:
        found.append(Problem(where + "to", "a segment with a law needs the position it reaches"))
    entry = LAWS.get(segment.law)
    if entry is None:
        return [*found, unknown_law(segment.law, where + "law")]
    params = dict(segment.params)
    problems = entry.problems(params, where)
    if not problems and not entry.joins:
        try:
            entry.make(params)
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


def _pieces(segment: Segment, span: Span, unit: float, folder: str) -> tuple[Piece, ...]:
    if segment.law is None:
        return (Piece(0.0, 1.0, 0.0, (span.before,)),)
    ends = Ends(lift=span.after - span.before, unit=unit, folder=folder)
    return placed(LAWS[segment.law].pieces(dict(segment.params), ends), span)


def placed(pieces: Sequence[Piece], span: Span) -> tuple[Piece, ...]:
    """The pieces moved to the span's position; one anchored at the end stands on the end position to the last digit."""
    *inner, last = (piece.scaled(1.0, span.before) for piece in pieces)
    return (*inner, Piece(last.start, last.end, last.anchor, (span.after, *last.power[1:]), last.waves))
