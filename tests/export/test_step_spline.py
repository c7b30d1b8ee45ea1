"""Spline bases against scipy, and fits measured at parameters they have never seen."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from camgeom.errors import NotConverged
from camgeom.export.step.geometry import SplineSurface
from camgeom.export.step.spline import MAX_SPANS, fit_bands
from camgeom.maths.splines import Basis


def clamped(degree: int, inner: list[float]) -> Basis:
    return Basis(degree, np.concatenate([np.zeros(degree + 1), sorted(inner), np.ones(degree + 1)]))


@settings(max_examples=25, deadline=None)
@given(st.integers(1, 5), st.lists(st.floats(0.05, 0.95), max_size=6, unique_by=lambda x: round(x, 3)))
def test_basis_and_derivatives_are_those_of_scipy(degree: int, inner: list[float]) -> None:
    basis = clamped(degree, inner)
    poles = np.random.default_rng(degree).normal(size=(basis.size, 3))
    x = np.linspace(0.0, 1.0, 41)
    reference = BSpline(basis.knots, poles, degree)
    assert np.allclose(basis.design(x) @ poles, reference(x), atol=1e-13)
    away = x[np.abs(x[:, None] - np.array([*inner, 2.0])).min(axis=1) > 1e-9]  # one-sided at knots of low degree
    scale = max(1.0, float(1.0 / np.diff(basis.breaks).min()))
    want = reference.derivative()(away)
    assert np.allclose(basis.design(away, 1) @ poles, want, atol=1e-11 * scale)


def wavy(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    x = np.empty((len(u), len(v), 3))
    x[..., 0], x[..., 1] = np.cos(u)[:, None] * (60.0 + v), np.sin(u)[:, None] * (60.0 + v)
    x[..., 2] = 10.0 * np.sin(3.0 * u)[:, None] * np.exp(0.3 * v)
    return x


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_fit_keeps_its_tolerance_between_its_points(tolerance: float) -> None:
    (fit,) = fit_bands([wavy], [5], (0.2, 1.9), tolerance)
    u, v = np.random.default_rng(1).uniform(size=(2, 4000)) * [[1.7], [1.0]] + [[0.2], [0.0]]
    points = SplineSurface(fit.u, fit.v, fit.poles).jet(u, v)[0]
    exact = np.stack([wavy(u[i : i + 1], v[i : i + 1])[0, 0] for i in range(len(u))])
    error = float(np.sqrt(((points - exact) ** 2).sum(axis=1)).max())
    assert error <= 1.1 * fit.deviation
    assert fit.deviation <= tolerance


def test_neighbours_share_their_boundary_poles() -> None:
    def upper(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        return wavy(u, 1.0 + v)

    low, high = fit_bands([wavy, upper], [5, 5], (0.2, 1.9), 1e-6)
    assert np.abs(low.poles[:, -1] - high.poles[:, 0]).max() < 1e-12
    assert low.u is high.u or np.array_equal(low.u.knots, high.u.knots)


def test_a_kink_inside_an_interval_is_refused_with_advice() -> None:
    def kinked(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        x = wavy(u, v)
        x[..., 2] += np.abs(u - 1.0 / 3.0)[:, None]
        return x

    with pytest.raises(NotConverged, match=rf"{MAX_SPANS} spans.*split the interval"):
        fit_bands([kinked], [1], (0.0, 1.0), 1e-7)


def test_nan_is_refused() -> None:
    with pytest.raises(NotConverged, match="NaN"):
        fit_bands([lambda u, v: wavy(u, v) * np.nan], [5], (0.0, 1.0), 1e-6)
