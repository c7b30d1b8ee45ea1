"""The waist: a roller, the joint that carries it, and the motion program that drives it.

Every cam is the envelope of its follower, seen from the cam; a `Track` is all that the envelope needs to know.
Cam types only produce tracks (and a blank); flanks, checks, solids, contact and exports only consume them.
"""

from __future__ import annotations

from dataclasses import replace
from math import asin, comb, sqrt, tan
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from camgeom.immutable import immutable
from camgeom.maths import TURN as TURN
from camgeom.maths import Floats, distinct
from camgeom.motion.program import Program
from camgeom.motion.table import Side

if TYPE_CHECKING:
    from camgeom.track.carriage import Carriage

Vector = tuple[float, float, float]
Complexes = npt.NDArray[np.complex128]


@immutable(eq=True)
class Straight:
    """Meridian of a cylinder or cone: radius + slope * (delta - centre). The parameter t is delta, mm."""

    radius: float
    centre: float
    slope: float = 0.0

    def jet(self, t: Floats) -> tuple[Floats, Floats, Floats, Floats, Floats, Floats]:
        """delta, r and their first and second derivatives by t: (delta, delta', delta'', r, r', r'')."""
        one, zero = np.ones_like(t), np.zeros_like(t)
        return t, one, zero, self.radius + self.slope * (t - self.centre), self.slope * one, zero

    def parameter(self, delta: float) -> float:
        """The t at the axial coordinate delta."""
        return delta

    def parameters(self, delta: Floats) -> Floats:
        """The t at axial coordinates delta, (...)."""
        return delta

    def grown(self, gap: float) -> Straight:
        """The parallel meridian at the normal distance gap, mm."""
        return replace(self, radius=self.radius + gap * sqrt(1.0 + self.slope**2))


@immutable(eq=True)
class Arc:
    """Meridian of a crowned roller or a sphere: an arc of radius `arc` whose crest (radius) is at `centre`.

    delta = centre + arc sin t, r = radius - arc (1 - cos t); a sphere has arc = radius. The parameter t is an angle.
    """

    radius: float
    centre: float
    arc: float

    def jet(self, t: Floats) -> tuple[Floats, Floats, Floats, Floats, Floats, Floats]:
        """(delta, delta', delta'', r, r', r'') at t."""
        c, s = np.cos(t), np.sin(t)
        a = self.arc
        return self.centre + a * s, a * c, -a * s, self.radius - a + a * c, -a * s, -a * c

    def parameter(self, delta: float) -> float:
        """The t at the axial coordinate delta; beyond the arc its end (a quarter turn); of no arc its middle."""
        return 0.0 if self.arc == 0.0 else asin(min(1.0, max(-1.0, (delta - self.centre) / self.arc)))

    def parameters(self, delta: Floats) -> Floats:
        """The t at axial coordinates delta, (...), likewise."""
        return np.asarray(np.arcsin(np.clip((delta - self.centre) / self.arc, -1.0, 1.0)))

    def grown(self, gap: float) -> Arc:
        """The parallel meridian at the normal distance gap, mm."""
        return replace(self, radius=self.radius + gap, arc=self.arc + gap)


Meridian = Straight | Arc


@immutable(eq=True)
class Slide:
    """A translating joint: the coordinate (mm) moves the follower along the unit `direction`, machine frame."""

    direction: Vector

    def carried(self, point: Vector, axis: Vector, coordinate: Floats) -> tuple[Floats, Floats]:
        """Machine-frame jets of a point and an axis direction on the follower, each (order + 1, 3, n)."""
        order, n = len(coordinate) - 1, coordinate.shape[1]
        return slide_jet(np.array(point), np.array(self.direction), coordinate), constant_jet(np.array(axis), order, n)

    def velocity(self, x: Floats, turn: Complexes) -> Floats:
        """Velocity of follower points per unit of the coordinate, cam frame: (3, n, ...) for x (3, n, ...)."""
        e = _turned(np.array(self.direction), turn)
        return np.broadcast_to(e.reshape(3, -1, *([1] * (x.ndim - 2))), x.shape)


