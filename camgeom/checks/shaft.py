"""Torque of both shafts: rigid, with vibration, with impacts."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from math import inf
from typing import TYPE_CHECKING

from camgeom.checks import LIFTED, NO_OPERATION, check, refuse_coarse, solved
from camgeom.checks.verdict import NO_GAP, Finding, NotJudged, judged

if TYPE_CHECKING:
    from camgeom.maths.extremum import Extreme
    from camgeom.mechanics.slide_drive import SlideDrive
    from camgeom.model import Model
    from camgeom.model.loaded import ShaftDemand

TORQUE = "less mass, force or speed, more angle for the motion, a smoother law, or a stronger drive"
FORCE = "less mass, load or speed, a gentler motion, or a smoother or longer way round of the plate's drive"
OUTPUT = "less inertia, torque or speed, a smoother law, more damping, or a stronger shaft"


def _torque(name: str, model: Model, peak: Extreme) -> Iterable[Finding]:
    """The largest torque, N mm, against the limit, where the profile gives one."""
    limit = model.profile.limits.torque_n_m
    if limit is not None:
        yield judged(name, 1e-3 * peak.value, "<=", limit, "N m", TORQUE, cam_angle=peak.cam_angle, where=peak.where)


def _alone(name: str, model: Model, peak_of: Callable[[Model], Extreme | None]) -> Iterable[Finding | NotJudged]:
    """The same of what is solved for each follower alone: of several, whose phase is not known, at most their sum."""
    peaks = [peak for one in model.at_once if (peak := peak_of(one)) is not None]
    limit = model.profile.limits.torque_n_m
    if limit is None or not peaks:
        return
    most = 1e-3 * sum(peak.value for peak in peaks)
    if len(peaks) == 1:
        yield from _torque(name, model, peaks[0])
    elif most <= limit or any(1e-3 * peak.value > limit for peak in peaks):
        yield judged(name, most, "<=", limit, "N m", TORQUE, where="all followers, as if they peaked at one angle")
    else:
        yield NotJudged(name, f"each follower is solved alone: all take {most:.4g} N m if they peak at one angle, more "
                        "than the limit, and each takes less")  # fmt: skip


@check("torque", "operation", "shaft")
def torque(model: Model) -> Iterable[Finding | NotJudged]:
    """Largest torque that a rigid cam takes from its shaft or gives it, under all followers."""
    if model.profile.limits.torque_n_m is None:
        return
    if model.camshaft is not None:
        yield from _torque("torque", model, replace(model.camshaft.peak_torque, where="all followers"))
    elif model.shaft is not None:
        yield from _torque("torque", model, model.shaft.peak_torque)
    else:
        yield NotJudged("torque", NO_OPERATION)


@check("drive-force", "operation")
def drive_force(model: Model) -> Iterable[Finding | NotJudged]:
    """Largest force that the drive of a cam that slides gives along its travel, for follower, plate and slide."""
    drives = [drive for one in model.states if (drive := one.slide_drive) is not None]
    if drives:
        yield (said := _slid("drive-force", model, max(drives, key=lambda one: one.peak.value)))
        if isinstance(said, Finding):
            across = max(drive.peak_across.value for drive in drives)
            yield NotJudged("drive-friction", "no key says how the plate's slide rubs, and the drive's force is "
                            f"without that: the roller presses the plate across its travel by up to {across:.4g} N")


@solved("dynamic-drive-force", "dynamics")
def dynamic_drive_force(model: Model) -> Iterable[Finding | NotJudged]:
    """The same with the follower's vibration; plate and drive are rigid."""
    if model.mechanism.carriage is None:
        return
    if model.dynamic_slide_drive is not None:
        yield _slid("dynamic-drive-force", model, model.dynamic_slide_drive)
    else:
        yield NotJudged("dynamic-drive-force", LIFTED)


@solved("start-drive-force", "dynamics", turn="start")
def start_drive_force(model: Model) -> Iterable[Finding | NotJudged]:
    """The same in the first turn from rest."""
    if model.mechanism.carriage is not None and model.start_slide_drive is not None:
        yield _slid("start-drive-force", model, model.start_slide_drive)


def _slid(name: str, model: Model, drive: SlideDrive) -> Finding | NotJudged:
    """The force of a drive against the limit."""
    limit = model.profile.limits.drive_force_n
    if limit is None or drive.mass is None:
        missing = "limits.drive_force_n" if limit is None else "cam.moving_mass"
        told = f"the follower takes {drive.peak_groove.value:.4g} N along the travel"
        if drive.mass is not None:
            told = f"follower, plate and slide take {drive.peak.value:.4g} N"
        return NotJudged(name, f"give {missing}: {told}")
    return judged(name, drive.peak.value, "<=", limit, "N", FORCE, cam_angle=drive.peak.cam_angle)


