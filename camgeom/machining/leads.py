"""How a tool comes and goes: down beside the flank (or in the middle of the groove), in on a tangent arc, and back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camgeom.machining.path import Positions
from camgeom.maths import Floats

LEAST = 1e-6
"""mm; a smaller arc is none"""
SHARE = 0.5
"""of the room beside the flank: an arc of that radius stays within the roller's body"""


@dataclass(frozen=True, eq=False)
class Move:
    """Positions reached one after another.

    kind     cut: along the flank; feed: in and out; rapid
    lengths  of a cut, (n,) mm: how far the contact moves along the flank up to each position from the one before
    """

    kind: str
    positions: Positions
    lengths: Floats | None = None


def lead_radius(wanted: float | None, room: float | None, tool_radius: float) -> float:
    """Radius of the arc in and out, mm: the wanted one, but no more than there is room for; 0: straight down."""
    if room is None:
        return tool_radius if wanted is None else wanted
    most = SHARE * room
    radius = most if wanted is None else min(wanted, most)
    return radius if radius > LEAST else 0.0


def with_leads(cut: Positions, lengths: Floats, radius: float, lift: float, chord: float) -> list[Move]:
    """The cut with what comes before and after it.

    lengths  (n - 1,) mm, between its contacts, along the flank
    radius  mm, of the quarter circles in and out; 0: none
    lift    mm, from the cut to where the tool may move freely
    chord   mm, error of the arcs' chords
    """
    moves = []
    first, last = cut.part(slice(0, 1)), cut.part(slice(-1, None))
    arc_in = _arc(first, radius, chord, -1.0)
    arc_out = _arc(last, radius, chord, 1.0)
    begin = arc_in.part(slice(0, 1)) if arc_in else first
    end = arc_out.part(slice(-1, None)) if arc_out else last
    moves.append(Move("rapid", _moved(begin, lift * begin.away)))
    moves.append(Move("feed", begin))
    if arc_in:
        moves.append(Move("feed", arc_in.part(slice(1, None))))
    steps = np.concatenate([[0.0], lengths])
    moves.append(Move("cut", cut, steps) if arc_in else Move("cut", cut.part(slice(1, None)), steps[1:]))
    if arc_out:
        moves.append(Move("feed", arc_out))
    moves.append(Move("rapid", _moved(end, lift * end.away)))
    return moves


def _moved(at: Positions, by: Floats) -> Positions:
    return Positions(at.phi, at.tip + by, at.axis, at.contacts, at.normals, at.travel, at.away)


def _arc(at: Positions, radius: float, chord: float, way: float) -> Positions | None:
    """A quarter circle that ends (way -1) or starts (+1) at a position, along its travel; without that position."""
    if radius <= LEAST:
        return None
    n = max(4, int(np.ceil(0.25 * np.pi / np.sqrt(2.0 * chord / radius))))
    angle = 0.5 * np.pi * np.arange(1, n + 1) / n
    angle = angle if way > 0.0 else angle[::-1]
    normal = at.normals[0]
    off = way * np.sin(angle) * at.travel - (1.0 - np.cos(angle)) * normal
    k = len(angle)
    return Positions(
        np.repeat(at.phi, k),
        at.tip + radius * off,
        np.repeat(at.axis, k, axis=1),
        np.repeat(at.contacts, k, axis=2),
        np.repeat(at.normals, k, axis=2),
        np.repeat(at.travel, k, axis=1),
        np.repeat(at.away, k, axis=1),
    )
