"""The profile per degree: one A3 sheet of numbers for a shop that sets out or checks a cam with a dividing head."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from camgeom.drawing.paper import Paper
from camgeom.drawing.sheet import decimals
from camgeom.errors import ExportError
from camgeom.maths import Floats
from camgeom.report.part_sheet import BOTTOM, HEIGHT, LEFT, RIGHT, TOP, WIDTH

if TYPE_CHECKING:
    from camgeom.model import Model
    from camgeom.track.touch import Touch

BLOCKS, ROWS = 5, 72
"""of rows side by side, a row every degree"""
HEAD, LABELS, PITCH, SIZE = 12.0, 8.0, 3.5, 2.5
"""mm: the title, the labels of the columns, line pitch and size of the numbers (ISO 3098: 2.5 at least on A3)"""
NARROWEST = 11.0
"""mm, of a column"""
PLACES = 4
"""decimals, a tenth of a micrometre"""
Columns = list[tuple[str, str, Floats]]
"""label, unit, values (360,)"""


def columns(model: Model) -> Columns:
    """The numbers of every degree of cam angle: the follower's place; of a plate its profile where it is touched, in
    polar coordinates of the cam, half way up a flank that leans; of a drum the middle of the groove, of an end wall
    that of the roller on it. Of several tracks that of each alone, of a face groove its middle too."""
    degrees = np.arange(360.0)
    phi = np.radians(degrees)
    found: Columns = [("cam", "°", degrees)]
    several = len(model.grooves) > 1
    for number, one in enumerate(model.grooves, start=1):
        mark = f" {number}" if several else ""
        if not several:
            lift = one.setup.program.jet(phi, 0)[0]
            found.append(("position", "°", np.degrees(lift)) if one.profile.rotating else ("lift", "mm", lift))
        if (carriage := one.mechanism.carriage) is not None:
            x, y = one.tracks[0].pose(phi, 0).a[0][:2]
            what = "groove" if len(one.tracks[0].sides) > 1 else "roller"
            found += [("travel", "mm", carriage.travel(phi)), (f"{what} x", "mm", x), ("y", "mm", y)]
        if one.mechanism.drum is not None and len(one.tracks) == 1:
            (track,) = one.tracks
            pose = track.pose(phi, 0)
            x, y, z = pose.a[0] + 0.5 * sum(track.contact) * pose.u[0]
            what = "groove" if len(track.sides) > 1 else "roller"
            found += [(f"{what}{mark} z", "mm", z), (f"at{mark}", "°", _azimuth(x, y))]
        if several and one.mechanism.face_groove is not None:
            x, y = one.tracks[0].pose(phi, 0).a[0][:2]
            found += [(f"groove{mark} R", "mm", np.hypot(x, y)), (f"at{mark}", "°", _azimuth(x, y))]
            continue
        walls = one.profiles.walls if one.profiles is not None else ()
        for touch in walls:
            # Both ends of a flank that leans stand off the same pitch curve along the same normal.
            x, y = np.mean([end.outline.curve(phi + end.lag).points for end in _ends(one, touch.name)], axis=0)
            name = f"{touch.name} " if len(walls) > 1 else f"profile{mark} " if several else ""
            found += [(f"{name}R", "mm", np.hypot(x, y)), (f"{name}at" if not several else f"at{mark}", "°",
                                                          _azimuth(x, y))]  # fmt: skip
    return found


def _ends(model: Model, name: str) -> list[Touch]:
    """What touches a wall of a disc: of a flank that leans at both of its ends."""
    return [] if model.profiles is None else [touch for touch in model.profiles.touches if touch.name == name]


def _halfway(model: Model) -> str:
    """At which heights the numbers of flanks that lean are; empty of others."""
    walls = model.profiles.walls if model.profiles is not None else ()
    each = {wall.name: [end.height for end in _ends(model, wall.name) if end.height is not None] for wall in walls}
    told = [f"{name} at z = {sum(ends) / len(ends):g}" for name, ends in each.items() if ends]
    return "; ".join(["", *told])


def _azimuth(x: Floats, y: Floats) -> Floats:
    """Angle on the cam from +X to +Y, deg, as it is shown: what rounds to a turn is 0."""
    return np.asarray(np.round(np.degrees(np.arctan2(y, x)), PLACES) % 360.0)


def table_sheet(model: Model) -> Paper:
    """The sheet. Raises CamgeomError where the cam has no body, or more columns than stand beside each other."""
    _ = model.solids  # of a body that cannot be made no number is given to a shop
    paper = Paper(WIDTH, HEIGHT, f"{model.profile.name}, table")
    paper.box("border", LEFT, TOP, RIGHT, BOTTOM)
    block = model.profile.drawing
    paper.words(LEFT + 3.0, TOP + 8.0, model.profile.name, size=4.5, style="strong")
    told = ", ".join(word for word in (block.number, block.revision, block.date, block.author) if word)
    way = "clockwise" if model.mechanism.sense < 0.0 else "counter-clockwise"
    each = "its own follower's cam angle" if len(model.grooves) > 1 else "cam angle"
    note = f"every degree of {each}; angles at on the cam from +X to +Y; it turns {way} seen from +Z; mm, degrees"
    note += _halfway(model)
    if model.mechanism.carriage is not None:
        what = "groove's" if len(model.tracks[0].sides) > 1 else "roller's"
        note = f"every degree of the plate's drive; x, y on the plate, the {what} middle; it slides along -X; mm"
    paper.words(RIGHT - 3.0, TOP + 8.0, f"{told}   {note}".strip(), size=SIZE, anchor="end")
    found = columns(model)
    wide = (RIGHT - LEFT) / BLOCKS
    cell = wide / len(found)
    if cell < NARROWEST:
        raise ExportError(f"{len(found)} columns are more than stand beside each other on A3: ask for points.csv")
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
