"""The groove of a drum rolled out flat: where its flanks and the roller's axis meet a cylinder about the cam axis."""

from __future__ import annotations

import numpy as np

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.curves import PlaneCurve, Role
from camgeom.maths.surface import dot
from camgeom.track import TURN, Track
from camgeom.track.column import Column, ConeLevel, cylinder_level
from camgeom.track.flank import Flank


@immutable
class FlankLine:
    """A flank where it meets the cylinder of `radius` mm: x = radius * azimuth (as seen from outside), y = z, mm.

    The azimuth of the points is followed without jumps from `origin` (rad) at cam angle zero.
    """

    track: Track
    side: float
    radius: float
    origin: float = 0.0

    def __call__(self, phi: Floats) -> tuple[Floats, Floats]:
        """Points and derivatives (2, n). Raises NotConverged where the flank does not reach the cylinder."""
        column = Column(self.track, phi)
        t = column.reach(self.side, cylinder_level(self.radius), self.radius)
        flank = Flank(self.track, phi, t, self.side)
        x = flank.x[:, :, 0]
        along, up = (d[:, :, 0] for d in flank.tangents)
        return _unrolled(self.track, phi, x, along, up, self.radius, self.origin)


@immutable
class AxisLine:
    """Where the roller's axis meets the cylinder of `radius` mm, rolled out as `FlankLine` is."""

    track: Track
    radius: float
    origin: float = 0.0

    def __call__(self, phi: Floats) -> tuple[Floats, Floats]:
        """Points and derivatives (2, n)."""
        pose = self.track.pose(phi, 1)
        a, u = pose.a[0], pose.u[0]
        flat = np.array([1.0, 1.0, 0.0])[:, None]
        square, mixed = dot(u * flat, u), dot(u * flat, a)
        rest = np.maximum(mixed**2 - square * (dot(a * flat, a) - self.radius**2), 0.0)
        # Of the two crossings the roller is at the one where its contact lies.
        sign = np.sign(sum(self.track.contact)) or 1.0
        delta = (-mixed + sign * np.sqrt(rest)) / square
        x = a + delta * u
        return _unrolled(self.track, phi, x, pose.a[1] + delta * pose.u[1], u, self.radius, self.origin)


@immutable
class ConeLine:
    """A flank, or the roller's axis, where it meets a cone, rolled out flat: the apex at the origin, as seen from
    outside with +Z up, mm.

    side    of the flank; 0: the roller's axis
    place   along the roller at which the cone lies near its axis, mm
    The azimuth is followed without jumps from `origin` (rad) at cam angle zero; half a turn stands at x = 0.
    """

    track: Track
    side: float
    cone: ConeLevel
    place: float
    origin: float = 0.0

    def __call__(self, phi: Floats) -> tuple[Floats, Floats]:
        """Points and derivatives (2, n). Raises NotConverged where the flank does not reach the cone."""
        if self.side:
            t = Column(self.track, phi).reach(self.side, self.cone, self.place)
            flank = Flank(self.track, phi, t, self.side)
            x = flank.x[:, :, 0]
            along, up = (d[:, :, 0] for d in flank.tangents)
        else:
            pose = self.track.pose(phi, 1)
            x, along, up = pose.a[0] + self.place * pose.u[0], pose.a[1] + self.place * pose.u[1], pose.u[0]
        away = np.hypot(x[0], x[1])
        radial, zero = np.stack([x[0], x[1], np.zeros_like(phi)]) / away, np.zeros_like(phi)
        square = radial + np.stack([zero, zero, zero + self.cone.slope])
        velocity = along - up * (dot(square, along) / dot(square, up))
        turned = -self.track.sense * phi
        around = np.angle((x[0] + 1j * x[1]) * np.exp(-1j * turned))
        sine = self.cone.slope / np.hypot(1.0, self.cone.slope)
        # The distance from the apex, positive below one that is above, and the angle about it.
        long, angle = away / sine, sine * (self.origin + turned + around - 0.5 * TURN)
        out, aside = dot(radial, velocity) / sine, (radial[0] * velocity[1] - radial[1] * velocity[0]) * sine / away
        c, s = np.cos(angle), np.sin(angle)
        return np.stack([long * s, -long * c]), np.stack([out * s + long * aside * c, long * aside * s - out * c])


def rolled_out(tracks: tuple[Track, ...], cone: ConeLevel, place: float) -> tuple[PlaneCurve, ...]:
    """Both flanks and the centre line of every track on a cone, rolled out about its apex; see `developed`."""
    curves = []
    for track in tracks:
        origin = TURN if track.sense > 0.0 else 0.0
        for side in (*track.sides, 0.0):
            word = f"flank {'+' if side > 0.0 else '-'}" if side else "centre"
            line = ConeLine(track, side, cone, place, origin)
            role: Role = "profile" if side else "pitch"
            curves.append(PlaneCurve(f"{track.name} {word}", role, line, track.knots(), False))
    return tuple(curves)


def _unrolled(
    track: Track, phi: Floats, x: Floats, along: Floats, up: Floats, radius: float, origin: float
) -> tuple[Floats, Floats]:
    """Points x (3, n) on the cylinder and their derivative, (2, n) each; they stay on it by moving along `up`."""
    radial = np.stack([x[0], x[1], np.zeros_like(phi)]) / radius
    velocity = along - up * (dot(radial, along) / dot(radial, up))
    turned = -track.sense * phi
    around = np.angle((x[0] + 1j * x[1]) * np.exp(-1j * turned))
    points = np.stack([radius * (origin + turned + around), x[2]])
    return points, np.stack([radial[0] * velocity[1] - radial[1] * velocity[0], velocity[2]])


def developed(tracks: tuple[Track, ...], radius: float) -> tuple[PlaneCurve, ...]:
    """Both flanks and the centre line of every track, rolled out at a radius, mm.

    x runs from 0 to one circumference (open tracks over several turns run beyond), with the azimuth as seen from
    outside; cam angle zero stands at x = 0 where the cam turns clockwise and at the circumference otherwise.
    """
    curves = []
    for track in tracks:
        origin = TURN if track.sense > 0.0 else 0.0
        for side in track.sides:
            word = f"{track.name} flank {'+' if side > 0.0 else '-'}"
            curves.append(PlaneCurve(word, "profile", FlankLine(track, side, radius, origin), track.knots(), False))
        axis = AxisLine(track, radius, origin)
        curves.append(PlaneCurve(f"{track.name} centre", "pitch", axis, track.knots(), False))
    return tuple(curves)


def drum_radii(model_radius: float, quoted: float) -> tuple[tuple[str, float], ...]:
    """The radii a drum is rolled out at, mm, with their names: pitch and outer; one where they are the same."""
    if abs(model_radius - quoted) < 1e-9:
        return (("outer", model_radius),)
    return ("pitch", quoted), ("outer", model_radius)
