"""A worker answers, raises what its object raises, and where it ends or holds up costs what it was asked alone."""

from __future__ import annotations

import os
import time

import numpy as np
import pytest

from camgeom.errors import DesignError
from camgeom.worker import Worker, WorkerEnded


class Subject:
    """What the tests ask."""

    def double(self, values: np.ndarray) -> np.ndarray:
        print("libraries print what they like")
        return 2.0 * values

    def refuse(self) -> None:
        raise DesignError("no such cam")

    def sleep(self) -> None:
        time.sleep(60.0)

    def leave(self, status: int) -> None:
        os._exit(status)

    def crash(self) -> None:
        os.abort()


@pytest.fixture
def worker():
    made = Worker("tests.claims.test_worker:Subject")
    yield made
    made.close()


def test_it_answers_again_and_again_and_raises_what_its_object_raises(worker: Worker) -> None:
    values = np.arange(100_000.0)
    for _ in range(2):
        np.testing.assert_array_equal(worker.ask("double", values, seconds=60.0), 2.0 * values)
        with pytest.raises(DesignError, match=r"^no such cam$"):
            worker.ask("refuse", seconds=60.0)
    assert not worker.ended


@pytest.mark.parametrize(
    ("what", "arguments", "seconds", "said"),
    [
        ("crash", (), 60.0, r"^ended by signal 6 \(Aborted\)$"),
        ("leave", (3,), 60.0, "^ended with status 3$"),
        ("sleep", (), 0.5, r"^took more than 0\.5 s$"),
    ],
)
def test_an_end_is_told(worker: Worker, what: str, arguments: tuple[int, ...], seconds: float, said: str) -> None:
    with pytest.raises(WorkerEnded, match=said):
        worker.ask(what, *arguments, seconds=seconds)
    assert worker.ended
    with pytest.raises(WorkerEnded):
        worker.ask("double", np.zeros(3), seconds=60.0)


def test_it_ends_with_who_started_it(worker: Worker) -> None:
    worker.close()
    assert worker.ended
