"""A roller against the true profile of its cam: foot point on the pitch curve, penetration and levers (SI units)."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from camgeom.dynamics.impact.lift import Jet, Lift, LiftJets
from camgeom.dynamics.impact.side import Side, Touch, Toucher, TouchMany
from camgeom.dynamics.impact.swing import swing_toucher
from camgeom.errors import NotConverged, Problem, ProfileError
from camgeom.maths import Floats

Complexes = NDArray[np.complex128]

_TAYLOR = 1e-6
"""rad; a correction below this is applied by Taylor, which is exact to rounding"""
_REACH = 0.35
"""rad; Newton may not walk further from the moment's own point; then the bracketed search takes over"""


@final
@dataclass(frozen=True)
class SwingArm:
    """A roller on a rocker: centre at pivot - length e^(-i (q - phase)), q the rocker angle past its lowest [rad]."""

    pivot: float
    length: float
    phase: float

    def pose(self, q: Any, exp: Callable[[Any], Any]) -> tuple[Any, Any, Any]:
        """Roller centre [m] and its first two derivatives over q; `exp` is cmath.exp or numpy.exp."""
        z = self.length * exp(-1j * (q - self.phase))
        return self.pivot - z, 1j * z, z

    def carried(self, point: Any) -> Any:
        """Velocity over q of a point [m] fixed to the follower."""
        return -1j * (point - self.pivot)


@final
@dataclass(frozen=True)
class SlideArm:
    """A roller on a slide: centre at origin + q direction [m], the direction of unit length (1: along +x)."""

    origin: complex
    direction: complex = 1.0 + 0.0j

    def pose(self, q: Any, exp: Callable[[Any], Any]) -> tuple[Any, Any, Any]:
        """Roller centre [m] and its first two derivatives over q."""
        return self.origin + q * self.direction, self.direction, 0.0j

    def carried(self, point: Any) -> Any:
        """Velocity over q of a point [m] fixed to the follower."""
        return self.direction


Arm = SwingArm | SlideArm


@final
@dataclass(frozen=True)
class DiscCurve:
    """The pitch curve of a disc cam, cut for the arm at q = s(u) + shift, turned into the machine frame."""

    arm: Arm
    shift: float = 0.0

    def point(self, e: Any, jet: tuple[Any, Any, Any], exp: Callable[[Any], Any]) -> tuple[Any, Any, Any]:
        """Point [m] at u = phi + e and its derivatives over u; `jet` is the motion at u."""
        s0, s1, s2 = jet
        b, b1, b2 = self.arm.pose(s0 + self.shift, exp)
        turn = exp(-1j * e)
        bs = b1 * s1
        return turn * b, turn * (bs - 1j * b), turn * (b2 * s1 * s1 + b1 * s2 - 2j * bs - b)

    def velocity(self, point: Any) -> Any:
        """Velocity per radian of cam angle of a cam point [m]."""
        return 1j * point


@final
@dataclass(frozen=True)
class DevelopedCurve:
    """The developed pitch curve of a cylindrical cam at a pitch radius: x along the circumference, y the lift [m]."""

    radius: float

    def point(self, e: Any, jet: tuple[Any, Any, Any], exp: Callable[[Any], Any]) -> tuple[Any, Any, Any]:
        """Point [m] at u = phi + e and its derivatives over u."""
        s0, s1, s2 = jet
        return self.radius * e + 1j * s0, self.radius + 1j * s1, 1j * s2

    def velocity(self, point: Any) -> Any:
        """Velocity per radian of cam angle of a cam point [m]."""
        return -self.radius + 0.0 * point


Curve = DiscCurve | DevelopedCurve


