"""The envelope of a roller: contact points, exact normals, curvatures, undercut margin, pressure angle, sliding.

A roller surface point is x = a + delta(t) u + r(t) m with m a unit vector across the axis; its outward normal is
n = (delta' m - r' u) / g, g² = delta'² + r'² (dashes: by the meridian parameter t). The cam touches it where n is
perpendicular to the velocity of the roller relative to the cam. The spin of the roller about its own axis drops out and

    m . w = c,     w = (delta' v + r r' u_phi) across u,     c = r' (v . u),     v = a_phi + delta u_phi,

whose two solutions m = (c w ± sqrt(|w|² - c²) u x w) / |w|² are the two flanks (theory: geometry of envelopes; for a
cylinder r' = 0 they are the parallel surfaces of the pitch surface at distance r). Derivatives follow by implicit
differentiation of that one equation, so every curvature below is exact.

Arrays inside are component-major, (3, n, m): n cam angles, m stations along the roller.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
import numpy.typing as npt

from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.maths.surface import Forms, cross, dot
from camgeom.motion.table import Side
from camgeom.track import Pose, Track

At = Literal["surface", "axis"]

TWICE_FOLDED = 1e-6
"""1 - r k / 2 below which, in size, a pitch surface counts as shrunk to a curve and not as folded twice"""


@immutable
class Flank:
    """One flank of a track evaluated at cam angles phi (n,) and meridian stations t (m,) or (n, m).

    side  +1: the flank on the side of u x v; -1: the other one.
    Where the contact equation has no solution (|w| < |c|: the roller end dives into the cam) DesignError is raised.
    """

    track: Track
    phi: Floats
    t: Floats
    side: float
    jet_side: Side = "right"
    given_pose: Pose | None = None

    @cached_property
    def pose(self) -> Pose:
        """Pose jets of the roller, order 2 (the given ones where the caller already has them)."""
        return self.given_pose or self.track.eased(self.side).pose(self.phi, 2, self.jet_side)

    @cached_property
    def _stations(self) -> tuple[Floats, ...]:
        """delta, delta', delta'', r, r', r'' broadcastable to (n, m)."""
        t = self.t if self.t.ndim == 2 else self.t[None, :]
        return self.track.meridian.jet(t)

    @cached_property
    def _vectors(self) -> tuple[Floats, Floats, Floats]:
        """u (3, n, 1), u_phi (3, n, 1) and v (3, n, m)."""
        u, up = self.pose.u[0][:, :, None], self.pose.u[1][:, :, None]
        v = self.pose.a[1][:, :, None] + self._stations[0][None] * up
        return u, up, v

    @cached_property
    def _contact(self) -> tuple[Floats, Floats, Floats]:
        """m (3, n, m), u x m (3, n, m), and f_chi = (u x m) . w (n, m)."""
        u, up, v = self._vectors
        _, dt, _, r, rt, _ = self._stations
        along = dot(v, u)
        if not np.any(rt):
            w = dt * (v - along * u)
            across = cross(u, w)
            length = np.sqrt(dot(w, w))
            self._refuse(length <= 1e-12 * np.sqrt(np.maximum(dot(v, v), 1e-300)))
            m = (self.side / length) * across
            return m, cross(u, m), -self.side * length
        w = dt * (v - along * u) + (r * rt) * up
        c = rt * along
        square = dot(w, w)
        left = square - c * c
        self._refuse(left <= 1e-24 * np.maximum(dot(v, v), 1e-300))
        root = self.side * np.sqrt(left)
        m = (c * w + root * cross(u, w)) / square
        return m, cross(u, m), -root

    def _refuse(self, bad: npt.NDArray[np.bool_]) -> None:
        if np.any(bad):
            n, _ = np.unravel_index(int(np.argmax(bad)), bad.shape)
            raise DesignError(
                f"track {self.track.name!r}: at cam angle {np.degrees(self.phi[n]):.6g} deg the roller moves along its "
                "own axis (or its end dives into the cam), so there is no contact line; change the motion or the pose",
            )

    @cached_property
    def rolled(self) -> Floats:
        """Path, mm/rad, (n, m), that the roller's rim turns by about its own pin as it rolls along the flank, >= 0.

        No slip across the axis: r (spin + w . u) = -v . q, with w the turning of the carrier relative to the cam and v
        the velocity of the axis. About a cam whose axis is parallel to the roller's that is a turn of the roller more
        or less than its middle's path gives, by the side on which the flank lies.
        """
        return self.pose.per_radian(np.abs(self._stations[3] * self.turning))

    @cached_property
    def turning(self) -> Floats:
        """The roller's turning about its own pin, against u, that rolls at each station, rad/rad, (n, m)."""
        u, _, v = self._vectors
        q, r = self._contact[1], self._stations[3]
        w = self.track.spin(self.phi, self.pose.turn)[:, :, None]
        return np.asarray(dot(v, q) / r + dot(w, u))

    @cached_property
    def x(self) -> Floats:
        """Contact points in the cam frame, mm, component-major (3, n, m)."""
        u, _, _ = self._vectors
        delta, _, _, r, _, _ = self._stations
        return np.asarray(self.pose.a[0][:, :, None] + delta[None] * u + r[None] * self._contact[0])

    @cached_property
    def n(self) -> Floats:
        """Unit normals, from the roller into the cam material, component-major (3, n, m)."""
        _, dt, _, _, rt, _ = self._stations
        if not np.any(rt):
            return self._contact[0]
        u, _, _ = self._vectors
        g = np.sqrt(dt * dt + rt * rt)
        return np.asarray((dt * self._contact[0] - rt * u) / g)

    @cached_property
    def points(self) -> Floats:
        """Contact points in the cam frame, mm, (n, m, 3)."""
        return np.ascontiguousarray(np.moveaxis(self.x, 0, -1))

    @cached_property
    def normals(self) -> Floats:
        """Unit normals from the roller into the cam material, (n, m, 3)."""
        return np.ascontiguousarray(np.moveaxis(self.n, 0, -1))

    @cached_property
    def _tangents(self) -> tuple[Floats, Floats, Floats, Floats]:
        """x_phi, x_t, n_phi, n_t along the flank, each (3, n, m); n_* up to a multiple of n."""
        u, up, v = self._vectors
        delta, dt, dtt, r, rt, rtt = self._stations
        m, q, f_chi = self._contact
        upp = self.pose.u[2][:, :, None]
        v_phi = self.pose.a[2][:, :, None] + delta[None] * upp
        along, m_up = dot(v, u), dot(m, up)
        if not (np.any(rt) or np.any(dtt) or np.any(rtt)):
            # A cylinder: what its radius and the meridian's bends would add is nothing.
            chi_phi, chi_t = (m_up * along - dot(m, v_phi)) * (dt / f_chi), -(dt * dt) * m_up / f_chi
            m_phi, m_t = chi_phi * q - m_up * u, chi_t * q
            return v + r * m_phi, dt * u + r * m_t, m_phi, m_t
        w_phi = dt * v_phi + (r * rt) * upp
        f_phi = -m_up * (dt * along) + dot(m, w_phi) - rt * (dot(up, v) + dot(u, v_phi))
        f_t = dtt * dot(m, v) + (dt * dt + rt * rt + r * rtt) * m_up - rtt * along
        chi_phi, chi_t = -f_phi / f_chi, -f_t / f_chi
        m_phi = -m_up * u + chi_phi * q
        m_t = chi_t * q
        x_phi, x_t = v + r * m_phi, dt * u + rt * m + r * m_t
        g = np.sqrt(dt * dt + rt * rt)
        n_phi = (dt * m_phi - rt * up) / g
        n_t = (dtt * m + dt * m_t - rtt * u) / g
        return x_phi, x_t, n_phi, n_t

    @cached_property
    def tangents(self) -> tuple[Floats, Floats]:
        """Derivatives of the contact points by the cam angle and by the meridian parameter, each (3, n, m)."""
        return self._tangents[:2]

    @cached_property
    def passing(self) -> Floats:
        """Speed of the contact line over the cam's flank, square to itself, mm/rad, (n, m)."""
        across, along = self.tangents
        line = along / np.sqrt(dot(along, along))
        return self.pose.per_radian(np.sqrt(np.maximum(dot(across, across) - dot(across, line) ** 2, 0.0)))

    @cached_property
    def forms(self) -> Forms:
        """First and second form in (phi, t) for the normal n that points into the material."""
        x_phi, x_t, n_phi, n_t = self._tangents
        return Forms(
            dot(x_phi, x_phi), dot(x_phi, x_t), dot(x_t, x_t), -dot(n_phi, x_phi), -dot(n_phi, x_t), -dot(n_t, x_t)
        )

    @cached_property
    def roller_curvatures(self) -> tuple[Floats, Floats]:
        """Curvatures of the roller round it and along its meridian with respect to n, 1/mm (negative: convex)."""
        _, dt, dtt, r, rt, rtt = self._stations
        g = np.sqrt(dt * dt + rt * rt)
        return -dt / (g * r), (rtt * dt - dtt * rt) / g**3

    @cached_property
    def _middle_curvatures(self) -> tuple[Floats, Floats, Floats]:
        """Principal curvatures (larger, smaller) of the surface half way from flank to roller axis, and its distance.

        Neither a cusp of the flank nor the pitch curve of a ball, to which the pitch surface shrinks, makes that
        parallel surface singular; margin and curvature of the flank follow from it without dividing by zero.
        """
        x_phi, x_t, n_phi, n_t = self._tangents
        n = self.n
        n_phi, n_t = n_phi - dot(n_phi, n) * n, n_t - dot(n_t, n) * n
        d = -0.5 / self.roller_curvatures[0]
        p_phi, p_t = x_phi - d * n_phi, x_t - d * n_t
        middle = Forms(
            dot(p_phi, p_phi), dot(p_phi, p_t), dot(p_t, p_t), -dot(n_phi, p_phi), -dot(n_phi, p_t), -dot(n_t, p_t)
        )
        return (*middle.principal(), d)

    @cached_property
    def k_rel(self) -> Floats:
        """Relative (induced) curvature of cam against roller across the contact line, 1/mm, (n, m); must be > 0.

        The flank's principal curvatures are k / (1 - d k), k those of a parallel surface at distance d; at a cusp,
        where they have no bound, the denominator is kept from zero: the value is very large and not infinite.
        """
        k1, k2, d = self._middle_curvatures
        round_it, along = self.roller_curvatures
        total = -round_it - along
        for k in (k1, k2):
            rest = 1.0 - d * k
            total = total + k / np.where(np.abs(rest) > 1e-12, rest, 1e-12)
        return np.asarray(total)

    @cached_property
    def margin(self) -> Floats:
        """Undercut margin 1 - r k_max, (n, m): 1 far from undercut, 0 at the cusp, negative where the flank folds.

        k is the curvature of the pitch surface; of the surface half way it is k / (1 - r k / 2), solved here for k.
        Where k > 2 / r that surface is folded too and its curvature turns negative. (A ball's own circle, whose pitch
        surface is a curve, has no k: it is known by a rest that is zero but for rounding.)
        """
        k1, k2, d = self._middle_curvatures
        rest = 1.0 + d * k1
        margin = (1.0 - d * k1) / np.where(np.abs(rest) > 1e-12, rest, 1e-12)
        for k in (k1, k2):
            rest = 1.0 + d * k
            folded = rest < -TWICE_FOLDED
            margin = np.minimum(margin, np.where(folded, (1.0 - d * k) / np.where(folded, rest, 1.0), margin))
        return np.asarray(margin)

    def pressure_angle(self, at: At = "surface") -> Floats:
        """Angle between the contact normal and the velocity of the follower point, rad, (n, m).

        at="surface" takes the velocity of the contact point, at="axis" that of the axis point beside it (the
        classical figure of globoidal cams). Of rollers that stay upright, those of discs and plates, it is always that
        one: as of all planar cams, whose roller turns on its pin, so that its force passes through its middle.
        """
        sine, cosine = self._leaning(at)
        return np.asarray(np.arctan2(np.sqrt(dot(sine, sine)), np.abs(cosine)))

    def lean(self) -> Floats:
        """The same of a planar cam, with its sign: positive where the normal is turned clockwise to that velocity or
        its opposite, rad, (n, m)."""
        sine, cosine = self._leaning("axis")
        return np.asarray(np.arctan2(sine[2] * np.sign(cosine), np.abs(cosine)))

    def _leaning(self, at: At) -> tuple[Floats, Floats]:
        """Vector and scalar product of the contact normal and that velocity, (3, n, m) and (n, m)."""
        u, _, _ = self._vectors
        middle = at == "axis" or self.track.upright
        point = self.pose.a[0][:, :, None] + self._stations[0][None] * u if middle else self.x
        e = self._carried(point)
        return cross(self.n, e), dot(self.n, e)

    def lever(self) -> Floats:
        """Signed velocity of the contact point along n per unit of the joint coordinate, (n, m): 1 or mm/rad."""
        return dot(self.n, self._carried(self.x))

    @property
    def behind(self) -> bool:
        """Whether this wall pushes the follower on: it lies behind it, and n points out of it against the motion."""
        return float(self.lever().mean()) < 0.0

    def _carried(self, x: Floats) -> Floats:
        """Velocity of follower points (3, n, m), cam frame, per unit of the joint coordinate."""
        pose = self.pose
        if pose.slid is not None:
            # The joint stands still beside a cam that slides.
            x = x - np.array([1.0, 0.0, 0.0])[:, None, None] * pose.slid[None, :, None]
        return self.track.joint.velocity(x, pose.turn)

    def sliding(self, reference: float | None = None) -> tuple[Floats, Floats]:
        """Sliding of the cam over a roller that rolls without slip at one station: mm per rad of cam angle.

        reference  the meridian parameter t that rolls purely; default: the middle station
        Returns (round the roller, along its axis), each (n, m).
        """
        u, _, v = self._vectors
        r = self._stations[3]
        _, q, _ = self._contact
        rim = dot(v, q)
        ratio = rim / r
        stations = self.t if self.t.ndim == 1 else self.t[0]
        middle = len(stations) // 2 if reference is None else int(np.argmin(np.abs(stations - reference)))
        round_it, along = rim - r * ratio[:, middle : middle + 1], dot(v, u) * np.ones_like(rim)
        return self.pose.per_radian(round_it), self.pose.per_radian(along)


def flank(track: Track, phi: Floats, t: Floats, side: float, jet_side: Side = "right") -> Flank:
    """Evaluate one flank; see `Flank`. phi (n,) rad; t (m,) or (n, m) meridian stations; side +1 or -1."""
    return Flank(track, np.atleast_1d(np.asarray(phi, float)), np.atleast_1d(np.asarray(t, float)), side, jet_side)
