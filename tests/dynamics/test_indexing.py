"""The indexing drive: frequencies, response, energy, refusals, against independently computed reference values."""

from __future__ import annotations

from dataclasses import replace
from math import pi, radians

import numpy as np
import pytest

from camgeom.dynamics.indexing.drive import (
    TORSION,
    IndexingDrive,
    Term,
    along,
    assemble,
    between,
    decoupled,
    definiteness,
    modes,
    periodic_spline,
)
from camgeom.dynamics.indexing.measures import dwells, energy_balance, residual_vibration
from camgeom.dynamics.indexing.modes import Mode, Modes, campbell, critical_speeds, natural_modes, speed_classes
from camgeom.dynamics.indexing.response import amplification, from_rest, steady_state, sweep
from camgeom.dynamics.indexing.system import OUTPUTS, DriveResponse, Fluctuation, TorsionSystem
from camgeom.dynamics.linear.accuracy import Accuracy
from camgeom.errors import DesignError, NotConverged, ProfileError
from camgeom.motion import Program, Segment
from tests.reference.indexing_lateral import Start, lateral_transient

RPM = pi / 30.0
DRIVE = IndexingDrive(
    cam_inertia=6.9996e-2,
    turret_inertia=3.471193e-3,
    load_inertia=5.9855881e-2,
    cam_mass=18.93348848,
    turret_mass=6.12670882,
    load_mass=6.569037,
    input_stiffness=1.9487e5,
    output_stiffness=3.5021e5,
    contact_stiffness=1.2329e6,
    cam_bending_x=3.1853e8,
    cam_bending_z=3.1853e8,
    cam_axial_y=3.8821e8,
    output_axial=3.9752e9,
    turret_bending=2.9312e9,
    load_bending=6.3888e7,
    cross_bending=8.4679e8,
    input_damping=7.0,
    output_damping=8.7,
    contact_damping=3.9,
)
UNDAMPED = replace(DRIVE, input_damping=0.0, output_damping=0.0, contact_damping=0.0)


def index(law: str, moving: float = 300.0, **parameters: float) -> Program:
    """45 degrees in `moving` degrees of cam angle, then a dwell."""
    move = Segment(radians(moving), radians(45.0), law, **parameters)
    return Program.from_segments([move, Segment(2.0 * pi)], closed=False, angular=True)


def amplified(response: DriveResponse) -> float:
    """Peak load-plate acceleration over its rigid value."""
    peak = response.peak("load_acceleration")
    return float(amplification(peak, response.system.motion, response.speed)[0])


def printed_modes(motion: Program) -> Modes:
    """Torsional modes without the contact's tau'^2 K12, as the printed equation has them."""
    angles = natural_modes(DRIVE, motion).theta
    stiffness = DRIVE.stiffness(angles, motion, TORSION)
    stiffness[:, 0, 0] -= DRIVE.contact_stiffness * motion.jet(angles, 1)[1] ** 2
    squared, shapes = modes(DRIVE.matrix(DRIVE.inertia_terms(), TORSION), stiffness)
    return Modes(angles, tuple(Mode(TORSION, angles, squared[:, k], shapes[:, :, k]) for k in range(3)), ())


@pytest.fixture(scope="module")
def mt() -> Program:
    return index("modified-trapezoid")


@pytest.fixture(scope="module")
def ms() -> Program:
    return index("modified-sine")


