"""The reference case of the frame on a constant-width cam: the pressing mechanism of a life tester (SI units).

Source: doi 10.3969/j.issn.1005-2895.2014.02.011. Stroke and base radius are not printed; 30 mm fits the printed speed
(exact peak pi h omega/(2 Phi) = 121.18 mm/s against 120.341 of its simulation). The frame's mass, the clearance and the
depth over which the damping ramps in are not printed either; 2 kg and 0.1 mm are used.
"""

from __future__ import annotations

import math

from camgeom.dynamics.contact_laws import PowerLaw
from camgeom.dynamics.contact_losses import Coulomb, RampedDamping
from camgeom.dynamics.impact import ImpactProblem
from camgeom.dynamics.impact_lift import TURN, Lift
from camgeom.dynamics.impact_pairs import FramePair

SPEED = TURN
"""rad/s; 60 r/min"""
STROKE = 0.030
BASE = 0.040
MASS = 2.0
LAW = PowerLaw(35_000.0 * 1000.0**1.5, 1.5)
"""35 000 N/mm^1.5"""
DAMPING = RampedDamping(28e3, 1e-4)
"""28 N s/mm"""
FRICTION = Coulomb(0.25, 0.20, 1e-4, 1e-2)
"""transition speeds 0.1 and 10, printed as m/s, taken as mm/s"""


def pressing_lift(law: str = "simple-harmonic") -> Lift:
    """Rise 140, dwell 40, return 140, dwell 40 degrees; the return of a constant-width cam is the rise upside down."""
    from camgeom.motion import Program, Segment

    there = [Segment(math.radians(140), STROKE, law), Segment(math.radians(180))]
    back = [Segment(math.radians(320), 0.0, law), Segment(TURN)]
    return Lift.from_program(Program.from_segments(there + back), 1.0)


def pressing_problem(clearance: float, law: str = "simple-harmonic") -> ImpactProblem:
    """The frame between its two faces with a clearance [m] and the printed contact data."""
    return ImpactProblem(FramePair(pressing_lift(law), BASE, clearance), MASS, SPEED, LAW, DAMPING, FRICTION)
