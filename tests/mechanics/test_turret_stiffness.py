"""Contact stiffness of turret and cam over a turn: equilibrium, preload, and what a profile's dynamics take from it."""

from __future__ import annotations

from dataclasses import replace
from math import log, pi

import numpy as np
import pytest

from camgeom.errors import DesignError, ProfileError
from camgeom.mechanics.material import STEEL
from camgeom.mechanics.stiffness import Slices
from camgeom.mechanics.turret_duty import COUNT, TurretDuty
from camgeom.model import Model
from camgeom.profile import parse
from camgeom.report.result import compute
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


def slices_at(duty: TurretDuty, theta: np.ndarray) -> Slices:
    return duty.slices(duty.beside.once(theta))


def torque_of(bearing, held):
    """Torque of the slices on the turret, N mm, (n,)."""
    return (held.line_load * bearing.lever * bearing.width).sum(axis=1)


def test_loads_are_those_of_the_turret_s_duty(changer):
    duty = changer.turret_duty
    picked = duty.loaded[:: max(len(duty.loaded) // 40, 1)]
    bearing = slices_at(duty, duty.theta[picked])
    held = bearing.held(duty.turret_torque[picked])
    shared = duty.line_load[picked].reshape(len(picked), -1)
    way = np.where(duty.turret_torque[picked] >= 0.0, 0, 1)
    mine = held.line_load.reshape(len(picked), 2, -1)[np.arange(len(picked)), way]
    assert np.abs(mine - shared).max() < 1e-9 * shared.max()


def test_slices_far_from_each_other_bear_the_torque_too(changer):
    """Where one slice touches first, its approach there is zero but for rounding: it was taken for a gap, and nothing
    bore the torque."""
    duty = changer.turret_duty
    picked = duty.loaded[::3]
    bearing = slices_at(duty, duty.theta[picked])
    gaps = np.random.default_rng(0).uniform(0.0, 1.0, bearing.preload.shape)
    bearing = replace(bearing, preload=-gaps)
    held = bearing.held(duty.turret_torque[picked])
    assert torque_of(bearing, held) == pytest.approx(duty.turret_torque[picked], rel=1e-9)


def test_stiffness_is_torque_over_angle_without_preload(changer):
    duty = changer.turret_duty
    table, tangent = (np.array(duty.stiffness_table(estimate)) for estimate in ("secant", "half-space"))
    theta = np.arange(COUNT) * 2.0 * pi / COUNT
    bearing = slices_at(duty, theta)
    torque = duty.torque_at(theta, preloaded=False)
    held = bearing.held(torque)
    resting = theta < np.radians(100.0)
    assert table[resting] == pytest.approx((1e-3 * torque / held.angle)[resting], rel=1e-9)
    assert torque_of(bearing, held) == pytest.approx(torque, rel=1e-10)
    assert 1.5 < table.max() / table.min() < 4.0
    # a small vibration feels how much more torque a little more angle takes
    more, less = bearing.held(1.001 * torque), bearing.held(0.999 * torque)
    slope = 1e-3 * 0.002 * torque / (more.angle - less.angle)
    assert tangent[resting] == pytest.approx(slope[resting], rel=1e-5)
    assert 1.05 < (tangent / table).min() < (tangent / table).max() < 1.12


@pytest.mark.parametrize(("share", "parted"), [(0.98, False), (1.02, True)])
def test_preload_holds_both_walls_until_the_torque_parts_one(changer, share, parted):
    duty = replace(changer.turret_duty, preload=0.01)
    bearing = slices_at(duty, np.array([0.0]))
    still = bearing.held(np.array([0.0]))
    assert still.angle == pytest.approx(0.0, abs=1e-12)
    assert (still.line_load > 0.0).sum() >= 14
    # the torque at which the wall that holds back lets go: psi lever = preload
    held_back = bearing.on & (bearing.lever < 0.0) & (bearing.preload > 0.0)
    limit = (bearing.preload[held_back] / -bearing.lever[held_back]).max()
    lone = replace(bearing, on=bearing.on & (bearing.lever > 0.0))
    low, high = 0.0, 1e9
    for _ in range(80):
        torque = 0.5 * (low + high)
        below = lone.held(np.array([torque])).angle[0] < limit
        low, high = (torque, high) if below else (low, torque)
    loaded = bearing.held(np.array([share * torque]))
    assert bool((loaded.line_load[held_back] > 0.0).any()) is not parted


def test_preload_stiffens_the_dwell(changer):
    loose, tight = (np.array(replace(changer.turret_duty, preload=p).stiffness_table()) for p in (0.0, 0.01))
    assert 1.7 * loose[0] < tight[0] < 3.0 * loose[0]


def test_a_turret_without_torque_is_refused(changer):
    duty = changer.turret_duty
    idle = replace(duty, load=replace(duty.load, mass=0.0, friction=0.0))
    with pytest.raises(DesignError, match="no torque"):
        idle.stiffness_table()


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


def slices(curvature: list[float], width: float = 15.0, radius: float = 10.0) -> Slices:
    """One cam angle, slices with the lever 1 mm on walls of these relative curvatures, 1/mm."""
    k = np.array([curvature])
    return Slices(np.full(k.shape, True), np.ones(k.shape), k, np.zeros(k.shape), width, radius, STEEL, STEEL)


def test_half_space_by_hand():
    """Two steel cylinders, R = 10 and 40 mm, 3 kN on 15 mm: the cam yields down to 20 mm."""
    line, comp = 3000.0 / 15.0, STEEL.compliance
    half = np.sqrt(4.0 * line * 2.0 * comp / (pi * (1.0 / 10.0 + 1.0 / 40.0)))
    sink = line * comp / pi * (2.0 * log(40.0 / half) - 1.0 + 2.0 * log(40.0 / half) - 0.3 / 0.7)
    pair = slices([1.0 / 10.0 + 1.0 / 40.0])
    found = pair.stiffness(np.array([[line]]), "secant")
    assert found[0] == pytest.approx(3000.0 / sink, rel=1e-14)
    tangent = pair.stiffness(np.array([[line]]))
    assert tangent[0] == pytest.approx(15.0 / (sink / line - 2.0 * comp / pi), rel=1e-12)


def test_chord_is_load_free_and_stiffer():
    """h1 + h2 is nearly b^2 k/2, so k = pi L E*/2 whatever the load: the source's formula counts the contact width
    alone.
    """
    loads = (10.0 / 15.0, 100.0 / 15.0, 1000.0 / 15.0)
    pair = slices([0.125])
    chord = np.array([pair.stiffness(np.array([[line]]), "chord")[0] for line in loads])
    softer = np.array([pair.stiffness(np.array([[line]]))[0] for line in loads])
    assert chord == pytest.approx(pi * 15.0 / 2.0 / (2.0 * STEEL.compliance), rel=1e-4)
    assert (softer < chord).all()
    assert (np.diff(softer) > 0.0).all()


def test_slices_add_up_and_idle_ones_do_not():
    one = slices([0.1]).stiffness(np.array([[50.0]]))
    assert slices([0.1, 0.1, 0.1]).stiffness(np.array([[50.0, 50.0, 0.0]])) == pytest.approx(2.0 * one, rel=1e-14)


@pytest.mark.parametrize("estimate", ["chord", "half-space"])
def test_a_contact_wider_than_its_body_is_refused(estimate):
    with pytest.raises(DesignError, match=r"wider than the (roller|body)"):
        slices([100.1]).stiffness(np.array([[1e12]]), estimate)


def test_dynamics_do_not_hang_on_where_the_turn_begins():
    """The stiffness over the cam angle is a table: between its angles rollers come and go."""
    later = model("tool_changer", **{"until = 110": "until = 102.7", "until = 250": "until = 242.7"})
    one, other = (compute(each, ("dynamics",)).data["dynamics"] for each in (model("tool_changer"), later))
    assert other["first_frequency_hz"] == pytest.approx(one["first_frequency_hz"], rel=1e-4)
    assert other["duty"]["peak_torque_n_m"] == pytest.approx(one["duty"]["peak_torque_n_m"], rel=2e-4)
    assert other["amplification"] == pytest.approx(one["amplification"], rel=2e-4)
    assert other["dissipated_power_w"] == pytest.approx(one["dissipated_power_w"], rel=2e-3)
