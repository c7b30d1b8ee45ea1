"""Solids from exact outlines and meridians: prisms with holes, plates with a groove in one face, bodies of revolution.

An outline is a callable: no polygon, no resampling. Where it is straight or circular between two knots the file gets
planes and cylinders, elsewhere splines within the tolerance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from math import asin, pi, sqrt
from typing import final

import numpy as np

from camgeom.errors import DesignError
from camgeom.export.step.brep import Brep, Face, Loop
from camgeom.export.step.geometry import Frame, Plane
from camgeom.export.step.shell import Shell, ShellBand, shell
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.solid import TOUCHED
from camgeom.solid.blank import Bore, arc_of
from camgeom.solid.pocket import EdgePlate, PocketPlate, named
from camgeom.solid.prism import FaceGroove, GroovedPlate, Prism
from camgeom.solid.prism import Loop as BodyLoop
from camgeom.track.outline import OutlineIntegrals

TOLERANCE = 1e-5
"""mm; default deviation of fitted curves and surfaces, a tenth of what a drawing could ask"""
VOLUME = 1e-7
"""share of a plate's volume that its edge, as it is fitted, may be off"""


@final
@immutable
class ClosedCurve:
    """A closed curve in the XY plane, run either way.

    point  exact points: parameters (n,) -> (n, 2) mm; at an inner knot either neighbour's value
    knots  ascending parameters where a derivative jumps; the last is one period after the first
    name   of the faces; a tuple names each interval between knots
    """

    point: Callable[[Floats], Floats]
    knots: tuple[float, ...]
    name: str | tuple[str, ...] = "outline"


def circle_curve(radius: float, centre: tuple[float, float] = (0.0, 0.0), name: str = "bore") -> ClosedCurve:
    """A circle, mm."""

    def point(t: Floats) -> Floats:
        return np.stack([centre[0] + radius * np.cos(t), centre[1] + radius * np.sin(t)], axis=1)

    return ClosedCurve(point, (0.0, pi, 2.0 * pi), name)


def bore_curve(diameter: float, keyway_width: float = 0.0, keyway_depth: float = 0.0) -> ClosedCurve:
    """A bore, with a keyway centred on +X where the width is not zero; depth (mm) from the bore wall on its middle."""
    radius, half = 0.5 * diameter, 0.5 * keyway_width
    if not keyway_width:
        return circle_curve(radius)
    start, chord, top = asin(half / radius), sqrt(radius * radius - half * half), radius + keyway_depth
    corners = np.array([[chord, -half], [top, -half], [top, half], [chord, half]])
    knots = (start, pi, 2.0 * pi - start, 7.0, 8.0, 9.0)
    across = np.array([2.0 * pi - start, 7.0, 8.0, 9.0])

    def point(t: Floats) -> Floats:
        arc = radius * np.stack([np.cos(t), np.sin(t)], axis=1)
        key = np.stack([np.interp(t, across, corners[:, c]) for c in (0, 1)], axis=1)
        return np.asarray(np.where((t > across[0])[:, None], key, arc))

    return ClosedCurve(point, knots, ("bore", "bore", "keyway", "keyway", "keyway"))


def bore_holes(bore: Bore | None) -> Sequence[ClosedCurve]:
    """The bore as a list of hole outlines, empty for a solid blank."""
    return [] if bore is None else [bore_curve(bore.diameter, bore.keyway_width, bore.keyway_depth)]


def wall(outline: ClosedCurve, low: float, high: float, outward: float, tolerance: float = TOLERANCE) -> Shell:
    """The shell straight along Z over an outline from z = low to z = high, mm; outward -1 for a hole."""
    return standing([upright(outline, low, high)], outline, outward, tolerance)


