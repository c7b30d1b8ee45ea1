"""The blank of a globoidal cam: a body of revolution, its outside an arc about the turret axis, with hubs and bore."""

from __future__ import annotations

from dataclasses import dataclass
from math import asin, atan2, hypot, pi, sqrt

import numpy as np
import numpy.typing as npt

from camgeom.errors import Problem
from camgeom.maths import Floats
from camgeom.solid.blank import Blank, Bore


@dataclass(frozen=True)
class Globoid:
    """Blank -width/2 <= z <= width/2, mm.

    centre  distance of the turret axis from the cam axis; radius: of the outside about the turret axis
    hub_diameter, hub_length  of hubs beyond both end faces, 0 for none
    """

    centre: float
    width: float
    radius: float
    bore: Bore | None = None
    hub_diameter: float = 0.0
    hub_length: float = 0.0

    @property
    def end_radius(self) -> float:
        """Radius at the end faces (its largest), mm."""
        return self.centre - sqrt(self.radius**2 - 0.25 * self.width**2)

    def blank(self) -> Blank:
        """The body of revolution."""
        half, end, arc = 0.5 * self.width, self.end_radius, (self.centre, 0.0)
        if not self.hub_length:
            return Blank(((end, -half), (end, half)), self.bore, (arc,), ("land",))
        hub, far = 0.5 * self.hub_diameter, half + self.hub_length
        outline = ((hub, -far), (hub, -half), (end, -half), (end, half), (hub, half), (hub, far))
        return Blank(outline, self.bore, (None, None, arc, None, None), ("hub", "end", "land", "end", "hub"))

    def inside(self, x: Floats) -> npt.NDArray[np.bool_]:
        """Whether points (3, ...) of the cam frame lie within the globoid."""
        rho = np.hypot(x[0], x[1])
        within = np.hypot(rho - self.centre, x[2]) >= self.radius - 1e-9
        return np.asarray(within & (np.abs(x[2]) <= 0.5 * self.width + 1e-9))

    def hub_problems(self, reach: float) -> list[Problem]:
        """What is wrong with the hubs beside rollers whose ends reach so far from the turret axis, mm."""
        if bool(self.hub_diameter) != bool(self.hub_length):
            limit = "diameter and length both, or neither"
            return [Problem("cam.hub_length", "cannot be built", self.hub_length, limit)]
        if not self.hub_length:
            return []
        least = 2.0 * self.bore.reach if self.bore else 0.0
        most = 2.0 * (self.centre - sqrt(max(0.0, reach**2 - 0.25 * self.width**2)))
        if least < self.hub_diameter < most:
            return []
        limit = f"{least:g} .. {most:g} mm, outside the bore and clear of the rollers"
        return [Problem("cam.hub_diameter", "cannot be built", self.hub_diameter, limit)]

    def clear_angle(self, low: float, radius: float) -> float:
        """Turret angle (rad) from the line of centres beyond which a tool of a radius is clear of the blank.

        low  distance of the tool's inner end from the turret axis, mm
        """
        size = hypot(low, radius)
        if 0.5 * self.width < size:
            angle = asin(0.5 * self.width / size) + atan2(radius, low)
            if angle < 0.5 * pi:
                return 1.02 * angle + 0.01
        return 0.5 * pi
