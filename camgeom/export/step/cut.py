"""Bodies cut from a blank as boundary representations: which faces there are from a mesh, where they meet exactly.

The grooves' walls and floors are fitted once, as patches. A boolean of coarse meshes made on those patches says which
pieces of which patches bound the body and which of them are neighbours. Then every corner and every edge is found on
the patches themselves: an edge is where two of them cross, to a billionth of a millimetre, and a spline through such
points to a tenth of the tolerance.
"""

from __future__ import annotations

from dataclasses import replace
from math import pi
from typing import final

import numpy as np

from camgeom.errors import CamgeomError, DesignError, NotConverged
from camgeom.export.step.brep import Brep, Edge, Face, Loop, Use, Vertex, vertex
from camgeom.export.step.check import check_solid
from camgeom.export.step.geometry import Cone, Curve, SplineSurface, Surface, Torus
from camgeom.export.step.groove import FlankPair, between, flipped, groove_bands, points_last, rooted_bands, split_knots
from camgeom.export.step.meeting import SurfaceCrossing, corner, fit_curve, iso_curve
from camgeom.export.step.patches import SECTORS, GrooveBody, Patch, blank_patches, groove_body, keyway_start
from camgeom.export.step.shell import ShellBand
from camgeom.export.step.solids import TOLERANCE
from camgeom.export.step.tagged import OUTSIDE, Chain, blank_mesh, groove_mesh, regions_of, subtract_tagged
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.mesh import Mesh
from camgeom.solid.cut import CutBlank, IndexingCut
from camgeom.track import Track
from camgeom.track.section import FlooredSection, GrooveSection, RootedSection

SAGS = (0.03, 0.008)
"""mm; of the meshes that settle the topology, tried one after another; in proportion more where the body is LARGE"""
LARGE = 1000.0
"""mm"""
EDGE_SHARE = 0.1
"""tolerance of edges as a share of that of the surfaces"""
TOGETHER = 1e-9
"""share of where they are; corners so near to each other are one, and what is between them is no edge"""


def cut_solid(body: IndexingCut | CutBlank, tolerance: float = TOLERANCE) -> Brep:
    """The cut blank as a solid whose fitted faces are within `tolerance` mm of the exact ones.

    Raises CamgeomError with the reason where the faces and edges do not close.
    """
    grooves: list[GrooveBody] = []
    count = 0
    for number, track in enumerate(body.tracks):
        bands, knots = _bands(body, track)
        grooves.append(groove_body(bands, knots, track.closed, number, count, tolerance))
        count += len(grooves[-1].patches)
    trouble: CamgeomError | None = None
    size = float(np.ptp(body.blank.mesh(SAGS[0]).vertices, axis=0).max())
    for sag in SAGS:
        try:
            return _Body(body, grooves, sag * max(1.0, size / LARGE), tolerance).solid()
        except CamgeomError as error:
            trouble = error
    assert trouble is not None
    raise trouble


def _bands(body: IndexingCut | CutBlank, track: Track) -> tuple[list[ShellBand], Floats]:
    """Bands across a groove from the top of flank +1 to the top of flank -1, and the knots along it."""
    if isinstance(body, CutBlank):
        return groove_bands(FlankPair(track, body.outside, body.guess), 1.0), split_knots(track)
    section = body.section(track)
    if isinstance(section, GrooveSection):
        return groove_bands(FlankPair(track, body.top, body.guesses[0]), 1.0), track.knots()
    if isinstance(section, RootedSection):
        return rooted_bands(FlankPair(track, body.top, body.guesses[0])), track.knots()
    return _floored(section), track.knots()


def _floored(section: FlooredSection) -> list[ShellBand]:
    top = FlankPair(section.track, section.top, section.guesses[0])
    foot = FlankPair(section.track, section.floor, section.guesses[1])

    def floor(phi: Floats, share: Floats) -> Floats:
        column = foot.column(phi)
        low, high = (column.wall(side, foot.top(phi, side)) for side in (1.0, -1.0))
        return points_last(low * (1.0 - share) + high * share)

    down, up = flipped(between(foot, top, 1.0)), between(foot, top, -1.0)
    return [ShellBand("flank", down), ShellBand("floor", floor, degree=1), ShellBand("flank", up)]


