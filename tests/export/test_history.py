"""Histories as files: their extremes are those of the result, their columns have units, their rows come back."""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np
import pytest

import camgeom
from camgeom.errors import CamgeomError, ExportError
from camgeom.export import write
from camgeom.export.history import STEP, impact_history, turn_history
from camgeom.model import Model
from camgeom.report.data.load import contact_data
from tests.places import PROFILES

ROWS = round(360.0 / STEP) + 1


@pytest.fixture(scope="module")
def pin() -> Model:
    return camgeom.read(PROFILES / "pin_insertion.toml")


@pytest.fixture(scope="module")
def rocker() -> Model:
    return camgeom.read(PROFILES / "conjugate_rocker.toml")


def test_a_turn_has_what_the_result_says_of_it(pin: Model) -> None:
    found, told = turn_history(pin), contact_data(pin)
    assert all(values.shape == (ROWS,) and np.isfinite(values).all() for values in found.values())
    assert found["time_s"][-1] == pytest.approx(0.1)
    assert found["lift_mm"].max() == 74.0
    assert found["groove_force_n"].max() == pytest.approx(told["peak_middle_force_n"], rel=1e-3)
    assert found["groove_pressure_mpa"].max() == pytest.approx(told["peak_slice_pressure_mpa"], rel=1e-3)
    assert found["groove_quoted_pressure_mpa"].max() == pytest.approx(told["peak_pressure_mpa"], rel=1e-3)
    assert np.abs(found["camshaft_torque_n_m"]).max() == pytest.approx(told["peak_torque_n_m"], rel=1e-3)
    power = found["follower_force_n"] * 1e-3 * found["velocity_mm_per_s"]
    assert power == pytest.approx(found["camshaft_torque_n_m"] * 20.0 * np.pi, abs=1e-6)


@pytest.mark.parametrize("speed", [True, False])
def test_every_follower_moves_over_the_cam_s_angle(speed: bool) -> None:
    text = (PROFILES / "two_groove_drum.toml").read_text(encoding="utf-8")
    if not speed:
        low, high = text.index("[operation]"), text.index("[material.cam]")
        kept = text[low:high].replace("[track.operation]\nfriction = 60\n", "")
        text = text[:low] + kept[kept.index("[[track]]") :] + text[text.index("[output]") :]
    model = camgeom.read(text)
    found, second, time = turn_history(model), model.bindings[1], "s" if speed else "rad"
    own = np.radians(found["cam_angle_deg"]) - second.angle
    jet = second.setup.program.jet(own, 3)
    omega = 6.0 * np.pi if speed else 1.0
    for order, name in enumerate(("velocity", "acceleration", "jerk"), start=1):
        head = f"{name}_mm_per_{time}{'' if order == 1 else order}"
        wanted = omega**order * jet[order]
        assert found[f"follower_2.{head}"] == pytest.approx(wanted, rel=1e-9, abs=1e-6 * omega**order)
    assert found["follower_2.lift_mm"] == pytest.approx(jet[0], abs=1e-9)
    assert found["lift_mm"].max() == 46.0


def test_without_a_speed_there_is_the_motion_alone() -> None:
    text = (PROFILES / "pin_insertion.toml").read_text(encoding="utf-8")
    still = camgeom.read(text[: text.index("[operation]")])
    found = turn_history(still)
    assert list(found) == ["cam_angle_deg", "lift_mm", "velocity_mm_per_rad", "acceleration_mm_per_rad2",
                           "jerk_mm_per_rad3"]  # fmt: skip


def test_both_contacts_of_a_pair_and_the_whole_force(rocker: Model) -> None:
    found = turn_history(rocker)
    both = found["main_force_n"] * found["return_force_n"]
    assert np.abs(both).max() == 0.0, "one of them presses at a time"
    assert found["follower_torque_n_m"].min() < -800.0
    assert found["follower_torque_n_m"].max() > 800.0
    assert found["main_pressure_mpa"].max() == pytest.approx(1040.64, abs=0.5)


def test_the_run_in_the_clearance(rocker: Model) -> None:
    assert rocker.impact is not None
    found = impact_history(rocker.impact, True)
    assert {len(values) for values in found.values()} == {len(found["time_s"])}
    assert found["cam_angle_deg"][-1] == pytest.approx(360.0 * len(rocker.impact.turn_times()))
    peak = rocker.impact.peak("force_main").value
    assert found["main_force_n"].max() == pytest.approx(peak, rel=1e-3)
    assert not np.any((found["driving_side"] == 0.0) & (found["main_force_n"] > 0.0))


def test_an_indexing_drive_turns_periodically_and_from_rest() -> None:
    drive = camgeom.read(PROFILES / "globoidal_drive.toml")
    found = turn_history(drive)
    assert drive.indexing is not None
    peak = float(drive.indexing.steady.peak("load_acceleration").magnitude[0])
    assert np.abs(found["periodic.load_acceleration_rad_s2"]).max() == pytest.approx(peak, rel=1e-3)
    peak = float(drive.indexing.start.peak("load_acceleration").magnitude[0])
    assert np.abs(found["from_rest.load_acceleration_rad_s2"]).max() == pytest.approx(peak, rel=1e-3)
    shared = sum(found[f"roller_{k}_force_n"] for k in (1, 2, 3))
    assert shared.max() > 0.0


def test_rows_come_back(pin: Model, rocker: Model, tmp_path: Path) -> None:
    write(pin, tmp_path / "pin.history.csv")
    with (tmp_path / "pin.history.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    found = turn_history(pin)
    assert [float(row["lift_mm"]) for row in rows] == found["lift_mm"].tolist()
    pyarrow = pytest.importorskip("pyarrow.parquet")
    write(rocker, tmp_path / "rocker.impact.parquet")
    table = pyarrow.read_table(tmp_path / "rocker.impact.parquet")
    assert rocker.impact is not None
    assert table["time_s"].to_pylist() == impact_history(rocker.impact, True)["time_s"].tolist()


def test_what_cannot_be_is_said(pin: Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ExportError, match=r"no \[impact\]"):
        write(pin, tmp_path / "pin.impact.csv")
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(CamgeomError, match=r"pip install 'camgeom\[parquet\]'"):
        write(pin, tmp_path / "pin.history.parquet")
    assert not list(tmp_path.iterdir())
