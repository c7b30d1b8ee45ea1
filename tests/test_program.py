"""The program round the cam: closure, jets, continuity, and every problem of a bad program."""

from __future__ import annotations

import math

import numpy as np
import pytest

from camgeom.errors import ProfileError
from camgeom.motion import Program, Segment

DEG = math.pi / 180


def pin_program() -> Program:
    return Program.from_segments(
        [
            Segment(155 * DEG),
            Segment(215 * DEG, 37.0, "cycloidal"),
            Segment(280 * DEG, 74.0, "cycloidal"),
            Segment(290 * DEG),
            Segment(360 * DEG, 0.0, "cycloidal"),
        ]
    )


def test_passes_through_the_given_positions_and_closes_exactly() -> None:
    program = pin_program()
    angles = np.array([155, 215, 280, 290]) * DEG
    assert program.jet(angles)[0].tolist() == [0.0, 37.0, 74.0, 74.0]
    assert program.jet(2 * math.pi, side="left")[0] == program.jet(0.0)[0] == 0.0


def test_is_periodic() -> None:
    program = pin_program()
    theta = np.linspace(0.1, 6.2, 50)
    np.testing.assert_allclose(program.jet(theta + 6 * math.pi), program.jet(theta), rtol=1e-9, atol=1e-9)


def test_a_turret_advances_each_turn() -> None:
    program = Program.from_segments(
        [Segment(300 * DEG, math.pi / 4, "modified-sine"), Segment(360 * DEG)], closed=False
    )
    assert program.advance == math.pi / 4
    assert program.jet(330 * DEG - 4 * math.pi)[0] == pytest.approx(-math.pi / 4, rel=1e-15)
    assert program.continuity.order == 2


def test_all_problems_at_once() -> None:
    with pytest.raises(ProfileError) as caught:
        Program.from_segments([Segment(2.0, 5.0, "cyclodial"), Segment(1.0, 7.0), Segment(6.0, math.nan, "3-4-5")])
    keys = [problem.key for problem in caught.value.problems]
    assert keys == ["motion[0].law", "motion[1].until", "motion[1].law", "motion[2].until", "motion[2].to"]
