"""Pressure angle, curvature and undercut margin of the flanks: along the turn and as maps over turn and roller."""

from __future__ import annotations

from collections.abc import Callable
from math import degrees
from typing import TYPE_CHECKING

import numpy as np

from camgeom.drawing.content import CAM_ANGLE, Axis, Block, Chart, Column, Limit, Map, Mark, Panel, Series, Table, Text
from camgeom.drawing.numerals import number
from camgeom.maths import Floats
from camgeom.report.sections.motion import zones
from camgeom.track.flank import Flank

if TYPE_CHECKING:
    from camgeom.model import Model
    from camgeom.track.survey import Extreme, Survey

ACROSS, ALONG = 361, 21
"""cells of a map"""


def flank(model: Model) -> tuple[Block, ...]:
    """Extremes of every track, lines at three stations, and maps of the first track; of planar cams the profile."""
    folded = [survey for survey in model.flanks if survey.margin.value <= 0.0]
    if folded:
        return _folded(model, folded)
    if model.planar is not None:
        from camgeom.report.sections.planes import profile

        return profile(model, model.planar)
    if not model.flanks:
        return ()
    first = model.flanks[0]
    blocks: list[Block] = [extremes(model), lines(model, first)]
    if len(model.flanks) > 1:
        same = f"The plots show the track {first.track.name!r}; the table covers all {len(model.flanks)}."
        blocks.insert(1, Text((same,)))
    return (*blocks, *maps(first))


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
    return survey.track.name, name, value, unit, angle if _whole(survey) else angle % 360.0, found.delta


def _sides(survey: Survey) -> list[tuple[float, str]]:
    sides = survey.track.sides
    return [(side, ("flank +" if side > 0 else "flank −") if len(sides) > 1 else "flank") for side in sides]


def lines(model: Model, survey: Survey, curved: bool = True) -> Chart:
    """Pressure angle at both ends and the middle of the contact, and relative curvature, along the turn."""
    angle = np.degrees(survey.phi)
    side = survey.pressure_angle.side
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
        marks=(Mark(at, degrees(peak.value), f"{number(degrees(peak.value))}° at {number(at)}°"),),
    )
    still = zones(model.setup.program) if _whole(survey) else ()
    caption = "Pressure angle at three places along the roller axis"
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
    found = Flank(survey.track, phi, t, worst.side)
    angle = np.degrees(phi)
    marks = (Mark(degrees(worst.cam_angle), worst.delta, f"{number(degrees(worst.value))}°"),)
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
