"""Loads and vibrations on the page: turrets, planar cams without rollers, elastic followers; one section alone."""

from __future__ import annotations

import json
import subprocess
import sys
from math import pi, radians
from pathlib import Path

import numpy as np
import pytest

from camgeom.checks.verdict import ENDLESS_H
from camgeom.drawing.content import Block, Chart, Map, Page, Table, Text
from camgeom.drawing.plots import NARROW, WIDE
from camgeom.drawing.sheet import overlap
from camgeom.dynamics.follower.study import FollowerStudy
from camgeom.dynamics.follower.train import FollowerTrain
from camgeom.model import Model, read
from camgeom.motion import Program, Segment
from camgeom.profile import parse
from camgeom.report.page import sheet
from camgeom.report.sections import report
from camgeom.report.sections.dynamics import SEEN, elastic, residual, stretches
from tests.places import PROFILES, ROOT


def _page(profile: str, *sections: str, change: tuple[str, str] = ("", "")) -> tuple[Model, Page]:
    text = (PROFILES / f"{profile}.toml").read_text(encoding="utf-8")
    model = Model(parse(text.replace(*change))) if change[0] else read(str(PROFILES / f"{profile}.toml"))
    return model, report(model, sections)


def _blocks(page: Page) -> list[Block]:
    return [block for section in page.sections for block in section.blocks]


def _charts(page: Page) -> list[Chart]:
    return [block for block in _blocks(page) if isinstance(block, Chart)]


def _readable(page_blocks: list[Block] | tuple[Block, ...]) -> None:
    for plot in page_blocks:
        if isinstance(plot, Chart | Map):
            for width in (WIDE, NARROW):
                drawn = sheet(plot, width)
                for i, (box, text) in enumerate(drawn.words):
                    assert box[0] > -1.5, text
                    assert box[2] < drawn.width + 1.5, text
                    assert [t for b, t in drawn.words[i + 1 :] if overlap(box, b, -1.5) > 30.0] == [], text


def _value(table: Table, label: str) -> object:
    return next(row[1] for row in table.rows if row[0] == label)


def test_turret_shows_how_its_rollers_share_the_load() -> None:
    model, page = _page("tool_changer", "contact", "fatigue")
    duty = model.turret_duty
    _readable(_blocks(page))
    torque, force, sharing, pressure, _ = _charts(page)[0].panels
    total = np.sum([series.y for series in force.series], axis=0)
    assert total == pytest.approx(duty.roller_load.sum(axis=1))
    assert float(np.abs(torque.series[0].y).max()) == pytest.approx(float(np.abs(duty.turret_torque).max()) * 1e-3)
    assert {float(y) for y in sharing.series[0].y} == {0.0, 1.0, 2.0}
    assert pressure.marks[0].y == pytest.approx(duty.peak_pressure.value)
    shown = next(block for block in _blocks(page) if isinstance(block, Map))
    assert np.nanmax(shown.values) == pytest.approx(duty.peak_pressure.value, rel=0.02)
    figures = {figure.label: figure.value for figure in page.figures}
    assert figures["Peak contact pressure"] == pytest.approx(duty.peak_pressure.value)
    assert duty.roller_life > ENDLESS_H
    assert figures["Roller life"] == "unlimited"


def test_slices_of_a_turret_roller_live_no_shorter_than_the_roller() -> None:
    duty = read(str(PROFILES / "two_start.toml")).turret_duty
    assert duty.slice_life.min() == duty.roller_life
    assert duty.slice_life.shape == duty.engagement.stations.shape


@pytest.mark.parametrize("profile", ["disc_flat_face", "constant_width_press", "disc_offset_roller"])
def test_planar_cam_shows_force_and_pressure_of_every_touch(profile: str) -> None:
    model, page = _page(profile, "contact", "flank")
    _readable(_blocks(page))
    drive = model.drive
    lines = next(chart for chart in _charts(page) if "Contact of cam" in chart.caption)
    force, pressure, torque = lines.panels
    assert [series.name for series in force.series] == [touch.name for touch in drive.touches]
    top = max(float(series.y.max()) for series in force.series)
    assert top == pytest.approx(drive.contact_data()["peak_force_n"], rel=1e-5)
    assert drive.peak_pressure is not None
    hardest = model.duty if model.duties else drive
    assert pressure.marks[0].y == pytest.approx(hardest.peak_pressure.value)
    assert float(np.abs(torque.series[0].y).max()) <= abs(torque.marks[0].y) * (1 + 1e-9)
    assert "Peak contact force" in {figure.label for figure in page.figures}


