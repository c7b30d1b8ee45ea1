"""The page of a study: lines or a map, limits, units, samples, and what is left out said."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from camgeom.cli.study_page import MOST_LINES, page, unit_of
from camgeom.design.sampling import Plan, tie
from camgeom.design.study import Row, Study, axis
from camgeom.drawing.content import Block, Chart, Map, Text
from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.profile.text import load
from camgeom.report.measured import _flat

TEXT = """
[cam]
kind = "disc"
base_radius = 40
width = 12
[follower]
kind = "translating"
mass = 1
[roller]
shape = "cylinder"
diameter = 16
length = 12
[[motion]]
until = 120
to = 10
law = "cycloidal"
[[motion]]
until = 240
to = 0
law = "cycloidal"
[[motion]]
until = 360
[operation]
speed = 100
spring_preload = 200
[limits]
contact_pressure_mpa = 1234
"""
PRESSURE = "contact.peak_slice_pressure_mpa"


def nothing(model: Model) -> tuple[dict[str, float | int | bool | str | None], str, str]:
    del model
    return {}, "pass", ""


def made(*texts: str, plan: Plan | None = None) -> Study:
    axes = plan.axes if plan is not None else tuple(map(axis, texts))
    return Study(load(TEXT, "disc.toml")[0], "", axes, nothing, plan=plan)


def rows(study: Study, key: str = PRESSURE) -> list[Row]:
    return [Row(v, {key: float(i)}, "pass") for i, v in enumerate(study.values(range(len(study))))]


def blocks(study: Study, *figures: str) -> tuple[Block, ...]:
    return page(study, rows(study, *figures[:1]), "x", figures=figures).sections[0].blocks


def test_a_line_has_its_limit_its_unit_and_its_samples() -> None:
    chart = blocks(made("operation.speed=100:300:3"))[0]
    assert isinstance(chart, Chart)
    assert (chart.x.label, chart.x.unit) == ("operation.speed", "r/min")
    (panel,) = chart.panels
    assert [limit.value for limit in panel.limits] == [1234.0]
    line, samples = panel.series
    assert (line.dots, samples.dots) == (False, True)
    assert line.y.tolist() == samples.y.tolist() == [0.0, 1.0, 2.0]


def test_a_limit_that_is_varied_is_no_line() -> None:
    chart = blocks(made("limits.contact_pressure_mpa=1000:2000:3"))[0]
    assert isinstance(chart, Chart)
    assert chart.panels[0].limits == ()


def test_keys_that_are_tied_leave_the_lines() -> None:
    plan = Plan((axis("cam.base_radius=40:60:3"),), ties=(tie("roller.diameter=cam.base_radius/4"),))
    chart = blocks(made(plan=plan))[0]
    assert isinstance(chart, Chart)
    assert chart.panels[0].series[0].x.tolist() == [40.0, 50.0, 60.0]


def test_drawn_variants_are_points() -> None:
    plan = Plan((axis("cam.base_radius=40:60", drawn=True),), "sobol", 8)
    chart = blocks(made(plan=plan))[0]
    assert isinstance(chart, Chart)
    assert all(series.dots and len(series.x) == 8 for series in chart.panels[0].series)


@pytest.mark.parametrize("many", [6, 7])
def test_many_settings_of_a_second_even_key_are_a_map(many: int) -> None:
    found = blocks(made("cam.base_radius=40:60:8", f"operation.speed=100:300:{many}"))[0]
    assert isinstance(found, Chart if many == 6 else Map)
    if isinstance(found, Map):
        assert found.values.shape == (7, 8)
        assert found.values[1, 0] == 1.0
        assert "limit 1234 MPa" in found.caption
        assert found.x.unit == "mm"


def test_what_is_left_out_is_told() -> None:
    texts = ("operation.speed=100:300:6", "cam.width=12:20:5", "roller.diameter=10:20:5")
    chart = blocks(made(*texts))[0]
    assert isinstance(chart, Chart)
    assert len({series.name for series in chart.panels[0].series}) == MOST_LINES
    assert f"the first {MOST_LINES} of 25 settings of the other keys, study.csv has them all" in chart.caption


def test_figures_asked_for_are_drawn_by_their_names() -> None:
    chart = blocks(made("operation.speed=100:300:3"), "fatigue.conventions.published.roller_life_h")[0]
    assert isinstance(chart, Chart)
    assert (chart.panels[0].y.label, chart.panels[0].y.unit) == ("conventions, published, roller life", "h")


def test_too_many_rows_for_the_page_are_said() -> None:
    from collections import Counter

    study = made("operation.speed=100:300:3")
    first = page(study, rows(study), "x", counts=Counter({"pass": 5})).sections[0].blocks[0]
    assert isinstance(first, Text)
    assert "Not drawn: 5 variants" in first.paragraphs[0]


def test_units_of_keys() -> None:
    profile = from_data(load(TEXT, "disc.toml")[0])
    wanted = {"cam.base_radius": "mm", "operation.speed": "r/min", "material.cam.contact_limit": "MPa",
              "follower.mass": "kg", "limits.pressure_angle_deg": "°", "material.cam.poisson": ""}  # fmt: skip
    assert {key: unit_of(profile, axis(f"{key}=1").path) for key in wanted} == wanted
    assert unit_of(profile, axis("motion[0].until=1").path) == "°"
    assert unit_of(None, ("cam", "width")) == ""


def test_short_lists_are_columns_and_long_ones_are_not() -> None:
    data = {"frequencies_hz": [1.0, 2.0], "sweep": list(np.arange(7.0)), "deep": {"on": True}, "name": "x"}
    assert _flat(data, "dynamics") == {
        "dynamics.frequencies_hz.1": 1.0, "dynamics.frequencies_hz.2": 2.0, "dynamics.deep.on": True,
    }  # fmt: skip


def test_every_line_that_fits_is_drawn() -> None:
    laws = "motion[0].law=" + ",".join(("cycloidal", "3-4-5", "modified-sine", "4-5-6-7", "modified-trapezoid"))
    study = made("operation.speed=100:300:5", laws, "cam.width=12:20:4")
    chart = blocks(study)[0]
    assert isinstance(chart, Chart)
    assert len({series.name for series in chart.panels[0].series}) == 20 == len(list(product(range(5), range(4))))
    assert "settings" not in chart.caption
