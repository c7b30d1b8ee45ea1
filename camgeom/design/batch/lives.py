"""Fatigue lives of planar cams, rollers and bearings of many variants; of a roller's hot spot by the published count of
contacts (`mechanics.life`).

Path and squared pressure are known at the samples of the motion, polynomials between them. A roller's point meets
a wall every half turn of it, so that on a grid of the path that divides half a turn evenly all contacts of a point fall
on the grid: its damage is a sum of rows. The largest is looked for there, and on both sides of every jump.
"""

from __future__ import annotations

from functools import lru_cache
from math import pi
from typing import TYPE_CHECKING, final
from weakref import proxy

import numpy as np
from numpy.typing import NDArray

from camgeom.design.batch.motion import Motion, Points
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.bearing import ROLLER_EXPONENT, rated_hours
from camgeom.mechanics.life import hours

if TYPE_CHECKING:
    from camgeom.design.batch.planar import Cams

SAMPLES = 129
"""of a piece: where a cam is nearly undercut the pressure has sharp peaks, and its power of ten sharper ones"""
ORDER = 6
"""samples that a polynomial between two of them goes through"""
FINER = 4
"""points a step of the samples, between which path and pressure are taken as straight"""
LEAST_GRID = 32
"""grid points in half a turn of the roller, at least"""
GRID = 8192
"""grid points over the path, where that is more"""
LEAST_LOAD = 1e-200
"""N; a load below it is none"""
HIGH, MOST_PEAKS = 0.3, 16
EDGE = 1e-9
"""of the path: how near a jump is asked on either side"""


