"""The grooves of an indexing cam side by side on shared knots, and the rims of the lands between them.

Round an indexing cam the grooves of the turret's rollers lie side by side, with lands of the blank's outside between
them: at one cam angle the section of groove k, the land up to groove k + 1, its section and so on. One turn on, each
groove stands where one some places further on stood, so that all turns fit together where their knots do. Grooves are
carried on beyond the blank's ends, where the finished surface is cut off.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats
from camgeom.maths.rounds import TURN, Strip, angles, columns_over, middle_angles, strip_sags
from camgeom.maths.sag import Cells, Counts
from camgeom.solid.lands import Land
from camgeom.solid.turret_lands import NotOneSurface
from camgeom.track import Track
from camgeom.track.section import Column

Index = npt.NDArray[np.int64]


class Section(Protocol):
    """Cross-section of a groove whose two outer rows lie on the land's surface."""

    @property
    def track(self) -> Track:
        """The track of the groove."""

    @property
    def names(self) -> tuple[str, ...]:
        """Face-group names of its bands."""

    @property
    def max_counts(self) -> Counts:
        """Most cells across each band."""

    def rows(self, column: Column, counts: Counts) -> Floats:
        """Points (3, n, 1 + sum(counts))."""


@dataclass(frozen=True)
class Between:
    """A land, from the groove below it (in w) to the one above, whose columns stand `offset` rounds on.

    Either is None where there is no groove, only the end of the cam.
    """

    lower: int | None
    upper: int | None
    offset: int


