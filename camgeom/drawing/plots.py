"""Line charts: panels stacked over one x axis with legends, limits and zones; and the frame that every plot has."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import count
from typing import final

import numpy as np

from camgeom.drawing.content import CAM_ANGLE, Axis, Band, Chart, Panel, Series
from camgeom.drawing.shapes import Box, Cursor, Dot, GridLines, Lines, Rectangle, Segments, Shape, Window
from camgeom.drawing.sheet import (
    FONT,
    Sheet,
    Ticks,
    outside,
    overlap,
    text_box,
    text_width,
    thin_line,
    ticks,
)
from camgeom.maths import Floats

WIDE, NARROW = 820.0, 370.0
"""px, the widths every plot is set at: the text column of a screen or sheet of paper, and a phone or half a column"""

STYLES = 6
"""line styles in report.css, told apart by colour and by dash"""
_LINE = 1.5 * FONT
_DOT = 2.6
_SWATCH = 24.0


@final
@dataclass(frozen=True, slots=True, eq=False)
class PlotFrame:
    """A rectangle (px) with the ranges of x and y it shows."""

    box: Box
    x: Ticks
    y: Ticks

    def at(self, x: Floats | float, y: Floats | float) -> Floats:
        """Pixels (n, 2) of quantities x and y."""
        x0, y0, x1, y1 = self.box
        right = x0 + (np.asarray(x, dtype=float) - self.x.low) / (self.x.high - self.x.low) * (x1 - x0)
        down = y1 - (np.asarray(y, dtype=float) - self.y.low) / (self.y.high - self.y.low) * (y1 - y0)
        return np.stack(np.broadcast_arrays(right, down), axis=-1)

    def one(self, x: float, y: float) -> tuple[float, float]:
        """Pixel of one point."""
        right, down = self.at(x, y).tolist()
        return right, down


def x_ticks(axis: Axis, values: Iterable[Floats], width: float) -> Ticks:
    """Ticks along x over the axis' own range or the data's, as many as `width` px carries without crowding."""
    low, high = x_range(axis, values)
    for most in range(max(int(width / 55.0), 2), 0, -1):
        found = ticks(low, high, most, unit=axis.unit, tight=True)
        if len(found.at) < 2 or _room(found, width):
            return found
    return found


def y_ticks(axis: Axis, values: Iterable[Floats], height: float) -> Ticks:
    """Ticks along y; the range grows to round ends unless the axis fixes it."""
    low, high = x_range(axis, values)
    fixed = axis.low is not None and axis.high is not None
    return ticks(low, high, max(int(height / 34.0), 2), unit=axis.unit, tight=fixed)


def x_range(axis: Axis, values: Iterable[Floats]) -> tuple[float, float]:
    """Ends of an axis: its own where it fixes them, else those of the data."""
    ends = [end for v in values for end in (float(np.min(v)), float(np.max(v)))]
    ends += [0.0] if axis.zero or not ends else []
    low = min(ends) if axis.low is None else axis.low
    return low, max(ends) if axis.high is None else axis.high


def _room(found: Ticks, width: float) -> bool:
    apart = width * (found.at[1] - found.at[0]) / (found.high - found.low)
    return bool(max(map(text_width, found.texts)) + 8.0 <= apart)


def axis_title(axis: Axis, scale: Ticks) -> str:
    """Axis title with the power of ten the tick texts leave out: `Force, 10³ N`."""
    if not scale.exponent:
        return axis.title
    return f"{axis.label}, {scale.factor} {axis.unit}".rstrip()


def draw_grid(sheet: Sheet, frame: PlotFrame, *, bottom: bool) -> None:
    """Grid lines, y tick texts, the frame; x tick texts where this is the lowest panel."""
    x0, _, x1, _ = frame.box
    across = tuple(frame.one(x, 0)[0] for x in frame.x.at.tolist())
    up = tuple(frame.one(0, y)[1] for y in frame.y.at.tolist())
    sheet.add(GridLines("grid", frame.box, across, up))
    if frame.y.low < 0.0 < frame.y.high:
        sheet.line(x0, frame.one(0, 0)[1], x1, frame.one(0, 0)[1], "zero")
    for y, text in zip(frame.y.at.tolist(), frame.y.texts):
        sheet.text(x0 - 6.0, frame.one(0, y)[1] + 0.34 * FONT, text, "end", "tick")
    sheet.add(Rectangle("frame", frame.box))
    if bottom:
        draw_x_texts(sheet, frame)


def draw_x_texts(sheet: Sheet, frame: PlotFrame) -> None:
    """Tick texts under the frame, the outer ones kept on the sheet."""
    for x, text in zip(frame.x.at.tolist(), frame.x.texts):
        half = 0.5 * text_width(text)
        middle = min(max(frame.one(x, 0)[0], half), sheet.width - half)
        sheet.text(middle, frame.box[3] + 1.35 * FONT, text, "middle", "tick")


_WAYS = (
    (0, -1),
    (0, 1),
    (1, -0.7),
    (-1, -0.7),
    (1, 0.7),
    (-1, 0.7),
    (1, 0),
    (-1, 0),
    (0.5, -1),
    (-0.5, -1),
    (0.5, 1),
    (-0.5, 1),
)
"""directions a label is tried in, as (right, down)"""


def place_label(sheet: Sheet, frame: Box, x: float, y: float, text: str, lines: Floats, style: str = "note") -> None:
    """Write `text` beside the point (px) where it covers no other words, and as little of the lines (k, 2) as can be.

    Near places come first, then farther ones with a leader line, then any free place in the frame.
    """
    width = text_width(text)

    def rated(left: float, base: float, reach: float) -> tuple[float, float, float]:
        left = min(max(left, frame[0] + 3.0), frame[2] - width - 3.0)
        box = text_box(left, base, text)
        cost = 1e3 * sheet.clash(box) + 1e4 * outside(box, frame) + 3.0 * covered(box, lines) + 0.25 * reach
        return cost + 1e3 * overlap(box, (x - 3, y - 3, x + 3, y + 3)), left, base

    best = (np.inf, x, y)
    for reach in (8.0, 22.0, 44.0, 70.0, 100.0):
        for dx, dy in _WAYS:
            left = x + dx * reach + (dx - 1.0) * 0.5 * width
            base = y + dy * reach + (0.35 + 0.45 * np.sign(dy)) * FONT
            # A level leader before a number reads as its minus sign.
            level = 30.0 if dy == 0 and reach > 14.0 else 0.0
            cost, left, base = rated(left, base, reach)
            best = min(best, (cost + level, left, base))
        if best[0] < 4.0 + 0.25 * reach:
            break
    if best[0] > 500.0:
        places = [
            (u, v) for u in np.linspace(frame[0], frame[2] - width, 15) for v in np.linspace(frame[1], frame[3], 15)
        ]
        best = min([best, *(rated(u, v, float(np.hypot(u - x, v - y))) for u, v in places)])
    _, left, base = best
    box = text_box(left, base, text)
    near = min(max(x, box[0]), box[2]), min(max(y, box[1]), box[3])
    if np.hypot(near[0] - x, near[1] - y) > 14.0:
        sheet.line(x, y, *near, "leader")
    sheet.text(left, base, text, "start", style)


def covered(box: Box, lines: Floats) -> int:
    """How many points (k, 2) of lines a box covers."""
    if len(lines) == 0:
        return 0
    inside = (lines[:, 0] > box[0]) & (lines[:, 0] < box[2]) & (lines[:, 1] > box[1]) & (lines[:, 1] < box[3])
    return int(np.count_nonzero(inside))


def dense(xy: Floats, step: float = 4.0) -> Floats:
    """Points about every `step` px along a line (n, 2), for asking what a label covers."""
    if len(xy) < 2:
        return xy
    length = np.r_[0.0, np.cumsum(np.hypot(*np.diff(xy, axis=0).T))]
    at = np.linspace(0.0, length[-1], max(int(length[-1] / step), 2))
    return np.column_stack([np.interp(at, length, xy[:, 0]), np.interp(at, length, xy[:, 1])])


def linked(axis: Axis, frame: PlotFrame, spans: list[tuple[float, float]]) -> tuple[Cursor, ...]:
    """A cursor that the page moves to the common cam angle, over the given heights (px); none for another axis."""
    if axis.label != CAM_ANGLE.label:
        return ()
    return (Cursor((frame.box[0], frame.box[2]), frame.x.low, frame.x.high, tuple(spans)),)


@final
@dataclass(frozen=True, slots=True)
class _Slot:
    """Where one panel stands: its header rows start at `top`, its frame runs from `y0` to `y1`."""

    panel: Panel
    scale: Ticks
    rows: tuple[tuple[tuple[str, str], ...], ...]
    top: float
    y0: float
    y1: float


def chart_sheet(chart: Chart, width: float) -> Sheet:
    """The chart set at a width, px; every label inside the sheet, none over another."""
    narrow = width < 0.5 * (NARROW + WIDE)
    slots, bottom = _stack(chart, width, narrow)
    left = max(text_width(text) for slot in slots for text in slot.scale.texts) + 10.0
    right = max((_direct_room(slot, width) for slot in slots), default=0.0) or 10.0
    scale = x_ticks(chart.x, _all_x(chart), width - left - right)
    right = max(right, 0.5 * text_width(scale.texts[-1]) if len(scale.at) and scale.at[-1] == scale.high else 0.0)
    sheet = Sheet(width, bottom + 3.2 * FONT)
    for slot in slots:
        frame = PlotFrame((left, slot.y0, width - right, slot.y1), scale, slot.scale)
        _draw_panel(sheet, frame, slot, chart, last=slot is slots[-1])
    title = axis_title(chart.x, scale)
    middle = min(max(0.5 * (left + width - right), 0.5 * text_width(title)), width - 0.5 * text_width(title))
    sheet.text(middle, bottom + 2.75 * FONT, title, "middle", "axis")
    span = PlotFrame((left, slots[0].y0, width - right, bottom), scale, slots[0].scale)
    sheet.add(*linked(chart.x, span, [(slot.y0, slot.y1) for slot in slots]))
    return sheet


def _stack(chart: Chart, width: float, narrow: bool) -> tuple[list[_Slot], float]:
    slots: list[_Slot] = []
    y = 0.0
    normal = (190.0 if narrow else 215.0) if len(chart.panels) == 1 else (105.0 if narrow else 118.0)
    for panel in chart.panels:
        height = normal * panel.height
        values = [s.y for s in panel.series] + [v for b in panel.bands for v in (b.low, b.high)]
        values += [np.array([limit.value * 1.04]) for limit in panel.limits if not limit.vertical]
        scale = y_ticks(panel.y, values, height)
        rows = _legend_rows(panel, axis_title(panel.y, scale), width)
        y0 = y + _LINE * len(rows) + 6.0
        if panel is chart.panels[0] and _named_zones(chart, width):
            y0 += _LINE - 3.0
        slots.append(_Slot(panel, scale, rows, y, y0, y0 + height))
        y = y0 + height + 10.0
    return slots, slots[-1].y1


def _named_zones(chart: Chart, width: float) -> bool:
    """Whether some zone is wide enough for its word, by the plot's least width."""
    low, high = x_range(chart.x, _all_x(chart))
    share = 0.8 * width / (high - low) if high > low else 0.0
    return any(zone.label and text_width(zone.label) + 6.0 < share * (zone.high - zone.low) for zone in chart.zones)


