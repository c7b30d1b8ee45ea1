"""Work that several threads share, none of which has to begin.

A thread that memory does not suffice for can end before its first line, and `threading.Thread.start` then waits for it
for ever. Here the caller works as well, and does what no other thread has taken.
"""

from __future__ import annotations

from _thread import allocate_lock, start_new_thread
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import TypeVar

S = TypeVar("S")
T = TypeVar("T")


def shared(job: Callable[[S], T], items: Sequence[S], threads: int) -> list[T]:
    """job(item) of every item, in their order, by so many threads, the calling one among them.

    What a job raises is raised here when every thread has ended; no other job is begun after it.
    """
    waiting, found = deque(range(len(items))), dict[int, T]()
    begun, errors = deque[Callable[[], object]](), deque[BaseException]()

    def take() -> int | None:
        with suppress(IndexError):
            return waiting.popleft()
        return None

    def work() -> None:
        try:
            while (at := take()) is not None:
                found[at] = job(items[at])
        except BaseException as error:
            errors.append(error)
            waiting.clear()

    def beside(wait: Callable[[], object], end: Callable[[], object]) -> None:
        begun.append(wait)
        try:
            work()
        finally:
            end()

    try:
        for _ in range(min(threads, len(items)) - 1):
            lock = allocate_lock()
            lock.acquire()
            with suppress(RuntimeError):  # no room for one more
                start_new_thread(beside, (lock.acquire, lock.release))
        work()
    finally:
        waiting.clear()
        for wait in list(begun):
            wait()
    if errors:
        raise errors[0]
    return [found[at] for at in range(len(items))]
