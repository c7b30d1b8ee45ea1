"""What stands under load: stress in a wall's root or a frame's plate, volumes for FE programs, how far a body gives
way; and the output shaft and bolts of a turret: their torque, and what the rollers bend the shaft by."""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from math import cos, hypot, radians, sin, sqrt
from typing import TYPE_CHECKING

from camgeom.errors import CamgeomError, DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme
from camgeom.mechanics.output_shaft import Bolts, OutputShaft, bolts_of, equivalent_stress
from camgeom.model.price import BELOW, ROOTS, WALLS, afford
from camgeom.solid.mechanism import Drive
from camgeom.track import TURN, Swing

if TYPE_CHECKING:
    from camgeom.body.compliance import Below
    from camgeom.body.stress import RootStress
    from camgeom.body.volume import Volume
    from camgeom.model import Model


def root_stress(model: Model) -> RootStress | None:
    """Stress at a wall's root, or in a frame's plate, under its duty; None without these or without [operation]."""
    if model.profile.duty:
        return model.hardest_state.root_stress
    angle = model.profile.output.load_angle_deg
    at = None if angle is None else (radians(angle) - model.angle) % TURN
    if model.mechanism.frame is not None and model.drive is not None:
        from camgeom.body.frame_stress import FrameBending
        from camgeom.body.stress import RootStress

        paid = partial(afford, model.body, WALLS)
        return RootStress(FrameBending(model.mechanism.frame, model.drive, model.profile.material.roller, at, paid))
    if not model.duties or model.mechanism.bore is None:
        return None
    from camgeom.body.bending import bending_of
    from camgeom.body.stress import PressedRing, RootStress

    several = model.grooves
    body = bending_of(model.parts[0], model.cutters, [one.cutters for one in several], model.groove)
    if body is None:
        return None
    for one in several:
        one.refuse_folded()
    alone = len(model.mates) == 1 or model.state is not None
    solved = None if alone else partial(_of_mates, model)
    wall = model.groove if model.state is None else model.number
    each = partial(afford, model.body, WALLS, wall), partial(afford, model.body, ROOTS, model.number)
    return RootStress(PressedRing(body, model.duties, model.profile.material.cam, at, solved, each))


def _of_mates(model: Model) -> Floats:
    """The nominal stress of a follower's wall, from the first one's on its track."""
    return model.mates[0].wall_stresses[model.number]


def wall_stresses(model: Model) -> dict[int, Floats]:
    """Nominal stress, MPa, by the numbers of the followers on a model's track, solved together."""
    from camgeom.body.stress import PressedRing, nominals

    rings: dict[int, PressedRing] = {}
    for one in model.mates:
        with suppress(CamgeomError):  # raised again where its own is asked for
            if one.root_stress is not None and isinstance(one.root_stress.body, PressedRing):
                rings[one.number] = one.root_stress.body
    return dict(zip(rings, nominals(list(rings.values())), strict=True))


def volume(model: Model) -> Volume:
    """The body as hexahedra or tetrahedra with its load at output.load_angle_deg, for FE programs."""
    from camgeom.body.volume import LoadedTrack, PressedBy, grooved_volume, volume_of
    from camgeom.model.loads import operation_of

    if model.profile.duty:
        return model.hardest_state.volume
    operation_of(model.profile, "the load of a volume file")
    together = tuple({one.groove: one for one in reversed(model.at_once)}.values())[::-1]
    for one in together:
        one.refuse_folded()
    angle, shared = model.profile.output.load_angle_deg, model.mechanism.drive is Drive.SHARED
    at, material = None if angle is None else radians(angle), model.profile.material.cam
    if len(together) > 1:
        tracks = [LoadedTrack(one.cutters, one.duties, one.angle) for one in together]
        return grooved_volume(model.parts[0], tracks, material, at)
    pressing = PressedBy(turret=model.turret_duty) if shared else PressedBy(model.duties, model.drive)
    return volume_of(model.parts, model.cutters, pressing, material, at, lambda: model.solid.mesh)


def frame_volume(model: Model) -> Volume:
    """The frame's plate as hexahedra with the cam's load at output.load_angle_deg, for FE programs."""
    from camgeom.body.frame_stress import frame_volume
    from camgeom.model.loads import operation_of

    if model.profile.duty:
        return model.hardest_state.frame_volume
    operation_of(model.profile, "the load of a volume file")
    plate, angle = model.mechanism.frame, model.profile.output.load_angle_deg
    if plate is None or model.drive is None:
        raise DesignError("the follower is no frame with a plate")
    material = model.profile.material.roller
    return frame_volume(plate, model.drive, material, None if angle is None else radians(angle))


def below(model: Model) -> Below | None:
    """What the body gives way below its contacts; None without dynamics.body_compliance.

    Raises NotConverged where that of all followers and operating states would take too long.
    """
    spec = model.profile.dynamics_spec
    if spec is None or not spec.body_compliance:
        return None
    from camgeom.body.compliance import below_rollers, below_turret

    afford(model.body, BELOW)
    model.refuse_folded()
    if model.turret_duty is not None:
        return below_turret(model.parts, model.turret_duty, lambda: model.solid.mesh)
    duties = [model.duty, *(one for one in model.duties if one is not model.duty)]
    return below_rollers(model.parts[0], model.cutters, duties, model.drive, lambda: model.solid.mesh)


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
