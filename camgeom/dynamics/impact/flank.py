"""Contacts with free play from the exact flanks of a groove: a track with two flanks as a pair of tables (SI)."""

from __future__ import annotations

import numpy as np

from camgeom.dynamics.impact.lift import TURN, Lift
from camgeom.dynamics.impact.pair import TablePair
from camgeom.errors import Problem, ProfileError
from camgeom.maths import Floats
from camgeom.track import Slide, Track
from camgeom.track.flank import flank


def groove_pair(track: Track, clearance: float, station: float, count: int = 720) -> TablePair:
    """The roller of a groove track with a clearance [m] between its walls, seen at one station along the roller.

    `station` is the delta [mm] at which the contact is taken (the pitch radius), `count` the steps round the cam. The
    follower coordinate is the track's, in m for a slide and rad for a swing; levers, curvature and sliding are those of
    the exact surface. Raises ProfileError where the track has one flank only or does not close.
    """
    if len(track.sides) < 2:
        raise ProfileError([Problem("track", "free play needs two flanks", track.name, "a groove or a pair of cams")])
    if not track.closed:
        raise ProfileError([Problem("track", "contact with free play is solved for closed tracks", track.name)])
    unit = 1e-3 if isinstance(track.joint, Slide) else 1.0
    phi: Floats = np.linspace(0.0, TURN, count, endpoint=False)
    parameter: Floats = np.full(1, track.meridian.parameter(station))
    radius = float(track.meridian.jet(parameter)[3][0])
    pose = track.pose(phi, 1)
    velocity = pose.a[1] + station * pose.u[1]
    sliding = tuple(map(float, 1e-3 * np.sqrt((velocity**2).sum(axis=0))))
    rows = {}
    for side in (1.0, -1.0):
        wall = flank(track, phi, parameter, side)
        # The normal points into the wall: the wall pushes the roller against it.
        lever = -track.factor * wall.lever()[:, 0] * (1e-3 / unit)
        bend = 1e3 * (wall.k_rel[:, 0] - 1.0 / radius)
        rows[bool(lever[0] > 0.0)] = (tuple(map(float, np.abs(lever))), tuple(map(float, bend)))
    if len(rows) < 2:
        raise ProfileError([Problem("track", "both flanks push the same way", track.name)])
    (main, bend_main), (back, bend_return) = rows[True], rows[False]
    lift = Lift.from_program(track.program, unit)
    return TablePair(lift, main, back, clearance, bend_main, bend_return, sliding)
