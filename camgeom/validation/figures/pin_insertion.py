"""S1: Figs. 5 to 9, the loads of Figs. 2 and 3, and the lives over drum, contact length and speed.

The paper's lives follow from '+' in its (11) with 1e8 cycles at the limit (printed: '-' and 1e7), see the entries.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from camgeom.drawing.content import Axis, Block, Chart, Mark, Panel, Series, Zone
from camgeom.drawing.sheet import number
from camgeom.maths import Floats
from camgeom.maths.panels import Panels
from camgeom.mechanics.groove import groove_contact
from camgeom.validation.figures import SourceFigure
from camgeom.validation.machine import machine
from camgeom.validation.pin_insertion import AS_PRINTED, LIFE, NAME, Change, drum, lives, long, smallest_drum

ROLLERS = (10.0, 12.0, 13.0, 16.0, 19.0, 22.0, 26.0)
"""mm, the seven smallest cam followers of IKO's series CF, outside diameters (the paper names 10, 22 and 26)"""
SHOWN = 22.0
"""mm, the roller of the printed numbers"""
TIME = Axis("Time", "s", 0.0, 0.1)
PER_PANEL = 15


def _over_time(panels: Panels, values: Floats) -> tuple[Floats, Floats]:
    """Times of the turn at 600 r/min, s, and a quantity there, with both limits at every panel edge."""
    share = np.linspace(1e-9, 1.0 - 1e-9, PER_PANEL)
    at = (panels.edges[:-1, None] + np.diff(panels.edges)[:, None] * share).ravel()
    return at / machine(NAME).duty.speed, np.asarray(panels.at(values, at))


def motion() -> tuple[Block, ...]:
    """Fig. 5."""
    duty = machine(NAME).duty
    force, speed = duty.force, duty.speed
    rows = (
        (Axis("Lift s", "mm"), force.lift),
        (Axis("Velocity v", "m/s"), 1e-3 * speed * force.ds),
        (Axis("Acceleration a", "m/s²"), 1e-3 * speed**2 * force.dds),
        (Axis("Inertia force I", "N"), force.inertia),
    )
    panels = tuple(Panel(axis, (Series(axis.label, *_over_time(force.panels, y)),)) for axis, y in rows)
    return (Chart("Fig. 5: lift, velocity, acceleration and inertia force over a turn", TIME, panels),)


def loads() -> tuple[Block, ...]:
    """The forces of Figs. 2 and 3, equations (4) to (6), (8) and (16)."""
    duty = machine(NAME).duty
    force = duty.force
    friction = np.broadcast_to(8.3 * force.direction, force.force.shape)
    along = (
        ("inertia I", force.inertia),
        ("friction F1 + F2", friction),
        ("pin hole F3", force.force - force.inertia - friction),
        ("sum Fx", force.force),
    )
    panels = (
        Panel(Axis("Force along the motion", "N"),
              tuple(Series(name, *_over_time(force.panels, y)) for name, y in along), height=1.4),
        Panel(Axis("Normal force Fc", "N", zero=True),
              (Series("normal force", *_over_time(force.panels, np.abs(duty.normal))),)),
    )  # fmt: skip
    return (Chart("Loads of the follower, (4) to (6), (8) and (16)", TIME, panels),)


def pressure() -> tuple[Block, ...]:
    """Fig. 6, by every reading of (11) and on the exact surface."""
    duty = machine(NAME).duty
    force = duty.force
    series = [Series("exact surface", *_over_time(force.panels, _pressure(duty.contact.behind, duty.contact.ahead)))]
    for name, what in AS_PRINTED.items():
        found = groove_contact(force, 67.0, duty.radius, duty.length, duty.roller, duty.cam, name)
        series.append(Series(what, *_over_time(force.panels, _pressure(found.behind, found.ahead))))
    printed = Mark(0.08661, 1168.0, "printed 1168 MPa at 0.08661 s")
    panel = Panel(Axis("Contact pressure", "MPa", zero=True), tuple(series), marks=(printed,), height=1.2)
    return (Chart("Fig. 6: contact pressure over a turn", TIME, (panel,)),)


