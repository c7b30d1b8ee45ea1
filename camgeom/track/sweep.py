"""What the rollers of a turret leave of a disc on a shaft parallel to theirs: outlines of plate cams, exact.

Every roller sweeps a band about the path of its centre. The boundary of what is left runs along the bands' edges
(parallel curves of the paths at the roller's radius), from crossing to crossing, and along the rim of the blank. Which
pieces of the edges count is asked point by point: a point of an edge is on the boundary where no position of any roller
covers it. The ends of the pieces are crossings of two exact curves, found by Newton's method.
"""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import numpy.typing as npt

from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import piece_grid
from camgeom.maths.frozen import cached_property
from camgeom.track import TURN, Straight, Swing, Track
from camgeom.track.outline import Curve

Bools = npt.NDArray[np.bool_]

PER_TURN = 720
NEAR = 1e-6
"""share of the blank's radius within which ends of pieces are one point, before they are polished"""
COVERED = 1e-10
"""share of the blank's radius by which a roller must reach over a point to cover it"""
SAME = 10.0 * COVERED
"""share of a point's radius within which two edges run through it: ends are found where one covers the other"""
MINIMA, NEWTON = 3, 7
HALVINGS = 22
POLISHED = 1e-3
"""rad by which an end of an edge is moved at most where it is polished"""
MOST_TURN = 0.1
"""rad that a path turns by between neighbouring places at which its band's edges are looked at"""
BLOCK = 256


@immutable
class BandEdge:
    """A piece of a band's edge: the roller on `track` touches it with its `side` from cam angle `low` to `high`, rad.

    An edge is travelled with the material on the left: in the sense of the cam angle on side +1, against it on -1.
    """

    track: Track
    side: float
    low: float
    high: float

    @property
    def first(self) -> float:
        """Cam angle at which the travel begins."""
        return self.low if self.side > 0.0 else self.high

    @property
    def last(self) -> float:
        """Cam angle at which it ends."""
        return self.high if self.side > 0.0 else self.low

    def knots(self) -> Floats:
        """Cam angles in order of travel where a derivative may jump, both ends included, rad."""
        found = replace(self.track, span=(self.low, self.high)).knots()
        return found if self.side > 0.0 else np.asarray(found[::-1])

    def curve(self, phi: Floats) -> Curve:
        """Exact points, outward normals of the material, curvature, and length per radian of travel (positive)."""
        x, step, bend = _parallel(self.track, phi, self.side)
        # The parallel curve grows by the share 1 - side r bend of its path, which is positive on the boundary.
        pace = np.abs(step)
        tangent = self.side * step / pace
        growth = 1.0 - self.side * _radius(self.track) * bend
        normal = -1j * tangent
        return Curve(_plane(x), _plane(normal), self.side * bend / growth, pace * np.abs(growth))


@immutable
class RimArc:
    """A piece of the blank's circle from azimuth `low` to `high`, rad, counter-clockwise."""

    radius: float
    low: float
    high: float

    @property
    def first(self) -> float:
        """Azimuth at which the travel begins."""
        return self.low

    @property
    def last(self) -> float:
        """Azimuth at which it ends."""
        return self.high

    def knots(self) -> Floats:
        """Both ends, and places between that keep every part below a half turn."""
        return np.linspace(self.low, self.high, 2 + int((self.high - self.low) / 3.0))

    def curve(self, angle: Floats) -> Curve:
        """Points, normals and curvature at azimuths (n,)."""
        n = np.stack([np.cos(angle), np.sin(angle)])
        one = np.ones_like(angle)
        return Curve(self.radius * n, n, one / self.radius, self.radius * one)


