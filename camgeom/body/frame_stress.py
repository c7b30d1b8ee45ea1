"""Load and stress of the frame about a constant-width cam: an end of its plate bends between the window's bars.

The cam presses a line on a face, as long as both touch along the axis; the guide bores (without any the plate's sides)
are held. The nominal stress is that of the end as a beam, membrane and bending of what its section at the window's
corner really passes on, which the mesh's forces there tell; so it exists for sharp corners too.
"""

from __future__ import annotations

from collections.abc import Callable
from math import degrees
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.body.cut import Cut, plate_cut
from camgeom.body.element import NATURAL, elasticity, largest_principal, stresses
from camgeom.body.frame import HELD, FrameCells, FrameMesh
from camgeom.body.load import ALONG, PER_TURN, QUIET
from camgeom.body.sparse_solver import SparseElastic
from camgeom.body.stress import StressPeak, with_hardest
from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.duty import free
from camgeom.mechanics.face_duty import FaceDuty
from camgeom.mechanics.material import Material
from camgeom.solid.frame import FramePlate

Index = npt.NDArray[np.int64]
TIMES = (1, 2)
"""how fine the two meshes of a peak are"""
WITHIN = 1e-6
"""mm by which a contact may be computed beyond the end of its face"""
TOLERANCE = 1e-7
"""force that is left over, a share of the load's"""
ON_FACE = 8
"""nodes of an element with a face on the corner's wall"""


@final
@immutable(eq=True)
class FacePatch:
    """The line that the cam presses on a face at one cam angle.

    theta rad; normal N; where: which face; y: place on it, mm; way: +1 on the near face, -1 on the far one; length: of
    the line along the axis, mm; thickness: of the plate between window and end, mm
    """

    theta: float
    normal: float
    where: str
    y: float
    way: float
    length: float
    thickness: float


@final
@immutable
class FaceLoad:
    """A cam that presses the faces of its frame, as its duty says."""

    frame: FrameMesh
    drive: FaceDuty

    def pressed(self, number: int, theta: Floats) -> tuple[Floats, Floats]:
        """Force, N, and place y, mm, of a touch at cam angles (n,).

        Raises DesignError where a contact that presses lies beyond the face.
        """
        touch = self.drive.touches[number]
        normal = self.drive.force.panels.at(self.drive.contact_forces[number], theta)
        points = touch.at(theta).curve.points
        y = np.imag((points[0] + 1j * points[1]) * np.exp(1j * touch.sense * theta))
        half = 0.5 * self.frame.plate.face
        if np.any((np.abs(y) > half + WITHIN) & (normal > QUIET * self.drive.peak_force.value)):
            raise DesignError("the contact leaves the frame's face: there is no load on its plate")
        return np.asarray(normal), np.asarray(np.clip(y, -half, half))

    @cached_property
    def hardest(self) -> float:
        """The cam angle at which the end of the plate is bent most at a corner, taken as a beam that is clamped there:
        F a² b / l²."""
        theta, span = self.drive.force.panels.sampled(PER_TURN), 2.0 * self.frame.root
        worst = []
        for number in range(len(self.drive.touches)):
            normal, y = self.pressed(number, theta)
            value = normal * (0.5 * span + np.abs(y)) ** 2 * (0.5 * span - np.abs(y)) / span**2
            worst.append((float(value.max()), float(theta[int(np.argmax(value))])))
        return max(worst)[1]

    def asked(self, angle: float | None) -> FacePatch:
        """The patch at a cam angle, rad, of the face that is pressed harder; None: at the hardest one.

        Raises DesignError where nothing presses.
        """
        forces = self.drive.contact_forces
        theta = self.drive.force.panels.harder(self.hardest if angle is None else angle, forces.max(axis=0))
        each = [self.pressed(number, np.array([theta])) for number in range(len(forces))]
        number = int(np.argmax([float(normal[0]) for normal, _ in each]))
        normal, y = (float(one[0]) for one in each[number])
        touch = self.drive.touches[number]
        if normal <= QUIET * max(self.drive.peak_force.value, 1e-300):
            raise DesignError(f"nothing presses the frame at cam angle {degrees(theta):.6g} deg: there is no load")
        return FacePatch(theta, normal, touch.name, y, touch.way, touch.length, self.frame.depth)

    def spread(self, patch: FacePatch) -> tuple[Index, Floats]:
        """Nodes (p, 8) of the near face, and shares of the force on them, N."""
        x, w = np.polynomial.legendre.leggauss(ALONG)
        z = self.frame.plate.height + 0.5 * patch.length * x
        return self.frame.spread(np.full(ALONG, patch.y), z, 0.5 * patch.normal * w)


