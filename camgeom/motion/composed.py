"""A motion over a place that itself moves: lift over a travel, travel over the turn of a drive, as one program.

s(theta) = f(x(theta)). Where no piece of f or x ends, both are analytic: their Taylor series about the middle of a
stretch are put into one another as power series, exact term by term, and a stretch is halved until what is left out is
below rounding. So a composed program is a program like any other, with jets, knots, peaks and jumps of its own.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from camgeom.errors import NotConverged
from camgeom.maths import Floats, distinct
from camgeom.maths.extremum import bracketed_root
from camgeom.motion.law import ORDER_LIMIT
from camgeom.motion.program import Program, Segment
from camgeom.motion.segment import TURN, Span
from camgeom.motion.table import JUMP_TOLERANCE, LEAST_JUMP, Piece

DEGREE = 17
"""of the series"""
LEFT_OUT = 1e-15
"""share of the largest lift, tenfold of each of its first three derivatives, that the last terms may hold"""
FACTORIALS = np.array([math.factorial(k) for k in range(DEGREE + 1)], dtype=float)
MOST_HALVINGS = 12
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
    spans = _spans(path, drive, edges)
    # Against it what is left out counts, too, where a motion comes to rest.
    size = max(abs(lift) for span in path.spans for lift in (span.before, span.after))
    series = [piece for low, high in pairwise(edges) for piece in _stretches(path, drive, low, high, size)]
    kept = dict(zip(edges[:-1], _kept(path, drive, edges)))
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


def _edges(path: Program, drive: Program) -> list[float]:
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
    return [float(edge) for edge in edges]


def _spans(path: Program, drive: Program, edges: list[float]) -> tuple[Span, ...]:
    """Stretches of the drive's turn in which one segment of the path is run one way, or the drive rests."""
    found: list[Span] = []
    last = (-1.0, -1)
    for low, high in pairwise(edges):
        at = float(place(drive, np.array([0.5 * (low + high)]))[0])
        moving = next(span for span in drive.spans if low < span.end - BESIDE)
        number = -1
        if moving.law != "dwell":
            number = next((i for i, span in enumerate(path.spans) if at <= span.end), len(path.spans) - 1)
        after = _lift(path, drive, high)
        if (moving.start, number) == last:
            found[-1] = found[-1]._replace(end=high, after=after)
            continue
        last = (moving.start, number)
        law = path.spans[number].law if number >= 0 else "dwell"
        found.append(Span(low, high, _lift(path, drive, low), after, law))
    # A closed program ends on the very number it began with.
    return (*found[:-1], found[-1]._replace(after=found[0].before))


def _lift(path: Program, drive: Program, theta: float) -> float:
    """The lift at an angle of the drive; where a segment of the path ends exactly the one that it states."""
    at = float(place(drive, np.array([theta]))[0])
    if at <= BESIDE:
        return path.spans[0].before
    stated = next((span.after for span in path.spans if abs(span.end - at) <= BESIDE), None)
    return float(path.jet(np.array([at]), 0)[0, 0]) if stated is None else stated


def _taylor(program: Program, index: int, at: float, degree: int) -> Floats:
    """Coefficients (degree + 1,) of the series of a program's piece about an angle, rad."""
    table = program.table
    jet = table.at(np.array([index]), np.array([at - float(table.anchors[index])]), degree)[:, 0]
    return np.asarray(jet / FACTORIALS[: degree + 1])


def _series(path: Program, drive: Program, at: float, beside: float, degree: int = DEGREE) -> Floats:
    """Coefficients of the composed series about an angle, of the pieces that hold at an angle beside it."""
    moved = _taylor(drive, int(drive.table.locate(np.array([beside]))[0]), at, degree)
    number = int(path.table.locate(place(drive, np.array([beside])))[0])
    shape = _taylor(path, number, min(max(float(moved[0]), 0.0), TURN), degree)
    moved[0] = 0.0
    total = np.zeros(degree + 1)
    for c in shape[::-1]:
        total = np.convolve(total, moved)[: degree + 1]
        total[0] += c
    return total


def _stretches(
    path: Program, drive: Program, low: float, high: float, size: float, depth: int = 0
) -> list[tuple[float, float, Floats]]:
    """Series about the middles of parts of a stretch, short enough that what they leave out is below rounding."""
    middle = 0.5 * (low + high)
    power = _series(path, drive, middle, middle)
    if _settled(power, 0.5 * (high - low), size):
        return [(low, high, power)]
    if depth == MOST_HALVINGS:
        at = math.degrees(middle)
        raise NotConverged(f"the motion over the drive has no series at {at:.6g} deg; take a gentler law or drive")
    parts = _stretches(path, drive, low, middle, size, depth + 1)
    return parts + _stretches(path, drive, middle, high, size, depth + 1)


def _settled(power: Floats, half: float, size: float) -> bool:
    """Whether the last two terms of a series, and of its first three derivatives, are below rounding of what they are
    on the stretch, or of the lift's `size` (per rad^order)."""
    k = np.arange(DEGREE + 1)
    for order in range(4):
        perms = FACTORIALS[order:] / FACTORIALS[: DEGREE + 1 - order]
        terms = np.abs(power[order:]) * perms * half ** k[: len(k) - order]
        if terms[-2:].sum() > LEFT_OUT * 10.0**order * max(float(terms.max()), size):
            return False
    return True


def _kept(path: Program, drive: Program, edges: list[float]) -> list[int]:
    """Derivatives that continue across each edge but the last, found on the exact pieces and not on cut off series."""
    middles = [0.5 * (low + high) for low, high in pairwise(edges)]
    before = [_series(path, drive, edge, middle, ORDER_LIMIT) for edge, middle in zip(edges[1:], middles)]
    after = [_series(path, drive, edge, middle, ORDER_LIMIT) for edge, middle in zip(edges, middles)]
    left, right = (np.stack(each) * FACTORIALS[: ORDER_LIMIT + 1] for each in ([before[-1], *before[:-1]], after))
    scale = np.maximum(np.abs(left), np.abs(right)).max(axis=0)
    jumps = np.abs(right - left) > JUMP_TOLERANCE * scale + LEAST_JUMP
    return [int(np.argmax(row)) - 1 if row.any() else ORDER_LIMIT for row in jumps]
