"""Clearance between a finished mesh and its follower over the whole turn: a second look without the envelope.

Each vertex of the mesh is measured against the roller body (meridian and flat end) at the cam angles at which the
roller can be near it, and the least signed distance is refined; what slides measures itself (`track.sliding`).
Vertices lie on the true surface, so a facet between them can stand in the follower's way, or back from it, by no more
than the chord error besides.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.extremum import FAN, ROUNDS, SAME, Extreme, bracketed_maximum, narrowed, piece_grid
from camgeom.maths.mesh import Mesh
from camgeom.track import TURN, Arc, Meridian, Straight, Track
from camgeom.track.column import Column, Level

if TYPE_CHECKING:
    from camgeom.track.sliding import Slider

SAMPLES = 15
SECANTS = 5
SHORT = 1e-5
"""share of a step of the samples; a secant step as short is the last"""


@immutable(eq=True)
class Clearance:
    """Signed distance of a follower (`where`) from the mesh, mm (negative: penetration), with cam angle and point."""

    value: float
    cam_angle: float
    point: tuple[float, float, float]
    where: str = ""

    @classmethod
    def at(cls, value: float, cam_angle: float, point: Floats, where: str = "") -> Clearance:
        """Of a point (3,)."""
        return cls(float(value), float(cam_angle), (float(point[0]), float(point[1]), float(point[2])), where)


def least_clearance(track: Track, points: Floats, slack: Floats | None = None, grow: float = 0.0) -> Clearance:
    """Least distance of the points (v, 3) from the roller (enlarged by `grow` mm, normal) over its whole motion.

    slack  (v,) by how much a point may stand proud of the true surface, mm; it is added to the point's distance

    Points farther from the roller than its radius do not count; where all are, the distance is infinite at angle 0.
    """
    track, own = track.grown(grow).evenly, track
    radius = _largest_radius(track)
    for share in NEARNESS:
        found = _least_within(track, points, slack, (1.0 + share) * radius)
        # What lies outside the window is farther away than its excess over the roller.
        if found.value <= share * radius:
            break
    return replace(found, where=track.name, cam_angle=own.drive_angle(found.cam_angle))


def edge_clearance(track: Track, tool: Track, grow: float = 0.0) -> Clearance:
    """Distance of the edge of a roller's end (the roller larger by `grow` mm) from the root that a tool's corner cuts.

    The tool's torus touches its root all round a quarter circle, wherever it stands: what stands out of the torus
    there collides. Infinite where the edge stays below no part of the torus.
    """
    start = np.array([tool.span[0]])
    radii = [float(one.meridian.jet(np.array([one.meridian.parameter(d)]))[3][0])
             for one, d in ((tool, tool.foot), (track, track.tip))]  # fmt: skip
    aside, over = radii[0] - radii[1] - grow, tool.tip_sign * (tool.tip - track.tip) - grow
    point = Column(tool, start).wall(tool.sides[0], np.array([tool.meridian.parameter(tool.foot)]))[:, 0, 0]
    met = max(aside, over) < tool.root
    value = tool.root - float(np.hypot(tool.root - aside, tool.root - over)) if met else float("inf")
    return Clearance.at(value, start[0], point, f"{track.name}, the roller's edge")


def least_beside(slider: Slider, points: Floats, slack: Floats, grow: float = 0.0) -> Clearance:
    """The same of a follower without a roller."""
    from camgeom.track.sliding import passing

    when, distance = passing(slider, points)
    distance += slack - grow
    i = int(np.argmin(distance))
    return Clearance.at(distance[i], when[i], points[i], slider.name)


def least_distances(track: Track, points: Floats) -> Floats:
    """Least distance (v,) of each of the points (v, 3) from the roller over its whole motion, mm; negative: inside.

    Infinite for what lies farther away than the roller's radius.
    """
    track = track.evenly
    radius = _largest_radius(track)
    found = np.full(len(points), np.inf)
    turns = _turns(track)
    for turn in turns:
        whole = _Window.of(track, 2.0 * radius)
        over = TURN * turn - whole.half, TURN * (turn + 1) + whole.half
        window = whole if len(turns) == 1 else _Window.of(replace(track, span=over), 2.0 * radius)
        near = np.flatnonzero(window.near(points))
        if not len(near):
            continue
        count = max(SAMPLES, int(np.ceil(2.0 * whole.half * _lipschitz(track) / radius)))
        step = whole.half / (count // 2 - 0.5)
        x, index, value = _samples(track, whole, turn, points[near], count, step)
        best = value.min(axis=1)
        # A point may lie in the way of several passes: each local minimum is followed.
        edge = np.full((len(near), 1), np.inf)
        low = (value <= np.hstack([edge, value[:, :-1]])) & (value <= np.hstack([value[:, 1:], edge]))
        row, column = np.nonzero(low & (value < radius))
        start = np.asarray(step * index[row, column], dtype=np.float64)
        np.minimum.at(best, row, roller_distance(track, x[:, row], _stationary(track, x[:, row], start, step)[0]))
        found[near] = np.minimum(found[near], best)
    return found


NEARNESS = (0.02, 0.2, 1.0)
"""shares of the roller's radius within which points are looked at, until the nearest one is sure to be among them"""


