"""A process of its own for a library that ends, holds up or fills the process that it runs in.

A worker is one object in another process, whose methods are asked one after the other. It ends with the process that
started it; where it ends before, or does not answer in time, that is an error of what was asked and of nothing else.
"""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from importlib import import_module
from typing import Any, final

from camgeom.errors import CamgeomError
from camgeom.interrupts import beginning_children, hear_none

_PATIENCE, _START = 5.0, 120.0
"""s, until a worker that was told to end is killed, and within which one has made its object"""
_TIMED_OUT = 124
_LATE = (_TIMED_OUT, -14)
"""exit statuses of a worker whose time was over: its own, and that of an alarm"""


class WorkerEnded(CamgeomError):
    """The worker's process ended while it was asked; the text says how, and ends a sentence about what was asked."""


@final
class Worker:
    """An object that `maker` ("module:callable", without arguments) makes in a process of its own.

    Raises OSError where no process can be started.
    """

    def __init__(self, maker: str, environment: Mapping[str, str] | None = None) -> None:
        code = f"import sys; sys.path[:] = {sys.path!r}; from camgeom.worker import serve; serve({maker!r})"
        pipe = subprocess.PIPE
        with beginning_children():
            self._process = subprocess.Popen(
                [sys.executable, "-c", code], stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL,
                env={**os.environ, **(environment or {})},
            )  # fmt: skip
        self._lock = threading.Lock()

    @property
    def ended(self) -> bool:
        """Whether the process is gone."""
        return self._process.poll() is not None

    def ask(self, what: str, *arguments: Any, seconds: float) -> Any:
        """What a method gives for arguments that can be pickled.

        Raises what it raises; WorkerEnded where the process ends, or does not answer within so many seconds.
        """
        sent, got = self._process.stdin, self._process.stdout
        assert sent is not None
        assert got is not None
        with self._lock:
            try:
                pickle.dump((what, arguments, seconds), sent, pickle.HIGHEST_PROTOCOL)
                sent.flush()
                answer, error = pickle.load(got)
            except (OSError, EOFError, ValueError, pickle.UnpicklingError):
                raise WorkerEnded(self._end(seconds)) from None
        if error is not None:
            raise error
        return answer

    def _end(self, seconds: float) -> str:
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(_PATIENCE)
        self._process.kill()
        code = self._process.wait()
        if code in _LATE:
            return f"took more than {seconds:g} s"
        if code >= 0:
            return f"ended with status {code}"
        return f"ended by signal {-code} ({signal.strsignal(-code)})"

    def close(self) -> None:
        """End the process."""
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                with suppress(OSError):
                    pipe.close()
        try:
            self._process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


def serve(maker: str) -> None:
    """Answer the process that started this one until it is gone; for Worker alone."""
    hear_none()
    # What libraries print does not belong between the answers.
    asked, answers = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    module, name = maker.split(":")
    with _ending_after(_START):
        made: Callable[[], Any] = getattr(import_module(module), name)
        work = made()
    while True:
        try:
            what, arguments, seconds = pickle.load(asked)
        except EOFError:
            os._exit(0)
        answer: Any = None
        error: Exception | None = None
        try:
            with _ending_after(seconds):
                answer = getattr(work, what)(*arguments)
        except Exception as raised:
            error = raised
        try:
            pickle.dump((answer, error), answers, pickle.HIGHEST_PROTOCOL)
            answers.flush()
        except BrokenPipeError:
            os._exit(0)


@contextmanager
def _ending_after(seconds: float) -> Iterator[None]:
    """Within it this process ends after so many seconds, where there are alarms even if a library never comes back."""
    if sys.platform != "win32":
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.setitimer(signal.ITIMER_REAL, seconds)
        try:
            yield
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
        return
    clock = threading.Timer(seconds, os._exit, [_TIMED_OUT])
    clock.daemon = True
    clock.start()
    try:
        yield
    finally:
        clock.cancel()
