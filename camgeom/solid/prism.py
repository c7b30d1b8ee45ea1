"""Solids of planar cams: an outline with holes between two planes, meshed directly with a guaranteed chord error."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import bracketed_maximum
from camgeom.solid import TOUCHED, QuickPart, Solid, eased, stated
from camgeom.solid.blank import Bore, Wall
from camgeom.solid.builder import (
    Builder,
    Index,
    add_grid,
    band_cells,
    bounded,
    cap,
    polygon_area,
    wrapped_faces,
)
from camgeom.track.outline import Outline

if TYPE_CHECKING:
    from camgeom.maths.sampling import Grid

ROUNDING = 1e-15
"""of the size of points, by which their sag differs for no reason"""
SEARCHED = 24
"""chords whose largest sag is searched for: steps are made for equal sags, which differ by a percent or two"""
NEARER = 0.999
"""share of what would just do that is asked for again where a chord's largest sag exceeds the tolerance"""


@immutable
class Loop:
    """One closed boundary of a body between two planes: an outline and the name of the faces it makes.

    upper  of a wall that leans, as a conical roller's does: the outline at the upper plane over the same cam angles,
           between which it is straight; None: the same as below
    """

    outline: Outline
    name: str
    upper: Outline | None = None

    @property
    def ends(self) -> tuple[Outline, ...]:
        """Its outlines from below up, each once."""
        return (self.outline,) if self.upper is None else (self.outline, self.upper)

    def flat(self, phi: Floats, share: Floats) -> Floats:
        """Points (2, n, k) seen along the axis at shares (k,) of the way up."""
        low = self.outline.curve(phi).points[:, :, None]
        if self.upper is None:
            return np.broadcast_to(low, (*low.shape[:2], len(share)))
        return np.asarray(low + (self.upper.curve(phi).points[:, :, None] - low) * share)


@immutable
class Prism(QuickPart):
    """A planar cam: a disc between z0 and z1 with an outer outline, further holes, and a bore with keyway."""

    name: str
    outer: Loop
    z0: float
    z1: float
    holes: tuple[Loop, ...] = ()
    bore: Bore | None = None

    @property
    def leans(self) -> bool:
        """True where its flank is another curve at every height."""
        return self.outer.upper is not None

    def solid(self, tolerance: float, free: float | None = None) -> Solid:
        """Mesh within the tolerance. Raises DesignError where the outline crosses itself or a hole."""
        builder = Builder()
        walls = [wall(builder, self.outer, self.z0, self.z1, tolerance, False, free)]
        walls += [wall(builder, hole, self.z0, self.z1, tolerance, True, free) for hole in self.holes]
        if self.bore is not None:
            walls.append(bore_wall(builder, self.bore, self.z0, self.z1, free or tolerance))
        above = bounded([w.above for w in walls])
        below = bounded([w.below for w in walls]) if self.leans else above
        builder.faces(np.concatenate([w.high for w in walls])[above], "end")
        builder.faces(np.concatenate([w.low for w in walls])[below][:, ::-1], "end")
        error, free_error = stated([pair for w in walls for pair in w.errors], free)
        return Solid(self.name, builder.mesh(), error, "direct", len(walls) - 1, free_error)


@immutable
class FaceGroove:
    """A groove in a face of a plate at z = `top` as deep as `floor`, between an inner and an outer flank.

    root  mm, radius of the tool's corner, which joins flanks and floor
    """

    inner: Loop
    outer: Loop
    floor: float
    top: float
    root: float = 0.0

    @property
    def way(self) -> float:
        """+1 where the groove opens upwards, -1 downwards."""
        return 1.0 if self.top > self.floor else -1.0

    @property
    def face(self) -> str:
        """The face that it is cut in."""
        return "upper" if self.way > 0.0 else "lower"

    @property
    def heights(self) -> tuple[float, float]:
        """Of its floor and its mouth, from below up, mm."""
        return min(self.floor, self.top), max(self.floor, self.top)

    def at_floor(self, loop: Loop) -> Outline:
        """A flank at the floor, as if the root were sharp."""
        return loop.outline if self.way > 0.0 or loop.upper is None else loop.upper

    @property
    def foot(self) -> float:
        """Height at which the flanks end, mm: at the floor, or a root's radius off it."""
        return self.floor + self.way * self.root

    def root_points(self, loop: Loop, phi: Floats, share: Floats) -> Floats:
        """Points (3, n, k) of a flank's root at shares (k,) or (n, k) of its quarter circle, 0 at the flank's foot.

        The corner of a tool with its axis along Z touches along such a circle square to its path.
        """
        curve, angle = loop.outline.curve(phi), 0.5 * np.pi * np.atleast_2d(share)
        aside = (1.0 if loop is self.inner else -1.0) * self.root * (1.0 - np.cos(angle))
        flat = curve.points[:, :, None] + curve.normals[:, :, None] * aside
        z = self.foot - self.way * self.root * np.sin(angle)
        return np.concatenate([flat, np.broadcast_to(z, (1, *flat.shape[1:]))])

    def flank(self, builder: Builder, loop: Loop, tolerance: float, free: float | None) -> LoopWall:
        """Add one flank with its root: its upper ring is at the mouth, its lower one at the floor."""
        inside, up = loop is self.outer, self.way > 0.0
        if self.root:
            return gridded(builder, self.rounded(loop, tolerance, free), ("root", loop.name), tolerance, inside, up)
        made = wall(builder, loop, *self.heights, tolerance, inside, free)
        return made if up else LoopWall(made.above, made.below, made.high, made.low, made.errors)

    def rounded(self, loop: Loop, tolerance: float, free: float | None = None) -> Grid:
        """A root from the floor and the flank beyond it as one grid within the tolerance."""
        from camgeom.maths.sampling import sample

        def rows(phi: Floats, counts: tuple[int, ...]) -> Floats:
            root = self.root_points(loop, phi, np.linspace(1.0, 0.0, counts[0] + 1))
            flank = np.repeat(root[:, :, -1:], counts[1], axis=2)
            flank[2] = self.foot + (self.top - self.foot) * np.arange(1, counts[1] + 1) / counts[1]
            return np.concatenate([root, flank], axis=2)

        ease = eased(("root", loop.name), tolerance, free)
        return sample(rows, loop.outline.knots(), tolerance, (4000, 1), ease)


