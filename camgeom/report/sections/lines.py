"""Lines over the turn of what is known on panels of the cam angle, and the marks at their extremes."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING

import numpy as np

from camgeom.drawing.content import Limit, Mark
from camgeom.drawing.numerals import number
from camgeom.maths import Floats

if TYPE_CHECKING:
    from camgeom.mechanics.panels import Panels
    from camgeom.model import Model

PER_PANEL, HAIR = 25, 1e-9
NOTHING = 1e-9


def over_turn(panels: Panels, values: Floats) -> tuple[Floats, Floats]:
    """Cam angles (k,), degrees, and a panel quantity (p, n) there, with both limits at every panel edge."""
    share = np.linspace(HAIR, 1.0 - HAIR, PER_PANEL)
    at = panels.edges[:-1, None] + np.diff(panels.edges)[:, None] * share
    return np.degrees(at).ravel(), np.asarray(panels.at(values, at.ravel()))


def extremes(panels: Panels, values: Floats, factor: float = 1.0) -> tuple[Mark, ...]:
    """The refined largest and smallest value of a panel quantity, where they are not zero."""
    from camgeom.mechanics.panels import highest

    marks = []
    for sign in (1.0, -1.0):
        peak, at = (float(found) for found in highest(panels, sign * values))
        value = sign * factor * peak
        if sign * value > NOTHING:
            marks.append(mark(degrees(at), value))
    return tuple(marks)


def mark(angle: float, value: float, unit: str = "") -> Mark:
    """A point at a cam angle, degrees, with its value and angle in words."""
    return Mark(angle, value, f"{number(value)}{unit} at {number(angle)}°")


def pressure_limit(model: Model, top: float) -> tuple[Limit, ...]:
    """The contact limit, MPa, as a line where the largest pressure comes near it; else nothing."""
    material = model.profile.material
    limit = model.profile.limits.contact_pressure_mpa or min(material.cam.contact_limit, material.roller.contact_limit)
    return (Limit(limit, f"limit {number(limit)} MPa"),) if top > 0.5 * limit else ()
