"""Shapes of a sheet as plain data, and their text as SVG; y runs down, in the unit of the sheet they stand on.

A style is a class name (or several): what it looks like is the business of the page's style sheet or of the paper.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from html import escape
from typing import Literal, final

import numpy as np

from camgeom.immutable import immutable
from camgeom.maths import Floats

Anchor = Literal["start", "middle", "end"]
Box = tuple[float, float, float, float]
"""left, top, right, bottom"""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Lines:
    """Polylines (k, 2) drawn as one shape; of a filled one with holes `even_odd` says what is inside."""

    style: str
    lines: tuple[Floats, ...]
    closed: bool = False
    even_odd: bool = False


@final
@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """Straight lines with their ends (k, 2, 2)."""

    style: str
    ends: Floats


@final
@dataclass(frozen=True, slots=True)
class GridLines:
    """Upright lines at x and level lines at y, from edge to edge of a box."""

    style: str
    box: Box
    x: tuple[float, ...]
    y: tuple[float, ...]


@final
@dataclass(frozen=True, slots=True)
class Rectangle:
    """A rectangle; `fill` is a colour that no style names, as `#rrggbb`."""

    style: str
    box: Box
    fill: str = ""


@final
@dataclass(frozen=True, slots=True)
class Dot:
    """A circle: centre and radius."""

    style: str
    centre: tuple[float, float]
    radius: float


@final
@dataclass(frozen=True, slots=True)
class Words:
    """A line of text with its baseline at (x, y); size is that of the face."""

    style: str
    x: float
    y: float
    text: str
    anchor: Anchor
    size: float


@final
@dataclass(frozen=True, slots=True)
class Picture:
    """A picture, given as a data URI, stretched over a box."""

    box: Box
    source: str


@final
@dataclass(frozen=True, slots=True)
class Window:
    """Shapes of which only what lies inside a box is seen."""

    box: Box
    shapes: tuple[Shape, ...]


@final
@dataclass(frozen=True, slots=True)
class Cursor:
    """A line that a page moves to the common cam angle: an axis from `low` to `high` over x, and heights it crosses."""

    x: tuple[float, float]
    low: float
    high: float
    heights: tuple[tuple[float, float], ...]


Painted = Lines | Segments | GridLines | Rectangle | Dot | Words
Shape = Painted | Picture | Window | Cursor


@final
@immutable(eq=True)
class Pen:
    """How shapes become SVG: the attributes that paint one, steps of a coordinate per unit, and the size of text that
    goes without saying."""

    paint: Callable[[Painted], str]
    steps: int
    size: float | None = None

    def svg(self, shape: Shape) -> str:
        """The element of a shape."""
        n = self._number
        paint = self.paint(shape) if isinstance(shape, Painted) else ""
        match shape:
            case Lines():
                rule = ' fill-rule="evenodd"' if shape.even_odd else ""
                return f'<path{paint}{rule} d="{"".join(self._path(line, shape.closed) for line in shape.lines)}"/>'
            case Segments():
                data = "".join(f"M{n(a)} {n(b)}L{n(c)} {n(d)}" for a, b, c, d in shape.ends.reshape(-1, 4).tolist())
                return f'<path{paint} d="{data}"/>'
            case GridLines():
                left, top, right, bottom = map(n, shape.box)
                upright, level = map(n, shape.x), map(n, shape.y)
                parts = [*(f"M{x} {top}V{bottom}" for x in upright), *(f"M{left} {y}H{right}" for y in level)]
                return f'<path{paint} d="{"".join(parts)}"/>'
            case Rectangle():
                fill = f' fill="{shape.fill}"' if shape.fill else ""
                return f"<rect{paint} {self._place(shape.box)}{fill}/>"
            case Dot():
                return f'<circle{paint} cx="{n(shape.centre[0])}" cy="{n(shape.centre[1])}" r="{n(shape.radius)}"/>'
            case Words():
                anchor = f' text-anchor="{shape.anchor}"' if shape.anchor != "start" else ""
                size = f' font-size="{shape.size:g}"' if shape.size != self.size else ""
                place = f'x="{n(shape.x)}" y="{n(shape.y)}"'
                return f"<text {place}{paint}{anchor}{size}>{escape(shape.text)}</text>"
            case Picture():
                return f'<image {self._place(shape.box)} preserveAspectRatio="none" href="{shape.source}"/>'
            case Window():
                x, y, wide, high = self._numbers(shape.box)
                inner = "".join(map(self.svg, shape.shapes))
                return f'<svg {self._place(shape.box)} viewBox="{x} {y} {wide} {high}">{inner}</svg>'
            case Cursor():
                heights = " ".join(f"{n(top)} {n(bottom)}" for top, bottom in shape.heights)
                x0, x1 = map(n, shape.x)
                return f'<path class="cursor" data-cam="{x0} {x1} {shape.low:g} {shape.high:g} {heights}" d=""/>'

    def _number(self, value: float) -> str:
        """A coordinate to a step; a whole one without a point."""
        places = len(str(self.steps)) - 1
        return f"{value:.{places}f}".rstrip("0").rstrip(".")

    def _numbers(self, box: Box) -> list[str]:
        """Left, top, width and height of a box."""
        left, top, right, bottom = box
        return [self._number(value) for value in (left, top, right - left, bottom - top)]

    def _place(self, box: Box) -> str:
        x, y, wide, high = self._numbers(box)
        return f'x="{x}" y="{y}" width="{wide}" height="{high}"'

    def _path(self, xy: Floats, closed: bool) -> str:
        """Path data through points (n, 2) as relative moves in whole steps, without drift."""
        whole = np.rint(np.asarray(xy, dtype=np.float64) * self.steps).astype(np.int64)
        moves = np.diff(whole, axis=0)
        moves = moves[np.any(moves != 0, axis=1)]
        start = f"M{whole[0, 0] / self.steps:g} {whole[0, 1] / self.steps:g}"
        text = " ".join(f"{dx / self.steps:g} {dy / self.steps:g}" for dx, dy in moves.tolist())
        return start + (f"l{text}" if text else "h0") + ("z" if closed else "")
