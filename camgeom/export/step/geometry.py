"""Curves and surfaces of a boundary representation: exact where the shape is elementary, clamped B-splines elsewhere.

All lengths in mm, angles in rad. Every curve has `at(t)` and `locate(points)`, every surface `jet(u, v)` and
`locate(points)`; `locate` gives the parameters of the nearest point and must be asked for points near the shape.
"""

from __future__ import annotations

from math import cos, sin
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.maths.splines import Basis

Vector = tuple[float, float, float]
SETTLED = 1e-13
"""share of a parameter range below which the search for a nearest point has arrived"""
MEET = 1e-8
"""mm; what ought to be one curve, or to meet in one, does so within this"""


def vector(values: npt.ArrayLike) -> Vector:
    """Three floats from any array of three."""
    x, y, z = (float(value) for value in np.asarray(values, dtype=float))
    return x, y, z


def cross(a: Floats, b: Floats) -> Floats:
    """Vector product of two single vectors, without the overhead of the general one."""
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def unit(values: npt.ArrayLike) -> Vector:
    """The unit vector along `values`."""
    array = np.asarray(values, dtype=float)
    return vector(array / np.sqrt(array @ array))


@final
@immutable(eq=True)
class Frame:
    """A right-handed placement: origin (mm), unit axis (its Z) and unit ref (its X, perpendicular to the axis)."""

    origin: Vector = (0.0, 0.0, 0.0)
    axis: Vector = (0.0, 0.0, 1.0)
    ref: Vector = (1.0, 0.0, 0.0)

    @classmethod
    def about(cls, origin: npt.ArrayLike, axis: npt.ArrayLike) -> Frame:
        """A frame with the given axis and a ref chosen the same way every time."""
        z = np.array(unit(axis))
        helper = np.eye(3)[int(np.argmin(np.abs(z)))]
        x = cross(cross(z, helper), z)
        if abs(z[2]) > 1.0 - 1e-15:
            x = np.array([1.0, 0.0, 0.0])
        return cls(vector(origin), vector(z), unit(x))

    @cached_property
    def rows(self) -> Floats:
        """Rotation matrix (3, 3) whose rows are X, Y, Z."""
        x, z = np.array(self.ref), np.array(self.axis)
        return np.stack([x, cross(z, x), z])

    def local(self, points: Floats) -> Floats:
        """Points (..., 3) in this frame's coordinates."""
        return np.asarray((points - np.array(self.origin)) @ self.rows.T)

    def world(self, points: Floats) -> Floats:
        """Points (..., 3) given in this frame, in the outer coordinates."""
        return np.asarray(points @ self.rows + np.array(self.origin))


WORLD = Frame()
"""The cam frame itself."""


@final
@immutable(eq=True)
class Line:
    """A straight line through origin (mm) along the unit direction; the parameter is the distance."""

    origin: Vector
    direction: Vector

    def at(self, t: Floats) -> Floats:
        """Points (n, 3), mm."""
        return np.asarray(np.array(self.origin) + t[:, None] * np.array(self.direction))

    def tangent(self, t: Floats) -> Floats:
        """Derivative by the parameter, (n, 3)."""
        return np.asarray(np.repeat([self.direction], len(t), axis=0), dtype=float)

    def locate(self, points: Floats) -> Floats:
        """Parameters (n,) of the nearest points."""
        return np.asarray((points - np.array(self.origin)) @ np.array(self.direction))


@final
@immutable(eq=True)
class Circle:
    """A circle of radius mm in the XY plane of its frame; the parameter is the angle from ref, counter-clockwise."""

    frame: Frame
    radius: float

    def at(self, t: Floats) -> Floats:
        """Points (n, 3), mm."""
        return self.frame.world(self.radius * np.stack([np.cos(t), np.sin(t), np.zeros_like(t)], axis=1))

    def tangent(self, t: Floats) -> Floats:
        """Derivative by the parameter, (n, 3)."""
        turned = self.radius * np.stack([-np.sin(t), np.cos(t), np.zeros_like(t)], axis=1)
        return np.asarray(turned @ self.frame.rows)

    def locate(self, points: Floats) -> Floats:
        """Angles (n,) in (-pi, pi] of the nearest points."""
        q = self.frame.local(points)
        return np.arctan2(q[:, 1], q[:, 0])


