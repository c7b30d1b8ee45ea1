"""The right-hand sides of the contact solver, one plain function a regime (SI units)."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import cast, final

import numpy as np

from camgeom.dynamics.impact.laws import ImpactDamping
from camgeom.dynamics.impact.problem import Coordinates, ImpactProblem, Rate, Regime, RollerSpin, State, follower, spin
from camgeom.errors import NotConverged

PlainRate = Callable[[float, complex], tuple[complex, complex]]


@final
class CompiledProblem:
    """The problem compiled to plain functions of floats.

    Every right-hand side also gives two powers: what the cam supplies, and what is lost in damping and friction. Where
    the elastic force depends on the place as well as the penetration it has no potential, and the second power then
    holds all that goes into the contact.
    """

    def __init__(self, problem: ImpactProblem) -> None:
        self.problem = problem
        self.lift = problem.pair.lift
        self.jets = self.lift.compiled()
        sides = problem.pair.sides
        self.touches = tuple(side.compiled(self.jets) for side in sides)
        self.limits = tuple(side.limit for side in sides)
        self.speed = problem.speed
        load = problem.load
        self.resistances = tuple(load.resistance(arc.start, arc.end) for arc in self.lift.arcs)
        self.factor = problem.damping.factor if isinstance(problem.damping, ImpactDamping) else 0.0
        self.levers = self._largest_levers()
        self.eta_scale, self.rate_scale = self._scales()

    def __reduce__(self) -> tuple[type[CompiledProblem], tuple[ImpactProblem]]:
        # Functions are not pickled: they are made again.
        return CompiledProblem, (self.problem,)

    def _largest_levers(self) -> tuple[float, float]:
        angle = np.linspace(0.0, 2.0 * math.pi, 121)
        main, back = (side.many(self.lift, angle, np.zeros_like(angle))[1] for side in self.problem.pair.sides)
        return float(np.abs(main).max()), float(np.abs(back).max())

    def _scales(self) -> tuple[float, float]:
        """Sizes of deviation and its rate that the tolerance refers to: play and static deflection, free flight."""
        lift, w, lever = self.lift, self.speed, max(self.levers)
        inertia = max(self.problem.inertia * lift.peaks[2] * w * w, self.problem.load.largest)
        deflection = self._deflection(inertia / lever) / lever
        size = self.problem.pair.play + deflection
        jerk = lift.peaks[3] * w**3
        flight = math.cbrt(6.0 * size / jerk) if jerk > 0.0 else 1.0 / w
        return size, max(0.5 * jerk * flight * flight, size * w)

    def _deflection(self, force: float) -> float:
        """Penetration [m] at a contact force [N], of the main side."""
        if force <= 0.0:
            return 0.0
        law = self.problem.law
        low, high = -14.0, -2.0
        for _ in range(50):
            middle = 0.5 * (low + high)
            try:
                short = law.force(math.pow(10.0, middle), 0.0) < force
            except NotConverged:
                short = False
            low, high = (middle, high) if short else (low, middle)
        return math.pow(10.0, low)

    def depth(self, which: int, regime: Regime, t: float, y: complex) -> tuple[float, float]:
        """How far the follower is past the limit of side `which` (0 main, 1 return), and its rate of change."""
        eta, rate = y.real, y.imag
        limit = self.limits[which]
        if limit is not None:
            return (limit - eta, -rate) if which == 0 else (eta - limit, rate)
        delta, speed = self.approach(which, regime, t, y)[:2]
        return delta, speed

    def approach(self, which: int, regime: Regime, t: float, y: complex) -> tuple[float, float, float]:
        """Penetration [m], its rate [m/s] and the factor of the elastic force that damping leaves (negative: clip)."""
        eta, rate = y.real, y.imag
        x = self.speed * (t - regime.begin)
        s0, s1, s2 = self.jets.jets[regime.arc](x)
        delta, h, g, _, _, bend = self.touches[which](regime.arc, x, s0, s1, s2, eta)
        speed = g * self.speed - h * (s1 * self.speed + rate)
        damping = self.problem.damping
        if isinstance(damping, ImpactDamping):
            return delta, speed, 1.0 + damping.factor * speed / regime.approach
        elastic = self.problem.laws[which].force(delta, bend)
        return delta, speed, 1.0 + damping.viscosity(delta) * speed / elastic if elastic > 0.0 else 1.0

    def rate(self, regime: Regime) -> Rate:
        """The right-hand side of a regime."""
        if self.problem.spin is not None:
            return self._spinning(regime, self.problem.spin)
        quick = self.problem.friction is None and not self.problem.load.acts and not regime.clipped
        if regime.state == State.FREE:
            rate = self._flight(regime)
        elif quick and isinstance(self.problem.damping, ImpactDamping):
            rate = self._contact(regime)
        else:
            rate = self._general(regime)
        # Without roller spins every state is one complex number.
        return cast("Rate", rate)

    def _flight(self, regime: Regime) -> PlainRate:
        jet, begin, w = self.jets.jets[regime.arc], regime.begin, self.speed
        ww, load, inverse = w * w, self.problem.load, 1.0 / self.problem.inertia
        if not load.acts:
            return lambda t, y: (complex(y.imag, -ww * jet(w * (t - begin))[2]), 0j)

        resistance = self.resistances[regime.arc]

        def rate(t: float, y: complex) -> tuple[complex, complex]:
            x = w * (t - begin)
            s0, s1, s2 = jet(x)
            speed = s1 * w + y.imag
            against = resistance(x, speed)
            force = load.constant - load.stiffness * (s0 + y.real) - against
            return complex(y.imag, force * inverse - s2 * ww), complex(0.0, against * speed)

        return rate

    def _contact(self, regime: Regime) -> PlainRate:
        arc, begin, w = regime.arc, regime.begin, self.speed
        which = regime.state - 1
        jet, touch, law = self.jets.jets[arc], self.touches[which], self.problem.laws[which].force
        ww, inverse, damp = w * w, 1.0 / self.problem.inertia, self.factor / regime.approach
        whole = self.problem.law.uses_curvature

        def rate(t: float, y: complex) -> tuple[complex, complex]:
            x = w * (t - begin)
            s0, s1, s2 = jet(x)
            rate = y.imag
            delta, h, g, _, _, bend = touch(arc, x, s0, s1, s2, y.real)
            speed = g * w - h * (s1 * w + rate)
            elastic = law(delta, bend)
            lost = elastic * damp * speed
            force = elastic + lost
            return complex(rate, force * h * inverse - s2 * ww), complex(
                force * g * w, (force if whole else lost) * speed
            )

        return rate

    def _general(self, regime: Regime) -> PlainRate:
        arc, begin, w = regime.arc, regime.begin, self.speed
        jet, touch, forces = self.jets.jets[arc], self.touches[regime.state - 1], self._forces(regime)
        load, inverse = self.problem.load, 1.0 / self.problem.inertia
        whole = self.problem.law.uses_curvature
        resistance = self.resistances[arc]
        mu = self.problem.friction.coefficient if self.problem.friction is not None else None

        def rate(t: float, y: complex) -> tuple[complex, complex]:
            x = w * (t - begin)
            s0, s1, s2 = jet(x)
            delta, h, g, ht, gt, bend = touch(arc, x, s0, s1, s2, y.real)
            q, q1 = s0 + y.real, s1 * w + y.imag
            speed = g * w - h * q1
            elastic, lost = forces(delta, bend, speed)
            force = elastic + lost
            torque, given, spent = force * h, force * g * w, (force if whole else lost) * speed
            if mu is not None:
                slide = ht * q1 - gt * w
                rub = mu(slide) * force
                torque -= rub * ht
                given -= rub * gt * w
                spent += rub * slide
            if load.acts:
                against = resistance(x, q1)
                torque += load.constant - load.stiffness * q - against
                spent += against * q1
            return complex(y.imag, torque * inverse - s2 * w * w), complex(given, spent)

        return rate

    def _forces(self, regime: Regime) -> Callable[[float, float, float], tuple[float, float]]:
        """(penetration, curvature, penetration rate) -> elastic force and damping force [N]; clipped they cancel."""
        law, damping = self.problem.laws[max(regime.state - 1, 0)].force, self.problem.damping
        if regime.clipped:

            def clipped(delta: float, bend: float, speed: float) -> tuple[float, float]:
                elastic = law(delta, bend)
                return elastic, -elastic

            return clipped
        if isinstance(damping, ImpactDamping):
            damp = damping.factor / regime.approach

            def hybrid(delta: float, bend: float, speed: float) -> tuple[float, float]:
                elastic = law(delta, bend)
                return elastic, elastic * damp * speed

            return hybrid
        viscosity = damping.viscosity
        return lambda delta, bend, speed: (law(delta, bend), viscosity(delta) * speed)

    def _spinning(self, regime: Regime, rollers: RollerSpin) -> Rate:
        """State (eta + 1j rate, spin main + 1j spin return); a roller without contact only feels its bearing."""
        friction = self.problem.friction
        assert friction is not None
        arc, begin, w = regime.arc, regime.begin, self.speed
        load, inverse, mu = self.problem.load, 1.0 / self.problem.inertia, friction.coefficient
        jet, free = self.jets.jets[arc], regime.state == State.FREE
        which, whole = 0 if free else regime.state - 1, self.problem.law.uses_curvature
        touch, forces = self.touches[which], self._forces(regime)
        resistance = self.resistances[arc]
        radius, carrier = self.problem.pair.sides[which].rolls

        def rate(t: float, y: Coordinates) -> tuple[Coordinates, complex]:
            x = w * (t - begin)
            s0, s1, s2 = jet(x)
            moving, spins = follower(y), spin(y)
            eta, eta1 = moving.real, moving.imag
            q, q1 = s0 + eta, s1 * w + eta1
            against = resistance(x, q1)
            torque = load.constant - load.stiffness * q - against
            spent = against * q1 + rollers.drag * abs(spins) ** 2
            given, turning = 0.0, -rollers.drag * spins / rollers.inertia
            if not free:
                delta, h, g, ht, gt, bend = touch(arc, x, s0, s1, s2, eta)
                elastic, lost = forces(delta, bend, g * w - h * q1)
                force = elastic + lost
                own = spins.real if which == 0 else spins.imag
                # The contact point of a turning roller: that of the centre, less the surface speed of the spin.
                centre = ht + radius * carrier
                slide = centre * q1 - radius * own - gt * w
                rub = mu(slide) * force
                torque += force * h - rub * centre
                given = force * g * w - rub * gt * w
                spent += (force if whole else lost) * (g * w - h * q1) + rub * slide
                gain = rub * radius / rollers.inertia
                turning += gain if which == 0 else 1j * gain
            return np.array([complex(eta1, torque * inverse - s2 * w * w), turning]), complex(given, spent)

        return rate
