"""The walls that bend under a roller, ring body by ring body; see `camgeom.body.stress.Bending`."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar, final

import numpy as np
import numpy.typing as npt

from camgeom.body.cut import cut_of
from camgeom.body.element import NATURAL, largest_principal, shapes, stresses, tensors
from camgeom.body.end_face import EndFaceSection
from camgeom.body.groove import Groove, Walled, groove_of
from camgeom.body.grooves import DrumGrooves, DrumStack, PlateFaces, PlateGrooves, grooves_of
from camgeom.body.load import LoadPatch, nodal_forces
from camgeom.body.rib import RibSection
from camgeom.body.ring import RingMesh, ring_about
from camgeom.body.section import Fineness, GroovedSection
from camgeom.body.solver import elastic
from camgeom.body.stress import Bending, StressPeak
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.material import Material
from camgeom.solid import Part
from camgeom.solid.drum import EndFaceRing, RibbedCylinder
from camgeom.track import Track

Index = npt.NDArray[np.int64]
CONTACT = 1.0 / 3.0
"""share of the root's height below the flank's foot in which the contact's own stress is larger than the bending's"""
GAUSS = 3.0**-0.5
"""natural coordinate at which an element tells its stress best"""
NO_CORNER = "no tool with a corner cuts the flank of a cone or a crown that it conforms to"
STEPS = (0.05, 0.035)
"""rad between the planes beside the load, of the two meshes"""


@final
@immutable
class GrooveBending:
    """The walls beside a closed groove; see `Bending`.

    body, track  of several grooves: all of them, and the number of this one's track
    """

    groove: Groove
    body: DrumGrooves | PlateGrooves | None = None
    track: int = 0

    @cached_property
    def section(self) -> GroovedSection | DrumStack | PlateFaces:
        """Coarse."""
        return self._section(Fineness())

    def _section(self, cells: Fineness) -> GroovedSection | DrumStack | PlateFaces:
        return GroovedSection.of(self.groove, cells) if self.body is None else self.body.section(self.track, cells)

    @property
    def walled(self) -> Walled:
        """The groove, rounded where it is sharp."""
        own = GroovedSection.of(self.groove, Fineness()).groove
        return own if self.body is None else self.body.walled(self.track)

    @property
    def sharp(self) -> str:
        """Why there is no peak."""
        if self.groove.shape.root:
            return ""
        way = "give cutter.corner_radius or cam.root_radius" if self.groove.straight else NO_CORNER
        return f"a sharp root has no stress that a mesh could find: {way}"

    @property
    def remedy(self) -> str:
        """What makes its stress smaller."""
        return "a thicker wall or a larger root radius"

    def peaks(self, patch: LoadPatch, material: Material) -> tuple[StressPeak, ...]:
        """On two meshes."""
        if self.sharp:
            return ()
        return tuple(self.peak(patch, material, times, step) for times, step in enumerate(STEPS, start=1))

    def nominal(self, ring: RingMesh, moved: Floats, patch: LoadPatch, material: Floats) -> Floats:
        """Membrane and bending of the stress out of the groove, at the flank's foot."""
        nodes = ring.elements.reshape(len(ring.planes), -1, 20)
        across: list[Floats] = []
        places: list[Floats] = []
        for cell, points in self.section.wall_path(patch.second):
            stress, x = _sampled(ring, moved, nodes[:, cell], points, material)
            away = self.groove.outward(x)
            across.append(np.einsum("npi,npij,npj->np", away, tensors(stress), away))
            places.append(self.groove.uv(x[..., 2], np.hypot(x[..., 0], x[..., 1]))[0])
        membrane, bending = linearised(np.array(places), np.array(across))
        return membrane + bending

    def peak(self, patch: LoadPatch, material: Material, times: int, step: float) -> StressPeak:
        """Largest principal stress on the root's face under a patch, on a mesh so many times refined."""
        section = self._section(Fineness.fine_at(patch.second, times))
        ring = ring_about(section, patch.middle, step)
        problem = elastic(ring, material)
        moved = problem.solve_one(nodal_forces(ring, [[patch]])[:, :, 0])
        cells = ring.contour[section.root_cells(patch.second)]
        nodes = ring.elements.reshape(len(ring.planes), -1, 20)[:, cells].reshape(-1, 20)
        x = ring.nodes[nodes]
        found = largest_principal(stresses(x, moved[nodes], NATURAL[list(FACE)], problem.material))
        # Beside the flank's foot, where the contact line ends, the stress is the contact's, which Hertz judges.
        face, shape = x[:, FACE], self.groove.shape
        _, height = self.groove.uv(face[..., 2], np.hypot(face[..., 0], face[..., 1]))
        free = height <= shape.foot - CONTACT * shape.root
        found = np.where(free, found, -np.inf)
        element, corner = np.unravel_index(int(np.argmax(found)), found.shape)
        point = x[element, FACE[corner]]
        azimuth = float(np.arctan2(point[1], point[0]))
        cut = cut_of(ring, moved, problem.material, section.outline, shape.depth, azimuth)
        return StressPeak(float(found[element, corner]), point, problem.cost.unknowns, cut)


def linearised(places: Floats, stress: Floats) -> tuple[Floats, Floats]:
    """Membrane and bending stress (n,), MPa, that is positive at the first place, of stresses (c, n, 3) at the ends and
    middles, in mm (c, n, 3), of cells across a wall."""
    depth = np.abs(places - places[:1, :, :1])
    total = depth[-1, :, -1]
    width = np.abs(places[:, :, -1] - places[:, :, 0])[:, :, None] * np.array([1.0, 4.0, 1.0]) / 6.0
    force = (width * stress).sum(axis=(0, 2))
    moment = (width * stress * (0.5 * total[:, None] - depth)).sum(axis=(0, 2))
    return force / total, 6.0 * moment / total**2


