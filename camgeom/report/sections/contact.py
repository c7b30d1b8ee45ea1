"""Contact pressure along the turn and along the roller, contact force and drive torque."""

from __future__ import annotations

from math import degrees, pi
from typing import TYPE_CHECKING

import numpy as np

from camgeom.drawing.content import CAM_ANGLE, Axis, Block, Chart, Column, Map, Mark, Panel, Series, Table, Text
from camgeom.drawing.numerals import number
from camgeom.maths import Floats
from camgeom.report.sections.lines import extremes, mark, over_turn, pressure_limit
from camgeom.report.sections.motion import zones

if TYPE_CHECKING:
    from camgeom.mechanics.panels import Panels
    from camgeom.mechanics.roller_duty import Duty
    from camgeom.model import Model


def contact(model: Model) -> tuple[Block, ...]:
    """Lines over the turn, the map over turn and roller, and the hardest contact in numbers."""
    if model.turret_loaded:
        from camgeom.report.sections.turret import contact as shared

        return shared(model)
    if model.driven:
        from camgeom.report.sections.planes import contact as touching

        return touching(model)
    if not model.loaded:
        return ()
    return track_contact(model)


def track_contact(model: Model) -> tuple[Block, ...]:
    """The contact of a roller in its groove, on its rib."""
    if not bool(np.all(model.duty.contact.sound)):
        return (Text(("The roller undercuts a wall that it loads: no stress can be given. See the checks.",)),)
    return lines(model), pressure_map(model), hardest(model), reversals(model.duty)


def lines(model: Model) -> Chart:
    """Force, pressure on both walls and torque along the turn."""
    duty = model.duty
    panels = duty.force.panels
    angle, force = over_turn(panels, duty.normal)
    walls = []
    for name, square in (("wall behind", duty.contact.behind), ("wall ahead", duty.contact.ahead)):
        x, y = over_turn(panels, square)
        if np.any(y > 0.0):
            walls.append(Series(name, x, np.sqrt(np.maximum(y, 0.0))))
    peak = duty.contact.peak()
    top = float(peak.pressure)
    shown = [
        Panel(Axis("Normal force", "N", zero=True), (Series("force", angle, force),),
              marks=extremes(panels, duty.normal)),
        Panel(Axis("Contact pressure", "MPa", zero=True), tuple(walls), limits=pressure_limit(model, top),
              marks=(mark(degrees(float(peak.theta)), top),)),
        torque(panels, duty.torque),
    ]  # fmt: skip
    kept = tuple(panel for panel in shown if panel.series)
    caption = (
        "Contact at the quoted place along the roller; positive force bears on the wall behind, towards smaller lift"
    )
    return Chart(caption, CAM_ANGLE, kept, zones(model.setup.program))


def torque(panels: Panels, values: Floats) -> Panel:
    """Torque of the camshaft, N mm on panels, over the turn."""
    x, y = over_turn(panels, values * 1e-3)
    return Panel(
        Axis("Drive torque", "N m", zero=True), (Series("torque", x, y),), marks=extremes(panels, values, 1e-3)
    )


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
    which = f", {duty.track.name}, the harder pressed" if len(model.duties) > 1 else ""
    caption = f"Contact pressure over the turn and along the roller{which}"
    return Map(
        caption, CAM_ANGLE, along, Axis("Contact pressure", "MPa"),
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
    name = f"Contact and drive, roller {duty.track.name}" if len(model.duties) > 1 else "Contact and drive"
    return Table(name, columns, tuple(rows))


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
