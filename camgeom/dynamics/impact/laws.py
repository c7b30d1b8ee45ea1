"""Contact laws of cam against roller in SI units: normal force over penetration, damping, friction, line pressure.

Every law is a frozen set of numbers with `force` for one penetration (plain floats, the hot path of the solver),
`force_many` for arrays and `energy`, the work stored. A negative penetration gives the odd continuation of the law: an
integrator may look a little beyond the end of a contact before it finds the end, and a kink there would cost steps; the
solver never lets a negative force act.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import final

import numpy as np

from camgeom.errors import NotConverged, Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import Floats, gauss_rule
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.hertz import point_contact

_NODES, _WEIGHTS = gauss_rule(24)


class ContactLaw(ABC):
    """A normal force [N] over the penetration [m]; `curvature` is that of the cam [1/m], convex positive."""

    name: str

    @abstractmethod
    def force(self, delta: float, curvature: float) -> float:
        """Elastic force [N] at one penetration [m]."""

    @abstractmethod
    def force_many(self, delta: Floats, curvature: Floats) -> Floats:
        """Elastic force [N] at an array of penetrations [m]."""

    @property
    def uses_curvature(self) -> bool:
        """Whether the force depends on the curvature at the contact point."""
        return False

    def energy(self, delta: float) -> float:
        """Work [J] stored at a penetration [m]; 0 without contact. The integral of `force` at the reference curvature.

        Gauss quadrature in the square root of the penetration, where every law here is smooth.
        """
        if delta <= 0.0:
            return 0.0
        root = 0.5 * math.sqrt(delta) * (_NODES + 1.0)
        force = self.force_many(root**2, np.zeros_like(root))
        return float(0.5 * math.sqrt(delta) * (_WEIGHTS @ (2.0 * root * force)))


@final
@immutable(eq=True)
class HertzLine(ContactLaw):
    """Line contact of two elastic cylinders: delta = f (ln(d1/b) + ln(d2/b) - 1), f = F/(pi E* L), b^2 = 4 f Re.

    The depths d1, d2 to which the approach is measured are 4 R of each body (its centre); a flat or hollow body has no
    centre on its own side, so its depth must be given. With X = d1 d2/(4 Re) the law reads delta = f (ln(X/f) - 1), for
    two convex cylinders X = 4 (Rb + R). Source: Johnson, Contact Mechanics, section 5.6 (equal materials).

    `modulus` E* [Pa], `length` of the contact [m], `roller_radius` [m] (inf: flat face), `cam_radius` [m] signed
    reference radius of the cam (inf: flat), `true_curvature`: follow the curvature of the cam at the contact point in
    Re instead of the reference.
    """

    modulus: float
    length: float
    roller_radius: float
    cam_radius: float
    cam_depth: float | None = None
    roller_depth: float | None = None
    true_curvature: bool = False
    name: str = "hertz"

    def __post_init__(self) -> None:
        _positive(self, "modulus", "length", "roller_radius")
        for who in ("cam", "roller"):
            radius, depth = getattr(self, f"{who}_radius"), getattr(self, f"{who}_depth")
            if depth is None and not 0.0 < radius < math.inf:
                message = "a flat or hollow body has no centre to measure the approach from"
                raise ProfileError([Problem(f"{who}_depth", message, depth, "> 0 m", "give the depth of the body")])
        if 1.0 / self.cam_radius + 1.0 / self.roller_radius <= 0.0:
            message = "the hollow of the cam is tighter than the roller"
            raise ProfileError([Problem("cam_radius", message, self.cam_radius, f"|r| > {self.roller_radius:g} m")])

    @property
    def uses_curvature(self) -> bool:
        return self.true_curvature

    @cached_property
    def _depths(self) -> float:
        d1 = 4.0 * self.cam_radius if self.cam_depth is None else self.cam_depth
        d2 = 4.0 * self.roller_radius if self.roller_depth is None else self.roller_depth
        return 0.25 * d1 * d2

    @cached_property
    def _reach(self) -> float:
        return self._depths * (1.0 / self.cam_radius + 1.0 / self.roller_radius)

    @cached_property
    def _line(self) -> float:
        return math.pi * self.modulus * self.length

    def force(self, delta: float, curvature: float) -> float:
        depth = delta if delta >= 0.0 else -delta
        if depth == 0.0:
            return 0.0
        reach = self._depths * (curvature + 1.0 / self.roller_radius) if self.true_curvature else self._reach
        m = _log_root(math.log(reach / depth) if reach > 0.0 else 0.0)
        return self._line * delta / m

    def force_many(self, delta: Floats, curvature: Floats) -> Floats:
        size = np.abs(delta)
        if self.true_curvature:
            reach = np.where(curvature == 0.0, self._reach, self._depths * (curvature + 1.0 / self.roller_radius))
        else:
            reach = np.full_like(delta, self._reach)
        level = np.log(np.maximum(reach, 1e-300) / np.maximum(size, 1e-300))
        if np.any(level < _LEAST_LEVEL):
            raise NotConverged(_TOO_DEEP)
        m = level + np.log(level) - 1.0
        for _ in range(3):
            m -= (m - np.log(m) - level + 1.0) / (1.0 - 1.0 / m)
        force: Floats = self._line * delta / m
        return force

    def energy(self, delta: float) -> float:
        """Work [J] stored at the reference curvature: pi E* L f^2/2 (ln(X/f) - 3/2)."""
        if delta <= 0.0:
            return 0.0
        m = _log_root(math.log(self._reach / delta))
        f = delta / m
        return self._line * 0.5 * f * f * (m - 0.5)


_LEAST_LEVEL = 3.0
_TOO_DEEP = (
    "the penetration has left the range of the Hertz line law (a twentieth of the bodies' size); "
    "the contact is far too soft or the speed far too high for the data"
)


def _log_root(level: float) -> float:
    """The root m of m - ln(m) = level - 1 by Newton from an asymptotic start; three steps reach rounding."""
    if level < _LEAST_LEVEL:
        raise NotConverged(_TOO_DEEP)
    log = math.log
    m = level + log(level) - 1.0
    m -= (m - log(m) - level + 1.0) / (1.0 - 1.0 / m)
    m -= (m - log(m) - level + 1.0) / (1.0 - 1.0 / m)
    return m - (m - log(m) - level + 1.0) / (1.0 - 1.0 / m)


@final
@immutable(eq=True)
class LiuCylinder(ContactLaw):
    """The cylinder-joint law F = 1/2 pi E* L delta sqrt(delta/(2 (S + delta))), S the radius difference or sum [m].

    Made for a conformal joint, S = R1 - R2. Between cam and roller S = Rb + R has been used in its place; the force
    then vanishes for a flat cam, which is wrong: `HertzLine` is the law to design with, this one is for comparison.
    """

    modulus: float
    length: float
    radius_sum: float
    name: str = "liu"

    def __post_init__(self) -> None:
        _positive(self, "modulus", "length", "radius_sum")

    def force(self, delta: float, curvature: float) -> float:
        depth = abs(delta)
        return 0.5 * math.pi * self.modulus * self.length * delta * math.sqrt(depth / (2.0 * (self.radius_sum + depth)))

    def force_many(self, delta: Floats, curvature: Floats) -> Floats:
        depth = np.abs(delta)
        force: Floats = (
            0.5 * math.pi * self.modulus * self.length * delta * np.sqrt(depth / (2.0 * (self.radius_sum + depth)))
        )
        return force


@final
@immutable(eq=True)
class PowerLaw(ContactLaw):
    """F = K delta^n with K [N/m^n] and n given; n = 3/2 point contact, 10/9 Palmgren's fit of rollers."""

    stiffness: float
    exponent: float = 1.5
    name: str = "power"

    def __post_init__(self) -> None:
        _positive(self, "stiffness")
        if not 1.0 <= self.exponent <= 3.0:
            raise ProfileError([Problem("exponent", "outside the range of contact laws", self.exponent, "1 to 3")])

    def force(self, delta: float, curvature: float) -> float:
        if delta >= 0.0:
            return self.stiffness * math.pow(delta, self.exponent)
        return -self.stiffness * math.pow(-delta, self.exponent)

    def force_many(self, delta: Floats, curvature: Floats) -> Floats:
        force: Floats = self.stiffness * np.sign(delta) * np.abs(delta) ** self.exponent
        return force

    def energy(self, delta: float) -> float:
        """Work [J] stored: K delta^(n+1)/(n+1)."""
        return self.stiffness * math.pow(max(delta, 0.0), self.exponent + 1.0) / (self.exponent + 1.0)


