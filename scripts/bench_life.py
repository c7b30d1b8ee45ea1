"""Speed of the fatigue life as ratios in the same run: many variants in one call against one variant at a time.

python scripts/bench_life.py
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

from camgeom.mechanics.contact import groove_contact
from camgeom.mechanics.fatigue import roller_life
from camgeom.mechanics.load import FollowerForce, FollowerLoad
from camgeom.mechanics.material import STEEL
from camgeom.motion import Program, Segment

SPEED = 60.0
VARIANTS = 1000


def least_time(work: Callable[[], Any], repeat: int) -> float:
    """Least time of a number of calls, s."""
    best = math.inf
    for _ in range(repeat):
        start = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - start)
    return best


def shuttle() -> FollowerForce:
    """A two-stroke motion with dwells, inertia and friction."""
    turn = 2.0 * math.pi
    program = Program.from_segments([
        Segment(0.4 * turn), Segment(0.6 * turn, 40.0, "cycloidal"), Segment(0.78 * turn, 74.0, "modified-sine"),
        Segment(0.8 * turn), Segment(turn, 0.0, "cycloidal")])
    return FollowerLoad(program, SPEED, 2.25, 8.3).sampled()


def life(load: FollowerForce, radius: Any) -> Any:
    """Life for one roller radius or an array of them, mm."""
    return roller_life(groove_contact(load, 67.0, radius, 12.0, STEEL, STEEL, "flat"), STEEL, radius, SPEED)


def main() -> None:
    load = shuttle()
    radii = np.linspace(5.0, 13.0, VARIANTS)
    one = least_time(lambda: life(load, 11.0), 5)
    many = least_time(lambda: life(load, radii), 2)
    print(f"one variant                     {one * 1e3:8.2f} ms")
    print(f"{VARIANTS} variants in one call       {many * 1e3:8.0f} ms")
    print(f"gain of the one call            {VARIANTS * one / many:8.1f} times")


if __name__ == "__main__":
    main()
