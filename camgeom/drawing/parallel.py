"""Parallel coordinates as SVG: one upright axis a quantity, each with its own scale, a line across them a row."""

from __future__ import annotations

import numpy as np

from camgeom.drawing.content import Axis, Parallel
from camgeom.drawing.plots import axis_title
from camgeom.drawing.shapes import Lines
from camgeom.drawing.sheet import FONT, Sheet, Ticks, text_width, ticks
from camgeom.maths import Floats

_LINE = 1.4 * FONT
_HEIGHT = 240.0
_APART = 96.0
"""px between two axes at least; where they do not fit, they stand in rows"""


def parallel_sheet(chart: Parallel, width: float) -> Sheet:
    """The plot set at a width, px; axes that do not fit beside each other go on in the next row."""
    gaps = len(chart.axes) - 1
    rows = max(1, -(-gaps // max(1, int(width / _APART) - 1)))
    each = -(-gaps // rows)
    step = _HEIGHT + 3.0 * _LINE + 2.0 * FONT
    sheet = Sheet(width, rows * step)
    for row in range(rows):
        # The last axis of a row begins the next, so that every line can be followed.
        _draw_row(sheet, chart, range(row * each, min((row + 1) * each, gaps) + 1), row * step)
    return sheet


def _draw_row(sheet: Sheet, chart: Parallel, columns: range, top: float) -> None:
    """The axes of one row, below their names, with the lines across them; the chosen one over the others."""
    scales = [_scale(chart.axes[i], chart.lines[:, i]) for i in columns]
    left = max(0.5 * _APART, max(map(text_width, scales[0].texts)) + 8.0)
    at = np.linspace(left, sheet.width - 0.5 * _APART, len(columns))
    low, high = top + 3.0 * _LINE + _HEIGHT, top + 3.0 * _LINE
    share = np.stack([(chart.lines[:, i] - s.low) / (s.high - s.low) for i, s in zip(columns, scales)], axis=1)
    y = low + share * (high - low)
    for i in range(len(y)):
        if i != chart.chosen:
            sheet.add(Lines("line s4 quiet", (np.column_stack([at, y[i]]),)))
    sheet.add(Lines("line s0 chosen", (np.column_stack([at, y[chart.chosen]]),)))
    for x, i, scale in zip(at.tolist(), columns, scales):
        _draw_axis(sheet, x, (low, high), chart.axes[i], scale)


def _scale(axis: Axis, values: Floats) -> Ticks:
    low = float(np.min(values)) if axis.low is None else axis.low
    high = float(np.max(values)) if axis.high is None else axis.high
    return ticks(low, high, 5, unit=axis.unit, tight=axis.low is not None and axis.high is not None)


def _draw_axis(sheet: Sheet, x: float, ends: tuple[float, float], axis: Axis, scale: Ticks) -> None:
    low, high = ends
    sheet.line(x, low, x, high, "frame")
    for value, text in zip(scale.at.tolist(), scale.texts):
        height = low + (value - scale.low) / (scale.high - scale.low) * (high - low)
        sheet.line(x - 4.0, height, x, height, "tick-line")
        sheet.text(x - 6.0, height + 0.34 * FONT, text, "end", "note faint")
    for number, line in enumerate(_wrapped(axis_title(axis, scale), _APART - 6.0)[-3:][::-1]):
        sheet.text(x, high - 8.0 - number * _LINE, line, "middle", "tick")


def _wrapped(text: str, width: float) -> list[str]:
    """The text in lines no wider than so many px, broken at blanks, dots and underscores where it can be."""
    lines = [""]
    for word in text.replace(".", ". ").replace("_", "_ ").split(" "):
        joined = f"{lines[-1]}{'' if not lines[-1] or lines[-1][-1] in '._' else ' '}{word}"
        if lines[-1] and text_width(joined) > width:
            lines.append(word)
        else:
            lines[-1] = joined
    return lines
