"""The comparison of a result with its expected numbers passes what holds and fails what does not."""

from __future__ import annotations

import importlib.util
import json
import sys
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from camgeom.checks.verdict import Finding
from camgeom.model import Model
from camgeom.profile import read
from camgeom.report.delivery import finite
from camgeom.report.figures import VERSION
from camgeom.report.result import compute
from tests.places import PROFILES, ROOT

_SCRIPT = ROOT / "scripts" / "check_profiles.py"
_SPEC = importlib.util.spec_from_file_location("check_profiles", _SCRIPT)
assert _SPEC is not None
assert _SPEC.loader is not None
check_profiles = importlib.util.module_from_spec(_SPEC)
sys.modules["check_profiles"] = check_profiles
_SPEC.loader.exec_module(check_profiles)

RESULT = {
    "solid": {"volume_mm3": 1000.0, "watertight": True, "genus": 1},
    "checks": [{"check": "undercut", "value": 0.5}, {"check": "gap", "value": float("nan")}],
    "name": "cam",
}


@pytest.mark.parametrize(
    ("path", "want", "holds"),
    [
        ("solid.volume_mm3", {"value": 1001.0, "rel": 1e-3}, True),
        ("solid.volume_mm3", {"value": 1003.0, "rel": 1e-3}, False),
        ("solid.volume_mm3", {"value": 1000.5, "abs": 1.0}, True),
        ("solid.volume_mm3", {"value": 1002.0, "abs": 1.0}, False),
        ("solid.volume_mm3", {"min": 999.0, "max": 1001.0}, True),
        ("solid.volume_mm3", {"max": 999.0}, False),
        ("solid.volume_mm3", {"min": 1001.0}, False),
        ("solid.volume_mm3", {"value": 1000.0}, True),
        ("solid.volume_mm3", {"value": 1000.1}, False),
        ("solid.volume_mm3", {}, False),
        ("solid.volume_mm3", {"value": 1000.0, "relative": 1.0}, False),
        ("solid.watertight", {"value": True}, True),
        ("solid.watertight", {"value": False}, False),
        ("solid.watertight", {"value": 1}, False),
        ("solid.genus", {"value": 1}, True),
        ("solid.genus", {"value": True}, False),
        ("checks.undercut.value", {"value": 0.5, "rel": 1e-9}, True),
        ("checks.0.value", {"value": 0.5, "rel": 1e-9}, True),
        ("checks.gap.value", {"min": -1.0}, False),
        ("checks.7.value", {"value": 0.5}, False),
        ("name", {"value": "cam"}, True),
        ("name", {"value": "Cam"}, False),
        ("absent.value", {"value": 1.0, "rel": 1.0}, False),
    ],
)
def test_an_expectation_holds_or_fails(path: str, want: dict[str, Any], holds: bool) -> None:
    (line,) = check_profiles.compare("p", RESULT, {path: want})
    assert (line.problem == "") == holds


def test_a_profile_without_expected_numbers_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(check_profiles, "ROOT", tmp_path)
    (tmp_path / "profiles" / "expected").mkdir(parents=True)
    profile = tmp_path / "profiles" / "new.toml"
    assert check_profiles.check(profile)[0].problem.endswith("new.json is missing")
    (tmp_path / "profiles" / "expected" / "new.json").write_text("{}")
    assert check_profiles.check(profile)[0].problem.endswith("expects nothing")


@pytest.fixture(scope="module")
def result() -> dict[str, Any]:
    """A result with sections of every sort: figures, lists of tables, a reason in the place of a section."""
    model = Model(read(PROFILES / "tool_changer.toml"))
    found = compute(model, ("motion", "blank", "flank", "contact", "fatigue", "dynamics"), None)
    finding = Finding("wall", "pass", 2.0, ">=", 1.0, "mm", where="rim").as_dict()
    data = {**found.data, "verdict": "pass", "checks": [finding], "not_judged": [], "files": []}
    data |= {"products": found.products.as_dict(), "cost_s": {"flanks": 0.1}, "solid": {"failed": "no room"}}
    return dict(json.loads(json.dumps(finite(data), allow_nan=False)))


def test_a_result_is_as_its_schema_says(result: dict[str, Any]) -> None:
    assert [line.problem for line in check_profiles.described("p", result)] == []
    assert result["schema"] == VERSION


@pytest.mark.parametrize(
    ("path", "value", "problem"),
    [
        ("schema", 2, "result.schema is 2, not 1"),
        ("colour", "red", "result.colour is not described"),
        ("verdict", "good", "result.verdict is 'good'"),
        ("contact.peak_pressure_mpa", "high", "result.contact.peak_pressure_mpa is 'high'"),
        ("contact.another_force_n", True, "result.contact.another_force_n is True"),
        ("checks.0.limit", "1", "result.checks[0].limit is '1'"),
        ("checks.0.limt", 1.0, "result.checks[0].limt is not described"),
        ("products.motion.status", "lost", "result.products.motion.status is 'lost'"),
    ],
)
def test_what_a_schema_does_not_say_is_told(result: dict[str, Any], path: str, value: object, problem: str) -> None:
    changed = deepcopy(result)
    here: Any = changed
    *parents, last = path.split(".")
    for part in parents:
        here = here[int(part) if part.isdigit() else part]
    here[last] = value
    assert any(problem in line.problem for line in check_profiles.described("p", changed))


def test_a_new_figure_is_no_new_version(result: dict[str, Any]) -> None:
    more = {**result, "contact": {**result["contact"], "another_force_n": 1.0, "another_word": "x"}}
    assert check_profiles.described("p", more) == []
