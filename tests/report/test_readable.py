"""What a reader stumbled over: signs that a typeface lacks, powers that a figure beside them has not, faces too small,
one thing told twice, silence in a pipe."""

from __future__ import annotations

import numpy as np
import pytest

import camgeom
from camgeom.cli import Console, main
from camgeom.cli import model as commands
from camgeom.drawing.content import Level, Page, Table
from camgeom.drawing.sheet import ticks
from camgeom.maths.frozen import Ledger
from camgeom.maths.mesh import Mesh
from camgeom.model import Model
from camgeom.report.page import verdict_box
from camgeom.report.sections.bodies import face_bodies
from camgeom.report.sections.design import across
from camgeom.report.sections.life import life
from camgeom.report.sections.motion import segments
from tests.places import BARE, PROFILES


@pytest.fixture(scope="module")
def flat() -> Model:
    return camgeom.read(PROFILES / "disc_flat_face.toml")


@pytest.fixture(scope="module")
def turret() -> Model:
    return camgeom.read(PROFILES / "two_start.toml")


def _page(*omitted: tuple[str, str]) -> Page:
    return Page("cam", "disc cam", Level.PASS, "", (), (), (), (), omitted)


def test_what_one_check_leaves_open_stands_under_one_heading() -> None:
    box = verdict_box(_page(("Hardness", "give a.hardness, HRC: taken as it stands"),
                            ("Hardness", "give b.hardness, HRC: taken as it stands"), ("Film", "give c")))  # fmt: skip
    assert box.count("<h3>Hardness</h3>") == 1
    assert "Not judged: give a.hardness, HRC and b.hardness, HRC: taken as it stands." in box
    assert "3 not judged" in box
    other = verdict_box(_page(("Life", "give a: one"), ("Life", "give b: two")))
    assert "give a: one; give b: two." in other


def test_ticks_leave_out_a_power_only_where_figures_have_one_too() -> None:
    assert ticks(-5e5, 5e5, 4).exponent == 0
    assert ticks(0.0, 0.03, 4).exponent == 0
    assert ticks(0.0, 9e7, 4).exponent == 6
    assert ticks(0.0, 4e-5, 4).exponent != 0


def test_pictures_have_signs_for_every_label() -> None:
    font = pytest.importorskip("PIL.ImageFont").load_default(24)
    from camgeom.report.overlay import _runs

    lacking = bytes(font.getmask("\N{MINUS SIGN}"))
    runs = _runs("Curvature, 10⁻³ × 1/mm² −1.5 µm ⌀ 3 – °")
    assert [text for text, raised in runs if raised] == ["-3", "2"]
    for sign in {sign for text, _ in runs for sign in text} - {" "}:
        assert bytes(font.getmask(sign)) != lacking, sign


def test_a_flat_face_is_as_wide_as_stated_wherever_it_is_looked_at(flat: Model) -> None:
    for phi in (np.zeros(1), np.linspace(0.0, 6.0, 31)):
        ((_, mesh, _),) = face_bodies(flat, phi)
        assert np.ptp(mesh.vertices[:, 1]) == pytest.approx(32.0)
    ((_, open_, _),) = face_bodies(flat.with_(follower__face_width=None), np.zeros(1))
    assert flat.planar is not None
    needed = flat.planar.face_needed
    assert needed is not None
    assert np.ptp(open_.vertices[:, 1]) > needed.value


@pytest.mark.parametrize("stated", [40.0, 200.0])
def test_the_faces_of_a_frame_are_as_wide_as_stated_and_it_clears_the_cam(stated: float) -> None:
    model = camgeom.read(PROFILES / "constant_width_press.toml").with_(**BARE, follower__face_width=stated)
    ((_, mesh, _),) = face_bodies(model, np.zeros(1))
    near = mesh.vertices[np.abs(mesh.vertices[:, 0]) < 1e-9]
    assert np.ptp(near[:, 1]) == pytest.approx(stated)
    assert mesh.watertight
    assert model.planar is not None
    assert np.ptp(mesh.vertices[:, 1]) > model.mechanism.envelope[0]


def test_laws_keep_the_hyphens_of_their_numbers(flat: Model) -> None:
    assert "4-5-6-7" in {row[3] for row in segments(flat).rows}


def test_a_life_is_told_in_one_table(turret: Model) -> None:
    tables = [block for block in life(turret) if isinstance(block, Table)]
    (lives,) = [table for table in tables if any(column.label == "Life" for column in table.columns)]
    parts = [(row[0], row[1]) for row in lives.rows]
    assert len(parts) == len(set(parts))
    assert any("take turns" in str(row[3]) for row in lives.rows)


def test_pressure_on_the_walls_of_a_turret_cam(turret: Model) -> None:
    duty = turret.turret_duty
    assert duty is not None
    index, turn = duty.engagement.places[0]
    phi = duty.theta + 2.0 * np.pi * turn
    both = [duty.pressure_at(index, phi, duty.engagement.stations, np.full(len(phi), wall)) for wall in (0, 1)]
    assert np.allclose(both[0] + both[1], duty.pressure[:, 0], rtol=1e-12)
    assert not np.any((both[0] > 0.0) & (both[1] > 0.0))
    beyond = duty.pressure_at(index, phi + 200.0 * np.pi, duty.engagement.stations, np.zeros(len(phi), dtype=int))
    assert not beyond.any()


def test_files_and_pictures_are_booked_beside_facts() -> None:
    seen: list[tuple[str, str]] = []
    ledger = Ledger(lambda event, name, seconds: seen.append((event, name)))
    assert ledger.book("png.cam", lambda: 7) == 7
    assert set(ledger.costs) == {"png.cam"}
    assert seen == [("start", "png.cam"), ("done", "png.cam")]


def test_a_pipe_is_told_seldom_and_a_short_run_never(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = {"now": 0.0}
    told: list[str] = []
    monkeypatch.setattr(commands, "perf_counter", lambda: clock["now"])
    monkeypatch.setattr(Console, "err", lambda _, text: told.append(text))
    observer = commands.ProgressObserver(Console())
    for now in (0.5, 9.9, 10.1, 12.0, 19.9, 20.2):
        clock["now"] = now
        observer("start", f"fact_at_{now}", 0.0)
    assert [line.split()[-2] for line in told] == ["10.1", "20.2"]
    assert told[0].startswith("camgeom:")


def test_help_names_every_format(capsys: pytest.CaptureFixture[str]) -> None:
    from camgeom.report.files import format_rows

    assert main(["run", "--help"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert all(row["format"] in text for row in format_rows())
    assert "<formats" not in text




def test_peaks_of_a_segment_are_its_own_at_its_ends_too() -> None:
    """A simple harmonic rise has its largest acceleration where it begins; the dwell beside it has none."""
    press = camgeom.read(PROFILES / "constant_width_press.toml")
    rise, dwell = segments(press).rows[:2]
    assert rise[-1] == pytest.approx(0.9789036, rel=1e-6)
    assert dwell[-2:] == (0.0, 0.0)


def test_the_level_of_a_section_is_told_without_the_hair_that_keeps_edges_out_of_it() -> None:
    press = camgeom.read(PROFILES / "constant_width_press.toml")
    lowered = Mesh(press.solid.mesh.vertices - np.array([0.0, 0.0, 8.0]), press.solid.mesh.faces)
    assert "Section at z = 0 mm," in across(press, (("cam", lowered),)).caption
    assert "Section at z = 8 mm," in across(press, (("cam", press.solid.mesh),)).caption
