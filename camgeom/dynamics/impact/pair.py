"""Two opposing contacts with free play between them, from the tracks and touches of a cam (SI units).

The follower coordinate is q = s(phi) + eta: s the ideal motion, eta the deviation (m, or rad of an arm). A side has a
penetration delta, a lever h (force on the coordinate per newton of contact force) and a drag g, so that by virtual work

    d delta/dt = g omega - h dq/dt        force on q: F h        torque that the cam must supply: F g

and likewise a tangential lever ht and drag gt with the sliding speed v = ht dq/dt - gt omega of follower over cam. The
cam turns by +phi = omega t, anticlockwise; one that turns clockwise is seen from behind.

A roller on a planar cam and a flat face are exact at any deviation. A roller in a groove round a spatial cam is read
from tables of its exact flanks, linear in the deviation.
"""

from __future__ import annotations

import cmath
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Literal, final

import numpy as np

from camgeom.dynamics.impact.lift import Lift, LiftJets, Row
from camgeom.errors import DesignError, NotConverged, Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import TURN, Floats
from camgeom.maths.frozen import cached_property
from camgeom.motion.program import Program
from camgeom.track import Slide, Track
from camgeom.track.flank import flank
from camgeom.track.outline import FaceOutline, RollerOutline
from camgeom.track.touch import Touch

MILLI = 1e-3
ClearanceKind = Literal["chord", "normal"]

Instant = tuple[float, float, float, float, float, float]
"""delta [m], lever h, drag g, sliding lever ht, sliding drag gt [m/rad, or 1 for a slide], cam curvature [1/m]"""
Instants = tuple[Floats, Floats, Floats, Floats, Floats, Floats]
"""the same as arrays"""
Evaluator = Callable[[int, float, float, float, float, float], Instant]
"""(arc number, angle past its start [rad], s, ds, d2s there, eta) -> Instant"""


class PairSide(ABC):
    """One contact of the pair; `push` is +1 for the side that pushes towards +q, -1 for the other."""

    push: int

    @property
    @abstractmethod
    def limit(self) -> float | None:
        """The deviation eta at which contact begins, where it is the same all round; None: found from delta."""

    @property
    def rolls(self) -> tuple[float, float]:
        """Radius [m] of a roller free to turn, and how fast its carrier turns anticlockwise per unit of q; else 0."""
        return 0.0, 0.0

    @abstractmethod
    def play(self, clearance: float) -> float:
        """Free play in q [m or rad] that a clearance [m] leaves; the mean over a turn where it varies."""

    @abstractmethod
    def opened(self, clearance: float, kind: ClearanceKind) -> PairSide:
        """This side withdrawn by a clearance [m]."""

    @abstractmethod
    def problems(self, lift: Lift) -> list[Problem]:
        """What keeps a cam from being made for this follower."""

    @abstractmethod
    def compiled(self, jets: LiftJets) -> Evaluator:
        """A plain function that evaluates the contact at one moment."""

    @abstractmethod
    def many(self, lift: Lift, angle: Floats, eta: Floats) -> Instants:
        """The contact at arrays of cam angle [rad] and deviation."""


_TAYLOR = 1e-6
"""rad; a correction below this is applied by Taylor, which is exact to rounding"""
_REACH = 0.35
"""rad; Newton may not walk further from the moment's own point; then the bracketed search takes over"""


