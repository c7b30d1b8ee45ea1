"""Motion, flank, blank and solid of a cam as plain data for result.json."""

from __future__ import annotations

from math import degrees, isfinite, pi
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from camgeom.model import Model
    from camgeom.motion.optimal.best import Best
    from camgeom.track.planar import Planar


def flank_data(model: Model) -> dict[str, Any]:
    """Pressure angle, curvature and undercut of every flank, of rollers and faces, and the play of a pair."""
    data = _surveyed(model) if model.tracks else {}
    if model.profiles is not None:
        data |= _planar(model.profiles)
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
    if model.tables:
        data[f"table_distance_{name}"] = max(one.largest[0] for one in model.tables)
        data["tables"] = [
            {"segment": one.segment, f"largest_{name}": one.largest[0], "at_deg": degrees(one.largest[1]),
             f"rms_{name}": one.rms, "rows": len(one.distance), "stretch": one.stretch, f"shift_{name}": one.shift}
            for one in model.tables
        ]  # fmt: skip
    if program.best_laws:
        stated = len(model.profile.motion)
        data["best_laws"] = {
            str(i): {**_best_law(found), "over": program.best_over} for i, found in program.best_laws if i < stated
        }
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
        "most_gain": found.most_gain,
        "bound_holds_for": found.holds_for,
        **peaks,
    }


def _stroke(model: Model) -> float:
    lifts = [lift for span in model.setup.program.spans for lift in (span.before, span.after)]
    return max(lifts) - min(lifts)


def _surveyed(model: Model) -> dict[str, Any]:
    """Extremes over all tracks and flanks."""
    surveys = model.flanks
    sharp = max((s.largest_relative_curvature for s in surveys), key=lambda e: e.value)
    margin = min((s.margin for s in surveys), key=lambda e: e.value)
    # Where the roller folds its flank the radius goes through 0.
    sound = min(s.relative_curvature.value for s in surveys) > 0.0
    return {
        **_angles(model),
        "min_relative_radius_mm": 1.0 / sharp.value if sound else 0.0,
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
    # On a roller parallel to the cam's axis that place is a height and no radius, and its pressure angle the largest.
    if radius is None or model.planar is not None or all(track.upright for track in model.tracks):
        return {}
    at = max((s.pressure_angle_at(radius) for s in model.flanks), key=lambda e: e.value)
    # A roller may stand in the cam with less than half of its length.
    drum = model.mechanism.drum
    # Of a cone the place has another radius at every lift: it is told by its depth.
    where = {"pitch_depth_mm": drum.radius - radius} if drum is not None and drum.slope else {"pitch_radius_mm": radius}
    return where | ({"pitch_pressure_angle_deg": degrees(at.value)} if at.value >= 0.0 else {})


def blank_data(model: Model) -> dict[str, Any]:
    """The cylinder about the axis that just holds the finished cam: what it is turned from; of a plate its sizes."""
    if model.mechanism.box is not None:
        length, width, thickness = model.mechanism.box
        return {"plate_length_mm": length, "plate_width_mm": width, "plate_thickness_mm": thickness,
                "volume_mm3": length * width * thickness}  # fmt: skip
    diameter, length = model.envelope
    whole = {"diameter_mm": diameter, "length_mm": length, "volume_mm3": 0.25 * pi * diameter**2 * length}
    plate, mass = model.mechanism.frame, model.frame_mass
    if plate is not None and mass is not None:
        whole |= {"frame_length_mm": plate.length, "frame_width_mm": plate.width, "frame_thickness_mm": plate.thickness,
                  "frame_opening_mm": plate.opening, "frame_mass_kg": mass}  # fmt: skip
    return whole | model.mechanism.named


def solid_data(model: Model) -> dict[str, Any]:
    """The body (for several, sums and the list of them)."""
    from camgeom.maths.mesh import mass_properties
    from camgeom.model.body import MassProperties

    made, bodies = model.workpieces, []
    beside = (MassProperties(*mass_properties(solid.mesh, density)) for solid, density in made[len(model.mass) :])
    for (solid, _), mass in zip(made, (*model.mass, *beside)):
        mesh = solid.mesh
        bodies.append(
            {
                "name": solid.name,
                "watertight": mesh.watertight,
                "volume_mm3": mass.volume,
                "area_mm2": mesh.area,
                "triangles": len(mesh.faces),
                "chord_error_mm": solid.chord_error,
                **({} if solid.free_error is None else {"free_chord_error_mm": solid.free_error}),
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
