"""Forces on the follower, the contact and the camshaft over one turn.

Units: N, mm, MPa, s, rad; mass kg, inertia kg m². A translating follower has a force in N; a swinging follower or a
turret has a torque in N mm. Positive pushes towards larger lift, so that the wall behind the roller (towards smaller
lift) carries it. Arrays are (..., p, n) on panels: leading axes are variants.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Literal, final

import numpy as np
from numpy.typing import ArrayLike

from camgeom.errors import DesignError, NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.frozen import cached_property
from camgeom.maths.panels import TURN, Panels, panels, resolved, roots

if TYPE_CHECKING:
    from camgeom.mechanics.applied import Applied, Motion

MILLI = 1e-3
"""kg mm/s² in N"""
KILO = 1e3
"""kg m² rad/s² (N m) in N mm"""
SOLVED = 1e-6
"""share of its largest value to which a solved force is resolved: that of its solver"""
MOST_PANELS = 5000
"""of a solved force, of 12 points each: they follow some 10 000 swings in a turn"""
QUIET = 1e-9
"""Share of the largest force below which a force counts as none: rounding in a dwell takes no side."""
FLAT = 1e-9
"""rad; a pressure angle that is none"""


@final
@immutable(eq=True)
class SiLoad:
    """A load without variants in SI: mass kg (inertia kg m²), forces N (N m), rate N/m (N m/rad)."""

    mass: float
    friction: float
    preload: float
    rate: float
    weight: float


@final
@immutable
class Demand:
    """What a follower asks of its cam where its motion is known: the sum of `Load`, in numbers that broadcast with it.

    Units and kinds as those of `Load`.
    """

    speed: Floats
    mass: Floats
    friction: Floats
    preload: Floats
    rate: Floats
    weight: Floats
    applied: tuple[Applied, ...] = ()
    rotating: bool = False

    def force(self, theta: Floats, jet: Sequence[Floats] | Floats, side: Floats) -> tuple[Floats, Floats]:
        """Force (N, N mm) at cam angles, rad, and the part of it that the mass takes.

        jet: s, s', s'' by the cam angle; side: sign of the motion.
        """
        inertia = inertia_force(self.mass, self.speed, jet[2], self.rotating)
        force = np.asarray(self.friction * side + inertia + (self.preload + self.weight) + self.rate * jet[0])
        for one in self.applied:
            force = force + self.of(one, theta, jet).astype(force.dtype, copy=False)
        return force, inertia

    def of(self, one: Applied, theta: Floats, jet: Sequence[Floats] | Floats) -> Floats:
        """One of the applied forces."""
        if not one.moved:
            return one(theta)
        return one(theta, jet[0], self.speed * jet[1], self.speed * self.speed * jet[2])


@final
@immutable
class Load:
    """Everything that acts on a follower over a turn; `sampled` gives the force (N) or torque (N mm) it needs.

    F = friction sign(s') + applied + m omega² s'' + preload + rate s + weight

    kind "translating": mass kg, s mm, forces N, rate N/mm; kind "rotating" (swinging follower, turret): mass is the
    inertia in kg m², s rad, every force a torque in N mm, rate N mm/rad. Any number may be an array (...) of variants.
    speed: cam speed, rad/s, constant; friction acts against the motion and not in a dwell; weight: the component of
    gravity along the motion, positive where it pulls towards smaller lift.
    """

    motion: Motion
    speed: ArrayLike
    mass: ArrayLike = 0.0
    friction: ArrayLike = 0.0
    preload: ArrayLike = 0.0
    rate: ArrayLike = 0.0
    weight: ArrayLike = 0.0
    applied: Sequence[Applied] = ()
    kind: Literal["translating", "rotating"] = "translating"
    guide_friction: float = 0.0
    """of a slide's guides: grows with the side thrust, which the geometry decides (see `normal_force`)"""
    solved: Callable[[Floats], Floats] | None = None
    """force, N (N mm), over cam angles (n,) that a solver found between cam and follower, in place of that sum"""
    solved_on: Panels | None = None
    """panels on which that force is known to be smooth; else they are sought"""

    @property
    def omega(self) -> float:
        """Cam speed, rad/s, of a load without variants."""
        return float(np.asarray(self.speed))

    @property
    def rotating(self) -> bool:
        """True for an angle and torques, False for a length and forces."""
        return self.kind == "rotating"

    @property
    def si(self) -> SiLoad:
        """The numbers that do not hang on the cam angle, of a load without variants, in SI."""
        unit, length = (MILLI, 1.0) if self.rotating else (1.0, MILLI)
        mass, friction, preload, rate, weight = (
            float(np.asarray(value)) for value in (self.mass, self.friction, self.preload, self.rate, self.weight)
        )
        return SiLoad(mass, unit * friction, unit * preload, unit * rate / length, unit * weight)

    @cached_property
    def given(self) -> Panels:
        """A turn between the cam angles at which what is given may jump: knots of the motion, ends of forces."""
        given = [np.array([0.0, TURN]), np.asarray(self.motion.knots, dtype=np.float64)]
        given += [np.asarray(force.breaks, dtype=np.float64) for force in self.applied]
        edges = np.concatenate(given)
        return panels(edges[(edges >= 0.0) & (edges <= TURN)])

    def breaks(self) -> Floats:
        """Cam angles, rad, where force or curvature may jump or kink: knots, ends of forces, zeros of s' and s''."""
        rough = self.given
        jet = _jet(self.motion, rough.theta)
        found = [roots(rough, jet[k][None], QUIET * np.abs(jet[k]).max(initial=0.0))[0] for k in (1, 2)]
        return np.concatenate([rough.breaks, *found])

    def panels(
        self, widest: float = float(np.radians(6.0)), tolerance: float = 1e-10, most: int = MOST_PANELS
    ) -> Panels:
        """Panels on which motion and applied forces are resolved to the tolerance (a share of their largest value).

        Raises NotConverged where a solved force would need more than so many.
        """
        if self.solved_on is not None:
            return self.solved_on.split(self.breaks())
        start = panels(self.breaks(), widest)
        if self.solved is None:
            return resolved(self._smooth, start, tolerance)
        try:
            return resolved(self._smooth, start, max(tolerance, SOLVED), most=max(most, 2 * len(start.half)))
        except NotConverged as error:
            raise NotConverged(
                f"the solved contact force cannot be sampled: {error}; what rings for a whole turn needs damping in "
                "[dynamics], or a higher speed or softer shafts, so that it swings less often in a turn"
            ) from None

    def sampled(self, where: Panels | None = None) -> FollowerForce:
        """The force over one turn, on the given panels or on ones that resolve it."""
        on = self.panels() if where is None else where
        jet = _jet(self.motion, on.theta)
        side = direction(on, jet[1])
        force, inertia = self.demand.force(on.theta, jet, side)
        if self.solved is not None:
            force = self.solved(on.theta.ravel()).reshape(on.theta.shape)
        return FollowerForce(on, jet[0], jet[1], jet[2], side, force, inertia)

    @cached_property
    def demand(self) -> Demand:
        """The numbers of the sum above, ready to meet (p, n)."""
        return Demand(
            column(self.speed), column(self.mass), column(self.friction), column(self.preload), column(self.rate),
            column(self.weight), tuple(self.applied), self.rotating,
        )  # fmt: skip

    def _smooth(self, theta: Floats) -> Floats:
        jet = _jet(self.motion, theta)
        demand = self.demand
        forces = [demand.of(one, theta, jet).reshape(-1, *theta.shape) for one in self.applied]
        if self.solved is not None:
            forces.append(self.solved(theta.ravel()).reshape(1, *theta.shape))
        return np.concatenate([jet, *forces])


@final
@immutable
class FollowerForce:
    """Motion and force on panels: lift (mm or rad) and derivatives (p, n), direction (p, 1), force (..., p, n).

    direction: sign of the motion, 0 in a dwell; force: what the cam must give, N or N mm, positive towards larger
    lift; inertia: the part of it that the mass takes.
    """

    panels: Panels
    lift: Floats
    ds: Floats
    dds: Floats
    direction: Floats
    force: Floats
    inertia: Floats

    def normal(self, cos_alpha: ArrayLike, lever: ArrayLike = 1.0, guide_friction: ArrayLike = 0.0) -> Floats:
        """Signed normal force on the roller, N; see `normal_force`."""
        return normal_force(self.force, cos_alpha, lever, column(guide_friction), self.direction)

    def camshaft_torque(self) -> Floats:
        """Torque that the cam takes from its shaft, N mm: F ds/dtheta, without losses at the roller, (..., p, n)."""
        return np.asarray(self.force * self.ds)

    def work(self) -> Floats:
        """Work of the cam on the follower over a turn, N mm: what friction and applied forces consume."""
        return self.panels.integral(self.camshaft_torque())

    def reversals(self) -> list[tuple[Reversal, ...]]:
        """Changes of the loaded wall, one tuple a variant (variants in flattened order)."""
        return reversals(self.panels, self.force)


def inertia_force(mass: Floats, speed: Floats, dds: Floats, rotating: bool) -> Floats:
    """Force, N, that moves a mass, kg, by its lift's second derivative, mm/rad²; rotating: torque, N mm, of an inertia,
    kg m². Speed of the cam in rad/s; all broadcast."""
    return np.asarray(((KILO if rotating else MILLI) * mass * speed * speed) * dds)


def direction(where: Panels, ds: Floats) -> Floats:
    """Sign of the motion (-1, 0, 1) in every panel, (p, 1); the panels' breaks hold every reversal of s'."""
    total = (where.half[:, None] * ds).sum(axis=-1)
    piece = where.piece
    moved = np.bincount(piece, total, minlength=len(where.breaks) - 1)
    largest = np.zeros(len(where.breaks) - 1)
    np.maximum.at(largest, piece, np.abs(ds).max(axis=-1))
    still = largest <= QUIET * np.abs(ds).max(initial=0.0)
    return np.asarray(np.where(still, 0.0, np.sign(moved))[piece][:, None])


def normal_force(force: ArrayLike, cos_alpha: ArrayLike, lever: ArrayLike = 1.0, guide_friction: ArrayLike = 0.0,
                 side: ArrayLike = 0.0) -> Floats:
    """Signed normal force on the roller, N, from the follower's force (N) or torque (N mm) and the pressure angle.

    Fn = F / (lever (cos(alpha) - sign(F) side mu sin(alpha))); lever 1 for a translating follower, the distance from
    pivot to contact in mm for a rotating one. mu: Coulomb friction of the guides times the factor by which bearing
    distance and overhang raise the guide reaction above the side thrust Fn sin(alpha) (1 or more); side: sign of the
    motion. Raises DesignError where the follower jams (denominator not positive).
    """
    demand, cosine = np.asarray(force, dtype=np.float64), np.asarray(cos_alpha, dtype=np.float64)
    friction = np.asarray(guide_friction, dtype=np.float64)
    share = thrust_share(demand, cosine, friction, np.asarray(side, dtype=np.float64))
    if np.any(share <= 0.0):
        angle = float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)).max()))
        raise DesignError(f"the follower jams in its guides: pressure angle up to {angle:.4g} deg with guide friction "
                          f"{float(np.max(friction)):.4g}; lower the pressure angle or the friction")
    return np.asarray(demand / (np.asarray(lever, dtype=np.float64) * share))


