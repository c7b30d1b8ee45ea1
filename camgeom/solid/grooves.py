"""A drum with several closed grooves beside each other, meshed directly as one structured grid."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.frozen import cached_property
from camgeom.maths.sampling import sample
from camgeom.solid import QuickPart, Solid, eased
from camgeom.solid.blank import Blank, Wall
from camgeom.solid.drum import GroovedCylinder, closed_body, edge_at, height_above, on_cylinder, refuse_turned
from camgeom.track import TURN
from camgeom.track.column import Column

SAMPLES, STRIDE = 721, 16
NEARER, ROUNDS = 17, 6
"""cam angles about the nearest samples of both edges that are looked at again, in steps a quarter as long each time"""
DEPTHS = 7
"""places between floor and outside at which lands are measured"""
APART = "grooves further apart (cam.start), smaller rollers, or shorter strokes"


@immutable
class GroovedDrum(QuickPart):
    """A cylinder 0 <= z <= length with several closed grooves round it, in any order along it."""

    name: str
    rings: tuple[GroovedCylinder, ...]
    blank: Blank
    radius: float
    length: float

    @cached_property
    def ordered(self) -> tuple[GroovedCylinder, ...]:
        """The grooves from the lower end to the upper one, each as if it were alone in the drum."""
        return tuple(sorted(self.rings, key=lambda ring: float(self._edge(ring, 1.0, np.zeros(1))(self.radius)[2, 0])))

    def _edge(self, ring: GroovedCylinder, which: float, phi: Floats) -> Callable[[float], Floats]:
        """The lower (1) or the upper (-1) edge of a groove, (3, n), as deep as a radius, mm, to the drum's own."""
        column, section = Column(ring.track, phi), ring.section
        side = which * section.first
        outside = column.reach(side, section.level, self.radius)
        return lambda depth: edge_at(column, side, outside, depth, self.radius)

    def _depths(self, *rings: GroovedCylinder) -> Floats:
        """Radii, mm, from the floor of the shallower groove to the outside: grooves near the axis are nearer in arc."""
        return np.linspace(max(ring.track.tip for ring in rings), self.radius, DEPTHS)

    @property
    def fits(self) -> bool:
        """True where every groove stays inside both end faces and none reaches into the next one."""
        return all(ring.fits for ring in self.rings) and not self._crossed

    @cached_property
    def lands(self) -> tuple[Wall, ...]:
        """What is left between neighbouring grooves along the drum, mm, at the cam angle of the lower one's edge.

        Straight from flank to flank, near where in the developed cylinder edges at one depth are nearest in any
        direction.
        """
        found = []
        for (lower, upper), (name, edges) in zip(pairwise(self.ordered), self._facing):
            each = [_land(*one, self._phi) for one in edges]
            depth = int(np.argmin([width for width, *_ in each]))
            thickness, at, there = each[depth]
            if thickness > 0.0:
                thickness, at = self._nearest(lower, upper, float(self._depths(lower, upper)[depth]), at, there)
            found.append(Wall(name, thickness, at, APART))
        return tuple(found)

    def _nearest(
        self, lower: GroovedCylinder, upper: GroovedCylinder, depth: float, at: float, there: float
    ) -> tuple[float, float]:
        """Least distance, mm, of two flanks near a depth and cam angles of both, rad, and that of the lower one."""
        around, down = np.linspace(-TURN, TURN, NEARER) / (SAMPLES - 1), np.linspace(-1.0, 1.0, 5) / DEPTHS
        places = [(lower, -1.0, at, depth), (upper, 1.0, there, depth)]
        for _ in range(ROUNDS):
            seen = []
            for ring, which, angle, deep in places:
                phi, tip = np.mod(angle + around, TURN), ring.track.tip
                depths = np.clip(deep + down * (self.radius - tip), tip, self.radius)
                edge = self._edge(ring, which, phi)
                seen.append((phi, depths, np.stack([edge(float(one)) for one in depths], axis=1).reshape(3, -1)))
            off = seen[0][2][:, :, None] - seen[1][2][:, None, :]
            square = (off * off).sum(axis=0)
            pair = np.unravel_index(int(np.argmin(square)), square.shape)
            places = [
                (ring, which, float(phi[k % NEARER]), float(depths[k // NEARER]))
                for (ring, which, *_), (phi, depths, _), k in zip(places, seen, pair)
            ]
            around, down = 0.25 * around, 0.5 * down
        return float(np.sqrt(square[pair])), places[0][2]

    @property
    def _phi(self) -> Floats:
        return np.linspace(0.0, TURN, SAMPLES)

    @cached_property
    def _facing(self) -> list[tuple[str, list[tuple[Floats, Floats]]]]:
        """Name of every land and the edges (3, n) below and above it at each depth."""
        found = []
        for lower, upper in pairwise(self.ordered):
            below, above = self._edge(lower, -1.0, self._phi), self._edge(upper, 1.0, self._phi)
            name = f"{lower.track.name} to {upper.track.name}"
            found.append((name, [(below(depth), above(depth)) for depth in self._depths(lower, upper)]))
        return found

    @property
    def _crossed(self) -> list[str]:
        """Names of lands whose edges cross: nothing is left of these, and the others' widths need not be known."""
        return [name for name, edges in self._facing if min(height_above(*each).min() for each in edges) <= 0.0]

    def knots(self) -> Floats:
        """Cam angles at which a derivative of any groove's motion may jump, with both ends of the turn, rad."""
        every = distinct(np.concatenate([ring.track.knots() for ring in self.rings]))
        return np.asarray(every[np.concatenate([[True], np.diff(every) > 1e-9])])

    def refuse_overlap(self) -> None:
        """DesignError where a groove runs out of an end face or into the next one."""
        if not all(ring.fits for ring in self.rings):
            raise DesignError("a groove runs out of an end face, so the body is not one closed grid")
        for name in self._crossed:
            raise DesignError(f"{name}: the grooves run into each other, so they bound no body; {APART}")

    def solid(self, tolerance: float, free: float | None = None) -> Solid:
        """Mesh directly. Raises DesignError where a groove runs out of an end face or into the next one."""
        self.refuse_overlap()
        rings = self.ordered
        sections = [ring.section for ring in rings]
        most: tuple[int, ...] = (1,)
        names: tuple[str, ...] = ("land",)
        for section in sections:
            most, names = (*most, *section.max_counts, 400), (*names, *section.names, "land")

        def rows(phi: Floats, counts: tuple[int, ...]) -> Floats:
            parts: list[Floats] = []
            place, edge = 1, np.zeros(0)
            for ring, section in zip(rings, sections):
                width = len(section.max_counts)
                groove = section.rows(Column(ring.track, phi), counts[place : place + width])
                if not parts:
                    parts.append(GroovedCylinder.land(groove[:, :, 0], 0.0, counts[0]))
                else:
                    between = counts[place - 1]
                    parts.append(on_cylinder(edge, groove[:, :, 0], self.radius, np.arange(1, between) / between))
                parts.append(groove)
                edge, place = groove[:, :, -1], place + width + 1
            parts.append(GroovedCylinder.land(edge, self.length, counts[-1])[:, :, ::-1])
            return np.concatenate(parts, axis=2)

        grid = sample(rows, self.knots(), tolerance, (*most[:-1], 1), eased(names, tolerance, free))
        ends = np.cumsum(grid.counts)[:-1]
        refuse_turned([grid.points[:, :, k] for k in ends], "groove's")
        sense = rings[0].track.sense
        return closed_body(self.name, grid, names, sense > 0, (0.0, self.length), self.blank, tolerance, free)


def _land(below: Floats, above: Floats, phi: Floats) -> tuple[float, float, float]:
    """Width of a land between edges (3, n) at one depth, mm, below 0 where they cross, and the cam angles of the lower
    and of the upper edge, rad."""
    radius = min(float(np.hypot(x[0], x[1]).min()) for x in (below, above))
    above_it = height_above(below, above)
    at = int(np.argmin(above_it))
    if above_it[at] <= 0.0:
        return float(above_it[at]), float(phi[at]), float(phi[at])
    flat = [np.stack([radius * np.unwrap(np.arctan2(x[1], x[0])), x[2]]) for x in (below, above)]
    turn = TURN * radius
    start, along = flat[1][:, :-1], np.diff(flat[1], axis=1)
    square = np.maximum((along * along).sum(axis=0), 1e-300)

    # Along an edge a distance changes by no more than the way: of what is looked at roughly, points from points, only
    # what may hold the least one is measured, points from segments.
    count, some = len(square), np.arange(0, len(phi), STRIDE)
    off = flat[0][:, some, None] - start[:, None, :]
    off[0] -= turn * np.rint(off[0] / turn)
    rough = np.sqrt(off[0] * off[0] + off[1] * off[1])
    least, longest = float(rough.min()), float(np.sqrt(square.max()))
    way = np.r_[0.0, np.cumsum(np.hypot(*np.diff(flat[0], axis=1)))]
    near = np.minimum((np.arange(len(phi)) + STRIDE // 2) // STRIDE, len(some) - 1)
    beside, reach = np.abs(way - way[some[near]]), np.zeros(len(some))
    np.maximum.at(reach, near, beside)
    rows = np.flatnonzero(rough.min(axis=1)[near] - beside - longest <= least)
    first = rough.argmin(axis=1)
    here, there = np.nonzero(rough - reach[:, None] - longest <= least)
    apart = (there - first[here] + count // 2) % count - count // 2
    most = int(np.abs(apart).max())
    segments = (first[near[rows], None] + np.arange(-most, most + 1)) % count
    d, along = flat[0][:, rows, None] - start.take(segments, axis=1), along.take(segments, axis=1)
    d[0] -= turn * np.rint(d[0] / turn)
    share = np.einsum("kij,kij->ij", d, along)
    share /= square.take(segments)
    d -= np.clip(share, 0.0, 1.0, out=share) * along
    distance = np.einsum("kij,kij->ij", d, d)
    i, j = np.unravel_index(int(np.argmin(distance)), distance.shape)
    return float(np.sqrt(distance[i, j])), float(phi[rows[i]]), float(phi[segments[i, j]])
