"""Dynamics, where the model has any: indexing drive, elastic follower, impacts in the follower's clearance."""

from __future__ import annotations

from collections.abc import Mapping
from math import degrees, pi
from typing import TYPE_CHECKING, Any, Literal, final

import numpy as np

from camgeom.checks.verdict import life_shown
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
    quantities,
)
from camgeom.drawing.sheet import number
from camgeom.errors import CamgeomError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.report.data.solved import duty_figures, dynamic_duty_data, impact_figures
from camgeom.report.sections.motion import at_speed, mark, one_turn, zones
from camgeom.track import TURN

if TYPE_CHECKING:
    from camgeom.dynamics.follower.response import Flight
    from camgeom.dynamics.follower.study import FollowerStudy
    from camgeom.model import Model
    from camgeom.motion.program import Program
RAD = 30.0 / pi
SEEN = 1000.0
"""natural periods in a move, beyond which some 1e-7 of it is left: a constant acceleration leaves 16 / (2 pi n)²"""
SPEEDS = 401
"""cam speeds at which the residual is drawn"""
MOST_EVENTS = 12
HAIR = 1e-9
"""rad"""


def dynamics(model: Model) -> tuple[Block, ...]:
    """Blocks of what the profile's [dynamics] and [impact] tables ask for, in the hardest state; none without them."""
    if model.profile.duty and (model.profile.dynamics_spec or model.profile.impact_spec):
        state = model.hardest_state
        name = state.state.name if state.state else ""
        whose = Text((f"Of the operating state {name!r}, in which the rigid contact is pressed hardest.",))
        return whose, *dynamics(state)
    blocks: tuple[Block, ...] = ()
    program, rotating = model.setup.program, model.profile.rotating
    if model.indexing is not None:
        from camgeom.report.sections.indexing import indexing

        blocks += indexing(model.indexing)
    if model.elastic_follower is not None:
        blocks += elastic(model.elastic_follower, program, rotating)
    if carried := dynamic_duty_data(model):
        blocks += (duties("with vibration", "Elastic", carried),)
    if model.impact is not None:
        from camgeom.report.sections.impact import impacts, reproduced, studies

        blocks += impacts(model.impact, rotating)
        figures = {"duty": impact_figures(model), "rigid_duty": duty_figures(model.carriers)}
        blocks += (duties("with impacts", "With impacts", figures),)
        blocks += studies(model)
        if model.impact_sensitivity is not None:
            blocks += (reproduced(model.impact_sensitivity),)
    return blocks


CARRIED = (
    ("Peak contact force", "peak_force_n", "N"),
    ("Peak torque at the cam", "peak_torque_n_m", "N m"),
    ("Peak force along the travel", "peak_travel_force_n", "N"),
    ("Peak force of the drive, plate and slide too", "peak_drive_force_n", "N"),
    ("Peak contact pressure", "peak_pressure_mpa", "MPa"),
    ("Static safety of the bearing", "bearing_static_safety", "1"),
    *((f"Life of the {body}", f"{body}_life_h", "h") for body in ("roller", "face", "cam", "bearing")),
)
"""words, key of `duty_figures`, unit"""


def duties(what: str, head: str, data: Mapping[str, Any]) -> Block:
    """Force, torque, pressure, safety and lives under the solved contact force, and what the rigid motion gives."""
    if "rigid_duty" not in data:
        return Text((f"What the contact carries {what} is not known: {data['duty']['failed']}",))
    solved, rigid, start = data["duty"], data["rigid_duty"], data.get("start_duty")
    every = (solved, rigid) if start is None else (solved, start, rigid)
    rows: list[tuple[Cell, ...]] = [
        (words, *(life_shown(each[key]) if unit == "h" and key in each else each.get(key) for each in every), unit)
        for words, key, unit in CARRIED
        if key in solved and key in rigid
    ]
    first = () if start is None else (data.get("start_camshaft_torque_n_m"),)
    if "camshaft_torque_n_m" in data:
        where = f"Peak camshaft torque, {data['camshaft_torque_is']}"
        rows.append((where, data["camshaft_torque_n_m"], *first, rigid["peak_torque_n_m"], "N m"))
    if "output_torque_n_m" in data:
        where, none = f"Peak torque of the output shaft, {data['output_torque_is']}", (None,) * len(first)
        rows.append((where, data["output_torque_n_m"], *none, None, "N m"))
    between = () if start is None else (Column("From rest"),)
    columns = (Column("Quantity"), Column(head), *between, Column("Rigid"), Column("Unit"))
    basis = f"; lives from {solved['lives_from']}" if "lives_from" in solved else ""
    return Table(f"What the contact carries {what}, and without{basis}", columns, tuple(rows))


