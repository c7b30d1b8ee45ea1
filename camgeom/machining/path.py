"""Paths of a tool beside the track of a roller, exact at every cam angle (cam frame, mm, rad).

A tool whose side touches the flank at x with normal n has its axis at x - (radius + stock) n. Where the roller is a
cylinder that is the parallel surface of its pitch surface, and a tool that is not larger than the roller stays within
the roller's own body: it can cut nothing that the roller does not sweep. A wheel may also work with its plane side.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Protocol, final

import numpy as np

from camgeom.immutable import immutable
from camgeom.machining.spec import AxisRule, WayOfPath
from camgeom.machining.wall import cosine_of, depth_of, roller_at, up_of, wall_ends
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.maths.surface import cross, dot
from camgeom.track import TURN, Pose, Track
from camgeom.track.flank import Flank


@final
@immutable
class Positions:
    """Positions of a tool at cam angles phi (n,), rad.

    tip       (3, n) end of the tool on its axis, mm
    axis      (3, n) unit, from the end towards the spindle
    contacts  (k, 3, n) where it touches the flank (a tool between two flanks: k = 2), mm
    normals   (k, 3, n) unit, into the cam's material
    travel    (3, n) unit, the way the contact moves
    away      (3, n) unit, the way the tool leaves the cut
    """

    phi: Floats
    tip: Floats
    axis: Floats
    contacts: Floats
    normals: Floats
    travel: Floats
    away: Floats

    def part(self, pick: slice) -> Positions:
        """Some of the positions."""
        return self._each(lambda values: values[..., pick])

    def repeated(self, count: int) -> Positions:
        """Every position so many times."""
        return self._each(lambda values: np.repeat(values, count, axis=-1))

    def reversed(self) -> Positions:
        """The same positions travelled the other way."""
        back = self.part(slice(None, None, -1))
        return replace(back, travel=-back.travel)

    def turned_over(self, height: float) -> Positions:
        """The same positions seen in a part of that height, mm, that is turned over about the X axis."""
        flip, foot = np.array([[1.0], [-1.0], [-1.0]]), np.array([[0.0], [0.0], [height]])
        return Positions(self.phi, flip * self.tip + foot, flip * self.axis, flip * self.contacts + foot,
                         flip * self.normals, flip * self.travel, flip * self.away)  # fmt: skip

    def lifted(self, height: float) -> Positions:
        """The same positions moved by so many mm the way the tool leaves the cut."""
        return replace(self, tip=self.tip + height * self.away)

    def _each(self, change: Callable[[Floats], Floats]) -> Positions:
        arrays = self.phi, self.tip, self.axis, self.contacts, self.normals, self.travel, self.away
        return Positions(*map(change, arrays))


class ToolPath(Protocol):
    """Positions of a tool as a function of the cam angle."""

    @property
    def name(self) -> str:
        """What it makes."""

    @property
    def closed(self) -> bool:
        """True where it ends where it starts."""

    @property
    def height(self) -> float:
        """Length of the tool in the cut, mm."""

    @property
    def room(self) -> float | None:
        """How far the tool may move off the flank, mm; None: as far as one likes."""

    @property
    def below(self) -> bool:
        """True where the spindle stands below the cam, so that the part is turned over."""

    @property
    def between(self) -> bool:
        """True in a groove, whose other wall another pass makes."""

    def follows(self, track: Track) -> bool:
        """Whether it runs along the track of a roller."""

    def knots(self) -> Floats:
        """Cam angles between which it is smooth, rad, with both ends."""

    def at(self, phi: Floats) -> Positions:
        """Positions at cam angles (n,)."""

    def __hash__(self) -> int:
        """By identity."""


def knots_from(track: Track, start: float) -> Floats:
    """Knots of a closed track over the turn that begins at the cam angle start (rad); of an open one its own."""
    knots = track.knots()
    if not track.closed or start % TURN == 0.0:
        return knots
    return round_from(knots, track.span[0] + start % TURN, TURN)


def round_from(knots: Floats, begin: float, whole: float) -> Floats:
    """Knots (k,) of a closed path, `whole` apart from end to end, over the round that begins somewhere else."""
    shifted = np.concatenate([knots, knots[1:] + whole])
    inside = shifted[(shifted > begin + 1e-12) & (shifted < begin + whole - 1e-12)]
    return np.concatenate([[begin], inside, [begin + whole]])


def flank_name(track: Track, side: float) -> str:
    """The flank of a track on one side; its sign where there are two."""
    mark = "" if len(track.sides) == 1 else " +" if side > 0.0 else " -"
    return f"{track.name}, flank{mark}"


class AlongTrack:
    """What paths along a roller's track have in common; abstract, the paths are final.

    track  the roller's track; start: cam angle rad at which a closed path begins
    side   +1 or -1, the flank it works on; None: all there are
    """

    track: Track
    start: float
    side: float | None

    @property
    def name(self) -> str:
        """What it makes."""
        return f"{self.track.name}, centre" if self.side is None else flank_name(self.track, self.side)

    @property
    def height(self) -> float:
        """Length of the tool in the cut, mm."""
        return depth_of(self.track)

    @property
    def closed(self) -> bool:
        """True where it ends where it starts."""
        return self.track.closed

    @property
    def below(self) -> bool:
        """A drum is cut all round, a disc from the side that its roller comes from."""
        return self.track.upright and up_of(self.track) * self.track.axis[2] < 0.0

    @property
    def between(self) -> bool:
        """Whether the roller has a wall on either side."""
        return len(self.track.sides) > 1

    def follows(self, track: Track) -> bool:
        """Whether that is its track."""
        return self.track is track

    def knots(self) -> Floats:
        """Cam angles between which it is smooth."""
        return knots_from(self.track, self.start)

    def makes(self, side: float) -> bool:
        """Whether it works on the flank of that side."""
        return self.side is None or self.side == side


def travel_of(pose: Pose, delta: float, normal: Floats) -> Floats:
    """Unit direction (3, n) in which the roller passes along the flank at delta; with the sign of the roller's way."""
    v = pose.a[1] + delta * pose.u[1]
    v = v - dot(v, pose.u[0]) * pose.u[0]
    v = v - dot(v, normal) * normal
    return np.asarray(v / np.maximum(np.sqrt(dot(v, v)), 1e-300))


