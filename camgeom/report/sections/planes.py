"""Planar cams by what touches them: forces, pressures and torque; pressure angles and curvature; a pair's residual."""

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
    Column,
    Limit,
    Mark,
    Panel,
    Series,
    Table,
    Text,
    Zone,
)
from camgeom.drawing.numerals import number
from camgeom.maths import Floats
from camgeom.report.sections.lines import extremes, mark, over_turn, pressure_limit
from camgeom.report.sections.motion import zones

if TYPE_CHECKING:
    from camgeom.mechanics.face_duty import PlanarDrive
    from camgeom.model import Model
    from camgeom.track.pair import PairResidual
    from camgeom.track.planar import Planar
    from camgeom.track.survey import Survey
    from camgeom.track.touch import Contacting

PER_TURN = 720
STEEPEST = 1e4
"""1/mm; a sharper outline has a corner, not a curvature"""
FLAT = 1e-9
"""rad; a pressure angle this small is rounding"""


def contact(model: Model) -> tuple[Block, ...]:
    """Force and pressure of every touch over the turn, torque, contact lost; along a roller too."""
    from camgeom.report.sections.contact import hardest, pressure_map

    if model.loaded and not bool(np.all(model.duty.contact.sound)):
        return (Text(("The roller undercuts a profile that it loads: no stress can be given. See the checks.",)),)
    blocks: list[Block] = [lines(model), kept(model.drive)]
    blocks += [pressure_map(model), hardest(model)] if model.loaded else [figures(model.drive)]
    return tuple(blocks)


def lines(model: Model) -> Chart:
    """Normal force and pressure of every touch, and the torque of all of them, over the turn."""
    from camgeom.report.sections.contact import torque

    drive = model.drive
    panels, names = drive.force.panels, tuple(touch.name for touch in drive.touches)
    force = tuple(Series(name, *over_turn(panels, drive.normals[name])) for name in names)
    high = extremes(panels, np.max(list(drive.normals.values()), axis=0))
    marks = (*high[:1], *_least(drive))
    shown = [Panel(Axis("Normal force", "N", zero=True), force, marks=marks)]
    peak = drive.peak_pressure
    if peak is not None:
        lines = []
        for name, found in drive.contacts.items():
            x, y = over_turn(panels, found.behind)
            lines.append(Series(name, x, np.sqrt(np.maximum(y, 0.0))))
        top = mark(degrees(peak[1]) % 360.0, peak[0])
        limits = pressure_limit(model, peak[0])
        shown.append(Panel(Axis("Contact pressure", "MPa", zero=True), tuple(lines), limits=limits, marks=(top,)))
    shown.append(torque(panels, drive.torque))
    still = zones(model.setup.program) + tuple(
        Zone(degrees(one.begin), degrees(one.end), "no contact") for one in drive.lost
    )
    line = ", as a line contact over the whole length" if model.loaded and model.duty.crown is not None else ""
    return Chart(f"Contact of cam and follower over one turn{line}", CAM_ANGLE, tuple(shown), still)


def _least(drive: PlanarDrive) -> tuple[Mark, ...]:
    """The least force of a follower that only its spring or weight holds; it must stay above zero."""
    value, angle = drive.least
    return () if drive.form_closed or value < 0.0 else (mark(degrees(angle) % 360.0, value),)


def kept(drive: PlanarDrive) -> Text:
    """A sentence on what keeps the follower at the cam, and how far that holds."""
    if drive.form_closed:
        return Text(("The cam drives its follower both ways; where the force changes sign the play is taken up.",))
    rpm = drive.leaving_speed * 30.0 / pi
    reach = f"up to {number(rpm)} r/min" if isfinite(rpm) else "at any speed"
    if drive.least[0] >= 0.0:
        return Text((f"Spring and load keep the follower at the cam {reach}.",))
    ranges = ", ".join(f"{number(degrees(one.begin))}° to {number(degrees(one.end))}°" for one in drive.lost)
    reach = f"it holds {reach}" if rpm > 0.0 else "it holds at no speed"
    return Text((f"The follower leaves the cam from {ranges}: contact would need a pull there; {reach}.",))


