"""Contact of a roller of real length on a half-space, against exact ellipse, line, an independent solver and tamaas."""

from __future__ import annotations

from math import inf, pi
from typing import final

import numpy as np
import pytest

from camgeom.maths import Floats
from camgeom.mechanics import hertz
from camgeom.mechanics.finite_contact import INSIDE, AxialProfile, Bodies, PressurePatch, press
from camgeom.mechanics.halfspace import CellPressure, Even, StripSpectrum, pressed
from camgeom.mechanics.material import STEEL, pair_compliance
from scripts.judge_contact import CASES, judged
from tests.reference import half_space

PAIR = pair_compliance(STEEL, STEEL)
TABLE = (
    # relative curvature 1/mm, straight line MPa over 10 mm, peaks of crowns R 5000, 500, 100, 20 mm under 500 N
    (1.0 / 10.0 + 1.0 / 55.0, 461.4, (596.2, 933.0, 1315.7, 1981.6)),
    (1.0 / 10.0, 424.432, (550.448, 863.552, 1223.256, 1861.222)),
)
CROWNS = (5000.0, 500.0, 100.0, 20.0)


@pytest.mark.parametrize(("k", "line", "peaks"), TABLE)
@pytest.mark.parametrize("number", range(4))
def test_crowns_against_the_exact_ellipse(k: float, line: float, peaks: tuple[float, ...], number: int) -> None:
    """64 x 64 within 0.1 %, its error stated, with the approach, the shear below and the centre of the load."""
    crown = CROWNS[number]
    exact = hertz.point_contact(500.0, 1.0 / crown, k, PAIR)
    found = press(Bodies(k, AxialProfile(-5.0, 5.0, crown), PAIR), 500.0)
    assert found.pressure.shape == (64, 64)
    assert found.peak[0] == pytest.approx(peaks[number], rel=2e-4)
    assert found.peak[0] == pytest.approx(float(exact.pressure), rel=1e-3)
    assert abs(found.peak[0] / float(exact.pressure) - 1.0) < 5.0 * found.error < 2e-3
    assert found.approach == pytest.approx(float(exact.approach), rel=1e-4)
    assert found.centre == pytest.approx(0.0, abs=1e-6)
    assert not found.unbounded
    assert found.length == pytest.approx(2.0 * float(exact.long), rel=0.03)
    below = hertz.beneath_point(float(exact.pressure), float(exact.long), float(exact.short), 0.3)
    half, shear, depth = found.beneath(0.3)
    assert (half, shear) == pytest.approx((below.half_width, below.shear), rel=1e-3)
    assert depth == pytest.approx(below.shear_depth, rel=0.02)
    assert float(hertz.line_pressure(50.0, k, PAIR)) == pytest.approx(line, rel=1e-4)


def test_the_error_falls_as_the_square_of_the_cells() -> None:
    k, crown = 0.1, 500.0
    exact = hertz.point_contact(500.0, 1.0 / crown, k, PAIR)
    wide, long = 1.12 * float(exact.short), 1.12 * float(exact.long)
    errors = []
    counts = (16, 32, 64, 128)
    for n in counts:
        dx, dy = 2.0 * wide / n, 2.0 * long / n
        x, y = (np.arange(n) + 0.5) * dx - wide, (np.arange(n) + 0.5) * dy - long
        bodies = Bodies(k, AxialProfile(-50.0, 50.0, crown), PAIR)
        found = pressed(bodies.gap(x, y), Even(n, n, dx, dy, PAIR), np.array(dx * dy), 500.0)
        patch = PressurePatch(bodies, 500.0, x, y, np.full(n, dy), found.pressure, found.approach, found.steps)
        errors.append(abs(patch.peak[0] / float(exact.pressure) - 1.0))
    assert errors[2] < 1e-4
    assert np.polyfit(np.log(counts), np.log(errors), 1)[0] < -1.9


