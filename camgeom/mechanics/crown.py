"""A crown on a straight flank: the ellipse in which a roller touches, as long as its wall leaves it room.

Units N, mm, MPa, rad; arrays on the panels (p, n) of the roller's force.
"""

from __future__ import annotations

from math import sin
from typing import final

import numpy as np

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme
from camgeom.maths.frozen import cached_property
from camgeom.maths.panels import highest
from camgeom.mechanics.contact import Contact
from camgeom.mechanics.hertz import CrownedContact, crowned_contact, point_contact, point_depths
from camgeom.mechanics.material import Material
from camgeom.mechanics.pressing import Pressing

OUTSIDE = 10.0
"""times a panel's largest squared pressure, below zero, at which the square outside of its ellipses is cut"""
NEXT_TO_NONE = 1e-6
"""share of the roller's length with which its crown is taken to touch where its crest stands beyond the wall"""


@final
@immutable
class Crown:
    """The crown of a roller: radius of its meridian, mm; tilt of its axis against the flank, rad, see `Ends`."""

    pressing: Pressing
    radius: float
    tilt: float

    @cached_property
    def crest(self) -> Floats:
        """Where a crown touches along the axis (delta), mm, (p, n): a tilt moves it, exactly, by its radius."""
        moved = self.radius * sin(self.tilt)
        return self.pressing.middle + np.where(self.pressing.normal >= 0.0, moved, -moved)

    @cached_property
    def ellipse(self) -> CrownedContact:
        """The contact on the panels, (p, n)."""
        across, along = self.principal
        return crowned_contact(np.abs(self.pressing.normal), along, across, self.pressing.pair, *self.sides)

    @cached_property
    def sides(self) -> tuple[Floats, Floats]:
        """Lengths of wall on either side of the crown's crest, mm, (p, n); hardly any where the crest has none."""
        low, high = self.pressing.stretch
        least = NEXT_TO_NONE * self.pressing.length
        return np.maximum(self.crest - low, least), np.maximum(high - self.crest, least)

    @cached_property
    def room(self) -> Floats:
        """The shorter of them, mm, (p, n)."""
        return np.minimum(*self.sides)

    @cached_property
    def filled(self) -> Floats:
        """Share of it that half of the ellipse's length fills where a force presses, (p, n); above 1 an end bears."""
        return np.where(self.pressing.bears, self.ellipse.along / self.room, 0.0)

    @cached_property
    def fullest(self) -> Extreme:
        """The largest such share over the turn."""
        share, angle = highest(self.pressing.force.panels, self.filled)
        return Extreme(float(share), float(angle))

    @cached_property
    def longest(self) -> float:
        """The largest half of an ellipse's length over the turn, mm."""
        return float(highest(self.pressing.force.panels, self.ellipse.along)[0])

    @property
    def at_fullest(self) -> tuple[float, float]:
        """Half of the ellipse's length there and its room, mm; no room where the crown touches beside the wall."""
        both = np.stack([self.ellipse.along, self.room])
        along, room = self.pressing.force.panels.limit(both, self.fullest.cam_angle, self.filled)
        return float(along), float(room) if room > NEXT_TO_NONE * self.pressing.length else 0.0

    @cached_property
    def principal(self) -> tuple[Floats, Floats]:
        """Principal relative curvatures under the crown, across the roller and along it, 1/mm, (p, n) each.

        The cylinder that cut the flank is curved against it across their line of contact alone, by k; the crown adds
        its own curvature c along the axis, which stands at the angle psi to that line: they are the roots of
        x² - (k + c) x + k c cos² psi.
        """
        k, c = self.pressing.curvature, 1.0 / self.radius
        half = 0.5 * (k + c)
        root = np.sqrt(np.maximum(half * half - k * c * self.pressing.alignment, 0.0))
        return np.where(k >= c, half + root, half - root), np.where(k >= c, half - root, half + root)

    def contact(self, place: Floats) -> Contact:
        """Contact at places (..., p, n) along the roller, mm from where its crown touches.

        p² = p0² (1 - place² / along²), and p0 / along does not hang on the load: p² is smooth across its edge,
        negative outside. A force that comes and goes on a panel must not make it jump: without force the panel's
        steepest ellipse counts, and what is far outside of all its ellipses is cut.
        """
        ellipse = self.ellipse
        slope = np.divide(ellipse.pressure, ellipse.along, out=np.zeros_like(ellipse.along), where=ellipse.along > 0.0)
        slope = np.where(ellipse.along > 0.0, slope, slope.max(axis=-1, keepdims=True))
        square = ellipse.pressure**2 - (slope * place) ** 2
        square = np.maximum(square, -OUTSIDE * np.max(ellipse.pressure**2, axis=-1, keepdims=True))
        square = np.where(self.pressing.as_line.sound, square, 0.0)
        width = np.divide(ellipse.around, ellipse.pressure, out=np.zeros_like(slope), where=ellipse.pressure > 0.0)
        load = 0.5 * np.pi * width * np.maximum(square, 0.0) * np.sign(self.pressing.normal)
        return self.pressing.rated(square, load)

    @cached_property
    def approach(self) -> Floats:
        """Of roller and cam under the crown's ellipse, mm, (p, n)."""
        across, along = self.principal
        return point_contact(np.abs(self.pressing.normal), along, across, self.pressing.pair).approach

    def depths(self, cam: Material) -> Floats:
        """Depth of the largest shear below the contact, mm, (p, n)."""
        long, short = (of(self.ellipse.along, self.ellipse.around) for of in (np.maximum, np.minimum))
        return np.asarray(
            short * point_depths(np.divide(short, long, out=np.ones_like(short), where=long > 0.0), cam)
        )

    def pressure_at(self, theta: Floats, delta: Floats, wall: int) -> Floats:
        """Largest pressure across, MPa, (k, j); see `RollerDuty.pressure_at`."""
        press, panels = self.pressing, self.pressing.force.panels
        force = panels.at(press.normal, theta)[:, None]
        bears = force != 0.0 if wall == 0 else wall * force > 0.0
        top, along, crest = (
            panels.at(each, theta)[:, None] for each in (self.ellipse.pressure, self.ellipse.along, self.crest)
        )
        low, high = sorted(press.track.contact)
        off = (delta - crest) / np.where(along > 0.0, along, NEXT_TO_NONE * press.length)
        here = bears & (delta >= low - 1e-9) & (delta <= high + 1e-9)
        return np.where(here, top * np.sqrt(np.maximum(1.0 - np.square(off), 0.0)), 0.0)

    @property
    def pressed_places(self) -> tuple[float, float]:
        """Between which places along the roller axis (delta), mm, it is pressed over the turn."""
        low, high = sorted(self.pressing.track.contact)
        return max(low, float(self.crest.min()) - self.longest), min(high, float(self.crest.max()) + self.longest)
