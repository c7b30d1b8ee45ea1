"""Bodies that cross themselves: pairs of triangles against every pair tried, winding numbers, grooves that overlap."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from camgeom.checks import judge
from camgeom.errors import DesignError
from camgeom.maths.crossing import crossings, outline, outlines_cross
from camgeom.maths.mesh import Mesh
from camgeom.model import Model, read
from camgeom.model.body import refuse_overlap
from camgeom.profile import from_data
from camgeom.profile.text import load
from camgeom.solid import Solid
from camgeom.solid.blank import Blank
from tests.places import PROFILES


def side_of(a, b, c, d):
    """Six times the signed volume of tetrahedra a b c d."""
    return np.linalg.det(np.stack([b - a, c - a, d - a], axis=-2))


def every_pair(mesh: Mesh) -> set[tuple[int, int]]:
    """Crossing pairs by volumes of tetrahedra alone, every pair of triangles tried."""
    tri, found = mesh.vertices[mesh.faces], set()
    for i in range(len(tri)):
        others = np.array([j for j in range(len(tri)) if not set(mesh.faces[i]) & set(mesh.faces[j])])
        if not len(others):
            continue
        a, b, c = (np.broadcast_to(tri[i, k], (len(others), 3)) for k in range(3))
        for k in range(3):
            p, q = tri[others, k], tri[others, (k + 1) % 3]
            # Triangles of one flat end lie in one plane but for rounding.
            heights = np.array([side_of(a, b, c, p), side_of(a, b, c, q)])
            apart = (heights[0] * heights[1] < 0.0) & (np.abs(heights).min(axis=0) > 1e-9)
            turns = np.sign([side_of(p, q, a, b), side_of(p, q, b, c), side_of(p, q, c, a)])
            hit = apart & (np.abs(turns.sum(axis=0)) == 3.0)
            found |= {(min(i, int(j)), max(i, int(j))) for j in others[hit]}
    return found


def told(mesh: Mesh) -> set[tuple[int, int]]:
    return {(int(min(pair)), int(max(pair))) for pair in crossings(mesh)}


def winding(mesh: Mesh, point) -> float:
    """Winding number of a mesh about a point, by solid angles (Van Oosterom and Strackee 1983)."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces] - point, 1, 0)
    la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
    top = np.einsum("fi,fi->f", a, np.cross(b, c))
    bottom = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    return float(np.arctan2(top, bottom).sum() / (2.0 * np.pi))


@pytest.mark.parametrize("seed", range(4))
def test_every_crossing_of_a_heap_of_triangles_is_found(seed) -> None:
    rng = np.random.default_rng(seed)
    centre = rng.uniform(-1.0, 1.0, (120, 1, 3))
    size = rng.choice([0.05, 0.4, 2.0], (120, 1, 1))
    vertices = (centre + size * rng.normal(size=(120, 3, 3))).reshape(-1, 3)
    heap = Mesh(vertices, np.arange(360, dtype=np.int32).reshape(-1, 3))
    wanted = every_pair(heap)
    assert len(wanted) > 100
    assert told(heap) == wanted


def two(shift: float) -> Mesh:
    """Two discs of radius 10 mm in one mesh, the second shifted along x."""
    disc = Blank(((10.0, 0.0), (10.0, 5.0))).mesh(0.05)
    turned = disc.vertices @ np.array([[1.0, 0.0, 0.0], [0.0, 0.8, 0.6], [0.0, -0.6, 0.8]]) + [shift, 0.1, 0.2]
    faces = np.concatenate([disc.faces, disc.faces + len(disc.vertices)]).astype(np.int32)
    return Mesh(np.concatenate([disc.vertices, turned]), faces)


@pytest.mark.parametrize(("shift", "crossed"), [(25.0, False), (20.1, False), (19.5, True), (3.0, True)])
def test_two_bodies_in_one_mesh(shift, crossed) -> None:
    mesh = two(shift)
    assert mesh.watertight
    assert told(mesh) == every_pair(mesh)
    assert bool(told(mesh)) == crossed


def test_a_crossing_shallower_than_the_depth_does_not_count() -> None:
    mesh = two(19.5)
    assert len(crossings(mesh, 0.05))
    assert not len(crossings(mesh, 5.0))


def barrel(clearance: float) -> Model:
    data, _, _ = load((PROFILES / "barrel_indexer.toml").read_text(encoding="utf-8"), "")
    data["cam"] = data["cam"] | {"running_clearance": clearance}
    return Model(from_data(data, ""))


def test_grooves_that_overlap_are_refused_and_neighbours_that_do_not_are_built() -> None:
    sound = barrel(5.0)
    assert sound.solid.sound
    assert all(f.level == "pass" for f in judge(sound, ["watertight"]).findings)
    overlapping = barrel(6.5)
    with pytest.raises(DesignError, match="crosses itself"):
        overlapping.solid  # noqa: B018
    (finding,) = judge(overlapping, ["watertight"]).findings
    assert finding.level == "fail"
    assert "overlap" in finding.advice


