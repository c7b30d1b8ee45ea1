"""Rows of a ball mill along a flank, so close that the ridges between them keep a height."""

from __future__ import annotations

from math import ceil, sqrt
from typing import final

import numpy as np

from camgeom.errors import DesignError, NotConverged
from camgeom.immutable import immutable
from camgeom.machining.path import AlongTrack, Positions, flank_name, travel_of
from camgeom.machining.wall import cosine_of, roller_at, up_of, wall_ends
from camgeom.maths import Floats, distinct
from camgeom.maths.surface import dot
from camgeom.track import Track
from camgeom.track.flank import Flank

MOST_ROWS = 20_000
"""on one flank; more rows than that no machine finishes"""
ANGLES_PER_TURN = 90
NEIGHBOURS = 13
WIDENINGS = 8


@final
@immutable
class RowPath(AlongTrack):
    """A ball that touches one flank along one line of it: the row at the meridian parameter t.

    group  number of the flank among all that a ball works on
    """

    track: Track
    side: float
    radius: float
    stock: float
    t: float
    number: int = 1
    start: float = 0.0
    group: int = 0

    @property
    def name(self) -> str:
        """What it makes."""
        return f"{flank_name(self.track, self.side)}, row {self.number}"

    @property
    def height(self) -> float:
        """Length of the tool in the cut, mm."""
        top = self.track.contact[0] if self.track.tip_sign > 0.0 else self.track.contact[1]
        return abs(top - roller_at(self.track, self.t)[0]) + self.radius

    @property
    def room(self) -> float | None:
        """In a groove: by how much the roller is larger there."""
        if len(self.track.sides) == 1:
            return None
        return max(0.0, roller_at(self.track, self.t)[1] - (self.radius + self.stock) * cosine_of(self.track))

    def at(self, phi: Floats) -> Positions:
        """Positions at cam angles (n,); the tip is the lowest point of the ball."""
        phi = np.asarray(phi, dtype=float)
        flank = Flank(self.track, phi, np.array([self.t]), self.side)
        x, n, pose = flank.x[:, :, 0], flank.n[:, :, 0], flank.pose
        axis = up_of(self.track) * pose.u[0]
        centre = x - (self.radius + self.stock) * n
        travel = travel_of(pose, roller_at(self.track, self.t)[0], n)
        return Positions(phi, centre - self.radius * axis, axis, x[None], n[None], travel, axis)


@immutable
class Rows:
    """The rows of one flank.

    t           meridian parameters, from the foot up
    scallop     mm, the highest ridge between two rows, measured along the flank's normal
    foot_left   mm, of the wall's height below the lowest row, which the ball does not finish
    """

    paths: tuple[RowPath, ...]
    scallop: float
    foot_left: float


def rows(
    track: Track, side: float, radius: float, stock: float, scallop: float, start: float = 0.0, group: int = 0
) -> Rows:
    """Rows of a ball on one flank with ridges of at most `scallop`, mm.

    Raises DesignError where the ball is higher than the wall, NotConverged where it takes more than MOST_ROWS rows.
    """
    foot, top = wall_ends(track)
    low, left = _lowest(track, radius + stock, foot, top)
    parts = _first_count(track, side, radius, low, top, scallop)
    for _ in range(WIDENINGS):
        if parts > MOST_ROWS:
            raise NotConverged(
                f"cutter.scallop {scallop:g} mm would take {parts} rows of a ball of {2.0 * radius:.6g} mm on one "
                f"flank, more than {MOST_ROWS}; ask for higher ridges or take a larger ball"
            )
        t = np.linspace(low, top, parts + 1)
        made = tuple(RowPath(track, side, radius, stock, float(x), i + 1, start, group) for i, x in enumerate(t))
        height = ridge(made, stock)
        if height <= scallop:
            return Rows(made, height, left)
        parts = max(parts + 1, ceil(parts * min(2.0, 1.02 * sqrt(height / scallop))))
    raise NotConverged(f"the ridges between rows stay {height:.3g} mm high, above cutter.scallop {scallop:g} mm")


