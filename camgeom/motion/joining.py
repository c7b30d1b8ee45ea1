"""What joining segments take over: the state of a moving neighbour, or the smoothest state two of them can share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np

from camgeom.errors import Problem, ProfileError
from camgeom.motion.curve import ParamValue
from camgeom.motion.law import Ends, LawEntry
from camgeom.motion.laws import LAWS
from camgeom.motion.piece import Piece
from camgeom.motion.segment import Segment, Span
from camgeom.motion.table import Floats

HIGHEST = 3
"""Derivatives that can be carried over: velocity, acceleration, jerk."""
Pieces = tuple[Piece, ...]


def join_order(segment: Segment) -> int:
    """How many derivatives the segment takes over from its neighbours; 0 for a dwell or a law of its own shape."""
    if segment.law is None or not LAWS[segment.law].joins:
        return 0
    return _order(LAWS[segment.law], dict(segment.params))


def _order(entry: LawEntry, params: Mapping[str, ParamValue]) -> int:
    return int(params["order"] if "order" in params else entry.parameters["order"].default)


def pinned(segment: Segment) -> list[float | None]:
    """The state that the user fixed at the segment's end: velocity, acceleration, jerk per rad."""
    return [segment.velocity, segment.acceleration, segment.jerk]


def all_ends(segments: Sequence[Segment], spans: Sequence[Span], unit: float, folder: str, key: str) -> list[Ends]:
    """The `Ends` of every segment, derivatives per unit travel; knot i is where segment i begins.

    Where a joining segment meets a dwell or a law of its own shape, it takes over that state. Where two joining
    segments meet, what the user did not fix is chosen so that as many further derivatives are continuous.
    """
    orders = [join_order(segment) for segment in segments]
    widths = [span.end - span.start for span in spans]
    states = np.zeros((len(segments), HIGHEST))
    unknown: list[tuple[int, int]] = []
    for knot, order in enumerate(orders):
        before = knot - 1
        if order and orders[before]:
            fixed = pinned(segments[before])
            for r in range(max(order, orders[before])):
                value = fixed[r]
                if value is None:
                    unknown.append((knot, r + 1))
                else:
                    states[knot, r] = value
        elif order or orders[before]:
            owner, at = (before, 1.0) if order else (knot, 0.0)
            states[knot] = _own_state(segments[owner], spans[owner], at)
    lifts = [span.after - span.before for span in spans]
    if unknown:
        shared = _Shared(segments, orders, widths, lifts, unit, folder)
        for (knot, r), value in zip(unknown, shared.solve(states, unknown, key), strict=True):
            states[knot, r - 1] = value
    powers = np.arange(1, HIGHEST + 1)
    after = np.roll(states, -1, axis=0)
    return [
        Ends(lift, tuple((start * w**powers).tolist()), tuple((end * w**powers).tolist()), unit, folder)
        for lift, w, start, end in zip(lifts, widths, states, after, strict=True)
    ]


def _own_state(segment: Segment, span: Span, at: float) -> Floats:
    """Velocity, acceleration and jerk per rad with which a dwell or a law of its own shape begins or ends."""
    if segment.law is None:
        return np.zeros(HIGHEST)
    pieces = LAWS[segment.law].pieces(dict(segment.params), Ends(lift=span.after - span.before))
    piece = pieces[-1] if at == 1.0 else pieces[0]
    return np.array([piece.value(at, r) / (span.end - span.start) ** r for r in range(1, HIGHEST + 1)])


