"""CalculiX runs the files as they are written and finds the same displacements; skipped where there is none."""

from __future__ import annotations

import numpy as np
import pytest

from camgeom.body.solver import elastic
from camgeom.body.volume import BodyVolume
from camgeom.model import Model
from camgeom.profile import from_data, read_data
from scripts.judge_body import displacements, judged, program
from tests.places import PROFILES


@pytest.mark.slow
@pytest.mark.skipif(program() is None, reason="no CalculiX: python scripts/judge_body.py --install")
@pytest.mark.parametrize("name", ["disc_offset_roller", "constant_width_press", "end_face_lifter", "parallel_index",
                                  "two_groove_drum", "both_faces_disc"])  # fmt: skip
def test_displacements_are_those_of_calculix(name: str) -> None:
    volume = Model(from_data(read_data(PROFILES / f"{name}.toml"))).volume
    assert isinstance(volume, BodyVolume)
    theirs, words = displacements(volume)
    material = volume.material
    own = elastic(volume.ring, material).solve(volume.forces[:, :, None])
    assert not words
    assert np.abs(theirs - own[:, :, 0]).max() < 1e-5 * np.abs(own).max()


@pytest.mark.slow
@pytest.mark.skipif(program() is None, reason="no CalculiX: python scripts/judge_body.py --install")
def test_the_frame_moves_as_in_calculix(capsys: pytest.CaptureFixture[str]) -> None:
    volume = Model(from_data(read_data(PROFILES / "constant_width_press.toml"))).frame_volume
    assert not judged("frame", volume)
    assert "CalculiX differs by" in capsys.readouterr().out
