"""Contact stiffness between cam and rollers over the cam angle, from Hertz line contact on the real geometry. SI.

Two estimates of the approach of a roller and a flank that touch along a length L under a force P:

- "chord": the heights of both arcs over the half contact width b, h = rho - sqrt(rho^2 - b^2), as in the source of the
  11-degree model, with its misprints mended (b is the half width, stiffness is P/(h1 + h2)). It counts only what lies
  within the contact width, so it is an upper bound of the stiffness and nearly independent of load and curvature.
- "half-space": the line load on each body with the approach of its centre (Johnson, Contact Mechanics, 5.6): roller
half
  p (1 - nu^2)/(pi E) (2 ln(4 R/b) - 1), cam down to a depth d p (1 - nu^2)/(pi E) (2 ln(2 d/b) - nu/(1 - nu)).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Literal

import numpy as np
import numpy.typing as npt

from camgeom.errors import Problem, ProfileError
from camgeom.maths import Floats

Estimate = Literal["chord", "half-space"]


@dataclass(frozen=True)
class Elastic:
    """Elastic modulus in Pa and Poisson's ratio of one body."""

    modulus: float
    poisson: float

    @property
    def compliance(self) -> float:
        """(1 - nu^2)/E in 1/Pa."""
        return (1.0 - self.poisson**2) / self.modulus


@dataclass(frozen=True, eq=False)
class ContactStiffness:
    """Stiffness (n,) in N/m of the engaged rollers together, half width (n,) in m and approach (n,) in m.

    each (rollers, n) is the stiffness in N/m of every roller, zero where it is not engaged.
    """

    stiffness: Floats
    half_width: Floats
    approach: Floats
    each: Floats

    def torsional(self, lever: npt.ArrayLike) -> Floats:
        """K12 (n,) in N m/rad at the turret, sum of k lever^2: lever in m for each roller (rollers, n), or one pitch
        radius for all.
        """
        return np.asarray((self.each * np.square(np.asarray(lever, dtype=float))).sum(0))


def contact_stiffness(
    relative_curvature: npt.ArrayLike,
    force: npt.ArrayLike,
    length: npt.ArrayLike,
    roller_radius: float,
    cam: Elastic,
    roller: Elastic,
    estimate: Estimate = "half-space",
    depth: float | None = None,
) -> ContactStiffness:
    """Secant stiffness P/approach (n,) in N/m at each cam angle.

    relative_curvature 1/rho1 + 1/rho2 (n,) or (rollers, n) in 1/m, force in N and engaged length in m of the same
    shape; more than one roller adds up, a roller without force or length counts as not engaged. depth in m for "half-
    space", by default the roller radius. Raises ProfileError for data that no contact has (no curvature, no engaged
    roller).
    """
    curvature, load, span = np.broadcast_arrays(
        *(np.atleast_2d(np.asarray(value, dtype=float)) for value in (relative_curvature, force, length))
    )
    _vet(curvature, load, span, roller_radius)
    engaged = (load > 0.0) & (span > 0.0)
    line = np.divide(load, span, out=np.zeros_like(load), where=engaged)
    half = np.sqrt(4.0 * line * (cam.compliance + roller.compliance) / (pi * np.where(engaged, curvature, 1.0)))
    safe = np.where(engaged, half, 1.0)
    if estimate == "chord":
        arc = np.where(engaged, half, 0.0)
        sink = _arc(arc, 1.0 / roller_radius) + _arc(arc, curvature - 1.0 / roller_radius)
    else:
        below = roller_radius if depth is None else depth
        sink = line / pi * roller.compliance * (2.0 * np.log(4.0 * roller_radius / safe) - 1.0)
        shape = 2.0 * np.log(2.0 * below / safe) - cam.poisson / (1.0 - cam.poisson)
        sink = sink + line / pi * cam.compliance * shape
    each = np.divide(load, sink, out=np.zeros_like(load), where=engaged & (sink > 0.0))
    total = each.sum(0)
    if not (total > 0.0).all():
        raise ProfileError([Problem("contact", "no roller is engaged at some cam angle", None, "force and length > 0")])
    return ContactStiffness(total, np.where(engaged, half, 0.0).max(0), load.sum(0) / total, each)


def _arc(half: Floats, curvature: Floats | float) -> Floats:
    """Height in m of an arc of given curvature (1/m, negative when hollow) over a half width: rho - sqrt(rho^2 -
    b^2).
    """
    bend = half * curvature
    if np.any(np.abs(bend) >= 1.0):
        raise ProfileError([Problem("contact", "the contact is wider than the body that makes it", None, "b < rho")])
    # (1 - sqrt(1 - x^2))/k without cancellation
    return np.asarray(half * bend / (1.0 + np.sqrt(1.0 - bend * bend)))


def _vet(curvature: Floats, load: Floats, span: Floats, roller_radius: float) -> None:
    problems = []
    if not np.isfinite([curvature.sum(), load.sum(), span.sum()]).all():
        problems.append(Problem("contact", "needs finite curvature, force and length"))
    elif np.any((curvature <= 0.0) & (load > 0.0)):
        problems.append(Problem("contact.relative_curvature", "must be positive where there is force", None, "> 0 1/m"))
    if not roller_radius > 0.0:
        problems.append(Problem("roller.diameter", "must be positive", roller_radius, "> 0"))
    if problems:
        raise ProfileError(problems)
