"""The follower's pressure on the flank as consistent nodal forces: the force of the duty, along the line it presses.

The contact is narrow beside an element, tenths of a millimetre, so that its width adds nothing to the nodal forces: the
pressure's distribution along the contact line is what they hold.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.body.element import shapes
from camgeom.body.groove import Walled
from camgeom.body.ring import RingMesh
from camgeom.body.tetra import PointLoad
from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.face_duty import FaceDuty
from camgeom.mechanics.roller_duty import RollerDuty
from camgeom.mechanics.turret_duty import TurretDuty
from camgeom.solid.prism import Prism
from camgeom.track import TURN
from camgeom.track.flank import Flank

ALONG = 24
"""integration points along the contact line"""
PER_TURN = 720
QUIET = 1e-9


@final
@immutable
class LoadPatch:
    """The pressed patch at one cam angle.

    theta      cam angle, rad; normal: force of the contact as the duty gives it, N; where: which flank, in words
    place      on the contour, azimuth (p,) of its points, rad, and their forces (p, 3), N
    thickness  mm, of the material behind the flank at the middle of what touches
    second     whether the flank of a groove is the second on its contour
    """

    theta: float
    normal: float
    where: str
    place: Floats
    azimuth: Floats
    forces: Floats
    thickness: float
    second: bool = False

    @property
    def middle(self) -> float:
        """Azimuth of its middle, rad."""
        return float(np.angle(np.exp(1j * self.azimuth).mean()))

    @cached_property
    def force(self) -> Floats:
        """Resultant on the cam (3,), N."""
        return np.asarray(self.forces.sum(axis=0))


@final
@immutable
class RollerForce:
    """A roller that presses the flanks of its track, as its duty says."""

    duty: RollerDuty

    @cached_property
    def sides(self) -> tuple[float, float]:
        """The flank behind (pressed by a positive normal force) and the one ahead."""
        at = np.array([self.duty.force.panels.theta[0, 0]])
        flank = Flank(self.duty.track, at, np.array([self.duty.station]), 1.0)
        behind = 1.0 if float(flank.lever()[0, 0]) < 0.0 else -1.0
        return behind, -behind

    def normal(self, theta: Floats) -> Floats:
        """Signed normal force (n,), N: positive on the flank behind."""
        return np.asarray(self.duty.force.panels.at(self.duty.normal, theta))

    def presses(self, theta: Floats) -> npt.NDArray[np.bool_]:
        """Whether anything presses at cam angles (n,)."""
        return np.asarray(np.abs(self.normal(theta)) > QUIET * max(self.duty.peak_force.value, 1e-300))

    def largest(self, theta: float) -> float:
        """The larger size, N, of the normal force on both sides of a cam angle."""
        size = np.abs(self.duty.normal)
        return float(self.duty.force.panels.limit(size, theta, size))

    def line(self, theta: float) -> tuple[float, Floats, Floats, Floats]:
        """The pressed side at a cam angle, rad, stations (m,) along it, and the force, N, and force per length, N/mm,
        there (m,), as slices share it.

        Where the force jumps, that of its harder side. Raises DesignError where nothing presses.
        """
        duty = self.duty
        angle = np.array([duty.force.panels.harder(theta, np.abs(duty.normal))])
        if not self.presses(angle)[0]:
            raise DesignError(f"nothing presses the flank at cam angle {np.degrees(theta):.6g} deg: there is no load")
        normal = float(self.normal(angle)[0])
        low, high = sorted(duty.track.contact)
        x, w = np.polynomial.legendre.leggauss(ALONG)
        delta = low + 0.5 * (high - low) * (x + 1.0)
        line = w * np.abs(duty.spread(duty.slices.normal, angle, delta)[0])
        force = abs(normal) * line / line.sum()
        side = self.sides[0 if normal >= 0.0 else 1]
        return side, duty.track.meridian.parameters(delta), force, force / (0.5 * (high - low) * w)

    def points(self, angle: float | None) -> PointLoad:
        """Points and forces at a cam angle, rad; None: that of the largest force."""
        theta = self.duty.peak_force.cam_angle if angle is None else angle
        side, t, share, density = self.line(theta)
        flank = Flank(self.duty.track, np.array([theta]), t, side)
        return PointLoad(theta, flank.x[:, 0].T, flank.n[:, 0].T, share, density)


@final
@immutable
class RollerLoad:
    """A roller that presses the flanks of a ring, as its duty says."""

    body: Walled
    duty: RollerDuty

    @cached_property
    def force(self) -> RollerForce:
        """The roller."""
        return RollerForce(self.duty)

    def thickness(self, theta: Floats) -> Floats:
        """Of the pressed wall at the middle of the roller's contact, mm, at cam angles (n,)."""
        t = self.duty.track.meridian.parameter(0.5 * sum(self.duty.track.contact))
        behind, ahead = (self.body.thickness(theta, side, t) for side in self.force.sides)
        return np.asarray(np.where(self.force.normal(theta) >= 0.0, behind, ahead))

    @cached_property
    def hardest(self) -> Extreme:
        """The cam angle of the largest force over squared thickness of the wall, and that, N/mm²."""
        theta = self.duty.force.panels.sampled(PER_TURN)
        value = np.abs(self.force.normal(theta)) / self.thickness(theta) ** 2
        worst = int(np.argmax(value))
        return Extreme(float(value[worst]), float(theta[worst]))

    def asked(self, angle: float | None) -> LoadPatch:
        """The patch at a cam angle, rad; None: where force over squared thickness is largest."""
        return self.patch(self.hardest.cam_angle if angle is None else angle)

    def patch(self, theta: float) -> LoadPatch:
        """The patch pressed at a cam angle, rad. Raises DesignError where nothing presses."""
        side, t, share, _ = self.force.line(theta)
        place, azimuth, n = self.body.place(theta, side, t)
        wall = float(self.thickness(np.array([theta]))[0])
        return LoadPatch(theta, float(share.sum()), self.body.word(side), place, azimuth, (share * n).T, wall,
                     self.body.second(side))  # fmt: skip


