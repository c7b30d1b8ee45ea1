"""What stands beside bodies that it must not touch: a whole roller against another disc, over the turn; a pivot."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme, piece_grid
from camgeom.track import Track
from camgeom.track.outline import Outline

PER_TURN = 1440
"""places of a roller in a turn, and points of an outline, before the nearest ones are looked at closer"""
CLOSER, ROUNDS, AROUND = 129, 3, 2.0
"""samples, rounds and steps on either side of the second look"""
BLOCK = 256
"""places that are measured against a whole outline at once"""


@immutable
class Neighbour:
    """A roller and a disc that it passes without touching; heights z in mm.

    track     the roller's, axis parallel to the cam's; roller: z of its two ends; disc: z of the disc's two faces
    sections  radius of the roller, mm, and outline of the disc, at every height at which they may be nearest
    """

    name: str
    track: Track
    roller: tuple[float, float]
    sections: tuple[tuple[float, Outline], ...]
    disc: tuple[float, float]

    @property
    def along(self) -> float:
        """Gap along the axis, mm; negative: by so much the roller stands beside the disc."""
        return max(self.disc[0] - self.roller[1], self.roller[0] - self.disc[1])

    def gap(self, wanted: float) -> Extreme:
        """Distance that roller and disc keep at least, mm, and the cam angle of the nearest place; negative: they meet.

        wanted  mm; where the gap along the axis is larger nothing else is looked at (and the angle is 0)
        """
        if self.along > wanted:
            return Extreme(self.along, 0.0, where="along the axis")
        each = (least_across(self.track, outline, radius) for radius, outline in self.sections)
        across = min(each, key=lambda one: one.value)
        if across.value >= self.along:
            return across
        return Extreme(self.along, across.cam_angle, where="along the axis")


def least_across(track: Track, outline: Outline, radius: float) -> Extreme:
    """Least distance of a roller's circle from the region within a closed outline, over the motion, mm, in XY.

    Negative where the circle reaches into it: by how far, to the sagitta of a step where its centre does.
    """
    least = least_outside(lambda phi: np.asarray(track.pose(phi, 0).a[0][:2]), track.knots(), outline)
    return Extreme(least.value - radius, least.cam_angle, where="beside each other")


def least_outside(path: Callable[[Floats], Floats], knots: Floats, outline: Outline, places: int = PER_TURN) -> Extreme:
    """Least distance of a point from the region within a closed outline, mm, and the parameter of its place; negative:
    how far it gets into it, to the sagitta of a step of the outline.

    path    places (2, n) in the outline's frame by parameters (n,) between the first and the last of the knots
    places  of them that are looked at before the nearest one is looked at closer
    """
    phi, _ = piece_grid(knots, places)
    psi, _ = piece_grid(outline.knots(), PER_TURN)
    corners = outline.curve(psi).points
    signed, near = _signed(path(phi), corners)
    i = int(np.argmin(signed))
    best, at, foot = float(signed[i]), float(phi[i]), float(psi[near[i]])
    step, wide = float(np.diff(phi).max()), float(np.diff(psi).max())
    for _ in range(ROUNDS):
        phi = np.clip(at + AROUND * step * np.linspace(-1.0, 1.0, CLOSER), knots[0], knots[-1])
        step *= 2.0 * AROUND / (CLOSER - 1)
        if best <= 0.0:
            # Within it one place is as far from several sides.
            signed, _ = _signed(path(phi), corners)
            i = int(np.argmin(signed))
            best, at = float(signed[i]), float(phi[i])
            continue
        around = foot + AROUND * wide * np.linspace(-1.0, 1.0, CLOSER)
        distance, feet = _nearest(path(phi), outline.curve(np.mod(around, 2.0 * np.pi)).points)
        i = int(np.argmin(distance))
        best, at, foot = float(distance[i]), float(phi[i]), float(around[feet[i]])
        wide *= 2.0 * AROUND / (CLOSER - 1)
    return Extreme(best, at)


def _signed(x: Floats, corners: Floats) -> tuple[Floats, np.ndarray]:
    """Distances (n,) of points (2, n) from a closed polygon (2, m), negative inside, and the nearest corners (n,)."""
    distance, near = _nearest(x, np.concatenate([corners, corners[:, :1]], axis=1))
    p, q = corners, np.roll(corners, -1, axis=1)
    inside = np.zeros(x.shape[1], dtype=bool)
    for k in range(0, x.shape[1], BLOCK):
        part = x[:, k : k + BLOCK, None]
        spans = (p[1] > part[1]) != (q[1] > part[1])
        rise = np.where(q[1] != p[1], q[1] - p[1], 1.0)
        right = part[0] < p[0] + (part[1] - p[1]) * (q[0] - p[0]) / rise
        inside[k : k + BLOCK] = (spans & right).sum(axis=1) % 2 == 1
    return np.where(inside, -distance, distance), near % corners.shape[1]


def _nearest(x: Floats, corners: Floats) -> tuple[Floats, np.ndarray]:
    """Distances (n,) of points (2, n) from a polyline (2, m), and the beginnings of the nearest edges (n,)."""
    p, along = corners[:, :-1], np.diff(corners, axis=1)
    square = np.maximum((along**2).sum(axis=0), 1e-300)
    distance, near = np.empty(x.shape[1]), np.empty(x.shape[1], dtype=np.int64)
    for k in range(0, x.shape[1], BLOCK):
        off = x[:, k : k + BLOCK, None] - p[:, None, :]
        share = np.clip((off * along[:, None, :]).sum(axis=0) / square, 0.0, 1.0)
        apart = np.hypot(*(off - share * along[:, None, :]))
        near[k : k + BLOCK] = apart.argmin(axis=1)
        distance[k : k + BLOCK] = apart.min(axis=1)
    return distance, near