def elastic(study: FollowerStudy, program: Program, rotating: bool) -> tuple[Block, ...]:
    """All about an elastic follower at its working speed; the sweep where one was asked for."""
    blocks: list[Block] = [over_turn(study, program, rotating)]
    if study.jump is not None and bool(study.jump.lost[0]):
        try:
            blocks += flying(study.flight, study, rotating)
        except CamgeomError as error:
            blocks.append(Text((f"Where the follower leaves its cam is not known: {error}",)))
    if study.sweep_speeds is not None and study.sweep.answered.any():
        blocks.append(over_speeds(study, rotating))
    left = residual(study, program, rotating)
    blocks += [left] if left is not None else []
    return (*blocks, figures(study, rotating))


def _units(rotating: bool) -> tuple[str, str, str, float]:
    """Units of acceleration, force and deviation, and the factor of the last from m (rad)."""
    return ("rad/s²", "N m", "mrad", 1e3) if rotating else ("m/s²", "N", "µm", 1e6)


def over_turn(study: FollowerStudy, program: Program, rotating: bool) -> Chart:
    """Acceleration against the rigid motion, deviation, contact force and cam torque over a periodic turn."""
    steady = study.steady
    theta, angle = one_turn(steady)
    acceleration, force, play, factor = _units(rotating)
    rigid = study.scale * study.speed**2 * np.asarray(study.motion.jet(theta, 2)[2])
    panels = [
        Panel(
            Axis("Acceleration", acceleration),
            (Series("with vibration", angle, steady.at(theta, "acceleration")[0]), Series("rigid", angle, rigid)),
            marks=(_peak(study, "acceleration"),),
        ),
    ]
    rows: list[tuple[str, Axis, float, tuple[Mark, ...]]] = [
        ("deviation", Axis("Deviation", play), factor, ()),
        ("contact_force", Axis("Contact force", force, zero=True), 1.0, _contact(study)),
    ]
    if not study.train.slides:
        rows.append(("cam_torque", Axis("Cam torque", "N m", zero=True), 1.0, (_peak(study, "cam_torque"),)))
    for name, axis, scale, marks in rows:
        panels.append(Panel(axis, (Series(axis.label, angle, scale * steady.at(theta, name)[0]),), marks=marks))
    caption = f"Periodic response of the elastic follower at {number(study.speed * RAD)} r/min, contact held"
    return Chart(caption, CAM_ANGLE, tuple(panels), zones(program))


def _peak(study: FollowerStudy, name: str) -> Mark:
    found = study.steady.peak(name)
    high = abs(float(found.maximum[0])) >= abs(float(found.minimum[0]))
    value, at = (found.maximum, found.maximum_at) if high else (found.minimum, found.minimum_at)
    return mark(degrees(float(at[0])) % 360.0, float(value[0]))


def _contact(study: FollowerStudy) -> tuple[Mark, ...]:
    found = study.steady.peak("contact_force")
    ends = ((found.maximum, found.maximum_at), (found.minimum, found.minimum_at))
    return tuple(mark(degrees(float(at[0])) % 360.0, float(value[0])) for value, at in ends)


