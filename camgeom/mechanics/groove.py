"""Cylindrical groove cam with a translating follower: curvature, pressure angle, path and contact in closed form.

The general cam gets these from its flank; here they are plain functions of s' and s'', which sweeps over many variants
and tests need. Wall "behind" is the one towards smaller lift, which pushes the follower forward; "ahead" the other.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from camgeom.maths import Floats
from camgeom.mechanics.contact import Contact, line_contacts
from camgeom.mechanics.load import FollowerForce, column
from camgeom.mechanics.material import Material, pair_compliance

Wall = Literal["behind", "ahead"]
Convention = Literal["exact", "developed", "published", "flat", "developed-wall"]
CONVENTIONS: tuple[Convention, ...] = get_args(Convention)
"""How the relative curvature of roller and wall is taken.

exact: the true surface; developed: 1/r - 1/rho, rho the radius of the developed pitch curve (the formula as printed in
doi 10.13705/j.issn.1671-6833.2023.01.017); published: 1/r + 1/rho (what the trends printed there follow); flat: 1/r;
developed-wall: the developed plane with the true wall radius, rho + r on the concave side.
"""


def pitch_curvature(pitch_radius: ArrayLike, ds: ArrayLike, dds: ArrayLike) -> Floats:
    """Signed curvature of the developed pitch curve, 1/mm: R s'' / (R² + s'²)^1.5; positive where s'' is."""
    radius, one, two = _floats(pitch_radius, ds, dds)
    square = radius * radius + one * one
    return np.asarray(radius * two / (square * np.sqrt(square)))


def groove_twist(pitch_radius: ArrayLike, ds: ArrayLike) -> Floats:
    """Twist of the pitch surface at this radius, 1/mm: s' / (R² + s'²); its Gaussian curvature is minus the square."""
    radius, one = _floats(pitch_radius, ds)
    return np.asarray(one / (radius * radius + one * one))


def path_rate(pitch_radius: ArrayLike, ds: ArrayLike) -> Floats:
    """Path of the roller centre along the groove per cam angle, mm/rad: sqrt(R² + s'²)."""
    radius, one = _floats(pitch_radius, ds)
    return np.asarray(np.sqrt(radius * radius + one * one))


def cos_pressure_angle(pitch_radius: ArrayLike, ds: ArrayLike) -> Floats:
    """Cosine of the pressure angle (1): R / sqrt(R² + s'²), from tan(alpha) = |s'| / R."""
    radius, one = _floats(pitch_radius, ds)
    return np.asarray(radius / np.sqrt(radius * radius + one * one))


def relative_curvature(convention: Convention, wall: Wall, roller_radius: ArrayLike, pitch_radius: ArrayLike,
                       ds: ArrayLike, dds: ArrayLike) -> Floats:
    """Relative curvature of roller and groove wall, 1/mm, at the pitch radius (mm); s' in mm/rad, s'' in mm/rad².

    The flank is the offset of the pitch surface at distance r, mean curvature H and Gaussian curvature K, so that
    k_rel = (1 - r² K) / (r (1 -+ 2 r H + r² K)); with 2H = -kappa (pitch curvature) and K = -twist² the exact value on
    the wall behind is (1 + r² twist²) / (r (1 + r kappa - r² twist²)), ahead with -kappa. The denominator is the
    undercut margin: the result is not positive (or infinite) where the roller undercuts that wall, and Hertz functions
    refuse it. Raises ValueError for an unknown convention.
    """
    r = np.asarray(roller_radius, dtype=np.float64)
    kappa = pitch_curvature(pitch_radius, ds, dds)
    signed = kappa if wall == "behind" else -kappa
    if convention == "exact":
        twist2 = (r * groove_twist(pitch_radius, ds)) ** 2
        margin = 1.0 + r * signed - twist2
        return np.asarray((1.0 + twist2) / (r * _nonzero(margin)))
    if convention == "developed":
        return np.asarray(1.0 / r - np.abs(kappa))
    if convention == "published":
        return np.asarray(1.0 / r + np.abs(kappa))
    if convention == "flat":
        return np.asarray(np.broadcast_to(1.0 / r, np.broadcast_shapes(r.shape, kappa.shape)), dtype=np.float64)
    if convention == "developed-wall":
        return np.asarray(1.0 / (r * _nonzero(1.0 + r * signed)))
    raise ValueError(f"unknown curvature convention {convention!r}; known: {', '.join(CONVENTIONS)}")


def undercut_margin(wall: Wall, roller_radius: ArrayLike, pitch_radius: ArrayLike, ds: ArrayLike,
                    dds: ArrayLike) -> Floats:
    """Margin against undercut of a groove wall (1): 1 - r k_max of the pitch surface; sound while positive."""
    r = np.asarray(roller_radius, dtype=np.float64)
    kappa = pitch_curvature(pitch_radius, ds, dds)
    signed = kappa if wall == "behind" else -kappa
    # The principal curvatures towards the wall are roots of k² + signed k - twist² = 0; the larger one decides.
    twist = groove_twist(pitch_radius, ds)
    return np.asarray(1.0 - r * 0.5 * (np.sqrt(signed * signed + 4.0 * (twist * twist)) - signed))


def _nonzero(margin: Floats) -> Floats:
    """The margin with an exact zero replaced by the smallest negative number, so that a cusp reads as undercut."""
    return np.asarray(np.where(margin == 0.0, -1e-300, margin))


def _floats(*values: ArrayLike) -> tuple[Floats, ...]:
    return tuple(np.asarray(value, dtype=np.float64) for value in values)


def groove_contact(load: FollowerForce, pitch_radius: ArrayLike, roller_radius: ArrayLike, length: ArrayLike,
                   roller: Material, cam: Material, convention: Convention = "exact",
                   guide_friction: ArrayLike = 0.0) -> Contact:
    """Contact of a roller in a cylindrical groove, follower translating along the axis; radii and length in mm.

    Any of the numbers may be an array of variants (...), of the shape of the load's variants or broadcast with it.
    Force, curvature and rolling path are taken at the pitch radius; see `CONVENTIONS`.
    """
    big, small, long = (column(x) for x in (pitch_radius, roller_radius, length))
    normal = load.normal(cos_pressure_angle(big, load.ds), guide_friction=guide_friction)
    behind = relative_curvature(convention, "behind", small, big, load.ds, load.dds)
    ahead = relative_curvature(convention, "ahead", small, big, load.ds, load.dds)
    margins = None if convention != "exact" else (
        undercut_margin("behind", small, big, load.ds, load.dds),
        undercut_margin("ahead", small, big, load.ds, load.dds))
    return line_contacts(load.panels, normal, behind, ahead, path_rate(big, load.ds), long,
                         pair_compliance(roller, cam), margins)
