"""What joining segments take over: the state of a moving neighbour, or the smoothest state two of them can share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np

from camgeom.errors import Problem, ProfileError
from camgeom.maths import TURN, Floats
from camgeom.motion.catalogue import LAWS
from camgeom.motion.law import Ends, LawEntry, ParamValue
from camgeom.motion.segment import Segment, Span

HIGHEST = 3
"""Derivatives that can be carried over: velocity, acceleration, jerk."""


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
    free: dict[int, list[int]] = {}
    for knot, order in enumerate(orders):
        before = knot - 1
        if order and orders[before]:
            chosen = pinned(segments[before])[: max(order, orders[before])]
            states[knot, : len(chosen)] = [0.0 if value is None else value for value in chosen]
            if None in chosen:
                free[knot] = [r for r, value in enumerate(chosen, 1) if value is None]
        elif order or orders[before]:
            owner, at = (before, 1.0) if order else (knot, 0.0)
            states[knot] = _own_state(segments[owner], spans[owner], at)
    lifts = [span.after - span.before for span in spans]
    if free:
        _Shared(segments, orders, widths, lifts, free, unit, folder).solve(states, key)
    p = np.arange(1, HIGHEST + 1)
    after = np.roll(states, -1, axis=0)
    following = [(i + 1) % len(segments) for i in range(len(segments))]
    shared = [i in free or following[i] in free for i in range(len(segments))]
    return [
        Ends(lift, tuple((start * w**p).tolist()), tuple((end * w**p).tolist()), unit, folder, sought, w / TURN)
        for lift, w, start, end, sought in zip(lifts, widths, states, after, shared, strict=True)
    ]


def _linear(segment: Segment) -> tuple[LawEntry, dict[str, ParamValue]]:
    """The law that a shared state is sought with, and its parameters: the segment's, or the one that stands in."""
    entry, params = LAWS[segment.law or ""], dict(segment.params)
    return (LAWS[entry.stand_in], {"order": _order(entry, params)}) if entry.stand_in else (entry, params)


def _own_state(segment: Segment, span: Span, at: float) -> Floats:
    """Velocity, acceleration and jerk per rad with which a dwell or a law of its own shape begins or ends."""
    if segment.law is None:
        return np.zeros(HIGHEST)
    pieces = LAWS[segment.law].pieces(dict(segment.params), Ends(lift=span.after - span.before))
    piece = pieces[-1] if at == 1.0 else pieces[0]
    return np.array([piece.value(at, r) / (span.end - span.start) ** r for r in range(1, HIGHEST + 1)])


