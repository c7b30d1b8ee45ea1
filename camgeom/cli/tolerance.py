"""`camgeom tolerance`: what every error does alone, what all of them do together, and the widest that hold a yield."""

from __future__ import annotations

import argparse
import json
from typing import Any

from camgeom.cli import Console, UsageError
from camgeom.cli.tables import aligned, number, number_in
from camgeom.errors import ProfileError
from camgeom.profile import Profile

FIGURES = ("dwell", "motion", "backlash")
LIMITS = {name: f"{name}_limit" for name in (*FIGURES, "preload", "pressure")}
MOST = 20_000_000


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Tell the study; returns 0, or 1 where fewer machines than wanted keep the limits."""
    from camgeom.model import Model
    from camgeom.profile import read
    from camgeom.tolerance.study import tolerance_data

    model = Model(asked(read(arguments.profile), arguments))
    data = tolerance_data(model.tolerances, with_widest=True)
    short = "yield" in data and data["yield"] < data["wanted_yield"]
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
    """The study in lines."""
    unit = data["unit"]
    lines = [f"each error alone: largest motion of the follower over the turn, {unit}"]
    heads = ("error", "of", "", "motion", "um", "at deg", "play", "preload um", "pressure")
    rows = [
        (row["error"], f"{row['size']:g}", row["size_unit"], number(row[f"motion_{unit}"], 4),
         number(row["motion_um"], 4), f"{row['cam_angle_deg']:.1f}", _cell(row[f"play_{unit}"]),
         _cell(row["preload_loss_um"], -1.0), _cell(row["pressure_ratio"], form="x {:.3g}"))
        for row in data["sensitivities"]
    ]  # fmt: skip
    lines += [f"  {line}" for line in aligned([heads, *rows], right=range(3, 9))]
    if "preload_um" in data:
        lines.append(f"preload: {data['preload_um']:.4g} um along the normals, nominal, at its least in the dwells")
    if "wanted_yield" not in data:
        return [*lines, "no [tolerance] in the profile: give its errors for worst case, yield and widest tolerances"]
    share = 100.0 * data["wanted_yield"]
    lines.append(f"all together, {data['samples']} machines, from {data['reference'].replace('-', ' ')}, {unit}")
    table = [["", "median", f"{share:.6g} % within", "worst case, from the drawing"]]
    for name in FIGURES:
        if f"{name}_{unit}" in data:
            table.append([name, *(number(data[f"{key}{name}_{unit}"], 4) for key in ("median_", "", "worst_"))])
    lines += [f"  {line}" for line in aligned(table, right=range(1, 4))]
    if "least_preload_um" in data:
        lines.append(f"preload that {share:.6g} % keep at least: {data['least_preload_um']:.4g} um (negative: play)")
    if "pressure_mpa" in data:
        lines.append(f"largest pressure: nominal {data['nominal_pressure_mpa']:.4g} MPa, {share:.6g} % within "
                     f"{data['pressure_mpa']:.4g} MPa; by that alone they live {100.0 * data['life_share']:.3g} % as "
                     "long")  # fmt: skip
    if "edge" in data:
        edge = data["edge"]
        what = "half a millimetre inside the sharp end that bears" if edge["unbounded"] else "at its largest"
        lines.append(f"the hardest roller, tilted by {edge['tilt_arcmin']:.3g}': {edge['tilted_pressure_mpa']:.4g} MPa "
                     f"{what}, level {edge['level_pressure_mpa']:.4g} MPa")  # fmt: skip
    if "yield" in data:
        lines.append(f"yield: {100.0 * data['yield']:.5g} % keep every limit; wanted {share:.6g} %")
    parts = [(key, f"{100.0 * part:.1f} %") for key, part in data["contributions"].items() if part >= 0.0005]
    lines += ["part of the variance in the dwells", *(f"  {line}" for line in aligned(parts, right=(1,)))]
    for row in data.get("wear", ()):
        lines.append(f"worn by {row['wear_um']:.3g} um: preload {row['preload_um']:.3g} um, still preloaded "
                     f"{100.0 * row['still_preloaded']:.4g} % of the machines")  # fmt: skip
    return [*lines, *_widest(data)]


def _widest(data: dict[str, Any]) -> list[str]:
    if "widest" not in data:
        return ["no limit is given: --limit dwell=VALUE, or tolerance.dwell_limit, tells the widest tolerances"]
    found = data["widest"]
    if found is None:
        return ["widest tolerances: none hold the limits; what is left without errors breaks them, or nothing does"]
    rows = [(key, "no part in it" if value is None else f"+- {value:.3g}") for key, value in
            found["tolerances"].items()]  # fmt: skip
    head = f"widest tolerances that hold the limits in {100.0 * found['yield']:.4g} % of the machines"
    return [head, *(f"  {line}" for line in aligned(rows))]


def _cell(value: float | None, sign: float = 1.0, form: str = "{:+.3g}") -> str:
    """A figure of the table; a dash where there is none."""
    return "-" if value is None else form.format(sign * value + 0.0)
