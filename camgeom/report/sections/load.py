"""Load of rollers, faces and turrets: force and pressure along turn and roller, torque."""

from __future__ import annotations

from math import degrees, isfinite, pi
from typing import TYPE_CHECKING

import numpy as np

from camgeom.drawing.content import (
    CAM_ANGLE,
    Axis,
    Block,
    Cell,
    Chart,
    Map,
    Mark,
    Panel,
    Series,
    Table,
    Text,
    Zone,
    quantities,
)
from camgeom.drawing.sheet import number
from camgeom.errors import NotConverged
from camgeom.maths import Floats
from camgeom.report.data.load import output_data
from camgeom.report.sections.motion import extremes, mark, over_turn, pressure_limit, zones

if TYPE_CHECKING:
    from camgeom.maths.extremum import Extreme
    from camgeom.maths.panels import Panels
    from camgeom.mechanics.face_duty import FaceDuty
    from camgeom.mechanics.hertz import Beneath
    from camgeom.mechanics.kept import Kept
    from camgeom.mechanics.roller_duty import RollerDuty
    from camgeom.mechanics.slide_drive import SlideDrive
    from camgeom.mechanics.turret_duty import TurretDuty
    from camgeom.model import Model
    from camgeom.model.together import Shaft

PATCH = (160, 81)
"""places along and across the roller of the map of its hardest contact"""
PLACES = 121
"""places along the roller on the map of its pressure"""
FEW = 4
"""rollers that get a line style and a name of their own"""
HALF_SPACE = "solved on a half-space"
_FIGURES = (
    ("inside_pressure_mpa", "Half a millimetre inside the sharp end", "MPa", "cam_angle_deg"),
    ("peak_pressure_mpa", "Peak contact pressure, middle of the roller", "MPa", "cam_angle_deg"),
    ("peak_slice_pressure_mpa", "Peak contact pressure, worst slice", "MPa", "peak_slice_cam_angle_deg"),
    ("peak_slice_delta_mm", "Place of the worst slice along the roller axis", "mm", ""),
    ("contact_length_mm", "Length that touches there", "mm", ""),
    ("least_contact_length_mm", "Least length that touches under load", "mm", "least_contact_length_at_deg"),
    ("load_centre_mm", "The load acts along the roller at", "mm", ""),
    ("approach_mm", "Approach of the bodies", "mm", ""),
    ("tangent_stiffness_n_mm", "Stiffness for small vibration, tangent", "N/mm", ""),
    ("secant_stiffness_n_mm", "Stiffness from no load, secant", "N/mm", ""),
    ("half_width_mm", "Half width of the contact", "mm", ""),
    ("peak_shear_mpa", "Largest shear stress under the surface", "MPa", ""),
    ("shear_depth_mm", "Depth of the largest shear stress", "mm", ""),
    ("deepest_shear_mm", "The same where it lies deepest", "mm", "deepest_shear_at_deg"),
    ("preload_pressure_mpa", "Contact pressure of the preload in the dwell", "MPa", ""),
    ("peak_force_n", "Largest force on a roller", "N", ""),
    ("peak_middle_force_n", "The same in the middle of the contact, as it is judged", "N", ""),
    ("allowable_force_n", "Force that the contact limit allows there", "N", ""),
    ("peak_turret_torque_n_m", "Peak torque on the turret", "N m", ""),
    ("peak_torque_n_m", "Peak torque of the camshaft", "N m", "peak_torque_at_deg"),
    ("mean_torque_n_m", "Mean torque of the camshaft", "N m", ""),
    ("peak_travel_force_n", "Peak force along the travel, for the follower", "N", "peak_travel_force_at_deg"),
    ("peak_drive_force_n", "Peak force of the drive, plate and slide too", "N", "peak_drive_force_at_deg"),
    ("peak_drive_power_w", "Peak power of the drive", "W", ""),
    ("mean_drive_power_w", "Mean power of the drive", "W", ""),
    ("stud_stress_mpa", "Equivalent stress in the roller's stud", "MPa", ""),
    ("shaft_stress_mpa", "Equivalent stress in the camshaft", "MPa", ""),
)


