"""What carries a cam that slides to and fro instead of turning: its place over the turn of the drive, and the path.

The cam angle is the drive's: in one turn of it the plate goes out over its stroke and comes back. What the follower
does stands over the plate's travel, so that both ways run the same groove.
"""

from __future__ import annotations

from dataclasses import replace
from typing import final

import numpy as np

from camgeom.immutable import immutable
from camgeom.maths import TURN, Floats
from camgeom.maths.extremum import bracketed_root
from camgeom.maths.frozen import cached_property
from camgeom.motion.composed import composed, place
from camgeom.motion.program import Program
from camgeom.motion.segment import Segment


@final
@immutable
class Carriage:
    """A plate on a slide along -X; seen from it the follower goes along +X.

    path    lift over the travel; its turn is the stroke
    drive   place of the plate over the turn of its drive; 2 pi is the stroke
    stroke  mm
    """

    path: Program
    drive: Program
    stroke: float

    @cached_property
    def program(self) -> Program:
        """The follower's motion over the drive's turn: what acts in time."""
        return composed(self.path, self.drive)

    def travel(self, theta: Floats) -> Floats:
        """How far the plate is out, mm, at angles of its drive (n,), rad."""
        return np.asarray(place(self.drive, theta) * (self.stroke / TURN))

    def rates(self, theta: Floats) -> Floats:
        """Travel and its first two derivatives by the drive's angle, mm/rad and mm/rad², (3, n): below zero on the way
        back."""
        return np.asarray(self.drive.jet(theta, 2) * (self.stroke / TURN))

    def pace(self, theta: Floats) -> Floats:
        """Speed of the plate, mm per rad of its drive, (n,), as a magnitude."""
        return np.asarray(np.abs(self.drive.jet(theta, 1)[1]) * (self.stroke / TURN))

    def lift(self, travel: Floats, order: int) -> Floats:
        """Lift and its derivatives per mm of travel, (order + 1, n), at travels (n,), mm; straight on beyond the ends.

        Where a derivative jumps the value behind is given, at the end of the stroke that before.
        """
        phi = np.clip(travel, 0.0, self.stroke) * (TURN / self.stroke)
        jet = self.path.jet(np.minimum(phi, TURN), order, "right")
        last = phi >= TURN
        if np.any(last):
            jet[:, last] = self.path.jet(np.array([TURN]), order, "left")
        return np.asarray(jet * (TURN / self.stroke) ** np.arange(order + 1)[:, None])

    @cached_property
    def even(self) -> Carriage:
        """The same path, run once from end to end at a constant speed."""
        return replace(self, drive=Program.from_segments([Segment(TURN, TURN, "constant-velocity")], closed=False))

    @property
    def turned(self) -> float:
        """Angle of the drive at which the plate is out and turns round, rad."""
        return self.drive.spans[0].end

    def back(self, theta: Floats) -> Floats:
        """Angles of the drive, rad, at which the plate is as far out on its way back as at angles on its way out."""
        wanted = self.drive.jet(theta, 0)[0]
        low, high = np.full(theta.shape, self.turned), np.full(theta.shape, TURN)
        return np.asarray(bracketed_root(lambda at: self.drive.jet(at, 0)[0] - wanted, low, high))

    def out(self, travel: Floats) -> Floats:
        """The angles of the drive (n,), rad, at which the plate is so far out, mm, on its way out."""
        wanted = np.clip(travel, 0.0, self.stroke) * (TURN / self.stroke)
        ends = np.zeros(wanted.shape), np.full(wanted.shape, self.turned)
        return np.asarray(bracketed_root(lambda at: self.drive.jet(at, 0)[0] - wanted, *ends))