class TestFrequencies:
    def test_dwell(self, mt: Program) -> None:
        found = natural_modes(DRIVE, mt, np.array([radians(330.0)])).torsional()
        hertz = [float(mode.frequency_hz()[0]) for mode in found]
        assert hertz == pytest.approx([265.555936, 339.248396, 3403.751641], abs=6e-7)

    @pytest.mark.parametrize(
        ("law", "first", "second", "third"),
        [
            ("modified-sine", 249.306835, 360.982360, 3407.308962),
            ("modified-trapezoid", 245.686461, 366.190095, 3408.347464),
            ("cycloidal", 245.686461, 366.190095, 3408.347464),
            ("3-4-5", 247.584610, 363.441986, 3407.790890),
            ("4-5-6-7", 242.790088, 370.460509, 3409.249682),
            ("simple-harmonic", 252.045628, 357.135559, 3406.586467),
            ("modified-constant-velocity", 256.065233, 351.629148, 3405.620057),
        ],
    )
    def test_steepest_point(self, law: str, first: float, second: float, third: float) -> None:
        found = natural_modes(DRIVE, index(law))
        lowest, where = found.lowest_hz()
        assert lowest == pytest.approx(first, abs=6e-7)
        k = int(np.flatnonzero(found.theta == where)[0])
        hertz = [float(mode.frequency_hz()[k]) for mode in found.torsional()]
        assert hertz == pytest.approx([first, second, third], abs=6e-7)

    def test_missing_contact_term_is_a_named_comparison(self, mt: Program, ms: Program) -> None:
        assert printed_modes(mt).lowest_hz()[0] == pytest.approx(165.688011, abs=6e-7)
        assert printed_modes(ms).lowest_hz()[0] == pytest.approx(190.132500, abs=6e-7)
        for law, hertz in (
            ("3-4-5", 179.093262),
            ("4-5-6-7", 141.850321),
            ("simple-harmonic", 205.954298),
            ("modified-constant-velocity", 226.244963),
        ):
            printed = printed_modes(index(law))
            assert printed.lowest_hz()[0] == pytest.approx(hertz, abs=6e-7)
        steep = printed_modes(index("modified-trapezoid", 120.0)).torsional()[0]
        assert steep.squared.min() < 0.0
        assert not steep.oscillates
        with pytest.raises(DesignError, match="diverges"):
            steep.frequency_hz()
        true = natural_modes(DRIVE, index("modified-trapezoid", 120.0)).torsional()[0]
        assert true.oscillates

    def test_modes_are_sorted_and_labelled(self, mt: Program) -> None:
        found = natural_modes(replace(DRIVE, load_bending=6.3888e8), mt)
        assert not found.indefinite
        labels = [mode.label for mode in found.modes]
        assert labels == [
            *("torsion", "torsion", "x1", "z1", "y1", "x2 x3", "y2 y3"),
            *("z23", "torsion", "x2 x3", "y2 y3"),
        ]
        lows = [float(mode.frequency_hz().min()) for mode in found.modes]
        assert lows == sorted(lows)
        assert lows[2] == pytest.approx(652.799755, abs=6e-7)
        assert lows[4] == pytest.approx(720.672866, abs=6e-7)
        assert lows[5] == pytest.approx(1182.0764, abs=6e-5)
        assert lows[7] == pytest.approx(2816.245521, abs=6e-7)
        assert lows[9] == pytest.approx(3631.1146, abs=6e-5)

    def test_shapes_are_mass_normalised(self, mt: Program) -> None:
        mass = DRIVE.matrix(DRIVE.inertia_terms(), TORSION)
        theta = np.linspace(0.0, 2.0 * pi, 50)
        stiffness = DRIVE.stiffness(theta, mt, TORSION)
        squared, shape = modes(mass, stiffness)
        eye = np.swapaxes(shape, -1, -2) @ mass @ shape
        assert np.abs(eye - np.eye(3)).max() < 1e-12
        back = np.swapaxes(shape, -1, -2) @ stiffness @ shape
        diagonal = squared[:, :, None] * np.eye(3)
        assert np.abs(back - diagonal).max() < 1e-12 * squared.max()

    def test_critical_speeds_and_classes(self, mt: Program) -> None:
        found = natural_modes(DRIVE, mt)
        classes = speed_classes(found.lowest_hz()[0])
        assert classes.first_critical_rpm == pytest.approx(14741.1876, abs=1e-4)
        assert classes.low_rpm == pytest.approx(982.7458, abs=1e-4)
        assert classes.medium_rpm == pytest.approx(2456.8646, abs=1e-4)
        assert [classes.of(speed) for speed in (982.0, 983.0, 2456.0, 2457.0)] == ["low", "medium", "medium", "high"]
        published = speed_classes(163.91)
        assert (published.low_rpm, published.medium_rpm) == (pytest.approx(655.64), pytest.approx(1639.10))
        # at 1000 r/min harmonic 16 meets the dwell mode
        near = [one for one in critical_speeds(found, 20) if one.mode == 1 and one.order == 16]
        assert near[0].dwell_rpm == pytest.approx(60.0 * 265.555936 / 16.0, abs=1e-5)
        assert near[0].lowest_rpm < 1000.0
        diagram = campbell(found, [500.0, 1000.0], 20)
        assert diagram.lines_hz[15, 1] == pytest.approx(16.0 * 1000.0 / 60.0)
        assert len(diagram.labels) == 9


