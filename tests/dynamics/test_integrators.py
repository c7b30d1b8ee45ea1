"""Integrators: order, dispersion, stability limits, knots, peaks and refusals, measured against closed forms."""

from __future__ import annotations

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from camgeom.dynamics.linear.accuracy import Accuracy, solved, verified, watch_position
from camgeom.dynamics.linear.maps import step_maps
from camgeom.dynamics.linear.method import (
    INTEGRATORS,
    WILSON_BOUND,
    Coefficients,
    Collocated,
    Correction,
    Method,
    RungeKutta,
    find,
    gauss_legendre,
    generalized_alpha,
    newmark,
    wilson,
)
from camgeom.dynamics.linear.peaks import peak
from camgeom.dynamics.linear.solve import periodic, transient
from camgeom.dynamics.linear.walk import MAX_STEPS, Walk, aligned_grid
from camgeom.errors import NotConverged, ProfileError
from tests.reference.integrators_constant import ConstantSystem

TURN = np.array([0.0, 2.0 * pi])
ONE = np.array([1.0])


def oscillator(frequency: float = 1.0, damping: float = 0.0) -> ConstantSystem:
    """q.. + 2 zeta w q. + w^2 q = 0 at one rad of cam angle per second."""
    stiffness = np.array([[frequency**2]])
    return ConstantSystem(np.eye(1), np.array([[2.0 * damping * frequency]]), stiffness, ONE)


