"""Flat faces of planar cams: triangles between loops, by the quick way for stars and the general one for the rest."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from camgeom.errors import DesignError
from camgeom.model import read
from camgeom.solid import builder
from camgeom.solid.blank import Bore
from camgeom.solid.builder import _star_ring, bounded, filled
from camgeom.solid.prism import outline_grid
from tests.places import ROOT


def star(count: int, radius: float, ripple: float, waves: int, turn: float) -> np.ndarray:
    """A counter-clockwise loop about the origin."""
    angle = turn + 2.0 * np.pi * np.arange(count) / count
    r = radius * (1.0 + ripple * np.cos(waves * angle))
    return np.stack([r * np.cos(angle), r * np.sin(angle)], axis=1)


def polygon_area(loop: np.ndarray) -> float:
    x, y = loop.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def check(planes: list[np.ndarray], triangles: np.ndarray) -> None:
    """All loops' edges are boundaries, every other edge is met from both sides, and the areas add up."""
    points = np.concatenate(planes)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    cross = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    wanted = sum(polygon_area(plane) for plane in planes)
    assert np.sum(cross) / 2.0 == pytest.approx(wanted, rel=1e-12)
    edges = {(int(f[k]), int(f[(k + 1) % 3])) for f in triangles for k in range(3)}
    assert len(edges) == 3 * len(triangles)
    start = 0
    rims = set()
    for plane in planes:
        n = len(plane)
        rims |= {(start + k, start + (k + 1) % n) for k in range(n)}
        start += n
    assert {(i, j) for i, j in edges if (j, i) not in edges} == rims


@settings(max_examples=60, deadline=None)
@given(
    n=st.integers(3, 60), m=st.integers(3, 60), ripple=st.floats(0.0, 0.2), waves=st.integers(1, 6),
    turn=st.floats(-7.0, 7.0), share=st.floats(0.02, 0.3),
)
def test_a_star_with_a_hole(n: int, m: int, ripple: float, waves: int, turn: float, share: float) -> None:
    planes = [star(n, 50.0, ripple, waves, 0.3), star(m, 50.0 * share * 0.3, 0.0, 1, turn)[::-1].copy()]
    triangles = bounded(planes)
    assert len(triangles) == n + m
    check(planes, triangles)


def test_a_keyway_is_a_star() -> None:
    outline, _ = Bore(40.0, 12.0, 3.3).outline(0.005)
    hole = outline[::-1] if polygon_area(outline) > 0.0 else outline
    planes = [star(500, 60.0, 0.3, 2, 0.1), np.ascontiguousarray(hole)]
    quick = _star_ring(*planes)
    assert quick is not None
    check(planes, quick)


def test_loops_that_are_no_stars_go_the_general_way() -> None:
    bent = np.array([[-10.0, -10], [30, -10], [30, 30], [20, 30], [20, 5], [15, 5], [15, 40], [-10, 40]])
    hole = star(12, 3.0, 0.0, 1, 0.0)[::-1].copy()
    assert _star_ring(bent, hole) is None
    check([bent, hole], bounded([bent, hole]))
    aside = star(40, 8.0, 0.0, 1, 0.0) + np.array([20.0, 0.0])
    assert _star_ring(star(80, 60.0, 0.0, 1, 0.0), aside[::-1].copy()) is None
    check([star(80, 60.0, 0.0, 1, 0.0), aside[::-1].copy()], bounded([star(80, 60.0, 0.0, 1, 0.0), aside[::-1].copy()]))


@pytest.mark.parametrize(("radius", "fits"), [(9.9, True), (10.1, False)])
def test_a_hole_that_crosses_the_outline_is_refused(radius: float, fits: bool) -> None:
    planes = [star(360, 20.0, 0.5, 1, 0.0), star(360, radius, 0.0, 1, 0.001)[::-1].copy()]
    if fits:
        check(planes, bounded(planes))
    else:
        with pytest.raises(DesignError, match="crosses itself or a hole"):
            bounded(planes)


@pytest.mark.parametrize("tolerance", [0.3, 0.03])
def test_the_stated_chord_error_is_the_largest_sag_along_any_chord(tolerance):
    """On a coarse mesh an outline's sag is not largest half way along a chord, and 0.999 of it is too little."""
    outline = read(ROOT / "profiles" / "parallel_index.toml").mechanism.outlines["plate 1"]
    grid = outline_grid(outline, tolerance)
    low, step, p = grid.phi[:-1], np.diff(grid.phi), grid.points[:2, :, 0]
    way = np.diff(p, axis=1)
    worst = 0.0
    for share in np.linspace(0.02, 0.98, 97):
        off = outline.curve(low + share * step).points - p[:, :-1]
        worst = max(worst, float(np.abs((way[0] * off[1] - way[1] * off[0]) / np.hypot(*way)).max()))
    assert 0.999 * grid.chord_error < worst <= grid.chord_error <= tolerance


