"""Grooved bodies as sections are made of them: exact points of the contour, and who presses it where.

A contour runs in bands from place 0 to 5: flank, root, floor, root, flank. In the plane of a section u runs across the
groove and v out of it: of a drum u = z and v = r, of a plate with a groove in its upper face u = -r and v = z.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import ClassVar, Protocol, Self, final

import numpy as np

from camgeom.errors import DesignError, NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.solid import Part
from camgeom.solid.blank import Bore
from camgeom.solid.drum import GroovedCylinder
from camgeom.solid.prism import FaceGroove, GroovedPlate
from camgeom.track import TURN, Straight, Track
from camgeom.track.column import Column
from camgeom.track.flank import Flank
from camgeom.track.outline import CircleOutline

STEPS = 40
FLATTEST = 0.05
"""least rate of azimuth by cam angle that a step trusts"""
MISSED = 1e-8
NEAR = 1e-11
"""rad; azimuth that a contour point may miss its plane by"""
NO_BORE = "the volume of a body without a bore is not meshed: a ring has a hole; give cam.bore"
KEYWAY = "the keyway is left out"


@final
@immutable(eq=True)
class GrooveShape:
    """Numbers of a grooved body, mm, and names of its faces.

    sense       +1 where the cam turns counter-clockwise
    root        radius, 0: sharp; depth and half_width: of the groove, square to it
    foot, back  v at which the flanks end and the roots begin, and at the back of the body; ends: u there
    faces       names of the faces at both ends and at the back; flanks: words for the first flank and the second
    notes       what a mesh leaves out
    """

    sense: float
    root: float
    depth: float
    half_width: float
    foot: float
    ends: tuple[float, float]
    back: float
    faces: tuple[str, str, str]
    flanks: tuple[str, str]
    notes: tuple[str, ...]


class Walled(Protocol):
    """A ring body whose flanks a roller presses."""

    def second(self, side: float) -> bool:
        """Whether a side of the track is the second flank."""

    def word(self, side: float) -> str:
        """The flank on a side of the track, in words."""

    def place(self, theta: float, side: float, t: Floats) -> tuple[Floats, Floats, Floats]:
        """Place on the contour (m,), azimuth (m,) and normals into the material (3, m) at stations t (m,)."""

    def thickness(self, theta: Floats, side: float, t: float) -> Floats:
        """Of the material behind a flank at station t, square to it, mm, at cam angles (n,)."""


class Groove(Walled, Protocol):
    """A body with one closed groove between two walls."""

    @property
    def shape(self) -> GrooveShape:
        """Its numbers. Raises DesignError where it is no ring."""

    @property
    def straight(self) -> bool:
        """True where a cylindrical tool cuts its flanks, which may have a corner."""

    def rounded(self, root: float) -> Self:
        """The same body with another root, mm."""

    def at(self, phi: Floats, row: Floats) -> Floats:
        """Points (3, n) of the contour at cam angles (n,) and places (n,)."""

    def uv(self, z: Floats, r: Floats) -> tuple[Floats, Floats]:
        """u and v of points."""

    def zr(self, u: Floats, v: Floats) -> tuple[Floats, Floats]:
        """z and r of points."""

    def outward(self, x: Floats) -> Floats:
        """Unit directions (..., 3) of v at points (..., 3)."""


def at_azimuths(surface: Callable[[Floats, Floats], Floats], sense: float, psi: Floats, rows: Floats) -> Floats:
    """Points (3, n k) of a surface at azimuths (n,) and rows (n, k): the cam angle of each is solved for.

    surface  (phi (m,), row (m,)) -> (3, m). Raises NotConverged where a plane through the axis does not meet it once.
    """
    row, plane = rows.ravel(), np.repeat(psi, rows.shape[1])
    phi = -sense * plane
    x = np.empty((3, len(phi)))

    def off(at: Floats) -> Floats:
        x[:] = surface(at % TURN, row)
        return np.asarray((np.arctan2(x[1], x[0]) - plane + np.pi) % TURN - np.pi)

    gap, slope = off(phi), np.ones(len(phi))
    for _ in range(STEPS):
        if float(np.abs(gap).max()) < NEAR:
            break
        step = sense * gap / slope
        after = off(phi + step)
        fresh = -sense * (after - gap) / np.where(step != 0.0, step, 1.0)
        slope = np.where((step != 0.0) & (fresh > FLATTEST), np.minimum(fresh, 1.0 / FLATTEST), slope)
        phi, gap = phi + step, after
    if float(np.abs(gap).max()) > MISSED:
        raise NotConverged("a plane through the cam's axis does not meet the cam's surface in one point of each row: "
                           "the volume is not meshed")  # fmt: skip
    return x


def radius_at(track: Track, delta: float) -> float:
    """Radius of a track's tool at delta, mm."""
    return float(track.meridian.jet(np.array([track.meridian.parameter(delta)]))[3][0])


