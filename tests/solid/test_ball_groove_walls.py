"""Walls between the passes of a ball's groove, down to where its two flanks meet."""

from __future__ import annotations

import pytest

from camgeom.model import Model
from camgeom.profile import from_data


def _drum(size: float) -> Model:
    return Model(from_data({
        "cam": {"kind": "cylindrical", "form": "groove", "diameter": 638.0 * size, "length": 655.0 * size,
                "groove_depth": 19.6 * size, "start": 595.0 * size, "bore": 96.0 * size},
        "follower": {"kind": "translating"},
        "roller": {"shape": "sphere", "diameter": 42.743 * size, "length": 14.96 * size},
        "motion": ({"until": 4.0}, {"to": 0.797 * size, "law": "modified-sine", "until": 150.0},
                   {"to": 0.0, "law": "modified-sine", "until": 360.0}),
        "output": {"tolerance": 0.07 * size},
    }))  # fmt: skip


@pytest.mark.parametrize("size", [1.0, 1e-3])
def test_walls_of_a_balls_groove_at_any_size(size: float) -> None:
    walls = {wall.name: wall.thickness / size for wall in _drum(size).walls}
    whole = {wall.name: wall.thickness for wall in _drum(0.1).walls}
    assert walls == pytest.approx({name: 10.0 * thickness for name, thickness in whole.items()}, rel=1e-9)
