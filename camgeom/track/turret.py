"""A turret beside its cam: its grooves, which rollers bear at each cam angle, the hand-over, how thick the ribs are.

A turret that steps by several roller pitches in a cam turn needs as many different grooves (starts); every roller of
the turret runs through one of them, some turns earlier or later. A turret that swings to and fro has one closed groove
for every roller that comes beside the cam.

Arrays: n cam angles, k rollers (each place a roller takes beside the cam counts as one), m slices along the roller.
Direction 0 holds the walls that can push the turret towards larger angles, direction 1 those that can hold it back.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from math import ceil, floor, pi
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from camgeom.immutable import immutable
from camgeom.maths import Floats, among, distinct
from camgeom.maths.extremum import FAN, Extreme, bracketed_maximum
from camgeom.maths.frozen import cached_property, shelved
from camgeom.motion.program import Program
from camgeom.track import TURN, Arc, Track
from camgeom.track.clearance import roller_distance
from camgeom.track.column import Column
from camgeom.track.flank import Flank
from camgeom.track.runout import PLACES, Within, changes, touching

Bools = npt.NDArray[np.bool_]
Slicing = Literal["even", "ended", "graded"]
"""of a roller's contact stretch: SLICES alike, those and the two ends of what touches as slices without width, or finer
ones in the middle, where a crown touches"""
Indices = npt.NDArray[np.intp]
SLICES = 7
GRADED = 31
"""slices that grow with the square of their distance from a roller's middle: five lie in a fortieth of its length"""
AT_ONCE = 2**14
"""slices of rollers that are looked at at once: what they need stays next to the processor"""
HANDS = 6
"""rounds in which a hand-over is looked at between FAN cam angles"""
BESIDE = 1e-8
"""rad on either side of a cam angle at which a roller comes to bear or ceases to"""
NEARBY = 0.04
"""rad; flanks this far on either side of a contact line are looked at for what stands nearest to the roller"""

def turret_tracks(first: Track, rollers: int, base: float, reach: float) -> tuple[Track, ...]:
    """Tracks of all grooves from that of one roller (its shift is ignored).

    rollers  on the turret, evenly spaced; base: angle of the first one from the line of centres in the first dwell, rad
    reach    angle from the line of centres, rad, within which a roller is followed
    """
    pitch = TURN / rollers
    if first.program.closed:
        return _oscillating(first, rollers, base, pitch, reach)
    starts = max(1, round(abs(first.program.advance) / pitch))
    found = []
    for j in range(starts):
        shift = base + j * pitch
        name = f"{first.name} {j + 1}" if starts > 1 else first.name
        found.append(replace(first, shift=shift, span=engaged_span(first.program, shift, reach), name=name))
    return tuple(found)


def _oscillating(first: Track, rollers: int, base: float, pitch: float, reach: float) -> tuple[Track, ...]:
    """To-and-fro drives: every roller that comes beside the cam has its own closed groove."""
    lifts = [lift for span in first.program.spans for lift in (span.before, span.after)]
    found: list[Track] = []
    for k in range(-rollers, rollers + 1):
        shift = base + k * pitch
        if shift + max(lifts) > -reach and shift + min(lifts) < reach and abs(shift) <= pi:
            found.append(replace(first, shift=shift, span=(0.0, TURN), name=f"{first.name} {len(found) + 1}"))
    return tuple(found)


@lru_cache(maxsize=256)
def engaged_span(program: Program, shift: float, reach: float) -> tuple[float, float]:
    """Cam angles (over several turns) between which the turret angle lift + shift lies within +-reach, rad."""
    advance = program.advance
    low = TURN * floor((-reach - shift) / advance - 1.0)
    high = TURN * ceil((reach - shift) / advance + 1.0)

    def crossing(level: float) -> float:
        a, b = low, high
        for _ in range(80):
            grid = np.linspace(a, b, 9)
            beyond = program.jet(grid, 0)[0] + shift >= level
            first = max(1, int(np.argmax(beyond))) if beyond.any() else 8
            a, b = float(grid[first - 1]), float(grid[first])
            if b - a <= 4.0 * np.spacing(abs(b) + abs(a)):
                break
        return b

    return crossing(-reach), crossing(reach)