@immutable
class GroovedPlate(QuickPart):
    """A plate z0..z1 with a groove in its upper face, its lower one or both; its rim is a circle or a profile.

    walls  what is left between its tracks, of which none may be gone
    """

    name: str
    rim: Loop
    grooves: tuple[FaceGroove, ...]
    z0: float
    z1: float
    bore: Bore | None = None
    walls: tuple[Wall, ...] = ()

    @property
    def leans(self) -> bool:
        """True where a flank is another curve at every height."""
        return self.rim.upper is not None or any(groove.inner.upper is not None for groove in self.grooves)

    def refuse_open(self) -> None:
        """Raise DesignError where a groove runs into the other one, out of the rim or through the plate."""
        for place in self.walls:
            if place.thickness <= 0.0:
                raise DesignError(f"{place.name}: nothing is left, so the tracks bound no body; {place.advice}")

    def solid(self, tolerance: float, free: float | None = None) -> Solid:
        """Mesh within the tolerance. Raises DesignError where outlines cross or a wall is gone."""
        self.refuse_open()
        builder = Builder()
        rim = wall(builder, self.rim, self.z0, self.z1, tolerance, False, free)
        hole = [] if self.bore is None else [bore_wall(builder, self.bore, self.z0, self.z1, free or tolerance)]
        walls, open_faces = [rim, *hole], {1.0, -1.0}
        for groove in self.grooves:
            up = groove.way > 0.0
            outer, inner = (groove.flank(builder, loop, tolerance, free) for loop in (groove.outer, groove.inner))
            side = [w.high if up else w.low for w in (rim, *hole)]
            cap(builder, [side[0], outer.high], [rim.above if up else rim.below, outer.above], "end", up)
            cap(builder, [inner.high, *side[1:]], [inner.above, *(w.above for w in hole)], "end", up)
            # The floor lies between the flanks' feet: its outer boundary is the outer flank, its hole the inner one.
            cap(builder, [outer.low[::-1], inner.low[::-1]], [outer.below[::-1], inner.below[::-1]], "floor", up)
            walls += [outer, inner]
            open_faces.discard(groove.way)
        for way in open_faces:
            rings = [w.high if way > 0.0 else w.low for w in (rim, *hole)]
            cap(builder, rings, [w.above if way > 0.0 else w.below for w in (rim, *hole)], "end", way > 0.0)
        error, free_error = stated([pair for w in walls for pair in w.errors], free)
        return Solid(self.name, builder.mesh(), error, "direct", len(hole), free_error)


@immutable
class LoopWall:
    """A wall over a closed polygon: plane points (n, 2) of its lower and upper ring, counter-clockwise (clockwise round
    a hole), their vertices, and the chord errors of its named faces, mm."""

    below: Floats
    above: Floats
    low: Index
    high: Index
    errors: tuple[tuple[str, float], ...]


def wall(
    builder: Builder, loop: Loop, z0: float, z1: float, tolerance: float, inside: bool, free: float | None = None
) -> LoopWall:
    """Add the wall of an outline between two heights; `inside` for the wall of a hole."""
    limit = tolerance if loop.name == TOUCHED else free or tolerance
    if loop.upper is not None:
        return gridded(builder, loop_grid(loop, limit, z0, z1), (loop.name,), tolerance, inside)
    grid = outline_grid(loop.outline, limit)
    plane = grid.points[:2, :-1, 0].T
    return raised(builder, plane, [loop.name] * len(plane), z0, z1, inside, (loop.name, grid.chord_error))


