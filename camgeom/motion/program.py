"""The motion round the cam: dwells and lawful segments laid end to end; periodic jets, knots, continuity, peaks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple, final

import numpy as np
import numpy.typing as npt

from camgeom.errors import Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import TURN as TURN
from camgeom.maths import Floats, distinct
from camgeom.maths.frozen import cached_property
from camgeom.motion.catalogue import LAWS, unknown_law
from camgeom.motion.law import ORDER_LIMIT, Ends, lowest_jump
from camgeom.motion.segment import Segment, Span
from camgeom.motion.table import Peak, Piece, PieceTable, Side

if TYPE_CHECKING:
    from camgeom.motion.optimal.best import Best

LEAST_WIDTH = math.radians(1e-9)
MOST_LIFT = 1e5
ANGLE_SLIP = 1e-9
"""rad; an end this near to a full turn is the full turn"""


class Jump(NamedTuple):
    """A step in a derivative of the lift: cam angle (rad), order (0 lift ... 3 jerk), size (lift per rad^order)."""

    angle: float
    order: int
    size: float


class Continuity(NamedTuple):
    """How smooth a program is: the highest derivative that is continuous all round, and every jump up to the jerk."""

    order: int
    jumps: tuple[Jump, ...]


@final
@immutable
class Program:
    """The follower's motion over the cam angle, periodic; lift in mm or rad, angles in rad.

    `advance` is what the lift grows by in each turn (the index angle of a turret; 0 for a closed program). `path`: the
    program over a travel that this one is composed of, whose laws are the user's.

    >>> from camgeom.motion import Program, Segment
    >>> rise, rest = Segment(math.pi, 10.0, "cycloidal"), Segment(1.5 * math.pi, 0.0, "3-4-5")
    >>> program = Program.from_segments([rise, rest, Segment(2 * math.pi)])
    >>> program.jet(math.pi / 2, order=1).round(6)
    array([5.      , 6.366198])
    """

    segments: tuple[Segment, ...]
    spans: tuple[Span, ...]
    pieces: tuple[tuple[Piece, ...], ...]
    advance: float = 0.0
    ends: tuple[Ends, ...] = ()
    path: Program | None = None

    @classmethod
    def from_segments(
        cls,
        segments: Sequence[Segment],
        start: float = 0.0,
        *,
        closed: bool = True,
        angular: bool = False,
        folder: str = "",
        key: str = "motion",
        beside: int = 1,
    ) -> Program:
        """The program that begins at `start` (mm or rad) and runs through the segments, the last until 2 pi.

        closed=False lets it end elsewhere and repeat from there (a turret). `angular` says that lifts are angles, shown
        in degrees in messages; `folder` is where relative file names start; `beside` the programs of the cam that have
        best laws. Raises ProfileError with every problem found, named `motion[i].key`.
        """
        unit = math.radians(1.0) if angular else 1.0
        spans, ends, pieces = _resolve(segments, start, closed, unit, folder, key, beside)
        advance = 0.0 if closed else spans[-1].after - start
        return cls(tuple(segments), spans, pieces, advance, ends)

    @property
    def closed(self) -> bool:
        """Whether the follower is back at its start after one turn."""
        return self.advance == 0.0

    @cached_property
    def table(self) -> PieceTable:
        """All pieces over one turn as arrays, in rad of cam angle."""
        edges, anchors, rates = [0.0], list[float](), list[float]()
        for span, pieces in zip(self.spans, self.pieces, strict=True):
            width = span.end - span.start
            for piece in pieces:
                edges.append(span.end if piece.end == 1.0 else span.start + piece.end * width)
                anchors.append(span.end if piece.anchor == 1.0 else span.start + piece.anchor * width)
            rates.extend([1.0 / width] * len(pieces))
        rows = [piece for pieces in self.pieces for piece in pieces]
        return PieceTable(np.array(edges), np.array(anchors), np.array(rates), rows)

    def jet(self, theta: npt.ArrayLike, order: int = 3, side: Side = "right") -> Floats:
        """Lift (mm or rad) and its derivatives per rad of cam angle, (order + 1, *theta.shape), at any real theta.

        At a knot the right-hand limit is given, or the left-hand one with side="left". Raises ValueError where an angle
        is not finite.
        """
        angle = np.asarray(theta, dtype=float)
        flat = angle.ravel()
        if not np.isfinite(flat).all():
            raise ValueError("cam angles must be finite")
        turns = np.floor(flat / TURN) if side == "right" else np.ceil(flat / TURN) - 1.0
        # Rounding may leave an angle a hair outside its turn; it belongs to the turn's end.
        local = np.clip(flat - turns * TURN, 0.0, TURN)
        out = self.table.jet(local, order, side)
        if self.advance:
            out[0] += turns * self.advance
        return out.reshape(order + 1, *angle.shape)

    @cached_property
    def knots(self) -> Floats:
        """Cam angles (rad) from 0 to 2 pi where some derivative may jump: segment ends and breaks inside the laws."""
        ends = np.array([0.0, *(span.end for span in self.spans)])
        knots = distinct(np.concatenate([ends, self.table.edges[1:-1][self._lowest_jumps[1:] <= ORDER_LIMIT]]))
        knots.setflags(write=False)
        return knots

    @cached_property
    def _steps(self) -> Floats:
        """The steps (ORDER_LIMIT + 1, p) in lift and derivatives at each piece's beginning; 0 where there is none."""
        after = np.arange(len(self.table))
        before = np.roll(after, 1)
        return self.table.steps(before, after, ORDER_LIMIT, self.advance)

    @cached_property
    def _lowest_jumps(self) -> npt.NDArray[np.intp]:
        return lowest_jump(self._steps)

    @cached_property
    def continuity(self) -> Continuity:
        """The order of continuity (counted up to 9) and the jumps of lift, velocity, acceleration and jerk."""
        angles = self.table.edges[:-1]
        piece, order = np.nonzero(self._steps[:4].T)
        sizes = self._steps[order, piece]
        jumps = tuple(Jump(float(angles[p]), int(r), float(v)) for p, r, v in zip(piece, order, sizes, strict=True))
        return Continuity(int(min(self._lowest_jumps.min() - 1, ORDER_LIMIT)), jumps)

    @cached_property
    def best_laws(self) -> tuple[tuple[int, Best], ...]:
        """The segments whose law is the best for a requirement, each with its least value and bound, normalised."""
        if self.path is not None:
            return self.path.best_laws
        if not any(segment.law == "optimal" for segment in self.segments):
            return ()
        from camgeom.motion.laws_optimal import best_law

        return tuple(
            (i, best_law(ends, **LAWS["optimal"].complete(dict(segment.params))))
            for i, (segment, ends) in enumerate(zip(self.segments, self.ends, strict=True))
            if segment.law == "optimal"
        )

    @property
    def best_over(self) -> str:
        """What the values and bounds of `best_laws` stand over, in words."""
        held = " of the plate, not of the follower in time" if self.path is not None else ""
        return f"unit lift over unit travel{held}"

    def peak(self, order: int) -> Peak:
        """The extreme (signed; lift per rad^order) of a derivative and its cam angle (rad), refined to rounding."""
        return self.table.derivative_peak(order)

    def extremes(self, order: int) -> tuple[Peak, Peak]:
        """The least and the greatest of a derivative (lift per rad^order), each with its cam angle (rad)."""
        return self.table.derivative_extremes(order)

    def mean_square(self, order: int = 2) -> float:
        """The mean square of a derivative over the turn, (lift per rad^order)²; exact up to rounding."""
        return self.table.mean_square(order)


