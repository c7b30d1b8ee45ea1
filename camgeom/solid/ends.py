"""Where grooves and lands are cut off at a cam's end planes: vertices on the true surface, and what facets then err.

A vertex of a groove has an address, its column and its row as real numbers, at which the section gives the exact
point. Along an edge that crosses a plane the address where the true surface does is found by its root; on a land,
a surface of revolution, the point is known from its direction.
"""

from __future__ import annotations

from functools import reduce

import numpy as np
import numpy.typing as npt

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import bracketed_root
from camgeom.maths.frozen import cached_property
from camgeom.maths.mesh import clip
from camgeom.maths.sampling import Counts
from camgeom.solid.builder import Index
from camgeom.solid.lands import LandSurface
from camgeom.track.section import CrossSection

LAND = -1
"""owner of a vertex that lies on a land alone"""
STEP = 1e-3
"""of a column or row, over which a height's slope is taken"""
SECANTS = 6
MET = 1e-12
"""share of an edge's height by which its crossing may miss the plane"""
FLAT = 1e-3
"""slope of the height along columns, as a share of that along rows, below which a vertex is moved along its column"""


@immutable
class Addresses:
    """Of every vertex (v,): the groove it belongs to (or LAND), its column and its row there."""

    owner: Index
    column: Floats
    row: Floats

    def of_vertices(self, index: Index) -> Addresses:
        """Those of some vertices, of any shape."""
        return Addresses(self.owner[index], self.column[index], self.row[index])

    def moved(self, index: Index, column: Floats, row: Floats) -> Addresses:
        """All, with some vertices elsewhere on their grooves."""
        columns, rows = self.column.copy(), self.row.copy()
        columns[index], rows[index] = column, row
        return Addresses(self.owner, columns, rows)

    def joined(self, other: Addresses) -> Addresses:
        """These and then others."""
        pairs = zip((self.owner, self.column, self.row), (other.owner, other.column, other.row))
        return Addresses(*(np.concatenate(pair) for pair in pairs))