@final
@immutable(eq=True)
class HertzEllipse(ContactLaw):
    """Point contact of a crowned roller on a straight flank: F = K delta^(3/2), K by the exact elliptic integrals.

    `modulus` E* [Pa], `roller_radius` [m], `cam_radius` [m] signed reference radius of the cam (inf: flat),
    `crown_radius` [m] of the roller's meridian. The crown's arc is taken to be all of the roller. Source: Johnson,
    Contact Mechanics, section 4.2.
    """

    modulus: float
    roller_radius: float
    cam_radius: float
    crown_radius: float
    name: str = "hertz ellipse"

    def __post_init__(self) -> None:
        _positive(self, "modulus", "roller_radius", "crown_radius")
        if 1.0 / self.cam_radius + 1.0 / self.roller_radius <= 0.0:
            message = "the hollow of the cam is tighter than the roller"
            raise ProfileError([Problem("cam_radius", message, self.cam_radius, f"|r| > {self.roller_radius:g} m")])

    @cached_property
    def stiffness(self) -> float:
        """K [N/m^1.5]."""
        across = 1.0 / self.cam_radius + 1.0 / self.roller_radius
        softness = float(point_contact(1.0, across, 1.0 / self.crown_radius, 1.0 / self.modulus).approach)
        return float(softness**-1.5)

    def force(self, delta: float, curvature: float) -> float:
        depth = delta if delta >= 0.0 else -delta
        return self.stiffness * delta * math.sqrt(depth)

    def force_many(self, delta: Floats, curvature: Floats) -> Floats:
        force: Floats = self.stiffness * delta * np.sqrt(np.abs(delta))
        return force

    def energy(self, delta: float) -> float:
        """Work [J] stored: K delta^(5/2) / (5/2)."""
        return 0.4 * self.stiffness * math.pow(max(delta, 0.0), 2.5)


