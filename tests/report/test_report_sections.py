"""The report of a real model: right numbers in the right places, work only where it is shown, reasons for gaps."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from camgeom.drawing.content import Chart, Drawing, Level, Map, Page, Polar, Scene, Table, Text
from camgeom.drawing.plots import NARROW, WIDE
from camgeom.drawing.sheet import overlap
from camgeom.errors import ExportError, ProfileError
from camgeom.maths.mesh import Mesh
from camgeom.mechanics.duty import peak_of
from camgeom.model import Model, read
from camgeom.profile import parse
from camgeom.report.page import render, sheet
from camgeom.report.sections import SECTIONS, report, write_report
from camgeom.report.sections.bodies import cam_poses, poses, roller_mesh
from camgeom.report.sections.design import outlines
from tests.places import PROFILES

PIN = PROFILES / "pin_insertion.toml"

SWINGING = """
name = "swinging <b>rib</b>"
[cam]
kind = "cylindrical"
form = "rib"
rib_thickness = 14
diameter = 120
length = 90
start = 45
groove_depth = 12
direction = "cw"
[follower]
kind = "swinging"
arm = 70
[roller]
shape = "crowned"
diameter = 20
length = 10
crown_radius = 400
[[motion]]
until = 120
to = 12
law = "modified-sine"
[[motion]]
until = 180
[[motion]]
until = 300
to = 0
law = "3-4-5"
[[motion]]
until = 360
"""


@pytest.fixture(scope="module")
def model() -> Model:
    return read(str(PIN))


@pytest.fixture(scope="module")
def page(model: Model) -> Page:
    return report(model)


def _plots(page: Page) -> list[Chart | Map | Polar | Drawing]:
    blocks = [b for section in page.sections for b in section.blocks]
    return [b for b in blocks if isinstance(b, Chart | Map | Polar | Drawing)]


def _crowded(plot: Chart | Map | Polar | Drawing, width: float) -> list[str]:
    drawn = sheet(plot, width)
    faults = [f"{text} leaves the sheet" for box, text in drawn.words if box[0] < -1.5 or box[2] > drawn.width + 1.5]
    for i, (box, text) in enumerate(drawn.words):
        faults += [f"{text} on {other}" for b, other in drawn.words[i + 1 :] if overlap(box, b, -1.5) > 30.0]
    return faults


def test_report_of_the_groove_cam_has_every_section(page: Page) -> None:
    assert page.level is Level.WARN
    missing = {entry.key for entry in SECTIONS} - {section.key for section in page.sections}
    assert missing <= {"dynamics", "cutter", "tolerance", "body", "followers"}
    assert len(render(page)) < 3_000_000


def test_no_section_stands_empty_with_a_reason(page: Page) -> None:
    texts = [p for s in page.sections for b in s.blocks if isinstance(b, Text) for p in b.paragraphs]
    assert not [text for text in texts if "cannot be computed" in text]


def test_figures_are_the_models_own(model: Model, page: Page) -> None:
    shown = {figure.label: figure.value for figure in page.figures}
    assert shown["Stroke"] == pytest.approx(74.0)
    assert shown["Peak contact pressure"] == pytest.approx(1102.458, abs=5e-3)
    assert shown["Contact pressure, quoted place"] == pytest.approx(1004.677, abs=5e-3)
    assert shown["Roller life"] == pytest.approx(23064.1, abs=1.0)
    assert shown["Largest pressure angle"] == pytest.approx(np.degrees(model.flanks[0].pressure_angle.value))


def test_marks_on_the_contact_chart_are_the_refined_extremes(model: Model, page: Page) -> None:
    chart = next(b for s in page.sections if s.key == "contact" for b in s.blocks if isinstance(b, Chart))
    force, pressure, _ = chart.panels
    high = peak_of(model.duty.force.panels, model.duty.normal)
    assert (force.marks[0].x, force.marks[0].y) == pytest.approx((np.degrees(high.cam_angle), high.value))
    for series in (*force.series, *pressure.series):
        top = max(
            mark.y for panel in (force, pressure) for mark in panel.marks if panel.series and series in panel.series
        )
        assert series.y.max() <= top * (1.0 + 1e-9)


def test_second_ways_agree(page: Page) -> None:
    section = next(s for s in page.sections if s.key == "validation")
    table = next(b for b in section.blocks if isinstance(b, Table))
    assert len(table.rows) >= 9
    assert [row for row in table.rows if row[-1] is not True] == []


@pytest.mark.parametrize("width", [WIDE, NARROW])
def test_labels_of_the_real_page_keep_clear(page: Page, width: float) -> None:
    assert [fault for plot in _plots(page) for fault in _crowded(plot, width)] == []


def test_swinging_rib_turning_clockwise(tmp_path: Path) -> None:
    page = report(Model(parse(SWINGING)))
    assert [fault for plot in _plots(page) for w in (WIDE, NARROW) for fault in _crowded(plot, w)] == []
    scene = next(b for s in page.sections for b in s.blocks if isinstance(b, Scene))
    assert [body.role for body in scene.bodies].count("follower") == 3  # two rollers on one arm
    for body in scene.bodies:
        assert body.mesh.watertight
        assert body.mesh.volume > 0.0
    assert "<b>rib</b>" not in render(page)


def test_one_section_computes_only_what_it_shows(tmp_path: Path) -> None:
    lone = read(str(PIN))
    page = report(lone, ["motion"])
    assert [section.key for section in page.sections] == ["motion"]
    assert page.level is None
    assert set(lone.ledger.costs) <= {"setup"}


def test_known_findings_are_not_judged_again() -> None:
    from camgeom.checks.verdict import Finding, Verdict

    known = Finding("pressure-angle", "fail", 71.0, "<=", 70.0, "deg", 325.0, "somewhere", "slow down")
    lone = read(str(PIN))
    page = report(lone, ["checks"], Verdict((known,)))
    assert (page.level, page.findings[0].value, page.findings[0].limit) == (Level.FAIL, 71.0, "≤ 70°")
    assert page.findings[0].advice == "Slow down."
    assert "checks" not in lone.ledger.costs


def test_unknown_section_is_named_with_the_known_ones(model: Model) -> None:
    with pytest.raises(ProfileError, match="motoin") as caught:
        report(model, ["motoin"])
    assert "motion" in str(caught.value)


def test_text_and_plots_load_no_picture_library() -> None:
    code = (
        "import sys; from camgeom.model import read; from camgeom.report.page import render;"
        "from camgeom.report.sections import report;"
        f"render(report(read({str(PIN)!r}), ['checks', 'motion', 'flank', 'contact', 'fatigue', 'parameters']));"
        "print([m for m in ('matplotlib', 'pyvista', 'vtk', 'trimesh', 'meshio', 'scipy.spatial') if m in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=PIN.parent.parent
    )
    assert done.stdout.strip() == "[]"


def test_undercut_cam_gets_a_page_that_says_so() -> None:
    tight = PIN.read_text().replace("diameter = 22", "diameter = 60")
    html = render(report(Model(parse(tight)), ["design", "solid", "motion", "flank"]))
    assert "No body can be drawn" in html
    assert "is undercut at cam angle" in html
    assert "The flank folds back on itself" in html


def test_report_file_is_whole_or_absent(model: Model, tmp_path: Path) -> None:
    path = write_report(model, tmp_path / "deep" / "report.html", ["motion"])
    assert path.read_text(encoding="utf-8").endswith("</html>\n")
    (tmp_path / "taken").mkdir()
    with pytest.raises(ExportError):
        write_report(model, tmp_path / "taken", ["motion"])


def test_outlines_of_a_ring_are_its_two_circles(model: Model) -> None:
    (name, mesh) = (model.solids[0].name, model.solids[0].mesh)
    loops = outlines(mesh, 2, 105.0)
    assert name
    radii = sorted(float(np.hypot(loop[:, 0], loop[:, 1]).max()) for loop in loops)
    assert len(loops) == 2
    assert radii[1] == pytest.approx(67.0, abs=6e-3)
    for loop in loops:
        assert np.all(loop[:, 2] == pytest.approx(105.0))


def test_outlines_enclose_the_area_of_the_section() -> None:
    corners = np.array([[x, y, z] for x in (0.0, 2.0) for y in (0.0, 3.0) for z in (0.0, 1.0)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], np.int32)
    box = Mesh(corners, faces)
    assert box.watertight
    for level in (0.0, 0.5, 1.0):  # a level through vertices closes as well
        loops = outlines(box, 2, level)
        for loop in loops:
            x, y = loop[:, 0], loop[:, 1]
            area = 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))
            assert area == pytest.approx(6.0)


def test_posed_roller_rolls_where_the_track_says(model: Model) -> None:
    track = model.tracks[0]
    phi = np.radians([0.0, 200.0, 320.0])
    follower, cam = poses(track, phi), cam_poses(model.mechanism, phi)
    pose = track.pose(phi, 0)
    middle = np.array(track.anchor) + 60.0 * np.array(track.axis)
    for k in range(3):
        machine = follower[k, :, :3] @ middle + follower[k, :, 3]
        seen = cam[k, :, :3].T @ machine
        assert seen == pytest.approx(pose.a[0][:, k] + 60.0 * pose.u[0][:, k], abs=1e-9)
    body = roller_mesh(track)
    assert body.watertight
    assert body.volume > np.pi * 11.0**2 * 12.0 * 0.99


@pytest.mark.parametrize(
    ("name", "said"), [("disc_offset_roller", "straight along"), ("feeder_runout", "straight along"),
                       ("conforming", "envelope of the roller's crown")]
)  # fmt: skip
def test_the_flank_under_a_crown_is_said(name: str, said: str) -> None:
    from camgeom.report.sections.flank import flank

    text = (PROFILES / f"{name if name != 'conforming' else 'feeder_runout'}.toml").read_text()
    if name == "conforming":
        text = text.replace("crown_radius = 300", 'crown_radius = 300\nflank = "conforming"')
    texts = [block.paragraphs for block in flank(Model(parse(text))) if isinstance(block, Text)]
    assert any(said in word for words in texts for word in words)


def test_sections_of_two_tracks_stand_beside_each_other() -> None:
    page = report(read(str(PROFILES / "two_groove_drum.toml")), only=("design", "motion", "flank", "followers"))
    assert [section.key for section in page.sections] == [
        "design", "motion", "motion-2", "flank", "flank-2", "followers"
    ]  # fmt: skip
    assert page.sections[2].title == "Motion, follower 2"


@pytest.mark.parametrize(("name", "lean", "said"), [
    ("two_groove_drum", 0.0, ", follower 1 at cam angle 0"), ("both_faces_disc", 0.0, ""),
    ("both_faces_disc", 8.0, "; flank of follower 1 leans by 8°"),
])  # fmt: skip
def test_the_section_through_the_axis_names_the_followers_it_shows(name: str, lean: float, said: str) -> None:
    text = (PROFILES / f"{name}.toml").read_text()
    if lean:
        text = text[: text.index("[cutter]")].replace("root_radius = 0.8\nbore", "bore")
        text = text.replace('"cylinder"\ndiameter = 22', f'"cone"\nhalf_angle = {lean}\ndiameter = 22')
    page = report(Model(parse(text)), only=("design",))
    (drawn,) = [b for b in page.sections[0].blocks if isinstance(b, Drawing) and "cam axis" in b.caption]
    assert drawn.caption == f"Section through the cam axis{said}"
    assert any(path.kind == "ghost" for path in drawn.paths) == ("follower 1 at" in said)


def test_stock_in_a_bell_is_shown_where_there_is_a_wall() -> None:
    text = (PROFILES / "bell_lifter.toml").read_text() + '\n[cutter]\nkind = "flat"\ndiameter = 16\n'
    page = report(Model(parse(text)), only=("cutter",))
    maps = [block for block in page.sections[0].blocks if isinstance(block, Map)]
    assert [chart.caption for chart in maps] == ["Stock left, groove, flank +", "Stock left, groove, flank −"]
    for chart in maps:
        blank = np.isnan(chart.values)
        assert not blank.all(axis=1).any()
        assert blank[0].any()


def test_ways_that_go_wrong_name_no_angle_of_rounding() -> None:
    page = report(read(str(PROFILES / "conical_groove.toml")), only=("cutter",))
    table = next(block for block in page.sections[0].blocks if isinstance(block, Table) and "follows" in block.caption)
    assert table.rows[-1][-1] == 0.0
