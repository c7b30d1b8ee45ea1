"""Globoids filled by fTetWild, where it is installed (scripts/test_extras): volume, faces, load and CalculiX."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("pytetwild", reason="pip install 'camgeom[tetra]'")

from camgeom.body.tetra import TetraVolume
from camgeom.model import Model
from camgeom.profile import from_data, read_data
from scripts.judge_body import displacements, program
from tests.places import PROFILES


@pytest.fixture(scope="module")
def model() -> Model:
    data = read_data(PROFILES / "tool_changer.toml")
    return Model(from_data({**data, "cam": {**data["cam"], "root_radius": 1.0}}))


def test_the_body_is_filled_out_to_its_faces(model: Model) -> None:
    volume = model.volume
    assert isinstance(volume, TetraVolume)
    x = volume.nodes[volume.elements[:, :4]]
    filled = float(np.einsum("ei,ei->", np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), x[:, 3] - x[:, 0])) / 6.0
    assert filled == pytest.approx(model.solid.mesh.volume, rel=0.01)  # straight edges
    assert {"bore", "flank", "root", "floor", "land", "end", "patch"} <= set(volume.sets)
    rho = np.hypot(*volume.nodes[volume.sets["bore"], :2].T)
    bore = 0.5 * read_data(PROFILES / "tool_changer.toml")["cam"]["bore"]
    assert np.median(np.abs(rho - bore)) < model.tolerance
    assert volume.mesh.left_off < 0.5
    assert np.allclose(volume.forces.sum(axis=0), volume.load.forces.sum(axis=0))


@pytest.mark.skipif(program() is None, reason="no CalculiX: python scripts/judge_body.py --install")
def test_calculix_runs_the_file_without_a_word(model: Model) -> None:
    moved, words = displacements(model.volume)
    assert not words
    assert 1.0e-3 < float(np.abs(moved).max()) < 1.6e-3
