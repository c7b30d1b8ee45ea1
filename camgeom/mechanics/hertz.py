"""Hertz contact of roller and cam: pressure, width, approach, stresses below the surface; lines and ellipses.

Units mm, N, MPa; `curvature` is the relative curvature of the pair, 1/mm; `compliance` is
(1 - nu1²)/E1 + (1 - nu2²)/E2, 1/MPa. All functions broadcast over arrays of any shape. A curvature that is not
positive is no Hertz contact (the bodies interfere or touch along a surface) and raises DesignError.
Source of the formulas: K. L. Johnson, Contact Mechanics, 1985, chapters 3 to 5.
"""

from __future__ import annotations

from typing import final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats, gauss_rule
from camgeom.maths.extremum import bracketed_root
from camgeom.mechanics.material import Material

GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
SHEAR_DEPTH = float(np.sqrt(GOLDEN))
"""Depth of the largest shear below a line contact over half-width: 0.78615, the root of q² + q = 1 in q = depth²."""
SHEAR_SHARE = float(SHEAR_DEPTH - GOLDEN / np.sqrt(1.0 + GOLDEN))
"""Largest shear below a line contact over peak pressure: 0.30028."""
TOO_WIDE = "the contact is wider than the roller or the cam body"
"""why no approach of two bodies can be given"""


def line_pressure(line_load: ArrayLike, curvature: ArrayLike, compliance: ArrayLike) -> Floats:
    """Peak pressure of a line contact, MPa: sqrt(w k / (pi compliance)), w the load per length in N/mm."""
    load, k = _loaded(line_load), _positive(curvature)
    return np.asarray(np.sqrt(load) * np.sqrt(k) / np.sqrt(np.pi * np.asarray(compliance, dtype=np.float64)))


def line_half_width(line_load: ArrayLike, curvature: ArrayLike, compliance: ArrayLike) -> Floats:
    """Half-width of a line contact, mm: sqrt(4 w compliance / (pi k))."""
    load, k = _loaded(line_load), _positive(curvature)
    return np.asarray(2.0 * np.sqrt(load) * np.sqrt(np.asarray(compliance, dtype=np.float64) / np.pi) / np.sqrt(k))


def allowable_load(pressure: ArrayLike, curvature: ArrayLike, length: ArrayLike, compliance: ArrayLike) -> Floats:
    """Load, N, at which a line contact of this length (mm) reaches the peak pressure (MPa).

    F = pi b rho_e sigma² compliance with rho_e = 1/curvature (T/WLJC 15-2018, equation 35).
    """
    sigma = np.asarray(pressure, dtype=np.float64)
    return np.asarray(np.pi * np.asarray(length, dtype=np.float64) / _positive(curvature)
                      * sigma * sigma * np.asarray(compliance, dtype=np.float64))


def line_flexibility(line_load: ArrayLike, curvature: ArrayLike, roller: Material, cam: Material,
                     radius: ArrayLike, depth: ArrayLike) -> Floats:
    """Elastic approach of roller axis and cam body over the load per length of their line contact, mm²/N.

    line_load: N/mm, positive; radius: of the roller, mm; depth: to which the cam yields, mm. A line contact has no
    approach of its own: it depends on how far away the displacement is taken. Roller: from the contact to its axis,
    (1-nu²)/(pi E) (2 ln(4 r / b) - 1) (Johnson, section 5.6, for a roller pressed from opposite sides, the usual
    estimate); cam: to a depth d, (1-nu²)/(pi E) (2 ln(2 d / b) - nu/(1-nu)) (same section).

    Raises DesignError where the contact is wider than the roller or the depth, so that the formula has no meaning.
    """
    half = line_half_width(line_load, curvature, roller.compliance + cam.compliance)
    r, d = np.asarray(radius, dtype=np.float64), np.asarray(depth, dtype=np.float64)
    if np.any(half > np.minimum(r, d)):
        share = float(np.max(half / np.minimum(r, d)))
        raise DesignError(f"{TOO_WIDE} ({share:.3g} times): half-space theory gives no approach there; lower the load")
    safe = np.maximum(half, 1e-300)
    return flexibility(np.log(4.0 * r / safe), np.log(2.0 * d / safe), roller.compliance, cam.compliance, cam.poisson)


