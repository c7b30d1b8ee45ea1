"""Operating loads in the contact with clearance: spring, friction and forces over the cam angle from [operation]."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from camgeom.checks import judge
from camgeom.dynamics.impact import solver as impact_solver
from camgeom.dynamics.impact.lift import ForceTable, Lift
from camgeom.dynamics.impact.problem import ImpactLoad
from camgeom.dynamics.impact.study import statistics
from camgeom.errors import NotConverged
from camgeom.model import Model
from camgeom.motion import Program, Segment
from camgeom.profile import parse
from tests.places import PROFILES


def model(name: str, extra: str = "", **changes: str) -> Model:
    head, _, rest = (PROFILES / f"{name}.toml").read_text().partition("[impact]")
    text = head + rest.partition("\n\n")[2]
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    return Model(parse(f"{text}\n[impact]\nturns = 2\n{extra}"))


def step(theta: np.ndarray) -> np.ndarray:
    """Jumps by 5 at 1 rad and kinks at 2 rad."""
    return np.where(theta < 1.0, 3.0 * np.sin(theta), 5.0 + 3.0 * np.sin(theta)) + np.maximum(theta - 2.0, 0.0)


class TestTable:
    table = ForceTable.of(step, (1.0, 2.0))

    def test_is_the_force_between_its_knots(self) -> None:
        theta = np.linspace(0.0, 2.0 * pi, 4001)[1:-1]
        ends = np.array([0.0, 1.0, 2.0, 2.0 * pi])
        k = np.searchsorted(ends, theta, side="right") - 1
        found = self.table.many(theta, ends[k], ends[k + 1])
        assert np.abs(found - step(theta)).max() < 1e-7
        plain = [self.table.within(ends[i], ends[i + 1])(t - ends[i]) for i, t in zip(k, theta, strict=True)]
        assert np.abs(found - plain).max() < 1e-12

    @pytest.mark.parametrize(("start", "end", "jump"), [(0.5, 1.0, 0.0), (1.0, 1.5, 5.0)])
    def test_a_jump_has_two_sides(self, start: float, end: float, jump: float) -> None:
        expected = 3.0 * np.sin(1.0) + jump
        assert self.table.within(start, end)(1.0 - start) == pytest.approx(expected, abs=1e-7)
        found = self.table.many(np.array([1.0]), np.array([start]), np.array([end]))[0]
        assert found == pytest.approx(expected, abs=1e-7)

    def test_only_the_jump_is_one(self) -> None:
        assert self.table.jumps == pytest.approx((1.0,))
        assert self.table.largest == pytest.approx(np.abs(step(np.linspace(0.0, 2.0 * pi, 9999))).max(), rel=1e-3)


def test_a_split_motion_is_the_same_motion() -> None:
    moves = [Segment(2.0, 10.0, "3-4-5"), Segment(3.0), Segment(5.0, 0.0, "cycloidal"), Segment(2.0 * pi)]
    lift = Lift.from_program(Program.from_segments(moves), 1e-3)
    split = lift.split((1.3, 3.0, 4.2))
    assert len(split.arcs) == len(lift.arcs) + 2
    theta = np.linspace(0.0, 2.0 * pi, 500)
    assert np.array_equal(lift.many(theta, 3), split.many(theta, 3))


def test_spring_friction_and_force_reach_the_solver_in_si_units() -> None:
    spring = {"friction = 8.3": "friction = 8.3\nspring_rate = 2\nspring_preload = 30\ngravity = 5"}
    load = model("pin_insertion", "clearance = 0.02\n", **spring).impact.problem.load
    assert load.constant == pytest.approx(-30.0 - 2.25 * 5.0)
    assert load.stiffness == pytest.approx(2000.0)
    assert load.drag == pytest.approx(8.3)
    assert load.applied is not None
    angle = np.radians(270.0)
    formula = 79.55 * ((56 * pi - 36 * angle) / (13 * pi) + np.sin((72 * angle - 86 * pi) / 13) / (2 * pi))
    assert load.applied.within(angle - 0.01, angle + 0.01)(0.01) == pytest.approx(formula, rel=1e-6)
    rocker = {"speed = 600": "speed = 600\nfriction = 4000\nspring_rate = 50\nspring_preload = 2000"}
    turned = model("conjugate_rocker", **rocker).impact.problem.load
    assert turned.constant == pytest.approx(-2.0)
    assert turned.stiffness == pytest.approx(0.05 * 180.0 / pi)
    assert turned.drag == pytest.approx(4.0)


def test_the_cam_supplies_what_friction_and_force_take() -> None:
    """The button of the press and its guides, 15 N and 10 N: 0.6 J a turn, little more with the impacts."""
    press = model("constant_width_press", "tolerance = 1e-7\n")
    run = press.impact
    assert run.energy.relative_residual < 1e-6
    work = 1e-3 * float(press.load.sampled().work())
    assert work == pytest.approx(0.6)
    assert statistics(run).mean_power == pytest.approx(work, rel=5e-3)
    assert run.problem.load.applied.jumps == pytest.approx(np.radians([140.0, 180.0]))
    assert np.abs(np.subtract.outer(np.radians([140.0, 180.0]), run.machine.lift.starts)).min(axis=1).max() < 1e-12


@pytest.mark.parametrize(("preload", "both"), [(0.0, True), (8000.0, False)])
def test_a_strong_spring_keeps_the_roller_on_one_wall(preload: float, both: bool) -> None:
    spring = {"friction = 8.3": f"friction = 8.3\nspring_preload = {preload}"}
    run = model("pin_insertion", "clearance = 0.02\ntolerance = 1e-7\n", **spring).impact
    assert (statistics(run).force_return.largest > 0.0) is both
    assert run.energy.relative_residual < 1e-6


def test_nothing_acts_by_default() -> None:
    assert not ImpactLoad().acts
    assert ImpactLoad().largest == 0.0
    assert ImpactLoad(applied=TestTable.table).acts


def test_a_contact_too_stiff_to_be_followed_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A gentle touch, then 450 kN: the damping latched at the touch is far stiffer than the contact."""
    monkeypatch.setattr(impact_solver, "_MOST_STEPS", 500)
    spring = {"friction = 8.3": "friction = 8.3\nspring_rate = 6115", "speed = 600": "speed = 240"}
    with pytest.raises(NotConverged, match="speed_floor"):
        _ = model("pin_insertion", "clearance = 0.015\nrestitution = 0.2\ntolerance = 1e-5\n", **spring).impact


@pytest.mark.parametrize(("stiffness", "sinks"), [(1.0, True), (1e3, True), (1e6, False)])
def test_a_roller_that_sinks_into_its_cam_is_no_contact(stiffness: float, sinks: bool) -> None:
    """149 N at 1 N/mm^1.5 are 28 mm of a roller of 20: 126 MPa passed, as what is soft presses little."""
    made = model("conjugate_rocker", f'law = "power"\nstiffness = {stiffness}\nexponent = 1.5\n')
    if sinks:
        with pytest.raises(NotConverged, match=r"the roller sinks .* mm into the cam, more than a twentieth"):
            _ = made.impact
        assert "the roller sinks" in str(judge(made, ["impact-pressure"]).not_judged)
        return
    assert made.impact.trace.penetration.max() <= 0.05 * 0.02
