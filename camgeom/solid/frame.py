"""The frame about a constant-width cam as a part: a plate with a window, its two faces, and bores for guide rods.

Seen along +Z: outside a rectangle, length along X, the motion; inside the window. Faces narrower than the window stand
out of it by `rise`; the corners beside them may then be rounded, as an end mill leaves them, where no cam comes. Two
guide bores run along X through the bars beside the window. Everything is plane or round: edges and faces are exact.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil, cos, pi, tan

import numpy as np

from camgeom.errors import Problem
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.solid import QuickPart, Solid, stated
from camgeom.solid.blank import Wall, chord_step
from camgeom.solid.builder import Builder, Index, bounded, cap
from camgeom.solid.prism import raised

ROUND = tan(pi / 8.0)
"""bulge of a quarter of a circle: tan of a quarter of its angle"""


@immutable(eq=True)
class WindowEdge:
    """One edge of the window's outline from start to stop, (x, y) mm, and the name of its face; bulge as in DXF."""

    start: tuple[float, float]
    stop: tuple[float, float]
    name: str
    bulge: float = 0.0

    @property
    def centre(self) -> tuple[float, float]:
        """Of a quarter of a circle."""
        (a, b), (c, d) = self.start, self.stop
        return 0.5 * (a + c - (d - b)), 0.5 * (b + d + (c - a))

    def at(self, share: Floats) -> Floats:
        """Points (n, 2) at shares of the edge."""
        start, stop = np.array(self.start), np.array(self.stop)
        if not self.bulge:
            return np.asarray(start + share[:, None] * (stop - start))
        centre, turn = np.array(self.centre), 0.5 * pi * share[:, None]
        way = start - centre
        return np.asarray(centre + np.cos(turn) * way + np.sin(turn) * np.array([-way[1], way[0]]))


