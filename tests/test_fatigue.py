"""Stress and life of the groove cam's roller against the published case and against plain counting."""

from __future__ import annotations

import numpy as np
import pytest
from pin_machine import CAM, LENGTH, PITCH_RADIUS, ROLLER, ROLLER_RADIUS, SPEED, pin_load

from camgeom.mechanics.contact import groove_contact
from camgeom.mechanics.fatigue import cam_life, roller_life

LOAD = pin_load().sampled()
TABLE = {
    "developed": (989.908, 313.714, 48231.0),
    "published": (1178.359, 309.124, 16971.0),
    "flat": (1072.765, 311.831, 32708.9),
    "developed-wall": (998.895, 313.363, None),
    "exact": (1004.677, 313.346, 45347.0),
}


@pytest.mark.parametrize("convention", TABLE)
def test_pin_machine_table(convention):
    pressure, degrees, life = TABLE[convention]
    contact = groove_contact(LOAD, PITCH_RADIUS, ROLLER_RADIUS, LENGTH, ROLLER, CAM, convention)
    peak = contact.peak()
    assert float(peak.pressure) == pytest.approx(pressure, abs=6e-4)
    assert np.degrees(float(peak.theta)) == pytest.approx(degrees, abs=6e-4)
    found = roller_life(contact, ROLLER, ROLLER_RADIUS, SPEED)
    assert float(found.path) == pytest.approx(481.201, abs=6e-4)
    if life is not None:
        assert float(found.life_h) == pytest.approx(life, abs=0.06)


def test_trends_of_the_published_convention():
    radius = np.array([5.0, 13.0])
    contact = groove_contact(LOAD, PITCH_RADIUS, radius, LENGTH, ROLLER, CAM, "published")
    small, large = roller_life(contact, ROLLER, radius, SPEED).life_h
    assert large / small == pytest.approx(15.12, abs=0.006)
    speed = SPEED * np.array([1.0, 1300.0 / 600.0])
    contact = groove_contact(pin_load(speed).sampled(), PITCH_RADIUS, ROLLER_RADIUS, LENGTH, ROLLER, CAM, "published")
    slow, fast = roller_life(contact, ROLLER, ROLLER_RADIUS, speed).life_h
    assert fast / slow == pytest.approx(0.004484, abs=1e-6)
    contact = groove_contact(LOAD, PITCH_RADIUS, ROLLER_RADIUS, np.array([5.0, 15.0]), ROLLER, CAM, "published")
    short, long = roller_life(contact, ROLLER, ROLLER_RADIUS, SPEED).life_h
    assert long / short == pytest.approx(27.0, rel=1e-9)


def test_cam_life_is_that_of_its_worst_point():
    contact = groove_contact(LOAD, PITCH_RADIUS, ROLLER_RADIUS, LENGTH, ROLLER, CAM)
    found = cam_life(contact, CAM, SPEED)
    pressure = float(contact.peak().pressure)
    assert float(found.life_h) == pytest.approx((2450.0 / pressure) ** 6 * 1e7 / 36000.0, rel=1e-9)
    # The return begins with a pull back: the wall ahead carries it.
    assert int(found.wall) == -1
