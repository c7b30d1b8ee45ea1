"""The [dynamics] table and the studies it asks for; contact stiffness from Hertz line contact."""

from __future__ import annotations

import json
from math import pi, radians
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from camgeom.dynamics.follower.study import follower_study
from camgeom.dynamics.indexing.response import at_rest, from_rest
from camgeom.dynamics.indexing.study import indexing_study
from camgeom.dynamics.linear.method import INTEGRATORS, Collocated
from camgeom.dynamics.spec import DRIVE_KEYS, FOLLOWER_KEYS, INDEXING_KEYS, INERTIA_KEYS, DynamicsSpec
from camgeom.errors import ProfileError
from camgeom.motion import Program, Segment

DRIVE: dict[str, Any] = {
    "kind": "indexing",
    "cam_inertia": 6.9996e-2,
    "turret_inertia": 3.471193e-3,
    "load_inertia": 5.9855881e-2,
    "input_stiffness": 1.9487e5,
    "output_stiffness": 3.5021e5,
    "contact_stiffness": 1.2329e6,
    "input_damping": 7.0,
    "output_damping": 8.7,
    "contact_damping": 3.9,
    "cam_mass": 18.93348848,
    "turret_mass": 6.12670882,
    "load_mass": 6.569037,
    "cam_bending": 3.1853e5,
    "cam_axial": 3.8821e5,
    "output_axial": 3.9752e6,
    "turret_bending": 2.9312e6,
    "load_bending": 6.3888e4,
    "cross_bending": 8.4679e5,
}


@pytest.fixture(scope="module")
def index() -> Program:
    move = Segment(radians(300.0), radians(45.0), "modified-trapezoid")
    return Program.from_segments([move, Segment(2.0 * pi)], closed=False, angular=True)


@pytest.fixture(scope="module")
def lift() -> Program:
    rise, rest = Segment(pi / 2.0, 10.0, "cycloidal"), Segment(1.5 * pi, 0.0, "cycloidal")
    return Program.from_segments([rise, Segment(pi), rest, Segment(2.0 * pi)])


def test_indexing_study(index: Program) -> None:
    spec = DynamicsSpec(**DRIVE, tolerance=1e-9, sweep=(900.0, 1100.0), sweep_points=3)
    study = indexing_study(spec, index, 1000.0)
    figures = json.loads(json.dumps(study.summary(), allow_nan=False))
    assert figures["first_frequency_hz"] == pytest.approx(245.686461, abs=6e-7)
    assert figures["first_critical_speed_rpm"] == pytest.approx(14741.1876, abs=1e-4)
    assert figures["peak_load_acceleration_rad_s2"] == pytest.approx(1746.331746878, rel=1e-10)
    assert figures["peak_load_acceleration_cam_angle_deg"] == pytest.approx(32.099949, abs=1.1e-6)
    assert figures["amplification"] == pytest.approx(1.137194324, abs=1e-9)
    assert figures["speed_class"] == "medium"
    assert len(figures["indefinite_blocks"]) == 2
    assert figures["error"] <= 1e-9
    assert study.sweep.peaks["load_acceleration"].maximum[1] == pytest.approx(1746.331746878, rel=1e-9)
    assert figures["sweep"]["speed_rpm"] == pytest.approx([900.0, 1000.0, 1100.0])
    assert figures["sweep"]["peak_load_acceleration_rad_s2"][1] == pytest.approx(1746.331746878, rel=1e-9)
    assert figures["sweep"]["refused"] == []
    assert figures["from_rest_peak_load_acceleration_rad_s2"] > 1000.0
    # harmonic 16 of the dwell mode stands at 995.8 r/min, harmonic 21 of the second at 969.3 in the dwell
    near = {(one["mode"], one["harmonic"]) for one in figures["critical_speeds"]}
    assert (1, 16) in near
    assert (1, 20) not in near
    assert abs(study.start.peak("load_acceleration").magnitude[0]) > 1000.0
    with pytest.raises(ProfileError, match=r"dynamics\.sweep"):
        _ = indexing_study(DynamicsSpec(**DRIVE), index, 1000.0).sweep


def test_paper_methods_are_selectable(index: Program) -> None:
    spec = DynamicsSpec(**DRIVE, method="wilson", wilson_theta=1.30, steps=3000)
    found = indexing_study(spec, index, 1000.0).summary()
    assert found["peak_load_acceleration_rad_s2"] == pytest.approx(1746.33, rel=1e-3)
    # an error of second order, which four times as many steps make a sixteenth of
    finer = indexing_study(spec.model_copy(update={"steps": 12_000}), index, 1000.0).summary()
    assert 1e-6 < float(str(found["error"])) < 1e-2
    assert float(str(finer["error"])) == pytest.approx(float(str(found["error"])) / 16.0, rel=0.1)
    assert any("1.3660" in str(note) for note in found["cautions"])  # type: ignore[attr-defined]
    method = DynamicsSpec(**DRIVE, method="generalized-alpha", spectral_radius=0.5).accuracy().method
    assert isinstance(method, Collocated)
    assert method.alpha_f == pytest.approx(1.0 / 3.0)
    for name in INTEGRATORS:
        assert DynamicsSpec(**DRIVE, method=name).method == name