def test_the_refused_mesh_is_closed_and_holds_what_no_body_holds() -> None:
    model = barrel(6.5)
    (part,) = model.parts
    made: Solid = part.solid(0.01)
    assert made.mesh.watertight
    pairs = crossings(made.mesh, 0.02)
    assert len(pairs)
    points = made.mesh.vertices[made.mesh.faces[pairs[:40]]].mean(axis=(1, 2))
    rng = np.random.default_rng(1)
    numbers = [round(winding(made.mesh, p + rng.normal(scale=0.2, size=3))) for p in points for _ in range(5)]
    assert set(numbers) - {0, 1}


@pytest.mark.parametrize("name", ["pin_insertion", "steep_shuttle", "tool_changer", "disc_face_groove"])
def test_sound_bodies_are_not_refused(name) -> None:
    model = read(str(PROFILES / f"{name}.toml"))
    for part in model.parts:
        solid = part.solid(0.05)
        refuse_overlap(part, solid)
        assert not len(crossings(solid.mesh, 2.0 * solid.chord_error))


def walls_on(*loops) -> Mesh:
    """The walls of a prism on closed loops (n, 2), 0 to 2 mm high, each wall two triangles."""
    points, faces, first = [], [], 0
    for loop in loops:
        n = len(loop)
        i, j = np.arange(n), np.roll(np.arange(n), -1)
        low, high = first + i, first + n + i
        faces += [np.stack([low, first + j, high], axis=1), np.stack([first + j, first + n + j, high], axis=1)]
        points += [np.column_stack([loop, np.zeros(n)]), np.column_stack([loop, np.full(n, 2.0)])]
        first += 2 * n
    return Mesh(np.concatenate(points), np.concatenate(faces).astype(np.int32))


@pytest.mark.parametrize("seed", range(12))
def test_a_prism_crosses_itself_where_its_outlines_do(seed) -> None:
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0.0, 2.0 * np.pi, 40))
    loop = 10.0 * np.column_stack([np.cos(angle), np.sin(angle)])
    loop += rng.normal(0.0, (0.0, 0.4, 1.5)[seed % 3], loop.shape)
    hole = rng.uniform(3.0, 9.9) * np.column_stack([np.cos(angle), -np.sin(angle)])
    mesh = walls_on(loop, hole)
    edges = outline(mesh)
    assert edges is not None
    assert len(edges) == 80
    assert outlines_cross(mesh, edges) == bool(every_pair(mesh))


@pytest.mark.parametrize(("depth", "crosses"), [(0.999, True), (1.002, False)])
def test_outlines_may_run_into_each_other_by_the_chord_errors(depth, crosses) -> None:
    square = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])
    wedge = np.array([[11.0, 4.0], [9.0, 5.0], [11.0, 6.0]])  # its corner 1 mm within the square
    mesh = walls_on(square, wedge)
    assert outlines_cross(mesh, outline(mesh), depth) is crosses


def test_what_is_no_prism_has_no_outline() -> None:
    mesh = walls_on(np.array([[0.0, 0.0], [10.0, 0.0], [0.0, 10.0]]))
    assert outline(mesh) is not None
    lifted = mesh.vertices.copy()
    lifted[0, 2] = 1e-9
    assert outline(Mesh(lifted, mesh.faces)) is None


@pytest.mark.parametrize(("share", "sound"), [(-0.05, True), (0.5, False)])
def test_a_disc_whose_bore_runs_through_its_rim_is_refused(share, sound) -> None:
    """The bore's vertices moved to a share of the way from the rim's least radius to its largest."""
    model = read(PROFILES / "disc_flat_face.toml")
    part = model.parts[0]
    solid = part.solid(model.tolerance)
    x, rim = solid.mesh.vertices.copy(), solid.mesh.vertices[solid.mesh.faces[solid.mesh.group_faces("flank")]]
    least, most = (f(np.hypot(rim[..., 0], rim[..., 1])) for f in (np.min, np.max))
    inner = np.unique(solid.mesh.faces[solid.mesh.group_faces("bore")])
    x[inner, :2] *= (least + share * (most - least)) / np.hypot(x[inner, 0], x[inner, 1])[:, None]
    moved = replace(solid, mesh=replace(solid.mesh, vertices=x))
    edges = outline(moved.mesh)
    assert edges is not None
    assert outlines_cross(moved.mesh, edges, 2.0 * solid.chord_error) is not sound
    if sound:
        refuse_overlap(part, moved)
    else:
        with pytest.raises(DesignError, match="crosses itself"):
            refuse_overlap(part, moved)
