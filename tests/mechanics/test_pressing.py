"""Contact of a roller along a turn of many stretches: in blocks, to the same bits, and within a bound."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from camgeom.errors import NotConverged
from camgeom.mechanics import pressing
from camgeom.model import Model
from camgeom.profile import from_data, read_data
from tests.places import PROFILES

KINDS = ["pin_insertion", "conical_groove", "feeder_runout", "conjugate_rocker", "linear_groove", "misaligned_roller"]


def made(name: str) -> Model:
    return Model(from_data(read_data(PROFILES / f"{name}.toml")))


def values(walls: Any) -> list[Any]:
    return [part for field in fields(walls) for part in np.atleast_1d(getattr(walls, field.name))]


@pytest.mark.parametrize("name", KINDS)
def test_walls_in_blocks_are_the_same(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    duty = made(name).duties[0]
    at = duty.pressing.track.meridian.parameters(duty.pressing.middles)
    each = np.broadcast_to(at, (duty.force.panels.theta.size, len(at)))
    for t in (at, each, at[:1]):
        whole = values(duty.pressing.walls(t))
        with monkeypatch.context() as patched:
            patched.setattr(pressing, "BLOCK", 1000)
            blocks = values(duty.pressing.walls(t))
        assert len(whole) == len(blocks) > 6
        assert all(np.array_equal(one, other) for one, other in zip(whole, blocks, strict=True))


def test_stretches_of_a_turn_are_followed_up_to_a_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    """A drum of 3 000 segments took 6.3 GB, and more time than a run has."""
    count = len(made("pin_insertion").duties[0].force.panels.half)
    for most in (count, count - 1):
        monkeypatch.setattr(pressing, "MOST_PRESSED", most)
        duty = made("pin_insertion").duties[0]
        if most == count:
            assert duty.slices
            continue
        with pytest.raises(NotConverged, match=rf"takes {count} stretches of the turn, more than the {most} it is"):
            _ = duty.slices
