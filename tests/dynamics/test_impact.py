"""The event solver on the reference mechanism B1, over the first 140 degrees: states, events, peaks, energy."""

import math
from dataclasses import replace

import numpy as np
import pytest

from camgeom.dynamics.impact.laws import Coulomb, HertzLine, ImpactDamping, RampedDamping
from camgeom.dynamics.impact.lift import Lift, MotionArc
from camgeom.dynamics.impact.problem import ImpactLoad, ImpactProblem, RollerSpin, State
from camgeom.dynamics.impact.run import ImpactRun, solve
from camgeom.dynamics.impact.solver import Beside, Stepped, crossing, step
from camgeom.errors import NotConverged, ProfileError
from tests.reference.impact_reference import BASE, LENGTH, LOWEST, MODULUS, ROLLER, b1_pair, b1_problem, frame_pair

END = math.radians(140.0)
RUNS: dict[tuple[str, float], ImpactRun] = {}


def run_of(contact: str, clearance: float) -> ImpactRun:
    """A solved run, shared by the tests."""
    key = (contact, clearance)
    if key not in RUNS:
        RUNS[key] = solve(b1_problem(clearance, contact=contact), end_angle=END)
    return RUNS[key]


@pytest.mark.parametrize(
    ("contact", "c", "psi", "rate", "peak", "time", "main", "back", "events"),
    [
        ("power-soft", 1e-5, 0.724315529226, 0.963970806, 9016.76899, 0.021715726, 12628.10996, 15899.12704, 7),
        ("power-soft", 1e-4, 0.724468427178, 0.937690409, 10022.59854, 0.002082041, 16799.01633, 16197.18519, 5),
        ("hertz", 1e-5, 0.724774901959, 0.143843459, 6435.28281, 0.004140341, 11692.15156, 11710.92103, 7),
        ("hertz", 1e-4, 0.724774394676, 0.147287402, 15514.68271, 0.012972554, 24519.48909, 24150.90048, 15),
    ],
)
def test_trajectory_of_the_reference_mechanism(
    contact: str, c: float, psi: float, rate: float, peak: float, time: float, main: float, back: float, events: int
) -> None:
    run = run_of(contact, c)
    end = run.recorded.state
    assert LOWEST + end.real == pytest.approx(psi, abs=2e-9)
    assert end.imag == pytest.approx(rate, abs=3e-8)
    top = run.peak("acceleration")
    assert top.value == pytest.approx(peak, rel=1e-7)
    assert top.time == pytest.approx(time, abs=3e-9)
    assert run.peak("force_main").value == pytest.approx(main, rel=1e-7)
    assert run.peak("force_return").value == pytest.approx(back, rel=1e-7)
    assert len(run.recorded.events) == events


