"""Interrupts and SIGTERM at the moments when they have to wait, and in the processes that are none of their concern."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from threading import current_thread, main_thread
from types import FrameType

ENDING = (signal.SIGINT, signal.SIGTERM)


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
def deaf_children() -> Iterator[None]:
    """Processes that begin within it hear no interrupt of the terminal, which is their parent's, until they have said
    with `hear_none` how they take it: before, their imports would end with a traceback each."""
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
