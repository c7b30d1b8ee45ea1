"""Contact of a crowned roller, what lies below it, and damage of a face that is swept to and fro."""

from __future__ import annotations

import numpy as np
import pytest

from camgeom.maths import Floats
from camgeom.mechanics import hertz
from camgeom.mechanics.life import swept_damage
from camgeom.mechanics.material import STEEL, pair_compliance
from tests.reference import half_space

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


FINITE = (
    # load N, crown radius mm, relative curvature 1/mm, length mm; formula over solver in the middle and outermost ninth
    (500.0, 8833.0, 0.1, 10.0, 1.003, 0.990),
    (500.0, 15635.0, 0.1, 10.0, 1.012, 0.957),
    (20000.0, 1000.0, 0.12, 12.0, 1.018, 0.934),
    (3000.0, 20000.0, 0.05, 16.0, 1.024, 0.930),
    (50.0, 50000.0, 0.2, 6.0, 1.018, 0.950),
    (500.0, 31126.0, 0.1, 10.0, 1.0235, 0.936),
    (500.0, 82955.0, 0.1, 10.0, 1.035, 0.921),
    (20000.0, 5000.0, 0.12, 12.0, 1.055, 0.880),
    (500.0, 1e9, 0.1, 10.0, 1.046, 0.910),
)


def finite_roller(load: float, crown: float, k: float, length: float) -> tuple[hertz.CrownedContact, Floats, Floats]:
    """Formula, its pressure in nine slices and the line pressure of theirs in the half-space solution, MPa."""
    found = hertz.crowned_contact(load, 1.0 / crown, k, PAIR, length)
    wide, long = 2.7 * float(found.around), min(length, 2.3 * float(found.along))
    dx, dy = wide / 24, long / 90
    x, y = (np.arange(24) + 0.5) * dx - 0.5 * wide, (np.arange(90) + 0.5) * dy - 0.5 * long
    pressure = half_space.pressed(0.5 * k * x[:, None] ** 2 + 0.5 * y**2 / crown, dx, dy, PAIR, load)
    line_load = pressure.sum(axis=0).reshape(9, -1).mean(axis=1) * dx
    middles = ((np.arange(9) + 0.5) / 9.0 - 0.5) * long
    formula = found.pressure * np.sqrt(np.maximum(1.0 - (middles / found.along) ** 2, 0.0))
    return found, formula, hertz.line_pressure(line_load, k, PAIR)


def test_the_half_space_solver_finds_the_exact_ellipse() -> None:
    found, formula, solved = finite_roller(500.0, 100.0, 0.1, 10.0)
    assert not found.truncated
    # A slice of the ellipse as a line: w k / (pi c) is its pressure but for the curvature of the crown.
    assert solved[4] == pytest.approx(formula[4], rel=0.022)
    assert half_space.love(np.array([1e3]), np.array([0.3]), 0.5, 0.5) == pytest.approx(1e-3, rel=1e-5)


@pytest.mark.parametrize(("load", "crown", "k", "length", "middle", "end"), FINITE)
def test_a_long_ellipse_against_a_half_space_solution_of_the_roller(
    load: float, crown: float, k: float, length: float, middle: float, end: float
) -> None:
    """What the docstring of `crowned_contact` says of its error: the middle is high, the outermost ninth low."""
    found, formula, solved = finite_roller(load, crown, k, length)
    assert found.truncated
    assert formula[4] / solved[4] == pytest.approx(middle, abs=0.004)
    assert formula[0] / solved[0] == pytest.approx(end, abs=0.004)
    # The hardest slice is not flattered while the ellipse is shorter than two lengths; below that by 9 % at most.
    share = float(0.5 * length / found.along)
    assert formula.max() / solved.max() > (1.0 if share >= 0.5 - 1e-3 else 0.905)
    assert np.all(formula[1:-1] / solved[1:-1] > 1.0)


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
