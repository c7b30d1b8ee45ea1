r"""The frame about a constant-width cam in hexahedra: a quarter of its plan in blocks, raised and mirrored twice.

      y = side    +----------------------------------+     The layer's cells run round the window's corner, or fill a
                  | outer                            |     square beside a sharp one. Between both `strip` lines runs a
      strip high  +----------------------------------+     guide bore along x: there a ring of cells round the bore is
                  | strip                            |     swept along x, with the same lines along x and z as its
      strip low   +-------------------+------+-------+     neighbours have.
                  |  bar              '-.    |       |
      y = window  +-----------------.    layer       |
                                     \       |       |
                                      +------+-------+
                                      |  low |  end  |
      y = face                   +----+------+-------+
                                 |pad |      |       |
                x = 0            +----+------+-------+
                                face       layer    end
"""

from __future__ import annotations

from itertools import pairwise
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.body.element import NATURAL, shapes
from camgeom.body.hexes import HexMesh, hexahedra
from camgeom.body.section import graded
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.solid.frame import FramePlate

Index = npt.NDArray[np.int64]
LAYER = 1.6
"""thickness of the graded layer in corner radii"""
SHARE = 0.4
"""of the bar beside the window, and of the end behind it, that the layer takes at most"""
BESIDE = 1.7
"""half the strip's width in radii of the bore, where there is room"""
ROOM = 2.2
"""bore radii from its axis to an edge below which the strip goes on to that edge"""
NEAR = 1e-7
"""mm"""
OUTLINED = 0.005
"""mm of chord error of a drawn window"""
HELD = "guides"


@final
@immutable(eq=True)
class FrameCells:
    """Cells: along half a face and half a bar, beside a face, half round a corner, across layer, end and a face's
    height, through the plate's thickness, and round a bore from its wall out."""

    face: int = 5
    bar: int = 5
    beside: int = 2
    half: int = 2
    layer: int = 2
    end: int = 2
    pad: int = 1
    through: int = 2
    ring: int = 2
    growth: float = 1.8

    @classmethod
    def fine(cls, times: int = 1) -> FrameCells:
        """Fine round the window's corners."""
        return cls(6, 6, 2 + times, 1 + 2 * times, 2 + times, 3, 1, 2 + times, 2, 2.2)


