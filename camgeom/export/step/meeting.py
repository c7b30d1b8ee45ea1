"""Points where surfaces meet, by Newton's method on their parameters: corners of three, edges of two."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camgeom.errors import NotConverged
from camgeom.export.step.geometry import Surface
from camgeom.maths import Floats

STEPS = 25
ARRIVED = 1e-11
"""mm; a step below which the search has arrived"""
APART = 1e-9
"""mm; surfaces must meet within this"""


def corner(surfaces: Sequence[Surface], guesses: Floats, fixed: Sequence[dict[int, float]]) -> tuple[Floats, Floats]:
    """The point (3,) on all surfaces and its parameters (k, 2), by least squares; raises NotConverged.

    guesses  (k, 2) parameters to start from; fixed: for each surface the parameters (0: u, 1: v) that are given
    """
    at = np.array(guesses, dtype=float)
    for k, given in enumerate(fixed):
        for axis, value in given.items():
            at[k, axis] = value
    free = [(k, axis) for k in range(len(surfaces)) for axis in (0, 1) if axis not in fixed[k]]
    gap = np.inf
    for _ in range(STEPS):
        jets = [surface.jet(at[k : k + 1, 0], at[k : k + 1, 1]) for k, surface in enumerate(surfaces)]
        points = np.array([jet[0][0] for jet in jets])
        middle = points.mean(axis=0)
        gap = float(np.abs(points - middle).max())
        if not free:
            return middle, at
        # Unknowns: the point, then the free parameters, each scaled to mm.
        matrix = np.zeros((3 * len(surfaces), 3 + len(free)))
        scale = np.ones(3 + len(free))
        for k in range(len(surfaces)):
            matrix[3 * k : 3 * k + 3, :3] = np.eye(3)
        for j, (k, axis) in enumerate(free):
            tangent = jets[k][1 + axis][0]
            scale[3 + j] = max(float(np.sqrt(tangent @ tangent)), 1e-12)
            matrix[3 * k : 3 * k + 3, 3 + j] = -tangent / scale[3 + j]
        step = np.linalg.lstsq(matrix, (points - middle).ravel(), rcond=1e-12)[0]
        for j, (k, axis) in enumerate(free):
            at[k, axis] += step[3 + j] / scale[3 + j]
        if np.abs(step).max() < ARRIVED:
            break
    if not gap < APART:
        raise NotConverged(f"{len(surfaces)} surfaces do not meet in a corner: {gap:.3g} mm apart")
    return middle, at


def along(
    first: Surface,
    second: Surface,
    a: Floats,
    b: Floats,
    planes: tuple[Floats, Floats] | None = None,
    held: int | None = None,
) -> tuple[Floats, Floats, Floats]:
    """Points (n, 3) on both surfaces and their parameters (n, 2) on each, from parameters a, b (n, 2) near them.

    Which point of the edge is either said by planes, through points (n, 3) across directions (n, 3), or by one
    parameter that is held: 0, 1 of the first surface, 2, 3 of the second.
    Raises NotConverged where the surfaces do not cross there.
    """
    a, b = a.copy(), b.copy()
    matrix, rest = np.zeros((len(a), 4, 4)), np.zeros((len(a), 4))
    for _ in range(STEPS):
        x, xu, xv = first.jet(a[:, 0], a[:, 1])
        y, yu, yv = second.jet(b[:, 0], b[:, 1])
        tangents = np.stack([xu, xv, -yu, -yv], axis=1)
        sizes = np.sqrt((tangents * tangents).sum(axis=2)) + 1e-150
        tangents /= sizes[:, :, None]
        matrix[:, :3] = tangents.transpose(0, 2, 1)
        rest[:, :3] = y - x
        if planes is not None:
            guide, direction = planes
            across = direction / np.sqrt((direction * direction).sum(axis=1))[:, None]
            matrix[:, 3, :2] = np.einsum("njc,nc->nj", tangents[:, :2], across)
            rest[:, 3] = np.einsum("nc,nc->n", guide - x, across)
        else:
            matrix[:, 3, held] = 1.0
        try:
            step = np.linalg.solve(matrix, rest[:, :, None])[:, :, 0]
        except np.linalg.LinAlgError:
            raise NotConverged("two surfaces touch instead of crossing") from None
        if not np.all(np.isfinite(step)):
            raise NotConverged("two surfaces do not cross where the mesh says so")
        if np.abs(step).max() < ARRIVED:
            return x, a, b
        a += step[:, :2] / sizes[:, :2]
        b += step[:, 2:] / sizes[:, 2:]
    gap = float(np.abs(rest[:, :3]).max())
    if not gap < APART:
        raise NotConverged(f"two surfaces do not cross where the mesh says so: {gap:.3g} mm apart")
    return x, a, b
