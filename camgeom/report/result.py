"""The result that scripts rely on: its pieces from the model's facts, the products a command asks for, what it cost."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import degrees, inf, isfinite, pi
from typing import TYPE_CHECKING, Any

import numpy as np

from camgeom.errors import NotConverged, Problem, ProfileError
from camgeom.maths.extremum import hardest
from camgeom.maths.overflow import within_range
from camgeom.mechanics.duty import MILLI, bearing_data, finite, least_lives, least_safety, torque_data
from camgeom.report.figures import VERSION
from camgeom.report.products import Products

if TYPE_CHECKING:
    from camgeom.checks.verdict import Finding, Verdict
    from camgeom.mechanics.duty import Duty
    from camgeom.mechanics.roller_duty import RollerDuty
    from camgeom.model import Model
    from camgeom.motion.optimal.best import Best
    from camgeom.track.planar import Planar

PRODUCTS = (
    "motion", "blank", "flank", "checks", "solid", "contact", "fatigue", "body", "dynamics", "cutter", "tolerance",
    "exports", "report",
)
FIRST = {"motion", "blank", "flank"}
"""products that stand before the checks in the result"""
LOADED = {"contact", "fatigue", "dynamics", "tolerance"}
"""products that are another follower's own, on a track that all of them share"""
OWN = {"motion", "flank"}
"""products that it has of its own where its track is its own"""
RIDES = {"impact": "dynamics", "together": "contact"}
"""sections that are made with another product"""
COMMANDS: dict[str, tuple[str, ...]] = {
    "run": tuple(name for name in PRODUCTS if name != "body"),
    "build": ("motion", "blank", "solid", "cutter", "exports"),
    "check": ("motion", "blank", "flank", "checks"),
    "solve": ("motion", "contact", "fatigue", "dynamics", "tolerance"),
    "report": ("motion", "blank", "flank", "checks", "solid", "contact", "fatigue", "dynamics", "tolerance", "report"),
}


@dataclass(frozen=True, eq=False)
class Result:
    """What a job found: plain data for result.json, the findings, their verdict, and what became of every product."""

    data: dict[str, Any]
    verdict: Verdict
    products: Products

    @property
    def exit_status(self) -> int:
        """The worst of the products; 1 where a finding fails."""
        return max(self.products.exit_status, int(self.verdict.level == "fail"))

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What was judged."""
        return self.verdict.findings


def chosen(command: str, only: Iterable[str] | None) -> tuple[tuple[str, ...], tuple[str, ...] | None]:
    """Products and checks that a command computes; `only` narrows them. Raises ProfileError for an unknown name.

    A body that is asked for is judged, too.
    """
    products = COMMANDS[command]
    if only is None:
        return products, None
    from difflib import get_close_matches

    from camgeom.checks import checks

    names = tuple(only)
    known = (*PRODUCTS, *checks())
    for name in names:
        if name not in known:
            near = get_close_matches(name, known, 1, 0.5)
            hint = f"did you mean {near[0]}?" if near else ""
            raise ProfileError([Problem("--only", "unknown product or check", name, ", ".join(known), hint)])
    wanted = tuple(name for name in names if name in PRODUCTS)
    single = tuple(name for name in names if name not in PRODUCTS)
    if "body" in wanted and "checks" not in wanted:
        single = (*single, "root-stress")
    return tuple(dict.fromkeys((*wanted, *(("checks",) if single else ())))), single or None


def compute(
    model: Model, wanted: Iterable[str], only_checks: Iterable[str] | None = None, products: Products | None = None
) -> Result:
    """The result of the named products, each computed, or its reason in its place; `products` takes the notes."""
    from camgeom import __version__
    from camgeom.checks.verdict import Verdict

    asked, noted = set(wanted), products if products is not None else Products()
    if "contact" in asked and model.profile.material.cam.bending_limit is not None:
        asked.add("body")
    data: dict[str, Any] = {"schema": VERSION, "name": model.profile.name, "kind": model.profile.kind}
    data["version"] = __version__
    if model.profile.units_note:
        data["units"] = model.profile.units_note
    if model.profile.reproduces is not None:
        data["reproduces"] = model.profile.reproduces
    data |= _sections(model, asked & FIRST, noted)
    verdict = Verdict(())
    if "checks" in asked:
        from camgeom.checks import judge

        verdict = noted.attempt("checks", partial(judge, model, only_checks)) or verdict
        data["verdict"] = verdict.level
        if verdict.loads is not None:
            data["loads"] = verdict.loads.as_dict()
        data["not_judged"] = [word.as_dict() for word in verdict.not_judged]
        data["checks"] = [finding.as_dict() for finding in verdict.findings]
        for name, why in verdict.lost:
            noted.unmade(f"checks.{name}", why)
        if verdict.lost:
            noted.gather("checks", whole=False)
    data |= _sections(model, asked - FIRST, noted)
    if len(model.bindings) > 1:
        data["followers"] = [
            {"angle_deg": degrees(one.angle), "track": one.groove + 1,
             **_sections(one, asked & (LOADED | OWN if one in model.grooves else LOADED), noted,
                         f"follower {one.number + 1}.")}
            for one in model.bindings[1:]
        ]
    data["files"] = []
    return Result(data, verdict, noted)


def _sections(model: Model, asked: set[str], products: Products, prefix: str = "") -> dict[str, Any]:
    """The sections asked for; the reason in the place of what cannot be made, nothing of what does not apply."""
    data: dict[str, Any] = {}
    for name, (source, absent) in SOURCES.items():
        if RIDES.get(name, name) not in asked or (name == "together" and (model.number or len(model.bindings) == 1)):
            continue
        product = f"{prefix}{name}"
        job = partial(_within, name, source, model)
        # Whether there is such a thing may hang on what cannot be made: that is the product's own reason too.
        reason = products.attempt(product, partial(absent, model))
        found = None if reason is None else {} if reason else products.attempt(product, job)
        if found is None:
            told = products[product]
            found = {told.status: told.reason}
        elif not found:
            products.absent(product, reason or "the cam has nothing of the kind")
            continue
        if name == "impact":
            data.setdefault("dynamics", {})["impact"] = found
        else:
            data[name] = found
    return data


def _within(name: str, source: Callable[[Model], dict[str, Any]], model: Model) -> dict[str, Any]:
    """A section's data; NotConverged where a number leaves its range on the way."""
    with within_range(name):
        return source(model)


