"""What a report brings along: the still for browsers without WebGL, the turning mechanism, the PDF; and why not."""

from __future__ import annotations

import json
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from camgeom.cams import starter
from camgeom.cli import main
from camgeom.errors import ExportError
from camgeom.model import Model, read
from camgeom.profile import from_data
from camgeom.profile.text import load
from camgeom.report import movie, painter, pdf
from camgeom.report.files import EXTRAS
from camgeom.report.page import render
from camgeom.report.result import compute
from camgeom.report.sections import mechanism, report
from camgeom.report.sections.bodies import cam_meshes
from camgeom.report.sections.mechanism import fields
from tests.places import PROFILES


def test_a_page_without_webgl_shows_the_cam_in_place_of_the_3d_view() -> None:
    page = render(report(read(str(PROFILES / "pin_insertion.toml")), ["solid"]))
    stage = page[page.index('<div class="stage">') : page.index('<div class="controls">')]
    assert stage.count("<svg") == 1
    assert 'class="d-cut"' in stage
    assert "<canvas" not in stage


@pytest.mark.parametrize("profile", ["disc_flat_face", "constant_width_press", "conjugate_rocker"])
def test_planar_cams_are_coloured_by_what_is_known_of_their_profile(profile: str) -> None:
    model = read(str(PROFILES / f"{profile}.toml"))
    peak = model.drive.peak_pressure
    assert peak is not None
    tops = []
    for _, mesh in cam_meshes(model):
        known = fields(model, mesh)
        assert {"curvature", "pressure"} <= set(known)
        flank = np.zeros(len(mesh.vertices), dtype=bool)
        flank[mesh.faces[mesh.group_faces("flank")]] = True
        assert np.all(np.isfinite(known["pressure"][flank]))
        assert np.all(np.isnan(known["pressure"][~flank]))
        tops.append(float(np.nanmax(known["pressure"])))
    assert max(tops) == pytest.approx(peak.value, rel=0.02)


def test_a_fine_body_is_painted_piece_by_piece(monkeypatch: pytest.MonkeyPatch) -> None:
    model = read(str(PROFILES / "pin_insertion.toml"))
    body = model.parts[0].rough(0.001).mesh
    found, peaks = [], []
    for block in (mechanism.BLOCK, len(body.vertices)):
        monkeypatch.setattr(mechanism, "BLOCK", block)
        fields(model, body)  # what is kept of the model
        tracemalloc.start()
        found.append(fields(model, body)["clearance"])
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert np.array_equal(*found, equal_nan=True)
    assert peaks[0] < 0.3 * peaks[1]


def _turning(model: Model, folder: Path, monkeypatch: pytest.MonkeyPatch, *kinds: str) -> list[Path]:
    monkeypatch.setattr(movie, "FRAMES", 4)
    films = movie.Films(model, kinds, (160, 120))
    paths = [folder / f"cam-turning.{kind}" for kind in kinds]
    for kind, path in zip(kinds, paths, strict=True):
        films.write(kind, path)
    return paths


@pytest.mark.opengl
@pytest.mark.slow
def test_gif_turns_and_comes_round(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (path,) = _turning(read(str(PROFILES / "constant_width_press.toml")), tmp_path, monkeypatch, "gif")
    with Image.open(path) as film:
        assert film.n_frames == 4  # type: ignore[attr-defined]
        assert film.info["loop"] == 0
        shots = []
        for k in range(4):
            film.seek(k)
            shots.append(np.asarray(film.convert("RGB")).astype(int))
    assert shots[0].shape == (120, 160, 3)
    for one, other in zip(shots, shots[1:]):
        assert np.mean(np.abs(one - other).max(axis=2) > 40) > 0.01
    for shot in shots:  # the whole mechanism is in the picture all round
        frame = np.concatenate([shot[:2].reshape(-1, 3), shot[:, :2].reshape(-1, 3), shot[:, -2:].reshape(-1, 3)])
        assert np.all(frame > 235)


@pytest.mark.opengl
@pytest.mark.slow
@pytest.mark.parametrize(("kind", "magic"), [("mp4", b"ftyp"), ("webm", b"\x1aE\xdf\xa3")])
def test_film_where_an_encoder_is_present(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, magic: bytes
) -> None:
    try:
        movie.find_encoder(kind)
    except ExportError as error:
        pytest.skip(str(error))
    (path,) = _turning(read(str(PROFILES / "disc_flat_face.toml")), tmp_path, monkeypatch, kind)
    assert magic in path.read_bytes()[:16]
    assert [p.name for p in tmp_path.iterdir()] == [f"cam-turning.{kind}"]


def test_without_an_encoder_the_message_says_how_to_get_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(movie.shutil, "which", lambda _: None)
    monkeypatch.setattr(movie, "_bundled", lambda: None)
    with pytest.raises(ExportError, match="imageio-ffmpeg"):
        movie.find_encoder("mp4")


def test_without_a_browser_the_message_says_how_to_get_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pdf.shutil, "which", lambda _: None)
    monkeypatch.delenv(pdf.CHOICE, raising=False)
    with pytest.raises(ExportError, match="apt-get install chromium"):
        pdf.find_browser()
    monkeypatch.setenv(pdf.CHOICE, "/nowhere/browser")
    with pytest.raises(ExportError, match="/nowhere/browser"):
        pdf.find_browser()


