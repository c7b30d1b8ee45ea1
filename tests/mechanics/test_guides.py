"""Where the pressure angle of a slide passes zero its guides' friction has a kink."""

from __future__ import annotations

import numpy as np
import pytest

from camgeom.design.batch import evaluate
from camgeom.model import read
from camgeom.profile import from_data

GROOVE = {
    "cam": {"kind": "disc", "form": "groove", "base_radius": 18.96875, "width": 24.0, "direction": "cw",
            "diameter": 293.93, "groove_depth": 12.0, "running_clearance": 0.0528},
    "follower": {"kind": "translating", "mass": 0.9, "offset": 15.9647},
    "roller": {"shape": "cylinder", "diameter": 12.54494, "length": 10.908, "dynamic_rating": 5200.0,
               "static_rating": 6100.0},
    "motion": ({"until": 78.979, "to": 21.5155, "law": "cycloidal"}, {"until": 150.0},
               {"until": 274.944, "to": 0.0, "law": "cycloidal"}, {"until": 360.0}),
    "operation": {"speed": 172.41, "spring_preload": 32.61, "spring_rate": 6.0, "friction": 7.512,
                  "guide_friction": 0.134},
}  # fmt: skip


@pytest.mark.parametrize("guide_friction", [0.0, 0.134, 0.3])
def test_pressure_beside_a_pressure_angle_of_zero(guide_friction: float) -> None:
    """A slide set off to one side: the pressure is computed again by the batch, which samples and has no panels."""
    data = {**GROOVE, "operation": {**GROOVE["operation"], "guide_friction": guide_friction}}
    duty = read(data).duty
    names = ["contact.peak_pressure_mpa", "contact.half_width_mm", "contact.peak_force_n"]
    batch = evaluate(from_data(data), {"operation.speed": np.array([172.41])}, names).figures
    assert duty.peak_pressure.value == pytest.approx(batch[names[0]][0], rel=2e-6)
    assert duty.peak_contact.half_width == pytest.approx(batch[names[1]][0], rel=1e-4)
    assert duty.peak_force.value == pytest.approx(batch[names[2]][0], rel=2e-6)