def flexibility(near: Floats, far: Floats, roller: ArrayLike, cam: ArrayLike, poisson: ArrayLike) -> Floats:
    """Approach over load per length, mm²/N, from logarithms of 4 r and 2 d over the half-width; see `line_flexibility`.

    roller, cam: compliances, 1/MPa; poisson: of the cam.
    """
    body = np.asarray(poisson, dtype=np.float64)
    return np.asarray((np.asarray(roller) * (2.0 * near - 1.0) + np.asarray(cam) * (2.0 * far - body / (1.0 - body)))
                      / np.pi)


@final
@immutable
class PointContact:
    """Elliptic contact: peak pressure MPa, semi-axes mm (long, short), elastic approach mm."""

    pressure: Floats
    long: Floats
    short: Floats
    approach: Floats


def point_contact(load: ArrayLike, least_curvature: ArrayLike, most_curvature: ArrayLike,
                  compliance: ArrayLike) -> PointContact:
    """Elliptic Hertz contact under a load in N; relative curvatures, 1/mm, of the two principal planes, least first.

    With t = short/long and the complete elliptic integrals K, D = (K - E)/(1 - t²), B = K - D (modulus² = 1 - t²):
    most/least = B/(t² D), long³ = 3 F compliance D / (pi least), approach = p0 compliance short K.
    Raises DesignError where a curvature is not positive (least = 0 is a line contact).
    """
    force, pair, one, two = np.broadcast_arrays(
        _loaded(load), np.asarray(compliance, dtype=np.float64), _positive(least_curvature), _positive(most_curvature))
    least, most = np.minimum(one, two), np.maximum(one, two)
    t = np.asarray(np.exp(_axis_ratio(np.log(most) - np.log(least))))
    whole, d, _ = elliptic(t)
    long = np.cbrt(3.0 * force * pair * d / np.pi / least)
    short = t * long
    area = np.pi * long * short
    pressure = np.divide(1.5 * force, area, out=np.zeros_like(area), where=area > 0.0)
    return PointContact(pressure, long, short, pressure * pair * short * whole)


@final
@immutable
class CrownedContact:
    """A crowned roller on a straight flank: pressure at the crown's top MPa; semi-axes mm along and around the roller.

    truncated: True where the ellipse is longer than the roller, so that its ends press too: there the pressure is that
    of the middle, and a sharp end has a peak of its own that no half-space theory bounds.
    """

    pressure: Floats
    along: Floats
    around: Floats
    truncated: NDArray[np.bool_]


def crowned_contact(load: ArrayLike, crown_curvature: ArrayLike, curvature: ArrayLike, compliance: ArrayLike,
                    length: ArrayLike, other: ArrayLike | None = None) -> CrownedContact:
    """Contact of a crowned roller, load N, curvature of the crown and relative curvature around, 1/mm, length mm.

    other: length, mm, on the other side of the crest, where `length` is that on one side; else the crest is its middle.

    Where the ellipse ends within the length it is exact. A longer one is the ellipse of that larger load whose part
    within the length carries the given one: with u = length / (2 along) < 1 that part is (3 u - u³)/2, and all lengths
    grow by q, q² = (2 + u³) / (3 u). Without crown (u to 0) this is the line contact, at u = 1 it joins the ellipse
    smoothly. The support that is cut off beyond the ends is not given back to them. Against a half-space solution of
    the roller with sharp ends (tests/mechanics/test_crowned_contact.py; half-widths of 0.004 to 0.036 of the length)
    the middle is 0.3 % high at u = 0.9, 1 to 2 % at 0.7, 2.5 % at 0.5, 5.5 % at 0.3; the mean of the outermost ninth
    is 1, 4 to 7, 7, 8 to 12 % low. So the hardest of nine slices is high down to u = 0.5, and up to 9 % low below, as
    it is of a line contact whose ends are sharp: check `crown-length` warns of both.
    """
    axial, around = np.asarray(crown_curvature, dtype=np.float64), np.asarray(curvature, dtype=np.float64)
    each = point_contact(load, axial, around, compliance)
    lengthwise = np.broadcast_to(axial <= around, each.long.shape)
    along = np.where(lengthwise, each.long, each.short)
    across = np.where(lengthwise, each.short, each.long)
    one = np.asarray(length, dtype=np.float64) * (0.5 if other is None else 1.0)
    two = one if other is None else np.asarray(other, dtype=np.float64)
    grown = _grown(*(np.divide(side, along, out=np.full_like(along, 2.0), where=along > 0.0) for side in (one, two)))
    truncated = np.asarray(along > np.minimum(one, two))
    return CrownedContact(grown * each.pressure, grown * along, grown * across, truncated)