@immutable
class EndCut:
    """Grooves and lands with their true surfaces, for being cut off.

    angles  rad, cam angles of the columns of every groove; counts of rows across its bands
    closed  whether a groove's last column is its first one
    """

    sections: tuple[CrossSection, ...]
    land: LandSurface
    angles: list[Floats]
    counts: Counts
    closed: bool

    @cached_property
    def _cells(self) -> Floats:
        """Columns of every groove, less one."""
        return np.array([len(phi) - 1.0 for phi in self.angles])

    def on_groove(self, at: Addresses) -> Floats:
        """Exact points (n, 3) at addresses (n,), none of them a land's."""
        points = np.empty((len(at.owner), 3))
        for k, section in enumerate(self.sections):
            own = np.flatnonzero(at.owner == k)
            if len(own):
                phi = np.interp(at.column[own], np.arange(len(self.angles[k])), self.angles[k])
                points[own] = section.at(phi, at.row[own], self.counts).T
        return points

    def on_land(self, points: Floats, height: float) -> Floats:
        """The land's points (n, 3) at one height, in the directions of the points given."""
        psi = np.arctan2(points[:, 1], points[:, 0])
        found = self.land.points(psi, np.full(len(points), self.land.at_height(height))).T
        found[:, 2] = height
        return np.ascontiguousarray(found)

    def unwrapped(self, at: Addresses, beside: Addresses) -> Addresses:
        """The same addresses with columns of a closed groove counted on from those beside them."""
        if not self.closed:
            return at
        cells = self._cells[np.maximum(at.owner, 0)]
        return Addresses(at.owner, at.column + cells * np.rint((beside.column - at.column) / cells), at.row)

    def _wrapped(self, at: Addresses) -> Addresses:
        """The same addresses with columns within their strips."""
        if not self.closed:
            return at
        cells = self._cells[np.maximum(at.owner, 0)]
        return Addresses(at.owner, np.where(at.column > cells, at.column - cells, np.maximum(at.column, 0.0)), at.row)

    def between(self, one: Addresses, other: Addresses, share: Floats) -> Addresses:
        """Addresses at shares (n,) of the way from one to the other, on the same grooves."""
        other = self.unwrapped(other, one)
        column = one.column + share * (other.column - one.column)
        return self._wrapped(Addresses(one.owner, column, one.row + share * (other.row - one.row)))

    def beside(self, one: Addresses, other: Addresses) -> npt.NDArray[np.bool_]:
        """Whether pairs lie in one cell of one groove (an edge of it, at least)."""
        other = self.unwrapped(other, one)
        near = (np.abs(other.column - one.column) <= 1.0) & (np.abs(other.row - one.row) <= 1.0)
        return np.asarray((one.owner != LAND) & (one.owner == other.owner) & near)

    def laid(self, points: Floats, at: Addresses, height: float, near: float) -> tuple[Floats, Addresses, Index]:
        """Vertices within `near` of a plane moved onto it over the true surface; points, addresses, and which moved.

        One that does not come to lie there stays where it was.
        """
        index = np.flatnonzero(np.abs(points[:, 2] - height) < near)
        on_land = index[at.owner[index] == LAND]
        points = points.copy()
        points[on_land] = self.on_land(points[on_land], height)
        index = index[at.owner[index] != LAND]
        if not len(index):
            return points, at, on_land
        start = at.of_vertices(index)
        last = sum(self.counts)
        inward = np.where(start.row < last, STEP, -STEP)
        by_column = (self._height(start, STEP, 0.0) - points[index, 2]) / STEP
        by_row = (self._height(start, 0.0, inward) - points[index, 2]) / inward
        rim = (start.row == 0.0) | (start.row == last)
        along = rim | (np.abs(by_column) > FLAT * np.abs(by_row))
        slope = np.where(along, by_column, by_row)
        move = np.zeros(len(index))
        before, off = move, points[index, 2] - height
        move = -off / np.where(slope != 0.0, slope, 1.0)
        for _ in range(SECANTS):
            after = self._height(start, np.where(along, move, 0.0), np.where(along, 0.0, move)) - height
            change = after - off
            step = np.where(change != 0.0, after * (move - before) / np.where(change != 0.0, change, 1.0), 0.0)
            before, off, move = move, after, np.clip(move - step, -0.5, 0.5)
        place = self._moved(start, np.where(along, move, 0.0), np.where(along, 0.0, move))
        found = self.on_groove(place)
        good = np.abs(found[:, 2] - height) < 1e-6 * near
        points[index[good]] = found[good]
        points[index[good], 2] = height
        return points, at.moved(index[good], place.column[good], place.row[good]), np.append(on_land, index[good])

    def _moved(self, at: Addresses, columns: Floats | float, rows: Floats | float) -> Addresses:
        row = np.clip(at.row + rows, 0.0, float(sum(self.counts)))
        column = at.column + columns
        if not self.closed:
            cells = self._cells[at.owner]
            column = np.clip(column, 0.0, cells)
        return Addresses(at.owner, np.asarray(column, dtype=np.float64), np.asarray(row, dtype=np.float64))

    def _height(self, at: Addresses, columns: Floats | float, rows: Floats | float) -> Floats:
        return self.on_groove(self._moved(at, columns, rows))[:, 2]

    def clipped(
        self, points: Floats, at: Addresses, faces: Index, label: npt.NDArray[np.uint8], height: float, sign: float
    ) -> tuple[Floats, Addresses, Index, npt.NDArray[np.uint8]]:
        """What lies at sign * (z - height) <= 0, as `clip` says, with new vertices on the true surface."""
        made: list[Addresses] = []

        def place(i: Index, j: Index, straight: Floats) -> Floats:
            one, other = at.of_vertices(i), at.of_vertices(j)
            groove = self.beside(one, other)
            new = np.empty_like(straight)
            new[~groove] = self.on_land(straight[~groove], height)
            a, b = (Addresses(x.owner[groove], x.column[groove], x.row[groove]) for x in (one, other))
            met, new[groove] = self._meeting(a, b, points[i[groove], 2] - height, points[j[groove], 2] - height, height)
            new[:, 2] = height
            owner, column, row = np.full(len(i), LAND), np.zeros(len(i)), np.zeros(len(i))
            owner[groove], column[groove], row[groove] = met.owner, met.column, met.row
            made.append(Addresses(owner, column, row))
            return new

        points, faces, label = clip(points, faces, label, height, sign, place)
        return points, at.joined(made[0]), faces, label

    def _meeting(
        self, a: Addresses, b: Addresses, below: Floats, above: Floats, height: float
    ) -> tuple[Addresses, Floats]:
        """Addresses and points on the way from a to b at one height, off which these stand by `below` and `above`, mm.

        By the parabola through both ends and what the straight edge misses by, then secants; by brackets where these
        do not meet it.
        """

        def at(share: Floats) -> tuple[Floats, Floats]:
            points = self.on_groove(self.between(a, b, share))
            return points, points[:, 2] - height

        rise = above - below
        share = -below / rise
        points, miss = at(share)
        slope = rise + miss * (1.0 - 2.0 * share) / (share * (1.0 - share))
        for _ in range(SECANTS):
            if np.all(np.abs(miss) <= MET * np.abs(rise)):
                return self.between(a, b, share), points
            moved = np.clip(share - miss / np.where(slope != 0.0, slope, rise), 0.0, 1.0)
            points, after = at(moved)
            steeper = moved != share
            slope = np.where(steeper, (after - miss) / np.where(steeper, moved - share, 1.0), slope)
            share, miss = moved, after
        left = np.abs(miss) > MET * np.abs(rise)
        if left.any():
            one, other = (Addresses(x.owner[left], x.column[left], x.row[left]) for x in (a, b))
            share[left] = bracketed_root(
                lambda s: self.on_groove(self.between(one, other, s))[:, 2] - height,
                np.zeros(len(one.row)), np.ones(len(one.row)),
            )  # fmt: skip
            points = at(share)[0]
        return self.between(a, b, share), points

    def sag(self, points: Floats, at: Addresses, faces: Index, on_land: npt.NDArray[np.bool_]) -> float:
        """Largest distance of the true surface from the facets (f, 3), mm, at the middles of their edges and their own.

        on_land  (f,) which facets are a land's
        """
        worst = 0.0
        corner = [at.of_vertices(faces[~on_land, k]) for k in range(3)]
        if len(corner[0].owner):
            x = [points[faces[~on_land, k]] for k in range(3)]
            corner = [corner[0], *(self.unwrapped(c, corner[0]) for c in corner[1:])]
            middles = [self._middle(part) for part in (corner, corner[:2], corner[1:], corner[::2])]
            for true in np.split(self.on_groove(reduce(Addresses.joined, middles)), len(middles)):
                worst = max(worst, float(_from_plane(true, *x).max()))
        face = faces[on_land]
        for group in (face, face[:, [0, 1]], face[:, [1, 2]], face[:, [2, 0]]):
            if len(group):
                middle = points[group].mean(axis=1)
                w = self.land.along(middle.T)
                true = self.land.points(np.arctan2(middle[:, 1], middle[:, 0]), w)
                worst = max(worst, float(np.sqrt(((true.T - middle) ** 2).sum(axis=1)).max()))
        return worst

    def _middle(self, corners: list[Addresses]) -> Addresses:
        column = np.mean([c.column for c in corners], axis=0)
        return self._wrapped(Addresses(corners[0].owner, column, np.mean([c.row for c in corners], axis=0)))


def _from_plane(x: Floats, a: Floats, b: Floats, c: Floats) -> Floats:
    """Distance (n,) of points (n, 3) from the planes through a, b and c; 0 where these are in one line."""
    normal = np.cross(b - a, c - a)
    size = np.sqrt((normal * normal).sum(axis=1))
    return np.asarray(np.abs(((x - a) * normal).sum(axis=1)) / np.maximum(size, 1e-300))