@final
@immutable
class SplineCurve:
    """A clamped B-spline curve: basis and poles (n, 3) mm; an edge on it uses all of it."""

    basis: Basis
    poles: Floats

    def at(self, t: Floats) -> Floats:
        """Points (n, 3), mm."""
        return self._derivative(t, 0)

    def tangent(self, t: Floats) -> Floats:
        """Derivative by the parameter, (n, 3)."""
        return self._derivative(t, 1)

    def _derivative(self, t: Floats, order: int) -> Floats:
        first, values = self.basis.local(t, order)
        alive = self.poles[first[:, None] + np.arange(self.basis.degree + 1)]
        return np.asarray(np.einsum("nk,nkc->nc", values, alive))

    def locate(self, points: Floats) -> Floats:
        """Parameters (n,) of the nearest points (Gauss-Newton from the nearest of four samples a span)."""
        basis = self.basis
        grid = np.linspace(basis.start, basis.stop, 4 * len(basis.breaks))
        t = grid[_nearest(points, self.at(grid))]
        for _ in range(20):
            d, x, before = self.tangent(t), self.at(t) - points, t
            step = _rows_dot(d, x) / np.maximum(_rows_dot(d, d), 1e-300)
            t = np.clip(t - step, basis.start, basis.stop)
            if np.abs(t - before).max() < SETTLED * (basis.stop - basis.start):
                break
        return np.asarray(t)


@final
@immutable(eq=True)
class Plane:
    """The XY plane of its frame; u along ref, v across, mm. The normal is the frame's axis."""

    frame: Frame

    def jet(self, u: Floats, v: Floats) -> tuple[Floats, Floats, Floats]:
        """Points and derivatives by u and v, each (n, 3)."""
        x = self.frame.world(np.stack([u, v, np.zeros_like(u)], axis=1))
        return x, np.repeat(self.frame.rows[:1], len(u), axis=0), np.repeat(self.frame.rows[1:2], len(u), axis=0)

    def locate(self, points: Floats) -> tuple[Floats, Floats]:
        """Parameters (u, v) of the nearest points."""
        q = self.frame.local(points)
        return q[:, 0], q[:, 1]


@final
@immutable(eq=True)
class Cone:
    """A cone about its frame's axis, radius + v tan(half_angle) at height v; half_angle 0 is a cylinder.

    u is the angle from ref; the normal u x v points away from the axis.
    """

    frame: Frame
    radius: float
    half_angle: float = 0.0

    def jet(self, u: Floats, v: Floats) -> tuple[Floats, Floats, Floats]:
        """Points and derivatives by u and v, each (n, 3)."""
        slope, c, s, zero = sin(self.half_angle) / cos(self.half_angle), np.cos(u), np.sin(u), np.zeros_like(u)
        r = self.radius + slope * v
        x = self.frame.world(np.stack([r * c, r * s, v], axis=1))
        xu = np.stack([-r * s, r * c, zero], axis=1) @ self.frame.rows
        xv = np.stack([slope * c, slope * s, zero + 1.0], axis=1) @ self.frame.rows
        return x, xu, xv

    def locate(self, points: Floats) -> tuple[Floats, Floats]:
        """Parameters (u, v) of the nearest points."""
        q = self.frame.local(points)
        rho = np.hypot(q[:, 0], q[:, 1]) - self.radius
        c, s = cos(self.half_angle), sin(self.half_angle)
        return np.arctan2(q[:, 1], q[:, 0]), np.asarray((rho * s + q[:, 2] * c) * c)


@final
@immutable(eq=True)
class Torus:
    """A torus about its frame's axis; u round the axis, v round the tube, mm. The normal points out of the tube."""

    frame: Frame
    major: float
    minor: float

    def jet(self, u: Floats, v: Floats) -> tuple[Floats, Floats, Floats]:
        """Points and derivatives by u and v, each (n, 3)."""
        cu, su, cv, sv = np.cos(u), np.sin(u), np.cos(v), np.sin(v)
        r = self.major + self.minor * cv
        x = self.frame.world(np.stack([r * cu, r * su, self.minor * sv], axis=1))
        xu = np.stack([-r * su, r * cu, np.zeros_like(u)], axis=1) @ self.frame.rows
        xv = self.minor * np.stack([-sv * cu, -sv * su, cv], axis=1) @ self.frame.rows
        return x, xu, xv

    def locate(self, points: Floats) -> tuple[Floats, Floats]:
        """Parameters (u, v) of the nearest points."""
        q = self.frame.local(points)
        rho = np.hypot(q[:, 0], q[:, 1])
        return np.arctan2(q[:, 1], q[:, 0]), np.arctan2(q[:, 2], rho - self.major)