def thrust_share(force: Floats, cosine: Floats, friction: Floats, side: Floats) -> Floats:
    """cos(alpha) - sign(F) side mu sin(alpha) of `normal_force`; a follower jams where it is not positive."""
    sine = np.sqrt(np.maximum((1.0 - cosine) * (1.0 + cosine), 0.0))
    return np.asarray(cosine - np.sign(force) * side * friction * sine)


def guided_force(force: Floats, cos_alpha: ArrayLike, guide_friction: float, side: ArrayLike) -> Floats:
    """Force along the motion that the cam gives a slide, N: the follower's `force` and the friction of its guides.

    The guides hold back mu times the side thrust Fn sin(alpha); side: sign of the motion. Raises DesignError where the
    follower jams.
    """
    if guide_friction == 0.0:
        return force
    cosine = np.asarray(cos_alpha, dtype=np.float64)
    return np.asarray(cosine * normal_force(force, cosine, 1.0, guide_friction, side))


@final
@immutable(eq=True)
class Reversal:
    """A change of the loaded wall: cam angles (rad) where one wall is left and the other taken, +1 behind, -1 ahead.

    left differs from taken where the roller is free in between (an unloaded dwell), which may run past the turn's end.
    """

    left: float
    taken: float
    wall: int


def reversals(where: Panels, force: Floats) -> list[tuple[Reversal, ...]]:
    """Changes of the loaded wall round the cam, one tuple for each row of force (..., p, n), located to 1e-9 rad.

    Zeros of the force inside panels are refined; jumps at breaks count at the break. A force below QUIET of the
    largest takes no side.
    """
    rows = force.reshape(-1, *force.shape[-2:])
    floor = QUIET * np.abs(rows).max(axis=(1, 2), initial=0.0)
    inside = roots(where, rows, floor)
    return [_walls(where, rows[k], inside[k], float(floor[k])) for k in range(len(rows))]