def gridded(
    builder: Builder, grid: Grid, names: tuple[str, ...], tolerance: float, inside: bool, up: bool = True
) -> LoopWall:
    """Add a wall as a grid of bands by name from its lower ring, or its upper one where not `up`, to the other."""
    index = add_grid(builder, grid.points[:, :-1], grid.counts, names, tolerance)
    far, near = grid.points[:2, :-1, -1].T, grid.points[:2, :-1, 0].T
    turned = (polygon_area(far) < 0.0) != inside
    faces = wrapped_faces(index, grid.rising, inward=turned == up)
    for band, name in enumerate(names):
        builder.faces(faces[band_cells(grid.counts, band)].reshape(-1, 3), name)
    way = -1 if turned else 1
    errors = [(names[-1], grid.chord_error), *((name, grid.free_error or 0.0) for name in names[:-1])]
    return LoopWall(near[::way], far[::way], index[::way, 0], index[::way, -1], tuple(errors))


def bore_wall(builder: Builder, bore: Bore, z0: float, z1: float, tolerance: float) -> LoopWall:
    """Add the wall of a bore with its keyway."""
    plane, names = bore.outline(tolerance)
    return raised(builder, plane, names, z0, z1, True, ("bore", bore.sag(tolerance)))


def raised(
    builder: Builder, plane: Floats, names: list[str], z0: float, z1: float, inside: bool, error: tuple[str, float]
) -> LoopWall:
    if (polygon_area(plane) < 0.0) != inside:
        plane, names = plane[::-1].copy(), [*names[::-1][1:], names[-1]]
    low = builder.add(np.column_stack([plane, np.full(len(plane), z0)]))
    high = builder.add(np.column_stack([plane, np.full(len(plane), z1)]))
    low2, high2 = np.roll(low, -1), np.roll(high, -1)
    for name in dict.fromkeys(names):
        mask = np.array([n == name for n in names])
        builder.faces(np.stack([low, low2, high2], axis=1)[mask], name)
        builder.faces(np.stack([low, high2, high], axis=1)[mask], name)
    return LoopWall(plane, plane, low, high, (error,))


def outline_grid(outline: Outline, tolerance: float) -> Grid:
    """The outline sampled so that every chord is within tolerance: a grid of one band over a unit height."""
    return loop_grid(Loop(outline, ""), tolerance, 0.0, 1.0)


def loop_grid(loop: Loop, tolerance: float, z0: float, z1: float) -> Grid:
    """A wall between two heights sampled so that every chord is within tolerance: a grid of one band.

    Its chord error is the largest distance of its outlines from a chord, found along the chord, not half way alone. A
    flank that leans is nearer to its facets than that, but what lies in the corner of a flat end is not.
    """
    from camgeom.maths.sampling import sample

    def rows(phi: Floats, counts: tuple[int, ...]) -> Floats:
        share = np.linspace(0.0, 1.0, counts[0] + 1)
        flat = loop.flat(phi, share)
        return np.concatenate([flat, np.broadcast_to(z0 + (z1 - z0) * share, (1, *flat.shape[1:]))])

    def sag(grid: Grid) -> float:
        ends = zip(loop.ends, (0, -1))
        return max(_largest_sag(outline, grid.phi, grid.points[:2, :, k]) for outline, k in ends)

    grid = sample(rows, loop.outline.knots(), tolerance, (1,))
    largest = sag(grid)
    if largest > tolerance:
        # Half way the sag falls short of the largest by as much again.
        grid = sample(rows, loop.outline.knots(), tolerance * grid.chord_error / largest * NEARER, (1,))
        largest = sag(grid)
    return replace(grid, chord_error=largest if loop.upper is None else max(largest, grid.chord_error))


def _largest_sag(outline: Outline, phi: Floats, points: Floats) -> float:
    """Largest distance, mm, of an outline from its chords between parameters phi (n + 1,), points (2, n + 1) there.

    A chord's sag is s (1 - s) times a parabola but for terms of the fifth order: the worst by that are searched.
    """
    low, width = phi[:-1], np.diff(phi)
    start, way = points[:, :-1], np.diff(points, axis=1)
    across = np.stack([-way[1], way[0]]) / np.maximum(np.hypot(*way), 1e-300)

    def sag(at: Floats, chord: Index) -> Floats:
        x = outline.curve(at.ravel()).points.reshape(2, *at.shape)
        return np.asarray(((x - start[:, chord, None]) * across[:, chord, None]).sum(axis=0))

    quarters = np.array([0.25, 0.5, 0.75])
    bend = sag(low[:, None] + width[:, None] * quarters, np.arange(len(low))) / (quarters * (1.0 - quarters))
    s = np.linspace(0.0, 1.0, 33)
    shares = np.array([[np.prod([(s - b) / (a - b) for b in quarters if b != a], axis=0)] for a in quarters])[:, 0]
    worst = np.argsort(np.abs(bend @ (shares * s * (1.0 - s))).max(axis=1))[-SEARCHED:]
    noise = ROUNDING * float(np.abs(points).max())
    found, _ = bracketed_maximum(
        lambda at: np.abs(sag(at, worst)), low[worst], low[worst] + width[worst], noise=noise, least=0.0
    )
    return float(found.max())
