"""The comparison of a result with its expected numbers passes what holds and fails what does not."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.places import ROOT

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
