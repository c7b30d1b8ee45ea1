"""Polar plots as SVG: a quantity round the roller, radius from zero, full turn."""

from __future__ import annotations

import numpy as np

from camgeom.drawing.content import Polar
from camgeom.drawing.plots import STYLES, axis_title, dense, place_label
from camgeom.drawing.shapes import Dot, Lines
from camgeom.drawing.sheet import FONT, Sheet, text_width, ticks
from camgeom.maths import Floats

_LINE = 1.5 * FONT


def polar_sheet(chart: Polar, width: float) -> Sheet:
    """The polar plot set at a width, px."""
    top = _LINE * _legend_height(chart, width) + 1.5 * FONT
    radius = min(0.5 * width - 44.0, 150.0)
    cx, cy = 0.5 * width, top + radius + 10.0
    largest = max(float(np.max(series.y)) for series in chart.series)
    rings = ticks(0.0, largest if largest > 0.0 else 1.0, 5, unit=chart.value.unit)
    sheet = Sheet(width, cy + radius + 2.0 * FONT)
    _draw_rings(sheet, cx, cy, radius, rings.at / rings.high)
    _draw_legend(sheet, chart, axis_title(chart.value, rings))
    lines: list[Floats] = []

    def at(angle: Floats, value: Floats) -> Floats:
        turn, r = np.radians(angle), radius * np.asarray(value) / rings.high
        return np.stack([cx + r * np.cos(turn), cy - r * np.sin(turn)], axis=-1)

    for number, series in enumerate(chart.series):
        style = (number if series.style is None else series.style) % STYLES
        xy = at(series.x, series.y)
        sheet.add(*((Lines(f"b{style}", (xy,), closed=True),) if number == 0 else ()))
        sheet.add(Lines(f"line s{style}", (xy,), closed=True))
        lines.append(dense(xy))
    frame = (2.0, top, width - 2.0, sheet.height - 2.0)
    marks = [(at(np.array(m.x), np.array(m.y)).tolist(), m.text) for m in chart.marks]
    for (x, y), _ in marks:
        sheet.add(Dot("dot", (x, y), 3.5))
    _draw_ring_values(sheet, cx, cy, radius, rings.at / rings.high, rings.texts, np.vstack(lines))
    for (x, y), text in marks:
        place_label(sheet, frame, x, y, text, np.vstack(lines))
    return sheet


def _draw_rings(sheet: Sheet, cx: float, cy: float, radius: float, shares: Floats) -> None:
    for share in shares[1:].tolist():
        style = "frame" if share > 0.999 else "grid"
        sheet.add(Dot(style, (cx, cy), radius * share))
    for degrees in range(0, 360, 30):
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        sheet.line(cx, cy, cx + radius * c, cy - radius * s, "grid")
        if degrees % 90 == 0 or degrees % 60 == 0:
            text = f"{degrees}°"
            reach = radius + 8.0 + 0.5 * text_width(text) * abs(c)
            sheet.text(cx + reach * c, cy - (radius + 12.0) * s + 0.34 * FONT, text, "middle", "tick")


def _draw_ring_values(
    sheet: Sheet, cx: float, cy: float, radius: float, shares: Floats, texts: tuple[str, ...], lines: Floats
) -> None:
    """Ring values along the ray that the lines cover least, of those on which the texts keep clear of each other."""
    rays = np.radians(np.array([15.0, 45.0, 75.0, 105.0, 135.0, 165.0, 195.0, 225.0, 255.0, 285.0, 315.0, 345.0]))
    apart, wide = radius * float(shares[1] - shares[0]), max(map(text_width, texts)) + 4.0
    rays = rays[(apart * np.abs(np.sin(rays)) > 1.2 * FONT) | (apart * np.abs(np.cos(rays)) > wide)]

    def covered(ray: float) -> int:
        spots = np.array([[cx + radius * s * np.cos(ray), cy - radius * s * np.sin(ray)] for s in shares[1:]])
        near = np.hypot(lines[:, None, 0] - spots[None, :, 0], lines[:, None, 1] - spots[None, :, 1]) < 16.0
        return int(np.count_nonzero(near))

    ray = min(rays.tolist(), key=covered)
    for share, text in zip(shares[1:].tolist(), texts[1:]):
        x, y = cx + radius * share * np.cos(ray), cy - radius * share * np.sin(ray)
        sheet.text(x, y + 0.34 * FONT, text, "middle", "note faint")


def _legend_height(chart: Polar, width: float) -> int:
    return 1 if len(chart.series) < 2 else 1 + len(chart.series)


def _draw_legend(sheet: Sheet, chart: Polar, title: str) -> None:
    sheet.text(0.0, 1.1 * FONT, title, "start", "axis")
    if len(chart.series) < 2:
        return
    for number, series in enumerate(chart.series):
        style = (number if series.style is None else series.style) % STYLES
        base = _LINE * (number + 1) + 1.1 * FONT
        sheet.line(0.0, base - 4.5, 24.0, base - 4.5, f"line s{style}")
        sheet.text(30.0, base, series.name, "start", "tick")
