"""The profile per degree: one A3 sheet of numbers for a shop that sets out or checks a cam with a dividing head."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from camgeom.drawing.paper import Paper, pdf
from camgeom.drawing.sheet import decimals
from camgeom.errors import CamgeomError, ExportError
from camgeom.export.files import atomic_write
from camgeom.maths import Floats
from camgeom.report.part_sheet import BOTTOM, HEIGHT, LEFT, RIGHT, TOP, WIDTH

if TYPE_CHECKING:
    from camgeom.model import Model

BLOCKS, ROWS = 5, 72
"""of rows side by side, a row every degree"""
HEAD, LABELS, PITCH, SIZE = 12.0, 8.0, 3.5, 2.5
"""mm: the title, the labels of the columns, line pitch and size of the numbers (ISO 3098: 2.5 at least on A3)"""
PLACES = 4
"""decimals, a tenth of a micrometre"""
Columns = list[tuple[str, str, Floats]]
"""label, unit, values (360,)"""


def write_table_sheet(model: Model, path: Path) -> int:
    """Write the table as .svg or .pdf, by the end of the name; returns the bytes written. Raises ExportError where the
    file cannot be written."""
    try:
        _ = model.solids  # of a body that cannot be made no number is given to a shop
        paper = table_sheet(model)
    except CamgeomError as error:
        raise ExportError(f"{path}: cannot be drawn: {error}") from error
    data = pdf(paper) if path.suffix.lower() == ".pdf" else paper.svg().encode()
    with atomic_write(path) as stream:
        stream.write(data)
    return len(data)


def columns(model: Model) -> Columns:
    """The numbers of every degree of cam angle: the follower's place; of a plate its profile where it is touched, in
    polar coordinates of the cam; of a drum the middle of the groove or rib."""
    degrees = np.arange(360.0)
    phi = np.radians(degrees)
    rotating = model.profile.rotating
    lift = model.setup.program.jet(phi, 0)[0]
    found = [("cam", "°", degrees), ("position", "°", np.degrees(lift)) if rotating else ("lift", "mm", lift)]
    if model.planar is not None:
        several = len(model.planar.touches) > 1
        for touch in model.planar.touches:
            x, y = touch.at(phi).curve.points
            name = f"{touch.name} " if several else ""
            found += [(f"{name}R", "mm", np.hypot(x, y)), (f"{name}at", "°", np.degrees(np.arctan2(y, x)) % 360.0)]
    elif model.mechanism.drum is not None and len(model.tracks) == 1:
        track = model.tracks[0]
        pose = track.pose(phi, 0)
        x, y, z = pose.a[0] + 0.5 * sum(track.contact) * pose.u[0]
        found += [("groove z", "mm", z), ("at", "°", np.degrees(np.arctan2(y, x)) % 360.0)]
    return found


def table_sheet(model: Model) -> Paper:
    """The sheet."""
    paper = Paper(WIDTH, HEIGHT, f"{model.profile.name}, table")
    paper.box("border", LEFT, TOP, RIGHT, BOTTOM)
    block = model.profile.drawing
    paper.words(LEFT + 3.0, TOP + 8.0, model.profile.name, size=4.5, style="strong")
    told = ", ".join(word for word in (block.number, block.revision, block.date, block.author) if word)
    way = "clockwise" if model.mechanism.sense < 0.0 else "counter-clockwise"
    note = f"every degree of cam angle; angles at on the cam from +X to +Y; it turns {way} seen from +Z; mm, degrees"
    paper.words(RIGHT - 3.0, TOP + 8.0, f"{told}   {note}".strip(), size=SIZE, anchor="end")
    found = columns(model)
    wide = (RIGHT - LEFT) / BLOCKS
    cell = wide / len(found)
    top = TOP + HEAD
    for number in range(BLOCKS):
        left = LEFT + wide * number
        if number:
            paper.lines("rule", [(left, top), (left, BOTTOM)])
        for k, (label, unit, values) in enumerate(found):
            x = left + cell * (k + 1) - 1.5
            paper.words(x, top + 3.2, label, size=SIZE, style="faint", anchor="end")
            paper.words(x, top + 6.4, unit, size=SIZE, style="faint", anchor="end")
            for row, value in enumerate(values[ROWS * number : ROWS * (number + 1)].tolist()):
                text = decimals(value, 0 if k == 0 else PLACES)
                paper.words(x, top + LABELS + PITCH * (row + 1), text, size=SIZE, anchor="end")
    paper.lines("rule", [(LEFT, top), (RIGHT, top)])
    paper.lines("rule", [(LEFT, top + LABELS), (RIGHT, top + LABELS)])
    return paper
