"""`camgeom law`: the best motion law for a requirement, its lower bound, and its front beside the catalogue's laws."""

from __future__ import annotations

import argparse
import csv
import io
import json
from dataclasses import replace
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from camgeom.cli import Console, UsageError, aligned, number, number_in, whole
from camgeom.cli.model import refuse_nameless, refuse_unwritable, write_set
from camgeom.errors import Problem, ProfileError
from camgeom.motion.catalogue import LAWS
from camgeom.motion.law import Ends

if TYPE_CHECKING:
    from camgeom.drawing.content import Chart, Page
    from camgeom.motion.optimal.best import Best
    from camgeom.motion.optimal.catalogue import Rival
    from camgeom.motion.optimal.wish import Wish

AIMS = {"acceleration": "peak-acceleration", "jerk": "jerk", "residual": "residual", "rms": "rms-acceleration"}
POINTS = 2001
"""x, lift, velocity and acceleration in the JSON and the CSV file, evenly spread"""
VOID = 0.1
"""share of a value by which its bound may lie below it while that share is told"""
ALONG = 9
"""points of the front"""
NAMED = 12
"""laws of the catalogue that are named on the chart"""


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Find the best law; returns 0, or 1 where no law can do what is asked."""
    from camgeom.motion.laws_optimal import wish_of
    from camgeom.motion.optimal.best import Impossible, best

    refuse_nameless(arguments.out)
    keys = keys_of(arguments)
    entry = LAWS["optimal"]
    asked = keys["minimise"] == "residual" or "residual_limit" in keys
    # A band alone asks nothing of the law; the residual over it is shown all the same.
    seen = {} if asked else {key: keys.pop(key) for key in ("band", "damping") if key in keys}
    if problems := entry.problems(keys):
        raise ProfileError([option(problem) for problem in problems])
    try:
        wish = wish_of(Ends(), **entry.complete(keys))
    except ProfileError as error:
        raise UsageError("; ".join(str(option(problem)) for problem in error.problems)) from None
    for word, given in (("--damping", "damping" in seen), ("--front", arguments.front)):
        if given and arguments.band is None:
            raise UsageError(f"{word}: says nothing without --band")
    if seen:
        wish = replace(wish, band=seen["band"], damping=seen.get("damping", 0.0))
    folder = None if arguments.out is None else Path(arguments.out)
    if folder is not None:
        refuse_unwritable(folder)
    found = best(wish)
    if isinstance(found, Impossible):
        if arguments.json:
            told = {"possible": False, "reason": found.reason, "least_factor": found.least, "bound": found.bound,
                    "clash": found.clash, "relaxed": found.relaxed, "assumed": found.assumed}  # fmt: skip
            console.out(json.dumps(told, indent=2))
        else:
            console.err(f"camgeom: {found.reason}")
        return 1
    data = law_data(found, keys)
    fronted = wish.band is not None and (arguments.front or folder is not None)
    points = front_of(wish, console) if fronted else []
    if fronted:
        data["front"] = [{"acceleration": a, "residual": e, "lower_bound": low} for a, e, low in points]
        data["catalogue"] = [{**shown(rival), "keeps_limits": rival.keeps(wish)} for rival in rivals_of(wish)]
    if folder is not None:
        data["files"] = [str(path) for path in written(folder, found, keys, points, console)]
    if arguments.json:
        console.out(json.dumps(data, indent=2, allow_nan=False))
        return 0
    for line in summary(data, keys):
        console.out(line)
    return 0


def keys_of(arguments: argparse.Namespace) -> dict[str, Any]:
    """The keys of a segment that say what the options ask."""
    if arguments.least not in AIMS:
        raise UsageError(f"--least: {arguments.least[:60]!r} is none of {', '.join(AIMS)}")
    keys: dict[str, Any] = {"minimise": AIMS[arguments.least]}
    limits = {"velocity": arguments.vmax, "acceleration": arguments.amax, "jerk": arguments.jmax,
              "residual": arguments.residual}  # fmt: skip
    for (name, text), word in zip(limits.items(), ("--vmax", "--amax", "--jmax", "--residual")):
        value = number_in(text, word, low=0.0)
        if value is not None:
            if value == 0.0:
                raise UsageError(f"{word}: a limit of 0 lets nothing move; allowed: above 0")
            keys[f"{name}_limit"] = value
    if (damping := number_in(arguments.damping, "--damping", low=0.0, high=0.9)) is not None:
        keys["damping"] = damping
    if arguments.band is not None:
        low, _, high = arguments.band.partition(":")
        ends = number_in(low, "--band", low=0.05, high=60.0), number_in(high or low, "--band", low=0.05, high=60.0)
        keys["band"] = tuple(sorted(end for end in ends if end is not None))
    if arguments.monotone:
        keys["monotone"] = True
    smooth = "jerk_limit" in keys or keys["minimise"] == "jerk"
    order = whole(arguments.order, "--order", 1, 2)
    keys["order"] = (2 if smooth else 1) if order is None else order
    if arguments.least == "residual" and arguments.band and not arguments.residual and len(keys) == 3:
        raise UsageError("--least residual: give --amax or --jmax, without either no law is best")
    return keys


OPTIONS = {"velocity_limit": "--vmax", "acceleration_limit": "--amax", "jerk_limit": "--jmax",
           "residual_limit": "--residual", "minimise": "--least"}  # fmt: skip


def option(problem: Problem) -> Problem:
    """A problem of a key as that of the option that says it."""
    return replace(problem, key=OPTIONS.get(problem.key, f"--{problem.key}"))


def law_data(found: Best, keys: dict[str, Any]) -> dict[str, Any]:
    """The law as plain data, normalised; null where a value is infinite or not asked for."""
    peaks = {name: value if isfinite(value) else None for name, value in found.peaks.items()}
    x = np.linspace(0.0, 1.0, POINTS)
    from camgeom.motion.table import PieceTable

    jet = PieceTable.of(found.pieces).jet(x, 2)
    return {
        "possible": True,
        "minimise": keys["minimise"],
        "value": found.value,
        "lower_bound": found.bound,
        "gap": found.gap,
        "most_gain": found.most_gain,
        "bound_holds_for": found.holds_for,
        "peak_velocity": peaks["velocity"],
        "peak_acceleration": peaks["acceleration"],
        "peak_jerk": peaks["jerk"],
        "rms_acceleration": peaks["rms-acceleration"],
        "residual": peaks.get("residual"),
        "pieces": len(found.pieces),
        "segment": {"law": "optimal", **keys},
        "x": x.tolist(),
        "lift": jet[0].tolist(),
        "velocity": jet[1].tolist(),
        "acceleration": jet[2].tolist(),
    }


def summary(data: dict[str, Any], keys: dict[str, Any]) -> list[str]:
    """What a reader wants to know first."""
    rows = [
        ("least " + keys["minimise"].replace("-", " "), number(data["value"], 8)),
        ("lower bound", f"{number(data['lower_bound'], 8)} for {data['bound_holds_for']}"),
        ("most to gain", number(data["most_gain"])),
        ("gap", f"{100.0 * data['gap']:.2g} %"),
        ("peak velocity", number(data["peak_velocity"], 7)),
        ("peak acceleration", number(data["peak_acceleration"], 7)),
        ("peak jerk", number(data["peak_jerk"], 7) if data["peak_jerk"] is not None else "inf"),
        ("rms acceleration", number(data["rms_acceleration"], 7)),
    ]
    if data["residual"] is not None:
        rows.append(("residual over the band", number(data["residual"], 6)))
    rows.append(("pieces", str(data["pieces"])))
    lines = ["the best law, for unit lift over unit travel", *(f"  {line}" for line in aligned(rows))]
    if data.get("front"):
        lines.append("front: peak acceleration, least residual, its bound")
        cells = [tuple(number(point[key]) for key in ("acceleration", "residual", "lower_bound"))
                 for point in data["front"]]  # fmt: skip
        lines += [f"  {line}" for line in aligned(cells)]
    lines.append("as a segment of a profile:")
    lines += [f"  {line}" for line in segment_lines(keys)]
    return [*lines, *(f"  wrote {path}" for path in data.get("files", ()))]


def segment_lines(keys: dict[str, Any]) -> list[str]:
    """The keys of the segment as TOML."""
    lines = ['law = "optimal"']
    for key, value in keys.items():
        if isinstance(value, bool):
            lines.append(f"{key} = {str(value).lower()}")
        elif isinstance(value, tuple):
            lines.append(f"{key} = [{', '.join(f'{item:.12g}' for item in value)}]")
        else:
            lines.append(f'{key} = "{value}"' if isinstance(value, str) else f"{key} = {value:.12g}")
    return lines


def front_of(wish: Wish, console: Console) -> list[tuple[float, float, float]]:
    """Peak acceleration, the least residual under it, and that one's bound, rising: from the least acceleration of all.

    Points where no law is found, or the programme finds no rest, are left out.
    """
    from camgeom.errors import NotConverged
    from camgeom.motion.optimal.best import Impossible, best

    free = replace(wish, aim="peak-acceleration", acceleration=float("inf"), residual=float("inf"))
    try:
        begun = best(free)
    except NotConverged:
        return []
    if isinstance(begun, Impossible):
        return []
    points: list[tuple[float, float, float]] = []
    for k, share in enumerate(np.geomspace(1.002, 1.9, ALONG)):
        console.progress(f"front {k + 1} of {ALONG}")
        limit = replace(wish, aim="residual", residual=float("inf"), acceleration=float(share) * begun.value)
        try:
            found = best(limit)
        except NotConverged:
            continue
        if not isinstance(found, Impossible):
            # What keeps a smaller limit keeps a larger one.
            least = min([found.value, *(value for _, value, _ in points)])
            points.append((limit.acceleration, least, found.bound))
    console.progress("")
    return points


def rivals_of(wish: Wish) -> list[Rival]:
    """The catalogue's laws over the band."""
    from camgeom.motion.optimal.catalogue import rivals

    return [] if wish.band is None else rivals(wish.band, wish.damping)


