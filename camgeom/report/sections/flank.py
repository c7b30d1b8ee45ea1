"""Pressure angle, curvature and undercut margin: of the flanks as lines and maps, of a planar cam along its profile."""

from __future__ import annotations

from collections.abc import Callable
from math import degrees, pi
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
    Map,
    Mark,
    Panel,
    Series,
    Table,
    Text,
)
from camgeom.drawing.sheet import number
from camgeom.maths import Floats, distinct
from camgeom.report.sections.motion import mark, zones
from camgeom.track.flank import Flank
from camgeom.track.survey import FLANKS

if TYPE_CHECKING:
    from camgeom.maths.extremum import Extreme
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
ACROSS, ALONG = 361, 21
"""cells of a map"""


def flank(model: Model) -> tuple[Block, ...]:
    """Extremes of every track, lines at three stations, and maps of the first track; of planar cams the profile."""
    folded = [survey for survey in model.flanks if survey.margin.value <= 0.0]
    if folded:
        return _folded(model, folded)
    if model.profiles is not None:
        blocks = (*profile(model, model.profiles), *_crowned(model))
        return blocks if model.planar is not None else (*blocks, *maps(model.flanks[0]))
    if not model.flanks:
        return ()
    first = model.flanks[0]
    found: list[Block] = [extremes(model), lines(model, first)]
    if len(model.flanks) > 1:
        same = f"The plots show the track {first.track.name!r}; the table covers all {len(model.flanks)}."
        found.insert(1, Text((same,)))
    return (*found, *_crowned(model), *maps(first))


def _crowned(model: Model) -> tuple[Block, ...]:
    """What meets the crown of a crowned roller."""
    words = {
        "straight": "The flank is straight along the roller, as a cylinder grinds it: the crown meets it in a point.",
        "conforming": "The flank is the envelope of the roller's crown: a tool of the same meridian cuts it.",
    }
    crown = model.mechanism.crown
    return (Text((words[crown],)),) if crown else ()


def _folded(model: Model, folded: list[Survey]) -> tuple[Block, ...]:
    """What can be said of an undercut cam: where the flank folds, and the pressure angle, which stays finite."""
    rows = [_row(survey, "least undercut margin 1 − rκ", survey.margin, "", float) for survey in folded]
    text = "The flank folds back on itself, so it has no curvature there and no contact can be computed."
    return Text((text,)), Table("Undercut tracks", _COLUMNS, tuple(rows)), lines(model, model.flanks[0], curved=False)


def extremes(model: Model) -> Table:
    """Largest pressure angle, sharpest relative curvature and least undercut margin of every track."""
    rows = []
    for survey in model.flanks:
        rows += [
            _row(survey, "largest pressure angle", survey.pressure_angle, "°", degrees),
            _row(survey, "largest pressure angle at the roller axis", survey.axis_pressure_angle, "°", degrees),
            _row(survey, "largest relative curvature", survey.largest_relative_curvature, "1/mm", float),
            _row(survey, "least relative curvature", survey.relative_curvature, "1/mm", float),
            _row(survey, "least undercut margin 1 − rκ", survey.margin, "", float),
        ]
    return Table("Extremes of the flanks, refined beyond the samples", _COLUMNS, tuple(rows))


_COLUMNS = (
        Column("Track"), Column("Extreme"), Column("Value"), Column("Unit"), Column("Cam angle", "°"),
        Column("Along the roller", "mm"),
    )  # fmt: skip


def _row(
    survey: Survey, name: str, found: Extreme, unit: str, shown: Callable[[float], float]
) -> tuple[str | float, ...]:
    value = shown(found.value)
    angle = degrees(found.cam_angle)
    # A roller that stays in the cam for several turns is counted through them; the table speaks of the cam.
    return survey.track.name, name, value, unit, angle if _whole(survey) else angle % 360.0, found.place


def _sides(survey: Survey) -> list[tuple[float, str]]:
    sides = survey.track.sides
    return [(side, ("flank +" if side > 0 else "flank −") if len(sides) > 1 else "flank") for side in sides]


