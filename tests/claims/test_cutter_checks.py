"""What the [cutter] tool does to the flanks is judged: gouges, stock that stays, tools that do not go in."""

from __future__ import annotations

from math import atan, cos

import pytest

from camgeom.checks import judge
from camgeom.checks.verdict import Finding, NotJudged
from camgeom.model import Model
from tests.places import PROFILES
from tests.reference.milled_cams import DRUM, GLOBOID, model


def one(made: Model, name: str) -> Finding:
    (found,) = judge(made, (name,)).findings
    return found


def test_a_shipped_tool_passes_and_no_tool_is_not_asked() -> None:
    from camgeom.profile import read

    milled = Model(read(PROFILES / "milled_drum.toml"))
    assert {one(milled, name).level for name in ("gouge", "stock-left")} == {"pass"}
    assert not judge(Model(read(PROFILES / "pin_insertion.toml")), ("gouge", "stock-left")).findings


def test_one_pass_along_the_rollers_path_leaves_half_of_what_the_tool_is_smaller() -> None:
    found = one(model(DRUM, kind="flat", diameter=16, path="centre"), "stock-left")
    assert found.level == "fail"
    assert found.value == pytest.approx(2.0, abs=1e-6)
    assert one(model(DRUM, kind="flat", diameter=19.992, path="centre"), "stock-left").level == "pass"
    assert one(model(DRUM, kind="flat", diameter=19.988, path="centre"), "stock-left").level == "fail"


def test_a_path_shifted_along_the_motion_is_too_narrow_on_the_slope() -> None:
    """On a slope a the wall stands proud by the difference of the radii times 1 - cos a, most at the groove's floor."""
    steepest = 2.0 * 30.0 / (110.0 / 57.29577951308232)
    slope = atan(steepest / 40.0)
    found = one(model(DRUM, kind="flat", diameter=16, path="shifted"), "stock-left")
    assert found.value == pytest.approx(2.0 * (1.0 - cos(slope)), rel=5e-3)
    assert found.level == "fail"


@pytest.mark.parametrize(("share", "level"), [(1.002, "pass"), (0.998, "fail")])
def test_a_gouge_is_judged_by_its_own_limit(share: float, level: str) -> None:
    deepest = one(model(GLOBOID, kind="flat", diameter=20, axis="fitted", gouge_limit=0.0), "gouge").value
    assert deepest is not None
    assert deepest > 1e-6
    tool = model(GLOBOID, kind="flat", diameter=20, axis="fitted", gouge_limit=share * deepest)
    assert one(tool, "gouge").level == level


def test_a_tool_that_is_too_short_fails() -> None:
    found = one(model(DRUM, kind="flat", diameter=16, length=3), "gouge")
    assert found.level == "fail"
    assert "cutter.length" in found.advice
    both = judge(model(DRUM, kind="flat", diameter=16, length=3), ("gouge", "stock-left"))
    assert [word.check for word in both.findings] == ["gouge"]
    assert not both.not_judged
    assert one(model(DRUM, kind="flat", diameter=16, length=12), "gouge").level == "pass"


def test_an_allowance_is_told() -> None:
    verdict = judge(model(DRUM, kind="flat", diameter=16, allowance=0.5), ("stock-left",))
    assert [word.check for word in verdict.not_judged if isinstance(word, NotJudged)] == ["allowance"]
    assert [word.level for word in verdict.findings] == ["pass"]
