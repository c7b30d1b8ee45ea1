"""Impacts of a follower in its clearance: the last turn, all turns, phase portrait, clearances and laws compared."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import degrees
from typing import TYPE_CHECKING

import numpy as np

from camgeom.drawing.content import (
    CAM_ANGLE,
    Axis,
    Band,
    Block,
    Cell,
    Chart,
    Column,
    Mark,
    Panel,
    Series,
    Table,
    Text,
    quantities,
)
from camgeom.drawing.sheet import number
from camgeom.maths import Floats

if TYPE_CHECKING:
    from camgeom.dynamics.impact.run import ImpactRun
    from camgeom.dynamics.impact.study import StartSensitivity, Statistic, StudyRow
    from camgeom.model import Model

MOST_ROWS = 24
"""impacts listed one by one"""


def reproduced(found: StartSensitivity) -> Text:
    """How far the turns of a motion with impacts can be reproduced."""
    from camgeom.dynamics.impact.study import DISTURBANCE

    grown = ", ".join(number(value) for value in found.growth[:MOST_ROWS])
    text = f"A start moved by {number(DISTURBANCE)} of the play is off by {grown} times as much after each turn."
    if found.reproducible < found.turns:
        return Text((f"{text} Peaks are not reproducible beyond turn {found.reproducible}: only statistics are.",))
    return Text((f"{text} The peaks of all {found.turns} turns are reproducible.",))


def impacts(run: ImpactRun, angular: bool) -> tuple[Block, ...]:
    """The last turn over the cam angle, all turns over time, the impacts of the last turn, and the balance.

    angular  True for a rocker, whose coordinate is an angle.
    """
    turns = run.turn_times()
    window = turns[-1] if turns else (0.0, run.recorded.time)
    return (
        last_turn(run, window, angular), portrait(run, angular), all_turns(run), hits(run, window), balance(run, turns)
    )  # fmt: skip


def _within(run: ImpactRun, window: tuple[float, float]) -> tuple[Floats, dict[str, Floats]]:
    """Cam angle (n,), degrees from the window's start, and the traces there; time rises."""
    flat = run.trace.flat()
    keep = (flat.time >= window[0]) & (flat.time <= window[1])
    angle = np.degrees(flat.angle[keep] - (run.start_angle + run.problem.speed * window[0]))
    start = degrees(run.start_angle + run.problem.speed * window[0]) % 360.0
    traces = {
        "position": flat.position[keep],
        "speed": flat.speed[keep],
        "acceleration": flat.acceleration[keep],
        "main": flat.force[keep, 0],
        "back": flat.force[keep, 1],
        "deviation": flat.deviation[keep],
    }
    return angle + start, traces


def last_turn(run: ImpactRun, window: tuple[float, float], angular: bool) -> Chart:
    """Position, velocity and acceleration with play and without, forces of both contacts, place in the clearance."""
    angle, traces = _within(run, window)
    lift, speed = run.machine.lift, run.problem.speed
    grid = np.linspace(float(angle[0]), float(angle[-1]), 1441)
    ideal = speed ** np.arange(3.0)[:, None] * np.asarray(lift.many(np.radians(grid), 2)[:3])
    play = Axis("Place in the play", "mrad") if angular else Axis("Place in the play", "µm")
    rows = (
        (Axis("Position", "°"), degrees(1.0), Axis("Velocity", "rad/s"), Axis("Acceleration", "rad/s²"))
        if angular
        else (Axis("Position", "mm"), 1e3, Axis("Velocity", "m/s"), Axis("Acceleration", "m/s²"))
    )
    i = int(np.abs(traces["acceleration"]).argmax())
    top = float(traces["acceleration"][i])
    mark = Mark(float(angle[i]), top, f"{number(top)} at {number(float(angle[i]) % 360.0)}°")
    motions = (("position", rows[0], rows[1], ()), ("speed", rows[2], 1.0, ()), ("acceleration", rows[3], 1.0, (mark,)))
    panels = (
        *(
            Panel(axis, (Series("with play", angle, unit * traces[name]), Series("without play", grid, unit * bare)),
                  marks=marks)
            for (name, axis, unit, marks), bare in zip(motions, ideal)
        ),
        Panel(
            Axis("Contact force", "N", zero=True),
            (Series("main contact", angle, traces["main"]), Series("opposite contact", angle, traces["back"])),
        ),
        Panel(play, (Series("deviation", angle, traces["deviation"] * (1e3 if angular else 1e6)),)),
    )
    whole = abs(float(angle[0])) < 1.0 and abs(float(angle[-1]) - 360.0) < 1.0
    axis = CAM_ANGLE if whole else Axis(CAM_ANGLE.label, "°")
    return Chart("The last turn: motion, contact forces, and where the follower is in its play", axis, panels)


