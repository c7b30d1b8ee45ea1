"""How far the cam's body gives way below its contacts: what the formulas of contact leave out.

A contact's formula holds the cam as a half-space down to a depth of its own: a line contact as deep as the roller is
thick (`mechanics.hertz.line_flexibility`), an ellipse and a half-space that is solved without end. The flank's
deflection on a mesh holds the same part once more, as well as the mesh can, so it is not taken. Taken is the
displacement u at a depth z below the contact, less what the formula's half-space moves there against its own depth,
along the force F:

    c = sum F (u(z) - w(z)) / (sum F)^2

w on the axis of a line load q: 2 q (1 - nu^2) / (pi E) ln(depth / z) (Johnson, Contact Mechanics, section 2.3, with
sigma_x = 0 on the axis); of point forces F: (1 + nu) / (2 pi E) F (z^2 / rho^3 + 2 (1 - nu) / rho) (section 3.2). c
does not hang on z where z is some elements deep. Where the body is thinner than the formula takes it, c may be below 0.
The shares of the load along the rollers are those on a rigid body.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib.util import find_spec
from typing import final

import numpy as np

from camgeom.body.element import elasticity
from camgeom.body.end_face import EndFaceSection
from camgeom.body.groove import groove_of
from camgeom.body.load import (
    LoadPatch,
    RollerForce,
    RollerLoad,
    disc_patch,
    nodal_forces,
    plate_patch,
)
from camgeom.body.plate import PlateSection
from camgeom.body.rib import RibSection
from camgeom.body.ring import RingMesh, SweptSection, even_planes, ring_of
from camgeom.body.section import Fineness, GroovedSection
from camgeom.body.solver import elastic
from camgeom.body.sparse_solver import AT_ONCE, SparseElastic
from camgeom.body.tetra import NEEDS, PointLoad, TetraMesh, filled, solid_cut
from camgeom.body.volume import NO_LOAD, unfilled
from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.mesh import Mesh
from camgeom.mechanics.face_duty import FaceDuty
from camgeom.mechanics.material import Material
from camgeom.mechanics.roller_duty import RollerDuty
from camgeom.mechanics.turret_duty import TurretDuty
from camgeom.solid import Part
from camgeom.solid.cut import IndexingCut
from camgeom.solid.drum import EndFaceRing, RibbedCylinder
from camgeom.solid.prism import Prism
from camgeom.track import TURN, Track

NO_BELOW = "below the contacts of several tracks, plates that slide and undercut bodies nothing is solved"
PLANES = 72
"""planes of a ring's mesh, and cam angles at which it is loaded"""
ANGLES = 36
"""cam angles at which tetrahedra are loaded"""
DEPTHS = np.arange(1, 9) / 8.0
"""shares of the contact's own depth at which the body is asked; the deepest that is reached within it counts"""
OUTSIDE = 0.5
"""share of a contact's load that may press where there is no body an eighth of its depth below it, at a wall's edge"""
TOLERANCE = 1e-4
"""share of a load that its displacements may leave over"""


@final
@immutable(eq=True)
class Own:
    """What a contact's formula holds of the cam: down to a depth, mm, as a line, or as a half-space without end."""

    material: Material
    depth: float
    endless: bool

    def moved(self, load: PointLoad, down: Floats) -> Floats:
        """Displacement (p,), mm, at depths (p,) below the points of a load, along it, as the formula has it."""
        cam = self.material
        if not self.endless:
            return np.asarray(2.0 * cam.compliance / np.pi * load.density * np.log(self.depth / down))
        x = load.points + down[:, None] * load.inward
        away = x[:, None] - load.points
        rho = np.sqrt((away**2).sum(axis=2))
        below = np.einsum("pqi,qi->pq", away, load.inward)
        each = below**2 / rho**3 + 2.0 * (1.0 - cam.poisson) / rho
        return np.asarray((1.0 + cam.poisson) / (2.0 * np.pi * cam.elastic_modulus) * (each @ load.sizes))


@final
@immutable
class Below:
    """What the body below its contacts makes of them at cam angles (n,), rad.

    value  (n,) of a follower: compliance along the contact's normal, mm/N; of a turret: share of its contact stiffness
    that is left
    """

    theta: Floats
    value: Floats

    def at(self, theta: Floats) -> Floats:
        """Between the cam angles, rad, linearly."""
        return np.interp(theta % TURN, self.theta, self.value, period=TURN)


