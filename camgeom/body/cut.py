"""A plane of a solved body beside the peak at its root: stress over it, to be coloured."""

from __future__ import annotations

from collections.abc import Callable
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.body.element import largest_principal, shapes, stresses
from camgeom.body.hexes import HexMesh
from camgeom.body.ring import RingMesh
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct

FLAT = 1e-6
"""mm"""
ACROSS = 9
"""points along each side of a quadrilateral at which the stress is taken"""


@final
@immutable
class Cut:
    """Largest principal stress in one plane of a ring, or at one height of a frame's plate.

    azimuth  of the plane, rad; None on a plate
    z, r     (p,) places, mm, on a plate x and y; stress (p,), MPa; outline (k, 2) of the body there, z and r
    depth    of the groove, or of a plate's bent end, mm
    holes    outlines (k, 2) of a plate's window, and of the strips round its guide bores
    """

    azimuth: float | None
    z: Floats
    r: Floats
    stress: Floats
    outline: Floats
    depth: float
    holes: tuple[Floats, ...] = ()

    def place(self, point: Floats) -> tuple[float, float]:
        """z and r, or x and y, of a point (3,)."""
        if self.azimuth is None:
            return float(point[0]), float(point[1])
        return float(point[2]), float(np.hypot(point[0], point[1]))

    def window(self, z: float, r: float, size: float, count: int) -> tuple[Floats, Floats, Floats]:
        """Stress (count, count) on an even grid r (count,) by z (count,) within `size` mm of a place, NaN outside."""
        from scipy.interpolate import LinearNDInterpolator

        low, high = self.outline.min(axis=0), self.outline.max(axis=0)
        ends = [(max(at - size, a), min(at + size, b)) for at, a, b in zip((z, r), low, high)]
        step = max(stop - start for start, stop in ends) / count
        along, out = (np.arange(start + 0.5 * step, stop, step) for start, stop in ends)
        grid = np.stack(np.meshgrid(along, out), axis=-1)
        found = LinearNDInterpolator(np.stack([self.z, self.r], axis=1), self.stress)(grid)
        inside = _inside(self.outline, grid)
        for hole in self.holes:
            inside &= ~_inside(hole, grid)
        return along, out, np.where(inside, found, np.nan)


def cut_of(
    ring: RingMesh, moved: Floats, material: Floats, outline: Callable[[float], Floats], depth: float, azimuth: float
) -> Cut:
    """The plane of the mesh next to an azimuth, rad, of displacements (v, 3), mm, with the body's outline at azimuths.
    """
    plane = int(np.argmin(np.abs(np.angle(np.exp(1j * (ring.planes - azimuth))))))
    nodes = ring.elements.reshape(len(ring.planes), -1, 20)[plane]
    s = np.linspace(-1.0, 1.0, ACROSS)
    at = np.stack([*(one.ravel() for one in np.meshgrid(s, s)), np.full(ACROSS**2, -1.0)], axis=1)
    x = np.einsum("pn,enk->epk", shapes(at)[0], ring.nodes[nodes])
    found = largest_principal(stresses(ring.nodes[nodes], moved[nodes], at, material))
    r = np.hypot(x[..., 0], x[..., 1])
    psi = float(ring.planes[plane])
    return Cut(psi, x[..., 2].ravel(), r.ravel(), found.ravel(), outline(psi), depth)


def plate_cut(mesh: HexMesh, moved: Floats, material: Floats, level: float) -> tuple[Floats, Floats, Floats]:
    """x, y and stress (p,) at a height of a raised mesh of displacements (v, 3), mm; elements that are not raised are
    left out."""
    z = mesh.nodes[mesh.elements[:, :8], 2]
    low, high = z[:, :4].mean(axis=1), z[:, 4:].mean(axis=1)
    flat = (np.ptp(z[:, :4], axis=1) < FLAT) & (np.ptp(z[:, 4:], axis=1) < FLAT)
    on = np.flatnonzero(flat & (np.minimum(low, high) < level + FLAT) & (np.maximum(low, high) > level - FLAT))
    s = np.linspace(-1.0, 1.0, ACROSS // 2 + 1)
    x, found = [], []
    up = 2.0 * (level - low[on]) / (high - low)[on] - 1.0
    for place in distinct(np.round(up, 6)):
        at = np.stack([*(one.ravel() for one in np.meshgrid(s, s)), np.full(len(s) ** 2, place)], axis=1)
        nodes = mesh.elements[on[np.abs(up - place) < 1e-5]]
        x.append(np.einsum("pn,enk->epk", shapes(at)[0], mesh.nodes[nodes]).reshape(-1, 3))
        found.append(largest_principal(stresses(mesh.nodes[nodes], moved[nodes], at, material)).ravel())
    places = np.concatenate(x)
    return places[:, 0], places[:, 1], np.concatenate(found)


def _inside(outline: Floats, points: Floats) -> npt.NDArray[np.bool_]:
    """Whether points (..., 2) lie within a closed polygon (k, 2): an odd number of its edges is crossed to one side."""
    found = np.zeros(points.shape[:-1], dtype=bool)
    x, y = points[..., 0], points[..., 1]
    for (x0, y0), (x1, y1) in zip(outline, np.roll(outline, -1, axis=0)):
        crossed = (y0 > y) != (y1 > y)
        found ^= crossed & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0 if y1 != y0 else 1.0))
    return found
