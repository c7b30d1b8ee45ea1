"""A plane section of a solved ring through the peak at its root: stress over the section, to be coloured."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.body.element import largest_principal, shapes, stresses
from camgeom.body.ring import RingMesh
from camgeom.body.section import GroovedSection
from camgeom.maths import Floats

ACROSS = 9
"""points along each side of a quadrilateral at which the stress is taken"""


@final
@dataclass(frozen=True, eq=False)
class Cut:
    """Largest principal stress in one plane of a ring.

    azimuth  of the plane, rad
    z, r     (p,) places, mm; stress (p,), MPa; outline (k, 2) of the body there, z and r
    depth    of the groove, mm
    """

    azimuth: float
    z: Floats
    r: Floats
    stress: Floats
    outline: Floats
    depth: float

    def window(self, z: float, r: float, size: float, count: int) -> tuple[Floats, Floats, Floats]:
        """Stress (count, count) on an even grid r (count,) by z (count,) within `size` mm of a place, NaN outside."""
        from scipy.interpolate import LinearNDInterpolator

        low, high = self.outline.min(axis=0), self.outline.max(axis=0)
        ends = [(max(at - size, a), min(at + size, b)) for at, a, b in zip((z, r), low, high)]
        step = max(stop - start for start, stop in ends) / count
        along, out = (np.arange(start + 0.5 * step, stop, step) for start, stop in ends)
        grid = np.stack(np.meshgrid(along, out), axis=-1)
        found = LinearNDInterpolator(np.stack([self.z, self.r], axis=1), self.stress)(grid)
        return along, out, np.where(_inside(self.outline, grid), found, np.nan)


def cut_of(ring: RingMesh, moved: Floats, material: Floats, section: GroovedSection, azimuth: float) -> Cut:
    """The plane of the mesh next to an azimuth, rad, of displacements (v, 3), mm."""
    plane = int(np.argmin(np.abs(np.angle(np.exp(1j * (ring.planes - azimuth))))))
    nodes = ring.elements.reshape(len(ring.planes), -1, 20)[plane]
    s = np.linspace(-1.0, 1.0, ACROSS)
    at = np.stack([*(one.ravel() for one in np.meshgrid(s, s)), np.full(ACROSS**2, -1.0)], axis=1)
    x = np.einsum("pn,enk->epk", shapes(at)[0], ring.nodes[nodes])
    found = largest_principal(stresses(ring.nodes[nodes], moved[nodes], at, material))
    r = np.hypot(x[..., 0], x[..., 1])
    psi = float(ring.planes[plane])
    return Cut(psi, x[..., 2].ravel(), r.ravel(), found.ravel(), section.outline(psi), section.groove.shape.depth)


def _inside(outline: Floats, points: Floats) -> npt.NDArray[np.bool_]:
    """Whether points (..., 2) lie within a closed polygon (k, 2): an odd number of its edges is crossed to one side."""
    found = np.zeros(points.shape[:-1], dtype=bool)
    x, y = points[..., 0], points[..., 1]
    for (x0, y0), (x1, y1) in zip(outline, np.roll(outline, -1, axis=0)):
        crossed = (y0 > y) != (y1 > y)
        found ^= crossed & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0 if y1 != y0 else 1.0))
    return found
