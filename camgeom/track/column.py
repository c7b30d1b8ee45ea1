"""The line in which a roller touches what it cuts, at every cam angle: flank, arc of its end circle, chord of a floor;
and where a flank ends, at a level surface of the body.

A roller with a flat end has an edge; its end circle sweeps a third surface between flank and floor. At each cam angle
the end circle touches that surface along the arc from the flank's foot (where the side of the roller touches) to the
end of the floor's chord (where the flat end touches): in between both the side and the end of the roller are moving
into the material. The floor is the envelope of the flat end itself: the chord of the end disc along which the velocity
has no component along the roller axis. A ball has no flat end: both flanks meet at the bottom.
Where the end has a corner radius the torus of its corner sweeps the root instead: it touches along a curve from the
flank's foot, a corner radius above the floor, to the end of the floor's chord, in the closed form of any meridian.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field
from functools import wraps
from math import pi, sqrt
from typing import Concatenate, ParamSpec

import numpy as np
import numpy.typing as npt

from camgeom.errors import DesignError, NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.maths.surface import cross, dot
from camgeom.track import Arc, Pose, Slide, Straight, Track
from camgeom.track.flank import Flank

Level = Callable[[Floats], Floats]
"""Scalar field on points (3, ...): zero on the blank's surface, positive outside."""


@immutable(eq=True)
class CylinderLevel:
    """Field of a cylinder about Z: (x² + y² - R²) / 2R, about the radial distance in mm."""

    radius: float

    def __call__(self, x: Floats) -> Floats:
        return np.asarray((x[0] * x[0] + x[1] * x[1] - self.radius**2) / (2.0 * self.radius))


def cylinder_level(radius: float) -> CylinderLevel:
    """Level field of a cylinder of the given radius about Z."""
    return CylinderLevel(radius)


@immutable(eq=True)
class ConeLevel:
    """Field of a cone about Z: the signed distance, mm.

    radius  at z = 0, mm; slope: by which it falls per mm of height, the tangent of the half angle
    """

    radius: float
    slope: float

    def __call__(self, x: Floats) -> Floats:
        away = np.sqrt(x[0] * x[0] + x[1] * x[1]) - self.radius + self.slope * x[2]
        return np.asarray(away / sqrt(1.0 + self.slope**2))

    def at(self, z: float) -> float:
        """Its radius at a height, mm."""
        return self.radius - self.slope * z


def outside_level(radius: float, slope: float) -> CylinderLevel | ConeLevel:
    """Level field of a drum's outside, `radius` at z = 0: of a cone where it has a slope."""
    return ConeLevel(radius, slope) if slope else CylinderLevel(radius)


P = ParamSpec("P")


def _along(make: Callable[Concatenate[Column, P], Floats]) -> Callable[Concatenate[Column, P], Floats]:
    """Figures (..., n) of a column's cam angles, made once for each set of arguments and for all parts of a whole."""

    def known(self: Column, /, *args: P.args, **kwargs: P.kwargs) -> Floats:
        if self.whole is not None:
            column, part = self.whole
            return np.asarray(known(column, *args, **kwargs)[..., part])
        key = (make.__name__, *args)
        if key not in self.figures:
            figures = make(self, *args, **kwargs)
            figures.setflags(write=False)
            self.figures[key] = figures
        return self.figures[key]

    return wraps(make)(known)


