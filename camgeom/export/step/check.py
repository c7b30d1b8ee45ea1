"""Judge a boundary representation without a CAD kernel: topology, tolerances, orientation, volume and area.

Volume and area are integrals over the faces: spline faces that fill their rectangle by Gauss quadrature over it, all
others by Green's theorem in the surface's parameters along their loops. Both are exact to rounding for the shape that
is written, so they can be compared with a mesh's or a closed form.
"""

from __future__ import annotations

from itertools import pairwise
from typing import final

import numpy as np

from camgeom.export.step.brep import Brep, Face, Loop, Use, gauss
from camgeom.export.step.geometry import Plane, SplineSurface, Surface, largest_gap, solve_pairs
from camgeom.immutable import immutable
from camgeom.maths import Floats, gauss_rule


@final
@immutable(eq=True)
class Soundness:
    """What a solid is.

    problems   everything wrong, in words; empty for a sound solid
    deviation  mm, largest distance of vertices from their edges and of edges from their faces, as measured
    volume     mm³, of the shape as written
    area       mm²
    genus      number of through holes, from Euler's formula
    """

    problems: tuple[str, ...]
    deviation: float
    volume: float
    area: float
    genus: int

    @property
    def sound(self) -> bool:
        """No problem found."""
        return not self.problems


def check_solid(solid: Brep, tolerance: float = 1e-3, nodes: int = 6) -> Soundness:
    """Measure a solid. A vertex off its edge or an edge off its surface by more than `tolerance` mm is a problem.

    nodes: of the integrals along spline edges, in each span; 6 leave rounding errors, 2 about a millionth
    """
    problems = [*_topology(solid)]
    at_vertices, at_edges = _vertex_gap(solid), [_edge_gap(face) for face in solid.faces]
    deviation = max([at_vertices, *at_edges])
    if at_vertices > tolerance:
        problems.append(f"a vertex is {at_vertices:.3g} mm from its edge")
    for face, gap in zip(solid.faces, at_edges):
        if gap > tolerance:
            problems.append(f"face {face.name!r}: an edge is {gap:.3g} mm from the surface")
    volume = area = 0.0
    for face in solid.faces:
        face_volume, face_area = measure_face(face, nodes)
        if face_area <= 0.0:
            problems.append(f"face {face.name!r}: its loops run against its normal")
        volume, area = volume + face_volume, area + face_area
    if volume <= 0.0:
        problems.append(f"the volume is {volume:.6g} mm³: the faces point inwards")
    return Soundness(tuple(problems), deviation, volume, area, _genus(solid))


def _topology(solid: Brep) -> list[str]:
    """Loops that do not close and edges not passed exactly once each way."""
    problems = []
    for face in solid.faces:
        for loop in face.loops:
            if any(use.last is not nxt.first for use, nxt in zip(loop, (*loop[1:], loop[0]))):
                problems.append(f"face {face.name!r}: a loop is not closed")
    passes: dict[int, list[bool]] = {}
    for use in solid.uses():
        passes.setdefault(id(use.edge), []).append(use.forward)
    wrong = sum(sorted(found) != [False, True] for found in passes.values())
    if wrong:
        problems.append(f"{wrong} edges are not shared by two faces in opposite directions")
    return problems


def _genus(solid: Brep) -> int:
    edges = solid.edges()
    vertices = {id(vertex) for edge in edges for vertex in (edge.start, edge.end)}
    rings = sum(len(face.loops) - 1 for face in solid.faces)
    return 1 - (len(vertices) - len(edges) + len(solid.faces) - rings) // 2


def _vertex_gap(solid: Brep) -> float:
    """Largest distance of an edge's vertices from the ends of its curve, mm."""
    worst = 0.0
    for edge in solid.edges():
        ends = edge.curve.at(np.array(edge.interval))
        worst = max(worst, float(np.abs(ends - np.array([edge.start.point, edge.end.point])).max()))
    return worst


def _edge_gap(face: Face) -> float:
    """Largest distance of the face's edges from its surface, mm, at 23 points an edge."""
    points = np.concatenate([use.edge.points(23) for loop in face.loops for use in loop])
    return largest_gap(face.surface.jet(*face.surface.locate(points))[0], points)


def measure_face(face: Face, nodes: int = 6) -> tuple[float, float]:
    """Share of the volume (mm³, about the origin) and area (mm²) of a face; the area is negative where the loops run
    against the face's normal."""
    sign = 1.0 if face.same_sense else -1.0
    spline = face.surface if isinstance(face.surface, SplineSurface) else None
    if spline is not None and _fills(face, spline):
        volume, area = _whole_patch(spline)
        turning = _turning(face)
        return turning * volume, turning * sign * area
    volume = area = 0.0
    for loop in face.loops:
        loop_volume, loop_area = (
            _green(face.surface, loop, nodes) if spline is None else _spline_green(spline, loop, nodes)
        )
        volume, area = volume + loop_volume, area + loop_area
    return volume, sign * area


