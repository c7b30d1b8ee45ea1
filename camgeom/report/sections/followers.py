"""Several followers on one track: what each bears, and the torque that they ask of the camshaft together."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING

from camgeom.checks.verdict import life_shown
from camgeom.drawing.content import CAM_ANGLE, Axis, Block, Cell, Chart, Column, Panel, Series, Table, Text
from camgeom.drawing.sheet import number
from camgeom.report.sections.motion import extremes, over_turn

if TYPE_CHECKING:
    from camgeom.model import Model


def followers(model: Model) -> tuple[Block, ...]:
    """The followers one by one, and the torque of all; nothing of one follower."""
    if len(model.bindings) == 1:
        return ()
    told = "Figures of a follower count from its own cam angle, the cam's less the angle of its place: on one track "
    told += "each does later by that what the first does."
    for what, least in (("Rollers come", model.apart), ("To a pivot one comes", model.apart_from_pivots)):
        if least is not None:
            at = f"cam angle {number(degrees(least.cam_angle) % 360.0)}°"
            told += f" {what} as near as {number(least.value)} mm ({least.where}, {at})."
    blocks: list[Block] = [Text((told,)), each(model)]
    if model.camshaft is not None:
        blocks.append(torques(model))
    return tuple(blocks)


def each(model: Model) -> Table:
    """Place, moving mass, load and lives of every follower."""
    bodies = [body for body in model.own_lives if body != "cam"] if model.profile.operation is not None else []
    unit = "kg m²" if model.profile.rotating else "kg"
    columns = [Column("Follower"), Column("Track"), Column("Place", "°"), Column("Moves", unit)]
    columns += [Column("Force", "N"), Column("Pressure", "MPa"), Column("Torque", "N m")]
    columns += [Column(f"{body.capitalize()} life") for body in bodies]
    rows: list[tuple[Cell, ...]] = []
    for one in model.bindings:
        operation, duty = one.profile.operation, one.hardest_state.carrier
        loads = (operation.load_mass, operation.load_inertia) if operation is not None else (0.0, 0.0)
        place = f"{one.number + 1}", f"{one.groove + 1}", degrees(one.angle)
        row: tuple[Cell, ...] = (*place, one.setup.follower.moving(*loads))
        shaft = one.hardest_state.shaft
        if duty is None or shaft is None:
            rows.append((*row, None, None, None, *("" for _ in bodies)))
            continue
        peak = duty.peak_pressure
        row = (*row, duty.peak_force.value, None if peak is None else peak.value, 1e-3 * shaft.peak_torque.value)
        rows.append((*row, *(_life(one.own_lives.get(body)) for body in bodies)))
    return Table("Followers", tuple(columns), tuple(rows))


def _life(hours: float | None) -> str:
    if hours is None:
        return ""
    shown = life_shown(hours)
    return shown if isinstance(shown, str) else f"{number(shown)} h"


def torques(model: Model) -> Chart:
    """Torque of the shaft over the cam angle, of each follower and of all."""
    shaft = model.camshaft
    assert shaft is not None
    count = range(len(shaft.followers))
    one = [Series(f"follower {k + 1}", *over_turn(shaft.panels, 1e-3 * shaft.torque_of(k))) for k in count]
    whole = Series("all", *over_turn(shaft.panels, 1e-3 * shaft.torque))
    panels = (
        Panel(Axis("All followers", "N m", zero=True), (whole,), marks=extremes(shaft.panels, shaft.torque, 1e-3)),
        Panel(Axis("Each follower", "N m", zero=True), tuple(one)),
    )
    return Chart("Torque of the camshaft over one turn of the cam", CAM_ANGLE, panels)
