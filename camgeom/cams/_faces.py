"""Several tracks on one disc: a groove in each of its faces, a profile as its rim; what stands between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from math import hypot, inf

import numpy as np

from camgeom.cams._plate import WALL_SAMPLES, bore_walls, least_distance, least_wall
from camgeom.maths import Floats
from camgeom.maths.extremum import piece_grid
from camgeom.solid.blank import Bore, Wall
from camgeom.solid.builder import Index
from camgeom.solid.prism import FaceGroove, GroovedPlate, Loop
from camgeom.track import TURN
from camgeom.track.outline import Outline, RollerOutline

Heights = tuple[float, float]
Line = tuple[tuple[float, float], tuple[float, float]]

STEPS = 4
LEAST_BEND = 0.1
"""of what a point's foot moves along a curve: beside its centre of curvature steps would be endless"""
APART = "a wider plate, shallower grooves, or grooves at other radii"


def room_within(inner: Outline, outer: Outline, how_far: bool = True) -> tuple[float, float]:
    """Least distance of one closed curve about the axis from another round it, mm, and its cam angle on the inner one.

    In any direction of the plane; negative where the inner one reaches beyond the outer one, -inf where that is seen at
    a sample and nobody asks how far.
    """
    from scipy.spatial import cKDTree

    knots = outer.knots()
    grid, _ = piece_grid(knots, WALL_SAMPLES)
    sampled = outer.curve(grid)
    tree, reach = cKDTree(sampled.points.T), TURN / WALL_SAMPLES

    def nearest(x: Floats) -> tuple[Floats, Index, Floats]:
        least, near = (np.asarray(one) for one in tree.query(x.T))
        return least, near, -((x - sampled.points[:, near]) * sampled.normals[:, near]).sum(axis=0)

    if not how_far and (nearest(inner.curve(piece_grid(inner.knots(), WALL_SAMPLES)[0]).points)[2] < 0.0).any():
        return -inf, 0.0

    def distance(x: Floats) -> Floats:
        least, near, inward = nearest(x)
        phi = first = grid[near]
        for _ in range(STEPS):
            # Newton's way to the foot: along the curve its distance changes by the tangent's share, less what it bends.
            at = outer.curve(phi)
            off, (nx, ny) = x - at.points, at.normals
            bend = np.maximum(1.0 + at.curvature * (off * at.normals).sum(axis=0), LEAST_BEND)
            step = (off[1] * nx - off[0] * ny) / (at.speed * bend)
            phi = np.clip(phi + step, np.maximum(first - reach, knots[0]), np.minimum(first + reach, knots[-1]))
        least = np.minimum(least, np.hypot(*(x - outer.curve(phi).points)))
        return np.asarray(np.where(inward < 0.0, -least, least))

    return least_distance(inner, distance)


def lift_of(loop: Loop) -> float:
    """By how much further out a loop stands at its upper end than at its lower one, mm; 0 of a straight wall."""
    low, high = loop.outline, loop.upper
    if not (isinstance(low, RollerOutline) and isinstance(high, RollerOutline)):
        return 0.0
    return high.distance - low.distance


def lines_apart(one: Line, other: Line) -> float:
    """Least distance of two straight walls seen along their tracks, each ((aside, z), (aside, z)) from below up, mm.

    Negative where at a height the first one stands further out than the other.
    """
    (a0, z0), (a1, z1) = one
    (b0, y0), (b1, y1) = other
    heights = [z for z in (max(z0, y0), min(z1, y1)) if z0 <= z <= z1 and y0 <= z <= y1]
    for z in heights:
        gap = b0 + (b1 - b0) * (z - y0) / (y1 - y0) - a0 - (a1 - a0) * (z - z0) / (z1 - z0)
        if gap <= 0.0:
            return gap
    ends = [(end, other) for end in one] + [(end, one) for end in other]
    return min(_off(end, line) for end, line in ends)


