"""The part drawing: one sheet with true sections and main dimensions, motion diagram, parameters and title block."""

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
from camgeom.errors import CamgeomError, DesignError, ExportError, visible
from camgeom.export.files import write_whole
from camgeom.immutable import immutable
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
SCALES = (50.0, 20.0, 10.0, 5.0, 2.0, 1.0, 0.5, 0.4, 0.2, 0.1, 0.05, 0.02, 0.01)
"""ISO 5455, and 1:2.5, which shops draw discs and drums in"""
LOWER = 130.0, 100.0
"""mm, heights that the band with the motion diagram and the parameters may have; of larger sheets so much larger"""
PANEL = 0.92, 0.6
"""height of a panel of the motion diagram at each, as a share of the report's"""
HEAD, GAP = 8.0, 2.0
"""mm, room for a view's caption, and beside the frame"""
NARROWEST = 64.0
"""mm, least width of a view, for its caption"""
BLOCK = 192.0, 42.0
"""mm, width of the title block, over which the parameters stand, and its height"""
SPARED = 0.5
"""of the scale that the largest view alone would have, below which the views of a sheet ask for a larger one"""
READ = 3
"""columns of parameters whose letters are as large as ISO 3098 asks; more ask for a larger sheet"""
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


@immutable(eq=True)
class Format:
    """A sheet that lies, by its name in ISO 216: its size, mm, and what is where on it."""

    name: str
    width: float
    height: float

    @property
    def right(self) -> float:
        """Of the frame."""
        return self.width - WIDTH + RIGHT

    @property
    def bottom(self) -> float:
        """Of the frame."""
        return self.height - HEIGHT + BOTTOM

    @property
    def split(self) -> float:
        """Where the motion diagram ends and the parameters begin."""
        return self.right - BLOCK[0]

    @property
    def block(self) -> float:
        """Upper edge of the title block."""
        return self.bottom - BLOCK[1]

    @property
    def bands(self) -> dict[float, float]:
        """Lower edges that the band with the views may have, and the height of a panel below each."""
        large = self.height / HEIGHT
        return {self.bottom - large * low: large * panel for low, panel in zip(LOWER, PANEL)}

    def columns(self, count: int, band: float) -> int:
        """Of so many parameters; two at least."""
        return max(2, -(-count // int((self.block - band - 10.0) / ROW)))


FORMATS = Format("A3", WIDTH, HEIGHT), Format("A2", 594.0, 420.0), Format("A1", 841.0, 594.0)


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
    # Sizes are read off the bodies as they are exported, not off those of the page's pictures.
    views = part_views(model, tuple((solid.name, solid.mesh) for solid in model.solids))
    found = rows(model)
    plan = _plan(views, len(found))
    own = plan.form
    paper = Paper(own.width, own.height, model.profile.name)
    paper.box("border", LEFT, TOP, own.right, own.bottom)
    _views(paper, views, plan)
    _motion(paper, diagrams(model), plan)
    _parameters(paper, found, plan)
    _title_block(paper, model, plan)
    return paper


@immutable(eq=True)
class Plan:
    """A sheet, the lower edge of the views' band on it, mm, and the scale of the views, whose widths these are, mm."""

    form: Format
    band: float
    scale: float
    widths: tuple[float, ...]

    @property
    def tall(self) -> float:
        """mm, height that the views may have."""
        return self.band - TOP - HEAD - 2.0

    @property
    def room(self) -> float:
        """mm, width that they may have together."""
        return self.form.right - LEFT - 2.0 * GAP


def _plan(views: tuple[Drawing, ...], count: int) -> Plan:
    """The smallest sheet on which views side by side are not much smaller than the largest would be alone on A3, and
    `count` parameters can be read; the largest sheet where there is none. Raises DesignError where none has room."""
    each = [plan.scale for view in views if (plan := _planned(FORMATS[0], (view,))) is not None]
    least = SPARED * min(each, default=0.0)
    plans = [plan for form in FORMATS if (plan := _planned(form, views)) is not None]
    if not plans:
        raise DesignError("no sheet up to A1 has room for the cam at a scale of the standard series")
    read = (plan for plan in plans if plan.scale >= least and plan.form.columns(count, plan.band) <= READ)
    return next(read, plans[-1])


def _planned(form: Format, views: tuple[Drawing, ...]) -> Plan | None:
    """The largest scale of the standard series that has room for all views, and the lowest band only where that gives
    a larger one; None where there is none."""

    def fitted(scale: float, band: float) -> Plan | None:
        sizes = [drawing_size(view, scale / PX) for view in views]
        plan = Plan(form, band, scale, tuple(max(NARROWEST, size[0] * PX) for size in sizes))
        high = max(size[1] for size in sizes) * PX
        return plan if sum(plan.widths) <= plan.room and high <= plan.tall else None

    found = [next((plan for s in SCALES if (plan := fitted(s, band))), None) for band in form.bands]
    plans = [plan for plan in found if plan is not None]
    return max(plans, key=lambda plan: (plan.scale, -plan.band), default=None)


def _views(paper: Paper, views: tuple[Drawing, ...], plan: Plan) -> None:
    """The views side by side."""
    spare, x = max(0.0, plan.room - sum(plan.widths)), LEFT + GAP
    for view, width in zip(views, plan.widths):
        width += spare / len(views)
        sheet = drawing_sheet(view, width / PX, plan.scale / PX)
        for row, line in enumerate(_lines(view.caption, width - GAP, 3.0)):
            paper.words(x, TOP + 4.2 + 3.6 * row, line, size=3.0)
        paper.place(sheet, x, TOP + HEAD + 0.5 * max(0.0, plan.tall - sheet.height * PX))
        x += width
    paper.lines("rule", [(LEFT, plan.band), (plan.form.right, plan.band)])


def _motion(paper: Paper, chart: Chart, plan: Plan) -> None:
    """Lift, velocity and acceleration."""
    form, band = plan.form, plan.band
    lower = tuple(replace(panel, height=form.bands[band]) for panel in chart.panels[:3])
    shown = Chart(chart.caption, chart.x, lower, chart.zones)
    paper.words(LEFT + 2.0, band + 5.0, chart.caption, size=3.0)
    sheet = chart_sheet(shown, (form.split - LEFT - 6.0) / PX)
    paper.place(sheet, LEFT + 2.0, band + 7.0)
    paper.lines("rule", [(form.split, band), (form.split, form.bottom)])


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
    if own.operation is not None:
        found += _section_rows(word, own.operation, own.rotating, tuple(track.operation))
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
    other = re.match(r"[^(;]*\((N[^)]*?)(?: (?:for|of) [^)]*)?\)", description)
    if other and rotating:
        return f" {other[1]}"
    unit = next((u for u in UNITS if re.match(rf"{re.escape(u)}(?![\w/])", description)), "")
    return "°" if unit == "deg" else f" {unit.replace('m2', 'm²').replace('s2', 's²')}" if unit else ""


def _parameters(paper: Paper, found: list[tuple[str, str]], plan: Plan) -> None:
    """The parameters in as many columns as they need, two at least."""
    form, band = plan.form, plan.band
    paper.words(form.split + 2.0, band + 5.0, "Parameters", size=3.0, style="strong")
    top, columns = band + 9.5, form.columns(len(found), band)
    size, per = SIZE * min(1.0, 2.6 / columns), -(-len(found) // columns)
    width = (form.right - form.split - 2.0) / columns
    for place, (key, value) in enumerate(found):
        x, y = form.split + 2.0 + width * (place // per), top + ROW * (place % per)
        value = _shortened(value, 0.55 * width - 2.0, size)
        left = width - 3.0 - text_width(value, size)
        paper.words(x, y, _shortened(key, left, size), size=size, style="faint")
        paper.words(x + width - 2.0, y, value, size=size, anchor="end")
    for column in range(1, columns):
        x = form.split + 1.0 + width * column
        paper.lines("grid", [(x, band + 7.0), (x, form.block - 2.0)])


def _title_block(paper: Paper, model: Model, plan: Plan) -> None:
    """Name, kind, scale, mass and origin of the drawing, in the lower right corner."""
    form, scale = plan.form, plan.scale
    left, above = form.split, form.block
    paper.box("heavy", left, above, form.right, form.bottom)
    profile, mass = model.profile, sum(one.mass for one in model.mass)
    title = _shortened(profile.name, BLOCK[0] - 6.0, 5.5)
    paper.words(left + 3.0, above + 8.5, title, size=5.5, style="strong")
    paper.words(left + 3.0, above + 14.5, f"{profile.kind} cam, part drawing", size=3.4)
    ratio = f"{number(scale)}:1" if scale >= 1.0 else f"1:{number(1.0 / scale)}"
    direction = "clockwise" if model.mechanism.sense < 0.0 else "counter-clockwise"
    carriage = model.mechanism.carriage
    way = ("Turns, seen from +Z", direction)
    if carriage is not None:
        way = ("Slides", f"along -X, {number(carriage.stroke)} mm")
    block, body = profile.drawing, profile.material.cam
    hard = "" if body.hardness is None else f"{number(body.hardness)} HRC"
    size = f"{form.name}, mm, {'not inch' if profile.units == 'inch' else 'degrees'}"
    cells = (
        ("Number", block.number), ("Revision", block.revision), ("Date", block.date), ("Drawn", block.author),
        ("Approved", block.approved), (PROJECTION, ""),
        ("Material", body.name), ("Treatment", block.treatment),
        ("General tolerances", block.general_tolerance), ("Finish of the flanks", block.finish),
        ("Mass", f"{number(mass, 4)} kg"), ("Density", f"{number(body.density)} kg/m³"),
        ("Scale", ratio), ("Sheet, dimensions", size), way,
        ("Profile", visible(Path(profile.source).name)), ("Made with", f"camgeom {__version__}"), ("Hardness", hard),
    )  # fmt: skip
    width, top, pitch = (form.right - left) / COLUMNS, above + 18.0, 8.0
    for place, (head, text) in enumerate(cells):
        x, y = left + width * (place % COLUMNS), top + pitch * (place // COLUMNS)
        paper.box("rule", x, y, x + width, y + pitch)
        paper.words(x + 1.2, y + 2.8, head, size=2.1, style="faint")
        if head != PROJECTION:
            shown, room = text or "-", width - 2.4
            fitting = 0.999 * LETTERS[1] * room / text_width(shown, LETTERS[1])
            letters = min(LETTERS[1], max(LETTERS[0], fitting))
            paper.words(x + 1.2, y + 6.8, _shortened(shown, room, letters), size=letters)
    _third_angle(paper, left + 5.6 * width, top + 0.5 * pitch)


def _third_angle(paper: Paper, x: float, y: float) -> None:
    """The sign of third-angle projection (ISO 5456-2) about (x, y): what is seen from the right stands on the right."""
    for radius in (1.2, 2.4):
        paper.shapes.append(Dot("rule", (x - 3.0, y), radius))
    paper.lines("rule", [(x + 1.0, y - 1.2), (x + 6.0, y - 2.4), (x + 6.0, y + 2.4), (x + 1.0, y + 1.2)], closed=True)
    paper.lines("grid", [(x - 6.0, y), (x + 7.0, y)], [(x - 3.0, y - 3.0), (x - 3.0, y + 3.0)])


def _lines(text: str, room: float, size: float) -> list[str]:
    """The text on one line, or on two where it has to be, broken at a space; what is more is cut."""
    words, first = text.split(" "), ""
    while words and text_width(f"{first} {words[0]}", size) <= room:
        first = f"{first} {words.pop(0)}".strip()
    return [line for line in (first, _shortened(" ".join(words), room, size)) if line]


def _shortened(text: str, room: float, size: float) -> str:
    """The text, or as much of it as fits `room` mm, with dots."""
    if text_width(text, size) <= room:
        return text
    while text and text_width(text + "...", size) > room:
        text = text[:-1]
    return f"{text.rstrip()}..."