def ridge(paths: tuple[RowPath, ...], stock: float) -> float:
    """Highest ridge, mm, between neighbouring rows, over samples of the flank: every row of a few, some of many.

    The height is that at which a line along the flank's normal, half way between two rows, comes out of both balls.
    """
    if len(paths) < 2:
        return 0.0
    first = paths[0]
    track, side = first.track, first.side
    pick = distinct(np.linspace(0, len(paths) - 2, min(len(paths) - 1, NEIGHBOURS)).astype(int))
    knots = track.knots()
    count = max(24, int(ANGLES_PER_TURN * (knots[-1] - knots[0]) / (2.0 * np.pi)))
    phi = np.linspace(knots[0], knots[-1], count)
    worst = 0.0
    for i in pick:
        lower, upper = paths[i], paths[i + 1]
        flank = Flank(track, phi, np.array([0.5 * (lower.t + upper.t)]), side)
        x, n = flank.x[:, :, 0] - stock * flank.n[:, :, 0], flank.n[:, :, 0]
        out = np.minimum(_leaves(lower, x, n, phi), _leaves(upper, x, n, phi))
        worst = max(worst, float(out.max()))
    return worst


def _leaves(row: RowPath, x: Floats, n: Floats, phi: Floats) -> Floats:
    """How far along -n (mm) the swept ball of a row takes lines from points x (3, n) out of the stock."""
    flank = Flank(row.track, phi, np.array([row.t]), row.side)
    pace = np.sqrt(flank.forms.E[:, 0])
    gap = x - flank.x[:, :, 0]
    half = 1.5 * np.sqrt(dot(gap, gap)) / np.maximum(pace, 1e-12) + 1e-12
    share = np.linspace(-1.0, 1.0, 9)
    centre = phi
    best = np.full(len(phi), np.inf)
    for _ in range(6):
        at = centre[:, None] + half[:, None] * share
        value = _entry(row, x, n, at)
        k = np.argmin(value, axis=1)
        rows_ = np.arange(len(phi))
        best, centre, half = np.minimum(best, value[rows_, k]), at[rows_, k], 0.25 * half
    return best


def _entry(row: RowPath, x: Floats, n: Floats, phi: Floats) -> Floats:
    """Distance along -n at which lines from x (3, n) meet the ball at angles phi (n, k); infinite where they miss."""
    at = row.at(phi.ravel())
    centre = (at.tip + row.radius * at.axis).reshape(3, *phi.shape)
    d = x[:, :, None] - centre
    b = dot(d, n[:, :, None])
    left = b * b - dot(d, d) + row.radius**2
    return np.asarray(np.where(left >= 0.0, b - np.sqrt(np.maximum(left, 0.0)), np.inf))


def _lowest(track: Track, reach: float, foot: float, top: float) -> tuple[float, float]:
    """Meridian parameter of the lowest row whose ball stays above the tool's end, and what wall is left below, mm."""
    up, t = up_of(track), foot
    floor = track.tip
    for _ in range(50):
        delta, dt, _, _, rt, _ = track.meridian.jet(np.array([t]))
        # The ball's centre stands back along the normal, whose part along the axis is -r' / sqrt(delta'² + r'²).
        centre = delta[0] + reach * rt[0] / np.hypot(dt[0], rt[0])
        short = floor + up * reach - centre
        if up * short <= 1e-12:
            break
        t = track.meridian.parameter(float(delta[0] + short))
    delta_foot, delta_low, delta_top = (roller_at(track, x)[0] for x in (foot, t, top))
    if up * (delta_top - delta_low) <= 0.0:
        raise DesignError(
            f"track {track.name!r}: a ball of {2.0 * reach:.6g} mm (with its stock) is too large for a wall of "
            f"{abs(delta_top - delta_foot):.6g} mm; at most {abs(delta_top - delta_foot):.6g} mm"
        )
    return t, abs(delta_low - delta_foot)


def _first_count(track: Track, side: float, radius: float, low: float, top: float, scallop: float) -> int:
    """Rows whose ridges are about right: w² / 8 (1 / radius + curvature) = scallop."""
    knots = track.knots()
    phi = np.linspace(knots[0], knots[-1], 180)
    flank = Flank(track, phi, np.linspace(low, top, 5), side)
    forms = flank.forms
    width = np.sqrt(forms.determinant / forms.E) * abs(top - low)
    apart = 2.0 * sqrt(scallop * (2.0 * radius - scallop)) if scallop < radius else 2.0 * radius
    return max(1, ceil(min(float(width.max()) / apart, 1e9)))