def _grown(first: Floats, second: Floats) -> Floats:
    """By how much an ellipse grows that ends at these shares u, v of its half-length on either side, each above 0.

    Both sides cut: q² = (4 + u³ + v³) / (3 (u + v)); one: q³/2 + 3 q² u/4 - u³/4 = 1.
    """
    u, v = np.minimum(np.minimum(first, second), 1.0), np.maximum(first, second)
    q = np.full_like(u, 2.0 ** (1.0 / 3.0))
    for _ in range(8):
        # From above the root, and convex: every step comes nearer, the last to rounding.
        q = q - (0.5 * q**3 + 0.75 * q * q * u - 0.25 * u**3 - 1.0) / (1.5 * q * (q + u))
    # Where it would grow beyond the farther end too, both cut it.
    return np.asarray(np.where(q > v, np.sqrt((4.0 + u**3 + v**3) / (3.0 * (u + v))), q))


@final
@immutable(eq=True)
class Beneath:
    """What lies below a contact's middle: half_width mm; largest shear, MPa, at shear_depth mm."""

    half_width: float
    shear: float
    shear_depth: float


def beneath_line(pressure: float, curvature: float, compliance: float) -> Beneath:
    """Below a line contact of this peak pressure, MPa: its half-width is 2 p0 compliance / curvature."""
    half = 2.0 * pressure * compliance / curvature
    return Beneath(half, pressure * SHEAR_SHARE, half * SHEAR_DEPTH)


def line_depth(pressure: ArrayLike, curvature: ArrayLike, compliance: ArrayLike) -> Floats:
    """Depth of the largest shear below a line contact, mm, from its peak pressure, MPa."""
    half = 2.0 * np.asarray(pressure, dtype=np.float64) * np.asarray(compliance, dtype=np.float64)
    return np.asarray(half / _positive(curvature) * SHEAR_DEPTH)


def point_depths(ratio: Floats, body: Material) -> Floats:
    """Depth of the largest shear below elliptic contacts over their short semi-axis, by `point_shear`.

    ratio: short over long semi-axis, (...). Between 65 ratios it is linear: exact to a ten thousandth.
    """
    known = np.linspace(float(ratio.min(initial=1.0)), 1.0, 65)
    return np.interp(ratio, known, [point_shear(float(one), body.poisson)[1] for one in known])


def beneath_point(pressure: float, long: float, short: float, poisson: float) -> Beneath:
    """Below an elliptic contact of this peak pressure, MPa, and semi-axes, mm; half_width is the short one."""
    if pressure <= 0.0:
        return Beneath(0.0, 0.0, 0.0)
    share, depth = point_shear(short / long, poisson)
    return Beneath(short, pressure * share, short * depth)


def point_shear(ratio: float, poisson: float) -> tuple[float, float]:
    """Largest shear below the middle of an elliptic contact over peak pressure, and its depth over the short semi-axis.

    ratio: short over long semi-axis. The stresses on the axis (Johnson, equation 3.69) are principal ones.
    """
    t = min(ratio, 1.0 - 1e-5)
    low, high = 0.2, 1.2
    for _ in range(4):
        depth = np.linspace(low, high, 33)
        shear = _axis_shear(depth, t, poisson)
        at = int(np.argmax(shear))
        low, high = depth[max(at - 1, 0)], depth[min(at + 1, 32)]
    return float(shear[at]), float(depth[at])


