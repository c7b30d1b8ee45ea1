"""Cross-sections of a drum's rib: a layer round its contour, the core within, and the drum below.

      r = radius           +--------+           contour: from the lower foot up the flank, over the top and down
                           | .----. | layer
                           | |core| |
      r = base   +---------+-+----+-+---------+
                 |  lower  |  middle |  upper |
      r = bore   +---------+--------+---------+
               z = 0                        length
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self, final

import numpy as np
import numpy.typing as npt

from camgeom.body.groove import at_azimuths, bore_radius, left_out
from camgeom.body.section import graded
from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.solid.drum import RibbedCylinder, height_above, on_cylinder
from camgeom.track import TURN
from camgeom.track.column import Column, cylinder_level
from camgeom.track.flank import Flank

Index = npt.NDArray[np.int64]
GROWTH = 1.4
"""of a cell up the flank over the one below"""
FINEST = 10
"""most cells up a flank"""
AROUND = 720
"""cam angles at which the foot's thickness is asked"""
LAYER = 0.2
"""share of the rib's thickness and height that the layer takes on each side"""


@final
@immutable
class RibSection:
    """The section of the rib and its drum; cells up a flank, over the top, across the layer, below, to an end."""

    body: RibbedCylinder
    cells: tuple[int, int, int, int, int] = (4, 2, 1, 3, 3)

    @classmethod
    def of(cls, body: RibbedCylinder) -> Self:
        """As many cells up a flank as make the one on the foot no higher than the rib is thick there at its thinnest,
        beyond which the bending stress came out a fifth low."""
        at, foot = np.linspace(0.0, TURN, AROUND, endpoint=False), np.zeros(1)
        lower, upper = (
            body.wall(Column(track, at), side, foot)[:, :, 0]
            for track, side in zip((body.lower, body.upper), body.sides)
        )
        thick, high = float(height_above(lower, upper).min()), body.radius - body.base
        few, over, deep, below, aside = cls.cells
        enough = (n for n in range(few, FINEST) if high * graded(n, GROWTH)[2] <= thick)
        return cls(body, (next(enough, FINEST), over, deep, below, aside))

    @cached_property
    def rows(self) -> Floats:
        """Bands: 0 to 1 up the lower flank, to 2 over the top, to 3 down the upper flank."""
        up = graded(self.cells[0], GROWTH)
        return np.concatenate([up[:-1], 1.0 + graded(self.cells[1], 1.0)[:-1], 3.0 - up[::-1]])

    @cached_property
    def foot_cells(self) -> tuple[tuple[int, tuple[float, float, float], float], ...]:
        """Quadrilaterals above the foot from the lower flank to the upper one: number, natural places across, and along
        the flank."""
        up, over, deep, _, _ = self.cells
        along = 2 * up + over
        lower = [(i * along, (-1.0, 0.0, 1.0), -1.0) for i in range(deep)]
        core = [(deep * along + i * up, (-1.0, 0.0, 1.0), -1.0) for i in range(over)]
        upper = [(i * along + along - 1, (1.0, 0.0, -1.0), 1.0) for i in reversed(range(deep))]
        return (*lower, *core, *upper)

    @property
    def notes(self) -> tuple[str, ...]:
        """The keyway is left out."""
        return left_out(self.body.blank.bore)

    def at(self, phi: Floats, row: Floats) -> Floats:
        """Points (3, n) of the rib's surface at cam angles (n,) and rows (n,)."""
        body, (low, high) = self.body, self.body.sides
        lower, upper = Column(body.lower, phi), Column(body.upper, phi)
        rising = body.wall(lower, low, np.clip(row, 0.0, 1.0)[:, None])[:, :, 0]
        falling = body.wall(upper, high, np.clip(3.0 - row, 0.0, 1.0)[:, None])[:, :, 0]
        top = on_cylinder(rising, falling, body.radius, np.clip(row - 1.0, 0.0, 1.0)[:, None])[:, :, 0]
        return np.asarray(np.where(row <= 1.0, rising, np.where(row >= 2.0, falling, top)))

    def blocks(self, psi: Floats) -> list[tuple[Floats, Floats]]:
        """z and r (n, i, j) of layer, core, middle, lower and upper; i runs into the rib in the layer and along z
        elsewhere, j along the contour in the layer and out in the others.

        Raises DesignError where the rib has no material at its foot.
        """
        body, (up, _, deep, below, aside) = self.body, self.cells
        rows = np.tile(self.rows, (len(psi), 1))
        x = at_azimuths(self.at, body.lower.sense, psi, rows)
        z, r = x[2].reshape(rows.shape), np.hypot(x[0], x[1]).reshape(rows.shape)
        left, top = slice(2 * up + 1), slice(2 * up, len(self.rows) - 2 * up)
        if float((z[:, ::-1][:, left] - z[:, left]).min()) <= 0.0:
            raise DesignError("the rib leaves no wall: the volume is not meshed")
        middle = 0.5 * (z + z[:, ::-1])
        oz, or_ = middle + (1.0 - 2.0 * LAYER) * (z - middle), body.base + (1.0 - LAYER) * (r - body.base)
        for line in (oz, or_):
            # Inside the body edges are straight.
            line[:, 1::2] = 0.5 * (line[:, :-2:2] + line[:, 2::2])
        depth = graded(deep, 1.5)[None, :, None]
        layer = z[:, None] + depth * (oz - z)[:, None], r[:, None] + depth * (or_ - r)[:, None]
        part = (oz[:, top] - oz[:, top][:, :1]) / (oz[:, top][:, -1:] - oz[:, top][:, :1])
        core = [line[:, None, left] + part[:, :, None] * (line[:, None, ::-1][:, :, left] - line[:, None, left])
                for line in (oz, or_)]  # fmt: skip
        foot = np.concatenate([layer[0][:, :-1, 0], core[0][:, :-1, 0], layer[0][:, ::-1, -1]], axis=1)
        inner = bore_radius(body.blank.bore)
        down = inner + (body.base - inner) * (1.0 - graded(below, 1.6)[::-1])

        def straight(lines: Floats) -> tuple[Floats, Floats]:
            shape = (*lines.shape, len(down))
            return np.broadcast_to(lines[:, :, None], shape), np.broadcast_to(down, shape)

        out = graded(aside, 1.6)
        lower = straight(foot[:, :1] * (1.0 - out[::-1]))
        upper = straight(foot[:, -1:] + (body.length - foot[:, -1:]) * out)
        return [layer, (core[0], core[1]), straight(foot), lower, upper]

    def sets(self, grids: Sequence[Index]) -> dict[str, list[Index]]:
        """Nodes on the faces of the body."""
        layer, _, middle, lower, upper = grids
        contour, edge = layer[0], 2 * self.cells[0]
        return {
            "bore": [middle[:, 0], lower[:, 0], upper[:, 0]],
            "flank_lower": [contour[: edge + 1]],
            "land": [contour[edge : len(contour) - edge]],
            "flank_upper": [contour[len(contour) - edge - 1 :]],
            "base": [lower[:, -1], upper[:, -1]],
            "end_lower": [lower[0]],
            "end_upper": [upper[-1]],
        }

    def second(self, side: float) -> bool:
        """Whether a side is the upper flank."""
        return side == self.body.sides[1]

    def word(self, side: float) -> str:
        """The flank in words."""
        return "the rib's upper flank" if self.second(side) else "the rib's lower flank"

    def place(self, theta: float, side: float, t: Floats) -> tuple[Floats, Floats, Floats]:
        """Row, azimuth and normals of what touches."""
        body, second, at = self.body, self.second(side), np.array([theta])
        track = body.upper if second else body.lower
        column = Column(track, at)
        foot, top = (float(column.reach(side, cylinder_level(r), r)[0, 0]) for r in (body.base, body.radius))
        share = np.clip((t - foot) / (top - foot), 0.0, 1.0)
        flank = Flank(track, at, t, side)
        x = flank.x[:, 0]
        return 3.0 - share if second else share, np.arctan2(x[1], x[0]), flank.n[:, 0]

    def thickness(self, theta: Floats, side: float, t: float) -> Floats:
        """Of the rib, mm, at cam angles (n,): from where one roller touches at station t to where the other does, along
        the flank's normal."""
        lower, upper = (
            Flank(track, theta, np.array([t]), own) for track, own in zip((self.body.lower, self.body.upper),
                                                                           self.body.sides)
        )
        mine, other = (upper, lower) if self.second(side) else (lower, upper)
        return np.asarray(np.abs(((other.x - mine.x) * mine.n).sum(axis=0)[:, 0]))
