"""Cam, turret and rollers as one assembly: each roller is one product, and stands where the track puts it."""

from __future__ import annotations

import json
from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import pytest

from camgeom.cli import main
from camgeom.errors import DesignError, ExportError
from camgeom.export import write
from camgeom.export.step.bodies import assembly_of, roller_solid
from camgeom.export.step.brep import Brep
from camgeom.export.step.check import check_solid
from camgeom.export.step.file import step_text
from camgeom.model import Model, read
from camgeom.track import Arc, Slide, Straight, Track
from tests.export.step_bodies import pin_program
from tests.places import PROFILES


def model(name: str) -> Model:
    return read(str(PROFILES / f"{name}.toml"))


def track_of(meridian: Straight | Arc, tip: float = 54.0, contact: tuple[float, float] = (54.0, 66.0)) -> Track:
    joint = Slide((0.0, 0.0, 1.0))
    return Track(meridian, joint, (0.0, 0.0, 18.0), (1.0, 0.0, 0.0), tip, contact, pin_program())


def test_a_turret_and_its_rollers() -> None:
    found = assembly_of(model("parallel_index"))
    names = [part.name or part.body.name for part in found.parts]
    assert names[:4] == ["plate 1", "plate 2", "shaft", "turret 1"]
    assert names.count("turret 2") == 1
    assert len({id(part.body) for part in found.parts}) == 7
    assert len(names) == len(set(names)) == 13
    for part in found.parts:
        assert isinstance(part.body, Brep)
        assert check_solid(part.body).problems == ()
    text = step_text(found)
    assert text.count("NEXT_ASSEMBLY_USAGE_OCCURRENCE(") == 13
    assert text.count("MANIFOLD_SOLID_BREP(") == 7


def test_rollers_of_a_pair_stand_on_their_tracks() -> None:
    pair = model("conjugate_rocker")
    rollers = [part for part in assembly_of(pair).parts if part.name.startswith("roller")]
    assert len(rollers) == len(pair.tracks) == 2
    for part, track in zip(rollers, pair.tracks):
        pose = track.pose(np.zeros(1), 0)
        for delta in (0.0, 7.0):
            stands = part.frame.world(np.array([[0.0, 0.0, delta]]))[0]
            assert stands == pytest.approx(pose.a[0][:, 0] + delta * pose.u[0][:, 0], abs=1e-12)


ROLLERS = {
    "cylinder": (Straight(11.0, 60.0), pi * 121.0 * 12.0),
    "cone": (Straight(11.0, 60.0, 0.1), pi * 12.0 * (121.0 + 0.01 * 12.0)),
    "crowned": (Arc(11.0, 60.0, 300.0), None),
}


@pytest.mark.parametrize("root", [None, 75.0])
@pytest.mark.parametrize("shape", ROLLERS)
def test_rollers_are_sound(shape: str, root: float | None) -> None:
    meridian, volume = ROLLERS[shape]
    verdict = check_solid(roller_solid(track_of(meridian), "roller", root))
    if volume is None:
        delta, weight = np.polynomial.legendre.leggauss(40)
        t = np.arcsin(6.0 * delta / 300.0)
        volume = float(pi * 6.0 * weight @ (11.0 - 300.0 * (1.0 - np.cos(t))) ** 2)
    stud = 0.0 if root is None else pi * 5.5**2 * (root - 66.0)
    assert verdict.problems == ()
    # A crown is no torus (its arc crosses the axis): fitted within 1e-5 mm.
    assert verdict.volume == pytest.approx(volume + stud, rel=1e-8 if shape != "crowned" else 5e-7)


def test_a_ball_is_cut_flat_beside_its_pole() -> None:
    track = track_of(Arc(11.0, 65.0, 11.0), 54.0, (54.0, 65.0))
    verdict = check_solid(roller_solid(track, "ball", None))
    assert verdict.problems == ()
    assert verdict.volume == pytest.approx(2.0 / 3.0 * pi * 11.0**3, rel=1e-6)


def test_nothing_to_place_beside_a_flat_follower(tmp_path: Path) -> None:
    with pytest.raises(DesignError, match="no rollers"):
        write(model("disc_flat_face"), tmp_path / "cam.assembly.step")
    assert not list(tmp_path.iterdir())


def test_result_notes_say_what_a_file_holds(tmp_path: Path) -> None:
    cam = model("pin_insertion")
    write(cam, tmp_path / "cam.ap214.step")
    text = (tmp_path / "cam.ap214.step").read_text()
    assert "AUTOMOTIVE_DESIGN" in text
    (body,) = cam.ledger.notes["step"][0]["bodies"]
    assert cam.ledger.notes["step"][0]["schema"] == "AP214"
    assert body["faces"] == "exact"
    assert 0.0 < body["deviation_mm"] <= 1e-5
    assert "exact faces, fitted ones within" in text
    write(cam, tmp_path / "cam.assembly.step")
    assert [(note["file"], note["schema"]) for note in cam.ledger.notes["step"]] == [
        ("cam.ap214.step", "AP214"), ("cam.assembly.step", "AP242")
    ]


def test_triangles_say_why(tmp_path: Path) -> None:
    cam = model("pin_insertion")
    part = replace(cam.parts[0], length=90.0)  # the groove runs out of the end, so it is no closed ring
    cam.body.__dict__["parts"] = (part,)
    cam.body.__dict__["solids"] = (replace(model("pin_insertion").solid, name="cam"),)
    write(cam, tmp_path / "cam.step")
    (body,) = cam.ledger.notes["step"][0]["bodies"]
    assert body["faces"] == "triangles"
    assert "runs out of an end" in body["reason"]
    assert body["deviation_mm"] == pytest.approx(cam.solid.chord_error)
    text = (tmp_path / "cam.step").read_text()
    assert "TRIANGULATED_FACE" in text
    assert "runs out of an end" in text
    with pytest.raises(ExportError, match="runs out of an end"):
        write(cam, tmp_path / "old.step", schema="AP214")


def test_the_result_says_what_the_step_file_holds(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    profile = str(PROFILES / "constant_width_press.toml")
    main(["run", profile, "--only", "exports", "--formats", "step", "--out", str(tmp_path)])
    capsys.readouterr()
    (entry,) = json.loads((tmp_path / "result.json").read_text())["step"]
    assert entry["file"].endswith(".step")
    assert (tmp_path / entry["file"]).exists()
    body, frame = entry["bodies"]
    assert (body["name"], body["faces"], body["count"]) == ("cam", "exact", 1)
    assert (frame["name"], frame["faces"], frame["count"]) == ("frame", "exact", 1)
    assert 0.0 < body["deviation_mm"] <= 1e-5
