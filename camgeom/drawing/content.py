"""What a report page says, as frozen data with no layout and no cam facts: the renderer draws it, the sections fill it.

Lengths of arrays are checked where they are made, so a page that exists can be drawn. Text is plain text everywhere;
the renderer escapes it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Literal, final

import numpy as np

from camgeom.maths import Floats
from camgeom.maths.mesh import Mesh

Width = Literal["full", "half"]
"""The whole text column, or one of two columns on a wide screen."""


@final
@dataclass(frozen=True, slots=True)
class Axis:
    """A quantity with its unit; `low` and `high` fix the range, otherwise the data and `zero` (include zero) do."""

    label: str
    unit: str = ""
    low: float | None = None
    high: float | None = None
    zero: bool = False

    @property
    def title(self) -> str:
        """Label and unit as printed at an axis: `Lift s, mm`."""
        return f"{self.label}, {self.unit}" if self.unit else self.label


CAM_ANGLE = Axis("Cam angle", "°", 0.0, 360.0)
"""The axis that charts, maps and the 3D view share: on the page their cursors move together."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Series:
    """A line y(x); NaN-free. `style` picks colour and dash (0 to 5); None takes the next in the panel."""

    name: str
    x: Floats
    y: Floats
    style: int | None = None
    dots: bool = False
    """Its points alone, without the line."""

    def __post_init__(self) -> None:
        _same_length(self.name, self.x, self.y)


@final
@dataclass(frozen=True, slots=True, eq=False)
class Band:
    """The area between low(x) and high(x), such as a natural frequency over all cam angles."""

    name: str
    x: Floats
    low: Floats
    high: Floats
    style: int | None = None

    def __post_init__(self) -> None:
        _same_length(self.name, self.x, self.low, self.high)


@final
@dataclass(frozen=True, slots=True)
class Zone:
    """A shaded range of x, such as a dwell, with an optional short label."""

    low: float
    high: float
    label: str = ""


@final
@dataclass(frozen=True, slots=True)
class Limit:
    """A limit at a constant y, labelled at its line; where `vertical`, a quiet line at an x such as a working speed."""

    value: float
    label: str
    vertical: bool = False


@final
@dataclass(frozen=True, slots=True)
class Mark:
    """A point with its characteristic value written beside it."""

    x: float
    y: float
    text: str


@final
@dataclass(frozen=True, slots=True)
class Panel:
    """One y axis over the x axis of its chart."""

    y: Axis
    series: tuple[Series, ...] = ()
    bands: tuple[Band, ...] = ()
    limits: tuple[Limit, ...] = ()
    marks: tuple[Mark, ...] = ()
    direct: bool = False
    """Name the lines at their right ends instead of in a legend (Campbell diagrams)."""
    height: float = 1.0
    """Relative to the normal panel height."""


@final
@dataclass(frozen=True, slots=True)
class Chart:
    """Panels stacked over one x axis: motion diagrams, responses, histories, Campbell diagrams."""

    caption: str
    x: Axis
    panels: tuple[Panel, ...]
    zones: tuple[Zone, ...] = ()
    width: Width = "full"


@final
@dataclass(frozen=True, slots=True, eq=False)
class Map:
    """A heat map: values (m, n) at cell centres y (m,) and x (n,), both evenly spaced and rising; NaN is left blank."""

    caption: str
    x: Axis
    y: Axis
    value: Axis
    x_at: Floats
    y_at: Floats
    values: Floats
    diverging: bool = False
    """Two colours about zero, for signed quantities."""
    marks: tuple[Mark, ...] = ()
    width: Width = "full"
    to_scale: bool = False
    """Both axes are lengths of one place and get one scale."""

    def __post_init__(self) -> None:
        if self.values.shape != (len(self.y_at), len(self.x_at)) or min(self.values.shape) < 2:
            raise ValueError(f"map {self.caption!r}: values {self.values.shape} do not fit y and x")
        if not np.any(np.isfinite(self.values)):
            raise ValueError(f"map {self.caption!r}: no finite value")


