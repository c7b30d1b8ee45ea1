"""Edges behind a section plane: what is seen of a tube, and of a block behind another one."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
import trimesh

from camgeom.maths import Floats
from camgeom.maths.hidden import _within, edges_behind
from camgeom.maths.mesh import Mesh
from camgeom.model import read
from camgeom.report.sections.design import outlines
from tests.places import PROFILES


def mesh(body: trimesh.Trimesh) -> Mesh:
    return Mesh(np.asarray(body.vertices), np.asarray(body.faces, dtype=np.int32))


def block(low: tuple[float, float, float], high: tuple[float, float, float]) -> Mesh:
    size, middle = np.subtract(high, low), 0.5 * np.add(high, low)
    return mesh(trimesh.creation.box(size, trimesh.transformations.translation_matrix(middle)))


def seen(sense: float, *bodies: Mesh, axis: int = 1, level: float = 0.0) -> tuple[Floats, ...]:
    cut = [loop for body in bodies for loop in outlines(body, axis, level)]
    return edges_behind(bodies, axis, level, sense, cut)


def test_of_a_tube_the_ends_of_its_bore_are_seen_and_its_outside_is_not() -> None:
    tube = mesh(trimesh.creation.annulus(10.0, 30.0, 40.0, sections=180))
    points = np.concatenate(seen(1.0, tube))
    assert points[:, 1].min() > -1e-9
    bore = points[np.hypot(points[:, 0], points[:, 1]) < 20.0]
    assert np.abs(bore[:, 2]) == pytest.approx(20.0)
    assert np.ptp(bore[:, 0]) == pytest.approx(20.0, abs=0.1)
    # What is left of the outside lies on the outline of the section, whose ends are the same lines.
    outside = points[np.hypot(points[:, 0], points[:, 1]) >= 20.0]
    assert np.all(np.abs(np.abs(outside[:, 2]) - 20.0) < 1e-9)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_of_two_blocks_the_nearer_one_hides_the_other(sense: float) -> None:
    # Both stand behind the plane: one low in front, one higher at the back; seen from the other side, turned about.
    front, back = block((-4, 1, 0), (4, 3, 3)), block((-2, 5, 0), (2, 7, 5))
    bodies = (front, back) if sense > 0 else (block((-4, -3, 0), (4, -1, 3)), block((-2, -7, 0), (2, -5, 5)))
    lines = seen(sense, *bodies)
    of_back = np.concatenate([line for line in lines if np.abs(line[:, 1]).min() > 4.0])
    assert of_back[:, 2].max() == pytest.approx(5.0)
    assert of_back[:, 2].min() == pytest.approx(3.0, abs=0.1)  # what stands lower is hidden
    of_front = np.concatenate([line for line in lines if np.abs(line[:, 1]).max() < 4.0])
    assert (of_front[:, 2].min(), of_front[:, 2].max()) == pytest.approx((0.0, 3.0))


def test_of_a_drum_the_edge_of_its_groove_is_seen_where_it_runs_behind_the_cut() -> None:
    model = read(str(PROFILES / "pin_insertion.toml"))
    body = model.parts[0].rough(0.05).mesh
    points = np.concatenate(seen(1.0, body))
    radius = np.hypot(points[:, 0], points[:, 1])
    edge = points[(radius > 66.5) & (np.abs(points[:, 2] - 55.0) < 54.0)]
    assert len(edge) > 20
    assert np.all(np.abs(edge[:, 0]) > 54.0 - 0.5)  # nearer the axis it is hidden by the cut face
    assert np.all(edge[:, 1] > -1e-9)


def test_behind_a_plane_beyond_every_body_nothing_is_seen() -> None:
    assert sum(map(len, seen(1.0, block((0.0, 0.0, 0.0), (2.0, 3.0, 4.0)), level=5.0))) == 0


def brute(points: np.ndarray, loop: np.ndarray) -> np.ndarray:
    """Which points lie inside a closed outline: the angle under which it goes round them, side by side."""
    found = []
    for point in points:
        a, b = loop - point, np.roll(loop, -1, axis=0) - point
        turn = np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(axis=1)).sum()
        found.append(abs(turn) > np.pi)
    return np.array(found, dtype=bool)


def test_inside_is_where_the_outline_goes_round() -> None:
    rng = np.random.default_rng(3)
    at = np.linspace(0.0, 2.0 * np.pi, 97)[:-1]
    wavy = np.stack([np.cos(at), np.sin(at)], axis=1) * (1.0 + 0.4 * np.cos(7.0 * at))[:, None]
    square = np.array([[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]])
    points = rng.uniform(-2.5, 2.5, (400, 2))
    points[:90, 1] = wavy[:90, 1]  # rays that pass through corners
    assert np.array_equal(_within(points, [wavy]), brute(points, wavy))
    assert np.array_equal(_within(points, [square, wavy]), brute(points, square) & ~brute(points, wavy))
    assert _within(points[:0], [wavy]).shape == (0,)


def test_a_fine_outline_takes_little_memory() -> None:
    at = np.linspace(0.0, 2.0 * np.pi, 20_001)[:-1]
    loop = np.stack([np.cos(at), np.sin(at)], axis=1) * (1.0 + 0.01 * np.cos(900.0 * at))[:, None]
    points = np.random.default_rng(4).uniform(-1.2, 1.2, (40_000, 2))
    tracemalloc.start()
    inside = _within(points, [loop])
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 2e8
    sure = np.abs(np.hypot(*points.T) - 1.0) > 0.011
    assert np.array_equal(inside[sure], np.hypot(*points.T)[sure] < 1.0)
