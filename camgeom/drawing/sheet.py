"""A sheet of SVG text and lines that knows where its words stand, so that no two of them overlap.

Colours are CSS classes (report.css): the same drawing serves light, dark and print. Text widths come from the advance
widths of a wide common typeface, so the estimate is on the safe side for the faces a browser falls back to.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from html import escape
from typing import Literal, final

import numpy as np

from camgeom.maths import Floats

FONT = 13.0
"""px, the text size of every plot"""
ASCENT, DESCENT = 0.80, 0.24
"""of the font size: the box a line of text is kept clear in"""

_WIDTHS = {
    0.33: "iljI|.,:;'!` \N{NARROW NO-BREAK SPACE}\N{NO-BREAK SPACE}",
    0.42: 'ftr()[]/\\-"°¹²³',
    0.56: "ckszvxyJ?_⁻⁰⁴⁵⁶⁷⁸⁹",
    0.66: "abdeghnopquLFTE0123456789$#*~αβγδεζηθκλνξπρστυχ",
    0.73: "PSXYZABCKRVD&",
    0.85: "GHMNOQUw+−=<>×≤≥≈φωψΔΣΩ",
    1.02: "mW@%",
}
_ADVANCE = {char: width for width, chars in _WIDTHS.items() for char in chars}

Anchor = Literal["start", "middle", "end"]
Box = tuple[float, float, float, float]


def text_width(text: str, size: float = FONT) -> float:
    """Width of a line of text, px, not less than common sans-serif faces set it."""
    return size * sum(_ADVANCE.get(char, 0.75) for char in text)


def text_box(x: float, y: float, text: str, anchor: Anchor = "start", size: float = FONT) -> Box:
    """Left, top, right, bottom (px) of a line of text with its baseline at y."""
    width = text_width(text, size)
    left = x - width * {"start": 0.0, "middle": 0.5, "end": 1.0}[anchor]
    return left, y - ASCENT * size, left + width, y + DESCENT * size


def overlap(a: Box, b: Box, gap: float = 0.0) -> float:
    """Area two boxes share, px², with `gap` px demanded between them."""
    wide = min(a[2], b[2]) - max(a[0], b[0]) + gap
    high = min(a[3], b[3]) - max(a[1], b[1]) + gap
    return wide * high if wide > 0.0 and high > 0.0 else 0.0


def outside(box: Box, frame: Box) -> float:
    """How far a box leaves a frame, px; 0 where it lies inside."""
    return max(frame[0] - box[0], frame[1] - box[1], box[2] - frame[2], box[3] - frame[3], 0.0)


@final
@dataclass(slots=True)
class Sheet:
    """A drawing being written: `width` x `height` px, its pieces in order and the boxes its words occupy."""

    width: float
    height: float
    pieces: list[str] = field(default_factory=list)
    words: list[tuple[Box, str]] = field(default_factory=list)

    def add(self, piece: str) -> None:
        """Append markup that is already safe."""
        self.pieces.append(piece)

    def text(self, x: float, y: float, text: str, anchor: Anchor = "start", style: str = "", size: float = FONT) -> Box:
        """Write a line of text with its baseline at y and keep its box."""
        box = text_box(x, y, text, anchor, size)
        self.words.append((box, text))
        attributes = f' class="{style}"' if style else ""
        attributes += f' text-anchor="{anchor}"' if anchor != "start" else ""
        attributes += f' font-size="{size:g}"' if size != FONT else ""
        self.add(f'<text x="{px(x)}" y="{px(y)}"{attributes}>{escape(text)}</text>')
        return box

    def line(self, x0: float, y0: float, x1: float, y1: float, style: str) -> None:
        """A straight line."""
        self.add(f'<path class="{style}" d="M{px(x0)} {px(y0)}L{px(x1)} {px(y1)}"/>')

    def polyline(self, xy: Floats, style: str, *, closed: bool = False, extra: str = "") -> None:
        """A line through points (n, 2), px."""
        self.add(f'<path class="{style}" d="{path_data(xy, closed=closed)}"{extra}/>')

    def rect(self, box: Box, style: str) -> None:
        """A rectangle."""
        x0, y0, x1, y1 = box
        self.add(f'<rect class="{style}" x="{px(x0)}" y="{px(y0)}" width="{px(x1 - x0)}" height="{px(y1 - y0)}"/>')

    def dot(self, x: float, y: float, radius: float, style: str) -> None:
        """A filled circle."""
        self.add(f'<circle class="{style}" cx="{px(x)}" cy="{px(y)}" r="{px(radius)}"/>')

    def clash(self, box: Box, gap: float = 2.0) -> float:
        """Area (px²) of a box that words already cover."""
        return sum(overlap(box, other, gap) for other, _ in self.words)

    def render(self, title: str, style: str = "") -> str:
        """The SVG element; `title` is its name for screen readers."""
        return (
            f'<svg class="plot {style}" viewBox="0 0 {px(self.width)} {px(self.height)}" width="{px(self.width)}" '
            f'height="{px(self.height)}" role="img" aria-label="{escape(title)}" font-size="{FONT:g}">'
            + "".join(self.pieces)
            + "</svg>"
        )


def px(value: float) -> str:
    """A coordinate to a tenth of a pixel."""
    text = f"{value:.1f}"
    return text[:-2] if text.endswith(".0") else text


def path_data(xy: Floats, *, closed: bool = False) -> str:
    """SVG path through points (n, 2), px, as relative moves in tenths of a pixel without drift."""
    tenths = np.rint(np.asarray(xy, dtype=np.float64) * 10.0).astype(np.int64)
    steps = np.diff(tenths, axis=0)
    steps = steps[np.any(steps != 0, axis=1)]
    start = f"M{tenths[0, 0] / 10:g} {tenths[0, 1] / 10:g}"
    moves = " ".join(f"{dx / 10:g} {dy / 10:g}" for dx, dy in steps.tolist())
    return start + (f"l{moves}" if moves else "h0") + ("z" if closed else "")


def thin_line(x: Floats, y: Floats, tolerance: float = 0.15, bucket: float = 1.0) -> Floats:
    """Points (k, 2) that draw the same line as x, y (px, x rising) to `tolerance`.

    Dense histories keep the first, last, lowest and highest point of each pixel column; then points on straight runs
    are dropped.
    """
    if len(x) > 4.0 * max((x[-1] - x[0]) / bucket, 1.0):
        column = np.floor((x - x[0]) / bucket).astype(np.int64)
        starts = np.flatnonzero(np.r_[True, column[1:] != column[:-1]])
        ends = np.r_[starts[1:], len(x)] - 1
        order = np.lexsort((y, column))
        keep = np.unique(np.concatenate([starts, ends, order[starts], order[ends]]))
        x, y = x[keep], y[keep]
    return straightened(np.column_stack([x, y]), tolerance)


def straightened(xy: Floats, tolerance: float = 0.15) -> Floats:
    """Those points (k, 2) of a line that keep it within `tolerance`; its ends stay."""
    keep = np.zeros(len(xy), dtype=bool)
    keep[[0, -1]] = True
    stack = [(0, len(xy) - 1)]
    while stack:
        first, last = stack.pop()
        if last - first < 2:
            continue
        chord = xy[last] - xy[first]
        length = float(np.hypot(*chord))
        away = xy[first + 1 : last] - xy[first]
        if length > 0.0:
            distance = np.abs(away[:, 0] * chord[1] - away[:, 1] * chord[0]) / length
        else:
            distance = np.hypot(away[:, 0], away[:, 1])
        worst = int(np.argmax(distance))
        if distance[worst] > tolerance:
            middle = first + 1 + worst
            keep[middle] = True
            stack += [(first, middle), (middle, last)]
    return np.asarray(xy[keep])
