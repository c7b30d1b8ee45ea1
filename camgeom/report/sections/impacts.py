"""Impacts of a follower in its clearance: histories of force and acceleration, single impacts, statistics."""

from __future__ import annotations

from math import degrees, pi
from typing import TYPE_CHECKING

import numpy as np

from camgeom.drawing.content import CAM_ANGLE, Axis, Block, Cell, Chart, Column, Mark, Panel, Series, Table, Text
from camgeom.drawing.numerals import number
from camgeom.maths import Floats

if TYPE_CHECKING:
    from camgeom.dynamics.impact.run import ImpactRun

TURN = 2.0 * pi
MOST_ROWS = 24
"""impacts listed one by one"""


def impacts(run: ImpactRun, angular: bool) -> tuple[Block, ...]:
    """The last turn over the cam angle, all turns over time, the impacts of the last turn, and the balance.

    angular  True for a rocker, whose coordinate is an angle.
    """
    turns = run.turn_times()
    window = turns[-1] if turns else (0.0, run.recorded.time)
    return (last_turn(run, window, angular), all_turns(run), hits(run, window), balance(run, turns))


def _within(run: ImpactRun, window: tuple[float, float]) -> tuple[Floats, dict[str, Floats]]:
    """Cam angle (n,), degrees from the window's start, and the traces there; time rises."""
    flat = run.trace.flat()
    keep = (flat.time >= window[0]) & (flat.time <= window[1])
    angle = np.degrees(flat.angle[keep] - (run.start_angle + run.problem.speed * window[0]))
    start = degrees(run.start_angle + run.problem.speed * window[0]) % 360.0
    traces = {
        "acceleration": flat.acceleration[keep],
        "main": flat.force[keep, 0],
        "back": flat.force[keep, 1],
        "deviation": flat.deviation[keep],
    }
    return angle + start, traces


def last_turn(run: ImpactRun, window: tuple[float, float], angular: bool) -> Chart:
    """Acceleration against the motion without play, forces of both contacts, and the place in the clearance."""
    angle, traces = _within(run, window)
    lift = run.machine.lift
    grid = np.linspace(float(angle[0]), float(angle[-1]), 1441)
    ideal = run.problem.speed**2 * np.asarray(lift.many(np.radians(grid), 2)[2])
    unit, play = ("rad/s²", Axis("Place in the play", "mrad")) if angular else ("m/s²", Axis("Place in the play", "µm"))
    i = int(np.abs(traces["acceleration"]).argmax())
    top = float(traces["acceleration"][i])
    mark = Mark(float(angle[i]), top, f"{number(top)} at {number(float(angle[i]) % 360.0)}°")
    panels = (
        Panel(
            Axis("Acceleration", unit),
            (Series("with play", angle, traces["acceleration"]), Series("without play", grid, ideal)),
            marks=(mark,),
        ),
        Panel(
            Axis("Contact force", "N", zero=True),
            (Series("main contact", angle, traces["main"]), Series("opposite contact", angle, traces["back"])),
        ),
        Panel(play, (Series("deviation", angle, traces["deviation"] * (1e3 if angular else 1e6)),)),
    )
    whole = abs(float(angle[0])) < 1.0 and abs(float(angle[-1]) - 360.0) < 1.0
    axis = CAM_ANGLE if whole else Axis(CAM_ANGLE.label, "°")
    return Chart("The last turn: acceleration, contact forces, and where the follower is in its play", axis, panels)


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
    return Table("The run in numbers", (Column("Quantity"), Column("Value"), Column("Unit")), tuple(rows))