def bore_radius(bore: Bore | None) -> float:
    """mm. Raises DesignError where there is none."""
    if bore is None:
        raise DesignError(NO_BORE)
    return 0.5 * bore.diameter


def left_out(bore: Bore | None) -> tuple[str, ...]:
    """What a ring leaves out of a bore."""
    return (KEYWAY,) if bore is not None and bore.keyway_width else ()


@final
@immutable
class DrumGroove:
    """A drum with one closed groove: the lower flank is the first."""

    body: GroovedCylinder

    @property
    def straight(self) -> bool:
        """True but round a cone, or a crown that its flank conforms to."""
        side = self.body.track.meridian
        return isinstance(side, Straight) and not side.slope

    @cached_property
    def shape(self) -> GrooveShape:
        """Its numbers. Raises DesignError without a bore."""
        body, track = self.body, self.body.track
        return GrooveShape(track.sense, track.root, body.radius - track.tip, radius_at(track, track.foot), track.foot,
                     (0.0, body.length), bore_radius(body.blank.bore), ("end_lower", "end_upper", "bore"),
                     ("lower", "upper"), left_out(body.blank.bore))  # fmt: skip

    def rounded(self, root: float) -> DrumGroove:
        """The same body with another root, mm."""
        return replace(self, body=replace(self.body, track=replace(self.body.track, root=root)))

    def at(self, phi: Floats, row: Floats) -> Floats:
        """Points (3, n) of the contour."""
        return self.body.section.at(phi, row, (1, 1, 1, 1, 1))

    def uv(self, z: Floats, r: Floats) -> tuple[Floats, Floats]:
        """u and v of points."""
        return z, r

    def zr(self, u: Floats, v: Floats) -> tuple[Floats, Floats]:
        """z and r of points."""
        return u, v

    def outward(self, x: Floats) -> Floats:
        """Unit directions (..., 3) of v."""
        flat = x * np.array([1.0, 1.0, 0.0])
        return np.asarray(flat / np.hypot(x[..., 0], x[..., 1])[..., None])

    def second(self, side: float) -> bool:
        """Whether a side is the second flank."""
        return side != self.body.section.first

    def word(self, side: float) -> str:
        """The flank in words."""
        return f"the {self.shape.flanks[int(self.second(side))]} flank"

    def place(self, theta: float, side: float, t: Floats) -> tuple[Floats, Floats, Floats]:
        """Place, azimuth and normals of what touches."""
        track, section = self.body.track, self.body.section
        column = Column(track, np.array([theta]))
        top, foot = float(column.reach(side, section.level, section.guess)[0, 0]), float(column.bottom_t()[0, 0])
        share = np.clip((t - top) / (foot - top), 0.0, 1.0)
        flank = Flank(track, np.array([theta]), t, side)
        x = flank.x[:, 0]
        return 5.0 - share if self.second(side) else share, np.arctan2(x[1], x[0]), flank.n[:, 0]

    def point(self, theta: Floats, side: float, t: float) -> tuple[Floats, Floats]:
        """Point and normal (3, n) of a flank at station t."""
        flank = Flank(self.body.track, theta, np.array([t]), side)
        return flank.x[:, :, 0], flank.n[:, :, 0]

    def thickness(self, theta: Floats, side: float, t: float) -> Floats:
        """Of the wall behind a flank, mm: out to the end of the drum."""
        x, n = self.point(theta, side, t)
        return np.asarray(np.where(n[2] > 0.0, self.body.length - x[2], x[2]) * np.abs(n[2]))