def contact(model: Model) -> tuple[Block, ...]:
    """Lines over the turn, the map over turn and roller, and the hardest contact in numbers, of the hardest state."""
    if model.profile.duty:
        state = model.hardest_state
        name = state.state.name if state.state else ""
        return Text((f"Of the operating state {name!r}, in which the contact is pressed hardest.",)), *contact(state)
    if model.turret_duty is not None:
        return (*turret_contact(model, model.turret_duty), *force_parts(model), *output(model))
    if model.drive is not None:
        return (*touch_contact(model, model.drive), *force_parts(model))
    if not model.duties:
        return ()
    return (*track_contact(model), *force_parts(model))


OUTPUT = (
    ("Largest torque", "torque_n_m", "N m"),
    ("Forces of all rollers, as if they pointed one way", "rollers_force_n", "N"),
    ("Bending moment by them", "bending_n_m", "N m"),
    ("Equivalent stress of the shaft", "stress_mpa", "MPa"),
    ("Preload of a bolt, largest", "preload_n", "N"),
    ("Preload of a bolt, least", "least_preload_n", "N"),
    ("Torque at which the joint slips", "grip_torque_n_m", "N m"),
    ("Torque that shears the bolts", "shear_torque_n_m", "N m"),
    ("Safety against slipping", "slip_safety", "1"),
    ("Safety against shear", "shear_safety", "1"),
)
"""words, key of `output_data`, unit"""


def output(model: Model) -> tuple[Table | Text, ...]:
    """What output shaft and bolts bear; nothing where the profile gives neither."""
    if model.profile.output_shaft_spec is None:
        return ()
    try:
        data = output_data(model)
    except NotConverged as lost:
        return (Text((f"What output shaft and bolts bear is not known: {lost}.",)),)
    rows = [(words, data[key], unit) for words, key, unit in OUTPUT if data.get(key) is not None]
    return (quantities(f"Output shaft and bolts, {data['torque_is']}", rows),)


def track_contact(model: Model) -> tuple[Block, ...]:
    """The contact of a roller in its groove, on its rib."""
    if not _sound(model.duty):
        return (Text(("The roller undercuts a wall that it loads: no stress can be given. See the checks.",)),)
    maps = *pressure_map(model), *patch_map(model)
    return lines(model), *unbounded(model), *maps, hardest(model), reversals(model.duty)


def unbounded(model: Model) -> tuple[Text, ...]:
    """A sentence on a sharp end that bears; nothing where none does."""
    lost = model.duty.no_stress if model.duties else ""
    return (Text((f"No largest pressure: {lost}.",)),) if lost else ()


def _sound(duty: RollerDuty) -> bool:
    """Whether the roller fits the walls that it loads, all along it."""
    return bool(np.all(duty.contact.sound)) and bool(np.all(duty.slices.sound))


def lines(model: Model) -> Chart:
    """Force, pressure on both walls and torque along the turn; of a rib of both its rollers."""
    duty, shaft = model.duty, model.shaft
    assert shaft is not None
    panels, walls = duty.force.panels, []
    normal = np.sum([one.normal for one in model.duties], axis=0)
    angle, force = over_turn(panels, normal)
    for one in model.duties:
        for name, square in (("wall behind", one.contact.behind), ("wall ahead", one.contact.ahead)):
            x, y = over_turn(panels, square)
            if np.any(y > 0.0):
                told = name if len(model.duties) == 1 else one.track.name
                walls.append(Series(told, x, np.sqrt(np.maximum(y, 0.0))))
    peak = duty.contact.peak()
    top = float(peak.pressure)
    shown = [
        Panel(Axis("Normal force", "N", zero=True), (Series("force", angle, force),),
              marks=extremes(panels, normal)),
        Panel(Axis("Contact pressure", "MPa", zero=True), tuple(walls), limits=pressure_limit(model, top),
              marks=(mark(degrees(float(peak.theta)), top),)),
        torque(shaft.panels, shaft.torque) if model.slide_drive is None else drive_force(model.slide_drive),
    ]  # fmt: skip
    caption = (
        "Pressure at the quoted place along the roller; positive force bears on the wall behind, towards smaller lift"
    )
    panels_shown = tuple(panel for panel in shown if panel.series)
    return Chart(caption, CAM_ANGLE, panels_shown, zones(model.setup.program) + unheld_zones(duty.kept))


