"""`python -m camgeom` and the `camgeom` command: the command line in a process of its own."""

from __future__ import annotations

import gc
import os
import signal
import sys
from contextlib import suppress
from importlib import import_module
from threading import enumerate as every_thread
from threading import main_thread
from types import ModuleType, TracebackType
from typing import TYPE_CHECKING

from camgeom.interrupts import heard, insist

if TYPE_CHECKING:
    from sys import UnraisableHookArgs

LOADER = "pydantic.plugin._loader"
TRIM_THRESHOLD, MMAP_THRESHOLD = -1, -3
"""of malloc.h: from which size on memory at the top goes back, and from which on an array has a mapping of its own"""


def seek_no_plugins() -> None:
    """Plugins of pydantic are sought among all that is installed, 2 % of a command, by a module that imports readers of
    mail and of archives for it, 3 %. camgeom knows of none that it needs: unless the environment names some, another
    module stands in its place, and makes way for it where more than its list of plugins is wanted."""
    if os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__") != "__all__" or LOADER in sys.modules:
        return

    def loader(name: str) -> object:
        if name.startswith("__"):  # what Python's import itself asks of every module
            raise AttributeError(name)
        sys.modules.pop(LOADER, None)
        return getattr(import_module(LOADER), name)

    none = ModuleType(LOADER)
    vars(none).update(get_plugins=tuple, __getattr__=loader)
    sys.modules[LOADER] = none


def keep_memory() -> None:
    """The C library of Linux maps every array of 128 kB and more anew, and gives it back at once: the kernel clears its
    pages each time, 1 to 5 % of a command. Up to 64 MB are kept instead. Other C libraries have their own way."""
    from ctypes import CDLL

    with suppress(AttributeError, OSError, TypeError):
        adjust = CDLL(None).mallopt
        for what, size in ((MMAP_THRESHOLD, 1 << 25), (TRIM_THRESHOLD, 1 << 26)):
            adjust(what, size)


def terminated(*_: object) -> None:
    """What SIGTERM does to a command, where it is not ignored: as an interrupt, it leaves nothing half-written."""
    insist(signal.SIGTERM)
    raise KeyboardInterrupt("SIGTERM")


def interrupted(*_: object) -> None:
    """What SIGINT does to a command, where it is not ignored."""
    insist(signal.SIGINT)
    raise KeyboardInterrupt


def show(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    """What ends a command is told by `run` alone: compiled code shows what it swallows as if nobody caught it."""
    if not issubclass(kind, KeyboardInterrupt):
        sys.__excepthook__(kind, error, trace)


def show_swallowed(what: UnraisableHookArgs) -> None:
    """An interrupt within code that cannot raise comes again."""
    if not issubclass(what.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(what)


def run() -> int:
    """Run the command line. A command makes classes and arrays and ends: looking for cycles every 700 objects, as is
    the default, takes 4 to 8 % of its time. Its matrices are many and small: threads of the linear algebra, started
    where nobody asked for a number of them, spend 10 % of it waiting for each other. What is left at the end goes with
    the process: looking through it for cycles once more takes 3 to 10 %. An interrupt or SIGTERM before the command has
    begun ends it without a trace; one after it has ended comes too late."""
    gc.set_threshold(100_000, 20, 20)
    seek_no_plugins()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if len(sys.argv) > 2:  # what says only how it is used has no arrays
        keep_memory()
    status = None
    if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
        signal.signal(signal.SIGTERM, terminated)
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, interrupted)
    sys.excepthook, sys.unraisablehook = show, show_swallowed
    try:
        from camgeom.cli import main

        status = main()
        # A thread that a law of the user's own has left behind is waited for, and may be ended.
        left = signal.SIG_IGN if all(one.daemon or one is main_thread() for one in every_thread()) else signal.SIG_DFL
        signal.signal(signal.SIGINT, left)
        signal.signal(signal.SIGTERM, left)
    except KeyboardInterrupt as stop:
        if status is None:
            said, status = ("terminated", 143) if stop.args else ("interrupted", 130)
            sys.stderr.write(f"camgeom: {said}\n")
    heard()
    if status in (130, 143):  # pools of workers that were stopped as they began complain of what is closed by then
        sys.unraisablehook = lambda _: None
    # An interrupt that comes out of text run as code (Python's own named tuples) is remembered as one that nobody has
    # caught: the process would end by SIGINT, whatever the status is. Other text that runs takes that back.
    exec("")
    gc.freeze()
    return status


if __name__ == "__main__":
    raise SystemExit(run())