@final
@immutable
class PlateGroove:
    """A plate with a groove in a face, cut by the tool of a track: of an upper face the outer flank is the first, of a
    lower one, whose section is turned by half a turn, the inner one."""

    plate: GroovedPlate
    track: Track
    number: int = 0
    straight: ClassVar[bool] = True

    @property
    def body(self) -> FaceGroove:
        """The groove."""
        return self.plate.grooves[self.number]

    @cached_property
    def radii(self) -> tuple[float, float]:
        """Of rim and bore, mm. Raises DesignError without a bore."""
        rim = float(np.hypot(*self.plate.rim.outline.curve(np.zeros(1)).points[:, 0]))
        return rim, bore_radius(self.plate.bore)

    @cached_property
    def shape(self) -> GrooveShape:
        """Its numbers. Raises DesignError without a bore."""
        body, plate, (rim, bore) = self.body, self.plate, self.radii
        up, flanks, faces = body.way > 0.0, ("outer", "inner"), ("rim", "bore")
        back = (plate.z0, "end_lower") if up else (-plate.z1, "end_upper")
        return GrooveShape(self.track.sense, body.root, abs(body.top - body.floor), radius_at(self.track, body.foot),
                     body.way * body.foot, (-rim, -bore) if up else (bore, rim), back[0],
                     (*(faces if up else faces[::-1]), back[1]), flanks if up else flanks[::-1],
                     left_out(plate.bore))  # fmt: skip

    def rounded(self, root: float) -> PlateGroove:
        """The same body with another root, mm."""
        grooves = list(self.plate.grooves)
        grooves[self.number] = replace(self.body, root=root)
        return replace(self, plate=replace(self.plate, grooves=tuple(grooves)))

    def at(self, phi: Floats, row: Floats) -> Floats:
        """Points (3, n) of the contour."""
        body, half = self.body, np.minimum(row, 5.0 - row)
        row = row if body.way > 0.0 else 5.0 - row
        outer, inner = (loop.outline.curve(phi) for loop in (body.outer, body.inner))
        angle = 0.5 * np.pi * np.clip(half - 1.0, 0.0, 1.0)
        aside = body.root * (1.0 - np.cos(angle))
        far, near = outer.points - outer.normals * aside, inner.points + inner.normals * aside
        flat = far + (near - far) * np.clip(row - 2.0, 0.0, 1.0)
        z = body.top + (body.foot - body.top) * np.minimum(half, 1.0) - body.way * body.root * np.sin(angle)
        return np.concatenate([flat, z[None]])

    def uv(self, z: Floats, r: Floats) -> tuple[Floats, Floats]:
        """u and v of points."""
        return -self.body.way * r, self.body.way * z

    def zr(self, u: Floats, v: Floats) -> tuple[Floats, Floats]:
        """z and r of points."""
        return self.body.way * v, -self.body.way * u

    def outward(self, x: Floats) -> Floats:
        """Unit directions (..., 3) of v."""
        return np.broadcast_to(np.array([0.0, 0.0, self.body.way]), x.shape)

    @cached_property
    def _outer(self) -> float:
        """The side of the track that is the outer flank."""
        at, t = np.zeros(1), np.array([self.track.meridian.parameter(self.body.foot)])
        x = Flank(self.track, at, t, 1.0).x[:2, 0, 0]
        far, near = (loop.outline.curve(at).points[:, 0] for loop in (self.body.outer, self.body.inner))
        return 1.0 if np.hypot(*(x - far)) < np.hypot(*(x - near)) else -1.0

    def second(self, side: float) -> bool:
        """Whether a side is the second flank."""
        return (side != self._outer) == (self.body.way > 0.0)

    def word(self, side: float) -> str:
        """The flank in words."""
        return f"the {self.shape.flanks[int(self.second(side))]} flank"

    def place(self, theta: float, side: float, t: Floats) -> tuple[Floats, Floats, Floats]:
        """Place, azimuth and normals of what touches."""
        flank = Flank(self.track, np.array([theta]), t, side)
        x, body = flank.x[:, 0], self.body
        share = np.clip((body.top - x[2]) / (body.top - body.foot), 0.0, 1.0)
        return 5.0 - share if self.second(side) else share, np.arctan2(x[1], x[0]), flank.n[:, 0]

    def thickness(self, theta: Floats, side: float, t: float) -> Floats:
        """Of the wall behind a flank, mm: out to the rim, or in to the bore, along the flank's normal."""
        flank = Flank(self.track, theta, np.array([t]), side)
        x, n = flank.x[:2, :, 0], flank.n[:2, :, 0]
        along, square = (x * n).sum(axis=0), (x * x).sum(axis=0)
        rim, bore = self.radii
        if side == self._outer:
            return np.asarray(np.sqrt(along**2 + rim**2 - square) - along)
        # Where the normal misses the bore it passes beside it: the nearest way in is what is left of the wall.
        left = along**2 + bore**2 - square
        return np.asarray(np.where((left > 0.0) & (along < 0.0), -along - np.sqrt(np.maximum(left, 0.0)),
                                   np.sqrt(square) - bore))  # fmt: skip


def groove_of(part: Part, cutters: tuple[Track, ...]) -> Groove | None:
    """The groove of a drum or a plate, cut by the track given, where it is one closed ring; None of other bodies, and
    of a cone, whose layers from groove to bore are not even, and of flanks that lean."""
    if isinstance(part, GroovedCylinder) and not part.slope and part.fits:
        return DrumGroove(part)
    if isinstance(part, GroovedPlate) and len(part.grooves) == 1 and not part.leans:
        return PlateGroove(part, cutters[0]) if isinstance(part.rim.outline, CircleOutline) else None
    return None
