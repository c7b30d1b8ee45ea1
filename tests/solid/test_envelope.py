"""The cylinder that a cam is turned from, in closed form, against the finished bodies."""

from __future__ import annotations

import numpy as np
import pytest

from camgeom.model import Model, read
from camgeom.solid.blank import Blank
from tests.places import PROFILES


@pytest.mark.slow
@pytest.mark.parametrize("path", sorted(PROFILES.glob("*.toml")), ids=lambda path: path.stem)
def test_it_just_holds_the_bodies(path):  # type: ignore[no-untyped-def]
    model = Model(read(path).profile, 0.02)
    diameter, length = model.mechanism.envelope
    points = np.concatenate([solid.mesh.vertices for solid in model.solids])
    if model.mechanism.box is not None:
        # A plate has no axis: its box, and the circle about its middle.
        assert np.ptp(points, axis=0) == pytest.approx(model.mechanism.box)
        points = points - 0.5 * np.array(model.mechanism.box)
    reach = np.hypot(points[:, 0], points[:, 1]).max()
    # Vertices lie on the surface: the farthest misses its top by a chord's sag at most.
    assert 0.5 * diameter - 0.021 <= reach <= 0.5 * diameter + 1e-6
    assert np.ptp(points[:, 2]) == pytest.approx(length, abs=1e-9)


def test_an_arc_that_bulges_counts_with_its_top() -> None:
    outward = Blank(((3.0, -4.0), (3.0, 4.0)), None, ((0.0, 0.0),))
    assert outward.envelope == pytest.approx((10.0, 8.0))
    saddle = Blank(((3.0, -4.0), (3.0, 4.0)), None, ((6.0, 0.0),))
    assert saddle.envelope == (6.0, 8.0)
