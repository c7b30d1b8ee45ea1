"""The page of a study: figures over the varied keys with their limits and units, and the table of the variants."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING, Any, final

import numpy as np

from camgeom.checks.verdict import life_shown
from camgeom.design.batch.judged import JUDGED, limit_of
from camgeom.design.study import Axis as Varied
from camgeom.design.study import Row, Study
from camgeom.drawing.content import (
    Axis,
    Block,
    Chapter,
    Chart,
    Column,
    Figure,
    Limit,
    Map,
    Page,
    Panel,
    Series,
    Table,
    Text,
)
from camgeom.drawing.sheet import number
from camgeom.errors import ProfileError
from camgeom.immutable import immutable
from camgeom.keys import Section
from camgeom.maths import Floats
from camgeom.profile.errors import OF_SLIDE
from camgeom.profile.units import is_length
from camgeom.report.figures import UNITS
from camgeom.report.measured import of_followers

if TYPE_CHECKING:
    from camgeom.profile import Profile

PLOTTED = (
    ("flank.max_pressure_angle_deg", "Largest pressure angle", "°"),
    ("flank.undercut_margin", "Undercut margin", ""),
    ("solid.mass_kg", "Mass", "kg"),
    ("contact.peak_slice_pressure_mpa", "Contact pressure, hardest place", "MPa"),
    ("contact.peak_pressure_mpa", "Contact pressure, quoted place", "MPa"),
    ("contact.peak_torque_n_m", "Peak torque", "N m"),
    ("together.peak_pressure_mpa", "Contact pressure, hardest follower", "MPa"),
    ("together.peak_torque_n_m", "Peak torque, all followers", "N m"),
    ("together.least_life_h", "Shortest life of all followers", "h"),
    ("fatigue.roller_slice_life_h", "Roller life", "h"),
    ("dynamics.first_frequency_hz", "First natural frequency", "Hz"),
    ("dynamics.frequencies_hz.1", "First natural frequency", "Hz"),
    ("dynamics.amplification", "Peak acceleration over the rigid one", ""),
    ("dynamics.peak_load_acceleration_rad_s2", "Peak load acceleration", "rad/s²"),
    ("dynamics.peak_acceleration_rad_s2", "Peak acceleration with vibration", "rad/s²"),
    ("dynamics.peak_acceleration_m_s2", "Peak acceleration with vibration", "m/s²"),
    ("dynamics.residual_deviation_deg", "Deviation left in the dwell", "°"),
    ("dynamics.duty.peak_pressure_mpa", "Contact pressure with vibration", "MPa"),
    ("dynamics.camshaft_torque_n_m", "Camshaft torque with vibration", "N m"),
    ("dynamics.duty.peak_drive_force_n", "Force of the drive with vibration", "N"),
    ("dynamics.impact.over_turns.peak_acceleration_rad_s2.mean", "Peak acceleration with impacts", "rad/s²"),
    ("dynamics.impact.over_turns.peak_acceleration_m_s2.mean", "Peak acceleration with impacts", "m/s²"),
    ("dynamics.impact.over_turns.peak_force_main_n.mean", "Peak force of the main contact, with impacts", "N"),
    ("dynamics.impact.over_turns.peak_force_return_n.mean", "Peak force of the opposite contact, with impacts", "N"),
    ("dynamics.impact.worst_pressure_mpa", "Contact pressure with impacts", "MPa"),
    ("dynamics.impact.duty.roller_life_h", "Roller life with impacts", "h"),
)
"""figures drawn where none are named, with words and unit"""
MOST_LINES = 24
"""in a panel; what is more is told"""
FEW_LINES = 6
"""up to which every line has a style of its own; more over two even axes are a map"""
MOST_MARKS = 60
"""samples of a line that are marked one by one"""
MOST_ROWS = 200


@final
@immutable(eq=True)
class Shown:
    """A figure that is drawn: its column, words and unit."""

    key: str
    label: str
    unit: str


def page(
    study: Study,
    rows: Sequence[Row],
    name: str,
    table: str = "study.csv",
    counts: Counter[str] | None = None,
    figures: Sequence[str] = (),
) -> Page:
    """The page of a finished study; `table` is the file with all its rows, `counts` what they say where `rows` are the
    first of them alone, `figures` the columns that were asked for."""
    counts = counts or Counter(row.verdict for row in rows)
    total = sum(counts.values())
    profile = _profile(study)
    shown = _shown(rows, figures)
    blocks: list[Block] = []
    if total == len(rows):
        blocks += _drawn(study, rows, shown, profile, table)
    elif shown:
        text = f"Not drawn: {total} variants, of which the page holds {len(rows)}; {table} has them all."
        blocks.append(Text((text,)))
    blocks.append(_table(study, rows, shown, profile))
    if open_ := left_open(rows):
        blocks.append(Text((f"Not judged in this study: {', '.join(open_)}. camgeom check judges a variant whole.",)))
    if total > MOST_ROWS:
        note = f"The table shows the first {MOST_ROWS} of {total} variants; {table} has them all."
        blocks.append(Text((note,)))
    return Page(
        title=name,
        kind=f"study of {', '.join(one.key for one in study.varied)}",
        level=None,
        figures=tuple(Figure(f"variants: {word(verdict, rows)}", count) for verdict, count in counts.items()),
        sections=(Chapter("study", "Variants", tuple(blocks)),),
    )


def left_open(rows: Sequence[Row]) -> list[str]:
    """Names of the checks that were not made of some variant."""
    return sorted({name for row in rows for name in str(row.figures.get("not_judged") or "").split()})


def word(verdict: str, rows: Sequence[Row]) -> str:
    """A verdict in words; "pass" alone is said only where everything that applies was judged."""
    return "pass of what was judged" if verdict == "pass" and left_open(rows) else verdict


def cell(key: str, value: Any) -> Any:
    """A value of a column as it is shown."""
    return life_shown(value) if key.endswith("_life_h") and value is not None else value


def _profile(study: Study) -> Profile | None:
    """The profile that is varied; None where it cannot be made without its variants' values."""
    from camgeom.profile import from_data

    try:
        return from_data(study.data, study.file)
    except ProfileError:
        return None


