"""The frame of a plot: scales from quantities to pixels, grid, tick labels, and free places for labels inside it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import final

import numpy as np

from camgeom.drawing.content import CAM_ANGLE, Axis
from camgeom.drawing.numerals import Ticks, ticks
from camgeom.drawing.sheet import FONT, Box, Sheet, outside, overlap, px, text_box, text_width
from camgeom.maths import Floats

WIDE, NARROW = 820.0, 370.0
"""px, the widths every plot is set at: the text column of a screen or sheet of paper, and a phone or half a column"""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Frame:
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
    for count in range(max(int(width / 55.0), 2), 0, -1):
        found = ticks(low, high, count, unit=axis.unit, tight=True)
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


def draw_grid(sheet: Sheet, frame: Frame, *, bottom: bool) -> None:
    """Grid lines, y tick texts, the frame; x tick texts where this is the lowest panel."""
    x0, y0, x1, y1 = frame.box
    grid = [f"M{px(frame.one(x, 0)[0])} {px(y0)}V{px(y1)}" for x in frame.x.at.tolist()]
    grid += [f"M{px(x0)} {px(frame.one(0, y)[1])}H{px(x1)}" for y in frame.y.at.tolist()]
    sheet.add(f'<path class="grid" d="{"".join(grid)}"/>')
    if frame.y.low < 0.0 < frame.y.high:
        sheet.line(x0, frame.one(0, 0)[1], x1, frame.one(0, 0)[1], "zero")
    for y, text in zip(frame.y.at.tolist(), frame.y.texts):
        sheet.text(x0 - 6.0, frame.one(0, y)[1] + 0.34 * FONT, text, "end", "tick")
    sheet.rect(frame.box, "frame")
    if bottom:
        draw_x_texts(sheet, frame)


def draw_x_texts(sheet: Sheet, frame: Frame) -> None:
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
        cost = 1e3 * sheet.clash(box) + 1e4 * outside(box, frame) + 3.0 * _covered(box, lines) + 0.25 * reach
        return cost + 1e3 * overlap(box, (x - 3, y - 3, x + 3, y + 3)), left, base

    best = (np.inf, x, y)
    for reach in (8.0, 22.0, 44.0, 70.0, 100.0):
        for dx, dy in _WAYS:
            left = x + dx * reach + (dx - 1.0) * 0.5 * width
            base = y + dy * reach + (0.35 + 0.45 * np.sign(dy)) * FONT
            best = min(best, rated(left, base, reach))
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


def _covered(box: Box, lines: Floats) -> int:
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


def linked(axis: Axis, frame: Frame, spans: list[tuple[float, float]]) -> str:
    """A cursor that the page moves to the common cam angle, over the given heights (px); empty for another axis."""
    if axis.label != CAM_ANGLE.label:
        return ""
    heights = " ".join(f"{px(top)} {px(bottom)}" for top, bottom in spans)
    x0, _, x1, _ = frame.box
    return f'<path class="cursor" data-cam="{px(x0)} {px(x1)} {frame.x.low:g} {frame.x.high:g} {heights}" d=""/>'
