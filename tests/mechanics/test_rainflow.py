"""Rainflow counting against the standard's own example and plain cases."""

from __future__ import annotations

import numpy as np
import pytest

from camgeom.mechanics.rainflow import rainflow, reversals


def counted(history) -> dict[float, float]:
    """Counts by range."""
    cycles = rainflow(history)
    return {float(size): float(cycles.count[cycles.range == size].sum()) for size in np.unique(cycles.range)}


def test_the_example_of_astm_e1049():
    # ASTM E1049-85 (2017), figure 6: A to I.
    history = [-2, 1, -3, 5, -1, 3, -4, 4, -2]
    assert counted(history) == {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}
    cycles = rainflow(history)
    closed = cycles.count == 1.0
    assert cycles.range[closed].tolist() == [4.0]
    assert cycles.mean[closed].tolist() == [1.0]


def test_samples_between_turning_points_and_equal_ones_change_nothing():
    assert reversals([0, 1, 1, 2, 0, 0, -1, 3]) == [0.0, 2.0, -1.0, 3.0]
    fine = np.interp(np.linspace(0, 8, 8 * 50 + 1), np.arange(9), [-2, 1, -3, 5, -1, 3, -4, 4, -2])
    assert counted(fine) == pytest.approx(counted([-2, 1, -3, 5, -1, 3, -4, 4, -2]))


def test_a_sine_of_equal_swings_is_as_many_cycles():
    found = counted([0.0, *([1.0, -1.0] * 20), 0.0])
    assert found[2.0] == 19.5
    with pytest.raises(ValueError, match="never changes"):
        rainflow([2.0, 2.0])