def upright(outline: ClosedCurve, low: float, high: float, upper: ClosedCurve | None = None) -> ShellBand:
    """The band straight along Z over an outline from z = low to z = high, mm; to another outline at the same knots
    where one is given."""

    def point(t: Floats, share: Floats) -> Floats:
        flat = outline.point(t)
        x = np.empty((len(t), len(share), 3))
        x[..., :2] = flat[:, None, :]
        if upper is not None:
            x[..., :2] += (upper.point(t) - flat)[:, None, :] * share[:, None]
        x[..., 2] = low * (1.0 - share) + high * share
        return x

    return ShellBand(outline.name, point, degree=1)


def standing(bands: Sequence[ShellBand], outline: ClosedCurve, outward: float, tolerance: float) -> Shell:
    """The shell of bands from the lowest up that stand about an outline; outward -1 for a hole."""
    knots = np.array(outline.knots)
    turn = outward * _running(outline.point(np.linspace(knots[0], knots[-1], 361)[:-1]))
    return shell(bands, knots, turn, tolerance)


def _running(points: Floats) -> float:
    """+1 where a closed polygon (n, 2) runs counter-clockwise, -1 where clockwise."""
    x, y = points.T
    return 1.0 if float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum()) > 0.0 else -1.0


def flat_end(name: str, z: float, up: bool, loops: Sequence[Loop]) -> Face:
    """A flat face at z (mm) whose normal is +Z where up, else -Z; outer loop first, as the shells hand them over."""
    normal = 1.0 if up else -1.0
    return Face(name, Plane(Frame.about((0.0, 0.0, z), (0.0, 0.0, normal))), tuple(loops))


def prism_solid(
    outline: ClosedCurve,
    z0: float,
    z1: float,
    holes: Sequence[ClosedCurve] = (),
    name: str = "cam",
    tolerance: float = TOLERANCE,
) -> Brep:
    """The prism z0 <= z <= z1 (mm) over an outline, with holes through it: the solid of every planar cam.

    >>> from camgeom.export.step.check import check_solid
    >>> round(check_solid(prism_solid(circle_curve(1.0), 0.0, 4.0)).volume, 9)
    12.566370614
    """
    return closed_solid(name, wall(outline, z0, z1, 1.0, tolerance), (z0, z1), holes, tolerance)


def closed_solid(
    name: str, body: Shell, ends: tuple[float, float], holes: Sequence[ClosedCurve] = (), tolerance: float = TOLERANCE
) -> Brep:
    """Close a shell that runs round the axis from a ring at z = ends[0] to one at ends[1] by flat ends with holes."""
    inner = [wall(hole, *ends, -1.0, tolerance) for hole in holes]
    bottom = flat_end("end", ends[0], False, [body.first, *(hole.first for hole in inner)])
    top = flat_end("end", ends[1], True, [body.last, *(hole.last for hole in inner)])
    faces = (*body.faces, *(face for hole in inner for face in hole.faces), bottom, top)
    return Brep(name, faces, deviation=max(s.deviation for s in (body, *inner)))


def revolved_band(name: str, meridian: Callable[[Floats], Floats], degree: int = 5) -> ShellBand:
    """A band of revolution about Z: meridian share (m,) -> (m, 2) of (r, z) mm; phi is the angle, so knots are too."""

    def point(phi: Floats, share: Floats) -> Floats:
        rz = meridian(share)
        x = np.empty((len(phi), len(share), 3))
        x[..., 0], x[..., 1] = np.outer(np.cos(phi), rz[:, 0]), np.outer(np.sin(phi), rz[:, 0])
        x[..., 2] = rz[:, 1]
        return x

    return ShellBand(name, point, degree)


def line_meridian(start: tuple[float, float], end: tuple[float, float]) -> Callable[[Floats], Floats]:
    """A straight meridian from (r, z) to (r, z), mm."""
    a, b = np.array(start, dtype=float), np.array(end, dtype=float)
    return lambda share: np.asarray(a * (1.0 - share[:, None]) + b * share[:, None])


def arc_meridian(
    start: tuple[float, float], end: tuple[float, float], centre: tuple[float, float]
) -> Callable[[Floats], Floats]:
    """The shorter arc about a centre from (r, z) to (r, z), mm."""
    c, radius, a0, sweep = arc_of(start, end, centre)

    def point(share: Floats) -> Floats:
        angle = a0 + sweep * share
        return np.asarray(c + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))

    return point