@final
@immutable
class SplineSurface:
    """A clamped tensor-product B-spline surface: bases and poles (nu, nv, 3) mm."""

    u: Basis
    v: Basis
    poles: Floats

    def jet(self, u: Floats, v: Floats) -> tuple[Floats, Floats, Floats]:
        """Points and derivatives by u and v, each (n, 3), at pairs u (n,), v (n,)."""
        n = len(u)
        (iu, bu), (iv, bv) = self.u.slopes(u), self.v.slopes(v)
        rows = (iu[:, None] + np.arange(self.u.degree + 1))[:, :, None]
        columns = (iv[:, None] + np.arange(self.v.degree + 1))[:, None, :]
        alive = self.poles[rows, columns].reshape(n, self.u.degree + 1, -1)
        along = (bu @ alive).reshape(n, 2, self.v.degree + 1, 3)
        x = bv @ along[:, 0]
        return x[:, 0], (bv[:, :1] @ along[:, 1])[:, 0], x[:, 1]

    def border(self, curve: SplineCurve) -> tuple[int, float, int] | None:
        """Which of this surface's borders a curve runs along: the parameter (0 u, 1 v) that is constant, its value, and
        the sign with which the other one is the curve's own parameter. None where it is no piece of a border, run at
        that pace, within MEET.
        """
        basis = curve.basis
        for axis, along, across in ((1, self.u, self.v), (0, self.v, self.u)):
            if along.degree != basis.degree:
                continue
            if along is basis or np.array_equal(along.knots, basis.knots):
                for end, value in ((0, across.start), (-1, across.stop)):
                    if np.abs(self.poles.take(end, axis) - curve.poles).max() <= MEET:
                        return axis, value, 1
                continue
            sign = 1 if basis.start >= along.start else -1
            breaks = np.sort(sign * along.breaks)
            inner = breaks[(breaks > basis.start) & (breaks < basis.stop)]
            if basis.start < breaks[0] or basis.stop > breaks[-1] or not np.array_equal(inner, basis.breaks[1:-1]):
                continue
            for value in (across.start, across.stop):
                # Splines of one degree and the same knots agree where they do so at as many points as they have poles.
                if self._apart(curve, basis.greville, axis, value, sign) <= MEET:
                    return axis, value, sign
        return None

    def _apart(self, curve: SplineCurve, t: Floats, axis: int, value: float, sign: int) -> float:
        """Largest distance in mm of a curve at t (n,) from the points where one parameter has the value and the other
        one is sign * t."""
        at = [sign * t] * 2
        at[axis] = np.full(len(t), value)
        return largest_gap(self.jet(*at)[0], curve.at(t))

    def locate(self, points: Floats) -> tuple[Floats, Floats]:
        """Parameters (u, v) of the nearest points (damped Gauss-Newton from the nearest sample)."""
        gu = np.linspace(self.u.start, self.u.stop, 2 * len(self.u.breaks) + 1)
        gv = np.linspace(self.v.start, self.v.stop, 2 * len(self.v.breaks) + 5)
        nodes = np.stack([a.ravel() for a in np.meshgrid(gu, gv, indexing="ij")])
        u, v = nodes[:, _nearest(points, self.jet(*nodes)[0])]
        scale = self.u.stop - self.u.start, self.v.stop - self.v.start
        for _ in range(25):
            x, xu, xv = self.jet(u, v)
            du, dv = solve_pairs(xu, xv, points - x)
            before = u, v
            u = np.clip(u + du, self.u.start, self.u.stop)
            v = np.clip(v + dv, self.v.start, self.v.stop)
            # Where one parameter is held at its end, the other takes the best step left to it.
            held = u != before[0] + du, v != before[1] + dv
            u, v = (
                np.where(held[1], _clipped(self.u, before[0], points - x - (v - before[1])[:, None] * xv, xu), u),
                np.where(held[0], _clipped(self.v, before[1], points - x - (u - before[0])[:, None] * xu, xv), v),
            )
            moved = float(np.abs(u - before[0]).max()) / scale[0], float(np.abs(v - before[1]).max()) / scale[1]
            if max(moved) < SETTLED:
                break
        return u, v


def _clipped(basis: Basis, before: Floats, d: Floats, tangent: Floats) -> Floats:
    """Parameters (n,) after the best step along one tangent (n, 3) towards d (n, 3), kept inside the basis."""
    step = _rows_dot(d, tangent) / np.maximum(_rows_dot(tangent, tangent), 1e-300)
    return np.clip(before + step, basis.start, basis.stop)


Curve = Line | Circle | SplineCurve
Surface = Plane | Cone | Torus | SplineSurface


def solve_pairs(xu: Floats, xv: Floats, d: Floats) -> tuple[Floats, Floats]:
    """Least-squares a, b (n,) of a xu + b xv = d, damped where the two directions nearly agree or one vanishes."""
    lu, lv = (np.sqrt(_rows_dot(x, x)) + 1e-150 for x in (xu, xv))
    f = _rows_dot(xu, xv) / (lu * lv)
    p, q = _rows_dot(xu, d) / lu, _rows_dot(xv, d) / lv
    det = np.maximum(1.0 - f * f, 1e-14)
    return np.asarray((p - q * f) / (det * lu)), np.asarray((q - p * f) / (det * lv))


def largest_gap(a: Floats, b: Floats) -> float:
    """Largest distance between points (..., 3) of the one and of the other, mm."""
    return float(np.sqrt(((a - b) ** 2).sum(axis=-1)).max())


def _rows_dot(a: Floats, b: Floats) -> Floats:
    return np.asarray(np.einsum("nc,nc->n", a, b))


def _nearest(points: Floats, samples: Floats) -> npt.NDArray[np.intp]:
    """Index (n,) of the sample nearest to each point."""
    square = (samples * samples).sum(axis=1)[None, :] - 2.0 * points @ samples.T
    return np.asarray(np.argmin(square, axis=1))
