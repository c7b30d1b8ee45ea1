"""Where a roller leaves its cam: cam angles at which a flank begins, ends, or is missing beside the roller."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats
from camgeom.maths.extremum import piece_grid
from camgeom.track import TURN, Track
from camgeom.track.flank import Flank

PER_TURN = 1440
HALVINGS = 40
"""halvings of a step of the cam angle: down to rounding"""
Mask = npt.NDArray[np.bool_]
Inside = Callable[[Floats], Mask]


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