def test_follower_that_leaves_its_cam_is_said_to() -> None:
    _, page = _page("disc_flat_face", "contact", change=("speed = 900", "speed = 2400"))
    texts = [p for block in _blocks(page) if isinstance(block, Text) for p in block.paragraphs]
    assert any("leaves the cam from" in text and "holds up to 1865 r/min" in text for text in texts)
    assert any(zone.label == "no contact" for zone in _charts(page)[0].zones)
    _readable(_blocks(page))
    _, kept = _page("disc_flat_face", "contact")
    assert any("keep the follower" in p for b in _blocks(kept) if isinstance(b, Text) for p in b.paragraphs)


def test_pair_shows_its_residual() -> None:
    model, page = _page("conjugate_rocker", "flank")
    chart = next(chart for chart in _charts(page) if "return roller" in chart.caption)
    assert model.pair is not None
    assert float(chart.panels[0].series[0].y.min()) == pytest.approx(model.pair.least)
    _readable(_blocks(page))


def _program(*steps: tuple[float, float | None]) -> Program:
    return Program.from_segments(
        [Segment(radians(until)) if to is None else Segment(radians(until), to, "cycloidal") for until, to in steps]
    )


def test_moves_that_end_in_a_dwell_are_found_also_over_the_end_of_the_turn() -> None:
    moves = stretches(_program((60, None), (150, 5.0), (200, None), (290, 0.0), (360, None)))
    assert [(round(np.degrees(m.start)), round(np.degrees(m.end)), m.size) for m in moves] == [
        (60, 150, 5.0),
        (200, 290, 5.0),
    ]
    around = stretches(_program((30, 8.0), (120, None), (300, 3.0), (330, None), (360, 0.0)))
    assert sorted((round(np.degrees(m.start)), round(np.degrees(m.end))) for m in around) == [(120, 300), (330, 390)]
    assert stretches(_program((180, 4.0), (360, 0.0))) == ()


