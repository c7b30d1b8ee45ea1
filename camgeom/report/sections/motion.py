"""Motion diagrams with their values, the segments, continuity; and what every diagram over the turn shares."""

from __future__ import annotations

import re
from math import degrees, pi
from typing import TYPE_CHECKING, Any

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
from camgeom.drawing.sheet import number
from camgeom.maths import Floats

if TYPE_CHECKING:
    from camgeom.dynamics.linear.response import Response
    from camgeom.maths.panels import Panels
    from camgeom.model import Model
    from camgeom.motion.program import Program
    from camgeom.track.carriage import Carriage

PER_PANEL, HAIR = 25, 1e-9
NOTHING = 1e-9


def over_turn(panels: Panels, values: Floats) -> tuple[Floats, Floats]:
    """Cam angles (k,), degrees, and a panel quantity (p, n) there, with both limits at every panel edge."""
    share = np.linspace(HAIR, 1.0 - HAIR, PER_PANEL)
    at = panels.edges[:-1, None] + np.diff(panels.edges)[:, None] * share
    return np.degrees(at).ravel(), np.asarray(panels.at(values, at.ravel()))


def one_turn(response: Response[Any]) -> tuple[Floats, Floats]:
    """The last turn of a response: cam angles as it counts them, rad, and from zero, degrees; each (n,)."""
    last = float(response.theta[-1])
    theta = np.linspace(last - 2.0 * pi, last, 1081)[:-1]
    return theta, np.degrees(theta - theta[0])


def extremes(panels: Panels, values: Floats, factor: float = 1.0) -> tuple[Mark, ...]:
    """The refined largest and smallest value of a panel quantity, where they are not zero."""
    from camgeom.maths.panels import highest

    marks = []
    for sign in (1.0, -1.0):
        peak, at = (float(found) for found in highest(panels, sign * values))
        value = sign * factor * peak
        if sign * value > NOTHING:
            marks.append(mark(degrees(at), value))
    return tuple(marks)


def mark(angle: float, value: float, unit: str = "") -> Mark:
    """A point at a cam angle, degrees, with its value and angle in words."""
    angle = round(angle, 9) + 0.0
    return Mark(angle, value, f"{number(value)}{unit} at {number(angle)}°")


def at_speed(rpm: float) -> tuple[Limit, ...]:
    """The working speed, r/min, as a line over the cam speed."""
    return (Limit(rpm, f"{number(rpm)} r/min", vertical=True),)


def pressure_limit(model: Model, top: float) -> tuple[Limit, ...]:
    """The contact limit, MPa, as a line where the largest pressure comes near it; else nothing."""
    limit = model.pressure_limit
    return (Limit(limit, f"limit {number(limit)} MPa"),) if top > 0.5 * limit else ()


PER_TURN = 720
WORDS = ("lift", "velocity", "acceleration", "jerk")


def motion(model: Model) -> tuple[Block, ...]:
    """The s, v, a, j diagrams over one turn and the table of segments."""
    best = best_laws(model)
    told = () if best is None else (best,)
    return diagrams(model), segments(model), *told, Text((continuity(model.setup.program),))


def samples(program: Program) -> tuple[Floats, Floats]:
    """Cam angles (n,), rad, and the jets (4, n) there; each knot twice, with the limits of both sides."""
    angles, jets = [], []
    for low, high in zip(program.knots[:-1], program.knots[1:]):
        count = max(3, int(np.ceil(PER_TURN * (high - low) / (2.0 * pi))) + 1)
        theta = np.linspace(low, high, count)
        jet = program.jet(theta, 3, side="right")
        jet[:, -1:] = program.jet(theta[-1:], 3, side="left")
        angles.append(theta)
        jets.append(jet)
    return np.concatenate(angles), np.concatenate(jets, axis=1)


def zones(program: Program) -> tuple[Zone, ...]:
    """The dwells as shaded ranges of cam angle."""
    still = [span for span in program.spans if span.law == "dwell"]
    return tuple(Zone(degrees(span.start), degrees(span.end), "dwell") for span in still)


def units(model: Model) -> tuple[tuple[Axis, ...], tuple[float, ...]]:
    """Axes of lift and its derivatives, and the factors from mm (rad) per rad^k: in time where the speed is known."""
    rotating, speed = model.profile.rotating, model.profile.fastest
    lift = Axis("Position" if rotating else "Lift s", "°" if rotating else "mm")
    one = 180.0 / pi if rotating else 1.0
    words = ("Velocity v", "Acceleration a", "Jerk j")
    if speed is None:
        unit = "°" if rotating else "mm"
        per = (f"{unit}/rad", f"{unit}/rad²", f"{unit}/rad³")
        return (lift, *(Axis(w, u) for w, u in zip(words, per))), (one,) * 4
    omega = speed * pi / 30.0
    scale, unit = (1.0, "rad") if rotating else (1e-3, "m")
    per = (f"{unit}/s", f"{unit}/s²", f"{unit}/s³")
    return (lift, *(Axis(w, u) for w, u in zip(words, per))), (one, *(scale * omega**k for k in (1, 2, 3)))


