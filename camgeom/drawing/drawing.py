"""A view to scale as SVG, with dimensions stacked round it and notes beside it that never cover each other."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from camgeom.drawing.content import Dimension, Drawing, Leader
from camgeom.drawing.plots import NARROW, WIDE, spread
from camgeom.drawing.shapes import Box, Dot, Lines
from camgeom.drawing.sheet import FONT, Sheet, straightened, text_width
from camgeom.maths import Floats

_ROW = 27.0
"""px from one stacked dimension line to the next"""
_ARROW = 14.0
"""px, by which the line of a short dimension, whose arrows stand outside, goes beyond it"""
_SHORT = 26.0, 18.0 + 1.6 * FONT
"""px, of a dimension along x, y, below which its arrows stand outside: an upright text stands between them"""
_TALLEST = 460.0
_STRETCHED = 240.0
_NOTE_GAP = 1.45 * FONT


@final
@dataclass(frozen=True, slots=True)
class _View:
    """From mm to px: the view's bounds (mm) and the box (px) they fill."""

    bounds: Box
    box: Box

    def at(self, points: Floats) -> Floats:
        """Pixels of points (..., 2) in mm."""
        x0, y0, x1, y1 = self.bounds
        left, top, right, bottom = self.box
        scale = np.array([(right - left) / (x1 - x0), (top - bottom) / (y1 - y0)])
        return np.asarray((np.asarray(points, dtype=float) - (x0, y0)) * scale + (left, bottom))

    def one(self, point: tuple[float, float]) -> tuple[float, float]:
        """Pixel of one point."""
        x, y = self.at(np.array(point)).tolist()
        return x, y

    @property
    def scale(self) -> float:
        """px per mm along x."""
        return (self.box[2] - self.box[0]) / (self.bounds[2] - self.bounds[0])


def drawing_size(drawing: Drawing, scale: float) -> tuple[float, float]:
    """Width and height, px, that a drawing takes at a scale, px per mm, with its dimensions and notes."""
    bounds = _bounds(drawing)
    wide, high = scale * (bounds[2] - bounds[0]), scale * (bounds[3] - bounds[1])
    rows = _stack(drawing.dimensions, view := _View(bounds, (0.0, 0.0, wide, high)))
    notes = _note_columns(drawing, view)
    across = sum(_depth(rows, side) + note + 6.0 for side, note in zip(("left", "right"), notes))
    return wide + across, high + _depth(rows, "above") + _depth(rows, "below") + 20.0


def drawing_sheet(drawing: Drawing, width: float, scale: float | None = None) -> Sheet:
    """The drawing set at a width, px; at a scale, px per mm, where one is given."""
    wide = scale is not None or width > 0.5 * (NARROW + WIDE)
    bounds = _bounds(drawing)
    view, rows = _fit(drawing, bounds, width, wide, scale)
    listed = 0.0 if wide else _NOTE_GAP * len(drawing.leaders)
    below = _depth(rows, "below") + 8.0
    sheet = Sheet(width, view.box[3] + below + listed + 4.0)
    for region in drawing.regions:
        sheet.add(Lines("d-cut", tuple(straightened(view.at(loop)) for loop in region.loops), True, True))
    for path in drawing.paths:
        lines = tuple(straightened(view.at(line)) for line in (path.points, *path.holes))
        sheet.add(Lines(f"d-{path.kind}", lines, path.closed, bool(path.holes)))
    for circle in drawing.circles:
        sheet.add(Dot(f"d-{circle.kind}", view.one(circle.centre), circle.radius * view.scale))
    for dimension, offset in rows:
        _draw_dimension(sheet, view, dimension, offset)
    if wide:
        _draw_notes(sheet, view, drawing, rows)
    else:
        _draw_list(sheet, view, drawing, view.box[3] + below)
    return sheet


def _bounds(drawing: Drawing) -> Box:
    points = [loop for path in drawing.paths for loop in (path.points, *path.holes)]
    points += [loop for region in drawing.regions for loop in region.loops]
    points += [
        np.array([[c.centre[0] + s * c.radius, c.centre[1] + s * c.radius] for s in (-1, 1)]) for c in drawing.circles
    ]
    points += [np.array([d.p, d.q]) for d in drawing.dimensions]
    everything = np.vstack(points)
    low, high = everything.min(axis=0), everything.max(axis=0)
    pad = np.maximum(0.01 * (high - low), 1e-6)
    x0, y0 = (low - pad).tolist()
    x1, y1 = (high + pad).tolist()
    return x0, y0, x1, y1


