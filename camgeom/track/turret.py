"""The grooves of an indexing cam: each roller of a turret followed through all its turns beside the cam.

A turret that steps by several roller pitches in a cam turn needs as many different grooves (starts); every roller of
the turret runs through one of them, some turns earlier or later. A turret that swings to and fro has one closed groove
for every roller that comes beside the cam.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from math import ceil, floor, pi

import numpy as np

from camgeom.motion.program import Program
from camgeom.track import TURN, Track


def turret_tracks(first: Track, rollers: int, base: float, reach: float) -> tuple[Track, ...]:
    """Tracks of all grooves from that of one roller (its shift is ignored).

    rollers  on the turret, evenly spaced; base: angle of the first one from the line of centres in the first dwell, rad
    reach    angle from the line of centres, rad, within which a roller is followed
    """
    pitch = TURN / rollers
    if first.program.closed:
        return _oscillating(first, rollers, base, pitch, reach)
    starts = max(1, round(abs(first.program.advance) / pitch))
    found = []
    for j in range(starts):
        shift = base + j * pitch
        name = f"{first.name} {j + 1}" if starts > 1 else first.name
        found.append(replace(first, shift=shift, span=engaged_span(first.program, shift, reach), name=name))
    return tuple(found)


def _oscillating(first: Track, rollers: int, base: float, pitch: float, reach: float) -> tuple[Track, ...]:
    """To-and-fro drives: every roller that comes beside the cam has its own closed groove."""
    lifts = [lift for span in first.program.spans for lift in (span.before, span.after)]
    found: list[Track] = []
    for k in range(-rollers, rollers + 1):
        shift = base + k * pitch
        if shift + max(lifts) > -reach and shift + min(lifts) < reach and abs(shift) <= pi:
            found.append(replace(first, shift=shift, span=(0.0, TURN), name=f"{first.name} {len(found) + 1}"))
    return tuple(found)


@lru_cache(maxsize=256)
def engaged_span(program: Program, shift: float, reach: float) -> tuple[float, float]:
    """Cam angles (over several turns) between which the turret angle lift + shift lies within +-reach, rad."""
    advance = program.advance
    low = TURN * floor((-reach - shift) / advance - 1.0)
    high = TURN * ceil((reach - shift) / advance + 1.0)

    def crossing(level: float) -> float:
        a, b = low, high
        for _ in range(80):
            grid = np.linspace(a, b, 9)
            beyond = program.jet(grid, 0)[0] + shift >= level
            first = max(1, int(np.argmax(beyond))) if beyond.any() else 8
            a, b = float(grid[first - 1]), float(grid[first])
            if b - a <= 4.0 * np.spacing(abs(b) + abs(a)):
                break
        return b

    return crossing(-reach), crossing(reach)