@final
@immutable(eq=True)
class PrintedStiffness(ContactLaw):
    """The stiffness printed as (9) in doi 10.3969/j.issn.1671-024x.2025.05.013, used as F = K(delta) delta^n.

    ERR: K(delta) is the tangent stiffness of the cylinder-joint law with the cube in the denominator and the contact
    length lost, multiplied by delta^n once more; with n = 1.5 the unit is not that of a force. For comparison only.
    """

    modulus: float
    radius_sum: float
    exponent: float = 1.0
    name: str = "printed"

    def __post_init__(self) -> None:
        _positive(self, "modulus", "radius_sum", "exponent")

    def force(self, delta: float, curvature: float) -> float:
        depth, s = abs(delta), self.radius_sum
        stiff = math.sqrt(2.0 * depth / (s + depth)) * (3.0 * s + 2.0 * depth)
        return math.copysign(0.125 * math.pi * self.modulus * stiff * depth**self.exponent, delta)

    def force_many(self, delta: Floats, curvature: Floats) -> Floats:
        depth, s = np.abs(delta), self.radius_sum
        stiff = np.sqrt(2.0 * depth / (s + depth)) * (3.0 * s + 2.0 * depth)
        force: Floats = np.sign(delta) * (0.125 * math.pi * self.modulus) * stiff * depth**self.exponent
        return force


@final
@immutable(eq=True)
class LinePatch:
    """The body data behind a line pressure: contact modulus [Pa], length [m], roller radius [m] (inf: flat face)."""

    modulus: float
    length: float
    roller_radius: float

    def pressure(self, force: Floats, curvature: Floats) -> Floats:
        """Peak Hertz pressure [Pa] sqrt(F E* k/(pi L)), k relative curvature [1/m], of forces and cam curvatures."""
        relative = np.maximum(curvature + 1.0 / self.roller_radius, 0.0)
        inside = np.maximum(force, 0.0) * self.modulus * relative / (math.pi * self.length)
        pressure: Floats = np.sqrt(inside)
        return pressure


