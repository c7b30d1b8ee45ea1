"""Where a roller touches its cam: the stretch of it that has a wall, and the cam angles at which it comes and goes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from camgeom.maths import Floats
from camgeom.maths.extremum import piece_grid
from camgeom.track import TURN, Pose, Track
from camgeom.track.column import Column
from camgeom.track.flank import Flank

PER_TURN = 1440
ROUNDS = 100
MET = 1e-13
"""share of a step of samples: the last step of a secant, which leaves as much of itself"""
PLACES = 28
"""places along the roller between which the ends of the wall are sought: what is shorter and meets none of them, as a
roller comes or goes, counts for nothing"""
Within = Callable[[Floats], Floats]
"""how deep contact points (3, ...) lie within what bounds the cam's walls, mm: negative beside it"""


def touching(track: Track, side: float, phi: Floats, within: Within, pose: Pose | None = None) -> tuple[Floats, Floats]:
    """Meridian parameters (n,) between which a roller at cam angles (n,) has a wall beside it; equal where none.

    Its contact line leaves the blank where it runs out through the land or an end face: what has a wall is one piece.
    pose: of that side's track there, where the caller has it.
    """
    low, high = sorted(track.meridian.parameter(d) for d in track.contact)
    stations = np.linspace(low, high, PLACES)
    whole = Column(track.eased(side), phi, pose)
    deep = within(whole.wall(side, stations))
    there = deep >= 0.0
    some = there.any(axis=1)
    at = np.stack((there.argmax(axis=1), PLACES - 1 - there[:, ::-1].argmax(axis=1)))
    ends = stations[np.where(some, at, 0)]
    # (2, n), and of those ends at which the contact line leaves the blank on the way only, (k,)
    which, rows = np.nonzero(some & (at != ((0,), (PLACES - 1,))))
    if not len(rows):
        return ends[0], ends[1]
    column, on = whole.at(rows), at[which, rows]
    off = on + np.where(which, 1, -1)
    start, step = stations[on], stations[off] - stations[on]

    def off_by(share: Floats) -> Floats:
        return np.asarray(within(column.wall(side, (start + share * step)[:, None]))[:, 0])

    ends[which, rows] = start + _crossed(off_by, deep[rows, on], deep[rows, off]) * step
    return ends[0], ends[1]


def _crossed(f: Callable[[Floats], Floats], first: Floats, last: Floats) -> Floats:
    """Shares (k,) of the way from 0 to 1 at which a function falls through zero; first >= 0 and last <= 0 at the ends.

    Secants, and halves of the bracket where these leave it or hardly lessen what is left.
    """
    low, high = np.zeros(len(first)), np.ones(len(first))
    p, fp, q, fq = high, last, low, first
    met = stuck = np.zeros(len(first), dtype=bool)
    for _ in range(ROUNDS):
        change = fq - fp
        x = q - fq * (q - p) / np.where(change != 0.0, change, 1.0)
        # What the step after this one would be is as the product of the last two.
        met = met | ~stuck & (change != 0.0) & (np.abs(x - q) < MET) | (high - low < MET)
        lost = ~met & (stuck | (change == 0.0) | (x <= low) | (x >= high))
        x = np.where(lost, 0.5 * (low + high), np.clip(x, low, high))
        if met.all():
            return x
        fx = f(x)
        held = fx >= 0.0
        low, high = np.where(held, x, low), np.where(held, high, x)
        stuck = np.abs(fx) > 0.5 * np.abs(fq)
        p, fp, q, fq = q, fq, x, fx
    return q


def wall_ends(track: Track, side: float, stations: Floats, within: Within) -> list[Floats]:
    """Cam angles (k,) at which the contact at each meridian station (m,) comes upon the cam or leaves it, rad."""

    def deep(t: Floats, phi: Floats) -> Floats:
        return np.asarray(within(Flank(track, phi, t, side).x)[:, 0])

    return [_sampled(track, partial(deep, t[None]))[1] for t in stations]


def missing(track: Track, side: float, within: Within) -> tuple[tuple[float, float], ...]:
    """Stretches of cam angle (from, to), rad, over which some of the roller's contact stretch has no flank beside it.

    Stretches that meet at the end of a closed turn are one, which then ends beyond it.
    """
    ends = np.array([track.meridian.parameter(d) for d in track.contact])
    stations = np.linspace(ends.min(), ends.max(), 9)

    def least(phi: Floats) -> Floats:
        return np.asarray(within(Flank(track, phi, stations, side).x).min(axis=1))

    lost, found = _sampled(track, least)
    edges = [track.span[0], *found.tolist(), track.span[1]]
    stretches = [(a, b) for k, (a, b) in enumerate(zip(edges, edges[1:])) if (k % 2 == 0) == lost and b > a]
    if track.closed and len(stretches) > 1 and stretches[0][0] == track.span[0] and stretches[-1][1] == track.span[1]:
        stretches = [*stretches[1:-1], (stretches[-1][0], stretches[0][1] + TURN)]
    return tuple(stretches)


def walled(track: Track, within: Within) -> Track | None:
    """The track from the first cam angle to the last at which either flank is beside its roller; None: at none is.

    A closed track is all of its turn.
    """
    low, high = sorted(track.meridian.parameter(d) for d in track.contact)
    stations = np.linspace(low, high, PLACES)

    def most(phi: Floats) -> Floats:
        column = Column(track, phi)
        return np.asarray(np.max([within(column.wall(side, stations)).max(axis=1) for side in track.sides], axis=0))

    none, found = _sampled(track, most)
    edges = [track.span[0], *found.tolist(), track.span[1]]
    held = [(a, b) for k, (a, b) in enumerate(zip(edges, edges[1:])) if (k % 2 == 0) != none]
    if not held:
        return None
    return track if track.closed else replace(track, span=(held[0][0], held[-1][1]))


def _sampled(track: Track, f: Callable[[Floats], Floats]) -> tuple[bool, Floats]:
    """Whether a function of the cam angle is negative at the beginning of the span, and where (k,) its sign changes."""
    phi, _ = piece_grid(track.knots(), PER_TURN)
    values = f(phi)
    return bool(values[0] < 0.0), changes(f, phi, values)


def changes(f: Callable[[Floats], Floats], phi: Floats, values: Floats) -> Floats:
    """Cam angles (k,), rad, at which a function changes its sign whose values at cam angles (n,) are known."""
    there = values >= 0.0
    at = np.flatnonzero(there[1:] != there[:-1])
    start, step, sign = phi[at], phi[at + 1] - phi[at], np.where(there[at], 1.0, -1.0)
    if not len(at):
        return start
    return start + _crossed(lambda x: sign * f(start + x * step), sign * values[at], sign * values[at + 1]) * step