@final
@dataclass(frozen=True, slots=True)
class Polar:
    """Lines over a full turn, angle (degrees) from the right, counter-clockwise; the radius is the value from zero."""

    caption: str
    value: Axis
    series: tuple[Series, ...]
    marks: tuple[Mark, ...] = ()
    width: Width = "half"


@final
@dataclass(frozen=True, slots=True, eq=False)
class Parallel:
    """Parallel coordinates: upright axes side by side, each with its own scale, a line across them for every row."""

    caption: str
    axes: tuple[Axis, ...]
    lines: Floats
    """(rows, axes)"""
    chosen: int
    """the row that stands out"""
    width: Width = "full"

    def __post_init__(self) -> None:
        if self.lines.ndim != 2 or self.lines.shape[1] != len(self.axes) or not np.all(np.isfinite(self.lines)):
            raise ValueError(f"parallel coordinates {self.caption!r}: lines {self.lines.shape} do not fit their axes")


def _same_length(name: str, *arrays: Floats) -> None:
    shapes = {array.shape for array in arrays}
    if len(shapes) != 1 or arrays[0].ndim != 1 or len(arrays[0]) == 0:
        raise ValueError(f"series {name!r}: arrays of shapes {sorted(shapes)} are not one line")
    if not all(bool(np.all(np.isfinite(array))) for array in arrays):
        raise ValueError(f"series {name!r}: not finite")


Point = tuple[float, float]


@final
@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """An outline in mm, (n, 2). `kind`: outline, thin, hidden (dashed), axis (chain line), trace (accent), part (filled
    section), ghost (filled faintly)."""

    points: Floats
    kind: Literal["outline", "thin", "hidden", "axis", "trace", "part", "ghost"] = "outline"
    closed: bool = False
    holes: tuple[Floats, ...] = ()
    """More closed outlines (k, 2) of a filled one, left open where they lie inside it"""


@final
@dataclass(frozen=True, slots=True)
class Circle:
    """A circle in mm; kinds as in `Path`."""

    centre: Point
    radius: float
    kind: Literal["outline", "thin", "hidden", "axis", "trace", "part", "ghost"] = "outline"


@final
@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """Cut material in mm: closed outlines (k, 2), holes among them, hatched."""

    loops: tuple[Floats, ...]


@final
@dataclass(frozen=True, slots=True)
class Dimension:
    """A linear dimension from p to q (mm), drawn outside the view on the named side; `below` and `above` measure along
    x, `left` and `right` along y. Dimensions on one side are stacked clear of each other."""

    p: Point
    q: Point
    text: str
    side: Literal["below", "above", "left", "right"]


@final
@dataclass(frozen=True, slots=True)
class Leader:
    """A note beside the view with a line to the point `to` (mm): diameters, radii, names. In a narrow setting the point
    gets a number and the note stands in a list under the view."""

    to: Point
    text: str


@final
@dataclass(frozen=True, slots=True)
class Drawing:
    """A view to scale in mm, x right and y up, with dimensions and notes."""

    caption: str
    paths: tuple[Path, ...] = ()
    circles: tuple[Circle, ...] = ()
    dimensions: tuple[Dimension, ...] = ()
    leaders: tuple[Leader, ...] = ()
    regions: tuple[Region, ...] = ()
    width: Width = "full"
    stretch: bool = False
    """Fill the width with different scales along x and y (a developed view): no true angles."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Actor:
    """One rigid body of a scene: its mesh at pose identity, and poses (n, 3, 4) [R | t] in the machine frame at the
    scene's cam angles; None for a body that stands still. `fields` are results on its vertices, (v,), by the key of a
    shade; NaN where a vertex has none."""

    name: str
    mesh: Mesh
    poses: Floats | None = None
    role: Literal["cam", "follower", "frame"] = "cam"
    fields: Mapping[str, Floats] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if any(values.shape != (len(self.mesh.vertices),) for values in self.fields.values()):
            raise ValueError(f"body {self.name!r}: a field does not fit its {len(self.mesh.vertices)} vertices")


@final
@dataclass(frozen=True, slots=True)
class Shade:
    """How a field of the bodies is shown: its key, label, unit, and whether it is signed about zero.

    Only faces of the named groups take the colour; all that have values at every corner where none is named.
    """

    key: str
    label: str
    unit: str = ""
    diverging: bool = False
    groups: tuple[str, ...] = ()


@final
@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """An interactive 3D view of bodies over one cam turn. `readouts` (n,) run beside the slider: lift, pressure."""

    caption: str
    angles: Floats
    """(n,) cam angles, degrees, rising from the first to the last frame"""
    bodies: tuple[Actor, ...]
    shades: tuple[Shade, ...] = ()
    readouts: tuple[tuple[Axis, Floats], ...] = ()
    speed: float = 60.0
    """r/min of the real cam, stated beside the animation's slow-motion factor"""
    still: Drawing | None = None
    """What stands in its place where no 3D view can start"""
    eye: tuple[float, float, float] | None = None
    """Direction to the eye at first; None: the viewer's own, beside what stands at +X"""

    def __post_init__(self) -> None:
        for body in self.bodies:
            if body.poses is not None and body.poses.shape != (len(self.angles), 3, 4):
                raise ValueError(f"body {body.name!r}: poses {body.poses.shape} do not fit {len(self.angles)} angles")


