"""From a model to the bodies of a STEP file: those of the cam, or the cam together with what it drives.

The assembly stands as it does at cam angle zero, in the cam frame. A roller is one product placed many times.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from camgeom.errors import CamgeomError, DesignError, ExportError
from camgeom.export import NO_PLATE, NO_ROLLERS, Colour
from camgeom.export.step.brep import Assembly, Brep, Edge, Face, FacetBody, Loop, Placed, Use, reversed_loop, vertex
from camgeom.export.step.cut import cut_solid
from camgeom.export.step.geometry import Circle, Cone, Frame, Line, Plane, vector
from camgeom.export.step.groove import (
    end_face_solid,
    grooved_ring_solid,
    grooved_solid,
    grooves_solid,
    ribbed_solid,
)
from camgeom.export.step.solids import (
    TOLERANCE,
    ClosedCurve,
    edge_solid,
    grooved_plate_solid,
    planar_solid,
    pocket_solid,
    prism_solid,
    revolved_solid,
)
from camgeom.maths import Floats
from camgeom.solid.bell import GroovedRing
from camgeom.solid.cut import CutBlank, IndexingCut
from camgeom.solid.drum import EndFaceRing, GroovedCylinder, RibbedCylinder
from camgeom.solid.frame import FramePlate
from camgeom.solid.grooves import GroovedDrum
from camgeom.solid.pocket import EdgePlate, PocketPlate
from camgeom.solid.prism import GroovedPlate, Prism
from camgeom.solid.turret import STUD_SHARE, StackedTurret, TurretBody, turned
from camgeom.track import TURN, Arc, Swing, Track

if TYPE_CHECKING:
    from camgeom.model import Model

Point = tuple[float, float]
MeridianEdge = tuple[Point, Point, Point | None, str]
"""an edge of a meridian: its ends (r, z), the centre of its arc or None, its name"""
POLE = 0.01
"""share of a ball's radius at which it is cut flat, so that no face ends in a point"""
TURRET_COLOUR: Colour = (0.72, 0.74, 0.78)
ROLLER_COLOUR: Colour = (0.85, 0.65, 0.25)

EXACT: dict[type, Callable[[Any, float], Brep]] = {
    GroovedCylinder: grooved_solid,
    GroovedDrum: grooves_solid,
    RibbedCylinder: ribbed_solid,
    EndFaceRing: end_face_solid,
    GroovedRing: grooved_ring_solid,
    Prism: planar_solid,
    GroovedPlate: grooved_plate_solid,
    PocketPlate: pocket_solid,
    EdgePlate: edge_solid,
    CutBlank: cut_solid,
    IndexingCut: cut_solid,
}
"""How a kind of part becomes a boundary representation: (part, tolerance mm) -> Brep."""


def model_bodies(model: Model, tolerance: float = TOLERANCE) -> Brep | FacetBody | Assembly:
    """A model's bodies: exact where the kind of part has a boundary representation, else the triangles of its mesh.

    Several bodies become an assembly. Raises DesignError where the cam is undercut and no body is made of it.
    """
    try:
        model.refuse_folded()
    except DesignError as error:
        bodies: list[Brep | FacetBody] = [_facets(model, index, error) for index in range(len(model.solids))]
    else:
        bodies = [_body(model, index, tolerance) for index in range(len(model.parts))]
    if model.mechanism.frame is not None:
        bodies.append(frame_of(model, tolerance))
    if len(bodies) == 1:
        return bodies[0]
    return Assembly(model.profile.name, tuple(Placed(body) for body in bodies))


def frame_of(model: Model, tolerance: float = TOLERANCE) -> Brep:
    """The frame about the cam as it stands at zero lift. Raises ExportError where it is no part."""
    plate = model.mechanism.frame
    if plate is None:
        raise ExportError(NO_PLATE)
    density = model.profile.material.roller.density * 1e-9
    return replace(frame_solid(plate, tolerance), colour=TURRET_COLOUR, density=density)


def _body(model: Model, index: int, tolerance: float) -> Brep | FacetBody:
    part = model.parts[index]
    build = EXACT.get(type(part))
    if build is None:
        return _facets(model, index, f"a {type(part).__name__} has no exact faces")
    try:
        return replace(build(part, tolerance), density=model.profile.material.cam.density * 1e-9)
    except CamgeomError as error:
        return _facets(model, index, error)


def _facets(model: Model, index: int, reason: object) -> FacetBody:
    solid = model.solids[index]
    return FacetBody(solid.name, solid.mesh, deviation=solid.chord_error, reason=str(reason))


def notes(shape: Brep | FacetBody | Assembly) -> list[dict[str, Any]]:
    """What a file holds, body by body, as plain data: exact faces or triangles, and their deviation in mm."""
    placed = [part.body for part in shape.parts] if isinstance(shape, Assembly) else [shape]
    found = []
    for body in dict.fromkeys(placed):
        exact = isinstance(body, Brep)
        note: dict[str, Any] = {
            "name": body.name,
            "faces": "exact" if exact else "triangles",
            "deviation_mm": body.deviation,
            "count": placed.count(body),
        }
        if isinstance(body, FacetBody):
            note["reason"] = body.reason
        found.append(note)
    return found


