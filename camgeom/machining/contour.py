"""Tool paths round the profile of a planar cam: the parallel curve at the tool's radius, never into the profile."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.errors import DesignError
from camgeom.machining.path import Positions
from camgeom.maths.extremum import piece_grid, refined_maximum
from camgeom.outline import Outline, ParallelOutline
from camgeom.outline_crossing import crossing
from camgeom.track import TURN

Floats = npt.NDArray[np.float64]

PER_TURN = 1440


@final
@dataclass(frozen=True, eq=False)
class ContourPath:
    """A tool with its axis along Z round an outline.

    material  +1 where the material is inside the outline, -1 outside
    reach     mm, from the tool's axis to the outline: its radius and the stock
    low       mm, height of the tool's end
    height    mm, of the tool in the cut
    room      mm, how far the tool may move off the outline; None: as far as one likes
    other     a second outline that the tool touches at the same time, on its other side
    """

    name: str
    outline: Outline
    material: float
    reach: float
    low: float
    height: float
    room: float | None = None
    start: float = 0.0
    other: Outline | None = None

    @property
    def closed(self) -> bool:
        """A profile always is."""
        return True

    def knots(self) -> Floats:
        """Cam angles between which it is smooth."""
        knots = self.outline.knots()
        begin = self.start % TURN
        if begin == 0.0:
            return knots
        shifted = np.concatenate([knots, knots[1:] + TURN])
        inside = shifted[(shifted > begin + 1e-12) & (shifted < begin + TURN - 1e-12)]
        return np.concatenate([[begin], inside, [begin + TURN]])

    def at(self, phi: Floats) -> Positions:
        """Positions at cam angles (n,)."""
        phi = np.asarray(phi, dtype=float)
        curve = self.outline.curve(phi)
        zero, one = np.zeros_like(phi), np.ones_like(phi)
        normal = -self.material * curve.normals
        tip = curve.points - self.reach * normal
        way = np.sign(curve.speed) * np.stack([-curve.normals[1], curve.normals[0]])
        axis = np.stack([zero, zero, one])
        middle = np.full_like(phi, self.low + 0.5 * self.height)
        contacts, into = [np.stack([*curve.points, middle])], [np.stack([*normal, zero])]
        if self.other is not None:
            far = self.other.curve(phi)
            contacts.append(np.stack([*far.points, middle]))
            into.append(np.stack([*(self.material * far.normals), zero]))
        ends, travel = np.stack([*tip, np.full_like(phi, self.low)]), np.stack([*way, zero])
        return Positions(phi, ends, axis, np.stack(contacts), np.stack(into), travel, axis)

    def refuse_gouge(self) -> None:
        """Raise DesignError where the tool is too large for a hollow, or its path crosses itself."""
        phi, owner = piece_grid(self.outline.knots(), PER_TURN)

        def hollow(x: Floats) -> Floats:
            return np.asarray(-self.material * self.outline.curve(x).curvature)

        sharpest, at = refined_maximum(hollow, phi, owner, hollow(phi))
        if sharpest * self.reach >= 1.0:
            raise DesignError(
                f"{self.name}: a tool of {2.0 * self.reach:.6g} mm (with its stock) does not go into the hollow at cam "
                f"angle {degrees(at) % 360.0:.6g} deg; at most {2.0 / sharpest:.6g} mm"
            )
        met = crossing(ParallelOutline(self.outline, self.material * self.reach))
        if met is not None:
            raise DesignError(
                f"{self.name}: a tool of {2.0 * self.reach:.6g} mm (with its stock) at cam angle "
                f"{degrees(met.first) % 360.0:.6g} deg cuts into the profile at {degrees(met.second) % 360.0:.6g} deg; "
                "use a smaller one"
            )

    def largest_diameter(self) -> float | None:
        """Largest tool that goes into every hollow, mm; None where there is no hollow."""
        phi, owner = piece_grid(self.outline.knots(), PER_TURN)

        def hollow(x: Floats) -> Floats:
            return np.asarray(-self.material * self.outline.curve(x).curvature)

        sharpest = refined_maximum(hollow, phi, owner, hollow(phi))[0]
        return 2.0 / sharpest if sharpest > 0.0 else None

    def distance(self, centres: Floats) -> float:
        """Least distance, mm, of points (2, n) from the outline, by its samples."""
        phi, _ = piece_grid(self.outline.knots(), 4 * PER_TURN)
        points = self.outline.curve(phi).points
        return float(min(np.hypot(*(points - c[:, None])).min() for c in centres.T))
