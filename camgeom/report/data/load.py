"""Contact, fatigue and film under rigid load for result.json, and what states and followers come to together."""

from __future__ import annotations

from collections.abc import Mapping
from math import degrees, inf, isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from camgeom.mechanics.bearing import borne_load
from camgeom.mechanics.duty import MILLI, bearing_data, finite, least_safety, torque_data

if TYPE_CHECKING:
    from camgeom.mechanics.roller_duty import RollerDuty
    from camgeom.model import Model


def contact_data(model: Model) -> dict[str, Any]:
    """Force, pressure and torque of what presses the cam; of several operating states in the hardest."""
    if model.profile.duty:
        state = model.hardest_state
        return {"state": state.state.name if state.state else "", **contact_data(state)}
    data = model.carrier.contact_data() if model.carrier is not None else {}
    if model.shaft is not None and len(model.driven) > 1:
        data |= force_data(model) | torque_data(model.shaft.peak_torque, model.shaft.work)
    if model.slide_drive is not None:
        # No shaft turns with a plate.
        data = {key: value for key, value in data.items() if "torque" not in key} | model.slide_drive.data()
    each = {"rollers": [roller_data(duty) for duty in model.duties]} if len(model.duties) > 1 else {}
    # A roller's own contact (crowning, slices) stands; force and torque are those of all touches together.
    if model.drive is None or model.carrier is None:
        return data | _touched(model) | each
    # Nor have its touches a pressure where the roller's sharp end has none.
    whole = model.drive.force_data() if model.carrier.no_stress else model.drive.contact_data()
    return whole | data | model.drive.torque_data() | (force_data(model) if each else {}) | each


def _touched(model: Model) -> dict[str, str]:
    """Which wall of a disc that leans is pressed hardest: no face tells it of a cone."""
    if model.profiles is None or not model.duties or model.duty.peak_pressure is None:
        return {}
    duty = model.duty
    if len(duty.track.sides) == 1:
        return {"peak_at": duty.track.name}
    normal = duty.force.panels.at(duty.normal, np.array([model.duty.peak_pressure.cam_angle]))
    return {"peak_at": next(touch.name for touch in model.profiles.walls if touch.way * float(normal[0]) >= 0.0)}


def force_data(model: Model) -> dict[str, Any]:
    """The largest force that presses the cam, where figures are quoted and where it acts."""
    if model.peak_force is None:
        return {}
    duties = model.duties if model.drive is None else ()
    quoted = max((duty.quoted_force.value for duty in duties), default=model.peak_force.value)
    moved = any(duty.at is not None for duty in duties)
    return {"peak_force_n": quoted} | ({"peak_middle_force_n": model.peak_force.value} if moved else {})


def roller_data(duty: RollerDuty) -> dict[str, Any]:
    """What one of a pair's rollers bears."""
    peak, force, bearing = duty.peak_pressure, duty.peak_force, duty.bearing
    return {
        "name": duty.track.name,
        "diameter_mm": 2.0 * duty.radius,
        "length_mm": duty.length,
        "peak_force_n": force.value,
        "peak_force_at_deg": degrees(force.cam_angle) % 360.0,
        "peak_pressure_mpa": peak.value if peak is not None else None,
        "peak_pressure_at_deg": degrees(peak.cam_angle) % 360.0 if peak is not None else None,
        **{f"{body}_life_h": finite(hours) for body, hours in duty.lives.items()},
        **({} if bearing is None else {"bearing_mean_load_n": float(bearing.mean_load)}),
    }