@immutable(eq=True)
class Swing:
    """A turning joint: the coordinate (rad) turns the follower about the unit machine-frame `axis` at `centre`."""

    axis: Vector
    centre: Vector

    def carried(self, point: Vector, axis: Vector, coordinate: Floats) -> tuple[Floats, Floats]:
        """Machine-frame jets of a point and an axis direction on the follower, each (order + 1, 3, n)."""
        circle = unit_circle_jet(coordinate)
        spin, centre = np.array(self.axis), np.array(self.centre)
        points = swing_jet(np.array(point) - centre, spin, circle)
        points[0] += centre[:, None]
        return points, swing_jet(np.array(axis), spin, circle)

    def spin(self, rate: Floats, turn: Complexes) -> Floats:
        """Turning of the follower, cam frame, (3, n), at a rate of the coordinate (n,)."""
        return np.asarray(rate * _turned(np.array(self.axis), turn))

    def velocity(self, x: Floats, turn: Complexes) -> Floats:
        """Velocity of follower points per radian of the coordinate, cam frame: axis x (x - centre)."""
        shape = (3, -1, *([1] * (x.ndim - 2)))
        w = _turned(np.array(self.axis), turn).reshape(shape)
        d = x - _turned(np.array(self.centre), turn).reshape(shape)
        return np.stack([w[1] * d[2] - w[2] * d[1], w[2] * d[0] - w[0] * d[2], w[0] * d[1] - w[1] * d[0]])


Joint = Slide | Swing


@immutable(eq=True)
class Relief:
    """A lead-in relief: how far (joint coordinate) a tool turns aside near some cam angles, so that its flank recedes.

    height (1 - x²)^4, x = (phi - end) / width, at every one of `ends`: three derivatives fade with it.

    ends    cam angles in [0, 2 pi), rad; width: rad, on either side
    height  of the joint coordinate, for the flank on the side +1; the other flank recedes the other way
    """

    ends: tuple[float, ...]
    width: float
    height: float

    def jet(self, phi: Floats, order: int) -> Floats:
        """The deviation and its derivatives by the cam angle, (order + 1, n), order up to 3."""
        off = phi[None, :] - np.array(self.ends)[:, None]
        x = (off - TURN * np.round(off / TURN)) / self.width
        q = np.maximum(1.0 - x * x, 0.0)
        shapes = (
            lambda: q**4,
            lambda: -8.0 * x * q**3,
            lambda: q * q * (56.0 * x * x - 8.0),
            lambda: q * x * (144.0 - 336.0 * x * x),
        )
        return np.array([self.height * shapes[k]().sum(axis=0) / self.width**k for k in range(order + 1)])

    def knots(self) -> Floats:
        """Cam angles in [0, 2 pi) where the deviation begins, peaks and ends, rad."""
        ends = np.array(self.ends)
        return np.asarray(np.concatenate([ends - self.width, ends, ends + self.width]) % TURN)


@immutable
class Pose:
    """Jets of the roller axis in the cam frame: fixed point a and unit direction u, each (order + 1, 3, n).

    turn (n,) is exp(-i sense phi), the rotation that brought them here. pace (n,): the jets are by the way of a cam
    that slides, mm, which goes so many mm per rad of the cam angle; None: by the cam angle itself. slid (n,): how far
    it is out, mm, along -X.
    """

    a: Floats
    u: Floats
    turn: Complexes
    pace: Floats | None = None
    slid: Floats | None = None

    def between(self, start: int, stop: int) -> Pose:
        """The pose from one of its cam angles to before another one."""
        pace, slid = (None if values is None else values[start:stop] for values in (self.pace, self.slid))
        return Pose(self.a[..., start:stop], self.u[..., start:stop], self.turn[start:stop], pace, slid)

    def at(self, rows: npt.NDArray[np.intp]) -> Pose:
        """The pose at some of its cam angles."""
        pace, slid = (None if values is None else values[rows] for values in (self.pace, self.slid))
        return Pose(self.a.take(rows, axis=-1), self.u.take(rows, axis=-1), self.turn[rows], pace, slid)

    def per_radian(self, values: Floats) -> Floats:
        """Ways (n, m) along the jets' own coordinate as ways per rad of the cam angle, mm/rad."""
        return values if self.pace is None else values * self.pace[:, None]


