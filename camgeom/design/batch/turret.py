"""Indexing cams with grooves and cylindrical rollers: figures of many variants of a globoid or a barrel at once.

The roller's axis sweeps the pitch surface of which the flanks are offsets. With tau the roller's angle from the line of
centres, tau' and tau'' by the cam angle, and delta the place along the roller axis, its forms are known in closed form,
the same for both hands and senses (a mirror image):

    globoid  R = C - delta cos tau, E = R² + (delta tau')², M = C tau' / sqrt E,
             2H = [delta tau'' R - sin tau (R² + 2 delta² tau'²)] / (E sqrt E), lever = R delta / sqrt E
    barrel   a = y' - delta, b = z', D = a² + b² with y = C - rf cos tau, z = rf sin tau; M = b / sqrt D,
             2H = [a z'' - b (y'' + y)] / (D sqrt D), lever = rf |cos tau| delta / sqrt D

K = -M²/E (M²/D). Arrays are (P, n), P samples of the cam angle and n variants, or (k, P, n) with a row for each place
that a roller takes beside the cam.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import pi
from typing import TYPE_CHECKING, final

import numpy as np

from camgeom.cams._turret import TurretKeys
from camgeom.design.batch.driven import LOAD_FIGURES, LOADED, chunk_of, refused
from camgeom.design.batch.indexer import Ends, Indexer, Line, Seat
from camgeom.design.batch.motion import motion_figures
from camgeom.design.batch.variants import Batch
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property

if TYPE_CHECKING:
    from camgeom.profile import Profile

CHUNK = 1536

GEOMETRY = (
    "motion.stroke_deg",
    *motion_figures("deg", "rad"),
    "flank.max_pressure_angle_deg",
    "flank.max_axis_pressure_angle_deg",
    "flank.pitch_radius_mm",
    "flank.pitch_pressure_angle_deg",
    "flank.undercut_margin",
    "flank.min_relative_radius_mm",
    "checks.relative-curvature",
)


def offered(profile: Profile) -> tuple[str, ...]:
    """Names of the figures that the batch gives."""
    return GEOMETRY + (LOADED if profile.operation is not None else ())


def supports(profile: Profile, varied: Sequence[str]) -> str | None:
    """None where the closed forms hold; else why not."""
    cam = profile.cam
    assert isinstance(cam, TurretKeys)
    for key in ("relief", "preload", "hub_diameter", "hub_length", "root_radius"):
        if f"cam.{key}" in varied or getattr(cam, key, None):
            return f"cam.{key}: rollers that are pressed or relieved, hubs and rounded roots are for the exact model"
    return refused(profile, varied)


def kernel(profile: Profile, columns: Mapping[str, Floats], figures: Sequence[str], level: float) -> Batch:
    """The figures of one chunk of variants."""
    every, motion = chunk_of(profile, columns)
    with np.errstate(all="ignore"):
        cam = KINDS[profile.kind](every, motion, figures, level)
        cam.refuse()
        rows = np.flatnonzero(every.refusals.none)
        if not rows.size:
            return every.refusals.scattered(None, figures)
        if rows.size < every.size:
            cam = cam.of(rows)
        variants = cam.variants
        values = {name: variants.full(_figure(cam, name)) for name in figures}
        variants.refusals.add(cam.margin <= 0.0, "undercut")
        if cam.asked:
            variants.refusals.add(cam.pressed.lost, "no roller can take the turret's torque")
    rest = variants.refusals.batch(values)
    return rest if cam.variants is every else every.refusals.scattered(rest, figures)


def _figure(cam: Indexer, name: str) -> Floats:
    """One of the figures, (n,) or (1,)."""
    if name.startswith("motion."):
        return cam.motion_figure(name)
    return LOAD_FIGURES[name](cam) if name in LOAD_FIGURES else FIGURES[name](cam)


@final
class Globoid(Indexer):
    """Globoidal cams."""

    pushing, mirrored = -1.0, True

    def contact(self) -> tuple[Floats, Floats]:
        """About the pitch radius."""
        return self.circle - 0.5 * self.length, self.circle + 0.5 * self.length

    @property
    def quoted(self) -> Floats:
        """The pitch radius."""
        return self.circle

    @cached_property
    def outside(self) -> Floats:
        """Radius of the blank's outside about the turret axis, mm."""
        return self.variants.number("cam.globoid_radius")

    @cached_property
    def floor(self) -> Floats:
        """Distance of the floor's edges from the turret axis, mm."""
        tool = self.cutter
        return np.sqrt(self.high**2 + 2.0 * tool * tool) + self.variants.number("cam.tip_clearance")

    @property
    def wall(self) -> tuple[Floats, Floats]:
        """From the roller's inner end to the floor."""
        return self.low, self.floor

    @cached_property
    def clear(self) -> Floats:
        """See `solid.blank.Globoid.clear_angle`."""
        top = 0.95 * self.outside
        size = np.hypot(top, self.cutter)
        angle = np.arcsin(np.minimum(0.5 * self.width / size, 1.0)) + np.arctan2(self.cutter, top)
        return np.where((0.5 * self.width < size) & (angle < 0.5 * pi), 1.02 * angle + 0.01, 0.5 * pi)

    def refuse(self) -> None:
        """As `Globoidal.problems`."""
        self.refuse_bore()
        refusals, cannot = self.variants.refusals, "cannot be built"
        diameter = 2.0 * self.roller
        refusals.add(self.circle >= self.centre, f"follower.pitch_radius: {cannot}")
        refusals.add(self.outside >= self.centre, f"cam.globoid_radius: {cannot}")
        refusals.add(0.5 * self.width >= self.outside, f"cam.width: {cannot}")
        floor = self.centre - self.floor
        refusals.add(floor <= 0.0, f"follower.pitch_radius: {cannot}")
        refusals.add((self.bored > 0.0) & (self.bored >= floor), f"cam.bore: {cannot}")
        within = (self.low - 1e-9 <= self.outside) & (self.outside < self.high)
        refusals.add(~within, f"cam.globoid_radius: {cannot}")
        half = 0.5 * self.pitch
        refusals.add(2.0 * self.low * np.sin(half) <= diameter, f"roller.diameter: {cannot}")
        refusals.add(self.roller * np.cos(half) >= self.outside * np.sin(half), f"roller.diameter: {cannot}")
        if self.base:
            rib = 2.0 * (self.outside * np.sin(half) - self.roller * np.cos(half))
            refusals.add(self.width <= rib, f"cam.width: {cannot}")

    def kept(self, cos: Floats, sin: Floats, one: Floats, two: Floats) -> tuple[Floats, ...]:
        """Nothing."""
        return ()

    def lever(self, seat: Seat, delta: Floats) -> Floats:
        """See the head of this file."""
        away, swept = self.centre - delta * seat.cos, delta * seat.one
        return np.asarray(away * delta / np.sqrt(away * away + swept * swept))

    def line(self, seat: Seat, delta: Floats) -> Line:
        """See the head of this file."""
        away = self.centre - delta * seat.cos
        swept = delta * seat.one
        square, forward = away * away, swept * swept
        form = square + forward
        root = np.sqrt(form)
        bend = (delta * seat.two * away - seat.sin * (square + 2.0 * forward)) / (form * root)
        twist = self.centre * seat.one / form
        return Line(bend, twist * twist, away * delta / root)

    def tangent2(self, surface: bool, delta: Floats, seat: Seat, side: Floats | float) -> Floats:
        """tan² at the axis; at the surface (r / delta)² more."""
        tangent = delta * seat.one / (self.centre - delta * seat.cos)
        found = tangent * tangent
        return np.asarray(found + (self.roller / delta) ** 2 if surface else found)

    def _height(self, seat: Seat, r: Floats, delta: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Height z of the contact point, mm; and what its distance rests on: R, delta tau' and r / sqrt E."""
        away, swept = self.centre - delta * seat.cos, delta * seat.one
        form = away * away
        form = form + swept * swept
        arm = r / np.sqrt(form, out=form)
        z = arm * away
        z *= seat.cos
        z += delta * seat.sin
        return z, away, swept, arm

    def _place(self, seat: Seat, r: Floats, delta: Floats) -> tuple[Floats, Floats]:
        """Distance of the contact point from the turret's axis, seen along the cam, and its height z, mm."""
        z, away, swept, arm = self._height(seat, r, delta)
        away *= 1.0 + arm * seat.sin
        away *= away
        swept = np.multiply(swept, arm, out=arm)
        swept *= swept
        away += swept
        rim = self.centre - np.sqrt(away, out=away)
        rim *= rim
        rim += z * z
        return np.sqrt(rim, out=rim), z

    def stretch(self, seat: Seat, side: Floats | float, ends: Ends) -> tuple[Floats, Floats]:
        """From the globoid, or the end faces, to the roller's end: roots of smooth functions by two secant steps."""
        (low, high, r), half, outside = ends, 0.5 * self.width, self.outside
        r = side * r
        (near, z_low), (far, z_high) = (self._place(seat, r, delta) for delta in (low, high))
        wide = high - low

        def root(which: Callable[..., tuple[Floats, ...]], at_low: Floats, at_high: Floats, level: Floats) -> Floats:
            slope = at_high - at_low
            slope /= wide
            slope[np.abs(slope) <= 1e-12] = 1e-12
            x = level - at_low
            x /= slope
            x += low
            np.minimum(np.maximum(x, low, out=x), high, out=x)
            left = np.subtract(level, which(seat, r, x)[0])
            left /= slope
            x += left
            return np.minimum(np.maximum(x, low, out=x), high, out=x)

        begin = np.where(near >= outside, low, root(self._place, near, far, outside))
        stop = np.where(far >= outside, high, low)
        z_begin = self._height(seat, r, begin)[0]
        leaves, comes = np.abs(z_high) > half, np.abs(z_begin) > half
        if np.any(leaves | comes):
            level = np.copysign(half, np.where(leaves, z_high, z_begin))
            edge = root(self._height, z_low, z_high, level)
            stop = np.where(leaves, np.minimum(edge, stop), stop)
            begin = np.where(comes, np.maximum(edge, begin), begin)
            begin = np.where(leaves & comes, stop, begin)
        return begin, np.maximum(stop, begin)


@final
class Barrel(Indexer):
    """Cylindrical indexing cams."""

    pushing, mirrored = 1.0, False

    def contact(self) -> tuple[Floats, Floats]:
        """From the drum's outside inwards."""
        radius = 0.5 * self.variants.number("cam.diameter")
        return radius - self.length, radius

    @property
    def quoted(self) -> Floats:
        """The middle of the contact."""
        return np.asarray(0.5 * (self.low + self.high))

    @cached_property
    def floor(self) -> Floats:
        """Distance of the floor from the cam axis, mm."""
        return np.asarray(self.low - self.variants.number("cam.tip_clearance"))

    @property
    def wall(self) -> tuple[Floats, Floats]:
        """From the floor to the drum's outside."""
        return self.floor, self.high

    @cached_property
    def clear(self) -> Floats:
        """See `CylindricalIndexMechanism`."""
        reach = (0.5 * self.width + self.cutter) / self.circle
        return np.where(reach < 0.95, 1.02 * np.arcsin(np.minimum(reach, 1.0)) + 0.01, 0.5 * pi)

    def refuse(self) -> None:
        """As `CylindricalIndex.problems`."""
        self.refuse_bore()
        refusals, cannot = self.variants.refusals, "cannot be built"
        rim, floor = self.cutter, self.floor
        refusals.add(0.5 * self.width + self.roller >= 0.95 * self.circle, f"cam.width: {cannot}")
        refusals.add(floor <= 0.0, f"roller.length: {cannot}")
        beside = np.minimum(1.0, (0.5 * self.width + rim) / self.circle)
        least, most = self.circle - floor + rim, self.circle * np.sqrt(1.0 - beside * beside) + floor - rim
        refusals.add(least >= most, f"cam.width: {cannot}")
        refusals.add((self.centre <= least) | (self.centre >= most), f"cam.center_distance: {cannot}")
        room = np.sqrt(np.maximum(floor * floor - rim * rim, 0.0))
        refusals.add((self.bored > 0.0) & (self.bored >= room), f"cam.bore: {cannot}")
        refusals.add(2.0 * self.circle * np.sin(0.5 * self.pitch) <= 2.0 * self.roller, f"roller.diameter: {cannot}")

    def kept(self, cos: Floats, sin: Floats, one: Floats, two: Floats) -> tuple[Floats, ...]:
        """y', b, (y'' + y), z'', the arm rf |cos tau|, and b²."""
        rf, square = self.circle, one * one
        along, across = rf * cos, rf * sin
        b = along * one
        y, z = self.centre + along * (square - 1.0) + across * two, along * two - across * square
        return across * one, b, y, z, np.abs(along), b * b

    def lever(self, seat: Seat, delta: Floats) -> Floats:
        """See the head of this file."""
        rate, _, _, _, arm, across = seat.kept
        a = rate - delta
        return np.asarray(arm * delta / np.sqrt(a * a + across))

    def line(self, seat: Seat, delta: Floats) -> Line:
        """See the head of this file."""
        rate, b, y, z, arm, across = seat.kept
        a = rate - delta
        form = a * a + across
        root = np.sqrt(form)
        twist = b / form
        return Line((a * z - b * y) / (form * root), twist * twist, arm * delta / root)

    def tangent2(self, surface: bool, delta: Floats, seat: Seat, side: Floats | float) -> Floats:
        """The contact's arm about the turret along the normal, at a surface by r further on, over that across it."""
        rate, b, _, _, arm, across = seat.kept
        a = rate - delta
        along = (b * seat.cos + a * seat.sin) * self.circle
        if surface:
            along = along + (side * self.roller) * np.sqrt(a * a + across)
        tangent = along / (arm * delta)
        return np.asarray(tangent * tangent)

    def stretch(self, seat: Seat, side: Floats | float, ends: Ends) -> tuple[Floats, Floats]:
        """To the drum's outside, between the end faces: z(delta) is monotone, its root known."""
        (low, high, r), half = ends, 0.5 * self.width
        rate, b, _, _, _, across = seat.kept
        y, z = self.centre - self.circle * seat.cos, self.circle * seat.sin
        outer, r_b = self.high * self.high, (side * r) * b

        def away(delta: Floats) -> tuple[Floats, Floats]:
            a = rate - delta
            form = a * a
            form += across
            return a, np.sqrt(form, out=form)

        stop = high
        for _ in range(3):
            _, beside = away(stop)
            np.subtract(y, np.divide(r_b, beside, out=beside), out=beside)
            beside *= beside
            stop = np.subtract(outer, beside, out=beside)
            stop = np.sqrt(np.maximum(stop, 0.0, out=stop), out=stop)
        stop = np.clip(stop, low, high)

        def height(delta: Floats) -> Floats:
            a, root = away(delta)
            a *= side * r
            a /= root
            a += z
            return a

        z_low, z_stop = height(low), height(stop)
        comes, leaves = np.abs(z_low) > half, np.abs(z_stop) > half
        if not np.any(leaves | comes):
            return np.broadcast_to(low, stop.shape), stop
        arm = np.copysign(half, np.where(leaves, z_stop, z_low))
        arm -= z
        root = arm * arm
        root = np.maximum(np.subtract(r * r, root, out=root), 1e-30, out=root)
        arm *= np.abs(b)
        arm *= side
        arm /= np.sqrt(root, out=root)
        edge = np.clip(np.subtract(rate, arm, out=arm), low, stop)
        begin = np.where(comes, np.where(leaves, stop, edge), low)
        return begin, np.where(leaves, np.maximum(edge, begin), stop)


KINDS: dict[str, type[Globoid] | type[Barrel]] = {"globoidal": Globoid, "cylindrical-index": Barrel}
FIGURES: dict[str, Callable[[Indexer], Floats]] = {
    "flank.max_pressure_angle_deg": lambda i: i.angle("angle"),
    "flank.max_axis_pressure_angle_deg": lambda i: i.angle("axis"),
    "flank.pitch_radius_mm": lambda i: i.quoted,
    "flank.pitch_pressure_angle_deg": lambda i: i.angle("quoted"),
    "flank.undercut_margin": lambda i: i.margin,
    "flank.min_relative_radius_mm": lambda i: np.maximum(-i.largest["convex"], 0.0),
    "checks.relative-curvature": lambda i: 1.0 / i.largest["hollow"],
}
