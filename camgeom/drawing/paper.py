"""A sheet of paper: shapes in millimetres, taken from sheets of pixels, written as SVG or PDF with the same styles.

Shapes carry style names only; here the styles have the fixed colours and line widths of a print. Cut
faces are hatched with real lines, so that neither writer needs patterns. PDF 1.4 (ISO 32000's predecessor), units of
1/72 inch, y upwards; the fourteen standard faces need no embedding, and their advance widths (thousandths of the size)
are those of the published Adobe font metrics.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass, field, replace
from html import escape
from typing import final

import numpy as np

from camgeom.drawing.shapes import (
    Anchor,
    Cursor,
    Dot,
    GridLines,
    Lines,
    Painted,
    Pen,
    Picture,
    Rectangle,
    Shape,
    Window,
    Words,
)
from camgeom.drawing.sheet import FONT, Sheet
from camgeom.maths import Floats

PX = 0.25
"""mm of paper for a pixel of a sheet: text of 13 px is 3.25 mm high"""
HATCH = 3.0
"""mm between hatching lines"""

POINT = 72.0 / 25.4
CIRCLE = 0.5522847498
"""length of a cubic's handle over the radius for a quarter circle"""
INSTEAD = str.maketrans(
    {"\N{NARROW NO-BREAK SPACE}": " ", "\N{NO-BREAK SPACE}": " ", "−": "-", "⌀": "Ø", "≤": "<=", "≥": ">=", "≈": "~",
     "⁻": "-", "⁰": "0", "⁴": "4", "⁵": "5", "⁶": "6", "⁷": "7", "⁸": "8", "⁹": "9"}
)  # fmt: skip
"""signs that the standard encoding lacks"""
_WIDTHS = (
    "278 278 355 556 556 889 667 191 333 333 389 584 278 333 278 278 556 556 556 556 556 556 556 556 556 556 278 278 "
    "584 584 584 556 1015 667 667 722 722 667 611 778 722 278 500 667 556 833 722 778 667 778 722 667 611 722 667 944 "
    "667 667 611 278 278 278 469 556 333 556 556 500 556 556 278 556 556 222 222 500 222 833 556 556 556 556 333 500 "
    "278 556 500 722 500 500 500 334 260 334 584"
)
ADVANCE = {chr(32 + k): int(width) for k, width in enumerate(_WIDTHS.split())}
ADVANCE |= {"°": 400, "²": 333, "³": 333, "¹": 333, "×": 584, "Ø": 778, "±": 584, "·": 278, "µ": 556}


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
Printed = Lines | Dot | Words
"""the shapes that paper bears"""


@final
@dataclass(slots=True)
class Paper:
    """A sheet of `width` x `height` mm with its shapes in drawing order, and the title a reader shows."""

    width: float
    height: float
    title: str = ""
    shapes: list[Printed] = field(default_factory=list)

    def place(self, sheet: Sheet, x: float, y: float) -> None:
        """Put an SVG sheet with its upper left corner at (x, y), mm."""
        for shape in sheet.shapes:
            self.shapes += _printed(shape, np.array([x, y]))

    def lines(self, style: str, *lines: list[tuple[float, float]], closed: bool = False) -> None:
        """Polylines of one style, mm."""
        arrays = tuple(np.array(line, dtype=float) for line in lines)
        self.shapes.append(Lines(style, arrays, closed))

    def box(self, style: str, x0: float, y0: float, x1: float, y1: float) -> None:
        """A rectangle, mm."""
        self.lines(style, [(x0, y0), (x1, y0), (x1, y1), (x0, y1)], closed=True)

    def words(
        self, x: float, y: float, text: str, *, size: float = FONT * PX, style: str = "words", anchor: Anchor = "start"
    ) -> None:
        """A line of text, mm."""
        self.shapes.append(Words(style, x, y, text, anchor, size))

    @property
    def ordered(self) -> list[Printed]:
        """The shapes in drawing order, words last: no line crosses them."""
        return sorted(self.shapes, key=lambda shape: isinstance(shape, Words))

    def svg(self) -> str:
        """The sheet as an SVG document at its true size."""
        body = "".join(map(_PEN.svg, self.ordered))
        return (
            f'<?xml version="1.0" encoding="UTF-8"?>\n<svg xmlns="http://www.w3.org/2000/svg" width="{self.width:g}mm" '
            f'height="{self.height:g}mm" viewBox="0 0 {self.width:g} {self.height:g}" '
            f"font-family=\"Helvetica, Arial, 'Liberation Sans', sans-serif\"><title>{escape(self.title)}</title>"
            f'<rect width="{self.width:g}" height="{self.height:g}" fill="#ffffff"/>{body}</svg>\n'
        )