def _entries(panel: Panel) -> list[tuple[str, str]]:
    """(style, name) of every line and band, styles counted up where not given."""
    number = count()
    named: list[tuple[Series | Band, str]] = [(s, "s") for s in panel.series]
    named += [(b, "b") for b in panel.bands]
    return [(f"{letter}{(next(number) if item.style is None else item.style) % STYLES}", item.name)
            for item, letter in named]  # fmt: skip


def _legend_rows(panel: Panel, title: str, width: float) -> tuple[tuple[tuple[str, str], ...], ...]:
    """Header rows: the axis title first, then legend entries as they fit."""
    rows: list[list[tuple[str, str]]] = [[("axis", title)]]
    entries = list(dict.fromkeys(_entries(panel)))  # lines of one name and style share an entry
    if len(entries) > 1 and not _direct_labels(panel, width):
        used = text_width(title) + 28.0
        for entry in entries:
            need = _SWATCH + 6.0 + text_width(entry[1]) + 14.0
            if used + need > width:
                rows.append([])
                used = 0.0
            rows[-1].append(entry)
            used += need
    return tuple(map(tuple, rows))


def _direct_labels(panel: Panel, width: float) -> bool:
    names = [name for _, name in _entries(panel)]
    return panel.direct and bool(names) and max(map(text_width, names)) < 0.3 * width


