"""A turret under load: torque shared among the rollers, contact pressure over turn and roller, lives."""

from __future__ import annotations

from math import degrees, isfinite
from typing import TYPE_CHECKING

import numpy as np

from camgeom.drawing.content import CAM_ANGLE, Axis, Block, Cell, Chart, Column, Map, Mark, Panel, Series, Table, Text
from camgeom.drawing.numerals import number
from camgeom.maths import Floats
from camgeom.report.sections.lines import mark, pressure_limit
from camgeom.report.sections.motion import zones

if TYPE_CHECKING:
    from camgeom.mechanics.turret_duty import TurretDuty
    from camgeom.model import Model

FEW = 4
"""rollers that get a line style and a name of their own"""
_FIGURES = (
    ("peak_pressure_mpa", "Peak contact pressure, middle of the roller", "MPa", "cam_angle_deg"),
    ("peak_slice_pressure_mpa", "Peak contact pressure, worst slice", "MPa", "peak_slice_cam_angle_deg"),
    ("peak_slice_delta_mm", "Place of the worst slice along the roller axis", "mm", ""),
    ("half_width_mm", "Half width of the contact", "mm", ""),
    ("peak_shear_mpa", "Largest shear stress under the surface", "MPa", ""),
    ("shear_depth_mm", "Depth of the largest shear stress", "mm", ""),
    ("preload_pressure_mpa", "Contact pressure of the preload in the dwell", "MPa", ""),
    ("peak_force_n", "Largest force on a roller", "N", ""),
    ("allowable_force_n", "Force that the contact limit allows there", "N", ""),
    ("peak_turret_torque_n_m", "Peak torque on the turret", "N m", ""),
    ("peak_torque_n_m", "Peak torque of the camshaft", "N m", "peak_torque_at_deg"),
    ("mean_torque_n_m", "Mean torque of the camshaft", "N m", ""),
    ("stud_stress_mpa", "Equivalent stress in the roller's stud", "MPa", ""),
    ("shaft_stress_mpa", "Equivalent stress in the camshaft", "MPa", ""),
)


def contact(model: Model) -> tuple[Block, ...]:
    """Torque, load of every roller, how many share it, pressure over the turn and along the roller, and the numbers."""
    duty = model.turret_duty
    if not len(duty.loaded):
        return (Text(("No torque acts on the turret: there is no load to share.",)),)
    return lines(model, duty), pressure_map(duty), figures(duty), supports(duty)


def lines(model: Model, duty: TurretDuty) -> Chart:
    """Turret torque, load on every roller, rollers in contact, largest pressure and camshaft torque over the turn."""
    angle = np.degrees(duty.theta)
    hardest = duty.pressure.max(axis=(1, 2))
    worst, top = degrees(duty.worst()[0]), duty.peak_pressure
    shaft = 1e-3 * duty.input_torque
    panels = (
        Panel(Axis("Torque on the turret", "N m", zero=True), (_line("torque", angle, 1e-3 * duty.torque),),
              marks=_largest(angle, 1e-3 * duty.torque)),
        Panel(Axis("Force on a roller", "N", zero=True), _rollers(angle, duty.roller_load),
              marks=_largest(angle, duty.roller_load.max(axis=1))),
        Panel(Axis("Rollers that share the load", "", zero=True), (_sharing(angle, duty.roller_load),), height=0.6),
        Panel(Axis("Contact pressure", "MPa", zero=True), (_line("largest of all slices", angle, hardest),),
              limits=pressure_limit(model, top), marks=(mark(worst, top),)),
        Panel(Axis("Camshaft torque", "N m", zero=True), (_line("torque", angle, shaft),),
              marks=_largest(angle, shaft)),
    )  # fmt: skip
    caption = "The turret under load: rollers share its torque by the stiffness of their contacts"
    return Chart(caption, CAM_ANGLE, panels, zones(model.setup.program))


def _line(name: str, angle: Floats, values: Floats) -> Series:
    return Series(name, angle, np.asarray(values))


def _largest(angle: Floats, values: Floats) -> tuple[Mark, ...]:
    """The largest value and, where it is negative, the least; samples lie dense enough for a picture."""
    i, j = int(np.argmax(values)), int(np.argmin(values))
    ends = [i] + ([j] if values[j] < -1e-3 * abs(values[i]) else [])
    return tuple(mark(float(angle[k]), float(values[k])) for k in ends if values[k] != 0.0)


def _rollers(angle: Floats, load: Floats) -> tuple[Series, ...]:
    """A line for every roller that bears anything, in the order in which they take the load."""
    some = [k for k in range(load.shape[1]) if load[:, k].max() > 0.0]
    some.sort(key=lambda k: int(np.argmax(load[:, k] > 0.0)))
    if len(some) <= FEW:
        return tuple(Series(f"roller {n}", angle, load[:, k]) for n, k in enumerate(some, start=1))
    return tuple(Series("each roller", angle, load[:, k], 0) for k in some)