def _least_within(track: Track, points: Floats, slack: Floats | None, reach: float) -> Clearance:
    """The least distance of the points that come within `reach` of the roller's axis."""
    turns = _turns(track)
    window = _Window.of(track, reach)
    best = Clearance(float("inf"), 0.0, (0.0, 0.0, 0.0))
    for turn in turns:
        # What a roller passes in one turn of several is a part of the cam.
        over = TURN * turn - window.half, TURN * (turn + 1) + window.half
        part = window if len(turns) == 1 else _Window.of(replace(track, span=over), reach)
        near = part.near(points)
        if not np.any(near):
            continue
        extra = np.zeros(int(near.sum())) if slack is None else slack[near]
        found = _search(track, points[near], extra, window, turn)
        if found.value < best.value:
            best = found
    return best


def wall_ends(mesh: Mesh) -> tuple[Floats, Floats]:
    """Heights (v,) z between which the wall of a planar cam's flank stands at each of its vertices, mm.

    Such a wall has vertices at its two ends alone, which edges join. Both are a vertex's own height where it is on no
    flank.
    """
    z, edges = mesh.vertices[:, 2], _edges(mesh, "flank").T
    low, high = z.copy(), z.copy()
    for one, other in (edges, edges[::-1]):
        np.minimum.at(low, one, z[other])
        np.maximum.at(high, one, z[other])
    return low, high


def wall_points(mesh: Mesh, height: float) -> Floats:
    """Vertices (v, 3) of a planar cam, those of its flanks moved along Z to `height` as far as each wall reaches, mm:
    a roller shorter than the wall touches between its ends. Those of walls that lean stay where they are."""
    points = mesh.vertices.copy()
    _, place, count = np.unique(points[:, :2], axis=0, return_inverse=True, return_counts=True)
    straight = count[place.ravel()] > 1
    points[straight, 2] = np.clip(height, *wall_ends(mesh))[straight]
    return points


def floor_points(mesh: Mesh) -> Floats:
    """Middles (e, 3) of the edges of floor faces: a floor is straight from foot to foot, with no vertex between."""
    return _middles(mesh.vertices, _edges(mesh, "floor"))


def facet_points(
    mesh: Mesh, points: Floats, among: npt.NDArray[np.bool_] | None = None, inner: bool = False
) -> Floats:
    """Middles (e, 3) of edges of flank faces, whose vertices stand at `points` (v, 3): where facets stand proud most.

    Of many edges the longest, which have the largest sag, and as many others from all over the flanks.
    among  (v,) both ends of the edges are such vertices
    inner  without edges at which other faces begin: the chord of a coarser face runs aside within the flank's surface
    """
    edges = _edges(mesh, "flank", inner)
    if among is not None:
        edges = edges[among[edges].all(axis=1)]
    if len(edges) > 2 * FACETS:
        ends = points[edges]
        longest = np.argsort(((ends[:, 1] - ends[:, 0]) ** 2).sum(axis=1))[-FACETS:]
        edges = edges[distinct(np.concatenate([longest, thinned(len(edges), FACETS)]))]
    return _middles(points, edges)


