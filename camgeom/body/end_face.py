"""Cross-sections of an end-face cam: a ring whose upper end is the flank, on a web with the bore.

      r = outer        +-----------+  contour: from the outer edge of the end face to the inner one
                       | base|core|layer
      r = inner        +-----+-----+
                       | web |
      r = bore         +-----+
                     z = 0   web
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.body.groove import at_azimuths, bore_radius, left_out
from camgeom.body.section import graded
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.solid.drum import EndFaceRing
from camgeom.track.column import Column, cylinder_level
from camgeom.track.flank import Flank

Index = npt.NDArray[np.int64]
LAYER = 0.3
"""share of the height from web to flank that the graded layer takes"""


@final
@immutable
class EndFaceSection:
    """The section of the ring; cells across the flank, the layer, from there to the web, the web, and along it."""

    body: EndFaceRing
    cells: tuple[int, int, int, int, int] = (4, 3, 2, 2, 3)

    @cached_property
    def rows(self) -> Floats:
        """Shares of the way from the outer edge to the inner one."""
        return np.linspace(0.0, 1.0, 2 * self.cells[0] + 1)

    @property
    def foot_cells(self) -> Index:
        """Quadrilaterals just above the web, from the outer edge to the inner one."""
        across, deep, core, _, _ = self.cells
        return (deep + core - 1) * across + np.arange(across)

    @property
    def notes(self) -> tuple[str, ...]:
        """The keyway is left out."""
        return left_out(self.body.blank.bore)

    def _edges(self, column: Column) -> tuple[Floats, Floats]:
        """Stations (n, 1) of the outer edge and the inner one."""
        (side,) = self.body.track.sides
        outer, inner = (column.reach(side, cylinder_level(r), r) for r in (self.body.outer, self.body.inner))
        return outer, inner

    def at(self, phi: Floats, row: Floats) -> Floats:
        """Points (3, n) of the end face at cam angles (n,) and shares (n,)."""
        column, (side,) = Column(self.body.track, phi), self.body.track.sides
        outer, inner = self._edges(column)
        return column.wall(side, outer + (inner - outer) * row[:, None])[:, :, 0]

    def blocks(self, psi: Floats) -> list[tuple[Floats, Floats]]:
        """z and r (n, i, j) of layer, core, base and web; i runs down, j inward, in the web the other way round."""
        body, (_, deep, core, base, along) = self.body, self.cells
        rows = np.tile(self.rows, (len(psi), 1))
        x = at_azimuths(self.at, body.track.sense, psi, rows)
        z, r = x[2].reshape(rows.shape), np.hypot(x[0], x[1]).reshape(rows.shape)
        foot = z - LAYER * (z - body.web)
        down, web = np.broadcast_to(body.web, z.shape), np.broadcast_to(0.0, z.shape)
        parts = ((z, foot, graded(deep, 1.6)), (foot, down, graded(core, 1.0)), (down, web, graded(base, 1.0)))
        blocks = []
        for high, low, share in parts:
            height = high[:, None] + share[None, :, None] * (low - high)[:, None]
            blocks.append((height, np.repeat(r[:, None], len(share), axis=1)))
        inner = blocks[-1][0][:, :, -1:]
        to_bore = r[:, None, -1:] + graded(along, 1.0) * (bore_radius(body.blank.bore) - r[:, None, -1:])
        blocks.append((np.repeat(inner, to_bore.shape[2], axis=2), np.repeat(to_bore, inner.shape[1], axis=1)))
        return blocks

    def sets(self, grids: Sequence[Index]) -> dict[str, list[Index]]:
        """Nodes on the faces of the ring."""
        layer, core, base, web = grids
        return {
            "bore": [web[:, -1]],
            "flank": [layer[0]],
            "land": [layer[:, 0], core[:, 0], base[:, 0]],
            "inside": [layer[:, -1], core[:, -1]],
            "web": [web[0]],
            "end_lower": [base[-1], web[-1]],
        }

    def second(self, side: float) -> bool:
        """There is one flank alone."""
        del side
        return False

    def word(self, side: float) -> str:
        """The flank in words."""
        del side
        return "the end face"

    def place(self, theta: float, side: float, t: Floats) -> tuple[Floats, Floats, Floats]:
        """Share, azimuth and normals of what touches."""
        outer, inner = (float(edge[0, 0]) for edge in self._edges(Column(self.body.track, np.array([theta]))))
        flank = Flank(self.body.track, np.array([theta]), t, side)
        x = flank.x[:, 0]
        return np.clip((t - outer) / (inner - outer), 0.0, 1.0), np.arctan2(x[1], x[0]), flank.n[:, 0]

    def thickness(self, theta: Floats, side: float, t: float) -> Floats:
        """Height of the ring, mm, square to the flank."""
        flank = Flank(self.body.track, theta, np.array([t]), side)
        return np.asarray(flank.x[2, :, 0] * np.abs(flank.n[2, :, 0]))
