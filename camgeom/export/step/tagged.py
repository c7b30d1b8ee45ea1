"""Meshes whose triangles know their patch and whose corners know their parameters, before and after the boolean.

The boolean settles which surfaces meet where (topology); nothing of its coordinates goes into the file. What is read
from its result are regions of one patch and the chains of mesh edges between two of them. A corner is a mesh vertex
where more (or fewer) than two border edges meet; a chain runs from corner to corner with one region on its left and one
on its right. A border ring without a corner is given two.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import ceil, pi, sqrt
from typing import Any, final

import numpy as np
import numpy.typing as npt

from camgeom.errors import DesignError
from camgeom.export.step.geometry import SplineSurface
from camgeom.export.step.patches import GrooveBody, Patch
from camgeom.export.step.spline import SurfaceFit
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.mesh import joined
from camgeom.solid.blank import Blank
from camgeom.solid.builder import cell_faces
from camgeom.solid.cut import groove_cap
from camgeom.solid.engine import checked, library
from camgeom.track import Track

Ints = npt.NDArray[np.int64]
Loops = tuple[tuple[tuple[tuple[int, bool], ...], ...], ...]
OUTSIDE = -1
"""tag of triangles that lie outside the blank: backs and caps of groove bodies"""


@final
@immutable
class Tagged:
    """A closed mesh whose corners may repeat a vertex.

    points  (p, 3) mm of the corners; twin (p,) the corner that stands for the vertex; values (p, 2) parameters
    faces   (f, 3) corners; tag (f,) the patch of each triangle
    """

    points: Floats
    twin: Ints
    values: Floats
    faces: Ints
    tag: Ints

    def volume(self) -> float:
        """Enclosed volume, mm³."""
        a, b, c = (self.points[self.twin[self.faces[:, i]]] for i in range(3))
        return float(np.einsum("fi,fi->", a, np.cross(b, c)) / 6.0)

    def reversed(self) -> Tagged:
        """The same mesh turned inside out."""
        return Tagged(self.points, self.twin, self.values, np.ascontiguousarray(self.faces[:, ::-1]), self.tag)


def groove_mesh(groove: GrooveBody, track: Track, ridge: float, sag: float) -> Tagged:
    """A groove body as a closed mesh on the fitted patches, its triangles within about `sag` mm of them."""
    along = [max(2, _cells([row[i] for row in groove.fits], 0, sag)) for i in range(len(groove.fits[0]))]
    across = [_cells(row, 1, sag) if row[0].v.degree > 1 else 1 for row in groove.fits]
    stations, rows = np.concatenate([[0], np.cumsum(along)]), np.concatenate([[0], np.cumsum(across)])
    wide, count = int(rows[-1]) + 2, int(stations[-1]) + (0 if groove.closed else 1)
    points, faces, tags = np.zeros((count * wide, 3)), [], []
    corners, twins, values = [points], [np.arange(count * wide)], [np.zeros((count * wide, 2))]
    same = np.arange(count * wide)
    size = count * wide
    for k, row in enumerate(groove.fits):
        for i, fit in enumerate(row):
            u = np.linspace(fit.u.start, fit.u.stop, along[i] + 1)
            v = np.linspace(0.0, 1.0, across[k] + 1)
            grid = _grid(fit, u, v)
            place = (stations[i] + np.arange(along[i] + 1))[:, None] % max(count, 1) * wide
            index = place + rows[k] + np.arange(across[k] + 1)
            points[index] = grid
            _pinch(same, index, grid)
            own = size + np.arange(index.size).reshape(index.shape)
            size += index.size
            corners.append(grid.reshape(-1, 3))
            twins.append(index.ravel())
            values.append(np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2))
            cells = cell_faces(own[:-1, :-1], own[1:, :-1], own[1:, 1:], own[:-1, 1:], _rising(grid), False)
            faces.append(cells.reshape(-1, 3))
            tags.append(np.full(len(faces[-1]), groove.numbers[k, i]))
    phi = np.concatenate([np.linspace(*ends, n + 1)[:-1] for ends, n in zip(pairwise(groove.knots), along)])
    phi = phi if groove.closed else np.append(phi, groove.knots[-1])
    pose = track.pose(phi, 0)
    points[wide - 1 :: wide] = (pose.a[0] + ridge * pose.u[0]).T
    lid = _lid(count, wide, groove.closed)
    faces.append(lid)
    tags.append(np.full(len(lid), OUTSIDE))
    twin = _settled(same)[np.concatenate(twins)]
    whole = Tagged(np.concatenate(corners), twin, np.concatenate(values), np.concatenate(faces), np.concatenate(tags))
    whole = _without_slivers(whole)
    return whole.reversed() if whole.volume() < 0.0 else whole


def _cells(fits: Sequence[SurfaceFit], axis: int, sag: float) -> int:
    """Cells along one parameter that keep the sag (mm) of all fits: second differences of a coarse grid."""
    probe = 16
    worst = 0.0
    for fit in fits:
        shares = [np.linspace(b.start, b.stop, probe + 1 if a == axis else 5) for a, b in enumerate((fit.u, fit.v))]
        x = np.moveaxis(_grid(fit, *shares), axis, 0)
        bend = x[2:] - 2.0 * x[1:-1] + x[:-2]
        worst = max(worst, float(np.sqrt((bend * bend).sum(axis=-1)).max()) / 8.0)
    return max(1, ceil(probe * sqrt(worst / sag)))


def _grid(fit: SurfaceFit, u: Floats, v: Floats) -> Floats:
    """Points (n, m, 3) of a fit on a grid."""
    rows = np.einsum("ni,ijc->njc", fit.u.design(u), fit.poles, optimize=True)
    return np.asarray(np.einsum("mj,njc->nmc", fit.v.design(v), rows, optimize=True))


def _rising(grid: Floats) -> npt.NDArray[np.bool_]:
    """The shorter diagonal of each cell: True from (i, j) to (i + 1, j + 1)."""
    d1, d2 = grid[1:, 1:] - grid[:-1, :-1], grid[1:, :-1] - grid[:-1, 1:]
    return np.asarray((d1 * d1).sum(axis=-1) <= (d2 * d2).sum(axis=-1))


def _pinch(same: Ints, index: Ints, grid: Floats) -> None:
    """Rows of a band that has shrunk to nothing at a station share one vertex."""
    gap = grid[:, -1] - grid[:, 0]
    shrunk = (gap * gap).sum(axis=1) < 1e-12
    same[index[shrunk, 1:]] = index[shrunk, :1]


def _settled(same: Ints) -> Ints:
    """Follow the chain of shared vertices to its end."""
    while not np.array_equal(same, same[same]):
        same = same[same]
    return same


def _without_slivers(mesh: Tagged) -> Tagged:
    a, b, c = mesh.twin[mesh.faces].T
    keep = (a != b) & (b != c) & (c != a)
    return Tagged(mesh.points, mesh.twin, mesh.values, mesh.faces[keep], mesh.tag[keep])


def _lid(count: int, wide: int, closed: bool) -> Ints:
    """Triangles from the last row over the ridge to the first row, and the caps of an open body."""
    index = np.arange(count * wide).reshape(count, wide)
    ring = index[:, [wide - 2, wide - 1, 0]]
    here, after = (ring, np.roll(ring, -1, axis=0)) if closed else (ring[:-1], ring[1:])
    rising = np.ones((len(here), 2), dtype=bool)
    lid = cell_faces(here[:, :-1], after[:, :-1], after[:, 1:], here[:, 1:], rising, False).reshape(-1, 3)
    if closed:
        return lid
    caps = [groove_cap(index[0, :-1], index[0, -1]), groove_cap(index[-1, :-1], index[-1, -1])[:, ::-1]]
    return np.concatenate([lid, *caps])


def blank_mesh(blank: Blank, patches: Sequence[Patch], first: int, sag: float) -> Tagged:
    """The blank's mesh within `sag` mm, each triangle tagged with the patch that holds all its vertices."""
    mesh = blank.mesh(sag)
    corners = mesh.vertices[mesh.faces]
    gaps = np.stack([_off(patch, corners) for patch in patches])
    owner = np.argmin(gaps, axis=0)
    if float(gaps[owner, np.arange(len(owner))].max()) > 1e-7:
        raise DesignError("the blank's mesh has triangles on none of its surfaces")
    n = len(mesh.vertices)
    faces = mesh.faces.astype(np.int64)
    return Tagged(mesh.vertices, np.arange(n), np.zeros((n, 2)), faces, first + owner)