def _axis_shear(depth: Floats, t: float, poisson: float) -> Floats:
    """Largest shear at depths (n,) over the short semi-axis, over peak pressure."""
    zeta = t * depth
    first, second = _incomplete(1.0 / zeta, t)
    big = np.sqrt((t * t + zeta * zeta) / (1.0 + zeta * zeta))
    scale = t / (1.0 - t * t)
    one = -0.5 * (1.0 - big) + zeta * (first - second)
    one_nu = 1.0 - big / t**2 + zeta * (second / t**2 - first)
    two = 0.5 + 0.5 / big - big / t**2 + zeta * (second / t**2 - first)
    two_nu = -1.0 + big + zeta * (first - second)
    stress = np.stack([
        2.0 * scale * (one + poisson * one_nu), 2.0 * scale * (two + poisson * two_nu), -scale * (1.0 / big - big)
    ])
    return np.asarray(0.5 * np.ptp(stress, axis=0))


def _incomplete(tangent: Floats, t: float) -> tuple[Floats, Floats]:
    """Incomplete elliptic integrals F and E of modulus² 1 - t² up to angles given by their tangent, (n,).

    With tan = sinh v both integrands are smooth also where t is small.
    """
    x, weight = gauss_rule(80)
    end = np.arcsinh(tangent)[:, None]
    v = 0.5 * end * (1.0 + x)
    root = np.sqrt(1.0 + (t * np.sinh(v)) ** 2)
    each = 0.5 * end * weight
    return np.asarray((each / root).sum(axis=1)), np.asarray((each * root / np.cosh(v) ** 2).sum(axis=1))


def _axis_ratio(log_ratio: Floats) -> Floats:
    """ln(short/long) of the contact ellipse from ln(most/least curvature), exact to rounding."""
    wanted = np.atleast_1d(log_ratio)

    def excess(log_t: Floats) -> Floats:
        _, d, b = elliptic(np.exp(log_t))
        return np.asarray(np.log(b / d) - 2.0 * log_t - wanted)

    low = -wanted - 1e-12
    found = bracketed_root(excess, low, np.zeros_like(wanted))
    return np.asarray(np.where(wanted <= 1e-15, 0.0, found).reshape(log_ratio.shape))


def elliptic(ratio: ArrayLike) -> tuple[Floats, Floats, Floats]:
    """Complete elliptic integrals K, D = (K - E)/m and B = K - D for m = 1 - ratio², 0 < ratio <= 1.

    Arithmetic-geometric mean (Gauss); every term of D is positive, so nothing cancels at either end.
    """
    t = np.asarray(ratio, dtype=np.float64)
    a, b = np.ones_like(t), t.copy()
    # c_1² / m = (1 - t)/(4 (1 + t)); the later c_n follow from c_(n+1) = c_n² / (4 a_(n+1)).
    total = np.full_like(t, 0.5)
    c2_over_m = (1.0 - t) / (4.0 * (1.0 + t))
    c = 0.5 * (1.0 - t)
    weight = 1.0
    for _ in range(12):
        total = total + weight * c2_over_m
        a, b = 0.5 * (a + b), np.sqrt(a * b)
        following = c * c / (2.0 * (a + b))
        shrink = np.divide(following, c, out=np.zeros_like(c), where=c > 0.0)
        c2_over_m = c2_over_m * shrink * shrink
        c = following
        weight *= 2.0
    whole = np.pi / (2.0 * a)
    d = whole * total
    return np.asarray(whole), np.asarray(d), np.asarray(whole - d)


def _positive(curvature: ArrayLike) -> Floats:
    k = np.asarray(curvature, dtype=np.float64)
    if not np.all(k > 0.0):
        raise DesignError(f"the relative curvature of cam and roller is {float(np.min(k)):.6g} 1/mm, not positive: the "
                          "roller does not fit the flank; use a smaller roller or a larger cam")
    return k


def _loaded(load: ArrayLike) -> Floats:
    value = np.asarray(load, dtype=np.float64)
    if not np.all(value >= 0.0):
        raise ValueError(f"a contact load is a pressure and cannot be negative (found {float(np.min(value)):.6g})")
    return value
