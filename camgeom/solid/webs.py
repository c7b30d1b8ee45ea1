"""Wall thicknesses of a drum with a groove or rib: to the end faces, to the bore, and between passes of the groove."""

from __future__ import annotations

import numpy as np

from camgeom.maths import Floats
from camgeom.solid.blank import Bore, Wall
from camgeom.track import TURN, Track
from camgeom.track.section import Column, cylinder_level

SAMPLES = 360


def drum_walls(tracks: tuple[Track, ...], radius: float, floor: float, length: float, bore: Bore | None) -> list[Wall]:
    """Walls of a drum of outer `radius` and `floor` radius, 0 <= z <= length, cut by the tracks' outer edges."""
    phi = np.linspace(0.0, TURN, SAMPLES, endpoint=False)
    walls = []
    for track in tracks:
        column = Column(track, phi)
        edges = {}
        for side in track.sides:
            x = column.wall(side, column.reach(side, cylinder_level(radius), radius))[:, :, 0]
            edges[side] = np.stack([radius * np.unwrap(np.arctan2(x[1], x[0])), x[2]])
        walls += _ends(track, phi, edges, length)
        if len(track.sides) == 2:
            walls += _webs(track, phi, edges, TURN * radius)
    if bore is not None:
        walls.append(Wall("floor to bore", floor - bore.reach, None, "make the bore smaller or the groove shallower"))
    return walls


def _ends(track: Track, phi: Floats, edges: dict[float, Floats], length: float) -> list[Wall]:
    z = np.stack([edge[1] for edge in edges.values()])
    low, high = z.min(axis=0), z.max(axis=0)
    i, j = int(np.argmin(low)), int(np.argmax(high))
    advice = "move `start`, lengthen the drum, or shorten the stroke"
    found = []
    if low[i] > 0.0:
        found.append(Wall(f"{track.name} to lower end", float(low[i]), float(phi[i]), advice))
    if high[j] < length:
        found.append(Wall(f"{track.name} to upper end", float(length - high[j]), float(phi[j]), advice))
    return found


def _webs(track: Track, phi: Floats, edges: dict[float, Floats], turn: float) -> list[Wall]:
    """Material between two passes of the same groove edge, in the developed outer surface.

    Two edge points face each other across the material where the line between them leaves both edges on their
    material side within 45 degrees of the normal; the shortest such line is the web.
    """
    shortest, where = np.inf, 0
    middle = 0.5 * sum(edges.values())
    for edge in edges.values():
        tangent = np.roll(edge, -1, axis=1) - np.roll(edge, 1, axis=1)
        tangent[0] = (tangent[0] + 0.5 * turn) % turn - 0.5 * turn
        normal = np.stack([-tangent[1], tangent[0]]) / np.hypot(*tangent)
        outward = (normal * (edge - middle)).sum(axis=0)
        normal = normal * np.sign(outward)
        d = edge[:, None, :] - edge[:, :, None]
        d[0] = (d[0] + 0.5 * turn) % turn - 0.5 * turn
        distance = np.hypot(d[0], d[1])
        leaving = (d * normal[:, :, None]).sum(axis=0)
        arriving = -(d * normal[:, None, :]).sum(axis=0)
        facing = (leaving > 0.71 * distance) & (arriving > 0.71 * distance) & (distance > 0.0)
        gap = np.where(facing, distance, np.inf)
        if gap.min() < shortest:
            shortest = float(gap.min())
            where = int(np.argmin(gap.min(axis=1)))
    if not np.isfinite(shortest):
        return []
    advice = "enlarge the drum, use a smaller roller, or give the steep motion more cam angle"
    return [Wall(f"{track.name} between passes", shortest, float(phi[where]), advice)]