def climbs(positions: Positions) -> bool:
    """True where the material lies on the right hand of a tool's way (clockwise spindle: climb milling)."""
    right = cross(positions.travel, positions.axis)
    return bool(np.median(dot(right, positions.normals[0])) > 0.0)


FITTED = 0.5 - 0.5 / 2.0**0.5
"""shares of the wall's height, from both ends, at which a fitted axis has its exact distance (zeros of a Chebyshev
polynomial: the rest between and beyond them is then the smallest)"""


@final
@immutable
class CentrePath(AlongTrack):
    """The roller's own path: the tool's axis is the roller's."""

    track: Track
    start: float = 0.0
    side: None = None

    @property
    def room(self) -> float | None:
        """None at all."""
        return 0.0

    def at(self, phi: Floats) -> Positions:
        """Positions at cam angles (n,)."""
        track = self.track
        pose = track.pose(phi, 2)
        t = 0.5 * sum(wall_ends(track))
        flanks = [Flank(track, phi, np.array([t]), side, given_pose=pose) for side in track.sides]
        contacts = np.stack([f.x[:, :, 0] for f in flanks])
        normals = np.stack([f.n[:, :, 0] for f in flanks])
        tip = pose.a[0] + track.tip * pose.u[0]
        travel = travel_of(pose, roller_at(track, t)[0], normals[0])
        axis = up_of(track) * pose.u[0]
        return Positions(np.asarray(phi), tip, axis, contacts, normals, travel, axis)