@immutable
class ChainOutline:
    """A closed outline made of edges and rims, counter-clockwise; its parameter runs from 0 to 2 pi.

    Each part takes a share of the parameter by its length; inside it the parameter is linear in the part's own.
    """

    parts: tuple[BandEdge | RimArc, ...]

    @cached_property
    def _stretches(self) -> tuple[Floats, Floats, npt.NDArray[np.int64]]:
        """Parameter knots (k + 1,), own parameters at both ends of every stretch (k, 2), part of every stretch (k,)."""
        own, owner, lengths = [], [], []
        for i, part in enumerate(self.parts):
            knots = part.knots()
            for a, b in zip(knots[:-1], knots[1:]):
                speed = part.curve(np.linspace(a, b, 17)[1:-1]).speed
                own.append((a, b))
                owner.append(i)
                lengths.append(float(speed.mean()) * abs(b - a))
        share = np.concatenate([[0.0], np.cumsum(lengths)])
        return share * (TURN / share[-1]), np.array(own), np.array(owner)

    def knots(self) -> Floats:
        """Parameters from 0 to 2 pi where a derivative may jump."""
        return self._stretches[0]

    def curve(self, phi: Floats) -> Curve:
        """Exact points, normals and curvature; at a corner those of the part that begins there."""
        knots, own, owner = self._stretches
        phi = np.asarray(phi, dtype=float)
        u = np.where(phi < TURN, phi, phi - TURN)
        at = np.clip(np.searchsorted(knots, u, side="right") - 1, 0, len(owner) - 1)
        rate = (own[at, 1] - own[at, 0]) / (knots[at + 1] - knots[at])
        t = own[at, 0] + (u - knots[at]) * rate
        points, normals = np.empty((2, len(u))), np.empty((2, len(u)))
        curvature, speed = np.empty(len(u)), np.empty(len(u))
        for i, part in enumerate(self.parts):
            mine = owner[at] == i
            if mine.any():
                one = part.curve(t[mine])
                points[:, mine], normals[:, mine] = one.points, one.normals
                curvature[mine], speed[mine] = one.curvature, one.speed * np.abs(rate[mine])
        return Curve(points, normals, curvature, speed)


