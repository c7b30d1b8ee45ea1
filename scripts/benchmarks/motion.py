"""Motion programs: one jet of lift to jerk against one sine of the same angles.

Five segments and a thousand, evenly spaced angles and shuffled ones.
"""

from __future__ import annotations

import math

import numpy as np
from kit import Table, best, milli, run, short

from camgeom.motion import Program, Segment

TURN = 2.0 * math.pi


def even_program(count: int) -> Program:
    """A program of `count` moves with four laws in turn."""
    laws = ["modified-sine", "3-4-5", "cycloidal", "polynomial"]
    ends = [TURN * (i + 1) / count for i in range(count)]
    return Program.from_segments([Segment(end, 10.0 * ((i + 1) % 2), laws[i % 4]) for i, end in enumerate(ends)])


def tables(quick: bool) -> list[Table]:
    """A row a program and a number of angles; what building costs."""
    moves = [(155, None), (215, 37.0), (280, 74.0), (290, None), (360, 0.0)]
    five = [Segment(math.radians(end), to, "cycloidal" if to is not None else None) for end, to in moves]
    programs = {"5 segments": Program.from_segments(five), "1000 segments": even_program(1000)}
    rows = []
    for name, program in programs.items():
        for count in (3600,) if quick else (3600, 100_000):
            even = np.linspace(0.0, TURN, count)
            for order, theta in (("sorted", even), ("shuffled", np.random.default_rng(1).permutation(even))):
                jet, _ = best(lambda p=program, t=theta: p.jet(t), 20)
                sine, _ = best(lambda t=theta: np.sin(t), 20)
                rows.append({"program": name, "angles": count, "order": order, "jet_ms": milli(jet),
                             "one_sine_ms": milli(sine), "ratio": short(jet / sine, 3)})
    small, _ = best(lambda: Program.from_segments(five), 20)
    large, _ = best(lambda: even_program(1000), 3)
    built = [{"segments": 5, "time_ms": milli(small)}, {"segments": 1000, "time_ms": milli(large)}]
    return [
        Table("motion", "Lift, velocity, acceleration and jerk beside one sine", rows),
        Table("motion_build", "Building and checking a program", built),
    ]


if __name__ == "__main__":
    run(tables, __doc__)
