"""Cross-sections of a grooved body, planar at one azimuth, in blocks of quadratic quadrilaterals graded to the root.

In the section's plane, with u across the groove and v out of it, the contour runs from the lower land's edge down
flank, root and floor and up the other flank. Round it lies a layer of cells whose rows are graded normal to the
contour; the rest is walls, a core below the floor and the two corners between them:

      u = ends[0]                              u = ends[1]
        +--------+--.                  .--+--------+  land
        | wall   |  | layer            |  |  wall  |
        |        |  '-- - - - - - - ---'  |        |
        +--------M----------- ------------M--------+
        | corner |          core          | corner |
        +--------+------------------------+--------+  v = back
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.body.groove import Groove, at_azimuths
from camgeom.errors import DesignError
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property

Index = npt.NDArray[np.int64]
LAYER = 1.6
"""thickness of the graded layer in root radii"""
ROUNDED = 0.06
"""share of a groove's depth by which a sharp root is rounded: no mesh has nodes of a sharp edge's stress"""
SHARE_OF_WALL = 0.4
"""of a wall's thickness that the layer takes at most"""
DENSE = 33
"""points of a root at which its length and turning are measured"""

@final
@dataclass(frozen=True)
class Fineness:
    """Cells of a section: along both flanks and roots (lower, upper), the floor, across layer, walls and core.

    growth  of the layer's cells from the contour outward
    """

    flank: tuple[int, int] = (3, 3)
    root: tuple[int, int] = (2, 2)
    floor: int = 2
    layer: int = 2
    wall: tuple[int, int] = (2, 2)
    core: int = 2
    growth: float = 2.0

    @classmethod
    def fine_at(cls, upper: bool, times: int = 1) -> Fineness:
        """Fine beside one flank alone."""
        def pair(this: int, other: int) -> tuple[int, int]:
            return (other, this) if upper else (this, other)

        return cls(pair(3 + times, 1), pair(4 + 2 * times, 2), 3, 2 + times, pair(3, 1), 2, 2.2)


