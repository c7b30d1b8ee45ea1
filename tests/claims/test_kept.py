"""A derived value is made once, and so is its refusal."""

from __future__ import annotations

import numpy as np
import pytest

from camgeom.errors import NotConverged, Problem, ProfileError
from camgeom.maths.frozen import cached_property


class Asked:
    def __init__(self) -> None:
        self.times = 0

    @cached_property
    def value(self) -> np.ndarray:
        self.times += 1
        return np.zeros(3)

    @cached_property
    def refused(self) -> float:
        self.times += 1
        raise ProfileError([Problem("cam.width", "is too small", 1.0, "above 2 mm")], "my.toml")

    @cached_property
    def lost(self) -> float:
        self.times += 1
        raise NotConverged("no steps left")

    @cached_property
    def too_large(self) -> float:
        self.times += 1
        raise MemoryError

    @cached_property
    def broken(self) -> float:
        self.times += 1
        raise ZeroDivisionError


def test_a_value_and_a_refusal_are_kept_and_a_bug_is_not() -> None:
    asked = Asked()
    assert asked.value is asked.value
    assert not asked.value.flags.writeable
    assert asked.times == 1
    for name, error in (("refused", ProfileError), ("lost", NotConverged), ("too_large", MemoryError)):
        asked.times, told = 0, []
        for _ in range(3):
            with pytest.raises(error) as caught:
                getattr(asked, name)
            told.append(str(caught.value))
        assert asked.times == 1
        assert len(set(told)) == 1
    asked.times = 0
    for _ in range(2):
        with pytest.raises(ZeroDivisionError):
            _ = asked.broken
    assert asked.times == 2