def nodal(frame: FrameMesh, load: FaceLoad, patch: FacePatch) -> Floats:
    """Nodal forces (v, 3), N, of a patch."""
    nodes, shares = load.spread(patch)
    found = np.zeros_like(frame.mesh.nodes)
    np.add.at(found[:, 0], nodes, shares)
    return found if patch.way > 0.0 else -found[_mirrored(frame)]


def _mirrored(frame: FrameMesh) -> Index:
    """The node (v,) on the other side of the window's middle of every node."""
    from scipy.spatial import cKDTree

    x = frame.mesh.nodes - np.array([frame.plate.middle, 0.0, 0.0])
    return np.asarray(cKDTree(x).query(x * np.array([-1.0, 1.0, 1.0]))[1], dtype=np.int64)


@final
@immutable
class Beam:
    """What a unit force on the near face at y (n,), mm, makes the end's section at the corner at large y pass on.

    pull (n,), 1: along y, positive where it is pulled; cross (n,), 1: along x, outward; moment (n,), mm: positive where
    it pulls the side away from the window
    """

    pull: Floats
    cross: Floats
    moment: Floats


@final
@immutable
class FrameBending:
    """The ends of a frame's plate under its cam; see `camgeom.body.stress.Stressed`.

    angle  rad, asked of the peak; None: where a corner is bent most
    paid   raises NotConverged where it would take too long
    """

    plate: FramePlate
    drive: FaceDuty
    material: Material
    angle: float | None = None
    paid: Callable[[], None] = free

    @cached_property
    def frame(self) -> FrameMesh:
        """The coarse mesh."""
        return FrameMesh(self.plate)

    @cached_property
    def load(self) -> FaceLoad:
        """What presses."""
        return FaceLoad(self.frame, self.drive)

    @property
    def sharp(self) -> str:
        """Why there is no peak."""
        return "" if self.plate.corner else (
            "a sharp corner of the window has no stress that a mesh could find: give follower.window_radius"
        )

    @property
    def remedy(self) -> str:
        """What makes its stress smaller."""
        return "a longer plate (follower.plate_length) or a thicker one, or a larger follower.window_radius"

    @cached_property
    def theta(self) -> Floats:
        """Even cam angles, and the hardest one."""
        return with_hardest(np.array([self.load.hardest]))

    @cached_property
    def influence(self) -> tuple[Index, Floats]:
        """Nodes of the near face, and pull, cross force and moment (3, p) at the corner of a unit force on each.

        Three solutions of the adjoint problem: a load's effect is its work on them.
        """
        self.paid()
        frame, mesh, root = self.frame, self.frame.mesh, self.frame.root
        x, tiny = mesh.nodes, 1e-6
        beyond = (x[:, 0] > frame.plate.middle) & (x[:, 1] > root - tiny)
        on = beyond & (x[:, 0] - frame.plate.middle > frame.end - tiny) & (x[:, 1] < root + tiny)
        behind = np.flatnonzero(beyond[mesh.elements].all(axis=1) & on[mesh.elements].any(axis=1))
        material = elasticity(self.material.elastic_modulus, self.material.poisson)
        elements = mesh.elements[behind]
        own = mesh.stiffness(x[elements], material).reshape(len(behind), 20, 3, 60)
        arm = x[:, 0] - (frame.plate.middle + frame.end + 0.5 * frame.depth)
        wanted = np.zeros((len(x), 3, 3))
        kinds: tuple[tuple[int, Floats], ...] = ((1, -np.ones(len(x))), (0, np.ones(len(x))), (1, -arm))
        for k, (axis, weight) in enumerate(kinds):
            rows = np.einsum("en,enc->ec", np.where(on[elements], weight[elements], 0.0), own[:, :, axis])
            np.add.at(wanted[:, :, k], elements, rows.reshape(len(behind), 20, 3))
        moved = SparseElastic(mesh, material, HELD).solve(wanted, TOLERANCE)
        nodes = mesh.sets["face_near"]
        return nodes, moved[nodes, 0].T

    def beam(self, y: Floats) -> Beam:
        """Of a force at y (n,)."""
        nodes, each = self.influence
        at = np.zeros((3, len(self.frame.mesh.nodes)))
        at[:, nodes] = each
        middle = np.full(len(y), self.plate.height)
        touch = self.drive.touches[0]
        x, w = np.polynomial.legendre.leggauss(ALONG)
        z = (middle[:, None] + 0.5 * touch.length * x).ravel()
        where, share = self.frame.spread(np.repeat(y, ALONG), z, np.tile(0.5 * w, len(y)))
        found = (at[:, where] * share).sum(axis=2).reshape(3, len(y), ALONG).sum(axis=2)
        return Beam(*found)

    @cached_property
    def places(self) -> tuple[Floats, list[str]]:
        """Nominal stress (k, m, n), MPa, at the angles (n,) by touch (k,) and place (m,), and the places' names."""
        plate, frame, theta = self.plate, self.frame, self.theta
        area, bend = frame.depth * plate.thickness, plate.thickness * frame.depth**2 / 6.0
        deep = frame.depth + plate.rise
        rows = []
        for number in range(len(self.drive.touches)):
            normal, y = self.load.pressed(number, theta)
            upper, lower = self.beam(y), self.beam(-y)
            foot = frame.root - 0.5 * plate.face
            found = [self._stress(one.pull, one.moment, area, bend) for one in (upper, lower)]
            found += [self._stress(one.pull, one.moment + foot * one.cross, area, bend) for one in (upper, lower)]
            behind = upper.moment + (frame.root - y) * upper.cross + 0.5 * plate.rise * upper.pull
            found.append(self._stress(upper.pull, behind, deep * plate.thickness, plate.thickness * deep**2 / 6.0))
            rows.append(normal * np.stack(found))
        names = ["window's corner beside", "window's corner beside", "foot of", "foot of", "plate behind"]
        return np.stack(rows), names

    @staticmethod
    def _stress(pull: Floats, moment: Floats, area: float, bend: float) -> Floats:
        """On the side that is pulled more."""
        return np.maximum(pull / area + np.abs(moment) / bend, 0.0)

    @cached_property
    def nominal(self) -> Floats:
        """At both corners beside the pressed face, at its foot and behind the contact."""
        return np.asarray(self.places[0].max(axis=(0, 1)))

    def where(self, theta: float) -> str:
        """The place of the nominal stress."""
        found, names = self.places
        at = int(np.argmin(np.abs(self.theta - theta)))
        number, place = np.unravel_index(int(np.argmax(found[:, :, at])), found.shape[:2])
        return f"{names[place]} the {self.drive.touches[number].name} of the frame"

    @property
    def notches(self) -> tuple[Floats, Floats]:
        """Of the window's corners, and of the sharp ones at the feet of faces that stand out."""
        found = self.places[0]
        return found[:, :2].max(axis=(0, 1)), found[:, 2:4].max(axis=(0, 1)) * bool(self.plate.rise)

    @cached_property
    def patch(self) -> FacePatch:
        """The load that the peak is asked of."""
        return self.load.asked(self.angle)

    @property
    def root(self) -> str:
        """The corners beside the pressed face."""
        return f"window's corner beside the {self.patch.where} of the frame"

    @cached_property
    def peaks(self) -> tuple[StressPeak, ...]:
        """On the coarser and the finer mesh; none of a sharp corner."""
        self.paid()
        return tuple(self.peak(FrameCells.fine(times)) for times in TIMES) if self.plate.corner else ()

    def peak(self, cells: FrameCells) -> StressPeak:
        """Largest principal stress on the corners' faces under the load, on one mesh."""
        frame = FrameMesh(self.plate, cells)
        mesh, material = frame.mesh, elasticity(self.material.elastic_modulus, self.material.poisson)
        forces = nodal(frame, FaceLoad(frame, self.drive), self.patch)
        moved = SparseElastic(mesh, material, HELD).solve(forces[:, :, None], TOLERANCE)[:, :, 0]
        root = np.zeros(len(mesh.nodes), dtype=bool)
        root[mesh.sets["root"]] = True
        nodes = mesh.elements[root[mesh.elements].sum(axis=1) >= ON_FACE]
        found = largest_principal(stresses(mesh.nodes[nodes], moved[nodes], NATURAL, material))
        found = np.where(root[nodes], found, -np.inf)
        element, corner = np.unravel_index(int(np.argmax(found)), found.shape)
        point = mesh.nodes[nodes[element, corner]]
        x, y, stress = plate_cut(mesh, moved, material, float(point[2]))
        cut = Cut(None, x, y, stress, self.plate.outside, frame.depth, frame.holes)
        return StressPeak(float(found[element, corner]), point, 3 * (len(mesh.nodes) - len(mesh.sets[HELD])), cut)