@final
@dataclass(frozen=True, eq=False)
class GroovedSection:
    """The section of one grooved body in cells; arrays (n, k) are at azimuths (n,) and numbered contour places (k,).

    rounded  mm, the radius that a sharp root was given for the mesh; None where the body has its own
    """

    groove: Groove
    cells: Fineness
    rounded: float | None = None

    @classmethod
    def of(cls, groove: Groove, cells: Fineness) -> GroovedSection:
        """The section of a body, whose sharp root is rounded by a share of the groove's depth."""
        if groove.shape.root:
            return cls(groove, cells)
        root = ROUNDED * groove.shape.depth
        return cls(groove.rounded(root), cells, root)

    @cached_property
    def counts(self) -> tuple[int, ...]:
        """Cells of the bands along the contour."""
        c = self.cells
        return c.flank[0], c.root[0], c.floor, c.root[1], c.flank[1]

    @cached_property
    def rows(self) -> Floats:
        """Place on the contour, in bands of the groove's section, of every other node: ends and middles of cells."""
        foot = graded(self.cells.flank[0], 1.4)[::-1]
        parts = [1.0 - foot, _even(self.cells.root[0]), _even(self.cells.floor), _even(self.cells.root[1]),
                 graded(self.cells.flank[1], 1.4)]  # fmt: skip
        places = [band + part[:-1] for band, part in enumerate(parts)]
        return np.append(np.concatenate(places), 5.0)

    @property
    def contour_cells(self) -> int:
        """Cells along the contour."""
        return sum(self.counts)

    @cached_property
    def middles(self) -> tuple[int, int]:
        """Cells before the middles of the two roots."""
        flank, root, floor, _, _ = self.counts
        other = self.counts[3]
        return flank + root // 2, flank + root + floor + other // 2

    def root_cells(self, upper: bool) -> Index:
        """Numbers along the contour of the cells of one root."""
        before = sum(self.counts[: 3 if upper else 1])
        return np.arange(before, before + self.counts[3 if upper else 1])

    def wall_cells(self, upper: bool) -> tuple[Index, Index]:
        """Quadrilaterals of layer and wall above the foot of a flank, from there through the wall to the end."""
        c, along = self.cells, self.contour_cells
        low, high = self.middles
        first = along * c.layer
        if upper:
            foot = sum(self.counts[:4])
            start = first + c.wall[0] * low + (foot - high)
            return along * np.arange(c.layer) + foot, start + (along - high) * np.arange(c.wall[1])
        foot = self.counts[0]
        start = first + low - foot
        return along * np.arange(c.layer) + foot - 1, start + low * np.arange(c.wall[0])[::-1]

    def contour(self, psi: Floats) -> tuple[Floats, Floats, Floats]:
        """Exact u and v (n, 2 k + 1) of the contour's places at azimuths (n,), and the share of a root's turn there.

        Cells of a root share its length and its turning in the plane alike; their middle nodes halve their length.
        Raises NotConverged where a plane through the axis does not meet the groove's surface once.
        """
        rows, turn = np.tile(self.rows, (len(psi), 1)), np.zeros((len(psi), len(self.rows)))
        ends = 2 * np.cumsum((0, *self.counts))
        turn[:, ends[2] : ends[3] + 1] = 1.0
        dense = 1.0 - (1.0 - np.linspace(0.0, 1.0, DENSE)) ** 3
        for band in (1, 3):
            inside = slice(ends[band], ends[band + 1] + 1)
            places = band + dense if band == 1 else band + 1.0 - dense
            z, r = self._uv(psi, np.tile(places, (len(psi), 1)))
            shares, turned = _spread(z, r, self.counts[band])
            shares = np.array([np.interp(one, np.arange(DENSE), dense) for one in shares])
            rows[:, inside] = band + shares if band == 1 else (band + 1.0 - shares)[:, ::-1]
            turn[:, inside] = turned if band == 1 else turned[:, ::-1]
        return *self._uv(psi, rows), turn

    def _uv(self, psi: Floats, rows: Floats) -> tuple[Floats, Floats]:
        """Exact u and v (n, k) of places (n, k) at azimuths (n,)."""
        x = at_azimuths(self.groove.at, self.groove.shape.sense, psi, rows)
        return self.groove.uv(x[2].reshape(rows.shape), np.hypot(x[0], x[1]).reshape(rows.shape))

    def outline(self, psi: float) -> Floats:
        """z and r (k, 2) of the body's outline at an azimuth, rad, from the first land's edge along the contour."""
        u, v, _ = self.contour(np.array([psi]))
        (start, stop), back = self.groove.shape.ends, self.groove.shape.back
        around = np.array([[stop, v[0, -1]], [stop, back], [start, back], [start, v[0, 0]]])
        line = np.concatenate([np.stack([u[0], v[0]], axis=1), around])
        return np.stack(self.groove.zr(line[:, 0], line[:, 1]), axis=1)

    def blocks(self, psi: Floats) -> list[tuple[Floats, Floats]]:
        """z and r (n, i, j) of the nodes of every block, ends and middles of cells, the layer first.

        i runs from the contour into the material in the layer and along z elsewhere, j along the contour or r.
        """
        shape, c = self.groove.shape, self.cells
        back, (start, stop), root = shape.back, shape.ends, shape.root
        z, r, turn = self.contour(psi)
        first, last = 2 * self.middles[0], 2 * self.middles[1]
        room = min(float(z[:, : first + 1].min()) - start, stop - float(z[:, last:].max()), float(r.min()) - back)
        if room <= 0.0:
            raise DesignError("the groove leaves no wall: the volume is not meshed")
        # Where the groove runs steeply its section is stretched along u, and so is the layer.
        middle = shape.half_width - (1.0 - sqrt(0.5)) * root
        stretch = np.maximum((z[:, last] - z[:, first]) / (2.0 * middle), 1.0)[:, None]
        deep = min(LAYER * root, SHARE_OF_WALL * (float(r.min()) - back))
        walls = z[:, :first + 1].min(axis=1, keepdims=True) - start, stop - z[:, last:].max(axis=1, keepdims=True)
        low, high = (np.minimum(LAYER * root * stretch, SHARE_OF_WALL * wall) for wall in walls)
        along = np.where(self.rows < 2.5, -low, high) * np.cos(0.5 * np.pi * turn)
        down = deep * np.sin(0.5 * np.pi * turn)
        oz, or_ = z + along, r - down
        for line in (oz, or_):
            # Inside the body edges are straight: no middle node stands beyond a quarter of its edge.
            line[:, 1::2] = 0.5 * (line[:, :-2:2] + line[:, 2::2])
        depth = graded(c.layer, c.growth)[None, :, None]
        layer = z[:, None] + depth * (oz - z)[:, None], r[:, None] + depth * (or_ - r)[:, None]
        wall = [graded(n, 1.3)[None, :, None] for n in c.wall]
        core = _even(c.core)[None, None, :]
        wz, wr = oz[:, first::-1], or_[:, first::-1]
        below = wz[:, None] + wall[0][:, ::-1] * (start - wz[:, None]), np.repeat(wr[:, None], wall[0].shape[1], axis=1)
        uz, ur = oz[:, last:], or_[:, last:]
        above = uz[:, None] + wall[1] * (stop - uz[:, None]), np.repeat(ur[:, None], wall[1].shape[1], axis=1)
        bz, br = oz[:, first : last + 1, None], or_[:, first : last + 1, None]
        rise = back + core * (br - back)
        below_floor = np.repeat(bz, rise.shape[2], axis=2), rise
        corners = []
        for edge_z, edge_r in ((below[0][:, :, :1], below[1][:, :, :1]), (above[0][:, :, :1], above[1][:, :, :1])):
            corner = back + core * (edge_r - back)
            corners.append((np.repeat(edge_z, corner.shape[2], axis=2), corner))
        blocks = [layer, (below[0], below[1]), (above[0], above[1]), below_floor, *corners]
        return [self.groove.zr(u, v) for u, v in blocks]

    @property
    def notes(self) -> tuple[str, ...]:
        """The keyway is left out, and a sharp root is rounded."""
        found = self.groove.shape.notes
        return found if self.rounded is None else (*found, f"the sharp root is rounded by {self.rounded:.4g} mm")

    def sets(self, grids: Sequence[Index]) -> dict[str, list[Index]]:
        """Nodes on the faces of the body."""
        layer, below, above, middle, lower, upper = grids
        ends, contour = 2 * np.cumsum((0, *self.counts)), layer[0]
        low, high, behind = self.groove.shape.faces
        one, other = self.groove.shape.flanks
        names = (f"flank_{one}", f"root_{one}", "floor", f"root_{other}", f"flank_{other}")
        return {
            behind: [middle[:, 0], lower[:, 0], upper[:, 0]],
            **{name: [contour[a : b + 1]] for name, a, b in zip(names, ends[:-1], ends[1:])},
            "land": [below[:, -1], above[:, -1], layer[:, 0], layer[:, -1]],
            low: [below[0], lower[0]],
            high: [above[-1], upper[-1]],
        }