class TestBlocks:
    def test_eleven_coordinates_fall_into_blocks(self) -> None:
        assert len(DRIVE.coordinates) == 11
        expected = (TORSION, ("x1",), ("y1",), ("z1",), ("x2", "x3"), ("y2", "y3"), ("z23",))
        assert DRIVE.blocks() == expected

    def test_energy_assembly(self) -> None:
        names = ("a", "b")
        matrix = assemble([Term(2.0, between("a", "b")), Term(3.0, along("a"), along("b"))], names)
        assert np.array_equal(matrix, np.array([[2.0, 1.0], [1.0, 2.0]]))
        assert decoupled(("a", "b", "c"), np.diag([1.0, 1.0, 1.0])) == (("a",), ("b",), ("c",))

    def test_matrices_follow_from_the_energies(self, mt: Program) -> None:
        """Against the second derivatives of the energies, by exact central differences of a quadratic."""
        theta, speed = radians(100.0), 100.0
        system = TorsionSystem(DRIVE, mt, np.array([speed]))
        here = system.coefficients(np.array([[theta]]))
        slope = float(mt.jet(theta, 1)[1])
        d = DRIVE

        def potential(q: np.ndarray) -> float:
            contact = q[1] - slope * q[0]
            return 0.5 * float(
                d.input_stiffness * q[0] ** 2
                + d.output_stiffness * (q[2] - q[1]) ** 2
                + d.contact_stiffness * contact**2
            )

        unit = np.eye(3)
        expected = np.array([[potential(a + b) - potential(a) - potential(b) for b in unit] for a in unit])
        still = replace(DRIVE, contact_damping=0.0)
        stiffness = TorsionSystem(still, mt, np.array([speed])).coefficients(np.array([[theta]])).stiffness[0, 0]
        assert np.allclose(stiffness * system.mass[:, None] * speed**2, expected, rtol=1e-14)
        bend = float(mt.jet(theta, 2)[2])
        extra = (here.stiffness[0, 0] - stiffness) * system.mass[:, None] * speed**2
        c = d.contact_damping
        wanted = np.array([[c * slope * bend * speed, 0, 0], [-c * bend * speed, 0, 0], [0, 0, 0]])
        assert np.allclose(extra, wanted, atol=1e-8)

    def test_divergent_lateral_mode_is_reported_not_integrated(self, mt: Program) -> None:
        found = DRIVE.indefinite(mt)
        assert [item.block for item in found] == [("x2", "x3"), ("y2", "y3")]
        first = found[0]
        assert first.growth_rate == pytest.approx(5061.720765, abs=6e-7)
        assert first.eigenvalue == pytest.approx(-1.675154e8, rel=1e-6)
        assert first.frequencies_squared == pytest.approx((-2.56210171e7, 5.13776431e8), rel=1e-8)
        for part in ("load_bending > 2.446279e+05 N/mm", "|cross_bending| < 4.327453e+05 N/mm"):
            assert part in str(first)
        divergent = [mode for mode in natural_modes(DRIVE, mt).modes if not mode.oscillates]
        assert len(divergent) == 2
        with pytest.raises(DesignError, match=r"indefinite.*not integrated"):
            lateral_transient(DRIVE, mt, 100.0, {"x3": Start(1e-6)})
        rest = lateral_transient(DRIVE, mt, 100.0)
        assert not rest.blocks
        assert len(rest.skipped) == 6
        assert len(rest.indefinite) == 2
        assert float(np.abs(rest.position("x3")).max()) == 0.0

    @pytest.mark.parametrize(("factor", "definite"), [(1.002, True), (0.999, False)])
    def test_admissible_range_has_two_sides(self, mt: Program, factor: float, definite: bool) -> None:
        drive = replace(DRIVE, load_bending=2.446279e8 * factor)
        assert (not drive.indefinite(mt)) == definite
        drive = replace(DRIVE, cross_bending=4.327453e8 / factor)
        assert (not drive.indefinite(mt)) == definite

    def test_definiteness_ignores_units(self) -> None:
        scale = np.diag([1.0, 1e9])
        good = scale @ np.array([[2.0, 1.9], [1.9, 2.0]]) @ scale
        assert definiteness(("a", "b"), np.eye(2), good) is None
        bad = scale @ np.array([[2.0, 2.1], [2.1, 2.0]]) @ scale
        assert definiteness(("a", "b"), np.eye(2), bad) is not None

    def test_disturbed_block_oscillates_at_its_frequency(self, mt: Program) -> None:
        speed = 100.0
        found = lateral_transient(DRIVE, mt, speed, {"x1": Start(1e-6, 2e-3)}, accuracy=Accuracy(1e-10))
        w = np.sqrt(3.1853e8 / 18.93348848)
        t = next(iter(found.blocks.values())).theta / speed
        exact = 1e-6 * np.cos(w * t) + 2e-3 / w * np.sin(w * t)
        assert np.abs(found.position("x1")[0] - exact).max() < 2e-10 * np.abs(exact).max()
        assert set(found.blocks) == {("x1",)}


