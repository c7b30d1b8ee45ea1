"""The body under load: stress in a wall's root or a frame's plate, volumes for FE programs, how far it gives way."""

from __future__ import annotations

from math import radians
from typing import TYPE_CHECKING

from camgeom.errors import DesignError
from camgeom.solid.mechanism import Drive
from camgeom.track import TURN

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

        return RootStress(FrameBending(model.mechanism.frame, model.drive, model.profile.material.roller, at))
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
    return RootStress(PressedRing(body, model.duties, model.profile.material.cam, at))


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
    """What the body gives way below its contacts; None without dynamics.body_compliance."""
    spec = model.profile.dynamics_spec
    if spec is None or not spec.body_compliance:
        return None
    from camgeom.body.compliance import below_rollers, below_turret

    model.refuse_folded()
    if model.turret_duty is not None:
        return below_turret(model.parts, model.turret_duty, lambda: model.solid.mesh)
    duties = [model.duty, *(one for one in model.duties if one is not model.duty)]
    return below_rollers(model.parts[0], model.cutters, duties, model.drive, lambda: model.solid.mesh)
