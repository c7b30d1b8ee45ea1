"""Finite contact of a turret's rollers: their ends, tilt and crown, on the load that each has of the torque.

All rollers are alike. What each bears, and how far its approach differs along it, is told by the sharing of the slices
(`stiffness`), whose gaps are those of crown, run-out and tilt: the turret turns about its own axis, so that the outer
end of a roller is pressed in further. Under that load and slope the contact is solved on a half-space where it is
hardest, and tabled over load, curvature and the slope that the load gives for the rest, within 5 % down to a fifth of
the load. Twist and the growth of the curvature along the roller are those where its wall is pressed hardest; a roller
that is beside the cam in part counts in the table with the load per length that it has, and its slope over that length.

Arrays: n cam angles, k rollers, m slices; wall 0 pushes the turret on (1 of `Ends.tilt`), wall 1 holds it back (-1).
Units N, mm, MPa, rad.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import inf
from typing import final

import numpy as np

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.contact import Stiffness
from camgeom.mechanics.finite_contact import AxialProfile, Bodies, PressurePatch
from camgeom.mechanics.finite_turn import PressureTable, bins, middles_of, refined, stiffness_of, surely, without_peak
from camgeom.mechanics.load import QUIET

CELLS = (32, 48, 80)
"""cells across and along, and strips, of a tabled contact: the rounding of a leaning roller's end asks for more"""
LEAST = 0.1
"""share of the mean curvature below which a fitted one does not fall within the roller"""


@final
@immutable
class WallLoad:
    """What presses one wall, (n, k, m) each.

    line_load N/mm; cover: length that has the wall, mm; place: its middle from that of the roller, mm; curvature:
    relative, 1/mm; approach: of roller and wall without crown, run-out and tilt, mm
    """

    line_load: Floats
    cover: Floats
    place: Floats
    curvature: Floats
    approach: Floats

    @cached_property
    def load(self) -> Floats:
        """Force on every roller, N, (n, k)."""
        return np.asarray((self.line_load * self.cover).sum(axis=2))

    @cached_property
    def share(self) -> Floats:
        """Of a whole roller's length that has the wall, (n, k)."""
        length = self.cover.sum(axis=2)
        return np.asarray(np.maximum(length / length.max(), 1e-9))

    @cached_property
    def even(self) -> Floats:
        """The force that a whole roller of this line load has, N, (n, k)."""
        return np.asarray(self.load / self.share)

    def _fitted(self, values: Floats, weight: Floats) -> tuple[Floats, Floats]:
        """Straight line through values along the roller: at its middle and its slope, (n, k), by least squares."""
        total = np.maximum(weight.sum(axis=2), 1e-300)
        centre, mean = ((weight * each).sum(axis=2) / total for each in (self.place, values))
        off = self.place - centre[..., None]
        square = (weight * off * off).sum(axis=2)
        slope = np.divide((weight * off * values).sum(axis=2), square, out=np.zeros_like(mean), where=square > 1e-12)
        return mean - slope * centre, slope

    @cached_property
    def slope(self) -> Floats:
        """Of the approach along the roller, 1, (n, k)."""
        return self._fitted(self.approach, self.cover)[1]

    @cached_property
    def bend(self) -> tuple[Floats, Floats]:
        """Curvature at the roller's middle, 1/mm, and its growth along it, 1/mm², (n, k), where it is not undercut."""
        there = self.cover * (self.curvature > 0.0)
        return self._fitted(np.where(self.curvature > 0.0, self.curvature, 0.0), there)

    def stretch(self, at: tuple[int, int]) -> tuple[float, float]:
        """Between which places a roller has the wall, mm from its middle."""
        on = self.cover[at] > 0.0
        half = 0.5 * self.cover[at][on]
        return float((self.place[at][on] - half).min()), float((self.place[at][on] + half).max())


