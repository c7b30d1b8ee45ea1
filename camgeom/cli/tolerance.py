"""`camgeom tolerance`: what every error does alone, what all of them do together, and the widest that hold a yield."""

from __future__ import annotations

import argparse
import json
from math import inf
from typing import Any

from camgeom.cli import Console, UsageError, aligned, number, number_in
from camgeom.errors import ProfileError
from camgeom.profile import Profile

FIGURES = {"dwell": "in the dwells", "motion": "anywhere in the turn", "backlash": "play in the dwells"}
LIMITS = {name: f"{name}_limit" for name in (*FIGURES, "preload", "pressure")}
MOST = 20_000_000


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Tell the study; returns 0, or 1 where fewer machines than wanted keep the limits."""
    from camgeom.model import Model
    from camgeom.profile import read
    from camgeom.tolerance.machine import whole_data

    model = Model(asked(read(arguments.profile), arguments))
    data = whole_data(model.machine_tolerances)
    kept = data.get("together", data)
    short = "yield" in kept and kept["yield"] < kept["wanted_yield"]
    if arguments.json:
        console.out(json.dumps(data, indent=2, allow_nan=False))
        return int(short)
    for line in summary(data):
        console.out(line)
    return int(short)


def asked(profile: Profile, arguments: argparse.Namespace) -> Profile:
    """The profile with what the options ask in place of its own. Raises UsageError where they mean nothing."""
    spec, change = profile.tolerance_spec, dict[str, Any]()
    if (samples := number_in(arguments.samples, "--samples", low=1000, high=MOST)) is not None:
        change["samples"] = int(samples)
    if (share := number_in(arguments.share, "--yield", low=1e-6, high=1.0 - 1e-9)) is not None:
        change["wanted_yield"] = share
    for text in arguments.limit or ():
        name, equals, value = text.partition("=")
        if name not in LIMITS or not equals:
            raise UsageError(f"--limit: needs NAME=VALUE with a name of {', '.join(LIMITS)} (found {text[:60]!r})")
        change[LIMITS[name]] = number_in(value, "--limit", low=1e-9, high=1e7)
    if not change:
        return profile
    if spec is None:
        raise UsageError("--samples, --yield, --limit: the profile has no [tolerance], so no machine can be drawn")
    changed = spec.model_copy(update=change)
    if found := list(changed.problems(profile.cam.mechanism(profile.setup()))):
        raise ProfileError(found, profile.source)
    return profile.model_copy(update={"tolerance": changed})


def summary(data: dict[str, Any]) -> list[str]:
    """The study in lines: of one follower, or of each of several and of what they keep together."""
    if "followers" not in data:
        return _told(data)
    lines = []
    for one in data["followers"]:
        lines += [f"follower {one['follower']}, track {one['track']}", *(f"  {line}" for line in _told(one))]
    if "wanted_yield" not in data["followers"][0]:
        return lines
    machine = data["together"]
    lines.append("all followers of a machine together: one body, a place and rollers of each")
    if "yield" in machine:
        share = f"{100.0 * machine['wanted_yield']:.6g} %"
        lines.append(f"  yield: {100.0 * machine['yield']:.5g} % keep every limit of every follower; wanted {share}")
    if machine.get("widest") is not None:
        lines += [f"  {line}" for line in _allowed(machine["widest"]["tolerances"], data["followers"][0]["errors"])]
    return [*lines, *(f"  {line}" for line in _limits(machine))]


def _told(data: dict[str, Any]) -> list[str]:
    """What is told of a follower."""
    unit = data["unit"]
    lines = ["each error alone, the largest over the turn", *_alone(data, unit)]
    if "preload_um" in data:
        lines.append(f"nominal, at its tightest in the dwells: {_normal(data['preload_um'])}")
    if "wanted_yield" not in data:
        return [*lines, "no [tolerance] in the profile: give its errors for worst case, yield and widest tolerances"]
    share = f"{100.0 * data['wanted_yield']:.6g} %"
    start = "the drawing" if data["reference"] == "absolute" else "where each stands in its first dwell"
    lines.append(f"all together, {data['samples']} machines, error of the follower's place from {start}, {unit}")
    table = [["", "median", f"{share} within", "worst case, from the drawing"]]
    for name, words in FIGURES.items():
        if f"{name}_{unit}" in data:
            table.append([words, *(number(data[f"{key}{name}_{unit}"], 4) for key in ("median_", "", "worst_"))])
    lines += [f"  {line}" for line in aligned(table, right=range(1, 4))]
    if "least_preload_um" in data:
        least = data["least_preload_um"]
        lines.append(f"{share} of them have at {'least' if least > 0.0 else 'most'} {_normal(least)} in their dwells")
    if "groove_end_um" in data:
        names = ("groove_end_um", "worst_groove_end_um", "groove_end_room_um")
        near, most, room = (number(data[name], 4) for name in names)
        lines.append(f"{share} of the rollers come at most {near} um nearer to the groove's end, worst case {most} um; "
                     f"its running clearance leaves {room} um")  # fmt: skip
    if "pressure_mpa" in data:
        lines.append(f"largest pressure: nominal {number(data['nominal_pressure_mpa'], 4)} MPa, {share} within "
                     f"{number(data['pressure_mpa'], 4)} MPa; by that alone they live "
                     f"{100.0 * data['life_share']:.3g} % as long")  # fmt: skip
    if "edge" in data:
        edge = data["edge"]
        what = "at most half a millimetre inside the sharp end that bears" if edge["unbounded"] else "at its largest"
        lines.append(f"the hardest roller, tilted by {edge['tilt_arcmin']:.3g}': "
                     f"{number(edge['tilted_pressure_mpa'], 4)} MPa {what}, level "
                     f"{number(edge['level_pressure_mpa'], 4)} MPa")  # fmt: skip
    if "yield" in data:
        whose = " of this follower" if "follower" in data else ""
        lines.append(f"yield: {100.0 * data['yield']:.5g} % keep every limit{whose}; wanted {share}")
    lines += _errors(data)
    lines += [] if "follower" in data else _limits(data)
    for row in data.get("wear", ()):
        lines.append(f"worn by {row['wear_um']:.3g} um, roller and flank together: {_normal(row['preload_um'])}, still "
                     f"preloaded {100.0 * row['still_preloaded']:.4g} % of the machines")  # fmt: skip
    return lines


def _alone(data: dict[str, Any], unit: str) -> list[str]:
    """What every error does alone, with the columns that mean something here."""
    rows = data["sensitivities"]
    columns = {
        "error": [row["error"] for row in rows],
        "size": [f"{row['size']:g} {row['size_unit']}" for row in rows],
        f"motion {unit}": [number(row[f"motion_{unit}"], 4) for row in rows],
        "um": [number(row["motion_um"], 4) for row in rows] if unit != "um" else None,
        "at deg": ["-" if row["cam_angle_deg"] is None else f"{row['cam_angle_deg']:.1f}" for row in rows],
        f"play {unit}": [_signed(row[f"play_{unit}"]) for row in rows] if "preload_um" in data else None,
        "preload um": [_signed(row["preload_loss_um"], -1.0) for row in rows] if "preload_um" in data else None,
        "pressure": [f"x {row['pressure_ratio']:.3g}" for row in rows] if data["pressed"] else None,
    }  # fmt: skip
    shown = {head: cells for head, cells in columns.items() if cells is not None}
    table = aligned([tuple(shown), *zip(*shown.values())], right=range(2, len(shown)))
    lines = [f"  {line}" for line in table]
    if unit != "um":
        lines.append("  um: at the follower's reference point")
    return lines if data["pressed"] else [*lines, "  pressures are told of line contacts under an [operation] alone"]


def _normal(preload: float) -> str:
    """An interference along the normals, um; below zero half the gap between two walls."""
    if preload > 0.0:
        return f"{number(preload, 4)} um of preload along the normals"
    if preload == -inf:
        return "one wall alone: the other has run out"
    return f"{number(-2.0 * preload, 4)} um of play between the walls" if preload else "walls that just touch"


def _allowed(widest: dict[str, float | None], errors: dict[str, Any]) -> list[str]:
    """The errors given, and how wide each may be for all followers together."""
    rows = [["error", "given", "widest"]]
    for key, wide in widest.items():
        rows.append([key, _tolerance(errors[key], errors[key]["value"]),
                     "any" if wide is None else _tolerance(errors[key], wide)])  # fmt: skip
    return aligned(rows)


def _errors(data: dict[str, Any]) -> list[str]:
    """The errors given, what part of the variance in the dwells each explains alone, and how wide it may be."""
    found = data.get("widest")
    rows = [["error", "given", "part", "widest"]]
    for key, part in data["contributions"].items():
        error = data["errors"][key]
        wide = None if found is None else found["tolerances"][key]
        allowed = "any" if wide is None else _tolerance(error, wide)
        rows.append([key, _tolerance(error, error["value"]), _part(part), allowed])
    rows.append(["acting together", "", _part(data["contributions_together"]), ""])
    lines = ["errors given, and the part of the variance in the dwells that each explains alone"]
    return [*lines, *(f"  {line}" for line in aligned([row[: 4 if found else 3] for row in rows], right=(2,)))]


def _limits(data: dict[str, Any]) -> list[str]:
    """How the widest tolerances hold the limits, or why there are none."""
    found = data.get("widest")
    if found is not None:
        kept = f"{100.0 * found['yield']:.4g} % of the machines"
        return [f"widest tolerances: they hold the limits in {kept} at the least cost"]
    if "widest_reason" in data:
        return [f"widest tolerances: {data['widest_reason']}"]
    if "widest" in data:
        why = "none hold the limits; what is left without errors breaks them, or no error reaches them"
        return [f"widest tolerances: {why}"]
    return ["no limit is given: --limit dwell=VALUE, or tolerance.dwell_limit, tells the widest tolerances"]


def _tolerance(error: dict[str, Any], value: float) -> str:
    about = f"{error['mean']:.3g} " if error["mean"] else ""
    return f"{about}+- {value:.3g} {error['unit']}"


def _part(share: float) -> str:
    return f"{100.0 * share:.1f} %" if share >= 0.0005 else "0"


def _signed(value: float, sign: float = 1.0) -> str:
    """A growth or a loss."""
    return f"{sign * value:+.3g}" if value else "0"
