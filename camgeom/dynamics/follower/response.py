"""Response of an elastic follower, and jump: where it loses contact, how fast it may run, and how it flies. SI.

While contact holds the system is linear and its contact force may be read off; the first angle at which it turns
negative is the lift-off. Preload acts linearly: 1 N more adds k/(k + k_s) N everywhere (springs in series with the
contact included), so the preload that just holds contact follows from one run. Flight is followed by events: lift-off
where the force falls to zero, landing where the gap closes.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from camgeom.dynamics.follower.train import CamShaft, FollowerResponse, FollowerSystem, FollowerTrain, Load
from camgeom.dynamics.linear.accuracy import STANDARD, Accuracy, predicted_steps
from camgeom.dynamics.linear.maps import step_maps
from camgeom.dynamics.linear.method import DrivenMotion
from camgeom.dynamics.linear.response import periodic_response, transient_response
from camgeom.dynamics.linear.solve import FINE, advance
from camgeom.dynamics.linear.walk import TurnGrid, aligned_grid
from camgeom.errors import DesignError, NotConverged, Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import Floats

MAX_EVENTS = 1_000
"""lift-offs and landings of a flight, some 10 ms each"""
MOST_STEPS = 100_000
"""of a flight; each is taken by itself, in some 100 us"""
STEPS_PER_RADIAN = 4.0
"""steps per radian of the fastest mode: short against any loss of contact, and FINE errs by less than rounding"""
FAN = np.linspace(0.0, 1.0, 33)[1:]
ROUNDS = 9
"""32^9 > 1e13: an event is placed to rounding"""


def steady_state(
    train: FollowerTrain,
    motion: DrivenMotion,
    speed: npt.ArrayLike,
    accuracy: Accuracy = STANDARD,
    scale: float = 1e-3,
    shaft: CamShaft | None = None,
    load: Load | None = None,
) -> FollowerResponse:
    """Periodic steady state at speeds (b,) in rad/s, contact never lost (see `flight` for that).

    Raises NotConverged for a resonance without damping, DesignError for a motion whose velocity jumps.
    """
    return periodic_response(FollowerSystem(train, motion, np.atleast_1d(speed), scale, shaft, load), accuracy)


def from_rest(
    train: FollowerTrain,
    motion: DrivenMotion,
    speed: npt.ArrayLike,
    turns: int = 1,
    accuracy: Accuracy = STANDARD,
    scale: float = 1e-3,
    shaft: CamShaft | None = None,
    load: Load | None = None,
) -> FollowerResponse:
    """Transient over `turns` turns from static equilibrium at the first cam angle."""
    system = FollowerSystem(train, motion, np.atleast_1d(speed), scale, shaft, load)
    return transient_response(system, accuracy, system.rest(), turns)


@immutable
class SteadyContact:
    """Contact of a steady state at speeds (b,): smallest force in N and where (rad), whether it is lost, preload to
    hold it.

    required_preload (b,) in N is the preload at which the smallest force is just zero (never below zero).
    """

    minimum_force: Floats
    minimum_at: Floats
    lost: npt.NDArray[np.bool_]
    required_preload: Floats


def jump(response: FollowerResponse) -> SteadyContact:
    """Loss of contact of a force-closed follower in a response whose contact was never released.

    Raises ProfileError for a form-closed follower, which cannot leave its groove.
    """
    train = response.system.train
    if train.closure != "force":
        raise ProfileError(
            [Problem("dynamics.closure", "a form-closed follower does not jump", train.closure, "force")]
        )
    force = response.peak("contact_force")
    needed = np.maximum(0.0, train.preload - force.minimum / preload_share(train))
    return SteadyContact(force.minimum, force.minimum_at, force.minimum < 0.0, needed)


def preload_share(train: FollowerTrain) -> float:
    """Contact force per preload, no unit: the springs between cam and mass in series against the return spring."""
    chain = 1.0 / train.stiffness + (1.0 / train.contact_stiffness if train.two_masses else 0.0)
    return 1.0 / (1.0 + train.return_stiffness * chain)


@immutable(eq=True)
class ContactEvent:
    """Lift-off or landing at a cam angle in rad; closing speed in m/s at a landing."""

    kind: Literal["lift-off", "landing"]
    theta: float
    closing_speed: float = 0.0


@immutable
class Flight:
    """Motion with loss of contact: theta (n + 1) rad, deviation (n + 1, m) in m, flying (n + 1,), events, largest gap
    in m.
    """

    theta: Floats
    deviation: Floats
    flying: npt.NDArray[np.bool_]
    events: tuple[ContactEvent, ...]
    largest_gap: float


def flight(
    train: FollowerTrain,
    motion: DrivenMotion,
    speed: float,
    turns: int = 2,
    scale: float = 1e-3,
    load: Load | None = None,
) -> Flight:
    """Motion over `turns` turns from static equilibrium at a speed in rad/s, contact released and taken up again.

    Raises DesignError for a tappet mass without contact stiffness (it could not leave the cam) and NotConverged when
    the contact chatters more than `MAX_EVENTS` times.
    """
    if train.tappet_mass > 0.0 and not train.two_masses:
        raise DesignError(
            "a flight needs dynamics.tappet_stiffness where there is a tappet_mass, or leave that out: a tappet that "
            "follows the cam exactly cannot leave it"
        )
    on = FollowerSystem(train, motion, np.array([speed]), scale, load=load)
    off = replace(on, flight=True)
    knots = np.asarray(motion.knots)
    fastest = float(train.natural_frequency().max()) / speed * (knots[-1] - knots[0])
    steps = max(float(predicted_steps(on, knots, 1e-9, FINE)[0]), fastest * STEPS_PER_RADIAN)
    if steps * turns > MOST_STEPS:
        raise NotConverged(
            f"a flight over {turns} turns would take {steps * turns:.3g} steps, more than the {MOST_STEPS:,} that are "
            f"spent: the fastest mode turns {fastest / (2.0 * np.pi):.3g} times in a turn of the cam; a softer contact "
            "or linkage, or a higher speed, needs fewer"
        )
    return _fly(on, off, aligned_grid(knots, round(steps)), turns)


def _fly(on: FollowerSystem, off: FollowerSystem, grid: TurnGrid, turns: int) -> Flight:
    """Step by step over the grid, each step cut at its events."""
    m, span = on.size, grid.theta[-1] - grid.theta[0]
    maps = [step_maps(FINE, system, grid.start, grid.step)[0] for system in (on, off)]
    state = on.rest()[0]
    flying, gap = False, 0.0
    theta, states, airborne = [float(grid.theta[0])], [state], [flying]
    events: list[ContactEvent] = []
    for turn in range(turns):
        for k, (start, step) in enumerate(zip(grid.start, grid.step, strict=True)):
            begin, left, whole = float(start), float(step), True
            while left > 0.0:
                system = off if flying else on
                one = maps[int(flying)][k]
                end = one[:, :-1] @ state + one[:, -1] if whole else _ahead(system, begin, np.array([left]), state)[0]
                if not _over(system, begin + np.array([left]), end[None], flying)[0]:
                    state, left = end, 0.0
                else:
                    used, state = _event(system, begin, left, state, flying)
                    begin, left, whole = begin + used, left - used, False
                    closing = -float(state[m]) * float(on.speed[0]) if flying else 0.0
                    events.append(ContactEvent("landing" if flying else "lift-off", begin + turn * span, closing))
                    flying = not flying
                    if len(events) > MAX_EVENTS:
                        raise NotConverged(
                            f"the follower lifts off and lands more than {MAX_EVENTS:,} times within {turn + 1} turns; "
                            "give the contact or the linkage damping"
                        )
                gap = max(gap, float(state[0])) if flying else gap
            theta.append(float(start + step) + turn * span)
            states.append(state)
            airborne.append(flying)
    return Flight(np.array(theta), np.array(states)[:, :m], np.array(airborne), tuple(events), gap)


def _event(system: FollowerSystem, begin: float, step: float, state: Floats, flying: bool) -> tuple[float, Floats]:
    """Cam angle used and state at the first end of the phase inside a step, closed in by shrinking fans of trial
    steps.
    """
    low, high = 0.0, step
    for _ in range(ROUNDS):
        trial = low + (high - low) * FAN
        over = _over(system, begin + trial, _ahead(system, begin, trial, state), flying)
        over[-1] = True
        k = int(over.argmax())
        low, high = (float(trial[k - 1]) if k else low), float(trial[k])
    return high, _ahead(system, begin, np.array([high]), state)[0]


def _ahead(system: FollowerSystem, begin: float, steps: Floats, state: Floats) -> Floats:
    """States (k, 2m) after steps (k,) from one state."""
    start = np.full((1, len(steps)), begin)
    return np.asarray(advance(system, start, steps[None], np.broadcast_to(state, (1, len(steps), len(state))))[0])


def _over(system: FollowerSystem, theta: Floats, state: Floats, flying: bool) -> npt.NDArray[np.bool_]:
    """Whether the phase has ended in states (k, 2m): contact by a pull, flight by a closed gap that still closes."""
    m = system.size
    if flying:
        return np.asarray((state[:, 0] <= 0.0) & (state[:, m] < 0.0))
    force, _ = system.contact(theta[None], state[None, :, :m], state[None, :, m:], "left")
    return np.asarray(force[0] < 0.0)