def _direct_room(slot: _Slot, width: float) -> float:
    if not _direct_labels(slot.panel, width):
        return 0.0
    return max(text_width(name) for _, name in _entries(slot.panel)) + 14.0


def _all_x(chart: Chart) -> list[Floats]:
    return [s.x for panel in chart.panels for s in panel.series] + [b.x for panel in chart.panels for b in panel.bands]


def _draw_panel(sheet: Sheet, frame: PlotFrame, slot: _Slot, chart: Chart, *, last: bool) -> None:
    x0, y0, x1, y1 = frame.box
    named = slot.panel is chart.panels[0] and _named_zones(chart, sheet.width)
    for zone in chart.zones:
        low, high = (float(np.clip(frame.one(v, 0.0)[0], x0, x1)) for v in (zone.low, zone.high))
        sheet.add(Rectangle("zone", (low, y0, high, y1)))
        fits = text_width(zone.label) + 6.0 < high - low  # a zone too narrow for its word is shaded only
        if named and zone.label and fits:
            sheet.text(0.5 * (low + high), y0 - 5.0, zone.label, "middle", "faint")
    _draw_header(sheet, slot, frame)
    draw_grid(sheet, frame, bottom=last)
    lines = _draw_lines(sheet, frame, slot.panel)
    for limit in slot.panel.limits:
        drawn = _draw_limit(sheet, frame, limit.value, limit.label, limit.vertical, lines)
        lines = np.vstack([lines, drawn])
    # What is unbounded stands at the frame's edge.
    places = [frame.one(mark.x, mark.y) for mark in slot.panel.marks]
    places = [(float(np.clip(x, x0, x1)), float(np.clip(y, y0, y1))) for x, y in places]
    for place in places:
        sheet.add(Dot("dot", place, 3.0))
    for (x, y), mark in zip(places, slot.panel.marks):
        place_label(sheet, frame.box, x, y, mark.text, lines)
    if _direct_labels(slot.panel, sheet.width):
        _draw_direct(sheet, frame, slot.panel)


