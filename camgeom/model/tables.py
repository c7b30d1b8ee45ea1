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


SAME = 1e-3
"""share of the segment's angle and of the table's lift within which rows stand where they are"""


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
    stretch: float
    shift: float

    @property
    def laid(self) -> str:
        """How the rows are laid on the segment; empty where they are as they stand."""
        words = [f"angles {self.stretch:.6g} times as wide"] if abs(self.stretch - 1.0) > SAME else []
        words += [f"lifts {self.shift:+.6g}"] if abs(self.shift) > SAME * self.size else []
        return ", ".join(words)

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
        wide = float(angle[-1] - angle[0])
        at = span.start + (span.end - span.start) * (angle - angle[0]) / wide
        lifts = unit * program.jet(at, 0)[0]
        smoothing = float(given.get("smoothing", -1.0))
        found.append(TableFit(i, distances(lift, lifts), at, float(np.ptp(lift)),
                              smoothing if smoothing >= 0.0 else None,
                              float(np.degrees(span.end - span.start)) / wide, float(lifts[0] - lift[0])))  # fmt: skip
    return tuple(found)