def revolved_solid(
    points: Sequence[tuple[float, float]],
    arcs: Sequence[tuple[float, float] | None] = (),
    names: Sequence[str] = (),
    name: str = "blank",
    tolerance: float = TOLERANCE,
) -> Brep:
    """A body of revolution about Z: points (r, z) mm from the lower end ring to the upper, lines or arcs between.

    arcs   for each outline edge None (a line) or the arc's centre (r, z)
    names  of the faces, one for each outline edge
    The flat ends are at the first and last z.
    """
    pairs = list(pairwise(points))
    centres = list(arcs) or [None] * len(pairs)
    labels = list(names) or ["land"] * len(pairs)
    bands = [
        revolved_band(label, line_meridian(a, b), 1) if c is None else revolved_band(label, arc_meridian(a, b, c))
        for (a, b), c, label in zip(pairs, centres, labels)
    ]
    body = shell(bands, np.array([0.0, pi, 2.0 * pi]), 1.0, tolerance)
    return closed_solid(name, body, (float(points[0][1]), float(points[-1][1])), (), tolerance)


def planar_solid(body: Prism, tolerance: float = TOLERANCE) -> Brep:
    """The prism as a solid whose fitted faces are within `tolerance` mm of the exact ones.

    Raises DesignError where the outline turns back on itself or the bore breaks through it.
    """
    holes = [*(closed(hole, body.name) for hole in body.holes), *bore_holes(body.bore)]
    ends = body.z0, body.z1
    return closed_solid(body.name, walled(body.outer, body, ends, 1.0, tolerance), ends, holes, tolerance)


def walled(
    loop: BodyLoop, body: Prism | GroovedPlate, ends: tuple[float, float], outward: float, tolerance: float
) -> Shell:
    """The shell of a wall round the bore between two heights; outward -1 for a hole."""
    curves = [closed(replace(loop, outline=outline, upper=None), body.name) for outline in loop.ends]
    for curve in curves:
        keep_bore_inside(curve, body.bore, body.name)
    return standing([upright(curves[0], *ends, *curves[1:])], curves[0], outward, tolerance)


def grooved_plate_solid(body: GroovedPlate, tolerance: float = TOLERANCE) -> Brep:
    """The plate with a groove in one face or in both; raises as `planar_solid`."""
    body.refuse_open()
    ends = body.z0, body.z1
    rim_of = body.rim
    outside = (wall(closed(rim_of, body.name), *ends, 1.0, tolerance) if rim_of.upper is None
               else walled(rim_of, body, ends, 1.0, tolerance))  # fmt: skip
    bore = [wall(hole, body.z0, body.z1, -1.0, tolerance) for hole in bore_holes(body.bore)]
    shells, flats, open_faces = [outside, *bore], list[Face](), {1.0, -1.0}
    for groove in body.grooves:
        far, near = (_flank(groove, loop, body, side, tolerance)
                     for loop, side in ((groove.outer, -1.0), (groove.inner, 1.0)))  # fmt: skip
        up = groove.way > 0.0
        (out, hole), (far_foot, near_foot) = (
            (([one.last for one in (outside, far)], [one.last for one in (near, *bore)]), (far.first, near.first)) if up
            else (([one.first for one in (outside, far)], [one.first for one in (near, *bore)]), (far.last, near.last))
        )
        flats += [flat_end("end", groove.top, up, out), flat_end("end", groove.top, up, hole),
                  flat_end("floor", groove.floor, up, [far_foot, near_foot])]  # fmt: skip
        shells += [far, near]
        open_faces.discard(groove.way)
    for way in open_faces:
        rings = [one.last if way > 0.0 else one.first for one in (outside, *bore)]
        flats.append(flat_end("end", body.z1 if way > 0.0 else body.z0, way > 0.0, rings))
    faces = (*(face for found in shells for face in found.faces), *flats)
    return Brep(body.name, faces, deviation=max(found.deviation for found in shells))