def _flank(model: Model) -> dict[str, Any]:
    data = flank_data(model) if model.tracks else {}
    if model.planar is not None:
        data |= _planar(model.planar)
    if model.mechanism.crown:
        data["crown"] = model.mechanism.crown
    if model.pair is not None:
        data |= {"pair_least_gap_mm": model.pair.least, "pair_largest_gap_mm": float(model.pair.gap.max())}
    return data


def _planar(planar: Planar) -> dict[str, Any]:
    """Extremes of a planar cam's profile."""
    low, high = planar.pressure_angle_range
    convex, hollow = planar.radii
    data: dict[str, Any] = {
        "max_pressure_angle_deg": round(degrees(planar.pressure_angle.value), 12),
        "max_pressure_angle_at_deg": degrees(planar.pressure_angle.cam_angle) % 360.0,
        "pressure_angle_range_deg": [degrees(low.value), degrees(high.value)],
        "min_convex_radius_mm": convex.value if convex else None,
        "min_hollow_radius_mm": hollow.value if hollow else None,
        "top_dwell_share": planar.top_share,
        "curvature_jumps_deg": [degrees(jump.cam_angle) for jump in planar.curvature_jumps],
    }
    for key, one in (("min_face_radius", planar.face_radius), ("face_width_needed", planar.face_needed)):
        data |= {f"{key}_mm": one.value, f"{key}_at_deg": degrees(one.cam_angle) % 360.0} if one else {}
    if planar.width_residual is not None:
        data |= {"width_mm": planar.span, "width_residual_mm": planar.width_residual.value}
    if planar.sliding is not None:
        data["max_sliding_mm_per_rad"] = planar.sliding.value
    return data


