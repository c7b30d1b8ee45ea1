"""Hertz formulas against integrals of the half-space solutions, scipy's elliptic integrals and limits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate, optimize, special

from camgeom.errors import DesignError
from camgeom.mechanics import hertz
from camgeom.mechanics.contact import share_load, uniform_slices
from camgeom.mechanics.material import CAST_IRON, STEEL, Material, pair_compliance
from tests.reference.line_stress import line_stress

PAIR = pair_compliance(STEEL, STEEL)
WIDE = st.floats(-9.0, 9.0).map(lambda power: 10.0**power)


def approach(load, curvature, roller, cam, radius, depth):
    """Of roller axis and cam body, mm, under a load per length, N/mm."""
    return float(load * hertz.line_flexibility(load, curvature, roller, cam, radius, depth))


def crowned(stations, arc):
    """Gap, mm, of a roller crowned to a radius, mm, at its stations: arc - sqrt(arc² - x²) without its rounding."""
    return stations * (stations / (arc + np.sqrt((arc - stations) * (arc + stations))))


def test_pair_compliance_of_steel():
    assert pytest.approx(2.0 * 0.91 / 206000.0, rel=1e-14) == PAIR


@given(WIDE, WIDE)
def test_line_pressure_carries_the_load(load, curvature):
    pressure = hertz.line_pressure(load, curvature, PAIR)
    half = hertz.line_half_width(load, curvature, PAIR)
    assert float(np.pi / 2.0 * pressure * half) == pytest.approx(load, rel=1e-12)
    # The profile gap x² k/2 is closed by the pressure: b k / (2 compliance) = p0.
    assert float(half * curvature / (2.0 * PAIR)) == pytest.approx(float(pressure), rel=1e-12)


@given(WIDE, WIDE, WIDE)
def test_allowable_load_is_the_inverse_of_the_pressure(pressure, curvature, length):
    force = hertz.allowable_load(pressure, curvature, length, PAIR)
    assert float(hertz.line_pressure(force / length, curvature, PAIR)) == pytest.approx(pressure, rel=1e-12)


def flamant(x, z):
    """Stresses under the pressure sqrt(1 - t²), |t| < 1, by quadrature of point forces on the edge of a half-plane."""
    t, weight = np.polynomial.legendre.leggauss(400)
    angle, w = 0.5 * np.pi * t, 0.5 * np.pi * weight
    s = np.sin(angle)
    p = np.cos(angle) ** 2 * w
    d2 = ((x - s) ** 2 + z * z) ** 2
    scale = -2.0 / np.pi * z
    return (scale * np.sum(p * (x - s) ** 2 / d2), scale * z * z * np.sum(p / d2), scale * z * np.sum(p * (x - s) / d2))


@pytest.mark.parametrize(("x", "z"), [(0.0, 0.786), (0.3, 0.5), (-0.9, 0.2), (1.7, 0.4), (0.866, 0.5), (4.0, 6.0)])
def test_stress_field_is_the_integral_of_point_forces(x, z):
    np.testing.assert_allclose(line_stress(x, z), flamant(x, z), atol=1e-9)


def test_surface_of_the_half_space():
    inside, _, shear = line_stress(np.array([0.0, 0.6, -0.6]), 0.0)
    np.testing.assert_allclose(inside, [-1.0, -0.8, -0.8], atol=1e-14)
    np.testing.assert_allclose(shear, 0.0, atol=1e-14)
    outside = np.array(line_stress(np.array([1.0, 1.5, -2.0]), 0.0))
    np.testing.assert_allclose(outside, 0.0, atol=1e-14)


def test_stress_far_away_falls_off_like_a_line_force():
    far = 1e6
    _, down, _ = line_stress(0.0, far)
    # A line force of pi/2 at the surface: 2 P / (pi z).
    assert float(down) == pytest.approx(-1.0 / far, rel=1e-9)


def test_largest_shear_is_where_the_golden_section_says():
    z = np.linspace(0.0, 3.0, 30001)
    field = np.array(line_stress(0.0, z))
    shear = 0.5 * np.abs(field[0] - field[1])
    np.testing.assert_allclose(shear, z - z * z / np.sqrt(1.0 + z * z), atol=1e-14)
    assert shear.max() == pytest.approx(hertz.SHEAR_SHARE, abs=1e-9)
    assert z[shear.argmax()] == pytest.approx(hertz.SHEAR_DEPTH, abs=1e-4)
    assert pytest.approx(0.300, abs=5e-4) == hertz.SHEAR_SHARE
    assert pytest.approx(0.786, abs=5e-4) == hertz.SHEAR_DEPTH


def test_approach_is_the_integral_of_the_strain():
    load, curvature, radius, depth = 150.0, 1.0 / 11.0 - 1.0 / 60.0, 11.0, 30.0
    half = float(hertz.line_half_width(load, curvature, pair_compliance(STEEL, CAST_IRON)))
    peak = 2.0 * load / (np.pi * half)

    def body(z):
        across, down, _ = line_stress(0.0, z / half)
        nu = CAST_IRON.poisson
        return -float(down - nu / (1.0 - nu) * across) * peak * CAST_IRON.compliance

    def roller(z):
        # A disc pressed from opposite sides: line contact on one side, line force on the other, uniform tension.
        across, down, _ = line_stress(0.0, z / half)
        uniform = load / (np.pi * radius)
        opposite = 2.0 * load / (np.pi * (2.0 * radius - z))
        nu = STEEL.poisson
        along = float(down) * peak + uniform - opposite
        sideways = float(across) * peak + uniform
        return -(along - nu / (1.0 - nu) * sideways) * STEEL.compliance

    parts = [
        integrate.quad(body, 0.0, depth, limit=400, points=[half, 10 * half])[0],
        integrate.quad(roller, 0.0, radius, limit=400, points=[half, 10 * half])[0],
    ]
    found = approach(load, curvature, STEEL, CAST_IRON, radius, depth)
    assert found == pytest.approx(sum(parts), rel=2e-3)
    # Palmgren's rule for steel agrees within a fifth on an ordinary roller.
    steel = approach(load, 1.0 / 11.0, STEEL, STEEL, 11.0, 22.0)
    assert steel == pytest.approx(3.84e-5 * (load * 12.0) ** 0.9 / 12.0**0.8, rel=0.25)


def test_unusable_contacts_are_refused():
    with pytest.raises(DesignError, match="does not fit"):
        hertz.line_pressure(10.0, [0.1, 0.0], PAIR)
    with pytest.raises(DesignError, match="does not fit"):
        hertz.point_contact(10.0, -1e-9, 0.1, PAIR)
    with pytest.raises(ValueError, match="negative"):
        hertz.line_pressure(-1.0, 0.1, PAIR)
    with pytest.raises(DesignError, match="half-space"):
        hertz.line_flexibility(1e9, 0.1, STEEL, STEEL, 10.0, 10.0)
    assert float(hertz.line_pressure(0.0, 0.1, PAIR)) == 0.0


@pytest.mark.parametrize("ratio", [1e-9, 1e-4, 0.1, 0.5, 0.999, 1.0 - 1e-12, 1.0])
def test_elliptic_integrals_match_scipy(ratio):
    whole, d, b = (float(value) for value in hertz.elliptic(ratio))
    rest = ratio * ratio
    assert whole == pytest.approx(special.ellipkm1(rest), rel=1e-14)
    # Carlson: D = R_D(0, 1 - m, 1)/3, B = (1 - m) R_D(0, 1, 1 - m)/3 needs no difference of large numbers.
    assert d == pytest.approx(special.elliprd(0.0, rest, 1.0) / 3.0, rel=1e-13)
    assert b == pytest.approx(rest * special.elliprd(0.0, 1.0, rest) / 3.0, rel=1e-13)


def test_circular_contact_is_the_sphere_on_a_plane():
    contact = hertz.point_contact(50.0, 0.1, 0.1, PAIR)
    radius = (0.75 * 50.0 * PAIR / 0.1) ** (1.0 / 3.0)
    assert float(contact.long) == pytest.approx(radius, rel=1e-13)
    assert float(contact.short) == pytest.approx(radius, rel=1e-13)
    assert float(contact.pressure) == pytest.approx(1.5 * 50.0 / (np.pi * radius**2), rel=1e-13)
    assert float(contact.approach) == pytest.approx(radius**2 * 0.1, rel=1e-13)


@pytest.mark.parametrize("ratio", [1.3, 8.0, 300.0])
def test_elliptic_contact_closes_the_gap_everywhere(ratio):
    """The half-space under the found pressure ellipse sinks by approach minus profile gap at every point of it."""
    least, load = 0.02, 40.0
    contact = hertz.point_contact(load, least, least * ratio, PAIR)
    a, b = float(contact.long), float(contact.short)

    def potential(w, x, y):
        return (1.0 - x * x / (a * a + w) - y * y / (b * b + w)) / np.sqrt((a * a + w) * (b * b + w) * w)

    for x, y in ((0.0, 0.0), (0.7, 0.0), (0.0, 0.7), (0.5, -0.6)):
        # Displacement of a half-space under an ellipsoid of pressure: compliance p0 a b / 2 times this integral over w.
        def integrand(t, x=x, y=y):
            w = (t / (1.0 - t)) ** 2 * a * b
            return potential(w, a * x, b * y) * 2.0 * t / (1.0 - t) ** 3 * a * b if t > 0.0 else 0.0

        area = integrate.quad(integrand, 0.0, 1.0, limit=400, epsabs=0.0, epsrel=1e-11)[0]
        sunk = PAIR * float(contact.pressure) * a * b / 2.0 * area
        gap = 0.5 * least * (a * x) ** 2 + 0.5 * least * ratio * (b * y) ** 2
        assert sunk == pytest.approx(float(contact.approach) - gap, rel=1e-7)


@given(WIDE, WIDE, WIDE)
def test_elliptic_contact_at_any_ratio(load, one, two):
    contact = hertz.point_contact(load, one, two, PAIR)
    values = [float(x) for x in (contact.pressure, contact.long, contact.short, contact.approach)]
    assert np.isfinite(values).all()
    assert min(values) > 0.0
    assert values[1] >= values[2] * (1.0 - 1e-12)
    assert 2.0 / 3.0 * np.pi * values[0] * values[1] * values[2] == pytest.approx(load, rel=1e-12)


def test_long_ellipse_approaches_the_line_contact():
    contact = hertz.point_contact(100.0, 1e-9, 0.1, PAIR)
    # In the middle of a very long ellipse the load per length is pi/2 p0 b, as in a line contact.
    line = np.pi / 2.0 * contact.pressure * contact.short
    assert float(hertz.line_pressure(line, 0.1, PAIR)) == pytest.approx(float(contact.pressure), rel=1e-6)


STATIONS = np.linspace(-5.5, 5.5, 12)
WIDTHS = np.full(12, 1.0)


def test_alike_slices_share_alike():
    shared = share_load(1200.0, STATIONS, WIDTHS, 0.09, STEEL, STEEL, 11.0, 22.0)
    np.testing.assert_allclose(shared.line_load, 100.0, rtol=1e-12)
    np.testing.assert_allclose(uniform_slices(1200.0, WIDTHS)[0], 100.0)
    assert float(shared.approach) == pytest.approx(approach(100.0, 0.09, STEEL, STEEL, 11.0, 22.0))
    assert float(shared.centre) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("tilt", "force"), [(0.0, 900.0), (2e-4, 900.0), (3e-3, 900.0), (3e-3, 1e-3), (1e-9, 1e4)])
def test_slices_approach_alike(tilt, force):
    """Against a plain nested root search: the load of each slice for a given approach, then the approach."""
    curvature = 0.08 + 0.002 * STATIONS
    gaps = crowned(STATIONS, 5e4)
    cosines = 0.9 - 0.01 * STATIONS
    cam = Material(elastic_modulus=127000.0, poisson=0.25)
    found = share_load(force, STATIONS, WIDTHS, curvature, STEEL, cam, 11.0, 30.0, gaps, tilt, cosines)

    def line(reach, k):
        if reach <= 0.0:
            return 0.0
        return optimize.brentq(
            lambda log_w: approach(np.exp(log_w), k, STEEL, cam, 11.0, 30.0) - reach,
            -60.0,
            9.5,
            xtol=1e-14,
            rtol=1e-14,
        )

    def loads(reach):
        slices = reach * cosines - gaps - tilt * STATIONS
        return np.array([np.exp(line(s, k)) if s > 0.0 else 0.0 for s, k in zip(slices, curvature)])

    top = float(found.approach)
    np.testing.assert_allclose(found.line_load, loads(top), rtol=1e-8, atol=1e-8 * force)
    assert float((found.line_load * WIDTHS * cosines).sum()) == pytest.approx(force, rel=1e-11)


def test_tilted_roller_touches_with_one_end_only():
    shared = share_load(10.0, STATIONS, WIDTHS, 0.09, STEEL, STEEL, 11.0, 22.0, tilt=np.array([0.0, 1e-2, -1e-2]))
    assert list((shared.line_load > 0.0).sum(axis=-1)) == [12, 1, 1]
    assert float(shared.centre[1]) == -5.5
    assert float(shared.centre[2]) == 5.5


@given(st.floats(-9.0, 3.0), st.floats(-9.0, 0.0), st.floats(0.0, 9.0))
def test_slices_at_any_ratio(load, tilt, crown):
    gaps = crowned(STATIONS, 10.0 + 10.0**crown)
    shared = share_load(10.0**load, STATIONS, WIDTHS, 0.09, STEEL, STEEL, 11.0, 22.0, gaps, 10.0**tilt)
    assert float(shared.line_load.sum()) == pytest.approx(10.0**load, rel=1e-10)
    assert np.isfinite(shared.pressure).all()

