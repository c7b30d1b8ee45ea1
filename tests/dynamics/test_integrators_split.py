"""Steps whose varying contact is solved apart from the constant springs, against the whole stage matrices."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from camgeom.dynamics.indexing.drive import IndexingDrive
from camgeom.dynamics.indexing.system import Fluctuation, TorsionSystem
from camgeom.dynamics.linear.maps import contact_maps, stages_of
from camgeom.dynamics.linear.method import RungeKutta, find
from camgeom.dynamics.linear.walk import aligned_grid
from camgeom.motion import Program, Segment

DRIVE = IndexingDrive(
    cam_inertia=7e-2,
    turret_inertia=3.5e-3,
    load_inertia=6e-2,
    input_stiffness=1.9e5,
    output_stiffness=3.5e5,
    contact_stiffness=1.2e6,
    input_damping=7.0,
    contact_damping=3.9,
)
MOVE = Segment(np.radians(200.0), np.radians(45.0), "modified-sine")
MOTION = Program.from_segments([MOVE, Segment(2.0 * pi)], closed=False, angular=True)


@pytest.mark.parametrize("name", ["gauss1", "gauss2", "gauss4", "gauss8"])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_steps_with_the_contact_apart_are_the_same_steps(name: str, friction: float) -> None:
    """The inversion lemma against the whole stage matrices, with a contact stiffness that varies."""
    waves = 1.2e6 * (1.0 + 0.3 * np.sin(np.arange(72)))
    drive = replace(DRIVE, contact_table=tuple(waves), cam_friction=friction, turret_friction=friction)
    system = TorsionSystem(drive, MOTION, np.array([60.0, 300.0]))
    grid = aligned_grid(system.knots, 400)
    method = find(name)
    assert isinstance(method, RungeKutta)
    apart = contact_maps(method, system, grid.start[None], grid.step[None])
    assert apart is not None
    whole = stages_of(method, system, grid.start[None], grid.step[None]).maps()
    assert np.abs(apart - whole).max() < 1e-12 * np.abs(whole).max()
    q, v = np.random.default_rng(5).normal(size=(2, 2, grid.steps, 3))
    here = system.coefficients(grid.start[None])
    plain = here.force - (here.damping @ v[..., None] + here.stiffness @ q[..., None])[..., 0]
    assert np.allclose(here.acceleration(q, v), plain, rtol=1e-11, atol=1e-11 * np.abs(plain).max())


def test_steps_that_do_not_split_take_the_whole_matrix() -> None:
    grid = aligned_grid(MOTION.knots, 100)
    swinging = TorsionSystem(DRIVE, MOTION, np.array([60.0]), Fluctuation(((1, 0.1, 0.0),)))
    gauss, radau = find("gauss4"), find("radau3")
    assert isinstance(gauss, RungeKutta)
    assert isinstance(radau, RungeKutta)
    assert contact_maps(gauss, swinging, grid.start[None], grid.step[None]) is None
    steady = TorsionSystem(DRIVE, MOTION, np.array([60.0]))
    assert contact_maps(radau, steady, grid.start[None], grid.step[None]) is None
    uneven = grid.step * (1.0 + 1e-3 * np.arange(grid.steps))
    assert contact_maps(gauss, steady, grid.start[None], uneven[None]) is None