@immutable
class Track:
    """One roller driven round the cam.

    meridian   the roller's shape; delta is measured from the anchor along the axis
    anchor     machine-frame point of the roller axis (delta = 0) at joint coordinate zero, mm
    axis       machine-frame unit direction of increasing delta at joint coordinate zero
    tip        delta of the roller's free end (its flat end face), mm
    contact    (delta, delta): the stretch of the roller that touches the flank, mm
    sense      +1 where the cam turns counter-clockwise about Z, -1 clockwise
    shift      added to the program's lift (turret rollers, second roller of a yoke)
    factor     multiplies the program's lift (-1 turns a hand)
    span       cam angles over which the roller cuts, rad; one turn for a closed track
    sides      the flanks it works on: +1 and -1, or one of them (a rib's roller, a disc cam's)
    relief     by which a tool's flanks recede, or None; ease: the side whose relief the poses have, 0 for none
    root       corner radius of a tool's end, mm: of the torus between its side and its flat end
    carriage   of a cam that slides where others turn; its motion is the program. Jets are then by the cam's travel, so
               that a flank has the same sides out and back, and its normal where the cam turns round
    """

    meridian: Meridian
    joint: Joint
    anchor: Vector
    axis: Vector
    tip: float
    contact: tuple[float, float]
    program: Program
    sense: float = 1.0
    shift: float = 0.0
    factor: float = 1.0
    span: tuple[float, float] = (0.0, TURN)
    name: str = "groove"
    sides: tuple[float, ...] = (1.0, -1.0)
    relief: Relief | None = None
    ease: float = 0.0
    root: float = 0.0
    carriage: Carriage | None = None

    @property
    def closed(self) -> bool:
        """True where the pose repeats after the span, so that the groove closes on itself."""
        turns = (self.span[1] - self.span[0]) / TURN
        there_and_back = self.carriage is None or self.carriage.drive.closed
        return abs(turns - 1.0) < 1e-12 and self.program.closed and there_and_back

    @property
    def upright(self) -> bool:
        """True where the roller's axis is along Z and stays so: nothing turns it."""
        return abs(self.axis[2]) == 1.0 and (isinstance(self.joint, Slide) or abs(self.joint.axis[2]) == 1.0)

    @property
    def tip_sign(self) -> float:
        """+1 where the tip is at the high end of delta, -1 at the low end."""
        return 1.0 if self.tip > 0.5 * (self.contact[0] + self.contact[1]) else -1.0

    @property
    def foot(self) -> float:
        """delta where the flank ends at the free end, mm: at the tip, or where the corner of a rounded tool begins."""
        return self.tip - self.tip_sign * self.root

    @property
    def corner(self) -> Track:
        """The same track with the torus of a tool's corner alone, as thick at the foot as the tool is there.

        Its parameter runs from 0, where the side ends, to tip_sign * pi / 2, where the flat end begins. It goes on
        smoothly from the side of a cylinder alone, which only tools with a corner have.
        """
        radius = float(self.meridian.jet(np.array([self.meridian.parameter(self.foot)]))[3][0])
        return replace(self, meridian=Arc(radius, self.foot, self.root), root=0.0)

    def radii(self, delta: Floats) -> Floats:
        """Radius of the roller at places along its axis (delta), mm, (...) both."""
        return self.meridian.jet(self.meridian.parameters(delta))[3]

    def coordinate(self, phi: Floats, order: int = 2, side: Side = "right") -> Floats:
        """Jet of the joint coordinate (mm or rad) by the cam angle, (order + 1, n)."""
        jet = self.factor * self.program.jet(np.asarray(phi, dtype=float), order, side=side)
        jet[0] += self.shift
        if self.relief is not None and self.ease:
            jet += self.ease * self.relief.jet(np.asarray(phi, dtype=float), order)
        return np.asarray(jet)

    def eased(self, side: float) -> Track:
        """The track whose poses cut one flank: with its relief, where there is one."""
        return self if self.relief is None or self.ease else replace(self, ease=side)

    def pose(self, phi: Floats, order: int = 2, side: Side = "right") -> Pose:
        """Jets of the roller axis in the cam frame at cam angles phi (n,), up to the given order (<= 3)."""
        phi = np.asarray(phi, dtype=float)
        if self.carriage is not None:
            return self._slid(self.carriage, phi, order)
        point, direction = self.joint.carried(self.anchor, self.axis, self.coordinate(phi, order, side))
        turn = np.exp(-1j * self.sense * phi)
        if self.upright:
            return Pose(seen_from_turning(point, turn, self.sense), direction, turn)
        return Pose(seen_from_turning(point, turn, self.sense), seen_from_turning(direction, turn, self.sense), turn)

    def _slid(self, carriage: Carriage, phi: Floats, order: int) -> Pose:
        """The same of a cam that slides along -X, by its travel."""
        travel = carriage.travel(phi)
        point, direction = self.joint.carried(self.anchor, self.axis, carriage.lift(travel, order))
        point[0, 0] += travel
        if order:
            point[1, 0] += 1.0
        return Pose(point, direction, np.ones(len(phi), dtype=np.complex128), carriage.pace(phi), travel)

    def spin(self, phi: Floats, turn: Complexes) -> Floats:
        """Turning of what carries the roller relative to the cam, cam frame, rad per rad of the cam, (3, n)."""
        turning = np.zeros((3, len(phi)))
        if isinstance(self.joint, Swing):
            slid = self.carriage
            jet = self.coordinate(phi, 1) if slid is None else slid.lift(slid.travel(phi), 1)
            turning = self.joint.spin(jet[1], turn)
        if self.carriage is None:
            turning[2] -= self.sense
        return turning

    def knots(self) -> Floats:
        """Cam angles in the span where a derivative of the motion may jump, with both ends of the span, rad."""
        low, high = self.span
        first, last = int(np.floor(low / TURN)) - 1, int(np.ceil(high / TURN)) + 1
        base = np.asarray(self.program.knots)
        if self.relief is not None:
            base = np.concatenate([base, self.relief.knots()])
        every = distinct(np.concatenate([base + TURN * k for k in range(first, last + 1)]))
        width = 1e-12 * max(1.0, high - low)
        inside = every[(every > low + width) & (every < high - width)]
        merged = np.concatenate([[low], inside, [high]])
        keep = np.concatenate([[True], np.diff(merged) > width])
        keep[-1] = True
        return np.asarray(merged[keep])

    @property
    def evenly(self) -> Track:
        """The same path run once and evenly over the turn, of a cam that slides; any other track itself."""
        if self.carriage is None:
            return self
        even = self.carriage.even
        return replace(self, carriage=even, program=even.path)

    @property
    def once(self) -> tuple[float, float]:
        """Cam angles between which it runs over its flank once, rad: its span, or the way out of a cam that slides."""
        return self.span if self.carriage is None else (0.0, self.carriage.turned)

    def once_knots(self) -> Floats:
        """The knots of that stretch, with both its ends, rad."""
        knots, end = self.knots(), self.once[1]
        return knots if self.carriage is None else np.append(knots[knots < end - 1e-12], end)

    def drive_angle(self, phi: float) -> float:
        """The cam angle of a place on that path, rad: on the way out of a cam that slides."""
        if self.carriage is None:
            return phi
        return float(self.carriage.out(np.array([phi * self.carriage.stroke / TURN]))[0])

    def grown(self, gap: float) -> Track:
        """The same track with a roller (cutter) larger by the normal distance gap, mm."""
        return self if gap == 0.0 else replace(self, meridian=self.meridian.grown(gap))

    def straightened(self) -> Track:
        """The same track with a cylinder as wide as the roller's crest, which is all of a crown that a disc meets."""
        meridian = self.meridian
        if not isinstance(meridian, Arc):
            return self
        return replace(self, meridian=Straight(meridian.radius, meridian.centre))