def test_residual_is_the_closed_form_of_the_cycloidal_law() -> None:
    program = _program((60, None), (150, 5.0), (200, None), (290, 0.0), (360, None))
    train = FollowerTrain(mass=2.0, stiffness=2.0 * (2.0 * pi * 100.0) ** 2, preload=500.0)
    study = FollowerStudy(train, program, 20.0 * pi)
    chart = residual(study, program, False)
    assert chart is not None
    rise, back = chart.panels[0].series
    n = 0.25 / (rise.x / 60.0) * 100.0  # time of 90 deg over the natural period
    wanted = 5e3 * np.abs(np.sin(pi * n)) / (pi * n * np.abs(n * n - 1.0))
    assert rise.y == pytest.approx(wanted, rel=1e-6, abs=1e-9)
    assert back.y == pytest.approx(rise.y, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize(("share", "shown"), [(0.999, True), (1.001, False)])
def test_a_residual_too_small_to_see_is_not_drawn(share: float, shown: bool) -> None:
    """A quarter turn at a quarter of 600 r/min takes 0.1 s."""
    program = _program((60, None), (150, 5.0), (200, None), (290, 0.0), (360, None))
    train = FollowerTrain(mass=2.0, stiffness=2.0 * (2.0 * pi * share * SEEN / 0.1) ** 2, preload=500.0)
    assert (residual(FollowerStudy(train, program, 20.0 * pi), program, False) is not None) is shown


@pytest.mark.parametrize(("preload", "lost"), [(600.0, False), (20.0, True)])
def test_elastic_follower_shows_its_response_and_its_flight(preload: float, lost: bool) -> None:
    program = _program((60, None), (150, 5.0), (200, None), (290, 0.0), (360, None))
    train = FollowerTrain(mass=1.0, stiffness=4e5, damping=40.0, return_stiffness=4e3, preload=preload)
    study = FollowerStudy(train, program, 60.0, sweep_speeds=np.array([30.0, 60.0, 90.0]))
    blocks = elastic(study, program, False)
    _readable(blocks)
    charts = [block for block in blocks if isinstance(block, Chart)]
    acceleration = charts[0].panels[0]
    assert abs(acceleration.marks[0].y) == pytest.approx(float(study.steady.peak("acceleration").magnitude[0]))
    assert any("Flight" in chart.caption for chart in charts) is lost
    table = next(block for block in blocks if isinstance(block, Table) and "numbers" in block.caption)
    assert _value(table, "Contact kept") is not lost
    assert any("cam speed" in chart.caption for chart in charts)


def _run(*words: str) -> str:
    code = (
        "import sys; from camgeom.cli import main; status = main(sys.argv[1:]);"
        "print(status, sorted({m.split('.')[0] for m in sys.modules} & "
        "{'scipy', 'trimesh', 'pyvista', 'vtk', 'PIL', 'meshio', 'matplotlib', 'ezdxf', 'manifold3d'}),"
        "'camgeom.mechanics.face_duty' in sys.modules, 'camgeom.solid.drum' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, check=True, cwd=ROOT)
    return done.stdout


def test_report_of_one_section_writes_and_computes_only_that(tmp_path: Path) -> None:
    profile = str(PROFILES / "pin_insertion.toml")
    out = _run("report", profile, "--only", "motion,parameters", "--out", str(tmp_path), "--explain")
    assert out.splitlines()[-1].startswith("0 [] False")
    html = (tmp_path / "report.html").read_text(encoding="utf-8")
    keys = ("motion", "parameters", "contact", "solid", "checks")
    assert [key for key in keys if f'<section id="{key}">' in html] == ["motion", "parameters"]
    result = json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))
    assert set(result["cost_s"]) <= {"setup", "tracks", "report"}
    assert "contact" not in result


def test_report_of_the_checks_gives_the_verdict_and_the_exit_status(tmp_path: Path) -> None:
    out = _run("report", str(PROFILES / "disc_flat_face.toml"), "--only", "checks", "--out", str(tmp_path))
    assert out.splitlines()[-1].startswith("0 ")
    result = json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))
    assert result["checks"]
    assert "Passes what was judged" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_unknown_section_is_refused_with_the_nearest_one(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "camgeom", "report", str(PROFILES / "two_start.toml"), "--only", "motoin"],
        capture_output=True, text=True, check=False, cwd=ROOT,
    )  # fmt: skip
    assert done.returncode == 2
    assert "did you mean 'motion'?" in done.stderr


JUDGED = ["conjugate_rocker", "disc_offset_roller", "parallel_index", "tool_changer", "two_start"]


@pytest.mark.parametrize("profile", JUDGED)
def test_pressure_angle_at_the_head_is_the_one_that_is_judged(profile: str) -> None:
    model, page = _page(profile, "checks", "flank")
    judged = next(finding for finding in page.findings if finding.check == "Pressure angle")
    shown = next(figure for figure in page.figures if figure.label == "Largest pressure angle")
    assert shown.value == pytest.approx(judged.value)
    for table in (block for block in _blocks(page) if isinstance(block, Table)):
        for i, column in enumerate(table.columns):
            if column.label == "Cam angle":
                angles = [row[i] for row in table.rows if isinstance(row[i], float)]
                assert all(0.0 <= angle <= 360.0 for angle in angles), (model.profile.name, table.caption)


def test_groove_of_a_roller_that_stays_for_several_turns_is_developed_over_one() -> None:
    _, page = _page("barrel_indexer", "design")
    chart = next(chart for chart in _charts(page) if "developed" in chart.caption)
    panel = chart.panels[0]
    assert panel.y.low == pytest.approx(-39.0)
    assert panel.y.high == pytest.approx(39.0)
    for series in panel.series:
        assert series.x.min() > -5.0
        assert series.x.max() < 365.0
    edges = [series for series in panel.series if series.name == "edges"]
    assert {round(float(np.interp(300.0, series.x, series.y))) for series in edges if series.x.max() > 300.0} == {
        -44, -14, 14, 44,
    }  # fmt: skip