_Rows = list[tuple[Dimension, float]]
"""each dimension with its distance (px) from the view's edge to its line"""


def _fit(drawing: Drawing, bounds: Box, width: float, wide: bool, given: float | None) -> tuple[_View, _Rows]:
    """The given scale, or the largest at which view, dimension rows and note columns share the sheet."""
    view = _View(bounds, (0.0, 0.0, width, _TALLEST))
    rows: _Rows = []
    for _ in range(4):
        rows = _stack(drawing.dimensions, view)
        notes = _note_columns(drawing, view) if wide else (0.0, 0.0)
        left, right = _depth(rows, "left") + notes[0] + 6.0, _depth(rows, "right") + notes[1] + 6.0
        top = _depth(rows, "above") + 8.0
        room = width - left - right
        mm_wide, mm_high = bounds[2] - bounds[0], bounds[3] - bounds[1]
        if drawing.stretch:
            view = replace(view, box=(left, top, left + room, top + _STRETCHED))
            continue
        scale = given or min(room / mm_wide, (_TALLEST if wide else 1.2 * width) / mm_high)
        x = left + 0.5 * (room - scale * mm_wide)
        view = replace(view, box=(x, top, x + scale * mm_wide, top + scale * mm_high))
    return view, rows


def _stack(dimensions: tuple[Dimension, ...], view: _View) -> _Rows:
    """Shorter dimensions nearer the view; two share a row where they do not meet."""
    rows: _Rows = []
    for side in ("below", "above", "left", "right"):
        along = 0 if side in ("below", "above") else 1
        taken: list[list[tuple[float, float]]] = []
        depth: list[float] = []
        mine = [(d, *_extent(d, view, along)) for d in dimensions if d.side == side]
        for dimension, low, high in sorted(mine, key=lambda item: item[2] - item[1]):
            level = next((i for i, row in enumerate(taken) if all(high < a or low > b for a, b in row)), len(taken))
            if level == len(taken):
                taken.append([])
                depth.append(_ROW if along == 0 else 0.0)
            taken[level].append((low, high))
            if along == 1:
                depth[level] = max(depth[level], text_width(dimension.text) + 14.0)
            rows.append((dimension, float(level)))
        offsets = np.cumsum([0.0, *depth])
        rows = [
            (d, float(offsets[int(v)]) + (0.5 * depth[int(v)] + 4.0 if along else 20.0)) if d.side == side else (d, v)
            for d, v in rows
        ]
    return rows


def _extent(dimension: Dimension, view: _View, along: int) -> tuple[float, float]:
    """Span (px) a dimension needs along its own direction, with its text and outside arrows."""
    a, b = sorted((view.one(dimension.p)[along], view.one(dimension.q)[along]))
    need = text_width(dimension.text) if along == 0 else 1.3 * FONT
    slack = (14.0 if along == 0 else _ARROW + 2.2 * FONT) if b - a < _SHORT[along] else 0.0
    middle, half = 0.5 * (a + b), max(0.5 * need, 0.5 * (b - a) + slack)
    return middle - half - 5.0, middle + half + 5.0


def _depth(rows: _Rows, side: str) -> float:
    """Room (px) the dimensions on a side take from the view's edge."""
    deepest = 0.0
    for dimension, offset in rows:
        if dimension.side == side:
            text = 0.5 * text_width(dimension.text) + 6.0 if side in ("left", "right") else 8.0
            deepest = max(deepest, offset + text + (FONT if side == "above" else 0.0))
    return deepest