def figures(drive: PlanarDrive) -> Table:
    """The hardest contact and the drive in numbers."""
    force, force_at = drive.peak_of(np.max(list(drive.normals.values()), axis=0))
    torque, torque_at = drive.peak_of(drive.torque)
    rows: list[tuple[Cell, ...]] = [("Peak contact force", force, "N", degrees(force_at) % 360.0)]
    if drive.peak_pressure is not None:
        pressure, at, name = drive.peak_pressure
        where = f", {name}" if len(drive.touches) > 1 else ""
        rows.append((f"Peak contact pressure{where}", pressure, "MPa", degrees(at) % 360.0))
    mean = float(drive.force.panels.integral(drive.torque)) / (2.0 * pi)
    rows += [
        ("Peak drive torque", 1e-3 * torque, "N m", degrees(torque_at)),
        ("Mean drive torque", 1e-3 * mean if abs(mean) > 1e-12 * abs(torque) else 0.0, "N m", None),
    ]
    if not drive.form_closed:
        rpm = drive.leaving_speed * 30.0 / pi
        rotating = drive.load.kind == "rotating"
        rows += [
            ("Least contact force", drive.least[0], "N", degrees(drive.least[1]) % 360.0),
            ("Contact is lost above", rpm if isfinite(rpm) else "no speed", "r/min" if isfinite(rpm) else "", None),
            ("Preload that just keeps contact", drive.preload_needed, "N mm" if rotating else "N", None),
        ]
    columns = (Column("Quantity"), Column("Value"), Column("Unit"), Column("Cam angle", "°"))
    return Table("Contact and drive", columns, tuple(rows))


def profile(model: Model, planar: Planar) -> tuple[Block, ...]:
    """Pressure angle and curvature where the cam is touched, the extremes of its profile, and a pair's residual."""
    phi = _angles(planar)
    angle = np.degrees(phi)
    found = [(touch.name, touch.at(phi)) for touch in planar.touches]
    bent = [(touch.name, touch.material * at.curve.curvature) for touch, (_, at) in zip(planar.touches, found)]
    shown = [_angle_panel(model, planar, angle, found)] if planar.pressure_angle.value > FLAT else []
    if all(float(np.abs(values).max()) < STEEPEST for _, values in bent):
        lines = tuple(Series(name, angle, values) for name, values in bent)
        shown.append(Panel(Axis("Curvature of the profile", "1/mm", zero=True), lines))
        rolling = [(touch.name, at) for touch, (_, at) in zip(planar.touches, found) if touch.rolling]
        if rolling:
            lines = tuple(Series(name, angle, at.relative) for name, at in rolling)
            shown.append(Panel(Axis("Relative curvature of cam against roller", "1/mm", zero=True), lines))
    if all(touch.kind == "flat" for touch in planar.touches):
        where = tuple(Series(name, angle, at.along) for name, at in found)
        shown.append(Panel(Axis("Contact on the face", "mm"), where))
    blocks: list[Block] = [Text((_shape_text(planar, bool(shown)),))]
    if shown:
        caption = "The profile where the follower touches it; convex curvature is positive"
        blocks.append(Chart(caption, CAM_ANGLE, tuple(shown), zones(model.setup.program)))
    blocks.append(extreme_table(planar, model.flanks))
    return (*blocks, *(residual(model.pair) if model.pair is not None else ()))


def _angle_panel(model: Model, planar: Planar, angle: Floats, found: list[tuple[str, Contacting]]) -> Panel:
    limit = model.profile.limits.pressure_angle_deg
    near = limit and degrees(planar.pressure_angle.value) > 0.5 * limit
    return Panel(
        Axis("Pressure angle", "°", zero=True),
        tuple(Series(name, angle, np.degrees(at.pressure_angle)) for name, at in found),
        limits=(Limit(limit, f"limit {number(limit)}°"),) if near and limit else (),
        marks=_signed(planar),
    )


