"""The catalogue of motion laws: every claim measured independently, textbook formulas, limits, properties."""

from __future__ import annotations

import doctest
import importlib
import math
import subprocess
import sys
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

from camgeom.errors import ProfileError
from camgeom.motion import LAWS, make
from camgeom.motion.catalogue import law as enter_law
from camgeom.motion.law import Claims, Law

CASES = [(name, {}, entry.claims) for name, entry in LAWS.items()]
CASES += [(name, dict(params), claims) for name, entry in LAWS.items() for params, claims in entry.cases]
IDS = [f"{name}{params or ''}" for name, params, _ in CASES]


def spans(law: Law) -> list[tuple[float, float]]:
    return list(zip(law.knots[:-1], law.knots[1:], strict=True))


def largest(law: Law, quantity: Callable[[np.ndarray], np.ndarray]) -> float:
    """The largest |quantity(jet)| by dense sampling between the knots and a bounded search round the best sample."""
    best = 0.0
    for low, high in spans(law):
        x = np.linspace(low, high, 2001)[1:-1]
        x = np.concatenate([[low + 1e-13], x, [high - 1e-13]])
        values = np.abs(quantity(law.jet(x, 3)))
        k = int(np.argmax(values))
        found = minimize_scalar(
            lambda t: -abs(float(quantity(law.jet(np.array([t]), 3))[0])),
            bounds=(x[max(k - 1, 0)], x[min(k + 1, len(x) - 1)]),
            method="bounded",
            options={"xatol": 1e-10},
        )
        best = max(best, float(values[k]), -float(found.fun))
    return best


@pytest.mark.parametrize(("name", "params", "claims"), CASES, ids=IDS)
def test_claims_are_true_to_the_printed_digits(name: str, params: Mapping[str, Any], claims: Claims) -> None:
    law = make(name, **params)
    assert law.claims == claims
    quantities: dict[str, Callable[[np.ndarray], np.ndarray]] = {
        "vm": lambda d: d[1],
        "am": lambda d: d[2],
        "jm": lambda d: d[3],
        "vam": lambda d: d[1] * d[2],
    }
    for key, quantity in quantities.items():
        claimed = getattr(claims, key)
        if math.isfinite(claimed):
            assert largest(law, quantity) == pytest.approx(claimed, rel=3e-9), key
    if math.isfinite(claims.arms):
        nodes, weights = np.polynomial.legendre.leggauss(60)
        square = sum(
            0.5 * (high - low) * float(weights @ law.jet(0.5 * (low + high) + 0.5 * (high - low) * nodes)[2] ** 2)
            for low, high in spans(law)
        )
        assert math.sqrt(square) == pytest.approx(claims.arms, rel=3e-9)


@pytest.mark.parametrize(("name", "params", "claims"), CASES, ids=IDS)
def test_the_law_measures_itself_as_claimed(name: str, params: Mapping[str, Any], claims: Claims) -> None:
    found = make(name, **params).peaks()
    for key in ("vm", "am", "jm", "vam", "arms"):
        assert getattr(found, key) == pytest.approx(getattr(claims, key), rel=1e-9), key
    assert (found.order_start, found.order_end) == (claims.order_start, claims.order_end)
    assert found.order_inside == claims.order_inside
    assert found.order == claims.order


@pytest.mark.parametrize(("name", "params", "claims"), CASES, ids=IDS)
def test_continuity_is_exactly_of_the_claimed_order(name: str, params: Mapping[str, Any], claims: Claims) -> None:
    law = make(name, **params)
    for x, side, order in ((0.0, "right", claims.order_start), (1.0, "left", claims.order_end)):
        jet = law.jet(x, 6, side)  # type: ignore[arg-type]
        assert np.all(np.abs(jet[1 : order + 1]) < 1e-8)
        assert abs(jet[order + 1]) > 0.5
    inner = np.array(law.knots[1:-1])
    assert (len(inner) == 0) == math.isinf(claims.order_inside)
    if len(inner):
        jumps = np.abs(law.jet(inner, 6) - law.jet(inner, 6, side="left")).max(axis=1)
        order = int(claims.order_inside)
        assert np.all(jumps[: order + 1] < 1e-9 * (1 + np.abs(law.jet(inner, order)).max()))
        assert jumps[order + 1] > 0.5


@pytest.mark.parametrize("name", LAWS)
def test_runs_from_zero_to_one_exactly(name: str) -> None:
    law = make(name)
    assert law.jet(0.0)[0] == 0.0
    assert law.jet(1.0, side="left")[0] == law.jet(1.0)[0] == 1.0


@pytest.mark.parametrize("name", LAWS)
def test_each_derivative_is_the_slope_of_the_one_before(name: str) -> None:
    law = make(name)
    x = (np.arange(400) + 0.5) / 400
    step = 1e-6
    x = x[np.min(np.abs(x[:, None] - np.array(law.knots)), axis=1) > 2 * step]
    slopes = (law.jet(x + step, 5) - law.jet(x - step, 5)) / (2 * step)
    jets = law.jet(x, 6)
    for r in range(6):
        np.testing.assert_allclose(
            slopes[r], jets[r + 1], atol=1e-9 * (1 + np.abs(jets[r : r + 4]).max()) / step * 1e-5
        )


