"""The grooves and lands of an indexing cam stitched together, cut off at both ends and closed to a solid."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats
from camgeom.maths.clip import clip, open_loops
from camgeom.maths.rounds import TURN, Rounds, Strip, sample_rounds
from camgeom.solid.blank import Blank, Builder, bore_walls, chord_step
from camgeom.solid.drum import Solid, cell_faces
from camgeom.solid.lands import land_of
from camgeom.solid.stitch import Section, TurretSurface
from camgeom.solid.turret_lands import Edge, NotOneSurface, land_net
from camgeom.solid.turret_lands import Strip as Land

Index = npt.NDArray[np.int64]
Labels = npt.NDArray[np.uint8]
METHOD = "direct, ends cut"
ON_PLANE = 1e-3
"""share of the tolerance within which a vertex beside an end plane is laid on it"""


def groove_solid(
    name: str, blank: Blank, edge: int, sections: tuple[Section, ...], expected_genus: int, tolerance: float
) -> Solid:
    """A blank whose outline edge `edge` is cut by grooves; sections end on that edge's surface.

    Raises NotOneSurface where the topology is not that of separate grooves, NotConverged as `sample_rounds` does.
    """
    land = land_of(blank, edge)
    if land is None:
        raise NotOneSurface("the blank's outside is neither a cylinder nor a globoid")
    low, high = blank.outline[edge][1], blank.outline[edge + 1][1]
    surface = TurretSurface(sections, land, low, high)
    knots = replace(sections[0].track, span=(0.0, TURN)).knots()
    rounds = sample_rounds(surface, knots, (1.0 - ON_PLANE) * tolerance, surface.most)
    whole, sag = stitched(surface, rounds, (1.0 - ON_PLANE) * tolerance)
    points, cut = whole.points, whole.crossing(low, high, ON_PLANE * tolerance)
    faces, label = whole.faces[cut], whole.label[cut]
    for height, sign in ((high, 1.0), (low, -1.0)):
        points[np.abs(points[:, 2] - height) < ON_PLANE * tolerance, 2] = height
        points, faces, label = clip(points, faces, label, height, sign)
    builder = Builder()
    builder.add(points)
    for k, group in enumerate(whole.names):
        builder.faces(np.concatenate([whole.faces[~cut & (whole.label == k)], faces[label == k]]), group)
    _close(builder, points, faces, blank, edge, tolerance)
    error = max(rounds.worst, sag) + ON_PLANE * tolerance
    return Solid(name, builder.mesh(), error, METHOD, expected_genus)


@dataclass(frozen=True, eq=False)
class Sheet:
    """An open surface: points (v, 3), outward faces (f, 3), and the number (f,) of each face's name."""

    points: Floats
    faces: Index
    label: Labels
    names: tuple[str, ...]

    def crossing(self, low: float, high: float, near: float) -> npt.NDArray[np.bool_]:
        """Which faces reach to within `near` of the two heights, or beyond."""
        off = (self.points[:, 2] < low + near) | (self.points[:, 2] > high - near)
        return np.asarray(off[self.faces].any(axis=1))


def stitched(surface: TurretSurface, rounds: Rounds, tolerance: float) -> tuple[Sheet, float]:
    """Grooves and lands as one surface that runs on beyond the cam's ends, and the largest sag of the lands, mm."""
    strips = rounds.strips[: len(surface.sections)]
    surface.check(rounds.theta, strips, rounds.counts[:-1])
    names = tuple(dict.fromkeys([*surface.names, "land"]))
    bands = np.repeat(np.array([names.index(name) for name in surface.names], dtype=np.uint8), rounds.counts[:-1])
    points = [strip.corner.reshape(3, -1) for strip in strips]
    starts = np.cumsum([0, *(x.shape[1] for x in points)])
    numbers = [
        start + np.arange(x.shape[1]).reshape(strip.corner.shape[1:]) for start, x, strip in zip(starts, points, strips)
    ]
    if surface.closed:
        for number in numbers:
            number[-1] = number[0]
    found = [_groove_faces(surface, *each, bands) for each in zip(strips, numbers, rounds.rising)]
    count, worst = int(starts[-1]), 0.0
    for between in surface.lands:
        rims = [
            None if groove is None else _edge(surface, strips[groove], numbers[groove], rounds.theta, upper, offset)
            for groove, upper, offset in ((between.lower, True, 0), (between.upper, False, between.offset))
        ]
        net = land_net(Land(surface.land, rims[0], rims[1], surface.ends, surface.closed), count, tolerance)
        points.append(surface.points(net.x, net.w))
        faces = net.faces if surface.outward[1] else net.faces[:, ::-1]
        found.append((faces, np.full(len(faces), names.index("land"), dtype=np.uint8)))
        count, worst = count + len(net.x), max(worst, net.sag)
    every = np.concatenate([faces for faces, _ in found])
    label = np.concatenate([label for _, label in found])
    return Sheet(np.ascontiguousarray(np.concatenate(points, axis=1).T), every, label, names), worst