@final
@immutable(eq=True)
class Roller(PairSide):
    """A roller of `radius` [m] against the profile of a planar cam, one radius beside its pitch curve.

    The roller's centre stands at centre + arm e^(i turn q) on an arm (`turn` +1 or -1, anticlockwise positive) and at
    centre + arm q on a slide (`turn` 0, `arm` the direction). The pitch curve is that of the follower ahead by `shift`
    in q; `gap` [m] withdraws the profile along its normal. `outward` is +1 for a profile inside its pitch curve, -1 for
    the outer flank of a face groove; `begins` is the deviation at which contact begins if it is constant.
    """

    push: int
    centre: complex
    arm: complex
    turn: float
    radius: float
    outward: float = 1.0
    shift: float = 0.0
    gap: float = 0.0
    begins: float | None = 0.0

    @property
    def limit(self) -> float | None:
        return self.begins

    @property
    def rolls(self) -> tuple[float, float]:
        return self.radius, self.turn

    def play(self, clearance: float) -> float:
        return 2.0 * math.asin(clearance / (2.0 * abs(self.arm))) if self.turn else clearance

    def opened(self, clearance: float, kind: ClearanceKind) -> Roller:
        """By "chord" the cam is cut for a follower ahead by the play, by "normal" it lies back along its normal."""
        if kind == "normal":
            return replace(self, gap=clearance, begins=None)
        play = self.play(clearance)
        return replace(self, shift=play, begins=play)

    def problems(self, lift: Lift) -> list[Problem]:
        angle = lift.inner
        s0, s1, s2 = lift.many(angle, 2)
        _, c1, c2 = self.pitch(np.exp, 0.0, s0, s1, s2)
        bend = (np.conj(c1) * c2).imag * self.outward / np.abs(c1) ** 3
        worst = float((-self.radius * bend).max(initial=-math.inf))
        if worst < 1.0:
            return []
        return [Problem("roller.diameter", "the cam is undercut", self.radius, f"radius < {self.radius / worst:.6g} m")]

    def pose(self, exp: Callable[[Any], Any], q: Any) -> tuple[Any, Any]:
        """Roller centre [m] and its derivative over q; `exp` is cmath.exp or numpy.exp."""
        if not self.turn:
            return self.centre + self.arm * q, self.arm
        arm = self.arm * exp(1j * self.turn * q)
        return self.centre + arm, 1j * self.turn * arm

    def pitch(self, exp: Callable[[Any], Any], e: Any, s0: Any, s1: Any, s2: Any) -> tuple[Any, Any, Any]:
        """Point [m] of the pitch curve at u = phi + e in the machine frame and its derivatives over u; s that at u."""
        back = exp(-1j * e)
        if not self.turn:
            c, along = back * (self.centre + self.arm * (s0 + self.shift)), back * self.arm
            return c, along * s1 - 1j * c, along * (s2 - 2j * s1) - c
        hub, rate = back * self.centre, self.turn * s1 - 1.0
        arm = back * self.arm * exp(1j * self.turn * (s0 + self.shift))
        return hub + arm, 1j * (rate * arm - hub), (1j * self.turn * s2 - rate * rate) * arm - hub

    def compiled(self, jets: LiftJets) -> Evaluator:
        """A plain function of the contact; Newton for the foot point, a bracketed search where Newton fails.

        Most of the solver's time goes here: `pose` and `pitch` are written out, so that a contact costs no calls but
        those of the exponential and the motion.
        """
        centre, arm, turn, radius, gap, shift = self.centre, self.arm, self.turn, self.radius, self.gap, self.shift
        outward, pitch = self.outward, self.pitch
        exp, at, left, spin, one = cmath.exp, jets.at, 1j * outward, 1j * turn, 1.0 + 0.0j
        ahead = arm * exp(spin * shift) if turn else centre + arm * shift

        def touch(k: int, x: float, s0: float, s1: float, s2: float, eta: float) -> Instant:
            reach = arm * exp(spin * (s0 + eta)) if turn else arm * (s0 + eta)
            p = centre + reach
            u0, u1, u2, e, back, hub, found = s0, s1, s2, 0.0, one, centre, False
            for _ in range(12):
                if turn:
                    z = ahead * exp(1j * (turn * u0 - e))
                    rate = turn * u1 - 1.0
                    c = hub + z
                    c1 = 1j * (rate * z - hub)
                    c2 = (spin * u2 - rate * rate) * z - hub
                else:
                    c = back * (ahead + arm * u0)
                    c1 = back * arm * u1 - 1j * c
                    c2 = back * arm * (u2 - 2j * u1) - c
                w = p - c
                size = c1.real * c1.real + c1.imag * c1.imag
                slope = w.real * c2.real + w.imag * c2.imag - size
                if slope > -0.05 * size:
                    break
                de = -(w.real * c1.real + w.imag * c1.imag) / slope
                if -_TAYLOR < de < _TAYLOR:
                    w -= de * (c1 + 0.5 * de * c2)
                    c1 += de * c2
                    found = True
                    break
                e += de
                if not -_REACH < e < _REACH:
                    break
                u0, u1, u2 = at(k, x + e)
                back = exp(-1j * e)
                hub = back * centre
            if not found:
                c, c1, c2 = _searched(lambda e: pitch(exp, e, *at(k, x + e)), p)
                w = p - c
            speed = abs(c1)
            n = left * c1 / speed
            nr, ni = n.real, n.imag
            foot = p - radius * n
            if turn:
                across = foot - centre
                lever = turn * (reach.real * ni - reach.imag * nr)
                slide = turn * (across.real * nr + across.imag * ni)
            else:
                lever = arm.real * nr + arm.imag * ni
                slide = arm.imag * nr - arm.real * ni
            bend = outward * (c1.real * c2.imag - c1.imag * c2.real) / (speed * speed * speed)
            return (
                -(w.real * nr + w.imag * ni) - gap,
                lever,
                foot.real * ni - foot.imag * nr,
                slide,
                foot.real * nr + foot.imag * ni,
                -bend / (1.0 + bend * radius),
            )

        return touch

    def many(self, lift: Lift, angle: Floats, eta: Floats) -> Instants:
        s0, s1, s2 = lift.many(angle, 2)
        p, p1 = self.pose(np.exp, s0 + eta)
        e = np.zeros_like(angle)
        c, c1, c2 = self.pitch(np.exp, e, s0, s1, s2)
        for _ in range(8):
            w = p - c
            size, slope = np.abs(c1) ** 2, (np.conj(w) * c2).real
            de = (np.conj(w) * c1).real / np.where(slope < 0.95 * size, size - slope, size)
            if np.abs(de).max(initial=0.0) < _TAYLOR:
                c, c1 = c + de * (c1 + 0.5 * de * c2), c1 + de * c2
                break
            e = e + np.clip(de, -0.1, 0.1)
            c, c1, c2 = self.pitch(np.exp, e, *lift.many(angle + e, 2))
        else:
            for i in np.flatnonzero((np.abs(de) > 1e-9) | (np.abs(e) > _REACH)):
                c[i], c1[i], c2[i] = self._searched(lift, float(angle[i]), complex(p[i]))
        speed = np.abs(c1)
        n = 1j * self.outward * c1 / speed
        foot = p - self.radius * n
        f = 1j * self.turn * (foot - self.centre) if self.turn else self.arm
        bend = (np.conj(c1) * c2).imag * self.outward / speed**3
        return (
            -(np.conj(p - c) * n).real - self.gap,
            (np.conj(p1) * n).real,
            (np.conj(1j * foot) * n).real,
            -(np.conj(f) * n).imag,
            (np.conj(foot) * n).real,
            -bend / (1.0 + bend * self.radius),
        )

    def _searched(self, lift: Lift, angle: float, p: complex) -> tuple[complex, complex, complex]:
        return _searched(lambda e: self.pitch(cmath.exp, e, *lift.many(angle + e, 2)[:, 0].tolist()), p)


