"""The batch against the exact model: figures by the same names, the same reasons, nothing that is not a number."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

from camgeom.cli.study import STUDIED, measure
from camgeom.design import light_checks
from camgeom.design.batch import evaluate, offered, supports
from camgeom.design.study import Study, axis
from camgeom.maths import Floats
from camgeom.profile import from_data, read_data

WITHIN = 1e-3
Data = dict[str, Any]


def exact_row(data: Data, values: Mapping[str, float]) -> tuple[dict[str, Any], str]:
    """Figures of the exact study of one variant, and its reason."""
    axes = tuple(axis(f"{key}={value!r}") for key, value in values.items())
    study = Study(data, "", axes, lambda model: measure(model, STUDIED, light_checks()))
    row, _ = study.row(tuple(one.values[0] for one in axes))
    return row.figures, row.reason


def compare(data: Data, columns: Mapping[str, Floats]) -> dict[str, float]:
    """The largest relative error of every figure over the variants; the reasons have to be the exact model's."""
    batch = evaluate(from_data(data), columns)
    worst: dict[str, float] = {}
    for i, word in enumerate(batch.words):
        figures, reason = exact_row(data, {key: float(values[i]) for key, values in columns.items()})
        if word:
            assert word in reason, (i, word, reason)
            continue
        assert figures, (i, reason)
        assert "undercut" not in reason
        for name, values in batch.figures.items():
            told, found = figures[name], float(values[i])
            assert not np.isnan(found)
            if told is None:
                assert np.isinf(found), (i, name, found)
                continue
            error = abs(found - told) / abs(told) if told else abs(found)
            worst[name] = max(worst.get(name, 0.0), error)
    return worst


def disc() -> Data:
    data = read_data("profiles/disc_offset_roller.toml")
    data["roller"] = {"shape": "cylinder", "diameter": 22.0, "length": 12.0}
    del data["operation"]["force"]
    return data


def disc_columns(rng: np.random.Generator, n: int) -> dict[str, Floats]:
    return {
        "cam.base_radius": rng.uniform(20.0, 60.0, n),
        "roller.diameter": rng.uniform(10.0, 40.0, n),
        "follower.offset": rng.uniform(-15.0, 15.0, n),
        "operation.speed": rng.uniform(100.0, 600.0, n),
        "motion[0].until": rng.uniform(60.0, 140.0, n),
        "motion[0].to": rng.uniform(10.0, 25.0, n),
        "motion[2].to": np.zeros(n),
    }


def drum() -> Data:
    """The published groove cam."""
    return read_data("profiles/pin_insertion.toml")


def drum_columns(rng: np.random.Generator, n: int) -> dict[str, Floats]:
    return {
        "cam.diameter": rng.uniform(134.0, 160.0, n),
        "cam.running_clearance": rng.uniform(0.0, 0.03, n),
        "roller.diameter": rng.uniform(12.0, 30.0, n),
        "roller.length": rng.uniform(6.0, 13.5, n),
        "motion[1].to": rng.uniform(25.0, 50.0, n),
        "operation.speed": rng.uniform(200.0, 900.0, n),
        "operation.friction": rng.uniform(0.0, 40.0, n),
    }


def guided() -> Data:
    """A drum whose slide has friction in its guides and a spring."""
    data = read_data("profiles/milled_drum.toml")
    del data["cutter"]
    data["operation"]["spring_preload"] = 20.0
    return data


def guided_columns(rng: np.random.Generator, n: int) -> dict[str, Floats]:
    return {
        "cam.diameter": rng.uniform(60.0, 130.0, n),
        "cam.groove_depth": rng.uniform(9.5, 14.0, n),
        "roller.diameter": rng.uniform(14.0, 24.0, n),
        "motion[1].until": rng.uniform(150.0, 230.0, n),
        "operation.guide_friction": rng.uniform(0.0, 0.9, n),
        "operation.spring_rate": rng.uniform(0.0, 3.0, n),
        "operation.gravity": rng.uniform(-9.8, 9.8, n),
        "material.cam.elastic_modulus": rng.uniform(1e5, 2.2e5, n),
    }


CASES: dict[str, tuple[Callable[[], Data], Callable[[np.random.Generator, int], dict[str, Floats]]]] = {
    "disc": (disc, disc_columns),
    "drum": (drum, drum_columns),
    "guided drum": (guided, guided_columns),
}


@pytest.mark.parametrize("case", CASES)
def test_every_figure_is_the_exact_models(case: str) -> None:
    data, columns = CASES[case][0](), CASES[case][1](np.random.default_rng(1), 30)
    assert supports(from_data(data), list(columns)) is None
    worst = compare(data, columns)
    assert set(worst) == set(offered(from_data(data)))
    assert max(worst.values()) < WITHIN, {name: error for name, error in worst.items() if error >= WITHIN}


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