def _walls(where: Panels, force: Floats, zeros: Floats, floor: float) -> tuple[Reversal, ...]:
    """Reversals of one row: the sign between consecutive zeros and breaks, followed round the turn."""
    edges = distinct(np.concatenate([where.edges, zeros]))
    middle = 0.5 * (edges[1:] + edges[:-1])
    value = where.at(force, middle)
    sign = np.where(np.abs(value) <= floor, 0, np.sign(value)).astype(int)
    loaded = np.nonzero(sign)[0]
    if not loaded.size:
        return ()
    found = []
    for first, second in zip(loaded, np.roll(loaded, -1)):
        if sign[first] != sign[second]:
            found.append(Reversal(float(edges[first + 1]), float(edges[second]), int(sign[second])))
    return tuple(sorted(found, key=lambda change: change.taken))


def _jet(motion: Motion, theta: Floats) -> Floats:
    """s, s', s'' on (p, n) sample points, (3, p, n)."""
    return np.asarray(motion.jet(theta.ravel(), 2)[:3], dtype=np.float64).reshape(3, *theta.shape)


def column(value: ArrayLike) -> Floats:
    """A number or an array (...) of variants, ready to meet (p, n)."""
    array = np.asarray(value, dtype=np.float64)
    return array if array.ndim == 0 else array[..., None, None]
