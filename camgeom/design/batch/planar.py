"""Planar cams for many variants at once: discs, constant-width cams and conjugate pairs with what touches them.

Curvature, pressure angle, lever and force do not hang on how far the cam has turned, so that all of it is computed in
the machine's frame: seen from the turning cam a point c has the velocity c' - i sense c. The formulas are those of the
exact model (`track.outline`, `mechanics.load`, `mechanics.hertz`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import pi
from typing import TYPE_CHECKING, final

import numpy as np

from camgeom.cams import sense_of
from camgeom.cams.disc import Disc
from camgeom.design.batch import Batch
from camgeom.design.batch.common import Motion, Points, Variants, motion_of, motion_reason, vertex
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.duty import MILLI
from camgeom.mechanics.hertz import SHEAR_DEPTH, SHEAR_SHARE
from camgeom.mechanics.life import hours
from camgeom.mechanics.load import inertia_force, thrust_share
from camgeom.track.outline import outward_normal, pitch_curvature

if TYPE_CHECKING:
    from camgeom.profile import Profile

CHUNK = 512

GEOMETRY = (
    "flank.max_pressure_angle_deg",
    "flank.min_relative_radius_mm",
    "flank.undercut_margin",
    "flank.min_convex_radius_mm",
    "flank.min_hollow_radius_mm",
    "flank.top_dwell_share",
)
LOADED = (
    "contact.peak_force_n",
    "contact.peak_torque_n_m",
    "contact.mean_torque_n_m",
    "contact.peak_pressure_mpa",
    "contact.half_width_mm",
    "contact.peak_shear_mpa",
    "contact.shear_depth_mm",
    "contact.deepest_shear_mm",
    "contact.peak_slice_pressure_mpa",
    "contact.contact_length_mm",
    "contact.least_contact_length_mm",
    "contact.least_force_n",
    "contact.preload_needed",
    "fatigue.cam_life_h",
    "fatigue.cam_slice_life_h",
    "fatigue.path_per_turn_m",
)


def supports(profile: Profile, varied: Sequence[str]) -> str | None:
    """None where these keys of this profile are carried, else why not."""
    cam, follower, roller = profile.cam, profile.follower, profile.roller
    if profile.kind != "disc" or follower.kind != "translating" or follower.face != "roller":
        return "the batch carries discs with a translating roller so far"
    if getattr(cam, "form", "") == "groove" or (roller is not None and roller.shape != "cylinder"):
        return "the batch carries external profiles with cylindrical rollers so far"
    if profile.operation is not None and profile.operation.force:
        return "[[operation.force]] is not carried so far"
    return motion_reason(profile, varied)


def offered(profile: Profile) -> tuple[str, ...]:
    """Names of the figures that are given for this profile."""
    unit = "deg" if profile.rotating else "mm"
    orders = (("velocity", "rad"), ("acceleration", "rad2"), ("jerk", "rad3"))
    motion = [f"motion.stroke_{unit}", *(f"motion.peak_{word}_{unit}_per_{per}" for word, per in orders)]
    if profile.operation is None:
        return (*motion, *GEOMETRY)
    timed = (("velocity", "s"), ("acceleration", "s2"), ("jerk", "s3"))
    motion += [f"motion.peak_{word}_{unit}_per_{per}" for word, per in timed]
    return (*motion, *GEOMETRY, *LOADED)


def kernel(profile: Profile, columns: Mapping[str, Floats], figures: Sequence[str]) -> Batch:
    """The figures of one chunk of variants."""
    cams = Cams(Variants(profile, columns))
    found = {name: cams.variants.full(cams.figure(name)) for name in figures}
    return cams.variants.refusals.batch(found)


@final
class Seen:
    """A roller on a slide at samples of the motion; each (P, n) or (2, P, n)."""

    def __init__(self, cams: Cams, points: Points) -> None:
        self.cams, self.points = cams, points

    @cached_property
    def centre(self) -> Floats:
        """The roller's centre, machine frame, mm."""
        cams, p = self.cams, self.points
        return np.stack(np.broadcast_arrays(cams.start + p.s, cams.offset))

    @cached_property
    def d(self) -> Floats:
        """Its velocity seen from the turning cam, mm/rad."""
        x, y = self.centre
        return np.stack([self.points.ds + self.cams.sense * y, -self.cams.sense * x])

    @cached_property
    def pace(self) -> Floats:
        """The size of that."""
        return np.asarray(np.sqrt(self.d[0] ** 2 + self.d[1] ** 2))

    @cached_property
    def bend(self) -> Floats:
        """Curvature of the pitch curve, 1/mm, convex positive."""
        x, y = self.centre
        dd = np.stack([self.points.dds - x, -2.0 * self.cams.sense * self.points.ds - y])
        return pitch_curvature(self.d, dd, self.pace, self.cams.sense)

    @cached_property
    def normal(self) -> Floats:
        """Outward normal."""
        return outward_normal(self.d, self.pace, self.cams.sense)

    @cached_property
    def lever(self) -> Floats:
        """Cosine of the pressure angle: the normal's part along the motion."""
        return np.asarray(self.normal[0])

    @cached_property
    def tangent(self) -> Floats:
        """Size of the pressure angle's tangent."""
        return np.asarray(np.abs(self.normal[1]) / self.lever)

    @cached_property
    def force(self) -> Floats:
        """What the follower needs, N."""
        load, p = self.cams, self.points
        inertia = inertia_force(load.mass, load.omega, p.dds, False)
        return load.friction * p.side + inertia + load.preload + load.rate * p.s + load.weight

    @cached_property
    def given(self) -> Floats:
        """What the cam gives along the motion, N, with the friction of the guides: it pushes one way."""
        pushed = np.maximum(self.force, 0.0)
        if self.cams.guide is None:
            return pushed
        share = thrust_share(pushed, self.lever, self.cams.guide, self.points.side)
        return self.lever * pushed / np.where(share > 0.0, share, 1.0)

    @cached_property
    def torque(self) -> Floats:
        """Of the camshaft, N mm."""
        return self.given * self.points.ds

    @cached_property
    def pressing(self) -> Floats:
        """Normal force, N."""
        return self.given / self.lever

    @cached_property
    def relative(self) -> Floats:
        """Relative curvature of cam against roller, 1/mm."""
        growth = 1.0 - self.cams.radius * self.bend
        return 1.0 / (self.cams.radius * np.where(np.abs(growth) > 1e-12, growth, 1e-12))

    @cached_property
    def needed(self) -> Floats:
        """Normal force that the follower needs, N: below zero it would have to be pulled."""
        return self.force / self.lever

    @cached_property
    def spread(self) -> Floats:
        """Square of pressure over relative curvature, MPa² mm²."""
        return self.square / self.relative**2

    @cached_property
    def square(self) -> Floats:
        """Squared peak pressure, MPa²."""
        return self.pressing * self.relative / (self.cams.length * np.pi * self.cams.compliance)


