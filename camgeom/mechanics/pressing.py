"""What a roller presses over a turn: which wall of its track, along how much of its length, and with what force.

Units N, mm, MPa, rad; arrays on the panels (p, n) of `force`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar, final

import numpy as np
import numpy.typing as npt

from camgeom.errors import NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme
from camgeom.maths.frozen import cached_property
from camgeom.maths.panels import Panels, resolved, roots
from camgeom.maths.surface import dot
from camgeom.mechanics.contact import Contact, line_contacts
from camgeom.mechanics.load import FLAT, QUIET, FollowerForce, Load, guided_force, normal_force
from camgeom.track import Pose, Track
from camgeom.track.flank import Flank
from camgeom.track.follower import Ends
from camgeom.track.runout import Within, touching, wall_ends

SLICES = 9
"""equal shares of the length that touches"""
RESOLVED, KEEN = 1e-4, 3
"""share of the largest square of pressure to which panels resolve it, and how often they are halved for that"""
BLOCK = 65_536
"""points of the walls that are computed at once"""
MOST_PRESSED = 30_000
"""panels that a roller is followed on: some 15 s and 1.2 GB"""
NO_RADIUS = 1e-3
"""mm; smaller relative radii count as so much where panels are laid"""
Mask = npt.NDArray[np.bool_]
Kind = TypeVar("Kind", bound=np.generic)


@final
@immutable
class StationWalls:
    """The flank on panels (p, n) at one station, or at several, a leading axis (m,): curvature, lever and path rolled.

    behind, ahead  relative curvature, 1/mm; `ahead` is zero where the cam has no such wall
    lever          velocity of the contact point along the normal per unit of the coordinate (1 or mm/rad), > 0, of
                   the wall that bears
    cosine         of the pressure angle there
    rolled         path by which the roller's rim turns about its pin on either wall, mm/rad (see `Flank.rolled`)
    here           whether the walls behind and ahead exist beside the roller, which may leave the cam on purpose
    """

    behind: Floats
    ahead: Floats
    lever: Floats
    cosine: Floats
    rolled: tuple[Floats, Floats]
    here: tuple[Mask, Mask]


@final
@immutable
class Pressing:
    """A roller on the walls of its track; the fields are those of `RollerDuty`, pair the compliance of both, 1/MPa."""

    track: Track
    station: float
    length: float
    load: Load
    pair: float
    crowned: bool
    ends: Ends
    beside: Within | None
    runs_out: bool

    @cached_property
    def force(self) -> FollowerForce:
        """Motion and force of the follower on panels; what this track's walls can give.

        Its panels have an edge where it changes sign: the roller goes over to the other wall, on which it turns at
        another speed. A track with one wall (force-closed cam, one disc of a conjugate pair) pushes one way only:
        there the force is clipped at zero.
        """
        full = self._within(self.load.sampled())
        if self.runs_out:
            return self._within(self._held(full))
        zeros = roots(full.panels, full.force[None], QUIET * float(np.abs(full.force).max(initial=0.0)))[0]
        edges = np.concatenate([zeros, *self._square(full.panels)])
        if edges.size:
            full = self._within(self.load.sampled(full.panels.split(edges)))
        if len(self.track.sides) > 1:
            # One roller between both walls: of two that have a wall each the forces are added up on the same panels.
            keen = resolved(lambda theta: self._hardness(full, theta), full.panels, RESOLVED, KEEN)
            return self._within(self.load.sampled(keen)) if len(keen.half) > len(full.panels.half) else full
        wall = Flank(self.track, full.panels.theta[0], np.array([self.station]), self.track.sides[0])
        sign = 1.0 if wall.behind else -1.0
        return replace(full, force=np.maximum(sign * full.force, 0.0) * sign)

    def _within(self, full: FollowerForce) -> FollowerForce:
        """The same; raises NotConverged where its panels are more than those that a roller is followed on."""
        if (count := len(full.panels.half)) > MOST_PRESSED:
            raise NotConverged(
                f"the roller's contact takes {count} stretches of the turn, more than the {MOST_PRESSED} it is "
                "followed on; fewer segments of the motion, pieces of its laws or rows of forces need less"
            )
        return full

    def _hardness(self, full: FollowerForce, theta: Floats) -> Floats:
        """The force times the relative curvature of the wall that it presses, at either end of the roller and at cam
        angles (p, n), (2, p, n): what the square of the pressure goes with, and may peak in less than a panel."""
        ends = self.track.meridian.parameters(np.array(sorted(self.track.contact)))
        force = full.panels.at(full.force, theta.ravel())
        found = np.zeros((2, theta.size))
        for side in self.track.sides:
            flank = Flank(self.track, theta.ravel(), ends, side)
            pressed = (force >= 0.0) if flank.behind else (force < 0.0)
            found[:, pressed] = np.clip(flank.k_rel[pressed].T, 0.0, 1.0 / NO_RADIUS) * np.abs(force[pressed])
        return found.reshape(2, *theta.shape)

    def _square(self, panels: Panels) -> list[Floats]:
        """Cam angles, rad, at which a planar cam's pressure angle passes zero: the thrust on a slide's guides has a
        kink there."""
        if not (self.load.guide_friction > 0.0 and self.track.upright):
            return []
        at = np.array([self.station])
        lean = [Flank(self.track, panels.theta.ravel(), at, side).lean() for side in self.track.sides]
        return roots(panels, np.stack([one.reshape(panels.theta.shape) for one in lean]), FLAT)

    def _held(self, full: FollowerForce) -> FollowerForce:
        """The force where the wall that it presses exists beside some slice of the roller, none elsewhere."""
        assert self.beside is not None
        places = np.array([self.middle]) if self.crowned else self.middles
        stations = self.track.meridian.parameters(places)
        edges = [roots(full.panels, full.force[None], QUIET * float(np.abs(full.force).max(initial=0.0)))[0]]
        edges += [lost for side in self.track.sides for lost in wall_ends(self.track, side, stations, self.beside)]
        split = self.load.sampled(full.panels.split(np.concatenate(edges)))
        theta = split.panels.theta
        held = np.zeros(theta.shape, dtype=bool)
        for side in self.track.sides:
            flank = Flank(self.track, theta.ravel(), stations, side)
            there = (self.beside(flank.x).max(axis=1) >= 0.0).reshape(theta.shape)
            held |= there & ((split.force >= 0.0) if flank.behind else (split.force < 0.0))
        return replace(split, force=np.where(held, split.force, 0.0))

    @cached_property
    def unheld(self) -> Extreme | None:
        """Largest force on the follower, N (N mm), that presses where no wall is; None where a wall is all round."""
        if not self.runs_out:
            return None
        full = np.abs(self.load.sampled(self.force.panels).force)
        lost = np.where(self.force.force == 0.0, full, 0.0)
        at = np.unravel_index(int(np.argmax(lost)), lost.shape)
        return Extreme(float(lost[at]), float(self.force.panels.theta[at]))

    @cached_property
    def middles(self) -> Floats:
        """Middles of SLICES equal slices of the whole contact stretch, mm."""
        edges = np.linspace(min(self.track.contact), max(self.track.contact), SLICES + 1)
        return np.asarray(0.5 * (edges[1:] + edges[:-1]))

    @cached_property
    def _poses(self) -> dict[float, Pose]:
        """Poses of the roller on the panels that cut the flank on each side: one where no flank recedes."""
        theta = self.force.panels.theta.ravel()
        shared = self.track.pose(theta)
        eased = {side: self.track.eased(side) for side in self.track.sides}
        return {side: shared if track is self.track else track.pose(theta) for side, track in eased.items()}

    def _flank(self, t: Floats, side: float) -> Flank:
        """A flank on the panels, at meridian parameters t (m,), or (p n, m) for each cam angle."""
        return Flank(self.track, self.force.panels.theta.ravel(), t, side, given_pose=self._poses[side])

    def walls(self, t: Floats) -> StationWalls:
        """The flank at meridian parameters t (m,), or (p n, m) for each cam angle; so many angles at once as memory
        likes."""
        shape, count = self.force.panels.theta.shape, self.force.panels.theta.size
        size = max(1, BLOCK // t.shape[-1])
        blocks = [self._walls(t, slice(at, at + size)) for at in range(0, count, size)]

        def laid(parts: Sequence[npt.NDArray[Kind]]) -> npt.NDArray[Kind]:
            values = parts[0] if len(parts) == 1 else np.concatenate(parts)
            return values.reshape(shape) if t.shape[-1] == 1 else values.T.reshape(-1, *shape)

        behind, ahead, lever, cosine, before, after, one, other = map(laid, zip(*blocks, strict=True))
        return StationWalls(behind, ahead, lever, cosine, (before, after), (one, other))

    def _walls(self, t: Floats, block: slice) -> tuple[Floats, Floats, Floats, Floats, Floats, Floats, Mask, Mask]:
        """What `StationWalls` has, in its order, at some of the cam angles, (k, m) each."""
        theta, t = self.force.panels.theta.ravel()[block], t if t.ndim == 1 else t[block]
        poses = {side: pose if len(theta) == len(pose.turn) else pose.between(block.start, block.stop)
                 for side, pose in self._poses.items()}  # fmt: skip
        flanks = {side: Flank(self.track, theta, t, side, given_pose=poses[side]) for side in self.track.sides}
        behind = next((side for side in flanks if self._behind[side]), None)
        ahead = next((side for side in flanks if side != behind), None)
        some = next(iter(flanks.values()))
        here = {side: self._here(flank) for side, flank in flanks.items()}
        curvature = {side: flank.k_rel for side, flank in flanks.items()}
        if self.beside is not None:
            # A fold in free air is nobody's stress: a plane stands for it.
            curvature = {side: np.where(here[side] | (k > 0.0), k, 1.0 / self.radius) for side, k in curvature.items()}
        zero = np.zeros_like(some.rolled)
        none = np.zeros(zero.shape, dtype=bool)
        # A cone whose arm carries it aside touches its walls at two places that are no mirror images of each other.
        one, other = (flanks[side] if side is not None else some for side in (behind, ahead))
        pressed = self.force.force.ravel()[block, None] >= 0.0
        return (
            curvature[behind] if behind is not None else zero,
            curvature[ahead] if ahead is not None else zero,
            np.where(pressed, np.abs(one.lever()), np.abs(other.lever())),
            np.where(pressed, np.cos(one.pressure_angle()), np.cos(other.pressure_angle())),
            flanks[behind].rolled if behind is not None else zero,
            flanks[ahead].rolled if ahead is not None else zero,
            here[behind] if behind is not None else none,
            here[ahead] if ahead is not None else none,
        )

    @cached_property
    def _behind(self) -> dict[float, bool]:
        """Which of the sides is the wall behind."""
        return {side: self._flank(np.array([self.station]), side).behind for side in self.track.sides}

    def _here(self, flank: Flank) -> Mask:
        """Where a flank's points are on the cam, (n, m)."""
        return np.ones(flank.x.shape[1:], dtype=bool) if self.beside is None else self.beside(flank.x) >= 0.0

    @cached_property
    def reference(self) -> StationWalls:
        """The flank at the station."""
        return self.walls(np.array([self.station]))

    @cached_property
    def path_rate(self) -> Floats:
        """Path that the roller rolls on the wall that it presses, mm/rad, (p, n)."""
        behind, ahead = self.reference.rolled
        pressed = self.normal >= 0.0 if len(self.track.sides) > 1 else behind > 0.0
        return np.where(pressed, behind, ahead)

    @cached_property
    def radius(self) -> float:
        """Roller radius at the station, mm."""
        return float(self.track.meridian.jet(np.array([self.station]))[3][0])

    @cached_property
    def normal(self) -> Floats:
        """Signed normal force on the roller, N, (p, n); positive on the wall behind."""
        w = self.reference
        return normal_force(self.pushed, w.cosine, w.lever / w.cosine)

    @cached_property
    def pushed(self) -> Floats:
        """Force along the motion with the friction that the side thrust makes in a slide's guides, N (N mm), (p, n)."""
        force = self.force
        return guided_force(force.force, self.reference.cosine, self.load.guide_friction, force.direction)

    @cached_property
    def as_line(self) -> Contact:
        """Contact at the station as a line over the whole length, as if there were no crown."""
        w = self.reference
        return line_contacts(self.force.panels, self.normal, w.behind, w.ahead, self.path_rate, self.length, self.pair)

    def rated(self, square: Floats, load: Floats) -> Contact:
        """Contact on the wall that bears: squared pressures, MPa², negative where none is, and loads, (..., p, n)."""
        line, off = self.as_line, -np.abs(square)
        behind, ahead = np.where(self.normal >= 0.0, square, off), np.where(self.normal < 0.0, square, off)
        rate, sound = np.broadcast_to(line.path_rate, square.shape), np.broadcast_to(line.sound, square.shape[:-2])
        return Contact(self.force.panels, load, behind, ahead, rate, sound)

    @property
    def middle(self) -> float:
        """Place of the contact's middle along the roller axis (delta), mm: the top of a crown that is not tilted."""
        return 0.5 * sum(self.track.contact)

    @cached_property
    def curvature(self) -> Floats:
        """Relative curvature of the wall that bears, across the roller's axis, 1/mm, (p, n); 1 of one undercut."""
        k = np.where(self.normal >= 0.0, self.reference.behind, self.reference.ahead)
        return np.where(k > 0.0, k, 1.0)

    @cached_property
    def stretch(self) -> tuple[Floats, Floats]:
        """The ends (delta, mm), (p, n) each, of what touches the wall that the roller presses."""
        theta, meridian = self.force.panels.theta, self.track.meridian
        low, high = (np.full(theta.size, end) for end in sorted(self.track.contact))
        for side in self.track.sides if self.beside is not None else ():
            behind = Flank(self.track, theta[0], np.array([self.station]), side).behind
            mine = np.flatnonzero((self.force.force.ravel() >= 0.0) == behind)
            if len(self.track.sides) == 1:
                mine = np.arange(theta.size)
            if self.beside is not None and len(mine):
                ends = touching(self.track, side, theta.ravel()[mine], self.beside)
                low[mine], high[mine] = (meridian.jet(end)[0] for end in ends)
        return low.reshape(theta.shape), high.reshape(theta.shape)

    @cached_property
    def touching(self) -> Floats:
        """Length of the roller that touches the wall it presses, mm, (p, n); 0 where it has none."""
        return self.stretch[1] - self.stretch[0]

    @cached_property
    def bears(self) -> Mask:
        """Where a force worth the name presses, (p, n)."""
        return np.asarray(np.abs(self.normal) > QUIET * np.abs(self.normal).max(initial=0.0))

    @cached_property
    def least_touching(self) -> Extreme:
        """Least of that length where a force presses, mm; the whole length without any force."""
        length = np.where(self.bears, self.touching, np.inf)
        at = np.unravel_index(int(np.argmin(length)), length.shape)
        return Extreme(min(float(length[at]), self.length), float(self.force.panels.theta[at]))

    @cached_property
    def alignment(self) -> Floats:
        """cos² of the angle between the roller's axis and its line of contact with the wall that bears, (p, n)."""
        theta = self.force.panels.theta
        walls = {}
        for side in self.track.sides:
            flank = self._flank(np.array([self.station]), side)
            line = flank.tangents[1][:, :, 0]
            square = dot(line, flank.pose.u[0]) ** 2 / dot(line, line)
            walls[flank.behind] = square.reshape(theta.shape)
        some = next(iter(walls.values()))
        return np.where(self.normal >= 0.0, walls.get(True, some), walls.get(False, some))

    def runs(self, places: Floats, crest: Floats | None = None) -> tuple[Floats, Floats, Floats]:
        """Of places (delta, mm) along the roller (m, p, n), likewise, mm/rad: mean speed of both surfaces through the
        contact, the contact's along the cam, and sliding.

        Round the roller, which rolls without slip at the station, or at a crest (delta, mm, (p, n)), and along
        its axis.
        """
        shape = self.force.panels.theta.shape
        both = len(self.track.sides) > 1
        many = len(places)
        stations = self.track.meridian.parameters(places.reshape(many, -1, 1))
        found = np.zeros((3, many, *shape))
        for m, t in enumerate(stations):
            for side in self.track.sides:
                flank = self._flank(t, side)
                pressed = (self.normal >= 0.0) == flank.behind if both else np.ones(shape, dtype=bool)
                on_cam = flank.passing.reshape(shape)
                radius = self.track.meridian.jet(t)[3].reshape(-1)[0 if t.size == 1 else slice(None)]
                rim = self.path_rate * np.reshape(radius, shape if np.size(radius) > 1 else ()) / self.radius
                if crest is not None:
                    rim = self._flank(self.track.meridian.parameters(crest.reshape(-1, 1)), side).rolled
                slip = rim.reshape(shape) - flank.rolled.reshape(shape)
                axial = flank.sliding()[1].reshape(shape)
                each = (np.abs(on_cam + 0.5 * slip), on_cam, np.hypot(slip, axial))
                for kind, values in enumerate(each):
                    found[kind, m] = np.where(pressed, values, found[kind, m])
        return found[0], found[1], found[2]