def torque(panels: Panels, values: Floats) -> Panel:
    """Torque of the camshaft, N mm on panels, over the turn."""
    x, y = over_turn(panels, values * 1e-3)
    return Panel(
        Axis("Drive torque", "N m", zero=True), (Series("torque", x, y),), marks=extremes(panels, values, 1e-3)
    )


def drive_force(drive: SlideDrive) -> Panel:
    """Force of a plate's drive over the turn, N."""
    panels = drive.duty.force.panels
    series = [Series("for the follower", *over_turn(panels, drive.groove))]
    if drive.mass is not None:
        series.append(Series("and for the plate", *over_turn(panels, drive.force)))
    return Panel(Axis("Force along the travel", "N", zero=True), tuple(series), marks=extremes(panels, drive.force))


def pressure_map(model: Model) -> tuple[Map, ...]:
    """Peak pressure of the loaded wall over the turn and along the roller; blank where nothing bears."""
    duty, top = model.duty, model.duty.least_peak
    if top.value == 0.0:
        return ()
    # A pulse may lie between the degrees.
    angle = np.union1d(np.linspace(0.0, 360.0, 361), degrees(top.cam_angle) % 360.0)
    places = np.linspace(min(duty.track.contact), max(duty.track.contact), PLACES)
    values = duty.pressure_at(np.radians(angle), places).T
    blank = np.where(values > 1e-3 * top.value, values, np.nan)
    if not np.isfinite(blank).any():
        return ()
    along = Axis("Along the roller axis", "mm")
    which = f", {duty.track.name}, the harder pressed" if len(model.duties) > 1 else ""
    caption = f"Contact pressure over the turn and along the roller{which}"
    return (Map(
        caption, CAM_ANGLE, along, Axis("Contact pressure", "MPa"),
        angle, places, blank, marks=_hardest_place(top),
    ),)  # fmt: skip


def patch_map(model: Model) -> tuple[Map, ...]:
    """Pressure of the hardest contact over its own surface; nothing of a line, which is alike all along."""
    duty = model.duty
    if duty.level == "line" or duty.least_peak.value == 0.0:
        return ()
    how = "the exact ellipse" if duty.level == "ellipse" else HALF_SPACE
    picture = duty.patch(PATCH)
    if not (picture[2] > 0.0).any():
        return ()
    return (_patch(picture, duty.least_peak, duty.no_stress, how),)


def _patch(picture: tuple[Floats, Floats, Floats], peak: Extreme, lost: str, how: str = HALF_SPACE) -> Map:
    """The map of places along and across, and the pressure there."""
    x, y, values = picture
    values = np.where(values > 0.0, values, np.nan)
    how += ", blank where a sharp end has no largest pressure" if lost else ""
    caption = f"Pressure of the hardest contact at cam angle {number(degrees(peak.cam_angle))}°, {how}"
    marks = (Mark(peak.place, 0.0, f"{number(peak.value)} MPa"),)
    along, across = Axis("Along the roller axis", "mm"), Axis("Across the roller", "mm")
    return Map(caption, along, across, Axis("Contact pressure", "MPa"), x, y, values, marks=marks)


def _hardest_place(peak: Extreme) -> tuple[Mark, ...]:
    """The mark of the largest pressure on a map over the turn and along the roller."""
    return (Mark(degrees(peak.cam_angle), peak.place, f"{number(peak.value)} MPa"),)


def _torques(shaft: Shaft) -> list[tuple[Cell, ...]]:
    torque = shaft.peak_torque
    return [
        ("Peak drive torque", 1e-3 * torque.value, "N m", degrees(torque.cam_angle)),
        ("Mean drive torque", 1e-3 * _unless_rounding(shaft.work / (2.0 * pi), torque.value), "N m", None),
    ]


