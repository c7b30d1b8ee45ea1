"""A frame with two flat faces on a constant-width cam, and its reference case, a pressing mechanism (SI units).

With the support function P = base + s both contacts are explicit: no foot point is sought. Source of the case:
doi 10.3969/j.issn.1005-2895.2014.02.011. Stroke and base radius are not printed; 30 mm fits the printed speed (exact
peak pi h omega/(2 Phi) = 121.18 mm/s against 120.341 of its simulation). The frame's mass, the clearance and the depth
over which the damping ramps in are not printed either; 2 kg and 0.1 mm are used. The printed peak
acceleration of 1.251 m/s^2 (kinematic 0.979) depends on these three and is not reproduced: a 2 kg frame shows 2.6 to
53 m/s^2 over clearances of 0.001 to 0.02 mm and ramp depths of 0.1 to 100 um; the peak speed is 121.2 to 122.2 mm/s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np

from camgeom.dynamics.impact.laws import Coulomb, PowerLaw, RampedDamping
from camgeom.dynamics.impact.lift import TURN, Lift, LiftJets
from camgeom.dynamics.impact.problem import ImpactProblem
from camgeom.dynamics.impact.side import Pair, Side, Touch, Toucher, TouchMany, check_clearance
from camgeom.errors import Problem, ProfileError
from camgeom.maths import Floats

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


@final
@dataclass(frozen=True)
class FrameSide(Side):
    """A flat face on a cam of support function P = base + s; the return face sees the width less P."""

    base: float
    width: float
    gap: float
    push: int

    @property
    def limit(self) -> float:
        return 0.0 if self.push > 0 else self.gap

    @property
    def sense(self) -> int:
        return self.push

    def compiled(self, jets: LiftJets) -> Toucher:
        base, width, gap = self.base, self.width, self.gap
        if self.push > 0:

            def main(k: int, x: float, s0: float, s1: float, s2: float, eta: float) -> Touch:
                support = base + s0
                return -eta, 1.0, s1, 0.0, support, 1.0 / (support + s2)

            return main

        def back(k: int, x: float, s0: float, s1: float, s2: float, eta: float) -> Touch:
            support = width - base - s0
            return eta - gap, -1.0, -s1, 0.0, support, 1.0 / (support - s2)

        return back

    def many(self, lift: Lift, angle: Floats, eta: Floats) -> TouchMany:
        s0, s1, s2 = lift.many(angle, 2)
        one, zero = np.ones_like(eta), np.zeros_like(eta)
        if self.push > 0:
            support = self.base + s0
            return -eta, one, s1, zero, support, 1.0 / (support + s2)
        support = self.width - self.base - s0
        return eta - self.gap, -one, -s1, zero, support, 1.0 / (support - s2)


@final
@dataclass(frozen=True)
class FramePair(Pair):
    """A frame with two parallel faces on a constant-width cam; q is the frame's lift [m], the faces stand square to it.

    The width is D = 2 base + stroke; the faces are D + clearance apart. Raises ProfileError where the motion is not one
    of constant width (s(phi + pi) = stroke - s(phi)) or the radius of curvature P + P'' leaves 0..D.
    """

    lift: Lift
    base_radius: float
    clearance: float

    def __post_init__(self) -> None:
        check_clearance(self.clearance)
        inside = np.concatenate([np.linspace(a.start, a.end, 183)[1:-1] for a in self.lift.arcs])
        s0, _, s2 = self.lift.many(inside, 2)
        stroke = self.lift.peaks[0]
        odd = float(np.abs(s0 + self.lift.many(inside + math.pi, 0)[0] - stroke).max())
        problems = []
        if odd > 1e-7 * stroke:
            message = "not a motion of constant width: s(phi + 180 deg) + s(phi) must be the stroke"
            problems.append(Problem("motion", message, odd, "0 m"))
        radius = self.base_radius + s0 + s2
        if not (radius.min() > 0.0 and radius.max() < self.width):
            least = self.base_radius - float(min(radius.min(), (self.width - radius).min()))
            problems.append(Problem("base_radius", "the cam is not convex", self.base_radius, f"> {least:.6g} m"))
        if problems:
            raise ProfileError(problems)

    @property
    def width(self) -> float:
        """Width of the cam [m]."""
        return 2.0 * self.base_radius + self.lift.peaks[0]

    @property
    def play(self) -> float:
        return self.clearance

    @property
    def clearance_text(self) -> str:
        return "gap along the common normal, which is the direction of motion"

    @cached_property
    def sides(self) -> tuple[FrameSide, FrameSide]:
        main = FrameSide(self.base_radius, self.width, self.clearance, 1)
        return main, FrameSide(self.base_radius, self.width, self.clearance, -1)

    def with_clearance(self, clearance: float) -> FramePair:
        return replace(self, clearance=clearance)


def pressing_lift(law: str = "simple-harmonic") -> Lift:
    """Rise 140, dwell 40, return 140, dwell 40 degrees; the return of a constant-width cam is the rise upside down."""
    from camgeom.motion import Program, Segment

    there = [Segment(math.radians(140), STROKE, law), Segment(math.radians(180))]
    back = [Segment(math.radians(320), 0.0, law), Segment(TURN)]
    return Lift.from_program(Program.from_segments(there + back), 1.0)


def pressing_problem(clearance: float, law: str = "simple-harmonic") -> ImpactProblem:
    """The frame between its two faces with a clearance [m] and the printed contact data."""
    return ImpactProblem(FramePair(pressing_lift(law), BASE, clearance), MASS, SPEED, LAW, DAMPING, FRICTION)