def fatigue_data(model: Model) -> dict[str, Any]:
    """Lives of roller, cam and bearing; of several operating states over all of them, and the damage of each."""
    if model.profile.duty:
        return _over_states(model)
    if model.carrier is None:
        return {}
    data = model.carrier.fatigue_data() | film_data(model)
    if len(model.duties) > 1:
        # A roller whose sharp end presses has no life; its reason stands with the findings.
        data["roller_lives_h"] = [finite(life) if (life := duty.lives.get("roller")) is not None else None
                                  for duty in model.duties]  # fmt: skip
        first = min(model.duties, key=lambda duty: duty.lives.get("roller", inf))
        data |= {key: value for key, value in first.fatigue_data().items() if key.startswith(("roller_", "hot_spot"))}
        if "cam" in model.own_lives:
            whole = model.own_lives["cam"]
            quoted = min(float(duty.cam_life.life_h) for duty in model.duties)
            data["cam_slice_life_h"] = finite(whole)
            data["cam_life_h"] = finite(whole if model.duty.meeting is not None else quoted)
    if model.duties and model.mechanism.classical:
        data["conventions"] = conventions(model)
    for table, roller in model.profile.rollers.items():
        if roller.designation is not None:
            data[f"{table.removesuffix('roller')}bearing_designation"] = roller.designation
    safety = least_safety(model.carriers)
    data |= bearing_data(model.bearing) | _borne(model)
    return data | ({} if safety is None else {"bearing_static_safety": finite(safety)})


def _borne(model: Model) -> dict[str, Any]:
    """The load that the weakest bearing bears for the wanted life; empty without one, and over several states."""
    life = model.profile.limits.life_h
    if life is None or model.state is not None:
        return {}
    pairs = ((duty.bearing, duty.rating) for duty in model.carriers)
    borne = (borne_load(one, rating, life) for one, rating in pairs if one is not None and rating is not None)
    loads = [load for load in borne if load is not None]
    return {"bearing_borne_load_n": min(loads)} if loads else {}


def together_data(model: Model) -> dict[str, Any]:
    """What several followers do together: the torque of the shaft, how near their rollers come, the cam's life; the
    hardest pressure and the shortest life of all, where every follower has one.

    The cam lives as long as the track that lives least, under all followers on it.
    """
    data: dict[str, Any] = {"followers": len(model.bindings)}
    if model.camshaft is not None:
        data |= torque_data(model.camshaft.peak_torque, model.camshaft.work)
    if model.apart is not None:
        data |= {"least_apart_mm": model.apart.value, "least_apart_at_deg": degrees(model.apart.cam_angle) % 360.0}
    if (pivot := model.apart_from_pivots) is not None:
        data |= {"least_to_pivot_mm": pivot.value, "least_to_pivot_at_deg": degrees(pivot.cam_angle) % 360.0}
    lives = [one.lives["cam"] for one in model.bindings if "cam" in one.lives]
    if lives:
        data["cam_life_h"] = finite(min(lives))
    carriers = [one.hardest_state.carrier for one in model.bindings]
    peaks = [None if carrier is None else carrier.peak_pressure for carrier in carriers]
    known = [peak.value for peak in peaks if peak is not None]
    if len(known) == len(peaks):
        data["peak_pressure_mpa"], data["hardest_follower"] = max(known), known.index(max(known)) + 1
    if all(one.lives for one in model.bindings):
        data["least_life_h"] = finite(min(min(one.lives.values()) for one in model.bindings))
    return data


def output_data(model: Model) -> dict[str, Any]:
    """What output shaft and bolts bear, of several operating states: the largest torque, and the largest stress."""
    outputs = [one.output for one in model.states if one.output is not None]
    found, bent = max(outputs, key=lambda one: one.torque.value), max(outputs, key=lambda one: one.stress or 0.0)
    data: dict[str, Any] = {
        "torque_n_m": MILLI * found.torque.value,
        "torque_is": found.torque.where,
        "torque_at_deg": degrees(found.torque.cam_angle) % 360.0,
        "rollers_force_n": bent.force,
    }
    if bent.stress is not None:
        data |= {"bending_n_m": MILLI * bent.bending, "stress_mpa": bent.stress}
    if found.bolts is not None:
        data |= {
            "preload_n": found.bolts.preload,
            "least_preload_n": found.bolts.least_preload,
            "grip_torque_n_m": MILLI * found.bolts.grip,
            "shear_torque_n_m": MILLI * found.bolts.shear,
            "slip_safety": found.slip_safety,
            "shear_safety": found.shear_safety,
        }
    return data


def film_data(model: Model) -> dict[str, Any]:
    """Least film over the turn, heat of sliding and wear; empty where nothing of it is asked."""
    data: dict[str, Any] = {}
    if model.film is not None:
        data["film_ratio"] = model.film.least.value
        data["film_ratio_at_deg"] = degrees(model.film.least.cam_angle) % 360.0
        data["film_thickness_um"] = 1e3 * model.film.thickness
    if model.friction_power is not None:
        data["friction_power_w"] = model.friction_power
    data |= {f"{body}_wear_um_per_1000h": 1e6 * depth for body, depth in model.wear_per_hour.items()}
    return data