def _drive(drive: SlideDrive) -> list[tuple[Cell, ...]]:
    """What the drive of a plate gives: for the follower, and for plate and slide where their mass is known."""
    rows: list[tuple[Cell, ...]] = [
        ("Peak force along the travel, for the follower", drive.peak_groove.value, "N",
         _turned(drive.peak_groove)),
    ]  # fmt: skip
    if drive.mass is not None:
        rows += [
            ("Peak force of the drive, plate and slide too", drive.peak.value, "N", _turned(drive.peak)),
            ("Peak power of the drive", 1e-3 * drive.peak_power.value, "W", _turned(drive.peak_power)),
        ]
    return rows


def _turned(peak: Extreme) -> float:
    """The drive's angle, deg, without what rounding leaves where it turns."""
    return round(degrees(peak.cam_angle), 9)


def hardest(model: Model) -> Table:
    """The hardest contact and the drive in numbers."""
    duty, shaft = model.duty, model.shaft
    assert shaft is not None
    assert model.peak_force is not None
    beneath = duty.peak_contact
    force = model.peak_force
    peak, slices, shortest = duty.contact.peak(), duty.least_peak, duty.least_touching
    worst = "Half a millimetre inside the sharp end" if duty.no_stress else "Peak contact pressure, worst slice"
    quoted = ("Peak contact pressure, quoted place", float(peak.pressure), "MPa", degrees(float(peak.theta)))
    rows: list[tuple[Cell, ...]] = [
        *((quoted,) if duty.finite is None else ()),
        (worst, slices.value, "MPa", degrees(slices.cam_angle)),
        ("Length that touches there", duty.contact_length, "mm", degrees(slices.cam_angle)),
        ("Least length that touches under load", shortest.value, "mm", degrees(shortest.cam_angle)),
        ("Peak contact force", force.value, "N", degrees(force.cam_angle)),
        *_beneath(beneath, duty.deepest_shear),
        *(_torques(shaft) if model.slide_drive is None else _drive(model.slide_drive)),
    ]
    if duty.crowned is not None and not duty.no_stress:
        line = duty.pressing.as_line.peak()
        rows[1:1] = [
            ("Pressure without the crown, as a line", float(line.pressure), "MPa", degrees(float(line.theta))),
            ("Largest half-length of the contact ellipse", duty.crowned.longest, "mm", None),
        ]
    if duty.finite is not None:
        patch, stiff = duty.finite.hardest[1], duty.stiffness
        rows[1:1] = [
            ("The load acts along the roller at", float(np.mean(duty.track.contact)) + patch.centre, "mm", None),
            ("Approach of the bodies", patch.approach, "mm", None),
            ("Stiffness for small vibration, tangent", stiff.tangent, "N/mm", None),
            ("Stiffness from no load, secant", stiff.secant, "N/mm", None),
        ]
        if not duty.no_stress:
            rows.insert(1, ("Error of the largest pressure, from a grid half as fine", 100.0 * patch.error, "%", None))
    name = f"Contact and drive, roller {duty.track.name}" if len(model.duties) > 1 else "Contact and drive"
    return quantities(name, [*rows, *kept_rows(duty.kept)])


def _beneath(beneath: Beneath | None, deepest: Extreme | None) -> list[tuple[Cell, ...]]:
    """Width and subsurface shear of the hardest contact, and where that shear lies deepest, in numbers."""
    if beneath is None or deepest is None:
        return []
    return [
        ("Half width of the hardest contact", beneath.half_width, "mm", None),
        ("Largest shear stress under it", beneath.shear, "MPa", None),
        ("Depth of the largest shear stress", beneath.shear_depth, "mm", None),
        ("The same where it lies deepest", deepest.value, "mm", degrees(deepest.cam_angle) % 360.0),
    ]


def _unless_rounding(value: float, scale: float) -> float:
    """The value, or 0 where it is rounding against `scale`."""
    return value if abs(value) > 1e-12 * abs(scale) else 0.0