@final
@immutable(eq=True)
class EllipsePatch:
    """The body data behind a crown's pressure: contact modulus [Pa], radius of the roller and of its crown [m]."""

    modulus: float
    roller_radius: float
    crown_radius: float

    def pressure(self, force: Floats, curvature: Floats) -> Floats:
        """Peak pressure [Pa] of the exact ellipse, of forces and cam curvatures [1/m]; 0 where a hollow is as tight as
        the roller."""
        relative = curvature + 1.0 / self.roller_radius
        some = relative > 0.0
        found = point_contact(
            np.maximum(force, 0.0), np.where(some, relative, 1.0), 1.0 / self.crown_radius, 1.0 / self.modulus
        )
        return np.where(some, found.pressure, 0.0)


Patch = LinePatch | EllipsePatch


def _positive(law: object, *names: str) -> None:
    problems = [
        Problem(name, "must be positive", getattr(law, name), "> 0") for name in names if not getattr(law, name) > 0.0
    ]
    if problems:
        raise ProfileError(problems)


_SERIES_LIMIT = 0.02
"""below this damping factor the balance is summed as a series: the logarithms would cancel"""


def hybrid_factor(coefficient: float) -> float:
    """The damping factor chi, 1, of the hybrid contact model for a nominal restitution: 3/4 (1 - c^2) e^(2 (1 - c)).

    >>> round(hybrid_factor(0.9), 12)
    0.174049893038
    """
    return 0.75 * (1.0 - coefficient**2) * math.exp(2.0 * (1.0 - coefficient))


def _balance(factor: float, e: float) -> float:
    """Zero where a contact of damping factor chi leaves with e times its approach speed; falls with chi and with e.

    m v dv = -Fe (1 + chi v/v0) ddelta is separable, and the way in and the way out take the same elastic work:
    chi - ln(1 + chi) + chi e + ln(1 - chi e) = 0, whatever the elastic law. Here divided by chi^2.
    """
    if factor < _SERIES_LIMIT:
        terms = ((-factor) ** (k - 2) * (1.0 - (-e) ** k) / k for k in range(2, 14))
        return sum(terms)
    return (factor - math.log1p(factor) + factor * e + math.log1p(-factor * e)) / factor**2


def exact_factor(restitution: float) -> float:
    """The damping factor chi, 1, that gives exactly this restitution (0 < restitution <= 1).

    >>> round(exact_factor(0.9), 8)
    0.16648195
    """
    if not 0.0 < restitution <= 1.0:
        raise ProfileError([Problem("restitution", "no damping factor gives it", restitution, "0 < e <= 1")])
    if restitution == 1.0:
        return 0.0
    return _falling_root(lambda chi: _balance(chi, restitution), 0.0, 1.0 / restitution)


def _falling_root(function: Callable[[float], float], low: float, high: float) -> float:
    """The root inside (low, high) of a function that is positive before it and negative after, to the last digit."""
    while True:
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            return middle
        if function(middle) > 0.0:
            low = middle
        else:
            high = middle


@final
@immutable(eq=True)
class ImpactDamping:
    """Damping proportional to the elastic force: F = Fe (1 + chi v/v0), v0 the approach speed of this contact [m/s].

    `coefficient` 0..1 is the nominal restitution; `exact` chooses chi so that the restitution is that number, otherwise
    the hybrid model's chi is used, whose true restitution differs (0.8959 for 0.9). `speed_floor` [m/s] bounds
    v0 from below (contact that begins at rest). The damping keeps the v0 of the onset for the whole contact, so ripples
    late in a long contact are damped less than a new impact of their speed would be: a property of the model.
    """

    coefficient: float = 0.9
    exact: bool = False
    speed_floor: float = 1e-3

    def __post_init__(self) -> None:
        problems = []
        if not 0.0 < self.coefficient <= 1.0:
            problems.append(Problem("restitution", "outside its range", self.coefficient, "0 < e <= 1"))
        if not self.speed_floor > 0.0:
            problems.append(Problem("speed_floor", "must be positive", self.speed_floor, "> 0 m/s"))
        if problems:
            raise ProfileError(problems)

    @cached_property
    def factor(self) -> float:
        """The damping factor chi, 1."""
        return exact_factor(self.coefficient) if self.exact else hybrid_factor(self.coefficient)