@immutable
class RollerSweep:
    """A blank of `radius` about the cam axis less the bands of rollers whose axes are parallel to it.

    tracks  whole passages (cylindrical rollers), each from beyond the blank to beyond it
    """

    tracks: tuple[Track, ...]
    radius: float

    @cached_property
    def _samples(self) -> tuple[tuple[Floats, npt.NDArray[np.int64]], ...]:
        return tuple(piece_grid(track.knots(), PER_TURN) for track in self.tracks)

    @cached_property
    def _paths(self) -> tuple[npt.NDArray[np.complex128], ...]:
        return tuple(_centre(track, phi, 0)[0] for track, (phi, _) in zip(self.tracks, self._samples))

    def cover(self, x: npt.NDArray[np.complex128]) -> Floats:
        """By how much the nearest roller reaches over points x (n,), mm; negative where every roller stays away."""
        least = np.full(len(x), np.inf)
        for track, (phi, _), path in zip(self.tracks, self._samples, self._paths):
            for begin in range(0, len(x), BLOCK):
                part = slice(begin, begin + BLOCK)
                least[part] = np.minimum(least[part], _nearest(track, phi, path, x[part]))
        return np.asarray(_radius(self.tracks[0]) - least)

    def _open(self, track: Track, side: float, phi: Floats) -> Bools:
        """Whether edge points are on the boundary: in the blank, and covered by no roller.

        Most covered points lie under one of the sampled positions already; the others are asked exactly.
        """
        x, _, _ = _parallel(track, phi, side)
        found = np.abs(x) <= self.radius
        allowed = COVERED * self.radius
        reach = (_radius(track) - allowed) ** 2
        for path in self._paths:
            for begin in range(0, len(x), BLOCK):
                rows = begin + np.flatnonzero(found[begin : begin + BLOCK])
                dx, dy = x.real[rows, None] - path.real, x.imag[rows, None] - path.imag
                found[rows] = (dx * dx + dy * dy).min(axis=1, initial=np.inf) >= reach
        found[found] = self.cover(x[found]) <= allowed
        return np.asarray(found)

    @cached_property
    def edges(self) -> tuple[BandEdge, ...]:
        """All pieces of the bands' edges on the boundary of what is left, ends polished."""
        found: list[BandEdge] = []
        for track, (phi, _) in zip(self.tracks, self._samples):
            fine = _turning_little(track, phi)
            for side in (1.0, -1.0):
                found += self._pieces(track, side, fine)
        return self._polished(found)

    def _pieces(self, track: Track, side: float, phi: Floats) -> list[BandEdge]:
        on = self._open(track, side, phi)
        change = np.flatnonzero(on[1:] != on[:-1])
        a, b, rising = phi[change], phi[change + 1], on[change + 1]
        for _ in range(HALVINGS):
            middle = 0.5 * (a + b)
            after = self._open(track, side, middle) == rising
            a, b = np.where(after, a, middle), np.where(after, middle, b)
        ends = np.where(rising, b, a)
        starts = ends[rising] if not on[0] else np.r_[phi[0], ends[rising]]
        stops = ends[~rising] if not on[-1] else np.r_[ends[~rising], phi[-1]]
        return [BandEdge(track, side, float(low), float(high)) for low, high in zip(starts, stops) if high > low]

    def _polished(self, found: list[BandEdge]) -> tuple[BandEdge, ...]:
        """The pieces with their ends moved onto the exact crossing with the rim or with another piece."""
        ends = [[edge.low, edge.high] for edge in found]
        near = NEAR * self.radius
        places = [(i, k) for i in range(len(found)) for k in (0, 1)]
        begins = [(k == 0) == (found[i].side > 0.0) for i, k in places]
        x = np.array([_parallel(found[i].track, np.array([ends[i][k]]), found[i].side)[0][0] for i, k in places])
        done: set[tuple[int, int]] = set()
        for p, (i, k) in enumerate(places):
            if (i, k) in done:
                continue
            if abs(abs(x[p]) - self.radius) < near:
                ends[i][k] = _on_rim(found[i], ends[i][k], self.radius)
                continue
            # The travel of one ends where that of the other begins.
            others = [q for q in range(len(places)) if begins[q] != begins[p] and abs(x[q] - x[p]) < near]
            if others:
                j, m = places[min(others, key=lambda q: abs(x[q] - x[p]))]
                ends[i][k], ends[j][m] = _crossed(found[i], ends[i][k], found[j], ends[j][m])
                done.add((j, m))
        return tuple(replace(edge, low=low, high=high) for edge, (low, high) in zip(found, ends))

    @cached_property
    def _starts(self) -> Floats:
        """Points at which the travel of every edge begins, (n, 2)."""
        return np.array([edge.curve(np.array([edge.first])).points[:, 0] for edge in self.edges]).reshape(-1, 2)

    @property
    def chain(self) -> tuple[BandEdge | RimArc, ...]:
        """The boundary of the piece that holds the shaft, counter-clockwise.

        Raises DesignError where the rollers leave no closed piece about the shaft.
        """
        return tuple(part for _, part in self._chain)

    @cached_property
    def _chain(self) -> tuple[tuple[int, BandEdge | RimArc], ...]:
        """The parts of the chain, each with the number of the edge it is cut from (-1: the rim)."""
        left, loose = set(range(len(self.edges))), ""
        while left:
            i, joints = min(left), dict[int, _Joint]()
            while i in left:
                left.discard(i)
                joint = self._next(i)
                if joint is None:
                    x, y = self.edges[i].curve(np.array([self.edges[i].last])).points[:, 0]
                    loose = f"; the edge of a roller's band ends at x = {x:.6g}, y = {y:.6g} mm where no other begins"
                    break
                joints[i] = joint
                i = joint.edge
            if i in joints:
                parts = self._cut(joints, i)
                if _winding([part for _, part in parts]) == 1:
                    return tuple(parts)
        raise DesignError(
            "the rollers leave no plate about the shaft: they cut through it, or never reach it; change the centre "
            f"distance, the pitch radius or the plate's diameter{loose}"
        )

    def _cut(self, joints: dict[int, _Joint], begin: int) -> list[tuple[int, BandEdge | RimArc]]:
        """The parts of one closed chain, each edge from the joint behind to the joint ahead."""
        order = [begin]
        while joints[order[-1]].edge != begin:
            order.append(joints[order[-1]].edge)
        parts: list[tuple[int, BandEdge | RimArc]] = []
        for before, i in zip([order[-1], *order], order):
            ends = sorted((joints[before].first, joints[i].last))
            parts.append((i, replace(self.edges[i], low=ends[0], high=ends[1])))
            rim = joints[i].rim
            parts += [] if rim is None else [(-1, rim)]
        return parts

    def _next(self, i: int) -> _Joint | None:
        """The joint at the end of an edge: along the rim, where another begins, or in the middle of what they share."""
        edge = self.edges[i]
        end = edge.curve(np.array([edge.last])).points[:, 0]
        near = NEAR * self.radius
        if abs(np.hypot(*end) - self.radius) < near:
            azimuth = np.arctan2(self._starts[:, 1], self._starts[:, 0]) - np.arctan2(end[1], end[0])
            ahead = np.where(np.abs(np.hypot(*self._starts.T) - self.radius) < near, azimuth % TURN, np.inf)
            j = int(np.argmin(ahead))
            if not np.isfinite(ahead[j]):
                return None  # no edge begins on the rim
            low = float(np.arctan2(end[1], end[0]))
            return _Joint(j, edge.last, self.edges[j].first, RimArc(self.radius, low, low + float(ahead[j])))
        gap = np.hypot(*(self._starts - end).T)
        j = int(np.argmin(gap))
        return _Joint(j, edge.last, self.edges[j].first) if gap[j] <= near else self._shared(i)

    def _shared(self, i: int) -> _Joint | None:
        """The joint in the middle of the stretch that edge i shares with the one that runs on farthest from its end.

        In a dwell two rollers that stand symmetrically about the line of centres sweep one circle about the cam's axis,
        and the edges of their bands are one curve there; where their dwells just meet they touch without crossing.
        """
        edge = self.edges[i]
        best, farthest = None, NEAR
        for j, other in enumerate(self.edges):
            for at in _places(other, edge, edge.last):
                begun = [x for x in _places(edge, other, other.first) if i != j or abs(x - edge.first) > NEAR]
                if not begun or abs(other.last - at) <= farthest:
                    continue
                last = 0.5 * (begun[-1] + edge.last)
                x = _rate(edge, last)[0]
                first = _foot(other, 0.5 * (other.first + at), x)
                if abs(_rate(other, first)[0] - x) <= SAME * self.radius:
                    best, farthest = _Joint(j, last, first), abs(other.last - at)
        return best

    @property
    def outline(self) -> ChainOutline:
        """The plate's outline."""
        return ChainOutline(self.chain)

    @cached_property
    def contacts(self) -> tuple[Track, ...]:
        """One track a wall of the plate: the roller that touches it, over all the cam angles at which it does.

        A stretch that two rollers share is a wall of both.
        """
        walls = {i: part for i, part in self._chain if isinstance(part, BandEdge)}
        for i, edge in enumerate(self.edges):
            middle = 0.5 * (edge.low + edge.high)
            if i not in walls and any(_places(part, edge, middle) for part in list(walls.values())):
                walls[i] = edge
        chosen = (self.edges[i] for i in walls)
        return tuple(replace(wall.track, span=(wall.low, wall.high), sides=(wall.side,)) for wall in chosen)