@immutable
class Cornered(ABC):
    """A wall that stands in a sharp corner, whose stress no mesh finds; see `Bending`.

    sharp, remedy  why there is no peak, and what makes its stress smaller
    """

    sharp: ClassVar[str]
    remedy: ClassVar[str]
    section: EndFaceSection | RibSection

    @property
    def walled(self) -> Walled:
        """The wall."""
        return self.section

    @abstractmethod
    def nominal(self, ring: RingMesh, moved: Floats, patch: LoadPatch, material: Floats) -> Floats:
        """Membrane and bending of the stress out of the corner, on the side that is pulled more."""

    def peaks(self, patch: LoadPatch, material: Material) -> tuple[StressPeak, ...]:
        """None."""
        del patch, material
        return ()


@final
@immutable
class FaceBending(Cornered):
    """The ring of an end-face cam on its web; see `Bending`."""

    section: EndFaceSection
    sharp = "the ring of an end-face cam stands on its web in a sharp corner, whose stress no mesh finds"
    remedy = "a thicker ring, or a lower one"

    def nominal(self, ring: RingMesh, moved: Floats, patch: LoadPatch, material: Floats) -> Floats:
        """Membrane and bending of the axial stress above the web, on the side that is pulled more."""
        del patch
        nodes = ring.elements.reshape(len(ring.planes), -1, 20)
        at = np.array([[1.0, s] for s in (-1.0, 0.0, 1.0)])
        found = [_sampled(ring, moved, nodes[:, cell], at, material) for cell in self.section.foot_cells]
        membrane, bending = linearised(np.array([np.hypot(x[..., 0], x[..., 1]) for _, x in found]),
                                       np.array([stress[..., 2] for stress, _ in found]))  # fmt: skip
        return np.asarray(np.maximum(membrane + np.abs(bending), 0.0))


@final
@immutable
class RibBending(Cornered):
    """A drum's rib on its foot; see `Bending`."""

    section: RibSection
    sharp = "a rib stands on its drum in a sharp corner, whose stress no mesh finds"
    remedy = "a thicker rib (`cam.rib_thickness`), a lower one, or a gentler motion, which leaves more of it"

    def nominal(self, ring: RingMesh, moved: Floats, patch: LoadPatch, material: Floats) -> Floats:
        """Membrane and bending of the radial stress at the foot, on the side that is pulled more: from Gauss points
        above it, since no mesh tells the stress in the corners themselves."""
        del patch
        near, far = (self._linearised(ring, moved, material, share) for share in (-GAUSS, GAUSS))
        foot = near + (near - far) * (1.0 / GAUSS - 1.0) / 2.0
        return np.asarray(np.maximum(foot[0] + np.abs(foot[1]), 0.0))

    def _linearised(self, ring: RingMesh, moved: Floats, material: Floats, up: float) -> Floats:
        """Membrane and bending (2, n) at a natural place up the flank in the cells on the foot."""
        nodes = ring.elements.reshape(len(ring.planes), -1, 20)
        across: list[Floats] = []
        places: list[Floats] = []
        for cell, s, foot in self.section.foot_cells:
            at = np.array([[one, -foot * up] for one in s])
            stress, x = _sampled(ring, moved, nodes[:, cell], at, material)
            out = x * np.array([1.0, 1.0, 0.0]) / np.hypot(x[..., 0], x[..., 1])[..., None]
            across.append(np.einsum("npi,npij,npj->np", out, tensors(stress), out))
            places.append(x[..., 2])
        return np.array(linearised(np.array(places), np.array(across)))


def bending_of(part: Part, cutters: tuple[Track, ...], several: Sequence[tuple[Track, ...]] = (), track: int = 0
               ) -> Bending | None:  # fmt: skip
    """The walls of a body that a roller bends; None of one without any that are known.

    several, track  the tools of each of several tracks, and the number of the one that is asked of
    """
    if len(several) > 1:
        body = grooves_of(part, several)
        return None if body is None else GrooveBending(body.grooves[body.tracks.index(track)], body, track)
    if isinstance(part, RibbedCylinder):
        return RibBending(RibSection.of(part))
    if isinstance(part, EndFaceRing):
        return FaceBending(EndFaceSection(part))
    groove = groove_of(part, cutters)
    return None if groove is None else GrooveBending(groove)


FACE = (0, 3, 4, 7, 11, 15, 16, 19)
"""nodes of an element on its face at the contour"""


def _sampled(ring: RingMesh, moved: Floats, nodes: Index, points: Floats, material: Floats) -> tuple[Floats, Floats]:
    """Stresses (2 n, p, 6) of elements with nodes (n, 20) at natural coordinates (p, 2) in both planes of their Gauss
    points round the ring, and the points (2 n, p, 3).

    In the planes between them elements tell it apart, by up to half.
    """
    x = ring.nodes[nodes]
    at = [np.column_stack([points, np.full(len(points), way)]) for way in (-GAUSS, GAUSS)]
    stress = np.concatenate([stresses(x, moved[nodes], one, material) for one in at])
    return stress, np.concatenate([np.einsum("pa,nak->npk", shapes(one)[0], x) for one in at])