@lru_cache(maxsize=1)
def _between() -> Floats:
    """Matrix from SAMPLES values to FINER times as many, of the polynomials between them."""
    value = np.zeros((FINER * (SAMPLES - 1) + 1, SAMPLES))
    for i in range(SAMPLES - 1):
        first = int(np.clip(i - ORDER // 2 + 1, 0, SAMPLES - ORDER))
        powers = np.vander(np.arange(float(ORDER)) + first - i, ORDER, increasing=True)
        basis = np.linalg.inv(powers)
        for k in range(FINER + 1):
            value[FINER * i + k] = 0.0
            value[FINER * i + k, first : first + ORDER] = ((k / FINER) ** np.arange(ORDER)) @ basis
    return value


def _unrolled(motion: Motion, values: Floats) -> list[Floats]:
    """Samples (P, n) as pieces in the order of the cam angle, finer: (m, n) each."""
    full, found = np.broadcast_to(values, (values.shape[0], motion.size)), []
    for number, _ in sorted(enumerate(motion.rows), key=lambda one: one[1][:2]):
        if number < motion.moving:
            found.append(_between() @ full[number * SAMPLES : (number + 1) * SAMPLES])
        else:
            still = full[motion.moving * SAMPLES + number - motion.moving]
            found.append(np.stack([still, still]))
    return found


def _paths(motion: Motion, rate: Floats) -> list[Floats]:
    """Path, mm, over the pieces in the order of the cam angle, each from 0 on: a rim that turns back rolls on."""
    order = [number for number, _ in sorted(enumerate(motion.rows), key=lambda one: one[1][:2])]
    widths = np.broadcast_to(motion.widths, (len(motion.rows), motion.size))
    found = []
    for number, piece in zip(order, _unrolled(motion, rate)):
        size = np.abs(piece)
        steps = 0.5 * (size[1:] + size[:-1]) * (widths[number] / (len(size) - 1))
        found.append(np.concatenate([np.zeros((1, motion.size)), steps.cumsum(axis=0)]))
    return found


def roller_damage(motion: Motion, rate: Floats, behind: Floats, ahead: Floats, radius: Floats, power: Floats) -> Floats:
    """Largest damage of a turn over a roller's circumference, (n,), in shares of the cycles at the contact limit.

    rate    path per rad of cam angle, mm, (P, n) at the samples, with the sign of the way in which the rim turns
    behind, ahead  squared pressure over the contact limit on either wall, (P, n), 0 where it bears nothing
    """
    paths = _paths(motion, rate)
    ends = np.cumsum([piece[-1] for piece in paths], axis=0)
    begins = np.concatenate([np.zeros((1, motion.size)), ends[:-1]])
    path = np.concatenate([piece + begin for piece, begin in zip(paths, begins)]).T
    each = [np.concatenate(_unrolled(motion, wall)).T for wall in (behind, ahead)]
    exponent, r = 0.5 * np.broadcast_to(power, (motion.size,)), np.broadcast_to(radius, (motion.size,))
    walls = [np.maximum(wall, 0.0) ** exponent[:, None] for wall in each]
    jumps = np.concatenate([np.zeros((1, motion.size)), ends]).T
    return np.array([
        _largest(path[i], walls[0][i], walls[1][i], float(r[i]), jumps[i]) for i in range(motion.size)
    ])  # fmt: skip


def _largest(path: Floats, behind: Floats, ahead: Floats, radius: float, jumps: Floats) -> float:
    """The largest damage of one roller's points; path (m,), damage of either wall there, path at every jump."""
    half, long = np.pi * radius, float(path[-1])
    contacts = int(np.ceil(long / half)) + 2
    contacts += contacts % 2
    steps = max(LEAST_GRID, -(-GRID // contacts))
    grid = (np.arange(contacts * steps) + 0.5) * (half / steps)
    total = np.zeros(2 * steps)
    beside = np.concatenate([jumps - EDGE * long, jumps + EDGE * long])
    best = 0.0
    edges = []
    for wall, shift in ((behind, 0), (ahead, 1)):
        if wall.any():
            found = np.interp(grid[shift * steps :], path, wall, right=0.0)
            rows = found[: len(found) // (2 * steps) * 2 * steps].reshape(-1, 2 * steps)
            total += rows.sum(axis=0)
            total[: len(found) % (2 * steps)] += found[rows.size :]
            places = np.concatenate([beside, path[_peaks(wall)]])
            edges.append((places / radius - shift * np.pi) % (2.0 * np.pi))
    best = float(total.max())
    if edges:
        theta = np.concatenate(edges)
        meets = theta[:, None] * radius + half * np.arange(contacts)
        damage = np.zeros(len(theta))
        for wall, shift in ((behind, 0), (ahead, 1)):
            if wall.any():
                damage += np.interp(meets[:, shift::2], path, wall, left=0.0, right=0.0).sum(axis=1)
        best = max(best, float(damage.max()))
    return best


def _peaks(wall: Floats) -> NDArray[np.intp]:
    """Where damage peaks by more than HIGH of its largest, at most MOST_PEAKS places: an applied force may do so within
    a step of the grid."""
    inner = wall[1:-1]
    found = np.flatnonzero((inner >= wall[:-2]) & (inner > wall[2:]) & (inner > HIGH * wall.max())) + 1
    return found[np.argsort(-wall[found], kind="stable")[:MOST_PEAKS]]


@final
class Lives:
    """Fatigue of a chunk of planar cams, of their rollers and bearings."""

    def __init__(self, cams: Cams) -> None:
        self.cams: Cams = proxy(cams)

    @cached_property
    def rolled(self) -> Floats:
        """Path, mm/rad, (P, n), that the roller rolls on the flank it presses: of two rollers the hardest pressed."""
        return self.cams.hard_samples(lambda s: s.rolled)

    @cached_property
    def roller(self) -> Floats:
        """h, of the hot spot of the roller that lives least."""
        v = self.cams.variants
        limit, cycles, power = (
            v.number(f"material.roller.{key}") for key in ("contact_limit", "contact_cycles", "exponent")
        )
        points = self.cams.motion.sampled(SAMPLES)
        every = [self.cams.seen(touch, points) for touch in self.cams.touches]
        walls = [np.broadcast_to(seen.signed_square / limit**2, (points.s.shape[0], v.size)) for seen in every]
        none = np.zeros_like(walls[0])
        # Two rollers have a wall each, a groove's has both.
        rollers = ([(seen.turned, wall, none) for seen, wall in zip(every, walls)] if self.cams.alone
                   else [(self.cams.hard_samples(lambda s: s.turned, every), walls[0], (*walls, none)[1])])  # fmt: skip
        damage = [roller_damage(self.cams.motion, turned, one, other, self.cams.radius, power)
                  for turned, one, other in rollers]  # fmt: skip
        return hours(np.max(damage, axis=0) / cycles, self.cams.omega)

    @cached_property
    def _bearings(self) -> tuple[Floats, Floats]:
        """Equivalent load, N, and life, h, of the bearing of every roller, (rollers, n) each."""
        motion, loads, lives = self.cams.motion, [], []
        rating = self.cams.variants.number("roller.dynamic_rating")
        shape = (motion.samples.s.shape[0], self.cams.variants.size)
        each = ([(seen.pressing, seen.rolled) for seen in self.cams.all] if self.cams.alone
                else [(self.cams.hard_samples(lambda s: s.pressing), self.rolled)])  # fmt: skip
        for force, rate in (np.broadcast_arrays(*one, np.empty(shape))[:2] for one in each):
            most, path = np.maximum(force.max(axis=0), LEAST_LOAD), motion.integral(rate)
            share = motion.integral((force / most) ** ROLLER_EXPONENT * rate) / path
            loads.append(most * share ** (1.0 / ROLLER_EXPONENT))
            lives.append(rated_hours(rating, loads[-1], self.cams.omega * path / (2.0 * pi * self.cams.radius)))
        return np.array(loads), np.array(lives)

    @property
    def bearing_load(self) -> Floats:
        """Equivalent load, N, of the bearing that lives least."""
        loads, lives = self._bearings
        return np.asarray(loads[lives.argmin(axis=0), np.arange(loads.shape[1])])

    @property
    def bearing(self) -> Floats:
        """h, of the bearing that lives least."""
        return np.asarray(self._bearings[1].min(axis=0))

    @cached_property
    def cam(self) -> Floats:
        """h, at the hardest place of the cam."""
        v = self.cams.variants
        limit, cycles, power = (
            v.number(f"material.cam.{key}") for key in ("contact_limit", "contact_cycles", "exponent")
        )
        damage = (self.cams.pressure / limit) ** power / cycles
        if v.profile.kind == "constant-width":
            damage = np.maximum(damage, self._shared_damage(limit, cycles, power))
        return hours(damage, self.cams.omega)

    def _shared_damage(self, limit: Floats, cycles: Floats, power: Floats) -> Floats:
        """Largest damage of a cam's point that both faces of a frame or rollers of a yoke meet, half a turn apart."""
        near, away = self.cams.touches
        low, high = self.cams.motion.lift_range

        def both(p: Points) -> Floats:
            far = Points(p.theta + pi, low + high - p.s, -p.ds, -p.dds, -p.side)
            squares = (self.cams.seen(*one).signed_square for one in ((near, p), (away, far)))
            return np.asarray(sum((np.maximum(one, 0.0) / limit**2) ** (0.5 * power) for one in squares) / cycles)

        return self.cams.motion.largest(both)