@pytest.mark.parametrize("name", LAWS)
def test_integral_and_mean_square_agree_with_quadrature(name: str) -> None:
    law = make(name)
    area = sum(quad(lambda x: float(law.jet(x, 0)[0]), *span, epsabs=1e-13)[0] for span in spans(law))
    assert float(law.integral()) == pytest.approx(area, rel=1e-12)
    assert law.integral(np.array([0.0, 0.3, 1.0]))[0] == 0.0
    square = sum(quad(lambda x: float(law.jet(x, 1)[1]) ** 2, *span, epsabs=1e-12)[0] for span in spans(law))
    assert law.mean_square(1) == pytest.approx(square, rel=1e-11)


def test_modified_sine_is_the_textbook_formula() -> None:
    x = np.linspace(0, 1, 4001)
    ends = math.pi * x - 0.25 * np.sin(4 * math.pi * x) + 4 * (x > 0.5)
    middle = 2 + math.pi * x - 2.25 * np.sin((4 * math.pi * x + math.pi) / 3)
    book = np.where((x < 0.125) | (x > 0.875), ends, middle) / (4 + math.pi)
    np.testing.assert_allclose(make("modified-sine").jet(x, 0)[0], book, atol=3e-16)


def test_modified_trapezoid_is_the_textbook_formula() -> None:
    law, factor = make("modified-trapezoid"), 1 / (2 + math.pi)
    x = np.linspace(0, 0.125, 101)
    start = factor * (2 * x - np.sin(4 * math.pi * x) / (2 * math.pi))
    np.testing.assert_allclose(law.jet(x, 0, side="left")[0], start, atol=1e-17)
    np.testing.assert_allclose(law.jet(np.linspace(0.125, 0.374, 50))[2], 8 * math.pi * factor, rtol=1e-14)
    x = np.linspace(0, 0.5, 101)
    np.testing.assert_allclose(law.jet(1 - x, 0)[0], 1 - law.jet(x, 0)[0], atol=1e-15)


def test_modified_constant_velocity_cruises_for_its_share() -> None:
    for share in (0.1, 0.5, 0.9):
        law = make("modified-constant-velocity", share=share)
        x = np.linspace(0.5 - 0.4999 * share, 0.5 + 0.4999 * share, 20)
        np.testing.assert_allclose(law.jet(x)[1], law.peaks().vm, rtol=1e-14)
        assert np.all(law.jet(x)[2] == 0.0)
        assert abs(law.jet(0.5 - 0.501 * share)[2]) > 0.0


@pytest.mark.parametrize(
    ("name", "params", "other", "same"),
    [
        ("scca", {"b": 0.25, "c": 0.0, "d": 0.75}, "modified-sine", {}),
        ("scca", {"b": 0.5, "c": 0.0, "d": 0.5}, "cycloidal", {}),
        ("scca", {"b": 0.0, "c": 0.0, "d": 1.0}, "simple-harmonic", {}),
        ("scca", {}, "modified-trapezoid", {}),
        ("modified-constant-velocity", {"share": 0.0}, "modified-sine", {}),
        ("universal-asymmetric", {"accelerate": 0.25, "cruise": 0.5, "fall": 0.75}, "modified-constant-velocity", {}),
        ("triple-harmonic", {"first": 15 * math.pi / 8, "second": 0.0}, "gutman-1-3", {}),
        ("power-polynomial", {"exponents": [4, 5, 6, 7]}, "4-5-6-7", {}),
        ("power-polynomial", {"exponents": [5, 6, 7, 8, 9], "reverse": True}, "5-6-7-8-9", {}),
        ("polynomial", {"order": 3}, "4-5-6-7", {}),
        ("trapezoidal-velocity", {"share": 0.0}, "parabolic", {}),
    ],
)
def test_families_contain_their_members(name: str, params: dict[str, Any], other: str, same: dict[str, Any]) -> None:
    x = np.linspace(0.001, 0.999, 777)
    np.testing.assert_allclose(make(name, **params).jet(x), make(other, **same).jet(x), rtol=1e-10, atol=1e-10)


def test_asymmetric_law_spends_its_shares() -> None:
    law = make("universal-asymmetric", accelerate=0.3, cruise=0.2)
    assert np.all(law.jet(np.linspace(0.001, 0.299, 50))[2] > 0)
    assert np.all(law.jet(np.linspace(0.301, 0.499, 50))[2] == 0)
    assert np.all(law.jet(np.linspace(0.501, 0.999, 50))[2] < 0)


def test_no_law_beats_the_parabola_or_the_harmonic() -> None:
    """Least peak acceleration from rest to rest is 4, least root mean square 2 sqrt(3) (bang-bang, cubic)."""
    for name in LAWS:
        claims = LAWS[name].claims
        assert claims.am >= 4.0
        assert claims.arms >= math.sqrt(12) - 1e-12
        assert claims.vm >= 1.0