@immutable
class Column:
    """Everything about a groove that is asked at one set of cam angles (n,), computed once.

    whole  a column of more cam angles that this one is a part of, and which part
    """

    track: Track
    phi: Floats
    given_pose: Pose | None = None
    whole: tuple[Column, slice] | None = None
    figures: dict[tuple[object, ...], Floats] = field(default_factory=dict)

    @property
    def pose(self) -> Pose:
        """Pose jets (order 1, or the given ones where the caller already has them)."""
        return self.given_pose or self._pose

    @cached_property
    def _pose(self) -> Pose:
        if self.whole is not None:
            column, part = self.whole
            return column.pose.between(part.start, part.stop)
        return self.track.pose(self.phi, 1)

    def at(self, rows: npt.NDArray[np.intp]) -> Column:
        """The same at some of its cam angles."""
        return Column(self.track, self.phi[rows], self.pose.at(rows))

    def between(self, start: int, stop: int) -> Column:
        """The same from one of its cam angles to before another one."""
        part = slice(start, stop)
        return Column(self.track, self.phi[part], None, (self, part))

    @cached_property
    def _eased(self) -> dict[float, Column]:
        if self.whole is not None:
            column, part = self.whole
            return {side: eased.between(part.start, part.stop) for side, eased in column._eased.items()}
        return {side: Column(self.track.eased(side), self.phi) for side in (1.0, -1.0)}

    @property
    def _relieved(self) -> bool:
        """True where the two flanks are cut from poses of their own."""
        return self.track.relief is not None and not self.track.ease

    def wall(self, side: float, t: Floats) -> Floats:
        """Flank points (3, n, m) at stations t (m,) or (n, m)."""
        if self._relieved:
            return self._eased[side].wall(side, t)
        meridian = self.track.meridian
        if isinstance(meridian, Straight) and meridian.slope == 0.0:
            return self._cylinder_wall(side * meridian.radius, t if t.ndim == 2 else t[None, :])
        if isinstance(meridian, Straight):
            return self._cone_wall(side, t if t.ndim == 2 else t[None, :])
        return Flank(self.track, self.phi, t, side, given_pose=self.pose).x

    def _cylinder_wall(self, radius: float, t: Floats) -> Floats:
        """Flank points (3, n, m) of a cylinder: the axis point and `radius` along u x v, which is linear in delta."""
        level, turning = self._crossed().reshape(2, 3, -1, 1)
        x: Floats = t * turning
        x += level
        length = np.sqrt(np.einsum("kij,kij->ij", x, x))
        if not float(length.min()) > 1e-9:
            # Near zero the flank itself judges, and refuses by name.
            return Flank(self.track, self.phi, t, float(np.sign(radius)), given_pose=self.pose).x
        x *= radius / length
        x += t * self.pose.u[0][:, :, None]
        x += self.pose.a[0][:, :, None]
        return x

    def _cone_wall(self, side: float, t: Floats) -> Floats:
        """Flank points (3, n, m) of a cone: the terms of `Flank` which hang on the cam angle alone are made once."""
        a, u = self.pose.a, self.pose.u
        delta, dt, _, r, rt, _ = self.track.meridian.jet(t)
        crossed, level, g = self._crossed(), self._level(), dt * delta + r * rt
        w = [dt * level[k][:, None] + g * u[1][k][:, None] for k in range(3)]
        across = [dt * crossed[k][:, None] + g * crossed[k + 3][:, None] for k in range(3)]
        c = rt * level[3][:, None]
        square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
        left = square - c * c
        if not bool((left > 1e-12 * square).all()):
            # Near zero the flank itself judges, and refuses by name.
            return Flank(self.track, self.phi, t, side, given_pose=self.pose).x
        root, share = side * np.sqrt(left), r / square
        x = np.empty((3, *square.shape))
        for k in range(3):
            np.multiply(root, across[k], out=x[k])
            x[k] += c * w[k]
            x[k] *= share
            x[k] += delta * u[0][k][:, None]
            x[k] += a[0][k][:, None]
        return x

    @_along
    def _level(self) -> Floats:
        """a' without its part along the roller, and that part, (4, n)."""
        u, speed = self.pose.u[0], self.pose.a[1]
        along = dot(u, speed)
        return np.concatenate([speed - along * u, along[None]])

    @_along
    def _crossed(self) -> Floats:
        """u x a' and u x u', (6, n): u x v is the first plus delta times the second."""
        a, u = self.pose.a, self.pose.u
        return np.concatenate([cross(u[0], a[1]), cross(u[0], u[1])])

    @cached_property
    def tip_t(self) -> float:
        """Meridian parameter of the roller's free end, or of where its corner begins."""
        return self.track.meridian.parameter(self.track.foot)

    @property
    def ball_ended(self) -> bool:
        """True where the roller's end is the pole of a ball, so that there is no flat end."""
        # Where the tip is a rounding away from the pole its parameter, an arc sine, is 1e-8 away.
        return isinstance(self.track.meridian, Arc) and abs(abs(self.tip_t) - 0.5 * pi) < 1e-6

    def bottom_t(self) -> Floats:
        """Meridian parameter (n, 1) where the flanks end at the bottom.

        The flat end's edge; for a ball the point where the contact circle, which lies across the velocity of the
        ball's centre, comes nearest to the pole: asin(|v.u| / |v|) from it.
        """
        n = len(self.phi)
        if not self.ball_ended:
            return np.full((n, 1), self.tip_t)
        v = self._ball_velocity()
        sine = np.clip(dot(v, self.pose.u[0]) / np.sqrt(dot(v, v)), -1.0, 1.0)
        return np.asarray(np.sign(self.tip_t) * (0.5 * pi - np.abs(np.arcsin(sine)))[:, None])

    def ball_bottom(self) -> Floats:
        """The point (3, n) where both flanks of a ball's groove meet: on the contact circle, nearest to the pole."""
        u, v = self.pose.u[0], self._ball_velocity()
        meridian = self.track.meridian
        down = np.sign(self.tip_t) * (u - (dot(u, v) / dot(v, v)) * v)
        down /= np.sqrt(dot(down, down))
        return np.asarray(self.pose.a[0] + meridian.centre * u + meridian.radius * down)

    def _ball_velocity(self) -> Floats:
        return np.asarray(self.pose.a[1] + self.track.meridian.centre * self.pose.u[1])

    def reach(self, side: float, level: Level, guess: float) -> Floats:
        """Meridian parameter (n, 1) where the flank crosses level(x) = 0, by a vectorised secant from delta = guess.

        Raises NotConverged where the flank does not meet the surface.
        """
        return self._reach(side, level, guess)[:, None]

    @_along
    def _reach(self, side: float, level: Level, guess: float) -> Floats:
        n = len(self.phi)
        meridian = self.track.meridian
        if isinstance(level, CylinderLevel) and self._radial_cylinder:
            return self._closed_reach(level.radius)
        t0 = np.full((n, 1), meridian.parameter(guess))
        step = 1e-4 * abs(self.track.contact[1] - self.track.contact[0])
        t1 = np.full((n, 1), meridian.parameter(guess - step * np.sign(guess - self.track.tip)))
        f0, f1 = level(self.wall(side, t0)), level(self.wall(side, t1))
        scale = float(np.abs(self.track.contact).max()) + abs(guess)
        for _ in range(30):
            if np.abs(f1).max() < 1e-14 * scale:
                return t1[:, 0]
            slope = np.where(f1 != f0, f1 - f0, 1.0)
            move = np.where(f1 != f0, f1 * (t1 - t0) / slope, 0.0)
            try:
                after = level(self.wall(side, t1 - move))
            except DesignError:
                # Sought beyond the stretch on which the roller touches anything: the flank ends before the surface.
                break
            # Where rounding alone is left a secant through it may lead anywhere.
            settled = (np.abs(f1) < 1e-11 * scale) & (np.abs(after) >= np.abs(f1))
            if settled.all():
                break
            pairs = (t0, t1), (f0, f1), (t1, t1 - move), (f1, after)
            t0, f0, t1, f1 = (np.where(settled, kept, new) for kept, new in pairs)
        if float(np.abs(f1).max()) < 1e-11 * scale:
            return t1[:, 0]
        worst = int(np.argmax(np.abs(f1)))
        self._refuse_beside(level, worst)
        raise NotConverged(
            f"the flank of track {self.track.name!r} does not meet the blank's surface at cam angle "
            f"{np.degrees(self.phi[worst]):.6g} deg; check roller, groove depth and blank"
        )

    def _refuse_beside(self, level: Level, worst: int) -> None:
        """Raise DesignError where a roller that swings past a drum stands so far beside its axis that it leaves it."""
        if not isinstance(level, CylinderLevel) or not self.track.closed:
            # What is not closed is a turret's, whose rollers come and go beside the drum.
            return
        a, u = self.pose.a[0][:, worst], self.pose.u[0][:, worst]
        across = np.array([-u[1], u[0]]) / max(float(np.hypot(u[0], u[1])), 1e-300)
        beside = abs(float(across @ a[:2]))
        meridian = self.track.meridian
        widest = float(meridian.jet(np.array([meridian.parameter(d) for d in self.track.contact]))[3].max())
        if beside + widest > level.radius:
            raise DesignError(
                f"at cam angle {np.degrees(self.phi[worst]):.6g} deg the arc of track {self.track.name!r} stands "
                f"{beside:.4g} mm beside the cam's axis, and with its {widest:.4g} mm of radius leaves the cam "
                f"({level.radius:g} mm) sideways: a longer arm, less swing, a pivot_distance that centres the arc on "
                "the axis, or a larger cam"
            )

    @property
    def _radial_cylinder(self) -> bool:
        """True for a cylindrical roller whose axis stays radial while it slides along Z."""
        track = self.track
        plain = isinstance(track.meridian, Straight) and track.meridian.slope == 0.0
        slides = isinstance(track.joint, Slide) and track.joint.direction == (0.0, 0.0, 1.0)
        return plain and slides and track.anchor[:2] == (0.0, 0.0) and track.axis == (1.0, 0.0, 0.0)

    def _closed_reach(self, radius: float) -> Floats:
        """delta (n,) where the wall of a radial cylinder meets a cylinder of `radius`, in closed form.

        The contact point lies at the tangential distance r |s'| / sqrt(delta² + s'²) from the axis plane, so that
        delta² = x solves x² + (s'² - R²) x + s'² (r² - R²) = 0. Raises DesignError where it has no positive root.
        """
        assert isinstance(self.track.meridian, Straight)
        slope2, square, roller = self.pose.a[1][2] ** 2, radius * radius, self.track.meridian.radius
        b = square - slope2
        inside = b * b + 4.0 * slope2 * (square - roller**2)
        x = 0.5 * (b + np.sqrt(np.maximum(inside, 0.0)))
        if float(min(inside.min(), x.min())) <= 0.0:
            worst = int(np.argmin(np.minimum(inside / square, x)))
            raise DesignError(
                f"at cam angle {np.degrees(self.phi[worst]):.6g} deg the roller of track {self.track.name!r}, "
                f"{roller:.6g} mm in radius, touches its flank beside the cylinder of {radius:.6g} mm in radius, where "
                "the flank should end: a smaller roller, less groove_depth, a larger diameter or a gentler motion"
            )
        return np.asarray(np.sqrt(x))

    @cached_property
    def _end_disc(self) -> tuple[Floats, float, Floats, Floats]:
        """Centre (3, n) and radius of the flat end, chord offset vector (3, n) and half chord vector (3, n)."""
        _, _, _, r, _, _ = self.track.meridian.jet(np.array([self.tip_t]))
        radius = float(r[0]) - self.track.root
        a, u = self.pose.a, self.pose.u
        centre, v = a[0] + self.track.tip * u[0], a[1] + self.track.tip * u[1]
        turn = dot(u[1], u[1])
        if np.any(turn <= 1e-18):
            name = self.track.name
            raise DesignError(f"track {name!r}: the roller axis keeps its direction, so its end cuts a plane")
        offset = (dot(v, u[0]) / turn) * u[1]
        left = radius**2 - dot(offset, offset)
        if np.any(left <= 0.0):
            worst = int(np.argmin(left))
            raise DesignError(
                f"track {self.track.name!r}: at cam angle {np.degrees(self.phi[worst]):.6g} deg the whole end of the "
                "roller dives into the cam; reduce the motion along the roller axis"
            )
        return centre, radius, offset, np.sqrt(left / turn) * cross(u[0], u[1])

    @cached_property
    def _corner(self) -> Track:
        return self.track.corner

    @_along
    def chord_end(self, side: float) -> Floats:
        """End of the floor's chord on one side, (3, n)."""
        centre, _, offset, half = self._end_disc
        return np.asarray(centre + offset + side * self._handed * half)

    @cached_property
    def _handed(self) -> Floats:
        """+1 where u x u' points to the side +1 flank."""
        u = self.pose.u
        v = self.pose.a[1] + self.track.tip * u[1]
        return np.where(dot(v, u[1]) >= 0.0, 1.0, -1.0)

    @_along
    def edge_arc(self, side: float) -> Floats:
        """Arc of the end circle from the flank's foot to the chord's end, (10, n): its signed angle, rad, the circle's
        centre, the way from there to the foot and that way turned by a right angle, mm."""
        centre = self._end_disc[0]
        foot = self.wall(side, np.array([self.tip_t]))[:, :, 0]
        start, stop = foot - centre, self.chord_end(side) - centre
        third = cross(self.pose.u[0], start)
        angle = np.arctan2(dot(stop, third), dot(stop, start))
        return np.concatenate([angle[None], centre, start, third])

    def corner(self, side: float, share: Floats) -> Floats:
        """Points (3, n, k) swept by the torus of the tool's corner, at shares (k,) or (n, k) of its quarter circle."""
        angle = self.track.tip_sign * 0.5 * pi * share
        return Flank(self._corner, self.phi, angle, side, given_pose=self.pose).x

    def edge(self, side: float, share: Floats) -> Floats:
        """Points of the end-circle sweep, (3, n, k), at shares (k,) or (n, k) of the arc: 0 the foot, 1 the floor.

        Of a rounded end those of the root, at shares of the corner's quarter circle.
        """
        if self.track.root:
            return np.where(share == 1.0, self.chord_end(side)[:, :, None], self.corner(side, share))
        arc = self.edge_arc(side)[:, :, None]
        turn = arc[0] * share
        x: Floats = np.cos(turn) * arc[4:7]
        x += np.sin(turn) * arc[7:]
        x += arc[1:4]
        end = share == 1.0
        if end.any():
            np.copyto(x, self.chord_end(side)[:, :, None], where=end)
        return x
