"""The cam together with what it drives, as an assembly: bodies of the cam, turret and rollers, each placed.

Everything stands as it does at cam angle zero, in the cam frame. A roller is one product placed many times.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from camgeom.errors import DesignError
from camgeom.export.step.brep import Assembly, Colour, Placed, Solid
from camgeom.export.step.geometry import Frame, vector
from camgeom.export.step.parts import model_bodies
from camgeom.export.step.solids import TOLERANCE, revolved_solid
from camgeom.maths import Floats
from camgeom.solid.turret import STUD_SHARE, StackedTurret, TurretBody
from camgeom.track import TURN, Arc, Swing, Track

if TYPE_CHECKING:
    from camgeom.model import Model

Point = tuple[float, float]
Side = tuple[Point, Point, Point | None, str]
"""an edge of a meridian: its ends (r, z), the centre of its arc or None, its name"""
POLE = 0.01
"""share of a ball's radius at which it is cut flat, so that no face ends in a point"""
TURRET_COLOUR: Colour = (0.72, 0.74, 0.78)
ROLLER_COLOUR: Colour = (0.85, 0.65, 0.25)


def mechanism(model: Model, tolerance: float = TOLERANCE) -> Assembly:
    """The cam's bodies, and its turret with rollers, or the rollers of its tracks.

    Raises DesignError where the follower has no rollers or the cam is undercut.
    """
    recipe = getattr(model.cam, "turret", None)
    if recipe is None and not model.tracks:
        raise DesignError(f"a {model.profile.kind} cam with this follower has no rollers to place beside it")
    body = recipe(model.setup) if recipe else None
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
        parts += _rollers(model.tracks, tolerance)
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
    frame = Frame.about(_turned(joint.centre, turn), _turned(joint.axis, turn))
    outline = ((body.radius, body.low), (body.radius, body.high))
    disc = revolved_solid(outline, names=("body",), name=name, tolerance=tolerance)
    return Placed(replace(disc, colour=TURRET_COLOUR), frame, name)


def _rollers(tracks: Sequence[Track], tolerance: float) -> list[Placed]:
    """One roller for every track, as it stands at cam angle zero; equal rollers are one product."""
    made: dict[object, Solid] = {}
    found = []
    for track in tracks:
        key = track.meridian, track.tip, track.contact
        if key not in made:
            number = f" {len(made) + 1}" if made else ""
            made[key] = roller_solid(track, f"roller{number}", None, tolerance)
        name = "roller" if len(tracks) == 1 else f"roller of {track.name}"
        found.append(Placed(made[key], _stand(track, 0.0), name))
    return found


def roller_solid(track: Track, name: str, root: float | None, tolerance: float = TOLERANCE) -> Solid:
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
    sides: list[Side] = [(start, stop, arc, "roller")]
    if root is not None:
        stud = STUD_SHARE * meridian.radius
        sides = [((stud, root), (stud, start[1]), None, "stud"), ((stud, start[1]), start, None, "end"), *sides]
    if sides[0][0][1] > sides[-1][1][1]:
        sides = [(b, a, arc, label) for a, b, arc, label in reversed(sides)]
    points = [sides[0][0], *(side[1] for side in sides)]
    shape = revolved_solid(points, [side[2] for side in sides], [side[3] for side in sides], (), name, tolerance)
    return replace(shape, colour=ROLLER_COLOUR)


def _stand(track: Track, cam_angle: float) -> Frame:
    """Where the roller's own axis and its delta = 0 are at a cam angle."""
    pose = track.pose(np.array([cam_angle]), 0)
    return Frame.about(vector(pose.a[0][:, 0]), vector(pose.u[0][:, 0]))


def _turned(values: tuple[float, float, float], turn: complex) -> Floats:
    z = (values[0] + 1j * values[1]) * turn
    return np.array([z.real, z.imag, values[2]])