def lines(model: Model, survey: Survey, curved: bool = True) -> Chart:
    """Pressure angle at both ends and the middle of the contact, and relative curvature, along the turn."""
    angle = np.degrees(survey.phi)
    side = FLANKS[survey.pressure_angle.where]
    found = survey.flank(side)
    stations = survey.track.meridian.jet(survey.stations)[0]
    picks = (0, len(stations) // 2, len(stations) - 1)
    limit = model.profile.limits.pressure_angle_deg
    peak = survey.pressure_angle
    at = degrees(peak.cam_angle)
    pressure = Panel(
        Axis("Pressure angle", "°", zero=True),
        tuple(
            Series(f"at {number(float(stations[k]))} mm", angle, np.degrees(found.pressure_angle()[:, k]))
            for k in picks
        ),
        limits=(Limit(limit, f"limit {number(limit)}°"),) if limit and degrees(peak.value) > 0.5 * limit else (),
        marks=(mark(at, degrees(peak.value), "°"),),
    )
    still = zones(model.setup.program) if _whole(survey) else ()
    caption = "Pressure angle at three places along the roller axis"
    if survey.track.carriage is not None:
        caption = "On the way out, which the way back repeats: pressure angle at three places along the roller axis"
    if not curved:
        return Chart(caption, _axis(survey), (pressure,), still)
    middle = len(stations) // 2
    curvature = Panel(
        Axis("Relative curvature", "1/mm", zero=True),
        tuple(Series(name, angle, survey.flank(s).k_rel[:, middle]) for s, name in _sides(survey)),
    )
    caption += f"; relative curvature of cam against roller at {number(float(stations[middle]))} mm"
    return Chart(caption, _axis(survey), (pressure, curvature), still)


def _whole(survey: Survey) -> bool:
    low, high = survey.track.span
    return abs(low) < 1e-9 and abs(high - 2.0 * np.pi) < 1e-9


def _axis(survey: Survey) -> Axis:
    if _whole(survey):
        return CAM_ANGLE
    low, high = survey.track.span
    return Axis("Cam angle, counted through all turns of one roller", "°", degrees(low), degrees(high))


def maps(survey: Survey) -> tuple[Map, ...]:
    """Pressure angle on the worst flank and relative curvature of every flank, over turn and roller."""
    phi, t = grid(survey)
    delta = survey.track.meridian.jet(t)[0]
    axis, along = _axis(survey), Axis("Along the roller axis", "mm")
    worst = survey.pressure_angle
    found = Flank(survey.track, phi, t, FLANKS[worst.where])
    angle = np.degrees(phi)
    marks = (Mark(degrees(worst.cam_angle), worst.place, f"{number(degrees(worst.value))}°"),)
    pressure = Map(
        "Pressure angle over the flank", axis, along, Axis("Pressure angle", "°"), *_even(angle, delta),
        np.degrees(found.pressure_angle()).T[_order(delta)], marks=marks,
    )  # fmt: skip
    curved = []
    for side, name in _sides(survey):
        values = Flank(survey.track, phi, t, side).k_rel.T[_order(delta)]
        caption = f"Relative curvature of cam against roller, {name}"
        curved.append(Map(caption, axis, along, Axis("Relative curvature", "1/mm"), *_even(angle, delta), values))
    return (pressure, *curved)


def grid(survey: Survey) -> tuple[Floats, Floats]:
    """Even cam angles (n,), rad, a hair inside the span, and even places along the roller as meridian stations (m,)."""
    low, high = survey.track.span
    hair = 1e-9 * (high - low)
    first, last = survey.stations[0], survey.stations[-1]
    ends = survey.track.meridian.jet(np.array([first, last]))[0]
    t = np.array(
        [survey.track.meridian.parameter(float(d)) for d in np.linspace(float(ends[0]), float(ends[1]), ALONG)]
    )
    return np.linspace(low + hair, high - hair, ACROSS), np.clip(t, min(first, last), max(first, last))


def _even(angle: Floats, delta: Floats) -> tuple[Floats, Floats]:
    return angle, np.sort(delta)


def _order(delta: Floats) -> slice:
    return slice(None) if delta[-1] > delta[0] else slice(None, None, -1)


def profile(model: Model, planar: Planar) -> tuple[Block, ...]:
    """Pressure angle and curvature where the cam is touched, the extremes of its profile, and a pair's residual."""
    phi = _angles(planar)
    angle = np.degrees(phi)
    found = [(touch.where, touch.at(phi)) for touch in planar.touches]
    bent = [(touch.where, touch.material * at.curve.curvature) for touch, (_, at) in zip(planar.touches, found)]
    angles = [(touch.name, touch.at(phi)) for touch in planar.walls]  # the same at every height
    shown = [_angle_panel(model, planar, angle, angles)] if planar.pressure_angle.value > FLAT else []
    if all(float(np.abs(values).max()) < STEEPEST for _, values in bent):
        lines = tuple(Series(name, angle, values) for name, values in bent)
        shown.append(Panel(Axis("Curvature of the profile", "1/mm", zero=True), lines))
        rolling = [(touch.where, at) for touch, (_, at) in zip(planar.touches, found) if touch.rolling]
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
    if any(touch.lean for touch in planar.touches):
        text += ". The flank leans as its cone does: its profiles at both ends are shown, and the pressure angle has "
        return text + "that lean in it, with the sign that it has in the plane, so that it jumps where that changes."
    return text + ". Along the width of the cam nothing changes."


def _angles(planar: Planar) -> Floats:
    """Cam angles, rad, over the turn with both sides of every knot."""
    knots = distinct(np.concatenate([np.r_[0.0, touch.knots(), 2.0 * pi] for touch in planar.touches]))
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