def portrait(run: ImpactRun, angular: bool) -> Chart:
    """Phase portrait: the place in the play and its rate, every turn over the others."""
    flat = run.trace.flat()
    unit, rate, factor = ("mrad", "rad/s", 1e3) if angular else ("µm", "m/s", 1e6)
    ideal = run.problem.speed * np.asarray(run.machine.lift.many(flat.angle, 1)[1])
    lines = []
    for turn, (low, high) in enumerate(run.turn_times(), 1):
        kept = (flat.time >= low) & (flat.time <= high)
        lines.append(Series(f"turn {turn}", factor * flat.deviation[kept], (flat.speed - ideal)[kept]))
    panel = Panel(Axis("Its rate", rate), tuple(lines), height=1.5)
    return Chart("Phase portrait: the place in the play and its rate", Axis("Place in the play", unit), (panel,))


def all_turns(run: ImpactRun) -> Chart:
    """Forces of both contacts over the whole run."""
    flat = run.trace.flat()
    series = tuple(
        Series(name, 1e3 * flat.time, flat.force[:, k]) for k, name in enumerate(("main contact", "opposite contact"))
    )
    return Chart(
        "Contact forces over the whole run", Axis("Time", "ms"), (Panel(Axis("Force", "N", zero=True), series),)
    )


def hits(run: ImpactRun, window: tuple[float, float]) -> Block:
    """The impacts of a window one by one, the hardest first where there are many."""
    found = [hit for hit in run.impacts if window[0] <= hit.time < window[1]]
    if not found:
        return Text(("No impact in the last turn: the follower stays in contact.",))
    kept = sorted(sorted(found, key=lambda hit: -hit.peak_force)[:MOST_ROWS], key=lambda hit: hit.time)
    rows = tuple(
        (
            degrees(hit.angle) % 360.0,
            "main" if int(hit.side) == 1 else "opposite",
            hit.approach_speed,
            1e3 * hit.energy,
            1e3 * hit.duration,
            hit.peak_force,
            1e-6 * hit.peak_pressure if hit.peak_pressure else None,
            "changes sides" if hit.converts else "",
        )
        for hit in kept
    )
    columns = (
        Column("Cam angle", "°"), Column("Contact"), Column("Approach", "m/s"), Column("Energy", "mJ"),
        Column("Duration", "ms"), Column("Peak force", "N"), Column("Peak pressure", "MPa"), Column("Drive"),
    )  # fmt: skip
    more = f", the {len(kept)} hardest of {len(found)}" if len(found) > len(kept) else ""
    return Table(f"Impacts of the last turn{more}", columns, rows)


def balance(run: ImpactRun, turns: list[tuple[float, float]]) -> Table:
    """Peaks turn by turn in short, and the energy balance that checks the run."""
    energy = run.energy
    rows: list[tuple[Cell, ...]] = []
    if turns:
        peaks = [run.peak("acceleration", *turn).value for turn in turns]
        ideal = float(run.machine.lift.peaks[2]) * run.problem.speed**2
        rows.append(("Peak acceleration over that without play, mean of the turns", float(np.mean(peaks)) / ideal, "1"))
        rows.append(("The same, largest turn", float(np.max(peaks)) / ideal, "1"))
    rows += [
        ("Impacts in the run", len(run.impacts), "1"),
        ("Changes of the driving side in the run", len(run.conversions), "1"),
        ("Energy lost in the contacts", energy.lost, "J"),
        ("Energy balance, residual of the largest flow", energy.relative_residual, "1"),
    ]
    return quantities("The run in numbers", rows)


