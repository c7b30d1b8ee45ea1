"""Where a planar cam touches its follower: the outline, the joint that carries the follower, and the follower's shape.

A touch pushes the follower one way. A cam held by a spring has one, a form-closed cam two that push against each
other: the two flanks of a face groove, the two faces of a frame, the two discs of a conjugate pair.
"""

from __future__ import annotations

from math import cos, inf
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import piece_grid
from camgeom.maths.frozen import cached_property
from camgeom.track import Joint, Slide, Swing
from camgeom.track.outline import Curve, Outline

if TYPE_CHECKING:
    from camgeom.track.survey import Grid


@immutable
class Contacting:
    """One touch at cam angles phi (n,).

    touch            whose contact it is
    curve            the cam's outline there
    lever            velocity of the contact point along the force on the follower, per unit of the joint coordinate
                     (1 or mm/rad), signed: positive where the force drives towards larger lift
    pressure_angle   rad, between the force and the velocity of the follower's point: a roller's centre, else the point
                     of contact; signed, positive in the rise of a follower without offset. A leaning force has that of
                     both angles, cos(a) cos(lean), with the sign of the one in the plane, a
    relative         relative curvature of cam against follower across their line of contact, 1/mm; infinite for a knife
                     edge
    along            place of the contact on a flat face, mm along the face from the follower's reference point
    slip             speed of the follower's point over the cam, of one that does not roll, along the tangent turned
                     left from the outward normal, in which `curve.speed` counts; mm per rad
    """

    touch: Touch
    curve: Curve
    lever: Floats
    pressure_angle: Floats
    relative: Floats
    along: Floats
    slip: Floats

    @cached_property
    def sliding(self) -> Floats:
        """Speed of the cam over a follower that does not roll, mm per rad."""
        return np.abs(self.slip)

    @cached_property
    def passing(self) -> Floats:
        """Mean speed of both surfaces through the contact, which moves itself, mm per rad: it draws the oil in.

        The contact runs along the cam by `curve.speed`, along the follower by less the slip; a roller rolls.
        """
        return np.abs(self.curve.speed - (0.0 if self.touch.rolling else 0.5 * self.slip))


@immutable
class Touch:
    """One contact of a planar cam with its follower.

    outline   the cam's profile there, travelled with the cam angle
    joint     what carries the follower
    sense     +1 where the cam turns counter-clockwise
    way       +1 where it pushes towards larger lift, -1 towards smaller
    radius    of the follower, mm: inf for a flat face, 0 for a knife edge
    length    of contact along the cam axis, mm
    lag       added to the cam angle to find the outline's place (pi for the far face of a frame), rad
    material  +1 where the cam's material is inside the outline, -1 outside (outer flank of a face groove)
    kind      roller, flat, knife or curved
    gap       running clearance between outline and roller, mm: its centre is counted where it is drawn, amid its play
    lean      of the flank from the cam axis, rad: half the angle of a conical roller
    height    z of the outline, mm, of a flank that leans; None where it is the same at every height
    """

    name: str
    outline: Outline
    joint: Joint
    sense: float
    way: float
    radius: float
    length: float
    lag: float = 0.0
    material: float = 1.0
    kind: str = "roller"
    gap: float = 0.0
    lean: float = 0.0
    height: float | None = None

    def knots(self) -> Floats:
        """Cam angles from 0 to 2 pi where a derivative may jump, rad."""
        return self.outline.knots()

    @property
    def rolling(self) -> bool:
        """True where a roller rolls on the cam."""
        return self.kind == "roller"

    @property
    def where(self) -> str:
        """Its name, with the height where its flank is another one at every height."""
        return self.name if self.height is None else f"{self.name} at z = {self.height:g} mm"

    @cached_property
    def grid(self) -> Grid:
        """Cam angles (n,), rad, at which it is sampled, one-sided at every knot, and the piece of each."""
        from camgeom.track.survey import PER_TURN

        return piece_grid(self.knots(), PER_TURN)

    @cached_property
    def sampled(self) -> Contacting:
        """The contact at the samples."""
        return self.at(self.grid[0])

    def place(self, phi: float, station: int) -> float:
        """It has one station, and no place along it."""
        del phi, station
        return 0.0

    def at(self, phi: Floats, station: int = 0) -> Contacting:
        """The contact at cam angles phi (n,). Raises DesignError where the outline has no direction."""
        del station
        phi = np.asarray(phi, dtype=float)
        curve = self.outline.curve(phi + self.lag)
        turn = np.exp(-1j * self.sense * phi)
        x = np.stack([*curve.points, np.zeros_like(phi)])
        e = self.joint.velocity(x, turn)[:2]
        n = curve.normals
        left = np.stack([-n[1], n[0]])
        lever = n[0] * e[0] + n[1] * e[1]
        own = inf if self.radius == 0.0 else 1.0 / self.radius
        return Contacting(
            self,
            curve,
            self.material * lever,
            self._pressure_angle(turn, curve),
            # The section across a straight line of contact that leans is less curved than the level one (Meusnier).
            cos(self.lean) * (self.material * curve.curvature + own),
            self._along(turn, curve, left),
            self._slip(curve, e, lever, left),
        )

    def _pressure_angle(self, turn: npt.NDArray[np.complex128], curve: Curve) -> Floats:
        """Signed pressure angle, rad. A roller turns on its pin, so that its force passes through its centre."""
        if self.kind == "flat" and isinstance(self.joint, Slide):
            return np.zeros(turn.shape)  # the face stands square to its motion
        push = self.way * self.material * curve.normals
        point = curve.points + (self.material * (self.radius + self.gap) * curve.normals if self.rolling else 0.0)
        e = self.joint.velocity(np.stack([*point, np.zeros_like(turn.real)]), turn)[:2]
        level = self.sense * np.arctan2(e[0] * push[1] - e[1] * push[0], e[0] * push[0] + e[1] * push[1])
        if self.lean == 0.0:
            return np.asarray(level)
        return np.asarray(np.copysign(np.arccos(np.cos(level) * cos(self.lean)), level))

    def _along(self, turn: npt.NDArray[np.complex128], curve: Curve, left: Floats) -> Floats:
        """Place of the contact along the face turned left from its normal, from the joint's centre or the cam axis."""
        centre = self.joint.centre if isinstance(self.joint, Swing) else (0.0, 0.0, 0.0)
        fixed = complex(centre[0], centre[1]) * turn
        x = curve.points
        return np.asarray((x[0] - fixed.real) * left[0] + (x[1] - fixed.imag) * left[1])

    def _slip(self, curve: Curve, e: Floats, lever: Floats, left: Floats) -> Floats:
        """Speed of the follower's point over the cam along the tangent, mm/rad.

        Seen from the cam the follower's point moves by its joint (e times the rate of the lift) and turns back with the
        frame. That both stay in touch, with no velocity along the normal, gives the rate of the lift.
        """
        back = -self.sense * np.stack([-curve.points[1], curve.points[0]])
        n = curve.normals
        rate = -(back[0] * n[0] + back[1] * n[1]) / np.where(np.abs(lever) > 1e-300, lever, 1e-300)
        v = back + rate * e
        return np.asarray(v[0] * left[0] + v[1] * left[1])
