"""The outline of a groove with two ends: what a round tool clears that goes along a path from end to end.

Two parallels of the path and half a circle about either end, counter-clockwise, without a corner.
"""

from __future__ import annotations

from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.track import TURN, Track
from camgeom.track.outline import Curve, RollerOutline

CAP = 0.05
"""share of the parameter's turn that the half circle of an end takes"""


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