REFERENCE = [
    (655.64, "mt", 684.268976343, 44.437080, -661.993671439, 187.329659, 1.036582568, 1.413439250e-2),
    (1000.0, "mt", 1746.331746878, 32.099949, -1591.716351195, 208.916677, 1.137194324, 6.140355639e-2),
    (1639.1, "mt", 4279.952935711, 81.629143, -4288.597293768, 188.288136, 1.039470816, 1.828093775e-1),
    (3000.0, "mt", 18093.271652178, 46.060591, -18625.694665559, 175.284310, 1.347652446, 3.917818881e-1),
    (1639.1, "ms", 4769.548115401, 53.143678, -4748.721772794, 262.903458, 1.022237478, 1.825902612e-1),
]


class TestResponse:
    def test_transient_from_rest(self, mt: Program) -> None:
        found = from_rest(DRIVE, mt, 1000.0 * RPM, accuracy=Accuracy(1e-11))
        names = ("cam_windup", "turret_deviation", "load_deviation", "load_acceleration")
        expected = {
            60.0: (-5.947512024710e-05, -8.228864608682e-05, -3.325621524797e-04, 1468.358026634),
            130.0: (-1.129576167482e-04, -9.096365299396e-05, -2.886913874366e-04, 1153.423785274),
            220.0: (7.524347705686e-05, 9.019108888779e-05, 3.493870140521e-04, -1517.786735422),
        }
        for angle, values in expected.items():
            got = [float(found.at(radians(angle), name)[0, 0]) for name in names]
            assert got[:3] == pytest.approx(values[:3], abs=2e-16)
            assert got[3] == pytest.approx(values[3], abs=6e-10)
        last = found.solution.position[0, -1]
        assert last == pytest.approx([-2.253817033279e-06, -3.428965208113e-06, -1.612016758197e-05], abs=2e-16)
        rate = found.solution.rate[0, -1] * found.speed[0]
        assert rate == pytest.approx([2.919737312e-03, 1.056569517e-02, 4.608251621e-02], abs=6e-12)

    def test_exact_contact(self, mt: Program) -> None:
        found = from_rest(DRIVE, mt, 1000.0 * RPM, accuracy=Accuracy(1e-9), exact=True)
        expected = [-2.251924589692e-06, -3.428942319650e-06, -1.612006083252e-05]
        assert found.solution.position[0, -1] == pytest.approx(expected, abs=3e-15)
        fast = [steady_state(DRIVE, mt, 3000.0 * RPM, exact=one).peak("load_acceleration").magnitude for one in (0, 1)]
        assert abs(fast[1] / fast[0] - 1.0) == pytest.approx(6e-4, rel=0.1)

    @pytest.mark.parametrize(("rpm", "law", "top", "top_at", "bottom", "bottom_at", "ratio", "radius"), REFERENCE)
    def test_steady_state(
        self,
        request: pytest.FixtureRequest,
        rpm: float,
        law: str,
        top: float,
        top_at: float,
        bottom: float,
        bottom_at: float,
        ratio: float,
        radius: float,
    ) -> None:
        motion = request.getfixturevalue(law)
        found = steady_state(DRIVE, motion, rpm * RPM, Accuracy(1e-11))
        peak = found.peak("load_acceleration")
        assert peak.maximum[0] == pytest.approx(top, rel=3e-11)
        assert peak.minimum[0] == pytest.approx(bottom, rel=3e-11)
        assert np.degrees(peak.maximum_at[0]) == pytest.approx(top_at, abs=1.1e-6)
        assert np.degrees(peak.minimum_at[0]) == pytest.approx(bottom_at, abs=1.1e-6)
        assert amplified(found) == pytest.approx(ratio, abs=6e-10)
        assert found.solution.spectral_radius[0] == pytest.approx(radius, rel=1e-9)
        assert found.solution.error[0] <= 1e-11
        coarse = steady_state(DRIVE, motion, rpm * RPM)
        assert coarse.peak("load_acceleration").magnitude[0] == pytest.approx(peak.magnitude[0], rel=1e-6)

    def test_steady_state_is_where_the_transient_goes(self, mt: Program) -> None:
        steady = steady_state(DRIVE, mt, 1639.1 * RPM, Accuracy(1e-10))
        late = from_rest(DRIVE, mt, 1639.1 * RPM, turns=16, accuracy=Accuracy(1e-10))
        assert steady.solution.spectral_radius[0] ** 16 < 1e-11
        gap = late.solution.position[0, -1] - steady.solution.position[0, -1]
        assert np.abs(gap).max() < 1e-9 * np.abs(steady.solution.position).max()

    def test_dwell_is_free_vibration(self, mt: Program) -> None:
        """In the dwell the motion is the exponential of the constant matrix, from any angle to any other."""
        from scipy.linalg import expm

        found = from_rest(DRIVE, mt, 1639.1 * RPM, accuracy=Accuracy(1e-11))
        here = found.system.coefficients(np.array([[radians(330.0)]]))
        matrix = np.block([[np.zeros((3, 3)), np.eye(3)], [-here.stiffness[0, 0], -here.damping[0, 0]]])
        angles = radians(305.0), radians(355.0)
        q = [np.array([found.at(a, n)[0, 0] for n in list(OUTPUTS)[:3]]) for a in angles]
        k = int(np.flatnonzero(np.isclose(found.theta, radians(300.0)))[0])
        y = np.concatenate([found.solution.position[0, k], found.solution.rate[0, k]])
        for angle, value in zip(angles, q, strict=True):
            exact = expm(matrix * (angle - radians(300.0))) @ y
            assert np.abs(exact[:3] - value).max() < 1e-10 * np.abs(y[:3]).max()

    def test_independent_solver(self, mt: Program) -> None:
        """scipy's Radau on the textbook form in time, written out independently here."""
        from scipy.integrate import solve_ivp

        speed = 1639.1 * RPM
        d = DRIVE

        def motion(t: float, y: np.ndarray) -> np.ndarray:
            tau = mt.jet(speed * t, 2)
            q, v = y[:3], y[3:]
            torque = d.contact_stiffness * (q[1] - tau[1] * q[0])
            torque += d.contact_damping * (v[1] - tau[1] * v[0] - tau[2] * speed * q[0])
            shaft = d.output_stiffness * (q[2] - q[1]) + d.output_damping * (v[2] - v[1])
            a1 = (-d.input_stiffness * q[0] - d.input_damping * v[0] + tau[1] * torque) / d.cam_inertia
            a2 = (shaft - torque) / d.turret_inertia - tau[2] * speed**2
            a3 = -shaft / d.load_inertia - tau[2] * speed**2
            return np.array([*v, a1, a2, a3])

        end = radians(37.5)
        # the first piece of the law only: no knot inside
        run = solve_ivp(motion, (0.0, end / speed), np.zeros(6), method="Radau", rtol=1e-9, atol=1e-14)
        found = from_rest(DRIVE, mt, speed, accuracy=Accuracy(1e-10))
        got = [found.at(end, name)[0, 0] for name in ("cam_windup", "turret_deviation", "load_deviation")]
        assert np.abs(np.array(got) - run.y[:3, -1]).max() < 1e-7 * np.abs(run.y[:3]).max()

    @pytest.mark.parametrize("exact", [False, True])
    def test_energy_balance(self, mt: Program, exact: bool) -> None:
        drive = replace(DRIVE, cam_friction=0.05, turret_friction=0.02)
        found = steady_state(drive, mt, np.array([655.64, 3000.0]) * RPM, Accuracy(1e-9), exact=exact)
        balance = energy_balance(found)
        assert (balance.error < 1e-8).all()
        assert (balance.dissipated > 0.0).all()
        if exact:
            assert np.abs(balance.linearisation).max() == 0.0
            assert balance.input == pytest.approx(balance.dissipated, rel=1e-8)

    def test_energy_balance_notices_a_wrong_state(self, mt: Program) -> None:
        found = from_rest(DRIVE, mt, 3000.0 * RPM, accuracy=Accuracy(1e-9))
        balance = energy_balance(found)
        assert balance.error[0] < 1e-7
        assert abs(balance.kinetic[0]) > 0.01 * balance.dissipated[0]

    def test_rigid_contact_is_two_inertias(self, mt: Program) -> None:
        """K12 to infinity: the turret follows the cam and the first two frequencies are those of two inertias."""
        slope = 0.3
        stiff = replace(DRIVE, contact_stiffness=1.2329e14)
        found = natural_modes(stiff, mt)
        k = int(np.abs(mt.jet(found.theta, 1)[1] - slope).argmin())
        d = DRIVE
        mass = np.array([[d.cam_inertia + slope**2 * d.turret_inertia, 0.0], [0.0, d.load_inertia]])
        s = d.output_stiffness
        stiffness = np.array([[d.input_stiffness + slope**2 * s, -slope * s], [-slope * s, s]])
        squared = np.linalg.eigvals(np.linalg.inv(mass) @ stiffness)
        got = [mode.squared[k] for mode in found.torsional()[:2]]
        assert sorted(got) == pytest.approx(sorted(squared), rel=1e-6)

    def test_outputs_agree_with_each_other(self, mt: Program) -> None:
        found = steady_state(DRIVE, mt, 1000.0 * RPM, Accuracy(1e-9))
        load = found.output("load_acceleration") * DRIVE.load_inertia
        assert np.allclose(load, -found.output("output_torque"), atol=1e-9 * np.abs(load).max())
        turret = found.output("turret_acceleration") * DRIVE.turret_inertia
        balance = turret - found.output("output_torque") + found.output("contact_torque")
        assert np.abs(balance).max() < 1e-9 * np.abs(load).max()
        with pytest.raises(ProfileError, match="load_acceleration"):
            found.output("load_accelaration")

    def test_residual_vibration_and_settling(self, mt: Program) -> None:
        found = steady_state(DRIVE, mt, np.array([1000.0, 3000.0]) * RPM)
        assert dwells(found) == [pytest.approx((radians(300.0), 2.0 * pi))]
        first = residual_vibration(found, band=1e-5)
        at_start = np.abs(found.at(radians(300.0), "load_deviation"))[:, 0]
        assert (first.deviation >= at_start * (1.0 - 1e-12)).all()
        wide = residual_vibration(found, band=1.0)
        assert wide.settled.all()
        assert np.all(wide.settling_s == 0.0)
        never = residual_vibration(found, band=1e-12)
        assert not never.settled.any()
        whole = Program.from_segments([Segment(2 * pi, radians(45.0), "cycloidal")], closed=False, angular=True)
        moving = steady_state(DRIVE, whole, 100.0)
        with pytest.raises(ProfileError, match="no dwell"):
            residual_vibration(moving)

    def test_a_dwell_goes_on_over_the_end_of_the_turn(self, ms: Program) -> None:
        """The same motion begun in the middle of its dwell leaves the same residual and settles as late."""
        late = radians(20.0)
        move = Segment(late + radians(300.0), radians(45.0), "modified-sine")
        turned = Program.from_segments([Segment(late), move, Segment(2.0 * pi)], closed=False, angular=True)
        states = (steady_state(DRIVE, motion, 1000.0 * RPM, Accuracy(1e-9)) for motion in (ms, turned))
        plain, moved = (residual_vibration(state, 4e-5) for state in states)
        assert (moved.begin_rad, moved.end_rad) == pytest.approx((radians(320.0), 2.0 * pi + late))
        assert moved.deviation == pytest.approx(plain.deviation, rel=1e-7)
        assert moved.acceleration == pytest.approx(plain.acceleration, rel=1e-7)
        assert plain.settled.all()
        assert 0.0 < plain.settling_s[0] < 60.0 / 6000.0
        assert moved.settling_s == pytest.approx(plain.settling_s, rel=1e-2)
        # a transient has no turn before its first
        assert residual_vibration(from_rest(DRIVE, turned, 1000.0 * RPM)).end_rad == pytest.approx(2.0 * pi)

    def test_input_speed_fluctuation(self, mt: Program) -> None:
        plain = steady_state(DRIVE, mt, 1000.0 * RPM, Accuracy(1e-8))
        still = steady_state(DRIVE, mt, 1000.0 * RPM, Accuracy(1e-8), Fluctuation(((2, 0.0, 0.3),)))
        assert np.allclose(still.solution.position[:, -1], plain.solution.position[:, -1], rtol=1e-6)
        uneven = steady_state(DRIVE, mt, 1000.0 * RPM, Accuracy(1e-9), Fluctuation(((2, 0.05, 0.3),)))
        balance = energy_balance(uneven)
        assert abs(amplified(uneven) / amplified(plain) - 1.0) > 1e-3
        assert np.isfinite(balance.input).all()
        with pytest.raises(ProfileError, match=r"below 0\.9"):
            Fluctuation(((1, 0.95, 0.0),))

    def test_external_torque_is_static_at_crawl(self, mt: Program) -> None:
        def torque(theta: np.ndarray, side: str) -> np.ndarray:
            out = np.zeros((*theta.shape, 3))
            out[..., 2] = -50.0
            return out

        found = steady_state(DRIVE, mt, 20.0 * RPM, Accuracy(1e-6), torque=torque)
        k = int(np.abs(found.theta - radians(350.0)).argmin())
        wanted = -50.0 * (1.0 / DRIVE.output_stiffness + 1.0 / DRIVE.contact_stiffness)
        assert found.solution.position[0, k, 2] == pytest.approx(wanted, rel=1e-4)

    def test_varying_contact_stiffness(self, mt: Program) -> None:
        angles = np.arange(72) * 2.0 * pi / 72
        flat = replace(DRIVE, contact_table=(1.2329e6,) * 72)
        plain = steady_state(DRIVE, mt, 1000.0 * RPM, Accuracy(1e-9)).peak("load_acceleration").maximum[0]
        same = steady_state(flat, mt, 1000.0 * RPM, Accuracy(1e-9)).peak("load_acceleration").maximum[0]
        assert same == pytest.approx(plain, rel=1e-10)
        waved = replace(DRIVE, contact_table=tuple(1.2329e6 * (1.0 + 0.3 * np.cos(3.0 * angles))))
        other = steady_state(waved, mt, 1000.0 * RPM, Accuracy(1e-6))
        assert abs(other.peak("load_acceleration").maximum[0] / plain - 1.0) > 1e-4
        fine = np.linspace(0.0, 2.0 * pi, 1000)
        values = np.cos(3.0 * angles)
        assert np.abs(periodic_spline(tuple(values), fine) - np.cos(3.0 * fine)).max() < 3e-5
        assert np.abs(periodic_spline(tuple(values), angles) - values).max() < 1e-14
        rate = periodic_spline(tuple(values), fine, slope=True)
        assert np.abs(rate + 3.0 * np.sin(3.0 * fine)).max() < 1e-3

    @pytest.mark.parametrize("exact", [False, True])
    def test_a_stiffness_that_varies_gives_and_takes_power(self, mt: Program, exact: bool) -> None:
        """K12' omega/2 times the stretch squared: without it a turn that rings misses tenths of a per cent."""
        angles = np.arange(72) * 2.0 * pi / 72
        waved = replace(DRIVE, contact_table=tuple(1.2329e6 * (1.0 + 0.3 * np.cos(3.0 * angles))))
        found = energy_balance(steady_state(waved, mt, 3000.0 * RPM, Accuracy(1e-9), exact=exact))
        assert found.error[0] < 1e-7
        assert abs(found.varying[0]) > 1e-3 * found.dissipated[0]


