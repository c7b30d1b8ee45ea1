"""Hexahedra of 20 nodes in blocks: lattices of nodes that are joined where they meet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar, final

import numpy as np
import numpy.typing as npt

from camgeom.body.element import EDGES, FOLDED, NATURAL, least_volume, stiffness
from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats

Index = npt.NDArray[np.int64]
SAME = 1e-7
"""mm; nodes of two blocks that stand as near are one"""
FACES = ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 4, 5), (1, 2, 5, 6), (2, 3, 6, 7), (3, 0, 7, 4))
"""corners of an element's faces S1 to S6"""


@final
@immutable
class HexMesh:
    """Hexahedra of 20 nodes: nodes (v, 3), mm; elements (e, 20); node numbers by the name of a set."""

    nodes: Floats
    elements: Index
    sets: Mapping[str, Index]
    edges: ClassVar[tuple[tuple[int, int], ...]] = EDGES

    @staticmethod
    def stiffness(x: Floats, material: Floats) -> Floats:
        """Of elements; see `camgeom.body.element.stiffness`."""
        return stiffness(x, material)

    def faces(self, nodes: Index) -> Index:
        """Element and number of the face (0 to 5), (f, 2), of the faces whose corners are all among some nodes."""
        among = np.zeros(len(self.nodes), dtype=bool)
        among[nodes] = True
        return np.argwhere(among[self.elements[:, np.array(FACES)]].all(axis=2))


def hexahedra(blocks: Sequence[Floats]) -> tuple[Floats, Index]:
    """Nodes (v, 3) and elements (e, 20) of blocks (a, b, c, 3): lattices of corners and middles in turn, of odd sizes.

    Raises DesignError where an element is folded.
    """
    number, first = merged(np.concatenate([block.reshape(-1, 3) for block in blocks]))
    points = np.concatenate([block.reshape(-1, 3) for block in blocks])[first]
    found, start = [], 0
    place = (NATURAL + 1.0).astype(int)
    for block in blocks:
        a, b, c, _ = block.shape
        grid = number[start : start + a * b * c].reshape(a, b, c)
        start += a * b * c
        low = np.stack(np.meshgrid(*(np.arange(0, n - 2, 2) for n in (a, b, c)), indexing="ij"), axis=-1).reshape(-1, 3)
        each = grid[tuple((low[:, None, k] + place[:, k]) for k in range(3))]
        x = points[each[0]]
        if np.linalg.det([x[1] - x[0], x[3] - x[0], x[4] - x[0]]) < 0.0:
            place_back = (NATURAL * np.array([1.0, 1.0, -1.0]) + 1.0).astype(int)
            each = grid[tuple((low[:, None, k] + place_back[:, k]) for k in range(3))]
        found.append(each)
    elements = np.concatenate(found)
    used, elements = np.unique(elements, return_inverse=True)
    nodes, elements = points[used], elements.reshape(-1, 20)
    if least_volume(nodes[elements]) <= 0.0:
        raise DesignError(FOLDED)
    return nodes, elements


def merged(points: Floats) -> tuple[Index, Index]:
    """Number (p,) of the node of every point (p, k), points in one place alike, and one of the points of each node."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(points).query_pairs(SAME, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    count, number = connected_components(graph, directed=False)
    first = np.zeros(count, dtype=np.int64)
    first[number[::-1]] = np.arange(len(points))[::-1]
    return number.astype(np.int64), first