@final
class Cams:
    """A chunk of variants and its facts, each computed when asked."""

    def __init__(self, variants: Variants) -> None:
        self.variants = variants
        v, profile = variants, variants.profile
        assert isinstance(profile.cam, Disc)
        self.sense = sense_of(profile.cam.direction)
        self.motion: Motion = motion_of(v)
        self.radius = 0.5 * v.number("roller.diameter")
        self.offset = v.number("follower.offset")
        prime = v.number("cam.base_radius") + self.radius
        v.refusals.add(np.abs(self.offset) >= prime, "follower.offset: cannot be built")
        self.start = np.sqrt(np.maximum(prime**2 - self.offset**2, 1e-12))
        self.length = np.minimum(v.number("roller.length"), v.number("cam.width"))
        self.all = Seen(self, self.motion.samples)
        if profile.operation is not None:
            self.omega = v.number("operation.speed") * 2.0 * pi / 60.0
            self.mass = v.number("follower.mass") + v.number("operation.load_mass")
            self.friction = v.number("operation.friction")
            self.preload = v.number("operation.spring_preload")
            self.rate = v.number("operation.spring_rate")
            self.weight = self.mass * v.number("operation.gravity")
            guide = v.number("operation.guide_friction")
            self.guide = guide if guide.any() else None
            self.compliance = sum(
                (1.0 - v.number(f"material.{body}.poisson") ** 2) / v.number(f"material.{body}.elastic_modulus")
                for body in ("cam", "roller")
            )
        v.refusals.add(self.margin <= 0.0, "undercut")

    def figure(self, name: str) -> Floats:
        """A figure by its name in a study, (n,) or (1,)."""
        if name.startswith("motion."):
            return self._motion(name)
        return FIGURES[name](self)

    def _motion(self, name: str) -> Floats:
        unit = 180.0 / pi if self.variants.profile.rotating else 1.0
        if name.startswith("motion.stroke"):
            return unit * self.motion.stroke
        order = ("velocity", "acceleration", "jerk").index(name.split("_")[1]) + 1
        peak = unit * self.motion.peaks()[order - 1]
        return peak * self.omega**order if "_per_s" in name else peak

    def largest(self, what: str) -> Floats:
        """The largest of a quantity of `Seen`, refined, (n,)."""
        return self.motion.largest(lambda points: getattr(Seen(self, points), what), getattr(self.all, what))

    def smallest(self, what: str) -> Floats:
        """The smallest."""
        return self.motion.smallest(lambda points: getattr(Seen(self, points), what), getattr(self.all, what))

    @cached_property
    def most_bend(self) -> Floats:
        """Largest curvature of the pitch curve, 1/mm."""
        return self.largest("bend")

    @cached_property
    def margin(self) -> Floats:
        """Undercut margin: the roller's generatrix is straight, so that it is 1 where the pitch curve is hollow."""
        return np.minimum(1.0 - self.radius * self.most_bend, 1.0)

    @cached_property
    def peak(self) -> tuple[Floats, Floats]:
        """Squared largest pressure, MPa², and the relative curvature there, 1/mm."""
        piece, step = self.motion.peak(self.all.square)
        seen = Seen(self, self.motion.around(piece, step))
        at, value = vertex(*seen.square)
        low, mid, high = seen.relative
        return value, mid + at * (0.5 * (high - low) + 0.5 * at * (low - 2.0 * mid + high))

    @cached_property
    def pressure(self) -> Floats:
        """Largest pressure, MPa."""
        return np.sqrt(np.maximum(self.peak[0], 0.0))

    @cached_property
    def mean_torque(self) -> Floats:
        """N mm: the work of friction, guides and springs that do not get all back, over the turn."""
        seen = self.all
        kept = self.variants.full(seen.force.min(axis=0)) >= 0.0
        # Inertia, spring and weight give back what they take, which no sum of samples has to find out.
        lossy = self.friction * seen.points.side + seen.given - np.maximum(seen.force, 0.0)
        least, every = (self.motion.integral(part * seen.points.ds) for part in (lossy, seen.given))
        return np.where(kept, least, every) / (2.0 * pi)

    @cached_property
    def peak_torque(self) -> Floats:
        """Largest size of the torque, N mm, with its sign."""
        high, low = self.largest("torque"), self.smallest("torque")
        return np.where(high >= -low, high, low)

    @cached_property
    def half_width(self) -> Floats:
        """Of the hardest contact, mm."""
        return np.asarray(2.0 * self.pressure * self.compliance / self.peak[1])

    @cached_property
    def deepest_shear(self) -> Floats:
        """Where the largest shear lies deepest, mm."""
        return np.asarray(2.0 * SHEAR_DEPTH * self.compliance * np.sqrt(np.maximum(self.largest("spread"), 0.0)))

    @cached_property
    def cam_life(self) -> Floats:
        """h."""
        v = self.variants
        limit, cycles, power = (
            v.number(f"material.cam.{key}") for key in ("contact_limit", "contact_cycles", "exponent")
        )
        return hours((self.pressure / limit) ** power / cycles, self.omega)


