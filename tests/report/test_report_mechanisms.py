"""Followers in pictures stand and move where the mechanics says; pages of indexing drives and of impacts."""

from __future__ import annotations

from dataclasses import replace
from math import pi, radians

import numpy as np
import pytest

from camgeom.drawing.content import Block, Chart, Drawing, Scene, Table
from camgeom.drawing.drawing import _bounds
from camgeom.drawing.plots import NARROW, WIDE
from camgeom.drawing.sheet import overlap
from camgeom.dynamics.impact.run import solve
from camgeom.dynamics.indexing.drive import IndexingDrive
from camgeom.dynamics.indexing.study import IndexingStudy
from camgeom.model import Model, read
from camgeom.motion import Program, Segment
from camgeom.profile import parse
from camgeom.report.page import render, sheet
from camgeom.report.sections import report
from camgeom.report.sections.bodies import cam_poses
from camgeom.report.sections.design import outlines
from camgeom.report.sections.impact import impacts
from camgeom.report.sections.indexing import indexing
from tests.places import PROFILES
from tests.reference.impact_reference import b1_problem

DISC = """
name = "plate"
[cam]
kind = "disc"
base_radius = 40
width = 14
bore = 20
direction = "{direction}"
{cam}
[follower]
{follower}
{roller}
[[motion]]
until = 150
to = 12
law = "modified-sine"
[[motion]]
until = 180
[[motion]]
until = 330
to = 0
law = "cycloidal"
[[motion]]
until = 360
"""
ROLLER = '[roller]\nshape = "cylinder"\ndiameter = 22\nlength = 10'
FOLLOWERS = {
    "sliding roller": ("", 'kind = "translating"\noffset = 6', ROLLER),
    "swinging roller": ("center_distance = 95", 'kind = "swinging"\narm = 70', ROLLER),
    "sliding face": ("", 'kind = "translating"\nface = "flat"', ""),
    "swinging face": ("center_distance = 90", 'kind = "swinging"\nface = "flat"\narm = 60', ""),
    "knife edge": ("", 'kind = "translating"\nface = "knife"', ""),
}


def _disc(name: str, direction: str) -> Model:
    cam, follower, roller = FOLLOWERS[name]
    return Model(parse(DISC.format(cam=cam, follower=follower, roller=roller, direction=direction)))


def _blocks(model: Model, section: str) -> tuple[Block, ...]:
    return report(model, [section]).sections[0].blocks


@pytest.mark.parametrize("direction", ["ccw", "cw"])
@pytest.mark.parametrize("name", FOLLOWERS)
def test_follower_touches_the_turning_plate_and_never_enters(name: str, direction: str) -> None:
    (scene,) = _blocks(_disc(name, direction), "solid")
    assert isinstance(scene, Scene)
    cam = next(body for body in scene.bodies if body.role == "cam")
    tool = next(body for body in scene.bodies if body.role == "follower")
    assert cam.poses is not None
    assert tool.poses is not None
    assert tool.mesh.watertight
    assert tool.mesh.volume > 0.0
    (rim,) = (loop for loop in outlines(cam.mesh, 2, 7.0) if np.hypot(loop[:, 0], loop[:, 1]).min() > 20.0)
    rim = np.concatenate([rim + share * (np.roll(rim, -1, axis=0) - rim) for share in np.linspace(0.0, 0.98, 50)])
    for k in range(0, len(scene.angles), 15):
        machine = rim @ cam.poses[k, :, :3].T + cam.poses[k, :, 3]
        seen = (machine - tool.poses[k, :, 3]) @ tool.poses[k, :, :3]  # in the follower's own frame
        depth = _distance(name, tool.mesh.vertices, seen)
        assert -0.02 < depth < 0.02, (name, float(scene.angles[k]), depth)


def _distance(name: str, tool: np.ndarray, seen: np.ndarray) -> float:
    """Least distance of the plate's rim from the touching surface of the follower, mm."""
    if "face" in name:
        return float(-seen[:, 0].max())
    if "knife" in name:
        edge = tool[np.argmin(np.hypot(tool[:, 0], tool[:, 1]))]
        return float(np.hypot(seen[:, 0] - edge[0], seen[:, 1] - edge[1]).min())
    low = tool[tool[:, 2] < tool[:, 2].min() + 1e-6]
    centre = 0.5 * (low.max(axis=0) + low.min(axis=0))
    return float(np.hypot(seen[:, 0] - centre[0], seen[:, 1] - centre[1]).min() - 11.0)


@pytest.mark.parametrize("name", FOLLOWERS)
def test_drawing_of_every_follower_is_readable(name: str) -> None:
    for block in _blocks(_disc(name, "ccw"), "design"):
        if isinstance(block, Drawing):
            _readable(block)


def _readable(plot: Chart | Drawing) -> None:
    for width in (WIDE, NARROW):
        drawn = sheet(plot, width)
        for i, (box, text) in enumerate(drawn.words):
            assert box[0] > -1.5, text
            assert box[2] < drawn.width + 1.5, text
            assert [t for b, t in drawn.words[i + 1 :] if overlap(box, b, -1.5) > 30.0] == [], text


def test_cam_turns_the_way_it_says() -> None:
    quarter, cam = np.array([0.5 * pi]), read(str(PROFILES / "disc_flat_face.toml")).mechanism
    for sense in (1.0, -1.0):
        turned = cam_poses(replace(cam, sense=sense), quarter)
        assert turned[0, :, 0] == pytest.approx([0.0, sense, 0.0])


