"""A ring of 20-node hexahedra: one section of quadratic quadrilaterals swept round the axis, nodes on the true faces.

Corners of the hexahedra stand in planes of azimuth psi, their middles between two in the plane half way. The nodes of
one plane and of the plane half way to the next are numbered on, plane by plane; in a plane all are the same order.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol, final

import numpy as np
import numpy.typing as npt

from camgeom.body.element import FOLDED, least_volume
from camgeom.body.hexes import merged
from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.frozen import cached_property
from camgeom.track import TURN

Index = npt.NDArray[np.int64]
WIDEST = (TURN / 18.0, TURN / 30.0, TURN / 60.0)
"""rad; steps between planes far from the load, tried in turn"""
CHUNK = 24
"""planes whose nodes are computed together"""


class SweptSection(Protocol):
    """What is swept: a cross-section in blocks of quadratic quadrilaterals, the layer below the loaded flank first."""

    @property
    def rows(self) -> Floats:
        """Places along the contour of the nodes of the layer's first row: ends and middles of cells."""

    @property
    def notes(self) -> tuple[str, ...]:
        """In what the meshed body differs from the true one."""

    def blocks(self, psi: Floats) -> list[tuple[Floats, Floats]]:
        """z and r (n, i, j) of the nodes of every block at azimuths (n,); i runs into the material in the layer."""

    def sets(self, grids: Sequence[Index]) -> dict[str, list[Index]]:
        """Nodes on the faces of the body by name, from the node numbers (i, j) of the blocks."""


@final
@immutable
class RingMesh:
    """Hexahedra round the axis.

    planes   (n,) azimuths of the corner planes, ascending within one turn, rad
    face     (n, f, 3) nodes in the planes; middle: (n, m, 3) nodes half way from each to the next
    quads    (q, 8) nodes of a plane of every quadrilateral: 4 corners, counter-clockwise in (z, r), and 4 middles
    corner   (f,) number among the nodes half way, -1 of middles of edges
    sets     node numbers of a plane by name
    contour  (a, b) quadrilaterals of the graded layer's first row, in order along the groove's contour
    """

    section: SweptSection
    planes: Floats
    face: Floats
    middle: Floats
    quads: Index
    corner: Index
    sets: Mapping[str, Index]
    contour: Index

    @property
    def per_plane(self) -> int:
        """Nodes from one plane to the next."""
        return int(self.face.shape[1] + self.middle.shape[1])

    @cached_property
    def nodes(self) -> Floats:
        """All nodes (v, 3), mm, cam frame."""
        return np.concatenate([self.face, self.middle], axis=1).reshape(-1, 3)

    @cached_property
    def local(self) -> Index:
        """Nodes (q, 20) of the elements between two planes, counted from the first one's; Abaqus' and VTK's order."""
        f, ahead = self.face.shape[1], self.per_plane
        low, high = self.quads, self.quads + ahead
        upright = f + self.corner[self.quads[:, :4]]
        return np.concatenate([low[:, :4], high[:, :4], low[:, 4:], high[:, 4:], upright], axis=1)

    @cached_property
    def elements(self) -> Index:
        """All elements (n q, 20)."""
        n = len(self.planes)
        start = self.per_plane * np.arange(n)[:, None, None]
        return np.asarray((self.local[None] + start) % (n * self.per_plane)).reshape(-1, 20)

    def node_set(self, name: str) -> Index:
        """Numbers of all nodes of a named set."""
        inside, f = self.sets[name], self.face.shape[1]
        half = self.corner[inside]
        every = np.concatenate([inside, f + half[half >= 0]])
        return np.asarray((self.per_plane * np.arange(len(self.planes))[:, None] + every).ravel())

    @cached_property
    def steps(self) -> Floats:
        """Azimuth (n,) from every plane to the next, rad."""
        return np.diff(np.append(self.planes, self.planes[0] + TURN))


