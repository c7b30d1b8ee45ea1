"""Motion laws from outside the package: what a law promises is measured before anything rests on it, and a user's file.

A profile is data and never names code: only the command line (`--laws FILE`) or a Python program brings a law in.
"""

from __future__ import annotations

import math
import os
import sys
import traceback
from collections.abc import Iterable, Mapping
from itertools import pairwise
from pathlib import Path
from types import ModuleType

import numpy as np

from camgeom.errors import Problem, ProfileError
from camgeom.motion.law import LAWS, Claims, Ends, LawEntry, ParamValue
from camgeom.motion.table import Piece
from camgeom.reading import read_bytes

MOST_BYTES = 1_000_000
TRUE_TO = 5e-4
"""relative; a claim may be rounded as books print it, to four digits"""
JOINED = 1e-9
"""a joining law takes over the derivatives of its neighbours to this share of the largest of them"""
TRIED = Ends(2.0, (0.3, -1.1, 2.3), (-0.7, 1.7, 0.9))
"""ends that a joining law must meet"""

_loaded: dict[Path, tuple[bytes, tuple[str, ...]]] = {}
"""the files read so far: their content and the laws they entered"""


def load_laws(file: str | Path) -> tuple[str, ...]:
    """Run a Python file that enters laws by `@camgeom.law`; the names of its laws. Reading it again changes nothing.

    Raises ProfileError where the file cannot be read or run, enters no law, takes a name that is taken, or claims what
    does not hold; the catalogue is then as it was before.
    """
    shown = str(file)
    return _enter(read_bytes(Path(file), MOST_BYTES, shown, "--laws"), Path(file).resolve(), shown)


def _enter(content: bytes, path: Path, shown: str) -> tuple[str, ...]:
    if path in _loaded and _loaded[path][0] == content:
        return _loaded[path][1]
    before = dict(LAWS)
    for name in _loaded.pop(path, (b"", ()))[1]:
        del LAWS.entered[name]
    kept = set(LAWS.entered)
    try:
        _run(content, path, shown)
        entered = tuple(name for name in LAWS.entered if name not in kept)
        if not entered:
            raise ProfileError([Problem("file", "enters no law", None, "functions under @camgeom.law(...)")], shown)
    except BaseException:
        LAWS.entered.clear()
        LAWS.entered.update(before)
        raise
    _loaded[path] = (content, entered)
    return entered


def loaded_files() -> tuple[str, ...]:
    """The files whose laws are in the catalogue, for processes that must know them too."""
    return tuple(map(str, _loaded))


def loaded_contents() -> tuple[bytes, ...]:
    """What stands in these files."""
    return tuple(content for content, _ in _loaded.values())


def loaded_copies() -> tuple[tuple[str, bytes], ...]:
    """The same files by name with what stands in them, for machines that do not have them."""
    return tuple((str(path), content) for path, (content, _) in _loaded.items())


def load_copies(copies: Iterable[tuple[str, bytes]]) -> None:
    """Enter the laws of files of another machine; a copy that is known already is left as it is."""
    known = loaded_contents()
    for name, content in copies:
        if content not in known:
            _enter(content, Path(name), name)


def load_all(files: Iterable[str]) -> None:
    """Enter the laws of several files."""
    for file in files:
        load_laws(file)


def cores() -> int:
    """Cores that this process may use; one of a worker that may have none of its own."""
    from multiprocessing import current_process

    if current_process().daemon:
        return 1
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def begin_worker(files: Iterable[str]) -> None:
    """How a worker process begins: it knows the parent's laws, leaves Ctrl-C to the parent, and ends when that ends."""
    import signal
    from multiprocessing import parent_process
    from threading import Thread

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if (parent := parent_process()) is not None:

        def end_after() -> None:
            # A pool's worker would wait for work for ever where its parent was killed.
            parent.join()
            os._exit(1)

        Thread(target=end_after, daemon=True).start()
    load_all(files)


def _run(content: bytes, path: Path, shown: str) -> None:
    """Execute the file as a module of its own; every way it can fail is a ProfileError with the line."""
    module = ModuleType(f"camgeom_laws_{path.stem}")
    module.__file__ = str(path)
    sys.modules[module.__name__] = module
    try:
        exec(compile(content, str(path), "exec"), vars(module))
    except ProfileError as error:
        raise ProfileError(error.problems, shown) from None
    except SyntaxError as error:
        raise ProfileError([Problem(f"line {error.lineno or 1}", f"is not Python: {error.msg}")], shown) from None
    except (Exception, SystemExit) as error:
        lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
        where = f"line {lines[-1]}" if lines else "file"
        said = str(error) if isinstance(error, ValueError) else f"{type(error).__name__}: {error}"
        raise ProfileError([Problem(where, said)], shown) from None


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