def _spread(z: Floats, r: Floats, count: int) -> tuple[Floats, Floats]:
    """Places (n, 2 count + 1), in numbers of points, of the nodes of a root's cells along points (n, k) from the flank.

    And the shares of the turning there, 0 at the flank and 1 at the floor.
    """
    dz, dr = np.diff(z, axis=1), np.diff(r, axis=1)
    length = np.cumsum(np.hypot(dz, dr), axis=1)
    angle = np.abs(np.arctan2(np.abs(dz), np.abs(dr)))
    angle = np.maximum.accumulate(np.concatenate([angle[:, :1], 0.5 * (angle[:, 1:] + angle[:, :-1]), angle[:, -1:]],
                                                 axis=1), axis=1)  # fmt: skip
    length = np.concatenate([np.zeros((len(z), 1)), length], axis=1) / length[:, -1:]
    turned = (angle - angle[:, :1]) / np.maximum(angle[:, -1:] - angle[:, :1], 1e-9)
    place, wanted = np.arange(z.shape[1], dtype=float), np.linspace(0.0, 1.0, count + 1)
    found, shares = np.empty((len(z), 2 * count + 1)), np.empty((len(z), 2 * count + 1))
    for i in range(len(z)):
        ends = np.interp(wanted, 0.5 * (length[i] + turned[i]), place)
        run = np.interp(ends, place, length[i])
        found[i, ::2], found[i, 1::2] = ends, np.interp(0.5 * (run[1:] + run[:-1]), length[i], place)
        found[i, [0, -1]] = 0.0, place[-1]
        shares[i] = np.interp(found[i], place, turned[i])
    return found, shares


def graded(count: int, growth: float) -> Floats:
    """Shares 0 .. 1 at the ends and middles (2 count + 1,) of cells that grow by a factor from one to the next."""
    size = growth ** np.arange(count)
    ends = np.concatenate([[0.0], np.cumsum(size)]) / size.sum()
    found = np.empty(2 * count + 1)
    found[::2], found[1::2] = ends, 0.5 * (ends[1:] + ends[:-1])
    return found


def _even(count: int) -> Floats:
    return np.linspace(0.0, 1.0, 2 * count + 1)
