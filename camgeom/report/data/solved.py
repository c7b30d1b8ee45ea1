"""Vibration and impacts as plain data for result.json, and what the same contact bears under them."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees
from typing import TYPE_CHECKING, Any

import numpy as np

from camgeom.errors import NotConverged
from camgeom.maths.extremum import hardest
from camgeom.mechanics.duty import MILLI, finite, least_lives, least_safety

if TYPE_CHECKING:
    from camgeom.mechanics.duty import Duty
    from camgeom.model import Model


def dynamics_data(model: Model) -> dict[str, Any]:
    """What the profile's [dynamics] table asks for; of several operating states in the hardest of rigid contact."""
    if model.profile.duty:
        state = model.hardest_state
        return {"state": state.state.name if state.state else "", **dynamics_data(state)}
    data: dict[str, Any] = {}
    if model.indexing is not None:
        data |= model.indexing.summary()
    if model.elastic_follower is not None:
        data |= model.elastic_follower.summary(model.profile.rotating)
        spec = model.profile.dynamics_spec
        found = (model.elastic_follower.rigid or model.elastic_follower).train.contact_stiffness
        if spec is not None and spec.tappet_contact is not None:
            unit, per = ("n_m_rad", 1.0) if model.profile.rotating else ("n_mm", MILLI)
            which = f"{spec.tappet_contact} of the contact, {model.duty.level}"
            data |= {f"tappet_stiffness_{unit}": per * found, "tappet_stiffness_is": which}
    return data | dynamic_duty_data(model)


def dynamic_duty_data(model: Model) -> dict[str, Any]:
    """Pressure, forces, torque and lives under the solved contact force, and the rigid ones beside; empty without.

    A force that cannot be sampled costs these figures alone.
    """
    try:
        solved, start = model.dynamic_duties, model.start_duties
    except NotConverged as error:
        return {"duty": {"failed": str(error)}}
    if not solved:
        return {}
    figures: dict[str, Any] = {"duty": duty_figures(solved), "rigid_duty": duty_figures(model.carriers)}
    if start:
        figures["start_duty"] = duty_figures(start, lives=False)
    for name, drive in (("duty", model.dynamic_slide_drive), ("rigid_duty", model.slide_drive),
                        ("start_duty", model.start_slide_drive)):  # fmt: skip
        if drive is not None:
            del figures[name]["peak_torque_n_m"]
            figures[name] |= drive.data()
    for name, peak in (("camshaft", model.dynamic_torque), ("start_camshaft", model.start_torque),
                       ("output", model.output_torque)):  # fmt: skip
        if peak is not None:
            figures |= {f"{name}_torque_n_m": MILLI * peak.value, f"{name}_torque_is": peak.where}
    return figures


def duty_figures(duties: Sequence[Duty], lives: bool = True) -> dict[str, Any]:
    """Peaks, lives (of a turn that comes again and again) and static safety over all that presses the cam."""
    force, torque = hardest(d.peak_force for d in duties), hardest(d.peak_torque for d in duties)
    data: dict[str, Any] = {
        "peak_force_n": force.value,
        "peak_force_cam_angle_deg": degrees(force.cam_angle) % 360.0,
        "peak_torque_n_m": torque.value * MILLI,
    }
    pressures = [duty.peak_pressure for duty in duties if duty.peak_pressure is not None]
    if pressures:
        data["peak_pressure_mpa"] = finite(hardest(pressures).value)
        data["peak_pressure_cam_angle_deg"] = degrees(hardest(pressures).cam_angle) % 360.0
    safety = least_safety(duties)
    if safety is not None:
        data["bearing_static_safety"] = finite(safety)
    return data | ({f"{body}_life_h": finite(hours) for body, hours in least_lives(duties).items()} if lives else {})


MOST_IMPACTS = 100
"""impacts that are listed one by one"""


def impact_data(model: Model) -> dict[str, Any]:
    """What the profile's [impact] table asks for: impacts one by one, statistics over turns, studies."""
    if model.profile.duty:
        state = model.hardest_state
        return {"state": state.state.name if state.state else "", **impact_data(state)}
    spec, run, rotating, row = model.profile.impact_spec, model.impact, model.profile.rotating, model.impact_row
    assert spec is not None
    assert run is not None
    assert row is not None
    data: dict[str, Any] = {
        "clearance": run.problem.pair.clearance_text,
        "conversions_deg": [degrees(hit.angle) for hit in run.conversions],
        "over_turns": row.as_dict(rotating),
        f"peak_jerk_{'rad' if rotating else 'm'}_s3": run.jerk[0],
        "friction_work_j": [side.friction for side in run.wear],
        "impacts": [
            {
                "cam_angle_deg": degrees(hit.angle),
                "side": hit.side.name.lower(),
                "approach_speed_m_s": hit.approach_speed,
                "energy_j": hit.energy,
                "duration_s": hit.duration,
                "peak_force_n": hit.peak_force,
                "peak_pressure_mpa": 1e-6 * hit.peak_pressure,
                "converts": hit.converts,
            }
            for hit in run.impacts[:MOST_IMPACTS]
        ],
    }
    if model.impact_sensitivity is not None:
        data["sensitivity"] = model.impact_sensitivity.as_dict()
    data["worst_pressure_mpa"] = model.impact_pressure.value
    data |= {"duty": impact_figures(model), "rigid_duty": duty_figures(model.carriers)}
    moving = run.trace.time >= spec.settle * run.problem.period
    data[f"peak_speed_{'rad' if rotating else 'm'}_s"] = float(np.abs(run.trace.speed[moving]).max())
    if spec.study:
        data["study"] = [row.as_dict(rotating) for row in model.impact_clearances]
    if spec.laws:
        data["laws"] = [row.as_dict(rotating) for row in model.impact_law_rows]
    return data


def impact_figures(model: Model) -> dict[str, Any]:
    """Peaks and lives over the turns that [impact] counts; the lives are those that `impact-life` judges."""
    every = [duty for turn in model.impact_duties for duty in turn]
    torque = model.impact_torque
    data = duty_figures(every) | {f"{body}_life_h": finite(hours) for body, hours in model.impact_lives.items()}
    data["lives_from"] = model.impact_basis
    return data if torque is None else data | {"peak_torque_n_m": MILLI * torque.value}
