"""Tool positions beside the track of a roller, exact at every cam angle (cam frame, mm, rad).

A tool whose side touches the flank at x with normal n has its axis at x - (radius + stock) n. Where the roller is a
cylinder that is the parallel surface of its pitch surface, and a tool that is not larger than the roller stays within
the roller's own body: it can cut nothing that the roller does not sweep.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, final

import numpy as np

from camgeom.maths import Floats
from camgeom.maths.surface import cross, dot
from camgeom.track import TURN, Pose, Track


@final
@dataclass(frozen=True, eq=False)
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
        return Positions(
            self.phi[pick],
            self.tip[:, pick],
            self.axis[:, pick],
            self.contacts[:, :, pick],
            self.normals[:, :, pick],
            self.travel[:, pick],
            self.away[:, pick],
        )

    def reversed(self) -> Positions:
        """The same positions travelled the other way."""
        return Positions(
            self.phi[::-1],
            self.tip[:, ::-1],
            self.axis[:, ::-1],
            self.contacts[:, :, ::-1],
            self.normals[:, :, ::-1],
            -self.travel[:, ::-1],
            self.away[:, ::-1],
        )


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

    def knots(self) -> Floats:
        """Cam angles between which it is smooth, rad, with both ends."""

    def at(self, phi: Floats) -> Positions:
        """Positions at cam angles (n,)."""

    def __hash__(self) -> int:
        """By identity."""


def up_of(track: Track) -> float:
    """+1 where the spindle stands at larger delta."""
    return -track.tip_sign


def wall_ends(track: Track) -> tuple[float, float]:
    """Meridian parameters of the cut wall: at the tool's end (a ball's contact: its lower end) and at the top."""
    top = track.contact[0] if track.tip_sign > 0.0 else track.contact[1]
    foot = track.tip
    t = track.meridian.parameter(foot)
    if abs(abs(t) - 0.25 * TURN) < 1e-9:
        foot = track.contact[1] if track.tip_sign > 0.0 else track.contact[0]
        t = track.meridian.parameter(foot)
    return t, track.meridian.parameter(top)


def depth_of(track: Track) -> float:
    """Depth of the cut along the roller, from the tool's end to the top of the contact, mm."""
    top = track.contact[0] if track.tip_sign > 0.0 else track.contact[1]
    return abs(top - track.tip)


def knots_from(track: Track, start: float) -> Floats:
    """Knots of a closed track over the turn that begins at the cam angle start (rad); of an open one its own."""
    knots = track.knots()
    if not track.closed or start % TURN == 0.0:
        return knots
    begin = track.span[0] + start % TURN
    shifted = np.concatenate([knots, knots[1:] + TURN])
    inside = shifted[(shifted > begin + 1e-12) & (shifted < begin + TURN - 1e-12)]
    return np.concatenate([[begin], inside, [begin + TURN]])


class AlongTrack:
    """What paths along a roller's track have in common; abstract, the paths are final.

    track  the roller's track; start: cam angle rad at which a closed path begins
    """

    track: Track
    start: float

    @property
    def closed(self) -> bool:
        """True where it ends where it starts."""
        return self.track.closed

    def knots(self) -> Floats:
        """Cam angles between which it is smooth."""
        return knots_from(self.track, self.start)


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