def reversals(duty: RollerDuty) -> Text:
    """Where the roller changes from one wall to the other."""
    found = duty.force.reversals()[0]
    if not found:
        return Text(("The roller bears on one wall all round.",))
    places = ", ".join(f"{number(degrees(change.taken))}°" for change in found)
    return Text((f"The roller changes walls at cam angle {places}; there its clearance is taken up.",))


def touch_contact(model: Model, drive: FaceDuty) -> tuple[Block, ...]:
    """Force and pressure of every touch over the turn, torque, contact lost; along a roller too."""

    if model.duties and not _sound(model.duty):
        return (Text(("The roller undercuts a profile that it loads: no stress can be given. See the checks.",)),)
    blocks: list[Block] = [touch_lines(model, drive), held(drive.kept), *unbounded(model)]
    blocks += [*pressure_map(model), *patch_map(model), hardest(model)] if model.duties else [touch_figures(drive)]
    return tuple(blocks)


def touch_lines(model: Model, drive: FaceDuty) -> Chart:
    """Normal force and pressure of every touch, and the torque of all of them, over the turn."""
    panels, names = drive.force.panels, tuple(touch.name for touch in drive.touches)
    force = tuple(Series(name, *over_turn(panels, drive.normals[name])) for name in names)
    high = extremes(panels, drive.contact_forces.max(axis=0))
    marks = (*high[:1], *_least(drive.kept))
    shown = [Panel(Axis("Normal force", "N", zero=True), force, marks=marks)]
    peak = model.duty.least_peak if model.duties else drive.peak_pressure
    if peak is not None:
        lines = [Series(name, x, np.sqrt(np.maximum(y, 0.0))) for name, (x, y) in _squares(model, drive)]
        top = mark(degrees(peak.cam_angle) % 360.0, peak.value)
        limits = pressure_limit(model, peak.value)
        shown.append(Panel(Axis("Contact pressure", "MPa", zero=True), tuple(lines), limits=limits, marks=(top,)))
    shown.append(torque(panels, drive.torque))
    still = zones(model.setup.program) + unheld_zones(drive.kept)
    place = ", at the hardest place along the roller" if model.duties else ""
    return Chart(f"Contact of cam and follower over one turn{place}", CAM_ANGLE, tuple(shown), still)


def _squares(model: Model, drive: FaceDuty) -> list[tuple[str, tuple[Floats, Floats]]]:
    """Squared pressure over the turn of every roller, at its hardest place, or of every touch, by name."""
    if model.duties:
        return [(duty.track.name, over_turn(duty.force.panels, duty.hardest_pressure**2)) for duty in model.duties]
    return [(name, over_turn(drive.force.panels, found.behind)) for name, found in drive.contacts.items()]


def unheld_zones(kept: Kept | None) -> tuple[Zone, ...]:
    """The cam angles at which the follower leaves its cam."""
    lost = kept.lost if kept is not None else ()
    return tuple(Zone(degrees(one.begin), degrees(one.end), "no contact") for one in lost)


def _least(kept: Kept | None) -> tuple[Mark, ...]:
    """The least force of a follower that only its spring or weight holds; it must stay above zero."""
    if kept is None or kept.least.value < 0.0:
        return ()
    return (mark(degrees(kept.least.cam_angle) % 360.0, kept.least.value),)


def held(kept: Kept | None) -> Text:
    """A sentence on what keeps the follower at the cam, and how far that holds."""
    if kept is None:
        return Text(("The cam drives its follower both ways; where the force changes sign the play is taken up.",))
    speed = kept.leaving_speed
    if speed is None:
        reach = "at this speed" if kept.least.value >= 0.0 else "at speeds that are not known"
    elif speed == 0.0:
        reach = "at no speed"
    else:
        reach = f"up to {number(speed * 30.0 / pi)} r/min" if isfinite(speed) else "at any speed"
    if kept.least.value >= 0.0:
        return Text((f"Spring and load keep the follower at the cam {reach}.",))
    ranges = ", ".join(f"{number(degrees(one.begin))}° to {number(degrees(one.end))}°" for one in kept.lost)
    return Text((f"The follower leaves the cam from {ranges}: contact would need a pull there; it holds {reach}.",))


