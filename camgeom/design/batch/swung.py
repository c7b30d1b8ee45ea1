"""Drums with cylindrical rollers on an arm, in closed form.

The arm turns about a line across the drum's axis, so that its roller stays radial and moves in the plane beside the
axis: y = d - L cos beta, z = L sin beta, L its length and beta its angle with the lift. With delta the place along the
roller, rho = delta - sense y' and W² = rho² + z'², dashes by the cam angle, seen from the cam

    normal of the wall that pushes up = (0, -sense z', -rho) / W,        lever = delta L |cos beta| / W,
    2H = -(rho z'' + sense z' (y'' + y)) / W³,                           M²/D = (z' / W²)²,
    tan of the pressure angle at its surface = |L (delta sin beta - sense L beta') - r W| / (delta L |cos beta|).

On the other wall 2H and what stands before r W change their signs. A rib's rollers stand beside the arm's end: each is
an arm of its own, a little longer and ahead of or behind the other one.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import product
from typing import final

import numpy as np
from numpy.typing import NDArray

from camgeom.cams import sense_of
from camgeom.cams.cylindrical import Cylindrical
from camgeom.design.batch.axial import CANNOT, Axial
from camgeom.design.batch.motion import Motion, Points, single
from camgeom.design.batch.slid import LEAST, ROUNDS, STEEP
from camgeom.design.batch.variants import Variants
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.track.survey import STATIONS

FOOT = 2
"""Newton's steps towards the end of a contact line"""
LEAST_SHARE = 0.01
"""of the square of a drum's radius that the place on a roller's axis keeps where the drum does not reach its wall"""


@final
@immutable
class Arm:
    """Where one roller is at samples of the motion: places and derivatives by the cam angle, mm, (P, n) each.

    up, aside  L cos beta and L sin beta;  y, z of the roller's axis from the drum's axis and from the pivot
    """

    up: Floats
    aside: Floats
    y: Floats
    dy: Floats
    dz: Floats
    bent: Floats
    """sense z' (y'' + y)"""
    ddz: Floats