def _over_states(model: Model) -> dict[str, Any]:
    """Every life, h, summed over the operating states, the other figures of the hardest, and the states themselves."""
    from camgeom.mechanics.life import summed_life

    each = [(state, fatigue_data(state)) for state in model.states]
    data = dict(next(found for state, found in each if state is model.hardest_state))
    for key in [key for key in data if key.endswith("_life_h")]:
        lives = [(_weight(state), inf if found[key] is None else found[key]) for state, found in each if key in found]
        data[key] = finite(summed_life(lives))
    # The thinnest film and the most heat may be those of another state.
    data |= film_data(min(model.states, key=lambda one: inf if one.film is None else one.film.least.value))
    powers = [state.friction_power for state in model.states if state.friction_power is not None]
    data |= {"friction_power_w": max(powers)} if powers else {}
    data |= {f"{body}_wear_um_per_1000h": 1e6 * depth for body, depth in model.wear_per_hour.items()}
    return data | {"states": [state_data(state, model.own_lives) for state in model.states]}


def _weight(state: Model) -> float:
    return 1.0 if state.state is None else state.state.weight


def state_data(model: Model, lives: Mapping[str, float]) -> dict[str, Any]:
    """An operating state: how long, how fast, how hard, and its share of the damage of every body.

    lives: over all states, h, with this follower alone on the cam
    """
    assert model.state is not None
    assert model.carrier is not None, "a state has a load"
    data: dict[str, Any] = {
        "name": model.state.name, "weight": model.state.weight, "speed_rpm": model.state.speed,
        "load_factor": model.state.load_factor, **force_data(model),
    }  # fmt: skip
    if model.carrier.peak_pressure is not None:
        data["peak_pressure_mpa"] = finite(model.carrier.peak_pressure.value)
    bearing = model.bearing
    if bearing is not None and bearing.ratio is not None and bearing.factor is not None:
        data |= {"bearing_viscosity_ratio": float(bearing.ratio), "bearing_life_factor": float(bearing.factor)}
    if model.film is not None:
        data["film_ratio"] = model.film.least.value
    if model.friction_power is not None:
        data["friction_power_w"] = model.friction_power
    if model.slide_drive is not None:
        drive = model.slide_drive
        data["peak_travel_force_n"] = drive.peak_groove.value
        if drive.mass is not None:
            data["peak_drive_force_n"] = drive.peak.value
    elif model.shaft is not None:
        data["peak_torque_n_m"] = model.shaft.peak_torque.value * MILLI
    for body, hours in model.lives.items():
        data[f"{body}_life_h"] = finite(hours)
        whole = lives.get(body, inf)
        # Of a life of 0 every state that has none has all the damage.
        share = (1.0 if hours == 0.0 else 0.0) if whole == 0.0 else model.state.weight * whole / hours
        data[f"{body}_damage_share"] = share if isfinite(whole) else 0.0
    return data


def conventions(model: Model) -> list[dict[str, Any]]:
    """Peak pressure and roller life under the curvature conventions of the literature, beside the exact surface.

    All at the quoted pitch radius; the last row is the exact surface integrated over slices along the roller.
    """
    duty, radius = model.duty, model.mechanism.quoted_radius
    assert radius is not None
    rows: list[tuple[str, Any, Any, Any]] = [
        (name, peak.pressure, peak.theta, life.life_h) for name, (peak, life) in duty.conventions(radius).items()
    ]
    rows.sort(key=lambda row: row[0] == "exact")
    hardest = duty.peak_pressure
    if hardest is not None:
        rows.append(("exact, slices", hardest.value, hardest.cam_angle, np.min(duty.slice_life.life_h)))
    return [
        {
            "convention": name,
            "peak_pressure_mpa": finite(pressure),
            "cam_angle_deg": degrees(angle),
            "roller_life_h": finite(hours),
        }
        for name, pressure, angle, hours in rows
    ]