FUNCTIONS = {
    "a parabola": (lambda t: (t - 0.3) * (t + 2.0), lambda t: 2.0 * t + 1.7, 0.3, 4),
    "a touch that turns": (lambda t: (t - 0.3) ** 3 + 1e-3 * (t - 0.3), lambda t: 3.0 * (t - 0.3) ** 2 + 1e-3, 0.3, 20),
    "a wave": (lambda t: math.sin(3.0 * (t - 0.61)), lambda t: 3.0 * math.cos(3.0 * (t - 0.61)), 0.61, 6),
    "no slope": (lambda t: math.expm1(4.0 * (t - 0.7)), lambda _: math.nan, 0.7, 30),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_an_event_is_placed_a_hair_past_its_time(name: str) -> None:
    """By the cubic of the inverse, in a few steps where its slopes are known; never before it."""
    function, slope, root, most = FUNCTIONS[name]
    nothing = Stepped(0j, 0j, 0j, 0j)
    count = 0

    def at(tau: float) -> Beside:
        nonlocal count
        count += 1
        return Beside(tau, function(tau), slope(tau), nothing)

    found = crossing(at, at(0.0), at(1.0), 1e-12, 1e-15)
    assert 0.0 < found.value <= 1e-12 or found.tau - root < 2e-15
    assert found.tau > root
    assert found.tau == pytest.approx(root, abs=1e-9)
    assert count - 2 <= most


def test_first_events() -> None:
    expected = {
        1e-4: [
            (0.001018423561, "on", State.MAIN, 0.130692026),
            (0.010141315137, "off", State.MAIN, None),
            (0.011086307216, "on", State.RETURN, 0.180284863),
            (0.029253801337, "off", State.RETURN, None),
            (0.030123567197, "on", State.MAIN, 0.137070170),
        ],
        1e-5: [
            (0.000465859655, "on", State.MAIN, None),
            (0.010141023699, "off", State.MAIN, None),
            (0.010269413918, "on", State.RETURN, 0.082102217),
            (0.019991116028, "off", State.RETURN, None),
        ],
    }
    for clearance, rows in expected.items():
        for event, (time, kind, side, speed) in zip(
            run_of("power-soft", clearance).recorded.events, rows, strict=False
        ):
            assert event.time == pytest.approx(time, abs=2e-11)
            assert (event.kind, event.state) == (kind, side)
            if speed is not None:
                assert event.approach == pytest.approx(speed, abs=2e-9)


@pytest.mark.parametrize(("c", "rise", "fall"), [(1e-5, 37.28, 107.18), (1e-4, 40.57, 110.45), (1e-3, 44.93, 114.92)])
def test_one_drive_conversion_in_the_rise_and_one_in_the_return(c: float, rise: float, fall: float) -> None:
    first, second = run_of("hertz", c).conversions
    assert (first.side, second.side) == (State.RETURN, State.MAIN)
    assert math.degrees(first.angle) == pytest.approx(rise, abs=0.006)
    assert math.degrees(second.angle) == pytest.approx(fall, abs=0.006)


@pytest.mark.parametrize("c", [1e-5, 1e-4, 1e-3])
def test_peaks_stand_against_a_ten_times_tighter_run(c: float) -> None:
    tight = solve(b1_problem(c), end_angle=END, rtol=1e-10)
    for quantity in ("acceleration", "force_main", "force_return", "pressure_main"):
        assert run_of("hertz", c).peak(quantity).value == pytest.approx(tight.peak(quantity).value, rel=1e-6)
    assert [e.kind for e in tight.recorded.events] == [e.kind for e in run_of("hertz", c).recorded.events]


@pytest.mark.parametrize(
    ("contact", "c", "work"),
    [("power-soft", 1e-5, 1.220826655), ("power-soft", 1e-4, 1.541194494), ("hertz", 1e-3, None)],
)
def test_energy_balance_closes(contact: str, c: float, work: float | None) -> None:
    energy = run_of(contact, c).energy
    assert abs(energy.residual) < 1e-6 * energy.work
    assert energy.relative_residual < 1e-8
    if work is not None:
        assert energy.work == pytest.approx(work, abs=1e-8)


def test_free_flight_estimate_of_the_second_impact() -> None:
    jerk = 30.0 * math.radians(24.0) / math.radians(70.0) ** 3 * (600 * math.pi / 30) ** 3
    for c, approach in ((1e-4, 0.18829), (1e-3, 0.87512)):
        pair = b1_pair(c)
        time = math.cbrt(6.0 * pair.play / jerk)
        hit = run_of("power-soft", c).conversions[0]
        assert 0.5 * jerk * time**2 * 0.0889 == pytest.approx(approach, rel=0.01)
        assert hit.approach_speed == pytest.approx(approach, rel=0.06)


def still_frame(law: HertzLine, damping: ImpactDamping | RampedDamping, clearance: float = 1e-3) -> ImpactProblem:
    """A frame on a cam that never moves it: a free body between two walls."""
    pair = frame_pair(Lift((MotionArc(0.0, 2 * math.pi, 0.0, (0.0,)),)), 0.04, clearance)
    return ImpactProblem(pair, 2.0, 1e-3, law, damping)


@pytest.mark.parametrize(
    ("damping", "restitution"),
    [
        (ImpactDamping(0.9), 0.895918),
        (ImpactDamping(0.9, exact=True), 0.9),
        (ImpactDamping(0.3, exact=True), 0.3),
        (ImpactDamping(1.0), 1.0),
    ],
)
@pytest.mark.parametrize("speed", [0.01, 2.0])
def test_restitution_of_a_free_impact(damping: ImpactDamping, restitution: float, speed: float) -> None:
    law = HertzLine(MODULUS, LENGTH, ROLLER, BASE)
    problem = still_frame(law, damping)
    run = solve(problem, turns=0.4e-3 / speed / problem.period * 3, start=(0.2e-3, -speed))
    on, off = run.recorded.events[:2]
    assert (on.kind, off.kind) == ("on", "off")
    assert on.approach == pytest.approx(speed, rel=1e-12)
    assert -off.approach / on.approach == pytest.approx(restitution, abs=1e-6)
    lost = 0.5 * 2.0 * speed**2 * (1.0 - restitution**2)
    assert run.energy.lost == pytest.approx(lost, abs=3e-6 * speed**2)


def test_contact_that_begins_at_rest_uses_the_floor_and_clips_instead_of_pulling() -> None:
    pair = b1_pair(1e-4)
    problem = b1_problem(1e-4, damping=ImpactDamping(0.5))
    run = solve(problem, end_angle=END, start=(0.0, 0.0))
    kinds = {event.kind for event in run.recorded.events}
    assert {"clip"} <= kinds
    assert run.trace.force.min() >= 0.0
    assert run.recorded.regimes[1].approach == 1e-3
    assert run.energy.relative_residual < 1e-8
    assert pair.play > 0.0


def test_friction_loads_and_spin_keep_the_balance() -> None:
    friction = Coulomb()
    rubbed = solve(b1_problem(1e-4, friction=friction), end_angle=END)
    assert rubbed.energy.relative_residual < 1e-9
    assert rubbed.wear[0].friction == pytest.approx(0.1 * rubbed.wear[0].sliding, rel=1e-3)
    loaded = solve(b1_problem(1e-4, load=ImpactLoad(20.0, 50.0, 5.0, 0.1)), end_angle=math.radians(60))
    assert loaded.energy.relative_residual < 1e-7
    creeping = Coulomb(0.15, 0.1, 0.05, 0.1)
    spun = solve(
        b1_problem(1e-4, friction=creeping, spin=RollerSpin(2e-4, 1e-4)), end_angle=math.radians(36), rtol=1e-7
    )
    assert spun.energy.relative_residual < 1e-6
    driven = spun.trace.sliding[..., 0][spun.trace.state == State.MAIN]
    rolling = np.abs(driven[-20:]).max()
    assert rolling < 0.2, "a free roller ends up rolling, not rubbing at the 8 m/s of a fixed one"
    assert np.abs(rubbed.trace.sliding[..., 0]).max() > 5.0


def test_true_curvature_changes_little_and_balances() -> None:
    law = HertzLine(MODULUS, LENGTH, ROLLER, BASE, true_curvature=True)
    run = solve(ImpactProblem(b1_pair(1e-4), 0.14, 20 * math.pi, law), end_angle=END)
    assert run.energy.relative_residual < 1e-9
    reference = run_of("hertz", 1e-4).peak("acceleration").value
    assert run.peak("acceleration").value == pytest.approx(reference, rel=0.05)
    assert run.peak("acceleration").value != pytest.approx(reference, rel=1e-6)


def test_states_in_between_are_as_good_as_the_solver() -> None:
    run = run_of("hertz", 1e-4)
    times = [0.0033, 0.0101, 0.0199, 0.0301]
    for time, state in zip(times, run.state_at(times), strict=True):
        until = solve(run.problem, end_angle=run.problem.speed * time, rtol=1e-11)
        assert state.real == pytest.approx(until.recorded.state.real, abs=1e-10)
        assert state.imag == pytest.approx(until.recorded.state.imag, abs=1e-6)


def test_the_method_is_of_order_eight() -> None:
    def rate(t: float, y: complex) -> tuple[complex, complex]:
        return complex(y.imag, -y.real), complex(y.real**2, t)

    errors = []
    for count in (2, 4):
        y, t, h = 1.0 + 0j, 0.0, 2.0 / count
        work = 0j
        for _ in range(count):
            made = step(rate, t, y, *rate(t, y), h)
            y, t, work = made.state, t + h, work + made.work
        errors.append(abs(y - complex(math.cos(2.0), -math.sin(2.0))))
        assert work.real == pytest.approx(1.0 + math.sin(4.0) / 4.0, abs=1e-6)
        assert work.imag == pytest.approx(2.0, abs=1e-12)
    assert 7.5 < math.log2(errors[0] / errors[1]) < 9.5


def test_refusals() -> None:
    with pytest.raises(ProfileError, match="tolerance"):
        solve(b1_problem(1e-4), rtol=1e-15)
    with pytest.raises(ProfileError, match="inertia"):
        ImpactProblem(b1_pair(1e-4), 0.0, 1.0, HertzLine(MODULUS, LENGTH, ROLLER, BASE))
    with pytest.raises(ProfileError, match="friction"):
        b1_problem(1e-4, spin=RollerSpin(1e-4))
    still = still_frame(HertzLine(MODULUS, LENGTH, ROLLER, BASE), ImpactDamping())
    with pytest.raises(ProfileError, match="roller_inertia"):
        replace(still, friction=Coulomb(), spin=RollerSpin(1e-4))
    with pytest.raises(ProfileError, match="clearance"):
        b1_pair(0.0)
    with pytest.raises(NotConverged, match="range of the Hertz"):
        solve(b1_problem(1e-4), end_angle=1.0, start=(-0.5, 0.0))
