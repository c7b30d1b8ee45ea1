"""S1: the groove cam of a pin-insertion machine and the fatigue life of its roller.

The printed formulas do not give the printed figures. The exact surface is ours; the conventions of `mechanics.groove`
are the readings: "-" in (11) as printed, "+", a flat wall, the wall of the developed plane.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from math import degrees, pi

import numpy as np

from camgeom.errors import DesignError
from camgeom.maths import Floats
from camgeom.maths.panels import panels, roots
from camgeom.mechanics.groove import Convention, pitch_curvature, relative_curvature
from camgeom.mechanics.roller_duty import RollerDuty
from camgeom.validation.entry import Answer, Entry, Reading, Source
from camgeom.validation.machine import machine

NAME = "pin_insertion"
PRESSURE, ANGLE, LIFE = range(3)
"""places of the figures of a convention"""
AS_PRINTED: dict[Convention, str] = {
    "developed": "(11) as printed, '-'",
    "published": "(11) with '+'",
    "flat": "flat wall, 1/r alone",
    "developed-wall": "true wall of the developed plane",
}
Change = tuple[str, float]


def drum(diameter: float) -> tuple[Change, ...]:
    """The drum with the pitch radius on its outside, as the paper takes it; mm."""
    return (("cam.diameter", diameter), ("cam.pitch_radius", 0.5 * diameter))


def long(length: float) -> tuple[Change, ...]:
    return (("roller.length", length), ("cam.groove_depth", length + 1.0))


@cache
def lives(*changes: Change) -> dict[str, tuple[float, float, float]]:
    """Peak pressure, MPa, its cam angle, deg, and roller life, h, by convention; life 0 of an undercut wall."""
    radius = dict(changes).get("cam.pitch_radius", 67.0)
    found = machine(NAME, *changes).duty.conventions(radius)
    return {name: (float(p.pressure), degrees(float(p.theta)), float(life.life_h)) for name, (p, life) in found.items()}


def _figure(which: int, *changes: Change) -> Answer:
    figures = lives(*changes)
    readings = [Reading(text, figures[name][which]) for name, text in AS_PRINTED.items()]
    if which == LIFE:
        readings.append(Reading("'+' with 1e8 cycles at the limit", 10.0 * figures["published"][LIFE]))
    return Answer(figures["exact"][which], tuple(readings))


def _life_ratio(over: tuple[Change, ...], under: tuple[Change, ...], scale: float = 1.0, less: float = 0.0) -> Answer:
    """Life of one machine over that of another, times `scale`, less `less`; where the latter's walls exist."""
    high, low = lives(*over), lives(*under)
    ratios = {k: scale * high[k][LIFE] / low[k][LIFE] - less for k in high if low[k][LIFE] > 0.0}
    readings = tuple(Reading(text, ratios[k]) for k, text in AS_PRINTED.items() if k in ratios)
    # Without a flank of the smaller drum there is no exact life to grow from: 0 stands for it.
    return Answer(ratios.get("exact", 0.0), readings)


def _program(angle: float, order: int) -> float:
    return float(machine(NAME).mechanism.program.jet(np.array([angle]), 2)[order][0])


def _margin(diameter: float, roller: float) -> Answer:
    """Least undercut margin along the roller on a drum of a diameter, mm."""
    return Answer(machine(NAME, *drum(diameter), ("roller.diameter", roller)).flanks[0].margin.value)


def smallest_drum(roller: float) -> Answer:
    """Smallest drum, mm, whose groove for a roller is not undercut anywhere, by bisection."""
    low, high = 50.0, 140.0
    while high - low > 1e-6:
        middle = 0.5 * (low + high)
        try:
            sound = machine(NAME, *drum(middle), ("roller.diameter", roller)).flanks[0].margin.value > 0.0
        except DesignError:
            sound = False
        low, high = (low, middle) if sound else (middle, high)
    return Answer(high)