def _flux(surface: Surface, u: Floats, v: Floats) -> tuple[Floats, Floats]:
    """x . (x_u x x_v) / 3 and |x_u x x_v| at pairs (n,)."""
    x, xu, xv = surface.jet(u, v)
    normal = np.cross(xu, xv)
    return (x * normal).sum(axis=1) / 3.0, np.sqrt((normal * normal).sum(axis=1))


def _whole_patch(surface: SplineSurface) -> tuple[float, float]:
    u, wu = gauss(surface.u.breaks, surface.u.degree + 3)
    v, wv = gauss(surface.v.breaks, surface.v.degree + 3)
    flux, area = _flux(surface, np.repeat(u, len(v)), np.tile(v, len(u)))
    weight = np.repeat(wu, len(v)) * np.tile(wv, len(u))
    return float(flux @ weight), float(area @ weight)


def _fills(face: Face, surface: SplineSurface) -> bool:
    """Whether all edges of a face lie on the border of its spline's rectangle."""
    if len(face.loops) > 1:
        return False
    u, v = surface.locate(np.concatenate([_run(use) for use in face.loops[0]]))
    rims = [(u, surface.u.start), (u, surface.u.stop), (v, surface.v.start), (v, surface.v.stop)]
    spans = surface.u.stop - surface.u.start, surface.v.stop - surface.v.start
    apart = [np.abs(values - rim) / spans[k // 2] for k, (values, rim) in enumerate(rims)]
    return bool(np.min(apart, axis=0).max() < 1e-7)


def _spline_green(surface: SplineSurface, loop: Loop, edge_nodes: int) -> tuple[float, float]:
    """As `_green` on a spline: primitives along the parameter with fewer spans, summed span by span."""
    bases, axis = (surface.u, surface.v), 0 if len(surface.u.breaks) < len(surface.v.breaks) else 1
    runs = [_passed(surface, use, edge_nodes) for use in loop]
    u, v, du, dv = (np.concatenate([run[i] for run in runs]) for i in range(4))
    inner, outer = ((u, v), (v, u))[axis]
    step = dv if axis == 0 else -du
    nodes, weights = gauss_rule(bases[axis].degree + 2)
    sums = np.zeros((2, len(inner)))
    for low, high in pairwise(bases[axis].breaks.tolist()):
        half = 0.5 * (np.clip(inner, low, high) - low)
        if not half.any():
            continue
        at, other = (low + half[:, None] * (1.0 + nodes)).ravel(), np.repeat(outer, len(nodes))
        values = _flux(surface, at, other) if axis == 0 else _flux(surface, other, at)
        sums += [(value.reshape(-1, len(nodes)) @ weights) * half for value in values]
    return float(sums[0] @ step), float(sums[1] @ step)


def _turning(face: Face) -> float:
    """+1 where the outer loop runs counter-clockwise in the parameters of a spline surface, -1 where clockwise."""
    points = np.concatenate([_run(use) for use in face.loops[0]])
    u, v = face.surface.locate(points)
    return float(np.sign((u * np.roll(v, -1) - np.roll(u, -1) * v).sum()))


def _run(use: Use) -> Floats:
    points = use.edge.points(5)
    return points[:-1] if use.forward else points[:0:-1]


def _green(surface: Surface, loop: Loop, edge_nodes: int) -> tuple[float, float]:
    """Integrals over the inside of a loop of flux and area element, as the loop integral of their u-primitives."""
    parts = [_passed(surface, use, edge_nodes) for use in loop]
    u, v, _, dv = (np.concatenate([part[i] for part in parts]) for i in range(4))
    if not isinstance(surface, Plane):
        u = np.unwrap(u)
    nodes, weights = gauss_rule(1 if isinstance(surface, Plane) else 24)
    start = float(u[0])
    half = 0.5 * (u - start)
    at = start + half[:, None] * (1.0 + nodes)
    flux, area = _flux(surface, at.ravel(), np.repeat(v, len(nodes)))
    shape = at.shape
    inner = half[:, None] * weights
    primitives = [(values.reshape(shape) * inner).sum(axis=1) for values in (flux, area)]
    return float(primitives[0] @ dv), float(primitives[1] @ dv)


def _passed(surface: Surface, use: Use, nodes: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Surface parameters at the Gauss nodes of an edge in the order of the pass, and their weighted changes."""
    t, weight = use.edge.quadrature(nodes)
    u, v = surface.locate(use.edge.curve.at(t))
    _, xu, xv = surface.jet(u, v)
    du, dv = (step * weight for step in solve_pairs(xu, xv, use.edge.curve.tangent(t)))
    if use.forward:
        return u, v, du, dv
    return u[::-1], v[::-1], -du[::-1], -dv[::-1]