@final
class Swung(Axial):
    """Rollers on an arm."""

    def __init__(self, variants: Variants, motion: Motion) -> None:
        super().__init__(variants, motion)
        assert isinstance(self.profile.cam, Cylindrical)
        self.sense = sense_of(self.profile.cam.direction)
        self.arm, self.start = variants.number("follower.arm"), np.radians(variants.number("follower.start_angle"))
        aside = self.half + self.roller if self.rib else np.zeros(1)
        # As many as variants, so that what is derived of them can be changed in place.
        self.long = variants.full(np.hypot(self.arm, aside))
        self.ahead = variants.full(np.arctan2(aside, self.arm))

    @cached_property
    def swing(self) -> tuple[Floats, ...]:
        """Least and largest angle of the arm, rad."""
        return tuple(self.start + lift for lift in self.motion.lift_range)

    @cached_property
    def pivot(self) -> Floats:
        """Distance of the pivot from the drum's axis, mm: as given, or such that the arc swings as far to both sides of
        it."""
        given = self.variants.optional("follower.pivot_distance")
        if given is not None:
            return given
        ends = np.broadcast_arrays(*(one for leg in self.motion.legs for one in (leg.before, leg.after)))
        low, high = self.start + np.min(ends, axis=0), self.start + np.max(ends, axis=0)
        return np.asarray(self.arm * 0.5 * sum(self._cosines(low, high)), dtype=self.variants.precision)

    @staticmethod
    def _cosines(low: Floats, high: Floats) -> tuple[Floats, Floats]:
        """Least and largest cosine of the angles between two."""
        one, two = np.cos(low), np.cos(high)
        most = np.where((low <= 0.0) & (high >= 0.0), 1.0, np.maximum(one, two))
        return np.where((high > np.pi) | (low < -np.pi), -1.0, np.minimum(one, two)), most

    def refuse_carrier(self) -> None:
        """As `arc_problems`."""
        refusals, given = self.variants.refusals, self.variants.optional("follower.pivot_distance")
        least, most = (self.arm * one for one in self._cosines(*self.swing))
        pivot = 0.5 * (least + most) if given is None else given
        lost = np.maximum(np.abs(pivot - least), np.abs(pivot - most)) >= self.radius
        refusals.add(lost & (0.5 * (most - least) >= self.radius), f"follower.arm: {CANNOT}")
        refusals.add(lost, f"follower.pivot_distance: {CANNOT}")
        if given is not None:
            refusals.add(np.abs(given - self.arm) > 0.9 * self.radius, f"follower.pivot_distance: {CANNOT}")

    @property
    def heights(self) -> tuple[Floats, Floats]:
        """Of the arm's end."""
        low, high = self.swing
        least, most = self._cosines(low - 0.5 * np.pi, high - 0.5 * np.pi)
        return self.arm * (least - np.sin(self.start)), self.arm * (most - np.sin(self.start))

    @property
    def aside(self) -> Floats:
        """At an end of the swing, or where the arm stands across."""
        low, high = self.swing
        ends = [self.pivot - self.long * one for way in self.ways
                for one in self._cosines(low + way * self.ahead, high + way * self.ahead)]  # fmt: skip
        return np.asarray(np.max(np.abs(np.broadcast_arrays(*ends)), axis=0))

    # Geometry

    def _at(self, points: Points, way: float) -> Arm:
        """The roller that pushes up, 1, or down, -1, of a rib, or that of a groove, 0."""
        return self.once(way, points, lambda: self._carried(points, way))

    def _carried(self, points: Points, way: float) -> Arm:
        beta = points.s + (self.start + way * self.ahead)
        up, aside = np.cos(beta), np.sin(beta)
        up *= self.long
        aside *= self.long
        dy, dz, y = aside * points.ds, up * points.ds, self.pivot - up
        bent, ddz = aside * points.dds, up * points.dds
        bent += dz * points.ds
        bent += y
        bent *= dz
        bent *= self.sense
        ddz -= dy * points.ds
        return Arm(up, aside, y, dy, dz, bent, ddz)

    def _away(self, arm: Arm, place: Floats) -> tuple[Floats, Floats]:
        """rho and W², mm and mm², at a place along the roller."""
        rho = place - self.sense * arm.dy
        return rho, rho * rho + arm.dz * arm.dz

    def _tangent(self, axis: bool, place: Floats, way: float, points: Points) -> Floats:
        """Tangent of the pressure angle at the axis, or on the wall where it is larger."""
        arm = self._at(points, way)
        size = place * arm.aside
        size -= (self.sense * self.long * self.long) * points.ds
        if not axis:
            turned = self.roller * np.sqrt(self._away(arm, place)[1])
            size = np.abs(size) + turned if way == 0.0 else size - way * turned
        return np.asarray(np.abs(size) / (place * np.abs(arm.up)))

    def _largest(self, axis: bool, *places: Callable[[Swung], Floats]) -> Floats:
        """Largest pressure angle, deg, at places along the roller: both are convex functions of 1 / delta, so that
        they are largest at an end of it."""
        def tangent(way: float, drums: Swung, place: Floats, points: Points) -> Floats:
            return drums._tangent(axis, place, way, points)

        found = []
        for way in self.ways:
            what = partial(tangent, way)
            samples = [self.motion.spread(partial(what, self.rough, place(self.rough)), rough=True) for place in places]
            at = np.stack(np.broadcast_arrays(*(place(self) for place in places)))
            found.append(self.over(what, at, np.stack(samples), self.motion))
        return np.asarray(np.degrees(np.arctan(np.max(found, axis=0))))

    @cached_property
    def steepest(self) -> Floats:
        """At either end of the roller."""
        return self._largest(False, lambda drums: drums.low, lambda drums: drums.radius)

    @cached_property
    def steepest_axis(self) -> Floats:
        """At either end of the roller."""
        return self._largest(True, lambda drums: drums.low, lambda drums: drums.radius)

    @property
    def steepest_quoted(self) -> Floats:
        """At that place of the roller."""
        return self._largest(False, lambda drums: drums.pitch)

    def _bends(self, points: Points, way: float, place: Floats) -> tuple[Floats, Floats]:
        """-2H of the wall that pushes up, 1/mm, and M²/D, 1/mm²; of a groove the larger of both walls, of a rib's lower
        roller that of its own."""
        arm = self._at(points, way)
        rho, square = self._away(arm, place)
        bend = rho * arm.ddz
        bend += arm.bent
        bend /= square * np.sqrt(square)
        turned = arm.dz / square
        turned *= turned
        return np.abs(bend) if way == 0.0 else way * bend, turned

    def _folding(self, way: float, place: Floats, points: Points) -> Floats:
        """r k of the pitch surface towards the wall, k its larger curvature."""
        bend, turned = self._bends(points, way, place)
        bend = bend if way == 0.0 else -bend
        turned *= 4.0
        turned += bend * bend
        root = np.sqrt(turned, out=turned)
        root += bend
        root *= 0.5 * self.cutter
        return root

    def _effective_radius(self, sign: float, way: float, place: Floats, points: Points) -> Floats:
        """Relative radius times sign, mm: of a groove on the wall where it is larger, 1, or where it is less, -1."""
        bend, turned = self._bends(points, way, place)
        turned *= self.roller * self.roller
        bend *= self.roller * (sign if way == 0.0 else 1.0)
        bend += 1.0
        bend -= turned
        turned += 1.0
        bend /= turned
        bend *= sign * self.roller
        return bend

    def _worst(self, what: Callable[[Swung, float, Floats, Points], Floats], low: Floats) -> Floats:
        """Largest of a quantity over the turn, all walls and the stations from `low` to the land, (n,)."""
        def of_way(way: float, drums: Swung, place: Floats, points: Points) -> Floats:
            return what(drums, way, place, points)

        each = [self._worst_of(partial(of_way, way), low, way) for way in self.ways]
        return np.asarray(np.max(each, axis=0))

    def _worst_of(self, what: Callable[[Swung, Floats, Points], Floats], low: Floats, way: float) -> Floats:
        radii, steeps = low + (self.radius - low) * np.linspace(0.0, 1.0, STATIONS)[:, None], False
        rough, (first, *others) = self.rough, (single(one) for one in radii[[0, STATIONS // 2, -1]])

        def worst(points: Points) -> Floats:
            nonlocal steeps
            values, arm = what(rough, first, points), rough._at(points, way)
            # The others matter on steep flanks alone.
            rows = np.flatnonzero((np.abs(arm.dz) > STEEP * (first - self.sense * arm.dy)).any(axis=1))
            if rows.size:
                steeps, steep = True, points.of(rows)
                values[rows] = np.max([values[rows], *(what(rough, one, steep) for one in others)], axis=0)
            return values

        values = self.motion.spread(worst, rough=True)
        return self.over(what, radii if steeps else radii[[0, -1]], values, self.motion)

    @cached_property
    def margin(self) -> Floats:
        """From the tool's end up, of a rib from the drum beside it."""
        if not self.rib:
            return np.asarray(1.0 - self._worst(Swung._folding, self.floor))

        def folding(share: float, way: float, drums: Swung, points: Points) -> Floats:
            return drums._rib_folding(share, way, points)

        folds = [self.largest(partial(folding, *one), self.motion) for one in product((0.0, 0.5, 1.0), self.ways)]
        return np.asarray(1.0 - np.max(folds, axis=0))

    def _rib_folding(self, share: float, way: float, points: Points) -> Floats:
        """The same as `_folding` at a share of a rib's wall from its foot up."""
        foot = self._under(self.floor, self.cutter, self._at(points, way), way)
        return self._folding(way, foot + share * (self.radius - foot), points)

    def widest(self, sign: float) -> Floats:
        """On the wall where it is larger, 1, or where it is less, -1."""
        return self._worst(lambda drums, *at: drums._effective_radius(sign, *at), self.low)

    @property
    def run_out(self) -> Floats:
        """Where the follower turns round: there the contact stands straight above or below the roller."""
        number = self.variants.number
        pivot = number("cam.start") - self.arm * np.sin(self.start)

        def least(way: float, side: float, points: Points) -> Floats:
            arm = self._at(points, way)
            rho, square = self._away(arm, self.low)
            height = (pivot + arm.aside) - side * self.roller * rho / np.sqrt(square)
            return np.minimum(height, number("cam.length") - height)

        walls = [(way, side) for way in self.ways for side in ((way,) if way else (1.0, -1.0))]
        return np.asarray(np.min([self.motion.smallest(partial(least, *wall)) for wall in walls], axis=0))

    @property
    def thickness(self) -> Floats:
        """Sought from the place where the other roller stands beside."""
        places = [(radius, way) for radius in (self.radius, self.floor) for way in self.ways]
        return np.asarray(np.min([self.motion.smallest(partial(self._thick, *place)) for place in places], axis=0))

    def _thick(self, radius: Floats, way: float, points: Points) -> Floats:
        """Distance, mm, of the wall of the upper, 1, or lower, -1, roller from the other one where that is nearest."""
        arm = self._at(points, way)
        place = self._under(radius, self.cutter, arm, way)
        rho, square = self._away(arm, place)
        far = self.cutter / np.sqrt(square)
        beside = arm.y - way * self.sense * arm.dz * far
        # The point's azimuth in the cam's frame, its height from the pivot.
        angle = np.arctan2(beside, place) - self.sense * points.theta
        height = arm.aside - way * far * rho
        at = points.theta + np.arctan2(2.0 * way * (self.half + self.roller) * rho * arm.dz / square, place)

        def gap(at: Floats) -> tuple[Arm, Floats, Floats, Floats]:
            """The other roller at cam angles, and the point from it: across, its derivative, and along the drum."""
            other = self._carried(self.motion.whenever(at), -way)
            turned = angle + self.sense * at
            return other, radius * np.sin(turned) - other.y, self.sense * radius * np.cos(turned), height - other.aside

        for _ in range(ROUNDS):
            other, across, rate, up = gap(at)
            # of half the square of the distance
            bow = np.where(other.dz == 0.0, other.y, self.sense * other.bent / other.dz)
            slope = across * (rate - other.dy) - up * other.dz
            bend = (rate - other.dy) ** 2 - across * (across + bow) + other.dz**2 - up * other.ddz
            at = at - np.clip(slope / np.maximum(np.abs(bend), LEAST), -0.1, 0.1)
        other, across, _, up = gap(at)
        return np.asarray(np.hypot(across, up) - self.cutter)

    # Load and contact

    @property
    def jams(self) -> NDArray[np.bool_]:
        """An arm has no guides."""
        return np.zeros(1, dtype=bool)

    def pushed(self, points: Points, force: Floats) -> Floats:
        """An arm has no guides."""
        return force

    def normal(self, points: Points, way: float, force: Floats, place: Floats) -> Floats:
        """By the lever there."""
        arm = self._at(points, way)
        return np.asarray(force * np.sqrt(self._away(arm, place)[1]) / (place * np.abs(arm.up)))

    def lever2(self, points: Points, way: float, place: Floats) -> Floats:
        """See the head of this file."""
        arm = self._at(points, way)
        size = place * arm.up
        return np.asarray(size * size / self._away(arm, place)[1])

    def wall(self, points: Points, way: float, up: Floats, place: Floats) -> tuple[Floats, Floats]:
        """See the head of this file."""
        arm = self._at(points, way)
        rho, square = self._away(arm, place)
        q = 1.0 / square
        root = np.sqrt(q)
        bend = rho * arm.ddz
        bend += arm.bent
        bend *= q
        bend *= root
        bend *= up
        q *= self.roller * arm.dz
        q *= q
        root *= place
        root *= np.abs(arm.up)
        return root, self.across(bend, q)

    def reach(self, points: Points, way: float, up: Floats) -> Floats:
        """Up to where the contact line leaves the drum through the land."""
        return self._under(self.radius, self.roller, self._at(points, way), up if way == 0.0 else way) - self.low

    def _under(self, radius: Floats, roller: Floats, arm: Arm, up: Floats | float) -> Floats:
        """Place on a roller's axis, mm, of the contact that lies so far from the drum's axis on the wall that pushes
        up, 1, or down, -1."""
        outer, turn = radius * radius, (roller * self.sense) * up * arm.dz
        beside = arm.y - turn / np.sqrt(self._away(arm, radius)[1])
        # As if the normal were alike all along the roller, then by Newton's steps.
        place = np.sqrt(np.maximum(outer - beside * beside, LEAST_SHARE * outer))
        for _ in range(FOOT):
            rho, square = self._away(arm, place)
            root = 1.0 / np.sqrt(square)
            beside = arm.y - turn * root
            over = place * place + beside * beside - outer
            place = place - 0.5 * over / (place + beside * turn * rho * root / square)
        return np.asarray(place)
