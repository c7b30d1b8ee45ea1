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
from math import sqrt
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.body.groove import Groove, at_azimuths
from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property

Index = npt.NDArray[np.int64]
Pair = tuple[Floats, Floats]
LAYER = 1.6
"""thickness of the graded layer in root radii"""
ROUNDED = 0.06
"""share of a groove's depth by which a sharp root is rounded: no mesh has nodes of a sharp edge's stress"""
SHARE_OF_WALL = 0.4
"""of a wall's thickness that the layer takes at most"""
CROSSED = {(way, edge): np.array([[way * s, edge] for s in (-1.0, 0.0, 1.0)])
           for way in (1.0, -1.0) for edge in (1.0, -1.0)}  # fmt: skip
"""natural points (3, 2) along an edge of a quadrilateral, by the way of the first coordinate and the second's value"""
DENSE = 33
"""points of a root at which its length and turning are measured"""

@final
@immutable(eq=True)
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
@immutable
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

    def wall_path(self, upper: bool, layer: int = 0, wall: int | None = None) -> list[tuple[int, Floats]]:
        """Quadrilaterals from the foot of a flank through layer and wall to its end, above the foot, and three natural
        points (3, 2) of each on the way.

        layer, wall  numbers of the first quadrilateral of the layer and of that wall; None: as in `blocks`
        """
        c, along, (low, high) = self.cells, self.contour_cells, self.middles
        foot = sum(self.counts[:4]) if upper else self.counts[0] - 1
        if wall is None:
            wall = layer + along * c.layer + (c.wall[0] * low if upper else 0)
        path = [(layer + along * i + foot, CROSSED[1.0, -1.0 if upper else 1.0]) for i in range(c.layer)]
        height = self.height(upper, foot)
        if upper:
            return path + [(wall + (along - high) * i + height, CROSSED[1.0, -1.0]) for i in range(c.wall[1])]
        return path + [(wall + low * i + height, CROSSED[-1.0, -1.0]) for i in reversed(range(c.wall[0]))]

    def height(self, upper: bool, cell: int) -> int:
        """Cells of a wall below one that meets a cell of the contour, or the other way round of a lower wall."""
        low, high = self.middles
        return cell - high if upper else low - 1 - cell

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
        start, stop = self.groove.shape.ends
        u, v, turn = self.contour(psi)
        first, last = 2 * self.middles[0], 2 * self.middles[1]
        low, high = u[:, : first + 1].min(axis=1) - start, stop - u[:, last:].max(axis=1)
        below = v.min(axis=1) - self.groove.shape.back
        layer, outer = self.layer((u, v), turn, (low, high), below)
        wall = [self.wall(outer, upper) for upper in (False, True)]
        ends = [(np.full_like(edge[0], end), edge[1]) for edge, end in zip(wall, (start, stop))]
        walls = [ruled(ends[0], wall[0], self.shares(False)), ruled(wall[1], ends[1], self.shares(True))]
        bed = self.bed(outer)
        core = _even(self.cells.core)
        parts = [bed, *((u[:, :, 0], v[:, :, 0]) for u, v in walls)]
        under = [standing(part, self.groove.shape.back, core) for part in parts]
        return [self.groove.zr(*block) for block in (layer, *walls, *under)]

    def layer(self, contour: Pair, turn: Floats, walls: Pair, below: Floats) -> tuple[Pair, Pair]:
        """The layer's nodes (n, i, j), u and v, and those of its outer edge (n, j), of a contour (n, j).

        walls, below  mm, (n,), of the walls beside both flanks and of what is below the floor, of which the layer takes
        its share. Raises DesignError where one of them is gone.
        """
        shape, c, (u, v) = self.groove.shape, self.cells, contour
        root = shape.root
        if min(float(one.min()) for one in (*walls, below)) <= 0.0:
            raise DesignError("the groove leaves no wall: the volume is not meshed")
        first, last = 2 * self.middles[0], 2 * self.middles[1]
        # Where the groove runs steeply its section is stretched along u, and so is the layer.
        middle = shape.half_width - (1.0 - sqrt(0.5)) * root
        stretch = np.maximum((u[:, last] - u[:, first]) / (2.0 * middle), 1.0)
        low, high = (np.minimum(LAYER * root * stretch, SHARE_OF_WALL * wall)[:, None] for wall in walls)
        along = np.where(self.rows < 2.5, -low, high) * np.cos(0.5 * np.pi * turn)
        down = min(LAYER * root, SHARE_OF_WALL * float(below.min())) * np.sin(0.5 * np.pi * turn)
        outer = u + along, v - down
        for line in outer:
            # Inside the body edges are straight: no middle node stands beyond a quarter of its edge.
            line[:, 1::2] = 0.5 * (line[:, :-2:2] + line[:, 2::2])
        return ruled(contour, outer, graded(c.layer, c.growth)), outer

    def wall(self, outer: Pair, upper: bool) -> Pair:
        """The layer's outer edge beside a flank, u and v (n, k), from below up."""
        part = slice(2 * self.middles[1], None) if upper else slice(2 * self.middles[0], None, -1)
        return outer[0][:, part], outer[1][:, part]

    def bed(self, outer: Pair) -> Pair:
        """The layer's outer edge below the floor, u and v (n, k)."""
        part = slice(2 * self.middles[0], 2 * self.middles[1] + 1)
        return outer[0][:, part], outer[1][:, part]

    def shares(self, upper: bool) -> Floats:
        """Of a wall's cells from the layer on."""
        part = graded(self.cells.wall[int(upper)], 1.3)
        return part if upper else 1.0 - part[::-1]

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


def ruled(start: Pair, stop: Pair, shares: Floats) -> Pair:
    """Points (n, i, j) at shares (i,) of the way from points (n, j) to others."""
    u, v = (a[:, None] + shares[:, None] * (b - a)[:, None] for a, b in zip(start, stop))
    return u, v


def standing(top: Pair, back: float, shares: Floats) -> Pair:
    """Points (n, i, j) at shares (j,) of the way up from v = back to points (n, i)."""
    u, v = top
    rise = back + shares * (v - back)[:, :, None]
    return np.broadcast_to(u[:, :, None], rise.shape), rise


def graded(count: int, growth: float) -> Floats:
    """Shares 0 .. 1 at the ends and middles (2 count + 1,) of cells that grow by a factor from one to the next."""
    size = growth ** np.arange(count)
    ends = np.concatenate([[0.0], np.cumsum(size)]) / size.sum()
    found = np.empty(2 * count + 1)
    found[::2], found[1::2] = ends, 0.5 * (ends[1:] + ends[:-1])
    return found


def _even(count: int) -> Floats:
    return np.linspace(0.0, 1.0, 2 * count + 1)