def studies(model: Model) -> tuple[Block, ...]:
    """The clearances and the laws that [impact] compares; nothing of what it does not ask for."""
    from camgeom.dynamics.impact.study import StudyRow, Unsolved

    spec, angular = model.profile.impact_spec, model.profile.rotating
    if spec is None:
        return ()
    blocks: list[Block] = []
    clearances, laws = ([row for row in rows if isinstance(row, StudyRow)]
                        for rows in (model.impact_clearances, model.impact_law_rows))  # fmt: skip
    if clearances:
        blocks.append(over_clearances(clearances, angular))
    if laws:
        blocks += [laws_overlaid(model.impact_law_runs, angular), laws_compared(laws, angular)]
    for row in (*model.impact_clearances, *model.impact_law_rows):
        if isinstance(row, Unsolved):
            blocks.append(Text((f"{row.label}: {row.reason}",)))
    return tuple(blocks)


def over_clearances(rows: Sequence[StudyRow], angular: bool) -> Chart:
    """Means of the peaks over the clearance, with the least and the largest of the counted turns as bands."""
    rows = sorted(rows, key=lambda row: row.clearance)
    x = np.array([1e3 * row.clearance for row in rows])
    unit = "rad/s²" if angular else "m/s²"

    def panel(axis: Axis, factor: float, *named: tuple[str, Sequence[Statistic]]) -> Panel:
        lines, bands = [], []
        for style, (name, each) in enumerate(named):
            mean, least, largest = (factor * np.array(values) for values in zip(*each))
            lines += [Series(name, x, mean, style), Series(name, x, mean, style, dots=True)]
            bands.append(Band(f"{name}, least to largest", x, least, largest, style))
        return Panel(axis, tuple(lines), tuple(bands))

    ideal = Series("without play", x, np.array([row.ideal_acceleration for row in rows]), 3)
    first = panel(Axis("Peak acceleration", unit, zero=True), 1.0, ("mean", [row.acceleration for row in rows]))
    panels = (
        Panel(first.y, (*first.series, ideal), first.bands),
        panel(Axis("Peak force", "N", zero=True), 1.0, ("main contact", [row.force_main for row in rows]),
              ("opposite contact", [row.force_return for row in rows])),
        panel(Axis("Peak pressure", "MPa", zero=True), 1e-6, ("mean", [row.pressure for row in rows])),
        panel(Axis("Approach speed", "m/s", zero=True), 1.0, ("mean", [row.approach_speed for row in rows])),
    )  # fmt: skip
    return Chart("Peaks of the counted turns over the clearance", Axis("Clearance", "mm"), panels)


def laws_overlaid(runs: Mapping[str, ImpactRun], angular: bool) -> Chart:
    """The last turn with every law that is compared: acceleration and the forces of both contacts."""
    found = {law: _within(run, run.turn_times()[-1]) for law, run in runs.items()}
    rows = (
        ("acceleration", Axis("Acceleration", "rad/s²" if angular else "m/s²")),
        ("main", Axis("Force of the main contact", "N", zero=True)),
        ("back", Axis("Force of the opposite contact", "N", zero=True)),
    )
    panels = tuple(
        Panel(axis, tuple(Series(law, angle, traces[name]) for law, (angle, traces) in found.items()))
        for name, axis in rows
    )
    return Chart("Laws compared: the last counted turn", CAM_ANGLE, panels)


def laws_compared(rows: Sequence[StudyRow], angular: bool) -> Table:
    """Peaks of every law that is compared, mean of the counted turns."""
    unit = "rad/s²" if angular else "m/s²"
    columns = (
        Column("Law"), Column("Peak acceleration", unit), Column("Without play", unit), Column("Ratio"),
        Column("Main contact", "N"), Column("Opposite contact", "N"), Column("Pressure", "MPa"), Column("Periodic"),
    )  # fmt: skip
    cells: tuple[tuple[Cell, ...], ...] = tuple(
        (row.label, row.acceleration.mean, row.ideal_acceleration, row.amplification, row.force_main.mean,
         row.force_return.mean, 1e-6 * row.pressure.mean, "yes" if row.periodic else "no")
        for row in rows
    )  # fmt: skip
    return Table("Laws compared, means of the counted turns", columns, cells)
