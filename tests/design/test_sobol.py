"""Sobol points against scipy's."""

import numpy as np
import pytest
from scipy.stats import qmc

from camgeom.design.study import MOST_DRAWN_AXES
from camgeom.maths.sobol import AXES, sobol


@pytest.mark.parametrize("axes", [1, 2, 3, 17, 64])
@pytest.mark.parametrize("first", [0, 1, 4095, 70_000_001])
def test_points_are_scipys(axes: int, first: int) -> None:
    """To the last bit, wherever they begin; those of another seed are others."""
    theirs = qmc.Sobol(axes, rng=np.random.default_rng(5))
    if first:
        theirs.fast_forward(first)
    expected = np.concatenate([theirs.random(1), theirs.random(9)])
    assert np.array_equal(sobol(axes, 5, first, 10), expected)
    assert not np.array_equal(sobol(axes, 6, first, 10), expected)


def test_there_are_axes_for_all_that_can_be_drawn() -> None:
    """The first one has no polynomial."""
    assert len(AXES.split()) + 1 == MOST_DRAWN_AXES
