"""What the contract promises to users of the library: the names, and that facts are computed when asked, once."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

import camgeom
from tests.places import PROFILES


def test_the_promised_names(tmp_path: Path) -> None:
    model = camgeom.read(str(PROFILES / "pin_insertion.toml"))
    assert not set(model.ledger.costs)
    assert float(model.contact.peak().pressure) == pytest.approx(1004.677, abs=5e-4)
    assert float(model.life.life_h) == pytest.approx(45346.97, abs=5e-3)
    assert "solids" not in model.ledger.costs
    assert model.solid.sound
    assert model.solid is model.solid
    assert model.flanks[0].margin.value > 0.0
    assert all(finding.passed for finding in camgeom.check(model))
    camgeom.write(model, tmp_path / "cam.3mf")
    assert (tmp_path / "cam.3mf").stat().st_size > 10_000
    assert len(list(camgeom.LAWS)) >= 20


def test_contact_and_life_of_a_turret_and_of_a_face() -> None:
    turret = camgeom.read(str(PROFILES / "conical_indexer.toml"))
    assert turret.contact is turret.turret_duty
    assert turret.life.roller_life > 0.0
    face = camgeom.read(str(PROFILES / "disc_flat_face.toml"))
    assert face.contact is face.drive
    with pytest.raises(camgeom.DesignError, match="without a roller"):
        _ = face.life


def test_import_costs_no_library() -> None:
    code = "import sys, json, camgeom; print(json.dumps(sorted(sys.modules.keys() & {'numpy', 'scipy', 'pydantic'})))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=PROFILES.parent)
    assert json.loads(done.stdout) == []
