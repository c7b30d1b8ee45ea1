"""The outline of a plate whose upper edge is a roller's envelope, and straight on along its tangents to both ends.

Counter-clockwise from the corner at the origin: foot, end, tangent, envelope, tangent, end.
"""

from __future__ import annotations

from typing import final

import numpy as np

from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.track import TURN, Track
from camgeom.track.outline import Curve, RollerOutline

STRAIGHT = 0.05
"""share of the parameter's turn that each straight side takes"""
FIRST, LAST = 3.0 * STRAIGHT * TURN, (1.0 - 2.0 * STRAIGHT) * TURN
"""parameters between which the envelope runs, from the end of the stroke back to its start"""


@final
@immutable
class EdgeOutline:
    """The closed outline of such a plate 0 <= x <= length, whose foot is y = 0.

    track   the roller's, on a carriage
    radius  mm, of the roller
    """

    track: Track
    radius: float
    length: float

    @cached_property
    def envelope(self) -> RollerOutline:
        """The edge that the roller runs on, over the stroke told as a turn; its normals point out of the plate."""
        return RollerOutline(self.track.evenly, -self.radius)

    @cached_property
    def corners(self) -> Floats:
        """Where straight sides begin or end, (2, 6), in their order. DesignError where an end tangent turns back."""
        ends = self.envelope.curve(np.array([0.0, TURN]))
        (x, y), (nx, ny) = ends.points, ends.normals
        if np.any(ny <= 0.0):
            raise DesignError(
                "the plate's edge turns back at an end of the stroke, so it does not go on to the plate's end; use a "
                "smaller cam.inclination or a gentler motion there"
            )
        left, right = y + (np.array([0.0, self.length]) - x) * -nx / ny
        return np.array([[0.0, 0.0], [self.length, 0.0], [self.length, right], [x[1], y[1]], [x[0], y[0]],
                         [0.0, left]]).T  # fmt: skip

    def knots(self) -> Floats:
        """Parameters from 0 to 2 pi where a derivative may jump."""
        inner = LAST - (LAST - FIRST) / TURN * self.envelope.knots()[::-1]
        step = STRAIGHT * TURN
        return np.concatenate([[0.0, step, 2.0 * step], inner, [TURN - step, TURN]])

    def curve(self, phi: Floats) -> Curve:
        """Points, outward normals, curvature. Raises DesignError where the path stands still."""
        t = np.mod(phi, TURN)
        t = np.where((t == 0.0) & (np.asarray(phi) > 0.0), TURN, t)
        step = STRAIGHT * TURN
        before, behind = t < FIRST, t > LAST
        # The three sides before the envelope, and the two behind it.
        side = np.where(before, t, np.maximum(t - LAST, 0.0)) / step
        number = np.minimum(side.astype(int), np.where(before, 2, 1))
        share, at = side - number, np.where(before, number, number + 4)
        corners = self.corners
        way = (np.roll(corners, -1, axis=1) - corners)[:, at]
        long = np.hypot(*way)
        points, normals = corners[:, at] + share * way, np.stack([way[1], -way[0]]) / long
        curvature, speed = np.zeros_like(t), long / step
        on = ~(before | behind)
        if np.any(on):
            assert self.track.carriage is not None
            rate = TURN / (LAST - FIRST)
            found = self.envelope.curve(np.clip((LAST - t[on]) * rate, 0.0, TURN))
            points[:, on], normals[:, on], curvature[on] = found.points, found.normals, found.curvature
            speed[on] = -found.speed * (self.track.carriage.stroke / TURN * rate)
        return Curve(points, normals, curvature, speed)

    def share(self, phi: Floats) -> Floats:
        """Where along the stroke the roller stands that touches there, (n,): 0 or 1 beyond the envelope."""
        t = np.mod(phi, TURN)
        return np.where(t < STRAIGHT * TURN, 0.0, np.clip((LAST - t) / (LAST - FIRST), 0.0, 1.0))