def _edge(surface: TurretSurface, strip: Strip, number: Index, theta: Floats, upper: bool, offset: int) -> Edge:
    """One edge of a groove as the rim of a land."""
    row, x, w = surface.rim(strip, upper, theta, offset)
    return Edge(x, w, number[:, row])


def _groove_faces(
    surface: TurretSurface, strip: Strip, number: Index, rising: npt.NDArray[np.bool_], bands: Labels
) -> tuple[Index, Labels]:
    """Faces (f, 3) and labels (f,) of the cells of a groove that reach between the cam's ends."""
    on = strip.within(surface.low, surface.high)
    p00, p10, p11, p01 = number[:-1, :-1][on], number[1:, :-1][on], number[1:, 1:][on], number[:-1, 1:][on]
    cells = cell_faces(p00, p10, p11, p01, rising[on], inward=not surface.outward[0])
    return cells.reshape(-1, 3), np.repeat(np.broadcast_to(bands, on.shape)[on], 2)


def _close(builder: Builder, points: Floats, faces: Index, blank: Blank, edge: int, tolerance: float) -> None:
    """Add the flat ends with hubs and bore."""
    outline = blank.outline
    holes: tuple[Index | None, Index | None] = None, None
    if blank.bore is not None:
        holes = bore_walls(builder, blank.bore, outline[0][1], outline[-1][1], tolerance)[:2]
    for upper in (False, True):
        height = outline[edge + 1 if upper else edge][1]
        loops = open_loops(faces, points[:, 2] == height)
        if not loops:
            raise NotOneSurface("the surface does not end in simple loops at the cam's ends")
        # Faces run along their ends the other way round than the flat end that joins them.
        rings = [loop[::-1] if upper else loop for loop in loops]
        hub = _hub(builder, blank, edge, upper, tolerance)
        hole = holes[1 if upper else 0]
        if hub is None:
            flat(builder, rings, hole, upper)
        else:
            flat(builder, rings, hub[0], upper)
            flat(builder, [hub[1]], hole, upper)


def _hub(builder: Builder, blank: Blank, edge: int, upper: bool, tolerance: float) -> tuple[Index, Index] | None:
    """Add the walls of what the outline has beyond one end; its rings there and at its far side; None for nothing."""
    outline = blank.outline[edge + 1 :] if upper else blank.outline[edge::-1]
    if len(outline) == 1:
        return None
    names = blank.names or ("land",) * (len(blank.outline) - 1)
    arcs = blank.arcs or (None,) * (len(blank.outline) - 1)
    beyond = slice(edge + 1, None) if upper else slice(edge - 1 if edge else None, None, -1)
    if outline[1][1] != outline[0][1] or any(arc is not None for arc in arcs[beyond]):
        raise NotOneSurface("the cam's end is not flat, or its hubs are not straight")
    parts = max(12, ceil(TURN / chord_step(max(r for r, _ in outline[1:]), tolerance)))
    angle = TURN * np.arange(parts) / parts
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rings = [builder.add(np.column_stack([r * circle, np.full(parts, z)])) for r, z in outline[1:]]
    for near, far, group in zip(rings[:-1], rings[1:], names[beyond][1:]):
        builder.band(*((near, far) if upper else (far, near)), group)
    return rings[0], rings[-1]


def flat(builder: Builder, rings: list[Index], hole: Index | None, up: bool) -> None:
    """Add the flat face within rings of vertices (counter-clockwise, holes clockwise) less a counter-clockwise `hole`.

    Raises NotOneSurface where the rings cross.
    """
    import manifold3d

    every = [*rings, *([] if hole is None else [hole[::-1]])]
    planes = [builder.points(ring)[:, :2] for ring in every]
    areas = [_area(plane) for plane in planes]
    number = np.asarray(manifold3d.triangulate([np.ascontiguousarray(plane) for plane in planes])).astype(np.int64)
    wanted = sum(len(plane) - 2 if area > 0.0 else len(plane) + 2 for plane, area in zip(planes, areas))
    a, b, c = (np.concatenate(planes)[number[:, k]] for k in range(3))
    covered = 0.5 * ((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]))
    if len(number) != wanted or covered.min() < -1e-9 * sum(areas):
        raise NotOneSurface("the outlines of a flat end cross")
    faces = np.concatenate(every)[number]
    builder.faces(faces if up else faces[:, ::-1], "end")


def _area(plane: Floats) -> float:
    """Signed area of a polygon (n, 2), mm²."""
    x, y = plane.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