def _shape_text(planar: Planar, drawn: bool) -> str:
    text = "Pressure angle and curvature are those of the profile where the follower touches it"
    if all(touch.rolling for touch in planar.touches):
        text += "; a roller turns on its pin, so that its force passes through its centre"
    if not drawn:
        return text + ". It has a corner or a cusp, so its curvature has no bound: see the checks."
    if planar.pressure_angle.value <= FLAT:
        text += "; a face at right angles to its guide has no pressure angle"
    return text + ". Along the width of the cam nothing changes."


def _angles(planar: Planar) -> Floats:
    """Cam angles, rad, over the turn with both sides of every knot."""
    knots = np.unique(np.concatenate([np.r_[0.0, touch.knots(), 2.0 * pi] for touch in planar.touches]))
    hair = 1e-9
    parts = [
        np.linspace(low + hair, high - hair, max(3, int(np.ceil(PER_TURN * (high - low) / (2.0 * pi)))))
        for low, high in zip(knots[:-1], knots[1:])
        if high - low > 4.0 * hair
    ]
    return np.concatenate(parts)


def _signed(planar: Planar) -> tuple[Mark, ...]:
    """Marks at the largest and, where it has the other sign, the least pressure angle."""
    low, high = planar.pressure_angle_range
    ends = [end for end in (high, low) if abs(end.value) > 0.02 * planar.pressure_angle.value]
    kept = ends if high.value * low.value < 0.0 else [max(ends, key=lambda end: abs(end.value))]
    return tuple(mark(degrees(end.cam_angle) % 360.0, degrees(end.value), "°") for end in kept)


def extreme_table(planar: Planar, flanks: tuple[Survey, ...]) -> Table:
    """Pressure angle, smallest radii, undercut margins, what a face needs, sliding and width of a planar cam."""
    convex, hollow = planar.radii
    named = (
        ("Largest pressure angle", planar.pressure_angle, "°", degrees(1.0)),
        ("Smallest convex radius of the profile", convex, "mm", 1.0),
        ("Smallest hollow radius of the profile", hollow, "mm", 1.0),
        ("Width that the flat face needs", planar.face_needed, "mm", 1.0),
        ("Largest sliding of the cam over the follower", planar.sliding, "mm/rad", 1.0),
        ("Largest deviation from the constant width", planar.width_residual, "mm", 1.0),
    )
    rows: list[tuple[Cell, ...]] = []
    for name, one, unit, factor in named:
        if one is not None:
            value = factor * one.value
            small = unit in ("°", "mm") and abs(value) < FLAT  # rounding
            rows.append((name, 0.0 if small else value, unit, None if small else degrees(one.cam_angle) % 360.0))
    for survey in flanks:
        margin, name = survey.margin, f"Least undercut margin 1 − rκ, {survey.track.name}"
        rows.append((name, float(margin.value), "", degrees(margin.cam_angle) % 360.0))
    if planar.curvature_jumps:
        places = ", ".join(f"{number(degrees(jump.cam_angle))}°" for jump in planar.curvature_jumps[:8])
        more = " and more" if len(planar.curvature_jumps) > 8 else ""
        rows.append(("Curvature jumps at", places + more, "", None))
    columns = (Column("Extreme"), Column("Value"), Column("Unit"), Column("Cam angle", "°"))
    return Table("Extremes of the profile", columns, tuple(rows))


def residual(found: PairResidual) -> tuple[Block, ...]:
    """Gap at the second roller of a pair over the turn, while the first one rests on its disc."""
    angle = np.degrees(found.phi)
    i, j = int(found.gap.argmin()), int(found.gap.argmax())
    # The spread alone tells how far the play can be taken away.
    spread = float(np.ptp(found.gap))
    marks = tuple(mark(float(angle[k]), float(found.gap[k]), " mm") for k in ((i, j) if spread > FLAT else (i,)))
    gap = np.append(found.gap, found.gap[0])
    if spread <= FLAT:
        gap = np.full(len(gap), round(float(found.gap.mean()), 9) + 0.0)
    panel = Panel(Axis("Gap", "mm"), (Series("gap", np.append(angle, 360.0), gap),), marks=marks)
    caption = "Gap at the return roller while the main roller rests on its disc, parts as drawn"
    return (Chart(caption, CAM_ANGLE, (panel,)),)