def _draw_dimension(sheet: Sheet, view: _View, dimension: Dimension, offset: float) -> None:
    """Extension lines, the dimension line with its arrows (outside where it is short), and the text."""
    side, along = dimension.side, 0 if dimension.side in ("below", "above") else 1
    edge = {"below": view.box[3], "above": view.box[1], "left": view.box[0], "right": view.box[2]}[side]
    away = 1.0 if side in ("below", "right") else -1.0
    line = edge + away * offset
    p, q = view.one(dimension.p), view.one(dimension.q)
    a, b = sorted((p[along], q[along]))

    def spot(on: float, across: float) -> tuple[float, float]:
        return (on, across) if along == 0 else (across, on)

    for end in (p, q):
        sheet.line(*spot(end[along], end[1 - along] + 3.0 * away), *spot(end[along], line + 4.0 * away), "d-thin")
    short = b - a < _SHORT[along]
    middle = 0.5 * (a + b)
    if along == 0:
        sheet.line(*spot(a - _ARROW * short, line), *spot(b + _ARROW * short, line), "d-thin")
        sheet.text(middle, line - 4.0, dimension.text, "middle", "note")
    elif short:  # the text stands over the outer arrow
        sheet.line(*spot(a - _ARROW, line), *spot(b + _ARROW, line), "d-thin")
        sheet.text(line, a - _ARROW - 4.0, dimension.text, "middle", "note")
    else:
        hole = 0.72 * FONT  # the line is broken for the text, which stands upright
        for near, far in ((a, middle - hole), (middle + hole, b)):
            if far > near:
                sheet.line(*spot(near, line), *spot(far, line), "d-thin")
        sheet.text(line, middle + 0.34 * FONT, dimension.text, "middle", "note")
    for tip, inward in ((a, 1.0), (b, -1.0)):
        back = tip + (-9.0 if short else 9.0) * inward
        corners = np.array([spot(tip, line), spot(back, line - 2.2), spot(back, line + 2.2)])
        sheet.add(Lines("d-arrow", (corners,), closed=True))


def _sides(drawing: Drawing, view: _View) -> tuple[list[Leader], list[Leader]]:
    middle = 0.5 * (view.bounds[0] + view.bounds[2])
    left = [leader for leader in drawing.leaders if leader.to[0] < middle]
    return left, [leader for leader in drawing.leaders if leader.to[0] >= middle]


def _note_columns(drawing: Drawing, view: _View) -> tuple[float, float]:
    widths = [max((text_width(leader.text) + 30.0 for leader in side), default=0.0) for side in _sides(drawing, view)]
    return widths[0], widths[1]


def _draw_notes(sheet: Sheet, view: _View, drawing: Drawing, rows: _Rows) -> None:
    """Notes in a column left and right of the view, in the order of their points, with leader lines."""
    for side, sign in zip(_sides(drawing, view), (-1.0, 1.0)):
        notes = sorted(side, key=lambda leader: -leader.to[1])
        if not notes:
            continue
        edge = view.box[0] - _depth(rows, "left") if sign < 0 else view.box[2] + _depth(rows, "right")
        x = edge + 24.0 * sign
        wanted = np.array([view.one(leader.to)[1] for leader in notes])
        at = spread(wanted, _NOTE_GAP, view.box[1] + FONT, view.box[3] - 4.0)
        for leader, y in zip(notes, at.tolist()):
            tip = view.one(leader.to)
            sheet.add(Lines("leader", (np.array([tip, (x - 14.0 * sign, y), (x - 4.0 * sign, y)]),)))
            sheet.add(Dot("dot", tip, 2.2))
            sheet.text(x, y + 0.34 * FONT, leader.text, "start" if sign > 0 else "end", "note")


def _draw_list(sheet: Sheet, view: _View, drawing: Drawing, top: float) -> None:
    """Numbers at the points, notes in a list under the view."""
    taken: list[tuple[float, float]] = []
    for number, leader in enumerate(drawing.leaders, start=1):
        x, y = view.one(leader.to)
        while any(np.hypot(x - u, y - v) < 17.0 for u, v in taken):  # beside the one that is there
            x += 4.0
        taken.append((x, y))
        sheet.add(Dot("balloon", (x, y), 8.0))
        sheet.text(x, y + 0.34 * FONT, str(number), "middle", "on-balloon", FONT - 2.0)
        base = top + _NOTE_GAP * number
        sheet.add(Dot("balloon", (9.0, base - 0.34 * FONT), 8.0))
        sheet.text(9.0, base, str(number), "middle", "on-balloon", FONT - 2.0)
        sheet.text(24.0, base, leader.text)