def _searched(
    point: Callable[[float], tuple[complex, complex, complex]], p: complex
) -> tuple[complex, complex, complex]:
    """The nearest point of the curve to p, by sampling and bisection; for kinks of the curvature and large play."""
    count = 64
    grid = [_REACH * (2.0 * i / count - 1.0) for i in range(count + 1)]

    def along(e: float) -> float:
        c, c1, _ = point(e)
        return ((p - c).conjugate() * c1).real

    near = min(range(count + 1), key=lambda i: abs(p - point(grid[i])[0]))
    low, high = grid[max(near - 1, 0)], grid[min(near + 1, count)]
    if not along(low) >= 0.0 >= along(high):
        raise NotConverged(
            "the roller has no nearest point on its cam within 20 degrees: the follower has left the cam; "
            "check clearance, stiffness and inertia"
        )
    for _ in range(80):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        if along(middle) > 0.0:
            low = middle
        else:
            high = middle
    return point(0.5 * (low + high))


@final
@immutable(eq=True)
class FaceSide(PairSide):
    """A flat face square to its slide on a cam of support base + push s [m]: explicit, no foot point is sought."""

    push: int
    base: float
    gap: float = 0.0

    @property
    def limit(self) -> float:
        return -self.push * self.gap

    def play(self, clearance: float) -> float:
        return clearance

    def opened(self, clearance: float, kind: ClearanceKind) -> FaceSide:
        return replace(self, gap=clearance)

    def problems(self, lift: Lift) -> list[Problem]:
        s0, _, s2 = lift.many(lift.inner, 2)
        least = float((self.base + self.push * (s0 + s2)).min())
        if least > 0.0:
            return []
        return [Problem("base_radius", "the cam is not convex", self.base, f"> {self.base - least:.6g} m")]

    def compiled(self, jets: LiftJets) -> Evaluator:
        base, gap, push = self.base, self.gap, float(self.push)

        def touch(k: int, x: float, s0: float, s1: float, s2: float, eta: float) -> Instant:
            support = base + push * s0
            return -push * eta - gap, push, push * s1, 0.0, support, 1.0 / (support + push * s2)

        return touch

    def many(self, lift: Lift, angle: Floats, eta: Floats) -> Instants:
        s0, s1, s2 = self.push * lift.many(angle, 2)
        support, push = self.base + s0, np.full_like(eta, self.push)
        return -push * eta - self.gap, push, s1, np.zeros_like(eta), support, 1.0 / (support + s2)


