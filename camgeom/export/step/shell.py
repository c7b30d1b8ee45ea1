"""Shells: bands of exact surface points stacked round a closed parameter phi, turned into faces that share edges.

Every body of this package is made of shells. A band gives exact points at (phi, share), share 0 to 1 across it; the
last row of one band is the first of the next. Knots cut phi where a derivative jumps. All patches between two knots
share one basis along phi and all patches of a band one basis across, so neighbours share their boundary poles exactly:
no sewing. A band that shrinks to nothing at a knot ends in a point there, and where it is nothing all along it is left
out. Patches that turn out to be planes, cylinders, cones or tori are written as such, and joined over knots.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import final

import numpy as np

from camgeom.errors import DesignError, NotConverged
from camgeom.export.step.brep import Edge, Face, Loop, Use, Vertex, reversed_loop, vertex
from camgeom.export.step.geometry import MEET, Cone, Curve, Plane, SplineCurve, SplineSurface, Surface, Torus, cross
from camgeom.export.step.recognise import curve_of, surface_of
from camgeom.export.step.spline import FIRST_SPANS, SurfaceFit, SurfacePoints, fit_bands
from camgeom.immutable import immutable
from camgeom.maths import Floats

NOTHING = 1e-7
"""mm; a band narrower than this everywhere is left out, at a knot it ends in a point"""
WIDEST = 5.5
"""rad; faces on surfaces of revolution are joined over knots up to this angle, so none needs a seam"""


@final
@immutable
class ShellBand:
    """One band of a shell.

    name        of its faces; a tuple names each interval between the knots
    point       exact points: phi (n,) and share (m,) -> (n, m, 3) mm
    degree      of the spline across the band (1 where it is straight across)
    candidates  elementary surfaces it may lie on
    """

    name: str | tuple[str, ...]
    point: SurfacePoints
    degree: int = 5
    candidates: tuple[Surface, ...] = ()

    def label(self, interval: int) -> str:
        """Face name in one interval between knots."""
        return self.name if isinstance(self.name, str) else self.name[interval]


@final
@immutable
class Shell:
    """Faces of a closed shell, its first and last rail as loops the neighbouring faces must pass, and the deviation."""

    faces: tuple[Face, ...]
    first: Loop
    last: Loop
    deviation: float


def shell(bands: Sequence[ShellBand], knots: Floats, outward: float, tolerance: float) -> Shell:
    """Faces of bands round a closed parameter.

    knots      (k,) ascending; the last is one period after the first
    outward    +1 where (d/dphi) x (d/dshare) points out of the material, -1 where it points in
    tolerance  mm between the exact points and every fitted curve and surface
    Raises NotConverged where a band has a kink between knots, DesignError where patches do not meet at a knot.
    """
    if len(knots) == 2:  # a face that closed on itself would need a seam
        knots = np.array([knots[0], 0.5 * (knots[0] + knots[1]), knots[1]])
    patches = fitted(bands, knots, tolerance)
    net = _Net(bands, patches)
    faces = [face for k in range(len(bands)) for face in _band_faces(net, k, outward)]
    deviation = max(fit.deviation for row in patches for fit in row)
    first, last = net.rail_loop(0), net.rail_loop(len(bands))
    ends = (reversed_loop(first), last) if outward > 0.0 else (first, reversed_loop(last))
    return Shell(tuple(faces), *ends, deviation)


def fitted(bands: Sequence[ShellBand], knots: Floats, tolerance: float) -> list[list[SurfaceFit]]:
    """Fits by band and interval: one basis along phi in each interval, one across in each band."""
    points, degrees = [band.point for band in bands], [band.degree for band in bands]
    intervals = list(pairwise(knots.tolist()))
    columns: list[list[SurfaceFit]] = []
    most = [1] * len(bands)
    for interval in intervals:
        columns.append(fit_bands(points, degrees, interval, tolerance, (FIRST_SPANS, most)))
        most = [fit.spans[1] for fit in columns[-1]]
    for i, column in enumerate(columns):
        along = column[0].spans[0]
        if [fit.spans[1] for fit in column] == most:
            continue
        columns[i] = fit_bands(points, degrees, intervals[i], tolerance, (along, most))
        if [fit.spans[1] for fit in columns[i]] != most:
            raise NotConverged("a spline fit gets worse when it is refined; allow a larger tolerance")
    return [[column[k] for column in columns] for k in range(len(bands))]


@final
class _Net:
    """Vertices and edges of a shell, each made once."""

    def __init__(self, bands: Sequence[ShellBand], fits: list[list[SurfaceFit]]) -> None:
        self.bands, self.fits = bands, fits
        self.count = len(fits[0])
        self.widths = np.array([[_width(fit) for fit in row] for row in fits])
        self._meet()
        self.vertices = self._make_vertices()
        curves = self._rail_curves()
        self.groups = [_groups(self, k, curves) for k in range(len(bands))]
        self.rails = self._make_rails(curves)
        self.sides = [[self._side(k, i) for i in range(self.count)] for k in range(len(bands))]

    def empty(self, band: int, interval: int) -> bool:
        """True where the band is nothing between two knots."""
        return bool(self.widths[band, interval].max() < NOTHING)

    def _meet(self) -> None:
        for k, row in enumerate(self.fits):
            for i in range(self.count):
                gap = float(np.abs(row[i].poles[0] - row[i - 1].poles[-1]).max())
                if gap > MEET:
                    raise DesignError(
                        f"face {self.bands[k].label(i)!r}: patches are {gap:.3g} mm apart at the knot "
                        f"{row[i].u.start:.6g} rad; the motion must be smooth there for a closed body"
                    )

    def _make_vertices(self) -> list[list[Vertex]]:
        """Vertices by rail and knot; rails that meet at a knot share one."""
        first = [vertex(fit.poles[0, 0]) for fit in self.fits[0]]
        rails = [first]
        for k, row in enumerate(self.fits):
            rails.append(
                [
                    rails[-1][i] if self.widths[k, i][0] < NOTHING else vertex(fit.poles[0, -1])
                    for i, fit in enumerate(row)
                ]
            )
        return rails

    def _rail_curves(self) -> list[list[Curve]]:
        """Curves by rail and interval; a band that is nothing has one for both of its rails."""
        curves: list[list[Curve]] = []
        for r in range(len(self.bands) + 1):
            row = []
            for i in range(self.count):
                if r > 0 and self.empty(r - 1, i):
                    row.append(curves[r - 1][i])
                    continue
                fit, column = self._rail_fit(r, i)
                row.append(curve_of(fit.u, fit.poles[:, column], fit.exact[:, column]))
            curves.append(row)
        return curves

    def _rail_fit(self, r: int, i: int) -> tuple[SurfaceFit, int]:
        """The fit that a rail is taken from, and the column of its poles."""
        return self.fits[min(r, len(self.bands) - 1)][i], 0 if r < len(self.bands) else -1

    def _make_rails(self, curves: list[list[Curve]]) -> list[list[Edge]]:
        """Edges by rail and interval. Beside a spline face an edge is the border of that face and nothing else, however
        nearly a line or a circle: so its parameter is the face's, and the file can say where in the face it runs."""
        rails: list[list[Edge]] = []
        for r in range(len(self.bands) + 1):
            row = []
            for i in range(self.count):
                if r > 0 and self.empty(r - 1, i):
                    row.append(rails[r - 1][i])
                    continue
                curve = curves[r][i]
                above = next((k for k in range(r, len(self.bands)) if not self.empty(k, i)), None)
                if (r > 0 and self._splined(r - 1, i)) or (above is not None and self._splined(above, i)):
                    fit, column = self._rail_fit(r, i)
                    curve = SplineCurve(fit.u, fit.poles[:, column])
                row.append(Edge(curve, self.vertices[r][i], self.vertices[r][(i + 1) % self.count]))
            rails.append(row)
        return rails

    def _splined(self, k: int, i: int) -> bool:
        """Whether the face of a band between two knots is a spline."""
        return any(i in members and isinstance(surface, SplineSurface) for surface, members in self.groups[k])

    def _side(self, k: int, i: int) -> Edge | None:
        """Edge across band k at knot i, or None where the band ends in a point there."""
        start, end = self.vertices[k][i], self.vertices[k + 1][i]
        if start is end:
            return None
        fit = self.fits[k][i]
        if self._splined(k, i) or self._splined(k, (i - 1) % self.count):
            return Edge(SplineCurve(fit.v, fit.poles[0]), start, end)
        return Edge(curve_of(fit.v, fit.poles[0], fit.exact[0]), start, end)

    def rail_loop(self, r: int) -> Loop:
        """The rail as a loop in the direction of phi."""
        return tuple(Use(edge) for edge in self.rails[r])