@final
@immutable
class FrameMesh:
    """The frame's plate in hexahedra, as it stands at zero lift, and where its ends bend."""

    plate: FramePlate
    cells: FrameCells = FrameCells()

    @property
    def root(self) -> float:
        """y at which the window's corner begins: there an end is as deep as beside it."""
        return 0.5 * self.plate.window - self.plate.corner

    @property
    def end(self) -> float:
        """x of the window's end from its middle, mm."""
        return 0.5 * self.plate.opening + self.plate.rise

    @property
    def depth(self) -> float:
        """Of the plate between the window and its end, mm."""
        return 0.5 * self.plate.length - self.end

    @cached_property
    def mesh(self) -> HexMesh:
        """Raises DesignError where an element is folded."""
        quarter = self._quarter
        ways = np.array([(x, y, 1.0) for x in (1.0, -1.0) for y in (1.0, -1.0)])
        nodes, elements = hexahedra([block * way for way in ways for block in quarter])
        sets = {name: np.flatnonzero(on) for name, on in self._faces(nodes).items()}
        return HexMesh(nodes + np.array([self.plate.middle, 0.0, 0.0]), elements, sets)

    def _faces(self, nodes: Floats) -> dict[str, npt.NDArray[np.bool_]]:
        plate, (low, high) = self.plate, self.plate.levels
        x, y, z = np.abs(nodes[:, 0]), np.abs(nodes[:, 1]), nodes[:, 2]
        near, side, half, wide = 0.5 * plate.opening, 0.5 * plate.face, 0.5 * plate.width, 0.5 * plate.window

        def at(value: Floats, place: float) -> npt.NDArray[np.bool_]:
            return np.asarray(np.abs(value - place) < NEAR)

        face = at(x, near) & (y < side + NEAR)
        bend_x, bend_y = x - (self.end - plate.corner), y - self.root
        root = at(np.hypot(bend_x, bend_y), plate.corner) & (bend_x > -NEAR) & (bend_y > -NEAR)
        walls = (at(x, self.end) & (y > side - NEAR) & (y < self.root + NEAR), at(y, wide) & (bend_x < NEAR),
                 at(y, side) & (x > near - NEAR) & (x < self.end + NEAR) & bool(plate.rise))  # fmt: skip
        found = {
            "face": face, "face_near": face & (nodes[:, 0] > 0.0), "face_far": face & (nodes[:, 0] < 0.0),
            "window": np.logical_or.reduce(walls), "root": root, "end_lower": at(z, low), "end_upper": at(z, high),
            "outside": at(x, 0.5 * plate.length) | at(y, half),
        }  # fmt: skip
        bored = at(np.hypot(y - 0.5 * plate.spacing, z - plate.height), 0.5 * plate.bore)
        return found | {HELD: bored if plate.bore else at(y, half)}

    @cached_property
    def _across(self) -> tuple[float, list[float]]:
        """Thickness of the layer, and y of the lines beside it: of the strip round a bore, and of the plate's side."""
        plate, (wide, half) = self.plate, (0.5 * self.plate.window, 0.5 * self.plate.width)
        wall = (0.5 * (plate.spacing - plate.bore) if plate.bore else half) - wide
        thick = min(LAYER * plate.corner if plate.corner else np.inf, SHARE * wall, SHARE * self.depth)
        lines = [wide + thick]
        if plate.bore:
            axis, radius = 0.5 * plate.spacing, 0.5 * plate.bore
            lines += [axis - BESIDE * radius] if axis - lines[0] > ROOM * radius else []
            lines += [axis + BESIDE * radius] if half - axis > ROOM * radius else []
        return thick, [*lines, half]

    @property
    def holes(self) -> tuple[Floats, ...]:
        """Outlines (k, 2) of the window and of the strips round the guide bores, mm."""
        plate, (_, lines) = self.plate, self._across
        strip = [(a, b) for a, b in pairwise(lines) if plate.bore and a < 0.5 * plate.spacing < b]
        (left, right), window = plate.ends, plate.polygon(OUTLINED)[0]
        bands = [way * np.array([[left, a], [right, a], [right, b], [left, b]])
                 for a, b in strip for way in (np.ones(2), np.array([1.0, -1.0]))]  # fmt: skip
        return (window, *bands)

    @cached_property
    def _heights(self) -> list[Floats]:
        """z of nodes in parts from the lower end up; three with a bore that is far from both, the middle one at it."""
        (low, high), middle, radius = self.plate.levels, self.plate.height, 0.5 * self.plate.bore
        places = [low, high]
        if radius and 0.5 * self.plate.thickness > ROOM * radius:
            places = [low, middle - BESIDE * radius, middle + BESIDE * radius, high]
        return [np.linspace(a, b, 2 * self.cells.through + 1) for a, b in pairwise(places)]

    @cached_property
    def _quarter(self) -> list[Floats]:
        """Blocks (a, b, c, 3) of the quarter at large x and y, x from the window's middle."""
        plate, c = self.plate, self.cells
        thick, (first, *lines) = self._across
        near, side, wide = 0.5 * plate.opening, 0.5 * plate.face, 0.5 * plate.window
        out = self.end + thick
        layer = graded(c.layer, c.growth)
        behind = out + graded(c.end, 1.4) * (0.5 * plate.length - out)
        beside = self.end + layer * thick
        half = 2 * c.half + 1
        if plate.corner:
            up, along = np.linspace(self.root, first, half), np.linspace(self.end - plate.corner, out, half)
        else:
            up, along = self.root + layer * thick, beside
        bar = (1.0 - graded(c.bar, 1.4)[::-1]) * along[0]
        flat: list[Floats] = []
        for low, high, count in ((0.0, side, c.face), (side, self.root, c.beside)):
            if high - low > NEAR:
                y = np.linspace(low, high, 2 * count + 1)
                flat += [_grid(beside, y), _grid(behind, y)]
                flat += [_grid(np.linspace(near, self.end, 2 * c.pad + 1), y)] if plate.rise and not low else []
        flat += [_grid(behind, up), _grid(bar, wide + layer * thick), *self._corner(along, up, beside)]
        x = np.concatenate([bar[:-1], along[:-1], behind])
        blocks = []
        heights = np.concatenate([self._heights[0], *(part[1:] for part in self._heights[1:])])
        for low, high in pairwise([first, *lines]):
            if plate.bore and low < 0.5 * plate.spacing < high:
                blocks += self._strip(x, low, high)
            else:
                flat.append(_grid(x, np.linspace(low, high, 2 * (2 if plate.bore else 4) + 1)))
        return [*blocks, *(_raised(block, heights) for block in flat)]

    def _corner(self, along: Floats, up: Floats, beside: Floats) -> list[Floats]:
        """The layer round the window's corner, in two blocks, or the square beside a sharp one."""
        plate, layer = self.plate, graded(self.cells.layer, self.cells.growth)[:, None, None]
        if not plate.corner:
            return [_grid(beside, up)]
        centre, found = np.array([self.end - plate.corner, self.root]), []
        sides = np.stack([np.full_like(up, along[-1]), up], axis=1), np.stack(
            [along[::-1], np.full_like(along, up[-1])], axis=1
        )
        for turn, outer in zip((0.0, 0.25 * np.pi), sides):
            angle = turn + np.linspace(0.0, 0.25 * np.pi, len(outer))
            arc = centre + plate.corner * np.stack([np.cos(angle), np.sin(angle)], axis=1)
            found.append(arc + layer * (outer - arc))
        return found

    def _strip(self, x: Floats, low: float, high: float) -> list[Floats]:
        """A ring of cells round a guide bore, swept along x (n,), and what is above and below it."""
        plate, c = self.plate, self.cells
        axis, radius, inner = 0.5 * plate.spacing, 0.5 * plate.bore, self._heights[len(self._heights) // 2]
        y = np.linspace(low, high, 2 * c.through + 1)
        z0, z1 = inner[0], inner[-1]
        sides = ((y, np.full_like(y, z0)), (np.full_like(inner, high), inner),
                 (y[::-1], np.full_like(y, z1)), (np.full_like(inner, low), inner[::-1]))  # fmt: skip
        centre, blocks = np.array([axis, plate.height]), []
        for outer in (np.stack(side, axis=1) for side in sides):
            a, b = np.arctan2(*(outer[[0, -1]] - centre).T[::-1])
            angle = a + np.linspace(0.0, (b - a) % (2.0 * np.pi), len(outer))
            wall = centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
            plane = wall + graded(c.ring, 1.5)[:, None, None] * (outer - wall)
            blocks.append(np.stack([np.concatenate([np.broadcast_to(one, (*plane.shape[:2], 1)), plane], axis=2)
                                    for one in x]))  # fmt: skip
        for part in (self._heights[0], self._heights[-1]) if len(self._heights) > 1 else ():
            blocks.append(_raised(_grid(x, y), part))
        return blocks

    @cached_property
    def _pressed(self) -> tuple[Index, Floats, Floats]:
        """Nodes (a, b) of the near face by y and z, -1 in the middles of cells, and y and z of its lines."""
        mesh = self.mesh
        nodes = mesh.sets["face_near"]
        lines, places = [], []
        for value in (mesh.nodes[nodes, 1], mesh.nodes[nodes, 2]):
            _, first, place = np.unique(np.round(value, 6), return_index=True, return_inverse=True)
            lines.append(value[first])
            places.append(place)
        y, z = lines
        found = np.full((len(y), len(z)), -1, dtype=np.int64)
        found[places[0], places[1]] = nodes
        return found, y, z

    def spread(self, y: Floats, z: Floats, sizes: Floats) -> tuple[Index, Floats]:
        """Nodes (p, 8) of the near face, and shares (p, 8), that do the work of sizes (p,) at points y, z (p,)."""
        grid, *lines = self._pressed
        cell, at = [], []
        for value, line in zip((y, z), lines):
            ends = line[::2]
            number = np.clip(np.searchsorted(ends, value, side="right") - 1, 0, len(ends) - 2)
            cell.append(number)
            at.append(2.0 * (value - ends[number]) / (ends[number + 1] - ends[number]) - 1.0)
        ours = np.flatnonzero(NATURAL[:, 2] == -1.0)
        weight = shapes(np.stack([*at, np.full_like(y, -1.0)], axis=1))[0][:, ours]
        place = (NATURAL[ours, :2] + 1.0).astype(int)
        nodes = grid[2 * cell[0][:, None] + place[:, 0], 2 * cell[1][:, None] + place[:, 1]]
        return nodes, weight * sizes[:, None]


def _grid(x: Floats, y: Floats) -> Floats:
    """Points (a, b, 2) of lines x (a,) and y (b,)."""
    return np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)


def _raised(flat: Floats, z: Floats) -> Floats:
    """Points (a, b, c, 3) of points (a, b, 2) at heights z (c,)."""
    a, b, _ = flat.shape
    return np.concatenate([np.broadcast_to(flat[:, :, None], (a, b, len(z), 2)),
                           np.broadcast_to(z[:, None], (a, b, len(z), 1))], axis=3)  # fmt: skip