def _shown(rows: Sequence[Row], figures: Sequence[str]) -> tuple[Shown, ...]:
    """The figures that some variant has: those asked for, else the usual ones."""
    followers = {key.split(".")[1] for row in rows for key in row.figures if key.startswith("followers.")}
    count = max(map(int, followers), default=1)
    usual: dict[str, Shown] = {}
    for key, label, unit in PLOTTED:
        usual[key] = Shown(key, label, unit)
        for one in of_followers((key,), count)[1:]:
            usual[one] = Shown(one, f"{label}, follower {one.split('.')[1]}", unit)
    keys = figures or usual
    there = {key for row in rows for key, value in row.figures.items()
             if isinstance(value, int | float) and not isinstance(value, bool)}  # fmt: skip
    return tuple(usual.get(key) or Shown(key, *_words(key)) for key in keys if key in there)


def _words(key: str) -> tuple[str, str]:
    """Words and unit of a figure by its name, parts of which end in a unit."""
    words, unit = [], ""
    for part in key.split(".")[1:] or [key]:
        ending = max((one for one in UNITS if part.endswith(f"_{one}")), key=len, default="")
        unit = UNITS.get(ending, unit)
        words.append(part.removesuffix(f"_{ending}").replace("_", " "))
    return ", ".join(words), unit


def unit_of(profile: Profile | None, path: Sequence[str | int]) -> str:
    """Unit of a key, from its description, which begins or ends with it; empty where it has none."""
    found: Any = profile
    for part in path[:-1]:
        if isinstance(found, Section) and isinstance(part, str) and part in type(found).model_fields:
            found = getattr(found, part)
        elif isinstance(found, tuple) and isinstance(part, int) and part < len(found):
            found = found[part]
        else:
            return ""
    if profile is None or not isinstance(found, Section):
        return ""
    fields = type(found).model_fields
    about = next((field.description or "" for name, field in fields.items() if path[-1] in (name, field.alias)), "")
    if profile.units == "inch" and is_length(str(path[-1]), about, profile.rotating):
        return "in"
    if profile.rotating and OF_SLIDE.match(about):
        return "°"
    known = ("r/min", "N/mm", "N mm", "kg m2", "kg/m³", "MPa", "deg", "mm", "kg", "m/s2", "N m", "N", "h", "s", "Hz")
    parts = re.split(r"[,;(]\s*", about)
    return next((unit for part in parts for unit in known if part.strip() == unit), "").replace("deg", "°")


def _limits(key: str, profile: Profile | None, study: Study) -> tuple[Limit, ...]:
    """The limit of a figure as a line, where the profile has one that is not varied itself."""
    own = {figure: limit for _, figure, limit, _ in JUDGED if limit}
    if profile is None or key not in own or any(one.path[0] in ("limits", "material") for one in study.varied):
        return ()
    value = limit_of(profile, {}, own[key])
    return () if value is None else (Limit(float(value), f"limit {number(float(value))}"),)


