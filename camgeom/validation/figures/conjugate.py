"""S5: Figs. 11 to 16, the rocker's motion with and without clearance, forces, clearances and laws; its phase portrait.

Peaks are of the first turn; Figs. 11 and 12 show the second, as the paper shows a turn of stable running.
"""

from __future__ import annotations

from math import degrees, pi

import numpy as np

from camgeom.drawing.content import CAM_ANGLE, Axis, Block, Chart, Mark, Panel, Series
from camgeom.dynamics.impact.run import ImpactRun
from camgeom.maths import Floats
from camgeom.validation.conjugate import CONTACTS, LINE, fixed, impact_run, peak
from camgeom.validation.figures import SourceFigure

LAWS = ("3-4-5", "modified-trapezoid")
CLEARANCES = (0.01, 0.1, 1.0)
"""mm, of Fig. 13"""
SCALE = np.geomspace(0.01, 1.0, 9).tolist()
"""mm, of Fig. 14"""
ACCELERATION = Axis("Angular acceleration", "rad/s²")
NEAR = (25.0, 50.0)
"""deg, about the drive conversion of the rise, which Fig. 11 (d) enlarges"""


def _trace(run: ImpactRun, turn: int) -> tuple[Floats, dict[str, Floats]]:
    """Cam angles of a turn, degrees, and what moves there."""
    flat, period = run.trace.flat(), run.problem.period
    kept = (flat.time >= turn * period) & (flat.time <= (turn + 1) * period)
    names = ("position", "speed", "acceleration", "deviation")
    found = {name: getattr(flat, name)[kept] for name in names}
    found |= {"main": flat.force[kept, 0], "back": flat.force[kept, 1]}
    return np.degrees(flat.angle[kept] - 2.0 * pi * turn), found


def _ideal(run: ImpactRun, order: int) -> tuple[Floats, Floats]:
    """Cam angles, degrees, and a derivative of the ideal motion, rad/s^order."""
    angle = np.linspace(0.0, 360.0, 2881)
    return angle, run.problem.speed**order * np.asarray(run.machine.lift.many(np.radians(angle), 2)[order])


def motion() -> tuple[Block, ...]:
    """Fig. 11, the second turn with 0.1 mm of clearance and the ideal one; (d) enlarged."""
    run = impact_run()
    angle, found = _trace(run, 1)
    rows = (("position", Axis("Angle", "°"), degrees(1.0)), ("speed", Axis("Angular speed", "rad/s"), 1.0),
            ("acceleration", ACCELERATION, 1.0))  # fmt: skip
    panels = []
    for order, (name, axis, unit) in enumerate(rows):
        x, y = _ideal(run, order)
        lines = (Series("clearance 0.1 mm", angle, unit * found[name]), Series("ideal", x, unit * y))
        panels.append(Panel(axis, lines))
    x, y = _ideal(run, 2)
    kept, near = ((values >= NEAR[0]) & (values <= NEAR[1]) for values in (angle, x))
    lines = (Series("clearance 0.1 mm", angle[kept], found["acceleration"][kept]), Series("ideal", x[near], y[near]))
    zoom = Axis("Cam angle", "°", *NEAR)
    return (Chart("Fig. 11: the rocker with clearance and without", CAM_ANGLE, tuple(panels)),
            Chart("Fig. 11 (d): where the drive passes over in the rise", zoom, (Panel(ACCELERATION, lines),)))


def forces() -> tuple[Block, ...]:
    """Fig. 12."""
    angle, found = _trace(impact_run(), 1)
    lines = (Series("main cam", angle, found["main"]), Series("return cam", angle, found["back"]))
    return (Chart("Fig. 12: contact forces, clearance 0.1 mm", CAM_ANGLE,
                  (Panel(Axis("Contact force", "N", zero=True), lines, height=1.2),)),)


def clearances() -> tuple[Block, ...]:
    """Fig. 13, the first turn of three clearances."""
    panels = []
    for clearance in CLEARANCES:
        angle, found = _trace(impact_run(clearance=clearance), 0)
        panels.append(Panel(Axis(f"{ACCELERATION.label}, {clearance:g} mm", "rad/s²"),
                            (Series("acceleration", angle, found["acceleration"]),)))  # fmt: skip
    return (Chart("Fig. 13: acceleration for three clearances, first turn", CAM_ANGLE, tuple(panels)),)