def _hollow(c: Cams) -> Floats:
    """Smallest hollow radius of the profile, mm; infinite where it is nowhere hollow."""
    bend = c.smallest("bend")
    return np.where(bend < 0.0, c.radius - 1.0 / np.where(bend < 0.0, bend, -1.0), np.inf)


def _convex(c: Cams) -> Floats:
    """Smallest convex radius of the profile, mm."""
    bend = c.most_bend
    return np.where(bend > 0.0, 1.0 / np.where(bend > 0.0, bend, 1.0) - c.radius, np.inf)


FIGURES: dict[str, Callable[[Cams], Floats]] = {
    "flank.max_pressure_angle_deg": lambda c: np.degrees(np.arctan(c.largest("tangent"))),
    "flank.min_relative_radius_mm": lambda c: c.radius * (1.0 - c.radius * c.most_bend),
    "flank.undercut_margin": lambda c: c.margin,
    "flank.min_convex_radius_mm": _convex,
    "flank.min_hollow_radius_mm": _hollow,
    "flank.top_dwell_share": lambda c: c.motion.top_share,
    "contact.peak_force_n": lambda c: c.largest("pressing"),
    "contact.peak_torque_n_m": lambda c: np.abs(c.peak_torque) * MILLI,
    "contact.mean_torque_n_m": lambda c: c.mean_torque * MILLI,
    "contact.peak_pressure_mpa": lambda c: c.pressure,
    "contact.half_width_mm": lambda c: c.half_width,
    "contact.peak_shear_mpa": lambda c: c.pressure * SHEAR_SHARE,
    "contact.shear_depth_mm": lambda c: c.half_width * SHEAR_DEPTH,
    "contact.deepest_shear_mm": lambda c: c.deepest_shear,
    "contact.peak_slice_pressure_mpa": lambda c: c.pressure,
    "contact.contact_length_mm": lambda c: c.length,
    "contact.least_contact_length_mm": lambda c: c.length,
    "contact.least_force_n": lambda c: c.smallest("needed"),
    "contact.preload_needed": lambda c: np.maximum(c.preload - c.smallest("force"), 0.0),
    "fatigue.cam_life_h": lambda c: c.cam_life,
    "fatigue.cam_slice_life_h": lambda c: c.cam_life,
    "fatigue.path_per_turn_m": lambda c: c.motion.integral(c.all.pace) * MILLI,
}
