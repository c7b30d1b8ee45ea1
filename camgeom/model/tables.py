"""How near the motion runs to the rows of the tables that its segments follow."""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING, final

import numpy as np

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.motion.measured import distances

if TYPE_CHECKING:
    from camgeom.model import Model


@final
@immutable
class TableFit:
    """A segment that follows a table, by its number: how far the motion runs above each row, mm or deg, at which cam
    angle, rad, (n,) each, the span of the table's lifts, mm or deg, and the standard deviation of them that the profile
    states, None where it leaves it to the data."""

    segment: int
    distance: Floats
    angle: Floats
    size: float
    smoothing: float | None

    @property
    def largest(self) -> tuple[float, float]:
        """Largest distance, and its cam angle, rad."""
        worst = int(np.argmax(np.abs(self.distance)))
        return abs(float(self.distance[worst])), float(self.angle[worst])

    @property
    def rms(self) -> float:
        """Root of the mean square of all distances."""
        return float(np.sqrt(np.mean(self.distance**2)))


def table_fits(model: Model) -> tuple[TableFit, ...]:
    """Those of the segments that a profile states: what mirrors them is as near."""
    program, unit, found = model.setup.program, 180.0 / pi if model.profile.rotating else 1.0, []
    for i, (segment, span) in enumerate(zip(model.profile.motion, program.spans)):
        given = dict(segment.parameters)
        if segment.law != "table" or not given.get("rows"):
            continue
        angle, lift = np.array(given["rows"], dtype=np.float64).T
        at = span.start + (span.end - span.start) * (angle - angle[0]) / (angle[-1] - angle[0])
        far = distances(lift, unit * program.jet(at, 0)[0])
        smoothing = float(given.get("smoothing", -1.0))
        found.append(TableFit(i, far, at, float(np.ptp(lift)), smoothing if smoothing >= 0.0 else None))
    return tuple(found)