def growth() -> tuple[Block, ...]:
    """Fig. 14 for every contact law that was tried, over the peak at 0.01 mm; the printed growth as points."""
    x = np.array(SCALE)
    lines = []
    for contact in CONTACTS:
        peaks = np.array([peak(contact, clearance) for clearance in SCALE])
        lines.append(Series(contact, x, peaks / peaks[0]))
    told = (Mark(0.1, 2.0, "printed: 2 times"), Mark(1.0, 12.0, "printed: 6 times that at 0.1 mm"))
    panel = Panel(Axis("Peak acceleration over that at 0.01 mm", "", zero=True), tuple(lines), marks=told, height=1.2)
    return (Chart("Fig. 14: peak acceleration over the clearance, first turn", Axis("Clearance", "mm"), (panel,)),)


def laws() -> tuple[Block, ...]:
    """Fig. 15, the ideal acceleration of both laws."""
    lines = tuple(Series(law, *_ideal(impact_run(law=law), 2)) for law in LAWS)
    return (Chart("Fig. 15: ideal acceleration of both laws", CAM_ANGLE, (Panel(ACCELERATION, lines, height=1.2),)),)


def laws_with_clearance() -> tuple[Block, ...]:
    """Fig. 16, acceleration and forces of both laws with 0.01 mm of clearance."""
    rows: tuple[tuple[str, Axis], ...] = (
        ("acceleration", ACCELERATION), ("back", Axis("Force of the return cam", "N", zero=True)),
        ("main", Axis("Force of the main cam", "N", zero=True)),
    )  # fmt: skip
    traces = {law: _trace(impact_run(LINE, 0.01, law), 1) for law in LAWS}
    panels = (Panel(axis, tuple(Series(law, angle, found[name]) for law, (angle, found) in traces.items()))
              for name, axis in rows)  # fmt: skip
    return (Chart("Fig. 16: both laws with a clearance of 0.01 mm", CAM_ANGLE, tuple(panels)),)


def portrait() -> tuple[Block, ...]:
    """Deviation and its rate: where the follower is in its play, the turns of 0.1 mm over each other."""
    run = impact_run()
    lines = []
    for turn in range(len(run.turn_times())):
        angle, found = _trace(run, turn)
        rate = found["speed"] - run.problem.speed * np.asarray(run.machine.lift.many(np.radians(angle), 1)[1])
        lines.append(Series(f"turn {turn + 1}", 1e3 * found["deviation"], rate))
    panel = Panel(Axis("Its rate", "rad/s"), tuple(lines), height=1.6)
    return (Chart("Phase portrait: place in the play of 0.1 mm and its rate", Axis("Deviation", "mrad"), (panel,)),)


def fixed_steps() -> tuple[Block, ...]:
    """Fig. 10, the paper's method, against the solver by events: the rise and the return of the first turn."""
    run, panels = impact_run(), []
    steps = fixed()
    angle, found = _trace(run, 0)
    kept = angle <= 140.0
    at = np.degrees(run.problem.speed * steps.time)
    rows: tuple[tuple[Axis, Floats, str], ...] = (
        (ACCELERATION, steps.acceleration[:, 0], "acceleration"),
        (Axis("Force of the main cam", "N", zero=True), steps.force_main[:, 0], "main"),
    )
    for axis, values, name in rows:
        lines = (Series("by events", angle[kept], found[name][kept]), Series("steps of 1e-5 s", at, values))
        panels.append(Panel(axis, lines))
    return (Chart("Fig. 10: Runge-Kutta of fixed steps, as in the paper, and the solver by events, 0.1 mm",
                  Axis("Cam angle", "°", 0.0, 140.0), tuple(panels)),)  # fmt: skip


FIGURES = (
    SourceFigure("Fig. 10", fixed_steps),
    SourceFigure("Fig. 11", motion),
    SourceFigure("Fig. 12", forces),
    SourceFigure("Fig. 13", clearances),
    SourceFigure("Fig. 14", growth),
    SourceFigure("Fig. 15", laws),
    SourceFigure("Fig. 16", laws_with_clearance),
    SourceFigure("Phase portrait", portrait),
)