def sunk(mesh: RingMesh | TetraMesh, cell: str, moved: Floats, load: PointLoad, own: Own) -> Floats:
    """Work (k,), N mm, of a load on displacements (v, 3, k) of all nodes, mm, below its contacts; of the first of them,
    which is its own, less what the formula holds. Infinite where more than `OUTSIDE` of it presses a wall too thin to
    be asked: such an edge bears nothing.
    """
    import pyvista

    kind = {"hexahedron20": pyvista.CellType.QUADRATIC_HEXAHEDRON, "tetra10": pyvista.CellType.QUADRATIC_TETRA}[cell]
    grid = pyvista.UnstructuredGrid({kind: np.asarray(mesh.elements)}, np.asarray(mesh.nodes))
    grid.point_data["moved"] = moved.reshape(len(moved), -1)
    down = own.depth * DEPTHS
    places = load.points[:, None] + down[None, :, None] * load.inward[:, None]
    found = pyvista.PolyData(places.reshape(-1, 3)).sample(grid)
    inside = np.asarray(found["vtkValidPointMask"], dtype=bool).reshape(len(load.points), -1)
    reached = np.cumprod(inside, axis=1).sum(axis=1)
    some, sizes = reached > 0, np.abs(load.sizes)
    lost = float(sizes[~some].sum() / sizes.sum())
    if lost > OUTSIDE:
        return np.full(moved.shape[2], np.inf)
    deepest = np.maximum(reached, 1) - 1
    at = np.asarray(found["moved"]).reshape(*inside.shape, 3, -1)[np.arange(len(deepest)), deepest]
    along = np.einsum("pik,pi->pk", at, load.inward)
    along[:, 0] -= own.moved(load, down[deepest])
    return np.asarray((load.sizes[:, None] * along)[some].sum(axis=0) / (1.0 - lost))


@final
@immutable
class _Ring:
    """A section's ring, to be loaded; `of` gives the patch that a load is on its contour."""

    section: SweptSection
    of: Callable[[PointLoad], LoadPatch]
    own: Own

    def works(self, cases: Sequence[Sequence[PointLoad]]) -> list[Floats]:
        """Work (k, k) of every load of a case on what each of them moves."""
        ring = ring_of(self.section, even_planes(PLANES))
        every = [load for case in cases for load in case]
        solver = elastic(ring, self.own.material)
        moved = solver.solve(nodal_forces(ring, [[self.of(load)] for load in every]))
        starts = np.cumsum([0, *map(len, cases)])
        return [_each(ring, "hexahedron20", moved[:, :, a:b], case, self.own)
                for a, b, case in zip(starts[:-1], starts[1:], cases)]  # fmt: skip


@final
@immutable
class _Tetra:
    """A body of tetrahedra, to be loaded."""

    mesh: TetraMesh
    own: Own

    def works(self, cases: Sequence[Sequence[PointLoad]]) -> list[Floats]:
        """As `_Ring.works`."""
        mesh, cam = self.mesh, self.own.material
        solver = SparseElastic(mesh, elasticity(cam.elastic_modulus, cam.poisson))
        found, left = list[Floats](), list(cases)
        while left:
            # As many cases as are solved together.
            count = max(1, int(np.searchsorted(np.cumsum([len(case) for case in left]), AT_ONCE, "right")))
            some, left = left[:count], left[count:]
            loads = [mesh.spread(load.points, load.forces) for case in some for load in case]
            moved = solver.solve(np.stack(loads, axis=2), TOLERANCE) if loads else np.zeros((0, 3, 0))
            ends = np.cumsum([len(case) for case in some])
            found += [_each(mesh, "tetra10", each, case, self.own)
                      for each, case in zip(np.split(moved, ends[:-1], axis=2), some)]  # fmt: skip
        return found


def _each(mesh: RingMesh | TetraMesh, cell: str, moved: Floats, case: Sequence[PointLoad], own: Own) -> Floats:
    """Work (k, k) of loads on displacements (v, 3, k), each first of its own."""
    rows = []
    for i, load in enumerate(case):
        order = np.roll(np.arange(len(case)), -i)
        rows.append(np.roll(sunk(mesh, cell, moved[:, :, order], load, own), i))
    return np.array(rows)


def unmeshed(parts: Sequence[Part], cutters: tuple[Track, ...]) -> str:
    """Why nothing is known of what lies below the contacts of a body; empty where it is."""
    if all(isinstance(one, Prism) for one in parts) and not solid_cut(parts[0]):
        pair = len(parts) > 1 and len(cutters) == len(parts) == 2
        return "takes one pressed body, and a pair's two discs press in turn" if pair else ""
    if (isinstance(parts[0], IndexingCut) or solid_cut(parts[0])) and len(parts) == 1:
        return NEEDS if find_spec("pytetwild") is None else ""
    return f"needs the body's volume: {reason}" if (reason := unfilled(parts, cutters)) else ""