def flying(flight: Flight, study: FollowerStudy, rotating: bool) -> tuple[Block, ...]:
    """The gap over three turns of a follower that leaves its cam, and where it lands how fast."""
    unit, factor = ("mrad", 1e3) if rotating else ("mm", 1e3)
    gap = np.where(flight.flying, np.maximum(flight.deviation[:, 0], 0.0), 0.0)
    turns = (flight.theta - flight.theta[0]) / TURN
    text = (
        "The contact force of the steady state falls below zero: the follower leaves its cam. The next figure follows "
        "it through flights and landings from standstill."
    )
    panel = Panel(Axis("Gap", unit, zero=True), (Series("gap", turns, factor * gap),))
    landings = [event for event in flight.events if event.kind == "landing"]
    hardest = sorted(landings, key=lambda event: -event.closing_speed)[:MOST_EVENTS]
    rows = tuple(
        (1 + int((event.theta - flight.theta[0]) / TURN), degrees(event.theta) % 360.0, event.closing_speed)
        for event in sorted(hardest, key=lambda event: event.theta)
    )
    speed = "rad/s" if rotating else "m/s"
    columns = (Column("Turn"), Column("Cam angle", "°"), Column("Closing speed", speed))
    more = f", the {len(hardest)} hardest of {len(landings)}" if len(landings) > len(hardest) else ""
    return (
        Text((text,)),
        Chart(f"Flight of the follower at {number(study.speed * RAD)} r/min", Axis("Turns from rest"), (panel,)),
        Table(f"Landings{more}", columns, rows),
    )


def over_speeds(study: FollowerStudy, rotating: bool) -> Chart:
    """Peak acceleration and, for a force-closed follower, the least contact force over the cam speed."""
    sweep, rpm = study.sweep, study.speed * RAD
    kept = sweep.answered
    x = sweep.speed[kept] * RAD
    acceleration, force, _, _ = _units(rotating)
    at = at_speed(rpm)
    peak = sweep.peaks["acceleration"].magnitude[kept]
    panels = [Panel(Axis("Peak acceleration", acceleration, zero=True), (Series("peak", x, peak),), limits=at)]
    if study.train.closure == "force":
        least = sweep.peaks["contact_force"].minimum[kept]
        limits = (Limit(0.0, "contact lost below"), Limit(rpm, "", vertical=True))
        panels.append(Panel(Axis("Least contact force", force, zero=True), (Series("least", x, least),), limits=limits))
    return Chart("Response over the cam speed", Axis("Cam speed", "r/min"), tuple(panels))


@final
@immutable
class Stretch:
    """A moving stretch of a program that ends in a dwell, as a law on 0 .. 1; `size` is what its lift is divided by."""

    program: Program
    start: float
    end: float
    size: float

    @property
    def knots(self) -> tuple[float, ...]:
        turn = self.program.knots
        inside = [k for k in np.concatenate([turn, turn + TURN]).tolist() if self.start + HAIR < k < self.end - HAIR]
        return (0.0, *sorted({(k - self.start) / (self.end - self.start) for k in inside}), 1.0)

    def jet(self, x: Floats, order: int = 3, side: Literal["left", "right"] = "right") -> Floats:
        span = self.end - self.start
        found = self.program.jet(self.start + span * np.asarray(x, dtype=float), order, side)
        return np.asarray(found * (span ** np.arange(order + 1.0))[:, None] / self.size)


def stretches(program: Program) -> tuple[Stretch, ...]:
    """The moving stretches that end in a dwell, also the one that runs over the end of the turn."""
    spans = program.spans
    still = [i for i, span in enumerate(spans) if span.law == "dwell"]
    if not still:
        return ()
    first = still[0]
    ordered = [(span, 0.0) for span in spans[first:]] + [(span, TURN) for span in spans[: first + 1]]
    found: list[Stretch] = []
    start, lifts = 0.0, list[float]()
    for span, later in ordered:
        if span.law != "dwell":
            start = start if lifts else span.start + later
            lifts += [span.before, span.after]
            continue
        if lifts and max(lifts) > min(lifts):
            found.append(Stretch(program, start, span.start + later, max(lifts) - min(lifts)))
        lifts = []
    return tuple(found)