@immutable(eq=True)
class _Joint:
    """Where the boundary passes to another edge: its number, both cam angles, and the rim it goes along in between."""

    edge: int
    last: float
    first: float
    rim: RimArc | None = None


def _radius(track: Track) -> float:
    assert isinstance(track.meridian, Straight)
    return track.meridian.radius


def _centre(track: Track, phi: Floats, order: int) -> npt.NDArray[np.complex128]:
    """Jet of the roller's centre in the cam's plane, (order + 1, n), order 0 to 2, mm.

    With C the turret's axis and A the roller from there at joint coordinate zero, turned by way tau and seen from a cam
    turned by sense phi: z = C exp(-i sense phi) + A exp(i (way tau - sense phi)).
    """
    joint = track.joint
    assert isinstance(joint, Swing)
    way, sense, pivot = joint.axis[2], track.sense, complex(joint.centre[0], joint.centre[1])
    tau = way * track.coordinate(phi, order)
    still = pivot * np.exp(-1j * sense * phi)
    arm = (complex(track.anchor[0], track.anchor[1]) - pivot) * np.exp(1j * (tau[0] - sense * phi))
    found = [still + arm]
    if order > 0:
        found.append(-1j * sense * still + 1j * (tau[1] - sense) * arm)
    if order > 1:
        found.append(-still + (1j * tau[2] - (tau[1] - sense) ** 2) * arm)
    return np.array(found)


