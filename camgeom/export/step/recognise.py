"""Recognise the elementary curve or surface behind exact points: line, circle; plane, cylinder, cone, torus.

A shape counts as elementary where every exact point lies on it within EXACT, far below any export tolerance, so that
replacing the spline by it changes nothing and the file says "plane" where the part has a plane.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import atan2

import numpy as np

from camgeom.export.step.geometry import (
    Circle,
    Cone,
    Curve,
    Frame,
    Line,
    Plane,
    SplineCurve,
    SplineSurface,
    Surface,
    Torus,
    cross,
    largest_gap,
    unit,
    vector,
)
from camgeom.maths import Floats
from camgeom.maths.splines import Basis

EXACT = 1e-9
"""mm"""
NARROW = 1e-6
"""mm; of a strip narrower than this rounding says how it is inclined"""


def curve_of(basis: Basis, poles: Floats, exact: Floats) -> Curve:
    """The line or circle that the exact points (n, 3) run along, else the spline through them."""
    chord = exact[-1] - exact[0]
    length = float(np.sqrt(chord @ chord))
    if length > EXACT:
        line = Line(vector(exact[0]), unit(chord))
        if largest_gap(line.at(line.locate(exact)), exact) < EXACT:
            return line
    circle = circle_through(exact)
    return circle if circle is not None else SplineCurve(basis, poles)


def circle_through(points: Floats) -> Circle | None:
    """The circle through points (n, 3) of an arc, counter-clockwise as they run, or None where they are on none."""
    a, b, c = points[0], points[len(points) // 3], points[(2 * len(points)) // 3]
    p, q = b - a, c - a
    normal = cross(p, q)
    size = float(normal @ normal)
    if size < 1e-16 * max(float(p @ p), float(q @ q)) ** 2:
        return None
    centre = a + cross((p @ p) * q - (q @ q) * p, normal) / (2.0 * size)
    axis = _snapped_axis(normal / np.sqrt(size))
    centre[np.abs(centre) < 1e-11] = 0.0
    radius = float(np.sqrt(((points - centre) ** 2).sum(axis=1)).mean())
    ref = points[0] - centre
    ref = ref - (ref @ axis) * axis
    circle = Circle(Frame(vector(centre), vector(axis), unit(ref)), radius)
    return circle if largest_gap(circle.at(circle.locate(points)), points) < EXACT else None


def surface_of(
    spline: SplineSurface, exact: Floats, rails: tuple[Curve | None, Curve | None], candidates: Iterable[Surface]
) -> Surface:
    """The elementary surface that all exact points (k, 3) lie on, the first of the candidates that fits, else spline.

    rails: the boundary curves along u; where both are circles about one axis the surface may be one of revolution.
    A strip narrower than NARROW stays the spline: as a piece of anything else its borders may cross within rounding.
    """
    if _breadth(spline.poles) < NARROW:
        return spline
    few = exact[:: max(1, len(exact) // 16)]
    for candidate in candidates:
        if lies_on(candidate, few) and lies_on(candidate, exact):
            return candidate
    plane = _plane_through(few) and _plane_through(exact)
    if plane is not None:
        return plane
    circles = [rail for rail in rails if isinstance(rail, Circle)]
    if len(circles) == 2:
        turned = _revolution_through(circles[0].frame, exact)
        if turned is not None:
            return turned
    return spline


def _breadth(poles: Floats) -> float:
    """Largest distance in mm from poles (n, m, 3) of the first border along u to those of the last, across the way
    that the border runs."""
    gap, way = poles[:, -1] - poles[:, 0], np.gradient(poles[:, 0], axis=0)
    length = np.maximum((way * way).sum(axis=1), 1e-300)
    across = gap - ((gap * way).sum(axis=1) / length)[:, None] * way
    return float(np.sqrt((across * across).sum(axis=1)).max())


def lies_on(surface: Surface, points: Floats) -> bool:
    """Whether all points (k, 3) are on an elementary surface within EXACT."""
    if isinstance(surface, SplineSurface):
        return False
    return largest_gap(surface.jet(*surface.locate(points))[0], points) < EXACT


def _plane_through(points: Floats) -> Plane | None:
    centre = points.mean(axis=0)
    spread = points - centre
    values, axes = np.linalg.eigh(spread.T @ spread)
    if values[1] < 1e-18 * values[2]:
        return None
    normal = _snapped_axis(axes[:, 0])
    plane = Plane(Frame.about(vector((centre @ normal) * normal), normal))
    return plane if lies_on(plane, points) else None


def _revolution_through(frame: Frame, points: Floats) -> Cone | Torus | None:
    """Cone (or cylinder) or torus about the frame's axis from the half-plane coordinates of the points."""
    q = frame.local(points)
    rho, z = np.hypot(q[:, 0], q[:, 1]), q[:, 2]
    meridian = np.stack([rho, z], axis=1)
    centre = meridian.mean(axis=0)
    _, _, axes = np.linalg.svd(meridian - centre, full_matrices=False)
    if float(np.abs((meridian - centre) @ axes[1]).max()) < EXACT:
        return _cone(frame, centre, axes[0])
    order = np.argsort((meridian - centre) @ axes[0])
    arc = circle_through(np.column_stack([meridian[order], np.zeros(len(order))]))
    if arc is None:
        return None
    major, height, _ = arc.frame.origin
    torus = Torus(_lifted(frame, height), major, arc.radius)
    return torus if major > arc.radius and lies_on(torus, points) else None


def _cone(frame: Frame, centre: Floats, direction: Floats) -> Cone:
    """Cone through (rho, z) along the direction; its axis points where it widens, as STEP demands."""
    across, along = float(direction[0]), float(direction[1])
    if abs(across) < 1e-12:
        return Cone(_lifted(frame, 0.0), float(centre[0]))
    if across < 0.0:
        across, along = -across, -along
    lifted = _lifted(frame, float(centre[1]))
    if along < 0.0:
        lifted = Frame(lifted.origin, vector(-np.array(lifted.axis)), lifted.ref)
    return Cone(lifted, float(centre[0]), atan2(across, abs(along)))


def _lifted(frame: Frame, height: float) -> Frame:
    return Frame(vector(np.array(frame.origin) + height * np.array(frame.axis)), frame.axis, frame.ref)


def _snapped_axis(axis: Floats) -> Floats:
    """The axis with rounding noise removed where it is along X, Y or Z."""
    snapped = np.where(np.abs(axis) < 1e-13, 0.0, axis)
    return np.asarray(snapped / np.sqrt(snapped @ snapped))