def _resolve(
    segments: Sequence[Segment], start: float, closed: bool, unit: float, folder: str, key: str, beside: int
) -> tuple[tuple[Span, ...], tuple[Ends, ...], tuple[tuple[Piece, ...], ...]]:
    """Spans, ends and pieces (lift over unit travel) of each segment; raises ProfileError with every problem."""
    problems = _problems(segments, start, closed, unit, folder, key)
    if problems:
        raise ProfileError(problems)
    spans = _spans(segments, start, closed)
    if _stand_alone(segments):
        ends = [
            Ends(span.after - span.before, unit=unit, folder=folder, turn=(span.end - span.start) / TURN)
            for span in spans
        ]
    else:
        from camgeom.motion.joining import all_ends

        ends = all_ends(segments, spans, unit, folder, key)
    best = beside * sum(segment.law == "optimal" for segment in segments)
    ends = [replace(one, best=max(best, 1)) for one in ends]
    pieces: list[tuple[Piece, ...]] = []
    for i, row in enumerate(zip(segments, spans, ends, strict=True)):
        try:
            pieces.append(_pieces(*row))
        except ProfileError as error:
            problems += _placed(error, f"{key}[{i}].")
    if problems:
        raise ProfileError(problems)
    return spans, tuple(ends), tuple(pieces)


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
    if found or _stand_alone(segments):
        return found
    from camgeom.motion.joining import pin_problems

    return pin_problems(segments, key)


def _stand_alone(segments: Sequence[Segment]) -> bool:
    """Whether every law has a shape of its own and no state is fixed, so that no segment asks its neighbours."""
    return not any(
        (segment.law is not None and LAWS[segment.law].joins)
        or any(state is not None for state in (segment.velocity, segment.acceleration, segment.jerk))
        for segment in segments
    )


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
    # What does not answer linearly to its ends can only be judged between those that it gets.
    if not problems and not entry.stand_in:
        try:
            entry.pieces(params, ends)
        except ProfileError as error:
            problems = _placed(error, where)
    return found + problems


def _placed(error: ProfileError, where: str) -> list[Problem]:
    """The problems of a law as those of its segment."""
    return [Problem(where + p.key, p.message, p.value, p.allowed, p.hint) for p in error.problems]


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