def _draw_header(sheet: Sheet, slot: _Slot, frame: PlotFrame) -> None:
    for number, row in enumerate(slot.rows):
        base = slot.top + _LINE * number + 1.1 * FONT
        x = 0.0
        if row and row[0][0] == "axis":
            sheet.text(0.0, base, row[0][1], "start", "axis")
            x = text_width(row[0][1]) + 28.0
        entries = [entry for entry in row if entry[0] != "axis"]
        need = sum(_SWATCH + 20.0 + text_width(name) for _, name in entries)
        x = max(x, frame.box[2] - need + 14.0) if number == 0 else x
        for style, name in entries:
            if style.startswith("b"):
                sheet.add(Rectangle(style, (x, base - 9.0, x + _SWATCH, base)))
            else:
                dotted = all(s.dots for s in slot.panel.series if s.name == name)
                mark = Dot(f"point {style}", (x + 0.5 * _SWATCH, base - 4.5), _DOT)
                line = Segments(f"line {style}", np.array([[[x, base - 4.5], [x + _SWATCH, base - 4.5]]]))
                sheet.add(mark if dotted else line)
            sheet.text(x + _SWATCH + 6.0, base, name, "start", "tick")
            x += _SWATCH + 20.0 + text_width(name)


def _draw_lines(sheet: Sheet, frame: PlotFrame, panel: Panel) -> Floats:
    """Bands, then lines, clipped to the frame; returns points along all of them (k, 2), px."""
    entries = _entries(panel)
    points: list[Floats] = []
    body: list[Shape] = []
    for (style, _), band in zip(entries[len(panel.series) :], panel.bands):
        low, high = (frame.at(band.x, v) for v in (band.low, band.high))
        body.append(Lines(style, (np.vstack([low, high[::-1]]),), closed=True))
        points += [dense(low), dense(high)]
    for (style, _), series in zip(entries, panel.series):
        xy = frame.at(series.x, series.y)
        rising = bool(np.all(np.diff(series.x) >= 0.0))
        drawn = thin_line(xy[:, 0], xy[:, 1]) if rising else xy
        if series.dots:
            body += [Dot(f"point {style}", (x, y), _DOT) for x, y in xy.tolist()]
            points.append(xy)
            continue
        body.append(Lines(f"line {style}", (drawn,)))
        points.append(dense(drawn))
    x0, y0, x1, y1 = frame.box
    sheet.add(Window((x0 - 1.0, y0 - 1.0, x1 + 1.0, y1 + 1.0), tuple(body)))
    return np.vstack(points) if points else np.empty((0, 2))


