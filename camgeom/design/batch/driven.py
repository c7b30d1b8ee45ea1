"""Turrets of many variants under load: what acts on them, what that comes to, and which keys no array carries."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from camgeom.design.batch.legs import force_cuts, motion_reason
from camgeom.design.batch.motion import Motion, Points, motion_figures, motion_of
from camgeom.design.batch.variants import Variants, demand_of
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.bearing import stud_stress
from camgeom.mechanics.duty import MILLI
from camgeom.mechanics.life import hours
from camgeom.mechanics.load import QUIET, Demand
from camgeom.mechanics.turret_duty import STUD_SHARE
from camgeom.track.follower import CylinderRoller

if TYPE_CHECKING:
    from camgeom.profile import Profile

LOADED = (
    *motion_figures("deg", "s"),
    "contact.peak_turret_torque_n_m",
    "contact.peak_torque_n_m",
    "contact.mean_torque_n_m",
    "contact.peak_pressure_mpa",
    "contact.peak_slice_pressure_mpa",
    "contact.peak_force_n",
    "contact.stud_diameter_mm",
    "contact.stud_stress_mpa",
    "fatigue.cam_life_h",
)


def refused(profile: Profile, varied: Sequence[str]) -> str | None:
    """Why no kernel of turrets carries these keys of this profile; None where that is for the kernel to say."""
    roller, program = profile.roller, profile.setup().program
    if not isinstance(roller, CylinderRoller):
        return f"roller.shape = {roller.shape if roller else None!r}: the closed forms are those of a cylinder"
    if program.closed:
        return "a drive to and fro: every roller has a groove of its own"
    for key in varied:
        if key in ("follower.stops", "follower.rollers", "cam.plates"):
            return f"{key}: every value makes another turret"
        if key.endswith(".to"):
            return f"{key}: steps by whole indexes"
        if key.startswith("operation.force"):
            return f"{key}: every value makes another force"
        if key.startswith("motion") and profile.operation is not None and profile.operation.force:
            return f"{key}: applied forces stay at their cam angles, elsewhere in every variant's motion"
        if key == "cam.bore" and not getattr(profile.cam, "bore", 0.0):
            return f"{key}: the profile gives none"
    if profile.cutter is not None:
        return "[cutter]: what it says is held against every variant by the exact model"
    lifts = program.jet(np.linspace(0.0, 2.0 * pi, 4097), 1)[1]
    if lifts.min() < -QUIET * lifts.max():
        return "a law that turns back: a roller passes the cam more than once"
    return motion_reason(profile, varied)


def chunk_of(profile: Profile, columns: Mapping[str, Floats]) -> tuple[Variants, Motion]:
    """The variants of a chunk, and their motion, broken where applied forces begin and end."""
    every = Variants(profile, columns)
    forces = profile.operation.force if profile.operation is not None else ()
    return every, motion_of(every, force_cuts(profile), bool(forces))


class Driven(ABC):
    """The turrets of n variants; numbers are (n,) or (1,).

    roller, length  radius of the rollers and length that touches, mm
    """

    variants: Variants
    motion: Motion
    roller: Floats
    length: Floats

    @property
    @abstractmethod
    def square(self) -> Floats:
        """Square of the largest pressure of all slices, MPa²."""

    @property
    @abstractmethod
    def middle(self) -> Floats:
        """The same of the middle slice."""

    @property
    @abstractmethod
    def force(self) -> Floats:
        """Largest force on a roller, N."""

    @cached_property
    def demand(self) -> Demand:
        """What acts on the turret."""
        return demand_of(self.variants)

    @property
    def speed(self) -> Floats:
        """Cam speed, rad/s."""
        return self.demand.speed

    def torque(self, points: Points) -> Floats:
        """Torque that the turret needs, N mm."""
        return self.demand.force(points.theta, (points.s, points.ds, points.dds), points.side)[0]

    @property
    def mean_torque(self) -> Floats:
        """Mean torque of the camshaft, N m: a turn ends with the speed that it began with."""
        d, points = self.demand, self.motion.samples
        lost = (d.friction * points.side + d.preload + d.rate * points.s) * points.ds
        for one in d.applied:
            lost = lost + d.of(one, points.theta, (points.s, points.ds, points.dds)) * points.ds
        return MILLI * self.motion.integral(lost) / (2.0 * pi)

    @cached_property
    def most_torque(self) -> Floats:
        """Largest size of the turret's torque at the samples, N mm."""
        return np.asarray(np.abs(self.torque(self.motion.samples)).max(axis=0))

    @cached_property
    def compliances(self) -> tuple[Floats, Floats]:
        """Of roller and cam, 1/MPa."""
        roller, cam = ((1.0 - self.variants.number(f"material.{body}.poisson") ** 2)
                       / self.variants.number(f"material.{body}.elastic_modulus") for body in ("roller", "cam"))
        return roller, cam

    @cached_property
    def pair(self) -> Floats:
        """Compliance of the two bodies, 1/MPa."""
        return sum(self.compliances)  # type: ignore[return-value]

    @property
    def peak_slice(self) -> Floats:
        """Largest pressure, MPa."""
        return np.sqrt(self.square)

    @property
    def cam_life(self) -> Floats:
        """Fatigue life of the cam's walls, h."""
        limit, cycles, exponent = (
            self.variants.number(f"material.cam.{key}") for key in ("contact_limit", "contact_cycles", "exponent")
        )
        return hours((self.peak_slice / limit) ** exponent / cycles, self.speed)

    def refuse_bore(self) -> None:
        """What is wrong with the keyway."""
        number, refusals = self.variants.number, self.variants.refusals
        width, deep, bore = number("cam.keyway_width"), number("cam.keyway_depth"), number("cam.bore")
        refusals.add((width > 0.0) != (deep > 0.0), "cam.keyway_depth: cannot be built")
        refusals.add((width > 0.0) & (width >= bore), "cam.keyway_width: cannot be built")

    @cached_property
    def bored(self) -> Floats:
        """Largest distance of the bore's outline from the axis, mm; 0 without one."""
        number = self.variants.number
        bore, width, deep = number("cam.bore"), number("cam.keyway_width"), number("cam.keyway_depth")
        return np.asarray(np.where(width > 0.0, np.hypot(0.5 * bore + deep, 0.5 * width), 0.5 * bore))

    def motion_figure(self, name: str) -> Floats:
        """A figure of the motion."""
        return self.motion.figure(name, 180.0 / pi, self.speed if self.variants.profile.operation is not None else 0.0)


LOAD_FIGURES: dict[str, Callable[[Driven], Floats]] = {
    "contact.peak_turret_torque_n_m": lambda i: MILLI * i.motion.largest(lambda p: np.abs(i.torque(p))),
    "contact.peak_torque_n_m": lambda i: MILLI * i.motion.largest(lambda p: np.abs(i.torque(p) * p.ds)),
    "contact.mean_torque_n_m": lambda i: i.mean_torque,
    "contact.peak_pressure_mpa": lambda i: np.sqrt(i.middle),
    "contact.peak_slice_pressure_mpa": lambda i: i.peak_slice,
    "contact.peak_force_n": lambda i: i.force,
    "contact.stud_diameter_mm": lambda i: 2.0 * STUD_SHARE * i.roller,
    "contact.stud_stress_mpa": lambda i: stud_stress(
        i.force, 0.5 * i.length, 2.0 * STUD_SHARE * i.roller).mises,
    "fatigue.cam_life_h": lambda i: i.cam_life,
}
