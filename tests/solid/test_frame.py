"""The frame of a constant-width cam as a part: its body, its files, and what is judged of it, both sides."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import camgeom
from camgeom.cams import starter
from camgeom.checks import judge
from camgeom.design.batch import supports
from camgeom.errors import ProfileError
from camgeom.export import write
from camgeom.export.step.bodies import assembly_of, frame_of, model_bodies
from camgeom.export.step.brep import Assembly
from camgeom.export.step.check import check_solid
from camgeom.model import Model
from camgeom.profile import parse
from camgeom.report.data.geometry import solid_data
from tests.places import BARE, PLATE, PROFILES


@pytest.fixture(scope="module")
def press() -> Model:
    return camgeom.read(PROFILES / "constant_width_press.toml").with_(impact=None, reproduces=None)


def changed(press: Model, **keys: Any) -> Model:
    return press.with_(**{f"follower__{key}": value for key, value in keys.items()})


SHAPES: dict[str, tuple[dict[str, Any], int]] = {
    "as shipped": ({}, 3),
    "without bores": ({"guide_bore": None}, 1),
    "sharp corners": ({"window_radius": None}, 3),
    "plain window": ({"face_width": 144.0, "face_height": None, "window_radius": None, "window_width": None}, 3),
    "corners as large as the faces stand out": ({"window_radius": 4.0, "plate_thickness": 10.0}, 3),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_the_body_is_closed_and_as_large_as_its_closed_form(press: Model, shape: str) -> None:
    keys, genus = SHAPES[shape]
    model = changed(press, **keys)
    plate, solid = model.mechanism.frame, model.frame
    assert plate is not None
    assert solid is not None
    assert solid.sound
    assert solid.mesh.genus == genus
    assert solid.chord_error <= model.tolerance
    # Chords lie within the round corners and bores, which are openings: the mesh is the larger one.
    fine = plate.solid(1e-4).mesh.volume
    assert plate.volume <= fine == pytest.approx(plate.volume, rel=1e-5)
    exact = check_solid(frame_of(model))
    assert exact.problems == ()
    assert exact.genus == genus
    assert exact.volume == pytest.approx(plate.volume, rel=1e-12)
    assert model.frame_mass == pytest.approx(plate.volume * 7850e-9)
    faces = [side for side in plate.sides if side.name == "face"]
    assert [np.ptp((side.start[1], side.stop[1])) for side in faces] == [plate.face] * 2
    assert abs(faces[0].start[0] - faces[1].start[0]) == pytest.approx(plate.opening, abs=1e-12)


def test_the_faces_stand_apart_by_the_width_and_the_play_and_touch_the_cam_all_round(press: Model) -> None:
    """Cam points, in the frame's place at each cam angle: within the faces by half of the play, and at it somewhere."""
    plate = press.mechanism.frame
    assert plate is not None
    faces = np.array([side.start[0] for side in plate.sides if side.name == "face"])
    assert np.ptp(faces) == pytest.approx(110.0 + 0.02, abs=1e-12)
    flank = press.solid.mesh.vertices[press.solid.mesh.group_vertices("flank")]
    for phi in np.linspace(0.0, 2.0 * np.pi, 25):
        lift = float(press.setup.program.jet(np.array([phi]), 0)[0][0])
        x = ((flank[:, 0] + 1j * flank[:, 1]) * np.exp(1j * phi)).real - lift
        assert faces.max() - x.max() == pytest.approx(0.01, abs=1e-2)
        assert x.min() - faces.min() == pytest.approx(0.01, abs=1e-2)
        assert faces.max() - x.max() >= 0.01 - 1e-9
        assert x.min() - faces.min() >= 0.01 - 1e-9


@pytest.mark.parametrize(("share", "level"), [(0.999, "fail"), (1.002, "pass")])
def test_both_sides_of_every_limit(press: Model, share: float, level: str) -> None:
    """The sides of the window, walls, and the mass of what moves."""
    radius, wall = 70.0, 4.0

    def told(check: str, word: str, **keys: Any) -> str:
        found = judge(changed(press, **keys), [check]).findings
        return next(finding.level for finding in found if word in finding.where)

    apart = press.with_(limits__clearance_mm=1.5)
    window = 2.0 * (radius + 1.5 * share)
    assert told("window", "side") == "pass"
    (side,) = judge(changed(apart, window_width=window), ["window"]).findings
    assert side.level == level
    thick = press.with_(limits__min_wall_mm=wall)
    for word, keys in {
        "window to end": {"plate_length": 118.02 + 2.0 * wall * share, "guide_bore": None},
        "window to side": {"plate_width": 144.0 + 2.0 * wall * share, "guide_bore": None},
        "guide bore to window": {"guide_spacing": 144.0 + 8.0 + 2.0 * wall * share, "plate_width": 190.0},
        "guide bore to side": {"guide_spacing": 176.0 - 8.0 - 2.0 * wall * share, "window_width": 141.0},
        "guide bore to face": {"plate_thickness": 8.0 + 2.0 * wall * share},
        "from face to face": {"plate_thickness": wall * share, "guide_bore": None},
    }.items():
        found = judge(changed(thick, **keys), ["wall"]).findings
        assert next(finding.level for finding in found if finding.where == f"frame, {word}") == level, word
    own = press.frame_mass
    assert own is not None
    assert told("moving-mass", "frame", mass=own * share) == level
    assert told("moving-mass", "frame", mass=None) == "fail"
    carried = changed(press, mass=0.5).with_(operation__load_mass=own * share - 0.5)
    assert judge(carried, ["moving-mass"]).findings[0].level == level


