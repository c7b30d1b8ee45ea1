"""The part drawing: one A3 sheet with true sections and main dimensions, motion diagram, parameters and title block."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camgeom.drawing.content import Chart, Drawing
from camgeom.drawing.drawing import drawing_sheet, drawing_size
from camgeom.drawing.paper import PX, Paper, pdf
from camgeom.drawing.plots import chart_sheet
from camgeom.drawing.shapes import Dot
from camgeom.drawing.sheet import number, text_width
from camgeom.errors import CamgeomError, ExportError, visible
from camgeom.export.files import write_whole
from camgeom.report.sections.design import part_views
from camgeom.report.sections.motion import diagrams
from camgeom.version import __version__

if TYPE_CHECKING:
    from camgeom.keys import Section
    from camgeom.model import Model
    from camgeom.profile import Profile
    from camgeom.profile.own_track import OwnTrack

WIDTH, HEIGHT = 420.0, 297.0
"""mm, A3 lying"""
LEFT, RIGHT, TOP, BOTTOM = 20.0, 410.0, 10.0, 287.0
"""mm, the frame: 20 for filing, 10 elsewhere (ISO 5457)"""
SCALES = (50.0, 20.0, 10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01)
"""ISO 5455"""
PANEL = {157.0: 0.92, 187.0: 0.6}
"""lower edges, mm, that the band with the views may have, with the height of a panel of the motion diagram below, as a
share of the report's"""
BANDS = tuple(PANEL)
HEAD, GAP = 8.0, 2.0
"""mm, room for a view's caption, and beside the frame"""
NARROWEST = 100.0
"""mm, least width of a view, for its caption"""
SPLIT = 218.0
"""mm, where the motion diagram ends and the parameters begin"""
BLOCK = 245.0
"""mm, upper edge of the title block"""
ROW, SIZE = 4.3, 2.7
"""mm, line pitch and size of the text in the table of parameters"""
LETTERS = 1.8, 2.7
"""mm, smallest (ISO 3098) and usual size of text in a cell of the title block"""
COLUMNS = 6
"""of cells in the title block"""
PROJECTION = "Projection"
"""the cell that has a sign in it"""
UNITS = ("mm", "deg", "kg m2", "kg", "N/mm", "N", "r/min", "m/s2")
SKIPPED = {"name", "kind", "direction"}


def write_sheet(draw: Callable[[Model], Paper], model: Model, path: Path) -> int:
    """Write what is drawn of a model as .svg or .pdf, by the end of the name; returns the bytes written.

    Raises ExportError where the cam has no body to draw or the file cannot be written.
    """
    try:
        paper = draw(model)
    except CamgeomError as error:
        raise ExportError(f"{path}: cannot be drawn: {error}") from error
    data = pdf(paper) if path.suffix.lower() == ".pdf" else paper.svg().encode()
    return write_whole(path, data)


def part_sheet(model: Model) -> Paper:
    """The drawing. Raises DesignError where the cam has no body."""
    paper = Paper(WIDTH, HEIGHT, model.profile.name)
    paper.box("border", LEFT, TOP, RIGHT, BOTTOM)
    # Sizes are read off the bodies as they are exported, not off those of the page's pictures.
    meshes = tuple((solid.name, solid.mesh) for solid in model.solids)
    scale, band = _views(paper, part_views(model, meshes))
    _motion(paper, diagrams(model), band)
    _parameters(paper, rows(model), band)
    _title_block(paper, model, scale)
    return paper


def _views(paper: Paper, views: tuple[Drawing, ...]) -> tuple[float, float]:
    """The views side by side at the largest scale of the standard series that has room for all, and the lower edge of
    their band: the lowest only where that gives a larger scale."""
    room = RIGHT - LEFT - 2.0 * GAP

    def needed(scale: float) -> tuple[list[float], float]:
        sizes = [drawing_size(view, scale / PX) for view in views]
        return [max(NARROWEST, size[0] * PX) for size in sizes], max(size[1] for size in sizes) * PX

    def largest(tall: float) -> float:
        return next((s for s in SCALES if sum(needed(s)[0]) <= room and needed(s)[1] <= tall), SCALES[-1])

    heights = {band: band - TOP - HEAD - 2.0 for band in BANDS}
    band = max(BANDS, key=lambda one: (largest(heights[one]), -one))
    tall, scale = heights[band], largest(heights[band])
    widths, _ = needed(scale)
    spare = max(0.0, room - sum(widths))
    x = LEFT + GAP
    for view, width in zip(views, widths):
        width += spare / len(views)
        sheet = drawing_sheet(view, width / PX, scale / PX)
        paper.words(x, TOP + 5.0, _shortened(view.caption, width - GAP, 3.0), size=3.0)
        paper.place(sheet, x, TOP + HEAD + 0.5 * max(0.0, tall - sheet.height * PX))
        x += width
    paper.lines("rule", [(LEFT, band), (RIGHT, band)])
    return scale, band