def style_of(classes: str) -> Style:
    """The style of a list of class names."""
    known = [name for name in classes.split() if name in STYLES]
    return STYLES[known[-1]] if known else STYLES[""]


def _printed(shape: Shape, corner: Floats) -> list[Printed]:
    """What a shape of a sheet leaves on paper, in mm, with the sheet's upper left corner there.

    A window stands open, since no line that is printed leaves it; pictures and cursors are for screens.
    """
    if isinstance(shape, Words):
        x, y = (corner + PX * np.array([shape.x, shape.y])).tolist()
        return [replace(shape, x=x, y=y, size=PX * shape.size)]
    if isinstance(shape, Dot):
        x, y = (corner + PX * np.array(shape.centre)).tolist()
        return [Dot(shape.style, (x, y), PX * shape.radius)]
    if isinstance(shape, Window):
        return [printed for inner in shape.shapes for printed in _printed(inner, corner)]
    if isinstance(shape, Picture | Cursor):
        return []
    if isinstance(shape, Lines):
        lines = Lines(shape.style, tuple(corner + PX * line for line in shape.lines), shape.closed, shape.even_odd)
        return [Lines("hatch", hatching(lines.lines)), lines] if shape.style == "d-cut" else [lines]
    if isinstance(shape, Rectangle):
        x0, y0, x1, y1 = shape.box
        ends = np.array([[[x0, y0], [x1, y0], [x1, y1], [x0, y1]]])
    elif isinstance(shape, GridLines):
        x0, y0, x1, y1 = shape.box
        ends = np.array([[[x, y0], [x, y1]] for x in shape.x] + [[[x0, y], [x1, y]] for y in shape.y])
    else:
        ends = shape.ends
    return [Lines(shape.style, tuple(corner + PX * ends), closed=isinstance(shape, Rectangle))]


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


def _paint(shape: Painted) -> str:
    """The style of a shape on paper as attributes."""
    style = style_of(shape.style)
    if isinstance(shape, Words):
        weight = ' font-weight="bold"' if style.bold else ""
        halo = f' stroke="#ffffff" stroke-width="{0.25 * shape.size:.3f}" paint-order="stroke"' if style.halo else ""
        return f'{weight}{halo} fill="{style.fill}"'
    paint = f' fill="{style.fill or "none"}"'
    if style.stroke:
        dash = f' stroke-dasharray="{" ".join(map(str, style.dash))}"' if style.dash else ""
        paint += f' stroke="{style.stroke}" stroke-width="{style.width:g}" stroke-linejoin="round"{dash}'
    return paint


_PEN = Pen(_paint, 1000)
"""coordinates to a thousandth of a millimetre"""


