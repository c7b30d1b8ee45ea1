"""Contact stiffness of turret and cam over a turn: equilibrium, preload, and what a profile's dynamics take from it."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from camgeom.errors import DesignError, ProfileError
from camgeom.mechanics.turret_stiffness import COUNT, bearing_at, contact_table, equilibrium, torque_at
from camgeom.model import Model
from camgeom.profile import parse
from tests.places import PROFILES

SHAFTS = '\n[dynamics]\nkind = "indexing"\ninput_stiffness = 194870\noutput_stiffness = 350210\ncontact_damping = 4\n'


def model(name: str, extra: str = "", **changes: str) -> Model:
    text = (PROFILES / f"{name}.toml").read_text()
    if extra:
        head, _, rest = text.partition("[dynamics]")
        text = head + rest.partition("\n\n")[2]
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    return Model(parse(text + extra))


@pytest.fixture(scope="module")
def changer() -> Model:
    return model("tool_changer")


def torque_of(bearing, held):
    """Torque of the slices on the turret, N mm, (n,)."""
    return (held.line_load * bearing.lever * bearing.width).sum(axis=1)


def test_loads_are_those_of_the_turret_s_duty(changer):
    duty = changer.turret_duty
    picked = duty.loaded[:: max(len(duty.loaded) // 40, 1)]
    bearing = bearing_at(duty, duty.theta[picked])
    held = equilibrium(bearing, duty.torque[picked], duty)
    shared = duty.line_load[picked].reshape(len(picked), -1)
    way = np.where(duty.torque[picked] >= 0.0, 0, 1)
    mine = held.line_load.reshape(len(picked), 2, -1)[np.arange(len(picked)), way]
    assert np.abs(mine - shared).max() < 1e-9 * shared.max()


def test_stiffness_is_torque_over_angle_without_preload(changer):
    duty = changer.turret_duty
    table = np.array(contact_table(duty))
    theta = np.arange(COUNT) * 2.0 * pi / COUNT
    bearing = bearing_at(duty, theta)
    torque = torque_at(duty, theta, preloaded=False)
    held = equilibrium(bearing, torque, duty)
    resting = theta < np.radians(100.0)
    assert table[resting] == pytest.approx((1e-3 * torque / held.angle)[resting], rel=1e-9)
    assert torque_of(bearing, held) == pytest.approx(torque, rel=1e-10)
    assert 1.5 < table.max() / table.min() < 4.0


@pytest.mark.parametrize(("share", "parted"), [(0.98, False), (1.02, True)])
def test_preload_holds_both_walls_until_the_torque_parts_one(changer, share, parted):
    duty = replace(changer.turret_duty, preload=0.01)
    bearing = bearing_at(duty, np.array([0.0]))
    still = equilibrium(bearing, np.array([0.0]), duty)
    assert still.angle == pytest.approx(0.0, abs=1e-12)
    assert (still.line_load > 0.0).sum() >= 14
    # the torque at which the wall that holds back lets go: psi lever = preload
    held_back = bearing.on & (bearing.lever < 0.0) & (bearing.preload > 0.0)
    limit = (bearing.preload[held_back] / -bearing.lever[held_back]).max()
    lone = replace(bearing, on=bearing.on & (bearing.lever > 0.0))
    low, high = 0.0, 1e9
    for _ in range(80):
        torque = 0.5 * (low + high)
        below = equilibrium(lone, np.array([torque]), duty).angle[0] < limit
        low, high = (torque, high) if below else (low, torque)
    loaded = equilibrium(bearing, np.array([share * torque]), duty)
    assert bool((loaded.line_load[held_back] > 0.0).any()) is not parted


def test_preload_stiffens_the_dwell(changer):
    loose, tight = (np.array(contact_table(replace(changer.turret_duty, preload=p))) for p in (0.0, 0.01))
    assert 1.7 * loose[0] < tight[0] < 3.0 * loose[0]


def test_a_turret_without_torque_is_refused(changer):
    duty = changer.turret_duty
    idle = replace(duty, load=replace(duty.load, mass=0.0, friction=0.0))
    with pytest.raises(DesignError, match="no torque"):
        contact_table(idle)


def test_profile_without_stiffness_and_inertias_says_what_it_used():
    found = model("tool_changer", SHAFTS)
    study = found.indexing
    assert study is not None
    assert len(study.drive.contact_table) == COUNT
    # a steel disc of the globoid's turret and its rollers: 2 % of what turns
    assert study.drive.turret_inertia + study.drive.load_inertia == pytest.approx(1.1)
    body = found.mass[0]
    assert study.drive.cam_inertia == pytest.approx(body.inertia[2][2], rel=1e-3)
    assert study.drive.cam_inertia > body.inertia[2][2]
    figures = study.summary()
    origins = figures["data_from"]
    assert isinstance(origins, dict)
    assert "Hertz" in origins["contact_stiffness"]
    assert origins["cam_inertia"] == "the cam's body"
    assert figures["lowest_contact_stiffness_n_m_per_rad"] == min(study.drive.contact_table)


def test_given_data_need_no_body():
    given = SHAFTS + "cam_inertia = 0.1\nturret_inertia = 0.02\ncontact_stiffness = 4e6\n"
    found = model("tool_changer", given)
    assert found.indexing is not None
    assert found.indexing.drive.load_inertia == pytest.approx(1.08)
    assert "solids" not in found.ledger.costs
    assert found.indexing.summary()["data_from"]["contact_stiffness"] == "given"


def test_load_inertia_beside_the_follower_s():
    found = model("tool_changer", SHAFTS + "cam_inertia = 0.1\n", **{"speed = 120": "speed = 120\nload_inertia = 0.4"})
    assert found.indexing is not None
    assert found.indexing.drive.turret_inertia == pytest.approx(1.1)
    assert found.indexing.drive.load_inertia == pytest.approx(0.4)


def test_nothing_left_for_the_load_plate_is_refused():
    with pytest.raises(ProfileError, match=r"dynamics\.load_inertia"):
        _ = model("tool_changer", SHAFTS + "cam_inertia = 0.1\nturret_inertia = 1.1\n").indexing