def _motion(paper: Paper, chart: Chart, band: float) -> None:
    """Lift, velocity and acceleration."""
    lower = tuple(replace(panel, height=PANEL[band]) for panel in chart.panels[:3])
    shown = Chart(chart.caption, chart.x, lower, chart.zones)
    paper.words(LEFT + 2.0, band + 5.0, chart.caption, size=3.0)
    sheet = chart_sheet(shown, (SPLIT - LEFT - 6.0) / PX)
    paper.place(sheet, LEFT + 2.0, band + 7.0)
    paper.lines("rule", [(SPLIT, band), (SPLIT, BOTTOM)])


def rows(model: Model) -> list[tuple[str, str]]:
    """The design's parameters: (key, value with unit), those that are given or count; then the motion's segments."""
    profile = model.profile
    found: list[tuple[str, str]] = []
    sections: list[tuple[str, Section | None]] = [
        ("cam", profile.cam), ("follower", profile.follower), ("roller", profile.roller),
        ("return roller", profile.return_roller), ("", profile.operation),
    ]  # fmt: skip
    idle = profile.cam.idle(model.setup)
    for word, section in sections:
        if section is not None:
            used = tuple(name for name in type(section).model_fields if f"{word}.{name}" not in idle)
            found += _section_rows(word, section, profile.rotating, used)
    for index, station in enumerate(profile.stations, start=2):
        found += _section_rows(f"follower {index}", station, profile.rotating)
    for index, track in enumerate(profile.tracks, start=2):
        found += _track_rows(f"track {index}", track)
    tool = profile.cutter_spec
    if tool is not None and tool.corner_radius:
        found.append(("root, by the tool's corner", f"{number(tool.corner_radius)} mm"))
    return found + _motion_rows("", profile)


def _track_rows(word: str, track: OwnTrack) -> list[tuple[str, str]]:
    """What a further track has of its own."""
    own = track.whole
    found = _section_rows(word, own.cam, own.rotating, tuple(track.cam))
    found += _section_rows(f"{word} follower", own.follower, own.rotating, tuple(track.follower))
    found.insert(0, (f"{word} follower at", f"{number(track.angle)}°"))
    if track.roller is not None and own.roller is not None:
        found += _section_rows(f"{word} roller", own.roller, own.rotating)
    return found + (_motion_rows(f"{word}, ", own) if track.motion is not None else [])


def _motion_rows(word: str, profile: Profile) -> list[tuple[str, str]]:
    """The segments of a motion."""
    unit, start, found = "°" if profile.rotating else " mm", 0.0, []
    over = "°" if profile.cam.travel is None else " mm"
    for segment in profile.motion:
        span = f"{word}{number(start)} to {number(segment.until)}{over}"
        found.append((span, "dwell" if segment.to is None else f"to {number(segment.to)}{unit}, {segment.law}"))
        start = segment.until
    return found


def _section_rows(
    word: str, section: Section, rotating: bool, only: tuple[str, ...] | None = None
) -> list[tuple[str, str]]:
    """Keys of a table that are given or count; `only`: of these."""
    found = []
    for name, entry in type(section).model_fields.items():
        value: Any = getattr(section, name)
        zero = not isinstance(value, bool | str) and value in (None, 0, ())
        if name in SKIPPED or zero or isinstance(value, tuple) or (only is not None and name not in only):
            continue
        if isinstance(value, int | float) and not isinstance(value, bool):
            text = number(float(value), 7) + _unit(entry.description or "", rotating)
        else:
            text = {True: "yes", False: "no"}.get(value, str(value))
        found.append((f"{word} {name.replace('_', ' ')}".strip(), text))
    return found


def _unit(description: str, rotating: bool) -> str:
    """The unit that a key's description begins with; the one in brackets counts for rotating followers."""
    other = re.match(r"[^(;]*\((N[^)]*?)(?: for [^)]*)?\)", description)
    if other and rotating:
        return f" {other[1]}"
    unit = next((u for u in UNITS if re.match(rf"{re.escape(u)}(?![\w/])", description)), "")
    return "°" if unit == "deg" else f" {unit.replace('m2', 'm²').replace('s2', 's²')}" if unit else ""


