"""The reference mechanism B1 of the conjugate-cam paper and its two statements, answered with computed numbers (SI).

Source of the statements: doi 10.3969/j.issn.1671-024x.2025.05.013. The printed geometry cannot be assembled and several
data are missing; B1 keeps what is printed (center distance, arm, roller, swing, speed, inertia) and chooses base radius
130 mm, rise and return 70 degrees.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from camgeom.cams.conjugate import Conjugate
from camgeom.dynamics.impact.laws import ContactLaw, HertzLine, LinePatch, PowerLaw, PrintedStiffness
from camgeom.dynamics.impact.lift import Lift
from camgeom.dynamics.impact.pair import ClearanceKind, FaceSide, Pair, planar_pair
from camgeom.dynamics.impact.problem import ImpactProblem
from camgeom.errors import ProfileError
from camgeom.maths import TURN
from camgeom.motion.program import Program
from camgeom.motion.segment import Segment
from camgeom.track.follower import CylinderRoller, Setup, SwingingFollower


def contact_modulus(elastic_1: float, poisson_1: float, elastic_2: float, poisson_2: float) -> float:
    """The contact modulus E*, in the unit of the moduli: 1/E* is the sum of (1 - nu^2)/E."""
    return 1.0 / ((1.0 - poisson_1**2) / elastic_1 + (1.0 - poisson_2**2) / elastic_2)


CENTER_DISTANCE = 0.205
ARM = 0.090
ROLLER = 0.020
BASE = 0.130
SWING = math.radians(24.0)
INERTIA = 0.140
SPEED = 600.0 * math.pi / 30.0
LENGTH = 0.020
MODULUS = contact_modulus(207e9, 0.28, 207e9, 0.28)


def rise_return_program(law: str, rise_deg: float = 70.0, return_deg: float = 70.0, swing: float = SWING) -> Program:
    """The rocker motion [rad]: rise, return by the same law, then dwell at the bottom."""
    top, bottom = math.radians(rise_deg), math.radians(rise_deg + return_deg)
    segments = [Segment(top, swing, law), Segment(bottom, 0.0, law), Segment(TURN)]
    return Program.from_segments(segments, angular=True)


def rise_return_lift(law: str, rise_deg: float = 70.0, return_deg: float = 70.0, swing: float = SWING) -> Lift:
    """The same motion for the solver."""
    return Lift.from_program(rise_return_program(law, rise_deg, return_deg, swing), 1.0)


def b1_pair(
    clearance: float, law: str = "3-4-5", kind: ClearanceKind = "chord", *, side: str = "left", **changes: Any
) -> Pair:
    """The pair of B1 with a clearance [m], from the cam's own touches; `changes` are keys of the profile [mm, deg]."""
    keys = {"center_distance": 1e3 * CENTER_DISTANCE, "base_radius": 1e3 * BASE, "arm": 1e3 * ARM, **changes}
    arm, roller = keys.pop("arm"), CylinderRoller(diameter=2e3 * ROLLER, length=1e3 * LENGTH)
    cam = Conjugate(kind="conjugate", width=1e3 * LENGTH, **keys)
    setup = Setup(SwingingFollower(kind="swinging", arm=arm, side=side), roller, rise_return_program(law))
    problems = cam.problems(setup)
    if problems:
        raise ProfileError(problems)
    return planar_pair(setup.program, cam.mechanism(setup).touches, clearance, kind)


def frame_pair(lift: Lift, base: float, clearance: float) -> Pair:
    """A frame with two flat faces on a cam of support base + s [m], whose opposite supports add up to one width."""
    across = float(lift.many([0.0, math.pi], 0).sum())
    sides = FaceSide(1, base), FaceSide(-1, base + across)
    return Pair(lift, *sides, clearance, "normal", "gap along the common normal")


def pressure_angle(pair: Pair, count: int = 721) -> float:
    """Largest pressure angle [rad] of the two rollers of a rocker over a turn."""
    angle = np.linspace(0.0, TURN, count)
    levers = [side.many(pair.lift, angle, np.zeros(count))[1] / abs(side.arm) for side in pair.sides]  # type: ignore[attr-defined]
    return float(np.arccos(np.clip(np.abs(levers), 0.0, 1.0)).max())


LOWEST = math.acos((CENTER_DISTANCE**2 + ARM**2 - (BASE + ROLLER) ** 2) / (2.0 * CENTER_DISTANCE * ARM))
"""rad, main arm from the line of centres at zero lift"""


def free_flight(problem: ImpactProblem) -> tuple[float, float, float]:
    """Estimate of the drive conversion: flight time [s], speed gained in the coordinate, approach speed [m/s].

    The follower leaves one side where the acceleration changes sign with the jerk j and crosses the play phi_m freely:
    t = (6 phi_m/|j|)^(1/3), eta' = 1/2 |j| t^2, growing with the clearance to the power 2/3.
    """
    pair, w = problem.pair, problem.speed
    lift = pair.lift
    angle = np.linspace(0.0, 2.0 * math.pi, 7201)
    second, third = lift.many(angle, 3)[2:]
    turning = 1 + np.flatnonzero((second[:-2] > 0.0) & (second[1:-1] <= 0.0) & (second[2:] < 0.0))
    if not turning.size:
        return 0.0, 0.0, 0.0
    place = int(turning[np.argmax(np.abs(third[turning]))])
    jerk = abs(float(third[place])) * w**3
    time = math.cbrt(6.0 * pair.play / jerk) if jerk > 0.0 else 0.0
    speed = 0.5 * jerk * time * time
    lever = float(pair.sides[1].many(lift, angle[place : place + 1], np.zeros(1))[1][0])
    return time, speed, abs(lever) * speed


def contact_law(name: str) -> ContactLaw:
    """The contact laws of the comparison: "hertz", "printed", "power-soft", "power-stiff"."""
    laws: dict[str, ContactLaw] = {
        "hertz": HertzLine(MODULUS, LENGTH, ROLLER, BASE),
        "printed": PrintedStiffness(MODULUS, BASE + ROLLER, 1.0),
        "power-soft": PowerLaw(6.4e9, 1.5),
        "power-stiff": PowerLaw(6.4e10, 1.5),
    }
    return laws[name]


def b1_problem(clearance: float, law: str = "3-4-5", contact: str = "hertz", **changes: Any) -> ImpactProblem:
    """The problem B1; `changes` are fields of `ImpactProblem`."""
    fields: dict[str, Any] = {"patch": LinePatch(MODULUS, LENGTH, ROLLER), **changes}
    return ImpactProblem(b1_pair(clearance, law), INERTIA, SPEED, contact_law(contact), **fields)
