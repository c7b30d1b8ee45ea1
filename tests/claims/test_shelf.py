"""Large values of many operating states make room for each other, and are the same when they are computed again."""

from __future__ import annotations

import gc
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

from camgeom.maths import Floats, frozen
from camgeom.maths.frozen import shelved
from camgeom.model import Model
from camgeom.profile import from_data, read_data
from camgeom.report.result import chosen, compute
from tests.places import PROFILES


class Held:
    """What is asked for large values."""

    def __init__(self) -> None:
        self.made = 0

    @shelved
    def large(self) -> tuple[Floats, dict[str, Floats]]:
        """Half a kilobyte."""
        self.made += 1
        return np.zeros(32), {"more": np.zeros(32)}


def test_what_was_computed_before_the_latest_makes_room(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(frozen, "_SHELF", frozen._Shelf())
    monkeypatch.setattr(frozen, "SHELF", 3 * 512)
    every = [Held() for _ in range(4)]
    for one in every:
        first = one.large
        assert one.large is first
        assert not first[0].flags.writeable
    assert ["large" in vars(one) for one in every] == [True, True, False, True]
    assert every[2].large
    assert [one.made for one in every] == [1, 1, 2, 1]
    assert ["large" in vars(one) for one in every] == [True, True, True, False]
    assert frozen._SHELF._held == 3 * 512
    del every, one
    gc.collect()
    assert frozen._SHELF._held == 0  # what is gone has no room
    alone = Held()
    with ThreadPoolExecutor(8) as pool:
        assert all(pool.map(lambda _: alone.large, range(8)))
    assert frozen._SHELF._held == 512
    monkeypatch.setattr(frozen, "SHELF", 100)  # one that is larger than the room is kept as long as it is the last
    assert alone.large is alone.large


def test_owners_may_go_while_room_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    """The collector came between: a dictionary changed during its iteration, or had lost what was just found in it."""
    shelf = frozen._Shelf()
    monkeypatch.setattr(frozen, "_SHELF", shelf)
    monkeypatch.setattr(frozen, "SHELF", 2 * 512)
    every: list[Held] = []

    class Share(float):
        def __mul__(self, other: float) -> float:  # in the middle of the search
            every.clear()
            return float(self) * other

    found = shelf._next

    def gone(added: tuple[int, str]) -> tuple[int, str]:
        at = found(added)
        every.clear()
        return at

    for share, search in ((Share(0.5), found), (0.5, gone)):
        monkeypatch.setattr(frozen, "LATEST", share)
        shelf._next = search  # type: ignore[method-assign]
        every += [Held(), Held()]
        assert every[0].large
        assert every[1].large
        alone = Held()
        assert alone.large
        assert "large" in vars(alone)
        assert shelf._held == 512
        del alone
    assert shelf._held == 0


def test_states_that_make_room_have_the_same_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forty states of an indexer with [dynamics] and [tolerance] held 2 GB, and their run ended without a result."""
    data = read_data(PROFILES / "fine_indexer.toml")
    data["duty"] = tuple({"share": 0.25, "speed": data["operation"]["speed"] - number} for number in range(4))

    def figures(model: Model) -> dict[str, Any]:
        found = compute(model, *chosen("check", None)).data
        return {key: value for key, value in found.items() if key != "cost_s"}

    wide = figures(Model(from_data(data)))
    for room in (1_000_000, 3_000_000):
        monkeypatch.setattr(frozen, "_SHELF", frozen._Shelf())
        monkeypatch.setattr(frozen, "SHELF", room)
        assert figures(Model(from_data(data))) == wide
