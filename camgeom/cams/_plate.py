"""How planar cams carry their followers: arms, slides, rollers; bores and marks; and what cannot be built."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from math import acos, atan2, cos, degrees, pi, sin
from typing import TYPE_CHECKING

import numpy as np

from camgeom.cams import NO_FILM_OR_WEAR, NO_LIFE, NO_PRESSURE, idle, problem
from camgeom.errors import Problem
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import piece_grid, refined_maximum
from camgeom.motion.program import Program
from camgeom.solid.blank import Bore, Wall
from camgeom.track import Joint, Meridian, Slide, Swing, Track, Vector
from camgeom.track.follower import AnyRoller, ConeRoller, CrownedRoller
from camgeom.track.outline import CircleOutline, Outline

if TYPE_CHECKING:
    from camgeom.solid.prism import Loop


@immutable(eq=True)
class Arm:
    """An arm about a pivot at (centre, 0): way +1 with its contact on the +Y side, where lift turns it clockwise."""

    centre: float
    way: float

    @property
    def joint(self) -> Swing:
        """The turning joint; its coordinate grows with the lift."""
        return Swing((0.0, 0.0, -self.way), (self.centre, 0.0, 0.0))

    def point(self, arm: float, angle: float) -> Vector:
        """The end of an arm that stands at `angle` (rad) from the line of centres, towards its own side."""
        return self.centre - arm * cos(angle), self.way * arm * sin(angle), 0.0


def arm_angle(centre: float, arm: float, prime: float) -> float:
    """Angle at the pivot between the line of centres and an arm whose end is `prime` from the cam axis, rad."""
    return acos((centre**2 + arm**2 - prime**2) / (2.0 * centre * arm))


def roller_track(
    name: str,
    program: Program,
    sense: float,
    anchor: Vector,
    joint: Joint,
    meridian: Meridian,
    contact: tuple[float, float],
    shift: float = 0.0,
    tip_high: bool = False,
    sides: tuple[float, ...] | None = None,
) -> Track:
    """The track of a roller whose axis is parallel to the cam's; contact: heights z; tip_high: its free end is above.

    The roller of an external profile works on the side towards the cam axis.
    """
    low, high = contact
    return Track(
        meridian=meridian,
        joint=joint,
        anchor=anchor,
        axis=(0.0, 0.0, 1.0),
        tip=high if tip_high else low,
        contact=contact,
        program=program,
        sense=sense,
        shift=shift,
        name=name,
        sides=(-sense,) if sides is None else sides,
    )


SLIDE = Slide((1.0, 0.0, 0.0))


def straight_problems(roller: AnyRoller | None, table: str = "roller") -> list[Problem]:
    """What is wrong with a crowned roller on a planar cam: its outline is the same at every height."""
    if not isinstance(roller, CrownedRoller) or roller.flank == "straight":
        return []
    limit = "straight on this cam, whose wall is the same curve at every height"
    return [problem(f"{table}.flank", roller.flank, limit)]


def triangle_problem(key: str, centre: float, arm: float, prime: float, what: str) -> Problem | None:
    """The problem of an arm, a centre distance and a prime radius that form no triangle, or None."""
    if abs(centre - arm) < prime < centre + arm:
        return None
    limit = f"such that {what} {arm:g}, centre distance {centre:g} and prime radius form a triangle: the prime radius "
    limit += f"{prime:g} mm must lie between {abs(centre - arm):g} and {centre + arm:g} mm"
    return problem(key, centre, limit)


def swing_problem(start: float, program: Program, key: str = "motion.to") -> Problem | None:
    """The problem of an arm that starts at `start` (rad) and is swung into line with the line of centres, or None."""
    low, high = lift_range(program)
    if start + low > 0.0 and start + high < pi:
        return None
    limit = f"{np.degrees(-start):.6g} .. {180.0 - np.degrees(start):.6g} deg, where the arm comes into line"
    return problem(key, float(np.degrees(high if start + high >= pi else low)), limit)


def bore_of(diameter: float, keyway_width: float, keyway_depth: float) -> Bore | None:
    """The bore of a disc; None where its diameter is 0."""
    return Bore(diameter, keyway_width, keyway_depth) if diameter else None


def bore_problems(
    bore: float, keyway_width: float, keyway_depth: float, radius: float, circle: str = "base circle"
) -> list[Problem]:
    """What is wrong with a bore and keyway in a disc whose material reaches in to the `circle` of `radius`, mm."""
    if not bore:
        return [problem("cam.keyway_width", keyway_width, "0 without a bore")] if keyway_width else []
    if bool(keyway_width) != bool(keyway_depth) or keyway_width >= bore:
        return [problem("cam.keyway_width", keyway_width, f"below the bore {bore:g} mm, with a keyway_depth")]
    reach = Bore(bore, keyway_width, keyway_depth).reach
    if reach >= radius:
        return [problem("cam.bore", bore, f"outline (reaches {reach:g} mm) inside the {circle}, {radius:g} mm")]
    return []


WALL_SAMPLES = 1440
"""a turn, before the least distances are refined"""


def least_distance(outline: Outline, distance: Callable[[Floats], Floats]) -> tuple[float, float]:
    """Least of a distance (2, n) -> (n,) over the points of an outline, mm, and its cam angle, rad."""

    def nearness(phi: Floats) -> Floats:
        return -distance(outline.curve(phi).points)

    phi, owner = piece_grid(outline.knots(), WALL_SAMPLES)
    nearest, where = refined_maximum(nearness, phi, owner, nearness(phi))
    return -nearest, where


def plate_envelope(outlines: Iterable[Outline], length: float) -> tuple[float, float]:
    """Diameter and length, mm, of the cylinder about the axis that holds plates of these profiles."""
    return -2.0 * min(least_distance(outline, lambda x: -np.hypot(x[0], x[1]))[0] for outline in outlines), length


def bore_distance(bore: Bore) -> Callable[[Floats], Floats]:
    """Distance of points (2, n) from a bore with its keyway on the +X side, mm; negative within the opening."""
    radius, half = 0.5 * bore.diameter, 0.5 * bore.keyway_width
    bottom = radius + bore.keyway_depth

    def distance(x: Floats) -> Floats:
        from_bore = np.hypot(x[0], x[1]) - radius
        if not half:
            return np.asarray(from_bore)
        # The keyway is the rectangle from the axis to its flat bottom.
        beyond = np.stack([np.abs(x[0] - 0.5 * bottom) - 0.5 * bottom, np.abs(x[1]) - half])
        outside = np.hypot(*np.maximum(beyond, 0.0))
        return np.asarray(np.minimum(from_bore, outside + np.minimum(beyond.max(axis=0), 0.0)))

    return distance


def bore_walls(name: str, outline: Outline, bore: Bore | None) -> tuple[Wall, ...]:
    """The wall between a profile and the bore with its keyway; none without a bore."""
    if bore is None:
        return ()
    thickness, angle = least_distance(outline, bore_distance(bore))
    return (Wall(f"{name} to bore", thickness, angle, "a smaller bore or keyway, or a larger base_radius"),)


def least_wall(loop: Loop, walls: Callable[[Outline], tuple[Wall, ...]]) -> tuple[Wall, ...]:
    """Walls beside an outline; beside a flank that leans each at the end where it is thinnest."""
    return tuple(min(each, key=lambda wall: wall.thickness) for each in zip(*map(walls, loop.ends)))


def cone_problems(roller: ConeRoller, ends: tuple[float, float], table: str = "roller") -> list[Problem]:
    """What is wrong with a conical roller whose flank goes on along its axis, mm, from its middle: towards its free end
    and away from it."""
    most, least = (degrees(atan2(0.5 * roller.diameter, end)) for end in ends)
    if -least < roller.half_angle < most:
        return []
    limit = f"-{least:.6g} to {most:.6g} deg: beyond, the cone comes to its point beside the disc"
    return [problem(f"{table}.half_angle", roller.half_angle, limit)]


def disc_wall(name: str, width: float) -> Wall:
    """A disc or plate from face to face."""
    return Wall(f"{name} from face to face", width, None, "a larger width")


def mark_walls(
    name: str, outline: Outline, bore: Bore | None, diameter: float, radius: float, sense: float
) -> tuple[Wall, ...]:
    """The walls between a phase mark and the profile, and between it and the bore; none without a mark."""
    if not diameter:
        return ()
    centre = np.array([[0.0], [-sense * radius]])

    def distance(x: Floats) -> Floats:
        return np.asarray(np.hypot(*(x - centre)) - 0.5 * diameter)

    thickness, angle = least_distance(outline, distance)
    walls = [Wall(f"{name} to phase mark", thickness, angle, "a smaller mark_diameter or mark_radius")]
    if bore is not None:
        between = float(bore_distance(bore)(centre)[0]) - 0.5 * diameter
        walls.append(Wall(f"{name} phase mark to bore", between, None, "a smaller mark or a larger mark_radius"))
    return tuple(walls)


SQUARE = idle("the pressure angle of a flat face that slides is always 0", "limits.warn_pressure_angle_deg") | idle(
    "a flat face square to its slide gives no side thrust: give a friction in N", "operation.guide_friction"
)
"""What means nothing for a flat face that slides square to itself."""


def face_idle(face: str) -> dict[str, str]:
    """The keys that mean nothing for what touches a planar cam: "roller", "flat", "curved" or "knife"."""
    found = {} if face == "roller" else idle(f"the follower's {face} face touches the cam, no roller", "roller")
    if face != "curved":
        found |= idle("only face = 'curved' has a radius", "follower.face_radius")
    if face != "flat":
        found |= idle("only face = 'flat' has a width and an offset", "follower.face_width", "follower.face_offset")
    if face == "knife":
        found |= NO_LIFE | NO_PRESSURE | NO_FILM_OR_WEAR
    if face in ("flat", "knife"):
        margins = ("limits.undercut_margin", "limits.warn_undercut_margin")
        found |= idle("no roller can undercut this cam; folds are judged by face-curvature", *margins)
    return found


def mark_loops(diameter: float, radius: float, sense: float) -> tuple[Loop, ...]:
    """A phase mark: a hole through the disc on the side where the follower's line lies a quarter turn later."""
    if not diameter:
        return ()
    from camgeom.solid.prism import Loop

    return (Loop(CircleOutline(0.5 * diameter, (0.0, -sense * radius)), "mark"),)


def mark_problems(diameter: float, radius: float | None, inside: float, bore_reach: float) -> list[Problem]:
    """What is wrong with a phase mark between the bore and the smallest radius of the profile."""
    if not diameter:
        return [] if radius is None else [problem("cam.mark_radius", radius, "none without a mark_diameter")]
    low, high = bore_reach + 0.5 * diameter, inside - 0.5 * diameter
    if radius is None or not low < radius < high:
        return [problem("cam.mark_radius", radius, f"between {low:g} and {high:g} mm, between bore and profile")]
    return []


def lift_range(program: Program) -> tuple[float, float]:
    """Smallest and largest lift of a program, mm or rad."""
    least, most = program.extremes(0)
    return float(least.value), float(most.value)