@final
@immutable
class FlankPath(AlongTrack):
    """A tool smaller than the roller beside one flank.

    side    +1 or -1, as in `Flank`
    reach   mm, from the tool's axis to the flank: its radius and the stock
    way     flank: along the normal; shifted: the roller's path moved along the follower's motion by as much as the
            tool is smaller
    axis    roller, fitted or radial (see `CutterSpec.axis`)
    free    mm, how far it may move off a flank that is alone; None: as far as one likes
    """

    track: Track
    side: float
    reach: float
    way: WayOfPath = "flank"
    axis: AxisRule = "roller"
    start: float = 0.0
    free: float | None = None

    @property
    def height(self) -> float:
        """Length of the tool in the cut, mm: of one that leans as a cone does along the flank."""
        leaning = self.axis == "fitted" and self.track.upright
        return depth_of(self.track) / cosine_of(self.track) if leaning else depth_of(self.track)

    @property
    def room(self) -> float | None:
        """In a groove: by how much the roller is larger, where it is least."""
        if len(self.track.sides) == 1:
            return self.free
        if self.axis == "fitted":
            if self.track.upright and roller_at(self.track, wall_ends(self.track)[0])[1] > self._top:
                return 0.0  # Beneath an overhang what moves off goes deeper.
            return max(0.0, min(roller_at(self.track, t)[1] for t in wall_ends(self.track)) - self.reach)
        own = roller_at(self.track, 0.5 * sum(wall_ends(self.track)))[1]
        return max(0.0, own - self.reach * cosine_of(self.track))

    @property
    def _top(self) -> float:
        """Radius of the roller at the top of the wall, mm."""
        return roller_at(self.track, wall_ends(self.track)[1])[1]

    @cached_property
    def _stations(self) -> Floats:
        """Meridian parameters: the middle of the wall, and the two places of a fitted axis."""
        low, high = wall_ends(self.track)
        return np.array([0.5 * (low + high), low + FITTED * (high - low), high - FITTED * (high - low)])

    def at(self, phi: Floats) -> Positions:
        """Positions at cam angles (n,)."""
        phi = np.asarray(phi, dtype=float)
        track, stations = self.track, self._stations[: 3 if self.axis == "fitted" else 1]
        flank = Flank(track, phi, stations, self.side)
        pose, x, n = flank.pose, flank.x, flank.n
        u = pose.u[0]
        place = x - self.reach * n
        if self.way == "shifted":
            place[:, :, 0] = self._shifted(flank)
        if self.axis == "fitted":
            axis, tip = self._fitted(place[:, :, 1], place[:, :, 2], pose)
        elif self.axis == "radial":
            axis, tip = self._radial(place[:, :, 0])
        else:
            axis = up_of(track) * u
            tip = place[:, :, 0] + (track.tip - dot(place[:, :, 0] - pose.a[0], u)) * u
        delta = roller_at(track, float(stations[0]))[0]
        normal = n[:, :, 0]
        return Positions(phi, tip, axis, x[None, :, :, 0], normal[None], travel_of(pose, delta, normal), axis)

    def _shifted(self, flank: Flank) -> Floats:
        """Points (3, n) of the tool's axis: the roller's, moved along the follower's motion towards the flank."""
        pose = flank.pose
        delta, radius = roller_at(self.track, float(self._stations[0]))
        point = pose.a[0] + delta * pose.u[0]
        way = self.track.joint.velocity(point[:, :, None], pose.turn)[:, :, 0]
        way = way / np.sqrt(dot(way, way))
        towards = np.where(dot(way, flank.n[:, :, 0]) >= 0.0, 1.0, -1.0)
        return np.asarray(point + (radius - self.reach) * towards * way)

    def _fitted(self, first: Floats, second: Floats, pose: Pose) -> tuple[Floats, Floats]:
        """Axis through two points; the end stands back by as much as its tilted rim would reach further down."""
        line, up = second - first, up_of(self.track) * pose.u[0]
        axis = line / np.sqrt(dot(line, line)) * np.where(dot(line, up) >= 0.0, 1.0, -1.0)
        cosine = dot(axis, up)
        sunk = dot(first - pose.a[0], up) - self.track.tip * up_of(self.track)
        rim = self.reach * np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0))
        return axis, first - ((sunk - rim) / cosine) * axis

    def _radial(self, place: Floats) -> tuple[Floats, Floats]:
        """Axis through the cam's own, at the azimuth and height of a point."""
        across = np.hypot(place[0], place[1])
        outwards = np.stack([place[0] / across, place[1] / across, np.zeros_like(across)])
        tip = self.track.tip * outwards
        tip[2] = place[2]
        return up_of(self.track) * outwards, tip


@final
@immutable
class SidePath(AlongTrack):
    """A wheel whose plane side lies on one flank: its end is that side, its axis the flank's normal.

    The side touches the middle of the wall, and its rim reaches down to the wall's foot.
    """

    track: Track
    side: float
    radius: float
    stock: float
    start: float = 0.0

    @property
    def room(self) -> float | None:
        """None at all: the wheel comes down from outside."""
        return 0.0

    def at(self, phi: Floats) -> Positions:
        """Positions at cam angles (n,); the axis points from the working side to the back."""
        phi = np.asarray(phi, dtype=float)
        track = self.track
        low, high = wall_ends(track)
        middle = 0.5 * (low + high)
        flank = Flank(track, phi, np.array([middle]), self.side)
        x, n, pose = flank.x[:, :, 0], flank.n[:, :, 0], flank.pose
        up = up_of(track) * pose.u[0]
        up = up - dot(up, n) * n
        up /= np.sqrt(dot(up, up))
        at_middle, at_foot = roller_at(track, middle)[0], roller_at(track, low)[0]
        centre = x - self.stock * n + (self.radius - abs(at_middle - at_foot)) * up
        travel = travel_of(pose, at_middle, n)
        return Positions(phi, centre, -n, x[None], n[None], travel, up)
