"""A motion over a place that itself moves: lift over a travel, travel over the turn of a drive, as one program.

s(theta) = f(x(theta)). Where no piece of f or x ends, both are analytic: their Taylor series about the middle of a
stretch are put into one another as power series, exact term by term, and a stretch is halved until what is left out is
below rounding. So a composed program is a program like any other, with jets, knots, peaks and jumps of its own.
"""

from __future__ import annotations

import math
from operator import itemgetter

import numpy as np
import numpy.typing as npt

from camgeom.errors import NotConverged
from camgeom.maths import TURN, Floats, distinct
from camgeom.maths.extremum import bracketed_root
from camgeom.motion.law import ORDER_LIMIT
from camgeom.motion.program import Program
from camgeom.motion.segment import Segment, Span
from camgeom.motion.table import JUMP_TOLERANCE, LEAST_JUMP, Piece

DEGREE = 17
"""of the series"""
LEFT_OUT = 1e-15
"""share of the largest lift, tenfold of each of its first three derivatives, that the last terms may hold"""
Index = npt.NDArray[np.intp]
Mask = npt.NDArray[np.bool_]
FACTORIALS = np.array([math.factorial(k) for k in range(DEGREE + 1)], dtype=float)
MOST_HALVINGS = 12
MOST_AT_ONCE = 20_000
BESIDE = 1e-9
"""rad; pieces nearer together are one place: what is left between is rounding"""


def composed(path: Program, drive: Program) -> Program:
    """The lift (mm or rad) over the turn of a drive that carries `path`.

    path   lift over one turn, which need not close
    drive  place on the path, 0 .. 2 pi (rad of the path's own angle), over the drive's turn; closed, monotone in each
           of its spans
    The path is never run beyond its ends. Raises NotConverged where the series need stretches too short.
    """
    edges = _edges(path, drive)
    if len(edges) > MOST_AT_ONCE + 1:
        raise NotConverged(f"the motion has {len(edges) - 1} pieces over the drive, more than the {MOST_AT_ONCE} that "
                           "are put together; fewer segments, or pieces of their laws")  # fmt: skip
    spans = _spans(path, drive, edges)
    # Against it what is left out counts, too, where a motion comes to rest.
    size = max(abs(lift) for span in path.spans for lift in (span.before, span.after))
    series = _stretches(path, drive, edges, size)
    kept = dict(zip(edges[:-1].tolist(), _kept(path, drive, edges)))
    pieces: list[tuple[Piece, ...]] = []
    for span in spans:
        width, own = span.end - span.start, list[Piece]()
        for low, high, power in series:
            if span.start - BESIDE <= low and high <= span.end + BESIDE:
                scaled = tuple((power * width ** np.arange(len(power))).tolist())
                start, end = ((at - span.start) / width for at in (low, high))
                end = 1.0 if high == span.end else end
                own.append(Piece(start, end, 0.5 * (start + end), scaled, (), kept.get(low, ORDER_LIMIT)))
        pieces.append(tuple(own))
    moved = [(span.end, None, None) if span.law == "dwell" else (span.end, span.after, span.law) for span in spans]
    return Program(tuple(Segment(*one) for one in moved), spans, tuple(pieces), path=path)


def place(drive: Program, theta: Floats) -> Floats:
    """Where on the path a drive stands, rad: never beyond the path's ends by rounding."""
    return np.asarray(np.clip(drive.jet(theta, 0)[0], 0.0, TURN))


def _edges(path: Program, drive: Program) -> Floats:
    """Angles of the drive from 0 to 2 pi at which a piece of it, or of the path below it, ends."""
    found = [drive.table.edges]
    for span in drive.spans:
        low, high = sorted((span.before, span.after))
        inner = path.table.edges[(path.table.edges > low + BESIDE) & (path.table.edges < high - BESIDE)]
        if not len(inner):
            continue

        def beyond(at: Floats, wanted: Floats = inner) -> Floats:
            return np.asarray(drive.jet(at, 0)[0] - wanted)

        found.append(bracketed_root(beyond, np.full(len(inner), span.start), np.full(len(inner), span.end)))
    edges = distinct(np.concatenate(found))
    edges = edges[np.append(True, np.diff(edges) > BESIDE)]
    edges[0], edges[-1] = 0.0, TURN
    return np.asarray(edges)