def diagrams(model: Model) -> Chart:
    """Lift, velocity, acceleration and jerk over the cam angle with their extremes."""
    program = model.setup.program
    theta, jets = samples(program)
    angle = np.degrees(theta)
    axes, factors = units(model)
    panels = []
    for order, (axis, factor, row) in enumerate(zip(axes, factors, jets)):
        y = factor * row
        marks = _extremes(program, order, factor, angle, y)
        panels.append(Panel(axis, (Series(axis.label, angle, y),), marks=marks, height=1.0))
    if (carriage := model.mechanism.carriage) is not None:
        panels.append(Panel(Axis("Travel of the plate x", "mm"), (Series("travel", angle, carriage.travel(theta)),)))
    speed = model.profile.fastest
    caption = "Motion over one turn" + (f" at {number(speed)} r/min" if speed else ", per radian of cam angle")
    return Chart(caption, CAM_ANGLE, tuple(panels), zones(program))


def _extremes(program: Program, order: int, factor: float, angle: Floats, y: Floats) -> tuple[Mark, ...]:
    """The largest and the smallest value; the extreme of a derivative is the refined one."""
    high, low = int(np.argmax(y)), int(np.argmin(y))
    spots = [(float(angle[high]), float(y[high]))]
    if order and y[low] < -1e-9 * abs(y[high]):
        spots.append((float(angle[low]), float(y[low])))
    if order:
        peak = program.peak(order)
        exact = (degrees(peak.at), factor * peak.value)
        which = 0 if exact[1] > 0.0 or len(spots) == 1 else 1
        spots[which] = exact
    return tuple(Mark(x, v, f"{number(v)} at {number(x)}°") for x, v in spots)


KNOT = 1e-9
"""rad; samples so near to a knot are at it"""


def segments(model: Model) -> Table:
    """Each segment, by its path in the profile, with its law and the largest velocity and acceleration in it."""
    program = model.setup.program
    theta, jets = samples(program)
    axes, factors = units(model)
    rows: list[tuple[Cell, ...]] = []
    stated, carriage = len(model.profile.motion), model.mechanism.carriage
    for i, span in enumerate(program.spans):
        # At a knot the last sample is of what follows it, the first of what precedes: both ends are the segment's own.
        low, high = np.searchsorted(theta, (span.start + KNOT, span.end - KNOT))
        peaks = [factors[k] * float(np.abs(jets[k, low - 1 : high + 1]).max()) for k in (1, 2)]
        law = re.sub(r"(?<=[a-z])-|-(?=[a-z])", " ", span.law)
        ends = (factors[0] * span.before, factors[0] * span.after)
        name = f"motion[{i}]" if i < stated else f"mirror of motion[{i - stated}]"
        if carriage is not None:
            name = _over_travel(carriage, stated, 0.5 * (span.start + span.end))
        rows.append((name, degrees(span.start), degrees(span.end), law, *ends, *peaks))
    unit = axes[0].unit
    columns = (
        Column("Segment"), Column("From", "°"), Column("Until", "°"), Column("Law"), Column("From", unit),
        Column("To", unit), Column("Peak v", axes[1].unit), Column("Peak a", axes[2].unit),
    )  # fmt: skip
    return Table("Segments of the motion", columns, tuple(rows))


def _over_travel(carriage: Carriage, stated: int, theta: float) -> str:
    """The segment of a plate's travel at an angle of its drive, and which way it is run."""
    travel = float(carriage.travel(np.array([theta]))[0]) * 2.0 * pi / carriage.stroke
    number = min(sum(travel > span.end for span in carriage.path.spans), stated - 1)
    return f"motion[{number}], {'out' if theta < carriage.turned else 'back'}"


def best_laws(model: Model) -> Table | None:
    """What the best laws reach, and the bound that no law of their class can go below; None where there is none."""
    program = model.setup.program
    rows: list[tuple[Cell, ...]] = []
    for i, found in program.best_laws:
        if i < len(model.profile.motion):
            peaks = [found.peaks.get(name) for name in ("velocity", "acceleration", "jerk", "residual")]
            shown = [None if value is None or not np.isfinite(value) else value for value in peaks]
            aim = found.wish.aim.replace("-", " ")
            rows.append((f"motion[{i}]", aim, found.value, found.bound, *shown, found.holds_for))
    heads = ("Segment", "Least", "Value", "Lower bound", "Velocity", "Acceleration", "Jerk", "Residual", "Bound for")
    columns = tuple(Column(head) for head in heads)
    return Table(f"Best laws, peaks for {program.best_over}", columns, tuple(rows)) if rows else None


def continuity(program: Program) -> str:
    """A sentence on what is continuous round the cam and where it is not."""
    found = program.continuity
    if found.order < 0:
        text = "The lift itself jumps."
    else:
        text = f"Lift and its derivatives are continuous up to the {WORDS[min(found.order, 3)]}."
    if found.jumps:
        order = min(jump.order for jump in found.jumps)
        places = [f"{degrees(j.angle):.6g}°" for j in found.jumps if j.order == order]
        more = f" and {len(places) - 8} more places" if len(places) > 8 else ""
        text += f" The {WORDS[order]} jumps at {', '.join(places[:8])}{more}."
    return text