def _off(patch: Patch, corners: Floats) -> Floats:
    """Largest distance (f,) of triangles (f, 3, 3) from a patch; infinite outside its sector."""
    surface = patch.surface
    assert not isinstance(surface, SplineSurface)
    flat = corners.reshape(-1, 3)
    gap = np.sqrt(((surface.jet(*surface.locate(flat))[0] - flat) ** 2).sum(axis=1)).reshape(-1, 3).max(axis=1)
    if patch.period is None:
        return np.asarray(gap)
    u0, u1 = sorted(patch.box[0])
    middle = surface.locate(corners.mean(axis=1))[0]
    return np.asarray(np.where((middle - u0) % (2.0 * pi) < u1 - u0, gap, np.inf))


@final
@immutable
class TaggedMesh:
    """The result of the boolean: vertices (v, 3), faces (f, 3), tag (f,), parameters at the corners (f, 3, 2)."""

    vertices: Floats
    faces: Ints
    tag: Ints
    values: Floats


def subtract_tagged(blank: Tagged, tools: Sequence[Tagged]) -> TaggedMesh:
    """Blank minus all tools with tags and parameters kept. Raises GeometryEngineError where the engine refuses."""
    manifold3d = library()

    numbers: dict[int, int] = {}
    solids = [_manifold(mesh, numbers) for mesh in (blank, *tools)]
    result = manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Subtract)
    checked(result, f"subtract of {len(solids)} bodies")
    raw = result.to_mesh64()
    table = np.asarray(raw.vert_properties)
    corners = np.asarray(raw.tri_verts).astype(np.int64)
    twin = np.arange(len(table))
    twin[np.asarray(raw.merge_from_vert).astype(np.int64)] = np.asarray(raw.merge_to_vert).astype(np.int64)
    used, faces = np.unique(twin[corners], return_inverse=True)
    tag = np.empty(len(corners), dtype=np.int64)
    bounds, ids = np.asarray(raw.run_index).astype(np.int64) // 3, np.asarray(raw.run_original_id)
    for start, stop, number in zip(bounds[:-1], bounds[1:], ids):
        tag[start:stop] = numbers[int(number)]
    return TaggedMesh(table[used, :3], faces.reshape(-1, 3), tag, table[corners, 3:5])