class _Shared:
    """The linear equations for the states that joining segments share."""

    def __init__(
        self,
        segments: Sequence[Segment],
        orders: Sequence[int],
        widths: Sequence[float],
        lifts: Sequence[float],
        unit: float,
        folder: str,
    ) -> None:
        self.orders, self.widths = orders, widths
        self.responses = {
            i: response(LAWS[segment.law], dict(segment.params), lift, unit, folder)
            for i, (segment, lift) in enumerate(zip(segments, lifts, strict=True))
            if segment.law is not None and orders[i]
        }

    def solve(self, states: Floats, unknown: Sequence[tuple[int, int]], key: str) -> list[float]:
        """The unknown states, each (knot, order), per rad^order; raises ProfileError where they are not determined."""
        place = {pair: i for i, pair in enumerate(unknown)}
        count = len(self.orders)
        # Widths may differ by many powers of ten: each knot is scaled by the shorter of its two segments.
        reach = [min(self.widths[knot - 1], self.widths[knot]) for knot in range(count)]
        matrix, right = np.zeros((len(unknown), len(unknown))), np.zeros(len(unknown))
        taken = dict.fromkeys(range(count), 0)
        for row, (knot, _) in enumerate(unknown):
            taken[knot] += 1
            r = min(self.orders[knot - 1], self.orders[knot]) + taken[knot]
            for segment, end, sign in ((knot - 1) % count, 1, 1.0), (knot, 0, -1.0):
                width, order = self.widths[segment], self.orders[segment]
                base, columns = self.responses[segment]
                factor = sign * (reach[knot] / width) ** r
                right[row] -= factor * base[end, r - 1]
                for j in range(2 * order):
                    other, k = (segment if j < order else (segment + 1) % count), j % order + 1
                    gain = factor * columns[end, r - 1, j] * width**k
                    if (other, k) in place:
                        matrix[row, place[other, k]] += gain / reach[other] ** k
                    else:
                        right[row] -= gain * states[other, k - 1]
        try:
            scaled = np.linalg.solve(matrix, right)
        except np.linalg.LinAlgError:
            message = "the joining segments leave their common velocity undetermined"
            raise ProfileError([Problem(key, message, None, "fix `velocity` at one of their ends")]) from None
        return [float(value) / reach[knot] ** r for value, (knot, r) in zip(scaled, unknown, strict=True)]


def response(
    entry: LawEntry, params: dict[str, ParamValue], lift: float, unit: float, folder: str
) -> tuple[Floats, Floats]:
    """How the derivatives 1..6 at both ends answer: at rest there (2, 6), and per unit end state (2, 6, 2 order).

    All joining laws are linear in the lift and the end states; those without data scale with the lift as well.
    """
    given = any(parameter.kind in ("list", "text") for parameter in entry.parameters.values())
    base, columns = _response(entry, tuple(params.items()), lift if given else 1.0, unit, folder)
    return (base if given else base * lift), columns


@lru_cache(maxsize=256)
def _response(
    entry: LawEntry, params: tuple[tuple[str, ParamValue], ...], lift: float, unit: float, folder: str
) -> tuple[Floats, Floats]:
    values = dict(params)
    order = _order(entry, values)

    def answer(ends: Ends) -> Floats:
        pieces = entry.pieces(values, ends)
        sides = ((pieces[0], 0.0), (pieces[-1], 1.0))
        return np.array([[piece.value(at, r) for r in range(1, 2 * HIGHEST + 1)] for piece, at in sides])

    base = answer(Ends(lift=lift, unit=unit, folder=folder))
    size = max(1.0, abs(lift))
    columns = []
    for j in range(2 * order):
        push = [size if i == j % order else 0.0 for i in range(HIGHEST)]
        still = [0.0] * HIGHEST
        start, end = (push, still) if j < order else (still, push)
        columns.append((answer(Ends(lift, tuple(start), tuple(end), unit, folder)) - base) / size)
    return base, np.stack(columns, axis=-1)


def pin_problems(segments: Sequence[Segment], key: str) -> list[Problem]:
    """States fixed where no two joining segments meet: there the neighbour's own motion decides."""
    found = []
    cycle = [*segments, segments[0]]
    for i, (segment, following) in enumerate(pairwise(cycle)):
        carried = max(join_order(segment), join_order(following))
        both = join_order(segment) > 0 and join_order(following) > 0
        for r, (name, value) in enumerate(zip(("velocity", "acceleration", "jerk"), pinned(segment), strict=True)):
            if value is None:
                continue
            where = f"{key}[{i}].{name}"
            if not abs(value) < 1e30:
                found.append(Problem(where, "not a finite number", value))
            elif not both:
                found.append(Problem(where, "only where two joining laws meet can a state be chosen", value))
            elif r >= carried:
                found.append(Problem(where, f"these laws carry over {carried} derivatives", value, "a larger `order`"))
    return found
