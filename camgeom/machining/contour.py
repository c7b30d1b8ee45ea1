"""Tool paths round the profile of a planar cam: the parallel curve at the tool's radius, never into the profile."""

from __future__ import annotations

from dataclasses import replace
from math import degrees, inf
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.machining.path import Positions, round_from
from camgeom.machining.plan import SHARE
from camgeom.machining.spec import LEAST
from camgeom.maths import Floats, distinct
from camgeom.maths.extremum import bracketed_maximum, piece_grid, refined_maximum
from camgeom.maths.frozen import cached_property
from camgeom.track import TURN, Track
from camgeom.track.outline import Curve, Outline, ParallelOutline, crossing

PER_TURN = 1440
CORNER = 1e-6
"""rad; a normal that turns by less at a knot makes no corner"""
HALVINGS = 12
FOLLOWED = 0.02
"""share of its radius between the places at which a tool is held against the profile"""
REFINED = 24
"""blocks, the deepest ones, whose depth is taken from the outline itself"""
TOUCHING = 1e-6
"""mm; where an arc meets the path the tool touches the profile"""
BESIDE = 1e-9
"""share of a piece by which one-sided values are taken beside its ends"""


@final
@immutable
class Corners:
    """Corners of an outline, where a tool rolls round a point: each takes a stretch of the path's parameter.

    phi    (k,) cam angles, in (0, 2 pi]
    angle  (k,) azimuth of the outward normal before, rad
    turn   (k,) by how much it turns there, rad
    """

    phi: Floats
    angle: Floats
    turn: Floats

    @classmethod
    def of(cls, outline: Outline) -> Corners:
        """The corners of an outline."""
        knots = outline.knots()
        width = np.diff(knots)
        before, after = outline.curve(knots[1:] - BESIDE * width), outline.curve(knots[:-1] + BESIDE * width)
        n0 = before.normals[0] + 1j * before.normals[1]
        n1 = np.roll(after.normals[0] + 1j * after.normals[1], -1)
        turn = np.angle(n1 * np.conj(n0))
        sharp = np.abs(turn) > CORNER
        return cls(knots[1:][sharp], np.angle(n0[sharp]), turn[sharp])

    @property
    def length(self) -> float:
        """Parameter of the whole turn: its cam angle and that of all corners."""
        return TURN + float(np.abs(self.turn).sum())

    @cached_property
    def _starts(self) -> Floats:
        """Parameters (k,) at which corners begin."""
        return np.asarray(self.phi + np.cumsum(np.abs(self.turn)) - np.abs(self.turn))

    def parameter(self, phi: float) -> float:
        """The parameter of a cam angle in [0, 2 pi)."""
        return phi + float(np.abs(self.turn)[self.phi <= phi].sum())

    def knots(self, phi: Floats) -> Floats:
        """Parameters of an outline's knots (cam angles), the two ends of every corner among them."""
        plain = [self.parameter(float(p)) for p in phi[:-1]]
        return distinct(np.concatenate([plain, self._starts, self._starts + np.abs(self.turn), [0.0, self.length]]))

    def resolve(self, p: Floats) -> tuple[Floats, Floats, Floats]:
        """Cam angle, number of the corner (-1: none) and share of it, each (n,), at parameters p (n,)."""
        if not len(self.phi):
            return p, np.full(p.shape, -1), np.zeros_like(p)
        turns = np.floor(p / self.length)
        p = p - turns * self.length
        passed = np.searchsorted(self._starts, p, side="right")
        width = np.concatenate([[0.0], np.cumsum(np.abs(self.turn))])
        last = np.maximum(passed - 1, 0)
        share = (p - self._starts[last]) / np.abs(self.turn)[last]
        inside = (passed > 0) & (share <= 1.0 + BESIDE)
        phi = np.where(inside, self.phi[last], p - width[passed]) + TURN * turns
        return phi, np.where(inside, last, -1), np.where(inside, np.minimum(share, 1.0), 0.0)


