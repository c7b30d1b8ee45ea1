"""Failures that the random campaign found, each held down: no silent one may come back."""

from __future__ import annotations

from math import degrees

import numpy as np
import pytest
from machines import pin_cam, pin_setup, program

from camgeom.errors import DesignError
from camgeom.job import compute
from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.survey import Survey

DISC = {
    "cam": {"kind": "disc", "base_radius": 30.0, "width": 12.0},
    "follower": {"kind": "translating", "mass": 0.5},
    "roller": {"diameter": 20.0, "length": 8.0},
    "motion": (
        {"until": 120.0, "to": 12.0, "law": "cycloidal"},
        {"until": 300.0, "to": 0.0, "law": "cycloidal"},
        {"until": 360.0},
    ),
    "output": {"tolerance": 0.02},
}


def changed(**sections):
    """The disc's tables with keys replaced."""
    return {**DISC, **{name: {**DISC.get(name, {}), **keys} for name, keys in sections.items()}}


@pytest.mark.parametrize("times", [0.5, 0.9, 1.1, 1.9, 2.1, 3.0, 10.0])
def test_margin_of_a_flank_folded_once_or_twice(times):
    # A short parabolic rise from rest: the pitch curve has one curvature k there, and r k is chosen.
    rise = 0.02
    height = times * 67.0**2 / 11.0 * rise**2 / 4.0
    up, down = (100 + degrees(rise), height, "parabolic"), (300, 0.0, "cycloidal")
    motion = program((100, None, None), up, down, (360, None, None))
    setup = pin_setup(motion=motion)
    survey = Survey(pin_cam().tracks(setup)[0], pin_cam().cutters(setup)[0])
    # At the wall's inner end the same motion is on a smaller radius: 55 mm and not 67.
    assert survey.margin.value <= 1.0 - times * (67.0 / 68.0) ** 2
    assert (survey.margin.value > 0.0) == (times < 0.6)


def test_rollers_narrower_than_the_disc_are_measured_against_its_wall():
    model = Model(from_data(DISC))
    finding = next(f for f in compute(model, ("checks",)).findings if f.check == "interference")
    assert finding.value == pytest.approx(0.0, abs=1e-9)
    # A larger roller than the cam was cut for stands in it by the difference.
    assert model.clearances_with(0.25)[0].value == pytest.approx(-0.25, abs=1e-9)


def test_a_stress_that_has_no_answer_leaves_the_rest_of_the_result():
    data = changed(operation={"speed": 10.0, "friction": 1e8})
    result = compute(Model(from_data(data)), ("motion", "solid", "contact", "fatigue"))
    assert "half-space" in result.data["contact"]["refused"]
    assert result.data["solid"]["watertight"]
    assert not result.refused
    assert not result.passed
    assert [name for name, _ in result.unanswered] == ["contact", "fatigue"]


def test_singular_surface_gives_large_curvatures_and_no_warning():
    from camgeom.maths.surface import Forms

    one, zero = np.ones(3), np.zeros(3)
    high, low = Forms(one, one, one, one, zero, zero).principal()
    assert np.isfinite([high, low]).all()
    assert (np.maximum(np.abs(high), np.abs(low)) > 1e12).all()
    flat = Forms(zero, zero, zero, zero, zero, zero).principal()
    assert np.isfinite(flat).all()


def test_undercut_seed_is_refused_by_name():
    data = dict(DISC)
    data["motion"] = (
        {"until": 20.0, "to": 12.0, "law": "cycloidal"},
        {"until": 40.0, "to": 0.0, "law": "cycloidal"},
        {"until": 360.0},
    )
    model = Model(from_data(data))
    with pytest.raises(DesignError, match="undercut at cam angle"):
        _ = model.solid