@final
@dataclass(frozen=True)
class CurveSide(Side):
    """A roller of `radius` [m] on `arm` against the profile that lies one radius inside its pitch curve.

    `gap` [m] withdraws the profile along its normal; `outward` is +1 where the roller lies to the left of the pitch
    curve's direction, seen along growing angle; `begins` is the deviation at which contact begins if it is constant.
    """

    arm: Arm
    curve: Curve
    radius: float
    push: int
    outward: int = 1
    gap: float = 0.0
    begins: float | None = None

    @property
    def limit(self) -> float | None:
        return self.begins

    @property
    def sense(self) -> int:
        return self.push

    def compiled(self, jets: LiftJets) -> Toucher:
        """A plain function of the contact; Newton for the foot point, a bracketed search where Newton fails."""
        curve, arm, radius, gap = self.curve.point, self.arm, self.radius, self.gap
        pose, exp, at = arm.pose, cmath.exp, jets.at
        carried, velocity, left = arm.carried, self.curve.velocity, 1j * self.outward

        def search(k: int, x: float, p: complex) -> tuple[complex, complex, complex]:
            return _searched(lambda e: curve(e, at(k, x + e), exp), p)

        if isinstance(arm, SwingArm) and isinstance(self.curve, DiscCurve) and self.outward == 1:
            sizes = (arm.pivot, arm.length, arm.phase, self.curve.shift, radius, gap)
            return swing_toucher(jets, *sizes, _TAYLOR, _REACH, search)

        def touch(k: int, x: float, s0: float, s1: float, s2: float, eta: float) -> Touch:
            p, p1, _ = pose(s0 + eta, exp)
            e = 0.0
            c, c1, c2 = curve(0.0, (s0, s1, s2), exp)
            for _ in range(12):
                w = p - c
                size = c1.real * c1.real + c1.imag * c1.imag
                slope = w.real * c2.real + w.imag * c2.imag - size
                if slope > -0.05 * size:
                    break
                de = -(w.real * c1.real + w.imag * c1.imag) / slope
                if -_TAYLOR < de < _TAYLOR:
                    c = c + de * (c1 + 0.5 * de * c2)
                    c1 = c1 + de * c2
                    slope = 0.0
                    break
                e += de
                if not -_REACH < e < _REACH:
                    break
                c, c1, c2 = curve(e, at(k, x + e), exp)
            if slope != 0.0:
                c, c1, c2 = search(k, x, p)
            speed = abs(c1)
            n = left * c1 / speed
            w = p - c
            delta = -(w.real * n.real + w.imag * n.imag) - gap
            foot = p - radius * n
            v, f = velocity(foot), carried(foot)
            bend = (c1.real * c2.imag - c1.imag * c2.real) * self.outward / (speed * speed * speed)
            return (
                delta,
                p1.real * n.real + p1.imag * n.imag,
                v.real * n.real + v.imag * n.imag,
                f.imag * n.real - f.real * n.imag,
                v.imag * n.real - v.real * n.imag,
                -bend / (1.0 + bend * radius),
            )

        return touch

    def many(self, lift: Lift, angle: Floats, eta: Floats) -> TouchMany:
        jet = lift.many(angle, 2)
        p, p1, _ = self.arm.pose(jet[0] + eta, np.exp)
        e = np.zeros_like(angle)
        c, c1, c2 = self.curve.point(e, (jet[0], jet[1], jet[2]), np.exp)
        for _ in range(8):
            w = p - c
            size, slope = np.abs(c1) ** 2, (np.conj(w) * c2).real
            de = (np.conj(w) * c1).real / np.where(slope < 0.95 * size, size - slope, size)
            if np.abs(de).max(initial=0.0) < _TAYLOR:
                c, c1 = c + de * (c1 + 0.5 * de * c2), c1 + de * c2
                break
            e = e + np.clip(de, -0.1, 0.1)
            jet = lift.many(angle + e, 2)
            c, c1, c2 = self.curve.point(e, (jet[0], jet[1], jet[2]), np.exp)
        else:
            lost = np.flatnonzero((np.abs(de) > 1e-9) | (np.abs(e) > _REACH))
            for i in lost:
                c[i], c1[i], c2[i] = _searched(lambda e, i=i: self._one(lift, float(angle[i]), e), complex(p[i]))  # type: ignore[misc]
        return self._measured(p, p1, c, c1, c2)

    def _one(self, lift: Lift, angle: float, e: float) -> tuple[complex, complex, complex]:
        j = lift.many(angle + e, 2)[:, 0]
        jet: Jet = (float(j[0]), float(j[1]), float(j[2]))
        return self.curve.point(e, jet, cmath.exp)

    def _measured(self, p: Complexes, p1: Complexes, c: Complexes, c1: Complexes, c2: Complexes) -> TouchMany:
        speed = np.abs(c1)
        n = 1j * self.outward * c1 / speed
        foot = p - self.radius * n
        v, f = np.conj(self.curve.velocity(foot)), np.conj(self.arm.carried(foot))
        bend = (np.conj(c1) * c2).imag * self.outward / speed**3
        return (
            -(np.conj(p - c) * n).real - self.gap,
            (np.conj(p1) * n).real,
            (v * n).real,
            -(f * n).imag + 0.0 * speed,
            -(v * n).imag,
            -bend / (1.0 + bend * self.radius),
        )


def _searched(
    point: Callable[[float], tuple[complex, complex, complex]], p: complex
) -> tuple[complex, complex, complex]:
    """The nearest point of the curve to p, by sampling and bisection; for kinks of the curvature and large play."""
    count = 64
    grid = [_REACH * (2.0 * i / count - 1.0) for i in range(count + 1)]

    def along(e: float) -> float:
        c, c1, _ = point(e)
        return ((p - c).conjugate() * c1).real

    near = min(range(count + 1), key=lambda i: abs(p - point(grid[i])[0]))
    low, high = grid[max(near - 1, 0)], grid[min(near + 1, count)]
    if not along(low) >= 0.0 >= along(high):
        raise NotConverged(
            "the roller has no nearest point on its cam within 20 degrees: the follower has left the cam; "
            "check clearance, stiffness and inertia"
        )
    for _ in range(80):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        if along(middle) > 0.0:
            low = middle
        else:
            high = middle
    return point(0.5 * (low + high))


def check_profile(side: CurveSide, lift: Lift, what: str) -> list[Problem]:
    """Problems of the profile under a roller: undercut (convex pitch radius below the roller radius)."""
    angle = np.concatenate([np.linspace(a.start, a.end, 183)[1:-1] for a in lift.arcs])
    jet = lift.many(angle, 2)
    _, c1, c2 = side.curve.point(np.zeros_like(angle), (jet[0], jet[1], jet[2]), np.exp)
    bend = (np.conj(c1) * c2).imag * side.outward / np.abs(c1) ** 3
    worst = float((-side.radius * bend).max(initial=-math.inf))
    if worst < 1.0:
        return []
    limit = side.radius / worst
    return [Problem(f"{what}.roller_radius", "the cam is undercut", side.radius, f"< {limit:.6g} m")]


def profile_problem(problems: list[Problem]) -> None:
    """Raise the collected problems, if there are any."""
    if problems:
        raise ProfileError(problems)
