"""The best law for a requirement: time of each against one linear programme of the mesh that it begins on."""

from __future__ import annotations

import math
from functools import partial
from time import process_time

import numpy as np
from kit import Table, best, milli, run, short

from camgeom.motion.optimal.best import Best, sought
from camgeom.motion.optimal.programme import NO_CUTS, Programme, SearchPurse
from camgeom.motion.optimal.search import SPANS
from camgeom.motion.optimal.shape import Shape
from camgeom.motion.optimal.wish import Task, Wish

WISHES = {
    "jerk": Wish("jerk"),
    "acceleration, jerk 60": Wish("peak-acceleration", jerk=60.0),
    "acceleration, jerk 60, velocity 1.6": Wish("peak-acceleration", jerk=60.0, velocity=1.6),
    "inside the modified sine": Wish(
        "peak-acceleration", velocity=1.7596, jerk=69.466, residual=0.04, band=(2.0, 6.0)
    ),
    "acceleration, jerk 400, n = 3 to 10": Wish("peak-acceleration", jerk=400.0, residual=0.0185, band=(3.0, 10.0)),
    "residual, jerk 100, n = 1.5 to 4": Wish("residual", jerk=100.0, band=(1.5, 4.0)),
    "residual, jerk 150, velocity 1.5, n = 3 to 10": Wish("residual", jerk=150.0, velocity=1.5, band=(3.0, 10.0)),
    "rms, jerk 60": Wish("rms-acceleration", jerk=60.0),
    "damped": Wish("peak-acceleration", jerk=100.0, residual=0.02, band=(2.0, 6.0), damping=0.05),
}


def tables(quick: bool) -> list[Table]:
    """A row a wish."""
    mesh = Shape(np.linspace(0.0, 1.0, SPANS + 1), np.zeros(SPANS + 1))
    task = Task.of(WISHES["acceleration, jerk 60"])
    one, _ = best(lambda: Programme(task, mesh, NO_CUTS, 0.0, 0.0).solve(SearchPurse()), 10, clock=process_time)
    rows = []
    for name, wish in WISHES.items():
        time, found = best(partial(sought, wish), 1 if quick else 5, clock=process_time)
        assert isinstance(found, Best)
        gap = f"{found.gap:.1e}" if math.isfinite(found.gap) else "-"
        rows.append({"wish": name, "value": short(found.value, 7), "gap": gap, "time_ms": milli(time),
                     "one_programme_ms": milli(one), "ratio": short(time / one, 3)})
    note = "Processor times. The ratio is to one linear programme on the even mesh; 0.5 s is the aim for each law."
    return [Table("best_law", "The best law for a requirement", rows, note)]


if __name__ == "__main__":
    run(tables, __doc__)
