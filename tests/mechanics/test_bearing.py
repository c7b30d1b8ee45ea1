"""Roller bearing life, stud and shaft against plain sums and textbook numbers."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate

from camgeom.maths.panels import TURN, panels
from camgeom.mechanics import groove
from camgeom.mechanics.bearing import (
    bearing_life,
    mean_load,
    rated_hours,
    required_rating,
    shaft_stress,
    span_moment,
    stud_stress,
)
from tests.reference.pin_machine import PIN_MOTION, PITCH_RADIUS, ROLLER_RADIUS, SPEED, pin_load

PIN = pin_load().sampled()
RATE = groove.path_rate(PITCH_RADIUS, PIN.ds)
NORMAL = PIN.normal(groove.cos_pressure_angle(PITCH_RADIUS, PIN.ds))
WIDE = st.floats(-9.0, 9.0).map(lambda power: 10.0**power)


def test_mean_load_against_a_fine_sum():
    theta = (np.arange(300_000) + 0.5) / 300_000 * TURN
    force, rate = np.abs(PIN.panels.at(NORMAL, theta)), np.hypot(PITCH_RADIUS, PIN_MOTION.jet(theta, 1)[1])
    expected = ((force ** (10 / 3) * rate).sum() / rate.sum()) ** 0.3
    assert float(mean_load(PIN.panels, NORMAL, RATE)) == pytest.approx(expected, rel=1e-6)


def test_life_of_the_pin_roller():
    found = bearing_life(PIN.panels, NORMAL, RATE, ROLLER_RADIUS, SPEED, rating=9000.0, static_rating=12000.0)
    path = integrate.quad(
        lambda t: float(np.hypot(PITCH_RADIUS, PIN_MOTION.jet(np.array([t]), 1)[1, 0])),
        0.0,
        TURN,
        points=list(PIN_MOTION.knots),
        limit=200,
    )[0]
    turns_per_hour = 600 * 60 * path / (2 * np.pi * ROLLER_RADIUS)
    assert float(found.speed) == pytest.approx(turns_per_hour / 3600 * 2 * np.pi, rel=1e-10)
    turns = (9000 / float(found.mean_load)) ** (10 / 3) * 1e6
    assert float(found.life_h) == pytest.approx(turns / turns_per_hour, rel=1e-10)
    edges = PIN.panels.edges
    angles = np.concatenate([edges, np.nextafter(edges[1:], 0.0), np.linspace(0.0, TURN, 20_001)])
    most = np.abs(PIN.panels.at(NORMAL, angles)).max()
    assert most > np.abs(NORMAL).max()
    assert float(found.static_safety) == pytest.approx(12000.0 / most, rel=1e-6)


def test_constant_load_is_its_own_mean_and_variants_broadcast():
    where = panels([0.0, TURN])
    load = np.array([1e-9, 1.0, 1e9])[:, None, None] + 0.0 * where.theta
    np.testing.assert_allclose(mean_load(where, load, 1.0 + 0 * where.theta), [1e-9, 1.0, 1e9], rtol=1e-12)
    found = bearing_life(where, load, 10.0 + 0 * where.theta, 5.0, np.array([1.0, 2.0, 4.0]), 1e3, 1e3)
    np.testing.assert_allclose(found.speed, [2.0, 4.0, 8.0])
    assert (np.diff(found.life_h) < 0).all()


def test_no_load_lasts_for_ever():
    where = panels([0.0, TURN])
    found = bearing_life(where, 0 * where.theta, 1.0 + 0 * where.theta, 5.0, 1.0, 1e3, 1e3)
    assert float(found.life_h) == float(found.static_safety) == np.inf


@given(WIDE, st.floats(1.0, 1e6), st.floats(1e-3, 1e3))
def test_required_rating_is_the_inverse_of_the_life(load, life, speed):
    rating = required_rating(load, life, speed)
    assert float(rated_hours(rating, load, speed)) == pytest.approx(life, rel=1e-9)


def test_required_rating_in_the_form_of_the_specification():
    # F = C (10^6 / (60 L_h n))^(3/10) with n = 500 r/min, L_h = 20000 h.
    c = float(required_rating(1000.0, 20000.0, 500 * 2 * np.pi / 60))
    assert c * (1e6 / (60 * 20000 * 500)) ** 0.3 == pytest.approx(1000.0, rel=1e-12)


def section(diameter, bore=0.0):
    """Second moment of a ring section by quadrature."""
    return integrate.quad(lambda r: np.pi * r**3, bore / 2, diameter / 2)[0]


def test_stud():
    found = stud_stress(-500.0, 20.0, 8.0)
    assert float(found.bending) == pytest.approx(500 * 20 * 4 / section(8.0), rel=1e-12)
    assert float(found.shear) == pytest.approx(500 / (np.pi * 16), rel=1e-12)
    assert float(found.mises) == pytest.approx(np.sqrt(found.bending**2 + 3 * found.shear**2), rel=1e-12)


def test_shaft():
    found = shaft_stress(2e5, 1e5, 40.0, 20.0)
    assert float(found.bending) == pytest.approx(2e5 * 20 / section(40.0, 20.0), rel=1e-12)
    assert float(found.shear) == pytest.approx(1e5 * 20 / (2 * section(40.0, 20.0)), rel=1e-12)
    assert float(found.mises) == pytest.approx(float(np.hypot(found.bending, np.sqrt(3) * found.shear)))
    assert float(shaft_stress(0.0, 1.0, 10.0).mises) > 0
    with pytest.raises(ValueError, match="bore"):
        shaft_stress(1.0, 1.0, 20.0, 20.0)
    assert float(span_moment(-100.0, 30.0, 60.0)) == pytest.approx(2000.0)
