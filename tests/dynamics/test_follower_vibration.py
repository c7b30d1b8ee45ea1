"""Elastic follower: residual vibration, response, jump, flight, polydyne cams and the elastic cam shaft."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import comb, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from camgeom.dynamics.follower.polydyne import operator, polydyne_motion
from camgeom.dynamics.follower.residual import residual_spectrum
from camgeom.dynamics.follower.response import flight, from_rest, jump, preload_share, steady_state
from camgeom.dynamics.follower.train import OUTPUTS, CamShaft, FollowerSystem, FollowerTrain
from camgeom.dynamics.linear.accuracy import Accuracy
from camgeom.errors import DesignError, NotConverged, ProfileError
from camgeom.motion import Program, Segment, make
from camgeom.motion.law import Law, finish
from camgeom.motion.table import Piece

RISE = pi / 2.0
LIFT = 10.0
RATIOS = np.array([1.5, 2.5, 3.5, 5.5])


def program(law: str = "cycloidal") -> Program:
    """10 mm up in 90 degrees, dwell, down in 90 degrees, dwell."""
    return Program.from_segments(
        [Segment(RISE, LIFT, law), Segment(pi), Segment(1.5 * pi, 0.0, law), Segment(2.0 * pi)]
    )


@pytest.fixture(scope="module")
def motion() -> Program:
    return program()


TRAIN = FollowerTrain(mass=2.0, stiffness=2e6, damping=150.0, return_stiffness=2e4, preload=150.0)


@dataclass(frozen=True)
class LawMotion:
    """A law as a rise of given lift and cam angle, then a dwell: a program by itself."""

    law: Law
    lift: float
    rise: float = RISE

    @property
    def knots(self) -> np.ndarray:
        return np.array([*(x * self.rise for x in self.law.knots), 2.0 * pi])

    def jet(self, theta: np.ndarray, order: int = 3, side: str = "right") -> np.ndarray:
        angle = np.asarray(theta)
        out = np.zeros((order + 1, *angle.shape))
        moving = angle < self.rise if side == "right" else angle <= self.rise
        out[0][~moving] = self.lift
        scale = self.lift / self.rise ** np.arange(order + 1)
        out[:, moving] = scale[:, None] * self.law.jet(angle[moving] / self.rise, order, side)
        return out


class TestResidual:
    def test_cycloidal_law(self) -> None:
        exact = np.abs(np.sin(pi * RATIOS)) / (pi * RATIOS * np.abs(RATIOS**2 - 1.0))
        found = residual_spectrum(make("cycloidal"), RATIOS)
        assert np.abs(found.amplitude - exact).max() < 1e-15
        assert found.acceleration == pytest.approx(exact * (2.0 * pi * RATIOS) ** 2, rel=1e-12)

    @pytest.mark.parametrize("ratio", RATIOS)
    def test_cycloidal_law_by_integration(self, motion: Program, ratio: float) -> None:
        speed = 100.0
        natural = 2.0 * pi * ratio / (RISE / speed)
        train = FollowerTrain(mass=1.0, stiffness=natural**2)
        found = from_rest(train, motion, speed, accuracy=Accuracy(1e-11))
        q = found.at(RISE, "deviation")[0, 0]
        v = found.at(RISE, "velocity")[0, 0]
        amplitude = np.hypot(q, v / natural) / (LIFT * 1e-3)
        exact = abs(np.sin(pi * ratio)) / (pi * ratio * abs(ratio**2 - 1.0))
        assert amplitude == pytest.approx(exact, abs=1e-12)
        assert amplitude == pytest.approx(exact, rel=1e-9)

    @pytest.mark.parametrize("law", ["modified-sine", "modified-trapezoid", "3-4-5", "simple-harmonic", "parabolic"])
    @pytest.mark.parametrize("damping", [0.0, 0.05])
    def test_other_laws_against_integration(self, law: str, damping: float) -> None:
        ratio, speed = 3.3, 50.0
        natural = 2.0 * pi * ratio / (RISE / speed)
        # damping of the relative motion alone: it sits in the linkage
        train = FollowerTrain(mass=1.0, stiffness=natural**2, damping=2.0 * damping * natural)
        found = from_rest(train, program(law), speed, accuracy=Accuracy(1e-11))
        q, v = found.at(RISE, "deviation")[0, 0], found.at(RISE, "velocity")[0, 0]
        damped = natural * np.sqrt(1.0 - damping**2)
        amplitude = np.hypot(q, (v + damping * natural * q) / damped) / (LIFT * 1e-3)
        spectrum = residual_spectrum(make(law), ratio, damping)
        assert spectrum.amplitude[0] == pytest.approx(amplitude, rel=1e-9)

    def test_velocity_steps_count(self) -> None:
        """Constant velocity knocks at both ends: |q| = |1 - exp(i w)|/w."""
        n = np.array([0.3, 1.7, 4.4])
        found = residual_spectrum(make("constant-velocity"), n)
        assert found.amplitude == pytest.approx(np.abs(2.0 * np.sin(pi * n)) / (2.0 * pi * n), rel=1e-12)

    def test_zeros_of_the_cycloidal_law(self) -> None:
        found = residual_spectrum(make("cycloidal"), np.arange(2.0, 12.0))
        assert found.amplitude.max() < 1e-15

    @given(ratio=st.floats(0.01, 300.0), damping=st.floats(0.0, 0.9))
    @settings(max_examples=40, deadline=None)
    def test_is_finite_and_bounded(self, ratio: float, damping: float) -> None:
        found = residual_spectrum(make("modified-sine"), ratio, damping)
        assert 0.0 <= found.amplitude[0] <= 5.53 / (2.0 * pi * ratio) / np.sqrt(1.0 - damping**2)

    def test_bad_input_is_named(self) -> None:
        with pytest.raises(ProfileError, match="ratio"):
            residual_spectrum(make("cycloidal"), [0.0])
        with pytest.raises(ProfileError, match="damping_ratio"):
            residual_spectrum(make("cycloidal"), [1.0], 1.0)


class TestResponse:
    def test_stiff_follower_is_rigid(self, motion: Program) -> None:
        stiff = FollowerTrain(
            mass=2.0, stiffness=1e12, return_stiffness=2e4, preload=150.0, tappet_mass=0.5, damping=2e5
        )
        speed = 30.0
        found = steady_state(stiff, motion, speed)
        s = 1e-3 * motion.jet(found.theta, 2)
        rigid = 2.5 * s[2] * speed**2 + 2e4 * s[0] + 150.0
        assert np.abs(found.output("contact_force")[0] - rigid).max() < 1e-3 * rigid.max()

    def test_forces_balance(self, motion: Program) -> None:
        speed = 60.0
        for train in (TRAIN, replace(TRAIN, tappet_mass=0.4, contact_stiffness=3e7, contact_damping=200.0)):
            found = steady_state(train, motion, speed, Accuracy(1e-9))
            spring = train.return_stiffness * found.output("position") + train.preload
            inertia = train.mass * found.output("acceleration")
            linkage = found.output("linkage_force")
            assert np.abs(linkage - inertia - spring).max() < 1e-9 * np.abs(linkage).max()
            if not train.two_masses:
                assert np.allclose(linkage, found.output("contact_force"), rtol=1e-12)
            torque = found.output("contact_force") * 1e-3 * motion.jet(found.theta, 1)[1]
            assert np.allclose(found.output("cam_torque"), torque, rtol=1e-12, atol=1e-12)

    def test_two_masses_with_a_hard_contact_are_one(self, motion: Program) -> None:
        one = steady_state(replace(TRAIN, tappet_mass=0.3), motion, 40.0)
        hard = replace(TRAIN, tappet_mass=0.3, contact_stiffness=2e12, contact_damping=1e4)
        two = steady_state(hard, motion, 40.0)
        a, b = one.peak("contact_force").maximum[0], two.peak("contact_force").maximum[0]
        assert a == pytest.approx(b, rel=1e-4)
        assert hard.natural_frequency()[0] == pytest.approx(TRAIN.natural_frequency()[0], rel=1e-5)

    def test_static_start_stays_static_in_a_dwell(self, motion: Program) -> None:
        class Rest:
            knots = np.array([0.0, 2.0 * pi])

            def jet(self, theta: np.ndarray, order: int = 3, side: str = "right") -> np.ndarray:
                return np.zeros((order + 1, *np.shape(theta)))

        train = replace(TRAIN, tappet_mass=0.4, contact_stiffness=3e7)
        found = from_rest(train, Rest(), 10.0)
        force = found.output("contact_force")
        assert np.ptp(force) < 1e-9 * force.max()
        assert force[0, 0] == pytest.approx(preload_share(train) * train.preload, rel=1e-12)

    def test_independent_solver_with_shaft(self, motion: Program) -> None:
        """Cam on an elastic shaft, elastic follower: scipy on the full non-linear equations in time."""
        from scipy.integrate import solve_ivp

        speed = 40.0
        shaft = CamShaft(inertia=2e-3, stiffness=5e3, damping=0.2)
        train = replace(TRAIN, stiffness=4e5)
        found = from_rest(train, motion, speed, accuracy=Accuracy(1e-8), shaft=shaft)
        start = found.solution.position[0, 0]

        def slope(t: float, y: np.ndarray) -> np.ndarray:
            angle, x, w, v = y
            s = 1e-3 * motion.jet(angle, 1)
            force = train.stiffness * (s[0] - x) + train.damping * (s[1] * w - v)
            windup = -shaft.stiffness * (angle - speed * t) - shaft.damping * (w - speed)
            turn = (windup - s[1] * force) / shaft.inertia
            rise = (force - train.return_stiffness * x - train.preload) / train.mass
            return np.array([w, v, turn, rise])

        end = RISE / speed
        run = solve_ivp(slope, (0.0, end), [start[0], start[1], speed, 0.0], method="DOP853", rtol=1e-11, atol=1e-14)
        windup = found.at(RISE, "windup")[0, 0]
        assert windup == pytest.approx(run.y[0, -1] - RISE, rel=2e-6)
        assert found.at(RISE, "position")[0, 0] == pytest.approx(run.y[1, -1], rel=1e-8)
        assert abs(windup) > 1e-6

    def test_shaft_windup_is_quasi_static_when_stiff(self, motion: Program) -> None:
        shaft = CamShaft(inertia=2e-3, stiffness=2e5, damping=2.0)
        found = steady_state(TRAIN, motion, 5.0, shaft=shaft)
        plain = steady_state(TRAIN, motion, 5.0)
        angles = np.radians([20.0, 45.0, 70.0, 200.0, 225.0, 250.0])
        expected = -plain.at(angles, "cam_torque") / shaft.stiffness
        assert found.at(angles, "windup") == pytest.approx(expected, rel=2e-2)
        assert found.peak("shaft_torque").maximum[0] == pytest.approx(plain.peak("cam_torque").maximum[0], rel=5e-3)

    def test_peaks_are_as_exact_as_the_steady_state(self) -> None:
        """Weakly damped, forced by jumps: eight stages turn through two radians of the mode in a step."""
        train = replace(TRAIN, damping=5.0)
        coarse, fine = (
            steady_state(train, program("simple-harmonic"), 41.3, accuracy).peak("contact_force").maximum[0]
            for accuracy in (Accuracy(1e-6), Accuracy(1e-11, "gauss6"))
        )
        assert coarse == pytest.approx(fine, rel=1e-6)

    def test_knocking_law_is_refused(self) -> None:
        with pytest.raises(DesignError, match=r"velocity jumps at .* degrees"):
            steady_state(TRAIN, program("constant-velocity"), 10.0)

    def test_undamped_resonance_is_refused(self, motion: Program) -> None:
        free = FollowerTrain(mass=1.0, stiffness=100.0**2)
        with pytest.raises(NotConverged, match="resonance"):
            steady_state(free, motion, 100.0 / 7.0, Accuracy(steps=200, method="gauss8"))

    def test_bad_trains_are_named(self, motion: Program) -> None:
        with pytest.raises(ProfileError, match="mass"):
            FollowerTrain(mass=0.0, stiffness=1.0)
        with pytest.raises(ProfileError, match="tappet_mass"):
            FollowerTrain(mass=1.0, stiffness=1.0, contact_stiffness=1.0)
        with pytest.raises(ProfileError, match="positive inertia"):
            CamShaft(inertia=0.0, stiffness=1.0)
        with pytest.raises(ProfileError, match="contact stiffness"):
            FollowerSystem(
                replace(TRAIN, tappet_mass=1.0), motion, np.array([1.0]), shaft=CamShaft(inertia=1, stiffness=1)
            )
        with pytest.raises(ProfileError, match="no such output"):
            steady_state(TRAIN, motion, 10.0).output("windup")
        with pytest.raises(ProfileError, match="contact_force"):
            steady_state(TRAIN, motion, 10.0).output("force")
        assert "m/s2" in OUTPUTS["acceleration"]


@pytest.fixture(scope="module")
def limit(motion: Program) -> float:
    """The lowest speed, rad/s, at which the contact force falls to zero: the first of samples, closed in."""

    def force(speed: float) -> float:
        return float(jump(steady_state(TRAIN, motion, speed)).minimum_force[0])

    sampled = np.linspace(10.0, 100.0, 65)
    first = int(np.argmax(jump(steady_state(TRAIN, motion, sampled)).lost))
    return float(brentq(force, sampled[first - 1], sampled[first], rtol=1e-9))


class TestJump:
    @pytest.mark.parametrize(("factor", "lost"), [(0.999, False), (1.002, True)])
    def test_speed_has_two_sides(self, motion: Program, limit: float, factor: float, lost: bool) -> None:
        found = jump(steady_state(TRAIN, motion, limit * factor, Accuracy(1e-9)))
        assert bool(found.lost[0]) == lost
        assert (found.required_preload[0] > TRAIN.preload) == lost

    @pytest.mark.parametrize("two", [False, True])
    def test_required_preload_just_holds(self, motion: Program, limit: float, two: bool) -> None:
        train = replace(TRAIN, tappet_mass=0.3, contact_stiffness=2e7, contact_damping=100.0) if two else TRAIN
        found = jump(steady_state(train, motion, 1.3 * limit, Accuracy(1e-9)))
        assert found.lost[0]
        again = steady_state(
            replace(train, preload=float(found.required_preload[0])), motion, 1.3 * limit, Accuracy(1e-9)
        )
        assert abs(jump(again).minimum_force[0]) < 1e-6 * found.required_preload[0]

    def test_flight_only_beyond_the_limit(self, motion: Program, limit: float) -> None:
        assert not flight(TRAIN, motion, 0.95 * limit, turns=3).events
        flown = flight(TRAIN, motion, 1.15 * limit, turns=3)
        kinds = [event.kind for event in flown.events]
        assert kinds[:4] == ["lift-off", "landing", "lift-off", "landing"]
        assert all(event.closing_speed > 0.0 for event in flown.events if event.kind == "landing")
        assert flown.largest_gap > 1e-6
        assert flown.largest_gap >= flown.deviation[flown.flying].max()

    def test_flight_is_ballistic(self, motion: Program, limit: float) -> None:
        """Between lift-off and landing the mass moves on its return spring alone: a shifted cosine."""
        speed = 1.15 * limit
        flown = flight(TRAIN, motion, speed, turns=1)
        off, on = flown.events[0].theta, flown.events[1].theta
        inside = (flown.theta > off) & (flown.theta < on)
        t = flown.theta[inside] / speed
        x = flown.deviation[inside, 0] + 1e-3 * motion.jet(flown.theta[inside], 0)[0]
        w = np.sqrt(TRAIN.return_stiffness / TRAIN.mass)
        rest = TRAIN.preload / TRAIN.return_stiffness
        basis = np.stack([np.cos(w * t), np.sin(w * t)], -1)
        fit, *_ = np.linalg.lstsq(basis, x + rest, rcond=None)
        assert np.abs(basis @ fit - x - rest).max() < 1e-13

    def test_refusals(self, motion: Program) -> None:
        closed = steady_state(replace(TRAIN, closure="form"), motion, 10.0)
        with pytest.raises(ProfileError, match="form-closed"):
            jump(closed)
        with pytest.raises(DesignError, match="tappet_stiffness"):
            flight(replace(TRAIN, tappet_mass=0.1), motion, 10.0)


class TestPolydyne:
    @pytest.mark.parametrize("two", [False, True])
    def test_response_is_the_wanted_motion(self, two: bool) -> None:
        train = FollowerTrain(mass=2.0, stiffness=4e5, return_stiffness=3e4, return_damping=60.0)
        wanted = make("5-6-7-8-9")
        if two:
            train = replace(train, tappet_mass=0.4, contact_stiffness=5e6)
            wanted = _smooth(7)
        speed = 80.0
        lift = 10.0
        cam = polydyne_motion(LawMotion(wanted, lift), wanted.peaks().order, train, speed)
        assert cam.coefficients[0] == pytest.approx(operator(train, 1.0)[0])
        response = from_rest(train, cam, speed, accuracy=Accuracy(1e-11))
        angles = np.linspace(0.0, RISE, 41)
        got = response.at(angles, "position")[0]
        assert np.abs(got - 1e-3 * lift * wanted.jet(angles / RISE, 0)[0]).max() < 1e-9 * 1e-3 * lift
        later = np.linspace(RISE, 2.0 * pi - 0.01, 50)
        assert np.abs(response.at(later, "position")[0] - 1e-3 * lift).max() < 1e-9 * 1e-3 * lift

    def test_plain_law_vibrates_where_polydyne_does_not(self) -> None:
        train = FollowerTrain(mass=2.0, stiffness=4e5)
        speed, wanted = 80.0, make("5-6-7-8-9")
        later = np.linspace(RISE, 2.0 * pi - 0.01, 200)
        plain = from_rest(train, LawMotion(wanted, 10.0), speed, accuracy=Accuracy(1e-10))
        cam = polydyne_motion(LawMotion(wanted, 10.0), wanted.peaks().order, train, speed)
        right = from_rest(train, cam, speed)
        off = from_rest(train, cam, 0.8 * speed)
        rest = [np.abs(one.at(later, "deviation")).max() for one in (plain, right, off)]
        assert rest[1] < 1e-6 * rest[0]
        assert rest[2] > 1e3 * rest[1]

    def test_slow_or_stiff_needs_no_correction(self) -> None:
        wanted = make("5-6-7-8-9")
        motion = LawMotion(wanted, 1.0)
        cam = polydyne_motion(motion, wanted.peaks().order, FollowerTrain(mass=1.0, stiffness=1e12), 1.0)
        angles = np.linspace(0.0, RISE, 101)
        assert np.abs(cam.jet(angles, 0) - motion.jet(angles, 0)).max() < 1e-10

    def test_refusals(self) -> None:
        rough, smooth = make("cycloidal"), make("5-6-7-8-9")
        with pytest.raises(ProfileError, match="needs 3"):
            polydyne_motion(LawMotion(rough, 1.0), rough.peaks().order, FollowerTrain(mass=1.0, stiffness=1e4), 10.0)
        damped = FollowerTrain(mass=1.0, stiffness=1e4, damping=1.0)
        with pytest.raises(ProfileError, match="return_damping"):
            polydyne_motion(LawMotion(smooth, 1.0), smooth.peaks().order, damped, 10.0)
        with pytest.raises(ProfileError, match="rise_time"):
            operator(FollowerTrain(mass=1.0, stiffness=1e4), 0.0)


def _smooth(order: int) -> Law:
    """The Hermite polynomial from 0 to 1 with `order` vanishing derivatives at both ends."""
    power = [0.0] * (2 * order + 2)
    for k in range(order + 1):
        power[order + 1 + k] = comb(order + k, k) * comb(2 * order + 1, order - k) * (-1.0) ** k
    return Law(f"smooth-{order}", finish([Piece(0.0, 1.0, 0.0, tuple(power))]))


def test_a_flight_knows_its_price_before_it_flies() -> None:
    motion = program()
    with pytest.raises(NotConverged, match=r"would take .* steps, more than the 100,000 that are spent"):
        flight(TRAIN, motion, 5e-4 * float(TRAIN.natural_frequency()[0]), turns=3)
