"""Conjugate pairs whose return roller is another one: each disc by the oracle, each roller by its own figures."""

from __future__ import annotations

import sys
import tomllib
from typing import Any

import numpy as np
import pytest

from camgeom.cams import starter
from camgeom.checks import judge as verdict_of
from camgeom.errors import ProfileError
from camgeom.model import Model
from camgeom.model.impact import impact_problem
from tests.places import ROOT
from tests.profile.cases import made
from tests.reference.profiles import built, changed

sys.path.insert(0, str(ROOT / "scripts" / "stability"))

from judging import judge

Data = dict[str, Any]
SMALL = {"diameter": 26.0, "length": 12.0}
FAST: Data = {"operation": {"speed": 1200.0, "friction": 5.0}}
"""so fast that inertia presses both rollers"""


def data_of(case: str, **keys: Any) -> Data:
    return changed(made(case), **keys)


def model_of(case: str, **keys: Any) -> Model:
    return built(data_of(case, **keys))


@pytest.mark.parametrize(("case", "diameter"), [("pair, rocker", 48.0), ("pair, slide", 12.0)])
def test_both_discs_lie_where_the_oracle_says(case: str, diameter: float) -> None:
    record = judge(data_of(case, return_roller={"diameter": diameter, "length": 9.0}, output={"tolerance": 0.05}))
    assert record["outcome"] == "good", record
    assert 0.3 < record["error"] <= 1.0 + 1e-6


def test_each_roller_has_the_figures_that_it_has_in_a_pair_of_its_own_kind() -> None:
    """The slide's return disc is that of a pair of return rollers on the same two circles of centres."""
    first, last = 20.0, SMALL["diameter"]
    mixed = model_of("pair, slide", **FAST, return_roller=SMALL)
    same = model_of("pair, slide", **FAST)
    stroke, half = 12.0, 0.5 * (first - last)
    radii = {"cam__base_radius": 40.0 + half, "cam__return_radius": 40.0 + stroke}
    other = model_of("pair, slide", **FAST, roller=SMALL, **radii)
    for index, alone in enumerate((same, other)):
        found, wanted = mixed.duties[index], alone.duties[index]
        assert found.peak_pressure.value > 100.0
        assert found.peak_pressure.value == pytest.approx(wanted.peak_pressure.value, rel=1e-12)
        assert found.lives == pytest.approx(wanted.lives, rel=1e-9)
        phi = np.linspace(0.0, 6.0, 50)
        name = ("main", "return")[index]
        curves = [model.mechanism.outlines[name].curve(phi).points for model in (mixed, alone)]
        assert np.abs(curves[0] - curves[1]).max() < 1e-11
    assert mixed.duties[1].length == 12.0
    assert mixed.duties[0].peak_pressure.value != pytest.approx(mixed.duties[1].peak_pressure.value, rel=0.01)


def test_a_bearing_is_judged_by_its_own_rating() -> None:
    keys = {**FAST, "roller__dynamic_rating": 30000.0, "roller__static_rating": 40000.0}
    load = model_of("pair, slide", **keys, return_roller=SMALL).duties[1].peak_force.value
    for share, level in ((0.999, "fail"), (1.002, "warn")):
        back = {**SMALL, "dynamic_rating": 9000.0, "static_rating": share * load}
        found = verdict_of(model_of("pair, slide", **keys, return_roller=back), ["bearing"])
        (safety,) = [one for one in found.findings if "static" in one.where]
        assert safety.level == level
        assert "return roller" in safety.where
    unrated = verdict_of(model_of("pair, slide", **keys, return_roller=SMALL), ["bearing"])
    assert any("return_roller.dynamic_rating" in one.reason for one in unrated.not_judged)


def test_each_disc_is_cut_by_a_tool_like_its_roller() -> None:
    model = model_of("pair, slide", return_roller=SMALL, cutter={"kind": "roller"})
    assert [tool.radius for tool in model.machining.tools] == [10.0, 13.0]


def test_impacts_press_either_roller_by_its_own_size() -> None:
    both = {"clearance": 0.02, "turns": 2}
    mixed, same, other = (
        model_of("pair, slide", **FAST, impact=both, **keys)
        for keys in ({"return_roller": SMALL}, {}, {"roller": SMALL})
    )
    problem, *alone = (impact_problem(one.profile, one.mechanism, one.load) for one in (mixed, same, other))
    assert problem.laws == (alone[0].law, alone[1].law)
    assert problem.patches == (alone[0].patch, alone[1].patch)
    assert alone[0].back is None
    assert mixed.impact.energy.relative_residual < 1e-6


def test_a_second_roller_belongs_to_a_pair() -> None:
    for case, word in (("disc, roller", "only a conjugate pair"), ("drum, groove", "only a conjugate pair")):
        with pytest.raises(ProfileError, match=word):
            model_of(case, return_roller=SMALL)
    with pytest.raises(ProfileError, match=r"return_roller\.shape.*cylinder, cone or crowned"):
        model_of("pair, slide", return_roller={"shape": "sphere", "diameter": 20.0})
    with pytest.raises(ProfileError, match=r"return_roller\.flank.*straight"):
        model_of("pair, slide", return_roller={**SMALL, "shape": "crowned", "crown_radius": 300.0,
                                               "flank": "conforming"})  # fmt: skip
    with pytest.raises(ProfileError, match=r"impact\.roller_inertia: is that of both rollers"):
        model_of("pair, impact", return_roller=SMALL)
    crowned = model_of("pair, slide", return_roller={**SMALL, "shape": "crowned", "crown_radius": 300.0})
    assert crowned.mechanism.crown == "straight"
    assert crowned.duties[0].crown is None
    assert crowned.duties[1].crown == 300.0


def test_the_starter_without_a_second_roller_is_what_it_was() -> None:
    data = tomllib.loads(starter("conjugate"))
    data["return_roller"] = dict(data["roller"])
    same, plain = (built(one) for one in (data, tomllib.loads(starter("conjugate"))))
    assert same.mechanism.angle_between == plain.mechanism.angle_between
    assert same.duty.peak_pressure == plain.duty.peak_pressure
