"""Chord errors of large grids, of which only a part is measured: every cell again, along the diagonal it really has."""

from __future__ import annotations

import re

import numpy as np
import pytest

from camgeom.errors import NotConverged
from camgeom.maths.sampling import MAX_CELLS, Cells, measure, patch_sag, sample_surface
from camgeom.solid.stitch import TurretSurface
from camgeom.track.column import Column
from tests.reference.indexing_machines import indexer
from tests.reference.machines import pin_cam, pin_setup


def along_diagonals(cells, rising):
    """Largest sag of the cells with the given diagonals."""
    return float(np.where(rising, patch_sag(cells.a, -cells.b, cells.c), patch_sag(cells.a, cells.b, cells.c)).max())


def test_every_cell_of_a_large_grid_is_within_tolerance():
    (part,) = pin_cam().mechanism(pin_setup()).parts
    tolerance = 4e-4
    grid, _ = part.grid(tolerance)
    assert grid.rising.size > 120_000

    def rows(phi, counts):
        groove = part.section.rows(Column(part.track, phi), counts[1:-1])
        low = part.land(groove[:, :, 0], 0.0, counts[0])
        high = part.land(groove[:, :, -1], part.length, counts[-1])
        return np.concatenate([low, groove, high[:, :, ::-1]], axis=2)

    middle = rows(0.5 * (grid.phi[1:] + grid.phi[:-1]), tuple(2 * c for c in grid.counts))
    cells = measure(grid.points[:, :-1], grid.points[:, 1:], middle)
    assert along_diagonals(cells, grid.rising) <= 1.001 * grid.chord_error <= 1.001 * tolerance


@pytest.mark.parametrize("shape", ["cylinder", "crowned"])
def test_every_cell_of_all_grooves_is_within_tolerance(shape):
    cam, setup = indexer(6, "groove", shape=shape)
    (part,) = cam.mechanism(setup).parts
    land = part.land
    surface = TurretSurface(part.sections(land), land, -0.5 * cam.width, 0.5 * cam.width)
    rounds = sample_surface(surface, np.asarray(setup.program.knots), 1e-3, surface.most)
    assert not rounds.complete
    every = [np.arange(strip.cells) for strip in rounds.strips]
    cells = surface.sags(rounds.theta, rounds.counts, rounds.strips, every)
    worst = max(along_diagonals(c, rising) for c, rising in zip(cells, rounds.rising))
    assert worst <= 1.001 * rounds.worst <= 1.001e-3


def test_what_needs_too_many_cells_says_how_many():
    cam, setup = indexer(6, "groove")
    (part,) = cam.mechanism(setup).parts
    land = part.land
    surface = TurretSurface(part.sections(land), land, -0.5 * cam.width, 0.5 * cam.width)
    knots = np.asarray(setup.program.knots)
    with pytest.raises(NotConverged, match=r"needs \d+ cells, more than 4000000") as refused:
        sample_surface(surface, knots, 3e-5, surface.most)
    assert MAX_CELLS < int(re.findall(r"\d+", str(refused.value))[0]) < 1.2 * MAX_CELLS
    assert sample_surface(surface, knots, 4e-5, surface.most).worst <= 4e-5


def test_cells_between_measured_ones_lie_on_straight_lines():
    a = np.array([[0.0], [4.0], [1.0]])
    spread = Cells(a, -a, 2.0 * a).spread(np.array([1, 3, 6]), 8)
    assert spread.a[:, 0] == pytest.approx([0.0, 0.0, 2.0, 4.0, 3.0, 2.0, 1.0, 1.0])
    assert spread.c[:, 0] == pytest.approx(2.0 * spread.a[:, 0])
    whole = Cells(a, a, a)
    assert whole.spread(np.arange(3), 3) is whole


def test_better_diagonal_against_brute_force():
    """Sag of random patches on a fine grid of both triangles, for both diagonals."""
    rng = np.random.default_rng(5)
    a, b, c = (rng.uniform(-1.0, 1.0, (60, 1)) for _ in range(3))
    error, rising = Cells(a, b, c).error()
    s, t = np.meshgrid(np.linspace(0.0, 1.0, 201), np.linspace(0.0, 1.0, 201))
    for k in range(len(a)):
        f = 0.5 * (a[k] * s * s + 2.0 * b[k] * s * t + c[k] * t * t)
        f10, f01, f11 = (0.5 * x[0] for x in (a[k], c[k], a[k] + 2.0 * b[k] + c[k]))
        up = np.where(s >= t, s * f10 + t * (f11 - f10), t * f01 + s * (f11 - f01))
        down = np.where(s + t <= 1.0, s * f10 + t * f01, f11 + (1.0 - s) * (f01 - f11) + (1.0 - t) * (f10 - f11))
        found = np.abs(f - up).max(), np.abs(f - down).max()
        assert error[k, 0] == pytest.approx(min(found), rel=2e-3, abs=1e-4)
        if abs(found[0] - found[1]) > 1e-3:
            assert bool(rising[k, 0]) == (found[0] < found[1])