def pdf(paper: Paper) -> bytes:
    """The sheet as a PDF document; the same sheet gives the same bytes."""
    content = zlib.compress("\n".join(_drawn(paper, shape) for shape in paper.ordered).encode("cp1252", "replace"), 9)
    page = f"<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {paper.width * POINT:.3f} {paper.height * POINT:.3f}] "
    page += "/Contents 4 0 R /Resources << /Font << /F1 5 0 R /F2 6 0 R >> >> >>"
    face = "<< /Type /Font /Subtype /Type1 /BaseFont /{} /Encoding /WinAnsiEncoding >>"
    objects = [
        b"<< /Type /Catalog /Pages 2 0 R >>",
        b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        page.encode(),
        f"<< /Length {len(content)} /Filter /FlateDecode >>\nstream\n".encode() + content + b"\nendstream",
        face.format("Helvetica").encode(),
        face.format("Helvetica-Bold").encode(),
        b"<< /Title " + b"(" + _literal(paper.title) + b") /Producer (camgeom) >>",
    ]
    out = bytearray(b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n")
    places = []
    for number, body in enumerate(objects, start=1):
        places.append(len(out))
        out += f"{number} 0 obj\n".encode() + body + b"\nendobj\n"
    start = len(out)
    out += f"xref\n0 {len(objects) + 1}\n0000000000 65535 f \n".encode()
    out += b"".join(f"{place:010d} 00000 n \n".encode() for place in places)
    out += f"trailer\n<< /Size {len(objects) + 1} /Root 1 0 R /Info 7 0 R >>\nstartxref\n{start}\n%%EOF\n".encode()
    return bytes(out)


def advance(text: str, size: float) -> float:
    """Width of a line of text in Helvetica, in the unit of the size."""
    return size * 1e-3 * sum(ADVANCE.get(char, 556) for char in text.translate(INSTEAD))


def _literal(text: str) -> bytes:
    """The text of a string object: WinAnsi, with brackets and backslashes escaped."""
    plain = text.translate(INSTEAD).encode("cp1252", "replace")
    return plain.replace(b"\\", b"\\\\").replace(b"(", b"\\(").replace(b")", b"\\)")


def _drawn(paper: Paper, shape: Printed) -> str:
    """Drawing operators of a shape."""
    style = style_of(shape.style)
    if isinstance(shape, Words):
        return _text(paper, shape, style)
    path = _circle(paper, shape) if isinstance(shape, Dot) else _polylines(paper, shape)
    paint = {(True, True): "B*", (True, False): "f*", (False, True): "S"}.get((bool(style.fill), bool(style.stroke)))
    if not path or paint is None:
        return ""
    setting = f"{_colour(style.fill, 'rg')} " if style.fill else ""
    if style.stroke:
        dash = " ".join(f"{POINT * part:.3f}" for part in style.dash)
        setting += f"{_colour(style.stroke, 'RG')} {POINT * style.width:.3f} w [{dash}] 0 d 1 j "
    return f"{setting}{path} {paint}"


def _colour(text: str, operator: str) -> str:
    parts = (int(text[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
    return " ".join(f"{part:.3f}" for part in parts) + f" {operator}"


def _polylines(paper: Paper, shape: Lines) -> str:
    parts = []
    for line in shape.lines:
        points = [f"{POINT * x:.3f} {POINT * (paper.height - y):.3f}" for x, y in line.tolist()]
        parts.append(
            " ".join([f"{points[0]} m", *(f"{point} l" for point in points[1:]), *(["h"] if shape.closed else [])])
        )
    return " ".join(parts)


def _circle(paper: Paper, shape: Dot) -> str:
    x, y = POINT * shape.centre[0], POINT * (paper.height - shape.centre[1])
    r, k = POINT * shape.radius, POINT * shape.radius * CIRCLE
    quarters = [
        (x + r, y + k, x + k, y + r, x, y + r),
        (x - k, y + r, x - r, y + k, x - r, y),
        (x - r, y - k, x - k, y - r, x, y - r),
        (x + k, y - r, x + r, y - k, x + r, y),
    ]
    curves = " ".join(" ".join(f"{value:.3f}" for value in quarter) + " c" for quarter in quarters)
    return f"{x + r:.3f} {y:.3f} m {curves} h"


def _text(paper: Paper, words: Words, style: Style) -> str:
    share = {"start": 0.0, "middle": 0.5, "end": 1.0}[words.anchor]
    x = words.x - share * advance(words.text, words.size)
    place = f"{POINT * x:.3f} {POINT * (paper.height - words.y):.3f} Td"
    text = f"({_literal(words.text).decode('cp1252')}) Tj"
    face = f"/F{2 if style.bold else 1} {POINT * words.size:.3f} Tf"
    halo = f"1 1 1 RG {0.25 * POINT * words.size:.3f} w [] 0 d 1 j BT {face} 1 Tr {place} {text} ET "
    halo = halo if style.halo else ""
    return f"{halo}{_colour(style.fill, 'rg')} BT {face} 0 Tr {place} {text} ET"
