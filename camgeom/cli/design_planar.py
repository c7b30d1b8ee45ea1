"""`camgeom design disc`: the smallest planar cam that keeps its limits, for the motion and follower of a profile."""

from __future__ import annotations

import argparse
import json
import re
from dataclasses import dataclass
from math import ceil, radians
from pathlib import Path
from typing import TYPE_CHECKING

from camgeom.cli import Console, UsageError
from camgeom.cli.text import aligned
from camgeom.errors import Problem, ProfileError

if TYPE_CHECKING:
    from camgeom.design.planar import Wanted
    from camgeom.profile import Profile

KINDS = ("disc", "conjugate", "constant-width")
MOST_BYTES = 4_000_000
STEP = 0.01
"""mm; the radius is rounded up to this"""


@dataclass(frozen=True)
class Choice:
    """A key of the profile, its value and the reason."""

    key: str
    value: float
    why: str


def run(arguments: argparse.Namespace, limits: dict[str, float | None], console: Console) -> int:
    """Design, print the reasons and write the profile; limits by option (deg, mm, MPa). Returns the exit status."""
    from camgeom.checks import findings
    from camgeom.export.files import atomic_write
    from camgeom.model import Model
    from camgeom.profile import parse

    text, source = _starting(arguments)
    profile = parse(text, source)
    if profile.kind != arguments.kind:
        raise ProfileError([Problem("cam.kind", "is not the kind to design", profile.kind, arguments.kind)], source)
    choices, text = chosen(profile, text, limits, bool(arguments.best_offset))
    found = findings(Model(parse(text, source)), _light())
    if arguments.file:
        with atomic_write(Path(arguments.file)) as file:
            file.write(text.encode())
    if arguments.json:
        data = {
            "choices": [{"what": c.key, "value": c.value, "why": c.why} for c in choices],
            "checks": [finding.as_dict() for finding in found],
            "profile": text,
        }
        console.out(json.dumps(data, indent=2, allow_nan=False, ensure_ascii=False))
        return 0
    for line in aligned([(c.key, f"{c.value:g} mm", c.why) for c in choices]):
        console.out(line)
    failed = sorted({finding.check for finding in found if not finding.passed})
    console.out(f"{len(found) - len(failed)} checks pass" + (f"; look at {', '.join(failed)}" if failed else ""))
    console.out(f"wrote {arguments.file}" if arguments.file else f"\n{text}")
    return 0


def chosen(
    profile: Profile, text: str, limits: dict[str, float | None], best: bool
) -> tuple[tuple[Choice, ...], str]:
    """The choices, and the profile's text with them. Raises DesignError where no radius keeps the limits."""
    from camgeom.design.planar import margins, smallest_base_radius

    wanted = _wanted(profile, limits)
    choices = []
    if best:
        offset = _offset(profile, wanted)
        text = with_key(text, "follower", "offset", offset)
        profile = _reread(profile, text)
        choices.append(Choice("follower.offset", offset, "gives the smallest prime radius for the pressure angle"))
    radius = ceil(smallest_base_radius(profile, wanted) / STEP) * STEP
    kept = margins(profile, radius, wanted)
    tight = min(kept, key=lambda name: kept[name]) if kept else ""
    asked = [
        f"pressure angle {wanted.pressure_angle_deg:g} deg" if wanted.pressure_angle_deg is not None else "",
        f"convex radius {wanted.convex_radius_mm:g} mm",
        f"contact pressure {wanted.contact_pressure_mpa:g} MPa" if wanted.contact_pressure_mpa is not None else "",
    ]
    why = f"the smallest for {', '.join(filter(None, asked))}; {tight} decides" if tight else "nothing limits it"
    choices.append(Choice("cam.base_radius", round(radius, 6), why))
    return tuple(choices), with_key(text, "cam", "base_radius", round(radius, 6))


def _wanted(profile: Profile, limits: dict[str, float | None]) -> Wanted:
    """The limits given, else those of the profile."""
    from camgeom.design.planar import Wanted

    own = profile.limits.for_follower(profile.follower)
    angle, pressure = limits["pressure_angle"], limits["contact_pressure"]
    pressure = own.contact_pressure_mpa if pressure is None else pressure
    if pressure is not None and profile.operation is None:
        raise UsageError("--contact-pressure: the profile has no [operation] to compute it from")
    return Wanted(own.pressure_angle_deg if angle is None else angle, limits["convex_radius"] or 0.0, pressure)


def _offset(profile: Profile, wanted: Wanted) -> float:
    """The best offset of a translating roller follower, mm, to a hundredth."""
    from camgeom.design.planar import best_offset
    from camgeom.track.follower import TranslatingFollower

    follower, cam = profile.follower, profile.cam
    simple = isinstance(follower, TranslatingFollower) and follower.face == "roller" and profile.kind == "disc"
    if not simple or wanted.pressure_angle_deg is None:
        raise UsageError("--best-offset: only a roller on a slide has an offset to choose")
    sense = float(getattr(cam, "sense", 1.0))
    return round(best_offset(profile.setup().program, radians(wanted.pressure_angle_deg), sense) / STEP) * STEP


def _starting(arguments: argparse.Namespace) -> tuple[str, str]:
    """The text to start from and its name: the profile given, or the kind's starter."""
    from camgeom.cams import starter
    from camgeom.profile.text import decode, read_bytes

    if arguments.profile is None:
        return starter(arguments.kind), ""
    path = str(arguments.profile)
    return decode(read_bytes(Path(path), MOST_BYTES, path), path), path


def _reread(profile: Profile, text: str) -> Profile:
    from camgeom.profile import parse

    return parse(text, profile.source)


def _light() -> tuple[str, ...]:
    """The checks that need no solid."""
    from camgeom.checks import checks

    return tuple(name for name, one in checks().items() if "solid" not in one.needs)


def with_key(text: str, table: str, key: str, value: float) -> str:
    """The TOML text with one number of a table replaced or added; everything else, comments too, stays as it is."""
    lines = text.splitlines()
    heads = [i for i, line in enumerate(lines) if line.lstrip().startswith("[")]
    first = next((i for i in heads if re.match(rf"\s*\[\s*{re.escape(table)}\s*\]", lines[i])), None)
    if first is None:
        return "\n".join([*lines, "", f"[{table}]", f"{key} = {value:.12g}", ""])
    last = next((i for i in heads if i > first), len(lines))
    for i in range(first + 1, last):
        found = re.match(rf"(\s*{re.escape(key)}\s*=\s*)[^#\s]+(.*)$", lines[i])
        if found:
            lines[i] = f"{found[1]}{value:.12g}{found[2]}"
            break
    else:
        lines.insert(first + 1, f"{key} = {value:.12g}")
    return "\n".join(lines) + "\n"
