"""A body as it is handed over: mesh, sets, material, held bore and the contact's load at one cam angle."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import degrees
from typing import Protocol, final

import numpy as np
import numpy.typing as npt

from camgeom.body.end_face import EndFaceSection
from camgeom.body.groove import groove_of
from camgeom.body.grooves import grooves_of
from camgeom.body.load import (
    LoadPatch,
    RollerForce,
    RollerLoad,
    asked_patch,
    nodal_forces,
    plate_angle,
    plate_patch,
    turret_patch,
)
from camgeom.body.plate import PlateSection
from camgeom.body.rib import RibSection
from camgeom.body.ring import RingMesh, ring_about
from camgeom.body.section import Fineness, GroovedSection
from camgeom.body.tetra import TetraVolume, filled, solid_cut, turret_load, turret_sample
from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.frozen import cached_property
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

Index = npt.NDArray[np.int64]
STEP = 0.05
"""rad between the planes beside the load"""
NO_RING = (
    "plates that slide, plates whose rim is a track beside a groove or on which a wall of several tracks leans, and "
    "undercut bodies are not meshed: give an FE program the STEP file of this body"
)
NO_LEANING_PAIR = "the leaning discs of a pair of cones are not meshed: give an FE program their STEP file"
NO_LOAD = "nothing presses this body: there is no load"


class Volume(Protocol):
    """A loaded body as it is handed over. Lengths mm, forces N, stresses MPa; nodes of the set `held` do not move."""

    @property
    def name(self) -> str:
        """Of the body."""

    @property
    def material(self) -> Material:
        """Of the cam."""

    @property
    def cell(self) -> str:
        """meshio's name of the elements: hexahedron20 or tetra10."""

    @property
    def nodes(self) -> Floats:
        """(v, 3), cam frame."""

    @property
    def elements(self) -> Index:
        """Node numbers (e, 20) or (e, 10), from 0."""

    @property
    def forces(self) -> Floats:
        """Nodal forces (v, 3)."""

    @property
    def sets(self) -> dict[str, Index]:
        """Node numbers, from 0, of the named sets."""

    @property
    def pressed_faces(self) -> Index:
        """Element and number of the face, both from 0, of what may be pressed, (f, 2)."""

    @property
    def held(self) -> str:
        """The set whose nodes do not move."""

    @property
    def about(self) -> tuple[str, ...]:
        """What the file is of, line by line."""


@final
@immutable
class BodyVolume:
    """A ring as it is handed over: mesh, material and load; see `Volume`."""

    name: str
    ring: RingMesh
    material: Material
    patch: LoadPatch
    cell: str = "hexahedron20"
    held: str = "bore"

    @property
    def nodes(self) -> Floats:
        """See `Volume`."""
        return self.ring.nodes

    @property
    def elements(self) -> Index:
        """See `Volume`."""
        return self.ring.elements

    @cached_property
    def pressed_faces(self) -> Index:
        """The contour of the ring: faces of nodes 4, 8, 5 and 1, Abaqus' S6."""
        ring = self.ring
        layer = ring.quads.shape[0] * np.arange(len(ring.planes))
        contour = (layer[:, None] + ring.contour).ravel()
        return np.stack([contour, np.full(len(contour), 5)], axis=1)

    @cached_property
    def forces(self) -> Floats:
        """Nodal forces (v, 3), N."""
        return np.asarray(nodal_forces(self.ring, [[self.patch]])[:, :, 0])

    @cached_property
    def sets(self) -> dict[str, Index]:
        """Node numbers, from 0, of the named sets: faces of the body and the pressed patch."""
        found = {name: self.ring.node_set(name) for name in self.ring.sets}
        for whole in ("flank", "root", "floor"):
            parts = [one for name, one in found.items() if name.startswith(f"{whole}_")]
            found |= {whole: distinct(np.concatenate(parts))} if parts else {}
        return found | {"patch": np.flatnonzero(np.abs(self.forces).sum(axis=1) > 0.0)}

    @property
    def about(self) -> tuple[str, ...]:
        """What the file is of, line by line."""
        patch = self.patch
        return (
            f"{self.name}: volume by camgeom, mm, N, MPa, cam frame; {len(self.ring.nodes)} nodes, "
            f"{len(self.ring.elements)} hexahedra of 20 nodes",
            f"load: {patch.normal:.6g} N of the follower on {patch.where} at cam angle {degrees(patch.theta):.6g} deg",
            "the bore is held; nodal forces are consistent with the contact's pressure",
            *self.ring.section.notes,
        )


@final
@immutable
class PressedBy:
    """The duty that presses a body: of its rollers, of a planar cam's touches, or of a turret."""

    rollers: tuple[RollerDuty, ...] = ()
    drive: FaceDuty | None = None
    turret: TurretDuty | None = None


