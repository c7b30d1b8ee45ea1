"""The smallest ring of an end-face cam for given limits: its middle radius, with the width that the profile gives."""

from __future__ import annotations

from collections.abc import Mapping
from math import ceil, degrees

import numpy as np

from camgeom.cams.end_face import EndFace
from camgeom.checks import findings, light_checks
from camgeom.design import Choice, Design
from camgeom.design.planar import (
    STEP,
    UNBUILDABLE,
    PlanarLimits,
    asking,
    largest_pressure,
    smallest_radius,
    unit_of,
    wanted_of,
    with_key,
)
from camgeom.errors import DesignError, Problem, ProfileError
from camgeom.model import Model
from camgeom.profile import Profile, parse

SCANNED, LARGEST = 25, 1000.0
"""middle radii that are tried first, and the largest of them, mm"""


def margins(profile: Profile, radius: float, wanted: PlanarLimits) -> dict[str, float]:
    """How far each limit is kept with a middle radius, mm, as a share of it; negative where it is not."""
    cam = _ring(profile, radius)
    model = Model(profile.model_copy(update={"cam": cam}))
    if cam.problems(model.setup):
        return {"what can be built": UNBUILDABLE}
    try:
        found = {"undercut": min(survey.margin.value for survey in model.flanks) - profile.limits.undercut_margin}
        least = profile.limits.min_wall_mm
        found |= {f"wall, {wall.name},": (wall.thickness - least) / radius for wall in model.walls}
        if wanted.pressure_angle_deg is not None and model.pressure_angle is not None:
            found["pressure angle"] = 1.0 - degrees(model.pressure_angle.value) / wanted.pressure_angle_deg
        if wanted.contact_pressure_mpa is not None and found["undercut"] > 0.0:
            found["contact pressure"] = 1.0 - largest_pressure(model) / wanted.contact_pressure_mpa
    except DesignError:
        # The roller dives into a ring so small, or presses it out of all theory.
        return {"what can be built": UNBUILDABLE}
    return found


def _ring(profile: Profile, radius: float) -> EndFace:
    """The cam with a ring of a middle radius, mm, as wide as before."""
    cam = profile.cam
    assert isinstance(cam, EndFace)
    width = 0.5 * (cam.diameter - cam.inner_diameter)
    return cam.model_copy(update={"diameter": 2.0 * radius + width, "inner_diameter": 2.0 * radius - width})


def design(text: str, source: str, limits: Mapping[str, float | None]) -> Design:
    """The profile in the text with the smallest ring that keeps the limits: pressure_angle, deg, contact_pressure, MPa.

    A limit of None is what the profile says. Raises ProfileError where the profile is of another kind or a limit asks
    too much of it, DesignError where no ring keeps the limits.
    """
    profile = parse(text, source)
    cam = profile.cam
    if not isinstance(cam, EndFace):
        raise ProfileError([Problem("cam.kind", "is not the kind to design", profile.kind, "end-face")], source)
    if cam.pitch_radius is not None:
        raise ProfileError([Problem("cam.pitch_radius", "is given, and the ring is sought", cam.pitch_radius, "",
                                    "leave it out: the middle of the contact")], source)  # fmt: skip
    wanted = wanted_of(profile, {**limits, "convex_radius": None})
    low = 0.25 * (cam.diameter - cam.inner_diameter) + 1.0
    radii = np.geomspace(low, LARGEST, SCANNED)
    radius = smallest_radius(lambda middle: margins(profile, middle, wanted), radii, "middle radius of the ring")
    radius = ceil(radius / STEP) * STEP
    kept, ring = margins(profile, radius, wanted), _ring(profile, radius)
    tight = min(kept, key=lambda name: kept[name])
    asked = [
        f"pressure angle {wanted.pressure_angle_deg:g} deg" if wanted.pressure_angle_deg is not None else "",
        f"contact pressure {wanted.contact_pressure_mpa:g} MPa" if wanted.contact_pressure_mpa is not None else "",
    ]
    why = f"the smallest for {', '.join(filter(None, asked)) or 'what can be built'}; {tight} decides"
    choices = []
    for key, value, reason in (("diameter", ring.diameter, why), ("inner_diameter", ring.inner_diameter,
                                                                 "the ring is as wide as before")):  # fmt: skip
        choices.append(Choice(f"cam.{key}", round(value, 6), reason))
        text = with_key(text, "cam", key, round(value, 6) / unit_of(profile))
    text = asking(text, limits)
    return Design(text, tuple(choices), findings(Model(parse(text, source)), light_checks()))
