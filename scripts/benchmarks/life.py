"""Fatigue life: many variants in one call against one variant at a time, and how time and memory grow.

A two-stroke groove cam with inertia and friction; the variants differ in roller radius.
"""

from __future__ import annotations

import math
import resource
from typing import Any

import numpy as np
from kit import Table, best, milli, run, short

from camgeom.mechanics.groove import groove_contact
from camgeom.mechanics.life import roller_life
from camgeom.mechanics.load import FollowerForce, Load
from camgeom.mechanics.material import STEEL
from camgeom.motion import Program, Segment

SPEED = 60.0


def shuttle() -> FollowerForce:
    """A two-stroke motion with dwells, inertia and friction."""
    turn = 2.0 * math.pi
    program = Program.from_segments([
        Segment(0.4 * turn), Segment(0.6 * turn, 40.0, "cycloidal"), Segment(0.78 * turn, 74.0, "modified-sine"),
        Segment(0.8 * turn), Segment(turn, 0.0, "cycloidal")])
    return Load(program, SPEED, 2.25, 8.3).sampled()


def life(load: FollowerForce, radius: Any) -> Any:
    """Life for one roller radius or an array of them, mm."""
    return roller_life(groove_contact(load, 67.0, radius, 12.0, STEEL, STEEL, "flat"), STEEL, radius, SPEED)


def tables(quick: bool) -> list[Table]:
    """Variants from one to ten thousand."""
    load = shuttle()
    one, _ = best(lambda: life(load, 11.0), 9)
    rows = [{"variants": 1, "time_ms": milli(one), "us_a_variant": short(one * 1e6), "gain": 1.0,
             "peak_memory_mb": memory()}]
    for count in (10, 100, 1000) if quick else (10, 100, 1000, 10_000):
        radii = np.linspace(5.0, 13.0, count)
        seconds, _ = best(lambda r=radii: life(load, r), 3)
        rows.append({"variants": count, "time_ms": milli(seconds), "us_a_variant": short(seconds / count * 1e6),
                     "gain": short(count * one / seconds, 3), "peak_memory_mb": memory()})
    note = "gain: against as many calls of one variant each."
    return [Table("life", "Roller life of many variants in one call", rows, note)]


def memory() -> float:
    """Peak memory of this process so far, MB."""
    return short(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3, 3)


if __name__ == "__main__":
    run(tables, __doc__)
