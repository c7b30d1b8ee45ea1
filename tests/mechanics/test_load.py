"""Follower forces, loaded walls, torque and applied forces against formulas written out and scipy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError
from scipy import integrate, interpolate, optimize

from camgeom.errors import DesignError, ProfileError
from camgeom.maths.extremum import bracketed_root
from camgeom.maths.panels import TURN, highest, panels, roots
from camgeom.mechanics.applied import expression_force, monotone_cubic, table_force
from camgeom.mechanics.load import Load, normal_force, reversals
from camgeom.motion import Program, Segment
from camgeom.profile.sections import Force
from tests.reference.pin_machine import (
    INSERTION_FROM,
    INSERTION_UNTIL,
    PIN_MOTION,
    SPEED,
    insertion,
    pin_load,
)
from tests.reference.sliding import slip_speed, spin_reversal

PIN = pin_load().sampled()
DEG = np.pi / 180.0


def pin_force(phi, friction=8.3, mass=2.25, speed=SPEED):
    """The follower force of the pin machine at one cam angle, from the published formulas."""
    _, one, two = PIN_MOTION.jet(np.array([phi]), 2)[:, 0]
    insert = 0.0
    if INSERTION_FROM <= phi <= INSERTION_UNTIL:
        insert = 79.55 * ((56 * np.pi - 36 * phi) / (13 * np.pi) + np.sin((72 * phi - 86 * np.pi) / 13) / (2 * np.pi))
    return friction * np.sign(one) + insert + mass * speed**2 * two * 1e-3


def test_force_of_the_pin_machine_at_every_sample():
    expected = np.array([pin_force(phi) for phi in PIN.panels.theta.ravel()]).reshape(PIN.force.shape)
    np.testing.assert_allclose(PIN.force, expected, rtol=1e-12, atol=1e-10)


def test_program_and_written_out_motion_give_the_same_force():
    program = Program.from_segments(
        [
            Segment(155 * DEG),
            Segment(215 * DEG, 37.0, "cycloidal"),
            Segment(280 * DEG, 74.0, "cycloidal"),
            Segment(290 * DEG),
            Segment(360 * DEG, 0.0, "cycloidal"),
        ]
    )
    load = Load(program, SPEED, 2.25, 8.3, applied=(insertion(),))
    found = load.sampled(PIN.panels)
    np.testing.assert_allclose(found.force, PIN.force, rtol=1e-9, atol=1e-8)
    assert load.panels().breaks.size == PIN.panels.breaks.size


def test_walls_change_where_the_force_changes_sign():
    (found,) = PIN.reversals()
    zeros = []
    for low, high in ((180, 190), (200, 214.99), (240, 250), (320, 330), (355, 359.999)):
        zeros.append(optimize.brentq(pin_force, low * DEG, high * DEG, xtol=1e-13))
    refined = [change.taken for change in found if change.left == change.taken]
    for zero in zeros:
        assert min(abs(zero - at) for at in refined) < 1e-9
    # From the dwell the roller goes to the wall behind as the rise begins, and to the wall ahead as the return begins.
    starts = {round(change.taken / DEG, 6): change.wall for change in found if change.left != change.taken}
    assert starts == {155.0: 1, 290.0: -1}
    assert [change.wall for change in found] == [1, -1] * (len(found) // 2)


def test_variants_are_the_single_cases():
    speed, mass = np.array([10.0, 60.0, 100.0]), np.array([0.5, 2.0, 8.0])
    together = pin_load(speed, mass=mass).sampled(PIN.panels)
    changes = together.reversals()
    for k in range(3):
        alone = pin_load(float(speed[k]), mass=float(mass[k])).sampled(PIN.panels)
        np.testing.assert_allclose(together.force[k], alone.force, rtol=1e-14)
        assert changes[k] == alone.reversals()[0]


def test_work_over_a_turn_is_what_friction_and_insertion_take():
    insert = integrate.quad(
        lambda phi: (pin_force(phi, 0.0, 0.0)) * PIN_MOTION.jet(np.array([phi]), 1)[1, 0],
        INSERTION_FROM,
        INSERTION_UNTIL,
        epsabs=1e-12,
    )[0]
    assert float(PIN.work()) == pytest.approx(8.3 * 2 * 74.0 + insert, rel=1e-12)
    # Inertia, spring and weight give back what they take.
    loaded = pin_load(rate=3.0, preload=50.0, weight=20.0).sampled(PIN.panels)
    assert float(loaded.work()) == pytest.approx(float(PIN.work()), rel=1e-9)
    np.testing.assert_allclose(loaded.force - PIN.force, 70.0 + 3.0 * PIN.lift, rtol=1e-12)


def test_rotating_follower_is_in_torques():
    swing = Program.from_segments(
        [Segment(90 * DEG, 0.5, "3-4-5"), Segment(180 * DEG), Segment(360 * DEG, 0.0, "3-4-5")]
    )
    load = Load(swing, 20.0, mass=0.01, friction=30.0, kind="rotating").sampled()
    theta = load.panels.theta
    jet = swing.jet(theta, 2)
    expected = 0.01 * 400.0 * jet[2] * 1e3 + 30.0 * np.sign(jet[1]) * (np.abs(jet[1]) > 0)
    np.testing.assert_allclose(load.force, expected, rtol=1e-12, atol=1e-9)
    normal = load.normal(0.9, lever=80.0)
    np.testing.assert_allclose(normal, load.force / 72.0, rtol=1e-14)


def test_guide_friction_against_the_balance_of_forces():
    cosine, friction = 0.8, 0.12
    for force in (100.0, -100.0):
        for side in (1.0, -1.0):
            normal = float(normal_force(force, cosine, guide_friction=friction, side=side))
            # Along the motion the wall gives Fn cos(alpha); guides hold back mu times the side thrust.
            balance = normal * cosine - side * friction * abs(normal) * 0.6 - force
            assert balance == pytest.approx(0.0, abs=1e-12)
    limit = 0.8 / 0.6
    assert float(normal_force(1.0, cosine, guide_friction=0.999 * limit, side=1.0)) > 100.0
    with pytest.raises(DesignError, match="jams"):
        normal_force(1.0, cosine, guide_friction=1.002 * limit, side=1.0)


def test_a_dwell_has_neither_friction_nor_side():
    still = Load(Program.from_segments([Segment(TURN)]), SPEED, 1.0, 5.0).sampled()
    assert not still.force.any()
    assert still.reversals() == [()]


def test_loads_at_extreme_ratios_stay_finite():
    for speed in (1e-9, 1e9):
        for mass in (1e-9, 1e9):
            found = pin_load(speed, mass=mass).sampled(PIN.panels)
            assert np.isfinite(found.force).all()
            assert len(found.reversals()[0]) >= 2


# --- applied forces -------------------------------------------------------------------------------------------------


def test_expression_force_holds_on_its_closed_range_only():
    force = expression_force("3 + 0*phi", 1.0, 2.0)
    edge = np.array([1.0, 2.0])
    np.testing.assert_array_equal(force(np.array([0.999, 1.0, 1.5, 2.0, 2.001])), [0, 3, 3, 3, 0])
    np.testing.assert_array_equal(force(edge + 3 * TURN), [3, 3])
    assert force.breaks == (1.0, 2.0)


def test_a_range_may_run_past_the_turn():
    force = expression_force("deg", 350 * DEG, 10 * DEG)
    found = force(np.array([349.9, 350, 355, 0, 5, 10, 10.1]) * DEG)
    np.testing.assert_allclose(found, [0, 350, 355, 0, 5, 10, 0], atol=1e-9)
    whole = expression_force("1", 0.0, TURN)
    assert (whole(np.linspace(-7.0, 20.0, 100)) == 1.0).all()


def test_velocity_in_an_expression_uses_the_speed():
    force = expression_force("0.5*v", 0.0, TURN)
    load = Load(PIN_MOTION, np.array([10.0, 20.0]), applied=(force,)).sampled(PIN.panels)
    np.testing.assert_allclose(load.force, 0.5 * np.array([10.0, 20.0])[:, None, None] * PIN.ds, rtol=1e-13)


def test_tables():
    angle, value = np.array([100, 120, 150, 160, 200]) * DEG, np.array([0.0, 50.0, 60.0, 60.0, -10.0])
    theta = np.linspace(100, 200, 501) * DEG
    np.testing.assert_allclose(table_force(angle, value)(theta), np.interp(theta, angle, value), atol=1e-9)
    smooth = table_force(angle, value, "smooth")
    np.testing.assert_allclose(smooth(theta), interpolate.PchipInterpolator(angle, value)(theta), atol=1e-9)
    assert smooth(np.array([99.9, 200.1]) * DEG).tolist() == [0.0, 0.0]
    wrapped = table_force(np.array([350, 380]) * DEG, np.array([10.0, 40.0]))
    np.testing.assert_allclose(wrapped(np.array([350, 0, 20, 21]) * DEG), [10, 20, 40, 0], atol=1e-9)
    np.testing.assert_allclose(np.sort(wrapped.breaks), np.array([20, 350]) * DEG)


@given(st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=12))
def test_monotone_cubic_is_that_of_scipy_and_does_not_overshoot(values):
    x = np.cumsum(1.0 + np.arange(len(values)) % 3)
    y = np.round(np.array(values), 6)
    at = np.linspace(x[0], x[-1], 200)
    found = monotone_cubic(x, y)(at)
    if len(values) > 2:
        np.testing.assert_allclose(found, interpolate.PchipInterpolator(x, y)(at), atol=1e-9 * (1 + np.abs(y).max()))
    cell = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(x) - 2)
    low, high = np.minimum(y[cell], y[cell + 1]), np.maximum(y[cell], y[cell + 1])
    slack = 1e-12 * (1.0 + np.abs(y).max())
    assert ((found >= low - slack) & (found <= high + slack)).all()


@pytest.mark.parametrize(
    ("rows", "message"),
    [([[10.0, 1.0]], "two rows"), ([[10.0, 1.0], [10.0, 2.0]], "increase"), ([[0.0, 1.0], [361.0, 1.0]], "one turn")],
)
def test_bad_tables(rows, message):
    with pytest.raises(ValidationError, match=message):
        Force.model_validate({"table": rows})
    array = np.array(rows)
    with pytest.raises(ProfileError, match=message):
        table_force(array[:, 0] * DEG, array[:, 1])


def test_force_section():
    force = Force.model_validate({"from": 255.31, "until": 280.0, "expression": "2*deg"})
    assert float(force.applied()(np.array([260 * DEG]))[0]) == pytest.approx(520.0)
    table = Force.model_validate({"table": ((10.0, 1.0), (20.0, 3.0)), "interpolation": "smooth"})
    assert float(table.applied()(15 * DEG)) == pytest.approx(2.0)
    for bad, message in (
        ({}, "either"),
        ({"expression": "1", "table": [[0.0, 1.0], [1.0, 2.0]]}, "either"),
        ({"expression": "9**9**9"}, "exponent"),
        ({"expression": "phi.x"}, "Attribute"),
        ({"expression": "1", "from": 5.0, "until": 5.0}, "equal"),
        ({"expresion": "1"}, "Extra"),
        ({"table": [[0.0, "1"], [1.0, 2.0]]}, "number"),
        ({"table": 3}, "tuple"),
    ):
        with pytest.raises(ValidationError, match=message):
            Force.model_validate(bad)


# --- panels ---------------------------------------------------------------------------------------------------------


def test_panels_integrate_interpolate_and_find_maxima():
    where = panels([0.0, 1.0, 2.5, TURN])
    theta = where.theta
    value = np.exp(np.sin(3 * theta))
    whole = integrate.quad(lambda t: np.exp(np.sin(3 * t)), 0, TURN)[0]
    assert float(where.integral(value)) == pytest.approx(whole, rel=1e-12)
    at = np.linspace(0.0, TURN, 1001)
    np.testing.assert_allclose(where.at(value, at), np.exp(np.sin(3 * at)), atol=1e-12)
    running, inside = where.running(value)
    assert running[-1] == pytest.approx(float(where.integral(value)))
    assert inside.shape == (*theta.shape[:1], theta.shape[1] + 1)
    top, angle = highest(where, value)
    assert float(top) == pytest.approx(np.e, rel=1e-13)
    assert np.sin(3 * float(angle)) == pytest.approx(1.0, abs=1e-12)


def test_highest_of_what_is_constant_nearly_everywhere():
    """A constant panel is passed over, the constant that is the largest value is told, and a bump on it is found."""
    where = panels(np.linspace(0.0, 1.0, 41), 1.0)
    bump = np.where((where.theta > 0.5) & (where.theta < 0.525), 1e-3 * np.sin(40.0 * np.pi * (where.theta - 0.5)), 0.0)
    flat = np.full(where.theta.shape, 2.0)
    values, angles = highest(where, np.stack([flat, flat + bump, flat - bump, -bump]))
    np.testing.assert_allclose(values, [2.0, 2.001, 2.0, 0.0], rtol=1e-9, atol=1e-12)
    assert angles[1] == pytest.approx(0.5125, abs=1e-5)


def test_highest_sees_both_sides_of_a_jump_and_the_larger_of_two_close_peaks():
    where = panels([0.0, 2.0, TURN])
    saw = np.where(where.middle[:, None] < 2.0, where.theta, 0.0)
    top, angle = highest(where, saw)
    assert float(top) == pytest.approx(2.0, rel=1e-13)
    assert float(angle) == pytest.approx(2.0, rel=1e-13)
    for extra in (1e-7, -1e-7):
        twin = np.sin(where.theta) ** 2 + extra * np.cos(where.theta / 2.0)
        _, angle = highest(where, twin)
        assert float(angle) == pytest.approx(np.pi / 2 if extra > 0 else 1.5 * np.pi, abs=1e-5)
    rows = np.stack([saw, -saw, 0 * saw])
    assert highest(where, rows)[0].tolist() == pytest.approx([2.0, 0.0, 0.0])


def test_roots_to_rounding():
    where = panels([0.0, TURN])
    found = roots(where, np.stack([np.sin(5 * where.theta - 0.3), 1 + 0 * where.theta]))
    np.testing.assert_allclose(found[0], (0.3 + np.pi * np.arange(10)) / 5, atol=1e-13)
    assert not found[1].size
    high = bracketed_root(lambda x: x**9 - 1e-9, np.array([0.0]), np.array([1e3]))
    assert float(high[0]) == pytest.approx(0.1, rel=1e-14)
    assert bracketed_root(lambda x: x, np.array([-1.0]), np.array([3.0]))[0] == 0.0


def test_reversal_at_a_jump_is_at_the_jump():
    where = panels([0.0, 2.0, 4.0, TURN])
    step = np.where(where.middle[:, None] < 2.0, 1.0, -1.0) + 0 * where.theta
    (found,) = reversals(where, step)
    assert [(change.left, change.taken, change.wall) for change in found] == [(TURN, 0.0, 1), (2.0, 2.0, -1)]


# --- spin reversal --------------------------------------------------------------------------------------------------


def test_spin_reversal_against_a_stepped_simulation():
    rate, omega, growth, radius, inertia, mu = 80.0, 60.0, 4000.0, 11.0, 2e-6, 0.1
    found = spin_reversal(rate, omega, growth, radius, inertia, mu)
    assert float(found.slip) == 2 * rate * omega == float(slip_speed(rate, omega))
    v, j = rate * omega, inertia * 1e3
    n = 200_000
    t = np.linspace(0.0, 1.2 * float(found.time), n)
    spin = -v / radius + np.cumsum(mu * growth * omega * t * radius / j) * t[1]
    stop = int(np.searchsorted(spin, v / radius))
    assert t[stop] == pytest.approx(float(found.time), rel=1e-4)
    slip = v - radius * spin[:stop]
    assert slip.sum() * t[1] == pytest.approx(float(found.distance), rel=1e-4)
    heat = (mu * growth * omega * t[:stop] * slip).sum() * t[1]
    assert heat == pytest.approx(float(found.energy), rel=1e-4)
    with pytest.raises(ValueError, match="friction"):
        spin_reversal(rate, omega, growth, radius, inertia, 0.0)
