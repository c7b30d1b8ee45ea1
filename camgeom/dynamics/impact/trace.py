"""The solved motion between two contacts as arrays: deviation, acceleration, forces, sliding, torque (SI units)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from camgeom.dynamics.impact.events import hermite_row
from camgeom.dynamics.impact.losses import ImpactDamping
from camgeom.dynamics.impact.problem import Recorded, Regime
from camgeom.dynamics.impact.rates import Machine
from camgeom.maths import Floats

SHARES = 8
"""intervals that every step is sampled in"""


@final
@dataclass(frozen=True, eq=False)
class Trace:
    """Arrays over time, shape (steps, 9) or whatever times were asked for; both sides in the last axis of the pairs.

    `time` s, `angle` cam angle rad (counted on over turns), `deviation` m or rad, `position`, `speed`,
    `acceleration` of the follower (m or rad, per s, per s^2), `force` (..., 2) N, `penetration` (..., 2) m
    (0 out of contact), `sliding` (..., 2) m/s, `pressure` (..., 2) Pa, `cam_torque` N m that the cam needs, `state`.
    """

    time: Floats
    angle: Floats
    deviation: Floats
    position: Floats
    speed: Floats
    acceleration: Floats
    force: Floats
    penetration: Floats
    sliding: Floats
    pressure: Floats
    cam_torque: Floats
    state: NDArray[np.int8]

    def flat(self) -> Trace:
        """The same with the time in one axis."""
        values = {}
        for name in self.__dataclass_fields__:
            value = getattr(self, name)
            values[name] = value.reshape(-1, *value.shape[self.time.ndim :])
        return Trace(**values)


def evaluate(
    machine: Machine, regimes: list[Regime], which: NDArray[np.int64], time: Floats, follower: Any, spins: Any
) -> Trace:
    """The trace at states given as eta + 1j * rate (flat arrays), `which` the number of the regime of each."""
    problem, lift, w = machine.problem, machine.lift, machine.speed
    arcs = np.array([r.arc for r in regimes])[which]
    x = w * (time - np.array([r.begin for r in regimes])[which])
    angle = np.array(lift.starts)[arcs] + x
    jet = np.empty((3, time.size))
    for k in np.unique(arcs):
        here = arcs == k
        jet[:, here] = lift.arcs[k].many(angle[here], 2)
    state = np.array([r.state for r in regimes], dtype=np.int8)[which]
    clipped = np.array([r.clipped for r in regimes])[which]
    approach = np.array([r.approach for r in regimes])[which]
    eta, rate = follower.real, follower.imag
    q, q1 = jet[0] + eta, jet[1] * w + rate
    load = problem.load
    torque = load.constant - load.stiffness * q
    if load.drag:
        torque = torque - load.drag * np.tanh(3.0 * q1 / load.drag_speed)
    if load.applied is not None:
        ends = np.array([arc.end for arc in lift.arcs])
        torque = torque - load.applied.many(angle, np.array(lift.starts)[arcs], ends[arcs])
    pairs = {name: np.zeros((time.size, 2)) for name in ("force", "penetration", "sliding", "pressure")}
    needed = np.zeros(time.size)
    for side in (0, 1):
        on = np.flatnonzero((state == side + 1) & ~clipped)
        if not on.size:
            continue
        delta, h, g, ht, gt, bend = problem.pair.sides[side].many(lift, angle[on], eta[on])
        sinking = g * w - h * q1[on]
        elastic = problem.law.force_many(delta, bend)
        if isinstance(problem.damping, ImpactDamping):
            lost = elastic * (problem.damping.factor / approach[on]) * sinking
        else:
            lost = problem.damping.viscosity_many(delta) * sinking
        force = np.maximum(elastic + lost, 0.0)
        slide = ht * q1[on] - gt * w
        lever = ht
        if spins is not None:
            radius = float(getattr(problem.pair.sides[side], "radius", 0.0))
            lever = ht + radius * machine.carrier_turn(side)
            slide = lever * q1[on] - radius * (spins.real if side == 0 else spins.imag)[on] - gt * w
        rub = problem.friction.coefficient_many(slide) * force if problem.friction is not None else 0.0
        torque[on] += force * h - rub * lever
        needed[on] += force * g - rub * gt
        pairs["force"][on, side], pairs["penetration"][on, side] = force, delta
        pairs["sliding"][on, side] = slide
        if problem.patch is not None:
            pairs["pressure"][on, side] = problem.patch.pressure(force, bend)
    whole = w * time
    return Trace(time, whole, eta, q, q1, torque / problem.inertia, cam_torque=needed, state=state, **pairs)


def sampled(machine: Machine, made: Recorded, angle: float) -> Trace:
    """The trace in nine points of every step, by quintic Hermite in the deviation (error below 1e-6 of its range)."""
    steps = made.steps
    t0 = np.array([s.time for s in steps])
    h = np.array([s.length for s in steps])
    which = np.array([s.regime for s in steps])
    states = [*(s.state for s in steps), made.state]
    spinning = not isinstance(made.state, complex)
    y = np.array([complex(s[0]) for s in states] if spinning else states)
    a0 = np.array([complex(s.rate[0]) if spinning else s.rate for s in steps]).imag
    w = machine.speed
    # The rate at a step's end belongs to its own regime: at a knot of the motion the next one begins with another.
    ends = evaluate(machine, made.regimes, which, t0 + h, y[1:], _spins(states[1:]) if spinning else None)
    a1 = ends.acceleration - _ideal(machine, made.regimes, which, t0 + h) * w * w
    shares = np.linspace(0.0, 1.0, SHARES + 1)
    rows = np.array([hermite_row(u) for u in shares])
    slopes = np.array([_hermite_slope(u) for u in shares])
    basis = np.stack([y[:-1].real, h * y[:-1].imag, h * h * a0, y[1:].real, h * y[1:].imag, h * h * a1], axis=1)
    follower = (basis @ rows.T + 1j * (basis @ slopes.T) / h[:, None]).ravel()
    time = (t0[:, None] + shares * h[:, None]).ravel()
    spins = None
    if spinning:
        z = _spins(states)
        spins = (z[:-1, None] * (1.0 - shares) + z[1:, None] * shares).ravel()
    numbers = np.repeat(which, SHARES + 1)
    flat = evaluate(machine, made.regimes, numbers, time, follower, spins)
    shape = (len(steps), SHARES + 1)
    values = {}
    for name in flat.__dataclass_fields__:
        value = getattr(flat, name)
        values[name] = value.reshape(*shape, *value.shape[1:])
    values["angle"] = values["angle"] + angle
    return Trace(**values)


def _ideal(machine: Machine, regimes: list[Regime], which: NDArray[np.int64], time: Floats) -> Floats:
    """Second derivative of the ideal motion per rad^2, each in the arc of its own regime."""
    lift = machine.lift
    arcs = np.array([r.arc for r in regimes])[which]
    angle = np.array(lift.starts)[arcs] + machine.speed * (time - np.array([r.begin for r in regimes])[which])
    second = np.empty(time.size)
    for k in np.unique(arcs):
        here = arcs == k
        second[here] = lift.arcs[k].many(angle[here], 2)[2]
    return second


def _spins(states: list[Any]) -> NDArray[np.complex128]:
    return np.array([complex(s[1]) for s in states])


def _hermite_slope(u: float) -> tuple[float, ...]:
    """Derivative over u of the rows of `hermite_row`."""
    v = 1.0 - u
    return (
        -30.0 * u * u * v * v,
        v * v * (1.0 + 2.0 * u - 15.0 * u * u),
        0.5 * u * v * v * (2.0 - 5.0 * u),
        30.0 * u * u * v * v,
        u * u * (1.0 + 2.0 * v - 15.0 * v * v),
        -0.5 * u * u * v * (2.0 - 5.0 * v),
    )