@final
class _Body:
    """One attempt: the mesh of one sag, its topology, and the exact corners, edges and faces."""

    def __init__(self, body: IndexingCut | CutBlank, grooves: list[GrooveBody], sag: float, tolerance: float) -> None:
        self.name, self.tolerance, self.sag = body.name, tolerance, sag
        self.patches = [patch for one in grooves for patch in one.patches]
        first = len(self.patches)
        cuts = _cut_angles(body, sag)
        on_blank = blank_patches(body.blank, *cuts, len(grooves))
        self.patches += on_blank
        tools = [groove_mesh(one, track, body.ridge, sag) for one, track in zip(grooves, body.tracks)]
        self.cut = subtract_tagged(blank_mesh(body.blank, on_blank, first, sag), tools)
        if np.any(self.cut.tag == OUTSIDE):
            raise DesignError("the back or a cap of a groove body reaches into the blank")
        self.regions = regions_of(self.cut)
        self.vertices: dict[int, _Corner] = {}

    def solid(self) -> Brep:
        """The body, verified. Raises NotConverged or DesignError."""
        regions, patches = self.regions, self.patches
        self._make_corners()
        edges = [self._edge(chain) for chain in regions.chains]
        faces = [self._face(number, [edge for edge, _ in edges]) for number in range(len(regions.tag))]
        used = {int(tag) for tag in regions.tag}
        deviation = max([patches[tag].deviation for tag in used] + [error for _, error in edges])
        found = Brep(self.name, tuple(faces), deviation=deviation)
        return replace(found, deviation=max(deviation, self._verified(found)))

    def _verified(self, found: Brep) -> float:
        """Largest gap (mm) between edges and faces.

        Raises DesignError where loops, edges, corners or orientation are not those of the body that the mesh shows.
        """
        verdict = check_solid(found, self.tolerance, nodes=2)
        problems = list(verdict.problems)
        mesh = Mesh(self.cut.vertices, self.cut.faces.astype(np.int32))
        if abs(verdict.volume - mesh.volume) > self.sag * mesh.area:
            problems.append(f"the volume is {verdict.volume:.9g} mm³, of the mesh {mesh.volume:.9g} mm³")
        if verdict.genus != mesh.genus:
            problems.append(f"the genus is {verdict.genus}, of the mesh {mesh.genus}")
        if problems:
            raise DesignError("the faces do not bound the body: " + "; ".join(problems))
        return verdict.deviation

    def patch_of(self, region: int) -> Patch:
        """The patch of a region."""
        return self.patches[int(self.regions.tag[region])]

    def _make_corners(self) -> None:
        meeting: dict[int, dict[int, Floats]] = {}
        for chain in self.regions.chains:
            for end in (0, -1):
                here = meeting.setdefault(int(chain.path[end]), {})
                here[chain.left], here[chain.right] = chain.at_left[end], chain.at_right[end]
        for number, seen in meeting.items():
            self.vertices[number] = self._corner(self.cut.vertices[number], seen)

    def _corner(self, rough: Floats, seen: dict[int, Floats]) -> _Corner:
        """The exact corner of the regions seen there with their rough parameters."""
        tags: dict[int, Floats] = {}
        for region, at in seen.items():
            tags.setdefault(int(self.regions.tag[region]), at)
        numbers = list(tags)
        patches = [self.patches[tag] for tag in numbers]
        fixed: list[dict[int, float]] = [{} for _ in patches]
        for i, one in enumerate(patches):
            for j, other in enumerate(patches):
                lines = one.lines_to(other) if i != j else None
                if lines is not None:
                    fixed[i][lines[0][0]] = lines[0][1]
        starts = [_start(self.patches[tag].surface, rough[None], tags[tag][None])[0] for tag in numbers]
        point, at = corner([patch.surface for patch in patches], np.array(starts), fixed)
        return _Corner(vertex(point), dict(zip(numbers, at)))

    def _edge(self, chain: Chain) -> tuple[Edge, float]:
        one, other = self.patch_of(chain.left), self.patch_of(chain.right)
        tags = int(self.regions.tag[chain.left]), int(self.regions.tag[chain.right])
        ends = [self.vertices[int(chain.path[k])] for k in (0, -1)]
        start, stop = (np.array(end.vertex.point) for end in ends)
        tolerance = EDGE_SHARE * self.tolerance
        if ends[0] is not ends[1] and float(np.linalg.norm(stop - start)) < TOGETHER * float(np.abs(start).max()):
            raise NotConverged(f"two corners of the body fall together at {start.round(6).tolist()} mm")
        lines = one.lines_to(other)
        if lines is not None:
            axis, value = lines[0]
            low, high = (end.at[tags[0]][1 - axis] for end in ends)
            plain = not any(isinstance(patch.written, SplineSurface) for patch in (one, other))
            curve, error = _line_on(one.surface, axis, value, float(low), float(high), start, stop, plain)
        else:
            rough = self.cut.vertices[chain.path].copy()
            rough[0], rough[-1] = start, stop
            guesses = []
            for patch, tag, at in ((one, tags[0], chain.at_left), (other, tags[1], chain.at_right)):
                guess = _start(patch.surface, rough, at)
                guess[0], guess[-1] = ends[0].at[tag], ends[1].at[tag]
                guesses.append(guess)
            curve, error = SurfaceCrossing((one.surface, other.surface), rough, *guesses).fit(tolerance)
        return Edge(curve, ends[0].vertex, ends[1].vertex), error

    def _face(self, region: int, edges: list[Edge]) -> Face:
        patch = self.patch_of(region)
        loops = [tuple(Use(edges[number], forward) for number, forward in ring) for ring in self.regions.loops[region]]
        same = self._same_sense(region, patch.written)
        if len(loops) > 1:
            loops.sort(key=lambda loop: -abs(_enclosed(patch.written, loop)))
        return Face(patch.name, patch.written, tuple(loops), same)

    def _same_sense(self, region: int, surface: Surface) -> bool:
        """Whether the surface's normal points out of the body, at the region's largest triangle."""
        triangles = np.nonzero(self.regions.owner == region)[0]
        corners = self.cut.vertices[self.cut.faces[triangles]]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        largest = int(np.argmax((normals * normals).sum(axis=1)))
        _, xu, xv = surface.jet(*surface.locate(corners[largest].mean(axis=0)[None]))
        return bool(np.cross(xu[0], xv[0]) @ normals[largest] > 0.0)