class TestHardCases:
    def test_undamped_resonance_is_refused_by_name(self, mt: Program) -> None:
        # a dwell all round has constant coefficients, so the resonance is exactly where it should be
        rest = replace(UNDAMPED, contact_stiffness=1.2329e6)

        class Still:
            knots = np.array([0.0, 2.0 * pi])

            def jet(self, theta: np.ndarray, order: int = 3, side: str = "right") -> np.ndarray:
                return np.zeros((order + 1, *np.shape(theta)))

        squared = natural_modes(rest, Still()).torsional()[0].squared[0]
        with pytest.raises(NotConverged, match="resonance"):
            steady_state(rest, Still(), np.sqrt(squared) / 7.0, Accuracy(steps=512, method="gauss8"))
        off = steady_state(rest, Still(), np.sqrt(squared) / 7.5, Accuracy(steps=512, method="gauss8"))
        assert np.abs(off.solution.position).max() == 0.0
        assert "never dies out" in off.solution.cautions[0]

    def test_undamped_steady_state_is_marked(self, mt: Program) -> None:
        found = steady_state(UNDAMPED, mt, 1000.0 * RPM)
        assert not found.solution.attracting.any()
        assert found.solution.spectral_radius[0] == pytest.approx(1.0, abs=1e-9)
        assert steady_state(DRIVE, mt, 1000.0 * RPM).solution.attracting.all()

    def test_parametric_instability_is_refused(self, mt: Program) -> None:
        speeds = np.linspace(8000.0, 8400.0, 41) * RPM
        found = sweep(UNDAMPED, mt, speeds)
        assert found.refused
        assert all("grows by" in reason for _, reason in found.refused)
        assert 0 < found.answered.sum() < len(speeds)
        damped = sweep(DRIVE, mt, speeds[::10])
        assert not damped.refused

    @pytest.mark.parametrize("factor", [1e-6, 1e6])
    @pytest.mark.parametrize("name", ["contact_stiffness", "input_stiffness", "output_stiffness"])
    def test_extreme_stiffness(self, mt: Program, name: str, factor: float) -> None:
        drive = replace(DRIVE, **{name: getattr(DRIVE, name) * factor})
        if (name, factor) == ("input_stiffness", 1e-6):
            # the cam hangs on 0.19 N m/rad: the linearised turn itself multiplies disturbances, on every grid
            with pytest.raises(NotConverged, match=r"grows by 1\.07198"):
                steady_state(drive, mt, 1000.0 * RPM, Accuracy(1e-4))
            return
        found = steady_state(drive, mt, 1000.0 * RPM, Accuracy(1e-4))
        assert np.isfinite(found.solution.state).all()
        assert found.solution.error[0] <= 1e-4
        assert energy_balance(found).error[0] < 1e-2

    def test_one_step_a_turn(self, mt: Program) -> None:
        coarse = steady_state(DRIVE, mt, 1000.0 * RPM, Accuracy(steps=1, method="gauss4"))
        assert coarse.solution.grid.steps == len(mt.knots) - 1
        assert np.isfinite(coarse.solution.state).all()
        assert (coarse.solution.error > 0.1).all()

    @pytest.mark.slow
    def test_a_hundred_thousand_steps(self, mt: Program) -> None:
        found = from_rest(DRIVE, mt, 1000.0 * RPM, accuracy=Accuracy(steps=100_000, method="gauss2"))
        expected = [-2.253817033279e-06, -3.428965208113e-06, -1.612016758197e-05]
        assert found.solution.position[0, -1] == pytest.approx(expected, rel=1e-8)
        assert found.solution.grid.steps >= 100_000

    def test_bad_data_is_named(self) -> None:
        with pytest.raises(ProfileError, match="load_inertia") as caught:
            replace(DRIVE, load_inertia=0.0, input_damping=-1.0)
        assert len(caught.value.problems) == 2
        with pytest.raises(ProfileError, match="finite"):
            replace(DRIVE, contact_stiffness=float("nan"))
        with pytest.raises(ProfileError, match="positive and finite"):
            TorsionSystem(DRIVE, index("cycloidal"), np.array([0.0]))
        with pytest.raises(ProfileError, match="tolerance"):
            Accuracy(1e-16)
        with pytest.raises(ProfileError, match="wilson"):
            Accuracy(method="wilsom")


