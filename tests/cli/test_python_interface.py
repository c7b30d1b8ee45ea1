"""What the contract promises to users of the library: the names, and that facts are computed when asked, once."""

from __future__ import annotations

import io
import json
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
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


PIN = PROFILES / "pin_insertion.toml"
DISC = PROFILES / "disc_offset_roller.toml"


def test_a_profile_comes_from_a_path_a_text_data_or_an_open_file() -> None:
    text = DISC.read_text(encoding="utf-8")
    digest = camgeom.read(DISC).profile.digest()
    with DISC.open("rb") as binary, DISC.open(encoding="utf-8") as plain:
        for source in (str(DISC), text, tomllib.loads(text), io.StringIO(text), binary, plain):
            assert camgeom.read(source).profile.digest() == digest
    assert camgeom.read(camgeom.read(DISC).toml()).profile.digest() == digest
    with pytest.raises(camgeom.ProfileError, match="there is no such file"):
        camgeom.read("nowhere.toml")
    with pytest.raises(TypeError, match="not a int"):
        camgeom.read(3)  # type: ignore[arg-type]
    with pytest.raises(camgeom.ProfileError, match="cam: a key must be a text"):
        camgeom.read({"cam": {3: 4}})


def test_arrays_of_numpy_may_stand_in_data_and_what_is_not_finite_may_not() -> None:
    data = tomllib.loads(DISC.read_text(encoding="utf-8"))
    data["cam"]["base_radius"] = np.float64(data["cam"]["base_radius"])
    data["motion"][0]["until"] = np.int64(data["motion"][0]["until"])
    assert camgeom.read(data).profile == camgeom.read(DISC).profile.model_copy(update={"source": ""})
    data["cam"]["base_radius"] = np.nan
    with pytest.raises(camgeom.ProfileError, match=r"cam.base_radius: must be a finite number"):
        camgeom.read(data)


def test_with_makes_another_model_judged_like_a_file() -> None:
    model = camgeom.read(PIN)
    wider = model.with_(cam__diameter=150, operation__speed=300)
    assert (wider.profile.cam.diameter, wider.profile.operation.speed) == (150.0, 300.0)
    assert model.profile.cam.diameter == 134.0
    higher = model.with_({"motion[1].to": 38})
    assert higher.motion(np.radians(215.0)).s == pytest.approx([38.0])
    assert model.motion(np.radians(215.0)).s == pytest.approx([37.0])
    assert model.with_({"limits.life_h": None}).profile.limits.life_h is None
    with pytest.raises(camgeom.ProfileError, match=r"cam.diametr: unknown key .* did you mean 'diameter'"):
        model.with_(cam__diametr=150)
    with pytest.raises(camgeom.ProfileError, match=r"motion\[9\].to: no such entry"):
        model.with_({"motion[9].to": 1})
    with pytest.raises(camgeom.ProfileError, match="is no dotted key"):
        model.with_({"cam diameter": 1})


def test_curves_as_arrays() -> None:
    model = camgeom.read(DISC)
    theta = np.linspace(0.0, 6.0, 25)
    motion = model.motion(theta)
    assert motion.s == pytest.approx(model.setup.program.jet(theta, 0)[0])
    assert not motion.v.flags.writeable
    apart = np.hypot(*(model.pitch_curve(theta)[:, :2] - model.outline(theta)).T)
    assert apart == pytest.approx(0.5 * model.profile.roller.diameter, abs=1e-9)
    flank = model.flank(theta=theta, stations=3)
    assert flank.points.shape == (25, 3, 3)
    assert flank.points[:, 1, :2] == pytest.approx(model.outline(theta), abs=1e-9)
    with pytest.raises(camgeom.DesignError, match="no flank on the side"):
        model.flank(3.0)
    with pytest.raises(camgeom.DesignError, match="no plane curve"):
        camgeom.read(PIN).outline()
    with pytest.raises(camgeom.DesignError, match="without a roller"):
        camgeom.read(PROFILES / "disc_flat_face.toml").pitch_curve()


def test_a_model_shows_itself_with_its_verdict() -> None:
    model = camgeom.read(DISC)
    assert repr(model).endswith("disc cam, translating follower, not judged yet>")
    html = model._repr_html_()
    assert html is not None
    assert "svg" in html
    assert "verdict" in html
    assert "PASS" in repr(model)


def test_plot_draws_on_axes() -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    axes = camgeom.read(DISC).plot()
    assert [len(axis.lines) for axis in axes] == [1, 1, 1, 1]
    camgeom.read(PROFILES / "disc_flat_face.toml").plot(axes)
    assert [len(axis.lines) for axis in axes] == [2, 2, 2, 2]
    from matplotlib import pyplot

    pyplot.close("all")


def test_files_in_memory(tmp_path: Path) -> None:
    model = camgeom.read(DISC)
    camgeom.write(model, tmp_path / "cam.stl")
    assert camgeom.encode(model, "stl") == (tmp_path / "cam.stl").read_bytes()
    assert camgeom.encode(model, "step").startswith(b"ISO-10303-21")
    with pytest.raises(camgeom.ExportError, match=r"no writer for \.setp"):
        camgeom.encode(model, "setp")


def test_a_study_gives_columns() -> None:
    model = camgeom.read(PIN)
    found = camgeom.study(model, {"operation.speed": [300, 600], "cam.diameter": [100.0, 134.0]}, only=["contact"])
    assert found["operation.speed"].tolist() == [300, 300, 600, 600]
    assert found.passed.tolist() == [False, True, False, True]
    assert found["contact.peak_pressure_mpa"][3] == pytest.approx(1004.677, abs=5e-4)
    assert found["contact.peak_pressure_mpa"][0] is None
    assert not found["cam.diameter"].flags.writeable
    tied = camgeom.study(model, {"cam.diameter": [134]}, tie={"cam.pitch_radius": "0.5*cam.diameter"}, only=["flank"])
    assert tied["cam.pitch_radius"].tolist() == [67.0]
    with pytest.raises(camgeom.ProfileError, match="unknown key"):
        camgeom.study(model, {"cam.diametr": [1.0]})
    with pytest.raises(camgeom.ProfileError, match="needs a dotted key and its values"):
        camgeom.study(model, {"cam.diameter": []})