def _parallel(
    track: Track, phi: Floats, side: float
) -> tuple[npt.NDArray[np.complex128], npt.NDArray[np.complex128], Floats]:
    """Points on one edge of the band, the path's derivative, and the path's curvature (left positive), at phi (n,)."""
    c, d, dd = _centre(track, phi, 2)
    pace = np.abs(d)
    if np.any(pace <= 1e-12 * np.abs(c)):
        raise DesignError("the roller stands still in the cam there: its path has no direction; change the motion")
    return c + side * _radius(track) * 1j * d / pace, d, (np.conj(d) * dd).imag / pace**3


def _turning_little(track: Track, phi: Floats) -> Floats:
    """Cam angles (n,) with more between those where the path turns sharply.

    Where a roller almost stands still in the cam its path turns back on the spot, and its whole end, half round it, is
    touched within a thousandth of a degree.
    """
    for _ in range(HALVINGS):
        d = _centre(track, phi, 1)[1]
        sharp = np.abs(np.angle(d[1:] * np.conj(d[:-1]))) > MOST_TURN
        if not sharp.any():
            break
        phi = np.sort(np.concatenate([phi, 0.5 * (phi[1:] + phi[:-1])[sharp]]))
    return phi


def _plane(z: npt.NDArray[np.complex128]) -> Floats:
    return np.stack([z.real, z.imag])


def _nearest(track: Track, phi: Floats, path: npt.NDArray[np.complex128], x: npt.NDArray[np.complex128]) -> Floats:
    """Least distance (n,) of points from a path: the best samples, each refined by Newton's method."""
    gap = np.hypot(x.real[:, None] - path.real, x.imag[:, None] - path.imag)
    ahead = np.concatenate([gap[:, 1:], gap[:, -1:] + 1.0], axis=1)
    behind = np.concatenate([gap[:, :1] + 1.0, gap[:, :-1]], axis=1)
    least = np.where((gap <= ahead) & (gap <= behind), gap, np.inf)
    take = min(MINIMA, least.shape[1])
    picked = np.argpartition(least, take - 1, axis=1)[:, :take]
    at = phi[picked]
    step = TURN / PER_TURN
    low, high = np.maximum(at - step, phi[0]), np.minimum(at + step, phi[-1])
    for _ in range(NEWTON):
        c, d, dd = (row.reshape(at.shape) for row in _centre(track, at.ravel(), 2))
        off = x[:, None] - c
        slope = -(np.conj(d) * off).real
        bend = np.abs(d) ** 2 - (np.conj(dd) * off).real
        # Where the acceleration jumps, or a path bends sharper than the roller, Newton's step may leave the minimum.
        low, high = np.where(slope <= 0.0, at, low), np.where(slope > 0.0, at, high)
        fresh = at - slope / np.where(bend > 0.0, bend, np.inf)
        inside = (bend > 0.0) & (fresh >= low) & (fresh <= high)
        at = np.where(inside, fresh, np.where(slope == 0.0, at, 0.5 * (low + high)))
    fine = np.abs(x[:, None] - _centre(track, at.ravel(), 0)[0].reshape(at.shape))
    return np.asarray(np.minimum(fine.min(axis=1), gap.min(axis=1)))