@final
@immutable
class ContourPath:
    """A tool with its axis along Z round an outline.

    material  +1 where the material is inside the outline, -1 outside
    reach     mm, from the tool's axis to the outline: its radius and the stock
    low       mm, height of the tool's end
    height    mm, of the tool in the cut
    room      mm, how far the tool may move off the outline; None: as far as one likes
    other     a second outline that the tool touches at the same time, on its other side
    width     mm, of the groove between whose walls the tool runs; endless outside of one
    up        +1 where the spindle is above, -1 below: then `low` is the height of the tool's end all the same

    Its parameter is the cam angle, and goes on at corners of the outline while the tool rolls round them.
    """

    name: str
    outline: Outline
    material: float
    reach: float
    low: float
    height: float
    room: float | None = None
    start: float = 0.0
    other: Outline | None = None
    up: float = 1.0
    width: float = inf

    @property
    def closed(self) -> bool:
        """A profile always is."""
        return True

    @property
    def below(self) -> bool:
        """Whether it is in the lower face."""
        return self.up < 0.0

    @property
    def between(self) -> bool:
        """Whether it is in a groove."""
        return self.width < inf

    def follows(self, track: Track) -> bool:
        """It follows an outline."""
        del track
        return False

    def knots(self) -> Floats:
        """Parameters between which it is smooth."""
        knots, begin = self.corners.knots(self.outline.knots()), self.corners.parameter(self.start % TURN)
        return round_from(knots, begin, self.corners.length) if begin else knots

    @cached_property
    def corners(self) -> Corners:
        """Corners of the outline."""
        return Corners.of(self.outline)

    def _curve(self, p: Floats) -> tuple[Floats, Curve]:
        """Cam angles and the outline at parameters (n,)."""
        phi, corner, share = self.corners.resolve(p)
        # Behind a corner at the end of the turn the outline begins anew.
        place = np.where(phi >= TURN, phi - TURN, phi)
        if not np.any(corner >= 0):
            return phi, self.outline.curve(place)
        at = np.maximum(corner, 0)
        inside = corner >= 0
        # A corner's point is the piece's before it; its normal turns from one piece's to the other's.
        curve = self.outline.curve(np.where(inside, self.corners.phi[at] * (1.0 - BESIDE), place))
        angle = self.corners.angle[at] + share * self.corners.turn[at]
        normals = np.where(inside, np.stack([np.cos(angle), np.sin(angle)]), curve.normals)
        return phi, Curve(curve.points, normals, curve.curvature, curve.speed)

    def at(self, phi: Floats) -> Positions:
        """Positions at parameters (n,)."""
        phi, curve = self._curve(np.asarray(phi, dtype=float))
        zero, one = np.zeros_like(phi), np.ones_like(phi)
        normal = -self.material * curve.normals
        tip = curve.points - self.reach * normal
        way = np.sign(curve.speed) * np.stack([-curve.normals[1], curve.normals[0]])
        axis = np.stack([zero, zero, self.up * one])
        middle = np.full_like(phi, self.low + 0.5 * self.up * self.height)
        contacts, into = [np.stack([*curve.points, middle])], [np.stack([*normal, zero])]
        if self.other is not None:
            far = self.other.curve(phi)
            contacts.append(np.stack([*far.points, middle]))
            into.append(np.stack([*(self.material * far.normals), zero]))
        ends, travel = np.stack([*tip, np.full_like(phi, self.low)]), np.stack([*way, zero])
        return Positions(phi, ends, axis, np.stack(contacts), np.stack(into), travel, axis)

    def refuse_gouge(self) -> None:
        """Raise DesignError where the tool is too large for a hollow, or its path crosses itself."""
        inner = self.corners.turn * self.material < 0.0
        if np.any(inner):
            at = degrees(float(self.corners.phi[inner][0])) % 360.0
            raise DesignError(f"{self.name}: no round tool goes into the inner corner at cam angle {at:.6g} deg")
        sharpest, at = self._sharpest_hollow
        if sharpest * self.reach >= 1.0:
            raise DesignError(
                f"{self.name}: a tool of {2.0 * self.reach:.6g} mm (with its stock) does not go into the hollow at cam "
                f"angle {degrees(at) % 360.0:.6g} deg; at most {2.0 / sharpest:.6g} mm"
            )
        met = crossing(ParallelOutline(self.outline, self.material * self.reach))
        if met is not None:
            raise DesignError(
                f"{self.name}: a tool of {2.0 * self.reach:.6g} mm (with its stock) at cam angle "
                f"{degrees(met.first) % 360.0:.6g} deg cuts into the profile at {degrees(met.second) % 360.0:.6g} deg; "
                "use a smaller one"
            )

    def largest_diameter(self) -> float:
        """Largest tool, with its stock, that goes into every hollow and between both walls, mm; endless round a bulge.
        """
        sharpest = self._sharpest_hollow[0]
        return min(self.width, 2.0 / sharpest if sharpest > 0.0 else inf)

    @cached_property
    def _sharpest_hollow(self) -> tuple[float, float]:
        """Largest curvature of the profile towards the tool, 1/mm (negative without a hollow), and its cam angle."""
        phi, owner = piece_grid(self.outline.knots(), PER_TURN)

        def hollow(x: Floats) -> Floats:
            return np.asarray(-self.material * self.outline.curve(x).curvature)

        return refined_maximum(hollow, phi, owner, hollow(phi))

    def cut(self, places: Floats, radius: float) -> tuple[float, int]:
        """How deep a tool that goes straight from place to place (2, n) cuts into the profile at most, mm (negative: it
        stays off by that), and before which of them.

        Looked for in steps of FOLLOWED on arcs between the outline's samples; where it is deepest, on the outline.
        """
        from scipy.spatial import cKDTree

        ways = np.diff(places)
        # Even numbers of steps: a chord is deepest at its middle.
        parts = 2 * np.maximum(1, np.ceil(np.hypot(*ways) / (2.0 * FOLLOWED * radius))).astype(np.intp)
        owner = np.repeat(np.arange(len(parts)), parts)
        share = (np.arange(len(owner)) - (np.cumsum(parts) - parts)[owner]) / parts[owner]
        x = places[:, owner] + share * ways[:, owner]
        found = (-inf, 0)
        for outline in (self.outline, self.other):
            if outline is None:
                continue
            phi, piece = piece_grid(outline.knots(), PER_TURN)
            arcs = _Arcs(outline.curve(phi), piece)
            near = np.asarray(cKDTree(arcs.curve.points.T).query(x.T)[1])
            off = arcs.distance(x, near)
            begin = np.cumsum(parts) - parts
            blocks = np.argsort(np.minimum.reduceat(off, begin))[:REFINED]
            at = [begin[i] + int(np.argmin(off[begin[i] : begin[i] + parts[i]])) for i in blocks]
            value, block = _nearest(outline, places, blocks, phi[near[at]])
            found = max(found, (radius - value, block + 1))
        return found

    def with_lead(self, wanted: float | None, radius: float) -> ContourPath:
        """The path with room for an arc in and out that stays off the profile.

        wanted  mm; None: the tool's radius, or what fits of it. Raises DesignError where the wanted arc does not fit.
        """
        if self.room is not None:
            return self
        arc = radius if wanted is None else wanted
        phi, _ = piece_grid(self.outline.knots(), 4 * PER_TURN)
        points = self.outline.curve(phi).points
        for _ in range(HALVINGS):
            if arc <= LEAST or self._clear(arc, points):
                return replace(self, room=arc / SHARE)
            if wanted is not None:
                raise DesignError(f"{self.name}: cutter.lead {wanted:g} mm cuts into the profile; use a smaller one")
            arc *= 0.5
        return replace(self, room=0.0)

    def _clear(self, arc: float, points: Floats) -> bool:
        """Whether quarter circles in and out at the path's start keep the tool off the profile's points (2, n)."""
        at = self.at(self.knots()[:1])
        angle = np.linspace(0.0, 0.5 * np.pi, 33)
        for way in (-1.0, 1.0):
            off = way * np.sin(angle) * at.travel[:2] - (1.0 - np.cos(angle)) * at.normals[0, :2]
            centres = at.tip[:2] + arc * off
            least = min(float(np.hypot(*(points - c[:, None])).min()) for c in centres.T)
            if least < self.reach - TOUCHING:
                return False
        return True


