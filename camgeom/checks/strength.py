"""Contact pressure and life against the limits of the profile."""

from __future__ import annotations

from collections.abc import Iterable
from math import degrees
from typing import TYPE_CHECKING

import numpy as np

from camgeom.checks import Finding, check

if TYPE_CHECKING:
    from camgeom.model import Model


@check("contact-pressure", "tracks", "operation")
def contact_pressure(model: Model) -> Iterable[Finding]:
    """Peak contact pressure over the slices along the roller."""
    material = model.profile.material
    limit = model.profile.limits.contact_pressure_mpa or min(material.cam.contact_limit, material.roller.contact_limit)
    peak = model.duty.slices.peak()
    worst = int(np.argmax(peak.pressure))
    value = float(peak.pressure[worst])
    advice = "" if value <= limit else "use a longer or larger roller, a larger cam, less mass or speed"
    where = f"slice at {model.duty.slice_stations[worst]:.6g} mm along the roller axis"
    angle = float(degrees(peak.theta[worst])) % 360.0
    yield Finding("contact-pressure", value, limit, "MPa", value <= limit, angle, advice, where)


@check("life", "tracks", "operation")
def life(model: Model) -> Iterable[Finding]:
    """Fatigue life of roller and cam, and of the roller's bearing where its rating is given."""
    limit = model.profile.limits.life_h
    if limit is None:
        return
    lives = {"roller": float(model.duty.roller_life.life_h), "cam": float(model.duty.cam_life.life_h)}
    roller = model.setup.roller
    if roller is not None and roller.dynamic_rating is not None:
        lives["bearing"] = float(model.duty.bearing(roller.dynamic_rating, roller.static_rating).life_h)
    for name, value in lives.items():
        shown = value if np.isfinite(value) else 1e30
        advice = "" if value >= limit else "lower the contact pressure: longer or larger roller, larger cam, less speed"
        yield Finding("life", shown, limit, "h", value >= limit, None, advice, name)