def _rate(edge: BandEdge, phi: float) -> tuple[complex, complex]:
    """Point of an edge and its derivative by the cam angle."""
    x, d, bend = _parallel(edge.track, np.array([phi]), edge.side)
    return complex(x[0]), complex(d[0] * (1.0 - edge.side * _radius(edge.track) * bend[0]))


def _on_rim(edge: BandEdge, phi: float, radius: float) -> float:
    """Cam angle at which an edge meets the rim, by Newton's method from one close by; as given where it runs along."""
    at = phi
    for _ in range(4):
        x, d = _rate(edge, at)
        slope = (x.conjugate() * d).real / abs(x)
        at -= (abs(x) - radius) / slope if slope else 0.0
    return at if abs(at - phi) < POLISHED else phi


def _crossed(one: BandEdge, phi: float, two: BandEdge, psi: float) -> tuple[float, float]:
    """Cam angles at which two edges cross, by Newton's method; as given where they touch without crossing."""
    a, b = phi, psi
    for _ in range(6):
        x, d = _rate(one, a)
        y, e = _rate(two, b)
        det = -(d.real * e.imag - d.imag * e.real)
        if abs(det) <= 1e-6 * abs(d) * abs(e):
            return phi, psi
        miss = y - x
        a += (-(miss.real * e.imag - miss.imag * e.real)) / det
        b += (-(miss.real * d.imag - miss.imag * d.real)) / det
    return (a, b) if abs(a - phi) < POLISHED and abs(b - psi) < POLISHED else (phi, psi)


def _foot(edge: BandEdge, phi: float, x: complex) -> float:
    """Cam angle at which an edge, produced where need be, is nearest to a point beside it, from one close by."""
    for _ in range(8):
        y, d = _rate(edge, phi)
        step = (d.conjugate() * (x - y)).real / abs(d) ** 2 if d else 0.0
        phi += step
    return phi


def _places(edge: BandEdge, other: BandEdge, psi: float) -> list[float]:
    """Cam angles, in order of travel, at which an edge runs through a point of another one and in the same sense."""
    x, d = _rate(other, psi)
    way, near = other.side * d / abs(d), SAME * abs(x)
    phi, _ = piece_grid(np.sort(edge.knots()), PER_TURN)
    gap = np.abs(_parallel(edge.track, phi, edge.side)[0] - x)
    padded = np.concatenate([[np.inf], gap, [np.inf]])
    found: set[float] = set()
    for k in np.flatnonzero((gap <= padded[:-2]) & (gap <= padded[2:])):
        at = min(max(_foot(edge, float(phi[k]), x), edge.low), edge.high)
        y, e = _rate(edge, at)
        if abs(y - x) <= near and edge.side * (way.conjugate() * e).real > 0.5 * abs(e):
            found.add(at)
    return sorted(found, reverse=edge.side < 0.0)


def _winding(parts: list[BandEdge | RimArc]) -> int:
    """How often a chain runs round the cam axis."""
    angles = []
    for part in parts:
        x = part.curve(np.linspace(part.first, part.last, 65)).points
        angles.append(np.angle(x[0] + 1j * x[1]))
    turning = np.angle(np.exp(1j * np.diff(np.concatenate([*angles, angles[0][:1]]))))
    return round(float(turning.sum()) / (2.0 * pi))