def explain(model: Model, products: Iterable[str]) -> list[str]:
    """What was computed and what it cost, and what was skipped and why."""
    lines = [f"{seconds * 1e3:9.2f} ms  {name}" for name, seconds in model.ledger.costs.items()]
    facts = ("flanks", "solids", "clearances", "mass", "duty")
    skipped = [name for name in facts if name not in model.ledger.costs]
    reasons = dict.fromkeys(skipped, "not asked for")
    if "duty" in skipped and not model.duties:
        reasons["duty"] = "the profile has no [operation], or no roller that one load bears on"
    lines += [f"  skipped     {name}: {reason}" for name, reason in reasons.items()]
    missing = [name for name in PRODUCTS if name not in set(products)]
    if missing:
        lines.append(f"  not asked   {', '.join(missing)}")
    import sys

    heavy = [m for m in ("scipy", "trimesh", "pyvista", "meshio", "manifold3d", "ezdxf") if m in sys.modules]
    lines.append(f"  imported    {', '.join(heavy) if heavy else 'none of the heavy libraries'}")
    return lines


def motion_data(model: Model) -> dict[str, Any]:
    """Characteristic values of the program, per radian of cam angle and, with a speed, in time."""
    program = model.setup.program
    rotating = model.profile.rotating
    unit, name = (180.0 / pi, "deg") if rotating else (1.0, "mm")
    peaks = [program.peak(order) for order in (1, 2, 3)]
    data: dict[str, Any] = {
        f"stroke_{name}": unit * _stroke(model),
        f"peak_velocity_{name}_per_rad": unit * abs(peaks[0].value),
        f"peak_acceleration_{name}_per_rad2": unit * abs(peaks[1].value),
        f"peak_jerk_{name}_per_rad3": unit * abs(peaks[2].value),
        "peak_velocity_at_deg": degrees(peaks[0].at),
        "peak_acceleration_at_deg": degrees(peaks[1].at),
        "continuity": program.continuity.order,
        "jumps": [
            {"cam_angle_deg": degrees(j.angle), "order": j.order, "size": unit * j.size}
            for j in program.continuity.jumps
        ],
    }
    if program.best_laws:
        stated = len(model.profile.motion)
        data["best_laws"] = {str(i): _best_law(found) for i, found in program.best_laws if i < stated}
    if model.profile.fastest is not None:
        omega = model.profile.fastest * pi / 30.0
        for order, word in ((1, "velocity"), (2, "acceleration"), (3, "jerk")):
            key = f"peak_{word}_{name}_per_s{'' if order == 1 else order}"
            data[key] = unit * abs(peaks[order - 1].value) * omega**order
    return data


def _best_law(found: Best) -> dict[str, Any]:
    """The least value of a best law, its bound and its peaks, for unit lift over unit travel; None where one jumps."""
    peaks = {name.replace("-", "_"): value if isfinite(value) else None for name, value in found.peaks.items()}
    return {
        "minimise": found.wish.aim,
        "value": found.value,
        "lower_bound": found.bound,
        "gap": found.gap,
        "bound_holds_for": found.holds_for,
        **peaks,
    }


def _stroke(model: Model) -> float:
    lifts = [lift for span in model.setup.program.spans for lift in (span.before, span.after)]
    return max(lifts) - min(lifts)


def flank_data(model: Model) -> dict[str, Any]:
    """Extremes over all tracks and flanks."""
    surveys = model.flanks
    sharp = max((s.largest_relative_curvature for s in surveys), key=lambda e: e.value)
    margin = min((s.margin for s in surveys), key=lambda e: e.value)
    return {
        **_angles(model),
        "min_relative_radius_mm": 1.0 / sharp.value if sharp.value > 0.0 else 0.0,
        "min_relative_radius_at_deg": degrees(sharp.cam_angle) % 360.0,
        "undercut_margin": margin.value,
        "undercut_margin_at_deg": degrees(margin.cam_angle) % 360.0,
        **_quoted(model),
        **_lost(model),
        **_rib(model),
    }


def _rib(model: Model) -> dict[str, Any]:
    """Least normal thickness of a drum's rib, and where."""
    thinnest = min(model.mechanism.ribs, key=lambda rib: rib.value, default=None)
    if thinnest is None:
        return {}
    return {"rib_thickness_mm": thinnest.value, "rib_thickness_at_deg": degrees(thinnest.cam_angle) % 360.0}