Form = Callable[[RollerDuty], Floats]


def _over_turn(ours: Form, printed: Form, corrected: tuple[tuple[str, Form], ...] = ()) -> Answer:
    """An equation over the turn: both forms where they differ most, or, by rounding alone, farthest from the start's.

    A corrected form is as good as its largest deviation from ours anywhere, which is put on its value.
    """
    duty = machine(NAME).duty
    exact, given = ours(duty), printed(duty)
    off, moved = np.abs(given - exact), np.abs(exact - exact.flat[0])
    at = np.unravel_index(int(np.argmax(off if off.max() > 1e-12 * np.abs(exact).max() else moved)), exact.shape)
    value = float(exact[at])
    readings = tuple(Reading(what, value + float(np.abs(form(duty) - exact).max())) for what, form in corrected)
    return Answer(value, readings, float(given[at]))


def _wall_curvature(convention: Convention, duty: RollerDuty) -> Floats:
    """Relative curvature of the loaded wall, 1/mm, in the closed form of a convention."""
    force = duty.force
    behind, ahead = (
        relative_curvature(convention, wall, duty.radius, 67.0, force.ds, force.dds) for wall in ("behind", "ahead")
    )
    return np.where(duty.normal >= 0.0, behind, ahead)


def _surface_curvature(duty: RollerDuty) -> Floats:
    """Relative curvature of the loaded wall, 1/mm, from the flank itself."""
    return duty.quoted.curvature


def _resistance(duty: RollerDuty) -> Floats:
    """Force on the follower by (4) to (6) and (16) as printed, N."""
    force, phi = duty.force, duty.force.panels.theta
    inertia = 1e-3 * (1.25 + 1.00) * duty.speed**2 * force.dds
    pin = 79.55 * ((56 * pi - 36 * phi) / (13 * pi) + np.sin((72 * phi - 86 * pi) / 13) / (2 * pi))
    inserting = (phi >= 4.456) & (phi <= 14 * pi / 9)
    return inertia + 8.3 * force.direction + np.where(inserting, pin, 0.0)


def _convex_share() -> Answer:
    """Share of the turn, %, over which the loaded wall is convex."""
    duty = machine(NAME).duty
    force = duty.force
    changes = [roots(force.panels, value[None], 1e-9 * float(np.abs(value).max()))[0]
               for value in (force.force, force.dds)]
    # Between the changes of force and of curvature the wall is of one kind, so the share is exact.
    force = duty.load.sampled(panels(np.concatenate([force.panels.edges, *changes]), np.inf))
    bend = pitch_curvature(67.0, force.ds, force.dds) * np.sign(force.force)
    convex = np.where(bend < -1e-12, 1.0, 0.0)
    return Answer(100.0 * float(force.panels.integral(convex)) / (2.0 * pi))


def _path(duty: RollerDuty) -> Floats:
    return np.array([float(duty.roller_life.path)])


def _printed_path(duty: RollerDuty) -> Floats:
    rate = np.sqrt(67.0**2 + duty.force.ds**2)
    return np.array([float(duty.force.panels.integral(rate))])


def _life_of_damage(duty: RollerDuty) -> Floats:
    return np.array([1.0 / (60.0 * 600.0 * float(duty.roller_life.damage))])


_LIFE_WHY = (
    "Absolute lives follow from no reading; they are 9.6 to 10.5 times those of '+', as if the cycles at the limit "
    "were about 1e8 (printed: 1e7)."
)
_CONVEX_WHY = "Text and (11) take the difference, '-', for a concave wall; the printed trends follow the sum, '+'."
_SMALL_WHY = (
    "A drum of 50 mm with a stroke of 74 mm has no groove: its flank folds for every roller from 10 to 26 mm, and (11) "
    "with '-' is then negative, so there is no life (0 stands for it). '+' stays positive and hides it."
)

