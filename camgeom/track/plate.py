"""Outlines of plates that slide: a groove with two ends, or an upper edge that a roller runs on; counter-clockwise.

The groove is what a round tool clears that goes along a path from end to end: two parallels of the path and half a
circle about either end, without a corner. The edge is a roller's envelope, and straight on along its tangents to both
ends of the plate: from the corner at the origin foot, end, tangent, envelope, tangent, end.
"""

from __future__ import annotations

from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.track import TURN, Track
from camgeom.track.outline import Curve, RollerOutline

CAP = 0.05
"""share of the parameter's turn that the half circle of an end takes"""
STRAIGHT = 0.05
"""share of the parameter's turn that each straight side takes"""
FIRST, LAST = 3.0 * STRAIGHT * TURN, (1.0 - 2.0 * STRAIGHT) * TURN
"""parameters between which the envelope runs, from the end of the stroke back to its start"""
UPPER_SIDE = 2.0 * STRAIGHT * TURN, LAST + (1.0 - 1e-12) * STRAIGHT * TURN
"""parameters between which the edge runs, its straight ends too, from one end of the plate to the other"""
ROUND_ENDS = ((1.0 - CAP) * TURN, TURN), ((0.5 - CAP) * TURN, 0.5 * TURN)
"""parameters between which the half circles about the start and the end of a groove run"""


@final
@immutable
class PocketOutline:
    """The closed edge of the groove that a roller of a cam on a slide needs.

    track   the roller's, on a carriage
    radius  mm, of the tool: half the groove's width

    Its parameter runs over the wall towards smaller lift from the start of the stroke to its end, round that end, back
    over the other wall and round the start.
    """

    track: Track
    radius: float

    @cached_property
    def _even(self) -> Track:
        return self.track.evenly

    def knots(self) -> Floats:
        """Parameters from 0 to 2 pi where a derivative may jump."""
        wall = (0.5 - CAP) * self._even.knots()
        back = TURN - CAP * TURN - wall[::-1]
        return np.concatenate([wall, back, [TURN]])

    def curve(self, phi: Floats) -> Curve:
        """Points, normals out of the groove, curvature. Raises DesignError where the path stands still."""
        t = np.mod(phi, TURN)
        t = np.where((t == 0.0) & (np.asarray(phi) > 0.0), TURN, t)
        reach = (0.5 - CAP) * TURN
        found = [np.zeros((2, len(t))), np.zeros((2, len(t))), np.zeros(len(t)), np.zeros(len(t))]
        out, far, back = t <= reach, (t > reach) & (t < 0.5 * TURN), (t >= 0.5 * TURN) & (t <= 0.5 * TURN + reach)
        for mask, way in ((out, 1.0), (back, -1.0)):
            if not np.any(mask):
                continue
            at = t[mask] / (0.5 - CAP) if way > 0.0 else (0.5 * TURN + reach - t[mask]) / (0.5 - CAP)
            wall = RollerOutline(self._even, -way * self.radius).curve(np.clip(at, 0.0, TURN))
            # Along +X the roller's outline has its normal towards larger lift.
            per = self.track.carriage.stroke / TURN / (0.5 - CAP) if self.track.carriage is not None else 1.0
            _put(found, mask, wall.points, -way * wall.normals, -way * wall.curvature, np.abs(wall.speed) * per
                 * np.sign(-wall.speed))  # fmt: skip
        for mask, end in ((far, TURN), (~(out | far | back), 0.0)):
            if np.any(mask):
                first = 0.5 * TURN - CAP * TURN if end else TURN - CAP * TURN
                _put(found, mask, *self._cap(end, (t[mask] - first) / (CAP * TURN)))
        return Curve(*found)

    def share(self, phi: Floats) -> Floats:
        """Where along the path the tool stands that touches there, (n,): 0 at its start, 1 at its end."""
        share = np.mod(phi, TURN) / TURN
        return np.clip(np.where(share <= 0.5, share, 1.0 - CAP - share) / (0.5 - CAP), 0.0, 1.0)

    def _cap(self, end: float, share: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Half a circle about an end of the path, from the wall that ends there to the one that begins."""
        pose = self._even.pose(np.array([end]), 1)
        way = complex(*pose.a[1][:2, 0])
        start = np.angle(way) - 0.25 * TURN + (0.0 if end else 0.5 * TURN)
        turn = np.exp(1j * (start + 0.5 * TURN * share))
        normals = np.stack([turn.real, turn.imag])
        one = np.ones_like(share)
        return pose.a[0][:2] + self.radius * normals, normals, one / self.radius, one * (0.5 * self.radius / CAP)


def _put(found: list[Floats], mask: npt.NDArray[np.bool_], *values: Floats) -> None:
    for whole, part in zip(found, values):
        whole[..., mask] = part


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
