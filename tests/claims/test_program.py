"""The program round the cam: closure, jets, continuity, peaks, extremes of scale, and every problem of a bad one."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from camgeom.errors import ProfileError
from camgeom.motion import LAWS, Program, Segment, make

DEG = math.pi / 180
TURN = 2 * math.pi
PLAIN = [name for name, entry in LAWS.items() if not entry.joins]


def pin_program() -> Program:
    moves = [(155, None), (215, 37.0), (280, 74.0), (290, None), (360, 0.0)]
    return Program.from_segments(
        [Segment(until * DEG, to, "cycloidal" if to is not None else None) for until, to in moves]
    )


def test_passes_through_the_given_positions_and_closes_exactly() -> None:
    program = pin_program()
    assert program.jet(np.array([155, 215, 280, 290]) * DEG)[0].tolist() == [0.0, 37.0, 74.0, 74.0]
    assert program.jet(TURN, side="left")[0] == program.jet(0.0)[0] == 0.0
    assert program.closed
    assert program.continuity.order == 2


def test_derivatives_are_per_radian() -> None:
    program, law = pin_program(), make("cycloidal")
    theta = np.linspace(155.5, 214.5, 60) * DEG
    width = 60 * DEG
    jet = law.jet((theta - 155 * DEG) / width)
    np.testing.assert_allclose(program.jet(theta), 37 * jet / width ** np.arange(4)[:, None], rtol=1e-11, atol=1e-11)
    middle = program.jet(185 * DEG, 1)
    assert middle == pytest.approx([18.5, 2 * 37 / width])


def test_is_periodic() -> None:
    program = pin_program()
    theta = np.linspace(0.1, 6.2, 50)
    for turns in (-3, 1, 40):
        shifted = program.jet(theta + turns * TURN)
        np.testing.assert_allclose(shifted, program.jet(theta), rtol=1e-9, atol=1e-9)


def test_a_turret_advances_each_turn() -> None:
    segments = [Segment(300 * DEG, math.pi / 4, "modified-sine"), Segment(TURN)]
    program = Program.from_segments(segments, closed=False, angular=True)
    assert program.advance == math.pi / 4
    assert not program.closed
    assert program.jet(330 * DEG - 2 * TURN)[0] == pytest.approx(-math.pi / 4, rel=1e-15)
    assert program.jet(TURN, side="left")[0] == program.jet(TURN)[0] == math.pi / 4
    assert program.continuity.order == 2
    assert 0.0 not in [jump.angle for jump in program.continuity.jumps if jump.order == 0]


def test_order_of_points_and_their_number_do_not_matter() -> None:
    program = pin_program()
    theta = np.random.default_rng(1).uniform(-10, 20, 5000)
    whole = program.jet(theta)
    np.testing.assert_array_equal(program.jet(np.sort(theta)), whole[:, np.argsort(theta)])
    one_by_one = np.column_stack([program.jet(float(t)) for t in theta[:200]])
    np.testing.assert_allclose(one_by_one, whole[:, :200], rtol=1e-12, atol=1e-12)
    assert program.jet(theta.reshape(50, 100), 1).shape == (2, 50, 100)
    assert program.jet(np.empty(0)).shape == (4, 0)


def test_both_sides_of_a_jump() -> None:
    segments = [Segment(1.0), Segment(2.0, 5.0, "simple-harmonic"), Segment(4.0), Segment(TURN, 0.0, "cycloidal")]
    program = Program.from_segments(segments)
    assert program.continuity.order == 1
    jump = next(j for j in program.continuity.jumps if j.order == 2)
    assert jump.angle == 1.0
    assert jump.size == pytest.approx(5 * math.pi**2 / 2, rel=1e-14)
    assert program.jet(1.0, side="left")[2] == 0.0
    assert program.jet(1.0)[2] == jump.size
    assert [j.angle for j in program.continuity.jumps if j.order == 2] == [1.0, 2.0]


def test_constant_velocity_against_a_dwell_jumps_and_joined_by_polynomials_does_not() -> None:
    ramp = Segment(3.0, 30.0, "constant-velocity")
    hard = [Segment(1.0), ramp, Segment(4.0), Segment(TURN, 0.0, "cycloidal")]
    assert Program.from_segments(hard).continuity.order == 0
    soft = [Segment(1.0), Segment(1.5, 3.0, "polynomial"), ramp, Segment(3.5, 33.0, "polynomial"), Segment(4.0)]
    program = Program.from_segments([*soft, Segment(TURN, 0.0, "cycloidal")])
    assert program.continuity.order == 2
    np.testing.assert_allclose(program.jet([1.5, 3.0], 2, side="left")[1:], program.jet([1.5, 3.0], 2)[1:], atol=1e-11)
    smoother = [Segment(s.until, s.to, s.law, {"order": 3} if s.law == "polynomial" else ()) for s in soft]
    assert Program.from_segments([*smoother, Segment(TURN, 0.0, "4-5-6-7")]).continuity.order == 3


def test_a_polynomial_takes_over_the_acceleration_of_its_neighbour() -> None:
    segments = [Segment(1.0), Segment(2.0, 5.0, "double-harmonic"), Segment(3.0, 0.0, "polynomial"), Segment(TURN)]
    program = Program.from_segments(segments)
    assert program.jet(2.0)[2] == pytest.approx(-5 * math.pi**2, rel=1e-12)
    assert program.continuity.order == 2


def test_knots_are_segment_ends_and_breaks_of_laws() -> None:
    program = Program.from_segments([Segment(1.0), Segment(3.0, 5.0, "modified-sine"), Segment(TURN, 0.0, "cycloidal")])
    np.testing.assert_allclose(program.knots, [0, 1, 1.25, 2.75, 3, TURN], rtol=1e-15)
    assert program.knots[-1] == TURN
    jets = program.jet(program.knots[1:-1], 4) - program.jet(program.knots[1:-1], 4, side="left")
    assert np.all(np.abs(jets[3:]).max(axis=0) > 1.0)


@pytest.mark.parametrize("name", PLAIN)
def test_peaks_are_those_of_the_law(name: str) -> None:
    program = Program.from_segments([Segment(1.0), Segment(3.0, 7.0, name), Segment(5.0), Segment(TURN, 0.0, "3-4-5")])
    claims = make(name).peaks()
    slow = {1: 7 * 1.875 / 1.2831853, 2: 7 * 5.7735 / 1.2831853**2, 3: 7 * 60 / 1.2831853**3}
    for order, value in ((1, claims.vm), (2, claims.am), (3, claims.jm)):
        own = 7 * value / 2**order
        if math.isfinite(value) and own > slow[order]:
            peak = program.peak(order)
            assert abs(peak.value) == pytest.approx(own, rel=1e-10)
            assert 1.0 <= peak.at <= 3.0
            sides = [program.jet(peak.at, order, side)[order] for side in ("left", "right")]  # type: ignore[arg-type]
            assert min(abs(side - peak.value) for side in sides) <= 1e-9 * abs(peak.value)


def test_extremes_and_their_angles() -> None:
    program = Program.from_segments([Segment(2.0, 10.0, "3-4-5"), Segment(TURN, 0.0, "3-4-5")])
    low, high = program.extremes(1)
    assert (high.value, high.at) == pytest.approx((1.875 * 10 / 2, 1.0), rel=1e-12)
    assert (low.value, low.at) == pytest.approx((-1.875 * 10 / (TURN - 2), 1 + math.pi), rel=1e-12)
    assert program.peak(1) == high
    top = program.extremes(0)[1]
    assert (top.value, top.at) == pytest.approx((10.0, 2.0))
    crossing = 0.5 - math.sqrt(3) / 6
    assert program.peak(2).at == pytest.approx(2 * crossing, rel=1e-9)


def test_mean_square_agrees_with_quadrature() -> None:
    program = pin_program()
    expected = sum(
        quad(lambda t: float(program.jet(t, 2)[2]) ** 2, low, high, epsabs=1e-7)[0]
        for low, high in zip(program.knots[:-1], program.knots[1:], strict=True)
    )
    assert program.mean_square(2) == pytest.approx(expected / TURN, rel=1e-9)


def test_a_standing_follower() -> None:
    program = Program.from_segments([Segment(TURN)], start=4.0)
    assert program.jet([0.0, 1.0, 7.0]).tolist() == [[4.0] * 3, [0.0] * 3, [0.0] * 3, [0.0] * 3]
    assert program.peak(1).value == 0.0
    assert program.continuity.jumps == ()


widths = st.lists(st.sampled_from([1e-6, 1e-3, 0.3, 5.0, 60.0]), min_size=2, max_size=12)
scales = st.sampled_from([1e-9, 1e-3, 1.0, 1e3, 9e4])


@settings(max_examples=40, deadline=None)
@given(widths, scales, st.data())
def test_any_program_meets_its_positions_and_closes(parts: list[float], scale: float, data: Any) -> None:
    ends = np.cumsum(parts) / np.sum(parts) * TURN
    ends[-1] = TURN
    lifts = [scale * data.draw(st.floats(-1, 1)) for _ in parts[:-1]] + [0.0]
    names = [data.draw(st.sampled_from([*PLAIN, "polynomial", "dwell"])) for _ in parts]
    segments, position = [], 0.0
    for until, to, name in zip(ends, lifts, names, strict=True):
        if name == "dwell" and until < TURN:
            segments.append(Segment(float(until)))
        else:
            segments.append(Segment(float(until), to, name.replace("dwell", "cycloidal")))
            position = to
    assert position == 0.0
    program = Program.from_segments(segments)
    at_knots = program.jet(ends[:-1], 0)[0]
    np.testing.assert_array_equal(at_knots, [span.after for span in program.spans[:-1]])
    np.testing.assert_allclose(program.jet(ends, 0, side="left")[0], [s.after for s in program.spans], rtol=1e-15)
    assert program.jet(TURN, 0, side="left")[0] == program.jet(0.0, 0)[0] == 0.0
    assert np.all(np.isfinite(program.jet(np.linspace(0, TURN, 500))))
    if not {"constant-velocity"} & set(names):
        assert program.continuity.order >= 1


def test_a_dwell_of_a_millionth_of_a_degree() -> None:
    tiny = 1e-6 * DEG
    segments = [Segment(1.0, 10.0, "cycloidal"), Segment(1.0 + tiny), Segment(TURN, 0.0, "cycloidal")]
    program = Program.from_segments(segments)
    assert program.continuity.order == 2
    assert program.jet([1.0, 1.0 + tiny / 2, 1.0 + tiny], 1)[:, 1].tolist() == [10.0, 0.0]


def test_the_shortest_segment_moves_without_a_false_jump() -> None:
    segments = [
        Segment(3.0),
        Segment(3.0 + 2e-9 * DEG, 1e-9, "modified-trapezoid"),
        Segment(5.0),
        Segment(TURN, 0.0, "3-4-5"),
    ]
    program = Program.from_segments(segments)
    assert program.continuity.order == 2
    assert program.jet(3.0 + 2e-9 * DEG)[0] == 1e-9
    assert np.all(np.isfinite(program.jet(program.knots)))


def test_a_thousand_segments() -> None:
    count = 1000
    names = ["modified-sine", "3-4-5", "cycloidal", "polynomial"]
    segments = [Segment((i + 1) / count * TURN, 10.0 * ((i + 1) % 2), names[i % 4]) for i in range(count)]
    program = Program.from_segments(segments)
    theta = np.linspace(0, TURN, 4001)
    assert program.continuity.order == 2
    assert program.jet(theta)[0].min() >= -1e-12
    assert program.jet(theta)[0].max() <= 10.0 + 1e-12
    width = TURN / count
    assert abs(program.peak(1).value) == pytest.approx(20.0 / width, rel=1e-9)


def test_an_angle_must_be_finite() -> None:
    with pytest.raises(ValueError, match="finite"):
        pin_program().jet([0.0, math.inf])


def problems(segments: list[Segment], **options: Any) -> list[tuple[str, object]]:
    with pytest.raises(ProfileError) as caught:
        Program.from_segments(segments, **options)
    return [(problem.key, problem.value) for problem in caught.value.problems]


def test_all_problems_at_once() -> None:
    segments = [Segment(2.0, 5.0, "cyclodial"), Segment(1.0, 7.0), Segment(6.0, math.nan, "3-4-5", {"share": 1})]
    assert [key for key, _ in problems(segments)] == [
        "motion[0].law",
        "motion[1].until",
        "motion[1].law",
        "motion[2].until",
        "motion[2].to",
        "motion[2].share",
    ]


@pytest.mark.parametrize(
    ("segments", "key"),
    [
        ([], "motion"),
        ([Segment(1.0)], "motion[0].until"),
        ([Segment(math.nan)], "motion[0].until"),
        ([Segment(1.0), Segment(1.0 + 1e-12), Segment(TURN)], "motion[1].until"),
        ([Segment(8.0)], "motion[0].until"),
        ([Segment(TURN, 2.0, "cycloidal")], "motion[0].to"),
        ([Segment(3.0, 1e6, "cycloidal"), Segment(TURN, 0.0, "cycloidal")], "motion[0].to"),
        ([Segment(TURN, None, "cycloidal")], "motion[0].to"),
        ([Segment(TURN, None, None, {"share": 0.2})], "motion[0].share"),
        ([Segment(3.0, 1.0, "modified-sine", {"share": 0.7}), Segment(TURN, 0.0, "cycloidal")], "motion[0].share"),
        ([Segment(3.0, 1.0, "cycloidal", velocity=1.0), Segment(TURN, 0.0, "polynomial")], "motion[0].velocity"),
        ([Segment(3.0, 1.0, "polynomial", jerk=1.0), Segment(TURN, 0.0, "polynomial")], "motion[0].jerk"),
        ([Segment(3.0, 1.0, "polynomial", velocity=math.nan), Segment(TURN, 0.0, "polynomial")], "motion[0].velocity"),
    ],
)
def test_each_problem_names_its_key(segments: list[Segment], key: str) -> None:
    assert [found for found, _ in problems(segments)] == [key]


def test_problems_are_shown_in_degrees() -> None:
    segments = [Segment(180 * DEG, 30 * DEG, "cycloidal"), Segment(TURN, 20 * DEG, "cycloidal")]
    (key, value), *rest = problems(segments, angular=True, key="motion")
    assert key == "motion[1].to"
    assert value == pytest.approx(20.0)
    assert rest == []
    assert problems([Segment(90 * DEG)]) == [("motion[0].until", pytest.approx(90.0))]


def test_touching_the_limits() -> None:
    """A full turn met within rounding is a full turn; one part in 1e8 off is not."""
    Program.from_segments([Segment(TURN * (1 + 1e-15))])
    assert problems([Segment(TURN * (1 - 1e-8))])[0][0] == "motion[0].until"
    rise = Segment(3.0, 10.0, "cycloidal")
    closed = Program.from_segments([rise, Segment(TURN, 1e-9, "cycloidal")])
    assert closed.jet(TURN, side="left")[0] == 0.0
    assert problems([rise, Segment(TURN, 1e-7, "cycloidal")])[0][0] == "motion[1].to"
