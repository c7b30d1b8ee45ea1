"""Parts of the variance: even effects, errors with a direction, what acts together, and the linear case."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from camgeom.model import Model
from camgeom.profile import parse
from camgeom.tolerance.causes import ARCMIN
from camgeom.tolerance.shares import first_order, sums_of
from tests.reference.rising_disc import rising_disc

EVEN = 1.0 - 2.0 / pi
"""variance of |x| of a normal x of variance 1"""


def _shares(*lines: str) -> tuple[dict[str, float], float]:
    drawn = Model(parse("\n".join([rising_disc(), "[tolerance]", *lines, "samples = 21000\n"]))).tolerances.drawn
    return drawn.shares, drawn.together


@pytest.mark.parametrize("value", [0.2, 1.0, 5.0])
def test_a_tilt_that_acts_both_ways_alike_has_the_variance_of_its_size(value: float) -> None:
    """A 12 mm line on a tilted disc lifts by 6 mm |tilt|: (6 s)² (1 - 2/pi) beside the growth's own variance."""
    growth = 0.004
    shares, together = _shares(f"skew_arcmin = {value}", f"flank_growth = {growth}")
    tilt = EVEN * (6.0 * value * ARCMIN / 3.0) ** 2
    wanted = tilt / (tilt + (growth / 3.0) ** 2)
    assert shares["skew_arcmin"] == pytest.approx(wanted, abs=0.015)
    assert shares["skew_arcmin"] + shares["flank_growth"] == pytest.approx(1.0, abs=0.015)
    assert together < 0.015


def test_a_wobble_of_any_direction_is_seen_whatever_way_it_points() -> None:
    shares, together = _shares("cam_wobble_arcmin = 2", "flank_growth = 1e-6")
    assert shares["cam_wobble_arcmin"] == pytest.approx(1.0, abs=0.01)
    assert together < 0.015


def test_straight_errors_have_the_squares_of_what_they_do() -> None:
    """In a dwell 1 of both: 9 and 16 of 25 parts, however they are distributed."""
    for how in ("normal", "uniform", "worst"):
        given = (f'{key} = {{ value = {value}, distribution = "{how}" }}' for key, value in
                 (("center_distance", 0.03), ("flank_growth", 0.04)))  # fmt: skip
        shares, together = _shares(*given)
        assert shares["center_distance"] == pytest.approx(0.36, abs=0.015), how
        assert shares["flank_growth"] == pytest.approx(0.64, abs=0.015), how
        assert together < 0.015, how


def test_what_only_acts_together_is_left_to_neither() -> None:
    """x y of two normal numbers has no part in either alone (Sobol); x + y |z| half of it in x, where z is even."""
    x, y, z = np.random.default_rng(3).standard_normal((3, 1, 40960)).astype(np.float32)
    outcomes = np.concatenate([x * y, x + y * np.abs(z)])
    each = [first_order([sums_of([x, y, z], [outcomes[k : k + 1]])], np.ones((3, 1), dtype=bool)) for k in (0, 1)]
    assert each[0] == pytest.approx([0.0, 0.0, 0.0], abs=0.005)
    # y |z|: E[. | y] = y E|z|, so y alone explains 2/pi of its variance of 1
    assert each[1] == pytest.approx([0.5, 0.5 * 2.0 / pi, 0.0], abs=0.015)


def test_what_an_outcome_does_not_hang_on_explains_nothing_of_it() -> None:
    x, y = np.random.default_rng(4).standard_normal((2, 1, 500)).astype(np.float32)
    sums = sums_of([x, y], [x, x * 0.0])
    assert first_order([sums], np.array([[True, True], [False, False]])) == pytest.approx([1.0, 0.0], abs=1e-5)
    assert first_order([sums_of([x], [0.0 * x])], np.ones((1, 1), dtype=bool)) == pytest.approx([0.0])
