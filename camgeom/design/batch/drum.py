"""Groove and rib drums with cylindrical rollers on a slide or on an arm: figures of many variants at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from camgeom.cams.cylindrical import Cylindrical
from camgeom.design.batch.axial import Axial
from camgeom.design.batch.legs import force_cuts, motion_reason
from camgeom.design.batch.motion import motion_figures, motion_of
from camgeom.design.batch.slid import Slid
from camgeom.design.batch.swung import Swung
from camgeom.design.batch.variants import Batch, Variants
from camgeom.maths import Floats
from camgeom.mechanics.hertz import SHEAR_DEPTH, SHEAR_SHARE, TOO_WIDE
from camgeom.track.follower import CylinderRoller

if TYPE_CHECKING:
    from camgeom.profile import Profile

CHUNK = 8192

GEOMETRY = (
    "blank.diameter_mm",
    "blank.length_mm",
    "blank.volume_mm3",
    "flank.max_pressure_angle_deg",
    "flank.max_axis_pressure_angle_deg",
    "flank.pitch_radius_mm",
    "flank.pitch_pressure_angle_deg",
    "flank.undercut_margin",
    "flank.min_relative_radius_mm",
    "checks.relative-curvature",
    "checks.run-out",
    "checks.floor-gap",
)
RIB = "flank.rib_thickness_mm"
LOADED = (
    "contact.peak_pressure_mpa",
    "contact.peak_force_n",
    "contact.peak_torque_n_m",
    "contact.mean_torque_n_m",
    "contact.peak_slice_pressure_mpa",
    "contact.contact_length_mm",
    "contact.half_width_mm",
    "contact.peak_shear_mpa",
    "contact.shear_depth_mm",
    "fatigue.cam_life_h",
    "fatigue.cam_slice_life_h",
)
PRESSED = frozenset(name for name in LOADED if "pressure" in name or "shear" in name or "life" in name
                    or name in ("contact.contact_length_mm", "contact.half_width_mm"))  # fmt: skip
"""figures for which contacts are computed"""


def offered(profile: Profile) -> tuple[str, ...]:
    """Names of the figures that the batch gives."""
    cam = profile.cam
    unit = "deg" if profile.rotating else "mm"
    rib = (RIB,) if isinstance(cam, Cylindrical) and cam.form == "rib" else ()
    moved = (f"motion.stroke_{unit}", *motion_figures(unit, "rad"))
    return (*moved, *GEOMETRY, *rib, *((*motion_figures(unit, "s"), *LOADED) if profile.operation is not None else ()))


def supports(profile: Profile, varied: Sequence[str]) -> str | None:
    """None where the closed forms hold; else why not."""
    cam = profile.cam
    assert isinstance(cam, Cylindrical)
    if cam.run_out:
        return "cam.run_out = true: what presses where is followed through the end face"
    if not isinstance(profile.roller, CylinderRoller):
        shape = profile.roller.shape if profile.roller is not None else None
        return f"roller.shape = {shape!r}: the closed forms are those of a cylinder"
    for table, given in (("cutter", profile.cutter), ("impact", profile.impact)):
        if given is not None:
            return f"[{table}]: what it says is held against every variant by the exact model"
    if found := motion_reason(profile, varied):
        return found
    forced = profile.operation is not None and profile.operation.force
    for key in varied:
        if key.startswith("operation.force"):
            return f"{key}: every value makes another force"
        if forced and key.startswith("motion") and key.endswith("until"):
            return f"{key}: applied forces stay at their cam angles, elsewhere in every variant's motion"
        if (key == "cam.bore" and not cam.bore) or (key == "cam.pitch_radius" and cam.pitch_radius is None):
            return f"{key}: the profile gives none"
    return None


def kernel(profile: Profile, columns: Mapping[str, Floats], figures: Sequence[str], level: float) -> Batch:
    """The figures of one chunk of variants; all of them are smooth, so that none hangs on the level."""
    del level
    variants = Variants(profile, columns)
    motion = motion_of(variants, force_cuts(profile), _rest_under_force(profile))
    drum = (Swung if profile.rotating else Slid)(variants, motion)
    with np.errstate(all="ignore"):
        drum.refuse()
        values = {name: variants.full(_figure(drum, name)) for name in figures}
        variants.refusals.add(drum.margin <= 0.0, "undercut")
        if profile.operation is not None:
            variants.refusals.add(drum.jams, "the follower jams in its guides")
            if not PRESSED.isdisjoint(figures):
                variants.refusals.add(drum.too_wide, TOO_WIDE)
    return variants.refusals.batch(values)


@lru_cache(maxsize=8)
def _rest_under_force(profile: Profile) -> bool:
    """Whether an applied force acts while the follower rests, so that dwells have to be sampled."""
    forces = profile.operation.force if profile.operation is not None else ()
    rests = [span for span in profile.setup().program.spans if span.law == "dwell"]
    for force in (force.applied() for force in forces):
        for span in rests:
            inner = np.linspace(span.start, span.end, 361)[1:-1]
            if np.any(np.mod(inner - force.begin, 2.0 * pi) < force.length):
                return True
    return False


def _figure(drum: Axial, name: str) -> Floats:
    """One of the figures, (n,) or (1,)."""
    if name.startswith("motion."):
        unit = 180.0 / pi if drum.profile.rotating else 1.0
        return drum.motion.figure(name, unit, drum.speed if drum.profile.operation is not None else 0.0)
    return FIGURES[name](drum)


FIGURES: dict[str, Callable[[Axial], Floats]] = {
    "blank.diameter_mm": lambda g: 2.0 * g.radius,
    "blank.length_mm": lambda g: g.variants.number("cam.length"),
    "blank.volume_mm3": lambda g: pi * g.radius**2 * g.variants.number("cam.length"),
    "flank.max_pressure_angle_deg": lambda g: g.steepest,
    "flank.max_axis_pressure_angle_deg": lambda g: g.steepest_axis,
    "flank.pitch_radius_mm": lambda g: g.pitch,
    "flank.pitch_pressure_angle_deg": lambda g: g.steepest_quoted,
    "flank.undercut_margin": lambda g: g.margin,
    RIB: lambda g: g.thickness,
    "flank.min_relative_radius_mm": lambda g: g.least_radius,
    "checks.relative-curvature": lambda g: g.dullest,
    "checks.run-out": lambda g: g.run_out,
    "checks.floor-gap": lambda g: g.low - g.floor,
    "contact.peak_pressure_mpa": lambda g: g.pressure,
    "contact.peak_force_n": lambda g: g.peak_force,
    "contact.peak_torque_n_m": lambda g: g.peak_torque,
    "contact.mean_torque_n_m": lambda g: g.mean_torque,
    "contact.peak_slice_pressure_mpa": lambda g: g.peak_slice,
    "contact.contact_length_mm": lambda g: g.hardest.touching,
    "contact.half_width_mm": lambda g: g.half_width,
    "contact.shear_depth_mm": lambda g: g.half_width * SHEAR_DEPTH,
    "contact.peak_shear_mpa": lambda g: g.hardest.slice * SHEAR_SHARE,
    "fatigue.cam_life_h": lambda g: g.cam_life(g.wearing),
    "fatigue.cam_slice_life_h": lambda g: g.cam_life(g.peak_slice),
}