REFUSED: dict[str, dict[str, Any]] = {
    "plate_width": {"plate_width": None},
    "face_width": {"face_width": None},
    "face_height": {"face_height": None, "window_radius": None},
    "window_radius": {"window_radius": 4.01},
    "plate_length": {"plate_length": 118.0},
    "guide_bore": {"guide_bore": 16.0},
    "guide_spacing": {"guide_spacing": 151.9},
}


@pytest.mark.parametrize("key", REFUSED)
def test_what_bounds_no_plate_is_refused_by_its_key(press: Model, key: str) -> None:
    with pytest.raises(ProfileError, match=rf"follower\.{key}: "):
        changed(press, **REFUSED[key])


@pytest.mark.parametrize("width", [144.01, 159.99])
def test_a_bar_too_narrow_for_its_bore_is_told_of_the_bore(press: Model, width: float) -> None:
    words = r"follower\.guide_bore: .*allowed: below .* the bars beside the window"
    with pytest.raises(ProfileError, match=words) as told:
        changed(press, plate_width=width)
    assert "guide_spacing" not in str(told.value)


def test_keys_that_mean_nothing_are_refused(press: Model) -> None:
    bare: dict[str, Any] = dict.fromkeys(set(PLATE) - {"window_width", "guide_spacing"})
    with pytest.raises(ProfileError, match=r"follower\.window_width: means nothing here .*no plate"):
        changed(press, **bare)
    with pytest.raises(ProfileError, match=r"follower\.guide_spacing: means nothing here .*no guide_bore"):
        changed(press, guide_bore=None, guide_spacing=160.0)
    dense = {"density": 2700.0}
    light = press.with_(material={"roller": dense})
    assert light.frame_mass == pytest.approx(0.34395 * (press.frame_mass or 0.0), rel=1e-4)
    with pytest.raises(ProfileError, match=r"material\.roller\.density: means nothing here"):
        changed(press, **bare, window_width=None).with_(material={"roller": dense})


def test_a_thinner_plate_bears_more(press: Model) -> None:
    """Pressure of a line goes with the root of its load over the length that touches: that of the thinner body."""
    peaks = [model.carrier.peak_pressure for model in (press, changed(press, plate_thickness=9.0))]
    assert peaks[0] is not None
    assert peaks[1] is not None
    assert peaks[1].value == pytest.approx(peaks[0].value * (16.0 / 9.0) ** 0.5, rel=1e-9)


def test_a_batch_leaves_a_frame_that_is_a_part_to_the_exact_model(press: Model) -> None:
    """A plate thinner than the cam bears less length, and only the exact model knows it."""
    part = press.with_(operation__force=None).profile
    bare = press.with_(operation__force=None, **BARE).profile
    assert supports(bare, ["operation.speed"]) is None
    assert "part" in str(supports(part, ["operation.speed"]))
    assert "part" in str(supports(bare, ["follower.plate_thickness"]))


def test_the_plate_that_the_starter_proposes_is_sound() -> None:
    proposed = starter("constant-width").replace("# plate", "plate").replace("# window", "window")
    model = Model(parse(proposed.replace("# face_height", "face_height").replace("# guide", "guide")))
    assert model.frame is not None
    assert model.frame.sound
    levels = {one.level for one in judge(model, ["wall", "window", "face-width"]).findings}
    assert levels == {"pass"}


def test_every_file_has_the_frame(press: Model, tmp_path: Path) -> None:
    for found in (model_bodies(press), assembly_of(press)):
        assert isinstance(found, Assembly)
        assert [part.body.name for part in found.parts] == ["cam", "frame"]
    assert [body["name"] for body in solid_data(press)["bodies"]] == ["cam", "frame"]
    for name, words in {"a.3mf": (), "a.obj": ("o frame",), "a.dxf": ("FRAME", "HIDDEN"), "a.step": ("'frame'",),
                        "a.assembly.step": ("'frame'",), "a.frame.step": ("'frame'",)}.items():  # fmt: skip
        assert write(press, tmp_path / name) > 0
        text = (tmp_path / name).read_bytes()
        assert all(word.encode() in text for word in words), name
    size = (tmp_path / "a.stl", sum(len(solid.mesh.faces) for solid, _ in press.workpieces))
    assert write(press, size[0]) == 84 + 50 * size[1]


def test_points_of_the_frame_lie_on_it_and_their_normals_leave_it(press: Model, tmp_path: Path) -> None:
    write(press, tmp_path / "a.frame.points.csv")
    with (tmp_path / "a.frame.points.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert {row["face"] for row in rows} == {"near face", "far face", "window", "guide bore"}
    plate = press.mechanism.frame
    assert plate is not None
    for row in rows:
        x = np.array([float(row[f"{axis}_mm"]) for axis in "xyz"])
        n = np.array([float(row[f"normal_{axis}"]) for axis in "xyz"])
        assert np.hypot.reduce(n) == pytest.approx(1.0, abs=1e-7)
        if row["face"] == "near face":
            assert x[0] == pytest.approx(40.01, abs=1e-12)
            assert n[0] == pytest.approx(-1.0)
        if row["face"] == "guide bore":
            y = min(plate.rods, key=lambda rod: abs(rod - x[1]))
            assert np.hypot(x[1] - y, x[2] - 8.0) == pytest.approx(4.0)
            assert n @ (x - np.array([x[0], y, 8.0])) == pytest.approx(-4.0)
