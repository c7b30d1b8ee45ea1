"""The parts of what a follower needs: they add up, and nothing stands for what there is none of."""

from __future__ import annotations

import numpy as np
import pytest

import camgeom
from camgeom.drawing.content import Series
from camgeom.model import Model
from camgeom.report.sections.load import force_parts
from tests.places import PROFILES


def parts(model: Model) -> dict[str, Series]:
    (chart,) = force_parts(model)
    return {series.name: series for series in chart.panels[0].series}


@pytest.mark.parametrize(
    ("name", "names"),
    [
        ("pin_insertion", {"inertia", "friction", "applied", "sum"}),
        ("disc_flat_face", {"inertia", "spring and weight", "sum"}),
        ("conjugate_rocker", {"inertia", "sum"}),
        ("tool_changer", {"inertia", "friction", "sum"}),
    ],
)
def test_parts_add_up(name: str, names: set[str]) -> None:
    found = parts(camgeom.read(PROFILES / f"{name}.toml"))
    assert set(found) - {"friction", "applied"} <= names
    total = np.sum([series.y for key, series in found.items() if key != "sum"], axis=0)
    assert total == pytest.approx(found["sum"].y, abs=1e-7 * np.abs(found["sum"].y).max())


def test_the_pin_takes_its_force_while_it_goes_in() -> None:
    applied = parts(camgeom.read(PROFILES / "pin_insertion.toml"))["applied"]
    inside = (applied.x > 255.4) & (applied.x < 279.9)
    assert np.all(applied.y[inside] > -1e-9)
    assert applied.y[inside].max() == pytest.approx(21.5, abs=0.5)
    assert np.abs(applied.y[(applied.x < 255.2) | (applied.x > 280.1)]).max() < 1e-9


def test_without_a_load_there_is_none() -> None:
    text = (PROFILES / "pin_insertion.toml").read_text(encoding="utf-8")
    assert force_parts(camgeom.read(text[: text.index("[operation]")])) == ()
