"""Contact pressure along the turn and along the roller, contact force and drive torque."""

from __future__ import annotations

from math import degrees, pi
from typing import TYPE_CHECKING

import numpy as np

from camgeom.maths.mesh import Floats
from camgeom.report.content import CAM_ANGLE, Axis, Block, Chart, Column, Limit, Map, Mark, Panel, Series, Table, Text
from camgeom.report.numerals import number
from camgeom.report.sections.motion import zones

if TYPE_CHECKING:
    from camgeom.duty import Duty
    from camgeom.model import Model


PER_PANEL, HAIR = 25, 1e-9


def contact(model: Model) -> tuple[Block, ...]:
    """Lines over the turn, the map over turn and roller, and the hardest contact in numbers."""
    if not model.loaded:
        return ()
    if not bool(np.all(model.duty.contact.sound)):
        return (Text(("The roller undercuts a wall that it loads: no stress can be given. See the checks.",)),)
    return lines(model), pressure_map(model), hardest(model), reversals(model.duty)


def over_turn(duty: Duty, values: Floats) -> tuple[Floats, Floats]:
    """Cam angles (k,), degrees, and a panel quantity (p, n) there, with both limits at every panel edge."""
    panels = duty.force.panels
    share = np.linspace(HAIR, 1.0 - HAIR, PER_PANEL)
    at = panels.edges[:-1, None] + np.diff(panels.edges)[:, None] * share
    return np.degrees(at).ravel(), np.asarray(panels.at(values, at.ravel()))


def lines(model: Model) -> Chart:
    """Force, pressure on both walls and torque along the turn."""
    duty = model.duty
    angle, force = over_turn(duty, duty.normal)
    walls = []
    for name, square in (("wall behind", duty.contact.behind), ("wall ahead", duty.contact.ahead)):
        x, y = over_turn(duty, square)
        if np.any(y > 0.0):
            walls.append(Series(name, x, np.sqrt(np.maximum(y, 0.0))))
    peak = duty.contact.peak()
    material = model.profile.material
    limit = model.profile.limits.contact_pressure_mpa or min(material.cam.contact_limit, material.roller.contact_limit)
    top = float(peak.pressure)
    panels = [
        Panel(
            Axis("Normal force", "N", zero=True), (Series("force", angle, force),), marks=_extremes(duty, duty.normal)
        ),
        Panel(
            Axis("Contact pressure", "MPa", zero=True),
            tuple(walls),
            limits=(Limit(limit, f"limit {number(limit)} MPa"),) if top > 0.5 * limit else (),
            marks=(Mark(degrees(float(peak.theta)), top, f"{number(top)} at {number(degrees(float(peak.theta)))}°"),),
        ),
    ]
    x, torque = over_turn(duty, duty.torque * 1e-3)
    panels.append(
        Panel(
            Axis("Drive torque", "N m", zero=True),
            (Series("torque", x, torque),),
            marks=_extremes(duty, duty.torque, 1e-3),
        )
    )
    kept = tuple(panel for panel in panels if panel.series)
    caption = (
        "Contact at the quoted place along the roller; positive force bears on the wall behind, towards smaller lift"
    )
    return Chart(caption, CAM_ANGLE, kept, zones(model.setup.program))


def _extremes(duty: Duty, values: Floats, factor: float = 1.0) -> tuple[Mark, ...]:
    """The refined largest and smallest value of a panel quantity, where they are not zero."""
    marks = []
    for sign in (1.0, -1.0):
        peak, at = duty.peak_of(sign * values)
        value, angle = sign * factor * peak, degrees(at)
        if sign * value > 1e-9:
            marks.append(Mark(angle, value, f"{number(value)} at {number(angle)}°"))
    return tuple(marks)


def pressure_map(model: Model) -> Map:
    """Peak pressure of the loaded wall over the turn and along the roller; blank where nothing bears."""
    duty = model.duty
    slices = duty.slices
    angle = np.linspace(0.0, 360.0, 361)
    theta = slices.panels.theta.ravel()
    values = np.stack([np.interp(np.radians(angle), theta, row.ravel()) for row in slices.pressure])
    stations = duty.slice_stations
    peak = slices.peak()
    worst = int(np.argmax(peak.pressure))
    top, at = float(peak.pressure[worst]), degrees(float(peak.theta[worst]))
    blank = np.where(values > 1e-3 * top, values, np.nan)
    marks = (Mark(at, float(stations[worst]), f"{number(top)} MPa"),)
    along = Axis("Along the roller axis", "mm")
    return Map(
        "Contact pressure over the turn and along the roller", CAM_ANGLE, along, Axis("Contact pressure", "MPa"),
        angle, stations, blank, marks=marks,
    )  # fmt: skip


def hardest(model: Model) -> Table:
    """The hardest contact and the drive in numbers."""
    duty = model.duty
    one = duty.peak_contact
    force, force_at = duty.peak_of(np.abs(duty.normal))
    torque, torque_at = duty.peak_of(duty.torque)
    peak = duty.contact.peak()
    slices = duty.slices.peak()
    worst = int(np.argmax(slices.pressure))
    rows: list[tuple[str, float, str, float | None]] = [
        ("Peak contact pressure, quoted place", float(peak.pressure), "MPa", degrees(float(peak.theta))),
        (
            "Peak contact pressure, worst slice",
            float(slices.pressure[worst]),
            "MPa",
            degrees(float(slices.theta[worst])),
        ),
        ("Peak contact force", force, "N", degrees(force_at)),
        ("Half width of the contact", float(one.half_width), "mm", None),
        ("Largest shear stress under the surface", float(one.shear), "MPa", None),
        ("Depth of the largest shear stress", float(one.shear_depth), "mm", None),
        ("Peak drive torque", 1e-3 * torque, "N m", degrees(torque_at)),
        (
            "Mean drive torque",
            _unless_rounding(1e-3 * float(duty.force.work()) / (2.0 * pi), 1e-3 * torque),
            "N m",
            None,
        ),
    ]
    columns = (Column("Quantity"), Column("Value"), Column("Unit"), Column("Cam angle", "°"))
    return Table("Contact and drive", columns, tuple(rows))


def _unless_rounding(value: float, scale: float) -> float:
    """The value, or 0 where it is rounding against `scale`."""
    return value if abs(value) > 1e-12 * abs(scale) else 0.0


def reversals(duty: Duty) -> Text:
    """Where the roller changes from one wall to the other."""
    found = duty.force.reversals()[0]
    if not found:
        return Text(("The roller bears on one wall all round.",))
    places = ", ".join(f"{number(degrees(change.taken))}°" for change in found)
    return Text((f"The roller changes walls at cam angle {places}; there its clearance is taken up.",))
