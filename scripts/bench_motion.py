"""Speed of motion programs as ratios in the same run: one jet of lift to jerk against one sine of the same angles.

python scripts/bench_motion.py
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np

from camgeom.motion import Program, Segment

TURN = 2.0 * math.pi


def least_time(work: Callable[[], Any], repeat: int) -> float:
    """Least time of a number of calls, s."""
    best = math.inf
    for _ in range(repeat):
        start = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - start)
    return best


def even_program(count: int) -> Program:
    """A program of `count` moves with four laws in turn."""
    laws = ["modified-sine", "3-4-5", "cycloidal", "polynomial"]
    ends = [TURN * (i + 1) / count for i in range(count)]
    return Program.from_segments([Segment(end, 10.0 * ((i + 1) % 2), laws[i % 4]) for i, end in enumerate(ends)])


def main() -> None:
    """Print a row a program and a number of angles."""
    moves = [(155, None), (215, 37.0), (280, 74.0), (290, None), (360, 0.0)]
    five = [Segment(math.radians(end), to, "cycloidal" if to is not None else None) for end, to in moves]
    programs = {"5 segments": Program.from_segments(five), "1000 segments": even_program(1000)}
    print(f"{'program':>14} {'angles':>8} {'order':>9} {'jet, ms':>8} {'one sine, ms':>13} {'ratio':>6}")
    for name, program in programs.items():
        for count in (3600, 100_000):
            even = np.linspace(0.0, TURN, count)
            for order, theta in (("sorted", even), ("shuffled", np.random.default_rng(1).permutation(even))):
                jet = least_time(lambda: program.jet(theta), 20)  # noqa: B023
                sine = least_time(lambda: np.sin(theta), 20)  # noqa: B023
                print(f"{name:>14} {count:8d} {order:>9} {jet * 1e3:8.3f} {sine * 1e3:13.3f} {jet / sine:6.1f}")
    build = least_time(lambda: even_program(1000), 3) / least_time(lambda: Program.from_segments(five), 20)
    print(f"building 1000 segments costs {build:.0f} times what building 5 costs")


if __name__ == "__main__":
    main()
