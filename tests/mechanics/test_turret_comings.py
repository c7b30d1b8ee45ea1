"""What presses a turret jumps where a roller comes to bear: the duty is sampled on both sides of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from camgeom.mechanics.turret_duty import TurretDuty
from camgeom.model import Model
from camgeom.profile import from_data, read_data
from camgeom.track import TURN
from camgeom.track.turret import Engagement, comings


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
    whole, middle = comings(duty.tracks, duty.inside)
    assert len(whole) >= 4
    assert len(middle) >= 4
    count = {way: Engagement(duty.tracks, duty.inside, whole + way).cover.any(axis=3).sum(axis=(0, 2))
             for way in (-1e-7, 1e-7)}
    assert (np.abs(count[1e-7] - count[-1e-7]) == 1).all()
    assert ((whole > 0.0) & (whole < TURN)).all()