def test_browser_that_does_not_print_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(pdf.CHOICE, "false")
    page = tmp_path / "report.html"
    page.write_text("<p>one</p>")
    with pytest.raises(ExportError, match="does not print"):
        pdf.write_pdf(page, tmp_path / "report.pdf")
    assert not (tmp_path / "report.pdf").exists()


@pytest.mark.slow
def test_page_is_printed(tmp_path: Path) -> None:
    try:
        pdf.find_browser()
    except ExportError as error:
        pytest.skip(str(error))
    page = tmp_path / "report.html"
    page.write_text("<!DOCTYPE html><title>x</title><p>one</p>")
    assert pdf.write_pdf(page, tmp_path / "report.pdf").read_bytes().startswith(b"%PDF-")


def test_what_cannot_be_made_is_said_and_the_rest_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """No OpenGL, no encoder, no browser: the report comes, the others say why, and so does the exit status."""
    monkeypatch.setattr(painter, "_started", lambda process: None)
    monkeypatch.setattr(movie.shutil, "which", lambda _: None)
    monkeypatch.setattr(movie, "_bundled", lambda: None)
    monkeypatch.setattr(pdf.shutil, "which", lambda _: None)
    profile, formats = str(PROFILES / "disc_flat_face.toml"), ",".join(EXTRAS)
    assert main(["report", profile, "--formats", formats, "--out", str(tmp_path)]) == 1
    said = [line.split(":")[1].strip() for line in capsys.readouterr().err.splitlines()]
    assert said == ["no png or gif", "no mp4 or webm", "no pdf"]
    assert {path.name for path in tmp_path.iterdir()} == {"manifest.json", "report.html", "result.json"}
    products = json.loads((tmp_path / "result.json").read_text())["products"]
    assert {products[name]["status"] for name in EXTRAS} == {"failed"}
    assert "apt-get install chromium" in products["pdf"]["reason"]
    assert main(["report", profile, "--out", str(tmp_path)]) == 0


def test_report_refuses_formats_of_bodies_and_names_its_own(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    profile = str(PROFILES / "disc_flat_face.toml")
    assert main(["report", profile, "--formats", "stl", "--out", str(tmp_path / "o")]) == 2
    assert "png, gif, mp4, webm, pdf" in capsys.readouterr().err
    assert not (tmp_path / "o").exists()


def test_of_two_rollers_the_one_whose_sharp_end_presses_has_no_life() -> None:
    """The other one's stands beside it, and the section is not lost."""
    data = load(starter("conjugate"), "pair")[0]
    data["roller"] = {"shape": "crowned", "diameter": 40.0, "length": 20.0, "crown_radius": 8000.0}
    data["operation"] = {"speed": 200.0, "force": ({"from": 0.0, "until": 360.0, "expression": "-300000"},)}
    made = Model(from_data(data))
    assert [bool(duty.no_stress) for duty in made.duties] == [False, True]
    found = compute(made, ("fatigue",)).data["fatigue"]["roller_lives_h"]
    assert found == [None if np.isinf(made.duties[0].lives["roller"]) else made.duties[0].lives["roller"], None]