def asked_patch(body: Walled, duties: Sequence[RollerDuty], angle: float | None) -> LoadPatch:
    """The patch of the rollers that press a ring's flanks at a cam angle, rad: that of the one that presses hardest.

    None: where force over squared thickness is largest of all.
    """
    loads = [RollerLoad(body, duty) for duty in duties]
    if angle is None:
        return max(loads, key=lambda load: load.hardest.value).asked(None)
    return max(loads, key=lambda load: load.force.largest(angle)).patch(angle)


def plate_angle(drive: FaceDuty, discs: Sequence[Prism], angle: float | None) -> tuple[int, float]:
    """Number of the touch, and the cam angle, of the largest force over squared distance to the bore.

    At a given angle, rad, the touch that presses hardest there.
    """
    forces, where = drive.contact_forces, drive.force.panels
    theta = where.sampled(PER_TURN) if angle is None else np.array([where.harder(angle, forces.max(axis=0))])
    best = (0, float(theta[0]), -1.0)
    for number, touch in enumerate(drive.touches):
        disc = next((one for one in discs if one.outer.outline is touch.outline), discs[0])
        room = np.hypot(*touch.at(theta).curve.points) - (0.5 * disc.bore.diameter if disc.bore is not None else 0.0)
        value = where.at(forces[number], theta) / np.maximum(room, 1e-9) ** 2
        worst = int(np.argmax(value))
        if value[worst] > best[2]:
            best = (number, float(theta[worst]), float(value[worst]))
    return best[0], best[1]


def plate_patch(drive: FaceDuty, number: int, disc: Prism, theta: float) -> LoadPatch:
    """The patch that a planar cam's touch presses at a cam angle, rad: even over the length that touches.

    Raises DesignError where nothing presses.
    """
    touch, angle = drive.touches[number], np.array([theta])
    force = drive.contact_forces[number]
    normal = float(drive.force.panels.limit(force, theta, force))
    if normal <= QUIET:
        raise DesignError(f"nothing presses the cam at cam angle {np.degrees(theta):.6g} deg: there is no load")
    curve = touch.at(angle).curve
    x, w = np.polynomial.legendre.leggauss(ALONG)
    share = 0.5 + 0.5 * min(1.0, touch.length / (disc.z1 - disc.z0)) * x
    azimuth = np.full(ALONG, float(np.arctan2(curve.points[1, 0], curve.points[0, 0])))
    push = -touch.material * np.append(curve.normals[:, 0], 0.0)
    room = float(np.hypot(*curve.points[:, 0])) - (0.5 * disc.bore.diameter if disc.bore is not None else 0.0)
    return LoadPatch(theta, normal, touch.name, share, azimuth, np.outer(0.5 * normal * w, push), room)


def turret_patch(duty: TurretDuty, discs: Sequence[Prism], index: int) -> tuple[Prism, LoadPatch]:
    """The disc of a turret's cam that is pressed hardest at a sample point of its duty, and the patch."""
    points, *rest = duty.pressed(index)
    on = [(points[:, 2] > disc.z0) & (points[:, 2] < disc.z1) for disc in discs]
    which = int(np.argmax([rest[1][one].sum() for one in on]))
    mine = on[which]
    load = PointLoad(float(duty.theta[index]), points[mine], *(one[mine] for one in rest))
    return discs[which], disc_patch(discs[which], load)


def disc_patch(disc: Prism, load: PointLoad) -> LoadPatch:
    """The patch of what presses a disc."""
    x = load.points
    room = float(np.hypot(x[:, 0], x[:, 1]).min()) - (0.5 * disc.bore.diameter if disc.bore is not None else 0.0)
    place, azimuth = (x[:, 2] - disc.z0) / (disc.z1 - disc.z0), np.arctan2(x[:, 1], x[:, 0])
    return LoadPatch(load.theta, float(load.sizes.sum()), disc.name, place, azimuth, load.forces, room)


def nodal_forces(ring: RingMesh, loads: Sequence[Sequence[LoadPatch]]) -> Floats:
    """Forces (v, 3, k), N, on all nodes, that do the same work as the patches of each load on the elements'
    displacements."""
    found = np.zeros((len(ring.nodes), 3, len(loads)))
    rows = ring.section.rows
    start = np.append(ring.planes, ring.planes[0] + TURN)
    for k, patch in ((k, patch) for k, load in enumerate(loads) for patch in load):
        cell = np.clip(np.searchsorted(rows[::2], patch.place, side="right") - 1, 0, len(ring.contour) - 1)
        low, high = rows[2 * cell], rows[2 * cell + 2]
        eta = 2.0 * (patch.place - low) / (high - low) - 1.0
        psi = ring.planes[0] + (patch.azimuth - ring.planes[0]) % TURN
        slab = np.clip(np.searchsorted(start, psi, side="right") - 1, 0, len(ring.planes) - 1)
        zeta = 2.0 * (psi - start[slab]) / (start[slab + 1] - start[slab]) - 1.0
        weight = shapes(np.stack([np.full_like(eta, -1.0), eta, zeta], axis=1))[0]
        nodes = ring.elements.reshape(len(ring.planes), -1, 20)[slab, ring.contour[cell]]
        np.add.at(found[:, :, k], nodes, weight[:, :, None] * patch.forces[:, None])
    return found