@dataclass(frozen=True, eq=False)
class TurretSurface:
    """Grooves and lands of an indexing cam between two heights, mm; sections in order of their tracks' shift."""

    sections: tuple[Section, ...]
    land: Land
    low: float
    high: float

    @property
    def names(self) -> tuple[str, ...]:
        """Face-group names of the bands of a groove."""
        return self.sections[0].names

    @property
    def most(self) -> Counts:
        """Most cells across each band of a groove, and across a land while knots are chosen."""
        return (*self.sections[0].max_counts, 1)

    @property
    def sense(self) -> float:
        """Turning of the cam."""
        return self.sections[0].track.sense

    @property
    def closed(self) -> bool:
        """True where every groove closes on itself after one turn."""
        return self.sections[0].track.closed

    @cached_property
    def _middle(self) -> tuple[float, float]:
        """psi + sense * phi of a groove's middle, and the sign of the step in w from its first row to its last."""
        track = self.sections[0].track
        phi = 0.5 * (track.span[0] + track.span[1])
        rows = self.sections[0].rows(Column(track, np.array([phi])), (1,) * len(self.names))[:, 0]
        centre, w = rows.mean(axis=1), self.land.along(rows)
        return float(np.arctan2(centre[1], centre[0]) + self.sense * phi), float(np.sign(w[-1] - w[0]))

    @cached_property
    def lands(self) -> tuple[Between, ...]:
        """The lands, each between two grooves. Raises NotOneSurface where the tracks are not those of one turret."""
        tracks = [section.track for section in self.sections]
        first, count = tracks[0], len(tracks)
        gain = first.factor * first.program.advance
        shifts = [t.shift for t in tracks]
        pitch = np.diff(shifts) if self.closed else np.diff([*shifts, shifts[0] + abs(gain)])
        if not all(_alike(first, t) for t in tracks) or (len(pitch) and (pitch.min() <= 0.0 or np.ptp(pitch) > 1e-9)):
            raise NotOneSurface("the tracks are not those of one turret")
        order = list(range(count)) if self._rising > 0.0 else list(range(count))[::-1]
        inner = [Between(a, b, 0) for a, b in zip(order[:-1], order[1:])]
        if self.closed:
            return (Between(None, order[0], 0), *inner, Between(order[-1], None, 0))
        return (*inner, Between(order[-1], order[0], 1 if gain * self._rising > 0.0 else -1))

    @property
    def _rising(self) -> float:
        """+1 where w grows with the turret's angle, else -1."""
        track = self.sections[0].track
        at = np.array(track.anchor) + np.mean(track.contact) * np.array(track.axis)
        return float(np.sign(track.joint.velocity(at[:, None], np.ones(1, dtype=complex))[2, 0]))

    @cached_property
    def ends(self) -> tuple[float, float]:
        """w at the cam's two ends."""
        return self.land.at_height(self.low), self.land.at_height(self.high)

    def strips(self, theta: Floats, counts: Counts) -> list[Strip]:
        """The grooves, then of each one both edges unrolled, as a strip for the sag of the lands along them."""
        bands, found = tuple(range(len(counts))), []
        for section in self.sections:
            first, last = columns_over(theta, *section.track.span)
            phi = angles(theta, np.arange(first, last + 1))
            found.append(Strip(first, bands[:-1], section.rows(Column(section.track, phi), counts[:-1])))
        for strip in found[: len(self.sections)]:
            edges = [self.unrolled(strip, row, theta) for row in (0, -1)]
            corner = np.stack([np.stack([x, w, w]) for x, w in edges], axis=2)
            found.append(Strip(strip.first, bands[-1:], corner))
        return found

    def sags(self, theta: Floats, counts: Counts, strips: list[Strip], chosen: list[Index]) -> list[Cells]:
        """Grooves as measured; of the lands the chords along both edges of each groove."""
        doubled, found, grooves = tuple(2 * c for c in counts[:-1]), [], len(self.sections)
        for section, strip, at in zip(self.sections, strips, chosen):
            phi = middle_angles(theta, strip.first + at)
            found.append(strip_sags(strip, at, section.rows(Column(section.track, phi), doubled), self.low, self.high))
        for strip, at in zip(strips[grooves:], chosen[grooves:]):
            start, stop = strip.corner[:, at], strip.corner[:, at + 1]
            on = (np.minimum(start[1], stop[1]) < self.ends[1]) & (np.maximum(start[1], stop[1]) > self.ends[0])
            sag = on * self.land.sag(stop[0] - start[0], stop[1] - start[1], 0.5 * (start[1] + stop[1]))
            a = 8.0 * sag.max(axis=1)[:, None]
            found.append(Cells(a, np.zeros_like(a), np.zeros_like(a)))
        return found

    def unrolled(self, strip: Strip, row: int, theta: Floats) -> tuple[Floats, Floats]:
        """x (n,) and w of a row of a groove: x = phi - sense psi, psi the polar angle from the groove's middle."""
        centre, _ = self._middle
        points, phi = strip.corner[:, :, row], angles(theta, strip.first + np.arange(strip.cells + 1))
        psi = np.arctan2(points[1], points[0]) + self.sense * phi
        return phi - self.sense * ((psi - centre + np.pi) % TURN - np.pi), self.land.along(points)

    def points(self, x: Floats, w: Floats) -> Floats:
        """Points (3, ...) on the land at unrolled x and w."""
        return self.land.points(self._middle[0] - self.sense * x, w)

    def rim(
        self, strip: Strip, upper: bool, theta: Floats, offset: int = 0, share: float = 0.0, counts: Counts = (1, 1)
    ) -> tuple[int, Floats, Floats]:
        """Row number, x and w of one side of a groove at a share of its depth (counts: cells of its bands).

        upper  the side with the greater w; offset: rounds by which the groove stands ahead
        """
        last = upper == (self._middle[1] > 0.0)
        row = -1 - round(share * counts[-1]) if last else round(share * counts[0])
        x, w = self.unrolled(strip, row, theta)
        return row, x - TURN * offset, w

    @property
    def outward(self) -> tuple[bool, bool]:
        """Whether faces turning from columns to rows of a groove, and from x to w, look outward."""
        return self.sense * self._middle[1] < 0.0, self.sense < 0.0

    def check(self, theta: Floats, grooves: list[Strip], counts: Counts) -> None:
        """Raise NotOneSurface unless rims keep their order all round, at several depths: no two grooves touch."""
        for share in (0.0, 0.5, 1.0):
            for between in self.lands:
                if between.lower is None or between.upper is None:
                    continue
                low = self.rim(grooves[between.lower], True, theta, 0, share, counts)
                high = self.rim(grooves[between.upper], False, theta, between.offset, share, counts)
                self._ordered(low, high)
            for strip in grooves if share < 1.0 else ():
                rims = [self.rim(strip, upper, theta, 0, share, counts) for upper in (False, True)]
                self._ordered(rims[0], rims[1])

    def _ordered(self, low: tuple[int, Floats, Floats], high: tuple[int, Floats, Floats]) -> None:
        """Raise NotOneSurface where, within the cam, a rim turns back in x or the lower is not below the upper."""
        for _, x, w in (low, high):
            on = (np.minimum(w[1:], w[:-1]) < self.ends[1]) & (np.maximum(w[1:], w[:-1]) > self.ends[0])
            if np.any(np.diff(x)[on] <= 0.0):
                raise NotOneSurface("a groove's edge turns back")
        for (_, x, w), (_, other_x, other_w), sign in ((low, high, 1.0), (high, low, -1.0)):
            on = (w < self.ends[1]) & (w > self.ends[0]) & (x > other_x[0]) & (x < other_x[-1])
            if np.any(on) and float((sign * (np.interp(x[on], other_x, other_w) - w[on])).min()) <= 0.0:
                raise NotOneSurface("two grooves touch")


def _alike(a: Track, b: Track) -> bool:
    """True where two tracks differ by their shift and span only."""
    same = ("meridian", "joint", "anchor", "axis", "tip", "sense", "factor", "closed", "relief")
    return a.program is b.program and all(getattr(a, k) == getattr(b, k) for k in same)