def _lost(model: Model) -> dict[str, Any]:
    """Over how much of a turn, and where, a roller that leaves its cam on purpose misses one of its flanks."""
    if not model.mechanism.runs_out:
        return {}
    lost = model.lost_contact
    return {
        "lost_contact_deg": max(degrees(sum(b - a for a, b in stretches)) for stretches in lost.values()),
        "lost_contact_at_deg": {name: [[degrees(a), degrees(b)] for a, b in each] for name, each in lost.items()},
    }


def _angles(model: Model) -> dict[str, Any]:
    """Largest pressure angles; where rollers take turns, of the best placed one."""
    worst = model.drive_angle
    if worst is not None:
        at = degrees(worst.cam_angle) % 360.0
        return {"max_pressure_angle_deg": degrees(worst.value), "max_pressure_angle_at_deg": at}
    angle = max((s.pressure_angle for s in model.flanks), key=lambda e: e.value)
    axis = max((s.axis_pressure_angle for s in model.flanks), key=lambda e: e.value)
    return {
        "max_pressure_angle_deg": degrees(angle.value),
        "max_pressure_angle_at_deg": degrees(angle.cam_angle) % 360.0,
        "max_pressure_angle_delta_mm": angle.place,
        "max_axis_pressure_angle_deg": degrees(axis.value),
    }


def _quoted(model: Model) -> dict[str, Any]:
    radius = model.mechanism.quoted_radius
    if radius is None or model.planar is not None:
        return {}
    at = max((s.pressure_angle_at(radius) for s in model.flanks), key=lambda e: e.value)
    return {"pitch_radius_mm": radius, "pitch_pressure_angle_deg": degrees(at.value)}


def blank_data(model: Model) -> dict[str, Any]:
    """The cylinder about the axis that just holds the finished cam: what it is turned from; of a plate its sizes."""
    if model.mechanism.box is not None:
        length, width, thickness = model.mechanism.box
        return {"plate_length_mm": length, "plate_width_mm": width, "plate_thickness_mm": thickness,
                "volume_mm3": length * width * thickness}  # fmt: skip
    diameter, length = model.envelope
    whole = {"diameter_mm": diameter, "length_mm": length, "volume_mm3": 0.25 * pi * diameter**2 * length}
    return whole | model.mechanism.named


def solid_data(model: Model) -> dict[str, Any]:
    """The body (for several, sums and the list of them)."""
    bodies = []
    for solid, mass in zip(model.solids, model.mass):
        mesh = solid.mesh
        bodies.append(
            {
                "name": solid.name,
                "watertight": mesh.watertight,
                "volume_mm3": mass.volume,
                "area_mm2": mesh.area,
                "triangles": len(mesh.faces),
                "chord_error_mm": solid.chord_error,
                "genus": mesh.genus,
                "mass_kg": mass.mass,
                "method": solid.method,
                "centroid_mm": list(mass.centroid),
                "inertia_kg_m2": [list(row) for row in mass.inertia],
                "size_mm": (mesh.vertices.max(axis=0) - mesh.vertices.min(axis=0)).tolist(),
            }
        )
    first = dict(bodies[0])
    if model.mechanism.root_radius:
        first["root_radius_mm"] = model.mechanism.root_radius
    if len(bodies) > 1:
        first["bodies"] = bodies
    return first


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
        return data | each
    # Nor have its touches a pressure where the roller's sharp end has none.
    whole = model.drive.force_data() if model.carrier.no_stress else model.drive.contact_data()
    return whole | data | model.drive.torque_data() | each


def force_data(model: Model) -> dict[str, Any]:
    """The largest force that presses the cam."""
    return {} if model.peak_force is None else {"peak_force_n": model.peak_force.value}


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
        if "cam" in model.lives:
            whole = model.lives["cam"]
            quoted = min(float(duty.cam_life.life_h) for duty in model.duties)
            data["cam_slice_life_h"] = finite(whole)
            data["cam_life_h"] = finite(whole if model.duty.meeting is not None else quoted)
    if model.duties and model.mechanism.classical:
        data["conventions"] = conventions(model)
    for table, roller in model.profile.rollers.items():
        if roller.designation is not None:
            data[f"{table.removesuffix('roller')}bearing_designation"] = roller.designation
    safety = least_safety(model.carriers)
    return data | bearing_data(model.bearing) | ({} if safety is None else {"bearing_static_safety": finite(safety)})


