"""A ring body as it is handed over: mesh, sets, material, held bore and the contact's load at one cam angle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.body.groove import groove_of
from camgeom.body.load import GrooveLoad, Patch, nodal_forces, plate_angle, plate_patch
from camgeom.body.plate import PlateSection
from camgeom.body.ring import RingMesh, ring_about
from camgeom.body.section import Fineness, GroovedSection
from camgeom.errors import DesignError
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.face_duty import FaceDuty
from camgeom.mechanics.material import Material
from camgeom.mechanics.roller_duty import RollerDuty
from camgeom.solid import Part
from camgeom.solid.prism import Prism
from camgeom.track import Track

Index = npt.NDArray[np.int64]
STEP = 0.05
"""rad between the planes beside the load"""
NO_RING = (
    "only rings are meshed as volumes, drums and discs with one closed groove or none: give an FE program the STEP "
    "file of this body"
)


@final
@dataclass(frozen=True, eq=False)
class BodyVolume:
    """Mesh, material and load. Lengths mm, forces N, stresses MPa; the nodes of the set `bore` are held."""

    name: str
    ring: RingMesh
    material: Material
    patch: Patch

    @cached_property
    def forces(self) -> Floats:
        """Nodal forces (v, 3), N."""
        return np.asarray(nodal_forces(self.ring, [self.patch])[:, :, 0])

    @cached_property
    def sets(self) -> dict[str, Index]:
        """Node numbers, from 0, of the named sets: faces of the body and the pressed patch."""
        found = {name: self.ring.node_set(name) for name in self.ring.sets}
        for whole in ("flank", "root"):
            parts = [one for name, one in found.items() if name.startswith(f"{whole}_")]
            found |= {whole: np.unique(np.concatenate(parts))} if parts else {}
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


def volume_of(
    parts: Sequence[Part], cutters: tuple[Track, ...], roller: RollerDuty | None, drive: FaceDuty | None,
    material: Material, angle: float | None,
) -> BodyVolume:
    """The loaded body at a cam angle, rad (None: where force over squared thickness of what bears it is largest).

    Raises DesignError where the body is no ring, or nothing presses it.
    """
    part = parts[0]
    groove = groove_of(part, cutters)
    if groove is not None and roller is not None:
        load = GrooveLoad(GroovedSection.of(groove, Fineness()).groove, roller)
        patch = load.patch(load.hardest.cam_angle if angle is None else angle)
        section = GroovedSection.of(groove, Fineness.fine_at(patch.second))
        return BodyVolume(part.name, ring_about(section, patch.middle, STEP), material, patch)
    discs = [one for one in parts if isinstance(one, Prism)]
    if drive is None or len(discs) != len(parts):
        raise DesignError(NO_RING)
    number, theta = plate_angle(drive, discs, angle)
    touch = drive.touches[number]
    disc = next((one for one in discs if one.outer.outline is touch.outline), discs[0])
    plate = PlateSection(disc)
    patch = plate_patch(drive, number, disc, theta)
    return BodyVolume(disc.name, ring_about(plate, patch.middle, STEP), material, patch)
