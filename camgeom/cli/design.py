"""`camgeom design`: of a globoidal drive a profile from what the drive has to do, with the reason of every choice."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from math import isfinite
from pathlib import Path

from camgeom.cli import Console, UsageError
from camgeom.cli import design_planar as cli_design_planar
from camgeom.cli.text import aligned

KINDS = ("globoidal",)


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Design, print the reasons and write the profile; returns the exit status."""
    from camgeom.design.brief import Wanted
    from camgeom.design.globoidal import design
    from camgeom.export.files import atomic_write

    if arguments.kind in cli_design_planar.KINDS:
        limits = {key: _number(arguments, key, None) for key in ("pressure_angle", "convex_radius", "contact_pressure")}
        return cli_design_planar.run(arguments, limits, console)
    if arguments.kind not in KINDS:
        known = ", ".join((*KINDS, *cli_design_planar.KINDS))
        raise UsageError(f"design: unknown kind {arguments.kind[:60]!r}; known: {known}")
    ratio, angle = _number(arguments, "ratio", None), _number(arguments, "motion_angle", None)
    if (ratio is None) == (angle is None):
        raise UsageError("give either --motion-angle or --ratio (time of motion over time of dwell)")
    if ratio is not None and ratio <= 0.0:
        raise UsageError(f"--ratio: needs a positive number (found {ratio:g})")
    stops = _number(arguments, "stops", None)
    if stops is None or stops != int(stops):
        raise UsageError("--stops: needs a whole number from 2 to 48")
    wanted = Wanted(
        int(stops),
        float(angle or 0.0) if ratio is None else 360.0 * ratio / (1.0 + ratio),
        _number(arguments, "speed", 60.0) or 0.0,
        _number(arguments, "inertia", 0.1) or 0.0,
        _number(arguments, "torque", 0.0) or 0.0,
        _number(arguments, "life", 20000.0) or 0.0,
        _number(arguments, "center_distance", None),
        _number(arguments, "envelope", None),
        arguments.name or f"globoidal indexer {int(stops)} stops",
    )
    found = design(wanted)
    if arguments.file:
        with atomic_write(Path(arguments.file)) as file:
            file.write(found.text.encode())
    if arguments.json:
        data = {
            "choices": [asdict(choice) for choice in found.choices],
            "checks": [finding.as_dict() for finding in found.findings],
            "profile": found.text,
        }
        console.out(json.dumps(data, indent=2, allow_nan=False, ensure_ascii=False))
        return 0
    for line in aligned([(c.what, c.value, c.why) for c in found.choices]):
        console.out(line)
    console.out(f"{len(found.findings)} checks pass")
    console.out(f"wrote {arguments.file}" if arguments.file else f"\n{found.text}")
    return 0


def _number(arguments: argparse.Namespace, key: str, default: float | None) -> float | None:
    """The number given for an option. Raises UsageError where it is none."""
    text = getattr(arguments, key)
    if text is None:
        return default
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not isfinite(value):
        raise UsageError(f"--{key.replace('_', '-')}: needs a number (found {text[:60]!r})")
    return value
