"""Globoidal cam solids against the distance to the nearest roller position, and their topology."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from camgeom.motion import Program, Segment
from tests.oracle.globoid import TOLERANCE, dwell_section, solid_of, wall_error
from tests.reference.indexing_machines import SHAPES, SIZES, indexer

CASES = [
    *[(n, form, "right", 1, "cylinder") for n in (3, 4, 6, 8, 12, 16, 24) for form in ("rib", "groove")],
    *[(8, "rib", "left", 1, shape) for shape in SHAPES],
    *[(6, "groove", "left", 1, shape) for shape in SHAPES[1:]],
    *[(n, "rib", "right", 2, "cylinder") for n in (3, 4, 6, 8, 12)],
    (4, "groove", "left", 2, "cone"),
    (6, "rib", "left", 2, "sphere"),
    (16, "groove", "left", 2, "sphere"),
]


@pytest.mark.parametrize(("stops", "form", "hand", "starts", "shape"), CASES)
def test_every_triangle_within_tolerance(stops, form, hand, starts, shape):
    cam, setup = indexer(stops, form, hand, starts, shape, bore=20.0)
    assert cam.problems(setup) == []
    solid = solid_of(cam, setup)
    assert solid.sound, (solid.mesh.components, solid.mesh.genus, solid.mesh.watertight)
    proud, inside, floor = wall_error(cam, setup, shape, solid)
    assert proud <= 1.0001 * solid.chord_error <= 1.0001 * TOLERANCE
    assert inside >= -1.0001 * solid.chord_error
    if shape != "sphere":
        assert floor >= cam.tip_clearance - solid.chord_error
    # The knots are used up: a mesh of far smaller error than asked for would be wasted triangles.
    assert solid.chord_error > 0.3 * TOLERANCE


def test_all_sizes_are_used():
    assert {n * s for n, _, _, s, _ in CASES} == {*SIZES, 32}


@pytest.mark.parametrize("indexes", [2, 3])
def test_several_indexes_in_a_turn(indexes):
    cam, setup = indexer(12, "rib", indexes=indexes, motion=70.0)
    assert len(cam.mechanism(setup).tracks) == indexes
    solid = solid_of(cam, setup)
    assert solid.sound
    proud, inside, _ = wall_error(cam, setup, "cylinder", solid)
    assert proud <= 1.0001 * TOLERANCE
    assert inside >= -1.0001 * TOLERANCE


def test_clockwise_cam_with_clearance():
    cam, setup = indexer(8, direction="cw", running_clearance=0.05)
    solid = solid_of(cam, setup)
    proud, inside, _ = wall_error(cam, setup, "cylinder", solid)
    assert solid.sound
    assert max(proud, -inside) <= 1.0001 * TOLERANCE


def test_dwell_is_a_surface_of_revolution():
    """Volume of a wedge in the dwell against the closed form: a globoid minus two strips, turned about the axis."""
    import manifold3d

    cam, setup = indexer(8)
    wedge = 0.4
    outline = [[0.0, 0.0], [1000.0, -1000.0 * np.tan(wedge)], [1000.0, 1000.0 * np.tan(wedge)]]
    sector = manifold3d.CrossSection([np.array(outline)]).extrude(400.0).translate([0.0, 0.0, -200.0])
    volumes, errors = [], []
    for tolerance in (0.01, 0.001):
        solid = solid_of(cam, setup, tolerance)
        body = manifold3d.Manifold(manifold3d.Mesh64(solid.mesh.vertices, solid.mesh.faces.astype(np.uint64)))
        volumes.append((body ^ sector).volume() / (2.0 * wedge))
        errors.append(solid.chord_error)
    # Chords take a volume in proportion to their sag: carried on to none.
    limit = volumes[1] + (volumes[1] - volumes[0]) * errors[1] / (errors[0] - errors[1])
    assert limit == pytest.approx(dwell_section(cam, setup), rel=1e-6)
    assert volumes[1] == pytest.approx(limit, rel=3e-5)


@pytest.mark.parametrize(("tolerance", "error"), [(0.01, 8e-5), (0.001, 8e-6)])
def test_volume_of_a_whole_turn_of_dwell(tolerance, error):
    """Measured on the finished solid, with nothing carried on: what its chords take, a tenth for a tenth."""
    cam, setup = indexer(8)
    still = Program.from_segments([Segment(2.0 * pi)], closed=True, angular=True)
    solid = solid_of(cam, replace(setup, program=still), tolerance)
    assert solid.sound
    missing = 1.0 - solid.mesh.volume / (2.0 * pi * dwell_section(cam, setup))
    assert abs(missing) < error