def test_indexing_drive_is_shown_with_its_own_numbers() -> None:
    drive = IndexingDrive(
        cam_inertia=7e-2, turret_inertia=3.5e-3, load_inertia=6e-2, input_stiffness=1.9e5, output_stiffness=3.5e5,
        contact_stiffness=1.2e6, input_damping=7.0, output_damping=8.7, contact_damping=3.9,
    )  # fmt: skip
    move = Segment(radians(300.0), radians(45.0), "modified-sine")
    program = Program.from_segments([move, Segment(2.0 * pi)], closed=False, angular=True)
    speeds = np.array([400.0, 800.0, 1200.0]) * pi / 30.0
    study = IndexingStudy(drive, program, speeds[1], sweep_speeds=speeds)
    response, blocks = study.steady, indexing(study)
    for block in blocks:
        if isinstance(block, Chart):
            _readable(block)
    over_turn = next(b for b in blocks if isinstance(b, Chart) and "Periodic response" in b.caption)
    shown = over_turn.panels[0].series[0].y
    assert np.abs(shown).max() == pytest.approx(float(response.peak("load_acceleration").magnitude[0]), rel=2e-3)
    table = next(b for b in blocks if isinstance(b, Table) and "Extremes" in b.caption)
    row = next(row for row in table.rows if row[0] == "load acceleration")
    assert row[2] == pytest.approx(float(response.peak("load_acceleration").maximum[0]))


def test_impacts_are_listed_and_the_play_is_crossed() -> None:
    run = solve(b1_problem(1e-4), turns=2)
    blocks = impacts(run, angular=True)
    chart = next(b for b in blocks if isinstance(b, Chart))
    _readable(chart)
    play = chart.panels[2].series[0].y
    assert play.max() - play.min() > 1e3 * 1.1e-3  # mrad: the whole angle of play, and the contacts give way
    table = next(b for b in blocks if isinstance(b, Table) and "Impacts" in b.caption)
    window = run.turn_times()[-1]
    assert len(table.rows) == len([hit for hit in run.impacts if window[0] <= hit.time < window[1]])


def test_dynamics_section_shows_what_the_model_knows() -> None:
    model = Model(parse(DISC.format(cam="", follower='kind = "translating"', roller=ROLLER, direction="ccw")))
    assert report(model, ["dynamics"]).sections == ()
    text = (PROFILES / "conjugate_rocker.toml").read_text(encoding="utf-8")
    model = Model(parse(text.replace("turns = 3", "turns = 2\ntolerance = 1e-6")))
    (section,) = report(model, ["dynamics"]).sections
    assert any(isinstance(block, Table) and "Impacts" in block.caption for block in section.blocks)


def test_frame_holds_the_constant_width_cam_on_both_sides() -> None:
    from camgeom.cams import starter

    (scene,) = _blocks(Model(parse(starter("constant-width"))), "solid")
    assert isinstance(scene, Scene)
    cam = next(body for body in scene.bodies if body.role == "cam")
    frame = next(body for body in scene.bodies if body.role == "follower")
    assert frame.mesh.watertight
    assert frame.mesh.genus == 1
    assert cam.poses is not None
    assert frame.poses is not None
    inner = frame.mesh.vertices[len(frame.mesh.vertices) // 2 :]  # the outer ring comes first
    faces = inner[[0, 5], 0]  # corners of the near and the far face, which stand out from the frame
    for k in range(0, len(scene.angles), 12):
        machine = cam.mesh.vertices @ cam.poses[k, :, :3].T
        shift = frame.poses[k, 0, 3]
        assert machine[:, 0].max() == pytest.approx(shift + faces.max(), abs=0.02)
        assert machine[:, 0].min() == pytest.approx(shift + faces.min(), abs=0.02)
        assert np.abs(machine[:, 1]).max() < inner[:, 1].max()


def test_page_of_a_turret_shows_every_roller_and_the_whole_engagement() -> None:
    from camgeom.cams import starter

    model = Model(parse(starter("globoidal")))
    page = report(model, ["solid", "flank"])
    scene = next(b for s in page.sections for b in s.blocks if isinstance(b, Scene))
    rollers = [body for body in scene.bodies if body.name.startswith("roller")]
    assert len(rollers) == (model.setup.follower.rollers or model.setup.follower.stops)
    assert [body.name for body in scene.bodies].count("turret") == 1
    assert all(body.mesh.watertight for body in scene.bodies)
    places = {tuple(np.round(b.poses[0, :, :3] @ b.mesh.vertices.mean(axis=0) + b.poses[0, :, 3], 3)) for b in rollers}
    assert len(places) == len(rollers)
    assert len(render(page)) < 3_000_000


def test_whole_frame_stands_inside_the_drawing() -> None:
    """The sheet's size follows from all outlines of a follower, its openings and parts among them."""
    from camgeom.cams import starter

    model = Model(parse(starter("constant-width")))
    drawings = [block for block in _blocks(model, "design") if isinstance(block, Drawing)]
    assert len(drawings) == 2
    for drawing in drawings:
        left, low, right, high = _bounds(drawing)
        frame = next(path for path in drawing.paths if path.kind == "ghost")
        assert len(frame.holes) == 1
        for loop in (frame.points, *frame.holes):
            assert left <= loop[:, 0].min() <= loop[:, 0].max() <= right
            assert low <= loop[:, 1].min() <= loop[:, 1].max() <= high
