"""Joining laws: boundary conditions met, splines and their basis against scipy, measured tables smoothed."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline, make_interp_spline

from camgeom.errors import ProfileError
from camgeom.maths.splines import Basis, clamped
from camgeom.motion import LAWS, Program, Segment, make
from camgeom.motion.law import Ends
from camgeom.motion.table import PieceTable

TURN = 2 * math.pi
number = st.floats(-50.0, 50.0)
triple = st.tuples(number, number, number)


def joined(name: str, ends: Ends, **params: Any) -> PieceTable:
    entry = LAWS[name]
    assert entry.problems(params) == []
    return PieceTable.of(entry.pieces(params, ends))


@settings(max_examples=40, deadline=None)
@given(
    st.sampled_from([1, 2, 3]), number, triple, triple, st.sampled_from(["polynomial", "spline", "b-spline", "table"])
)
def test_end_states_are_met(order: int, lift: float, start: Any, end: Any, name: str) -> None:
    params: dict[str, Any] = {"order": order}
    if name == "spline":
        params["points"] = [[0.25, 1.0], [0.6, -2.0]]
    if name == "b-spline":
        params["control"] = [1.0, 3.0, -1.0]
    if name == "table":
        params |= {"rows": [[i, lift * (i / 9) ** 2] for i in range(10)], "knots": 2}
    table = joined(name, Ends(lift, start, end), **params)
    scale = 1e-11 * (1 + abs(lift) + np.abs([*start, *end]).max()) * 20.0**order
    for x, state, value in ((0.0, start, 0.0), (1.0, end, lift)):
        jet = table.jet(np.array([x]), order)[:, 0]
        assert jet[0] == value
        np.testing.assert_allclose(jet[1:], state[:order], atol=scale)


def test_b_spline_basis_is_scipys() -> None:
    knots = clamped(np.array([0.1, 0.35, 0.36, 0.9]), 5)
    x = np.linspace(0, 1, 101)
    for order in range(6):
        ours = Basis(5, knots).design(x, order)
        theirs = np.column_stack([BSpline(knots, row, 5)(x, nu=order) for row in np.eye(10)])
        np.testing.assert_allclose(ours, theirs, rtol=1e-10, atol=1e-10 * np.abs(theirs).max())


def test_spline_passes_through_its_points_as_scipys_does() -> None:
    points = [[0.2, 0.1], [0.45, 0.7], [0.5, 0.72], [0.8, 1.3]]
    x, y = np.array([[0.0, 0.0], *points, [1.0, 1.0]]).T
    ends = [(1, 0.0), (2, 0.0)]
    theirs = make_interp_spline(x, y, k=5, bc_type=(ends, ends), t=clamped(x[1:-1], 5))
    ours = make("spline", points=points)
    u = np.linspace(0, 1, 501)
    for order in range(4):
        other = theirs(u, nu=order)
        np.testing.assert_allclose(ours.jet(u, order)[order], other, atol=1e-10 * np.abs(other).max())
    assert ours.peaks().order_inside == 4


def test_b_spline_keeps_within_its_control_values() -> None:
    law = make("b-spline", control=[0.2, 0.9, 0.1, 0.95, 0.5])
    jet = law.jet(np.linspace(0, 1, 500), 0)
    assert jet.min() >= 0.0
    assert jet.max() <= 1.0
    moved = make("b-spline", control=[0.2, 0.9, 0.1, 0.95, 0.6])
    assert law.jet(0.1)[0] == pytest.approx(moved.jet(0.1)[0], abs=1e-12)
    assert abs(law.jet(0.8)[0] - moved.jet(0.8)[0]) > 0.01


def test_neighbouring_polynomials_are_the_periodic_spline() -> None:
    angles = np.array([0.0, 0.8, 1.7, 3.0, 4.4, 5.0, TURN])
    lifts = np.array([0.0, 3.0, 10.0, 4.0, -2.0, 1.0, 0.0])
    segments = [Segment(a, s, "polynomial") for a, s in zip(angles[1:], lifts[1:], strict=True)]
    program = Program.from_segments(segments)
    spline = make_interp_spline(angles, lifts, k=5, bc_type="periodic")
    theta = np.linspace(0, TURN, 333)
    for order in range(4):
        other = spline(theta, nu=order)
        np.testing.assert_allclose(program.jet(theta, order)[order], other, atol=1e-9 * np.abs(other).max())
    assert program.continuity.order == 4


def test_one_spline_or_many_polynomials_are_the_same_motion() -> None:
    many = [
        Segment(1.0),
        Segment(2.0, 4.0, "polynomial"),
        Segment(3.5, 5.0, "polynomial"),
        Segment(5.0, 0.0, "polynomial"),
    ]
    points = [[0.25, 4.0], [0.625, 5.0]]
    one = [Segment(1.0), Segment(5.0, 0.0, "spline", {"points": points})]
    theta = np.linspace(0, TURN, 400)
    first, second = (Program.from_segments([*segments, Segment(TURN)]) for segments in (many, one))
    np.testing.assert_allclose(first.jet(theta), second.jet(theta), atol=1e-10 * np.abs(first.jet(theta)).max())


def test_a_fixed_state_is_kept() -> None:
    segments = [
        Segment(1.0),
        Segment(2.0, 4.0, "polynomial", velocity=7.0, acceleration=-3.0),
        Segment(4.0, 0.0, "polynomial"),
    ]
    program = Program.from_segments([*segments, Segment(TURN)])
    for side in ("left", "right"):
        jet = program.jet(2.0, side=side)  # type: ignore[arg-type]
        np.testing.assert_allclose(jet[:3], [4.0, 7.0, -3.0], rtol=1e-13)
    assert program.continuity.order == 2
    only_velocity = [segments[0], Segment(2.0, 4.0, "polynomial", velocity=7.0), segments[2], Segment(TURN)]
    freed = Program.from_segments(only_velocity)
    assert freed.jet(2.0)[1] == pytest.approx(7.0)
    jerk = [float(freed.jet(2.0, side=side)[3]) for side in ("left", "right")]  # type: ignore[arg-type]
    assert jerk[0] == pytest.approx(jerk[1])


def test_mixed_orders_share_the_smoothest_state() -> None:
    orders = [1, 2, 3, 2]
    segments = [Segment(0.5)]
    segments += [Segment(1.0 + i, float(i % 3 + 1), "polynomial", {"order": o}) for i, o in enumerate(orders)]
    program = Program.from_segments([*segments, Segment(5.5, 0.0, "polynomial"), Segment(TURN)])
    jumps = {round(j.angle, 9): j.order for j in program.continuity.jumps if j.order < 3}
    # The cubic carries the velocity alone out of the dwell; everywhere else the acceleration is continuous.
    assert jumps == {0.5: 2}


def measured(noise: float, rows: int = 361) -> tuple[np.ndarray, np.ndarray]:
    x = np.linspace(0, 1, rows)
    return x, 20 * (0.5 - 0.5 * np.cos(TURN * x)) ** 2 + np.random.default_rng(3).normal(0, noise, rows)


@pytest.mark.parametrize("smoothing", [-1.0, 0.02])
def test_a_noisy_table_is_smoothed_below_its_noise(smoothing: float) -> None:
    x, lift = measured(0.02)
    rows = np.column_stack([360 * x, lift]).tolist()
    segment = Segment(TURN, 0.0, "table", {"rows": rows, "smoothing": smoothing})
    program = Program.from_segments([segment])
    error = program.jet(TURN * x)[0] - 20 * (0.5 - 0.5 * np.cos(TURN * x)) ** 2
    assert np.std(error) < 0.35 * 0.02
    assert program.continuity.order == 4
    assert program.jet(TURN, side="left")[0] == program.jet(0.0)[0] == 0.0


def test_a_table_keeps_to_its_rows_between_dwells() -> None:
    """A straight table joined to rest: the fit bends at the ends alone, not throughout."""
    share = np.linspace(0, 1, 101)
    law = make("table", rows=np.column_stack([share, share]).tolist())
    assert np.abs(law.jet(share)[0] - share).max() < 0.02
    assert law.peaks().order == 2
    moving = [
        Segment(1.0, 1.0, "constant-velocity"),
        Segment(2.0, 2.0, "table", {"rows": [[i, i / 50] for i in range(51)]}),
    ]
    program = Program.from_segments([*moving, Segment(3.0, 3.0, "constant-velocity"), Segment(TURN, 0.0, "polynomial")])
    np.testing.assert_allclose(program.jet(np.linspace(1.0, 2.0, 50), 1)[1], 1.0, atol=1e-9)


def test_a_clean_table_is_reproduced() -> None:
    x = np.linspace(0, 1, 241)
    rows = np.column_stack([x, make("4-5-6-7").jet(x)[0]]).tolist()
    law = make("table", rows=rows, smoothing=0.0)
    u = np.linspace(0, 1, 1001)
    np.testing.assert_allclose(law.jet(u, 2)[0], make("4-5-6-7").jet(u)[0], atol=1e-8)
    np.testing.assert_allclose(law.jet(u, 2)[2], make("4-5-6-7").jet(u)[2], atol=1e-3)


def test_a_table_file_in_degrees(tmp_path: Path) -> None:
    x, lift = measured(0.0, 181)
    lines = ["angle; lift", "# probe 3 mm", *(f"{360 * a};{b}" for a, b in zip(x, lift, strict=True))]
    (tmp_path / "lift.csv").write_text("\n".join(lines))
    segment = Segment(TURN, 0.0, "table", {"file": "lift.csv", "smoothing": 0.0})
    program = Program.from_segments([segment], angular=True, folder=str(tmp_path))
    assert program.jet(math.pi)[0] == pytest.approx(math.radians(20.0), rel=1e-6)


@pytest.mark.parametrize(
    ("params", "key", "text"),
    [
        ({"rows": [[0, 0], [1, 1]]}, "rows", "8 to 20000 rows"),
        ({"rows": [[0, 0], [2, 1], [2, 1], *([i, 1] for i in range(3, 9))]}, "rows", "row 3"),
        ({"rows": [[0, 0], [1, 0.5, 3], [2, 1]]}, "rows", "row 2"),
        ({"rows": [[i, 2 * i] for i in range(9)]}, "rows", "does not end"),
        ({"file": "no-such-file.csv"}, "file", "there is no such file"),
        ({"file": "x.csv", "rows": [[0, 0], [1, 0.5], [2, 1]]}, "rows", "not both"),
    ],
)
def test_bad_tables_are_named(params: dict[str, Any], key: str, text: str) -> None:
    with pytest.raises(ProfileError, match=text) as caught:
        make("table", **params)
    assert [problem.key for problem in caught.value.problems] == [key]


def test_a_file_with_words_names_the_row(tmp_path: Path) -> None:
    (tmp_path / "lift.csv").write_text("angle,lift\n0,0\n1,nought\n2,1\n")
    with pytest.raises(ProfileError, match=r"motion\[0\]\.file: row 2"):
        Program.from_segments([Segment(TURN, 0.0, "table", {"file": "lift.csv"})], folder=str(tmp_path))