FACETS = 800
"""edges of flank facets that are measured, of the longest and of all"""


def thinned(count: int, most: int) -> npt.NDArray[np.int64]:
    """At most so many of the numbers below `count`, in no order that a grid could have."""
    if count <= most:
        return np.arange(count)
    # splitmix64 of the numbers (Steele, Lea, Flood 2014): numpy's own generators cost 15 ms of import.
    mixed = np.arange(1, count + 1, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return np.sort(np.argpartition(mixed ^ (mixed >> np.uint64(31)), most)[:most])


def _edges(mesh: Mesh, group: str, inner: bool = False) -> npt.NDArray[np.int64]:
    """Edges (e, 2) of the faces of one group, each once; only those between two of them where `inner`."""
    faces = mesh.faces[mesh.group_faces(group)]
    if not len(faces):
        return np.zeros((0, 2), dtype=np.int64)
    start, end, count = faces.ravel(), faces[:, [1, 2, 0]].ravel(), len(mesh.vertices)
    keys = np.minimum(start, end).astype(np.int64) * count + np.maximum(start, end)
    if inner:
        keys.sort(kind="stable")
        keys = keys[1:][keys[1:] == keys[:-1]]
    edges = distinct(keys)
    return np.stack([edges // count, edges % count], axis=1)


def _middles(points: Floats, edges: npt.NDArray[np.int64]) -> Floats:
    return np.asarray(points[edges].mean(axis=1)).reshape(-1, 3)


def roller_distance(track: Track, x: Floats, phi: Floats) -> Floats:
    """Signed distance (…) of points x (3, ...) to the roller body standing at cam angles phi (...), mm."""
    pose = track.pose(phi.ravel(), 0)
    shape = (3, *phi.shape)
    return _distance(track, x, pose.a[0].reshape(shape), pose.u[0].reshape(shape))


def _samples(track: Track, window: _Window, turn: int, points: Floats, count: int, step: float
             ) -> tuple[Floats, npt.NDArray[np.int64], Floats]:  # fmt: skip
    """Points (v, 3) as (3, v), the whole steps (v, k) about their passage in a turn, and their distances there, mm.

    Samples stand on whole steps, so that few poses serve all points; half a step more covers the window from there.
    """
    x, middle = np.ascontiguousarray(points.T), np.rint((window.angles(points) + TURN * turn) / step).astype(np.int64)
    index = middle[:, None] + np.arange(-(count // 2), count // 2 + 1)
    return x, index, _at_steps(track, x[:, :, None], index, step)


def _at_steps(track: Track, x: Floats, index: npt.NDArray[np.int64], step: float) -> Floats:
    """The same at whole multiples `index` (...) of an angle: points that share an angle share its pose."""
    first, last = int(index.min()), int(index.max())
    pose = track.pose(step * np.arange(first, last + 1, dtype=np.float64), 0)
    found = np.empty(index.shape)
    for low in range(0, len(index), BLOCK):
        part = index[low : low + BLOCK] - first
        found[low : low + BLOCK] = _distance(
            track, x[:, low : low + BLOCK], np.take(pose.a[0], part, axis=1), np.take(pose.u[0], part, axis=1)
        )
    return found


BLOCK = 512
"""points whose distances at all steps are taken at once, so that they stay in the processor's cache"""


def _distance(track: Track, x: Floats, a: Floats, u: Floats) -> Floats:
    """Signed distance (…) of points x from the roller whose axis has the point a and the direction u (3, ...), mm."""
    d = x - a
    axial = np.einsum("k...,k...->...", d, u)
    across = np.einsum("k...,k...->...", d, d)
    across -= axial * axial
    np.sqrt(np.maximum(across, 0.0, out=across), out=across)
    return body_distance(track.meridian, track.tip, track.contact, axial, across)


def body_distance(
    meridian: Meridian, tip: float, contact: tuple[float, float], axial: Floats, across: Floats
) -> Floats:
    """Signed distance in the meridian half plane to a roller between its tip and the far end of its contact stretch.

    Exact inside and beside the roller; beyond its flat ends the distance to the end plane or rim.
    """
    if isinstance(meridian, Straight):
        slope = meridian.slope
        level = across - meridian.radius - slope * (axial - meridian.centre)
        wall = np.asarray(level / np.sqrt(1.0 + slope * slope))
    else:
        wall = _arc_wall(meridian, axial, across)
    if _ball(meridian):
        return wall
    low, high = min(tip, *contact), max(tip, *contact)
    end = np.maximum(low - axial, axial - high)
    beside, beyond = np.maximum(wall, 0.0), np.maximum(end, 0.0)
    outside = np.sqrt(beside * beside + beyond * beyond)
    return np.asarray(np.where(outside > 0.0, outside, np.maximum(wall, end)))


def _ball(meridian: Meridian) -> bool:
    return isinstance(meridian, Arc) and abs(meridian.arc - meridian.radius) < 1e-12 * meridian.arc


def _arc_wall(meridian: Arc, axial: Floats, across: Floats) -> Floats:
    return np.asarray(
        np.hypot(across - (meridian.radius - meridian.arc), axial - meridian.centre) - meridian.arc
    )


def _largest_radius(track: Track) -> float:
    ends = np.array([track.meridian.parameter(d) for d in (track.tip, *track.contact)])
    grid = np.linspace(ends.min(), ends.max(), 33)
    return float(track.meridian.jet(grid)[3].max())


def _turns(track: Track) -> range:
    return range(int(np.floor(track.span[0] / TURN + 1e-9)), int(np.ceil(track.span[1] / TURN - 1e-9)))


@immutable(eq=True)
class _Window:
    """Where the roller can be in the machine frame: a sector of azimuth, and a radial and an axial stretch.

    Of a cam that slides `rate` mm a radian the sector is a length along the slide, and across it is what is radial.
    """

    middle: float
    half: float
    low: float
    high: float
    below: float
    above: float
    sense: float
    rate: float = 0.0

    @classmethod
    def of(cls, track: Track, reach: float) -> _Window:
        phi = np.linspace(*track.span, 721)
        pose = track.pose(phi, 0)
        axial = np.linspace(min(track.tip, *track.contact), max(track.tip, *track.contact), 9)
        p = pose.a[0][:, :, None] + axial * pose.u[0][:, :, None]
        if track.carriage is not None:
            rate = track.carriage.stroke / TURN
            along = p[0] - (rate * np.clip(phi, 0.0, TURN))[:, None]
            (left, right), half = (float(along.min()), float(along.max())), reach / rate
            sides = (float(p[1].min()), float(p[1].max()), float(p[2].min()), float(p[2].max()))
            return cls(0.5 * (left + right), half + 0.5 * (right - left) / rate + 1e-6, sides[0] - reach,
                       sides[1] + reach, sides[2] - reach, sides[3] + reach, track.sense, rate)  # fmt: skip
        z = (p[0] + 1j * p[1]) * np.conj(pose.turn)[:, None]
        radius, angle = np.abs(z), np.angle(z * np.conj(z.mean() / abs(z.mean()))) if abs(z.mean()) > 0 else np.angle(z)
        spread = np.where(radius > reach, np.arcsin(np.minimum(1.0, reach / np.maximum(radius, 1e-300))), np.pi)
        low, high = float((angle - spread).min()), float((angle + spread).max())
        half = min(np.pi, 0.5 * (high - low) + 1e-6)
        middle = 0.5 * (low + high) + float(np.angle(z.mean()))
        ends = float(radius.min()), float(radius.max()), float(p[2].min()), float(p[2].max())
        return cls(middle, half, ends[0] - reach, ends[1] + reach, ends[2] - reach, ends[3] + reach, track.sense)

    def near(self, points: Floats) -> npt.NDArray[np.bool_]:
        """Points within the radial and the axial stretch."""
        radius, z = points[:, 1] if self.rate else np.hypot(points[:, 0], points[:, 1]), points[:, 2]
        return np.asarray((radius > self.low) & (radius < self.high) & (z > self.below) & (z < self.above))

    def angles(self, points: Floats) -> Floats:
        """Cam angle (v,) at which the middle of the sector faces each point: azimuth = middle - sense phi."""
        if self.rate:
            return np.asarray((points[:, 0] - self.middle) / self.rate)
        azimuth = np.arctan2(points[:, 1], points[:, 0])
        return np.asarray((self.sense * (self.middle - azimuth)) % TURN)


def _search(track: Track, x: Floats, extra: Floats, window: _Window, turn: int) -> Clearance:
    """Best of coarse samples in each point's window, refined: on the roller's side by the stationary distance to its
    axis, elsewhere (ends, rims) by narrowing brackets where the point can still undercut the best."""
    step, speed = window.half / (SAMPLES // 2 - 0.5), _lipschitz(track)
    xt, index, value = _samples(track, window, turn, x, SAMPLES, step)
    value += extra[:, None]
    rows = np.arange(len(x))
    best = np.argmin(value, axis=1)
    centre, coarse = step * index[rows, best], value[rows, best]
    # Half a step from its nearest sample a distance is less by no more than the fastest point of the roller moves: what
    # stays farther away than the nearest sample of all is not the nearest point.
    moved = 0.5 * speed * step
    hopeful = np.flatnonzero(coarse - moved <= coarse.min())
    x, extra, xt, centre, coarse = x[hopeful], extra[hopeful], xt[:, hopeful], centre[hopeful], coarse[hopeful]
    # Beside its least a distance to what is round grows by the square of the way: what is farther off at its nearest
    # sample than that is not near its least there, and its bracket alone is narrowed.
    close = np.flatnonzero(coarse <= coarse.min() + moved * moved / _largest_radius(track))
    fine, refined, settled = coarse.copy(), centre.copy(), np.zeros(len(x), dtype=bool)
    where, settled[close] = _stationary(track, xt[:, close], centre[close], step)
    distance = roller_distance(track, xt[:, close], where) + extra[close]
    better = distance < coarse[close]
    fine[close[better]], refined[close[better]] = distance[better], where[better]
    least = float(fine.min())
    unsure = (coarse - moved < least) & (fine > least + 1e-9) & ((fine == coarse) | ~settled)
    point, low, high = np.flatnonzero(unsure), centre[unsure] - step, centre[unsure] + step
    for number in range(ROUNDS):
        if not len(point):
            break

        def depth(at: Floats, near: Floats = xt[:, point, None], whole: bool = number == 0) -> Floats:
            # The first fans stand on parts of the steps.
            part = 2.0 * step / (FAN - 1)
            return -(_at_steps(track, near, np.rint(at / part).astype(np.int64), part) if whole
                     else roller_distance(track, near, at))

        deepest, where, low, high = narrowed(depth, low, high)
        distance = extra[point] - deepest
        better = distance < fine[point]
        fine[point] = np.where(better, distance, fine[point])
        refined[point] = np.where(better, where, refined[point])
        # From the middle of its bracket a distance falls by no more than the fastest point of the roller moves; a point
        # that cannot come below the least is done with.
        keep = distance - 0.5 * speed * (high - low) < float(fine.min())
        point, low, high = point[keep], low[keep], high[keep]
    i = int(np.argmin(fine))
    return Clearance.at(fine[i], refined[i], x[i])


def _stationary(track: Track, x: Floats, phi: Floats, step: float) -> tuple[Floats, npt.NDArray[np.bool_]]:
    """Cam angles (v,) where the distance of points (3, v) to the roller is stationary, by secant from phi, and whether
    the secants have settled there."""
    low, high = phi - step, phi + step

    def slope(at: Floats, x: Floats) -> Floats:
        pose = track.pose(at, 1)
        a, u, da, du = pose.a[0], pose.u[0], pose.a[1], pose.u[1]
        if _ball(track.meridian):
            d, v = x - a - track.meridian.centre * u, da + track.meridian.centre * du
            far = np.sqrt((d * d).sum(axis=0))
            return np.asarray(-(d * v).sum(axis=0) / np.where(far > 0.0, far, 1.0))
        d = x - a
        axial = (d * u).sum(axis=0)
        radius = track.meridian.jet(_parameter(track, axial))
        across = d - axial * u
        length = np.sqrt((across * across).sum(axis=0))
        moved = (across * (da + axial * du)).sum(axis=0) / np.where(length > 0.0, length, 1.0)
        along = ((da * u).sum(axis=0) - (d * du).sum(axis=0)) * radius[4] / np.where(radius[1] != 0.0, radius[1], 1.0)
        return np.asarray(-moved + along)

    p, q = phi - 0.25 * step, phi + 0.25 * step
    fp, fq = slope(p, x), slope(q, x)
    found, live = q.copy(), np.arange(len(phi))
    settled = np.ones(len(phi), dtype=bool)
    for number in range(SECANTS):
        change = fq - fp
        move = np.where(change != 0.0, fq * (q - p) / np.where(change != 0.0, change, 1.0), 0.0)
        p, fp, q = q, fq, np.clip(q - move, low[live], high[live])
        found[live] = q
        # What is left is as the product of the last two steps, and about its least a distance changes by its square.
        going = np.abs(q - p) > SHORT * step
        live, p, q, fp = live[going], p[going], q[going], fp[going]
        if number + 1 == SECANTS or not len(live):
            break
        fq = slope(q, x[:, live])
    settled[live] = False
    return found, settled


def _parameter(track: Track, axial: Floats) -> Floats:
    """Meridian parameter at axial coordinates."""
    meridian = track.meridian
    if isinstance(meridian, Straight):
        return axial
    return np.asarray(np.arcsin(np.clip((axial - meridian.centre) / meridian.arc, -1.0, 1.0)))


def _lipschitz(track: Track) -> float:
    """How much the distance can fall per radian, mm: the roller's largest speed."""
    phi = np.linspace(*track.span, 361)
    pose = track.pose(phi, 1)
    pace = 1.0 if pose.pace is None else pose.pace
    speeds = [pose.a[1] + d * pose.u[1] for d in (track.tip, *track.contact)]
    return float(max((np.sqrt((v * v).sum(axis=0)) * pace).max() for v in speeds))


def flank_gap(one: Track, other: Track, level: Level, near: float) -> Extreme:
    """Least distance of the flank of one roller, where it meets a level surface, from the flank of the other, mm.

    The material between two flanks is as thick as its points on one are far from all positions of the other's roller;
    negative where that roller cuts the flank away. Exact: no curvature is left out, no section developed.

    level  the surface on which the thickness is asked, near: a delta near it
    """
    wide = 2.0 * _largest_radius(other)
    other = replace(other, tip=other.tip - wide, contact=(min(other.contact) - wide, max(other.contact) + wide))
    (side,) = one.sides
    knots = one.knots()

    def edge(phi: Floats) -> Floats:
        column = Column(one, phi)
        return np.ascontiguousarray(column.wall(side, column.reach(side, level, near))[:, :, 0].T)

    phi, _ = piece_grid(knots, EDGE_SAMPLES)
    # Somewhere the flank is as near as where both rollers stand at one cam angle.
    beside = float(roller_distance(other, edge(phi).T, phi).min())
    reach = _largest_radius(other) + max(beside, 0.0) + 1e-6
    low, high = float(knots[0]), float(knots[-1])
    best, place = Clearance(np.inf, 0.0, (0.0, 0.0, 0.0)), 0.0
    for _ in range(EDGE_ROUNDS):
        points = edge(phi)
        least = _least_within(other, points, None, reach)
        at = int(np.argmin(((points - np.array(least.point)) ** 2).sum(axis=1)))
        if least.value <= best.value:
            best, place = least, float(phi[at])
        step = float(np.diff(phi[max(0, at - 1) : at + 2]).max(initial=0.0))
        phi = np.linspace(max(low, place - step), min(high, place + step), 2 * FAN)
    return Extreme(best.value, place, near)


EDGE_SAMPLES = 360
EDGE_ROUNDS = 5


def largest_gap(
    tracks: tuple[Track, ...], sliders: tuple[Slider, ...], points: Floats, slack: Floats
) -> Clearance:
    """The point (v, 3) of a flank that all followers pass at the largest distance, mm, and where the nearest stands.

    slack  (v,) by how much a point may stand back from the true surface, mm; it is taken off the point's distance

    The rollers count without their ends: beyond the contact stretch too the flank is that of the roller gone on.
    Of many points MOST_POINTS are looked at, from all over.
    """
    some = thinned(len(points), MOST_POINTS)
    points, slack = points[some], slack[some]
    least, when = np.full(len(points), np.inf), np.zeros(len(points))
    for slider in sliders:
        from camgeom.track.sliding import passing

        angles, distance = passing(slider, points)
        better = distance < least
        least[better], when[better] = distance[better], angles[better]
    passes = []
    for track in (one.evenly for one in tracks):
        radius = _largest_radius(track)
        longer = replace(
            track, tip=track.tip + track.tip_sign * radius,
            contact=(min(track.contact) - radius, max(track.contact) + radius),
        )  # fmt: skip
        whole = _Window.of(longer, 2.0 * radius)
        for turn in _turns(longer):
            over = TURN * turn - whole.half, TURN * (turn + 1) + whole.half
            part = whole if len(_turns(longer)) == 1 else _Window.of(replace(longer, span=over), 2.0 * radius)
            near = np.flatnonzero(part.near(points))
            if not len(near):
                continue
            passes.append((longer, whole, turn))
            angles, distance = _passing(longer, whole, turn, points[near], SAMPLES)
            better = distance < least[near]
            least[near[better]], when[near[better]] = distance[better], angles[better]
    # A point whose nearest passage lay between the samples seems far: the farthest ones are looked at again.
    for number in range(GAP_ROUNDS):
        worst = np.argsort(least - slack)[::-1][: GAP_POINTS << number]
        before = least[worst].copy()
        for longer, whole, turn in passes:
            angles, distance = _nearest_pass(longer, whole, turn, points[worst])
            better = distance < least[worst]
            least[worst[better]], when[worst[better]] = distance[better], angles[better]
        if np.all(least[worst] > before - 1e-9):
            break
    least -= slack
    i = int(np.argmax(least))
    angle = tracks[0].drive_angle(float(when[i])) if tracks else when[i]
    return Clearance.at(least[i], angle, points[i])


MOST_POINTS = 4000
GAP_ROUNDS, GAP_POINTS, GAP_SAMPLES = 8, 32, 91
"""rounds, points of the first one and samples a window of the second look at what seems far from every roller; each
round takes twice as many, the last ones all: beside the point of a cone a passage may be shorter than a sample"""


def _nearest_pass(track: Track, window: _Window, turn: int, x: Floats) -> tuple[Floats, Floats]:
    """The same as `_passing`, from many samples and by narrowing brackets."""
    angles, _ = _passing(track, window, turn, x, GAP_SAMPLES)
    step, xt = window.half / (GAP_SAMPLES // 2 - 0.5), np.ascontiguousarray(x.T)
    # A distance is a difference of coordinates, and as coarse as they are, however small it is itself.
    negative, where = bracketed_maximum(
        lambda at: -roller_distance(track, xt[:, :, None], at), angles - step, angles + step,
        noise=8.0 * SAME * float(np.abs(x).max()),
    )  # fmt: skip
    return where, -negative


def _passing(track: Track, window: _Window, turn: int, x: Floats, samples: int) -> tuple[Floats, Floats]:
    """Where in a turn the roller is nearest to points (v, 3): cam angles, rad, and signed distances, mm, (v,) each."""
    step = window.half / (samples // 2 - 0.5)
    xt, index, value = _samples(track, window, turn, x, samples, step)
    rows, best = np.arange(len(x)), np.argmin(value, axis=1)
    centre, coarse = step * index[rows, best], value[rows, best]
    refined, _ = _stationary(track, xt, centre, step)
    fine = roller_distance(track, xt, refined)
    return np.where(fine < coarse, refined, centre), np.minimum(fine, coarse)