def _turned(vector: Floats, turn: Complexes) -> Floats:
    """A fixed machine-frame vector in the cam frame, (3, n)."""
    z = (vector[0] + 1j * vector[1]) * turn
    return np.stack([z.real, z.imag, np.full(len(turn), vector[2])])


def cone_slope(half_angle: float, tip_sign: float) -> float:
    """dr/ddelta of a cone of the given half angle (rad) that narrows towards the tip."""
    return -tip_sign * tan(half_angle)


# Jets of poses: a point or direction carried by a joint and seen from a turning body, with exact derivatives by the cam
# angle up to order 3. They are component-major, (order + 1, 3, n): derivative order, xyz, cam angle.


def constant_jet(vector: Floats, order: int, n: int) -> Floats:
    """Jet of a vector that does not move, (order + 1, 3, n)."""
    jet = np.zeros((order + 1, 3, n))
    jet[0] = np.asarray(vector, dtype=float)[:, None]
    return jet


def slide_jet(point: Floats, direction: Floats, coordinate: Floats) -> Floats:
    """Jet of a point that slides: point + coordinate * direction.

    coordinate  (order + 1, n) jet of the joint coordinate, mm
    Returns (order + 1, 3, n).
    """
    jet = coordinate[:, None, :] * np.asarray(direction, dtype=float)[None, :, None]
    jet[0] += np.asarray(point, dtype=float)[:, None]
    return np.asarray(jet)


