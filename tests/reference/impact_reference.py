"""The reference mechanism B1 of the conjugate-cam paper and its two statements, answered with computed numbers (SI).

Source of the statements: doi 10.3969/j.issn.1671-024x.2025.05.013. The printed geometry cannot be assembled and several
data are missing; B1 keeps what is printed (center distance, arm, roller, swing, speed, inertia) and chooses base radius
130 mm, rise and return 70 degrees.
"""

from __future__ import annotations

import math
from typing import Any

from camgeom.dynamics.impact.laws import ContactLaw, HertzLine, LinePatch, PowerLaw, PrintedStiffness, contact_modulus
from camgeom.dynamics.impact.lift import TURN, Lift
from camgeom.dynamics.impact.pairs import RockerPair
from camgeom.dynamics.impact.problem import ImpactProblem
from camgeom.motion.program import Program, Segment

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


def b1_pair(clearance: float, law: str = "3-4-5", **changes: Any) -> RockerPair:
    """The pair of B1 with a clearance [m]; other fields of `RockerPair` by name."""
    fields = {
        "center_distance": CENTER_DISTANCE,
        "arm_main": ARM,
        "arm_return": ARM,
        "roller_radius": ROLLER,
        "base_radius": BASE,
    }
    return RockerPair(lift=rise_return_lift(law), clearance=clearance, **{**fields, **changes})


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
