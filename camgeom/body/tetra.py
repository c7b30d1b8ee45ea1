"""Bodies that are no ring, such as globoids, as quadratic tetrahedra: for deflections, not for stress at a root.

fTetWild (pytetwild, MPL-2.0) fills the body's own mesh; it takes any closed surface and never gives up, but its outer
nodes stand off by up to its envelope. So they are moved onto the faces of that mesh, with the middles of the outer
edges, wherever no element folds. Gmsh (GPL), TetGen (AGPL) and CGAL (GPL) have licences that would bind the user, and
Netgen (LGPL) wants the B-rep kernel that this package does without.
"""

from __future__ import annotations

from contextlib import chdir
from importlib.util import find_spec
from math import degrees
from tempfile import TemporaryDirectory
from typing import ClassVar, final

import numpy as np
import numpy.typing as npt

from camgeom.body.element import gradients, strain_matrix
from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.frozen import cached_property
from camgeom.maths.mesh import Mesh
from camgeom.mechanics.material import Material
from camgeom.mechanics.turret_duty import TurretDuty
from camgeom.solid import Part
from camgeom.solid.bell import GroovedRing
from camgeom.solid.cut import CutBlank
from camgeom.solid.drum import GroovedCylinder
from camgeom.solid.prism import GroovedPlate, Prism
from camgeom.worker import Worker, WorkerEnded

Index = npt.NDArray[np.int64]
EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
"""of which nodes 5 to 10 are the middles, in Abaqus', Nastran's and VTK's order"""
FACES = ((0, 1, 2, 4, 5, 6), (0, 3, 1, 7, 8, 4), (1, 3, 2, 8, 9, 5), (2, 3, 0, 9, 7, 6))
"""corners and middles of the faces S1 to S4, clockwise from outside"""
EDGE_SHARE = 0.05
"""wanted edge length over the body's diagonal"""
ENVELOPE = 1e-3
"""of the diagonal by which the mesher may leave the surface, before its nodes are moved onto it"""
ROUGH = 4e-4
"""of the diagonal: chord error of the surface that is filled; with a fine one the mesher took minutes"""
MESHER_SECONDS = 300.0
"""after which the mesher is given up; it takes 5 to 50"""
ROUNDS = 20
"""projections of a node on the edge of two faces, onto either in turn"""
FLATTEST = 0.05
"""least share of its volume that an element may keep where nodes are moved onto the surface"""
INSIDE = 0.13819660112501053
"""(5 - sqrt 5)/20: of the four Gauss points' barycentric coordinates the three that are alike, exact to degree two"""
NEEDS = "this body is no ring and is filled with tetrahedra, which needs pytetwild: pip install 'camgeom[tetra]'"


