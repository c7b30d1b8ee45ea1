"""A sheet of paper as plain shapes in millimetres: taken from SVG sheets, written as SVG or PDF with the same styles.

The pieces of `Sheet` carry class names only; here the classes have the fixed colours and line widths of a print. Cut
faces are hatched with real lines, so that no back end needs patterns.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from html import escape
from typing import final
from xml.etree import ElementTree as ET

import numpy as np

from camgeom.drawing.sheet import FONT, Sheet
from camgeom.maths import Floats

PX = 0.25
"""mm of paper for a pixel of a sheet: text of 13 px is 3.25 mm high"""
HATCH = 3.0
"""mm between hatching lines"""


@final
@dataclass(frozen=True, slots=True)
class Style:
    """How a shape is drawn: stroke colour and width (mm), dashes (mm), fill colour; halo behind words."""

    stroke: str = ""
    width: float = 0.18
    dash: tuple[float, ...] = ()
    fill: str = ""
    halo: bool = False
    bold: bool = False


INK, SOFT, FAINT, BLUE, ORANGE, RED = "#000000", "#404448", "#c8ccd0", "#1f5fa8", "#b05a00", "#b3261e"
CHAIN, DASHED = (3.0, 0.75, 0.5, 0.75), (1.25, 0.75)
STYLES: dict[str, Style] = {
    "border": Style(INK, 0.5), "rule": Style(INK, 0.18), "heavy": Style(INK, 0.35),
    "grid": Style(FAINT, 0.13), "zone": Style(fill="#eef1f4"), "frame": Style(SOFT, 0.18), "zero": Style(SOFT, 0.18),
    "tick-line": Style(SOFT, 0.18), "leader": Style(SOFT, 0.18), "dot": Style(fill=INK), "at": Style(INK, 0.25, CHAIN),
    "limit": Style(RED, 0.3, CHAIN),
    "line": Style(INK, 0.35), "s0": Style(BLUE, 0.4), "s1": Style(ORANGE, 0.35, DASHED),
    "s2": Style(INK, 0.3, (0.6, 0.6)), "s3": Style("#6a3d9a", 0.35, CHAIN), "s4": Style(SOFT, 0.3),
    "s5": Style("#2d7a3d", 0.35, (3.5, 1.2)), "below": Style(SOFT, 0.25, DASHED),
    "d-outline": Style(INK, 0.5), "d-thin": Style(SOFT, 0.18), "d-hidden": Style(INK, 0.25, DASHED),
    "d-axis": Style(SOFT, 0.18, CHAIN), "d-trace": Style(BLUE, 0.35), "d-part": Style(INK, 0.5, fill="#ffffff"),
    "d-cut": Style(INK, 0.5), "hatch": Style(SOFT, 0.13), "d-ghost": Style(ORANGE, 0.3), "d-arrow": Style(fill=SOFT),
    "balloon": Style(fill=INK), "on-balloon": Style(fill="#ffffff", bold=True),
    "note": Style(fill=INK, halo=True), "name": Style(fill=INK, halo=True), "limit-text": Style(fill=RED, halo=True),
    "tick": Style(fill=SOFT), "faint": Style(fill=SOFT), "axis": Style(fill=INK), "words": Style(fill=INK),
    "strong": Style(fill=INK, bold=True), "": Style(fill=INK),
}  # fmt: skip
"""by class name; of several names the last known one counts"""
UNSEEN = {"cursor"}


@final
@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """Polylines (k, 2) in mm of paper, y down, drawn as one shape."""

    style: str
    lines: tuple[Floats, ...]
    closed: tuple[bool, ...]


@final
@dataclass(frozen=True, slots=True)
class Dot:
    """A circle: centre and radius, mm."""

    style: str
    centre: tuple[float, float]
    radius: float


@final
@dataclass(frozen=True, slots=True)
class Words:
    """A line of text with its baseline at (x, y), mm; size is that of the face, mm."""

    style: str
    x: float
    y: float
    text: str
    anchor: str
    size: float


Shape = Outline | Dot | Words


@final
@dataclass(slots=True)
class Paper:
    """A sheet of `width` x `height` mm with its shapes in drawing order, and the title a reader shows."""

    width: float
    height: float
    title: str = ""
    shapes: list[Shape] = field(default_factory=list)

    def place(self, sheet: Sheet, x: float, y: float) -> None:
        """Put an SVG sheet with its upper left corner at (x, y), mm."""
        root = ET.fromstring(f"<svg>{''.join(sheet.pieces)}</svg>")
        for element in root:
            self.shapes += [moved(shape, x, y) for shape in _shapes(element)]

    def lines(self, style: str, *lines: list[tuple[float, float]], closed: bool = False) -> None:
        """Polylines of one style, mm."""
        arrays = tuple(np.array(line, dtype=float) for line in lines)
        self.shapes.append(Outline(style, arrays, (closed,) * len(arrays)))

    def box(self, style: str, x0: float, y0: float, x1: float, y1: float) -> None:
        """A rectangle, mm."""
        self.lines(style, [(x0, y0), (x1, y0), (x1, y1), (x0, y1)], closed=True)

    def words(
        self, x: float, y: float, text: str, *, size: float = FONT * PX, style: str = "words", anchor: str = "start"
    ) -> None:
        """A line of text, mm."""
        self.shapes.append(Words(style, x, y, text, anchor, size))

    @property
    def ordered(self) -> list[Shape]:
        """The shapes in drawing order, words last: no line crosses them."""
        return sorted(self.shapes, key=lambda shape: isinstance(shape, Words))

    def svg(self) -> str:
        """The sheet as an SVG document at its true size."""
        body = "".join(_svg(shape) for shape in self.ordered)
        return (
            f'<?xml version="1.0" encoding="UTF-8"?>\n<svg xmlns="http://www.w3.org/2000/svg" width="{self.width:g}mm" '
            f'height="{self.height:g}mm" viewBox="0 0 {self.width:g} {self.height:g}" '
            f'font-family="Helvetica, Arial, \'Liberation Sans\', sans-serif"><title>{escape(self.title)}</title>'
            f'<rect width="{self.width:g}" height="{self.height:g}" fill="#ffffff"/>{body}</svg>\n'
        )


def style_of(classes: str) -> Style:
    """The style of a list of class names."""
    known = [name for name in classes.split() if name in STYLES]
    return STYLES[known[-1]] if known else STYLES[""]


def moved(shape: Shape, x: float, y: float) -> Shape:
    """A shape shifted on the paper, mm."""
    if isinstance(shape, Outline):
        return replace(shape, lines=tuple(line + np.array([x, y]) for line in shape.lines))
    if isinstance(shape, Dot):
        return replace(shape, centre=(shape.centre[0] + x, shape.centre[1] + y))
    return replace(shape, x=shape.x + x, y=shape.y + y)


def _shapes(element: ET.Element) -> list[Shape]:
    """The shapes of one SVG element of a sheet; pixels become mm."""
    style = element.get("class", "")
    if element.tag in ("g", "svg"):  # an inner svg only clips, at the same scale
        return [shape for child in element for shape in _shapes(child)]
    if set(style.split()) & UNSEEN:
        return []
    number = {key: float(element.get(key, "0")) * PX for key in ("x", "y", "width", "height", "cx", "cy", "r")}
    if element.tag == "text":
        size = float(element.get("font-size", str(FONT))) * PX
        anchor = element.get("text-anchor", "start")
        return [Words(style, number["x"], number["y"], "".join(element.itertext()), anchor, size)]
    if element.tag == "circle":
        return [Dot(style, (number["cx"], number["cy"]), number["r"])]
    if element.tag == "rect":
        x, y, w, h = (number[key] for key in ("x", "y", "width", "height"))
        return [Outline(style, (np.array([[x, y], [x + w, y], [x + w, y + h], [x, y + h]]),), (True,))]
    lines, closed = _path(element.get("d", ""))
    if not lines:
        return []
    outline = Outline(style, tuple(PX * line for line in lines), closed)
    if "d-cut" in style.split():
        return [Outline("hatch", hatching(outline.lines), ()), outline]
    return [outline]


_TOKEN = re.compile(r"[MLHVZlhz]|-?\d+(?:\.\d+)?(?:e-?\d+)?")


def _path(data: str) -> tuple[list[Floats], tuple[bool, ...]]:
    """Polylines of the path commands that sheets use: M L H V l h z."""
    lines: list[list[tuple[float, float]]] = []
    closed: list[bool] = []
    tokens = _TOKEN.findall(data)
    at, command = 0, ""
    x = y = 0.0
    while at < len(tokens):
        if tokens[at].isalpha():
            command = tokens[at]
            at += 1
            if command in "zZ":
                closed[-1] = True
                continue
        count = 1 if command in "HVh" else 2
        values = [float(token) for token in tokens[at : at + count]]
        at += count
        if command == "H":
            x = values[0]
        elif command == "V":
            y = values[0]
        elif command == "h":
            x += values[0]
        elif command == "l":
            x, y = x + values[0], y + values[1]
        else:
            x, y = values
        if command == "M":
            lines.append([])
            closed.append(False)
        lines[-1].append((x, y))
    return [np.array(line) for line in lines], tuple(closed)


def hatching(loops: tuple[Floats, ...], spacing: float = HATCH) -> tuple[Floats, ...]:
    """Lines at 45 degrees inside closed outlines (even-odd), mm."""
    starts = np.concatenate(loops)
    ends = np.concatenate([np.roll(loop, -1, axis=0) for loop in loops])
    # Along (1, -1) lines run upwards to the right on paper; `across` numbers them.
    across_a, across_b = starts.sum(axis=1), ends.sum(axis=1)
    along_a, along_b = starts[:, 0] - starts[:, 1], ends[:, 0] - ends[:, 1]
    step = spacing * np.sqrt(2.0)
    found = []
    first = np.ceil(min(across_a.min(), across_b.min()) / step)
    for level in np.arange(first, max(across_a.max(), across_b.max()) / step) * step:
        cut = (across_a > level) != (across_b > level)
        share = (level - across_a[cut]) / (across_b[cut] - across_a[cut])
        crossings = np.sort(along_a[cut] + share * (along_b[cut] - along_a[cut]))
        for low, high in zip(crossings[::2], crossings[1::2]):
            found.append(0.5 * np.array([[level + low, level - low], [level + high, level - high]]))
    return tuple(found)


def _svg(shape: Shape) -> str:
    style = style_of(shape.style)
    if isinstance(shape, Words):
        weight = ' font-weight="bold"' if style.bold else ""
        halo = f' stroke="#ffffff" stroke-width="{0.25 * shape.size:.3f}" paint-order="stroke"' if style.halo else ""
        anchor = f' text-anchor="{shape.anchor}"' if shape.anchor != "start" else ""
        place = f'x="{shape.x:.3f}" y="{shape.y:.3f}" font-size="{shape.size:.3f}"'
        return f'<text {place}{anchor}{weight}{halo} fill="{style.fill}">{escape(shape.text)}</text>'
    paint = f'fill="{style.fill or "none"}"'
    if style.stroke:
        dash = f' stroke-dasharray="{" ".join(map(str, style.dash))}"' if style.dash else ""
        paint += f' stroke="{style.stroke}" stroke-width="{style.width:g}"{dash}'
    if isinstance(shape, Dot):
        x, y = shape.centre
        return f'<circle cx="{x:.3f}" cy="{y:.3f}" r="{shape.radius:.3f}" {paint}/>'
    ends = [*shape.closed, *(False,) * (len(shape.lines) - len(shape.closed))]
    data = "".join(
        "M" + "L".join(f"{x:.3f} {y:.3f}" for x, y in line.tolist()) + ("Z" if closed else "")
        for line, closed in zip(shape.lines, ends)
    )
    return f'<path d="{data}" fill-rule="evenodd" stroke-linejoin="round" {paint}/>'