def _sharing(angle: Floats, load: Floats) -> Series:
    """Number of loaded rollers as steps."""
    count = (load > 0.0).sum(axis=1).astype(float)
    at = np.flatnonzero(np.diff(count)) + 1
    middle = 0.5 * (angle[at - 1] + angle[at])
    x = np.concatenate([[angle[0]], np.repeat(middle, 2), [angle[-1]]])
    y = np.concatenate([[count[0]], np.column_stack([count[at - 1], count[at]]).ravel(), [count[-1]]])
    return Series("rollers", x, y)


def pressure_map(duty: TurretDuty) -> Map:
    """Largest pressure of all rollers over the turn and along them; blank where nothing bears."""
    angle = np.linspace(0.0, 360.0, 361)
    delta = duty.tracks[0].meridian.jet(duty.engagement.stations)[0]
    hardest = duty.pressure.max(axis=1)[:, np.argsort(delta)]
    nearest = np.clip(np.searchsorted(duty.theta, np.radians(angle)), 1, len(duty.theta) - 1)
    before = np.abs(duty.theta[nearest - 1] - np.radians(angle)) < np.abs(duty.theta[nearest] - np.radians(angle))
    values = hardest[np.where(before, nearest - 1, nearest)].T
    top = duty.peak_pressure
    worst, place = duty.worst()
    marks = (Mark(degrees(worst), place, f"{number(top)} MPa"),)
    along, value = Axis("Along the roller axis", "mm"), Axis("Contact pressure", "MPa")
    caption = "Contact pressure over the turn and along the rollers, the hardest pressed of them"
    return Map(
        caption, CAM_ANGLE, along, value, angle, np.sort(delta), np.where(values > 1e-3 * top, values, np.nan),
        marks=marks,
    )  # fmt: skip


def figures(duty: TurretDuty) -> Table:
    """The hardest contact, the torques and what carries the parts, in numbers."""
    data = duty.contact_data()
    rows: list[tuple[Cell, ...]] = []
    for key, label, unit, at in _FIGURES:
        if key in data and not (key == "preload_pressure_mpa" and data[key] == 0.0):
            value = 0.0 if key.startswith("mean") and abs(data[key]) < 1e-9 else data[key]
            rows.append((label, value, unit, data[at] % 360.0 if at else None))
    least, most = data["rollers_sharing_least"], data["rollers_sharing_most"]
    rows.append(("Rollers that share the load", f"{least} to {most}" if most > least else str(most), "", None))
    columns = (Column("Quantity"), Column("Value"), Column("Unit"), Column("Cam angle", "°"))
    return Table("Contact and drive", columns, tuple(rows))


def supports(duty: TurretDuty) -> Text:
    """What the stresses of stud and shaft assume."""
    data = duty.contact_data()
    text = f"The stud is taken as {number(data['stud_diameter_mm'])} mm thick, half the roller"
    if "shaft_bearing_distance_mm" in data:
        text += f", the camshaft as thick as the bore on bearings {number(data['shaft_bearing_distance_mm'])} mm apart"
    return Text((text + ": replace these by your own.",))


def life(model: Model) -> tuple[Block, ...]:
    """Lives of roller, cam and bearing, and the roller's life along its axis."""
    duty = model.turret_duty
    if not len(duty.loaded):
        return ()
    rows: list[tuple[Cell, ...]] = [
        ("Roller, worst slice", hours(duty.roller_life), "its points take turns in the load from passage to passage"),
        ("Cam surface", hours(duty.cam_life), f"cam angle {number(degrees(duty.worst()[0]))}°"),
    ]
    spec = model.setup.roller
    if spec is not None and spec.dynamic_rating is not None:
        bearing, mean, safety = duty.bearing(spec.dynamic_rating, spec.static_rating)
        static = f", static safety {number(safety)}" if spec.static_rating is not None else ""
        rows.append(("Roller bearing, L10", hours(bearing), f"equivalent load {number(mean)} N{static}"))
    rolled = duty.fatigue_data(None, None)["path_per_turn_m"]
    rows.append(("Path rolled in a turn of the cam", f"{number(rolled)} m", "of a roller, on average"))
    table = Table("Lives", (Column("Part"), Column("Life"), Column("Remark")), tuple(rows))
    along = along_roller(duty)
    return (along, table) if along is not None else (table,)


def along_roller(duty: TurretDuty) -> Chart | None:
    """Roller life over the place along its axis; None where a slice lives for ever."""
    lives = duty.slice_life
    if not np.all(np.isfinite(lives)):
        return None
    x = duty.tracks[0].meridian.jet(duty.engagement.stations)[0]
    order = np.argsort(x)
    worst = int(np.argmin(lives))
    marks = (Mark(float(x[worst]), float(lives[worst]), f"{number(float(lives[worst]))} h"),)
    panel = Panel(Axis("Roller life", "h", zero=True), (Series("life", x[order], lives[order]),), marks=marks)
    return Chart("Life of the roller's slices", Axis("Along the roller axis", "mm"), (panel,))


def hours(value: float) -> str:
    """A life in words."""
    return f"{number(float(value))} h" if isfinite(float(value)) else "unlimited"
