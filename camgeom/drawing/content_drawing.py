"""Drawings to scale of a report page as frozen data: outlines, cut material, dimensions and notes, all in mm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, final

from camgeom.drawing.content_plot import Width
from camgeom.maths import Floats

Point = tuple[float, float]


@final
@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """An outline in mm, (n, 2). `kind`: outline, thin, hidden (dashed), axis (chain line), trace (accent), part (filled
    section), ghost (filled faintly)."""

    points: Floats
    kind: Literal["outline", "thin", "hidden", "axis", "trace", "part", "ghost"] = "outline"
    closed: bool = False
    holes: tuple[Floats, ...] = ()
    """More closed outlines (k, 2) of a filled one, left open where they lie inside it"""


@final
@dataclass(frozen=True, slots=True)
class Circle:
    """A circle in mm; kinds as in `Path`."""

    centre: Point
    radius: float
    kind: Literal["outline", "thin", "hidden", "axis", "trace", "part", "ghost"] = "outline"


@final
@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """Cut material in mm: closed outlines (k, 2), holes among them, hatched."""

    loops: tuple[Floats, ...]


@final
@dataclass(frozen=True, slots=True)
class Dimension:
    """A linear dimension from p to q (mm), drawn outside the view on the named side; `below` and `above` measure along
    x, `left` and `right` along y. Dimensions on one side are stacked clear of each other."""

    p: Point
    q: Point
    text: str
    side: Literal["below", "above", "left", "right"]


@final
@dataclass(frozen=True, slots=True)
class Leader:
    """A note beside the view with a line to the point `to` (mm): diameters, radii, names. In a narrow setting the point
    gets a number and the note stands in a list under the view."""

    to: Point
    text: str


@final
@dataclass(frozen=True, slots=True)
class Drawing:
    """A view to scale in mm, x right and y up, with dimensions and notes."""

    caption: str
    paths: tuple[Path, ...] = ()
    circles: tuple[Circle, ...] = ()
    dimensions: tuple[Dimension, ...] = ()
    leaders: tuple[Leader, ...] = ()
    regions: tuple[Region, ...] = ()
    width: Width = "full"
    stretch: bool = False
    """Fill the width with different scales along x and y (a developed view): no true angles."""
