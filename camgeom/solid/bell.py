"""A ring on a web with a closed groove in its inside, meshed directly as one structured grid; thicknesses of its walls.

      r = outer   +-----------------------------+
                  |            +-----+ r = floor|
      r = inner   +-------+----+     +----------+
                  |  web  |      groove
      r = bore    +-------+
                z = 0    web                  length
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.sampling import sample
from camgeom.solid import QuickPart, Solid, eased
from camgeom.solid.blank import Blank, Wall
from camgeom.solid.drum import (
    WALL_SAMPLES,
    WEB_DEPTHS,
    GroovedCylinder,
    closed_body,
    ends_walls,
    facing,
    height_above,
    on_cylinder,
    refuse_turned,
    thinnest_web,
    wall_between,
)
from camgeom.track import TURN, Track
from camgeom.track.column import Column

NAMES = ("land", "end", "inside", "flank", "floor", "flank", "inside")
"""of the bands, from the lower end up the outside, over the upper end, and down the inside to the web"""


@immutable
class GroovedRing(QuickPart):
    """A ring from radius `inner` to `outer`, 0 <= z <= length, on a web 0 <= z <= web, with a groove in its inside.

    floor  radius of the groove's floor, a cylinder about the axis, mm
    """

    name: str
    track: Track
    blank: Blank
    inner: float
    outer: float
    floor: float
    length: float
    web: float

    @property
    def sides(self) -> tuple[float, float]:
        """Sides (+1 or -1) of the roller's lower flank and of its upper one."""
        return facing(self.track, -1.0), facing(self.track, 1.0)

    def wall(self, column: Column, side: float, share: Floats) -> Floats:
        """Points (3, n, k) of a flank at shares (k,) or (n, k) of the way from the ring's inside to the floor."""
        return wall_between(column, side, (self.inner, self.floor), share)

    def rim(self, edge: Floats) -> Floats:
        """Points (3, ...) of the outside at the upper end, at the azimuths of points (3, ...) of an edge."""
        away = self.outer / np.sqrt(edge[0] * edge[0] + edge[1] * edge[1])
        return np.stack([edge[0] * away, edge[1] * away, np.full_like(away, self.length)])

    def solid(self, tolerance: float, free: float | None = None) -> Solid:
        """Mesh directly. Raises DesignError where an edge turns back, or the groove leaves the ring or crosses itself.
        """
        low_side, high_side = self.sides

        def rows(phi: Floats, counts: tuple[int, ...]) -> Floats:
            column = Column(self.track, phi)
            down = self.wall(column, high_side, np.arange(counts[3] + 1) / counts[3])
            up = self.wall(column, low_side, np.arange(counts[5] + 1) / counts[5])[:, :, ::-1]
            floor = on_cylinder(down[:, :, -1], up[:, :, 0], self.floor, np.arange(1, counts[4]) / counts[4])
            above = GroovedCylinder.land(down[:, :, 0], self.length, counts[2])
            rim, share = self.rim(down[:, :, 0]), np.arange(counts[1]) / counts[1]
            end = rim[:, :, None] + (above[:, :, 0] - rim)[:, :, None] * share
            outside = GroovedCylinder.land(rim, 0.0, counts[0])
            below = GroovedCylinder.land(up[:, :, -1], self.web, counts[6])[:, :, ::-1]
            return np.concatenate([outside, end, above, down, floor, up, below], axis=2)

        grid = sample(rows, self.track.knots(), tolerance, (1, 1, 1, 4000, 4000, 4000, 1),
                      eased(NAMES, tolerance, free))  # fmt: skip
        ends = np.cumsum(grid.counts)
        self.check([grid.points[:, :, k] for k in ends[2:6]])
        inward = self.track.sense > 0
        return closed_body(self.name, grid, NAMES, inward, (0.0, self.web), self.blank, tolerance, free)

    def check(self, edges: Sequence[Floats]) -> None:
        """DesignError where the edges (3, n), from the upper mouth over the floor to the lower mouth, leave the ring,
        turn back, or cross."""
        if min(edge[2].min() for edge in edges) <= self.web or max(edge[2].max() for edge in edges) >= self.length:
            raise DesignError("the groove runs out of the ring's upper end or into its web; a longer ring, or `start`")
        refuse_turned(edges, "groove's")
        for lower, upper, where in ((3, 0, "mouth"), (2, 1, "floor")):
            if height_above(edges[lower], edges[upper]).min() <= 0.0:
                raise DesignError(f"the groove's flanks cross at its {where}: the flank is undercut")


def bell_walls(ring: GroovedRing) -> list[Wall]:
    """Walls of a ring with a groove in its inside: behind the floor, to the web and the upper end, between passes."""
    phi = np.linspace(0.0, TURN, WALL_SAMPLES, endpoint=False)
    column, track = Column(ring.track, phi), ring.track
    shares = np.linspace(0.0, 1.0, WEB_DEPTHS)
    z = np.concatenate([np.moveaxis(ring.wall(column, side, shares)[2], 1, 0) for side in ring.sides])
    return [
        Wall("outside to groove floor", ring.outer - ring.floor, None, "a shallower groove or a larger cam.diameter"),
        *ends_walls(track, phi, z, ring.web, ring.length, "web"),
        *thinnest_web(track, phi, ring.inner),
    ]
