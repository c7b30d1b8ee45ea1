"""Where a roller touches its cam: the stretch of it that has a wall, and the cam angles at which it comes and goes."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats
from camgeom.maths.extremum import piece_grid
from camgeom.track import TURN, Pose, Track
from camgeom.track.flank import Flank

PER_TURN = 1440
HALVINGS = 40
"""halvings of a step of the cam angle, or along the roller: down to rounding"""
PLACES = 28
"""places along the roller between which the ends of the wall are sought: what is shorter and meets none of them, as a
roller comes or goes, counts for nothing"""
Mask = npt.NDArray[np.bool_]
Inside = Callable[[Floats], Mask]


def touching(
    track: Track, side: float, phi: Floats, inside: Inside, halvings: int = HALVINGS
) -> tuple[Floats, Floats]:
    """Meridian parameters (n,) between which a roller at cam angles (n,) has a wall beside it; equal where none.

    Its contact line leaves the blank where it runs out through the land or an end face: what has a wall is one piece.
    """
    low, high = sorted(track.meridian.parameter(d) for d in track.contact)
    stations = np.linspace(low, high, PLACES)
    pose = track.eased(side).pose(phi, 1)
    there = inside(Flank(track, phi, stations, side, given_pose=pose).x)
    first, last = there.argmax(axis=1), PLACES - 1 - there[:, ::-1].argmax(axis=1)
    some = there.any(axis=1)
    ends = []
    for at, step in ((first, -1), (last, 1)):
        end = stations[np.where(some, at, 0)]
        rows = np.flatnonzero(some & (at + step >= 0) & (at + step < PLACES))
        if len(rows):
            part = Pose(pose.a[:, :, rows], pose.u[:, :, rows], pose.turn[rows])
            on, off = end[rows], stations[at[rows] + step]
            for _ in range(halvings):
                middle = 0.5 * (on + off)
                held = inside(Flank(track, phi[rows], middle[:, None], side, given_pose=part).x)[:, 0]
                on, off = np.where(held, middle, on), np.where(held, off, middle)
            end[rows] = on
        ends.append(end)
    return ends[0], ends[1]


def wall_ends(track: Track, side: float, stations: Floats, inside: Inside) -> list[Floats]:
    """Cam angles (k,) at which the contact at each meridian station (m,) comes upon the cam or leaves it, rad."""

    def there(t: Floats, phi: Floats) -> Mask:
        return inside(Flank(track, phi, t, side).x)[:, 0]

    return [_changes(track, partial(there, t[None]))[1] for t in stations]


def missing(track: Track, side: float, inside: Inside) -> tuple[tuple[float, float], ...]:
    """Stretches of cam angle (from, to), rad, over which some of the roller's contact stretch has no flank beside it.

    Stretches that meet at the end of a closed turn are one, which then ends beyond it.
    """
    ends = np.array([track.meridian.parameter(d) for d in track.contact])
    stations = np.linspace(ends.min(), ends.max(), 9)

    def lost(phi: Floats) -> Mask:
        return np.asarray(~inside(Flank(track, phi, stations, side).x).all(axis=1))

    first, changes = _changes(track, lost)
    edges = [track.span[0], *changes.tolist(), track.span[1]]
    stretches = [(a, b) for k, (a, b) in enumerate(zip(edges, edges[1:])) if (k % 2 == 0) == first and b > a]
    if track.closed and len(stretches) > 1 and stretches[0][0] == track.span[0] and stretches[-1][1] == track.span[1]:
        stretches = [*stretches[1:-1], (stretches[-1][0], stretches[0][1] + TURN)]
    return tuple(stretches)


def _changes(track: Track, state: Callable[[Floats], Mask]) -> tuple[bool, Floats]:
    """The state at the beginning of the span, and the cam angles (k,) at which it changes, rad."""
    phi, _ = piece_grid(track.knots(), PER_TURN)
    values = state(phi)
    at = np.flatnonzero(values[1:] != values[:-1])
    low, high, before = phi[at], phi[at + 1], values[at]
    if len(at):
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            same = state(middle) == before
            low, high = np.where(same, middle, low), np.where(same, high, middle)
    return bool(values[0]), np.asarray(high)