@pytest.mark.parametrize("count", [20_000, 30_001])
@pytest.mark.parametrize("holes", [1, 2])
def test_a_long_polygon_is_cut_short_before_it_is_filled(count: int, holes: int, monkeypatch) -> None:
    lengths: list[int] = []
    whole = builder._without_ears

    def seen(loop: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        cuts, left = whole(loop)
        lengths.append(len(left))
        return cuts, left

    monkeypatch.setattr(builder, "_without_ears", seen)
    planes = [star(count, 50.0, 0.02, 5, 0.3)]
    planes += [star(40, 3.0, 0.0, 1, 0.0)[::-1] + np.array([20.0 * (-1) ** k, 0.0]) for k in range(holes)]
    triangles = filled(planes)
    assert triangles is not None
    # The triangles join again the corners between which they were cut off.
    check(planes, triangles)
    assert builder.LONG / 2 < lengths[0] <= builder.LONG


def test_where_another_part_reaches_into_what_is_cut_off_the_whole_is_filled() -> None:
    """A slit from the far side whose tip ends within one chord of the rim: 0.5 of its sag off it."""
    loop = star(20_000, 50.0, 0.0, 1, 0.0)
    sag = 50.0 * (1.0 - np.cos(np.pi / 10_000))
    assert loop[0, 1] == 0.0
    rim = np.insert(loop, 10_000, [[50.0 - 0.5 * sag, 0.0]], axis=0)
    triangles = filled([rim])
    assert triangles is not None
    check([rim], triangles)
    assert filled([np.insert(loop, 10_000, [[60.0, 0.0]], axis=0)]) is None


def swept(upper: np.ndarray, lower: np.ndarray, turn: int) -> np.ndarray:
    """A counter-clockwise loop between two graphs over the same stretch, turned by so many right angles."""
    x, at = np.linspace(0.0, 10.0, len(upper)), np.linspace(0.0, 10.0, len(lower))
    loop = np.concatenate([np.stack([at, lower], axis=1), np.stack([x, upper], axis=1)[::-1]])
    return np.stack([[loop[:, 0], loop[:, 1]], [-loop[:, 1], loop[:, 0]], [-loop[:, 0], -loop[:, 1]]][turn], axis=1)


@settings(max_examples=80, deadline=None)
@given(
    n=st.integers(2, 40), m=st.integers(2, 40), seed=st.integers(0, 10**6), turn=st.integers(0, 2),
    flat=st.booleans(), ripple=st.sampled_from([0.0, 1e-9, 1e-3, 1.0]),
)
def test_a_loop_between_two_graphs(n: int, m: int, seed: int, turn: int, flat: bool, ripple: float) -> None:
    rng = np.random.default_rng(seed)
    loop = swept(2.0 + ripple * rng.uniform(size=n), -(0.0 if flat else ripple) * rng.uniform(size=m), turn)
    triangles = builder._swept(loop)
    assert triangles is not None
    assert len(triangles) == n + m - 2
    check([loop], triangles)


def test_loops_that_are_not_swept() -> None:
    """One that turns back, one that runs clockwise and one that crosses itself are left to the general method."""
    back = np.array([[0, 0], [10, 0], [10, 4], [3, 4], [3, 3], [9, 3], [9, 1], [0, 1]], dtype=float)
    crossed = swept(np.array([1.0, -1.0, 1.0]), np.zeros(3), 0)
    assert builder._swept(back) is None
    assert builder._swept(swept(np.ones(5), np.zeros(5), 0)[::-1]) is None
    assert builder._swept(crossed) is None


def test_a_long_edge_is_filled_in_no_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """The general method takes a minute for the 70 000 corners of a plate of 30 m within a nanometre's sag."""
    x = np.linspace(0.0, 10.0, 70_000)
    loop = swept(3.0 + np.sin(x), np.zeros(2), 0)
    monkeypatch.setattr("camgeom.solid.engine.library", lambda: pytest.fail("asked"))
    triangles = filled([loop])
    assert triangles is not None
    assert len(triangles) == len(loop) - 2