def _draw_limit(sheet: Sheet, frame: PlotFrame, value: float, label: str, vertical: bool, lines: Floats) -> Floats:
    """The line with its label where that hides least of the lines (k, 2); returns points along it."""
    x0, y0, x1, y1 = frame.box
    at = frame.one(value, value)[0 if vertical else 1]
    ends = (at, y0, at, y1) if vertical else (x0, at, x1, at)
    sheet.line(*ends, "at" if vertical else "limit")
    drawn = dense(np.reshape(ends, (2, 2)))
    if not label:
        return drawn
    width = text_width(label)
    spots = [(x, at + dy) for dy in (-5.0, 1.05 * FONT) for x in np.linspace(x1 - width - 5.0, x0 + 5.0, 9)]
    if vertical:
        spots = [(at + dx, y) for y in np.linspace(y0 + 1.2 * FONT, y1 - 6.0, 7) for dx in (5.0, -width - 5.0)]

    def cost(spot: tuple[float, float]) -> float:
        box = text_box(*spot, label)
        inside = (lines[:, 0] > box[0]) & (lines[:, 0] < box[2]) & (lines[:, 1] > box[1]) & (lines[:, 1] < box[3])
        return 1e3 * sheet.clash(box) + 1e4 * outside(box, frame.box) + float(np.count_nonzero(inside))

    sheet.text(*min(spots, key=cost), label, "start", "note" if vertical else "limit-text")
    return drawn


def _draw_direct(sheet: Sheet, frame: PlotFrame, panel: Panel) -> None:
    """Names at the right ends of the lines, pushed apart to a line's height."""
    items: list[Series | Band] = [*panel.series, *panel.bands]
    _, y0, x1, y1 = frame.box
    lines = {item.name for item in panel.series if not item.dots}
    ends = []
    for (style, name), item in zip(_entries(panel), items):
        if isinstance(item, Series) and item.dots and name in lines:
            continue  # the marks of a line that has the name
        y = item.y[-1] if isinstance(item, Series) else 0.5 * (item.low[-1] + item.high[-1])
        ends.append((float(np.clip(frame.one(0.0, float(y))[1], y0, y1)), style, name))
    ends.sort(key=lambda end: end[0])
    at = spread(np.array([end[0] for end in ends]), 1.12 * FONT, y0 + 4.0, y1 - 2.0)
    for (y, style, name), spot in zip(ends, at.tolist()):
        if abs(y - spot) > 2.0:
            sheet.line(x1, y, x1 + 7.0, spot, "leader")
        sheet.text(x1 + 9.0, spot + 0.34 * FONT, name, "start", f"name {style}")


def spread(at: Floats, gap: float, low: float, high: float) -> Floats:
    """Sorted positions moved as little as their order and a least distance `gap` allow, in low..high if they fit."""
    if len(at) * gap > high - low + gap:
        return np.linspace(low, high, len(at))
    step = gap * np.arange(len(at))
    blocks: list[list[float]] = []  # [sum, count] of positions less their rank offset: pool adjacent violators
    for value in (at - step).tolist():
        blocks.append([value, 1.0])
        while len(blocks) > 1 and blocks[-2][0] / blocks[-2][1] > blocks[-1][0] / blocks[-1][1]:
            last = blocks.pop()
            blocks[-1] = [blocks[-1][0] + last[0], blocks[-1][1] + last[1]]
    pooled = np.concatenate([np.full(int(n), total / n) for total, n in blocks])
    return np.asarray(np.clip(pooled, low, high - step[-1]) + step)
