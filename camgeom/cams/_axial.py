"""Followers that move along the cam axis: a slide, or an arm whose roller swings beside the cam in a tangent plane."""

from __future__ import annotations

from math import cos, pi, radians, sin

import numpy as np

from camgeom.cams import idle, problem
from camgeom.errors import Problem
from camgeom.maths import Floats
from camgeom.motion.program import Program
from camgeom.solid.mechanism import Mechanism
from camgeom.track import Joint, Meridian, Slide, Swing, Track
from camgeom.track.follower import AnyRoller, Setup, SphereRoller, SwingingFollower, TranslatingFollower

Axial = TranslatingFollower | SwingingFollower
FACES = ("face", "face_radius", "face_width", "face_offset")


def axial_idle(follower: Axial, body: str) -> dict[str, str]:
    """Keys that mean nothing for a roller beside a `body` ("drum")."""
    kind = f"a {body}'s {follower.kind} follower"
    found = idle(f"{kind} has none; a disc's translating follower has", "follower.offset")
    found |= idle(f"{kind} swings in the plane of the pivot, to neither side", "follower.side")
    return found | idle(f"{kind} carries a roller", *(f"follower.{key}" for key in FACES))


def grooved_contact(roller: AnyRoller, outside: float, depth: float) -> tuple[float, float]:
    """Stretch of a roller that touches the flanks of a groove, along its axis as `outside` and its floor count, mm."""
    if isinstance(roller, SphereRoller):
        centre = outside - depth + 0.5 * roller.diameter
        return centre - (roller.length or 0.35 * roller.diameter), min(centre, outside)
    return outside - roller.length, outside


def ball_problems(roller: SphereRoller, depth: float) -> list[Problem]:
    """What is wrong with a ball in a groove of a depth, mm."""
    found = []
    if depth > 0.5 * roller.diameter:
        limit = f"at most half the ball's diameter, {0.5 * roller.diameter:g} mm (the equator must come out)"
        found.append(problem("cam.groove_depth", depth, limit))
    least = 0.5 * roller.diameter - depth
    if (roller.length or 0.35 * roller.diameter) <= least:
        limit = f"above {least:g} mm, from the ball's equator down into the groove"
        found.append(problem("roller.length", roller.length, limit))
    if (roller.length or 0.0) > 0.49 * roller.diameter:
        found.append(problem("roller.length", roller.length, f"below {0.49 * roller.diameter:g} mm"))
    return found


def too_long(roller: AnyRoller, depth: float) -> list[Problem]:
    """What is wrong with a roller longer than the wall that it touches, mm."""
    if (roller.length or 0.0) <= depth:
        return []
    return [problem("roller.length", roller.length, f"at most the wall height {depth:g} mm")]


def heights(follower: Axial, program: Program) -> Floats:
    """Heights of the roller's centre above that at zero lift, mm, from the least lift to the greatest."""
    least, most = program.extremes(0)
    lifts = np.linspace(float(least.value), float(most.value), 181)
    if isinstance(follower, SwingingFollower):
        start = radians(follower.start_angle)
        lifts = follower.arm * (np.sin(start + lifts) - sin(start))
    return np.asarray(lifts)


def axial_track(
    mechanism: Mechanism,
    follower: Axial,
    meridian: Meridian,
    contact: tuple[float, float],
    tip: float,
    height: float,
    name: str,
    sides: tuple[float, ...] = (1.0, -1.0),
    dz: float = 0.0,
) -> Track:
    """The track of a roller square to the cam axis, mounted dz above the trace point, at `height` at zero lift, mm."""
    joint: Joint
    if isinstance(follower, TranslatingFollower):
        anchor, joint, shift = (0.0, 0.0, height + dz), Slide((0.0, 0.0, 1.0)), 0.0
    else:
        shift = radians(follower.start_angle)
        distance, z = pivot_distance(follower, mechanism.program), height - follower.arm * sin(shift)
        anchor, joint = (0.0, distance - follower.arm, z + dz), Swing((-1.0, 0.0, 0.0), (0.0, distance, z))
    return Track(
        meridian=meridian,
        joint=joint,
        anchor=anchor,
        axis=(1.0, 0.0, 0.0),
        tip=tip,
        contact=contact,
        program=mechanism.program,
        sense=mechanism.sense,
        shift=shift,
        name=name,
        sides=sides,
    )


def pivot_distance(follower: SwingingFollower, program: Program) -> float:
    """Distance of the pivot from the cam axis, mm: as given, or such that the arc swings as far to both sides."""
    if follower.pivot_distance is not None:
        return follower.pivot_distance
    start = radians(follower.start_angle)
    lifts = [lift for span in program.spans for lift in (span.before, span.after)]
    low, high = start + min(lifts), start + max(lifts)
    cosines = [cos(low), cos(high)]
    if low <= 0.0 <= high:
        cosines.append(1.0)
    if high > pi or low < -pi:
        cosines.append(-1.0)
    return follower.arm * 0.5 * (min(cosines) + max(cosines))


def beside(follower: Axial, program: Program) -> float:
    """How far the roller's axis stands from the plane through the cam axis, at most, mm."""
    if isinstance(follower, TranslatingFollower):
        return 0.0
    return float(np.abs(pivot_distance(follower, program) - _reach(follower, program)).max())


def _reach(follower: SwingingFollower, program: Program) -> Floats:
    least, most = (float(end.value) for end in program.extremes(0))
    return np.asarray(follower.arm * np.cos(radians(follower.start_angle) + np.linspace(least, most, 181)))


def arc_problems(setup: Setup, radius: float) -> list[Problem]:
    """What is wrong with an arm whose roller has to stay beside a cam, or within a ring, of `radius`, mm."""
    follower = setup.follower
    if not isinstance(follower, SwingingFollower):
        return []
    arm, reach = follower.arm, _reach(follower, setup.program)
    distance = follower.pivot_distance
    if distance is None:
        distance = 0.5 * float(reach.min() + reach.max())
    aside = float(np.abs(distance - reach).max())
    if aside >= radius:
        # Centred, the arc leaves the axis by half of what it bulges.
        half = 0.5 * float(np.ptp(reach))
        low, high = float(reach.max()) - radius, float(reach.min()) + radius
        limit = f"{low:.6g} .. {high:.6g} mm, so that the arc, {aside:.6g} mm beside the axis, stays beside the cam"
        if half >= radius:
            limit = f"an arc that bulges less than the cam's {2.0 * radius:g} mm (it does {2.0 * half:.6g}): "
            limit += "a longer arm for the same stroke, less swing, or a larger cam"
            return [problem("follower.arm", arm, limit)]
        return [problem("follower.pivot_distance", distance, limit)]
    if follower.pivot_distance is not None and abs(follower.pivot_distance - arm) > 0.9 * radius:
        limit = f"{max(0.0, arm - 0.9 * radius):g} .. {arm + 0.9 * radius:g} mm for an arm of {arm:g}"
        return [problem("follower.pivot_distance", follower.pivot_distance, limit)]
    return []