def _spans(path: Program, drive: Program, edges: Floats) -> tuple[Span, ...]:
    """Stretches of the drive's turn in which one segment of the path is run one way, or the drive rests."""
    found: list[Span] = []
    last = (-1.0, -1)
    lifts, middles = _lifts(path, drive, edges), place(drive, 0.5 * (edges[:-1] + edges[1:]))
    for i, at in enumerate(middles.tolist()):
        low, high, before, after = (float(one) for one in (edges[i], edges[i + 1], lifts[i], lifts[i + 1]))
        moving = next(span for span in drive.spans if low < span.end - BESIDE)
        number = -1
        if moving.law != "dwell":
            number = next((k for k, span in enumerate(path.spans) if at <= span.end), len(path.spans) - 1)
        if (moving.start, number) == last:
            found[-1] = found[-1]._replace(end=high, after=after)
            continue
        last = (moving.start, number)
        found.append(Span(low, high, before, after, path.spans[number].law if number >= 0 else "dwell"))
    # A closed program ends on the very number it began with.
    return (*found[:-1], found[-1]._replace(after=found[0].before))


def _lifts(path: Program, drive: Program, theta: Floats) -> Floats:
    """Lifts at angles (n,) of the drive; where a segment of the path ends exactly those that it states."""
    at = place(drive, theta)
    lifts = np.array(path.jet(at, 0)[0])
    for span in reversed(path.spans):
        lifts[np.abs(at - span.end) <= BESIDE] = span.after
    lifts[at <= BESIDE] = path.spans[0].before
    return np.asarray(lifts)


def _taylor(program: Program, index: Index, at: Floats, degree: int) -> Floats:
    """Coefficients (n, degree + 1) of the series of a program's pieces about angles (n,), rad."""
    table = program.table
    return np.asarray(table.at(index, at - table.anchors[index], degree).T / FACTORIALS[: degree + 1])


def _series(path: Program, drive: Program, at: Floats, beside: Floats, degree: int = DEGREE) -> Floats:
    """Coefficients (n, degree + 1) of the composed series about angles (n,), of the pieces at angles beside them."""
    moved = _taylor(drive, drive.table.locate(beside), at, degree)
    shape = _taylor(path, path.table.locate(place(drive, beside)), np.clip(moved[:, 0], 0.0, TURN), degree)
    moved[:, 0] = 0.0
    lag = np.subtract.outer(np.arange(degree + 1), np.arange(degree + 1))
    times = np.where(lag >= 0, moved[:, np.maximum(lag, 0)], 0.0)
    total = np.zeros_like(moved)
    for c in shape.T[::-1]:
        total = (times @ total[:, :, None])[:, :, 0]
        total[:, 0] += c
    return total


def _stretches(path: Program, drive: Program, edges: Floats, size: float) -> list[tuple[float, float, Floats]]:
    """Series about the middles of parts of each stretch, short enough that what they leave out is below rounding."""
    low, high, found = edges[:-1], edges[1:], list[tuple[float, float, Floats]]()
    for _ in range(MOST_HALVINGS + 1):
        if len(low) > MOST_AT_ONCE:
            break
        middle = 0.5 * (low + high)
        power = _series(path, drive, middle, middle)
        settled = _settled(power, 0.5 * (high - low), size)
        found += zip(low[settled].tolist(), high[settled].tolist(), power[settled])
        if settled.all():
            return sorted(found, key=itemgetter(0))
        low, middle, high = low[~settled], middle[~settled], high[~settled]
        low, high = np.concatenate((low, middle)), np.concatenate((middle, high))
    at = math.degrees(low[0])
    raise NotConverged(f"the motion over the drive has no series at {at:.6g} deg; take a gentler law or drive")


def _settled(power: Floats, half: Floats, size: float) -> Mask:
    """Whether the last two terms of series (n, k), and of their first three derivatives, are below rounding of what
    they are on stretches of half widths (n,), or of the lift's `size` (per rad^order)."""
    settled = np.ones(len(half), dtype=bool)
    for order in range(4):
        perms = FACTORIALS[order:] / FACTORIALS[: DEGREE + 1 - order]
        terms = np.abs(power[:, order:]) * perms * half[:, None] ** np.arange(DEGREE + 1 - order)
        settled &= terms[:, -2:].sum(axis=1) <= LEFT_OUT * 10.0**order * np.maximum(terms.max(axis=1), size)
    return settled


def _kept(path: Program, drive: Program, edges: Floats) -> list[int]:
    """Derivatives that continue across each edge but the last, found on the exact pieces and not on cut off series."""
    middles = 0.5 * (edges[:-1] + edges[1:])
    before = np.roll(_series(path, drive, edges[1:], middles, ORDER_LIMIT), 1, axis=0)
    after = _series(path, drive, edges[:-1], middles, ORDER_LIMIT)
    left, right = (each * FACTORIALS[: ORDER_LIMIT + 1] for each in (before, after))
    scale = np.maximum(np.abs(left), np.abs(right)).max(axis=0)
    jumps = np.abs(right - left) > JUMP_TOLERANCE * scale + LEAST_JUMP
    return [int(np.argmax(row)) - 1 if row.any() else ORDER_LIMIT for row in jumps]