def _pressure(behind: Floats, ahead: Floats) -> Floats:
    return np.sqrt(np.maximum(np.maximum(behind, ahead), 0.0))


Changes = Callable[[float], tuple[Change, ...]]


def life(
    place: str, axis: Axis, values: Sequence[float], changes: Changes, printed: Sequence[tuple[float, float]],
    zone: Callable[[], tuple[Zone, ...]] = tuple,
) -> tuple[Block, ...]:
    """Life of seven rollers over a measure: by the paper's convention with its printed points, and on the exact flank.

    Where the roller undercuts its flank anywhere there is no groove: the paper's curve is dotted there, ours not drawn.
    """
    papers: list[Series] = []
    ours: list[Series] = []
    x = np.array(values)
    undercut: list[tuple[float, float]] = []
    for style, roller in enumerate(ROLLERS):
        found = [lives(*changes(value), ("roller.diameter", roller)) for value in values]
        claimed = np.array([10.0 * one["published"][LIFE] for one in found])
        true = np.array([one["exact"][LIFE] for one in found])
        sound = np.array([machine(NAME, *changes(v), ("roller.diameter", roller)).flanks[0].margin.value > 0.0
                          for v in values])  # fmt: skip
        name = f"{number(roller)} mm"
        papers.append(Series(name, x, claimed, style))
        undercut += [(v, y) for v, y, whole in zip(values, claimed.tolist(), sound) if not whole]
        if np.count_nonzero(sound) > 1:
            ours.append(Series(name, x[sound], true[sound], style))
    dots = [_dots("undercut: no groove", undercut, 0)] if undercut else []
    dots.append(_dots("printed", printed, 3))
    hours = Axis("Roller life", "h", zero=True)
    zones = zone()
    caption = f"{place}: life by the paper's convention, '+' in (11) and 1e8 cycles at the limit"
    return (
        Chart(caption, axis, (Panel(hours, (*papers, *dots), direct=True, height=1.3),), zones),
        Chart(f"{place}: life on the exact surface, 1e7 cycles at the limit as printed", axis,
              (Panel(hours, tuple(ours), direct=True, height=1.3),), zones),
    )  # fmt: skip


def _dots(name: str, points: Sequence[tuple[float, float]], style: int) -> Series:
    x, y = np.array(points).T
    return Series(name, x, y, style, dots=True)


def _no_groove() -> tuple[Zone, ...]:
    least = smallest_drum(SHOWN).computed
    return (Zone(50.0, least, f"no groove for {number(SHOWN)} mm below {number(least)} mm"),)


def _fast(speed: float) -> tuple[Change, ...]:
    return (("operation.speed", speed),)


FIGURES = (
    SourceFigure("Fig. 5", motion),
    SourceFigure("Figs. 2, 3", loads),
    SourceFigure("Fig. 6", pressure),
    SourceFigure("Fig. 7", partial(life, "Fig. 7", Axis("Drum diameter, its pitch radius the half", "mm", 50.0, 140.0),
                             tuple(np.linspace(50.0, 140.0, 19).tolist()), drum, ((50.0, 22510.0), (140.0, 191341.0)),
                             _no_groove)),
    SourceFigure("Fig. 8", partial(life, "Fig. 8", Axis("Contact length", "mm"),
                             tuple(np.linspace(5.0, 15.0, 11).tolist()),
                             long, ((5.0, 12919.0), (12.0, 178588.0), (15.0, 348804.0)))),
    SourceFigure("Fig. 9", partial(life, "Fig. 9", Axis("Cam speed", "r/min"),
                             tuple(np.linspace(600.0, 1300.0, 15).tolist()),
                             _fast, ((600.0, 178588.0), (1300.0, 801.0)))),
)  # fmt: skip
