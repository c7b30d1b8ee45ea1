"""Where a roller's wall ends: secants against functions whose roots are known, however they are bent."""

from __future__ import annotations

import numpy as np
import pytest

from camgeom.track.runout import _crossed, changes

RNG = np.random.default_rng(1)
ROOT, BEND = RNG.uniform(0.0, 1.0, 500), RNG.uniform(-3.0, 3.0, 500)
SHAPES = {
    "smooth": lambda x: (ROOT - x) * (1.0 + BEND**2 * x) * np.exp(BEND * x),
    "kink": lambda x: np.minimum(3.0 * (ROOT - x), 0.1 * (ROOT - x)),
    "jump": lambda x: np.where(x < ROOT, 1.0, -1e-3),
    "steep": lambda x: np.arctan(1e4 * (ROOT - x)),
    "root": lambda x: np.sign(ROOT - x) * np.sqrt(np.abs(ROOT - x)),
    "rises first": lambda x: (ROOT - x) * (x + 0.1) ** 3,
}


@pytest.mark.parametrize("shape", SHAPES)
def test_where_a_function_falls_through_zero(shape: str) -> None:
    f = SHAPES[shape]
    asked = []

    def counted(x: np.ndarray) -> np.ndarray:
        asked.append(x)
        return f(x)

    found = _crossed(counted, f(np.zeros(500)), f(np.ones(500)))
    assert np.abs(found - ROOT).max() < (1e-9 if shape == "jump" else 1e-13)
    assert len(asked) <= 80


def test_a_sign_that_changes_both_ways() -> None:
    phi = np.linspace(0.0, 7.0, 50)
    found = changes(lambda x: np.cos(x) - 0.25, phi, np.cos(phi) - 0.25)
    a = np.arccos(0.25)
    assert found == pytest.approx([a, 2.0 * np.pi - a, 2.0 * np.pi + a][: len(found)], abs=1e-13)
    assert len(found) == 2
    assert not len(changes(np.cos, phi[:5], np.cos(phi[:5])))