def test_follower_study(lift: Program) -> None:
    spec = DynamicsSpec(kind="follower", mass=2.0, linkage_stiffness=2000.0, linkage_damping=150.0, preload=150.0)
    study = follower_study(spec, lift, 600.0, return_stiffness=2e4)
    assert study.train.stiffness == 2e6
    assert study.train.return_stiffness == 2e4
    figures = json.loads(json.dumps(study.summary(), allow_nan=False))
    assert figures["contact_lost"] is False
    assert figures["frequencies_hz"][0] == pytest.approx(np.sqrt(2.02e6 / 2.0) / (2.0 * pi))
    assert figures["least_contact_force_n"] > 0.0
    assert not study.flight.events
    grooved = follower_study(spec, lift, 600.0, closure="form")
    assert grooved.jump is None
    shaft = DynamicsSpec(
        **{**spec.model_dump(exclude_unset=True), "shaft_inertia": 2e-3, "shaft_stiffness": 2e4, "shaft_damping": 0.5}
    )
    assert follower_study(shaft, lift, 300.0).summary()["peak_windup_deg"] > 0.0  # type: ignore[operator]
    swept = follower_study(
        DynamicsSpec(**{**spec.model_dump(exclude_unset=True), "sweep": (100.0, 400.0)}), lift, 300.0
    )
    assert swept.sweep.peaks["contact_force"].minimum.shape == (100,)
    listed = json.loads(json.dumps(swept.summary(), allow_nan=False))["sweep"]
    assert (listed["speed_rpm"][0], listed["speed_rpm"][-1]) == pytest.approx((100.0, 400.0))
    assert len(listed["least_contact_force_n"]) == 100


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"mass": 1.0}, "mass mean nothing"),
        ({"output_stiffness": None}, "needs output_stiffness"),
        ({"sweep": (100.0, 50.0)}, "must rise"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"method": "wilsom"}, "method"),
        ({"method": "magnus4"}, "magnus4 is no longer offered"),
        ({"cam_inertia": float("nan")}, "cam_inertia"),
    ],
)
def test_contradictions_are_named(changes: dict[str, Any], reason: str) -> None:
    with pytest.raises(ValidationError, match=reason):
        DynamicsSpec(**{**DRIVE, **changes})


def test_inertias_come_with_the_table_or_beside_it(index: Program) -> None:
    spec = DynamicsSpec(**{**DRIVE, "load_inertia": None})
    with pytest.raises(ProfileError, match=r"dynamics\.load_inertia"):
        indexing_study(spec, index, 800.0)
    found = indexing_study(spec, index, 800.0, inertias={"load_inertia": 0.05, "cam_inertia": 9.0})
    assert found.drive.load_inertia == 0.05
    assert found.drive.cam_inertia == DRIVE["cam_inertia"]


def test_every_key_belongs_to_one_kind() -> None:
    names = set(DynamicsSpec.model_fields)
    assert set(INDEXING_KEYS) <= names
    assert set(FOLLOWER_KEYS) <= names
    assert not set(INDEXING_KEYS) & set(FOLLOWER_KEYS)
    assert set(DRIVE_KEYS) | set(INERTIA_KEYS) <= set(INDEXING_KEYS)
    common = names - set(INDEXING_KEYS) - set(FOLLOWER_KEYS)
    assert common == {
        *("kind", "method", "tolerance", "steps", "wilson_theta", "spectral_radius", "sweep", "sweep_points"),
        "settling_band", "body_compliance",
    }
    assert all(field.description for field in DynamicsSpec.model_fields.values())


def test_a_table_of_contact_stiffness_feeds_the_drive(index: Program) -> None:
    table = tuple(1e6 * (1.0 + 0.2 * np.cos(np.arange(72) * 2.0 * pi / 72)))
    spec = DynamicsSpec(**{key: value for key, value in DRIVE.items() if key != "contact_stiffness"})
    study = indexing_study(spec, index, 800.0, table)
    assert study.drive.contact_table == table
    assert study.modes.lowest_hz()[0] > 100.0
    with pytest.raises(ProfileError, match="contact_stiffness"):
        indexing_study(spec, index, 800.0)


def test_a_steady_state_and_a_start_share_their_steps(index: Program, monkeypatch: pytest.MonkeyPatch) -> None:
    """They are of one system on one grid: the maps of its steps are formed once, and read as a start of its own is."""
    from camgeom.dynamics.linear import maps

    formed: list[int] = []
    real = maps._step_maps
    monkeypatch.setattr(maps, "_step_maps", lambda m, s, a, h: (formed.append(a.shape[1]), real(m, s, a, h))[1])
    study = indexing_study(DynamicsSpec(**DRIVE), index, 300.0)
    steady = study.steady
    steps = [n for n in formed if n >= maps.KEPT[0]]
    start = study.start
    assert start.solution.grid.steps == steady.solution.grid.steps
    assert [n for n in formed if n >= maps.KEPT[0]] == steps
    alone = from_rest(study.drive, study.motion, study.speed, 1, study.accuracy, study.fluctuation, study.torque,
                      at_rest(study.drive, study.motion, study.torque), study.exact)  # fmt: skip
    assert np.array_equal(alone.solution.state, start.solution.state)
