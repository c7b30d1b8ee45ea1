"""Stress at a groove's root under its duty: nominal over the turn, and the peak where the root is round.

The nominal stress is that of a beam: the stress out of the groove, of a drum the radial one, linearised over the wall's
thickness at the flank's foot, which hardly hangs on the mesh and exists for a sharp root too. The peak is the largest
principal stress on the root's face under one load, by default that of the largest force over squared wall thickness; it
is given where two meshes, refined along the root and normal to it, agree.
The whole ring is solved: a block cut out of it would be too soft.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees
from typing import Any, final

import numpy as np
import numpy.typing as npt

from camgeom.body.cut import Cut, cut_of
from camgeom.body.element import NATURAL, largest_principal, shapes, stresses, tensors
from camgeom.body.groove import Groove
from camgeom.body.load import Patch, RollerLoad, nodal_forces
from camgeom.body.ring import RingMesh, even_planes, ring_about, ring_of
from camgeom.body.section import Fineness, GroovedSection
from camgeom.body.solver import Elastic
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.material import Material
from camgeom.mechanics.roller_duty import RollerDuty
from camgeom.track import TURN

Index = npt.NDArray[np.int64]
ANGLES = 72
"""cam angles of the curve, and planes of its mesh"""
AGREE = 0.05
"""share within which the peaks of two meshes agree"""
CONTACT = 1.0 / 3.0
"""share of the root's height below the flank's foot in which the contact's own stress is larger than the bending's"""
STEPS = (0.05, 0.035)
"""rad between the planes beside the load, of the two meshes"""


@final
@dataclass(frozen=True, eq=False)
class Peak:
    """The peak on one mesh: stress, MPa, its point (3,), mm, the unknowns that were solved for, and a section there."""

    value: float
    point: Floats
    unknowns: int
    cut: Cut | None = None


@final
@dataclass(frozen=True, eq=False)
class RootStress:
    """Stress at the root of a body with one closed groove, from its duty.

    angle  rad, asked of the peak; None: where force over squared thickness of the wall is largest
    """

    groove: Groove
    duty: RollerDuty
    material: Material
    angle: float | None = None

    @cached_property
    def theta(self) -> Floats:
        """Cam angles of the curve, rad."""
        return np.linspace(0.0, TURN, ANGLES, endpoint=False)

    @cached_property
    def _coarse(self) -> GroovedSection:
        return GroovedSection.of(self.groove, Fineness())

    @cached_property
    def load(self) -> RollerLoad:
        """What presses its walls."""
        return RollerLoad(self._coarse.groove, self.duty)

    @cached_property
    def patches(self) -> dict[int, Patch]:
        """The pressed patches by the number of their angle."""
        pressed = np.flatnonzero(self.load.force.presses(self.theta)).tolist()
        return {i: self.load.patch(float(self.theta[i])) for i in pressed}

    @cached_property
    def nominal(self) -> Floats:
        """Largest nominal stress, MPa, of the pressed wall at the curve's angles; 0 where nothing presses.

        One factorisation; all angles are solved together.
        """
        found = np.zeros(len(self.theta))
        if self.patches:
            ring = ring_of(self._coarse, even_planes(ANGLES))
            patches = list(self.patches.values())
            moved = self._elastic(ring).solve(nodal_forces(ring, patches))
            for k, (i, patch) in enumerate(self.patches.items()):
                found[i] = self._linearised(ring, moved[:, :, k], patch.second).max()
        return found

    @cached_property
    def worst(self) -> Extreme:
        """Largest nominal stress of the curve, MPa."""
        i = int(np.argmax(self.nominal))
        return Extreme(float(self.nominal[i]), float(self.theta[i]))

    @cached_property
    def patch(self) -> Patch:
        """The load that the peak is asked of."""
        return self.load.asked(self.angle)

    @cached_property
    def peaks(self) -> tuple[Peak, ...]:
        """The peak on the coarser and the finer mesh; none of a sharp root, whose stress has no end."""
        if not self.groove.shape.root:
            return ()
        return tuple(self._peak(times, step) for times, step in enumerate(STEPS, start=1))

    @property
    def disagreement(self) -> float | None:
        """Share by which the two peaks differ; None of a sharp root."""
        if not self.peaks:
            return None
        coarse, fine = (peak.value for peak in self.peaks)
        return abs(coarse - fine) / fine

    @property
    def peak(self) -> float | None:
        """Peak stress, MPa; None of a sharp root, or where two meshes do not agree."""
        apart = self.disagreement
        return self.peaks[-1].value if apart is not None and apart <= AGREE else None

    @property
    def hardest(self) -> bool:
        """Whether the nominal stress is about largest under the load that the peak is asked of."""
        here = float(np.interp(self.patch.theta % TURN, self.theta, self.nominal, period=TURN))
        return here >= (1.0 - AGREE) * self.worst.value

    @property
    def why_no_peak(self) -> str:
        """Why there is no peak; empty where there is one."""
        if not self.groove.shape.root:
            return "a sharp root has no stress that a mesh could find: give cutter.corner_radius or cam.root_radius"
        if self.peak is None:
            coarse, fine = (peak.value for peak in self.peaks)
            return f"two meshes differ by more than {AGREE:.0%}: {coarse:.4g} and {fine:.4g} MPa"
        return ""

    def data(self) -> dict[str, Any]:
        """As plain data for result.json."""
        worst, patch = self.worst, self.patch
        data: dict[str, Any] = {
            "nominal_stress_mpa": worst.value,
            "nominal_at_deg": degrees(worst.cam_angle),
            "load_angle_deg": degrees(patch.theta),
            "load_n": patch.normal,
            "wall_mm": patch.thickness,
            "where": f"root of {patch.where}",
            "hardest_load": self.hardest,
            "peak_stress_mpa": self.peak,
        }
        if self.peaks:
            data |= {"meshes_mpa": [one.value for one in self.peaks], "point_mm": self.peaks[-1].point.tolist()}
            data |= {"unknowns": self.peaks[-1].unknowns}
        if self.why_no_peak:
            data["no_peak"] = self.why_no_peak
        limit = self.material.bending_limit
        if limit is not None and self.peak is not None:
            data["fatigue_factor"] = limit / self.peak
        return data

    def _elastic(self, ring: RingMesh) -> Elastic:
        return Elastic(ring, self.material.elastic_modulus, self.material.poisson)

    def _linearised(self, ring: RingMesh, moved: Floats, second: bool) -> Floats:
        """Nominal stress (n,), MPa, of one wall in every plane: membrane and bending of that out of the groove."""
        layer, wall = self._coarse.wall_cells(second)
        nodes = ring.elements.reshape(len(ring.planes), -1, 20)
        at = np.array([[s, -1.0 if second else 1.0, -1.0] for s in (-1.0, 0.0, 1.0)])
        below = np.array([[s, -1.0, -1.0] for s in ((-1.0, 0.0, 1.0) if second else (1.0, 0.0, -1.0))])
        across: list[Floats] = []
        places: list[Floats] = []
        for cells, points in ((layer, at), (wall, below)):
            for cell in cells:
                stress, x = _sampled(ring, moved, nodes[:, cell], points, self._elastic(ring).material)
                away = self.groove.outward(x)
                across.append(np.einsum("npi,npij,npj->np", away, tensors(stress), away))
                places.append(self.groove.uv(x[..., 2], np.hypot(x[..., 0], x[..., 1]))[0])
        force = np.zeros(len(ring.planes))
        moment = np.zeros(len(ring.planes))
        start, total = places[0][:, 0], np.abs(places[-1][:, -1] - places[0][:, 0])
        for sigma, z in zip(across, places):
            width = np.abs(z[:, -1] - z[:, 0])[:, None] * np.array([1.0, 4.0, 1.0]) / 6.0
            force += (width * sigma).sum(axis=1)
            moment += (width * sigma * (0.5 * total[:, None] - np.abs(z - start[:, None]))).sum(axis=1)
        return np.asarray(force / total + 6.0 * moment / total**2)

    def _peak(self, times: int, step: float) -> Peak:
        patch = self.patch
        section = GroovedSection.of(self.groove, Fineness.fine_at(patch.second, times))
        ring = ring_about(section, patch.middle, step)
        problem = self._elastic(ring)
        moved = problem.solve(nodal_forces(ring, [patch]))[:, :, 0]
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
        cut = cut_of(ring, moved, problem.material, section, float(np.arctan2(point[1], point[0])))
        return Peak(float(found[element, corner]), point, problem.cost.unknowns, cut)


FACE = (0, 3, 4, 7, 11, 15, 16, 19)
"""nodes of an element on its face at the contour"""


def _sampled(ring: RingMesh, moved: Floats, nodes: Index, points: Floats, material: Floats) -> tuple[Floats, Floats]:
    """Stresses (n, p, 6) of elements with nodes (n, 20) at natural coordinates (p, 3), and the points (n, p, 3)."""
    x = ring.nodes[nodes]
    return stresses(x, moved[nodes], points, material), np.einsum("pa,nak->npk", shapes(points)[0], x)