def shown(rival: Rival) -> dict[str, Any]:
    """A law of the catalogue as plain data."""
    return {key: value if isinstance(value, str) or isfinite(value) else None for key, value in
            rival._asdict().items()}  # fmt: skip


def written(
    folder: Path, found: Best, keys: dict[str, Any], points: list[tuple[float, float, float]], console: Console
) -> list[Path]:
    """The law as a segment (TOML), as a table (CSV) and on a page; they appear together."""
    from camgeom.export.folder import LAW
    from camgeom.motion.table import PieceTable
    from camgeom.report.page import render

    x = np.linspace(0.0, 1.0, POINTS)
    rows = np.vstack([x, PieceTable.of(found.pieces).jet(x, 3)]).T
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(("x", "lift", "velocity", "acceleration", "jerk"))
    writer.writerows(rows.tolist())
    contents = {
        "law.toml": "\n".join(segment_lines(keys)) + "\n",
        "law.csv": text.getvalue(),
        "law.html": render(page(found, keys, points)),
    }
    return write_set(folder, LAW, "best law", "law", contents, console)


def page(found: Best, keys: dict[str, Any], points: list[tuple[float, float, float]]) -> Page:
    """The page: what was found, how it moves, and the front with the catalogue's laws on it."""
    from camgeom.drawing.content import Chapter, Column, Figure, Page, Table, Text

    values = [("Least " + keys["minimise"].replace("-", " "), found.value), ("Lower bound", found.bound)]
    values += [(name.capitalize().replace("Rms-", "RMS "), value) for name, value in found.peaks.items()]
    figures = tuple(Figure(name, value) for name, value in values if isfinite(value))
    near = f"within {100.0 * found.gap:.2g} % of it" if found.gap < VOID else f"above it by {found.most_gain:.2g}"
    told = f"The bound holds for {found.holds_for}; the law is {near}."
    chapters = [Chapter("law", "The law", (Text(("; ".join(segment_lines(keys)),)), motion_chart(found)))]
    if found.wish.band is not None:
        rivals = rivals_of(found.wish)
        rows = tuple(
            (r.name, *(value if isfinite(value) else None for value in r[1:]), "yes" if r.keeps(found.wish) else "no")
            for r in rivals
        )
        heads = (Column("Law"), Column("Velocity"), Column("Acceleration"), Column("Jerk"), Column("Residual"),
                 Column("Keeps the limits"))  # fmt: skip
        table = Table("The catalogue's laws over the band, least residual first", heads, rows)
        chapters.append(Chapter("front", "Front", (front_chart(found, points, rivals), table)))
    return Page("best law", "unit lift over unit travel", None,
                figures=figures, sections=tuple(chapters), headline=told)  # fmt: skip


