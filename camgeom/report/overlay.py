"""Scale bar, colour bar and axes drawn over a picture, in crisp text."""

from __future__ import annotations

import re
from math import floor, log10
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from camgeom.drawing.colours import scale
from camgeom.drawing.sheet import ticks
from camgeom.immutable import immutable
from camgeom.maths import Floats

if TYPE_CHECKING:
    from PIL.Image import Image

_INK = (38, 42, 48)
_AXES = ((178, 74, 26), (0, 116, 90), (24, 92, 160))
_OVER = 2
"""Drawn this many times larger and scaled down, so that thin lines are smooth."""


@immutable(eq=True)
class ColourBar:
    """The shown field: its label with unit and its range."""

    title: str
    low: float
    high: float
    diverging: bool


def overlay(
    image: npt.NDArray[np.uint8], size: tuple[int, int], mm_per_pixel: float, axes: Floats, bar: ColourBar | None
) -> Image:
    """The picture (h, w, 3) at its final size with a scale bar of round length, the axes and the colour bar.

    mm_per_pixel  at the final size
    axes          (3, 2) the unit vectors X, Y, Z as they appear in the picture: right, up
    """
    from PIL import Image, ImageDraw

    width, height = size
    picture = Image.fromarray(image).resize(size, Image.Resampling.LANCZOS)
    layer = Image.new("RGBA", (_OVER * width, _OVER * height), (255, 255, 255, 0))
    pen = _Pen(ImageDraw.Draw(layer), _OVER * height / 1000.0)
    margin = 36.0
    bottom = 1000.0 - margin
    _draw_axes(pen, axes, (margin + 44.0, bottom - 48.0))
    _draw_length(pen, mm_per_pixel * height / 1000.0, 1000.0 * width / height, bottom)
    if bar is not None:
        _draw_colours(pen, bar, 1000.0 * width / height)
    layer = layer.resize((width, height), Image.Resampling.LANCZOS)
    picture.paste(layer, (0, 0), layer)
    return picture


@immutable(eq=True)
class _Pen:
    """Draws in thousandths of the picture's height, from the top left."""

    draw: Any
    unit: float

    def line(self, points: list[tuple[float, float]], colour: tuple[int, int, int] = _INK, width: float = 1.8) -> None:
        self.draw.line([(x * self.unit, y * self.unit) for x, y in points], (*colour, 255), round(width * self.unit))

    def box(self, x: float, y: float, w: float, h: float, colour: tuple[int, ...]) -> None:
        corners = [x * self.unit, y * self.unit, (x + w) * self.unit, (y + h) * self.unit]
        self.draw.rectangle(corners, (*(int(c) for c in colour), 255))

    def text(self, x: float, y: float, text: str, anchor: str, size: float = 24.0, colour: Any = _INK) -> None:
        """A line of text; powers stand raised. The anchor is that of pillow: across (l, m, r) and up."""
        from PIL import ImageFont

        runs = [(run, raised) for run, raised in _runs(text) if run]
        fonts = [ImageFont.load_default((_RAISED if raised else 1.0) * size * self.unit) for _, raised in runs]
        widths = [font.getlength(run) for font, (run, _) in zip(fonts, runs)]
        left = x * self.unit - sum(widths) * {"l": 0.0, "m": 0.5, "r": 1.0}[anchor[0]]
        for font, wide, (run, raised) in zip(fonts, widths, runs):
            lift = 0.35 * size * self.unit if raised else 0.0
            self.draw.text((left, y * self.unit - lift), run, (*colour, 255), font, f"l{anchor[1]}")
            left += wide


_RAISED = 0.68
"""of the size of the text, that of its powers"""
_PLAIN = str.maketrans("\N{MINUS SIGN}–×µ⌀\N{NARROW NO-BREAK SPACE}\N{NO-BREAK SPACE}", "--xuD  ")
"""signs that the typeface of the pictures lacks"""
_POWERS = "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"


def _runs(text: str) -> list[tuple[str, bool]]:
    """The text in runs of signs that the typeface has, each with whether it is raised."""
    parts = re.split(f"([{_POWERS}]+)", text)
    tables = _PLAIN, str.maketrans(_POWERS, "-0123456789")
    return [(part.translate(tables[i % 2]), bool(i % 2)) for i, part in enumerate(parts)]


def _draw_axes(pen: _Pen, axes: Floats, foot: tuple[float, float]) -> None:
    for letter, colour, (right, up) in zip("XYZ", _AXES, axes):
        length = float(np.hypot(right, up))
        if length < 0.15:  # it points at the eye
            continue
        x, y = foot[0] + 42.0 * right, foot[1] - 42.0 * up
        pen.line([foot, (x, y)], colour, 2.6)
        pen.text(x + 15.0 * right / length, y - 15.0 * up / length, letter, "mm", 22.0, colour)


def _draw_length(pen: _Pen, mm_per_unit: float, width: float, bottom: float) -> None:
    """A round length, a tenth to a quarter of the picture's height, at the bottom right."""
    longest = 250.0 * mm_per_unit
    decade = 10.0 ** floor(log10(longest))
    length = max(step * decade for step in (1.0, 2.0, 5.0) if step * decade <= longest)
    right = width - 36.0
    left = right - length / mm_per_unit
    pen.line([(left, bottom - 9.0), (left, bottom), (right, bottom), (right, bottom - 9.0)], _INK, 2.2)
    pen.text((left + right) / 2.0, bottom - 12.0, f"{length:g} mm", "ms", 24.0)


def _draw_colours(pen: _Pen, bar: ColourBar, width: float) -> None:
    """An upright bar at the right edge, its title above it."""
    top, tall, wide = 130.0, 520.0, 24.0
    left = width - 150.0
    table = scale(bar.diverging, 256)
    for i, colour in enumerate(table[::-1]):
        pen.box(left, top + tall * i / 256.0, wide, tall / 256.0, tuple(colour))
    found = ticks(bar.low, bar.high, 5, tight=True)
    for value, text in zip(found.at, found.texts):
        y = top + tall * (bar.high - value) / (bar.high - bar.low)
        pen.line([(left + wide, y), (left + wide + 7.0, y)], _INK, 1.6)
        pen.text(left + wide + 13.0, y, text, "lm", 22.0)
    factor = f" × {found.factor}".rstrip() if found.exponent else ""
    pen.text(width - 36.0, top - 34.0, bar.title + factor, "rs", 24.0)
