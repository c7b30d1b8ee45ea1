"""Cutter data: the tool and its passes in numbers, the stock it leaves on the flanks, and the ways that go wrong."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from camgeom.drawing.content import CAM_ANGLE, Axis, Block, Cell, Column, Map, Table, Text, quantities
from camgeom.machining.rest import NOISE
from camgeom.track.flank import Flank

if TYPE_CHECKING:
    from camgeom.machining.outcome import Outcome
    from camgeom.machining.rest import RestField
    from camgeom.maths import Floats
    from camgeom.model import Model

ANGLES = 181
PLACES = 9
MICRON = 1e3
LEAST_SHOWN = 1e-6
"""mm; a rest below that everywhere is none, and has no map"""

_FIGURES = (
    ("passes", "Passes", ""),
    ("rows", "Rows of the ball", ""),
    ("scallop_mm", "Highest ridge between rows", "mm"),
    ("foot_left_mm", "Wall left at the foot", "mm"),
    ("most_rest_mm", "Most stock left", "mm"),
    ("least_rest_mm", "Least stock left (a gouge is negative)", "mm"),
    ("opposite_wall_mm", "Least distance from the opposite wall", "mm"),
    ("standing_mm", "Groove left standing between the passes", "mm"),
    ("mouth_gouge_mm", "Tool thicker than the groove's mouth by", "mm"),
    ("largest_tool_diameter_mm", "Largest tool that goes in", "mm"),
    ("head_room_mm", "Room for angle head and tool along its axis", "mm"),
    ("head_left_mm", "Left of it for the head alone (negative: the tool is too long)", "mm"),
    ("head_over_web_mm", "Tool's axis above the web, where it is lowest", "mm"),
    ("chord_error_mm", "Chord error of the path", "mm"),
    ("cutting_time_min", "Time at the feeds", "min"),
)
_WAYS = {
    "centre": "the roller's path, once",
    "shifted": "the roller's path, moved along the follower's motion",
    "radial": "beside the flank, with the axis through the cam's",
}


def cutter(model: Model) -> tuple[Block, ...]:
    """The section; empty for a profile without [cutter]. Raises DesignError where the tool cannot make the cam."""
    if model.profile.cutter is None:
        return ()
    outcome = model.machined
    data = outcome.data()
    known = [entry for entry in _FIGURES if data.get(entry[0]) is not None]
    rows: list[tuple[Cell, ...]] = [(label, data[key], unit) for key, label, unit in known]
    table = quantities(f"Tool: {data['tool']}", rows)
    blocks: list[Block] = [table, *_maps(outcome)]
    if shop := data.get("shop_errors"):
        ways: list[tuple[Cell, ...]] = [
            (_WAYS[way["path"]], way["least_mm"], way["most_mm"], round(way["most_at_deg"], 6)) for way in shop
        ]
        heads = (Column("Way"), Column("Least stock", "mm"), Column("Most stock", "mm"), Column("at", "°"))
        blocks.append(Table("What the same tool leaves where it only follows the roller", heads, tuple(ways)))
    if outcome.certain and outcome.machining.tracks:
        blocks.append(Text(("The tool stays within the roller's own body all the way, so it cannot cut too deep.",)))
    return tuple(blocks)


def _maps(outcome: Outcome) -> list[Block]:
    """Stock over both flanks of the first track, where there is any."""
    shown: list[Block] = []
    fields = outcome.fields
    for one in [field for field in fields if field.track is fields[0].track]:
        if float(np.abs(one.rest[one.valid]).max(initial=0.0)) > LEAST_SHOWN:
            shown.append(_map(one, outcome))
    return shown


def _map(one: RestField, outcome: Outcome) -> Map:
    start, stop = one.track.knots()[[0, -1]].tolist()
    phi = np.linspace(start, stop, ANGLES)
    low, high = sorted(one.track.contact)
    if outcome.within is not None:  # places that stand beyond the blank at every angle are left out
        along = np.linspace(low, high, ANGLES)
        low, high = along[(outcome.within(_flank(one, phi, along).x) >= 0.0).any(axis=0)][[0, -1]].tolist()
    delta = np.linspace(low, high, PLACES)
    flank = _flank(one, phi, delta)
    inside = np.ones((ANGLES, PLACES), dtype=bool) if outcome.within is None else outcome.within(flank.x) >= 0.0
    rest = one.at(flank)
    values = np.where(inside, MICRON * np.where(np.abs(rest) > NOISE, rest, 0.0), np.nan)
    name = f"{one.track.name}, flank {'+' if one.side > 0.0 else '−'}"
    axis = Axis("Along the roller", "mm")
    return Map(f"Stock left, {name}", CAM_ANGLE, axis, Axis("Stock", "µm"), np.degrees(phi), delta, values.T)


def _flank(one: RestField, phi: Floats, delta: Floats) -> Flank:
    """The flank at cam angles and places along the roller, mm."""
    return Flank(one.track, phi, np.array([one.track.meridian.parameter(float(d)) for d in delta]), one.side)
