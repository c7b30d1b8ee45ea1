"""What a best law is built of, seen on a mesh that becomes finer where its jerk changes.

On fixed breaks a linear programme finds the best of all shapes, but a change of the jerk, or a hold shorter than a
span, leaves a span or two there whose jerk is neither at its limit nor none. Divided, they show what they hide: where
the jerk changes, that it does so twice, or that acceleration or velocity is held for a moment. Of that a law is made
whose breaks are near enough to where they belong for Newton's method.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats
from camgeom.motion.optimal.shape import Shape
from camgeom.motion.optimal.wish import Task

PARTS, LONGEST = 4, 1.0 / 16.0
"""into which a span is divided in which the jerk changes; share of the travel of the longest span beside others"""
CRUISE = 1.0 / 256.0
"""share of the travel of the longest span in which the velocity stays as it is: its multipliers stand at breaks alone,
where those of all laws are spread"""
FULL = 1e-6
"""share of the jerk's limit by which it may be missed at it, and of the largest acceleration that is none"""
CLEAR = 0.004
"""share of the travel; spans whose jerk is at its limit show that it stays there from so many on"""
AT_LIMIT = 1e-3
"""relative; how near acceleration or velocity comes to its limit where it is held"""
HOLD, TWICE = 1e-4, 1e-3
"""shares of the travel: the shortest hold, and the shortest span between two changes, that are built in"""
SHORTEST = 1e-5
"""breaks closer than that are no build"""