def residual(study: FollowerStudy, program: Program, rotating: bool) -> Chart | None:
    """Amplitude left in the dwell after each rise and return over the cam speed; None without a dwell."""
    from camgeom.dynamics.follower.residual import residual_spectrum

    moves = stretches(program)
    if not moves:
        return None
    train = study.train
    frequency = float(train.natural_frequency()[0])
    ratio = min((train.damping + train.return_damping) / (2.0 * train.mass * frequency), 0.99)
    rpm = study.speed * RAD
    speeds = np.linspace(0.25, 2.0, SPEEDS) * rpm
    unit, factor = ("mrad", 1e3) if rotating else ("µm", 1e6)
    series = []
    for move in moves:
        periods = (move.end - move.start) / (speeds / RAD) * frequency / TURN
        if periods.max() > SEEN:
            continue  # a follower so stiff against its cam leaves nothing that could be seen
        values = residual_spectrum(move, periods, ratio).amplitude * move.size * study.scale * factor
        name = f"after {number(degrees(move.start))}° to {number(degrees(move.end) % 360.0 or 360.0)}°"
        series.append(Series(name, speeds, values))
    if not series:
        return None
    at = at_speed(rpm)
    panel = Panel(Axis("Residual amplitude", unit, zero=True), tuple(series), limits=at)
    hertz = number(frequency / TURN)
    caption = f"Vibration left at the start of the dwell by each move from rest, one mass at {hertz} Hz"
    return Chart(caption, Axis("Cam speed", "r/min"), (panel,))


def figures(study: FollowerStudy, rotating: bool) -> Table:
    """Natural frequencies, extremes of the response, and what keeps contact."""
    steady = study.steady
    acceleration, force, play, factor = _units(rotating)
    rigid = study.scale * study.speed**2 * float(np.abs(study.motion.jet(steady.theta, 2)[2]).max())
    peak = float(steady.peak("acceleration").magnitude[0])
    contact = steady.peak("contact_force")
    rows: list[tuple[Cell, ...]] = [
        (f"Natural frequency {n}", float(w) / TURN, "Hz") for n, w in enumerate(study.train.natural_frequency(), 1)
    ]
    rows += [
        ("Peak acceleration", peak, acceleration),
        ("The same over the rigid peak", peak / rigid if rigid > 0.0 else None, ""),
        ("Peak deviation", factor * float(steady.peak("deviation").magnitude[0]), play),
        ("Largest contact force", float(contact.maximum[0]), force),
        ("Least contact force", float(contact.minimum[0]), force),
    ]
    if not study.train.slides:
        rows.append(("Peak cam torque", float(steady.peak("cam_torque").magnitude[0]), "N m"))
    if study.jump is not None:
        rows.append(("Contact kept", not bool(study.jump.lost[0]), ""))
        rows.append(("Preload that just keeps contact", float(study.jump.required_preload[0]), force))
    if study.shaft is not None:
        rows.append(("Peak windup of the camshaft", degrees(float(steady.peak("windup").magnitude[0])), "°"))
        rows.append(("Peak torque of the camshaft", float(steady.peak("shaft_torque").magnitude[0]), "N m"))
    if study.rigid is not None:
        soft, angle = study.body
        unit = "N m/rad" if rotating else "N/mm"
        where = f"Stiffness of the cam's body below the contact, at its softest, {degrees(angle):.4g}°"
        rows.append((where, 1.0 / soft if soft > 0.0 else "no softer than the contact's half-space", unit))
        first, stiff = study.rigid.train.natural_frequency()[0], study.rigid.steady.peak("acceleration").magnitude[0]
        rows.append(("Natural frequency 1 on a rigid cam body", float(first) / TURN, "Hz"))
        rows.append(("Peak acceleration on a rigid cam body", float(stiff), acceleration))
    return quantities("The elastic follower in numbers", rows)
