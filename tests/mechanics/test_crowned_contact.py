"""Contact of a crowned roller, what lies below it, and damage of a face that is swept to and fro."""

from __future__ import annotations

import numpy as np
import pytest

from camgeom.mechanics import hertz
from camgeom.mechanics.life import swept_damage
from camgeom.mechanics.material import STEEL, pair_compliance

PAIR = pair_compliance(STEEL, STEEL)


@pytest.mark.parametrize(
    ("cam", "line", "peaks"),
    [
        (55.0, 461.4, (596.2, 933.0, 1315.7, 1981.6)),
        (np.inf, 424.432, (550.448, 863.552, 1223.256, 1861.222)),
    ],
)
def test_crowns_against_the_exact_ellipse(cam: float, line: float, peaks: tuple[float, ...]) -> None:
    """500 N on a roller of 20 mm diameter and 10 mm length, on a disc of 55 mm radius and on a plane."""
    k = 1.0 / 10.0 + 1.0 / cam
    assert float(hertz.line_pressure(50.0, k, PAIR)) == pytest.approx(line, rel=1e-4)
    for crown, peak in zip((5000.0, 500.0, 100.0, 20.0), peaks):
        found = hertz.crowned_contact(500.0, 1.0 / crown, k, PAIR, 10.0)
        assert not found.truncated
        assert float(found.pressure) == pytest.approx(peak, rel=1e-4)


def test_a_long_ellipse_joins_the_exact_one_and_the_line() -> None:
    k, load, length = 0.1, 500.0, 10.0
    exact = hertz.point_contact(load, 1.0 / 5000.0, k, PAIR)
    for factor, truncated in ((1.002, False), (0.999, True)):
        found = hertz.crowned_contact(load, 1.0 / 5000.0, k, PAIR, 2.0 * factor * float(exact.long))
        assert bool(found.truncated) is truncated
        assert float(found.pressure) == pytest.approx(float(exact.pressure), rel=2e-6)
    flat = hertz.crowned_contact(load, 1e-10, k, PAIR, length)
    assert float(flat.pressure) == pytest.approx(float(hertz.line_pressure(load / length, k, PAIR)), rel=1e-5)
    crowns = np.geomspace(50.0, 1e7, 60)
    assert np.all(np.diff(hertz.crowned_contact(load, 1.0 / crowns, k, PAIR, length).pressure) < 0.0)


def test_a_long_ellipse_carries_the_load_within_the_length() -> None:
    found = hertz.crowned_contact(500.0, 1e-6, 0.1, PAIR, 10.0)
    x = np.linspace(-5.0, 5.0, 200001)
    share = 1.0 - (x / float(found.along)) ** 2
    carried = np.trapezoid(0.5 * np.pi * float(found.pressure * found.around) * share, x)
    assert carried == pytest.approx(500.0, rel=1e-9)


@pytest.mark.parametrize(
    ("ratio", "share", "depth"), [(1.0, 0.310021, 0.480864), (0.6, 0.322123, 0.596174), (0.2, 0.321477, 0.740492)]
)
def test_largest_shear_below_an_ellipse(ratio: float, share: float, depth: float) -> None:
    """Johnson, equation 3.69, at a Poisson ratio of 0.3."""
    found = hertz.point_shear(ratio, 0.3)
    assert found == pytest.approx((share, depth), rel=2e-5)


def test_largest_shear_of_a_long_ellipse_is_that_of_a_line() -> None:
    share, depth = hertz.point_shear(1e-4, 0.3)
    assert share == pytest.approx(hertz.SHEAR_SHARE, rel=2e-3)
    assert depth == pytest.approx(hertz.SHEAR_DEPTH, rel=2e-3)
    line = hertz.beneath_line(1000.0, 0.1, PAIR)
    assert line.half_width == pytest.approx(2.0 * 1000.0 * PAIR / 0.1)
    assert line.shear == pytest.approx(300.283, abs=1e-3)
    assert hertz.beneath_point(0.0, 0.0, 0.0, 0.3) == hertz.Beneath(0.0, 0.0, 0.0)


def _stepped(place: np.ndarray, damage: np.ndarray, points: np.ndarray) -> float:
    """Damage of the points by walking along the path and counting every crossing."""
    total = np.zeros(len(points))
    for a, b, d, e in zip(place, np.roll(place, -1), damage, np.roll(damage, -1)):
        if a != b:
            inside = (points > min(a, b)) & (points <= max(a, b))
            total += np.where(inside, d + (e - d) * (points - a) / (b - a), 0.0)
    return float(total.max())


def test_a_face_sums_the_passes_over_its_points() -> None:
    phi = np.linspace(0.0, 2.0 * np.pi, 7200, endpoint=False)
    place = np.sin(phi) + 0.4 * np.sin(3.0 * phi)
    damage = 1.0 + 0.5 * np.cos(phi) ** 2
    points = np.linspace(-1.39, 1.39, 4001)
    assert swept_damage(place, damage) == pytest.approx(_stepped(place, damage, points), rel=2e-3)
    assert swept_damage(place, 2.0 * damage) == pytest.approx(2.0 * swept_damage(place, damage))
    # To and fro: two passes; where it rests, once.
    assert swept_damage(np.sin(phi), np.ones(7200)) == pytest.approx(2.0)
    assert swept_damage(np.zeros(7200), damage) == pytest.approx(1.5)
    assert swept_damage(np.maximum(np.sin(phi), 0.0), np.ones(7200)) == pytest.approx(2.0)