@final
@immutable
class TetraMesh:
    """Ten-node tetrahedra.

    nodes     (v, 3), mm; elements (e, 10)
    outer     (f, 2) element and number of the face (0 to 3) of every outer face; labels (f,) their names' numbers
    names     of the faces of the body
    left_off  mm, most that an outer node stands off the body's mesh, where moving it would have folded an element
    """

    nodes: Floats
    elements: Index
    outer: Index
    labels: Index
    names: tuple[str, ...]
    left_off: float
    edges: ClassVar[tuple[tuple[int, int], ...]] = EDGES

    @staticmethod
    def stiffness(x: Floats, material: Floats) -> Floats:
        """Of elements; see `stiffness`."""
        return stiffness(x, material)

    @cached_property
    def outer_nodes(self) -> Index:
        """Nodes (f, 6) of the outer faces: corners and middles."""
        return np.asarray(self.elements[self.outer[:, :1], np.array(FACES)[self.outer[:, 1]]])

    @cached_property
    def sets(self) -> dict[str, Index]:
        """Node numbers by the body's face."""
        found = {name: distinct(self.outer_nodes[self.labels == k]) for k, name in enumerate(self.names)}
        return {name: nodes for name, nodes in found.items() if len(nodes)}

    def spread(self, points: Floats, forces: Floats) -> Floats:
        """Nodal forces (v, 3), N, that do the work of forces (p, 3) at points (p, 3) on the outside."""
        nodes = self.outer_nodes
        near, at = _closest(self.nodes, nodes[:, :3], points)
        a, b, c = (self.nodes[nodes[near, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        area = (normal * normal).sum(axis=1)
        u, v = (np.einsum("pi,pi->p", np.cross(*edge), normal) / area for edge in ((c - b, at - b), (a - c, at - c)))
        w = 1.0 - u - v
        weight = np.stack([u * (2 * u - 1), v * (2 * v - 1), w * (2 * w - 1), 4 * u * v, 4 * v * w, 4 * w * u], axis=1)
        loads = np.zeros_like(self.nodes)
        np.add.at(loads, nodes[near], weight[:, :, None] * forces[:, None])
        return loads


def solid_cut(part: Part) -> bool:
    """Whether a body that a roller presses is filled with tetrahedra: a groove that runs out, a flank of a disc that
    leans, a cone, a ring with a groove in its inside."""
    if isinstance(part, Prism | GroovedPlate):
        return part.leans
    cone = isinstance(part, GroovedCylinder) and part.slope != 0.0
    return cone or isinstance(part, CutBlank | GroovedRing)


def filled(part: Part, surface: Mesh) -> TetraMesh:
    """A body with its outer nodes on the faces of its mesh. Raises DesignError without pytetwild."""
    if find_spec("pytetwild") is None:
        raise DesignError(NEEDS)
    diagonal = float(np.sqrt((np.ptp(surface.vertices, axis=0) ** 2).sum()))
    rough = part.solid(ROUGH * diagonal).mesh
    mesher = Worker("camgeom.body.tetra:Mesher")
    try:
        nodes, cells = mesher.ask("fill", rough.vertices, rough.faces, seconds=MESHER_SECONDS)
    except WorkerEnded as end:
        raise DesignError(f"no tetrahedra: the mesher {end}; a body with less detail would do") from None
    finally:
        mesher.close()
    return quadratic(surface, nodes, cells)


class Mesher:
    """The library in a process of its own: it listens to nobody until it is done, and may take minutes."""

    def fill(self, vertices: Floats, faces: npt.NDArray[np.integer]) -> tuple[Floats, Index]:
        """Corners (v, 3) and elements (e, 4) in a closed surface."""
        import pytetwild

        # The mesher leaves a file of its own in the working directory.
        with TemporaryDirectory(prefix="camgeom-") as folder, chdir(folder):
            nodes, cells = pytetwild.tetrahedralize(
                vertices.astype(np.float64), faces.astype(np.int32), edge_length_fac=EDGE_SHARE, epsilon=ENVELOPE,
                quiet=True,
            )  # fmt: skip
        return np.asarray(nodes), np.asarray(cells, dtype=np.int64)


def quadratic(surface: Mesh, nodes: Floats, cells: Index) -> TetraMesh:
    """Ten-node tetrahedra of four-node ones (e, 4), their outer nodes on the faces of a closed mesh."""
    cells = cells.copy()
    turned = _volumes(nodes, cells) < 0.0
    cells[turned] = cells[turned][:, [0, 2, 1, 3]]
    pairs = np.sort(cells[:, np.array(EDGES)].reshape(-1, 2), axis=1)
    edges, number = np.unique(pairs, axis=0, return_inverse=True)
    elements = np.concatenate([cells, len(nodes) + number.reshape(-1, 6)], axis=1)
    faces = elements[:, np.array(FACES)]
    _, first, count = np.unique(
        np.sort(faces[:, :, :3].reshape(-1, 3), axis=1), axis=0, return_index=True, return_counts=True
    )
    outer = np.stack(np.divmod(first[count == 1], 4), axis=1)
    skin = distinct(faces[outer[:, 0], outer[:, 1]])
    corners, middles = skin[skin < len(nodes)], skin[skin >= len(nodes)]

    outside = faces[outer[:, 0], outer[:, 1]]
    near, _ = _closest(surface.vertices, surface.faces, nodes[outside[:, :3]].mean(axis=1))
    labels = np.asarray(surface.group)[near].astype(np.int64)
    member = np.zeros((len(nodes) + len(edges), len(surface.groups)), dtype=bool)
    member[outside.ravel(), np.repeat(labels, 6)] = True

    start = _volumes(nodes, cells)
    moved = nodes.copy()
    reach = np.full(len(nodes), 3.0 * ENVELOPE * float(np.sqrt((np.ptp(surface.vertices, axis=0) ** 2).sum())))
    moved[corners] = _onto(surface, member[corners], nodes[corners], reach[corners])
    while np.any(bad := _volumes(moved, cells) < FLATTEST * start):
        moved[distinct(cells[bad])] = nodes[distinct(cells[bad])]
    every = np.concatenate([moved, moved[edges].mean(axis=1)])
    straight = every.copy()
    length = np.sqrt(((moved[edges[:, 0]] - moved[edges[:, 1]]) ** 2).sum(axis=1))
    every[middles] = _onto(surface, member[middles], straight[middles], 0.25 * length[middles - len(nodes)])
    while np.any(bad := _least(every[elements]) < FLATTEST * _least(straight[elements])):
        back = distinct(elements[bad][:, 4:])
        every[back] = straight[back]
    off = every[skin] - _closest(surface.vertices, surface.faces, every[skin])[1]
    return TetraMesh(every, elements, outer, labels, surface.groups, float(np.sqrt((off**2).sum(axis=1)).max()))


def _onto(surface: Mesh, member: npt.NDArray[np.bool_], points: Floats, reach: Floats) -> Floats:
    """Points (p, 3) moved onto the named faces (p, k) that they belong to, where these are several onto all in turn.

    Where that is farther away than `reach` (p,), mm, onto the nearest face: there an element lies across an edge.
    """
    found = points.copy()
    several = member.sum(axis=1) > 1
    for turn in range(ROUNDS):
        for k, name in enumerate(surface.groups):
            mine = member[:, k] & (several if turn else True)
            if mine.any():
                _, found[mine] = _closest(surface.vertices, surface.faces[surface.group_faces(name)], found[mine])
    far = np.sqrt(((found - points) ** 2).sum(axis=1)) > reach
    if far.any():
        _, found[far] = _closest(surface.vertices, surface.faces, points[far])
    return found


def _volumes(nodes: Floats, cells: Index) -> Floats:
    a, b, c, d = (nodes[cells[:, k]] for k in range(4))
    six: Floats = (np.cross(b - a, c - a) * (d - a)).sum(axis=1)
    return six / 6.0


def _least(x: Floats) -> Floats:
    """Least det J (e,) at the ten nodes of elements (e, 10, 3)."""
    corners = np.eye(4)
    slope = rates(np.concatenate([corners, [0.5 * (corners[i] + corners[j]) for i, j in EDGES]]))
    return np.asarray(np.linalg.det(np.einsum("pna,enk->epak", slope, x, optimize=True)).min(axis=1))


def stiffness(x: Floats, material: Floats) -> Floats:
    """Stiffness (e, 30, 30), N/mm, of elements with nodes (e, 10, 3). Raises DesignError where one is folded."""
    gradient, volume = gradients(x, rates(np.full((4, 4), INSIDE) + (1.0 - 4.0 * INSIDE) * np.eye(4)))
    b = strain_matrix(gradient)
    db = (volume / 24.0)[:, :, None, None] * (material @ b)
    return np.asarray(np.swapaxes(b.reshape(len(b), -1, 30), 1, 2) @ db.reshape(len(b), -1, 30))


def rates(at: Floats) -> Floats:
    """Derivatives (p, 10, 3) of the shape functions by three natural coordinates, at barycentric ones (p, 4)."""
    found = np.zeros((len(at), 10, 4))
    for k in range(4):
        found[:, k, k] = 4.0 * at[:, k] - 1.0
    for k, (i, j) in enumerate(EDGES):
        found[:, 4 + k, i], found[:, 4 + k, j] = 4.0 * at[:, j], 4.0 * at[:, i]
    return found[:, :, 1:] - found[:, :, :1]


def _closest(vertices: Floats, faces: npt.NDArray[np.integer], points: Floats) -> tuple[Index, Floats]:
    """The nearest triangle (p,) to each of points (p, 3), and the point on it."""
    import pyvista

    surface = pyvista.PolyData.from_regular_faces(vertices, np.asarray(faces))
    cell, on = surface.find_closest_cell(points, return_closest_point=True)
    return np.asarray(cell, dtype=np.int64), np.asarray(on, dtype=np.float64)


@final
@immutable
class PointLoad:
    """What rollers press on a cam at one cam angle, rad.

    points (p, 3), mm; inward: unit normals into the cam (p, 3); sizes (p,) of the forces along them, N; density: force
    per length of the contact line (p,), N/mm
    """

    theta: float
    points: Floats
    inward: Floats
    sizes: Floats
    density: Floats

    @cached_property
    def forces(self) -> Floats:
        """On the cam (p, 3), N."""
        return np.asarray(self.sizes[:, None] * self.inward)


@final
@immutable
class TetraVolume:
    """A body of tetrahedra as it is handed over: mesh, material and the forces of its rollers."""

    name: str
    mesh: TetraMesh
    material: Material
    load: PointLoad
    cell: str = "tetra10"
    held: str = "bore"

    @cached_property
    def nodes(self) -> Floats:
        """See `Volume`."""
        return self.mesh.nodes

    @cached_property
    def elements(self) -> Index:
        """See `Volume`."""
        return self.mesh.elements

    @cached_property
    def forces(self) -> Floats:
        """Nodal forces (v, 3), N."""
        return self.mesh.spread(self.load.points, self.load.forces)

    @cached_property
    def sets(self) -> dict[str, Index]:
        """Node numbers, from 0, of the faces of the body and of what is pressed."""
        return self.mesh.sets | {"patch": np.flatnonzero(np.abs(self.forces).sum(axis=1) > 0.0)}

    @cached_property
    def pressed_faces(self) -> Index:
        """Element and number of the face, both from 0, of the flanks, (f, 2)."""
        return np.asarray(self.mesh.outer[self.mesh.labels == self.mesh.names.index("flank")])

    @property
    def about(self) -> tuple[str, ...]:
        """What the file is of, line by line."""
        load = self.load
        normal = float(np.sqrt((load.forces**2).sum(axis=1)).sum())
        return (
            f"{self.name}: volume by camgeom, mm, N, MPa, cam frame; {len(self.nodes)} nodes, "
            f"{len(self.elements)} tetrahedra of 10 nodes: for deflections, not for stress at a root",
            f"load: {normal:.6g} N of rollers at {len(load.points)} points, cam angle {degrees(load.theta):.6g} deg",
            "the bore is held; nodal forces do the work of the forces at these points",
            f"outer nodes stand within {self.mesh.left_off:.3g} mm of the body's mesh",
        )


def turret_load(duty: TurretDuty, angle: float | None) -> PointLoad:
    """The load of `turret_sample`."""
    index = turret_sample(duty, angle)
    return PointLoad(float(duty.theta[index]), *duty.pressed(index))


def turret_sample(duty: TurretDuty, angle: float | None) -> int:
    """The sample point next to a cam angle, rad; None: that of the largest force on a roller.

    Raises DesignError where nothing presses.
    """
    at = duty.peak_force.cam_angle if angle is None else angle
    index = int(np.argmin(np.abs(duty.theta - at)))
    if not duty.roller_load[index].any():
        raise DesignError(f"nothing presses the cam at cam angle {degrees(at):.6g} deg: there is no load")
    return index
