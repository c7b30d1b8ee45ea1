"""What a turret weighs: by one roller of each ring, as much as the whole turret united."""

from __future__ import annotations

import numpy as np
import pytest

from camgeom.maths.mesh import mass_properties
from tests.reference.profiles import model


@pytest.mark.parametrize("name", ["tool_changer", "barrel_indexer", "parallel_index", "conical_indexer", "two_start"])
def test_one_roller_of_each_ring_stands_for_all(name: str) -> None:
    made = model(name)
    volume, mass, centre, inertia = mass_properties(made.turret.mesh, 1.0)
    body = made.mechanism.turret.body
    shares = [(mass_properties(mesh, 1.0)[0], alike) for mesh, alike in body.shares(made.tolerance)]
    assert sum(one * alike for one, alike in shares) == pytest.approx(volume, rel=1e-6)
    joint = made.mechanism.tracks[0].joint
    axis, away = np.array(joint.axis), np.array(centre) - np.array(joint.centre)
    whole = axis @ np.array(inertia) @ axis + 1e-6 * mass * (away @ away - (away @ axis) ** 2)
    assert made.body.turret_moment == pytest.approx(whole, rel=1e-6)


@pytest.mark.parametrize("name", ["tool_changer", "parallel_index"])
def test_a_turret_is_weighed_no_finer_than_its_inertia_is_known(name: str) -> None:
    coarse, fine = (model(name, output={"tolerance": each}).body.turret_moment for each in (0.01, 1e-6))
    assert fine == pytest.approx(coarse, rel=1e-3)
    assert fine > coarse
    # A full cylinder: what the polygons of the finest mesh lose.
    body = model(name).mechanism.turret.body
    (disc, _), *_ = body.shares(1e-5 * body.size)
    ring = getattr(body, "_shaft", body)
    exact = np.pi * ring.radius**2 * (ring.high - ring.low)
    lost = 3e-5 * body.size / ring.radius
    assert exact * (1.0 - lost) < mass_properties(disc, 1.0)[0] < exact
