"""What the followers on one cam do together: the torque that they ask of its shaft, and how near their rollers come to
each other and to the pivots of arms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import combinations, permutations
from math import inf
from typing import TYPE_CHECKING, final

import numpy as np
import numpy.typing as npt

from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.extremum import Extreme, piece_grid, refined_maximum
from camgeom.maths.frozen import cached_property
from camgeom.maths.panels import TURN, Panels, panels
from camgeom.mechanics.duty import largest_of
from camgeom.track import Swing

if TYPE_CHECKING:
    from camgeom.mechanics.duty import Duty
    from camgeom.model import Model
    from camgeom.track import Track

Segment = tuple[Floats, Floats]
"""both ends of one in the machine frame, (3, n) each (or (3, 1)), mm"""
Standing = Callable[[Floats], Segment]
"""where one stands at cam angles (n,), rad"""

PARALLEL = 1e-20
"""square of the sine of an angle between axes that are parallel"""
PER_TURN = 1440
"""places of every pair of rollers in a turn, before the nearest ones are looked at closer"""


@final
@immutable
class Shaft:
    """The torque of a camshaft.

    followers  the angle of each one's place, rad, and the duties whose torques add up to what it asks: those of a rib's
               two rollers, one of all others
    """

    followers: tuple[tuple[float, tuple[Duty, ...]], ...]

    @cached_property
    def panels(self) -> Panels:
        """A turn of the cam, with the edges of every follower's own panels."""
        whole = [(angle, duty.force.panels) for angle, duties in self.followers for duty in duties]
        first = whole[0][1]
        if all(angle == 0.0 and np.array_equal(own.edges, first.edges) for angle, own in whole):
            return first
        edges = [(own.edges + angle) % TURN for angle, own in whole]
        every = panels(np.concatenate([[0.0, TURN], *edges]), np.inf).edges
        return Panels(every, every)

    def torque_of(self, number: int) -> Floats:
        """Torque of one follower, N mm on the panels (p, n)."""
        angle, duties = self.followers[number]
        theta, found = self.panels.theta, []
        for duty in duties:
            own = duty.force.panels
            if angle == 0.0 and np.array_equal(own.edges, self.panels.edges):
                found.append(duty.torque)
            else:
                found.append(own.at(duty.torque, ((theta - angle) % TURN).ravel()).reshape(theta.shape))
        return np.asarray(sum(found))

    @cached_property
    def torque(self) -> Floats:
        """Torque of all, N mm on the panels (p, n)."""
        return np.asarray(sum(self.torque_of(number) for number in range(len(self.followers))))

    @cached_property
    def peak_torque(self) -> Extreme:
        """The largest of it, N mm, as a magnitude."""
        return largest_of(self.panels, self.torque)

    def at(self, theta: Floats) -> Floats:
        """Torque of all, N mm, at cam angles (n,)."""
        return np.asarray(self.panels.at(self.torque, theta))

    @property
    def work(self) -> float:
        """Work of the cam on all followers over a turn, N mm."""
        return sum(duty.work for _, duties in self.followers for duty in duties)


def least_apart(models: tuple[Model, ...]) -> Extreme | None:
    """Least distance between rollers of two followers over the turn, mm, at the cam angle; None without two rollers.

    A roller counts as the segment of its axis from its free end to the end of its contact, as thick as it is anywhere:
    what is told is never more than the distance. Its ends are flat beside a roller on a parallel axis. `where` names
    the two.
    """
    found = []
    for one, other in combinations(filter(_rolls, models), 2):
        for first in one.tracks:
            for second in other.tracks:
                knots = np.concatenate([_knots(first, one.angle), _knots(second, other.angle)])
                least = _least(_segment(first, one.angle), _segment(second, other.angle), knots,
                               _thickest(first) + _thickest(second))  # fmt: skip
                found.append(replace(least, where=f"follower {one.number + 1} to follower {other.number + 1}"))
    return min(found, key=lambda least: least.value, default=None)


def least_to_pivot(models: tuple[Model, ...]) -> Extreme | None:
    """Least distance from a roller to the axis on which the arm of another follower turns, over the turn, mm, at the
    cam angle; negative: the axis lies in the roller. None without such an arm.

    That axis counts as far as the arm's own rollers reach along it: a roller on a parallel axis that passes above or
    below them stands in another plane. Rollers count as in `least_apart`, `where` names the two.
    """
    found = []
    for one, other in permutations(models, 2):
        pivot = _pivot(other)
        if pivot is None or not _rolls(one):
            continue
        for track in one.tracks:
            roller = _segment(track, one.angle)
            parallel, behind, _ = _along(*roller(np.zeros(1)), *pivot(np.zeros(1)))
            if parallel[0] and behind[0] > 0.0:
                continue
            least = _least(roller, pivot, _knots(track, one.angle), _thickest(track))
            where = f"roller of follower {one.number + 1} to pivot of follower {other.number + 1}"
            found.append(replace(least, where=where))
    return min(found, key=lambda least: least.value, default=None)