@final
@immutable
class LoadedTrack:
    """One of several tracks of a body: its tools, its duties, and the cam angle, rad, by which its own is less."""

    cutters: tuple[Track, ...]
    duties: tuple[RollerDuty, ...]
    angle: float


def grooved_volume(part: Part, tracks: Sequence[LoadedTrack], material: Material, angle: float | None) -> BodyVolume:
    """A body with several grooves under the load of the track that is pressed hardest at a cam angle, rad.

    None: where force over squared thickness of the wall is largest of all. Raises as `volume_of`.
    """
    body = grooves_of(part, [one.cutters for one in tracks])
    if body is None:
        raise DesignError(NO_RING)
    each = [(k, RollerLoad(body.walled(k), duty)) for k, one in enumerate(tracks) for duty in one.duties]
    if angle is None:
        track, load = max(each, key=lambda one: one[1].hardest.value)
        patch = load.asked(None)
    else:
        own = [(angle - one.angle) % TURN for one in tracks]
        track, load = max(each, key=lambda one: one[1].force.largest(own[one[0]]))
        patch = load.patch(own[track])
    section = body.section(track, Fineness.fine_at(patch.second))
    told = replace(patch, theta=(patch.theta + tracks[track].angle) % TURN,
                   where=f"{patch.where} of track {track + 1}")  # fmt: skip
    return BodyVolume(part.name, ring_about(section, patch.middle, STEP), material, told)


def unfilled(parts: Sequence[Part], cutters: tuple[Track, ...], several: Sequence[tuple[Track, ...]] = ()) -> str:
    """Why a body is neither meshed as a ring nor filled, told before anything is computed; empty where it may be.

    several  the tools of each of several tracks
    """
    if len(several) > 1:
        return "" if grooves_of(parts[0], several) is not None else NO_RING
    if _leaning_pair(parts):
        return NO_LEANING_PAIR
    ring = isinstance(parts[0], EndFaceRing | RibbedCylinder | IndexingCut)
    known = ring or solid_cut(parts[0]) or all(isinstance(one, Prism) for one in parts)
    return "" if known or groove_of(parts[0], cutters) is not None else NO_RING


def _leaning_pair(parts: Sequence[Part]) -> bool:
    return len(parts) > 1 and any(solid_cut(one) for one in parts)


def volume_of(
    parts: Sequence[Part], cutters: tuple[Track, ...], pressing: PressedBy, material: Material, angle: float | None,
    surface: Callable[[], Mesh],
) -> Volume:
    """The loaded body at a cam angle, rad (None: where force over squared thickness of what bears it is largest).

    surface  the body's mesh, asked for where it is no ring
    Raises DesignError where nothing presses the body, or it cannot be meshed.
    """
    if _leaning_pair(parts):
        raise DesignError(NO_LEANING_PAIR)
    part, rollers = parts[0], pressing.rollers
    groove = groove_of(part, cutters)
    if groove is not None and rollers:
        patch = asked_patch(GroovedSection.of(groove, Fineness()).groove, rollers, angle)
        section = GroovedSection.of(groove, Fineness.fine_at(patch.second))
        return BodyVolume(part.name, ring_about(section, patch.middle, STEP), material, patch)
    if isinstance(part, EndFaceRing | RibbedCylinder) and rollers:
        ring = EndFaceSection(part) if isinstance(part, EndFaceRing) else RibSection.of(part)
        patch = asked_patch(ring, rollers, angle)
        return BodyVolume(part.name, ring_about(ring, patch.middle, STEP), material, patch)
    discs = [one for one in parts if isinstance(one, Prism) and not one.leans]
    if len(discs) == len(parts):
        disc, patch = _pressed_disc(discs, pressing, angle)
        plate = PlateSection(disc)
        return BodyVolume(disc.name, ring_about(plate, patch.middle, STEP), material, patch)
    if isinstance(part, IndexingCut) and pressing.turret is not None:
        load = turret_load(pressing.turret, angle)
    elif solid_cut(part) and rollers:
        load = RollerForce(rollers[0]).points(angle)
    else:
        raise DesignError(NO_RING)
    return TetraVolume(part.name, filled(part, surface()), material, load)


def _pressed_disc(discs: list[Prism], pressing: PressedBy, angle: float | None) -> tuple[Prism, LoadPatch]:
    """The disc of a planar cam that is pressed hardest, and the patch."""
    if pressing.turret is not None:
        return turret_patch(pressing.turret, discs, turret_sample(pressing.turret, angle))
    drive = pressing.drive
    if drive is None:
        raise DesignError(NO_LOAD)
    number, theta = plate_angle(drive, discs, angle)
    disc = next((one for one in discs if one.outer.outline is drive.touches[number].outline), discs[0])
    return disc, plate_patch(drive, number, disc, theta)