def ring_of(section: SweptSection, planes: Floats) -> RingMesh:
    """The mesh of a drum's section swept over planes (n,) of azimuth, rad. Raises as `DrumSection.blocks`."""
    steps = np.diff(np.append(planes, planes[0] + TURN))
    psi = np.concatenate([planes, planes + 0.5 * steps])
    flat = [_flat(section.blocks(part)) for part in np.array_split(psi, max(1, len(psi) // CHUNK))]
    z, r = (np.concatenate([one[k] for one in flat]) for k in (0, 1))
    shapes = [block[0].shape[1:] for block in section.blocks(planes[:1])]
    number, first = merged(np.stack([z[0], r[0]], axis=1))
    used, cells, contour = _cells(shapes, number)
    keep = first[used]
    new = np.full(int(number.max()) + 1, -1, dtype=np.int64)
    new[used] = np.arange(len(used))
    quads = new[cells]
    corner = np.full(len(used), -1, dtype=np.int64)
    corners = distinct(quads[:, :4])
    corner[corners] = np.arange(len(corners))
    x = np.stack([r * np.cos(psi)[:, None], r * np.sin(psi)[:, None], z], axis=2)[:, keep]
    n = len(planes)
    starts = np.cumsum([0, *(a * b for a, b in shapes)])
    grids = [new[number[s : s + a * b]].reshape(a, b) for s, (a, b) in zip(starts, shapes)]
    sets = {name: _unique(parts) for name, parts in section.sets(grids).items()}
    return RingMesh(section, planes, x[:n], x[n:][:, corners], quads, corner, sets, contour)


def _flat(blocks: list[tuple[Floats, Floats]]) -> tuple[Floats, Floats]:
    z, r = (np.concatenate([block[k].reshape(len(block[k]), -1) for block in blocks], axis=1) for k in (0, 1))
    return z, r


def _cells(shapes: list[tuple[int, ...]], number: Index) -> tuple[Index, Index, Index]:
    """Numbers in use, quadrilaterals (q, 8) of them, and those (k,) of the layer's first row."""
    found, start, contour = [], 0, np.zeros(0, dtype=np.int64)
    for block, (a, b) in enumerate(shapes):
        grid = number[start : start + a * b].reshape(a, b)
        start += a * b
        i, j = np.meshgrid(np.arange(0, a - 2, 2), np.arange(0, b - 2, 2), indexing="ij")
        offsets = ((0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1))
        found.append(np.stack([grid[i + di, j + dj].ravel() for di, dj in offsets], axis=1))
        if block == 0:
            contour = np.arange(j.shape[1])
    quads = np.concatenate(found)
    return distinct(quads), quads, contour


def _unique(parts: Sequence[Index]) -> Index:
    every = distinct(np.concatenate([part.ravel() for part in parts]))
    return every[every >= 0]


def even_planes(count: int) -> Floats:
    """Azimuths of planes at equal steps, rad."""
    return np.linspace(0.0, TURN, count, endpoint=False)


def ring_about(section: SweptSection, azimuth: float, step: float) -> RingMesh:
    """The ring with close planes about one azimuth, rad, and as few elsewhere as leave no element folded.

    Raises DesignError where none will do.
    """
    for widest in WIDEST:
        ring = ring_of(section, planes_about(azimuth, step, widest))
        if least_volume(ring.nodes[ring.elements]) > 0.0:
            return ring
    raise DesignError(FOLDED)


def planes_about(azimuth: float, step: float, widest: float = WIDEST[0], growth: float = 1.25) -> Floats:
    """Azimuths of planes that stand close (step, rad) on both sides of one and wider apart away from it."""
    ahead, at = [0.5 * step], step
    while ahead[-1] < np.pi - 0.7 * at:
        ahead.append(ahead[-1] + at)
        if ahead[-1] > 4.0 * step:
            at = min(at * growth, widest)
    places = np.array(ahead)
    places *= (np.pi - 0.5 * at) / places[-1] if places[-1] > np.pi - 0.5 * at else 1.0
    return np.asarray(np.sort(np.concatenate([azimuth - places, azimuth + places]) % TURN))
