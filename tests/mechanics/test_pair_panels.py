"""Forces of two rollers on one cam are added up: they are known at the same cam angles."""

from __future__ import annotations

import numpy as np

from camgeom.model import read
from camgeom.report.sections.load import contact


def test_both_rollers_of_a_pair_are_loaded_on_the_same_panels() -> None:
    """A force as steep as a square root: panels of one of them were halved for its pressure alone, and the report's
    contact ended as a bug."""
    model = read({
        "cam": {"kind": "conjugate", "base_radius": 2608.802, "width": 505.6, "gap": 3.0, "direction": "ccw",
                "center_distance": 4657.43},
        "follower": {"kind": "swinging", "clearance": 0.2, "arm": 2448.4, "inertia": 0.0474},
        "roller": {"shape": "cylinder", "diameter": 822.3, "length": 551.0},
        "return_roller": {"shape": "cone", "diameter": 1038.0, "length": 627.4, "half_angle": -6.5},
        "operation": {"speed": 5.77, "spring_rate": 0.296, "spring_preload": 573.0,
                      "force": ({"from": 70.0, "until": 120.0, "expression": "sqrt(s)"},)},
        "motion": ({"until": 20.0, "to": 12.6, "law": "modified-sine"},
                   {"until": 190.0, "to": 0.0, "law": "modified-sine", "share": 0.0497699}, {"until": 360.0}),
    })  # fmt: skip
    one, other = (duty.force.panels.edges for duty in model.duties)
    assert np.array_equal(one, other)
    assert contact(model)