def assembly_of(model: Model, tolerance: float = TOLERANCE) -> Assembly:
    """The cam's bodies, and its turret with rollers, the rollers of its tracks, or the frame about it.

    Raises DesignError where the follower has no rollers and is no part, or the cam is undercut.
    """
    turret = model.mechanism.turret
    if turret is None and not model.tracks and model.mechanism.frame is None:
        raise DesignError(NO_ROLLERS)
    body = turret.body if turret else None
    cam = model_bodies(model, tolerance)
    parts = list(cam.parts) if isinstance(cam, Assembly) else [Placed(cam)]
    if isinstance(body, StackedTurret):
        shaft = replace(body.rings[0], rollers=0, radius=body.shaft, low=body.low, high=body.high)
        parts.append(_disc(shaft, "shaft", tolerance))
        for number, ring in enumerate(body.rings, 1):
            parts += _turret(ring, f" {number}", tolerance)
    elif isinstance(body, TurretBody):
        parts += _turret(body, "", tolerance)
    else:
        parts += _rollers(model, tolerance)
    return Assembly(f"{model.profile.name}, assembly", tuple(parts))


def _turret(body: TurretBody, suffix: str, tolerance: float) -> list[Placed]:
    """The disc and its rollers, whose studs stand in it."""
    roller = roller_solid(body.track, f"roller{suffix}", body.root, tolerance)
    tracks = [replace(body.track, shift=body.track.shift + k * TURN / body.rollers) for k in range(body.rollers)]
    placed = [
        Placed(roller, _stand(track, body.cam_angle), f"roller{suffix} {k}") for k, track in enumerate(tracks, 1)
    ]
    return [_disc(body, f"turret{suffix}", tolerance), *placed]


def _disc(body: TurretBody, name: str, tolerance: float) -> Placed:
    joint = body.track.joint
    assert isinstance(joint, Swing)
    turn = np.exp(-1j * body.track.sense * body.cam_angle)
    frame = Frame.about(turned(joint.centre, turn), turned(joint.axis, turn))
    outline = ((body.radius, body.low), (body.radius, body.high))
    disc = revolved_solid(outline, names=("body",), name=name, tolerance=tolerance)
    return Placed(replace(disc, colour=TURRET_COLOUR), frame, name)


def _rollers(model: Model, tolerance: float) -> list[Placed]:
    """One roller for every track of every follower, as it stands at cam angle zero; equal rollers are one product."""
    made: dict[object, Brep] = {}
    found = []
    tracks = [(one, track) for one in model.bindings for track in one.tracks]
    for one, track in tracks:
        key = track.meridian, track.tip, track.contact
        if key not in made:
            number = f" {len(made) + 1}" if made else ""
            made[key] = roller_solid(track, f"roller{number}", None, tolerance)
        name = "roller" if len(tracks) == 1 else f"roller of {track.name}"
        if len(model.bindings) > 1:
            name += f", follower {one.number + 1}"
        found.append(Placed(made[key], _stand(track, -one.angle), name))
    return found


def roller_solid(track: Track, name: str, root: float | None, tolerance: float = TOLERANCE) -> Brep:
    """A roller as a body of revolution about Z, z = delta; with a stud as far as delta = root where one is given."""
    meridian = track.meridian
    inner = max(track.contact) if track.tip_sign < 0.0 else min(track.contact)
    t = np.array([meridian.parameter(inner), meridian.parameter(track.tip)])
    arc = None
    if isinstance(meridian, Arc):
        # Cut flat where the arc comes near the axis: radius - arc (1 - cos t) = POLE radius.
        most = float(np.arccos(max(-1.0, 1.0 - (1.0 - POLE) * meridian.radius / meridian.arc)))
        t = np.clip(t, -most, most)
        arc = (meridian.radius - meridian.arc, meridian.centre)
    delta, _, _, r, _, _ = meridian.jet(t)
    start, stop = ((float(radius), float(z)) for radius, z in zip(r, delta))
    sides: list[MeridianEdge] = [(start, stop, arc, "roller")]
    if root is not None:
        stud = STUD_SHARE * meridian.radius
        sides = [((stud, root), (stud, start[1]), None, "stud"), ((stud, start[1]), start, None, "end"), *sides]
    if sides[0][0][1] > sides[-1][1][1]:
        sides = [(b, a, arc, label) for a, b, arc, label in reversed(sides)]
    points = [sides[0][0], *(side[1] for side in sides)]
    shape = revolved_solid(points, [side[2] for side in sides], [side[3] for side in sides], name, tolerance)
    return replace(shape, colour=ROLLER_COLOUR)


def _stand(track: Track, cam_angle: float) -> Frame:
    """Where the roller's own axis and its delta = 0 are at a cam angle."""
    pose = track.pose(np.array([cam_angle]), 0)
    return Frame.about(vector(pose.a[0][:, 0]), vector(pose.u[0][:, 0]))


ALONG = (1.0, 0.0, 0.0)
"""the motion, along which the guide bores run"""


def frame_solid(plate: FramePlate, tolerance: float = TOLERANCE) -> Brep:
    """The frame of a constant-width cam with its window and guide bores: planes and cylinders, nothing fitted."""
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
