"""Outside surfaces that grooves are cut into, between which the lands lie: as a level field, and unrolled.

Unrolled, a surface of revolution about Z is a plane: the polar angle psi about Z, and w along the meridian.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import asin
from typing import Protocol

import numpy as np

from camgeom.maths import Floats
from camgeom.solid.blank import Blank
from camgeom.track.section import CylinderLevel


@dataclass(frozen=True)
class GloboidLevel:
    """Field of the globoid of `radius` about a turret axis at `centre` from the cam axis: positive outside the cam."""

    centre: float
    radius: float

    def __call__(self, x: Floats) -> Floats:
        """Radius - distance of the meridian point from the turret centre, mm."""
        rho = np.sqrt(x[0] * x[0] + x[1] * x[1]) - self.centre
        return np.asarray(self.radius - np.sqrt(rho * rho + x[2] * x[2]))


class Land(Protocol):
    """The outside of a blank of revolution as a surface with coordinates."""

    @property
    def level(self) -> GloboidLevel | CylinderLevel:
        """Its level field."""

    def along(self, x: Floats) -> Floats:
        """The coordinate w of points (3, ...)."""

    def points(self, psi: Floats, w: Floats) -> Floats:
        """Points (3, ...) at polar angle psi (rad) and w."""

    def at_height(self, z: float) -> float:
        """The w at height z (mm)."""

    def sag(self, psi: Floats, w: Floats, middle: Floats) -> Floats:
        """How far the middle of short chords lies off the surface, mm: steps in psi and in w, and w half way."""


@dataclass(frozen=True)
class GloboidLand:
    """A globoid: w is the angle (rad) about the turret axis from the line across both axes."""

    level: GloboidLevel

    def along(self, x: Floats) -> Floats:
        """w (rad) of points (3, ...)."""
        return np.asarray(np.arctan2(x[2], self.level.centre - np.sqrt(x[0] * x[0] + x[1] * x[1])))

    def points(self, psi: Floats, w: Floats) -> Floats:
        """Points (3, ...) at polar angle psi (rad) and w (rad)."""
        rho = self.level.centre - self.level.radius * np.cos(w)
        return np.stack([rho * np.cos(psi), rho * np.sin(psi), self.level.radius * np.sin(w)])

    def at_height(self, z: float) -> float:
        """w (rad) at height z (mm)."""
        return asin(z / self.level.radius)

    def sag(self, psi: Floats, w: Floats, middle: Floats) -> Floats:
        """Sag of short chords, mm: bent outward round the axis, inward along the meridian."""
        cosine, radius = np.cos(middle), self.level.radius
        return np.asarray(np.abs(radius * w * w - (self.level.centre - radius * cosine) * cosine * psi * psi) / 8.0)


@dataclass(frozen=True)
class CylinderLand:
    """A cylinder about Z: w is the height (mm)."""

    level: CylinderLevel

    def along(self, x: Floats) -> Floats:
        """w (mm) of points (3, ...)."""
        return np.asarray(x[2])

    def points(self, psi: Floats, w: Floats) -> Floats:
        """Points (3, ...) at polar angle psi (rad) and w (mm)."""
        radius = self.level.radius
        return np.stack([radius * np.cos(psi), radius * np.sin(psi), w])

    def at_height(self, z: float) -> float:
        """w (mm) at height z (mm)."""
        return z

    def sag(self, psi: Floats, w: Floats, middle: Floats) -> Floats:
        """Sag of short chords, mm."""
        del w, middle
        return np.asarray(self.level.radius * psi * psi / 8.0)


def land_of(blank: Blank, edge: int) -> GloboidLand | CylinderLand | None:
    """The surface of one outline edge of a blank; None where it is neither a cylinder nor a globoid about z = 0."""
    (r0, z0), (r1, _) = blank.outline[edge : edge + 2]
    arc = blank.arcs[edge] if blank.arcs else None
    if arc is None:
        return CylinderLand(CylinderLevel(r0)) if r0 == r1 else None
    if arc[1] != 0.0 or arc[0] <= max(r0, r1):
        return None
    return GloboidLand(GloboidLevel(arc[0], float(np.hypot(r0 - arc[0], z0))))