def _rolls(model: Model) -> bool:
    """Whether what its tracks are of are rollers: a curved face is no more than a part of the circle that it counts as.
    """
    return bool(model.mechanism.rollers)


def _knots(track: Track, angle: float) -> Floats:
    return (track.knots() + angle) % TURN


def _least(one: Standing, other: Standing, knots: Floats, thick: float) -> Extreme:
    """Least distance, mm, over the cam angle between what stands about two segments, as thick together."""

    def nearness(theta: Floats) -> Floats:
        return np.asarray(-_beside(*one(theta), *other(theta), thick))

    theta, owner = piece_grid(distinct(np.concatenate([knots, [0.0, TURN]])), PER_TURN)
    value, where = refined_maximum(nearness, theta, owner, nearness(theta))
    return Extreme(-value, where % TURN)


def _along(a: Floats, b: Floats, c: Floats, d: Floats) -> tuple[npt.NDArray[np.bool_], Floats, Floats]:
    """Of segments from a to b and from c to d, (3, n) each: whether their axes are parallel, and then how far one
    stands behind the other along them and how far they are apart across, mm, (n,) each."""
    u, v = b - a, d - c
    length = np.sqrt((u * u).sum(axis=0))
    axis = u / length
    skew = np.cross(axis, v, axis=0)
    start, stop = ((axis * (point - a)).sum(axis=0) for point in (c, d))
    behind = np.maximum(np.maximum(np.minimum(start, stop) - length, -np.maximum(start, stop)), 0.0)
    off = c - a - axis * start
    parallel = (skew * skew).sum(axis=0) <= PARALLEL * (v * v).sum(axis=0)
    return parallel, behind, np.sqrt((off * off).sum(axis=0))


def _beside(a: Floats, b: Floats, c: Floats, d: Floats, thick: float) -> Floats:
    """Distance (n,) of two rollers about the segments from a to b and from c to d, (3, n) each, as thick together.

    Rollers one behind the other on parallel axes are as far apart as their flat ends.
    """
    parallel, behind, across = _along(a, b, c, d)
    across = across - thick
    flat = np.where(across > 0.0, np.hypot(behind, across), np.where(behind > 0.0, behind, across))
    return np.asarray(np.where(parallel, flat, _between(a, b, c, d) - thick))


def _thickest(track: Track) -> float:
    """Largest radius of a roller, mm."""
    ends = np.array([track.meridian.parameter(end) for end in (track.tip, *track.contact)])
    return float(track.meridian.jet(np.linspace(ends.min(), ends.max(), 33))[3].max())


def _segment(track: Track, angle: float) -> Standing:
    """Both ends of the roller's axis by cam angles (n,), turned about the cam by the angle of its place."""
    turn = _turned(track.sense * angle)

    def ends(theta: Floats) -> Segment:
        point, axis = track.joint.carried(track.anchor, track.axis, track.coordinate((theta - angle) % TURN, 0))
        low, high = (turn @ (point[0] + delta * axis[0]) for delta in _reach(track))
        return low, high

    return ends


def _pivot(model: Model) -> Standing | None:
    """The same of the axis on which its arm turns, as far as its rollers reach along it; None without an arm."""
    joint = model.tracks[0].joint if model.tracks else None
    if not isinstance(joint, Swing):
        return None
    axis, centre = np.array(joint.axis), np.array(joint.centre)
    reach = [axis @ (np.array(track.anchor) + delta * np.array(track.axis) - centre)
             for track in model.tracks for delta in _reach(track)]  # fmt: skip
    turn = _turned(model.mechanism.sense * model.angle)
    low, high = ((turn @ (centre + delta * axis))[:, None] for delta in (min(reach), max(reach)))
    return lambda theta: (low, high)


def _reach(track: Track) -> tuple[float, float]:
    """Where along its axis a roller ends, mm."""
    return min(track.tip, *track.contact), max(track.tip, *track.contact)


def _turned(angle: float) -> Floats:
    """The matrix of a turn about Z by an angle, rad."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _between(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats:
    """Distance (n,) of the segments from a to b and from c to d, (3, n) each.

    The least is inside both, or at an end of one of them.
    """
    u, v, w = b - a, d - c, a - c
    uu, uv, vv, uw, vw = ((p * q).sum(axis=0) for p, q in ((u, u), (u, v), (v, v), (u, w), (v, w)))
    spread = uu * vv - uv * uv
    skew = spread > 1e-12 * uu * vv
    safe = np.where(skew, spread, 1.0)
    s, t = (uv * vw - vv * uw) / safe, (uu * vw - uv * uw) / safe
    inside = skew & (s > 0.0) & (s < 1.0) & (t > 0.0) & (t < 1.0)
    best = np.where(inside, np.sqrt(((w + s * u - t * v) ** 2).sum(axis=0)), inf)
    for point, start, along, square in ((a, c, v, vv), (b, c, v, vv), (c, a, u, uu), (d, a, u, uu)):
        off = point - start
        share = np.clip((off * along).sum(axis=0) / np.maximum(square, 1e-300), 0.0, 1.0)
        best = np.minimum(best, np.sqrt(((off - share * along) ** 2).sum(axis=0)))
    return best