@final
@immutable
class _Corner:
    """A vertex and its parameters on each patch."""

    vertex: Vertex
    at: dict[int, Floats]


def _start(surface: Surface, points: Floats, known: Floats) -> Floats:
    """Parameters (n, 2) to start from: those carried by the mesh on a spline, the nearest point on anything else."""
    if isinstance(surface, SplineSurface):
        return known.copy()
    return np.stack(surface.locate(points), axis=1)


def _line_on(
    surface: Surface, axis: int, value: float, low: float, high: float, start: Floats, stop: Floats, plain: bool
) -> tuple[Curve, float]:
    """The curve of one constant parameter between two values of the other, and its deviation in mm; a line or circle
    where it is one and both of its faces are `plain`."""
    if isinstance(surface, SplineSurface):
        return iso_curve(surface, axis, value, low, high, plain), 0.0
    if isinstance(surface, Torus):
        high = low + (high - low + pi) % (2.0 * pi) - pi

    def point(share: Floats) -> Floats:
        at = [low * (1.0 - share) + high * share] * 2
        at[axis] = np.full(len(share), value)
        return surface.jet(*at)[0]

    return fit_curve(point, start, stop, 1e-9)


def _enclosed(surface: Surface, loop: Loop) -> float:
    """Area in parameters (or over them, on a surface of revolution) that a loop encloses."""
    points = np.concatenate([(p if use.forward else p[::-1])[:-1] for use in loop for p in (use.edge.points(9),)])
    u, v = surface.locate(points)
    if isinstance(surface, Cone | Torus):
        u, v = np.unwrap(u), np.unwrap(v) if isinstance(surface, Torus) else v
    return float((u * np.roll(v, -1) - np.roll(u, -1) * v).sum()) / 2.0


def _cut_angles(body: IndexingCut | CutBlank, sag: float) -> tuple[Floats, Floats]:
    """Angles in rad at which the blank's surfaces of revolution and its bore are cut: mesh vertices away from knots."""
    x, y, _ = body.blank.mesh(sag).vertices.T
    around, rho = np.arctan2(y, x), np.hypot(x, y)
    knots = np.concatenate([-track.sense * track.knots() for track in body.tracks])
    bore = body.blank.bore
    limit = bore.reach + 1e-6 if bore is not None else 0.0
    outer = distinct(np.round(np.mod(around[rho > limit], 2.0 * pi), 12))
    best = max(
        (np.array([outer[(j + s * len(outer) // SECTORS) % len(outer)] for s in range(SECTORS)]) for j in
         range(len(outer) // SECTORS)),
        key=lambda cuts: float(np.abs((cuts[:, None] - knots + pi) % (2.0 * pi) - pi).min()),
    )
    if bore is None:
        return np.sort(best), np.sort(best)
    inner = distinct(np.round(np.mod(around[np.abs(rho - 0.5 * bore.diameter) < 1e-9], 2.0 * pi), 12))
    start = keyway_start(bore)
    first = 0.0 if start else float(inner[len(inner) // 7])
    wanted = first + np.arange(1, SECTORS) * 2.0 * pi / SECTORS
    nearest = inner[np.argmin(np.abs((wanted[:, None] - inner + pi) % (2.0 * pi) - pi), axis=1)]
    return np.sort(best), np.sort(np.append(nearest, first))
