"""Contact of a roller of real length: error and time of the half-space against exact ellipse and line, and its growth.

500 N on a steel roller of 20 mm diameter and 10 mm length, on a disc of 55 mm radius; errors against Hertz's ellipse.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from kit import Plot, Row, Table, best, milli, run, short

from camgeom.mechanics import hertz
from camgeom.mechanics.finite_contact import AxialProfile, Bodies, press
from camgeom.mechanics.halfspace import Even, pressed
from camgeom.mechanics.material import STEEL, pair_compliance

LOAD, CURVATURE, HALF = 500.0, 0.1 + 1.0 / 55.0, 5.0
PAIR = pair_compliance(STEEL, STEEL)
CROWNS = (5000.0, 500.0, 100.0, 20.0)


def fixed(crown: float, n: int) -> tuple[float, float, int]:
    """Error of the peak, seconds and steps of n x n cells on a window 1.12 times the ellipse."""
    exact = hertz.point_contact(LOAD, 1.0 / crown, CURVATURE, PAIR)
    wide, long = 1.12 * float(exact.short), 1.12 * float(exact.long)
    dx, dy = 2.0 * wide / n, 2.0 * long / n
    x, y = (np.arange(n) + 0.5) * dx - wide, (np.arange(n) + 0.5) * dy - long
    gap = Bodies(CURVATURE, AxialProfile(-50.0, 50.0, crown), PAIR).gap(x, y)
    guess = np.sqrt(np.maximum(1.0 - (x[:, None] / wide) ** 2 - (y / long) ** 2, 0.0))

    def work() -> Any:
        return pressed(gap, Even(n, n, dx, dy, PAIR), np.array(dx * dy), LOAD, guess)

    seconds, found = best(work, 7)
    # The four cells about the middle stand half a cell off it: the square of an ellipse is a parabola.
    top = np.sqrt(float(np.square(found.pressure).max()) / (1.0 - 0.25 * (dx / (wide / 1.12)) ** 2
                                                           - 0.25 * (dy / (long / 1.12)) ** 2))  # fmt: skip
    return abs(top / float(exact.pressure) - 1.0), seconds, found.steps


def grids(quick: bool) -> Table:
    """Error and time over the cells."""
    rows: list[Row] = []
    for crown in CROWNS:
        for n in (16, 32, 64) if quick else (16, 32, 64, 128):
            error, seconds, steps = fixed(crown, n)
            rows.append({"crown_mm": crown, "cells": f"{n} x {n}", "across": n, "time_ms": milli(seconds),
                         "error_percent": short(100.0 * error), "steps": steps})
    note = "One contact on a fitted window. The budget is 15 ms at 64 x 64 and 0.1 per cent."
    return Table("contact_grids", "Half-space against the exact ellipse", rows, note,
                 Plot("time_ms", "error_percent", "crown_mm", "time, ms", "error of the peak, %"))


def whole(quick: bool) -> Table:
    """Contacts found from nothing: window, coarse pass, half grid for the error, solution."""
    del quick
    cases = {
        "crown of 500 mm": (AxialProfile(-HALF, HALF, 500.0), 0.0),
        "crown of 500 mm, tilted 0.1 deg": (AxialProfile(-HALF, HALF, 500.0), np.radians(0.1)),
        "logarithmic, tilted 0.05 deg": (AxialProfile(-HALF, HALF, run_out=0.007), np.radians(0.05)),
        "end radius 1 mm, tilted 0.02 deg": (AxialProfile(-HALF, HALF, end_radius=1.0), np.radians(0.02)),
        "sharp, tilted 0.02 deg": (AxialProfile(-HALF, HALF), np.radians(0.02)),
    }
    rows: list[Row] = []
    for name, (profile, tilt) in cases.items():
        bodies = Bodies(CURVATURE, profile, PAIR, tilt)
        seconds, found = best(lambda b=bodies: press.__wrapped__(b, LOAD), 5)  # the latest are kept
        rows.append({"roller": name, "time_ms": milli(seconds), "cells": " x ".join(map(str, found.pressure.shape)),
                     "peak_mpa": "unbounded" if found.unbounded else short(found.peak[0]),
                     "told_error_percent": short(100.0 * found.error), "length_mm": short(found.length),
                     "load_centre_mm": short(found.centre, 3)})
    note = "The error is that against half as many cells."
    return Table("contact_whole", "Contacts of rollers with ends", rows, note)


def tables(quick: bool) -> list[Table]:
    """Grids and whole contacts."""
    return [grids(quick), whole(quick)]


if __name__ == "__main__":
    run(tables, __doc__)