@final
@immutable(eq=True)
class RampedDamping:
    """Viscous damping that grows with the penetration: F = Fe + c ramp(delta/depth) v, ramp = x^2 (3 - 2x) up to 1.

    `coefficient` c [N s/m], `depth` [m] of full damping: the contact damper of general multibody programs.
    """

    coefficient: float
    depth: float

    def __post_init__(self) -> None:
        if not (self.coefficient >= 0.0 and self.depth > 0.0):
            found = (self.coefficient, self.depth)
            raise ProfileError([Problem("damping", "needs a coefficient >= 0 and a depth > 0", found)])

    def viscosity(self, delta: float) -> float:
        """Damping constant [N s/m] at a penetration [m]."""
        x = delta / self.depth
        if x >= 1.0:
            return self.coefficient
        return self.coefficient * x * x * (3.0 - 2.0 * x) if x > 0.0 else 0.0

    def viscosity_many(self, delta: Floats) -> Floats:
        """Damping constant [N s/m] at an array of penetrations [m]."""
        x = np.clip(delta / self.depth, 0.0, 1.0)
        viscosity: Floats = self.coefficient * x * x * (3.0 - 2.0 * x)
        return viscosity


Damping = ImpactDamping | RampedDamping


@final
@immutable(eq=True)
class Coulomb:
    """Dry friction without a jump: odd and continuously differentiable in the sliding speed [m/s].

    `static` at the speed `stick_speed`, `dynamic` from `slip_speed` on, cubic in between and through zero.
    """

    static: float = 0.15
    dynamic: float = 0.10
    stick_speed: float = 0.001
    slip_speed: float = 0.002

    def __post_init__(self) -> None:
        problems = []
        if not 0.0 <= self.dynamic <= self.static:
            problems.append(Problem("friction", "dynamic above static", self.dynamic, "0 <= dynamic <= static"))
        if not 0.0 < self.stick_speed < self.slip_speed:
            problems.append(Problem("slip_speed", "must exceed the stick speed", self.slip_speed, "> stick_speed > 0"))
        if problems:
            raise ProfileError(problems)

    def coefficient(self, speed: float) -> float:
        """The signed friction coefficient, 1, at a sliding speed [m/s]; the force is against the sign."""
        size = speed if speed >= 0.0 else -speed
        if size >= self.slip_speed:
            value = self.dynamic
        elif size >= self.stick_speed:
            x = (size - self.stick_speed) / (self.slip_speed - self.stick_speed)
            value = self.static + (self.dynamic - self.static) * x * x * (3.0 - 2.0 * x)
        else:
            x = (size + self.stick_speed) / (2.0 * self.stick_speed)
            value = self.static * (2.0 * x * x * (3.0 - 2.0 * x) - 1.0)
        return value if speed >= 0.0 else -value

    def coefficient_many(self, speed: Floats) -> Floats:
        """The signed friction coefficients, 1, at an array of sliding speeds [m/s]."""
        size = np.abs(speed)
        x = np.clip((size - self.stick_speed) / (self.slip_speed - self.stick_speed), 0.0, 1.0)
        sliding = self.static + (self.dynamic - self.static) * x * x * (3.0 - 2.0 * x)
        x = (np.minimum(size, self.stick_speed) + self.stick_speed) / (2.0 * self.stick_speed)
        sticking = self.static * (2.0 * x * x * (3.0 - 2.0 * x) - 1.0)
        value: Floats = np.copysign(np.where(size >= self.stick_speed, sliding, sticking), speed)
        return value
