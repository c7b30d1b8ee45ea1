"""A survey of a flank: refined extremes of pressure angle, curvature, undercut margin and sliding."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats
from camgeom.maths.extremum import piece_grid, refined_maximum
from camgeom.track import Track
from camgeom.track.flank import Flank
from camgeom.track.section import Column, Level

PER_TURN = 720
STATIONS = 9


@dataclass(frozen=True)
class Extreme:
    """An extreme value with its cam angle (rad), its place along the roller (delta, mm) and its flank (+1 or -1)."""

    value: float
    cam_angle: float
    delta: float
    side: float


@dataclass(frozen=True, eq=False)
class Survey:
    """One track sampled over its span on both flanks (or the sides it works on).

    track   the roller itself: its contact stretch is what pressure angle and relative curvature are asked on
    cutter  the tool that cuts: its wall, from the tip to the end of the contact, is what undercut is asked on
    foot    the surface at which that wall ends where it does not reach down to the tool's tip, and a delta near it
    """

    track: Track
    cutter: Track
    foot: tuple[Level, float] | None = None

    @cached_property
    def _grid(self) -> tuple[Floats, npt.NDArray[np.int64]]:
        return piece_grid(self.track.knots(), PER_TURN)

    @property
    def phi(self) -> Floats:
        """Sampled cam angles (n,), rad, one-sided at every knot."""
        return self._grid[0]

    @cached_property
    def stations(self) -> Floats:
        """Meridian stations (m,) over the contact stretch."""
        low, high = (self.track.meridian.parameter(d) for d in self.track.contact)
        return np.linspace(low, high, STATIONS)

    @cached_property
    def wall(self) -> Floats:
        """Meridian stations (m,) over the whole cut wall, from the tool's tip to the end of the contact."""
        parameter = self.cutter.meridian.parameter
        ends = sorted((parameter(self.cutter.tip), *(parameter(d) for d in self.cutter.contact)))
        low, high = ends[0], ends[-1]
        inset = 1e-3 * (high - low)
        if abs(abs(low) - 0.5 * np.pi) < 1e-6 and self.cutter.meridian.jet(np.array([low]))[3][0] < 1e-6:
            low += inset
        if abs(abs(high) - 0.5 * np.pi) < 1e-6 and self.cutter.meridian.jet(np.array([high]))[3][0] < 1e-6:
            high -= inset
        return np.linspace(low, high, STATIONS)

    def flank(self, side: float) -> Flank:
        """The sampled flank over the contact stretch, (n, m)."""
        return self._flanks[side]

    @cached_property
    def _flanks(self) -> dict[float, Flank]:
        return {side: Flank(self.track, self.phi, self.stations, side) for side in self.track.sides}

    @cached_property
    def pressure_angle(self) -> Extreme:
        """Largest pressure angle over the contact stretch, rad."""
        return self._extreme(self.track, self.stations, lambda f: f.pressure_angle(), 1.0)

    @cached_property
    def axis_pressure_angle(self) -> Extreme:
        """Largest pressure angle taken at the roller axis, rad."""
        return self._extreme(self.track, self.stations, lambda f: f.pressure_angle("axis"), 1.0)

    def pressure_angle_at(self, delta: float) -> Extreme:
        """Largest pressure angle at one place along the roller, rad."""
        t = np.array([self.track.meridian.parameter(delta)])
        return self._extreme(self.track, t, lambda f: f.pressure_angle(), 1.0)

    @cached_property
    def relative_curvature(self) -> Extreme:
        """Smallest relative curvature of cam against roller over the contact stretch, 1/mm."""
        return self._extreme(self.track, self.stations, lambda f: f.k_rel, -1.0)

    @cached_property
    def largest_relative_curvature(self) -> Extreme:
        """Largest relative curvature over the contact stretch, 1/mm: the sharpest contact."""
        return self._extreme(self.track, self.stations, lambda f: f.k_rel, 1.0)

    @cached_property
    def margin(self) -> Extreme:
        """Smallest undercut margin 1 - r k over the cut wall."""
        if self.foot is None and not Column(self.cutter, np.zeros(1)).ball_ended:
            return self._extreme(self.cutter, self.wall, lambda f: f.margin, -1.0)
        return min((self._footed_margin(side) for side in self.cutter.sides), key=lambda e: e.value)

    def _footed_margin(self, side: float) -> Extreme:
        """The same on one side of a wall whose foot is at another place of the roller at each angle.

        A wall may end on a surface; that of a ball ends where the two sides meet, short of the pole.
        """
        cutter, (phi, owner) = self.cutter, self._grid
        top = cutter.meridian.parameter(max(cutter.contact, key=lambda d: abs(d - cutter.tip)))

        def stations(x: Floats, share: Floats) -> Floats:
            column = Column(cutter, x)
            low = column.bottom_t() if self.foot is None else column.reach(side, *self.foot)
            return np.asarray(low + (top - low) * share)

        share = np.linspace(0.0 if self.foot else 1e-3, 1.0, STATIONS)
        sampled = -Flank(cutter, phi, stations(phi, share), side).margin
        column = int(np.argmax(sampled.max(axis=0)))
        own = share[column : column + 1]
        value, angle = refined_maximum(
            lambda x: -Flank(cutter, x, stations(x, own), side).margin[:, 0], phi, owner, sampled[:, column]
        )
        t = stations(np.array([angle]), own)
        return Extreme(-value, angle, float(cutter.meridian.jet(t)[0][0, 0]), side)

    @cached_property
    def sliding(self) -> Extreme:
        """Largest sliding along the contact line of a roller that rolls purely at its middle, mm per rad."""

        def speed(flank: Flank) -> Floats:
            round_it, along = flank.sliding()
            return np.asarray(np.hypot(round_it, along))

        return self._extreme(self.track, self.stations, speed, 1.0, refine=False)

    def _extreme(
        self, track: Track, stations: Floats, what: Callable[[Flank], Floats], sign: float, refine: bool = True
    ) -> Extreme:
        phi, owner = self._grid
        best: Extreme | None = None
        for side in track.sides:
            sampled = sign * what(self._sampled(track, stations, side))
            column = int(np.argmax(sampled.max(axis=0)))
            t = stations[column : column + 1]

            def along(x: Floats, t: Floats = t, side: float = side) -> Floats:
                return np.asarray(sign * what(Flank(track, x, t, side))[:, 0])

            values = sampled[:, column]
            if refine:
                value, angle = refined_maximum(along, phi, owner, values)
            else:
                value, angle = float(values.max()), float(phi[int(np.argmax(values))])
            if best is None or value > sign * best.value:
                delta = float(track.meridian.jet(t)[0][0])
                best = Extreme(sign * value, angle, delta, side)
        assert best is not None
        return best

    def _sampled(self, track: Track, stations: Floats, side: float) -> Flank:
        if track is self.track and stations is self.stations:
            return self._flanks[side]
        return Flank(track, self.phi, stations, side)
