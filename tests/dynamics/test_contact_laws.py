"""The contact laws against tabulated forces, their own integrals and closed-form restitution."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from camgeom.dynamics.impact.laws import (
    ContactLaw,
    Coulomb,
    HertzEllipse,
    HertzLine,
    ImpactDamping,
    LinePatch,
    LiuCylinder,
    PowerLaw,
    PrintedStiffness,
    RampedDamping,
    exact_factor,
)
from camgeom.errors import NotConverged, ProfileError
from tests.reference.impact_reference import MODULUS

LAWS: list[ContactLaw] = [
    PowerLaw(6.4e9, 1.5),
    LiuCylinder(MODULUS, 0.02, 0.15),
    PrintedStiffness(MODULUS, 0.15, 1.5),
    PrintedStiffness(MODULUS, 0.15, 1.0),
    HertzLine(MODULUS, 0.02, 0.02, 0.13),
]
EVERY: list[ContactLaw] = [*LAWS, HertzEllipse(MODULUS, 0.02, 0.13, 0.3)]

TABLE = {
    1e-6: (6.400000000, 6.441480277, 0.07246697520, 72.46697520, 469.9932583),
    1e-5: (202.3857703, 203.6913812, 7.246769988, 2291.629884, 5631.423427),
    5e-5: (2262.741700, 2277.035310, 181.1773024, 25622.33982, 32761.03024),
    1e-4: (6400.000000, 6439.355655, 724.7494789, 72474.94789, 70546.65681),
}


@pytest.mark.parametrize("delta", TABLE)
def test_forces_of_the_table(delta: float) -> None:
    for law, force in zip(LAWS, TABLE[delta], strict=True):
        assert law.force(delta, 0.0) == pytest.approx(force, rel=5e-10)
        assert law.force_many(np.array([delta]), np.zeros(1))[0] == pytest.approx(force, rel=5e-10)


def test_the_tangent_stiffness_is_what_was_printed_as_a_coefficient() -> None:
    liu = LiuCylinder(MODULUS, 0.02, 0.15)
    for delta, force in {1e-6: 9.662198945, 1e-4: 9656.888460}.items():
        step = 1e-5 * delta
        slope = (liu.force(delta + step, 0.0) - liu.force(delta - step, 0.0)) / (2 * step)
        assert slope * delta == pytest.approx(force, rel=1e-9)


def test_hertz_force_satisfies_the_approach_formula() -> None:
    law = HertzLine(MODULUS, 0.02, 0.02, 0.13)
    for delta in (1e-9, 1e-6, 1e-4, 1e-3):
        f = law.force(delta, 0.0) / (math.pi * MODULUS * 0.02)
        b = math.sqrt(4 * f / (1 / 0.13 + 1 / 0.02))
        assert f * (math.log(4 * 0.13 / b) + math.log(4 * 0.02 / b) - 1) == pytest.approx(delta, rel=1e-13)


def test_true_curvature_meets_the_reference_and_hollow_is_stiffer() -> None:
    law = HertzLine(MODULUS, 0.02, 0.02, 0.13)
    true = HertzLine(MODULUS, 0.02, 0.02, 0.13, true_curvature=True)
    assert true.force(1e-5, 1 / 0.13) == pytest.approx(law.force(1e-5, 0.0), rel=1e-13)
    assert true.force(1e-5, -5.0) > true.force(1e-5, 1e-9) > true.force(1e-5, 1 / 0.13)
    many = true.force_many(np.array([1e-5, 1e-5]), np.array([-5.0, 7.0]))
    assert many[0] == pytest.approx(true.force(1e-5, -5.0), rel=1e-13)


@given(st.floats(1e-10, 1e-3), st.integers(0, len(EVERY) - 1))
def test_energy_is_the_integral_of_the_force(delta: float, which: int) -> None:
    law = EVERY[which]
    nodes, weights = np.polynomial.legendre.leggauss(40)
    root = 0.5 * math.sqrt(delta) * (nodes + 1)
    work = 0.5 * math.sqrt(delta) * (weights @ (2 * root * law.force_many(root**2, np.zeros(40))))
    assert law.energy(delta) == pytest.approx(work, rel=1e-7)
    assert law.force(-delta, 0.0) == pytest.approx(-law.force(delta, 0.0), rel=1e-14)
    assert law.energy(-delta) == 0.0


def test_pressure_of_a_textbook_pair() -> None:
    pressure = LinePatch(MODULUS, 0.02, 0.02).pressure(np.array([10e3]), np.array([1 / 0.13]))[0]
    half_width = math.sqrt(4 * 10e3 / 0.02 / (math.pi * MODULUS * (1 / 0.13 + 1 / 0.02)))
    assert pressure == pytest.approx(2 * 10e3 / (math.pi * half_width * 0.02), rel=1e-12)


def test_restitution_closed_forms() -> None:
    assert ImpactDamping(0.9).factor == pytest.approx(0.174049893037824, abs=1e-14)
    for e, chi in {0.5: 1.43275053, 0.8: 0.37314620, 0.9: 0.16648195, 0.95: 0.07892661}.items():
        assert exact_factor(e) == pytest.approx(chi, abs=6e-9)
    assert ImpactDamping(0.8, exact=True).factor == exact_factor(0.8)


@given(st.floats(0.1, 1.0))
def test_exact_factor_leaves_with_the_restitution(e: float) -> None:
    """The way in and the way out of m v dv = -Fe (1 + chi v/v0) ddelta take the same elastic work."""
    chi = exact_factor(e)
    balance = chi - math.log1p(chi) + chi * e + math.log1p(-chi * e)
    assert balance == pytest.approx(0.0, abs=1e-8 * chi**2 + 1e-15)


def test_friction_is_odd_continuous_and_smooth() -> None:
    law = Coulomb()
    speeds = np.linspace(-0.004, 0.004, 4001)
    values = law.coefficient_many(speeds)
    assert values == pytest.approx([law.coefficient(float(v)) for v in speeds], abs=1e-15)
    assert values == pytest.approx(-values[::-1], abs=1e-15)
    slope = np.diff(values) / np.diff(speeds)
    assert np.abs(np.diff(slope)).max() < 2.5, "a kink of the friction curve would jump by its slope, 225 s/m"
    assert law.coefficient(0.001) == pytest.approx(0.15)
    assert law.coefficient(0.002) == pytest.approx(0.10)


def test_ramped_damping() -> None:
    ramp = RampedDamping(28e3, 1e-4)
    assert ramp.viscosity(-1e-5) == 0.0
    assert ramp.viscosity(5e-5) == pytest.approx(14e3)
    assert ramp.viscosity(2e-4) == 28e3
    assert ramp.viscosity_many(np.array([-1e-5, 5e-5, 2e-4])) == pytest.approx([0.0, 14e3, 28e3])


def test_refusals() -> None:
    with pytest.raises(ProfileError, match="cam_depth"):
        HertzLine(MODULUS, 0.02, 0.02, math.inf)
    with pytest.raises(ProfileError, match="tighter than the roller"):
        HertzLine(MODULUS, 0.02, 0.02, -0.019, cam_depth=0.1)
    HertzLine(MODULUS, 0.02, 0.02, -0.021, cam_depth=0.1)
    with pytest.raises(NotConverged, match="range of the Hertz"):
        HertzLine(MODULUS, 0.02, 0.02, 0.13).force(0.1, 0.0)
    with pytest.raises(ProfileError, match="restitution"):
        ImpactDamping(0.0)
    with pytest.raises(ProfileError, match="exponent"):
        PowerLaw(1e9, 0.9)
    with pytest.raises(ProfileError, match="static"):
        Coulomb(0.1, 0.2)


def test_a_crown_as_round_as_its_roller_is_a_ball() -> None:
    """On a flat the closed form of a sphere, 4/3 E* sqrt(R) delta^(3/2); flatter crowns are stiffer."""
    ball = HertzEllipse(MODULUS, 0.02, math.inf, 0.02)
    assert ball.force(1e-5, 0.0) == pytest.approx(4.0 / 3.0 * MODULUS * math.sqrt(0.02) * 1e-5**1.5, rel=1e-9)
    assert HertzEllipse(MODULUS, 0.02, math.inf, 0.5).stiffness > 1.5 * ball.stiffness
    with pytest.raises(ProfileError, match="tighter than the roller"):
        HertzEllipse(MODULUS, 0.02, -0.01, 0.5)
