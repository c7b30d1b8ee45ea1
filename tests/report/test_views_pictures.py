"""The stills of a design show the follower, the section and the results."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from camgeom.errors import ExportError
from camgeom.model import read
from camgeom.report import painter
from camgeom.report.pictures import write_pictures
from tests.places import PROFILES

PROFILE = PROFILES / "pin_insertion.toml"


@pytest.mark.opengl
@pytest.mark.slow
def test_the_stills_of_the_pin_insertion_cam(tmp_path: Path) -> None:
    paths = write_pictures(read(str(PROFILE)), tmp_path, "pin", size=(400, 300))
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(path.name for path in paths)
    pictures = {path.stem: np.asarray(Image.open(path)).reshape(-1, 3).astype(int) for path in paths}
    shown = ("cam", "mechanism", "section", "pressure", "pressure-angle", "curvature")
    assert set(pictures) == {f"pin-{what}" for what in shown}
    orange = {name: np.mean((p[:, 0] > 1.4 * p[:, 1]) & (p[:, 1] > 1.4 * p[:, 2])) for name, p in pictures.items()}
    assert orange["pin-mechanism"] > 0.001
    assert orange["pin-section"] > 0.001
    sand = {name: np.mean((p[:, 0] > 200) & (p[:, 2] < 180) & (p[:, 2] > 130)) for name, p in pictures.items()}
    assert sand["pin-section"] > 0.05 > 0.02 > sand["pin-mechanism"]
    yellow = {name: np.mean((p[:, 0] > 170) & (p[:, 1] > 160) & (p[:, 2] < 110)) for name, p in pictures.items()}
    assert yellow["pin-pressure"] > 0.001 > yellow["pin-mechanism"]
    assert yellow["pin-pressure-angle"] > 0.001


def test_without_opengl_nothing_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(painter, "_started", lambda process: None)
    with pytest.raises(ExportError, match="libegl1"):
        write_pictures(read(str(PROFILE)), tmp_path, "pin", size=(400, 300))
    assert not list(tmp_path.iterdir())