share = st.floats(0.0, 1.0)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.02, 0.98), share, share, share)
def test_any_asymmetric_law_is_a_smooth_monotone_rise(
    accelerate: float, cruise: float, rise: float, fall: float
) -> None:
    cruise *= 0.99 - accelerate
    scale = max(1.0, (rise + fall) * (1 + 1e-15))
    law = make("universal-asymmetric", accelerate=accelerate, cruise=cruise, rise=rise / scale, fall=fall / scale)
    assert law.jet(1.0, side="left")[0] == 1.0
    jet = law.jet(np.linspace(0, 1, 501))
    assert np.all(jet[1] > -1e-13)
    knots = np.array(law.knots[1:-1])
    jump = np.abs(law.jet(knots, 1) - law.jet(knots, 1, side="left"))
    assert jump.max(initial=0.0) < 1e-13
    assert law.peaks().vm == pytest.approx(float(law.jet(accelerate)[1]), rel=1e-12)
    assert jet[1].max() <= law.peaks().vm * (1 + 1e-12)


@settings(max_examples=20, deadline=None)
@given(share, share)
def test_any_scca_keeps_to_its_lift(b: float, c: float) -> None:
    b *= 1 - c
    law = make("scca", b=b, c=c, d=max(0.0, 1.0 - b - c))
    x = np.linspace(0, 1, 301)
    np.testing.assert_allclose(law.jet(x, 0)[0] + law.jet(1 - x, 0)[0], 1.0, atol=1e-14)


def test_an_unknown_law_is_told_the_nearest_spelling() -> None:
    with pytest.raises(ProfileError, match="did you mean 'modified-sine'"):
        make("modifed-sine")


def test_every_bad_parameter_is_named_at_once() -> None:
    with pytest.raises(ProfileError) as caught:
        make("modified-constant-velocity", shar=0.5, rise=2.0)
    assert [problem.key for problem in caught.value.problems] == ["shar", "rise"]
    assert "did you mean 'share'" in str(caught.value)


@pytest.mark.parametrize(
    ("name", "params", "key"),
    [
        ("scca", {"b": 0.5, "c": 0.5, "d": 0.5}, "d"),
        ("modified-sine", {"share": math.nan}, "share"),
        ("modified-sine", {"share": "0.1"}, "share"),
        ("modified-sine", {"share": True}, "share"),
        ("modified-trapezoid", {"share": 0.26}, "share"),
        ("universal-asymmetric", {"rise": 0.6, "fall": 0.6}, "fall"),
        ("universal-asymmetric", {"accelerate": 0.6, "cruise": 0.5}, "cruise"),
        ("power-polynomial", {"exponents": [3, 3, 4]}, "exponents"),
        ("power-polynomial", {"exponents": [3, 4.5]}, "exponents"),
        ("power-polynomial", {"exponents": [3, {}]}, "exponents"),
        ("power-polynomial", {"exponents": []}, "exponents"),
        ("spline", {"points": [[0.5, 0.2], [0.4, 0.3]]}, "points"),
        ("spline", {"points": [[0.5, 0.2, 1.0]]}, "points"),
        ("b-spline", {"control": [[1.0]]}, "control"),
        ("polynomial", {"order": 4}, "order"),
        ("polynomial", {"order": 2.0}, "order"),
        ("double-harmonic", {"reverse": 1}, "reverse"),
    ],
)
def test_bad_parameters_are_named(name: str, params: dict[str, Any], key: str) -> None:
    with pytest.raises(ProfileError) as caught:
        make(name, **params)
    assert [problem.key for problem in caught.value.problems] == [key]


def test_limits_of_ranges_are_allowed() -> None:
    assert make("modified-trapezoid", share=0.25).peaks().am == pytest.approx(2 * math.pi)
    assert make("universal-asymmetric", rise=0.5, fall=0.5).peaks().order == 2


@pytest.mark.parametrize("x", [-1e-9, 1.0 + 1e-9, math.nan, math.inf])
def test_a_law_is_not_extrapolated(x: float) -> None:
    with pytest.raises(ValueError, match="0 <= x <= 1"):
        make("cycloidal").jet(x)


def test_every_law_says_what_it_is_and_where_it_comes_from() -> None:
    for entry in LAWS.values():
        assert len(entry.summary) > 20
        assert len(entry.source) > 20
        for parameter in entry.parameters.values():
            assert parameter.help
            assert parameter.accepts(parameter.default)


def test_a_name_is_taken_once() -> None:
    with pytest.raises(ValueError, match="cycloidal"):
        enter_law("cycloidal", source="", claims=LAWS["cycloidal"].claims)(LAWS["cycloidal"].factory)


@pytest.mark.parametrize("module", ["law", "program", "table"])
def test_examples_in_docstrings(module: str) -> None:
    result = doctest.testmod(importlib.import_module(f"camgeom.motion.{module}"))
    assert result.failed == 0


def test_laws_load_nothing_heavy() -> None:
    code = "import sys, camgeom.motion.law, camgeom.motion.program; print(sorted(sys.modules))"
    modules = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    for heavy in ("scipy", "trimesh", "pyvista", "matplotlib"):
        assert f"'{heavy}'" not in modules
