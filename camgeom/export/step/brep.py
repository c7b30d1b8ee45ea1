"""A boundary representation small enough to read: vertices, edges shared by two faces, loops, faces, solids.

Everything is frozen; a vertex or an edge is shared by being the same object. An edge runs along its curve from start to
end. A face's outward normal is its surface's normal (u x v), reversed where `same_sense` is False; seen against it
(from outside) the outer loop runs counter-clockwise and the inner loops clockwise. All lengths in mm.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import pi
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.export import Colour
from camgeom.export.step.geometry import WORLD, Circle, Curve, Frame, Line, SplineCurve, Surface, Vector, vector
from camgeom.immutable import immutable
from camgeom.maths import Floats, gauss_rule
from camgeom.maths.frozen import cached_property
from camgeom.maths.mesh import Mesh


@final
@immutable
class Vertex:
    """A corner, mm; shared by identity."""

    point: Vector


@final
@immutable
class Edge:
    """A piece of a curve from one vertex to another along the curve's own direction; shared by identity.

    A full circle has the same vertex at both ends. A spline curve is used from end to end.
    """

    curve: Curve
    start: Vertex
    end: Vertex

    @cached_property
    def interval(self) -> tuple[float, float]:
        """Parameters of the curve at start and end, ascending."""
        if isinstance(self.curve, SplineCurve):
            return self.curve.basis.start, self.curve.basis.stop
        ends = np.array([self.start.point, self.end.point])
        low, high = (float(t) for t in self.curve.locate(ends))
        if isinstance(self.curve, Circle) and high <= low + 1e-12:
            high += 2.0 * pi
        return low, high

    def points(self, count: int) -> Floats:
        """Points (count, 3) mm, evenly spaced in the parameter, both ends included."""
        return self.curve.at(np.linspace(*self.interval, count))

    def quadrature(self, nodes: int = 6) -> tuple[Floats, Floats]:
        """Gauss nodes and weights in the parameter (n,) along the edge; nodes: how many in each span of a spline."""
        if isinstance(self.curve, SplineCurve):
            return gauss(self.curve.basis.breaks, nodes)
        return gauss(np.linspace(*self.interval, 2), 4 if isinstance(self.curve, Line) else 40)


@final
@immutable
class Use:
    """An edge as a loop passes it: from start to end where forward, else from end to start."""

    edge: Edge
    forward: bool = True

    @property
    def first(self) -> Vertex:
        """Vertex where the pass begins."""
        return self.edge.start if self.forward else self.edge.end

    @property
    def last(self) -> Vertex:
        """Vertex where the pass ends."""
        return self.edge.end if self.forward else self.edge.start

    def reversed(self) -> Use:
        """The same edge passed the other way."""
        return Use(self.edge, not self.forward)


Loop = tuple[Use, ...]


def reversed_loop(loop: Loop) -> Loop:
    """The loop run the other way."""
    return tuple(use.reversed() for use in reversed(loop))


@final
@immutable
class Face:
    """A named piece of surface: loops[0] is the outer one."""

    name: str
    surface: Surface
    loops: tuple[Loop, ...]
    same_sense: bool = True


@final
@immutable
class Brep:
    """A closed shell of faces with a name; colour and density (kg/mm³) where given.

    deviation  largest distance in mm of its fitted curves and surfaces from the exact shape, as measured
    """

    name: str
    faces: tuple[Face, ...]
    colour: Colour | None = None
    density: float | None = None
    deviation: float = 0.0

    def edges(self) -> tuple[Edge, ...]:
        """Every edge once, in the order of first use."""
        return tuple({use.edge: None for use in self.uses()})

    def uses(self) -> Iterator[Use]:
        """Every pass of every loop."""
        for face in self.faces:
            for loop in face.loops:
                yield from loop


@final
@immutable
class FacetBody:
    """A body known only as triangles: its name and its mesh, whose face groups become faces.

    deviation  largest distance in mm of the triangles from the exact shape; reason: why there are no exact faces
    """

    name: str
    mesh: Mesh
    deviation: float = 0.0
    reason: str = ""


@final
@immutable
class Placed:
    """A body in an assembly: where its origin and axes go, and the name of this occurrence (default: the body's)."""

    body: Brep | FacetBody
    frame: Frame = WORLD
    name: str = ""


@final
@immutable
class Assembly:
    """Bodies with placements; the same body may be placed several times and is then written once."""

    name: str
    parts: tuple[Placed, ...]


def vertex(point: npt.ArrayLike) -> Vertex:
    """A vertex at three coordinates, mm."""
    return Vertex(vector(point))


def gauss(breaks: Floats, order: int) -> tuple[Floats, Floats]:
    """Gauss-Legendre nodes and weights of `order` points in each interval between the breaks."""
    x, w = gauss_rule(order)
    half = 0.5 * np.diff(breaks)[:, None]
    middle = 0.5 * (breaks[1:] + breaks[:-1])[:, None]
    return (middle + half * x).ravel(), (half * w).ravel()