def _off(point: tuple[float, float], line: Line) -> float:
    """Distance of a point from a stretch of a line, mm."""
    (x0, z0), (x1, z1) = line
    dx, dz = x1 - x0, z1 - z0
    share = min(1.0, max(0.0, ((point[0] - x0) * dx + (point[1] - z0) * dz) / (dx * dx + dz * dz)))
    return hypot(point[0] - x0 - share * dx, point[1] - z0 - share * dz)


def walls_apart(inner: Loop, outer: Loop, heights: tuple[Heights, Heights]) -> tuple[float, float]:
    """Least distance of the wall of one loop from that of another round it, mm, and its cam angle on the inner one.

    heights  (low z, high z) of each. Walls that lean keep the normals of their tracks: where two are nearest in the
    plane at one height they are at all, and how near is told by the straight lines across both.
    """
    room, angle = room_within(inner.outline, outer.outline)
    if inner.upper is None and outer.upper is None:
        return room, angle
    (z0, z1), (y0, y1) = heights
    one, other = ((0.0, z0), (lift_of(inner), z1)), ((room, y0), (room + lift_of(outer), y1))
    return lines_apart(one, other), angle


def plate_of(grooves: Mapping[str, FaceGroove], rim: Loop, width: float, bore: Bore | None) -> GroovedPlate:
    """The plate 0 <= z <= width with these grooves by name, and with its walls."""
    each, names = tuple(grooves.values()), tuple(grooves)
    walls = list[Wall]()
    for name, groove in grooves.items():
        walls += least_wall(groove.inner, partial(bore_walls, f"{name}, inner flank", bore=bore))
        thickness, angle = walls_apart(groove.outer, rim, (groove.heights, (0.0, width)))
        walls.append(Wall(f"{name}, outer flank to rim", thickness, angle, "a smaller groove, or a larger rim"))
    walls += face_walls(each, names, (0.0, width))
    return GroovedPlate("cam", rim, each, 0.0, width, bore, tuple(walls))


def face_walls(grooves: Sequence[FaceGroove], names: Sequence[str], ends: tuple[float, float]) -> tuple[Wall, ...]:
    """What is left under the floor of each groove, or between the grooves of both faces where they come nearer.

    Grooves whose floors pass over each other leave the web from floor to floor; grooves beside each other what is left
    between their walls, across and along the axis: as if their roots were sharp, which takes nothing from the wall.
    """
    under = [
        Wall(f"{name}, under the floor", abs(groove.floor - (ends[0] if groove.way > 0.0 else ends[1])), None,
             "a wider plate, a shallower groove")
        for groove, name in zip(grooves, names)
    ]  # fmt: skip
    if len(grooves) == 1:
        return tuple(under)
    (one, other), between = grooves, f"{names[0]} to {names[1]}"
    along = one.way * (one.floor - other.floor)
    within, at = _floors_apart(one, other)
    # Of two rings of which one is within the other, that one is not round it as well.
    around = _floors_apart(other, one)[0] if within < 0.0 else within
    inner, outer, aside, angle = (one, other, within, at) if within >= around else (other, one, around, None)
    if aside <= 0.0:
        return (Wall(f"{between}, floor to floor", along, None, APART),)
    thickness = lines_apart(_line(inner, inner.outer), _line(outer, outer.inner, aside))
    return (*under, Wall(f"{between}, edge to edge", thickness, angle, APART))


def _floors_apart(one: FaceGroove, other: FaceGroove) -> tuple[float, float]:
    """How far the floor of a groove stands within that of another one round it, in the plane, mm, and the cam angle."""
    return room_within(one.at_floor(one.outer), other.at_floor(other.inner), how_far=False)


def _line(groove: FaceGroove, loop: Loop, aside: float = 0.0) -> Line:
    """The wall of a groove seen along it, from below up; its foot stands `aside`, mm."""
    lift = lift_of(loop)
    (low, high), foot = groove.heights, aside if groove.way > 0.0 else aside - lift
    return (foot, low), (foot + lift, high)
