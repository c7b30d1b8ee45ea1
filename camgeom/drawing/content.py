"""What a report page says, as frozen data with no layout and no cam facts: the renderer draws it, the sections fill it.

Lengths of arrays are checked where they are made, so a page that exists can be drawn. Text is plain text everywhere;
the renderer escapes it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import final

from camgeom.drawing.content_drawing import Circle, Dimension, Drawing, Leader, Path, Point, Region
from camgeom.drawing.content_plot import (
    CAM_ANGLE,
    Axis,
    Band,
    Chart,
    Limit,
    Map,
    Mark,
    Panel,
    Polar,
    Series,
    Width,
    Zone,
)
from camgeom.drawing.content_scene import Body, Scene, Shade

__all__ = [
    "CAM_ANGLE",
    "Axis",
    "Band",
    "Block",
    "Body",
    "Cell",
    "Chart",
    "Circle",
    "Column",
    "Cost",
    "Dimension",
    "Drawing",
    "Figure",
    "Finding",
    "Leader",
    "Limit",
    "Map",
    "Mark",
    "Page",
    "Panel",
    "Path",
    "Point",
    "Polar",
    "Region",
    "Scene",
    "Section",
    "Series",
    "Shade",
    "Table",
    "Text",
    "Width",
    "Zone",
]

Cell = str | float | int | bool | None
"""A table cell: text, a number (set right, four significant digits), a verdict (True passes), or nothing."""


@final
@dataclass(frozen=True, slots=True)
class Finding:
    """One judged fact: what was checked, its value against its limit, where it occurs and what to do about it."""

    check: str
    passed: bool
    value: Cell = None
    limit: Cell = None
    unit: str = ""
    where: str = ""
    advice: str = ""


@final
@dataclass(frozen=True, slots=True)
class Figure:
    """A key figure: label, value, unit, and one short line of context."""

    label: str
    value: Cell
    unit: str = ""
    note: str = ""


@final
@dataclass(frozen=True, slots=True)
class Column:
    """A table column: heading and unit."""

    label: str
    unit: str = ""


@final
@dataclass(frozen=True, slots=True)
class Table:
    """Rows under headings; numbers are set right, text left."""

    caption: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    width: Width = "full"

    def __post_init__(self) -> None:
        if any(len(row) != len(self.columns) for row in self.rows):
            raise ValueError(f"table {self.caption!r}: a row does not fit its {len(self.columns)} columns")


@final
@dataclass(frozen=True, slots=True)
class Text:
    """Paragraphs of plain text."""

    paragraphs: tuple[str, ...]


@final
@dataclass(frozen=True, slots=True)
class Cost:
    """What was computed and the seconds it took, and what nobody asked for."""

    computed: tuple[tuple[str, float], ...]
    skipped: tuple[str, ...] = ()


Block = Text | Table | Chart | Map | Polar | Drawing | Scene | Cost


@final
@dataclass(frozen=True, slots=True)
class Section:
    """A numbered section: `key` is its anchor and its name for `--only`."""

    key: str
    title: str
    blocks: tuple[Block, ...]


@final
@dataclass(frozen=True, slots=True)
class Page:
    """A whole report: verdict first, then key figures, then sections. `details` fills the title block."""

    title: str
    kind: str
    passed: bool | None
    """None where nothing was judged"""
    summary: str = ""
    findings: tuple[Finding, ...] = ()
    figures: tuple[Figure, ...] = ()
    sections: tuple[Section, ...] = ()
    details: tuple[tuple[str, str], ...] = field(default=())
