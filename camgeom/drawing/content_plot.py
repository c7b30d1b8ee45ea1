"""Charts, maps and polar plots of a report page as frozen data; lengths of arrays are checked where they are made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, final

import numpy as np

from camgeom.maths import Floats

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


def _same_length(name: str, *arrays: Floats) -> None:
    shapes = {array.shape for array in arrays}
    if len(shapes) != 1 or arrays[0].ndim != 1 or len(arrays[0]) == 0:
        raise ValueError(f"series {name!r}: arrays of shapes {sorted(shapes)} are not one line")
    if not all(bool(np.all(np.isfinite(array))) for array in arrays):
        raise ValueError(f"series {name!r}: not finite")
