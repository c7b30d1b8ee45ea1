"""What the report tells of a follower in its clearance and of an indexing drive's first turn and powers."""

from __future__ import annotations

import numpy as np
import pytest

import camgeom
from camgeom.drawing.content import Chart, Table, Text
from camgeom.model import Model
from camgeom.report.data.solved import impact_data
from camgeom.report.sections.impact import impacts, studies
from camgeom.report.sections.indexing import balance, from_rest, torsion
from tests.places import PROFILES

ASKED = 'study = [0.01, 0.1]\nlaws = ["3-4-5", "modified-trapezoid"]'


def rocker(more: str = "") -> Model:
    text = (PROFILES / "conjugate_rocker.toml").read_text(encoding="utf-8").replace("turns = 3", "turns = 2")
    return camgeom.read(text.replace("[impact]", f"[impact]\n{more}\n#"))


def drive(more: str = "") -> Model:
    text = (PROFILES / "globoidal_drive.toml").read_text(encoding="utf-8")
    return camgeom.read(text.replace("[dynamics]", f"[dynamics]\n{more}\n#"))


def test_position_and_velocity_stand_beside_the_motion_without_play() -> None:
    model = rocker()
    assert model.impact is not None
    turn, portrait = impacts(model.impact, True)[:2]
    assert isinstance(turn, Chart)
    assert [panel.y.label for panel in turn.panels[:3]] == ["Position", "Velocity", "Acceleration"]
    for panel in turn.panels[:3]:
        assert {series.name for series in panel.series} == {"with play", "without play"}
    position = {series.name: series.y for series in turn.panels[0].series}
    assert position["without play"].max() == pytest.approx(24.0, abs=1e-6)
    assert position["with play"].max() == pytest.approx(24.0, abs=0.1)
    assert isinstance(portrait, Chart)
    assert [series.name for series in portrait.panels[0].series] == ["turn 1", "turn 2"]


def test_studies_are_drawn_where_they_are_asked_for() -> None:
    assert studies(rocker()) == ()
    model = rocker(ASKED)
    clearances, overlaid, compared = studies(model)
    told = impact_data(model)
    assert isinstance(clearances, Chart)
    line = clearances.panels[0].series[0]
    assert line.x.tolist() == pytest.approx([0.01, 0.1])
    assert line.y.tolist() == [row["peak_acceleration_rad_s2"]["mean"] for row in told["study"]]
    assert isinstance(overlaid, Chart)
    for series, row in zip(overlaid.panels[0].series, told["laws"]):
        assert series.name == row["label"]
        assert np.abs(series.y).max() == pytest.approx(row["peak_acceleration_rad_s2"]["mean"], rel=2e-3)
    assert isinstance(compared, Table)
    assert [row[0] for row in compared.rows] == ["3-4-5", "modified-trapezoid"]


def test_all_torsional_modes_and_the_first_turn() -> None:
    study = drive().indexing
    assert study is not None
    modes, start = torsion(study.modes), from_rest(study)
    assert len(modes.panels) == 3
    assert modes.panels[2].series[0].y.max() == pytest.approx(3408.347, abs=1e-2)
    lines = {series.name: series for series in start.panels[0].series}
    peak = float(study.start.peak("load_acceleration").magnitude[0])
    assert np.abs(lines["first turn from rest"].y).max() == pytest.approx(peak, rel=1e-3)
    assert lines["first turn from rest"].y[0] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("exact", [False, True])
def test_powers_balance_and_why(exact: bool) -> None:
    study = drive(f"exact_contact = {str(exact).lower()}").indexing
    assert study is not None
    found, text = study.summary(), balance(study)
    whole = [float(str(found[f"{name}_power_w"])) for name in ("input", "applied", "linearisation", "dissipated")]
    assert sum(whole[:3]) == pytest.approx(whole[3], rel=1e-5)
    assert (whole[2] == 0.0) is exact
    assert isinstance(text, Text)
    assert ("The linearised contact adds" in " ".join(text.paragraphs)) is not exact
    assert ("linearisation" in str(found["power_balance_is"])) is not exact
