"""Paths of a mill along the roller's own path, or beside one flank of its groove or rib."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from camgeom.machining.path import AlongTrack, Positions, depth_of, travel_of, up_of, wall_ends
from camgeom.machining.spec import AxisRule, WayOfPath
from camgeom.maths import Floats
from camgeom.maths.surface import dot
from camgeom.track import Pose, Track
from camgeom.track.flank import Flank

FITTED = 0.5 - 0.5 / 2.0**0.5
"""shares of the wall's height, from both ends, at which a fitted axis has its exact distance (zeros of a Chebyshev
polynomial: the rest between and beyond them is then the smallest)"""


@final
@dataclass(frozen=True, eq=False)
class CentrePath(AlongTrack):
    """The roller's own path: the tool's axis is the roller's."""

    track: Track
    start: float = 0.0

    @property
    def name(self) -> str:
        """What it makes."""
        return f"{self.track.name}, centre"

    @property
    def height(self) -> float:
        """Length of the tool in the cut, mm."""
        return depth_of(self.track)

    @property
    def room(self) -> float | None:
        """None at all."""
        return 0.0

    def at(self, phi: Floats) -> Positions:
        """Positions at cam angles (n,)."""
        track = self.track
        pose = track.pose(phi, 2)
        t = np.array([0.5 * sum(wall_ends(track))])
        flanks = [Flank(track, phi, t, side, given_pose=pose) for side in track.sides]
        contacts = np.stack([f.x[:, :, 0] for f in flanks])
        normals = np.stack([f.n[:, :, 0] for f in flanks])
        tip = pose.a[0] + track.tip * pose.u[0]
        travel = travel_of(pose, float(track.meridian.jet(t)[0][0]), normals[0])
        axis = up_of(track) * pose.u[0]
        return Positions(np.asarray(phi), tip, axis, contacts, normals, travel, axis)


@final
@dataclass(frozen=True, eq=False)
class FlankPath(AlongTrack):
    """A tool smaller than the roller beside one flank.

    side    +1 or -1, as in `Flank`
    reach   mm, from the tool's axis to the flank: its radius and the stock
    way     flank: along the normal; shifted: the roller's path moved along the follower's motion by as much as the
            tool is smaller
    axis    roller, fitted or radial (see `CutterSpec.axis`)
    """

    track: Track
    side: float
    reach: float
    way: WayOfPath = "flank"
    axis: AxisRule = "roller"
    start: float = 0.0

    @property
    def name(self) -> str:
        """What it makes."""
        if len(self.track.sides) == 1:
            return f"{self.track.name}, flank"
        return f"{self.track.name}, flank {'+' if self.side > 0.0 else '-'}"

    @property
    def height(self) -> float:
        """Length of the tool in the cut, mm."""
        return depth_of(self.track)

    @property
    def room(self) -> float | None:
        """In a groove: by how much the roller is larger."""
        if len(self.track.sides) == 1:
            return None
        t = np.array([0.5 * sum(wall_ends(self.track))])
        return max(0.0, float(self.track.meridian.jet(t)[3][0]) - self.reach)

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
        delta = float(track.meridian.jet(stations[:1])[0][0])
        normal = n[:, :, 0]
        return Positions(phi, tip, axis, x[None, :, :, 0], normal[None], travel_of(pose, delta, normal), axis)

    def _shifted(self, flank: Flank) -> Floats:
        """Points (3, n) of the tool's axis: the roller's, moved along the follower's motion towards the flank."""
        pose, stations = flank.pose, self._stations[:1]
        delta, _, _, r, _, _ = self.track.meridian.jet(stations)
        point = pose.a[0] + delta * pose.u[0]
        way = self.track.joint.velocity(point[:, :, None], pose.turn)[:, :, 0]
        way = way / np.sqrt(dot(way, way))
        towards = np.where(dot(way, flank.n[:, :, 0]) >= 0.0, 1.0, -1.0)
        return np.asarray(point + (float(r[0]) - self.reach) * towards * way)

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
        axis = np.stack([place[0] / across, place[1] / across, np.zeros_like(across)])
        tip = self.track.tip * axis
        tip[2] = place[2]
        return axis, tip
