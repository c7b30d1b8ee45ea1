"""Drums with cylindrical rollers on a slide, in closed form.

At the distance R from the drum's axis the groove is the offset of a pitch curve with s' and s'', in closed form
(`mechanics.groove`): pressure angle, margin, curvature and contact are functions of (R, s', s''). A rib's walls are
those of a groove, each with a roller of its own: the one that pushes the follower up stands on the upper.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import final

import numpy as np
from numpy.typing import NDArray

from camgeom.design.batch.axial import Axial
from camgeom.design.batch.motion import Points, single
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.load import thrust_share
from camgeom.track.survey import STATIONS

LEAST = 1e-200
ROUNDS = 5
"""Newton's steps towards the roller that stands nearest a point of a rib"""
STEEP = float(np.sqrt(2.0))
"""s' / R from which on the sharpest curvature may stand above the foot of the wall: R / (R² + s'²)^1.5 is largest at
R = s' / sqrt(2)"""


@final
class Slid(Axial):
    """Rollers on a slide."""

    def refuse_carrier(self) -> None:
        """Nothing."""

    @property
    def heights(self) -> tuple[Floats, Floats]:
        """The lift's."""
        return self.motion.lift_range

    @property
    def aside(self) -> Floats:
        """None."""
        return np.zeros(1)

    @property
    def steepest(self) -> Floats:
        """Where the wall is nearest the drum's axis."""
        return self._angle(self.low)

    @property
    def steepest_axis(self) -> Floats:
        """The same: the force passes through the roller's axis."""
        return self.steepest

    @property
    def steepest_quoted(self) -> Floats:
        """In closed form."""
        return self._angle(self.pitch)

    def _angle(self, radius: Floats) -> Floats:
        """Largest pressure angle, deg, at a distance from the drum's axis: that of the axis and that of the walls."""
        return np.asarray(np.degrees(np.arctan2(self.motion.peaks[0], radius)))

    def _folding(self, radius: Floats, points: Points) -> Floats:
        """r k of the pitch surface towards the wall that it undercuts first, k its larger curvature."""
        # With q = 1 / (R² + s'²) that curvature is q (w + sqrt(w² + 4 s'²)) / 2, w = R |s''| sqrt q.
        slope = points.ds * points.ds
        q = 1.0 / (radius * radius + slope)
        w = np.sqrt(q)
        w *= radius * np.abs(points.dds)
        root = w * w
        root += 4.0 * slope
        np.sqrt(root, out=root)
        root += w
        root *= q
        return np.asarray(root * (0.5 * self.cutter))

    def _effective_radius(self, sign: float, radius: Floats, points: Points) -> Floats:
        """Relative radius times sign, mm: +1 on the wall where it is larger, -1 where it is less (a cusp has none)."""
        q = 1.0 / (radius * radius + points.ds * points.ds)
        turned = q * (self.roller * points.ds)
        turned *= turned
        q *= np.sqrt(q)
        bent = q * ((sign * radius * self.roller) * np.abs(points.dds))
        bent += 1.0
        bent -= turned
        turned += 1.0
        bent /= turned
        bent *= sign * self.roller
        return bent

    def _worst(self, what: Callable[[Slid, Floats, Points], Floats], from_: Callable[[Slid], Floats]) -> Floats:
        """Largest of a quantity over the turn and over the stations from a place to the land, (n,): walls are alike
        where a move is turned about its middle."""
        motion, rough, low = self.motion.halves, self.rough, from_(self)
        if np.all(motion.peaks[0] <= STEEP * low):
            return self.largest(lambda drums, points: what(drums, from_(drums), points), motion)
        radii = low + (self.radius - low) * np.linspace(0.0, 1.0, STATIONS)[:, None]
        first, *others = (single(one) for one in radii[[0, STATIONS // 2, -1]])

        def worst(points: Points) -> Floats:
            values = what(rough, first, points)
            # The others matter on steep flanks alone.
            rows = np.flatnonzero((np.abs(points.ds) > STEEP * first).any(axis=1))
            if rows.size:
                steep = points.of(rows)
                values[rows] = np.max([values[rows], *(what(rough, one, steep) for one in others)], axis=0)
            return values

        return self.over(what, radii, motion.spread(worst, rough=True), motion)

    @cached_property
    def margin(self) -> Floats:
        """Least margin against undercut over the wall, 1: from the tool's end up, of a rib from the drum beside it."""
        if not self.rib:
            return np.asarray(1.0 - self._worst(Slid._folding, lambda drums: drums.floor))
        shares = (0.0,) if np.all(self.motion.peaks[0] <= STEEP * self.floor) else (0.0, 0.5, 1.0)

        def folding(share: float, drums: Slid, points: Points) -> Floats:
            return drums._rib_folding(share, points)

        folds = [self.largest(partial(folding, share), self.motion) for share in shares]
        return np.asarray(1.0 - np.max(folds, axis=0))

    def _rib_folding(self, share: float, points: Points) -> Floats:
        """The same as `_folding` at a share of a rib's wall from its foot up."""
        foot = self._under(self.floor, self.cutter, points)
        return self._folding(foot + share * (self.radius - foot), points)

    @property
    def thickness(self) -> Floats:
        """Least normal thickness of a rib, mm, at its tip and its foot: how far points of either wall are from all
        places of the other's roller."""
        places = [(radius, way) for radius in (self.radius, self.floor) for way in (1.0, -1.0)]
        return np.asarray(np.min([self.motion.smallest(partial(self._thick, *place)) for place in places], axis=0))

    def _thick(self, radius: Floats, way: float, points: Points) -> Floats:
        """Distance, mm, of the wall of the upper, 1, or lower, -1, roller from the other one where that is nearest."""
        half = self.half + self.roller
        place = self._under(radius, self.cutter, points)
        far = np.hypot(place, points.ds)
        sine, cosine = points.ds / far, place / far
        angle = points.theta + np.arctan2(way * self.cutter * sine, place)
        height = points.s + way * (half - self.cutter * cosine)
        at = points.theta + np.arctan2(2.0 * way * half * cosine * sine, place)
        for _ in range(ROUNDS):
            other = self.motion.whenever(at)
            lag, up = angle - at, height - other.s + way * half
            # of half the square of the distance
            slope = -0.5 * radius**2 * np.sin(2.0 * lag) - up * other.ds
            bend = radius**2 * np.cos(2.0 * lag) + other.ds**2 - up * other.dds
            at = at - np.clip(slope / np.maximum(np.abs(bend), LEAST), -0.1, 0.1)
        other = self.motion.whenever(at)
        return np.asarray(np.hypot(radius * np.sin(angle - at), height - other.s + way * half) - self.cutter)

    def widest(self, sign: float) -> Floats:
        """On the wall where it is larger, 1, or where it is less, -1."""
        return self._worst(lambda drums, *at: drums._effective_radius(sign, *at), lambda drums: drums.low)

    @property
    def run_out(self) -> Floats:
        """From the roller's contact to the nearer end of the drum, mm."""
        (least, most), number = self.motion.lift_range, self.variants.number
        return np.asarray(np.minimum(number("cam.start") + least, number("cam.length") - number("cam.start") - most)
                          - self.half)

    # Load and contact

    def _share(self, points: Points, force: Floats, place: Floats) -> Floats:
        """Normal force at a place along the roller over the follower's force is 1 over this."""
        cosine = place / np.sqrt(place * place + points.ds * points.ds)
        if not self.guided:
            return np.asarray(cosine)
        return thrust_share(force, cosine, self.variants.number("operation.guide_friction"), points.side)

    @cached_property
    def jams(self) -> NDArray[np.bool_]:
        """Where the guides' friction takes all of a force."""
        if not self.guided:
            return np.zeros(1, dtype=bool)
        jams = (self._share(points, self.force(points), self.middle) <= 0.0 for points in self.motion.parts)
        return np.asarray(np.any([one.any(axis=0) for one in jams], axis=0))

    def pushed(self, points: Points, force: Floats) -> Floats:
        """With the friction that the side thrust in the middle of the contact makes."""
        if not self.guided:
            return force
        cosine = self.middle / np.sqrt(self.middle * self.middle + points.ds * points.ds)
        return np.asarray(cosine * force / self._share(points, force, self.middle))

    def normal(self, points: Points, way: float, force: Floats, place: Floats) -> Floats:
        """Alike for both rollers of a rib."""
        return np.asarray(force / self._share(points, force, place))

    def lever2(self, points: Points, way: float, place: Floats) -> Floats:
        """cos² of the pressure angle."""
        square = place * place
        return np.asarray(square / (square + points.ds * points.ds))

    def wall(self, points: Points, way: float, up: Floats, place: Floats) -> tuple[Floats, Floats]:
        """cos of the pressure angle, and of the wall that is the pitch curve's offset."""
        q = 1.0 / (place * place + points.ds * points.ds)
        cosine = place * np.sqrt(q)
        turned = self.roller * points.ds * q
        turned *= turned
        return cosine, self.across(up * (cosine * points.dds * q), turned)

    def reach(self, points: Points, way: float, up: Floats) -> Floats:
        """On a steep flank the contact line leaves the land below its edge: with x the square of the place along the
        axis x² + (s'² - R²) x + s'² (r² - R²) = 0."""
        return self._under(self.radius, self.roller, points) - self.low

    @staticmethod
    def _under(radius: Floats, roller: Floats, points: Points) -> Floats:
        """Place on a roller's axis, mm from the drum's, of the contact that lies so far from the drum's axis."""
        outer, slope = radius * radius, points.ds * points.ds
        both = outer + slope
        root = np.sqrt(np.maximum(both * both - 4.0 * slope * (roller * roller), 0.0))
        return np.asarray(np.sqrt(np.maximum(0.5 * (outer - slope + root), 0.0)))
