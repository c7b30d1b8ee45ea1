"""Patches: the analytic surfaces a cut body is made of, each with the rectangle of parameters it is used in.

A groove body is a shell of patches: bands across the groove, cut at the knots of the motion. Neighbours in a shell meet
along a line of constant parameter and share its points exactly. The blank's surfaces of revolution are cut into
sectors, so that no face closes on itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import asin, atan2, nan, pi
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.export.step.geometry import WORLD, Cone, Frame, Plane, SplineSurface, Surface, Torus
from camgeom.export.step.recognise import curve_of, surface_of
from camgeom.export.step.shell import ShellBand, fitted
from camgeom.export.step.spline import SurfaceFit
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.frozen import cached_property
from camgeom.solid.blank import Blank, Bore

Box = tuple[tuple[float, float], tuple[float, float]]
NOWHERE: Box = ((nan, nan), (nan, nan))
"""of a patch that meets no neighbour along a line of constant parameter"""
SECTORS = 3
"""faces round a surface of revolution"""


@final
@immutable
class Patch:
    """One analytic surface of a body.

    surface  as crossings are computed on it; written: as the file shows it (the same, or what it was recognised as)
    shell    number of the shell it belongs to, and its cell there (along, across); period: cells round the shell
    box      the parameters ((u0, u1), (v0, v1)) at which it meets its neighbours in the shell
    deviation  mm, of the fitted surface from the exact one
    """

    name: str
    surface: Surface
    written: Surface
    shell: int
    cell: tuple[int, int] = (0, 0)
    period: int | None = None
    box: Box = NOWHERE
    deviation: float = 0.0

    def lines_to(self, other: Patch) -> tuple[tuple[int, float], tuple[int, float]] | None:
        """Where a neighbour of the same shell meets this one: (axis, value) here and there; None where it is none."""
        if other.shell != self.shell:
            return None
        along, across = other.cell[0] - self.cell[0], other.cell[1] - self.cell[1]
        if self.period is not None and abs(along) == self.period - 1:
            along = -1 if along > 0 else 1
        if (abs(along), abs(across)) not in ((1, 0), (0, 1)):
            return None
        axis = 0 if along else 1
        ahead = (along or across) > 0
        return (axis, self.box[axis][1 if ahead else 0]), (axis, other.box[axis][0 if ahead else 1])


@final
@immutable
class GrooveBody:
    """The patches of one groove body: fits by band and interval; a fit is None where its band is nothing there."""

    fits: tuple[tuple[SurfaceFit, ...], ...]
    knots: Floats
    closed: bool
    patches: tuple[Patch, ...]
    first: int
    """index of patches[0] among all patches of the body"""

    @cached_property
    def numbers(self) -> npt.NDArray[np.int64]:
        """Number of the patch of each band and interval, (bands, intervals)."""
        return self.first + np.arange(len(self.patches)).reshape(len(self.fits), -1)


def groove_body(
    bands: Sequence[ShellBand], knots: Floats, closed: bool, shell: int, first: int, tolerance: float
) -> GrooveBody:
    """Fit the bands of a groove body between its knots, each within `tolerance` mm. Raises as `shell.fitted`."""
    if closed and len(knots) < 4:
        knots = distinct(np.concatenate([knots, np.linspace(knots[0], knots[-1], 4)]))
    fits = fitted(bands, knots, tolerance)
    period = len(knots) - 1 if closed else None
    patches = []
    for k, (band, row) in enumerate(zip(bands, fits)):
        for i, fit in enumerate(row):
            spline = SplineSurface(fit.u, fit.v, fit.poles)
            rails = tuple(curve_of(fit.u, fit.poles[:, c], fit.exact[:, c]) for c in (0, -1))
            written = surface_of(spline, fit.exact.reshape(-1, 3), (rails[0], rails[1]), band.candidates)
            box = (fit.u.start, fit.u.stop), (0.0, 1.0)
            patches.append(Patch(band.label(i), spline, written, shell, (i, k), period, box, fit.deviation))
    return GrooveBody(tuple(tuple(row) for row in fits), knots, closed, tuple(patches), first)


def blank_patches(blank: Blank, cuts: Floats, bore_cuts: Floats, shell: int) -> list[Patch]:
    """The blank's surfaces: outline, flat ends, bore and keyway.

    cuts, bore_cuts  (SECTORS,) ascending angles in rad at which surfaces of revolution, and the bore, are cut
    """
    arcs = blank.arcs or (None,) * (len(blank.outline) - 1)
    names = blank.names or ("land",) * (len(blank.outline) - 1)
    found: list[Patch] = []
    for (start, stop), arc, name in zip(pairwise(blank.outline), arcs, names):
        surface = _turned(start, stop, arc)
        found += _sectors(name, surface, cuts, shell + len(found))
    z0, z1 = blank.outline[0][1], blank.outline[-1][1]
    found += [_flat("end", (0.0, 0.0, z), (0.0, 0.0, d), shell + len(found) + j) for j, (z, d) in
              enumerate(((z0, -1.0), (z1, 1.0)))]
    if blank.bore is not None:
        found += _bore(blank.bore, bore_cuts, shell + len(found))
    return found


def _turned(start: tuple[float, float], stop: tuple[float, float], arc: tuple[float, float] | None) -> Surface:
    """The surface of revolution through one edge (r, z) of the outline."""
    (r0, z0), (r1, z1) = start, stop
    if arc is not None:
        return Torus(Frame((0.0, 0.0, arc[1])), arc[0], float(np.hypot(r0 - arc[0], z0 - arc[1])))
    if z0 == z1:
        return Plane(Frame.about((0.0, 0.0, z0), (0.0, 0.0, 1.0 if r1 < r0 else -1.0)))
    if r0 == r1:
        return Cone(WORLD, r0)
    up = 1.0 if (r1 - r0) * (z1 - z0) > 0.0 else -1.0
    return Cone(Frame((0.0, 0.0, z0), (0.0, 0.0, up)), r0, atan2(abs(r1 - r0), abs(z1 - z0)))


def _flat(name: str, origin: tuple[float, float, float], axis: tuple[float, float, float], shell: int) -> Patch:
    plane = Plane(Frame.about(origin, axis))
    return Patch(name, plane, plane, shell)


def _sectors(name: str, surface: Surface, cuts: Floats, shell: int) -> list[Patch]:
    """A plane as one patch, a surface of revolution as sectors between the cuts."""
    if isinstance(surface, Plane):
        return [Patch(name, surface, surface, shell)]
    assert not isinstance(surface, SplineSurface)
    turn = surface.frame.axis[2]
    ends = np.append(cuts, cuts[0] + 2.0 * pi)
    return [
        Patch(name, surface, surface, shell, (s, 0), len(cuts), ((turn * a, turn * b), NOWHERE[1]))
        for s, (a, b) in enumerate(pairwise(ends.tolist()))
    ]


def _bore(bore: Bore, cuts: Floats, shell: int) -> list[Patch]:
    found = _sectors("bore", Cone(WORLD, 0.5 * bore.diameter), cuts, shell)
    if bore.keyway_width:
        half, top = 0.5 * bore.keyway_width, 0.5 * bore.diameter + bore.keyway_depth
        walls = (((0.0, -half, 0.0), (0.0, 1.0, 0.0)), ((top, 0.0, 0.0), (-1.0, 0.0, 0.0)),
                 ((0.0, half, 0.0), (0.0, -1.0, 0.0)))
        found += [_flat("keyway", origin, axis, shell + 1 + j) for j, (origin, axis) in enumerate(walls)]
    return found


def keyway_start(bore: Bore | None) -> float:
    """Angle in rad at which a bore's round part begins beside its keyway; 0 without one."""
    return asin(bore.keyway_width / bore.diameter) if bore is not None and bore.keyway_width else 0.0