def pocket_solid(body: PocketPlate, tolerance: float = TOLERANCE) -> Brep:
    """The plate with a pocket in its upper face; raises as `planar_solid`."""
    rim, pocket = (closed(loop, body.name) for loop in (body.rim, body.pocket))
    outside = wall(rim, 0.0, body.top, 1.0, tolerance)
    inside = wall(pocket, body.floor, body.top, -1.0, tolerance)
    flats = (
        flat_end("end", 0.0, False, [outside.first]),
        flat_end("end", body.top, True, [outside.last, inside.last]),
        flat_end("floor", body.floor, True, [inside.first]),
    )
    return Brep(body.name, (*outside.faces, *inside.faces, *flats), deviation=max(outside.deviation, inside.deviation))


def edge_solid(body: EdgePlate, tolerance: float = TOLERANCE) -> Brep:
    """The plate whose upper edge a roller runs on; raises as `planar_solid`."""
    whole = closed(BodyLoop(body.outline, TOUCHED), body.name)
    knots = np.array(whole.knots)
    outline = replace(whole, name=tuple(named(0.5 * (knots[:-1] + knots[1:]))))
    # Of a narrow plate a little off its edge is much of its volume.
    plane = OutlineIntegrals(body.outline).properties
    narrow = min(tolerance, max(0.1 * tolerance, VOLUME * 2.0 * plane.area / plane.perimeter))
    side = wall(outline, 0.0, body.top, 1.0, narrow)
    flats = flat_end("end", 0.0, False, [side.first]), flat_end("end", body.top, True, [side.last])
    return Brep(body.name, (*side.faces, *flats), deviation=side.deviation)


def _flank(groove: FaceGroove, loop: BodyLoop, body: GroovedPlate, outward: float, tolerance: float) -> Shell:
    """The shell of one flank with its root, from the lower end up."""
    if not groove.root:
        return walled(loop, body, groove.heights, outward, tolerance)
    up, outline = groove.way > 0.0, closed(loop, body.name)
    keep_bore_inside(outline, body.bore, body.name)

    def root(phi: Floats, share: Floats) -> Floats:
        points = groove.root_points(loop, phi, 1.0 - share if up else share)
        return np.ascontiguousarray(np.moveaxis(points, 0, -1))

    bands = [ShellBand("root", root), upright(outline, groove.foot, groove.top)]
    return standing(bands if up else [upright(outline, groove.top, groove.foot), bands[0]], outline, outward, tolerance)


def closed(loop: BodyLoop, body: str, samples: int = 721) -> ClosedCurve:
    """A loop's outline. Raises DesignError where it has a cusp or turns back (its speed vanishes or changes sign)."""
    outline = loop.outline
    knots = outline.knots()
    phi = np.linspace(knots[0], knots[-1], samples)
    speed = outline.curve(phi).speed
    if float((speed * np.sign(speed[0])).min()) <= 0.0:
        worst = int(np.argmin(speed * np.sign(speed[0])))
        raise DesignError(
            f"{body!r}: the outline {loop.name!r} turns back on itself at cam angle {np.degrees(phi[worst]):.6g} deg, "
            "so it bounds no body; use a smaller roller, a larger cam or a gentler motion"
        )
    return ClosedCurve(lambda t: np.ascontiguousarray(outline.curve(t).points.T), tuple(knots.tolist()), loop.name)


def keep_bore_inside(outline: ClosedCurve, bore: Bore | None, body: str, samples: int = 721) -> None:
    """Raise DesignError where a bore about the axis reaches the outline."""
    if bore is None:
        return
    nearest = float(np.hypot(*outline.point(np.linspace(outline.knots[0], outline.knots[-1], samples)).T).min())
    if nearest <= bore.reach:
        raise DesignError(
            f"{body!r}: the bore reaches {bore.reach:.6g} mm from the axis, the outline is {nearest:.6g} mm from it"
        )