@final
class Ring:
    """Periodic cubic spline through equally spaced values round the cam, with its slope."""

    def __init__(self, values: Row) -> None:
        y = np.asarray(values, dtype=np.float64)
        self.n = y.size
        self.step = TURN / y.size
        # Slopes of the C2 spline: m[-1] + 4 m[0] + m[1] = 3 (y[1] - y[-1])/h, a circulant system solved by FFT.
        right = 3.0 * (np.roll(y, -1) - np.roll(y, 1)) / self.step
        symbol = 4.0 + 2.0 * np.cos(TURN * np.arange(y.size) / y.size)
        slope = np.fft.ifft(np.fft.fft(right) / symbol).real
        y1, m1 = np.roll(y, -1), np.roll(slope, -1)
        h = self.step
        self.rows = np.stack(
            [y, slope, (3 * (y1 - y) / h - 2 * slope - m1) / h, (2 * (y - y1) / h + slope + m1) / h**2]
        )
        self.table = [(float(a), float(b), float(c), float(d)) for a, b, c, d in self.rows.T]

    def many(self, angle: Floats) -> tuple[Floats, Floats]:
        """Values and slopes at an array of angles [rad]."""
        place = np.mod(angle / self.step, self.n)
        k = np.minimum(place.astype(np.int64), self.n - 1)
        u = (place - k) * self.step
        a, b, c, d = self.rows[:, k]
        return a + u * (b + u * (c + u * d)), b + u * (2.0 * c + 3.0 * u * d)


