"""Pictures show what is there, and their absence is told and not suffered."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from camgeom.drawing.colours import ROLLER
from camgeom.errors import ExportError
from camgeom.export import NamedMesh
from camgeom.maths.creases import crease_lines
from camgeom.maths.mesh import Mesh
from camgeom.report import painter
from camgeom.report.overlay import overlay
from camgeom.report.painter import render, stage, working_painter
from camgeom.report.views import CuttingPlane, View, skin

SIZE = (320, 240)


def box(low: tuple[float, float, float], high: tuple[float, float, float], *groups: str) -> Mesh:
    """A box; with groups: the last one is the top, the first one the rest."""
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = np.array([(q[0], q[i], q[i + 1]) for q in quads for i in (1, 2)], np.int32)
    group = (np.arange(12) >= 10).astype(np.uint8) if groups else None
    fields = {"height_mm": np.ascontiguousarray(corners[:, 2])}
    return Mesh(corners, faces, groups or ("surface",), group, fields)


CUBE = NamedMesh("cube", box((0.0, 0.0, 0.0), (10.0, 10.0, 10.0), "land", "flank"))


def share(picture: np.ndarray, colour: tuple[float, float, float], within: float = 0.1) -> float:
    """Share of the picture whose hue is that of the colour, lit or in shade."""
    rgb = picture.reshape(-1, 3) / 255.0
    strength = rgb.max(axis=1)
    hue = rgb / np.maximum(strength, 1e-9)[:, None]
    near = np.abs(hue - np.array(colour) / max(colour)).max(axis=1) < within
    return float(np.mean(near & (strength > 0.25) & (np.ptp(rgb, axis=1) > 0.1)))


@pytest.mark.opengl
def test_a_picture_is_a_png_of_its_size_with_the_part_inside_the_frame(tmp_path: Path) -> None:
    path = tmp_path / "cube.png"
    assert render([CUBE], path, View(size=SIZE)) == path.stat().st_size
    picture = np.asarray(Image.open(path))
    assert picture.shape == (240, 320, 3)
    frame = np.concatenate([picture[:3].reshape(-1, 3), picture[:, :3].reshape(-1, 3), picture[:, -3:].reshape(-1, 3)])
    assert np.all(frame == 255)
    assert 0.2 < np.mean(np.any(picture < 250, axis=2)) < 0.6


@pytest.mark.opengl
def test_a_body_is_seen_in_its_colour_where_it_is_put() -> None:
    roller = NamedMesh("roller", box((2.0, -6.0, 2.0), (8.0, -2.0, 8.0)), ROLLER)
    with stage([CUBE, roller], View(camera="-y", size=SIZE)) as scene:
        before = share(scene.image(), ROLLER)
        assert before > 0.1
        behind = np.eye(4)
        behind[1, 3] = 20.0
        scene.place("roller", behind)
        assert share(scene.image(), ROLLER) < 0.001
        scene.place("roller", np.eye(4)[:3])
        assert share(scene.image(), ROLLER) == pytest.approx(before, rel=1e-3)


@pytest.mark.opengl
def test_a_field_colours_its_groups_only() -> None:
    top = View(field="height_mm", field_groups=("flank",), limits=(0.0, 10.0), camera="+z", size=SIZE)
    yellow = (252, 232, 115)
    with stage([CUBE], top) as scene:
        assert share(scene.image(), tuple(c / 255 for c in yellow)) > 0.2
    side = View(field="height_mm", field_groups=("flank",), camera="-y", size=SIZE)
    with stage([CUBE], side) as scene:
        assert share(scene.image()[:, :200], tuple(c / 255 for c in yellow)) < 0.01


@pytest.mark.opengl
def test_a_section_shows_the_cut_of_the_named_bodies_only() -> None:
    cut, plane = (0.95, 0.85, 0.66), CuttingPlane((0.0, 5.0, 0.0), (0.0, -1.0, 0.0))
    for names, seen in ((("cube",), True), (("other",), False), ((), True)):
        with stage([CUBE], View(section=plane, section_bodies=names, camera="-y", size=SIZE)) as scene:
            assert (share(scene.image(), cut) > 0.1) is seen


def test_what_cannot_be_shown_is_refused(tmp_path: Path) -> None:
    for view, message in (
        (View(field="height"), "no body carries the field 'height'"),
        (View(camera="top"), r"no camera 'top'; there are iso, back, \+x"),
    ):
        with pytest.raises(ExportError, match=message):
            render([CUBE], tmp_path / "cube.png", view)
    assert not list(tmp_path.iterdir())


@pytest.mark.opengl
def test_a_painter_that_ends_costs_its_picture_alone(tmp_path: Path) -> None:
    with stage([CUBE], View(size=SIZE)) as scene:
        working_painter()._worker._process.kill()
        with pytest.raises(ExportError, match=r"the graphics library ended by signal 9 \(Killed\)"):
            scene.image()
    with pytest.raises(ExportError, match=r"no picture: the graphics library took more than 0\.001 s"):
        working_painter().ask("trial", seconds=1e-3)
    assert render([CUBE], tmp_path / "cube.png", View(size=SIZE)) > 0


@pytest.mark.opengl
def test_scenes_beside_each_other_do_not_mix_and_a_picture_with_errors_is_none(tmp_path: Path) -> None:
    flat = NamedMesh("flat", box((0.0, 0.0, 0.0), (10.0, 10.0, 1.0)), ROLLER)
    look = View(camera="-y", size=SIZE)
    with stage([CUBE], look) as one, stage([flat], look) as other:
        assert share(one.image(), ROLLER) < 0.001 < 0.02 < share(other.image(), ROLLER)
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    broken = NamedMesh("broken", Mesh(corners, np.array([[0, 1, 7]])))
    with pytest.raises(IndexError):
        render([broken], tmp_path / "broken.png", look)
    assert not list(tmp_path.iterdir())


@pytest.fixture
def fresh_answer(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """The machine is asked again, and again after the test."""
    monkeypatch.setattr(painter, "_started", painter._started.__wrapped__)
    monkeypatch.delenv("VTK_DEFAULT_OPENGL_WINDOW", raising=False)
    return monkeypatch


@pytest.mark.parametrize("end", ["kill -SEGV $$", "exit 1", "exit 0", "echo drawn"])
def test_a_painter_that_crashes_fails_or_draws_nothing_is_told(
    tmp_path: Path, fresh_answer: pytest.MonkeyPatch, end: str
) -> None:
    broken = tmp_path / "python"
    broken.write_text(f"#!/bin/sh\n{end}\n")
    broken.chmod(0o755)
    fresh_answer.setattr(sys, "executable", str(broken))
    with pytest.raises(ExportError, match="apt-get install libegl1 libgl1-mesa-dri"):
        render([CUBE], tmp_path / "cube.png")
    fresh_answer.setattr(painter, "memory_limits", lambda: {"an address space of 500 MB (ulimit -v)": 500})
    with pytest.raises(ExportError, match=r"no OpenGL library works here within an address space of 500 MB"):
        render([CUBE], tmp_path / "cube.png")
    fresh_answer.setattr(sys, "executable", str(tmp_path / "absent"))
    assert not painter.draws()


def test_the_named_window_is_the_only_one_tried(fresh_answer: pytest.MonkeyPatch) -> None:
    tried: list[str] = []
    fresh_answer.setattr(painter, "_start", lambda window: tried.append(window))
    fresh_answer.setenv("DISPLAY", ":7")
    assert not painter.draws()
    assert tried == ["vtkEGLRenderWindow", "", "vtkOSOpenGLRenderWindow"]
    fresh_answer.setenv("VTK_DEFAULT_OPENGL_WINDOW", "vtkSomething")
    tried.clear()
    assert not painter.draws()
    assert tried == ["vtkSomething"]


@pytest.mark.parametrize(
    ("normal", "point", "left"),
    [
        ((0.0, 0.0, 1.0), (0.0, 0.0, 4.0), 400.0),
        ((0.0, 0.0, -1.0), (0.0, 0.0, 4.0), 600.0),
        ((1.0, 1.0, 1.0), (5.0, 5.0, 5.0), 500.0),
        ((1.0, 0.0, 0.0), (12.0, 0.0, 0.0), 1000.0),
        ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), 0.0),
    ],
)
def test_a_cut_body_is_closed_and_has_the_right_volume(
    normal: tuple[float, float, float], point: tuple[float, float, float], left: float
) -> None:
    plane = CuttingPlane(point, normal)
    drawn = skin(CUBE.mesh, "height_mm", plane)
    # The library cuts in single precision.
    assert plane.height(drawn.points[drawn.faces].reshape(-1, 3)).max(initial=-1.0) <= 1e-6
    for origin in (np.zeros(3), np.array([37.0, -11.0, 5.0])):  # the same about any origin: nothing is open
        a, b, c = ((drawn.points - origin)[drawn.faces[:, i]] for i in range(3))
        assert np.einsum("fi,fi->", a, np.cross(b, c)) / 6.0 == pytest.approx(left, abs=1e-4)
    assert drawn.values is not None
    old = drawn.faces[drawn.group < 2]
    np.testing.assert_allclose(drawn.values[old], drawn.points[old][..., 2], atol=1e-6)
    if len(drawn.lines):
        assert plane.height(drawn.lines.reshape(-1, 3)).max() <= 1e-6


def test_the_hatching_covers_the_cut_and_nothing_else() -> None:
    drawn = skin(CUBE.mesh, None, CuttingPlane((0.0, 0.0, 4.0), (0.0, 0.0, 1.0)))
    assert drawn.groups[-1] == "cut"
    np.testing.assert_allclose(drawn.hatch[..., 2], 4.0)
    assert drawn.hatch[..., :2].min() >= 0.0
    assert drawn.hatch[..., :2].max() <= 10.0
    length = np.linalg.norm(drawn.hatch[:, 1] - drawn.hatch[:, 0], axis=1).sum()
    assert length * 10.0 / 36.0 == pytest.approx(100.0, rel=0.02)  # area = length x spacing


def test_lines_are_creases_group_borders_and_open_ends() -> None:
    assert len(crease_lines(CUBE.mesh)) == 12
    lid = Mesh(CUBE.mesh.vertices, CUBE.mesh.faces[10:])
    assert len(crease_lines(lid)) == 4
    grouped = Mesh(CUBE.mesh.vertices, CUBE.mesh.faces[10:], ("a", "b"), np.array([0, 1], np.uint8))
    assert len(crease_lines(grouped)) == 5


@pytest.mark.parametrize(("mm_per_pixel", "length"), [(0.1, 20.0), (0.011, 2.0), (3.0, 500.0)])
def test_the_scale_bar_has_the_length_it_names(mm_per_pixel: float, length: float) -> None:
    blank = np.full((900, 1200, 3), 255, np.uint8)
    axes = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
    picture = np.asarray(overlay(blank, (1200, 900), mm_per_pixel, axes, None))
    row = picture[round(0.9 * (1000 - 36)), :, :].max(axis=1) < 200
    columns = np.flatnonzero(row[600:])
    assert (columns[-1] - columns[0]) * mm_per_pixel == pytest.approx(length, abs=3.0 * mm_per_pixel)