def finer(shape: Shape, most: float) -> Shape:
    """The mesh (levels of none) that is finer where the jerk, `most` at its limit, changes or the velocity stays as it
    is, and coarser elsewhere."""
    rate = shape.jerk / most
    odd = (np.abs(rate) < 1.0 - FULL) & (np.abs(rate) > FULL)
    changes = np.append(False, (np.round(rate[1:]) != np.round(rate[:-1])) & ~odd[1:] & ~odd[:-1])
    near = odd | changes
    near[1:] |= odd[:-1]
    near[:-1] |= odd[1:] | changes[1:]
    still = np.abs(shape.a) <= FULL * np.abs(shape.a).max()
    cruising = still[1:] & still[:-1]
    parts = np.where(odd, PARTS, np.where(near, PARTS // 2, 1))
    parts = np.where(cruising, np.maximum(parts, np.ceil(shape.h / CRUISE).astype(int)), parts)
    near |= cruising
    x = [0.0]
    for k, (low, high) in enumerate(zip(shape.x[:-1].tolist(), shape.x[1:].tolist(), strict=True)):
        if near[k]:
            x += [low] if low > x[-1] else []
            x += np.linspace(low, high, int(parts[k]) + 1)[1:].tolist()
        elif high - x[-1] > LONGEST:
            x.append(high)
    places = np.array([*x, 1.0] if x[-1] < 1.0 else x)
    return Shape(places, np.zeros(len(places)))


def switched(task: Task, shape: Shape, value: float) -> Shape | None:
    """The law of jerks at their limit and of holds that a shape on a mesh shows, `value` being what is least; None
    where its breaks would meet.

    Between two runs of spans at the limit the jerk changes where the accelerations meet, acceleration or velocity is
    held where it is at its limit, or the jerk changes twice where the acceleration says so.
    """
    most, x, a = task.jerk.at(value), shape.x, shape.a
    v, top, fast = shape.states(task.wish.start[0])[1], task.acceleration.at(value), task.velocity.at(value)
    runs = _runs(shape, most)
    if not runs:
        return None
    places, rates = [0.0], [runs[0][2]]

    def change(at: float, rate: float) -> None:
        if rate != rates[-1]:
            places.append(at)
            rates.append(rate)

    first, last = runs[0], runs[-1]
    ahead = _opposite(float(x[first[0]]), float(a[first[0]] - a[0]) / most, first[2])
    if ahead > HOLD:
        rates[0] = -first[2]
        change(ahead, first[2])
    for (_, left, before), (right, _, after) in zip(runs[:-1], runs[1:], strict=True):
        width, rise = float(x[right] - x[left]), float(a[right] - a[left]) / most
        inner, held = slice(left, right + 1), None
        if before == after and _at_limit(v[inner], -before, fast, task.wish.monotone).any():
            held = 0.0
        elif before != after and bool((before * a[inner] >= (1.0 - AT_LIMIT) * top).any()):
            held = before * top
        if held is not None:
            begin = float(x[left]) + (held - float(a[left])) / most / before
            end = float(x[right]) - (float(a[right]) - held) / most / after
            if end - begin > HOLD:
                change(begin, 0.0)
                change(end, after)
                continue
        if before != after:
            change(float(x[left]) + (rise - width * after) / (before - after), after)
        elif (short := _opposite(width, rise, before)) > TWICE:
            middle = 0.5 * float(x[left] + x[right])
            change(middle - 0.5 * short, -before)
            change(middle + 0.5 * short, before)
    behind = _opposite(1.0 - float(x[last[1]]), float(a[-1] - a[last[1]]) / most, last[2])
    if behind > HOLD:
        change(1.0 - behind, -last[2])
    breaks = np.array([*places, 1.0])
    if np.diff(breaks).min() <= SHORTEST:
        return None
    levels: Floats = float(a[0]) + most * np.append(0.0, np.cumsum(np.array(rates) * np.diff(breaks)))
    return Shape(breaks, levels)


def ramped(task: Task, shape: Shape, value: float) -> Shape | None:
    """The law of the holds that a shape on a mesh shows and of ramps between them at the jerk's limit, where that lets
    ramps be shorter than a span; None without a hold, or where ramps would meet."""
    most, x, a, wish = task.jerk.at(value), shape.x, shape.a, task.wish
    v, top, fast = shape.states(wish.start[0])[1], task.acceleration.at(value), task.velocity.at(value)
    cruising = _at_limit(v, 1.0, fast, wish.monotone) | _at_limit(v, -1.0, fast, wish.monotone)
    level = np.where(np.abs(a) >= (1.0 - AT_LIMIT) * top, np.copysign(top, a), np.where(cruising, 0.0, np.nan))
    edges = np.flatnonzero(np.append(True, level[1:] != level[:-1])).tolist()
    runs = [(first, after - 1, float(level[first])) for first, after in zip(edges, [*edges[1:], len(level)])]
    # A velocity that is only touched is no hold.
    holds = [run for run in runs if abs(run[2]) == top or (run[2] == 0.0 and run[1] > run[0])]
    last = len(x) - 1
    states = [(0, 0, float(a[0])), *holds, (last, last, float(a[-1]))]
    breaks, levels = list[float](), list[float]()
    for (_, left, before), (right, _, after) in zip(states[:-1], states[1:], strict=True):
        half = 0.5 * abs(after - before) / most
        if half == 0.0:
            continue
        # What the velocity gains from hold to hold says where the ramp is; at the ends it begins and ends there.
        middle = float(after * x[right] - before * x[left] - v[right] + v[left]) / (after - before)
        middle = half if left == 0 else 1.0 - half if right == last else middle
        breaks += [middle - half, middle + half]
        levels += [before, after]
    if not holds or len(breaks) < 4 or np.diff(breaks).min() <= SHORTEST:
        return None
    return Shape(np.array([0.0, *breaks[1:-1], 1.0]), np.array(levels))


def _runs(shape: Shape, most: float) -> list[tuple[int, int, float]]:
    """Runs of spans whose jerk is at its limit: first and last break and its sense; short ones only at the ends."""
    sense = np.where(np.abs(shape.jerk) >= (1.0 - FULL) * most, np.sign(shape.jerk), 0.0)
    edges = np.flatnonzero(np.diff(sense, prepend=np.nan, append=np.nan) != 0.0).tolist()
    return [
        (first, last, float(sense[first]))
        for first, last in zip(edges[:-1], edges[1:], strict=True)
        if sense[first] and (shape.x[last] - shape.x[first] >= CLEAR or first == 0 or last == len(sense))
    ]


def _opposite(width: float, rise: float, rate: float) -> float:
    """How much of a width has the opposite of a jerk (1 or -1), so that the acceleration rises by so much over it."""
    return 0.5 * (width - rise / rate)


def _at_limit(v: Floats, sign: float, limit: float, monotone: bool) -> npt.NDArray[np.bool_]:
    """Which velocities (n,) are at their limit upwards (1) or downwards (-1)."""
    if sign < 0.0 and monotone:
        return v <= AT_LIMIT
    return sign * v >= (1.0 - AT_LIMIT) * limit
