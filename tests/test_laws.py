"""The catalogue of motion laws: exact values, end conditions, jets against independent differences."""

from __future__ import annotations

import math

import numpy as np
import pytest

from camgeom.errors import ProfileError
from camgeom.motion import LAWS, make

EXACT = {
    "modified-sine": (1.759603, 5.527957, 69.466357),
    "modified-trapezoid": (2.0, 4.888124, 61.425975),
    "modified-constant-velocity": (1.275258, 8.012683, 201.381),
    "3-4-5": (1.875, 10 / math.sqrt(3), 60.0),
    "cycloidal": (2.0, 2 * math.pi, 4 * math.pi**2),
    "4-5-6-7": (2.1875, 7.51318840, 52.5),
}


@pytest.mark.parametrize("name", EXACT)
def test_peaks_stand_in_the_books(name: str) -> None:
    peaks = make(name).peaks()
    assert (peaks.vm, peaks.am) == pytest.approx(EXACT[name][:2], abs=6e-7)
    assert peaks.jm == pytest.approx(EXACT[name][2], rel=2e-6)


@pytest.mark.parametrize("name", LAWS)
def test_runs_from_zero_to_one_exactly(name: str) -> None:
    law = make(name)
    assert law.jet(0.0)[0] == 0.0
    assert law.jet(1.0, side="left")[0] == 1.0


@pytest.mark.parametrize("name", LAWS)
def test_each_derivative_is_the_slope_of_the_one_before(name: str) -> None:
    law = make(name)
    x = (np.arange(400) + 0.5) / 400
    step = 1e-6
    near_knot = np.min(np.abs(x[:, None] - np.array(law.knots)), axis=1) < 2 * step
    x = x[~near_knot]
    high, low, jets = law.jet(x + step, 3), law.jet(x - step, 3), law.jet(x, 4)
    np.testing.assert_allclose((high - low) / (2 * step), jets[1:], rtol=1e-7, atol=1e-7 * np.abs(jets).max())


def test_an_unknown_law_is_told_the_nearest_spelling() -> None:
    with pytest.raises(ProfileError, match="modified-sine"):
        make("modifed-sine")


def test_every_bad_parameter_is_named_at_once() -> None:
    with pytest.raises(ProfileError) as caught:
        make("modified-constant-velocity", shar=0.5, rise=2.0)
    assert [problem.key for problem in caught.value.problems] == ["shar", "rise"]
