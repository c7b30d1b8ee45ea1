"""`camgeom laws`, `materials`, `rollers`, `formats`, `new` and `schema`, which need no model."""

from __future__ import annotations

import argparse
import json
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camgeom.cli import Console, UsageError, aligned, number
from camgeom.errors import did_you_mean

if TYPE_CHECKING:
    from camgeom.motion.law import LawEntry


def law_rows() -> list[dict[str, Any]]:
    """The laws with their characteristic values as plain data; None where a value is infinite (an impulse)."""
    from camgeom.motion import LAWS

    rows = []
    for name, entry in sorted(LAWS.items()):
        claims = entry.claims
        values = {key: getattr(claims, key) for key in ("vm", "am", "jm", "vam", "arms")}
        rows.append(
            {
                "name": name,
                **{key: value if isfinite(value) else None for key, value in values.items()},
                "torque_rate": _torque_rate(entry),
                "continuity": claims.order,
                "summary": entry.summary,
                "source": entry.source,
                "parameters": {
                    key: {"default": p.default, "allowed": p.allowed, "meaning": p.help}
                    for key, p in entry.parameters.items()
                },
            }
        )
    return rows


def _torque_rate(entry: LawEntry) -> float | None:
    """Peak rate of the torque of a pure inertia; None where it is infinite, or a law is sought for its own wish."""
    rate = inf if entry.stand_in else entry.make({}).torque_rate()
    return rate if isfinite(rate) else None


def laws(arguments: argparse.Namespace, console: Console) -> int:
    """Print the motion laws."""
    rows = law_rows()
    if arguments.json:
        console.out(json.dumps(rows, indent=2, allow_nan=False))
        return 0
    head = ("law", "Vm", "Am", "Jm", "(VA)m", "Arms", "(VA)'m", "continuity", "parameters", "source")
    cells = [
        (
            row["name"],
            *("inf" if row[key] is None else f"{row[key]:.5f}" for key in ("vm", "am", "jm", "vam", "arms")),
            number(row["torque_rate"]),
            str(row["continuity"]),
            ", ".join(row["parameters"]) or "-",
            row["source"],
        )
        for row in rows
    ]
    for line in aligned([head, *cells], right=range(1, 8)):
        console.out(line)
    return 0


def new(arguments: argparse.Namespace, console: Console) -> int:
    """Print a starter profile, or write it to a file that must not exist."""
    from camgeom.cams import kinds, starter

    kind = arguments.kind.lower().replace("_", "-")
    if kind not in kinds():
        hint = did_you_mean(kind, kinds())
        raise UsageError(f"unknown cam kind {arguments.kind[:60]!r}; known: {', '.join(kinds())}{hint and '; ' + hint}")
    path = None if arguments.file is None else _free(arguments.file)
    text = starter(kind)
    if path is None:
        console.toml(text.rstrip("\n"))
        return 0
    from camgeom.export.files import write_whole

    write_whole(path, text)
    console.out(f"wrote {path}")
    return 0


def _free(name: str) -> Path:
    """The path of a file that does not exist yet. Raises UsageError where one is there."""
    path = Path(name)
    try:
        taken = path.exists() or path.is_symlink()
    except (OSError, ValueError):
        taken = True
    if taken or not name.strip():
        raise UsageError(f"{name[:200]!r} exists already, or is no file name; nothing was written")
    return path


def formats(arguments: argparse.Namespace, console: Console) -> int:
    """Print the file formats with the cams each is for and what it is."""
    from camgeom.report.files import format_rows

    rows = format_rows()
    if arguments.json:
        console.out(json.dumps(rows, indent=2))
        return 0
    cells = [(row["format"], row["cams"], row["about"]) for row in rows]
    for line in aligned([("format", "for", "what it is"), *cells]):
        console.out(line)
    return 0


def rollers(arguments: argparse.Namespace, console: Console) -> int:
    """Print the track rollers of the catalogue, or of a file of the user's own with it."""
    from camgeom.profile.catalogue import read, shipped

    catalogues = [shipped()]
    if arguments.file is not None:
        catalogues.insert(0, read(Path(arguments.file), arguments.file))
    rows = [{**dict(one), "source": catalogue.source_of(one)} for catalogue in catalogues for one in catalogue.follower]
    if arguments.json:
        console.out(json.dumps(rows, indent=2, allow_nan=False))
        return 0
    columns = (("designation", "designation"), ("type", "type"), ("diameter", "D mm"), ("bore", "d mm"),
               ("width", "B mm"), ("dynamic_rating", "C N"), ("static_rating", "C0 N"),
               ("max_radial_load", "Fr max N"), ("max_static_load", "F0r max N"),
               ("limiting_speed", "r/min"))  # fmt: skip
    cells = [tuple(number(row[key]) for key, _ in columns) for row in rows]
    for line in aligned([tuple(head for _, head in columns), *cells], right=range(2, len(columns))):
        console.out(line)
    for source in dict.fromkeys(row["source"] for row in rows if row["source"]):
        console.out(f"source: {source}")
    return 0


def schema(arguments: argparse.Namespace, console: Console) -> int:
    """Print the JSON Schema of the profile, or of the result."""
    if arguments.result:
        from camgeom.report.result_schema import schema as made
    else:
        from camgeom.profile.schema import schema as made
    console.out(json.dumps(made(), indent=2, allow_nan=False))
    return 0


def materials(arguments: argparse.Namespace, console: Console) -> int:
    """Print the grades that material.cam.grade and material.roller.grade may name; returns 0."""
    from camgeom.mechanics.grades import SOURCE, grades

    every = grades().values()
    if arguments.json:
        rows = [{**one.model_dump(), "contact_limit": one.limit, "source": f"{SOURCE}, {one.place}"} for one in every]
        console.out(json.dumps({"materials": rows}, indent=2, allow_nan=False, ensure_ascii=False))
        return 0
    table = [("grade", "for", "treatment", "HRC", "limit, MPa", "place")]
    for one in every:
        hard = "-" if one.hardness is None else f"{one.hardness[0]:g} to {one.hardness[1]:g}"
        limit = "by hardness" if one.limit is None else f"{one.limit:g}"
        table.append((one.name, ", ".join(one.of), one.treatment, hard, limit, one.place))
    for line in aligned(table):
        console.out(line)
    console.out(f"from {SOURCE}; the limit, at 1e7 cycles, is what the least hardness bears")
    return 0