def together_data(model: Model) -> dict[str, Any]:
    """What several followers do together: the torque of the shaft, how near their rollers come, the cam's life."""
    data: dict[str, Any] = {"followers": len(model.bindings)}
    if model.camshaft is not None:
        data |= torque_data(model.camshaft.peak_torque, model.camshaft.work)
    if model.apart is not None:
        data |= {"least_apart_mm": model.apart.value, "least_apart_at_deg": degrees(model.apart.cam_angle) % 360.0}
    if "cam" in model.lives:
        data["cam_life_h"] = finite(model.lives["cam"])
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
    return data | {"states": [state_data(state, model.lives) for state in model.states]}


def _weight(state: Model) -> float:
    return 1.0 if state.state is None else state.state.weight


def state_data(model: Model, lives: Mapping[str, float]) -> dict[str, Any]:
    """An operating state: how long, how fast, how hard, and its share of the damage of every body.

    lives: over all states, h
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
        data["peak_travel_force_n"] = model.slide_drive.peak_groove.value
    elif model.shaft is not None:
        data["peak_torque_n_m"] = model.shaft.peak_torque.value * MILLI
    for body, hours in model.lives.items():
        data[f"{body}_life_h"] = finite(hours)
        whole = lives.get(body, inf)
        # Of a life of 0 every state that has none has all the damage.
        share = (1.0 if hours == 0.0 else 0.0) if whole == 0.0 else model.state.weight * whole / hours
        data[f"{body}_damage_share"] = share if isfinite(whole) else 0.0
    return data


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
    from camgeom.dynamics.impact.study import statistics, tighter_change

    if model.profile.duty:
        state = model.hardest_state
        return {"state": state.state.name if state.state else "", **impact_data(state)}
    spec, run, rotating = model.profile.impact_spec, model.impact, model.profile.rotating
    assert spec is not None
    assert run is not None
    data: dict[str, Any] = {
        "clearance": run.problem.pair.clearance_text,
        "conversions_deg": [degrees(hit.angle) for hit in run.conversions],
        "over_turns": statistics(run, spec.settle, "", tighter_change(run)).as_dict(rotating),
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


NO_ROOT = "stress in the body is found at the root of a closed groove under an [operation], in a body with a bore"


def body_data(model: Model) -> dict[str, Any]:
    """Nominal and peak stress at a groove's root. Raises DesignError where its volume is not meshed."""
    assert model.root_stress is not None
    return model.root_stress.data()


def cutter_data(model: Model) -> dict[str, Any]:
    """The tool's passes and what they leave. Raises DesignError where the tool cannot make the cam."""
    return model.machined.data()


def tolerance_data(model: Model) -> dict[str, Any]:
    """What the errors of [tolerance] do, each alone and all together."""
    from camgeom.tolerance.study import tolerance_data as told

    return told(model.tolerances)


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


def _unless(known: object, reason: str) -> str:
    return "" if known else reason


NO_OPERATION = "the profile has no [operation]"
Source = tuple[Callable[["Model"], dict[str, Any]], Callable[["Model"], str]]
SOURCES: dict[str, Source] = {
    "motion": (motion_data, lambda model: ""),
    "blank": (blank_data, lambda model: ""),
    "flank": (_flank, lambda model: ""),
    "solid": (solid_data, lambda model: ""),
    "contact": (contact_data, lambda model: _unless(model.profile.operation, NO_OPERATION)),
    "together": (together_data, lambda model: _unless(model.profile.operation, NO_OPERATION)),
    "fatigue": (fatigue_data, lambda model: _unless(model.profile.operation, NO_OPERATION)),
    "body": (body_data, lambda model: _unless(model.root_stress, NO_ROOT)),
    "dynamics": (dynamics_data, lambda model: _unless(model.profile.dynamics_spec, "the profile has no [dynamics]")),
    "impact": (impact_data, lambda model: _unless(model.profile.impact_spec, "the profile has no [impact]")),
    "cutter": (cutter_data, lambda model: _unless(model.profile.cutter, "the profile has no [cutter]")),
    "tolerance": (tolerance_data, lambda model: _unless(model.profile.tolerance, "the profile has no [tolerance]")),
}
"""How a section of the result is made, and why it does not apply to a model, empty where it does."""