class Level(Enum):
    """How a judgement ends: it passes, a designer would want to know, or it fails."""

    PASS = "pass"
    WARN = "warn"
    FAIL = "fail"


Cell = str | float | int | bool | Level | None
"""A table cell: text, a number (set right, four significant digits), a verdict (True passes), or nothing."""


@final
@dataclass(frozen=True, slots=True)
class Remark:
    """One judged fact: what was checked, its value against its limit, where it occurs and what to do about it."""

    check: str
    level: Level
    value: Cell = None
    limit: str | None = None
    """with its comparison and unit, for example `<= 30°`"""
    unit: str = ""
    where: str = ""
    advice: str = ""


@final
@dataclass(frozen=True, slots=True)
class Figure:
    """A key figure: label, value, unit, and one short line of context."""

    label: str
    value: Cell
    unit: str = ""
    note: str = ""


@final
@dataclass(frozen=True, slots=True)
class Column:
    """A table column: heading and unit."""

    label: str
    unit: str = ""


@final
@dataclass(frozen=True, slots=True)
class Table:
    """Rows under headings; numbers are set right, text left."""

    caption: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    width: Width = "full"

    def __post_init__(self) -> None:
        if any(len(row) != len(self.columns) for row in self.rows):
            raise ValueError(f"table {self.caption!r}: a row does not fit its {len(self.columns)} columns")


def quantities(caption: str, rows: Sequence[tuple[Cell, ...]]) -> Table:
    """A table of named quantities with value and unit, and the cam angle, degrees, where the rows have one."""
    heads = (Column("Quantity"), Column("Value"), Column("Unit"), Column("Cam angle", "°"))
    return Table(caption, heads[: len(rows[0])], tuple(rows))


@final
@dataclass(frozen=True, slots=True)
class Text:
    """Paragraphs of plain text."""

    paragraphs: tuple[str, ...]


@final
@dataclass(frozen=True, slots=True)
class Cost:
    """What was computed and the seconds it took, and what nobody asked for."""

    computed: tuple[tuple[str, float], ...]
    skipped: tuple[str, ...] = ()


Block = Text | Table | Chart | Map | Polar | Parallel | Drawing | Scene | Cost


@final
@dataclass(frozen=True, slots=True)
class Chapter:
    """A numbered section: `key` is its anchor and its name for `--only`."""

    key: str
    title: str
    blocks: tuple[Block, ...]


@final
@dataclass(frozen=True, slots=True)
class Page:
    """A whole report: verdict first, then key figures, then sections. `details` fills the title block."""

    title: str
    kind: str
    level: Level | None
    """the worst of the findings; None where nothing was judged"""
    summary: str = ""
    findings: tuple[Remark, ...] = ()
    figures: tuple[Figure, ...] = ()
    sections: tuple[Chapter, ...] = ()
    details: tuple[tuple[str, str], ...] = field(default=())
    omitted: tuple[tuple[str, str], ...] = ()
    """checks that apply and were not judged, each with the reason"""
    headline: str = ""
    """what stands at the head of a page that judges no design"""