class TestSweep:
    def test_agrees_with_single_speeds(self, mt: Program) -> None:
        rpm = np.array([655.64, 1000.0, 1639.1, 3000.0])
        found = sweep(DRIVE, mt, rpm * RPM, Accuracy(1e-11))
        assert found.answered.all()
        assert found.peaks["load_acceleration"].maximum == pytest.approx([row[2] for row in REFERENCE[:4]], rel=3e-11)
        ratio = amplification(found.peaks["load_acceleration"], mt, found.speed)
        assert ratio == pytest.approx([row[6] for row in REFERENCE[:4]], abs=6e-10)
        assert (found.error <= 1e-11).all()
        assert found.speed_rpm == pytest.approx(rpm)

    def test_published_peaks_are_below_the_kinematic_bound(self, mt: Program) -> None:
        """No rest-to-rest law of 45 degrees in 300 gives 427.5 or 2852.4 rad/s2: bound 4 delta (omega/theta)^2."""
        speed = np.array([655.64, 1639.1]) * RPM
        bound = 4.0 * radians(45.0) / radians(300.0) ** 2 * speed**2
        assert bound == pytest.approx([540.2, 3376.0], rel=1e-3)
        found = sweep(DRIVE, mt, speed)
        assert (found.peaks["load_acceleration"].magnitude > bound).all()
        assert (bound > [427.5, 2852.4]).all()
