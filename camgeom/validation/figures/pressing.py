"""S2: Figs. 3 to 5, the profile and the motion by theory and simulated with contact."""

from __future__ import annotations

from math import pi

import numpy as np

from camgeom.drawing.content import Axis, Block, Chart, Mark, Panel, Polar, Series
from camgeom.maths import Floats
from camgeom.validation.figures import SourceFigure
from camgeom.validation.machine import machine
from camgeom.validation.pressing import NAME

TIME = Axis("Time", "s", 0.0, 1.0)
ROWS = (Axis("Lift s", "mm"), Axis("Velocity v", "mm/s"), Axis("Acceleration a", "m/s²"))
PLAYS = (0.001, 0.02)
"""mm, of the frame: none is printed"""
SPEED = 2.0 * pi
"""rad/s, 60 cycles a minute"""


def profile() -> tuple[Block, ...]:
    """Fig. 3, of the base radius and stroke that are not printed."""
    (outline,) = machine(NAME).mechanism.outlines.values()
    x, y = outline.curve(np.linspace(0.0, 2.0 * pi, 1441)).points
    line = Series("profile", np.degrees(np.unwrap(np.arctan2(y, x))), np.hypot(x, y))
    return (Polar("Fig. 3: profile, base radius 40 and stroke 30 mm", Axis("Radius", "mm"), (line,)),)


def ideal() -> tuple[Floats, list[Floats]]:
    """Times, s, and lift, mm, velocity, mm/s, acceleration, m/s², of the motion; both limits at every knot."""
    program = machine(NAME).mechanism.program
    pieces = [np.linspace(a, b, 181) for a, b in zip(program.knots[:-1], program.knots[1:])]
    jets = [program.jet(np.clip(p, p[0] + 1e-12, p[-1] - 1e-12), 2) for p in pieces]
    s, v, a = np.concatenate(jets, axis=1)
    return np.concatenate(pieces) / SPEED, [s, SPEED * v, 1e-3 * SPEED**2 * a]


def theory() -> tuple[Block, ...]:
    """Fig. 4."""
    time, values = ideal()
    panels = tuple(Panel(axis, (Series(axis.label, time, y),)) for axis, y in zip(ROWS, values))
    return (Chart("Fig. 4: motion of the frame by theory", TIME, panels),)


def simulated() -> tuple[Block, ...]:
    """Fig. 5 over the second turn, for two plays, with the theory beside it and the printed numbers."""
    time, values = ideal()
    lines = [[Series("theory", time, y)] for y in values]
    for play in PLAYS:
        run = machine(NAME, ("follower.clearance", play)).impact
        assert run is not None
        trace, period = run.trace.flat(), run.problem.period
        kept = (trace.time >= period) & (trace.time <= 2.0 * period)
        found = (1e3 * trace.position, 1e3 * trace.speed, trace.acceleration)
        for line, y in zip(lines, found):
            line.append(Series(f"with contact, play {play:g} mm", trace.time[kept] - period, y[kept]))
    marks: tuple[tuple[Mark, ...], ...] = (
        (), (Mark(70.0 / 360.0, 120.341, "printed 120.341 mm/s"),), (Mark(0.0, 1.251, "printed 1.251 m/s²"),),
    )  # fmt: skip
    panels = tuple(Panel(axis, tuple(line), marks=m, height=1.2) for axis, line, m in zip(ROWS, lines, marks))
    return (Chart("Fig. 5: motion of the frame simulated with contact", TIME, panels),)


FIGURES = (SourceFigure("Fig. 3", profile), SourceFigure("Fig. 4", theory), SourceFigure("Fig. 5", simulated))
