"""What the contact solver asks of one side of a follower with free play, in SI units.

The follower coordinate is q = s(phi) + eta: s the ideal motion, eta the deviation (m, or rad of a rocker). A side has a
penetration delta, a lever h (force on the coordinate per newton of contact force) and a drag g, so that by virtual work

    d delta/dt = g omega - h dq/dt        force on q: F h        torque that the cam must supply: F g

and likewise a tangential lever ht and drag gt with the sliding speed v = ht dq/dt - gt omega of follower over cam. The
cam turns by +phi = omega t, anticlockwise.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Literal

import numpy as np

from camgeom.dynamics.impact.lift import Lift, LiftJets
from camgeom.errors import Problem, ProfileError
from camgeom.maths import Floats

ClearanceKind = Literal["chord", "normal"]

Touch = tuple[float, float, float, float, float, float]
"""delta [m], lever h, drag g, sliding lever ht, sliding drag gt [m/rad, or 1 for a slide], cam curvature [1/m]"""
TouchMany = tuple[Floats, Floats, Floats, Floats, Floats, Floats]
"""the same as arrays"""
Toucher = Callable[[int, float, float, float, float, float], Touch]
"""(arc number, angle past its start [rad], s, ds, d2s there, eta) -> Touch"""


class Side(ABC):
    """One contact of the pair."""

    @property
    @abstractmethod
    def limit(self) -> float | None:
        """The deviation eta at which contact begins, where it is the same all round; None: found from delta."""

    @property
    @abstractmethod
    def sense(self) -> int:
        """+1 for the side that pushes towards +q, -1 for the other."""

    @abstractmethod
    def compiled(self, jets: LiftJets) -> Toucher:
        """A plain function that evaluates the contact at one moment."""

    @abstractmethod
    def many(self, lift: Lift, angle: Floats, eta: Floats) -> TouchMany:
        """The contact at arrays of cam angle [rad] and deviation."""


class Pair(ABC):
    """Two opposing sides, the motion between them and what the clearance means."""

    lift: Lift

    @property
    @abstractmethod
    def sides(self) -> tuple[Side, Side]:
        """The main side (+q) and the return side (-q)."""

    @property
    @abstractmethod
    def play(self) -> float:
        """Free play in the follower coordinate [m or rad]; the mean over a turn where it varies."""

    @property
    @abstractmethod
    def clearance_text(self) -> str:
        """How the clearance is measured, in words."""

    @abstractmethod
    def with_clearance(self, clearance: float) -> Pair:
        """The same pair with another clearance [m]."""

    def middle(self, angle: float) -> float:
        """The deviation halfway between the two sides at a cam angle [rad]."""
        main, back = self.sides
        if main.limit is not None and back.limit is not None:
            return 0.5 * (main.limit + back.limit)
        at = np.array([angle])
        ends = []
        for side in (main, back):
            eta = np.zeros(1)
            for _ in range(4):
                touch = side.many(self.lift, at, eta)
                eta = eta + touch[0] / touch[1]
            ends.append(float(eta[0]))
        return 0.5 * (ends[0] + ends[1])


def check_clearance(clearance: float) -> None:
    """Raise ProfileError unless the clearance [m] is a gap."""
    if not 0.0 < clearance < math.inf:
        raise ProfileError([Problem("clearance", "contact with free play needs a gap", clearance, "> 0 m")])
