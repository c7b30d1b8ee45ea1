"""Whether a law from outside the package keeps what it claims, measured before anything rests on it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from camgeom.errors import Problem, ProfileError
from camgeom.motion.law import Claims, Ends, LawEntry, ParamValue
from camgeom.motion.table import Piece

TRUE_TO = 5e-4
"""relative; a claim may be rounded as books print it, to four digits"""
JOINED = 1e-9
"""a joining law takes over the derivatives of its neighbours to this share of the largest of them"""
TRIED = Ends(2.0, (0.3, -1.1, 2.3), (-0.7, 1.7, 0.9))
"""ends that a joining law must meet"""


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
        law = entry.make(params)
        if fault := _shape_fault(law.pieces):
            return [Problem(where, fault)]
        measured = law.peaks()
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


def _shape_fault(pieces: tuple[Piece, ...]) -> str:
    """Why the pieces are no motion over 0 <= x <= 1; empty where they are one."""
    edges = [pieces[0].start, *(piece.end for piece in pieces)]
    if edges[0] != 0.0 or edges[-1] != 1.0 or any(piece.start != edge for piece, edge in zip(pieces, edges)):
        return "its pieces do not follow on one another from x = 0 to x = 1"
    if any(not low < high for low, high in pairwise(edges)):
        return "its pieces must each end after they start"
    numbers = np.array([c for piece in pieces for c in (*piece.power, *(x for wave in piece.waves for x in wave))])
    if not np.isfinite(numbers).all():
        return "a number of its pieces is not finite"
    steps = [abs(after.value(after.start) - before.value(before.end)) for before, after in pairwise(pieces)]
    return "its lift jumps between two pieces" if max(steps, default=0.0) > JOINED else ""


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