class Varying:
    """Two coupled coordinates with every coefficient varying smoothly, chosen so that the solution is known.

    q = (sin(2 theta), cos theta + 1/2): the force is computed from it.
    """

    size = 2
    batch = 1
    linear = True

    def exact(self, theta: np.ndarray) -> np.ndarray:
        t = np.asarray(theta)
        q = np.stack([np.sin(2 * t), np.cos(t) + 0.5], -1)
        v = np.stack([2 * np.cos(2 * t), -np.sin(t)], -1)
        a = np.stack([-4 * np.sin(2 * t), -np.cos(t)], -1)
        return np.stack([q, v, a])

    def matrices(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        one = np.ones_like(t)
        d = np.stack(
            [np.stack([0.4 + 0.2 * np.sin(t), 0.1 * np.cos(t)], -1), np.stack([-0.2 * one, 0.3 * one], -1)], -2
        )
        s = np.stack([np.stack([9 + 2 * np.cos(t), 1 + np.sin(t)], -1), np.stack([1 - np.sin(t), 5 * one], -1)], -2)
        return d, s

    def coefficients(self, theta: np.ndarray, side: str = "right") -> Coefficients:
        d, s = self.matrices(theta)
        q, v, a = self.exact(theta)
        return Coefficients(d, s, a + (d @ v[..., None])[..., 0] + (s @ q[..., None])[..., 0])

    def correction(self, theta: np.ndarray, side: str = "right") -> Correction:
        return lambda position, rate: np.zeros_like(position)


def error_of(method: Method, steps: int) -> float:
    system = Varying()
    grid = aligned_grid(TURN, steps)
    exact = system.exact(grid.theta)
    found = transient(system, grid, method, exact[:2, 0].reshape(1, 4))
    return float(np.abs(found.position[0] - exact[0]).max())


STEPS = {2: (96, 192), 3: (96, 192), 4: (48, 96), 5: (24, 48), 6: (16, 32)}


@pytest.mark.parametrize("name", [name for name, method in INTEGRATORS.items() if method.order in STEPS])
def test_order_of_convergence(name: str) -> None:
    method = INTEGRATORS[name]
    coarse, fine = (error_of(method, steps) for steps in STEPS[method.order])
    assert np.log2(coarse / fine) == pytest.approx(method.order, abs=0.2)


@pytest.mark.parametrize("name", [name for name, method in INTEGRATORS.items() if method.order not in STEPS])
def test_high_order_of_one_step(name: str) -> None:
    """Error of one step of the oscillator at two lengths: order + 1. Halving would leave the digits of a double."""
    method = find(name)
    lengths = (1.0, 0.5) if method.order % 2 else (2.0, 1.0) if method.order <= 10 else (3.0, 2.0)
    errors = []
    for h in lengths:
        maps = step_maps(method, oscillator(), np.array([0.0]), np.array([h]))[0, 0, :, :-1]
        exact = np.array([[np.cos(h), np.sin(h)], [-np.sin(h), np.cos(h)]])
        errors.append(np.abs(maps - exact).max())
    order = np.log(errors[0] / errors[1]) / np.log(lengths[0] / lengths[1]) - 1.0
    assert order == pytest.approx(method.order, abs=0.2)


@pytest.mark.parametrize(
    ("method", "expected"),
    [
        (
            wilson(),
            [(0.01, 0.07157, 0.01303), (0.05, 1.71063, 1.44494), (0.1, 6.14622, 8.40960), (0.2, 19.36534, 29.63878)],
        ),
        (newmark(), [(0.01, 0.03289, 0.0), (0.05, 0.81712, 0.0), (0.1, 3.20749, 0.0), (0.2, 12.00331, 0.0)]),
        (
            generalized_alpha(),
            [(0.01, 0.03472, 0.00011), (0.05, 0.86233, 0.01309), (0.1, 3.38284, 0.09877), (0.2, 12.63509, 0.64447)],
        ),
    ],
    ids=lambda value: value.name if isinstance(value, Collocated) else "",
)
def test_period_elongation_and_amplitude_loss(method: Collocated, expected: list[tuple[float, float, float]]) -> None:
    for share, elongation, loss in expected:
        maps = step_maps(method, oscillator(2.0 * pi), np.array([0.0]), np.array([share]))[0, 0, :, :-1]
        values = np.linalg.eigvals(maps)
        one = values[np.abs(values.imag).argmax()]
        angle = abs(np.angle(one))
        assert 100.0 * (2.0 * pi * share / angle - 1.0) == pytest.approx(elongation, abs=6e-6)
        assert 100.0 * (1.0 - abs(one) ** (2.0 * pi / angle)) == pytest.approx(loss, abs=6e-6)


def radius(method: Method, phase: float) -> float:
    maps = step_maps(method, oscillator(), np.array([0.0]), np.array([phase]))[0, 0, :, :-1]
    return float(np.abs(np.linalg.eigvals(maps)).max())


class TestStability:
    def test_wilson_bound_has_two_sides(self) -> None:
        assert pytest.approx((1.0 + sqrt(3.0)) / 2.0, abs=1e-15) == WILSON_BOUND
        assert radius(wilson(WILSON_BOUND + 1e-4), 1e6) < 1.0
        assert radius(wilson(WILSON_BOUND - 1e-4), 1e6) > 1.0
        assert radius(wilson(1.40), 1e6) == pytest.approx(0.77844, abs=1e-5)
        assert radius(wilson(1.420815), 1e6) == pytest.approx(0.52097, abs=1e-3)
        assert radius(wilson(1.37), 1e6) == pytest.approx(0.97602, abs=1e-5)

    def test_wilson_below_the_bound_is_cautioned(self) -> None:
        assert wilson(1.3661).caution == ""
        assert "1.3660" in wilson(1.3660).caution
        found = transient(oscillator(), aligned_grid(TURN, 100), wilson(1.30))
        assert "1.40" in found.cautions[0]

    def test_wilson_overshoots_a_stiff_displacement(self) -> None:
        peaks = []
        for share in (1.0, 5.0, 10.0):
            system = oscillator(2.0 * pi)
            grid = aligned_grid([0.0, 20.0 * share], 20)
            peaks.append(np.abs(transient(system, grid, wilson(), np.array([[1.0, 0.0]])).position).max())
        assert peaks == pytest.approx([5.65, 141.0, 564.0], rel=5e-3)
        grid = aligned_grid([0.0, 100.0], 20)
        calm = transient(oscillator(2.0 * pi), grid, newmark(), np.array([[1.0, 0.0]]))
        assert np.abs(calm.position).max() <= 1.0 + 1e-12

    @given(phase=st.floats(1e-3, 1e8), stages=st.integers(1, 8))
    @settings(max_examples=60, deadline=None)
    def test_gauss_keeps_the_amplitude_at_every_step(self, phase: float, stages: int) -> None:
        assert radius(gauss_legendre(stages), phase) == pytest.approx(1.0, abs=1e-7)


class TestConstantSystems:
    @pytest.mark.parametrize("ratio", [1e-6, 1e6])
    def test_stiffness_a_million_apart(self, ratio: float) -> None:
        """No damping: gauss4 follows the slow mode and keeps the stiff one bounded, whatever the step."""
        stiffness = np.array([[1.0 + ratio, -ratio], [-ratio, ratio]])
        system = ConstantSystem(np.eye(2), np.zeros((2, 2)), stiffness, ONE)
        found = transient(system, aligned_grid(TURN, 64), "gauss4", np.array([[1.0, 1.0, 0.0, 0.0]]), turns=4)
        assert np.abs(found.state).max() < 10.0 * max(1.0, ratio) ** 0.5
        energy = 0.5 * (found.rate**2).sum(-1) + 0.5 * np.einsum(
            "bni,ij,bnj->bn", found.position, stiffness, found.position
        )
        assert np.ptp(energy) < 1e-9 * energy.max()

    def test_forced_resonance(self) -> None:
        def force(theta: np.ndarray, side: str) -> np.ndarray:
            return np.cos(theta)[..., None]

        at = ConstantSystem(np.eye(1), np.zeros((1, 1)), np.eye(1), ONE, force)
        with pytest.raises(NotConverged, match="resonance"):
            periodic(at, aligned_grid(TURN, 200), "gauss8")
        off = ConstantSystem(np.eye(1), np.zeros((1, 1)), np.array([[2.0]]), ONE, force)
        found = solved(off, TURN, Accuracy(1e-10), lambda g, m: periodic(off, g, m), watch_position)
        assert np.abs(found.position[0, :, 0] - np.cos(found.theta)).max() < 1e-10
        grown = transient(at, aligned_grid(TURN, 200), "gauss4", turns=3)
        exact = 0.5 * grown.theta * np.sin(grown.theta)
        assert np.abs(grown.position[0, :, 0] - exact).max() < 1e-10

    def test_damped_response_is_the_transfer_function(self) -> None:
        def force(theta: np.ndarray, side: str) -> np.ndarray:
            return np.sin(3.0 * theta)[..., None]

        system = ConstantSystem(np.eye(1), np.array([[0.3]]), np.array([[7.0]]), ONE, force)
        for name in INTEGRATORS:
            found = periodic(system, aligned_grid(TURN, 2000), name)
            exact = (np.exp(3j * found.theta) / (7.0 - 9.0 + 0.9j)).imag
            assert np.abs(found.position[0, :, 0] - exact).max() < 1e-4
            assert found.spectral_radius[0] == pytest.approx(np.exp(-0.3 * pi), rel=1e-4)


class TestGrids:
    def test_knots_are_nodes_and_halves_keep_them(self) -> None:
        knots = np.array([0.0, 0.3, 0.3 + 1e-14, 2.0, 2.0 * pi])
        grid = aligned_grid(knots, 50)
        assert all(np.any(grid.theta == knot) for knot in (0.0, 0.3, 2.0, 2.0 * pi))
        assert grid.steps >= 50
        assert np.allclose(np.cumsum(grid.step), grid.theta[1:], rtol=1e-14)
        fine = grid.halved()
        assert np.abs(fine.theta[::2] - grid.theta).max() < 1e-14
        assert grid.starts_at_knot.sum() == 3

    def test_bad_grids_are_named(self) -> None:
        with pytest.raises(ProfileError, match=f"1 to {MAX_STEPS}"):
            aligned_grid(TURN, 0)
        with pytest.raises(ProfileError, match="two distinct"):
            aligned_grid([1.0, 1.0], 10)
        with pytest.raises(ProfileError, match="gauss4"):
            find("gaus4")
        with pytest.raises(ProfileError, match="unconditionally"):
            newmark(0.2, 0.5)
        with pytest.raises(ProfileError, match="spectral"):
            generalized_alpha(1.2)
        with pytest.raises(ProfileError, match="range of the method"):
            wilson(0.5)
        with pytest.raises(ProfileError, match="stages"):
            gauss_legendre(11)

    def test_blocks_of_steps_are_steps(self) -> None:
        system = Varying()
        for count in (1, 2, 3, 10, 17):
            grid = aligned_grid(TURN, count)
            walk = Walk(find("gauss3"), system, grid)
            single = step_maps(find("gauss3"), system, grid.start, grid.step)[0]
            y = np.array([0.3, -0.2, 0.1, 0.7])
            got = walk.run(y[None])[0][0]
            for k, one in enumerate(single):
                assert np.allclose(got[k], y, rtol=1e-13, atol=1e-14)
                y = one[:, :-1] @ y + one[:, -1]
            total = walk.period[0]
            assert np.allclose(total[:, :-1] @ got[0] + total[:, -1], y, rtol=1e-12)

    def test_long_walks_in_parts_agree_with_short_ones(self, monkeypatch: pytest.MonkeyPatch) -> None:
        from camgeom.dynamics.linear import walk as integrators_grid

        system, grid = Varying(), aligned_grid(TURN, 500)
        begin = np.zeros((1, 4))
        whole = Walk(find("gauss3"), system, grid)
        monkeypatch.setattr(integrators_grid, "KEEP", 100)
        parts = Walk(find("gauss3"), system, grid)
        assert not parts.kept
        assert np.allclose(parts.run(begin)[0], whole.run(begin)[0], rtol=1e-12, atol=1e-13)
        assert np.allclose(parts.period, whole.period, rtol=1e-12, atol=1e-13)


class Kicked:
    """An oscillator whose force jumps at a knot: F = 0 before theta = 2, 1 after."""

    size = 1
    batch = 1
    linear = True
    knots = np.array([0.0, 2.0, 2.0 * pi])

    def coefficients(self, theta: np.ndarray, side: str = "right") -> Coefficients:
        after = theta >= 2.0 if side == "right" else theta > 2.0
        zero = np.zeros((1, 1, 1, 1))
        return Coefficients(zero, zero + 9.0, np.where(after, 1.0, 0.0)[..., None])

    def correction(self, theta: np.ndarray, side: str = "right") -> Correction:
        return lambda position, rate: np.zeros_like(position)


@pytest.mark.parametrize("name", list(INTEGRATORS))
def test_a_jump_at_a_knot_costs_no_order(name: str) -> None:
    method = find(name)
    coarse, fine = {2: (200, 400), 3: (100, 200), 4: (60, 120), 5: (32, 64), 6: (32, 64)}.get(method.order, (16, 32))
    errors = []
    for steps in (coarse, fine):
        grid = aligned_grid(Kicked.knots, steps)
        found = transient(Kicked(), grid, method)
        t = np.maximum(grid.theta - 2.0, 0.0)
        errors.append(np.abs(found.position[0, :, 0] - (1.0 - np.cos(3.0 * t)) / 9.0).max())
    assert errors[1] < 2e-12 or np.log2(errors[0] / errors[1]) > method.order - 0.5


class TestVerified:
    def test_error_by_halving_bounds_the_true_error(self) -> None:
        system = Varying()

        def once(grid: object, method: Method) -> object:
            return periodic(system, grid, method)

        for tolerance in (1e-3, 1e-6, 1e-9, 1e-12):
            for name in ("auto", "newmark", "gauss3"):
                if name == "newmark" and tolerance < 1e-6:
                    continue
                found = solved(system, TURN, Accuracy(tolerance, name), once, watch_position)
                exact = system.exact(found.theta)[0]
                true = (np.abs(found.position[0] - exact).max(0) / np.abs(exact).max(0)).max()
                assert found.error[0] <= tolerance
                assert true <= tolerance
                assert f"{found.grid.steps} steps a turn" in found.choice
                assert found.method.name in found.choice

    def test_auto_takes_high_order_for_tight_and_says_so(self) -> None:
        system = Varying()
        found = solved(system, TURN, Accuracy(1e-10), lambda g, m: periodic(system, g, m), watch_position)
        assert found.method.order >= 8
        assert found.grid.steps < 200

    def test_unreachable_tolerance_is_refused(self) -> None:
        system = oscillator(3.3)
        grid = aligned_grid(TURN, 10)
        begin = np.array([[1.0, 0.0]])
        with pytest.raises(NotConverged, match="not met with 300 steps"):
            verified(lambda g: transient(system, g, "newmark", begin), grid, 1e-9, max_steps=300)
        with pytest.raises(NotConverged, match="no longer falls"):
            verified(lambda g: transient(system, g, "gauss6", begin, turns=20), aligned_grid(TURN, 400), 1e-16)

    def test_too_small_a_step_budget_names_the_way_out(self) -> None:
        stiff = oscillator(1e9)
        with pytest.raises(NotConverged, match="use auto"):
            solved(stiff, TURN, Accuracy(1e-9, "newmark"), lambda g, m: transient(stiff, g, m), watch_position)


def test_peaks_between_the_nodes() -> None:
    """Largest and smallest value of the known motion from few nodes, to the accuracy of the steps."""
    system = Varying()
    grid = aligned_grid(TURN, 16)
    found = transient(system, grid, "gauss8", system.exact(np.array([0.0]))[:2].reshape(1, 4))
    got = peak(found, lambda theta, q, u, side: q[..., 0] + q[..., 1])
    fine = np.linspace(0.0, 2.0 * pi, 2_000_001)
    values = system.exact(fine)[0].sum(-1)
    assert got.maximum[0] == pytest.approx(values.max(), abs=2e-11)
    assert got.minimum[0] == pytest.approx(values.min(), abs=2e-11)
    assert got.maximum_at[0] == pytest.approx(fine[values.argmax()], abs=5e-6)
    assert got.minimum_at[0] == pytest.approx(fine[values.argmin()], abs=5e-6)
    assert got.magnitude[0] == max(got.maximum[0], -got.minimum[0])


def test_tableaus_satisfy_their_conditions() -> None:
    for method in INTEGRATORS.values():
        if isinstance(method, RungeKutta):
            a, b, c = (np.array(one) for one in (method.a, method.b, method.c))
            assert a.sum(1) == pytest.approx(c, abs=1e-14)
            for k in range(1, method.order + 1):
                assert b @ c ** (k - 1) == pytest.approx(1.0 / k, abs=1e-14)
            assert replace(method, name="other").order == method.order
