"""`camgeom laws`, `formats`, `new` and `schema`: tables and texts that need no model."""

from __future__ import annotations

import argparse
import json
from math import isfinite
from pathlib import Path
from typing import Any

from camgeom.cli import Console, UsageError
from camgeom.cli.text import aligned, format_lines
from camgeom.spelling import did_you_mean


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


def laws(arguments: argparse.Namespace, console: Console) -> int:
    """Print the motion laws."""
    rows = law_rows()
    if arguments.json:
        console.out(json.dumps(rows, indent=2, allow_nan=False))
        return 0
    head = ("law", "Vm", "Am", "Jm", "(VA)m", "Arms", "continuity", "parameters", "source")
    cells = [
        (
            row["name"],
            *("inf" if row[key] is None else f"{row[key]:.5f}" for key in ("vm", "am", "jm", "vam", "arms")),
            str(row["continuity"]),
            ", ".join(row["parameters"]) or "-",
            row["source"],
        )
        for row in rows
    ]
    for line in aligned([head, *cells], right=range(1, 7)):
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
        console.out(text.rstrip("\n"))
        return 0
    from camgeom.export.files import atomic_write

    with atomic_write(path) as stream:
        stream.write(text.encode())
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
    """Print the file formats."""
    for line in format_lines(arguments.json):
        console.out(line)
    return 0


def schema(arguments: argparse.Namespace, console: Console) -> int:
    """Print the JSON Schema of the profile."""
    from camgeom.profile.schema import schema as profile_schema

    del arguments
    console.out(json.dumps(profile_schema(), indent=2, allow_nan=False))
    return 0
