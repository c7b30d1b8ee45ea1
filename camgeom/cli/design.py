"""`camgeom design`: a checked profile from what the cam has to do, with the reason of every choice."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from camgeom.cli import Console, UsageError, aligned, number_in

if TYPE_CHECKING:
    from camgeom.design import Design

PLANAR = ("disc", "conjugate", "constant-width")
"""kinds whose smallest base radius is sought, for the motion and follower of a profile"""
KINDS = ("globoidal", *PLANAR, "end-face")
OPTIONS: dict[str, tuple[str, ...]] = {
    "globoidal": (
        "stops", "motion_angle", "ratio", "center_distance", "envelope", "speed", "inertia", "torque", "life", "name",
        "pressure_angle", "contact_pressure", "law", "accurate_dwell",
    ),
    "end-face": ("profile", "pressure_angle", "contact_pressure"),
    **dict.fromkeys(PLANAR, ("profile", "pressure_angle", "convex_radius", "contact_pressure", "best_offset")),
}  # fmt: skip
"""the options that a kind's design asks; the others are refused"""
LEAST_RATIO = 0.01
"""time of motion over time of dwell, and the other way round"""
MOST_BYTES = 4_000_000


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Design, print the reasons and write the profile; returns the exit status."""
    from camgeom.export.files import write_whole

    if arguments.kind not in KINDS:
        raise UsageError(f"design: unknown kind {arguments.kind[:60]!r}; known: {', '.join(KINDS)}")
    _refuse_idle(arguments)
    made = _globoidal(arguments) if arguments.kind == "globoidal" else _smallest(arguments)
    if arguments.file:
        write_whole(Path(arguments.file), made.text)
    status = int(any(finding.level == "fail" for finding in made.findings))
    if arguments.json:
        data = {
            "choices": [asdict(choice) for choice in made.choices],
            "checks": [finding.as_dict() for finding in made.findings],
            "profile": made.text,
        }
        console.out(json.dumps(data, indent=2, allow_nan=False))
        return status
    shown = [(c.what, c.value if isinstance(c.value, str) else f"{c.value:g} mm", c.why) for c in made.choices]
    # Without a file the profile alone stands on stdout, so that `> file` makes one.
    tell = console.out if arguments.file else console.err
    for line in aligned(shown):
        tell(line)
    tell(f"{sum(finding.level == 'pass' for finding in made.findings)} findings pass")
    for level, word in (("warn", "warned of"), ("fail", "FAILS")):
        if found := dict.fromkeys(finding.check for finding in made.findings if finding.level == level):
            tell(f"{word}: {', '.join(found)}; `camgeom check` tells what and where")
    if arguments.file:
        console.out(f"wrote {arguments.file}")
    else:
        console.toml(made.text.rstrip("\n"))
    return status


def _refuse_idle(arguments: argparse.Namespace) -> None:
    """UsageError for every option given that this kind's design does not ask."""
    known = dict.fromkeys(key for keys in OPTIONS.values() for key in keys)
    given = [key for key in known if getattr(arguments, key) not in (None, False)]
    idle = [_flag(key) for key in given if key not in OPTIONS[arguments.kind]]
    if idle:
        has = ", ".join(_flag(key) for key in OPTIONS[arguments.kind])
        raise UsageError(f"{', '.join(idle)}: nothing in the design of a {arguments.kind} cam hangs on it; it has "
                         f"{has}")


def _flag(key: str) -> str:
    return f"--{key.replace('_', '-')}"


def _smallest(arguments: argparse.Namespace) -> Design:
    """The smallest cam for the profile given, or for the kind's starter."""
    from camgeom.cams import starter
    from camgeom.design.planar import design
    from camgeom.reading import decode, read_bytes

    limits = {key: _number(arguments, key) for key in ("pressure_angle", "convex_radius", "contact_pressure")}
    source: str | None = arguments.profile
    text = starter(arguments.kind) if source is None else decode(read_bytes(Path(source), MOST_BYTES, source), source)
    return design(text, source or "", arguments.kind, limits, arguments.best_offset)


def _globoidal(arguments: argparse.Namespace) -> Design:
    """The globoidal drive for a requirement."""
    from camgeom.design.globoidal import Wanted, design

    ratio, angle = _number(arguments, "ratio"), _number(arguments, "motion_angle")
    if (ratio is None) == (angle is None):
        raise UsageError("give either --motion-angle or --ratio (time of motion over time of dwell)")
    if ratio is not None and not LEAST_RATIO <= ratio <= 1.0 / LEAST_RATIO:
        range_ = f"{LEAST_RATIO:g} to {1.0 / LEAST_RATIO:g}"
        raise UsageError(f"--ratio: needs time of motion over time of dwell (found {ratio:g}); allowed: {range_}")
    stops = _number(arguments, "stops")
    if stops is None or stops != int(stops):
        raise UsageError("--stops: needs a whole number from 1 to 48")
    if arguments.name is not None and not (arguments.name.isprintable() and 1 <= len(arguments.name.strip()) <= 120):
        raise UsageError("--name: needs 1 to 120 characters that can be shown")
    wanted = Wanted(
        int(stops),
        float(angle or 0.0) if ratio is None else 360.0 * ratio / (1.0 + ratio),
        _number(arguments, "speed", 60.0) or 0.0,
        _number(arguments, "inertia", 0.1) or 0.0,
        _number(arguments, "torque", 0.0) or 0.0,
        _number(arguments, "life", 20000.0) or 0.0,
        _number(arguments, "center_distance"),
        _number(arguments, "envelope"),
        arguments.name or f"globoidal indexer {int(stops)} stops",
        _number(arguments, "pressure_angle", 50.0) or 0.0,
        _number(arguments, "contact_pressure"),
        arguments.law,
        arguments.accurate_dwell,
    )
    return design(wanted)


def _number(arguments: argparse.Namespace, key: str, default: float | None = None) -> float | None:
    """The number given for an option. Raises UsageError where it is none."""
    value = number_in(getattr(arguments, key), _flag(key))
    return default if value is None else value