def _drawn(
    study: Study, rows: Sequence[Row], shown: Sequence[Shown], profile: Profile | None, table: str
) -> list[Block]:
    """A panel for each figure, over the numeric axis with the most values; a map where too many lines would cross."""
    numeric = [i for i, one in enumerate(study.axes) if all(not isinstance(v, str) for v in one.values)]
    if not numeric or not shown:
        return []
    if study.plan is not None and study.plan.method != "grid":
        return [_scatter(study, rows, shown, profile, i) for i in numeric[:MOST_LINES]]
    across = max(numeric, key=lambda i: len(study.axes[i].values))
    if len(study.axes[across].values) < 2:
        return []
    others = [one for i, one in enumerate(study.axes) if i != across]
    settings = math.prod(len(one.values) for one in others)
    x = Axis(study.axes[across].key, unit_of(profile, study.axes[across].path))
    if settings > FEW_LINES and len(study.axes) == 2 and len(numeric) == 2 and all(map(_even, study.axes)):
        return [_map(study, rows, one, profile, across) for one in shown]
    panels = []
    for one in shown:
        series = _lines(study.axes, rows, across, one)
        if series:
            limits = _limits(one.key, profile, study)
            panels.append(Panel(Axis(one.label, one.unit), series, limits=limits, direct=settings > 1, height=1.3))
    if not panels:
        return []
    caption = f"Figures over {x.label}; variants without a result leave the line out"
    if settings > MOST_LINES:
        caption += f"; the first {MOST_LINES} of {settings} settings of the other keys, {table} has them all"
    return [Chart(caption, x, tuple(panels))]


def _even(axis: Varied) -> bool:
    """Whether the values of an axis rise in equal steps."""
    steps = np.diff(np.array(axis.values, dtype=float))
    return len(steps) > 0 and bool(np.all(steps > 0.0) and np.ptp(steps) <= 1e-9 * float(steps.max()))


def _map(study: Study, rows: Sequence[Row], one: Shown, profile: Profile | None, across: int) -> Map:
    """A figure over two keys; blank where a variant has no result."""
    up = 1 - across
    x, y = (np.array(study.axes[i].values, dtype=float) for i in (across, up))
    values = np.full((len(y), len(x)), np.nan)
    for row in rows:
        value = row.figures.get(one.key)
        if isinstance(value, int | float):
            at = [int(np.argmin(np.abs(axis - float(row.values[i])))) for axis, i in ((y, up), (x, across))]
            values[at[0], at[1]] = float(value)
    axes = [Axis(study.axes[i].key, unit_of(profile, study.axes[i].path)) for i in (across, up)]
    told = "".join(f"; {limit.label} {one.unit}" for limit in _limits(one.key, profile, study))
    caption = f"{one.label} over {axes[0].label} and {axes[1].label}{told}; blank where there is no result"
    return Map(caption, axes[0], axes[1], Axis(one.label, one.unit), x, y, values)


def _scatter(study: Study, rows: Sequence[Row], shown: Sequence[Shown], profile: Profile | None, i: int) -> Chart:
    """Every variant as a point over one of the keys of which it was drawn."""
    panels = []
    for one in shown:
        points = [(float(row.values[i]), float(value)) for row in rows
                  if isinstance(value := row.figures.get(one.key), int | float)]  # fmt: skip
        x, y = np.array(points).T
        series = (Series(one.label, x, y, 0, dots=True),)
        panels.append(Panel(Axis(one.label, one.unit), series, limits=_limits(one.key, profile, study)))
    axis = study.axes[i]
    return Chart(f"Every variant over {axis.key}", Axis(axis.key, unit_of(profile, axis.path)), tuple(panels))


def _lines(axes: Sequence[Varied], rows: Sequence[Row], across: int, one: Shown) -> tuple[Series, ...]:
    """One line for each setting of the other axes, over the axis `across`, its samples marked where they are few."""
    others = [i for i in range(len(axes)) if i != across]
    found: dict[tuple[Any, ...], list[tuple[float, float]]] = {}
    for row in rows:
        value = row.figures.get(one.key)
        if isinstance(value, int | float):
            setting = tuple(row.values[i] for i in others)
            found.setdefault(setting, []).append((float(row.values[across]), float(value)))
    lines: list[Series] = []
    for k, setting in enumerate(product(*(axes[i].values for i in others))):
        if k == MOST_LINES:
            break
        points: Floats = np.array(sorted(found.get(setting, [])))
        if len(points) < 2:
            continue
        name = ", ".join(f"{axes[i].key} {_value(v)}" for i, v in zip(others, setting)) or one.label
        lines.append(Series(name, points[:, 0], points[:, 1], k % FEW_LINES))
        if len(points) <= MOST_MARKS:
            lines.append(Series(name, points[:, 0], points[:, 1], k % FEW_LINES, dots=True))
    return tuple(lines)


def _value(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _table(study: Study, rows: Sequence[Row], shown: Sequence[Shown], profile: Profile | None) -> Table:
    keys = [Column(one.key, unit_of(profile, one.path)) for one in study.varied]
    heads = [*keys, Column("Status"), *(Column(one.label, one.unit) for one in shown)]
    cells = tuple(
        (*row.values, row.verdict, *(cell(one.key, row.figures.get(one.key)) for one in shown), row.reason[:200])
        for row in rows[:MOST_ROWS]
    )
    return Table("Variants", (*heads, Column("Reason")), cells)