@final
@immutable
class _Arcs:
    """A closed outline between its samples (n,), whose smooth pieces are numbered: arcs of the curvature there."""

    curve: Curve
    piece: npt.NDArray[np.int64]

    def distance(self, x: Floats, near: npt.NDArray[np.intp]) -> Floats:
        """Distance (m,), mm, of points (2, m) from the arcs on either side of the samples next to them (m,)."""
        first = np.flatnonzero(self.piece[1:] == self.piece[:-1])
        low, way = self.curve.points[:, first], self.curve.points[:, first + 1] - self.curve.points[:, first]
        square = np.maximum((way * way).sum(axis=0), 1e-300)
        bend = self.curve.curvature[first], self.curve.curvature[first + 1]
        outward = self.curve.normals[:, first]
        after = (near - self.piece[near]) % len(first)
        off = np.full(x.shape[1], inf)
        for arc in (after - 1, after):
            to = x - low[:, arc]
            along = np.clip((way[:, arc] * to).sum(axis=0) / square[arc], 0.0, 1.0)
            # Of a curvature that changes evenly along the arc.
            mean = (bend[0][arc] * (2.0 - along) + bend[1][arc] * (1.0 + along)) / 3.0
            bulge = 0.5 * square[arc] * along * (1.0 - along) * mean
            side = np.where((to * outward[:, arc]).sum(axis=0) > 0.0, 1.0, -1.0)
            off = np.minimum(off, np.hypot(*(to - along * way[:, arc])) - side * bulge)
        return off


def _nearest(outline: Outline, places: Floats, blocks: npt.NDArray[np.intp], phi: Floats) -> tuple[float, int]:
    """Least distance, mm, of straight ways from an outline, and which way that is.

    blocks  (k,) numbers of the ways, from place to place (2, n); phi: (k,) of the samples that they come nearest to
    """
    begin, way = places[:, blocks, None], (places[:, blocks + 1] - places[:, blocks])[..., None]
    square = np.maximum((way * way).sum(axis=0), 1e-300)

    def inside(at: Floats) -> Floats:
        to = outline.curve(np.mod(at, TURN).ravel()).points.reshape(2, *at.shape) - begin
        along = np.clip((to * way).sum(axis=0) / square, 0.0, 1.0)
        return np.asarray(-np.hypot(*(to - along * way)))

    step = TURN / PER_TURN
    found, _ = bracketed_maximum(inside, phi - step, phi + step, least=-inf)
    best = int(np.argmax(found))
    return -float(found[best]), int(blocks[best])
