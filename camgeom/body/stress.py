"""Stress at a wall's root under its duty: nominal over the turn, and the peak where the root is round.

The nominal stress is that of a beam: the stress out of the groove, of a drum the radial one, of an end face's ring the
axial one, linearised over the wall's thickness at the flank's foot (the web), which hardly hangs on the mesh and exists
for a sharp root too. The peak is the largest
principal stress on the root's face under one load, by default that of the largest force over squared wall thickness; it
is given where two meshes, refined along the root and normal to it, agree.
The whole ring is solved: a block cut out of it would be too soft.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import degrees
from typing import Any, Protocol, final

import numpy as np

from camgeom.body.cut import Cut
from camgeom.body.groove import Walled
from camgeom.body.load import LoadPatch, RollerLoad, asked_patch, nodal_forces
from camgeom.body.ring import RingMesh, SweptSection, even_planes, ring_of
from camgeom.body.solver import Elastic, elastic
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.duty import free
from camgeom.mechanics.material import Material
from camgeom.mechanics.roller_duty import RollerDuty
from camgeom.track import TURN

ANGLES = 72
"""cam angles of the curve, and planes of its mesh"""
NEAR = 1e-9
"""rad; angles nearer to each other are one"""
AGREE = 0.05
"""share within which the peaks of two meshes agree"""


@final
@immutable
class StressPeak:
    """The peak on one mesh: stress, MPa, its point (3,), mm, the unknowns that were solved for, and a section there."""

    value: float
    point: Floats
    unknowns: int
    cut: Cut | None = None


class PeakLoad(Protocol):
    """The load that a peak is asked of."""

    @property
    def theta(self) -> float:
        """Cam angle, rad."""

    @property
    def normal(self) -> float:
        """Force, N."""

    @property
    def thickness(self) -> float:
        """Of the wall that it bends, mm."""


class Stressed(Protocol):
    """A body that bends under its duty: nominal stress over the turn, and the peak under one load."""

    @property
    def material(self) -> Material:
        """Of the body."""

    @property
    def theta(self) -> Floats:
        """Cam angles (n,) of the curve, rad."""

    @property
    def nominal(self) -> Floats:
        """Largest nominal stress (n,), MPa; 0 where nothing presses."""

    @property
    def notches(self) -> tuple[Floats, Floats] | None:
        """That at round corners alone, and at sharp ones beside; None where the nominal stress is told nowhere else."""

    def where(self, theta: float) -> str:
        """The place of the nominal stress at a cam angle, rad, in words."""

    @property
    def patch(self) -> PeakLoad:
        """The load that the peak is asked of."""

    @property
    def root(self) -> str:
        """The place of that peak in words."""

    @property
    def peaks(self) -> tuple[StressPeak, ...]:
        """The peak on the coarser and the finer mesh; none of a sharp root, whose stress has no end."""

    @property
    def sharp(self) -> str:
        """Why its root has no peak stress; empty of a round one."""

    @property
    def remedy(self) -> str:
        """What makes its stress smaller."""


@final
@immutable
class RootStress:
    """Stress at the root of a body's pressed wall, from its duty."""

    body: Stressed

    @cached_property
    def theta(self) -> Floats:
        """Cam angles of the curve, rad."""
        return self.body.theta

    @cached_property
    def nominal(self) -> Floats:
        """Largest nominal stress, MPa, at the curve's angles; 0 where nothing presses."""
        return self.body.nominal

    @cached_property
    def worst(self) -> Extreme:
        """Largest nominal stress of the curve, MPa, and what is pressed then."""
        i = int(np.argmax(self.nominal))
        theta = float(self.theta[i])
        return Extreme(float(self.nominal[i]), theta, where=self.body.where(theta) if self.nominal[i] else "")

    @property
    def patch(self) -> PeakLoad:
        """The load that the peak is asked of."""
        return self.body.patch

    @cached_property
    def peaks(self) -> tuple[StressPeak, ...]:
        """The peak on the coarser and the finer mesh; none of a sharp root."""
        return self.body.peaks

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
        """Whether the nominal stress of a corner is about largest under the load that the peak is asked of, there."""
        rounded, sharp = self.body.notches or (self.nominal, self.nominal)
        here = float(np.interp(self.patch.theta % TURN, self.theta, rounded, period=TURN))
        return here >= (1.0 - AGREE) * max(float(rounded.max()), float(sharp.max()))

    @property
    def why_no_peak(self) -> str:
        """Why there is no peak; empty where there is one."""
        if self.body.sharp:
            return self.body.sharp
        if self.peak is None:
            coarse, fine = (peak.value for peak in self.peaks)
            return f"two meshes differ by more than {AGREE:.0%}: {coarse:.4g} and {fine:.4g} MPa"
        return ""

    def data(self) -> dict[str, Any]:
        """As plain data for result.json; of a sharp root there is no load that a peak is asked of."""
        worst, patch = self.worst, self.patch
        data: dict[str, Any] = {
            "nominal_stress_mpa": worst.value,
            "nominal_at_deg": degrees(worst.cam_angle),
            "nominal_where": worst.where,
            "peak_stress_mpa": self.peak,
        }
        if not self.body.sharp:
            data |= {"load_angle_deg": degrees(patch.theta), "load_n": patch.normal, "wall_mm": patch.thickness,
                     "where": self.body.root, "hardest_load": self.hardest}  # fmt: skip
        if self.peaks:
            data |= {"meshes_mpa": [one.value for one in self.peaks], "point_mm": self.peaks[-1].point.tolist()}
            data |= {"unknowns": self.peaks[-1].unknowns}
        if self.why_no_peak:
            data["no_peak"] = self.why_no_peak
        limit = self.body.material.bending_limit
        if limit is not None and self.peak is not None:
            data["fatigue_factor"] = limit / self.peak
        return data


