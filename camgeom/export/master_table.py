"""Electronic cams: the follower's position and its derivatives over the master angle as a table.

The master angle is the cam angle in degrees. Derivatives are per degree of master angle (mm/deg, or deg/deg for
swinging followers and turrets), as servo drives take them at a master speed of one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import degrees, pi
from typing import TYPE_CHECKING

import numpy as np

from camgeom.errors import NotConverged
from camgeom.maths import Floats

if TYPE_CHECKING:
    from camgeom.motion.program import Program
    from camgeom.profile import Profile


POINTS = 361
"""default number of points, one a degree"""
MOST = 200_000
SHARES = np.array([0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875])
"""where between two points the error of a table is measured"""
EVEN = 1e-9
"""share of the largest value below which both sides of a knot count as the same"""


@dataclass(frozen=True, eq=False)
class MasterTable:
    """Rows of an electronic cam.

    master   (n,) strictly rising, deg, from 0 to 360
    jet      (4, n) position (unit), and derivatives by the master angle, unit/deg, unit/deg², unit/deg³; where one
             jumps, the mean of both sides
    unit     mm or deg
    error    largest measured difference (unit) between the motion and what the drive makes of the rows
    advance  position gained in one turn (an indexing turret), 0 for a follower that comes back
    """

    master: Floats
    jet: Floats
    unit: str
    error: float
    advance: float


Interpolation = Callable[[Floats, Floats, Floats, Floats], Floats]
"""(share (m,), step (k,), jet at the start (4, k), jet at the end (4, k)) -> positions (k, m)"""


def straight(share: Floats, step: Floats, start: Floats, stop: Floats) -> Floats:
    """Straight lines from point to point: drives that are given positions alone."""
    del step
    return np.asarray(start[0][:, None] + (stop[0] - start[0])[:, None] * share)


def quintic(share: Floats, step: Floats, start: Floats, stop: Floats) -> Floats:
    """The polynomial of degree five through position, velocity and acceleration of both points."""
    x, h = share[None, :], step[:, None]
    d = (stop[0] - start[0])[:, None]
    v0, v1, a0, a1 = (q[:, None] for q in (start[1], stop[1], start[2], stop[2]))
    v0, v1, a0, a1 = v0 * h, v1 * h, a0 * h * h, a1 * h * h
    c3 = 10.0 * d - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1
    c4 = -15.0 * d + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1
    c5 = 6.0 * d - 3.0 * v0 - 3.0 * v1 - 0.5 * a0 + 0.5 * a1
    return np.asarray(start[0][:, None] + x * (v0 + x * (0.5 * a0 + x * (c3 + x * (c4 + x * c5)))))


ORDERS: dict[Interpolation, int] = {straight: 2, quintic: 4}
"""With which power of the step the error falls (a quintic's where the acceleration jumps; smooth, the sixth)."""


def master_table(profile: Profile, interpolation: Interpolation) -> MasterTable:
    """The electronic cam of a profile: `[output] table_tolerance` (mm or deg) chooses the points, or `table_points`.

    Raises NotConverged where the tolerance needs more than MOST points.
    """
    program, unit = profile.setup().program, degrees(1.0) if profile.rotating else 1.0
    output = profile.output
    if output.table_tolerance is not None:
        theta = _within(program, unit, interpolation, output.table_tolerance)
    else:
        theta = np.linspace(0.0, 2.0 * pi, output.table_points or POINTS)
    jet = _jets(program, unit, theta)
    error = float(_errors(program, unit, theta, jet, interpolation).max())
    word = "deg" if profile.rotating else "mm"
    return MasterTable(np.degrees(theta), jet, word, error, unit * program.advance)


def _jets(program: Program, unit: float, theta: Floats) -> Floats:
    """Jets (4, n) per degree; where both sides differ, their mean."""
    scale = unit * (pi / 180.0) ** np.arange(4)[:, None]
    right, left = scale * program.jet(theta, 3), scale * program.jet(theta, 3, side="left")
    size = np.maximum(np.abs(right).max(axis=1, keepdims=True), 1e-300)
    return np.asarray(np.where(np.abs(right - left) > EVEN * size, 0.5 * (right + left), right))


def _errors(program: Program, unit: float, theta: Floats, jet: Floats, interpolation: Interpolation) -> Floats:
    """Largest error (n - 1,) between neighbouring rows, in the table's unit."""
    step = np.diff(theta)
    between = theta[:-1, None] + step[:, None] * SHARES
    true = unit * program.jet(between.ravel(), 0)[0].reshape(between.shape)
    made = interpolation(SHARES, np.degrees(step), jet[:, :-1], jet[:, 1:])
    return np.asarray(np.abs(made - true).max(axis=1))


def _within(program: Program, unit: float, interpolation: Interpolation, tolerance: float) -> Floats:
    """Angles, with every knot of the motion among them, between which the error stays within the tolerance."""
    theta = np.unique(np.clip(program.knots, 0.0, 2.0 * pi))
    theta[0], theta[-1] = 0.0, 2.0 * pi
    for _ in range(40):
        error = _errors(program, unit, theta, _jets(program, unit, theta), interpolation)
        if error.max() <= tolerance:
            return np.asarray(theta)
        need = np.ceil(1.02 * (error / tolerance) ** (1.0 / ORDERS[interpolation]))
        parts = np.clip(need, np.where(error > tolerance, 2, 1), 16).astype(np.int64)
        if parts.sum() >= MOST:
            break
        first = np.repeat(np.cumsum(parts) - parts, parts)
        share = (np.arange(parts.sum()) - first) / np.repeat(parts, parts)
        theta = np.append(np.repeat(theta[:-1], parts) + share * np.repeat(np.diff(theta), parts), theta[-1])
    raise NotConverged(f"an electronic cam within {tolerance:g} needs more than {MOST} points; ask for a coarser one")
