"""The turret as a solid: a disc with its rollers on their studs, standing as it does at one cam angle (cam frame)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.mesh import Mesh
from camgeom.solid import Solid
from camgeom.solid.blank import Blank
from camgeom.solid.engine import subtract, unite
from camgeom.track import TURN, Arc, Swing, Track

STUD_SHARE = 0.5
"""stud over roller diameter"""


@immutable
class TurretBody:
    """A disc about the turret's axis with evenly spaced rollers.

    track       one of the rollers (its shift places the first); rollers: on the whole turret
    radius      of the disc, mm; low, high: its two faces along the turret axis from the joint's centre, mm
    root        delta at which a roller's stud ends, within the disc, mm
    cam_angle   at which it is shown, rad
    """

    track: Track
    rollers: int
    radius: float
    low: float
    high: float
    root: float
    cam_angle: float = 0.0
    name: str = "turret"

    def solid(self, tolerance: float) -> Solid:
        """Disc, studs and rollers united. Raises GeometryEngineError where the engine refuses."""
        return Solid(self.name, unite(self.bodies(tolerance)), tolerance, "boolean", 0)

    def shares(self, tolerance: float) -> list[tuple[Mesh, int]]:
        """Meshes that together fill the turret, and how many of each, alike about its axis, there are.

        Of a roller only what no disc and no roller beside it fills, so that one of them stands for all.
        """
        disc, *rollers = self.bodies(tolerance, 2)
        return [(disc, 1), (subtract(rollers[0], [disc, *rollers[1:]]), self.rollers)]

    @property
    def size(self) -> float:
        """How far it reaches about, mm."""
        return self.radius

    def bodies(self, tolerance: float, most: int | None = None) -> list[Mesh]:
        """The disc and the rollers with their studs, or the first ones of these, in the cam frame."""
        joint = self.track.joint
        assert isinstance(joint, Swing)
        disc = Blank(((self.radius, self.low), (self.radius, self.high)), None, (None,), ("body",)).mesh(tolerance)
        turn = np.exp(-1j * self.track.sense * self.cam_angle)
        place, axis = turned(joint.centre, turn), turned(joint.axis, turn)
        bodies = [_moved(disc, place, axis)]
        roller = self._roller().mesh(tolerance)
        for k in range(self.rollers if most is None else min(self.rollers, most)):
            one = replace(self.track, shift=self.track.shift + k * TURN / self.rollers)
            pose = one.pose(np.array([self.cam_angle]), 0)
            bodies.append(_moved(roller, pose.a[0][:, 0], pose.u[0][:, 0]))
        return bodies

    def _roller(self) -> Blank:
        """A roller with its stud as a body of revolution about its own axis, z = delta."""
        track, meridian = self.track, self.track.meridian
        inner = max(track.contact) if track.tip_sign < 0.0 else min(track.contact)
        stations = 33 if isinstance(meridian, Arc) else 2
        t = np.linspace(meridian.parameter(inner), meridian.parameter(track.tip), stations)
        delta, _, _, r, _, _ = meridian.jet(t)
        # A ball ends in a point; a disc of a hundredth of its radius stands for it.
        r = np.maximum(r, 0.01 * meridian.radius)
        stud = STUD_SHARE * meridian.radius
        outline = [(stud, self.root), (stud, float(delta[0])), *zip(r.tolist(), delta.tolist())]
        if track.tip_sign < 0.0:
            outline = outline[::-1]
        return Blank(tuple(outline), None, (None,) * (len(outline) - 1), ("roller",) * (len(outline) - 1))


@immutable
class StackedTurret:
    """Rings of rollers on dials of one turret shaft.

    shaft      its radius, mm; low, high: its ends along the turret axis from the joint's centre, mm
    """

    rings: tuple[TurretBody, ...]
    shaft: float
    low: float
    high: float

    def solid(self, tolerance: float) -> Solid:
        """Everything united. Raises GeometryEngineError where the engine refuses."""
        bodies = [body for ring in (self._shaft, *self.rings) for body in ring.bodies(tolerance)]
        return Solid(self.rings[0].name, unite(bodies), tolerance, "boolean", 0)

    def shares(self, tolerance: float) -> list[tuple[Mesh, int]]:
        """Meshes that together fill the turret, and how many of each, alike about its axis, there are."""
        shaft, discs, found = self._shaft.bodies(tolerance)[0], list[Mesh](), list[tuple[Mesh, int]]()
        for ring in {(ring.radius, ring.low, ring.high): ring for ring in self.rings}.values():
            (disc,) = ring.bodies(tolerance, 0)
            found.append((subtract(disc, [shaft, *discs]), 1))
            discs.append(disc)
        for ring in self.rings:
            roller, *beside = ring.bodies(tolerance, 2)[1:]
            found.append((subtract(roller, [shaft, *discs, *beside]), ring.rollers))
        return [(shaft, 1), *found]

    @property
    def size(self) -> float:
        """How far it reaches about, mm."""
        return max(ring.size for ring in self.rings)

    @property
    def _shaft(self) -> TurretBody:
        return replace(self.rings[0], rollers=0, radius=self.shaft, low=self.low, high=self.high)


def turned(vector: npt.ArrayLike, turn: complex) -> Floats:
    """A vector (3,) turned about Z by the angle of a unit complex number."""
    vector = np.asarray(vector)
    z = (vector[0] + 1j * vector[1]) * turn
    return np.array([z.real, z.imag, vector[2]])


def _moved(mesh: Mesh, place: Floats, axis: Floats) -> Mesh:
    """The mesh with its Z axis laid along `axis` and its origin at `place`."""
    first = np.cross(axis, [0.0, 0.0, 1.0] if abs(axis[2]) < 0.9 else [1.0, 0.0, 0.0])
    first /= np.linalg.norm(first)
    frame = np.stack([first, np.cross(axis, first), axis])
    return Mesh(np.ascontiguousarray(mesh.vertices @ frame + place), mesh.faces, mesh.groups, mesh.group)
