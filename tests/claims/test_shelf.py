"""Large values of many operating states make room for each other, and are the same when they are computed again."""

from __future__ import annotations

import gc

import numpy as np
import pytest

from camgeom.maths import Floats, frozen
from camgeom.maths.frozen import shelved
from camgeom.model import Model
from camgeom.profile import from_data, read_data
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


def test_the_latest_values_are_kept_up_to_the_room_of_all(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(frozen, "_SHELF", frozen._Shelf())
    monkeypatch.setattr(frozen, "SHELF", 3 * 512)
    every = [Held() for _ in range(4)]
    for one in every:
        first = one.large
        assert one.large is first
        assert not first[0].flags.writeable
    assert ["large" in vars(one) for one in every] == [False, True, True, True]
    assert every[0].large
    assert [one.made for one in every] == [2, 1, 1, 1]
    assert "large" not in vars(every[1])
    del every
    gc.collect()
    alone = Held()
    monkeypatch.setattr(frozen, "SHELF", 100)  # one that is larger than the room is kept as long as it is the last
    assert alone.large is alone.large


def test_states_that_make_room_have_the_same_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forty states of an indexer with [dynamics] and [tolerance] held 2 GB, and their run ended without a result."""
    data = read_data(PROFILES / "fine_indexer.toml")
    data["duty"] = tuple({"share": 0.25, "speed": data["operation"]["speed"] - number} for number in range(4))

    def figures(model: Model) -> list[float]:
        duties = [one.turret_duty for one in model.states]
        found = [duty.least_peak.value for duty in duties if duty is not None and duty.least_peak is not None]
        return found + [float(duty.pressure.max()) for duty in duties if duty is not None]

    wide = figures(Model(from_data(data)))
    monkeypatch.setattr(frozen, "_SHELF", frozen._Shelf())
    monkeypatch.setattr(frozen, "SHELF", 1_000_000)
    model = Model(from_data(data))
    assert figures(model) == figures(model) == wide
