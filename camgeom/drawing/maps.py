"""Heat maps as SVG: an embedded picture, lines of equal value with their numbers, and a colour bar."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from camgeom.drawing.colours import picture, scale, value_range
from camgeom.drawing.content import Axis, Map
from camgeom.drawing.plots import (
    NARROW,
    WIDE,
    PlotFrame,
    axis_title,
    covered,
    draw_x_texts,
    linked,
    place_label,
    x_ticks,
    y_ticks,
)
from camgeom.drawing.shapes import Box, Dot, Picture, Rectangle, Segments, Window
from camgeom.drawing.sheet import FONT, Sheet, Ticks, outside, text_box, text_width, ticks
from camgeom.maths import Floats

_SMOOTH = 160
"""pixels along the longer side a coarse picture is refined to before it is shown"""
TALLEST = 2.0
"""heights of a map that one to scale has at most"""
MOST_HIDDEN = 24
"""pieces of other lines that a line's number may cover: about two lines' height of text"""


def map_sheet(chart: Map, width: float) -> Sheet:
    """The map set at a width, px."""
    narrow = width < 0.5 * (NARROW + WIDE)
    low, high = value_range(chart.values, chart.diverging)
    bar = ticks(low, high, 6, unit=chart.value.unit, tight=True)
    top = 2.7 * FONT + 14.0
    height, right = 150.0 if narrow else 180.0, width - 14.0
    x_span, y_span = (float(np.ptp(_ends(at))) for at in (chart.x_at, chart.y_at))
    if chart.to_scale:
        height = min(TALLEST * height, right * y_span / x_span)
    y = y_ticks(_tight(chart.y, chart.y_at), [], height)
    left = max(map(text_width, y.texts)) + 10.0
    if chart.to_scale:
        height = min(height, (right - left) * y_span / x_span)
        right = left + height * x_span / y_span
    x = x_ticks(_tight(chart.x, chart.x_at) if chart.to_scale else chart.x, [_ends(chart.x_at)], right - left)
    frame = PlotFrame((left, top + 1.9 * FONT, right, top + 1.9 * FONT + height), x, y)
    sheet = Sheet(width, frame.box[3] + 3.2 * FONT)
    _draw_bar(sheet, chart, bar, width, narrow)
    sheet.text(0.0, top + 1.1 * FONT, axis_title(chart.y, y), "start", "axis")
    _draw_cells(sheet, chart, frame, low, high)
    lines = _isolines(chart, frame, bar)
    for value, _, ends in lines:
        sheet.add(Segments("iso below" if value < 0.0 else "iso", ends))
    for yv, text in zip(y.at.tolist(), y.texts):
        sheet.text(left - 6.0, frame.one(x.low, yv)[1] + 0.34 * FONT, text, "end", "tick")
    sheet.add(Rectangle("frame", frame.box))
    draw_x_texts(sheet, frame)
    for mark in chart.marks:
        sheet.add(Dot("dot", frame.one(mark.x, mark.y), 3.5))
    middles = [ends.mean(axis=1) for _, _, ends in lines]
    for mark in chart.marks:
        beside = np.concatenate([np.empty((0, 2)), *middles])
        place_label(sheet, frame.box, *frame.one(mark.x, mark.y), mark.text, beside, "on-map")
    _number_lines(sheet, frame, [text for _, text, _ in lines], middles)
    title = axis_title(chart.x, x)
    sheet.text(0.5 * (left + right), frame.box[3] + 2.75 * FONT, title, "middle", "axis")
    sheet.add(*linked(chart.x, frame, [(frame.box[1], frame.box[3])]))
    return sheet


def _ends(at: Floats) -> Floats:
    """Outer edges of evenly spaced cells."""
    half = 0.5 * (at[-1] - at[0]) / (len(at) - 1)
    return np.array([at[0] - half, at[-1] + half])


def _tight(axis: Axis, at: Floats) -> Axis:
    low, high = _ends(at).tolist()
    return Axis(axis.label, axis.unit, low, high)


def _draw_bar(sheet: Sheet, chart: Map, bar: Ticks, width: float, narrow: bool) -> None:
    """Value title, then the colour bar with its numbers under it."""
    title = axis_title(chart.value, bar)
    sheet.text(0.0, 1.1 * FONT, title, "start", "axis")
    x0 = text_width(title) + 24.0
    if narrow or width - x0 < 260.0:
        x0 = max(x0, width - 10.0 - 200.0)
    x1 = min(width - 14.0, x0 + 360.0)
    table = scale(chart.diverging, 32)
    step = (x1 - x0) / len(table)
    for i, (r, g, b) in enumerate(table.tolist()):
        edge = x0 + i * step
        sheet.add(Rectangle("", (edge, 4.0, edge + step + 0.51, 15.0), f"#{r:02x}{g:02x}{b:02x}"))
    end = -1e9
    for value, text in zip(bar.at.tolist(), bar.texts):
        x = x0 + (value - bar.low) / (bar.high - bar.low) * (x1 - x0)
        sheet.line(x, 4.0, x, 18.0, "tick-line")
        if x - 0.5 * text_width(text) > end + 6.0:
            end = sheet.text(x, 18.0 + FONT, text, "middle", "tick")[2]


def _draw_cells(sheet: Sheet, chart: Map, frame: PlotFrame, low: float, high: float) -> None:
    x0, y0 = frame.one(*(float(e[0]) for e in (_ends(chart.x_at), _ends(chart.y_at))))
    x1, y1 = frame.one(*(float(e[1]) for e in (_ends(chart.x_at), _ends(chart.y_at))))
    href = picture(_refined(chart.values), low, high, chart.diverging)
    sheet.add(Window(frame.box, (Picture((x0, y1, x1, y0), href),)))


def _refined(values: Floats) -> Floats:
    """Cells divided by linear interpolation so that a coarse map shows no steps; blank cells stay blank."""
    for axis in (0, 1):
        n = values.shape[axis]
        split = max(1, _SMOOTH // n)
        at = np.clip((np.arange(n * split) + 0.5) / split - 0.5, 0.0, n - 1.0)
        first = np.minimum(at.astype(np.int64), n - 2)
        share = at - first
        share = share[:, None] if axis == 0 else share[None, :]
        a, b = values.take(first, axis), values.take(first + 1, axis)
        values = np.where(share == 0.0, a, np.where(share == 1.0, b, a + share * (b - a)))
    return values


def _isolines(chart: Map, frame: PlotFrame, bar: Ticks) -> list[tuple[float, str, Floats]]:
    """Value, text and segments (k, 2, 2), px, of the lines at the colour bar's values, up to the edge of the map."""
    x, y = (np.r_[ends[0], at, ends[1]] for at in (chart.x_at, chart.y_at) for ends in (_ends(at),))
    values = np.pad(chart.values, 1, mode="edge")
    levels = [(v, t) for v, t in zip(bar.at.tolist(), bar.texts) if bar.low < v < bar.high]
    found = [(value, text, isolines(x, y, values, value)) for value, text in levels]
    return [(value, text, frame.at(ends[..., 0], ends[..., 1])) for value, text, ends in found if len(ends)]