@immutable(eq=True, kw_only=True)
class FramePlate(QuickPart):
    """The plate as it stands at zero lift, mm.

    middle, height       x of the middle of its window, z of its middle plane
    length, width        outside, along the motion and across; thickness: along the cam axis
    opening              between both faces: the cam's constant width and the clearance
    window               width of the window; face: of each face, at most as wide; rise: of a face out of the window
    corner               radius of the window's corners
    bore, spacing        diameter of the guide bores, 0 for none, and the distance of their axes
    """

    middle: float
    height: float
    length: float
    width: float
    thickness: float
    opening: float
    window: float
    face: float
    rise: float = 0.0
    corner: float = 0.0
    bore: float = 0.0
    spacing: float = 0.0
    name: str = "frame"

    @property
    def ends(self) -> tuple[float, float]:
        """x of both ends, mm."""
        return self.middle - 0.5 * self.length, self.middle + 0.5 * self.length

    @property
    def levels(self) -> tuple[float, float]:
        """z of both large faces, mm."""
        return self.height - 0.5 * self.thickness, self.height + 0.5 * self.thickness

    @property
    def rods(self) -> tuple[float, ...]:
        """y of the axes of the guide bores, mm."""
        return (-0.5 * self.spacing, 0.5 * self.spacing) if self.bore else ()

    @property
    def outside(self) -> Floats:
        """Corners (4, 2) of the rectangle, counter-clockwise from the lower left."""
        (low, high), half = self.ends, 0.5 * self.width
        return np.array([[low, -half], [high, -half], [high, half], [low, half]])

    @cached_property
    def sides(self) -> tuple[WindowEdge, ...]:
        """The window's outline, counter-clockwise from the near face (at large x) on."""
        face, wide, near, far = 0.5 * self.face, 0.5 * self.window, 0.5 * self.opening, 0.5 * self.opening + self.rise
        quarter = [(near, face)]
        if self.rise:
            quarter += [(far, face), (far, wide - self.corner)]
            quarter += [(far - self.corner, wide)] if self.corner else []
        half = [*quarter, *((-x, y) for x, y in reversed(quarter))]
        ring = [*half, *((-x, -y) for x, y in half)]
        found = []
        for (x0, y0), (x1, y1) in zip([ring[-1], *ring], ring):
            name = "face" if x0 == x1 and abs(x0) == near else "window"
            ends = (x0 + self.middle, y0), (x1 + self.middle, y1)
            found.append(WindowEdge(*ends, name, ROUND if x0 != x1 and y0 != y1 else 0.0))
        return tuple(found)

    @property
    def volume(self) -> float:
        """mm³, closed form."""
        corners = (4.0 - pi) * self.corner**2
        area = self.face * self.opening + (self.window - self.face) * (self.opening + 2.0 * self.rise) - corners
        bores = len(self.rods) * 0.25 * pi * self.bore**2 * self.length
        return (self.length * self.width - area) * self.thickness - bores

    @property
    def walls(self) -> tuple[Wall, ...]:
        """What is left of the plate beside window and bores."""
        bar = 0.5 * (self.width - self.window)
        found = [
            ("window to end", 0.5 * (self.length - self.opening) - self.rise, "a longer plate (follower.plate_length)"),
            ("window to side", bar, "a wider plate (follower.plate_width)"),
            ("from face to face", self.thickness, "a larger follower.plate_thickness"),
        ]
        if self.bore:
            radius = 0.5 * self.bore
            moved = "a smaller follower.guide_bore, another guide_spacing, or a wider plate"
            found += [
                ("guide bore to window", 0.5 * (self.spacing - self.window) - radius, moved),
                ("guide bore to side", 0.5 * (self.width - self.spacing) - radius, moved),
                ("guide bore to face", 0.5 * self.thickness - radius, "a smaller follower.guide_bore, a thicker plate"),
            ]
        return tuple(Wall(f"frame, {place}", thickness, None, advice) for place, thickness, advice in found)

    def problems(self) -> list[Problem]:
        """What bounds no plate, with key, value and allowed range."""

        def found(key: str, value: float, allowed: str) -> Problem:
            return Problem(f"follower.{key}", "cannot be built", value, allowed)

        told = []
        if self.face > self.window:
            told.append(found("face_width", self.face, f"at most the window's width, {self.window:g} mm"))
        elif bool(self.rise) != (self.face < self.window):
            allowed = "above 0, for faces narrower than the window stand out of it" if self.face < self.window else (
                "0, or a follower.face_width below the window's")  # fmt: skip
            told.append(found("face_height", self.rise, allowed))
        most = max(0.0, min(self.rise, 0.5 * (self.window - self.face)))
        if self.corner > most:
            allowed = f"at most {most:g} mm: a rounded corner lies beside faces that stand out of the window"
            told.append(found("window_radius", self.corner, allowed))
        inside = self.opening + 2.0 * self.rise
        if self.length <= inside:
            told.append(found("plate_length", self.length, f"above {inside:.9g} mm, the length of the window"))
        if self.width <= self.window:
            told.append(found("plate_width", self.width, f"above {self.window:g} mm, the width of the window"))
        if self.bore >= self.thickness:
            told.append(found("guide_bore", self.bore, f"below {self.thickness:g} mm, the thickness of the plate"))
        low, high = self.window + self.bore, self.width - self.bore
        if self.bore and not told and low >= high:
            told.append(found("guide_bore", self.bore, f"below {0.5 * (self.width - self.window):.9g} mm, the width of "
                              "the bars beside the window"))  # fmt: skip
        if self.bore and not told and not low < self.spacing < high:
            allowed = f"between {low:g} and {high:g} mm, so that both bores run within the bars beside the window"
            told.append(found("guide_spacing", self.spacing, allowed))
        return told

    def points(self, step: float) -> Iterator[tuple[str, Floats, Floats]]:
        """Name, points (n, 3) and normals out of the material (n, 3) of window and guide bores, about `step` mm apart.

        Three heights of every edge of the window, and 12 places round a bore; edges and corners stay free.
        """
        (low, high), around = self.levels, 2.0 * pi * np.arange(12) / 12
        heights = low + (high - low) * np.array([0.1, 0.5, 0.9])
        for side in self.sides:
            length = float(np.hypot(*np.subtract(side.stop, side.start)))
            share = np.linspace(0.0, 1.0, max(1, ceil(length / step)) + 2)[1:-1]
            flat, ahead = side.at(share), side.at(share + 1e-4) - side.at(share - 1e-4)
            inward = np.column_stack([-ahead[:, 1], ahead[:, 0]]) / np.hypot(*ahead.T)[:, None]
            points = np.column_stack([np.repeat(flat, 3, axis=0), np.tile(heights, len(flat))])
            name = side.name if side.name == "window" else ("near" if side.start[0] > self.middle else "far") + " face"
            yield name, points, np.column_stack([np.repeat(inward, 3, axis=0), np.zeros(len(points))])
        x = np.linspace(*self.ends, max(1, ceil(self.length / step)) + 2)[1:-1]
        for y in self.rods:
            out = np.column_stack([np.zeros(12), np.cos(around), np.sin(around)])
            ring = np.array([0.0, y, self.height]) + 0.5 * self.bore * out
            points = (ring[None] + x[:, None, None] * np.array([1.0, 0.0, 0.0])).reshape(-1, 3)
            yield "guide bore", points, np.tile(-out, (len(x), 1))

    def polygon(self, tolerance: float) -> tuple[Floats, list[str], float]:
        """The window as a polygon (n, 2), counter-clockwise, the name of each edge, and its chord error, mm."""
        step = chord_step(self.corner, tolerance)
        parts = ceil(0.5 * pi / step) if self.corner else 1
        points = [side.at(np.arange(parts if side.bulge else 1) / parts) for side in self.sides]
        names = [side.name for side, each in zip(self.sides, points) for _ in each]
        return np.concatenate(points), names, self.corner * (1.0 - cos(0.25 * pi / parts))

    def solid(self, tolerance: float, free: float | None = None) -> Solid:
        """Mesh within the tolerance: planes are exact, corners and guide bores have a chord error, and are all free."""
        builder, (low, high) = Builder(), self.levels
        polygon, names, error = self.polygon(free or tolerance)
        window = raised(builder, polygon, names, low, high, True, ("corner", error))
        corners = [builder.add(np.column_stack([self.outside, np.full(4, z)])) for z in (low, high)]
        for ring, hole, up in ((corners[0], window.low, False), (corners[1], window.high, True)):
            cap(builder, [ring, hole], [self.outside, window.above], "end", up)
        for a, b in ((0, 1), (2, 3)):
            (i, j), (k, m) = corners[0][[a, b]], corners[1][[a, b]]
            builder.faces(np.array([[i, j, m], [i, m, k]]), "outside")
        error, free_error = stated([("corner", max(error, self._bored(builder, corners, free or tolerance)))], free)
        return Solid(self.name, builder.mesh(), error, "direct", 1 + len(self.rods), free_error)

    def _bored(self, builder: Builder, corners: list[Index], tolerance: float) -> float:
        """Add both ends with the guide bores between them; returns the chord error of the bores, mm."""
        radius = 0.5 * self.bore
        parts = max(12, ceil(2.0 * pi / chord_step(radius, tolerance))) if self.bore else 12
        angle = 2.0 * pi * np.arange(parts) / parts
        circle = radius * np.column_stack([np.cos(angle), np.sin(angle)])
        circles = [circle + np.array([y, self.height]) for y in self.rods]
        half, (low, high) = 0.5 * self.width, self.levels
        outer = np.array([[-half, low], [half, low], [half, high], [-half, high]])
        triangles = bounded([outer, *(circle[::-1] for circle in circles)])
        rings: list[list[Index]] = []
        for x, (left, right), out in zip(self.ends, ((0, 3), (1, 2)), (False, True)):
            rings.append([builder.add(np.column_stack([np.full(parts, x), circle])) for circle in circles])
            frame = np.array([corners[0][left], corners[0][right], corners[1][right], corners[1][left]])
            faces = np.concatenate([frame, *(ring[::-1] for ring in rings[-1])])[triangles]
            builder.faces(faces if out else faces[:, ::-1], "outside")
        for one, other in zip(*rings):
            builder.band(other, one, "guide bore")
        return radius * (1.0 - cos(pi / parts))
