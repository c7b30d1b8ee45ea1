"""The batch against the exact model: figures by the same names, the same reasons, nothing that is not a number."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from camgeom.design.batch import evaluate, supports
from camgeom.profile import from_data, read_data
from scripts.batch_campaign import CASES, case

Data = dict[str, Any]


def disc() -> Data:
    data = read_data("profiles/disc_offset_roller.toml")
    data["cam"] = {"kind": "disc", "base_radius": 34.0, "width": 14.0}
    data["roller"] = {"shape": "cylinder", "diameter": 22.0, "length": 12.0}
    del data["operation"]["force"]
    return data


@pytest.mark.parametrize("name", CASES)
def test_every_figure_is_the_exact_models(name: str) -> None:
    found = case(name, 12, 7)
    assert not found.wrong
    assert found.exist >= 5


def test_what_cannot_exist_has_a_reason_and_no_figures() -> None:
    columns = {
        "cam.base_radius": np.array([34.0, 3.0, 5.0, -1.0]),
        "roller.diameter": np.array([22.0, 4.0, 90.0, 22.0]),
        "motion[0].until": np.array([110.0, 110.0, 70.0, 110.0]),
    }
    batch = evaluate(from_data(disc()), columns)
    assert batch.words == ["", "follower.offset: cannot be built", "undercut", "cam.base_radius: out of range"]
    assert all((values[1:] == 0.0).all() and values[0] >= 0.0 for values in batch.figures.values())


def test_keys_that_no_array_carries_are_told() -> None:
    profile = from_data(disc())
    for key, word in (
        ("cam.direction", "no number"), ("dynamics.mass", "solver"), ("cam.diameter", "means nothing"),
        ("motion[1].to", "dwells"),
    ):  # fmt: skip
        assert word in str(supports(profile, [key]))


def test_nobody_pays_who_does_not_ask() -> None:
    code = "import sys, camgeom.cli, camgeom.design.study; assert not [m for m in sys.modules if 'batch' in m]"
    subprocess.run([sys.executable, "-c", code], check=True)
