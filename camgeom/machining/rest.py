"""What a tool leaves: the distance of the finished flank from the tool at its nearest, over the whole path.

A point of the nominal flank that no position of the tool reaches has so much stock in front of it as its least distance
from the tool (positive); one that the tool passes over lies so deep inside it (negative: a gouge). Nothing is
interpolated: the tool's positions are exact at every cam angle, and the least distance is refined.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import degrees, inf
from typing import Any, final

import numpy as np
import numpy.typing as npt

from camgeom.immutable import immutable
from camgeom.machining.path import ToolPath
from camgeom.machining.rows import RowPath
from camgeom.machining.tool import Tool
from camgeom.maths import Floats, distinct
from camgeom.maths.extremum import piece_grid
from camgeom.maths.frozen import cached_property
from camgeom.maths.surface import dot
from camgeom.track import Track
from camgeom.track.flank import Flank
from camgeom.track.runout import Within

PER_TURN = 180
STATIONS = 7
COARSE = 41
"""positions tried round each cam angle"""
FAN = 5
ROUNDS = 2
ZOOMS = 6
MARGIN = 1.5
NOISE = 1e-11
"""mm; less is rounding"""


@final
@immutable
class RestField:
    """Stock that a tool leaves on one flank of a track, at cam angles phi (n,) and heights delta along the roller (m,).

    paths   of the tool that may come near this flank: all, or some rows of a ball
    rows    of a ball on this flank, in order; at each height those next to it count besides
    bound   mm, below which the stock is known not to fall
    within  how deep points (3, ...) lie within the blank, mm; None: all are of the blank
    """

    track: Track
    side: float
    tool: Tool
    paths: tuple[ToolPath, ...]
    within: Within | None = None
    rows: tuple[RowPath, ...] = ()
    bound: float = -inf

    @cached_property
    def phi(self) -> Floats:
        """Cam angles (n,), rad."""
        return piece_grid(self.track.knots(), PER_TURN)[0]

    @cached_property
    def _stations(self) -> Floats:
        """Meridian parameters (m,) over the stretch that the roller touches."""
        low, high = (self.track.meridian.parameter(d) for d in self.track.contact)
        return np.linspace(low, high, STATIONS)

    @cached_property
    def delta(self) -> Floats:
        """Heights along the roller (m,), mm."""
        return self.track.meridian.jet(self._stations)[0]

    @cached_property
    def flank(self) -> Flank:
        """The nominal flank there."""
        return Flank(self.track, self.phi, self._stations, self.side)

    @cached_property
    def rest(self) -> Floats:
        """Stock (n, m), mm; negative where the tool cuts into the flank; 0 off the blank."""
        rows = self.valid.any(axis=1)
        found = np.zeros(self.valid.shape)
        if np.any(rows):
            found[rows] = self._left(self.flank.x[:, rows], self.phi[rows], self._stations)
        return found

    @cached_property
    def valid(self) -> npt.NDArray[np.bool_]:
        """True (n, m) for points of the blank."""
        return self._of_blank(self.flank.x)

    def at(self, flank: Flank) -> Floats:
        """Stock on other points of the same flank."""
        return self._left(flank.x, flank.phi, flank.t)

    def _left(self, x: Floats, phi: Floats, t: Floats) -> Floats:
        left = np.asarray(np.min([least_distance(path, self.tool, x, phi) for path in self.paths], axis=0))
        if self.rows:
            above = np.searchsorted(np.sort([row.t for row in self.rows]), t)
            ordered = sorted(self.rows, key=lambda row: row.t)
            for j, k in enumerate(above):
                for row in ordered[max(0, k - 1) : k + 1]:
                    left[:, j] = np.minimum(left[:, j], least_distance(row, self.tool, x[:, :, j : j + 1], phi)[:, 0])
        return left

    def extreme(self, sign: float) -> RestExtreme | None:
        """The largest (sign +1) or smallest stock, by finer and finer grids round the best samples; None: no flank."""
        if not np.any(self.valid):
            return None
        shown = np.where(self.valid, sign * self.rest, -np.inf)
        i, j = np.unravel_index(int(np.argmax(shown)), shown.shape)
        value, phi, delta = float(shown[i, j]), float(self.phi[i]), float(self.delta[j])
        if sign < 0.0 and abs(value + self.bound) <= NOISE:
            return RestExtreme(self.bound, phi, delta, self.side)
        # Beside an end of the blank, which passes between two stations, it may be larger than where they show it.
        along = np.concatenate([[-np.inf], shown.max(axis=0), [-np.inf]])
        tops = np.flatnonzero((along[1:-1] >= along[:-2]) & (along[1:-1] >= along[2:]) & (along[1:-1] > -np.inf))
        for k in tops:
            found = self._zoomed(sign, float(self.phi[int(np.argmax(shown[:, k]))]), float(self.delta[k]))
            value, phi, delta = max((value, phi, delta), found)
        return RestExtreme(sign * value if abs(value) > NOISE else 0.0, phi, delta, self.side)

    def _zoomed(self, sign: float, phi: float, delta: float) -> tuple[float, float, float]:
        """The largest `sign` times the stock about a place, and where it is."""
        value = -inf
        width, height = 2.0 * np.pi / PER_TURN, abs(float(self.delta[1] - self.delta[0]))
        knots, (low, high) = self.track.knots(), sorted(self.track.contact)
        for _ in range(ZOOMS):
            angles = distinct(np.clip(phi + width * np.linspace(-1.0, 1.0, 9), knots[0], knots[-1]))
            deltas = distinct(np.clip(delta + height * np.linspace(-1.0, 1.0, 5), low, high))
            t = np.array([self.track.meridian.parameter(float(d)) for d in deltas])
            flank = Flank(self.track, angles, t, self.side)
            rest = np.where(self._of_blank(flank.x), sign * self.at(flank), -np.inf)
            i, j = np.unravel_index(int(np.argmax(rest)), rest.shape)
            if float(rest[i, j]) > value:
                value, phi, delta = float(rest[i, j]), float(angles[i]), float(deltas[j])
            width, height = 0.3 * width, 0.5 * height
        return value, phi, delta

    def _of_blank(self, x: Floats) -> npt.NDArray[np.bool_]:
        return np.ones(x.shape[1:], dtype=bool) if self.within is None else np.asarray(self.within(x) >= 0.0)


@final
@immutable(eq=True)
class RestExtreme:
    """A largest or smallest rest, mm, with its cam angle (rad), height along the roller (mm) and flank."""

    value: float
    cam_angle: float
    delta: float
    side: float

    def data(self, name: str) -> dict[str, Any]:
        """As plain data, keys beginning with `name`."""
        return {
            f"{name}_mm": self.value,
            f"{name}_at_deg": degrees(self.cam_angle) % 360.0,
            f"{name}_delta_mm": self.delta,
            f"{name}_side": self.side,
        }


def extreme_of(fields: Sequence[RestField], sign: float) -> RestExtreme | None:
    """The largest (sign +1) or smallest rest over several flanks."""
    found = [at for at in (one.extreme(sign) for one in fields) if at is not None]
    return max(found, key=lambda at: sign * at.value) if found else None


def least_distance(path: ToolPath, tool: Tool, x: Floats, phi: Floats) -> Floats:
    """Least signed distance (n, m), mm, of points x (3, n, m) from a tool that passes them near cam angles phi (n,)."""
    ends = path.knots()
    half = _window(path, tool)
    share = np.linspace(-1.0, 1.0, COARSE)
    centre = np.broadcast_to(phi[:, None], x.shape[1:])
    shared = np.asarray(phi[:, None] + half * share)
    value = _distance(path, tool, x[..., None], shared[:, None, :], ends)
    best = np.argmin(value, axis=-1)[..., None]
    centre = np.take_along_axis(np.broadcast_to(shared[:, None, :], value.shape), best, -1)[..., 0]
    found = np.take_along_axis(value, best, -1)[..., 0]
    half *= share[1] - share[0]
    fan = np.linspace(-1.0, 1.0, FAN)
    for _ in range(ROUNDS):
        tried = centre[..., None] + half * fan
        value = _distance(path, tool, x[..., None], tried, ends)
        best = np.clip(np.argmin(value, axis=-1), 1, FAN - 2)[..., None]
        low, mid, high = (np.take_along_axis(value, best + k, -1)[..., 0] for k in (-1, 0, 1))
        bend = low - 2.0 * mid + high
        move = np.where(bend > 0.0, 0.5 * (low - high) / np.where(bend > 0.0, bend, 1.0), 0.0)
        step = half * (fan[1] - fan[0])
        centre = np.take_along_axis(tried, best, -1)[..., 0] + step * np.clip(move, -1.0, 1.0)
        found, half = np.minimum(found, value.min(axis=-1)), step
    return np.asarray(np.minimum(found, _distance(path, tool, x, centre, ends)))


@lru_cache(maxsize=256)
def _window(path: ToolPath, tool: Tool) -> float:
    """Cam angle, rad, before and after a contact within which the tool can come nearest to it."""
    ends = path.knots()
    phi = np.linspace(ends[0], ends[-1], 181)
    contacts = path.at(phi).contacts[0]
    pace = np.sqrt((np.diff(contacts, axis=1) ** 2).sum(axis=0)) / np.diff(phi)
    return float(np.clip(MARGIN * tool.radius / max(float(np.median(pace)), 1e-9), 0.02, 0.5 * np.pi))


def _distance(path: ToolPath, tool: Tool, x: Floats, phi: Floats, ends: Floats) -> Floats:
    """Signed distance of points x (3, ...) from the tool at cam angles phi (...), which broadcast with them."""
    inside = phi if path.closed else np.clip(phi, ends[0], ends[-1])
    at = path.at(inside.ravel())
    shape = (3, *phi.shape)
    d = x - at.tip.reshape(shape)
    axis = at.axis.reshape(shape)
    s = dot(d, axis)
    across = np.sqrt(np.maximum(dot(d, d) - s * s, 0.0))
    return tool.distance(s, across)
