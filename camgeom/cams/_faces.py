"""Several tracks on one disc: a groove in each of its faces, a profile as its rim; what stands between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import hypot, inf

import numpy as np

from camgeom.cams._plate import WALL_SAMPLES, bore_walls, least_distance
from camgeom.maths import Floats
from camgeom.maths.extremum import piece_grid
from camgeom.solid.blank import Bore, Wall
from camgeom.solid.builder import Index
from camgeom.solid.prism import FaceGroove, GroovedPlate, Loop
from camgeom.track import TURN
from camgeom.track.outline import Outline

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


def plate_of(grooves: Mapping[str, FaceGroove], rim: Loop, width: float, bore: Bore | None) -> GroovedPlate:
    """The plate 0 <= z <= width with these grooves by name, and with its walls."""
    each, names = tuple(grooves.values()), tuple(grooves)
    walls = list[Wall]()
    for name, groove in grooves.items():
        walls += bore_walls(f"{name}, inner flank", groove.inner.outline, bore)
        thickness, angle = room_within(groove.outer.outline, rim.outline)
        walls.append(Wall(f"{name}, outer flank to rim", thickness, angle, "a smaller groove, or a larger rim"))
    walls += face_walls(each, names, (0.0, width))
    return GroovedPlate("cam", rim, each, 0.0, width, bore, tuple(walls))


def face_walls(grooves: Sequence[FaceGroove], names: Sequence[str], ends: tuple[float, float]) -> tuple[Wall, ...]:
    """What is left under the floor of each groove, or between the grooves of both faces where they come nearer.

    Grooves at the same radius leave the web from floor to floor; grooves beside each other what is left between their
    nearest edges, across and along the axis: as if their roots were sharp, which takes nothing from the wall.
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
    within, at = room_within(one.outer.outline, other.inner.outline, how_far=False)
    # Of two rings of which one is within the other, that one is not round it as well.
    around = room_within(other.outer.outline, one.inner.outline, how_far=False)[0] if within < 0.0 else within
    aside, angle = (within, at) if within >= around else (around, None)
    if aside <= 0.0:
        return (Wall(f"{between}, floor to floor", along, None, APART),)
    return (*under, Wall(f"{between}, edge to edge", hypot(aside, max(along, 0.0)), angle, APART))