def _parameters(paper: Paper, found: list[tuple[str, str]], band: float) -> None:
    """The parameters in as many columns as they need, two at least."""
    paper.words(SPLIT + 2.0, band + 5.0, "Parameters", size=3.0, style="strong")
    top, room = band + 9.5, int((BLOCK - band - 10.0) / ROW)
    columns = max(2, -(-len(found) // room))
    size, per = SIZE * min(1.0, 2.6 / columns), -(-len(found) // columns)
    width = (RIGHT - SPLIT - 2.0) / columns
    for place, (key, value) in enumerate(found):
        x, y = SPLIT + 2.0 + width * (place // per), top + ROW * (place % per)
        value = _shortened(value, 0.55 * width - 2.0, size)
        left = width - 3.0 - text_width(value, size)
        paper.words(x, y, _shortened(key, left, size), size=size, style="faint")
        paper.words(x + width - 2.0, y, value, size=size, anchor="end")
    for column in range(1, columns):
        x = SPLIT + 1.0 + width * column
        paper.lines("grid", [(x, band + 7.0), (x, BLOCK - 2.0)])


def _title_block(paper: Paper, model: Model, scale: float) -> None:
    """Name, kind, scale, mass and origin of the drawing, in the lower right corner."""
    paper.box("heavy", SPLIT, BLOCK, RIGHT, BOTTOM)
    profile, mass = model.profile, sum(one.mass for one in model.mass)
    paper.words(SPLIT + 3.0, BLOCK + 8.5, _shortened(profile.name, RIGHT - SPLIT - 6.0, 5.5), size=5.5, style="strong")
    paper.words(SPLIT + 3.0, BLOCK + 14.5, f"{profile.kind} cam, part drawing", size=3.4)
    ratio = f"{number(scale)}:1" if scale >= 1.0 else f"1:{number(1.0 / scale)}"
    direction = "clockwise" if model.mechanism.sense < 0.0 else "counter-clockwise"
    carriage = model.mechanism.carriage
    way = ("Turns, seen from +Z", direction)
    if carriage is not None:
        way = ("Slides", f"along -X, {number(carriage.stroke)} mm")
    block, body = profile.drawing, profile.material.cam
    hard = "" if body.hardness is None else f"{number(body.hardness)} HRC"
    size = "A3, mm, not inch" if profile.units == "inch" else "A3, mm, degrees"
    cells = (
        ("Number", block.number), ("Revision", block.revision), ("Date", block.date), ("Drawn", block.author),
        ("Approved", block.approved), (PROJECTION, ""),
        ("Material", body.name), ("Treatment", block.treatment),
        ("General tolerances", block.general_tolerance), ("Finish of the flanks", block.finish),
        ("Mass", f"{number(mass, 4)} kg"), ("Density", f"{number(body.density)} kg/m³"),
        ("Scale", ratio), ("Sheet, dimensions", size), way,
        ("Profile", visible(Path(profile.source).name)), ("Made with", f"camgeom {__version__}"), ("Hardness", hard),
    )  # fmt: skip
    width, top, pitch = (RIGHT - SPLIT) / COLUMNS, BLOCK + 18.0, 8.0
    for place, (head, text) in enumerate(cells):
        x, y = SPLIT + width * (place % COLUMNS), top + pitch * (place // COLUMNS)
        paper.box("rule", x, y, x + width, y + pitch)
        paper.words(x + 1.2, y + 2.8, head, size=2.1, style="faint")
        if head != PROJECTION:
            shown, room = text or "-", width - 2.4
            fitting = 0.999 * LETTERS[1] * room / text_width(shown, LETTERS[1])
            letters = min(LETTERS[1], max(LETTERS[0], fitting))
            paper.words(x + 1.2, y + 6.8, _shortened(shown, room, letters), size=letters)
    _third_angle(paper, SPLIT + 5.6 * width, top + 0.5 * pitch)


def _third_angle(paper: Paper, x: float, y: float) -> None:
    """The sign of third-angle projection (ISO 5456-2) about (x, y): what is seen from the right stands on the right."""
    for radius in (1.2, 2.4):
        paper.shapes.append(Dot("rule", (x - 3.0, y), radius))
    paper.lines("rule", [(x + 1.0, y - 1.2), (x + 6.0, y - 2.4), (x + 6.0, y + 2.4), (x + 1.0, y + 1.2)], closed=True)
    paper.lines("grid", [(x - 6.0, y), (x + 7.0, y)], [(x - 3.0, y - 3.0), (x - 3.0, y + 3.0)])


def _shortened(text: str, room: float, size: float) -> str:
    """The text, or as much of it as fits `room` mm, with dots."""
    if text_width(text, size) <= room:
        return text
    while text and text_width(text + "...", size) > room:
        text = text[:-1]
    return f"{text.rstrip()}..."