def below_rollers(
    part: Part, cutters: tuple[Track, ...], duties: Sequence[RollerDuty], drive: FaceDuty | None,
    surface: Callable[[], Mesh],
) -> Below:
    """The compliance below a follower's rollers at the cam angles at which they press, each its own flank of a rib.

    duties   the first is the hardest pressed, and the only one that counts but on a rib
    drive    forces of a planar cam's touch; surface: the body's mesh, asked for where it is no ring
    Raises DesignError where nothing presses the body, or it cannot be meshed.
    """
    if isinstance(part, RibbedCylinder) and len(duties) > 1:
        each = [below_rollers(part, cutters, [one], drive, surface) for one in duties]
        pressed, number = np.unique(np.concatenate([one.theta for one in each]), return_inverse=True)
        value = np.zeros(len(pressed))
        np.maximum.at(value, number, np.concatenate([one.value for one in each]))
        return Below(pressed, value)
    duty = duties[0]
    own, force = Own(duty.cam, 2.0 * duty.radius, duty.level != "line"), RollerForce(duty)
    rings = isinstance(part, EndFaceRing | RibbedCylinder | Prism) and not solid_cut(part)
    groove = groove_of(part, cutters)
    every = np.linspace(0.0, TURN, PLANES if rings or groove is not None else ANGLES, endpoint=False)
    theta = every[force.presses(every)]
    if not len(theta):
        raise DesignError(NO_LOAD)
    body: _Ring | _Tetra
    if isinstance(part, Prism) and drive is not None:
        body = _Ring(PlateSection(part), lambda load: plate_patch(drive, 0, part, load.theta), own)
    elif isinstance(part, EndFaceRing | RibbedCylinder):
        face = EndFaceSection(part) if isinstance(part, EndFaceRing) else RibSection.of(part)
        body = _Ring(face, lambda load: RollerLoad(face, duty).patch(load.theta), own)
    elif groove is not None:
        section = GroovedSection.of(groove, Fineness())
        body = _Ring(section, lambda load: RollerLoad(section.groove, duty).patch(load.theta), own)
    elif solid_cut(part):
        body = _Tetra(filled(part, surface()), own)
    else:
        raise DesignError(NO_BELOW)
    loads = [force.points(float(at)) for at in theta]
    work = np.array([float(one[0, 0]) for one in body.works([[load] for load in loads])])
    if not np.isfinite(work).all():
        at = float(np.degrees(theta[np.isinf(work)][0]))
        raise DesignError(f"at cam angle {at:.4g} deg the roller presses a wall thinner than "
                          f"{own.depth * DEPTHS[0]:.3g} mm, an eighth of the depth that the contact's formula holds: "
                          "nothing is known of the body below it")  # fmt: skip
    return Below(theta, work / np.array([load.sizes.sum() for load in loads]) ** 2)


def below_turret(parts: Sequence[Part], duty: TurretDuty, surface: Callable[[], Mesh]) -> Below:
    """The share of a turret's contact stiffness that the body below its contacts leaves, over the turn.

    A contact of stiffness K_j takes a torque T_j, and the body turns the turret by C T: all turn alike, so the whole is
    the sum of (diag(1/K) + C)^-1. Along a roller its slices share as on a rigid body. Raises as `below_rollers`.
    """
    own = Own(duty.cam, 2.0 * float(duty.tracks[0].meridian.jet(np.zeros(1))[3][0]), False)
    theta = np.linspace(0.0, TURN, PLANES, endpoint=False)
    each = duty.stirred(theta)
    cases = [[PointLoad(float(at), *one) for _, one in pressing] for at, pressing in zip(theta, each)]
    hard = [np.array([torque for torque, _ in pressing]) for pressing in each]
    discs = [one for one in parts if isinstance(one, Prism)]
    if discs:
        work = [np.zeros((len(case), len(case))) for case in cases]
        for disc in discs:
            on = [[disc.z0 < load.points[:, 2].mean() < disc.z1 for load in case] for case in cases]
            mine = [np.flatnonzero(one).tolist() for one in on]
            ring = _Ring(PlateSection(disc), lambda load, disc=disc: disc_patch(disc, load), own)  # type: ignore[misc]
            kept = [i for i, some in enumerate(mine) if some]
            for i, found in zip(kept, ring.works([[cases[i][k] for k in mine[i]] for i in kept])):
                work[i][np.ix_(mine[i], mine[i])] = found
    else:
        work = _Tetra(filled(parts[0], surface()), own).works(cases)
    left = []
    for stiff, found in zip(hard, work):
        some = np.isfinite(found.diagonal())
        soft = np.diag(1.0 / stiff) + 0.5 * (found + found.T) / np.outer(stiff, stiff)
        left.append(float(np.linalg.inv(soft[np.ix_(some, some)]).sum() / stiff.sum()))
    return Below(theta, np.array(left))
