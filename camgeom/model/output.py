"""The load of a turret's output shaft and bolts: its torque, and what its rollers bend it by."""

from __future__ import annotations

from math import cos, hypot, sin, sqrt
from typing import TYPE_CHECKING

from camgeom.immutable import immutable
from camgeom.maths.extremum import Extreme
from camgeom.mechanics.output_shaft import Bolts, OutputShaft, bolts_of, equivalent_stress
from camgeom.track import Swing

if TYPE_CHECKING:
    from camgeom.model import Model


@immutable(eq=True)
class ShaftDemand:
    """What the drive asks of output shaft and bolts, the hardest of rigid, vibrating and starting from rest.

    torque  N mm, and where; force: of all rollers on the turret, N, no matter where each points; bending: N mm
    stress  equivalent, MPa; None where the profile gives no shaft; bolts: None where it gives none
    """

    torque: Extreme
    force: float
    bending: float
    stress: float | None
    bolts: Bolts | None

    @property
    def slip_safety(self) -> float | None:
        """Torque at which the joint slips over the largest one; None without bolts or torque."""
        return self.bolts.grip / self.torque.value if self.bolts and self.torque.value else None

    @property
    def shear_safety(self) -> float | None:
        """Torque that shears the bolts over the largest one; None without bolts or torque."""
        return self.bolts.shear / self.torque.value if self.bolts and self.torque.value else None


def output_of(model: Model, spec: OutputShaft) -> ShaftDemand | None:
    """The output shaft's load and stress; None without a turret or a load.

    Every roller's force counts as if all pointed one way, under the pressure angle that bends most: its part across the
    output axis by the lever, its part along that axis by the pitch radius. Rollers parallel to the axis have no such
    part. Forces of preload are among them.
    """
    torque, rigid = model.output_torque, model.turret_duty
    if torque is None or rigid is None:
        return None
    duties = (rigid, *model.dynamic_duties, *model.start_duties)
    force = max(float(duty.contact_forces.sum(axis=0).max()) for duty in duties)
    bending, stress = 0.0, None
    if spec.diameter is not None and spec.lever is not None:
        bending = force * _arm(model, spec.lever)
        stress = equivalent_stress(spec.diameter, spec.bore, bending, torque.value)
    return ShaftDemand(torque, force, bending, stress, bolts_of(spec))


def _arm(model: Model, lever: float) -> float:
    """Moment on the output shaft per force of the rollers, mm."""
    track, worst = model.tracks[0], model.pressure_angle
    joint = track.joint
    assert isinstance(joint, Swing), "a turret turns"
    along = sum(a * b for a, b in zip(track.axis, joint.axis))
    radius = model.mechanism.follower.swing_radius * sqrt(max(0.0, 1.0 - along * along))
    angle = 0.0 if worst is None else worst.value
    return max(lever, hypot(lever * cos(angle), radius * sin(angle)))