@final
@immutable(eq=True)
class GrooveWall(PairSide):
    """One wall of a groove round a spatial cam, by its exact flank at equal steps of one turn, the last not repeated.

    `lever` [m/rad, or 1], > 0, is the normal component of the follower's velocity at the contact, `curvature` [1/m]
    that of the cam, `sliding` [m/rad] the sliding speed per unit of cam speed; `gap` [m] is taken along the normal.
    With the deviation gap/lever at which the wall is touched

        delta = -push lever (eta + push gap/lever)

    is linear in the deviation, exact to first order in the play over the radius of curvature (3.5e-3 of the clearance
    at 1 mm on a 130 mm cam).
    """

    push: int
    lever: Row
    curvature: Row
    sliding: Row
    gap: float = 0.0

    @property
    def limit(self) -> float | None:
        return None if self.gap else 0.0

    def play(self, clearance: float) -> float:
        return clearance * float(np.mean(1.0 / np.asarray(self.lever)))

    def opened(self, clearance: float, kind: ClearanceKind) -> GrooveWall:
        return replace(self, gap=clearance)

    def problems(self, lift: Lift) -> list[Problem]:
        if min(self.lever) > 0.0:
            return []
        return [Problem("lever", "must be positive: the wall must be able to drive", min(self.lever), "> 0")]

    @cached_property
    def _rings(self) -> tuple[Ring, Ring, Ring, Ring]:
        offset = tuple(-self.push * self.gap / lever for lever in self.lever)
        return Ring(self.lever), Ring(offset), Ring(self.curvature), Ring(self.sliding)

    def compiled(self, jets: LiftJets) -> Evaluator:
        # The four share their places: one lookup for all.
        first, starts, push = self._rings[0], jets.starts, float(self.push)
        step, count = first.step, first.n
        rows = [a + b + c + d for a, b, c, d in zip(*(ring.table for ring in self._rings))]

        def touch(k: int, x: float, s0: float, s1: float, s2: float, eta: float) -> Instant:
            place = ((starts[k] + x) / step) % count
            j = min(int(place), count - 1)
            u = (place - j) * step
            l0, l1, l2, l3, o0, o1, o2, o3, c0, c1, c2, c3, g0, g1, g2, g3 = rows[j]
            lever = l0 + u * (l1 + u * (l2 + u * l3))
            away = push * (eta - (o0 + u * (o1 + u * (o2 + u * o3))))
            offset1 = o1 + u * (2.0 * o2 + 3.0 * u * o3)
            drag = push * lever * (s1 + offset1) - (l1 + u * (2.0 * l2 + 3.0 * u * l3)) * away
            slide, bend = g0 + u * (g1 + u * (g2 + u * g3)), c0 + u * (c1 + u * (c2 + u * c3))
            return -lever * away, push * lever, drag, 0.0, slide, bend

        return touch

    def many(self, lift: Lift, angle: Floats, eta: Floats) -> Instants:
        lever_ring, offset_ring, bend_ring, slide_ring = self._rings
        lever, lever1 = lever_ring.many(angle)
        offset, offset1 = offset_ring.many(angle)
        away = self.push * (eta - offset)
        drag = self.push * lever * (lift.many(angle, 1)[1] + offset1) - lever1 * away
        bend, slide = bend_ring.many(angle)[0], slide_ring.many(angle)[0]
        return -lever * away, self.push * lever, drag, np.zeros_like(eta), slide, bend


@final
@immutable(eq=True)
class Pair:
    """Two opposing sides and the motion between them, which ends in contact with the main side at eta = 0.

    `main` pushes towards +q, `back` towards -q; both touch at eta = 0 without clearance. `clearance` [m] withdraws the
    back side, as a chord between the two limiting positions of a roller centre or as a gap along the common normal;
    `clearance_text` says which in words. Raises ProfileError without a clearance, DesignError where the cam cannot be
    made.
    """

    lift: Lift
    main: PairSide
    back: PairSide
    clearance: float
    kind: ClearanceKind
    clearance_text: str

    def __post_init__(self) -> None:
        if not 0.0 < self.clearance < math.inf:
            raise ProfileError([Problem("clearance", "contact with free play needs a gap", self.clearance, "> 0 m")])
        problems = [problem for side in self.sides for problem in side.problems(self.lift)]
        if problems:
            raise DesignError("; ".join(dict.fromkeys(map(str, problems))))

    @cached_property
    def sides(self) -> tuple[PairSide, PairSide]:
        """The main side (+q), and the return side (-q) withdrawn by the clearance."""
        return self.main, self.back.opened(self.clearance, self.kind)

    @property
    def play(self) -> float:
        """Free play in the follower coordinate [m or rad]; the mean over a turn where it varies."""
        return self.back.play(self.clearance)

    def with_clearance(self, clearance: float) -> Pair:
        """The same pair with another clearance [m]."""
        return replace(self, clearance=clearance)

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
                delta, lever, *_ = side.many(self.lift, at, eta)
                eta = eta + delta / lever
            ends.append(float(eta[0]))
        return 0.5 * (ends[0] + ends[1])


