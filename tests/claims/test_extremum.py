"""Largest values are found to rounding: few samples where a function is smooth, narrowing brackets where it is not."""

from __future__ import annotations

import numpy as np
import pytest

from camgeom.maths.extremum import FAN, ROUNDS, bracketed_maximum, refined_maximum

LOW = np.array([0.3, 1.1, 2.0, 5.9])
WIDE = 0.0174
PEAK = (LOW + WIDE * np.array([0.031, 0.27, 0.5001, 0.93]))[:, None]


def counted(f):
    calls = []

    def g(x):
        calls.append(x.shape)
        return f(x)

    return g, calls


@pytest.mark.parametrize(
    ("f", "top"),
    [
        (lambda x: 2.0 - (x - PEAK) ** 2 + 5.0 * (x - PEAK) ** 3, 2.0),
        (lambda x: 1.0 / (1.0 + (30.0 * (x - PEAK)) ** 2), 1.0),
        (lambda x: -1.0 - (x - PEAK) ** 4, -1.0),
        (lambda x: np.ones_like(x), 1.0),
        (lambda x: np.zeros_like(x), 0.0),
        (lambda x: x, (LOW + WIDE)[:, None]),
        (lambda x: -(x**3), -(LOW**3)[:, None]),
    ],
)
def test_a_smooth_maximum_takes_few_samples(f, top) -> None:
    g, calls = counted(f)
    value, place = bracketed_maximum(g, LOW, LOW + WIDE)
    assert np.abs(value - np.ravel(top)).max() <= 1e-15 * np.abs(top).max() + 1e-300
    assert np.array_equal(f(place[:, None]), value[:, None])
    assert len(calls) <= 4
    assert all(shape == (4, FAN) for shape in calls)


@pytest.mark.parametrize(
    ("f", "top", "within"),
    [
        (lambda x: 2.0 - np.abs(x - PEAK), 2.0, 1e-9),
        (lambda x: np.minimum(1.0 + x - PEAK, 1.0 - 2.0 * (x - PEAK) - 9.0 * (x - PEAK) ** 2), 1.0, 1e-9),
        (lambda x: np.where(x <= PEAK, 1.0 + x - PEAK, -np.inf), 1.0, 1e-9),
        (lambda x: 1.0 / (1.0 + (3000.0 * (x - PEAK)) ** 2), 1.0, 1e-14),
    ],
)
def test_kinks_jumps_and_spikes_are_narrowed_down(f, top, within) -> None:
    """No parabola tells where they are; a bracket that a false one led out of is taken up again."""
    g, calls = counted(f)
    value, place = bracketed_maximum(g, LOW, LOW + WIDE)
    assert np.abs(value - top).max() < within
    assert np.abs(place - PEAK[:, 0]).max() < 1e-8
    assert len(calls) <= ROUNDS + 4


def test_the_higher_of_two_peaks_wins_though_its_samples_are_lower() -> None:
    x = np.linspace(0.0, 1.0, 21)
    owner = np.zeros(21, dtype=np.int64)

    def f(at):
        # The left peak stands on a sample, the right one between two and 1e-4 higher.
        return np.maximum(1.0 - 8.0 * (at - 0.25) ** 2, 1.0001 - 8.0 * (at - 0.775) ** 2)

    assert f(x).argmax() == 5
    assert refined_maximum(f, x, owner, f(x)) == pytest.approx((1.0001, 0.775), abs=1e-8)
    lower = refined_maximum(lambda at: f(at) - 0.0002 * (at > 0.5), x, owner, f(x) - 0.0002 * (x > 0.5))
    assert lower == pytest.approx((1.0, 0.25), abs=1e-8)


def test_what_is_nowhere_finite_on_one_side_is_no_number_of_its_own() -> None:
    x = np.linspace(0.0, 1.0, 21)
    owner = np.zeros(21, dtype=np.int64)

    def f(at):
        return np.where(at < 0.52, at, -np.inf)

    value, place = refined_maximum(f, x, owner, f(x))
    assert (value, place) == pytest.approx((0.52, 0.52), abs=1e-8)
    assert value < 0.52


def test_a_kink_is_met_where_both_sides_meet_and_rivals_stop_early() -> None:
    """Twelve rounds without the two parabolas; a lower row, a jump among them, is left as soon as it cannot win."""

    def kink(x):
        return np.minimum(1.0 + 3.0 * (x - PEAK), 1.0 - 2.0 * (x - PEAK) - 9.0 * (x - PEAK) ** 2)

    g, calls = counted(kink)
    value, place = bracketed_maximum(g, LOW, LOW + WIDE)
    assert np.abs(value - 1.0).max() < 1e-13
    assert np.abs(place - PEAK[:, 0]).max() < 1e-13
    assert len(calls) <= 8
    with np.errstate(all="raise"):  # as large as a curvature beside a cusp
        huge, there = bracketed_maximum(lambda x: 2.0**700 * kink(x), LOW, LOW + WIDE)
    np.testing.assert_array_equal([huge * 2.0**-700, there], [value, place])

    def several(x):
        height = np.arange(4.0)[:, None]
        return np.where((height == 0.0) & (x > PEAK), -np.inf, height - (x - PEAK) ** 2)

    taken = []
    for least in (0.0, None):
        g, calls = counted(several)
        value, _ = bracketed_maximum(g, LOW, LOW + WIDE, least=least)
        assert value.max() == pytest.approx(3.0, abs=1e-15)
        taken.append(len(calls))
    assert taken[0] <= 3 < taken[1]
    with np.errstate(all="raise"):
        value, _ = bracketed_maximum(lambda x: np.full(x.shape, -np.inf), LOW, LOW + WIDE, least=0.0)
    assert (value == -np.inf).all()
