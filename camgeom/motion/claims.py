"""Whether a law from outside the package keeps what it claims, measured before anything rests on it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import islice, pairwise
from numbers import Real
from operator import index

import numpy as np

from camgeom.errors import Problem, ProfileError, told_of
from camgeom.maths import TURN
from camgeom.motion.law import Claims, Ends, Factory, LawEntry, ParamValue, finish
from camgeom.motion.table import JUMP_TOLERANCE, Piece, PieceTable

MOST_PIECES, MOST_TERMS, MOST_IN_ALL, MOST_PERIODS, MOST_SIZE = 20_000, 100, 100_000, 500, 1e30
"""of what a law from outside gives: pieces, powers and waves of each and of all, periods in all, size of the numbers"""
MEASURED, KEPT, SMALL, ROUNDING = 3, 1e-6, 1e-3, 1e-14
"""a piece that says it keeps derivatives of the one before is believed but for the lowest ones, of which it may miss
a share, and more where rounding of short pieces explains it, up to the second share"""
CANCELLED, PLACES = 0.01, 9
"""share of the largest derivative, sought at so many places of each piece, that steps may come to which are said to be
none"""
DIGITS = 64.0 * float(np.finfo(np.float64).eps)
"""share of the sum of its terms to which a derivative is known"""
NARROW = 1e-6
"""share of the travel within which neither lift nor velocity may change: no angle that is looked at lies there"""
APART = 1e-12
"""share of the travel by which its pieces may fail to meet"""
TRUE_TO = 5e-4
"""relative; a claim may be rounded as books print it, to four digits"""
JOINED = 1e-9
"""a joining law takes over the derivatives of its neighbours to this share of the largest of them"""
TRIED = Ends(2.0, (0.3, -1.1, 2.3), (-0.7, 1.7, 0.9))
"""ends that a joining law must meet"""


def guarded(name: str, factory: Factory, /, *ends: Ends, **params: ParamValue) -> Sequence[Piece]:
    """The pieces of a law from outside of the package; ProfileError, and nothing else, where they are none."""
    try:
        pieces = [_sound(piece) for piece in islice(factory(*ends, **params), MOST_PIECES + 1)]
        _refuse_unsound(pieces, bool(ends))
        pieces[0] = replace(pieces[0], kept=-1)  # what is before the first one is none of the law's
        return finish(pieces, ends[0].lift if ends else 1.0)
    except (MemoryError, KeyboardInterrupt):
        raise
    except BaseException as error:  # whatever it raises must not end a command as if the design were judged
        given = ", ".join(f"{key} = {value!r}"[:60] for key, value in params.items())
        at = f" at {given}" if given else ""
        fault = f"the function of {name} does not give a motion{at} ({told_of(error)})"
        raise ProfileError([Problem("law", fault)]) from error


def _sound(piece: Piece) -> Piece:
    """The same piece of plain numbers, its waves of positive frequencies; raises ValueError where there is none."""
    if not isinstance(piece, Piece):
        raise ValueError(f"{piece!r:.60} is no Piece")
    power = [_number(x) for x in islice(piece.power, MOST_TERMS + 1)]
    rows = [[_number(x) for x in wave] for wave in islice(piece.waves, MOST_TERMS + 1)]
    if not power or max(len(power), len(rows)) > MOST_TERMS:
        raise ValueError(f"a piece has no number, or more than {MOST_TERMS} powers or waves")
    waves = [(abs(w), a, b if w > 0.0 else -b) for w, a, b in rows if w != 0.0]
    start, end, anchor = map(_number, (piece.start, piece.end, piece.anchor))
    return Piece(start, end, anchor, tuple(power), tuple(waves), index(piece.kept))


def _number(given: object) -> float:
    number = float(given) if isinstance(given, Real) else math.nan
    if not abs(number) <= MOST_SIZE:
        raise ValueError(f"a piece has a number that is none or beyond {MOST_SIZE:g}")
    return number


def _refuse_unsound(pieces: Sequence[Piece], joins: bool) -> None:
    """Raise ValueError where they are not pieces from 0 to 1 of one motion that can be computed with."""
    if not 0 < len(pieces) <= MOST_PIECES:
        raise ValueError("it has no pieces" if not pieces else f"it has more than {MOST_PIECES} pieces")
    if (terms := sum(len(piece.power) + len(piece.waves) for piece in pieces)) > MOST_IN_ALL:
        raise ValueError(f"its pieces have {terms} powers and waves in all, more than {MOST_IN_ALL}")
    edges = [0.0, *(piece.end for piece in pieces)]
    met = all(abs(piece.start - edge) <= APART and piece.end > piece.start for piece, edge in zip(pieces, edges))
    if not met or abs(edges[-1] - 1.0) > APART:
        raise ValueError("its pieces do not follow on one another from x = 0 to x = 1")
    turns = sum(max((w for w, *_ in piece.waves), default=0.0) * _width(piece) for piece in pieces) / TURN
    if turns > MOST_PERIODS:
        raise ValueError(f"its waves have {turns:.6g} periods in all, more than {MOST_PERIODS}")
    pairs = list(pairwise(pieces))
    lift = max(1.0, *(abs(piece.value(x)) for piece in pieces for x in (piece.start, piece.end)))
    if any(_step(before, after, 0) > JOINED * lift for before, after in pairs):
        raise ValueError("its lift jumps between two pieces")
    for order in range(1, 1 + min(MEASURED, max(piece.kept for piece in pieces))):
        most = max(abs(piece.value(x, order)) for piece in pieces for x in (piece.start, piece.end))
        for before, after in pairs:
            rounding = ROUNDING * lift * math.factorial(order) / min(_width(before), _width(after)) ** order
            if order <= after.kept and _step(before, after, order) > min(SMALL * most, KEPT * most + rounding):
                raise ValueError(f"derivative {order} jumps at {after.start:.6g}, where a piece says that it is kept")
    for order in (0, 1):
        change = [abs(piece.value(piece.end, order) - piece.value(piece.start, order)) for piece in pieces]
        most = max(abs(piece.value(x, order)) for piece in pieces for x in (piece.start, piece.end))
        for piece, rise in zip(pieces, change):
            if _width(piece) < NARROW and rise > SMALL * most:
                what = "its velocity" if order else "its lift"
                raise ValueError(f"{what} changes within {_width(piece):.3g} of the travel, from {piece.start:.6g} on; "
                                 f"give it {NARROW:g} at least")
    _refuse_hidden(PieceTable.of(pieces), lift, joins)


def _refuse_hidden(table: PieceTable, lift: float, joins: bool) -> None:
    """Raise ValueError where terms that cancel each other leave too few digits, or raise what counts as rounding beyond
    a jump between pieces or at an end, or where many small steps that are said to be none come to one."""
    every = np.arange(len(table))
    places = np.linspace(table.first_u, table.last_u, PLACES, axis=1).ravel()
    most = np.maximum(np.abs(table.at(np.repeat(every, PLACES), places, MEASURED)).max(axis=1), lift)
    bounds = table.bounds(MEASURED)
    if (lost := DIGITS * bounds.max(axis=1) > SMALL * most).any():
        raise ValueError(f"its terms cancel each other: too few digits of derivative {int(np.argmax(lost))} are left")
    first, last = (table.limit(every, MEASURED, end) for end in ("first", "last"))
    steps, around = np.abs(first[:, 1:] - last[:, :-1]), bounds[:, 1:] + bounds[:, :-1]
    where = table.edges[1:-1]
    if not joins:  # a dwell is beside it, where all derivatives are 0
        ends = np.abs(np.stack([first[:, 0], last[:, -1]], axis=1))
        ends[0] = 0.0
        steps, around = np.hstack([steps, ends]), np.hstack([around, bounds[:, [0, -1]]])
        where = np.r_[where, 0.0, 1.0]
    order, at = np.nonzero((steps <= JUMP_TOLERANCE * around) & (steps > SMALL * most[:, None]))
    if len(order):
        raise ValueError(f"derivative {order[0]} jumps at {where[at[0]]:.6g}, hidden by terms that cancel each other")
    for r in range(1, MEASURED + 1):
        if float(steps[r, : len(table) - 1][table.kept[1:] >= r].sum()) > CANCELLED * most[r]:
            raise ValueError(f"derivative {r} changes in steps, where pieces say that it is kept")


def _step(before: Piece, after: Piece, order: int) -> float:
    return abs(after.value(after.start, order) - before.value(before.end, order))


def _width(piece: Piece) -> float:
    return piece.end - piece.start


def refuse_unkept(entry: LawEntry) -> None:
    """Raise ProfileError where a law is no motion from 0 to 1, or is not what it claims, at its defaults and cases."""
    if entry.joins and "order" not in entry.parameters:
        text = "a joining law needs the parameter `order`: how many derivatives it takes over"
        raise ProfileError([Problem(f"law {entry.name}", text)])
    cases: list[tuple[Mapping[str, ParamValue], Claims]] = [({}, entry.claims), *entry.cases]
    if problems := [problem for case in cases for problem in _unkept(entry, *case)]:
        raise ProfileError(problems)


def _unkept(entry: LawEntry, params: Mapping[str, ParamValue], claims: Claims) -> list[Problem]:
    """What is wrong with the law at these parameters."""
    at = ", ".join(f"{key} = {value!r}" for key, value in params.items())
    where = f"law {entry.name}" + (f" ({at})" if at else "")
    if problems := entry.problems(params, f"{where}: "):
        return problems
    try:
        measured = entry.make(params).peaks()
        missed = _missed_end(entry, params) if entry.joins else ""
    except ProfileError as error:
        return [Problem(f"{where}: {p.key}", p.message, p.value, p.allowed, p.hint) for p in error.problems]
    except Exception as error:
        return [Problem(where, f"its function does not give a motion ({type(error).__name__}: {error})")]
    problems = [Problem(where, missed)] if missed else []
    for key in ("vm", "am", "jm", "vam", "arms", "order_start", "order_end", "order_inside"):
        claimed, is_ = getattr(claims, key), getattr(measured, key)
        tolerance = 0.0 if key.startswith("order") else TRUE_TO
        if claimed != is_ and not (math.isfinite(is_) and abs(claimed - is_) <= tolerance * abs(is_)):
            problems.append(Problem(f"{where}: {key}", "the claim does not hold", claimed, f"{is_:.9g} as measured"))
    return problems


def _missed_end(entry: LawEntry, params: Mapping[str, ParamValue]) -> str:
    """Which derivative of a moving neighbour the law does not take over; empty where it takes over all it should."""
    pieces = entry.pieces(params, TRIED)
    order = int(params.get("order", entry.parameters["order"].default))
    scale = max(map(abs, (*TRIED.start, *TRIED.end)))
    for piece, x, ends, word in ((pieces[0], 0.0, TRIED.start, "start"), (pieces[-1], 1.0, TRIED.end, "end")):
        for r in range(1, order + 1):
            if abs(piece.value(x, r) - ends[r - 1]) > JOINED * scale:
                return f"it does not take over derivative {r} at its {word}"
    return ""