def comings(tracks: tuple[Track, ...], within: Within, samples: int = 181) -> tuple[Floats, Floats]:
    """Cam angles in [0, 2 pi], rad, at which a roller, and its middle slice, comes to have a wall or ceases to.

    With the first or last share of its wall a roller presses as hard as with all of it: what presses whom jumps there.
    """
    theta = np.linspace(0.0, TURN, samples)
    whole, middle = [np.zeros(0)], [np.zeros(0)]
    for index, turn in Engagement(tracks, within, theta).places:
        track = tracks[index]
        phi = theta + TURN * turn
        inner = phi[(phi > track.span[0]) & (phi < track.span[1])]
        # A wall may be shorter than the samples are apart.
        ends = [end for end in track.span if not track.closed and phi[0] <= end <= phi[-1]]
        phi = np.sort(np.concatenate([inner, ends]))
        if not len(phi):
            continue
        low, high = sorted(track.meridian.parameter(d) for d in track.contact)
        inset = (SLICES // 2) * (high - low) / SLICES
        for found, t in (
            (whole, np.linspace(low, high, PLACES)),
            (middle, np.linspace(low + inset, high - inset, PLACES // SLICES)),
        ):
            for side in track.sides:

                def deep(at: Floats, track: Track = track, t: Floats = t, side: float = side) -> Floats:
                    return np.asarray(within(Column(track.eased(side), at).wall(side, t)).max(axis=1))

                values = deep(phi)
                # A wall may end with the span.
                found += [np.array([end - TURN * turn]) for end in ends if values[np.searchsorted(phi, end)] >= 0.0]
                found.append(changes(deep, phi, values) - TURN * turn)
    return np.sort(np.concatenate(whole)), np.sort(np.concatenate(middle))


def _edges(track: Track, slicing: Slicing) -> Floats:
    """Meridian parameters between the slices of a roller that have a width, (m + 1,)."""
    low, high = sorted(track.meridian.parameter(d) for d in track.contact)
    if slicing != "graded":
        return np.linspace(low, high, SLICES + 1)
    u = np.linspace(-1.0, 1.0, GRADED + 1)
    return np.asarray(0.5 * (low + high) + 0.5 * (high - low) * u * np.abs(u))


class _Wall(NamedTuple):
    """A wall beside a roller: its flank at stations t (n, m), which way it pushes (n,), its levers, and of every slice
    its ends, whether it has a wall, and whether at least half of it has."""

    flank: Flank
    way: npt.NDArray[np.intp]
    lever: Floats
    t: Floats
    low: Floats
    high: Floats
    touches: Bools
    on: Bools


@immutable
class Engagement:
    """Every roller beside the cam at cam angles theta (n,), both walls, sliced along its contact stretch.

    within   how deep points lie within the blank: beyond it a roller has no wall to bear on
    known   of the same rollers at other cam angles, in rising order: where it stands at one of these it is believed
    slicing  at which places along a roller it is looked at, see `Slicing`
    """

    tracks: tuple[Track, ...]
    within: Within
    theta: Floats
    known: Engagement | None = None
    slicing: Slicing = "even"

    @cached_property
    def places(self) -> tuple[tuple[int, int], ...]:
        """(track, turn) of every roller that is ever beside the cam; its own angle is theta + turn * 2 pi."""
        found = []
        for index, track in enumerate(self.tracks):
            low, high = track.span
            turns = range(floor(low / TURN), ceil(high / TURN)) if not track.closed else range(1)
            found += [(index, turn) for turn in turns]
        return tuple(found)

    @cached_property
    def stations(self) -> Floats:
        """Meridian parameters of the slices' middles, and of the contact's ends where these count too, (m,)."""
        edges = _edges(self.tracks[0], self.slicing)
        return self._ended(0.5 * (edges[1:] + edges[:-1]), edges[0], edges[-1])

    def _ended(self, values: npt.NDArray[Any], first: Any, last: Any) -> npt.NDArray[Any]:
        """Values of the slices that have a width (..., m), between those (...) of the ends where these count too."""
        if self.slicing != "ended":
            return values
        return np.concatenate([np.expand_dims(first, -1), values, np.expand_dims(last, -1)], axis=-1)

    @property
    def length(self) -> float:
        """Contact length of a roller along its axis, mm."""
        low, high = sorted(self.tracks[0].contact)
        return high - low

    @cached_property
    def runs(self) -> tuple[Floats, Floats]:
        """Speed of the contact along the cam, and sliding along the roller's axis, mm/rad, (2, n, k, m) each."""
        on_cam, axial = np.zeros((2, *self.curvature.shape))
        for track, phi, rows, place in self._rollers():
            for wall in self._beside(track, phi, 2):
                on_cam[wall.way, rows, place] = wall.flank.passing
                axial[wall.way, rows, place] = wall.flank.sliding()[1]
        return on_cam, axial

    @shelved
    def _walls(self) -> dict[str, Any]:
        n, k, m = len(self.theta), len(self.places), len(self.stations)
        out = {
            "lever": np.ones((2, n, k, m)),
            "curvature": np.ones((2, n, k, m)),
            "on": np.zeros((2, n, k, m), dtype=bool),
            "touches": np.zeros((2, n, k, m), dtype=bool),
            "cover": np.zeros((2, n, k, m)),
            "place": np.zeros((2, n, k, m)),
            "normal": np.zeros((2, n, k, m, 3)),
            "turning": np.zeros((2, n, k, m)),
            "angle": np.full((2, n, k, m), np.pi / 2.0),
        }
        fresh = np.ones(n, dtype=bool)
        if self.known is not None:
            believed = self.known._walls  # may make room meanwhile
            at, there = among(self.known.theta, self.theta)
            fresh = ~there
            for name, values in out.items():
                values[:, there] = believed[name][:, at[there]]
        for found in self._rollers(fresh):
            self._fill(out, *found)
        return out

    def _rollers(self, asked: Bools | None = None) -> Iterator[tuple[Track, Floats, Indices, Indices]]:
        """All rollers of each track at the cam angles that are asked for, as one: the track, their own angles (q,), and
        of each of these the row of theta and the place."""
        for number, track in enumerate(self.tracks):
            places = np.array([k for k, (index, _) in enumerate(self.places) if index == number], dtype=np.intp)
            phi = self.theta + TURN * np.array([self.places[k][1] for k in places])[:, None]
            some = (phi >= track.span[0]) & (phi <= track.span[1])
            which, rows = np.nonzero(some if asked is None else some & asked)
            step = max(1, AT_ONCE // len(self.stations))
            for first in range(0, len(rows), step):
                part = slice(first, first + step)
                yield track, phi[which[part], rows[part]], rows[part], places[which[part]]

    @cached_property
    def held(self) -> Bools:
        """Whether a roller has a wall to bear on with any slice, (2, n, k); without what else `on` comes with."""
        held = np.zeros((2, len(self.theta), len(self.places)), dtype=bool)
        for track, phi, rows, place in self._rollers():
            for wall in self._beside(track, phi, 1):
                held[wall.way, rows, place] = wall.on.any(axis=1)
        return held

    def _beside(self, track: Track, phi: Floats, order: int) -> Iterator[_Wall]:
        """The walls beside a roller at its cam angles (n,), from poses to an order of derivatives."""
        edges = _edges(track, self.slicing)
        shared = track.pose(phi, order)
        for side in track.sides:
            eased = track.eased(side)
            pose = shared if eased is track else eased.pose(phi, order)
            begin, stop = touching(track, side, phi, self.within, pose)
            low, high = np.maximum(edges[:-1], begin[:, None]), np.minimum(edges[1:], stop[:, None])
            some = high > low
            on = some & (high - low >= 0.5 * np.diff(edges))
            ends = np.maximum(begin, edges[0]), np.minimum(stop, edges[-1])
            low, high = (self._ended(each, *ends) for each in (low, high))
            some, on = (self._ended(each, each.any(axis=1), each.any(axis=1)) for each in (some, on))
            # Of a slice that stands out of the cam with one end, the rest is looked at.
            t = np.where(some, 0.5 * (low + high), self.stations)
            flank = Flank(track, phi, t, side, given_pose=pose)
            lever = flank.lever()
            way = np.where(lever.mean(axis=1) < 0.0, 0, 1)
            yield _Wall(flank, way, lever, t, low, high, some, on)

    def _fill(self, out: dict[str, Any], track: Track, phi: Floats, rows: Indices, place: Indices) -> None:
        delta = track.meridian.jet
        for flank, way, lever, t, low, high, some, on in self._beside(track, phi, 2):
            out["lever"][way, rows, place] = np.abs(lever)
            out["curvature"][way, rows, place] = flank.k_rel
            out["on"][way, rows, place] = on
            out["touches"][way, rows, place] = some
            out["cover"][way, rows, place] = np.where(some, np.abs(delta(high)[0] - delta(low)[0]), 0.0)
            out["place"][way, rows, place] = delta(t)[0]
            out["normal"][way, rows, place] = flank.normals
            out["angle"][way, rows, place] = flank.pressure_angle("axis")
            out["turning"][way, rows, place] = flank.turning

    @property
    def lever(self) -> Floats:
        """Speed of the contact along its normal per radian of the turret, mm, (2, n, k, m), > 0."""
        return np.asarray(self._walls["lever"])

    @property
    def curvature(self) -> Floats:
        """Relative curvature, 1/mm, (2, n, k, m)."""
        return np.asarray(self._walls["curvature"])

    @property
    def on(self) -> Bools:
        """Whether at least half of a slice has a wall to bear on, (2, n, k, m)."""
        return np.asarray(self._walls["on"])

    @property
    def touches(self) -> Bools:
        """Whether a slice has a wall to bear on, (2, n, k, m), also one without width."""
        return np.asarray(self._walls["touches"])

    @property
    def cover(self) -> Floats:
        """Length of every slice that has a wall to bear on, mm, (2, n, k, m)."""
        return np.asarray(self._walls["cover"])

    @property
    def place(self) -> Floats:
        """Middle of that length along the roller axis (delta), mm, (2, n, k, m)."""
        return np.asarray(self._walls["place"])

    @property
    def normal(self) -> Floats:
        """Unit normals from roller into cam, (2, n, k, m, 3)."""
        return np.asarray(self._walls["normal"])

    @cached_property
    def drive_angle(self) -> Floats:
        """Pressure angle at the axis of the best placed roller of each direction, at its worst slice, rad, (2, n)."""
        angle = np.where(self.on, self._walls["angle"], 0.0).max(axis=3)
        return np.asarray(np.where(self.on.any(axis=3), angle, 0.5 * np.pi).min(axis=2, initial=0.5 * np.pi))

    @property
    def turning(self) -> Floats:
        """Turning of a roller about its pin that rolls on each slice, rad/rad, (2, n, k, m), see `Flank.turning`."""
        return np.asarray(self._walls["turning"])

    @cached_property
    def carrying(self) -> Floats:
        """Rollers that have a wall in each direction, in whole rollers: sums of shares of contact length, (2, n)."""
        return np.asarray(self.on.mean(axis=3).sum(axis=2))

    @cached_property
    def count(self) -> npt.NDArray[np.intp]:
        """Number of rollers that touch a wall of each direction with any slice, (2, n)."""
        return np.asarray(self.on.any(axis=3).sum(axis=2))


@immutable
class Beside:
    """The rollers of a turret beside its cam, asked at several sets of cam angles: nothing is sought twice.

    graded: whether slices are finer in the middle of the rollers, else the ends count as slices too
    """

    tracks: tuple[Track, ...]
    within: Within
    graded: bool = False

    @cached_property
    def comings(self) -> tuple[Floats, Floats]:
        """Cam angles at which a roller, and its middle slice, comes to bear or ceases to, rad."""
        return comings(self.tracks, self.within)

    def at(self, theta: Floats, known: Engagement | None = None) -> Engagement:
        """The engagement at cam angles (n,), rad, in rising order, some of them those of one that is known."""
        for one in self._asked:
            if np.array_equal(one.theta, theta):
                return one
        self._asked.append(self.once(theta, known))
        return self._asked[-1]

    def once(self, theta: Floats, known: Engagement | None = None) -> Engagement:
        """The same, which is not kept."""
        return Engagement(self.tracks, self.within, theta, known, "graded" if self.graded else "ended")

    @cached_property
    def _asked(self) -> list[Engagement]:
        """Engagements that were asked for."""
        return []


def least_held(tracks: tuple[Track, ...], within: Within, samples: int = 361) -> tuple[Extreme, Extreme]:
    """Least number of rollers that have a wall to bear on, pushing on and holding back, over a turn.

    Between two cam angles at which other rollers hold the turret it is looked at ever finer, down to 1e-7 rad: there
    one may have left its wall before the next one comes.
    """
    theta = np.linspace(0.0, TURN, samples)
    best: list[Extreme] = []
    for number in range(HANDS):
        held = Engagement(tracks, within, theta).held
        for way, count in enumerate(held.sum(axis=2)):
            least = Extreme(float(count.min()), float(theta[count.argmin()]))
            if not number:
                best.append(least)
            elif least.value < best[way].value:
                best[way] = least
        other = np.logical_xor(held[:, 1:], held[:, :-1]).any(axis=(0, 2))
        changes = np.flatnonzero(other & (np.diff(theta) < 2.0 * TURN / samples))
        if not len(changes):
            break
        low, high = theta[changes], theta[changes + 1]
        theta = distinct(low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, FAN))
    return best[0], best[1]


def largest_drive_angle(tracks: tuple[Track, ...], within: Within, samples: int = 1441) -> Extreme:
    """Largest pressure angle, rad, at which the best placed roller has to drive or to hold.

    It jumps where a roller comes to bear or ceases to: both sides of these are looked at too.
    """
    events, step = np.concatenate(comings(tracks, within)), TURN / (samples - 1)
    theta = np.concatenate([np.linspace(0.0, TURN, samples), events - BESIDE, events + BESIDE])
    theta = distinct(theta[(theta >= 0.0) & (theta <= TURN)])
    value, at = 0.0, 0.0
    for _ in range(4):
        angle = Engagement(tracks, within, theta).drive_angle.max(axis=0)
        i = int(np.argmax(angle))
        if angle[i] >= value:
            value, at = float(angle[i]), float(theta[i])
        theta = np.linspace(max(0.0, at - step), min(TURN, at + step), 33)
        step /= 16.0
    return Extreme(value, at, where="best placed roller that carries")


@immutable(eq=True)
class Rib:
    """Thickness of a rib, mm, where it is thinnest: cam angle, rad, and distance from the turret axis, mm."""

    thickness: float
    cam_angle: float
    delta: float


def rib_thickness(track: Track, pitch: float, within: Within, delta: float, samples: int = 361) -> Rib | None:
    """Thinnest place, at one distance from the turret axis, of the rib between a track and the next roller's.

    pitch   angle between the rollers, rad; delta: mm
    Each point of either wall is measured against the other roller's body over the angles about its own; None where the
    two rollers are never beside the blank together.
    """
    # The groove is open towards the turret: its wall goes on beyond the contact stretch.
    low, high = sorted(track.contact)
    more = (2.0 * low - high, high) if track.tip_sign > 0.0 else (low, 2.0 * high - low)
    track = replace(track, contact=more)
    reach = float(np.abs(track.coordinate(np.array(track.span), 0)[0]).max())
    phi = np.linspace(*track.span, samples)
    best: Rib | None = None
    for sign in (1.0, -1.0):
        other = replace(track, shift=track.shift + sign * pitch)
        near = np.abs(other.coordinate(phi, 0)[0]) <= reach
        t = np.array([track.meridian.parameter(delta)])
        for side in track.sides:
            x = Flank(track, phi, t, side).x[:, :, 0]
            kept = near & (within(x) >= 0.0)
            if not kept.any():
                continue
            distance, i = _nearest(other, x[:, kept], phi[kept])
            if best is None or distance < best.thickness:
                best = Rib(distance, float(phi[kept][i]), delta)
    return best


@immutable(eq=True)
class Horn:
    """The longest stretch of a groove's outer wall whose foot has broken through an end face.

    turn       cam angle it takes, rad; cam_angle: its middle, rad
    narrower, wider   widths of the cam, mm, below which it is gone and above which its foot stands, there
    """

    turn: float
    cam_angle: float
    narrower: float
    wider: float


def longest_horn(cutter: Track, within: Within, half: float, wall: float, per_turn: int = 720) -> Horn | None:
    """The longest horn beside a groove, or None.

    half  half the cam's width, mm; wall: thickness that a foot needs, mm

    Where a groove runs out of an end face its outer wall ends in a wedge; in a dwell the same wedge is a hoop.
    Beside a ball there is none: its wall rises from the bottom outwards, square to the end face that cuts it there.
    """
    if Column(cutter, np.zeros(1)).ball_ended:
        return None
    phi = np.linspace(*cutter.span, int(per_turn * (cutter.span[1] - cutter.span[0]) / TURN) + 2)
    meridian, away = cutter.meridian, max(cutter.contact, key=lambda d: abs(d - cutter.tip))
    t = np.linspace(meridian.parameter(away), meridian.parameter(cutter.tip), 13)
    if isinstance(meridian, Arc):
        t = t[meridian.jet(t)[3] > 1e-3 * meridian.radius]
    best: Horn | None = None
    for side in cutter.sides:
        flank = Flank(cutter, phi, t, side)
        there, z = within(flank.x) >= 0.0, flank.x[2]
        hanging = there.any(axis=1) & (np.abs(z[:, -1]) > half - wall) & (z[:, -1] * flank.n[2][:, -1] > 0.0)
        edges = np.flatnonzero(np.diff(np.r_[0, hanging.astype(int), 0]))
        for i, j in edges.reshape(-1, 2):
            turn = float(phi[j - 1] - phi[i])
            if best is None or turn > best.turn:
                # One station above the first in the blank: outside, so that the width is on the safe side.
                top = np.abs(z[np.arange(i, j), np.maximum(np.argmax(there[i:j], axis=1) - 1, 0)])
                foot = _upper_median(np.abs(z[i:j, -1]))
                best = Horn(turn, float(0.5 * (phi[i] + phi[j - 1])), 2.0 * _upper_median(top), 2.0 * (foot + wall))
    return best


def _upper_median(values: Floats) -> float:
    """The middle value, of an even count the larger: numpy's own imports masked arrays, 20 ms, to look for NaN."""
    return float(np.sort(values)[len(values) // 2])


def play_at(tracks: tuple[Track, ...], cutters: tuple[Track, ...], within: Within, theta: float) -> float:
    """Least distance, mm, of the flanks that the cutters leave from the rollers standing at one cam angle (rad)."""
    near, least = np.linspace(-NEARBY, NEARBY, 401), np.inf
    for track, cutter in zip(tracks, cutters):
        low, high = track.span
        t = np.linspace(track.meridian.parameter(track.contact[0]), track.meridian.parameter(track.contact[1]), 9)
        for turn in range(floor(low / TURN) - 1, ceil(high / TURN) + 1):
            at = theta + TURN * turn
            if not low <= at <= high:
                continue
            for side in cutter.sides:
                x = Flank(cutter, at + near, t, side).x.reshape(3, -1)
                x = x[:, within(x) >= 0.0]
                distance = roller_distance(track, x, np.full(x.shape[1], at))
                least = min(least, float(distance.min(initial=np.inf)))
    return least


def _nearest(track: Track, x: Floats, phi: Floats, width: float = 0.6) -> tuple[float, int]:
    """Least distance, mm, of points (3, n) to a roller near cam angles phi (n,), and the number of the nearest point.
    """
    grid = np.linspace(-width, width, 25)
    value = roller_distance(track, x[:, :, None], phi[:, None] + grid)
    top = np.argmin(value, axis=1)
    coarse, beside = (np.take_along_axis(value, np.clip(top[:, None] + way, 0, len(grid) - 1), axis=1)
                      for way in ((0,), (-1, 1)))  # fmt: skip
    # Between two samples a distance is less than the nearer one by no more than its neighbours are more.
    hopeful = np.flatnonzero(2.0 * coarse[:, 0] - beside.max(axis=1) <= coarse.min())
    middle, step, x = (phi + grid[top])[hopeful], grid[1] - grid[0], x[:, hopeful]
    near, _ = bracketed_maximum(
        lambda at: -roller_distance(track, x[:, :, None], at), middle - step, middle + step, least=-np.inf
    )
    return float(-near.max()), int(hopeful[np.argmax(near)])
