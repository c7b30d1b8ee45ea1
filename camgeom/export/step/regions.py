"""Topology of a tagged mesh: regions of one patch, the chains of mesh edges between two of them, corners and loops.

A corner is a mesh vertex where more (or fewer) than two border edges meet; a chain runs from corner to corner with one
region on its left and one on its right. A border ring without a corner is given two.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.errors import DesignError
from camgeom.export.step.tagged import Cut
from camgeom.maths import Floats

Ints = npt.NDArray[np.int64]
Loops = tuple[tuple[tuple[tuple[int, bool], ...], ...], ...]


@final
@dataclass(frozen=True, eq=False)
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
@dataclass(frozen=True, eq=False)
class Regions:
    """Owner (f,) of each triangle, tag (r,) the patch of each region, chains, loops of (chain, forward) by region."""

    owner: Ints
    tag: Ints
    chains: tuple[Chain, ...]
    loops: Loops


def regions_of(cut: Cut) -> Regions:
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
    a, b = a[inner], b[inner]
    label = np.arange(len(tag))
    while True:
        before = label.copy()
        low = np.minimum(label[a], label[b])
        np.minimum.at(label, a, low)
        np.minimum.at(label, b, low)
        label = label[label]
        if np.array_equal(before, label):
            return np.unique(label, return_inverse=True)[1].astype(np.int64)


def _chains(cut: Cut, owner: Ints, opposite: Ints, border: Ints) -> list[Chain]:
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


def _chain(cut: Cut, owner: Ints, opposite: Ints, path: Ints) -> Chain:
    start, end = cut.faces.ravel(), cut.faces[:, [1, 2, 0]].ravel()
    here, there = cut.values.reshape(-1, 2), cut.values[:, [1, 2, 0]].reshape(-1, 2)
    back = opposite[path]
    owners = np.unique(owner[path // 3]), np.unique(owner[back // 3])
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