def kept_rows(kept: Kept | None) -> list[tuple[Cell, ...]]:
    """What keeps the follower at its cam, in numbers."""
    if kept is None:
        return []
    speed, least = kept.leaving_speed, kept.least
    above: tuple[Cell, Cell] = "not known: forces that hang on the speed" if speed is None else "no speed", ""
    if speed is not None and isfinite(speed):
        above = speed * 30.0 / pi, "r/min"
    return [
        ("Least contact force", least.value, "N", degrees(least.cam_angle) % 360.0),
        ("Contact is lost above", *above, None),
        ("Preload that just keeps contact", kept.preload_needed, "N mm" if kept.load.rotating else "N", None),
    ]


def touch_figures(drive: FaceDuty) -> Table:
    """The hardest contact and the drive in numbers."""
    force, torque, peak = drive.peak_force, drive.peak_torque, drive.peak_pressure
    rows: list[tuple[Cell, ...]] = [("Peak contact force", force.value, "N", degrees(force.cam_angle) % 360.0)]
    if peak is not None:
        where = f", {peak.where}" if len(drive.touches) > 1 else ""
        rows.append((f"Peak contact pressure{where}", peak.value, "MPa", degrees(peak.cam_angle) % 360.0))
    rows += [
        *_beneath(drive.peak_contact, drive.deepest_shear),
        ("Peak drive torque", 1e-3 * torque.value, "N m", degrees(torque.cam_angle)),
        ("Mean drive torque", 1e-3 * _unless_rounding(drive.work / (2.0 * pi), torque.value), "N m", None),
    ]
    return quantities("Contact and drive", [*rows, *kept_rows(drive.kept)])


def turret_contact(model: Model, duty: TurretDuty) -> tuple[Block, ...]:
    """Torque, load of every roller, how many share it, pressure over the turn and along the roller, and the numbers."""
    if not len(duty.loaded):
        return (Text(("No torque acts on the turret: there is no load to share.",)),)
    if not isfinite(duty.least_peak.value):
        return (Text(("A roller undercuts a wall that it loads: no stress can be given. See the checks.",)),)
    lost = (Text((f"No largest pressure: {duty.no_stress}.",)),) if duty.no_stress else ()
    return turret_lines(model, duty), *lost, turret_map(duty), *turret_patch(duty), turret_figures(duty), supports(duty)


def turret_patch(duty: TurretDuty) -> tuple[Map, ...]:
    """Pressure of the hardest contact over its own surface; nothing of a line."""
    if duty.finite is None:
        return ()
    n, m = PATCH
    return (_patch(duty.finite.hardest[1].picture(n, m, duty.middle), duty.least_peak, duty.no_stress),)


