"""Interrupts and SIGTERM at the moments when they have to wait, and in the processes that are none of their concern."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from threading import Event, Thread, current_thread, main_thread
from types import FrameType
from typing import Any

ENDING = (signal.SIGINT, signal.SIGTERM)
SWALLOWED = 0.1
"""s after which an interrupt that the main thread does not leave by was swallowed"""
_heard = Event()


def insist(number: int) -> None:
    """Send a signal once more, and again, until the main thread leaves by the exception that it raises: code that
    cannot raise (functions of SciPy's Sobol sequences, what an object does when it goes), or catches whatever comes,
    swallows it, and the command would go on."""

    def watch() -> None:
        while not _heard.wait(SWALLOWED):
            if not _leaving():
                os.kill(os.getpid(), number)  # whose handler insists again
                return

    with suppress(RuntimeError):  # no room for a thread
        Thread(target=watch, daemon=True).start()


def heard() -> None:
    """The interrupt has done what it is for."""
    _heard.set()


def _leaving() -> bool:
    """Whether the main thread is on its way out of an interrupt: cleans up, or tells it."""
    found: Any = sys._current_exceptions().get(main_thread().ident or 0)
    error = found[1] if isinstance(found, tuple) else found  # before Python 3.12 with its class
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__context__
    return error is not None


@contextmanager
def held() -> Iterator[None]:
    """Within it an interrupt, or SIGTERM, of the main thread waits for its end: a second one leaves no clean-up half
    done, and one within a library that cannot bear it does not end the process."""
    if current_thread() is not main_thread():
        yield
        return
    came: list[int] = []

    def keep(number: int, _: FrameType | None) -> None:
        came.append(number)

    before = {one: signal.getsignal(one) for one in ENDING}
    try:
        for one in ENDING:
            signal.signal(one, keep)
        yield
    finally:
        for one, handler in before.items():
            # None: a handler that is not Python's
            signal.signal(one, signal.SIG_DFL if handler is None else handler)
        for number in came[:1]:
            signal.raise_signal(number)


@contextmanager
def beginning_children() -> Iterator[None]:
    """Processes that begin within it hear no interrupt of the terminal, which is their parent's, until they have said
    with `hear_none` how they take it: before, their imports would end with a traceback each, as they would where their
    parent ends before it has told them what they are for. Interrupts of the parent wait."""
    with held():
        if not hasattr(signal, "pthread_sigmask"):
            yield
            return
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            yield
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


def hear_none() -> None:
    """Leave interrupts to the parent of this process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