def planar_pair(program: Program, touches: Sequence[Touch], clearance: float, kind: ClearanceKind) -> Pair:
    """The two touches of a planar cam that drive its follower to and fro, with a clearance [m] between them.

    A roller in a groove and a frame with flat faces have no chord that is the same all round, or that differs from the
    gap along the normal: their clearance is that gap.
    """
    main, back = sorted(touches, key=lambda touch: -touch.way)
    lift = Lift.from_program(program, MILLI if isinstance(main.joint, Slide) else 1.0)
    first, second = _planar(main), _planar(back)
    text = "chord between the two limiting positions of the roller centre"
    if isinstance(second, FaceSide):
        kind, text = "normal", "gap along the common normal, which is the direction of motion"
    elif kind == "normal" or back.material < 0.0:
        kind, text = "normal", "gap along the common normal"
    return Pair(lift, first, second, clearance, kind, text)


def _planar(touch: Touch) -> Roller | FaceSide:
    """The side of a planar cam's touch."""
    outline, push = touch.outline, int(touch.way)
    if isinstance(outline, FaceOutline):
        # The supports of opposite tangents of a constant-width cam add up to one width.
        program, lag = outline.line.program, np.array([0.0, touch.lag])
        ends = program.jet(lag, 0)[0] if touch.lag else np.zeros(2)
        return FaceSide(push, MILLI * (outline.line.base + float(ends.sum())))
    assert isinstance(outline, RollerOutline)
    track, seen = outline.track, touch.sense
    anchor = MILLI * complex(track.anchor[0], seen * track.anchor[1])
    if isinstance(track.joint, Slide):
        x, y, _ = track.joint.direction
        return Roller(push, anchor, complex(x, seen * y), 0.0, MILLI * touch.radius, touch.material)
    centre = MILLI * complex(track.joint.centre[0], seen * track.joint.centre[1])
    return Roller(
        push, centre, anchor - centre, seen * track.joint.axis[2], MILLI * touch.radius, touch.material
    )


def groove_pair(track: Track, clearance: float, station: float, count: int = 720) -> Pair:
    """The roller of a groove track with a clearance [m] between its walls, seen at one station along the roller.

    `station` is the delta [mm] at which the contact is taken (its middle), `count` the steps round the cam. The
    follower coordinate is the track's, in m for a slide and rad for an arm; levers, curvature and sliding are those of
    the exact surface. Raises ProfileError where the track has one flank only or does not close.
    """
    if len(track.sides) < 2:
        raise ProfileError([Problem("track", "free play needs two flanks", track.name, "a groove or a pair of cams")])
    if not track.closed:
        raise ProfileError([Problem("track", "contact with free play is solved for closed tracks", track.name)])
    unit = MILLI if isinstance(track.joint, Slide) else 1.0
    phi: Floats = np.linspace(0.0, TURN, count, endpoint=False)
    parameter: Floats = np.full(1, track.meridian.parameter(station))
    radius = float(track.meridian.jet(parameter)[3][0])
    pose = track.pose(phi, 1)
    velocity = pose.a[1] + station * pose.u[1]
    sliding = tuple(map(float, MILLI * np.sqrt((velocity**2).sum(axis=0))))
    lift = Lift.from_program(track.program, unit)
    walls = {}
    for side in (1.0, -1.0):
        wall = flank(track, phi, parameter, side)
        # The normal points into the wall: the wall pushes the roller against it.
        lever = -track.factor * wall.lever()[:, 0] * (MILLI / unit)
        bend = 1e3 * (wall.k_rel[:, 0] - 1.0 / radius)
        push = 1 if lever[0] > 0.0 else -1
        walls[push] = GrooveWall(push, tuple(map(float, push * lever)), tuple(map(float, bend)), sliding)
    if len(walls) < 2:
        raise ProfileError([Problem("track", "both flanks push the same way", track.name)])
    return Pair(lift, walls[1], walls[-1], clearance, "normal", "gap along the common normal, from tables")