@final
@immutable
class FiniteTurret:
    """Contact of all rollers over one turn with both walls.

    theta    cam angles, rad, (n,); middles of every roller along its axis (delta), mm, (k,)
    profile  of a roller beside the cam with all of its length
    pair, own   compliance of both bodies, 1/MPa, and the roller's share of it; mirror: see `Bodies`
    tilt     tangent of the roller's misalignment, see `Ends`
    twist    angle, rad, of the roller's axis to its line of contact with wall 0 or 1 at a place of the arrays
    """

    theta: Floats
    walls: tuple[WallLoad, WallLoad]
    middles: Floats
    profile: AxialProfile
    pair: float
    own: float
    mirror: float
    tilt: float
    twist: Callable[[int, tuple[int, int]], float]

    @property
    def _pressed(self) -> list[int]:
        """Numbers of the walls that anything presses."""
        most = max(float(wall.load.max(initial=0.0)) for wall in self.walls)
        return [w for w, wall in enumerate(self.walls) if wall.load.max(initial=0.0) > QUIET * most]

    def _own_tilt(self, w: int) -> float:
        """Of a roller against a wall without load."""
        return -self.tilt if w == 0 else self.tilt

    def bodies(self, w: int, at: tuple[int, int]) -> Bodies:
        """Of a roller at a sample point, as far as it is beside the cam."""
        wall = self.walls[w]
        low, high = wall.stretch(at)
        k, growth = (float(each[at]) for each in wall.bend)
        reach = max(abs(low - self.profile.end_radius), abs(high + self.profile.end_radius))
        steepest = (1.0 - LEAST) * k / reach
        gap = self._own_tilt(w) - float(wall.slope[at])
        profile = replace(self.profile, low=low, high=high)
        return Bodies(k, profile, self.pair, gap, self.twist(w, at), self.own, self.mirror,
                      float(np.clip(growth, -steepest, steepest)))  # fmt: skip

    def _harshest(self, w: int) -> tuple[int, int]:
        """Sample point and roller of the largest load times curvature."""
        wall = self.walls[w]
        n, k = np.unravel_index(int(np.argmax(wall.even * np.maximum(wall.bend[0], 0.0))), wall.load.shape)
        return int(n), int(k)

    @cached_property
    def edges(self) -> Floats:
        """Of the bins along the roller, mm from its middle."""
        return bins(self.profile)

    @cached_property
    def _tabled(self) -> tuple[Floats, ...]:
        """Pressure of every bin on either wall, MPa, (bins, n, k) each, from the table's coarser cells."""
        found = []
        for w, wall in enumerate(self.walls):
            if w not in self._pressed:
                found.append(np.zeros((len(self.edges) - 1, *wall.load.shape)))
                continue
            own = self._own_tilt(w)
            low, high = (wall.place + way * 0.5 * wall.cover for way in (-1.0, 1.0))
            on = wall.cover > 0.0
            first, last = np.where(on, low, inf).min(axis=2), np.where(on, high, -inf).max(axis=2)
            # A part of the roller that is never beside the cam under load bears nothing of what the table shares out.
            profile = replace(self.profile, low=max(self.profile.low, float(first[wall.load > 0.0].min())),
                              high=min(self.profile.high, float(last[wall.load > 0.0].max())))  # fmt: skip
            part = profile.length / float(wall.cover.sum(axis=2).max())
            bodies = replace(self.bodies(w, self._harshest(w)), profile=profile, tilt=own)
            load = np.where(wall.load > 0.0, wall.even * part, 0.0)
            k = np.where(wall.bend[0] > 0.0, wall.bend[0], bodies.curvature)
            # A shorter roller under the same load per length differs as much from one end to the other.
            tilt = (own - wall.slope) * wall.share / part
            lean = np.divide(tilt - own, load, out=np.zeros_like(tilt), where=load > 0.0)
            pressure = PressureTable(bodies, load, k, self.edges, lean, CELLS).pressures(load, k, lean)
            middle = middles_of(self.edges, self.profile)[:, None, None]
            hair = 1e-6 * self.profile.length
            beside = (middle >= first - hair) & (middle <= last + hair)
            # Where less of the roller is beside the cam, its wall ends as the roller does.
            beside[[0, -1]] = on.any(axis=2)
            pressure = np.where(beside, pressure, 0.0)
            self._on_edges(w, pressure, np.clip(0.0, first, last))
            found.append(pressure)
        return tuple(found)

    def _on_edges(self, w: int, pressure: Floats, nearest: Floats) -> None:
        """Give rollers that bear where the table has nothing the pressure (bins, n, k) of the most loaded of them.

        They touch the end of a wall that does not reach their middle, of which the table, made of whole rollers, knows
        nothing; nearest: the place of it that is nearest to the middle, mm, (n, k).
        """
        load = self.walls[w].load
        missed = np.where(pressure.max(axis=0) > 0.0, 0.0, load)
        n, k = (int(i) for i in np.unravel_index(int(np.argmax(missed)), missed.shape))
        if missed[n, k] > QUIET * load.max():
            peak = surely(refined(self.bodies(w, (n, k)), float(missed[n, k])))
            at = np.nonzero(missed)
            bins = np.clip(np.searchsorted(self.edges, nearest[at]) - 1, 0, len(pressure) - 1)
            pressure[(bins, *at)] = peak * np.cbrt(missed[at] / missed[n, k])

    @property
    def hardest(self) -> tuple[Extreme, PressurePatch]:
        """Where the table is hardest, or the load, and the contact solved there; an unbounded one before others."""
        return self._hardest[:2]

    @property
    def middle(self) -> float:
        """Of the hardest pressed roller along its axis (delta), mm."""
        return self._hardest[3]

    @cached_property
    def _hardest(self) -> tuple[Extreme, PressurePatch, float, float]:
        """That, by how much it is harder than the table says there, and the middle of that roller."""
        found: list[tuple[Extreme, PressurePatch, float, float]] = []
        for w in self._pressed:
            wall, tabled = self.walls[w], self._tabled[w].max(axis=0)
            for n, k in {tuple(int(i) for i in np.unravel_index(int(np.argmax(each)), each.shape))
                         for each in (tabled, wall.load)}:  # fmt: skip
                if wall.load[n, k] <= 0.0:  # the table tells of none
                    continue
                patch = refined(self.bodies(w, (n, k)), float(wall.load[n, k]))
                sure = surely(patch)
                middle = float(self.middles[k])
                extreme = Extreme(sure, float(self.theta[n]), middle + patch.peak[1])
                found.append((extreme, patch, sure / float(tabled[n, k]) if tabled[n, k] > 0.0 else 1.0, middle))
        sharp = [one for one in found if one[1].unbounded]
        return max(sharp or found, key=lambda one: one[0].value)

    @cached_property
    def most_loaded(self) -> PressurePatch | None:
        """The contact of the roller that bears the most; None without load."""
        loads = np.stack([wall.load for wall in self.walls])
        w, n, k = (int(i) for i in np.unravel_index(int(np.argmax(loads)), loads.shape))
        return refined(self.bodies(w, (n, k)), float(loads[w, n, k])) if loads[w, n, k] > 0.0 else None

    @cached_property
    def no_stress(self) -> str:
        """Why there is no largest pressure; empty where there is one."""
        return without_peak(self.hardest[1])

    @cached_property
    def stiffness(self) -> Stiffness:
        """Of the hardest contact, N/mm."""
        return stiffness_of(self.hardest[1])

    def pressure(self, places: Floats) -> Floats:
        """Largest pressure about places along the roller, mm from its middle, (m,), of both walls, MPa, (n, k, m).

        As hard as `hardest`, of a sharp end that bears inside of it; each bin counts for the place
        nearest to it, and for a place that has none the nearest bin.
        """
        peak, _, scale, _ = self._hardest
        tabled = np.minimum(scale * np.maximum(*self._tabled), peak.value)
        far = np.abs(middles_of(self.edges, self.profile)[:, None] - places)
        nearest = np.argmin(far, axis=1)
        out = np.empty((*tabled.shape[1:], len(places)))
        for m in range(len(places)):
            # Beside places as near to each other as those of graded slices a bin counts for several.
            near = nearest == m
            out[..., m] = tabled[near if near.any() else [int(np.argmin(far[:, m]))]].max(axis=0)
        return out