def test_the_middle_of_a_long_roller_is_a_line() -> None:
    found = press(Bodies(0.1, AxialProfile(-50.0, 50.0), PAIR), 5000.0)
    middle = float(np.interp(0.0, found.y, found.line_load))
    assert found.at(0.0) == pytest.approx(float(hertz.line_pressure(middle, 0.1, PAIR)), rel=1e-3)
    half = float(hertz.line_half_width(middle, 0.1, PAIR))
    assert found.half_widths[len(found.y) // 2] == pytest.approx(half, rel=5e-3)
    assert middle == pytest.approx(50.0, rel=0.06)


@pytest.mark.parametrize("case", CASES)
def test_against_tamaas(case: str) -> None:
    """Tilt and ends: the same cells, another code."""
    pytest.importorskip("tamaas")
    assert judged(case) < 1e-6


@pytest.mark.parametrize(("crown", "tilt"), [(inf, 0.0), (inf, 2e-4), (500.0, 1e-3)])
def test_against_the_reference_solver_with_tilt_and_ends(crown: float, tilt: float) -> None:
    n, m, wide, length = 24, 40, 0.6, 12.0
    dx, dy = wide / n, length / m
    x, y = (np.arange(n) + 0.5) * dx - 0.5 * wide, (np.arange(m) + 0.5) * dy - 0.5 * length
    gap = Bodies(0.1, AxialProfile(-6.0, 6.0, crown), PAIR, tilt).gap(x, y)
    found = pressed(gap, Even(n, m, dx, dy, PAIR), np.array(dx * dy), 500.0, tolerance=1e-11)
    other = half_space.pressed(gap, dx, dy, PAIR, 500.0, 1e-12)
    assert np.abs(found.pressure - other).max() < 1e-7 * other.max()
    assert (found.pressure * dx * dy).sum() == pytest.approx(500.0, rel=1e-12)


def test_strips_of_one_length_are_even_cells() -> None:
    p = np.random.default_rng(3).random((16, 12))
    edges = np.linspace(-1.8, 1.8, 13)
    even, strips = Even(16, 12, 0.1, 0.3, PAIR), StripSpectrum(16, 0.1, edges, PAIR)
    assert np.abs(even(p) - strips(p)).max() < 1e-13 * np.abs(even(p)).max()


@final
class Plain:
    """Strips without their waves: what the gradients find where nothing leads them."""

    stiff = 1.0

    def __init__(self, strips: StripSpectrum, alone: Floats | None = None) -> None:
        self.strips, self.alone = strips, np.ones(1) if alone is None else alone

    def __call__(self, pressure: Floats) -> Floats:
        return self.strips(pressure)

    def nearly(self, deflection: Floats) -> Floats:
        return deflection


def test_waves_along_strips_lead_to_the_same_pressure_in_a_third_of_the_steps() -> None:
    patch = press(Bodies(0.1, AxialProfile(-6.0, 6.0, end_radius=0.1), PAIR, 3e-4), 500.0, strips=128)
    edges = np.concatenate([[0.0], np.cumsum(patch.along)]) + patch.y[0] - 0.5 * patch.along[0]
    strips = StripSpectrum(len(patch.x), patch.width, edges, PAIR)
    gap, area = patch.bodies.gap(patch.x, patch.y), patch.width * patch.along[None, :]
    led, plain = (pressed(gap, how, area, 500.0, tolerance=1e-10) for how in (strips, Plain(strips)))
    assert np.abs(led.pressure - plain.pressure).max() < 1e-6 * plain.pressure.max()
    assert led.approach == pytest.approx(plain.approach, rel=1e-9)
    assert 3 * led.steps < plain.steps


WIDE_ENDED = Bodies(2.394e-5, AxialProfile(-129.8, 129.8, end_radius=0.168, whole=259.6), 6.54e-5, own=0.94)
"""a plate's roller under hardly any load, whose contact is twice as wide at its rounded ends as a first look shows"""


def test_what_every_cell_does_to_itself_leads_where_cells_keep_coming_and_going() -> None:
    patch = press(WIDE_ENDED, 0.003, 32, 48, 80, False)
    edges = np.concatenate([[0.0], np.cumsum(patch.along)]) + patch.y[0] - 0.5 * patch.along[0]
    strips = StripSpectrum(len(patch.x), patch.width, edges, WIDE_ENDED.compliance)
    gap, area = WIDE_ENDED.gap(patch.x, patch.y), patch.width * patch.along[None, :]
    led, plain = (pressed(gap, Plain(strips, how), area, 0.003) for how in (strips.alone, None))
    assert led.approach == pytest.approx(plain.approach, rel=1e-6)
    assert np.abs(led.pressure - plain.pressure)[:, 4:-4].max() < 2e-3 * plain.pressure.max()
    assert 1.8 * led.steps < plain.steps


def test_a_window_that_was_too_narrow_leads_the_next(monkeypatch: pytest.MonkeyPatch) -> None:
    steps: list[int] = []

    def counted(*words: object) -> CellPressure:
        found = pressed(*words)  # type: ignore[arg-type]
        steps.append(found.steps)
        return found

    monkeypatch.setattr("camgeom.mechanics.finite_contact.pressed", counted)
    press.cache_clear()
    found = press(WIDE_ENDED, 0.003, 32, 48, 80, False)
    assert len(steps) > 5
    assert max(steps[4:]) < 70
    assert not found.pressure[[0, -1]].any()
    assert found.pressure.sum(axis=0) @ found.along * found.width == pytest.approx(0.003, rel=1e-9)


def test_a_sharp_end_that_bears_has_no_peak() -> None:
    """The end cell grows with the grid as its length to the -1/2; half a millimetre inside the pressure settles."""
    tops, inner = [], []
    for strips in (48, 96, 192):
        found = press(Bodies(0.1, AxialProfile(-6.0, 6.0), PAIR, tilt=-2e-4), 500.0, strips=strips)
        assert found.unbounded
        assert found.bearing_ends == (False, True)
        tops.append(found.ridge[-1] * np.sqrt(found.along[-1]))
        inner.append(found.at(6.0 - INSIDE))
        assert found.peak[0] == pytest.approx(inner[-1])
    assert tops[2] == pytest.approx(tops[1], rel=0.03)
    assert inner[2] == pytest.approx(inner[1], rel=2e-3)
    assert 2.3 < found.centre < 2.6
    off = press(Bodies(0.1, AxialProfile(-6.0, 6.0, 500.0), PAIR, tilt=-2e-4), 500.0)
    assert not off.unbounded


def test_what_touches_next_to_a_sharp_end_alone_is_told_halfway() -> None:
    found = press(Bodies(0.1, AxialProfile(-6.0, 6.0), PAIR, tilt=-1e-2), 1.0)
    assert found.unbounded
    assert found.length < INSIDE
    assert found.inside == pytest.approx(0.5 * found.length)
    assert found.peak == (pytest.approx(found.at(6.0 - found.inside)), pytest.approx(6.0 - found.inside))
    assert found.peak[0] > 100.0


@pytest.mark.parametrize(("end", "tilt", "share"), [(0.5, 0.0, 0.02), (1.0, 3e-4, 0.01), (1.0, -3e-4, 0.01)])
def test_a_rounded_end_has_a_peak_that_settles(end: float, tilt: float, share: float) -> None:
    fine = press(Bodies(0.1, AxialProfile(-6.0, 6.0, end_radius=end), PAIR, tilt), 500.0, strips=192)
    found = press(Bodies(0.1, AxialProfile(-6.0, 6.0, end_radius=end), PAIR, tilt), 500.0)
    assert not found.unbounded
    assert found.peak[0] == pytest.approx(fine.peak[0], rel=share)
    assert abs(found.peak[1]) == pytest.approx(6.0, abs=0.02)
    assert np.sign(found.centre) == -np.sign(tilt) or tilt == 0.0
    softer = press(Bodies(0.1, AxialProfile(-6.0, 6.0, end_radius=2.0 * end), PAIR, tilt), 500.0)
    assert softer.peak[0] < found.peak[0]


def test_a_tilt_moves_the_ellipse_along_the_crown() -> None:
    """Exactly by crown radius times tilt, as long as it ends within the roller."""
    found = press(Bodies(0.1, AxialProfile(-6.0, 6.0, 500.0), PAIR, tilt=-3e-3), 500.0)
    exact = hertz.point_contact(500.0, 1.0 / 500.0, 0.1, PAIR)
    assert found.peak == pytest.approx((float(exact.pressure), 1.5), rel=1e-3)
    assert found.centre == pytest.approx(1.5, abs=1e-3)


def test_a_logarithmic_run_out_ends_within_the_roller() -> None:
    straight = press(Bodies(0.1, AxialProfile(-6.0, 6.0, run_out=0.00035 * 20.0), PAIR), 2000.0)
    assert not straight.unbounded
    assert straight.length < 12.0
    tilted = press(Bodies(0.1, AxialProfile(-6.0, 6.0, run_out=0.00035 * 20.0), PAIR, 3e-4), 2000.0)
    assert tilted.peak[0] > straight.peak[0]
    assert tilted.peak[1] < straight.peak[1]
    y = np.array([-5.4, 0.0, 5.4])
    assert AxialProfile(-6.0, 6.0, run_out=0.007).drop(y) == pytest.approx(0.007 * np.log(1.0 / (1.0 - (y / 6.0) ** 2)))


def test_a_twisted_ellipse_has_the_principal_curvatures() -> None:
    """A flank straight along a line at 0.3 rad to the axis: x² - (k + c) x + k c cos² of it."""
    k, c, twist = 0.1, 1.0 / 100.0, 0.3
    found = press(Bodies(k, AxialProfile(-8.0, 8.0, 1.0 / c), PAIR, twist=twist), 500.0)
    half, root = 0.5 * (k + c), np.sqrt((0.5 * (k + c)) ** 2 - k * c * np.cos(twist) ** 2)
    exact = hertz.point_contact(500.0, half - root, half + root, PAIR)
    assert found.peak[0] == pytest.approx(float(exact.pressure), rel=2e-3)


def test_a_mirrored_end_is_softer() -> None:
    bodies = Bodies(0.1, AxialProfile(-6.0, 6.0, end_radius=0.5), PAIR)
    whole, free = press(bodies, 500.0), press(Bodies(0.1, bodies.profile, PAIR, mirror=1.0), 500.0)
    assert free.peak[0] < whole.peak[0]
    assert free.approach > whole.approach


def test_the_load_is_carried_and_scales() -> None:
    """Load times s³, lengths times s: pressure times s, as of any such contact."""
    small = press(Bodies(0.1, AxialProfile(-6.0, 6.0, 5000.0, end_radius=1.0), PAIR), 800.0)
    large = press(Bodies(0.05, AxialProfile(-12.0, 12.0, 10000.0, end_radius=2.0), PAIR), 3200.0)
    assert large.peak[0] == pytest.approx(small.peak[0], rel=1e-6)
    carried = float((large.line_load * large.along).sum())
    assert carried == pytest.approx(3200.0, rel=1e-12)


def love_by_quadrature(x: float, y: float, a: float, b: float) -> Floats:
    nodes, weights = np.polynomial.legendre.leggauss(200)
    s, t = a * nodes[:, None] - x, b * nodes[None, :] - y
    return np.asarray(a * b * (weights[:, None] * weights / np.hypot(s, t)).sum())


def test_the_influence_of_a_cell_is_loves() -> None:
    a, b = 0.05, 0.15
    spike = np.zeros((8, 8))
    spike[2, 3] = 1.0
    found = Even(8, 8, 2 * a, 2 * b, PAIR)(spike) * pi / PAIR
    for i, j in ((5, 6), (0, 0), (7, 3)):
        assert found[i, j] == pytest.approx(love_by_quadrature((i - 2) * 2 * a, (j - 3) * 2 * b, a, b), rel=1e-9)


@pytest.mark.parametrize("half", [7.0, 7.2, 7.4, 7.6])
def test_a_rounded_end_that_bears_is_found_whatever_the_coarse_cells(half: float) -> None:
    """The peak at the rounding hardly hangs on the length under the same load per length; 96 strips against 192."""
    bodies = Bodies(0.0686, AxialProfile(-half, half, end_radius=1.0), PAIR)
    peaks = [press(bodies, 200.0 * 2.0 * half, strips=n, checked=False).peak for n in (96, 192)]
    assert peaks[0][0] == pytest.approx(peaks[1][0], rel=0.02)
    assert peaks[1][0] == pytest.approx(2080.0, rel=0.03)
    assert abs(abs(peaks[1][1]) - half) < 0.05


def test_a_contact_whose_cells_keep_coming_and_going_settles() -> None:
    """A crown of 50 m, nearly straight between its rounded ends, did not; its neighbour of 49.9 m presses alike."""
    found = [press(Bodies(0.12147303768146733, AxialProfile(-6.0, 6.0, crown, end_radius=0.5), PAIR), 254.4097714268559)
             for crown in (50000.0, 49900.0)]  # fmt: skip
    assert found[0].peak[0] == pytest.approx(found[1].peak[0], rel=1e-3)
    assert all(found[0].bearing_ends)


@pytest.mark.parametrize("tilt", [-1.7e-3, 1.7e-3])
@pytest.mark.parametrize("load", [2.2e-5, 1e-3, 1e-2])
def test_a_tilted_roller_that_touches_with_its_rounding_alone_has_an_ellipse_there(load: float, tilt: float) -> None:
    """The window ended before the contact began, as a light load's lies wholly beyond the roller's straight length."""
    roller = AxialProfile(-12.7, 12.7, end_radius=1.5)
    found = press(Bodies(0.049, roller, 8.835e-6, tilt), load)
    exact = float(hertz.point_contact(load, 0.049, 1.0 / 1.5, 8.835e-6).pressure)
    assert found.peak[0] == pytest.approx(exact, rel=3e-3)
    assert abs(found.peak[1]) > 12.7
    assert float((found.line_load * found.along).sum()) == pytest.approx(load, rel=1e-9)
