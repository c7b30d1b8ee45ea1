"""Extremes between the nodes of a solution whose interpolation promises what is not there."""

from __future__ import annotations

import numpy as np
import pytest

from camgeom.dynamics.linear import peaks
from tests.reference.profiles import built

RINGING = {
    "cam": {"kind": "disc", "base_radius": 106.1, "width": 26.6, "center_distance": 208.79},
    "follower": {"kind": "swinging", "face": "flat", "arm": 229.05, "inertia": 0.0103},
    "operation": {"speed": 60.0},
    "dynamics": {"kind": "follower", "linkage_stiffness": 25.7, "linkage_damping": 691.0, "shaft_inertia": 0.00511,
                 "shaft_stiffness": 712.0, "shaft_damping": 1.72669},
    "motion": ({"until": 60.0}, {"until": 160.0, "to": 17.54, "law": "double-harmonic", "reverse": True},
               {"until": 320.0, "to": 0.0, "law": "cycloidal"}, {"until": 360.0}),
}  # fmt: skip
"""a shaft that rings after the acceleration's step at 60 degrees"""


@pytest.mark.parametrize(("steps", "all_of_them"), [(4000, False), (500, True)])
def test_the_largest_of_a_ringing_shaft_is_that_of_all_true_steps(
    monkeypatch: pytest.MonkeyPatch, steps: int, all_of_them: bool
) -> None:
    taken, inside = [], peaks._true_inside

    def counted(solution, output, some):
        taken.append(len(some))
        return inside(solution, output, some)

    monkeypatch.setattr(peaks, "_true_inside", counted)
    study = built(RINGING).elastic_follower
    speed = np.array([1.03 * study.speed])
    found = study.over(speed, steps).peaks["acceleration"]
    # Those of acceleration and contact force; a step too coarse for the shaft is wrong everywhere.
    assert sum(taken) > 0
    assert (sum(taken) >= 2 * steps) == all_of_them
    taken.clear()
    monkeypatch.setattr(peaks, "LOOKED_AT", 10**6)
    whole = study.over(speed, steps).peaks["acceleration"]
    assert min(taken) >= steps
    assert (found.maximum, found.minimum) == (whole.maximum, whole.minimum)
    assert (found.maximum_at, found.minimum_at) == (whole.maximum_at, whole.minimum_at)
