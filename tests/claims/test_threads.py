"""Work that threads share is done whatever becomes of them."""

from __future__ import annotations

import time
from collections.abc import Callable
from threading import Event, get_ident
from typing import Any

import pytest

from camgeom.maths import threads
from camgeom.maths.threads import shared


def test_results_come_in_order_and_from_several_threads() -> None:
    other = Event()

    def job(number: int) -> tuple[int, int]:
        if number == 0:
            assert other.wait(60.0)  # somebody else does the second one meanwhile
        other.set()
        return number, get_ident()

    found = shared(job, range(50), 2)
    assert [number for number, _ in found] == list(range(50))
    assert len({thread for _, thread in found}) == 2
    assert shared(job, [], 2) == []
    assert shared(lambda x: -x, [3], 8) == [-3]


def lost(function: Callable[..., object], arguments: tuple[Any, ...]) -> int:
    """A thread that ends before its first line."""
    return 0


def refused(function: Callable[..., object], arguments: tuple[Any, ...]) -> int:
    raise RuntimeError("can't start new thread")


def late(function: Callable[..., object], arguments: tuple[Any, ...]) -> int:
    """One that begins when the caller has done everything."""
    return start(lambda: (time.sleep(0.05), function(*arguments)), ())


start = threads.start_new_thread


@pytest.mark.parametrize("way", [lost, refused, late])
def test_threads_that_do_not_begin_are_not_waited_for(monkeypatch: pytest.MonkeyPatch, way: Any) -> None:
    """A run with little memory waited for one for ever."""
    monkeypatch.setattr(threads, "start_new_thread", way)
    assert shared(lambda x: 2 * x, range(9), 4) == list(range(0, 18, 2))


@pytest.mark.parametrize("kind", [ValueError, MemoryError, KeyboardInterrupt, IndexError])
@pytest.mark.parametrize("number", [1, 2])
def test_what_a_job_raises_is_raised_when_all_have_ended(kind: type[BaseException], number: int) -> None:
    running: list[int] = []

    def job(at: int) -> None:
        running.append(at)
        if at == 3:
            raise kind("x")
        time.sleep(0.01)
        running.remove(at)

    with pytest.raises(kind):
        shared(job, range(100), number)
    assert running == [3]
