"""The frame of a constant-width cam as a boundary representation: planes and cylinders, nothing fitted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from camgeom.export.step.brep import Brep, Edge, Face, Loop, Use, reversed_loop, vertex
from camgeom.export.step.geometry import Circle, Cone, Frame, Line, Plane
from camgeom.export.step.solids import TOLERANCE, ClosedCurve, prism_solid
from camgeom.maths import Floats
from camgeom.solid.frame import FramePlate

ALONG = (1.0, 0.0, 0.0)
"""the motion, along which the guide bores run"""


def frame_solid(plate: FramePlate, tolerance: float = TOLERANCE) -> Brep:
    """The plate with its window and guide bores."""
    corners = np.concatenate([plate.outside, plate.outside[:1]])

    def rim(t: Floats) -> Floats:
        return np.stack([np.interp(t, np.arange(5.0), corners[:, axis]) for axis in (0, 1)], axis=1)

    def window(t: Floats) -> Floats:
        number = np.clip(t.astype(int), 0, len(plate.sides) - 1)
        points = np.empty((len(t), 2))
        for k, side in enumerate(plate.sides):
            points[number == k] = side.at(t[number == k] - k)
        return points

    knots = tuple(float(k) for k in range(len(plate.sides) + 1))
    outside = ClosedCurve(rim, (0.0, 1.0, 2.0, 3.0, 4.0), "outside")
    hole = ClosedCurve(window, knots, tuple(side.name for side in plate.sides))
    whole = prism_solid(outside, *plate.levels, [hole], plate.name, tolerance)
    bores = [_bore(plate, y) for y in plate.rods]
    faces = [_pierced(face, plate, [(first, last) for _, first, last in bores]) for face in whole.faces]
    return replace(whole, faces=(*faces, *(face for each, _, _ in bores for face in each)))


def _pierced(face: Face, plate: FramePlate, rims: list[tuple[Loop, Loop]]) -> Face:
    """An end of the plate with the rims of the guide bores; other faces as they are."""
    if face.name != "outside" or not isinstance(face.surface, Plane):
        return face
    xs = {use.first.point[0] for use in face.loops[0]}
    if len(xs) > 1:
        return face
    near = abs(xs.pop() - plate.ends[0]) > 0.5 * plate.length
    return replace(face, loops=(*face.loops, *(last if near else first for first, last in rims)))


def _bore(plate: FramePlate, y: float) -> tuple[list[Face], Loop, Loop]:
    """Both halves of the wall of a guide bore, and its rims as the ends at small and at large x pass them."""
    radius, rims, corners = 0.5 * plate.bore, [], []
    for x in plate.ends:
        frame = Frame((x, y, plate.height), ALONG, (0.0, 1.0, 0.0))
        corners.append([vertex((x, y + way * radius, plate.height)) for way in (1.0, -1.0)])
        left, right = corners[-1]
        circle = Circle(frame, radius)
        rims.append([Edge(circle, left, right), Edge(circle, right, left)])
    lines = [Edge(Line(low.point, ALONG), low, high) for low, high in zip(*corners)]
    surface = Cone(Frame((plate.ends[0], y, plate.height), ALONG, (0.0, 1.0, 0.0)), radius)
    faces = []
    for half in (0, 1):
        loop = (Use(rims[0][half]), Use(lines[1 - half]), Use(rims[1][half], False), Use(lines[half], False))
        # The material lies outside of the cylinder, so that its outward normal points to the axis.
        faces.append(Face("guide bore", surface, (reversed_loop(loop),), same_sense=False))
    first: Loop = tuple(Use(edge) for edge in rims[0])
    last: Loop = tuple(Use(edge) for edge in rims[1])
    return faces, first, reversed_loop(last)