def _width(fit: SurfaceFit) -> Floats:
    """Distance between the two rails at the first knot and at its largest, mm: (2,)."""
    gap = fit.poles[:, -1] - fit.poles[:, 0]
    size = np.sqrt((gap * gap).sum(axis=1))
    return np.array([size[0], size.max()])


def _band_faces(net: _Net, k: int, outward: float) -> list[Face]:
    """Faces of band k; neighbours on one elementary surface and of one name are joined."""
    return [_face(net, k, surface, members, outward) for surface, members in net.groups[k]]


def _groups(net: _Net, k: int, curves: list[list[Curve]]) -> list[tuple[Surface, list[int]]]:
    """Surfaces of band k, each with the intervals it goes over."""
    band = net.bands[k]
    groups: list[tuple[Surface, list[int], float]] = []
    for i, fit in enumerate(net.fits[k]):
        if net.empty(k, i):
            continue
        spline = SplineSurface(fit.u, fit.v, fit.poles)
        last = groups[-1] if groups and groups[-1][1][-1] == i - 1 and band.label(i - 1) == band.label(i) else None
        tried = (*band.candidates, *((last[0],) if last and last[0] not in band.candidates else ()))
        surface = surface_of(spline, fit.exact.reshape(-1, 3), (curves[k][i], curves[k + 1][i]), tried)
        angle = _turned(surface, fit)
        if last and surface is last[0] and last[2] + angle < WIDEST:
            last[1].append(i)
            groups[-1] = (surface, last[1], last[2] + angle)
        else:
            groups.append((surface, [i], angle))
    return [(surface, members) for surface, members, _ in groups]


