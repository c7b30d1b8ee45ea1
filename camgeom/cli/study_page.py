"""The page of a study: the figures over the first axis, one line for each setting of the others, and the variants."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np

from camgeom.design.study import Axis as Varied
from camgeom.design.study import Row, Study
from camgeom.drawing.content import Axis, Block, Chart, Column, Figure, Page, Panel, Section, Series, Table, Text

PLOTTED = (
    ("flank.max_pressure_angle_deg", "Largest pressure angle", "°"),
    ("flank.undercut_margin", "Undercut margin", ""),
    ("solid.mass_kg", "Mass", "kg"),
    ("contact.peak_pressure_mpa", "Peak contact pressure", "MPa"),
    ("contact.peak_torque_n_m", "Peak torque", "N m"),
    ("fatigue.roller_life_h", "Roller life", "h"),
)
MOST_LINES = 6
MOST_ROWS = 200


def page(study: Study, rows: Sequence[Row], name: str) -> Page:
    """The page of a finished study."""
    counts = {status: sum(row.status == status for row in rows) for status in dict.fromkeys(row.status for row in rows)}
    blocks: list[Block] = []
    plotted = _chart(study, rows)
    if plotted is not None:
        blocks.append(plotted)
    blocks.append(_table(study, rows))
    if len(rows) > MOST_ROWS:
        note = f"The table shows the first {MOST_ROWS} of {len(rows)} variants; study.csv has them all."
        blocks.append(Text((note,)))
    return Page(
        title=name,
        kind=f"study of {', '.join(one.key for one in study.axes)}",
        passed=None,
        figures=tuple(Figure(f"variants: {status}", count) for status, count in counts.items()),
        sections=(Section("study", "Variants", tuple(blocks)),),
    )


def _chart(study: Study, rows: Sequence[Row]) -> Chart | None:
    """A panel for each figure that was measured, over the numeric axis with the most values."""
    numeric = [i for i, one in enumerate(study.axes) if all(not isinstance(v, str) for v in one.values)]
    if not numeric:
        return None
    across = max(numeric, key=lambda i: len(study.axes[i].values))
    if len(study.axes[across].values) < 2:
        return None
    panels = []
    for key, label, unit in PLOTTED:
        series = _lines(study.axes, rows, across, key, label)
        if series:
            panels.append(Panel(Axis(label, unit), series))
    caption = f"Figures over {study.axes[across].key}; variants without a result leave the line out"
    return Chart(caption, Axis(study.axes[across].key), tuple(panels)) if panels else None


def _lines(axes: Sequence[Varied], rows: Sequence[Row], across: int, key: str, label: str) -> tuple[Series, ...]:
    """One line for each setting of the other axes (the first few), over the axis `across`."""
    others = [i for i in range(len(axes)) if i != across]
    lines = []
    for setting in product(*(axes[i].values for i in others)):
        points = sorted(
            (float(row.values[across]), float(value))
            for row in rows
            if tuple(row.values[i] for i in others) == setting and (value := row.figures.get(key)) is not None
        )
        if len(points) >= 2:
            x, y = np.array(points).T
            name = ", ".join(f"{axes[i].key} {_shown(v)}" for i, v in zip(others, setting)) or label
            lines.append(Series(name, x, y))
        if len(lines) == MOST_LINES:
            break
    return tuple(lines)


def _shown(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _table(study: Study, rows: Sequence[Row]) -> Table:
    measured = [(key, label, unit) for key, label, unit in PLOTTED if any(key in row.figures for row in rows)]
    heads = [*(Column(one.key) for one in study.axes), Column("Status"), *(Column(l, u) for _, l, u in measured)]
    cells = tuple(
        (*row.values, row.status, *(row.figures.get(key) for key, _, _ in measured), row.reason[:200])
        for row in rows[:MOST_ROWS]
    )
    return Table("Variants", (*heads, Column("Reason")), cells)
