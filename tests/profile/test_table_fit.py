"""How near the motion runs to the rows of a table: told, judged, and as near as the profile states."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camgeom.checks import judge
from camgeom.errors import ProfileError
from camgeom.model import Model, read
from camgeom.motion.measured import file_rows
from camgeom.report.data.geometry import motion_data


def steps(count: int, noise: float = 0.0) -> list[list[float]]:
    """Two cycloidal steps of 10 mm with a rest between them, over 90 deg."""
    x = np.linspace(0.0, 1.0, count)
    part = np.clip(np.where(x < 0.5, x / 0.4, (x - 0.6) / 0.4), 0.0, 1.0)
    lift = 10.0 * (part - np.sin(2.0 * np.pi * part) / (2.0 * np.pi)) + np.where(x < 0.5, 0.0, 10.0)
    lift[1:-1] += noise * np.random.default_rng(1).standard_normal(count - 2)
    return [[float(a), float(b)] for a, b in zip(90.0 * x, lift)]


def made(rows: list[list[float]], **more: Any) -> Model:
    return read({
        "cam": {"kind": "disc", "base_radius": 60.0, "width": 14.0}, "follower": {"kind": "translating"},
        "roller": {"shape": "cylinder", "diameter": 20.0, "length": 12.0},
        "motion": [{"until": 90.0, "to": 20.0, "law": "table", "rows": rows, **more}, {"until": 180.0},
                   {"until": 300.0, "to": 0.0, "law": "3-4-5"}, {"until": 360.0}],
    })  # fmt: skip


def level(model: Model) -> str:
    return judge(model, ("table",)).findings[0].level


def test_a_table_that_cannot_be_followed_is_told_and_fails() -> None:
    rows = steps(13)
    model = made(rows)
    [one] = model.tables
    angle, lift = np.radians(np.array(rows)[:, 0]), np.array(rows)[:, 1]
    off = np.abs(model.setup.program.jet(angle, 0)[0] - lift)
    assert one.largest == (pytest.approx(off.max()), pytest.approx(float(angle[off.argmax()])))
    assert off.max() > 0.3
    assert level(model) == "fail"
    data = motion_data(model)
    assert data["table_distance_mm"] == data["tables"][0]["largest_mm"] == one.largest[0]
    assert "table_distance_mm" not in motion_data(read("profiles/disc_flat_face.toml"))
    assert not judge(read("profiles/disc_flat_face.toml"), ("table",)).findings


def test_how_rows_are_laid_on_the_segment_is_told() -> None:
    """Angles in radians, or lifts from another zero, were followed within rounding, and nothing said that they had been
    stretched and moved."""
    plain, far = steps(31), [[np.radians(angle), lift + 5.0] for angle, lift in steps(31)]
    assert made(plain).tables[0].laid == ""
    model = made(far, smoothing=0)
    told = judge(model, ("table",)).findings[0]
    assert told.where == "motion[0], 31 rows, angles 57.2958 times as wide, lifts -5"
    one = motion_data(model)["tables"][0]
    assert one["stretch"] == pytest.approx(np.degrees(1.0))
    assert one["shift_mm"] == pytest.approx(-5.0)
    assert made([[1.0009 * angle, lift] for angle, lift in plain]).tables[0].laid == ""
    assert "0.99891" in made([[1.00109 * angle, lift] for angle, lift in plain]).tables[0].laid


@pytest.mark.parametrize("count", [9, 13, 31, 91])
@pytest.mark.parametrize("order", [1, 2, 3])
def test_rows_without_scatter_are_run_through(count: int, order: int) -> None:
    model = made(steps(count), smoothing=0, order=order)
    assert model.tables[0].largest[0] < 1e-9 * 20.0
    assert level(model) == "pass"


@pytest.mark.parametrize(
    ("smoothing", "knots", "wanted"),
    [(0.02, 100, "pass"), (0.001, 400, "pass"), (0.0, 400, "pass"), (0.001, 100, "fail"), (0.0, 100, "fail")],
)
def test_the_distance_is_the_stated_scatter(smoothing: float, knots: int, wanted: str) -> None:
    """Where there may be as many knots as it takes."""
    model = made(steps(181, 0.02), smoothing=smoothing, knots=knots)
    assert (model.tables[0].rms <= 1.2 * smoothing + 1e-9) == (wanted == "pass")
    assert level(model) == wanted


def test_too_few_knots_fail() -> None:
    assert level(made(steps(91), smoothing=0, knots=2)) == "fail"
    assert level(made(steps(91), smoothing=0.2, knots=2)) == "pass"
    assert level(made(steps(91))) == "pass"


def test_a_first_line_with_a_number_is_no_heading(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text("angle,lift\n0,0\n1,2\n")
    assert file_rows(path) == [(0.0, 0.0), (1.0, 2.0)]
    path.write_text("0 deg,0\n1,2\n")
    with pytest.raises(ProfileError, match="row 1 is not two numbers"):
        file_rows(path)