def _turned(surface: Surface, fit: SurfaceFit) -> float:
    """Angle in rad that a patch goes round a surface of revolution; 0 on a plane, beyond any limit on a spline."""
    if isinstance(surface, Plane):
        return 0.0
    if not isinstance(surface, Cone | Torus):
        return float("inf")
    angle = np.unwrap(surface.locate(fit.poles[:, 0])[0])
    return float(np.abs(angle - angle[0]).max())


def _face(net: _Net, k: int, surface: Surface, members: list[int], outward: float) -> Face:
    band, first, stop = net.bands[k], members[0], (members[-1] + 1) % net.count
    low = [Use(net.rails[k][i]) for i in members]
    high = [Use(net.rails[k + 1][i], False) for i in reversed(members)]
    sides = net.sides[k][stop], net.sides[k][first]
    right = [Use(sides[0])] if sides[0] else []
    left = [Use(sides[1], False)] if sides[1] else []
    loops: tuple[Loop, ...] = ((*low, *right, *high, *left),)
    if len(members) == net.count:
        loops = _two_loops(tuple(low), tuple(high))
    if outward < 0.0:
        loops = tuple(reversed_loop(loop) for loop in loops)
    same = _agrees(surface, net.fits[k][first]) == (outward > 0.0)
    return Face(band.label(first), surface, loops, same)


def _two_loops(low: Loop, high: Loop) -> tuple[Loop, ...]:
    """The outer loop of a flat ring first: the longer one."""
    return (low, high) if _length(low) > _length(high) else (high, low)


def _length(loop: Loop) -> float:
    return sum(float(np.sqrt((np.diff(use.edge.points(17), axis=0) ** 2).sum(axis=1)).sum()) for use in loop)


def _agrees(surface: Surface, fit: SurfaceFit) -> bool:
    """Whether the surface's normal points along (d/dphi) x (d/dshare) in the middle of the patch."""
    if isinstance(surface, SplineSurface):
        return True
    i, j = len(fit.exact) // 2, fit.exact.shape[1] // 2
    x, ahead, beside = fit.exact[i, j], fit.exact[i + 1, j], fit.exact[i, j + 1]
    _, su, sv = surface.jet(*surface.locate(x[None]))
    return bool(cross(ahead - x, beside - x) @ cross(su[0], sv[0]) > 0.0)