def _manifold(mesh: Tagged, numbers: dict[int, int]) -> Any:
    manifold3d = library()

    order = np.argsort(mesh.tag, kind="stable")
    tags, starts = np.unique(mesh.tag[order], return_index=True)
    first = manifold3d.Manifold.reserve_ids(len(tags))
    ids = np.arange(first, first + len(tags), dtype=np.uint32)
    numbers.update(zip(ids.tolist(), tags.tolist()))
    table = np.concatenate([mesh.points[mesh.twin], mesh.values], axis=1)
    doubled = np.nonzero(mesh.twin != np.arange(len(mesh.twin)))[0]
    solid = manifold3d.Manifold(
        manifold3d.Mesh64(
            vert_properties=np.ascontiguousarray(table),
            tri_verts=np.ascontiguousarray(mesh.faces[order].astype(np.uint64)),
            merge_from_vert=doubled.astype(np.uint64),
            merge_to_vert=mesh.twin[doubled].astype(np.uint64),
            run_index=np.append(3 * starts, 3 * len(mesh.faces)).astype(np.uint64),
            run_original_id=ids,
        )
    )
    checked(solid, "input body")
    return solid




@final
@immutable
class Chain:
    """Mesh edges between two regions.

    path         (n + 1,) vertices; the left region is on the left seen from outside
    left, right  regions; at_left, at_right: parameters (n + 1, 2) of the path on their patches
    """

    path: Ints
    left: int
    right: int
    at_left: Floats
    at_right: Floats


@final
@immutable
class Regions:
    """Owner (f,) of each triangle, tag (r,) the patch of each region, chains, loops of (chain, forward) by region."""

    owner: Ints
    tag: Ints
    chains: tuple[Chain, ...]
    loops: Loops


