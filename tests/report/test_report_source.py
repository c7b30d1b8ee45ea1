"""The source that a profile is the machine of: named by a key, recomputed in its report."""

from __future__ import annotations

import pytest

import camgeom
from camgeom.drawing.content import Table, Text
from camgeom.errors import ProfileError
from camgeom.report.result import compute
from camgeom.report.sections.record import source
from camgeom.validation import SOURCES
from tests.places import PROFILES

MACHINES = {"S1": "pin_insertion", "S2": "constant_width_press", "S3": "tool_changer", "S4": "globoidal_drive",
            "S5": "conjugate_rocker"}  # fmt: skip
PIN = (PROFILES / "pin_insertion.toml").read_text(encoding="utf-8")


def test_every_source_has_its_machine() -> None:
    assert set(MACHINES) == {one.short for one in SOURCES}
    for short, name in MACHINES.items():
        assert camgeom.read(PROFILES / f"{name}.toml").profile.reproduces == short


def test_its_report_has_the_printed_results_beside_ours() -> None:
    told, results, reasons = source(camgeom.read(PIN))
    assert isinstance(told, Text)
    assert "camgeom validate S1 --out DIR" in told.paragraphs[0]
    assert isinstance(results, Table)
    rows = {row[0]: row for row in results.rows}
    assert rows["peak-pressure"][2:4] == ("1168", "1004.677")
    assert rows["peak-pressure"][-1] == "not reproducible"
    assert isinstance(reasons, Table)


def test_a_profile_that_names_none_has_none() -> None:
    plain = camgeom.read(PIN.replace('reproduces = "S1"\n', ""))
    assert source(plain) == ()
    assert "reproduces" not in compute(plain, ("motion",)).data
    assert compute(camgeom.read(PIN), ("motion",)).data["reproduces"] == "S1"


def test_an_unknown_source_is_refused() -> None:
    with pytest.raises(ProfileError, match="S1, S2, S3, S4, S5"):
        camgeom.read(PIN.replace('"S1"', '"S6"'))
