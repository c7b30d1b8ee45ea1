"""Surveys: the largest and least values of what is asked of a cam's contacts, refined beyond the samples.

A contact is one flank of a roller, sampled at stations along it, or a planar cam's touch. Whatever is asked of it, its
extreme lies between two samples: it is refined on the exact surface, between the knots of the motion.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from typing import Protocol, TypeVar, final

import numpy as np
import numpy.typing as npt

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme, piece_grid, refined_maximum
from camgeom.maths.frozen import cached_property
from camgeom.track import Straight, Track
from camgeom.track.column import Column, Level
from camgeom.track.flank import Flank
from camgeom.track.runout import Within, touching

PER_TURN = 720
STATIONS = 9
HAIR = 1e-9
"""share of what is left of a contact line by which stations lie within an end at which it runs out"""
TIED = 1e-13
"""share by which an extreme has to surpass that of another contact to stand in its place"""
FLANKS = {"flank +": 1.0, "flank -": -1.0}
"""sides of a track by the name that an extreme's `where` has"""

Grid = tuple[Floats, npt.NDArray[np.int64]]
"""Cam angles (n,), rad, one-sided at every knot, and the piece of the motion each belongs to."""
T = TypeVar("T", covariant=True)
S = TypeVar("S")


class SurveyedContact(Protocol[T]):
    """One contact of the cam, which can be asked at any cam angle."""

    @property
    def where(self) -> str:
        """Its name."""

    @property
    def grid(self) -> Grid:
        """Where it is sampled."""

    @property
    def sampled(self) -> T:
        """The contact at the samples, with values (n,) or, at all its stations, (n, m)."""

    def at(self, phi: Floats, station: int) -> T:
        """The contact at one of its stations, with values (n,) or (n, 1)."""

    def place(self, phi: float, station: int) -> float:
        """Where along the follower a station is, mm."""


def largest(
    contacts: Iterable[SurveyedContact[S]], what: Callable[[S], Floats], refine: bool = True, grain: float = 0.0
) -> Extreme:
    """The largest value of a quantity over all contacts, stations and cam angles.

    grain   share by which values beside a kink differ for no reason
    refine  False: of the samples alone, for what means something only beside the other stations
    """
    best: Extreme | None = None
    # All sampled first: what does not reach the best sample of another one need not be refined.
    tried = []
    for contact in contacts:
        sampled = what(contact.sampled).reshape(len(contact.grid[0]), -1)
        station = int(np.argmax(sampled.max(axis=0)))
        tried.append((contact, station, sampled[:, station]))
    most = max(float(values.max()) for _, _, values in tried)
    for contact, station, values in tried:
        phi, owner = contact.grid
        if refine:

            def exact(x: Floats, contact: SurveyedContact[S] = contact, station: int = station) -> Floats:
                return what(contact.at(x, station)).reshape(len(x))

            value, angle = refined_maximum(exact, phi, owner, values, grain=grain, least=most)
        else:
            value, angle = float(values.max()), float(phi[int(np.argmax(values))])
        # Mirrored flanks have the same extreme: the first one's, not the one that rounding puts ahead.
        if best is None or value - best.value > max(TIED, grain) * abs(value):
            best = Extreme(value, angle, contact.place(angle, station), contact.where)
    assert best is not None
    return best


def smallest(contacts: Iterable[SurveyedContact[S]], what: Callable[[S], Floats], grain: float = 0.0) -> Extreme:
    """The smallest value of a quantity over all contacts, stations and cam angles."""
    low = largest(contacts, lambda at: -what(at), grain=grain)
    return replace(low, value=-low.value)


def _alike(track: Track) -> bool:
    """Whether all stations of a flank are alike: of a cylinder that stays along Z, as in a planar cam."""
    return track.upright and isinstance(track.meridian, Straight) and track.meridian.slope == 0.0