@final
@immutable
class FrameVolume:
    """The frame as it is handed over, at zero lift; see `camgeom.body.volume.Volume`."""

    frame: FrameMesh
    material: Material
    load: FaceLoad
    patch: FacePatch
    name: str = "frame"
    cell: str = "hexahedron20"
    held: str = HELD

    @property
    def nodes(self) -> Floats:
        """See `Volume`."""
        return self.frame.mesh.nodes

    @property
    def elements(self) -> Index:
        """See `Volume`."""
        return self.frame.mesh.elements

    @cached_property
    def forces(self) -> Floats:
        """Nodal forces (v, 3), N."""
        return nodal(self.frame, self.load, self.patch)

    @cached_property
    def sets(self) -> dict[str, Index]:
        """Node numbers, from 0, of the named sets."""
        return {**self.frame.mesh.sets, "patch": np.flatnonzero(np.abs(self.forces).sum(axis=1) > 0.0)}

    @cached_property
    def pressed_faces(self) -> Index:
        """Element and number of the face, both from 0, of both faces, (f, 2)."""
        return self.frame.mesh.faces(self.frame.mesh.sets["face"])

    @property
    def about(self) -> tuple[str, ...]:
        """What the file is of, line by line."""
        patch, plate = self.patch, self.frame.plate
        held = "guide bores are" if plate.bore else "plate's sides are"
        return (
            f"{self.name}: volume by camgeom, mm, N, MPa, cam frame at zero lift; {len(self.nodes)} nodes, "
            f"{len(self.elements)} hexahedra of 20 nodes",
            f"load: {patch.normal:.6g} N of the cam on the {patch.where}, a line {patch.length:.6g} mm long at "
            f"y = {patch.y:.6g} mm, cam angle {degrees(patch.theta):.6g} deg",
            f"the {held} held, along the motion too; nodal forces are consistent with the contact's pressure",
        )


def frame_volume(plate: FramePlate, drive: FaceDuty, material: Material, angle: float | None) -> FrameVolume:
    """The loaded frame at a cam angle, rad (None: where a corner of the window is bent most).

    Raises DesignError where nothing presses it.
    """
    frame = FrameMesh(plate, FrameCells.fine())
    load = FaceLoad(frame, drive)
    return FrameVolume(frame, material, load, load.asked(angle))
