"""Motion laws from a user's file, in this process and in those that work for it.

A profile is data and never names code: only the command line (`--laws FILE`) or a Python program brings a law in.
"""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Iterable
from pathlib import Path
from types import CodeType, ModuleType

from camgeom.errors import Problem, ProfileError, told_of
from camgeom.motion.catalogue import LAWS
from camgeom.reading import read_bytes

MOST_BYTES = 1_000_000

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

    from camgeom.interrupts import hear_none

    hear_none()
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    if (parent := parent_process()) is not None:

        def end_after() -> None:
            # A pool's worker would wait for work for ever where its parent was killed.
            parent.join()
            os._exit(1)

        Thread(target=end_after, daemon=True).start()
    load_all(files)


def _compiled(content: bytes, path: Path) -> CodeType:
    try:
        return compile(content, str(path), "exec")
    except (MemoryError, RecursionError):
        raise ProfileError([Problem("file", "is nested too deeply for Python")]) from None


def _run(content: bytes, path: Path, shown: str) -> None:
    """Execute the file as a module of its own; every way it can fail is a ProfileError with the line."""
    module = ModuleType(f"camgeom_laws_{path.stem}")
    module.__file__ = str(path)
    sys.modules[module.__name__] = module
    try:
        exec(_compiled(content, path), vars(module))
    except ProfileError as error:
        raise ProfileError(error.problems, shown) from None
    except SyntaxError as error:
        raise ProfileError([Problem(f"line {error.lineno or 1}", f"is not Python: {error.msg}")], shown) from None
    except (KeyboardInterrupt, MemoryError):
        raise
    except BaseException as error:
        lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
        where = f"line {lines[-1]}" if lines else "file"
        raise ProfileError([Problem(where, told_of(error))], shown) from None
