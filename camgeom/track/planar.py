"""Facts of a planar cam and its follower, whatever touches: pressure angle, curvature, folds, crossings, faces, width.

Every extreme is refined on the exact curves between the knots of the motion. Curvature is counted for the cam's
material: convex is positive, also on the outer flank of a face groove.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import degrees, pi
from typing import final

import numpy as np

from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme
from camgeom.maths.frozen import cached_property
from camgeom.motion.program import Program
from camgeom.track import Slide, Swing
from camgeom.track.outline import Crossing, Outline, crossing
from camgeom.track.survey import largest, smallest
from camgeom.track.touch import Contacting, Touch

SMALLEST_JUMP = 1e-6
"""share of the largest curvature above which a step counts as a jump"""


@immutable(eq=True)
class CurvatureJump:
    """A step of the profile's curvature, 1/mm: cam angle (rad), before, after, and the touch."""

    cam_angle: float
    before: float
    after: float
    touch: str


@final
@immutable
class Planar:
    """A planar cam seen by what touches it.

    touches   one (held by a spring or by weight) or two (form-closed)
    outlines  closed curves by name
    span      constant width of the cam between parallel faces, or None, mm
    centre    place on a flat face, mm, that its width is centred on
    """

    touches: tuple[Touch, ...]
    outlines: Mapping[str, Outline]
    program: Program
    span: float | None = None
    centre: float = 0.0

    @property
    def walls(self) -> tuple[Touch, ...]:
        """One touch for each wall: of a flank that leans that of its lower end."""
        return tuple({touch.way: touch for touch in reversed(self.touches)}.values())[::-1]

    @property
    def form_closed(self) -> bool:
        """True where the cam drives the follower both ways."""
        return {touch.way for touch in self.touches} == {1.0, -1.0}

    @cached_property
    def pressure_angle(self) -> Extreme:
        """Largest magnitude of the pressure angle, rad."""
        return largest(self.touches, lambda at: np.abs(at.pressure_angle))

    @cached_property
    def pressure_angle_range(self) -> tuple[Extreme, Extreme]:
        """Least and greatest signed pressure angle, rad."""
        return smallest(self.touches, lambda at: at.pressure_angle), largest(self.touches, lambda at: at.pressure_angle)

    @cached_property
    def curvature_range(self) -> tuple[Extreme, Extreme]:
        """Least and greatest curvature of the cam's material, 1/mm; negative where it is hollow."""

        def curvature(at: Contacting) -> Floats:
            return at.touch.material * at.curve.curvature

        return smallest(self.touches, curvature), largest(self.touches, curvature)

    @cached_property
    def largest_radius(self) -> Extreme:
        """Largest distance of a profile from the cam axis, mm: the circle that it sweeps."""
        return largest(self.touches, lambda at: np.hypot(*at.curve.points))

    @cached_property
    def radii(self) -> tuple[Extreme | None, Extreme | None]:
        """Smallest convex and smallest hollow radius of curvature of the profile, mm; None where there is none.

        A grinding wheel or cutter reaches every place of the profile where it is smaller than the hollow radius.
        """
        low, high = self.curvature_range
        convex = replace(high, value=1.0 / high.value) if high.value > 0.0 else None
        hollow = replace(low, value=-1.0 / low.value) if low.value < 0.0 else None
        return convex, hollow

    @cached_property
    def face_radius(self) -> Extreme | None:
        """Smallest radius of curvature of a profile that flat faces envelop, mm; it must be positive. None: no face.

        Unlike a curvature it goes smoothly through zero where the profile begins to fold.
        """
        flat = tuple(touch for touch in self.touches if touch.kind == "flat")
        if not flat:
            return None
        return smallest(self.touches, lambda at: 1.0 / at.curve.curvature)

    def refuse_folded(self) -> None:
        """Raise DesignError where a flat face envelops a profile that folds back on itself."""
        worst = self.face_radius
        if worst is not None and worst.value <= 0.0:
            raise DesignError(
                f"{worst.where}: the profile folds at cam angle {degrees(worst.cam_angle) % 360.0:.6g} deg (radius of "
                f"curvature {worst.value:.6g} mm, must be above 0), so that it bounds no solid; {self.fold_advice}"
            )

    @property
    def fold_advice(self) -> str:
        """What makes a folded profile of a flat face good."""
        worst = self.face_radius
        if worst is None:
            return ""
        if isinstance(self.touches[0].joint, Slide):
            return f"enlarge base_radius by more than {max(0.0, -worst.value):.6g} mm, or take a gentler motion"
        return "enlarge base_radius, or take a gentler motion"

    @cached_property
    def crossings(self) -> dict[str, Crossing | None]:
        """Where a profile crosses itself, by the touch's name; None where it does not."""
        return {touch.where: crossing(touch.outline) for touch in self.touches}

    @cached_property
    def curvature_jumps(self) -> tuple[CurvatureJump, ...]:
        """Cam angles at which the curvature of a profile jumps (one-sided values at the knots).

        A flank that leans jumps at all of its heights alike: counted once, at its lower end.
        """
        found = []
        for touch in self.touches[:1] if self.span is not None else self.walls:
            (_, owner), at = touch.grid, touch.sampled
            k = touch.material * at.curve.curvature
            first = np.flatnonzero(np.r_[True, owner[1:] != owner[:-1]])
            last = np.r_[first[1:], len(owner)] - 1
            knot = touch.knots()
            before, after = k[np.roll(last, 1)], k[first]
            large = np.abs(after - before) > SMALLEST_JUMP * np.abs(k).max()
            found += [
                CurvatureJump(float(knot[i]) % (2.0 * pi), float(before[i]), float(after[i]), touch.where)
                for i in np.flatnonzero(large)
            ]
        return tuple(found)

    @cached_property
    def face_needed(self) -> Extreme | None:
        """Width that a flat face needs, mm: centred on its line (translating), or its length from the pivot on."""
        flat = [touch for touch in self.touches if touch.kind == "flat"]
        if not flat:
            return None
        if isinstance(flat[0].joint, Swing):
            return largest(self.touches, lambda at: np.abs(at.along))
        return largest(self.touches, lambda at: 2.0 * np.abs(at.along - at.touch.way * self.centre))

    @cached_property
    def sliding(self) -> Extreme | None:
        """Largest sliding of the cam over a follower that does not roll, mm per rad of cam angle."""
        if all(touch.rolling for touch in self.touches):
            return None
        return largest(self.touches, lambda at: at.sliding)

    @cached_property
    def width_residual(self) -> Extreme | None:
        """Largest deviation of the cam's width between parallel faces from the nominal, mm; None without such faces."""
        if self.span is None or len(self.touches) != 2 or self.touches[0].kind != "flat":
            return None
        near, far = self.touches
        phi, _ = near.grid
        one, two = near.at(phi).curve, far.at(phi).curve
        width = ((one.points - two.points) * one.normals).sum(axis=0)
        at = int(np.argmax(np.abs(width - self.span)))
        return Extreme(float(width[at] - self.span), float(phi[at]), where=near.name)

    @property
    def top_share(self) -> float:
        """Share of the turn in which the follower rests at its largest lift (contact time of a press)."""
        top = max(max(span.before, span.after) for span in self.program.spans)
        rest = sum(s.end - s.start for s in self.program.spans if s.before == s.after == top)
        return rest / (2.0 * pi)