def _number_lines(sheet: Sheet, frame: PlotFrame, texts: list[str], middles: list[Floats]) -> None:
    """Each number once, where it covers no words and least of the other lines; nowhere where it hides several."""
    x0, y0, x1, y1 = frame.box
    inner, middle = (x0 + 12.0, y0 + 4.0, x1 - 12.0, y1 - 4.0), 0.5 * (x0 + x1)
    for number, (text, spots) in enumerate(zip(texts, middles)):
        others = np.concatenate([np.empty((0, 2)), *middles[:number], *middles[number + 1 :]])
        fitting = [spot for spot in spots.tolist() if _fits(sheet, inner, spot, text)]
        rated = [(covered(_box(spot, text), others), abs(spot[0] - middle), *spot) for spot in fitting]
        hidden, _, x, y = min(rated, default=(MOST_HIDDEN, 0.0, 0.0, 0.0))
        if hidden < MOST_HIDDEN:
            sheet.text(x, y + 0.3 * FONT, text, "middle", "on-map", FONT - 1.0)


def _box(spot: list[float], text: str) -> Box:
    return text_box(spot[0], spot[1] + 0.3 * FONT, text, "middle")


def _fits(sheet: Sheet, inner: Box, spot: list[float], text: str) -> bool:
    box = _box(spot, text)
    return sheet.clash(box, 8.0) == 0.0 and outside(box, inner) == 0.0


def isolines(x: Floats, y: Floats, values: Floats, level: float) -> Floats:
    """Segments (k, 2, 2) of the line `values` = level over the grid y (m,), x (n,): marching squares with linear edges.

    A cell with a blank corner has no line; a saddle is cut by the sign of its mean.
    """
    xx, yy = np.meshgrid(x, y)
    corners = [[_corner(array, k) for k in range(4)] for array in (xx, yy, values)]
    case = np.zeros(corners[2][0].shape, dtype=np.int64)
    for k in range(4):
        case += (corners[2][k] > level).astype(np.int64) << k
    total = sum(corners[2])
    case[~np.isfinite(total)] = 0
    high = np.where(np.isfinite(total), total, 0.0) > 4.0 * level
    case = np.where(((case == 5) | (case == 10)) & high, 15 - case, case)
    segments = [
        np.stack([_crossing(corners, edge, level, case == code) for edge in pair], axis=1)
        for code, pairs in _CASES.items()
        for pair in pairs
    ]
    return np.concatenate(segments)


def _corner(array: Floats, k: int) -> Floats:
    """Values at corner k of every cell: 0 lower left, then counter-clockwise."""
    i, j = ((0, 0), (0, 1), (1, 1), (1, 0))[k]
    m, n = array.shape
    return array[i : m - 1 + i, j : n - 1 + j]


def _crossing(corners: list[list[Floats]], edge: int, level: float, cells: npt.NDArray[np.bool_]) -> Floats:
    """Points (k, 2) where an edge of the chosen cells meets the level."""
    (xa, xb), (ya, yb), (va, vb) = ((q[edge][cells], q[(edge + 1) % 4][cells]) for q in corners)
    share = (level - va) / (vb - va)
    return np.stack([xa + share * (xb - xa), ya + share * (yb - ya)], axis=-1)


_CASES: dict[int, tuple[tuple[int, int], ...]] = {
    1: ((3, 0),), 2: ((0, 1),), 3: ((3, 1),), 4: ((1, 2),), 5: ((3, 0), (1, 2)), 6: ((0, 2),), 7: ((3, 2),),
    8: ((2, 3),), 9: ((2, 0),), 10: ((0, 1), (2, 3)), 11: ((2, 1),), 12: ((1, 3),), 13: ((1, 0),), 14: ((0, 3),),
}  # fmt: skip
"""cell edges (0 bottom, 1 right, 2 top, 3 left) that a line joins, by the corners above the level (bits 0 to 3)"""
