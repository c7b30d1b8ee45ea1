"""Peak rate of the torque of a pure inertia, by hand for some laws and by difference quotients for all of one form."""

from __future__ import annotations

from math import inf, pi

import numpy as np
import pytest

from camgeom.cli.tables import law_rows
from camgeom.motion import LAWS, make


@pytest.mark.parametrize(
    ("name", "rate"),
    [
        ("3-4-5", 1.875 * 30.0),
        ("cycloidal", 8.0 * pi**2),
        ("simple-harmonic", pi**4 / 4.0),
        ("cubic-2", 36.0),
        ("parabolic", inf),
        ("constant-velocity", inf),
    ],
)
def test_by_hand(name: str, rate: float) -> None:
    """At mid-stroke s'' = 0 and the rate is s' s'''; at the ends of a harmonic motion it is s'' squared."""
    assert make(name).torque_rate() == pytest.approx(rate, rel=1e-12)


@pytest.mark.parametrize("name", ["modified-sine", "modified-trapezoid", "double-harmonic", "universal-asymmetric"])
def test_by_difference_quotients(name: str) -> None:
    law = make(name)
    x = np.linspace(0.0, 1.0, 400_001)
    _, velocity, acceleration = law.jet(x, 2)
    steps = np.abs(np.diff(velocity * acceleration)) / (x[1] - x[0])
    assert law.torque_rate() == pytest.approx(steps.max(), rel=1e-4)


def test_the_catalogue_shows_it() -> None:
    rows = {row["name"]: row["torque_rate"] for row in law_rows()}
    assert set(rows) == set(LAWS)
    assert rows["3-4-5"] == pytest.approx(56.25)
    assert rows["parabolic"] is None
    assert rows["optimal"] is None