@final
@immutable
class FlankContact:
    """One flank of a track, at stations t (m,) along the roller, or (n, m) as a function of the cam angles (n,)."""

    track: Track
    side: float
    grid: Grid
    stations: Floats | Callable[[Floats], Floats]

    @property
    def where(self) -> str:
        """Its name."""
        return next(name for name, side in FLANKS.items() if side == self.side)

    @cached_property
    def sampled(self) -> Flank:
        """The flank at the samples, at all stations."""
        return Flank(self.track, self.grid[0], self._stations(self.grid[0]), self.side)

    def at(self, phi: Floats, station: int) -> Flank:
        """The flank at one station."""
        return Flank(self.track, phi, self._stations(phi)[..., station : station + 1], self.side)

    def place(self, phi: float, station: int) -> float:
        """delta of a station, mm."""
        t = self._stations(np.array([phi])).reshape(-1)[station : station + 1]
        return float(self.track.meridian.jet(t)[0][0])

    def _stations(self, phi: Floats) -> Floats:
        return self.stations(phi) if callable(self.stations) else self.stations


@final
@immutable
class Survey:
    """One track sampled over its span, or one way out of a cam that slides, on both flanks (or the sides it works on).

    track   the roller itself: its contact stretch is what pressure angle and relative curvature are asked on
    cutter  the tool that cuts: its wall, from the tip to the end of the contact, is what undercut is asked on
    foot    the surface at which that wall ends where it does not reach down to the tool's tip, and a delta near it
    within   how deep contact points (3, ...) lie on the cam, where rollers come and go: none beside it counts, and
            stations lie over what is left of a contact line that runs out of the cam
    mouth   the surface at which the wall begins where that is not the end of the contact, and a delta near it
    """

    track: Track
    cutter: Track
    foot: tuple[Level, float] | None = None
    within: Within | None = None
    mouth: tuple[Level, float] | None = None

    @cached_property
    def _grid(self) -> Grid:
        return piece_grid(self.track.once_knots(), PER_TURN)

    @cached_property
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
        """Meridian stations (m,) over the whole cut wall, from its foot to the end of the contact."""
        return self._wall(self.cutter.foot)

    def _wall(self, foot: float) -> Floats:
        parameter = self.cutter.meridian.parameter
        ends = sorted((parameter(foot), *(parameter(d) for d in self.cutter.contact)))
        low, high = ends[0], ends[-1]
        inset = 1e-3 * (high - low)
        if abs(abs(low) - 0.5 * np.pi) < 1e-6 and self.cutter.meridian.jet(np.array([low]))[3][0] < 1e-6:
            low += inset
        if abs(abs(high) - 0.5 * np.pi) < 1e-6 and self.cutter.meridian.jet(np.array([high]))[3][0] < 1e-6:
            high -= inset
        return np.linspace(low, high, STATIONS)

    def flank(self, side: float) -> Flank:
        """The sampled flank over the contact stretch, (n, m)."""
        return next(contact.sampled for contact in self._whole if contact.side == side)

    @cached_property
    def contacts(self) -> tuple[FlankContact, ...]:
        """The flanks over the contact stretch, as far as it is on the cam."""
        if self.within is None:
            return self._over(self.stations[:1]) if _alike(self.track) else self._whole
        track, grid = self.track, self._grid
        return tuple(FlankContact(track, side, grid, partial(self._left, track, side)) for side in track.sides)

    @property
    def _grain(self) -> float:
        """Share by which what is asked beside an end of the wall hangs on HAIR."""
        return 0.1 * HAIR if self.within is not None else 0.0

    @cached_property
    def _whole(self) -> tuple[FlankContact, ...]:
        return self._over(self.stations)

    def _over(self, stations: Floats) -> tuple[FlankContact, ...]:
        return tuple(FlankContact(self.track, side, self._grid, stations) for side in self.track.sides)

    def _left(self, track: Track, side: float, phi: Floats) -> Floats:
        """Stations (n, m) over what is left at each angle of the contact line of the roller, or of the tool."""
        assert self.within is not None
        first, last = sorted(track.meridian.parameter(d) for d in track.contact)
        low, high = touching(track, side, phi, self.within)
        # By a hair within: where it runs out rounding may put a point off the cam.
        hair = HAIR * (high - low)
        low, high = np.where(low > first, low + hair, low), np.where(high < last, high - hair, high)
        return np.asarray(low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, STATIONS))

    def _counted(self, what: Callable[[Flank], Floats], beyond: float) -> Callable[[Flank], Floats]:
        """The quantity where the contact is on the cam, `beyond` (never the extreme) where it is not."""
        within = self.within
        if within is None:
            return what
        return lambda flank: np.where(within(flank.x) >= 0.0, what(flank), beyond)

    @cached_property
    def pressure_angle(self) -> Extreme:
        """Largest pressure angle over the contact stretch, rad."""
        return largest(self.contacts, self._counted(lambda flank: flank.pressure_angle(), -np.inf), grain=self._grain)

    @cached_property
    def axis_pressure_angle(self) -> Extreme:
        """Largest pressure angle taken at the roller axis, rad."""
        return largest(
            self.contacts, self._counted(lambda flank: flank.pressure_angle("axis"), -np.inf), grain=self._grain
        )

    def pressure_angle_at(self, delta: float) -> Extreme:
        """Largest pressure angle at one place along the roller, rad."""
        t = np.array([self.track.meridian.parameter(delta)])
        return largest(self._over(t), self._counted(lambda flank: flank.pressure_angle(), -np.inf), grain=self._grain)

    @cached_property
    def relative_curvature(self) -> Extreme:
        """Smallest relative curvature of cam against roller over the contact stretch, 1/mm."""
        return smallest(self.contacts, self._counted(lambda flank: flank.k_rel, np.inf), grain=self._grain)

    @cached_property
    def largest_relative_curvature(self) -> Extreme:
        """Largest relative curvature over the contact stretch, 1/mm: the sharpest contact."""
        return largest(self.contacts, self._counted(lambda flank: flank.k_rel, -np.inf), grain=self._grain)

    @cached_property
    def margin(self) -> Extreme:
        """Smallest undercut margin 1 - r k over the cut wall, down to the tool's end."""
        plain = self.foot is None and not Column(self.cutter, np.zeros(1)).ball_ended
        # A rounded tool lies within the sharp one: where that one leaves no fold, its root has none.
        walls = (FlankContact(self.cutter, side, self._grid, self._cut(side, plain)) for side in self.cutter.sides)
        return smallest(walls, self._counted(lambda flank: flank.margin, np.inf), grain=self._grain)

    def _cut(self, side: float, plain: bool) -> Floats | Callable[[Floats], Floats]:
        """Stations over the cut wall; plain: it goes down to the tool's tip."""
        cutter = self.cutter
        if not plain:
            return partial(self._footed, side)
        wall = self._wall(cutter.tip)
        if self.within is None:
            return wall[:1] if _alike(cutter) else wall
        low, high = cutter.meridian.jet(wall[[0, -1]])[0].tolist()
        return partial(self._left, replace(cutter, contact=(low, high)), side)

    def _footed(self, side: float, phi: Floats) -> Floats:
        """Stations (n, m) over a wall whose foot is at another place of the roller at each angle.

        A wall may end on a surface; that of a ball ends where the two sides meet, short of the pole.
        """
        cutter = self.cutter
        column = Column(cutter, phi)
        end = cutter.meridian.parameter(max(cutter.contact, key=lambda d: abs(d - cutter.tip)))
        top = np.full((len(phi), 1), end) if self.mouth is None else column.reach(side, *self.mouth)
        low = column.bottom_t() if self.foot is None else column.reach(side, *self.foot)
        return np.asarray(low + (top - low) * np.linspace(0.0 if self.foot else 1e-3, 1.0, STATIONS))

    @cached_property
    def sliding(self) -> Extreme:
        """Largest sliding along the contact line of a roller that rolls purely at its middle, mm per rad."""
        return largest(self.contacts, self._counted(lambda flank: np.hypot(*flank.sliding()), -np.inf), refine=False)