def regions_of(cut: TaggedMesh) -> Regions:
    """Regions, chains and loops of a closed mesh. Raises DesignError where a region's border is no set of rings."""
    opposite = _opposite(cut.faces)
    owner = _connected(cut.tag, opposite)
    first = np.unique(owner, return_index=True)[1]
    border = np.nonzero(np.repeat(owner, 3) != owner[opposite // 3])[0]
    chains = _chains(cut, owner, opposite, border)
    loops = _loops(chains, len(first))
    return Regions(owner, cut.tag[first], tuple(chains), loops)


def _opposite(faces: Ints) -> Ints:
    """Number 3 f + k of the half-edge that runs against each half-edge, (3 f,)."""
    start, end = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    size = np.int64(faces.max()) + 1
    forward, backward = start * size + end, end * size + start
    order = np.argsort(forward)
    at = np.minimum(np.searchsorted(forward, backward, sorter=order), len(order) - 1)
    found = order[at]
    if not np.array_equal(forward[found], backward) or np.any(np.diff(forward[order]) == 0):
        raise DesignError("the cut mesh is not closed")
    return np.asarray(found)


def _connected(tag: Ints, opposite: Ints) -> Ints:
    """Connected region (f,) of each triangle over edges inside one patch, numbered from 0."""
    a, b = np.repeat(np.arange(len(tag)), 3), opposite // 3
    inner = (tag[a] == tag[b]) & (a < b)
    return np.unique(joined(len(tag), a[inner], b[inner]), return_inverse=True)[1].astype(np.int64)


def _chains(cut: TaggedMesh, owner: Ints, opposite: Ints, border: Ints) -> list[Chain]:
    start = cut.faces.ravel()
    end = cut.faces[:, [1, 2, 0]].ravel()
    once = border[border < opposite[border]]
    degree = np.bincount(np.concatenate([start[once], end[once]]), minlength=len(cut.vertices))
    touching: dict[int, list[int]] = {}
    for h in border.tolist():
        touching.setdefault(int(start[h]), []).append(h)
    corners = set(np.nonzero((degree != 0) & (degree != 2))[0].tolist())
    left_over = set(border.tolist())
    found: list[Chain] = []

    def run(h: int) -> None:
        path = [h]
        while int(end[path[-1]]) not in corners:
            back = int(opposite[path[-1]])
            path.append(next(n for n in touching[int(end[path[-1]])] if n != back))
        if min(path) > min(int(opposite[p]) for p in path):  # each chain once, from its lowest half-edge
            path = [int(opposite[p]) for p in reversed(path)]
        left_over.difference_update(path)
        left_over.difference_update(int(opposite[p]) for p in path)
        found.append(_chain(cut, owner, opposite, np.array(path)))

    for corner in sorted(corners):
        for h in touching[corner]:
            if h in left_over:
                run(h)
    while left_over:
        ring = [min(left_over)]
        while (at := int(end[ring[-1]])) != int(start[ring[0]]):
            back = int(opposite[ring[-1]])
            ring.append(next(n for n in touching[at] if n != back))
        corners.update((int(start[ring[0]]), int(start[ring[len(ring) // 2]])))
        run(ring[0])
        run(ring[len(ring) // 2])
    return found


def _chain(cut: TaggedMesh, owner: Ints, opposite: Ints, path: Ints) -> Chain:
    start, end = cut.faces.ravel(), cut.faces[:, [1, 2, 0]].ravel()
    here, there = cut.values.reshape(-1, 2), cut.values[:, [1, 2, 0]].reshape(-1, 2)
    back = opposite[path]
    owners = distinct(owner[path // 3]), distinct(owner[back // 3])
    if len(owners[0]) != 1 or len(owners[1]) != 1:
        raise DesignError("a border changes its sides without a corner")
    return Chain(
        np.append(start[path], end[path[-1]]),
        int(owners[0][0]),
        int(owners[1][0]),
        np.concatenate([here[path], there[path[-1:]]]),
        np.concatenate([there[back], here[back[-1:]]]),
    )


def _loops(chains: list[Chain], count: int) -> Loops:
    """For each region its border as rings of chains, the region on the left."""
    leaving: list[dict[int, tuple[int, bool]]] = [{} for _ in range(count)]
    for number, chain in enumerate(chains):
        for region, forward in ((chain.left, True), (chain.right, False)):
            at = int(chain.path[0 if forward else -1])
            if at in leaving[region]:
                raise DesignError("a face touches itself in a corner")
            leaving[region][at] = (number, forward)
    result = []
    for border in leaving:
        rings = []
        while border:
            at = next(iter(border))
            ring = []
            while at in border:
                use = border.pop(at)
                ring.append(use)
                at = int(chains[use[0]].path[-1 if use[1] else 0])
            rings.append(tuple(ring))
        result.append(tuple(rings))
    return tuple(result)
