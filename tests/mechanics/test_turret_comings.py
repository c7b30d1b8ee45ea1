"""What presses a turret jumps where a roller comes to bear: the duty is sampled on both sides of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from camgeom.cams import starter
from camgeom.checks import judge
from camgeom.mechanics.turret_duty import TurretDuty
from camgeom.model import Model
from camgeom.profile import from_data, read_data
from camgeom.profile.text import load
from camgeom.track import TURN
from camgeom.track.turret import Beside, Engagement, comings


def barrel() -> Model:
    """A barrel whose hardest slice is the last corner of a roller that leaves it."""
    data = read_data("profiles/barrel_indexer.toml")
    data["cam"] |= {"center_distance": 151.0, "width": 66.0, "diameter": 146.0}
    data["roller"] |= {"diameter": 25.0, "length": 16.0}
    return Model(from_data(data))


def test_the_hardest_slice_is_that_of_dense_samples() -> None:
    duty = barrel().turret_duty
    assert duty is not None
    dense: TurretDuty = replace(duty)
    vars(dense)["force"] = duty.load.sampled(duty.load.panels(float(np.radians(0.5))))
    assert duty.peak_pressure.value > 0.998 * dense.peak_pressure.value
    assert duty.peak_pressure.value < 1.02 * dense.peak_pressure.value


def test_rollers_come_where_they_are_said_to() -> None:
    duty = barrel().turret_duty
    assert duty is not None
    whole, middle = comings(duty.tracks, duty.beside.within)
    assert len(whole) >= 4
    assert len(middle) >= 4
    count = {way: Engagement(duty.tracks, duty.beside.within, whole + way).cover.any(axis=3).sum(axis=(0, 2))
             for way in (-1e-7, 1e-7)}
    assert (np.abs(count[1e-7] - count[-1e-7]) == 1).all()
    assert ((whole > 0.0) & (whole < TURN)).all()


def test_what_is_known_at_a_cam_angle_is_not_sought_again() -> None:
    duty = barrel().turret_duty
    assert duty is not None
    beside = Beside(duty.tracks, duty.beside.within)
    first = beside.at(np.linspace(0.0, TURN, 37))
    assert beside.at(np.linspace(0.0, TURN, 37)) is first
    finer = np.linspace(0.0, TURN, 73)
    one, fresh = beside.at(finer, first), Engagement(duty.tracks, duty.beside.within, finer, slicing="ended")
    assert one.known is first
    for name in ("on", "cover", "lever", "curvature", "place", "normal", "turning", "drive_angle"):
        assert np.array_equal(getattr(one, name), getattr(fresh, name)), name


def test_a_duty_under_another_load_asks_for_its_rollers_once() -> None:
    duty = barrel().turret_duty
    assert duty is not None
    heavier = replace(duty, load=replace(duty.load, friction=50_000.0))
    assert heavier.beside.comings is duty.beside.comings
    assert heavier.peak_force.value > duty.peak_force.value


@pytest.mark.parametrize("begin", [120.0, 120.26])
@pytest.mark.parametrize(("width", "level", "least"), [(62.38, "fail", 0.0), (62.46, "pass", 1.0)])
def test_a_hand_over_that_leaves_the_turret_free_for_a_tenth_of_a_degree(begin, width, level, least) -> None:
    """Wherever it falls between the cam angles that are looked at first; counted beside it at every minute."""
    data = load(starter("globoidal"), "globoidal")[0]
    data["cam"]["width"] = width
    data["motion"] = (
        {"until": begin}, {"until": begin + 120.0, "to": 45.0, "law": "modified-sine"}, {"until": 360.0},
    )  # fmt: skip
    made = Model(from_data(data))
    said = judge(made, ("hand-over",)).findings
    assert [found.level for found in said] == [level, level]
    turret = made.mechanism.turret
    assert turret is not None
    for way, found in enumerate(said):
        theta = np.radians(np.arange(0.0, 360.0, 1.0 / 60.0))
        held = Engagement(turret.bearing, made.mechanism.within, theta).on[way].any(axis=2).sum(axis=1)
        assert found.value == least == held.min()


@pytest.mark.parametrize(("center", "short"), [(149.27097, True), (148.5, False)])
def test_a_wall_shorter_than_the_samples_are_apart_is_looked_at(center: float, short: bool) -> None:
    """Of a plate's wall between two crossings 0.04 deg are left: there the contact is wider than the roller."""
    data = read_data("profiles/parallel_index.toml")
    data["cam"] |= {"center_distance": center, "diameter": 203.81263, "width": 18.8471,
                    "running_clearance": 0.0363154, "plates": 4, "direction": "cw"}  # fmt: skip
    data["follower"] |= {"stops": 4, "rollers": 16, "pitch_radius": 81.227473, "inertia": 0.59943407}
    data["roller"] |= {"diameter": 27.5825319}
    data["motion"] = ({"until": 70.0}, {"until": 295.71319, "to": 90.0, "law": "4-5-6-7"}, {"until": 360.0})
    data["operation"] |= {"speed": 158.156313, "friction": 29080.9153}
    model = Model(from_data(data))
    duty = model.turret_duty
    assert duty is not None
    spans = [float(np.ptp(track.span)) for track in duty.tracks]
    assert (min(spans) < 1e-3) == short
    # Both ends of it are among the cam angles at which somebody comes.
    ends = np.mod(duty.tracks[int(np.argmin(spans))].span, TURN)
    whole, _ = comings(duty.tracks, duty.beside.within)
    assert np.abs(whole[:, None] - ends).min(axis=0) == pytest.approx(0.0, abs=1e-9)
    [said] = judge(model, ("turret-pressure",)).findings
    assert said.level == ("fail" if short else "pass")
    assert ("wider than the roller" in str(said)) == short


def test_the_pressure_angle_is_looked_at_where_rollers_come() -> None:
    """The best placed roller leaves between two samples: 44.78 deg were told, of a smooth maximum elsewhere."""
    data = read_data("profiles/parallel_index.toml")
    data["cam"] |= {"center_distance": 144.89667, "diameter": 217.56983, "running_clearance": 0.0415649}
    data["follower"] |= {"pitch_radius": 78.841883}
    data["roller"] |= {"diameter": 20.92494}
    data["motion"] = ({"until": 70.0}, {"until": 293.80834, "to": 90.0, "law": "3-4-5"}, {"until": 360.0})
    model = Model(from_data(data))
    turret = model.mechanism.turret
    assert turret is not None
    assert model.drive_angle is not None
    coming, _ = comings(turret.bearing, model.mechanism.within)
    beside = np.sort(np.concatenate([coming - 1e-8, coming + 1e-8]))
    there = Engagement(turret.bearing, model.mechanism.within, beside).drive_angle.max()
    assert np.degrees(there) > 44.9
    assert model.drive_angle.value >= there * (1.0 - 1e-9)
