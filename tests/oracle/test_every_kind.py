"""Every kind of cam has an oracle, and the body of its starter lies where that says."""

from __future__ import annotations

import sys
import tomllib

import pytest

from camgeom.cams import kinds, starter
from tests.oracle.cams import JUDGES
from tests.places import ROOT

sys.path.insert(0, str(ROOT / "scripts" / "stability"))

from judging import judge


@pytest.mark.parametrize("kind", kinds())
def test_the_starter_of_every_kind_is_judged_by_its_oracle(kind: str) -> None:
    assert kind in JUDGES, f"no oracle for {kind}: place its follower from the keys in tests/oracle/cams.py"
    record = judge(tomllib.loads(starter(kind)))
    assert record["outcome"] == "good", record
    assert 0.3 < record["error"] <= 1.0 + 1e-6
