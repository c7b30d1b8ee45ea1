"""The reference case of a frame with two flat faces on a constant-width cam: a pressing mechanism (SI units).

Source of the case:
doi 10.3969/j.issn.1005-2895.2014.02.011. Stroke and base radius are not printed; 30 mm fits the printed speed (exact
peak pi h omega/(2 Phi) = 121.18 mm/s against 120.341 of its simulation). The frame's mass, the clearance and the depth
over which the damping ramps in are not printed either; 2 kg and 0.1 mm are used. The printed peak
acceleration of 1.251 m/s^2 (kinematic 0.979) depends on these three and is not reproduced: a 2 kg frame shows 2.6 to
53 m/s^2 over clearances of 0.001 to 0.02 mm and ramp depths of 0.1 to 100 um; the peak speed is 121.2 to 122.2 mm/s.
"""

from __future__ import annotations

import math

from camgeom.dynamics.impact.laws import Coulomb, PowerLaw, RampedDamping
from camgeom.dynamics.impact.lift import Lift
from camgeom.dynamics.impact.problem import ImpactProblem
from camgeom.maths import TURN
from camgeom.motion import Program, Segment
from tests.reference.impact_reference import frame_pair

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
    there = [Segment(math.radians(140), STROKE, law), Segment(math.radians(180))]
    back = [Segment(math.radians(320), 0.0, law), Segment(TURN)]
    return Lift.from_program(Program.from_segments(there + back), 1.0)


def pressing_problem(clearance: float, law: str = "simple-harmonic") -> ImpactProblem:
    """The frame between its two faces with a clearance [m] and the printed contact data."""
    return ImpactProblem(frame_pair(pressing_lift(law), BASE, clearance), MASS, SPEED, LAW, DAMPING, FRICTION)