SOURCE = Source(
    "S1",
    "pin-insertion",
    "Groove cam of a pin-insertion machine, roller fatigue",
    "Journal of Zhengzhou University (Engineering Science) 2023, doi 10.13705/j.issn.1671-6833.2023.01.017",
    (
        Entry("lift-1", "Table 1", "lift at 43 pi/36", "0.037", "m",
              lambda: Answer(1e-3 * _program(43 * pi / 36, 0))),
        Entry("lift-2", "Table 1", "lift at 14 pi/9", "0.074", "m",
              lambda: Answer(1e-3 * _program(14 * pi / 9, 0))),
        Entry("rest-1", "Table 1", "velocity at 43 pi/36, between the two rises", "0", "m/s",
              lambda: Answer(1e-3 * 20 * pi * _program(43 * pi / 36, 1)), within=1e-9),
        Entry("rest-2", "Table 1", "acceleration at 43 pi/36", "0", "m/s2",
              lambda: Answer(1e-3 * (20 * pi) ** 2 * _program(43 * pi / 36, 2)), within=1e-9),
        Entry("(3) (4)", "Equations (3), (4)", "inertia force, over the turn", "", "N",
              partial(_over_turn, lambda d: d.force.inertia,
                      lambda d: 1e-3 * 2.25 * (20 * pi) ** 2 * d.force.dds)),
        Entry("(5) (6) (16)", "Equations (5), (6), (16)", "force on the follower, over the turn", "", "N",
              partial(_over_turn, lambda d: d.force.force, _resistance),
              "The force of the pin hole falls to nothing while the pin goes in; a friction would grow."),
        Entry("(7)", "Equation (7)", "cosine of the pressure angle at the pitch radius", "", "1",
              partial(_over_turn, lambda d: d.quoted.reference.cosine,
                      lambda d: np.cos(np.arctan(np.abs(d.force.ds) / 67.0)))),
        Entry("(8)", "Equation (8)", "normal force", "", "N",
              partial(_over_turn, lambda d: np.abs(d.quoted.normal),
                      lambda d: np.abs(d.force.force) * np.hypot(67.0, d.force.ds) / 67.0)),
        Entry("(9)", "Equation (9)", "speed of the roller's centre along the groove", "", "mm/s",
              partial(_over_turn, lambda d: d.speed * d.quoted.path_rate,
                      lambda d: d.speed * np.hypot(67.0, d.force.ds))),
        Entry("(10) (11)", "Equations (10), (11)", "relative curvature of roller and loaded wall", "", "1/mm",
              partial(_over_turn, _surface_curvature, partial(_wall_curvature, "developed"),
                      (("wall rho + r of the developed plane", partial(_wall_curvature, "developed-wall")),
                       ("offset of the pitch surface, (1 + r2 w2)/(r (1 + r k - r2 w2)), k its curvature, w = s'/(R2 + "
                        "s'2) its twist", partial(_wall_curvature, "exact")))),
              "(10) is the radius of the roller centre's path; the wall stands a roller radius beside it and is "
              "twisted."),
        Entry("(12)", "Equation (12)", "path that the roller rolls in a turn", "", "mm",
              partial(_over_turn, _path, _printed_path)),
        Entry("(14) (15)", "Equations (14), (15)", "life from the damage of a turn at the worst point", "", "h",
              partial(_over_turn, lambda d: np.array([float(d.roller_life.life_h)]), _life_of_damage)),
        Entry("concave", "below (11)", "share of the turn with the loaded wall convex; 'always concave'", "0", "%",
              _convex_share, "Friction and the pin hold the roller against the convex wall near the ends of each "
              "stroke.", within=1e-6),
        Entry("time", "Section 2.2", "cam angle of 0.08661 s at 600 r/min; printed 311 deg 48'", "311.80", "deg",
              lambda: Answer(360.0 * 10.0 * 0.08661), within=0.018),
        Entry("peak-pressure", "Fig. 6", "largest contact pressure", "1168", "MPa",
              partial(_figure, PRESSURE), _CONVEX_WHY),
        Entry("peak-angle", "Fig. 6", "cam angle of the largest contact pressure", "311.80", "deg",
              partial(_figure, ANGLE), "No reading peaks there; a flat wall comes nearest.", within=0.018),
        Entry("life", "Fig. 9", "roller life at 600 r/min", "178588", "h", partial(_figure, LIFE), _LIFE_WHY),
        Entry("life-drum-50", "Fig. 7", "roller life, drum of 50 mm", "22510", "h",
              partial(_figure, LIFE, *drum(50.0)), _SMALL_WHY),
        Entry("life-drum-140", "Fig. 7", "roller life, drum of 140 mm", "191341", "h",
              partial(_figure, LIFE, *drum(140.0)), _LIFE_WHY),
        Entry("life-length-5", "Fig. 8", "roller life, contact length 5 mm", "12919", "h",
              partial(_figure, LIFE, *long(5.0)), _LIFE_WHY),
        Entry("life-length-15", "Fig. 8", "roller life, contact length 15 mm", "348804", "h",
              partial(_figure, LIFE, *long(15.0)), _LIFE_WHY),
        Entry("life-speed-1300", "Fig. 9", "roller life at 1300 r/min", "801", "h",
              partial(_figure, LIFE, ("operation.speed", 1300.0)), _LIFE_WHY),
        Entry("trend-length", "Abstract, Fig. 8", "life of 15 mm over that of 5 mm contact length, '26.0 times more'",
              "27.0", "1", partial(_life_ratio, long(15.0), long(5.0)),
              "The third power of the length: p goes with its root, damage with p to the sixth."),
        Entry("trend-length-12", "Figs. 8, 9", "178588 h of 12 mm over 12919 h of 5 mm", "13.8237", "1",
              partial(_life_ratio, (), long(5.0)), "The printed lives agree among themselves.", within=6e-4),
        Entry("trend-roller", "Abstract, Fig. 7", "life of a roller of 26 mm over that of 10 mm, '14.1 times more'",
              "15.1", "1", partial(_life_ratio, (("roller.diameter", 26.0),), (("roller.diameter", 10.0),)),
              _CONVEX_WHY),
        Entry("trend-drum", "Abstract, Fig. 7", "life on a drum of 140 mm over that on 50 mm, '7.5 times more'", "8.5",
              "1", partial(_life_ratio, drum(140.0), drum(50.0)), _SMALL_WHY),
        Entry("trend-drum-134", "Figs. 7, 9", "191341 h on 140 mm over 178588 h on 134 mm", "1.07141", "1",
              partial(_life_ratio, drum(140.0), ()), "No reading grows so little.", within=5e-6),
        Entry("trend-speed", "Abstract, Fig. 9", "life at 1300 r/min over that at 600, of the lives 801 h and 178588 h",
              "0.44852", "%", partial(_life_ratio, (("operation.speed", 1300.0),), (), 100.0),
              f"{_CONVEX_WHY} Rounded to 0.449 in the text; '+' rounds to 0.448.", within=2.9e-4),
        Entry("undercut-50", "Fig. 7", "undercut margin of the groove on a drum of 50 mm, roller 22 mm", "0", "1",
              partial(_margin, 50.0, 22.0), _SMALL_WHY, ">"),
        Entry("undercut-50-10", "Fig. 7", "undercut margin of the groove on a drum of 50 mm, roller 10 mm", "0", "1",
              partial(_margin, 50.0, 10.0), _SMALL_WHY, ">"),
        Entry("smallest-drum", "Fig. 7", "smallest drum with a groove for the 22 mm roller; drawn from 50 mm on", "50",
              "mm", partial(smallest_drum, 22.0), "All drums below are undercut: the left part of Fig. 7 is of cams "
              "that do not exist."),
    ),
)  # fmt: skip