def unit_circle_jet(angle: Floats) -> Complexes:
    """Jet of exp(i angle(phi)), (order + 1, n), by the chain rule (Faà di Bruno), order <= 3."""
    order = len(angle) - 1
    g = np.exp(1j * angle[0])
    jet = np.empty((order + 1, *g.shape), dtype=complex)
    jet[0] = g
    if order >= 1:
        jet[1] = 1j * angle[1] * g
    if order >= 2:
        jet[2] = (1j * angle[2] - angle[1] ** 2) * g
    if order >= 3:
        jet[3] = (1j * angle[3] - 3.0 * angle[1] * angle[2] - 1j * angle[1] ** 3) * g
    return jet


def swing_jet(vector: Floats, axis: Floats, circle: Complexes) -> Floats:
    """Jet of a vector turned about a unit axis by the angle whose circle jet is given.

    circle  (order + 1, n) from `unit_circle_jet`
    Returns (order + 1, 3, n); the component along the axis stays.
    """
    vector, axis = np.asarray(vector, dtype=float), np.asarray(axis, dtype=float)
    along = float(vector @ axis) * axis
    across = vector - along
    (a, b, c), (x, y, z) = axis.tolist(), across.tolist()
    third = np.array([b * z - c * y, c * x - a * z, a * y - b * x])
    jet: Floats = circle.real[:, None, :] * across[:, None]
    jet += circle.imag[:, None, :] * third[:, None]
    jet[0] += along[:, None]
    return jet


def seen_from_turning(jet: Floats, turn: Complexes, sense: float) -> Floats:
    """Jet in a frame that turns by sense * phi about Z: Rz(-sense phi) applied with all its derivatives.

    jet   (order + 1, 3, n) in the fixed frame
    turn  (n,) exp(-i sense phi), computed once per angle by the caller
    In the plane, d/dphi of exp(-i sense phi) z is exp(-i sense phi) (z' - i sense z); Leibniz gives every order.
    """
    order = len(jet) - 1
    z = jet[:, 0] + 1j * jet[:, 1]
    out = np.empty_like(jet)
    spin = -1j * sense
    for k in range(order + 1):
        total = z[k].copy()
        for j in range(k):
            total += comb(k, j) * spin ** (k - j) * z[j]
        total *= turn
        out[k, 0], out[k, 1] = total.real, total.imag
        out[k, 2] = jet[k, 2]
    return out