class Bending(Protocol):
    """A ring body with a wall that bends on its root."""

    @property
    def section(self) -> SweptSection:
        """The coarse section that is swept for the nominal stress."""

    @property
    def walled(self) -> Walled:
        """What a roller presses."""

    @property
    def sharp(self) -> str:
        """Why its root has no peak stress; empty of a round one."""

    @property
    def remedy(self) -> str:
        """What makes its stress smaller."""

    def nominal(self, ring: RingMesh, moved: Floats, patch: LoadPatch, material: Floats) -> Floats:
        """Nominal stress (2 n,), MPa, of the pressed wall between the planes of a ring with displacements (v, 3)."""

    def peaks(self, patch: LoadPatch, material: Material) -> tuple[StressPeak, ...]:
        """The peak on the coarser and the finer mesh; none of a sharp root, whose stress has no end."""


@final
@immutable
class PressedRing:
    """A ring body under its rollers; see `Stressed`.

    angle   rad, asked of the peak; None: where force over squared thickness of the wall is largest
    solved  gives the nominal stress where it is solved together with that of others, see `nominals`
    paid    raise NotConverged where this wall over the turn, and where this peak would take too long
    """

    ring: Bending
    duties: tuple[RollerDuty, ...]
    material: Material
    angle: float | None = None
    solved: Callable[[], Floats] | None = None
    paid: tuple[Callable[[], None], Callable[[], None]] = (free, free)

    @property
    def notches(self) -> None:
        """None."""

    @property
    def sharp(self) -> str:
        """Why there is no peak."""
        return self.ring.sharp

    @property
    def remedy(self) -> str:
        """What makes its stress smaller."""
        return self.ring.remedy

    @cached_property
    def theta(self) -> Floats:
        """Cam angles of the curve, rad: even ones, and those of the largest force over squared thickness of each
        roller, which a short rise has between them."""
        return with_hardest(np.array([load.hardest.cam_angle for load in self._loads]))

    @cached_property
    def _loads(self) -> tuple[RollerLoad, ...]:
        return tuple(RollerLoad(self.ring.walled, duty) for duty in self.duties)

    @cached_property
    def patches(self) -> dict[int, list[LoadPatch]]:
        """The pressed patches by the number of their angle."""
        found: dict[int, list[LoadPatch]] = {}
        for load in self._loads:
            for i in np.flatnonzero(load.force.presses(self.theta)).tolist():
                found.setdefault(i, []).append(load.patch(float(self.theta[i])))
        return found

    @cached_property
    def nominal(self) -> Floats:
        """Of the pressed wall."""
        self.paid[0]()
        return nominals((self,))[0] if self.solved is None else self.solved()

    def under(self, mesh: RingMesh, solver: Elastic) -> Floats:
        """The same on its mesh; all angles are solved together."""
        found = np.zeros(len(self.theta))
        moved = solver.solve(nodal_forces(mesh, list(self.patches.values())))
        for k, (i, pressed) in enumerate(self.patches.items()):
            found[i] = max(self.ring.nominal(mesh, moved[:, :, k], one, solver.material).max() for one in pressed)
        return found

    def where(self, theta: float) -> str:
        """The root of what is pressed hardest then; empty where nothing is."""
        pressed = self.patches.get(int(np.argmin(np.abs(self.theta - theta))), [])
        hardest = max(pressed, key=lambda patch: patch.normal, default=None)
        return "" if hardest is None else f"root of {hardest.where}"

    @cached_property
    def patch(self) -> LoadPatch:
        """The load that the peak is asked of."""
        return asked_patch(self.ring.walled, self.duties, self.angle)

    @property
    def root(self) -> str:
        """Of what is pressed then."""
        return f"root of {self.patch.where}"

    @cached_property
    def peaks(self) -> tuple[StressPeak, ...]:
        """On the coarser and the finer mesh. Raises NotConverged where those of the design would take too long."""
        self.paid[1]()
        return self.ring.peaks(self.patch, self.material)


def nominals(rings: Sequence[PressedRing]) -> list[Floats]:
    """The nominal stress (a,), MPa, of each, with one factorisation for all whose meshes are the same."""
    found = [np.zeros(len(one.theta)) for one in rings]
    left = [(k, one, ring_of(one.ring.section, even_planes(ANGLES))) for k, one in enumerate(rings) if one.patches]
    while left:
        _, first, mesh = left[0]
        alike = [
            (k, one) for k, one, other in left
            if one.material == first.material and np.array_equal(mesh.nodes, other.nodes)
            and np.array_equal(mesh.elements, other.elements)
        ]  # fmt: skip
        solver = elastic(mesh, first.material)
        for k, one in alike:
            found[k] = one.under(mesh, solver)
        left = [each for each in left if each[:2] not in alike]
    return found


def with_hardest(hardest: Floats) -> Floats:
    """Even cam angles round the turn and the hardest ones, rad, ascending."""
    even = np.linspace(0.0, TURN, ANGLES, endpoint=False)
    return np.union1d(even, hardest[np.abs(hardest[:, None] - even).min(axis=1) > NEAR])