@solved("dynamic-torque", "dynamics", "shaft")
def dynamic_torque(model: Model) -> Iterable[Finding | NotJudged]:
    """Torque with vibration: at the cam, and in its shaft where that is elastic; without a limit it is told."""
    if model.mechanism.carriage is not None:
        return
    peaks = [one.dynamic_torque for one in model.at_once]
    if model.profile.limits.torque_n_m is None:
        peak, start = (peaks[0], model.start_torque) if len(peaks) == 1 else (None, None)
        shown = "" if peak is None else f": it takes {1e-3 * peak.value:.4g} N m with vibration, {peak.where}"
        if shown and start is not None:
            shown += f", {1e-3 * start.value:.4g} N m starting from rest"
        yield NotJudged("dynamic-torque", f"give limits.torque_n_m, what the camshaft may carry{shown}")
    elif all(peaks):
        yield from _alone("dynamic-torque", model, lambda one: one.dynamic_torque)
    else:
        yield NotJudged("dynamic-torque", LIFTED)


@solved("output-torque", "turret load", slow=True)
def output_torque(model: Model) -> Iterable[Finding | NotJudged]:
    """Largest torque of a turret's output shaft, where the profile has a limit; what [dynamics] finds is told too."""
    limit, solves = model.profile.limits.output_torque_n_m, model.profile.dynamics_spec is not None
    if limit is None and not solves:
        return
    if solves:
        refuse_coarse(model)
    peak = model.output_torque
    assert peak is not None, "there is a turret, and a load"
    if limit is not None:
        yield judged("output-torque", 1e-3 * peak.value, "<=", limit, "N m", OUTPUT, cam_angle=peak.cam_angle,
                     where=peak.where)  # fmt: skip
    elif (shaft := model.profile.output_shaft_spec) is None or shaft.diameter is None:
        yield NotJudged("output-torque", "give limits.output_torque_n_m, what the output shaft may carry: it takes "
                        f"{1e-3 * peak.value:.4g} N m {peak.where}")  # fmt: skip


@solved("output-shaft", "turret load", slow=True)
def output_shaft(model: Model) -> Iterable[Finding]:
    """Equivalent stress of the output shaft at the section that [output_shaft] gives, and whether it has room."""
    spec, found, turret = model.profile.output_shaft_spec, _output(model), model.mechanism.turret
    if spec is None or spec.diameter is None or found is None or found.stress is None or turret is None:
        return
    advice = f"a thicker shaft, or {OUTPUT}"
    yield judged("output-shaft", found.stress, "<=", spec.stress_limit, "MPa", advice,
                 cam_angle=found.torque.cam_angle, where=f"bent and twisted, {found.torque.where}")  # fmt: skip
    advice = (f"make output_shaft.diameter less than {2.0 * turret.room:.6g} mm: no shaft is thicker where it is "
              "weakest than the turret's disc, or than what turns beside it lets past")  # fmt: skip
    yield judged("output-shaft", turret.room - 0.5 * spec.diameter, ">", 0.0, "mm", advice, slack=-NO_GAP,
                 where="room for the shaft in its turret")  # fmt: skip


@solved("bolts", "turret load", slow=True)
def bolts(model: Model) -> Iterable[Finding]:
    """Safety of the bolts of [output_shaft] against slipping, and shear should they slip; room for their circle."""
    found, limits = _output(model), model.profile.limits
    if found is None or found.bolts is None:
        return
    more = "more or larger bolts, a higher grade, a larger circle"
    each = (("slip", found.slip_safety, limits.bolt_slip_safety, f"{more}, or tighten them more evenly"),
            ("shear", found.shear_safety, limits.bolt_shear_safety, more))  # fmt: skip
    for word, safety, least, advice in each:
        yield judged("bolts", inf if safety is None else safety, ">=", least, "1", advice, unlimited=True,
                     cam_angle=found.torque.cam_angle, where=f"{word}, {found.torque.where}")  # fmt: skip
    turret = model.mechanism.turret
    if turret is not None:
        flange, heads = max(turret.room, *(radius for radius, _, _ in turret.dials), 0.0), found.bolts.head
        advice = (f"make output_shaft.bolt_circle less than {2.0 * flange - heads:.6g} mm: no joint is wider than the "
                  "turret's disc, or than its dials")  # fmt: skip
        yield judged("bolts", flange - 0.5 * (found.bolts.circle + heads), ">", 0.0, "mm", advice, slack=-NO_GAP,
                     where="room for the bolts' heads on their turret")  # fmt: skip


def _output(model: Model) -> ShaftDemand | None:
    """The load of the output shaft, where the profile gives one; what is solved has to be fine enough."""
    if model.output is not None and model.profile.dynamics_spec is not None:
        refuse_coarse(model)
    return model.output


@solved("start-torque", "dynamics", "shaft", turn="start")
def start_torque(model: Model) -> Iterable[Finding | NotJudged]:
    """Largest torque of the camshaft in the first turn from rest, where the profile has a limit."""
    yield from _alone("start-torque", model, lambda one: one.start_torque)


@solved("impact-torque", "impact", "shaft")
def impact_torque(model: Model) -> Iterable[Finding | NotJudged]:
    """The same over the turns that [impact] counts, with the friction of the contacts."""
    yield from _alone("impact-torque", model, lambda one: one.impact_torque)
