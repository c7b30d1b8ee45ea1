"""What slides over a planar cam as it passes the finished body: flat faces and knife edges, without the envelope.

The least signed distance of a point of the body from the follower over the whole turn is positive where the follower
stays clear of it, negative where it cuts in. A flat face counts as wide as it likes: whether it is wide enough is
another question, and cams of flat faces are convex.
"""

from __future__ import annotations

from typing import Protocol, final

import numpy as np

from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.extremum import bracketed_maximum
from camgeom.track import TURN, Track
from camgeom.track.outline import FlatFace, RollerOutline

Jet = tuple[Floats, Floats, Floats]

SAMPLES, CHUNK = 720, 2000
NEWTON_STEPS = 4
EXTREMES = 32
"""points at either end of the distances found whose place is bracketed besides"""


class Slider(Protocol):
    """A follower without a roller, seen from the cam."""

    @property
    def name(self) -> str:
        """Its name."""

    def jet(self, x: Floats, phi: Floats) -> Jet:
        """What is least where it passes points x (2, ...) most closely, at cam angles phi (...), and two derivatives.

        The shapes of phi and of the points broadcast.
        """

    def distance(self, x: Floats, phi: Floats) -> Floats:
        """Signed distance (...) of the points there, mm."""


@final
@immutable
class SlidingFace:
    """A flat face: the half plane beyond its line."""

    name: str
    line: FlatFace

    def jet(self, x: Floats, phi: Floats) -> Jet:
        """The distance h - n . x itself."""
        psi, h = (j.reshape(3, *phi.shape) for j in self.line.jets(phi.ravel()))
        c, s = np.cos(psi[0]), np.sin(psi[0])
        out, left = c * x[0] + s * x[1], c * x[1] - s * x[0]
        return h[0] - out, h[1] - psi[1] * left, h[2] - psi[2] * left + psi[1] ** 2 * out

    def distance(self, x: Floats, phi: Floats) -> Floats:
        """From the face's line."""
        return self.jet(x, phi)[0]


@final
@immutable
class SlidingEdge:
    """A knife edge, whose path is the profile itself: a point beyond the path stands in its way."""

    name: str
    track: Track

    def jet(self, x: Floats, phi: Floats) -> Jet:
        """Half the square of the distance from the edge."""
        a = self.track.pose(phi.ravel(), 2).a[:, :2].reshape(3, 2, *phi.shape)
        d = np.stack([x[0] - a[0, 0], x[1] - a[0, 1]])
        return 0.5 * _dot(d, d), -_dot(d, a[1]), _dot(a[1], a[1]) - _dot(d, a[2])

    def distance(self, x: Floats, phi: Floats) -> Floats:
        """From the edge; negative on the path's outer side."""
        path = RollerOutline(self.track, 0.0).curve(phi.ravel())
        d = x - path.points.reshape(2, *phi.shape)
        beyond = _dot(d, path.normals.reshape(2, *phi.shape))
        return np.asarray(-np.copysign(np.hypot(d[0], d[1]), beyond))


def _dot(a: Floats, b: Floats) -> Floats:
    """Of plane vectors (2, ...)."""
    return np.asarray(a[0] * b[0] + a[1] * b[1])


def passing(slider: Slider, points: Floats) -> tuple[Floats, Floats]:
    """Where over the turn the follower is nearest to points (v, 3): cam angles, rad, and signed distances, mm, (v,)."""
    step = TURN / SAMPLES
    grid = step * np.arange(SAMPLES, dtype=np.float64)
    # Points above each other are passed at once.
    order = np.lexsort(points[:, :2].T)
    ranked = points[order, :2]
    new = np.append(True, (ranked[1:] != ranked[:-1]).any(axis=1))
    which = np.empty(len(points), dtype=np.int64)
    which[order] = np.cumsum(new) - 1
    x = np.ascontiguousarray(ranked[new].T)
    phi = np.empty(x.shape[1])
    for begin in range(0, x.shape[1], CHUNK):
        part = slice(begin, begin + CHUNK)
        phi[part] = grid[np.argmin(slider.jet(x[:, part, None], grid)[0], axis=1)]
    first = phi.copy()
    for _ in range(NEWTON_STEPS):
        _, slope, bend = slider.jet(x, phi)
        move = np.where(bend > 0.0, -slope / np.where(bend > 0.0, bend, 1.0), 0.0)
        phi = np.clip(phi + move, first - step, first + step)
    phi = np.where(slider.jet(x, phi)[0] <= slider.jet(x, first)[0], phi, first)
    distance = slider.distance(x, phi)
    order = np.argsort(distance)
    ends = distinct(np.concatenate([order[:EXTREMES], order[-EXTREMES:]]))
    _, phi[ends] = bracketed_maximum(
        lambda at: -slider.jet(x[:, ends, None], at)[0], first[ends] - step, first[ends] + step
    )
    distance[ends] = slider.distance(x[:, ends], phi[ends])
    return phi[which], distance[which]
