"""The hardest direction of an error is that of the figure asked: of a motion, of a pressure."""

from __future__ import annotations

import numpy as np
import pytest

from camgeom.model import Model
from camgeom.profile import parse
from camgeom.tolerance.study import ToleranceStudy
from tests.places import ROOT


def _tolerances(name: str) -> ToleranceStudy:
    text = (ROOT / "profiles" / f"{name}.toml").read_text()
    return Model(parse(text.partition("[tolerance]")[0])).tolerances


@pytest.mark.parametrize(
    ("name", "error", "before"),
    [
        ("tool_changer", "turret_wobble_arcmin", 1.459),
        ("two_start", "turret_wobble_arcmin", 2.987),
        ("conical_indexer", "turret_wobble_arcmin", 2.154),
        ("disc_face_groove", "cam_wobble_arcmin", 2.3586),
    ],
)
def test_no_direction_of_an_error_presses_harder_than_is_told(name: str, error: str, before: float) -> None:
    """That to which the pressures of its parts point told up to 3.5 % less than another one does."""
    table = _tolerances(name).sensitivities
    row = next(row for row in table.rows if row.cause.key == error)
    assert table.hard is not None
    assert row.pressure is not None
    seated, packed = table.seated, table.seated.packed
    walls, square = packed.walls, packed.square
    one, other = row.size * row.cause.scale * packed.taken(seated.flat(seated.approaches.of(row.cause)))
    found = max(
        float(np.sqrt((walls.forces(np.cos(t) * one + np.sin(t) * other) * square).max())) / table.hard.value
        for t in np.arange(360) * np.pi / 180.0
    )
    assert before < found <= 1.001 * row.pressure
    assert row.pressure <= 1.002 * found


@pytest.mark.parametrize(
    ("name", "error", "before"),
    [
        ("two_start", "side_shift", 1.361),
        ("two_start", "roller_axial", 2.224),
        ("barrel_indexer", "axial_shift", 1.147),
        ("linear_groove", "crossing_arcmin", 1.4),
    ],
)
def test_no_cam_angle_presses_harder_than_is_told(name: str, error: str, before: float) -> None:
    """Every tenth of those that are looked at, and the nominally hardest, told up to 17 % less than the others."""
    table = _tolerances(name).sensitivities
    row = next(row for row in table.rows if row.cause.key == error)
    assert table.hard is not None
    packed = table.seated.packed
    (one,) = row.size * row.cause.scale * packed.taken(table.seated.flat(table.seated.approaches.of(row.cause)))
    whose = packed.roller if row.cause.holder == "roller" else np.zeros_like(packed.roller)
    found = max(
        float(np.sqrt((packed.walls.forces(sign * one * (whose == owner)) * packed.square).max())) / table.hard.value
        for owner in np.unique(whose)
        for sign in (-1.0, 1.0)
    )
    assert 1.01 * before < found == pytest.approx(row.pressure, rel=1e-9)


@pytest.mark.parametrize(
    ("name", "error"),
    [
        ("tool_changer", "cam_eccentricity"),
        ("two_start", "turret_wobble_arcmin"),
        ("barrel_indexer", "roller_tilt_arcmin"),
        ("conical_indexer", "turret_eccentricity"),
    ],
)
def test_no_direction_of_an_error_moves_farther_than_is_told(name: str, error: str) -> None:
    """That of what its parts do alone was told: 11.957 seconds of arc where 12.047 are, 36.65 where 37.25; of
    what acts both ways alike one way was tried: 26.55 where 26.61 are."""
    study = _tolerances(name)
    row = next(row for row in study.sensitivities.rows if row.cause.key == error)
    seated = study.sensitivities.seated
    packed, base, found = seated.packed, seated.nominal, 0.0
    parts = row.size * row.cause.scale * packed.taken(seated.flat(seated.approaches.of(row.cause)))
    whose = packed.roller if row.cause.holder == "roller" else np.zeros_like(packed.roller)
    for owner in np.unique(whose):
        one, other = parts * (whose == owner)
        for t in np.arange(180) * np.pi / 90.0:
            stand = packed.walls.stand(np.cos(t) * one + np.sin(t) * other)
            found = max(found, float((stand.high - base.high).max()), float((base.low - stand.low).max()))
    assert found <= 1.0005 * row.motion.value
    assert row.motion.value <= 1.002 * found
