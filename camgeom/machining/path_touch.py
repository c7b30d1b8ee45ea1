"""Paths of tools that touch a flank with a part of their own: a ball along a row, a wheel with its plane side."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from camgeom.machining.path import AlongTrack, Positions, depth_of, travel_of, up_of, wall_ends
from camgeom.maths import Floats
from camgeom.maths.surface import dot
from camgeom.track import Track
from camgeom.track.flank import Flank


@final
@dataclass(frozen=True, eq=False)
class RowPath(AlongTrack):
    """A ball that touches one flank along one line of it: the row at the meridian parameter t.

    group  number of the flank among all that a ball works on
    """

    track: Track
    side: float
    radius: float
    stock: float
    t: float
    number: int = 1
    start: float = 0.0
    group: int = 0

    @property
    def name(self) -> str:
        """What it makes."""
        mark = "" if len(self.track.sides) == 1 else " +" if self.side > 0.0 else " -"
        return f"{self.track.name}, flank{mark}, row {self.number}"

    @property
    def height(self) -> float:
        """Length of the tool in the cut, mm."""
        top = self.track.contact[0] if self.track.tip_sign > 0.0 else self.track.contact[1]
        delta = float(self.track.meridian.jet(np.array([self.t]))[0][0])
        return abs(top - delta) + self.radius

    @property
    def room(self) -> float | None:
        """In a groove: by how much the roller is larger there."""
        if len(self.track.sides) == 1:
            return None
        radius = float(self.track.meridian.jet(np.array([self.t]))[3][0])
        return max(0.0, radius - self.radius - self.stock)

    def at(self, phi: Floats) -> Positions:
        """Positions at cam angles (n,); the tip is the lowest point of the ball."""
        phi = np.asarray(phi, dtype=float)
        flank = Flank(self.track, phi, np.array([self.t]), self.side)
        x, n, pose = flank.x[:, :, 0], flank.n[:, :, 0], flank.pose
        axis = up_of(self.track) * pose.u[0]
        centre = x - (self.radius + self.stock) * n
        delta = float(self.track.meridian.jet(np.array([self.t]))[0][0])
        return Positions(phi, centre - self.radius * axis, axis, x[None], n[None], travel_of(pose, delta, n), axis)


@final
@dataclass(frozen=True, eq=False)
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
    def name(self) -> str:
        """What it makes."""
        mark = "" if len(self.track.sides) == 1 else " +" if self.side > 0.0 else " -"
        return f"{self.track.name}, flank{mark}"

    @property
    def height(self) -> float:
        """Depth of the wheel in the cut, mm."""
        return depth_of(self.track)

    @property
    def room(self) -> float | None:
        """None at all: the wheel comes down from outside."""
        return 0.0

    def at(self, phi: Floats) -> Positions:
        """Positions at cam angles (n,); the axis points from the working side to the back."""
        phi = np.asarray(phi, dtype=float)
        track = self.track
        low, high = wall_ends(track)
        t = np.array([0.5 * (low + high)])
        flank = Flank(track, phi, t, self.side)
        x, n, pose = flank.x[:, :, 0], flank.n[:, :, 0], flank.pose
        up = up_of(track) * pose.u[0]
        up = up - dot(up, n) * n
        up /= np.sqrt(dot(up, up))
        delta = track.meridian.jet(np.array([float(t[0]), low]))[0]
        centre = x - self.stock * n + (self.radius - abs(float(delta[0] - delta[1]))) * up
        travel = travel_of(pose, float(delta[0]), n)
        return Positions(phi, centre, -n, x[None], n[None], travel, up)
