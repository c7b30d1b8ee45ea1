"""What the [cutter] tool does to the flanks is judged: gouges, stock that stays, tools that do not go in."""

from __future__ import annotations

from math import atan, cos

import pytest

from camgeom.checks import judge
from camgeom.checks.verdict import Finding, NotJudged
from camgeom.errors import DesignError
from camgeom.machining.plan import Machining, Space
from camgeom.model import Model
from tests.places import PROFILES
from tests.reference.milled_cams import DRUM, GLOBOID, model


def one(made: Model, name: str) -> Finding:
    (found,) = judge(made, (name,)).findings
    return found


def chord_cut(machining: Machining) -> float:
    """How deep the chords of the cutter data and of the G-code cut, mm."""
    spaces: tuple[Space, ...] = ("cam", "machine")
    return max(machining.sag(path, space).cut for path in machining.paths for space in spaces)


def test_a_shipped_tool_passes_and_no_tool_is_not_asked() -> None:
    from camgeom.profile import read

    milled = Model(read(PROFILES / "milled_drum.toml"))
    assert {one(milled, name).level for name in ("gouge", "stock-left")} == {"pass"}
    assert not judge(Model(read(PROFILES / "pin_insertion.toml")), ("gouge", "stock-left")).findings


def test_one_pass_along_the_rollers_path_leaves_half_of_what_the_tool_is_smaller() -> None:
    found = one(model(DRUM, kind="flat", diameter=16, path="centre"), "stock-left")
    assert found.level == "fail"
    assert found.value == pytest.approx(2.0, abs=1e-3)
    assert 2.0 < found.value < 2.0005  # chords of at most 0.0005 mm
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
    outcome = model(GLOBOID, kind="flat", diameter=20, axis="fitted").machined
    assert outcome.least is not None
    deepest = chord_cut(outcome.machining) - outcome.least.value
    assert deepest > 1e-6
    tool = model(GLOBOID, kind="flat", diameter=20, axis="fitted", gouge_limit=share * deepest)
    assert one(tool, "gouge").level == level


@pytest.mark.parametrize("text", [DRUM, GLOBOID])
@pytest.mark.parametrize(("share", "level"), [(1.002, "pass"), (0.999, "fail")])
def test_chords_along_a_track_are_judged_as_they_cut(text: str, share: float, level: str) -> None:
    """A tool like the roller passed with 0 whatever its path's chords cut into the walls."""
    deepest = chord_cut(model(text, kind="roller", tolerance=0.1).machined.machining)
    assert 0.05 < deepest <= 0.1
    made = model(text, kind="roller", tolerance=0.1, gouge_limit=share * deepest)
    found = one(made, "gouge")
    assert (found.level, found.advice) == (level, "" if level == "pass" else "use a smaller cutter.tolerance")
    if level == "fail":
        with pytest.raises(DesignError, match=r"into the flank .* use a smaller cutter\.tolerance"):
            made.machining  # noqa: B018


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