def turret_lines(model: Model, duty: TurretDuty) -> Chart:
    """Turret torque, load on every roller, rollers in contact, largest pressure and camshaft torque over the turn."""
    angle = np.degrees(duty.theta)
    hardest = duty.pressure.max(axis=(1, 2))
    worst, top = degrees(duty.least_peak.cam_angle), duty.least_peak.value
    shaft, nodes = 1e-3 * duty.torque.ravel(), np.degrees(duty.force.panels.theta.ravel())
    panels = (
        Panel(Axis("Torque on the turret", "N m", zero=True), (_line("torque", angle, 1e-3 * duty.turret_torque),),
              marks=_largest(angle, 1e-3 * duty.turret_torque)),
        Panel(Axis("Force on a roller", "N", zero=True), _rollers(angle, duty.roller_load),
              marks=_largest(angle, duty.roller_load.max(axis=1))),
        Panel(Axis("Rollers that share the load", "", zero=True), (_sharing(angle, duty.roller_load),), height=0.6),
        Panel(Axis("Contact pressure", "MPa", zero=True), (_line("largest of all slices", angle, hardest),),
              limits=pressure_limit(model, top), marks=(mark(worst, top),)),
        Panel(Axis("Camshaft torque", "N m", zero=True), (_line("torque", nodes, shaft),),
              marks=_largest(nodes, shaft)),
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


def turret_map(duty: TurretDuty) -> Map:
    """Largest pressure of all rollers over the turn and along them; blank where nothing bears."""
    angle = np.linspace(0.0, 360.0, 361)
    delta = duty.tracks[0].meridian.jet(duty.engagement.stations)[0]
    hardest = duty.pressure.max(axis=1)[:, np.argsort(delta)]
    nearest = np.clip(np.searchsorted(duty.theta, np.radians(angle)), 1, len(duty.theta) - 1)
    before = np.abs(duty.theta[nearest - 1] - np.radians(angle)) < np.abs(duty.theta[nearest] - np.radians(angle))
    values = hardest[np.where(before, nearest - 1, nearest)].T
    along, value = Axis("Along the roller axis", "mm"), Axis("Contact pressure", "MPa")
    caption = "Contact pressure over the turn and along the rollers, the hardest pressed of them"
    blank = np.where(values > 1e-3 * duty.least_peak.value, values, np.nan)
    marks = _hardest_place(duty.least_peak)
    return Map(caption, CAM_ANGLE, along, value, angle, np.sort(delta), blank, marks=marks)


def turret_figures(duty: TurretDuty) -> Table:
    """The hardest contact, the torques and what carries the parts, in numbers."""
    data = duty.contact_data()
    rows: list[tuple[Cell, ...]] = []
    for key, label, unit, at in _FIGURES:
        if key in data and not (key == "preload_pressure_mpa" and data[key] == 0.0):
            value = 0.0 if key.startswith("mean") and abs(data[key]) < 1e-9 else data[key]
            rows.append((label, value, unit, data[at] % 360.0 if at else None))
    least, most = data["rollers_sharing_least"], data["rollers_sharing_most"]
    rows.append(("Rollers that share the load", f"{least} to {most}" if most > least else str(most), "", None))
    return quantities("Contact and drive", rows)


def supports(duty: TurretDuty) -> Text:
    """What the stresses of stud and shaft assume."""
    data = duty.contact_data()
    text = f"The stud is taken as {number(data['stud_diameter_mm'])} mm thick, half the roller"
    if "shaft_bearing_distance_mm" in data:
        text += f", the camshaft as thick as the bore on bearings {number(data['shaft_bearing_distance_mm'])} mm apart"
    return Text((text + ": replace these by your own.",))


NOTHING = 1e-12
"""share of the largest part below which a part is none"""


def force_parts(model: Model) -> tuple[Chart, ...]:
    """The parts of the force (N) or torque (N m) that the follower needs, and their sum; none without a load."""
    bearing = model.drive or model.carrier
    if bearing is None:
        return ()
    force, demand, rotating = bearing.force, model.load.demand, model.profile.rotating
    panels, jet = force.panels, (force.lift, force.ds, force.dds)
    applied = sum((demand.of(one, panels.theta, jet) for one in demand.applied), np.zeros(force.lift.shape))
    parts: dict[str, Floats] = {
        "inertia": force.inertia,
        "friction": demand.friction * force.direction,
        "spring and weight": demand.preload + demand.weight + demand.rate * force.lift,
        "applied": applied,
        "sum": force.force,
    }
    whole = {name: np.broadcast_to(values, force.lift.shape) for name, values in parts.items()}
    largest = max(float(np.abs(values).max()) for values in whole.values())
    if largest == 0.0:
        return ()
    factor, axis = (1e-3, Axis("Torque", "N m", zero=True)) if rotating else (1.0, Axis("Force", "N", zero=True))
    lines = []
    for name, values in whole.items():
        if float(np.abs(values).max()) > NOTHING * largest:
            x, y = over_turn(panels, factor * values)
            lines.append(Series(name, x, y))
    panel = Panel(axis, tuple(lines), marks=extremes(panels, force.force, factor), height=1.4)
    what = "torque about its axis" if rotating else "force along its motion"
    return (Chart(f"What the follower needs: {what}, part by part", CAM_ANGLE, (panel,),
                  zones(model.setup.program)),)  # fmt: skip