def motion_chart(found: Best) -> Chart:
    """Lift, velocity, acceleration and jerk over the travel."""
    from camgeom.drawing.content import Axis, Chart, Panel, Series
    from camgeom.motion.table import PieceTable

    table = PieceTable.of(found.pieces)
    words = ("Lift s", "Velocity s'", "Acceleration s''", "Jerk s'''")
    x = np.concatenate([np.linspace(piece.start, piece.end, 41) for piece in found.pieces])
    index = np.repeat(np.arange(len(found.pieces)), 41)
    jets = table.at(index, x - table.anchors[index], 3)
    kept = words if isfinite(found.peaks["jerk"]) else words[:3]
    panels = tuple(Panel(Axis(word), (Series(word, x, row),)) for word, row in zip(kept, jets))
    return Chart("The law for unit lift over unit travel", Axis("Share of the travel x", "", 0.0, 1.0), panels)


def front_chart(found: Best, points: list[tuple[float, float, float]], rivals: list[Rival]) -> Chart:
    """Residual over peak acceleration: the least of all laws as a line, the catalogue's laws as named points."""
    from camgeom.drawing.content import Axis, Chart, Mark, Panel, Series

    band = found.wish.band or (0.0, 0.0)
    most = 1.15 * max([2.0 * found.peaks["acceleration"], *(a for a, _, _ in points)])
    near = sorted((r for r in rivals if r.acceleration <= most), key=lambda r: not r.keeps(found.wish))[:NAMED]
    series = []
    if points:
        a, least, _ = np.array(points).T
        series.append(Series("least residual within these limits", a, least))
    marks = [
        Mark(r.acceleration, r.residual, r.name if r.keeps(found.wish) else f"({r.name})") for r in near
    ]
    marks.append(Mark(found.peaks["acceleration"], found.peaks["residual"], "this law"))
    caption = (
        f"Peak acceleration against the largest residual over n = {number(band[0])} to {number(band[1])}; "
        "laws of the catalogue in brackets exceed another limit"
    )
    # The line alone would set the axes, and what lies beyond it would stand at their edges.
    across = [mark.x for mark in marks] + [a for a, _, _ in points]
    top = 1.1 * max([mark.y for mark in marks] + [least for _, least, _ in points])
    panel = Panel(Axis("Residual, share of the lift", "", 0.0, top), tuple(series), marks=tuple(marks), height=2.2)
    return Chart(caption, Axis("Peak acceleration", "", 0.95 * min(across), 1.05 * max(across)), (panel,))
