"""A sheet of text and lines that knows where its words stand, so that no two of them overlap; and numbers as texts.

Colours are CSS classes (report.css): the same drawing serves light, dark and print. Text widths come from the advance
widths of a wide common typeface, so the estimate is on the safe side for the faces a browser falls back to.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from html import escape
from typing import final

import numpy as np

from camgeom.drawing.shapes import Anchor, Box, Pen, Segments, Shape, Words
from camgeom.maths import Floats, distinct

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

THIN = "\N{NARROW NO-BREAK SPACE}"
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)
_DEGREE_STEPS = (1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 60.0, 90.0, 180.0, 360.0, 720.0)
_FLAT = 1e-7
"""a range this small against its values is rounding noise and is shown as a constant"""
_PLAIN = (1e-3, 1e7)


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
    shapes: list[Shape] = field(default_factory=list)
    words: list[tuple[Box, str]] = field(default_factory=list)

    def add(self, *shapes: Shape) -> None:
        """Append shapes."""
        self.shapes += shapes

    def text(self, x: float, y: float, text: str, anchor: Anchor = "start", style: str = "", size: float = FONT) -> Box:
        """Write a line of text with its baseline at y and keep its box."""
        box = text_box(x, y, text, anchor, size)
        self.words.append((box, text))
        self.add(Words(style, x, y, text, anchor, size))
        return box

    def line(self, x0: float, y0: float, x1: float, y1: float, style: str) -> None:
        """A straight line."""
        self.add(Segments(style, np.array([[[x0, y0], [x1, y1]]])))

    def clash(self, box: Box, gap: float = 2.0) -> float:
        """Area (px²) of a box that words already cover."""
        left, top, right, bottom = box[0] - gap, box[1] - gap, box[2] + gap, box[3] + gap
        beside = (other for other, _ in self.words if other[0] < right and left < other[2])
        return sum(overlap(box, other, gap) for other in beside if other[1] < bottom and top < other[3])

    def render(self, title: str, style: str = "") -> str:
        """The SVG element; `title` is its name for screen readers."""
        x, y = f"{self.width:.1f}".removesuffix(".0"), f"{self.height:.1f}".removesuffix(".0")
        return (
            f'<svg class="plot {style}" viewBox="0 0 {x} {y}" width="{x}" height="{y}" role="img" '
            f'aria-label="{escape(title)}" font-size="{FONT:g}">{"".join(map(_PAGE.svg, self.shapes))}</svg>'
        )


_PAGE = Pen(lambda shape: f' class="{shape.style}"' if shape.style else "", 10, FONT)
"""classes of report.css, coordinates to a tenth of a pixel"""


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
        keep = distinct(np.concatenate([starts, ends, order[starts], order[ends]]))
        x, y = x[keep], y[keep]
    return straightened(np.column_stack([x, y]), tolerance)


def straightened(xy: Floats, tolerance: float = 0.15) -> Floats:
    """Those points (k, 2) of a line that keep it within `tolerance`; its ends stay.

    Every stretch whose chord leaves a point out by more is split there (Ramer, Douglas and Peucker), all at once.
    """
    if len(xy) < 3:
        return xy
    keep = np.array([0, len(xy) - 1])
    while True:
        count = np.diff(keep)
        first, last = np.repeat(keep[:-1], count), np.repeat(keep[1:], count)
        begin = xy.take(first, axis=0)
        chord, away = xy.take(last, axis=0) - begin, xy[first[0] : last[-1]] - begin
        length = np.sqrt(np.einsum("ij,ij->i", chord, chord))
        closed = length == 0.0
        distance = np.abs(away[:, 0] * chord[:, 1] - away[:, 1] * chord[:, 0]) / np.where(closed, 1.0, length)
        if closed.any():
            distance[closed] = np.hypot(*away[closed].T)
        worst = np.maximum.reduceat(distance, keep[:-1])
        split = np.flatnonzero((distance == np.repeat(worst, count)) & (distance > tolerance))
        # Of several equally far points of a stretch the first.
        split = split[np.unique(first[split], return_index=True)[1]]
        if not len(split):
            return np.asarray(xy[keep])
        keep = np.sort(np.concatenate([keep, split]))


def number(value: float, digits: int = 4) -> str:
    """Text of a number with at most `digits` significant digits, trailing zeros of a fraction dropped.

    >>> number(1234567.0), number(-0.00012345), number(37.0)
    ('1\u202f235\u202f000', '−1.234 × 10⁻⁴', '37')
    """
    if isinstance(value, int) and abs(value) < 1e15:
        return _grouped(str(value))
    if not math.isfinite(value):
        return "unbounded" if value > 0 else "unbounded below" if value < 0 else "not defined"
    if value == 0.0:
        return "0"
    rounded = float(f"{value:.{digits}g}")
    exponent = math.floor(math.log10(abs(rounded)))
    if not _PLAIN[0] <= abs(rounded) < _PLAIN[1]:
        mantissa = _trim(f"{rounded / 10.0**exponent:.{digits - 1}f}")
        return _sign(f"{mantissa} × 10{str(exponent).translate(_SUPERSCRIPT)}")
    return _grouped(_trim(f"{rounded:.{max(digits - 1 - exponent, 0)}f}"))


def decimals(value: float, places: int) -> str:
    """Text of a number with exactly `places` decimals.

    >>> decimals(-12345.678, 1)
    '−12\u202f345.7'
    """
    text = f"{value:.{places}f}"
    return _grouped(text.lstrip("-") if float(text) == 0.0 else text)


def _trim(text: str) -> str:
    return text.rstrip("0").rstrip(".") if "." in text else text


def _sign(text: str) -> str:
    return text.replace("-", "−", 1)


def _grouped(text: str) -> str:
    whole, point, fraction = text.lstrip("-").partition(".")
    if len(whole) > 4:
        whole = f"{int(whole):,}".replace(",", THIN)
    return ("−" if text.startswith("-") else "") + whole + point + fraction


@final
@dataclass(frozen=True, slots=True, eq=False)
class Ticks:
    """Round tick values over a range, the range they close, their texts and the power of ten they share."""

    low: float
    high: float
    at: Floats
    texts: tuple[str, ...]
    exponent: int = 0

    @property
    def factor(self) -> str:
        """`10³ ` where the texts are in thousands, else empty; it precedes the unit."""
        return f"10{str(self.exponent).translate(_SUPERSCRIPT)}" if self.exponent else ""


def ticks(low: float, high: float, count: int, *, unit: str = "", tight: bool = False) -> Ticks:
    """Ticks at a round step, at most about `count`; the range grows to the outer ticks unless `tight`.

    >>> ticks(0.0, 360.0, 9, unit="°", tight=True).texts
    ('0', '45', '90', '135', '180', '225', '270', '315', '360')
    """
    if not high - low > _FLAT * max(abs(low), abs(high)):
        pad = abs(low) * 0.1 or 1.0
        low, high = low - pad, high + pad
    raw = (high - low) / max(count, 1)
    step = _degree_step(raw) if unit in ("°", "deg") and 1.0 <= raw <= 720.0 else _step(raw)
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    if not tight:
        first, last = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
        low, high = first * step, last * step
    at = np.asarray(np.arange(first, last + 1) * step, dtype=np.float64)
    exponent = _shared_exponent(at)
    places = max(0, -math.floor(math.log10(step / 10.0**exponent) + 1e-9))
    if step / 10.0**exponent * 10.0**places % 1.0 > 1e-6:  # a step of 2.5 needs one place more than its power of ten
        places += 1
    return Ticks(low, high, at, tuple(decimals(v / 10.0**exponent, places) for v in at), exponent)


def _step(raw: float) -> float:
    power: float = 10.0 ** math.floor(math.log10(raw))
    return next(s for s in _STEPS if s * power >= raw * (1.0 - 1e-9)) * power


def _degree_step(raw: float) -> float:
    return next(s for s in _DEGREE_STEPS if s >= raw * (1.0 - 1e-9))


def _shared_exponent(at: Floats) -> int:
    largest = float(np.max(np.abs(at)))
    if largest == 0.0 or _PLAIN[0] <= largest < _PLAIN[1]:
        return 0
    return 3 * math.floor(math.log10(largest) / 3.0)
