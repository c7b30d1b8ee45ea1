"""The elastohydrodynamic film between roller or face and cam, and its ratio to the roughness of both surfaces.

    line     h / R  = 2.65 U^0.70 G^0.54 W^-0.13,     W = w / (E' R)              (Dowson and Higginson 1966)
    ellipse  h / Rx = 3.63 U^0.68 G^0.49 W^-0.073 (1 - e^(-0.68 k)),  W = F / (E' Rx²)  (Hamrock and Dowson 1977)
    U = eta0 u / (E' R),  G = alpha E',  2 / E' = sum (1 - nu²)/E,  lambda = h / sqrt(Rq1² + Rq2²)

h is the least thickness, R the relative radius along the motion, k the axis of the ellipse across the motion over the
one along it, u the mean of both surface speeds relative to the contact, which moves. E' is twice the contact modulus.
Units mm, N, MPa, s; viscosity MPa s.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme
from camgeom.mechanics.lubricant import Lubricant
from camgeom.mechanics.material import Material

FITTED = (1.0, 8.0)
"""ratios k for which the formula of the ellipse was fitted"""
MICRO = 1e-3
"""um in mm"""
PASCAL = 1e-6
"""Pa in MPa"""
GIGA = 1e-3
"""1/GPa in 1/MPa"""


@final
@immutable(eq=True)
class Oil:
    """A lubricant between two surfaces: viscosity eta0 at the inlet, MPa s, pressure-viscosity coefficient alpha,
    1/MPa, and the roughness of both together, sqrt(Rq1² + Rq2²), mm."""

    viscosity: float
    thickening: float
    roughness: float

    @classmethod
    def between(cls, lubricant: Lubricant | None, first: Material, second: Material) -> Oil | None:
        """What a film takes; None where one of its keys is missing."""
        if lubricant is None or lubricant.pressure_viscosity is None:
            return None
        if first.roughness_um is None or second.roughness_um is None:
            return None
        rough = float(np.hypot(first.roughness_um, second.roughness_um)) * MICRO
        return cls(lubricant.dynamic_viscosity * PASCAL, lubricant.pressure_viscosity * GIGA, rough)


@final
@immutable
class Film:
    """The film over a turn where something bears: cam angles (n,), rad, increasing, and ratio lambda (n,), 1.

    least: the least ratio, and where; thickness: that of it, mm; ellipse: the ratio k there, None of a line
    """

    theta: Floats
    ratio: Floats
    least: Extreme
    thickness: float
    ellipse: float | None = None

    @property
    def fitted(self) -> bool:
        """False where the ellipse there is beyond those for which the formula was fitted."""
        return self.ellipse is None or FITTED[0] <= self.ellipse <= FITTED[1]


def line_film(speed: ArrayLike, curvature: ArrayLike, line_load: ArrayLike, oil: Oil, compliance: float) -> Floats:
    """Least film of a line contact, mm: mean speed u mm/s, relative curvature 1/mm, load w N/mm, all above 0."""
    u, k, w = (np.asarray(value, dtype=np.float64) for value in (speed, curvature, line_load))
    modulus = 2.0 / compliance
    thick = (oil.viscosity * u * k / modulus) ** 0.70 * (oil.thickening * modulus) ** 0.54
    return np.asarray(2.65 / k * thick * (w * k / modulus) ** -0.13)


def point_film(
    speed: ArrayLike, curvature: ArrayLike, load: ArrayLike, ratio: ArrayLike, oil: Oil, compliance: float
) -> Floats:
    """Least film of an elliptic contact, mm: u mm/s, relative curvature along the motion 1/mm, F N, all above 0; k."""
    u, k, f = (np.asarray(value, dtype=np.float64) for value in (speed, curvature, load))
    modulus = 2.0 / compliance
    thick = (oil.viscosity * u * k / modulus) ** 0.68 * (oil.thickening * modulus) ** 0.49
    side = 1.0 - np.exp(-0.68 * np.asarray(ratio, dtype=np.float64))
    return np.asarray(3.63 / k * thick * (f * k * k / modulus) ** -0.073 * side)


def thinnest(
    theta: Floats, ratio: Floats, oil: Oil, ellipse: Floats | None = None, place: Floats | None = None,
    where: Callable[[int], str] = lambda at: "",
) -> Film | None:
    """The film over a turn from ratios lambda at cam angles, alike in shape, infinite where nothing bears; None if so.

    ellipse: the ratio k, place: mm along the roller, where: in words, of a flat index
    """
    bears = np.flatnonzero(np.isfinite(ratio))
    if not bears.size:
        return None
    order = bears[np.argsort(theta.ravel()[bears], kind="stable")]
    at = int(order[np.argmin(ratio.ravel()[order])])
    least = Extreme(
        float(ratio.flat[at]), float(theta.flat[at]), 0.0 if place is None else float(place.flat[at]), where(at)
    )
    k = None if ellipse is None else float(ellipse.flat[at])
    return Film(theta.ravel()[order], ratio.ravel()[order], least, least.value * oil.roughness, k)