class _Shared:
    """The linear equations for the states that joining segments share, a block of rows and columns a knot."""

    def __init__(
        self,
        segments: Sequence[Segment],
        orders: Sequence[int],
        widths: Sequence[float],
        lifts: Sequence[float],
        free: Mapping[int, Sequence[int]],
        unit: float,
        folder: str,
    ) -> None:
        self.orders, self.widths, self.free = orders, widths, free
        self.responses = {
            i: response(*_linear(segment), lift, unit, folder)
            for i, (segment, lift) in enumerate(zip(segments, lifts, strict=True))
            if segment.law is not None and orders[i] and (i in free or (i + 1) % len(segments) in free)
        }

    def solve(self, states: Floats, key: str) -> None:
        """Fill in the free derivatives of each knot (orders by knot), per rad^order; ProfileError if undetermined."""
        free = self.free
        # Widths may differ by many powers of ten: each knot is scaled by the shorter of its two segments.
        reach = {knot: min(self.widths[knot - 1], self.widths[knot]) for knot in free}
        knots = list(free)
        rows = []
        for i, knot in enumerate(knots):
            before, own, after, right = self._rows(knot, states, reach)
            # Where the next free knot is not the neighbour, a known state lies between and cuts the ring.
            last, following = knots[i - 1], knots[(i + 1) % len(knots)]
            if last != (knot - 1) % len(self.orders):
                before = np.zeros((len(own), len(free[last])))
            if following != (knot + 1) % len(self.orders):
                after = np.zeros((len(own), len(free[following])))
            rows.append((before, own, after, right))
        try:
            found = _solve_ring(rows)
        except np.linalg.LinAlgError:
            message = "the joining segments leave their common velocity undetermined"
            raise ProfileError([Problem(key, message, None, "fix `velocity` at one of their ends")]) from None
        for (knot, derivatives), values in zip(free.items(), found, strict=True):
            for r, value in zip(derivatives, values, strict=True):
                states[knot, r - 1] = value / reach[knot] ** r

    def _rows(self, knot: int, states: Floats, reach: Mapping[int, float]) -> tuple[Floats, Floats, Floats, Floats]:
        """Continuity of the first derivatives that the laws do not secure: blocks before, own, after; right side."""
        free = self.free
        count, mine = len(self.orders), free[knot]
        neighbours = [(knot - 1) % count, knot, (knot + 1) % count]
        blocks = [np.zeros((len(mine), len(free.get(other, ())))) for other in neighbours]
        right = np.zeros(len(mine))
        lowest = min(self.orders[knot - 1], self.orders[knot])
        for segment, end, sign in ((neighbours[0], 1, 1.0), (knot, 0, -1.0)):
            width, order = self.widths[segment], self.orders[segment]
            base, columns = self.responses[segment]
            for row in range(len(mine)):
                r = lowest + 1 + row
                factor = sign * (reach[knot] / width) ** r
                right[row] -= factor * base[end, r - 1]
                for j in range(2 * order):
                    place, k = 1 - end + (j >= order), j % order + 1
                    gain = factor * columns[end, r - 1, j] * width**k
                    other = neighbours[place]
                    if k in free.get(other, ()):
                        blocks[place][row, free[other].index(k)] += gain / reach[other] ** k
                    else:
                        right[row] -= gain * states[other, k - 1]
        return blocks[0], blocks[1], blocks[2], right


def _solve_ring(rows: Sequence[tuple[Floats, Floats, Floats, Floats]]) -> list[Floats]:
    """Solve before @ x[i-1] + own @ x[i] + after @ x[i+1] = right around a ring, a small block a place.

    The first place is carried along as a parameter, which opens the ring; the rest is block elimination. The blocks
    stem from the least bending energy, a definite form, so they need no pivoting from place to place.
    """
    before, own, after, right = rows[0]
    if len(rows) == 1:
        return [np.asarray(np.linalg.solve(before + own + after, right))]
    size = own.shape[1]
    gains: list[Floats] = []
    parts: list[Floats] = []
    for i, (lower, middle, upper, given) in enumerate(rows[1:], 1):
        known = np.column_stack([given, np.zeros((len(given), size))])
        if i == 1:
            known[:, 1:] -= lower
        else:
            middle = middle - lower @ gains[-1]
            known = known - lower @ parts[-1]
        if i == len(rows) - 1:
            known[:, 1:] -= upper
            upper = np.zeros((len(given), 0))
        solved = np.linalg.solve(middle, np.column_stack([upper, known]))
        gains.append(solved[:, : upper.shape[1]])
        parts.append(solved[:, upper.shape[1] :])
    found: list[Floats] = [parts[-1]]
    for gain, part in zip(reversed(gains[:-1]), reversed(parts[:-1]), strict=True):
        found.append(part - gain @ found[-1])
    found.reverse()
    ring = own + after @ found[0][:, 1:] + before @ found[-1][:, 1:]
    rest = right - after @ found[0][:, 0] - before @ found[-1][:, 0]
    first = np.asarray(np.linalg.solve(ring, rest), dtype=np.float64)
    return [first, *(part[:, 0] + part[:, 1:] @ first for part in found)]


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

    base = answer(Ends(lift=lift, unit=unit, folder=folder, shared=True))
    size = max(1.0, abs(lift))
    columns = []
    for j in range(2 * order):
        push = [size if i == j % order else 0.0 for i in range(HIGHEST)]
        still = [0.0] * HIGHEST
        start, end = (push, still) if j < order else (still, push)
        columns.append((answer(Ends(lift, tuple(start), tuple(end), unit, folder, True)) - base) / size)
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
