"""A follower between two opposing contacts with free play: the event solver (SI units).

The deviation eta = q - s(phi) is integrated as the complex state eta + 1j * d eta/dt by DOP853, restarted at every knot
of the motion and at every event: contact on, contact off, contact force clipped at zero and released. Every accepted
step is looked at in eight points, so that no contact is stepped over; an event is placed by repeating the step to it,
so the state there has the accuracy of the method, not that of an interpolation.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import field
from enum import IntEnum
from typing import NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from camgeom.dynamics.impact.laws import ContactLaw, Coulomb, Damping, ImpactDamping, Patch
from camgeom.dynamics.impact.lift import ForceTable
from camgeom.dynamics.impact.pair import Pair
from camgeom.errors import Problem, ProfileError
from camgeom.immutable import immutable

Coordinates = complex | NDArray[np.complex128]
"""deviation + 1j * its rate; where rollers turn an array of that and of main + 1j * return spin [rad/s]"""
Rate = Callable[[float, Coordinates], tuple[Coordinates, complex]]
"""f(t, y) -> (dy/dt, powers); the powers (two of them in one complex number) are integrated beside the state"""


def follower(y: Coordinates) -> complex:
    """Deviation + 1j * its rate (or what stands in its place in a derivative)."""
    return y if isinstance(y, complex) else complex(y[0])


def spin(y: Coordinates) -> complex:
    """Main + 1j * return roller spin [rad/s]; 0 where the rollers do not turn."""
    return 0j if isinstance(y, complex) else complex(y[1])


class State(IntEnum):
    """Where the follower is."""

    FREE = 0
    MAIN = 1
    RETURN = 2


class Regime(NamedTuple):
    """What the right-hand side depends on between restarts: state, arc of the motion, and the latched approach."""

    state: State
    arc: int
    begin: float
    """time [s] at which the arc begins"""
    approach: float
    """approach speed [m/s] at the onset of this contact, not below the floor"""
    clipped: bool
    """in reach but separating faster than the contact can follow: no force"""


class Event(NamedTuple):
    """A change of regime at a time [s]; `approach` is the penetration rate [m/s], `state` the one entered."""

    time: float
    kind: str
    state: State
    approach: float


@final
@immutable(eq=True)
class ImpactLoad:
    """What acts on the follower beside the contacts: `constant` - `stiffness` q, guide friction against the motion, and
    the force `applied` over the cam angle, against larger q.

    N and N/m of a slide, N m and N m/rad of a rocker; `drag` [N or N m] is reached at the speed `drag_speed` [m/s or
    rad/s] on a smooth curve. Gravity of a slide is part of `constant`; that of a rocker is left out (it is far below
    the inertia torque at the speeds where clearance matters).
    """

    constant: float = 0.0
    stiffness: float = 0.0
    drag: float = 0.0
    drag_speed: float = 1e-3
    applied: ForceTable | None = None

    @property
    def acts(self) -> bool:
        """Whether any of it is there."""
        return bool(self.constant or self.stiffness or self.drag or self.applied)

    @property
    def largest(self) -> float:
        """Size [N or N m] of what does not depend on the motion."""
        return abs(self.constant) + self.drag + (self.applied.largest if self.applied is not None else 0.0)

    def resistance(self, start: float, end: float) -> Callable[[float, float], float]:
        """Friction and applied force [N or N m] against +q between two cam angles [rad]: a plain function of the angle
        past `start` and the speed. Its power counts as lost.
        """
        if self.applied is None:
            return lambda x, speed: self.friction(speed)
        applied, friction = self.applied.within(start, end), self.friction
        return lambda x, speed: applied(x) + friction(speed)

    def friction(self, speed: float) -> float:
        """Guide friction [N or N m], positive against +q: odd, smooth."""
        return self.drag * math.tanh(3.0 * speed / self.drag_speed) if self.drag else 0.0

    def energy(self, q: float) -> float:
        """Potential [J] of the constant and the spring."""
        return (0.5 * self.stiffness * q - self.constant) * q


@final
@immutable(eq=True)
class RollerSpin:
    """Rollers free to turn: `inertia` [kg m^2] of a roller about its axis, `drag` [N m s/rad] of its bearing.

    Needs friction. The contact then creeps towards rolling; with a stick speed of a few mm/s that is fast against the
    impact and costs many small steps, 1 % of the surface speed is a realistic creep.
    """

    inertia: float
    drag: float = 0.0


@final
@immutable(eq=True)
class ImpactProblem:
    """Everything the solver needs. `inertia` kg (slide) or kg m^2 (rocker), `speed` of the cam in rad/s.

    `law` and `damping` give the normal force, `friction` the tangential one, `patch` the data of the contact pressure;
    `back` is the law and the patch of the return side, where its roller is another one.
    """

    pair: Pair
    inertia: float
    speed: float
    law: ContactLaw
    damping: Damping = field(default_factory=ImpactDamping)
    friction: Coulomb | None = None
    spin: RollerSpin | None = None
    load: ImpactLoad = field(default_factory=ImpactLoad)
    patch: Patch | None = None
    back: tuple[ContactLaw, Patch] | None = None

    @property
    def laws(self) -> tuple[ContactLaw, ContactLaw]:
        """The contact law of the main and of the return side."""
        return self.law, self.law if self.back is None else self.back[0]

    @property
    def patches(self) -> tuple[Patch | None, Patch | None]:
        """The data of the contact pressure of either side."""
        return self.patch, self.patch if self.back is None else self.back[1]

    def __post_init__(self) -> None:
        problems = [
            Problem(key, "must be positive", value, "> 0")
            for key, value in (("inertia", self.inertia), ("speed", self.speed))
            if not 0.0 < value < math.inf
        ]
        if self.spin is not None and self.friction is None:
            problems.append(Problem("spin", "a roller turns only by friction", None, "", "give friction as well"))
        if self.spin is not None and not all(side.rolls[0] for side in self.pair.sides):
            message = "rollers turn on planar cams only; the roller of a groove and a flat face take no spin"
            problems.append(Problem("impact.roller_inertia", message, self.spin.inertia, "none"))
        if self.spin is not None and not (self.spin.inertia > 0.0 and self.spin.drag >= 0.0):
            problems.append(Problem("spin", "needs an inertia > 0 and a drag >= 0", self.spin))
        if problems:
            raise ProfileError(problems)

    @property
    def period(self) -> float:
        """Time of a turn [s]."""
        return 2.0 * math.pi / self.speed


class StepRecord(NamedTuple):
    """An accepted step: start time, length, state, its rate, powers there, the number of its regime."""

    time: float
    length: float
    state: Coordinates
    rate: Coordinates
    powers: complex
    regime: int


class Recorded(NamedTuple):
    """The raw outcome of the solver: steps, final time and state, work at every step's start and end, events."""

    steps: list[StepRecord]
    time: float
    state: Coordinates
    work: list[complex]
    regimes: list[Regime]
    events: list[Event]
    calls: int
