"""The audit's commands: each is one that can be typed as it stands."""

from __future__ import annotations

import shlex

import pytest

from camgeom.cli import main
from tests.places import ROOT

ROWS = [line.split("\t") for line in (ROOT / "docs" / "sources.tsv").read_text(encoding="utf-8").splitlines()[1:]]


@pytest.mark.parametrize("command", sorted({row[3] for row in ROWS if "design" in row[3].split()[1:2]}))
def test_a_design_that_is_named_is_whole(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(shlex.split(command)[1:]) == 0
    assert "(equation 9)" in capsys.readouterr().err
